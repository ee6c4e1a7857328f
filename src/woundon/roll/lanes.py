r"""A roll of lanes across the width of the web: its build-up, stage by stage.

The lanes of a web of uneven thickness have the same number of layers on the same core.  Each lane
j is a roll with its own tension T_j, pressure P_j and kappa_j (:mod:`.build_up`), but the web
connects them: a lane with a larger radius is strained more (:mod:`.lane_tension`).  A layer
increases the radius of the lane's surface by less than its thickness h_j = h (1 + d_j), because it
compresses the layers below and itself, under the mean pressure p_j = T_j h_j/(2 s_j),

    ds_j/dn = h_j g_j,    g_j = 1 - (1 + kappa_j) T_j/E_t - F(p_j).

With the mean radius s = sum w_j s_j as the independent variable, x = ln s, and s_j = s (1 + rho_j)

    d rho_j/dx = h_j g_j/m - 1 - rho_j,    m = sum w_j h_j g_j.

A higher lane is tighter, T_j = T + E_t rho_j, and its g_j smaller by (1 + kappa) rho_j.  With
(1 + kappa) T/E_t small compared with 1, a deviation of the relative height therefore decays like
d rho_j/dx = -(2 + kappa) rho_j, within 1/(2 + kappa) of ln r (and that of the height s rho_j within
s/(1 + kappa) of the radius), a fraction of a stage: the equation is stiff.  Kappa, T and rho are
interpolated between the stages by the same polynomials of order three (:class:`.Growth`), and rho
satisfies its equation at each stage, which is the backward differentiation formula (BDF) of order
three.  Unknowns of a stage are P_j, kappa_j and

    theta_j = T_j/T,    T = WOT/h of the mean web,

of all lanes.  Newton's method eliminates them in turn: P_j with its banded matrix, of all lanes at
once, then kappa_j, then rho_j = c_j - mu_j theta_j from the BDF, at last theta_j from the balances
of the web and the nip.

The roll of the mean web is the reference: the lanes have its stages, with further stages where
their polynomials would have too large an error, and kappa is interpolated as the difference from
its kappa.  Lanes of equal thickness therefore give that roll.

Points of a lane belong to those of the mean roll by their layers: ln r_j = x + ln(1 + rho_j(x)).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import exp
from typing import NamedTuple

import numpy as np

from ..problems.thickness_profile import Lanes
from .build_up import (
    IMPLICIT_ERROR,
    KINK_STEP,
    SMALLEST_STEP,
    STEP_STRETCH,
    BuildUp,
    Layers,
    NotWoundError,
    no_stage_of_roll,
    step_factor,
)
from .equations import (
    CellSource,
    OwnPressure,
    SingularStageError,
    StageData,
    StageSolution,
    initial_guess,
    source_residual,
    stretched,
)
from .growth import Growth
from .lane_tension import TensionOfLanes
from .stage_nodes import cell_source, kinks_of, nodes_between

__all__ = ["LaneBuildUp", "TensionAt", "stage_data", "wind_lanes"]

Array = np.ndarray
# (x = ln s, c, mu, initial theta) -> tension of the lanes with rho = c - mu theta;
# None if it cannot be found from the initial theta
TensionAt = Callable[[float, Array, Array, Array], TensionOfLanes | None]

MAX_ITERATIONS = 60
MAX_STAGES = 5000  # a plain roll has about 50
# Largest last Newton step, relative: quadratic convergence leaves about its square.
LAST_STEP = 1e-5
LEAST_SOFTENING = 0.1  # smallest part of 1 + kappa by which a lane yields to its tension
SMALLEST_PRESSURE = 1e-4  # of the largest: smaller pressures, of slack lanes, count relative to it
# Longest step relative to the one before, that of a plain roll, whose steps are extended to kinks:
# lanes of equal thickness then need no further stages.
LONGEST_GROWTH = 3.0 * (1 + STEP_STRETCH)
# Rows of the functions of every lane; from LOAD on there is one for each nip.
KAPPA, THETA, RHO, WEB, LOAD = range(5)


class _Points(NamedTuple):
    """Values at the left end, in the middle and at the right end of the cells of a stage.

    Attributes
    ----------
    functions, slopes : (3, L, 3 n) arrays
        KAPPA, THETA and RHO of the lanes with the guess of the stage, and d/dx of them.
    basis, basis_slope : (3 n,) arrays
        Their derivatives by the values at the stage.
    tension, tension_slope, kappa : (3 n,) arrays
        T and dT/dx of the mean web [Pa], and kappa of its roll.
    """

    functions: Array
    slopes: Array
    basis: Array
    basis_slope: Array
    tension: Array
    tension_slope: Array
    kappa: Array


class _Sources(NamedTuple):
    """Nodes, sources and pressures under which the layers are wound, of the lanes at a stage.

    Attributes
    ----------
    nodes : (L, n + 1) array
        ln r_j of each lane.
    source, by_kappa, by_theta : CellSource
        C [Pa], and its derivatives by kappa and theta of the stage; (L, n) arrays.
    own : OwnPressure
        p of the lanes, one after the other, as of :class:`.StageData`.
    own_slope, own_by_theta : (L, n + 1) arrays
        dp/d ln r, at a kink of its outer side, and the derivative of p by theta of the stage [Pa].
    """

    nodes: Array
    source: CellSource
    by_kappa: CellSource
    by_theta: CellSource
    own: OwnPressure
    own_slope: Array
    own_by_theta: Array


class _Eliminated(NamedTuple):
    """A Newton step of P, Q and kappa as functions of the change dtheta of theta.

        P, Q -= step + dkappa of_kappa + dtheta of_theta,    dkappa = free - softening dtheta

    Attributes
    ----------
    step, of_kappa, of_theta : (L, n + 1, 2) arrays
        P and Q in the last axis [Pa].
    free, softening : (L,) arrays
        kappa + dkappa is that of a further layer.
    """

    step: Array
    of_kappa: Array
    of_theta: Array
    free: Array
    softening: Array


@dataclass
class LaneBuildUp:
    """The lanes at one stage.

    Attributes
    ----------
    curves : Growth
        The functions of all lanes over ln s, (J, (4 + K) L): the difference of kappa from that of
        the mean roll, theta, rho, and web tension and the loads of K nips relative to their means.
    x : (n + 1,) array
        ln r of the nodes in the mean roll.
    P, Q : (L, n + 1) arrays
        Pressure at the same layers of the lanes, and r dP/dr [Pa].
    reference_P, reference_Q : (n + 1,) arrays
        Those of the mean roll.
    largest_error : float
        Largest error estimate of this and the previous stages, relative to kappa + 2 and to the
        mean tension.  It exceeds the tolerance where the tension or kappa of a lane jumps: no step
        is short enough there.
    data : StageData, optional
        Nodes, source, core tension and own pressure of the lanes, one after the other; None before
        the last stage.
    own_slope : (L, n + 1) array, optional
        dp/d ln r of the own pressure [Pa]; as ``data``.
    """

    curves: Growth
    x: Array
    P: Array
    Q: Array
    reference_P: Array
    reference_Q: Array
    largest_error: float
    data: StageData | None = None
    own_slope: Array | None = None

    def functions(self, x: Array) -> Array:
        """Return the functions of the lanes at ln s (k,), (4 + K, L, k)."""
        values = self.curves(x)
        return np.moveaxis(values.reshape(x.size, -1, self.P.shape[0]), 0, -1)


def wind_lanes(
    layers: Layers,
    lanes: Lanes,
    tension_at: TensionAt,
    reference: BuildUp,
    *,
    tolerance: float,
    cells: int,
    surface_layer: float,
    report: Callable[[float], None] | None = None,
) -> LaneBuildUp:
    """Wind the lanes of a roll with the stages of the roll of the mean web, and further ones.

    Parameters
    ----------
    layers : Layers
        Of the mean web.
    lanes : Lanes
    tension_at : callable
        Web, and nip if there is one.
    reference : BuildUp
        The roll of the mean web.
    tolerance : float
        Tolerance of kappa, relative to kappa + 2, and of theta.
    cells : int
        Cells of each stage.
    surface_layer : float
        Depth of the layer below the surface, in ln r.
    report : callable, optional
        Is called with each stage's mean radius [m].

    Raises
    ------
    NotWoundError
        If a stage cannot be solved.
    """
    roll = _Lanes(layers, lanes, tension_at, reference, cells, surface_layer)
    kinks, step = reference.growth.kinks, np.inf
    stages = zip(reference.nodes, reference.solutions, strict=True)
    for number, known in enumerate(stages, start=1):
        target = float(known[0][-1])
        while roll.x < target:
            if report is not None:
                report(exp(roll.x))
            remaining = target - roll.x
            # two equal steps rather than a full and a tiny one
            length = remaining if step >= remaining else min(step, remaining / 2)
            whole = length == remaining
            stage, error = roll.stage(
                target if whole else roll.x + length, known if whole else None
            )
            if stage is None or error > tolerance:
                step = length * max(0.2, step_factor(tolerance / error) if stage else 0.2)
                if step < SMALLEST_STEP:
                    raise NotWoundError(_no_stage_of_lanes(roll.x))
                if stage is None or step > KINK_STEP * surface_layer:
                    continue
                # a lane that becomes slack or taut, or the discretisation error of the nodes
                roll.last.curves.start_new_polynomial()
                stage, error = roll.stage(roll.x + step, None)
                if stage is None:
                    continue
                length = step
            roll.last = stage
            step = length * min(LONGEST_GROWTH, step_factor(tolerance / max(error, 1e-99)))
            if roll.last.curves.x.size > MAX_STAGES:
                raise NotWoundError(_no_stage_of_lanes(roll.x))
        step = max(step, remaining)
        if number in kinks:
            roll.last.curves.start_new_polynomial()
    return roll.finished()


class _Core(NamedTuple):
    """The lanes on the core, before the first layer; see :class:`LaneBuildUp`."""

    curves: Growth
    largest_error: float = 0.0


class _Lanes:
    """Lanes during winding: the last stage, and the data common to all stages.

    Parameters as of :func:`wind_lanes`.

    Attributes
    ----------
    last : LaneBuildUp
        The last stage; at first the core.

    Raises
    ------
    NotWoundError
        If the tension of the first layer cannot be found.
    """

    def __init__(
        self,
        layers: Layers,
        lanes: Lanes,
        tension_at: TensionAt,
        reference: BuildUp,
        cells: int,
        surface_layer: float,
    ) -> None:
        self.layers, self.lanes = layers, lanes
        self.equations, self.tension = layers.equations, layers.tension
        self.tension_at, self.reference = tension_at, reference
        self.cells, self.surface_layer = cells, surface_layer
        start, zero = float(reference.growth.x[0]), np.zeros(lanes.share.size)
        on_core = tension_at(start, zero, zero, zero + 1)
        if on_core is None:
            raise NotWoundError(_no_stage_of_lanes(start))
        values = np.concatenate([zero, on_core.wound_on, zero, on_core.web, *on_core.load])
        self.T_c = float(self.tension.at(np.array([exp(start)]))[0])
        self.core_tension = self.T_c * on_core.wound_on
        self.last: LaneBuildUp | _Core = _Core(Growth(start, values))

    @property
    def x(self) -> float:
        """ln s of the last stage."""
        return float(self.last.curves.x[-1])

    def stage(
        self, surface: float, known: tuple[Array, StageSolution] | None
    ) -> tuple[LaneBuildUp | None, float]:
        """Return the next stage and its error estimate; None and inf if it cannot be solved.

        Parameters
        ----------
        surface : float
            ln s.
        known : (nodes, solution), optional
            The stage of the mean roll; without it, that is solved with its known kappa.
        """
        if known is None:
            nodes, P, Q = self._reference_stage(surface)
        else:
            nodes, P, Q = known[0], known[1].P, known[1].Q
        curves = self.last.curves
        guess = np.array(curves.extrapolate(surface)).reshape(-1, self.lanes.share.size)
        solved = self._solve(nodes, P, Q, guess)
        if solved is None:
            return None, np.inf
        values, lane_P, lane_Q = solved
        kappa = float(self.reference.growth(nodes[-1:])[0]) + values[KAPPA]
        change = np.abs(values - guess)
        error = max(np.max(change[KAPPA] / (2 + np.abs(kappa))), np.max(change[THETA]))
        error = IMPLICIT_ERROR * float(error)
        extended = curves.with_stage(surface, values.ravel())
        largest = max(error, self.last.largest_error)
        return LaneBuildUp(extended, nodes, lane_P, lane_Q, P, Q, largest), error

    def _reference_stage(self, surface: float) -> tuple[Array, Array, Array]:
        """Return nodes, P and Q of the mean roll at another stage than its own.

        Raises
        ------
        NotWoundError
        """
        growth, start = self.reference.growth, float(self.reference.growth.x[0])
        kinks = kinks_of(self.tension, growth)
        core_layer = self.equations.core_layer
        nodes = nodes_between(start, surface, self.cells, self.surface_layer, *kinks, core_layer)
        source = cell_source(self.tension, growth, nodes)
        last = self.last
        known = None
        if isinstance(last, LaneBuildUp):
            known = last.x, last.reference_P, last.reference_Q
        stage = StageData(nodes, source, self.T_c, own=self.layers.own(nodes))
        solved = self.equations.solve(stage, *initial_guess(nodes, self.T_c, known))
        if solved is None:
            raise NotWoundError(no_stage_of_roll(surface))
        return nodes, solved.P, solved.Q

    def _pressure_guess(self, nodes: Array, P: Array, Q: Array) -> tuple[Array, Array]:
        """Return the initial guess of P and Q of the lanes, (L, n + 1) each [Pa].

        It differs from the mean roll, ``P`` and ``Q``, as the previous stage did.
        """
        last = self.last
        if isinstance(last, _Core):
            theta = last.curves.kappa[0].reshape(-1, self.lanes.share.size)[THETA][:, None]
            return theta * P, theta * Q
        dP, dQ = stretched(last.x, last.P - last.reference_P, last.Q - last.reference_Q, nodes)
        return np.maximum(P + dP, 0.0), Q + dQ

    def finished(self) -> LaneBuildUp:
        """Return the last stage with its data."""
        last = self.last
        assert isinstance(last, LaneBuildUp)
        points = self._points(last.x, last.curves)
        sources = self._sources(last.x, points, np.zeros((WEB, 1)))
        data = stage_data(sources.nodes, sources.source, self.core_tension, sources.own)
        return replace(last, data=data, own_slope=sources.own_slope)

    def _points(self, nodes: Array, candidate: Growth) -> _Points:
        """Return the values in the cells of a stage; ``candidate`` has the functions up to it."""
        curves, surface, n = self.last.curves, float(nodes[-1]), nodes.size - 1
        x = np.concatenate([nodes[:-1], (nodes[1:] + nodes[:-1]) / 2, nodes[1:]])
        side = np.repeat([1, 1, -1], n)  # of a kink that is a node
        functions, slopes = (
            np.moveaxis(values.reshape(x.size, -1, self.lanes.share.size)[:, :WEB], 0, -1)
            for values in (candidate(x), candidate.slope(x, side))
        )
        basis = basis_slope = np.zeros(x.size)
        if surface > self.x:  # a further stage, whose values are unknown
            basis = curves.lagrange_basis(surface, x)
            basis_slope = curves.lagrange_slope(surface, x)
        r = np.exp(x)
        return _Points(
            np.ascontiguousarray(functions),
            np.ascontiguousarray(slopes),
            basis,
            basis_slope,
            self.tension.at(r),
            r * self.tension.slope(r, side),
            self.reference.growth(x),
        )

    def _solve(
        self, nodes: Array, mean_P: Array, mean_Q: Array, guess: Array
    ) -> tuple[Array, Array, Array] | None:
        """Solve a stage by Newton's method; None if that does not converge.

        Parameters
        ----------
        nodes : (n + 1,) array
            ln r in the mean roll.
        mean_P, mean_Q : (n + 1,) arrays
            Of the mean roll [Pa].
        guess : (4 + K, L) array
            Of the functions at this stage.

        Returns
        -------
        (4 + K, L) array, two (L, n + 1) arrays
            The functions, P and Q [Pa].
        """
        lanes, E_t = self.lanes, self.equations.tangential
        surface = float(nodes[-1])
        points = self._points(nodes, self.last.curves.with_stage(surface, guess.ravel()))
        P, Q = self._pressure_guess(nodes, mean_P, mean_Q)
        mean_kappa, strain = float(points.kappa[-1]), float(points.tension[-1]) / E_t
        # BDF: d rho/dx = rate + by_rho (rho - guess) at this stage
        rate, by_rho = points.slopes[RHO, :, -1], float(points.basis_slope[-1])
        thickness = 1 + lanes.excess
        # p of a layer just wound, by theta
        p = float(points.tension[-1]) * self.layers.thickness * thickness / (2 * exp(surface))
        values = guess.copy()
        values[THETA] = np.maximum(values[THETA], 0.0)
        for _ in range(MAX_ITERATIONS):
            kappa, theta = mean_kappa + values[KAPPA], values[THETA]
            sources = self._sources(nodes, points, values - guess)
            try:
                step, of_kappa, of_theta, free, softening = self._eliminate(sources, P, Q, kappa)
            except SingularStageError:
                return None
            # (1 + kappa) theta = inward theta + rest, linearised; the bound of inward only slows
            # Newton's method
            inward = np.maximum(
                1 + kappa + free - softening * theta, LEAST_SOFTENING * (1 + np.abs(kappa))
            )
            rest = (1 + kappa + free - inward) * theta  # equal for the present theta
            # F(p) = F_theta theta + F_rest, linearised
            F, F_theta = self.equations.strain(p * theta), p / self.equations.modulus(p * theta)
            F_rest = F - F_theta * theta
            mean_growth = float(lanes.share * thickness @ (1 - (1 + kappa) * theta * strain - F))
            relative = thickness / mean_growth
            c = relative * (1 - strain * rest - F_rest) - 1 - rate + by_rho * guess[RHO]
            c, mu = c / (1 + by_rho), relative * (strain * inward + F_theta) / (1 + by_rho)
            tension = self.tension_at(surface, c, mu, theta)
            if tension is None:
                return None
            dtheta = tension.wound_on - theta
            dkappa = free - softening * dtheta
            step = step + dkappa[:, None, None] * of_kappa + dtheta[:, None, None] * of_theta
            P, Q = P - step[..., 0], Q - step[..., 1]
            rho = c - mu * tension.wound_on
            drho = rho - values[RHO]
            values = np.vstack(
                [values[KAPPA] + dkappa, tension.wound_on, rho, tension.web, tension.load]
            )
            if not np.isfinite(values).all():
                return None
            largest = np.max(np.abs(P), axis=1)
            scale = np.maximum(largest, SMALLEST_PRESSURE * np.max(largest))
            changes = (
                np.abs(step[..., 0]).max(axis=1) / scale,
                dkappa / (2 + np.abs(kappa)),
                dtheta,
                drho / strain,
            )
            if np.max(np.abs(changes)) <= LAST_STEP:
                return values, P, Q
        return None

    def _eliminate(self, sources: _Sources, P: Array, Q: Array, kappa: Array) -> _Eliminated:
        """Eliminate the changes of P and Q, then that of kappa, from a Newton step.

        Parameters
        ----------
        sources : _Sources
        P, Q : (L, n + 1) arrays
            Of the lanes [Pa].
        kappa : (L,) array

        Raises
        ------
        SingularStageError
        """
        X, source, by_kappa, by_theta, own, _, p_by_theta = sources
        data = stage_data(X, source, self.core_tension, own)
        factors, E, step, layer = self.equations.linearised(data, P.ravel(), Q.ravel())
        # E_t (F(P + p) - F(p)) depends on theta by p
        of_own = 1 / E - 1 / self.equations.modulus(own.pressure[: E.size])
        of_own = self.equations.tangential * of_own.reshape(P.shape) * p_by_theta
        inner, outer = of_own[:, :-1], of_own[:, 1:]
        by_own = CellSource(inner, (inner + outer) / 2, outer)
        right = [
            source_residual(data.lengths, CellSource(*map(_joined, each)))
            for each in (by_kappa, map(np.add, by_theta, by_own))
        ]
        of_kappa, of_theta = factors.solve(np.array(right).T).T.reshape(2, *P.shape, 2)
        of_layer = layer[::2]
        kappa_by_P = self.equations.kappa_by_pressure(data, P.ravel(), of_layer, of_layer, E)
        step, layer = (part.reshape(*P.shape, 2) for part in (step, layer))
        own, of_step, of_tension = (
            (kappa_by_P.reshape(P.shape) * part[..., 0]).sum(axis=1)
            for part in (of_kappa, step, of_theta)
        )
        of_tension = of_tension - (kappa_by_P.reshape(P.shape) * p_by_theta).sum(axis=1)
        free = (layer[:, -1, 1] - kappa - of_step) / (1 + own)
        return _Eliminated(step, of_kappa, of_theta, free, of_tension / (1 + own))

    def _sources(self, nodes: Array, points: _Points, change: Array) -> _Sources:
        """Return nodes and sources of the lanes, C = -r T' - T (2 + kappa).

        Parameters
        ----------
        nodes : (n + 1,) array
            ln r in the mean roll.
        points : _Points
        change : (k, L) array, k >= 3
            Difference of the functions at the stage from their guess.

        Returns
        -------
        _Sources
        """
        n = nodes.size - 1
        change = change[:WEB, :, None]
        kappa, theta, rho = points.functions + change * points.basis
        _, theta_slope, rho_slope = points.slopes + change * points.basis_slope
        T, dT = points.tension, points.tension_slope
        stretch = 1 + rho_slope / (1 + rho)  # d ln r_j/dx
        factor = 2 + points.kappa + kappa
        T_slope = (dT * theta + T * theta_slope) / stretch
        C = -T_slope - T * theta * factor
        by_kappa = -T * theta * points.basis
        by_theta = (
            -(dT * points.basis + T * points.basis_slope) / stretch - T * points.basis * factor
        )
        shift = np.log1p(rho)
        X = nodes + np.concatenate([shift[:, :n], shift[:, -1:]], axis=1)
        source, of_kappa, of_theta = (
            CellSource(values[:, :n], values[:, n : 2 * n].copy(), values[:, 2 * n :])
            for values in (C, by_kappa, by_theta)
        )
        # The middle of a cell of the lane belongs to another layer than that of the mean roll.
        off = (shift[:, :n] + shift[:, 2 * n :]) / 2 - shift[:, n : 2 * n]
        source.middle[:] += off * (source.right - source.left) / np.diff(nodes)
        own = self._own(X, points, T * theta, T_slope)
        return _Sources(X, source, of_kappa, of_theta, *own)

    def _own(
        self, X: Array, points: _Points, T: Array, slope: Array
    ) -> tuple[OwnPressure, Array, Array]:
        """Return p of the lanes, its slope and its derivative by theta; see :class:`_Sources`.

        Parameters
        ----------
        X : (L, n + 1) array
            ln r of the nodes of each lane.
        points : _Points
        T, slope : (L, 3 n) arrays
            Wound-on stress of the lanes, and its derivative by ln r [Pa].
        """
        n = X.shape[1] - 1
        h = self.layers.thickness * (1 + self.lanes.excess)[:, None]

        def at_nodes(values: Array) -> Array:
            """Return values at the left ends of the cells and at the right end of the last one."""
            return np.concatenate([values[..., :n], values[..., -1:]], axis=-1)

        by_T = h / (2 * np.exp(X))
        p = np.maximum(at_nodes(T), 0.0) * by_T
        middle = (X[:, 1:] + X[:, :-1]) / 2
        in_cells = np.maximum(T[:, n : 2 * n], 0.0) * h / (2 * np.exp(middle))
        pressure = np.concatenate([p.ravel(), _joined(in_cells)])
        own = OwnPressure(pressure, np.asarray(self.equations.strain(pressure)))
        return own, at_nodes(slope) * by_T - p, at_nodes(points.tension * points.basis) * by_T


def _joined(values: Array) -> Array:
    """Return values in the cells of lanes, (L, n), as those of cells with gaps between lanes."""
    with_gaps = np.zeros((values.shape[0], values.shape[1] + 1))
    with_gaps[:, :-1] = values
    return with_gaps.ravel()[:-1]


def stage_data(X: Array, source: CellSource, tension: Array, own: OwnPressure) -> StageData:
    """Return the stages of all lanes, one after the other.

    Parameters
    ----------
    X : (L, n + 1) array
        ln r of the nodes of each lane.
    source : CellSource
        Of (L, n) arrays [Pa].
    tension : (L,) array
        T_c [Pa].
    own : OwnPressure
        Of the lanes, one after the other.
    """
    lanes, nodes = X.shape
    gaps = nodes * np.arange(1, lanes) - 1
    return StageData(X.ravel(), CellSource(*map(_joined, source)), tension, gaps=gaps, own=own)


def _no_stage_of_lanes(x: float) -> str:
    """Return the message for a stage of lanes, beyond ln r = x, that cannot be solved."""
    return (
        f"no stage beyond the radius {exp(x):.6g} m can be solved, though the roll of the mean web "
        "can: thickness, slack or nip load vary too much between the lanes; even the profile out, "
        "oscillate the web, or choose a crown closer to that of an even load (even_crown)"
    )
