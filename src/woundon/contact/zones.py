"""The zones of a face: their runs, and to a fraction of a cell where they end."""

from __future__ import annotations

from itertools import groupby

import numpy as np

__all__ = ["slip_begins", "slip_lengths", "zone_runs"]

Array = np.ndarray

# how the slip grows with the distance from the point where it begins: behind the leading slip it
# dies out and the traction leaves its bound smoothly; at the end of stick it sets in with a
# vertical tangent, as the body's strain has one, or with a kink on a rigid body, which has none
DYING, SETTING_IN, ON_RIGID = 1.5, 0.5, 1.0


def zone_runs(x: Array, zones: Array) -> list[tuple[int, float, float]]:
    """Return runs (zone, from, to) [m] along the nip, zone borders half-way between nodes."""
    borders = np.concatenate([x[:1], (x[1:] + x[:-1]) / 2, x[-1:]]).tolist()
    runs: list[tuple[int, float, float]] = []
    first = 0
    for zone, members in groupby(zones.tolist()):
        last = first + len(list(members))
        runs.append((int(zone), borders[first], borders[last]))
        first = last
    return runs


def slip_begins(
    x: Array, slip_x: Array, slip: Array, node: int, ahead: int, power: float
) -> float:
    """Return where slip begins between ``node - 1`` and ``node``, extrapolated to nil [m].

    Parameters
    ----------
    x, slip_x, slip : (M,) arrays
        Nodes, and where the slips are taken [m]; slips.
    node : int
        The border lies between ``node - 1`` and ``node``.
    ahead : {1, -1}
        Slip lies behind the border (1) or before it (-1).
    power : float
        With which the slip grows.
    """
    border = float(x[node] + x[node - 1]) / 2
    near = node if ahead == 1 else node - 1
    far = near + ahead
    if not 0 < far < x.size - 1:
        return border
    v = np.abs(slip[[near, far]]) ** (1 / power)
    at, stick = slip_x[[near, far]], float(slip_x[near - ahead])
    if v[1] > v[0]:
        root = float(at[0] - v[0] * (at[1] - at[0]) / (v[1] - v[0]))
        border = min(max(root, min(stick, at[0])), max(stick, at[0]))
    return border


def slip_lengths(
    x: Array, slip_x: Array, zones: Array, slip: Array, *, rigid: bool, sub_cell: bool = True
) -> tuple[float, float]:
    """Return the lengths over which a face slips one way from its leading and trailing edge [m].

    Parameters
    ----------
    x, slip_x, zones, slip : (M,) arrays
        Nodes [m], where the slips are taken [m], zones and slips of the face.
    rigid : bool
        Whether the body behind the face is.
    sub_cell : bool
        Follow the slip to where it is nil, so that lengths vary smoothly; else take the borders
        half-way between nodes.

    Returns
    -------
    (float, float)
        With the sign of the slip: > 0 where the web is the faster one; 0 where it sticks.
    """
    other = np.nonzero(zones != zones[0])[0]
    if zones[0] != 0 and not other.size:
        whole = float(zones[0]) * float(x[-1] - x[0])
        return whole, whole

    def border(node: int, ahead: int, power: float) -> float:
        if not sub_cell:
            return float(x[node] + x[node - 1]) / 2
        if zones[node] * zones[node - 1] < 0:  # slip one way meets slip the other way
            v = slip[[node - 1, node]]
            between = slip_x[node - 1] - v[0] * (slip_x[node] - slip_x[node - 1]) / (v[1] - v[0])
            return float(np.clip(between, x[node - 1], x[node])) if v[1] != v[0] else float(x[node])
        return slip_begins(x, slip_x, slip, node, ahead, power)

    setting_in = ON_RIGID if rigid else SETTING_IN
    leading = trailing = 0.0
    if zones[0] != 0:
        leading = float(zones[0]) * (border(int(other[0]), -1, DYING) - float(x[0]))
    if zones[-1] != 0:
        first = int(np.nonzero(zones != zones[-1])[0][-1]) + 1
        trailing = float(zones[-1]) * (float(x[-1]) - border(first, 1, setting_in))
    return leading, trailing
