"""What the surface of the wound roll does outside the nip, from a solved nip."""

from __future__ import annotations

from math import pi
from typing import TYPE_CHECKING, Any

import numpy as np

from ..contact.action import Action
from ..contact.grid import Grid
from ..contact.response import Gradients, Response, Tractions
from ..contact.schemes import interpolation_rank
from ..errors import InvalidProblem
from ..two_bodies import restored_mesh

if TYPE_CHECKING:
    from .result import NipResult

__all__ = ["Outside", "roll_strain", "wound_on_tension_estimate"]

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

        return Response(gradients, act=act if by_parts and kernels.lag is None else None)


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
