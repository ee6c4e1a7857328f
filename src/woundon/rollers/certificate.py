"""The certificate of two rollers: every law measured on the arrays that the result reports."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..contact.certificate import (
    friction_laws,
    integral,
    largest,
    misplaced_slips,
    positive_pressure,
)
from ..losses import Surface, balance_law, pressed, surfaces
from ..results import Residuals
from ..two_bodies import Matrices, mesh_of, within
from .equations import RollerMatrices

if TYPE_CHECKING:
    from .result import RollerResult

__all__ = ["certificate", "matrices_of"]

Array = np.ndarray


def matrices_of(result: RollerResult) -> Matrices:
    """Assemble the equations of a result anew, bodies that are not linear about its tractions."""
    about = RollerMatrices.loads(result.pressure[1:-1], result.traction[1:-1])
    return RollerMatrices.at(result.problem, mesh_of(result), result.half_width, about)


def certificate(result: RollerResult, made: Matrices) -> Residuals:
    """Measure every law of a result.

    Parameters
    ----------
    result : RollerResult
    made : Matrices
        Its equations; see :func:`matrices_of`.
    """
    problem, x, a = result.problem, result.x, result.half_width
    p, q, zone = result.pressure[1:-1], result.traction[1:-1], result.zone[1:-1]
    static = problem.motion == "static"
    v = made.slips(p, q, result.shift if static else result.creepage)
    scale = made.top * (a if static else 1.0)
    bound = problem.friction * p
    # where there is no friction, tractions are measured by the pressure itself
    unit = np.full(p.size, (problem.friction or 1.0) * np.max(np.abs(p)))
    shift = result.offset / problem.contact_radius
    Q = integral(result.traction, x)
    asked = result.tangential_load
    if problem.creepage is None:
        asked = problem.tangential_load or 0.0
    # creepage is found, where it is not given
    astray = 0.0 if problem.creepage is None else abs(result.creepage - problem.creepage)
    places = np.concatenate([x - a * mesh_of(result).nodes, x[[0, -1]] - [-a, a]])
    return Residuals(
        indentation=largest(np.abs(made.indentation(p, q, shift))) / made.top,
        positive_pressure=positive_pressure(result.pressure),
        **friction_laws(zone, q, v, bound, unit=unit, slip_scale=scale),
        slip_speed=largest(np.abs(result.slip - np.concatenate([v[:1], v, v[-1:]]))) / scale,
        load_equilibrium=abs(integral(result.pressure, x) / problem.load - 1),
        force_equilibrium=largest([abs(Q - asked), abs(Q - result.tangential_load)]) / problem.load,
        creepage=astray / made.top,
        half_width=largest([largest(np.abs(places)), misplaced_slips(result.slip_x, x)]) / a,
        **within(problem, made.responses),
        **balance_law(
            result,
            lambda: surfaces(problem, made.responses, mesh_of(result), a, made.loads(p, q)),
            lambda one, two: _put_in(result, one, two),
        ),
    )


def _put_in(result: RollerResult, upper: Surface, lower: Surface) -> float:
    """Return what the shafts put in less what friction takes [N/m]."""
    problem, xi = result.problem, result.creepage
    last = xi + lower.strain[-1] - upper.strain[-1]  # that of the last cell belongs to no node
    x = result.half_width * mesh_of(result).middle
    work = pressed(problem, x, result.offset / problem.contact_radius, upper, lower)
    each = upper.traction * (xi - np.append(result.slip[1:-1], last))
    return work + float(upper.length @ each)
