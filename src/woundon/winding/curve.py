r"""Interpolation of the wound-on tension over the radius, from a few nips.

The friction share y = (WOT - T_in)/(mu+ P) is interpolated.  It varies little, because T_in and P
contain most of the effect of the schedules.  Its coordinate is x = ln(r - r_c), because the nip
depends on the depth of the roll.  The nips are solved at *places*, the interpolation points x:

    layers    1     10         0.05 r_c                     a sharp kink          R
            |------|============|================================|==============|
          tangent    on the core         one polynomial per piece, through a few places

The pressure of a roll of fewer than ten layers is not computed.  In the piece on the core the
contact is wider than the depth of the layers and y varies quickly; it affects only the region near
the core and has its own few places.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from math import ceil

import numpy as np

from ..problems.roll import FEWEST_LAYERS
from ..problems.winding import LOADS, WindingProblem
from .interpolation import Piece

__all__ = [
    "MAX_PIECES",
    "NOMINAL",
    "TensionCurve",
    "polyline_radii",
    "sampling_radii",
    "sharp_kinks",
]

Array = np.ndarray

NEAR_CORE = 0.05  # depth of the piece on the core, relative to the core radius
AIR_FACTOR = 2.0  # largest thickness of ten layers with air, relative to the web alone
MIN_PLACES_NEAR_CORE = 4  # initial number of places of the piece on the core
# Initial number of places of the other pieces, and of a survey: places are added where polynomials
# through three and four places differ too much from the next nip.
MIN_PLACES, MIN_PLACES_SURVEY = 7, 5
CORE_ERROR_FACTOR = 5  # accepted error of the piece on the core, in multiples of rtol
MIN_DEPTH = 1.5  # minimum depth of the piece on the core, in multiples of ten layers
# distance in x for the curvature at the first place, and step of the difference quotients
CURVATURE_DISTANCE, STEP = 0.5, 1e-4
MIN_TENSION = 0.2  # minimum tension of the first layers, relative to the tenth layer
SHARP = 0.1  # strength of a kink, r |d slope|/value, above which the curve is split there
MAX_PIECES = 6  # in addition to that on the core
SAMPLING_RADII = 200  # radii from which the radii of the curve are chosen
LINEAR_SHARE = 0.3  # accepted error of linear interpolation, relative to rtol
# number of intervals between core and surface times rtol^0.5, and factor of its increase
INTERVALS, INTERVAL_GROWTH = 2.0, 1.25
NOMINAL = 0.6  # initial guess of the share


class TensionCurve:
    """Piecewise polynomial interpolation of the wound-on tension over x = ln(r - r_c).

    The function that is interpolated is the friction share y = (WOT - T_in)/(mu+ P), known at the
    places, the interpolation points x.

    Parameters
    ----------
    problem : WindingProblem
    rtol : float
        Accepted relative error of the tension.
    survey : bool
        True begins with fewer places, for windings whose errors are not estimated one by one.

    Attributes
    ----------
    pieces : list of Piece
        From the tenth layer to the surface; nips are solved at their places.
    accepted_errors : list of float
        Accepted error of each piece, relative to the tension.
    interval_count : int
        Number of intervals, uniform in x, of the reported tension.
    """

    def __init__(self, problem: WindingProblem, rtol: float, survey: bool = False) -> None:
        self.problem, self.rtol = problem, rtol
        self.interval_count = ceil(INTERVALS / rtol**0.5)
        core, R = problem.ends
        factor = AIR_FACTOR if problem.air is not None and problem.web_speed else 1 + 1e-9
        self.min_depth = FEWEST_LAYERS * problem.web.thickness * factor
        # of the piece on the core: at least ten layers, and less than a quarter of the build-up
        core_depth = min(
            max(self.min_depth, NEAR_CORE * core), max(self.min_depth, 0.25 * (R - core))
        )
        # the curve is split at its sharpest kinks above the piece on the core
        all_kinks = sharp_kinks(problem)
        kinks = {r: all_kinks[r] for r in all_kinks if core + core_depth < r < R}
        cuts = sorted(sorted(kinks, key=kinks.__getitem__)[-MAX_PIECES + 1 :])
        ends = [float(np.log(r - core)) for r in (core + core_depth, *cuts, R)]
        count = MIN_PLACES_SURVEY if survey else MIN_PLACES
        self.pieces = [Piece(a, b, count) for a, b in pairwise(ends)]
        if core_depth > MIN_DEPTH * self.min_depth:
            start = float(np.log(self.min_depth))
            self.pieces.insert(0, Piece(start, ends[0], MIN_PLACES_NEAR_CORE))
        self.on_core = len(self.pieces) >= len(ends)  # True if the first piece is on the core
        # the rest of rtol is for linear interpolation between the reported radii
        self.accepted_errors = [(1 - LINEAR_SHARE) * rtol] * len(self.pieces)
        if self.on_core:
            self.accepted_errors[0] *= CORE_ERROR_FACTOR

    @property
    def places(self) -> list[float]:
        """Coordinates of all interpolation points: a nip is solved at each."""
        return list(dict.fromkeys(place for piece in self.pieces for place in piece.places))

    def radius(self, place: float) -> float:
        """Return the radius of a place [m]; at the surface without rounding."""
        core, R = self.problem.ends
        return R if place == self.pieces[-1].end else core + float(np.exp(place))

    def shares(self, values: Mapping[float, float], r: Array, *, curved: bool = False) -> Array:
        """Interpolate y at radii (k,) [m], from ``values``, which map each place to its y, (k,).

        Below ten layers y is extrapolated linearly in x, or with its curvature if ``curved``, and
        is constant below one layer.  It is limited to the value of the winding force alone, because
        the contribution of the roll deformation vanishes there.
        """
        x = np.log(np.maximum(r - self.problem.core.radius, self.problem.web.thickness))
        out = np.empty(x.shape)
        for piece in self.pieces:  # a later piece replaces the values beyond its start
            beyond = x >= piece.start - 1e-12
            out[beyond] = piece.at(np.clip(x[beyond], piece.start, piece.end), values)
        first_piece = self.pieces[0]
        below = x < first_piece.start
        dx = x[below] - first_piece.start
        slope = self._slope(values, 0.0)
        out[below] = values[first_piece.start] + slope * dx
        if curved:
            curvature = (self._slope(values, CURVATURE_DISTANCE) - slope) / CURVATURE_DISTANCE
            out[below] += curvature * dx**2 / 2
        force_share = float(self._share_of_winding_force(np.array(self.radius(first_piece.start))))
        # the share may approach that of the force from above or from below, but not cross it
        limit = np.maximum if values[first_piece.start] > force_share else np.minimum
        out[below] = limit(out[below], self._share_of_winding_force(r[below]))
        return out

    def _share_of_winding_force(self, r: Array) -> Array:
        """Return y = F/(mu+ P) at radii [m], with their shape.

        It is the share of a nip-induced tension equal to the winding force F.
        """
        return np.asarray(self.problem.at("winding_force", r) / self._friction_limit(r))

    def _friction_limit(self, r: Array) -> Array:
        """Return mu+ P at radii [N/m], with their shape: NIT is y times this limit."""
        return np.asarray(self.problem.roll_friction * self.problem.at("nip_load", r))

    def _slope(self, values: Mapping[float, float], distance: float) -> float:
        """Return dy/dx at a distance in x above the first place, by a difference quotient."""
        first_piece = self.pieces[0]
        x = first_piece.start + min(distance, first_piece.end - first_piece.start)
        y, y_next = first_piece.at(np.array([x, x + STEP]), values)
        return float(y_next - y) / STEP

    def tension(self, values: Mapping[float, float], r: Array, *, curved: bool = False) -> Array:
        """Return WOT at radii [N/m], from shares at the places; see :meth:`shares`.

        A lower limit keeps the extrapolated tension of the first layers positive.
        """
        WOT = self.wound_on(self.shares(values, r, curved=curved), r)
        first_place = self.pieces[0].start
        r_first = np.array(self.radius(first_place))
        WOT_first = float(self.wound_on(np.array(values[first_place]), r_first))
        limit = min(WOT_first, MIN_TENSION * WOT_first)  # the former if it is negative
        return np.where(r < r_first, np.maximum(WOT, limit), WOT)

    def wound_on(self, shares: Array, r: Array) -> Array:
        """Convert shares y at radii [m] to WOT = T_in + y mu+ P [N/m], all of one shape."""
        return self.problem.at("web_tension", r) + shares * self._friction_limit(r)

    def share(self, tension: float, r: float) -> float:
        """Convert WOT [N/m] at a radius [m] to the friction share y = (WOT - T_in)/(mu+ P) [1]."""
        NIT = tension - float(self.problem.at("web_tension", r))
        return NIT / float(self._friction_limit(np.array(r)))

    def knots(self) -> Array:
        """Return the radii at which the tension is reported, linear in between.

        They are the places, the radii that the schedules need, and more radii, uniform in x.  The
        tension does not affect them, so that the roll does not depend on the initial guess.
        """
        core, R = self.problem.ends
        r = sampling_radii(self.problem)
        nominal = self.wound_on(np.full(r.size, NOMINAL), r)
        first_radius = core + self.problem.web.thickness  # where the share begins to change
        included = [*(self.radius(place) for place in self.places), first_radius]
        needed = polyline_radii(self.problem, r, nominal, self.rtol, included)
        x = np.linspace(np.log(first_radius - core), np.log(R - core), self.interval_count + 1)
        outside_core = needed[1:]  # the first radius is the core, where x is infinite
        is_near = np.abs(x[:, None] - np.log(outside_core - core)).min(axis=1) < (x[1] - x[0]) / 2
        return np.union1d(needed, core + np.exp(x[~is_near]))

    def refine_radii(self, values: Mapping[float, float]) -> bool:
        """Add radii until linear interpolation is accurate; return True if any were added.

        The reported tension is linear between its radii; the polynomials of the pieces are not.
        In the piece on the core a larger error is accepted, as for the polynomials themselves.

        Parameters
        ----------
        values : mapping of float to float
            Place -> friction share.
        """
        initial_count = self.interval_count
        while True:
            r = self.knots()
            error, on_core = self._polyline_errors(values, r, self.tension(values, r))
            if max(error, on_core / CORE_ERROR_FACTOR) <= LINEAR_SHARE * self.rtol:
                return self.interval_count > initial_count
            self.interval_count = ceil(INTERVAL_GROWTH * self.interval_count)

    def _polyline_errors(
        self, values: Mapping[float, float], r: Array, tension: Array
    ) -> tuple[float, float]:
        """Return the relative errors of linear interpolation above and in the piece on the core.

        Radii below ten layers are excluded.

        Parameters
        ----------
        values : mapping of float to float
            Place -> friction share, for the polynomials.
        r, tension : (k,) arrays
            Points of the reported polyline [m], [N/m].
        """
        fine = sampling_radii(self.problem)
        # of the polyline through the reported tension, relative to the interpolating polynomials
        error = np.abs(np.interp(fine, r, tension) / self.tension(values, fine) - 1)
        first_radius, outer = (self.radius(self.pieces[k].start) for k in (0, int(self.on_core)))
        on_core = error[(fine >= first_radius) & (fine < outer)]
        return float(np.max(error[fine >= outer])), float(np.max(on_core, initial=0.0))

    # ---- error estimates ------------------------------------------------------------------------

    def errors(self, values: Mapping[float, float]) -> list[float]:
        """Return the estimated error of each piece, relative to the tension [1].

        ``values`` map each place to its friction share.
        """
        return [
            max(
                self._relative_error(place, error, values[place])
                for place, error in piece.error_estimates(values)
            )
            for piece in self.pieces
        ]

    def _relative_error(self, place: float, error: float, value: float) -> float:
        """Convert the error of a share at a place to a relative error of the tension.

        ``value`` is the share there.
        """
        r = np.array(self.radius(place))
        return float(error * self._friction_limit(r) / self.wound_on(np.array(value), r))

    def interpolation_error(self, values: Mapping[float, float], r: Array, tension: Array) -> float:
        """Return the relative interpolation error of the reported tension between the nips.

        It is the sum of the errors of the polynomials, of the polyline through the reported tension
        and of schedules that vary between the nips.  Parameters as of :meth:`_polyline_errors`.
        """
        fine = sampling_radii(self.problem)
        polyline, _ = self._polyline_errors(values, r, tension)
        schedule = self._schedule_error(fine, self.tension(values, fine))
        return max(self.errors(values)[self.on_core :]) + polyline + schedule

    def core_interpolation_error(
        self, values: Mapping[float, float], r: Array, tension: Array
    ) -> float:
        """Return the relative interpolation error of the tension in the piece on the core.

        Parameters as of :meth:`_polyline_errors`.
        """
        return (
            self.errors(values)[0] + self._polyline_errors(values, r, tension)[1]
            if self.on_core
            else 0.0
        )

    def _schedule_error(self, r: Array, tension: Array) -> float:
        """Return the relative error of the tension from schedules that vary between the nips.

        It is estimated from the error of the nip load, interpolated by the same polynomials.  The
        relative error of the share is at most half of it, because NIT varies as a power of the
        load between 1/2 and 1.  ``r`` and ``tension`` are radii [m] and WOT there [N/m], (k,).
        """
        schedule = self.problem.at
        loads = {place: float(schedule("nip_load", self.radius(place))) for place in self.places}
        error = np.abs(self.shares(loads, r) / schedule("nip_load", r) - 1) / 2
        added = np.abs(tension - schedule("web_tension", r)) / tension
        return float(np.max((error * added)[r >= self.radius(self.pieces[0].start)]))


def sharp_kinks(problem: WindingProblem) -> dict[float, float]:
    """Return the radii of sharp kinks of the schedules [m], with the strength of each kink."""
    return {r: strength for r, strength in problem.kinks.items() if strength > SHARP}


def sampling_radii(problem: WindingProblem) -> Array:
    """Return a fine set of radii, dense near the core, for choosing the reported ones [m]."""
    core, R = problem.ends
    layer = problem.web.thickness
    near_core_radii = core + np.exp(np.linspace(np.log(layer), np.log(R - core), SAMPLING_RADII))
    r = np.union1d(near_core_radii[:-1], problem.radii(SAMPLING_RADII))
    r = r[np.append(True, np.diff(r) > 1e-9 * R)]
    r[-1] = R
    return np.asarray(r)


def polyline_radii(
    problem: WindingProblem, r: Array, tension: Array, rtol: float, included: Sequence[float] = ()
) -> Array:
    """Return radii between which tension and schedules are linear to a fraction of rtol [m].

    Parameters
    ----------
    problem : WindingProblem
    r, tension : arrays
        Fine radii to choose from [m], and WOT there [N/m].
    rtol : float
    included : sequence of float
        Further radii, which the returned ones include [m].
    """
    curves = [tension, *(problem.at(name, r) for name in LOADS)]
    selected = [_polyline_points(r, y, LINEAR_SHARE * rtol * np.max(np.abs(y))) for y in curves]
    chosen, R = r[np.any(selected, axis=0)], problem.radius
    # -R is far from all radii; without it there would be no minimum if nothing is included
    is_new = np.abs(chosen[:, None] - np.array([*included, -R])).min(axis=1) > 1e-9 * R
    return np.union1d(chosen[is_new], list(included))


def _polyline_points(r: Array, values: Array, tolerance: float) -> Array:
    """Return True for the points of a polyline that deviates by at most ``tolerance``.

    Douglas-Peucker algorithm; all arrays (k,).
    """
    selected = np.zeros(r.size, dtype=bool)
    selected[[0, -1]] = True
    intervals = [(0, r.size - 1)]
    while intervals:
        start, end = intervals.pop()
        line = values[start] + (values[end] - values[start]) * (r[start : end + 1] - r[start]) / (
            r[end] - r[start]
        )
        error = np.abs(values[start : end + 1] - line)
        k = start + int(np.argmax(error))
        if error[k - start] > tolerance:
            selected[k] = True
            intervals += [(start, k), (k, end)]
    return selected
