"""A contact on one mesh: stick and slip for a half width, inside the iteration on the half width.

for a half width a: equations                                    Contact.equations
                    stick and slip                               pivoting
                    on to the width that carries the load        follow
secant on a, where that does not get there                       width
again about what was found, until nothing moves (where something was linearised)
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import isnan, log, nan
from typing import Any, NamedTuple

import numpy as np

from ..errors import NotConverged
from .contracts import Contact
from .follow import follow
from .levels import Known, Level, Start
from .meshes import Mesh
from .panagiotopoulos import panagiotopoulos
from .pivoting import solve_stick_slip
from .stick_slip import Ending, StickSlip, StickSlipSolution
from .width import WidthNotFound, width_for_load

__all__ = ["ALGORITHMS", "COARSE", "COARSEST", "FINE", "LOOSE", "FindZones", "OneMesh", "Tolerance"]

Array = np.ndarray
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
LOOSE = Tolerance(load=1e-2, balance=1e-2)  # where outputs are told at the load asked
COARSEST = Tolerance(load=3e-4, balance=1e-2)  # those before the last two: they tell least of it
STAND_INS = 3  # linear contacts before one that is not
FRICTIONLESS = 0.3  # ln of loads: from so near the width without friction is extrapolated
MOST_FOLLOWED = 4  # changes of the zones along the way to the half width asked
MOST_PASSES = 20  # linearisations about what was found before
BLUR = 0.1  # of the load missed: the imbalance from which on it is found again at the same width


class OneMesh:
    """Solves a contact on one mesh or another.

    Attributes
    ----------
    contact : Contact
    find_zones : callable
        The algorithm that finds stick and slip.
    solves : int
        Linear systems so far.
    begun : (m,) int array or None
        The zones that the last mesh took over.
    missed : float
        By how much its first half width missed the load, ln of loads.
    """

    def __init__(self, contact: Contact, find_zones: FindZones) -> None:
        self.contact, self.find_zones = contact, find_zones
        self.solves, self.missed = 0, 0.0
        self.begun: Array | None = None

    def solved(
        self, mesh: Mesh, start: Start | None, a: float | None, tolerance: Tolerance
    ) -> Level:
        """Return a solved mesh.

        Parameters
        ----------
        mesh : Mesh
        start : Start or None
            Another mesh or a neighbouring case.
        a : float, optional
            Half width to begin with [m]; that of the start without.
        tolerance : Tolerance

        Raises
        ------
        NotConverged
        """
        contact = self.contact
        if start is None:
            start = self._stand_in(mesh)
        if start is None:
            a, power = self._frictionless(mesh)
        else:
            a, power = a or start.half_width, start.power
        about = contact.about(mesh, a, None if start is None else start.before)
        step = _Step(self, mesh, Known(about, None), start, tolerance)
        for _ in range(MOST_PASSES):
            (equations, state), power = self._width(step.at, a, tolerance.load, power, step)
            a = state.half_width
            if step.followed:
                power = step.power
            if step.settled:
                contact.refuse(equations, state)
                self.begun, self.missed = step.begun, step.missed
                return Level(mesh, equations, state, contact.load, power)
        contact.refuse(equations, state)
        text = f"what the equations are linearised about did not settle in {MOST_PASSES} passes"
        raise self.stopped(text)

    def stopped(self, text: str) -> NotConverged:
        """Return the error of what was not solved, with what lies far outside the model."""
        return NotConverged("; ".join(filter(None, (text, self.contact.outside))))

    def _frictionless(self, mesh: Mesh) -> tuple[float, float]:
        """Return the half width that carries the load without friction, and its power."""

        def evaluate(a: float) -> tuple[tuple[float, float], float]:
            carried = self.contact.frictionless_load(mesh, a)
            return (a, carried), carried

        (a, carried), power = self._width(evaluate, self.contact.guess(), FRICTIONLESS, 2.0)
        return float(a * (self.contact.load / carried) ** (1 / power)), power

    def _stand_in(self, mesh: Mesh) -> Start | None:
        """Return what linear bodies, about as stiff as the present ones, start from; or None."""
        peak: float | None = None
        start: Start | None = None
        for _ in range(STAND_INS if self.contact.settles_apart else 0):
            linear = self.contact.stand_in(peak)
            if linear is None:
                return None
            level = OneMesh(linear, self.find_zones).solved(mesh, start, None, COARSE)
            peak, start = float(np.max(level.state.pressure)), replace(level.start, level=None)
            start = replace(start, frictionless=None, rough=True)
        return start

    def _width(
        self, evaluate: Callable[[float], tuple[Any, float]], guess: float, rtol: float,
        power: float, step: _Step | None = None,
    ) -> tuple[Any, float]:  # fmt: skip
        contact = self.contact
        try:
            return width_for_load(
                evaluate, contact.load, guess, rtol, power, contact.widest, lambda: contact.beyond
            )
        except WidthNotFound as stop:
            if step is not None and step.latest is not None:
                contact.refuse(*step.latest)
            raise self.stopped(str(stop)) from None


class _Step:
    """Evaluates half widths on one mesh; what is known goes from one to the next."""

    def __init__(
        self, solver: OneMesh, mesh: Mesh, known: Known, start: Start | None, tolerance: Tolerance
    ) -> None:
        self.solver, self.mesh, self.known, self.start = solver, mesh, known, start
        self.tolerance = tolerance
        self.latest: tuple[Any, Any] | None = None
        self.missed = nan  # ln of the load carried at first over that asked
        self.begun: Array | None = None  # the zones taken over
        self.power, self.followed = 2.0 if start is None else start.power, False
        # from a neighbouring state, linearisation and width settle together
        self.apart = solver.contact.settles_apart and (start is None or start.rough)

    @property
    def settled(self) -> bool:
        """Whether the last state is what its equations were linearised about."""
        assert self.latest is not None
        equations, state = self.latest
        return bool(equations.imbalance(state) <= self.tolerance.balance)

    def at(self, a: float) -> tuple[tuple[Any, Any], float]:
        """Return equations, state and carried load for the half width a [m], or a better one."""
        equations, state = self._linear(a)
        if isnan(self.missed):
            carried = float(equations.carried(state))
            self.missed = log(carried / self.solver.contact.load) if carried > 0 else 0.0
        if not self.solver.contact.settles_apart:
            equations, state = self._followed(equations, state)
        for _ in range(MOST_PASSES):
            if not self._unsure(equations, state):
                break
            equations, state = self._linear(state.half_width)
        return (equations, state), float(equations.carried(state))

    def _followed(self, equations: Any, state: Any) -> tuple[Any, Any]:
        """Return what carries the load, by the factors of a solved state; that where they fail."""
        for _ in range(MOST_FOLLOWED):
            if state.solution.joint is None:
                break
            load = self.solver.contact.load
            found = follow(equations, state, load, self.tolerance, self.power)
            if found is None:
                break
            equations, state, self.power = found[:3]
            self.followed, self.latest = True, (equations, state)
            if found.kept:
                break
            equations, state = self._linear(state.half_width)
        return equations, state

    def _unsure(self, equations: Any, state: Any) -> bool:
        """Tell whether a load means little yet, for what was linearised has not settled.

        Bodies that are not linear must settle first; what else is linearised, where it blurs by how
        much the load is missed: then the next width misses it again.
        """
        contact = self.solver.contact
        if contact.settles_apart:
            return self.apart and not self.settled
        missed = abs(float(equations.carried(state)) / contact.load - 1)
        blurred = missed > self.tolerance.load and equations.imbalance(state) > BLUR * missed
        return bool(blurred)

    def _linear(self, a: float) -> tuple[Any, Any]:
        """Solve once, about what is known; of bodies that are not linear afresh if that fails."""
        contact = self.solver.contact
        equations, state, solution = self._solved(a)
        if solution.ending is not Ending.SOLVED and contact.settles_apart:
            self.known = Known(contact.about(self.mesh, a, None), None)
            equations, state, solution = self._solved(a)
        if solution.ending is not Ending.SOLVED:
            contact.refuse(equations, state)
            raise self.solver.stopped(
                f"stick and slip not found ({solution.ending.name}): {solution.ending.value}"
            )
        self.known = Known(state.known, solution.state)
        self.latest = equations, state
        return equations, state

    def _solved(self, a: float) -> tuple[Any, Any, StickSlipSolution]:
        last = self.latest[0] if self.latest else None
        equations = self.solver.contact.equations(self.mesh, a, self.known.about, last)
        joint = getattr(equations, "joint", None)
        by_pivots = self.solver.find_zones is solve_stick_slip and joint is not None
        problem: Any = joint if by_pivots else equations.stick_slip()
        zones = self.known.zones
        if self.start is not None:
            self.begun = zones = self.solver.contact.zones(self.start, equations)
            self.start = None
        elif zones is None and by_pivots:
            zones = self.solver.contact.first_zones(equations)
        solution = self.solver.find_zones(problem, zones)
        self.solver.solves += solution.solves
        return equations, equations.state(solution), solution
