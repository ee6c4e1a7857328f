r"""Winding: from a problem to a certified result.

The one loop of the program that goes from a result back to a problem:

    wound-on tension over the radius ----> the roll, all its stages         roll/
             ^                                      |  the pressure wound so far
             |   polynomials through few radii      v
             +------------------------------ nips at these radii            wrap/
                       curve                     nips, bodies

What a nip adds depends on the radius, and on the stack just below the surface, which the last laps
have wound: hardly on what is below.  So the loop closes in a few turns, each radius for itself:

    linear      no turn at all: the nips do not feel what they have wound
    effective   the tension of a nip on a slightly different roll is predicted, so that two turns
                with nips suffice, and rolls alone in between
    direct      by a secant

Radii are added where the polynomial without them is off by more than rtol.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Annotated, Any

import numpy as np

from ..arguments import Option, check_type, tolerance, whole_number
from ..errors import NotConverged, unwarned
from ..parallel import one_thread
from ..problems.schedules import Profile
from ..problems.winding import WindingProblem
from ..roll.result import RollResult
from ..roll.solve import ThinLaps
from .assembly import assemble_result
from .bodies import tension_on_roll
from .certificate import MOST_AGREED, certificate
from .curve import NOMINAL, TensionCurve, looked_at, told_radii
from .interpolation import Piece
from .measured import Departure, largest_miss, smoothed
from .nips import Nips
from .result import WindingResult
from .roll import changed, wind

__all__ = ["check_options", "solve_winding"]

Array = np.ndarray
Progress = Callable[[float], None]

RTOL, NODES = 1e-3, 65
AGREED = {"effective": 1e-6, "linear": 1e-6, "direct": 1e-5}
MOST_NIPS = 40  # radii
MOST_TURNS = 30
PATIENT = 10  # turns, after which radii are added whatever the tension still changes by
EXPECTED_TURNS = 4  # for the reported progress
SETTLED = 0.03  # change of the tension from which on roll and nips are solved well
# and from which on their answers tell whether more radii are needed, and which: not sooner, or that
# would depend on where the winding was begun
TOLD_BY = {"effective": 5e-3, "linear": 1.0, "direct": 1e-3}
COARSE_RTOL = 0.05  # until then
LEAST_SECANT = 1e-6  # of a share, a step that tells how steep answers are: less is noise
POWER = 0.75  # of the nip load, to which a neighbour's nip-induced tension is proportional
SPARE = 0.9  # of what nips and roll are to agree to, at which the turns end
ROUNDING = 1e-13
LEAST_RTOL, LEAST_AGREED, LEAST_NODES = 1e-6, 1e-8, 25
RTOL_OPTION = Option(
    "Relative error of the solver.",
    "1e-6 to 0.1, of the wound-on tension interpolated between the nips, and of the pressure in "
    "the roll; default 1e-3.",
)
NODES_OPTION = Option(
    "Number of nodes on the last mesh.",
    "25 to 1025, of every nip; default 65. With fewer there is no error estimate.",
)
AGREED_OPTION = Option(
    "Relative tolerance of the nip-roll iteration.",
    "1e-8 to 1e-2, of the wound-on tension; default 1e-6, and 1e-5 with a direct roll.",
)


@one_thread
def solve_winding(
    problem: WindingProblem,
    *,
    rtol: Annotated[float, RTOL_OPTION] = RTOL,
    nodes: Annotated[int, NODES_OPTION] = NODES,
    agreed: Annotated[float | None, AGREED_OPTION] = None,
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
        Of every nip, 25 to 1025: on fewer none tells its error.
    agreed : float, optional
        To what of the wound-on tension nips and roll are to agree, 1e-8 to 1e-2; by default 1e-6,
        and 1e-5 with a direct roll.
    start : WindingResult, optional
        A neighbouring case, to start from its tension and nips.  The answer does not depend on it.
    progress : callable, optional
        Is called with the estimated fraction of the work that is done.

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
    within = AGREED[problem.roll_body] if agreed is None else agreed
    with unwarned():  # reported once, with the radius
        if problem.tension_law != "nip":
            result = _given(problem, rtol, nodes, within)
        elif (smooth := smoothed(problem, rtol)) is not None:
            result = _Winder(smooth, rtol, nodes, within, start, progress).measured(problem)
        else:
            result = _Winder(problem, rtol, nodes, within, start, progress).wound()
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
    whole_number("nodes", nodes, LEAST_NODES, 1025)
    if agreed is not None:
        tolerance("agreed", agreed, LEAST_AGREED, MOST_AGREED)


@dataclass
class _Turn:
    """One turn of the loop: the shares wound with, what the nips on that roll answer."""

    given: dict[float, float]  # by place
    answers: dict[float, float]
    r: Array
    roll: ThinLaps
    film: float  # of air, that the roll was wound with
    change: float  # of the tension, the largest


class _Winder:
    """Winds one roll with the tension of its nips."""

    def __init__(
        self, problem: WindingProblem, rtol: float, nodes: int, agreed: float,
        start: WindingResult | None, progress: Progress | None,
    ) -> None:  # fmt: skip
        self.problem, self.rtol, self.nodes, self.agreed = problem, rtol, nodes, agreed
        self.start, self.progress = start, progress
        self.curve = TensionCurve(problem, rtol)
        self.nips = Nips(problem, nodes, agreed, self._tell, () if start is None else start.nips)

    def wound(self) -> WindingResult:
        """Wind the roll of the problem."""
        return self._told(self._agreed())

    def _agreed(self) -> _Turn:
        """Wind until nips and roll agree."""
        given, change = self._begun()
        before: _Turn | None = None
        steep: dict[float, float] = {}
        solve, certain = True, False
        # the nips of a neighbour give the tension
        self.nips.coarse = change > SETTLED and not self.nips.before
        for number in range(MOST_TURNS):
            if solve and self.nips.coarse and change <= SETTLED:
                self.nips.coarse, before = False, None
            rough = change > SETTLED
            turn = self._turned(given, rough, None if solve else before)
            if solve:
                known = turn.change <= TOLD_BY[self.problem.roll_body] or number >= PATIENT
                certain = known and not self.nips.coarse
            added = solve and certain and self._refined(turn)
            change = turn.change
            settled = certain and not (added or rough)
            if settled and change <= SPARE * self.agreed:
                return turn if solve else self._recompute_roll(turn)
            direct = self.problem.roll_body == "direct"
            given = _corrected(turn, before, steep) if direct else turn.answers
            before = turn
            # every second turn of effective rolls takes no nips
            solve = not (solve and self.problem.roll_body == "effective")
        raise NotConverged(
            f"nips and roll do not agree: after {MOST_TURNS} turns the wound-on tension still "
            f"changes by {change:.2g} of it",
            self._told(before) if before else None,
        )

    def _begun(self) -> tuple[dict[float, float], float]:
        """Return the first shares, and by what of it their tension may be off."""
        given = {place: self._first(place) for place in self.curve.places}
        if self.problem.roll_body != "linear" or self.problem.air is not None:
            return given, 1.0
        # the nips do not feel what they have wound
        given = {place: self._answer(place, None) for place in given}
        while piece := self._wanting(given):
            given[piece.next] = self._answer(piece.next, None)
            piece.places.append(piece.next)
        self.curve.drawn_finer(given)
        return given, 0.0

    def _turned(self, given: dict[float, float], rough: bool, before: _Turn | None) -> _Turn:
        """Wind the roll with shares at places, solve the nips on it.

        Or, after another turn, predict their tension on it.  It is wound in the same stages
        then: other stages might move it by more than nips and roll are to agree to.
        """
        film, r = self.nips.mean_film(), self.curve.knots()
        self.nips.rough = rough
        tension = self.curve.tension(given, r)
        if before is None:
            roll = wind(self.problem, r, tension, max(self.rtol, COARSE_RTOL * rough), film)
            answers = {place: self._answer(place, roll.result) for place in given}
        else:
            roll = changed(self.problem, before.roll, r, tension, film)
            answers = {place: self._predict(place, roll.result) for place in given}
        change = max(self._off(place, share) for place, share in given.items())
        # of a lap, what more of air it would hold
        change = max(change, abs(self.nips.mean_film() - film) / self.problem.web.thickness)
        return _Turn(given, answers, r, roll, film, change)

    def _recompute_roll(self, turn: _Turn) -> _Turn:
        """Return a turn with the roll that its tension makes whatever was wound before."""
        tension = self.curve.tension(turn.given, turn.r)
        return replace(turn, roll=wind(self.problem, turn.r, tension, self.rtol, turn.film))

    def _predict(self, place: float, roll: RollResult) -> float:
        radius = self.curve.radius(place)
        return self.curve.share(self.nips.predict(radius, roll), radius)

    def _answer(self, place: float, roll: RollResult | None) -> float:
        radius = self.curve.radius(place)
        return self.curve.share(self.nips.tension(radius, roll), radius)

    def _tension(self, place: float, share: float) -> float:
        return float(self.curve.wound_on(np.array(share), np.array(self.curve.radius(place))))

    def _off(self, place: float, share: float) -> float:
        """Return by what of it the tension wound with is off what a nip answers, at the most.

        That is the tension of the nip solved, and that on the roll it asks for.
        """
        felt, given = self.nips.felt[self.curve.radius(place)], self._tension(place, share)
        return max(abs(given / due - 1) for due in (tension_on_roll(felt.result), felt.tension))

    def _first(self, place: float) -> float:
        if self.start is None:
            return NOMINAL
        r = self.curve.radius(place)
        # the nip-induced tension varies as a power of the nip load, between 1/2 and 1
        ratio = self.start.nip_induced_tension / self.start.nip_load**POWER
        friction = self.problem.roll_friction * self.problem.at("nip_load", r) ** (1 - POWER)
        return float(np.interp(r, self.start.radius, ratio) / friction)

    def _refined(self, turn: _Turn) -> bool:
        """Add radii until the interpolation is good enough; tell whether any were needed."""
        added, answers = False, turn.answers
        while piece := self._wanting(answers):
            place = piece.next
            turn.given[place] = float(piece.at(np.array(place), turn.given))
            answers[place] = self._answer(place, turn.roll.result)
            turn.change = max(turn.change, self._off(place, turn.given[place]))
            piece.places.append(place)
            added = True
        return self.curve.drawn_finer(answers) or added

    def _wanting(self, answers: dict[float, float]) -> Piece | None:
        """Return the piece that is the farthest off, None where all are good enough."""
        curve = self.curve
        errors = np.divide(curve.errors(answers), curve.allowed)
        worst = int(np.argmax(errors))
        piece = curve.pieces[worst]
        if errors[worst] <= 1:
            return None
        if len(answers) >= MOST_NIPS:
            r = curve.radius(piece.misses(answers)[-1][0])
            raise NotConverged(
                f"rtol={self.rtol:g} is not reached with {MOST_NIPS} nips: at the radius "
                f"{r:.4g} m their wound-on tension is {curve.errors(answers)[worst]:.2g} off "
                "between them; smoother schedules, or a larger rtol"
            )
        return piece

    def _tell(self, solved: int) -> None:
        if self.progress is not None:
            self.progress(min(solved / (EXPECTED_TURNS * len(self.curve.places)), 1.0))

    def _told(self, turn: _Turn) -> WindingResult:
        curve, r = self.curve, turn.r
        tension = curve.tension(turn.given, r)
        return assemble_result(
            self.problem, r, tension, turn.roll, self.nips,
            interpolation=(
                curve.off(turn.answers, r, tension), curve.off_on_core(turn.answers, r, tension)
            ),
            rtol=self.rtol, agreed=self.agreed, film=turn.film,
            bent=curve.tension(turn.given, r, bent=True),
        )  # fmt: skip

    def measured(self, problem: WindingProblem) -> WindingResult:
        """Wind the roll of a problem whose schedules wander about those that are wound here."""
        turn, curve = self._agreed(), self.curve
        departs = Departure(problem, self.problem, curve, self.nips)

        def tension(at: Array, *, bent: bool = False) -> Array:
            return curve.tension(turn.given, at, bent=bent) + departs(at)

        fine = looked_at(problem)
        own = [curve.radius(place) for place in curve.places]
        r = told_radii(problem, fine, tension(fine), self.rtol, own)
        roll = wind(problem, r, tension(r), self.rtol, turn.film)
        known = self.nips
        checks = Nips(
            problem, self.nodes, self.agreed, known.tell, known.from_core_to_surface(), known.solved
        )
        missed = largest_miss(departs, checks, roll.result, tension)
        known.solved = checks.solved
        drawn = np.interp(turn.r, r, tension(r) - departs(r))
        smooth = curve.off(turn.answers, turn.r, drawn)
        return assemble_result(
            problem, r, tension(r), roll, known,
            interpolation=(smooth + missed, curve.off_on_core(turn.answers, turn.r, drawn)),
            rtol=self.rtol, agreed=self.agreed, film=turn.film, bent=tension(r, bent=True),
            departure=departs(np.array(sorted(own))),
        )  # fmt: skip


def _corrected(turn: _Turn, before: _Turn | None, steep: dict[float, float]) -> dict[float, float]:
    """Return the next shares: each by a secant of its own, for nips feel little of each other.

    How ``steep`` its answers are is kept by place: so much the same on another mesh, and, of a new
    place, as the others are.
    """
    known = before or turn
    for place, share in turn.given.items():
        moved = share - known.given.get(place, share)
        if abs(moved) > LEAST_SECANT:
            by = (turn.answers[place] - known.answers[place]) / moved
            steep[place] = float(np.clip(by, -0.5, 0.3))
    usual = float(np.median([*steep.values()])) if steep else 0.0
    return {
        place: share + (turn.answers[place] - share) / (1 - steep.setdefault(place, usual))
        for place, share in turn.given.items()
    }


def _given(problem: WindingProblem, rtol: float, nodes: int, agreed: float) -> WindingResult:
    """Wind with a tension that takes no nip."""
    law, at, r = problem.tension_law, problem.at, looked_at(problem)
    if isinstance(law, Profile):
        tension = problem.curve("tension_law").at(r)
    elif law == "fixed":
        tension = at("web_tension", r) + at("nip_induced_tension", r)
    else:
        tension = at("web_tension", r) + at("winding_force", r)
        tension = tension + problem.roll_friction * at("nip_load", r)
    own = told_radii(problem, r, tension, rtol)
    drawn = np.interp(own, r, tension)
    off = float(np.max(np.abs(np.interp(r, own, drawn) - tension)) / np.max(np.abs(tension)))
    return assemble_result(
        problem, own, drawn, wind(problem, own, drawn, rtol),
        Nips(problem, nodes, agreed, lambda _: None),
        interpolation=(off * (off > ROUNDING), 0.0), rtol=rtol, agreed=agreed, film=0.0,
    )  # fmt: skip
