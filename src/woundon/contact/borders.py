r"""What a mesh leaves open of a border of stick: where within its cell it lies.

Zones end between nodes, so that a border is known to a cell.  What all unknowns change by as it is
moved over nodes, which take the law of those on its other side, follows from the factors at hand.

At its true place a border leaves no root singularity behind, and there the outputs are stationary:
moved by u cells from it they change by E u^2/2, to leading order.  So a parabola through the
changes by one node either way tells where the border is at rest, and what the outputs are there;
with the changes by two nodes it is a quartic.  A mesh's own outputs miss these by up to E/8, here
much, there nothing, as its nodes happen to lie.

Where slip meets slip the other way there is stick between, too short to be seen, and so there is
slip before the first and behind the last node of a face that sticks.  Borders that lie side by side
hold each other: there what both change together beyond what each does alone is left open too.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations
from typing import NamedTuple

import numpy as np

from .joint import Joint
from .stick_slip import StickSlipSolution

__all__ = ["Moved", "at_rest", "by_turning"]

Array = np.ndarray

BESIDE = 2  # nodes between two borders that hold each other, at most
ALIKE = 2.0  # times the curvature one node on: beyond, the changes are no parabola's
FARTHEST = 0.75  # nodes that a border may be from its place of rest; half a node and a margin

# what outputs of random nips err by, once borders rest, of their changes: by borders at rest, by how
# unlike these are on both sides, by borders that come to no rest, by stick that is not seen, and by
# borders that hold each other (the most likely ones for errors of 600 nips on 33 to 129 nodes, as
# Student's t of 2 degrees of freedom)
RESTING, UNLIKE, RESTLESS, UNSEEN, HELD = 0.025, 0.12, 0.08, 0.2, 0.05


class Moved(NamedTuple):
    """Changes of outputs as borders move.

    ``by_nodes`` are those by -2, -1, 1 and 2 nodes of each border, (borders, 4, outputs), nan where
    a zone has not so many; ``unseen`` those by stick that is not seen, and ``held`` what two
    borders side by side change beyond what each does, (k, outputs).
    """

    by_nodes: Array
    unseen: Array
    held: Array


def by_turning(joint: Joint, solution: StickSlipSolution, faces: int, gradients: Array) -> Moved:
    """Return the changes of outputs as each border moves.

    Parameters
    ----------
    joint : Joint
        The system that the solution is of.
    solution : StickSlipSolution
    faces : int
        Of as many nodes each.
    gradients : (n + m + 2, outputs) array
        Of outputs by unknowns.
    """
    size = solution.state.size // faces
    borders, others = list(_borders(solution, size)), list(_others(solution, size))
    turns = [turn for border in borders for turn in border] + others
    nodes, ways = np.array(turns, dtype=np.intp).reshape(-1, 2).T
    effects = joint.effects(solution.joint[0], nodes)
    laws = joint.laws(nodes, ways) @ effects.T  # of each turn, by each effect
    left = solution.traction[nodes] - ways * solution.bound[nodes]
    misses = np.where(ways == 0, solution.slip[nodes], left)
    changes = effects @ gradients

    def together(one: Array, two: Array) -> Array:
        both = laws[one, one] * laws[two, two] - laws[one, two] * laws[two, one]
        first = (misses[two] * laws[one, two] - misses[one] * laws[two, two]) / both
        second = (misses[one] * laws[two, one] - misses[two] * laws[one, one]) / both
        return np.asarray(first[:, None] * changes[one] + second[:, None] * changes[two])

    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):  # states without solution
        alone = (-misses / np.diag(laws))[:, None] * changes
        far, near = 4 * np.arange(len(borders))[:, None] + [[0, 3]], [1, 2]
        by_nodes = alone[: 4 * len(borders)].reshape(len(borders), 4, -1)
        twice = together(far.ravel(), (far + [[1, -1]]).ravel()).reshape(len(borders), 2, -1)
        reach = nodes[far] != nodes[far + [[1, -1]]]
        by_nodes[:, [0, 3]] = np.where(reach[:, :, None], twice, np.nan)
        asked = [4 * k + j for k in range(len(borders)) for j in near]
        asked += range(4 * len(borders), len(turns))
        one, two = np.array(list(_pairs(asked, nodes.tolist(), size)), np.intp).reshape(-1, 2).T
        beyond = together(one, two) - alone[one] - alone[two]
    return Moved(by_nodes, alone[4 * len(borders) :], beyond)


def at_rest(moved: Moved) -> tuple[Array, Array]:
    """Return what outputs change by as borders come to rest, and what they may err by then.

    Returns
    -------
    (outputs,) array, (outputs,) array
        Borders whose changes are not alike on both sides are left where they are.
    """
    rest, known, unlike = _rests(moved.by_nodes)
    near = np.hypot(moved.by_nodes[:, 1], moved.by_nodes[:, 2])
    size = np.where(known, np.hypot(RESTING * near, UNLIKE * unlike), RESTLESS * near)
    parts = size, UNSEEN * moved.unseen, HELD * moved.held
    squares = [np.square(part)[np.isfinite(part).all(axis=1)].sum(axis=0) for part in parts]
    return rest.sum(axis=0), np.sqrt(np.sum(squares, axis=0))


def _rests(by_nodes: Array) -> tuple[Array, Array, Array]:
    """Return changes to rest, where they are known, and by how much both sides differ."""
    two_back, back, on, two_on = by_nodes.transpose(1, 0, 2)
    with np.errstate(all="ignore"):
        bend = back + on
        # a side that is too short continues the other one's cubic, and both the parabola
        flat = 2 * bend
        bends = (two_back - 2 * back) / bend, (two_on - 2 * on) / bend
        alike = [np.isnan(part) | ((part * ALIKE >= 1) & (part <= ALIKE)) for part in bends]
        unlike = bend * np.sqrt(np.nanmean((np.array(bends) - 1) ** 2, axis=0))
        cubic_back, cubic_on = 2 * flat - two_on, 2 * flat - two_back
        two_back, two_on = (
            np.where(np.isnan(own), np.where(np.isnan(other), flat + sign * (on - back), cubic), own)
            for own, other, cubic, sign in (
                (two_back, two_on, cubic_back, -2), (two_on, two_back, cubic_on, 2),
            )
        )  # fmt: skip
        slope = (two_back - 8 * back + 8 * on - two_on) / 12
        second = (16 * bend - two_back - two_on) / 24
        third = (2 * back - two_back - 2 * on + two_on) / 12
        fourth = (two_back - 4 * bend + two_on) / 24
        u = (back - on) / (2 * bend)
        for _ in range(2):  # from the parabola's vertex to the quartic's, by Newton's method
            steep = slope + u * (2 * second + u * (3 * third + u * 4 * fourth))
            u = u - steep / (2 * second + u * (6 * third + u * 12 * fourth))
        rest = u * (slope + u * (second + u * (third + u * fourth)))
        told = ~np.isnan(by_nodes[:, 0]) | ~np.isnan(by_nodes[:, 3])
        known = told & alike[0] & alike[1] & (back * on >= 0) & (np.abs(u) <= FARTHEST)
    known &= np.isfinite(rest)
    return np.where(known, rest, 0.0), known, unlike


Turn = tuple[int, int]  # a node, and the state that it turns to


def _borders(solution: StickSlipSolution, size: int) -> Iterator[list[Turn]]:
    """Yield, of each border of stick, the turns of the two nodes before and the two behind it.

    The outer one of a zone that has but one is that one again.  Faces are of one size.
    """
    states = solution.state.tolist()
    for first in range(0, len(states), size):
        last = first + size - 1
        for node in range(first, last):
            before, behind = states[node], states[node + 1]
            if before == behind or before * behind:
                continue
            back = node - 1 if node > first and states[node - 1] == before else node
            on = node + 2 if node + 1 < last and states[node + 2] == behind else node + 1
            yield [(back, behind), (node, behind), (node + 1, before), (on, before)]


def _others(solution: StickSlipSolution, size: int) -> Iterator[Turn]:
    """Yield turns of nodes beside stick that is not seen, and of those that stick at an edge."""
    states = solution.state.tolist()
    for first in range(0, len(states), size):
        last = first + size - 1
        for node in range(first, last):
            if states[node] * states[node + 1] < 0:
                yield node, 0
                yield node + 1, 0
        for node in (first, last):
            if states[node] == 0:
                yield node, 1 if solution.traction[node] > 0 else -1


def _pairs(asked: Sequence[int], nodes: Sequence[int], size: int) -> Iterator[Turn]:
    """Yield which turns are side by side, of two faces."""
    places = [divmod(nodes[k], size) for k in asked]
    for (i, one), (j, two) in combinations(zip(asked, places, strict=True), 2):
        if one[0] != two[0] and abs(one[1] - two[1]) <= BESIDE:
            yield i, j
