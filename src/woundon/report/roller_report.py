"""The report of two rollers."""

from __future__ import annotations

from math import isnan

from ..nip.roller_result import RollerResult
from .closed_forms import roller_closed_forms
from .outputs_report import approach_note, rows_of
from .report_parts import Line, Part, Row, Section, field_row, roller_zones

__all__ = ["roller_report"]


def roller_report(result: RollerResult) -> list[Part]:
    """Return the report of two rollers."""
    problem, rolling = result.problem, result.problem.motion == "rolling"
    prescribed = "creepage" if problem.creepage is not None else "tangential_load"
    moving = [] if problem.speed is None else ["speed"]
    names = ("load", prescribed, "friction", *moving)
    loads = (field_row(problem, name, empty=0.0) for name in names)
    summary = f"{problem.motion} contact, {result.nodes} nodes, {result.iterations} linear systems"
    return [
        Line(summary, "quiet"),
        Section("Loads", tuple(loads)),
        Section("Rolling contact" if rolling else "Static contact", _roller_rows(result)),
        roller_zones(result),
        *roller_closed_forms(result),
    ]


def _roller_rows(result: RollerResult) -> tuple[Row, ...]:
    """Return the rows of the outputs of rollers."""
    problem = result.problem
    computed = "creepage" if problem.motion == "rolling" else "shift"
    names = [
        "tangential_load" if problem.creepage is not None else computed,
        "nip_width",
        "peak_pressure",
        "approach",
        "offset",
        "slip_share",
    ]
    if not isnan(result.traction_error):
        names.append("traction_error")
    undetermined = approach_note(problem.upper, problem.lower)
    return rows_of(result, names, approach=undetermined, shift=undetermined)
