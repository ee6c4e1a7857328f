r"""The pressure in a roll at one stage of its build-up: a boundary-value problem.

Layers wound later change the strains of a layer wound at r with the stress T.  With the hoop stress
-(P + r P') and the compression F(P) of the stack, compatibility of the increments of its strains
along the web and through the stack requires that

    C(r) = r^2 P'' + 3 r P' + P - E_t F(P)

is the same at all later stages, because its increments are total derivatives.  In x = ln r, with
Q = r P' and D = d/dx:

    D P = Q
    D Q = C + E_t F(P) - P - 2 Q          on the interval from the core to the surface s
    Q = b P - T_c       at the core,  b = E_t/E_c - 1 + nu,  T_c = T(r_c)
    P = P_s             at s: zero, except in a finished roll of layers of finite thickness

A further thin layer adds p = dP/ds, the solution of the linearised equations with T_c = 0, scaled
to p = 1 at s.  Its growth kappa = D p at s determines C of the next layer:

    C(s) = -s T' - T (2 + kappa)

Layers of finite thickness (:class:`.Layers`) are wound under a pressure p(r).  P is then the
pressure in addition to p, and F(P) is replaced by F(P + p) - F(p).

It follows that -D P = T at s; the residual of this relation measures the error of the source.
Newton's method solves for P and kappa together: a fixed-point iteration diverges for long steps.

Discretised by the two-stage Lobatto rule (order four, as in scipy.integrate.solve_bvp) on given
nodes.  Source values belong to a cell, left, middle and right, because C jumps where T has a kink.
The unknowns P0, Q0, P1, Q1, ... have a matrix of five diagonals:

    core      [ -b  1                ]
    cell 0    [ L   L   R   R        ]  2 rows
    cell 1    [         L   L   R  R ]  2 rows
    surface   [                 1  0 ]

Arrays may have a leading axis of lanes across the web, which are then solved together: their
matrices are the diagonal blocks of one with the same five diagonals.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import lapack

__all__ = [
    "CellSource",
    "StageData",
    "StageEquations",
    "StageSolution",
    "interpolate_pressure",
    "source_residual",
]

Array = np.ndarray
MAX_ITERATIONS = 60
BAND = 2  # diagonals on either side
NEWTON_TOLERANCE = 1e-11  # relative change of P by the last Newton step
# Largest last step, relative to the square root of the accepted error.  In tests the accepted error
# followed from a step of 1 to 1.2 times this root.
LAST_STEP = 0.5


class CellSource(NamedTuple):
    """Source C of every cell at its left end, its middle and its right end, (n,) each [Pa]."""

    left: Array
    middle: Array
    right: Array


class StageData(NamedTuple):
    """Nodes, source and boundary values of one stage.

    Attributes
    ----------
    x : (n + 1,) array
        ln r of the nodes.
    source : CellSource
    tension : float
        T_c of the core condition [Pa]; of lanes (L,).
    surface_pressure : float
        P_s [Pa].
    """

    x: Array
    source: CellSource
    tension: Any
    surface_pressure: float = 0.0


class StageSolution(NamedTuple):
    """Pressure P and Q = r P' at the nodes, (n + 1,) each [Pa]; kappa = D p/p at the surface."""

    P: Array
    Q: Array
    growth: Any


