"""Tables as people keep them: headers and numbers as spreadsheets write them, faults by place."""

from __future__ import annotations

import csv
import io
import sys
from pathlib import Path

import numpy as np
import pytest

import woundon as wo
from woundon.errors import InvalidProblem
from woundon.io import sheets, table_files
from woundon.studies.api import study_of
from woundon.studies.column_names import columns_of, measurable_outputs
from woundon.studies.export import check_export
from woundon.studies.measured_tables import Measured, read_measured

NIP = wo.NipProblem.example()


def read(data, columns=None) -> Measured:
    return read_measured(data, columns_of(NIP), measurable_outputs(NIP), columns)


def written(folder: Path, text: str | bytes, name: str = "rig.csv", code: str = "utf-8") -> Path:
    path = folder / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode(code))
    return path


def faults(data, columns=None) -> list[str]:
    with pytest.raises(InvalidProblem) as refusal:
        read(data, columns)
    return [text for _, text in refusal.value.faults]


# ---- headers ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "header",
    [
        "nip_load [kN/m]", "nip_load kN/m", "nip load (kN/m)", "nip load [kN/m]", "nip load, kN/m",
        "NIP LOAD [ kN / m ]", "Nip-load / (kN/m)", "nip load in kN/m", "nip_load_kN/m",
        "P [kN/m]", "Nip load P [kN/m]", "  nip   load\n[kN/m] ",
    ],
)  # fmt: skip
def test_a_header_is_matched_as_people_write_it(tmp_path: Path, header: str):
    path = written(tmp_path, f'"{header}";WOT N/m\n1.9;650\n')
    data = read(path)
    assert data.inputs["nip_load"].tolist() == [1900.0]
    assert data.outputs["wound_on_tension"].tolist() == [650.0]


@pytest.mark.parametrize(
    ("header", "name", "value"),
    [
        ("web thickness [um]", "web.thickness", 66e-6),
        ("Web.Thickness \N{MICRO SIGN}m", "web.thickness", 66e-6),
        ("2h, um", "web.thickness", 66e-6),
        ("roll friction [%]", "roll_friction", 0.66),
        ("mu+ [-]", "roll_friction", 66.0),
        ("Roll friction", "roll_friction", 66.0),
        ("web material poissons ratio", "web.material.poissons_ratio", 66.0),
        ("T_in [N/m]", "web_tension", 66.0),
    ],
)
def test_names_symbols_and_meanings_of_units(header: str, name: str, value: float):
    data = read({header: [66], "wound_on_tension": [650.0]})
    assert data.inputs[name].tolist() == [value]  # to the last bit: by exact fractions


def test_one_header_is_assigned_once_in_any_spelling():
    twice = "is given twice, ('Load', 'nip_load') and ('LOAD', None); must be given once"
    assert faults({"load": [1.0]}, {"Load": "nip_load", "LOAD": None}) == [twice]


# ---- text files ---------------------------------------------------------------------------------

GERMAN = (
    "Nip load kN/m;Web thickness µm;WOT ± N/m;WOT N/m\n1,9;66;5,5;650\n;;;\n2,5;57,5;6;700,25\n"
)


@pytest.mark.parametrize("code", ["utf-8", "utf-8-sig", "cp1252", "utf-16"])
@pytest.mark.parametrize("between", [";", "\t"])
@pytest.mark.parametrize("ending", ["\n", "\r\n"])
def test_text_as_european_excel_writes_it(tmp_path: Path, code, between, ending):
    text = GERMAN.replace(";", between).replace("\n", ending)
    data = read(written(tmp_path, text, code=code))
    assert data.inputs["nip_load"].tolist() == [1900.0, 2500.0]
    assert data.inputs["web.thickness"].tolist() == [66e-6, 57.5e-6]
    assert data.outputs["wound_on_tension"].tolist() == [650.0, 700.25]
    assert data.deviations["wound_on_tension"].tolist() == [5.5, 6.0]
    assert list(data.numbers) == [2, 4]


@pytest.mark.parametrize(
    "text",
    [
        "sep=;\nnip_load [kN/m];WOT [N/m]\n1.9;650\n",
        "Laboratory winder\n\nnip_load [kN/m],WOT [N/m]\n1.9,650\n",
        '# the rig\'s "first" day\nnip_load [kN/m],WOT [N/m],,\n1.9,650,,\n,,,\n',
        ",nip_load [kN/m],WOT [N/m]\n0,1.9,650\n",  # an index that has no header
        'nip_load [kN/m],WOT [N/m],"warnings"\n1.9,650,"a; b; c"\n',
    ],
)
def test_what_stands_around_a_table_is_left_out(tmp_path: Path, text: str):
    data = read(written(tmp_path, text))
    assert data.inputs["nip_load"].tolist() == [1900.0]
    assert data.outputs["wound_on_tension"].tolist() == [650.0]


