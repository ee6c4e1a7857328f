"""The build-up of a roll from the core to its surface, stage by stage.

The source of a layer depends on kappa alone (see :mod:`.equations`).  Kappa is a smooth function of
the surface radius, except for kinks where the tension has one.  It is integrated like a
differential equation by an implicit multistep method: kappa is extrapolated from the previous
stages to the next one, and there pressure and kappa are solved for together.  The difference from
the extrapolation controls the step size.  The cost does not depend on the number of layers.

Layers of a finite thickness h are laid one after the other: the roll below each one takes the
pressure T h/s at once, and in the layer itself the pressure falls from T h/s to zero.  To first
order in h that is a stage, and a layer laid on it, at half of that pressure, p = T h/(2 s), where
thin layers have zero (:class:`Layers`): P(s) = p where kappa is found, C is smaller by E_t F(p),
and T_c at the core is larger by (E_t/E_c + nu) p.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from math import exp, log
from typing import Protocol

import numpy as np

from .equations import CellSource, StageEquations, StageSolution, pressure_between
from .growth import ORDER, Growth

__all__ = [
    "BuildUp",
    "Layers",
    "NotWoundError",
    "Tension",
    "cell_source",
    "in_cells",
    "kinks_of",
    "nodes_between",
    "source_error",
    "wind",
    "wind_finite_layers",
    "wind_with_stages",
]

Array = np.ndarray

STAGE_TOLERANCE = 0.02  # of the tolerance; the last stage is solved again with the finished roll
ONE_NEWTON_STEP = 1.0  # accepted error of kappa that one Newton step mostly reaches
WEAK_KINK = 0.05  # of the tolerance: kinks that change the source by less are ignored
STEP_STRETCH = 0.3  # of a step, so that the next one is not tiny
STRETCH_REDUCTION = 0.75  # of a stretched step that was too long, below 1/(1 + STEP_STRETCH)
# Additional cells on either side of a kink that changes the source by STRONG_KINK or more, relative
# to the number of cells of a stage
KINK_CELLS, STRONG_KINK = 0.1, 0.1
KINK_STEP = 1e-5  # of the layer; a shorter step indicates an unknown kink
SMALLEST_STEP = 1e-12  # of ln r
# Error of a stage's kappa relative to its difference from the extrapolation: the error of an
# implicit step is several times smaller than that of an extrapolation
IMPLICIT_ERROR = 0.2


class NotWoundError(ArithmeticError):
    """A stage has no solution, or the steps became too small."""


class Tension(Protocol):
    """The wound-on stress of the layers over the radius."""

    kinks: Array  # radii between core and surface at which its slope jumps [m]
    bends: Array  # jumps of the slope there, r |dT'|/T [1]

    def at(self, r: Array) -> Array:
        """Return T [Pa]."""
        ...

    def slope(self, r: Array, side: int | Array) -> Array:
        """Return dT/dr [Pa/m]; at a kink, that of its inner (-1) or outer (1) side."""
        ...


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
    before : BuildUp, optional
        The previous stage.
    """

    growth: Growth
    x: Array
    solved: StageSolution
    before: BuildUp | None = None

    def stages(self) -> list[BuildUp]:
        """Return all stages up to this one."""
        stage: BuildUp | None = self
        found = []
        while stage is not None:
            found.append(stage)
            stage = stage.before
        return found[::-1]


