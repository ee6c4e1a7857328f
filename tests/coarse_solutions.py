"""Quick solutions of any kind of problem, on coarse meshes."""

from __future__ import annotations

from functools import cache
from typing import Any

import woundon as wo
from woundon import kinds
from woundon.arguments import keywords_of

__all__ = ["coarse_options", "coarse_solution", "solve_coarsely"]

# the loosest tolerances that the solver permits: a winding solves some 60 nips
WINDING = {"rtol": 0.1, "coupling_rtol": 1e-2, "nodes": 25}


def coarse_options(kind: kinds.Kind, nodes: int) -> dict[str, Any]:
    """Return options of a kind's solver that make it quick."""
    options = keywords_of(kind.solver)
    if "coupling_rtol" in options:
        return dict(WINDING)
    return {"nodes": nodes} if "nodes" in options else {}


def solve_coarsely(problem: wo.Problem, nodes: int = 25) -> Any:
    """Solve a problem of any kind, on the given number of nodes if it can be chosen."""
    return wo.solve(problem, **coarse_options(kinds.of(problem), nodes))


def coarse_solution(problem: wo.Problem, nodes: int = 25) -> Any:
    """Return the same solution, computed once per process: results are read-only."""
    return _solved(problem, *coarse_options(kinds.of(problem), nodes).items())


@cache
def _solved(problem: wo.Problem, *options: tuple[str, Any]) -> Any:
    return wo.solve(problem, **dict(options))
