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

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from .joint import Joint
from .stick_slip import StickSlipSolution

__all__ = ["JUMPED", "Jumps", "changing"]

Array = np.ndarray

JUMPED = 0.05  # of their changes by jumps outputs of random nips err by
STEP = 1e-6  # of differences; places are in cells
NO_WAY = 1e-12  # in place of nil, which would say that a node sticks


def changing(state: Array) -> list[int]:
    """Return the nodes behind which the state is another."""
    found: list[int] = (state[1:] != state[:-1]).nonzero()[0].tolist()
    return found


class Jumps(NamedTuple):
    """The jumps of a state: ``nodes`` K, those ``behind`` them, ways of slip before, and u; (k,).

    ``crossed`` are the nodes from which a jump lies before the next one.
    """

    nodes: Array
    behind: Array
    ways: Array
    places: Array
    crossed: frozenset[int]

    @classmethod
    def of(cls, solution: StickSlipSolution, faces: Sequence[tuple[int, int]]) -> Jumps | None:
        """Return those on some faces, each from its first node to its last one; None without."""
        states, found = solution.state.tolist(), []
        crossed: set[int] = set()
        for node in changing(solution.state) if faces else ():
            way, on = states[node], states[node + 1]
            for first, last in faces:
                if not first <= node < last:
                    continue
                if way * on < 0:
                    found.append((node, way))
                    crossed.add(node)
                elif way and node + 1 < last and way * states[node + 2] < 0:
                    found.append((node + 1, way))
                    crossed |= {node, node + 1}
        if not found:
            return None
        nodes, ways = np.array(found).T
        shares = solution.traction[nodes] / solution.bound[nodes]
        places = (1 + np.clip(ways * shares, -1, 1)) / 2
        return cls(nodes, nodes + 1, ways, places, frozenset(crossed))

    def effects(
        self, joint: Joint, solution: StickSlipSolution
    ) -> tuple[Array, Callable[[Array, Array, Array], Array]]:
        """Return unknowns by unit misses of the nodes' laws, and (u, v_K, v_K+1) -> those misses.

        The misses that make the slip at the jumps nil, (k,).
        """
        nodes, n = self.nodes, joint.unknowns
        bound, stick = solution.bound[nodes], np.zeros(nodes.size, dtype=int)
        effects = joint.effects(solution.joint[0], nodes)
        at, behind = (joint.laws(which, stick) @ effects.T for which in (nodes, self.behind))
        share = solution.traction[nodes] / bound
        sliding = (
            effects[:, n + 1 + nodes].T - share[:, None] * joint.bounds(effects[:, :n]).T[nodes]
        )
        moves = sliding / (2 * self.ways * bound)[:, None]  # of u
        own = joint.matrix[n + 2 :, n + 1 :]
        kink = (own[self.behind, nodes] - own[nodes, nodes]) * self.ways * bound

        def misses(u: Array, v: Array, further: Array) -> Array:
            slip = (1 - u) * v + u * (further + 2 * (1 - u) * kink)
            rise = further - v + (2 - 4 * u) * kink
            by_misses = (1 - u)[:, None] * at + u[:, None] * behind + rise[:, None] * moves
            return np.asarray(np.linalg.solve(by_misses, -slip))

        return effects, misses

    def changes(self, joint: Joint, solution: StickSlipSolution, gradients: Array) -> Array:
        """Return what outputs change by as the slip at the jumps becomes nil, (outputs,).

        Parameters
        ----------
        joint : Joint
            The system that the solution is of.
        solution : StickSlipSolution
        gradients : (n + m + 2, outputs) array
            Of outputs by unknowns.
        """
        effects, misses = self.effects(joint, solution)
        slip = solution.slip
        return np.asarray(
            misses(self.places, slip[self.nodes], slip[self.behind]) @ effects @ gradients
        )

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
