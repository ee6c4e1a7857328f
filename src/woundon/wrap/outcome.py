"""From solved equations of a wrapped nip to its result."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..assembly import contact_radius
from ..contact.certificate import certify
from ..outcome import slip_ratios
from ..validity import nip_warnings
from .equations import WrapEquations, WrapState
from .result import WrappedNipResult, WrappedResiduals

__all__ = ["wrapped_result"]

Array = np.ndarray


def wrapped_result(
    equations: WrapEquations, state: WrapState, angles: tuple[float, float], error: float
) -> WrappedNipResult:
    """Return the result of a solved wrapped nip.

    Parameters
    ----------
    equations, state : WrapEquations, WrapState
    angles : (float, float)
        Wrap on roll and on drum [rad].
    error : float
        Estimated error of the wound-on tension [N/m].
    """
    grid, T, a, problem = equations.grid, state.tension, state.half_width, equations.problem
    x = a * grid.nodes
    slip_x = a * np.append(grid.points[:1], grid.points)
    slip_x[grid.first] = slip_x[grid.first + 1]
    zones = _zones(equations, state.solution.state)
    nip, inside = slice(grid.first, grid.last + 1), slice(grid.first + 1, grid.last)
    surfaces = [body.surface(2 * a) for body in (problem.roll, problem.drum)]
    result = WrappedNipResult(
        problem=problem,
        roll_wrap=angles[0],
        drum_wrap=angles[1],
        wrap_friction=equations.loads.friction,
        winding_force=equations.loads.force,
        wound_on_tension=float(T[-1]),
        wound_on_tension_error=error,
        tension_before_nip=float(T[grid.first]),
        tension_behind_nip=float(T[grid.last]),
        roll_wrap_traction=float(T[-1] - T[grid.last]),
        drum_wrap_traction=float(T[grid.first] - T[0]),
        slip_angle=_slip_angle(equations, zones[0]),
        half_width=a,
        approach=_approach(equations, state),
        offset=state.shift * contact_radius(problem),
        drum_creep=_creep(equations, state),
        x=x,
        slip_x=slip_x,
        pressure=state.drum_pressure,
        roll_pressure=state.roll_pressure,
        hoop_pressure=T * state.bend * equations.weighs,
        curvature=state.bend,
        roll_traction=state.roll_traction,
        drum_traction=state.drum_traction,
        roll_slip=state.roll_slip,
        drum_slip=state.drum_slip,
        roll_strain=_roll_strain(equations, state),
        roll_zone=zones[0],
        drum_zone=zones[1],
        web_tension=T,
        slip_ratios=slip_ratios(x[nip], zones[0, inside], zones[1, inside]),
        residuals=_residuals(equations, state),
        iterations=state.solution.solves,
        series_terms=max(s.terms for s in surfaces),
        series_error=max(s.truncation_error for s in surfaces),
    )
    return replace(result, warnings=nip_warnings(result.nip))


def _roll_strain(equations: WrapEquations, state: WrapState) -> Array:
    """Return the roll's surface strain in the cell before each node, (N+1,); nan before the nip."""
    first, face = equations.grid.first, equations.roll
    strain = (
        face.strain_p @ state.roll_pressure[first:] + face.strain_q @ state.roll_traction[first:]
    )
    out = np.full(equations.grid.size, np.nan)
    out[first], out[first + 1 :] = strain[0], strain[:-1]
    return out


def _creep(equations: WrapEquations, state: WrapState) -> float:
    """Return xi-, unstrained web and drum as reference: the solved one is referred to T(end)."""
    web, thickness = equations.web, equations.problem.web.thickness
    return state.solution.creep - web.c11 / thickness * float(state.tension[-1])


def _zones(equations: WrapEquations, states: Array) -> Array:
    """Place the states of both faces along all nodes, (2, N+1); the ends copy their neighbours."""
    n_q, grid = equations.roll_q.size, equations.grid
    out = np.zeros((2, grid.size), dtype=states.dtype)
    out[0, equations.roll_q], out[1, equations.drum_q] = states[:n_q], states[n_q:]
    out[0, grid.first], out[0, -1] = out[0, grid.first + 1], out[0, -2]
    out[1, 0], out[1, grid.last] = out[1, 1], out[1, grid.last - 1]
    return out


def _slip_angle(equations: WrapEquations, roll_zones: Array) -> float:
    """Return over which angle the web slips on the roll just behind the nip [rad]."""
    grid, behind = equations.grid, roll_zones[equations.grid.last :]
    if behind[0] == 0 or not equations.loads.roll_arc:
        return 0.0
    other = np.nonzero(behind != behind[0])[0]
    x = grid.nodes[grid.last :]
    border = (x[other[0]] + x[other[0] - 1]) / 2 if other.size else x[-1]
    return float((border - 1) * equations.half_width / equations.problem.roll.radius)


def _approach(equations: WrapEquations, state: WrapState) -> float:
    """Return the mutual approach, from the indentation at the trailing edge [m]."""
    problem, a, web, grid = equations.problem, state.half_width, equations.web, equations.grid
    v = web.c12 * state.tension[grid.last]
    v -= problem.web.thickness * web.c22 * state.roll_pressure[grid.last]
    roll, drum = slice(grid.first, None), slice(0, grid.last + 1)
    for face, own, p, q in (
        (equations.roll, roll, state.roll_pressure, state.roll_traction),
        (equations.drum, drum, state.drum_pressure, state.drum_traction),
    ):
        v += face.normal_p @ p[own] + face.normal_q @ q[own]
    return -float(v + state.shift * a - a**2 / (2 * contact_radius(problem)))


def _residuals(equations: WrapEquations, state: WrapState) -> WrappedResiduals:
    """Measure every law anew from the assembled equations."""
    problem, grid, q = equations.problem, equations.grid, state.solution.traction
    gap, by_z, by_q = equations.indentation()
    top, z = float(np.max(gap)), equations.unknowns(state)
    laws = certify(equations.stick_slip(), state.solution, slip_scale=top)
    x, P = state.half_width * grid.nodes, problem.nip_load
    whole = float(np.trapezoid(state.roll_traction + state.drum_traction, x))
    force = float(np.trapezoid(state.drum_traction, x)) - equations.loads.force
    pressures = np.concatenate([state.roll_pressure, state.drum_pressure])
    return WrappedResiduals(
        indentation=float(np.max(np.abs(by_z @ z + by_q @ q - gap))) / top,
        positive_pressure=max(0.0, -float(np.min(pressures)) / float(np.max(pressures))),
        stick=laws.stick,
        friction_bound=laws.friction_bound,
        slip_traction=laws.slip_traction,
        slip_direction=laws.slip_direction,
        load_equilibrium=abs(equations.nip_load(state) / P - 1),
        force_equilibrium=abs(force) / P,
        web_equilibrium=abs(float(state.tension[-1]) - problem.web_tension - whole) / P,
        hoop_pressure=equations.imbalance(state),
    )
