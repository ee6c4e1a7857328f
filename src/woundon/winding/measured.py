r"""Windings with measured schedules, which fluctuate over the radius.

A fluctuating wound-on tension cannot be interpolated from a few nips.  But the tension of a nip is
a smooth function of the radius and of its loads L = (P, F, T_in), with those of the further nips of
a two-drum winder.  The winding is therefore solved
with smoothed schedules L0, and the tension is linearised about this solution:

    WOT(r) = WOT0(r) + dWOT/dL(r) . (L(r) - L0(r)).

The derivatives are exact for the nips on the smooth roll and are interpolated like WOT0.  The roll
is computed from this tension.  The linearisation error is estimated from nips under the measured
loads on this roll, at the radii of the largest departures.

    effective roll    dWOT = W_L dL + W_Pe dP_e,
                      dP_e = (1 - feedback)^-1 ((wound - 0.25 p_max) dln a + 0.25 p_max dln P)
"""

from __future__ import annotations

from collections.abc import Callable
from math import isnan

import numpy as np

from ..problems.paths import field_or_none
from ..problems.schedules import Profile, Steps
from ..problems.winding import LOADS, WindingProblem
from ..roll.result import RollResult
from ..roll.weight import PEAK_COEFFICIENT
from .bodies import NipSample, tension_on_roll
from .curve import MAX_PIECES, TensionCurve, sampling_radii, sharp_kinks
from .nips import Nips

__all__ = ["CHECKS", "Departure", "largest_mismatch", "smoothed"]

Array = np.ndarray

SCHEDULES = (
    "web_tension",
    "nip_load",
    "winding_force",
    "torque_split",
    "winder.rider_load",
    "winder.core_torque",
)
MAX_SMOOTH_VALUES = 12  # a table with more values may fluctuate
DEGREE = 5  # of the polynomial that replaces it
FIT_RADII, TABLE_RADII = 1025, 33  # numbers of radii of the fit and of the smoothed table
CHECKS = 4  # nips under measured loads, one in each part of the radii


def smoothed(problem: WindingProblem, rtol: float) -> WindingProblem | None:
    """Replace fluctuating schedules of a winding by smooth ones; return None if there are none.

    A table fluctuates if a polynomial differs from it by more than ``rtol`` of its largest value.
    Steps always do: behind a step the tension of the nips approaches that of the next value within
    some half-widths, so that each step would need about ten nips.
    """
    has_many_kinks = len(sharp_kinks(problem)) >= MAX_PIECES
    r = np.linspace(*problem.ends, FIT_RADII)
    changes = {}
    for name in SCHEDULES:
        schedule = field_or_none(problem, name)
        if isinstance(schedule, Steps):
            table, may_fluctuate = schedule.profile(*problem.ends), True
        elif isinstance(schedule, Profile):
            table, has_many_values = schedule, len(schedule.radius) > MAX_SMOOTH_VALUES
            may_fluctuate = has_many_kinks if table.between == "lines" else has_many_values
        else:
            continue
        if not may_fluctuate:
            continue
        values = table.at(r)
        fitted = np.polynomial.Polynomial.fit(r, values, DEGREE)(r)
        if np.max(np.abs(fitted - values)) > rtol * np.max(np.abs(values)):
            stride = (FIT_RADII - 1) // (TABLE_RADII - 1)
            bounded = np.clip(fitted, np.min(values), np.max(values))[::stride]
            changes[name] = Profile(radius=r[::stride], value=bounded, between="smooth")
    return problem.replace(**changes) if changes else None


