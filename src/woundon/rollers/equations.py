r"""The equations of two rollers on a mesh.

With the traction q on the upper roller along +x (and -q on the lower one)

    indentation, differentiated    v1' + v2' + Delta/R* = x/R*
    rolling                        slip = eps2 - eps1 + xi
    static                         slip = u2 - u1 + shift

and slip = 0 in stick, q = sgn(slip) mu p else.  The static problem is that of a load that only
grows; the pressure is taken to be there before the tangential load.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np

from ..contact.meshes import Mesh
from ..contact.response import Response, Tractions
from ..contact.stick_slip import StickSlip
from ..two_bodies import About, Matrices, PairEquations

__all__ = ["RollerEquations", "RollerMatrices"]

Array = np.ndarray


@dataclass(frozen=True, eq=False)
class RollerMatrices(Matrices):
    """The matrices of two rollers: one face, m = n."""

    @classmethod
    def of(
        cls, problem: Any, mesh: Mesh, a: float, one: Response, two: Response, about: About = None
    ) -> Self:
        """Assemble for the half width ``a`` [m] and given responses of upper and lower roller."""
        n, (up_p, up_q, up_strain_p, up_strain_q) = mesh.unknowns, one.gradients
        low_p, low_q, low_strain_p, low_strain_q = two.gradients
        if problem.motion == "rolling":  # strains of the upstream cells
            direct = -(low_strain_q + up_strain_q)[:n]
            through = (low_strain_p - up_strain_p)[:n]
        else:  # displacements at the nodes; the shift takes up any constant
            (u1_p, u1_q), (u2_p, u2_q) = (r.tangent(mesh.columns) for r in (one, two))
            direct, through = -(u2_q + u1_q), u2_p - u1_p
        gap, offset = mesh.middle * (a / problem.contact_radius), np.zeros(n)
        top = float(np.max(gap))
        if not problem.linear:
            rows = (n + 2,)
            gap = gap - np.broadcast_to(one.slope + two.slope, rows)[:-1]
            if problem.motion == "rolling":
                offset = offset + np.broadcast_to(two.strain - one.strain, rows)[:n]
            else:
                offset = offset + two.rest(mesh.columns)[1] - one.rest(mesh.columns)[1]
        return cls(
            a, (up_p + low_p)[:-1], (up_q - low_q)[:-1], gap, top, direct, through, offset,
            np.ones(n), a * mesh.grid.weights, (one, two),
        )  # fmt: skip

    @staticmethod
    def loads(p: Array, q: Array) -> tuple[Tractions, Tractions]:
        """Return what loads the upper and the lower roller."""
        return Tractions(p, q), Tractions(p, -q)


@dataclass(frozen=True, eq=False)
class RollerEquations(PairEquations):
    """The equations of two rollers for one half width, the normal problem solved."""

    made_of: ClassVar[type[Matrices]] = RollerMatrices

    def stick_slip(self) -> StickSlip:
        """Return the stick-slip problem of the one face."""
        problem, made, n = self.problem, self.matrices, self.mesh.unknowns
        given = problem.creepage is not None
        return StickSlip(
            made.direct, made.through_pressure, made.offset + (problem.creepage or 0.0),
            self.pressure, self.pressure_response, np.full(n, problem.friction), faces=1,
            creep=None if given else made.moves,
            resultant=None if given else made.weights,
            force=problem.tangential_load or 0.0,
        )  # fmt: skip

    def frictionless(self) -> float | None:
        """Return the load without tractions [N/m], which the normal problem tells."""
        return float(self.matrices.weights @ self.pressure) if self.problem.linear else None
