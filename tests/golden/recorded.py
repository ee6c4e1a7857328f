"""What users see of the program: records of numbers, texts, files, names and panels.

Each function returns one record; ``test_recorded.py`` compares it with the file of the same name in
``tests/golden/recorded``.  ``UPDATE_GOLDEN=1`` rewrites the files.
"""

from __future__ import annotations

import inspect
import json
import os
import re
import warnings
from collections.abc import Callable, Iterator
from functools import cache
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np
from click.testing import CliRunner
from coarse_solutions import coarse_solution
from damaged_files import hostile_case
from rich.console import Console
from thesis_cases import film_nip

import woundon as wo
from woundon import kinds, quantities
from woundon.app.plot_data import panel_data, slow_panel_data
from woundon.cli.commands import commands
from woundon.io.case_files import load_case, to_toml
from woundon.io.case_texts import grade_template, template
from woundon.io.python_texts import to_python
from woundon.report.plots import figure_for_file
from woundon.report.result_panels import panels_of
from woundon.studies.study_texts import study_template

ROOT = Path(__file__).parents[2]
CASE = "examples/newsprint_table2.toml"
KINDS = ("nip", "rollers", "roll", "winding")


@cache
def problems() -> dict[str, wo.Problem]:
    """Return a problem for every part that a problem may have."""
    nip, pair, roll = (kinds.named(name).example() for name in KINDS[:3])
    winding = wo.WindingProblem.example().replace(radius=0.1, roll_body="linear")
    rubber = wo.Isotropic(youngs_modulus=5e6, poissons_ratio=0.45, prony=[(3e6, 1e-3)])
    cover = wo.Cylinder(radius=0.25, core_radius=0.235, material=rubber)
    return {
        "nip": nip,
        "nip without wraps": nip.replace(roll_wrap=0.0),
        "nip wrapped on both": nip.replace(roll_wrap=1.0, drum_wrap=0.5, wrap_friction=0.3),
        "nip with a viscoelastic cover": nip.replace(drum=cover, web_speed=20.0),
        "nip with air": film_nip(),
        "rollers": pair,
        "rollers with creepage": pair.replace(tangential_load=None, creepage=1e-4),
        "rollers at rest": pair.replace(motion="static"),
        "roll": roll,
        "roll after storage": roll.replace(core_shrinkage=1e-4, temperature_change=-5.0),
        "winding": winding,
        "winding on two drums": winding.replace(
            winder=wo.TwoDrums(
                front_drum=wo.Rigid(radius=0.2),
                rider=wo.Rigid(radius=0.1),
                gap=0.02,
                rider_load=2000.0,
                core_mass=5.0,
            ),
            nip_load=None,
            torque_split=0.5,
        ),
        "winding with limits": winding.replace(limits=wo.grade("newsprint").limits),
    }


