r"""Winding: from a problem to a certified result.

The one loop of the program that goes from a result back to a problem:

    wound-on tension over the radius ----> the roll, all its stages         roll/
             ^                                      |  the pressure wound so far
             |   polynomials through few radii      v
             +------------------------------ nips at these radii            wrap/
                      interpolation                  bodies

What a nip adds depends on the radius, and on the stack just below the surface, which the last laps
have wound: hardly on what is below.  So the loop closes in a few turns, each radius for itself by a
secant, and radii are added where the polynomial without them is off by more than rtol.  The curve
is of the share y = (WOT - T_in)/(mu+ P), which hardly varies: what the schedules do is in T_in, P.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from itertools import pairwise
from math import nan
from typing import Any

import numpy as np

from ..air.solve import solved_with_air
from ..arguments import check_type, tolerance, whole_number
from ..errors import RESOLUTION, InvalidProblem, NotConverged, unwarned
from ..problems.bodies import Body
from ..problems.nip import WrappedNipProblem
from ..problems.roll import FEWEST_LAPS
from ..problems.schedules import Profile
from ..problems.winding import LOADS, WindingProblem
from ..results import Residuals
from ..roll.result import WoundRollResult
from ..threads import one_thread
from ..wrap.result import WrappedNipResult
from ..wrap.solve import solve_wrapped_nip
from .bodies import Felt, solved_nip
from .certificate import certificate
from .interpolation import Piece
from .result import WindingResult
from .roll import wind

__all__ = ["check_options", "solve_winding"]

Array = np.ndarray
Progress = Callable[[int, int], None]

RTOL, NODES = 1e-3, 65
AGREED = {"effective": 1e-6, "linear": 1e-6, "direct": 1e-5}
MOST_NIPS = 40  # radii
MOST_TURNS = 25
PATIENT = 9  # turns, after which an agreement to rtol will do: nips whose zones jump do no better
EXPECTED_TURNS = 4  # for the progress told
# Depth of the roll at the first nip, of the core's radius: on less the contact is wider than the
# roll is deep.  Below, the share goes on along its tangent
FIRST = 0.05
SHARP = 0.1  # of a kink, r |d slope|/value, from which the curve is drawn in two pieces
MOST_PIECES = 6
LOOKED_AT = 200  # radii from which those of the curve told are taken
STRAIGHT = 0.3  # of rtol, by which the curve may miss the line between two of them
STAY = 1e-3  # change of the tension from which on they stay
SETTLED = 0.01  # and from which on roll and nips are solved well
COARSE_RTOL, COARSE_NODES = 0.05, 33  # until then
# to what the pressure that a nip's roll feels is found in one turn
FELT_COARSELY, FELT = 0.02, 3e-3
FIRST_SHARE = 0.6  # of mu P, to begin with
LEAST_RTOL, LEAST_AGREED = 1e-6, 1e-8


@one_thread
def solve_winding(
    problem: WindingProblem,
    *,
    rtol: float = RTOL,
    nodes: int = NODES,
    agreed: float | None = None,
    start: WindingResult | None = None,
    progress: Progress | None = None,
) -> WindingResult:
    """Wind a roll: nips as it grows, and the stresses that they leave, until both agree.

    Parameters
    ----------
    problem : WindingProblem
    rtol : float
        Accepted error of the interpolation between the nips, relative to the wound-on tension, and
        of the roll's pressure; 1e-6 to 0.1.
    nodes : int
        Of every nip, 17 to 1025.
    agreed : float, optional
        To what of the wound-on tension nips and roll are to agree, 1e-8 to 1e-2; by default 1e-6,
        and 1e-5 with a direct roll.
    start : WindingResult, optional
        A neighbouring case, to start from its tension.  The answer does not depend on it.
    progress : callable, optional
        Is called with how many nips are solved, and how many are expected in all.

    Returns
    -------
    WindingResult

    Raises
    ------
    InvalidProblem
        For options out of range, or a nip that is not admissible, with its radius.
    NoSteadyState
        If the drum slides or the web is slack at some radius.
    NotConverged
        If a nip or the roll is not solved, or nips and roll do not agree.
    """
    check_type("problem", problem, WindingProblem)
    check_options(rtol=rtol, nodes=nodes, agreed=agreed)
    if start is not None:
        check_type("start", start, WindingResult)
    with unwarned():  # told once, with the radius
        winder = _Winder(
            problem, rtol, nodes, AGREED[problem.roll_body] if agreed is None else agreed, progress
        )
        result = winder.coupled(start) if problem.tension_law == "nip" else winder.given()
    return result.replace(residuals=certificate(result)).checked().warned()


def check_options(
    *, rtol: Any = RTOL, nodes: Any = NODES, agreed: Any = None, start: Any = None
) -> None:
    """Check the options of :func:`solve_winding`.

    Raises
    ------
    InvalidProblem
        For an option out of range.
    """
    tolerance("rtol", rtol, LEAST_RTOL, 0.1)
    whole_number("nodes", nodes, 17, 1025)
    if agreed is not None:
        tolerance("agreed", agreed, LEAST_AGREED, 1e-2)


@dataclass
class _Winder:
    """Winds one roll."""

    problem: WindingProblem
    rtol: float
    nodes: int
    agreed: float
    progress: Progress | None
    solved: int = 0  # nips
    coarse: bool = False  # whether a turn is far from the last
    nips: dict[float, Felt] = field(default_factory=dict)  # by place, ln(r - r_c)
    film: float = 0.0  # of air, that the roll was wound with
    films: dict[float, float] = field(default_factory=dict)  # that the nips let through, by radius
    frictions: dict[float, tuple[float, float]] = field(default_factory=dict)  # that they leave

    # ---- radii and places -----------------------------------------------------------------------

    def __post_init__(self) -> None:
        problem = self.problem
        core, R = problem.ends
        self.first = max(FEWEST_LAPS * problem.web.thickness * (1 + 1e-9), FIRST * core)
        self.first = min(self.first, max(0.25 * (R - core), FEWEST_LAPS * problem.web.thickness))
        sharp = {r: bend for r, bend in problem.kinks.items()
                 if bend > SHARP and core + self.first < r < R}  # fmt: skip
        cuts = sorted(sorted(sharp, key=sharp.__getitem__)[-MOST_PIECES + 1 :])
        ends = [float(np.log(r - core)) for r in (core + self.first, *cuts, R)]
        self.pieces = [Piece(a, b) for a, b in pairwise(ends)]

    def radius(self, place: float) -> float:
        """Return the radius of a place [m]; at the surface exactly."""
        core, R = self.problem.ends
        return R if place == self.pieces[-1].end else core + float(np.exp(place))

    def places(self, r: Array) -> Array:
        """Return the places of radii; that of the tenth lap of all before."""
        least = FEWEST_LAPS * self.problem.web.thickness
        return np.log(np.maximum(r - self.problem.core.radius, least))

    def shares(self, values: Mapping[float, float], r: Array) -> Array:
        """Return y at radii, from values at the pieces' points."""
        x = self.places(r)
        out = np.empty(x.shape)
        for piece in self.pieces:
            own = x >= piece.start - 1e-12
            out[own] = piece.at(np.clip(x[own], piece.start, piece.end), values)
        below, first = x < self.pieces[0].start, self.pieces[0]
        step = 1e-4 * (first.end - first.start)
        one, two = first.at(first.start + np.array([0.0, step]), values)
        out[below] = one + (two - one) / step * (x[below] - first.start)
        return out

    def tension(self, shares: Array, r: Array) -> Array:
        """Return WOT of shares at radii [N/m]."""
        at = self.problem.at
        return at("web_tension", r) + shares * self.problem.roll_friction * at("nip_load", r)

    # ---- roll and nips --------------------------------------------------------------------------

    def knots(self, given: Mapping[float, float]) -> Array:
        """Return the radii at which the tension is told: the nips', and what it takes between."""
        core, R = self.problem.ends
        least = FEWEST_LAPS * self.problem.web.thickness
        deep = core + np.exp(np.linspace(np.log(least), np.log(R - core), LOOKED_AT))
        even = self.problem.radii(LOOKED_AT)
        r = np.union1d(deep[:-1], even)
        r = r[np.append(True, np.diff(r) > 1e-9 * R)]
        r[-1] = R
        tension = self.tension(self.shares(given, r), r)
        own = [self.radius(place) for place in given]
        found = r[_needed(r, tension, STRAIGHT * self.rtol * np.max(np.abs(tension)))]
        apart = np.abs(found[:, None] - np.array([*own, -R])).min(axis=1) > 1e-9 * R
        return np.union1d(found[apart], own)

    def wound(self, r: Array, tension: Array) -> WoundRollResult:
        """Return the roll wound with a tension."""
        self.film = self.mean_film()
        return wind(self.problem, r, tension, max(self.rtol, COARSE_RTOL * self.coarse), self.film)

    def nip(self, place: float, roll: WoundRollResult) -> float:
        """Solve the nip at a place on a roll; return the share y that it answers."""
        radius = self.radius(place)
        before = self.nips.get(place) or self._nearest(place)
        with _at(radius):
            stage = roll if radius == self.problem.radius else roll.at(radius)
            felt = solved_nip(
                self.on(roll),
                stage,
                before,
                self._solve,
                FELT_COARSELY if self.coarse else FELT,
            )
        self.nips[place] = felt
        at = self.problem.at
        gained = felt.tension - float(at("web_tension", radius))
        return gained / (self.problem.roll_friction * float(at("nip_load", radius)))

    def on(self, roll: WoundRollResult) -> WindingProblem:
        """Return the problem with the stack of a roll, air and all."""
        stack = roll.problem.stack
        return self.problem if stack is self.problem.stack else self.problem.replace(stack=stack)

    def _nearest(self, place: float) -> Felt | None:
        found = min(self.nips, key=lambda other: abs(other - place), default=None)
        return None if found is None else self.nips[found]

    def _solve(self, roll: Body, start: WrappedNipResult | None) -> WrappedNipResult:
        nodes = min(self.nodes, COARSE_NODES) if self.coarse else self.nodes
        result = self._with_its_air(self.problem.nip(roll.radius, roll), nodes, start)
        self.solved += 1
        if self.progress is not None:
            points = sum(len(piece.places) for piece in self.pieces)
            self.progress(self.solved, max(EXPECTED_TURNS * points, self.solved))
        return result

    def _with_its_air(
        self, nip: WrappedNipProblem, nodes: int, start: WrappedNipResult | None
    ) -> WrappedNipResult:
        """Solve a nip, with the friction that its air leaves; keep the film."""
        radius = nip.roll.radius
        if self.problem.air is None:
            self.films[radius] = 0.0
            return solve_wrapped_nip(nip, nodes=nodes, start=start)
        near = min(self.films, key=lambda other: abs(other - radius), default=None)
        result, found = solved_with_air(
            self.problem.with_air(nip), None if near is None else self.frictions[near], self.agreed,
            nodes=nodes, start=start,
        )  # fmt: skip
        self.films[radius] = found["film"]
        self.frictions[radius] = found["roll_friction"], found["wrap_friction"]
        return result

    def mean_film(self) -> float:
        """Return the mean of the nips' films over the length of web [m]."""
        if not any(self.films.values()):
            return 0.0
        r = np.array(sorted(self.films))
        h = np.array([self.films[radius] for radius in r.tolist()])
        return float(np.trapezoid(h * r, r) / np.trapezoid(r, r)) if r.size > 1 else float(h[0])

    # ---- the loop -------------------------------------------------------------------------------

    def coupled(self, start: WindingResult | None) -> WindingResult:
        """Wind with the nips' tension."""
        given = {place: self._first(start, place) for p in self.pieces for place in p.places}
        before: tuple[dict[float, float], dict[float, float]] | None = None
        r, change, added, self.coarse = self.knots(given), 1.0, True, True
        for turn in range(MOST_TURNS):
            if added or change > STAY:  # the same from then on, for the turns to settle
                r = self.knots(given)
            if self.coarse and change <= SETTLED:
                self.coarse, before = False, None
            roll = self.wound(r, self.tension(self.shares(given, r), r))
            answers = {place: self.nip(place, roll) for place in given}
            added = not self.coarse and self._refined(given, answers, roll)
            change = max(abs(self._off(place, share)) for place, share in given.items())
            # of a lap, what more of air it would hold
            change = max(change, abs(self.mean_film() - self.film) / self.problem.web.thickness)
            settled = not added and not self.coarse
            if settled and turn >= PATIENT and change <= self.rtol:
                self.agreed = max(self.agreed, 1.001 * change)  # as well as it will
            if settled and change <= self.agreed:
                return self._result(r, given, answers, roll)
            own = before if self.problem.roll_body == "direct" else None
            given, before = _corrected(given, answers, own), (given, answers)
        raise NotConverged(
            f"nips and roll do not agree: after {MOST_TURNS} turns the wound-on tension still "
            f"changes by {change:.2g} of it",
            self._result(r, before[0], answers, roll) if before else None,
        )

    def _off(self, place: float, share: float) -> float:
        """Return by what of it a nip's wound-on tension is off the one it was wound with."""
        r = np.array(self.radius(place))
        return (
            float(self.tension(np.array(share), r)) / self.nips[place].result.wound_on_tension - 1
        )

    def _first(self, start: WindingResult | None, place: float) -> float:
        if start is None:
            return FIRST_SHARE
        r = np.array(self.radius(place))
        told = np.interp(r, start.radius, start.nip_induced_tension)
        return float(told / (self.problem.roll_friction * self.problem.at("nip_load", r)))

    def _relative(self, place: float, share: float) -> float:
        """Return by how much of the wound-on tension a share is."""
        result, problem = self.nips[place].result, self.problem
        return share * problem.roll_friction * result.problem.nip_load / result.wound_on_tension

    def _errors(self, answers: Mapping[float, float]) -> list[float]:
        """Return of each piece by how much of the tension it may be off."""
        told = []
        for piece in self.pieces:
            misses = [abs(self._relative(*miss)) for miss in piece.misses(answers)]
            told.append(max(misses, default=np.inf))
        return told

    def _refined(
        self, given: dict[float, float], answers: dict[float, float], roll: WoundRollResult,
    ) -> bool:  # fmt: skip
        """Add radii until the interpolation is good enough; tell whether any were needed."""
        added = False
        while (errors := self._errors(answers)) and max(errors) > self.rtol:
            piece = self.pieces[int(np.argmax(errors))]
            if len(answers) >= MOST_NIPS:
                r = self.radius(piece.misses(answers)[-1][0])
                raise NotConverged(
                    f"rtol={self.rtol:g} is not reached with {MOST_NIPS} nips: at the radius "
                    f"{r:.4g} m their wound-on tension is {max(errors):.2g} off between them; "
                    "smoother schedules, or a larger rtol"
                )
            place = piece.next
            given[place] = float(piece.at(np.array(place), given))
            answers[place] = self.nip(place, roll)
            piece.places.append(place)
            added = True
        return added

    # ---- results --------------------------------------------------------------------------------

    def given(self) -> WindingResult:
        """Wind with a tension that takes no nip."""
        problem = self.problem
        law, at = problem.tension_law, problem.at
        r = problem.radii(LOOKED_AT)
        if isinstance(law, Profile):
            tension = problem.curve("tension_law").at(r)
        else:
            tension = at("web_tension", r)
            if law == "fixed":
                tension = tension + at("nip_induced_tension", r)
            else:
                tension = tension + at("winding_force", r)
                tension = tension + problem.roll_friction * at("nip_load", r)
        return self._told(r, tension, self.wound(r, tension), {}, 0.0)

    def _result(
        self, r: Array, given: Mapping[float, float], answers: Mapping[float, float],
        roll: WoundRollResult,
    ) -> WindingResult:  # fmt: skip
        shares = self.shares(given, r)
        between = (r[1:] + r[:-1]) / 2
        drawn = (shares[1:] + shares[:-1]) / 2 - self.shares(given, between)
        straight = np.max(
            np.abs(self.tension(drawn, between) / self.tension(0 * drawn, between) - 1)
        )
        return self._told(
            r, self.tension(shares, r), roll, answers, max(self._errors(answers)) + straight
        )

    def _told(
        self, r: Array, tension: Array, roll: WoundRollResult, answers: Mapping[float, float],
        interpolation: float,
    ) -> WindingResult:  # fmt: skip
        at, places = self.problem.at, sorted(answers)
        nips = [self.nips[place] for place in places]
        loads: dict[str, Any] = {name: at(name, r) for name in LOADS}
        result = WindingResult(
            problem=self.problem,
            radius=r,
            **loads,
            nip_induced_tension=tension - loads["web_tension"],
            wound_on_tension=tension,
            nip_radius=np.array([self.radius(place) for place in places]),
            nip_wound_on_tension=np.array([felt.result.wound_on_tension for felt in nips]),
            nip_half_width=np.array([felt.result.half_width for felt in nips]),
            nip_peak_pressure=np.array([felt.result.peak_pressure for felt in nips]),
            nip_felt_pressure=np.array([felt.pressure for felt in nips]),
            nip_air_film=np.array([self.films[self.radius(place)] for place in places]),
            nip_friction=np.array([felt.result.problem.roll_friction for felt in nips]),
            air_film=self.film,
            nip_error=np.array([felt.result.wound_on_tension_error for felt in nips]),
            nip_residual=np.array([felt.result.residual for felt in nips]),
            interpolation_error=float(interpolation),
            nodes=self.nodes,
            roll_rtol=self.rtol,
            agreed=self.agreed,
            nips_solved=self.solved,
            residuals=Residuals(),
            warnings=_warnings([(self.radius(p), self.nips[p].result) for p in places]),
            wound=roll,
        )
        return result.replace(errors=_errors(result))


