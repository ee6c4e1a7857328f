"""Contact conditions of two rollers, evaluated from the arrays of a result.

The residuals concern the discretised equations: the same influence functions are used to solve them
and to evaluate them, so an error of a kernel does not show here.  The power balance in
:func:`consistency` compares different quadratures and converges with the mesh.
"""

from __future__ import annotations

from math import inf, isfinite, isnan, log, nan
from typing import Any

import numpy as np

from ..contact.newton import SemismoothNewton
from ..contact.refinement import MeshSolution
from ..results import Residuals, largest
from .conditions import body_equilibrium, friction_law, integral, negative_pressure
from .roller_energy import dissipation, roller_power_balance, surface_work
from .rollers import RollerEquations, RollerState

__all__ = ["certificate", "consistency", "solutions", "state_of"]

Array = np.ndarray


def state_of(result: Any) -> tuple[RollerEquations, RollerState] | None:
    """Return equations and state from the arrays of a result; None if the arrays are invalid."""
    a, size = result.half_width, result.x.size
    arrays = result.x, result.pressure, result.traction, result.slip_x, result.slip, result.zone
    if size < 3 or {array.shape for array in arrays} != {(size,)} or not isfinite(a):
        return None
    equations = RollerEquations(result.problem, size)
    if not a > 0 or log(a) > equations.largest_ln_a + 1e-9:
        return None
    u = np.zeros(equations.q.stop)
    u[equations.p] = result.pressure[1:-1]
    if result.problem.friction:
        u[equations.q] = result.traction[1:-1]
    u[equations.shift] = result.offset / result.problem.contact_radius
    u[equations.ln_a] = log(a)
    u[equations.xi] = 0.0 if equations.static else result.creepage
    return equations, equations.evaluate(u, equations.surfaces(a))


def certificate(result: Any) -> Residuals:
    """Evaluate every contact condition of a result.

    Slopes and rolling slip are relative to the slope of the gap at the edge, static slip to that
    times a, forces to the load, pressures to the largest one.
    """
    found = state_of(result)
    if found is None:
        return Residuals(mesh=inf)
    equations, state = found
    problem, a, p, q = result.problem, result.half_width, result.pressure, result.traction
    edge = a / problem.contact_radius
    unit = edge * (a if equations.static else 1.0)
    xi, other = result.creepage, result.shift
    if equations.static:
        xi, other = result.shift - equations.rigid_displacement(state, 0.0), result.creepage
    free, slip = equations.slip(state)
    # without friction the creepage that is not given is that of vanishing friction
    loose = not problem.friction and problem.creepage is None
    slip = slip - (free if loose else state.u[equations.xi]) + xi
    given = free if loose else problem.creepage
    peak = float(np.max(np.abs(p)))
    friction = friction_law(
        result.zone[1:-1],
        q[1:-1],
        slip[1:-1],
        problem.friction * p[1:-1],
        unit=np.full(p.size - 2, (problem.friction or 1.0) * peak),
        slip_scale=unit,
    )
    ends = [[0, -1], [1, -2]]
    same_zone = np.array_equal(result.zone[ends[0]], result.zone[ends[1]])
    Q, asked = integral(q, result.x), problem.tangential_load or 0.0
    if not equations.is_force_given and problem.friction:
        asked = result.tangential_load
    gap = state.equilibrium[: equations.drive_row] * equations.slope_scale
    approach = equations.approach(state)
    conditions = {
        "gap_slope": largest(np.abs(gap)) / edge,
        "positive_pressure": negative_pressure(p) + largest(np.abs(p[ends[0]])) / peak,
        **friction,
        "zones": 0.0 if same_zone and (np.abs(result.zone) <= 1).all() else inf,
        "slip_velocity": largest(np.abs(result.slip - slip)) / unit,
        "load": abs(integral(p, result.x) / problem.load - 1),
        "tangential_load": largest([abs(Q - asked), abs(Q - result.tangential_load)])
        / problem.load,
        "creepage": 0.0 if given is None else abs(xi - given) / unit,
        "mesh": _mesh_difference(result, equations),
        "approach": abs(result.approach / approach - 1),
    }
    conditions["friction_bound"] += largest(np.abs(q[ends[0]])) / ((problem.friction or 1) * peak)
    if not isnan(other):  # the creepage of static, the rigid displacement of rolling rollers
        conditions["creepage"] = inf
    surfaces = state.surfaces.upper, state.surfaces.lower
    conditions |= body_equilibrium(problem, surfaces, ((p, q), (p, -q)))
    if problem.viscoelastic:
        lost = dissipation(problem, surface_work(problem, equations.mesh, state))
        size = problem.load * edge
        conditions["rolling_resistance"] = abs(result.rolling_resistance - lost) / size
    elif not isnan(result.rolling_resistance):
        conditions["rolling_resistance"] = inf
    return Residuals(**conditions)


def _mesh_difference(result: Any, equations: RollerEquations) -> float:
    a = result.half_width
    nodes = np.abs(result.x - a * equations.mesh.nodes)
    points = np.abs(result.slip_x - equations.slip_points(a))
    return largest(np.append(nodes, points)) / a


def consistency(result: Any) -> Residuals:
    """Return conditions that hold up to the discretisation error.

    power_balance
        Of rollers with a viscoelastic body, relative to P a/R* (:mod:`.energy`).
    """
    found = state_of(result) if result.problem.viscoelastic else None
    if not result.problem.viscoelastic:
        return Residuals()
    if found is None:
        return Residuals(power_balance=nan)
    equations, state = found
    bodies = surface_work(result.problem, equations.mesh, state)
    return Residuals(power_balance=roller_power_balance(result, bodies))


def solutions(result: Any) -> list[MeshSolution]:
    """Return the solutions on all meshes of a result; for a loaded result only on the last."""
    if result.refinement is not None:
        meshes: list[MeshSolution] = result.refinement.meshes
        return meshes
    found = state_of(result)
    assert found is not None  # a loaded result is verified
    equations, state = found
    solver = SemismoothNewton(equations)
    return [MeshSolution(result.nodes, equations, state, result.zone[1:-1].astype(np.int8), solver)]
