r"""The winding nip: from a problem to a certified result (thesis ch. 3).

    NipProblem --> for a half width a: influence matrices        assembly.NipEquations
                   normal problem        p = p0 + K q
                   stick-slip problem    q+, q-, xi              contact.stick_slip
               --> secant on a until int p = P
               --> NipResult with its certificate

A coarse grid is solved first, from a cold start; its state starts the fine one and the difference
of the two gives the error estimate.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from math import nan
from typing import Literal

import numpy as np

from .assembly import NipEquations, NipState, contact_radius, half_width_guess
from .contact.certificate import certify
from .contact.discretisation import Discretisation, discretisation
from .contact.panagiotopoulos import panagiotopoulos
from .contact.stick_slip import Ending, StickSlip, StickSlipSolution, solve_stick_slip
from .contact.width import WidthNotFound, width_for_load
from .errors import InvalidProblem, NotConverged, did_you_mean
from .problems import NipProblem
from .results import NipResult, Residuals, SlipRatios

__all__ = ["solve_nip"]

Array = np.ndarray
Scheme = Literal["graded", "thesis", "thesis-printed"]
Algorithm = Literal["pivoting", "panagiotopoulos"]

DEFAULT_NODES = {"graded": 65, "thesis": 200, "thesis-printed": 200}
ACCEPTED_RESIDUAL = 1e-8


def solve_nip(
    problem: NipProblem,
    *,
    scheme: Scheme = "graded",
    nodes: int | None = None,
    rtol: float | None = None,
    algorithm: Algorithm = "pivoting",
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
        Number M of nodes, 7 to 4000; 65 by default (200 for the thesis's scheme).
    rtol : float, optional
        Refine until the estimated error of NIT is below ``rtol`` times the larger of |NIT| and 1 %
        of mu+ P; 1e-10 to 0.1.
    algorithm : {"pivoting", "panagiotopoulos"}
        How stick and slip are found; the latter is the thesis's process (sec. 3.6).

    Returns
    -------
    NipResult

    Raises
    ------
    InvalidProblem
        For options out of range.
    NotConverged
        If a law could not be satisfied to 1e-8, or ``rtol`` not reached; carries the best result.
    """
    M = _checked(scheme, nodes, rtol, algorithm)
    results: list[NipResult] = []
    state: NipState | None = None
    for count in _grids(scheme, M, algorithm):
        disc = discretisation(scheme, count)
        equations, state = _solve_on(problem, disc, algorithm, state)
        results.append(_result(equations, state, scheme, algorithm))
    result = _with_error(results)
    while rtol is not None and result.nip_induced_tension_error > rtol * _scale(problem, result):
        M = 2 * M - 1
        if M > 2100:
            raise NotConverged(
                f"rtol={rtol:g} is not reached with {result.nodes} nodes: the estimated error of "
                f"NIT is {result.nip_induced_tension_error:.3g} N/m", result
            )
        equations, state = _solve_on(problem, discretisation(scheme, M), algorithm, state)
        results.append(_result(equations, state, scheme, algorithm))
        result = _with_error(results)
    return result


def _checked(scheme: str, nodes: int | None, rtol: float | None, algorithm: str) -> int:
    """Check the options; return the number of nodes."""
    if scheme not in DEFAULT_NODES:
        raise InvalidProblem([("scheme", f"{scheme!r} is unknown{did_you_mean(scheme, DEFAULT_NODES)}")])
    if algorithm not in _ALGORITHMS:
        raise InvalidProblem(
            [("algorithm", f"{algorithm!r} is unknown{did_you_mean(algorithm, _ALGORITHMS)}")]
        )
    M = DEFAULT_NODES[scheme] if nodes is None else nodes
    if isinstance(M, bool) or not isinstance(M, (int, np.integer)) or not 7 <= M <= 4000:
        raise InvalidProblem([("nodes", f"{nodes!r} is out of range: must be a whole number, 7 to 4000")])
    if rtol is not None and not (isinstance(rtol, (int, float)) and 1e-10 <= rtol <= 0.1):
        raise InvalidProblem([("rtol", f"{rtol!r} is out of range: must be >= 1e-10 and <= 0.1")])
    return int(M)


