"""Tables that are made to keep a reader busy: each is rejected by row and column, within seconds.

Evidence: measured processor time. Without the limits most of these files take from 15 s to hours.
"""

from __future__ import annotations

import time
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest
from thesis_cases import newsprint_nip

import woundon as wo
from woundon.io.case_files import template

NIP = newsprint_nip()
SECONDS = 6.0  # of processor time, with every reserve: each takes less than 2
HEAD, ROW = "nip_load [N/m],half_width [mm]\n", "2000,4\n"


def rejected(path: Path) -> str:
    """Return why a table of measured data is rejected, in time."""
    start = time.process_time()
    with pytest.raises(wo.InvalidProblem) as fault:
        wo.fit(NIP, path, ["roll_friction"], nodes=17)
    assert time.process_time() - start < SECONDS
    assert max(map(len, str(fault.value).splitlines())) < 1100
    return str(fault.value)


# ---- text ---------------------------------------------------------------------------------------

TEXTS = {
    "header of separators": (HEAD[:-1] + "," * 100_000 + "x\n" + ROW, "row 1, column"),
    "header of names": (",".join(f"c{k}" for k in range(20_000)) + "\n" + ROW, "row 1, column"),
    "header of brackets": (f"half_width [mm],{'[' * 100_000}\n{ROW}", "row 1, column 2"),
    "header of units": (f"nip_load [{'N*' * 50_000}N],half_width [mm]\n{ROW}", "row 1, column 1"),
    "header of a few hundred strange columns": (
        ",".join(f"strange column {k} of {'x' * 150}" for k in range(400)) + "\n" + "1," * 400,
        "column 'strange column 0",
    ),
    "number of 100 000 digits": (f"{HEAD}{'1' * 100_000},4\n", "row 2, column 1"),
    "digits and commas": (
        f'{HEAD}"{"1," * 15_000}x1",4\n', "row 2, column 'nip_load [N/m]'",
    ),
    "cell of spaces": (f'{HEAD}2000,"4{" " * 100_000}x"\n', "row 2, column 2"),
    "quoted cell of lines": (HEAD + '2000,"' + "4 mm\n" * 20_000 + '"\n', "row 2"),
    "quote without an end": (HEAD + '2000,"' + ROW * 30_000, "row"),
    "line of megabytes": (f"{HEAD}{'1,' * 5_000_000}1\n", "row 2, column"),
    "lines without end": (HEAD + "\n" * 3_000_000, "rows"),
    "faulty cells": (HEAD + "x,y\n" * 200_000, "row 2, column 'nip_load [N/m]'"),
}  # fmt: skip


@pytest.mark.parametrize("name", TEXTS)
def test_a_hostile_text_is_rejected_by_row_and_column_in_time(name: str, tmp_path: Path):
    text, place = TEXTS[name]
    path = tmp_path / "rig.csv"
    path.write_text(text, encoding="utf-8")
    assert place in rejected(path)


@pytest.mark.parametrize("digits", [5_000, 100_000])
def test_hostile_headers_and_cells_in_memory_are_rejected_in_time(digits: int):
    for table in (
        {"a, " * digits: [1.0], "half_width": [4e-3]},
        {"nip_load": ["1" * digits + "x"], "half_width": [4e-3]},
        {"nip_load": [10**digits], "half_width": [4e-3]},
        {f"c{k}": [1.0] for k in range(digits)},
    ):
        rejected(table)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "cell",
    ['{"a":' * 20_000, '{"a":' * 5000,
     '{"a":' * 5000 + "1" + "}" * 5000, '{"kind": ' + "9" * 5000 + "}",
     "{" + ",".join(f'"radius{k}": 1' for k in range(2000)) + "}"],
    ids=["long", "open", "deep", "digits", "names"],
)  # fmt: skip
def test_a_hostile_body_in_a_cell_is_rejected_in_time(cell: str, tmp_path: Path):
    path = tmp_path / "cases.csv"
    quoted = cell.replace('"', '""')
    path.write_text(f'drum\n"{quoted}"\n', encoding="utf-8")
    start = time.process_time()
    with pytest.raises(wo.InvalidProblem, match="row 2, column"):
        wo.sweep(NIP, path, nodes=17, workers=1)
    assert time.process_time() - start < SECONDS


