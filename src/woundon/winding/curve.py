r"""The wound-on tension over the radius, from what a few nips add.

What is drawn is the share y = (WOT - T_in)/(mu+ P), which hardly varies: what the schedules do is
in T_in and P.  Its coordinate, the *place*, is x = ln(r - r_c), for a nip feels a roll's depth:

    laps    1     10         0.05 r_c                     a sharp kink          R
            |------|============|================================|==============|
          tangent    on the core         a piece each of polynomials through few places

On fewer laps than ten no roll has a known pressure.  In the piece on the core the
contact is wider than what it presses, and y changes quickly; it matters to the core's surroundings
only, and takes a few places of its own.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from math import ceil

import numpy as np

from ..problems.roll import FEWEST_LAYERS
from ..problems.winding import LOADS, WindingProblem
from .interpolation import FEWEST, Piece

__all__ = ["MOST_PIECES", "NOMINAL", "TensionCurve", "looked_at", "sharp_kinks", "told_radii"]

Array = np.ndarray

NEAR_CORE = 0.05  # depth of the piece on the core, of the core's radius
ROOM_FOR_AIR = 2.0  # how thick ten laps may be with their air, of the web alone
FEWEST_NEAR_CORE = 4  # of its places
LESS_EXACT = 5  # times rtol, by which that piece may be off
DEEP_ENOUGH = 1.5  # times ten laps: the least depth of such a piece
# of x: from where the curvature before the first place is taken, and on which slopes are
JUST_BEHIND, STEP = 0.5, 1e-4
LEAST_KEPT = 0.2  # of the tenth lap's tension, by those before it
SHARP = 0.1  # of a kink, r |d slope|/value, from which the curve is drawn in two pieces
MOST_PIECES = 6  # in addition to that on the core
LOOKED_AT = 200  # radii from which the radii of the curve are chosen
STRAIGHT = 0.3  # of rtol, by which the curve may miss the line between two of them
# lines between the core and the surface, times the root of rtol; more where they miss by more
LINES, FINER = 2.0, 1.25
NOMINAL = 0.6  # share, to begin with


class TensionCurve:
    """The tension of a winding, between places at which shares y are given.

    Parameters
    ----------
    problem : WindingProblem
    rtol : float
        By how much of it the tension may be off.

    Attributes
    ----------
    pieces : list of Piece
        From the tenth lap to the surface; their places are where nips are wanted.
    allowed : list of float
        By how much of the tension each piece may be off.
    lines : int
        How many there are, even in x, for the reported tension.
    """

    def __init__(self, problem: WindingProblem, rtol: float) -> None:
        self.problem, self.rtol = problem, rtol
        self.lines = ceil(LINES / rtol**0.5)
        core, R = problem.ends
        room = ROOM_FOR_AIR if problem.air is not None and problem.web_speed else 1 + 1e-9
        self.least = FEWEST_LAYERS * problem.web.thickness * room
        inner = min(max(self.least, NEAR_CORE * core), max(self.least, 0.25 * (R - core)))
        sharp = {r: bend for r, bend in sharp_kinks(problem).items() if core + inner < r < R}
        cuts = sorted(sorted(sharp, key=sharp.__getitem__)[-MOST_PIECES + 1 :])
        ends = [float(np.log(r - core)) for r in (core + inner, *cuts, R)]
        self.pieces = [Piece(a, b, FEWEST) for a, b in pairwise(ends)]
        if inner > DEEP_ENOUGH * self.least:
            start = float(np.log(self.least))
            self.pieces.insert(0, Piece(start, ends[0], FEWEST_NEAR_CORE))
        self.on_core = len(self.pieces) >= len(ends)  # whether the first one is that on the core
        # the rest is for the lines between the reported radii
        self.allowed = [(1 - STRAIGHT) * rtol] * len(self.pieces)
        if self.on_core:
            self.allowed[0] *= LESS_EXACT

    @property
    def places(self) -> list[float]:
        """Where nips are wanted."""
        return list(dict.fromkeys(place for piece in self.pieces for place in piece.places))

    def radius(self, place: float) -> float:
        """Return the radius of a place [m]; at the surface exactly."""
        core, R = self.problem.ends
        return R if place == self.pieces[-1].end else core + float(np.exp(place))

    def shares(self, values: Mapping[float, float], r: Array, *, bent: bool = False) -> Array:
        """Return y at radii, from values at the places.

        On fewer laps than ten along the tangent, or ``bent`` as y is just behind; below a lap that
        of one lap.  There the roll's layer vanishes, and with it what the nip adds to the winding
        force: y does not go on beyond that.
        """
        x = np.log(np.maximum(r - self.problem.core.radius, self.problem.web.thickness))
        out = np.empty(x.shape)
        for piece in self.pieces:
            own = x >= piece.start - 1e-12
            out[own] = piece.at(np.clip(x[own], piece.start, piece.end), values)
        first = self.pieces[0]
        below = x < first.start
        before = x[below] - first.start
        out[below] = values[first.start] + self._slope(values, 0.0) * before
        if bent:
            bend = (self._slope(values, JUST_BEHIND) - self._slope(values, 0.0)) / JUST_BEHIND
            out[below] += bend * before**2 / 2
        tenth = float(self._by_force(np.array(self.radius(first.start))))
        kept = np.maximum if values[first.start] > tenth else np.minimum
        out[below] = kept(out[below], self._by_force(r[below]))
        return out

    def _by_force(self, r: Array) -> Array:
        """Return y of a nip that adds the winding force alone."""
        at = self.problem.at
        return np.asarray(at("winding_force", r) / (self.problem.roll_friction * at("nip_load", r)))

    def _slope(self, values: Mapping[float, float], behind: float) -> float:
        """Return dy/dx somewhat behind the first place."""
        first = self.pieces[0]
        at = first.start + min(behind, first.end - first.start) + np.array([0.0, STEP])
        one, two = first.at(at, values)
        return float(two - one) / STEP

    def tension(self, values: Mapping[float, float], r: Array, *, bent: bool = False) -> Array:
        """Return WOT at radii [N/m], from shares at the places; see :meth:`shares`.

        No extrapolation leaves the first laps slack.
        """
        found, first = self.wound_on(self.shares(values, r, bent=bent), r), self.pieces[0].start
        at = np.array(self.radius(first))
        tenth = float(self.wound_on(np.array(values[first]), at))
        return np.where(r < at, np.maximum(found, min(tenth, LEAST_KEPT * tenth)), found)

    def wound_on(self, shares: Array, r: Array) -> Array:
        """Return WOT of shares at radii [N/m]."""
        at = self.problem.at
        return at("web_tension", r) + shares * self.problem.roll_friction * at("nip_load", r)

    def share(self, tension: float, r: float) -> float:
        """Return y of a tension at a radius."""
        at = self.problem.at
        gained = tension - float(at("web_tension", r))
        return gained / (self.problem.roll_friction * float(at("nip_load", r)))

    def knots(self) -> Array:
        """Return the radii at which the tension is reported, linear in between.

        The places, what the schedules take, and more, even in x.  No tension takes part in their
        choice, so that the roll does not depend on where the winding was begun.
        """
        core, R = self.problem.ends
        r = looked_at(self.problem)
        nominal = self.wound_on(np.full(r.size, NOMINAL), r)
        first = core + self.problem.web.thickness  # where the share begins to change
        places = [self.radius(place) for place in self.places]
        own = told_radii(self.problem, r, nominal, self.rtol, [*places, first])
        x = np.linspace(np.log(first - core), np.log(R - core), self.lines + 1)
        near = np.abs(x[:, None] - np.log(own[1:] - core)).min(axis=1) < (x[1] - x[0]) / 2
        return np.union1d(own, core + np.exp(x[~near]))

    def drawn_finer(self, values: Mapping[float, float]) -> bool:
        """Take more radii until straight lines between them do; tell whether any were needed."""
        before = self.lines
        while True:
            r = self.knots()
            off, on_core = self._straight(values, r, self.tension(values, r))
            if max(off, on_core / LESS_EXACT) <= STRAIGHT * self.rtol:
                return self.lines > before
            self.lines = ceil(FINER * self.lines)

    def _straight(
        self, values: Mapping[float, float], r: Array, tension: Array
    ) -> tuple[float, float]:
        """Return by how much of it straight lines miss the tension, and in the piece on the core.

        Of fewer laps than ten nothing is known.
        """
        fine = looked_at(self.problem)
        off = np.abs(np.interp(fine, r, tension) / self.tension(values, fine) - 1)
        first, rest = (self.radius(self.pieces[k].start) for k in (0, int(self.on_core)))
        on_core = off[(fine >= first) & (fine < rest)]
        return float(np.max(off[fine >= rest])), float(np.max(on_core, initial=0.0))

    # ---- how far it may be off ------------------------------------------------------------------

    def errors(self, values: Mapping[float, float]) -> list[float]:
        """Return of each piece by how much of the tension it may be off."""
        return [
            max(self._relative(place, off, values[place]) for place, off in piece.misses(values))
            for piece in self.pieces
        ]

    def _relative(self, place: float, off: float, value: float) -> float:
        """Return by how much of the tension a share is off."""
        r = np.array(self.radius(place))
        added = off * self.problem.roll_friction * self.problem.at("nip_load", r)
        return float(added / self.wound_on(np.array(value), r))

    def off(self, values: Mapping[float, float], r: Array, tension: Array) -> float:
        """Return by how much of it the tension reported at some radii may be off between nips."""
        fine = looked_at(self.problem)
        straight, _ = self._straight(values, r, tension)
        unseen = self._unseen(fine, self.tension(values, fine))
        return max(self.errors(values)[self.on_core :]) + straight + unseen

    def off_on_core(self, values: Mapping[float, float], r: Array, tension: Array) -> float:
        """Return by how much of it the tension in the piece on the core may be off."""
        return (
            self.errors(values)[0] + self._straight(values, r, tension)[1] if self.on_core else 0.0
        )

    def _unseen(self, r: Array, tension: Array) -> float:
        """Return what schedules may do to the tension between nips, of it.

        Where the nip load is off its own polynomial through the nips, so is the share; by less than
        half as much, for NIT grows with a power of the load between 1/2 and 1.
        """
        at = self.problem.at
        loads = {place: float(at("nip_load", self.radius(place))) for place in self.places}
        off = np.abs(self.shares(loads, r) / at("nip_load", r) - 1) / 2
        added = np.abs(tension - at("web_tension", r)) / tension
        return float(np.max((off * added)[r >= self.radius(self.pieces[0].start)]))


def sharp_kinks(problem: WindingProblem) -> dict[float, float]:
    """Return the radii at which a schedule has a sharp kink [m], and how sharp it is."""
    return {r: bend for r, bend in problem.kinks.items() if bend > SHARP}


def looked_at(problem: WindingProblem) -> Array:
    """Return radii, dense near the core, among which are those of the reported tension [m]."""
    core, R = problem.ends
    lap = problem.web.thickness
    deep = core + np.exp(np.linspace(np.log(lap), np.log(R - core), LOOKED_AT))
    r = np.union1d(deep[:-1], problem.radii(LOOKED_AT))
    r = r[np.append(True, np.diff(r) > 1e-9 * R)]
    r[-1] = R
    return np.asarray(r)


def told_radii(
    problem: WindingProblem, r: Array, tension: Array, rtol: float, own: Sequence[float] = ()
) -> Array:
    """Return which radii the tension and the schedules take, drawn linear between, and own ones."""
    curves = [tension, *(problem.at(name, r) for name in LOADS)]
    within = STRAIGHT * rtol
    taken = np.any([_points_needed(r, y, within * np.max(np.abs(y))) for y in curves], axis=0)
    found, R = r[taken], problem.radius
    apart = np.abs(found[:, None] - np.array([*own, -R])).min(axis=1) > 1e-9 * R
    return np.union1d(found[apart], list(own))


def _points_needed(r: Array, values: Array, within: float) -> Array:
    """Return which points a line through them needs, to miss none by more (Douglas, Peucker)."""
    keep = np.zeros(r.size, dtype=bool)
    keep[[0, -1]] = True
    waiting = [(0, r.size - 1)]
    while waiting:
        a, b = waiting.pop()
        line = values[a] + (values[b] - values[a]) * (r[a : b + 1] - r[a]) / (r[b] - r[a])
        off = np.abs(values[a : b + 1] - line)
        k = a + int(np.argmax(off))
        if off[k - a] > within:
            keep[k] = True
            waiting += [(a, k), (k, b)]
    return keep
