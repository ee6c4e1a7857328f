r"""What a mesh leaves open of a border of stick: where within its cell it lies.

Zones end between nodes, so that a border is known to a cell.  As it passes through one, the node on
this side and then that on the other side would change its law; what all unknowns change by when
either takes its neighbour's law is how much the place of the border matters to them.  Where slip
meets slip the other way there is stick between, too short to be seen, and so there is slip before
the first and behind the last node of a face that sticks.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from .joint import Joint
from .stick_slip import StickSlipSolution

__all__ = ["by_turning"]

Array = np.ndarray


def by_turning(joint: Joint, solution: StickSlipSolution, faces: int) -> Array:
    """Return the changes of all unknowns by each node beside a border that turns, (k, n + m + 2).

    Parameters
    ----------
    joint : Joint
        The system that the solution is of.
    solution : StickSlipSolution
    faces : int
        Of as many nodes each.
    """
    turns = [_turned(joint, solution, *turn) for turn in _turns(solution, faces)]
    changes = np.array(turns).reshape(len(turns), joint.matrix.shape[1])
    return np.asarray(changes[np.isfinite(changes).all(axis=1)])


def _turns(solution: StickSlipSolution, faces: int) -> Iterator[tuple[int, int]]:
    """Yield nodes beside borders and the states they turn to."""
    for first, face in enumerate(np.split(solution.state, faces)):
        first *= face.size
        for node in (face[1:] != face[:-1]).nonzero()[0].tolist():
            before, behind = int(face[node]), int(face[node + 1])
            yield first + node, behind if before == 0 else 0
            yield first + node + 1, before if behind == 0 else 0
        for node in (first, first + face.size - 1):
            if solution.state[node] == 0:
                yield node, 1 if solution.traction[node] > 0 else -1


def _turned(joint: Joint, solution: StickSlipSolution, node: int, state: int) -> Array:
    """Return the changes of all unknowns as one node turns to stick, or from it to slip."""
    n, factors = joint.unknowns, solution.joint[0]
    row, column = n + 2 + node, n + 1 + node
    if state == 0:
        change = joint.step(factors, -joint.matrix[:, column])
        change[column] += 1.0
        missed, by_one = solution.slip[node], joint.matrix[row] @ change
    else:
        right = np.zeros(len(joint.matrix))
        right[row] = 1.0
        change = joint.step(factors, right)
        missed = solution.traction[node] - state * solution.bound[node]
        by_one = change[column] - state * joint.bounds(change[:n])[node]
    return np.asarray(change * (-missed / by_one if by_one else np.nan))
