r"""What a mesh leaves open of a border of stick: where within its cell it lies.

Zones end between nodes, so that a border is known to a cell.  What all unknowns change by as it is
moved over nodes, which take the law of those on its other side, follows from the factors at hand.

At its true place a border leaves no root singularity behind, and there the outputs are stationary:
moved by u cells from it they change by E u^2/2, to leading order.  So a parabola through the
changes by one node either way tells where the border is at rest, and what the outputs are there;
with the changes by two nodes it is a quartic.  A mesh's own outputs miss these by up to E/8, here
much, there nothing, as its nodes happen to lie.

Where slip meets slip the other way there is stick between, too short to be seen, and so there is
slip before the first and behind the last node of a face that sticks.  A border there is hidden
where the one node that would turn misses its law by nothing; so what the second one adds counts
too.  Borders that lie side by side hold each other: there what both change together beyond what
each does alone is left open too.  On a rigid body tractions jump instead: :mod:`.jumps`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations
from math import isfinite, isnan, nan
from typing import NamedTuple

import numpy as np

from .joint import Joint
from .jumps import Jumps, changing
from .stick_slip import StickSlipSolution

__all__ = ["Changes", "Moved", "at_rest", "by_turning", "rest_of", "turned"]

Array = np.ndarray

BESIDE = 2  # nodes between two borders that hold each other, at most
# times the curvature one node on: up to the one the changes count as a parabola's, from the other
# on no more, and in between by a share, lest outputs jump
ALIKE, OTHERWISE = 1.5, 2.5
FARTHEST = 0.75  # nodes that a border may be from its place of rest; half a node and a margin

# what outputs of random nips err by, once borders rest, of their changes: by borders at rest, by
# how unlike these are on both sides, by borders that come to no rest, by stick that is not seen,
# and by borders that hold each other (about the most likely ones for the errors of 600 nips on 33
# to 129 nodes, as Student's t of 2 degrees of freedom)
RESTING, UNLIKE, RESTLESS, UNSEEN, HELD = 0.025, 0.12, 0.08, 0.2, 0.05


Turn = tuple[int, int]  # a node, and the state that it turns to


class Moved(NamedTuple):
    """Changes of so many outputs as borders move; plain numbers, for there are few.

    ``by_nodes`` are those by -2, -1, 1 and 2 nodes of each border, (borders, 4, outputs), nan where
    a zone has not so many; ``unseen`` those by stick or slip that is not seen, ``bent`` what a
    second node at an edge changes beyond twice the first, and ``held`` what two borders side by
    side change beyond what each does, (k, outputs).
    """

    outputs: int
    by_nodes: list[list[list[float]]]
    unseen: list[list[float]]
    bent: list[list[float]]
    held: list[list[float]]


def by_turning(
    joint: Joint, solution: StickSlipSolution, faces: Sequence[Array], gradients: Array,
    open_ends: Sequence[int] = (), jumps: Jumps | None = None,
) -> Moved:  # fmt: skip
    """Return the changes of outputs as each border moves.

    Parameters
    ----------
    joint : Joint
        The system that the solution is of.
    solution : StickSlipSolution
    faces : sequence of int arrays
        The numbers of the nodes of each, in one row for all.
    gradients : (n + m + 2, outputs) array
        Of outputs by unknowns.
    open_ends : sequence of int
        Outermost nodes at which no edge is, so that they may stick.
    jumps : Jumps, optional
        Which are no borders.
    """
    crossed = jumps.crossed if jumps else frozenset[int]()
    edges = list(_edges(solution, faces, open_ends))
    seen = [*_meeting(solution, faces, crossed), *(edge[0] for edge in edges)]
    second = [edge[1] for edge in edges if len(edge) > 1]
    borders, nodes, _, laws, misses, effects, free = turned(
        joint, solution, faces, crossed, seen + second
    )
    changes = Changes(laws.tolist(), misses.tolist(), (effects @ gradients).tolist())
    held = changes.of_one_held(borders, free)
    changes.misses = np.where(free, nan, misses).tolist()
    by_nodes = [changes.of_border(4 * k, border) for k, border in enumerate(borders)] + held
    first, last = 4 * len(borders), nodes.size - len(second)
    near = [*(k + j for k in range(0, first, 4) for j in (1, 2)), *range(first, last)]
    unseen = [changes.of_one(k) for k in range(first, last)]
    ends = (last - len(edges) + k for k, edge in enumerate(edges) if len(edge) > 1)
    bent = [changes.of_bend(*pair) for pair in zip(ends, range(last, nodes.size), strict=True)]
    beside = [changes.of_pair(*pair) for pair in _pairs(near, nodes.tolist(), faces)]
    return Moved(gradients.shape[1], by_nodes, unseen, bent, beside)


def turned(
    joint: Joint, solution: StickSlipSolution, faces: Sequence[Array],
    crossed: frozenset[int], others: Sequence[Turn],
) -> tuple[list[list[Turn]], Array, Array, Array, Array, Array, Array]:  # fmt: skip
    """Return borders, nodes that turn and their ways, (turns,) each, laws, misses and effects.

    The laws (turns, turns) are those of each turn by each effect, the effects (turns, n + m + 2).
    Last, which turns are of the one node that holds the creep, which nothing would hold then.
    """
    borders = list(_borders(solution, faces, crossed))
    turns = [*(turn for border in borders for turn in border), *others]
    nodes, ways = np.array(turns, dtype=np.intp).reshape(-1, 2).T
    effects = joint.effects(solution.joint[0], nodes)
    laws = joint.laws(nodes, ways) @ effects.T
    left = solution.traction[nodes] - ways * solution.bound[nodes]
    misses = np.where(ways == 0, solution.slip[nodes], left)
    holding = joint.held[solution.state.take(joint.held) == 0]
    free = np.isin(nodes, holding) if holding.size == 1 else np.zeros(nodes.size, dtype=bool)
    return borders, nodes, ways, laws, misses, effects, free


class Changes:
    """Changes of outputs by turned nodes, as plain numbers: there are few.

    Parameters
    ----------
    laws : (k, k) numbers
        The new laws of each turn, by each effect.
    misses : (k,) numbers
        What they miss as yet.
    by_effects : (k, outputs) numbers
    """

    def __init__(
        self, laws: list[list[float]], misses: list[float], by_effects: list[list[float]]
    ) -> None:
        self.laws, self.misses, self.by_effects = laws, misses, by_effects
        self.unknown = [nan] * len(by_effects[0]) if by_effects else []

    def of_one(self, node: int) -> list[float]:
        """Return them where one node turns."""
        law = self.laws[node][node]
        step = -self.misses[node] / law if law else nan
        return [step * change for change in self.by_effects[node]]

    def of_border(self, first: int, border: list[Turn]) -> list[list[float]]:
        """Return the changes where a border moves by -2, -1, 1 and 2 nodes."""
        back, on = (border[j] != border[j + 1] for j in (0, 2))  # no zones of one node
        return [
            self.of_two(first, first + 1) if back else self.unknown,
            self.of_one(first + 1), self.of_one(first + 2),
            self.of_two(first + 2, first + 3) if on else self.unknown,
        ]  # fmt: skip

    def of_one_held(self, borders: Sequence[list[Turn]], free: Array) -> list[list[list[float]]]:
        """Return them where the one node that holds the creep is followed by that beside it.

        As of a border that moves by -1 and 1 nodes; nothing where there is no such node.
        """
        own = [4 * k for k in range(len(borders)) if free[4 * k + 1] or free[4 * k + 2]]
        if len(own) != 2:
            return []
        moves = [self.of_two(own[0] + turn, own[1] + turn) for turn in (1, 2)]
        return [[self.unknown, *moves, self.unknown]]

    def of_two(self, one: int, two: int) -> list[float]:
        """Return them where two nodes turn at once."""
        (a, b), (c, d) = ((self.laws[k][one], self.laws[k][two]) for k in (one, two))
        both = a * d - b * c
        if not both:  # no such state
            return self.unknown
        miss, other = self.misses[one], self.misses[two]
        step, further = (other * b - miss * d) / both, (miss * c - other * a) / both
        pairs = zip(self.by_effects[one], self.by_effects[two], strict=True)
        return [step * change + further * second for change, second in pairs]

    def of_bend(self, one: int, two: int) -> list[float]:
        """Return what two nodes that turn change beyond twice what the first one does."""
        pairs = zip(self.of_two(one, two), self.of_one(one), strict=True)
        return [both - 2 * first for both, first in pairs]

    def of_pair(self, one: int, two: int) -> list[float]:
        """Return what two nodes that turn at once change beyond what each does alone."""
        each = self.of_two(one, two), self.of_one(one), self.of_one(two)
        return [both - first - second for both, first, second in zip(*each, strict=True)]


def at_rest(moved: Moved, *others: tuple[Array, Array]) -> tuple[Array, Array]:
    """Return what outputs change by as borders come to rest, and what they may err by then.

    Parameters
    ----------
    moved : Moved
    others : ((outputs,) array, (outputs,) array)
        Further changes, and by how much they may err.

    Returns
    -------
    (outputs,) array, (outputs,) array
        Borders whose changes are not alike on both sides are left where they are.
    """
    rests, squares = [0.0] * moved.outputs, [0.0] * moved.outputs
    for border in moved.by_nodes:
        found = [rest_of(*changes) for changes in zip(*border, strict=True)]
        if all(isfinite(square) for _, square in found):  # else of states without a solution
            for k, (rest, square) in enumerate(found):
                rests[k] += rest
                squares[k] += square
    shares = (UNSEEN, moved.unseen), (RESTING, moved.bent), (HELD, moved.held)
    for share, left in shares:
        for each in left:
            if all(map(isfinite, each)):
                for k, change in enumerate(each):
                    off = share * change
                    squares[k] += off * off  # a power would raise where this is inf
    all_rests, all_squares = np.array(rests), np.array(squares)
    for changes, errors in others:
        all_rests += changes
        all_squares += errors * errors
    return all_rests, np.sqrt(all_squares)


def rest_of(two_back: float, back: float, on: float, two_on: float) -> tuple[float, float]:
    """Return what an output changes by as a border comes to rest, and the square of its error then.

    Parameters
    ----------
    two_back, back, on, two_on : float
        Its changes by -2, -1, 1 and 2 nodes, nan where there are no two.

    Returns
    -------
    (float, float)
        From the vertex of a parabola that of the quartic is sought by one step of Newton's method,
        whose error is of fourth order there.
    """
    near, bend = back * back + on * on, back + on
    unmoved = 0.0, RESTLESS**2 * near
    if not back * on >= 0 or bend == 0:
        return unmoved
    if isnan(two_back):  # goes on as a cubic of what there is
        two_back = 4 * bend - two_on
        behind = before = (two_on - 2 * on) / bend
    else:
        before = (two_back - 2 * back) / bend
        behind = before if isnan(two_on) else (two_on - 2 * on) / bend
        two_on = 4 * bend - two_back if isnan(two_on) else two_on
    least = min(before, behind)
    if not least > 0:
        return unmoved
    share = (OTHERWISE - max(before, behind, 1 / least)) / (OTHERWISE - ALIKE)
    # the quartic's coefficients
    first = (two_back - two_on - 8 * (back - on)) / 12
    second = (16 * bend - two_back - two_on) / 24
    third = (two_on - two_back + 2 * (back - on)) / 12
    fourth = (two_back + two_on - 4 * bend) / 24
    u = first / (-2 * second) if second else FARTHEST
    if not (share > 0 and abs(u) < FARTHEST):
        return unmoved
    share = min(share, 1.0)
    slope = u * u * (3 * third + 4 * u * fourth)
    curvature = 2 * second + 6 * u * (third + 2 * u * fourth)
    rest = u * (first / 2 + u * u * (third + u * fourth)) - slope * slope / (2 * curvature)
    unlike = ((before - 1) ** 2 + (behind - 1) ** 2) / 2 * bend * bend
    resting = RESTING**2 * near + UNLIKE**2 * unlike
    return share * rest, unmoved[1] + share * (resting - unmoved[1])


def _ends(faces: Sequence[Array]) -> Iterator[tuple[int, int]]:
    """Yield the first and the last node of each face."""
    first = 0
    for face in faces:
        yield first, first + face.size - 1
        first += face.size


def _borders(
    solution: StickSlipSolution, faces: Sequence[Array], crossed: frozenset[int]
) -> Iterator[list[Turn]]:
    """Yield, of each border of stick, the turns of the two nodes before and the two behind it.

    The outer one of a zone that has but one is that one again.
    """
    states = solution.state.tolist()
    for first, last, node in _changing(solution, faces, crossed):
        before, behind = states[node], states[node + 1]
        if before * behind == 0:
            back = node - 1 if node > first and states[node - 1] == before else node
            on = node + 2 if node + 1 < last and states[node + 2] == behind else node + 1
            yield [(back, behind), (node, behind), (node + 1, before), (on, before)]


def _meeting(
    solution: StickSlipSolution, faces: Sequence[Array], crossed: frozenset[int]
) -> Iterator[Turn]:
    """Yield turns of nodes beside stick that is not seen."""
    state = solution.state
    for _, _, node in _changing(solution, faces, crossed):
        if state[node] * state[node + 1] < 0:
            yield node, 0
            yield node + 1, 0


def _changing(
    solution: StickSlipSolution, faces: Sequence[Array], crossed: frozenset[int]
) -> Iterator[tuple[int, int, int]]:
    """Yield the nodes behind which the state is another, between the first and last of a face."""
    ends = list(_ends(faces))
    for node in changing(solution.state):
        for first, last in ends:
            if first <= node < last and node not in crossed:
                yield first, last, node


def _edges(
    solution: StickSlipSolution, faces: Sequence[Array], open_ends: Sequence[int]
) -> Iterator[list[Turn]]:
    """Yield turns of nodes that stick at an edge: of the outermost one, and of the next one."""
    states = solution.state.tolist()
    for first, last in _ends(faces):
        for node, inner in ((first, first + 1), (last, last - 1)):
            if states[node] == 0 and node not in open_ends:
                way = 1 if solution.traction[node] > 0 else -1
                more = first <= inner <= last and states[inner] == 0
                yield [(node, way), (inner, way)] if more else [(node, way)]


def _pairs(asked: Sequence[int], nodes: Sequence[int], faces: Sequence[Array]) -> Iterator[Turn]:
    """Yield which turns are side by side, of two faces."""
    places = []
    for k in asked:
        node, which = nodes[k], 0
        while node >= faces[which].size:
            node, which = node - faces[which].size, which + 1
        places.append((k, which, int(faces[which][node])))
    for (i, one, place), (j, two, other) in combinations(places, 2):
        if one != two and abs(place - other) <= BESIDE:
            yield i, j
