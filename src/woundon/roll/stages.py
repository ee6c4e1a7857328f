"""A wound roll at radii between its nodes, and at earlier stages of its build-up.

A stage is the roll while it is wound, with a smaller surface radius.  Its pressure is recomputed
with kappa, the growth of a further layer's pressure below the surface, which the result contains
as a function of the surface radius (:mod:`.build_up`).
"""

from __future__ import annotations

from collections.abc import Sequence
from math import inf
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..errors import InvalidProblem, NotConverged
from ..problems.finished_roll import UNCHANGED
from ..problems.messages import quote
from ..problems.permitted import is_within
from ..problems.radii import radii_on_roll
from ..problems.roll import FEWEST_LAYERS, RollProblem
from ..problems.schedules import AnySchedule, Steps, Taper
from .build_up import Layers
from .equations import (
    StageData,
    StageSolution,
    interpolate_pressure,
    joined,
    stretched,
)
from .finished import (
    FEWEST_CELLS,
    finished_arrays,
    layers_of,
    middle_of_layers,
    surface_layer_depth,
)
from .roll_fields import RollFields
from .stage_nodes import cell_source, kinks_of, nodes_between, radii_of_nodes

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

__all__ = ["Stage", "stage_arrays", "stages_at", "stresses_between", "wound_stage"]

Array = np.ndarray


class Stage(NamedTuple):
    """The pressure of a roll at a stage of its build-up, on which a nip runs.

    Attributes
    ----------
    radius, pressure, gradient : (n + 1,) arrays
        Nodes [m], P and r P' there [Pa].
    thickness : float
        Of the web [m].
    tension : float
        Wound-on tension of the outermost layer [N/m].
    centrifugal : float
        rho V^2 of a running roll [Pa]; zero at rest.
    """

    radius: Array
    pressure: Array
    gradient: Array
    thickness: float
    tension: float
    centrifugal: float = 0.0

    @property
    def centrifugal_tension(self) -> float:
        """m V^2 of a running roll [N/m]; zero at rest."""
        return self.centrifugal * self.thickness

    def stresses_at(self, r: Array) -> tuple[Array, Array]:
        """Return P and the hoop stress -(P + r P') + c r^2/s^2 of the layers at radii [Pa]."""
        arrays = np.log(self.radius), self.pressure, self.gradient
        pressure, _ = interpolate_pressure(*arrays, np.log(r))
        middle = middle_of_layers(r, self.radius, self.thickness)
        P, Q = interpolate_pressure(*arrays, np.log(middle))
        rotation = self.centrifugal * turn_of(self.radius[-1], self.thickness)
        return pressure, rotation * (middle / self.radius[-1]) ** 2 - (P + Q)


def turn_of(surface: float | Array, thickness: float) -> Any:
    """Return the factor of B of finished rolls, (J,) radii [m] [1].

    The middle of the outermost layer has the web speed.
    """
    return (surface / (surface - thickness / 2)) ** 2


def stresses_between(
    result: RollFields, radius: ArrayLike, stage: Stage | None = None
) -> dict[str, Array]:
    """Return ``pressure`` and ``hoop_stress`` [Pa] at radii [m], with the shape of ``radius``.

    They are those of the finished roll, or of the roll at a ``stage``.
    """
    r = radii_on_roll(radius, *result.radius[[0, -1]].tolist())
    P, hoop = (stage or finished_stage(result)).stresses_at(r)
    return {"pressure": P[()], "hoop_stress": hoop[()]}


def finished_stage(result: RollFields) -> Stage:
    """Return the finished roll, at rest, as a stage."""
    arrays = result.radius, result.pressure, result.pressure_gradient
    h = float(result.problem.web_thickness)
    return Stage(*arrays, h, float(result.problem.tension_curve.at(result.radius[-1:])[0]) * h)


def stage_arrays(result: RollFields, radius: float) -> dict[str, Any]:
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
    r = radii_on_roll(radius, *result.radius[[0, -1]].tolist())
    if r.ndim:  # several radii
        raise InvalidProblem.at("radius", f"{r.size} values; must be one radius [m]")
    surface, problem = float(r), result.problem
    smallest = problem.core.radius + FEWEST_LAYERS * problem.web_thickness
    if not is_within(surface, smallest, inf):
        text = f"{quote(surface)} is out of range; must be >= {smallest:.6g} [m]"
        raise InvalidProblem.at("radius", f"{text}, {FEWEST_LAYERS} layers")
    growth = result.kappa.truncate(float(np.log(surface)))
    cells = result.radius.size - 1
    x, solved = _solve_stages(result, layers_of(problem), [surface], cells, is_free=False)[0]
    stage = problem.replace(
        radius=surface,
        wound_on_tension=_schedule_until(problem, surface),
        # the changes after winding do not apply to a stage
        **UNCHANGED,
    )
    arrays = finished_arrays(stage, x, growth, solved)
    thin_growth = result.thin_layer_kappa.truncate(growth.x[-1]).kappa
    return {**arrays, "problem": stage, "thin_layer_growth": thin_growth}


