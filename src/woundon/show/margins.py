"""The margins of a roll, told and drawn."""

from __future__ import annotations

from io import StringIO

from ..winding.margins import Margin, Margins
from .html import parts_html
from .parts import Verdict, Verdicts
from .report import plain_console
from .terminal import print_parts

__all__ = ["margins_html", "margins_part", "margins_text"]

TITLE = "Will the roll hold?"
TONES = {True: "good", False: "bad", None: "quiet"}


def margins_part(margins: Margins) -> Verdicts:
    """Return the table of margins, for a report."""
    return Verdicts(TITLE, tuple(map(_verdict, margins)))


def margins_text(margins: Margins) -> str:
    """Return the table as plain text."""
    paper = StringIO()
    print_parts([margins_part(margins)], plain_console(paper))
    return paper.getvalue().rstrip("\n")


def margins_html(margins: Margins) -> str:
    """Return the table for a notebook or a page."""
    return parts_html([margins_part(margins)])


def _verdict(margin: Margin) -> Verdict:
    quantity = margin.quantity
    value, limit = (
        "-" if number != number else f"{sign}{quantity.shown(number):.4g}"
        for sign, number in (("", margin.value), (_sign(margin), margin.limit))
    )
    place = "" if margin.radius != margin.radius else f"r = {1e3 * margin.radius:.4g} mm"
    return Verdict(
        f"{margin.name}: {quantity.meaning}", value, limit, quantity.display, place,
        _word(margin), TONES[margin.ok], margin.note, margin.left_out,
    )  # fmt: skip


def _sign(margin: Margin) -> str:
    return ">= " if margin.name == "slack" else "<= "


def _word(margin: Margin) -> str:
    if margin.ok is None:
        return margin.verdict
    by = f"{100 * abs(margin.reserve):.3g} %"
    if margin.limit == 0:  # of which there is no share
        by = f"{abs(margin.quantity.shown(margin.value)):.4g} {margin.quantity.display}"
    return f"{margin.verdict}, {by} to spare" if margin.ok else f"{margin.verdict} by {by}"
