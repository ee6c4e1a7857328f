"""The parts of a report: sections of rows, zone strips, lines of text.

The report function of a kind returns these parts in their order; they do not depend on the medium
(terminal, HTML).  A row takes meaning, symbol and unit from the quantity of its field or output.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import floor, isfinite, log10, nan
from typing import Any, ClassVar, NamedTuple

import numpy as np

from .. import quantities
from ..nip.result import NipResult
from ..nip.roller_result import RollerResult
from ..problems.description import Description
from ..problems.fields import FLAGS
from ..problems.paths import get_field, quantity_of_field
from ..problems.problem import Problem
from ..problems.schedules import Profile, Steps, Taper
from ..quantities import Quantity, in_chosen_units, rounded_text
from ..results import ACCEPTED_RESIDUAL, Residuals, Result, Zone, zone_runs

__all__ = [
    "COLUMNS",
    "GREEK",
    "SYMBOL",
    "Column",
    "Line",
    "Part",
    "Row",
    "Section",
    "Table",
    "TableRow",
    "ZoneStrips",
    "certificate_line",
    "certificate_of",
    "field_row",
    "friction_bounds",
    "nip_zones",
    "output_row",
    "printed_unit",
    "quantity_of",
    "roller_zones",
    "row_of",
    "rows_of_given",
    "schedule_rows",
    "value_row",
    "values_row",
    "values_table",
    "warning_lines",
    "zone_line",
    "zone_strips",
]

Array = np.ndarray
DIGITS = 5  # significant ones of a value
MOST_LISTED = 8  # values of a field that are listed; more are given by their number and range
_GREEK_NAMES = "alpha beta gamma delta Delta eps kappa mu nu omega rho sigma tau theta xi"
# Units as they are printed: patterns of parts of them, the power before the product.  The page has
# the same in typeset() of units.js.
_PRINTED_UNITS = (
    (r"\bum\b", "µm"),
    (r"\bdeg([CF])\b", r"°\1"),
    (r"\bm\*\*0\.5", "√m"),
    *((rf"\^{power}\b", raised) for power, raised in zip("2345", "²³⁴⁵", strict=True)),
    (r"\*", "·"),
)

GREEK = frozenset(_GREEK_NAMES.split())
# factor, letter, number, index, and sign or exponent of "2a", "mu+", "s_l+", "K1", "V^2"
SYMBOL = re.compile(r"(\d*)([A-Za-z]+?)(\d*)(?:_(\w+(?:,\w+)*))?\^?([+-]?|(?<=\^)\d)")


def printed_unit(text: str) -> str:
    """Return a unit, or a text with units after numbers, as figures, reports and pages print it.

    >>> printed_unit("um"), printed_unit("kg*m^2"), printed_unit("Pa/m**0.5")
    ('µm', 'kg·m²', 'Pa/√m')
    >>> printed_unit("-36 degF"), printed_unit("aluminium")
    ('-36 °F', 'aluminium')
    """
    for written, printed in _PRINTED_UNITS:
        text = re.sub(written, printed, text)
    return text


@dataclass(frozen=True)
class Row:
    """One value of a section.

    Attributes
    ----------
    meaning, symbol : str
    value : float, int or str
        In the unit for display, or a word.
    unit : str
    error : float
        Error estimate in the same unit; nan if there is none.
    note : str
        Text after the unit.
    """

    meaning: str
    symbol: str
    value: float | int | str
    unit: str = ""
    error: float = nan
    note: str = ""

    @property
    def value_text(self) -> str:
        """The value with five digits, or rounded to zero if it is smaller than its error."""
        if isinstance(self.value, str):
            return self.value
        value = float(self.value)
        if isfinite(self.error) and abs(value) < self.error:
            # to two digits of the error; + 0.0 turns -0.0 into 0.0
            value = round(value, 1 - floor(log10(self.error))) + 0.0
        return f"{value:.{DIGITS}g}"

    @property
    def error_text(self) -> str:
        """The error with two digits, or '<' one unit of the last digit of the value."""
        size = nan if isinstance(self.value, str) else abs(float(self.value))
        if not (isfinite(size) and isfinite(self.error)):
            return ""
        if size == self.error == 0:  # e.g. the length of a zone that does not exist
            return ""
        # one unit of the last digit that the value is shown with
        last = 10.0 ** (floor(log10(size)) - DIGITS + 1) if size else 0.0
        return f"<{last:.0g}" if self.error < last else rounded_text(self.error, 2)

    @property
    def text(self) -> str:
        """The value with its unit."""
        return f"{self.value_text} {self.unit}".rstrip()

    @property
    def cells(self) -> tuple[str, str, str, str]:
        """Meaning, symbol, value, and unit with error and note, as in :data:`COLUMNS`."""
        error = f"  ± {self.error_text}" if self.error_text else ""
        return self.meaning, self.symbol, self.value_text, f"{self.unit}{error}{self.note}"


@dataclass(frozen=True)
class Section:
    """Rows under a title, with remarks below."""

    title: str
    rows: tuple[Row, ...]
    text: str = ""

    def as_table(self) -> Table:
        """Return the rows as a table without a head."""
        return Table(self.title, COLUMNS, tuple(TableRow(row.cells) for row in self.rows))


class Column(NamedTuple):
    """A column of a table: its head, and what its cells are.

    ``kind`` is "words", "phrase" (which is not broken), "name" (dotted, of a field), "symbol",
    "number" (on the right) or "unit".
    """

    head: str = ""
    kind: str = "words"


COLUMNS = (Column(), Column("", "symbol"), Column("", "number"), Column("", "unit"))


@dataclass(frozen=True)
class TableRow:
    """A row of a table.

    Attributes
    ----------
    cells : tuple of str
    tone : str
        That of the last cell, as of a :class:`Line`; "differs" marks the row of a field in which
        cases differ.
    below : str
        Remarks below the row.
    """

    cells: tuple[str, ...]
    tone: str = ""
    below: str = ""


@dataclass(frozen=True)
class Table:
    """Rows of texts in columns under a title, with remarks below."""

    title: str
    columns: tuple[Column, ...]
    rows: tuple[TableRow, ...]
    text: str = ""


def values_row(label: str, quantity: Quantity, values: Array) -> TableRow:
    """Return the row of several values in the unit for display, which the last cell states."""
    shown = (f"{float(value) + 0.0:.4g}" for value in np.round(quantity.shown(values), 6))
    return TableRow((label, *shown, quantity.display))


def values_table(
    title: str, heads: Sequence[str], rows: Iterable[TableRow], text: str = ""
) -> Table:
    """Return a table of rows as of :func:`values_row`, with a head for each of their values."""
    columns = (Column(), *(Column(head, "number") for head in heads), Column("", "unit"))
    return Table(title, columns, tuple(rows), text)


@dataclass(frozen=True, eq=False)
class ZoneStrips:
    """Zones along a contact.

    Attributes
    ----------
    x : (M,) array
        Nodes [m].
    faces : mapping of str to (M,) int arrays
        Zones of each node, by the face's name.
    faster, slower : str
        What slip forward (1) and backward (-1) mean.
    """

    TITLE: ClassVar[str] = "Zones, leading edge on the left"

    x: Array
    faces: Mapping[str, Array]
    faster: str = f"web {Zone.FORWARD.word}"
    slower: str = f"web {Zone.BACKWARD.word}"

    @property
    def words(self) -> dict[int, str]:
        """Words for the zones 0, 1 and -1, in the order of a legend."""
        return {0: Zone.STICK.word, 1: self.faster, -1: self.slower}


@dataclass(frozen=True)
class Line:
    """A text; ``tone`` is one of "quiet", "answer", "warning", "good", "bad"."""

    text: str
    tone: str = ""


Part = Section | Table | ZoneStrips | Line


# ---- rows from quantities -----------------------------------------------------------------------


def quantity_of(result: Result | type[Result], name: str) -> Quantity:
    """Return the quantity of an output of a result, or of a class of results.

    All that is drawn along an axis is converted by the quantity that labels it.
    """
    place = quantities.output(result, name)
    if place is None or place.quantity is None:
        raise AttributeError(f"{type(result).__name__} has no output {name!r}")
    return place.quantity


def row_of(quantity: Quantity, value: Any, error: float = nan, **texts: str) -> Row:
    """Return the row of a value and its error [SI].

    ``texts`` are fields of the row, such as ``meaning``, in place of those of the quantity.
    """
    converted, error = quantity.shown(value), abs(quantity.shown(error))
    row = Row(quantity.meaning, quantity.symbol, converted, quantity.display, error)
    return replace(row, **texts)  # type: ignore[arg-type]


def output_row(result: Result, name: str, value: float | None = None, **texts: str) -> Row:
    """Return the row of an output with its error estimate.

    Parameters
    ----------
    result : Result
    name : str
        Of the output.
    value : float, optional
        Value in place of that of the result, e.g. of a closed form, in SI units; without error.
    texts : str
        ``meaning``, ``symbol`` in place of the quantity's; ``note`` behind the unit.
    """
    quantity = quantity_of(result, name)
    if value is not None:
        return row_of(quantity, value, nan, **texts)
    error = result.errors.get(name, nan)
    return row_of(quantity, quantities.value_of(result, name), error, **texts)


def value_row(quantity: Quantity | None, value: Any) -> Row:
    """Return the row of the value of a field: a number, several, a word, or None."""
    text = "not given" if value is None else str(value)
    text = FLAGS[value] if isinstance(value, bool) else text
    if quantity is None:
        return Row(meaning="", symbol="", value=text)
    if isinstance(value, int | float):
        return row_of(quantity, value)
    if isinstance(value, tuple):
        text = _list_text([quantity.shown(item) for item in value])
    unit = quantity.display if isinstance(value, tuple) else ""
    return Row(quantity.meaning, quantity.symbol, text, unit)


def _list_text(values: Sequence[float]) -> str:
    """Return numbers as text; of many of them their number, and the smallest and largest one."""
    if len(values) <= MOST_LISTED:
        return ", ".join(f"{value:.{DIGITS}g}" for value in values)
    low, high = min(values), max(values)
    ends = f"{low:.{DIGITS}g}" if low == high else f"{low:.{DIGITS}g} to {high:.{DIGITS}g}"
    return f"{len(values)} values, {ends}"


def rows_of_given(problem: Description, *names: str) -> list[Row]:
    """Return the rows of the fields that are given and not zero."""
    return [field_row(problem, name) for name in names if getattr(problem, name)]


def field_row(problem: Description, name: str, *, empty: float = nan, **texts: str) -> Row:
    """Return the row of a problem's field; ``empty`` is the value of a field that is None.

    ``texts`` as of :func:`row_of`.
    """
    value = get_field(problem, name)
    return row_of(quantity_of_field(problem, name), empty if value is None else value, nan, **texts)


def schedule_rows(problem: Problem, name: str, ends: Iterable[float]) -> list[Row]:
    """Return the row of a number, or those of a schedule at the core and at the surface.

    Parameters
    ----------
    problem : Problem
    name : str
        Field.
    ends : (2,) iterable of float
        Values of the schedule at the core and at the surface [SI].
    """
    if not isinstance(get_field(problem, name), Taper | Steps | Profile):
        return [field_row(problem, name)]
    quantity = quantity_of_field(problem, name)
    return [
        row_of(quantity, float(value), meaning=f"{quantity.meaning}, at the {where}")
        for where, value in zip(("core", "surface"), ends, strict=True)
    ]


# ---- what every report ends with ----------------------------------------------------------------


def warning_lines(warnings: Iterable[str]) -> list[Line]:
    """Return the lines of a result's warnings."""
    return [Line(f"warning: {in_chosen_units(text)}", "warning") for text in warnings]


