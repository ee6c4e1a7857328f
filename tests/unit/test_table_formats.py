"""Files as instruments and spreadsheets write them: the table is found, or the row is named.

Evidence: small files in the layouts of real ones (test machines, winder logs, LabVIEW, TDMS) with
numbers that are known; personal details are replaced.
"""

from __future__ import annotations

import csv
import io
import sys
from pathlib import Path

import numpy as np
import pytest

import woundon as wo
from woundon.cli.commands import main
from woundon.errors import InputWarning, InvalidProblem
from woundon.io import instruments
from woundon.io.case_texts import template
from woundon.io.columns import read_columns
from woundon.io.sheets import TableFile, find_table, read_sheet
from woundon.io.tables import Names, is_known_header
from woundon.io.words import names_of_word
from woundon.problems.radial_laws import StackTest
from woundon.quantities import quantity_of
from woundon.studies.column_names import columns_of, measurable_outputs
from woundon.studies.measured_tables import read_measured

NIP = wo.NipProblem.example()
STACK = {name: quantity_of(field) for name, field in StackTest.model_fields.items()}
IS_KNOWN = is_known_header(Names(STACK))


def read(path, columns=None):
    return read_measured(path, columns_of(NIP), measurable_outputs(NIP), columns)


def text_file(folder: Path, text: str, name: str = "rig.csv") -> Path:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def faults(call, *arguments) -> str:
    with pytest.raises(InvalidProblem) as refusal:
        call(*arguments)
    text = str(refusal.value)
    assert len(text.splitlines()) <= 10
    return text


# ---- text: where the table is -------------------------------------------------------------------

# The layout of the CSV export of a test machine: results, then the raw data with a row of units.
BLUEHILL = """\
"Results Table 1"
"","Maximum load","Stress at maximum load"
"","(kN)","(MPa)"
"1","5.021","0.5021"

"Specimen label","A-1"
"Operator","N. N."

"Time","Extension","Compressive stress","Compressive strain"
"(s)","(mm)","(kPa)","(mm/mm)"
"0.00","0.000","10.0","0.009"
"0.10","0.020","25.0","0.016"
"0.20","0.051","50.0","0.022"
"0.30","0.102","90.0","0.029"
"""


def test_the_raw_data_below_a_results_block_are_read(tmp_path: Path):
    with pytest.warns(InputWarning, match="rows 4 to 4 above the header in row 9 are not read"):
        sheet = read_sheet(text_file(tmp_path, BLUEHILL), "csv", IS_KNOWN)
    assert sheet.header == 9
    assert list(sheet.numbers) == [11, 12, 13, 14]
    assert sheet.units["Compressive strain"] == "mm/mm"
    assert sheet.columns["Compressive stress"] == ["10.0", "25.0", "50.0", "90.0"]


def test_a_header_is_found_without_a_known_name():
    text = b"Test 12\nOperator;N. N.\nPeak;81,2\n\nAlpha;Beta\n1,5;2\n2,5;3\n3,5;4\n"
    assert find_table(TableFile("rig.csv", text), "table").header == 5


def test_a_row_with_most_known_units_is_one_of_units(tmp_path: Path):
    """An unknown unit matters only in a column that is used: C is no unit."""
    text = "half_width;wound_on_tension;note\nmm;N/m;C\n4;650;20\n5;700;21\n"
    data = read(text_file(tmp_path, text), {"note": None})
    assert data.outputs["wound_on_tension"].tolist() == [650.0, 700.0]
    message = faults(read, text_file(tmp_path, text), {"note": "web_tension"})
    assert "'C'" in message


def test_a_row_without_numbers_that_are_no_units_is_data(tmp_path: Path):
    """An empty cell of a table of cases stands for the value of the case; the row is not lost."""
    table = text_file(tmp_path, "nr;nip_load [kN/m]\nbase;\nb;2,5\n")
    columns = {"nr": None}
    solved = wo.solve_table(table, NIP, ["wound_on_tension"], columns=columns, nodes=13, workers=1)
    assert list(solved["nr"]) == ["base", "b"]


