"""The commands ``woundon sweep``, ``sobol``, ``fit`` and ``plan``."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..errors import InvalidProblem, unwarned
from ..io.files import write_whole
from . import options

if TYPE_CHECKING:
    from ..studies.run import Table

__all__ = ["fit", "plan", "sobol", "sweep"]

EXPORTS = ("nc", "csv", "xlsx", "parquet")


def _execution_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add the options for processes and folders of a study."""
    for option in (
        options.WORKERS,
        options.SCHEDULER,
        options.RESUME,
        click.option(
            "--out", type=options.PATH, required=True, metavar="DIR", help="Folder of results."
        ),
        click.option(
            "--export-to",
            type=options.PATH,
            metavar="FOLDER",
            help="Folder of exported files and figures; by default DIR.",
        ),
    ):
        command = option(command)
    return command


@options.command(
    """\
    Solve all cases of a study file.

    An example is examples/study_nip_load_and_shear.toml. Results are written to DIR/study.sqlite
    chunk by chunk, so that an interrupted study can be resumed with --resume. The same option
    exports a complete study again, with --export-to also from a read-only medium.
    """
)
@click.argument("study", type=options.PATH)
@_execution_options
@click.option("--chunk", type=click.IntRange(1), help="Number of cases per chunk.")
@options.UNITS
@options.DECIMAL_COMMA
@click.option(
    "--export",
    "exports",
    multiple=True,
    type=click.Choice(EXPORTS),
    default=("nc", "csv"),
    show_default=True,
    help="File formats of the result; repeatable.",
)
def sweep(
    study: Path,
    out: Path,
    export_to: Path | None,
    exports: tuple[str, ...],
    workers: int | None,
    scheduler: str | None,
    **arguments: Any,
) -> int:
    """Solve all cases of a study file."""
    from ..studies.api import study_of
    from ..studies.export import check_export, export
    from ..studies.run import Workers, run_study
    from ..studies.study_file import load_study

    loaded = load_study(study)
    options.check_unit_names(loaded.problem)
    folder = _export_folder(out, export_to)
    targets = [folder / f"study.{ending}" for ending in exports]
    for target in targets:
        check_export(target)
    start = time.perf_counter()
    model, cases = study_of(**loaded.arguments)
    with options.resumable(out), unwarned():
        solvers = Workers(workers, scheduler)
        table = run_study(model, cases, solvers, out=out, progress=True, **arguments)
    seconds = time.perf_counter() - start
    for target in targets:
        export(table, target)
    figures = [folder / f"{output}.png" for output in table.outputs]
    for output, figure in zip(table.outputs, figures, strict=True):
        table.plot(output, figure)
    code = options.print_failures("cases", table.failure, seconds)
    _print_ranges(table)
    options.print_written([*targets, *figures])
    return code


def _export_folder(out: Path, export_to: Path | None) -> Path:
    """Return the folder of the exported files: ``export_to``, by default that of the results.

    Raises
    ------
    InvalidProblem
        If it is the folder of the results, and cannot be written.
    """
    if export_to is not None:
        export_to.mkdir(parents=True, exist_ok=True)
    elif out.is_dir() and not os.access(out, os.W_OK):
        text = "is not writable; name a folder for the exported files, --export-to FOLDER"
        raise InvalidProblem.at(str(out), text)
    return export_to or out


def _print_ranges(table: Table) -> None:
    """Print the number of warnings of a study, and the range of each output."""
    import numpy as np

    from ..quantities import in_chosen_units

    warned = table.warnings[table.warnings != ""]
    if warned.size:
        text = f"  {warned.size} outside the validity range of the model, the first: "
        click.secho(text + in_chosen_units(warned[0]), fg="yellow")
    for name, values in table.outputs.items():
        if np.isfinite(values).any():
            quantity = table.quantities[name]
            least, largest = (quantity.shown(f(values)) for f in (np.nanmin, np.nanmax))
            text = f"{quantity.meaning}: {least:.5g} to {largest:.5g} {quantity.display}"
            click.echo(text.rstrip())


