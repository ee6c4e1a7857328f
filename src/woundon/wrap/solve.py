r"""The winding nip with its wraps: from a problem to a certified result (thesis sec. 3.5).

    NipProblem --> for a half width a and a known T0, kappa0:   equations.WrapEquations
                   normal problem       z = z0 + Z q            p+, p-, Delta
                   stick-slip problem   q+, q-, xi              contact.stick_slip
               --> T, kappa of the solution take the place of T0, kappa0, while a secant moves a
                   until int p- = P: both settle together
               --> WrappedNipResult with its certificate        outcome

Coarse grids come first, as in the plain nip: they find zones, tension and curvature for the finer
ones and tell the discretisation error.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import degrees, exp, pi

import numpy as np

from ..assembly import NipEquations, contact_radius, half_width_guess
from ..contact.discretisation import Discretisation, discretisation
from ..contact.stick_slip import Ending, solve_stick_slip
from ..contact.width import WidthNotFound, width_for_load
from ..errors import InvalidProblem, NoSteadyState, NotConverged
from ..options import check_kind, whole_number
from ..outcome import check_certificate
from ..problems import NipProblem
from .equations import Loads, WrapEquations, WrapState
from .grid import WrapGrid, wrap_grid
from .outcome import wrapped_result
from .result import WrappedNipResult

__all__ = ["solve_wrapped_nip"]

Array = np.ndarray

LOAD_RTOL, COARSE_LOAD_RTOL = 8e-9, 1e-4  # the certificate allows 1e-8
BALANCE_RTOL, COARSE_BALANCE_RTOL = 1e-9, 1e-2
COARSEST = 24  # nodes
ERROR_WEIGHTS = (0.7, 0.2)  # of the last two changes under doubling, as for the plain nip
SHORTEST_WRAP = 2.0  # half widths


def solve_wrapped_nip(
    problem: NipProblem,
    *,
    roll_wrap: float = pi,
    drum_wrap: float = 0.0,
    wrap_friction: float | None = None,
    winding_force: float | None = None,
    nodes: int = 65,
    wrap_nodes: int | None = None,
) -> WrappedNipResult:
    """Solve the winding nip with the web wrapped on the roll behind it and on the drum before it.

    Parameters
    ----------
    problem : NipProblem
        ``winding_force`` is the drum's whole, on nip and wrap.
    roll_wrap : float
        Angle from the line of centres to where the web is held to the roll (thesis eq. 96) [rad],
        at most pi; 0 holds it at the trailing edge (97), as the plain nip does.
    drum_wrap : float
        Angle of the arc on which the web lies on the drum before the nip [rad], 0 to pi.
    wrap_friction : float, optional
        mu+ behind the nip, >= 1e-6; by default that in the nip.
    winding_force : float, optional
        F on nip and drum wrap together [N/m]; by default the problem's, which must stay below the
        nip's own mu- P.  With a wrap the drum can take mu- P + T_in (exp(mu- drum_wrap) - 1).
    nodes : int
        Number of nodes in the nip, 17 to 1025.
    wrap_nodes : int, optional
        Number of cells on each arc, 12 to 2048; by default 3/4 of those in the nip.

    Returns
    -------
    WrappedNipResult

    Raises
    ------
    InvalidProblem
        For angles or options out of range, or a wrap on the drum without web tension.
    NoSteadyState
        If the drum slides under nip and wrap, or the web would be slack on a wrap.
    NotConverged
        If a law is not satisfied to 1e-8; carries the best result.
    """
    check_kind("problem", problem, NipProblem)
    mu = problem.roll_friction if wrap_friction is None else wrap_friction
    _check("roll_wrap", roll_wrap, 0.0, pi, "rad")
    _check("drum_wrap", drum_wrap, 0.0, pi, "rad")
    if wrap_friction is not None:
        _check("wrap_friction", mu, 1e-6, 10.0, "1")
    nodes = whole_number("nodes", nodes, 17, 1025)
    cells = 3 * (nodes - 1) // 4 if wrap_nodes is None else wrap_nodes
    cells = whole_number("wrap_nodes", cells, 12, 2048)
    F = problem.winding_force if winding_force is None else winding_force
    _check_loads(problem, F, drum_wrap)
    loads = Loads(roll_wrap > 0, drum_wrap > 0, float(mu), float(F))
    solver = _Solver(problem, float(roll_wrap), float(drum_wrap), loads)
    level: _Level | None = None
    tensions: list[float] = []
    for count in _grids(nodes):
        fine = count == nodes
        on_arcs = max(8, cells * (count - 1) // (nodes - 1))
        level = solver.solve(discretisation("graded", count), on_arcs, level, fine)
        tensions.append(float(level.state.tension[-1]))
    assert level is not None
    changes = np.abs(np.diff(tensions))[::-1]
    error = float(sum(w * c for w, c in zip(ERROR_WEIGHTS, changes, strict=False)))
    angles = (float(roll_wrap), float(drum_wrap))
    result = wrapped_result(level.equations, level.state, angles, error)
    check_certificate(result)
    return result


def _check_loads(problem: NipProblem, F: float, drum_wrap: float) -> None:
    """Refuse a slack web on the drum, and forces that slide it (capstan, thesis eq. 179)."""
    T_in, mu = problem.web_tension, problem.drum_friction
    _check("winding_force", F, -1e7, 1e7, "N/m")
    if drum_wrap > 0 and T_in == 0:
        raise InvalidProblem.at(
            "web_tension", "0 is out of range: a web wrapped on the drum must be taut, > 0 [N/m]"
        )
    nip = mu * problem.nip_load
    low = -nip - T_in * (1 - exp(-mu * drum_wrap))
    high = nip + T_in * (exp(mu * drum_wrap) - 1)
    if not low < F < high:
        raise NoSteadyState.at(
            "winding_force",
            f"{F:.10g} is out of range; must be > {low:.10g} and < {high:.10g} [N/m], what "
            "friction can carry in the nip and on the drum's wrap, or the drum slides",
        )


def _check(name: str, value: float, low: float, high: float, unit: str) -> None:
    good = isinstance(value, (int, float, np.integer, np.floating)) and not isinstance(value, bool)
    if good and low <= value <= high * (1 + 1e-12):
        return
    hint = ""
    if good and unit == "rad" and 2 * pi < value <= degrees(high):
        hint = f" (angles are in radians: {value:g} degrees are {value * pi / 180:.6g})"
    elif good and unit == "rad":
        hint = f" ({value:.6g} rad is {degrees(value):.4g} deg)"
    given = f"{value:.6g}" if good else repr(value)
    raise InvalidProblem.at(
        name, f"{given} is out of range; must be >= {low:g} and <= {high:.6g} [{unit}]{hint}"
    )


def _grids(nodes: int) -> list[int]:
    grids = [nodes]
    while grids[0] > COARSEST:
        grids.insert(0, (grids[0] + 1) // 2)
    return grids


@dataclass(frozen=True, eq=False)
class _Level:
    """A solved grid, and the power d ln P/d ln a found on the way."""

    equations: WrapEquations
    state: WrapState
    power: float


@dataclass(eq=False)
class _Known:
    """What the next linearisation starts from: tension, curvature and zones at the nodes."""

    tension: Array
    bend: Array
    zones: Array | None


class _Solver:
    """Solves one problem on one grid after another."""

    def __init__(
        self, problem: NipProblem, roll_wrap: float, drum_wrap: float, loads: Loads
    ) -> None:
        self.problem, self.roll_wrap, self.drum_wrap = problem, roll_wrap, drum_wrap
        self.loads, self.solves = loads, 0

    def grid(self, disc: Discretisation, cells: int, a: float) -> WrapGrid:
        """Return the grid for a half width: the arcs' ends stay where they are in space."""
        problem = self.problem
        drum = self.drum_wrap * problem.drum.radius / a
        roll = self.roll_wrap * problem.roll.radius / a - 1 if self.loads.roll_arc else 0.0
        if self.loads.roll_arc and roll < SHORTEST_WRAP - 1:
            least = SHORTEST_WRAP * a / problem.roll.radius
            raise InvalidProblem.at(
                "roll_wrap",
                f"{self.roll_wrap:.6g} is out of range; the nip's trailing edge is at "
                f"{a / problem.roll.radius:.4g}, so it must be 0 or >= {least:.4g} [rad]",
            )
        return wrap_grid(disc.grid, drum, cells, roll, cells)

    def solve(self, disc: Discretisation, cells: int, start: _Level | None, fine: bool) -> _Level:
        """Find tension, curvature and half width together."""
        if start is None:
            a, power = self._frictionless(disc)
            known = self._guess(self.grid(disc, cells, a))
        else:
            a, power = start.state.half_width, start.power
            known = _carried_over(start, self.grid(disc, cells, a))

        def evaluate(a: float) -> tuple[tuple[WrapEquations, WrapState], float]:
            grid = self.grid(disc, cells, a)
            equations = WrapEquations(self.problem, self.loads, grid, a, known.tension, known.bend)
            solution = solve_stick_slip(equations.stick_slip(), known.zones)
            self.solves += solution.solves
            state = equations.state(replace(solution, solves=self.solves))
            known.tension, known.bend, known.zones = state.tension, state.bend, solution.state
            if solution.ending is not Ending.SOLVED:
                self._refuse_slack(equations, state)
                raise NotConverged(
                    f"stick and slip not found ({solution.ending.name}): {solution.ending.value}"
                )
            return (equations, state), equations.nip_load(state)

        rtol, balance = (
            (LOAD_RTOL, BALANCE_RTOL) if fine else (COARSE_LOAD_RTOL, COARSE_BALANCE_RTOL)
        )
        for _ in range(20):
            try:
                (equations, state), power = width_for_load(
                    evaluate, self.problem.nip_load, a, rtol, power,
                    min(self.problem.roll.radius, self.problem.drum.radius),
                )  # fmt: skip
            except WidthNotFound as stop:
                raise NotConverged(str(stop)) from None
            self._refuse_slack(equations, state)
            a = state.half_width
            if equations.imbalance(state) <= balance:
                return _Level(equations, state, power)
        raise NotConverged("tension and curvature of the web did not settle")

    def _frictionless(self, disc: Discretisation) -> tuple[float, float]:
        """Return the half width that carries the load without friction or wrap, and its power."""
        problem = self.problem
        bodies = (problem.roll, problem.drum)
        guess = half_width_guess(problem.nip_load, contact_radius(problem), bodies)
        try:
            return width_for_load(
                lambda a: (a, NipEquations.frictionless_load(problem, disc, a)),
                problem.nip_load, guess, 1e-2, 2.0,
                min(problem.roll.radius, problem.drum.radius),
            )  # fmt: skip
        except WidthNotFound as stop:
            raise NotConverged(str(stop)) from None

    def _guess(self, grid: WrapGrid) -> _Known:
        """Guess tension and curvature to begin with."""
        problem = self.problem
        before = np.arange(grid.size) <= grid.last
        gained = max(self.loads.force, 0.0) + 0.2 * problem.roll_friction * problem.nip_load
        tension = problem.web_tension + np.where(before, 0.0, gained)
        bend = np.where(before, -1 / problem.drum.radius, 1 / problem.roll.radius)
        return _Known(tension, bend, None)

    def _refuse_slack(self, equations: WrapEquations, state: WrapState) -> None:
        """Raise where the web is slack on a wrap: then nothing presses it on."""
        grid, T = equations.grid, state.tension
        for name, arc, present in (
            ("behind the nip", T[grid.last :], self.loads.roll_arc),
            ("before the nip", T[: grid.first + 1], self.loads.drum_arc),
        ):
            T_in, least = self.problem.web_tension, float(np.min(arc))
            if present and least <= 0:
                raise NoSteadyState.at(
                    "web_tension",
                    f"{T_in:.6g} leaves the web slack {name}: its tension falls to {least:.4g} "
                    f"[N/m]; more is needed, about {T_in - least:.4g}",
                )


def _carried_over(start: _Level, grid: WrapGrid) -> _Known:
    """Carry tension, curvature and zones over to another grid."""
    equations, state = start.equations, start.state
    old, zones = equations.grid, state.solution.state
    n_q = equations.roll_q.size
    faces = (
        (zones[:n_q], old.nodes[equations.roll_q], grid.nodes[grid.first + 1 : -1]),
        (zones[n_q:], old.nodes[equations.drum_q], grid.nodes[1 : grid.last]),
    )
    nearest = [own[np.searchsorted((x[1:] + x[:-1]) / 2, new)] for own, x, new in faces]
    return _Known(
        np.interp(grid.nodes, old.nodes, state.tension),
        np.interp(grid.nodes, old.nodes, state.bend),
        np.concatenate(nearest),
    )