def test_two_tables_of_one_file_are_rejected_by_their_rows(tmp_path: Path):
    table = "nip_load [kN/m];WOT [N/m]\n1,9;650\n2,5;700\n"
    message = faults(read, text_file(tmp_path, table + "\n" + table))
    assert "rows 1 and 5 have the same headers; save each table as a file" in message


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("1,2\n3,4\n", "numbers in row 1, but no header above them; write one"),
        ("nip_load [kN/m],WOT [N/m]\n1,9,650\n", "row 2 has 3 cells, the header in row 1 has 2; "),
        ("nip_load [kN/m];WOT [N/m]\n1,9\n", "the header in row 1 has 2; delete"),
        ("alpha;beta\n1;2\n3;4\n", "row 1 is taken for the header; if another row is, delete"),
        ("\n".join(f"c{k};d{k}" for k in range(40)), "row 1 is taken for the header"),
        (";".join(f"c{k}" for k in range(40)) + "\n" + ";".join("1" * 40), "34 more errors"),
    ],
)  # fmt: skip
def test_a_table_that_is_not_found_is_rejected_with_its_row_and_a_remedy(tmp_path, text, words):
    assert words in faults(read, text_file(tmp_path, text))


# ---- languages ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("header", "row", "values"),
    [
        ("Bahnzug;Durchmesser;Linienlast\nN/m;mm;kN/m", "350,5;800;2,5", (350.5, 0.4, 2500.0)),
        ("Bahnzugkraft [N/m];Rollendurchmesser [m];Linienkraft [kN/m]", "350,5;0,8;2,5",
         (350.5, 0.4, 2500.0)),
        ("Rataveto (N/m);Halkaisija (mm);Viivakuorma (kN/m)", "350,5;800;2,5",
         (350.5, 0.4, 2500.0)),
        ("Tension de la bande (N/m);Diamètre (mm);Charge linéique (kN/m)", "350,5;800;2,5",
         (350.5, 0.4, 2500.0)),
    ],
)  # fmt: skip
def test_headers_of_mills_in_four_languages(tmp_path: Path, header, row, values):
    names = Names({**columns_of(NIP), **measurable_outputs(NIP)})
    path = text_file(tmp_path, f"{header};WOT\n{row};650\n".replace(";WOT", ";WOT [N/m]", 1))
    if "\n" in header:  # units in a row of their own
        path = text_file(tmp_path, f"{header.replace(chr(10), ';WOT' + chr(10))};N/m\n{row};650\n")
    data = read(path)
    tension, radius, load = values
    assert data.inputs["web_tension"].tolist() == [tension]
    assert data.inputs["roll.diameter"].tolist() == pytest.approx([2 * radius])
    assert data.inputs["nip_load"].tolist() == [load]
    assert names.find("Kraft") == []  # of a nip it may be any force


@pytest.mark.parametrize(
    "header",
    ["Stress [MPa];Strain [mm/mm]", "Druckspannung [MPa];Stauchung [-]",
     "Puristusjännitys [MPa];Puristuma [1]", "Contrainte [MPa];Déformation [mm/mm]"],
)  # fmt: skip
def test_headers_of_stack_tests_in_four_languages(tmp_path: Path, header: str):
    rows = "0,01;0,009\n0,025;0,016\n0,05;0,022\n0,1;0,03\n"
    columns = read_columns(text_file(tmp_path, f"{header}\n{rows}"), STACK)
    assert columns["pressure"][0] == "0.01 MPa"
    test = StackTest(**columns)
    assert test.pressure == pytest.approx((10e3, 25e3, 50e3, 100e3))
    assert test.strain == pytest.approx((0.009, 0.016, 0.022, 0.03))


