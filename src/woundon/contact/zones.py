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


def slip_begins(x: Array, slip_x: Array, slip: Array, node: int, ahead: int, power: float) -> float:
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
    border = 0.5 * (float(x[node]) + float(x[node - 1]))
    near = node if ahead == 1 else node - 1
    far = near + ahead
    if not 0 < far < x.size - 1:
        return border
    v, w = (abs(float(slip[k])) ** (1 / power) for k in (near, far))
    at, beyond, stick = (float(slip_x[k]) for k in (near, far, near - ahead))
    if w <= v:
        return border
    root = at - v * (beyond - at) / (w - v)
    return min(max(root, min(stick, at)), max(stick, at))


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
    runs = np.nonzero(np.diff(zones))[0] + 1  # the nodes where another zone begins
    first, last = int(zones[0]), int(zones[-1])
    if not runs.size:
        whole = first * float(x[-1] - x[0])
        return whole, whole

    def border(node: int, ahead: int, power: float) -> float:
        if not sub_cell:
            return 0.5 * (float(x[node]) + float(x[node - 1]))
        if zones[node] * zones[node - 1] < 0:  # slip one way meets slip the other way
            return _crossing(x, slip_x, slip, node)
        return slip_begins(x, slip_x, slip, node, ahead, power)

    leading = trailing = 0.0
    if first:
        leading = first * (border(int(runs[0]), -1, DYING) - float(x[0]))
    if last:
        power = ON_RIGID if rigid else SETTING_IN
        trailing = last * (float(x[-1]) - border(int(runs[-1]), 1, power))
    return leading, trailing


def _crossing(x: Array, slip_x: Array, slip: Array, node: int) -> float:
    """Return where the slip changes its sign between ``node - 1`` and ``node``."""
    v, w = float(slip[node - 1]), float(slip[node])
    left, right = float(slip_x[node - 1]), float(slip_x[node])
    at = left - v * (right - left) / (w - v) if w != v else float(x[node])
    return min(max(at, float(x[node - 1])), float(x[node]))
