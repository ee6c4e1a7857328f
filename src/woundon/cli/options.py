"""What several commands share: types of values, options, the output of a result.

An option that a public function has is passed to it by its name: the command only declares it, and
a type below converts its text to the value that the function expects.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from inspect import cleandoc
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..errors import InvalidProblem, mapping_of
from ..io.files import check_writable

if TYPE_CHECKING:
    from rich.console import Console

    from ..problems.problem import Problem
    from ..studies.outcome import Outcome

__all__ = [
    "COLUMNS",
    "DECIMAL_COMMA",
    "FIGURE",
    "JSON",
    "NEW_CASE",
    "NODES",
    "PATH",
    "PLOT",
    "RESUME",
    "RTOL",
    "SAVE_TABLE",
    "SCHEDULER",
    "SETTINGS",
    "TABLE",
    "TIES",
    "UNITS",
    "WORKERS",
    "FieldRange",
    "Files",
    "KindName",
    "Numbers",
    "OutputFile",
    "Pair",
    "as_mapping",
    "as_number",
    "check_unit_names",
    "command",
    "console",
    "load_case",
    "option_name",
    "present",
    "print_failures",
    "print_written",
    "resumable",
    "write",
]

# ---- types of values ----------------------------------------------------------------------------


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
    """A text "NAME=VALUE" as a tuple of the name and the value.

    Parameters
    ----------
    form : str
        The form of the text, which help and error messages show.
    value : callable
        Converts the text of the value.
    optional : bool
        Whether the value may be empty, which gives None.
    """

    def __init__(
        self, form: str, value: Callable[[str], Any] = str, *, optional: bool = False
    ) -> None:
        self.name, self.value, self.optional = form, value, optional

    def convert(self, value: Any, param: Any, ctx: Any) -> tuple[str, Any]:
        """Split the text at its last equals sign; the header of a column may have others."""
        name, sign, right = (part.strip() for part in value.rpartition("="))
        if not (sign and name and (right or self.optional)):
            self.fail(f"{value!r} is out of place; must be written {self.name}", param, ctx)
        return name, self.value(right) if right else None


class Numbers(click.ParamType):
    """Numbers with colons between them, such as LOW:HIGH, each with or without a unit.

    Parameters
    ----------
    form : str
        Names of the numbers, each optional one in brackets: "TENSION:LOAD[:SPLIT]".
    """

    def __init__(self, form: str) -> None:
        self.name = form
        longest = form.count(":") + 1
        self.counts = range(longest - form.count("["), longest + 1)  # permitted numbers of parts

    def convert(self, value: Any, param: Any, ctx: Any) -> list[str | float]:
        """Split the text at its colons."""
        parts = [part.strip() for part in value.split(":")]
        if len(parts) not in self.counts or not all(parts):
            self.fail(f"{value!r} is out of place; must be written {self.name}", param, ctx)
        return [as_number(part) for part in parts]


class FieldRange(click.ParamType):
    """A text "FIELD" or "FIELD=LOW:HIGH" as the name and the range, which may be None."""

    name = "FIELD[=LOW:HIGH]"

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
        super().__init__(())  # the choices are computed when they are read

    @property
    def choices(self) -> tuple[str, ...]:
        """The names of all kinds."""
        # the kinds import NumPy, SciPy and pydantic
        from ..kinds import every

        return tuple(kind.name for kind in every())

    @choices.setter
    def choices(self, names: tuple[str, ...]) -> None:
        pass  # set by the base class


class OutputFile(click.Path):
    """A file that the command writes; it is checked before anything is computed.

    Parameters
    ----------
    endings : str
        Permitted endings; messages name the first.  Without one, all are permitted.
    check : callable, optional
        Rejects other formats of a file that may have several.
    """

    def __init__(self, *endings: str, check: Callable[[Path], object] | None = None) -> None:
        super().__init__(path_type=Path)
        self.endings, self.check = endings, check

    def get_metavar(self, param: click.Parameter, ctx: click.Context) -> str:
        """Return the name of the file in the help, such as FILE.toml."""
        return f"FILE{self.endings[0]}" if self.endings else "FILE"

    def convert(self, value: Any, param: Any, ctx: Any) -> Path:
        """Return the path.

        Raises
        ------
        InvalidProblem
            For an ending that is not permitted, or a file that cannot be written.
        """
        path = Path(value)
        if self.endings and path.suffix not in self.endings:
            text = f"the ending {path.suffix!r} is not permitted; must be {self.endings[0]}"
            raise InvalidProblem.at(str(path), text)
        if self.check is not None:
            self.check(path)
        check_writable(path)
        return path


def _check_figure(path: Path) -> None:
    """Reject a file that is not of a format of figures."""
    # importing Matplotlib takes half a second
    from ..report.figures import check_format

    check_format(path)


def _check_table(path: Path) -> None:
    """Reject a file that is not of a format of tables."""
    # the tables of cases import NumPy
    from ..studies.export import TABLES, check_export

    check_export(path, TABLES)


PATH = click.Path(path_type=Path)
FIGURE = OutputFile(check=_check_figure)
TABLE = OutputFile(check=_check_table)

# ---- commands and options -----------------------------------------------------------------------

UNITS_OF_COMMAND = "woundon.units"  # entry of a command's context: the texts of --unit


def command(text: str, cls: type[click.Command] = click.Command) -> Callable[..., click.Command]:
    """Return the decorator of a command with its help, whose first sentence is the summary.

    The docstring of the function is no help, because Python leaves it out with ``-OO``.
    """
    first_sentence, *_ = re.split(r"\.(?=\s|$)", cleandoc(text), maxsplit=1)
    summary = " ".join(first_sentence.split())
    return click.command(cls=cls, help=text, short_help=f"{summary}.")


def option_name(name: str) -> str:
    """Return the option for the name of an argument or field: --roll-wrap of roll_wrap."""
    return f"--{name.replace('_', '-')}"


def as_mapping(
    context: click.Context, option: click.Parameter, pairs: Iterable[tuple[str, Any]]
) -> dict[str, Any]:
    """Return the pairs of a repeated option as a mapping; the callback of such an option."""
    return mapping_of(pairs, option.opts[-1])  # names the option by its long form


def _use_units(context: click.Context, option: click.Parameter, choices: tuple[str, ...]) -> None:
    """Display results in the chosen units until the command ends."""
    if choices:
        # the units import the kinds of problem, with NumPy and pydantic
        from ..io.chosen_units import units_of

        context.meta[UNITS_OF_COMMAND] = choices
        context.with_resource(units_of(choices))


def _use_decimal_commas(context: click.Context, option: click.Parameter, chosen: bool) -> None:
    """Write CSV files with decimal commas until the command ends."""
    if chosen:
        from ..io.spreadsheets import decimal_commas

        context.with_resource(decimal_commas())


def check_unit_names(*problems: Problem | type[Problem]) -> None:
    """Reject a unit that --unit chooses for a name which none of the problems has."""
    choices = click.get_current_context().meta.get(UNITS_OF_COMMAND)
    if choices:
        from ..io.chosen_units import check_names

        check_names(choices, problems)


def load_case(path: Path, settings: Iterable[str] = ()) -> Problem:
    """Return the problem of a case file with settings "FIELD=VALUE".

    The names of --unit must be among its names.
    """
    from ..io.case_files import load_case

    problem = load_case(path, settings)
    check_unit_names(problem)
    return problem


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
DECIMAL_COMMA = click.option(
    "--decimal-comma",
    is_flag=True,
    expose_value=False,
    callback=_use_decimal_commas,
    help="Write CSV files with decimal commas and semicolons, for spreadsheets that expect them.",
)
TIES = click.option(
    "--tie",
    multiple=True,
    type=Pair("FIELD=FIELD"),
    callback=as_mapping,
    help="Let a field follow another one, e.g. web.material=roll.material; repeatable.",
)
COLUMNS = click.option(
    "--column",
    "columns",
    multiple=True,
    type=Pair("COLUMN=NAME", optional=True),
    callback=as_mapping,
    help="Assign a column of the table to an input or output, e.g. "
    "'Linienlast=nip_load [kN/m]'; without NAME the column is ignored, and by '*=' every column "
    "without a known name; repeatable.",
)
PLOT = click.option("--plot", type=FIGURE, help="Plot to .png, .svg or .pdf.")
NEW_CASE = click.option(
    "--case", "new_case", type=OutputFile(".toml"), help="Write the case with the solution."
)
SAVE_TABLE = click.option("--save", type=TABLE, help="Save the table as .csv or .xlsx, in SI.")
RESUME = click.option("--resume", is_flag=True, help="Resume the study in DIR.")
JSON = click.option("--json", "as_json", is_flag=True, help="Print the complete result as JSON.")
NODES = click.option("--nodes", type=int, help="Number of nodes on the last mesh.")
RTOL = click.option("--rtol", type=float, help="Relative error of the solver.")
WORKERS = click.option("--workers", type=int, help="Number of processes; by default one per core.")
SCHEDULER = click.option("--scheduler", metavar="ADDRESS", help="Dask scheduler, tcp://host:port.")

# ---- running and printing -----------------------------------------------------------------------


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


# path of a file that a command writes -> function that writes it; None if it is not requested
Files = Mapping[Path | None, Callable[[Path], object]]


def present(
    result: Outcome, as_json: bool, files: Files, lines: Iterable[str] | None = None
) -> None:
    """Write the requested files of a study's result, and print its JSON or its lines.

    Parameters
    ----------
    result : Outcome
    as_json : bool
        Whether JSON is printed in place of the lines.
    files : mapping of path to callable
        Writes the file of each path.
    lines : iterable of str, optional
        In place of ``result.lines()``.
    """
    written = write(files)
    if as_json:
        click.echo(result.to_json())
    else:
        from ..report.terminal import in_characters

        terminal = console()
        for line in result.lines() if lines is None else lines:
            click.echo(in_characters(line, terminal))
    print_written(written, as_json)


def write(files: Files) -> list[Path]:
    """Write the requested files; return their paths."""
    requested = {path: save for path, save in files.items() if path is not None}
    for path, save in requested.items():
        save(path)
    return list(requested)


def print_written(paths: Iterable[Path], as_json: bool = False) -> None:
    """Print the paths of written files; next to JSON on the error channel."""
    text = ", ".join(map(str, paths))
    if text:
        click.echo(f"written: {text}", err=as_json)


def print_failures(cases: str, reasons: Iterable[str], seconds: float) -> int:
    """Print how many cases of a study failed, and the most frequent reasons.

    Parameters
    ----------
    cases : str
        What the cases are called, such as "rows".
    reasons : iterable of str
        Reason of the failure of each case; empty for a solved one.
    seconds : float
        Duration of the study.

    Returns
    -------
    int
        The exit code: 3 if all cases failed, else 0.
    """
    import numpy as np

    from ..quantities import in_chosen_units
    from ..studies.run import failures

    texts = np.array([*reasons], dtype=object)
    failed = int((texts != "").sum())
    click.echo(f"{texts.size} {cases} in {seconds:.1f} s, {failed} failed")
    for reason, count in failures(texts):
        click.secho(f"  {count} x {in_chosen_units(reason)}", fg="red")
    return 3 if failed == texts.size else 0


def console() -> Console:
    """Return the terminal on which commands print reports.

    Its lines are not wrapped, so that a pipe or a log gets the same text.
    """
    from rich.console import Console

    class Terminal(Console):
        def on_broken_pipe(self) -> None:
            raise BrokenPipeError  # rich would exit with code 1

    terminal = Terminal(highlight=False)
    terminal.width = max(terminal.width, 100)
    return terminal