def test_a_word_that_may_mean_several_quantities_is_assigned_by_the_user(tmp_path: Path):
    assert names_of_word("Tension", ["web_tension", "wound_on_tension"]) == []
    path = text_file(tmp_path, "Tension [N/m];WOT [N/m]\n350;650\n")
    assert "--column 'Tension [N/m]=NAME [UNIT]'" in faults(read, path)
    data = read(path, {"Tension": "web_tension"})
    assert data.inputs["web_tension"].tolist() == [350.0]


# ---- Excel --------------------------------------------------------------------------------------


def test_a_sheet_is_named_behind_the_file(tmp_path: Path):
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    book.active.title = "Results"
    book.active.append(["Peak", 12.5])
    raw = book.create_sheet("Raw data")
    for row in (["nip_load [kN/m]", "WOT [N/m]"], [1.9, 650], [2.5, 700]):
        raw.append(row)
    path = tmp_path / "rig.xlsx"
    book.save(path)
    assert read(f"{path}#raw data").inputs["nip_load"].tolist() == [1900.0, 2500.0]
    assert find_table(path, "rig", sheet="Raw data").header == 1
    message = faults(read, path)
    assert f"{path}#Results" in message
    assert f"other sheets are {path}#Raw data" in message
    assert "its sheets are 'Results' and 'Raw data'" in faults(read, f"{path}#Nope")


def test_a_cell_in_minutes_that_was_meant_as_millimetres_is_rejected(tmp_path: Path):
    """The format `0 mm` without quotes is one of a date, and the cell becomes one."""
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    for row in (["half_width [mm]", "WOT [N/m]"], [4, 650]):
        book.active.append(row)
    book.active["A2"].number_format = "0 mm"
    book.save(tmp_path / "rig.xlsx")
    message = faults(read, tmp_path / "rig.xlsx")
    assert "row 2, column 'half_width [mm]': 1900-01-04 00:00:00 is a date, not a number" in message
    assert 'write 0 "mm"' in message
    book.active["A2"].number_format = '0 "mm"'
    book.save(tmp_path / "rig.xlsx")
    assert read(tmp_path / "rig.xlsx").outputs["half_width"].tolist() == [4e-3]


# ---- LabVIEW ------------------------------------------------------------------------------------


def lvm(x_columns: str = "One", decimal: str = ".", segments: int = 1) -> str:
    """Return a measurement file of LabVIEW with two channels, in the layout of its express VI."""
    one = x_columns == "One"
    lines = [
        "LabVIEW Measurement\t", "Writer_Version\t2", "Reader_Version\t2", "Separator\tTab",
        f"Decimal_Separator\t{decimal}", "Multi_Headings\tYes", f"X_Columns\t{x_columns}",
        "Time_Pref\tRelative", "Operator\tN. N.", "Date\t2026/11/02", "Time\t10:00:00",
        "***End_of_Header***\t", "\t",
    ]  # fmt: skip
    for segment in range(segments):
        lines += [
            "Channels\t2\t\t", "Samples\t3\t3\t", "Date\t2026/11/02\t2026/11/02\t",
            "Time\t10:00:00\t10:00:00\t", "Y_Unit_Label\tkN/m\tN/m\t", "X_Dimension\tTime\tTime\t",
            "X0\t0\t0\t", "Delta_X\t0.1\t0.1\t", "***End_of_Header***\t\t\t",
            "X_Value\tnip load\tweb tension\tComment",
        ]  # fmt: skip
        for k in range(3):
            x = f"{0.1 * k:.1f}" if one else ""
            comment = f"\tpass {segment}" if k == 0 else ""
            lines.append(f"{x}\t{1.5 + k + 10 * segment:.3f}\t{350.25 + k:.3f}{comment}")
        lines.append("")
    text = "\r\n".join(lines)
    if decimal == ",":
        body = text.index("***End_of_Header***")
        text = text[:body] + text[body:].replace(".", ",")
    return text