@dataclass
class StageEquations:
    """The equations of every stage of one roll.

    Parameters
    ----------
    strain, modulus, modulus_slope : callable
        F(P), E_r(P) and dE_r/dP of the stack.
    tangential : float
        E_t [Pa].
    core : float
        b = E_t/E_c - 1 + nu.
    own_pressure : callable, optional
        p(ln r), the pressure under which layers are wound [Pa]; without it zero.
    """

    strain: Callable[[Array], Any]
    modulus: Callable[[Array], Any]
    modulus_slope: Callable[[Array], Any]
    tangential: float
    core: float
    own_pressure: Callable[[Array], Array] | None = None
    steps: int = field(default=0, init=False)  # number of Newton steps

    @property
    def core_layer(self) -> float:
        """Depth of the layer at a soft core, in ln r: kappa decreases from b as 1/(ln r/r_c + 1/b).

        It follows from the Riccati equation of kappa (:meth:`solve_with_growth`).
        """
        return 1 / max(abs(self.core), 1e-300)

    def _total(self, x: Array, P: Array) -> Array:
        """Return P + p at ln r = x, p the pressure under which the layers are wound [Pa]."""
        return P if self.own_pressure is None else P + self.own_pressure(x)

    def _slope_of_Q(self, x: Array, P: Array, Q: Array) -> Array:
        """Return dQ/dx - C = E_t F(P) - P - 2 Q at x = ln r [Pa], C the source.

        Layers wound under a pressure p have F(P + p) - F(p) in place of F(P).
        """
        F = self.strain(self._total(x, P))
        if self.own_pressure is not None:
            F = F - self.strain(self.own_pressure(x))
        return np.asarray(self.tangential * F - P - 2 * Q)

    def residual(self, stage: StageData, P: Array, Q: Array) -> tuple[Array, Array]:
        """Return the residual of all equations, (2 n + 2,) [Pa], and P in mid-cell, (n,) [Pa].

        The residuals are those of the core condition, of dP/dx = Q and of the equation of Q in turn
        for each cell, integrated by the Lobatto rule, and of the surface condition.

        Parameters
        ----------
        stage : StageData
        P, Q : (n + 1,) arrays
            Pressure, and Q = r dP/dr [Pa].
        """
        x, source = stage.x, stage.source
        x_left, P_left, Q_left = (values[..., :-1] for values in (x, P, Q))
        x_right, P_right, Q_right = (values[..., 1:] for values in (x, P, Q))
        h = x_right - x_left
        slope = self._slope_of_Q(x, P, Q)
        left, right = slope[..., :-1] + source.left, slope[..., 1:] + source.right
        middle_P = (P_right + P_left) / 2 - h / 8 * (Q_right - Q_left)
        middle_Q = (Q_right + Q_left) / 2 - h / 8 * (right - left)
        middle = self._slope_of_Q(x_left + h / 2, middle_P, middle_Q) + source.middle
        out = np.empty((*x.shape[:-1], 2 * x.shape[-1]))
        out[..., 0] = Q[..., 0] - self.core * P[..., 0] + stage.tension
        out[..., -1] = P[..., -1] - stage.surface_pressure
        out[..., 1:-1:2] = P_right - P_left - h / 6 * (Q_left + 4 * middle_Q + Q_right)
        out[..., 2:-1:2] = Q_right - Q_left - h / 6 * (left + 4 * middle + right)
        return out, middle_P

    def _moduli(self, x: Array, P: Array, middle_P: Array) -> Array:
        """Return E_r at the nodes, then in mid-cell, (2 n + 1,) [Pa]."""
        points = np.concatenate([x, (x[..., 1:] + x[..., :-1]) / 2], axis=-1)
        pressures = np.concatenate([P, middle_P], axis=-1)
        return np.asarray(self.modulus(self._total(points, pressures)))

    def _matrix(self, x: Array, E: Array) -> Array:
        """Return the Jacobian of the residual with respect to P and Q in LAPACK's band storage.

        With g = E_t/E_r - 1, J = [[0, 1], [g, -2]] at an end of a cell, and M = 1/2 -+ h/8 J, the
        derivative of the values in mid-cell by those at that end, the block of a cell is
        -+1 - h/6 (J + 4 J_mid M).

        Parameters
        ----------
        x : (n + 1,) array
        E : (2 n + 1,) array
            E_r at the nodes, then in mid-cell [Pa].
        """
        n, h = x.shape[-1] - 1, x[..., 1:] - x[..., :-1]
        g = self.tangential / E - 1
        g_node, g_mid = g[..., : n + 1], g[..., n + 1 :]
        twelfth_h2, mid_term = h * h / 12, h / 3 * g_mid
        product = twelfth_h2 * g_mid
        band = np.zeros((3 * BAND + 1, 2 * x.size), order="F")
        # a view with the columns of every lane; entry (i, j) is in row diagonal + i - j
        columns, diagonal = band.T.reshape(*x.shape[:-1], 2 * (n + 1), 3 * BAND + 1), 2 * BAND
        for first, side, end in ((0, -1.0, g_node[..., :-1]), (2, 1.0, g_node[..., 1:])):
            # the columns of P and Q at the left and at the right end of each cell
            for i, j, value in (
                (1, first, side + side * twelfth_h2 * end),
                (1, first + 1, -h / 2 - side * 2 * twelfth_h2),
                (2, first, -h / 6 * (1 + side * h) * end - mid_term),
                (2, first + 1, side + h + side * (4 * twelfth_h2 + product)),
            ):
                columns[..., j : j + 2 * n : 2, diagonal + i - j] = value
        columns[..., 0, diagonal], columns[..., 1, diagonal - 1] = -self.core, 1.0
        columns[..., -2, diagonal + 1] = 1.0
        return band

    def solve_linearised(
        self, stage: StageData, P: Array, Q: Array, *right_hand_sides: Array
    ) -> tuple[Array, Array] | None:
        """Solve the linearised equations for several right-hand sides; None if that fails.

        Returns
        -------
        (2 + k, 2 n + 2) array
            In its rows, with P and Q alternating: the negative Newton step, p and D p of a
            further layer, and the solutions for the k further right-hand sides; of lanes
            (2 + k, L, 2 n + 2).
        (n + 1,) array
            E_r at the nodes.
        """
        x = stage.x
        residual, middle_P = self.residual(stage, P, Q)
        E = self._moduli(x, P, middle_P)
        self.steps += 1
        factors, pivots, info = lapack.dgbtrf(self._matrix(x, E), BAND, BAND, overwrite_ab=1)
        if info != 0 or not np.isfinite(residual).all():
            return None
        right = np.zeros((2 + len(right_hand_sides), *residual.shape))
        right[0], right[1, ..., -1] = residual, 1.0
        for k, values in enumerate(right_hand_sides):
            right[2 + k] = values
        columns = right.reshape(len(right), residual.size).T
        solved = lapack.dgbtrs(factors, BAND, BAND, columns, pivots, overwrite_b=1)[0]
        return solved.T.reshape(right.shape), E[..., : x.shape[-1]]

    def solve(self, stage: StageData, P: Array, Q: Array) -> StageSolution | None:
        """Solve by Newton's method from an initial guess; None if it does not converge.

        Parameters
        ----------
        stage : StageData
        P, Q : (n + 1,) arrays
            Initial guess [Pa].
        """
        for _ in range(MAX_ITERATIONS):
            solutions = self.solve_linearised(stage, P, Q)
            if solutions is None:
                return None
            step, layer = solutions[0]  # each with P and Q alternating
            P, Q = P - step[..., ::2], Q - step[..., 1::2]
            if np.max(np.abs(step[..., ::2])) <= NEWTON_TOLERANCE * np.max(np.abs(P)):
                return StageSolution(P, Q, layer[..., -1][()])  # the last D p: kappa, for p = 1
        return None

    def kappa_by_pressure(self, x: Array, P: Array, layer: Array, E: Array) -> Array:
        """Return the derivatives of kappa of a stage by the pressures at its nodes [1/Pa].

        With g = E_t/E_r - 1, kappa(x) = D p/p satisfies the Riccati equation
        D kappa + kappa^2 + 2 kappa = g.  Hence a change dg(x) changes kappa at the surface by the
        integral of exp(2 (x - ln s)) p^2 dg, for p = 1 at s.

        Parameters
        ----------
        x, P, layer, E : (n + 1,) arrays
            ln r of the nodes, pressure, p of a further layer and E_r there.
        """
        half = np.diff(x) / 2
        quadrature = np.exp(2 * (x - x[..., -1:]))
        quadrature[..., :-1] *= half + np.concatenate([0 * half[..., :1], half[..., :-1]], axis=-1)
        quadrature[..., -1] *= half[..., -1]
        # some laws have an infinite slope at P = 0, where p has no effect
        E_slope = np.nan_to_num(self.modulus_slope(self._total(x, P)), posinf=0.0)
        return -quadrature * layer**2 * self.tangential * E_slope / E**2

    def solve_with_growth(
        self,
        stage: StageData,
        source_by_kappa: CellSource,
        P: Array,
        Q: Array,
        growth: float,
        accepted_error: float,
    ) -> StageSolution | None:
        """Solve for pressure and kappa of a stage together; None if that does not converge.

        The unknowns (P, Q) and kappa are eliminated in turn.  For a change d of kappa the step of
        (P, Q) is step + d by_kappa, and kappa must equal the D p of a further layer on it:

            kappa + d = D p - kappa_by_P (step + d by_kappa).

        Parameters
        ----------
        stage : StageData
            With the source for the guess of kappa.
        source_by_kappa : CellSource
            Derivative of the source with respect to kappa.
        P, Q : (n + 1,) arrays
            Initial guess [Pa].
        growth : float
            Initial guess of kappa.
        accepted_error : float
            Accepted error of kappa, relative to kappa + 2.  Newton's method converges
            quadratically: the error after a step is about the square of the step.
        """
        x = stage.x
        residual_by_kappa = source_residual(x, source_by_kappa)
        for _ in range(MAX_ITERATIONS):
            solutions = self.solve_linearised(stage, P, Q, residual_by_kappa)
            if solutions is None:
                return None
            (step, layer, by_kappa), E = solutions  # P, Q -= step
            kappa_by_P = self.kappa_by_pressure(x, P, layer[::2], E)
            change = layer[-1] - growth - kappa_by_P @ step[::2]
            change /= 1 + kappa_by_P @ by_kappa[::2]
            step += change * by_kappa
            P, Q, growth = P - step[::2], Q - step[1::2], growth + float(change)
            relative = np.max(np.abs(step[::2])) / np.max(np.abs(P))
            if max(relative, abs(change) / (2 + abs(growth))) <= LAST_STEP * accepted_error**0.5:
                return StageSolution(P, Q, growth)
            C = zip(stage.source, source_by_kappa, strict=True)
            stage = stage._replace(source=CellSource(*(c + change * dc for c, dc in C)))
        return None

    def linear_response(
        self, x: Array, P: Array, Q: Array, change: CellSource
    ) -> tuple[Array, Array]:
        """Return the linear response of P and Q to a small change of the source [Pa].

        Two (n + 1,) arrays, infinite if the linearised equations are singular.

        Parameters
        ----------
        x, P, Q : (n + 1,) arrays
            ln r of the nodes, pressure and Q = r dP/dr there [Pa].
        change : CellSource
            Change of the source C in every cell [Pa].
        """
        middle = (P[1:] + P[:-1]) / 2 - np.diff(x) / 8 * np.diff(Q)
        band = self._matrix(x, self._moduli(x, P, middle))
        factors, pivots, info = lapack.dgbtrf(band, BAND, BAND, overwrite_ab=1)
        self.steps += 1
        if info != 0:
            return np.full_like(P, np.inf), np.full_like(Q, np.inf)
        out, _ = lapack.dgbtrs(factors, BAND, BAND, -source_residual(x, change), pivots)
        return out[::2], out[1::2]


