r"""Density of a wound roll over its radius.

A layer wound at s with the stress T loads the roll below by T h/s.  The surface moves inwards by
(1 + kappa) T h/E_t, and the layer itself is compressed by F(p), p = T h/2s, so that the radius
increases by less than the layer thickness,

    ds = h_0 g dn,    g = 1 - (1 + kappa) T/E_t - F(p),    h_0 = h/(1 - F(p_c)),

where h_0 is the thickness without pressure of a web that has the thickness h under the pressure
p_c.  The length of this web, stretched by T/E_t, is dL = 2 pi s ds/(h_0 g (1 + T/E_t)), and its
mass is dm = rho h dL.  Divided by the increase of the roll volume, it is the density that a density
analyser measures during winding, from the diameter and the length of web on the roll.  Divided by
the final volume of these layers, at r + u, it is the density of the finished roll, in which

    du/dr = 1 - g + eps_r,    eps_r = -F(P) - nu sigma_t/E_t + e_r + eps_g

(eps_g by gaps between open layers) follows from the equations (:mod:`.equations`), so that a layer
of the finished roll has the thickness h_0 (1 + eps_r) to first order of the strains, h (1 - (F(P) -
F(p_c))) without the other parts of eps_r: mass is conserved, and a layer under the pressure p_c has
the thickness h.
"""

from __future__ import annotations

from math import pi

import numpy as np

from ..elasticity.quadrature import gauss_points
from .finished import FinalChanges, layers_of, opening
from .roll_fields import RollFields

__all__ = [
    "density_during_winding",
    "finished_density",
    "mean_over_length",
    "volume",
    "wound_length",
    "wound_mass",
]

Array = np.ndarray
GAUSS = 4  # points of a cell


def _winding_strains(result: RollFields, r: Array) -> tuple[Array, Array]:
    """Return 1 - g and T/E_t at radii r (k,) [m], two (k,) arrays [1].

    The first is by how much less than its thickness a layer wound there increases the radius,
    relative to it; the second is the strain of the web as wound.
    """
    x, layers = np.log(r), layers_of(result.problem)
    strain = layers.tension.at(r) / layers.equations.tangential
    compression = layers.equations.strain(layers.own_pressure(x))
    return (1 + result.kappa(x)) * strain + compression, strain


def _length_per_volume(result: RollFields, r: Array) -> Array:
    """Return the length of web per increase of the roll volume at radii (k,) [m], (k,) [1/m].

    It is dL/(2 pi s ds) = 1/(h_0 g (1 + T/E_t)), h_0 the thickness of the web without pressure.

    It is nan where the surface moves inwards by more than the layer thickness, which is outside the
    range of small strains.
    """
    inward, strain = _winding_strains(result, r)
    g = np.where(inward < 1, 1 - inward, np.nan)
    return np.asarray(1 / (result.problem.unloaded_thickness * g * (1 + strain)))


def density_during_winding(result: RollFields, r: Array) -> Array:
    """Return the mass of web per increase of the roll volume at radii (k,) [m], (k,) [kg/m^3].

    It is nan without the density of the web, and outside the range of small strains.
    """
    density, h = result.problem.density, result.problem.web_thickness
    return (np.nan if density is None else density) * h * _length_per_volume(result, r)


def finished_density(result: RollFields) -> Array:
    """Return the density of the finished roll at the nodes, (M,) [kg/m^3]; nan if unknown."""
    problem, r = result.problem, result.radius
    stack, hoop = problem.stack, result.hoop_stress
    radial_strain = (
        -stack.radial.strain_at(result.pressure)
        - stack.poissons_ratio / stack.tangential * hoop
        + FinalChanges(problem).through(r)
        + opening(result)
    )
    du_dr = _winding_strains(result, r)[0] + radial_strain
    volume_ratio = (1 + result.displacement / r) * (1 + du_dr)
    return np.asarray(density_during_winding(result, r) / volume_ratio)


def mean_over_length(r: Array, values: Array) -> float:
    """Return the mean of values at radii, (k,) each, over the length of web between them.

    The length of a layer is proportional to its radius r: int v r dr/int r dr by the trapezoidal
    rule.  It is the value at a single radius, and 0 without any.
    """
    if r.size < 2:
        return float(values[0]) if r.size else 0.0
    return float(np.trapezoid(values * r, r) / np.trapezoid(r, r))


def wound_length(result: RollFields) -> float:
    """Return the length of web without stress of all layers [m]."""
    # cells between neighbouring nodes and stages: kappa is smooth between two stages
    r, weights = gauss_points(np.union1d(result.radius, result.stage_radius), GAUSS)
    return float(weights @ (2 * pi * r * _length_per_volume(result, r)))


def wound_mass(result: RollFields) -> float:
    """Return the mass of the web without stress of all layers [kg/m]; nan without its density."""
    density = result.problem.density
    if density is None:
        return float("nan")
    return wound_length(result) * float(result.problem.web_thickness) * float(density)


def volume(result: RollFields) -> float:
    """Return the volume of the finished roll, per metre of width [m^2]."""
    inner, outer = (result.radius + result.displacement)[[0, -1]].tolist()
    return pi * float(outer**2 - inner**2)
