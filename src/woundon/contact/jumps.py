r"""Where within its cell a traction jumps.

On a rigid body slip one way may meet slip the other way in a point, where the traction jumps from
one bound to the other.  A mesh has a node K that sticks there, or none: then K is the last one
before.  The traction of that node, q = s mu p (2 u - 1) where slip goes the way s before, tells
the place: u of the way from the point at which its slip is taken to the next one.  The slip must be
nil there, but the mesh asks for none at the point.  At the place it is

    v = (1 - u) v_K + u [v_K+1 + 2 (1 - u) kink],

where the kink is what the slip bends by as the traction jumps: v_K+1 knows the traction of the
node, behind the place and before it.  One step of Newton's method makes v nil, by the effects of
the nodes' laws, for all places of a state at once.  Without it the outputs err by first order.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from .joint import Joint
from .stick_slip import StickSlipSolution

__all__ = ["JUMPED", "Jumps", "changing"]

Array = np.ndarray

JUMPED = 0.05  # of their changes by jumps outputs err by at least, of random nips
SHORT = 0.1  # of a face's nodes, that stick for a jump's sake has at most
STEP = 1e-6  # of differences; places are in cells
NO_WAY = 1e-12  # in place of nil, which would say that a node sticks


def changing(state: Array) -> list[int]:
    """Return the nodes behind which the state is another."""
    found: list[int] = (state[1:] != state[:-1]).nonzero()[0].tolist()
    return found


class Jumps(NamedTuple):
    """The jumps of a state: ``nodes`` K, those ``behind`` them, ways of slip before, and u; (k,).

    ``crossed`` are the nodes from which a jump lies before the next one, ``kink`` what the slip
    bends by, and ``unlike`` by how much its rises beside the cell differ from those in it.
    ``faces`` are those that were looked at.
    """

    nodes: Array
    behind: Array
    ways: Array
    places: Array
    kink: Array
    unlike: Array
    crossed: frozenset[int]
    faces: Sequence[tuple[int, int]]

    @classmethod
    def of(
        cls, joint: Joint, solution: StickSlipSolution, faces: Sequence[tuple[int, int]]
    ) -> Jumps | None:
        """Return those on some faces, each from its first node to its last one; None without.

        Slip goes away from a jump on both sides; where it would not, there is stick on a length.
        """
        found = [
            (node, way, max(node - 1, first), min(node + 2, last))
            for first, last in faces
            for node, way in _meeting(solution.state, first, last)
        ]
        if not found:
            return None
        nodes, ways, back, on = np.array(found).T
        slip, bound, behind = solution.slip, solution.bound[nodes], nodes + 1
        places = (1 + np.clip(ways * solution.traction[nodes] / bound, -1, 1)) / 2
        own = joint.matrix[joint.unknowns + 2 :, joint.unknowns + 1 :]
        kink = (own[behind, nodes] - own[nodes, nodes]) * ways * bound
        rise = slip[behind] - slip[nodes] + 2 * (1 - places) * kink
        rises = np.array([rise, rise - 2 * kink])
        beside = np.array([slip[nodes] - slip[back], slip[on] - slip[behind]])
        with np.errstate(divide="ignore", invalid="ignore"):
            unlike = np.minimum(np.abs(beside / rises - 1).max(axis=0), 1.0)
        kept = np.all(-ways * rises > 0, axis=0)
        if not kept.any():
            return None
        crossed = frozenset(
            before
            for node in nodes[kept].tolist()
            for before in ((node - 1, node) if solution.state[node] == 0 else (node,))
        )
        return cls(
            nodes[kept], behind[kept], ways[kept], places[kept], kink[kept], unlike[kept],
            crossed, faces,
        )  # fmt: skip

    def effects(
        self, joint: Joint, solution: StickSlipSolution
    ) -> tuple[Array, Callable[[Array, Array, Array], Array]]:
        """Return unknowns by unit misses of the nodes' laws, and (u, v_K, v_K+1) -> those misses.

        The misses that make the slip at the jumps nil, (k,).
        """
        nodes, n, kink = self.nodes, joint.unknowns, self.kink
        bound, stick = solution.bound[nodes], np.zeros(nodes.size, dtype=int)
        effects = joint.effects(solution.joint[0], nodes)
        at, behind = (joint.laws(which, stick) @ effects.T for which in (nodes, self.behind))
        share = solution.traction[nodes] / bound
        sliding = (
            effects[:, n + 1 + nodes].T - share[:, None] * joint.bounds(effects[:, :n]).T[nodes]
        )
        moves = sliding / (2 * self.ways * bound)[:, None]  # of u

        def misses(u: Array, v: Array, further: Array) -> Array:
            slip = (1 - u) * v + u * (further + 2 * (1 - u) * kink)
            rise = further - v + (2 - 4 * u) * kink
            by_misses = (1 - u)[:, None] * at + u[:, None] * behind + rise[:, None] * moves
            try:
                return np.asarray(np.linalg.solve(by_misses, -slip))
            except np.linalg.LinAlgError:  # no place is nearer to nil
                return np.zeros_like(slip)

        return effects, misses

    def unknowns(self, joint: Joint, solution: StickSlipSolution) -> Array:
        """Return what the unknowns change by with each jump, (k, n + m + 2)."""
        effects, misses = self.effects(joint, solution)
        slip = solution.slip
        each = misses(self.places, slip[self.nodes], slip[self.behind])
        return np.asarray(each[:, None] * effects)

    def changes(
        self, joint: Joint, solution: StickSlipSolution, gradients: Array
    ) -> tuple[Array, Array]:
        """Return what outputs change by as the slip at the jumps becomes nil, and err by then.

        Parameters
        ----------
        joint : Joint
            The system that the solution is of.
        solution : StickSlipSolution
        gradients : (n + m + 2, outputs) array
            Of outputs by unknowns.

        Returns
        -------
        (outputs,) array, (outputs,) array
            They err by all that short zones of stick change by which need not be there then.
        """
        by_jumps = self.unknowns(joint, solution)
        each = by_jumps @ gradients
        error = np.sqrt(np.square(np.maximum(self.unlike, JUMPED)[:, None] * each).sum(axis=0))
        other = self._without_short_stick(joint, solution)
        if other is not None:
            error += np.abs((other - solution.joint[1] - by_jumps.sum(axis=0)) @ gradients)
        return each.sum(axis=0), error

    def _without_short_stick(self, joint: Joint, solution: StickSlipSolution) -> Array | None:
        """Return the unknowns without short zones of stick; None where there have to be any.

        A jump that is not in its place moves the slip of its whole face, to where slip that is
        nearly nil elsewhere would turn: there nodes stick that do not with the jump in its place.
        Where they alone hold the creep, the node of a jump does then.
        """
        state = solution.state.copy()
        for first, last in self.faces:
            for short in _short_stick(solution.state, first, last):
                state[short] = state[short.start - 1]
        zone = state != solution.state
        if joint.held.size and state.take(joint.held).all():
            state[self.nodes[~zone[self.nodes]][:1]] = 0
        other = joint.solve(state) if zone.any() else None
        if other is None or not other.finite:
            return None
        jumps = Jumps.of(joint, other, self.faces)
        if jumps is None:
            return None
        found: Array = other.joint[1] + jumps.unknowns(joint, other).sum(axis=0)
        slip = joint.slips(found) - joint.right[joint.unknowns + 2 :]
        return found if np.all((slip[: state.size] * state)[zone] > 0) else None

    def slopes(
        self, joint: Joint, solution: StickSlipSolution, gradients: Array
    ) -> tuple[Array, Array, Array]:
        """Return nodes, ways and slopes (outputs, 3k) of the changes, as of a ``Resting``."""
        effects, misses = self.effects(joint, solution)
        k, slip = self.nodes.size, solution.slip
        here = np.array([self.places, slip[self.nodes], slip[self.behind]])
        scale = np.repeat([1.0, *[float(np.abs(slip).max())] * 2], k)
        rows = []
        for j, size in enumerate(scale):
            step = np.zeros(3 * k)
            step[j] = STEP * size
            more, less = (misses(*(here + way * step.reshape(3, k))) for way in (1, -1))
            rows.append((more - less) / (2 * STEP * size))
        by = np.array(rows) @ effects @ gradients
        bound = solution.bound[self.nodes]
        by[:k] /= (2 * self.ways * bound)[:, None]  # u by the traction beyond its share of mu p
        share = solution.traction[self.nodes] / bound
        nodes = np.concatenate([self.nodes, self.nodes, self.behind])
        return nodes, np.concatenate([share + NO_WAY * (share == 0), np.zeros(2 * k)]), by.T


def _short_stick(state: Array, first: int, last: int) -> Iterator[slice]:
    """Yield short runs of nodes some of which stick, between slip the same way, on a face."""
    ends = [k for k in changing(state) if first <= k < last]
    behind = -1
    for k, one in enumerate(ends):
        for two in reversed(ends[k + 1 :] if one > behind else []):
            run = slice(one + 1, two + 1)
            alike = state[one] == state[two + 1] != 0
            if two - one <= SHORT * (last - first) and alike and not state[run].all():
                yield run
                behind = two
                break


def _meeting(state: Array, first: int, last: int) -> Iterator[tuple[int, int]]:
    """Yield the nodes K between the first and the last one of a face, and the way before each."""
    states = state[first : last + 1].tolist()
    for k in changing(state[first : last + 1]):
        way, on = states[k : k + 2]
        if way * on < 0:
            yield first + k, way
        elif way and k + 2 < len(states) and way * states[k + 2] < 0:
            yield first + k + 1, way
