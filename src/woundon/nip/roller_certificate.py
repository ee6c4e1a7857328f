"""Contact conditions of two rollers, evaluated from the arrays of a result.

The residuals concern the discretised equations: the same influence functions are used to solve them
and to evaluate them, so an error of a kernel does not show here.  The power balance in
:func:`consistency` compares different quadratures and converges with the mesh.
"""

from __future__ import annotations

from math import inf, isfinite, isnan, log, nan

import numpy as np

from ..contact.newton import SemismoothNewton
from ..contact.refinement import MeshSolution
from ..results import Residuals, largest
from .conditions import (
    LARGEST_MESH,
    body_equilibrium,
    difference,
    friction_law,
    integral,
    negative_pressure,
)
from .energy import BodyWork, dissipation, pressure_resultant
from .roller_fields import RollerFields
from .rollers import RollerEquations, RollerState, work_on_rollers

__all__ = ["certificate", "consistency", "recomputed_solution", "state_of"]

Array = np.ndarray


def state_of(result: RollerFields) -> tuple[RollerEquations, RollerState] | None:
    """Return equations and state from the arrays of a result; None if the arrays are invalid."""
    a, size = result.half_width, result.x.size
    arrays = result.x, result.pressure, result.traction, result.slip_x, result.slip, result.zone
    if not 3 <= size <= LARGEST_MESH or not isfinite(a):
        return None
    if {array.shape for array in arrays} != {(size,)}:
        return None
    equations = RollerEquations(result.problem, size)
    if not a > 0 or log(a) > equations.largest_ln_a[0] + 1e-9:
        return None
    layout = equations.layout
    u = np.zeros(layout.size)
    u[layout.p] = result.pressure[1:-1]
    if result.problem.friction:
        u[layout.q] = result.traction[1:-1]
    u[layout.shift] = result.offset / result.problem.contact_radius
    u[layout.ln_a] = log(a)
    u[layout.xi] = 0.0 if equations.static else result.creepage
    return equations, equations.state(u, equations.geometry(a))


def certificate(result: RollerFields) -> Residuals:
    """Evaluate every contact condition of a result.

    Slopes and rolling slip are relative to the slope of the gap at the edge, static slip to that
    times a, forces to the load, pressures to the largest one.
    """
    recomputed = state_of(result)
    if recomputed is None:
        return Residuals(mesh=inf)
    equations, state = recomputed
    problem, a, p, q = result.problem, result.half_width, result.pressure, result.traction
    slope_scale, peak = a / problem.contact_radius, float(np.max(np.abs(p)))
    gap = state.equilibrium[: equations.drive_row] * equations.slope_scale
    Q, prescribed = integral(q, result.x), problem.tangential_load or 0.0
    if not equations.is_force_given and problem.friction:
        prescribed = result.tangential_load
    nodes, slip_points = a * equations.mesh.nodes, equations.slip_points(a)
    conditions = {
        "gap_slope": largest(np.abs(gap)) / slope_scale,
        "positive_pressure": negative_pressure(p) + largest(np.abs(p[[0, -1]])) / peak,
        **_slip_and_friction(result, equations, state, peak),
        "load": abs(integral(p, result.x) / problem.load - 1),
        "tangential_load": largest([abs(Q - prescribed), abs(Q - result.tangential_load)])
        / problem.load,
        "mesh": max(difference(result.x, nodes), difference(result.slip_x, slip_points)) / a,
        "approach": abs(result.approach / equations.approach(state) - 1),
    }
    surfaces = state.geometry.upper.surface, state.geometry.lower.surface
    conditions |= body_equilibrium(problem, surfaces, ((p, q), (p, -q)))
    if problem.viscoelastic:
        dissipated = dissipation(problem, work_on_rollers(state))
        deviation = abs(result.rolling_resistance - dissipated)
        conditions["rolling_resistance"] = deviation / (problem.load * slope_scale)
    elif not isnan(result.rolling_resistance):
        conditions["rolling_resistance"] = inf
    return Residuals(**conditions)


def _slip_and_friction(
    result: RollerFields, equations: RollerEquations, state: RollerState, peak: float
) -> dict[str, float]:
    """Return the residuals of slip, zones, creepage and the friction law."""
    problem, p, q, mu = result.problem, result.pressure, result.traction, result.problem.friction
    # xi is the creepage of rolling rollers, the relative displacement of static ones
    xi, unused = result.creepage, result.shift
    if equations.static:
        xi, unused = result.shift - equations.rigid_displacement(state, 0.0), result.creepage
    scale = result.half_width / problem.contact_radius
    scale *= result.half_width if equations.static else 1.0
    recomputed_xi, slip = equations.slip(state)
    slip = slip - recomputed_xi + xi  # with the xi of the result
    # a creepage that is not prescribed is, without friction, that of vanishing friction
    is_vanishing = not mu and problem.creepage is None
    prescribed = recomputed_xi if is_vanishing else problem.creepage
    ends, neighbours = [0, -1], [1, -2]
    zones_are_valid = (
        np.array_equal(result.zone[ends], result.zone[neighbours])
        and (np.abs(result.zone) <= 1).all()
    )
    unit = (mu or 1.0) * peak
    inner = slice(1, -1)
    zones, bound = result.zone[inner], mu * p[inner]
    conditions = {
        **friction_law(zones, q[inner], slip[inner], bound, unit=unit, slip_scale=scale),
        "zones": 0.0 if zones_are_valid else inf,
        "slip_velocity": largest(np.abs(result.slip - slip)) / scale,
        "creepage": 0.0 if prescribed is None else abs(xi - prescribed) / scale,
    }
    conditions["friction_bound"] += largest(np.abs(q[ends])) / unit
    if not isnan(unused):  # the creepage of static, the displacement of rolling rollers
        conditions["creepage"] = inf
    return conditions


def consistency(result: RollerFields) -> Residuals:
    """Return conditions that hold up to the discretisation error.

    power_balance
        Of rollers with a viscoelastic body, relative to P a/R* (:mod:`.energy`).
    """
    if not result.problem.viscoelastic:
        return Residuals()
    recomputed = state_of(result)
    if recomputed is None:
        return Residuals(power_balance=nan)
    _, state = recomputed
    return Residuals(power_balance=_power_balance(result, work_on_rollers(state)))


def _power_balance(result: RollerFields, bodies: tuple[BodyWork, BodyWork]) -> float:
    """Return the violation of the power balance of two rollers, relative to P a/R*.

    ``bodies`` is the work on the upper and on the lower roller.
    """
    problem, x, p, q = result.problem, result.x, result.pressure, result.traction
    h, R = np.diff(x), problem.contact_radius
    load, position = pressure_resultant(x, p)
    middle = result.slip_x[1:]
    fraction = (middle - x[:-1]) / h
    friction = float(h @ (((1 - fraction) * q[:-1] + fraction * q[1:]) * result.slip[1:]))
    supplied = load * (result.offset - position) / R + result.creepage * result.tangential_load
    supplied -= friction + sum(work.curvature_work for work in bodies)
    return abs(result.rolling_resistance - supplied) / (load * result.half_width / R)


def recomputed_solution(result: RollerFields) -> MeshSolution:
    """Return the solution on the last mesh from the arrays of a result."""
    recomputed = state_of(result)
    assert recomputed is not None  # a loaded result is verified
    equations, state = recomputed
    active, solver = result.zone[1:-1].astype(np.int8), SemismoothNewton(equations)
    return MeshSolution(result.nodes, equations, state, active, solver)
