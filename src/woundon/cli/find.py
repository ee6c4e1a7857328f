"""The command ``woundon find``: solve an inverse problem and print its solutions."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from inspect import signature
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..errors import InvalidProblem, unwarned
from ..quantities import header
from . import options

if TYPE_CHECKING:
    from ..studies.find import FindResult

__all__ = ["find"]


@options.command(
    """\
    Find the value of a field for which an output reaches a target.

    All solutions in the range are printed, the smallest first, then the points of the scan. Exit
    status: 0 if there is a solution, 3 if there is none in the range, 2 for invalid input.
    """
)
@click.argument("case", type=options.PATH)
@click.option(
    "--vary",
    required=True,
    type=options.FieldRange(),
    help="The field to find, e.g. nip_load or nip_load='1 kN/m:5 kN/m'; without a range, a decade "
    "around the value of the case, and more if necessary.",
)
@click.option(
    "--target",
    required=True,
    type=options.Pair("OUTPUT=VALUE", options.as_number),
    help='The output and its target, e.g. wound_on_tension="300 N/m"; a plain number is SI.',
)
@options.TIES
@options.SETTINGS
@options.UNITS
@click.option(
    "--points",
    type=click.IntRange(3, 1000),
    default=17,
    show_default=True,
    help="Points of the scan.",
)
@options.NODES
@options.RTOL
@options.JSON
@options.NEW_CASE
@options.PLOT
def find(
    case: Path,
    settings: tuple[str, ...],
    vary: tuple[str, tuple[float | str, float | str] | None],
    target: tuple[str, str | float],
    as_json: bool,
    new_case: Path | None,
    plot: Path | None,
    **arguments: Any,
) -> None:
    """Find the value of a field for which an output reaches a target."""
    from ..io.case_texts import save_case
    from ..quantities import in_chosen_units
    from ..studies.find import find as find_values

    (name, between), (output, value) = vary, target
    if output in signature(find_values).parameters:  # the target is passed as output=value
        raise InvalidProblem.at("target", f"{output!r} is an option, not an output")
    arguments |= {"between": between, "progress": not as_json, output: value}
    with unwarned():
        result = find_values(options.load_case(case, settings), name, **arguments)
        files: options.Files = {new_case: partial(save_case, result.problem), plot: result.plot}
        options.present(result, as_json, files, _lines(result))
    for text in () if as_json else result.result.warnings:
        click.secho(f"warning: {in_chosen_units(text)}", fg="yellow", err=True)


def _lines(result: FindResult) -> Iterator[str]:
    """Yield the solutions, then the table of all points, then the remarks."""
    yield from result.answer()
    yield ""
    field, output = result.quantities[result.name], result.quantities[result.output]
    heads = [header(result.name, field.display), header(result.output, output.display)]
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
