"""What the surface of the wound roll does outside the nip, from a solved nip."""

from __future__ import annotations

from dataclasses import replace
from math import pi

import numpy as np

from .contact.grid import Grid
from .elasticity.strip import compliance
from .errors import InvalidProblem
from .results import NipResult

__all__ = ["rig_tension", "roll_strain"]

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
    if np.any(np.abs(s) < a * (1 - 1e-12)) or np.any(np.abs(s) > pi * roll.radius * (1 + 1e-12)):
        raise InvalidProblem(
            [
                (
                    "s",
                    f"must lie outside the nip, {a:.4g} [m], and within pi R = "
                    f"{pi * roll.radius:.4g} [m]",
                )
            ]
        )
    kernels = roll.surface(float(np.max(np.abs(s))) + a)
    grid = Grid(result.x / a, s / a)
    strain = np.zeros(s.size)
    for kernel, traction in (
        (kernels.strain_p, result.pressure[1:-1]),
        (kernels.strain_q, result.roll_traction[1:-1]),
    ):
        strain += grid.integrate(replace(kernel, smooth=None), a) @ traction
        if kernel.smooth is not None:
            strain += kernel.smooth(s[:, None] - result.x[None, 1:-1]) @ (
                a * grid.weights * traction
            )
    return strain


def rig_tension(result: NipResult, angle: float = pi / 2) -> float:
    """Estimate the tension of a web led off the roll to a load cell (thesis eq. 183) [N/m].

    The web is taken to stick to the roll from the trailing edge to the point where it leaves, so
    its strain follows the roll's: T_out + 2h/c11 [eps1(angle) - eps1(a)].

    Parameters
    ----------
    result : NipResult
    angle : float
        Where the web leaves the roll, behind the nip [rad].
    """
    problem = result.problem
    c11 = compliance(*problem.web.material.stiffness[:3]).c11
    far, edge = roll_strain(result, np.array([angle * problem.roll.radius, result.half_width]))
    return float(result.wound_on_tension + problem.web.thickness / c11 * (far - edge))
