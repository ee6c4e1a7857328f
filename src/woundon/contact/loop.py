r"""The one loop of every contact here: coarse grids to fine ones, on each the width for the load.

    Contact --> on each mesh of a ladder:
                  equations for a half width a, linear about what is known     Contact.equations
                  stick and slip                                               stick_slip
              --> secant on a until the pressure carries the load              width
              --> again about what was found, until nothing moves (where something was linearised)
              --> zones, width and what is known carried to the next mesh
            --> scalars of every mesh, whose changes tell the discretisation error

What is nip, wrap or rollers hides behind :class:`Contact`; what is half-plane, cylinder or a body
that is not linear, behind the equations.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from math import exp, isnan, log, nan
from typing import Any, NamedTuple, Protocol

import numpy as np

from ..errors import NotConverged
from .grid import nearest_nodes, zone_borders
from .panagiotopoulos import panagiotopoulos
from .schemes import Graded, Mesh, Scheme
from .stick_slip import Ending, StickSlip, StickSlipSolution, solve_stick_slip
from .width import WidthNotFound, width_for_load

__all__ = [
    "ALGORITHMS", "COARSE", "FINE", "Contact", "Equations", "Known", "Ladder", "Level", "Start",
    "State", "Tolerance", "Widths", "halved",
]  # fmt: skip

Array = np.ndarray
Scalars = Mapping[str, float]
FindZones = Callable[[StickSlip, Array | None], StickSlipSolution]

ALGORITHMS: dict[str, FindZones] = {
    "pivoting": solve_stick_slip,
    "panagiotopoulos": panagiotopoulos,
}

# The C library returns freed memory to the system, a page fault for every 4 kB of the next matrix,
# unless a block as large as this was freed before (glibc's dynamic thresholds): a tenth of the time
# of a small contact.
np.empty(1 << 20)


class Tolerance(NamedTuple):
    """When a mesh counts as solved: the carried load's relative miss, and the imbalance left."""

    load: float
    balance: float


FINE = Tolerance(load=3e-9, balance=1e-9)  # the certificate allows 1e-8
COARSE = Tolerance(load=1e-4, balance=1e-2)  # meshes that only start finer ones and tell the error
COARSEST = Tolerance(load=3e-4, balance=1e-2)  # those before the last two: they tell least of it
STAND_INS = 3  # linear contacts before one that is not
MOST_PASSES = 20  # linearisations about what was found before
BLUR = 0.1  # of the load missed: the imbalance from which on it is found again at the same width
# An error is estimated as a weighted sum of the last two changes under doubling of the mesh.
# Smooth errors of order two would leave a third of the last change; zone borders make it erratic,
# so both weights are larger, set by benchmarks/campaign (95 % of cases within 1.5 estimates).
ERROR_WEIGHTS = (0.7, 0.2)
# Where only one change is known (from a neighbour's state, or on coarse meshes) it may be small by
# chance, as zone borders fall between nodes; so it counts less, and a share of the scale is added
# which falls with the nodes: 95 % of random nips are within 2 estimates (4.3 of the change alone).
CHANGE_WEIGHT, CHANCE = 0.4, 4e-4
EXTRAPOLATED_WEIGHTS = (0.35, 0.05)  # once three values are extrapolated on fitted meshes


class State(Protocol):
    """What solved tractions come to on one mesh."""

    @property
    def half_width(self) -> float:
        """a [m]."""
        ...

    @property
    def solution(self) -> StickSlipSolution:
        """Tractions, zones, slips."""
        ...

    @property
    def known(self) -> Any:
        """What to linearise about next on the same mesh."""
        ...


