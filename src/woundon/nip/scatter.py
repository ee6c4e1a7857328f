"""What a nip's outputs owe to where within their cells its zones end."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..contact.borders import by_turning
from ..contact.levels import Level

__all__ = ["by_borders"]

Array = np.ndarray


def by_borders(problem: Any, level: Level) -> dict[str, float]:
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