class Departure:
    """Linearised change of the wound-on tension from smooth to measured schedules.

    Parameters
    ----------
    problem, smooth : WindingProblem
        The winding with the measured and with the smoothed schedules.
    curve : TensionCurve
        Tension of the smooth winding.
    nips : Nips
        Nips of the smooth winding, solved at the places of the curve.
    """

    def __init__(
        self, problem: WindingProblem, smooth: WindingProblem, curve: TensionCurve, nips: Nips
    ) -> None:
        self.problem, self.smooth, self.curve = problem, smooth, curve
        self.names = tuple(nip_loads(problem, np.array(problem.radius)))
        slopes = {
            place: _slopes(nips.samples[curve.radius(place)], self.names) for place in curve.places
        }
        # derivatives of the tension by place, a mapping for each of the loads
        self.slopes = [{place: s[k] for place, s in slopes.items()} for k in range(len(self.names))]

    def parts(self, r: Array) -> Array:
        """Return the changes of the wound-on tension at radii, (loads, k) [N/m].

        A change is the derivative of the tension by the load, known at the nips and interpolated
        over the radius, times the measured minus the smoothed schedule.  The nip load is linearised
        by its root, because the contact width varies as this root.

        Parameters
        ----------
        r : (k,) array
            Radii [m].
        """
        changes = []
        measured, smooth = nip_loads(self.problem, r), nip_loads(self.smooth, r)
        for name, slope in zip(self.names, self.slopes, strict=True):
            L, L0 = measured[name], smooth[name]
            dL = 2 * L0 * (np.sqrt(L / L0) - 1) if name.endswith("nip_load") else L - L0
            changes.append(self.curve.shares(slope, r) * dL)
        return np.array(changes)

    def __call__(self, r: Array) -> Array:
        """Return the total change at radii, (k,) [N/m]."""
        return np.asarray(self.parts(r).sum(axis=0))


def nip_loads(problem: WindingProblem, r: Array) -> dict[str, Array]:
    """Return the loads of the nips at radii, (k,) each, by the name of the field of a nip [N/m]."""
    loads = {name: problem.at(name, r) for name in LOADS}
    if problem.winder is None:
        return loads
    drums = problem.drum_loads(r)
    loads |= {
        "next_nips.0.nip_load": drums.front_load,
        "next_nips.0.winding_force": drums.front_force,
    }
    if problem.winder.rider is not None:
        loads["next_nips.1.nip_load"] = drums.rider_load
    return loads


def _slopes(sample: NipSample, names: tuple[str, ...]) -> Array:
    """Return the derivatives of WOT by the named loads of the nips, (loads,) [1].

    They include the change of the roll: on an effective roll a load changes the effective pressure
    P_e, and with it the moduli.  P_e = wound + 0.25 p_max, where the wound pressure, a mean down to
    the depth a, is about proportional to the half-width a, and p_max to P/a.  1/(1 - feedback) sums
    the further changes of P_e by the change of the nip.
    """
    result, P_e = sample.result, sample.pressure
    sensitivity = result.sensitivity(*names, outputs=("roll_wound_on_tension", "half_width"))
    tension, width = sensitivity.derivatives
    if isnan(P_e):
        return np.asarray(tension)
    contact_part = PEAK_COEFFICIENT * result.peak_pressure
    # derivatives of ln a and ln P by the loads, and of P_e at a fixed roll
    ln_a = width / result.half_width
    ln_P = np.array([1 / result.problem.nip_load if name == "nip_load" else 0.0 for name in names])
    wound_part = P_e - contact_part
    pressure_change = (wound_part - contact_part) * ln_a + contact_part * ln_P
    by_pressure = sample.exponents.tension * tension_on_roll(result) / P_e
    return np.asarray(tension + by_pressure * pressure_change / (1 - sample.feedback))


def largest_mismatch(
    departure: Departure, nips: Nips, roll: RollResult, tension_at: Callable[[Array], Array]
) -> float:
    """Return the largest relative error of the reported tension at nips under measured loads.

    Parameters
    ----------
    departure : Departure
    nips : Nips
        Nips of the measured winding.
    roll : RollResult
        The roll of the reported tension.
    tension_at : callable
        (radii) -> reported tension [N/m].
    """
    curve = departure.curve
    r = sampling_radii(departure.problem)
    r = r[r >= curve.radius(curve.pieces[0].start)]
    change, error = np.abs(departure.parts(r)).sum(axis=0), 0.0
    for part in np.array_split(np.arange(r.size), CHECKS):
        # where the loads differ most from the smooth ones
        radius = float(r[part[np.argmax(change[part])]])
        tension = nips.tension(radius, roll)
        error = max(error, abs(float(tension_at(np.array(radius))) / tension - 1))
    return error
