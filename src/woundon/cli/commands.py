"""The command line: parse the arguments, call a public function, print the result.

Every command stands in a module of this package; plug-ins add theirs (:mod:`woundon.plugins`).
Libraries that take long to import are imported inside the commands, so that ``--help`` is fast.

Exit codes: 0 success, 2 invalid input (one line for each error), 3 not converged or (``find``) no
solution in the range, 130 interrupted by Ctrl-C, 143 by SIGTERM, 129 by SIGHUP.
"""

from __future__ import annotations

import atexit
import gc
import os
import signal
import sys
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from copy import copy
from io import TextIOWrapper
from typing import Any

import click
from click.shell_completion import shell_complete

from .. import __version__, plugins
from ..errors import (
    InvalidProblem,
    NoSolution,
    NotConverged,
    did_you_mean,
    mapping_of,
    one_of,
    printable_line,
)
from ..parallel import environment, terminations_as_interrupts
from .app import app
from .compare import compare
from .describe import describe, grades, materials
from .find import find
from .new import new
from .report import report
from .schedule import schedule
from .solve import solve
from .stack import stack
from .studies import fit, plan, sobol, sweep
from .table import table
from .window import window

__all__ = ["commands", "main"]

INVALID_INPUT = 2
NOT_CONVERGED = 3
SIGNAL = 128  # shells add the number of the signal that ended a command
INTERRUPTED = SIGNAL + signal.SIGINT

SECTIONS = {
    "Cases": (new, describe, solve, report, app),
    "Questions": (find, compare, table, schedule, window, stack),
    "Studies": (sweep, sobol, fit, plan),
    "Libraries": (grades, materials),
}


def main(args: Sequence[str] | None = None) -> int:
    """Run the command line; return the exit code.

    >>> main(["--version"])
    woundon, version 0.4.0.dev0
    0
    """
    # when the process ends, Python would search all modules four times for unused objects
    atexit.register(gc.freeze)
    for name, value in environment().items():  # read by NumPy when it is imported
        os.environ.setdefault(name, value)
    # pydantic would read the entry points of all installed packages for plug-ins of its own
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")
    if isinstance(sys.stdout, TextIOWrapper):  # as Python does for errors
        sys.stdout.reconfigure(errors="backslashreplace")
    code = INTERRUPTED
    with suppress(KeyboardInterrupt), terminations_as_interrupts() as arrived:
        # a second signal does not change the exit code
        with _warnings_in_one_line():
            code = _run(sys.argv[1:] if args is None else args)
        for stream in filter(None, (sys.stdout, sys.stderr)):
            try:
                stream.flush()
            except OSError:  # Python would report it when it exits
                os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
    return SIGNAL + arrived[0] if arrived else code


def _run(args: Sequence[str]) -> int:
    """Run the command line, print errors, and return the exit code."""
    try:
        if request := os.environ.get("_WOUNDON_COMPLETE"):  # of the shell
            return shell_complete(commands, {}, "woundon", "_WOUNDON_COMPLETE", request)
        with commands.make_context("woundon", list(args)) as context:
            code = int(commands.invoke(context) or 0)
        if sys.stdout:
            sys.stdout.flush()
        return code
    except click.exceptions.Exit as end:  # of --help and --version
        return end.exit_code
    except NoSolution as fault:
        return _print_errors([f"no solution: {fault}"], NOT_CONVERGED)
    except InvalidProblem as fault:
        return _print_errors(str(fault).splitlines(), INVALID_INPUT)
    except NotConverged as fault:
        return _print_errors([f"not converged: {fault}"], NOT_CONVERGED)
    except click.exceptions.NoArgsIsHelpError as fault:
        with suppress(OSError):
            click.echo(fault.format_message(), err=True)
        return INVALID_INPUT
    except click.NoSuchOption as fault:
        return _print_errors([_no_such_option(fault)], INVALID_INPUT)
    except click.ClickException as fault:
        return _print_errors([fault.format_message()], INVALID_INPUT)
    except (KeyboardInterrupt, click.Abort) as fault:
        return _print_interruption(str(fault))
    except RuntimeError as fault:
        # Python 3.11 raises it for Ctrl-C while a class is defined, as during an import
        if not isinstance(fault.__cause__, KeyboardInterrupt):
            raise
        return _print_interruption()
    except BrokenPipeError:
        return 0  # the reader, such as head, has read enough
    except OSError as fault:
        place = f"{fault.filename}: " if fault.filename else ""
        return _print_errors([f"{place}{fault.strerror or fault}"], INVALID_INPUT)