class Equations(Protocol):
    """A contact's equations for one half width, linear."""

    def stick_slip(self) -> StickSlip:
        """Return the stick-slip problem, the normal problem put in."""
        ...

    def state(self, solution: StickSlipSolution) -> Any:
        """Return the state of solved tractions."""
        ...

    def carried(self, state: Any) -> float:
        """Return the load that a state carries [N/m]."""
        ...

    def imbalance(self, state: Any) -> float:
        """Return what a state leaves of whatever was linearised, relative; 0 where nothing was."""
        ...

    def frictionless(self) -> float | None:
        """Return the load without friction [N/m] where the equations tell it, else None."""
        ...

    @property
    def faces(self) -> Sequence[Array]:
        """Where each face's unknown tractions are, in units of a."""
        ...

    @property
    def places(self) -> Array:
        """Where what is linearised about is given, in units of a."""
        ...


class Known(NamedTuple):
    """What is known before a half width is tried: a state to linearise about, and zones."""

    about: Any
    zones: Array | None


class Before(NamedTuple):
    """What another mesh, or a neighbouring case, was linearised about."""

    places: Array  # in units of a
    about: Any


class Contact(Protocol):
    """A problem that the loop can solve."""

    @property
    def load(self) -> float:
        """What the pressure must carry [N/m]."""
        ...

    @property
    def widest(self) -> float:
        """Largest half width that makes sense [m]."""
        ...

    @property
    def beyond(self) -> str:
        """What is wrong with a wider one, and what to change."""
        ...

    @property
    def outside(self) -> str:
        """What of the problem lies far outside the model, and what to change; '' where nothing."""
        ...

    @property
    def settles_apart(self) -> bool:
        """Whether what is linearised must settle before a load tells the width.

        Bodies that are not linear must; else both settle together.
        """
        ...

    def stand_in(self, peak: float | None) -> Contact | None:
        """Return a linear contact to start from, for this largest pressure; None if unknown."""
        ...

    def guess(self) -> float:
        """Return a half width to start from [m]."""
        ...

    def frictionless_load(self, mesh: Mesh, a: float) -> float:
        """Return the load that a frictionless contact of half width a carries [N/m]."""
        ...

    def about(self, mesh: Mesh, a: float, before: Before | None) -> Any:
        """Return what to linearise about on a mesh, after another or to begin with."""
        ...

    def equations(self, mesh: Mesh, a: float, about: Any, last: Any = None) -> Any:
        """Return the equations for the half width a [m]; what still holds of the last may stay."""
        ...

    def refuse(self, equations: Any, state: Any) -> None:
        """Raise for a state that shows that there is no steady state."""
        ...

    def scalars(self, level: Level) -> Scalars:
        """Return the numbers whose changes from mesh to mesh tell their errors."""
        ...

    def scale(self, name: str, value: float) -> float:
        """Return what relative errors of a scalar are measured by."""
        ...

    def grain(self, name: str, mesh: Mesh) -> float:
        """Return what a mesh leaves of a scalar that changes between meshes need not show."""
        ...


class Widths(NamedTuple):
    """The half width that carries the load on each mesh, by its number of nodes [m].

    ``power`` is d ln P/d ln a: with it a neighbouring case knows where to begin.
    """

    power: float
    by_nodes: Mapping[int, float]

    def at(self, share: float) -> Widths:
        """Return what they would be at another load, ``share`` times as large."""
        factor = share ** (1 / self.power)
        return Widths(self.power, {nodes: a * factor for nodes, a in self.by_nodes.items()})


@dataclass(frozen=True, eq=False)
class Start:
    """What one mesh, or a neighbouring case, hands to the next.

    Attributes
    ----------
    half_width : float
        [m].
    faces : sequence of arrays
        Where each face's tractions were, in units of a.
    zones : (m,) int array
        Their states, face by face.
    power : float
        d ln P/d ln a.
    frictionless : (a, load), optional
        A half width and the load that it would carry on that mesh without friction.
    level : Level, optional
        The solved mesh itself.
    widths : Widths, optional
        Those of a neighbouring case, at the load asked.
    before : Before, optional
        What it was linearised about.
    rough : bool
        Whether it is no more than a guess.
    """

    half_width: float
    faces: Sequence[Array]
    zones: Array
    power: float = 2.0
    frictionless: tuple[float, float] | None = None
    level: Level | None = None
    widths: Widths | None = None
    before: Before | None = None
    rough: bool = False

    def zones_on(self, faces: Sequence[Array]) -> Array:
        """Carry the zones over: each new node takes that of the nearest old one of its face."""
        ends = np.cumsum([0, *(face.size for face in self.faces)])
        return np.concatenate([
            self.zones[first:last][nearest_nodes(old, new)]
            for old, new, first, last in zip(self.faces, faces, ends, ends[1:], strict=False)
        ])  # fmt: skip


