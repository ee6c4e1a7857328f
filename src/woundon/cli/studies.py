"""The commands ``woundon sweep``, ``sobol``, ``fit`` and ``plan``."""

from __future__ import annotations

import os
import time
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..errors import InvalidProblem, ValidityWarning
from .options import (
    COLUMNS,
    JSON,
    NODES,
    PATH,
    PLOT,
    SETTINGS,
    TIES,
    UNITS,
    WORKERS,
    FieldRange,
    check_output_files,
    resumable,
)

if TYPE_CHECKING:
    from ..studies.run import Table

__all__ = ["fit", "plan", "sobol", "sweep"]

EXPORTS = ("nc", "csv", "xlsx", "parquet")


def _execution_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add the options for processes and folders of a study."""
    for option in (
        WORKERS,
        click.option("--scheduler", metavar="ADDRESS", help="Dask scheduler, tcp://host:port."),
        click.option("--resume", is_flag=True, help="Resume the study in DIR."),
        click.option("--out", type=PATH, required=True, metavar="DIR", help="Folder of results."),
        click.option(
            "--export-to",
            type=PATH,
            metavar="FOLDER",
            help="Folder of exported files and figures; by default DIR.",
        ),
    ):
        command = option(command)
    return command


@click.command(
    help="""\
    Solve all cases of a study file, e.g. examples/study_nip_load_and_shear.toml.

    Results are written to DIR/study.sqlite chunk by chunk, so that an interrupted study can be
    resumed with --resume. The same option exports a complete study again, with --export-to also
    from a read-only medium.
    """,
    short_help="Solve all cases of a study file.",
)
@click.argument("study", type=PATH)
@_execution_options
@click.option("--chunk", type=click.IntRange(1), help="Number of cases per chunk.")
@UNITS
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
    resume: bool,
    scheduler: str | None,
    workers: int | None,
    chunk: int | None,
    exports: tuple[str, ...],
    export_to: Path | None,
) -> int:
    """Solve all cases of a study file."""
    from ..studies.api import study_of
    from ..studies.export import check_export, export
    from ..studies.run import Workers, run_study
    from ..studies.studyfile import load_study

    loaded = load_study(study)
    folder = _export_folder(out, export_to)
    targets = [folder / f"study.{ending}" for ending in exports]
    for target in targets:
        check_export(target)
    start = time.perf_counter()
    model, cases = study_of(
        loaded.problem,
        loaded.over,
        loaded.outputs,
        columns=loaded.columns,
        tie=loaded.tie,
        **loaded.design,
        options=loaded.options,
    )
    table = _resumable(
        run_study,
        model,
        cases,
        Workers(workers, scheduler),
        out=out,
        resume=resume,
        chunk=chunk,
        progress=True,
    )
    seconds = time.perf_counter() - start
    for target in targets:
        export(table, target)
    figures = [folder / f"{output}.png" for output in table.outputs]
    for output, figure in zip(table.outputs, figures, strict=True):
        table.plot(output, figure)
    code = _print_summary(table, seconds)
    _print_written([*targets, *figures])
    return code


def _export_folder(out: Path, export_to: Path | None) -> Path:
    """Return the folder of the exported files; reject one that cannot be written."""
    if export_to is not None:
        export_to.mkdir(parents=True, exist_ok=True)
    elif out.is_dir() and not os.access(out, os.W_OK):
        text = "is not writable; name a folder for the exported files, --export-to FOLDER"
        raise InvalidProblem.at(str(out), text)
    return export_to or out


def _resumable(run: Callable[..., Any], *args: Any, **kwargs: Any) -> Any:
    """Run a study; after Ctrl-C say how to resume it."""
    with resumable(kwargs["out"]), warnings.catch_warnings():
        warnings.simplefilter("always")
        warnings.simplefilter("ignore", ValidityWarning)  # the summary counts them
        return run(*args, **kwargs)


def _print_summary(table: Table, seconds: float) -> int:
    """Print failures, warnings and ranges of the outputs; return the exit code, 3 if all failed."""
    import numpy as np

    from ..quantities import in_chosen_units
    from ..studies.run import failures

    failed, size = table.failed.size, len(table.cases)
    click.echo(f"{size} cases in {seconds:.1f} s, {failed} failed")
    for reason, count in failures(table.failure):
        click.secho(f"  {count} x {in_chosen_units(reason)}", fg="red")
    warned = int(np.count_nonzero(table.warnings != ""))
    if warned:
        first = table.warnings[table.warnings != ""][0]
        text = f"  {warned} outside the validity range of the model, the first: "
        text += in_chosen_units(first)
        click.secho(text, fg="yellow")
    for name, values in table.outputs.items():
        if np.isfinite(values).any():
            quantity = table.quantities[name]
            unit, converted = quantity.in_table(values)
            text = f"{quantity.meaning}: {np.nanmin(converted):.5g} to {np.nanmax(converted):.5g}"
            click.echo(text if unit == "1" else f"{text} {unit}")
    return 3 if failed == size else 0


def _print_written(paths: list[Path]) -> None:
    click.echo("written: " + ", ".join(str(path) for path in paths))


@click.command(
    help="""\
    Compute Sobol' indices: the share of each output's variance explained by each input range.

    Every entry of [over] in the study file is a range { from, to }. The number of cases is
    samples * (inputs + 2). The derivatives at a single case are computed by 'woundon solve
    --sensitivity'.
    """,
    short_help="Rank the inputs of a study by Sobol' sensitivity indices.",
)
@click.argument("study", type=PATH)
@_execution_options
@click.option("--samples", type=int, help="Base samples, a power of 2; by default 256.")
def sobol(
    study: Path,
    out: Path,
    resume: bool,
    scheduler: str | None,
    workers: int | None,
    samples: int | None,
    export_to: Path | None,
) -> None:
    """Compute the Sobol' indices of the ranges of a study file."""
    from ..studies.api import global_sensitivity
    from ..studies.studyfile import load_study

    loaded = load_study(study, ranges=True)
    folder = _export_folder(out, export_to)
    design = {k: v for k, v in loaded.design.items() if k in ("samples", "seed")}
    if samples is not None:
        design["samples"] = samples
    indices = _resumable(
        global_sensitivity,
        loaded.problem,
        loaded.over,
        loaded.outputs,
        tie=loaded.tie,
        **design,
        options=loaded.options,
        out=out,
        resume=resume,
        scheduler=scheduler,
        workers=workers,
        progress=True,
    )
    for line in indices.lines():
        click.echo(line)
    targets = [folder / "sobol.nc", folder / "sobol.png"]
    indices.to_xarray().to_netcdf(targets[0], engine="scipy")
    indices.plot(targets[1])
    _print_written(targets)


