r"""The equations of two rollers on a mesh.

With the traction q on the upper roller along +x (and -q on the lower one)

    indentation, differentiated    v1' + v2' + Delta/R* = x/R*
    rolling                        slip = eps2 - eps1 + xi
    static                         slip = u2 - u1 + shift

and slip = 0 in stick, q = sgn(slip) mu p else.  The static problem is that of a load that only
grows; the pressure is taken to be there before the tangential load.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..contact.normal import solve_normal
from ..contact.response import Response, Tractions
from ..contact.schemes import Mesh
from ..contact.stick_slip import StickSlip, StickSlipSolution
from ..problems.bodies import contact_radius
from ..problems.rollers import RollerProblem

__all__ = ["RollerEquations", "RollerMatrices", "RollerState"]

Array = np.ndarray
About = tuple[Tractions, Tractions] | None


@dataclass(frozen=True, eq=False)
class RollerState:
    """Two solved rollers on one mesh: contact state, pressure and shift for one half width."""

    half_width: float
    solution: StickSlipSolution
    pressure: Array  # (n,) [Pa]
    shift: float  # Delta/R*

    @property
    def known(self) -> tuple[Tractions, Tractions]:
        """What loads the upper and the lower roller."""
        q = self.solution.traction
        return Tractions(self.pressure, q), Tractions(self.pressure, -q)


@dataclass(frozen=True, eq=False)
class RollerMatrices:
    """The matrices of two rollers for one half width a; N cells, n = N - 1 unknown nodes."""

    half_width: float
    slope_p: Array  # (N, n)
    slope_q: Array  # (N, n)
    gap: Array  # (N,) slope of the gap, less what a linearised body has at zero tractions
    top: float  # largest slope of the gap alone
    direct: Array  # (n, n) slips by tractions
    through_pressure: Array  # (n, n) slips by pressures
    offset: Array  # (n,) slips that a linearised body has at zero tractions
    weights: Array  # (n,)
    upper: Response
    lower: Response

    @classmethod
    def at(
        cls, problem: RollerProblem, mesh: Mesh, a: float, about: About = None
    ) -> RollerMatrices:
        """Assemble for the half width ``a`` [m], bodies that are not linear about their loads."""
        one, two = about or (None, None)
        upper, lower = problem.upper.respond(mesh, a, one), problem.lower.respond(mesh, a, two)
        n = mesh.unknowns
        up_p, up_q, up_strain_p, up_strain_q = upper.gradients
        low_p, low_q, low_strain_p, low_strain_q = lower.gradients
        if problem.motion == "rolling":  # strains of the upstream cells
            direct = -(low_strain_q + up_strain_q)[:n]
            through = (low_strain_p - up_strain_p)[:n]
        else:  # displacements at the nodes; the shift takes up any constant
            (u1_p, u1_q), (u2_p, u2_q) = (r.tangent(mesh.columns) for r in (upper, lower))
            direct, through = -(u2_q + u1_q), u2_p - u1_p
        whole = mesh.middle * (a / contact_radius(problem.upper, problem.lower))
        gap, offset = whole, np.zeros(n)
        if not (problem.upper.linear and problem.lower.linear):
            slope, strain = (
                np.broadcast_to(one, (n + 2,)) for one in (upper.slope + lower.slope,
                                                           lower.strain - upper.strain)
            )  # fmt: skip
            gap, offset = gap - slope[:-1], offset + strain[:n]
        return cls(
            a, (up_p + low_p)[:-1], (up_q - low_q)[:-1], gap, float(np.max(whole)),
            direct, through, offset, a * mesh.grid.weights, upper, lower,
        )  # fmt: skip

    def indentation(self, p: Array, q: Array, shift: float) -> Array:
        """Return what pressures, tractions and shift leave of the gap's slope, (N,)."""
        return self.slope_p @ p + self.slope_q @ q + shift - self.gap

    def slips(self, p: Array, q: Array, creep: float) -> Array:
        """Return the slips of the nodes, (n,)."""
        return self.offset + self.direct @ q + self.through_pressure @ p + creep


@dataclass(frozen=True, eq=False)
class RollerEquations:
    """The equations for one half width, the normal problem solved; made by :meth:`at`."""

    problem: RollerProblem
    mesh: Mesh
    matrices: RollerMatrices
    normal: Array  # (N, 1 + n) rows p and shift; by the gap, and by unit tractions

    @classmethod
    def at(
        cls, problem: RollerProblem, mesh: Mesh, a: float, about: About = None
    ) -> RollerEquations:
        """Assemble the equations for the half width ``a`` [m] and solve the normal problem."""
        made = RollerMatrices.at(problem, mesh, a, about)
        return cls(problem, mesh, made, solve_normal(made.slope_p, made.gap, made.slope_q))

    @property
    def faces(self) -> Sequence[Array]:
        """Where the tractions are."""
        return (self.mesh.columns,)

    def stick_slip(self) -> StickSlip:
        """Return the stick-slip problem of the one face."""
        problem, made, n = self.problem, self.matrices, self.mesh.unknowns
        given = problem.creepage is not None
        return StickSlip(
            made.direct, made.through_pressure, made.offset + (problem.creepage or 0.0),
            self.normal[:-1, 0], self.normal[:-1, 1:],
            np.full(n, problem.friction), faces=1,
            creep=None if given else np.ones(n),
            resultant=None if given else made.weights,
            force=problem.tangential_load or 0.0,
        )  # fmt: skip

    def state(self, solution: StickSlipSolution) -> RollerState:
        """Return the state that belongs to solved tractions."""
        solved = self.normal[:, 0] + self.normal[:, 1:] @ solution.traction
        return RollerState(self.matrices.half_width, solution, solved[:-1], float(solved[-1]))

    def carried(self, state: RollerState) -> float:
        """Return the integral of the pressure [N/m]."""
        return float(self.matrices.weights @ state.pressure)

    def frictionless(self) -> float | None:
        """Return the integral of the pressure without tractions [N/m]."""
        return float(self.matrices.weights @ self.normal[:-1, 0])

    def imbalance(self, state: RollerState) -> float:
        """Return what the state leaves of the laws of bodies that are not linear, relative."""
        if self.problem.upper.linear and self.problem.lower.linear:
            return 0.0
        p, q, after = state.pressure, state.solution.traction, self.anew(state)
        slope = self.matrices.indentation(p, q, 0.0) - after.indentation(p, q, 0.0)
        return float(np.max(np.abs(slope))) / after.top

    def anew(self, state: RollerState) -> RollerMatrices:
        """Return the matrices for the same half width about a state."""
        return RollerMatrices.at(self.problem, self.mesh, self.matrices.half_width, state.known)