@dataclass(frozen=True, eq=False)
class Level:
    """A solved mesh, and the power d ln P/d ln a found on the way."""

    mesh: Mesh
    equations: Any
    state: Any
    load: float  # asked
    power: float

    @property
    def share(self) -> float:
        """Load asked over load carried: a coarse mesh is not solved to the last digit."""
        return self.load / float(self.equations.carried(self.state))

    @property
    def half_width(self) -> float:
        """The half width at which this mesh would carry the load [m]."""
        return float(self.state.half_width * self.share ** (1 / self.power))

    def at_load(self, value: float) -> float:
        """Return a pressure as it would be at the load asked: it goes like load over width."""
        return float(value * self.share ** (1 - 1 / self.power))

    @property
    def start(self) -> Start:
        """What the next mesh starts from."""
        load = self.equations.frictionless()
        frictionless = None if load is None else (self.state.half_width, load)
        zones = self.state.solution.state
        return Start(
            self.half_width, self.equations.faces, zones, self.power, frictionless, self,
            before=Before(self.equations.places, self.state.known),
        )  # fmt: skip

    def borders(self) -> Array:
        """Return where zones change on any face, in units of the half width."""
        solution, first, found = self.state.solution, 0, []
        slack = solution.bound - np.abs(solution.traction)
        for face in self.equations.faces:
            own = slice(first, first + face.size)
            nodes = np.concatenate([[-1.0], face, [1.0]])
            found.append(zone_borders(nodes, solution.state[own], slack[own]))
            first += face.size
        return np.sort(np.concatenate(found))