def test_a_spreadsheet_by_another_name_is_reported(tmp_path: Path):
    assert faults(written(tmp_path, b"\xd0\xcf\x11\xe0....")) == [
        "is not a text file; save it as .xlsx or .csv"
    ]


# ---- Excel --------------------------------------------------------------------------------------


def book(folder: Path, rows, *merged: str) -> Path:
    openpyxl = pytest.importorskip("openpyxl")
    made = openpyxl.Workbook()
    for row in rows:
        made.active.append(row)
    for block in merged:
        made.active.merge_cells(block)
    made.save(folder / "rig.xlsx")
    return folder / "rig.xlsx"


def test_merged_cells_titles_and_blank_rows_of_excel(tmp_path: Path):
    rows = [
        ["Laboratory winder", None, None], [None, None, None],
        ["nip load", "web tension", "WOT"], ["kN/m", "N/m", "N/m"],
        [1.9, 350, 650], [2.5, None, None], [None, None, None], [3.1, 260, 700],
    ]  # fmt: skip
    data = read(book(tmp_path, rows, "A1:C1", "B5:B6"))
    assert data.inputs["nip_load"].tolist() == [1900.0, 2500.0, 3100.0]
    assert data.inputs["web_tension"].tolist() == [350.0, 350.0, 260.0]
    assert np.array_equal(data.outputs["wound_on_tension"], [650, np.nan, 700], equal_nan=True)
    assert list(data.numbers) == [5, 6, 8]


def test_long_merged_blocks_of_a_wide_table_are_repeated(tmp_path: Path):
    """All columns but the first are one block each: not more cells than the table has."""
    rows, columns = 250, 100
    body = [[1.0, *range(1, columns)], *([k] for k in range(2, rows + 1))]
    blocks = [f"{name}2:{name}{rows + 1}" for name in columns_of_excel(columns)[1:]]
    path = book(tmp_path, [[f"c{k}" for k in range(columns)], *body], *blocks)
    read_columns = sheets.read_sheet(path, "rig").columns
    assert read_columns["c1"] == [1] * rows
    assert read_columns["c99"] == [99] * rows


def columns_of_excel(count: int) -> list[str]:
    utils = pytest.importorskip("openpyxl.utils")
    return [utils.get_column_letter(k) for k in range(1, count + 1)]


def test_overlapping_merged_blocks_are_rejected_by_their_place():
    cells = np.full((1000, 1000), "", dtype=object)
    with pytest.raises(InvalidProblem, match="row 1, column 1: merged cells overlap"):
        table_files._repeat_merged(cells, [(1, 1, 1000, 1000)] * 3, "rig.xlsx")


def test_merged_titles_next_to_each_other_are_no_header(tmp_path: Path):
    rows = [
        ["Rig", None, "May", None],
        ["nip load [N/m]", "WOT [N/m]", "web tension [N/m]", "nip width [mm]"],
        [1000, 650, 300, 2],
    ]
    data = read(book(tmp_path, rows, "A1:B1", "C1:D1"))
    assert data.inputs["nip_load"].tolist() == [1000.0]
    assert list(data.numbers) == [3]


def percentages(folder: Path, header: str, cells: list[tuple[object, str]]) -> Path:
    """Write an Excel file with a column of (value, number format)."""
    path = book(folder, [[header, "WOT [N/m]"], *([value, 650] for value, _ in cells)])
    openpyxl = pytest.importorskip("openpyxl")
    made = openpyxl.load_workbook(path)
    for row, (_, number_format) in enumerate(cells, 2):
        made.active.cell(row, 1).number_format = number_format
    made.save(path)
    return path


# 20 % as Excel keeps it, with formats of its menu, and as a text; the last two are displayed with a
# sign that does not multiply by 100 (ECMA-376 part 1, 18.8.31)
TWENTY = [
    (0.2, "0%"), (0.2, "0.00%"), (0.2, "[Red]0.0 %;-0.0 %"), (0.2, '"x"0%'), ("20 %", "@"),
    (20, '0"%"'), (20, "0\\%"),
]  # fmt: skip


