"""Pivoting: the state of stick and slip in which every law holds.

With one face and the interlacing collocation points of :mod:`.grid` the matrix of the stick-slip
problem (:mod:`.stick_slip`) for given xi is a P-matrix (docs, theory), for which block pivoting
with a single-pivot safeguard ends at the unique solution after finitely many steps (Judice and
Pires 1994; the single pivots are Murty's).  The resultant grows with xi.  So three steps suffice:

    1. block pivoting on the whole system, xi among the unknowns: 1 to 10 systems nearly always;
    2. where that wanders, from K = 0, where the theory holds, to the whole of K by large steps;
    3. where that fails, regula falsi on xi with block pivoting inside: slower, and safe.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from .stick_slip import Ending, RigidFace, StickSlip, StickSlipSolution

if TYPE_CHECKING:
    from .joint import Joint

__all__ = ["keep_one_stuck", "solve_stick_slip"]

Array = np.ndarray

LEAST_STEP = 1 / 64  # of the coupling, to which no state is followed further


def solve_stick_slip(problem: StickSlip | Joint, start: Array | None = None) -> StickSlipSolution:
    """Find the state in which every law holds.

    Parameters
    ----------
    problem : StickSlip or Joint
    start : (m,) int array, optional
        State to begin with; all in stick by default.

    Returns
    -------
    StickSlipSolution
        With ``ending`` SOLVED, or the best that was found.
    """
    all_stick, solves = np.zeros(problem.friction.size, dtype=np.int8), 0
    # a start that leads astray is let go; from all in stick one gets to the answer nearly always
    for state in (start, all_stick) if start is not None and start.any() else (all_stick,):
        direct = _pivot(problem, state, limit=60)
        solves += direct.solves
        if direct.ending is Ending.SOLVED:
            return direct if direct.solves == solves else direct._replace(solves=solves)
    if not isinstance(problem, StickSlip):  # nearer to rounding, and then the safe way
        apart = solve_stick_slip(problem.condensed(), start)
        return apart._replace(solves=apart.solves + solves)
    coupled = _couple(problem)
    solves += coupled.solves
    if coupled.ending is Ending.SOLVED or problem.creep is None:
        return coupled._replace(solves=solves)
    bracketed = _bracket_creep(problem, direct.state, direct.creep)
    return bracketed._replace(solves=bracketed.solves + solves)


def _couple(problem: StickSlip) -> StickSlipSolution:
    """Solve without what tractions change of the pressure, then with ever more of it.

    Where it is large, of bodies far softer one way than the other, pivots may go round in a circle
    of states that all lie far from the answer; the one without it is near.
    """
    whole, part, step = problem.pressure_response, 0.0, 1.0
    without = replace(problem, pressure_response=np.zeros_like(whole))
    last = _pivot(without, np.zeros(problem.friction.size, dtype=np.int8), limit=60)
    solves = last.solves
    while part < 1 and last.ending is Ending.SOLVED and step >= LEAST_STEP:
        more = min(1.0, part + step)
        coupled = problem if more == 1 else replace(problem, pressure_response=more * whole)
        found = _pivot(coupled, last.state, limit=60)
        solves += found.solves
        if found.ending is Ending.SOLVED:
            part, last = more, found
        else:
            step /= 2
    return last._replace(ending=last.ending if part == 1 else Ending.LIMIT, solves=solves)


def _pivot(problem: StickSlip | Joint, state: Array, limit: int) -> StickSlipSolution:
    """Block pivoting; single pivots when the number of violated laws does not fall."""
    fewest, patience, solution = state.size + 1, 8, problem.solve(state)
    for solves in range(1, limit + 1):
        if solution.ending is Ending.SINGULAR:
            return solution._replace(solves=solves)
        violated = solution.violated()
        count = int(np.count_nonzero(violated))
        if count == 0:
            return solution if solves == 1 else solution._replace(solves=solves)
        single = count >= fewest and patience == 0
        if count < fewest:
            fewest, patience = count, 8
        elif single:  # Murty's rule: only the violated node of the highest index
            violated[: np.nonzero(violated)[0][-1]] = False
        else:
            patience -= 1
        state = solution.flipped(violated)
        if problem.rigid is not None and not single:
            _pass_on(problem.rigid, solution, violated, state)
        state = keep_one_stuck(problem, solution, state)
        solution = problem.solve(state)
    return solution._replace(ending=Ending.LIMIT, solves=limit)


def _pass_on(face: RigidFace, solution: StickSlipSolution, violated: Array, state: Array) -> None:
    """Turn nodes of a rigid body that cannot hold what the last one of a run of stick passes on.

    Where a web sticks to a rigid body its strain tells what each node holds, but for the last one
    of a run, which takes what is left of the force: that one alone would turn from state to state.
    What is above its bound goes to the nodes before it, until their slack holds it.
    """
    nodes, weights = face
    before, traction, bound = solution.state[nodes], solution.traction[nodes], solution.bound[nodes]
    ends = violated[nodes] & (before == 0)
    ends[:-1] &= before[1:] != 0
    for last in ends.nonzero()[0].tolist():
        way = 1 if traction[last] > 0 else -1
        over = weights * (way * traction - bound)
        held = (over[last::-1].cumsum() <= 0) | (before[last::-1] != 0)
        turned = int(held.argmax()) if held.any() else last + 1
        state[nodes][last + 1 - turned : last + 1] = way


def keep_one_stuck(problem: StickSlip | Joint, solution: StickSlipSolution, state: Array) -> Array:
    """Leave a node in stick where a resultant is prescribed: else nothing holds the creep."""
    held = problem.held
    if not held.size or np.count_nonzero(state.take(held)) < held.size:
        return state
    # the node that turns between the two directions: of those that pull against what the nodes just
    # unable to stick ask for, the one that slips least
    free = solution.state[held] == 0
    asked = np.sign(np.sum(state[held][free]))
    against = ~free & (state[held] * asked <= 0)
    distance = np.where(against if against.any() else ~free, np.abs(solution.slip[held]), np.inf)
    last = held[np.argmin(distance)] if np.isfinite(distance).any() else held[0]
    state = state.copy()
    state[last] = 0
    return state


def _bracket_creep(problem: StickSlip, start: Array, guess: float) -> StickSlipSolution:
    """Find the creep that carries the resultant, by regula falsi on a monotone function.

    For a given creep the problem is solved by pivoting; the resultant grows with the creep, from
    full slip one way to full slip the other, so a bracket exists whenever a steady state does.
    """
    search = _CreepSearch(problem, start)
    reach = float(np.max(np.abs(problem.stick_offset)))
    step, creep = 1e-3 * reach, guess if np.isfinite(guess) else 0.0
    excess = search.excess(creep)
    ends = [(creep, excess), (creep, excess)]
    while ends[0][1] * ends[1][1] > 0 and search.alive and step < 1e9 * reach:
        creep -= np.copysign(step, excess)
        step *= 2
        ends = [ends[1], (creep, search.excess(creep))]
    ends.sort()
    for _ in range(200):
        if not search.alive:
            break
        # the resultant is piecewise linear in the creep: the right piece's state solves the whole
        exact = search.whole()
        if exact.ending is Ending.SOLVED:
            return exact._replace(solves=search.solves)
        (low, f_low), (high, f_high) = ends
        creep = (low * f_high - high * f_low) / (f_high - f_low) if f_high > f_low else low
        excess = search.excess(creep)
        # Illinois: halve the value kept, or the other end would stand still
        ends = (
            [(low, f_low / 2), (creep, excess)]
            if excess > 0
            else [(creep, excess), (high, f_high / 2)]
        )
    return search.last._replace(ending=Ending.LIMIT, solves=search.solves)


class _CreepSearch:
    """Solves for given creeps, each from the state of the one before."""

    def __init__(self, problem: StickSlip, start: Array) -> None:
        self.problem, self.state, self.solves = problem, start, 0
        self.limit = 200 + 4 * start.size
        self.alive = True
        self.last: StickSlipSolution = StickSlipSolution.failed(start)

    def excess(self, creep: float) -> float:
        """Return the resultant less the prescribed one."""
        problem = self.problem
        assert problem.creep is not None
        assert problem.resultant is not None
        given = replace(
            problem, creep=None, resultant=None, offset=problem.offset + problem.creep * creep
        )
        self.last = _pivot(given, self.state, self.limit)
        self.state, self.solves = self.last.state, self.solves + self.last.solves
        self.alive = self.last.ending is Ending.SOLVED
        return float(problem.resultant @ self.last.traction) - problem.force

    def whole(self) -> StickSlipSolution:
        """Try the whole system from the state found last."""
        solution = _pivot(self.problem, self.state, limit=6)
        self.solves += solution.solves
        return solution
