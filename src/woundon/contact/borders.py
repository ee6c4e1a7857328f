r"""What a mesh leaves open of a border of stick: where within its cell it lies.

Zones end between nodes, so that a border is known to a cell.  As it passes through one, the node on
this side and then that on the other side would change its law; what all unknowns change by when
either takes its neighbour's law is how much the place of the border matters to them.  Where slip
meets slip the other way there is stick between, too short to be seen, and so there is slip before
the first and behind the last node of a face that sticks.  Borders of two faces that lie side by
side hold each other: there what both nodes change together beyond what each does alone counts too.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations

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
    size = solution.state.size // faces
    held = joint.held[solution.state.take(joint.held) == 0].tolist()
    alone = held if len(held) == 1 else []  # without it nothing holds the creep
    turns = [turn for turn in _turns(solution, size) if turn[0] not in alone]
    nodes, ways = np.array(turns, dtype=np.intp).reshape(-1, 2).T
    effects = joint.effects(solution.joint[0], nodes)
    laws = joint.laws(nodes, ways) @ effects.T  # of each turn, by each effect
    left = solution.traction[nodes] - ways * solution.bound[nodes]
    misses = np.where(ways == 0, solution.slip[nodes], left)
    with np.errstate(divide="ignore", invalid="ignore"):  # states that have no solution
        single = -misses / np.diag(laws)
        changes = single[:, None] * effects
        pairs = list(_pairs([node for node, _ in turns], size))
        if pairs:
            one, two = np.array(pairs).T
            both = laws[one, one] * laws[two, two] - laws[one, two] * laws[two, one]
            first = (misses[two] * laws[one, two] - misses[one] * laws[two, two]) / both
            second = (misses[one] * laws[two, one] - misses[two] * laws[one, one]) / both
            beyond = (first - single[one])[:, None] * effects[one]
            beyond += (second - single[two])[:, None] * effects[two]
            changes = np.concatenate([changes, beyond])
        return np.asarray(changes[np.isfinite(changes.sum(axis=1))])


def _turns(solution: StickSlipSolution, size: int) -> Iterator[tuple[int, int]]:
    """Yield nodes beside borders, and the state that each turns to; faces are of one size."""
    states = solution.state.tolist()
    for first in range(0, len(states), size):
        last = first + size - 1
        for node in range(first, last):
            before, behind = states[node], states[node + 1]
            if before != behind:
                yield node, behind if before == 0 else 0
                yield node + 1, before if behind == 0 else 0
        for node in (first, last):
            if states[node] == 0:
                yield node, 1 if solution.traction[node] > 0 else -1


def _pairs(nodes: Sequence[int], size: int) -> Iterator[tuple[int, int]]:
    """Yield which of some nodes are of two faces and side by side."""
    places = [divmod(node, size) for node in nodes]
    for (i, one), (j, two) in combinations(enumerate(places), 2):
        if one[0] != two[0] and abs(one[1] - two[1]) <= BESIDE:
            yield i, j
