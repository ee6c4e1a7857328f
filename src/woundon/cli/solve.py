"""The command ``woundon solve``: solve a case file of any kind and print the report."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..errors import InvalidProblem, one_of, unwarned
from . import options

if TYPE_CHECKING:
    from pydantic.fields import FieldInfo

    from ..kinds import Kind, SolverOption
    from ..problems.problem import Problem
    from ..results import Result
    from ..sensitivity import Sensitivity

__all__ = ["solve"]


class SolveCommand(click.Command):
    """Has the options of the solvers of all kinds, which plug-ins may add."""

    def get_params(self, ctx: click.Context) -> list[click.Parameter]:
        """Return arguments and options."""
        *others, help_option = super().get_params(ctx)  # click adds --help at the end
        return [*others, *_solver_options(), *_wrap_options(), help_option]


def _check_result_file(path: Path) -> None:
    """Reject a file that is not of a format of results."""
    # the files of results import NumPy and pydantic
    from ..io.result_files import writer_for

    writer_for(path)


@options.command(
    "Solve the problem in a case file of any kind, and print the report.", cls=SolveCommand
)
@click.argument("case", type=options.PATH)
@options.SETTINGS
@options.UNITS
@options.DECIMAL_COMMA
@options.JSON
@click.option(
    "--sensitivity",
    is_flag=True,
    help="Print the local sensitivities of the main outputs to all inputs, largest first.",
)
@click.option(
    "--save",
    type=options.OutputFile(check=_check_result_file),
    help="Save the result as .nc, .json or .csv.",
)
@options.PLOT
def solve(
    case: Path,
    settings: tuple[str, ...],
    as_json: bool,
    sensitivity: bool,
    save: Path | None,
    plot: Path | None,
    **arguments: Any,
) -> None:
    """Solve a case file and print the report."""
    from .. import kinds

    given = {name: value for name, value in arguments.items() if value is not None}
    # wrap angles are fields of the case, so they are set like by --set; the others are the solver's
    wraps = [f"{name}={given.pop(name)}" for name in _wrap_fields() if name in given]
    problem = options.load_case(case, [*settings, *wraps])
    _check_options(kinds.of(problem), given, sensitivity)
    result = _solve(problem, given)
    derivatives = result.sensitivity() if sensitivity else None
    written = options.write({save: result.save, plot: result.plot})
    if as_json:
        from ..io.result_files import to_json

        click.echo(to_json(result, derivatives), nl=False)
    else:
        _print(result, derivatives)
    options.print_written(written, as_json)


# ---- options ------------------------------------------------------------------------------------


def _solver_options() -> Iterator[click.Option]:
    """Yield an option for each keyword-only argument of the solvers."""
    from ..kinds import every

    kinds_with: dict[str, list[Kind[Any, Any]]] = {}
    options_of_first: dict[str, SolverOption] = {}
    for kind in every():
        for name, option in kind.solver_options().items():
            options_of_first.setdefault(name, option)
            kinds_with.setdefault(name, []).append(kind)
    for name, owners in kinds_with.items():
        option = options_of_first[name]
        text = f"{option.help} See 'woundon describe'." if option.details else option.help
        if len(owners) < len(every()):
            text += f" Only for {one_of((kind.name for kind in owners), 'and')}."
        value_type = click.Choice(option.choices) if option.choices else option.type
        yield click.Option([options.option_name(name)], type=value_type, help=text.strip())


def _wrap_fields() -> dict[str, FieldInfo]:
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
        yield click.Option([options.option_name(name)], metavar="VALUE", help=field_comment(field))


def _check_options(kind: Kind[Any, Any], given: Iterable[str], sensitivity: bool) -> None:
    """Reject names of options that the solver of the kind does not have.

    ``sensitivity``: derivatives are requested, which the results of some kinds do not have.
    """
    from ..kinds import every

    known = kind.solver_options()
    text = f"not an option of the kind {kind.name!r}, which has " + (
        one_of(map(options.option_name, known), "and") or "none"
    )
    faults = [(options.option_name(name), text) for name in given if name not in known]
    if sensitivity and not hasattr(kind.result, "sensitivity"):
        others = one_of((k.name for k in every() if hasattr(k.result, "sensitivity")), "and")
        text = f"not available for the kind {kind.name!r}, but for {others}"
        faults.append(("--sensitivity", text))
    if faults:
        raise InvalidProblem(faults)


# ---- solving and printing -----------------------------------------------------------------------


def _solve(problem: Problem, arguments: Mapping[str, Any]) -> Any:
    """Solve, with a progress bar on a terminal if the solver reports its progress."""
    from .. import kinds
    from ..arguments import keywords_of

    reports = "progress" in keywords_of(kinds.of(problem).solver)
    with unwarned():  # the report contains the warnings
        if not (reports and sys.stderr.isatty()):
            return kinds.solve(problem, **arguments)
        from ..studies.bars import fraction_bar

        with fraction_bar() as progress:
            return kinds.solve(problem, progress=progress, **arguments)


def _print(result: Result, sensitivity: Sensitivity | None) -> None:
    """Print the report of a result, and its sensitivities."""
    from ..report.result_report import report_parts
    from ..report.sensitivity_report import sensitivity_parts
    from ..report.terminal import print_parts

    parts = report_parts(result)
    if sensitivity is not None:
        parts += sensitivity_parts(sensitivity)
    print_parts(parts, options.console())
