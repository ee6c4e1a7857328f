"""What the equations of a winding nip and of two rollers have in common."""

from __future__ import annotations

from functools import cached_property
from math import exp, inf, log, pi
from typing import Generic, NamedTuple, Protocol, TypeVar

import numpy as np

from ..contact.newton import Jacobian
from ..elasticity.mesh import Face
from ..elasticity.surface import SurfaceResponse, SurfacesByHalfWidth, SurfaceTangent
from ..problems.contact_problem import ContactProblem
from .layout import Unknowns
from .load_limit import frictionless_half_width, largest_half_width

__all__ = ["DIFFERENCE", "ContactEquations", "Side", "nearest"]

Array = np.ndarray

# Step of ln a for the difference quotient (truncation error 1e-5, rounding 1e-10).
DIFFERENCE = 1e-5
# Bound of the estimated half width, relative to the largest one that the bodies permit.
BELOW_LARGEST = 0.9
# Distance in ln a of the second half width at which responses are computed.
SECOND = 1e-4


class Side(NamedTuple):
    """One body on its part of the mesh."""

    face: Face
    surface: SurfaceResponse
    radius: float
    flattening: float  # 1/R^2 of a cylinder, 0 of a half-plane or a rigid body

    def displacement(self, slope: Array, p: Array, q: Array, a: float) -> Array:
        """Return the normal displacement v at the n nodes [m].

        ``slope`` is that at the points of the face, (n+1,), under the nodal loads p and q, (n,).
        """
        return self.face.displacement_at_nodes(slope, self.surface.end_displacement(p, q), a)

    def curvature(self, slope: Array, p: Array, q: Array, a: float) -> Array:
        """Return the curvature of the deformed surface at the n nodes, 1/R - v'' - v/R^2 [1/m].

        ``slope`` is that at the points of the face, (n+1,), under the nodal loads p and q, (n,).
        """
        out = 1 / self.radius + self.face.curvature_change(slope, a)
        if self.flattening:
            out -= self.flattening * self.displacement(slope, p, q, a)
        return out

    def curvature_tangent(
        self, tangent: SurfaceTangent, p: Array, q: Array, a: float
    ) -> tuple[Array, Array] | None:
        """Return the derivatives of the curvature at the nodes by p and by q, (n, n) each.

        In 1/(m Pa); None for a rigid body.
        """
        if self.surface.rigid:
            return None
        slopes = tangent.slope_p, tangent.slope_q
        by_p, by_q = (self.face.curvature_change(slope, a) for slope in slopes)
        if self.flattening:
            ends = self.surface.end_tangent(p, q)
            for out, slope, end in zip((by_p, by_q), slopes, ends, strict=True):
                out -= self.flattening * self.face.displacement_at_nodes(slope, end, a)
        return by_p, by_q


class WithHalfWidth(Protocol):
    """The bodies for a half width."""

    @property
    def a(self) -> float:
        """Half width [m]."""
        ...


class OfHalfWidth(Protocol):
    """The state of the unknowns ``u``, with the bodies for its half width."""

    @property
    def geometry(self) -> WithHalfWidth:
        """The bodies."""
        ...

    @property
    def u(self) -> Array:
        """Unknowns."""
        ...


Geometry = TypeVar("Geometry", bound=WithHalfWidth)
State = TypeVar("State", bound=OfHalfWidth)