CURVES = {
    "header of separators": "pressure [kPa]," * 50_000 + "strain [%]\n10,0.9\n",
    "number of 1 000 000 digits": f"pressure [kPa],strain [%]\n{'1' * 1_000_000},0.9\n25,1.6\n",
    "quote without an end": 'pressure [kPa],strain [%]\n10,"' + "0.9\n25,1.6\n" * 40_000,
    "millions of rows": "pressure [kPa],strain [%]\n" + "1,1\n" * 2_000_000,
}


@pytest.mark.parametrize("name", CURVES)
def test_a_hostile_curve_of_a_case_is_rejected_in_time(name: str, tmp_path: Path):
    (tmp_path / "curve.csv").write_text(CURVES[name], encoding="utf-8")
    case = template("roll") + '\n[stack.curve]\ncsv = "curve.csv"\n'
    (tmp_path / "case.toml").write_text(case, encoding="utf-8")
    start = time.process_time()
    with pytest.raises(wo.InvalidProblem) as fault:
        wo.load_case(tmp_path / "case.toml")
    assert time.process_time() - start < SECONDS
    assert "curve.csv" in str(fault.value)


# ---- Excel --------------------------------------------------------------------------------------


def book(folder: Path, change: Callable[[object], None]) -> Path:
    openpyxl = pytest.importorskip("openpyxl")
    made = openpyxl.Workbook()
    for row in (["nip_load [N/m]", "half_width [mm]"], [2000, 4], [3000, 5], [4000, 6], [5000, 7]):
        made.active.append(row)
    change(made.active)
    made.save(folder / "rig.xlsx")
    return folder / "rig.xlsx"


def rewritten(path: Path, old: str, new: str, part: str = "xl/worksheets/sheet1.xml") -> Path:
    """Replace a text in a part of an Excel file."""
    with zipfile.ZipFile(path) as archive:
        parts = {name: archive.read(name) for name in archive.namelist()}
    assert old.encode() in parts[part]
    parts[part] = parts[part].replace(old.encode(), new.encode(), 1)
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in parts.items():
            archive.writestr(name, content)
    return path


MERGED = '<mergeCells count="1"><mergeCell ref="A3:A4" /></mergeCells>'


@pytest.mark.parametrize(
    ("blocks", "place"),
    [
        (["A5:B900000"], "row 5, column 1"),
        (["A2:B1048576"], "row 2, column 1"),
        (["B2:XFD1048576"], "row 2, column 2"),
        (["$A$5:$B$900000"], "row 5, column 1"),
        (["A3:A4"] * 200_000, "merged cells"),
        ([f"A{k}:B{k + 900_000}" for k in range(2, 900)], "row 2, column 1"),
        (["A5:B99999999999"], "is not an Excel file"),
        (["nonsense"], "is not an Excel file"),
    ],
    ids=["A5:B900000", "all rows", "all", "absolute", "many", "many long", "beyond", "nonsense"],
)
def test_merged_cells_that_reach_too_far_are_rejected_in_time(blocks, place, tmp_path: Path):
    path = book(tmp_path, lambda sheet: sheet.merge_cells("A3:A4"))
    cells = "".join(f'<mergeCell ref="{block}"/>' for block in blocks)
    rewritten(path, MERGED, f"<mergeCells>{cells}</mergeCells>")
    assert place in rejected(path)


