"""The commands ``woundon sweep``, ``fit``, ``plan`` and ``sensitivity``: parse, call, show."""

from __future__ import annotations

import os
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..errors import InvalidProblem
from ..io.chosen_units import units_of
from ..io.files import check_writable
from .options import COLUMNS, PATH, PLOT, SETTINGS, TIES, UNITS, check_output_files

if TYPE_CHECKING:
    from ..studies.table import Table

__all__ = ["fit", "plan", "sensitivity", "sweep"]

_EXPORTS = (".nc", ".csv", ".xlsx", ".parquet")


def _running(command: Any) -> Any:
    """Add the options of how a study is run."""
    for option in (
        click.option("--workers", type=int, help="Processes; by default one a core."),
        click.option("--scheduler", metavar="ADDRESS", help="Dask scheduler, tcp://host:port."),
        click.option("--resume", is_flag=True, help="Go on with the study that DIR holds."),
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

    Every chunk of cases is added to DIR/study.sqlite when it is solved: --resume continues a study
    that was stopped, by whatever means, and exports a complete one, from a read-only medium too
    with --export-to.
    """,
    short_help="Solve all cases of a study file.",
)
@click.argument("study", type=PATH)
@_running
@click.option("--chunk", type=click.IntRange(1), help="Cases solved in a row.")
@UNITS
@click.option(
    "--export", "exports", multiple=True, type=click.Choice([e[1:] for e in _EXPORTS]),
    default=("nc", "csv"), show_default=True, help="File formats of the result; repeatable.",
)  # fmt: skip
def sweep(
    study: Path, out: Path, resume: bool, scheduler: str | None, workers: int | None,
    chunk: int | None, chosen: tuple[str, ...], exports: tuple[str, ...], export_to: Path | None,
) -> int:  # fmt: skip
    """Solve all cases of a study file, e.g. examples/study_nip_load_and_shear.toml."""
    from ..studies.api import study_of
    from ..studies.engine import run_study
    from ..studies.export import check_export, export
    from ..studies.runners import runner_for
    from ..studies.studyfile import load_study

    told = load_study(study)
    folder = _export_folder(out, export_to)
    targets = [folder / f"study.{ending}" for ending in exports]
    for target in targets:
        check_export(target)
    began = time.perf_counter()
    with units_of(chosen):
        model, cases = study_of(
            told.problem, told.over, told.outputs, columns=told.columns, tie=told.tie,
            **told.design, options=told.options,
        )  # fmt: skip
        table = _stoppable(
            run_study, model, cases, runner_for(workers, scheduler),
            out=out, resume=resume, chunk=chunk, progress=True,
        )  # fmt: skip
    seconds = time.perf_counter() - began
    for target in targets:
        export(table, target)
    figures = [folder / f"{output}.png" for output in table.outputs]
    for output, figure in zip(table.outputs, figures, strict=True):
        table.plot(output, figure)
    code = _summary(table, seconds)
    _written([*targets, *figures])
    return code


def _export_folder(out: Path, export_to: Path | None) -> Path:
    """Return the folder of the exported files; reject one that cannot be written."""
    if export_to is not None:
        export_to.mkdir(parents=True, exist_ok=True)
    elif out.is_dir() and not os.access(out, os.W_OK):
        text = "is not writable; name a folder for the exported files, --export-to FOLDER"
        raise InvalidProblem.at(str(out), text)
    return export_to or out


def _stoppable(run: Any, *args: Any, **kwargs: Any) -> Any:
    """Run, warnings in a line each; after Ctrl-C say how to go on."""
    import warnings

    from ..errors import ValidityWarning

    def show(message: Warning | str, *where: Any) -> None:
        click.secho(f"warning: {message}", fg="yellow", err=True)

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("always")
            warnings.simplefilter("ignore", ValidityWarning)  # the summary counts them
            warnings.showwarning = show  # type: ignore[assignment]
            return run(*args, **kwargs)
    except KeyboardInterrupt:
        text = f"stopped; what was solved is in {kwargs['out']}, --resume goes on from there"
        click.echo(text, err=True)
        raise click.Abort from None


def _summary(table: Table, seconds: float) -> int:
    """Show what came out; return the exit code, 3 where no case at all was solved."""
    import numpy as np

    from ..studies.table import failures

    failed, size = table.failed.size, table.design.size
    click.echo(f"{size} cases in {seconds:.1f} s, {failed} failed")
    for reason, count in failures(table.failure):
        click.secho(f"  {count} x {reason}", fg="red")
    warned = int(np.count_nonzero(table.warnings != ""))
    if warned:
        first = table.warnings[table.warnings != ""][0]
        click.secho(f"  {warned} leave the model's validity, the first: {first}", fg="yellow")
    for name, values in table.outputs.items():
        if np.isfinite(values).any():
            about = table.quantities[name]
            unit, shown = about.in_table(values)
            range_of = f"{np.nanmin(shown):.5g} to {np.nanmax(shown):.5g}"
            click.echo(f"{about.meaning}: {range_of}{'' if unit == '1' else f' {unit}'}")
    return 3 if failed == size else 0


def _written(paths: list[Path]) -> None:
    click.echo("written: " + ", ".join(str(path) for path in paths))


@click.command(
    help="""\
    Tell how much of each output's variance the ranges of a study file explain (Sobol indices).

    Every entry of [over] is a range { from, to }.  It takes samples * (inputs + 2) cases.
    """,
    short_help="Tell which inputs of a study file matter (Sobol indices).",
)
@click.argument("study", type=PATH)
@_running
@click.option("--samples", type=int, help="Base samples, a power of 2; 256 by default.")
def sensitivity(
    study: Path, out: Path, resume: bool, scheduler: str | None, workers: int | None,
    samples: int | None, export_to: Path | None,
) -> None:  # fmt: skip
    """Compute the Sobol indices of the ranges of a study file."""
    from ..studies.api import global_sensitivity
    from ..studies.studyfile import load_study

    told = load_study(study, ranges=True)
    folder = _export_folder(out, export_to)
    drawn = {k: v for k, v in told.design.items() if k in ("samples", "seed")}
    if samples is not None:
        drawn["samples"] = samples
    indices = _stoppable(
        global_sensitivity, told.problem, told.over, told.outputs, tie=told.tie, **drawn,
        options=told.options, out=out, resume=resume, scheduler=scheduler, workers=workers,
        progress=True,
    )  # fmt: skip
    for line in indices.lines():
        click.echo(line)
    targets = [folder / "sensitivity.nc", folder / "sensitivity.png"]
    indices.to_dataset().to_netcdf(targets[0], engine="scipy")
    indices.plot(targets[1])
    _written(targets)


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
    "--vary", "varied", multiple=True, required=True, metavar="FIELD[=LOW:HIGH]",
    help="What to fit, e.g. roll.material.shear='1 MPa:100 MPa'; repeatable.",
)  # fmt: skip
@TIES
@COLUMNS
@SETTINGS
@UNITS
@click.option("--starts", type=click.IntRange(1), default=6, show_default=True)
@click.option("--nodes", type=int, help="Number of nodes along the nip.")
@click.option("--no-profiles", is_flag=True, help="Leave out the profile-likelihood intervals.")
@click.option("--json", "as_json", is_flag=True, help="Print the fit as JSON.")
@click.option("--save", type=PATH, help="Save the fit as .json.")
@PLOT
def fit(
    case: Path, data: Path, varied: tuple[str, ...], ties: tuple[str, ...],
    columns: tuple[str, ...], settings: tuple[str, ...], chosen: tuple[str, ...], starts: int,
    nodes: int | None, no_profiles: bool, as_json: bool, save: Path | None, plot: Path | None,
) -> None:  # fmt: skip
    """Fit fields of a case to measured data (.csv or .xlsx, units in the header)."""
    from ..io.case_files import load_case
    from ..studies.api import fit as fit_problem

    problem = load_case(case, settings)
    if plot:
        from ..report.figures import check_format

        check_format(plot)
    if save and save.suffix != ".json":
        raise InvalidProblem.at(str(save), f"the ending {save.suffix!r} is not .json")
    for path in filter(None, (save, plot)):
        check_writable(path)
    with units_of(chosen):
        found = fit_problem(
            problem, data, dict(_varied(problem, text) for text in varied),
            tie=dict(_pair(text) for text in ties), starts=starts, nodes=nodes,
            columns={name: of or None for name, of in map(_pair, columns)},
            profiles=not no_profiles, progress=True,
        )  # fmt: skip
    if save:
        save.write_text(found.to_json(), encoding="utf-8")
    if plot:
        found.plot(plot)
    for line in [found.to_json()] if as_json else found.lines():
        click.echo(line)


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
@click.option("--draws", type=click.IntRange(0),
              help="Points drawn at which the ranking is repeated; 3.")  # fmt: skip
@UNITS
@click.option("--json", "as_json", is_flag=True, help="Print the plan as JSON.")
@click.option("--save", type=PATH, metavar="FILE", help="Save the steps as .csv or .xlsx, in SI.")
@PLOT
def plan(
    study: Path, count: int | None, draws: int | None, chosen: tuple[str, ...], as_json: bool,
    save: Path | None, plot: Path | None,
) -> None:  # fmt: skip
    """Rank the candidate measurements of a study file."""
    from ..studies.case_table import check_table_path, write_table
    from ..studies.experiment import next_experiment
    from ..studies.plan_file import load_plan

    if save:
        check_table_path(save)
    check_output_files(plot, save)
    keywords = load_plan(study)
    settings = {name: v for name, v in (("count", count), ("draws", draws)) if v is not None}
    with units_of(chosen):
        found = next_experiment(**{**keywords, **settings})
        if save:
            write_table(found.to_dataframe().reset_index(), save)
        if plot:
            found.plot(plot)
        for line in [found.to_json()] if as_json else found.lines():
            click.echo(line)


def _pair(text: str) -> tuple[str, str]:
    left, sign, right = (part.strip() for part in text.partition("="))
    if not sign or not left:
        raise InvalidProblem.at(text, "must be written NAME=NAME")
    return left, right


def _varied(problem: Any, text: str) -> tuple[str, tuple[float, float] | None]:
    """Return field and bounds of "FIELD" or "FIELD=LOW:HIGH"."""
    from ..studies.kind_model import field_quantity, number_in_si

    name, sign, bounds = (part.strip() for part in text.partition("="))
    quantity = field_quantity(problem, name)
    if not sign or quantity is None:
        return name, None
    ends = bounds.split(":")
    if len(ends) != 2:
        raise InvalidProblem.at(name, f"{bounds!r} are not bounds; write LOW:HIGH")
    low, high = (number_in_si(problem, name, _number(end)) for end in ends)
    return name, (low, high)


def _number(text: str) -> str | float:
    """Return a plain number as one, which is SI; anything else as text with its unit."""
    try:
        return float(text)
    except ValueError:
        return text
