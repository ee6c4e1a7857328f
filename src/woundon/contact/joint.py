r"""The whole contact problem of one half width as one system: pressure, shift, tractions, creep.

    gap       [ slope_p   1   slope_q   0 ] [ p  ]   [ gap ]      N = n + 1 cells
    slips     [ S         0   D         e ] [ D  ] = [ -c0 ]      m nodes
    resultant [ -F w      0   g         0 ] [ q  ]   [  0  ]
                                            [ xi ]

A slipping node needs no unknown of its own: its traction is s mu p, so that its column is added to
that of its pressure and its row is left out.  What is left has n + 2 unknowns and one a sticking
node, less work than to solve for the pressure by all tractions first.  That is what the regula
falsi of :mod:`.stick_slip` asks for, to which :meth:`Joint.condensed` leads back.

The factors of one half width serve its neighbours too: :mod:`.follow`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from . import lapack
from .stick_slip import StickSlip, StickSlipSolution

__all__ = ["Factors", "Joint"]

Array = np.ndarray


class Factors(NamedTuple):
    """A state of stick and slip, the indices of its sticking nodes, its system factorised."""

    state: Array
    stuck: Array
    lu: Array
    pivots: Array


@dataclass(frozen=True, eq=False)
class Joint:
    """The joint system; letters as in the module's text, unknowns (p, shift, q, xi) in one row.

    Attributes
    ----------
    matrix : (N + m + ..., n + m) array
        Slopes and slips by (p, q); more slips than the nodes' are told too.
    gap : (N,) array
        Slope of the gap.
    offset : (m + ...,) array
        c0.
    friction : (m,) array
        mu of each node; node k of each face sees pressure k.
    moves : (m + ...,) array
        e.
    resultant : (m,) array
        g.
    share : (n,) array
        F w: by the pressures, what the resultant is to be.
    condensed : callable
        () -> the same, solved for the pressure.
    """

    matrix: Array
    gap: Array
    offset: Array
    friction: Array
    moves: Array
    resultant: Array
    share: Array
    condensed: Callable[[], StickSlip]

    @property
    def creep(self) -> Array:
        """e of the nodes, (m,)."""
        return self.moves[: self.friction.size]

    @cached_property
    def scale(self) -> float:
        """Slope per pressure: what the rows are measured by."""
        slope = self.matrix[: self.gap.size, : self.gap.size - 1]
        return float(max(slope.max(), -slope.min()))

    @cached_property
    def weight(self) -> float:
        """What the resultant's row is multiplied by."""
        return self.scale / float(self.resultant.max())

    def factorised(self, state: Array) -> Factors | None:
        """Return the factors of one state of stick and slip; None where it is singular."""
        N, n = self.gap.size, self.gap.size - 1
        stuck, slides = np.flatnonzero(state == 0), self.friction * state
        law = self.matrix.take(np.concatenate([np.arange(N), N + stuck]), axis=0)
        A = np.empty((N + stuck.size + 1,) * 2)
        by_p = A[:-1, :n]
        by_p[...] = law[:, :n]
        for first in range(0, state.size, n):
            own = slides[first : first + n]
            if own.any():
                by_p += law[:, n + first : 2 * n + first] * own
        A[:N, n], A[N:, n] = self.scale, 0.0
        A[:-1, N:-1] = law.take(n + stuck, axis=1)
        A[:N, -1], A[N:-1, -1], A[-1, -1] = 0.0, self.scale * self.creep[stuck], 0.0
        slid = (self.resultant * slides).reshape(-1, n).sum(axis=0)
        A[-1, :n], A[-1, N:-1] = self.weight * (slid - self.share), self.resultant[stuck]
        A[-1, N:-1] *= self.weight
        # rows are written contiguously, so LAPACK is handed the transpose
        lu, pivots, info = lapack.dgetrf(A.T, overwrite_a=1)
        return Factors(state, stuck, lu, pivots) if info == 0 else None

    def step(self, factors: Factors, gap: Array, slip: Array, force: float) -> Array:
        """Return the unknowns that give gap slopes, slips and a resultant, by a state's laws.

        What the slips of slipping nodes are is not asked.
        """
        n, stuck = gap.size - 1, factors.stuck
        right = np.concatenate([gap, slip[stuck], [self.weight * force]])
        found, _ = lapack.dgetrs(factors.lu, factors.pivots, right, trans=1, overwrite_b=1)
        out = np.empty(n + 2 + factors.state.size)
        out[: n + 1], out[-1] = found[: n + 1], found[-1]
        out[n] *= self.scale
        out[-1] *= self.scale
        q = out[n + 1 : -1]
        np.multiply((self.friction * factors.state).reshape(-1, n), out[:n], out=q.reshape(-1, n))
        q[stuck] = found[n + 1 : -1]
        return out

    def slips(self, found: Array) -> Array:
        """Return all slips by unknowns, less c0."""
        n = self.gap.size - 1
        loads = np.concatenate([found[:n], found[n + 1 : -1]])
        return np.asarray(self.matrix[n + 1 :] @ loads + self.moves * found[-1])

    def solve(self, state: Array) -> StickSlipSolution:
        """Solve the linear system of one state."""
        factors = self.factorised(state)
        if factors is not None:
            found = self.step(factors, self.gap, -self.offset, 0.0)
            if np.isfinite(found).all():
                return self.solution(factors, found, self.offset + self.slips(found))
        return StickSlipSolution.failed(state)

    def solution(self, factors: Factors, found: Array, slip: Array) -> StickSlipSolution:
        """Return unknowns and slips as the solution of a state."""
        n, m = self.gap.size - 1, self.friction.size
        slip[factors.stuck] = 0.0  # solved for: what is left is rounding
        bound = (self.friction.reshape(-1, n) * found[:n]).ravel()
        return StickSlipSolution(
            factors.state, found[n + 1 : -1], float(found[-1]), slip[:m], bound,
            joint=(factors, found, slip[m:]),
        )  # fmt: skip
