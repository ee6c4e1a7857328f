r"""What a mesh leaves open of a border of stick: where within its cell it lies.

Zones end between nodes, so that a border is known to a cell.  As it passes through one, the node on
this side and then that on the other side would change its law; what all unknowns change by when
either takes its neighbour's law is how much the place of the border matters to them.  Where slip
meets slip the other way there is stick between, too short to be seen, and so there is slip before
the first and behind the last node of a face that sticks.  Borders of two faces that lie side by
side hold each other: there what both nodes change together beyond what each does alone counts too.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from .joint import Joint
from .stick_slip import StickSlipSolution

__all__ = ["by_turning"]

Array = np.ndarray

BESIDE = 2  # nodes between two borders that hold each other, at most


def by_turning(joint: Joint, solution: StickSlipSolution, faces: int) -> Array:
    """Return the changes of all unknowns by each turn, and by pairs beyond those, (k, n + m + 2).

    Parameters
    ----------
    joint : Joint
        The system that the solution is of.
    solution : StickSlipSolution
    faces : int
        Of as many nodes each.
    """
    turns = np.array(list(_turns(solution, faces)), dtype=np.intp).reshape(-1, 2)
    nodes, ways = turns.T
    effects = joint.effects(solution.joint[0], nodes)
    laws = joint.laws(nodes, ways) @ effects.T  # of each turn, by each effect
    left = solution.traction[nodes] - ways * solution.bound[nodes]
    misses = np.where(ways == 0, solution.slip[nodes], left)
    with np.errstate(divide="ignore", invalid="ignore"):  # states that have no solution
        alone = -misses / np.diag(laws)
        one, two = _pairs(nodes, solution.state.size // faces)
        both = laws[one, one] * laws[two, two] - laws[one, two] * laws[two, one]
        first = (misses[two] * laws[one, two] - misses[one] * laws[two, two]) / both - alone[one]
        second = (misses[one] * laws[two, one] - misses[two] * laws[one, one]) / both - alone[two]
        changes = np.concatenate([
            alone[:, None] * effects,
            first[:, None] * effects[one] + second[:, None] * effects[two],
        ])  # fmt: skip
    return np.asarray(changes[np.isfinite(changes).all(axis=1)])


def _turns(solution: StickSlipSolution, faces: int) -> Iterator[tuple[int, int]]:
    """Yield nodes beside borders, and the state that each turns to."""
    for first, face in enumerate(np.split(solution.state, faces)):
        first *= face.size
        for node in (face[1:] != face[:-1]).nonzero()[0].tolist():
            before, behind = int(face[node]), int(face[node + 1])
            yield first + node, behind if before == 0 else 0
            yield first + node + 1, before if behind == 0 else 0
        for node in (first, first + face.size - 1):
            if solution.state[node] == 0:
                yield node, 1 if solution.traction[node] > 0 else -1


def _pairs(nodes: Array, size: int) -> tuple[Array, Array]:
    """Return which turns are of two faces and side by side."""
    faces, places = np.divmod(nodes, size)
    beside = np.abs(places - places[:, None]) <= BESIDE
    one, two = np.triu(beside & (faces != faces[:, None])).nonzero()
    return one, two
