"""The report of a result of any kind: its sections, warnings and certificate."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from .. import kinds
from ..results import Result
from .answer import answer_lines, assumptions_section, defaults_section
from .report_parts import Part, certificate_of, warning_lines

__all__ = ["report_of", "report_parts"]


def report_parts(result: Result) -> list[Part]:
    """Return the report of any result: answer, sections, warnings and certificate."""
    report = report_of(kinds.of(result))
    warnings = warning_lines((*getattr(result.problem, "input_warnings", ()), *result.warnings))
    return [
        *answer_lines(result),
        *report(result),
        *assumptions_section(result),
        *defaults_section(result.problem),
        *warnings,
        certificate_of(result),
    ]


def report_of(kind: kinds.Kind[Any, Any]) -> Callable[[Any], list[Part]]:
    """Return the report of a kind; only its module is imported, for a command has one result.

    >>> report_of(kinds.named("nip")).__name__
    'nip_report'
    """
    if kind.report is not None:
        return kind.report
    match kind.name:
        case "nip":
            from .nip_report import nip_report

            return nip_report
        case "rollers":
            from .roller_report import roller_report

            return roller_report
        case "roll":
            from .roll_report import roll_report

            return roll_report
        case "winding":
            from .winding_report import winding_report

            return winding_report
        case _:
            from .outputs_report import outputs_report

            return outputs_report
