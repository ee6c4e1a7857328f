"""What the surface of the wound roll does outside the nip, from a solved nip."""

from __future__ import annotations

from functools import cached_property
from math import exp, pi
from typing import TYPE_CHECKING, Any

import numpy as np

from ..contact.action import Action
from ..contact.grid import Grid
from ..contact.meshes import interpolation_rank
from ..contact.response import Gradients, Response, Tractions
from ..errors import InvalidProblem
from ..two_bodies import restored_mesh

if TYPE_CHECKING:
    from ..problems.nip import NipProblem
    from .result import NipResult

__all__ = ["Outside", "Rise", "roll_strain", "wound_on_tension_estimate"]

Array = np.ndarray


def roll_strain(result: NipResult, s: Array) -> Array:
    """Return the tangential surface strain of the wound roll under the nip's tractions.

    Parameters
    ----------
    result : NipResult
    s : (k,) array
        Distance along the surface from the contact centre, downstream > 0 [m]; outside the open
        interval (-a, a) and within half a circumference.

    Returns
    -------
    (k,) array
        eps_theta1 (thesis eqs. 32, 114).
    """
    s = np.atleast_1d(np.asarray(s, dtype=float))
    a, roll = result.half_width, result.problem.roll
    reach = pi * roll.radius
    if np.any(np.abs(s) < a * (1 - 1e-12)) or np.any(np.abs(s) > reach * (1 + 1e-12)):
        text = f"must lie outside the nip, {a:.4g} [m], and within pi R = {reach:.4g} [m]"
        raise InvalidProblem.at("s", text)
    loads = Tractions(result.pressure[1:-1], result.roll_traction[1:-1])
    outside = Outside(restored_mesh(result).grid, s / a)
    response = result.problem.respond(roll, outside, a, loads)
    return np.asarray(response.strain + response.act(*loads)[1])


class Outside:
    """A nip's nodes with points outside it, where smooth parts are integrated node by node.

    Parameters
    ----------
    nip : Grid
    points : (k,) array
        In half widths.
    """

    def __init__(self, nip: Grid, points: Array) -> None:
        self.grid = grid = nip.outside(points)
        self.nodes, self.points = grid.nodes, grid.points
        self.columns = grid.nodes[1:-1]
        self.value = self.slope = np.zeros((grid.points.size, grid.unknowns))

    def integrated(self, kernels: Any, curvature: float, radius: float, a: float) -> Response:
        """Return the response at the points by influence functions."""
        grid, rank = self.grid, interpolation_rank(kernels.length, a)
        by_parts = rank <= grid.highest_rank or any(k.twice is None for k in kernels.gradients)
        apart, around = a * (self.points[:, None] - self.columns), 2 * pi * radius
        # beyond half the circumference the way round is shorter: the whole kernel is periodic
        far = np.abs(apart) > around / 2 if curvature else np.zeros(apart.shape, dtype=bool)
        short = np.where(far, apart - np.sign(apart) * around, apart)

        def smooth() -> Array:
            if kernels.smooth is None:
                return np.zeros((4, *apart.shape))
            values = kernels.smooth(short)
            if far.any():
                for kernel, value in zip(kernels.gradients, values, strict=True):
                    value[far] += kernel.singular(short[far]) - kernel.singular(apart[far])
            return np.asarray(values * (a * grid.weights))

        def gradients() -> Gradients:
            made = grid.integrate_together(kernels.gradients, None, a, rank, kernels.lag)
            slope_p, slope_q, strain_p, strain_q = made + smooth() if by_parts else made
            return slope_p, slope_q, strain_p, strain_q

        def act(p: Array, q: Array) -> tuple[Array, Array]:
            slope, strain = Action(grid, kernels.gradients, None, a, 0)(p, q)
            slope_p, slope_q, strain_p, strain_q = smooth()
            return slope + slope_p @ p + slope_q @ q, strain + strain_p @ p + strain_q @ q

        alone = by_parts and kernels.lag is None
        return Response(gradients, act=(lambda: act) if alone else None)


class Rise:
    """The roll's strain where the web is led off less that at the trailing edge, and its changes.

    Under given loads, of a nip and of neighbouring ones.

    Parameters
    ----------
    problem : NipProblem
    grid : Grid
        Of the nip.
    a : float
        Half width [m].
    angle : float
        Where the web is led off, behind the nip [rad].
    loads : Tractions
        Of the roll.
    """

    def __init__(
        self, problem: NipProblem, grid: Grid, a: float, angle: float, loads: Tractions
    ) -> None:
        self.problem, self.grid, self.half_width = problem, grid, a
        self.angle, self.loads = angle, loads

    def of(self, problem: NipProblem, a: float) -> float:
        """Return the rise of a problem and half width under the loads."""
        own = self.problem
        same = problem.roll == own.roll and problem.rolling_speed == own.rolling_speed
        return self._here if same and a == self.half_width else self._of(problem, a)

    def gradients(self, step: float) -> tuple[Array, Array, float]:
        """Return the rise's changes by pressures and tractions, (n,) each, and by ln a."""
        _, _, strain_p, strain_q = self._response(self.problem, self.half_width).gradients
        wider = self.of(self.problem, self.half_width * exp(step))
        return (
            strain_p[0] - strain_p[1], strain_q[0] - strain_q[1], (wider - self._here) / step,
        )  # fmt: skip

    @cached_property
    def _here(self) -> float:
        return self._of(self.problem, self.half_width)

    def _of(self, problem: NipProblem, a: float) -> float:
        response = self._response(problem, a)
        far, edge = response.strain + response.act(*self.loads)[1]
        return float(far - edge)

    def _response(self, problem: NipProblem, a: float) -> Response:
        radius, outside = problem.roll.radius, self._outside
        if a != self.half_width or radius != self.problem.roll.radius:
            outside = self._led_off(radius, a)
        return problem.respond(problem.roll, outside, a, self.loads)

    @cached_property
    def _outside(self) -> Outside:
        return self._led_off(self.problem.roll.radius, self.half_width)

    def _led_off(self, radius: float, a: float) -> Outside:
        return Outside(self.grid, np.array([self.angle * radius / a, 1.0]))


def wound_on_tension_estimate(result: NipResult, angle: float) -> float:
    """Estimate the tension of a web that sticks to the roll up to an angle (thesis eq. 183) [N/m].

    The web's strain follows the roll's from the trailing edge to where it is held or leaves:
    T_out + 2h/c11 [eps1(angle) - eps1(a)].

    Parameters
    ----------
    result : NipResult
    angle : float
        Behind the nip [rad].

    Raises
    ------
    InvalidProblem
        For an angle within the nip, or beyond half a turn.
    """
    problem = result.problem
    edge_angle = result.half_width / problem.roll.radius
    if not edge_angle * (1 - 1e-12) <= angle <= pi * (1 + 1e-12):
        text = (
            f"{angle:.6g} is out of range; must be >= {edge_angle:.4g}, the nip's trailing edge, "
        )
        raise InvalidProblem.at("angle", f"{text}and <= {pi:.6g} [rad]")
    c11 = problem.web.compliance.c11
    far, edge = roll_strain(result, np.array([angle * problem.roll.radius, result.half_width]))
    return float(result.tension_behind_nip + problem.web.thickness / c11 * (far - edge))
