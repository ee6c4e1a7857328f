r"""The nip's equations on a mesh: bodies and web joined into a normal and a stick-slip problem.

With tractions of the web on the roll q+ and on the drum q- (along +x), pressure p on both faces,
T = T_in + int (q+ + q-), 1/R* = 1/R1 + 1/R2 and the web's compliances c:

    indentation (82), differentiated      v1' + v2' + c12 (q+ + q-) - 2h c22 p' + Delta/R* = x/R*
    slip at the roll (133)                v+ = eps - eps1 - [eps - eps1](x = a)
    slip at the drum (133)                v- = eps - eps2 + xi-
    strain of the web (72)                eps = c11 T/(2h) - c12 p

The first is linear in p and Delta and is solved for them once:  p = p0 + K q  (the normal problem).
Put into the other two it leaves the stick-slip problem in q = (q+, q-) and one rigid slip,
xi = xi- + c11 T_out/(2h), which the winding force fixes.  T_in drops out: the winding theorem.

                 p          q+                    q-              xi
    v+  [  S+ = -c12 -E1p | L - E1q           |   L             |  0 ]     E: strain of a body
    v-  [  S- = -c12 -E2p | L                 |   L - E2q       |  1 ]     (E1 less its last row)
    L = c11/(2h) (upstream integral - whole integral)
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..contact.normal import solve_normal
from ..contact.response import Response, Tractions
from ..contact.schemes import Mesh
from ..contact.stick_slip import StickSlip, StickSlipSolution
from ..elasticity.strip import Compliance, compliance
from ..problems.bodies import contact_radius
from ..problems.nip import Web, WindingNip

__all__ = ["NipEquations", "NipMatrices", "NipState", "frictionless_load", "web_compliance"]

Array = np.ndarray
About = tuple[Tractions, Tractions] | None


def web_compliance(web: Web) -> Compliance:
    """Return the web's plane-strain compliances [1/Pa]."""
    return compliance(*web.material.stiffness[:3])


@dataclass(frozen=True, eq=False)
class NipState:
    """A solved nip on one mesh: contact state, pressure and shift for one half width."""

    half_width: float
    solution: StickSlipSolution
    pressure: Array  # (n,) [Pa]
    shift: float  # Delta/R*

    @property
    def roll_traction(self) -> Array:
        """q+ at the interior nodes, (n,) [Pa]."""
        return self.solution.traction[: self.pressure.size]

    @property
    def drum_traction(self) -> Array:
        """q- at the interior nodes, (n,) [Pa]."""
        return self.solution.traction[self.pressure.size :]

    @property
    def known(self) -> tuple[Tractions, Tractions]:
        """What loads the roll and the drum: bodies that are not linear are linearised about it."""
        return (
            Tractions(self.pressure, self.roll_traction),
            Tractions(self.pressure, self.drum_traction),
        )


