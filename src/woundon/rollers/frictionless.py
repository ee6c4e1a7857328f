r"""Two rollers that slip freely: no traction anywhere, and the creepage of vanishing friction.

Without traction nothing fixes the rigid slip xi of v = c0 + S p0 + xi.  However little friction
there is does: tractions mu p sgn(v) add up to nothing where

    int p sgn(c0 + S p0 + xi) dx = 0,

so -xi is the median of the slips weighted by the pressure (for half-planes it is Bentall and
Johnson's limit).
"""

from __future__ import annotations

import numpy as np

from ..contact.stick_slip import StickSlip, StickSlipSolution

__all__ = ["without_traction"]

Array = np.ndarray


def without_traction(problem: StickSlip, start: Array | None = None) -> StickSlipSolution:
    """Return the state of no friction; to be used as one that finds zones.

    Parameters
    ----------
    problem : StickSlip
        Of one face, with no friction.
    start : ignored
    """
    slip, creep = problem.stick_offset, 0.0
    if problem.creep is not None and problem.resultant is not None:
        creep = 0.0 - _median(slip, problem.resultant * problem.pressure)
        slip = slip + creep
    state = np.sign(slip).astype(np.int8)
    none = np.zeros(slip.size)
    return StickSlipSolution(state, none, creep, slip, none)


def _median(values: Array, weights: Array) -> float:
    """Return where the weighted share below crosses a half, linear between the values."""
    order = np.argsort(values)
    v, w = values[order], weights[order]
    share = (np.cumsum(w) - w / 2) / np.sum(w)
    return float(np.interp(0.5, share, v))