def nodes_between(
    core: float,
    surface: float,
    cells: int,
    layer: float,
    kinks: Array | None = None,
    changes: Array | None = None,
) -> Array:
    """Return ln r of nodes, dense at the core, at the surface and at kinks.

    Parameters
    ----------
    core, surface : float
        ln r of both ends.
    cells : int
        Approximate number of cells without kinks.
    layer : float
        Depth of the layer below the surface, in ln r.
    kinks, changes : (K,) arrays, optional
        ln r of kinks, which become nodes, and the relative changes of the source there.
    """
    length = surface - core
    layer = min(layer, length)
    even = np.linspace(0, length, 2 * cells)
    steps = layer * np.expm1(np.log1p(length / layer) / length * even)
    y = np.sort(np.concatenate([steps, length - steps, even]))
    # density 1/(distance + layer) at both ends, and an even part as large as theirs
    unit = np.log1p(length / layer)
    total = unit * y / length + np.log1p(y / layer) - np.log1p((length - y) / layer)
    found = core + np.interp(np.linspace(-unit, 2 * unit, cells + 1), total, y)
    found[0], found[-1] = core, surface
    if kinks is None:
        return found
    own = (kinks > core + SMALLEST_STEP) & (kinks < surface - SMALLEST_STEP)
    more = [kinks[own]]
    if changes is not None:
        ends = np.concatenate([[core], kinks[own], [surface]])
        more += _kink_nodes(
            ends, np.round(cells * KINK_CELLS * np.minimum(1.0, changes[own] / STRONG_KINK)), layer
        )
    return np.unique(np.concatenate([found, *more]))


def _kink_nodes(ends: Array, many: Array, layer: float) -> list[Array]:
    """Return nodes on either side of kinks, half-way to the next; ``ends``: kinks and both ends."""
    share = np.arange(1, int(many.max(initial=0)) + 1) / (many[:, None] + 1)
    inside, kinks = share < 1, ends[1:-1, None]
    nodes = []
    for side, room in ((-1, np.diff(ends)[:-1]), (1, np.diff(ends)[1:])):
        reach = room[:, None] / 2
        depth = np.minimum(layer, reach)
        nodes.append((kinks + side * depth * np.expm1(np.log1p(reach / depth) * share))[inside])
    return nodes


def kinks_of(tension: Tension, growth: Growth) -> tuple[Array, Array]:
    """Return ln r of a tension's kinks, and the relative changes of the source there.

    Beyond the last stage, kappa of the last stage is used.  Kinks that are closer together than
    1/(2 + kappa) approximate a curve: they are weighted by their distance.
    """
    x = np.log(tension.kinks)
    if not x.size:
        return x, x
    reach = 2 + growth(np.minimum(x, growth.x[-1]))
    gaps = np.diff(x, prepend=-np.inf, append=np.inf)
    curved = reach * np.maximum(gaps[1:], gaps[:-1]) / 2
    return x, tension.bends / reach * np.minimum(1.0, curved)


@dataclass(frozen=True)
class Layers:
    """Layers as they are laid: thin ones at zero pressure, others at half of their own pressure.

    Parameters
    ----------
    equations : StageEquations
    tension : Tension
    thickness : float
        h [m]; 0 in the limit of thin layers.
    """

    equations: StageEquations
    tension: Tension
    thickness: float = 0.0

    def pressure(self, x: Array) -> Array:
        """Return P at which a layer is laid at ln r [Pa]."""
        r = np.exp(x)
        return np.asarray(self.tension.at(r) * self.thickness / (2 * r))

    def source(self, growth: Growth, nodes: Array) -> CellSource:
        """Return C of every cell."""
        thin = cell_source(self.tension, growth, nodes)
        if not self.thickness:
            return thin
        E_t, strain = self.equations.tangential, self.equations.strain

        def finite_part(x: Array, side: Array) -> Array:
            # a layer has the tension of its inner radius over its full thickness
            lag = self.thickness / 2 * self.tension.slope(np.exp(x), side)
            return np.asarray(lag - E_t * strain(self.pressure(x)))

        more = in_cells(nodes, finite_part)
        return CellSource(*(a + b for a, b in zip(thin, more, strict=True)))

    def at_core(self, start: float) -> float:
        """Return T_c [Pa], with the core at ln r = start."""
        x = np.array([start])
        lag = self.thickness / 2 * self.tension.slope(np.exp(x), 1)
        laid = self.tension.at(np.exp(x)) + (self.equations.core + 1) * self.pressure(x) - lag
        return float(laid[0])


