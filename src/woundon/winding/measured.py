r"""Windings by measured schedules, whose tables wander from radius to radius.

A wound-on tension that wanders with them is drawn by no few nips.  But what a nip answers is a
smooth function of the radius and of its loads L = (T_in, P, F).  So the winding is solved with
smooth schedules L0 in the place of the measured ones, and

    WOT(r) = WOT0(r) + dWOT/dL(r) . (L(r) - L0(r)),

the derivatives exact ones of the nips on that roll, drawn through the same radii as WOT0.  With
this tension the roll is wound.  Nips under the measured loads, on the very roll, where these depart
most, say by how much that is off: the second order, and what unevenly wound layers do to a nip.

    effective roll    dWOT = W_L dL + W_Pe dP_e,
                      dP_e = (1 - feedback)^-1 ((wound - 0.25 p_max) dln a + 0.25 p_max dln P)
"""

from __future__ import annotations

from collections.abc import Callable
from math import isnan

import numpy as np

from ..problems.schedules import Profile
from ..problems.winding import LOADS, WindingProblem
from ..roll.result import RollResult
from .bodies import SHARE, NipSample, tension_on_roll
from .curve import MOST_PIECES, TensionCurve, sampling_radii, sharp_kinks
from .nips import Nips

__all__ = ["Departure", "largest_mismatch", "smoothed"]

Array = np.ndarray

WANDERING = ("web_tension", "nip_load", "winding_force", "torque_split")
MANY = 12  # values of a smooth table from which it may wander
DEGREE = 5  # of the polynomial in its place
FITTED, DRAWN = 1025, 33  # radii that it is fitted at, and given by
CHECKED = 4  # nips under measured loads, each in as large a part of the radii


def smoothed(problem: WindingProblem, rtol: float) -> WindingProblem | None:
    """Return a winding with smooth schedules in place of those that wander; None if none does."""
    many = len(sharp_kinks(problem)) >= MOST_PIECES
    r = np.linspace(*problem.ends, FITTED)
    found = {}
    for name in WANDERING:
        table = getattr(problem, name)
        if not isinstance(table, Profile):
            continue
        if many if table.between == "lines" else len(table.radius) > MANY:
            values = table.at(r)
            fitted = np.polynomial.Polynomial.fit(r, values, DEGREE)(r)
            if np.max(np.abs(fitted - values)) > rtol * np.max(np.abs(values)):
                kept = slice(None, None, (FITTED - 1) // (DRAWN - 1))
                inside = np.clip(fitted, np.min(values), np.max(values))
                found[name] = Profile(radius=r[kept], value=inside[kept], between="smooth")
    return problem.replace(**found) if found else None


class Departure:
    """By how much the wound-on tension departs from that of smooth schedules.

    Parameters
    ----------
    problem, smooth : WindingProblem
        With the measured schedules, and with smooth ones.
    curve : TensionCurve
        Of the smooth one.
    nips : Nips
        That are solved at its places.
    """

    def __init__(
        self, problem: WindingProblem, smooth: WindingProblem, curve: TensionCurve, nips: Nips
    ) -> None:
        self.problem, self.smooth, self.curve = problem, smooth, curve
        slopes = {place: _slopes(nips.samples[curve.radius(place)]) for place in curve.places}
        self.slopes = [{place: own[k] for place, own in slopes.items()} for k in range(len(LOADS))]

    def parts(self, r: Array) -> Array:
        """Return it at radii, a row for each load [N/m].

        Load counts by its root, with which a contact gets wider: nips are less bent over it.
        """
        found = []
        for name, slope in zip(LOADS, self.slopes, strict=True):
            own, smooth = self.problem.at(name, r), self.smooth.at(name, r)
            by = 2 * smooth * (np.sqrt(own / smooth) - 1) if name == "nip_load" else own - smooth
            found.append(self.curve.shares(slope, r) * by)
        return np.array(found)

    def __call__(self, r: Array) -> Array:
        """Return it at radii [N/m]."""
        return np.asarray(self.parts(r).sum(axis=0))


def _slopes(sample: NipSample) -> Array:
    """Return the derivatives of a nip's wound-on tension by its loads, what the roll feels too."""
    result, P_e = sample.result, sample.pressure
    found = result.sensitivity(*LOADS, outputs=("roll_wound_on_tension", "half_width"))
    tension, width = found.derivatives
    if isnan(P_e):
        return np.asarray(tension)
    pressed = SHARE * result.peak_pressure
    ln_a = width / result.half_width
    ln_P = np.array([1 / result.problem.nip_load if name == "nip_load" else 0.0 for name in LOADS])
    pressure_change = ((P_e - pressed) - pressed) * ln_a + pressed * ln_P
    by_pressure = sample.exponents[0] * tension_on_roll(result) / P_e
    return np.asarray(tension + by_pressure * pressure_change / (1 - sample.feedback))


def largest_mismatch(
    departure: Departure, nips: Nips, roll: RollResult, tension_at: Callable[[Array], Array]
) -> float:
    """Return by what of it nips under the measured loads miss the reported tension, at most.

    Parameters
    ----------
    departure : Departure
    nips : Nips
        Of the measured winding.
    roll : RollResult
        Wound with the reported tension.
    tension_at : callable
        (radii) -> that tension [N/m].
    """
    curve = departure.curve
    r = sampling_radii(departure.problem)
    r = r[r >= curve.radius(curve.pieces[0].start)]
    by, missed = np.abs(departure.parts(r)).sum(axis=0), 0.0
    for part in np.array_split(np.arange(r.size), CHECKED):
        radius = float(r[part[np.argmax(by[part])]])
        tension = nips.tension(radius, roll)
        missed = max(missed, abs(float(tension_at(np.array(radius))) / tension - 1))
    return missed
