"""What the equations of a winding nip and of two rollers have in common."""

from __future__ import annotations

from math import exp, inf, log, pi, prod
from typing import Any, NamedTuple

import numpy as np

from ..contact.newton import Jacobian
from ..elasticity.mesh import Face
from ..elasticity.surface import InterpolatedSurface, SurfaceResponse, SurfaceTangent
from .load_limit import frictionless_half_width

__all__ = ["ContactEquations", "Side", "nearest"]

Array = np.ndarray

# Step of ln a for the difference quotient (truncation error 1e-5, rounding 1e-10).
DIFFERENCE = 1e-5
# Bound of the estimated half width, relative to the largest one that the bodies permit.
BELOW_LARGEST = 0.9
# Distance in ln a of the second half width at which responses are computed, and the smallest one of
# two half widths between which they are interpolated: rounding errors are 1e-15 over it.
SECOND, NEAREST = 1e-4, 1e-7


class Side(NamedTuple):
    """One body on its part of the mesh."""

    face: Face
    surface: SurfaceResponse
    radius: float
    flattening: float  # 1/R^2 of a cylinder, 0 of a half-plane or a rigid body

    def displacement(self, slope: Array, p: Array, q: Array, a: float) -> Array:
        """Return the normal displacement v at the nodes [m]."""
        return self.face.displacement_at_nodes(slope, self.surface.end_displacement(p, q), a)

    def curvature(self, slope: Array, p: Array, q: Array, a: float) -> Array:
        """Return the curvature of the deformed surface at the nodes, 1/R - v'' - v/R^2."""
        out = 1 / self.radius + self.face.curvature_change(slope, a)
        if self.flattening:
            out -= self.flattening * self.displacement(slope, p, q, a)
        return out

    def curvature_tangent(
        self, tangent: SurfaceTangent, p: Array, q: Array, a: float
    ) -> tuple[Array, Array] | None:
        """Return the derivatives of the curvature by p and by q; None for a rigid body."""
        if self.surface.rigid:
            return None
        slopes = tangent.slope_p, tangent.slope_q
        by_p, by_q = (self.face.curvature_change(slope, a) for slope in slopes)
        if self.flattening:
            ends = self.surface.end_tangent(p, q)
            for out, slope, end in zip((by_p, by_q), slopes, ends, strict=True):
                out -= self.flattening * self.face.displacement_at_nodes(slope, end, a)
        return by_p, by_q


class ExactSurfaces(NamedTuple):
    """The surfaces of both bodies at one half width."""

    ln_a: float
    surfaces: tuple[SurfaceResponse, ...]


