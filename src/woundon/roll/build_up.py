r"""The build-up of a roll from the core to its surface, stage by stage.

A stage is the roll with the surface radius s, a boundary-value problem (:mod:`.equations`),

    C(r) = -r T' - T (2 + kappa(r)),       P(r; s) from C on [r_c, s],
    kappa(s) = growth of the pressure of a further layer below the surface, from P(r; s).

Kappa is a smooth function of ln s, with kinks where the tension has kinks.  It is integrated like
a differential equation by an implicit multistep method: kappa is extrapolated from the previous
stages to the next one, where pressure and kappa are computed together.  The difference from the
extrapolation controls the step size.  The cost does not depend on the number of layers.

**Layers of the thickness h.**  Each layer loads the roll below by T h/s at once, and in the layer
the pressure decreases from T h/s to zero.  To first order in h the pressure between the layers is
P + p, with p = T h/(2 s), the pressure of half a layer, and with P as of thin layers in a stack
that is wound under p (:class:`Layers`): F(P) is replaced by F(P + p) - F(p).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import exp, log
from typing import NamedTuple

import numpy as np

from .equations import (
    GrowthEffect,
    OwnPressure,
    StageData,
    StageEquations,
    StageSolution,
    initial_guess,
    interpolate_stages,
    joined,
)
from .growth import ORDER, Growth, point_counts_of
from .stage_nodes import Tension, cell_source, kinks_of, nodes_between, points_of_cells

__all__ = [
    "IMPLICIT_ERROR",
    "KINK_STEP",
    "SMALLEST_STEP",
    "BuildUp",
    "Layers",
    "NotWoundError",
    "no_stage_of_roll",
    "step_factor",
    "wind",
    "wind_thin_layers",
    "wind_with_stages",
]

Array = np.ndarray

STAGE_TOLERANCE = 0.02  # error of a stage, relative to the tolerance
ONE_NEWTON_STEP = 0.04  # accepted error of kappa for which one Newton step usually suffices
# Accepted error of kappa at known stages: the last Newton step is at most 5e-8, and the error is
# about its square.
SAME_STAGES = 1e-14
WEAK_KINK = 0.05  # of the tolerance: kinks that change the source by less are ignored
STEP_STRETCH = 0.3  # a step is extended by up to this fraction to a kink, to prevent a tiny step
STRETCH_REDUCTION = 0.75  # factor for an extended step that was rejected, < 1/(1 + STEP_STRETCH)
KINK_STEP = 1e-5  # of the surface layer; a shorter step indicates an unknown kink
SMALLEST_STEP = 1e-12  # of ln r
# Error of a stage's kappa relative to its difference from the extrapolation: the error of an
# implicit step is several times smaller than that of an extrapolation
IMPLICIT_ERROR = 0.2


def wind(
    layers: Layers,
    core: float,
    radius: float,
    *,
    tolerance: float,
    cells: int,
    surface_layer: float,
    report: Callable[[float], None] | None = None,
) -> BuildUp:
    """Wind a roll with adaptive steps in ln r of its surface.

    Kappa is the relative change with ln r, at the surface, of the pressure that a further layer
    adds.  It is extrapolated from the previous stages to the next one, where it is computed
    together with the pressure; the difference from the extrapolation controls the step size.

    Parameters
    ----------
    layers : Layers
    core, radius : float
        Both radii [m].
    tolerance : float
        Tolerance of kappa, relative to kappa + 2.
    cells : int
        Cells of each stage.
    surface_layer : float
        Depth of the layer below the surface, in ln r.
    report : callable, optional
        Is called with each stage's radius [m].

    Raises
    ------
    NotWoundError
        If a stage cannot be solved.
    """
    roll = _Roll(layers, core, cells, surface_layer, report)
    accepted_error = STAGE_TOLERANCE * tolerance
    first_step = 0.1 * min(surface_layer, layers.equations.core_layer)
    # x is ln r of the surface; it equals last_kink only after a step that ended at a kink
    x, end, step, last_kink = roll.start, log(radius), first_step, -np.inf
    while x < end:
        kinks, changes = roll.kinks
        # the next kink that counts, or the end
        kink = float(np.append(kinks[(kinks > x) & (changes > WEAK_KINK * tolerance)], end)[0])
        length = min(step, kink - x)
        surface = kink if kink - x - length < STEP_STRETCH * length else x + length
        stage, guess = roll.stage(surface, accepted_error)
        error = _extrapolation_error(stage, guess)
        if stage is None or error > tolerance:
            step = (surface - x) * max(0.3, step_factor(tolerance / error))
            if surface == kink:  # prevents a repetition of the same extended step
                step = min(step, STRETCH_REDUCTION * (kink - x))
            if x == last_kink:  # start the polynomials of kappa at this kink
                roll.growth.start_new_polynomial()
                step, last_kink = min(step, surface_layer), -np.inf
            if step < SMALLEST_STEP:
                raise NotWoundError(no_stage_of_roll(x))
            if stage is None or step > KINK_STEP * surface_layer:
                continue
            roll.growth.start_new_polynomial()  # an unknown kink, or the discretisation error
            stage, _ = roll.stage(surface, accepted_error)
            if stage is None:
                continue
        roll.append(stage)
        step = (surface - x) * min(3.0, step_factor(tolerance / max(error, 1e-99)))
        x, last_kink = surface, kink
    return roll.finished()


def wind_with_stages(
    layers: Layers,
    reference: BuildUp,
    *,
    cells: int,
    surface_layer: float,
    report: Callable[[float], None] | None = None,
) -> BuildUp:
    """Wind a roll with the stages of a reference build-up.

    The reference is the same roll with fewer cells, or a roll with a similar tension: differences
    between both are then free of the errors of the stages, which they share, and of Newton's
    method.  Other parameters as of :func:`wind`.
    """
    all_stages = range(1, reference.growth.x.size)
    return _wind_selected_stages(
        layers, reference, all_stages, SAME_STAGES, cells, surface_layer, report
    )


def wind_thin_layers(
    layers: Layers, reference: BuildUp, *, cells: int, surface_layer: float
) -> Array:
    """Return kappa in the limit of thin layers, at the stages of the roll.

    The difference is small and smooth.  It is computed at every second stage and at the kinks,
    usually with one Newton step, and interpolated.

    Parameters
    ----------
    layers : Layers
        Of the roll.
    reference : BuildUp
        The roll.
    cells, surface_layer
        As of :func:`wind`.

    Returns
    -------
    (J,) array
        Kappa at the stages ``reference.growth.x``.
    """
    known = reference.growth
    kinks = known.kinks[known.kinks > 0]  # without the core
    stage_numbers = np.union1d(np.arange(known.x.size - 1, 0, -2), kinks).tolist()
    thin = _wind_selected_stages(
        layers.thin, reference, stage_numbers, ONE_NEWTON_STEP, cells, surface_layer, None
    ).growth
    difference = Growth.of(thin.x, thin.kappa - known(thin.x), thin.point_counts)
    return np.asarray(known.kappa + difference(known.x))


def _wind_selected_stages(
    layers: Layers,
    reference: BuildUp,
    stage_numbers: Sequence[int],
    accepted_error: float,
    cells: int,
    surface_layer: float,
    report: Callable[[float], None] | None,
) -> BuildUp:
    """Solve some stages of a reference build-up together, from its solution as initial guess.

    Parameters
    ----------
    layers : Layers
    reference : BuildUp
    stage_numbers : sequence of int
        The stages, in increasing order; they include all kinks of the reference.
    accepted_error : float
        Of kappa.
    cells, surface_layer, report
        As of :func:`wind`.
    """
    equations, tension, known = layers.equations, layers.tension, reference.growth
    numbers, core = [0, *stage_numbers], float(known.x[0])
    growth = Growth.of(
        known.x[numbers], known.kappa[numbers], point_counts_of(stage_numbers, known.kinks)
    )
    kinks = kinks_of(tension, growth)
    nodes = [
        nodes_between(core, surface, cells, surface_layer, *kinks, equations.core_layer)
        for surface in growth.x[1:].tolist()
    ]
    x, gaps = joined(nodes)
    stage = StageData(
        x,
        cell_source(tension, growth, x),
        float(tension.at(np.array([exp(core)]))[0]),
        laid_tension=tension.at(np.exp(growth.x[1:])),
        own=layers.own(x),
        gaps=gaps,
    )
    solved = equations.solve_with_growth(
        stage,
        _effect_of(growth, tension, x),
        *interpolate_stages(
            [(reference.nodes[k - 1], reference.solutions[k - 1]) for k in stage_numbers], nodes
        ),
        growth.kappa[1:],
        accepted_error,
    )
    if solved is None:
        raise NotWoundError(
            "the stages of the roll, known from a similar one, do not converge with its tension"
        )
    if report is not None:
        for surface in growth.x[1:].tolist():
            report(exp(surface))
    return BuildUp(
        Growth.of(growth.x, np.append(growth.kappa[0], solved.growth), growth.point_counts),
        nodes,
        solved.parts(gaps),
    )


def _effect_of(growth: Growth, tension: Tension, x: Array) -> GrowthEffect:
    """Return the effect of the kappa of all stages on the source in cells, with nodes x = ln r.

    The source C = -r T' - T (2 + kappa) depends on kappa by -T.  That of the core is known.
    """
    points = points_of_cells(x)
    numbers, derivatives = growth.basis(points)
    factors = -tension.at(np.exp(points))[:, None] * derivatives
    return GrowthEffect(np.maximum(numbers - 1, 0), np.where(numbers > 0, factors, 0.0))


def _extrapolation_error(stage: WoundStage | None, guess: float) -> float:
    """Estimate the error of kappa at a stage, relative to kappa + 2; inf without a solution.

    ``guess`` is kappa extrapolated from the previous stages.
    """
    if stage is None:
        return np.inf
    return float(IMPLICIT_ERROR * abs(stage.kappa - guess) / (2 + abs(guess)))


def step_factor(ratio: float) -> float:
    """Return the factor of the step size from tolerance/error, with a safety factor of 0.8."""
    return float(0.8 * ratio ** (1 / (ORDER + 0.5)))


class WoundStage(NamedTuple):
    """A solved stage: ln r of its nodes, (n + 1,), and its pressure."""

    x: Array
    solved: StageSolution

    @property
    def kappa(self) -> float:
        """Growth of the pressure of a further layer below the surface."""
        return float(self.solved.growth[0])


@dataclass
class BuildUp:
    """A roll at one stage, and the stages before.

    Attributes
    ----------
    growth : Growth
        Kappa at the stages and at the core.
    nodes : list of (n + 1,) arrays
        ln r of the nodes of each stage.
    solutions : list of StageSolution
        Pressure of each stage.
    """

    growth: Growth
    nodes: list[Array]
    solutions: list[StageSolution]

    @property
    def x(self) -> Array:
        """The nodes ln r of the last stage, (n + 1,)."""
        return self.nodes[-1]

    @property
    def solved(self) -> StageSolution:
        """The pressure of the last stage."""
        return self.solutions[-1]


@dataclass(frozen=True)
class Layers:
    """Layers as they are wound: under half of their own pressure.

    Parameters
    ----------
    equations : StageEquations
        The boundary-value problem of every stage.
    tension : Tension
        Wound-on stress over the radius, and its kinks.
    thickness : float
        h [m]; 0 in the limit of thin layers.
    centrifugal : float
        c = rho V^2 while they are wound [Pa].
    """

    equations: StageEquations
    tension: Tension
    thickness: float
    centrifugal: float = 0.0

    @property
    def thin(self) -> Layers:
        """The layers in the limit of thin ones under the same stress."""
        return replace(self, thickness=0.0)

    @property
    def at_rest(self) -> Layers:
        """The same layers, wound under the same pressure, after the roll has stopped."""
        return replace(self, equations=self.equations.at_rest)

    def own_pressure(self, x: Array) -> Array:
        """Return the pressure p = (T - c) h/(2 r) under which a layer is wound at ln r [Pa]."""
        r = np.exp(x)
        return np.asarray((self.tension.at(r) - self.centrifugal) * self.thickness / (2 * r))

    def own_slope(self, x: Array, side: int | Array) -> Array:
        """Return dp/d ln r [Pa]; at a kink of T, that of its inner (-1) or outer (1) side."""
        return self.tension.slope(np.exp(x), side) * self.thickness / 2 - self.own_pressure(x)

    def total(self, x: Array, P: Array, Q: Array) -> tuple[Array, Array]:
        """Return the total pressure P + p at nodes ln r and r times its gradient, (n + 1,) [Pa].

        At a kink the gradient is that of its outer side.
        """
        side = np.append(np.ones(x.size - 1), -1)
        return P + self.own_pressure(x), Q + self.own_slope(x, side)

    def additional(self, x: Array, total: Array, gradient: Array) -> tuple[Array, Array]:
        """Return P and Q from the total pressure and its gradient, as of :meth:`total` [Pa]."""
        p, slope = self.total(x, np.zeros(x.size), np.zeros(x.size))
        return total - p, gradient - slope

    def own(self, nodes: Array) -> OwnPressure | None:
        """Return p and F(p) at nodes ln r (n + 1,) and in mid-cell; None for thin layers."""
        if not self.thickness:
            return None
        p = self.own_pressure(np.concatenate([nodes, (nodes[1:] + nodes[:-1]) / 2]))
        return OwnPressure(p, np.asarray(self.equations.strain(p)))


class _Roll:
    """A roll during winding: the previous stages, and the data common to all stages.

    Parameters
    ----------
    layers : Layers
    core : float
        Core radius [m].
    cells : int
        Cells of each stage.
    surface_layer : float
        Depth of the layer below the surface, in ln r.
    report : callable, optional
        Is called with each stage's radius [m].

    Attributes
    ----------
    start, T_c : float
        ln of the core radius, and the wound-on stress there [Pa].
    growth : Growth
        Kappa at the previous stages.
    kinks : pair of arrays
        Kinks of the tension, and the changes of the source there, as of :func:`.kinks_of`.
    nodes, solutions : list
        Of the previous stages, as of :class:`BuildUp`.
    """

    def __init__(
        self,
        layers: Layers,
        core: float,
        cells: int,
        surface_layer: float,
        report: Callable[[float], None] | None,
    ) -> None:
        self.layers, self.equations, self.tension = layers, layers.equations, layers.tension
        self.cells, self.surface_layer, self.report, self.start = (
            cells,
            surface_layer,
            report,
            log(core),
        )
        self.T_c = float(self.tension.at(np.array([core]))[0])
        self.growth = Growth(self.start, self.equations.growth_on_core(self.T_c))
        self.kinks = kinks_of(self.tension, self.growth)
        self.nodes: list[Array] = []
        self.solutions: list[StageSolution] = []

    def stage(self, surface: float, accepted_error: float) -> tuple[WoundStage | None, float]:
        """Return the next stage, None if it cannot be solved, and the initial guess of its kappa.

        The guess is extrapolated from the previous stages.
        """
        previous, kappa = self.growth, self.growth.extrapolate(surface)
        nodes = nodes_between(
            self.start,
            surface,
            self.cells,
            self.surface_layer,
            *self.kinks,
            self.equations.core_layer,
        )
        source = cell_source(self.tension, previous.with_stage(surface, kappa), nodes)
        points = points_of_cells(nodes)
        last = None
        if self.nodes:
            last = self.nodes[-1], self.solutions[-1].P, self.solutions[-1].Q
        by_kappa = -self.tension.at(np.exp(points)) * previous.lagrange_basis(surface, points)
        solved = self.equations.solve_with_growth(
            StageData(
                nodes,
                source,
                self.T_c,
                laid_tension=self.tension.at(np.exp(nodes[-1:])),
                own=self.layers.own(nodes),
            ),
            GrowthEffect(np.zeros((points.size, 1), dtype=int), by_kappa[:, None]),
            *initial_guess(nodes, self.T_c, last),
            np.array([kappa]),
            accepted_error,
        )
        return (solved and WoundStage(nodes, solved)), kappa

    def append(self, stage: WoundStage) -> None:
        """Append a stage."""
        self.nodes.append(stage.x)
        self.solutions.append(stage.solved)
        self.growth = self.growth.with_stage(float(stage.x[-1]), stage.kappa)
        self.kinks = kinks_of(self.tension, self.growth)
        if self.report is not None:
            self.report(exp(stage.x[-1]))

    def finished(self) -> BuildUp:
        """Return all stages."""
        return BuildUp(self.growth, self.nodes, self.solutions)


class NotWoundError(ArithmeticError):
    """A stage has no solution, or the steps became too small."""


def no_stage_of_roll(x: float) -> str:
    """Return the message for a stage that cannot be solved."""
    return (
        f"no stage beyond the radius {exp(x):.6g} m can be solved: the stack at low pressure, or "
        "the core, is too soft for this tension"
    )
