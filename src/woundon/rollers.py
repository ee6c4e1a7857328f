r"""Two rollers without a web, rolling or static: the nip's contact code on the textbook's problems.

With the traction q on the upper roller along +x (and -q on the lower one)

    indentation, differentiated    v1' + v2' + Delta/R* = x/R*
    rolling                        slip = eps2 - eps1 + xi
    static                         slip = u2 - u1 + shift

and slip = 0 in stick, q = sgn(slip) mu p else.  The static problem is that of a load that only
grows; the pressure is taken to be there before the tangential load.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import nan
from typing import Any

import numpy as np

from .assembly import half_width_guess, surface_response
from .contact.certificate import certify
from .contact.discretisation import Discretisation, Response, discretisation, on_grid
from .contact.grid import Grid, nearest_nodes, segmented_grid, zone_borders
from .contact.normal import solve_normal
from .contact.stick_slip import Ending, StickSlip, StickSlipSolution, solve_stick_slip
from .contact.width import WidthNotFound, width_for_load
from .errors import NotConverged
from .options import check_kind, tolerance, whole_number
from .outcome import check_certificate
from .problems import RollerProblem
from .results import Residuals, RollerResult

__all__ = ["solve_rollers"]

Array = np.ndarray
MOST_NODES = 1700  # of the grids that rtol asks for


class _RollerEquations:
    """The equations of two rollers for one half width a."""

    def __init__(self, problem: RollerProblem, disc: Discretisation, a: float) -> None:
        self.problem, self.disc, self.a = problem, disc, a
        self.radius = 1 / (1 / problem.upper.radius + 1 / problem.lower.radius)
        zero = _no_response(disc)
        self.upper = surface_response(problem.upper, disc, a) or zero
        self.lower = surface_response(problem.lower, disc, a) or zero
        self.weights = a * disc.grid.weights
        self.gap = disc.middle * (a / self.radius)
        self.slope_p = self.upper.slope_p + self.lower.slope_p
        self.slope_q = self.upper.slope_q - self.lower.slope_q
        self.normal = solve_normal(self.slope_p, self.gap, self.slope_q)
        self.stick_slip = self._stick_slip()

    def _stick_slip(self) -> StickSlip:
        problem, n = self.problem, self.disc.unknowns
        rolling = problem.motion == "rolling"
        direct, through = self._rolling() if rolling else self._static()
        given = problem.creepage is not None
        return StickSlip(
            direct, through, np.full(n, problem.creepage or 0.0),
            self.normal[:-1, 0], self.normal[:-1, 1:],
            np.full(n, problem.friction), faces=1,
            creep=None if given else np.ones(n),
            resultant=None if given else self.weights,
            force=problem.tangential_load or 0.0,
        )  # fmt: skip

    def _rolling(self) -> tuple[Array, Array]:
        """Return the slip by unit tractions and pressures: strains of the upstream cells."""
        n = self.disc.unknowns
        direct = -(self.lower.strain_q + self.upper.strain_q)[:n]
        return direct, (self.lower.strain_p - self.upper.strain_p)[:n]

    def _static(self) -> tuple[Array, Array]:
        """Return the same from displacements at the nodes; the shift takes up any constant."""
        n, a = self.disc.unknowns, self.a
        at_nodes = Grid(self.disc.grid.nodes, self.disc.grid.nodes[1:-1])
        direct, through = np.zeros((n, n)), np.zeros((n, n))
        for body, sign in ((self.problem.lower, 1.0), (self.problem.upper, -1.0)):
            kernels = body.surface(2 * a)
            direct -= at_nodes.integrate(kernels.tangent_q, a)
            through += sign * at_nodes.integrate(kernels.tangent_p, a)
        return direct, through

    def pressure(self, solution: StickSlipSolution) -> Array:
        """Return the pressure at the interior nodes, (n,) [Pa]."""
        return self.normal[:-1, 0] + self.normal[:-1, 1:] @ solution.traction

    def result(self, solution: StickSlipSolution) -> RollerResult:
        """Return the solved state with its certificate."""
        problem, a, q = self.problem, self.a, solution.traction
        p = self.pressure(solution)
        shift = float(self.normal[-1, 0] + self.normal[-1, 1:] @ q)
        zone = solution.state
        given = problem.creepage
        creepage = given if given is not None else solution.creep
        return RollerResult(
            problem=problem,
            creepage=creepage if problem.motion == "rolling" else nan,
            tangential_load=float(self.weights @ q),
            half_width=a,
            approach=self._approach(p, q, shift),
            offset=shift * self.radius,
            x=a * self.disc.grid.nodes,
            pressure=_padded(p),
            traction=_padded(q),
            slip=np.concatenate([solution.slip[:1], solution.slip, solution.slip[-1:]]),
            zone=np.concatenate([zone[:1], zone, zone[-1:]]),
            residuals=self._residuals(solution, p, shift),
            iterations=solution.solves,
        )

    def _approach(self, p: Array, q: Array, shift: float) -> float:
        put, a, edge, v = self.disc.grid.integrate, self.a, slice(-1, None), 0.0
        for body, sign in ((self.problem.upper, 1.0), (self.problem.lower, -1.0)):
            kernels = body.surface(2 * a)
            v += float((put(kernels.normal_p, a, edge) @ p)[0])
            v += sign * float((put(kernels.normal_q, a, edge) @ q)[0])
        return -(v + shift * a - a**2 / (2 * self.radius))

    def _residuals(self, solution: StickSlipSolution, p: Array, shift: float) -> Residuals:
        problem, q, top = self.problem, solution.traction, float(np.max(self.gap))
        static = problem.motion == "static"
        laws = certify(self.stick_slip, solution, slip_scale=top * (self.a if static else 1.0))
        miss = self.slope_p @ p + self.slope_q @ q + shift - self.gap
        force = 0.0
        if problem.creepage is None:
            asked = problem.tangential_load or 0.0
            force = abs(float(self.weights @ q) - asked) / problem.load
        return Residuals(
            indentation=float(np.max(np.abs(miss))) / top,
            positive_pressure=max(0.0, -float(np.min(p)) / float(np.max(p))),
            stick=laws.stick,
            friction_bound=laws.friction_bound,
            slip_traction=laws.slip_traction,
            slip_direction=laws.slip_direction,
            load_equilibrium=abs(float(self.weights @ p) / problem.load - 1),
            force_equilibrium=force,
        )


def _padded(values: Array) -> Array:
    return np.concatenate([[0.0], values, [0.0]])


def _no_response(disc: Discretisation) -> Response:
    n = disc.unknowns
    cells, edge = np.zeros((n + 1, n)), np.zeros((n + 2, n))
    return Response(cells, cells, edge, edge)


def solve_rollers(
    problem: RollerProblem, *, nodes: int = 101, rtol: float | None = None
) -> RollerResult:
    """Solve two rollers in contact: pressure, traction, stick and slip.

    Parameters
    ----------
    problem : RollerProblem
    nodes : int
        Number of nodes, 7 to 4000; a few more where short zones ask for them.
    rtol : float, optional
        Double the nodes until the estimated relative error of the traction (L2) is below; 1e-8 to
        0.1.

    Returns
    -------
    RollerResult

    Raises
    ------
    InvalidProblem
        For options out of range.
    NotConverged
        If stick and slip or the half width were not found, a law is not satisfied to 1e-8, or
        ``rtol`` is not reached; the last two carry the best result.
    """
    check_kind("problem", problem, RollerProblem)
    check_options(nodes=nodes, rtol=rtol)
    result = _solve_fitted(problem, int(nodes))
    while rtol is not None and not result.traction_error <= rtol:
        count = 2 * result.x.size - 1
        if count > MOST_NODES:
            raise NotConverged(
                f"rtol={rtol:g} is not reached with {result.x.size} nodes: the estimated error of "
                f"the traction is {result.traction_error:.2g}", result
            )  # fmt: skip
        result = _solve_fitted(problem, count)
    check_certificate(result)
    return result


def check_options(*, nodes: Any = 101, rtol: Any = None) -> None:
    """Check the options of :func:`solve_rollers`.

    Raises
    ------
    InvalidProblem
        For an option out of range.
    """
    whole_number("nodes", nodes, 7, 4000)
    if rtol is not None:
        tolerance("rtol", rtol, 1e-8, 0.1)


def _solve_fitted(problem: RollerProblem, nodes: int) -> RollerResult:
    """Solve on grids ever better fitted to the zone borders, the last with all the nodes.

    The traction leaves a border like the root of the distance, so the grid is graded there.
    """
    quarter, half = max((nodes + 3) // 4, min(nodes, 13)), max((nodes + 1) // 2, min(nodes, 13))
    sizes = (quarter, quarter, half, nodes)
    before: _Solved | None = None
    levels: list[RollerResult] = []
    for k, size in enumerate(sizes):
        last = k + 1 == len(sizes)
        disc = _fitted_grid(before, size)
        try:
            before = _solve_on(problem, disc, before, 1e-11 if last else 1e-6)
        except NotConverged:
            if last:
                raise
            continue  # too coarse for a layer much thinner than the contact
        levels.append(before.equations.result(before.solution))
    change = _traction_change(levels[-2], levels[-1]) if len(levels) > 1 else nan
    return replace(
        levels[-1],
        traction_error=change / 2,
        iterations=sum(level.iterations for level in levels),
    )


@dataclass(frozen=True, eq=False)
class _Solved:
    """A solved grid, from which a finer one starts."""

    equations: _RollerEquations
    solution: StickSlipSolution

    @property
    def nodes(self) -> Array:
        return self.equations.disc.grid.nodes

    def zones_on(self, nodes: Array) -> Array:
        """Carry zones over to other interior nodes: each takes those of the nearest old one."""
        old = self.nodes[1:-1]
        return self.solution.state[nearest_nodes(old, nodes)]


def _fitted_grid(before: _Solved | None, nodes: int) -> Discretisation:
    """Return a grid fitted to the zone borders found before; to the edges where there are none."""
    if before is not None:
        solution = before.solution
        slack = solution.bound - np.abs(solution.traction)
        borders = zone_borders(before.nodes, solution.state, slack)
        if borders.size:
            return on_grid(segmented_grid(borders, nodes))
    return discretisation("graded", nodes)


def _traction_change(coarse: RollerResult, fine: RollerResult) -> float:
    """Return the L2 norm of the traction's change from grid to grid, relative to its own."""
    x = fine.x / fine.half_width
    other = np.interp(x, coarse.x / coarse.half_width, coarse.traction)
    whole = float(np.trapezoid(fine.traction**2, x))
    if whole == 0.0:
        return 0.0
    return float(np.sqrt(np.trapezoid((fine.traction - other) ** 2, x) / whole))


