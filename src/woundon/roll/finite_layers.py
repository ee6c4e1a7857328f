r"""Errors by the thickness of the layers of a wound roll.

Pressures and stresses contain the thickness h of the layers to first order (:mod:`.build_up`).  The
error by terms of higher order is estimated from the change by those of first order, relative to the
limit of thin layers under the same stress.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from ..errors import NotConverged
from .equations import interpolate_pressure
from .finished import (
    FinalChanges,
    additional_pressure,
    core_gap,
    equations_of,
    finished_zones,
    layers_of,
    middle_of_layers,
)
from .roll_fields import RollFields
from .separation import solve_on_core
from .stage_nodes import cell_source, evaluate_in_cells

if TYPE_CHECKING:
    from ..problems.roll import RollProblem

__all__ = [
    "finite_layer_errors",
    "finite_layer_stresses",
    "is_surely_off_core",
    "with_bore_displacement",
]

Array = np.ndarray

NEIGHBOURHOOD = 0.15  # of the build-up, in which the largest error counts for the middle
SAFETY = 1.5  # of the terms of higher order, which are estimated for layers of constant moduli
# Error by the law of the stack within a layer, relative to the change by the mean of F in it: at
# most 0.04 against sums over layers.
LAW_SHARE = 0.05


def finite_layer_stresses(result: RollFields) -> tuple[Array, Array]:
    """Return the changes of pressure and hoop stress by the layer thickness, (M,) each [Pa].

    They are relative to the limit of thin layers, at the nodes of the result, and nan if kappa in
    this limit has not been computed.
    """
    x = np.log(result.radius)
    if np.isnan(result.thin_layer_growth).any():
        return np.full(x.size, np.nan), np.full(x.size, np.nan)
    layers, changes = layers_of(result.problem), FinalChanges(result.problem)
    thin = layers.at_rest.thin
    source = changes.added_to(cell_source(thin.tension, result.thin_layer_kappa, x), x)
    T_c = float(thin.tension.at(result.radius[:1])[0]) + changes.core
    P, Q = result.pressure, result.pressure_gradient
    # the ends of open zones are kept
    zones = finished_zones(result.problem, P, Q)
    stage, part = zones.stage(thin, x, source, T_c), zones.nodes
    never_on_core = zones.off_core.copy()
    never_on_core[0] = result.problem.core_removed or part[0] > 0
    found = solve_on_core(thin.equations, stage, P[part], Q[part], never_on_core)
    if found is None:
        text = (
            "the roll in the limit of thin layers, for the error estimate, has no solution: "
            "the stack at low pressure, or the core, is too soft for this tension"
        )
        raise NotConverged(text, result)
    thin_P, thin_Q = (zones.spread(values, x.size) for values in found[0][:2])
    middle = np.log(middle_of_layers(result.radius, result.radius, layers.thickness))
    return P - thin_P, result.hoop_stress + sum(interpolate_pressure(x, thin_P, thin_Q, middle))


def finite_layer_errors(result: RollFields) -> dict[str, float]:
    """Return the error by the layer thickness of each output that has an error estimate [SI].

    It is that by the terms of higher order.  The change by those of first order may have a zero:
    the largest error in a neighbourhood counts.
    """
    change, _ = finite_layer_stresses(result)
    r, x = result.radius, np.log(result.radius)
    layers = layers_of(result.problem)
    h = layers.thickness
    # a layer's pressure decreases per layer below it by exp(-decrease)
    decrease = np.abs(2 + result.kappa(x)) * h / r
    # of the curve through the faces of the layers, at most its second difference on three of them
    _, slope = additional_pressure(result)
    curvature = np.abs(np.gradient(slope, x)) * (h / r) ** 2 / 12
    inner, middle, outer = (
        interpolate_pressure(x, result.pressure, result.pressure_gradient, np.log(faces))[0]
        for faces in (np.minimum(r + k * h, r[-1]) for k in range(3))
    )
    curvature = np.minimum(curvature, np.abs(outer - 2 * middle + inner))
    higher_orders = SAFETY * np.maximum(
        np.abs(change) * _higher_orders_of(change, result.pressure - change),
        layers.own_pressure(x) * _higher_orders(decrease),
    )
    size = curvature + higher_orders
    # of P + r P'; the curvature jumps at kinks of the tension
    slope = np.abs(np.gradient(higher_orders, x)) + _change_by_a_layer(r, h, curvature) * r / h
    of_hoop = SAFETY * (size + slope)
    at_core = SAFETY * (_factor_at_core(result.problem) - 1)
    if not result.is_off_core:
        size[0] = max(size[0], abs(change[0]) * at_core)
    of_law, of_law_hoop = (LAW_SHARE * values for values in _change_by_mean_compression(result))
    # r P' jumps by h/2 times a jump of T', within a layer by no more than T changes there
    jump = np.abs(layers.own_slope(x, 1) - layers.own_slope(x, -1))
    jump = np.minimum(jump, _change_by_a_layer(r, h, layers.tension.at(r)))
    of_hoop = of_hoop + of_law_hoop
    size = size + of_law
    # at a soft core r P' is determined by P
    of_hoop[0] = max(of_hoop[0], abs(1 + layers.equations.core) * size[0])

    def largest(values: Array, centre: float) -> float:
        """Return the largest value in the neighbourhood of a radius [m]."""
        ends = centre + NEIGHBOURHOOD * (r[-1] - r[0]) * np.array([-1.0, 1.0])
        near = (ends[0] <= r) & (r <= ends[1])
        return float(max(*np.interp(ends, r, values), *values[near]))

    def of_layer(radius: float) -> float:
        """Return the largest error of the hoop stress in the neighbourhood of a layer [Pa]."""
        return largest(of_hoop, radius) + float(np.max(jump[np.abs(r - radius) <= h]))

    errors = {
        "peak_pressure": float(np.max(size)),
        "core_pressure": float(size[0]),
        "mid_pressure": largest(size, (r[0] + r[-1]) / 2),
        "least_hoop_stress": of_layer(float(r[np.argmin(result.hoop_stress)])),
        "bore_hoop_stress": of_layer(float(r[0])),
    }
    if is_surely_off_core(result, errors["bore_hoop_stress"]):
        errors["core_pressure"] = 0.0
    errors = with_bore_displacement(result.problem, errors)
    # of the first layer, which pressed on the core with 2 p
    first = 2 * float(layers.own_pressure(x[:1])[0]) / result.problem.core.effective_stiffness
    errors["bore_displacement"] += float(r[0]) * first * at_core
    return errors


def is_surely_off_core(result: RollFields, hoop_error: float) -> bool:
    """Return True if the gap to the core is larger than it may be by an error of the bore.

    The pressure on the core is then exactly zero.  ``hoop_error`` is that of the hoop stress at the
    bore [Pa].
    """
    bore_error = result.problem.core.radius * hoop_error / result.problem.stack.tangential
    # the gap is nan if the core is removed
    return result.is_off_core and not core_gap(result) <= bore_error


def _change_by_a_layer(r: Array, thickness: float, values: Array) -> Array:
    """Return the larger change of values at radii (M,) to the layer below and above."""
    outer, inner = (
        np.interp(np.clip(r + step, r[0], r[-1]), r, values) for step in (thickness, -thickness)
    )
    return np.maximum(np.abs(outer - values), np.abs(values - inner))


def with_bore_displacement(problem: RollProblem, errors: Mapping[str, float]) -> dict[str, float]:
    """Return errors of a roll's outputs with that of the bore's displacement [m].

    The displacement is r_c times the change of the strain (sigma_t + nu P)/E_t at the bore, whose
    errors are those of ``bore_hoop_stress`` and ``core_pressure`` [Pa].
    """
    stack, r_c = problem.stack, problem.core.radius
    stress = errors["bore_hoop_stress"] + stack.poissons_ratio * errors["core_pressure"]
    return {**errors, "bore_displacement": r_c * stress / stack.tangential}


def _change_by_mean_compression(result: RollFields) -> tuple[Array, Array]:
    """Return the changes of P and P + r P' if F(p) were the mean of F in a layer, (M,) each [Pa].

    In a layer as it is wound the pressure is between 0 and 2 p.  By Simpson's rule the mean of F
    exceeds F(p) by (F(2 p) - 2 F(p))/6.
    """
    layers, x = layers_of(result.problem).at_rest, np.log(result.radius)

    def source(points: Array, _: Array) -> Array:
        """Return the change of the source at ln r [Pa]."""
        p, F = layers.own_pressure(points), layers.equations.strain
        return np.asarray(layers.equations.tangential * (F(2 * p) - 2 * F(p)) / 6)

    zones = finished_zones(result.problem, result.pressure, result.pressure_gradient)
    P, Q = layers.equations.linear_response(
        zones.stage(layers, x, evaluate_in_cells(x, source), 0.0),
        *(values[zones.nodes] for values in additional_pressure(result)),
    )
    return zones.spread(np.abs(P), x.size), zones.spread(np.abs(P + Q), x.size)


def _higher_orders(x: Array) -> Array:
    """Return the terms of higher order in a sum over layers, relative to that of first order.

    Where the pressure by a layer decreases as exp(-x) per layer below it, thin layers add up to
    P = 2 p/x, and finite ones to 2 p/(1 - exp(-x)) = 2 p/x + p + p x/6 - ...: the terms after p,
    over p, are between 0 and 1.
    """
    x = np.maximum(x, 1e-4)  # below, digits cancel
    return np.asarray(2 / -np.expm1(-x) - 2 / x - 1)


def _higher_orders_of(change: Array, thin: Array) -> Array:
    """Return :func:`_higher_orders` for a change p of first order, and thin layers, 2 p/x [Pa]."""
    size = 2 * np.abs(change)
    # at most 1e4, also where the pressure is zero
    return _higher_orders(size / np.maximum(thin, np.maximum(1e-4 * size, np.finfo(float).tiny)))


def _factor_at_core(problem: RollProblem) -> float:
    """Return the factor of a change at the core that includes the terms of higher order.

    At a soft core, b > 0, the pressure on it by a layer at s is p/(1 + b ln(s/r_c)), not an
    exponential: with z = r_c/(b h), the sum over layers is sum_n 1/(1 + n/z), and it exceeds the
    integral by z (ln z - digamma(z)) instead of 1/2.
    """
    from scipy.special import digamma

    b, h = equations_of(problem).core, float(problem.web_thickness)
    if b <= 0:
        return 1.0
    z = problem.core.radius / (b * h)
    # for large z, ln z and digamma cancel: their difference is 1/(2 z) + 1/(12 z^2) - ...
    return 1 + 1 / (6 * z) if z > 100 else float(2 * z * (np.log(z) - digamma(z)))
