"""The margins of a roll as text and HTML."""

from __future__ import annotations

from math import isinf

from ..quantities import Quantity, in_chosen_units
from ..roll.result import RollResult
from ..winding.margins import SMALL, Margin, Margins
from .report_parts import Column, Line, Part, Table, TableRow, quantity_of

__all__ = ["margins_part", "margins_parts", "verdict_lines"]

RADIUS = quantity_of(RollResult, "radius")
COLUMNS = (
    Column(),
    Column("value", "number"),
    Column("limit", "number"),
    Column("", "unit"),
    Column("worst at", "phrase"),
    Column("", "phrase"),
)
TONES = {True: "good", False: "bad", None: "quiet"}  # satisfied, violated, not checked


def margins_part(margins: Margins) -> Table:
    """Return the table of margins, for a report."""
    return Table("Margins", COLUMNS, tuple(map(_row, margins)))


def margins_parts(margins: Margins) -> list[Part]:
    """Return verdict, advice and the table of margins."""
    return [*verdict_lines(margins), margins_part(margins)]


def verdict_lines(margins: Margins) -> list[Line]:
    """Return the verdict and the advice as lines."""
    tone = "" if margins.least is None else TONES[not margins.violated]
    lines = [Line(margins.verdict, tone), Line(margins.advice)]
    return [line for line in lines if line.text]


def _row(margin: Margin) -> TableRow:
    """Return the row of a margin: value, limit, location and verdict; remarks below it."""
    quantity, sign = margin.quantity, ">= " if margin.name == "slack" else "<= "
    value, limit = (
        _number(number, prefix, quantity)
        for prefix, number in (("", margin.value), (sign, margin.limit))
    )
    # nan: not at a radius
    place = "" if margin.radius != margin.radius else f"r = {RADIUS.text(margin.radius)}"
    title, verdict = f"{margin.title}: {quantity.meaning}", _verdict_text(margin)
    remarks = filter(None, (_note(margin), f"Not considered: {margin.left_out}"))
    return TableRow(
        (title, value, limit, quantity.display, place, verdict),
        TONES[margin.ok],
        ". ".join(remarks),
    )


def _number(value: float, sign: str, quantity: Quantity) -> str:
    """Return value or limit as text, with a sign before it; a torque without capacity in words."""
    if value != value:  # nan: not known
        return "-"
    return "no capacity" if isinf(value) else f"{sign}{quantity.shown(value):.4g}"


def _note(margin: Margin) -> str:
    """Return the note of a margin, with advice if its reserve is small or negative."""
    small = margin.checked and margin.reserve < SMALL
    stored = in_chosen_units(margin.note)
    advice = f"to increase the reserve: {margin.hint}" if small else ""
    return "; ".join(filter(None, (stored, advice)))


def _verdict_text(margin: Margin) -> str:
    """Return the verdict with the distance from the limit."""
    if margin.ok is None:
        return margin.verdict
    if isinf(margin.value):  # its note states the reason
        return margin.verdict
    distance = margin.distance
    return (
        f"{margin.verdict}, reserve {distance}" if margin.ok else f"{margin.verdict} by {distance}"
    )
