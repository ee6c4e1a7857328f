r"""The nip's equations on a mesh: bodies and web joined into a normal and a stick-slip problem.

With tractions of the web on the roll q+ and on the drum q- (along +x), pressure p on both faces,
T = T_in + int (q+ + q-), 1/R* = 1/R1 + 1/R2 and the web's compliances c:

    indentation (82), differentiated      v1' + v2' + c12 (q+ + q-) - 2h F(p)' + Delta/R* = x/R*
    slip at the roll (133)                v+ = eps - eps1 - [eps - eps1](x = a)
    slip at the drum (133)                v- = eps - eps2 + xi-
    strain of the web (72)                eps = c11 T/(2h) - c12 p

F = c22 p, but of a web that hardens: there it is linearised about known pressures, as bodies are.
They are solved together, for p, Delta, q = (q+, q-) and one rigid slip, xi = xi- + c11 T_out/(2h),
which the winding force fixes (the joint system).  T_in drops out: the winding theorem.  Where that
wanders, the first is solved for p and Delta,  p = p0 + K q  (the normal problem); put into the
other two it leaves the stick-slip problem in q and xi, which has a safe way.

                 p          q+                    q-              xi
    v+  [  S+ = -c12 -E1p | L - E1q           |   L             |  0 ]     E: strain of a body
    v-  [  S- = -c12 -E2p | L                 |   L - E2q       |  1 ]     (E1 less its last row)
    L = c11/(2h) (upstream integral - whole integral)
"""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, Self

import numpy as np

from ..contact.joint import Joint
from ..contact.meshes import Mesh
from ..contact.response import Response, Tractions
from ..contact.stick_slip import RigidFace, StickSlip, StickSlipSolution
from ..two_bodies import About, Matrices, PairEquations, PairState
from .laws import NipLaws

__all__ = ["NipEquations", "NipMatrices", "gained", "jointly"]

Array = np.ndarray
# below, tractions drown in the rounding of the pressures if both are solved for together
LEAST_FRICTION = 0.01


@dataclass(frozen=True, eq=False)
class NipMatrices(Matrices):
    """The nip's matrices: tractions are stacked (q+, q-), m = 2n.

    Slips are those of the nodes' cells first, roll then drum; the last cell, which belongs to no
    unknown, follows for both, (2n + 2,).  All are parts of one matrix, that of the joint system.
    """

    whole: Array  # (3n + 4, 3n + 2)

    @classmethod
    def of(
        cls, problem: Any, mesh: Mesh, a: float, one: Response, two: Response, about: About = None
    ) -> Self:
        """Assemble for the half width ``a`` [m] and given responses of roll and drum."""
        web, thickness = problem.web.compliance, problem.web.thickness
        n, N = mesh.unknowns, mesh.unknowns + 1
        gap = mesh.middle * (a / problem.contact_radius)
        top, offset, thinning = float(gap[-1]), np.zeros(2 * N), problem.thinning
        if not problem.web.linear:
            # the web's thinning varies linearly between the nodes, as the pressure does
            known = np.zeros(n) if about is None else np.maximum(about[0].pressure, 0.0)
            thinned, by_pressure = problem.web.thinned(known)
            gap, thinning = (
                gap + mesh.slope[:-1] @ (thinned - by_pressure * known) / a,
                -by_pressure,
            )
        whole = np.empty((3 * N + 1, 3 * N - 1))
        slope_p, slope_q = whole[:N, :n], whole[:N, N:-1]
        through, direct = whole[N + 1 :, :n], whole[N + 1 :, N:-1]
        moves = whole[N + 1 :, -1]
        whole[:N, n], whole[:N, -1], whole[N + 1 :, n] = 1.0, 0.0, 0.0
        np.multiply(mesh.slope[:-1], thinning / a, out=slope_p)
        # the web: its tension between the point and the trailing edge, and its squeezing
        value = web.c12 * mesh.value[:-1]
        stretched = a * web.c11 / thickness
        behind = stretched * mesh.behind
        for face, (body, response) in enumerate(((problem.roll, one), (problem.drum, two))):
            own, last = slice(face * n, (face + 1) * n), 2 * n + face
            other, facing = slice((1 - face) * n, (2 - face) * n), mesh.facing(body.rigid)
            stretch = behind if facing is mesh else stretched * facing.behind
            direct[other, own], direct[2 * n + 1 - face, own] = stretch[:-1], stretch[-1]
            if body.rigid:
                slope_q[:, own] = web.c12 * facing.value[:-1]
                direct[own, own], direct[last, own] = stretch[:-1], stretch[-1]
                through[own], through[last] = -value[:-1], -value[-1]
                continue
            body_slope_p, body_slope_q, strain_p, strain_q = response.gradients
            slope_p += body_slope_p[:-1]
            np.add(value, body_slope_q[:-1], out=slope_q[:, own])
            by_p, by_q = -value - strain_p[:-1], stretch - strain_q[:-1]
            if face == 0:  # the wound-on condition refers the roll's strain to the trailing edge
                by_p += strain_p[-1]
                by_q += strain_q[-1]
            through[own], through[last] = by_p[:-1], by_p[-1]
            direct[own, own], direct[last, own] = by_q[:-1], by_q[-1]
            if not body.linear:
                rest = np.broadcast_to(response.strain, (N + 1,))
                rest = rest[:-1] - (rest[-1] if face == 0 else 0.0)
                offset[own], offset[last] = -rest[:-1], -rest[-1]
                gap = gap - np.broadcast_to(response.slope, (N + 1,))[:-1]
        moves[:] = 0.0
        moves[n : 2 * n] = moves[-1] = 1.0
        weights = a * mesh.grid.weights
        return cls(
            a, slope_p, slope_q, gap, top, direct, through, offset, moves, weights, (one, two),
            whole,
        )  # fmt: skip

    @staticmethod
    def loads(p: Array, q: Array) -> tuple[Tractions, Tractions]:
        """Return what loads roll and drum."""
        return Tractions(p, q[: p.size]), Tractions(p, q[p.size :])


