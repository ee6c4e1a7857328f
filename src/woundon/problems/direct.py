"""A hardening roll as a contact sees it: the linear cylinder's response and what the roll adds."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from ..contact.response import Displace, Gradients, Response
from ..elasticity import cylinder
from ..elasticity.hardening import HardeningLaw
from ..elasticity.hardening_ring import Equilibrium, HardeningRing, NoEquilibrium
from ..elasticity.ring_elements import Fineness
from ..errors import NotConverged

if TYPE_CHECKING:
    from ..contact.response import ContactGrid, Tractions
    from .wound_roll import WoundRoll

__all__ = ["respond", "ring"]

Array = np.ndarray

FEWEST = 8  # columns of elements under the contact
MANY = 64  # cells of a contact; from there on columns grow more slowly


def respond(
    ring: HardeningRing, limit: float, grid: ContactGrid, a: float, about: Tractions | None
) -> Response:
    """Return the response of a ring linearised about tractions.

    Parameters
    ----------
    ring : HardeningRing
    limit : float
        Pressure beyond which the stack is not admissible [Pa].
    grid, a, about
        As :meth:`~woundon.problems.bodies.Body.respond` has them.
    """
    kernels = cylinder.surface_kernels(ring.radius, ring.core_radius, *ring.stiffness)
    linear = grid.integrated(kernels, 1 / ring.radius, ring.radius, a)
    nodes, n = grid.nodes, grid.columns.size
    p, q = (np.zeros(n), np.zeros(n)) if about is None else about
    p = np.maximum(p, 0.0)  # a trial state may pull, and tear the stack
    own = slice(None) if nodes.size == n else slice(1, -1)
    try:
        found = ring.about(fineness(nodes), a, a * nodes, own, p, q)
    except NoEquilibrium as stop:
        text = f"{stop}; more pressure wound in, a lower load or a smaller shear_exponent may do"
        raise NotConverged(text) from None
    by_p, by_q, rest = found.gradients(a * grid.points)

    def places(points: Array | None) -> Array:
        return a * (grid.points[-1:] if points is None else points)

    def displaced(linear: Displace, part: int) -> Displace:
        def displace(points: Array | None) -> tuple[Array, Array]:
            (one, two), (more, less, _) = linear(points), found.displacements(places(points))
            return one + more[part], two + less[part]

        return displace

    def resting(points: Array | None) -> tuple[Array, Array]:
        v, u = found.displacements(places(points))[2]
        return v, u

    def gradients() -> Gradients:
        slope_p, slope_q, strain_p, strain_q = linear.gradients
        return slope_p + by_p[0], slope_q + by_q[0], strain_p + by_p[1], strain_q + by_q[1]

    state = found.state
    return Response(
        gradients, displaced(linear.normal, 0), displaced(linear.tangent, 1),
        slope=rest[0], strain=rest[1], rest=resting, imbalance=state.imbalance,
        outside=_outside(state, ring.law, limit), terms=linear.terms,
        truncation_error=linear.truncation_error,
    )  # fmt: skip


def _outside(state: Equilibrium, law: HardeningLaw, limit: float) -> str:
    """Return where a pressure is beyond the law, in words."""
    if state.highest > limit:
        return (
            f"the pressure in it reaches {state.highest:.4g} [Pa], and its stack's law ends at "
            f"{limit:.4g}: a lower nip load or another law is needed"
        )
    if state.lowest < law.lowest:
        return (
            f"beside the load its stack is torn: the pressure in it falls to {state.lowest:.4g} "
            f"[Pa], and at {law.lowest:.4g} it has lost 95 % of its stiffness; more pressure wound "
            "in, or a lower nip load, is needed"
        )
    return ""


def fineness(nodes: Array) -> Fineness:
    """Return how finely to cut a ring for a contact's nodes, in units of its half width."""
    cells = int(np.count_nonzero(np.abs(nodes) <= 1 + 1e-9)) - 1
    # the elements' error falls with the cube of their size, that of the contact with the square
    inside = max(FEWEST, cells // 2 if cells <= MANY else round(MANY / 2 * (cells / MANY) ** 0.6))
    return Fineness(inside, 8 + inside // 4, 4 + 3 * inside // 8)


@lru_cache(maxsize=4)
def ring(roll: WoundRoll) -> HardeningRing:
    """Return the ring that a roll is; it keeps what it has found to start from."""
    stack = roll.stack
    law = HardeningLaw(
        stack.radial, stack.tangential, stack.poissons_ratio, stack.shear, stack.shear_exponent
    )
    return HardeningRing(roll.radius, roll.core_radius, law, roll.wound_pressure)
