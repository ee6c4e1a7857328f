"""Solution for the lanes of a finished roll, with the estimated errors of the worst lane."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import fields, replace
from typing import Protocol

import numpy as np

from ..errors import NotConverged
from ..problems.bending import bends
from ..problems.roll import RollProblem
from ..problems.stack import Stack
from ..problems.thickness_profile import Lanes
from ..problems.winding import WindingProblem
from .build_up import BuildUp, NotWoundError, wind, wind_with_stages
from .equations import (
    CellSource,
    OwnPressure,
    StageData,
    StageSolution,
    initial_guess,
    interpolate_pressure,
)
from .finished import (
    ROUNDING,
    FinalChanges,
    layers_of,
    middle_of_layers,
    surface_layer_depth,
    with_nodes,
)
from .lane_roll import NIP_LOADS, POSITION, PRESSURES, LaneRoll, WorstLane
from .lane_tension import TensionOfLanes, tension_of_web
from .lanes import LOAD, RHO, THETA, WEB, LaneBuildUp, TensionAt, stage_data, wind_lanes
from .roll_fields import RollFields
from .separation import solve_on_core
from .stage_nodes import cell_source, kinks_of, nodes_between, radii_of_nodes

__all__ = ["NipsAcross", "build_up_of", "solve_lanes"]

Array = np.ndarray

TOLERANCE = 2e-3  # of the stages by default, that of a roll with the default rtol


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


def build_up_of(result: RollFields) -> BuildUp:
    """Return the build-up of a result that was loaded from a file.

    The pressure of the stages is solved again with the known kappa.

    Raises
    ------
    NotConverged
    """
    problem, growth = result.problem, result.kappa
    layers, curve = layers_of(problem), problem.tension_curve
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
                layers.equations.core_layer,
            )
        source = cell_source(curve, growth, nodes)
        last = (all_nodes[-1], solutions[-1].P, solutions[-1].Q) if solutions else None
        stage = StageData(nodes, source, T_c, own=layers.own(nodes))
        solved = layers.equations.solve(stage, *initial_guess(nodes, T_c, last))
        if solved is None:
            raise NotConverged("a stage of the roll could not be solved again")
        all_nodes.append(nodes)
        solutions.append(solved)
    return BuildUp(growth, all_nodes, solutions)


def _wound_at_rest(result: RollFields, tolerance: float) -> BuildUp:
    """Return the build-up of the same roll without centrifugal force.

    Its stages are chosen with a ``tolerance`` of kappa, relative to kappa + 2, and then solved
    without the error of Newton's method, as the lanes need them.

    Raises
    ------
    NotWoundError
    """
    problem = _at_rest(result.problem)
    layers = layers_of(problem)
    cells, surface_layer = _cells(result), surface_layer_depth(problem)
    reference = wind(
        layers,
        problem.core.radius,
        problem.radius,
        tolerance=tolerance,
        cells=cells,
        surface_layer=surface_layer,
    )
    return wind_with_stages(layers, reference, cells=cells, surface_layer=surface_layer)


def _at_rest(problem: RollProblem) -> RollProblem:
    """Return the problem without the centrifugal force, which the lanes neglect."""
    return problem.replace(web_speed=None) if problem.centrifugal_stress else problem


def _cells(result: RollFields) -> int:
    """Return the approximate number of cells of a stage, without those at kinks of the tension."""
    return max(int(result.radius.size) - 1 - int(result.problem.tension_curve.kinks.size), 1)


def solve_lanes(
    result: RollFields,
    build_up: BuildUp,
    problem: RollProblem | WindingProblem,
    *,
    count: int,
    tolerance: float = TOLERANCE,
    nips: NipsAcross | None = None,
    report: Callable[[float], None] | None = None,
) -> LaneRoll:
    """Solve for the lanes of a roll, and estimate the errors of their worst values.

    A lane has the mean thickness of its part of the width.  Further lanes without a share of the
    width, which do not affect the others, have the extreme thicknesses of the profile, and lie at
    the edges and in the middle of the web if a drum bends.  The error of the number of lanes is the
    difference of the worst values from theirs or, if larger, from those of half as many lanes:
    the lanes that carry a load share it otherwise if they are wider.  The latter is Richardson's
    estimate of order two with the factor of safety 3.  The stages add their tolerance, or their
    largest error where that exceeds it, and the mean roll its own.

    The lanes neglect the centrifugal force: their mean roll is wound at rest.

    Parameters
    ----------
    result : RollResult
        The roll of the mean web.
    build_up : BuildUp
        Its stages, which those of the lanes begin with if the roll is wound at rest.
    problem : RollProblem or WindingProblem
        With the thickness profile and the oscillation.
    count : int
        Number of lanes.
    tolerance : float
        Of the stages, relative to kappa + 2 and to the tension.
    nips : NipsAcross, optional
    report : callable, optional
        Is called with each stage's radius [m]: of all lanes, then of half as many.

    Raises
    ------
    NotConverged
        If a stage has no solution, the layers of a lane separate, or its pressure exceeds the range
        of the law of the stack.
    """
    if result.problem.centrifugal_stress:
        build_up = _wound_at_rest(result, tolerance)
    profile, oscillation = problem.thickness_profile, problem.oscillation
    assert profile is not None  # of a problem with lanes
    lanes = profile.lanes(count, oscillation)
    # a bent drum has its extreme loads at the edges and in the middle
    first, last = profile.position[0], profile.position[-1]
    bent = (first, (first + last) / 2, last) if bends(problem) else ()
    extremes = profile.extremes(oscillation, bent)
    together = Lanes(*(np.concatenate(pair) for pair in zip(lanes, extremes, strict=True)))
    solved = _solve(result, build_up, together, nips, tolerance, report)
    roll = solved.of_lanes(lanes)
    half = profile.lanes(count // 2, oscillation)
    coarse = _solve(result, build_up, half, nips, tolerance, report)
    _check_law(roll, result.problem.stack)
    of_mean = result.errors.get("peak_pressure", np.nan) / float(np.max(result.pressure))
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
    result: RollFields,
    build_up: BuildUp,
    lanes: Lanes,
    nips: NipsAcross | None,
    tolerance: float,
    report: Callable[[float], None] | None,
) -> LaneRoll:
    """Wind the lanes and apply the changes after winding; errors are not estimated.

    Parameters as of :func:`solve_lanes`.
    """
    problem = _at_rest(result.problem)
    layers, curve, E_t = layers_of(problem), problem.tension_curve, problem.stack.tangential

    def tension_at(x: float, c: Array, mu: Array, guess: Array) -> TensionOfLanes:
        """Return the tension of the lanes of a roll without a nip."""
        T = float(curve.at(np.array([np.exp(x)]))[0])
        return tension_of_web(lanes, c, mu, T / E_t)

    try:
        wound = wind_lanes(
            layers,
            lanes,
            tension_at if nips is None else nips.tension_at(lanes),
            build_up,
            tolerance=tolerance,
            cells=_cells(result),
            surface_layer=surface_layer_depth(problem),
            report=report,
        )
    except NotWoundError as stop:
        raise NotConverged(f"with lanes across the width {stop}") from None
    x, *states = _finished(problem, wound, lanes)
    r, functions = radii_of_nodes(x, *result.radius[[0, -1]]), wound.functions(x)
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
    middle = np.log(middle_of_layers(r, r, h))
    finished, as_wound = (
        {
            # where a lane becomes slack between two stages, the interpolated source is not exact
            "pressure": np.maximum(P, 0.0),
            "hoop_stress": -sum(interpolate_pressure(x, P, Q, middle)),
        }
        for P, Q in states
    )
    before = {f"{name}_as_wound": values for name, values in as_wound.items()}
    return LaneRoll(
        lanes=lanes,
        radius=r,
        **finished,
        wound_on_tension=tension,
        web_tension=web,
        nip_load=loads[0],
        ridge_height=functions[RHO] * r,
        band_strain=T * theta / E_t,
        stages=wound.curves.x.size - 1,
        stage_error=wound.largest_error,
        further={
            **dict(zip(NIP_LOADS[1:], loads[1:], strict=False)),
            **deflections,
            **(before if problem.is_changed else {}),
        },
    )


def _shared(functions: Array, weight: Array) -> Array:
    """Return shares of the lanes (L, M) that are interpolated between the stages.

    They are not negative, and their mean with a ``weight`` (L,) is the same as before.
    """
    positive = np.maximum(functions, 0.0)
    return np.asarray(positive * (weight @ functions) / (weight @ positive))


def _finished(
    problem: RollProblem, wound: LaneBuildUp, lanes: Lanes
) -> tuple[Array, tuple[Array, Array], tuple[Array, Array]]:
    """Return the lanes as wound and after the changes after winding, with nodes at the kinks.

    Temperature and moisture of a layer are those at its radius in the mean roll.

    Returns
    -------
    (M,) array
        ln r of the nodes in the mean roll.
    two pairs of (L, M) arrays
        Total pressure of the lanes and r times its gradient, finished and as wound [Pa].
    """
    data, own_slope = wound.data, wound.own_slope
    assert data is not None
    assert data.own is not None
    assert own_slope is not None
    layers, changes, x, P, Q = layers_of(problem), FinalChanges(problem), wound.x, wound.P, wound.Q
    X, p = data.x.reshape(P.shape), data.own.pressure[: P.size].reshape(P.shape)
    source = CellSource(*(np.append(part, 0).reshape(P.shape)[:, :-1] for part in data.source))
    own = data.own
    if changes.kinks.size:
        x = with_nodes(wound.x, changes.kinks)
        source = _between_nodes(source, wound.x, x)
        P, Q = interpolate_pressure(wound.x, P, Q, x)
        shift = np.array([np.interp(x, wound.x, values) for values in X - wound.x])
        # r p = T h/2, and dp/d ln r + p = h T'/2
        r, middle = np.exp(X), (x[1:] + x[:-1]) / 2
        (rp, slope), (rp_middle, _) = (
            interpolate_pressure(wound.x, r * p, r * (own_slope + p), points)
            for points in (x, middle)
        )
        X = x + shift
        p, in_cells = rp / np.exp(X), rp_middle / np.exp((X[:, 1:] + X[:, :-1]) / 2)
        own_slope = slope / np.exp(X) - p
        in_cells = np.append(in_cells, np.zeros((len(p), 1)), axis=1)
        pressure = np.concatenate([p.ravel(), in_cells.ravel()[:-1]])
        own = OwnPressure(pressure, layers.equations.strain(pressure))

    def solved(
        sources: CellSource, tension: Array, P: Array, Q: Array, removed: bool
    ) -> tuple[Array, Array]:
        """Return the total pressure of all lanes and r times its gradient."""
        stage = stage_data(X, sources, tension, own)
        stage.surface_pressure = -p[:, -1]
        found = solve_on_core(layers.equations, stage, P.ravel(), Q.ravel(), removed)
        if found is None:
            text = "no equilibrium of the lanes after the changes of the finished roll"
            raise NotConverged(text)
        state = found[0]
        return state.P.reshape(p.shape) + p, state.Q.reshape(p.shape) + own_slope

    T_c = np.asarray(data.tension)
    finished = solved(changes.added_to(source, x), T_c + changes.core, P, Q, problem.core_removed)
    as_wound = solved(source, T_c, P, Q, False) if problem.is_changed else finished
    P, _ = finished
    if problem.core_removed:
        P[:, 0] = 0.0  # without the rounding error
    loosest = np.unravel_index(np.argmin(P), P.shape)
    if problem.is_changed and P[loosest] < -ROUNDING * float(np.max(P)):
        position = POSITION.stored_text(lanes.position[loosest[0]])
        place = f"the lane at {position} across the web"
        raise NotConverged(
            f"the layers of {place} separate: the changes after winding reduce the pressure to zero"
        )
    return x, finished, as_wound


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


def _check_law(roll: LaneRoll, stack: Stack) -> None:
    """Raise an error for a pressure beyond the range of the stack's law."""
    lane = int(np.argmax(np.max(roll.pressure, axis=1)))
    P = float(np.max(roll.pressure[lane]))
    end = min(stack.limit, stack.radial.max_pressure)
    if end > P:
        return
    position = POSITION.stored_text(roll.lanes.position[lane])
    raise NotConverged(
        f"the pressure of the lane at {position} across the web reaches {P:.4g} Pa, beyond the "
        f"range of the stack law, which ends at {end:.4g} Pa; lower the tension, oscillate the "
        "web, or extend the law"
    )
