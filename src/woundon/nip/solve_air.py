"""A nip with entrained air, by a fixed-point iteration for the friction coefficients.

    nip without air, friction reduced --> pressure at the inlet edge, K sqrt(s) --> film
          ^                                                                          |
          +------- friction in the nip and on the wrap, by film over roughness <-----+

The film is thin relative to the deformation of the surfaces and does not change the pressure.  K
depends weakly on friction, so that two or three iterations suffice.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import NotConverged
from .entrained_air import AirFilm, air_film

if TYPE_CHECKING:
    from ..problems.nip import NipProblem
    from .result import NipResult

__all__ = ["solve_with_air"]

MAX_ITERATIONS = 30
# Iterations after which the mesh is fixed: a mesh that depends on the friction may alternate.
FREE_ITERATIONS = 5
# Relative change of the friction coefficients, below the accepted residual of 1e-8.
TOLERANCE = 1e-10


def solve_with_air(
    problem: NipProblem,
    solve: Callable[..., NipResult],
    *,
    frictions: tuple[float, float] | None = None,
    tolerance: float = TOLERANCE,
    **options: Any,
) -> tuple[NipResult, AirFilm]:
    """Return the nip with the friction reduced by its air film, and the film.

    Parameters
    ----------
    problem : NipProblem
        With air.
    solve : callable
        (problem without air, **options) -> result.
    frictions : (float, float), optional
        Initial guess, in the nip and on the roll wrap; by default those without air.
    tolerance : float
        Relative change of the friction coefficients in the last iteration.
    options
        Of ``solve``.

    Raises
    ------
    NotConverged
        If the friction coefficients do not converge.
    """
    frictions = frictions or (problem.roll_friction, problem.friction_on_wrap)
    largest_mesh, chooses_nodes = 0, options.get("nodes") is None and options.get("rtol") is None
    for iteration in range(MAX_ITERATIONS):
        if chooses_nodes and iteration >= FREE_ITERATIONS:
            options["nodes"] = largest_mesh
        solved = solve(problem.without_air(*frictions), **options)
        nip = solved.in_nip
        if iteration:
            largest_mesh = max(largest_mesh, solved.nodes)
        film = air_film(problem, solved.x[nip], solved.roll_pressure[nip], solved.half_width)
        reduced = film.roll_friction, film.wrap_friction
        if np.allclose(reduced, frictions, rtol=tolerance, atol=0):
            return solved, film
        frictions = reduced
    raise NotConverged(
        f"air film and friction do not converge in {MAX_ITERATIONS} iterations", None
    )
