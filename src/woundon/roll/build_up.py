"""The build-up of a roll: from the core to its surface, stage after stage.

What a lap gets as its source depends on kappa alone (see :mod:`.equations`), a smooth function of
where the surface is, but for kinks where the tension has one.  It is found like the solution of a
differential equation by an implicit multistep method: from the stages behind, kappa is extrapolated
to the next one; there pressure and kappa are solved for together.  By how far the extrapolation was
off, the step is chosen.  The cost does not know how many laps there are.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import exp, log
from typing import Protocol

import numpy as np

from .equations import CellSource, Solved, StageEquations, pressure_between

__all__ = [
    "BuildUp", "Growth", "NotWoundError", "Tension", "cell_source", "in_cells", "kinks_of",
    "missed_source", "nodes_between", "wind", "wind_again",
]  # fmt: skip

Array = np.ndarray

ORDER = 3  # of the polynomial through the last stages
AGREED = 0.02  # of the tolerance: the last stage is solved anew when the roll is finished
WEAK = 0.05  # of the tolerance
STRETCHED = 0.3  # of a step, lest the next one be tiny
AGAIN = 0.75  # of a stretched step that was too long, below 1/(1 + STRETCHED)
# Of a stage's cells, how many more stand on either side of a kink, where it is felt so much or more
DENSE, FELT = 0.1, 0.1
NOISE = 0.5  # of a step: the least distance of a stage that tells its error
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


class Growth:
    """Kappa over x = ln r: polynomials through up to four stages, none across a kink.

    Parameters
    ----------
    x, kappa : float
        Of the core, where a roll begins.

    Attributes
    ----------
    x, kappa : (J,) arrays
        The stages.
    through : (J,) int array
        How many stages the polynomial that ends at each goes through.
    """

    def __init__(self, x: float, kappa: float) -> None:
        self.x, self.kappa = np.array([x]), np.array([kappa])
        self.through = np.array([1])
        self.first = 0  # the stage behind which no polynomial reaches
        self._pieces = np.zeros((ORDER + 1, 0))

    @classmethod
    def of(cls, x: Array, kappa: Array, through: Array) -> Growth:
        """Return that of given stages; see the attributes."""
        growth = cls(float(x[0]), float(kappa[0]))
        for k in range(1, x.size):
            growth.first = k + 1 - int(through[k])
            growth = growth.then(float(x[k]), float(kappa[k]))
        return growth

    def begin_anew(self) -> None:
        """Draw no polynomial across the last stage: there the tension has a kink."""
        self.first = self.x.size - 1

    def _behind(self) -> slice:
        return slice(max(self.first, self.x.size - ORDER), None)

    def extrapolated(self, x: float) -> float:
        """Return what the polynomial through the last stages says of the next one."""
        own = self._behind()
        return _through(self.x[own] - x, self.kappa[own])[0]

    def share(self, surface: float, x: Array) -> Array:
        """Return how kappa at any x follows that of a further stage at ``surface``: 0 to 1."""
        share = np.where(x > self.x[-1], 1.0, 0.0)
        for stage in self.x[self._behind()]:
            share *= (x - stage) / (surface - stage)
        return share

    def then(self, x: float, kappa: float) -> Growth:
        """Return this with one more stage."""
        more, own = Growth.__new__(Growth), self._behind()
        more.x, more.kappa = np.append(self.x, x), np.append(self.kappa, kappa)
        more.first = self.first
        more.through = np.append(self.through, more.x.size - own.start)
        c = np.zeros((ORDER + 1, 1))
        piece = _through(more.x[own.start :] - self.x[-1], more.kappa[own.start :])
        c[: len(piece), 0] = piece
        more._pieces = np.hstack([self._pieces, c])
        return more

    def missed(self, x: Array) -> Array:
        """Return by how much kappa misses the next higher polynomials, which tells its error.

        They go through a stage that follows too, or one more behind where none does.
        """
        missed, k = np.zeros(x.size), np.searchsorted(self.x, x, side="left")
        for j in range(1, self.x.size):
            at, start = k == j, j + 1 - int(self.through[j])
            more = self._stage_after(j) or start - 1
            if more < 0 or not at.any():
                continue
            own = [*range(start, j + 1), more]
            highest = _through(self.x[own] - self.x[j], self.kappa[own])[-1]
            missed[at] = highest * np.prod(x[at, None] - self.x[own[:-1]], axis=1)
        return missed

    def _stage_after(self, j: int) -> int:
        """Return a stage before the next kink, not so near j that it tells noise; 0 if none."""
        for k in range(j + 1, self.x.size):
            if self.through[k] == 2:
                return 0
            if self.x[k] - self.x[j] > NOISE * (self.x[j] - self.x[j - 1]):
                return k
        return 0

    def __call__(self, x: Array) -> Array:
        """Return kappa at any x."""
        if not self._pieces.shape[1]:
            return np.full(np.shape(x), self.kappa[0])
        k = np.clip(np.searchsorted(self.x, x, side="left") - 1, 0, self._pieces.shape[1] - 1)
        t, c = x - self.x[k], self._pieces[:, k]
        return np.asarray(c[0] + t * (c[1] + t * (c[2] + t * c[3])))


def _through(x: Array, y: Array) -> list[float]:
    """Return the ascending coefficients of the polynomial through a few points."""
    at, divided = x.tolist(), y.tolist()
    for k in range(1, len(at)):
        for j in range(len(at) - 1, k - 1, -1):
            divided[j] = (divided[j] - divided[j - 1]) / (at[j] - at[j - k])
    c = [divided[-1]]
    for k in range(len(at) - 2, -1, -1):  # times (x - x_k), and the next difference
        times = (a - at[k] * b for a, b in zip(c, [*c[1:], 0.0], strict=True))
        c = [divided[k] - at[k] * c[0], *times]
    return c


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


class _Roll:
    """A roll that is being wound: the stages so far, and what all of them need."""

    def __init__(
        self, equations: StageEquations, tension: Tension, core: float, cells: int, layer: float,
        told: Callable[[float], None] | None,
    ) -> None:  # fmt: skip
        self.equations, self.tension, self.start = equations, tension, log(core)
        self.cells, self.layer, self.told = cells, layer, told
        self.T_c = float(tension.at(np.array([core]))[0])
        self.growth = Growth(self.start, equations.core)
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
            guess = pressure_between(known.x, known.solved.P, known.solved.Q, nodes)
        source = cell_source(self.tension, behind.then(surface, kappa), nodes)
        more = in_cells(nodes, lambda x, _: -self.tension.at(np.exp(x)) * behind.share(surface, x))
        solved = self.equations.lay(nodes, source, more, self.T_c, *guess, kappa, agreed)
        if solved is None:
            return None, kappa
        return BuildUp(behind.then(surface, solved.growth), nodes, solved, self.last), kappa

    def keep(self, found: BuildUp) -> None:
        """Take a stage as wound."""
        self.last, self.growth = found, found.growth
        if self.told is not None:
            self.told(exp(found.x[-1]))

    def wound(self) -> BuildUp:
        """Return the last stage."""
        assert self.last is not None
        return self.last


def wind(
    equations: StageEquations, tension: Tension, core: float, radius: float, *, tolerance: float,
    cells: int, layer: float, told: Callable[[float], None] | None = None,
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
    told : callable, optional
        Is called with each stage's radius [m].

    Raises
    ------
    NotWoundError
        Where a stage cannot be solved.
    """
    roll = _Roll(equations, tension, core, cells, layer, told)
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
                roll.growth.begin_anew()
                step, kink = min(step, layer), -np.inf
            if step < LEAST_STEP:
                raise NotWoundError(_no_stage_beyond(x))
            if found is None or step > UNTOLD * layer:
                continue
            roll.growth.begin_anew()  # a kink that nobody told of, or what nodes leave
            found, _ = roll.stage(surface, AGREED * tolerance)
            if found is None:
                continue
        roll.keep(found)
        step = (surface - x) * min(3.0, _factor(tolerance / max(off, 1e-99)))
        x, kink = surface, stop
    return roll.wound()


def wind_again(
    equations: StageEquations, tension: Tension, known: BuildUp, *, tolerance: float, cells: int,
    layer: float, told: Callable[[float], None] | None = None,
) -> BuildUp:  # fmt: skip
    """Wind a roll with the stages of another build-up: parameters as of :func:`wind`."""
    roll = _Roll(equations, tension, exp(known.growth.x[0]), cells, layer, told)
    for stage, through in zip(known.stages(), known.growth.through[1:], strict=True):
        if through == 2:
            roll.growth.begin_anew()
        found, _ = roll.stage(stage.x[-1], AGREED * tolerance, stage)
        if found is None:
            raise NotWoundError(_no_stage_beyond(stage.x[-1]))
        roll.keep(found)
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