def stages_at(
    result: RollFields,
    radii: Sequence[float],
    cells: int | None = None,
    *,
    at_rest: bool = False,
    as_wound: bool = False,
) -> list[Stage]:
    """Return the pressure at stages of the build-up, without residuals and error estimates.

    Parameters
    ----------
    result : RollResult
    radii : sequence of float
        Of the roll's surface at these stages, ten layers or more above the core [m].
    cells : int, optional
        Approximate number of cells without those at kinks of the tension; by default so many that
        there are about as many cells as in the result.
    at_rest : bool
        True for the roll stopped at these stages; by default it runs.
    as_wound : bool
        True for the whole roll before its changes after winding, as further layers or a nip meet
        it; by default the whole roll at rest is the finished one.
    """
    problem = result.problem
    curve, core, h = problem.tension_curve, problem.core.radius, float(problem.web_thickness)
    if cells is None:
        cells = max(result.radius.size - 1 - curve.kinks.size, FEWEST_CELLS)
    layers = layers_of(problem)
    if at_rest:
        layers = layers.at_rest
    c = layers.equations.centrifugal
    # the finished roll is at rest and changed
    differs = bool(c) or (as_wound and problem.is_changed)
    solved = sorted({radius for radius in radii if radius != problem.radius or differs})
    solutions = dict(zip(solved, _solve_stages(result, layers, solved, cells), strict=True))
    stages = []
    for radius, T in zip(radii, curve.at(np.array(radii)).tolist(), strict=True):
        if radius not in solutions:
            stages.append(finished_stage(result))
            continue
        x, solution = solutions[radius]
        r = radii_of_nodes(x, core, radius)
        stages.append(Stage(r, *layers.total(x, solution.P, solution.Q), h, T * h, c))
    return stages


def wound_stage(result: RollFields, *, at_rest: bool = False) -> Stage:
    """Return the roll as wound, before its changes after winding, at the nodes of the result.

    Parameters
    ----------
    result : RollResult
    at_rest : bool
        True for the stopped roll; by default it still runs.

    Raises
    ------
    NotConverged
        If no equilibrium exists.
    """
    problem, x = result.problem, np.log(result.radius)
    curve, layers = problem.tension_curve, layers_of(problem)
    if at_rest:
        layers = layers.at_rest
    T = curve.at(result.radius)
    own, source = layers.own(x), cell_source(curve, result.kappa, x)
    turn = turn_of(result.radius[-1], layers.thickness)
    surface_pressure = -layers.own_pressure(x[-1:])
    data = StageData(x, source, float(T[0]), surface_pressure, own=own, turn=turn)
    solved = layers.equations.solve(data, *_guess(result))
    if solved is None:
        raise NotConverged("the roll as wound could not be solved", result)
    h, c = float(problem.web_thickness), layers.equations.centrifugal
    arrays = layers.total(x, solved.P, solved.Q)
    return Stage(result.radius, *arrays, h, float(T[-1]) * h, c)


def _guess(result: RollFields) -> tuple[Array, Array]:
    """Return an initial guess of P and Q as wound, at the nodes of the result [Pa].

    It is the finished roll, whose changes after winding may separate layers.
    """
    layers, x = layers_of(result.problem), np.log(result.radius)
    return layers.additional(x, np.maximum(result.pressure, 0.0), result.pressure_gradient)


def _solve_stages(
    result: RollFields,
    layers: Layers,
    surfaces: Sequence[float],
    cells: int,
    *,
    is_free: bool = True,
) -> list[tuple[Array, StageSolution]]:
    """Solve stages of a result again, together, with the kappa of the result.

    Parameters
    ----------
    result : RollResult
    layers : Layers
        Of the roll, running or at rest.
    surfaces : sequence of float
        Radii of the roll at these stages [m].
    cells : int
        Approximate number of cells without those at kinks of the tension.
    is_free : bool
        True if nothing presses on the outermost layer, False while the next one is wound on it.

    Returns
    -------
    list of (x, solution)
        Nodes ln r of each stage, and P and Q = r dP/dr there [Pa].
    """
    if not surfaces:
        return []
    problem, growth = result.problem, result.kappa
    curve = problem.tension_curve
    depth, core_radius = surface_layer_depth(problem), problem.core.radius
    nodes = []
    for surface in np.log(surfaces).tolist():
        kinks = kinks_of(curve, growth, surface)
        ends = float(np.log(core_radius)), surface
        nodes.append(nodes_between(*ends, cells, depth, *kinks, layers.equations.core_layer))
    x, gaps = joined(nodes)
    T_c = float(curve.at(np.array([core_radius]))[0])
    finished = np.log(result.radius), *_guess(result)
    guesses = [stretched(*finished, of_stage) for of_stage in nodes]
    P, Q = (np.concatenate(parts) for parts in zip(*guesses, strict=True))
    stage = StageData(x, cell_source(curve, growth, x), T_c, gaps=gaps, own=layers.own(x))
    if is_free:
        stage.surface_pressure = -layers.own_pressure(np.log(surfaces))
        stage.turn = turn_of(np.array(surfaces), layers.thickness)
    solved = layers.equations.solve(stage, P, Q)
    if solved is None:
        radii = ", ".join(f"{surface:.6g}" for surface in surfaces)
        raise NotConverged(f"the stages at the radii {radii} m could not be solved")
    return list(zip(nodes, solved.parts(gaps), strict=True))


def _schedule_until(problem: RollProblem, surface: float) -> AnySchedule:
    """Return the wound-on tension of a roll that ends at the radius ``surface`` [m].

    A linear taper refers to the radius R of the finished roll.  The same tension up to the radius s
    has this taper times (s - r_c)/(R - r_c).  Other schedules do not depend on R; steps may begin
    beyond s.
    """
    schedule, core = problem.wound_on_tension, problem.core.radius
    if isinstance(schedule, Steps):
        return schedule.profile(core, problem.radius)
    if not isinstance(schedule, Taper) or schedule.law != "linear":
        return schedule
    fraction = (surface - core) / (problem.radius - core)
    return schedule.replace(taper=schedule.taper * fraction)
