"""From a solved mesh of a wrapped nip to its result, with its certificate."""

from __future__ import annotations

from collections.abc import Mapping
from math import nan
from typing import Any

import numpy as np

from ..contact.loop import Ladder, Level
from ..losses import lost
from ..nip.solve import most_beyond, slip_ratios, told_by
from ..nip.validity import nip_warnings
from ..problems.nip import WrappedNipProblem
from ..results import Residuals, measured
from .certificate import certificate, equations_of, roll_strain, surfaces_of, unknowns_of
from .equations import WrapEquations, WrapState
from .grid import WrapGrid
from .laws import Along
from .result import WrappedNipResult
from .scatter import rest_of_borders

__all__ = ["along_web", "creep", "ratios", "recomputed", "result_of"]

Array = np.ndarray

EXTRAPOLATED = {
    "extrapolation": "wound_on_tension",
    "extrapolation_behind": "tension_behind_nip",
    "extrapolation_of_nip": "nip_induced_tension",
}


def result_of(ladder: Ladder, problem: WrappedNipProblem) -> WrappedNipResult:
    """Return the result of the last mesh, its certificate measured on what it reports."""
    level = ladder.level
    equations, state = level.equations, level.state
    along = state.along
    if not problem.linear:
        equations = equations.anew(state)
        along = equations.laws.at(equations.unknowns(state), state.solution.traction)
    responses = [face.response for face in equations.laws.both if face.response]
    result = WrappedNipResult(
        problem=problem,
        half_width=state.half_width,
        approach=approach(equations, along, state.shift),
        offset=state.shift * problem.contact_radius,
        drum_creep=creep(equations, state),
        **ratios(level),
        **along_web(level),
        roll_strain=roll_strain(equations, along),
        **_extrapolated(level),
        residuals=Residuals(),
        iterations=ladder.solves,
        series_terms=max((r.terms for r in responses), default=0),
        series_error=max((r.truncation_error for r in responses), default=0.0),
        mesh=level.mesh,
        widths=ladder.widths,
        rolling_resistance=ladder.history[-1].get("rolling_resistance", nan),
    )
    return measured(
        result,
        errors=ladder.errors_of(result),
        residuals=certificate(result, equations),
        warnings=nip_warnings(result),
    )


def _extrapolated(level: Level) -> dict[str, Any]:
    """Return what tensions change by as borders come to rest, by the fields that tell it."""
    rest = rest_of_borders(level)
    return {field: rest[name] for field, name in EXTRAPOLATED.items() if name in rest}


def along_web(level: Level) -> dict[str, Any]:
    """Return what a solved mesh has along the web, by the names of the result, (N,) each."""
    found: dict[str, Any] | None = level.kept.get("along_web")
    if found is None:
        found = level.kept["along_web"] = _along_web(level)
    return found


def _along_web(level: Level) -> dict[str, Any]:
    equations, state, along = level.equations, level.state, level.state.along
    grid, a = equations.grid, state.half_width
    slip_x = a * np.append(grid.points[:1], grid.points)
    slip_x[grid.first] = slip_x[grid.first + 1]
    zones = _zones(equations, state.solution.state)
    return {
        "x": a * grid.nodes,
        "slip_x": slip_x,
        "pressure": along.drum_loads.pressure,
        "roll_pressure": along.roll_loads.pressure,
        "hoop_pressure": along.tension * along.bend * equations.weighs,
        "curvature": along.bend,
        "roll_traction": along.roll_loads.traction,
        "drum_traction": along.drum_loads.traction,
        "roll_slip": state.roll_slip,
        "drum_slip": state.drum_slip,
        "roll_zone": zones[0],
        "drum_zone": zones[1],
        "web_tension": along.tension,
    }


def ratios(level: Level) -> dict[str, Any]:
    """Return the slip ratios of a solved mesh, by name."""
    found: dict[str, Any] | None = level.kept.get("slip_ratios")
    if found is None:
        equations = level.equations
        own = _in_nip(along_web(level), equations.grid)
        found = level.kept["slip_ratios"] = slip_ratios(equations.problem, own)
    return found


def _in_nip(arrays: Mapping[str, Array], grid: WrapGrid) -> dict[str, Array]:
    return {name: values[grid.first : grid.last + 1] for name, values in arrays.items()}


def _zones(equations: WrapEquations, states: Array) -> Array:
    """Place the states of both faces along all nodes, (2, N+1); the ends copy their neighbours."""
    n_q, grid = equations.roll_q.size, equations.grid
    out = np.zeros((2, grid.size), dtype=states.dtype)
    out[0, equations.roll_q], out[1, equations.drum_q] = states[:n_q], states[n_q:]
    out[0, grid.first], out[0, -1] = out[0, grid.first + 1], out[0, -2]
    out[1, 0], out[1, grid.last] = out[1, 1], out[1, grid.last - 1]
    return out


def creep(equations: WrapEquations, state: WrapState) -> float:
    """Return xi-, unstrained web and drum as reference: the solved one is referred to T(end)."""
    web, thickness = equations.web, equations.problem.web.thickness
    return float(state.solution.creep - web.c11 / thickness * float(state.along.tension[-1]))


def approach(equations: WrapEquations, along: Along, shift: float) -> float:
    """Return the mutual approach, from the indentation at the trailing edge [m]."""
    problem, a, edge = equations.problem, equations.half_width, equations.grid.last
    laws = equations.laws
    v = laws.roll.sunk(*along.roll_loads) + laws.drum.sunk(*along.drum_loads)
    v += equations.web.c12 * along.tension[edge]
    v -= float(problem.web.thinned(along.roll_loads.pressure[edge:][:1])[0][0])
    return -float(v + shift * a - a**2 / (2 * problem.contact_radius))


def recomputed(result: WrappedNipResult) -> dict[str, tuple[float, float]]:
    """Return the scalars that no law tells, by name: as the arrays give them, how exactly."""
    equations, problem = equations_of(result), result.problem
    z, q, _ = unknowns_of(result, equations)
    along = equations.laws.at(z, q)
    indented = approach(equations, along, float(z[-1]))
    arrays = {name: value for name, value in vars(result).items() if isinstance(value, np.ndarray)}
    own = _in_nip(arrays, equations.grid)
    told = told_by(indented, slip_ratios(problem, own), own["x"])
    loads = (along.roll_loads, along.drum_loads)
    by_0_1 = sum(
        face.sunk(*load) - face.summed(*load)
        for face, load in zip(equations.laws.both, loads, strict=True)
    )
    told["approach"] = indented, told["approach"][1] + abs(by_0_1)
    told |= dict.fromkeys(EXTRAPOLATED, (0.0, most_beyond(result)))
    if problem.viscoelastic:
        resistance = lost(problem, surfaces_of(result, equations))
        told["rolling_resistance"] = resistance, 1e-7 * abs(resistance)
    return told
