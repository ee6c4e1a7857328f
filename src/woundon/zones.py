"""The zones of a contact as runs of one state, for drawing."""

from __future__ import annotations

from itertools import groupby

import numpy as np

from .results import Zone

__all__ = ["zone_runs"]


def zone_runs(x: np.ndarray, zones: np.ndarray) -> list[tuple[Zone, float, float]]:
    """Return runs (zone, from, to) [m] along the nip, zone borders half-way between nodes."""
    borders = np.concatenate([x[:1], (x[1:] + x[:-1]) / 2, x[-1:]]).tolist()
    runs: list[tuple[Zone, float, float]] = []
    first = 0
    for zone, members in groupby(zones.tolist()):
        last = first + len(list(members))
        runs.append((Zone(zone), borders[first], borders[last]))
        first = last
    return runs
