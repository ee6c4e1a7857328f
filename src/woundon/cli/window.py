"""The command ``woundon window``: the probability that a roll keeps its limits, over set points."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from ..errors import InvalidProblem
from ..io.chosen_units import units_of
from ..io.files import check_writable, write_whole
from .options import PATH, SETTINGS, UNITS

__all__ = ["window"]


@click.command(
    help="""\
    Map the probability that a winding keeps all its limits, over web tension and nip load.

    The inputs are uncertain: the spreads are those of the grade that the case names, and of
    --uncertain. The ranges are of the values at the core; schedules keep their shape. Exit status:
    0 if the map is complete, 2 for invalid input, 3 if too few windings can be solved.
    """,
    short_help="Map the probability that a winding keeps all its limits.",
)
@click.argument("case", type=PATH)
@click.option("--web-tension", "web_tension", required=True, metavar="LOW:HIGH",
              help='Range at the core, e.g. "200 N/m:500 N/m"; plain numbers are SI.')  # fmt: skip
@click.option("--nip-load", "nip_load", required=True, metavar="LOW:HIGH",
              help="Range at the core.")  # fmt: skip
@click.option(
    "--torque-split", "torque_split", metavar="LOW:HIGH",
    help="Range of the share that the drum pulls; by default as in the case.",
)  # fmt: skip
@click.option(
    "--uncertain", "spreads", multiple=True, metavar="FIELD=DEVIATION",
    help="Relative standard deviation of an input, e.g. roll_friction=0.15; 0 removes that of the "
    "grade; repeatable.",
)  # fmt: skip
@click.option(
    "--at", "points", multiple=True, metavar="TENSION:LOAD[:SPLIT]",
    help="Print margins and contributions at a point as well; repeatable.",
)  # fmt: skip
@SETTINGS
@UNITS
@click.option("--samples", type=int, default=2048, show_default=True,
              help="Draws from the distributions of the inputs.")  # fmt: skip
@click.option("--workers", type=int, help="Processes; by default one for each core.")
@click.option("--out", type=PATH, metavar="DIR", help="Store the windings in a folder.")
@click.option("--resume", is_flag=True, help="Continue the computation in the folder.")
@click.option("--plot", type=PATH, metavar="FILE",
              help="Draw to .png, .svg or .pdf; a coarse preview is drawn first.")  # fmt: skip
@click.option("--csv", "csv", type=PATH, metavar="FILE.csv", help="Write the map as a table.")
@click.option("--json", "as_json", is_flag=True, help="Print the best point as JSON.")
def window(
    case: Path, web_tension: str, nip_load: str, torque_split: str | None,
    spreads: tuple[str, ...], points: tuple[str, ...], settings: tuple[str, ...],
    chosen: tuple[str, ...], samples: int, workers: int | None, out: Path | None, resume: bool,
    plot: Path | None, csv: Path | None, as_json: bool,
) -> None:  # fmt: skip
    """Map the probability that a winding keeps all its limits."""
    from ..errors import unwarned
    from ..io.case_files import load_case
    from ..studies.window import operating_window

    if plot:
        from ..report.figures import check_format

        check_format(plot)
    for path in filter(None, (plot, csv)):
        check_writable(path)
    ranges: dict[str, Any] = {name: _parts(name, text, 2) for name, text in
              (("web_tension", web_tension), ("nip_load", nip_load))}  # fmt: skip
    if torque_split is not None:
        ranges["torque_split"] = _parts("torque_split", torque_split, 2)
    places = [_parts("at", text, len(ranges)) for text in points]
    uncertain = dict(_spread(text) for text in spreads)
    problem: Any = load_case(case, settings)

    def draw(preview: Any) -> None:
        if plot:
            preview.plot(plot)

    with units_of(chosen), unwarned():
        found = operating_window(
            problem, **ranges, uncertain=uncertain or None, samples=samples, workers=workers,
            out=out, resume=resume, progress=not as_json, preview=draw,
        )  # fmt: skip
        draw(found)
        if csv:
            write_whole(csv, found.to_dataframe().to_csv(index=False).encode())
        given = [found.at(*place) for place in places]
        lines = [found.to_json()] if as_json else found.lines(*given)
        for line in lines:
            click.echo(line)


def _parts(name: str, text: str, count: int) -> list[str | float]:
    parts = [_number(part.strip()) for part in text.split(":")]
    if len(parts) != count:
        raise InvalidProblem.at(name, f"{text!r} must have {count} values with : between them")
    return parts


def _spread(text: str) -> tuple[str, Any]:
    name, sign, value = (part.strip() for part in text.partition("="))
    if not sign or not name:
        raise InvalidProblem.at(text, "must be written FIELD=DEVIATION")
    return name, _number(value)


def _number(text: str) -> str | float:
    """Return a plain number as one, which is SI; anything else as text with its unit."""
    try:
        return float(text)
    except ValueError:
        return text
