"""Cases of every kind, solved for their looks."""

from __future__ import annotations

from functools import cache
from inspect import signature
from typing import Any

import woundon as wo
from woundon import kinds

__all__ = ["coarse", "coarse_anew", "coarse_options"]

# as cheap as the solver lets it be, whatever the nodes: a winding is some 60 nips
WINDING = {"rtol": 0.1, "agreed": 1e-2, "nodes": 25}


def coarse_options(kind: kinds.Kind, nodes: int) -> dict[str, Any]:
    """Return the options of a kind's solver that make it quick."""
    options = signature(kind.solver).parameters
    if "agreed" in options:
        return dict(WINDING)
    return {"nodes": nodes} if "nodes" in options else {}


def coarse_anew(problem: wo.Problem, nodes: int = 25) -> Any:
    """Solve a problem of any kind, on so many nodes where these can be chosen."""
    return wo.solve(problem, **coarse_options(kinds.of(problem), nodes))


def coarse(problem: wo.Problem, nodes: int = 25) -> Any:
    """Return the same, solved once: results are read-only, one serves all tests of a process."""
    return _solved(problem, *coarse_options(kinds.of(problem), nodes).items())


@cache
def _solved(problem: wo.Problem, *options: tuple[str, Any]) -> Any:
    return wo.solve(problem, **dict(options))
