"""What the surface of the wound roll does outside the nip, from a solved nip."""

from __future__ import annotations

from dataclasses import replace
from math import pi
from typing import TYPE_CHECKING, Any

import numpy as np

from ..contact.grid import Grid
from ..contact.response import Response, Tractions
from ..contact.schemes import interpolation_rank
from ..errors import InvalidProblem
from ..two_bodies import restored_mesh

if TYPE_CHECKING:
    from ..problems.nip import NipProblem
    from .result import NipResult

__all__ = ["roll_strain", "strain_outside", "wound_on_tension_estimate"]

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
    response = strain_outside(result.problem, restored_mesh(result).grid, a, s, loads)
    _, _, strain_p, strain_q = response.gradients
    strain = response.strain + strain_p @ loads.pressure + strain_q @ loads.traction
    return np.asarray(strain)


def strain_outside(
    problem: NipProblem, grid: Grid, a: float, s: Array, about: Tractions
) -> Response:
    """Return what the roll answers outside a nip; see :func:`roll_strain`.

    Parameters
    ----------
    problem : NipProblem
    grid : Grid
        Of the nip.
    a : float
        Half width [m].
    s : (k,) array
        Distances from the contact's centre [m].
    about : Tractions
        On the inner nodes, about which a roll that is not linear is linearised.
    """
    return problem.respond(problem.roll, _Outside(grid.outside(s / a)), a, about)


class _Outside:
    """A nip's nodes with points outside it, where smooth parts are integrated node by node."""

    def __init__(self, grid: Grid) -> None:
        self.grid, self.nodes, self.points = grid, grid.nodes, grid.points
        self.columns = grid.nodes[1:-1]
        self.value = self.slope = np.zeros((grid.points.size, grid.unknowns))

    def integrated(self, kernels: Any, curvature: float, radius: float, a: float) -> Response:
        """Return the gradients at the points by influence functions."""
        straight = a * (self.points[:, None] - self.columns)
        # beyond half the circumference the way round is shorter: the whole kernel is periodic
        far = np.abs(straight) > pi * radius if curvature else np.zeros(straight.shape, dtype=bool)
        short = straight - np.where(far, np.sign(straight) * 2 * pi * radius, 0.0)

        too_short = interpolation_rank(kernels.length, a) > self.grid.highest_rank

        def whole(kernel: Any) -> Array:
            if too_short and kernel.twice is not None:
                out = self.grid.by_second_integral(kernel.twice, a)
                return out if kernel.lag is None else out + self.grid.lagging(kernel.lag, a)[0]
            out = self.grid.integrate(replace(kernel, smooth=None), a)
            if kernel.smooth is not None:
                values = kernel.smooth(short)
                values[far] += kernel.singular(short[far]) - kernel.singular(straight[far])
                out += values * (a * self.grid.weights)
            return out

        slope_p, slope_q, strain_p, strain_q = map(whole, kernels.gradients)
        return Response((slope_p, slope_q, strain_p, strain_q))


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
