"""The command ``woundon solve``: solve a case file of any kind and print the report."""

from __future__ import annotations

import inspect
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..errors import InvalidProblem, one_of, unwarned
from .options import PATH, SETTINGS, UNITS, check_output_files

if TYPE_CHECKING:
    from rich.console import Console

    from ..kinds import Kind

__all__ = ["console", "solve"]


class SolveCommand(click.Command):
    """Has the options of the solvers of all kinds, which plug-ins may add."""

    def get_params(self, ctx: click.Context) -> list[click.Parameter]:
        """Return arguments and options."""
        *others, help_option = super().get_params(ctx)
        return [*others, *_solver_options(), *_wrap_options(), help_option]


@click.command(
    cls=SolveCommand,
    help="Solve the problem in a case file (any kind; see 'woundon new'), and print the report.",
    short_help="Solve a case file of any kind.",
)
@click.argument("case", type=PATH)
@SETTINGS
@UNITS
@click.option("--json", "as_json", is_flag=True, help="Print the complete result as JSON.")
@click.option(
    "--sensitivity",
    is_flag=True,
    help="Print the local sensitivities of the main outputs to all inputs, largest first.",
)
@click.option("--save", type=PATH, metavar="FILE", help="Save the result as .nc, .json or .csv.")
@click.option("--plot", type=PATH, metavar="FILE", help="Plot to .png, .svg or .pdf.")
def solve(
    case: Path,
    settings: tuple[str, ...],
    as_json: bool,
    sensitivity: bool,
    save: Path | None,
    plot: Path | None,
    **options: Any,
) -> None:
    """Solve a case file and print the report."""
    from .. import kinds
    from ..io.case_files import load_case
    from ..io.result_files import to_json, writer_for

    solver_options = {name: value for name, value in options.items() if value is not None}
    wraps = [
        f"{name}={solver_options.pop(name)}"
        for name in list(solver_options)
        if name in _wrap_fields()
    ]
    problem = load_case(case, [*settings, *wraps])
    _check_options(kinds.of(problem), solver_options, sensitivity)
    if save:
        writer_for(save)
    check_output_files(plot, *([save] if save else []))
    result = _solve(problem, solver_options)
    derivatives = result.sensitivity() if sensitivity else None
    if save:
        result.save(save)
    if plot:
        result.plot(plot)
    if as_json:
        click.echo(to_json(result, derivatives), nl=False)
    else:
        _print(result, derivatives)


# ---- options ------------------------------------------------------------------------------------


def _option_name(name: str) -> str:
    return f"--{name.replace('_', '-')}"


def _solver_options() -> Iterator[click.Option]:
    """Yield an option for each keyword-only argument of the solvers."""
    from ..kinds import every

    known = [(kind, kind.solver_options()) for kind in every()]
    for name in dict.fromkeys(name for _, options in known for name in options):
        owners = [kind.name for kind, options in known if name in options]
        option = next(options[name] for _, options in known if name in options)
        note = "" if len(owners) == len(known) else f" Only for {one_of(owners, 'and')}."
        details = f"{option.help} See 'woundon describe'." if option.details else option.help
        yield click.Option(
            [_option_name(name)],
            type=click.Choice(option.choices) if option.choices else option.type,
            help=f"{details}{note}".strip(),
        )


def _wrap_fields() -> dict[str, Any]:
    """Return the fields that case files group in a table, by name: the wrap angles."""
    from ..kinds import every

    return {
        name: kind.problem.model_fields[name]
        for kind in every()
        for names in kind.problem.tables.values()
        for name in names
    }


def _wrap_options() -> Iterator[click.Option]:
    """Yield an option for each field that case files group in a table: --roll-wrap."""
    from ..io.case_texts import field_comment

    for name, field in _wrap_fields().items():
        yield click.Option([_option_name(name)], metavar="VALUE", help=field_comment(field))


def _check_options(kind: Kind[Any, Any], options: Mapping[str, Any], sensitivity: bool) -> None:
    """Reject options that the solver of the kind does not have."""
    from ..kinds import every

    known = kind.solver_options()
    text = f"not an option of the kind {kind.name!r}, which has " + (
        one_of(map(_option_name, known), "and") or "none"
    )
    faults = [(_option_name(name), text) for name in options if name not in known]
    if sensitivity and not hasattr(kind.result, "sensitivity"):
        others = one_of((k.name for k in every() if hasattr(k.result, "sensitivity")), "and")
        text = f"not available for the kind {kind.name!r}, but for {others}"
        faults.append(("--sensitivity", text))
    if faults:
        raise InvalidProblem(faults)


# ---- solving and printing -----------------------------------------------------------------------


def _solve(problem: Any, options: Mapping[str, Any]) -> Any:
    """Solve, with a progress bar on a terminal if the solver reports its progress."""
    from .. import kinds
    from ..studies.bars import fraction_bar

    reports = "progress" in inspect.signature(kinds.of(problem).solver).parameters
    with unwarned():  # the report contains the warnings
        if not (reports and sys.stderr.isatty()):
            return kinds.solve(problem, **options)
        with fraction_bar() as progress:
            return kinds.solve(problem, progress=progress, **options)


def _print(result: Any, sensitivity: Any) -> None:
    """Print the report of a result, and its sensitivities."""
    from ..report.result_report import print_report
    from ..report.sensitivity_report import print_sensitivity

    terminal = console()
    print_report(result, terminal)
    if sensitivity is not None:
        print_sensitivity(sensitivity, terminal)


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
