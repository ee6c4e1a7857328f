"""The certificate of a nip: every law measured on the arrays that its result reports."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..contact.certificate import (
    beyond_rounding,
    friction_laws,
    largest,
    misplaced_slips,
    positive_pressure,
)
from ..losses import Surface, balance_law, pressed, surfaces
from ..results import Residuals
from ..two_bodies import Matrices, mesh_of, within
from .equations import NipMatrices, gained

if TYPE_CHECKING:
    from .result import NipResult

__all__ = ["certificate", "matrices_of"]

Array = np.ndarray


def matrices_of(result: NipResult) -> Matrices:
    """Assemble the equations of a result anew, bodies that are not linear about its tractions."""
    q = np.concatenate([result.roll_traction[1:-1], result.drum_traction[1:-1]])
    about = NipMatrices.loads(result.pressure[1:-1], q)
    return NipMatrices.at(result.problem, mesh_of(result), result.half_width, about)


def certificate(result: NipResult, made: Matrices) -> Residuals:
    """Measure every law of a result.

    Parameters
    ----------
    result : NipResult
    made : Matrices
        Its equations; see :func:`matrices_of`.
    """
    problem, a, inside = result.problem, result.half_width, slice(1, -1)
    problem.web.refuse(float(np.max(result.pressure)))
    P, T_in = problem.nip_load, problem.web_tension
    p, x = result.pressure[inside], result.x
    q_roll, q_drum = result.roll_traction, result.drum_traction
    q = np.concatenate([q_roll[inside], q_drum[inside]])
    zones = np.concatenate([result.roll_zone[inside], result.drum_zone[inside]])
    mesh = mesh_of(result)
    gain = gained(problem, mesh, x, q_roll, q_drum)
    c11 = problem.web.compliance.c11
    # the solved rigid slip holds the web's strain behind the nip too
    creep = result.drum_creep + c11 / problem.web.thickness * (T_in + gain[-1])
    shift = result.offset / problem.contact_radius
    miss, v = made.laws(p, q, shift, creep)
    n, top = p.size, made.top
    # a node has the slip of the cell before it; that at the leading edge repeats the first
    slips = np.empty((2, n + 2))
    slips[:, 1:-1], slips[:, -1] = v[: 2 * n].reshape(2, n), v[2 * n :]
    slips[:, 0] = slips[:, 1]
    told = np.array([result.roll_slip, result.drum_slip])
    friction = np.empty(2 * n)
    friction[:n], friction[n:] = problem.roll_friction, problem.drum_friction
    tension = np.concatenate([
        result.web_tension - T_in - gain,
        [result.nip_induced_tension - result.extrapolation - gain[-1]],
    ])  # fmt: skip
    unit = friction * np.abs(p).max()
    laws = friction_laws(
        zones, q, v[: q.size], friction * np.concatenate([p, p]), unit=unit, slip_scale=top,
        strain=result.drum_creep,
    )  # fmt: skip
    # without pressure at the edges of the contact there is no traction
    edges = np.abs(np.concatenate([q_roll[[0, -1]], q_drum[[0, -1]]]))
    bound = largest([laws["friction_bound"], largest(edges) / unit.min()])
    places = np.concatenate([x - a * mesh.nodes, x[[0, -1]] - [-a, a]])
    return Residuals(
        indentation=largest(np.abs(miss)) / top,
        positive_pressure=positive_pressure(result.pressure),
        **{**laws, "friction_bound": bound},
        slip_speed=beyond_rounding(told - slips, np.asarray(result.drum_creep)) / top,
        load_equilibrium=abs(mesh.integral(result.pressure, x) / P - 1),
        force_equilibrium=abs(
            mesh.facing(problem.drum.rigid).integral(q_drum, x) - problem.winding_force
        ) / P,
        web_equilibrium=beyond_rounding(tension, result.web_tension) / P,
        half_width=largest([largest(np.abs(places)), misplaced_slips(result.slip_x, x)]) / a,
        **within(problem, made.responses),
        **balance_law(
            result,
            lambda: surfaces(problem, made.responses, mesh, a, made.loads(p, q)),
            lambda one, two: _put_in(result, made, one, two),
        ),
    )  # fmt: skip


def _put_in(result: NipResult, made: Matrices, roll: Surface, drum: Surface) -> float:
    """Return what shafts and web tension put in less what friction takes [N/m]."""
    problem, mesh, a = result.problem, mesh_of(result), result.half_width
    web = problem.web.compliance
    work = pressed(problem, a * mesh.middle, result.offset / problem.contact_radius, roll, drum)
    tension = (
        problem.web_tension
        + a * mesh.upstream @ (result.roll_traction + result.drum_traction)[1:-1]
    )
    stretched = web.c11 / problem.web.thickness * tension
    behind = web.c11 / problem.web.thickness * float(result.web_tension[-1])
    p = result.pressure[1:-1]
    _, _, strain_p, strain_q = made.responses[0].gradients
    edge = float(strain_p[-1] @ p + strain_q[-1] @ result.roll_traction[1:-1]) - behind
    edge += float(np.ravel(made.responses[0].strain)[-1])  # of a roll that is not linear
    thinner = mesh.slope[:-1] @ problem.web.thinned(p)[0] / -a
    # a node has the slip of the cell before it
    each = roll.traction * (stretched + edge - result.roll_slip[1:])
    each += drum.traction * (stretched + result.drum_creep - result.drum_slip[1:])
    each += roll.pressure * thinner
    return work + float(roll.length @ each)
