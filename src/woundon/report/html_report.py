"""The report file: a self-contained, printable HTML page with its provenance.

Of one state or of several: the answer with warnings and certificate, figures, results with errors,
inputs with units and sources, version and date, and room for remarks.  A state takes at most two
A4 pages; a winding three with more than two columns of panels, four with more than four.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from datetime import datetime
from html import escape
from importlib import resources
from math import isnan
from typing import Any

from matplotlib.figure import Figure

from .. import __version__, kinds
from ..errors import InvalidProblem
from ..problems.description import Description
from ..problems.materials import MATERIALS
from ..problems.problem import Problem
from ..quantities import Place, quantity_of, scalar_outputs, walk
from ..results import Result
from .figures import figure_bytes
from .html import parts_html, table_html
from .outputs_report import LEFT_OUT, not_applicable
from .plots import figures_of_columns
from .report_parts import (
    Column,
    Line,
    Part,
    Row,
    Section,
    Table,
    TableRow,
    ZoneStrips,
    output_row,
    value_row,
)
from .result_report import report_parts
from .scale_drawing import scale_drawing

__all__ = ["report_file"]

# A column of panels is printed at half of its width; in a smaller figure its letters are larger.
PRINTED = 0.88
# Of more than two columns, which do not fit next to each other, the panels are less high.
LOW = 0.8
# of a drawing, what is no part of the picture
_APART = re.compile(r"<metadata>.*?</metadata>|<!--.*?-->", re.DOTALL)


def report_file(
    results: Sequence[Result],
    labels: Sequence[str] = (),
    *,
    title: str = "",
    remarks: str = "",
    sources: Sequence[str] = (),
) -> str:
    """Return a report of solved cases, the states, as an HTML page.

    Parameters
    ----------
    results : sequence of Result
        One, or several to compare.
    labels : sequence of str
        Names of the cases.
    title, remarks : str
    sources : sequence of str
        Where each case comes from, e.g. its file.

    Raises
    ------
    InvalidProblem
        Without results, or if the number of labels differs.
    """
    if not results:
        raise InvalidProblem.at("results", "there is none to report")
    names = list(labels) or [f"State {k}" for k in range(1, len(results) + 1)]
    if len(names) != len(results):
        raise InvalidProblem.at("labels", f"{len(names)} labels; must be {len(results)}")
    title = title or " and ".join(dict.fromkeys(kinds.of(r).about.rstrip(".") for r in results))
    origin = f", from {escape(', '.join(sources))}" if sources else ""
    date = datetime.now().strftime("%Y-%m-%d %H:%M")
    style = (resources.files(__package__) / "report_file.css").read_text("utf-8")
    parts = [report_parts(result) for result in results]
    body = "\n".join(
        [
            f"<h1>{escape(title)}</h1>",
            f'<p class="about">woundon {__version__}, {escape(date)}{origin}</p>',
            *_answers(parts, names),
            *_figure(results, names),
            *(_comparison(results, names) if len(results) > 1 else ()),
            *_results(parts, names),
            *_inputs(results, names),
            _footer(results),
            "<h2>Remarks</h2>",
            f'<div class="remarks">{escape(remarks)}</div>',
        ]
    )
    return (
        f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        f'<meta name="viewport" content="width=device-width">'
        f"<title>{escape(title)}</title><style>\n{style}</style></head>\n"
        f"<body>\n{body}\n</body></html>\n"
    )


def _answers(reports: Sequence[Sequence[Part]], names: Sequence[str]) -> Iterator[str]:
    """Yield the answer, the warnings and the certificate of each case from its report."""
    for parts, name in zip(reports, names, strict=True):
        if len(reports) > 1:
            yield f"<h2>{escape(name)}</h2>"
        yield parts_html([p for p in parts if isinstance(p, Line) and p.tone != "quiet"])


def _results(reports: Sequence[Sequence[Part]], names: Sequence[str]) -> Iterator[str]:
    """Yield the sections of the report of each case, tables of values in two columns."""
    for parts, name in zip(reports, names, strict=True):
        yield f"<h2>{escape(name)}: results</h2>" if len(reports) > 1 else "<h2>Results</h2>"
        sections = parts_html([part for part in parts if isinstance(part, Section)])
        yield f'<div class="columns">{sections}</div>'
        yield parts_html([p for p in parts if isinstance(p, Table | ZoneStrips)])


# ---- inputs -----------------------------------------------------------------------------------


def _inputs(results: Sequence[Result], names: Sequence[str]) -> Iterator[str]:
    """Yield a table of all fields, differences marked, and the sources of named materials."""
    yield "<h2>Inputs</h2>"
    fields = [{place.path: place for place in walk(result.problem)} for result in results]
    rows = []
    omitted = []
    for path in dict.fromkeys(path for places in fields for path in places):
        if all(
            path not in places or _is_omitted(result.problem, places[path])
            for result, places in zip(results, fields, strict=True)
        ):
            omitted.append(path)
            continue
        cases = [
            value_row(places[path].quantity, places[path].value) if path in places else None
            for places in fields
        ]
        values = [row.text if row else "-" for row in cases]
        first = next(row for row in cases if row)
        tone = "differs" if len(set(values)) > 1 else ""
        rows.append(TableRow((path, _meaning(first, path, fields), first.symbol, *values), tone))
    columns: tuple[Column, ...] = (
        Column("field", "name"),
        Column("meaning"),
        Column("symbol", "symbol"),
    )
    heads = names if len(names) > 1 else ["value"]
    columns = (*columns, *(Column(head, "number") for head in heads))
    table = table_html(Table("", columns, tuple(rows)))
    yield f'<div class="columns inputs">{table}</div>' if len(names) == 1 else table
    if omitted:
        text = f"Not given, or zero and without effect: {', '.join(omitted)}."
        yield f'<p class="source">{escape(text)}</p>'
    sources = dict.fromkeys(
        material for result in results for material in _named_materials(result.problem)
    )
    for path, name in sources:
        source = f"{path}: the named material {name}; {MATERIALS[name].source}"
        yield f'<p class="source">{escape(source)}</p>'


def _meaning(row: Row, path: str, fields: Sequence[Mapping[str, Place]]) -> str:
    """Return the meaning of a field: that of its quantity, or else its description.

    ``fields`` are those of each case by their path.
    """
    field = next(places[path] for places in fields if path in places).field
    quantity = quantity_of(field)  # of a word in place of a number
    return row.meaning or field.description or (quantity.meaning if quantity else "")


def _is_omitted(problem: Problem, place: Place) -> bool:
    """Return True for a field without a value, or with the value zero and without effect.

    Another value of a field without effect may have been entered, and is shown.
    """
    if place.value is None or place.value == ():
        return True
    return place.path in problem.unused and place.value == 0


def _named_materials(thing: Any, path: str = "") -> Iterator[tuple[str, str]]:
    """Yield path and name of each named material in a problem or a part of it at ``path``."""
    for name, known in MATERIALS.items():
        if thing == known.material:
            yield path, name
            return
    inner: dict[Any, Any] = dict(enumerate(thing)) if isinstance(thing, tuple) else {}
    if isinstance(thing, Description):
        inner = {name: getattr(thing, name) for name in type(thing).model_fields}
    for key, value in inner.items():
        yield from _named_materials(value, f"{path}.{key}".strip("."))


# ---- several states ---------------------------------------------------------------------------


def _comparison(results: Sequence[Result], names: Sequence[str]) -> Iterator[str]:
    """Yield a table of the common outputs with the differences from the first case."""
    yield "<h2>Comparison</h2>"
    columns = (Column(), Column("symbol", "symbol"), *(Column(name, "number") for name in names))
    yield table_html(Table("", columns, tuple(_outputs(results))))
    yield f'<p class="source">Below a value: how far it is from that of {escape(names[0])}.</p>'


def _outputs(results: Sequence[Result]) -> Iterator[TableRow]:
    """Yield the rows of the outputs that all results have, with the differences from the first."""
    known = [scalar_outputs(result) for result in results]
    left_out = LEFT_OUT.union(
        {f"{name}_error" for name in results[0].errors},
        *(not_applicable(result.problem) for result in results),
    )
    # the kind's main outputs first
    for name in dict.fromkeys((*results[0].MAIN, *known[0])):
        if name in left_out or not all(name in outputs for outputs in known):
            continue
        first, *others = [output_row(result, name) for result in results]
        if isnan(float(first.value)):  # there is no such thing here, as losses of elastic bodies
            continue
        cells = [_with_error(first)]
        cells += [f"{_with_error(row)}\n{_difference(first, row)}" for row in others]
        unit = f" [{first.unit}]" if first.unit else ""
        yield TableRow((f"{first.meaning}{unit}", first.symbol, *cells))


def _difference(first: Row, row: Row) -> str:
    """Return the difference of a value from the first one, absolute and relative.

    A relative one that would be rounded to 0.0 % is given as an upper bound.
    """
    change, whole = float(row.value) - float(first.value), abs(float(first.value))
    if not whole:
        return f"{change:+.3g}"
    share = f"{change / whole:+.1%}" if abs(change) >= 5e-4 * whole else "< 0.1%"
    return f"{change:+.3g} ({share})"


def _with_error(row: Row) -> str:
    """Return the value of a row with its error estimate, if there is one."""
    return f"{row.value_text} ± {row.error_text}" if row.error_text else row.value_text


# ---- figures and foot -------------------------------------------------------------------------


def _figure(results: Sequence[Result], names: Sequence[str]) -> Iterator[str]:
    """Yield the figure of the cases as inline SVG; nothing for kinds without common panels."""
    try:
        figures = figures_of_columns(results, names, PRINTED, LOW)
    except InvalidProblem as fault:
        yield f"<p>{escape(str(fault))}</p>"
        return
    drawing = scale_drawing(results[0]) if len(results) == 1 else None
    if drawing is not None:
        yield _inline(drawing, "drawing to scale", 0)
    # of three the last one stands next to the other two
    yield f'<div class="{"three" if len(figures) == 3 else "figures"}">'
    for number, (names_of_panels, figure) in enumerate(figures, 1):
        yield _inline(figure, names_of_panels, number)
    yield "</div>"


def _inline(figure: Figure, label: str, number: int) -> str:
    """Return a figure as SVG with a label for screen readers.

    Names of its parts begin with its number: they may not occur twice in a page.
    """
    image = figure_bytes(figure, ".svg").decode()
    svg = _APART.sub("", image[image.index("<svg") :])
    svg = re.sub(r'(id="|url\(#|href="#)', rf"\g<1>f{number}-", svg)
    return f'<figure role="img" aria-label="{escape(label)}">{svg}</figure>'


def _footer(results: Sequence[Result]) -> str:
    """Return the footer: version, the largest residual of each case, and what errors include."""
    residuals = ", ".join(f"{result.residual:.1e}" for result in results)
    return (
        f"<footer>Computed by woundon {escape(__version__)}; largest residual of the "
        f"conditions: {residuals}. Errors (±) are the estimated errors of discretisation; those of "
        "the model and of the inputs come on top.</footer>"
    )
