"""``woundon solve`` and the commands of the kinds of problem: one command, made for each.

What a command takes and tells is read off its kind when it is called: the options are the
keyword-only arguments of the solver, their help its docstring; the fields and outputs that
``--help`` lists are those of problem and result.
"""

from __future__ import annotations

import inspect
import sys
from collections.abc import Iterable, Iterator, Mapping
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from .. import kinds
from ..errors import InvalidProblem, one_of, unwarned
from ..io.files import check_writable
from ..kinds import Kind

if TYPE_CHECKING:
    from rich.console import Console

__all__ = ["SolveCommand", "console"]

_ABOUT = """\
Solve the problem of a case file, of whatever kind ('woundon new' writes one)."""


class SolveCommand(click.Command):
    """Solves the case files of one kind of problem, or of any kind."""

    def __init__(self, kind: Kind | None) -> None:
        self.kind = kind
        about = kind.about if kind else _ABOUT
        super().__init__(
            kind.command if kind else "solve", callback=self.solve, help=about,
            short_help=about if kind else "Solve a case file of any kind.",
        )  # fmt: skip

    # ---- what it takes --------------------------------------------------------------------------

    def get_params(self, ctx: click.Context) -> list[click.Parameter]:
        """Return arguments and options, those of the solvers among them."""
        if not self.params:
            self.params = [*_common(self._kinds()), *self._solver_options(), *self._field_options()]
        return super().get_params(ctx)

    def _kinds(self) -> tuple[Kind, ...]:
        """Return the kinds that the command solves: its own, and those that a table makes of it."""
        if self.kind is None:
            return kinds.every()
        own = set(self.kind.problem.model_fields)
        return tuple(
            kind for kind in kinds.every()
            if kind is self.kind or set(kind.problem.model_fields) - set(_grouped(kind)) == own
        )  # fmt: skip

    def _solver_options(self) -> Iterator[click.Option]:
        all_of = self._kinds()
        known = {kind: kind.solver_options() for kind in all_of}
        for name in dict.fromkeys(name for options in known.values() for name in options):
            owners = [kind for kind in all_of if name in known[kind]]
            own = known[self.kind if self.kind in owners else owners[0]][name]
            about = f"{one_of(own.words)}. {own.about}" if own.words else own.about
            if self.kind is None and len({known[kind][name] for kind in owners}) > 1:
                about = f"As of each kind; 'woundon {owners[0].command} --help' says more."
            only = "" if owners == list(all_of) else f"[{', '.join(k.command for k in owners)}] "
            yield click.Option([_option(name)], type=own.type, help=f"{only}{about}",
                               metavar="NAME" if own.words else None)  # fmt: skip

    def _field_options(self) -> Iterator[click.Option]:
        """Yield an option for each field that case files group in a table: --roll-wrap."""
        from ..io.case_texts import described

        owners = {name: kind for kind in self._kinds() for name in _grouped(kind)}
        for name, kind in owners.items():
            about = described(kind.problem.model_fields[name])
            yield click.Option([_option(name)], metavar="VALUE", help=f"Set {about}.")

    # ---- what it does ---------------------------------------------------------------------------

    def solve(
        self, case: Path, settings: tuple[str, ...], chosen: tuple[str, ...], as_json: bool,
        save: Path | None, plot: Path | None, sensitivity: bool = False, **given: Any,
    ) -> None:  # fmt: skip
        """Solve a case file and show the result."""
        asked = {name: value for name, value in given.items() if value is not None}
        fields = {name for kind in self._kinds() for name in _grouped(kind)}
        changes = [f"{name}={asked.pop(name)}" for name in list(asked) if name in fields]
        problem = self._problem(case, [*settings, *changes])
        kind = kinds.of(problem)
        _check_options(kind, asked, sensitivity)
        _check_outputs(save, plot)
        # most runs choose none, and need not wait for the fields of all kinds
        units = _chosen_units(chosen) if chosen else nullcontext()
        with units:
            result = _solved(problem, asked)
            slopes = result.sensitivity() if sensitivity else None
            if save:
                result.save(save)
            if plot:
                result.plot(plot)
            if as_json:
                from ..io.result_files import to_json

                click.echo(to_json(result, slopes), nl=False)
            else:
                _show(result, slopes)

    def _problem(self, path: Path, settings: list[str]) -> Any:
        """Return the problem of a case file, if it is of the command's kind."""
        from ..io.case_files import apply_settings, make_problem, read_case

        case = apply_settings(read_case(path), settings)
        if self.kind is None or _fits(case, self.kind):
            return make_problem(case, self.kind.name if self.kind else None)
        other = next((kind for kind in kinds.every() if _fits(case, kind)), None)
        heads = {setting.partition("=")[0].partition(".")[0].strip() for setting in settings}
        if other is None or heads - _names(self.kind):  # misspelt, or asked for
            return make_problem(case, (other or self.kind).name)
        raise InvalidProblem.at(str(path), _which_fits(case, self.kind, other))

    # ---- what its help says ---------------------------------------------------------------------

    def format_epilog(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the fields of the kind's problem and the outputs of its result."""
        if self.kind is None:
            return
        for title, rows in [*_field_tables(self.kind.problem), _output_table(self.kind.result)]:
            with formatter.section(title):
                formatter.write_dl(rows, col_max=24)


def _option(name: str) -> str:
    return f"--{name.replace('_', '-')}"


def _common(all_of: Iterable[Kind]) -> Iterator[click.Parameter]:
    path = click.Path(path_type=Path)
    yield click.Argument(["case"], type=path)
    yield click.Option(
        ["--set", "settings"], multiple=True, metavar="FIELD=VALUE",
        help='Change a field, e.g. --set web.thickness="57 um"; repeatable; none leaves it out.',
    )  # fmt: skip
    yield click.Option(
        ["--unit", "chosen"], multiple=True, metavar="NAME=UNIT",
        help='Show a field or output in another unit, e.g. --unit nip_load="kN/m"; repeatable.',
    )  # fmt: skip
    yield click.Option(["--json", "as_json"], is_flag=True,
                       help="Print the complete result as JSON.")  # fmt: skip
    if any(hasattr(kind.result, "sensitivity") for kind in all_of):
        yield click.Option(["--sensitivity"], is_flag=True,
                           help="Tell what the outputs depend on most.")  # fmt: skip
    yield click.Option(["--save"], type=path, help="Save as .nc, .json or .csv.")
    yield click.Option(["--plot"], type=path, help="Draw to .png, .svg or .pdf.")


def _check_options(kind: Kind, asked: Mapping[str, Any], sensitivity: bool) -> None:
    """Refuse options that the kind's solver does not have."""
    known = kind.solver_options()
    has = ", ".join(map(_option, known)) or "none"
    faults = [(_option(name), f"no option of {_spoken(kind)}; it has {has}")
              for name in asked if name not in known]  # fmt: skip
    if sensitivity and not hasattr(kind.result, "sensitivity"):
        those = [k.command for k in kinds.every() if hasattr(k.result, "sensitivity")]
        faults.append(("--sensitivity", f"not available for {_spoken(kind)}, but for "
                       f"{one_of(those, 'and')}"))  # fmt: skip
    if faults:
        raise InvalidProblem(faults)


def _spoken(kind: Kind) -> str:
    return f"the kind {kind.command!r}"


# ---- the file's kind ----------------------------------------------------------------------------


def _names(kind: Kind) -> set[str]:
    return {*kind.problem.model_fields, *kind.problem.tables}


def _grouped(kind: Kind) -> dict[str, None]:
    """Return the fields that case files group in a table, in their order."""
    return {name: None for names in kind.problem.tables.values() for name in names}


def _fits(case: Mapping[str, Any], kind: Kind) -> bool:
    return set(case) - {"schema"} <= _names(kind)


def _which_fits(case: Mapping[str, Any], kind: Kind, other: Kind) -> str:
    text = f"is a case of {_spoken(other)}; use 'woundon solve' or 'woundon {other.command}'"
    beyond = [name for name in case if name not in _names(kind) | {"schema"}]
    needed = {name for name, field in kind.problem.model_fields.items() if field.is_required()}
    if needed <= set(case):
        text += f", or leave out what makes it one: {' '.join(f'--set {n}=none' for n in beyond)}"
    return text


# ---- solving and showing ------------------------------------------------------------------------


def _check_outputs(save: Path | None, plot: Path | None) -> None:
    """Refuse unusable output paths before anything is solved."""
    if save:
        from ..io.result_files import writer_for

        writer_for(save)
    if plot:
        from ..report.figures import check_format

        check_format(plot)
    for path in filter(None, (save, plot)):
        check_writable(path)


def _solved(problem: Any, options: Mapping[str, Any]) -> Any:
    """Solve, with a bar in a terminal if the solver reports its progress."""
    tells = "progress" in inspect.signature(kinds.of(problem).solver).parameters
    watched = tells and sys.stderr.isatty()
    shows = _progress_bar() if watched else nullcontext()
    with shows as progress, unwarned():  # the report shows the warnings
        return kinds.solve(problem, **options, **({"progress": progress} if watched else {}))


def _show(result: Any, sensitivity: Any) -> None:
    from ..report.reports import print_report
    from ..report.sections import print_sensitivity

    paper = console()
    print_report(result, paper)
    if sensitivity is not None:
        print_sensitivity(sensitivity, paper)


def console() -> Console:
    """Return the terminal as commands write on it."""
    from rich.console import Console

    class Terminal(Console):
        def on_broken_pipe(self) -> None:
            raise BrokenPipeError  # rich would end with exit code 1

    terminal = Terminal(highlight=False)
    # lines are never folded: what a pipe or a log gets is the same text
    terminal.width = max(terminal.width, 100)
    return terminal


# ---- help ---------------------------------------------------------------------------------------

_Table = tuple[str, list[tuple[str, str]]]


def _field_tables(problem: type[Any]) -> Iterator[_Table]:
    """Yield a table of the problem's fields, then of those of what it is made of, each once."""
    from ..io.case_texts import described
    from ..quantities import members_of

    owners: dict[tuple[type, ...], list[str]] = {(problem,): []}
    waiting: list[tuple[Any, ...]] = [(problem,)]
    for models in waiting:  # grows while it is walked
        rows: dict[str, str] = {}
        for name in dict.fromkeys(name for model in models for name in model.model_fields):
            having = [model for model in models if name in model.model_fields]
            field = having[0].model_fields[name]
            inner = members_of(field.annotation)
            if inner:
                owners.setdefault(inner, []).append(name)
                waiting += [inner] if inner not in waiting else []
            only = "" if having == list(models) else f"[{', '.join(map(_member, having))}] "
            rows[name] = only + (described(field) or "its fields are below")
        if len(models) > 1:
            rows = {"kind": one_of(map(_member, models)), **rows}
        of = one_of(dict.fromkeys(owners[models]), "and") if owners[models] else ""
        yield f"Fields of {of}" if of else "Fields of a case", list(rows.items())


def _member(model: Any) -> str:
    return str(model.member_name()) if hasattr(model, "member_name") else model.__name__


def _output_table(result: type[Any]) -> _Table:
    from ..quantities import outputs

    told = [(place.path, place.quantity) for place in outputs(result)]
    return "Outputs", [
        (name, f"{quantity.symbol}: {quantity.meaning}"
         + (f" [{quantity.unit}]" if quantity.unit != "1" else ""))
        for name, quantity in told if quantity
    ]  # fmt: skip


def _chosen_units(chosen: Any) -> Any:
    from ..io.chosen_units import units_of

    return units_of(chosen)


def _progress_bar() -> Any:
    from ..studies.bars import fraction_bar

    return fraction_bar()
