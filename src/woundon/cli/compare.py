"""The command ``woundon compare``: compare measured values with predictions."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from .options import (
    COLUMNS,
    JSON,
    NODES,
    PATH,
    PLOT,
    RTOL,
    SETTINGS,
    TIES,
    UNITS,
    Pair,
    as_number,
    check_output_files,
)

__all__ = ["compare"]

TAB_OPTIONS = ("slope", "offset", "friction", "area", "faces", "deviation")


@click.command(
    help="""\
    Compare a table of measured values (.csv or .xlsx) with the predictions for a case.

    A column is an input or an output by its name, with its unit, e.g. "nip_load [kN/m]",
    "wound_on_tension [N/m]", "nip_width [mm]"; "nip_width +- [mm]" holds standard deviations. For a
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
@click.option(
    "--tab-faces", type=click.IntRange(1, 2), help="Sliding faces of the tab; by default 2."
)
@click.option(
    "--tab-deviation",
    metavar="VALUE",
    help='Relative standard deviation of the calibration, "5 %".',
)
@click.option(
    "--spread",
    "spreads",
    multiple=True,
    type=Pair("FIELD=VALUE"),
    metavar="FIELD=VALUE",
    help='Standard deviation of a field, "1 MPa" or "10 %"; repeatable.',
)
@COLUMNS
@TIES
@SETTINGS
@UNITS
@NODES
@RTOL
@JSON
@click.option("--save", type=PATH, metavar="FILE", help="Save all values as .csv or .xlsx, in SI.")
@PLOT
def compare(
    measured: Path,
    case: Path,
    spreads: tuple[tuple[str, str], ...],
    columns: tuple[tuple[str, str], ...],
    ties: tuple[tuple[str, str], ...],
    settings: tuple[str, ...],
    nodes: int | None,
    rtol: float | None,
    as_json: bool,
    save: Path | None,
    plot: Path | None,
    **tab: Any,
) -> None:
    """Compare a table of measured values with the predictions for a case."""
    from ..io.case_files import load_case
    from ..studies.compare import compare as compare_with
    from ..studies.export import TABLES, check_export, write_table
    from ..studies.pull_tab import PullTab

    if save:
        check_export(save, TABLES)
    check_output_files(plot, save)
    problem = load_case(case, settings)
    values = {name: tab[f"tab_{name}"] for name in TAB_OPTIONS}
    calibration: dict[str, Any] = {
        name: as_number(value) if isinstance(value, str) else value
        for name, value in values.items()
        if value is not None
    }
    comparison = compare_with(
        problem,
        measured,
        tab=PullTab(**calibration) if calibration else None,
        spread={name: as_number(value) for name, value in spreads},
        columns={name: assigned or None for name, assigned in columns},
        tie=dict(ties),
        nodes=nodes,
        rtol=rtol,
        progress=True,
    )
    if save:
        write_table(comparison.to_dataframe(), save)
    if plot:
        comparison.plot(plot)
    text = [*comparison.lines(), "", *comparison.table()]
    for line in [comparison.to_json()] if as_json else text:
        click.echo(line)
