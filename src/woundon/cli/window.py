"""The command ``woundon window``: the probability that all limits of a roll are satisfied."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

import click

from ..errors import unwarned
from . import options

__all__ = ["window"]

RANGE = options.Numbers("LOW:HIGH")


@options.command(
    """\
    Map the operating window: the probability of a roll without defects.

    The probability is that of positive margins of a winding, over web tension and nip load, or the
    rider load of a two-drum winder, or any fields of --vary: two or three ranges in all. The inputs
    are uncertain: their relative standard deviations are those of the grade of the case, and of
    --uncertain. The ranges are of the values at the core; schedules keep their shape. Exit status:
    0 if the map is complete, 2 for invalid input, 3 if too few windings can be solved.
    """
)
@click.argument("case", type=options.PATH)
@click.option(
    "--web-tension",
    type=RANGE,
    help='Range at the core, e.g. "200 N/m:500 N/m"; plain numbers are SI.',
)
@click.option("--nip-load", type=RANGE, help="Range at the core.")
@click.option(
    "--rider-load",
    type=RANGE,
    help="Range at the core, of a two-drum winder instead of --nip-load.",
)
@click.option(
    "--torque-split",
    type=RANGE,
    help="Range of the fraction of the web tension carried by the drum; by default as in the case.",
)
@click.option(
    "--vary",
    multiple=True,
    type=options.FieldRange(),
    callback=options.as_mapping,
    help='Range of any other field, e.g. oscillation="0 mm:200 mm"; repeatable.',
)
@click.option(
    "--uncertain",
    multiple=True,
    type=options.Pair("FIELD=DEVIATION", options.as_number),
    callback=options.as_mapping,
    help="Relative standard deviation of an input, e.g. roll_friction=0.15; 0 removes that of the "
    "grade; repeatable.",
)
@click.option(
    "--at",
    "points",
    multiple=True,
    type=options.Numbers("VALUE:VALUE[:VALUE]"),
    help="Print margins and contributions at a point as well, the values in the order of --help: "
    "web tension, load, torque split, then those of --vary; repeatable.",
)
@options.SETTINGS
@options.UNITS
@options.DECIMAL_COMMA
@click.option(
    "--samples",
    type=int,
    default=2048,
    show_default=True,
    help="Number of samples of the uncertain inputs.",
)
@options.WORKERS
@options.SCHEDULER
@click.option(
    "--out", type=options.PATH, metavar="DIR", help="Folder in which the windings are stored."
)
@options.RESUME
@click.option(
    "--plot",
    type=options.FIGURE,
    help="Plot to .png, .svg or .pdf; a coarse preview is plotted first.",
)
@click.option("--csv", type=options.TABLE, help="Write the map to .csv or .xlsx.")
@options.JSON
def window(
    case: Path,
    settings: tuple[str, ...],
    points: tuple[list[str | float], ...],
    plot: Path | None,
    csv: Path | None,
    as_json: bool,
    **arguments: Any,
) -> None:
    """Map the operating window: the probability of a roll without defects."""
    from ..studies.export import in_units, write_table
    from ..studies.window import operating_window

    named = ("web_tension", "nip_load", "rider_load", "torque_split")
    axes = [*(name for name in named if arguments[name]), *arguments["vary"]]
    for point in points:
        if len(point) != len(axes):
            raise click.UsageError(f"--at needs {len(axes)} values: {' and '.join(axes)}")

    with options.resumable(arguments["out"]), unwarned():
        result = operating_window(
            options.load_case(case, settings),
            progress=not as_json,
            preview=lambda coarse: options.write({plot: coarse.plot}),
            **arguments,
        )
        files: options.Files = {
            csv: partial(write_table, in_units(result.to_dataframe(), result.quantities)),
            plot: result.plot,
        }
        at_points = [result.at(*point) for point in points]
        options.present(result, as_json, files, result.lines(*at_points))
