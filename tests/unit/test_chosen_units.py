"""Units of choice: in reports, figures and tables, and nowhere else."""

from __future__ import annotations

import csv
from pathlib import Path

import pandas
import pytest
from thesis_cases import newsprint_nip

import woundon as wo
from woundon.quantities import find, output


@pytest.fixture(scope="module")
def nip():
    return wo.solve(newsprint_nip(), nodes=33)


def line(text: str, meaning: str) -> str:
    return next(" ".join(row.split()) for row in text.splitlines() if meaning in row)


def test_reports_show_fields_and_outputs_with_their_errors(nip):
    before = str(nip)
    with wo.units({"nip_load": "kN/m"}, nip_width="um"):
        message = str(nip)
    assert line(message, "nip load") == "nip load P 3.502 kN/m"
    error = 1e6 * nip.errors["nip_width"]
    assert line(message, "nip width").startswith(f"nip width 2a {1e6 * nip.nip_width:.5g} um")
    assert line(message, "nip width").endswith(f"± {error:.2g}")
    assert str(nip) == before


def test_choices_nest_and_are_taken_back():
    with wo.units(nip_load="kN/m"):
        with wo.units(half_width="um"):
            assert find(wo.NipProblem, "nip_load")[0].quantity.display == "kN/m"
            assert output(wo.NipResult, "half_width").quantity.display == "um"
        assert output(wo.NipResult, "half_width").quantity.display == "mm"
    assert find(wo.NipProblem, "nip_load")[0].quantity.display == "N/m"


def test_files_for_programs_stay_si(nip, tmp_path: Path):
    with wo.units(nip_load="kN/m", half_width="um"):
        nip.save(tmp_path / "nip.json")
        assert nip.to_xarray().half_width.attrs["units"] == "m"
    assert wo.load_result(tmp_path / "nip.json") == nip


# ---- CSV of one result --------------------------------------------------------------------------


def test_csv_holds_single_numbers_and_arrays(nip, tmp_path: Path):
    path = tmp_path / "nip.csv"
    with wo.units(nip_load="kN/m", x="um"):
        nip.save(path)
    frame = pandas.read_csv(path, comment="#")
    assert frame["x [um]"].tolist() == pytest.approx(1e6 * nip.x, rel=1e-15)
    assert frame["drum_pressure [Pa]"].tolist() == nip.drum_pressure.tolist()
    lines = [row[2:] for row in path.read_text("utf-8").splitlines() if row.startswith("# ")]
    computed = dict(csv.reader(lines))
    assert float(computed["nip_load [kN/m]"]) == 3.502
    assert float(computed["web.material.shear [Pa]"]) == nip.problem.web.material.shear
    assert float(computed["nip_induced_tension [N/m]"]) == nip.nip_induced_tension
    assert float(computed["half_width_error [m]"]) == nip.errors["half_width"]
    assert len(lines) == len(computed)  # nothing is reported twice
