"""Gauss's quadrature in cells."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

__all__ = ["gauss_points", "gauss_rule"]

Array = np.ndarray


@lru_cache
def gauss_rule(count: int) -> tuple[Array, Array]:
    """Return points and weights of Gauss's rule on [-1, 1], (count,) each."""
    points, weights = np.polynomial.legendre.leggauss(count)
    for each in (points, weights):
        each.setflags(write=False)  # the same arrays for all callers
    return points, weights


def gauss_points(ends: Array, count: int) -> tuple[Array, Array]:
    """Return points and weights of an integral over n cells, (n count,) each.

    Parameters
    ----------
    ends : (n + 1,) array
        Ends of the cells, ascending.
    count : int
        Points in each cell.

    Examples
    --------
    >>> x, weights = gauss_points(np.array([0.0, 1.0, 3.0]), 2)
    >>> round(float(weights @ x**3), 12)  # 3^4/4
    20.25
    """
    points, weights = gauss_rule(count)
    half = np.diff(ends)[:, None] / 2
    return (ends[:-1, None] + half * (1 + points)).ravel(), (half * weights).ravel()
