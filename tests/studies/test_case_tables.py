"""Tables of cases: what a study writes is read as the cases of another, and so are people's own."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pandas
import pytest
import study_models as models
from thesis_cases import paper_nip

import woundon as wo
from woundon.cli import commands as cli
from woundon.studies.export import export

CASE = Path(__file__).with_name("nip_alone.toml")
STEEL = wo.HalfPlane(radius=0.1, material=wo.material("steel"))
OVER = {
    "nip_load": [1000.0, 3502.123456789],
    "drum": [wo.Rigid(radius=0.0762), STEEL],
    "web.material": ["newsprint", "paper"],
    "winding_force": [0.0, 500.0],  # too much for the lower load
}
OUTPUTS = ["nip_width", "errors.half_width"]
QUICK = {"nodes": 13}
# The cases are solved in another order, from other starts, each to the solver's own tolerance:
# 1e-11 on the last mesh.  Error estimates contain the coarser ones, where the last step of ln(a)
# is below 1e-5, so 3 times twice that in the half width.
SAME, SAME_ESTIMATE = 1e-8, 6e-5


@pytest.fixture(scope="module")
def study():
    return models.table_of(paper_nip(), OVER, OUTPUTS, options=QUICK)


@pytest.mark.parametrize("ending", ["csv", "xlsx"])
def test_a_table_that_a_study_writes_is_read_as_cases(tmp_path: Path, study, ending: str):
    if ending == "xlsx":
        pytest.importorskip("openpyxl")
    path = tmp_path / f"study.{ending}"
    export(study, path)
    again = models.table_of(paper_nip(), path, OUTPUTS, options=QUICK)
    assert again.cases.design == "table"
    one, two = study.cases.frame, again.cases.frame
    assert list(one) == list(two)
    assert all(list(one[name]) == list(two[name]) for name in one)  # to the last bit
    assert 0 < study.failed.size < len(study.cases)
    width = study.outputs["nip_width"]
    assert again.outputs["nip_width"] == pytest.approx(width, rel=SAME, nan_ok=True)
    difference = again.outputs["errors.half_width"] - study.outputs["errors.half_width"]
    assert np.nanmax(np.abs(difference) / (width / 2)) < SAME_ESTIMATE


def test_a_table_of_ones_own_from_a_study_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    (tmp_path / "cases.csv").write_text(
        "Linienlast;Papier;Trommel;Nr;WOT N/m\n1,5;paper;\"{\"\"kind\"\": \"\"rigid\"\", "
        "\"\"radius\"\": 0.1}\";A;650\n2,5;newsprint;\"{\"\"radius\"\": 0.2}\";B;\n", "utf-8",
    )  # fmt: skip
    study = tmp_path / "study.toml"
    study.write_text(
        f'schema = 1\ncase = "{CASE.as_posix()}"\nover = "cases.csv"\n'
        '[columns]\nLinienlast = "nip_load [kN/m]"\nPapier = "web.material"\nTrommel = "drum"\n'
        'Nr = ""\n"WOT" = ""\n[solver]\nnodes = 13\n',
        encoding="utf-8",
    )
    out = tmp_path / "out"
    command = ["sweep", str(study), "--out", str(out), "--workers", "1"]
    assert cli.main([*command, "--unit", "nip_load=kN/m"]) == 0
    said = capsys.readouterr().out
    assert "2 cases" in said
    rows = list(csv.DictReader((out / "study.csv").read_text("utf-8").splitlines()))
    assert [row["nip_load [kN/m]"] for row in rows] == ["1.5", "2.5"]
    assert [row["web.material"] for row in rows] == ["paper", "newsprint"]
    case = wo.load_case(CASE).replace(
        nip_load=1500.0, drum=wo.Rigid(radius=0.1), **{"web.material": wo.material("paper")}
    )
    single = wo.solve(case, nodes=13).wound_on_tension
    assert float(rows[0]["wound_on_tension [N/m]"]) == pytest.approx(single, rel=SAME)


def test_what_is_field_and_output_is_an_input_unless_a_study_wrote_the_table(tmp_path: Path):
    pair = wo.RollerProblem.example()
    table = models.table_of(pair, {"load": [8e4, 9e4]}, ["creepage"], options={"nodes": 17})
    export(table, tmp_path / "study.csv")
    again = models.table_of(pair, tmp_path / "study.csv", ["creepage"], options={"nodes": 17})
    assert again.cases.names == ("load",)
    own = pandas.DataFrame({"load": [8e4], "creepage": [1e-4]})
    free = pair.replace(tangential_load=None)
    given = models.table_of(free, own, ["tangential_load"], options={"nodes": 17})
    assert given.cases.names == ("load", "creepage")


@pytest.mark.parametrize(
    ("lines", "says"),
    [
        ('over = "none.csv"', "none.csv: cannot be read: No such file"),
        ('over = "cases.csv"\n[columns]\nP = 5', "columns.P: 5 is not a name, as text"),
        ("[over]\nnip_load = [1]\n[columns]\nP = 'nip_load'", "columns: there is no table; write"),
        ('over = "cases.csv"\n[design]\nkind = "sobol"\nsamples = 8', "over"),
    ],
)
def test_bad_study_files_with_tables_are_rejected(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], lines: str, says: str
):
    (tmp_path / "cases.csv").write_text("nip_load [N/m]\n1000\n", "utf-8")
    study = tmp_path / "study.toml"
    study.write_text(f'schema = 1\ncase = "{CASE.as_posix()}"\n{lines}\n', "utf-8")
    assert cli.main(["sweep", str(study), "--out", str(tmp_path / "out")]) == 2
    assert says in capsys.readouterr().err
