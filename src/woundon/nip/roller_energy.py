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

from typing import Any

import numpy as np

from .energy import BodyWork, body_work, pressure_resultant

__all__ = ["roller_power_balance", "work_on_rollers"]

Array = np.ndarray


def work_on_rollers(state: Any) -> tuple[BodyWork, BodyWork]:
    """Return the work on the upper and on the lower roller."""
    a, upper, lower = state.geometry
    return (
        body_work(upper, state.upper, state.p, state.q, a),
        body_work(lower, state.lower, state.p, -state.q, a),
    )


def roller_power_balance(result: Any, bodies: tuple[BodyWork, BodyWork]) -> float:
    """Return the violation of the power balance of two rollers, relative to P a/R*.

    Parameters
    ----------
    result : RollerResult
    bodies : pair of BodyWork
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
