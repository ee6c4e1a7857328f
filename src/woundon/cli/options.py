"""Options that several commands share, and the check of the files that a command is to write."""

from __future__ import annotations

from pathlib import Path

import click

from ..io.files import check_writable

__all__ = ["COLUMNS", "PATH", "PLOT", "SETTINGS", "TIES", "UNITS", "check_output_files"]

PATH = click.Path(path_type=Path)
SETTINGS = click.option(
    "--set", "settings", multiple=True, metavar="FIELD=VALUE", help="Change a field."
)
UNITS = click.option(
    "--unit", "chosen", multiple=True, metavar="NAME=UNIT",
    help="Print and draw an input or output in another unit; repeatable.",
)  # fmt: skip
TIES = click.option(
    "--tie", "ties", multiple=True, metavar="FIELD=FIELD",
    help="A field that follows another, e.g. web.material=roll.material; repeatable.",
)  # fmt: skip
COLUMNS = click.option(
    "--column", "columns", multiple=True, metavar="COLUMN=NAME",
    help="What a column is, e.g. 'Linienlast=nip_load [kN/m]'; without NAME: not used.",
)  # fmt: skip
PLOT = click.option("--plot", type=PATH, metavar="FILE", help="Draw to .png, .svg or .pdf.")


def check_output_files(plot: Path | None, *others: Path | None) -> None:
    """Check before a computation that its figure and its other files can be written.

    Raises
    ------
    InvalidProblem
        For a figure whose ending is not a known format.
    OSError
        For a file that cannot be written.
    """
    if plot:
        # drawing takes half a second to import
        from ..report.figures import check_format

        check_format(plot)
    for path in filter(None, (plot, *others)):
        check_writable(path)
