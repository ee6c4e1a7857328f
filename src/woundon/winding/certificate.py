"""The certificate of a winding: nips, roll, and what binds them together."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..contact.certificate import largest
from ..problems.schedules import Curve
from ..results import ACCEPTED_RESIDUAL, Residuals

if TYPE_CHECKING:
    from .result import WindingResult

__all__ = ["certificate"]


def certificate(result: WindingResult) -> Residuals:
    """Measure every law of a result.

    roll
        The largest violation of a law of the roll, wound with the tension told.
    roll_tension
        That it is this tension, at every radius told; of the largest.
    nips
        The largest violation of a law of any nip.
    coupling
        That each nip, on the roll wound so far, answers the tension told, less by what that departs
        under schedules that wander: to ``agreed`` of it, which counts as 1e-8.
    air
        That the laps hold the mean of the nips' films: to ``agreed`` of a lap, which counts as
        1e-8.
    tension_balance
        That WOT - T_in is the nip-induced tension, of the largest WOT.
    schedules
        That T_in, P and F are the problem's, each of its largest.
    reach
        That the radii go from the core to the finished roll, and rise.
    """
    problem, r, roll = result.problem, result.radius, result.roll
    WOT = result.wound_on_tension
    wound = Curve(roll.problem.wound_on_tension, *problem.ends).at(r)
    told = np.interp(result.nip_radius, r, WOT) - result.nip_departure
    answers = told / result.nip_wound_on_tension - 1
    unit = max(float(np.max(np.abs(WOT))), 1e-300)
    steps = np.diff(r)
    return Residuals(
        roll=roll.certified().largest,
        roll_tension=largest(np.abs(wound - WOT)) / unit,
        nips=largest(result.nip_residual),
        coupling=largest(np.abs(answers)) * ACCEPTED_RESIDUAL / result.agreed,
        air=_air_missed(result) * ACCEPTED_RESIDUAL / result.agreed,
        tension_balance=largest(np.abs(WOT - result.web_tension - result.nip_induced_tension))
        / unit,
        schedules=max(
            largest(np.abs(getattr(result, name) - problem.at(name, r)))
            / max(float(np.max(np.abs(problem.at(name, r)))), 1e-300)
            for name in ("web_tension", "nip_load", "winding_force")
        ),
        reach=max(
            largest(np.abs(r[[0, -1]] / problem.ends - 1)), 0.0 if (steps > 0).all() else 1.0
        ),
    )


def _air_missed(result: WindingResult) -> float:
    """Return by what of a lap the air between laps misses the mean of the nips' films."""
    r, h = result.nip_radius, result.nip_air_film
    mean = float(np.trapezoid(h * r, r) / np.trapezoid(r, r)) if r.size > 1 else 0.0
    return abs(result.air_film - mean) / float(result.problem.web.thickness)
