"""Solve the wrapped form of a nip."""

from __future__ import annotations

from math import pi
from typing import Any

import woundon as wo

__all__ = ["solve_wrapped"]


def solve_wrapped(problem: Any, nodes: int | None = None, **wraps: Any) -> wo.NipResult:
    """Return the result of a nip with wraps; a plain nip gets half a turn on the roll."""
    if wraps or isinstance(problem, wo.NipProblem):
        problem = problem.replace(roll_wrap=pi, **wraps)
    result: wo.NipResult = wo.solve(problem, nodes=nodes)
    return result
