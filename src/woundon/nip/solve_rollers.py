"""Solve two rollers without a web on a sequence of meshes.

The equations of :mod:`.rollers` are solved on refined meshes until the error estimates e of half
width, largest pressure, and creepage (with a prescribed tangential load) or tangential load satisfy

    e(a) <= rtol a,    e(p_max) <= rtol p_max,
    e(xi) <= rtol max(|xi|, 0.01 mu a/R*)    or    e(Q) <= rtol max(|Q|, 0.01 mu P).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from itertools import pairwise
from math import nan
from typing import Annotated

import numpy as np

from ..arguments import Option, check_type, nodes_or_rtol, tolerance, whole_number
from ..contact.newton import NewtonFailed
from ..contact.refinement import (
    CHANGES,
    FINAL_TOLERANCE,
    Refinement,
    Tolerances,
    refine,
)
from ..errors import RESOLUTION, NotConverged
from ..parallel import one_thread
from ..problems.messages import quote
from ..problems.rollers import RollerProblem
from ..results import Residuals, measured
from ..validity import far_outside
from .conditions import LARGEST_MESH
from .load_limit import bending_text, check_load
from .roller_certificate import certificate, consistency
from .roller_result import RollerResult
from .rollers import RollerEquations
from .validity import roller_warnings
from .zones import LEAST_OFFSET_ERROR, cusp_excess

__all__ = ["check_options", "solve_rollers"]

Array = np.ndarray

# Relative error of half width, peak pressure, and creepage or tangential load.
DEFAULT_RTOL = 1e-3
# The solver's tolerance of 1e-9 would contribute to smaller ones.
LEAST_RTOL, MOST_RTOL = 1e-5, 0.1
# Largest meshes: by default, and with an explicit rtol.
DEFAULT_NODES, MOST_NODES = 257, 1025
LEAST_NODES = 7
NODES_OPTION = Option("Number of nodes on the last mesh.", "7 to 2049.")
RTOL_OPTION = Option(
    "Relative error of the solver.",
    "1e-5 to 0.1, of half width, peak pressure, and creepage or tangential load; default 1e-3.",
)
# Creepages and tangential loads near zero are not known to a relative error: they are measured by
# at least this share of those of full slip.
FLOOR = 0.01
# A violation of the power balance beyond this many error estimates is reported.
INCONSISTENT = 3.0


@one_thread
def solve_rollers(
    problem: RollerProblem,
    *,
    nodes: Annotated[int | None, NODES_OPTION] = None,
    rtol: Annotated[float | None, RTOL_OPTION] = None,
    start: RollerResult | None = None,
    errors: bool = True,
    progress: Callable[[float], None] | None = None,
) -> RollerResult:
    """Solve two rollers in contact: pressure, traction, stick and slip.

    The mesh is refined until the estimated errors of the half width, the peak pressure, and the
    creepage or the tangential load are below 0.1 %.  A result that needs more than 257 nodes is
    returned with its error estimates and a warning.

    Parameters
    ----------
    problem : RollerProblem
    nodes : int, optional
        Size of the last mesh, 7 to 2049, in place of the criterion.
    rtol : float, optional
        Relative error in place of 0.1 %, 1e-5 to 0.1, reached with at most 1025 nodes.
    start : RollerResult, optional
        The solution of a neighbouring problem, which supplies the initial guess on every mesh.  It
        does not change the result beyond the solver tolerance.  A result restored from a file does
        not hold the solutions on its meshes and is not used.
    errors : bool
        False omits the error estimates if ``start`` has ``nodes`` too: only the last mesh is
        solved.
    progress : callable, optional
        Called with the estimated fraction of the work that is done.

    Returns
    -------
    RollerResult

    Raises
    ------
    InvalidProblem
        For options out of range, and for a load that no single contact carries.
    NotConverged
        If the iteration fails, a contact condition is violated by more than 1e-8, or ``rtol`` is
        not reached; the last two carry the best result.

    Examples
    --------
    >>> result = solve_rollers(RollerProblem.example())
    >>> round(result.half_width * 1e3, 3)  # mm
    0.354
    """
    check_type("problem", problem, RollerProblem)
    check_options(nodes=nodes, rtol=rtol, start=start, errors=errors)
    check_load(problem, "load")
    relative = DEFAULT_RTOL if rtol is None else float(rtol)
    tolerances = _tolerances(problem, relative)
    try:
        refinement = refine(
            lambda size: RollerEquations(problem, size),
            nodes=nodes,
            tolerances=tolerances,
            most_nodes=DEFAULT_NODES if rtol is None else MOST_NODES,
            rtol=relative,
            start=None if start is None else start.refinement,
            errors=errors,
            progress=progress,
        )
    except NewtonFailed as failed:
        texts = (
            f"stick and slip zones were not found: {failed}",
            *far_outside(problem, problem.load),
            bending_text(problem, problem.load),
        )
        raise NotConverged("; ".join(filter(None, texts))) from failed
    unmet = "" if nodes else _unmet_tolerance(refinement, tolerances)
    result = _result(problem, refinement, unmet if rtol is None else "").checked()
    if unmet and rtol is not None:
        raise NotConverged(f"rtol={rtol:g} is not reached: {unmet}", result)
    return result.warned()


def check_options(
    *, nodes: object = None, rtol: object = None, start: object = None, errors: object = True
) -> None:
    """Check the options of :func:`solve_rollers`.

    Raises
    ------
    InvalidProblem
        For an option out of range.
    """
    if nodes is not None:
        whole_number("nodes", nodes, LEAST_NODES, LARGEST_MESH)
    if rtol is not None:
        tolerance("rtol", rtol, LEAST_RTOL, MOST_RTOL)
    nodes_or_rtol(nodes, rtol)
    check_type("errors", errors, bool)
    if start is not None:
        check_type("start", start, RollerResult)


def _tolerances(problem: RollerProblem, rtol: float) -> Tolerances:
    """Return the function that returns the permitted errors of the main outputs."""

    def tolerances(outputs: Mapping[str, float]) -> dict[str, float]:
        """Return the permitted errors of given outputs, by name."""
        floors = {"half_width": 0.0, "peak_pressure": 0.0}
        if problem.friction and problem.creepage is not None:
            floors["tangential_load"] = FLOOR * problem.friction * problem.load
        elif "creepage" in outputs and problem.creepage is None:
            slope = outputs["half_width"] / problem.contact_radius
            floors["creepage"] = FLOOR * (problem.friction or 1.0) * slope
        return {name: rtol * max(abs(outputs[name]), floor) for name, floor in floors.items()}

    return tolerances


def _unmet_tolerance(refinement: Refinement, tolerances: Tolerances) -> str:
    """Return a text about the output that misses its tolerance most; empty if none does."""
    ratios = refinement.ratios(tolerances)
    name = max(ratios, key=lambda key: ratios[key])
    if ratios[name] <= 1:
        return ""
    value = quote(float(f"{refinement.errors(of='main_outputs')[name]:.2g}"))
    return (
        f"the estimated error of {name} is {value} with {refinement.last.size} nodes, "
        f"{ratios[name]:.2g} times the tolerance"
    )


def _result(problem: RollerProblem, refinement: Refinement, unmet: str) -> RollerResult:
    """Assemble the result of the last mesh with its certificate, errors and warnings."""
    equations: RollerEquations = refinement.last.system
    state, outputs = refinement.last.state, refinement.last.outputs
    a = state.geometry.a
    xi, slip = equations.slip(state)
    result = RollerResult(
        problem=problem,
        creepage=nan if equations.static else xi,
        shift=outputs["shift"] if equations.static else nan,
        tangential_load=outputs["tangential_load"],
        half_width=a,
        approach=outputs["approach"],
        offset=outputs["offset"],
        x=a * equations.mesh.nodes,
        pressure=state.p.copy(),
        traction=state.q.copy(),
        slip_x=equations.slip_points(a),
        slip=slip,
        zone=equations.zones(state, refinement.last.active),
        residuals=Residuals(),
        traction_error=_traction_error(refinement),
        iterations=refinement.iterations,
        rolling_resistance=outputs.get("rolling_resistance", nan),
        refinement=refinement,
    )
    errors = refinement.errors()
    # both may be zero
    errors["offset"] = max(errors["offset"], LEAST_OFFSET_ERROR * a)
    friction_limit = FINAL_TOLERANCE * problem.friction * problem.load
    errors["tangential_load"] = max(errors["tangential_load"], friction_limit)
    errors["peak_pressure"] = max(
        errors["peak_pressure"], cusp_excess(result.pressure, result.zone)
    )
    # the position of a zone boundary is known to the cell in which it lies
    errors["slip_share"] = max(errors["slip_share"], float(equations.mesh.cells.max()) / 2)
    warnings = [*roller_warnings(result), *_inconsistent(result, errors)]
    if unmet:
        warnings.append(f"{RESOLUTION}{unmet}; use an rtol of {DEFAULT_RTOL:g}")
    return measured(result, errors=errors, residuals=certificate(result), warnings=tuple(warnings))


def _traction_error(refinement: Refinement) -> float:
    """Return the estimated error of the traction, its L2 norm relative to that of the traction.

    Next to zone boundaries tractions have infinite slopes, so that they converge with order one: on
    meshes of m < n nodes the error on the finer one is about the change over n/m - 1, and n/N of
    that on the last mesh of N nodes.  Of the estimates from the last two changes the larger one is
    returned; nan without any traction, and on a single mesh.
    """
    last, estimates = refinement.last, [nan]
    if not last.state.q.any():
        return nan
    # squares of tractions may underflow
    peak, w = np.abs(last.state.q).max(), last.system.mesh.weights
    for coarse, fine in pairwise(refinement.meshes[-1 - CHANGES :]):
        x = fine.system.mesh.nodes
        other = np.interp(x, coarse.system.mesh.nodes, coarse.state.q)
        change = np.sqrt(fine.system.mesh.weights @ ((fine.state.q - other) / peak) ** 2)
        change /= np.sqrt(w @ (last.state.q / peak) ** 2)
        estimates.append(change / (fine.size / coarse.size - 1) * (fine.size / last.size))
    return float(np.fmax.reduce(estimates))


def _inconsistent(result: RollerResult, errors: Mapping[str, float]) -> list[str]:
    """Return a warning if the power balance is violated beyond the error estimates of its terms.

    Both are relative to P a/R*; ``errors`` are the estimated errors of the outputs by name.
    """
    if not result.problem.viscoelastic:
        return []
    problem, violation = result.problem, consistency(result).power_balance
    size = problem.load * result.half_width / problem.contact_radius
    terms = errors["rolling_resistance"] / size
    terms += errors["offset"] / result.half_width
    terms += abs(errors["creepage"] * result.tangential_load) / size
    terms += abs(errors["tangential_load"] * result.creepage) / size
    if not violation > INCONSISTENT * terms:
        return []
    return [
        f"{RESOLUTION}the power balance is violated by {violation:.2g} of P a/R*, more than "
        f"{INCONSISTENT:g} times the estimated errors of its terms; use more nodes"
    ]
