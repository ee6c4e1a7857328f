r"""Energy of rolling contacts: work of the tractions on the bodies, and the power balance.

A surface point that passes the pressure p and the traction q at the speed V moves at V v' and V u'
in the frame of its body, so that the tractions do the work

    W_i = int [-p v_i' + q_i u_i'] dx,      u' = eps - v/R   (u' = eps on a half-plane)

per length rolled and width.  An elastic body returns it (W = 0), a viscoelastic one dissipates it.
The gap slope v1' + v2' = (x - Delta)/R* and the slip s = eps2 - eps1 + xi of two rollers, with
q_1 = q and q_2 = -q, give the power balance

    sum W_i = P (Delta - x_p)/R* + xi Q - int q s dx - sum int q_i v_i/R_i dx,

x_p being the position of the pressure's resultant.  The left-hand side is evaluated at one point in
each cell for the viscoelastic bodies alone, the right-hand side by exact integrals of the nodal
functions where they are known: the two agree to the order of the discretisation only.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..elasticity.mesh import Mesh
from ..elasticity.surface import Deformation, SurfaceResponse
from .energy import pressure_resultant

__all__ = ["SurfaceWork", "dissipation", "roller_power_balance", "surface_work"]

Array = np.ndarray


class SurfaceWork(NamedTuple):
    """Work on a body, and its part int q v/R dx that belongs to the torque [N/m]."""

    work: float
    curvature_work: float


def _work_on_body(
    body: Any,
    surface: SurfaceResponse,
    mesh: Mesh,
    a: float,
    deformation: Deformation,
    p: Array,
    q: Array,
) -> SurfaceWork:
    """Return the work W of nodal pressures p and tractions q on the surface of a body."""
    h, curvature_work = a * mesh.cells, 0.0
    if body.rigid:
        return SurfaceWork(0.0, 0.0)
    if body.curvature and q.any():
        end = surface.end_displacement(p, q)
        v = mesh.roll_face.displacement_at_nodes(deformation.slope, end, a)
        curvature_work = float(body.curvature * h @ (mesh.at_points(q) * mesh.at_points(v)))
    slope, strain = deformation.slope[:-2], deformation.strain[:-2]  # in the cells
    density = mesh.at_points(q) * strain - mesh.at_points(p) * slope
    return SurfaceWork(float(h @ density) - curvature_work, curvature_work)


def surface_work(problem: Any, mesh: Mesh, state: Any) -> tuple[SurfaceWork, SurfaceWork]:
    """Return the work on the upper and on the lower roller."""
    (a, upper, lower), (one, two) = state.surfaces, problem.bodies
    return (
        _work_on_body(one, upper, mesh, a, state.upper, state.p, state.q),
        _work_on_body(two, lower, mesh, a, state.lower, state.p, -state.q),
    )


def dissipation(problem: Any, bodies: tuple[SurfaceWork, SurfaceWork]) -> float:
    """Return the dissipation of the viscoelastic bodies per length rolled and width [N/m]."""
    pairs = zip(problem.bodies, bodies, strict=True)
    return sum(surface.work for body, surface in pairs if body.viscoelastic)


def roller_power_balance(result: Any, bodies: tuple[SurfaceWork, SurfaceWork]) -> float:
    """Return the violation of the power balance of two rollers, relative to P a/R*.

    Parameters
    ----------
    result : RollerResult
    bodies : pair of SurfaceWork
    """
    problem, x, p, q = result.problem, result.x, result.pressure, result.traction
    h, R = np.diff(x), problem.contact_radius
    load, position = pressure_resultant(x, p)
    middle = result.slip_x[1:]
    fraction = (middle - x[:-1]) / h
    friction = float(h @ (((1 - fraction) * q[:-1] + fraction * q[1:]) * result.slip[1:]))
    supplied = load * (result.offset - position) / R + result.creepage * result.tangential_load
    supplied -= friction + sum(surface.curvature_work for surface in bodies)
    return abs(result.rolling_resistance - supplied) / (load * result.half_width / R)
