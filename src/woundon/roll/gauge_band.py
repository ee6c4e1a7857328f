r"""Gauge bands: a thick lane across the width of a wound roll, in closed form.

A lane of the web that is thicker by the fraction d is wound on the same core, with the same number
of layers, and to about the same radius as the neighbouring lanes.  The radial compression of its
layers is therefore larger by d.  Below the surface of a roll of many thin layers, wound with the
stress T = WOT/h, the pressure P has a plateau, where the strain energy of compression equals that
of the tension:

    mean roll    W(P) = T^2/(2 E_t)            W(P) = int_0^P P' dP'/E_r(P')
    lane         F(P_b) = F(P) + d             compression larger by d, F(P) = int_0^P dP'/E_r
                 T_b = sqrt(2 E_t W(P_b))      the tension that winds this pressure
    radius       (s_b - s)/s = (T_b - T)/E_t   a larger circumference strains the web

For Pfeiffer's law W = (P - K1 ln(1 + P/K1))/K2 and F = ln(1 + P/K1)/K2, so that

    (K1 + P_b)/(K1 + P) = exp(K2 d).

d > 0 gives T_b > T, P_b > P and a ridge.  A lane thinner by more than F(P) is slack: its pressure
and tension are zero.

The plateau relation neglects the curvature of the layers: in complete rolls the pressure is 4 to
15 % higher, and the tension up to 2 % lower.  Two neglected effects make tension, pressure and
ridge too large: the shear between lanes, which loads the neighbours, and the part lead/d of the
thickness that increases the radius, up to a seventh in hard stacks.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..problems.roll import RollProblem
from ..problems.stack import Stack

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

__all__ = ["GaugeBand", "band_of", "gauge_band_over", "lane_strain"]

Array = np.ndarray


@dataclass(frozen=True)
class GaugeBand:
    """A thick lane of a wound roll.

    Attributes
    ----------
    tension : float or array
        Wound-on tension of the lane [N/m].
    pressure : float or array
        Pressure between its layers [Pa].
    lead : float or array
        Height of the ridge, (s_b - s)/s [1].
    mean_pressure : float or array
        Pressure of the mean roll [Pa].
    strain : float or array
        Strain of the lane along the web, tension/(h E_t) [1].
    """

    tension: Any
    pressure: Any
    lead: Any
    mean_pressure: Any
    strain: Any


def band_of(stack: Stack, thickness: float, tension: ArrayLike, excess: float) -> GaugeBand:
    """Return a thick lane in the plateau of a long roll.

    Parameters
    ----------
    stack : Stack
    thickness : float
        h of the web [m].
    tension : array_like
        Wound-on tension of the mean roll [N/m], > 0.
    excess : float
        d, additional thickness of the lane over that of the web [1].

    Raises
    ------
    InvalidProblem
        If the law of the stack ends below a pressure.
    """
    WOT, E_t = np.asarray(tension, dtype=float), stack.tangential
    T = WOT / thickness
    P = stack.plateau_pressure(T)
    if excess == 0:
        T_b, P_b = T, P
    else:
        compression = np.maximum(stack.radial.strain_at(P) + excess, 0.0)
        P_b = stack.radial.pressure_at(compression)
        stack.check_pressure(P_b)
        T_b = np.sqrt(2 * E_t * stack.compression_energy(P_b))
    values = (thickness * T_b, P_b, (T_b - T) / E_t, P, T_b / E_t)
    return GaugeBand(*(value if np.ndim(value) else float(value) for value in values))


def gauge_band_over(problem: RollProblem, radius: Array) -> GaugeBand:
    """Return the thick lane of a roll at radii [m], from the plateau for the tension there."""
    T = problem.tension_curve.at(radius)
    return band_of(
        problem.stack, problem.web_thickness, T * problem.web_thickness, problem.gauge_excess
    )


def lane_strain(problem: RollProblem, radius: Array) -> Array:
    """Return the strain along the web of the thickest lane of a roll at radii [m].

    It is T/E_t for a web of uniform thickness.

    Raises
    ------
    InvalidProblem
        If the law of the stack ends below the pressure of the lane.
    """
    if problem.gauge_excess == 0:
        return np.asarray(problem.tension_curve.at(radius) / problem.stack.tangential)
    return np.asarray(gauge_band_over(problem, radius).strain)
