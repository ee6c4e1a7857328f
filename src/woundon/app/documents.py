"""Case files, scripts, result files, figures and reports: functions that run in workers.

The tables of a case are its fields as in a case file; they arrive as JSON.
Case files are read from the text that is sent; no path is ever opened.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager
from typing import Any

from .. import kinds, plugins
from ..errors import InvalidProblem, did_you_mean
from ..io.case_files import make_problem, names_of_files, tables_of_text
from ..io.case_texts import to_toml
from ..io.chosen_units import units, units_of
from ..io.python_texts import to_python
from ..io.result_files import writer_for
from ..problems.messages import quote
from .computations import problem_of, solved
from .input_forms import tables_of
from .json_texts import to_json

__all__ = ["case_file", "exhibit", "figure", "python_text", "read_case", "report", "result_file"]


def read_case(text: str) -> bytes:
    """Return the tables of the text of a case file, complete and in SI, as JSON."""
    tables = tables_of_text(text.encode("utf-8", "replace"), "the file")
    _reject_files(tables)
    problem = make_problem(tables, needs_schema=True)
    return to_json({"kind": kinds.of(problem).name, "problem": tables_of(problem)})


def _reject_files(tables: Mapping[str, Any]) -> None:
    """Reject tables whose columns are in another file, which is on the client's machine."""
    for name in names_of_files(tables):
        text = "other files are not read here; write the columns into the case"
        raise InvalidProblem.at(name, text)


def case_file(tables: Mapping[str, Any]) -> bytes:
    """Return the case file of a case, with comments."""
    return to_toml(problem_of(tables), comments=True).encode()


def python_text(tables: Mapping[str, Any]) -> bytes:
    """Return the Python script that computes a case."""
    return to_python(problem_of(tables)).encode()


def result_file(tables: Mapping[str, Any], ending: str, options: Mapping[str, Any]) -> bytes:
    """Return the solved case as a result file, SI units.

    Parameters
    ----------
    tables : mapping
    ending : str
        Of the name of the file, which determines its format: csv, json or nc.
    options : mapping
        Of the solver.
    """
    write = writer_for(f"result.{ending}")
    return write(solved(problem_of(tables), options))


def figure(request: Mapping[str, Any], ending: str, panels: Sequence[str]) -> bytes:
    """Return a figure of solved cases.

    Parameters
    ----------
    request : mapping
        As :class:`.request_models.Cases`.
    ending : str
        Format of the figure: svg, png or pdf.
    panels : sequence of str
        Names of the panels; empty for the usual ones.
    """
    from ..report.figures import figure_bytes
    from ..report.plots import figure_for_file

    results, labels = _solved_cases(request["cases"])
    with _units(request["units"]):
        plot = figure_for_file(
            results, labels=labels if len(labels) > 1 else None, panels=panels or None
        )
        return figure_bytes(plot, f".{ending}")


def report(request: Mapping[str, Any]) -> bytes:
    """Return the report of solved cases, one HTML file; ``request`` as for :func:`figure`."""
    from ..report.html_report import report_file

    results, labels = _solved_cases(request["cases"])
    with _units(request["units"]):
        page = report_file(results, labels, title=request["title"], remarks=request["remarks"])
        return page.encode()


def exhibit(name: str) -> bytes:
    """Compute the figure of a plug-in with that name and return it as SVG."""
    owners = {figure["name"]: group for group in plugins.figures() for figure in group.list()}
    if name not in owners:
        raise InvalidProblem.at("name", f"{quote(name)} is unknown{did_you_mean(name, owners)}")
    return owners[name].draw(name)


def _solved_cases(cases: Sequence[Mapping[str, Any]]) -> tuple[list[Any], list[str]]:
    """Return the results of labelled cases, and the labels; by default A, B, C, D."""
    results = []
    for k, entry in enumerate(cases):
        try:
            results.append(solved(problem_of(entry["case"]), options={}))
        except InvalidProblem as fault:
            raise fault.under(f"cases.{k}.case") from None
    # a request has at most LIMITS["compare"] = 4 cases
    return results, [entry["label"] or "ABCD"[k] for k, entry in enumerate(cases)]


def _units(chosen: Mapping[str, str] | str) -> AbstractContextManager[None]:
    """Use a system of units, or units by the names of fields and outputs."""
    return units_of([chosen]) if isinstance(chosen, str) else units(chosen)
