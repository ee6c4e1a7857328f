r"""Solver of a winding: fixed-point iteration between the nips and the roll.

    wound-on tension over the radius ----> the roll, all its stages         roll/
             ^                                      |  the pressure wound so far
             |   polynomials through few radii      v
             +------------------------------ nips at these radii            wrap/
                       curve                     nips, bodies

The nip-induced tension depends on the radius and on the pressure of the outermost layers, and
hardly on the layers below.  The iteration therefore converges quickly, separately at each radius;
its roll is without the changes after winding, which :mod:`.assembly` applies to the result.

    linear      no iteration: the nips do not depend on the wound roll
    effective   between iterations with nips, only the roll is recomputed, and the tensions of the
                nips are extrapolated to it until both agree; three iterations with nips usually
                suffice, the first on a coarse mesh
    direct      secant method

Radii are added until the error estimate of the interpolation is below rtol.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np

from ..arguments import Option, check_type, tolerance, whole_number
from ..errors import NotConverged, unwarned
from ..parallel import one_thread
from ..problems.schedules import Profile
from ..problems.winding import WindingProblem
from ..roll.lane_roll import FEWEST_LANES, LANES, MOST_LANES
from ..roll.result import RollResult
from ..roll.solve import LANES_OPTION, PASSES_OF_LANES, WoundRoll, pass_reporter
from .assembly import assemble_result
from .bodies import tension_on_roll
from .certificate import LARGEST_COUPLING_RTOL, certificate
from .curve import NOMINAL, TensionCurve, polyline_radii, sampling_radii
from .foil import mean_foil_film
from .interpolation import Piece
from .lane_nips import lanes_of_winding
from .measured import CHECKS, Departure, largest_mismatch, smoothed
from .nips import Nips
from .result import WindingResult
from .roll import recomputed, wind

__all__ = ["check_options", "solve_winding"]

Array = np.ndarray
Progress = Callable[[float], None]

RTOL, NODES = 1e-3, 65
SURVEY = 1e-2  # rtol from which on a winding without error estimates begins with fewer nips
# Tolerance of the nip-roll iteration with the default ``rtol``.  It increases in proportion to a
# larger ``rtol``: the stages of the roll follow ``rtol``, and another stage changes the tension.
COUPLING_RTOL = {"effective": 1e-6, "linear": 1e-6, "direct": 1e-5}
MAX_NIPS = 40  # radii
MAX_ITERATIONS = 30
# Iterations after which radii are added even if the tension still changes.
MAX_UNREFINED_ITERATIONS = 10
# For the reported progress: the iteration reduces the change from 1 to its tolerance at about the
# same factor in each pass; of a winding without iteration the expected number of nips.  The last
# part is the roll, the nips that check measured schedules, and the certificate.
FIRST_GAIN, LEAST_GAIN, EXPECTED_NIPS = 0.2, 0.05, 16
OF_ITERATIONS, OF_MEASURED = 0.95, 0.75
OF_MEAN_WEB = 0.6  # share of the winding of the mean web if lanes follow
ROUGH_CHANGE = 0.03  # relative change of the tension above which lower accuracies are used
# Relative change below which radii may be added, or rtol if that is larger.  With larger changes
# the choice of the radii would depend on the initial guess.
REFINEMENT_CHANGE = {"effective": 5e-3, "linear": 1.0, "direct": 1e-3}
# Iterations with extrapolated nips: the most, and the relative difference of the tension at which
# they end: while the nips are coarse, and before the nips are solved on the next roll in units of
# the tolerance.
MAX_EXTRAPOLATIONS, SETTLED_ROUGHLY, BEFORE_NIPS = 5, 1e-3, 5.0
FEWEST_PRESSURES = 3  # from which effective pressures are interpolated
MIN_SECANT_STEP = 1e-6  # of a share; the slope of a smaller one is too noisy
POWER = 0.75  # exponent of the nip load in the initial guess of the nip-induced tension
STOP_FRACTION = 0.9  # fraction of ``coupling_rtol`` at which the iteration stops
ROUNDING = 1e-13
LEAST_RTOL, SMALLEST_COUPLING_RTOL, LEAST_NODES = 1e-6, 1e-8, 25
RTOL_OPTION = Option(
    "Relative error of the solver.",
    "1e-6 to 0.1, of the wound-on tension interpolated between the nips, and of the pressure in "
    "the roll; default 1e-3.",
)
NODES_OPTION = Option(
    "Number of nodes on the last mesh.",
    "25 to 1025, of every nip; default 65. With fewer there is no error estimate.",
)
COUPLING_RTOL_OPTION = Option(
    "Relative tolerance of the nip-roll iteration.",
    "1e-8 to 1e-2, of the wound-on tension; default 1e-6, and 1e-5 with a direct roll, more with "
    "an rtol above 1e-3.",
)


@one_thread
def solve_winding(
    problem: WindingProblem,
    *,
    rtol: Annotated[float, RTOL_OPTION] = RTOL,
    nodes: Annotated[int, NODES_OPTION] = NODES,
    coupling_rtol: Annotated[float | None, COUPLING_RTOL_OPTION] = None,
    lanes: Annotated[int, LANES_OPTION] = LANES,
    start: WindingResult | None = None,
    errors: bool = True,
    progress: Progress | None = None,
) -> WindingResult:
    """Solve a winding: the nips on the growing roll and the stresses in the roll.

    Parameters
    ----------
    problem : WindingProblem
    rtol : float
        Accepted error of the interpolation between the nips, relative to the wound-on tension, and
        of the roll's pressure; 1e-6 to 0.1.
    nodes : int
        Number of nodes of every nip, 25 to 1025; an error estimate needs at least 25.
    coupling_rtol : float, optional
        Tolerance of the nip-roll iteration, relative to the wound-on tension, 1e-8 to 1e-2; by
        default 1e-6, and 1e-5 with a direct roll, multiplied by rtol/1e-3 if rtol is larger.
    lanes : int
        Number of lanes into which the width is divided if the problem has a thickness profile.
    start : WindingResult, optional
        A neighbouring case whose tension and nips are the initial guess.  It does not change the
        result beyond the tolerances.
    errors : bool
        False omits the error estimates of the nips and what follows from them, a fifth of the time,
        and with rtol >= 1e-2 begins the interpolation between the nips with fewer of them.
    progress : callable, optional
        Called with the estimated fraction of the work that is done.

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
        If a nip or the roll cannot be solved, or the nip-roll iteration does not converge.
    """
    check_type("problem", problem, WindingProblem)
    check_options(rtol=rtol, nodes=nodes, coupling_rtol=coupling_rtol, lanes=lanes, errors=errors)
    if start is not None:
        check_type("start", start, WindingResult)
    coupling_tolerance = coupling_rtol
    if coupling_tolerance is None:
        coupling_tolerance = COUPLING_RTOL[problem.roll_body] * max(1.0, rtol / RTOL)
    has_lanes = problem.thickness_profile is not None

    def report(done: float) -> None:
        """Report the fraction of the winding of the mean web that is done."""
        if progress is not None:
            progress((OF_MEAN_WEB if has_lanes else 1.0) * done)

    with unwarned():  # reported once, with the radius
        if not problem.solves_nips:
            result = _solve_prescribed(problem, rtol, nodes, coupling_tolerance)
        elif (smooth := smoothed(problem, rtol)) is not None:
            winder = _Winder(smooth, rtol, nodes, coupling_tolerance, start, errors, report)
            result = winder.solve_measured(problem)
        else:
            winder = _Winder(problem, rtol, nodes, coupling_tolerance, start, errors, report)
            result = winder.solve()
    result = result.replace(residuals=certificate(result)).checked()
    if has_lanes:
        radii = problem.core.radius, problem.radius
        report_lanes = pass_reporter(progress, radii, PASSES_OF_LANES, OF_MEAN_WEB)
        lane_roll = lanes_of_winding(result, rtol, lanes, report_lanes)
        result = result.replace(
            lane_roll=lane_roll,
            lane_count=lanes,
            errors={**result.errors, **lane_roll.errors},
            warnings=(*result.warnings, *lane_roll.warnings),
        )
    if progress is not None:
        progress(1.0)
    return result.warned()


def check_options(
    *,
    rtol: object = RTOL,
    nodes: object = NODES,
    coupling_rtol: object = None,
    lanes: object = LANES,
    start: object = None,
    errors: object = True,
) -> None:
    """Check the options of :func:`solve_winding`.

    Raises
    ------
    InvalidProblem
        For an option out of range.
    """
    tolerance("rtol", rtol, LEAST_RTOL, 0.1)
    whole_number("nodes", nodes, LEAST_NODES, 1025)
    whole_number("lanes", lanes, FEWEST_LANES, MOST_LANES)
    check_type("errors", errors, bool)
    if coupling_rtol is not None:
        tolerance("coupling_rtol", coupling_rtol, SMALLEST_COUPLING_RTOL, LARGEST_COUPLING_RTOL)


@dataclass
class _Iteration:
    """One nip-roll iteration: the tension of the roll, and that of the nips on this roll.

    Attributes
    ----------
    shares, nip_shares : dict of float to float
        Friction shares y = (WOT - T_in)/(mu+ P) with which the roll is wound, and of the nips on
        this roll, by their places x = ln(r - r_c).
    r : (M,) array
        Radii of the tension of the roll [m].
    roll : WoundRoll
    has_own_stages : bool
        True if the stages of the roll were chosen for its own tension.
    film : float
        Air film between the layers of the roll [m].
    change : float
        Largest relative difference of the tension between nips and roll [1].
    """

    shares: dict[float, float]
    nip_shares: dict[float, float]
    r: Array
    roll: WoundRoll
    has_own_stages: bool
    film: float
    change: float


class _Winder:
    """Nip-roll iteration of one winding.

    The unknowns are the friction shares y = (WOT - T_in)/(mu+ P) at a few places, the interpolation
    points x = ln(r - r_c): they give the tension of the roll, and the nips on this roll give them.
    Parameters as of :func:`solve_winding`.
    """

    def __init__(
        self,
        problem: WindingProblem,
        rtol: float,
        nodes: int,
        coupling_rtol: float,
        start: WindingResult | None,
        errors: bool,
        progress: Progress | None,
    ) -> None:
        self.problem, self.rtol, self.nodes, self.errors = problem, rtol, nodes, errors
        self.coupling_rtol = coupling_rtol
        self.start, self.progress = start, progress
        self.curve = TensionCurve(problem, rtol, survey=not errors and rtol >= SURVEY)
        self.nips = Nips(
            problem,
            nodes,
            coupling_rtol,
            self._report_progress,
            () if start is None else start.nips,
            errors=errors,
        )
        # the progress before and after the present iteration, and the nips solved before it
        self.reached, self.expected, self.solved_before = 0.0, FIRST_GAIN, 0
        self.share_of_iterations, self.reported = OF_ITERATIONS, 0.0

    def solve(self) -> WindingResult:
        """Solve the winding."""
        return self._assemble(self._converge())

    def _converge(self) -> _Iteration:
        """Iterate between nips and roll until their tensions agree.

        On the way, the mesh of the nips and the tolerances are refined when the change falls below
        ROUGH_CHANGE, and radii are added when it falls below REFINEMENT_CHANGE.
        """
        shares, change = self._initial_shares()
        previous: _Iteration | None = None
        slopes: dict[float, float] = {}
        has_close_stages = False  # True once they were chosen for a tension close to the solution
        # warm starts from a neighbouring winding need no coarse mesh
        self.nips.coarse = change > ROUGH_CHANGE and not self.nips.neighbours
        for number in range(MAX_ITERATIONS):
            self.nips.rough = rough = change > ROUGH_CHANGE
            if self.nips.coarse and not rough:
                # tensions on another mesh do not continue the secant steps; where nips are
                # extrapolated, the previous iteration only gives the stages of the roll
                self.nips.coarse, slopes = False, {}
                previous = previous if self._extrapolates else None
            # other stages would change the tension, which the extrapolation has made agree
            stages = previous if self._extrapolates else None
            iteration = self._iterate(shares, self._nip_share, stages)
            is_close = (
                iteration.change <= max(REFINEMENT_CHANGE[self.problem.roll_body], self.rtol)
                or number >= MAX_UNREFINED_ITERATIONS
            )
            may_refine = is_close and not self.nips.coarse
            added = may_refine and self._refine(iteration)
            agrees = not added and iteration.change <= STOP_FRACTION * self.coupling_rtol
            if self._extrapolates and not agrees:
                iteration = self._extrapolate(iteration, may_refine and not has_close_stages)
                has_close_stages = has_close_stages or may_refine
                shares, added = iteration.nip_shares, False  # what was added is included
            else:
                shares = _secant_update(iteration, previous, slopes)
            previous, change = iteration, iteration.change
            self._note_progress(change)
            # with the last mesh, tolerances and radii
            is_final = may_refine and not (added or rough)
            if is_final and change <= STOP_FRACTION * self.coupling_rtol:
                return iteration if iteration.has_own_stages else self._recompute_roll(iteration)
        raise NotConverged(
            f"the nip-roll iteration does not converge: after {MAX_ITERATIONS} iterations the "
            f"relative change of the wound-on tension is still {change:.2g}",
            self._assemble(previous) if previous else None,
        )

    @property
    def _extrapolates(self) -> bool:
        """True if nips are extrapolated to other rolls between their solutions."""
        return self.problem.roll_body == "effective"

    def _extrapolate(self, iteration: _Iteration, chooses_stages: bool) -> _Iteration:
        """Iterate between the roll and nips that are extrapolated to it, until both agree.

        ``chooses_stages`` chooses the stages of the roll again, once: a change of the stages could
        exceed the tolerance.
        """
        goal = STOP_FRACTION * self.coupling_rtol
        if chooses_stages:  # the nips are solved again in any case
            goal *= BEFORE_NIPS
        elif self.nips.coarse:
            goal = SETTLED_ROUGHLY
        slopes: dict[float, float] = {}
        previous: _Iteration | None = None
        shares, stages = iteration.nip_shares, None if chooses_stages else iteration
        for _ in range(MAX_EXTRAPOLATIONS):
            iteration = self._iterate(shares, self._predicted_share, stages)
            if max(self._differences(iteration.shares, iteration.nip_shares)) <= goal:
                break
            shares = _secant_update(iteration, previous, slopes)
            previous = stages = iteration
        return iteration

    def _recompute_roll(self, iteration: _Iteration) -> _Iteration:
        """Recompute the roll from its tension alone, independent of earlier iterations."""
        tension = self.curve.tension(iteration.shares, iteration.r)
        roll = wind(self.problem, iteration.r, tension, self.rtol, iteration.film, changes=False)
        return replace(iteration, roll=roll, has_own_stages=True)

    def _differences(
        self, shares: dict[float, float], others: dict[float, float]
    ) -> Iterator[float]:
        """Yield the relative difference of the tensions of two shares at each place."""
        for place, share in shares.items():
            yield abs(self._tension(place, others[place]) / self._tension(place, share) - 1)

    def _initial_shares(self) -> tuple[dict[float, float], float]:
        """Return the initial shares by place, and the relative error of their tension.

        The error is 0 if the shares are those of solved nips, otherwise unknown and taken as 1.
        """
        shares = {place: self._initial_share(place) for place in self.curve.places}
        if self.problem.roll_body != "linear" or self.problem.air is not None:
            return shares, 1.0
        # the nips do not depend on the wound roll
        shares = {place: self._nip_share(place, None) for place in shares}
        while piece := self._worst_piece(shares):
            shares[piece.next_place] = self._nip_share(piece.next_place, None)
            piece.places.append(piece.next_place)
        self.curve.refine_radii(shares)
        return shares, 0.0

    def _iterate(
        self,
        shares: dict[float, float],
        share_of_nip: Callable[[float, RollResult], float],
        stages: _Iteration | None,
    ) -> _Iteration:
        """Compute the roll from the shares, and the shares of the nips on this roll.

        The roll contains the mean air film of the nips that were solved so far.  Those solved on it
        change this mean: like the tension, the film must agree between roll and nips.

        Parameters
        ----------
        shares : dict of float to float
            Of the roll, by place.
        share_of_nip : callable
            (place, roll) -> share of a nip, solved or extrapolated.
        stages : _Iteration, optional
            The roll is computed in the stages of this one, by default in its own.
        """
        film, r = self.nips.mean_film(), self.curve.knots()
        tension = self.curve.tension(shares, r)
        if stages is None:
            roll = wind(self.problem, r, tension, self.rtol, film, changes=False)
        else:
            roll = recomputed(self.problem, stages.roll, r, tension, film, changes=False)
        nip_shares = {place: share_of_nip(place, roll.result) for place in shares}
        change = max(self._mismatch(place, share) for place, share in shares.items())
        # the film of the nips solved above differs from that of the roll; relative to the web
        film_change = abs(self.nips.mean_film() - film) / self.problem.web.thickness
        change = max(change, film_change)
        return _Iteration(shares, nip_shares, r, roll, stages is None, film, change)

    def _predicted_share(self, place: float, roll: RollResult) -> float:
        """Return the friction share of the nip at a place, extrapolated to another roll [1]."""
        radius = self.curve.radius(place)
        return self.curve.share(self.nips.predict(radius, roll), radius)

    def _nip_share(self, place: float, roll: RollResult | None) -> float:
        """Solve the nip at a place on a roll; return its friction share [1]."""
        radius, pressure = self.curve.radius(place), self._interpolated_pressure(place)
        return self.curve.share(self.nips.tension(radius, roll, pressure), radius)

    def _interpolated_pressure(self, place: float) -> float | None:
        """Return the effective pressure P_e at a place from the nips of its piece, solved before.

        It is their interpolating polynomial in ln P_e; None below FEWEST_PRESSURES nips, and where
        the same nip of a neighbouring winding is the better guess.
        """
        if not self._extrapolates or self.curve.radius(place) in self.nips.neighbours:
            return None
        piece = next(piece for piece in self.curve.pieces if place <= piece.end)
        before = piece.places.index(place) if place in piece.places else len(piece.places)
        samples = [self.nips.samples.get(self.curve.radius(p)) for p in piece.places[:before]]
        known = [sample.implied_pressure for sample in samples if sample is not None]
        if before < FEWEST_PRESSURES or len(known) < before:
            return None
        logarithms = dict(zip(piece.places, np.log(known).tolist(), strict=False))
        return float(np.exp(piece.at(np.array(place), logarithms, first=before)))

    def _tension(self, place: float, share: float) -> float:
        """Return the wound-on tension of a friction share at a place [N/m]."""
        return float(self.curve.wound_on(np.array(share), np.array(self.curve.radius(place))))

    def _mismatch(self, place: float, share: float) -> float:
        """Return the relative difference between the tension of the roll and that of a nip.

        A nip is solved with a guess of the effective pressure of the roll, and its tension is then
        extrapolated to the pressure that follows from it (:class:`.NipSample`).  The larger of the
        differences to both tensions is returned, so that a small one shows a good guess too.
        """
        sample, tension = self.nips.samples[self.curve.radius(place)], self._tension(place, share)
        return max(
            abs(tension / other - 1) for other in (tension_on_roll(sample.result), sample.tension)
        )

    def _initial_share(self, place: float) -> float:
        """Return the friction share at a place from the neighbouring winding, or a nominal one."""
        if self.start is None:
            return NOMINAL
        r = self.curve.radius(place)
        # the nip-induced tension varies as a power of the nip load, between 1/2 and 1
        ratio = self.start.nip_induced_tension / self.start.nip_load**POWER
        friction = self.problem.roll_friction * self.problem.at("nip_load", r) ** (1 - POWER)
        return float(np.interp(r, self.start.radius, ratio) / friction)

    def _refine(self, iteration: _Iteration) -> bool:
        """Add radii until the interpolation error is accepted; return True if any were added."""
        added, nip_shares = False, iteration.nip_shares
        while piece := self._worst_piece(nip_shares):
            place = piece.next_place
            iteration.shares[place] = float(piece.at(np.array(place), iteration.shares))
            nip_shares[place] = self._nip_share(place, iteration.roll.result)
            iteration.change = max(iteration.change, self._mismatch(place, iteration.shares[place]))
            piece.places.append(place)
            added = True
        return self.curve.refine_radii(nip_shares) or added

    def _worst_piece(self, nip_shares: dict[float, float]) -> Piece | None:
        """Return the piece with the largest error, or None if all errors are accepted.

        ``nip_shares`` are the friction shares of the nips by place.
        """
        curve = self.curve
        errors = np.divide(curve.errors(nip_shares), curve.accepted_errors)
        worst = int(np.argmax(errors))
        piece = curve.pieces[worst]
        if errors[worst] <= 1:
            return None
        if len(nip_shares) >= MAX_NIPS:
            last_place, _ = piece.error_estimates(nip_shares)[-1]
            r = curve.radius(last_place)
            raise NotConverged(
                f"rtol={self.rtol:g} is not reached with {MAX_NIPS} nips: at the radius "
                f"{r:.4g} m the relative interpolation error of the wound-on tension is "
                f"{curve.errors(nip_shares)[worst]:.2g}; use smoother schedules or a larger rtol"
            )
        return piece

    def _note_progress(self, change: float) -> None:
        """Update the progress after an iteration from the relative change of the tension."""
        tolerance = STOP_FRACTION * self.coupling_rtol
        # 0 for a change of 1, 1 at the tolerance
        reached = np.log(max(change, tolerance)) / np.log(tolerance)
        gain = max(reached - self.reached, LEAST_GAIN)
        self.reached = max(self.reached, reached)
        self.expected = min(self.reached + gain, 1.0)
        self.solved_before = self.nips.solved

    def _report_progress(self, solved: int) -> None:
        """Report the estimated fraction of the work after a nip, which never decreases."""
        if self.progress is None:
            return
        if self.nips.is_roll_independent:
            fraction = solved / (EXPECTED_NIPS + max(0, solved - EXPECTED_NIPS))
        else:
            done = (solved - self.solved_before) / len(self.curve.places)
            fraction = self.reached + min(done, 1.0) * (self.expected - self.reached)
        self.reported = max(self.reported, self.share_of_iterations * fraction)
        self.progress(self.reported)

    def _report_check(self, solved: int) -> None:
        """Report the progress after a nip that checks the measured schedules."""
        if self.progress is not None:
            done = min((solved - self.nips.solved) / CHECKS, 1.0)
            self.progress(OF_MEASURED + done * (OF_ITERATIONS - OF_MEASURED))

    def _assemble(self, iteration: _Iteration) -> WindingResult:
        """Assemble the result of an iteration."""
        curve, r = self.curve, iteration.r
        tension = curve.tension(iteration.shares, r)
        self.nips.estimate_errors()
        return assemble_result(
            self.problem,
            r,
            tension,
            iteration.roll,
            self.nips,
            interpolation=(
                curve.interpolation_error(iteration.nip_shares, r, tension),
                curve.core_interpolation_error(iteration.nip_shares, r, tension),
            ),
            rtol=self.rtol,
            coupling_rtol=self.coupling_rtol,
            film=iteration.film,
            curved=curve.tension(iteration.shares, r, curved=True) if self.errors else None,
        )

    def solve_measured(self, problem: WindingProblem) -> WindingResult:
        """Solve a problem whose schedules fluctuate around the smooth ones of this winding.

        The tension is that of the smooth winding plus the departure, its linear change by the
        differences between the schedules.  The roll is computed from this tension, and a few nips
        under the measured schedules on this roll give the error of the linearisation.
        """
        self.share_of_iterations = OF_MEASURED
        iteration, curve = self._converge(), self.curve
        self.nips.estimate_errors()
        departure = Departure(problem, self.problem, curve, self.nips)

        def tension(r: Array, *, curved: bool = False) -> Array:
            """Return the tension under the measured schedules [N/m]."""
            return curve.tension(iteration.shares, r, curved=curved) + departure(r)

        fine = sampling_radii(problem)
        nip_radii = sorted(curve.radius(place) for place in curve.places)
        r = polyline_radii(problem, fine, tension(fine), self.rtol, nip_radii)
        roll = wind(problem, r, tension(r), self.rtol, iteration.film, changes=False)
        # nips under the measured schedules, with warm starts from those of the smooth winding; they
        # continue its count of solved nips
        nips = self.nips
        checks = Nips(
            problem,
            self.nodes,
            self.coupling_rtol,
            self._report_check,
            nips.from_core_to_surface(),
            nips.solved,
        )
        mismatch = largest_mismatch(departure, checks, roll.result, tension)
        nips.solved = checks.solved
        # the interpolation error is that of the smooth part of the reported tension
        smooth_tension = np.interp(iteration.r, r, tension(r) - departure(r))
        known = iteration.nip_shares, iteration.r, smooth_tension
        return assemble_result(
            problem,
            r,
            tension(r),
            roll,
            nips,
            interpolation=(
                curve.interpolation_error(*known) + mismatch,
                curve.core_interpolation_error(*known),
            ),
            rtol=self.rtol,
            coupling_rtol=self.coupling_rtol,
            film=iteration.film,
            curved=tension(r, curved=True) if self.errors else None,
            departure=departure(np.array(nip_radii)),  # the nips are those of the smooth winding
        )


def _secant_update(
    iteration: _Iteration, previous: _Iteration | None, slopes: dict[float, float]
) -> dict[float, float]:
    """Return the next friction shares by a secant step at each place, neglecting their coupling.

    The share y of the roll at a place shall equal the share f(y) of the nip on this roll.

    Parameters
    ----------
    iteration, previous : _Iteration
        The last two; None for ``previous`` in the first step.
    slopes : dict of float to float
        Secant slopes df/dy by place, which are updated; that of a new place is their median.

    Returns
    -------
    dict of float to float
        The next y by place.
    """
    last = previous or iteration
    for place, share in iteration.shares.items():
        step = share - last.shares.get(place, share)
        if abs(step) > MIN_SECANT_STEP:
            slope = (iteration.nip_shares[place] - last.nip_shares[place]) / step
            slopes[place] = float(np.clip(slope, -0.5, 0.3))  # limits the effect of noise
    median = float(np.median([*slopes.values()])) if slopes else 0.0
    shares = {}
    for place, share in iteration.shares.items():
        slope = slopes.setdefault(place, median)
        shares[place] = share + (iteration.nip_shares[place] - share) / (1 - slope)
    return shares


def _solve_prescribed(
    problem: WindingProblem, rtol: float, nodes: int, coupling_rtol: float
) -> WindingResult:
    """Solve a winding whose wound-on tension needs no nips.

    Parameters as of :func:`solve_winding`.
    """
    law, schedule, r = problem.tension_law, problem.at, sampling_radii(problem)
    film = 0.0 if problem.has_nip else mean_foil_film(problem)
    if isinstance(law, Profile):
        tension = problem.curve("tension_law").at(r)
    elif law == "fixed":
        tension = schedule("web_tension", r) + schedule("nip_induced_tension", r)
    else:
        tension = _full_slip_tension(problem, r)  # without a nip T_in
    radii = polyline_radii(problem, r, tension, rtol)
    reported = np.interp(radii, r, tension)
    difference = np.abs(np.interp(r, radii, reported) - tension)
    error = float(np.max(difference) / np.max(np.abs(tension)))
    return assemble_result(
        problem,
        radii,
        reported,
        wind(problem, radii, reported, rtol, film, changes=False),
        Nips(problem, nodes, coupling_rtol, report=lambda _: None),
        interpolation=(error if error > ROUNDING else 0.0, 0.0),
        rtol=rtol,
        coupling_rtol=coupling_rtol,
        film=film,
    )


def _full_slip_tension(problem: WindingProblem, r: Array) -> Array:
    """Return the wound-on tension at radii, (k,) [N/m], of a web that slips in the whole nip.

    T_1 = T_in + F + mu+ P.  Of a two-drum winder the web slips in each nip.  The arc upstream of a
    nip holds T_1 exp(-mu_w theta) by its friction (Euler-Eytelwein, T without the centrifugal force
    m V^2); what a nip adds beyond that pulls web through the nip before:
    T_k = max{T_k-1, T_k-1 exp(-mu_w theta_k) + F_k + mu+ P_k}.
    """
    mu = problem.roll_friction
    on_wrap = mu if problem.wrap_friction is None else problem.wrap_friction
    tension = problem.at("web_tension", r) + problem.at("winding_force", r)
    tension = tension + mu * problem.at("nip_load", r)
    if problem.winder is None:
        return tension
    loads, force = problem.drum_loads(r), problem.centrifugal_tension
    further = [(loads.front_arc, loads.front_force + mu * loads.front_load)]
    if problem.winder.rider is not None:
        further.append((loads.rider_arc, mu * loads.rider_load))
    for arc, added in further:
        held = force + (tension - force) * np.exp(-on_wrap * arc)
        tension = np.maximum(tension, held + added)
    return tension
