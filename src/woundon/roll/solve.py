r"""The stresses in a wound roll: from a problem to a certified result.

    RollProblem --> stage by stage: source, pressure          build_up, equations
                     --> the finished roll, with its final changes
                     --> refinement of stages and nodes until the error estimate is met
                     --> RollResult with its certificate      certificate

The published layer-by-layer scheme (Hakiel 1987) is available as ``theories.layer_by_layer``.
"""

from __future__ import annotations

from collections.abc import Callable
from math import inf, log
from typing import Annotated, Any, NamedTuple

import numpy as np

from ..arguments import Option, check_type, tolerance
from ..errors import NotConverged
from ..parallel import one_thread
from ..problems.roll import RollProblem
from ..results import Residuals
from .build_up import (
    BuildUp,
    NotWoundError,
    source_error,
    wind,
    wind_finite_layers,
    wind_with_stages,
)
from .certificate import certificate
from .equations import pressure_between
from .finished import equations_of, finished_arrays, layer_thickness
from .finite_layers import finite_layer_effects, layers_of
from .result import RollResult

__all__ = [
    "ThinLayerRoll",
    "check_options",
    "solve_thin_layers",
    "solve_wound_roll",
]

Array = np.ndarray
Report = Callable[[float], None]

DEFAULT_RTOL = 1e-3
RTOL_OPTION = Option(
    "Relative error of the solver.",
    "1e-8 to 0.1, of the pressure relative to the largest; default 1e-3.",
)
# Tolerance and cells of the stages for the largest rtol, and their factors per factor of four in
# rtol; then the cells are refined until the errors by nodes and by stages are below rtol.
FIRST_TOLERANCE, FIRST_CELLS = 0.008, 28
TOLERANCE_FACTOR, CELL_FACTOR = 0.25, 1.42
NODE_ERROR_FACTOR = 0.6  # of the change by refined nodes; a third follows from order four
# Safety factor of the stage error, which neglects that errors of earlier stages propagate.
STAGE_ERROR_FACTOR = 1.6
STAGE_ERROR_SHARE = 0.7  # of rtol
MAX_LEVELS = 12
COARSE = 1e-2  # rtol that the second level reaches; smaller values start at a finer level
ROUNDING = 1e-9
# Tolerance of the stages of a neighbouring roll: the last Newton step, whose square is about the
# remaining error, is at most 5e-8.
NEIGHBOUR_TOLERANCE = 5e-13
ESTIMATED = "peak_pressure", "core_pressure", "mid_pressure", "least_hoop_stress"
NEIGHBOURHOOD = 0.15  # of the build-up


