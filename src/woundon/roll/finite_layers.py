"""Effects of finite layer thickness on a wound roll, relative to the limit of thin layers."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..errors import NotConverged
from .build_up import Layers
from .finished import add_constant, equations_of, final_changes

__all__ = ["finite_layer_effects", "finite_layer_stresses", "layers_of"]

Array = np.ndarray


def layers_of(result: Any) -> Layers:
    """Return layers with the web thickness of a result."""
    problem = result.problem
    return Layers(equations_of(problem), problem.tension_curve, float(problem.web_thickness))


def finite_layer_stresses(result: Any) -> tuple[Array, Array]:
    """Return the changes of pressure and hoop stress by layers of finite thickness [Pa].

    They are nan if kappa with such layers has not been computed.
    """
    x = np.log(result.radius)
    if np.isnan(result.layer_growth).any():
        return np.full(x.size, np.nan), np.full(x.size, np.nan)
    layers, (source_change, core_change) = layers_of(result), final_changes(result.problem)
    source = add_constant(layers.source(result.layer_kappa, x), source_change)
    T_c = layers.core_tension(x[0]) + core_change
    P, Q = result.pressure, result.pressure_gradient
    solved = layers.equations.solve(x, source, T_c, P, Q)
    if solved is None:
        raise NotConverged("the roll with layers of the web thickness could not be solved", result)
    return solved.P - P, (P + Q) - (solved.P + solved.Q)


def finite_layer_effects(result: Any) -> dict[str, float]:
    """Return the change by finite layers of each output that has an error estimate [Pa]."""
    pressure, hoop = finite_layer_stresses(result)
    middle = (result.radius[0] + result.radius[-1]) / 2
    return {
        "peak_pressure": float(np.max(np.abs(pressure))),
        "core_pressure": abs(float(pressure[0])),
        "mid_pressure": abs(float(np.interp(middle, result.radius, pressure))),
        "least_hoop_stress": abs(
            float(np.min(result.hoop_stress + hoop)) - result.least_hoop_stress
        ),
    }
