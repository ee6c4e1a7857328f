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
from typing import TYPE_CHECKING

import numpy as np

from ..contact.newton import SemismoothNewton
from ..contact.refinement import CHANGES, FINAL_TOLERANCE, MeshSolution, richardson_estimates
from ..errors import RESOLUTION
from ..results import ACCEPTED_RESIDUAL, Residuals, largest
from .conditions import LARGEST_MESH, body_equilibrium, difference, friction_law, negative_pressure
from .energy import dissipation, power_balance, work_on_bodies
from .entrained_air import air_conditions
from .nip_fields import NipFields
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
from .several_nips import SeveralNips, SeveralState, system_of

if TYPE_CHECKING:
    from .equations import NipEquations, NipState

__all__ = [
    "certificate",
    "consistency",
    "consistency_defects",
    "equations_of",
    "inconsistencies",
    "recomputed",
    "recomputed_solution",
    "state_of",
]

Array = np.ndarray

# A defect is reported if it exceeds INCONSISTENT times its error estimate and MIN_REDUCTION times
# the largest defect on coarser meshes, because an estimate may be small by chance.
INCONSISTENT, MIN_REDUCTION = 3.0, 0.3


def equations_of(result: NipFields) -> NipSystem | SeveralNips:
    """Return the equations on the mesh of a result.

    Raises
    ------
    ValueError
        If it has more nodes than the largest mesh.
    """
    if result.nodes > LARGEST_MESH:
        raise ValueError(f"{result.nodes} nodes; must be at most {LARGEST_MESH}")
    return system_of(result.without_air, result.nodes)


def state_of(result: NipFields, system: NipSystem | SeveralNips) -> NipState | SeveralState:
    """Return the state of the unknowns that a result reports.

    Responses may be interpolated between half widths of ``system`` next to that of the result.

    Raises
    ------
    ValueError
        If the number of nodes is not that of the mesh.
    """
    pairs = zip(system.parts_of(result), system.nips, strict=True)
    u = np.concatenate([_unknowns_of(part, nip) for part, nip in pairs])
    return system.evaluate(u, FINAL_TOLERANCE)


def _unknowns_of(result: NipFields, equations: NipEquations) -> Array:
    """Return the unknowns u, (size,), that a result reports, of one nip.

    Raises
    ------
    ValueError
        If the number of nodes is not that of the mesh.
    """
    layout, web, problem = equations.layout, result.problem.web, equations.problem
    if result.x.size != layout.end + 1:
        raise ValueError(f"{result.x.size} nodes; the mesh of this nip has {layout.end + 1}")
    u = np.empty(layout.size)
    u[layout.drum_p] = result.drum_pressure[layout.drum_p_nodes]
    u[layout.wrap_p] = result.roll_pressure[layout.wrap_p_nodes]
    u[layout.shift] = result.offset / problem.contact_radius
    # the creepage of the equations refers to the web's strain at the end
    u[layout.xi] = result.drum_creepage + web.compliance.c11 / web.thickness * result.tension[-1]
    u[layout.ln_a] = np.log(result.half_width)
    u[layout.roll_q] = result.roll_traction[layout.roll_nodes]
    u[layout.drum_q] = result.drum_traction[layout.drum_nodes]
    return u


def certificate(result: NipFields, system: NipSystem | SeveralNips) -> Residuals:
    """Return the largest violation of every contact condition, dimensionless.

    Parameters
    ----------
    result : NipResult
    system : NipSystem or SeveralNips
        The equations on its mesh.
    """
    system.problem.web.check_pressure(float(result.drum_pressure.max()))
    try:
        state = state_of(result, system)
    except ValueError:
        return Residuals(mesh=inf)
    of_nips = [
        _conditions(part, nip, own)
        for part, nip, own in zip(system.parts_of(result), system.nips, state.nips, strict=True)
    ]
    names = dict.fromkeys(name for conditions in of_nips for name in conditions)
    conditions = {name: largest([each.get(name, 0.0) for each in of_nips]) for name in names}
    if isinstance(system, SeveralNips):
        centres = system.centres([result.half_width, *result.next_half_widths])
        extent = float(result.x[-1] - result.x[0])
        positions = difference(result.next_positions, np.array(centres[1:]))
        conditions["mesh"] = max(conditions["mesh"], positions / extent)
    if (result.air is None) != (result.problem.air is None):
        conditions["air_film"] = inf
    elif result.air is not None:
        nip = result.in_nip
        arrays = result.x[nip], result.roll_pressure[nip]
        conditions |= air_conditions(result.air, result.problem, *arrays, result.half_width)
    return Residuals(**conditions)


def _conditions(result: NipFields, equations: NipEquations, state: NipState) -> dict[str, float]:
    """Return the largest violation of every contact condition of one nip."""
    f, zones = state.fields, _zones_of_tractions(result, equations)
    # the arrays that follow from the unknowns of the result
    expected = web_arrays(equations, state, zones.astype(np.int8))
    conditions = _equations_and_friction(result, equations, state, expected, zones)
    conditions |= _reported_arrays(result, equations, state, expected)
    conditions |= _wrap_conditions(result, equations, state, expected)
    surfaces = f.geometry.roll.surface, f.geometry.drum.surface
    return conditions | body_equilibrium(equations.problem, surfaces, (f.on_roll, f.on_drum))


