"""The nip's equations (:mod:`.equations`) at given tractions, without their matrices.

Where only a residual is asked for, by the certificate or on the way from one half width to another,
the bodies' responses to given tractions are a few products with vectors.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Self

import numpy as np

from ..contact.meshes import Mesh
from ..contact.response import Response, Tractions

__all__ = ["NipLaws"]

Array = np.ndarray


@dataclass(frozen=True, eq=False)
class NipLaws:
    """What a nip of linear bodies leaves of its equations; as :class:`~.equations.NipMatrices`."""

    problem: Any
    mesh: Mesh
    half_width: float
    responses: tuple[Response, Response]

    @classmethod
    def at(cls, problem: Any, mesh: Mesh, a: float) -> Self:
        """Return the laws for the half width ``a`` [m]."""
        one, two = (problem.respond(body, mesh, a) for body in problem.bodies)
        return cls(problem, mesh, a, (one, two))

    @property
    def gap(self) -> Array:
        """Slope of the gap, (N,)."""
        return self.mesh.middle * (self.half_width / self.problem.contact_radius)

    @property
    def top(self) -> float:
        """Largest slope of the gap."""
        return float(self.mesh.middle[-1] * (self.half_width / self.problem.contact_radius))

    @cached_property
    def weights(self) -> Array:
        """Integrate a traction over the contact, (n,) [m]."""
        return self.half_width * self.mesh.grid.weights

    @staticmethod
    def loads(p: Array, q: Array) -> tuple[Tractions, Tractions]:
        """Return what loads roll and drum."""
        return Tractions(p, q[: p.size]), Tractions(p, q[p.size :])

    def laws(self, p: Array, q: Array, shift: float, creep: float) -> tuple[Array, Array]:
        """Return what the surfaces leave of the gap's slope, (N,), and all slips, (2n + 2,)."""
        n, a, web = p.size, self.half_width, self.problem.web
        c12, stretch = web.compliance.c12, a * web.compliance.c11 / web.thickness
        # slope, value and behind of the pressure, then of the tractions together
        felt = (np.array([p, q[:n] + q[n:]]) @ self.mesh.web.T).reshape(6, -1)
        thinner = self.problem.thinning / a
        coefficients = [[thinner, 0.0, 0.0, 0.0, c12, 0.0], [0.0, -c12, 0.0, 0.0, 0.0, stretch]]
        miss, strain = np.array(coefficients) @ felt
        miss += shift - self.gap
        slips = np.empty(2 * n + 2)
        bodies = zip(self.problem.bodies, self.responses, strict=True)
        for face, (body, response) in enumerate(bodies):
            v = strain
            if not body.rigid:
                slope, own = response.act(p, q[face * n : (face + 1) * n])
                miss += slope[:-1]
                v = strain - own[:-1]
                if face == 0:  # the wound-on condition: from the trailing edge on
                    v += own[-1]
            slips[face * n : (face + 1) * n], slips[2 * n + face] = v[:-1], v[-1]
        slips[n : 2 * n] += creep
        slips[-1] += creep
        return miss, slips
