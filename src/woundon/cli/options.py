"""Options that several commands share, and the types of their values."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import click

from ..io.files import check_writable

__all__ = [
    "COLUMNS",
    "JSON",
    "NODES",
    "PATH",
    "PLOT",
    "RTOL",
    "SETTINGS",
    "TIES",
    "UNITS",
    "WORKERS",
    "FieldRange",
    "KindName",
    "Numbers",
    "Pair",
    "as_number",
    "check_output_files",
    "resumable",
]


def as_number(text: str) -> str | float:
    """Return a plain number, which is in SI units, as a float; any other text, with a unit, as is.

    >>> as_number("300"), as_number("300 N/m")
    (300.0, '300 N/m')
    """
    try:
        return float(text)
    except ValueError:
        return text


class Pair(click.ParamType):
    """A text "NAME=VALUE" as a tuple; the value may be empty if it is optional."""

    name = "pair"

    def __init__(self, form: str = "NAME=VALUE", optional: bool = False) -> None:
        self.form, self.optional = form, optional

    def convert(self, value: Any, param: Any, ctx: Any) -> tuple[str, str]:
        """Split the text at its last equals sign; the header of a column may have others."""
        name, sign, right = (part.strip() for part in value.rpartition("="))
        if not (sign and name and (right or self.optional)):
            self.fail(f"{value!r}: must be written {self.form}", param, ctx)
        return name, right


class Numbers(click.ParamType):
    """Numbers with colons between them, such as LOW:HIGH, each with or without a unit."""

    name = "numbers"

    def __init__(self, form: str) -> None:
        self.form = form
        longest = form.count(":") + 1
        self.counts = range(longest - form.count("["), longest + 1)

    def convert(self, value: Any, param: Any, ctx: Any) -> list[str | float]:
        """Split the text at its colons."""
        parts = [part.strip() for part in value.split(":")]
        if len(parts) not in self.counts or not all(parts):
            self.fail(f"{value!r}: must be written {self.form}", param, ctx)
        return [as_number(part) for part in parts]


class FieldRange(click.ParamType):
    """A text "FIELD" or "FIELD=LOW:HIGH" as the name and the range, which may be None."""

    name = "field range"

    def convert(
        self, value: Any, param: Any, ctx: Any
    ) -> tuple[str, tuple[str | float, str | float] | None]:
        """Split the text at its equals sign, and the range at its colon."""
        name, sign, ends = (part.strip() for part in value.partition("="))
        if not sign:
            return name, None
        low, high = Numbers("FIELD=LOW:HIGH").convert(ends, param, ctx)
        return name, (low, high)


class KindName(click.Choice[str]):
    """The name of a kind of problem; plug-ins may add kinds until the command is called."""

    def __init__(self) -> None:
        super().__init__(())

    @property
    def choices(self) -> tuple[str, ...]:
        """The names of all kinds."""
        # the kinds import NumPy, SciPy and pydantic
        from ..kinds import every

        return tuple(kind.name for kind in every())

    @choices.setter
    def choices(self, names: tuple[str, ...]) -> None:
        pass  # set by the base class


def _use_units(context: click.Context, option: Any, choices: tuple[str, ...]) -> None:
    """Display results in the chosen units until the command ends."""
    if choices:
        # the units import the kinds of problem, with NumPy and pydantic
        from ..io.chosen_units import units_of

        context.with_resource(units_of(choices))


PATH = click.Path(path_type=Path)
SETTINGS = click.option(
    "--set",
    "settings",
    multiple=True,
    metavar="FIELD=VALUE",
    help='Change a field, e.g. web.thickness="57 um"; "none" unsets an optional field; repeatable.',
)
UNITS = click.option(
    "--unit",
    multiple=True,
    expose_value=False,
    callback=_use_units,
    metavar="NAME=UNIT|mill",
    help='Display an input or output in another unit, e.g. nip_load="kN/m"; "mill" displays all in '
    "pli, psi, mil, in; repeatable.",
)
TIES = click.option(
    "--tie",
    "ties",
    multiple=True,
    type=Pair("FIELD=FIELD"),
    metavar="FIELD=FIELD",
    help="Let a field follow another one, e.g. web.material=roll.material; repeatable.",
)
COLUMNS = click.option(
    "--column",
    "columns",
    multiple=True,
    type=Pair("COLUMN=NAME", optional=True),
    metavar="COLUMN=NAME",
    help="Assign a column of the table to an input or output, e.g. "
    "'Linienlast=nip_load [kN/m]'; without NAME the column is ignored, and by '*=' every column "
    "without a known name; repeatable.",
)
PLOT = click.option("--plot", type=PATH, metavar="FILE", help="Plot to .png, .svg or .pdf.")
JSON = click.option("--json", "as_json", is_flag=True, help="Print the complete result as JSON.")
NODES = click.option("--nodes", type=int, help="Number of nodes on the last mesh.")
RTOL = click.option("--rtol", type=float, help="Relative error of the solver.")
WORKERS = click.option("--workers", type=int, help="Number of processes; by default one per core.")


@contextmanager
def resumable(out: Path | None) -> Iterator[None]:
    """End a study in a folder, after Ctrl-C, with a line that says how to resume it."""
    try:
        yield
    except KeyboardInterrupt:
        if out is None:
            raise
        text = f"interrupted; the solved cases are in {out}, --resume continues"
        raise click.Abort(text) from None


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
        # importing Matplotlib takes half a second
        from ..report.figures import check_format

        check_format(plot)
    for path in filter(None, (plot, *others)):
        check_writable(path)
