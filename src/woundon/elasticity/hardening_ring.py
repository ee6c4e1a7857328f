r"""A wound roll that stiffens under the nip: how its surface differs from a linear cylinder's.

The roll is a ring R0 <= r <= R on a rigid core, wound under the pressure P0(r).  Pressure p and
traction q on its surface (x = R theta along it) add displacements v (outward) and u (along +x) and
stresses by :mod:`.hardening`; strains are small, and plane:

    int (s_r e_r* + s_t e_t* + tau gamma*) r/R dr dx = int (q u* - p v*) dx,    v = u = 0 at R0,

for all virtual displacements v*, u* and their strains (:mod:`.ring_elements`).  On the surface

    w(f) = w_0(f) + [w_h(f) - w_0h(f)],        w = (v, u),  f = (p, q),

w_0 that of the linear cylinder with the moduli of the wound surface, known exactly
(:mod:`.cylinder`), w_h and w_0h those of roll and linear cylinder on one mesh of elements.  Where
the tractions fall to zero like a root, at the contact's edges, the stack is as stiff as wound, and
both have the same singularities: what is left to the elements has strains that vary like distance
times its logarithm.  About tractions f0 then

    w(f) ~ w_0(f) + w_h(f0) - Y f0 + (Y - Y_0) f,        Y = dw_h/df at f0.

The equilibrium is found from the last one, whatever that was: the energy is convex, there is only
one, and where the iteration started shows in its last digits alone.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from .hardening import HardeningLaw, Stressed
from .ring_elements import Factors, Fineness, RingMesh

__all__ = ["Equilibrium", "HardeningRing", "Linearised", "NoEquilibrium"]

Array = np.ndarray

EQUILIBRIUM = 1e-11  # of the load; the certificate allows 1e-8
ROUNDING = 5e-9  # of the load: what very thin rows may leave
STEPS = 80
LONGEST = 1.0  # change of ln E_r in a step
# shares of the forces that a step leaves: one with a tangent of before that leaves more was the
# last one with it; one that leaves less shows that it is still right
SLOW, RIGHT = 0.05, 1e-4


class NoEquilibrium(ArithmeticError):
    """Newton's iteration found no equilibrium."""


class Equilibrium(NamedTuple):
    """The roll at rest under given loads.

    Attributes
    ----------
    moved : (2, k) array
        v and u of the surface's nodes [m].
    compliance : (2, k, 2, k) array
        Their derivatives by the surface's nodal forces [m per N/m].
    imbalance : float
        The largest nodal force left, by the sum of those given.
    lowest, highest : float
        Least and largest pressure in the roll [Pa].
    """

    moved: Array
    compliance: Array
    imbalance: float
    lowest: float
    highest: float


@dataclass(frozen=True, eq=False)
class Linearised:
    """What a roll's surface does beside a linear cylinder's, linearised about n tractions.

    Attributes
    ----------
    mesh : RingMesh
    by_p, by_q : (2, k, n) arrays
        v and u of the surface's nodes by pressures and tractions [m/Pa].
    rest : (2, k) array
        What they are without [m].
    state : Equilibrium
    """

    mesh: RingMesh
    by_p: Array
    by_q: Array
    rest: Array
    state: Equilibrium

    def displacements(self, at: Array) -> tuple[Array, Array, Array]:
        """Return v and u at m places x, by p, by q (2, m, n), and without tractions (2, m)."""
        value, _ = self.mesh.drawn(at)
        return value @ self.by_p, value @ self.by_q, self.rest @ value.T

    def gradients(self, at: Array) -> tuple[Array, Array, Array]:
        """Return dv/dx and the surface's strain, as ``displacements`` does."""
        value, slope = self.mesh.drawn(at)

        def of(w: Array) -> Array:
            return np.stack([slope @ w[0], slope @ w[1] + value @ w[0] / self.mesh.radius])

        return of(self.by_p), of(self.by_q), of(self.rest)


