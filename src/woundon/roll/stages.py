"""A wound roll at other radii than its nodes, and at other stages than the last."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..errors import InvalidProblem, NotConverged
from ..problems.messages import quote
from ..problems.roll import FEWEST_LAPS, RollProblem
from ..problems.schedules import Profile, Taper
from .build_up import cell_source, kinks_of, nodes_between
from .certificate import certificate, equations_of
from .equations import Solved, pressure_between
from .growth import Growth
from .result import RollResult
from .solve import finished, layer_of

__all__ = ["Stage", "at", "between", "wound_so_far"]

Array = np.ndarray
FEWEST_CELLS = 23


class Stage(NamedTuple):
    """A roll wound so far, as what is wound on it feels it.

    Attributes
    ----------
    radius, pressure, gradient : (n + 1,) arrays
        Nodes [m], P and r P' there [Pa].
    tension : float
        Wound-on tension of the last lap [N/m].
    """

    radius: Array
    pressure: Array
    gradient: Array
    tension: float

    def pressure_at(self, r: Array) -> Array:
        """Return P at radii [Pa]."""
        return pressure_between(np.log(self.radius), self.pressure, self.gradient, np.log(r))[0]


def _inside(result: RollResult, radius: Any) -> np.ndarray:
    try:
        r = np.asarray(radius, dtype=float)
    except (TypeError, ValueError):
        text = f"{quote(radius)} is not a number; must be a radius on the roll [m]"
        raise InvalidProblem.at("radius", text) from None
    core, surface = float(result.radius[0]), float(result.radius[-1])
    slack = 1e-12 * surface
    wrong = r[~((core - slack <= r) & (r <= surface + slack))]
    if wrong.size:
        raise InvalidProblem.at(
            "radius",
            f"{quote(float(wrong.flat[0]))} is out of range; must be >= {core:.6g} and <= "
            f"{surface:.6g} [m], on the roll",
        )
    return np.clip(r, core, surface)


def between(result: RollResult, radius: Any) -> dict[str, Any]:
    """Return pressure and hoop stress at radii [m]; see :meth:`RollResult.at_radius`."""
    r = _inside(result, radius)
    x = np.log(result.radius)
    P, Q = pressure_between(x, result.pressure, result.pressure_gradient, np.log(r))
    return {"pressure": P[()], "hoop_stress": (-(P + Q))[()]}


def at(result: RollResult, radius: float) -> RollResult:
    """Return a stage of the build-up; see :meth:`RollResult.at`."""
    place = _inside(result, radius)
    if place.ndim:
        raise InvalidProblem.at("radius", f"{place.size} values; must be one radius [m]")
    surface, problem = float(place), result.problem
    least = problem.core.radius + FEWEST_LAPS * problem.web_thickness
    if surface < least:
        text = f"{quote(surface)} is out of range; must be >= {least:.6g} [m], {FEWEST_LAPS} laps"
        raise InvalidProblem.at("radius", text)
    stage, nodes, growth, solved = _laid(result, surface, result.radius.size - 1)
    laps = result.kappa_of_laps.until(growth.x[-1]).kappa
    found = finished(stage, nodes, growth, solved).replace(errors=result.errors, lap_growth=laps)
    return found.replace(residuals=certificate(found)).checked()


def wound_so_far(result: RollResult, radius: float) -> Stage:
    """Return a stage of the build-up by its pressure alone, without a certificate.

    Parameters
    ----------
    result : RollResult
    radius : float
        [m], of ten laps or more.
    """
    T = float(result.problem.tension_curve.at(np.array([radius]))[0])
    tension = T * float(result.problem.web_thickness)
    if radius == result.problem.radius:
        return Stage(result.radius, result.pressure, result.pressure_gradient, tension)
    # kinks are nodes of their own
    cells = max(result.radius.size - 1 - result.problem.tension_curve.kinks.size, FEWEST_CELLS)
    _, nodes, _, solved = _laid(result, radius, cells)
    r = np.exp(nodes)
    r[0], r[-1] = result.problem.core.radius, radius
    return Stage(r, solved.P, solved.Q, tension)


def _laid(
    result: RollResult, surface: float, cells: int
) -> tuple[RollProblem, Array, Growth, Solved]:
    """Return the problem of a stage, its nodes, kappa up to it, and its pressure."""
    problem, core, x = result.problem, result.problem.core.radius, float(np.log(surface))
    growth = result.kappa.until(x)
    # as it was wound: what changes the finished roll comes later
    stage = problem.replace(
        radius=surface, wound_on_tension=_until(problem, surface),
        temperature_change=0.0, core_shrinkage=0.0,
    )  # fmt: skip
    curve, equations = stage.tension_curve, equations_of(stage)
    nodes = nodes_between(
        float(np.log(core)), x, cells, layer_of(problem), *kinks_of(curve, growth)
    )
    T_c = float(curve.at(np.array([core]))[0])
    guess = T_c * (x - nodes), np.full_like(nodes, -T_c)
    solved = equations.solve(nodes, cell_source(curve, growth, nodes), T_c, *guess)
    if solved is None:
        raise NotConverged(f"the stage at the radius {surface:.6g} m could not be solved")
    return stage, nodes, growth, solved


def _until(problem: RollProblem, surface: float) -> float | Profile | Taper:
    """Return the tension's schedule as it is up to a radius: a linear taper falls by its share."""
    schedule, core = problem.wound_on_tension, problem.core.radius
    if not isinstance(schedule, Taper) or schedule.law != "linear":
        return schedule
    share = (surface - core) / (problem.radius - core)
    return schedule.replace(taper=schedule.taper * share)
