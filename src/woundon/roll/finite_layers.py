"""Effects of finite layer thickness on a wound roll, relative to the limit of thin layers."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from ..errors import NotConverged
from .build_up import Layers
from .equations import interpolate_pressure
from .finished import FinalChanges, equations_of, finished_zones
from .roll_fields import RollFields
from .separation import solve_on_core
from .stage_nodes import cell_source

if TYPE_CHECKING:
    from ..problems.roll import RollProblem

__all__ = [
    "finite_layer_effects",
    "finite_layer_stresses",
    "layers_of",
    "with_bore_displacement",
]

Array = np.ndarray

NEIGHBOURHOOD = 0.15  # of the build-up, in which the largest error counts for the middle
FEW_LAYERS = 1000  # in a roll of more layers a node is the beginning of a layer


def layers_of(result: RollFields) -> Layers:
    """Return the layers of a result with the thickness of its web, in place of thin layers."""
    problem = result.problem
    return Layers(equations_of(problem), problem.tension_curve, float(problem.web_thickness))


def finite_layer_stresses(result: RollFields) -> tuple[Array, Array]:
    """Return the changes of pressure and hoop stress by layers of finite thickness, (M,) each [Pa].

    They are relative to the limit of thin layers, at the nodes of the result, and nan if kappa with
    layers of finite thickness has not been computed.
    """
    x = np.log(result.radius)
    if np.isnan(result.layer_growth).any():
        return np.full(x.size, np.nan), np.full(x.size, np.nan)
    layers, changes = layers_of(result), FinalChanges(result.problem)
    tension, h = layers.tension, layers.thickness
    source = changes.added_to(cell_source(tension, result.layer_kappa, x), x)
    T_c = float(tension.at(result.radius[:1])[0]) + changes.core
    P, Q, own = result.pressure, result.pressure_gradient, layers.own_pressure(x)
    # nothing presses on the outermost layer, nor on the ends of open zones, whose edges are kept
    zones = finished_zones(result.problem, P, Q)
    stage, part = zones.stage(x, source, T_c, -own), zones.nodes
    never_on_core = zones.off_core.copy()
    never_on_core[0] = result.problem.core_removed or part[0] > 0
    found = solve_on_core(layers.equations.at_rest, stage, P[part], Q[part], never_on_core)
    if found is None:
        raise NotConverged("the roll with layers of the web thickness could not be solved", result)
    solved = found[0]
    # r p' = h T'/2 - p, at a kink on its outer side
    side = np.append(np.ones(x.size - 1), -1)
    hoop_of_own = -h / 2 * tension.slope(result.radius, side)
    change = solved.P + (own - P)[part]
    hoop_change = (P + Q + hoop_of_own)[part] - (solved.P + solved.Q)
    return zones.spread(change, x.size), zones.spread(hoop_change, x.size)


def finite_layer_effects(result: RollFields) -> dict[str, float]:
    """Return the change by finite layers of each output that has an error estimate [SI].

    The hoop stress varies across a layer: its minimum is compared with that of a smooth curve
    through the layers, and at both faces of the layers.  The change may have a zero in the middle
    of the roll: its largest size in a neighbourhood counts.
    """
    change, hoop_change = finite_layer_stresses(result)
    r, build_up = result.radius, result.radius[-1] - result.radius[0]
    middle = r[0] + build_up * (0.5 + NEIGHBOURHOOD * np.array([-1.0, 1.0]))
    near_middle = (middle[0] <= r) & (r <= middle[1])
    size = np.abs(change) * _higher_order_factor(change, result.pressure)
    factor = _factor_at_core(result)
    size[0] = max(size[0], abs(change[0]) * factor)
    # the smooth curve, and the inner and the outer faces
    hoop = result.hoop_stress + hoop_change, *_hoop_stress_at_faces(result, change, hoop_change)
    least, bore = float(np.min(result.hoop_stress)), float(result.hoop_stress[0])
    at_bore = np.array([float(curve[0]) - bore for curve in hoop])
    # of exponential and of algebraic decay
    bore_factor = max(factor, float(np.max(_higher_order_factor(at_bore, np.array(abs(bore))))))
    effects = {
        "peak_pressure": float(np.max(size)),
        "core_pressure": float(size[0]),
        "mid_pressure": float(max(*np.interp(middle, r, size), *size[near_middle])),
        "least_hoop_stress": max(
            abs(float(np.min(curve)) - least) * (1.0 if np.argmin(curve) else bore_factor)
            for curve in hoop
        ),
        "bore_hoop_stress": float(np.max(np.abs(at_bore))) * bore_factor,
    }
    return with_bore_displacement(result.problem, effects)


def with_bore_displacement(problem: RollProblem, errors: Mapping[str, float]) -> dict[str, float]:
    """Return errors of a roll's outputs with that of the bore's displacement [m].

    The displacement is r_c times the change of the strain (sigma_t + nu P)/E_t at the bore, whose
    errors are those of ``bore_hoop_stress`` and ``core_pressure`` [Pa].
    """
    stack, r_c = problem.stack, problem.core.radius
    stress = errors["bore_hoop_stress"] + stack.poissons_ratio * errors["core_pressure"]
    return {**errors, "bore_displacement": r_c * stress / stack.tangential}


def _higher_order_factor(change: Array, pressure: Array) -> Array:
    """Return the factor of a change by finite layers that includes the terms of higher order.

    Where the pressure by a layer decreases as exp(-x) per layer below it, thin layers add up to
    P = p/x, and finite ones to p/(1 - exp(-x)): a relative change of x/(1 - exp(-x)) - 1, of which
    the term of first order is x/2.  The factor is between 1 and 2.
    """
    size = 2 * np.abs(change)
    # at most 1e4, also where the pressure is zero
    x = size / np.maximum(pressure, np.maximum(1e-4 * size, np.finfo(float).tiny))
    x = np.maximum(x, 1e-4)  # below, the factor is 1 + x/6
    return np.asarray((x / -np.expm1(-x) - 1) / (x / 2))


def _factor_at_core(result: RollFields) -> float:
    """Return the factor of a change at the core that includes the terms of higher order.

    At a soft core, b > 0, the pressure on it by a layer at s is p/(1 + b ln(s/r_c)), not an
    exponential: with z = r_c/(b h), the sum over layers is sum_n 1/(1 + n/z), and it exceeds the
    integral by z (ln z - digamma(z)) instead of 1/2.
    """
    from scipy.special import digamma

    b, h = equations_of(result.problem).core, float(result.problem.web_thickness)
    if b <= 0 or result.is_off_core:
        return 1.0
    z = result.problem.core.radius / (b * h)
    # for large z, ln z and digamma cancel: their difference is 1/(2 z) + 1/(12 z^2) - ...
    return 1 + 1 / (6 * z) if z > 100 else float(2 * z * (np.log(z) - digamma(z)))


def _hoop_stress_at_faces(
    result: RollFields, change: Array, hoop_change: Array
) -> tuple[Array, Array]:
    """Return the hoop stress at the inner and at the outer face of layers [Pa].

    The layers begin at the nodes, few layers at their own radii.  Equilibrium gives the mean hoop
    stress of a layer from the pressures on its faces.  In a layer, wound with the stress T under
    its own pressure P_own, the source of the equations of a stage is -T - E_t F(P_own), in a roll
    that is wound at a speed less nu c, plus dC by the changes after winding:

        r d sigma_t/dr = T + nu c - sigma_t - E_t (F(P) - F(P_own)) - dC = D,

    integrated by Simpson's rule from D at the inner face, in the middle and at the outer face.

    Parameters
    ----------
    result : RollResult
    change, hoop_change : (M,) arrays
        Of pressure and hoop stress by layers of finite thickness, at the nodes [Pa].

    Returns
    -------
    two (K,) arrays
    """
    layers, h = layers_of(result), float(result.problem.web_thickness)
    E_t, strain = layers.equations.tangential, layers.equations.strain
    changes, c = FinalChanges(result.problem), layers.thin.centrifugal
    x, P = np.log(result.radius), result.pressure + change
    Q = -(result.hoop_stress + hoop_change) - P
    core, surface = result.radius[[0, -1]].tolist()
    count = round((surface - core) / h)
    r = core + h * np.arange(count) if count <= FEW_LAYERS else result.radius
    r = r[r <= (surface - h) * (1 + 1e-12)]  # layers that end below the surface, or at it
    T = layers.tension.at(r)
    # pressure at the inner face, in the middle and at the outer face of the layers
    faces = [interpolate_pressure(x, P, Q, np.log(r + part * h))[0] for part in (0, 0.5, 1)]
    mean = (r * faces[0] - (r + h) * faces[2]) / h
    inner, middle, outer = (
        T
        + layers.thin.poissons_ratio * c
        - mean
        - E_t * (strain(P) - strain((T - c) * h / r * (1 - part)))
        - changes.source(np.log(r + part * h))
        for P, part in zip(faces, (0, 0.5, 1), strict=True)
    )
    share = h / (r + h / 2)  # the thickness of a layer in ln r
    return mean - share * (inner + 2 * middle) / 6, mean + share * (2 * middle + outer) / 6
