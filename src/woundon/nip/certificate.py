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
    from .equations import NipEquations, NipState

__all__ = [
    "certificate", "consistency", "consistency_defects", "equations_of", "inconsistencies",
    "recomputed", "solutions", "state_of",
]  # fmt: skip

Array = np.ndarray

# A defect beyond this many error estimates of it is reported, if it has not fallen below this share
# of the largest one on coarser meshes: the estimate alone may be small by chance.
INCONSISTENT, FALLEN = 3.0, 0.3


def equations_of(result: Any) -> NipEquations:
    """Return the equations on the mesh of a result."""
    return NipSystem(result.without_air, result.nodes)


def state_of(result: Any, equations: NipEquations) -> NipState:
    """Return the state of the unknowns that a result reports.

    Raises
    ------
    ValueError
        If the nodes are not those of such a nip.
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
    problem.web.refuse(float(result.drum_pressure.max()))
    try:
        state = state_of(result, equations)
    except ValueError:
        return Residuals(mesh=inf)
    at, f = equations.layout, state.fields
    peak, top = float(np.abs(f.p_drum).max()), equations.slope_scale
    zones = np.concatenate([result.roll_zone[at.roll_nodes], result.drum_zone[at.drum_nodes]])
    active = zones.astype(np.int8)
    n_gap = at.last - at.first
    gap, wraps = state.equilibrium[:n_gap], state.equilibrium[n_gap:-2]
    # as gap over a cell: on the short cells at the edges slopes are known to rounding only
    cells = f.geometry.mesh.cells[f.geometry.mesh.nip_cells]
    # values that the equations imply, as the result reports them
    implied = web_arrays(equations, state, active)
    rounding = strain_rounding(equations, state)

    def beyond(slip: Array) -> Array:
        return np.sign(slip) * np.maximum(np.abs(slip) - rounding, 0.0)

    tension_scale = problem.nip_load + ROUNDING * float(np.abs(f.tension).max()) / 1e-8
    conditions = {
        "gap_slope": largest(np.abs(gap) * cells / cells.max()) * equations.slope_scale / top,
        "positive_pressure": negative_pressure(f.p_roll, f.p_drum),
        **friction_law(
            zones, state.traction, beyond(state.slip * top), state.bound,
            unit=np.full(zones.size, float(np.abs(state.bound).max())), slip_scale=top,
        ),
        "slip_velocity": largest([
            max(difference(getattr(result, name), implied[name]) - rounding, 0.0)
            for name in ("roll_slip", "drum_slip")
        ]) / top,
        "winding_force": abs(float(state.equilibrium[-2])),
        "load": abs(float(state.equilibrium[-1])),
        "tension": difference(result.tension, f.tension) / tension_scale,
        "zones": 0.0 if _zones_are_valid(result, implied) else inf,
        "mesh": max(
            difference(result.x, implied["x"]), difference(result.slip_x, implied["slip_x"])
        ) / result.half_width / float(np.abs(f.geometry.mesh.nodes).max()),
    }  # fmt: skip
    pressures = {
        "drum_pressure": f.p_drum, "roll_pressure": f.p_roll,
        "hoop_pressure": implied["hoop_pressure"],
    }  # fmt: skip
    conditions["roll_strain"] = difference(result.roll_strain, implied["roll_strain"]) / top
    if problem.is_wrapped:
        # as nodal forces and as turns of the web over a cell: on short cells curvatures are
        # differences of nearly equal slopes
        lengths = f.geometry.a * f.geometry.mesh.weights
        on_wraps = np.concatenate([
            lengths[: at.first + 1] if problem.drum_wrap else lengths[:0],
            lengths[at.last :] if problem.roll_wrap else lengths[:0],
        ])  # fmt: skip
        conditions["hoop_pressure"] = (
            largest(np.abs(wraps) * on_wraps) * equations.pressure_scale / problem.nip_load
        )
        lengths = lengths if result.curvature.shape == lengths.shape else np.ones(())
        turn = lengths * result.curvature, lengths * implied["curvature"]
        conditions["curvature"] = difference(*turn) / top
    else:
        conditions["curvature"] = difference(result.curvature, implied["curvature"])
    conditions["normal_equilibrium"] = (
        max(difference(getattr(result, name), value) for name, value in pressures.items()) / peak
    )
    tractions = ("roll_traction", f.q_roll), ("drum_traction", f.q_drum)
    conditions["free_surface"] = (
        max(difference(getattr(result, name), value) for name, value in tractions) / peak
    )
    loads = (f.p_roll[at.first :], f.q_roll[at.first :]), (
        f.p_drum[: at.last + 1], f.q_drum[: at.last + 1],
    )  # fmt: skip
    surfaces = f.geometry.roll.surface, f.geometry.drum.surface
    conditions |= body_equilibrium(problem, surfaces, loads)
    if result.air is not None:
        conditions |= air_conditions(result)
    return Residuals(**conditions)


def _zones_are_valid(result: Any, implied: Mapping[str, Array]) -> bool:
    """Return whether zones are -1, 0 or 1, and nodes without a traction repeat their neighbour."""
    zones = result.roll_zone, result.drum_zone
    known = all(np.isin(zone, (-1, 0, 1)).all() for zone in zones)
    same = all(
        np.array_equal(getattr(result, name), implied[name]) for name in ("roll_zone", "drum_zone")
    )
    return known and same


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
    """Return the sizes of the defects of :func:`consistency_defects` by the arrays of a result."""
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
        estimate, largest_defect = (
            error_estimate(history, name),
            largest([abs(defects[name]) for _, defects in history]),
        )
        if abs(value) > max(INCONSISTENT * estimate, FALLEN * largest_defect, ACCEPTED_RESIDUAL):
            texts.append(
                f"{RESOLUTION}the condition {name} is violated by {abs(value):.2g}, "
                f"{abs(value) / estimate:.2g} times its estimated discretisation error"
            )
    return texts


def recomputed(result: Any) -> dict[str, tuple[float, float]]:
    """Return the scalars that no condition determines: values from the arrays, and tolerances."""
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
    """Return the solutions on the meshes of a result; of a loaded one, that on its own mesh."""
    if result.refinement is not None:
        meshes: list[MeshSolution] = result.refinement.meshes
        return meshes
    equations = equations_of(result)
    at = equations.layout
    active = np.concatenate([result.roll_zone[at.roll_nodes], result.drum_zone[at.drum_nodes]])
    state = state_of(result, equations)
    solver = SemismoothNewton(equations)
    return [MeshSolution(result.nodes, equations, state, active.astype(np.int8), solver)]