@click.command(
    help="""\
    Fit fields of a case to measured data (.csv or .xlsx, units in the header).

    A column is an input or an output by its name, e.g. "nip_load [kN/m]", "web_tension [N/m]",
    "wound_on_tension [N/m]"; "wound_on_tension +- [N/m]" holds its standard deviations.
    """,
    short_help="Fit fields of a case to measured data.",
)
@click.argument("case", type=PATH)
@click.argument("data", type=PATH)
@click.option(
    "--vary",
    "varied",
    multiple=True,
    required=True,
    type=FieldRange(),
    metavar="FIELD[=LOW:HIGH]",
    help="A field to fit, e.g. roll.material.shear='1 MPa:100 MPa'; repeatable.",
)
@TIES
@COLUMNS
@SETTINGS
@UNITS
@click.option(
    "--starts",
    type=click.IntRange(1),
    help="Number of initial guesses; by default until two lead to the best minimum, at most 6.",
)
@NODES
@click.option("--no-profiles", is_flag=True, help="Omit the profile-likelihood intervals.")
@JSON
@click.option("--save", type=PATH, metavar="FILE.json", help="Save the fit.")
@PLOT
def fit(
    case: Path,
    data: Path,
    varied: tuple[tuple[str, tuple[str | float, str | float] | None], ...],
    ties: tuple[tuple[str, str], ...],
    columns: tuple[tuple[str, str], ...],
    settings: tuple[str, ...],
    starts: int | None,
    nodes: int | None,
    no_profiles: bool,
    as_json: bool,
    save: Path | None,
    plot: Path | None,
) -> None:
    """Fit fields of a case to measured data (.csv or .xlsx, units in the header)."""
    from ..io.case_files import load_case
    from ..io.files import write_whole
    from ..studies.api import fit as fit_problem

    problem = load_case(case, settings)
    if save and save.suffix != ".json":
        raise InvalidProblem.at(str(save), f"the ending {save.suffix!r} is not .json")
    check_output_files(plot, save)
    result = fit_problem(
        problem,
        data,
        {name: _bounds_in_si(problem, name, bounds) for name, bounds in varied},
        tie=dict(ties),
        starts=starts,
        nodes=nodes,
        columns={name: assigned or None for name, assigned in columns},
        profiles=not no_profiles,
        progress=True,
    )
    if save:
        write_whole(save, result.to_json().encode())
    if plot:
        result.plot(plot)
    for line in [result.to_json()] if as_json else result.lines():
        click.echo(line)


def _bounds_in_si(
    problem: Any, name: str, bounds: tuple[str | float, str | float] | None
) -> tuple[float, float] | None:
    """Return the bounds of a field in SI; None for an unknown field, which the fit rejects."""
    from ..studies.kind_model import field_quantity, number_in_si

    if bounds is None or field_quantity(problem, name) is None:
        return None
    low, high = bounds
    return number_in_si(problem, name, low), number_in_si(problem, name, high)


@click.command(
    help="""\
    Rank the candidate measurements of a study file by the expected reduction of uncertainty per
    cost, e.g. examples/plan_next_measurement.toml.

    The file names unknown fields with their prior relative standard deviations [unknown], completed
    measurements [[completed]] and candidates [[candidate]]: quantity, state, standard deviation and
    cost. The standard errors that are expected after each measurement are printed.
    """,
    short_help="Choose the next measurement by its expected information.",
)
@click.argument("study", type=PATH)
@click.option("--count", type=click.IntRange(1), help="Number of measurements to select.")
@click.option(
    "--draws",
    type=click.IntRange(0),
    help="Number of random points at which the ranking is repeated; by default 3.",
)
@UNITS
@JSON
@click.option("--save", type=PATH, metavar="FILE", help="Save the steps as .csv or .xlsx, in SI.")
@PLOT
def plan(
    study: Path,
    count: int | None,
    draws: int | None,
    as_json: bool,
    save: Path | None,
    plot: Path | None,
) -> None:
    """Rank the candidate measurements of a study file."""
    from ..studies.experiment import next_experiment
    from ..studies.export import TABLES, check_export, write_table
    from ..studies.plan_file import load_plan

    if save:
        check_export(save, TABLES)
    check_output_files(plot, save)
    keywords = load_plan(study)
    settings = {name: v for name, v in (("count", count), ("draws", draws)) if v is not None}
    plan_result = next_experiment(**{**keywords, **settings}, progress=True)
    if save:
        write_table(plan_result.to_dataframe().reset_index(), save)
    if plot:
        plan_result.plot(plot)
    for line in [plan_result.to_json()] if as_json else plan_result.lines():
        click.echo(line)
