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


def test_missing_openpyxl_is_reported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setitem(sys.modules, "openpyxl", None)
    for call in (_read, check_export):
        with pytest.raises(InvalidProblem, match=r"need openpyxl: pip install 'woundon\[excel\]'"):
            call(tmp_path / "rig.xlsx")
