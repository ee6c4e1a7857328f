"""Solve a winding nip on a sequence of meshes.

The equations of :mod:`.equations` are solved on refined meshes until the error estimates e of the
wound-on tension WOT and of the nip-induced tension NIT satisfy

    e(WOT) <= rtol max(|WOT|, T_0),    e(NIT) <= 20 rtol max(|NIT|, T_0),    T_0 = 0.01 mu+ P.

The result of the last mesh is returned with its certificate, if all conditions are satisfied.  A
nip with entrained air is solved with the friction coefficients that its air film leaves.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from math import nan, pi
from typing import Annotated, Any

import numpy as np

from ..arguments import Option, check_type, nodes_or_rtol, tolerance, whole_number
from ..contact.newton import NewtonFailed
from ..contact.refinement import (
    FIRST_SIZES,
    REPORTED,
    MeshSolution,
    Refinement,
    Tolerances,
    refine,
    richardson_estimates,
)
from ..errors import RESOLUTION, InvalidProblem, NoSteadyState, NotConverged
from ..parallel import one_thread
from ..problems.bodies import half_width_guess
from ..problems.nip import NipProblem
from ..results import ACCEPTED_RESIDUAL, Residuals, measured
from ..validity import far_outside
from .certificate import certificate, inconsistencies
from .entrained_air import AirFilm, air_film, air_warnings
from .equations import NipEquations, NipState
from .load_limit import bending_text, check_load
from .outputs import SLIP_RATIOS, NipSystem, error_estimates
from .result import NipResult
from .several_nips import SeveralNips, SeveralState, system_of
from .single_nips import check_nips, single_nips
from .validity import nip_warnings, web_far_outside

__all__ = ["check_options", "solve_nip", "solve_with_film"]

# Scalar outputs that are fields of a result.
SCALARS = (
    *("roll_wound_on_tension", "half_width", "approach", "offset", "drum_creepage"),
    *SLIP_RATIOS,
)
# Default criterion: relative error of the wound-on tension, and the nip-induced tension's error
# relative to it; the largest mesh of the default and of an explicit tolerance.
RTOL, TENSION_RATIO = 1e-3, 20.0
MOST_NODES, MOST_NODES_RTOL = 257, 1025
# A nonlinear body costs seconds on a fine mesh.
RTOL_NONLINEAR, MOST_NODES_NONLINEAR = 3e-3, 129
LEAST_RTOL = 1e-5
NODES_OPTION = Option(
    "Number of nodes on the last mesh.",
    "13 to 1025. By default the mesh is refined until the estimated error of the wound-on tension "
    "is below 0.1 % of it, and that of the nip-induced tension below 2 %.",
)
RTOL_OPTION = Option(
    "Relative error of the solver.",
    "1e-5 to 0.1, of the wound-on tension; 20 times as much of the nip-induced tension.",
)
# Slackness relative to the largest tension that no refinement of a coarse mesh removes: tensions on
# 13 nodes are accurate to a few percent.
CERTAINLY_SLACK = 0.2
# The nip-induced tension is compared with at least this share of the roll's friction limit: it may
# be zero.
LEAST_TENSION = 0.01
# Length of the roll wrap from the line of centres, in half widths, from which on the initial guess
# is good enough.
LONG_WRAP = 4.0
# Shortest roll wrap that is solved, from the trailing edge, in half widths: the hoop pressure on a
# shorter one changes within less than its length T C (docs/theory/wraps.md).
SHORTEST_WRAP = 0.02
# Iterations for the friction that an air film leaves, those after which the mesh is fixed, because
# a mesh that depends on the friction may alternate, and the relative change of the last one, below
# the accepted residual of 1e-8.
MAX_FILM_ITERATIONS, FREE_ITERATIONS, FRICTION_TOLERANCE = 30, 5, 1e-10


@one_thread
def solve_nip(
    problem: NipProblem,
    *,
    nodes: Annotated[int | None, NODES_OPTION] = None,
    rtol: Annotated[float | None, RTOL_OPTION] = None,
    start: NipResult | None = None,
    errors: bool = True,
    progress: Callable[[float], None] | None = None,
) -> NipResult:
    """Solve a winding nip: stick and slip zones, tractions and the wound-on tension.

    Parameters
    ----------
    problem : NipProblem
    nodes : int, optional
        Nodes of the nip on the last mesh, 13 to 1025.  By default as many as it takes until the
        estimated error of the wound-on tension is below 0.1 % of it (0.3 % with nonlinear bodies),
        and that of the nip-induced tension below 20 times as much of itself, at most 257 (129).
    rtol : float, optional
        Relative error of the wound-on tension in place of the default, 1e-5 to 0.1; up to 1025
        nodes.
    start : NipResult, optional
        A solved neighbouring case, which replaces the initial guess on every mesh; one with another
        number of nips is not used.  The result does not depend on it beyond the tolerance of the
        solver.
    errors : bool
        False omits the error estimates if there is a ``start``, and ``nodes`` is given: only the
        last mesh is solved, which takes less than half the time.
    progress : callable, optional
        Called with the fraction of the work that is done.

    Raises
    ------
    InvalidProblem
        For options out of range, loads that no contact of the bodies carries, a body so soft that
        the web lifts off it on a wrap, and an air film under more than 100 times the ambient
        pressure.
    NoSteadyState
        If the web would be slack on a wrap.
    NotConverged
        If a contact condition is not satisfied to 1e-8, ``rtol`` is not reached, or the air film
        does not converge; it carries the best result.
    """
    check_type("problem", problem, NipProblem)
    check_options(nodes=nodes, rtol=rtol, errors=errors)
    if start is not None:
        check_type("start", start, NipResult)
    solve = _solve if problem.air is None else solve_with_film
    options: dict[str, Any] = {"nodes": nodes, "rtol": rtol, "errors": errors, "progress": progress}
    return solve(problem, start=start, **options).warned()


def solve_with_film(
    problem: NipProblem,
    *,
    frictions: tuple[float, float] | None = None,
    tolerance: float = FRICTION_TOLERANCE,
    **options: Any,
) -> NipResult:
    """Solve a nip with entrained air, and return its result without issuing the warnings.

    The friction coefficients f that the air film leaves are found by a fixed-point iteration:

        nip without air, friction f --> pressure at the inlet edge, K sqrt(s) --> film
                  ^                                                                 |
                  +------- f in the nip and on the wrap, by film over roughness <---+

    The film is thin relative to the deformation of the surfaces and does not change the pressure.
    K depends weakly on friction, so that two or three iterations suffice.

    Parameters
    ----------
    problem : NipProblem
        With air.
    frictions : (float, float), optional
        Initial guess, in the nip and on the roll wrap; by default those without air.
    tolerance : float
        Relative change of the friction coefficients in the last iteration.
    options
        Of :func:`solve_nip`.

    Raises
    ------
    NotConverged
        If the friction coefficients do not converge.
    """
    frictions = frictions or (problem.roll_friction, problem.friction_on_wrap)
    largest_mesh, chooses_nodes = 0, options.get("nodes") is None and options.get("rtol") is None
    for iteration in range(MAX_FILM_ITERATIONS):
        # the friction converges on one mesh only: from some iteration on it is not chosen again
        if chooses_nodes and iteration >= FREE_ITERATIONS:
            options["nodes"] = largest_mesh
        solved = _solve(problem.without_air(*frictions), **options)
        nip = solved.in_nip
        if iteration:  # the first friction is a guess, which may need another mesh
            largest_mesh = max(largest_mesh, solved.nodes)
        film = air_film(problem, solved.x[nip], solved.roll_pressure[nip], solved.half_width)
        reduced = film.roll_friction, film.wrap_friction
        if np.allclose(reduced, frictions, rtol=tolerance, atol=0):
            assert solved.refinement is not None  # only of a loaded result
            result = result_of(problem, solved.refinement, film).checked()
            dry_warnings = [text for text in solved.warnings if text not in result.warnings]
            return result.replace(warnings=(*result.warnings, *dry_warnings))
        frictions = reduced
    text = f"air film and friction do not converge in {MAX_FILM_ITERATIONS} iterations"
    raise NotConverged(text, None)


def _solve(problem: NipProblem, *, start: NipResult | None = None, **options: Any) -> NipResult:
    """Solve a nip without air; options as of :func:`solve_nip`."""
    check_load(problem, "nip_load")
    _check_force(problem)
    if problem.next_nips:
        check_nips(problem)
    else:
        start = _longer_wrap(problem) or start
    if start is not None and len(start.problem.next_nips) != len(problem.next_nips):
        start = None  # it has other unknowns
    return _refined(problem, start=start, **options)


def _refined(
    problem: NipProblem,
    *,
    nodes: int | None = None,
    rtol: float | None = None,
    start: NipResult | None = None,
    **options: Any,
) -> NipResult:
    """Solve on a sequence of meshes until the error estimates meet their tolerance."""
    default = RTOL if problem.linear else RTOL_NONLINEAR
    max_nodes = MOST_NODES if problem.linear else MOST_NODES_NONLINEAR
    tolerances = _tolerances(problem, rtol or default)
    known = start.refinement if start else None
    solved: list[MeshSolution] = []

    def check(mesh: MeshSolution) -> None:
        """Keep the solution on a mesh, and reject a web that is certainly slack there."""
        solved.append(mesh)
        _check_taut(problem, mesh, CERTAINLY_SLACK)

    try:
        refinement = refine(
            lambda size: system_of(problem, size),
            nodes=nodes,
            tolerances=tolerances,
            most_nodes=MOST_NODES_RTOL if rtol else max_nodes,
            rtol=rtol or default,
            start=known,
            # of the same problem only the coarse meshes are solved
            last=known.last if known and start and start.problem == problem else None,
            check=check,
            **options,
        )
    except NewtonFailed as failed:
        _check_slack_beyond_errors(problem, solved)
        neighbour = None
        if problem.drum_wrap and start is None:
            # continuation: the web on the drum is added to the solution without it
            with suppress(NotConverged, NoSteadyState):
                neighbour = _refined(problem.replace(drum_wrap=0.0), nodes=FIRST_SIZES[-1])
        if neighbour is not None:
            return _refined(problem, nodes=nodes, rtol=rtol, start=neighbour, **options)
        reason = _outside_model(problem)
        raise NotConverged("; ".join(filter(None, (f"no solution: {failed}", reason)))) from None
    _check_taut(problem, refinement.last)
    _check_pressed(problem, refinement.last)
    result = result_of(problem, refinement).checked()
    ratio = 0.0 if nodes else max(refinement.ratios(tolerances).values())
    if rtol is not None and ratio > 1:
        text = f"rtol = {rtol:g} is not reached with {result.nodes} nodes"
        raise NotConverged(f"{text}: the estimated error is {ratio:.2g} times as large", result)
    if ratio > 1:
        text = f"{RESOLUTION}the error estimate is {ratio:.2g} times the default tolerance"
        result = result.replace(warnings=(*result.warnings, text))
    return result


def _longer_wrap(problem: NipProblem) -> NipResult | None:
    """Return a coarse solution as the initial guess for a roll wrap that ends next to the nip.

    The wrap is shortened from LONG_WRAP half widths, half the distance to the trailing edge at a
    time (continuation).  None for a longer wrap, or without one.

    Raises
    ------
    InvalidProblem
        If the wrap ends in the nip, with the smallest value permitted.
    """
    theta, R = problem.roll_wrap, problem.roll.radius
    if not 0 < theta < 1:
        return None
    guess = NipSystem(problem.replace(roll_wrap=pi), FIRST_SIZES[0]).initial_half_width()
    wrap, start = min(LONG_WRAP * guess / R, pi), None
    while wrap > theta:
        start = _refined(problem.replace(roll_wrap=wrap), nodes=FIRST_SIZES[-1], start=start)
        edge = start.half_width / R
        smallest = (1 + SHORTEST_WRAP) * edge
        if wrap <= (1 + SHORTEST_WRAP / 10) * smallest:  # still longer than theta, which is inside
            text = f"{theta:.6g} is out of range; must be 0 or >= {1.001 * wrap:.4g} [rad]"
            raise InvalidProblem.at(
                "roll_wrap",
                f"{text}, downstream of the trailing edge of the nip, which lies {edge:.4g} [rad] "
                "from the line of centres",
            )
        wrap = max(theta, smallest, (wrap + edge) / 2)
    return start


def check_options(*, nodes: object = None, rtol: object = None, errors: object = True) -> None:
    """Check the options of :func:`solve_nip`.

    Raises
    ------
    InvalidProblem
        For an option out of range.
    """
    if nodes is not None:
        whole_number("nodes", nodes, 13, MOST_NODES_RTOL)
    if rtol is not None:
        tolerance("rtol", rtol, LEAST_RTOL, 0.1)
    nodes_or_rtol(nodes, rtol)
    check_type("errors", errors, bool)


def _tolerances(problem: NipProblem, rtol: float) -> Tolerances:
    """Return the function that returns the permitted errors [N/m] of both tensions."""
    floor = LEAST_TENSION * problem.roll_friction * problem.nip_load
    relative = {"wound_on_tension": rtol, "nip_induced_tension": TENSION_RATIO * rtol}

    def tolerances(outputs: Mapping[str, float]) -> dict[str, float]:
        """Return the permitted errors of given outputs."""
        return {name: r * max(abs(outputs[name]), floor) for name, r in relative.items()}

    return tolerances


def _outside_model(problem: NipProblem) -> str:
    """Return a text on what is far outside the model, or at its limit, in an unsolved case."""
    texts: list[str] = []
    alone = single_nips(problem).problems if problem.next_nips else (problem,)
    for k, each in enumerate(alone, 1):
        load = each.nip_load
        width = 2 * half_width_guess(load, *each.bodies)
        of_nip = (
            *web_far_outside(each, width),
            *far_outside(each, load),
            bending_text(each, load),
        )
        prefix = f"nip {k}: " if k > 1 else ""
        texts += [f"{prefix}{text}" for text in of_nip if text and text not in texts]
    return "; ".join(texts)


def _check_force(problem: NipProblem) -> None:
    """Raise an error if the winding force leaves the web slack on the roll wrap in any case.

    At the trailing edge T = T_in + F + int_nip q+ dx, and q+ <= mu+ p+.  The resultant of p+ is P,
    and at most |F| larger if the tension inside the nip is negative.
    """
    T_in, F, P = problem.web_tension, problem.winding_force, problem.nip_load
    largest_tension = T_in + F + problem.roll_friction * (P + abs(F))
    if problem.roll_wrap > 0 and largest_tension < problem.centrifugal_tension:
        raise _slack(problem, "downstream", largest_tension)


def _check_taut(problem: NipProblem, mesh: MeshSolution, permitted: float = 0.0) -> None:
    """Raise an error if the web is slack on a wrap, where its tension must press it on the body.

    Parameters
    ----------
    problem : NipProblem
    mesh : MeshSolution
    permitted : float
        Slackness that counts as an error of a coarse mesh, relative to the largest tension.
    """
    force = problem.centrifugal_tension
    for name, least, largest in _tensions_on_wraps(problem, mesh):
        if least - force <= -permitted * largest:
            raise _slack(problem, name, least)


def _check_slack_beyond_errors(problem: NipProblem, solved: Sequence[MeshSolution]) -> None:
    """Raise an error if the web is slack by more than the estimated errors on coarse meshes.

    Of a problem without a solution on a finer mesh: the hoop pressure T kappa of a slack web pulls
    at the roll, so that the equations are ill-posed on meshes that resolve it, and the friction
    law has no bound (docs/theory/wraps.md).

    Parameters
    ----------
    problem : NipProblem
    solved : sequence of MeshSolution
        Of all attempts, in their order; an attempt begins with a coarser mesh than the last one.
    """
    ascending: list[MeshSolution] = []
    for mesh in solved:
        if not ascending or mesh.size > ascending[-1].size:
            ascending.append(mesh)
    if not ascending:
        return
    tensions = [[least for _, least, _ in _tensions_on_wraps(problem, mesh)] for mesh in ascending]
    errors = richardson_estimates([mesh.size for mesh in ascending], tensions)  # nan of two meshes
    on_last = _tensions_on_wraps(problem, ascending[-1])
    for (name, least, _), error in zip(on_last, errors, strict=True):
        if least - problem.centrifugal_tension < -error:
            raise _slack(problem, name, least)


def _tensions_on_wraps(problem: NipProblem, mesh: MeshSolution) -> list[tuple[str, float, float]]:
    """Return the least tension on each wrap, and the largest one of its nip [N/m].

    With the place of the wrap, "upstream" or "downstream" of the nip.
    """
    nips: Sequence[NipEquations] = mesh.system.nips
    found = []
    for nip, state in zip(nips, mesh.state.nips, strict=True):
        layout, T = nip.layout, state.fields.tension
        largest = float(np.abs(T).max())
        if problem.roll_wrap > 0:
            found.append(("downstream", float(T[layout.roll_wrap_nodes].min()), largest))
        if nip.drum_wrap > 0:
            found.append(("upstream", float(T[layout.drum_wrap_nodes].min()), largest))
    return found


def _slack(problem: NipProblem, name: str, tension: float) -> NoSteadyState:
    """Return the error for a web that is slack upstream or downstream of the nip."""
    T_in, force = problem.web_tension, problem.centrifugal_tension
    below = f", below its centrifugal force of {force:.4g} [N/m]" if force else " [N/m]"
    return NoSteadyState.at(
        "web_tension",
        f"{T_in:.6g} leaves the web slack {name} of the nip: its tension falls to {tension:.4g}"
        f"{below}; about {T_in - tension + force:.4g} or more is needed",
    )


def _check_pressed(problem: NipProblem, mesh: MeshSolution) -> None:
    """Raise where a body is deformed so that it is concave on its wrap: the web lifts off it."""
    nips: Sequence[NipEquations] = mesh.system.nips
    faces = []
    for nip, state in zip(nips, mesh.state.nips, strict=True):
        layout, f = nip.layout, state.fields
        faces.append(("roll", f.p_roll[layout.roll_wrap_nodes], problem.roll_wrap > 0, f))
        faces.append(("drum", f.p_drum[layout.drum_wrap_nodes], nip.drum_wrap > 0, f))
    for name, pressure, wrapped, f in faces:
        min_pressure = float(pressure.min())
        if wrapped and min_pressure < -ACCEPTED_RESIDUAL * f.p_drum.max():
            raise InvalidProblem.at(
                name,
                f"its deformed surface is concave on the wrap next to the nip: a web that followed "
                f"it would need a pressure of {min_pressure:.3g} [Pa], so that it lifts off; use a "
                "smaller nip_load, or a thicker or stiffer elastic layer",
            )


def result_of(
    problem: NipProblem, refinement: Refinement, film: AirFilm | None = None
) -> NipResult:
    """Return the result of the last mesh with its certificate, errors and warnings."""
    equations, state, active = refinement.last.system, refinement.last.state, refinement.last.active
    arrays, outputs = equations.arrays(state, active), refinement.last.outputs
    bodies = problem.named_bodies.values()
    kernels = [body.kernels() for body in bodies if hasattr(body, "kernels")]
    values: dict[str, Any] = {name: outputs[name] for name in SCALARS} | arrays
    result = NipResult(
        problem=problem,
        residuals=Residuals(),
        air=film,
        **values,
        iterations=refinement.iterations,
        series_terms=max((k.terms for k in kernels), default=0),
        series_error=max((k.truncation_error for k in kernels), default=0.0),
        rolling_resistance=outputs.get("rolling_resistance", nan),
        refinement=refinement,
    )
    film_warnings = air_warnings(problem, film, result.half_width) if film else ()
    return measured(
        result,
        errors=error_estimates(refinement, arrays),
        residuals=certificate(result, equations),
        warnings=(
            *film_warnings,
            *_warnings_of_all_nips(result, equations, state, active),
            *inconsistencies(refinement.meshes[-REPORTED - 1 :]),
        ),
    )


def _warnings_of_all_nips(
    result: NipResult,
    system: NipSystem | SeveralNips,
    state: NipState | SeveralState,
    active: np.ndarray,
) -> list[str]:
    """Return the warnings of the first nip, and those that further nips have in addition.

    ``active`` are the zones of the traction nodes of all nips, (k,).
    """
    texts = list(nip_warnings(result))
    if isinstance(system, NipSystem):
        return texts
    parts = list(zip(system.nips, state.nips, system.tractions, strict=True))
    for k, (nip, own, nodes) in enumerate(parts[1:], 2):
        outputs = nip.outputs(own, active[nodes])
        values: dict[str, Any] = {name: outputs[name] for name in SCALARS}
        values |= nip.arrays(own, active[nodes])
        single = NipResult(problem=nip.problem, residuals=Residuals(), **values)
        texts += [f"nip {k}: {text}" for text in nip_warnings(single) if text not in texts]
    return texts