class HardeningRing:
    """A wound roll; it remembers its last equilibrium and its last answer.

    Parameters
    ----------
    radius, core_radius : float
        R and R0 [m].
    law : HardeningLaw
    wound : callable
        P0(r) [Pa], vectorised.
    """

    def __init__(
        self, radius: float, core_radius: float, law: HardeningLaw,
        wound: Callable[[Array], Array],
    ) -> None:  # fmt: skip
        self.radius, self.core_radius, self.law, self.wound = radius, core_radius, law, wound
        self._mesh: _Loaded | None = None
        self._answer: tuple[Any, Linearised] | None = None

    @property
    def stiffness(self) -> tuple[float, float, float, float]:
        """A_rr, A_tt, A_rt, G of the wound surface, those of the linear cylinder [Pa]."""
        return self.law.stiffness(float(self.wound(np.array(self.radius))))

    def about(
        self, fineness: Fineness, a: float, nodes: Array, columns: slice, p: Array, q: Array
    ) -> Linearised:
        """Return the roll linearised about tractions, less the linear cylinder.

        Parameters
        ----------
        fineness : Fineness
        a : float
            Half width of the contact [m].
        nodes : (m,) array
            Of the piecewise linear tractions [m]; ``columns`` are those of the unknowns.
        p, q : (n,) arrays
            Pressure and traction [Pa].

        Raises
        ------
        NoEquilibrium
            If the roll's equilibrium is not found.
        """
        asked = (fineness, a, *(part.tobytes() for part in (nodes, p, q)))
        if self._answer is not None and self._answer[0] == asked:
            return self._answer[1]
        mesh = self._loaded(fineness, a)
        hats = mesh.hats(nodes)[:, columns]
        forces = np.stack([-hats @ p, hats @ q])
        state = mesh.equilibrium(forces)
        rest = state.moved - np.einsum("ikjl,jl->ik", state.compliance, forces)
        more = state.compliance - mesh.reference
        found = Linearised(mesh, -more[:, :, 0] @ hats, more[:, :, 1] @ hats, rest, state)
        self._answer = asked, found
        return found

    def _loaded(self, fineness: Fineness, a: float) -> _Loaded:
        """Return the mesh for a half width, its state that of the last one."""
        global _latest
        if self._mesh is None or (self._mesh.fineness, self._mesh.half_width) != (fineness, a):
            self._mesh = _Loaded(self, fineness, a, self._mesh or _latest)
        _latest = self._mesh
        return self._mesh


class _Loaded(RingMesh):
    """A ring's mesh and the state that was last found on it."""

    def __init__(
        self, ring: HardeningRing, fineness: Fineness, a: float, before: _Loaded | None
    ) -> None:
        super().__init__(ring.radius, ring.core_radius, fineness, a)
        self.ring, self.law, self.fineness = ring, ring.law, fineness
        self.stiffness_0 = ring.stiffness
        self.wound = ring.wound(self.heights)
        self.u = np.zeros(self.topology.size)
        self.factors: Factors | None = None
        if before is not None and before.ring is ring and before.fineness == fineness:
            self.u, self.factors = before.u, before.factors
        elif before is not None and np.array_equal(before.r[[0, -1]], self.r[[0, -1]]):
            self.u = self.carried(before.u, before)

    @cached_property
    def reference(self) -> Array:
        """Compliance of the linear cylinder, (2, k, 2, k)."""
        A_rr, A_tt, A_rt, G = self.stiffness_0
        moduli = np.array([[A_rr, A_rt, 0], [A_rt, A_tt, 0], [0, 0, G]])
        return self.stiffness(np.broadcast_to(moduli, (*self.weights.shape, 3, 3))).compliance

    def equilibrium(self, forces: Array) -> Equilibrium:
        """Return the roll at rest under nodal forces of the surface, (2, k) [N/m]."""
        f = np.zeros(self.topology.size)
        f[self.topology.surface] = forces
        try:
            return self._found(f)
        except NoEquilibrium:
            if not self.u.any():
                raise
        self.u, self.factors = np.zeros(f.size), None  # the last state was too far away
        return self._found(f)

    def _found(self, f: Array) -> Equilibrium:
        """Return the equilibrium by Newton's iteration, the tangent of before while it serves."""
        unit = float(np.sum(np.abs(f))) or 1.0
        u, factors = self.u, self.factors
        found = self.law.stressed(self.strain(u), self.wound)
        before, rate = np.inf, 0.0  # rate: the share of forces that a step with these factors left
        for _ in range(STEPS):
            rest = f - self.forces(found.stress)
            left = float(np.max(np.abs(rest))) / unit
            if left <= EQUILIBRIUM or (left <= ROUNDING and left > before / 2):
                break
            rate, before = max(rate, left / before), left
            if factors is None or rate > SLOW:
                factors, rate = self.stiffness(found.tangent), 0.0
            u, found = self._stepped(u, factors.solve(rest), found, f)
        else:
            raise NoEquilibrium(f"the roll finds no equilibrium: {left:.2g} of the load are left")
        if factors is None or rate > RIGHT:
            factors = self.stiffness(found.tangent)
        self.u, self.factors = u, factors
        P = found.pressure
        return Equilibrium(
            u[self.topology.surface], factors.compliance, left, float(P.min()), float(P.max())
        )

    def _stepped(self, u: Array, step: Array, found: Stressed, f: Array) -> tuple[Array, Stressed]:
        """Take a step, shorter where the moduli would change much or the energy rise."""
        steep = self.law.radial.modulus_slope(found.pressure)
        change = float(np.max(np.abs(steep * self.strain(step)[..., 0])))
        share = min(1.0, LONGEST / change) if change > 0 else 1.0
        falls = (f - self.forces(found.stress)) @ step  # by so much the energy falls at first
        for _ in range(30):
            there = self.law.stressed(self.strain(u + share * step), self.wound)
            if (self.forces(there.stress) - f) @ step <= falls / 2:  # else it is steep up again
                break
            share /= 2
        return u + share * step, there


_latest: _Loaded | None = None
