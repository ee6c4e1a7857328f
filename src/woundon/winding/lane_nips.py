r"""The lanes of a winding: the nip loads shared between them, and the tension that the nips add.

A ridge is pressed harder by a straight drum.  At a few radii the nip is solved under further loads,
which gives the load-approach curve P(delta) and the added tension A(P) at that radius.  Relative to
the load N of the winding, with f = P/N,

    ln(delta/delta_N) and (A - A_N)/(mu+ N)    are functions of ln f and f

that vary little over the radius and are interpolated in ln(r - r_c).  Monotone cubics pass through
the samples; below them P is a power of delta.  Without load A = 0.  The winding force is shared
like the load.  Where lanes carry more than twice the mean load, further loads are solved, up to
MOST_LOAD times the mean; beyond those that have a steady state P is a power of delta and A is
linear, and a warning says so.

The nips of a two-drum winder add the tension A together.  The load of each nip is changed alone,
and the changes of A are added,

    A = A_N + sum_k [A(N_1, ..., P_k, ...) - A_N],

A is also solved under LIGHT of the load of a nip, and is constant below: other nips add more where
one has no load.  delta_k is the approach of drum and roll by the loads of nip k.

Drums with a crown and beams (:mod:`~woundon.problems.bending`) share their loads less evenly or
more evenly than straight ones; the load of a core is that of the one nip.

A tension law without solved nips has no load-approach curve: the nips then add the same tension to
all lanes, and their load is not shared.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import NamedTuple

import numpy as np

from ..elasticity.beam import Beam, BeamsAcross
from ..errors import InvalidProblem, NotConverged, unwarned
from ..nip.outputs import approach
from ..nip.result import NipResult
from ..nip.solve import solve_nip
from ..problems.bending import Bending, DrumBending
from ..problems.bodies import Body
from ..problems.paths import field_or_none
from ..problems.thickness_profile import Lanes
from ..roll.finite_layers import finite_layer_errors
from ..roll.lane_roll import NIP_LOADS, POSITION, LaneRoll
from ..roll.lane_tension import DrumsAcross, TensionOfLanes, tension_in_nips, tension_of_web
from ..roll.lanes import TensionAt
from ..roll.result import RollResult
from ..roll.solve import Report, lanes_of
from ..roll.stages import stages_at
from .bodies import NipSample, solved_nip, tension_on_roll
from .nips import PRESSURE_TOLERANCE
from .roll import wind
from .winding_fields import WindingFields

__all__ = ["NipAtRadius", "NipsOfWinding", "lanes_of_winding", "largest_load"]

Array = np.ndarray

RADII = 5  # at which the nip is solved under other loads, of those of the winding
# Loads relative to that of the winding.  Half and double enclose the loads of usual ridges; steeper
# ones and crowns need further doublings.
LOADS = (0.5, 1.0, 2.0)
MOST_LOAD, LOAD_RESERVE = 16.0, 1.25  # LOAD_RESERVE: the loads change a little with the samples
LIGHT = 0.1  # smallest load of one of several nips
# Beams: field of the winding, nip that loads it, name of its deflection.
BEAMS = (
    ("drum_bending", 0, "drum_deflection"),
    ("core_bending", 0, "core_deflection"),
    ("winder.front_bending", 1, "front_deflection"),
    ("winder.rider_bending", 2, "rider_deflection"),
)


class _Curve:
    """A monotone cubic through samples, continued by straight lines.

    Parameters
    ----------
    x, y : (k,) arrays
        The samples, x rising.
    """

    def __init__(self, x: Array, y: Array) -> None:
        # the import takes a quarter of a second, which a nip on the command line does not need
        from scipy.interpolate import PchipInterpolator

        self.first, self.last = float(x[0]), float(x[-1])
        self.value = PchipInterpolator(x, y)
        self.slope = self.value.derivative()

    def at(self, x: Array) -> tuple[Array, Array]:
        """Return the values and the slopes at any x, arrays of its shape."""
        inside = np.clip(x, self.first, self.last)
        slope = self.slope(inside)
        return self.value(inside) + slope * (x - inside), slope


@dataclass(frozen=True)
class NipAtRadius:
    """A nip at one radius as a function of its load; see :class:`.lane_tension.NipAcross`.

    Parameters
    ----------
    load : float
        N of the winding [N/m].
    approach : float
        delta under this load [m].
    log_approach : (n,) array
        ln(delta/delta_N) at the n sampled loads.
    added_at_load : float
        A under this load [N/m]; of several nips the whole A in the first one, 0 in the others.
    added_change : (n + 1,) array
        (A - A_N)/(mu+ N) without load, and at the sampled loads.
    friction_force : float
        mu+ N [N/m].
    sampled : sequence of n floats
        Loads relative to N.
    """

    load: float
    approach: float
    log_approach: Array
    added_at_load: float
    added_change: Array
    friction_force: float
    sampled: Sequence[float] = LOADS

    @cached_property
    def _log_load(self) -> _Curve:
        """ln(P/N) over ln(delta/delta_N); a straight line is a power of delta."""
        return _Curve(self.log_approach, np.log(self.sampled))

    @cached_property
    def _added_change(self) -> _Curve:
        """(A - A_N)/(mu+ N) over P/N."""
        return _Curve(np.array([0.0, *self.sampled]), self.added_change)

    def load_at(self, approach: Array) -> tuple[Array, Array]:
        """Return P [N/m] and dP/d delta [N/m^2] at approaches [m], (L,); zero at negative ones."""
        touches = approach > 0
        delta = np.where(touches, approach, self.approach)  # any positive one without contact
        log_load, exponent = self._log_load.at(np.log(delta / self.approach))
        load = self.load * np.exp(log_load)
        # d ln P/d ln delta is the exponent
        return np.where(touches, load, 0.0), np.where(touches, load * exponent / delta, 0.0)

    def added(self, load: Array) -> tuple[Array, Array]:
        """Return A(P) [N/m] and dA/dP [1] at loads (L,) [N/m]."""
        change, slope = self._added_change.at(load / self.load)
        ratio = self.friction_force / self.load
        return self.added_at_load + self.friction_force * change, ratio * slope


class _Samples(NamedTuple):
    """The K nips of a winding, solved under n loads each at m radii.

    Attributes
    ----------
    radius : (m,) array
        [m].
    friction : (m,) array
        mu+ with the entrained air.
    log_compliance : (m, K) array
        ln(delta/N) under the loads of the winding.
    log_approach : (m, K, n) array
        ln(delta/delta_N).
    change : (m, K, n) array
        (A - A_N)/(mu+ N).
    largest_load : (m, K) array
        Largest load of the samples that has a steady state, relative to N.
    """

    radius: Array
    friction: Array
    log_compliance: Array
    log_approach: Array
    change: Array
    largest_load: Array


class NipsOfWinding:
    """The nips of a winding across the width; see :class:`.solve_lanes.NipsAcross`.

    Parameters
    ----------
    result : WindingResult
    roll : RollResult
        Its roll.
    largest : float
        Largest load of a lane relative to the mean, up to which nips are solved.

    Attributes
    ----------
    sampled : tuple of float
        Loads of the samples, relative to N.
    samples : _Samples, optional
        None without solved nips.
    """

    def __init__(self, result: WindingFields, roll: RollResult, largest: float = LOADS[-1]) -> None:
        self.result, self.problem, self.roll = result, result.problem, roll
        self.core = float(self.problem.core.radius)
        loads = LOADS if self.problem.winder is None else (LIGHT, *LOADS)
        while loads[-1] < min(largest, MOST_LOAD):
            loads = (*loads, 2 * loads[-1])
        self.sampled = loads
        self.samples = self._samples() if self.problem.solves_nips else None

    @property
    def solved_up_to(self) -> float:
        """Largest load of all samples that has a steady state at all radii, relative to N."""
        return np.inf if self.samples is None else float(self.samples.largest_load.min())

    def web_tension(self, r: Array) -> Array:
        """Return T_in at radii [N/m]."""
        return np.interp(r, self.result.radius, self.result.web_tension)

    def nip_loads(self, r: Array) -> Array:
        """Return N_k of all nips at radii (M,), (K, M) [N/m]; a row of nan without solved nips."""
        return np.full((1, r.size), np.nan) if self.samples is None else self._loads(r)

    def _loads(self, r: Array) -> Array:
        """Return the loads of all nips at radii (M,), (K, M) [N/m]."""
        loads = [np.interp(r, self.result.radius, self.result.nip_load)]
        if (winder := self.problem.winder) is not None:
            of_drums = self.problem.drum_loads(r)
            loads += [of_drums.front_load, *([] if winder.rider is None else [of_drums.rider_load])]
        return np.array(loads)

    def tension_at(self, lanes: Lanes) -> TensionAt:
        """Return the function that gives the tension of lanes, in nips if these are solved."""
        E_t = float(self.roll.problem.stack.tangential)
        h = float(self.roll.problem.web_thickness)
        drums = self.drums(lanes)

        def tension(x: float, c: Array, mu: Array, guess: Array) -> TensionOfLanes | None:
            """Return the tension of lanes at ln s = x; see :data:`.lanes.TensionAt`."""
            r = np.array([np.exp(x)])
            wound_on = h * float(self.roll.problem.tension_curve.at(r)[0])
            web, strain = float(self.web_tension(r)[0]), wound_on / (h * E_t)
            if self.samples is None:
                return tension_of_web(lanes, c, mu, strain, 1 - web / wound_on)
            nips = self.nips(float(r[0]), wound_on - web)
            return tension_in_nips(
                lanes, c, mu, strain, nips, float(r[0]), wound_on, web, guess, drums
            )

        return tension

    @property
    def _beams(self) -> list[tuple[Bending, int, str]]:
        """Those of BEAMS in the problem: (beam, nip that loads it, name of its deflection)."""
        beams = [(field_or_none(self.problem, name), nip, of) for name, nip, of in BEAMS]
        return [(beam, nip, name) for beam, nip, name in beams if beam is not None]

    def drums(self, lanes: Lanes) -> DrumsAcross | None:
        """Return the drums across the lanes; None of straight drums.

        Lanes with a share of the width lie next to each other between the edges of the profile; the
        others are places between the edges, without a width.
        """
        if not self._beams:
            return None
        assert self.problem.thickness_profile is not None  # of a problem with lanes
        edges = np.array(self.problem.thickness_profile.position)[[0, -1]]
        with_share = lanes.share > 0
        # edges of the lanes next to each other, from one edge of the web to the other
        ends = edges[0] + np.ptp(edges) * np.append(0.0, np.cumsum(lanes.share[with_share]))
        places = lanes.position[~with_share]
        nip_count = len(self.nip_loads(np.array([self.problem.radius])))
        crown = np.zeros((nip_count, lanes.share.size))
        loaded_by = np.zeros((nip_count, len(self._beams)))
        beams = []
        for b, (bending, nip, _) in enumerate(self._beams):
            loaded_by[nip, b] = 1.0
            shear = bending.shear_rigidity
            beams.append(
                Beam(
                    bending.flexural_rigidity,
                    bending.bearing_distance,
                    np.inf if shear is None else shear,
                )
            )
            if isinstance(bending, DrumBending):  # a core has no crown
                # relative to the mean height over the width
                heights = bending.mean_heights(ends), bending.heights(places, tuple(edges))
                crown[nip] = np.concatenate(heights) - lanes.share[with_share] @ heights[0]
        return DrumsAcross(crown, BeamsAcross(beams, np.diff(ends), places - edges[0]), loaded_by)

    def deflections(self, lanes: Lanes, loads: Array) -> dict[str, Array]:
        """Return the deflections of drums and core (L, M) [m] under loads (K, L, M), by name."""
        drums = self.drums(lanes)
        if drums is None:
            return {}
        names = [name for _, _, name in self._beams]
        return dict(zip(names, drums.deflection(loads), strict=True))

    def nips(self, radius: float, added: float) -> list[NipAtRadius]:
        """Return the nips at a radius [m], which together add the tension ``added`` [N/m]."""
        samples = self.samples
        assert samples is not None
        places = np.log(samples.radius - self.core)
        x = np.clip(np.log(max(radius - self.core, 1e-12)), places[0], places[-1])

        def at_radius(values: Array) -> Array:
            """Interpolate values of the samples, (m,) or (m, n), at this radius."""
            columns = values.reshape(len(values), -1).T
            return np.array([np.interp(x, places, column) for column in columns])

        friction = float(at_radius(samples.friction)[0])
        fade = self._fade(radius, added)
        loads = self.nip_loads(np.array([radius]))[:, 0].tolist()
        nips = []
        for k, load in enumerate(loads):
            compliance = float(np.exp(at_radius(samples.log_compliance[:, k])[0]))
            change = fade * at_radius(samples.change[:, k])
            force = friction * load
            # one nip adds nothing without load; the others of several add more without this one
            unloaded = -added / force if len(loads) == 1 else change[0]
            nips.append(
                NipAtRadius(
                    load=load,
                    approach=compliance * load,
                    log_approach=at_radius(samples.log_approach[:, k]),
                    added_at_load=added if k == 0 else 0.0,
                    added_change=np.array([unloaded, *change]),
                    friction_force=force,
                    sampled=self.sampled,
                )
            )
        return nips

    def _fade(self, radius: float, added: float) -> float:
        """Return the factor of the changes of A between the core and the first solved nip [1].

        On the first layers the nips add less, and nothing on the core of a roll without layers.
        The changes by another load decrease like A_N itself, so that A is 0 without load and does
        not overshoot between.

        Parameters
        ----------
        radius : float
            [m].
        added : float
            A_N at this radius [N/m].
        """
        first = float(self.result.nip_radius[0])
        if radius >= first:
            return 1.0
        loads = [
            np.interp(first, self.result.radius, each)
            for each in (self.result.wound_on_tension, self.result.web_tension)
        ]
        at_first = float(loads[0] - loads[1])
        return float(np.clip(added / at_first, 0.0, 1.0)) if at_first else 1.0

    def _samples(self) -> _Samples:
        """Return the nips solved under further loads at a few radii."""
        radii = self.result.nip_radius
        chosen = np.unique(np.round(np.linspace(0, radii.size - 1, RADII)).astype(int))
        friction = self.result.nip_friction[chosen]
        at_radii = [
            self._sampled_at(float(r), float(mu))
            for r, mu in zip(radii[chosen], friction, strict=True)
        ]
        values = (np.array(each) for each in zip(*at_radii, strict=True))
        return _Samples(radii[chosen], friction, *values)

    def _sampled_at(self, radius: float, friction: float) -> tuple[Array, Array, Array, Array]:
        """Return the last four attributes of :class:`_Samples` at one radius, without their axis m.

        The nips are solved under all loads of one of them at a time; a load without a steady state
        is left out.  ``friction`` is mu+ with the entrained air.
        """
        loads = self._loads(np.array([radius]))[:, 0].tolist()
        solved: dict[tuple[float, ...], NipSample | None] = {}
        last: NipSample | None = None  # a warm start
        rows = []
        for k, load in enumerate(loads):
            values = []  # approach of nip k, and tension added by all nips, at each of its loads
            for fraction in self.sampled:
                fractions = tuple(fraction if j == k else 1.0 for j in range(len(loads)))
                if fractions not in solved:
                    solved[fractions] = self._sample(radius, friction, fractions, last)
                    last = solved[fractions] or last
                values.append(_approach_and_added(solved[fractions], k))
            delta, added = np.array(values).T
            middle = self.sampled.index(1.0)
            log_approach = np.log(delta / delta[middle])
            change = (added - added[middle]) / (friction * load)
            rows.append(
                (
                    np.log(delta[middle] / load),
                    _completed(np.log(self.sampled), log_approach),
                    _completed(np.array(self.sampled), change),
                    np.array(self.sampled)[~np.isnan(delta)].max(),
                )
            )
        compliance, approaches, changes, largest = (np.array(c) for c in zip(*rows, strict=True))
        return compliance, approaches, changes, largest

    def _sample(
        self, radius: float, friction: float, fractions: Sequence[float], last: NipSample | None
    ) -> NipSample | None:
        """Return the nips under fractions of their loads.

        None if they have no steady state then, as a strongly driven drum under twice its load and
        force may have none; that under the loads of the winding exists.

        Parameters
        ----------
        radius : float
            [m].
        friction : float
            mu+ with the entrained air.
        fractions : sequence of K floats
        last : NipSample, optional
            A solution for a warm start.
        """
        problem, solve = self.problem, partial(self._solve, radius, friction, fractions)
        stage = None
        if problem.roll_body != "linear":
            stage = stages_at(self.roll, [radius], as_wound=True)[0]
        with_air = problem.replace(stack=self.roll.problem.stack)
        try:
            return solved_nip(with_air, radius, stage, None, last, solve, PRESSURE_TOLERANCE)
        except (InvalidProblem, NotConverged):
            if set(fractions) == {1.0}:
                raise
            return None

    def _solve(
        self,
        radius: float,
        friction: float,
        fractions: Sequence[float],
        body: Body,
        start: NipResult | None,
    ) -> NipResult:
        """Solve the nips under fractions of their loads, with the friction that the air leaves."""
        nip = self.problem.nip(radius, body)
        if nip.air is not None:
            ratio = friction / nip.roll_friction
            wrap = nip.wrap_friction
            nip = nip.without_air(friction, None if wrap is None else wrap * ratio)
        first, *others = fractions
        next_nips = [
            further.replace(
                nip_load=fraction * further.nip_load, winding_force=fraction * further.winding_force
            )
            for fraction, further in zip(others, nip.next_nips, strict=True)
        ]
        nip = nip.replace(
            nip_load=first * nip.nip_load,
            winding_force=first * nip.winding_force,
            next_nips=next_nips,
        )
        with unwarned():
            return solve_nip(nip, nodes=self.result.nodes, start=start, errors=start is None)


def _approach_and_added(sample: NipSample | None, k: int) -> tuple[float, float]:
    """Return the approach of nip k [m], and the tension that all nips add [N/m]; nan without."""
    if sample is None:
        return np.nan, np.nan
    nip = sample.result
    assert nip.refinement is not None  # only of a loaded result
    mesh = nip.refinement.last
    delta = approach(mesh.system.nips[k], mesh.state.nips[k])
    return delta, tension_on_roll(nip) - nip.problem.web_tension


def _completed(x: Array, values: Array) -> Array:
    """Return values over x (n,), where they are nan on the line through the two nearest others.

    The value at the load of the winding and another one must be known.

    Raises
    ------
    NotConverged
        If only one is.
    """
    known = np.flatnonzero(~np.isnan(values))
    if known.size < 2:
        text = "the nips have no steady state under other loads, as lanes of a web have"
        raise NotConverged(text)
    values = values.copy()
    for k in np.flatnonzero(np.isnan(values)):
        first, second = known[np.argsort(np.abs(known - k), kind="stable")[:2]]
        slope = (values[second] - values[first]) / (x[second] - x[first])
        values[k] = values[first] + slope * (x[k] - x[first])
    return values


def lanes_of_winding(
    result: WindingFields, rtol: float, count: int, report: Report | None = None
) -> LaneRoll:
    """Solve for the lanes of a winding.

    They are those of a roll at rest, as lanes neglect the centrifugal force, and of thin layers:
    the effect of the thickness of the layers is part of the error estimates.

    Parameters
    ----------
    result : WindingResult
        The winding of the mean web, whose problem has a thickness profile.
    rtol : float
        Accepted error of the pressure, relative to the largest.
    count : int
        Number of lanes.
    report : callable, optional
        Is called with each stage's radius [m], in several passes.
    """
    arrays = result.radius, result.wound_on_tension
    roll = wind(result.problem, *arrays, rtol, result.air_film, rotates=False)

    def lanes_with(nips: NipsOfWinding) -> LaneRoll:
        """Return the lanes with the nips solved under some loads."""
        return lanes_of(roll, result.problem, rtol, count, nips, report)

    nips = NipsOfWinding(result, roll.result)
    lanes = lanes_with(nips)
    largest, _ = largest_load(lanes)
    if nips.samples is not None and largest > nips.sampled[-1]:
        nips = NipsOfWinding(result, roll.result, largest=LOAD_RESERVE * largest)
        lanes = lanes_with(nips)
    lanes = replace(lanes, warnings=tuple(_load_warnings(lanes, nips)))
    of_layers = finite_layer_errors(result.roll)["peak_pressure"]
    return lanes.with_layer_error(of_layers / result.roll.peak_pressure)


def largest_load(lanes: LaneRoll) -> tuple[float, float]:
    """Return the largest load of a lane relative to the mean of its nip, and its position [m].

    nan if no nip load is shared.
    """
    loads = [lanes.arrays[name] for name in NIP_LOADS if name in lanes.arrays]
    ratios = np.max([load / (lanes.lanes.share @ load) for load in loads], axis=(0, 2))
    lane = int(np.argmax(ratios))
    return float(ratios[lane]), float(lanes.lanes.position[lane])


def _load_warnings(lanes: LaneRoll, nips: NipsOfWinding) -> Iterator[str]:
    """Yield a warning about lanes that carry more than the largest load that was solved."""
    largest, position = largest_load(lanes)
    if largest > nips.solved_up_to:
        yield (
            f"the lane at {POSITION.stored_text(position)} across the web carries up to "
            f"{largest:.3g} times the mean nip load: nips are solved up to "
            f"{nips.solved_up_to:.3g} times the mean, and extrapolated beyond"
        )
