r"""The whole contact problem of one half width as one system: pressure, shift, tractions, creep.

    gap       [ slope_p   1   slope_q   0 ] [ p  ]   [ gap ]      N = n + 1 cells
    resultant [ -F w      0   g         0 ] [ D  ] = [  0  ]
    slips     [ S         0   D         e ] [ q  ]   [ -c0 ]      m nodes, and further places
                                            [ xi ]

A slipping node needs no unknown of its own: its traction is s mu p, so that its column is added to
that of its pressure and its row is left out.  What is left has n + 2 unknowns and one a sticking
node, less work than to solve for the pressure by all tractions first.  That is what the regula
falsi of :mod:`.pivoting` asks for, to which :attr:`Joint.condensed` leads back.

From one state to the next a few nodes turn.  Each of them may then miss the law that it obeyed, by
c: slip where it stuck, more or less than s mu p where it slipped.  The unknowns are linear in these
c, by effects that the factors at hand tell; the laws that hold instead are as many equations for c
as nodes have turned.

The factors of one half width serve its neighbours too: :mod:`.follow`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from math import isfinite
from typing import NamedTuple

import numpy as np

from . import lapack
from .stick_slip import RigidFace, StickSlip, StickSlipSolution

__all__ = ["Factors", "Joint"]

Array = np.ndarray

# factors of another state serve where it has at least so many unknowns, and no larger share of them
# turns: else factors of its own cost no more
LEAST, TURNED = 100, 0.2
ROUNDING = 1e-12  # of the largest slip: what they may leave where nodes stick


class Base(NamedTuple):
    """A state of stick and slip, which rows and columns its system has, and that factorised.

    ``shares`` are s mu, what tractions are of pressures where they slip, (m,).
    """

    state: Array
    shares: Array
    rows: Array
    columns: Array
    lu: Array
    pivots: Array

    def solved(self, right: Array) -> Array:
        """Return solutions of its system, (rows) or (rows, k); right sides are written over."""
        found: Array = lapack.dgetrs(self.lu, self.pivots, right, trans=1, overwrite_b=1)[0]
        return found


class Turned(NamedTuple):
    """Nodes that have turned from a base's state.

    ``laws`` are the rows of those that they obey now, (k, n + m + 2); ``effects`` the unknowns by a
    unit miss of each one's former law, alike; ``lu`` and ``pivots`` the factors of the ones by the
    others.
    """

    nodes: Array
    laws: Array
    effects: Array
    lu: Array
    pivots: Array


class Factors(NamedTuple):
    """A state of stick and slip by the factors of a base, from which some nodes may have turned."""

    state: Array
    base: Base
    turned: Turned | None = None


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
        mu of each node.
    own : (m,) int array
        Which pressure bounds each traction; of a nip the nodes' own, face by face.
    condensed : callable
        () -> the same, solved for the pressure.
    rigid : RigidFace, optional
        The face, if one is on a rigid body, whose tractions the resultant is of.
    """

    matrix: Array
    right: Array
    friction: Array
    own: Array
    condensed: Callable[[], StickSlip]
    rigid: RigidFace | None = field(default=None, kw_only=True)
    _last: list[Base] = field(default_factory=list, init=False, repr=False)

    @cached_property
    def unknowns(self) -> int:
        """Number n of pressures."""
        return self.matrix.shape[1] - 2 - self.friction.size

    @cached_property
    def _first(self) -> Array:
        """The rows that every state has."""
        return np.arange(self.unknowns + 2)

    @cached_property
    def _own_column(self) -> Array:
        """The column of each row: p and shift, xi for the resultant, the nodes' tractions."""
        columns = np.arange(-1, self.matrix.shape[1] - 1)
        columns[: self.unknowns + 1] += 1
        columns[self.unknowns + 1] = self.matrix.shape[1] - 1
        return columns

    @property
    def creep(self) -> Array:
        """e of the nodes, (m,)."""
        return self.matrix[self.unknowns + 2 :, -1][: self.friction.size]

    @cached_property
    def held(self) -> Array:
        """The nodes that feel the creep, of which one must stick."""
        return self.creep.nonzero()[0]

    def bounds(self, p: Array) -> Array:
        """Return mu p of each node, (..., m)."""
        bounds = p.take(self.own, axis=-1)
        bounds *= self.friction
        return bounds

    def _by_last(self, state: Array) -> Factors | None:
        """Return a state by the factors at hand; None where they do not serve."""
        base = self._last[0] if self._last else None
        if base is None or base.rows.size < LEAST:
            return None
        nodes = (state != base.state).nonzero()[0]
        turned = None
        if 0 < nodes.size <= TURNED * base.rows.size:
            turned = self._turned(base, state, nodes)
        return None if turned is None else Factors(state, base, turned)

    def _by_own(self, state: Array) -> Factors | None:
        """Return a state by its own factors; None where it is singular."""
        n, stuck = self.unknowns, (state == 0).nonzero()[0]
        rows = np.concatenate([self._first, stuck + (n + 2)])
        columns = self._own_column.take(rows)
        law = self.matrix.take(rows, axis=0)
        A = law.take(columns, axis=1)
        shares = self.friction * state
        self._bring(law[:, n + 1 : -1], shares, A)
        # rows are written contiguously, so LAPACK is handed the transpose
        lu, pivots, info = lapack.dgetrf(A.T, overwrite_a=1)
        if info != 0:
            return None
        self._last[:] = [Base(state, shares, rows, columns, lu, pivots)]
        return Factors(state, self._last[0])

    def _bring(self, columns: Array, shares: Array, to: Array) -> None:
        """Add the columns of tractions, by shares, to those of the pressures that bound them."""
        n = self.unknowns
        faces = columns.reshape(len(columns), -1, n), shares.reshape(-1, n)
        to[:, :n] += np.einsum("rfn,fn->rn", *faces)

    def _turned(self, base: Base, state: Array, nodes: Array) -> Turned | None:
        """Return what follows from the turning of nodes; None where they have no such state."""
        effects = self.effects(Factors(base.state, base), nodes)
        laws = self.laws(nodes, state.take(nodes))
        lu, pivots, info = lapack.dgetrf(laws @ effects.T)
        return Turned(nodes, laws, effects, lu, pivots) if info == 0 else None

    def effects(self, factors: Factors, nodes: Array) -> Array:
        """Return the unknowns by a unit miss of each of some nodes' laws, (k, n + m + 2)."""
        n, ways = self.unknowns, factors.state.take(nodes)
        stuck, slid = (ways == 0).nonzero()[0], ways.nonzero()[0]
        # unit slips where there is stick, unit tractions beside s mu p where there is slip
        right = np.zeros((nodes.size, len(self.matrix)))
        right[stuck, nodes[stuck] + (n + 2)] = 1.0
        right[slid] = -self.matrix.take(nodes[slid] + (n + 1), axis=1).T
        effects = self.step(factors, right)
        effects[slid, nodes[slid] + (n + 1)] += 1.0
        return effects

    def _unfolded(self, base: Base, found: Array) -> Array:
        """Return all unknowns by those of a base's system, (..., n + m + 2)."""
        out = np.empty((*found.shape[:-1], self.matrix.shape[1]))
        own = found.take(self.own, axis=-1)
        np.multiply(base.shares, own, out=out[..., self.unknowns + 1 : -1])
        out[..., base.columns] = found
        return out

    def laws(self, nodes: Array, ways: Array) -> Array:
        """Return the rows of nodes that stick, their slips, or go one way: q - s mu p, (k, ...)."""
        rows, k = np.zeros((nodes.size, self.matrix.shape[1])), np.arange(nodes.size)
        rows[k, self.own.take(nodes)] = -ways * self.friction.take(nodes)
        rows[k, nodes + (self.unknowns + 1)] = 1.0
        stuck = (ways == 0).nonzero()[0]
        rows[stuck] = self.matrix.take(nodes[stuck] + (self.unknowns + 2), axis=0)
        return rows

    def step(self, factors: Factors, right: Array) -> Array:
        """Return the unknowns that give right sides by a state's laws, (..., n + m + 2).

        What the slips of slipping nodes are is not asked.
        """
        state, base, turned = factors
        found = self._unfolded(base, base.solved(right.take(base.rows, axis=-1).T).T)
        if turned is None:
            return found
        asked = right.take(turned.nodes + (self.unknowns + 2), axis=-1)
        asked[..., state.take(turned.nodes) != 0] = 0.0
        left = found @ turned.laws.T - asked
        misses, _ = lapack.dgetrs(turned.lu, turned.pivots, left.T, overwrite_b=1)
        return np.asarray(found - misses.T @ turned.effects)

    def slips(self, found: Array) -> Array:
        """Return all slips by unknowns, less c0."""
        return np.asarray(self.matrix[self.unknowns + 2 :] @ found)

    def solve(self, state: Array) -> StickSlipSolution:
        """Solve the linear system of one state."""
        for make in (self._by_last, self._by_own):
            factors = make(state)
            solution = None if factors is None else self._solved(factors)
            if solution is not None:
                return solution
        return StickSlipSolution.failed(state)

    def _solved(self, factors: Factors) -> StickSlipSolution | None:
        """Return the solution of a state; None where it is not finite, or lost too many digits."""
        found = self.step(factors, self.right)
        if not isfinite(found @ found):
            return None
        slip = self.slips(found) - self.right[self.unknowns + 2 :]
        if factors.turned is not None:
            size = np.abs(slip[: self.friction.size])
            if size[factors.state == 0].max(initial=0.0) > ROUNDING * size.max():
                return None
        return self.solution(factors, found, slip)

    def solution(self, factors: Factors, found: Array, slip: Array) -> StickSlipSolution:
        """Return unknowns and slips as the solution of a state."""
        n, m = self.unknowns, self.friction.size
        slip[:m][factors.state == 0] = 0.0  # solved for: what is left is rounding
        return StickSlipSolution(
            factors.state, found[n + 1 : -1], float(found[-1]), slip[:m], self.bounds(found[:n]),
            joint=(factors, found, slip[m:]),
        )  # fmt: skip
