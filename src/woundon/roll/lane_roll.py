"""The lanes of a finished roll: solution with error estimates, arrays, and the worst lane."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Protocol

import numpy as np

from ..errors import InvalidProblem, NotConverged
from ..problems.bending import bends
from ..problems.thickness_profile import Lanes
from ..quantities import Quantity, length, line_load, on_request, share, strain, stress
from .build_up import BuildUp, NotWoundError
from .equations import CellSource, StageData, StageSolution, interpolate_pressure, stretched
from .finished import ROUNDING, FinalChanges, equations_of, surface_layer_depth, with_nodes
from .lane_tension import tension_of_web
from .lanes import LOAD, RHO, THETA, WEB, LaneBuildUp, TensionAt, stage_data, wind_lanes
from .separation import solve_on_core
from .stage_nodes import cell_source, kinks_of, nodes_between

if TYPE_CHECKING:
    import xarray

__all__ = [
    "FEWEST_LANES",
    "LANES",
    "LANE_QUANTITIES",
    "MOST_LANES",
    "NIP_LOADS",
    "POSITION",
    "LaneRoll",
    "NipsAcross",
    "WithLanes",
    "WorstLane",
    "build_up_of",
    "slack_lanes",
    "solve_lanes",
]

Array = np.ndarray

FEWEST_LANES, MOST_LANES = 4, 1000
LANES = 50  # by default: they resolve smooth profiles to 0.1 % of the tension
TOLERANCE = 2e-3  # of the stages by default, that of a roll with the default rtol
SLACK = 1e-9  # of the mean tension: a lane with less is slack

PRESSURES = ("pressure", "core_pressure", "compression")  # among the worst values
POSITION = length("y", "position across the web")
# Loads of the nips in the direction of travel.
NIP_LOADS = ("nip_load", "front_load", "rider_load")
# Variables of the lanes over radius and position; those of the front drum and the rider only on a
# two-drum winder whose nips are solved, deflections only of beams that the problem has.
LANE_QUANTITIES: Mapping[str, Quantity] = {
    "pressure": stress("P_j", "pressure between the layers of a lane"),
    "hoop_stress": stress("sigma_t,j", "hoop (MD) stress of a lane, > 0: tension"),
    "wound_on_tension": line_load("WOT_j", "wound-on tension of a lane"),
    "web_tension": line_load("T_in,j", "web tension of a lane, upstream of the nip"),
    "nip_load": line_load("P_N,j", "nip load on a lane"),
    "front_load": line_load("P_2", "load of the front drum on a lane"),
    "rider_load": line_load("P_3", "load of the rider roll on a lane"),
    "drum_deflection": length("w_d", "deflection of the drum away from the roll", "um"),
    "core_deflection": length("w_c", "deflection of the core away from the drum", "um"),
    "front_deflection": length("w_2", "deflection of the front drum away from the roll", "um"),
    "rider_deflection": length("w_3", "deflection of the rider away from the roll", "um"),
    "ridge_height": length("dR_j", "height of the surface of a lane over the mean one", "um"),
    "band_strain": strain("eps_j", "strain along the web of a lane as wound"),
}


class NipsAcross(Protocol):
    """The nips of a winding across the width."""

    def tension_at(self, lanes: Lanes) -> TensionAt:
        """Return the function that gives the tension of lanes."""
        ...

    def web_tension(self, r: Array) -> Array:
        """Return T_in at radii [N/m]."""
        ...

    def nip_loads(self, r: Array) -> Array:
        """Return N_k of all nips at radii (M,), (K, M) [N/m]; one row of nan if none is shared."""
        ...

    def deflections(self, lanes: Lanes, loads: Array) -> Mapping[str, Array]:
        """Return the deflections of drums and core (L, M) [m] under loads (K, L, M), by name."""
        ...


@dataclass(frozen=True)
class WorstLane:
    """The worst values of all lanes of the finished roll, each of another lane perhaps.

    Examples
    --------
    >>> import woundon as wo
    >>> profile = wo.ThicknessProfile(position=[0, 1, 2], thickness=[0.995, 1.005, 0.995])
    >>> result = wo.solve(wo.RollProblem.example().replace(thickness_profile=profile), lanes=20)
    >>> result.worst_lane.pressure > result.peak_pressure
    True
    """

    part_of_result: ClassVar[bool] = True

    pressure: Annotated[float, stress("P_w", "largest pressure in a lane")]
    core_pressure: Annotated[float, stress("P_c,w", "largest pressure of a lane on the core")]
    compression: Annotated[float, stress("S_w", "largest hoop (MD) compression of a lane")]
    tension: Annotated[float, line_load("WOT_w", "largest wound-on tension of a lane")]
    least_tension: Annotated[float, line_load("WOT_l", "smallest wound-on tension of a lane")]
    strain: Annotated[float, strain("eps_w", "largest strain along the web of a lane as wound")]
    ridge_height: Annotated[
        float, length("dR_w", "height of the highest lane over the mean surface", "um")
    ]
    slack_share: Annotated[float, share("s_w", "part of the width that is slack at some radius")]


@dataclass(frozen=True, eq=False)
class LaneRoll:
    """The lanes of a finished roll.

    Attributes
    ----------
    lanes : Lanes
    radius : (M,) array
        Of the layers in the mean roll [m].
    pressure, hoop_stress, wound_on_tension, web_tension, nip_load, ridge_height, band_strain
        (L, M) arrays, see :data:`LANE_QUANTITIES` [SI].
    further : mapping of str to (L, M) array
        Loads of further nips and deflections, by the names of :data:`LANE_QUANTITIES`.
    stages : int
        Number of stages of the build-up.
    stage_error : float
        Largest error estimate of a stage, relative to kappa + 2 and to the mean tension.
    errors : mapping of str to float
        Estimated errors of the worst values, by the name of the output [SI].
    warnings : tuple of str
        Warnings about the lanes.
    """

    lanes: Lanes
    radius: Array
    pressure: Array
    hoop_stress: Array
    wound_on_tension: Array
    web_tension: Array
    nip_load: Array
    ridge_height: Array
    band_strain: Array
    stages: int
    stage_error: float
    further: Mapping[str, Array] = field(default_factory=dict)
    errors: Mapping[str, float] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()

    @property
    def arrays(self) -> dict[str, Array]:
        """The variables over lanes and radius that the roll has, (L, M) arrays, by name."""
        own = {name: getattr(self, name) for name in LANE_QUANTITIES if hasattr(self, name)}
        return {**own, **self.further}

    @cached_property
    def worst(self) -> WorstLane:
        """The worst values of all lanes."""
        slack = slack_lanes(self.lanes.share, self.wound_on_tension)
        return WorstLane(
            pressure=float(np.max(self.pressure)),
            core_pressure=float(np.max(self.pressure[:, 0])),
            compression=float(np.max(-self.hoop_stress)),
            tension=float(np.max(self.wound_on_tension)),
            # interpolated between the stages, the tension of a slack lane is zero up to its error
            least_tension=max(0.0, float(np.min(self.wound_on_tension))),
            strain=float(np.max(self.band_strain)),
            ridge_height=float(np.max(self.ridge_height[:, -1])),
            slack_share=float(np.sum(self.lanes.share[slack])),
        )

    def of_lanes(self, lanes: Lanes) -> LaneRoll:
        """Return the first lanes, which are ``lanes``."""
        count = lanes.share.size
        further = {name: values[:count] for name, values in self.further.items()}
        own: dict[str, Any] = {
            name: values[:count] for name, values in self.arrays.items() if name not in further
        }
        return replace(self, lanes=lanes, **own, further=further)

    def with_finite_layers(self, effect: float) -> LaneRoll:
        """Return the lanes with the effect of the thickness of the layers in their errors.

        ``effect`` is that on the pressure, relative to the largest pressure; the tension, a
        property of the surface, hardly depends on it.
        """
        errors = dict(self.errors)
        for name in PRESSURES:
            errors[f"worst_lane.{name}"] += effect * getattr(self.worst, name)
        return replace(self, errors=errors)

    def dataset(self) -> xarray.Dataset:
        """Return the lanes as an xarray Dataset over radius and position; see RollResult.lanes."""
        import xarray

        variables = {
            name: (
                ("radius", "position"),
                values.T,
                {"units": q.unit, "long_name": q.meaning, "symbol": q.symbol},
            )
            for name, values in self.arrays.items()
            for q in [LANE_QUANTITIES[name]]
        }
        across = {
            "share": ("position", self.lanes.share, {"units": "1"}),
            "thickness_excess": ("position", self.lanes.excess, {"units": "1"}),
            "slack": ("position", self.lanes.slack, {"units": "1"}),
        }
        places = {
            "radius": ("radius", self.radius, {"units": "m"}),
            "position": ("position", self.lanes.position, {"units": "m"}),
        }
        return xarray.Dataset({**variables, **across}, places)


def slack_lanes(share: Array, tension: Array) -> Array:
    """Return whether lanes have no tension at some radius, (L,) bool array.

    Parameters
    ----------
    share : (L,) array
        Fraction of the width.
    tension : (L, M) array
        Wound-on tension [N/m].
    """
    mean = float(np.max(share @ tension))
    return np.asarray((tension <= SLACK * mean).any(axis=1))


class WithLanes:
    """Base class of a result that has lanes if its problem has a thickness profile."""

    problem: Any
    lane_roll: LaneRoll | None
    lane_count: int

    def check_lane_count(self) -> None:
        """Reject a number of lanes that no solution has.

        Raises
        ------
        InvalidProblem
        """
        has_lanes = self.problem.thickness_profile is not None
        if self.lane_count and not (has_lanes and FEWEST_LANES <= self.lane_count <= MOST_LANES):
            must = f"0, or {FEWEST_LANES} to {MOST_LANES}" if has_lanes else "0"
            text = f"{self.lane_count} is out of range; must be {must}"
            raise InvalidProblem.at("lane_count", text)

    @property
    def lanes(self) -> xarray.Dataset | None:
        """The lanes across the width over the radius; None without a thickness profile.

        Variables over (``radius``, ``position``), in SI units: ``pressure`` and ``hoop_stress``
        [Pa], ``wound_on_tension``, ``web_tension`` and ``nip_load`` per width of the lane [N/m],
        ``ridge_height`` of the surface over the mean one [m], ``band_strain`` of the web as wound
        [1]; on a two-drum winder also ``front_load`` and ``rider_load`` [N/m]; where the problem
        has beams, ``drum_deflection``, ``core_deflection``, ``front_deflection`` and
        ``rider_deflection`` from the bearings [m]; over ``position`` ``share``,
        ``thickness_excess`` and ``slack`` [1].  A radius is that of the same layer in the mean
        roll.
        """
        return None if (lanes := self._lanes()) is None else lanes.dataset()

    @on_request
    def worst_lane(self) -> WorstLane | None:
        """The worst values of all lanes; None without a thickness profile.

        Files do not contain them: those of a loaded result are recomputed, in a winding
        with a few of the nips.
        """
        return None if (lanes := self._lanes()) is None else lanes.worst

    def recompute_lanes(self) -> LaneRoll:
        """Solve for the lanes of a result that was loaded from a file."""
        raise NotImplementedError

    def _lanes(self) -> LaneRoll | None:
        """Return the lanes, recomputed for a loaded result; None without a thickness profile."""
        if self.lane_roll is None and self.problem.thickness_profile is not None:
            object.__setattr__(self, "lane_roll", self.recompute_lanes())
        return self.lane_roll


def build_up_of(result: Any) -> BuildUp:
    """Return the build-up of a result that was loaded from a file.

    The pressure of the stages is solved again with the known kappa.

    Raises
    ------
    NotConverged
    """
    problem, growth = result.problem, result.kappa
    equations, curve = equations_of(problem), problem.tension_curve
    T_c = float(curve.at(result.radius[:1])[0])
    all_nodes: list[Array] = []
    solutions: list[StageSolution] = []
    for number in range(1, growth.x.size):
        nodes = np.log(result.radius)
        if number < growth.x.size - 1:
            nodes = nodes_between(
                float(growth.x[0]),
                float(growth.x[number]),
                _cells(result),
                surface_layer_depth(problem),
                *kinks_of(curve, growth),
                equations.core_layer,
            )
        source = cell_source(curve, growth, nodes)
        guess = T_c * (nodes[-1] - nodes), np.full_like(nodes, -T_c)
        if solutions:
            guess = stretched(all_nodes[-1], solutions[-1].P, solutions[-1].Q, nodes)
        solved = equations.solve(StageData(nodes, source, T_c), *guess)
        if solved is None:
            raise NotConverged("a stage of the roll could not be solved again")
        all_nodes.append(nodes)
        solutions.append(solved)
    return BuildUp(growth, all_nodes, solutions)


def _cells(result: Any) -> int:
    """Return the approximate number of cells of a stage, without those at kinks of the tension."""
    return max(int(result.radius.size) - 1 - int(result.problem.tension_curve.kinks.size), 1)


def solve_lanes(
    result: Any,
    build_up: BuildUp,
    problem: Any,
    *,
    count: int,
    tolerance: float = TOLERANCE,
    nips: NipsAcross | None = None,
) -> LaneRoll:
    """Solve for the lanes of a roll, and estimate the errors of their worst values.

    A lane has the mean thickness of its part of the width.  Further lanes without a share of the
    width, which do not affect the others, have the extreme thicknesses of the profile, and lie at
    the edges and in the middle of the web if a drum bends.  The error of the number of lanes is the
    difference of the worst values from theirs or, if larger, from those of half as many lanes:
    the lanes that carry a load share it otherwise if they are wider.  The latter is Richardson's
    estimate of order two with the factor of safety 3.  The stages add their tolerance, or their
    largest error where that exceeds it, and the mean roll its own.

    Parameters
    ----------
    result : RollResult
        The roll of the mean web.
    build_up : BuildUp
        Its stages.
    problem : RollProblem or WindingProblem
        With the thickness profile and the oscillation.
    count : int
        Number of lanes.
    tolerance : float
        Of the stages, relative to kappa + 2 and to the tension.
    nips : NipsAcross, optional

    Raises
    ------
    NotConverged
        If a stage has no solution, the layers of a lane separate, or its pressure exceeds the range
        of the law of the stack.
    """
    profile, oscillation = problem.thickness_profile, problem.oscillation
    lanes = profile.lanes(count, oscillation)
    # a bent drum has its extreme loads at the edges and in the middle
    first, last = profile.position[0], profile.position[-1]
    bent = (first, (first + last) / 2, last) if bends(problem) else ()
    extremes = profile.extremes(oscillation, bent)
    together = Lanes(*(np.concatenate(pair) for pair in zip(lanes, extremes, strict=True)))
    solved = _solve(result, build_up, together, nips, tolerance)
    roll = solved.of_lanes(lanes)
    coarse = _solve(result, build_up, profile.lanes(count // 2, oscillation), nips, tolerance)
    _check_law(roll, result.problem.stack)
    of_mean = result.errors.get("peak_pressure", np.nan) / result.peak_pressure
    errors = {}
    for part in fields(WorstLane):
        value, *others = (getattr(each.worst, part.name) for each in (roll, solved, coarse))
        of_lanes = max(abs(value - other) for other in others)
        # the tolerance of the tension is relative to that of the mean web, which is given
        scale = roll.worst.tension if part.name == "least_tension" else abs(value)
        of_stages = max(tolerance, roll.stage_error) * scale
        of_roll = of_mean * abs(value) if part.name in PRESSURES else 0.0
        errors[f"worst_lane.{part.name}"] = of_lanes + of_stages + of_roll
    # the boundary of a slack part lies anywhere within a lane
    is_partly_slack = 0 < roll.worst.slack_share < 1 or solved.worst.least_tension == 0
    errors["worst_lane.slack_share"] = float(np.max(lanes.share)) if is_partly_slack else 0.0
    return replace(roll, errors=errors)


def _solve(
    result: Any, build_up: BuildUp, lanes: Lanes, nips: NipsAcross | None, tolerance: float
) -> LaneRoll:
    """Wind the lanes and apply the changes after winding; errors are not estimated.

    Parameters as of :func:`solve_lanes`.
    """
    problem, curve = result.problem, result.problem.tension_curve
    equations = equations_of(problem)

    def tension_at(x: float, c: Array, mu: Array, guess: Array) -> Any:
        """Return the tension of the lanes of a roll without a nip."""
        T = float(curve.at(np.array([np.exp(x)]))[0])
        return tension_of_web(lanes, c, mu, T / equations.tangential)

    try:
        wound = wind_lanes(
            equations,
            curve,
            lanes,
            tension_at if nips is None else nips.tension_at(lanes),
            build_up,
            tolerance=tolerance,
            cells=_cells(result),
            surface_layer=surface_layer_depth(problem),
        )
    except NotWoundError as stop:
        raise NotConverged(f"with lanes across the width {stop}") from None
    x, (P, Q) = _finished(problem, wound, lanes)
    r, functions = np.exp(x), wound.functions(x)
    r[0], r[-1] = result.radius[[0, -1]]  # without the rounding error of exp(ln r)
    T, h, thickness = curve.at(r), float(problem.web_thickness), (1 + lanes.excess)[:, None]
    theta = _shared(functions[THETA], lanes.share * (1 + lanes.excess))
    tension = h * T * theta * thickness
    web, loads, deflections = tension, [np.full_like(tension, np.nan)], {}
    if nips is not None:
        of_web = _shared(functions[WEB], lanes.share * (1 + lanes.excess))
        web = nips.web_tension(r) * of_web * thickness
        loads = [
            N * _shared(share, lanes.share)
            for N, share in zip(nips.nip_loads(r), functions[LOAD:], strict=True)
        ]
        deflections = dict(nips.deflections(lanes, np.array(loads)))
    return LaneRoll(
        lanes=lanes,
        radius=r,
        # where a lane becomes slack between two stages, the interpolated source is not exact
        pressure=np.maximum(P, 0.0),
        hoop_stress=-(P + Q),
        wound_on_tension=tension,
        web_tension=web,
        nip_load=loads[0],
        ridge_height=functions[RHO] * r,
        band_strain=T * theta / equations.tangential,
        stages=wound.curves.x.size - 1,
        stage_error=wound.largest_error,
        further={**dict(zip(NIP_LOADS[1:], loads[1:], strict=False)), **deflections},
    )


def _shared(functions: Array, weight: Array) -> Array:
    """Return shares of the lanes (L, M) that are interpolated between the stages.

    They are not negative, and their mean with a ``weight`` (L,) is the same as before.
    """
    positive = np.maximum(functions, 0.0)
    return np.asarray(positive * (weight @ functions) / (weight @ positive))


def _finished(problem: Any, wound: LaneBuildUp, lanes: Lanes) -> tuple[Array, tuple[Array, Array]]:
    """Return the lanes after the changes of the finished roll, with nodes at the kinks of these.

    Temperature and moisture of a layer are those at its radius in the mean roll.

    Returns
    -------
    (M,) array
        ln r of the nodes in the mean roll.
    two (L, M) arrays
        P and Q of the lanes [Pa].
    """
    assert wound.data is not None
    changes, x, P, Q = FinalChanges(problem), wound.x, wound.P, wound.Q
    X = wound.data.x.reshape(P.shape)
    source = CellSource(
        *(np.append(part, 0).reshape(P.shape)[:, :-1] for part in wound.data.source)
    )
    if changes.kinks.size:
        x = with_nodes(wound.x, changes.kinks)
        source = _between_nodes(source, wound.x, x)
        X = x + np.array([np.interp(x, wound.x, shift) for shift in X - wound.x])
        P, Q = interpolate_pressure(wound.x, P, Q, x)
    tension = np.asarray(wound.data.tension + changes.core)
    data = stage_data(X, changes.added_to(source, x), tension)
    found = solve_on_core(equations_of(problem), data, P.ravel(), Q.ravel(), problem.core_removed)
    if found is None:
        raise NotConverged("no equilibrium of the lanes after the change of temperature or core")
    solved, _ = found
    P, Q = solved.P.reshape(P.shape), solved.Q.reshape(P.shape)
    loosest = np.unravel_index(np.argmin(P), P.shape)
    if problem.is_changed and P[loosest] < -ROUNDING * float(np.max(P)):
        place = f"the lane at {lanes.position[loosest[0]]:.4g} m across the web"
        raise NotConverged(
            f"the layers of {place} separate: the changes after winding reduce the pressure to zero"
        )
    return x, (P, Q)


def _between_nodes(source: CellSource, x: Array, x_new: Array) -> CellSource:
    """Return a source in the cells between more nodes, by the parabola through its values.

    Parameters
    ----------
    source : CellSource
        Of (L, n) arrays.
    x, x_new : (n + 1,), (k + 1,) arrays
        Nodes ln r, and nodes that divide some of the cells.

    Returns
    -------
    CellSource
        Of (L, k) arrays.
    """
    middle = (x_new[1:] + x_new[:-1]) / 2
    cell = np.clip(np.searchsorted(x, middle) - 1, 0, x.size - 2)

    def at(points: Array) -> Array:
        """Return the source at one point of each new cell, (L, k)."""
        t = (points - x[cell]) / (x[cell + 1] - x[cell])
        left, centre, right = (part[:, cell] for part in source)
        rise, bend = right - left, 2 * (left + right - 2 * centre)
        return np.asarray(left + t * rise - t * (1 - t) * bend)

    return CellSource(at(x_new[:-1]), at(middle), at(x_new[1:]))


def _check_law(roll: LaneRoll, stack: Any) -> None:
    """Raise an error for a pressure beyond the range of the stack's law."""
    lane = int(np.argmax(np.max(roll.pressure, axis=1)))
    P = float(np.max(roll.pressure[lane]))
    end = min(stack.limit, stack.radial.max_pressure)
    if end > P:
        return
    raise NotConverged(
        f"the pressure of the lane at {roll.lanes.position[lane]:.4g} m across the web reaches "
        f"{P:.4g} Pa, beyond the range of the stack law, which ends at {end:.4g} Pa; lower the "
        "tension, oscillate the web, or extend the law"
    )
