"""Tables of cases: the same numbers as single solves, faults by row, files, and the command."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pandas
import pytest

import woundon as wo
from woundon.cli.commands import main
from woundon.io.case_texts import template, to_toml
from woundon.io.sheets import read_sheet
from woundon.studies.export import write_table

NIP = wo.NipProblem.example()
WOT = "wound_on_tension [N/m]"
HERE = {"workers": 1, "nodes": 33}


def solved(table, case=NIP, outputs=("wound_on_tension",), **more):
    return wo.solve_table(table, case, outputs, **{**HERE, **more})


def test_every_row_is_what_a_single_solve_gives():
    """Also for cells with units, and for empty cells, which have the value of the case."""
    table = pandas.DataFrame(
        {"nip_load [kN/m]": [2.0, "2500 N/m", None], "web tension": ["300 N/m", 350.0, 250.0]}
    )
    found = solved(table)
    problems = [NIP.replace(nip_load=P, web_tension=T)
                for P, T in ((2000.0, 300.0), (2500.0, 350.0), (NIP.nip_load, 250.0))]  # fmt: skip
    expected = [wo.solve(problem, nodes=33).wound_on_tension for problem in problems]
    assert found[WOT].tolist() == pytest.approx(expected, rel=1e-8)
    assert list(found.columns) == ["nip_load [kN/m]", "web tension", WOT, "failure", "warnings"]
    assert found["nip_load [kN/m]"].tolist()[:2] == [2.0, "2500 N/m"]
    assert (found.failure == "").all()


def test_forces_are_divided_by_the_width_of_the_web():
    totals = {"nip_load [kN]": [4.0, 5.0], "Web tension [N]": [600.0, 700.0]}
    found = solved(totals, NIP.replace(width=2.0))
    per_width = {"nip_load [N/m]": [2000.0, 2500.0], "Web tension [N/m]": [300.0, 350.0]}
    np.testing.assert_allclose(found[WOT], solved(per_width)[WOT], rtol=1e-10)
    assert found["nip_load [kN]"].tolist() == [4.0, 5.0]
    with pytest.raises(
        wo.InvalidProblem, match=r"is a force; expected a force per width\. Give the width"
    ):
        solved(totals)


def test_a_force_in_a_cell_is_divided_by_the_width_of_its_row():
    """Of the case, or of the table; a stress by the thickness of its row is multiplied."""
    table = {"nip_load [pli]": ["6 kN", 20.0, "6 kN"], "web_tension": ["5 MPa", 330.0, "5 MPa"],
             "width [m]": [None, 3.0, 3.0], "web.thickness [um]": [None, 66.0, 80.0]}  # fmt: skip
    found = solved(table, NIP.replace(width=2.0))
    pli = 4.4482216152605 / 0.0254
    same = {"nip_load": [3000.0, 20 * pli, 2000.0], "web_tension": [330.0, 330.0, 400.0],
            "web.thickness": [66e-6, 66e-6, 80e-6]}  # fmt: skip
    np.testing.assert_allclose(found[WOT], solved(same)[WOT], rtol=1e-8)


@pytest.mark.parametrize("header", ["web.density [kg/m^3]", "web density [lb/ft^3]"])
def test_a_basis_weight_is_divided_by_the_density_of_its_row(header: str):
    """The density of a web converts, and is no field."""
    unit = 1.0 if "kg" in header else 0.45359237 / 0.3048**3
    table = {"web.thickness [gsm]": [45.0, 60.0], header: [680 / unit, 750 / unit]}
    same = {"web.thickness": [45e-3 / 680, 60e-3 / 750]}
    np.testing.assert_allclose(solved(table)[WOT], solved(same)[WOT], rtol=1e-8)
    assert list(solved(table).columns)[:2] == list(table)
    with pytest.raises(wo.InvalidProblem, match=r"'1 gsm' is a basis weight.* Give the density"):
        solved({"web.thickness [gsm]": [45.0]})


def test_the_basis_weight_of_a_roll_needs_the_density_of_the_case_or_of_the_row():
    roll = wo.RollProblem.example().replace(density=680.0)
    table = {"web_thickness": ["45 gsm", "45 gsm", 66e-6], "density": [None, 750.0, "45 gsm"]}
    found = wo.solve_table(table, roll, ["layer_count", "mass"], workers=1)
    same = {
        "web_thickness": [45e-3 / 680, 45e-3 / 750, 66e-6],
        "density": [680, 750, 45e-3 / 66e-6],
    }
    expected = wo.solve_table(same, roll, ["layer_count", "mass"], workers=1)
    pandas.testing.assert_frame_equal(found.iloc[:, 2:], expected.iloc[:, 2:])


def test_columns_without_a_known_name_are_ignored_together(tmp_path: Path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("case.toml").write_text(to_toml(NIP))
    Path("cases.csv").write_text("Nr;Remark;nip_load [kN/m];b at v=900 [mm]\n7;x;2;3\n")
    command = ["table", "cases.csv", "--case", "case.toml", "-o", "r.csv", "--workers", "1",
               "--nodes", "13"]  # fmt: skip
    assert main(command) == 2
    assert main([*command, "--column", "*="]) == 0
    rows = list(csv.reader(Path("r.csv").read_text().splitlines()))
    assert rows[0][:4] == ["Nr", "Remark", "nip_load [kN/m]", "b at v=900 [mm]"]
    # the last equals sign separates the name, and the header has the unit
    assert main([*command, "--column", "*=", "--column", "b at v=900 [mm]=nip_width"]) == 0
    assert "b at v=900 [mm] (given)" in Path("r.csv").read_text()


def test_a_faulty_row_is_explained_and_the_others_are_solved():
    table = {
        "nip_load [N/m]": [2000.0, "abc", -5.0, 3000.0, 3000.0],
        "winding_force": [0.0, 0.0, 0.0, -900.0, 0.0],
        "web.material": ["newsprint", "newsprint", "newsprint", "newsprint", "cheese"],
    }
    found = solved(table)
    assert np.isfinite(found[WOT]).tolist() == [True, False, False, False, False]
    reasons = found.failure.tolist()
    assert reasons[0] == ""
    assert (
        reasons[1] == "column 'nip_load [N/m]': 'abc' is not a number; correct it or delete the row"
    )
    assert reasons[2].startswith("nip_load: -5 is out of range; must be >= 1e-12")
    assert reasons[3].startswith("winding_force: -900 is out of range; must be > -600")
    assert "web.material: 'cheese'" in reasons[4]
    assert not any("Error" in reason or "InvalidProblem" in reason for reason in reasons)


COMPLETE = {
    "web.thickness [um]": [66, 60, 66],
    "web.material": ["newsprint"] * 3,
    "roll.radius [mm]": [100, 200, 100],
    "roll.core_radius [mm]": [44.5] * 3,
    "roll.material": ["newsprint"] * 3,
    "drum.radius [mm]": [76.2] * 3,
    "roll_friction": [0.19] * 3,
    "drum_friction": [0.2, 0.2, None],
    "nip_load [N/m]": [3502.0, 3000.0, 3000.0],
    "web_tension [N/m]": [350.0, 300.0, 300.0],
}


def test_without_a_case_the_columns_describe_the_problem():
    found = solved(COMPLETE, None, kind="nip")
    other = NIP.replace(
        nip_load=3000.0, web_tension=300.0, **{"web.thickness": 60e-6, "roll.radius": 0.2}
    )
    expected = [wo.solve(problem, nodes=33).wound_on_tension for problem in (NIP, other)]
    assert found[WOT].tolist()[:2] == pytest.approx(expected, rel=1e-8)
    assert found.failure[2] == "drum_friction: missing; must be >= 1e-08 and <= 10"
    # the kind of problem with the fewest missing fields
    assert wo.solve_table(COMPLETE, **HERE).attrs["about"]["kind"] == "nip"


def test_other_columns_are_copied_and_measured_ones_are_kept():
    table = {"Nr": [7], "nip_load": [2000.0], WOT: [470.0]}
    found = solved(table, columns={"Nr": None})
    assert found["Nr"].tolist() == [7]
    assert found[f"{WOT} (given)"].tolist() == [470.0]
    assert found[WOT][0] != 470.0
    frame = pandas.DataFrame(table, index=["a"])
    assert solved(frame, columns={"Nr": None}).index.tolist() == ["a"]


@pytest.mark.parametrize("ending", [".csv", ".xlsx"])
def test_a_written_table_is_a_table_of_cases_again(tmp_path, ending):
    table = {"nip_load [kN/m]": [2.0, 3.0], "web_tension [N/m]": [350.0, -1.0]}
    first = solved(table)
    write_table(first, tmp_path / f"results{ending}")
    again = solved(tmp_path / f"results{ending}")
    assert list(again.columns) == list(first.columns)
    assert again[WOT].tolist() == pytest.approx(first[WOT].tolist(), nan_ok=True)
    assert again.failure.tolist() == first.failure.tolist()


@pytest.mark.slow
@pytest.mark.parametrize("workers", [1, 2])
def test_the_numbers_do_not_depend_on_the_number_of_processes(workers):
    loads = np.linspace(1500, 3500, 12)
    tensions = [None if k % 5 == 0 else 300.0 for k in range(12)]
    found = solved({"nip_load": loads, "web_tension": tensions}, workers=workers, chunk=6)
    single = [wo.solve(NIP.replace(nip_load=P, web_tension=T or 350.0), nodes=33).wound_on_tension
              for P, T in zip(loads[:6], tensions, strict=False)]  # fmt: skip
    assert found[WOT][:6].tolist() == pytest.approx(single, rel=1e-8)


# ---- the command --------------------------------------------------------------------------------


def test_from_excel_to_excel_in_one_command(tmp_path: Path, capsys, monkeypatch):
    pytest.importorskip("openpyxl")
    monkeypatch.chdir(tmp_path)
    Path("case.toml").write_text(template("nip"))
    loads = [1.5, 2.5, -1.0, 3.5]
    table = {"Nr": [1, 2, 3, 4], "nip_load [kN/m]": loads}
    pandas.DataFrame(table).to_excel("cases.xlsx", index=False)
    command = ["table", "cases.xlsx", "--case", "case.toml", "-o", "results.xlsx", "--workers", "1",
               "--column", "Nr=", "--nodes", "33", "--set", "web_tension=300 N/m"]  # fmt: skip
    assert main(command) == 0
    message = capsys.readouterr().out
    assert "4 rows in" in message
    assert "1 failed" in message
    assert "1 x nip_load: -1000 is out of range" in message
    found = pandas.read_excel("results.xlsx", keep_default_na=False)
    assert found["Nr"].tolist() == [1, 2, 3, 4]
    assert found.failure[2].startswith("nip_load: -1000 is out of range")
    expected = wo.solve(NIP.replace(nip_load=2500.0, web_tension=300.0), nodes=33).wound_on_tension
    assert found[WOT][1] == pytest.approx(expected, rel=1e-8)


def test_exit_status_of_the_command(tmp_path: Path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("case.toml").write_text(to_toml(NIP))
    Path("bad.csv").write_text("nip_load [N/m]\n-1\n")
    Path("good.csv").write_text("nip_load [N/m]\n2000\n")
    assert main(["table", "bad.csv", "--case", "case.toml", "-o", "r.csv"]) == 3
    assert Path("r.csv").read_text().count("out of range") == 1
    for wrong in (["-o", "r.txt"], ["-o", "none/r.csv"], ["-o", "r.csv", "--column", "x"]):
        assert main(["table", "good.csv", "--case", "case.toml", *wrong]) == 2
    assert main(["table", "good.csv", "-o", "r.csv", "--set", "nip_load=1"]) == 2
    assert "--set: changes a field of --case" in capsys.readouterr().err


# ---- cells of spreadsheets ----------------------------------------------------------------------

TEXTS = ["=1+1", "+A1", "-x", "@SUM(A1)", "'=2", "-2 mm", "007", "say, \"hi\"", "#N/A"]  # fmt: skip


def remarks(tmp_path: Path, ending: str) -> Path:
    """Write a solved table with texts that start like formulas, from a CSV file."""
    rows = "".join(f"{100 + 10 * k}.5;{'1e-3' if k else '2'};{text}\n"
                   for k, text in enumerate(TEXTS)).replace(".", ",")  # fmt: skip
    (tmp_path / "cases.csv").write_text(f"load [kN/m];Nr;=remark\n{rows}".replace("'=", "''="))
    columns = {"Nr": None, "=remark": None}
    pair = wo.RollerProblem.example()
    found = wo.solve_table(
        tmp_path / "cases.csv", pair, ["half_width"], columns=columns, nodes=13, workers=1
    )
    write_table(found, tmp_path / f"results{ending}")
    return tmp_path / f"results{ending}"


def test_texts_and_numbers_of_a_csv_file_are_texts_and_numbers_in_excel(tmp_path: Path):
    openpyxl = pytest.importorskip("openpyxl")
    sheet = openpyxl.load_workbook(remarks(tmp_path, ".xlsx")).worksheets[0]
    rows = list(sheet.iter_rows(min_row=2))
    assert [row[0].value for row in rows] == [100.5 + 10 * k for k in range(len(TEXTS))]
    assert {row[k].data_type for row in rows for k in (0, 3)} == {"n"}
    assert rows[0][1].value == 2
    assert [row[2].value for row in rows] == TEXTS
    assert {cell.data_type for row in sheet.iter_rows(min_col=3, max_col=3) for cell in row} == {
        "s"
    }
    # "quotePrefix": a spreadsheet keeps the text when the cell is edited
    assert [row[2].quotePrefix for row in rows][:6] == [True] * 4 + [False] * 2


def test_texts_that_start_like_formulas_have_an_apostrophe_in_csv_and_are_read_without_it(
    tmp_path: Path,
):
    path = remarks(tmp_path, ".csv")
    written = [row[2] for row in csv.reader(path.read_text().splitlines())]
    quoted = ["'=remark", "'=1+1", "'+A1", "'-x", "'@SUM(A1)", "''=2"]
    assert written == [*quoted, *TEXTS[5:]]
    sheet = read_sheet(path, "")
    assert sheet.columns["=remark"] == TEXTS


def test_the_path_of_a_table_may_be_a_text(tmp_path: Path):
    path = tmp_path / "loads.csv"
    path.write_text("load [kN/m]\n89\n", encoding="utf-8")
    solved = wo.solve_table(str(path), wo.RollerProblem.example(), ["half_width"], nodes=17)
    assert list(solved.index) == [0]


def test_a_column_without_a_unit_has_no_brackets(tmp_path: Path) -> None:
    path = tmp_path / "rolls.csv"
    path.write_text("wound_on_tension;core_removed\nN/m;\n300;false\n350;true\n")
    solved = wo.solve_table(path, wo.RollProblem.example(), outputs=["core_pressure"], rtol=0.01)
    assert list(solved.columns[:2]) == ["wound_on_tension [N/m]", "core_removed"]
    assert solved["core_pressure [Pa]"].iloc[1] == 0
