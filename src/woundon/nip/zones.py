"""Boundaries of the stick and slip zones of a face, and its slip lengths.

Zones belong to nodes.  As a boundary moves past a node, both the slip of the node and its slack
mu p - |q| are zero.  In between the boundary moves from one node to the next in proportion to the
slip of the slipping neighbour and the slack of the sticking one, each relative to the value one
node farther from the boundary.  The slip lengths therefore depend continuously on the solution; the
position of a boundary is known to the cell in which it lies.
"""

from __future__ import annotations

import numpy as np

__all__ = ["boundary_positions", "has_traction_jump", "slip_lengths"]

Array = np.ndarray


def boundary_positions(x: Array, zones: Array, slip: Array, slack: Array) -> list[float]:
    """Return the positions at which the zone changes along a face.

    Parameters
    ----------
    x, zones, slip, slack : (n,) arrays
        Nodes, zones (0 stick, +1 and -1 slip), slip velocities, and mu p - |q|.
    """
    return [
        _boundary(x, zones, np.abs(slip), slack, int(k), int(k) + 1)
        for k in np.nonzero(np.diff(zones))[0]
    ]


def _boundary(x: Array, zones: Array, slip: Array, slack: Array, left: int, right: int) -> float:
    if zones[left] * zones[right] < 0:  # slip changes its direction
        share = slip[left] / (slip[left] + slip[right]) if slip[left] + slip[right] else 0.5
        return float(x[left] + share * (x[right] - x[left]))
    stick, slips, outward = (left, right, 1) if zones[left] == 0 else (right, left, -1)
    passed = _cells_from_zero(slip, slips, outward)
    ahead = _cells_from_zero(np.maximum(slack, 0.0), stick, -outward)
    share = ahead / (ahead + passed) if ahead + passed else 0.5
    return float(x[stick] + share * (x[slips] - x[stick]))


def _cells_from_zero(values: Array, node: int, outward: int) -> float:
    """Return the number of cells between a node and the place where a quantity becomes zero."""
    beyond = node + outward
    if not 0 <= beyond < values.size or values[beyond] <= values[node]:
        return 1.0
    return float(min(values[node] / (values[beyond] - values[node]), 1.0))


def slip_lengths(x: Array, zones: Array, slip: Array, slack: Array) -> tuple[float, float]:
    """Return the lengths of the slip zones at the leading and at the trailing edge [m].

    They have the sign of the slip, > 0 where the web is faster, and are 0 where the web sticks.
    """
    leading, trailing, ends = (
        int(zones[0]),
        int(zones[-1]),
        boundary_positions(x, zones, slip, slack),
    )
    if not ends:
        length = leading * float(x[-1] - x[0])
        return length, length
    return leading * (ends[0] - float(x[0])), trailing * (float(x[-1]) - ends[-1])


def has_traction_jump(zones: Array) -> bool:
    """Return True if slip changes its direction without a stick zone of more than one node.

    Examples
    --------
    >>> has_traction_jump(np.array([-1, 0, 1])), has_traction_jump(np.array([-1, 0, 0, 1]))
    (True, False)
    """
    single = (zones[1:-1] == 0) & (zones[:-2] * zones[2:] < 0)
    return bool(single.any() or (zones[:-1] * zones[1:] < 0).any())
