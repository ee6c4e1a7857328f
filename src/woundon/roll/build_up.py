"""The build-up of a roll: from the core to its surface, stage after stage.

What a lap gets as its source depends on kappa alone (see :mod:`.equations`), a smooth function of
where the surface is, but for kinks where the tension has one.  It is found like the solution of a
differential equation by an implicit multistep method: from the stages behind, kappa is extrapolated
to the next one; there pressure and kappa are solved for together.  By how far the extrapolation was
off, the step is chosen.  The cost does not know how many laps there are.

Laps of a finite thickness h are laid one after the other: under each the roll below takes the
pressure T h/s at once, and the lap itself begins with a pressure that falls from T h/s to zero
through it.  To first order in h that is a stage, and a lap laid on it, at half of that pressure,
p = T h/(2 s), where thin laps have zero (:class:`Laps`): P(s) = p where kappa is found, E_t F(p)
less in C, and at the core (E_t/E_c + nu) p more in T_c.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from math import exp, log
from typing import Protocol

import numpy as np

from .equations import CellSource, Solved, StageEquations, pressure_between
from .growth import ORDER, Growth

__all__ = [
    "BuildUp", "Laps", "NotWoundError", "Tension", "cell_source", "in_cells", "kinks_of",
    "missed_source", "nodes_between", "wind", "wind_again", "wind_laps",
]  # fmt: skip

Array = np.ndarray

AGREED = 0.02  # of the tolerance: the last stage is solved again when the roll is finished
ROUGHLY = 1.0
WEAK = 0.05  # of the tolerance
STRETCHED = 0.3  # of a step, lest the next one be tiny
AGAIN = 0.75  # of a stretched step that was too long, below 1/(1 + STRETCHED)
# Of a stage's cells, how many more stand on either side of a kink, where it is felt so much or more
DENSE, FELT = 0.1, 0.1
UNTOLD = 1e-5  # of the layer: a step so short is a kink's
LEAST_STEP = 1e-12  # of ln r
# Of the change that a stage's kappa makes to its extrapolation, what is counted as error, for an
# implicit step errs several times less than an extrapolation
COUNTED = 0.2


class NotWoundError(ArithmeticError):
    """A stage has no solution, or the steps became too small."""


class Tension(Protocol):
    """The stress that laps are wound on with."""

    kinks: Array  # radii between core and surface at which its slope jumps [m]
    bends: Array  # by how much, r |dT'|/T

    def at(self, r: Array) -> Array:
        """T [Pa]."""
        ...

    def slope(self, r: Array, side: int | Array) -> Array:
        """dT/dr [Pa/m], at a kink that of the side behind (-1) or before (1) it."""
        ...


@dataclass
class BuildUp:
    """A roll at one stage.

    Attributes
    ----------
    growth : Growth
        Kappa at this and all earlier stages.
    x : (n + 1,) array
        ln r of the nodes.
    solved : Solved
    before : BuildUp, optional
        The stage before.
    """

    growth: Growth
    x: Array
    solved: Solved
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
    core: float, surface: float, cells: int, layer: float,
    kinks: Array | None = None, felt: Array | None = None,
) -> Array:  # fmt: skip
    """Return ln r of nodes, dense at the core and at the surface, and at kinks that are felt.

    Parameters
    ----------
    core, surface : float
        Both ends.
    cells : int
        How many, about; more where there are kinks.
    layer : float
        How deep the layer below the surface is.
    kinks, felt : (K,) arrays, optional
        ln r of what are to be nodes, and how much the source changes there, relative.
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
    own = (kinks > core + LEAST_STEP) & (kinks < surface - LEAST_STEP)
    more = [kinks[own]]
    if felt is not None:
        ends = np.concatenate([[core], kinks[own], [surface]])
        more += _beside(ends, np.round(cells * DENSE * np.minimum(1.0, felt[own] / FELT)), layer)
    return np.unique(np.concatenate([found, *more]))


def _beside(ends: Array, many: Array, layer: float) -> list[Array]:
    """Return nodes on either side of kinks, half-way to the next; ``ends`` are kinks and ends."""
    share = np.arange(1, int(many.max(initial=0)) + 1) / (many[:, None] + 1)
    inside, kinks = share < 1, ends[1:-1, None]
    nodes = []
    for side, room in ((-1, np.diff(ends)[:-1]), (1, np.diff(ends)[1:])):
        reach = room[:, None] / 2
        depth = np.minimum(layer, reach)
        nodes.append((kinks + side * depth * np.expm1(np.log1p(reach / depth) * share))[inside])
    return nodes