@pytest.mark.parametrize(
    ("cell", "place"),
    [
        ("XFD3", "row 3, column 16384"),
        pytest.param("B900000", "row 900000, column 2", marks=pytest.mark.slow),
        pytest.param("XFD1048576", "row 1048576, column 16384", marks=pytest.mark.slow),
    ],
)
def test_a_stray_cell_is_rejected_by_row_and_column_in_time(cell: str, place: str, tmp_path: Path):
    def stray(sheet):
        sheet[cell] = 1

    assert place in rejected(book(tmp_path, stray))


DATA_END = "</sheetData>"


@pytest.mark.parametrize(
    "rows",
    [
        pytest.param(
            '<row r="2000000000"><c r="A2000000000"><v>1</v></c></row>', marks=pytest.mark.slow
        ),
        "".join(f'<row r="{k}"><c r="XFD{k}"><v>1</v></c></row>' for k in range(6, 20_000)),
        "".join(f'<row r="{k}"><c r="XFD{k}"/></row>' for k in range(6, 20_000)),
        f'<row r="6"><c r="A6" t="inlineStr"><is><t>{"1" * 100_000}</t></is></c></row>',
        f'<row r="6"><c r="A6"><v>{"1" * 100_000}</v></c></row>',
    ],
    ids=["row 2e9", "wide rows", "wide empty rows", "text of digits", "number"],
)
def test_rows_of_a_hostile_sheet_are_rejected_in_time(rows: str, tmp_path: Path):
    path = book(tmp_path, lambda sheet: None)
    rejected(rewritten(path, DATA_END, rows + DATA_END))


def test_an_archive_that_unpacks_to_gigabytes_is_rejected_in_time(tmp_path: Path):
    path = book(tmp_path, lambda sheet: None)
    with zipfile.ZipFile(path, "a", zipfile.ZIP_DEFLATED) as archive:
        for k in range(4):
            archive.writestr(f"xl/media/{k}.xml", bytes(20_000_000))
    assert path.stat().st_size < 1_000_000
    assert "unpacked" in rejected(path)


def test_entities_that_expand_are_rejected_in_time(tmp_path: Path):
    path = book(tmp_path, lambda sheet: None)
    entities = "".join(
        f'<!ENTITY e{k} "' + (f"&e{k - 1};" * 10 if k else "ha") + '">' for k in range(12)
    )
    rewritten(path, "<worksheet", f"<!DOCTYPE worksheet [{entities}]><worksheet")
    text = '<row r="6"><c r="A6" t="inlineStr"><is><t>&e11;</t></is></c></row>'
    rejected(rewritten(path, DATA_END, text + DATA_END))


def test_a_damaged_excel_file_is_rejected(tmp_path: Path):
    whole = book(tmp_path, lambda sheet: None).read_bytes()
    for content in (b"", b"PK", whole[:1000], whole[:-30], whole[:50] + bytes(200) + whole[250:]):
        (tmp_path / "bad.xlsx").write_bytes(content)
        rejected(tmp_path / "bad.xlsx")
    with zipfile.ZipFile(tmp_path / "bad.xlsx", "w") as archive:
        archive.writestr("a", "b")
    rejected(tmp_path / "bad.xlsx")


def test_blank_rows_and_wide_formats_within_reason_are_read(tmp_path: Path):
    from openpyxl.styles import Font

    def formatted(sheet):
        sheet["A900"], sheet["B900"] = 6000, 8
        for k in range(1, 50):
            sheet.cell(k, 60).font = Font(bold=True)

    found = wo.fit(NIP, book(tmp_path, formatted), {"roll.material.shear": (1e6, 1e8)}, nodes=17,
                   starts=1, profiles=False)  # fmt: skip
    assert found.measured == pytest.approx([4e-3, 5e-3, 6e-3, 7e-3, 8e-3])


def test_formulas_without_values_are_rejected_wherever_they_are(tmp_path: Path):
    def formulas(sheet):
        sheet["A6"], sheet["B6"] = "=A5+1000", "=B5+1"

    assert "row 6, column 1: the formula has no value" in rejected(book(tmp_path, formulas))
