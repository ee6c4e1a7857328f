"""Measured data from files and columns: units in the header, gaps, and what is refused."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
from thesis_cases import paper_nip

from woundon import InvalidProblem
from woundon.studies.export import check_export
from woundon.studies.kind_model import columns_of, measurable
from woundon.studies.measured import read_measured

NIP = paper_nip().replace(roll_wrap=np.pi)
OUTPUTS = measurable(NIP)


def _read(data, columns=None):
    return read_measured(data, columns_of(NIP), OUTPUTS, columns)


def test_csv_with_units(tmp_path: Path):
    path = tmp_path / "rig.csv"
    path.write_text(
        "# laboratory winder\nnip_load [kN/m], web.thickness [um], wound_on_tension [N/cm], "
        "wound_on_tension +- [N/m]\n1.9, 66, 6.5, 10\n\n2.5, 57, , \n",
        encoding="utf-8",
    )
    data = _read(path)
    assert data.inputs["nip_load"] == pytest.approx([1900.0, 2500.0])
    assert data.inputs["web.thickness"] == pytest.approx([66e-6, 57e-6])
    assert np.array_equal(data.outputs["wound_on_tension"], [650.0, np.nan], equal_nan=True)
    assert data.deviations["wound_on_tension"][0] == 10.0


def test_a_formula_that_failed_is_no_gap(tmp_path: Path):
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    book.active.append(["nip_load [N/m]", "half_width [mm]"])
    book.active.append([1000, "#DIV/0!"])
    book.active["B2"].data_type = "e"
    book.save(tmp_path / "rig.xlsx")
    with pytest.raises(
        InvalidProblem, match=r"row 2, column 'half_width \[mm\]': '#ERROR' is not a"
    ):
        _read(tmp_path / "rig.xlsx")


GOOD = "wound_on_tension [N/m]"


@pytest.mark.parametrize(
    ("columns", "says"),
    [
        (
            {"nip_lode": [1.0], GOOD: [1.0]},
            "column 'nip_lode': no field or output; did you mean 'nip_load'",
        ),
        ({"wound_on_tenson": [1.0]}, "no field or output; did you mean 'wound_on_tension'"),
        ({"nip_load": [1.0]}, "has no column that is an output"),
        ({"nip_load [mm]": [1.0], GOOD: [1.0]}, "mm"),
        ({"nip_load [lb]": [1.0], GOOD: [1.0]}, "lb"),
        ({"nip_load": ["1k"], GOOD: [1.0]}, "row 1, column 'nip_load': '1k' is not a number"),
        ({"nip_load": [""], GOOD: [1.0]}, "row 1, column 'nip_load': the cell is empty"),
        (
            {"nip_load": [np.inf], GOOD: [1.0]},
            "row 1, column 'nip_load': inf is not a finite number",
        ),
        ({"nip_load": [np.nan], GOOD: [1.0]}, "row 1, column 'nip_load': the cell is empty"),
        ({"nip_load": [1.0, 2.0], GOOD: [1.0]}, "columns differ in length: [1, 2]"),
        (
            {"drum": ["steel"], GOOD: [1.0]},
            "column 'drum': is not a number, so it cannot be a column here",
        ),
        ({GOOD: [1.0], "wound_on_tension +-": [0.0]}, "deviations of wound_on_tension must be > 0"),
        ({GOOD: [1.0], "half_width +-": [1.0]}, "deviations of half_width must be > 0 wherever"),
    ],
)
def test_bad_columns_are_rejected(columns, says):
    with pytest.raises(InvalidProblem) as fault:
        _read(columns)
    assert says in str(fault.value)


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (b"", "has no header with rows below it"),
        (b"nip_load,half_width\n", "has no header with rows below it"),
        (b"nip_load,half_width\n1,2,3\n", "row 2 has 3 cells, the header 2"),
        (b"nip_load,half_width\n1,2\n3\n", "row 3 has 1 cells, the header 2"),
        (b"half_width,half_width\n1,2\n", "two columns have the same header"),
        (b"nip_load,half_width\n\x81,1\n", "is not a text file; save it as .xlsx"),
    ],
)
def test_bad_files_are_rejected(tmp_path: Path, content, says):
    path = tmp_path / "rig.csv"
    path.write_bytes(content)
    with pytest.raises(InvalidProblem, match=says):
        _read(path)


def test_missing_openpyxl_is_reported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setitem(sys.modules, "openpyxl", None)
    for call in (_read, check_export):
        with pytest.raises(InvalidProblem, match=r"need openpyxl: pip install 'woundon\[excel\]'"):
            call(tmp_path / "rig.xlsx")
