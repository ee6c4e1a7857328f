"""``woundon schedule``: target pressure in; tension, case and figure out."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from slow_cases import slow_case

import woundon as wo
from woundon.cli.commands import main
from woundon.io.case_files import load_case
from woundon.io.case_texts import template

TABLE = "radius [mm]; pressure [kPa]\n44,5; 250\n60; 200\n120; 120\n150; 0\n"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    Path("roll.toml").write_text(template("roll"))
    Path("wanted.csv").write_text(TABLE)
    return tmp_path


@pytest.mark.parametrize(
    ("units", "header"),
    [
        (["--unit", "mill"], "radius [in],value [pli]"),
        slow_case([], "radius [mm],value [N/m]"),
    ],
)
def test_the_tension_comes_back_as_a_case(
    folder: Path, capsys: pytest.CaptureFixture[str], units: list[str], header: str
):
    given = ["schedule", "roll.toml", "--pressure", "wanted.csv", "--out", "tension.csv",
             "--case", "found.toml", "--plot", "design.png", *units]  # fmt: skip
    assert main(given) == 0
    assert Path("tension.csv").read_text().splitlines()[0] == header
    message = capsys.readouterr().out
    assert "largest deviation below the outer layer" in message
    over_radius = message.partition("Over the radius")[2].partition("written")[0].splitlines()
    rows = [line.split() for line in over_radius[2:]]
    for place in (0, 2):  # radius and tension: the largest value has five digits in all units
        largest = max((row[place] for row in rows), key=float)
        assert len(largest.replace(".", "")) == 5
    by_case = load_case("found.toml")
    lines = [line for line in Path("roll.toml").read_text().splitlines()
             if not line.startswith("wound_on_tension")]  # fmt: skip
    table = '[wound_on_tension]\ncsv = "tension.csv"\nbetween = "smooth"\n'
    Path("by_table.toml").write_text("\n".join([*lines, table]))
    by_table = load_case("by_table.toml")
    r = np.array([0.0445, 0.06, 0.12])
    wound = wo.solve(by_case, rtol=1e-4)
    # 1e-4 inside, of the largest
    P = wound.at_radius(r)["pressure"]
    np.testing.assert_allclose(P[1:], [200e3, 120e3], atol=25)
    assert P[0] == pytest.approx(250e3, rel=1e-3)  # on the core
    np.testing.assert_allclose(by_table.tension_curve.at(r), by_case.tension_curve.at(r), rtol=1e-8)
    assert Path("design.png").stat().st_size > 10_000


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        (["--pressure", "200 N"], "wrong dimension"),
        (["--pressure", "none.csv"], "none.csv: cannot be read"),
        (["--pressure", "odd.csv"], "odd.csv: has the columns radius; must be radius and"),
        (["--pressure", "falls.csv"], "falls.csv.radius.1: 0.05 is out of range"),
        (["--pressure", "wanted.csv", "--set", "radius=0.16"], "must be radius = 0.16 [m]"),
        (["--pressure", "2 kPa", "--smooth"], "--smooth: is given with one value"),
        (["--pressure", "wanted.csv", "--rtol", "0.5"], "rtol: 0.5 is out of range"),
        (["--pressure", "wanted.csv", "--out", "t.txt"], "must be .csv"),
        (["--pressure", "wanted.csv", "--plot", "t.bmp"], "not a known format"),
        (["--pressure", "2 kPa", "--case", "no/t.toml"], "no/t.toml: "),
    ],
)
def test_refusals_are_one_line(
    folder: Path, capsys: pytest.CaptureFixture[str], arguments: list[str], text: str
):
    Path("odd.csv").write_text("radius [mm],\n60,\n")
    Path("falls.csv").write_text("radius [mm],pressure [kPa]\n60,200\n50,100\n")
    assert main(["schedule", "roll.toml", *arguments]) == 2
    message = capsys.readouterr()
    assert not message.out
    assert text in message.err
    assert len(message.err.splitlines()) == 1
