r"""Two rollers without a web, rolling or static, by the loop of every contact here.

The traction leaves a zone border like the root of the distance, so the meshes are graded there:
each is fitted to the borders that the one before found.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import nan
from typing import Any

import numpy as np

from ..arguments import check_type, tolerance, whole_number
from ..contact.loop import Ladder, Level, Tolerance
from ..contact.normal import solve_normal
from ..contact.response import on_columns, padded
from ..contact.schemes import Graded, Mesh
from ..errors import NotConverged
from ..problems.bodies import contact_radius, half_width_guess
from ..problems.rollers import RollerProblem
from ..results import Residuals
from .certificate import certificate
from .equations import About, RollerEquations, RollerMatrices, RollerState
from .result import RollerResult

__all__ = ["check_options", "solve_rollers"]

Array = np.ndarray
MOST_NODES = 1700  # of the meshes that rtol asks for
FINE = Tolerance(load=1e-11, balance=1e-9)
COARSE = Tolerance(load=1e-6, balance=1e-4)


def solve_rollers(
    problem: RollerProblem, *, nodes: int = 101, rtol: float | None = None
) -> RollerResult:
    """Solve two rollers in contact: pressure, traction, stick and slip.

    Parameters
    ----------
    problem : RollerProblem
    nodes : int
        Number of nodes, 7 to 4000; a few more where short zones ask for them.
    rtol : float, optional
        Double the nodes until the estimated relative error of the traction (L2) is below; 1e-8 to
        0.1.

    Returns
    -------
    RollerResult

    Raises
    ------
    InvalidProblem
        For options out of range.
    NotConverged
        If stick and slip or the half width were not found, a law is not satisfied to 1e-8, or
        ``rtol`` is not reached; the last two carry the best result.
    """
    check_type("problem", problem, RollerProblem)
    check_options(nodes=nodes, rtol=rtol)
    result = _solved(problem, int(nodes))
    while rtol is not None and not result.traction_error <= rtol:
        count = 2 * result.x.size - 1
        if count > MOST_NODES:
            raise NotConverged(
                f"rtol={rtol:g} is not reached with {result.x.size} nodes: the estimated error of "
                f"the traction is {result.traction_error:.2g}", result
            )  # fmt: skip
        result = _solved(problem, count)
    return result.checked()


def check_options(*, nodes: Any = 101, rtol: Any = None) -> None:
    """Check the options of :func:`solve_rollers`.

    Raises
    ------
    InvalidProblem
        For an option out of range.
    """
    whole_number("nodes", nodes, 7, 4000)
    if rtol is not None:
        tolerance("rtol", rtol, 1e-8, 0.1)


@dataclass(frozen=True, eq=False)
class RollerContact:
    """Two rollers as the loop sees them."""

    problem: RollerProblem

    @property
    def load(self) -> float:
        """P [N/m]."""
        return self.problem.load

    @property
    def widest(self) -> float:
        """The smaller radius [m]."""
        return min(self.problem.upper.radius, self.problem.lower.radius)

    @property
    def settles_apart(self) -> bool:
        """Whether a body is not linear."""
        return not (self.problem.upper.linear and self.problem.lower.linear)

    def guess(self) -> float:
        """Return a half width to start from [m]."""
        return half_width_guess(self.load, self.problem.upper, self.problem.lower)

    def frictionless_load(self, mesh: Mesh, a: float) -> float:
        """Return the load that a frictionless contact of half width a carries [N/m]."""
        upper, lower = self.problem.upper, self.problem.lower
        slope = np.zeros((mesh.unknowns + 1, mesh.unknowns))
        for body in (upper, lower):
            if not body.rigid:
                slope += body.respond(mesh, a).pressure_slope()
        gap = mesh.middle * (a / contact_radius(upper, lower))
        pressure = solve_normal(slope, gap, np.empty((gap.size, 0)))[:-1, 0]
        return float(a * mesh.grid.weights @ pressure)

    def about(self, mesh: Mesh, a: float, before: Level | None) -> About:
        """Return the loads about which bodies that are not linear are linearised."""
        if before is None or not self.settles_apart:
            return None
        upper, lower = before.state.known
        old, new = before.mesh.columns, mesh.columns
        return on_columns(old, new, upper), on_columns(old, new, lower)

    def equations(self, mesh: Mesh, a: float, about: About) -> RollerEquations:
        """Return the equations for the half width a [m]."""
        return RollerEquations.at(self.problem, mesh, a, about)

    def refuse(self, equations: RollerEquations, state: RollerState) -> None:
        """Refuse nothing: whatever has no steady state was refused with the problem."""

    def scalars(self, level: Level) -> Mapping[str, float]:
        """Return the outputs whose errors are told."""
        state, problem = level.state, self.problem
        rolling = problem.motion == "rolling"
        return {
            "half_width": level.half_width,
            "nip_width": 2 * level.half_width,
            "peak_pressure": level.at_load(float(np.max(state.pressure))),
            "offset": state.shift * contact_radius(problem.upper, problem.lower),
            "tangential_load": float(level.equations.matrices.weights @ state.solution.traction),
            **({"creepage": _creepage(problem, state)} if rolling else {}),
        }

    def scale(self, name: str, value: float) -> float:
        """Return what relative errors of an output are measured by."""
        return abs(value)


def _creepage(problem: RollerProblem, state: RollerState) -> float:
    given = problem.creepage
    return float(state.solution.creep) if given is None else given


def _solved(problem: RollerProblem, nodes: int) -> RollerResult:
    """Solve on meshes ever better fitted to the zone borders, the last with all the nodes."""
    quarter, half = max((nodes + 3) // 4, min(nodes, 13)), max((nodes + 1) // 2, min(nodes, 13))
    ladder = Ladder(RollerContact(problem), Graded(), "tangential_load", tolerance=FINE)
    ladder.climb_fitted((quarter, quarter, half, nodes), COARSE)
    level, before = ladder.level, ladder.before
    state, made, mesh = level.state, level.equations.matrices, level.mesh
    q, zone, a = state.solution.traction, state.solution.state, state.half_width
    rolling = problem.motion == "rolling"
    slip = state.solution.slip
    result = RollerResult(
        problem=problem,
        creepage=_creepage(problem, state) if rolling else nan,
        shift=nan if rolling else float(state.solution.creep),
        tangential_load=float(made.weights @ q),
        half_width=a,
        approach=_approach(problem, made, state),
        offset=state.shift * contact_radius(problem.upper, problem.lower),
        x=a * mesh.nodes,
        pressure=padded(state.pressure),
        traction=padded(q),
        slip_x=a * np.append(mesh.middle[:1], mesh.middle),
        slip=np.concatenate([slip[:1], slip, slip[-1:]]),
        zone=np.concatenate([zone[:1], zone, zone[-1:]]),
        residuals=Residuals(),
        traction_error=nan if before is None else _traction_change(before, level) / 2,
        iterations=ladder.solves,
        mesh=mesh,
    )
    linear = problem.upper.linear and problem.lower.linear
    final = made if linear else level.equations.anew(state)
    return result.replace(errors=ladder.errors_of(result), residuals=certificate(result, final))


def _approach(problem: RollerProblem, made: RollerMatrices, state: RollerState) -> float:
    a, q, v = state.half_width, state.solution.traction, 0.0
    for response, sign in ((made.upper, 1.0), (made.lower, -1.0)):
        by_p, by_q = response.normal()
        v += float((by_p @ state.pressure)[0]) + sign * float((by_q @ q)[0])
    return float(a**2 / (2 * contact_radius(problem.upper, problem.lower)) - v - state.shift * a)


def _traction_change(coarse: Level, fine: Level) -> float:
    """Return the L2 norm of the traction's change from mesh to mesh, relative to its own."""
    (x, q), (old_x, old_q) = (
        (level.mesh.nodes, padded(level.state.solution.traction)) for level in (fine, coarse)
    )
    other = np.interp(x, old_x, old_q)
    whole = float(np.trapezoid(q**2, x))
    return float(np.sqrt(np.trapezoid((q - other) ** 2, x) / whole)) if whole else 0.0
