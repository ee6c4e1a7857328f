"""The command ``woundon compare``: compare measured values with predictions."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import click

from ..errors import InvalidProblem
from . import options

__all__ = ["compare"]

TAB_OPTIONS = {  # fields of a PullTab, which states their permitted values
    "slope": 'Pressure per force of the pull tab, "2 kPa/N".',
    "offset": "Pressure at zero force.",
    "friction": "Coefficient of friction of the tab.",
    "area": 'Area of one face of the tab, "12 cm^2".',
    "faces": "Sliding faces of the tab, 1 or 2; by default 2.",
    "deviation": 'Relative standard deviation of the calibration, "5 %".',
}


def _tab_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add the options --tab-slope, ... with the calibration of a pull tab."""
    for name, text in reversed(TAB_OPTIONS.items()):  # the last one added is the first in the help
        option = click.option(f"--tab-{name}", type=options.as_number, metavar="VALUE", help=text)
        command = option(command)
    return command


@options.command(
    """\
    Compare measured values with the predictions for a case.

    MEASURED is a table (.csv or .xlsx). A column is an input or an output by its name, with its
    unit, e.g. "nip_load [kN/m]", "wound_on_tension [N/m]", "nip_width [mm]"; "nip_width +- [mm]"
    holds standard deviations. For a roll or a winding also "pressure [kPa]", "pull_tab_force [N]"
    and "length [m]", with a column "measured_radius [mm]" or "diameter [mm]". Residuals, their
    error budget and possible explanations are printed. Exit status: 0 if a value has a prediction,
    3 if the solver did not converge at any row, 2 for invalid input.
    """
)
@click.argument("measured", type=options.PATH)
@click.argument("case", type=options.PATH)
@_tab_options
@click.option(
    "--spread",
    multiple=True,
    type=options.Pair("FIELD=VALUE", options.as_number),
    callback=options.as_mapping,
    help='Standard deviation of a field, "1 MPa" or "10 %"; repeatable.',
)
@options.COLUMNS
@options.TIES
@options.SETTINGS
@options.UNITS
@options.DECIMAL_COMMA
@options.NODES
@options.RTOL
@options.JSON
@options.SAVE_TABLE
@options.PLOT
def compare(
    measured: Path,
    case: Path,
    settings: tuple[str, ...],
    as_json: bool,
    save: Path | None,
    plot: Path | None,
    **arguments: Any,
) -> None:
    """Compare measured values with the predictions for a case."""
    from ..studies.compare import compare as compare_with
    from ..studies.export import write_table
    from ..studies.pull_tab import PullTab

    values = {name: arguments.pop(f"tab_{name}") for name in TAB_OPTIONS}
    calibration = {name: value for name, value in values.items() if value is not None}
    try:
        tab = PullTab(**calibration) if calibration else None
    except InvalidProblem as fault:
        raise fault.under("tab") from None
    problem = options.load_case(case, settings)
    comparison = compare_with(problem, measured, tab=tab, progress=True, **arguments)
    files: options.Files = {
        save: partial(write_table, comparison.to_dataframe()),
        plot: comparison.plot,
    }
    options.present(comparison, as_json, files, [*comparison.lines(), "", *comparison.table()])
