r"""What a mesh leaves open of a border of stick: where within its cell it lies.

Zones end between nodes, so that a border is known to a cell.  As it passes through one, the node on
this side and then that on the other side would change its law; what all unknowns change by when
either takes its neighbour's law is how much the place of the border matters to them.  Where slip
meets slip the other way there is stick between, too short to be seen, and so there is slip before
the first and behind the last node of a face that sticks.  Borders of two faces that lie side by
side hold each other: there what both nodes change together beyond what each does alone counts too.

A node that turns may miss its former law, by c: slip where it stuck, more or less than s mu p where
it slipped.  Its effect is what all unknowns change by with c = 1.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from .joint import Joint
from .stick_slip import StickSlipSolution

__all__ = ["by_turning"]

Array = np.ndarray
Turn = tuple[int, int]  # a node, and the state that it turns to

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
    turns = list(_turns(solution, faces))
    if not turns:
        return np.empty((0, joint.matrix.shape[1]))
    effects = np.array([_effect(joint, solution, node) for node, _ in turns])
    misses, laws = _laws(joint, solution, turns, effects)
    with np.errstate(divide="ignore", invalid="ignore"):  # states that have no solution
        alone = -misses / np.diag(laws)
        one, two = _pairs(np.array([node for node, _ in turns]), solution.state.size // faces)
        both = laws[one, one] * laws[two, two] - laws[one, two] * laws[two, one]
        first = (misses[two] * laws[one, two] - misses[one] * laws[two, two]) / both - alone[one]
        second = (misses[one] * laws[two, one] - misses[two] * laws[one, one]) / both - alone[two]
        changes = np.concatenate([
            alone[:, None] * effects,
            first[:, None] * effects[one] + second[:, None] * effects[two],
        ])  # fmt: skip
    return np.asarray(changes[np.isfinite(changes).all(axis=1)])


def _turns(solution: StickSlipSolution, faces: int) -> Iterator[Turn]:
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


def _effect(joint: Joint, solution: StickSlipSolution, node: int) -> Array:
    n, factors = joint.unknowns, solution.joint[0]
    if solution.state[node] == 0:
        right = np.zeros(len(joint.matrix))
        right[n + 2 + node] = 1.0
        return joint.step(factors, right)
    effect = joint.step(factors, -joint.matrix[:, n + 1 + node])
    effect[n + 1 + node] += 1.0
    return effect


def _laws(
    joint: Joint, solution: StickSlipSolution, turns: Sequence[Turn], effects: Array
) -> tuple[Array, Array]:
    """Return what new laws are missed by, (k,), and by how much more with each effect, (k, k)."""
    n = joint.unknowns
    nodes, states = np.array(turns).T
    slips = joint.matrix[n + 2 + nodes] @ effects.T
    bounds = np.array([joint.bounds(effect[:n])[nodes] for effect in effects]).T
    tractions = effects[:, n + 1 + nodes].T - states[:, None] * bounds
    left = solution.traction[nodes] - states * solution.bound[nodes]
    stuck = states == 0
    return np.where(stuck, solution.slip[nodes], left), np.where(stuck[:, None], slips, tractions)
