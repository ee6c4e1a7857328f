"""How far a stick-slip solution is from each law, measured from the matrices themselves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .stick_slip import StickSlip, StickSlipSolution

__all__ = ["Laws", "certify"]


@dataclass(frozen=True)
class Laws:
    """Largest violation of each law, dimensionless."""

    stick: float
    friction_bound: float
    slip_traction: float
    slip_direction: float


def certify(problem: StickSlip, solution: StickSlipSolution, slip_scale: float) -> Laws:
    """Measure the laws of a solution.

    Parameters
    ----------
    problem : StickSlip
    solution : StickSlipSolution
    slip_scale : float
        The slip that counts as one.
    """
    q, state = solution.traction, solution.state
    p = problem.pressure + problem.pressure_response @ q
    v = problem.offset + problem.direct @ q + problem.through_pressure @ p
    if problem.creep is not None:
        v = v + problem.creep * solution.creep
    bound = problem.friction * problem.on_faces(p)
    unit = problem.friction * float(np.max(np.abs(p)))
    stuck = state == 0

    def largest(values: np.ndarray) -> float:
        return float(np.max(values, initial=0.0))

    return Laws(
        stick=largest(np.abs(v[stuck])) / slip_scale,
        friction_bound=largest(((np.abs(q) - bound) / unit)[stuck]),
        slip_traction=largest((np.abs(q - state * bound) / unit)[~stuck]),
        slip_direction=largest((-state * v)[~stuck]) / slip_scale,
    )