@pytest.mark.parametrize("x_columns", ["One", "No"])
@pytest.mark.parametrize("decimal", [".", ","])
def test_the_channels_of_a_labview_file_are_columns(tmp_path: Path, x_columns, decimal):
    pytest.importorskip("lvmio")
    path = tmp_path / "run.lvm"
    path.write_text(lvm(x_columns, decimal), encoding="utf-8", newline="")
    sheet = find_table(path, "run")
    assert list(sheet.columns) == ["time", "nip load", "web tension"]  # and no comments
    assert sheet.columns["nip load"].tolist() == [1.5, 2.5, 3.5]
    assert sheet.columns["web tension"].tolist() == [350.25, 351.25, 352.25]
    assert sheet.columns["time"] == pytest.approx([0.0, 0.1, 0.2])
    assert sheet.units == {"nip load": "kN/m", "web tension": "N/m", "time": "s"}


def test_a_segment_of_a_labview_file_is_chosen_by_its_number(tmp_path: Path):
    pytest.importorskip("lvmio")
    path = tmp_path / "run.lvm"
    path.write_text(lvm(segments=2), encoding="utf-8", newline="")
    message = faults(find_table, path, "run")
    assert f"has 2 segments, each a table; name one of {path}#1 and {path}#2" in message
    assert find_table(f"{path}#2", "run").columns["nip load"].tolist() == [11.5, 12.5, 13.5]


def test_all_segments_of_a_labview_file_are_read_one_after_the_other(tmp_path: Path):
    """A recording that was interrupted, as by the stops of a winder, has several segments."""
    pytest.importorskip("lvmio")
    path = tmp_path / "run.lvm"
    path.write_text(lvm(segments=2), encoding="utf-8", newline="")
    sheet = find_table(f"{path}#all", "run")
    assert sheet.columns["nip load"].tolist() == [1.5, 2.5, 3.5, 11.5, 12.5, 13.5]
    assert sheet.remarks == ("2 segments are read one after the other, without their times",)
    other = lvm(segments=1).replace("nip load", "torque")
    path.write_text(lvm() + other[other.index("Channels") :], encoding="utf-8", newline="")
    assert "has tables with different channels" in faults(find_table, f"{path}#all", "run")


def test_a_damaged_labview_file_is_rejected_by_its_line(tmp_path: Path):
    pytest.importorskip("lvmio")
    path = tmp_path / "run.lvm"
    path.write_text(lvm().replace("351.250", "35x"), encoding="utf-8", newline="")
    assert "line 25" in faults(find_table, path, "run")


# ---- TDMS ---------------------------------------------------------------------------------------


def tdms(folder: Path, channels: dict[str, tuple[np.ndarray, dict]], cut: int = 0) -> Path:
    nptdms = pytest.importorskip("nptdms")
    content = io.BytesIO()
    with nptdms.TdmsWriter(content) as writer:
        writer.write_segment(
            [nptdms.ChannelObject(*name.split("/"), *each) for name, each in channels.items()]
        )
    path = folder / "run.tdms"
    path.write_bytes(content.getvalue()[: len(content.getvalue()) - cut])
    return path


def rate(period: float, unit: str, **others) -> dict:
    return {"wf_increment": period, "wf_start_offset": 0.0, "unit_string": unit, **others}


def test_channels_of_one_rate_are_one_table(tmp_path: Path):
    path = tdms(
        tmp_path,
        {"rig/nip load": (np.array([1.5, 2.5]), rate(0.5, "kN/m")),
         "rig/WOT": (np.array([650.0, 700.0]), rate(0.5, "N/m"))},
    )  # fmt: skip
    data = read(path)
    assert data.inputs["nip_load"].tolist() == [1500.0, 2500.0]
    assert data.outputs["wound_on_tension"].tolist() == [650.0, 700.0]