def kinks_of(tension: Tension, growth: Growth) -> tuple[Array, Array]:
    """Return ln r of a tension's kinks, and how much they change the source there, relative.

    Beyond the last stage as if laid there.  Kinks on either side that are nearer than what a lap
    feels of the tension, 1/(2 + kappa), make a curve: of them the less counts the nearer they are.
    """
    x = np.log(tension.kinks)
    if not x.size:
        return x, x
    reach = 2 + growth(np.minimum(x, growth.x[-1]))
    gaps = np.diff(x, prepend=-np.inf, append=np.inf)
    curved = reach * np.maximum(gaps[1:], gaps[:-1]) / 2
    return x, tension.bends / reach * np.minimum(1.0, curved)


@dataclass(frozen=True)
class Laps:
    """Laps as they are laid: thin ones without pressure, others with half of their own.

    Parameters
    ----------
    equations : StageEquations
    tension : Tension
    thickness : float
        h [m]; 0 in the limit of thin laps.
    """

    equations: StageEquations
    tension: Tension
    thickness: float = 0.0

    def pressure(self, x: Array) -> Array:
        """P at which a lap is laid at ln r [Pa]."""
        r = np.exp(x)
        return np.asarray(self.tension.at(r) * self.thickness / (2 * r))

    def source(self, growth: Growth, nodes: Array) -> CellSource:
        """C of every cell."""
        thin = cell_source(self.tension, growth, nodes)
        if not self.thickness:
            return thin
        E_t, strain = self.equations.tangential, self.equations.strain

        def laid(x: Array, side: Array) -> Array:
            # all of a lap has the tension of its inner radius
            lag = self.thickness / 2 * self.tension.slope(np.exp(x), side)
            return np.asarray(lag - E_t * strain(self.pressure(x)))

        more = in_cells(nodes, laid)
        return CellSource(*(a + b for a, b in zip(thin, more, strict=True)))

    def at_core(self, start: float) -> float:
        """T_c [Pa], the core at ln r = start."""
        x = np.array([start])
        lag = self.thickness / 2 * self.tension.slope(np.exp(x), 1)
        laid = self.tension.at(np.exp(x)) + (self.equations.core + 1) * self.pressure(x) - lag
        return float(laid[0])


class _Roll:
    """A roll that is being wound: the stages so far, and what all of them need."""

    def __init__(
        self, laps: Laps, core: float, cells: int, layer: float,
        report: Callable[[float], None] | None,
    ) -> None:  # fmt: skip
        self.laps, self.equations, self.tension = laps, laps.equations, laps.tension
        self.cells, self.layer, self.report, self.start = cells, layer, report, log(core)
        self.T_c = laps.at_core(self.start)
        self.growth = Growth(self.start, self.equations.core)
        self.last: BuildUp | None = None

    def stage(
        self, surface: float, agreed: float, known: BuildUp | None = None
    ) -> tuple[BuildUp | None, float]:
        """Return the next stage, None where that fails, and the kappa expected of it.

        Expected are what the stages behind say, or another solution of the same stage.
        """
        nodes = nodes_between(
            self.start, surface, self.cells, self.layer, *kinks_of(self.tension, self.growth)
        )
        behind = self.growth
        if known is None:
            kappa, guess = behind.extrapolated(surface), _moved(self.last, nodes, self.T_c)
        else:
            kappa = known.solved.growth
            # under half a lap the layer below a surface is much like that of half a lap more
            share = (nodes - nodes[0]) / (nodes[-1] - nodes[0])
            inner = nodes - share * self.laps.thickness / (2 * np.exp(nodes[-1]))
            guess = pressure_between(known.x, known.solved.P, known.solved.Q, inner)
        source = self.laps.source(behind.then(surface, kappa), nodes)
        top = float(self.laps.pressure(nodes[-1:])[0])
        more = in_cells(nodes, lambda x, _: -self.tension.at(np.exp(x)) * behind.share(surface, x))
        solved = self.equations.lay(nodes, source, more, self.T_c, *guess, kappa, agreed, top)
        if solved is None:
            return None, kappa
        return BuildUp(behind.then(surface, solved.growth), nodes, solved, self.last), kappa

    def keep(self, found: BuildUp) -> None:
        """Take a stage as wound."""
        self.last, self.growth = found, found.growth
        if self.report is not None:
            self.report(exp(found.x[-1]))

    def wound(self) -> BuildUp:
        """Return the last stage."""
        assert self.last is not None
        return self.last