@pytest.mark.parametrize("header", ["roll_friction [%]", "roll_friction"])
def test_a_percentage_of_excel_is_what_is_displayed(tmp_path: Path, header: str):
    path = percentages(tmp_path, header, TWENTY)
    expected = [0.2] * len(TWENTY)
    assert read(path).inputs["roll_friction"].tolist() == pytest.approx(expected, rel=1e-15)
    _, cases = study_of(NIP, path, ["half_width"])
    assert cases.frame["roll_friction"].tolist() == pytest.approx(expected)
    solved = wo.solve_table(path, NIP, ["wound_on_tension"], nodes=13, workers=1)
    alone = wo.solve(NIP.replace(roll_friction=0.2), nodes=13).wound_on_tension
    np.testing.assert_allclose(solved["wound_on_tension [N/m]"], alone, rtol=1e-8)  # starts differ


# ECMA-376 part 1, 18.8.31: a comma that no digit follows divides by a thousand
@pytest.mark.parametrize("number_format", ["0.0,", "#,##0,,", '0.0, "k"', "0,.0", "0;-0,"])
def test_a_number_that_excel_displays_in_thousands_is_rejected(tmp_path: Path, number_format: str):
    path = percentages(tmp_path, "nip_load [N/m]", [(1900, "#,##0.0_);(#,##0.0)")])
    assert read(path).inputs["nip_load"].tolist() == [1900.0]
    path = percentages(tmp_path, "nip_load [N/m]", [(1900, number_format)])
    expected = (
        "row 2, column 'nip_load [N/m]': 1900 is displayed in thousands by its number format; "
        "must have a number format without a comma after the last digit"
    )
    assert faults(path) == [expected]
    solved = wo.solve_table(path, NIP, ["wound_on_tension"], nodes=13, workers=1)
    assert expected.partition(", ")[2] in solved["failure"][0]


def test_a_percentage_is_no_length(tmp_path: Path):
    path = percentages(tmp_path, "nip_load [N/m]", [(0.2, "0%")])
    assert "'20.0 %' has the wrong dimension" in faults(path)[0]


def test_cells_of_excel_that_hold_no_number(tmp_path: Path):
    rows = [["nip_load [N/m]", "WOT [N/m]"], [True, 1]]
    message = faults(book(tmp_path, rows))
    assert message == [
        "row 2, column 'nip_load [N/m]': True is not a number; correct it or delete the row"
    ]
    message = faults(book(tmp_path, [*rows, ["=A1*2", 2]]))
    assert message[0].startswith("row 3, column 1: the formula has no value; open and save")


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ('a,"b\nc\nd', "row 2: is not a table: a quote has no end"),
        ('"a" b,c', "row 2: is not a table: in a cell in quotes, ',' expected after '\"'"),
        (
            '"' + "x\n" * 70_000,
            "row 2: is not a table: a quote has no end, or a cell has more than",
        ),
    ],
)
def test_quotes_that_do_not_match_are_reported_by_row(tmp_path: Path, text: str, fault: str):
    assert faults(written(tmp_path, f"nip_load [N/m],WOT [N/m]\n{text}"))[0].startswith(fault)


def test_separators_quotes_and_lines_in_quotes_belong_to_the_cell(tmp_path: Path):
    """As the csv module writes them; the rows keep the numbers of a spreadsheet."""
    rows = [["case", "nip_load [N/m]", "WOT [N/m]"], ['a "b", c\nd', "1000", "650"], ["", "x", "7"]]
    text = io.StringIO()
    csv.writer(text).writerows(rows)
    sheet = sheets.read_sheet(written(tmp_path, text.getvalue()), "measured")
    assert sheet.columns["case"] == ['a "b", c\nd', ""]
    assert list(sheet.numbers) == [2, 3]


def test_a_formula_that_failed_is_no_gap(tmp_path: Path):
    openpyxl = pytest.importorskip("openpyxl")
    path = book(tmp_path, [["nip_load [N/m]", "WOT [N/m]"], [1000, "#DIV/0!"]])
    made = openpyxl.load_workbook(path)
    made.active["B2"].data_type = "e"
    made.save(path)
    assert faults(path)[0].startswith("row 2, column 'WOT [N/m]': '#")


def test_missing_openpyxl_is_reported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setitem(sys.modules, "openpyxl", None)
    for call in (read, check_export):
        with pytest.raises(InvalidProblem, match=r"need openpyxl: pip install 'woundon\[excel\]'"):
            call(tmp_path / "rig.xlsx")