def certificate_line(residuals: Residuals, noun: str = "contact condition") -> Line:
    """Return the line of the certificate: all conditions are satisfied, or which are not.

    ``noun`` is what a condition is called.
    """
    conditions = dict(residuals.items())
    if not conditions:
        return Line(f"Certificate: none; no {noun} was evaluated", "bad")
    # a nan is not satisfied either
    violated = {n: value for n, value in conditions.items() if not value <= ACCEPTED_RESIDUAL}
    if not violated:
        several = f"all {len(conditions)} {noun}s are satisfied"
        satisfied = several if len(conditions) > 1 else "its one condition is satisfied"
        worst = f"{residuals.largest:.1e} ({_readable(residuals.worst)})"
        return Line(f"Certificate: {satisfied}; largest residual {worst}", "good")
    values = ", ".join(
        f"{_readable(name)} " + ("not known (nan)" if value != value else f"{value:.1e}")
        for name, value in violated.items()
    )
    count = f"{len(violated)} of {len(conditions)} {noun}s {'is' if len(violated) == 1 else 'are'}"
    return Line(f"Certificate: {count} NOT satisfied: {values}", "bad")


def certificate_of(result: Result) -> Line:
    """Return the line of the certificate of a result of any kind."""
    contact = isinstance(result, NipResult | RollerResult)
    return certificate_line(result.residuals, "contact condition" if contact else "condition")


