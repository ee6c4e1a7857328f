"""The command ``woundon find``: solve an inverse problem and print its solutions."""

from __future__ import annotations

from collections.abc import Iterator
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..errors import InvalidProblem
from ..io.chosen_units import units_of
from ..io.files import write_whole
from .options import PATH, PLOT, SETTINGS, TIES, UNITS, check_output_files

if TYPE_CHECKING:
    from ..studies.find import FindResult

__all__ = ["find"]


@click.command(
    help="""\
    Find the value of a field for which an output of a case reaches a target.

    All solutions in the range are printed, the smallest first, then the points of the scan. Exit
    status: 0 if there is a solution, 3 if there is none in the range, 2 for invalid input.
    """,
    short_help="Find the value of a field for which an output reaches a target.",
)
@click.argument("case", type=PATH)
@click.option(
    "--vary", required=True, metavar="FIELD[=LOW:HIGH]",
    help="The field to find, e.g. nip_load or nip_load='1 kN/m:5 kN/m'; without a range, a decade "
    "around the value of the case, and more if necessary.",
)  # fmt: skip
@click.option(
    "--target", required=True, metavar="OUTPUT=VALUE",
    help='The output and its target, e.g. wound_on_tension="300 N/m"; a plain number is SI.',
)  # fmt: skip
@TIES
@SETTINGS
@UNITS
@click.option("--points", type=click.IntRange(3, 1000), default=17, show_default=True,
              help="Points of the scan.")  # fmt: skip
@click.option("--nodes", type=int, help="Number of nodes along the nip.")
@click.option("--rtol", type=float, help="Relative error of the solver.")
@click.option("--json", "as_json", is_flag=True, help="Print solutions and scan as JSON.")
@click.option("--case", "new_case", type=PATH, metavar="FILE.toml",
              help="Write the case with the first solution.")  # fmt: skip
@PLOT
def find(
    case: Path, vary: str, target: str, ties: tuple[str, ...], settings: tuple[str, ...],
    chosen: tuple[str, ...], points: int, nodes: int | None, rtol: float | None, as_json: bool,
    new_case: Path | None, plot: Path | None,
) -> None:  # fmt: skip
    """Find the value of a field for which an output of a case reaches a target."""
    from ..errors import unwarned
    from ..io.case_files import load_case, to_toml
    from ..studies.find import find as find_values

    name, between = _field(vary)
    output, value = _pair(target, "OUTPUT=VALUE")
    if new_case and new_case.suffix != ".toml":
        raise InvalidProblem.at(str(new_case), f"the ending {new_case.suffix!r} is not .toml")
    check_output_files(plot, new_case)
    problem = load_case(case, settings)
    tie = dict(_pair(text, "FIELD=FIELD") for text in ties)
    aim: dict[str, Any] = {output: _number(value)}
    with units_of(chosen), unwarned():
        outcome = find_values(
            problem, name, between=between, points=points, tie=tie, progress=not as_json,
            nodes=nodes, rtol=rtol, **aim,
        )  # fmt: skip
        if new_case:
            write_whole(new_case, to_toml(outcome.problem).encode())
        if plot:
            outcome.plot(plot)
        for line in [outcome.to_json()] if as_json else _lines(outcome):
            click.echo(line)
    for text in () if as_json else outcome.result.warnings:
        click.secho(f"warning: {text}", fg="yellow", err=True)


def _field(text: str) -> tuple[str, list[str | float] | None]:
    """Return field and range of "FIELD" or "FIELD=LOW:HIGH"."""
    name, sign, ends = (part.strip() for part in text.partition("="))
    if not sign:
        return name, None
    parts = [_number(end.strip()) for end in ends.split(":")]
    if len(parts) != 2:
        raise InvalidProblem.at(name, f"{ends!r} is not a range; write LOW:HIGH")
    return name, parts


def _pair(text: str, form: str) -> tuple[str, str]:
    left, sign, right = (part.strip() for part in text.partition("="))
    if not sign or not left or not right:
        raise InvalidProblem.at(text, f"must be written {form}")
    return left, right


def _number(text: str) -> str | float:
    """Return a plain number as one, which is SI; anything else as text with its unit."""
    try:
        return float(text)
    except ValueError:
        return text


def _lines(outcome: FindResult) -> Iterator[str]:
    """Yield the solutions, then the table of all points, then the remarks."""
    from ..studies.find import remarks

    count = len(outcome.solutions)
    yield from outcome.lines()[:count]
    yield ""
    field, output = outcome.quantities[outcome.name], outcome.quantities[outcome.output]
    heads = [f"{name} [{quantity.display}]" if quantity.display else name
             for name, quantity in ((outcome.name, field), (outcome.output, output))]  # fmt: skip
    reasons = dict(outcome.failures)
    values = {value for value, _ in outcome.solutions}
    yield "  ".join(heads)
    for value, reached in zip(outcome.values.tolist(), outcome.outputs.tolist(), strict=True):
        left = f"{field.shown(value):{len(heads[0])}.6g}"
        right = f"{output.shown(reached):.6g}" if isfinite(reached) else "-"
        note = "  solution" if value in values else f"  {reasons.get(value, '')}".rstrip()
        yield f"{left}  {right:>{len(heads[1])}}{note}"
    yield ""
    yield from remarks(outcome)
