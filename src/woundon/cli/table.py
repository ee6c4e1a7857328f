"""The command ``woundon table``: solve the cases of a spreadsheet and write the results."""

from __future__ import annotations

import time
from pathlib import Path

import click

from ..errors import InvalidProblem, unwarned
from ..io.files import check_writable
from .options import COLUMNS, NODES, PATH, RTOL, SETTINGS, TIES, UNITS, WORKERS, KindName

__all__ = ["table"]

MOST_REASONS = 5


@click.command(
    help="""\
    Solve the cases of a table (.csv or .xlsx), one in each row, and write the results as a table.

    A column is a field by its name, e.g. "nip_load [kN/m]" or "web.thickness [um]", with the unit
    in the header, in a row below it or in the cells. Fields without a column, and empty cells, have
    the value of --case; without it, the columns describe the complete problem. The columns
    "failure" and "warnings" explain the rows that were not solved or leave the validity of the
    model. Exit status: 0 if a row was solved, 3 if none was, 2 for invalid input.
    """,
    short_help="Solve the cases of a spreadsheet, one in each row.",
)
@click.argument("cases", type=PATH)
@click.option(
    "-o",
    "--out",
    type=PATH,
    required=True,
    metavar="FILE",
    help="Table of the results, .csv or .xlsx.",
)
@click.option("--case", type=PATH, metavar="CASE.toml", help="Values of all other fields.")
@click.option("--kind", type=KindName(), help="Kind of problem of a table without --case.")
@SETTINGS
@click.option(
    "--output",
    "outputs",
    multiple=True,
    metavar="NAME",
    help="An output; by default all; repeatable.",
)
@COLUMNS
@TIES
@UNITS
@WORKERS
@NODES
@RTOL
def table(
    cases: Path,
    out: Path,
    case: Path | None,
    kind: str | None,
    settings: tuple[str, ...],
    outputs: tuple[str, ...],
    columns: tuple[tuple[str, str], ...],
    ties: tuple[tuple[str, str], ...],
    workers: int | None,
    nodes: int | None,
    rtol: float | None,
) -> int:
    """Solve the cases of a table (.csv or .xlsx), one in each row."""
    from ..io.case_files import load_case
    from ..studies.case_table import solve_table
    from ..studies.export import TABLES, check_export, write_table
    from ..studies.run import failures

    check_export(out, TABLES)
    check_writable(out)
    if settings and case is None:
        raise InvalidProblem.at("--set", "changes a field of --case, which is not given")
    problem = load_case(case, settings) if case else None
    start = time.perf_counter()
    with unwarned():
        solved = solve_table(
            cases,
            problem,
            outputs or None,
            kind=kind,
            workers=workers,
            progress=True,
            columns={name: assigned or None for name, assigned in columns},
            tie=dict(ties),
            nodes=nodes,
            rtol=rtol,
        )
    write_table(solved, out)
    failure = solved["failure"].to_numpy(dtype=object)
    size, failed = len(failure), int((failure != "").sum())
    click.echo(f"{size} rows in {time.perf_counter() - start:.1f} s, {failed} failed")
    for reason, count in failures(failure, MOST_REASONS):
        click.secho(f"  {count} x {reason}", fg="red")
    warned = int((solved["warnings"] != "").sum())
    if warned:
        click.secho(f"  {warned} with a warning; see the column 'warnings'", fg="yellow")
    click.echo(f"written: {out}")
    return 3 if failed == size else 0
