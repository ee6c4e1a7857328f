"""A report to file: one HTML page that stands alone, prints well, and says where it comes from.

Of one state or of several beside each other: inputs with units and sources, results with errors
and certificate, figures, warnings, version and date, and room for remarks.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from datetime import datetime
from html import escape
from typing import Any

from .. import __version__, kinds
from ..errors import InvalidProblem
from ..problems.fields import Description
from ..problems.materials import MATERIALS
from ..quantities import Place, scalar_outputs, walk
from ..results import Result
from .figures import figure_bytes
from .html import parts_html
from .parts import Row, output_row, row_of
from .plots import plotted
from .report import report_parts

__all__ = ["report_file"]

_STYLE = """\
:root { color-scheme: light; }
body { font: 10.5pt/1.4 "DejaVu Sans", "Segoe UI", Helvetica, Arial, sans-serif; color: #111;
  background: #fff; max-width: 180mm; margin: 12mm auto; padding: 0 6mm; }
h1 { font-size: 18pt; margin: 0 0 1mm; }
h2 { font-size: 13pt; margin: 8mm 0 2mm; border-bottom: 0.3mm solid #0072B2; break-after: avoid; }
h3 { font-size: 11pt; margin: 5mm 0 1mm; break-after: avoid; }
p.about { margin: 0 0 4mm; color: #444; }
table { border-collapse: collapse; margin: 2mm 0 4mm; width: 100%; font-size: 9pt; }
caption { text-align: left; font-weight: bold; padding: 1mm 0; break-after: avoid; }
th, td { text-align: left; padding: 0.7mm 2mm 0.7mm 0; border-bottom: 0.2mm solid #ccc;
  vertical-align: top; }
th { border-bottom: 0.4mm solid #555; }
td.n, th.n { text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap; }
tr, figure { break-inside: avoid; }
thead { display: table-header-group; }
figure { margin: 3mm 0; }
figure svg { width: 100%; height: auto; max-height: 230mm; }
p.warning { border-left: 1mm solid #D55E00; padding-left: 2mm; }
div.remarks { min-height: 45mm; border: 0.3mm solid #999; padding: 2mm 3mm; white-space: pre-wrap;
  break-inside: avoid; }
footer { margin-top: 8mm; font-size: 8.5pt; color: #444; }
@page { size: A4; margin: 15mm; }
@media print { body { margin: 0; padding: 0; max-width: none; } }
"""


def report_file(
    results: Sequence[Result],
    labels: Sequence[str] = (),
    *,
    title: str = "",
    remarks: str = "",
    sources: Sequence[str] = (),
    written: datetime | None = None,
) -> str:
    """Return a report of solved states as an HTML page.

    Parameters
    ----------
    results : sequence of Result
        One, or several to compare.
    labels : sequence of str
        What several are called.
    title, remarks : str
    sources : sequence of str
        Where each case comes from, e.g. its file.
    written : datetime, optional
        The report's date; now where None.

    Raises
    ------
    InvalidProblem
        For no result, or labels that are not as many.
    """
    if not results:
        raise InvalidProblem.at("results", "there is none to report")
    names = list(labels) or [f"State {k}" for k in range(1, len(results) + 1)]
    if len(names) != len(results):
        raise InvalidProblem.at("labels", f"{len(names)} labels; must be {len(results)}")
    title = title or " and ".join(dict.fromkeys(_title(result) for result in results))
    when = (written or datetime.now()).strftime("%Y-%m-%d %H:%M")
    body = "\n".join([
        f"<h1>{escape(title)}</h1>",
        f'<p class="about">woundon {escape(__version__)}, {escape(when)}{_from(sources)}</p>',
        *(_comparison(results, names) if len(results) > 1 else ()),
        *_states(results, names),
        "<h2>Remarks</h2>",
        f'<div class="remarks">{escape(remarks)}</div>',
        _footer(results),
    ])  # fmt: skip
    return (f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
            f'<meta name="viewport" content="width=device-width">'
            f"<title>{escape(title)}</title><style>\n{_STYLE}</style></head>\n"
            f"<body>\n{body}\n</body></html>\n")  # fmt: skip


def _title(result: Result) -> str:
    return kinds.of(result).about.rstrip(".")


def _from(sources: Sequence[str]) -> str:
    return f", from {escape(', '.join(sources))}" if sources else ""


def _states(results: Sequence[Result], names: Sequence[str]) -> Iterator[str]:
    """Yield inputs, results and figure of each state."""
    for result, name in zip(results, names, strict=True):
        several = len(results) > 1
        yield f"<h2>{escape(name)}: inputs</h2>" if several else "<h2>Inputs</h2>"
        yield _inputs(result.problem)
        yield f"<h2>{escape(name)}: results</h2>" if several else "<h2>Results</h2>"
        yield parts_html(report_parts(result))
        if not several:
            yield from _figure([result], None)
    if len(results) > 1:
        yield "<h2>Figures</h2>"
        yield from _figure(results, names)


# ---- inputs -----------------------------------------------------------------------------------


def _inputs(problem: Description) -> str:
    """Return a table of every field, with units; of named materials their source."""
    rows = [_cells(place.path, _row(place)) for place in walk(problem)]
    head = '<tr><th>field</th><th>meaning</th><th>symbol</th><th class="n">value</th><th></th></tr>'
    text = f"<table><thead>{head}</thead><tbody>{''.join(rows)}</tbody></table>"
    for path, name in _named(problem):
        source = MATERIALS[name].source
        text += f"<p>{escape(path)}: the named material {escape(name)!r}; {escape(source)}</p>"
    return text


def _row(place: Place) -> Row:
    if place.quantity is not None and isinstance(place.value, tuple):
        shown = ", ".join(f"{place.quantity.shown(value):.5g}" for value in place.value)
        return Row(place.quantity.meaning, place.quantity.symbol, shown, place.quantity.display)
    if place.quantity is None or not isinstance(place.value, int | float):
        quantity = place.quantity
        told = "not given" if place.value is None else str(place.value)
        return Row(quantity.meaning if quantity else "", quantity.symbol if quantity else "", told)
    return row_of(place.quantity, place.value)


def _cells(path: str, row: Row) -> str:
    cells = (path, row.meaning, row.symbol, row.value_text, row.unit)
    kinds_of_cell = ("", "", "", ' class="n"', "")
    told = (f"<td{k}>{escape(c)}</td>" for c, k in zip(cells, kinds_of_cell, strict=True))
    return f"<tr>{''.join(told)}</tr>"


def _named(thing: Any, path: str = "") -> Iterator[tuple[str, str]]:
    """Yield where a named material stands, and its name."""
    for name, known in MATERIALS.items():
        if thing == known.material:
            yield path, name
            return
    inner: dict[Any, Any] = dict(enumerate(thing)) if isinstance(thing, tuple) else {}
    if isinstance(thing, Description):
        inner = {name: getattr(thing, name) for name in type(thing).model_fields}
    for key, value in inner.items():
        yield from _named(value, f"{path}.{key}".strip("."))


# ---- several states ---------------------------------------------------------------------------


def _comparison(results: Sequence[Result], names: Sequence[str]) -> Iterator[str]:
    """Yield what the states differ in, and their outputs with the differences from the first."""
    yield "<h2>Comparison</h2>"
    yield _table("Inputs that differ", names, _differing(results))
    yield _table("Results, and their change from the first", names, _outputs(results))


def _differing(results: Sequence[Result]) -> Iterator[tuple[str, list[str]]]:
    told = [{place.path: place for place in walk(result.problem)} for result in results]
    for path in dict.fromkeys(path for one in told for path in one):
        values = [one[path].value if path in one else None for one in told]
        if len({repr(value) for value in values}) > 1:
            rows = [_row(one[path]) if path in one else Row("", "", "-") for one in told]
            yield path, [f"{row.value_text} {row.unit}".strip() for row in rows]


def _outputs(results: Sequence[Result]) -> Iterator[tuple[str, list[str]]]:
    known = [scalar_outputs(result) for result in results]
    for name in known[0]:
        if name == "residual" or name.endswith("_error") or not all(name in one for one in known):
            continue
        rows = [output_row(result, name) for result in results]
        first, *others = rows
        cells = [_with_error(first)]
        for row in others:
            change = float(row.value) - float(first.value)
            share = f", {change / abs(float(first.value)):+.2%}" if float(first.value) else ""
            cells.append(f"{_with_error(row)} ({change:+.4g}{share})")
        yield f"{first.meaning} ({first.symbol}){f' [{first.unit}]' if first.unit else ''}", cells


def _with_error(row: Row) -> str:
    return f"{row.value_text} ± {row.error_text}" if row.error_text else row.value_text


def _table(title: str, names: Sequence[str], rows: Iterator[tuple[str, list[str]]]) -> str:
    head = "".join(f'<th class="n">{escape(name)}</th>' for name in names)
    body = ""
    for label, cells in rows:
        told = "".join(f'<td class="n">{escape(cell)}</td>' for cell in cells)
        body += f"<tr><td>{escape(label)}</td>{told}</tr>"
    return (f"<table><caption>{escape(title)}</caption><thead><tr><th></th>{head}</tr></thead>"
            f"<tbody>{body}</tbody></table>")  # fmt: skip


# ---- figures and foot -------------------------------------------------------------------------


def _figure(results: Sequence[Result], names: Sequence[str] | None) -> Iterator[str]:
    """Yield the states' figure as inline SVG; nothing for kinds that have none in common."""
    try:
        drawn = figure_bytes(plotted(results, labels=names), ".svg").decode()
    except InvalidProblem as fault:
        yield f"<p>{escape(str(fault))}</p>"
        return
    svg = drawn[drawn.index("<svg") :]
    # what a browser reads inside a page is HTML: no outside addresses, none that run
    svg = re.sub(r"<metadata>.*?</metadata>", "", svg, flags=re.DOTALL)
    yield f'<figure role="img" aria-label="the states drawn">{svg}</figure>'


def _footer(results: Sequence[Result]) -> str:
    laws = ", ".join(f"{result.residual:.1e}" for result in results)
    return (f"<footer>Computed by woundon {escape(__version__)}; largest residual of the contact "
            f"laws: {laws}. Errors (±) are the estimated errors of discretisation; those of the "
            "model and of the inputs come on top.</footer>")  # fmt: skip
