"""What outputs change by as borders and jumps come to rest, linearised: for derivatives."""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite, nan
from typing import NamedTuple

import numpy as np

from .borders import Changes, rest_of, turned
from .joint import Joint
from .jumps import Jumps
from .stick_slip import StickSlipSolution

__all__ = ["Resting", "by_misses"]

Array = np.ndarray

STEP = 1e-5  # of the changes, of differences


class Resting(NamedTuple):
    """What outputs change by as borders come to rest: ``slopes`` @ misses, about a state.

    The misses (turns,) are those of ``nodes`` that turn to ``ways``, of their new laws; changes are
    of their first degree, so that the ``slopes`` (outputs, turns) tell all.  ``gradients`` are
    those of the changes by the joint system's unknowns, (outputs, n + m + 2).  A way between -1
    and 1 is that of a traction which is so much of its bound.
    """

    nodes: Array
    ways: Array
    slopes: Array
    gradients: Array

    @classmethod
    def of(cls, joint: Joint, nodes: Array, ways: Array, slopes: Array) -> Resting:
        """Return them with their gradients."""
        return cls(nodes, ways, slopes, slopes @ joint.laws(nodes, ways))

    def beside(self, other: Resting) -> Resting:
        """Return the changes of both."""
        parts = zip(self[:3], other[:3], strict=True)
        nodes, ways, slopes = (np.concatenate(both, axis=-1) for both in parts)
        return Resting(nodes, ways, slopes, self.gradients + other.gradients)

    def under(self, slip: Array, traction: Array, bound: Array) -> Array:
        """Return the changes where all nodes have these, (outputs,)."""
        nodes, ways = self.nodes, self.ways
        misses = np.where(ways == 0, slip[nodes], traction[nodes] - ways * bound[nodes])
        return np.asarray(self.slopes @ misses)


def by_misses(
    joint: Joint, solution: StickSlipSolution, faces: Sequence[Array], gradients: Array,
    jumps: Jumps | None = None,
) -> Resting:  # fmt: skip
    """Return what outputs change by as borders and jumps come to rest, linearised.

    Parameters as of :func:`by_turning`; what the laws and effects themselves change by is left out,
    a share of these changes as small as they are.
    """
    crossed = jumps.crossed if jumps else frozenset[int]()
    borders, nodes, ways, laws, misses, effects, free = turned(joint, solution, faces, crossed, ())
    misses[free] = nan
    outputs, table = (effects @ gradients).tolist(), laws.tolist()
    slopes = np.zeros((gradients.shape[1], nodes.size))

    def of(border: int, by: list[float]) -> list[tuple[float, ...]]:
        changes = Changes(table, by, outputs).of_border(4 * border, borders[border])
        return list(zip(*changes, strict=True))  # of each output by -2, -1, 1 and 2 nodes

    for border in range(len(borders)):
        at = of(border, misses.tolist())
        for turn in range(4 * border, 4 * border + 4):
            alone = [0.0] * nodes.size
            alone[turn] = 1.0
            slopes[:, turn] = list(map(_slope, at, of(border, alone)))
    found = Resting.of(joint, nodes, ways, slopes)
    return (
        found.beside(Resting.of(joint, *jumps.slopes(joint, solution, gradients)))
        if jumps
        else found
    )


def _slope(at: Sequence[float], on: Sequence[float]) -> float:
    """Return the derivative of :func:`rest_of` at some changes by nodes along others."""
    size, way = (max((abs(c) for c in by if isfinite(c)), default=0.0) for by in (at, on))
    step = STEP * size / (way or 1.0)
    more, less = (
        rest_of(*(a + side * step * b for a, b in zip(at, on, strict=True)))[0] for side in (1, -1)
    )
    slope = (more - less) / (2 * step) if step else 0.0
    return slope if isfinite(slope) else 0.0