def test_raw_samples_are_scaled_by_the_properties_of_the_file(tmp_path: Path):
    scale = {
        "NI_Number_Of_Scales": 1, "NI_Scale[0]_Scale_Type": "Linear",
        "NI_Scaling_Status": "unscaled",
        "NI_Scale[0]_Linear_Slope": 0.5, "NI_Scale[0]_Linear_Y_Intercept": 1.0,
        "NI_Scale[0]_Linear_Input_Source": 0xFFFFFFFF,
    }  # fmt: skip
    path = tdms(tmp_path, {"rig/Force": (np.arange(3, dtype=np.int16), rate(0.1, "kN", **scale))})
    assert find_table(path, "run").columns["Force"].tolist() == [1.0, 1.5, 2.0]


def test_channels_of_two_rates_are_joined_by_time_and_never_by_number(tmp_path: Path):
    """The fast channel starts 0.3 s later: its sample k belongs to the instant 0.3 + 0.1 k."""
    start = np.datetime64("2026-11-02T10:00:00.000000")
    later = start + np.timedelta64(300_000, "us")
    slow = np.arange(6.0)  # the instant 0.5 k is k
    fast = 0.3 + 0.1 * np.arange(20)  # its values are its instants, 0.3 to 2.2
    path = tdms(
        tmp_path,
        {"rig/Weg": (slow, rate(0.5, "mm", wf_start_time=start)),
         "rig/Kraft": (fast, rate(0.1, "N", wf_start_time=later)),
         "rig/Temperature": (np.arange(3.0), rate(60.0, "degC", wf_start_time=start))},
    )  # fmt: skip
    sheet = find_table(path, "run", lambda header: "Temperature" not in header)
    assert sheet.columns["time"] == pytest.approx([0.5, 1.0, 1.5, 2.0])
    assert sheet.columns["Kraft"] == pytest.approx([0.5, 1.0, 1.5, 2.0])
    assert sheet.columns["Weg"].tolist() == [1.0, 2.0, 3.0, 4.0]
    joined, instants, left_out = sheet.remarks
    assert joined == (
        "joined by time to 'Weg', one sample each 0.5 s: 'Kraft', one sample each 0.1 s"
    )
    assert left_out == "channels without a known name are not read: Temperature"
    assert instants == "2 instants left out, at which a channel has no sample"


START = np.datetime64("2026-11-02T10:00:00.000000")
NEVER = np.datetime64("1904-01-01T00:00:00.000000")  # what LabVIEW writes without a start


@pytest.mark.parametrize("no_start", [{}, {"wf_start_time": NEVER}])
def test_a_channel_without_a_start_is_joined_by_number_to_one_of_its_rate(tmp_path, no_start):
    """A start of 1970 in place of none would be 56 years before the other: no common instant."""
    path = tdms(
        tmp_path,
        {"rig/Weg": (np.arange(4.0), rate(0.5, "mm", **no_start)),
         "rig/Kraft": (np.arange(4.0) + 7, rate(0.5, "N", wf_start_time=START))},
    )  # fmt: skip
    sheet = find_table(path, "run")
    assert sheet.columns["Weg"].tolist() == [0.0, 1.0, 2.0, 3.0]
    assert sheet.columns["Kraft"].tolist() == [7.0, 8.0, 9.0, 10.0]
    assert sheet.columns["time"] == pytest.approx([0.0, 0.5, 1.0, 1.5])
    assert sheet.remarks == (
        "the file does not state the start of 'Weg'; joined to 'Kraft' by the number of the sample",
    )


@pytest.mark.parametrize(("size", "period"), [(5, 0.5), (4, 0.25)])
def test_a_channel_without_a_start_and_of_another_rate_is_rejected(tmp_path, size, period):
    path = tdms(
        tmp_path,
        {"rig/Weg": (np.arange(float(size)), rate(period, "mm")),
         "rig/Kraft": (np.arange(4.0), rate(0.5, "N", wf_start_time=START))},
    )  # fmt: skip
    message = faults(find_table, path, "run")
    assert "does not state when the channel 'Weg' starts, so that it cannot be joined" in message
    assert "'Kraft' has 4 samples, one each 0.5 s" in message
    assert f"'Weg' has {size} samples, one each {period:g} s" in message


