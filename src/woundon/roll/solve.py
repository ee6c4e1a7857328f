r"""The stresses in a wound roll: from a problem to a certified result.

    WoundRollProblem --> stage after stage: source, pressure       build_up, equations
                     --> the finished roll, its changes put in
                     --> the same with more stages and nodes, until both agree
                     --> WoundRollResult with its certificate      certificate

The published lap-by-lap scheme (Hakiel 1987) stands beside it: ``theories.lap_by_lap``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from math import inf, log
from typing import Any

import numpy as np

from ..arguments import check_type, tolerance
from ..errors import NotConverged
from ..problems.roll import WoundRollProblem
from ..results import Residuals
from ..threads import one_thread
from .build_up import Growth, NotWoundError, cell_source, wind
from .certificate import certificate, changes, equations_of, shifted
from .equations import Solved, pressure_between
from .result import WoundRollResult

__all__ = ["check_options", "finished", "layer_of", "solve_wound_roll"]

Array = np.ndarray
Told = Callable[[float], None]

DEFAULT_RTOL = 1e-3
# tolerance and cells of the first build-up, and of each further one: half the cells more, a quarter
# of the tolerance.  Both errors fall by four to five, a third of the change is left where they fall
# so; few stages make it irregular, so that a change counts for the next one too
FIRST, CELLS = 0.12, 23
FINER, MORE = 0.25, 1.42
LEFT = 0.7  # of the last change, told as error
MOST_LEVELS = 12
COARSE = 1e-2  # what the second level is good for: for less, the first ones are left out
ROUNDING = 1e-9
TOLD = "peak_pressure", "core_pressure", "mid_pressure", "least_hoop_stress"
COMPARED = 400  # radii at which two build-ups are compared


@one_thread
def solve_wound_roll(
    problem: WoundRollProblem,
    *,
    rtol: float = DEFAULT_RTOL,
    told: Told | None = None,
) -> WoundRollResult:
    """Solve for the pressure and the stresses that winding leaves in a roll.

    Every stage of the build-up is one boundary-value problem; the cost does not depend on the
    number of laps.

    Parameters
    ----------
    problem : WoundRollProblem
    rtol : float
        Accepted error of the pressure, relative to the largest; 1e-8 to 0.1.
    told : callable, optional
        Is called with the radius reached [m].

    Returns
    -------
    WoundRollResult

    Raises
    ------
    InvalidProblem
        For options out of range.
    NotConverged
        If a stage has no solution, a pressure leaves the stack's law, or ``rtol`` is not reached.
    """
    check_type("problem", problem, WoundRollProblem)
    check_options(rtol=rtol)
    before: WoundRollResult | None = None
    steps, error = 0, inf
    for level in range(max(0, int(log(rtol / COARSE, FINER))), MOST_LEVELS):
        result = _wound(problem, FIRST * FINER**level, round(CELLS * MORE**level), told)
        steps += result.steps
        if before is not None:
            errors = _told_errors(result, _changes(before, result))
            error = errors["peak_pressure"] / max(result.peak_pressure, 1e-300)
            result = result.replace(errors=errors, steps=steps)
            if error <= rtol:
                return _admissible(result.replace(residuals=certificate(result))).checked()
        before = result
    _admissible(result)
    raise NotConverged(
        f"rtol={rtol:g} is not reached: the estimated error of the pressure is {error:.2g}", result
    )


def check_options(*, rtol: Any = DEFAULT_RTOL, told: Any = None) -> None:
    """Check the options of :func:`solve_wound_roll`.

    Raises
    ------
    InvalidProblem
        For an option out of range.
    """
    tolerance("rtol", rtol, 1e-8, 0.1)


def layer_of(problem: WoundRollProblem) -> float:
    """Return over which part of ln r the pressure rises below a surface.

    There the modulus changes by itself, or, where it does not, waves of the incremental equation
    die out.
    """
    law, T = problem.stack.radial, problem.tension_curve.at(np.array([problem.core.radius]))
    start = np.zeros(1)
    E, slope = float(law.modulus(start)[0]), float(law.modulus_slope(start)[0])
    wave = (E / problem.stack.tangential) ** 0.5
    return float(min(E / (slope * T[0]) if slope > 0 else inf, wave, 0.3))


def _wound(
    problem: WoundRollProblem, tolerance: float, cells: int, told: Told | None
) -> WoundRollResult:
    equations, curve = equations_of(problem), problem.tension_curve
    try:
        found = wind(
            equations, curve, problem.core.radius, problem.radius, tolerance=tolerance,
            cells=cells, layer=layer_of(problem), told=told,
        )  # fmt: skip
    except NotWoundError as stop:
        raise NotConverged(str(stop)) from None
    result = finished(problem, found.x, found.growth, found.solved)
    return result.replace(steps=equations.steps + result.steps)


def finished(
    problem: WoundRollProblem, x: Array, growth: Growth, solved: Solved
) -> WoundRollResult:
    """Return the result of a roll wound so far, what changes the finished roll put in.

    Parameters
    ----------
    problem : WoundRollProblem
    x : (M,) array
        ln r of the nodes.
    growth : Growth
    solved : Solved
        As wound.
    """
    equations, curve, stack = equations_of(problem), problem.tension_curve, problem.stack
    r, T = np.exp(x), curve.at(np.exp(x))
    r[0], r[-1] = problem.core.radius, problem.radius
    more, at_core = changes(problem)
    source = shifted(cell_source(curve, growth, x), more)
    again = equations.solve(x, source, float(T[0]) + at_core, solved.P, solved.Q)
    if again is None:
        raise NotConverged("the finished roll's changes leave it without a solution")
    P, Q, E_t = again.P, again.Q, stack.tangential
    hoop = -(P + Q)
    strain = (hoop + stack.poissons_ratio * P) / E_t
    strain = strain + problem.tangential_expansion * problem.temperature_change
    return WoundRollResult(
        problem=problem,
        radius=r,
        pressure=P,
        hoop_stress=hoop,
        displacement=r * (strain - T / E_t),
        lap_strain=strain,
        radial_modulus=stack.radial.modulus(P),
        source=np.append(source.left, source.right[-1]),
        pressure_gradient=Q,
        stage_radius=np.exp(growth.x),
        growth=growth.kappa,
        stage_order=growth.through,
        surface_slope=float(-solved.Q[-1] / T[-1] - 1),
        steps=equations.steps,
        residuals=Residuals(),
    )  # fmt: skip


def _changes(before: WoundRollResult, now: WoundRollResult) -> dict[str, float]:
    """Return by what more stages and nodes change what errors are told of [Pa]."""
    x = np.linspace(np.log(now.radius[0]), np.log(now.radius[-1]), COMPARED)
    (P0, Q0), (P1, Q1) = (
        pressure_between(np.log(r.radius), r.pressure, r.pressure_gradient, x)
        for r in (before, now)
    )
    changes = (
        float(np.max(np.abs(P1 - P0))),
        abs(now.core_pressure - before.core_pressure),
        abs(now.mid_pressure - before.mid_pressure),
        float(np.max(np.abs(P1 + Q1 - P0 - Q0))),
    )
    return dict(zip(TOLD, changes, strict=True))


def _told_errors(now: WoundRollResult, changed: Mapping[str, float]) -> dict[str, float]:
    """Estimate errors from the changes, and that of the pressure from the surface's slope too.

    The slope there is free of the source, so its miss tells what the stages leave.
    """
    T = float(now.problem.tension_curve.at(now.radius[-1:])[0])
    errors = {name: LEFT * by for name, by in changed.items()}
    errors["peak_pressure"] += abs(now.surface_slope) * layer_of(now.problem) * T
    return errors


def _admissible(result: WoundRollResult) -> WoundRollResult:
    """Return the result, if the laps press each other, within the stack's law."""
    limit, loosest = result.problem.stack.limit, int(np.argmin(result.pressure))
    if result.pressure[loosest] < -ROUNDING * result.peak_pressure:
        raise NotConverged(
            f"the laps come apart at the radius {result.radius[loosest]:.6g} m: nothing holds them "
            "where the finished roll's changes take all pressure away", result
        )  # fmt: skip
    if result.peak_pressure >= limit:
        raise NotConverged(
            f"the pressure reaches {result.peak_pressure:.4g} Pa, beyond the stack's law, which "
            f"holds below {limit:.4g} Pa; less tension, or a law that reaches farther", result
        )  # fmt: skip
    return result
