"""The roll of a winding, from the wound-on tension over the radius."""

from __future__ import annotations

import numpy as np

from ..errors import NoSteadyState
from ..problems.roll import RollProblem
from ..problems.schedules import Profile
from ..problems.winding import WindingProblem
from ..roll.solve import WoundRoll, solve_uncertified

__all__ = ["recomputed", "wind"]

Array = np.ndarray
STRAIGHT = 1e-13  # relative distance from a straight line below which a point lies on it


def wind(
    problem: WindingProblem,
    r: Array,
    tension: Array,
    rtol: float,
    film: float = 0.0,
    *,
    rotates: bool = True,
    changes: bool = True,
) -> WoundRoll:
    """Compute the roll of a piecewise linear wound-on tension, in the limit of thin layers.

    Parameters
    ----------
    problem : WindingProblem
    r, tension : (M,) arrays
        Radii [m], wound-on tension there [N/m].
    rtol : float
        Of the roll's pressure.
    film : float
        Of air between the layers, at ambient pressure [m].
    rotates : bool
        False neglects the centrifugal force.
    changes : bool
        False omits the changes after winding.

    Returns
    -------
    WoundRoll

    Raises
    ------
    NoSteadyState
        For a tension that is not positive everywhere.
    """
    roll = _roll_problem(problem, r, tension, film, rotates=rotates, changes=changes)
    return solve_uncertified(roll, rtol)


def recomputed(
    problem: WindingProblem,
    roll: WoundRoll,
    r: Array,
    tension: Array,
    film: float,
    *,
    changes: bool = True,
) -> WoundRoll:
    """Recompute a roll with another tension, at the same stages of its build-up.

    Parameters
    ----------
    problem : WindingProblem
    roll : WoundRoll
        Its stages are used.
    r, tension : (M,) arrays
        Radii [m], the other wound-on tension there [N/m].
    film : float
        Of air between the layers, at ambient pressure [m].
    changes : bool
        False omits the changes after winding.
    """
    return roll.wound_with(_roll_problem(problem, r, tension, film, changes=changes))


def _roll_problem(
    problem: WindingProblem,
    r: Array,
    tension: Array,
    film: float,
    *,
    rotates: bool = True,
    changes: bool = True,
) -> RollProblem:
    """Return the problem of the roll; reject a tension that holds no layer on it.

    ``r`` and ``tension`` are radii [m] and WOT there [N/m], (M,); other parameters as of
    :meth:`.WindingProblem.wound_roll`.
    """
    smallest, force = int(np.argmin(tension)), problem.centrifugal_tension
    if not tension[smallest] > force:
        least = f"{force:.6g} [N/m], the centrifugal force of the web" if force else "0"
        raise NoSteadyState.at(
            "tension_law" if isinstance(problem.tension_law, Profile) else "web_tension",
            f"the wound-on tension falls to {tension[smallest]:.6g} [N/m] at the radius "
            f"{r[smallest]:.6g} [m]; must be > {least}, or no layer is wound on",
        )
    return problem.wound_roll(_schedule(r, tension), film, rotates=rotates, changes=changes)


def _schedule(r: Array, tension: Array) -> float | Profile:
    """Return the tension over the radius without points on straight lines between others.

    A linear tension then has no spurious kinks.  ``r`` and ``tension`` are radii [m] and WOT there
    [N/m], (M,).
    """
    if np.ptp(tension) <= STRAIGHT * np.max(tension):
        return float(tension[0])
    nodes = [0]
    for k in range(1, r.size - 1):
        last = nodes[-1]
        t = (r[k] - r[last]) / (r[k + 1] - r[last])
        line = tension[last] + t * (tension[k + 1] - tension[last])
        # rounding of r next to another point bends the line, hence min(t, 1 - t)
        if abs(line - tension[k]) > STRAIGHT * tension[k] / min(t, 1 - t):
            nodes.append(k)
    nodes.append(r.size - 1)
    return Profile(radius=r[nodes], value=tension[nodes])
