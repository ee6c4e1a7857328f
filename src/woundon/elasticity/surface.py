r"""Surface response of a body: slope and strain of its surface under pressure and traction.

A body touches the web on a :class:`~woundon.elasticity.mesh.Face` of a mesh that is scaled by the
half width a.  The nodal pressures p and tractions q displace its surface by v (outward) and u
(along +x).  The contact equations need, at the points of the face,

    slope  dv/dx          strain  du/dx + v/R   (du/dx on a half-plane)

and v at the trailing edge of the nip.  A :class:`SurfaceResponse` returns these values for given p
and q (``deform``, ``end_displacement``) and their derivatives.  A new body implements
``surface(face, half_width, speed)``, which returns such an object; :class:`LinearSurface` serves
any body whose influence matrices are known.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import inf, log, prod
from typing import NamedTuple, Protocol

import numpy as np

from .mesh import Face

__all__ = [
    "Deformation",
    "InterpolatedSurface",
    "LinearSurface",
    "RigidSurface",
    "SurfaceResponse",
    "SurfaceTangent",
    "SurfacesByHalfWidth",
]

Array = np.ndarray

# Smallest distance in ln a of two half widths between which surfaces are interpolated: rounding
# errors are 1e-15 over it.
NEAREST = 1e-7


class Deformation(NamedTuple):
    """Slope and strain at the n+1 points of a face."""

    slope: Array
    strain: Array


class SurfaceTangent(NamedTuple):
    """Derivatives of a :class:`Deformation` by nodal pressures and tractions, (n+1, n) [1/Pa]."""

    slope_p: Array
    slope_q: Array
    strain_p: Array
    strain_q: Array


class SurfaceResponse(Protocol):
    """The surface of a body on a face."""

    rigid: bool

    def deform(self, p: Array, q: Array) -> Deformation:
        """Return the deformation under nodal pressures and tractions, (n,) each [Pa]."""
        ...

    def tangent(self, p: Array, q: Array) -> SurfaceTangent:
        """Return the derivatives of ``deform`` at these pressures and tractions."""
        ...

    def end_displacement(self, p: Array, q: Array) -> float:
        """Return v at the trailing edge of the nip [m]."""
        ...

    def end_tangent(self, p: Array, q: Array) -> tuple[Array, Array]:
        """Return the derivatives of ``end_displacement`` by p and by q, (n,) each [m/Pa]."""
        ...

    def end_tangential_displacement(self, p: Array, q: Array) -> float:
        """Return u at the last node [m]; nan if it is not known.

        It is needed for the rigid displacement of static rollers only.
        """
        ...

    def tangent_outside(self, s: Array) -> SurfaceTangent:
        """Return the derivatives of slope and strain at positions s [m] outside, (k, n) each.

        It is needed for further nips on the same roll only; zero if it is not known.
        """
        ...


class LinearSurface:
    """The surface of a linear body with known influence matrices.

    Parameters
    ----------
    tangent : SurfaceTangent
    end : (2, n) array
        v at the trailing edge of the nip by unit pressures and by unit tractions [m/Pa].
    """

    rigid = False

    def __init__(self, tangent: SurfaceTangent, end: Array) -> None:
        self._tangent, self._end = tangent, end

    def deform(self, p: Array, q: Array) -> Deformation:
        """Return the influence matrices times the pressures and tractions."""
        slope_p, slope_q, strain_p, strain_q = self._tangent
        # dot: @ takes twice the time for small matrices
        return Deformation(slope_p.dot(p) + slope_q.dot(q), strain_p.dot(p) + strain_q.dot(q))

    def tangent(self, p: Array, q: Array) -> SurfaceTangent:
        """Return the influence matrices."""
        return self._tangent

    def end_displacement(self, p: Array, q: Array) -> float:
        """Return v at the trailing edge of the nip [m]."""
        return float(self._end[0].dot(p) + self._end[1].dot(q))

    def end_tangent(self, p: Array, q: Array) -> tuple[Array, Array]:
        """Return the influence functions of v at the trailing edge."""
        return self._end[0], self._end[1]

    def end_tangential_displacement(self, p: Array, q: Array) -> float:
        """Return nan: strains determine u up to a constant."""
        return float("nan")

    def tangent_outside(self, s: Array) -> SurfaceTangent:
        """Return zeros: the influence matrices are those of the face alone."""
        return SurfaceTangent(*np.zeros((4, s.size, self._end.shape[1])))


class RigidSurface(LinearSurface):
    """The surface of a body that does not deform."""

    rigid = True

    def __init__(self, face: Face) -> None:
        n = face.nodes.size
        none = np.zeros((n + 1, n))
        super().__init__(SurfaceTangent(none, none, none, none), np.zeros((2, n)))
        self._undeformed = Deformation(np.zeros(n + 1), np.zeros(n + 1))

    def deform(self, p: Array, q: Array) -> Deformation:
        """Return zeros."""
        return self._undeformed

    def end_tangential_displacement(self, p: Array, q: Array) -> float:
        """Return zero."""
        return 0.0


class InterpolatedSurface:
    """The surface of a body at a half width between two others, linear in its logarithm.

    Parameters
    ----------
    first, second : SurfaceResponse
        The body at two half widths, on faces with the same numbers of nodes.
    share : float
        Position between them: 0 at the first, 1 at the second.
    """

    rigid = False

    def __init__(self, first: SurfaceResponse, second: SurfaceResponse, share: float) -> None:
        self.first, self.second, self.share = first, second, share

    def deform(self, p: Array, q: Array) -> Deformation:
        """Return the interpolated deformation."""
        return Deformation(*self._between(self.first.deform(p, q), self.second.deform(p, q)))

    def tangent(self, p: Array, q: Array) -> SurfaceTangent:
        """Return the derivatives of ``deform``."""
        return SurfaceTangent(*self._between(self.first.tangent(p, q), self.second.tangent(p, q)))

    def end_displacement(self, p: Array, q: Array) -> float:
        """Return v at the trailing edge of the nip [m]."""
        one, two = (each.end_displacement(p, q) for each in (self.first, self.second))
        return one + self.share * (two - one)

    def end_tangent(self, p: Array, q: Array) -> tuple[Array, Array]:
        """Return the derivatives of ``end_displacement`` by p and by q, (n,) each [m/Pa]."""
        by_p, by_q = self._between(self.first.end_tangent(p, q), self.second.end_tangent(p, q))
        return by_p, by_q

    def end_tangential_displacement(self, p: Array, q: Array) -> float:
        """Return u at the last node [m]; nan if it is not known."""
        one, two = (each.end_tangential_displacement(p, q) for each in (self.first, self.second))
        return one + self.share * (two - one)

    def tangent_outside(self, s: Array) -> SurfaceTangent:
        """Return the derivatives of slope and strain at positions s [m] outside, (k, n) each."""
        one, two = (each.tangent_outside(s) for each in (self.first, self.second))
        return SurfaceTangent(*self._between(one, two))

    def _between(self, first: Sequence[Array], second: Sequence[Array]) -> list[Array]:
        """Return the interpolated arrays."""
        return [one + self.share * (two - one) for one, two in zip(first, second, strict=True)]


class HasSurface(Protocol):
    """A body, as :class:`SurfacesByHalfWidth` uses it."""

    @property
    def linear(self) -> bool:
        """True if the surface responds linearly."""
        ...

    def surface(self, face: Face, half_width: float, speed: float | None) -> SurfaceResponse:
        """Return the response of the surface where it touches the web."""
        ...


class SurfacesByHalfWidth:
    """The surfaces of several bodies at any half width a, interpolated between computed ones.

    Meshes are scaled by the half width, so that the responses M of the surfaces depend on it.  They
    are computed at some half widths, and in between interpolated linearly in x = ln a,

        M(x) = M(x1) + (x - x1)/(x2 - x1) [M(x2) - M(x1)],

    with the error M'' (x - x1)(x - x2)/2, where M'' is of the size of M.  x1 and x2 are the latest
    two; with a single one M is constant, with an error of |x - x1|.

    Parameters
    ----------
    bodies : sequence of Body
        Surfaces of nonlinear bodies, which cost an equilibrium each, are not interpolated.
    speed : float, optional
        V [m/s], on which viscoelastic bodies depend.
    """

    def __init__(self, bodies: Sequence[HasSurface], speed: float | None = None) -> None:
        self.bodies, self.speed = bodies, speed
        # (x, surfaces) at one or two half widths, the latest first
        self.computed: list[tuple[float, tuple[SurfaceResponse, ...]]] = []

    def surface_of(
        self, body: HasSurface, face: Face, a: float, speed: float | None
    ) -> SurfaceResponse:
        """Compute the surface of a body on a face."""
        return body.surface(face, a, speed)

    def at(self, a: float, faces: Sequence[Face], tolerance: float) -> tuple[SurfaceResponse, ...]:
        """Return the surfaces at a half width.

        Parameters
        ----------
        a : float
            [m].
        faces : sequence of Face
            Of the mesh for ``a``, one for each body.
        tolerance : float
            Relative error of interpolated responses above which they are computed; inf for
            interpolated ones, whatever their error.
        """
        x = log(a)
        if self._interpolation_error(x) > tolerance:
            pairs = zip(self.bodies, faces, strict=True)
            surfaces = tuple(self.surface_of(body, face, a, self.speed) for body, face in pairs)
            other = [known for known in self.computed if abs(known[0] - x) > NEAREST]
            self.computed = [(x, surfaces), *other[:1]]
        for known_x, surfaces in self.computed:
            if known_x == x or len(self.computed) == 1:
                return surfaces
        (x1, first), (x2, second) = self.computed
        return tuple(
            one if one.rigid else InterpolatedSurface(one, two, (x - x1) / (x2 - x1))
            for one, two in zip(first, second, strict=True)
        )

    def _interpolation_error(self, x: float) -> float:
        """Return the estimated relative error of responses at ln a = x without computing them."""
        distances = [abs(x - known_x) for known_x, _ in self.computed]
        if 0 in distances:
            return 0.0
        if not distances or not all(body.linear for body in self.bodies):
            return inf
        return prod(distances) / len(distances)
