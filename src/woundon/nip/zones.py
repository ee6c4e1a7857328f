"""Boundaries of the stick and slip zones of a face, and its slip lengths.

Zones belong to nodes.  As a boundary moves past a node, both the slip of the node and its slack
mu p - |q| are zero.  In between the boundary moves from one node to the next in proportion to the
slip of the slipping neighbour and the slack of the sticking one, each relative to the value one
node farther from the boundary.  The slip lengths therefore depend continuously on the solution; the
position of a boundary is known to the cell in which it lies.
"""

from __future__ import annotations

import numpy as np

__all__ = [
    "LEAST_OFFSET_ERROR",
    "boundary_positions",
    "cusp_excess",
    "has_traction_jump",
    "slip_lengths",
    "slip_share",
]

Array = np.ndarray

# Least error of an offset, which may be zero, relative to the half width: rounding decides whether
# a node at the boundary of a zone slips, and this moves the pressure of a symmetric contact.
LEAST_OFFSET_ERROR = 1e-9


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
    """Return the zone boundary between two neighbouring nodes.

    Between a stick and a slip node it divides their distance in the ratio of two extrapolations:
    of mu p - |q| to zero in the stick zone, and of the slip velocity to zero in the slip zone.
    Arrays as of :func:`boundary_positions`, but ``slip`` is the magnitude of the velocity.
    """
    if zones[left] * zones[right] < 0:  # slip changes its direction
        t = slip[left] / (slip[left] + slip[right]) if slip[left] + slip[right] else 0.5
        return float(x[left] + t * (x[right] - x[left]))
    stick, slips, outward = (left, right, 1) if zones[left] == 0 else (right, left, -1)
    from_slip = _cells_to_zero(slip, slips, outward)
    from_stick = _cells_to_zero(np.maximum(slack, 0.0), stick, -outward)
    t = from_stick / (from_stick + from_slip) if from_stick + from_slip else 0.5
    return float(x[stick] + t * (x[slips] - x[stick]))


def _cells_to_zero(values: Array, node: int, outward: int) -> float:
    """Extrapolate a quantity linearly to its zero; return the distance from a node in cells.

    It is extrapolated from the node and the next one ``outward`` (+1 or -1), away from the zone
    boundary, and is at most one cell, also where it does not fall towards the boundary.
    """
    following = node + outward
    if not 0 <= following < values.size or values[following] <= values[node]:
        return 1.0
    return float(min(values[node] / (values[following] - values[node]), 1.0))


def slip_lengths(x: Array, zones: Array, slip: Array, slack: Array) -> tuple[float, float]:
    """Return the lengths of the slip zones at the leading and at the trailing edge [m].

    Parameters as of :func:`boundary_positions`.
    They have the sign of the slip, > 0 where the web is faster, and are 0 where the web sticks.
    """
    leading, trailing = int(zones[0]), int(zones[-1])
    boundaries = boundary_positions(x, zones, slip, slack)
    if not boundaries:
        length = leading * float(x[-1] - x[0])
        return length, length
    return leading * (boundaries[0] - float(x[0])), trailing * (float(x[-1]) - boundaries[-1])


def slip_share(x: Array, zones: Array, slip: Array, slack: Array) -> float:
    """Return the share of the width of a contact on which the surfaces slip [1].

    Parameters
    ----------
    x, zones, slip, slack : (n,) arrays
        As for :func:`boundary_positions`.
    """
    ends = [x[0], *boundary_positions(x, zones, slip, slack), x[-1]]
    # of each run of nodes in one zone: whether it slips
    slips = zones[np.append(True, np.diff(zones) != 0)] != 0
    return float(np.diff(ends)[slips].sum() / (x[-1] - x[0]))


def has_traction_jump(zones: Array) -> bool:
    """Return True if slip changes its direction without a stick zone of more than one node.

    Examples
    --------
    >>> has_traction_jump(np.array([-1, 0, 1])), has_traction_jump(np.array([-1, 0, 0, 1]))
    (True, False)
    """
    single = (zones[1:-1] == 0) & (zones[:-2] * zones[2:] < 0)  # stick nodes between them
    return bool(single.any() or (zones[:-1] * zones[1:] < 0).any())


def cusp_excess(pressure: Array, *faces: Array) -> float:
    """Return the possible excess of the largest pressure over the largest nodal value, >= 0.

    The pressure may have a cusp at a zone boundary, because a change of the traction deflects the
    surfaces of dissimilar bodies.  It is concave there, so that it exceeds the value of a node
    next to the boundary by at most about the difference to a neighbouring node.

    Parameters
    ----------
    pressure : (n,) array
    faces : (n,) arrays
        Zones of the faces, at least one.

    Examples
    --------
    >>> p = np.array([0.0, 0.5, 0.75, 0.875, 0.75, 0.5, 0.0])
    >>> cusp_excess(p, np.array([0, 0, 0, 0, 1, 1, 1])), cusp_excess(p, np.zeros(7))
    (0.125, 0.0)
    """
    near = np.zeros(pressure.size - 2, dtype=bool)
    for zones in faces:
        changes = np.diff(zones) != 0
        near |= changes[1:] | changes[:-1]
    rise = np.diff(pressure)
    possible = pressure[1:-1] + np.maximum(rise[:-1], -rise[1:])
    return max(float(possible[near].max(initial=0.0) - pressure.max()), 0.0)
