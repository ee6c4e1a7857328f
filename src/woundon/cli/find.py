"""The command ``woundon find``: solve an inverse problem and print its solutions."""

from __future__ import annotations

from collections.abc import Iterator
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..errors import InvalidProblem, unwarned
from ..io.files import write_whole
from .options import (
    JSON,
    NODES,
    PATH,
    PLOT,
    RTOL,
    SETTINGS,
    TIES,
    UNITS,
    FieldRange,
    Pair,
    as_number,
    check_output_files,
)

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
    "--vary",
    required=True,
    type=FieldRange(),
    metavar="FIELD[=LOW:HIGH]",
    help="The field to find, e.g. nip_load or nip_load='1 kN/m:5 kN/m'; without a range, a decade "
    "around the value of the case, and more if necessary.",
)
@click.option(
    "--target",
    required=True,
    type=Pair("OUTPUT=VALUE"),
    metavar="OUTPUT=VALUE",
    help='The output and its target, e.g. wound_on_tension="300 N/m"; a plain number is SI.',
)
@TIES
@SETTINGS
@UNITS
@click.option(
    "--points",
    type=click.IntRange(3, 1000),
    default=17,
    show_default=True,
    help="Points of the scan.",
)
@NODES
@RTOL
@JSON
@click.option(
    "--case",
    "new_case",
    type=PATH,
    metavar="FILE.toml",
    help="Write the case with the first solution.",
)
@PLOT
def find(
    case: Path,
    vary: tuple[str, tuple[str | float, str | float] | None],
    target: tuple[str, str],
    ties: tuple[tuple[str, str], ...],
    settings: tuple[str, ...],
    points: int,
    nodes: int | None,
    rtol: float | None,
    as_json: bool,
    new_case: Path | None,
    plot: Path | None,
) -> None:
    """Find the value of a field for which an output of a case reaches a target."""
    from ..io.case_files import load_case, to_toml
    from ..quantities import in_chosen_units
    from ..studies.find import find as find_values

    if new_case and new_case.suffix != ".toml":
        raise InvalidProblem.at(str(new_case), f"the ending {new_case.suffix!r} is not .toml")
    check_output_files(plot, new_case)
    problem = load_case(case, settings)
    (name, between), (output, value) = vary, target
    outputs: dict[str, Any] = {output: as_number(value)}
    with unwarned():
        result = find_values(
            problem,
            name,
            between=between,
            points=points,
            tie=dict(ties),
            progress=not as_json,
            nodes=nodes,
            rtol=rtol,
            **outputs,
        )
        if new_case:
            write_whole(new_case, to_toml(result.problem).encode())
        if plot:
            result.plot(plot)
        for line in [result.to_json()] if as_json else _lines(result):
            click.echo(line)
    for text in () if as_json else result.result.warnings:
        click.secho(f"warning: {in_chosen_units(text)}", fg="yellow", err=True)


def _lines(result: FindResult) -> Iterator[str]:
    """Yield the solutions, then the table of all points, then the remarks."""
    yield from result.answer()
    yield ""
    field, output = result.quantities[result.name], result.quantities[result.output]
    heads = [
        f"{name} [{quantity.display}]" if quantity.display else name
        for name, quantity in ((result.name, field), (result.output, output))
    ]
    yield "  ".join(heads)
    reasons = dict(result.failures)
    solutions = {value for value, _ in result.solutions}
    for value, reached in zip(result.values.tolist(), result.outputs.tolist(), strict=True):
        left = f"{field.shown(value):{len(heads[0])}.6g}"
        right = f"{output.shown(reached):.6g}" if isfinite(reached) else "-"
        note = "solution" if value in solutions else reasons.get(value, "")
        yield f"{left}  {right:>{len(heads[1])}}  {note}".rstrip()
    yield ""
    yield from result.remarks()
