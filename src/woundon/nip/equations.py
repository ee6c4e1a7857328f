r"""The nip's equations on a mesh: bodies and web joined into a normal and a stick-slip problem.

With tractions of the web on the roll q+ and on the drum q- (along +x), pressure p on both faces,
T = T_in + int (q+ + q-), 1/R* = 1/R1 + 1/R2 and the web's compliances c:

    indentation (82), differentiated      v1' + v2' + c12 (q+ + q-) - 2h F(p)' + Delta/R* = x/R*
    slip at the roll (133)                v+ = eps - eps1 - [eps - eps1](x = a)
    slip at the drum (133)                v- = eps - eps2 + xi-
    strain of the web (72)                eps = c11 T/(2h) - c12 p

F = c22 p, but of a web that hardens: there it is linearised about known pressures, as bodies are.
The first is linear in p and Delta and is solved for them once:  p = p0 + K q  (the normal problem).
Put into the other two it leaves the stick-slip problem in q = (q+, q-) and one rigid slip,
xi = xi- + c11 T_out/(2h), which the winding force fixes.  T_in drops out: the winding theorem.

                 p          q+                    q-              xi
    v+  [  S+ = -c12 -E1p | L - E1q           |   L             |  0 ]     E: strain of a body
    v-  [  S- = -c12 -E2p | L                 |   L - E2q       |  1 ]     (E1 less its last row)
    L = c11/(2h) (upstream integral - whole integral)
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np

from ..contact.response import Response, Tractions
from ..contact.schemes import Mesh
from ..contact.stick_slip import StickSlip
from ..two_bodies import About, Matrices, PairEquations, PairState

__all__ = ["NipEquations", "NipMatrices", "gained"]

Array = np.ndarray


@dataclass(frozen=True, eq=False)
class NipMatrices(Matrices):
    """The nip's matrices: tractions are stacked (q+, q-), m = 2n.

    Slips are those of the nodes' cells first, roll then drum; the last cell, which belongs to no
    unknown, follows for both, (2n + 2,).
    """

    @classmethod
    def of(
        cls, problem: Any, mesh: Mesh, a: float, one: Response, two: Response, about: About = None
    ) -> Self:
        """Assemble for the half width ``a`` [m] and given responses of roll and drum."""
        web, thickness = problem.web.compliance, problem.web.thickness
        n, N = mesh.unknowns, mesh.unknowns + 1
        value = mesh.value[:-1]
        # the web's thinning varies linearly between the nodes, as the pressure does
        known = np.zeros(n) if about is None else np.maximum(about[0].pressure, 0.0)
        thinned, by_pressure = problem.web.thinned(known)
        slope_p = mesh.slope[:-1] * (-by_pressure / a)
        slope_q = np.empty((N, 2 * n))
        # the web: its tension between the point and the trailing edge, and its squeezing
        direct, through = np.empty((2 * N, 2 * n)), np.empty((2 * N, n))
        squeeze = -web.c12 * value
        for face, body in enumerate(problem.bodies):
            own, facing = slice(face * n, (face + 1) * n), mesh.facing(body.rigid)
            slope_q[:, own] = web.c12 * facing.value[:-1]
            stretch = (a * web.c11 / thickness) * facing.behind
            direct[: 2 * n].reshape(2, n, 2, n)[:, :, face] = stretch[:-1]
            direct[2 * n :, own] = stretch[-1]
        through[: 2 * n].reshape(2, n, n)[...] = squeeze[:-1]
        through[2 * n :] = squeeze[-1]
        gap = mesh.middle * (a / problem.contact_radius)
        top, offset = float(np.max(gap)), np.zeros(2 * N)
        if not problem.web.linear:
            gap = gap + mesh.slope[:-1] @ (thinned - by_pressure * known) / a
        for face, (body, response) in enumerate(((problem.roll, one), (problem.drum, two))):
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
        moves = np.zeros(2 * N)
        moves[n : 2 * n] = moves[-1] = 1.0
        weights = a * mesh.grid.weights
        return cls(
            a, slope_p, slope_q, gap, top, direct, through, offset, moves, weights, (one, two)
        )  # fmt: skip

    @staticmethod
    def loads(p: Array, q: Array) -> tuple[Tractions, Tractions]:
        """Return what loads roll and drum."""
        return Tractions(p, q[: p.size]), Tractions(p, q[p.size :])


@dataclass(frozen=True, eq=False)
class NipEquations(PairEquations):
    """The equations of a nip for one half width, the normal problem solved."""

    made_of: ClassVar[type[Matrices]] = NipMatrices

    def stick_slip(self) -> StickSlip:
        """Return the stick-slip problem of both faces; slips are strains, tractions in Pa."""
        n, made, problem = self.mesh.unknowns, self.matrices, self.problem
        p0, K = self.pressure, self.pressure_response
        nodes = slice(0, 2 * n)
        zero, one = np.zeros(n), np.ones(n)
        friction = np.concatenate([problem.roll_friction * one, problem.drum_friction * one])
        held = made.half_width * self.mesh.facing(problem.drum.rigid).grid.weights
        # F in proportion to the load that this half width carries: a steady state at any width
        share = problem.winding_force / problem.nip_load
        carried = share * (made.weights @ K)
        return StickSlip(
            made.direct[nodes], made.through_pressure[nodes], made.offset[nodes],
            p0, K, friction, faces=2,
            creep=np.concatenate([zero, one]),
            resultant=np.concatenate([zero, held]) - carried,
            force=share * float(made.weights @ p0),
        )  # fmt: skip

    def last_slips(self, state: PairState) -> tuple[float, float]:
        """Return v+ and v- in the last cell, which belongs to no unknown."""
        made, last = self.matrices, slice(2 * self.mesh.unknowns, None)
        v = made.offset[last] + made.direct[last] @ state.solution.traction
        v += made.through_pressure[last] @ state.pressure
        return float(v[0]), float(v[1]) + state.solution.creep


def gained(problem: Any, mesh: Mesh, x: Array, q_roll: Array, q_drum: Array) -> Array:
    """Return what nodal tractions add to the web's tension up to every node, (M,) [N/m]."""
    roll, drum = (mesh.facing(body.rigid) for body in problem.bodies)
    if roll is drum:
        return roll.from_edge(q_roll + q_drum, x)
    return roll.from_edge(q_roll, x) + drum.from_edge(q_drum, x)
