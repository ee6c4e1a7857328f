"""What goes in and out of the page: case files, scripts, result files, pictures, reports.

These run in workers.  Case files are read from the text that is sent; no path is ever opened.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from typing import Any

from .. import kinds
from ..errors import InvalidProblem, did_you_mean
from ..io.case_files import make_problem, tables_of_text
from ..io.case_texts import to_toml
from ..io.chosen_units import units
from ..io.python_texts import to_python
from ..io.result_files import writer_for
from ..problems.messages import quote
from .answers import as_json, fields_of, problem_of, solved
from .catalogue import LIMITS, exhibits, tables_of

__all__ = ["exhibit", "figure", "python_text", "read_case", "report", "result_file", "written_case"]


def read_case(body: Any) -> bytes:
    """Return the tables that the text of a case file says, complete and in SI."""
    text = fields_of(body, "toml").get("toml")
    if not isinstance(text, str):
        raise InvalidProblem.at("toml", f"must be the text of a case file, got {quote(text)}")
    tables = tables_of_text(text.encode("utf-8", "replace"), "the file")
    _refuse_files(tables)
    problem = make_problem(tables)
    return as_json({"kind": kinds.of(problem).name, "problem": tables_of(problem)})


def _refuse_files(part: Any, path: str = "") -> None:
    """Refuse tables whose columns stand in a file beside the case: that is on another machine."""
    inner = part.items() if isinstance(part, Mapping) else enumerate(part)
    for name, value in inner:
        if name == "csv":
            text = "files beside a case are not read here; write the columns into the case"
            raise InvalidProblem.at(f"{path}csv", text)
        if isinstance(value, Mapping | list):
            _refuse_files(value, f"{path}{name}.")


def written_case(tables: Any) -> bytes:
    """Return the case file of a case, with comments."""
    return to_toml(problem_of(tables), comments=True).encode()


def python_text(tables: Any) -> bytes:
    """Return the Python script that computes a case."""
    return to_python(problem_of(tables)).encode()


def result_file(tables: Any, ending: str, options: Mapping[str, Any]) -> bytes:
    """Return the solved case as a result file, SI units."""
    return writer_for(f"result.{ending}")(solved(problem_of(tables), options))


def figure(body: Any, ending: str, panels: Sequence[str]) -> bytes:
    """Return a picture of solved cases."""
    from ..report.figures import figure_bytes
    from ..report.plots import plotted

    asked = fields_of(body, "cases", "units")
    results, labels = _cases(asked)
    with _units(asked):
        drawn = plotted(results, labels=labels if len(labels) > 1 else None, panels=panels or None)
        return figure_bytes(drawn, f".{ending}")


def report(body: Any) -> bytes:
    """Return the report of solved cases: one HTML file that stands alone."""
    from ..report.html_report import report_file

    asked = fields_of(body, "cases", "units", "title", "remarks")
    for name in ("title", "remarks"):
        if not isinstance(asked.get(name, ""), str):
            raise InvalidProblem.at(name, f"must be a text, got {quote(asked[name])}")
    results, labels = _cases(asked)
    with _units(asked):
        return report_file(
            results, labels, title=asked.get("title", ""), remarks=asked.get("remarks", "")
        ).encode()


def exhibit(name: str) -> bytes:
    """Return a figure of a plug-in, computed now, as SVG."""
    owners = {one["name"]: plugin for plugin in exhibits() for one in plugin.known()}
    if name not in owners:
        raise InvalidProblem.at("name", f"{quote(name)} is unknown{did_you_mean(name, owners)}")
    drawn: bytes = owners[name].drawn(name)
    return drawn


# ---- what is asked ----------------------------------------------------------------------------


def _cases(asked: Mapping[str, Any]) -> tuple[list[Any], list[str]]:
    """Return the solved cases and their labels."""
    given = asked.get("cases")
    if not isinstance(given, list) or not 1 <= len(given) <= LIMITS["compare"]:
        text = f"must be a list of 1 to {LIMITS['compare']} cases, got {quote(given)}"
        raise InvalidProblem.at("cases", text)
    results, labels = [], []
    for k, entry in enumerate(given):
        try:
            told = fields_of(entry, "label", "case")
            label = told.get("label", "ABCD"[k])
            if not isinstance(label, str):
                raise InvalidProblem.at("label", f"must be a text, got {quote(label)}")
            results.append(solved(problem_of(told.get("case")), {}))
        except InvalidProblem as fault:
            raise fault.under(f"cases.{k}") from None
        labels.append(label[:80])
    return results, labels


def _units(asked: Mapping[str, Any]) -> AbstractContextManager[None]:
    chosen = asked.get("units") or {}
    if not isinstance(chosen, Mapping) or not all(isinstance(v, str) for v in chosen.values()):
        raise InvalidProblem.at("units", f"must be a table of names and units, got {quote(chosen)}")
    return units(chosen) if chosen else nullcontext()