def _grids(scheme: str, M: int, algorithm: str) -> list[int]:
    """Return the numbers of nodes to solve on, coarse first; the published process starts cold."""
    grids = [M]
    while algorithm == "pivoting" and grids[0] > (70 if scheme == "graded" else 60):
        grids.insert(0, (grids[0] + 1) // 2)
    if len(grids) == 1 and scheme == "graded" and M >= 13:
        grids.insert(0, (M + 1) // 2)
    return grids


def _scale(problem: NipProblem, result: NipResult) -> float:
    return max(abs(result.nip_induced_tension), 0.01 * problem.roll_friction * problem.nip_load)


def _with_error(results: list[NipResult]) -> NipResult:
    """Estimate NIT's error from the last two grids; the scheme's order is two."""
    if len(results) < 2:
        return results[-1]
    difference = abs(results[-1].nip_induced_tension - results[-2].nip_induced_tension)
    iterations = sum(r.iterations for r in results[-2:])
    return replace(results[-1], nip_induced_tension_error=difference / 2, iterations=iterations)


def _solve_on(
    problem: NipProblem, disc: Discretisation, algorithm: str, start: NipState | None
) -> tuple[NipEquations, NipState]:
    """Solve on one grid: stick and slip for a half width, inside the iteration on the width."""
    solve = _ALGORITHMS[algorithm]
    zones = None if start is None else _carried_over(start, disc)
    guess = start.half_width if start else _frictionless_width(problem, disc)
    solves = 0

    def evaluate(a: float) -> tuple[tuple[NipEquations, NipState], float]:
        nonlocal zones, solves
        equations = NipEquations.at(problem, disc, a)
        solution = solve(equations.stick_slip(), zones)
        solves += solution.solves
        state = equations.state(replace(solution, solves=solves))
        if solution.ending is not Ending.SOLVED:
            best = _result(equations, state, disc.scheme, algorithm) if solution.finite else None
            raise NotConverged(
                f"stick and slip not found ({solution.ending.name}): {solution.ending.value}", best
            )
        zones = solution.state
        return (equations, state), float(equations.load_weights @ state.pressure)

    try:
        return width_for_load(evaluate, problem.nip_load, guess, rtol=1e-11)
    except WidthNotFound as stop:
        raise NotConverged(str(stop)) from None


def _frictionless_width(problem: NipProblem, disc: Discretisation) -> float:
    """Return the half width at which the frictionless contact carries the nip load [m]."""

    def evaluate(a: float) -> tuple[float, float]:
        equations = NipEquations.at(problem, disc, a)
        return a, float(equations.load_weights @ equations.pressure)

    return width_for_load(evaluate, problem.nip_load, half_width_guess(problem), rtol=1e-2)


def _carried_over(start: NipState, disc: Discretisation) -> Array:
    """Carry zones over to another grid, by the nearest node."""
    n_old, n_new = start.pressure.size, disc.unknowns
    # both grids are even in their own parameter
    nearest = np.rint(np.arange(1, n_new + 1) * (n_old + 1) / (n_new + 1)).astype(int) - 1
    nearest = np.clip(nearest, 0, n_old - 1)
    old = start.solution.state
    return np.concatenate([old[:n_old][nearest], old[n_old:][nearest]])


def _padded(values: Array) -> Array:
    return np.concatenate([[0.0], values, [0.0]])


def _result(
    equations: NipEquations, state: NipState, scheme: str, algorithm: str
) -> NipResult:
    problem, a, n = equations.problem, state.half_width, equations.disc.unknowns
    h2, T_in = problem.web.thickness, problem.web_tension
    x = a * equations.disc.grid.nodes
    q_roll, q_drum = _padded(state.roll_traction), _padded(state.drum_traction)
    total = q_roll + q_drum
    tension = T_in + np.concatenate([[0.0], np.cumsum(np.diff(x) * (total[1:] + total[:-1]) / 2)])
    NIT = float(tension[-1]) - T_in
    slips = state.solution.slip
    last = equations.last_slips(state)
    zones = state.solution.state
    roll = problem.roll.surface(2 * a)
    drum = problem.drum.surface(2 * a)
    return NipResult(
        problem=problem,
        nip_induced_tension=NIT,
        nip_induced_tension_error=nan,
        half_width=a,
        approach=_approach(equations, state, T_in + NIT),
        offset=state.shift * contact_radius(problem),
        drum_creep=state.solution.creep - equations.web.c11 / h2 * (T_in + NIT),
        x=x,
        pressure=_padded(state.pressure),
        roll_traction=q_roll,
        drum_traction=q_drum,
        roll_slip=np.concatenate([slips[:1], slips[:n], [last[0]]]),
        drum_slip=np.concatenate([slips[n : n + 1], slips[n:], [last[1]]]),
        roll_zone=np.concatenate([zones[:1], zones[:n], zones[n - 1 : n]]),
        drum_zone=np.concatenate([zones[n : n + 1], zones[n:], zones[-1:]]),
        web_tension=tension,
        slip_ratios=_slip_ratios(x, zones[:n], zones[n:]),
        residuals=_residuals(equations, state),
        scheme=scheme,
        algorithm=algorithm,
        iterations=state.solution.solves,
        series_terms=max(roll.terms, drum.terms),
        series_error=max(roll.truncation_error, drum.truncation_error),
    )


def _approach(equations: NipEquations, state: NipState, T_out: float) -> float:
    """Return the mutual approach -delta > 0, from the indentation (82) at the trailing edge [m]."""
    problem, a = equations.problem, state.half_width
    put, edge = equations.disc.grid.integrate, slice(-1, None)
    v = equations.web.c12 * T_out
    for body, q in ((problem.roll, state.roll_traction), (problem.drum, state.drum_traction)):
        kernels = body.surface(2 * a)
        if kernels.deforms:
            v += float((put(kernels.normal_p, a, edge) @ state.pressure)[0])
            v += float((put(kernels.normal_q, a, edge) @ q)[0])
    return -(v + state.shift * a - a**2 / (2 * contact_radius(problem)))


def _slip_ratios(x: Array, roll: Array, drum: Array) -> SlipRatios:
    """Measure slip lengths, zone borders half-way between nodes (thesis eq. 172)."""
    border = (x[1:] + x[:-1]) / 2
    border[0], border[-1] = x[0], x[-1]

    def run(zones: Array, from_end: bool) -> tuple[int, int]:
        ordered = zones[::-1] if from_end else zones
        first = int(ordered[0])
        if first == 0:
            return 0, 0
        other = np.nonzero(ordered != first)[0]
        return first, int(other[0]) if other.size else ordered.size

    def share(zones: Array, from_end: bool) -> float:
        sign, count = run(zones, from_end)
        return sign * _length(border, count, from_end) / (x[-1] - x[0])

    sign_roll, count_roll = run(roll, True)
    sign_drum, count_drum = run(drum, True)
    both = min(count_roll, count_drum)
    dual = (sign_roll if sign_roll == sign_drum else 0) * _length(border, both, True)
    return SlipRatios(share(roll, False), share(roll, True), dual / (x[-1] - x[0]))


def _length(border: Array, count: int, from_end: bool) -> float:
    if count == 0:
        return 0.0
    n = border.size - 1
    return float(border[-1] - border[n - count] if from_end else border[count] - border[0])


def _residuals(equations: NipEquations, state: NipState) -> Residuals:
    """Measure every law anew from the assembled equations."""
    problem, p, q = equations.problem, state.pressure, state.solution.traction
    p_max = float(np.max(np.abs(p)))
    indentation = equations.slope_p @ p + equations.slope_q @ q + state.shift - equations.gap
    laws = certify(equations.stick_slip(), state.solution, slip_scale=float(np.max(equations.gap)))
    w = equations.load_weights
    NIT = float(w @ (state.roll_traction + state.drum_traction))
    x = equations.half_width * equations.disc.grid.nodes
    trapezoid = float(np.trapezoid(_padded(state.roll_traction + state.drum_traction), x))
    return Residuals(
        indentation=float(np.max(np.abs(indentation)) / np.max(equations.gap)),
        positive_pressure=max(0.0, -float(np.min(p)) / p_max),
        stick=laws.stick,
        friction_bound=laws.friction_bound,
        slip_traction=laws.slip_traction,
        slip_direction=laws.slip_direction,
        load_equilibrium=abs(float(w @ p) / problem.nip_load - 1),
        force_equilibrium=abs(float(w @ state.drum_traction) - problem.winding_force)
        / problem.nip_load,
        web_equilibrium=abs(NIT - trapezoid) / problem.nip_load,
    )


def _pivoting(problem: StickSlip, start: Array | None) -> StickSlipSolution:
    return solve_stick_slip(problem, start)


_ALGORITHMS = {"pivoting": _pivoting, "panagiotopoulos": panagiotopoulos}


def _laws(result: NipResult) -> Iterator[str]:
    """Yield the laws a result breaks by more than is accepted."""
    return (f"{k} {v:.2g}" for k, v in result.residuals.items() if not v <= ACCEPTED_RESIDUAL)
