"""The command ``woundon schedule``: the tension schedule for a target pressure in a roll."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import click

from ..errors import InvalidProblem
from ..io.files import write_whole
from . import options

if TYPE_CHECKING:
    from ..problems.schedules import Profile

__all__ = ["schedule"]


@options.command(
    """\
    Compute the tension schedule for a target pressure in a roll.

    CASE is a case of the kind roll ('woundon new roll'); its own tension is ignored. The report
    states the pressure of a roll that is wound with the schedule. The pressure is zero at the
    outer surface; the report states how deep this boundary layer extends.
    """
)
@click.argument("case", type=options.PATH)
@click.option(
    "--pressure",
    "target",
    required=True,
    metavar="TABLE|VALUE",
    help="Target pressure between the layers: a table with the columns radius and "
    'pressure, from the core to the surface, or one value, as "200 kPa".',
)
@click.option(
    "--smooth", is_flag=True, help="Interpolate the table with a cubic spline; by default linearly."
)
@click.option(
    "--rtol",
    type=float,
    default=1e-4,
    show_default=True,
    help="Relative tolerance of the interior pressure.",
)
@options.SETTINGS
@options.UNITS
@options.DECIMAL_COMMA
@click.option(
    "--out",
    type=options.OutputFile(".csv"),
    help="Write the tension over the radius; a case reads it by [wound_on_tension], "
    'csv = "FILE.csv", between = "smooth".',
)
@options.NEW_CASE
@options.PLOT
def schedule(
    case: Path,
    target: str,
    smooth: bool,
    rtol: float,
    settings: tuple[str, ...],
    out: Path | None,
    new_case: Path | None,
    plot: Path | None,
) -> None:
    """Compute the tension schedule for a target pressure in a roll."""
    from ..io.case_texts import save_case
    from ..problems.roll import RollProblem
    from ..report.schedule_report import csv_text, plot_schedule, schedule_parts
    from ..report.terminal import print_parts
    from ..roll.design import design_tension
    from ..roll.solve import solve_wound_roll

    problem = options.load_case(case, settings)
    if not isinstance(problem, RollProblem):
        text = "is not a case of the kind roll; 'woundon new roll' writes one"
        raise InvalidProblem.at(str(case), text)
    solution = design_tension(problem, _target_pressure(target, smooth), rtol=rtol)
    roll = solve_wound_roll(solution.problem, rtol=max(rtol, 1e-8))  # the least of that solver
    print_parts(schedule_parts(solution, roll), options.console())
    files: options.Files = {
        out: lambda path: write_whole(path, csv_text(solution).encode()),
        new_case: partial(save_case, solution.problem),
        plot: partial(plot_schedule, solution, roll),
    }
    options.print_written(options.write(files))


def _target_pressure(text: str, smooth: bool) -> float | str | Profile:
    """Return a target pressure: a number [Pa], a text with a unit, or the profile in a file."""
    from ..io.columns import read_columns
    from ..io.sheets import TABLES
    from ..problems.schedules import Profile
    from ..quantities import length, stress

    if Path(text.rpartition("#")[0] or text).suffix.lower() not in TABLES:
        if smooth:
            raise InvalidProblem.at("--smooth", "is given with one value; must be with a table")
        return options.as_number(text)
    pressure = stress("P", "pressure between the layers")
    # "value" is the name of the column in files of schedules
    known = {"radius": length("r", "radius"), "pressure": pressure, "value": pressure}
    columns = read_columns(Path(text), known)
    if set(columns) not in ({"radius", "pressure"}, {"radius", "value"}):
        reason = f"has the columns {', '.join(columns)}; must be radius and pressure"
        raise InvalidProblem.at(text, reason)
    radius = columns.pop("radius")
    (target,) = columns.values()  # of the pressure, by either name
    try:
        return Profile(radius=radius, value=target, between="smooth" if smooth else "lines")
    except InvalidProblem as fault:
        raise fault.under(text) from None
