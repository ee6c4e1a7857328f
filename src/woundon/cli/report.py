"""The command ``woundon report``: write a report of solved cases."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from ..errors import InvalidProblem, unwarned
from ..io.files import write_whole
from . import options

if TYPE_CHECKING:
    from ..problems.problem import Problem
    from ..results import Result

__all__ = ["report"]

HTML = options.OutputFile(".html", ".htm")


@options.command(
    """\
    Write a report of solved cases: one HTML file for print.

    CASES are case files, which are solved, or saved results (.json, .nc). The report contains the
    inputs, the results with errors and certificate, and figures, and prints to PDF from any
    browser. Several CASES are compared with each other.
    """
)
@click.argument("cases", nargs=-1, required=True, type=options.PATH)
@click.option("--out", type=HTML, metavar="FILE.html", help="HTML file; by default CASE.html.")
@options.SETTINGS
@options.UNITS
@click.option("--title", default="", help="Title of the report.")
@click.option("--remarks", default="", help="Text of the remarks; by default left empty.")
def report(
    cases: tuple[Path, ...], out: Path | None, settings: tuple[str, ...], title: str, remarks: str
) -> None:
    """Write a report of solved cases: one HTML file for print."""
    from .. import kinds
    from ..problems.problem import Problem
    from ..report.html_report import report_file

    loaded = [_load(path, settings) for path in cases]
    options.check_unit_names(
        *(each if isinstance(each, Problem) else each.problem for each in loaded)
    )
    # checked like a path that is given, which the type has converted already
    out = out or HTML.convert(cases[0].with_suffix(".html"), param=None, ctx=None)
    with unwarned():
        results = [kinds.solve(each) if isinstance(each, Problem) else each for each in loaded]
        page = report_file(
            results,
            [path.stem for path in cases],
            title=title,
            remarks=remarks,
            sources=[path.name for path in cases],
        )
    write_whole(out, page.encode())
    options.print_written([out])


def _load(path: Path, settings: tuple[str, ...]) -> Problem | Result:
    """Return the problem of a case file, or a saved result; errors name the file."""
    from ..io.case_files import load_case
    from ..io.result_files import load_result

    if path.suffix in (".json", ".nc"):
        if settings:
            raise InvalidProblem.at("--set", f"changes a case file; {path} is a saved result")
        result: Result = load_result(path)
        return result
    try:
        return load_case(path, settings)
    except InvalidProblem as fault:
        # errors of reading the file have its path as their field, those of fields have not
        names_file = any(field == str(path) for field, _ in fault.faults)
        raise fault if names_file else fault.under(str(path)) from None
