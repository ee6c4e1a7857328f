"""Strain of the roll's surface outside of a solved nip, and the tension estimate by eq. (183)."""

from __future__ import annotations

from math import pi
from typing import Any

import numpy as np

from ..errors import InvalidProblem
from .certificate import equations_of

__all__ = ["roll_strain", "wound_on_tension_estimate"]

Array = np.ndarray


def roll_strain(result: Any, s: Array) -> Array:
    """Return the tangential strain of the roll's surface under the tractions of the nip.

    Parameters
    ----------
    result : NipResult
    s : (k,) array
        Distance along the surface from the contact centre, > 0 downstream [m]; outside of the
        open interval (-a, a) and within half a circumference.

    Returns
    -------
    (k,) array
        eps_1 (thesis eqs. 32, 114).
    """
    s = np.atleast_1d(np.asarray(s, dtype=float))
    a, roll = result.half_width, result.problem.roll
    reach = pi * roll.radius
    if np.any(np.abs(s) < a * (1 - 1e-12)) or np.any(np.abs(s) > reach * (1 + 1e-12)):
        text = f"must lie outside the nip, {a:.4g} [m], and within pi R = {reach:.4g} [m]"
        raise InvalidProblem.at("s", text)
    if roll.rigid:
        return np.zeros(s.size)
    surface: Any = equations_of(result).geometry(a).roll.surface
    if not hasattr(surface, "strain_outside"):
        text = f"a {type(roll).__name__} has no strain outside of the nip; must be an elastic body"
        raise InvalidProblem.at("roll", text)
    return np.asarray(surface.strain_outside(result.roll_pressure, result.roll_traction, s))


def wound_on_tension_estimate(result: Any, angle: float) -> float:
    """Return the tension of a web that sticks to the roll up to an angle (thesis eq. 183) [N/m].

    The strain of the web follows that of the roll from the trailing edge to the angle where it is
    held or leaves: T_out + 2h/c11 [eps_1(angle) - eps_1(a)].

    Parameters
    ----------
    result : NipResult
    angle : float
        Downstream of the nip [rad].

    Raises
    ------
    InvalidProblem
        For an angle within the nip, or more than half a turn.
    """
    problem = result.problem
    edge = result.half_width / problem.roll.radius
    if not edge * (1 - 1e-12) <= angle <= pi * (1 + 1e-12):
        raise InvalidProblem.at(
            "angle",
            f"{angle:.6g} is out of range; must be >= {edge:.4g}, the trailing edge of the nip, "
            f"and <= {pi:.6g} [rad]",
        )
    far, near = roll_strain(result, np.array([angle * problem.roll.radius, result.half_width]))
    c11 = problem.web.compliance.c11
    return float(result.outlet_tension + problem.web.thickness / c11 * (far - near))