@dataclass(frozen=True, eq=False)
class NipEquations(PairEquations):
    """The equations of a nip for one half width."""

    made_of: ClassVar[type[Matrices]] = NipMatrices
    face_count: ClassVar[int] = 2

    @cached_property
    def _friction(self) -> Array:
        """mu of each node, (2n,)."""
        n, friction = self.mesh.unknowns, np.empty(2 * self.mesh.unknowns)
        friction[:n], friction[n:] = self.problem.roll_friction, self.problem.drum_friction
        return friction

    @property
    def _share(self) -> float:
        """F by the load that a half width carries: a steady state at any width."""
        return float(self.problem.winding_force / self.problem.nip_load)

    @cached_property
    def joint(self) -> Joint | None:
        """The system of pressure and tractions together.

        None where rounding blurs tractions, and on elements, which have a search of their own.
        """
        if not jointly(self.problem) or self.mesh.facing(True) is not self.mesh:
            return None
        made, n = self.matrices, self.mesh.unknowns
        row = made.whole[n + 1]
        row[...] = 0.0
        row[:n], row[2 * n + 1 : -1] = -self._share * made.weights, made.weights
        row *= self._size
        right = np.concatenate([made.gap, [0.0], -made.offset])
        own = np.concatenate([np.arange(n)] * 2)
        rigid = RigidFace(slice(n, 2 * n), made.weights) if self.problem.drum.rigid else None
        # a copy has no joint: matrices that lead to themselves would wait for the garbage collector
        condensed = copy(self).stick_slip
        return Joint(made.whole, right, self._friction, own, condensed, rigid=rigid)

    @cached_property
    def _size(self) -> float:
        """What makes the row of the force as large as those of slopes."""
        # slopes are largest beside their own node, in the middle cell as in any
        middle = self.matrices.slope_p[self.mesh.unknowns // 2]
        return float(np.abs(middle).max() / self.matrices.weights.max())

    def stick_slip(self) -> StickSlip:
        """Return the stick-slip problem of both faces; slips are strains, tractions in Pa."""
        n, made = self.mesh.unknowns, self.matrices
        nodes, p0, K = slice(0, 2 * n), self.pressure, self.pressure_response
        held = made.half_width * self.mesh.facing(self.problem.drum.rigid).grid.weights
        carried = self._share * (made.weights @ K)
        return StickSlip(
            made.direct[nodes], made.through_pressure[nodes], made.offset[nodes],
            p0, K, self._friction, faces=2,
            creep=made.moves[nodes],
            resultant=np.concatenate([np.zeros(n), held]) - carried,
            force=self._share * float(made.weights @ p0),
        )  # fmt: skip

    def state(self, solution: StickSlipSolution) -> PairState:
        """Return the state that belongs to solved tractions."""
        if solution.joint is None:
            return super().state(solution)
        n, found = self.mesh.unknowns, solution.joint[1]
        p, q = found[:n], solution.traction
        known = self.matrices.loads(p, q)
        return PairState(self.matrices.half_width, solution, p, float(found[n]), known)

    def last_slips(self, state: PairState) -> tuple[float, float]:
        """Return v+ and v- in the last cell, which belongs to no unknown."""
        if state.solution.joint is not None:
            last = state.solution.joint[2]
        else:
            made, q = self.matrices, state.traction
            last = made.slips(state.pressure, q, state.solution.creep)[q.size :]
        return float(last[0]), float(last[1])

    # ---- from one half width to another --------------------------------------------------------

    def moved(self, a: float) -> Self:
        """Return the equations for another half width [m], as laws without matrices."""
        other = type(self)(self.problem, self.mesh, NipLaws.at(self.problem, self.mesh, a))
        vars(other).update(_size=self._size, joint=self.joint)  # the factors stay
        return other

    def left(self, found: Array) -> Array:
        """Return what unknowns leave of the joint system's right sides; less all slips."""
        n, made, weights = self.mesh.unknowns, self.matrices, self.matrices.weights
        p, q = found[:n], found[n + 1 : -1]
        out = np.empty(3 * n + 4)
        miss, slips = made.laws(p, q, float(found[n]), float(found[-1]))
        force = self._share * float(weights @ p) - float(weights @ q[n:])
        np.negative(miss, out=out[: n + 1])
        np.negative(slips, out=out[n + 2 :])
        out[n + 1] = self._size * force
        return out

    def load_of(self, p: Array) -> float:
        """Return the load that a pressure carries [N/m]."""
        return float(self.matrices.weights @ p)


def jointly(problem: Any) -> bool:
    """Tell whether there is friction enough for pressure and tractions to be solved together."""
    return bool(min(problem.roll_friction, problem.drum_friction) >= LEAST_FRICTION)


def gained(problem: Any, mesh: Mesh, x: Array, q_roll: Array, q_drum: Array) -> Array:
    """Return what nodal tractions add to the web's tension up to every node, (M,) [N/m]."""
    roll, drum = (mesh.facing(body.rigid) for body in problem.bodies)
    if roll is drum:
        return roll.from_edge(q_roll + q_drum, x)
    return roll.from_edge(q_roll, x) + drum.from_edge(q_drum, x)
