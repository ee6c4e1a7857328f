"""The six questions of docs/start/mill.md: the commands of the page run as they stand there.

Evidence: documentation.  The case is the TOML block of the page, the tables are those of the page,
and the answers are compared with ``wo.solve`` and ``wo.fit`` where another route exists.
"""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pandas
import pytest

import woundon as wo
from woundon.cli import commands as cli

PAGE = (Path(__file__).parents[2] / "docs" / "start" / "mill.md").read_text("utf-8")
COMMANDS = re.findall(r"^\$ woundon (.*)$", PAGE, re.MULTILINE)
CASE = re.search(r"```toml\n(.*?)```", PAGE, re.DOTALL)[1]


def table(first_header: str) -> list[list[str]]:
    """Return the rows of a table of the page, the header first."""
    lines = PAGE.splitlines()
    start = next(k for k, line in enumerate(lines) if line.startswith(f"| {first_header}"))
    rows = [lines[start]]
    rows += [line for line in lines[start + 2 : start + 9] if line.startswith("| ")]
    return [[cell.strip() for cell in row.strip("|").split("|")] for row in rows]


def workbook(first_header: str, path: str) -> None:
    """Write a table of the page as an Excel file."""
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    for row in table(first_header):
        book.active.append([float(cell) if cell[0].isdigit() else cell for cell in row])
    book.save(path)


def run(start: str, capsys: pytest.CaptureFixture[str], *, number: int = 0) -> str:
    """Run a command of the page that starts with these words; return what it prints."""
    words = shlex.split([one for one in COMMANDS if one.startswith(start)][number])
    file = words[words.index(">") + 1] if ">" in words else ""
    assert cli.main(words[: words.index(">")] if file else words) == 0
    text = capsys.readouterr().out
    if file:
        Path(file).write_text(text, "utf-8")
    return text


@pytest.fixture
def case(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("case.toml").write_text(CASE, "utf-8")
    with pytest.warns(wo.InputWarning, match="replaces the 104 um"):
        return wo.load_case("case.toml")


def test_the_short_case_has_the_fields_of_the_page(case, capsys):
    printed = run("new --grade", capsys)
    names = re.compile(r"^(\[?\w+\]?)", re.MULTILINE)
    assert names.findall(printed) == names.findall(CASE)


def test_the_wound_on_tension_of_a_paper_of_60_gsm(case, capsys):
    assert case.web.thickness == pytest.approx(0.060 / wo.grade("uncoated-fine").density)
    first = run("solve case.toml", capsys).splitlines()[0]
    tension = wo.solve(case).wound_on_tension
    assert first.startswith(f"Wound-on tension {tension:.0f} N/m = web tension 350 N/m")
    first, *_ = run("solve case.toml", capsys, number=1).splitlines()
    assert re.match(r"Wound-on tension 3\.\d\d pli = web tension 2.00 pli", first)
    assert Path("nip.png").stat().st_size > 10_000


@pytest.mark.slow
def test_the_nip_load_for_a_tension(case, capsys):
    found = re.search(r"nip_load = ([\d.]+) ± [\d.]+ N/m", run("find", capsys))
    assert found is not None
    tension = wo.solve(case.replace(nip_load=float(found[1]))).wound_on_tension
    assert tension == pytest.approx(550.0, abs=0.5)  # 0.1 %, the error of the default mesh


@pytest.mark.slow
def test_the_defect_of_a_roll(case, capsys):
    run("new winding", capsys)
    said = run("solve roll.toml", capsys)
    assert said.startswith("The roll does not hold: starring (hoop compression)")


def test_from_excel_to_excel(case, capsys):
    workbook("Nip load [pli]", "cases.xlsx")
    run("table", capsys)
    got = pandas.read_excel("results.xlsx")["wound_on_tension [pli]"][0]
    changes = {"nip_load": "10 pli", "web_tension": "1.5 pli", "roll.diameter": "20 in"}
    expected = wo.solve(case.replace(**changes))
    # other initial guesses: within the estimated error
    assert got == pytest.approx(
        expected.in_units("pli").wound_on_tension,
        rel=expected.wound_on_tension_error / expected.wound_on_tension,
    )


@pytest.mark.slow
def test_the_friction_of_a_paper(case, capsys):
    workbook("Nip load [kN/m]", "tensions.xlsx")
    said = run("fit", capsys)
    friction = re.search(r"roll_friction +([\d.]+) ± [\d.]+ \(standard error", said)
    assert friction is not None
    # the readings are those of a friction of 0.15, rounded to 1 N/m, which is 1 % of the friction;
    # a second minimum is near 2, where the tension hardly depends on friction
    assert float(friction[1]) == pytest.approx(0.15, rel=0.03)
    assert Path("fit.png").stat().st_size > 10_000


@pytest.mark.slow
def test_starts_on_a_plateau_do_not_hide_the_minimum(case):
    """Two starts end where the tension hardly depends on friction; the minimum is elsewhere."""
    measured = {
        "nip_load [kN/m]": [1, 2, 3, 4, 2, 3],
        "web_tension [N/m]": [300, 300, 300, 300, 200, 200],
        "wound_on_tension [N/m]": [395, 450, 500, 555, 370, 430],
    }
    found = wo.fit(case, measured, ["roll_friction"], profiles=False, workers=1, nodes=25)
    many = wo.fit(case, measured, ["roll_friction"], profiles=False, workers=1, nodes=25, starts=6)
    # the same minimum, to the accuracy of a fit: a few hundredths of the standard error
    assert found.estimates == pytest.approx(many.estimates, abs=0.1 * many.standard_errors[0])
    assert found.starts > 2
    assert found.not_identified == ()


def test_the_case_of_a_two_drum_winder(tmp_path, monkeypatch, capsys):
    """The page's winder: its loads from the weight, its tension with full slip, no nip solved."""
    monkeypatch.chdir(tmp_path)
    [drums] = [
        block for block in re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL) if "[winder]" in block
    ]
    Path("drums.toml").write_text(drums, "utf-8")
    words = shlex.split(next(one for one in COMMANDS if one.startswith("solve drums.toml")))
    assert cli.main([*words, "--set", "tension_law=friction"]) == 0
    text = capsys.readouterr().out
    problem = wo.load_case("drums.toml")
    load = problem.drum_loads(problem.radius).front_load
    assert "Two-drum winder" in text
    assert f"{load:.0f}  N/m" in text
    assert Path("drums.png").exists()
    find = next(one for one in COMMANDS if one.startswith("find drums.toml"))
    assert "torque_split" in find
