"""A winding nip with air: the nip dry, the film that its inlet lets through, the friction left.

    AirNipProblem --> pressure behind the inlet edge, K sqrt(s) --> film passed   films, inlet
          ^                                                                |
          +---- friction in the nip and behind it, by film over roughness -+   until it stays

The film is thin beside the nip's gap, so that it leaves the pressure as it is; friction hardly
changes K, so that two or three turns are enough.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..arguments import check_type
from ..errors import NotConverged, unwarned
from ..nip.result import WrappedNipResult
from ..nip.solve import check_options, solve_nip
from ..parallel import one_thread
from ..problems.air import AirNipProblem
from ..results import Residuals
from .certificate import OF_THE_NIP, certificate, edge_of, films_of
from .result import AirNipResult

__all__ = ["air_warnings", "check_options", "solve_air_nip", "solved_with_air"]

MOST_TURNS = 30
FREE_TURNS = 5  # after which the mesh stays: one that friction changes may change friction back
SETTLED = 1e-10
LONG = 0.3  # of the half width: up to there the film is known to 2 % (tests/verification/test_air)


@one_thread
def solve_air_nip(
    problem: AirNipProblem,
    *,
    nodes: int | None = None,
    rtol: float | None = None,
) -> AirNipResult:
    """Solve a winding nip with the air that its web brings.

    Parameters
    ----------
    problem : AirNipProblem
    nodes, rtol
        Of :func:`~woundon.solve_nip`.

    Returns
    -------
    AirNipResult

    Raises
    ------
    InvalidProblem
        For options out of range, or an inlet under more than 100 times the ambient pressure.
    NoSteadyState, NotConverged
        As of the nip; if film and friction do not settle.
    """
    check_type("problem", problem, AirNipProblem)
    with unwarned():
        solved, found = solved_with_air(problem, nodes=nodes, rtol=rtol)
    return _result(problem, solved, found)


def solved_with_air(
    problem: AirNipProblem,
    frictions: tuple[float, float] | None = None,
    settled: float = SETTLED,
    **options: Any,
) -> tuple[WrappedNipResult, dict[str, float]]:
    """Return the nip with the friction that its air leaves, and films and frictions by name.

    Parameters
    ----------
    problem : AirNipProblem
    frictions : (float, float), optional
        In the nip and behind it, to begin with; those without air by default.
    settled : float
        To what of them they are to agree.
    options
        Of :func:`~woundon.solve_nip`.

    Raises
    ------
    NotConverged
        If film and friction do not settle.
    """
    frictions = frictions or (problem.roll_friction, problem.friction_behind)
    finest, chooses = 0, options.get("nodes") is None and options.get("rtol") is None
    for turn in range(MOST_TURNS):
        if chooses and turn >= FREE_TURNS:
            options["nodes"] = finest
        solved = solve_nip(problem.without_air(*frictions), **options)
        assert isinstance(solved, WrappedNipResult)
        if turn:
            finest = max(finest, solved.x[solved.in_nip].size)
        found = films_of(problem, edge_of(problem, solved), solved.half_width)
        left = found["roll_friction"], found["wrap_friction"]
        if np.allclose(left, frictions, rtol=settled, atol=0):
            return solved, found
        frictions = left
    raise NotConverged(f"film and friction did not settle in {MOST_TURNS} turns", None)


def _result(
    problem: AirNipProblem, solved: WrappedNipResult, found: dict[str, float]
) -> AirNipResult:
    own = solved.in_nip
    pressure = solved.roll_pressure[own]
    result = AirNipResult(
        problem=problem,
        x=solved.x[own],
        pressure=pressure,
        air_film=pressure,
        edge=edge_of(problem, solved),
        nip_residual=solved.residual,
        solved=solved,
        residuals=Residuals(),
        errors={name: solved.errors[name] for name in OF_THE_NIP if name in solved.errors},
        warnings=(*air_warnings(problem, found, solved.half_width), *solved.warnings),
        **found,
        **{name: getattr(solved, name) for name in OF_THE_NIP},
    )
    film = result.passed / (problem.air.ambient_pressure + pressure)
    result = result.replace(air_film=film)
    residuals = certificate(result, solved, same_mesh=True)
    return result.replace(residuals=residuals).checked().warned()


def air_warnings(
    problem: AirNipProblem, found: dict[str, float], half_width: float
) -> tuple[str, ...]:
    """Return what is to be said of a nip's air: what was found of it, by name; a [m]."""
    told: list[str] = []
    if found["inlet_length"] > LONG * half_width:
        told.append(
            f"the inlet in which the film is made, {found['inlet_length'] * 1e3:.3g} mm, is "
            f"{found['inlet_length'] / half_width:.2g} of the half-width, which is taken as much "
            "longer: the film bends the nip's pressure"
        )
    air = problem.air
    if found["film_in_nip"] >= air.no_friction * air.roughness:
        told.append(
            f"the film in the nip, {found['film_in_nip'] * 1e6:.3g} um, is thicker than "
            f"{air.no_friction:.3g} roughnesses: web and roll do not touch, and the nip adds "
            "no tension"
        )
    return tuple(told)
