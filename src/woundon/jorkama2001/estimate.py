"""Tension estimated downstream of a nip without wraps (thesis eq. 183).

The web sticks to the roll from the trailing edge to the angle where it is held or leaves, so that
its strain changes as that of the roll's surface under the tractions of the nip:

    T(angle) = T_out + 2h/c11 [eps_1(angle) - eps_1(a)].

With T_out it brackets the wound-on tension of the same nip with a roll wrap.
"""

from __future__ import annotations

from math import nan, pi
from typing import TYPE_CHECKING

import numpy as np

import woundon as wo

from .influence import surface_strain

if TYPE_CHECKING:
    from .procedure import ProcedureResult

__all__ = ["RIG_ANGLE", "rig_tension", "wound_on_tension_estimate"]

# Angle downstream of the nip at which the laboratory winder leads the web to a load cell [rad].
RIG_ANGLE = pi / 2


def wound_on_tension_estimate(result: wo.NipResult | ProcedureResult, angle: float = pi) -> float:
    """Return the tension of a web that sticks to the roll up to an angle (thesis eq. 183) [N/m].

    Parameters
    ----------
    result : NipResult or ProcedureResult
        With a rigid roll, a half-plane or a cylinder.
    angle : float
        Downstream of the nip [rad].

    Returns
    -------
    float
        nan of a nip with wraps, whose wound-on tension is solved.

    Raises
    ------
    InvalidProblem
        For an angle within the nip, or more than half a turn.

    Examples
    --------
    >>> import woundon as wo
    >>> from woundon.jorkama2001.estimate import wound_on_tension_estimate
    >>> nip = wo.solve(wo.NipProblem.example().replace(roll_wrap=0.0), nodes=65)
    >>> print(f"{nip.outlet_tension:.0f} to {wound_on_tension_estimate(nip):.0f} N/m")
    609 to 744 N/m
    """
    problem, a = result.problem, result.half_width
    if problem.is_wrapped:
        return nan
    R, c11 = problem.roll.radius, problem.web.compliance.c11
    if not a / R * (1 - 1e-12) <= angle <= pi * (1 + 1e-12):
        text = (
            f"{angle:.6g} is out of range; must be >= {a / R:.4g}, the trailing edge of the nip, "
            f"and <= {pi:.6g} [rad]"
        )
        raise wo.InvalidProblem([("angle", text)])
    points = np.array([angle * R, a])
    far, near = surface_strain(
        problem.roll, result.x, result.drum_pressure, result.roll_traction, points
    )
    return float(result.outlet_tension + problem.web.thickness / c11 * (far - near))


def rig_tension(result: wo.NipResult | ProcedureResult) -> float:
    """Return the estimate (183) a quarter turn downstream, at the laboratory's load cell [N/m]."""
    return wound_on_tension_estimate(result, RIG_ANGLE)
