"""The command line: parse, call, show.  Everything heavy is imported by the command that uses it.

Exit codes: 0 done, 2 bad input (one line a fault), 3 not solved to tolerance.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import click

from . import __version__
from .errors import InvalidProblem, NotConverged
from .outputs import check_writable
from .studies import commands as study_commands

if TYPE_CHECKING:
    from .results import NipResult, Sensitivity
    from .wrap import WrappedNipResult

__all__ = ["main"]

BAD_INPUT = 2
NOT_CONVERGED = 3


def main(args: Sequence[str] | None = None) -> int:
    """Run the command line; return the exit code."""
    # a second BLAS thread makes matrices of this size slower, and must be set before NumPy loads
    for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ.setdefault(name, "1")
    try:
        return int(commands.main(args, "woundon", standalone_mode=False) or 0)
    except InvalidProblem as fault:
        return _refuse(str(fault).splitlines(), BAD_INPUT)
    except NotConverged as fault:
        return _refuse([f"not converged: {fault}"], NOT_CONVERGED)
    except click.exceptions.NoArgsIsHelpError as told:
        click.echo(told.format_message(), err=True)
        return BAD_INPUT
    except click.ClickException as fault:
        return _refuse([fault.format_message()], BAD_INPUT)
    except click.Abort:
        return 130
    except BrokenPipeError:
        # the reader (head, less) has left; nobody is there to tell
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except OSError as fault:
        where = f"{fault.filename}: " if fault.filename else ""
        return _refuse([f"{where}{fault.strerror or fault}"], BAD_INPUT)


def _refuse(lines: Sequence[str], code: int) -> int:
    for line in lines:
        click.secho(f"error: {line}", fg="red", err=True)
    return code


# commands of packages that come beside this one, which stand on it: found when they are asked for
_BESIDE = {"thesis": "jorkama2001.command"}


class _Commands(click.Group):
    """The program's own commands, and late those of the packages beside it."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names of all commands."""
        return sorted([*super().list_commands(ctx), *_BESIDE])

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Return a command by its name."""
        if cmd_name in _BESIDE:
            return cast("click.Command", getattr(import_module(_BESIDE[cmd_name]), cmd_name))
        return super().get_command(ctx, cmd_name)


@click.group(cls=_Commands, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="woundon")
def commands() -> None:
    """Winding mechanics: what the winding nip does to a paper or film web."""


@commands.command(short_help="Solve the winding nip of a case file.")
@click.argument("case", type=click.Path(path_type=Path))
@click.option(
    "--set",
    "settings",
    multiple=True,
    metavar="FIELD=VALUE",
    help='Change a field, e.g. --set nip_load="3.5 kN/m"; repeatable, nested: web.thickness.',
)
@click.option("--json", "as_json", is_flag=True, help="Print the complete result as JSON.")
@click.option("--sensitivity", is_flag=True, help="Tell what the outputs depend on most.")
@click.option("--save", type=click.Path(path_type=Path), help="Save as .nc, .json or .csv.")
@click.option("--plot", type=click.Path(path_type=Path), help="Draw to .png, .svg or .pdf.")
@click.option(
    "--scheme", default="graded", show_default=True, help="graded, thesis or thesis-printed."
)
@click.option("--algorithm", default="pivoting", show_default=True, help="Or panagiotopoulos.")
@click.option("--nodes", type=int, help="Number of nodes along the nip, fixed.")
@click.option("--rtol", type=float, help="Refine until the added tension is known to RTOL.")
@click.option(
    "--roll-wrap",
    metavar="ANGLE",
    help='Wrap the web on the roll behind the nip, e.g. "180 deg", where it is then held.',
)
@click.option(
    "--drum-wrap", metavar="ANGLE", help='Wrap the web on the drum before the nip, e.g. "90 deg".'
)
def nip(
    case: Path,
    settings: tuple[str, ...],
    as_json: bool,
    sensitivity: bool,
    save: Path | None,
    plot: Path | None,
    roll_wrap: str | None,
    drum_wrap: str | None,
    **options: Any,
) -> None:
    """Solve the winding nip of a case file ('woundon new' writes one)."""
    from .casefile import load_case

    problem = load_case(case, settings)
    _check_outputs(save, plot)
    result: NipResult | WrappedNipResult
    slopes = None
    if roll_wrap is None and drum_wrap is None:
        result = _solved(problem, options)
        slopes = result.sensitivity() if sensitivity else None
    else:
        options["sensitivity"] = sensitivity
        result = _solved_with_wraps(problem, roll_wrap, drum_wrap, options)
    if save:
        result.save(save)
    if plot:
        result.plot(plot)
    if as_json:
        from .resultfile import result_to_json

        click.echo(result_to_json(result, slopes), nl=False)
    else:
        _show(result, slopes)


def _check_outputs(save: Path | None, plot: Path | None) -> None:
    """Refuse unusable output paths before anything is solved."""
    if save:
        from .resultfile import writer_for

        writer_for(save)
    if plot:
        from .plots import check_format

        check_format(plot)
    for path in filter(None, (save, plot)):
        check_writable(path)


def _solved(problem: Any, options: dict[str, Any]) -> NipResult:
    import warnings

    from .errors import ValidityWarning
    from .nip import solve_nip

    with warnings.catch_warnings():
        # the result carries them too, and the report shows them
        warnings.simplefilter("ignore", ValidityWarning)
        return solve_nip(problem, **options)


def _solved_with_wraps(
    problem: Any, roll_wrap: str | None, drum_wrap: str | None, options: dict[str, Any]
) -> WrappedNipResult:
    from .units import parse
    from .wrap import solve_wrapped_nip

    plain = {"scheme": "graded", "algorithm": "pivoting", "rtol": None, "sensitivity": False}
    for name, usual in plain.items():
        if options[name] != usual:
            text = f"{options[name]!r} is not admissible with a wrap; leave it out, or the wraps"
            raise InvalidProblem.at(f"--{name}", text)
    given = {"roll_wrap": roll_wrap, "drum_wrap": drum_wrap}
    # a wrap that is not asked for is none; without one the web is held at the trailing edge
    chosen: dict[str, Any] = {"roll_wrap": 0.0} | {
        name: parse(text, "rad", f"--{name.replace('_', '-')}")
        for name, text in given.items()
        if text is not None
    }
    if options["nodes"] is not None:
        chosen["nodes"] = options["nodes"]
    return solve_wrapped_nip(problem, **chosen)


def _show(result: NipResult | WrappedNipResult, sensitivity: Sensitivity | None) -> None:
    from rich.console import Console

    from .report import print_report, print_sensitivity

    console = Console(highlight=False)
    # lines are never folded: what a pipe or a log gets is the same text
    console.width = max(console.width, 100)
    print_report(result, console)
    if sensitivity:
        print_sensitivity(sensitivity, console)


@commands.command(short_help="Print a commented case file to start from.")
def new() -> None:
    """Print a commented case file to start from: woundon new > case.toml."""
    from .casefile import template

    click.echo(template(), nl=False)


@commands.command()
def materials() -> None:
    """List the named materials with their values and sources."""
    from .materials import MATERIALS

    for name, (material, source) in MATERIALS.items():
        click.secho(name, bold=True)
        values = material.model_dump(exclude={"kind"}).items()
        click.echo(f"  {{ {', '.join(f'{field} = {_shown(value)}' for field, value in values)} }}")
        click.secho(f"  {source}", dim=True)


def _shown(value: float) -> str:
    """Return a modulus or a pure number as a case file would have it."""
    for factor, unit in ((1e9, "GPa"), (1e6, "MPa")):
        if value >= factor:
            return f'"{value / factor:g} {unit}"'
    return f"{value:g}"


for _command in (study_commands.sweep, study_commands.fit, study_commands.sensitivity):
    commands.add_command(_command)