def _zones_of_tractions(result: NipFields, equations: NipEquations) -> Array:
    """Return the zones of the traction nodes, (k,), roll then drum."""
    layout = equations.layout
    return np.append(result.roll_zone[layout.roll_nodes], result.drum_zone[layout.drum_nodes])


Arrays = Mapping[str, Array]


def _difference(result: NipFields, expected: Arrays, *names: str) -> float:
    """Return the largest difference of the named arrays of a result from the expected ones."""
    return largest([difference(getattr(result, name), expected[name]) for name in names])


def _equations_and_friction(
    result: NipFields, equations: NipEquations, state: NipState, expected: Arrays, zones: Array
) -> dict[str, float]:
    """Return the residuals of gap slope, resultants and friction law.

    ``expected`` are the arrays that follow from the unknowns, ``zones`` those of the k traction
    nodes, (k,).

    Slips below the rounding error of a difference of strains count as zero.  The equations of the
    state are dimensionless: gap slope of each cell of the nip, equilibrium on the wraps, winding
    force, load.
    """
    f, slope_scale = state.fields, equations.slope_scale
    rounding = strain_rounding(equations, state)
    # gap over a cell instead of slope: on the short cells at the edges slopes have rounding errors
    cells = f.geometry.mesh.cells[f.geometry.mesh.nip_cells]
    gap = np.abs(state.equilibrium[: cells.size]) * cells / cells.max()
    slip = np.sign(state.slip) * np.maximum(np.abs(state.slip * slope_scale) - rounding, 0.0)
    unit = float(np.abs(state.bound).max())
    slip_difference = _difference(result, expected, "roll_slip", "drum_slip")
    return {
        "gap_slope": largest(gap),
        "positive_pressure": negative_pressure(f.p_roll, f.p_drum),
        **friction_law(zones, state.traction, slip, state.bound, unit=unit, slip_scale=slope_scale),
        "slip_velocity": max(slip_difference - rounding, 0.0) / slope_scale,
        "winding_force": abs(float(state.equilibrium[-2])),
        "load": abs(float(state.equilibrium[-1])),
    }


def _reported_arrays(
    result: NipFields, equations: NipEquations, state: NipState, expected: Arrays
) -> dict[str, float]:
    """Return the differences of the reported arrays from the expected ones.

    Pressures and tractions are relative to the largest pressure, tensions to the load, positions to
    the extent of the mesh.  Zones must be the same: those at the ends of a face and outside of it
    follow from the zones of the neighbouring nodes.
    """
    f, P = state.fields, equations.problem.nip_load
    peak = float(np.abs(f.p_drum).max())
    # the rounding error of large tensions is accepted
    tension_scale = P + ROUNDING * float(np.abs(f.tension).max()) / ACCEPTED_RESIDUAL
    extent = result.half_width * float(np.abs(f.geometry.mesh.nodes).max())
    pressures = _difference(result, expected, "drum_pressure", "roll_pressure", "hoop_pressure")
    tractions = _difference(result, expected, "roll_traction", "drum_traction")
    zones_are_valid = (
        np.isin(np.append(result.roll_zone, result.drum_zone), (-1, 0, 1)).all()
        and _difference(result, expected, "roll_zone", "drum_zone") == 0
    )
    return {
        "tension": _difference(result, expected, "tension") / tension_scale,
        "zones": 0.0 if zones_are_valid else inf,
        "mesh": _difference(result, expected, "x", "slip_x") / extent,
        "roll_strain": _difference(result, expected, "roll_strain") / equations.slope_scale,
        "normal_equilibrium": pressures / peak,
        "free_surface": tractions / peak,
    }


def _wrap_conditions(
    result: NipFields, equations: NipEquations, state: NipState, expected: Arrays
) -> dict[str, float]:
    """Return the residual of the normal equilibrium on the wraps, and that of the curvature."""
    problem, layout, f = equations.problem, equations.layout, state.fields
    if not problem.is_wrapped:
        return {"curvature": _difference(result, expected, "curvature")}
    # nodal forces and changes of slope over a cell instead of pressures and curvatures: on short
    # cells curvatures are differences of nearly equal slopes
    lengths = f.geometry.a * f.geometry.mesh.weights
    upstream = lengths[layout.drum_wrap_nodes] if problem.drum_wrap else lengths[:0]
    downstream = lengths[layout.roll_wrap_nodes] if problem.roll_wrap else lengths[:0]
    forces = np.abs(state.equilibrium[layout.last - layout.first : -2])
    forces = forces * np.append(upstream, downstream) * equations.pressure_scale
    lengths = lengths if result.curvature.shape == lengths.shape else np.ones(())
    turn = difference(lengths * result.curvature, lengths * expected["curvature"])
    return {
        "hoop_pressure": largest(forces) / problem.nip_load,
        "curvature": turn / equations.slope_scale,
    }


