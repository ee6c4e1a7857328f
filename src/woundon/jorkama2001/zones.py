"""Stick and slip along a nip as runs of one zone, and the thesis's slip ratios from them.

The ratios run between the thesis's points A, B and C.  A ends the leading slip at the roll, B
begins the forward slip there, C ends the stick at the drum.  The roll may stick again for a short
length around C, at heavy loads for instance; that is not taken off s_r2 and s_d, which run from B
and C to the trailing edge.  A face that slips all over counts as its trailing zone.  The sign of
s_d is that of the slip at the drum, because at the roll the web is always the faster one there.

The thesis took the nodes for the points, which makes its curves jagged; so do results of its
procedure here.  In other results the slip is extrapolated to zero, and the lengths vary smoothly.
"""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np

import woundon as wo

from .procedure import ProcedureResult

__all__ = ["Run", "ZoneLengths", "longest_stick", "runs", "zone_lengths"]

Array = np.ndarray

# exponent of the slip over the distance from the point where it begins: downstream of A slip
# vanishes and the traction leaves its bound smoothly,
# at B it sets in with a vertical tangent, at C with a kink
POWER_A, POWER_B, POWER_C = 1.5, 0.5, 1.0


class Run(NamedTuple):
    """Neighbouring nodes in one zone: the first, and one past the last; from where to where.

    ``zone`` is 0 in stick, 1 or -1 for a web faster or slower.  The boundaries ``left`` and
    ``right`` lie half-way between nodes, in the unit of x.
    """

    zone: int
    first: int
    end: int
    left: float
    right: float

    @property
    def length(self) -> float:
        """Length between the zone boundaries."""
        return self.right - self.left


class ZoneLengths(NamedTuple):
    """Slip lengths over the nip width: s_r1, s_r2, s_d of thesis eq. (172)."""

    leading_roll: float
    trailing_roll: float
    dual: float


def runs(x: Array, zones: Array) -> list[Run]:
    """Return the runs of one zone along x, both (M,)."""
    boundaries = np.concatenate([x[:1], (x[1:] + x[:-1]) / 2, x[-1:]])
    ends = [0, *(np.flatnonzero(np.diff(zones)) + 1).tolist(), zones.size]
    return [
        Run(int(zones[a]), a, b, float(boundaries[a]), float(boundaries[b]))
        for a, b in pairwise(ends)
    ]


def longest_stick(zones: list[Run]) -> int | None:
    """Return the index of the longest stick zone by its nodes, None if all nodes slip."""
    sticks = [k for k, run in enumerate(zones) if run.zone == 0]
    return max(sticks, key=lambda k: zones[k].end - zones[k].first, default=None)


def zone_lengths(result: wo.NipResult | ProcedureResult) -> ZoneLengths:
    """Measure the slip zones of a nip between the thesis's points A, B and C."""
    roll, dual = runs(result.x, result.roll_zone), _dual(result)
    if all(run.zone != 0 for run in roll):  # it counts as the trailing zone
        return ZoneLengths(0.0, float(roll[-1].zone), dual)
    leading = roll[0].zone
    first = next(k for k, run in enumerate(roll) if run.zone == 0)
    begins = next((run for run in roll[first:] if run.zone != 0), None)
    slip = result.roll_slip
    A = _share(result, slip, roll[first].first, -1, POWER_A) if leading else 0.0
    trailing = 0.0
    if begins is not None:
        trailing = begins.zone * (1 - _share(result, slip, begins.first, 1, POWER_B))
    return ZoneLengths(leading * A, trailing, dual)


def _dual(result: wo.NipResult | ProcedureResult) -> float:
    """Return s_d, from the end of the drum's longest stick zone."""
    drum = runs(result.x, result.drum_zone)
    k = longest_stick(drum)
    if k is None:
        return float(drum[-1].zone)
    if k + 1 == len(drum):
        return 0.0
    return drum[k + 1].zone * (1 - _share(result, result.drum_slip, drum[k].end, 1, POWER_C))


def _share(
    result: wo.NipResult | ProcedureResult, slip: Array, node: int, ahead: int, power: float
) -> float:
    """Return the start of slip as a fraction of the nip width from the leading edge.

    Parameters
    ----------
    result : NipResult or ProcedureResult
    slip : (M,) array
        v+ or v-.
    node : int
        The boundary lies between ``node - 1`` and ``node``.
    ahead : {1, -1}
        1 if the slip zone lies downstream of the boundary, -1 if upstream.
    power : float
        Exponent of the slip velocity over the distance from the boundary, which is extrapolated
        from the first two slip nodes.
    """
    x = result.x
    boundary = float(x[node] + x[node - 1]) / 2
    near = node if ahead == 1 else node - 1  # the first two slip nodes
    far = near + ahead
    if not isinstance(result, ProcedureResult) and 0 < far < x.size - 1:
        v = np.abs(slip[[near, far]]) ** (1 / power)
        at = result.slip_x[[near, far]]
        stick = float(result.slip_x[near - ahead])
        # v^(1/power) is linear; its root is limited to the cell between the stick and the slip node
        if v[1] > v[0]:
            root = float(at[0] - v[0] * (at[1] - at[0]) / (v[1] - v[0]))
            boundary = min(max(root, min(stick, at[0])), max(stick, at[0]))
    return boundary / (2 * result.half_width) + 0.5