@dataclass(frozen=True, eq=False)
class NipMatrices:
    """Every matrix of the nip's equations for one half width a, nothing solved yet.

    N cells, n = N - 1 unknown nodes; tractions are stacked (q+, q-).  Slips are those of the nodes'
    cells first, roll then drum; the last cell, which belongs to no unknown, follows for both.
    """

    half_width: float
    slope_p: Array  # (N, n)
    slope_q: Array  # (N, 2n)
    gap: Array  # (N,) slope of the gap, x/R*, less what a linearised body has at zero tractions
    top: float  # largest slope of the gap alone
    direct: Array  # (2n + 2, 2n) slips by tractions
    through_pressure: Array  # (2n + 2, n) slips by pressures
    offset: Array  # (2n + 2,) slips that a linearised body has at zero tractions
    weights: Array  # (n,) integrate a traction over the nip [m]
    roll: Response
    drum: Response

    @classmethod
    def at(cls, problem: WindingNip, mesh: Mesh, a: float, about: About = None) -> NipMatrices:
        """Assemble for the half width ``a`` [m], bodies that are not linear about their loads."""
        one, two = about or (None, None)
        roll, drum = problem.roll.respond(mesh, a, one), problem.drum.respond(mesh, a, two)
        return cls.of(problem, mesh, a, roll, drum)

    @classmethod
    def of(
        cls, problem: WindingNip, mesh: Mesh, a: float, roll: Response, drum: Response
    ) -> NipMatrices:
        """Assemble for the half width ``a`` [m] and given responses of the bodies."""
        web, thickness = web_compliance(problem.web), problem.web.thickness
        n, N = mesh.unknowns, mesh.unknowns + 1
        value = mesh.value[:-1]
        slope_p = (-thickness * web.c22 / a) * mesh.slope[:-1]
        slope_q = np.empty((N, 2 * n))
        slope_q[:, :n] = slope_q[:, n:] = web.c12 * value
        # the web: its tension between the point and the trailing edge, and its squeezing
        direct, through = np.empty((2 * N, 2 * n)), np.empty((2 * N, n))
        stretch, squeeze = (a * web.c11 / thickness) * mesh.behind, -web.c12 * value
        direct[: 2 * n].reshape(2, n, 2, n)[...] = stretch[:-1, None]
        direct[2 * n :].reshape(2, 2, n)[...] = stretch[-1]
        through[: 2 * n].reshape(2, n, n)[...] = squeeze[:-1]
        through[2 * n :] = squeeze[-1]
        gap = mesh.middle * (a / contact_radius(problem.roll, problem.drum))
        top, offset = float(np.max(gap)), np.zeros(2 * N)
        for face, (body, response) in enumerate(((problem.roll, roll), (problem.drum, drum))):
            if body.rigid:
                continue
            own, last = slice(face * n, (face + 1) * n), 2 * n + face
            body_slope_p, body_slope_q, strain_p, strain_q = response.gradients
            slope_p = slope_p + body_slope_p[:-1]
            slope_q[:, own] += body_slope_q[:-1]
            # the wound-on condition refers the roll's strain to the trailing edge
            edge_p, edge_q = (strain_p[-1], strain_q[-1]) if face == 0 else (0.0, 0.0)
            direct[own, own] -= strain_q[:-2] - edge_q
            direct[last, own] -= strain_q[-2] - edge_q
            through[own] -= strain_p[:-2] - edge_p
            through[last] -= strain_p[-2] - edge_p
            if not body.linear:
                rest = np.broadcast_to(response.strain, (N + 1,))
                rest = rest[:-1] - (rest[-1] if face == 0 else 0.0)
                offset[own], offset[last] = -rest[:-1], -rest[-1]
                gap = gap - np.broadcast_to(response.slope, (N + 1,))[:-1]
        weights = a * mesh.grid.weights
        return cls(a, slope_p, slope_q, gap, top, direct, through, offset, weights, roll, drum)

    def indentation(self, p: Array, q: Array, shift: float) -> Array:
        """Return what pressures, tractions and shift leave of the gap's slope, (N,)."""
        return self.slope_p @ p + self.slope_q @ q + shift - self.gap

    def slips(self, p: Array, q: Array, creep: float) -> Array:
        """Return the slips of the nodes' cells, roll then drum, then the last cell's, (2n + 2,)."""
        v = self.offset + self.direct @ q + self.through_pressure @ p
        v[p.size : 2 * p.size] += creep
        v[-1] += creep
        return v


def frictionless_load(problem: WindingNip, mesh: Mesh, a: float) -> float:
    """Return the load that a frictionless contact of half width ``a`` carries [N/m]."""
    web = web_compliance(problem.web)
    slope_p = (-problem.web.thickness * web.c22 / a) * mesh.slope[:-1]
    gap = mesh.middle * (a / contact_radius(problem.roll, problem.drum))
    for body in (problem.roll, problem.drum):
        if not body.rigid:
            slope_p = slope_p + body.respond(mesh, a).pressure_slope()
    pressure = solve_normal(slope_p, gap, np.empty((gap.size, 0)))[:-1, 0]
    return float(a * mesh.grid.weights @ pressure)