@one_thread
def solve_wound_roll(
    problem: RollProblem,
    *,
    rtol: Annotated[float, RTOL_OPTION] = DEFAULT_RTOL,
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
    check_options(rtol=rtol)
    core, R = problem.core.radius, problem.radius

    def reached(radius: float) -> None:
        if progress is not None:
            progress(min(max((radius - core) / (R - core), 0.0), 1.0))

    return solve_thin_layers(problem, rtol, reached).with_finite_layers()


class ThinLayerRoll(NamedTuple):
    """The solution for a roll in the limit of thin layers, and its build-up.

    Attributes
    ----------
    result : RollResult
        Without a certificate; its errors are those of the discretisation.
    known : BuildUp
    cells : int
        Cells of its stages.
    """

    result: RollResult
    known: BuildUp
    cells: int

    def with_finite_layers(self) -> RollResult:
        """Return the certified result with layers of the web's thickness."""
        result = _with_layers(self.result, self.known, self.cells)
        return result.replace(residuals=certificate(result)).checked()

    def wound_with(self, problem: RollProblem) -> ThinLayerRoll:
        """Return the roll of a neighbouring tension with the same stages and number of cells.

        The discretisation errors cancel in the difference; the error estimates are copied.
        """
        known, result = _wind(problem, NEIGHBOUR_TOLERANCE, self.cells, self.known, None)
        return ThinLayerRoll(result.replace(errors=self.result.errors), known, self.cells)


def solve_thin_layers(
    problem: RollProblem, rtol: float, report: Report | None = None
) -> ThinLayerRoll:
    """Solve for a roll in the limit of thin layers; see :func:`solve_wound_roll`."""
    level = max(0, int(log(rtol / COARSE, TOLERANCE_FACTOR)))
    tolerance, cells = (
        FIRST_TOLERANCE * TOLERANCE_FACTOR**level,
        round(FIRST_CELLS * CELL_FACTOR**level),
    )
    least = tolerance * TOLERANCE_FACTOR**3
    known: BuildUp | None = None
    before: RollResult | None = None
    steps, error = 0, inf
    for _ in range(MAX_LEVELS):
        known, result = _wind(problem, tolerance, cells, known, report)
        steps += result.steps
        _check_layers_in_contact(result, COARSE)
        stages = _stage_errors(result)
        rough = stages["peak_pressure"] / max(result.peak_pressure, 1e-300)
        if rough > STAGE_ERROR_SHARE * rtol and tolerance > least:
            tolerance *= max(
                TOLERANCE_FACTOR**2, TOLERANCE_FACTOR**0.5 * STAGE_ERROR_SHARE * rtol / rough
            )
            known = before = None
            continue
        if before is not None:
            errors = {name: by + stages[name] for name, by in _node_errors(before, result).items()}
            error = errors["peak_pressure"] / max(result.peak_pressure, 1e-300)
            if error <= rtol:
                result = _check_stack_law(result.replace(steps=steps, errors=errors), known)
                return ThinLayerRoll(result, known, cells)
        before, cells = result, round(cells * CELL_FACTOR)
    _check_layers_in_contact(result, ROUNDING)
    raise NotConverged(
        f"rtol={rtol:g} is not reached: the estimated error of the pressure is {error:.2g}", result
    )


def check_options(*, rtol: Any = DEFAULT_RTOL) -> None:
    """Check the options of :func:`solve_wound_roll`.

    Raises
    ------
    InvalidProblem
        For an option out of range.
    """
    tolerance("rtol", rtol, 1e-8, 0.1)


def _wind(
    problem: RollProblem,
    tolerance: float,
    cells: int,
    known: BuildUp | None,
    report: Report | None,
) -> tuple[BuildUp, RollResult]:
    equations, curve = equations_of(problem), problem.tension_curve
    layer = layer_thickness(problem)
    try:
        if known is None:
            found = wind(
                equations,
                curve,
                problem.core.radius,
                problem.radius,
                tolerance=tolerance,
                cells=cells,
                layer=layer,
                report=report,
            )
        else:
            found = wind_with_stages(
                equations,
                curve,
                known,
                tolerance=tolerance,
                cells=cells,
                layer=layer,
                report=report,
            )
    except NotWoundError as stop:
        raise NotConverged(str(stop)) from None
    arrays = finished_arrays(problem, found.x, found.growth, found.solved)
    result = RollResult(problem=problem, **arrays, residuals=Residuals())
    return found, result.replace(steps=equations.steps + result.steps)


def _with_layers(result: RollResult, known: BuildUp, cells: int) -> RollResult:
    """Return a result with layers of the web's thickness, their effect added to the errors."""
    layers = layers_of(result)
    try:
        growth = wind_finite_layers(
            layers, known, cells=cells, layer=layer_thickness(result.problem)
        )
    except NotWoundError as stop:
        raise NotConverged(f"with layers as thick as the web {stop}", result) from None
    result = result.replace(layer_growth=growth, steps=result.steps + layers.equations.steps)
    by = finite_layer_effects(result)
    return result.replace(errors={name: error + by[name] for name, error in result.errors.items()})


def _node_errors(before: RollResult, now: RollResult) -> dict[str, float]:
    """Estimate the errors due to the nodes from the change by refined nodes [Pa]."""
    x = _error_points(now)
    (P0, Q0), (P1, Q1) = (
        pressure_between(np.log(r.radius), r.pressure, r.pressure_gradient, x)
        for r in (before, now)
    )
    return _largest_errors(
        now, NODE_ERROR_FACTOR * np.abs(P1 - P0), NODE_ERROR_FACTOR * np.abs(P1 + Q1 - P0 - Q0)
    )


def _stage_errors(result: RollResult) -> dict[str, float]:
    """Estimate the errors due to the interpolation of the source between stages [Pa]."""
    problem, x = result.problem, np.log(result.radius)
    source_errors = source_error(problem.tension_curve, result.kappa, x)
    by = equations_of(problem).linear_response(
        x, result.pressure, result.pressure_gradient, source_errors
    )
    P, Q = (STAGE_ERROR_FACTOR * np.interp(_error_points(result), x, values) for values in by)
    return _largest_errors(result, np.abs(P), np.abs(P + Q))


def _error_points(result: RollResult) -> Array:
    """Return ln r where errors are estimated: the nodes and the midpoints between them."""
    x = np.log(result.radius)
    return np.sort(np.append(x, (x[1:] + x[:-1]) / 2))


def _largest_errors(result: RollResult, pressure: Array, hoop: Array) -> dict[str, float]:
    """Return the largest errors; for an output at one radius, the largest within a neighbourhood.

    The estimated error may change sign at that radius.
    """
    r, core, R = np.exp(_error_points(result)), result.radius[0], result.radius[-1]
    near_core, near_mid = (
        abs(r - place) <= NEIGHBOURHOOD * (R - core) for place in (core, (core + R) / 2)
    )
    worst = pressure, pressure[near_core], pressure[near_mid], hoop
    return {name: float(np.max(errors)) for name, errors in zip(ESTIMATED, worst, strict=True)}


def _check_stack_law(result: RollResult, known: BuildUp) -> RollResult:
    """Return the result if its layers are in contact and the stack's law covers the pressure.

    At every radius the pressure rises from stage to stage, so that the roll as wound has the
    largest pressure before the final changes.
    """
    _check_layers_in_contact(result, ROUNDING)
    limit, wound = result.problem.stack.limit, float(np.max(known.solved.P))
    if max(wound, result.peak_pressure) >= limit:
        when = " as wound" if wound > result.peak_pressure else ""
        raise NotConverged(
            f"the pressure reaches {max(wound, result.peak_pressure):.4g} Pa{when}, beyond the "
            f"stack's law, which holds below {limit:.4g} Pa; less tension, or a law that reaches "
            "farther",
            result,
        )
    return result


def _check_layers_in_contact(result: RollResult, slack: float) -> None:
    """Raise NotConverged for a roll whose layers separate."""
    loosest = int(np.argmin(result.pressure))
    if result.pressure[loosest] < -slack * result.peak_pressure:
        raise NotConverged(
            f"the layers come apart at the radius {result.radius[loosest]:.6g} m: nothing holds "
            "them where the finished roll's changes take all pressure away",
            result,
        )
