"""A wound roll at radii between its nodes, and at earlier stages of its build-up.

A stage is the roll while it is wound, with a smaller surface radius.  Its pressure is recomputed
with kappa, the growth of a further layer's pressure below the surface, which the result contains
as a function of the surface radius (:mod:`.build_up`).
"""

from __future__ import annotations

from math import inf
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..errors import InvalidProblem, NotConverged
from ..problems.messages import quote
from ..problems.permitted import is_within
from ..problems.roll import FEWEST_LAYERS, RollProblem
from ..problems.schedules import Profile, Taper
from .equations import StageData, StageSolution, interpolate_pressure
from .finished import equations_of, finished_arrays, surface_layer_depth
from .growth import Growth
from .stage_nodes import cell_source, kinks_of, nodes_between

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

__all__ = ["Stage", "stage_arrays", "stage_at", "stresses_between"]

Array = np.ndarray
FEWEST_CELLS = 23


class Stage(NamedTuple):
    """The pressure of a roll at a stage of its build-up, on which a nip runs.

    Attributes
    ----------
    radius, pressure, gradient : (n + 1,) arrays
        Nodes [m], P and r P' there [Pa].
    tension : float
        Wound-on tension of the outermost layer [N/m].
    """

    radius: Array
    pressure: Array
    gradient: Array
    tension: float

    def pressure_at(self, r: Array) -> Array:
        """Return P at radii [Pa]."""
        return interpolate_pressure(np.log(self.radius), self.pressure, self.gradient, np.log(r))[0]


def stresses_between(result: Any, radius: ArrayLike) -> dict[str, Any]:
    """Return ``pressure`` and ``hoop_stress`` [Pa] at radii [m], with the shape of ``radius``.

    P and Q = r dP/dr are interpolated between the nodes; the hoop stress is -(P + Q).
    """
    r = _radii_on_roll(result, radius)
    x = np.log(result.radius)
    P, Q = interpolate_pressure(x, result.pressure, result.pressure_gradient, np.log(r))
    return {"pressure": P[()], "hoop_stress": (-(P + Q))[()]}


def stage_arrays(result: Any, radius: float) -> dict[str, Any]:
    """Return problem and arrays of the result of a stage; see :meth:`RollResult.at`.

    Parameters
    ----------
    result : RollResult
    radius : float
        Of the roll's surface at this stage [m].

    Returns
    -------
    dict
        Fields of :class:`~woundon.RollResult` by name.

    Raises
    ------
    InvalidProblem
        For a radius outside the roll, or of fewer than ten layers.
    """
    r = _radii_on_roll(result, radius)
    if r.ndim:  # several radii
        raise InvalidProblem.at("radius", f"{r.size} values; must be one radius [m]")
    surface, problem = float(r), result.problem
    smallest = problem.core.radius + FEWEST_LAYERS * problem.web_thickness
    if not is_within(surface, smallest, inf):
        text = f"{quote(surface)} is out of range; must be >= {smallest:.6g} [m]"
        raise InvalidProblem.at("radius", f"{text}, {FEWEST_LAYERS} layers")
    stage = _solve_stage(result, surface, result.radius.size - 1)
    arrays = finished_arrays(stage.problem, stage.x, stage.growth, stage.solved)
    layer_growth = result.layer_kappa.truncate(stage.growth.x[-1]).kappa
    return {**arrays, "problem": stage.problem, "layer_growth": layer_growth}


def stage_at(result: Any, radius: float) -> Stage:
    """Return the pressure at a stage of the build-up, without residuals and error estimates.

    Parameters
    ----------
    result : RollResult
    radius : float
        Of the roll's surface at this stage, ten layers or more above the core [m].
    """
    T = float(result.problem.tension_curve.at(np.array([radius]))[0])
    tension = T * float(result.problem.web_thickness)
    if radius == result.problem.radius:
        return Stage(result.radius, result.pressure, result.pressure_gradient, tension)
    # kinks of the tension are additional nodes
    cells = max(result.radius.size - 1 - result.problem.tension_curve.kinks.size, FEWEST_CELLS)
    stage = _solve_stage(result, radius, cells)
    r = np.exp(stage.x)
    r[0], r[-1] = result.problem.core.radius, radius  # without rounding
    return Stage(r, stage.solved.P, stage.solved.Q, tension)


def _radii_on_roll(result: Any, radius: ArrayLike) -> Array:
    """Return radii [m] as an array; those outside the roll by a rounding error are set to its ends.

    A single number gives an array without dimensions.

    Raises
    ------
    InvalidProblem
        For a radius outside the roll.
    """
    try:
        r = np.asarray(radius, dtype=float)
    except (TypeError, ValueError):
        text = f"{quote(radius)} is not a number; must be a radius on the roll [m]"
        raise InvalidProblem.at("radius", text) from None
    core, surface = float(result.radius[0]), float(result.radius[-1])
    outside = r[~is_within(r, core, surface)]
    if outside.size:
        must = f"must be >= {core:.6g} and <= {surface:.6g} [m], on the roll"
        text = f"{quote(float(outside.flat[0]))} is out of range; {must}"
        raise InvalidProblem.at("radius", text)
    return np.clip(r, core, surface)


class _SolvedStage(NamedTuple):
    """A stage of the build-up, solved again.

    Attributes
    ----------
    problem : RollProblem
        The roll with the radius of the stage, as wound.
    x : (n + 1,) array
        ln r of the nodes.
    growth : Growth
        Kappa, the growth of a layer's pressure below the surface, up to this stage.
    solved : StageSolution
        P and Q = r dP/dr at the nodes [Pa].
    """

    problem: RollProblem
    x: Array
    growth: Growth
    solved: StageSolution


def _solve_stage(result: Any, surface: float, cells: int) -> _SolvedStage:
    """Solve a stage of a result again, with the kappa of the result.

    Parameters
    ----------
    result : RollResult
    surface : float
        Radius of the roll at this stage [m].
    cells : int
        Approximate number of cells without those at kinks of the tension.
    """
    problem, core, x = result.problem, result.problem.core.radius, float(np.log(surface))
    growth = result.kappa.truncate(x)
    stage = problem.replace(
        radius=surface,
        wound_on_tension=_schedule_until(problem, surface),
        # the changes after winding do not apply to a stage
        temperature_change=0.0,
        core_shrinkage=0.0,
    )
    curve, equations = stage.tension_curve, equations_of(stage)
    kinks, depth = kinks_of(curve, growth), surface_layer_depth(problem)
    nodes = nodes_between(float(np.log(core)), x, cells, depth, *kinks, equations.core_layer)
    T_c = float(curve.at(np.array([core]))[0])
    # of P and r P': zero at the surface, with the slope of the tension at the core
    guess = T_c * (x - nodes), np.full_like(nodes, -T_c)
    solved = equations.solve(StageData(nodes, cell_source(curve, growth, nodes), T_c), *guess)
    if solved is None:
        raise NotConverged(f"the stage at the radius {surface:.6g} m could not be solved")
    return _SolvedStage(stage, nodes, growth, solved)


def _schedule_until(problem: RollProblem, surface: float) -> float | Profile | Taper:
    """Return the wound-on tension of a roll that ends at the radius ``surface`` [m].

    A linear taper refers to the radius R of the finished roll.  The same tension up to the radius s
    has this taper times (s - r_c)/(R - r_c).  Other schedules do not depend on R.
    """
    schedule, core = problem.wound_on_tension, problem.core.radius
    if not isinstance(schedule, Taper) or schedule.law != "linear":
        return schedule
    fraction = (surface - core) / (problem.radius - core)
    return schedule.replace(taper=schedule.taper * fraction)
