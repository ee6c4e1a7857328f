r"""The stresses in a wound roll: from a problem to a certified result.

    RollProblem --> stage after stage: source, pressure       build_up, equations
                     --> the finished roll, its changes put in
                     --> the same with more stages and nodes, until both agree
                     --> RollResult with its certificate      certificate

The published lap-by-lap scheme (Hakiel 1987) is available as ``theories.lap_by_lap``.
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
    missed_source,
    wind,
    wind_again,
    wind_laps,
)
from .certificate import certificate
from .equations import pressure_between
from .finished import equations_of, finished_arrays, layer_thickness
from .laps import changed_by_laps, laps_of
from .result import RollResult

__all__ = [
    "ThinLaps",
    "check_options",
    "solve_thin_laps",
    "solve_wound_roll",
]

Array = np.ndarray
Report = Callable[[float], None]

DEFAULT_RTOL = 1e-3
RTOL_OPTION = Option(
    "Relative error of the solver.",
    "1e-8 to 0.1, of the pressure relative to the largest; default 1e-3.",
)
# tolerance of the stages and cells of them, for the largest rtol and each one less by a factor of
# four; then half the cells more, until nodes and stages both leave less than asked
FIRST, CELLS = 0.008, 28
FINER, MORE = 0.25, 1.42
LEFT = 0.6  # of the change by more nodes, as error estimate: a third where it is of order four
# Of the estimate for the stages: it leaves out that the stages themselves stand on earlier ones
STAGES = 1.6
MOST_BY_STAGES = 0.7  # of rtol
MOST_LEVELS = 12
COARSE = 1e-2  # what the second level is good for: for less, the first ones are left out
ROUNDING = 1e-9
# tolerance of the stages of a roll that is wound again: the last step of Newton's method, which
# leaves about the square of its change, is at most 5e-8
EXACT = 5e-13
ESTIMATED = "peak_pressure", "core_pressure", "mid_pressure", "least_hoop_stress"
NEAR = 0.15  # of the build-up


@one_thread
def solve_wound_roll(
    problem: RollProblem,
    *,
    rtol: Annotated[float, RTOL_OPTION] = DEFAULT_RTOL,
    progress: Callable[[float], None] | None = None,
) -> RollResult:
    """Solve for the pressure and the stresses that winding leaves in a roll.

    Every stage of the build-up is one boundary-value problem; the cost does not depend on the
    number of laps.

    Parameters
    ----------
    problem : RollProblem
    rtol : float
        Accepted error of the pressure, relative to the largest; 1e-8 to 0.1.
    progress : callable, optional
        Is called with the fraction of the build-up that is computed, of each discretisation.

    Returns
    -------
    RollResult

    Raises
    ------
    InvalidProblem
        For options out of range.
    NotConverged
        If a stage has no solution, a pressure leaves the stack's law, or ``rtol`` is not reached.
    """
    check_type("problem", problem, RollProblem)
    check_options(rtol=rtol)
    core, R = problem.core.radius, problem.radius

    def reached(radius: float) -> None:
        if progress is not None:
            progress(min(max((radius - core) / (R - core), 0.0), 1.0))

    return solve_thin_laps(problem, rtol, reached).with_laps()


class ThinLaps(NamedTuple):
    """A roll wound of laps without thickness, and how it was built up.

    Attributes
    ----------
    result : RollResult
        Without a certificate; its errors are those of the discretisation.
    known : BuildUp
    cells : int
        Of its stages.
    """

    result: RollResult
    known: BuildUp
    cells: int

    def with_laps(self) -> RollResult:
        """Return the result with laps of the web's thickness, certified."""
        result = _with_laps(self.result, self.known, self.cells)
        return result.replace(residuals=certificate(result)).checked()

    def wound_with(self, problem: RollProblem) -> ThinLaps:
        """Return the roll of a neighbouring tension, in the same stages and on as many cells.

        So the discretisation takes no part in what it differs by; the errors are those of this one.
        """
        known, result = _wound(problem, EXACT, self.cells, self.known, None)
        return ThinLaps(result.replace(errors=self.result.errors), known, self.cells)


def solve_thin_laps(problem: RollProblem, rtol: float, report: Report | None = None) -> ThinLaps:
    """Return a roll in the limit of thin laps; see :func:`solve_wound_roll`."""
    level = max(0, int(log(rtol / COARSE, FINER)))
    tolerance, cells = FIRST * FINER**level, round(CELLS * MORE**level)
    least = tolerance * FINER**3
    known: BuildUp | None = None
    before: RollResult | None = None
    steps, error = 0, inf
    for _ in range(MOST_LEVELS):
        known, result = _wound(problem, tolerance, cells, known, report)
        steps += result.steps
        _pressed(result, COARSE)
        stages = _left_by_stages(result)
        rough = stages["peak_pressure"] / max(result.peak_pressure, 1e-300)
        if rough > MOST_BY_STAGES * rtol and tolerance > least:
            tolerance *= max(FINER**2, FINER**0.5 * MOST_BY_STAGES * rtol / rough)
            known = before = None
            continue
        if before is not None:
            errors = {
                name: by + stages[name] for name, by in _left_by_nodes(before, result).items()
            }
            error = errors["peak_pressure"] / max(result.peak_pressure, 1e-300)
            if error <= rtol:
                result = _admissible(result.replace(steps=steps, errors=errors), known)
                return ThinLaps(result, known, cells)
        before, cells = result, round(cells * MORE)
    _pressed(result, ROUNDING)
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


