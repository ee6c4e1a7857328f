r"""Exact sensitivities of a solved nip with its wraps, as :mod:`..nip.sensitivity` has them.

The unknowns are u = (z, q, xi, ln a) of :mod:`.equations`, z = (p+, p-, Delta/R*), and R(u, theta)

      z           q           xi    ln a
    [ by_z        by_q        0     dR/dln a ]    indentation, cells of the nip
    [ 1 - T kappa             0     dR/dln a ]    the web's normal balance, nodes
    [ slip_z      slip_q      e     dR/dln a ]    sticking nodes
    [ -s mu       1           0     0        ]    slipping nodes
    [ 0           w-          0     dR/dln a ]    winding force
    [ w           0           0     dR/dln a ]    nip load

T kappa is not linear; about the converged state its tangent is what the solver used last.  That of
a roll that hardens is its response about its loads, which R at other parameters takes as given:
its equilibrium under them is found anew.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from ..contact.levels import Level
from ..contact.resting import Resting
from ..errors import InvalidProblem
from ..nip.differential import Differential
from ..nip.sensitivity import Sensitivity, continuous_fields, differentiated
from ..threads import one_thread
from ..two_bodies import mesh_of
from .certificate import equations_of, unknowns_of
from .equations import WrapEquations
from .grid import grid_for
from .scatter import resting

if TYPE_CHECKING:
    from ..problems.nip import WrappedNipProblem
    from .result import WrappedNipResult

__all__ = ["wrapped_sensitivity"]

Array = np.ndarray

WRAPS = ("roll_wrap", "drum_wrap")
# What moves the grid: where an arc begins the curvature is then known to 1e-7 only, for its slope
# is taken 1e-9 of a cell beside the node; so steps are longer, and differences central.
GEOMETRY, LONG_STEP = (*WRAPS, "roll.radius", "drum.radius"), 1e-4


@one_thread
def wrapped_sensitivity(
    result: WrappedNipResult, parameters: tuple[str, ...], outputs: tuple[str, ...] = ()
) -> Sensitivity:
    """Return derivatives of a wrapped nip's main outputs; see :class:`Sensitivity`.

    Parameters
    ----------
    result : WrappedNipResult
        On its own mesh, in its own state.
    parameters : tuple of str
        Dotted names; all continuous fields if empty, without the items of lists.
    outputs : tuple of str
        All if empty.

    Raises
    ------
    InvalidProblem
        For a name that is not a continuous field or not one of these outputs, and for a wrap of
        angle 0, which has one side.
    """
    known = continuous_fields(result.problem)
    for name in WRAPS:
        if known[name] == 0 and name in parameters:
            raise InvalidProblem.at(name, "0 has no derivative: with a wrap the web's path changes")
        if known[name] == 0:
            del known[name]
    return differentiated(_WrapDifferential, result, parameters, outputs, known)


class _WrapDifferential(Differential):
    """R and J of a nip with its wraps."""

    outputs = (
        "wound_on_tension", "nip_induced_tension", "tension_behind_nip", "half_width", "nip_width",
        "drum_creep",
    )  # fmt: skip

    def __init__(self, result: WrappedNipResult, told: tuple[str, ...]) -> None:
        super().__init__(result, told)
        here = self.here = equations_of(result)
        self.z, self.q, self.creep = unknowns_of(result, here)
        self.zones = np.concatenate([result.roll_zone[here.roll_q], result.drum_zone[here.drum_q]])
        self.rest = self.residual(self.problem, here)
        self.resting = self._resting()

    def _resting(self) -> Resting | None:
        """Return what outputs change by as borders come to rest; None of a result without."""
        result, here, names = self.result, self.here, self.outputs[:3]
        beyond = result.extrapolation, result.extrapolation_of_nip, result.extrapolation_behind
        if not any(beyond) or here.joint is None:
            return None
        state = here.state(here.joint.solve(self.zones))
        # of these outputs none asks for the power, as widths do
        level = Level(mesh_of(result), here, state, self.problem.nip_load, 2.0)
        return resting(level, names)

    def laws_of(self, made: WrapEquations) -> Any:
        """Return what is along the web, of the unknowns."""
        return made.laws.at(self.z, self.q)

    def residual(self, problem: WrappedNipProblem, made: WrapEquations) -> Array:
        """Return R at the fixed unknowns, of another problem or half width."""
        z, q, laws = self.z, self.q, made.laws
        along = self.laws(made)
        slip, bound = self._slips_and_bounds(made)
        held = np.where(self.zones == 0, slip, q - self.zones * bound)
        force = float(made.force_weights @ q) - problem.winding_force
        load = float(made.load_weights @ z) - problem.nip_load
        first = z[:1] if made.drum_arc else z[:0]  # p+ begins with zero
        return np.concatenate([along.gap, laws.balance(along), first, held, [force, load]])

    def jacobian(self) -> Array:
        """Return R_u."""
        here, k, m = self.here, self.z.size, self.q.size
        _, *closing = here.indentation
        _, *balance = here.balance()
        slip_z, slip_q, _ = here.node_slips
        stuck, bound = (self.zones == 0)[:, None], np.zeros((m, k))
        bound[np.arange(m), here.own_pressure] = -self.zones * here.friction
        J = np.zeros((k + m + 2, k + m + 2))
        normal = np.hstack([np.vstack(part) for part in zip(closing, balance, strict=True)])
        J[: len(normal), : k + m] = normal
        if here.drum_arc:
            J[k - 1, 0] = 1.0
        J[k : k + m, :k] = np.where(stuck, slip_z, bound)
        J[k : k + m, k : k + m] = np.where(stuck, slip_q, np.eye(m))
        J[k : k + m, k + m] = stuck[:, 0] & here.on_drum
        J[k + m, k : k + m] = here.force_weights
        J[k + m + 1, :k] = here.load_weights
        J[:, -1], self.outputs_by_width = self.by_width()
        return J

    def output_gradients(self) -> Array:
        """Return J_u of the outputs, (outputs, unknowns); after :meth:`jacobian`."""
        here, k, m = self.here, self.z.size, self.q.size
        before, behind, far = (
            here.tension_q[node] for node in (here.grid.first, here.grid.last, -1)
        )
        stretch = here.web.c11 / self.problem.web.thickness
        J = np.zeros((len(self.outputs), k + m + 2))
        J[[0, 1, 2, 5], k : k + m] = far, behind - before, behind, -stretch * far
        J[5, k + m] = 1.0
        if self.resting is not None:
            J[:3, :-1] += self.resting.gradients
        J[:, -1] = self.outputs_by_width
        return J

    def output_values(self, problem: WrappedNipProblem, made: WrapEquations) -> Array:
        """Return the outputs of another problem or half width at the fixed unknowns."""
        a, grid = made.half_width, made.grid
        T = problem.web_tension + made.tension_q @ self.q
        before, behind, far = T[grid.first], T[grid.last], T[-1]
        creep = self.creep - problem.web.compliance.c11 / problem.web.thickness * far
        found = np.array([far, behind - before, behind, a, 2 * a, creep])
        if self.resting is not None:
            slip, bound = self._slips_and_bounds(made)
            found[:3] += self.resting.under(slip, self.q, bound) * (a / self.half_width)
        return found

    def _slips_and_bounds(self, made: WrapEquations) -> tuple[Array, Array]:
        """Return slips, and what friction can hold, of the nodes of the tractions."""
        along = self.laws(made)
        slip = np.concatenate([along.roll_slip[:-1], along.drum_slip[:-1] + self.creep])
        return slip, made.friction * self.z[made.own_pressure]

    def by_width(self) -> tuple[Array, Array]:
        """Return dR/dln a and the outputs' dJ/dln a."""
        return _mean(*(self.by_width_over(step) for step in (LONG_STEP, -LONG_STEP)))

    def changes(self, name: str, value: float) -> tuple[Array, Array]:
        """Return R_theta and the outputs' explicit J_theta for one field."""
        if name not in GEOMETRY:
            return super().changes(name, value)
        return _mean(*(self.changes_over(step, name, value) for step in (LONG_STEP, -LONG_STEP)))

    def assembled(self, problem: WrappedNipProblem, a: float, part: str) -> WrapEquations:
        """Assemble for a half width and a problem of which only one part is another ('' none)."""
        here = self.here
        own, first = here.grid, here.grid.first
        nip = mesh_of(self.result).grid
        grid = grid_for(problem, nip, a, first, own.size - first - nip.nodes.size, own)
        made = WrapEquations(problem, grid, a, here.about)
        if a == self.half_width and np.array_equal(grid.nodes, own.nodes):
            # what a body answers is most of the work; that of the others have not changed
            for name, body in zip(problem.pair, problem.bodies, strict=True):
                lags = part == problem.speed_field and body.viscoelastic
                if name != part and not lags:
                    vars(made.laws)[name] = getattr(here.laws, name)
        return made

    def bounds(self) -> Iterator[tuple[str, Array, Array]]:
        """Yield each face by name, the nodes of its tractions, and what friction can hold there."""
        here, bound = self.here, self.here.friction * self.z[self.here.own_pressure]
        yield "roll", here.roll_q, bound[~here.on_drum]
        yield "drum", here.drum_q, bound[here.on_drum]


def _mean(one: tuple[Array, Array], two: tuple[Array, Array]) -> tuple[Array, Array]:
    return (one[0] + two[0]) / 2, (one[1] + two[1]) / 2
