"""The zones of a face: their runs, and to a fraction of a cell where they end."""

from __future__ import annotations

from itertools import groupby, pairwise
from typing import NamedTuple

import numpy as np

__all__ = ["Runs", "slip_lengths", "stick_ends", "zone_runs"]

Array = np.ndarray

# Where stick ends, by how slip and slack grow from nil: the power of the distance, and the share of
# the way from where a node's slip is taken to the node at which the border lies when it changes.
# Best of a few on five families of nips against 385 nodes: 65 nodes leave a 30th of a cell.
LEADING, TRAILING = (1.0, 0.3), (1.5, 0.6)
FARTHEST = 0.9  # a value so near to the next one tells no more where it is nil


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


class _Face(NamedTuple):
    """Nodes, where the slips are taken [m], slips, and slacks mu p - |q| [Pa], M each."""

    x: list[float]
    slip_x: list[float]
    slip: list[float]
    slack: list[float]


def stick_ends(face: _Face, node: int, ahead: int, power: float, share: float) -> float:
    """Return where stick ends between ``node - 1`` and ``node`` [m].

    When a node changes between stick and slip, its slip and its slack are both nil.  In between the
    border goes from one such place to the next by how far the slip of the one node and the slack of
    the other are from nil, as the nodes behind them tell: a continuous function of what is solved.

    Parameters
    ----------
    face : _Face
    node : int
        The border lies between ``node - 1`` and ``node``.
    ahead : {1, -1}
        Slip lies behind the border (1) or before it (-1).
    power, share : float
        See ``LEADING``.
    """
    x, slip_x, slip, slack = face
    stuck, near = (node - 1, node) if ahead == 1 else (node, node - 1)
    far, deep = near + ahead, stuck - ahead
    # at the leading edge the slip of the first cell stands twice
    begins, ends = (slip_x[k] + share * (x[k] - slip_x[k]) for k in (near, stuck))
    if min(far, deep) < 0 or max(far, deep) >= len(x) or slip_x[far] == slip_x[near]:
        return 0.5 * (begins + ends)
    past = _steps_from_nil(abs(slip[near]), abs(slip[far]), power)
    left = _steps_from_nil(max(slack[stuck], 0.0), slack[deep], power)
    return begins - (begins - ends) * (past / (past + left) if past + left else 0.5)


def _steps_from_nil(value: float, following: float, power: float) -> float:
    """Return how many steps a value is from nil that grows with a power of the distance."""
    most = FARTHEST**power * following
    part = (value / following) ** (1 / power) if value < most else FARTHEST
    return part / (1 - part)


def _on_rigid(face: _Face, node: int, ahead: int) -> float:
    """Return where slip begins between ``node - 1`` and ``node`` on a rigid body: with a kink [m].

    The traction may jump there, so that the slack tells nothing.
    """
    x, slip_x, slip, _ = face
    near = node if ahead == 1 else node - 1
    far = near + ahead
    border = 0.5 * (slip_x[node] + slip_x[node - 1])
    if not 0 < far < len(x) - 1:
        return border
    v, w = abs(slip[near]), abs(slip[far])
    at, beyond, stick = slip_x[near], slip_x[far], slip_x[near - ahead]
    if w <= v:
        return border
    root = at - v * (beyond - at) / (w - v)
    return min(max(root, min(stick, at)), max(stick, at))


def slip_lengths(
    x: Array, slip_x: Array, zones: Array, slip: Array, slack: Array, *, rigid: bool,
    share: float | None = None,
) -> tuple[float, float]:  # fmt: skip
    """Return the lengths over which a face slips one way from its leading and trailing edge [m].

    Parameters
    ----------
    x, slip_x, zones, slip, slack : (M,) arrays
        Nodes [m], where the slips are taken [m], zones and slips of the face, and the bound less
        the traction's size [Pa].
    rigid : bool
        Whether the body behind the face is.
    share : float, optional
        Place borders so far from the node before them to the next one.  Without it they are placed
        by slip and slack, so that lengths vary smoothly.

    Returns
    -------
    (float, float)
        With the sign of the slip: > 0 where the web is the faster one; 0 where it sticks.
    """
    runs = Runs.of(x, slip_x, zones, slip, slack, rigid=rigid, share=share)
    return runs.slip_lengths(float(x[0]), float(x[-1]))


def _border(face: _Face, node: int, before: int, behind: int, rigid: bool) -> tuple[float, float]:
    """Return where the zone changes between ``node - 1`` and ``node`` [m], and at which share.

    A node changes as the border passes this share of the way from where its slip is taken to it.
    """
    if before * behind < 0:  # slip one way meets slip the other way
        return _crossing(face, node), 0.0
    ahead, law = (1, TRAILING) if before == 0 else (-1, LEADING)
    if rigid:
        return _on_rigid(face, node, ahead), 0.0
    return stick_ends(face, node, ahead, *law), law[1]


class Runs(NamedTuple):
    """The zones of a face in their order, and where each ends, with its share; by :meth:`of`."""

    zones: list[int]
    borders: list[tuple[float, float]]

    @classmethod
    def of(
        cls, x: Array, slip_x: Array, zones: Array, slip: Array, slack: Array, *, rigid: bool,
        share: float | None = None,
    ) -> Runs:  # fmt: skip
        """Return those of a solved face; see :func:`slip_lengths`."""
        nodes = ((zones[1:] != zones[:-1]).nonzero()[0] + 1).tolist()
        states = [int(zones[0]), *zones[nodes].tolist()]
        if share is not None:
            places = share * x[nodes] + (1 - share) * x[[node - 1 for node in nodes]]
            return cls(states, [(place, 0.0) for place in places.tolist()])
        face = _Face(*(part.tolist() for part in (x, slip_x, slip, slack)))  # single numbers
        pairs = zip(nodes, pairwise(states), strict=True)
        return cls(states, [_border(face, node, *pair, rigid) for node, pair in pairs])

    def slip_lengths(self, first: float, last: float) -> tuple[float, float]:
        """Return the slip lengths of a face from ``first`` to ``last``; see the function."""
        leading, trailing = self.zones[0], self.zones[-1]
        if not self.borders:
            return leading * (last - first), leading * (last - first)
        return leading * (self.borders[0][0] - first), trailing * (last - self.borders[-1][0])

    def on(self, x: Array, slip_x: Array) -> Array:
        """Return the zones of other nodes, whose slips are taken at ``slip_x``."""
        out = np.full(x.size, self.zones[0], dtype=np.int8)
        for zone, (place, share) in zip(self.zones[1:], self.borders, strict=True):
            out[int((slip_x + share * (x - slip_x)).searchsorted(place)) :] = zone
        return out


def _crossing(face: _Face, node: int) -> float:
    """Return where the slip changes its sign between ``node - 1`` and ``node`` [m]."""
    x, slip_x, slip, _ = face
    (v, w), (left, right) = slip[node - 1 : node + 1], slip_x[node - 1 : node + 1]
    at = left - v * (right - left) / (w - v) if w != v else x[node]
    return min(max(at, x[node - 1]), x[node])
