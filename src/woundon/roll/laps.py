"""What laps of finite thickness change in a roll, against the limit of thin ones."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..errors import NotConverged
from .build_up import Laps
from .finished import equations_of, final_changes, shifted

__all__ = ["changed_by_laps", "finite_laps", "laps_of"]

Array = np.ndarray


def laps_of(result: Any) -> Laps:
    """Return laps as thick as the web of a result."""
    problem = result.problem
    return Laps(equations_of(problem), problem.tension_curve, float(problem.web_thickness))


def finite_laps(result: Any) -> tuple[Array, Array]:
    """Return what they add to pressure and hoop stress [Pa]; nan in a roll that is not solved."""
    x = np.log(result.radius)
    if np.isnan(result.lap_growth).any():
        return np.full(x.size, np.nan), np.full(x.size, np.nan)
    laps, (more, at_core) = laps_of(result), final_changes(result.problem)
    source, T_c = shifted(laps.source(result.kappa_of_laps, x), more), laps.at_core(x[0]) + at_core
    P, Q = result.pressure, result.pressure_gradient
    solved = laps.equations.solve(x, source, T_c, P, Q)
    if solved is None:
        raise NotConverged("the roll with laps as thick as the web could not be solved", result)
    return solved.P - P, (P + Q) - (solved.P + solved.Q)


def changed_by_laps(result: Any) -> dict[str, float]:
    """Return how much they change each output that has an error estimate [Pa]."""
    pressure, hoop = finite_laps(result)
    middle = (result.radius[0] + result.radius[-1]) / 2
    return {
        "peak_pressure": float(np.max(np.abs(pressure))),
        "core_pressure": abs(float(pressure[0])),
        "mid_pressure": abs(float(np.interp(middle, result.radius, pressure))),
        "least_hoop_stress": abs(
            float(np.min(result.hoop_stress + hoop)) - result.least_hoop_stress
        ),
    }
