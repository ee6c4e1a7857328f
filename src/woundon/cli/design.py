"""The command ``woundon design``: a wanted pressure in, the tension that makes it out."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from ..errors import InvalidProblem
from ..io.files import check_writable, write_whole
from .solve import console

__all__ = ["design"]

_PATH = click.Path(path_type=Path)
COLUMNS = ("radius", "pressure")  # of a table of a wanted pressure; "value" is the pressure too


@click.command(
    help="""\
    Find the wound-on tension over the radius that leaves a wanted pressure in a wound roll.

    CASE is that of a wound roll ('woundon new roll'); its own tension plays no part. The roll
    is then wound forward with what was found, to see how near it comes. No pressure can be wanted
    of the surface itself; the depth of the influence is stated.
    """,
    short_help="Find the wound-on tension that leaves a wanted pressure in a roll.",
)
@click.argument("case", type=_PATH)
@click.option("--pressure", "wanted", required=True, metavar="TABLE|VALUE",
              help='Wanted between the laps: a CSV file with the columns radius and pressure, from '
              'the core to the surface, or one value, as "200 kPa".')  # fmt: skip
@click.option("--smooth", is_flag=True,
              help="Draw a cubic spline through the table, not a curve that stays between its "
              "values.")  # fmt: skip
@click.option("--rtol", type=float, default=1e-4, show_default=True,
              help="Accepted miss of the pressure inside, relative to the largest.")  # fmt: skip
@click.option("--set", "settings", multiple=True, metavar="FIELD=VALUE",
              help="Change a field of the case; repeatable.")  # fmt: skip
@click.option("--out", type=_PATH, metavar="FILE.csv",
              help='Write the tension over the radius; a case takes it back by [wound_on_tension], '
              'csv = "FILE.csv", between = "smooth".')  # fmt: skip
@click.option("--case", "new_case", type=_PATH, metavar="FILE.toml",
              help="Write the case with the tension found.")  # fmt: skip
@click.option("--plot", type=_PATH, metavar="FILE",
              help="Draw pressure and tension; .png, .svg or .pdf.")  # fmt: skip
def design(
    case: Path, wanted: str, smooth: bool, rtol: float, settings: tuple[str, ...],
    out: Path | None, new_case: Path | None, plot: Path | None,
) -> None:  # fmt: skip
    """Find the wound-on tension over the radius that leaves a wanted pressure in a wound roll."""
    from ..io.case_files import load_case
    from ..problems.roll import RollProblem
    from ..report.design_report import plot_design, print_design
    from ..report.figures import check_format

    for file, ending in ((out, ".csv"), (new_case, ".toml")):
        if file and file.suffix != ending:
            text = f"the ending {file.suffix!r} is not that of such a file; must be {ending}"
            raise InvalidProblem.at(str(file), text)
    for path in filter(None, (out, new_case, plot)):
        check_writable(path)
    if plot:
        check_format(plot)
    problem = load_case(case, settings)
    if not isinstance(problem, RollProblem):
        text = "is not the case of a wound roll; 'woundon new roll' writes one"
        raise InvalidProblem.at(str(case), text)
    from ..roll.design import design_tension
    from ..roll.solve import solve_wound_roll

    found = design_tension(problem, _wanted(wanted, smooth), rtol=rtol)
    wound = solve_wound_roll(found.problem, rtol=max(rtol, 1e-8))
    print_design(found, wound, console())
    if out:
        write_whole(out, _table(found).encode())
    if new_case:
        from ..io.case_texts import to_toml

        write_whole(new_case, to_toml(found.problem).encode())
    if plot:
        plot_design(found, wound, plot)


def _wanted(text: str, smooth: bool) -> Any:
    """Return a wanted pressure: a number [Pa], or the profile of a CSV file."""
    from ..io.columns import with_columns
    from ..problems.schedules import Profile
    from ..problems.units import parse

    if not text.lower().endswith(".csv"):
        if smooth:
            raise InvalidProblem.at("--smooth", "is given with one value; must be with a table")
        return parse(_number(text), "Pa", "pressure")
    columns = with_columns({"csv": text}, Path())
    columns = {"pressure" if name == "value" else name: cells for name, cells in columns.items()}
    if set(columns) != set(COLUMNS):
        told = ", ".join(map(str, columns))
        raise InvalidProblem.at(text, f"has the columns {told}; must be {' and '.join(COLUMNS)}")
    r, P = (
        [parse(cell, unit, f"{name}.{k}") for k, cell in enumerate(columns[name])]
        for name, unit in zip(COLUMNS, ("m", "Pa"), strict=True)
    )
    try:
        return Profile(radius=r, value=P, between="smooth" if smooth else "lines")
    except InvalidProblem as fault:
        raise fault.under(text) from None


def _number(text: str) -> str | float:
    try:
        return float(text)
    except ValueError:
        return text


def _table(found: Any) -> str:
    """Return the tension as the columns of a profile."""
    rows = zip(found.tension.radius, found.tension.value, strict=True)
    lines = [f"{1e3 * r:.9g},{T:.9g}" for r, T in rows]
    return "\n".join(["radius [mm],value [N/m]", *lines, ""])
