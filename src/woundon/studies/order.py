"""Orders in which neighbours follow one another, so that each case starts from the one before."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

__all__ = ["bisected", "serpentine", "tour"]

Array = np.ndarray


def serpentine(shape: Sequence[int], axes: Sequence[int]) -> Array:
    """Return a grid's cases in a path that moves one step along one axis at a time.

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
    """
    step = np.arange(int(np.prod(shape)))
    index: list[Array] = [step] * len(shape)
    stride = step.size
    for axis in axes:
        count = shape[axis]
        turns = step // stride  # passes along this axis that lie behind: every other one goes back
        stride //= count
        digit = step // stride % count
        index[axis] = np.where(turns % 2 == 0, digit, count - 1 - digit)
    return np.ravel_multi_index(tuple(index), tuple(shape))


def bisected(points: Array) -> Array:
    """Return the rows of a table so that every stretch of them is a compact group.

    The widest column is halved at its median, and the halves likewise.

    Parameters
    ----------
    points : (cases, inputs) array

    Returns
    -------
    (cases,) int array
    """
    unit = _scaled(points)
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
    """Return the order of a walk from row to nearest row not yet visited, from the first one.

    Parameters
    ----------
    points : (cases, inputs) array

    Returns
    -------
    (cases,) int array
    """
    unit = _scaled(points)
    out = np.zeros(len(points), dtype=np.intp)
    ahead = np.ones(len(points), dtype=bool)
    for k in range(1, len(points)):
        ahead[out[k - 1]] = False
        distance = np.sum((unit - unit[out[k - 1]]) ** 2, axis=1)
        out[k] = np.argmin(np.where(ahead, distance, np.inf))
    return out


def _scaled(points: Array) -> Array:
    """Return every column in units of its spread."""
    spread = np.ptp(points, axis=0)
    return np.asarray(points / np.where(spread > 0, spread, 1.0))
