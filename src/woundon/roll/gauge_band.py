r"""Gauge bands: a thick lane across the width of a wound roll, in closed form.

A lane of the web that is thicker by the fraction d is wound on the same core and with the same
number of layers n as the rest.  Below the surface of a roll of many thin layers, wound with the
stress T = WOT/h, the pressure P has a plateau, where the strain energy of compression equals that
of the tension:

    mean roll    W(P) = T^2/(2 E_t)            W(P) = int_0^P P' dP'/E_r(P')
    lane         T_b^2/(2 E_t) = W(P_b)        the tension that winds the pressure P_b
    radius       lead = (s_b - s)/s = (T_b - T)/E_t
    thickness    F(P_b) - F(P) = ln((1 + d)/(1 + lead)),    F(P) = int_0^P dP'/E_r

The web has one unstrained length per revolution, so that a circumference larger by the fraction
lead strains it by lead.  Deep in a long roll lead does not depend on the radius: ds_b/dn =
(1 + lead) ds/dn.  With the logarithmic compression F, layers of the roll are h exp(-F(P)) thick and
those of the lane (1 + d) h exp(-F(P_b)), which gives the last equation: the larger radius takes up
the part lead of the excess, compression the rest.

d > 0 gives T_b > T, P_b > P and a ridge.  A lane so thin that ln((1 + d)/(1 - T/E_t)) <= -F(P) is
slack: its pressure and tension are zero.

The plateau relation neglects the curvature of the layers.  The shear between the lanes, which loads
the neighbours, is also neglected; it makes tension, pressure and ridge of the lane too large.
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

# Newton's method for the pressure of a lane, in ln P: the error after a step is about its square.
NEWTON_TOLERANCE, LARGEST_STEP, NEWTON_STEPS = 1e-8, 3.0, 100


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
        P_b, T_b = _pressure_and_tension(stack, T, P, excess)
        stack.check_pressure(P_b)
    # in the order of the fields: tension, pressure, lead, mean pressure, strain
    values = (thickness * T_b, P_b, (T_b - T) / E_t, P, T_b / E_t)
    return GaugeBand(*(value if np.ndim(value) else float(value) for value in values))


def _pressure_and_tension(stack: Stack, T: Array, P: Array, excess: float) -> tuple[Array, Array]:
    """Return P_b and T_b of a lane [Pa]; both are zero if the lane is slack.

    ``T`` and ``P`` are the wound-on stress and the pressure of the mean roll [Pa], ``excess`` is d.

    Newton's method in ln P_b for g = F(P_b) + ln(1 + lead) - F(P) - ln(1 + d), which increases:
    d F = P_b/E_r d ln P_b, and d T_b = (E_t/E_r) (P_b/T_b) P_b d ln P_b.
    """
    E_t, law = stack.tangential, stack.radial
    target = law.strain_at(P) + np.log1p(excess)
    # slack at any pressure: g > 0 also for P_b = T_b = 0; the minimum keeps the logarithm finite
    slack = np.log1p(-np.minimum(T / E_t, 1 - 1e-15)) >= target
    P_b = np.array(P, dtype=float)
    for _ in range(NEWTON_STEPS):
        T_b = np.sqrt(2 * E_t * stack.compression_energy(P_b))
        circumference = 1 + (T_b - T) / E_t
        residual = law.strain_at(P_b) + np.log(circumference) - target
        slope = P_b / law.modulus(P_b) * (1 + P_b / T_b / circumference)
        step = np.where(slack, 0.0, np.clip(-residual / slope, -LARGEST_STEP, LARGEST_STEP))
        P_b = P_b * np.exp(step)
        if np.all(np.abs(step) <= NEWTON_TOLERANCE):
            break
    T_b = np.sqrt(2 * E_t * stack.compression_energy(P_b))
    return np.where(slack, 0.0, P_b), np.where(slack, 0.0, T_b)


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
