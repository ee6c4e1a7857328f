"""The report of a result of any kind: its sections, warnings and certificate."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from .. import kinds
from ..results import Result
from .answer import answer_lines, assumptions_section, defaults_section
from .nip_report import nip_report
from .outputs_report import outputs_report
from .report_parts import Part, certificate_of, warning_lines
from .roll_report import roll_report
from .roller_report import roller_report
from .winding_report import winding_report

__all__ = ["report_parts"]

REPORTS: Mapping[str, Callable[[Any], list[Part]]] = {
    "nip": nip_report,
    "rollers": roller_report,
    "roll": roll_report,
    "winding": winding_report,
}


def report_parts(result: Result) -> list[Part]:
    """Return the report of any result: answer, sections, warnings and certificate."""
    kind = kinds.of(result)
    report = kind.report or REPORTS.get(kind.name, outputs_report)
    warnings = warning_lines((*getattr(result.problem, "input_warnings", ()), *result.warnings))
    return [
        *answer_lines(result),
        *report(result),
        *assumptions_section(result),
        *defaults_section(result.problem),
        *warnings,
        certificate_of(result),
    ]