class _Roll:
    """A roll during winding: the previous stages, and the data common to all stages."""

    def __init__(
        self,
        layers: Layers,
        core: float,
        cells: int,
        layer: float,
        report: Callable[[float], None] | None,
    ) -> None:
        self.layers, self.equations, self.tension = layers, layers.equations, layers.tension
        self.cells, self.layer, self.report, self.start = cells, layer, report, log(core)
        self.T_c = layers.at_core(self.start)
        self.growth = Growth(self.start, self.equations.core)
        self.last: BuildUp | None = None

    def stage(
        self, surface: float, accepted_error: float, known: BuildUp | None = None
    ) -> tuple[BuildUp | None, float]:
        """Return the next stage, None if it cannot be solved, and the initial guess of its kappa.

        The guess is extrapolated from the previous stages, or taken from ``known``, another
        solution of the same stage.
        """
        nodes = nodes_between(
            self.start, surface, self.cells, self.layer, *kinks_of(self.tension, self.growth)
        )
        previous = self.growth
        if known is None:
            kappa, guess = previous.extrapolate(surface), _initial_guess(self.last, nodes, self.T_c)
        else:
            kappa = known.solved.growth
            # P below half a layer resembles that of a surface half a layer farther out
            share = (nodes - nodes[0]) / (nodes[-1] - nodes[0])
            inner = nodes - share * self.layers.thickness / (2 * np.exp(nodes[-1]))
            guess = pressure_between(known.x, known.solved.P, known.solved.Q, inner)
        source = self.layers.source(previous.with_stage(surface, kappa), nodes)
        top = float(self.layers.pressure(nodes[-1:])[0])
        more = in_cells(
            nodes, lambda x, _: -self.tension.at(np.exp(x)) * previous.lagrange_basis(surface, x)
        )
        solved = self.equations.solve_with_growth(
            nodes, source, more, self.T_c, *guess, kappa, accepted_error, top
        )
        if solved is None:
            return None, kappa
        return BuildUp(previous.with_stage(surface, solved.growth), nodes, solved, self.last), kappa

    def keep(self, found: BuildUp) -> None:
        """Append a stage."""
        self.last, self.growth = found, found.growth
        if self.report is not None:
            self.report(exp(found.x[-1]))

    def wound(self) -> BuildUp:
        """Return the last stage."""
        assert self.last is not None
        return self.last


def wind(
    equations: StageEquations,
    tension: Tension,
    core: float,
    radius: float,
    *,
    tolerance: float,
    cells: int,
    layer: float,
    report: Callable[[float], None] | None = None,
) -> BuildUp:
    """Wind a roll with adaptive steps.

    Parameters
    ----------
    equations : StageEquations
    tension : Tension
    core, radius : float
        Both radii [m].
    tolerance : float
        Tolerance of kappa, relative to kappa + 2.
    cells : int
        Cells of each stage.
    layer : float
        Depth of the layer below the surface, in ln r.
    report : callable, optional
        Is called with each stage's radius [m].

    Raises
    ------
    NotWoundError
        If a stage cannot be solved.
    """
    roll = _Roll(Layers(equations, tension), core, cells, layer, report)
    x, end, step, kink = roll.start, log(radius), 0.1 * layer, -np.inf
    while x < end:
        # kinks that change the source by less than its tolerance are ignored
        kinks, changes = kinks_of(tension, roll.growth)
        stop = float(np.append(kinks[(kinks > x) & (changes > WEAK_KINK * tolerance)], end)[0])
        reach = min(step, stop - x)
        surface = stop if stop - x - reach < STEP_STRETCH * reach else x + reach
        found, guess = roll.stage(surface, STAGE_TOLERANCE * tolerance)
        off = (
            IMPLICIT_ERROR * abs(found.growth.kappa[-1] - guess) / (2 + abs(guess))
            if found
            else np.inf
        )
        if found is None or off > tolerance:
            step = (surface - x) * (0.3 if found is None else max(0.3, _factor(tolerance / off)))
            if surface == stop:  # prevents the same stretched step
                step = min(step, STRETCH_REDUCTION * (stop - x))
            if x == kink:  # the kink matters: start the polynomials there
                roll.growth.restart()
                step, kink = min(step, layer), -np.inf
            if step < SMALLEST_STEP:
                raise NotWoundError(_no_stage_beyond(x))
            if found is None or step > KINK_STEP * layer:
                continue
            roll.growth.restart()  # an unknown kink, or the discretisation error
            found, _ = roll.stage(surface, STAGE_TOLERANCE * tolerance)
            if found is None:
                continue
        roll.keep(found)
        step = (surface - x) * min(3.0, _factor(tolerance / max(off, 1e-99)))
        x, kink = surface, stop
    return roll.wound()


