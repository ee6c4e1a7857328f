r"""The stick-slip problem on matrices.

Unknown are the tractions q (m of them, one or two faces) and, where a resultant is prescribed, one
rigid slip xi (a creep).  The tractions load the bodies and press back on the pressure:

    p = p0 + K q                        pressure, from the normal problem
    v = c0 + D q + S p + e xi           slip at each node's collocation point
    b = mu * p[face nodes]              friction bound
    g q = F                             prescribed resultant (optional)

and each node obeys one of three laws, held in ``state``:

    stick      0    v = 0    |q| <= b
    forward   +1    q = +b   v >= 0
    backward  -1    q = -b   v <= 0

so that, for a given state, everything is one linear system

      rows of sticking nodes    [ D + S K    e ] [ q  ]   [ -(c0 + S p0) ]
      rows of slipping nodes    [ I - s mu K 0 ] [ xi ] = [  s mu p0     ]
      resultant                 [ g          0 ]          [  F           ]

This is a mixed complementarity problem; :mod:`.pivoting` solves it.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from functools import cached_property
from typing import Any, ClassVar, NamedTuple

import numpy as np

from . import lapack

__all__ = ["Ending", "RigidFace", "StickSlip", "StickSlipSolution"]

Array = np.ndarray

# a law counts as kept when violated by less than this, relative to the largest bound or slip
TOLERANCE = 1e-11


class Ending(Enum):
    """How an iteration ended, and what to do next."""

    SOLVED = "every law is kept"
    CYCLE = "the iteration repeats itself: use algorithm='pivoting'"
    LIMIT = "the limit of iterations was reached; another number of nodes may do"
    SINGULAR = "a linear system was singular"


class RigidFace(NamedTuple):
    """The nodes on a rigid body, in one row, and what integrates their tractions [m]."""

    nodes: slice
    weights: Array


class _System(NamedTuple):
    """A linear system as it was last asked for, changed in place."""

    state: Array
    matrix: Array
    right: Array


@dataclass(frozen=True, eq=False)
class StickSlip:
    """The matrices of a stick-slip problem; see the module's text for the letters.

    Attributes
    ----------
    direct : (m, m) array
        D.
    through_pressure : (m, n) array
        S.
    offset : (m,) array
        c0.
    pressure : (n,) array
        p0.
    pressure_response : (n, m) array
        K.
    friction : (m,) array
        mu of each node.
    faces : int
        Number of faces; node k of each face sees pressure k.
    creep : (m,) array or None
        e; None if no resultant is prescribed.
    resultant : (m,) array or None
        g.
    force : float
        F.
    """

    direct: Array
    through_pressure: Array
    offset: Array
    pressure: Array
    pressure_response: Array
    friction: Array
    faces: int
    creep: Array | None = None
    resultant: Array | None = None
    force: float = 0.0

    rigid: ClassVar[None] = None  # told to the joint system alone

    @cached_property
    def stick_matrix(self) -> Array:
        """D + S K."""
        if self.apart:
            return self.direct
        return self.direct + self.through_pressure @ self.pressure_response

    @cached_property
    def held(self) -> Array:
        """The nodes that feel the creep, of which one must stick."""
        return np.empty(0, dtype=int) if self.creep is None else self.creep.nonzero()[0]

    @cached_property
    def apart(self) -> bool:
        """Whether tractions leave the pressure alone, K = 0: then slipping ones are known."""
        return not self.pressure_response.any()

    @cached_property
    def stick_offset(self) -> Array:
        """c0 + S p0."""
        return self.offset + self.through_pressure @ self.pressure

    @cached_property
    def bound_offset(self) -> Array:
        """mu p0 for all faces, (m,)."""
        return self.friction * self.on_faces(self.pressure)

    def on_faces(self, values: Array) -> Array:
        """Return nodal values of the nip repeated for each face."""
        return np.concatenate([values] * self.faces)

    @cached_property
    def scale(self) -> float:
        """Slip per traction; slipping rows are multiplied by it to balance the system."""
        matrix = self.stick_matrix
        return float(max(matrix.max(), -matrix.min()))

    def system(self, state: Array) -> tuple[Array, Array]:
        """Return matrix and right side of one state, slipping rows balanced by ``scale``."""
        made = self._made
        turned = np.nonzero(state != made.state)[0]  # after the first time these are few
        made.state[turned] = state[turned]
        self._write_rows(made, turned)
        return made.matrix.copy(), made.right.copy()

    @cached_property
    def _made(self) -> _System:
        """The system asked for last; to begin with, that of all nodes in stick."""
        m, bordered = self.friction.size, self.creep is not None
        matrix, right = np.empty((m + bordered, m + bordered)), np.empty(m + bordered)
        matrix[:m, :m], right[:m] = self.stick_matrix, -self.stick_offset
        if self.creep is not None and self.resultant is not None:
            unit = self.scale / float(np.max(np.abs(self.resultant)))
            matrix[:m, m], matrix[m, m] = self.scale * self.creep, 0.0
            matrix[m, :m], right[m] = unit * self.resultant, unit * self.force
        return _System(np.zeros(m, dtype=np.int8), matrix, right)

    def _write_rows(self, made: _System, rows: Array) -> None:
        """Write the laws of some nodes: v = 0 in stick, q = s mu p in slip."""
        m, scale = self.friction.size, self.scale
        stuck, slips = (rows[made.state[rows] == 0], rows[made.state[rows] != 0])
        made.matrix[stuck, :m] = self.stick_matrix[stuck]
        made.right[stuck] = -self.stick_offset[stuck]
        sign = scale * made.state[slips]
        bound = self.pressure_response[slips % self.pressure.size]
        made.matrix[slips, :m] = (-sign * self.friction[slips])[:, None] * bound
        made.matrix[slips, slips] += scale
        made.right[slips] = sign * self.bound_offset[slips]
        if self.creep is not None:
            made.matrix[stuck, m], made.matrix[slips, m] = scale * self.creep[stuck], 0.0

    def solve(self, state: Array) -> StickSlipSolution:
        """Solve the linear system of one state."""
        if self.apart:
            return self._solve_apart(state)
        m = state.size
        matrix, right = self.system(state)
        # rows are written contiguously, so LAPACK is handed the transpose
        factor, pivots, info = lapack.dgetrf(matrix.T, overwrite_a=1)
        if info != 0:
            return StickSlipSolution.failed(state)
        unknown, _ = lapack.dgetrs(factor, pivots, right, trans=1, overwrite_b=1)
        if not np.isfinite(unknown).all():
            return StickSlipSolution.failed(state)
        creep = self.scale * float(unknown[m]) if self.creep is not None else 0.0
        return self.evaluate(state, unknown[:m], creep)

    def _solve_apart(self, state: Array) -> StickSlipSolution:
        """Solve for the sticking tractions and the creep alone, where slipping ones are known."""
        q, creep = state * self.bound_offset, 0.0
        stuck = (state == 0).nonzero()[0]
        k, bordered = stuck.size, int(self.creep is not None)
        matrix, right = np.zeros((k + bordered,) * 2), np.empty(k + bordered)
        matrix[:k, :k] = self.direct[np.ix_(stuck, stuck)]
        right[:k] = -self.stick_offset[stuck] - self.direct[stuck] @ q
        if self.creep is not None and self.resultant is not None:
            unit = self.scale / float(np.max(np.abs(self.resultant)))
            matrix[:k, k] = self.scale * self.creep[stuck]
            matrix[k, :k] = unit * self.resultant[stuck]
            right[k] = unit * (self.force - self.resultant @ q)
        if right.size:
            _, _, unknown, info = lapack.dgesv(matrix.T.copy().T, right, overwrite_b=1)
            if info != 0 or not np.isfinite(unknown).all():
                return StickSlipSolution.failed(state)
            q[stuck] = unknown[:k]
            creep = self.scale * float(unknown[k]) if bordered else 0.0
        return self.evaluate(state, q, creep)

    def evaluate(self, state: Array, traction: Array, creep: float) -> StickSlipSolution:
        """Evaluate slip and bound of given tractions."""
        slip = self.stick_offset + self.stick_matrix @ traction
        if self.creep is not None:
            slip += self.creep * creep
        slip[state == 0] = 0.0  # solved for: what is left is rounding
        pressure = self.pressure + self.pressure_response @ traction
        bound = self.friction * self.on_faces(pressure)
        return StickSlipSolution(state, traction, creep, slip, bound)


class StickSlipSolution(NamedTuple):
    """Tractions, rigid slip, slips and bounds of a state, and how it was reached.

    ``joint`` is what a joint system tells besides: factors, unknowns, further slips.
    """

    state: Array
    traction: Array
    creep: float
    slip: Array
    bound: Array
    ending: Ending = Ending.SOLVED
    solves: int = 1
    joint: Any = None

    @classmethod
    def failed(cls, state: Array) -> StickSlipSolution:
        """Return what stands for the solution of a singular system."""
        nan = np.full(state.size, np.nan)
        return cls(state, nan, np.nan, nan, nan, Ending.SINGULAR)

    @property
    def finite(self) -> bool:
        """Whether tractions were found at all."""
        return bool(np.isfinite(self.traction).all())

    def violated(self) -> Array:
        """Which nodes break the law of their state, (m,) bool."""
        # a node in stick has no slip, one that slips no slack: nodes break one law or the other
        b_tol = TOLERANCE * np.maximum.reduce(np.abs(self.bound))
        v_tol = TOLERANCE * np.maximum.reduce(np.abs(self.slip))
        over = np.abs(self.traction) > self.bound + b_tol
        return np.where(self.state == 0, over, self.state * self.slip < -v_tol)

    def flipped(self, which: Array) -> Array:
        """Return the state with the given nodes brought to the law they ask for."""
        asked = np.sign(self.traction) * (self.state == 0)
        return np.where(which, asked, self.state).astype(np.int8)
