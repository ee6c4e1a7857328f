r"""The pressure in a roll at one stage of its build-up: a boundary-value problem.

A lap laid at r with the stress T moves by what is wound on it later; that its strain along the web
and the one through the stack stay compatible is, with hoop stress -(P + r P') and the stack's law,

    C(r) = r^2 P'' + 3 r P' + P - E_t F(P)            the same at every later stage,

because all increments of it are total derivatives.  In x = ln r, with Q = r P' and D = d/dx:

    D P = Q
    D Q = C + E_t F(P) - P - 2 Q          on the interval from the core to the surface s
    Q = b P - T_c       at the core,  b = E_t/E_c - 1 + nu,  T_c = T(r_c)
    P = 0               at s

What a thin lap more adds is p = dP/ds, of the same equations made linear, with p = 1 at s (any
multiple will do) and no T_c; its growth kappa = D p at s says what C the next lap gets:

    C(s) = -s T' - T (2 + kappa)

Then -D P = T at s comes out, and tells how good the source is.

Discretised by the two-stage Lobatto rule (order four, as in scipy.integrate.solve_bvp) on given
nodes.  Source values belong to a cell, left, middle and right, because C jumps where T has a kink.
The unknowns P0, Q0, P1, Q1, ... have a matrix of five diagonals:

    core      [ -b  1                ]
    cell 0    [ L   L   R   R        ]  2 rows
    cell 1    [         L   L   R  R ]  2 rows
    surface   [                 1  0 ]
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from ..contact import lapack

__all__ = ["CellSource", "Solved", "StageEquations", "pressure_between"]

Array = np.ndarray
MOST_STEPS = 60
BAND = 2  # diagonals on either side
SETTLED = 1e-11  # change of P by a Newton step, relative


class CellSource(NamedTuple):
    """Source C of every cell at its left end, its middle and its right end, (n,) each [Pa]."""

    left: Array
    middle: Array
    right: Array


class Solved(NamedTuple):
    """Pressure P and Q = r P' at the nodes, (n + 1,) each [Pa]; kappa = D p/p at the surface."""

    P: Array
    Q: Array
    growth: float


@dataclass
class StageEquations:
    """The equations of every stage of one roll.

    Parameters
    ----------
    strain, modulus : callable
        F(P) and E_r(P) of the stack.
    tangential : float
        E_t [Pa].
    core : float
        b = E_t/E_c - 1 + nu.
    """

    strain: Callable[[Array], Any]
    modulus: Callable[[Array], Any]
    tangential: float
    core: float
    steps: int = field(default=0, init=False)  # of Newton, so far

    def _slope_of_Q(self, P: Array, Q: Array) -> Array:
        """D Q less the source."""
        return np.asarray(self.tangential * self.strain(P) - P - 2 * Q)

    def defects(
        self, x: Array, source: CellSource, tension: float, P: Array, Q: Array
    ) -> tuple[Array, Array]:
        """Return what P and Q leave of all equations, (2 n + 2,) [Pa], and P in mid-cell, (n,)."""
        h = x[1:] - x[:-1]
        own = self._slope_of_Q(P, Q)
        left, right = own[:-1] + source.left, own[1:] + source.right
        middle_P = (P[1:] + P[:-1]) / 2 - h / 8 * (Q[1:] - Q[:-1])
        middle_Q = (Q[1:] + Q[:-1]) / 2 - h / 8 * (right - left)
        middle = self._slope_of_Q(middle_P, middle_Q) + source.middle
        out = np.empty(2 * x.size)
        out[0], out[-1] = Q[0] - self.core * P[0] + tension, P[-1]
        out[1:-1:2] = P[1:] - P[:-1] - h / 6 * (Q[:-1] + 4 * middle_Q + Q[1:])
        out[2:-1:2] = Q[1:] - Q[:-1] - h / 6 * (left + 4 * middle + right)
        return out, middle_P

    def _matrix(self, x: Array, P: Array, middle_P: Array) -> Array:
        """Return the derivative of the defects by P and Q, by diagonals as LAPACK wants them."""
        n, h = x.size - 1, x[1:] - x[:-1]
        stiff = self.tangential / self.modulus(np.concatenate([P, middle_P])) - 1
        ends, mid = stiff[: n + 1], stiff[n + 1 :]
        band = np.zeros((3 * BAND + 1, 2 * (n + 1)))
        diagonal = 2 * BAND  # entry (i, j) stands in row diagonal + i - j
        for side, own in ((-1.0, ends[:-1]), (1.0, ends[1:])):
            # J = [[0, 1], [own, -2]] at the end; M = 1/2 -+ h/8 J takes the end to the middle
            turn = -side * h / 8
            m21, m22 = turn * own, 0.5 - 2 * turn
            first = 0 if side < 0 else 2  # columns of P and Q: this one and the next, of each cell
            for i, j, value in (
                (1, first, side - h / 6 * 4 * m21),
                (1, first + 1, -h / 6 * (1 + 4 * m22)),
                (2, first, -h / 6 * (own + 4 * (mid / 2 - 2 * m21))),
                (2, first + 1, side - h / 6 * (-2 + 4 * (mid * turn - 2 * m22))),
            ):
                band[diagonal + i - j, j : j + 2 * n : 2] = value
        band[diagonal, 0], band[diagonal - 1, 1] = -self.core, 1.0
        band[diagonal + 1, -2] = 1.0
        return band

    def solve(
        self, x: Array, source: CellSource, tension: float, P: Array, Q: Array,
        settled: float = SETTLED,
    ) -> Solved | None:  # fmt: skip
        """Solve by Newton's method from a first guess; None where it does not settle.

        Parameters
        ----------
        x : (n + 1,) array
            ln r of the nodes.
        source : CellSource
        tension : float
            T_c, in the core's condition [Pa].
        P, Q : (n + 1,) arrays
            First guess [Pa].
        settled : float
            Change of P by the last step, relative to the largest.
        """
        for _ in range(MOST_STEPS):
            miss, middle_P = self.defects(x, source, tension, P, Q)
            factors, pivots, info = lapack.dgbtrf(
                self._matrix(x, P, middle_P), BAND, BAND, overwrite_ab=1
            )
            if info != 0 or not np.isfinite(miss).all():
                return None
            change, _ = lapack.dgbtrs(factors, BAND, BAND, miss, pivots)
            P, Q = P - change[::2], Q - change[1::2]
            self.steps += 1
            if np.max(np.abs(change[::2])) <= settled * np.max(np.abs(P)):
                unit = np.zeros_like(miss)
                unit[-1] = 1.0
                more, _ = lapack.dgbtrs(factors, BAND, BAND, unit, pivots)
                return Solved(P, Q, float(more[-1]))
        return None


def pressure_between(x: Array, P: Array, Q: Array, at: Array) -> tuple[Array, Array]:
    """Return P and Q at any ln r by the cubics through P and Q, which are of order four."""
    k = np.clip(np.searchsorted(x, at, side="right") - 1, 0, x.size - 2)
    h = x[k + 1] - x[k]
    t = (at - x[k]) / h
    rise, q0, q1 = (P[k + 1] - P[k]) / h, Q[k], Q[k + 1]
    c2, c3 = 3 * rise - 2 * q0 - q1, q0 + q1 - 2 * rise
    return P[k] + h * t * (q0 + t * (c2 + t * c3)), q0 + t * (2 * c2 + 3 * t * c3)