def _solve_on(
    problem: RollerProblem, disc: Discretisation, before: _Solved | None, load_rtol: float
) -> _Solved:
    """Solve on one grid: stick and slip for a half width, inside the iteration on the width."""
    zones = None if before is None else before.zones_on(disc.grid.nodes[1:-1])
    solves = 0

    def evaluate(a: float) -> tuple[_Solved, float]:
        nonlocal zones, solves
        equations = _RollerEquations(problem, disc, a)
        solution = solve_stick_slip(equations.stick_slip, zones)
        solves += solution.solves
        if solution.ending is not Ending.SOLVED:
            raise NotConverged(f"stick and slip not found: {solution.ending.value}")
        zones = solution.state
        found = _Solved(equations, replace(solution, solves=solves))
        return found, float(equations.weights @ equations.pressure(solution))

    guess = _frictionless_width(problem, disc) if before is None else before.equations.a
    try:
        return width_for_load(evaluate, problem.load, guess, load_rtol, widest=_widest(problem))[0]
    except WidthNotFound as stop:
        raise NotConverged(str(stop)) from None


def _frictionless_width(problem: RollerProblem, disc: Discretisation) -> float:
    """Return nearly the half width at which a frictionless contact carries the load [m]."""
    bodies = (problem.upper, problem.lower)

    def evaluate(a: float) -> tuple[float, float]:
        equations = _RollerEquations(problem, disc, a)
        return a, float(equations.weights @ equations.normal[:-1, 0])

    radius = 1 / (1 / problem.upper.radius + 1 / problem.lower.radius)
    guess = half_width_guess(problem.load, radius, bodies)
    try:
        return width_for_load(evaluate, problem.load, guess, rtol=1e-2, widest=_widest(problem))[0]
    except WidthNotFound as stop:
        raise NotConverged(str(stop)) from None


def _widest(problem: RollerProblem) -> float:
    return min(problem.upper.radius, problem.lower.radius)
