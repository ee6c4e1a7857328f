"""Residuals of a winding: nips, roll and the coupling between them."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..problems.schedules import Curve
from ..results import ACCEPTED_RESIDUAL, Residuals, largest, positive

__all__ = ["LARGEST_COUPLING_RTOL", "certificate"]

LARGEST_COUPLING_RTOL = 1e-2  # largest tolerance that may be requested of nips and roll


def certificate(result: Any) -> Residuals:
    """Compute the residuals of a result.

    roll
        Largest residual of the roll.
    roll_tension
        Difference between the tension of the roll and the reported wound-on tension, relative to
        the largest.
    nips
        Largest residual of any nip; infinite unless half-widths, pressures and friction
        coefficients are positive.
    coupling
        Relative difference between the wound-on tension of each nip and the reported tension minus
        its departure under fluctuating schedules; scaled so that ``coupling_rtol`` is 1e-8.
    air
        Difference between the air film of the layers and the mean film of the nips, relative to the
        web thickness; scaled so that ``coupling_rtol`` is 1e-8.
    tension_balance
        Residual of WOT = T_in + NIT, relative to the largest WOT.
    schedules
        Differences of T_in, P and F from the schedules, each relative to its largest value.
    reach
        Relative difference of the end radii from core and roll radius; 1 unless radii increase.
    """
    problem, r, roll = result.problem, result.radius, result.roll
    WOT = result.wound_on_tension
    wound = Curve(roll.problem.wound_on_tension, *problem.ends).at(r)
    tension = np.interp(result.nip_radius, r, WOT) - result.nip_departure
    mismatch = tension / result.nip_wound_on_tension - 1
    unit = max(float(np.max(np.abs(WOT))), 1e-300)
    steps = np.diff(r)
    # tolerances outside this range cannot be requested
    rtol = result.coupling_rtol
    scale = ACCEPTED_RESIDUAL / rtol if 0 < rtol <= LARGEST_COUPLING_RTOL else np.inf
    schedules = [
        largest(np.abs(getattr(result, name) - problem.at(name, r)))
        / max(float(np.max(np.abs(problem.at(name, r)))), 1e-300)
        for name in ("web_tension", "nip_load", "winding_force")
    ]
    return Residuals(
        roll=roll.certified().largest,
        roll_tension=largest(np.abs(wound - WOT)) / unit,
        nips=largest([largest(result.nip_residual), _positivity_residual(result)]),
        coupling=largest(np.abs(mismatch)) * scale,
        air=_air_film_residual(result) * scale,
        tension_balance=largest(np.abs(WOT - result.web_tension - result.nip_induced_tension))
        / unit,
        schedules=largest(schedules),
        reach=largest(
            [largest(np.abs(r[[0, -1]] / problem.ends - 1)), 0.0 if (steps > 0).all() else 1.0]
        ),
    )


def _positivity_residual(result: Any) -> float:
    """Return 0 if widths, pressures and friction of all nips are positive, else inf."""
    quantities = [result.nip_half_width, result.nip_peak_pressure, result.nip_friction]
    if result.problem.roll_body == "effective":
        quantities.append(result.nip_effective_pressure)
    return largest([positive(*quantities), 0.0 if (result.nip_residual >= 0).all() else np.inf])


def _air_film_residual(result: Any) -> float:
    """Return the difference of the air film from the mean film of the nips, over thickness."""
    r, h = result.nip_radius, result.nip_air_film
    mean = float(np.trapezoid(h * r, r) / np.trapezoid(r, r)) if r.size > 1 else 0.0
    return abs(result.air_film - mean) / float(result.problem.web.thickness)
