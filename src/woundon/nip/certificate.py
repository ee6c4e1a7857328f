"""The certificate of a nip: contact conditions evaluated from the arrays of a result.

``residuals`` concern the discretised equations: pressures, tractions, slips and scalars of the
result are put into the equations of its mesh.  They do not detect an error of an influence
function, because both sides use the same matrices.  ``consistency`` does: the balance of power and
equilibrium by another quadrature hold for the continuous fields, and their defects vary as the
discretisation error.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import inf, isnan
from typing import TYPE_CHECKING, Any

import numpy as np

from ..contact.newton import SemismoothNewton
from ..contact.refinement import MeshSolution, error_estimate
from ..errors import RESOLUTION
from ..results import ACCEPTED_RESIDUAL, Residuals, largest
from .conditions import body_equilibrium, difference, friction_law, negative_pressure
from .energy import power_balance, rolling_resistance
from .entrained_air import air_conditions
from .outputs import (
    ROUNDING,
    SLIP_RATIOS,
    NipSystem,
    approach,
    roll_wound_on_tension,
    slip_ratios,
    strain_rounding,
    web_arrays,
)

if TYPE_CHECKING:
    from .equations import Fields, NipEquations, NipState

__all__ = [
    "certificate",
    "consistency",
    "consistency_defects",
    "equations_of",
    "inconsistencies",
    "recomputed",
    "solutions",
    "state_of",
]

Array = np.ndarray

# A defect is reported if it exceeds INCONSISTENT times its error estimate and MIN_REDUCTION times
# the largest defect on coarser meshes, because an estimate may be small by chance.
INCONSISTENT, MIN_REDUCTION = 3.0, 0.3


def equations_of(result: Any) -> NipEquations:
    """Return the equations on the mesh of a result."""
    return NipSystem(result.without_air, result.nodes)


def state_of(result: Any, equations: NipEquations) -> NipState:
    """Return the state of the unknowns that a result reports.

    Raises
    ------
    ValueError
        If the number of nodes is not that of the mesh.
    """
    at, web, problem = equations.layout, result.problem.web, equations.problem
    if result.x.size != at.end + 1:
        raise ValueError(f"{result.x.size} nodes; the mesh of this nip has {at.end + 1}")
    u = np.empty(at.size)
    u[at.drum_p] = result.drum_pressure[at.p_nodes[at.drum_p]]
    u[at.wrap_p] = result.roll_pressure[at.p_nodes[at.wrap_p]]
    u[at.shift] = result.offset / problem.contact_radius
    # the creepage of the equations refers to the web's strain at the end
    u[at.xi] = result.drum_creepage + web.compliance.c11 / web.thickness * result.tension[-1]
    u[at.ln_a] = np.log(result.half_width)
    u[at.roll_q], u[at.drum_q] = (
        result.roll_traction[at.roll_nodes],
        result.drum_traction[at.drum_nodes],
    )
    return equations.evaluate(u)


def certificate(result: Any, equations: NipEquations) -> Residuals:
    """Return the largest violation of every contact condition, dimensionless.

    Parameters
    ----------
    result : NipResult
    equations : NipEquations
        Those of its mesh.
    """
    problem = equations.problem
    problem.web.check_pressure(float(result.drum_pressure.max()))
    try:
        state = state_of(result, equations)
    except ValueError:
        return Residuals(mesh=inf)
    at, f = equations.layout, state.fields
    zones = np.concatenate([result.roll_zone[at.roll_nodes], result.drum_zone[at.drum_nodes]])
    # the arrays of a result, recomputed from its unknowns
    implied = web_arrays(equations, state, zones.astype(np.int8))
    conditions = _equations_and_friction(result, equations, state, implied, zones)
    conditions |= _reported_arrays(result, equations, state, implied)
    conditions |= _wrap_conditions(result, equations, state, implied)
    conditions |= _surface_loads(result, f, implied)
    on_roll = f.p_roll[at.first :], f.q_roll[at.first :]
    on_drum = f.p_drum[: at.last + 1], f.q_drum[: at.last + 1]
    surfaces = f.geometry.roll.surface, f.geometry.drum.surface
    conditions |= body_equilibrium(problem, surfaces, (on_roll, on_drum))
    if result.air is not None:
        conditions |= air_conditions(result)
    return Residuals(**conditions)


Implied = Mapping[str, Array]


def _equations_and_friction(
    result: Any, equations: NipEquations, state: NipState, implied: Implied, zones: Array
) -> dict[str, float]:
    """Return the residuals of gap slope, resultants and friction law."""
    f, top, rounding = state.fields, equations.slope_scale, strain_rounding(equations, state)
    # gap over a cell instead of slope: on the short cells at the edges slopes have rounding errors
    cells = f.geometry.mesh.cells[f.geometry.mesh.nip_cells]
    gap = np.abs(state.equilibrium[: cells.size]) * cells / cells.max()
    slip = np.sign(state.slip) * np.maximum(np.abs(state.slip * top) - rounding, 0.0)
    unit = np.full(zones.size, float(np.abs(state.bound).max()))
    differences = [
        difference(getattr(result, name), implied[name]) for name in ("roll_slip", "drum_slip")
    ]
    return {
        "gap_slope": largest(gap),
        "positive_pressure": negative_pressure(f.p_roll, f.p_drum),
        **friction_law(zones, state.traction, slip, state.bound, unit=unit, slip_scale=top),
        "slip_velocity": largest([max(value - rounding, 0.0) for value in differences]) / top,
        "winding_force": abs(float(state.equilibrium[-2])),
        "load": abs(float(state.equilibrium[-1])),
    }


def _reported_arrays(
    result: Any, equations: NipEquations, state: NipState, implied: Implied
) -> dict[str, float]:
    """Return the differences of the reported arrays from values recomputed from the tractions."""
    f, P = state.fields, equations.problem.nip_load
    # the rounding error of large tensions is accepted
    tension_scale = P + ROUNDING * float(np.abs(f.tension).max()) / ACCEPTED_RESIDUAL
    extent = result.half_width * float(np.abs(f.geometry.mesh.nodes).max())
    positions = [difference(getattr(result, name), implied[name]) for name in ("x", "slip_x")]
    strain = difference(result.roll_strain, implied["roll_strain"])
    return {
        "tension": difference(result.tension, f.tension) / tension_scale,
        "zones": 0.0 if _zones_are_valid(result, implied) else inf,
        "mesh": max(positions) / extent,
        "roll_strain": strain / equations.slope_scale,
    }


def _wrap_conditions(
    result: Any, equations: NipEquations, state: NipState, implied: Implied
) -> dict[str, float]:
    """Return the residual of the normal equilibrium on the wraps, and that of the curvature."""
    problem, at, f = equations.problem, equations.layout, state.fields
    if not problem.is_wrapped:
        return {"curvature": difference(result.curvature, implied["curvature"])}
    # nodal forces and changes of slope over a cell instead of pressures and curvatures: on short
    # cells curvatures are differences of nearly equal slopes
    lengths = f.geometry.a * f.geometry.mesh.weights
    upstream = lengths[: at.first + 1] if problem.drum_wrap else lengths[:0]
    downstream = lengths[at.last :] if problem.roll_wrap else lengths[:0]
    forces = np.abs(state.equilibrium[at.last - at.first : -2])
    forces = forces * np.append(upstream, downstream) * equations.pressure_scale
    lengths = lengths if result.curvature.shape == lengths.shape else np.ones(())
    turn = difference(lengths * result.curvature, lengths * implied["curvature"])
    return {
        "hoop_pressure": largest(forces) / problem.nip_load,
        "curvature": turn / equations.slope_scale,
    }


def _surface_loads(result: Any, f: Fields, implied: Implied) -> dict[str, float]:
    """Return the differences of pressures and tractions from those of the state."""
    pressures = {
        "drum_pressure": f.p_drum,
        "roll_pressure": f.p_roll,
        "hoop_pressure": implied["hoop_pressure"],
    }
    tractions = {"roll_traction": f.q_roll, "drum_traction": f.q_drum}
    peak = float(np.abs(f.p_drum).max())

    def largest_difference(arrays: Implied) -> float:
        return max(difference(getattr(result, name), value) for name, value in arrays.items())

    return {
        "normal_equilibrium": largest_difference(pressures) / peak,
        "free_surface": largest_difference(tractions) / peak,
    }


def _zones_are_valid(result: Any, implied: Mapping[str, Array]) -> bool:
    """Return True if all zones are -1, 0 or 1 and equal the recomputed ones.

    At the ends of a face and outside of it zones follow from those of the neighbouring nodes.
    """
    names = "roll_zone", "drum_zone"
    return all(
        np.isin(getattr(result, name), (-1, 0, 1)).all()
        and np.array_equal(getattr(result, name), implied[name])
        for name in names
    )


def consistency_defects(equations: NipEquations, state: NipState) -> dict[str, float]:
    """Return the signed defects of conditions that hold for the continuous fields, dimensionless.

    ``power_balance`` is relative to P a/R*; ``load`` and ``tension`` compare the integrals of the
    hat functions with the trapezoidal rule in theta, x = -cos(theta), relative to P and mu+ P.
    """
    f, problem, mesh = state.fields, equations.problem, state.fields.geometry.mesh
    nip, a = mesh.nip_nodes, f.geometry.a
    theta = np.linspace(0.0, np.pi, nip.stop - nip.start)
    by_theta = a * np.sin(theta) * (theta[1] - theta[0])
    load = float(by_theta @ f.p_drum[nip])
    tension = float(by_theta[1:-1] @ (f.q_roll + f.q_drum)[nip][1:-1])
    gained = float(f.tension[mesh.last] - f.tension[mesh.first])
    return {
        "power_balance": power_balance(equations, state),
        "load": load / problem.nip_load - 1,
        "tension": (tension - gained) / (problem.roll_friction * problem.nip_load),
    }


def consistency(result: Any) -> Residuals:
    """Return the absolute defects of :func:`consistency_defects` from the arrays of a result."""
    equations = equations_of(result)
    defects = consistency_defects(equations, state_of(result, equations))
    return Residuals(**{name: abs(value) for name, value in defects.items()})


def inconsistencies(meshes: Sequence[MeshSolution]) -> list[str]:
    """Return a text for each defect that does not converge to zero with the mesh.

    A defect is of the order of the discretisation error, so that it is smaller than the error
    estimate of the defect itself.  An error of an influence function leaves a defect that does not
    change with the mesh.
    """
    history = [(mesh.size, consistency_defects(mesh.system, mesh.state)) for mesh in meshes]
    texts = []
    for name, value in history[-1][1].items():
        estimate = error_estimate(history, name)
        largest_defect = largest([abs(defects[name]) for _, defects in history])
        if abs(value) > max(
            INCONSISTENT * estimate, MIN_REDUCTION * largest_defect, ACCEPTED_RESIDUAL
        ):
            texts.append(
                f"{RESOLUTION}the condition {name} is violated by {abs(value):.2g}, "
                f"{abs(value) / estimate:.2g} times its estimated discretisation error"
            )
    return texts


def recomputed(result: Any) -> dict[str, tuple[float, float]]:
    """Recompute the scalars without a contact condition of their own; with tolerances."""
    equations = equations_of(result)
    state = state_of(result, equations)
    arrays = {name: value for name, value in vars(result).items() if isinstance(value, np.ndarray)}
    ratios = slip_ratios(equations.problem, arrays, result.in_nip)
    indented = approach(equations, state)
    of_roll = roll_wound_on_tension(equations, state)
    values = {
        "approach": (indented, 1e-8 * abs(indented)),
        "roll_wound_on_tension": (of_roll, 1e-8 * abs(of_roll)),
    }
    values |= {name: (ratios[name], 1e-8) for name in SLIP_RATIOS}
    if not isnan(result.rolling_resistance) or result.problem.viscoelastic:
        lost = rolling_resistance(equations, state)
        values["rolling_resistance"] = lost, 1e-7 * abs(lost)
    return values


def solutions(result: Any) -> list[MeshSolution]:
    """Return the solutions on all meshes of a result; for a loaded result only on the last."""
    if result.refinement is not None:
        meshes: list[MeshSolution] = result.refinement.meshes
        return meshes
    equations = equations_of(result)
    at = equations.layout
    active = np.concatenate([result.roll_zone[at.roll_nodes], result.drum_zone[at.drum_nodes]])
    state = state_of(result, equations)
    solver = SemismoothNewton(equations)
    return [MeshSolution(result.nodes, equations, state, active.astype(np.int8), solver)]
