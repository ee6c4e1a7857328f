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
    P = P_s             at s: zero while further layers are wound

A further thin layer adds p = dP/ds, the solution of the linearised equations with T_c = 0, scaled
to p = 1 at s.  Its growth kappa = D p at s determines C of the next layer:

    C(s) = -s T' - T (2 + kappa)

Layers are wound under the pressure p(r) of half a layer (:class:`.Layers`).  P is the pressure in
addition to p, the *total* is P + p, and F(P) is replaced by F(P + p) - F(p).  In a finished roll
the total is zero at the surface, P_s = -p, and off its core also at its innermost radius, instead
of the core condition.

It follows that -D P = T at s; the residual of this relation measures the error of the source.

In a roll that runs at the surface speed V the layers carry the body force rho omega^2 r, with
omega = V/s.  With c = rho V^2 and B(r; s) = c r^2/s^2 equilibrium is sigma_t = -(P + Q) + B, and

    D Q = C + (3 + nu) B + E_t F(P) - P - 2 Q
    Q = b P - T_c + B      at the core

with a source C that is the same at all stages, and at rest.  A further layer presses with T - c
alone, and the roll slows down: dP/d ln s = T q solves the linearised equations with the source
-2 (3 + nu) B/T, with D q = b q - 2 B/T at the core, and q = 1 - c/T at s.  The source of the next
layer is again C(s) = -s T' - T (2 + kappa), with

    kappa = D q + (1 + nu) c/T;        -D P = T - c at s.

So defined, kappa is the growth without rotation, and T (1 + kappa)/E_t in both cases the inward
displacement of the surface by a further layer, relative to the thickness of the layer.
Newton's method solves for P and kappa together: a fixed-point iteration diverges for long steps.

Discretised by the two-stage Lobatto rule (order four, as in scipy.integrate.solve_bvp) on given
nodes.  Source values belong to a cell, left, middle and right, because C jumps where T has a kink.
The unknowns P0, Q0, P1, Q1, ... have a matrix of five diagonals:

    core      [ -b  1                ]
    cell 0    [ L   L   R   R        ]  2 rows
    cell 1    [         L   L   R  R ]  2 rows
    surface   [                 1  0 ]

Stages do not depend on each other but for their source.  Several of them, one after the other, are
one system of the same form: the two rows of the *gap* between the last node of a stage and the
first of the next one are the conditions at this surface and at that core.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from copy import copy
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import lapack