def wind(
    equations: StageEquations, tension: Tension, core: float, radius: float, *, tolerance: float,
    cells: int, layer: float, report: Callable[[float], None] | None = None,
) -> BuildUp:  # fmt: skip
    """Wind a roll, its steps chosen on the way.

    Parameters
    ----------
    equations : StageEquations
    tension : Tension
    core, radius : float
        From where to where [m].
    tolerance : float
        Of kappa + 2, relative.
    cells : int
        Of each stage.
    layer : float
        Depth of the layer below the surface, of ln r.
    report : callable, optional
        Is called with each stage's radius [m].

    Raises
    ------
    NotWoundError
        Where a stage cannot be solved.
    """
    roll = _Roll(Laps(equations, tension), core, cells, layer, report)
    x, end, step, kink = roll.start, log(radius), 0.1 * layer, -np.inf
    while x < end:
        # a kink that changes the source by less than its tolerance is none
        kinks, felt = kinks_of(tension, roll.growth)
        stop = float(np.append(kinks[(kinks > x) & (felt > WEAK * tolerance)], end)[0])
        reach = min(step, stop - x)
        surface = stop if stop - x - reach < STRETCHED * reach else x + reach
        found, guess = roll.stage(surface, AGREED * tolerance)
        off = COUNTED * abs(found.growth.kappa[-1] - guess) / (2 + abs(guess)) if found else np.inf
        if found is None or off > tolerance:
            step = (surface - x) * (0.3 if found is None else max(0.3, _factor(tolerance / off)))
            if surface == stop:  # not stretched to there again
                step = min(step, AGAIN * (stop - x))
            if x == kink:  # felt
                roll.growth.restart()
                step, kink = min(step, layer), -np.inf
            if step < LEAST_STEP:
                raise NotWoundError(_no_stage_beyond(x))
            if found is None or step > UNTOLD * layer:
                continue
            roll.growth.restart()  # an unknown kink, or an error of the nodes
            found, _ = roll.stage(surface, AGREED * tolerance)
            if found is None:
                continue
        roll.keep(found)
        step = (surface - x) * min(3.0, _factor(tolerance / max(off, 1e-99)))
        x, kink = surface, stop
    return roll.wound()


def wind_again(
    equations: StageEquations, tension: Tension, known: BuildUp, *, tolerance: float, cells: int,
    layer: float, report: Callable[[float], None] | None = None,
) -> BuildUp:  # fmt: skip
    """Wind a roll with the stages of another build-up: parameters as of :func:`wind`."""
    laps, every = Laps(equations, tension), range(1, known.growth.x.size)
    return _with_stages(laps, known, every, AGREED * tolerance, cells, layer, report)


def wind_laps(laps: Laps, known: BuildUp, *, cells: int, layer: float) -> Array:
    """Return kappa with laps of a finite thickness, at the stages of a build-up with thin ones.

    What they change is little and smooth: every second stage will do, and kinks, and there mostly
    one step of Newton's method.
    """
    thin = known.growth
    kinks = np.flatnonzero(thin.through == 2) - 1
    kept = np.union1d(np.arange(thin.x.size - 1, 0, -2), kinks[kinks > 0])
    found = _with_stages(laps, known, kept, ROUGHLY, cells, layer, None).growth
    return np.asarray(thin.kappa + np.interp(thin.x, found.x, found.kappa - thin(found.x)))


def _with_stages(
    laps: Laps, known: BuildUp, which: Iterable[int], agreed: float, cells: int, layer: float,
    report: Callable[[float], None] | None,
) -> BuildUp:  # fmt: skip
    roll = _Roll(laps, exp(known.growth.x[0]), cells, layer, report)
    stages, last = known.stages(), 0
    for k in which:
        if (known.growth.through[last + 1 : k + 1] == 2).any():  # a kink at the last one
            roll.growth.restart()
        found, _ = roll.stage(stages[k - 1].x[-1], agreed, stages[k - 1])
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


def _moved(last: BuildUp | None, nodes: Array, T_c: float) -> tuple[Array, Array]:
    """Return a first guess: the stage before, its surface moved to the new one."""
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


def missed_source(tension: Tension, growth: Growth, nodes: Array) -> CellSource:
    """Return what the source misses in every cell, by an estimate: see :meth:`Growth.missed`."""
    return in_cells(nodes, lambda x, _: -tension.at(np.exp(x)) * growth.missed(x))


def in_cells(nodes: Array, values: Callable[[Array, Array], Array]) -> CellSource:
    """Return values(x, side) at the left end, in the middle and at the right end of every cell."""
    x = np.concatenate([nodes[:-1], (nodes[1:] + nodes[:-1]) / 2, nodes[1:]])
    n = nodes.size - 1
    C = values(x, np.repeat([1, 1, -1], n))  # side: behind or before a kink that is a node
    return CellSource(C[:n], C[n : 2 * n], C[2 * n :])
