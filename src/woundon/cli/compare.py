"""The command ``woundon compare``: measured values against predictions."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from ..errors import InvalidProblem
from ..io.chosen_units import units_of
from .options import COLUMNS, PATH, PLOT, SETTINGS, TIES, UNITS, check_output_files

__all__ = ["compare"]

_TAB = ("slope", "offset", "friction", "area", "faces", "deviation")


@click.command(
    help="""\
    Compare a table of measured values (.csv or .xlsx) with the predictions for a case.

    A column is an input or an output by its name, with its unit, e.g. "nip_load [kN/m]",
    "wound_on_tension [N/m]", "nip_width [mm]"; "nip_width +- [mm]" holds standard deviations. Of a
    roll or a winding also "pressure [kPa]", "pull_tab_force [N]" and "length [m]", with a column
    "measured_radius [mm]" or "diameter [mm]". Residuals, their error budget and possible
    explanations are printed. Exit status: 0 if a value has a prediction, 3 if the solver did not
    converge at any row, 2 for invalid input.
    """,
    short_help="Compare measured values with the predictions for a case.",
)
@click.argument("measured", type=PATH)
@click.argument("case", type=PATH)
@click.option("--tab-slope", metavar="VALUE", help='Pressure per force of the pull tab, "2 kPa/N".')
@click.option("--tab-offset", metavar="VALUE", help="Pressure at zero force.")
@click.option("--tab-friction", type=float, help="Coefficient of friction of the tab.")
@click.option("--tab-area", metavar="VALUE", help='Area of one face of the tab, "12 cm^2".')
@click.option("--tab-faces", type=click.IntRange(1, 2), help="Sliding faces of the tab; 2.")
@click.option("--tab-deviation", metavar="VALUE",
              help='Relative standard deviation of the calibration, "5 %".')  # fmt: skip
@click.option("--spread", "spreads", multiple=True, metavar="FIELD=VALUE",
              help='Standard deviation of a field, "1 MPa" or "10 %"; repeatable.')  # fmt: skip
@COLUMNS
@TIES
@SETTINGS
@UNITS
@click.option("--nodes", type=int, help="Number of nodes along the nip.")
@click.option("--rtol", type=float, help="Relative error of the solver.")
@click.option("--json", "as_json", is_flag=True, help="Print the comparison as JSON.")
@click.option("--save", type=PATH, metavar="FILE", help="Save all values as .csv or .xlsx, in SI.")
@PLOT
def compare(
    measured: Path, case: Path, spreads: tuple[str, ...], columns: tuple[str, ...],
    ties: tuple[str, ...], settings: tuple[str, ...], chosen: tuple[str, ...], nodes: int | None,
    rtol: float | None, as_json: bool, save: Path | None, plot: Path | None, **tab: Any,
) -> None:  # fmt: skip
    """Compare a table of measured values with the predictions for a case."""
    from ..io.case_files import load_case
    from ..studies.case_table import check_table_path, write_table
    from ..studies.compare import compare as compare_with
    from ..studies.pull_tab import PullTab

    if save:
        check_table_path(save)
    check_output_files(plot, save)
    problem = load_case(case, settings)
    calibration = {
        name: _number(value) for name in _TAB if (value := tab[f"tab_{name}"]) is not None
    }
    with units_of(chosen):
        comparison = compare_with(
            problem, measured, tab=PullTab(**calibration) if calibration else None,
            spread={name: _number(value) for name, value in map(_pair, spreads) if value},
            columns={name: of or None for name, of in map(_pair, columns)},
            tie=dict(map(_pair, ties)), nodes=nodes, rtol=rtol,
        )  # fmt: skip
        if save:
            write_table(comparison.to_dataframe(), save)
        if plot:
            comparison.plot(plot)
        for line in (
            [comparison.to_json()] if as_json else [*comparison.lines(), "", *comparison.table()]
        ):
            click.echo(line)


def _pair(text: str) -> tuple[str, str]:
    left, sign, right = (part.strip() for part in text.partition("="))
    if not sign or not left:
        raise InvalidProblem.at(text, "must be written NAME=VALUE")
    return left, right


def _number(text: Any) -> Any:
    """Return a plain number as one, which is SI; anything else as text with its unit."""
    try:
        return float(text) if isinstance(text, str) else text
    except ValueError:
        return text
