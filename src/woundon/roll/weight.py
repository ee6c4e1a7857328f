r"""The weight of a finished roll on its core, or on a floor.

The core carries the weight W = rho g pi (R^2 - r_c^2) of the layers, per width.  If the layers and
the core slide on each other without friction, a cylindrical surface at r carries the weight W(r)
of the layers outside it by its pressure alone.  Gravity is a load of the first harmonic in the
angle theta from the top, so that in linear elasticity only this harmonic of the pressure changes,
and balance determines its amplitude:

    p = P + p_1 cos(theta),    W(r) = int p_1 cos^2(theta) r d theta = pi r p_1

The layers part locally, at the bottom, where p_1 > P, that is where

    W(r)/(pi r P) = rho g (R^2 - r^2)/(r P) > 1.

With friction shear carries a part of the weight, half of it if both tractions have the same
amplitude, so that the ratio is an upper bound.  The mean pressure of the weight on the projected
core is W/(2 r_c).

A roll on a rigid floor is flattened over the width 2 a of a line contact (Hertz; Johnson, Contact
Mechanics, 1985, eq. 4.43 with 1/E* = C/2),

    a^2 = 2 C(P_e) W R/pi,     p_max = 2 W/(pi a),

with the compliance C of the stack at the pressure P_e of the model "effective" of a winding: the
mean of the wound pressure down to the depth a and PEAK_COEFFICIENT p_max.
"""

from __future__ import annotations

from math import exp, isnan, log, nan, pi

import numpy as np

from ..elasticity.half_plane import coefficients
from ..problems.two_drums import GRAVITY
from .density import wound_mass
from .roll_fields import RollFields
from .stages import stresses_between

__all__ = ["DEPTHS", "PEAK_COEFFICIENT", "flat_width", "weight_of_layers", "weight_share"]

Array = np.ndarray

PEAK_COEFFICIENT = 0.25  # of p_max in P_e
DEPTHS = 33  # at which the wound pressure is averaged
# Ends of the search for a, relative to R: the smaller one is below any load of interest.
NARROWEST, WIDEST = 1e-6, 0.5
# At the surface P and the weight outside both vanish: share of the build-up that is left out, and
# number of radii.
OUTERMOST, PLACES = 1e-3, 400


def weight_of_layers(result: RollFields, r: Array) -> Array:
    """Return the weight of the layers outside radii (k,) [m] per width, (k,) [N/m].

    It is nan without the density of the web.  The density of the roll is taken as uniform.
    """
    core, R = float(result.radius[0]), float(result.radius[-1])
    share = (R**2 - np.asarray(r, dtype=float) ** 2) / (R**2 - core**2)
    return np.asarray(GRAVITY * wound_mass(result) * share)


def weight_share(result: RollFields) -> float:
    """Return the largest W(r)/(pi r P) of a roll result on its core [1].

    It is infinite where the layers are open, and nan without the density of the web and off the
    core, which then carries nothing.
    """
    if result.problem.density is None or result.is_off_core:
        return nan
    core, R = float(result.radius[0]), float(result.radius[-1])
    r = np.append(result.radius[:-1], np.linspace(core, R - OUTERMOST * (R - core), PLACES))
    P = stresses_between(result, r)["pressure"]
    with np.errstate(divide="ignore"):
        return float(np.max(weight_of_layers(result, r) / (pi * r * np.maximum(P, 0.0))))


def flat_width(result: RollFields) -> float:
    """Return the width 2 a over which the roll is flattened by its weight on a rigid floor [m].

    It is nan without the density of the web, and for a roll so soft that it has no such contact.
    """
    from scipy.optimize import brentq

    stack, core, R = result.problem.stack, float(result.radius[0]), float(result.radius[-1])
    W = float(weight_of_layers(result, np.array(core)))
    if isnan(W):
        return nan

    def excess(log_a: float) -> float:
        """Return ln(a^2) less that of the contact with the moduli at this half width a."""
        a = exp(log_a)
        depths = np.linspace(0.0, min(a, R - core), DEPTHS)
        wound = float(np.mean(stresses_between(result, R - depths)["pressure"]))
        P_e = max(wound, 0.0) + PEAK_COEFFICIENT * 2 * W / (pi * a)
        return 2 * log_a - log(2 * coefficients(*stack.tangent(P_e)).C * W * R / pi)

    narrowest, widest = log(NARROWEST * R), log(WIDEST * R)
    if excess(narrowest) * excess(widest) > 0:
        return nan
    return 2 * exp(brentq(excess, narrowest, widest, xtol=1e-10))
