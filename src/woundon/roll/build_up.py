r"""The build-up of a roll from the core to its surface, stage by stage.

A stage is the roll with the surface radius s, a boundary-value problem (:mod:`.equations`),

    C(r) = -r T' - T (2 + kappa(r)),       P(r; s) from C on [r_c, s],
    kappa(s) = growth of the pressure of a further layer below the surface, from P(r; s).

Kappa is a smooth function of ln s, with kinks where the tension has kinks.  It is integrated like
a differential equation by an implicit multistep method: kappa is extrapolated from the previous
stages to the next one, where pressure and kappa are computed together.  The difference from the
extrapolation controls the step size.  The cost does not depend on the number of layers.

**Layers of a finite thickness h.**  Each layer loads the roll below by T h/s at once, and in the
layer the pressure decreases from T h/s to zero.  To first order in h the pressure between the
layers is P + p, with p = T h/(2 s), the pressure of half a layer, and with P as of thin layers in a
stack that is wound under p (:class:`Layers`): F(P) is replaced by F(P + p) - F(p).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from math import exp, log

import numpy as np

from .equations import StageData, StageEquations, StageSolution, interpolate_pressure
from .growth import ORDER, Growth
from .stage_nodes import Tension, cell_source, evaluate_in_cells, kinks_of, nodes_between

__all__ = [
    "IMPLICIT_ERROR",
    "KINK_STEP",
    "SMALLEST_STEP",
    "BuildUp",
    "Layers",
    "NotWoundError",
    "no_stage_beyond",
    "step_factor",
    "stretched_guess",
    "wind",
    "wind_finite_layers",
    "wind_with_stages",
]

Array = np.ndarray

STAGE_TOLERANCE = 0.02  # error of a stage, relative to the tolerance
ONE_NEWTON_STEP = 0.04  # accepted error of kappa for which one Newton step usually suffices
WEAK_KINK = 0.05  # of the tolerance: kinks that change the source by less are ignored
STEP_STRETCH = 0.3  # a step is extended by up to this fraction to a kink, to prevent a tiny step
STRETCH_REDUCTION = 0.75  # factor for an extended step that was rejected, < 1/(1 + STEP_STRETCH)
KINK_STEP = 1e-5  # of the surface layer; a shorter step indicates an unknown kink
SMALLEST_STEP = 1e-12  # of ln r
# Error of a stage's kappa relative to its difference from the extrapolation: the error of an
# implicit step is several times smaller than that of an extrapolation
IMPLICIT_ERROR = 0.2


def wind(
    equations: StageEquations,
    tension: Tension,
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
    equations : StageEquations
        The boundary-value problem of every stage.
    tension : Tension
        Wound-on stress over the radius, and its kinks.
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
    roll = _Roll(Layers(equations, tension), core, cells, surface_layer, report)
    accepted_error = STAGE_TOLERANCE * tolerance
    first_step = 0.1 * min(surface_layer, equations.core_layer)
    # x is ln r of the surface; it equals last_kink only after a step that ended at a kink
    x, end, step, last_kink = roll.start, log(radius), first_step, -np.inf
    while x < end:
        kinks, changes = kinks_of(tension, roll.growth)
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
                raise NotWoundError(no_stage_beyond(x))
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
    equations: StageEquations,
    tension: Tension,
    reference: BuildUp,
    *,
    tolerance: float,
    cells: int,
    surface_layer: float,
    report: Callable[[float], None] | None = None,
) -> BuildUp:
    """Wind a roll with the stages of a reference build-up.

    The reference is the same roll with fewer cells, or a roll with a similar tension: differences
    between both are then free of the errors of the stages, which they share.  Other parameters as
    of :func:`wind`.
    """
    layers, all_stages = Layers(equations, tension), range(1, reference.growth.x.size)
    return _wind_selected_stages(
        layers, reference, all_stages, STAGE_TOLERANCE * tolerance, cells, surface_layer, report
    )


def wind_finite_layers(
    layers: Layers, reference: BuildUp, *, cells: int, surface_layer: float
) -> Array:
    """Return kappa with layers of finite thickness, at the stages of a build-up with thin ones.

    The difference is small and smooth.  It is computed at every second stage and at the kinks,
    usually with one Newton step, and interpolated.

    Parameters
    ----------
    layers : Layers
        Of finite thickness.
    reference : BuildUp
        The roll wound with thin layers.
    cells, surface_layer
        As of :func:`wind`.

    Returns
    -------
    (J,) array
        Kappa at the stages ``reference.growth.x``.
    """
    thin = reference.growth
    kinks = thin.kinks[thin.kinks > 0]  # without the core
    stage_numbers = np.union1d(np.arange(thin.x.size - 1, 0, -2), kinks)
    finite = _wind_selected_stages(
        layers, reference, stage_numbers, ONE_NEWTON_STEP, cells, surface_layer, None
    ).growth
    difference = Growth.of(finite.x, finite.kappa - thin(finite.x), finite.point_counts)
    return np.asarray(thin.kappa + difference(thin.x))


def _wind_selected_stages(
    layers: Layers,
    reference: BuildUp,
    stage_numbers: Iterable[int],
    accepted_error: float,
    cells: int,
    surface_layer: float,
    report: Callable[[float], None] | None,
) -> BuildUp:
    """Solve some stages of a reference build-up, with its pressures as initial guesses.

    Parameters
    ----------
    layers : Layers
    reference : BuildUp
    stage_numbers : iterable of int
        The stages, in increasing order; they include all kinks of the reference.
    accepted_error : float
        Of kappa.
    cells, surface_layer, report
        As of :func:`wind`.
    """
    roll = _Roll(layers, exp(reference.growth.x[0]), cells, surface_layer, report)
    stages, kinks = reference.stages(), reference.growth.kinks
    previous_number = 0  # stage 0 is the core, which is not in stages
    for number in stage_numbers:
        if previous_number in kinks:
            roll.growth.start_new_polynomial()
        known = stages[number - 1]
        stage, _ = roll.stage(known.x[-1], accepted_error, known)
        if stage is None:
            raise NotWoundError(no_stage_beyond(known.x[-1]))
        roll.append(stage)
        previous_number = number
    return roll.finished()


def _extrapolation_error(stage: BuildUp | None, guess: float) -> float:
    """Estimate the error of kappa at a stage, relative to kappa + 2; inf without a solution.

    ``guess`` is kappa extrapolated from the previous stages.
    """
    if stage is None:
        return np.inf
    return float(IMPLICIT_ERROR * abs(stage.growth.kappa[-1] - guess) / (2 + abs(guess)))


def step_factor(ratio: float) -> float:
    """Return the factor of the step size from tolerance/error, with a safety factor of 0.8."""
    return float(0.8 * ratio ** (1 / (ORDER + 0.5)))


@dataclass
class BuildUp:
    """A roll at one stage.

    Attributes
    ----------
    growth : Growth
        Kappa at this stage and all earlier ones.
    x : (n + 1,) array
        ln r of the nodes.
    solved : StageSolution
    previous : BuildUp, optional
        The previous stage.
    """

    growth: Growth
    x: Array
    solved: StageSolution
    previous: BuildUp | None = None

    def stages(self) -> list[BuildUp]:
        """Return all stages up to this one."""
        stage: BuildUp | None = self
        stages = []
        while stage is not None:
            stages.append(stage)
            stage = stage.previous
        return stages[::-1]


@dataclass(frozen=True)
class Layers:
    """Layers as they are wound: thin ones at zero pressure, others at half of their own pressure.

    Parameters
    ----------
    thin : StageEquations
        The equations with thin layers.
    tension : Tension
    thickness : float
        h [m]; 0 in the limit of thin layers.
    """

    thin: StageEquations
    tension: Tension
    thickness: float = 0.0

    def own_pressure(self, x: Array) -> Array:
        """Return the pressure p = T h/(2 r) under which a layer is wound at ln r [Pa]."""
        r = np.exp(x)
        return np.asarray(self.tension.at(r) * self.thickness / (2 * r))

    @property
    def equations(self) -> StageEquations:
        """The equations of the stages; not kept, because they refer to these layers."""
        if not self.thickness:
            return self.thin
        return replace(self.thin, own_pressure=self.own_pressure)


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
    last : BuildUp or None
        The previous stage.
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
        self.growth = Growth(self.start, self.equations.core)
        self.last: BuildUp | None = None

    def stage(
        self, surface: float, accepted_error: float, reference: BuildUp | None = None
    ) -> tuple[BuildUp | None, float]:
        """Return the next stage, None if it cannot be solved, and the initial guess of its kappa.

        The guess is extrapolated from the previous stages, or taken from ``reference``, another
        solution of the same stage.
        """
        nodes = nodes_between(
            self.start,
            surface,
            self.cells,
            self.surface_layer,
            *kinks_of(self.tension, self.growth),
            self.equations.core_layer,
        )
        previous = self.growth
        if reference is None:
            kappa = previous.extrapolate(surface)
            guess = stretched_guess(self.last, nodes, self.T_c)
        else:
            kappa = reference.solved.growth
            guess = interpolate_pressure(reference.x, reference.solved.P, reference.solved.Q, nodes)
        source = cell_source(self.tension, previous.with_stage(surface, kappa), nodes)
        source_by_kappa = evaluate_in_cells(
            nodes, lambda x, _: -self.tension.at(np.exp(x)) * previous.lagrange_basis(surface, x)
        )
        solved = self.equations.solve_with_growth(
            StageData(nodes, source, self.T_c), source_by_kappa, *guess, kappa, accepted_error
        )
        if solved is None:
            return None, kappa
        return BuildUp(previous.with_stage(surface, solved.growth), nodes, solved, self.last), kappa

    def append(self, stage: BuildUp) -> None:
        """Append a stage."""
        self.last, self.growth = stage, stage.growth
        if self.report is not None:
            self.report(exp(stage.x[-1]))

    def finished(self) -> BuildUp:
        """Return the last stage."""
        assert self.last is not None
        return self.last


def stretched_guess(last: BuildUp | None, nodes: Array, T_c: float) -> tuple[Array, Array]:
    """Return the initial guess of P and Q = r dP/dr at the nodes ln r, (n + 1,) each [Pa].

    It is the previous stage, stretched linearly to the new surface.  Without one, on the core, the
    pressure decreases from the surface with the slope of the wound-on stress ``T_c`` there.
    """
    if last is None:
        return T_c * (nodes[-1] - nodes), np.full_like(nodes, -T_c)
    t = (nodes - nodes[0]) / (nodes[-1] - nodes[0])
    stretched = nodes - (nodes[-1] - last.x[-1]) * t
    return interpolate_pressure(last.x, last.solved.P, last.solved.Q, stretched)


class NotWoundError(ArithmeticError):
    """A stage has no solution, or the steps became too small."""


def no_stage_beyond(x: float) -> str:
    """Return the message for a stage that cannot be solved."""
    return (
        f"no stage beyond the radius {exp(x):.6g} m can be solved: the stack at low pressure, or "
        "the core, is too soft for this tension"
    )