@dataclass(frozen=True, eq=False)
class NipEquations:
    """The equations of a nip for one half width, the normal problem solved; made by :meth:`at`."""

    problem: WindingNip
    mesh: Mesh
    matrices: NipMatrices
    pressure: Array  # (n,) p0
    pressure_response: Array  # (n, 2n) K
    shift: float  # Delta/R*
    shift_response: Array  # (2n,)

    @classmethod
    def at(cls, problem: WindingNip, mesh: Mesh, a: float, about: About = None) -> NipEquations:
        """Assemble the equations for the half width ``a`` [m] and solve the normal problem."""
        made = NipMatrices.at(problem, mesh, a, about)
        solved = solve_normal(made.slope_p, made.gap, made.slope_q)
        return cls(
            problem, mesh, made,
            solved[:-1, 0], solved[:-1, 1:], float(solved[-1, 0]), solved[-1, 1:],
        )  # fmt: skip

    @property
    def faces(self) -> Sequence[Array]:
        """Where the tractions on roll and drum are."""
        return self.mesh.columns, self.mesh.columns

    def stick_slip(self) -> StickSlip:
        """Return the stick-slip problem of both faces; slips are strains, tractions in Pa."""
        n, made, problem = self.mesh.unknowns, self.matrices, self.problem
        nodes = slice(0, 2 * n)
        zero, one = np.zeros(n), np.ones(n)
        friction = np.concatenate([problem.roll_friction * one, problem.drum_friction * one])
        # F in proportion to the load that this half width carries: a steady state at any width
        share = problem.winding_force / problem.nip_load
        carried = share * (made.weights @ self.pressure_response)
        return StickSlip(
            made.direct[nodes], made.through_pressure[nodes], made.offset[nodes],
            self.pressure, self.pressure_response, friction, faces=2,
            creep=np.concatenate([zero, one]),
            resultant=np.concatenate([zero, made.weights]) - carried,
            force=share * float(made.weights @ self.pressure),
        )  # fmt: skip

    def state(self, solution: StickSlipSolution) -> NipState:
        """Return the state that belongs to solved tractions."""
        q = solution.traction
        return NipState(
            self.matrices.half_width, solution,
            self.pressure + self.pressure_response @ q,
            self.shift + float(self.shift_response @ q),
        )  # fmt: skip

    def carried(self, state: NipState) -> float:
        """Return the integral of the pressure [N/m]."""
        return float(self.matrices.weights @ state.pressure)

    def frictionless(self) -> float | None:
        """Return the integral of p0 [N/m]."""
        return float(self.matrices.weights @ self.pressure)

    def imbalance(self, state: NipState) -> float:
        """Return what the state leaves of the laws of bodies that are not linear, relative."""
        if self.problem.roll.linear and self.problem.drum.linear:
            return 0.0
        return imbalance(self.matrices, self.anew(state), state)

    def last_slips(self, state: NipState) -> tuple[float, float]:
        """Return v+ and v- in the last cell, which belongs to no unknown."""
        made, last = self.matrices, slice(2 * self.mesh.unknowns, None)
        v = made.offset[last] + made.direct[last] @ state.solution.traction
        v += made.through_pressure[last] @ state.pressure
        return float(v[0]), float(v[1]) + state.solution.creep

    def anew(self, state: NipState) -> NipMatrices:
        """Return the matrices for the same half width about a state."""
        return NipMatrices.at(self.problem, self.mesh, self.matrices.half_width, state.known)


def imbalance(before: Any, after: Any, state: NipState) -> float:
    """Return the largest difference of slopes and slips by two linearisations, relative."""
    p, q = state.pressure, state.solution.traction
    slope = before.indentation(p, q, 0.0) - after.indentation(p, q, 0.0)
    slip = before.slips(p, q, 0.0) - after.slips(p, q, 0.0)
    return float(max(np.max(np.abs(slope)), np.max(np.abs(slip)))) / float(after.top)
