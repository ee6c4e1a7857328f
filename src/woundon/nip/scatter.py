"""What a nip's outputs owe to where within their cells its zones end."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from itertools import pairwise
from math import hypot
from typing import Any

import numpy as np

from ..contact.borders import by_turning
from ..contact.levels import Level
from ..contact.told import Foreseen
from ..contact.zones import Runs

__all__ = ["by_borders", "unseen_stick"]

Array = np.ndarray

# what outputs err by in the middle of random nips, of their changes by nodes that turn at borders,
# and of what is usual where that is mostly these borders' doing; as how many changes this counts
BORDERS, REST, KNOWN = 0.08, 0.3, 2.0


def by_borders(problem: Any, level: Level, usual: Mapping[str, Foreseen]) -> dict[str, Foreseen]:
    """Return by how much outputs scatter on a mesh, by its borders and by what is usual."""
    found = dict(usual)
    for name, change in _by_turning(problem, level).items():
        rest = usual[name].size * (1.0 if usual[name].changes == KNOWN else REST)
        found[name] = Foreseen(hypot(BORDERS * change, rest), KNOWN)
    return found


def _by_turning(problem: Any, level: Level) -> dict[str, float]:
    """Return the changes of outputs by each node that turns beside a border, as a root sum square.

    At the load asked, to first order; nothing where stick and slip were not solved for jointly.
    """
    solution, joint = level.state.solution, level.equations.joint
    if joint is None or solution.joint is None:
        return {}
    changes, n = by_turning(joint, solution, faces=2), joint.unknowns
    weights, p = level.equations.matrices.weights, level.state.pressure
    by_p, by_q = changes[:, :n], changes[:, n + 1 : -1].reshape(-1, 2, n).sum(axis=1)
    load, gain = by_p @ weights / level.load, by_q @ weights
    whole = float(weights @ solution.traction.reshape(2, n).sum(axis=0))
    top, wider = int(np.argmax(p)), load / level.power
    stretch = problem.web.compliance.c11 / problem.web.thickness
    changed = np.array([
        gain - load * whole,
        wider * level.half_width,
        by_p[:, top] - (load - wider) * p[top],
        changes[:, n] * problem.contact_radius,
        changes[:, -1] - stretch * gain,
    ])  # fmt: skip
    tension, width, peak, offset, creep = np.sqrt((changed**2).sum(axis=1)).tolist()
    return {
        "nip_induced_tension": tension, "tension_behind_nip": tension, "half_width": width,
        "nip_width": 2 * width, "peak_pressure": peak, "offset": offset, "drum_creep": creep,
    }  # fmt: skip


def unseen_stick(nodes: Array, faces: Iterable[Runs]) -> float:
    """Return by how much slip ratios err as stick that is shorter than its cell is not seen.

    It is where slip meets slip the other way, of up to a cell: half of it in the middle, and that
    of a width of 2a.
    """
    met = [
        place
        for face in faces
        for (one, two), (place, _) in zip(pairwise(face.zones), face.borders, strict=True)
        if one * two < 0
    ]
    ends = np.searchsorted(nodes[1:-1], met) + 1
    return float(np.max(nodes[ends] - nodes[ends - 1], initial=0.0)) / 4
