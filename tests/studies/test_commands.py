"""woundon sweep, fit and sensitivity as their users meet them, and study files."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
import study_models as models
import xarray
from nip_study import nip_study
from thesis_cases import paper_nip

import woundon as wo
from woundon.cli import commands as cli
from woundon.studies.study_file import load_study

EXAMPLES = Path(__file__).parents[2] / "examples"
CASE = Path(__file__).with_name("nip_alone.toml")
STUDY = nip_study(CASE)


@pytest.fixture
def study(tmp_path: Path) -> Path:
    path = tmp_path / "study.toml"
    path.write_text(STUDY, encoding="utf-8")
    return path


def test_sweep_writes_tables_and_figures_and_sums_up(
    study: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    out = tmp_path / "out"
    outputs = 'outputs = ["nip_induced_tension"'
    study.write_text(STUDY.replace(outputs, f'{outputs}, "half_width"'), encoding="utf-8")
    assert cli.main(["sweep", str(study), "--out", str(out), "--workers", "1"]) == 0
    said = capsys.readouterr()
    first, failed, *_ = said.out.splitlines()
    assert first.startswith("6 cases in ")
    assert first.endswith("1 failed")
    # mu- P = 200 N/m at the lowest load
    assert failed.startswith("  1 x NoSteadyState: winding_force: 300 is out of range")
    (width,) = [line for line in said.out.splitlines() if line.startswith("half-width of the nip")]
    assert width.endswith(" mm")  # as in the figure, not in m
    assert "6/6" in said.err
    assert "cases/s" in said.err
    assert {p.name for p in out.iterdir()} == {
        "study.sqlite", "study.nc", "study.csv", "nip_induced_tension.png", "half_width.png",
    }  # fmt: skip
    assert (out / "nip_induced_tension.png").stat().st_size > 10_000


def test_sensitivity_tells_the_shares(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    path = tmp_path / "study.toml"
    path.write_text(
        f'schema = 1\ncase = "{CASE}"\n[over]\nnip_load = {{ from = 3000, to = 4000 }}\n'
        "roll_friction = { from = 0.15, to = 0.3 }\n[solver]\nnodes = 17\n",
        encoding="utf-8",
    )
    out = tmp_path / "out"
    command = ["sobol", str(path), "--out", str(out), "--samples", "16", "--workers", "1"]
    assert cli.main(command) == 0
    said = capsys.readouterr().out
    assert said.startswith("wound_on_tension: share of the variance, alone / with interactions")
    assert (out / "sobol.png").stat().st_size > 10_000
    with xarray.open_dataset(out / "sobol.nc", engine="scipy") as data:
        # the interactions are weak, so the shares add up to about one
        assert float(data.total_order.sum()) == pytest.approx(1, abs=0.3)


def test_fit_from_the_command_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    data, case = tmp_path / "rig.csv", wo.load_case(CASE)
    rows = ["Linienlast,tension [N/m],reel"]
    for P in (1000.0, 2000.0, 4000.0):
        true = case.replace(nip_load=P, **{"roll.material.shear": 1.3e7})
        rows.append(f"{P / 1e3},{wo.solve(true, nodes=25).outlet_tension:.6f},7")
    data.write_text("\n".join(rows), encoding="utf-8")
    command = [
        "fit", str(CASE), str(data), "--vary", "roll.material.shear=1 MPa:100 MPa",
        "--column", "Linienlast=nip_load [kN/m]", "--column", "tension=outlet_tension",
        "--column", "reel=", "--nodes", "25", "--starts", "2",
    ]  # fmt: skip
    figure, saved = tmp_path / "fit.png", tmp_path / "fit.json"
    assert cli.main([*command, "--plot", str(figure), "--save", str(saved)]) == 0
    said = capsys.readouterr().out
    assert said.startswith("3 measured values, 1 fitted parameter, RMS ")
    assert "roll.material.shear  13 ± " in said
    assert figure.stat().st_size > 10_000
    estimate = json.loads(saved.read_text("utf-8"))["estimates"][0]
    assert estimate == pytest.approx(1.3e7, rel=1e-5)  # six decimals of the data
    assert cli.main([*command, "--no-profiles", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["profiles"] == {}
    units = ["--unit", "roll.material.shear=MPa", "--unit", "outlet_tension=mN/m"]
    assert cli.main([*command, *units]) == 0
    shown = capsys.readouterr().out
    assert "MPa (standard error " in shown
    interval = r"interval ([\d.]+) MPa to ([\d.]+) MPa$"
    assert [float(e) for e in re.search(interval, shown, re.M).groups()] == pytest.approx(
        [13, 13], rel=1e-3
    )
    rms = [float(re.search(r"RMS ([\d.e-]+) m?N/m", text)[1]) for text in (said, shown)]
    assert rms[1] == pytest.approx(1e3 * rms[0], rel=1e-3)  # four digits are reported


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (["--vary", "roll.material.sheer"], "did you mean 'shear'"),
        (
            ["--vary", "roll.material.shear=1"],
            "'1' is out of place; must be written FIELD=LOW:HIGH",
        ),
        (["--vary", "roll.material.shear=1 mm:2 mm"], "mm"),
        (["--vary", "roll_friction", "--tie", "web.material"], "must be written FIELD=FIELD"),
        (["--vary", "roll_friction", "--column", "WOT=half_width"], "has no column 'WOT'"),
        (["--vary", "roll_friction", "--plot", "fit.bmp"], "bmp"),
        (["--vary", "roll_friction", "--plot", "no/fit.png"], "the folder 'no' does not exist"),
        (
            ["--vary", "roll_friction", "--save", "fit.txt"],
            "the ending '.txt' is not permitted; must be .json",
        ),
        (["--vary", "roll.material.shear=-5 MPa:5 MPa"], "shear: -5000000 is out of range"),
        (
            ["--vary", "roll_friction", "--tie", "roll_friction=drum_friction"],
            "roll_friction: cannot be varied, because roll_friction is tied to drum_friction",
        ),
    ],
)
def test_bad_fit_commands(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], options: list[str], says: str
):
    data = tmp_path / "rig.csv"
    data.write_text("nip_load [N/m],half_width [mm]\n1000,1\n2000,1.5\n", encoding="utf-8")
    assert cli.main(["fit", str(CASE), str(data), *options]) == 2
    said = capsys.readouterr()
    assert says in said.err
    assert said.out == ""


@pytest.mark.parametrize("name", sorted(p.name for p in EXAMPLES.glob("study_*.toml")))
def test_example_studies_load(name: str):
    study = load_study(EXAMPLES / name)
    assert study.outputs
    assert all(len(values) for values in study.over.values())


def test_figures_of_many_inputs(tmp_path: Path):
    """Curves, panels and held inputs of a grid; a scatter of a table; failed cases left out."""
    over = {
        "nip_load": [1000.0, 1500.0, 3000.0],
        "winding_force": [0.0, 300.0],
        "roll_friction": [0.2, 0.3],
        "web.material": ["paper", "newsprint"],
    }
    table = models.table_of(paper_nip(), over, options={"nodes": 13})
    figure = table.plot("wound_on_tension", tmp_path / "grid.png")
    assert len(figure.axes) == 2
    assert all(len(axes.lines) == 2 for axes in figure.axes)
    drawn = figure.axes[0].lines[0].get_ydata()
    assert np.all(np.isin(drawn, table.outputs["wound_on_tension"]))
    ranges = {"nip_load": (1e3, 3e3), "roll.material.shear": (1e6, 1e8, "log")}
    cases = models.table_of(
        paper_nip(), ranges, design="latin-hypercube", samples=8, options={"nodes": 13}
    )
    scatter = cases.plot("wound_on_tension")
    assert [axes.get_xscale() for axes in scatter.axes] == ["linear", "log"]


def test_an_option_of_find_is_no_target(capsys: pytest.CaptureFixture[str]):
    assert cli.main(["find", str(CASE), "--vary", "nip_load", "--target", "points=3"]) == 2
    assert capsys.readouterr().err == "error: target: 'points' is an option, not an output\n"