def test_channels_that_all_have_no_start_begin_together(tmp_path: Path):
    path = tdms(
        tmp_path,
        {"rig/Weg": (np.arange(3.0), rate(0.5, "mm")),
         "rig/Kraft": (np.arange(11.0), rate(0.1, "N") | {"wf_start_offset": 0.1})},
    )  # fmt: skip
    sheet = find_table(path, "run")
    assert sheet.columns["time"] == pytest.approx([0.5, 1.0])
    assert sheet.columns["Kraft"].tolist() == [4.0, 9.0]


def test_channels_without_a_common_instant_are_rejected(tmp_path: Path):
    later = START + np.timedelta64(3600, "s")
    path = tdms(
        tmp_path,
        {"rig/Weg": (np.arange(3.0), rate(0.5, "mm", wf_start_time=START)),
         "rig/Kraft": (np.arange(9.0), rate(0.1, "N", wf_start_time=later))},
    )  # fmt: skip
    message = faults(find_table, path, "run")
    assert "at no instant of 'Weg', 0 s to 1 s, does every channel have a sample" in message


def test_a_channel_without_a_known_name_is_named_and_not_read(tmp_path: Path):
    path = tdms(
        tmp_path,
        {"rig/nip load": (np.array([1.5, 2.5]), rate(0.5, "kN/m")),
         "rig/WOT": (np.array([650.0, 700.0]), rate(0.5, "N/m")),
         "rig/Door 3": (np.array([0.0, 1.0]), rate(0.5, ""))},
    )  # fmt: skip
    with pytest.warns(InputWarning, match="channels without a known name are not read: Door 3"):
        assert list(read(path).inputs) == ["nip_load"]


def test_channels_without_times_are_not_joined_by_number(tmp_path: Path):
    path = tdms(
        tmp_path, {"rig/Weg": (np.arange(3.0), {}), "rig/Kraft": (np.arange(4.0), rate(0.1, "N"))}
    )
    message = faults(find_table, path, "run")
    assert "the channel 'Weg' has no times, so that it cannot be joined to others" in message


def test_a_group_is_chosen_by_its_name(tmp_path: Path):
    each = (np.arange(3.0), rate(0.1, "N"))
    path = tdms(tmp_path, {"loading/Kraft": each, "unloading/Kraft": each})
    message = faults(find_table, path, "run")
    assert f"name one of {path}#loading and {path}#unloading" in message
    assert find_table(f"{path}#unloading", "run").columns["Kraft"].tolist() == [0.0, 1.0, 2.0]


@pytest.mark.parametrize(
    ("cut", "words"),
    [(40, "ends in the middle of a segment"), (4100, "has no channel with numbers")],
)
def test_a_tdms_file_that_ends_early_is_rejected(tmp_path: Path, cut: int, words: str):
    """The package that reads it returns the samples that are there, with a message in a log."""
    path = tdms(tmp_path, {"rig/Kraft": (np.arange(500.0), rate(0.1, "N"))}, cut=cut)
    message = faults(find_table, path, "run")
    assert words in message
    assert "copy the file again" in message


def test_the_samples_of_a_tdms_file_are_counted_before_they_are_read(tmp_path, monkeypatch):
    path = tdms(tmp_path, {"rig/Kraft": (np.arange(500.0), rate(0.1, "N"))})
    monkeypatch.setattr(instruments, "MAX_SAMPLES", 499)
    monkeypatch.setattr(instruments, "_tdms_channel", None)  # is not called
    assert "has more than 499 samples" in faults(find_table, path, "run")


