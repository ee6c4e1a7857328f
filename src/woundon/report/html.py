"""Reports as HTML tables for notebooks, in their light or dark colours.

Every text is escaped.  Letters and grounds have no colour here, they take those of the page; only
marks have one, of zones and of a limit that is not kept.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from html import escape
from typing import TYPE_CHECKING

from ..results import zone_runs
from .report_parts import GREEK, SYMBOL, Line, Part, Row, Section, Verdict, Verdicts, ZoneStrips

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["label_html", "parts_html", "symbol_html", "table_html", "unit_html"]

LEFT = "text-align:left"
RIGHT = "text-align:right"
QUIET = "opacity:0.75"
ALARM = "display:inline-block;background:#B00020;color:#FFFFFF;font-weight:bold;padding:0 0.4em"
_ZONES = {-1: "#E69F00", 0: "#BBBBBB", 1: "#56B4E9"}


def table_html(head: str, frame: pd.DataFrame, remarks: Iterable[str]) -> str:
    """Return the HTML of a section: heading, table of numbers, remarks."""
    table = frame.to_html(float_format="{:.4g}".format, na_rep="")
    return _division([_paragraph(head), table, *map(_paragraph, remarks)])


def parts_html(parts: Iterable[Part]) -> str:
    """Return the parts of a report."""
    return _division([_part(part) for part in parts])


def _division(texts: Sequence[str]) -> str:
    return "<div>\n{}\n</div>".format("\n".join(texts))


def _part(part: Part) -> str:
    """Return the HTML of a part of a report."""
    if isinstance(part, Section):
        return _section(part)
    if isinstance(part, Verdicts):
        return _verdicts(part)
    return _strips(part) if isinstance(part, ZoneStrips) else _line(part)


def _paragraph(text: str, style: str = "") -> str:
    return f'<p style="margin:0.3em 0;{style}">{label_html(text)}</p>'


def _line(line: Line) -> str:
    loud = {"quiet": QUIET, **dict.fromkeys(("answer", "warning", "bad"), "font-weight:bold")}
    return _paragraph(line.text, loud.get(line.tone, ""))


def _section(section: Section) -> str:
    """Return the HTML of a section: a table, and a text below it."""
    paragraph = _paragraph(section.text, QUIET) if section.text else ""
    return _table(section.title, map(_row, section.rows)) + paragraph


def _table(title: str, rows: Iterable[str], head: str = "") -> str:
    """Return a table under a title from the HTML of its rows and of its head."""
    caption = f'<caption style="{LEFT};font-weight:bold">{escape(title)}</caption>'
    body = "\n".join(rows)
    return f"<table>{caption}{head}<tbody>\n{body}\n</tbody></table>"


def _cells(cells: Iterable[tuple[str, str]], tag: str = "td") -> str:
    """Return the cells of a row from the HTML and the style of each."""
    return "".join(f'<{tag} style="{style}">{text}</{tag}>' for text, style in cells)


def symbol_html(symbol: str) -> str:
    """Return a symbol with Greek letters, index and exponent; quotients have a symbol on each side.

    >>> symbol_html("mu+ p"), symbol_html("T_in")
    ('<i>&mu;</i><sup>+</sup> <i>p</i>', '<i>T</i><sub>in</sub>')
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
    subscript, superscript = subscript and f"<sub>{subscript}</sub>", sign and f"<sup>{sign}</sup>"
    return f"{factor}{letter}{subscript}{superscript}"


# A symbol within words: "T_in", "mu+", "M2", "F"; not the article "A", units as in "2 N" and "N/m",
# or names as "web_tension".
_LETTER = r"(?<!\d )[B-Z]\d?(?!\w|/[a-z])"
_ONE = rf"(?:[A-Za-z]_\w{{1,3}}\b|(?:{'|'.join(sorted(GREEK))})\b[+-]?|{_LETTER})"
_TERM = rf"-?{_ONE}(?:/{_ONE})?"
# symbols on their own, or with operators between them: "WOT - T_in", "F = -M2/R2"
_FORMULA = re.compile(rf"(?<![\w.'=/-])(?:(?:{_TERM}|WOT|NIT) [=+-] )*{_TERM}")


def label_html(text: str) -> str:
    """Return a text whose formulas are typeset, and not broken.

    >>> label_html("nip-induced tension, WOT - T_in")
    'nip-induced tension, <span style="white-space:nowrap">WOT - <i>T</i><sub>in</sub></span>'
    >>> label_html("winding force, F = -M2/R2")[15:]
    '<span style="white-space:nowrap"><i>F</i> = -<i>M</i><sub>2</sub>/<i>R</i><sub>2</sub></span>'
    """
    return _FORMULA.sub(lambda match: _formula(match[0]), escape(text))


def _formula(text: str) -> str:
    signed = [("-" if word[0] == "-" and len(word) > 1 else "", word) for word in text.split(" ")]
    words = " ".join(sign + symbol_html(word.removeprefix(sign)) for sign, word in signed)
    return f'<span style="white-space:nowrap">{words}</span>' if " " in text else words


# units as they are printed
_UNITS = (("um", "µm"), ("**0.5", "<sup>1/2</sup>"), ("*", "·"))


def unit_html(unit: str) -> str:
    """Return a unit as it is printed.

    >>> unit_html("um"), unit_html("kg/m^3"), unit_html("Pa/m**0.5")
    ('µm', 'kg/m<sup>3</sup>', 'Pa/m<sup>1/2</sup>')
    """
    text = escape(unit)
    for name, printed in _UNITS:
        text = text.replace(name, printed)
    return re.sub(r"\^(\d)", r"<sup>\1</sup>", text)


def _row(row: Row) -> str:
    """Return the HTML of a row: meaning, symbol, value, unit and error."""
    error = f" ± {row.error_text}" if row.error_text else ""
    unit = f'<span style="white-space:nowrap">{unit_html(row.unit)}{escape(error)}</span>'
    cells = [
        (label_html(row.meaning), LEFT),
        (symbol_html(row.symbol), f"{LEFT};white-space:nowrap"),
        (row.value_text, RIGHT),
        (unit + escape(row.note), LEFT),
    ]
    return f"<tr>{_cells(cells)}</tr>"


def _verdicts(part: Verdicts) -> str:
    """Return the HTML of a table of limits; the remarks on each are below it."""
    sides = (LEFT, RIGHT, RIGHT, *[LEFT] * 3)
    head = _cells(zip(("", *part.HEAD), sides, strict=True), "th")
    return _table(part.title, map(_verdict, part.rows), f"<thead><tr>{head}</tr></thead>")


def _verdict(row: Verdict) -> str:
    """Return the HTML of a row of a table of limits, and of the remarks below it."""
    word = escape(row.word)
    word = f'<span style="{ALARM}">{word}</span>' if row.tone == "bad" else word
    left, right = (f"{side};white-space:nowrap;border-bottom:0" for side in (LEFT, RIGHT))
    cells = [
        (escape(row.meaning), f"{LEFT};border-bottom:0"),
        (escape(row.value), right),
        (escape(row.limit), right),
        (unit_html(row.unit), left),
        (escape(row.place), left),
        (word, left),
    ]
    below = f'<td colspan="{len(cells)}" style="{LEFT};{QUIET}">{escape(row.below)}</td>'
    return f"<tr>{_cells(cells)}</tr>\n<tr>{below}</tr>"


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
    table = _table(part.TITLE, rows)
    return f'{table}<p style="margin:0.3em 0">{key}</p>'
