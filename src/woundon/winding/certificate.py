"""The certificate of a winding: nips, roll, and what binds them together."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..problems.schedules import Curve
from ..results import ACCEPTED_RESIDUAL, Residuals, largest, positive

__all__ = ["MOST_AGREED", "certificate"]

MOST_AGREED = 1e-2  # largest tolerance that may be requested of nips and roll


def certificate(result: Any) -> Residuals:
    """Measure every law of a result.

    roll
        The largest violation of a law of the roll, wound with the reported tension.
    roll_tension
        That it is this tension, at every radius; of the largest.
    nips
        The largest violation of a law of any nip; that their half-widths, pressures and frictions
        are positive.
    coupling
        That each nip, on the roll wound so far, has the reported tension, minus its departure
        under schedules that wander: to the requested tolerance ``agreed`` of it, which counts as
        1e-8.
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
    tension = np.interp(result.nip_radius, r, WOT) - result.nip_departure
    answers = tension / result.nip_wound_on_tension - 1
    unit = max(float(np.max(np.abs(WOT))), 1e-300)
    steps = np.diff(r)
    # no other tolerance can have been requested
    scale = ACCEPTED_RESIDUAL / result.agreed if 0 < result.agreed <= MOST_AGREED else np.inf
    schedules = [
        largest(np.abs(getattr(result, name) - problem.at(name, r)))
        / max(float(np.max(np.abs(problem.at(name, r)))), 1e-300)
        for name in ("web_tension", "nip_load", "winding_force")
    ]
    return Residuals(
        roll=roll.certified().largest,
        roll_tension=largest(np.abs(wound - WOT)) / unit,
        nips=largest([largest(result.nip_residual), _impossible(result)]),
        coupling=largest(np.abs(answers)) * scale,
        air=_air_missed(result) * scale,
        tension_balance=largest(np.abs(WOT - result.web_tension - result.nip_induced_tension))
        / unit,
        schedules=largest(schedules),
        reach=largest(
            [largest(np.abs(r[[0, -1]] / problem.ends - 1)), 0.0 if (steps > 0).all() else 1.0]
        ),
    )


def _impossible(result: Any) -> float:
    """Return 0 if the nips have widths, pressures and frictions that a nip can have, else inf."""
    quantities = [result.nip_half_width, result.nip_peak_pressure, result.nip_friction]
    if result.problem.roll_body == "effective":
        quantities.append(result.nip_felt_pressure)
    return largest([positive(*quantities), 0.0 if (result.nip_residual >= 0).all() else np.inf])


def _air_missed(result: Any) -> float:
    """Return by what of a lap the air between laps misses the mean of the nips' films."""
    r, h = result.nip_radius, result.nip_air_film
    mean = float(np.trapezoid(h * r, r) / np.trapezoid(r, r)) if r.size > 1 else 0.0
    return abs(result.air_film - mean) / float(result.problem.web.thickness)
