r"""What a mesh misses of the roll's strain at the trailing edge.

The wound-on condition refers the roll's strain to the trailing edge, where it is by the tractions q
nearby, at distances t, an integral of q/t.  They go like the root of t but for a length l on which
the web's thinning weighs against the bodies' compliance; there they go straight to nil, as on the
mesh they do over the whole last cell.  Where l is shorter than that cell, the mesh misses

    MISSED exp(-FADES sqrt(l/cell)) times the traction of the last node

of the integral: an error of first order, until such cells are as short as l.  Both numbers are of a
contact without friction by itself, solved on graded meshes and exactly (tests/verification).
"""

from __future__ import annotations

from math import exp, pi, sqrt
from typing import Any

import numpy as np

from ..contact.levels import Level
from ..contact.resting import Resting

__all__ = ["at_trailing_edge", "resting_at_trailing_edge"]

Array = np.ndarray

MISSED, FADES = 0.78, 3.4
SEEN = 6.0  # lengths l a cell, from which less than 2e-4 of a last traction is missed


def at_trailing_edge(problem: Any, level: Level, gradients: Array) -> Array | None:
    """Return what outputs change by with what the mesh misses, (outputs,); None if nothing.

    ``gradients`` are those of the outputs by the joint system's unknowns.
    """
    by_traction = _by_last_traction(problem, level, gradients)
    if by_traction is None:
        return None
    return by_traction * level.state.traction[level.equations.joint.unknowns - 1]


def resting_at_trailing_edge(problem: Any, level: Level, gradients: Array) -> Resting | None:
    """Return the same by the last traction, q = [(q - mu p) + (q + mu p)]/2."""
    by_traction, joint = _by_last_traction(problem, level, gradients), level.equations.joint
    if by_traction is None:
        return None
    last, halves = np.full(2, joint.unknowns - 1), by_traction / 2
    return Resting.of(joint, last, np.array([1.0, -1.0]), np.stack([halves, halves], axis=1))


def _by_last_traction(problem: Any, level: Level, gradients: Array) -> Array | None:
    """Return the changes by the traction of the last node.

    What a traction next to a point does to the bodies' slope and strain there, as the mesh has it,
    tells their compliances on the length of its cells, of any body.
    """
    joint, mesh, a = level.equations.joint, level.mesh, level.state.half_width
    n, inverse, cell = joint.unknowns, mesh.grid.inverse, a * float(mesh.grid.cells[-1])
    web, last = problem.web, n - 1
    thinning = problem.thinning
    if not web.linear:
        thinning = -float(web.thinned(level.state.pressure)[1][last])
    slope = (joint.matrix[n, last] - thinning / a * mesh.slope[n, last]) / inverse[n, last]
    if problem.roll.rigid or -thinning > SEEN * cell * pi * slope:
        return None
    stretch = a * web.compliance.c11 / web.thickness * mesh.behind[0, last]
    strain = (joint.matrix[n + 2, n + 1 + last] - stretch) / inverse[-1, last]
    missed = MISSED * exp(-FADES * sqrt(-thinning / (pi * slope * cell)))
    right = np.zeros(len(joint.matrix))
    right[n + 2 : 2 * n + 2] = -strain * missed  # in all slips on the roll
    return np.asarray(joint.step(level.state.solution.joint[0], right) @ gradients)
