"""Solve a nip with wraps."""

from __future__ import annotations

from math import pi
from typing import Any

import woundon as wo

__all__ = ["solve_wrapped"]


def solve_wrapped(problem: Any, nodes: int | None = None, **wraps: Any) -> wo.NipResult:
    """Return the result of a nip with these wraps, by default half a turn on the roll."""
    result: wo.NipResult = wo.solve(problem.replace(**{"roll_wrap": pi} | wraps), nodes=nodes)
    return result