def _no_such_option(fault: click.NoSuchOption) -> str:
    """Return the message for an unknown option, with those of the command that are like it."""
    name = fault.option_name
    params = fault.ctx.command.get_params(fault.ctx) if fault.ctx else []
    known = [option for param in params for option in param.opts if option.startswith("--")]
    alike = [option for option in known if option[2:].startswith(name.lstrip("-"))]
    hint = f"; did you mean {one_of(alike)}?" if alike else did_you_mean(name, known)
    return f"No such option {name!r}{hint}"


def _print_errors(lines: Sequence[str], code: int) -> int:
    """Print lines to the error channel, which may be closed; return ``code``, the exit code."""
    with suppress(OSError):
        for line in lines:
            click.secho(f"error: {printable_line(line)}", fg="red", err=True)
    return code


def _print_interruption(text: str = "") -> int:
    """Print one line to the error channel, whose terminal may be closed; return the exit code."""
    with suppress(OSError):
        click.echo(text or "interrupted; nothing is kept", err=True)
    return INTERRUPTED


@contextmanager
def _warnings_in_one_line() -> Iterator[None]:
    """Print each warning in one line, without the place in the source."""

    def show(message: Warning | str, *place: Any) -> None:
        click.secho(f"warning: {message}", fg="yellow", err=True)

    with warnings.catch_warnings():
        warnings.showwarning = show  # type: ignore[assignment]
        yield


class Commands(click.Group):
    """The commands in sections, and those of plug-ins."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names of all commands."""
        return [*self.commands, *plugins.commands()]

    def get_command(self, ctx: click.Context, name: str) -> click.Command | None:
        """Return a command by its name."""
        return self.commands.get(name) or plugins.commands().get(name)

    def resolve_command(self, ctx: click.Context, args: list[str]) -> Any:
        """Return the command of the arguments; suggest a name for a misspelt one."""
        name = args[0]
        if self.get_command(ctx, name) is None and not name.startswith("-"):
            ctx.fail(f"No such command {name!r}{did_you_mean(name, self.list_commands(ctx))}")
        resolved = super().resolve_command(ctx, args)
        _, command, arguments = resolved
        if command is not None and not ctx.resilient_parsing:  # as for the completion in a shell
            with _modules_kept():  # options may be those of all solvers
                _check_given_once(click.Context(command, parent=ctx), arguments)
        return resolved

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the commands of each section with their summaries."""
        for title, members in {**SECTIONS, "Plug-ins": plugins.commands().values()}.items():
            rows = [(command.name or "", command.get_short_help_str(200)) for command in members]
            if rows:
                with formatter.section(title):
                    formatter.write_dl(rows)


@contextmanager
def _modules_kept() -> Iterator[None]:
    """Import modules without searching their objects for unused ones, then or later.

    The search takes a tenth of the time of a solution.  Only once in a process: what is unused by
    then is kept as well.
    """
    if gc.get_freeze_count():
        yield
        return
    gc.disable()
    try:
        yield
    finally:
        gc.freeze()
        gc.enable()


def _check_given_once(context: click.Context, arguments: Sequence[str]) -> None:
    """Reject an option that is given twice, or a repeatable one that is given twice alike.

    click would use the last value, and has no record of the others; so the arguments are parsed
    with all options repeatable.

    Parameters
    ----------
    context : click.Context
        Of the command.
    arguments : sequence of str
        Those of the command.
    """
    parser = click.Command(None).make_parser(context)
    for param in context.command.get_params(context):
        collecting = copy(param)
        collecting.multiple = isinstance(param, click.Option) and not param.is_flag
        collecting.add_to_parser(parser, context)
    with suppress(click.UsageError):  # reported when the command itself reads its arguments
        values, *_ = parser.parse_args(list(arguments))
        for option in context.command.get_params(context):
            if isinstance(option, click.Option) and not option.is_flag:
                texts = values.get(option.name, ())
                # a repeatable option must have different texts, another one may have one text only:
                # all have the same name
                names = texts if option.multiple else [""] * len(texts)
                mapping_of(zip(names, texts, strict=True), option.opts[-1])  # the long form


@click.group(
    help="Winding mechanics: wound-on tension, nip stick-slip and wound-roll stresses of paper and "
    "film webs.",
    cls=Commands,
    context_settings={"help_option_names": ["-h", "--help"]},
)
@click.version_option(__version__, prog_name="woundon")
def commands() -> None:
    """Winding mechanics: wound-on tension, nip stick-slip and wound-roll stresses of webs."""


for _members in SECTIONS.values():
    for _command in _members:
        commands.add_command(_command)
