"""What the equations of a winding nip and of two rollers have in common."""

from __future__ import annotations

from math import exp, log, pi
from typing import Any, NamedTuple

import numpy as np

from ..elasticity.mesh import Face
from ..elasticity.surface import SurfaceResponse, SurfaceTangent
from .load_limit import frictionless_half_width

__all__ = ["ContactEquations", "Side", "nearest", "side_of"]

Array = np.ndarray

# Step of ln a for the difference quotient (truncation error 1e-5, rounding 1e-10).
DIFFERENCE = 1e-5
# Bound of the estimated half width, relative to the largest one that the bodies permit.
BELOW_LARGEST = 0.9
# Distance in ln a within which the surfaces of an earlier half width are used for the difference.
NEAREST, FARTHEST = 1e-7, 1e-2


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


def side_of(body: Any, face: Face, a: float, speed: float | None) -> Side:
    """Return a body on a face for the half width a."""
    flattening = body.curvature**2 if not body.rigid else 0.0
    return Side(face, body.surface(face, a, speed), body.radius, flattening)


class ContactEquations:
    """The initial half width, the scales, and the derivatives by ln a.

    A subclass has the bodies for a half width, ``geometry(a)``, and the residuals of unknowns u,
    ``evaluate(u, geometry)``; its states hold the geometry.

    Parameters
    ----------
    problem : NipProblem or RollerProblem
    load : float
        P [N/m].
    guess : float
        Estimated half width [m].
    """

    largest_ln_a: Any

    def __init__(self, problem: Any, load: float, guess: float) -> None:
        self.problem, self.load = problem, load
        self.guessed_half_width = a = min(guess, BELOW_LARGEST * exp(self.largest_ln_a))
        # scales: the maximum pressure of Hertz, and the slope of the gap at the contact edge
        self.pressure_scale, self.slope_scale = 2 * load / (pi * a), a / problem.contact_radius
        self._neighbour: Any = None

    def geometry(self, a: float) -> Any:
        """Return the surfaces for a half width; ``a`` is its first item."""
        raise NotImplementedError

    def evaluate(self, u: Array, geometry: Any = None) -> Any:
        """Return the state of the unknowns u."""
        raise NotImplementedError

    def initial_half_width(self) -> float:
        """Return the half width of the frictionless contact [m].

        With nonlinear bodies it is the estimate ``guessed_half_width``.
        """
        problem, a = self.problem, self.guessed_half_width
        if not problem.linear:
            return a
        return frictionless_half_width(problem, self.load, a, exp(self.largest_ln_a))

    def half_width_column(self, state: Any) -> tuple[Array, Array, Array]:
        """Return the derivatives of equilibrium, slip and bound by ln a as a difference quotient.

        The surfaces of an earlier half width are used if it is near: an error of 1 % in this column
        only slows the convergence of one step.
        """
        a, neighbour = state.geometry.a, self._neighbour
        if neighbour is None or not NEAREST < abs(log(neighbour.a / a)) < FARTHEST:
            neighbour = self._neighbour = self.geometry(a * exp(DIFFERENCE))
        shifted, step = self.evaluate(state.u, neighbour), log(neighbour.a / a)
        return (
            (shifted.equilibrium - state.equilibrium) / step,
            (shifted.slip - state.slip) / step,
            (shifted.bound - state.bound) / step,
        )


def nearest(old: Array, values: Array, new: Array) -> Array:
    """Return the values at the nearest of the old nodes."""
    return values[np.searchsorted((old[1:] + old[:-1]) / 2, new)]
