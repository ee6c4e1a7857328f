"""The command ``woundon window``: the probability that all limits of a roll are satisfied."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..errors import unwarned
from ..io.files import write_whole
from .options import (
    JSON,
    PATH,
    SETTINGS,
    UNITS,
    WORKERS,
    Numbers,
    Pair,
    as_number,
    check_output_files,
    resumable,
)

__all__ = ["window"]

if TYPE_CHECKING:
    from ..studies.window_result import OperatingWindow

RANGE = Numbers("LOW:HIGH")


@click.command(
    help="""\
    Map the probability that all margins of a winding are positive, over web tension and nip load.

    The inputs are uncertain: their relative standard deviations are those of the grade of the case,
    and of --uncertain. The ranges are of the values at the core; schedules keep their shape. Exit
    status: 0 if the map is complete, 2 for invalid input, 3 if too few windings can be solved.
    """,
    short_help="Map the operating window: the probability of a roll without defects.",
)
@click.argument("case", type=PATH)
@click.option(
    "--web-tension",
    required=True,
    type=RANGE,
    metavar="LOW:HIGH",
    help='Range at the core, e.g. "200 N/m:500 N/m"; plain numbers are SI.',
)
@click.option(
    "--nip-load",
    required=True,
    type=RANGE,
    metavar="LOW:HIGH",
    help="Range at the core.",
)
@click.option(
    "--torque-split",
    type=RANGE,
    metavar="LOW:HIGH",
    help="Range of the fraction of the web tension carried by the drum; by default as in the case.",
)
@click.option(
    "--uncertain",
    "spreads",
    multiple=True,
    type=Pair("FIELD=DEVIATION"),
    metavar="FIELD=DEVIATION",
    help="Relative standard deviation of an input, e.g. roll_friction=0.15; 0 removes that of the "
    "grade; repeatable.",
)
@click.option(
    "--at",
    "points",
    multiple=True,
    type=Numbers("TENSION:LOAD[:SPLIT]"),
    metavar="TENSION:LOAD[:SPLIT]",
    help="Print margins and contributions at a point as well; repeatable.",
)
@SETTINGS
@UNITS
@click.option(
    "--samples",
    type=int,
    default=2048,
    show_default=True,
    help="Number of samples of the uncertain inputs.",
)
@WORKERS
@click.option("--out", type=PATH, metavar="DIR", help="Store the solved windings in a folder.")
@click.option("--resume", is_flag=True, help="Resume the computation in the folder.")
@click.option(
    "--plot",
    type=PATH,
    metavar="FILE",
    help="Plot to .png, .svg or .pdf; a coarse preview is plotted first.",
)
@click.option("--csv", type=PATH, metavar="FILE.csv", help="Write the map as a table.")
@JSON
def window(
    case: Path,
    web_tension: list[str | float],
    nip_load: list[str | float],
    torque_split: list[str | float] | None,
    spreads: tuple[tuple[str, str], ...],
    points: tuple[list[str | float], ...],
    settings: tuple[str, ...],
    samples: int,
    workers: int | None,
    out: Path | None,
    resume: bool,
    plot: Path | None,
    csv: Path | None,
    as_json: bool,
) -> None:
    """Map the probability that all margins of a winding are positive."""
    from ..io.case_files import load_case
    from ..studies.window import operating_window

    check_output_files(plot, csv)
    ranges: dict[str, Any] = {"web_tension": web_tension, "nip_load": nip_load}
    if torque_split is not None:
        ranges["torque_split"] = torque_split
    for point in points:
        if len(point) != len(ranges):
            names = " and ".join(ranges)
            raise click.UsageError(f"--at needs {len(ranges)} values: {names}")
    uncertain: dict[str, Any] = {name: as_number(value) for name, value in spreads}
    problem: Any = load_case(case, settings)

    def draw(result: Any) -> None:
        if plot:
            result.plot(plot)

    with resumable(out), unwarned():
        result = operating_window(
            problem,
            **ranges,
            uncertain=uncertain or None,
            samples=samples,
            workers=workers,
            out=out,
            resume=resume,
            progress=not as_json,
            preview=draw,
        )
        draw(result)
        if csv:
            write_whole(csv, _csv_text(result).encode())
        at_points = [result.at(*point) for point in points]
        for line in [result.to_json()] if as_json else result.lines(*at_points):
            click.echo(line)


def _csv_text(window: OperatingWindow) -> str:
    """Return the map as a table with units in its header."""
    frame = window.to_dataframe()
    for name in window.names:
        unit, frame[name] = window.quantities[name].in_table(frame[name])
        frame = frame.rename(columns={name: name if unit == "1" else f"{name} [{unit}]"})
    return str(frame.to_csv(index=False))