@pytest.mark.parametrize("content", [b"", b"TDSm" + bytes(200), b"\x00" * 50, b"TDSm\xff" * 99])
def test_a_file_that_is_none_of_an_instrument_is_rejected(tmp_path: Path, content: bytes):
    for name in ("run.tdms", "run.lvm"):
        (tmp_path / name).write_bytes(content)
        assert faults(find_table, tmp_path / name, "run")


@pytest.mark.parametrize(("name", "package"), [("run.lvm", "lvmio"), ("run.tdms", "nptdms")])
def test_a_missing_reader_is_named(tmp_path: Path, monkeypatch, name: str, package: str):
    monkeypatch.setitem(sys.modules, package, None)
    message = faults(find_table, tmp_path / name, "run")
    assert f"files need {package}: pip install 'woundon[instruments]'" in message


def test_an_mdf_file_is_rejected_with_the_remedy(tmp_path: Path):
    path = tmp_path / "run.mf4"
    path.write_bytes(b"MDF     4.10    " + bytes(100))
    assert "export them as .tdms or .csv with one time base" in faults(find_table, path, "run")


def test_text_that_begins_with_mdf_is_text(tmp_path: Path):
    path = tmp_path / "board.csv"
    path.write_text("MDF [kN/m];NIP [kN/m]\n1;2\n", encoding="utf-8")
    assert find_table(path, "board").header == 1


@pytest.mark.parametrize(
    "beginning",
    [
        b"\x89HDF\r\n\x1a\n",  # HDF5, also of MATLAB and netCDF: text in Windows-1252
        b"MATLAB 7.3 MAT-file".ljust(512),  # HDF5 after 512 bytes of text
        b"MATLAB 5.0 MAT-file".ljust(124),
        b"CDF\x01",
        b"SQLite format 3",
    ],
)
def test_a_binary_file_is_rejected_with_the_remedy(tmp_path: Path, beginning: bytes):
    path = tmp_path / "log.csv"
    path.write_bytes(beginning + bytes(100))
    assert "is not a text file; save it as .xlsx or .csv" in faults(find_table, path, "log")


# ---- CSV files for spreadsheets with decimal commas ---------------------------------------------


def test_every_csv_file_may_have_decimal_commas(tmp_path: Path, monkeypatch):
    """Read back by the tables of this package: the numbers are those with decimal points."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "roll.toml").write_text(template("roll"), encoding="utf-8")
    (tmp_path / "rollers.toml").write_text(template("rollers"), encoding="utf-8")
    (tmp_path / "cases.csv").write_text("load [kN/m]\n89.5\n", encoding="utf-8")
    commands = {
        "solved.csv": ["solve", "rollers.toml", "--nodes", "33", "--save", "solved.csv"],
        "table.csv": ["table", "cases.csv", "--case", "rollers.toml", "-o", "table.csv"],
        "schedule.csv": ["schedule", "roll.toml", "--pressure", "200 kPa", "--out", "schedule.csv"],
    }
    for name, arguments in commands.items():
        assert main(arguments) == 0
        points = (tmp_path / name).read_text(encoding="utf-8")
        assert main([*arguments, "--decimal-comma"]) == 0
        commas = (tmp_path / name).read_text(encoding="utf-8")
        rows = list(csv.reader(io.StringIO(points)))
        others = list(csv.reader(io.StringIO(commas), delimiter=";"))
        assert len(rows) == len(others)
        numbers = 0
        for cell, other in zip(sum(rows, []), sum(others, []), strict=True):  # noqa: RUF017
            if other != cell:
                assert float(other.replace(",", ".")) == float(cell)
                numbers += "." in cell
        assert numbers > 0
    data = find_table("table.csv", "cases").columns["load [kN/m]"]
    assert data == ["89,5"]
    with wo.decimal_commas():
        wo.solve(wo.RollerProblem.example(), nodes=33).save("result.csv")
    assert ";" in (tmp_path / "result.csv").read_text(encoding="utf-8")