def solution(name: str) -> Any:
    """Return a coarse solution, computed once per process."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return coarse_solution(problems()[name], 33)


def numbers() -> dict[str, Any]:
    """Return value and error estimate of every output that is a number."""
    return {name: outputs_of(solution(name)) for name in problems()}


def outputs_of(result: Any) -> dict[str, list[float | None]]:
    """Return value and error estimate of the outputs of a result."""
    return {
        name: [float(quantities.value_of(result, name)), result.errors.get(name)]
        for name in quantities.scalar_outputs(result)
    }


def grades(folder: Path) -> dict[str, Any]:
    """Return the outputs of a nip of every grade, from its short case file."""
    found = {}
    for name in wo.grades():
        path = folder / "case.toml"
        path.write_text(grade_template("nip", name), encoding="utf-8")
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            found[name] = outputs_of(wo.solve(load_case(path), nodes=25))
    return found


# ---- texts --------------------------------------------------------------------------------------


def commands_of(folder: Path) -> Iterator[list[str]]:
    """Yield command lines on the examples; relative paths are those of the project."""
    yield ["--help"]
    for name in commands.list_commands(None):  # type: ignore[arg-type]
        yield [name, "--help"]
    for kind in KINDS:
        yield ["new", kind]
        yield ["new", kind, "--study"]
        yield ["describe", kind]
    yield ["new", "winding", "--grade", "newsprint"]
    yield ["grades"]
    yield ["grades", "newsprint"]
    yield ["materials"]
    yield ["solve", CASE]
    yield ["solve", CASE, "--unit", "mill", "--sensitivity", "--nodes", "25"]
    yield [
        "find",
        CASE,
        "--vary",
        "nip_load",
        "--target",
        "wound_on_tension=600 N/m",
        "--nodes",
        "25",
    ]
    yield ["plan", "examples/plan_next_measurement.toml", "--draws", "0"]
    tensions = folder / "tensions.csv"
    tensions.write_text(
        "nip_load [kN/m],wound_on_tension [N/m],wound_on_tension +- [N/m]\n"
        "0.9,450,10\n1.8,560,10\n3.5,700,10\n5.8,830,12\n",
        encoding="utf-8",
    )
    data = os.fspath(tensions)
    yield ["fit", CASE, data, "--vary", "roll_friction", "--nodes", "25"]
    yield ["compare", data, CASE, "--nodes", "25", "--spread", "roll_friction=10 %"]
    table = os.fspath(folder / "cases.csv")
    (folder / "cases.csv").write_text("nip_load [kN/m]\n1\n2\n", encoding="utf-8")
    yield [
        "table",
        table,
        "--case",
        CASE,
        "--nodes",
        "25",
        "--workers",
        "1",
        "-o",
        os.fspath(folder / "out.csv"),
    ]
    roll = folder / "roll.toml"
    roll.write_text(template("roll"), encoding="utf-8")
    yield ["schedule", os.fspath(roll), "--pressure", "200 kPa"]
    yield ["solve", "missing.toml"]
    yield ["solve", CASE, "--set", "nip_load=1 kN/s"]


def command_lines(folder: Path) -> str:
    """Return what the commands print, with their exit codes."""
    runner = CliRunner()
    parts = []
    for arguments in commands_of(folder):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            answer = runner.invoke(commands, arguments, prog_name="woundon", terminal_width=100)
        text = re.sub(
            r" in [\d.]+ s,", " in some s,", answer.stdout.replace(f"{folder}{os.sep}", "")
        )
        line = " ".join(arguments).replace(f"{folder}{os.sep}", "")
        parts.append(f"$ woundon {line}\n{text}[{answer.exit_code}]\n")
    return "\n".join(parts)


def case_texts() -> str:
    """Return the case files and scripts that the program writes."""
    written = [f"# {name}\n{to_toml(problem)}" for name, problem in problems().items()]
    scripts = [f"# {kind}\n{to_python(kinds.named(kind).example())}" for kind in KINDS]
    return "\n".join([*written, *scripts, *(study_template(kind) for kind in KINDS)])


def reports() -> str:
    """Return the printed reports of all problems, and of sensitivities."""
    soft = wo.Isotropic(youngs_modulus=1e9, poissons_ratio=0.3)
    lower = wo.HalfPlane(radius=0.25, material=soft)
    pair = problems()["rollers"].replace(lower=lower, tangential_load=None)
    printed = {name: solution(name) for name in problems()}
    printed["dissimilar rollers"] = coarse_solution(pair, 33)
    printed["sensitivities of the nip"] = solution("nip").sensitivity()
    parts = []
    for name, thing in printed.items():
        paper = StringIO()
        Console(file=paper, width=100).print(str(thing))
        parts.append(f"==== {name}\n{paper.getvalue()}")
    return "\n".join(parts)


def public_names() -> str:
    """Return signature and documentation of every public name, and of the methods of classes.

    Members that a public result inherits from a class without a public name are those of this
    class, which follows the public names.
    """
    kinds.every()  # loads the plug-ins, whose outputs are members of the results
    things = {name: getattr(wo, name) for name in sorted(wo.__all__)}
    bases = {base for kind in kinds.every() for base in kind.result.__mro__ if base is not object}
    unnamed = bases - {thing for thing in things.values() if inspect.isclass(thing)}
    things |= {base.__name__: base for base in sorted(unnamed, key=lambda base: base.__name__)}
    return "\n".join(line for name, thing in things.items() for line in _described(name, thing))


def _described(name: str, thing: Any) -> Iterator[str]:
    """Yield the lines of a public name, then those of its public members."""
    if inspect.ismodule(thing):
        members = {n: getattr(thing, n) for n in getattr(thing, "__all__", ())}
        for part in sorted(members):
            if getattr(members[part], "__module__", thing.__name__) == thing.__name__:
                yield from _described(f"{name}.{part}", members[part])
        return
    yield f"{name}{_signature(thing)}"
    text = inspect.getdoc(thing) or ""
    yield "\n".join(f"    {line}".rstrip() for line in text.splitlines())
    if inspect.isclass(thing):
        for part, member in sorted(vars(thing).items()):
            function = getattr(member, "fget", None) or getattr(member, "func", None) or member
            if not part.startswith("_") and callable(getattr(function, "__func__", function)):
                text = inspect.getdoc(member) or ""
                yield f"{name}.{part}{_signature(getattr(function, '__func__', function))}"
                yield "\n".join(f"    {line}".rstrip() for line in text.splitlines())


def _signature(thing: Any) -> str:
    try:
        return str(inspect.signature(thing))
    except (TypeError, ValueError):
        return ""


# ---- panels -------------------------------------------------------------------------------------


def fingerprint(values: Any) -> list[float]:
    """Return number of points, first, last, smallest, largest and mean value of an array."""
    array = np.asarray([np.nan if v is None else v for v in values], dtype=float)
    array = array[np.isfinite(array)]
    if not array.size:
        return [0]
    ends = (array[0], array[-1], array.min(), array.max(), array.mean())
    return [int(array.size), *(float(f"{v:.7g}") for v in ends)]


def figure_panels() -> dict[str, Any]:
    """Return the labels and curves of every panel of the figures."""
    from matplotlib import pyplot as plt

    found: dict[str, Any] = {}
    for name in problems():
        result = solution(name)
        for panel in panels_of(result):
            figure = figure_for_file([result], panels=[panel])
            drawn = [part for axes in figure.axes for part in (axes, *axes.child_axes)]
            found[f"{name}: {panel}"] = [_axes_record(axes) for axes in drawn]
            plt.close("all")
    return found


def _axes_record(axes: Any) -> dict[str, Any]:
    return {
        "x": axes.get_xlabel(),
        "y": axes.get_ylabel(),
        "texts": [text.get_text() for text in axes.texts],
        "curves": {
            f"{k} {line.get_label()}": [
                fingerprint(line.get_xdata()),
                fingerprint(line.get_ydata()),
            ]
            for k, line in enumerate(axes.get_lines())
        },
    }


def panels_of_page() -> dict[str, Any]:
    """Return the labels and curves of every panel of the page."""
    return {
        f"{name}: {panel['name']}": {
            "x": panel["x"]["label"],
            "y": panel["y"]["label"],
            "curves": {
                curve["label"] or curve["name"]: [fingerprint(curve["x"]), fingerprint(curve["y"])]
                for curve in panel["curves"]
            },
        }
        for name in problems()
        for panel in (*panel_data(solution(name)), *slow_panel_data(solution(name)))
    }


def interface_of_server() -> dict[str, Any]:
    """Return the OpenAPI document of the server."""
    from woundon.app.routes import application  # imports the server's libraries

    document: dict[str, Any] = application().openapi()
    del document["info"]["version"]
    return document


# ---- files and errors ---------------------------------------------------------------------------


def files(folder: Path) -> str:
    """Return the structure of result files, and the tables of results and of a sweep."""
    import xarray

    parts = []
    for name in problems():
        result = solution(name)
        for ending in ("nc", "json", "csv"):
            result.save(folder / f"result.{ending}")
        with xarray.open_dataset(folder / "result.nc", engine="scipy") as data:
            parts.append(f"==== {name}\n{_structure(data)}")
        parts.append(" ".join(sorted(json.loads((folder / "result.json").read_text("utf-8")))))
        parts.append("\n".join((folder / "result.csv").read_text("utf-8").splitlines()[:3]))
    nip = problems()["nip without wraps"]
    table = wo.sweep(nip, {"nip_load": [1e3, 2e3], "web_tension": [200.0, 300.0]}, nodes=17)
    parts += [_structure(table), table.to_dataframe().to_csv()]
    return "\n".join(parts)


def _structure(data: Any) -> str:
    """Return dimensions, variables with units and names, and attributes of a dataset."""
    lines = [f"{dict(data.sizes)}", f"attributes: {sorted(data.attrs)}"]
    lines += [
        f"{name} {variable.dims} {variable.dtype.kind} {variable.attrs.get('units')} "
        f"{variable.attrs.get('long_name')}"
        for name, variable in sorted(data.variables.items())
    ]
    return "\n".join(lines)


def errors(folder: Path) -> str:
    """Return how malformed case files are rejected, seeds 0 to 199."""
    outcomes = [hostile_case(seed, folder) for seed in range(200)]
    assert [(seed, one) for seed, one in enumerate(outcomes) if one.finding] == []
    # the texts on missing files contain the temporary folder
    return "".join(f"{one.text}\n" for one in outcomes if one.damage != "no file")


# ---- work ---------------------------------------------------------------------------------------


def solves() -> dict[str, int]:
    """Return the number of solved problems of a fit and of a find."""
    nip = wo.NipProblem.example()
    measured = {"nip_load": [900.0, 1800.0, 3500.0], "wound_on_tension": [430.0, 500.0, 600.0]}
    fitted = wo.fit(nip.replace(roll_wrap=0.0), measured, ["roll_friction"], nodes=25)
    done = [0]
    wo.find(nip, "nip_load", wound_on_tension=600.0, nodes=25, progress=lambda n, _: done.append(n))
    return {"fit": fitted.solves, "find": max(done)}


RECORDS: dict[str, Callable[..., Any]] = {
    "numbers.json": numbers,
    "grades.json": grades,
    "command_lines.txt": command_lines,
    "case_texts.txt": case_texts,
    "reports.txt": reports,
    "files.txt": files,
    "errors.txt": errors,
    "public_names.txt": public_names,
    "figure_panels.json": figure_panels,
    "page_panels.json": panels_of_page,
    "server.json": interface_of_server,
    "solves.json": solves,
}