def wind_with_stages(
    equations: StageEquations,
    tension: Tension,
    known: BuildUp,
    *,
    tolerance: float,
    cells: int,
    layer: float,
    report: Callable[[float], None] | None = None,
) -> BuildUp:
    """Wind a roll with the stages of another build-up: parameters as in :func:`wind`."""
    layers, every = Layers(equations, tension), range(1, known.growth.x.size)
    return _wind_selected_stages(
        layers, known, every, STAGE_TOLERANCE * tolerance, cells, layer, report
    )


def wind_finite_layers(layers: Layers, known: BuildUp, *, cells: int, layer: float) -> Array:
    """Return kappa with layers of finite thickness, at the stages of a build-up with thin ones.

    The difference is small and smooth: every second stage and the kinks suffice, mostly with one
    step of Newton's method.
    """
    thin = known.growth
    kinks = np.flatnonzero(thin.through == 2) - 1
    kept = np.union1d(np.arange(thin.x.size - 1, 0, -2), kinks[kinks > 0])
    found = _wind_selected_stages(layers, known, kept, ONE_NEWTON_STEP, cells, layer, None).growth
    return np.asarray(thin.kappa + np.interp(thin.x, found.x, found.kappa - thin(found.x)))


def _wind_selected_stages(
    layers: Layers,
    known: BuildUp,
    which: Iterable[int],
    accepted_error: float,
    cells: int,
    layer: float,
    report: Callable[[float], None] | None,
) -> BuildUp:
    roll = _Roll(layers, exp(known.growth.x[0]), cells, layer, report)
    stages, last = known.stages(), 0
    for k in which:
        if (known.growth.through[last + 1 : k + 1] == 2).any():  # a kink at the last one
            roll.growth.restart()
        found, _ = roll.stage(stages[k - 1].x[-1], accepted_error, stages[k - 1])
        if found is None:
            raise NotWoundError(_no_stage_beyond(stages[k - 1].x[-1]))
        roll.keep(found)
        last = k
    return roll.wound()


def _no_stage_beyond(x: float) -> str:
    return (
        f"no stage beyond the radius {exp(x):.6g} m can be solved: the stack without pressure, or "
        "the core, is too soft for this tension"
    )


def _factor(slack: float) -> float:
    return float(0.8 * slack ** (1 / (ORDER + 0.5)))


def _initial_guess(last: BuildUp | None, nodes: Array, T_c: float) -> tuple[Array, Array]:
    """Return the initial guess: the previous stage, its surface moved to the new one."""
    if last is None:
        return T_c * (nodes[-1] - nodes), np.full_like(nodes, -T_c)
    share = (nodes - nodes[0]) / (nodes[-1] - nodes[0])
    moved = nodes - (nodes[-1] - last.x[-1]) * share
    return pressure_between(last.x, last.solved.P, last.solved.Q, moved)


def cell_source(tension: Tension, growth: Growth, nodes: Array) -> CellSource:
    """Return C = -r T' - T (2 + kappa) in every cell."""

    def source(x: Array, side: Array) -> Array:
        r = np.exp(x)
        return -r * tension.slope(r, side) - tension.at(r) * (2 + growth(x))

    return in_cells(nodes, source)


def source_error(tension: Tension, growth: Growth, nodes: Array) -> CellSource:
    """Return the estimated error of the source in every cell by the interpolation of kappa."""
    return in_cells(nodes, lambda x, _: -tension.at(np.exp(x)) * growth.interpolation_error(x))


def in_cells(nodes: Array, values: Callable[[Array, Array], Array]) -> CellSource:
    """Return values(x, side) at the left end, in the middle and at the right end of every cell."""
    x = np.concatenate([nodes[:-1], (nodes[1:] + nodes[:-1]) / 2, nodes[1:]])
    n = nodes.size - 1
    C = values(x, np.repeat([1, 1, -1], n))  # side: inner or outer side of a kink that is a node
    return CellSource(C[:n], C[n : 2 * n], C[2 * n :])