class Ladder:
    """Solves a contact on one mesh after another, and tells the errors from their changes.

    ``level`` is the last mesh, ``before`` the one before it, ``history`` the scalars of all,
    ``values`` and ``errors`` the best values and their told errors, ``solves`` the linear systems,
    ``widths`` the half widths of all meshes.

    Parameters
    ----------
    contact : Contact
    scheme : Scheme
    find_zones : callable
        The algorithm that finds stick and slip.
    target : str
        The scalar that refinement is for.
    tolerance : Tolerance, optional
        Of the meshes that count; ``FINE`` without.
    """

    def __init__(
        self,
        contact: Contact,
        scheme: Scheme,
        target: str,
        find_zones: FindZones = solve_stick_slip,
        tolerance: Tolerance | None = None,
    ) -> None:
        self.contact, self.scheme, self.target = contact, scheme, target
        self.find_zones, self.tolerance = find_zones, tolerance or FINE
        self.level: Level
        self.before: Level | None = None
        self.history: list[Scalars] = []
        self.values: dict[str, float] = {}
        self.errors: dict[str, float] = {}
        self.solves = 0
        self._by_nodes: dict[int, float] = {}
        self._expected: Mapping[int, float] = {}  # half widths, from a neighbouring case
        self._missed = 0.0  # by how much a width carried to the last mesh missed, ln of loads

    # ---- ladders -------------------------------------------------------------------------------

    def climb(self, counts: Sequence[int], start: Start | None = None) -> None:
        """Solve on the scheme's own meshes, the last one to tolerance; tell errors from them."""
        if start is not None and start.widths is not None:
            self._expected = start.widths.by_nodes
        tolerances = [COARSEST] * (len(counts) - 2) + [COARSE, self.tolerance]
        for count, tolerance in zip(counts, tolerances[-len(counts) :], strict=True):
            self._step(self.scheme.mesh(count), start, tolerance)
            start = self.level.start
        if self.contact.settles_apart:  # there the coarsest mesh is but a start
            del self.history[:-2]
        self._tell()

    def climb_fitted(self, counts: Sequence[int], coarse: Tolerance) -> None:
        """Solve on meshes ever better fitted to the zone borders found before.

        A coarse one that fails is passed over: it was too coarse for a layer much thinner than the
        contact.
        """
        start = None
        for k, count in enumerate(counts):
            last = k + 1 == len(counts)
            mesh = self.scheme.mesh(count) if start is None else self._fitted(count)
            try:
                self._step(mesh, start, self.tolerance if last else coarse)
            except NotConverged:
                if last:
                    raise
                continue
            start = self.level.start
        self._tell()

    def double(self, rtol: float, most: int) -> None:
        """Double the mesh until the target's told error is below rtol, up to so many nodes."""
        while self.level.mesh.nodes.size < most and not self.reached(rtol):
            self._step(self.scheme.mesh(2 * self.level.mesh.nodes.size - 1), self.level.start)
            self._tell()

    def fit(self, rtol: float, most: int) -> None:
        """Refine to rtol on meshes fitted to the zone borders, and extrapolate.

        There errors fall regularly, by order two, and are extrapolated to zero cells.
        """
        nodes, before = self.level.mesh.nodes.size, list(self.history)
        fitted: list[Scalars] = []
        while not self.reached(rtol) and nodes <= most:
            for _ in range(1 if fitted else 2):  # the first fit is to borders of an unfitted mesh
                self._step(self._fitted(nodes), self.level.start)
            fitted.append(self.history[-1])
            nodes = 2 * nodes - 1
            if len(fitted) > 1:  # one alone tells nothing of its own error
                self._extrapolate(before, fitted)

    @property
    def widths(self) -> Widths:
        """What a neighbouring case may begin with."""
        return Widths(self.level.power, self._by_nodes)

    def reached(self, rtol: float) -> bool:
        """Tell whether the target's told error is below rtol of its scale."""
        name = self.target
        return self.errors[name] <= rtol * self.contact.scale(name, self.values[name])

    def errors_of(self, result: Any) -> dict[str, float]:
        """Return the told errors of a result's outputs.

        One that is not itself extrapolated is farther off by what the extrapolation would add.
        """
        return {
            name: error
            + abs(getattr(result, name) - self.values[name])
            + self.contact.grain(name, self.level.mesh)
            for name, error in self.errors.items()
        }

    def not_reached(self, rtol: float, what: str, result: Any) -> NotConverged:
        """Return the error that says that the target is not known to rtol."""
        nodes, error = self.level.mesh.nodes.size, self.errors[self.target]
        return NotConverged(
            f"rtol={rtol:g} is not reached with {nodes} nodes: the estimated error of {what} is "
            f"{error:.3g} N/m", result
        )  # fmt: skip

    # ---- told errors ---------------------------------------------------------------------------

    def _tell(self) -> None:
        """Take the values of the last mesh, and tell their errors from the changes so far."""
        self.values = dict(self.history[-1])
        if not self.scheme.refines:
            self.errors = dict.fromkeys(self.values, nan)
            return
        chance = CHANCE * (64 / (self.level.mesh.nodes.size - 1)) ** 1.6
        for name, value in self.values.items():
            told = [scalars[name] for scalars in self.history]
            if len(told) == 2:
                by_chance = chance * self.contact.scale(name, value)
                self.errors[name] = CHANGE_WEIGHT * abs(told[1] - told[0]) + by_chance
            else:
                self.errors[name] = _told_error(told)

    def _extrapolate(self, before: list[Scalars], fitted: list[Scalars]) -> None:
        for name in self.values:
            told = [scalars[name] for scalars in fitted]
            values = [told[0], *(b + (b - a) / 3 for a, b in pairwise(told))]
            weights = ERROR_WEIGHTS if len(values) < 4 else EXTRAPOLATED_WEIGHTS
            self.values[name] = values[-1]
            self.errors[name] = _told_error([*(s[name] for s in before), *values], weights)

    # ---- one mesh ------------------------------------------------------------------------------

    def _fitted(self, nodes: int) -> Mesh:
        assert isinstance(self.scheme, Graded)
        self._missed = 0.0  # of a mesh that is no finer one of the same kind
        return self.scheme.fitted(self.level.borders(), nodes)

    def _step(self, mesh: Mesh, start: Start | None, tolerance: Tolerance | None = None) -> None:
        solved = self._solved(mesh, start, tolerance or self.tolerance)
        self.before = getattr(self, "level", None)
        self.level = solved
        self._by_nodes.setdefault(mesh.nodes.size, solved.half_width)
        self.history.append(self.contact.scalars(self.level))

    def _solved(self, mesh: Mesh, start: Start | None, tolerance: Tolerance) -> Level:
        """Find stick and slip for a half width, inside the iteration on the half width."""
        contact = self.contact
        if start is None:
            start = self._stand_in(mesh)
        if start is None:
            a, power = self._frictionless(mesh)
        else:
            a, power = self._carried_over(start, mesh), start.power
        about = contact.about(mesh, a, None if start is None else start.before)
        step = _Step(self, mesh, Known(about, None), start, tolerance)
        for _ in range(MOST_PASSES):
            (equations, state), power = self._width(step.at, a, tolerance.load, power)
            a = state.half_width
            if step.settled:
                contact.refuse(equations, state)
                carried_over = start is not None and start.level is not None
                # what the frictionless contact left, the share of it included that was foreseen
                self._missed = step.missed + self._missed / 4 if carried_over else 0.0
                return Level(mesh, equations, state, contact.load, power)
        contact.refuse(equations, state)
        text = f"what the equations are linearised about did not settle in {MOST_PASSES} passes"
        raise self.stopped(text)

    def stopped(self, text: str) -> NotConverged:
        """Return the error of what was not solved, with what lies far outside the model."""
        return NotConverged("; ".join(filter(None, (text, self.contact.outside))))

    def _carried_over(self, start: Start, mesh: Mesh) -> float:
        """Return the half width to begin with: on each mesh the same load needs a little another.

        By how much, a neighbouring case tells if there is one, or a contact without friction to a
        tenth, at a tenth of the cost.  What that missed falls with the square of the cells.
        """
        expected = self._expected.get(mesh.nodes.size)
        if expected is not None:
            if start.level is None:
                return expected
            before = self._expected.get(start.level.mesh.nodes.size, start.half_width)
            return start.half_width * expected / before
        ratio = exp(-self._missed / 4)
        if start.frictionless is not None:
            a, before = start.frictionless
            now = self.contact.frictionless_load(mesh, a)
            ratio *= before / now if min(before, now) > 0 else 1.0
        return float(start.half_width * ratio ** (1 / start.power))

    def _frictionless(self, mesh: Mesh) -> tuple[float, float]:
        """Return the half width that carries the load without friction, and its power."""

        def evaluate(a: float) -> tuple[float, float]:
            return a, self.contact.frictionless_load(mesh, a)

        return self._width(evaluate, self.contact.guess(), 1e-2, 2.0)

    def _stand_in(self, mesh: Mesh) -> Start | None:
        """Return what linear bodies, about as stiff as the present ones, start from; or None."""
        peak: float | None = None
        start: Start | None = None
        for _ in range(STAND_INS if self.contact.settles_apart else 0):
            linear = self.contact.stand_in(peak)
            if linear is None:
                return None
            ladder = Ladder(linear, self.scheme, self.target, self.find_zones)
            level = ladder._solved(mesh, start, COARSE)
            peak, start = float(np.max(level.state.pressure)), replace(level.start, level=None)
            start = replace(start, frictionless=None, rough=True)
        return start

    def _width(
        self, evaluate: Callable[[float], tuple[Any, float]], guess: float, rtol: float,
        power: float,
    ) -> tuple[Any, float]:  # fmt: skip
        contact = self.contact
        try:
            return width_for_load(
                evaluate, contact.load, guess, rtol, power, contact.widest, contact.beyond
            )
        except WidthNotFound as stop:
            raise self.stopped(str(stop)) from None