def consistency_defects(
    system: NipSystem | SeveralNips, state: NipState | SeveralState
) -> dict[str, float]:
    """Return the signed defects of conditions that hold for the continuous fields, dimensionless.

    ``power_balance`` is relative to P a/R*, of all nips together; ``load`` and ``tension`` compare
    the integrals of the hat functions with the trapezoidal rule in theta, x = -cos(theta), relative
    to P and mu+ P, in each nip: those of the further ones are ``load_2``, ``tension_2`` ...
    """
    power, unit, out = 0.0, 0.0, {"power_balance": 0.0}
    for k, (nip, own) in enumerate(zip(system.nips, state.nips, strict=True)):
        scale = nip.problem.nip_load * own.geometry.a / nip.problem.contact_radius
        power, unit = power + scale * power_balance(nip, own), unit + scale
        suffix = f"_{k + 1}" if k else ""
        out |= {f"{name}{suffix}": value for name, value in _quadratures(nip, own).items()}
    return out | {"power_balance": power / unit}


def _quadratures(equations: NipEquations, state: NipState) -> dict[str, float]:
    """Return the relative defects of load and tension of a nip by another quadrature."""
    f, problem, mesh = state.fields, equations.problem, state.fields.geometry.mesh
    nip, a = mesh.nip_nodes, f.geometry.a
    theta = np.linspace(0.0, np.pi, nip.stop - nip.start)
    weights = a * np.sin(theta) * (theta[1] - theta[0])  # dx = a sin(theta) dtheta
    load = float(weights @ f.p_drum[nip])
    tension_change = float(weights[1:-1] @ (f.q_roll + f.q_drum)[nip][1:-1])
    expected = float(f.tension[mesh.last] - f.tension[mesh.first])
    return {
        "load": load / problem.nip_load - 1,
        "tension": (tension_change - expected) / (problem.roll_friction * problem.nip_load),
    }


def consistency(result: NipFields) -> Residuals:
    """Return the absolute defects of :func:`consistency_defects` from the arrays of a result."""
    equations = equations_of(result)
    defects = consistency_defects(equations, state_of(result, equations))
    return Residuals(**{name: abs(value) for name, value in defects.items()})


def inconsistencies(meshes: Sequence[MeshSolution]) -> list[str]:
    """Return a text for each defect that does not converge to zero with the mesh.

    A defect is of the order of the discretisation error, so that it is smaller than the error
    estimate of the defect itself.  An error of an influence function leaves a defect that does not
    change with the mesh.  None without error estimates.
    """
    if len(meshes) <= CHANGES:
        return []
    history = [consistency_defects(mesh.system, mesh.state) for mesh in meshes]
    values = np.array([list(defects.values()) for defects in history])
    estimates = richardson_estimates([mesh.size for mesh in meshes], values)
    texts = []
    for name, defects, estimate in zip(history[-1], np.abs(values).T, estimates, strict=True):
        defect = float(defects[-1])
        if defect > max(
            INCONSISTENT * estimate, MIN_REDUCTION * largest(defects), ACCEPTED_RESIDUAL
        ):
            texts.append(
                f"{RESOLUTION}the condition {name} is violated by {defect:.2g}, "
                f"{defect / estimate:.2g} times its estimated discretisation error"
            )
    return texts


def recomputed(result: NipFields) -> dict[str, tuple[float, float]]:
    """Return (recomputed value, tolerance) of the scalars that no contact condition determines."""
    system = equations_of(result)
    state = state_of(result, system)
    equations, first = system.nips[0], state.nips[0]
    arrays = {name: value for name, value in vars(result).items() if isinstance(value, np.ndarray)}
    ratios = slip_ratios(equations.problem, arrays, result.in_nip)
    indentation = approach(equations, first)
    WOT_of_roll = roll_wound_on_tension(system.nips[-1], state.nips[-1])
    values = {
        "approach": (indentation, 1e-8 * abs(indentation)),
        "roll_wound_on_tension": (WOT_of_roll, 1e-8 * abs(WOT_of_roll)),
    }
    values |= {name: (ratios[name], 1e-8) for name in SLIP_RATIOS}
    if not isnan(result.rolling_resistance) or result.problem.viscoelastic:
        resistance = sum(
            dissipation(nip.problem, work_on_bodies(own))
            for nip, own in zip(system.nips, state.nips, strict=True)
        )
        values["rolling_resistance"] = resistance, 1e-7 * abs(resistance)
    return values


def recomputed_solution(result: NipFields) -> MeshSolution:
    """Return the solution on the last mesh from the arrays of a result."""
    equations = equations_of(result)
    parts = zip(equations.parts_of(result), equations.nips, strict=True)
    zones = [_zones_of_tractions(part, nip) for part, nip in parts]
    active = np.concatenate(zones).astype(np.int8)
    state, solver = state_of(result, equations), SemismoothNewton(equations)
    return MeshSolution(result.nodes, equations, state, active, solver)
