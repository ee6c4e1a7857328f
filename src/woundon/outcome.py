"""From solved equations to a result: the quantities people ask for, and the certificate."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from .assembly import NipEquations, NipState, contact_radius
from .contact.certificate import certify
from .elasticity.strip import compliance
from .errors import NotConverged
from .problems import NipProblem
from .results import NipResult, Residuals, SlipRatios
from .validity import nip_warnings

__all__ = ["check_certificate", "nip_result", "slip_ratios"]

Array = np.ndarray
ACCEPTED_RESIDUAL = 1e-8


class Certified(Protocol):
    """Any result that carries residuals."""

    @property
    def residuals(self) -> Residuals: ...


def check_certificate(result: Certified) -> None:
    """Refuse a result that breaks a law, so that nothing unsolved is passed off as solved.

    Raises
    ------
    NotConverged
        Naming every law not satisfied to 1e-8; carries the result.
    """
    broken = [f"{k} {v:.2g}" for k, v in result.residuals.items() if not v <= ACCEPTED_RESIDUAL]
    if broken:
        raise NotConverged(f"laws are not satisfied to 1e-8: {', '.join(broken)}", result)


def nip_result(
    equations: NipEquations,
    state: NipState,
    scheme: str,
    algorithm: str,
    tension: float,
    error: float,
) -> NipResult:
    """Return the result of a solved nip.

    Parameters
    ----------
    equations, state : NipEquations, NipState
    scheme, algorithm : str
    tension, error : float
        NIT and its estimated error [N/m].
    """
    problem, a, n = equations.problem, state.half_width, equations.disc.unknowns
    T_in = problem.web_tension
    x = a * equations.disc.grid.nodes
    q_roll, q_drum = padded(state.roll_traction), padded(state.drum_traction)
    total = q_roll + q_drum
    web_tension = T_in + np.concatenate(
        [[0.0], np.cumsum(np.diff(x) * (total[1:] + total[:-1]) / 2)]
    )
    slips, zones = state.solution.slip, state.solution.state
    last = equations.last_slips(state)
    pressure = padded(state.pressure)
    surfaces = [body.surface(2 * a) for body in (problem.roll, problem.drum)]
    result = NipResult(
        problem=problem,
        nip_induced_tension=tension,
        nip_induced_tension_error=error,
        half_width=a,
        approach=_approach(equations, state),
        offset=state.shift * contact_radius(problem),
        drum_creep=_drum_creep(equations, state),
        x=x,
        slip_x=a * np.append(equations.disc.middle[:1], equations.disc.middle),
        pressure=pressure,
        roll_traction=q_roll,
        drum_traction=q_drum,
        roll_slip=np.concatenate([slips[:1], slips[:n], [last[0]]]),
        drum_slip=np.concatenate([slips[n : n + 1], slips[n:], [last[1]]]),
        roll_zone=np.concatenate([zones[:1], zones[:n], zones[n - 1 : n]]),
        drum_zone=np.concatenate([zones[n : n + 1], zones[n:], zones[-1:]]),
        web_tension=web_tension,
        slip_ratios=slip_ratios(x, zones[:n], zones[n:]),
        residuals=_residuals(equations, state),
        scheme=scheme,
        algorithm=algorithm,
        iterations=state.solution.solves,
        series_terms=max(s.terms for s in surfaces),
        series_error=max(s.truncation_error for s in surfaces),
    )
    return result.with_warnings(nip_warnings(result))


def padded(values: Array) -> Array:
    """Return nodal values with the zeros of both ends."""
    return np.concatenate([[0.0], values, [0.0]])


def _whole(equations: NipEquations, state: NipState) -> float:
    """Return the integral of q+ + q-, the NIT of this grid [N/m]."""
    return float(equations.matrices.weights @ (state.roll_traction + state.drum_traction))


def _drum_creep(equations: NipEquations, state: NipState) -> float:
    """Return xi- (thesis eq. 93): the solved rigid slip holds the web's strain behind the nip."""
    problem: NipProblem = equations.problem
    T_out = problem.web_tension + _whole(equations, state)
    c11 = compliance(*problem.web.material.stiffness[:3]).c11
    return state.solution.creep - c11 / problem.web.thickness * T_out


def _approach(equations: NipEquations, state: NipState) -> float:
    """Return the mutual approach -delta > 0, from the indentation (82) at the trailing edge [m]."""
    problem, a = equations.problem, state.half_width
    put, edge = equations.disc.grid.integrate, slice(-1, None)
    v = compliance(*problem.web.material.stiffness[:3]).c12 * (
        problem.web_tension + _whole(equations, state)
    )
    for body, q in ((problem.roll, state.roll_traction), (problem.drum, state.drum_traction)):
        kernels = body.surface(2 * a)
        if kernels.deforms:
            rank = equations.disc.rank(kernels.length, a)
            v += float((put(kernels.normal_p, a, edge, rank) @ state.pressure)[0])
            v += float((put(kernels.normal_q, a, edge, rank) @ q)[0])
    return -(v + state.shift * a - a**2 / (2 * contact_radius(problem)))


def slip_ratios(x: Array, roll: Array, drum: Array) -> SlipRatios:
    """Measure slip lengths, zone borders half-way between nodes (thesis eq. 172)."""
    border = (x[1:] + x[:-1]) / 2
    border[0], border[-1] = x[0], x[-1]
    width = x[-1] - x[0]

    def run(zones: Array) -> int:
        """Count the nodes from the start on that slip the same way."""
        other = np.nonzero(zones != zones[0])[0]
        return 0 if zones[0] == 0 else int(other[0]) if other.size else zones.size

    def trailing(count: int) -> float:
        return float(border[-1] - border[border.size - 1 - count]) / width

    leading = float(border[run(roll)] - border[0]) / width
    both = min(run(roll[::-1]), run(drum[::-1]))
    return SlipRatios(
        leading_roll=int(roll[0]) * leading,
        trailing_roll=int(roll[-1]) * trailing(run(roll[::-1])),
        dual=int(roll[-1]) * trailing(both) if roll[-1] == drum[-1] else 0.0,
    )


def _residuals(equations: NipEquations, state: NipState) -> Residuals:
    """Measure every law anew from the assembled equations."""
    problem, p, q = equations.problem, state.pressure, state.solution.traction
    w, top = equations.matrices.weights, float(np.max(equations.matrices.gap))
    indentation = (
        equations.matrices.slope_p @ p
        + equations.matrices.slope_q @ q
        + state.shift
        - equations.matrices.gap
    )
    laws = certify(equations.stick_slip(), state.solution, slip_scale=top)
    x = state.half_width * equations.disc.grid.nodes
    whole = float(np.trapezoid(padded(state.roll_traction + state.drum_traction), x))
    force = float(w @ state.drum_traction) - problem.winding_force
    return Residuals(
        indentation=float(np.max(np.abs(indentation))) / top,
        positive_pressure=max(0.0, -float(np.min(p)) / float(np.max(np.abs(p)))),
        stick=laws.stick,
        friction_bound=laws.friction_bound,
        slip_traction=laws.slip_traction,
        slip_direction=laws.slip_direction,
        load_equilibrium=abs(float(w @ p) / problem.nip_load - 1),
        force_equilibrium=abs(force) / problem.nip_load,
        web_equilibrium=abs(_whole(equations, state) - whole) / problem.nip_load,
    )
