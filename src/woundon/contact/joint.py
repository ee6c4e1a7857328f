r"""The whole contact problem of one half width as one system: pressure, shift, tractions, creep.

    gap       [ slope_p   1   slope_q   0 ] [ p  ]   [ gap ]      N = n + 1 cells
    resultant [ -F w      0   g         0 ] [ D  ] = [  0  ]
    slips     [ S         0   D         e ] [ q  ]   [ -c0 ]      m nodes, and further places
                                            [ xi ]

A slipping node needs no unknown of its own: its traction is s mu p, so that its column is added to
that of its pressure and its row is left out.  What is left has n + 2 unknowns and one a sticking
node, less work than to solve for the pressure by all tractions first.  That is what the regula
falsi of :mod:`.stick_slip` asks for, to which :attr:`Joint.condensed` leads back.

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
    """A state of stick and slip, which rows and columns its system has, and that factorised."""

    state: Array
    rows: Array
    columns: Array
    lu: Array
    pivots: Array


@dataclass(frozen=True, eq=False)
class Joint:
    """The joint system; letters as in the module's text, unknowns (p, shift, q, xi) in one row.

    Attributes
    ----------
    matrix : (N + 1 + m + ..., n + m + 2) array
        All rows; the resultant's is of the size of the others.
    right : (N + 1 + m + ...,) array
        The right sides.
    friction : (m,) array
        mu of each node; node k of each face sees pressure k.
    condensed : callable
        () -> the same, solved for the pressure.
    """

    matrix: Array
    right: Array
    friction: Array
    condensed: Callable[[], StickSlip]

    @cached_property
    def unknowns(self) -> int:
        """Number n of pressures."""
        return self.matrix.shape[1] - 2 - self.friction.size

    @cached_property
    def _ends(self) -> tuple[Array, Array]:
        """The rows that every state has, and the last column."""
        return np.arange(self.unknowns + 2), np.array([self.matrix.shape[1] - 1])

    @property
    def creep(self) -> Array:
        """e of the nodes, (m,)."""
        return self.matrix[self.unknowns + 2 :, -1][: self.friction.size]

    def factorised(self, state: Array) -> Factors | None:
        """Return the factors of one state of stick and slip; None where it is singular."""
        n, stuck = self.unknowns, (state == 0).nonzero()[0]
        first, last = self._ends
        rows = np.concatenate([first, stuck + (n + 2)])
        columns = np.concatenate([first[:-1], stuck + (n + 1), last])
        law = self.matrix.take(rows, axis=0)
        A = law.take(columns, axis=1)
        sliding = law[:, n + 1 : -1]
        sliding *= self.friction * state
        self._bring(sliding, A)
        # rows are written contiguously, so LAPACK is handed the transpose
        lu, pivots, info = lapack.dgetrf(A.T, overwrite_a=1)
        return Factors(state, rows, columns, lu, pivots) if info == 0 else None

    def _bring(self, sliding: Array, to: Array) -> None:
        """Add the columns of slipping tractions to those of the pressures that bound them."""
        n = self.unknowns
        for start in range(0, self.friction.size, n):
            to[:, :n] += sliding[:, start : start + n]

    def bounds(self, p: Array) -> Array:
        """Return mu p of each node, (m,)."""
        return np.asarray((self.friction.reshape(-1, p.size) * p).ravel())

    def step(self, factors: Factors, right: Array) -> Array:
        """Return the unknowns that give right sides by a state's laws, (n + m + 2,).

        What the slips of slipping nodes are is not asked.
        """
        n, right = self.unknowns, right.take(factors.rows)
        found, _ = lapack.dgetrs(factors.lu, factors.pivots, right, trans=1, overwrite_b=1)
        out = np.empty(self.matrix.shape[1])
        np.multiply(factors.state, self.bounds(found[:n]), out=out[n + 1 : -1])
        out[factors.columns] = found
        return out

    def slips(self, found: Array) -> Array:
        """Return all slips by unknowns, less c0."""
        return np.asarray(self.matrix[self.unknowns + 2 :] @ found)

    def solve(self, state: Array) -> StickSlipSolution:
        """Solve the linear system of one state."""
        factors = self.factorised(state)
        if factors is not None:
            found = self.step(factors, self.right)
            if np.isfinite(found).all():
                slip = self.slips(found) - self.right[self.unknowns + 2 :]
                return self.solution(factors, found, slip)
        return StickSlipSolution.failed(state)

    def solution(self, factors: Factors, found: Array, slip: Array) -> StickSlipSolution:
        """Return unknowns and slips as the solution of a state."""
        n, m = self.unknowns, self.friction.size
        slip[factors.rows[n + 2 :] - (n + 2)] = 0.0  # solved for: what is left is rounding
        return StickSlipSolution(
            factors.state, found[n + 1 : -1], float(found[-1]), slip[:m], self.bounds(found[:n]),
            joint=(factors, found, slip[m:]),
        )  # fmt: skip