class ContactEquations(Generic[Geometry, State]):
    """Equations of two bodies in contact: scales of the unknowns, and dependence on the half width.

    The derivative of the residuals by ln a contains that of the surfaces' responses
    (:class:`~woundon.elasticity.surface.SurfacesByHalfWidth`).

    A subclass has the bodies for a half width, ``geometry(a, tolerance)``, the residuals of
    unknowns u, ``state(u, geometry)``, whose states hold the geometry, and two attributes:

    layout : Unknowns
        Indices of the unknowns.
    friction : float or (k,) array
        Friction coefficients of the traction nodes.

    Parameters
    ----------
    problem : NipProblem or RollerProblem
    load : float
        P [N/m].
    guess : float
        Estimated half width [m].
    """

    layout: Unknowns
    friction: float | Array

    def __init__(self, problem: ContactProblem, load: float, guess: float) -> None:
        self.problem, self.load = problem, load
        self.guessed_half_width = a = min(guess, BELOW_LARGEST * exp(self.largest_ln_a[0]))
        # scales: the maximum pressure of Hertz, and the slope of the gap at the contact edge
        self.pressure_scale, self.slope_scale = 2 * load / (pi * a), a / problem.contact_radius
        self.slip_scale = self.slope_scale
        self.surfaces = SurfacesByHalfWidth(problem.bodies, problem.rolling_speed)

    # ---- interface of the semismooth Newton method ---------------------------------------------

    @cached_property
    def scales(self) -> Array:
        """Scales of the unknowns, (size,): the tractions' is the friction bound at Hertz's peak."""
        layout = self.layout
        out = np.full(layout.size, self.pressure_scale)
        out[layout.shift], out[layout.xi] = self.slope_scale, self.slip_scale
        out[layout.ln_a] = 1.0
        out[layout.q] *= self.friction
        return out

    @cached_property
    def traction_unknowns(self) -> Array:
        """Indices of the tractions in u, (k,)."""
        return np.arange(self.layout.q.start, self.layout.q.stop)

    @cached_property
    def ln_a(self) -> Array:
        """Index of ln a in u, (1,)."""
        return np.array([self.layout.ln_a])

    @cached_property
    def load_rows(self) -> Array:
        """Index of the load equation, the last one of the equilibrium equations, (1,)."""
        return np.array([self.layout.q.start - 1])  # xi and ln a have no rows of their own

    @cached_property
    def largest_ln_a(self) -> Array:
        """ln of the largest half width that the bodies permit, (1,)."""
        return np.array([log(largest_half_width(self.problem))])

    def evaluate(self, u: Array, tolerance: float = 0.0) -> State:
        """Return the state of the unknowns u with responses of a relative error below a tolerance.

        By default they are exact.
        """
        return self.state(u, self.geometry(exp(u[self.layout.ln_a]), tolerance))

    def fill_half_width_column(self, jacobian: Jacobian, state: State) -> None:
        """Write the derivatives by ln a, by a difference quotient, into their column.

        The responses are interpolated: an error of 1 % in this column only slows the convergence.
        """
        self.fill_column(jacobian, state, self.shifted(state))

    def shifted(self, state: State) -> State:
        """Return the state of the same unknowns for a larger ln a, by DIFFERENCE."""
        a = state.geometry.a
        if len(self.surfaces.computed) == 1:  # a second half width, to interpolate the responses
            self.geometry(a * exp(SECOND))
        return self.state_like(state, self.geometry(a * exp(DIFFERENCE), inf))

    def fill_column(self, jacobian: Jacobian, state: State, shifted: State) -> None:
        """Write the derivatives by ln a into their column from a state and the shifted one."""
        for name, matrix in jacobian._asdict().items():
            change = getattr(shifted, name) - getattr(state, name)
            matrix[:, self.layout.ln_a] = change / DIFFERENCE

    def initial_guess(self) -> tuple[Array, Array]:
        """Return unknowns u, (size,), with zero fields and the initial half width, and full stick.

        Full stick is the active set of k zeros.
        For linear bodies the first Newton step gives the fields for this half width.
        """
        u = np.zeros(self.layout.size)
        u[self.layout.ln_a] = log(self.initial_half_width())
        return u, np.zeros(self.layout.traction_count, dtype=np.int8)

    # ---- for subclasses ------------------------------------------------------------------------

    def geometry(self, a: float, tolerance: float = 0.0) -> Geometry:
        """Return the surfaces for a half width, with an error below a tolerance (:meth:`sides`).

        ``a`` is its first item.
        """
        raise NotImplementedError

    def state(self, u: Array, geometry: Geometry) -> State:
        """Return the state of the unknowns u."""
        raise NotImplementedError

    def state_like(self, state: State, geometry: Geometry) -> State:
        """Return the state of the same unknowns for another geometry."""
        return self.state(state.u, geometry)

    def sides(self, a: float, faces: tuple[Face, Face], tolerance: float) -> list[Side]:
        """Return both bodies for a half width.

        Parameters
        ----------
        a : float
            [m].
        faces : two Face
            Those of the mesh for ``a``.
        tolerance : float
            Relative error of the responses (:meth:`.SurfacesByHalfWidth.at`).
        """
        surfaces = self.surfaces.at(a, faces, tolerance)
        return [
            Side(face, surface, body.radius, 0.0 if body.rigid else body.curvature**2)
            for body, face, surface in zip(self.problem.bodies, faces, surfaces, strict=True)
        ]

    def initial_half_width(self) -> float:
        """Return the half width of the frictionless contact [m].

        With nonlinear bodies it is the estimate ``guessed_half_width``.
        """
        problem, a = self.problem, self.guessed_half_width
        if not problem.linear:
            return a
        return frictionless_half_width(problem, self.load, a, exp(self.largest_ln_a[0]))


def nearest(old: Array, values: Array, new: Array) -> Array:
    """Return the values at the old nodes that are nearest to the new nodes, (new.size,)."""
    return values[np.searchsorted((old[1:] + old[:-1]) / 2, new)]