def _readable(condition: str) -> str:
    """Return the name of a condition in words."""
    return condition.replace("_", " ")


# ---- zones --------------------------------------------------------------------------------------


def nip_zones(result: NipResult) -> ZoneStrips:
    """Return the zones of a nip at roll and drum."""
    nip = result.in_nip
    faces = {"roll": result.roll_zone[nip], "drum": result.drum_zone[nip]}
    return ZoneStrips(result.x[nip], faces)


def roller_zones(result: RollerResult) -> ZoneStrips:
    """Return the zones of two rollers."""
    faces = {"contact": result.zone}
    return ZoneStrips(result.x, faces, faster="lower faster", slower="lower slower")


def zone_strips(result: Result) -> ZoneStrips | None:
    """Return the zones of a contact of any kind; None where there are none."""
    if isinstance(result, NipResult):
        return nip_zones(result)
    return roller_zones(result) if isinstance(result, RollerResult) else None


def friction_bounds(result: Result) -> dict[str, Array]:
    """Return the friction bound mu p [Pa] at the nodes, by the name of the traction.

    In a nip, mu is the friction that an air film leaves.
    """
    problem = result.problem
    if isinstance(result, RollerResult):
        return {"traction": problem.friction * result.pressure}
    if not isinstance(result, NipResult):
        return {}
    # the equations of a nip with air: those without, with the friction that the film leaves
    problem = result.without_air
    mu = np.full(result.x.shape, problem.roll_friction)
    mu[result.in_nip.stop :] = problem.friction_on_wrap  # nodes downstream of the nip
    return {
        "roll_traction": mu * result.roll_pressure,
        "drum_traction": problem.drum_friction * result.drum_pressure,
    }


def zone_line(x: Array, zones: Array, width: int) -> list[tuple[int, int]]:
    """Return the zones as runs (zone, number of characters) over ``width`` characters.

    The length of a run is proportional to that of the zone, but at least one character.  ``x``
    are the nodes [m], ``zones`` their zones, both (n,).
    """
    runs = [
        (zone, max(1, round((right - left) / (x[-1] - x[0]) * width)))
        for zone, left, right in zone_runs(x, zones)
    ]
    # the longest run absorbs the rounding
    longest = max(range(len(runs)), key=lambda i: runs[i][1])
    surplus = sum(length for _, length in runs) - width
    runs[longest] = (runs[longest][0], max(1, runs[longest][1] - surplus))
    return runs