@options.command(
    """\
    Rank the inputs of a study by Sobol' sensitivity indices.

    An index is the share of an output's variance that is explained by the range of an input.
    Every entry of [over] in the study file is a range { from, to }. The number of cases is
    samples * (inputs + 2). The derivatives at a single case are computed by 'woundon solve
    --sensitivity'.
    """
)
@click.argument("study", type=options.PATH)
@_execution_options
@click.option("--samples", type=int, help="Base samples, a power of 2; by default 256.")
def sobol(
    study: Path, out: Path, export_to: Path | None, samples: int | None, **arguments: Any
) -> None:
    """Rank the inputs of a study by Sobol' sensitivity indices."""
    from ..studies.api import global_sensitivity
    from ..studies.study_file import load_study

    loaded = load_study(study, ranges=True)
    folder = _export_folder(out, export_to)
    over: Any = loaded.over  # ranges by field; the table of another file is rejected
    design = {k: v for k, v in loaded.design.items() if k in ("samples", "seed")}
    if samples is not None:
        design["samples"] = samples
    with options.resumable(out), unwarned():
        indices = global_sensitivity(
            loaded.problem,
            over,
            loaded.outputs,
            tie=loaded.tie,
            options=loaded.options,
            out=out,
            progress=True,
            **design,
            **arguments,
        )
    for line in indices.lines():
        click.echo(line)
    targets = [folder / "sobol.nc", folder / "sobol.png"]
    indices.to_xarray().to_netcdf(targets[0], engine="scipy")
    indices.plot(targets[1])
    options.print_written(targets)


@options.command(
    """\
    Fit fields of a case to measured data.

    DATA is a table (.csv or .xlsx) with units in its header. A column is an input or an output by
    its name, e.g. "nip_load [kN/m]", "web_tension [N/m]", "wound_on_tension [N/m]";
    "wound_on_tension +- [N/m]" holds its standard deviations.
    """
)
@click.argument("case", type=options.PATH)
@click.argument("data", type=options.PATH)
@click.option(
    "--vary",
    multiple=True,
    required=True,
    type=options.FieldRange(),
    callback=options.as_mapping,
    help="A field to fit, e.g. roll.material.shear='1 MPa:100 MPa'; repeatable.",
)
@options.TIES
@options.COLUMNS
@options.SETTINGS
@options.UNITS
@click.option(
    "--starts",
    type=click.IntRange(1),
    help="Number of initial guesses; by default until two lead to the best minimum, at most 6.",
)
@options.NODES
@click.option(
    "--no-profiles",
    "profiles",
    flag_value=False,
    default=True,
    help="Omit the profile-likelihood intervals.",
)
@options.JSON
@click.option("--save", type=options.OutputFile(".json"), help="Save the fit.")
@options.PLOT
def fit(
    case: Path,
    data: Path,
    settings: tuple[str, ...],
    as_json: bool,
    save: Path | None,
    plot: Path | None,
    **arguments: Any,
) -> None:
    """Fit fields of a case to measured data."""
    from ..studies.fit import fit as fit_problem

    problem = options.load_case(case, settings)
    result = fit_problem(problem, data, progress=True, **arguments)
    files: options.Files = {
        save: lambda path: write_whole(path, result.to_json().encode()),
        plot: result.plot,
    }
    options.present(result, as_json, files)


@options.command(
    """\
    Choose the next measurement by its expected information.

    The candidate measurements of a study file, such as examples/plan_next_measurement.toml, are
    ranked by the expected reduction of uncertainty per cost.

    The file names unknown fields with their prior relative standard deviations [unknown], completed
    measurements [[completed]] and candidates [[candidate]]: quantity, state, standard deviation and
    cost. The standard errors that are expected after each measurement are printed.
    """
)
@click.argument("study", type=options.PATH)
@click.option("--count", type=click.IntRange(1), help="Number of measurements to select.")
@click.option(
    "--draws",
    type=click.IntRange(0),
    help="Number of random points at which the ranking is repeated; by default 3.",
)
@options.UNITS
@options.DECIMAL_COMMA
@options.JSON
@options.SAVE_TABLE
@options.PLOT
def plan(
    study: Path, as_json: bool, save: Path | None, plot: Path | None, **arguments: Any
) -> None:
    """Choose the next measurement by its expected information."""
    from ..studies.export import write_table
    from ..studies.plan import next_experiment
    from ..studies.study_file import load_plan

    keywords = load_plan(study)
    options.check_unit_names(keywords["problem"])
    keywords |= {name: value for name, value in arguments.items() if value is not None}
    result = next_experiment(progress=True, **keywords)
    table = result.to_dataframe().reset_index()
    options.present(result, as_json, {save: partial(write_table, table), plot: result.plot})