def _wound(
    problem: RollProblem, tolerance: float, cells: int, known: BuildUp | None,
    report: Report | None,
) -> tuple[BuildUp, RollResult]:  # fmt: skip
    equations, curve = equations_of(problem), problem.tension_curve
    layer = layer_thickness(problem)
    try:
        if known is None:
            found = wind(
                equations, curve, problem.core.radius, problem.radius, tolerance=tolerance,
                cells=cells, layer=layer, report=report,
            )  # fmt: skip
        else:
            found = wind_again(
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


def _with_laps(result: RollResult, known: BuildUp, cells: int) -> RollResult:
    """Return a result with laps of the web's thickness, and what they change in its errors."""
    laps = laps_of(result)
    try:
        growth = wind_laps(laps, known, cells=cells, layer=layer_thickness(result.problem))
    except NotWoundError as stop:
        raise NotConverged(f"with laps as thick as the web {stop}", result) from None
    result = result.replace(lap_growth=growth, steps=result.steps + laps.equations.steps)
    by = changed_by_laps(result)
    return result.replace(errors={name: error + by[name] for name, error in result.errors.items()})


def _left_by_nodes(before: RollResult, now: RollResult) -> dict[str, float]:
    """Return what a change by more nodes leaves of errors [Pa]."""
    x = _compared(now)
    (P0, Q0), (P1, Q1) = (
        pressure_between(np.log(r.radius), r.pressure, r.pressure_gradient, x)
        for r in (before, now)
    )
    return _worst(now, LEFT * np.abs(P1 - P0), LEFT * np.abs(P1 + Q1 - P0 - Q0))


def _left_by_stages(result: RollResult) -> dict[str, float]:
    """Return the errors that come of the source between stages, where it is interpolated [Pa]."""
    problem, x = result.problem, np.log(result.radius)
    missed = missed_source(problem.tension_curve, result.kappa, x)
    by = equations_of(problem).moved(x, result.pressure, result.pressure_gradient, missed)
    P, Q = (STAGES * np.interp(_compared(result), x, values) for values in by)
    return _worst(result, np.abs(P), np.abs(P + Q))


def _compared(result: RollResult) -> Array:
    """Return ln r where errors are estimated: at the nodes, dense where it matters, and between."""
    x = np.log(result.radius)
    return np.sort(np.append(x, (x[1:] + x[:-1]) / 2))


def _worst(result: RollResult, pressure: Array, hoop: Array) -> dict[str, float]:
    """Return the largest errors; for one place the largest ones near it, not to meet a zero."""
    r, core, R = np.exp(_compared(result)), result.radius[0], result.radius[-1]
    near_core, near_mid = (abs(r - place) <= NEAR * (R - core) for place in (core, (core + R) / 2))
    worst = pressure, pressure[near_core], pressure[near_mid], hoop
    return {name: float(np.max(errors)) for name, errors in zip(ESTIMATED, worst, strict=True)}


def _admissible(result: RollResult, known: BuildUp) -> RollResult:
    """Return the result, if the laps press each other, within the stack's law.

    At every radius the pressure rises from stage to stage, so that the roll as wound has the
    largest, whatever changes the finished roll.
    """
    _pressed(result, ROUNDING)
    limit, wound = result.problem.stack.limit, float(np.max(known.solved.P))
    if max(wound, result.peak_pressure) >= limit:
        when = " as wound" if wound > result.peak_pressure else ""
        raise NotConverged(
            f"the pressure reaches {max(wound, result.peak_pressure):.4g} Pa{when}, beyond the "
            f"stack's law, which holds below {limit:.4g} Pa; less tension, or a law that reaches "
            "farther", result
        )  # fmt: skip
    return result


def _pressed(result: RollResult, slack: float) -> None:
    """Refuse a roll whose laps come apart."""
    loosest = int(np.argmin(result.pressure))
    if result.pressure[loosest] < -slack * result.peak_pressure:
        raise NotConverged(
            f"the laps come apart at the radius {result.radius[loosest]:.6g} m: nothing holds them "
            "where the finished roll's changes take all pressure away", result
        )  # fmt: skip
