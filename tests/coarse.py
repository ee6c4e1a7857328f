"""Cases of every kind, solved for their looks."""

from __future__ import annotations

from inspect import signature
from typing import Any

import woundon as wo
from woundon import kinds

__all__ = ["coarse"]


def coarse(problem: wo.Problem, nodes: int = 25) -> Any:
    """Solve a problem of any kind, on so many nodes where these can be chosen."""
    options = signature(kinds.of(problem).solver).parameters
    return wo.solve(problem, **({"nodes": nodes} if "nodes" in options else {}))
