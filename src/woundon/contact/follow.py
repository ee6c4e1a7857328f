"""From one half width to the one that carries the load, by the factors of the first.

Unknowns x and half width a are a root of R(x, a) = 0, load(x, a) = P.  About a solved (x0, a0) with
factors of R_x, x is followed along ln a by the chord method: as a moves by no more than the meshes
differ, its error falls by |ln a/a0| a step, and a step costs two matrix products with vectors where
another assembly and factorisation would cost hundreds.  The changes along ln a tell
d ln P/d ln a, and predict the next x; the first is predicted to go like load over width, as slopes,
strains and stresses nearly do.
"""

from __future__ import annotations

from math import exp, inf, log
from typing import Any, NamedTuple

import numpy as np

__all__ = ["Followed", "follow"]

Array = np.ndarray

FARTHEST = 0.1  # of ln(load): beyond, another factorisation pays
MOST_STEPS = 8
CONTRACTION = 3.0  # of the chord method, per ln a; 0.01 to 0.8 are seen on random nips
LEFT = 0.03  # of the imbalance that is allowed, of pressures
SAFELY = 1 / 3  # of it: what laws are estimated to miss then; up to 1.7 times as much is seen
SETTLED = 1e-12  # imbalance of what is linear
SHORT = 0.02  # of a step: what may be left of what was linearised
ENOUGH = 0.8  # of the load's miss that is allowed: where it need not be met any better
ROUGH = 1e-4  # imbalance that is allowed meshes that only start finer ones


class Followed(NamedTuple):
    """Equations, state and power d ln P/d ln a at the half width that carries the load."""

    equations: Any
    state: Any
    power: float
    kept: bool  # whether stick and slip are still the same


def follow(
    equations: Any, state: Any, load: float, tolerance: Any, power: float
) -> Followed | None:
    """Return the state that carries the load, near a solved one; None if there, or not got to.

    Parameters
    ----------
    equations : Equations
        Those of the solved half width.
    state : State
        Its solution, a joint one.
    load : float
        [N/m].
    tolerance : Tolerance
    power : float
        First guess of d ln P/d ln a.
    """
    joint, (factors, x, _) = equations.joint, state.solution.joint
    n = joint.unknowns
    carried = equations.load_of(x[:n])
    if carried <= 0 or abs(log(carried / load)) > FARTHEST:
        return None
    apart = float(equations.imbalance(state))
    if abs(carried / load - 1) <= tolerance.load and apart <= tolerance.balance:
        return None
    at = first = log(state.half_width)
    miss, along, moved = log(carried / load), (power - 1) * x, equations
    linear = apart < SETTLED
    error, enough = (0.0, tolerance.load / 4) if linear else (inf, ENOUGH * tolerance.load)
    for k in range(MOST_STEPS):
        step = -miss / power if abs(miss) > enough else 0.0
        # what was linearised settles before the width moves: that asks for kernels anew, and tells
        # the power only if nothing else moves
        if not linear and error > SHORT * abs(step):
            step = 0.0
        if step:
            moved = equations.moved(exp(at + step))
        before = x + along * step
        left = moved.left(before)
        change = joint.step(factors, left)
        now = before + change
        carried = moved.load_of(now[:n])
        last, miss = miss, log(carried / load) if carried > 0 else inf
        if abs(miss) > FARTHEST:
            return None
        if abs(step) > 1e-9:  # a shorter one tells rounding, not the power
            power, along = (miss - last) / step, (now - x) / step
        at, x = at + step, now
        size = float(np.abs(change[:n]).max() / np.abs(x[:n]).max())
        contracts = min(1.0, CONTRACTION * abs(at - first) + apart**0.5)
        error = contracts * size
        rest = 0.0 if abs(miss) <= tolerance.load else -miss / power
        bends = abs(rest * step) > tolerance.load or tolerance.balance < ROUGH
        straight = not rest or (k == 0 and linear and not bends)
        settled = error <= max(LEFT * tolerance.balance, 1e-15)
        if settled and not linear:  # a light nip's gap may be told by the last digits of pressures
            settled = contracts * moved.missed(left) <= SAFELY * tolerance.balance
        if straight and settled:
            slips = joint.slips(change) - left[n + 2 :]
            if rest:  # on, the way that led here
                slips += (slips - _slips(state)) * (rest / step)
                moved, x = equations.moved(exp(at + rest)), x + along * rest
            found = joint.solution(factors, x, slips)
            return Followed(moved, moved.state(found), power, not found.violated().any())
        if not 0.5 < power < 15.0:
            return None
    return None


def _slips(state: Any) -> Array:
    """Return all slips of a solved state."""
    return np.concatenate([state.solution.slip, state.solution.joint[2]])
