"""Closed forms of the strength of layers and cores; sources in docs/theory/margins.md."""

from __future__ import annotations

from math import nan, pi

import numpy as np

from ..problems.materials import Isotropic
from ..problems.roll import Core

__all__ = [
    "coil_set",
    "collapse_pressure",
    "ring_inertia",
    "sliding_layers_buckling_stress",
    "torque_carried",
    "torque_share",
]

Array = np.ndarray
THIN = 10  # ratio of radius to thickness above which the thin-tube formula is used


def torque_carried(
    r: Array, s: float, tension: float, density: float, acceleration: float
) -> Array:
    """Return the torque through the layers at radii, per metre of width [N].

    The sum of the torque from the core and of the inertia of the layers outside the radius.

    Parameters
    ----------
    r : (M,) array
        [m].
    s : float
        The roll's surface [m].
    tension : float
        Pulled by the core at the surface [N/m].
    density, acceleration : float
        Of the web [kg/m^3], [m/s^2].
    """
    return abs(tension) * s + ring_inertia(r, s, density) * acceleration / s


def ring_inertia(inner: float | Array, outer: float | Array, density: float) -> Array:
    """Return the moment of inertia of a ring about its axis, per metre of width [kg m].

    Parameters
    ----------
    inner, outer : float or (k,) array
        Radii [m].
    density : float
        [kg/m^3].
    """
    return np.asarray(pi / 2 * density * (np.asarray(outer) ** 4 - np.asarray(inner) ** 4))


def torque_share(r: Array, P: Array, friction: float | Array, torque: Array) -> Array:
    """Return the torque over what friction carries, 2 pi r^2 mu P, at radii, (k,) [1].

    Parameters
    ----------
    r, P : (k,) arrays
        Radii [m], pressure between the layers [Pa]; friction carries nothing where it is < 0.
    friction : float or (k,) array
        Coefficient of friction mu between the layers [1].
    torque : (k,) array
        Through the cylinder of layers at each radius, per metre of width [N].
    """
    capacity = 2 * pi * np.asarray(r) ** 2 * friction * np.maximum(P, 0)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(torque > 0, torque / capacity, 0.0)


def coil_set(membrane: float, bending: float, yield_strain: float) -> float:
    """Return the curvature that a web keeps after winding, relative to that of the roll [1].

    The web is elastic and perfectly plastic, with the strain e_0 of its tension and the bending
    strain e_b = h/2r at its faces.  At eta = 2 z/h the stress relative to that of yield is

        s = a + k eta, at most 1 and at least -1,    k = e_b/e_y,    int s d eta = 2 e_0/e_y,

    and without moment the web springs back elastically by (3/2) int s eta d eta relative to k.  In
    pure bending 1 - 3/(2 k) + 1/(2 k^3) remains (Timoshenko, Strength of Materials II, plastic
    bending).

    Parameters
    ----------
    membrane, bending, yield_strain : float
        e_0, e_b and e_y [1]; e_0 < e_y.

    Returns
    -------
    float
        0 if nothing yields.
    """
    t, k = membrane / yield_strain, bending / yield_strain
    if t + k <= 1:
        return 0.0
    # the outer face yields beyond eta = outer, the inner one, if it does, below inner
    outer = 2 * np.sqrt((1 - t) / k) - 1
    inner = -1.0
    if k * (outer + 1) > 2:
        outer, inner = 1 / k - t, -1 / k - t
    a = 1 - k * outer
    elastic = a * (outer**2 - inner**2) / 2 + k * (outer**3 - inner**3) / 3
    moment = (1 - outer**2) / 2 + elastic - (inner**2 - 1) / 2
    return float(1 - 1.5 * moment / k)


def sliding_layers_buckling_stress(
    radial: float, tangential: float, thickness: float, depth: float
) -> float:
    """Return the buckling stress of a zone of layers that slide freely on each other [Pa].

    An estimate: each layer is a beam on the elastic foundation of its neighbours; the zone is
    uniform and is bounded on both faces by layers in tension.  At the wave number q the load is

        N = E_t h^3/12 q^2 + k/q^2,    k = 4 E_r/h sin^2(pi/(2 (n + 1))),    n h = depth

    (the softest mode of n layers on n + 1 springs E_r/h), at minimum 2 (k E_t h^3/12)^(1/2).  While
    friction prevents sliding, the shear modulus of the stack adds a much larger resistance.

    Parameters
    ----------
    radial, tangential : float
        E_r and E_t [Pa].
    thickness, depth : float
        Of the web, and of the zone in compression [m].
    """
    k = 4 * radial / thickness * np.sin(pi / (2 * (depth / thickness + 1))) ** 2
    return float(2 * np.sqrt(k * tangential * thickness**3 / 12) / thickness)


def collapse_pressure(core: Core) -> float:
    """Return the collapse pressure of a long thin tube [Pa]; nan for other cores.

    E/(4 (1 - nu^2)) (t/r)^3, r the mean radius, for r/t > 10: Saunders and Windenberg (1931), after
    Roark, table 35, case 19a.
    """
    if core.inner_radius is None or not isinstance(core.material, Isotropic):
        return nan
    t, r = core.radius - core.inner_radius, (core.radius + core.inner_radius) / 2
    E, nu = core.material.youngs_modulus, core.material.poissons_ratio
    return E / (4 * (1 - nu**2)) * (t / r) ** 3 if r / t > THIN else nan
