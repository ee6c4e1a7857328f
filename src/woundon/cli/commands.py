"""The command line: parse, call, show.  Everything heavy is imported by the command that uses it.

Each kind of problem has a command of its own name (:mod:`.solve_command`), and any package may add
commands by the entry-point group ``woundon.commands``.

Exit codes: 0 done, 2 bad input (one line a fault), 3 not solved to tolerance or (``find``) no
solution in the range, 130 stopped by Ctrl-C.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from contextlib import suppress
from typing import Any

import click

from .. import __version__, kinds
from ..errors import InvalidProblem, NoSolution, NotConverged, one_of, printable_line
from ..kinds import entry_points
from ..parallel import environment
from .solve import SolveCommand

__all__ = ["main"]

BAD_INPUT = 2
NOT_CONVERGED = 3
STOPPED = 130  # by Ctrl-C, as shells have it
COMMANDS = "woundon.commands"

# commands that are imported when they are called, with their help
_LATE = {
    "app": "Open the nip and the roll in the browser.",
    "report": "Write a report of solved cases: one HTML file that prints well.",
    "design": "Find the wound-on tension for a prescribed pressure in a roll.",
    "sweep": "Solve all cases of a study file.",
    "fit": "Fit fields of a case to measured data.",
    "find": "Find the value of a field for which an output reaches a target.",
    "window": "Map the probability that a winding keeps all its limits.",
    "table": "Solve the cases of a spreadsheet, one in each row.",
    "compare": "Compare measured values with the predictions for a case.",
    "plan": "Choose the next measurement by its expected information.",
    "sensitivity": "Rank the inputs of a study file by their influence (Sobol indices).",
}


def _late_command(name: str) -> click.Command:
    """Import a command."""
    if name in ("app", "report"):
        from . import app as app_commands

        return app_commands.app if name == "app" else app_commands.report
    if name == "design":
        from .design import design

        return design
    if name in ("find", "table", "compare", "window"):
        return _late_question(name)
    from . import studies as study_commands

    found: click.Command = getattr(study_commands, name)
    return found


def _late_question(name: str) -> click.Command:
    """Import a command that answers a question on a case."""
    if name == "find":
        from .find import find

        return find
    if name == "table":
        from .table import table

        return table
    if name == "window":
        from .window import window

        return window
    from .compare import compare

    return compare


def main(args: Sequence[str] | None = None) -> int:
    """Run the command line; return the exit code."""
    for name, value in environment().items():  # before NumPy loads
        os.environ.setdefault(name, value)
    code = STOPPED
    try:
        try:
            code = _run(args)
        except (_ReaderLeftError, BrokenPipeError):
            code = 0  # head or less have read enough; nobody is there to tell
        for stream in filter(None, (sys.stdout, sys.stderr)):
            try:
                stream.flush()
            except OSError:  # or Python would tell of it at its end
                os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
    except KeyboardInterrupt:  # once more, when all is told: the code is that of what was done
        pass
    return code


def _run(args: Sequence[str] | None) -> int:
    """Run the command line; return the exit code, faults told."""
    try:
        code = int(commands.main(args, "woundon", standalone_mode=False) or 0)
        if sys.stdout:
            sys.stdout.flush()
        return code
    except NoSolution as fault:
        return _refuse([f"no solution: {fault}"], NOT_CONVERGED)
    except InvalidProblem as fault:
        return _refuse(str(fault).splitlines(), BAD_INPUT)
    except NotConverged as fault:
        return _refuse([f"not converged: {fault}"], NOT_CONVERGED)
    except click.exceptions.NoArgsIsHelpError as told:
        with suppress(OSError):
            click.echo(told.format_message(), err=True)
        return BAD_INPUT
    except click.ClickException as fault:
        return _refuse([fault.format_message()], BAD_INPUT)
    except click.Abort:
        return STOPPED
    except BrokenPipeError:
        raise
    except OSError as fault:
        where = f"{fault.filename}: " if fault.filename else ""
        return _refuse([f"{where}{fault.strerror or fault}"], BAD_INPUT)


def _refuse(lines: Sequence[str], code: int) -> int:
    with suppress(OSError):  # the code is told even where nobody reads why
        for line in lines:
            click.secho(f"error: {printable_line(line)}", fg="red", err=True)
    return code


class _ReaderLeftError(Exception):
    """A broken pipe, by a name that click does not end with exit code 1."""


class Commands(click.Group):
    """The commands written here, one for each kind of problem, studies, and those of plug-ins."""

    def make_context(self, *args: Any, **more: Any) -> click.Context:
        """Read the arguments; --help and --version print here already."""
        try:
            return super().make_context(*args, **more)
        except BrokenPipeError:
            raise _ReaderLeftError from None

    def invoke(self, ctx: click.Context) -> Any:
        """Run the command that is asked for."""
        try:
            return super().invoke(ctx)
        except BrokenPipeError:
            raise _ReaderLeftError from None

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names of all commands."""
        return [name for names in self._sections().values() for name in names]

    def get_command(self, ctx: click.Context, name: str) -> click.Command | None:
        """Return a command by its name, imported now."""
        if name in self.commands:
            return self.commands[name]
        if name in _LATE:
            return _late_command(name)
        for found in entry_points(group=COMMANDS, name=name):
            return found.load()
        own = next((kind for kind in kinds.every() if kind.command == name), None)
        return SolveCommand(own) if own else None

    def resolve_command(self, ctx: click.Context, args: list[str]) -> Any:
        """Return the command that is asked for; a misspelt one is told the nearest."""
        name = args[0]
        if self.get_command(ctx, name) is None and not name.startswith("-"):
            from ..errors import did_you_mean

            ctx.fail(f"No such command {name!r}{did_you_mean(name, self.list_commands(ctx))}")
        return super().resolve_command(ctx, args)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the commands under their headings."""
        for title, names in self._sections().items():
            with formatter.section(title):
                formatter.write_dl([(name, self._about(ctx, name)) for name in names])

    def _sections(self) -> dict[str, list[str]]:
        others = sorted(found.name for found in entry_points(group=COMMANDS))
        sections = {
            "Commands": list(self.commands),
            "Commands for one kind of problem": [kind.command for kind in kinds.every()],
            "Studies": list(_LATE),
            "Other commands": others,
        }
        return {title: names for title, names in sections.items() if names}

    def _about(self, ctx: click.Context, name: str) -> str:
        if name in _LATE:
            return _LATE[name]
        try:
            command = self.get_command(ctx, name)
        except ImportError as fault:
            return f"(cannot be loaded: {fault})"
        return command.get_short_help_str(200) if command else ""


@click.group(
    help="""\
    Winding mechanics: what the winding nip does to a paper or film web.
    """,
    cls=Commands,
    context_settings={"help_option_names": ["-h", "--help"]},
)
@click.version_option(__version__, prog_name="woundon")
def commands() -> None:
    """Winding mechanics: what the winding nip does to a paper or film web."""


commands.add_command(SolveCommand(None))


class New(click.Command):
    """Prints a file to start from; every kind of problem has a flag."""

    def get_params(self, ctx: click.Context) -> list[click.Parameter]:
        """Return argument and flags; a kind of two words has a short flag if that is unique."""
        if len(self.params) == 2:
            self.params += [
                click.Option(_flags(kind.command), is_flag=True, default=False, help=kind.about)
                for kind in kinds.every()
            ]
        return super().get_params(ctx)


def _flags(command: str) -> list[str]:
    first, *others = command.split("-")
    alone = sum(kind.command.split("-")[0] == first for kind in kinds.every()) == 1
    return [f"--{command}", *([f"--{first}"] if others and alone else [])]


@commands.command(
    help="""\
    Print a commented case file to start from: woundon new > case.toml.

    KIND is the kind of problem, named as its command or by a flag; by default nip.
    """,
    cls=New,
    short_help="Print a commented case or study file to start from.",
)
@click.argument("kind", required=False)
@click.option("--study", is_flag=True, help="A study file with such a case, for 'woundon sweep'.")
def new(kind: str | None, study: bool, **flags: bool) -> None:
    """Print a commented case file to start from: woundon new > case.toml."""
    named = [*([kind] if kind else []), *(name for name, asked in flags.items() if asked)]
    if len(named) > 1:
        raise InvalidProblem.at("kind", f"must be one, got {one_of(named, 'and')}")
    chosen = named[0] if named else "nip"
    if study:
        from ..studies.study_texts import study_template

        click.echo(study_template(chosen), nl=False)
    else:
        from ..io.case_texts import template

        click.echo(template(chosen), nl=False)


@commands.command(
    help="""\
    List the named materials with their values and sources.
    """,
)
def materials() -> None:
    """List the named materials with their values and sources."""
    from ..problems.materials import MATERIALS
    from ..problems.units import written
    from ..quantities import walk

    def shown(place: Any) -> str:
        text = written(place.value, place.quantity.unit, place.quantity.shown_unit)
        return f"{place.path} = " + (f'"{text}"' if isinstance(text, str) else f"{text:g}")

    def given(material: Any) -> list[Any]:
        return [place for place in walk(material) if place.value is not None]

    for name, known in MATERIALS.items():
        click.secho(name, bold=True)
        click.echo(f"  {{ {', '.join(map(shown, given(known.material)))} }}")
        click.secho(f"  {known.source}", dim=True)


@commands.command(
    help="""\
    List the grades of paper, film, foil and nonwoven; with a NAME its values.
    """,
)
@click.argument("name", required=False)
@click.option("--file", metavar="FILE", help="A TOML file with grades of your own.")
def grades(name: str | None, file: str | None) -> None:
    """List the grades, or the values of one with their spread and source."""
    from ..problems import grades as library

    click.echo(str(library.grades(file) if name is None else library.grade(name, file)))