__all__ = [
    "CellSource",
    "GrowthEffect",
    "OwnPressure",
    "StageData",
    "StageEquations",
    "StageSolution",
    "initial_guess",
    "interpolate_pressure",
    "interpolate_stages",
    "joined",
    "source_residual",
    "stretched",
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


class OwnPressure(NamedTuple):
    """Pressure p under which layers are wound [Pa], and their compression F(p), at some points."""

    pressure: Array
    strain: Array

    def part(self, points: slice) -> OwnPressure:
        """Return the values at some of the points."""
        return OwnPressure(self.pressure[points], self.strain[points])


@dataclass
class StageData:
    """Nodes, source and boundary values of one stage, or of J stages, one after the other.

    Attributes
    ----------
    x : (n + 1,) array
        ln r of the nodes.
    source : CellSource
        Without meaning in gaps, but finite.
    tension : float
        T_c of the core condition [Pa], one of all stages or (J,) of each.
    surface_pressure : float
        P_s [Pa], one of all stages or (J,) of each.
    off_core : bool or (J,) bool array
        True for a stage without contact at its innermost radius.
    laid_tension : float or (J,) array
        T of the outermost layer [Pa], on which only kappa of a running roll depends.
    own : OwnPressure, optional
        At the nodes, then in mid-cell, (2 n + 1,) each; without it zero, in the limit of thin
        layers.
    turn : float or (J,) array
        Factor of B of a running roll, 1 if the web speed is that of the surface [1].
    gaps : (J - 1,) int array
        Last node of each stage but the last one, which is also the number of the gap behind it
        among the cells.
    """

    x: Array
    source: CellSource
    tension: float | Array
    surface_pressure: float | Array = 0.0
    off_core: bool | Array = False
    gaps: Array = field(default_factory=lambda: np.zeros(0, dtype=int))
    laid_tension: float | Array = np.nan
    own: OwnPressure | None = None
    turn: float | Array = 1.0

    @cached_property
    def firsts(self) -> Array:
        """First node of each stage, (J,)."""
        return np.append(0, self.gaps + 1)

    @cached_property
    def lasts(self) -> Array:
        """Last node of each stage, (J,)."""
        return np.append(self.gaps, self.x.size - 1)

    @cached_property
    def depths(self) -> Array:
        """ln r of the nodes relative to that of the surface of their stage, (n + 1,), <= 0."""
        return self.x - np.repeat(self.x[self.lasts], self.lasts - self.firsts + 1)

    @cached_property
    def lengths(self) -> Array:
        """Lengths of the cells in ln r, (n,); zero in gaps."""
        h = self.x[1:] - self.x[:-1]
        h[self.gaps] = 0.0
        return h

    def total(self, P: Array) -> Array:
        """Return P + p for P at the nodes, (n + 1,), or also in mid-cell, (2 n + 1,) [Pa]."""
        return P if self.own is None else P + self.own.pressure[: P.size]

    def with_source_changed(self, change: CellSource) -> StageData:
        """Return the stages with a change added to the source."""
        changed = copy(self)
        changed.source = CellSource(*(C + dC for C, dC in zip(self.source, change, strict=True)))
        return changed


class StageSolution(NamedTuple):
    """Pressure P and Q = r dP/dr at the nodes, (n + 1,) each [Pa]; kappa = D p/p, (J,) surfaces."""

    P: Array
    Q: Array
    growth: Array

    def parts(self, gaps: Array) -> list[StageSolution]:
        """Return the solution of each stage; ``gaps`` as of :class:`StageData`."""
        kappa = np.split(self.growth, self.growth.size)
        P, Q = (np.split(values, gaps + 1) for values in (self.P, self.Q))
        return [StageSolution(*part) for part in zip(P, Q, kappa, strict=True)]


class GrowthEffect(NamedTuple):
    """Effect of unknown kappa on the source at the 3 n points of the cells.

    The points are the left ends, the middles and the right ends of all cells.  Each depends on K
    of the kappa of J stages.

    Attributes
    ----------
    stages : (3 n, K) int array
        The stages of these kappa, counted from 0.
    factors : (3 n, K) array
        Derivatives of the source with respect to them [Pa].
    """

    stages: Array
    factors: Array

    def of(self, kappa: Array) -> CellSource:
        """Return the change of the source by changes of kappa, (J,) [Pa]."""
        change = np.einsum("pk,pk->p", self.factors, kappa[self.stages])
        return CellSource(*change.reshape(3, -1))

    def by_stage(self, weights: Array, owners: Array, count: int) -> Array:
        """Return weighted sums of the derivatives over the points of each stage.

        The entry (i, k) is the sum of weight times d source/d kappa_k over the points of stage i.

        Parameters
        ----------
        weights : (3 n,) array
        owners : (n,) int array
            The stage of each cell.
        count : int
            J.

        Returns
        -------
        (J, J) array
            Rows: stages of the points, columns: stages of kappa.
        """
        rows = np.tile(owners, 3)[:, None]  # of the points: a cell has three
        columns = self.stages
        # bincount adds the values with the same index: that of the entry in the flat matrix
        entries = rows * count + columns
        weighted = weights[:, None] * self.factors
        sums = np.bincount(entries.ravel(), weighted.ravel(), minlength=count * count)
        return sums.reshape(count, count)


class _Factors(NamedTuple):
    """LU factors of the Jacobian of the residual, and their pivots."""

    lu: Array
    pivots: Array

    def solve(self, right: Array, *, transposed: bool = False) -> Array:
        """Return the solutions for right-hand sides, (2 n + 2,) or (2 n + 2, k)."""
        solutions, _ = lapack.dgbtrs(self.lu, BAND, BAND, right, self.pivots, trans=int(transposed))
        return np.asarray(solutions).reshape(right.shape)


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
    centrifugal : float
        c = rho V^2 of a running roll [Pa]; zero at rest.
    poissons_ratio : float
        nu, needed for a running roll only.
    """

    strain: Callable[[Array], Any]
    modulus: Callable[[Array], Any]
    modulus_slope: Callable[[Array], Any]
    tangential: float
    core: float
    centrifugal: float = 0.0
    poissons_ratio: float = 0.0
    steps: int = field(default=0, init=False)  # number of linear systems

    @property
    def core_layer(self) -> float:
        """Depth of the layer at a soft core, in ln r: kappa decreases from b as 1/(ln r/r_c + 1/b).

        It follows from the Riccati equation of kappa (:meth:`solve_with_growth`).
        """
        return 1 / max(abs(self.core), 1e-300)

    @property
    def at_rest(self) -> StageEquations:
        """The equations of the same roll at rest, with the same source."""
        return replace(self, centrifugal=0.0)

    def growth_on_core(self, tension: float) -> float:
        """Return kappa of the first layer, wound with a stress T [Pa]: b, with c/T less E_t/E_c."""
        stiffness_ratio = self.core + 1 - self.poissons_ratio
        return self.core - self.centrifugal / tension * stiffness_ratio

    def rotation_stress(self, depth: Array) -> Array:
        """Return B = c r^2/s^2 [Pa] at depths ln r/s."""
        return np.asarray(self.centrifugal * np.exp(2 * depth))

    def _rotation_source(self, stage: StageData) -> CellSource:
        """Return (3 + nu) B in every cell [Pa], which a running roll adds to the source."""
        depths, counts = stage.depths, stage.lasts - stage.firsts + 1
        turn = np.repeat(stage.turn + np.zeros(counts.size), counts)
        B, middle_B = map(self.rotation_stress, (depths, depths[:-1] + stage.lengths / 2))
        factor = (3 + self.poissons_ratio) * turn
        return CellSource((factor * B)[:-1], factor[:-1] * middle_B, (factor * B)[1:])

    def _rotation_share(self, stage: StageData) -> Array:
        """Return c/T of the outermost layer of each stage, (J,) [1]; zero at rest."""
        shares = np.zeros(stage.lasts.size)
        return shares + self.centrifugal / stage.laid_tension if self.centrifugal else shares

    def _slope_of_Q(self, P: Array, Q: Array, own: OwnPressure | None, points: slice) -> Array:
        """Return dQ/dx - C = E_t (F(P + p) - F(p)) - P - 2 Q at points of ``own`` [Pa]."""
        if own is None:
            F = self.strain(P)
        else:
            own = own.part(points)
            F = self.strain(P + own.pressure) - own.strain
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
        x, h = stage.x, stage.lengths
        if self.centrifugal:
            source = stage.with_source_changed(self._rotation_source(stage)).source
        else:
            source = stage.source
        nodes, cells = slice(x.size), slice(x.size, None)
        slope = self._slope_of_Q(P, Q, stage.own, nodes)
        left, right = slope[:-1] + source.left, slope[1:] + source.right
        middle_P = (P[1:] + P[:-1]) / 2 - h / 8 * (Q[1:] - Q[:-1])
        middle_Q = (Q[1:] + Q[:-1]) / 2 - h / 8 * (right - left)
        middle = self._slope_of_Q(middle_P, middle_Q, stage.own, cells) + source.middle
        out = np.empty(2 * x.size)
        out[1:-1:2] = P[1:] - P[:-1] - h / 6 * (Q[:-1] + 4 * middle_Q + Q[1:])
        out[2:-1:2] = Q[1:] - Q[:-1] - h / 6 * (left + 4 * middle + right)
        firsts, lasts = stage.firsts, stage.lasts
        B = stage.turn * self.rotation_stress(stage.depths[firsts])
        out[2 * firsts] = np.where(
            stage.off_core,
            stage.total(P)[firsts],
            Q[firsts] - self.core * P[firsts] + stage.tension - B,
        )
        out[2 * lasts + 1] = P[lasts] - stage.surface_pressure
        return out, middle_P

    def _moduli(self, stage: StageData, P: Array, middle_P: Array) -> Array:
        """Return E_r at the nodes, then in mid-cell, (2 n + 1,) [Pa]."""
        return np.asarray(self.modulus(stage.total(np.concatenate([P, middle_P]))))

    def _matrix(self, stage: StageData, E: Array) -> Array:
        """Return the Jacobian of the residual with respect to P and Q in LAPACK's band storage.

        With g = E_t/E_r - 1, J = [[0, 1], [g, -2]] at an end of a cell, and M = 1/2 -+ h/8 J, the
        derivative of the values in mid-cell by those at that end, the block of a cell is
        -+1 - h/6 (J + 4 J_mid M).

        Parameters
        ----------
        stage : StageData
        E : (2 n + 1,) array
            E_r at the nodes, then in mid-cell [Pa].
        """
        n, h, gaps = stage.x.size - 1, stage.lengths, stage.gaps
        g = self.tangential / E - 1
        g_node, g_mid = g[: n + 1], g[n + 1 :]
        twelfth_h2, mid_term = h * h / 12, h / 3 * g_mid
        product = twelfth_h2 * g_mid
        band = np.zeros((3 * BAND + 1, 2 * (n + 1)), order="F")
        diagonal = 2 * BAND  # entry (i, j) is in row diagonal + i - j
        for first, side, end in ((0, -1.0, g_node[:-1]), (2, 1.0, g_node[1:])):
            # the columns of P and Q at the left and at the right end of each cell
            for i, j, value in (
                (1, first, side + side * twelfth_h2 * end),
                (1, first + 1, -h / 2 - side * 2 * twelfth_h2),
                (2, first, -h / 6 * (1 + side * h) * end - mid_term),
                (2, first + 1, side + h + side * (4 * twelfth_h2 + product)),
            ):
                value[gaps] = 0.0
                band[diagonal + i - j, j : j + 2 * n : 2] = value
        # the first and the last equation, and both of each gap
        band[diagonal, 2 * stage.firsts] = np.where(stage.off_core, 1.0, -self.core)
        band[diagonal - 1, 2 * stage.firsts + 1] = np.where(stage.off_core, 0.0, 1.0)
        band[diagonal + 1, 2 * stage.lasts] = 1.0
        return band

    def _factorised(self, stage: StageData, P: Array, middle_P: Array) -> tuple[_Factors, Array]:
        """Return the factorised Jacobian, and E_r at the nodes, (n + 1,) [Pa].

        ``P`` and ``middle_P`` are the pressures at the nodes and in mid-cell.

        Raises
        ------
        SingularStageError
        """
        E = self._moduli(stage, P, middle_P)
        self.steps += 1
        factors, pivots, info = lapack.dgbtrf(self._matrix(stage, E), BAND, BAND, overwrite_ab=1)
        if info != 0:
            raise SingularStageError
        return _Factors(factors, pivots), E[: P.size]

    def linearised(
        self, stage: StageData, P: Array, Q: Array
    ) -> tuple[_Factors, Array, Array, Array]:
        """Return the factorised Jacobian, E_r at the nodes, the Newton step and a further layer.

        The negative step of P and Q, and q = s (dP/ds)/T of a layer with D q, are (2 n + 2,)
        arrays, the values of each node alternating.

        Raises
        ------
        SingularStageError
        """
        residual, middle_P = self.residual(stage, P, Q)
        if not np.isfinite(residual).all():
            raise SingularStageError
        factors, E = self._factorised(stage, P, middle_P)
        right = np.zeros((residual.size, 2), order="F")
        right[:, 0], right[:, 1] = residual, self._layer_loads(stage)
        step, layer = factors.solve(right).T
        return factors, E, step, layer

    def _layer_loads(self, stage: StageData) -> Array:
        """Return the right-hand side for q = s (dP/ds)/T of a further layer, (2 n + 2,).

        At rest it is 1 at each surface.  A running roll slows down: B decreases as s^-2.
        """
        right, share = np.zeros(2 * stage.x.size), self._rotation_share(stage)
        if self.centrifugal:
            in_cells = 2 * source_residual(stage.lengths, self._rotation_source(stage))
            values = 2 * (stage.lasts - stage.firsts + 1)  # of P and Q of each stage
            T = stage.laid_tension + np.zeros(share.size)
            right = in_cells / np.repeat(T, values)
            B = self.rotation_stress(stage.depths[stage.firsts])
            right[2 * stage.firsts] = -2 * B / stage.laid_tension
        right[2 * stage.lasts + 1] = 1 - share
        return right

    def growth_of_layer(self, stage: StageData, layer: Array) -> Array:
        """Return kappa of each stage, (J,), from q and D q of a further layer, (2 n + 2,)."""
        share = self._rotation_share(stage)
        return np.asarray(layer[2 * stage.lasts + 1] + (1 + self.poissons_ratio) * share)

    def _unit_layer(self, stage: StageData, factors: _Factors, layer: Array) -> Array:
        """Return the increment p with p = 1 at the surface, of the roll at one speed, and D p.

        ``layer`` is q of a further layer; at rest both are the same.  (2 n + 2,) arrays.
        """
        if not self.centrifugal:
            return layer
        right = np.zeros(layer.size)
        right[2 * stage.lasts + 1] = 1.0
        return factors.solve(right)

    def solve(self, stage: StageData, P: Array, Q: Array) -> StageSolution | None:
        """Solve by Newton's method from an initial guess; None if it does not converge.

        Parameters
        ----------
        stage : StageData
        P, Q : (n + 1,) arrays
            Initial guess [Pa].
        """
        for _ in range(MAX_ITERATIONS):
            try:
                _, _, step, layer = self.linearised(stage, P, Q)
            except SingularStageError:
                return None
            P, Q = P - step[::2], Q - step[1::2]
            if _relative_step(stage, step, P) <= NEWTON_TOLERANCE:
                return StageSolution(P, Q, self.growth_of_layer(stage, layer))
        return None

    def kappa_by_pressure(
        self, stage: StageData, P: Array, layer: Array, unit_layer: Array, E: Array
    ) -> Array:
        """Return the derivatives of kappa of each stage by the pressures at its nodes [1/Pa].

        With g = E_t/E_r - 1, q satisfies D(r^2 D q) - g r^2 q = r^2 f, f its source, and p the same
        equation without source.  Green's identity: a change dg(x) changes D q at the surface, and
        kappa, by the integral of exp(2 (x - ln s)) p q dg, for p = 1 at s.

        Parameters
        ----------
        stage : StageData
        P, layer, unit_layer, E : (n + 1,) arrays
            Pressure, q of a further layer, p and E_r at the nodes.
        """
        half = stage.lengths / 2
        quadrature = np.exp(2 * stage.depths) * (np.append(half, 0) + np.append(0, half))
        # some laws have an infinite slope at P = 0, where p has no effect
        E_slope = self.modulus_slope(stage.total(P))
        E_slope = np.where(np.isfinite(E_slope), E_slope, 0.0)
        return np.asarray(-quadrature * layer * unit_layer * self.tangential * E_slope / E**2)

    def solve_with_growth(
        self,
        stage: StageData,
        effect: GrowthEffect,
        P: Array,
        Q: Array,
        growth: Array,
        accepted_error: float,
    ) -> StageSolution | None:
        """Solve for pressure and kappa of stages together; None if that does not converge.

        The unknowns U = (P, Q) and kappa are eliminated in turn.  For changes d of all kappa the
        step is step + J^-1 R d, J the Jacobian and R d the change of the residual by the source,
        and kappa of each stage must equal that of a further layer on it, kappa_q:

            kappa + d = kappa_q - kappa_by_P (step + J^-1 R d).

        kappa_by_P J^-1 follows from one solution with the transpose of J.  A stage depends on the
        kappa of no later one.

        Parameters
        ----------
        stage : StageData
            With the source for the guess of kappa.
        effect : GrowthEffect
            Of kappa on the source.
        P, Q : (n + 1,) arrays
            Initial guess [Pa].
        growth : (J,) array
            Initial guess of kappa.
        accepted_error : float
            Accepted error of kappa, relative to kappa + 2.  Newton's method converges
            quadratically: the error after a step is about the square of the step.
        """
        firsts, lasts, h = stage.firsts, stage.lasts, stage.lengths
        count = lasts.size
        owners = np.repeat(np.arange(count), lasts - firsts + 1)[:-1]
        for _ in range(MAX_ITERATIONS):
            try:
                factors, E, step, layer = self.linearised(stage, P, Q)
            except SingularStageError:
                return None
            unit_layer = self._unit_layer(stage, factors, layer)
            kappa_by_P = self.kappa_by_pressure(stage, P, layer[::2], unit_layer[::2], E)
            adjoint = np.zeros_like(step)
            adjoint[::2] = kappa_by_P
            weights = _source_weights(h, factors.solve(adjoint, transposed=True))
            coupling = np.eye(count) + effect.by_stage(weights, owners, count)
            missing = self.growth_of_layer(stage, layer) - growth
            missing -= np.add.reduceat(kappa_by_P * step[::2], firsts)
            change, _ = lapack.dtrtrs(coupling, missing, lower=1)
            source_change = effect.of(change)
            step += factors.solve(source_residual(h, source_change))
            P, Q, growth = P - step[::2], Q - step[1::2], growth + change
            relative = np.max(np.abs(change) / (2 + np.abs(growth)))
            if max(_relative_step(stage, step, P), relative) <= LAST_STEP * accepted_error**0.5:
                return StageSolution(P, Q, growth)
            stage = stage.with_source_changed(source_change)
        return None

    def linear_response(self, stage: StageData, P: Array, Q: Array) -> tuple[Array, Array]:
        """Return the linear response of P and Q of stages to a small change of the source [Pa].

        Two (n + 1,) arrays, infinite if the linearised equations are singular.

        Parameters
        ----------
        stage : StageData
            Its ``source`` is the change of the source C in every cell.
        P, Q : (n + 1,) arrays
            Pressure and Q = r dP/dr at the nodes [Pa].
        """
        h = stage.lengths
        try:
            middle_P = (P[1:] + P[:-1]) / 2 - h / 8 * np.diff(Q)
            factors, _ = self._factorised(stage, P, middle_P)
        except SingularStageError:
            return np.full_like(P, np.inf), np.full_like(Q, np.inf)
        out = factors.solve(-source_residual(h, stage.source))
        return out[::2], out[1::2]


class SingularStageError(ArithmeticError):
    """The linearised equations of a stage have no solution."""


def _relative_step(stage: StageData, step: Array, P: Array) -> float:
    """Return the largest Newton step of P, relative to the largest P of its stage.

    ``step`` has the values of P and Q at the nodes, alternating, (2 n + 2,).
    """
    largest = np.maximum.reduceat(np.abs([step[::2], P]), stage.firsts, axis=1)
    return float(np.max(largest[0] / largest[1]))


def source_residual(h: Array, source: CellSource) -> Array:
    """Return the contribution of a source to the residual of :class:`StageEquations`, (2 n + 2,).

    ``h`` are the lengths of the cells, (n,); it is zero in gaps.
    """
    left, middle, right = source
    out = np.zeros(2 * h.size + 2)
    out[1:-1:2] = h * h / 12 * (right - left)
    out[2:-1:2] = -h / 6 * (left + 4 * middle + right + h * (right - left))
    return out


def _source_weights(h: Array, factors: Array) -> Array:
    """Return the derivatives of factors @ :func:`source_residual` by the source, (3 n,).

    ``factors`` are (2 n + 2,); the derivatives are those by the values at the left ends, in the
    middles and at the right ends of the cells.
    """
    of_P, of_Q = h * h / 12 * factors[1:-1:2], -h / 6 * factors[2:-1:2]
    return np.concatenate([(1 - h) * of_Q - of_P, 4 * of_Q, (1 + h) * of_Q + of_P])


def interpolate_pressure(x: Array, P: Array, Q: Array, x_new: Array) -> tuple[Array, Array]:
    """Interpolate P and Q = dP/d ln r by cubic Hermite polynomials (order four).

    Parameters
    ----------
    x, P, Q : (n + 1,) arrays
        ln r of the nodes, and the values there [Pa]; of several rolls (L, n + 1) on the same nodes.
    x_new : (k,) array
        ln r between the first and the last node.

    Returns
    -------
    two (k,) arrays, or (L, k)
    """
    k = np.clip(np.searchsorted(x, x_new, side="right") - 1, 0, x.size - 2)
    h = x[k + 1] - x[k]
    t = (x_new - x[k]) / h
    P0, q0, q1 = P[..., k], Q[..., k], Q[..., k + 1]
    chord = (P[..., k + 1] - P0) / h
    c2, c3 = 3 * chord - 2 * q0 - q1, q0 + q1 - 2 * chord
    return P0 + h * t * (q0 + t * (c2 + t * c3)), q0 + t * (2 * c2 + 3 * t * c3)


def stretched(x: Array, P: Array, Q: Array, x_new: Array) -> tuple[Array, Array]:
    """Return P and Q of a stage, stretched linearly in ln r to another surface, at new nodes.

    Parameters
    ----------
    x, P, Q : (n + 1,) arrays
        ln r of the nodes, and the values there [Pa].
    x_new : (k,) array
        ln r of all new nodes.

    Returns
    -------
    two (k,) arrays
    """
    t = (x_new - x_new[0]) / (x_new[-1] - x_new[0])
    return interpolate_pressure(x, P, Q, x_new - (x_new[-1] - x[-1]) * t)


def initial_guess(
    x: Array, tension: float, known: tuple[Array, Array, Array] | None
) -> tuple[Array, Array]:
    """Return the initial guess of P and Q of a stage, (n + 1,) each [Pa].

    It is a known stage, stretched to the new surface.  Without one, on the core, the pressure
    decreases from the core with the slope of the wound-on stress there.

    Parameters
    ----------
    x : (n + 1,) array
        ln r of the nodes.
    tension : float
        T_c of the core condition [Pa].
    known : tuple of three (k + 1,) arrays, optional
        ln r, P and Q of the known stage.
    """
    if known is None:
        return tension * (x[-1] - x), np.full_like(x, -tension)
    return stretched(*known, x)


def joined(nodes: Sequence[Array]) -> tuple[Array, Array]:
    """Return the nodes of several stages, one after the other, and the gaps between them."""
    return np.concatenate(nodes), np.cumsum([x.size for x in nodes])[:-1] - 1


def interpolate_stages(
    stages: Sequence[tuple[Array, StageSolution]], nodes: Sequence[Array]
) -> tuple[Array, Array]:
    """Interpolate P and Q of several stages at other nodes of the same stages.

    Parameters
    ----------
    stages : sequence of (x, solution)
        Nodes ln r of each stage, and the solution there.
    nodes : sequence of arrays
        The other nodes of each stage.

    Returns
    -------
    two arrays
        Of all stages, one after the other [Pa].
    """
    # shifted so that ln r increases over all stages
    shifts = (1 + nodes[-1][-1] - nodes[-1][0]) * np.arange(len(nodes))
    x = np.concatenate([x + shift for (x, _), shift in zip(stages, shifts, strict=True)])
    x_new = np.concatenate([x + shift for x, shift in zip(nodes, shifts, strict=True)])
    P = np.concatenate([solved.P for _, solved in stages])
    Q = np.concatenate([solved.Q for _, solved in stages])
    return interpolate_pressure(x, P, Q, x_new)
