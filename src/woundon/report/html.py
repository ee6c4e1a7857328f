"""Reports as HTML tables for notebooks, in their light or dark colours.

Every text is escaped.  Letters and grounds have no colour here, they take those of the page; only
marks have one, of zones and of a limit that is not kept.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from html import escape
from typing import TYPE_CHECKING

from ..results import zone_runs
from .report_parts import (
    GREEK,
    SYMBOL,
    Line,
    Part,
    Section,
    Table,
    TableRow,
    ZoneStrips,
    printed_unit,
)

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["frame_html", "label_html", "parts_html", "symbol_html", "table_html", "unit_html"]

LEFT = "text-align:left"
RIGHT = "text-align:right"
QUIET = "opacity:0.75"
ALARM = "display:inline-block;background:#B00020;color:#FFFFFF;font-weight:bold;padding:0 0.4em"
_ZONES = {-1: "#E69F00", 0: "#BBBBBB", 1: "#56B4E9"}


def frame_html(head: str, frame: pd.DataFrame, remarks: Iterable[str]) -> str:
    """Return the HTML of a section: heading, table of numbers, remarks."""
    table = frame.to_html(float_format="{:.4g}".format, na_rep="")
    return _division([_paragraph(head), table, *map(_paragraph, remarks)])


def parts_html(parts: Iterable[Part]) -> str:
    """Return the parts of a report."""
    return _division([_part(part) for part in parts])


def _division(texts: Sequence[str]) -> str:
    """Return pieces of HTML in one element."""
    return "<div>\n{}\n</div>".format("\n".join(texts))


def _part(part: Part) -> str:
    """Return the HTML of a part of a report."""
    if isinstance(part, Section | Table):
        table = part.as_table() if isinstance(part, Section) else part
        return table_html(table) + (_paragraph(part.text, QUIET) if part.text else "")
    return _strips(part) if isinstance(part, ZoneStrips) else _line(part)


def _paragraph(text: str, style: str = "") -> str:
    """Return the HTML of a text, which is escaped; ``style`` is more CSS."""
    return f'<p style="margin:0.3em 0;{style}">{label_html(text)}</p>'


def _line(line: Line) -> str:
    """Return the HTML of a line in the style of its tone."""
    styles = {"quiet": QUIET, **dict.fromkeys(("answer", "warning", "bad"), "font-weight:bold")}
    return _paragraph(line.text, styles.get(line.tone, ""))


def symbol_html(symbol: str) -> str:
    """Return a symbol with Greek letters, index and exponent; quotients have a symbol on each side.

    >>> symbol_html("mu+ p"), symbol_html("T_in"), symbol_html("M_k,max")
    ('<i>&mu;</i><sup>+</sup> <i>p</i>', '<i>T</i><sub>in</sub>', '<i>M</i><sub>k,max</sub>')
    >>> symbol_html("m V^2")
    '<i>m</i> <i>V</i><sup>2</sup>'
    """
    return " ".join("/".join(map(_symbol, word.split("/"))) for word in symbol.split(" "))


def _symbol(word: str) -> str:
    """Return a single symbol; a word that is none as it is."""
    match = SYMBOL.fullmatch(word)
    if match is None:
        return escape(word)
    factor, base, number, index, sign = match.groups()
    letter = f"&{base.replace('eps', 'epsilon')};" if base in GREEK else base
    letter = f"<i>{letter}</i>" if base in GREEK or len(base) == 1 else letter
    index = f"&{index};" if index in GREEK else index
    subscript = number + (index or "")
    # nothing for an empty one
    subscript, superscript = subscript and f"<sub>{subscript}</sub>", sign and f"<sup>{sign}</sup>"
    return f"{factor}{letter}{subscript}{superscript}"


# A symbol within words: "T_in", "sigma_b", "mu+", "M2", "F"; not the article "A", units as in "2 N"
# and "N/m", or names as "web_tension".
_LETTER = r"(?<!\d )[B-Z]\d?(?!\w|/[a-z])"
_LETTERS = "|".join(sorted(GREEK))
_ONE = rf"(?:(?:[A-Za-z]|{_LETTERS})_\w{{1,4}}\b|(?:{_LETTERS})\b[+-]?|{_LETTER})"
_TERM = rf"-?{_ONE}(?:/{_ONE})?"
# symbols on their own, or with operators between them: "WOT - T_in", "F = -M2/R2"
_FORMULA = re.compile(rf"(?<![\w.'=/-])(?:(?:{_TERM}|WOT|NIT) [=+-] )*{_TERM}")


def label_html(text: str) -> str:
    """Return a text whose formulas and units are typeset; a formula is not broken.

    >>> label_html("nip-induced tension, WOT - T_in")
    'nip-induced tension, <span style="white-space:nowrap">WOT - <i>T</i><sub>in</sub></span>'
    >>> label_html("winding force, F = -M2/R2")[15:]
    '<span style="white-space:nowrap"><i>F</i> = -<i>M</i><sub>2</sub>/<i>R</i><sub>2</sub></span>'
    >>> label_html("hoop stress, sigma_min")
    'hoop stress, <i>&sigma;</i><sub>min</sub>'
    >>> label_html("acceleration = 0.5 m/s^2, inertia = 3 kg*m^2")
    'acceleration = 0.5 m/s², inertia = 3 kg·m²'
    """
    return printed_unit(_FORMULA.sub(lambda match: _formula(match[0]), escape(text)))


def _formula(text: str) -> str:
    """Return the HTML of a formula, which is not broken between its words."""
    # a minus before a symbol is no part of the symbol; a "-" alone is an operator
    signed = [("-" if word[0] == "-" and len(word) > 1 else "", word) for word in text.split(" ")]
    words = " ".join(sign + symbol_html(word.removeprefix(sign)) for sign, word in signed)
    return f'<span style="white-space:nowrap">{words}</span>' if " " in text else words


def unit_html(unit: str) -> str:
    """Return a unit, or a number with its unit, as it is printed.

    >>> unit_html("kg/m^3"), unit_html("a < b")
    ('kg/m³', 'a &lt; b')
    """
    return printed_unit(escape(unit))


# ---- tables -------------------------------------------------------------------------------------


def _breakable(name: str) -> str:
    """Return a dotted name, which may be broken after a dot or an underscore."""
    return re.sub(r"([._])", r"\1<wbr>", escape(name))


def _number(text: str) -> str:
    """Return a number with its unit as printed, or a list of them, which may be broken.

    >>> _number("350 N/m"), _number("1, 2 um")
    ('350 N/m', '<span class="list">1, 2&nbsp;µm</span>')
    >>> _number("9 values, 1 to 2 mil")
    '<span class="list">9&nbsp;values, 1&nbsp;to 2&nbsp;mil</span>'
    """
    if ", " not in text:
        return unit_html(text)
    items = ", ".join(unit_html(item).replace(" ", "&nbsp;") for item in text.split(", "))
    items = items.replace("&nbsp;to&nbsp;", "&nbsp;to ")  # a range may be broken too
    return f'<span class="list">{items}</span>'


# of each kind of column: HTML of a text, and style
CELLS: Mapping[str, tuple[Callable[[str], str], str]] = {
    "words": (label_html, LEFT),
    "phrase": (label_html, f"{LEFT};white-space:nowrap"),
    "name": (_breakable, LEFT),
    "symbol": (symbol_html, f"{LEFT};white-space:nowrap"),
    "number": (_number, f"{RIGHT};white-space:pre"),
    "unit": (unit_html, f"{LEFT};white-space:nowrap"),
}


def table_html(table: Table) -> str:
    """Return a table under its title; remarks on a row are below it."""
    caption = f'<caption style="{LEFT};font-weight:bold">{label_html(table.title)}</caption>'
    head = "".join(
        f'<th style="{RIGHT if kind == "number" else LEFT}">{label_html(word)}</th>'
        for word, kind in table.columns
    )
    head = f"<thead><tr>{head}</tr></thead>" if any(c.head for c in table.columns) else ""
    kinds = [column.kind for column in table.columns]
    body = "\n".join(_row(row, kinds) for row in table.rows)
    return f"<table>{caption if table.title else ''}{head}<tbody>\n{body}\n</tbody></table>"


def _row(row: TableRow, kinds: Sequence[str]) -> str:
    """Return the HTML of a row of a table, and of the remarks below it.

    ``kinds`` are those of the columns; see :class:`~.report_parts.Column`.
    """
    cells = []
    for text, kind in zip(row.cells, kinds, strict=True):
        to_html, style = CELLS[kind]
        # the remarks belong to the row
        cells.append((to_html(text), f"{style};border-bottom:0" if row.below else style))
    if row.tone == "bad":
        text, style = cells[-1]
        cells[-1] = f'<span style="{ALARM}">{text}</span>', style
    mark = ' class="differs"' if row.tone == "differs" else ""
    line = "".join(f'<td style="{style}">{text}</td>' for text, style in cells)
    below = f'<td colspan="{len(cells)}" style="{LEFT};{QUIET}">{label_html(row.below)}</td>'
    return f"<tr{mark}>{line}</tr>" + (f"\n<tr>{below}</tr>" if row.below else "")


def _strips(part: ZoneStrips) -> str:
    """Return bars along the contact with the name of each face and a legend of its zones."""
    rows = []
    for face, zones in part.faces.items():
        long = part.x[-1] - part.x[0]
        bars = "".join(
            f'<span title="{escape(part.words[zone])}" style="display:inline-block;height:1em;'
            f'background:{_ZONES[zone]};width:{100 * (right - left) / long:.2f}%"></span>'
            for zone, left, right in zone_runs(part.x, zones)
        )
        bar = f'<td style="width:30em;font-size:0.9em;white-space:nowrap">{bars}</td>'
        rows.append(f'<tr><td style="{LEFT}">{escape(face)}</td>{bar}</tr>')
    key = " &emsp; ".join(
        f'<span style="display:inline-block;width:1em;height:0.8em;background:{_ZONES[zone]}">'
        f"</span> {escape(word)}"
        for zone, word in part.words.items()
    )
    title = f'<caption style="{LEFT};font-weight:bold">{part.TITLE}</caption>'
    table = "<table>{}<tbody>\n{}\n</tbody></table>".format(title, "\n".join(rows))
    return f'{table}<p style="margin:0.3em 0">{key}</p>'