def source_residual(x: Array, source: CellSource) -> Array:
    """Return the contribution of a source to the residual of :class:`StageEquations`, (2 n + 2,).

    ``x`` is ln r of the nodes, (n + 1,); of lanes (L, n + 1).
    """
    h, (left, middle, right) = np.diff(x), source
    out = np.zeros((*x.shape[:-1], 2 * x.shape[-1]))
    out[..., 1:-1:2] = h * h / 12 * (right - left)
    out[..., 2:-1:2] = -h / 6 * (left + 4 * middle + right + h * (right - left))
    return out


def interpolate_pressure(x: Array, P: Array, Q: Array, x_new: Array) -> tuple[Array, Array]:
    """Interpolate P and Q = dP/d ln r by cubic Hermite polynomials (order four).

    Parameters
    ----------
    x, P, Q : (n + 1,) arrays
        ln r of the nodes, and the values there [Pa]; of lanes (L, n + 1) on the same nodes.
    x_new : (k,) array
        ln r between the first and the last node.

    Returns
    -------
    two (k,) arrays
    """
    k = np.clip(np.searchsorted(x, x_new, side="right") - 1, 0, x.size - 2)
    h = x[k + 1] - x[k]
    t = (x_new - x[k]) / h
    P0, q0, q1 = P[..., k], Q[..., k], Q[..., k + 1]
    chord = (P[..., k + 1] - P0) / h
    c2, c3 = 3 * chord - 2 * q0 - q1, q0 + q1 - 2 * chord
    return P0 + h * t * (q0 + t * (c2 + t * c3)), q0 + t * (2 * c2 + 3 * t * c3)