def _needed(r: Array, values: Array, within: float) -> Array:
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


def _corrected(
    given: Mapping[float, float], answers: Mapping[float, float],
    before: tuple[Mapping[float, float], Mapping[float, float]] | None,
) -> dict[float, float]:  # fmt: skip
    """Return the next shares: each by a secant of its own, for nips feel little of each other.

    An effective roll needs none: what it feels is found with the tension that it gives.
    """
    found = {}
    for place, share in given.items():
        steep, answer = 0.0, answers[place]
        if before is not None and place in before[0]:
            moved = share - before[0][place]
            if abs(moved) > 1e-12:
                steep = float(np.clip((answer - before[1][place]) / moved, -0.5, 0.3))
        found[place] = share + (answer - share) / (1 - steep)
    return found


@contextmanager
def _at(radius: float) -> Iterator[None]:
    """Name the radius at which a nip fails."""
    where = f"at the radius {radius:.4g} m: "
    try:
        yield
    except InvalidProblem as fault:
        raise type(fault)([(f, where + text) for f, text in fault.faults]) from None
    except NotConverged as stop:
        raise NotConverged(where + str(stop), stop.best) from None


def _warnings(nips: list[tuple[float, WrappedNipResult]]) -> tuple[str, ...]:
    """Return the nips' warnings, each sort once, with the radius where it first comes up."""
    told: dict[str, str] = {}
    for radius, result in nips:
        for text in result.warnings:
            sort = re.sub(r"[\d.e+-]+", "", text)
            mark = RESOLUTION if text.startswith(RESOLUTION) else ""
            where = f"nip at the radius {radius:.4g} m: "
            told.setdefault(sort, mark + where + text.removeprefix(RESOLUTION))
    return tuple(told.values())


def _errors(result: WindingResult) -> dict[str, float]:
    """Return the errors told: what nips, their interpolation and the roll leave."""
    told = {}
    share = result.interpolation_error + result.agreed
    if result.nip_radius.size:
        share += float(np.max(result.nip_error / result.nip_wound_on_tension))
        told["mean_wound_on_tension"] = share * result.mean_wound_on_tension
    for name in ("core_pressure", "mid_pressure", "least_hoop_stress"):
        # a roll's pressure goes with about the square of its tension
        own = result.roll.errors.get(name, nan)
        told[name] = own + 2 * share * abs(getattr(result, name))
    return told