class ContactEquations:
    """The initial half width, the scales, and the dependence on the half width.

    Meshes are scaled by the half width a, so that the responses of the surfaces depend on it.  They
    are computed at some half widths and in between interpolated linearly in x = ln a,

        M(x) = M(x1) + (x - x1)/(x2 - x1) [M(x2) - M(x1)],

    with the error M'' (x - x1)(x - x2)/2, where M'' is of the size of M.  x1 and x2 are the latest
    two; with a single one M is constant, with an error of |x - x1|.  The derivative of the
    residuals by ln a contains the slope of this line.

    A subclass has the bodies for a half width, ``geometry(a, tolerance)``, and the residuals of
    unknowns u, ``state(u, geometry)``; its states hold the geometry.

    Parameters
    ----------
    problem : NipProblem or RollerProblem
    load : float
        P [N/m].
    guess : float
        Estimated half width [m].
    """

    largest_ln_a: Any
    ln_a: Any

    def __init__(self, problem: Any, load: float, guess: float) -> None:
        self.problem, self.load = problem, load
        self.guessed_half_width = a = min(guess, BELOW_LARGEST * exp(self.largest_ln_a))
        # scales: the maximum pressure of Hertz, and the slope of the gap at the contact edge
        self.pressure_scale, self.slope_scale = 2 * load / (pi * a), a / problem.contact_radius
        self._exact: list[ExactSurfaces] = []

    def geometry(self, a: float, tolerance: float = 0.0) -> Any:
        """Return the surfaces for a half width, with an error below a tolerance (:meth:`sides`).

        ``a`` is its first item.
        """
        raise NotImplementedError

    def state(self, u: Array, geometry: Any) -> Any:
        """Return the state of the unknowns u."""
        raise NotImplementedError

    def evaluate(self, u: Array, tolerance: float = 0.0) -> Any:
        """Return the state of the unknowns u with responses of a relative error below a tolerance.

        By default they are exact.
        """
        return self.state(u, self.geometry(exp(u[self.ln_a]), tolerance))

    def sides(self, a: float, faces: tuple[Face, Face], tolerance: float) -> list[Side]:
        """Return both bodies for a half width.

        Parameters
        ----------
        a : float
        faces : two Face
            Those of the mesh for ``a``.
        tolerance : float
            Relative error of interpolated responses above which they are computed; inf for
            interpolated ones, whatever their error.
        """
        ln_a, bodies = log(a), self.problem.bodies
        if self._interpolation_error(ln_a) > tolerance:
            speed = self.problem.rolling_speed
            pairs = zip(bodies, faces, strict=True)
            computed = tuple(self.surface_of(body, face, a, speed) for body, face in pairs)
            other = [known for known in self._exact if abs(known.ln_a - ln_a) > NEAREST]
            self._exact = [ExactSurfaces(ln_a, computed), *other[:1]]
        return [
            Side(face, surface, body.radius, 0.0 if body.rigid else body.curvature**2)
            for body, face, surface in zip(bodies, faces, self._surfaces(ln_a), strict=True)
        ]

    def _interpolation_error(self, ln_a: float) -> float:
        """Return the estimated relative error of interpolated responses.

        Those of nonlinear bodies, which cost an equilibrium each, are not interpolated.
        """
        distances = [abs(ln_a - known.ln_a) for known in self._exact]
        if 0 in distances:
            return 0.0
        is_known = distances and self.problem.linear
        return prod(distances) / len(distances) if is_known else inf

    def _surfaces(self, ln_a: float) -> tuple[SurfaceResponse, ...]:
        """Return the surfaces at a half width by interpolation."""
        for known in self._exact:
            if known.ln_a == ln_a or len(self._exact) == 1:
                return known.surfaces
        latest, other = self._exact
        share = (ln_a - latest.ln_a) / (other.ln_a - latest.ln_a)
        return tuple(
            one if one.rigid else InterpolatedSurface(one, two, share)
            for one, two in zip(latest.surfaces, other.surfaces, strict=True)
        )

    def surface_of(self, body: Any, face: Face, a: float, speed: float | None) -> SurfaceResponse:
        """Return the surface of a body on a face."""
        surface: SurfaceResponse = body.surface(face, a, speed)
        return surface

    def initial_half_width(self) -> float:
        """Return the half width of the frictionless contact [m].

        With nonlinear bodies it is the estimate ``guessed_half_width``.
        """
        problem, a = self.problem, self.guessed_half_width
        if not problem.linear:
            return a
        return frictionless_half_width(problem, self.load, a, exp(self.largest_ln_a))

    def fill_half_width_column(self, jacobian: Jacobian, state: Any) -> None:
        """Write the derivatives by ln a, by a difference quotient, into their column.

        The responses are interpolated: an error of 1 % in this column only slows the convergence.
        """
        a = state.geometry.a
        if len(self._exact) == 1:
            self.geometry(a * exp(SECOND))
        a *= exp(DIFFERENCE)
        shifted = self.state(state.u, self.geometry(a, inf))
        for name, matrix in jacobian._asdict().items():
            change = getattr(shifted, name) - getattr(state, name)
            matrix[:, self.ln_a] = change / DIFFERENCE


def nearest(old: Array, values: Array, new: Array) -> Array:
    """Return the values at the nearest of the old nodes."""
    return values[np.searchsorted((old[1:] + old[:-1]) / 2, new)]
