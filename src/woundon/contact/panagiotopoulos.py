"""The thesis's modified Panagiotopoulos process (sec. 3.6), kept beside the default algorithm.

Normal and tangential problem are solved in turn.  Inside the tangential problem nodes are first
moved from stick to slip until none exceeds its bound (steps 4 to 6), then back to stick where
traction and slip disagree (steps 7, 8).  It has no safeguard: it may repeat itself for ever.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .pivoting import keep_one_stuck
from .stick_slip import Ending, StickSlip, StickSlipSolution

__all__ = ["panagiotopoulos"]

Array = np.ndarray


def panagiotopoulos(
    problem: StickSlip, start: Array | None = None, limit: int = 500
) -> StickSlipSolution:
    """Solve the stick-slip problem by the published process.

    Parameters
    ----------
    problem : StickSlip
    start : (m,) int array, optional
        State to begin with; by default stick everywhere (step 2).
    limit : int
        Largest number of linear systems.

    Returns
    -------
    StickSlipSolution
        ``ending`` is CYCLE or LIMIT where the process did not settle.
    """
    m = problem.friction.size
    state = np.zeros(m, dtype=np.int8) if start is None else start
    traction, solves = np.zeros(m), 0
    for _ in range(100):
        pressure = problem.pressure + problem.pressure_response @ traction  # step 1
        tangential = replace(
            problem, pressure=pressure, pressure_response=np.zeros_like(problem.pressure_response)
        )
        solution = _tangential(tangential, state, limit)  # steps 2 to 8
        solves += solution.solves
        if solution.ending is not Ending.SOLVED:
            return solution._replace(solves=solves)
        change = float(np.max(np.abs(solution.traction - traction)))
        traction, state = solution.traction, solution.state
        if change < 1e-12 * float(np.max(np.abs(traction))):  # step 9
            return problem.evaluate(state, traction, solution.creep)._replace(solves=solves)
    return solution._replace(ending=Ending.LIMIT, solves=solves)


def _tangential(problem: StickSlip, state: Array, limit: int) -> StickSlipSolution:
    """Steps 4 to 8: stick to slip until no bound is exceeded, then slip to stick, and again."""
    seen: set[bytes] = set()
    for solves in range(1, limit + 1):
        solution = problem.solve(state)
        if solution.ending is Ending.SINGULAR:
            return solution._replace(solves=solves)
        wrong = solution.violated()
        leave_stick = wrong & (state == 0)
        which = leave_stick if leave_stick.any() else wrong
        if not which.any():
            return solution._replace(solves=solves)
        if state.tobytes() in seen:
            return solution._replace(ending=Ending.CYCLE, solves=solves)
        seen.add(state.tobytes())
        state = keep_one_stuck(problem, solution, solution.flipped(which))
    return solution._replace(ending=Ending.LIMIT, solves=limit)
