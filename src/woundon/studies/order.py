"""Orders of cases in which successive cases are neighbours, for warm starts."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

__all__ = ["bisection_order", "serpentine", "tour"]

Array = np.ndarray


def serpentine(shape: Sequence[int], axes: Sequence[int]) -> Array:
    """Return the cases of a grid in an order that moves one step along one axis at a time.

    Parameters
    ----------
    shape : sequence of int
        The grid; cases are numbered with the last axis running fastest.
    axes : sequence of int
        The axes from the slowest to the fastest on the path.

    Returns
    -------
    (cases,) int array
        The reflected mixed-radix Gray code.

    Examples
    --------
    >>> serpentine((2, 3), (0, 1)).tolist()
    [0, 1, 2, 5, 4, 3]
    """
    step = np.arange(int(np.prod(shape)))
    index: list[Array] = [step] * len(shape)
    stride = step.size
    for axis in axes:
        count = shape[axis]
        passes = step // stride  # number of completed passes: every second one is reversed
        stride //= count
        digit = step // stride % count
        index[axis] = np.where(passes % 2 == 0, digit, count - 1 - digit)
    return np.ravel_multi_index(tuple(index), tuple(shape))


def bisection_order(points: Array) -> Array:
    """Return an order of the rows of a table in which successive rows form compact groups.

    Recursive bisection: the column with the largest range is divided at its median.

    Parameters
    ----------
    points : (cases, inputs) array

    Returns
    -------
    (cases,) int array
    """
    unit = _scale_columns(points)
    out = np.empty(len(points), dtype=np.intp)
    stack = [(np.arange(len(points)), 0)]
    while stack:
        rows, start = stack.pop()
        if len(rows) <= 8:
            out[start : start + len(rows)] = rows
            continue
        widest = int(np.argmax(np.ptp(unit[rows], axis=0)))
        ranked = rows[np.argsort(unit[rows, widest], kind="stable")]
        half = len(rows) // 2
        stack += [(ranked[:half], start), (ranked[half:], start + half)]
    return out


def tour(points: Array) -> Array:
    """Return the nearest-neighbour tour of the rows of a table, from the first one.

    Parameters
    ----------
    points : (cases, inputs) array

    Returns
    -------
    (cases,) int array
    """
    unit = _scale_columns(points)
    out = np.zeros(len(points), dtype=np.intp)
    unvisited = np.ones(len(points), dtype=bool)
    for k in range(1, len(points)):
        unvisited[out[k - 1]] = False
        distance = np.sum((unit - unit[out[k - 1]]) ** 2, axis=1)
        out[k] = np.argmin(np.where(unvisited, distance, np.inf))
    return out


def _scale_columns(points: Array) -> Array:
    """Return every column divided by its range."""
    spread = np.ptp(points, axis=0)
    return np.asarray(points / np.where(spread > 0, spread, 1.0))
