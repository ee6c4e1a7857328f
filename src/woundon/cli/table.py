"""The command ``woundon table``: solve the cases of a spreadsheet and write the results."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import click

from ..errors import InvalidProblem, unwarned
from . import options

__all__ = ["table"]


@options.command(
    """\
    Solve the cases of a spreadsheet, one in each row.

    CASES is a table (.csv or .xlsx); the results are written as a table too. A column is a field by
    its name, e.g. "nip_load [kN/m]" or "web.thickness [um]", with the unit in the header, in a row
    below it or in the cells. Fields without a column, and empty cells, have the value of --case;
    without it, the columns describe the complete problem. The columns "failure" and "warnings"
    explain the rows that were not solved or leave the validity of the model. Exit status: 0 if a
    row was solved, 3 if none was, 2 for invalid input.
    """
)
@click.argument("cases", type=options.PATH)
@click.option(
    "-o", "--out", type=options.TABLE, required=True, help="Table of the results, .csv or .xlsx."
)
@click.option("--case", type=options.PATH, metavar="CASE.toml", help="Values of all other fields.")
@click.option("--kind", type=options.KindName(), help="Kind of problem of a table without --case.")
@options.SETTINGS
@click.option(
    "--output",
    "outputs",
    multiple=True,
    metavar="NAME",
    help="An output; by default all; repeatable.",
)
@options.COLUMNS
@options.TIES
@options.UNITS
@options.DECIMAL_COMMA
@options.WORKERS
@options.NODES
@options.RTOL
def table(
    cases: Path,
    out: Path,
    case: Path | None,
    settings: tuple[str, ...],
    outputs: tuple[str, ...],
    **arguments: Any,
) -> int:
    """Solve the cases of a spreadsheet, one in each row."""
    from .. import kinds
    from ..studies.case_table import solve_table
    from ..studies.export import write_table

    if settings and case is None:
        raise InvalidProblem.at("--set", "changes a field of --case, which is not given")
    problem = options.load_case(case, settings) if case else None
    if arguments["kind"]:
        options.check_unit_names(kinds.named(arguments["kind"]).problem)
    start = time.perf_counter()
    with unwarned():
        solved = solve_table(cases, problem, outputs or None, progress=True, **arguments)
    write_table(solved, out)
    code = options.print_failures("rows", solved["failure"], time.perf_counter() - start)
    warned = int((solved["warnings"] != "").sum())
    if warned:
        click.secho(f"  {warned} with a warning; see the column 'warnings'", fg="yellow")
    options.print_written([out])
    return code
