r"""Solution of a wound roll with error estimates: from a problem to a certified result.

    RollProblem --> build-up, stage by stage                  build_up, equations, growth
                --> finished roll, changes after winding      finished
                --> refinement of stages and nodes until the error estimate is below rtol
                --> error by the layer thickness              finite_layers
                --> RollResult with residuals                 certificate

The published layer-by-layer scheme (Hakiel 1987) is available as ``theories.layer_by_layer``.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import inf, log, nan
from typing import Annotated, Any, NamedTuple

import numpy as np

from ..arguments import Option, check_type, tolerance, whole_number
from ..errors import NotConverged
from ..parallel import one_thread
from ..problems.roll import RollProblem
from ..problems.winding import WindingProblem
from ..results import Residuals
from .build_up import (
    BuildUp,
    NotWoundError,
    wind,
    wind_thin_layers,
    wind_with_stages,
)
from .certificate import certificate
from .equations import interpolate_pressure
from .finished import (
    additional_pressure,
    finished_arrays,
    finished_zones,
    layers_of,
    surface_layer_depth,
)
from .finite_layers import (
    NEIGHBOURHOOD,
    finite_layer_errors,
    is_surely_off_core,
    with_bore_displacement,
)
from .lane_roll import FEWEST_LANES, LANES, MOST_LANES, LaneRoll
from .result import RollResult
from .solve_lanes import NipsAcross, solve_lanes
from .stage_nodes import source_error
from .validity import roll_warnings

__all__ = [
    "LANES_OPTION",
    "PASSES_OF_LANES",
    "Report",
    "WoundRoll",
    "check_options",
    "lanes_of",
    "pass_reporter",
    "solve_uncertified",
    "solve_wound_roll",
]

Array = np.ndarray
Report = Callable[[float], None]

DEFAULT_RTOL = 1e-3
RTOL_OPTION = Option(
    "Relative error of the solver.",
    "1e-8 to 0.1, of the pressure relative to the largest; default 1e-3.",
)
LANES_OPTION = Option(
    "Number of lanes across the width.",
    "4 to 1000, with a thickness profile; default 50.",
)
# Tolerance of kappa and cells of a stage for the largest rtol, and their factors when rtol is
# reduced by a factor of four.  Then the cells are refined until the estimated error is below rtol.
FIRST_TOLERANCE, FIRST_CELLS = 0.008, 28
TOLERANCE_FACTOR, CELL_FACTOR = 0.25, 1.42
# Node error relative to the change by refinement: 1/3 from order four, and a safety factor.
NODE_ERROR_FACTOR = 0.6
# Safety factor of the stage error, which neglects the propagation of errors of earlier stages.
STAGE_ERROR_FACTOR = 1.6
STAGE_ERROR_SHARE = 0.7  # fraction of rtol for the stage error
MAX_LEVELS = 12
# Fractions of the work at the ends of the passes over the radius, for the reported progress: two
# usually suffice, the second one on more nodes.
PASSES = (0.0, 0.4, 0.9, 0.95, 0.975, 0.99)
# The same for all lanes and half as many, and the share of the roll of the mean web before them.
PASSES_OF_LANES, OF_MEAN_ROLL = (0.0, 0.7, 0.99), 0.15
COARSE = 1e-2  # rtol reached by the second level; smaller values start at a finer level
ESTIMATED = (
    "peak_pressure",
    "core_pressure",
    "mid_pressure",
    "least_hoop_stress",
    "bore_hoop_stress",
)


@one_thread
def solve_wound_roll(
    problem: RollProblem,
    *,
    rtol: Annotated[float, RTOL_OPTION] = DEFAULT_RTOL,
    lanes: Annotated[int, LANES_OPTION] = LANES,
    progress: Callable[[float], None] | None = None,
) -> RollResult:
    """Solve for the pressure and the stresses in a wound roll.

    Every stage of the build-up is one boundary-value problem; the cost does not depend on the
    number of layers.

    Parameters
    ----------
    problem : RollProblem
    rtol : float
        Accepted error of the pressure, relative to the largest; 1e-8 to 0.1.
    lanes : int
        Number of lanes into which the width is divided if the problem has a thickness profile.
    progress : callable, optional
        Called with the computed fraction of the build-up, for each discretisation.

    Returns
    -------
    RollResult

    Raises
    ------
    InvalidProblem
        For options out of range.
    NotConverged
        If a stage has no solution, a pressure exceeds the range of the stack's law, or ``rtol`` is
        not reached.
    """
    check_type("problem", problem, RollProblem)
    check_options(rtol=rtol, lanes=lanes)
    has_lanes = problem.thickness_profile is not None
    of_roll = OF_MEAN_ROLL if has_lanes else 1.0

    radii = problem.core.radius, problem.radius
    roll = solve_uncertified(problem, rtol, pass_reporter(progress, radii, PASSES, end=of_roll))
    if has_lanes:
        # the stages of the lanes are those of a roll without the error of Newton's method
        roll = roll.wound_with(problem)
        report = pass_reporter(progress, radii, PASSES_OF_LANES, of_roll)
        lane_roll = lanes_of(roll, problem, rtol, lanes, report=report)
        result = roll.result.replace(lane_roll=lane_roll, lane_count=lanes)
        roll = roll._replace(result=result)
    result = roll.certified().warned()
    if progress is not None:
        progress(1.0)
    return result


def pass_reporter(
    progress: Callable[[float], None] | None,
    radii: tuple[float, float],
    ends: Sequence[float],
    begin: float = 0.0,
    end: float = 1.0,
) -> Report:
    """Return the function that reports passes over the radius [m] as a part of the work.

    Parameters
    ----------
    progress : callable or None
        Is called with the fraction of the work; None for no report.
    radii : (float, float)
        Of the core and of the roll [m].
    ends : sequence of float
        Fractions of the part at the ends of the passes; further passes share the last one.
    begin, end : float
        Fractions of the work at the ends of the part.
    """
    passes, last = 0, 0.0

    def report(radius: float) -> None:
        """Report the fraction of the work; a smaller radius begins the next pass."""
        nonlocal passes, last
        passes += radius < last
        last = radius
        if progress is not None:
            first, following = ends[min(passes, len(ends) - 2) :][:2]
            share = min(max((radius - radii[0]) / (radii[1] - radii[0]), 0.0), 1.0)
            progress(begin + (first + share * (following - first)) * (end - begin))

    return report


class WoundRoll(NamedTuple):
    """A solved roll, and its build-up.

    Attributes
    ----------
    result : RollResult
        Without residuals; its errors are those of the discretisation.
    build_up : BuildUp
    cells : int
        Cells of each stage.
    """

    result: RollResult
    build_up: BuildUp
    cells: int

    def certified(self) -> RollResult:
        """Return the certified result with the error by the layer thickness in its estimates."""
        result = _with_layer_errors(self.result, self.build_up, self.cells)
        residuals, warnings = certificate(result), roll_warnings(result)
        return result.replace(residuals=residuals, warnings=warnings).checked()

    def wound_with(self, problem: RollProblem) -> WoundRoll:
        """Return the roll with a neighbouring tension, with the same stages and number of cells.

        The discretisation errors cancel in the difference; the error estimates are copied.
        """
        build_up, result = _wind(problem, nan, self.cells, self.build_up, report=None)
        return WoundRoll(result.replace(errors=self.result.errors), build_up, self.cells)


def solve_uncertified(problem: RollProblem, rtol: float, report: Report | None = None) -> WoundRoll:
    """Solve for a roll without its residuals; see :func:`solve_wound_roll`.

    The tolerance of the stages is reduced until their error is below a fraction of rtol, then the
    nodes are refined until the change of the pressure shows an error below rtol.  A smaller rtol
    begins with a smaller tolerance and more cells.

    Parameters
    ----------
    problem : RollProblem
    rtol : float
        Accepted error of the pressure, relative to the largest.
    report : callable, optional
        Is called with each stage's radius [m].
    """
    level = _first_level(rtol)
    tolerance = FIRST_TOLERANCE * TOLERANCE_FACTOR**level
    cells = round(FIRST_CELLS * CELL_FACTOR**level)
    smallest_tolerance = tolerance * TOLERANCE_FACTOR**3
    build_up: BuildUp | None = None
    coarse: RollResult | None = None
    steps, error = 0, inf
    for _ in range(MAX_LEVELS):
        build_up, result = _wind(problem, tolerance, cells, build_up, report)
        steps += result.steps
        peak = max(result.peak_pressure, 1e-300)
        stage_errors = _stage_errors(result)
        excess = stage_errors["peak_pressure"] / peak / (STAGE_ERROR_SHARE * rtol)
        if excess > 1 and tolerance > smallest_tolerance:
            # the error is about proportional to the tolerance: half of the permitted one, at most
            # a sixteenth at once
            tolerance *= max(TOLERANCE_FACTOR**2, TOLERANCE_FACTOR**0.5 / excess)
            build_up = coarse = None  # begin again, with other stages
            continue
        if coarse is not None:
            node_errors = _node_errors(coarse, result)
            errors = {name: node_errors[name] + stage_errors[name] for name in node_errors}
            errors = with_bore_displacement(problem, errors)
            error = errors["peak_pressure"] / peak
            if error <= rtol:
                result = _check_stack_law(result.replace(steps=steps, errors=errors), build_up)
                return WoundRoll(result, build_up, cells)
        coarse, cells = result, round(cells * CELL_FACTOR)
    raise NotConverged(
        f"rtol={rtol:g} is not reached: the estimated error of the pressure is {error:.2g}", result
    )


def _first_level(rtol: float) -> int:
    """Return the number of reductions of the tolerance by TOLERANCE_FACTOR from COARSE to rtol."""
    return max(0, int(log(rtol / COARSE, TOLERANCE_FACTOR)))


def lanes_of(
    roll: WoundRoll,
    problem: RollProblem | WindingProblem,
    rtol: float,
    lanes: int,
    nips: NipsAcross | None = None,
    report: Report | None = None,
) -> LaneRoll:
    """Return the lanes of a roll.

    Parameters
    ----------
    roll : WoundRoll
        The roll of the mean web, whose stages have the tolerance of :meth:`wound_with`.
    problem : RollProblem or WindingProblem
        With a ``thickness_profile``.
    rtol : float
        Accepted error of the pressure, relative to the largest.
    lanes : int
        Number of lanes.
    nips : NipsAcross, optional
        The nips of a winding.
    report : callable, optional
        As of :func:`.solve_lanes.solve_lanes`.
    """
    return solve_lanes(
        roll.result,
        roll.build_up,
        problem,
        # That with which the stages of the mean roll begin for this rtol.  Those of the lanes are
        # not refined further: the tolerance is a part of the error estimates of the lanes.
        tolerance=FIRST_TOLERANCE * TOLERANCE_FACTOR ** _first_level(rtol),
        count=lanes,
        nips=nips,
        report=report,
    )


def check_options(*, rtol: object = DEFAULT_RTOL, lanes: object = LANES) -> None:
    """Check the options of :func:`solve_wound_roll`.

    Raises
    ------
    InvalidProblem
        For an option out of range.
    """
    tolerance("rtol", rtol, 1e-8, 0.1)
    whole_number("lanes", lanes, FEWEST_LANES, MOST_LANES)


def _wind(
    problem: RollProblem,
    tolerance: float,
    cells: int,
    reference: BuildUp | None,
    report: Report | None,
) -> tuple[BuildUp, RollResult]:
    """Wind a roll and apply the changes after winding.

    Parameters
    ----------
    problem : RollProblem
    tolerance : float
        Of kappa at the stages, relative to kappa + 2, for their choice.
    cells : int
        Cells of each stage.
    reference : BuildUp or None
        A build-up whose stages are used; without one they are chosen adaptively.
    report : callable, optional
        Is called with each stage's radius [m].

    Returns
    -------
    BuildUp, RollResult
        The last stage, and the result without residuals and errors.
    """
    layers, radii = layers_of(problem), (problem.core.radius, problem.radius)
    depth = surface_layer_depth(problem)
    options: Any = {"cells": cells, "surface_layer": depth, "report": report}
    try:
        if reference is None:
            build_up = wind(layers, *radii, tolerance=tolerance, **options)
        else:
            build_up = wind_with_stages(layers, reference, **options)
    except NotWoundError as stop:
        raise NotConverged(str(stop)) from None
    arrays = finished_arrays(problem, build_up.x, build_up.growth, build_up.solved)
    result = RollResult(problem=problem, **arrays, residuals=Residuals())
    return build_up, result.replace(steps=layers.equations.steps + result.steps)


def _with_layer_errors(result: RollResult, build_up: BuildUp, cells: int) -> RollResult:
    """Return a result with the error by the layer thickness added to its error estimates.

    Kappa, the relative change of a layer's pressure with ln r below the surface, is computed in the
    limit of thin layers at the stages of the build-up, and from it the change by the thickness.

    Parameters
    ----------
    result : RollResult
    build_up : BuildUp
        Its stages.
    cells : int
        Cells of each stage.
    """
    layers, depth = layers_of(result.problem), surface_layer_depth(result.problem)
    try:
        growth = wind_thin_layers(layers, build_up, cells=cells, surface_layer=depth)
    except NotWoundError as stop:
        raise NotConverged(f"in the limit of thin layers {stop}", result) from None
    steps = result.steps + layers.equations.steps
    result = result.replace(thin_layer_growth=growth, steps=steps)
    of_layers = finite_layer_errors(result)
    errors = {name: error + of_layers[name] for name, error in result.errors.items()}
    if result.lane_roll is None:
        return result.replace(errors=errors)
    lanes = result.lane_roll.with_layer_error(of_layers["peak_pressure"] / result.peak_pressure)
    return result.replace(errors={**errors, **lanes.errors}, lane_roll=lanes)


def _node_errors(coarse: RollResult, fine: RollResult) -> dict[str, float]:
    """Estimate the errors due to the nodes from the change by refinement [Pa]."""
    x = _error_points(fine)
    (P0, Q0), (P1, Q1) = (
        interpolate_pressure(np.log(r.radius), r.pressure, r.pressure_gradient, x)
        for r in (coarse, fine)
    )
    P, hoop = np.abs(P1 - P0), np.abs(P1 + Q1 - P0 - Q0)
    return _largest_errors(fine, NODE_ERROR_FACTOR * P, NODE_ERROR_FACTOR * hoop)


def _stage_errors(result: RollResult) -> dict[str, float]:
    """Estimate the errors due to the interpolation of the source between stages [Pa]."""
    problem, x = result.problem, np.log(result.radius)
    source_errors = source_error(problem.tension_curve, result.kappa, x)
    zones = finished_zones(problem, result.pressure, result.pressure_gradient)
    layers = layers_of(problem)
    response = layers.equations.linear_response(
        zones.stage(layers, x, source_errors, 0.0),
        *(values[zones.nodes] for values in additional_pressure(result)),
    )
    errors = [zones.spread(error, x.size) for error in response]
    P, Q = (STAGE_ERROR_FACTOR * np.interp(_error_points(result), x, error) for error in errors)
    return _largest_errors(result, np.abs(P), np.abs(P + Q))


def _error_points(result: RollResult) -> Array:
    """Return ln r where errors are estimated: the nodes and the midpoints between them."""
    x = np.log(result.radius)
    return np.sort(np.append(x, (x[1:] + x[:-1]) / 2))


def _largest_errors(result: RollResult, pressure: Array, hoop: Array) -> dict[str, float]:
    """Return the largest error of each output [Pa], by name.

    ``pressure`` and ``hoop`` are the errors of pressure and hoop stress at :func:`_error_points`
    [Pa].

    For an output at one radius it is the largest error within a neighbourhood, because the
    estimate may change sign at that radius.
    """
    r, core, R = np.exp(_error_points(result)), result.radius[0], result.radius[-1]
    near_core, near_middle = (
        abs(r - centre) <= NEIGHBOURHOOD * (R - core) for centre in (core, (core + R) / 2)
    )
    values = pressure, pressure[near_core], pressure[near_middle], hoop, hoop[near_core]
    errors = {name: float(np.max(part)) for name, part in zip(ESTIMATED, values, strict=True)}
    if is_surely_off_core(result, errors["bore_hoop_stress"]):
        errors["core_pressure"] = 0.0
    return errors


def _check_stack_law(result: RollResult, build_up: BuildUp) -> RollResult:
    """Return the result if the pressure is in the range of the law.

    The pressure increases from stage to stage at every radius, so that the roll as wound has the
    largest pressure before the changes after winding.
    """
    stack, wound = result.problem.stack, float(np.max(build_up.solved.P))
    largest, limit = max(wound, result.peak_pressure), stack.radial.max_pressure
    if stack.limit <= largest < limit:
        raise stack.beyond_limit(largest).under("stack")
    if largest >= limit:
        when = " as wound" if wound > result.peak_pressure else ""
        raise NotConverged(
            f"the pressure reaches {largest:.4g} Pa{when}, beyond the "
            f"range of the stack law, which ends at {limit:.4g} Pa; lower the tension or extend "
            "the law",
            result,
        )
    return result
