r"""Two rollers without a web, rolling or static, by the loop of every contact here.

The traction leaves a zone border like the root of the distance, so the meshes are graded there:
each is fitted to the borders that the one before found.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import nan
from types import SimpleNamespace
from typing import Any, ClassVar

import numpy as np

from ..arguments import check_type, nodes_or_rtol, tolerance, whole_number
from ..contact.loop import Ladder, Level, Tolerance
from ..contact.response import padded
from ..contact.schemes import Graded
from ..errors import NotConverged
from ..problems.rollers import RollerProblem
from ..results import Residuals, measured
from ..threads import one_thread
from ..two_bodies import PairContact, PairEquations, PairState, approach
from .certificate import certificate, matrices_of
from .equations import RollerEquations
from .frictionless import without_traction
from .result import RollerResult
from .validity import roller_warnings

__all__ = ["check_options", "recomputed", "solve_rollers"]

Array = np.ndarray
NODES = 101
MOST_NODES = 1700  # of the meshes that rtol asks for
FINE = Tolerance(load=1e-11, balance=1e-9)
COARSE = Tolerance(load=1e-6, balance=1e-4)


@one_thread
def solve_rollers(
    problem: RollerProblem, *, nodes: int = NODES, rtol: float | None = None
) -> RollerResult:
    """Solve two rollers in contact: pressure, traction, stick and slip.

    Parameters
    ----------
    problem : RollerProblem
    nodes : int
        Number of nodes, 7 to 4000; a few more where short zones ask for them.
    rtol : float, optional
        In place of nodes: double them until the estimated relative error of the traction (L2) is
        below; 1e-8 to 0.1.  Without friction there is no traction to err.

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
    return result.checked().warned()


def check_options(*, nodes: Any = NODES, rtol: Any = None) -> None:
    """Check the options of :func:`solve_rollers`.

    Raises
    ------
    InvalidProblem
        For an option out of range.
    """
    whole_number("nodes", nodes, 7, 4000)
    if rtol is not None:
        tolerance("rtol", rtol, 1e-8, 0.1)
    nodes_or_rtol(None if nodes == NODES else nodes, rtol)


class RollerContact(PairContact):
    """Two rollers as the loop sees them."""

    equations_of: ClassVar[type[PairEquations]] = RollerEquations
    load_field: ClassVar[str] = "load"

    def scalars(self, level: Level) -> Mapping[str, float]:
        """Return the outputs whose errors are told."""
        state, weights = level.state, level.equations.matrices.weights
        rolling = self.problem.motion == "rolling"
        return {
            **super().scalars(level),
            "tangential_load": float(weights @ state.traction),
            **({"creepage": _creepage(self.problem, state)} if rolling else {}),
        }


def _creepage(problem: RollerProblem, state: PairState) -> float:
    given = problem.creepage
    return float(state.solution.creep) if given is None else given


def _solved(problem: RollerProblem, nodes: int) -> RollerResult:
    """Solve on meshes ever better fitted to the zone borders, the last with all the nodes."""
    quarter, half = max((nodes + 3) // 4, min(nodes, 13)), max((nodes + 1) // 2, min(nodes, 13))
    contact, counts = RollerContact(problem), (quarter, quarter, half, nodes)
    if problem.friction:
        ladder = Ladder(contact, Graded(), "tangential_load", tolerance=FINE)
        ladder.climb_fitted(counts, COARSE)
    else:  # no zone has a border
        ladder = Ladder(contact, Graded(), "half_width", without_traction, FINE)
        ladder.climb(counts[1:])
    level, before = ladder.level, ladder.before
    state, made, mesh = level.state, level.equations.matrices, level.mesh
    q, zone, a = state.traction, state.solution.state, state.half_width
    rolling = problem.motion == "rolling"
    slip = state.solution.slip
    result = RollerResult(
        problem=problem,
        creepage=_creepage(problem, state) if rolling else nan,
        shift=nan if rolling else float(state.solution.creep),
        tangential_load=float(made.weights @ q),
        half_width=a,
        approach=approach(problem, made, state),
        offset=state.shift * problem.contact_radius,
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
        rolling_resistance=ladder.history[-1].get("rolling_resistance", nan),
    )
    return measured(
        result,
        errors=ladder.errors_of(result),
        residuals=certificate(result, level.equations.anew(state)),
        warnings=roller_warnings(result),
    )


def _traction_change(coarse: Level, fine: Level) -> float:
    """Return the L2 norm of the traction's change from mesh to mesh, relative to its own."""
    (x, q), (old_x, old_q) = (
        (level.mesh.nodes, padded(level.state.traction)) for level in (fine, coarse)
    )
    other = np.interp(x, old_x, old_q)
    whole = float(np.trapezoid(q**2, x))
    return float(np.sqrt(np.trapezoid((q - other) ** 2, x) / whole)) if whole else 0.0


def recomputed(result: RollerResult) -> dict[str, tuple[float, float]]:
    """Return the scalars that no law tells, by name: as the arrays give them, how exactly."""
    state: Any = SimpleNamespace(  # as much of one as the approach asks for
        half_width=result.half_width, pressure=result.pressure[1:-1],
        traction=result.traction[1:-1], shift=result.offset / result.problem.contact_radius,
    )  # fmt: skip
    delta = approach(result.problem, matrices_of(result), state)
    return {"approach": (delta, 1e-5 * abs(delta))}  # 0.1 summed its series less far
