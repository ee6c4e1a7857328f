"""The films of a nip with air, and the certificate: both from numbers that its result holds."""

from __future__ import annotations

from math import exp, log
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import InvalidProblem
from ..results import Residuals, largest
from .films import escaped_film, foil_film, friction_share, nip_film

if TYPE_CHECKING:
    from collections.abc import Callable

    from ..nip.result import WrappedNipResult
    from ..problems.air import Air, AirNipProblem
    from .result import AirNipResult

__all__ = ["OF_THE_NIP", "certificate", "edge_of", "films_of", "friction_between"]

OF_THE_NIP = "wound_on_tension", "nip_induced_tension", "half_width", "peak_pressure"

LEAST = 1e-6  # a nip without any friction is not solved, nor an inlet without any pressure
LENGTHS = 1e-12, 1e3  # between which an inlet's is sought [m]
FIRST, FARTHEST = 3, 0.5  # node, and share of the half width, between which K is taken: the first
# two nodes of Hertz's pressure are 9 and 1 % off


def edge_of(problem: AirNipProblem, solved: WrappedNipResult) -> float:
    """Return K [Pa/sqrt(m)] of a nip, as its inlet meets it.

    The pressure between web and roll, as solved without air, is K sqrt(s) at the inlet's length s
    behind the edge.  Nearer it may rise otherwise, as a viscoelastic drum or a web that is taut on
    the drum have it, but there the film does not follow it.
    """
    own, a = solved.in_nip, solved.half_width
    s, p = solved.x[own][FIRST:] + a, solved.roll_pressure[own][FIRST:]
    rise = np.maximum(p, LEAST * p.max()) / np.sqrt(s)

    def at(length: float) -> float:
        return float(np.interp(min(length, FARTHEST * a), s, rise))

    return at(_inlet_length(problem, at))


def _inlet_length(problem: AirNipProblem, edge: Callable[[float], float]) -> float:
    """Return the length of the inlet whose K is ``edge`` of that length [m]; 0 at rest."""
    if problem.web_speed == 0:
        return 0.0
    from scipy.optimize import brentq

    drag = 12 * problem.air.viscosity * problem.web_speed

    def longer(x: float) -> float:
        length = exp(x)
        return x - 0.4 * log(drag / (problem.compliance_over(length) ** 2 * edge(length) ** 3))

    low, high = map(log, LENGTHS)
    return exp(float(brentq(longer, low, high, xtol=1e-14, rtol=1e-14)))


def friction_between(film: float, pressure: Any, air: Air) -> Any:
    """Return which share of their friction laps have under a pressure [1], an array of its shape.

    The film that they hold, ``film`` at ambient pressure [m], is pressed together: none leaves.
    """
    pressed = film * air.ambient_pressure / (air.ambient_pressure + np.asarray(pressure))
    return friction_share(pressed, air.roughness, air.full_friction, air.no_friction)


def films_of(problem: AirNipProblem, edge: float, half_width: float) -> dict[str, float]:
    """Return films and frictions by the names that a result has them under."""
    air, V, R = problem.air, problem.web_speed, problem.roll.radius
    mu, p_a, T = air.viscosity, air.ambient_pressure, problem.web_tension
    compliance = problem.compliance_over(_inlet_length(problem, lambda _: edge))
    try:
        passing = nip_film(edge, compliance, V, mu, p_a)
    except ValueError as stop:
        text = f"of {V:.6g} m/s is out of range: where the nip catches the air, {stop}"
        raise InvalidProblem.at("web_speed", text) from None
    behind = passing.film * p_a / (p_a + T / R)
    # without tension nothing but the nip limits the film
    foil = float(foil_film(R, V, T, mu)) if T > 0 else behind
    laid = min(behind, foil)
    in_nip = passing.film * p_a / (p_a + problem.nip_load / (2 * half_width))

    def left(friction: float, film: float) -> float:
        share = friction_share(film, air.roughness, air.full_friction, air.no_friction)
        return float(max(friction * share, min(LEAST, friction)))

    return {
        "foil_film": foil, "nip_film": behind, "film_in_nip": in_nip,
        "inlet_length": passing.length,
        "film": float(escaped_film(laid, air.permeance, T, V)),
        "roll_friction": left(problem.roll_friction, in_nip),
        "wrap_friction": left(problem.friction_behind, laid),
    }  # fmt: skip


def certificate(result: AirNipResult, solved: WrappedNipResult, *, same_mesh: bool) -> Residuals:
    """Measure every law of a result.

    Parameters
    ----------
    result : AirNipResult
    solved : WrappedNipResult
        The nip with the frictions held.
    same_mesh : bool
        Whether the outputs are those on this mesh.  On another one with as many nodes they may
        differ by three times the estimated errors.

    film
        That films and frictions are those of the edge's rise and the half-width held.
    film_over_nip
        That the film in the nip is what passes, under the pressure held.
    nip
        The nip's own certificate, as it was solved with these frictions; that its outputs are the
        ones held, tensions relative to the nip load, and that the nodes go from edge to edge.
    """
    found = films_of(result.problem, result.edge, result.half_width)
    off = [abs(getattr(result, name) - value) / max(value, 1e-300)
           for name, value in found.items() if value or getattr(result, name)]  # fmt: skip
    profile = result.passed / (result.problem.air.ambient_pressure + result.pressure)
    missed = np.abs(result.air_film - profile)
    return Residuals(
        film=largest(off),
        film_over_nip=float(np.max(missed)) / max(result.film_in_nip, 1e-300),
        nip=largest(
            [
                result.nip_residual if result.nip_residual >= 0 else np.inf,
                *(_missed(result, solved, name, same_mesh) for name in OF_THE_NIP),
                largest(np.abs(result.x[[0, -1]] / result.half_width - [-1.0, 1.0])),
                0.0 if (np.diff(result.x) > 0).all() else np.inf,
            ]
        ),
    )


def _missed(result: AirNipResult, solved: WrappedNipResult, name: str, same_mesh: bool) -> float:
    """Return by how much an output differs from that of the nip, relative."""
    value, due = getattr(result, name), getattr(solved, name)
    unit = result.problem.nip_load if name.endswith("tension") else due
    known = 0.0 if same_mesh else 3 * result.errors.get(name, 0.0) + 1e-6 * abs(due)
    return float(np.maximum(abs(value - due) - known, 0.0) / unit)
