r"""The winding nip: from a problem to a certified result (thesis ch. 3).

    NipProblem --> for a half width a: influence matrices        assembly.NipEquations
                   normal problem        p = p0 + K q
                   stick-slip problem    q+, q-, xi              contact.stick_slip
               --> secant on a until int p = P
               --> NipResult with its certificate                outcome

Coarse grids come first: they find the zones from a cold start, hand them to the finer grid, and
tell the discretisation error.  Where ``rtol`` asks for more than the last of them gives, the grid
is graded anew towards the borders of the zones and doubled; on such grids NIT falls cleanly with
the square of the cells, so the last two are extrapolated.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any, Literal, TypeVar

import numpy as np

from .assembly import NipEquations, NipState, contact_radius, half_width_guess
from .contact.discretisation import Discretisation, discretisation, on_grid
from .contact.grid import nearest_nodes, segmented_grid, zone_borders
from .contact.panagiotopoulos import panagiotopoulos
from .contact.stick_slip import Ending, StickSlip, StickSlipSolution, solve_stick_slip
from .contact.width import WidthNotFound, width_for_load
from .errors import InvalidProblem, NotConverged, did_you_mean
from .options import check_kind, tolerance, whole_number
from .outcome import check_certificate, nip_result
from .problems import NipProblem
from .results import NipResult

__all__ = ["check_options", "solve_nip"]

Array = np.ndarray
T = TypeVar("T")
Scheme = Literal["graded", "thesis", "thesis-printed"]
Algorithm = Literal["pivoting", "panagiotopoulos"]

DEFAULT_NODES = {"graded": 65, "thesis": 200, "thesis-printed": 200}
DEFAULT_RTOL = 1e-3  # where neither nodes nor rtol are given: double 65 nodes until below it, ...
DEFAULT_MOST_NODES = 257  # ... but not beyond these; the error is told in any case
MOST_NODES = 1100  # of the grids that rtol asks for
LOAD_RTOL = 3e-9  # how nearly the pressure carries the nip load; the certificate allows 1e-8
COARSE_LOAD_RTOL = 1e-4  # on grids that only start finer ones and tell the error
# NIT's error is estimated as a weighted sum of its last two changes under doubling of the grid.
# Smooth errors of order two would leave a third of the last change; zone borders make it erratic,
# so both weights are larger, set by benchmarks/campaign (95 % of cases within 1.5 estimates).
ERROR_WEIGHTS = (0.7, 0.2)
# Where only one change is known (from a neighbour's state, or on coarse grids) it may be small by
# chance, as zone borders fall between nodes; so it counts less, and a share of the scale is added
# which falls with the nodes: 95 % of random nips are within 2 estimates (4.3 of the change alone).
CHANGE_WEIGHT, CHANCE = 0.4, 4e-4
EXTRAPOLATED_WEIGHTS = (0.35, 0.05)  # once three values are extrapolated on fitted grids


def solve_nip(
    problem: NipProblem,
    *,
    scheme: Scheme = "graded",
    nodes: int | None = None,
    rtol: float | None = None,
    algorithm: Algorithm = "pivoting",
    start: NipResult | None = None,
) -> NipResult:
    """Solve the winding nip: where the web sticks and slips, and what tension the nip adds.

    Parameters
    ----------
    problem : NipProblem
    scheme : {"graded", "thesis", "thesis-printed"}
        ``graded``: edge-graded nodes, exact kernel integrals (default).  ``thesis``: even nodes and
        backward differences (thesis sec. 3.4) with the web tension lumped; ``thesis-printed`` with
        the web's coefficients (121) as printed.
    nodes : int, optional
        Number M of nodes, 7 to 4000.  By default 65, doubled up to 257 until the estimated error
        of NIT is below 0.1 % (200 for the thesis's scheme).
    rtol : float, optional
        Refine until the estimated error of NIT is below ``rtol`` times the larger of |NIT| and 1 %
        of mu+ P; 1e-10 to 0.1; graded scheme only.  The grids are then fitted to the zones, and
        ``nip_induced_tension`` is extrapolated from them; the arrays are those of the finest.
    algorithm : {"pivoting", "panagiotopoulos"}
        How stick and slip are found; the latter is the thesis's process (sec. 3.6).
    start : NipResult, optional
        A solved neighbouring case; its half width and zones start this one, which saves the
        coarsest grids.  The answer does not depend on it.

    Returns
    -------
    NipResult

    Raises
    ------
    InvalidProblem
        For options out of range.
    NotConverged
        If a law is not satisfied to 1e-8, or ``rtol`` not reached; carries the best result.
    """
    check_kind("problem", problem, NipProblem)
    M = check_options(scheme=scheme, nodes=nodes, rtol=rtol, algorithm=algorithm)
    if start is not None:
        check_kind("start", start, NipResult)
    solver = _Solver(problem, algorithm)
    begin = None if start is None else _Start.of(start, problem.nip_load)
    tensions: list[float] = []
    for count in _grids(scheme, M, algorithm)[-2 if start else 0 :]:
        load_rtol = LOAD_RTOL if count == M else COARSE_LOAD_RTOL
        level = solver.solve(discretisation(scheme, count), begin, load_rtol)
        begin = level.start
        tensions.append(level.nip_induced_tension)
    tension = tensions[-1]
    scale = solver.tension_scale(tension)
    error = _first_error(tensions, M, scale) if scheme == "graded" else float("nan")
    if scheme == "graded" and nodes is None and rtol is None:
        while M < DEFAULT_MOST_NODES and not error <= DEFAULT_RTOL * solver.tension_scale(tension):
            M = 2 * M - 1
            level = solver.solve(discretisation(scheme, M), level.start)
            tensions.append(level.nip_induced_tension)
            tension, error = tensions[-1], _estimated_error(tensions)
    if rtol is not None:
        level, tension, error = _refined(solver, level, tensions, error, rtol)
    result = nip_result(level.equations, level.state, scheme, algorithm, tension, error)
    check_certificate(result)
    if rtol is not None and not error <= rtol * solver.tension_scale(tension):
        raise NotConverged(
            f"rtol={rtol:g} is not reached with {result.nodes} nodes: the estimated error of NIT "
            f"is {error:.3g} N/m", result
        )  # fmt: skip
    return result


def check_options(
    *,
    scheme: Any = "graded",
    nodes: Any = None,
    rtol: Any = None,
    algorithm: Any = "pivoting",
) -> int:
    """Check the options of :func:`solve_nip`; return the number of nodes.

    Raises
    ------
    InvalidProblem
        For an option out of range.
    """
    for name, value, known in (
        ("scheme", scheme, DEFAULT_NODES), ("algorithm", algorithm, _ALGORITHMS)
    ):  # fmt: skip
        if not isinstance(value, str) or value not in known:
            raise InvalidProblem([(name, f"{value!r} is unknown{did_you_mean(str(value), known)}")])
    if rtol is not None:
        tolerance("rtol", rtol, 1e-10, 0.1)
        if scheme != "graded":
            raise InvalidProblem([("rtol", f"{rtol!r} is not admissible with scheme {scheme!r}")])
    return DEFAULT_NODES[scheme] if nodes is None else whole_number("nodes", nodes, 7, 4000)


def _grids(scheme: str, M: int, algorithm: str) -> list[int]:
    """Return the numbers of nodes to solve on, coarse first; the published process starts cold."""
    grids = [M]
    coarsest = 24 if scheme == "graded" else 60
    while (algorithm == "pivoting" or scheme == "graded") and grids[0] > coarsest:
        grids.insert(0, (grids[0] + 1) // 2)
    return grids


def _first_error(tensions: list[float], nodes: int, scale: float) -> float:
    """Estimate NIT's error on the first grids, of which there may be two only [N/m]."""
    if len(tensions) != 2:
        return _estimated_error(tensions)
    chance = CHANCE * (64 / (nodes - 1)) ** 1.6 * scale
    return float(CHANGE_WEIGHT * abs(tensions[1] - tensions[0]) + chance)


def _estimated_error(tensions: list[float], weights: tuple[float, float] = ERROR_WEIGHTS) -> float:
    """Estimate NIT's error from its last two changes [N/m]; nan from a single grid."""
    changes = np.abs(np.diff(tensions))[::-1]
    if changes.size == 0:
        return float("nan")
    if changes.size == 1:
        return float(changes[0])
    return float(sum(w * c for w, c in zip(weights, changes, strict=False)))


@dataclass(frozen=True, eq=False)
class _Start:
    """What one grid hands to the next: half width, nodes with their zones, d ln P/d ln a."""

    half_width: float
    nodes: Array  # interior ones, in units of the half width
    zones: Array  # of the roll, then of the drum
    power: float = 2.0
    # where the same problem was solved on another grid: a half width, and the load that it would
    # carry there without friction
    frictionless: tuple[float, float] | None = None

    @classmethod
    def of(cls, result: NipResult, nip_load: float) -> _Start:
        """Start from another case's result; the width of a Hertzian nip goes by the load's root."""
        zones = np.concatenate([result.roll_zone[1:-1], result.drum_zone[1:-1]])
        a = result.half_width
        return cls(a * (nip_load / result.problem.nip_load) ** 0.5, result.x[1:-1] / a, zones)

    def zones_on(self, nodes: Array) -> Array:
        """Carry the zones over to other interior nodes: each takes those of the nearest old one."""
        nearest = nearest_nodes(self.nodes, nodes)
        n = self.nodes.size
        return np.concatenate([self.zones[:n][nearest], self.zones[n:][nearest]])


@dataclass(frozen=True, eq=False)
class _Level:
    """A solved grid, and the power d ln P/d ln a found on the way."""

    equations: NipEquations
    state: NipState
    power: float

    @property
    def nip_induced_tension(self) -> float:
        total = self.state.roll_traction + self.state.drum_traction
        return float(self.equations.matrices.weights @ total)

    @property
    def start(self) -> _Start:
        made, state = self.equations.matrices, self.state
        carried = float(made.weights @ state.pressure)
        a = state.half_width * (self.equations.problem.nip_load / carried) ** (1 / self.power)
        nodes = self.equations.disc.grid.nodes[1:-1]
        frictionless = (made.half_width, float(made.weights @ self.equations.pressure))
        return _Start(a, nodes, state.solution.state, self.power, frictionless)


class _Solver:
    """Solves one problem on one grid after another."""

    def __init__(self, problem: NipProblem, algorithm: str) -> None:
        self.problem, self.find_zones, self.solves = problem, _ALGORITHMS[algorithm], 0

    def tension_scale(self, tension: float) -> float:
        """Return what relative errors of NIT are measured by [N/m]."""
        return max(abs(tension), 0.01 * self.problem.roll_friction * self.problem.nip_load)

    def solve(
        self, disc: Discretisation, start: _Start | None, load_rtol: float = LOAD_RTOL
    ) -> _Level:
        """Find stick and slip for a half width, inside the iteration on the half width."""
        zones = None if start is None else start.zones_on(disc.grid.nodes[1:-1])
        if start is None:
            guess, power = self._frictionless(disc)
        else:
            guess, power = self._carried_over(start, disc), start.power

        def evaluate(a: float) -> tuple[tuple[NipEquations, NipState], float]:
            nonlocal zones
            equations = NipEquations.at(self.problem, disc, a)
            solution = self.find_zones(equations.stick_slip(), zones)
            self.solves += solution.solves
            if solution.ending is not Ending.SOLVED:
                raise NotConverged(
                    f"stick and slip not found ({solution.ending.name}): {solution.ending.value}"
                )
            zones = solution.state
            state = equations.state(replace(solution, solves=self.solves))
            return (equations, state), float(equations.matrices.weights @ state.pressure)

        (equations, state), power = self._width(evaluate, guess, load_rtol, power)
        return _Level(equations, state, power)

    def _carried_over(self, start: _Start, disc: Discretisation) -> float:
        """Return the half width to begin with: on each grid the same load needs a little another.

        By how much, a contact without friction tells to a tenth, at a tenth of the cost.
        """
        if start.frictionless is None:
            return start.half_width
        a, before = start.frictionless
        now = NipEquations.frictionless_load(self.problem, disc, a)
        share = before / now if min(before, now) > 0 else 1.0
        return float(start.half_width * share ** (1 / start.power))

    def _frictionless(self, disc: Discretisation) -> tuple[float, float]:
        """Return the half width that carries the nip load without friction, and its power."""

        def evaluate(a: float) -> tuple[float, float]:
            return a, NipEquations.frictionless_load(self.problem, disc, a)

        problem = self.problem
        bodies = (problem.roll, problem.drum)
        guess = half_width_guess(problem.nip_load, contact_radius(problem), bodies)
        return self._width(evaluate, guess, 1e-2, 2.0)

    def _width(
        self, evaluate: Callable[[float], tuple[T, float]], guess: float, rtol: float, power: float
    ) -> tuple[T, float]:
        try:
            widest = min(self.problem.roll.radius, self.problem.drum.radius)
            return width_for_load(evaluate, self.problem.nip_load, guess, rtol, power, widest)
        except WidthNotFound as stop:
            raise NotConverged(str(stop)) from None


def _refined(
    solver: _Solver, level: _Level, tensions: list[float], error: float, rtol: float
) -> tuple[_Level, float, float]:
    """Refine to ``rtol``: return the last level, NIT (extrapolated if need be) and its error.

    The grids are fitted to the zone borders that the one before found.  Then NIT's error falls
    regularly, by order two, and is extrapolated to zero cells.
    """
    tension = tensions[-1]
    nodes = level.equations.disc.grid.nodes.size
    fitted: list[float] = []
    while not error <= rtol * solver.tension_scale(tension) and nodes <= MOST_NODES:
        for _ in range(1 if fitted else 2):  # the first fit is to borders of an unfitted grid
            level = solver.solve(on_grid(segmented_grid(_borders(level), nodes)), level.start)
        fitted.append(level.nip_induced_tension)
        nodes = 2 * nodes - 1
        if len(fitted) > 1:  # one alone tells nothing of its own error
            values = [fitted[0], *(b + (b - a) / 3 for a, b in pairwise(fitted))]
            weights = ERROR_WEIGHTS if len(values) < 4 else EXTRAPOLATED_WEIGHTS
            tension, error = values[-1], _estimated_error([*tensions, *values], weights)
    return level, tension, error


def _borders(level: _Level) -> Array:
    """Return where zones change on either face, in units of the half width."""
    grid, solution = level.equations.disc.grid, level.state.solution
    slack = solution.bound - np.abs(solution.traction)
    faces = zip(np.split(solution.state, 2), np.split(slack, 2), strict=True)
    return np.sort(np.concatenate([zone_borders(grid.nodes, *face) for face in faces]))


def _pivoting(problem: StickSlip, start: Array | None) -> StickSlipSolution:
    return solve_stick_slip(problem, start)


_ALGORITHMS: dict[str, Callable[[StickSlip, Array | None], StickSlipSolution]] = {
    "pivoting": _pivoting,
    "panagiotopoulos": panagiotopoulos,
}
