"""Closed forms next to the solution of a nip or of two rollers."""

from __future__ import annotations

from collections.abc import Iterator

from .. import theories
from ..errors import InvalidProblem
from ..nip.result import NipResult
from ..nip.roller_result import RollerResult
from .outputs_report import is_half_plane
from .report_parts import Row, Section, output_row

__all__ = ["nip_closed_forms", "roller_closed_forms"]


def nip_closed_forms(result: NipResult) -> Iterator[Section]:
    """Yield closed forms of a nip; tension formulas use the solved approach and zones."""
    rows = [
        output_row(result, "nip_induced_tension", value, meaning=label)
        for label, value in _tension_formulas(result)
    ]
    rows += _hertz(result, "Hertz (half-planes, no web)")
    if rows:
        yield Section("Other theories", tuple(rows))


def _tension_formulas(result: NipResult) -> Iterator[tuple[str, float]]:
    """Yield (words, value [N/m]) of the closed forms of the nip-induced tension that apply.

    The trade rule has a section of its own.
    """
    problem = result.problem
    if problem.drum_wrap or problem.air:
        return  # their winding force is that of the nip alone
    if result.dual:
        dual = float(theories.dual_slip(problem, result.dual))
        yield "dual-slip formula, with the solved dual slip", dual
    if not (is_half_plane(problem.roll) or is_half_plane(problem.drum)):
        jalkanen = theories.jalkanen(problem, result.approach)
        yield "Jalkanen, with the solved approach", jalkanen


def _hertz(result: NipResult | RollerResult, label: str) -> list[Row]:
    """Return rows of width and peak pressure by Hertz's theory, named by ``label``.

    Empty if it does not apply.
    """
    if result.problem.viscoelastic:
        label += ", all relaxed"
    try:
        contact = theories.hertz(result.problem)
    except InvalidProblem:  # a body of no linear elastic material
        return []
    return [
        output_row(result, "nip_width", 2 * contact.half_width, meaning=label),
        output_row(result, "peak_pressure", contact.peak_pressure, meaning=label),
    ]


def roller_closed_forms(result: RollerResult) -> Iterator[Section]:
    """Yield the closed forms of two rollers."""
    elastic = not result.problem.viscoelastic
    rows = [*_partial_slip(result), *_free_rolling(result)] if elastic else []
    rows += _hertz(result, "Hertz (half-planes)")
    if rows:
        yield Section("Closed forms", tuple(rows))


def _partial_slip(result: RollerResult) -> Iterator[Row]:
    """Yield Carter's or Cattaneo's solution for elastically similar rollers."""
    rolling = result.problem.motion == "rolling"
    name, theory = ("Carter", theories.carter) if rolling else ("Cattaneo", theories.cattaneo)
    try:
        solution = theory(result.problem)
    except InvalidProblem:  # it does not apply to these rollers
        return
    label = f"{name} (similar half-planes)"
    if rolling and result.problem.creepage is None:
        yield output_row(result, "creepage", solution.creepage, meaning=label)
    if rolling and result.problem.creepage is not None:
        yield output_row(result, "tangential_load", solution.tangential_load, meaning=label)
    share = 1 - solution.stick_half_width / solution.half_width
    yield output_row(result, "slip_share", share, meaning=label)


def _free_rolling(result: RollerResult) -> Iterator[Row]:
    """Yield the limits of Bentall and Johnson for dissimilar rollers in free rolling."""
    problem = result.problem
    if problem.motion != "rolling" or problem.creepage is not None or problem.tangential_load:
        return
    try:
        stick = theories.bentall_johnson_stick(problem)
        slip = theories.bentall_johnson_frictionless(problem)
    except InvalidProblem:  # a body of no linear elastic material
        return
    if stick.oscillation:  # similar ones roll freely without creepage
        for value, neglected in ((slip, "friction"), (stick.creepage, "slip")):
            label = f"Bentall and Johnson (half-planes), without {neglected}"
            yield output_row(result, "creepage", value, meaning=label)