class _Step:
    """Evaluates half widths on one mesh; what is known goes from one to the next."""

    def __init__(
        self, ladder: Ladder, mesh: Mesh, known: Known, start: Start | None, tolerance: Tolerance
    ) -> None:
        self.ladder, self.mesh, self.known, self.start = ladder, mesh, known, start
        self.tolerance = tolerance
        self.latest: tuple[Any, Any] | None = None
        self.missed = nan  # ln of the load carried at first over that asked
        # from a neighbouring state, linearisation and width settle together
        self.apart = ladder.contact.settles_apart and (start is None or start.rough)

    @property
    def settled(self) -> bool:
        """Whether the last state is what its equations were linearised about."""
        assert self.latest is not None
        equations, state = self.latest
        return bool(equations.imbalance(state) <= self.tolerance.balance)

    def at(self, a: float) -> tuple[tuple[Any, Any], float]:
        """Return equations, state and carried load for the half width a [m]."""
        contact = self.ladder.contact
        equations, state = self._linear(a)
        carried = float(equations.carried(state))
        for _ in range(MOST_PASSES):
            if not self._unsure(equations, state, carried):
                break
            equations, state = self._linear(a)
            carried = float(equations.carried(state))
        if isnan(self.missed):
            self.missed = log(carried / contact.load) if carried > 0 else 0.0
        return (equations, state), carried

    def _unsure(self, equations: Any, state: Any, carried: float) -> bool:
        """Tell whether a load means little yet, for what was linearised has not settled.

        Bodies that are not linear must settle first; what else is linearised, where it blurs by how
        much the load is missed: then the next width misses it again.
        """
        contact = self.ladder.contact
        if contact.settles_apart:
            return self.apart and not self.settled
        missed = abs(carried / contact.load - 1)
        blurred = missed > self.tolerance.load and equations.imbalance(state) > BLUR * missed
        return bool(blurred)

    def _linear(self, a: float) -> tuple[Any, Any]:
        """Solve once, about what is known; of bodies that are not linear afresh if that fails."""
        contact = self.ladder.contact
        equations, state, solution = self._solved(a)
        if solution.ending is not Ending.SOLVED and contact.settles_apart:
            self.known = Known(contact.about(self.mesh, a, None), None)
            equations, state, solution = self._solved(a)
        if solution.ending is not Ending.SOLVED:
            contact.refuse(equations, state)
            raise self.ladder.stopped(
                f"stick and slip not found ({solution.ending.name}): {solution.ending.value}"
            )
        self.known = Known(state.known, solution.state)
        self.latest = equations, state
        return equations, state

    def _solved(self, a: float) -> tuple[Any, Any, StickSlipSolution]:
        last = self.latest[0] if self.latest else None
        equations = self.ladder.contact.equations(self.mesh, a, self.known.about, last)
        zones = self.known.zones
        if self.start is not None:
            zones, self.start = self.start.zones_on(equations.faces), None
        solution = self.ladder.find_zones(equations.stick_slip(), zones)
        self.ladder.solves += solution.solves
        return equations, equations.state(solution), solution


def halved(nodes: int, coarsest: int) -> list[int]:
    """Return the numbers of nodes of a ladder, coarse first, that ends at ``nodes``."""
    counts = [nodes]
    while counts[0] > coarsest:
        counts.insert(0, (counts[0] + 1) // 2)
    return counts


def _told_error(values: Sequence[float], weights: tuple[float, float] = ERROR_WEIGHTS) -> float:
    """Estimate the last value's error from the last two changes; nan from a single value."""
    changes = [abs(b - a) for a, b in pairwise(values)][::-1]
    if len(changes) < 2:
        return changes[0] if changes else nan
    return weights[0] * changes[0] + weights[1] * changes[1]
