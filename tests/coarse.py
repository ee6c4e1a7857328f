"""Cases of every kind, solved for their looks."""

from __future__ import annotations

from functools import cache
from inspect import signature
from typing import Any

import woundon as wo
from woundon import kinds

__all__ = ["coarse", "coarse_anew", "coarse_options"]

# as cheap as a kind's solver lets it be; a winding is 60 nips
CHEAP = {"rtol": 0.05, "agreed": 1e-3}
LEAST_NODES = 25  # of a winding's nips


def coarse_options(kind: kinds.Kind, nodes: int) -> dict[str, Any]:
    """Return the options of a kind's solver that make it quick."""
    options = signature(kind.solver).parameters
    if "agreed" in options:
        return CHEAP | {"nodes": max(nodes, LEAST_NODES)}
    return {"nodes": nodes} if "nodes" in options else {}


def coarse_anew(problem: wo.Problem, nodes: int = 25) -> Any:
    """Solve a problem of any kind, on so many nodes where these can be chosen."""
    return wo.solve(problem, **coarse_options(kinds.of(problem), nodes))


coarse = cache(coarse_anew)  # results are read-only: one serves all tests of a process
