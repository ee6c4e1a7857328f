"""The normal problem: the pressure that closes the gap, for given tractions (thesis eq. 126)."""

from __future__ import annotations

import numpy as np

from . import lapack

__all__ = ["solve_normal"]

Array = np.ndarray


def solve_normal(slope_p: Array, gap: Array, slope_q: Array) -> Array:
    """Solve slope_p p + shift = gap - slope_q q for p and shift, for the gap and all q at once.

    Parameters
    ----------
    slope_p : (N, n) array
        Slope of the surfaces by unit pressures; N = n + 1.
    gap : (N,) array
        Slope of the gap.
    slope_q : (N, m) array
        Slope of the surfaces by unit tractions.

    Returns
    -------
    (N, 1 + m) array
        Rows p and shift; the first column for the gap, the others for unit tractions.
    """
    if slope_q.size and not slope_q.any():  # of equal bodies tractions leave the pressure alone
        out = np.zeros((gap.size, 1 + slope_q.shape[1]))
        out[:, :1] = solve_normal(slope_p, gap, slope_q[:, :0])
        return out
    N = gap.size
    matrix = np.empty((N, N), order="F")
    # p is of the order gap/slope_p; a column of that size keeps the matrix balanced
    scale = float(np.max(np.abs(slope_p)))
    matrix[:, :-1] = slope_p
    matrix[:, -1] = scale
    right = np.empty((N, 1 + slope_q.shape[1]), order="F")
    right[:, 0] = gap
    np.negative(slope_q, out=right[:, 1:])
    _, _, solved, info = lapack.dgesv(matrix, right, overwrite_a=1, overwrite_b=1)
    if info != 0:
        raise ArithmeticError("the normal problem is singular; is every body's stiffness finite?")
    solved[-1] *= scale
    return solved
