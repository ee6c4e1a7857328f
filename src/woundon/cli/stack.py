"""The command ``woundon stack``: fit the laws of a stack to a compression test."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

import click

from . import options

__all__ = ["stack"]


@options.command(
    """\
    Fit the laws of a stack to a compression test.

    TEST is a table (.csv or .xlsx, .lvm, .tdms) with the columns pressure (or stress) and strain,
    or load and deflection, which need --area and --height. All laws of a stack are fitted
    (Pfeiffer's, a power, a polynomial, a constant) and ranked by their misfit; the table of the
    best one for a case file is printed. A part of a file is named as in "test.xlsx#Sheet".
    """
)
@click.argument("test", type=options.PATH)
@click.option(
    "--area", type=options.as_number, metavar="AREA", help='Loaded area, "100 cm^2", for a load.'
)
@click.option(
    "--height",
    type=options.as_number,
    metavar="LENGTH",
    help='Height of the stack without load, "20 mm", for a deflection.',
)
@click.option(
    "--offset",
    type=options.as_number,
    default=0.0,
    metavar="LOAD",
    help="Load, or pressure, that the load cell shows without a stack.",
)
@click.option(
    "--preload",
    type=options.as_number,
    metavar="PRESSURE",
    help="Rows below are left out; by default 1 % of the largest pressure if the rows scatter.",
)
@click.option(
    "--branch",
    default="loading",
    show_default=True,
    help="loading, unloading, or the number of a branch between two reversals.",
)
@click.option(
    "--degree", type=int, default=2, show_default=True, help="Degree of the polynomial, 2 to 5."
)
@options.COLUMNS
@options.UNITS
@options.DECIMAL_COMMA
@options.JSON
@options.SAVE_TABLE
@options.PLOT
def stack(
    test: Path,
    as_json: bool,
    save: Path | None,
    plot: Path | None,
    **arguments: Any,
) -> None:
    """Fit the laws of a stack to a compression test."""
    from ..studies.export import write_table
    from ..studies.stack_fit import fit_stack

    found = fit_stack(test, **arguments)
    files: options.Files = {save: partial(write_table, found.to_dataframe()), plot: found.plot}
    options.present(found, as_json, files, [*found.lines(), "", *found.toml().splitlines()])
