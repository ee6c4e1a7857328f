"""A study on disk: parts, manifest, queries, exports."""

from __future__ import annotations

import csv
import json
import os
import signal
import threading
import time
from pathlib import Path

import duckdb
import numpy as np
import pytest
import toys
import xarray
from thesis_cases import paper_nip

import woundon as wo
from woundon.studies.design import make_design
from woundon.studies.engine import run_study
from woundon.studies.export import export
from woundon.studies.runners import Here
from woundon.studies.store import write_parquet
from woundon.studies.table import failures

DESIGN = make_design({"a": range(4), "b": [0.5, 1.5]})


class Other(toys.Toy):
    """Has the record of a Toy, and answers otherwise."""

    def value(self, inputs):
        return -1.0

    def record(self):
        return toys.Toy().record()


def _part(out: Path, number: int) -> Path:
    (path,) = (out / "parts").glob(f"{number:06d}-*.parquet")
    return path


@pytest.fixture(scope="module")
def table():
    """Six cases, three of which have no steady state: |F| >= 0.4 P."""
    over = {"nip_load": [1000.0, 2000.0], "winding_force": [0.0, 450.0, 900.0]}
    outputs = ("nip_induced_tension", "half_width")
    return toys.table_of(paper_nip(), over, outputs, options={"nodes": 17})


def test_resume_solves_only_what_is_missing(tmp_path: Path):
    out, solved = tmp_path / "out", []
    first = run_study(toys.Toy(), DESIGN, Here(), out=out, chunk=3)
    _part(out, 1).unlink()
    again = run_study(
        toys.Toy(), DESIGN, Here(), out=out, chunk=3, resume=True,
        progress=lambda done, size: solved.append((done, size)),
    )  # fmt: skip
    assert solved == [(8, 8)]  # 5 of 8 cases were there
    assert np.array_equal(first.outputs["y"], again.outputs["y"])


@pytest.mark.skipif(os.name == "nt", reason="names that Windows does not admit")
@pytest.mark.parametrize("name", ["x[1]", "*", "?1", "[!a]1", "x{1,2}", "it's", 'a "b"', "a\\b"])
def test_a_folder_s_name_is_no_pattern(tmp_path: Path, name: str):
    """Beside it lie folders that it would match, with another study of the same cases."""
    for other in ("x1", "x2"):
        run_study(Other(), DESIGN, Here(), out=tmp_path / other)
    first = run_study(toys.Toy(), DESIGN, Here(), out=tmp_path / name)
    # solves nothing: what it answers would be seen
    again = run_study(Other(), DESIGN, Here(), out=tmp_path / name, resume=True)
    assert np.array_equal(first.outputs["y"], again.outputs["y"])


def _damaged(out: Path, damage: str) -> None:
    first, second = _part(out, 0), _part(out, 1)
    content = first.read_bytes()
    if damage == "empty":
        first.write_bytes(b"")
    elif damage == "cut":
        first.write_bytes(content[:-20])
    elif damage == "a bit":
        first.write_bytes(bytes([content[0] ^ 1]) + content[1:])
    elif damage == "exchanged":
        first.write_bytes(second.read_bytes())
        second.write_bytes(content)
    elif damage == "renumbered":
        first.rename(first.with_name(first.name.replace("000000", "000001")))
    elif damage == "foreign":
        run_study(Other(), DESIGN, Here(), out=out.with_name("other"), chunk=3)
        first.write_bytes(_part(out.with_name("other"), 0).read_bytes())
    elif damage == "no file":
        first.unlink()
        first.mkdir()


@pytest.mark.parametrize(
    "damage", ["empty", "cut", "a bit", "exchanged", "renumbered", "foreign", "no file"]
)
def test_damaged_parts_are_set_aside_told_and_solved_again(tmp_path: Path, damage: str):
    out = tmp_path / "out"
    first = run_study(toys.Toy(), DESIGN, Here(), out=out, chunk=3)
    name = _part(out, 0).name
    _damaged(out, damage)
    with pytest.warns(UserWarning, match="damaged or of another study, moved to set_aside") as told:
        again = run_study(toys.Toy(), DESIGN, Here(), out=out, chunk=3, resume=True)
    assert again.failed.size == 0
    assert np.array_equal(first.outputs["y"], again.outputs["y"])
    assert _part(out, 0).name == name
    aside = sorted(path.name.partition("-")[2] for path in (out / "set_aside").iterdir())
    assert all(part in str(told[0].message) for part in aside)
    run_study(Other(), DESIGN, Here(), out=out, chunk=3, resume=True)  # repaired: nothing is told


@pytest.mark.parametrize("content", [None, b"", b"{}", b"[" * 100_000, b"\xff", b"9" * 5000])
def test_a_damaged_manifest_is_made_again_where_parts_are_of_this_study(tmp_path: Path, content):
    out = tmp_path / "out"
    run_study(toys.Toy(), DESIGN, Here(), out=out)
    manifest = out / "manifest.json"
    whole = manifest.read_bytes()
    manifest.unlink()
    if content is None:
        run_study(Other(), DESIGN, Here(), out=out, resume=True)
    else:
        manifest.write_bytes(content)
        with pytest.warns(UserWarning, match=r"moved to set_aside and made again: manifest\.json"):
            run_study(Other(), DESIGN, Here(), out=out, resume=True)
    assert manifest.read_bytes() == whole


def test_an_edited_manifest_does_not_open_a_study_to_another_one(tmp_path: Path):
    """Its hash kept, its design that of the study that is resumed: the parts are of the old one."""
    out, design = tmp_path / "out", make_design({"a": range(4), "b": [0.5, 2.5]})
    run_study(toys.Toy(), DESIGN, Here(), out=out)
    manifest = out / "manifest.json"
    told = json.loads(manifest.read_text("utf-8"))
    manifest.write_text(json.dumps(told | {"design": design.record()}), encoding="utf-8")
    with pytest.raises(wo.InvalidProblem, match="damaged, and none of its parts is of this study"):
        run_study(toys.Toy(), design, Here(), out=out, resume=True)


def test_a_part_is_on_disk_before_it_has_its_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    happened = []
    fsync, replace = os.fsync, os.replace

    def synced(descriptor: int) -> None:
        happened.append(("on disk", os.fstat(descriptor).st_ino))
        fsync(descriptor)

    def moved(one: Path, other: Path) -> None:
        happened.append((Path(other).name, os.stat(one).st_ino))
        replace(one, other)

    monkeypatch.setattr(os, "fsync", synced)
    monkeypatch.setattr(os, "replace", moved)
    run_study(toys.Toy(), DESIGN, Here(), out=tmp_path, chunk=3)
    for number in range(3):
        part = _part(tmp_path, number)
        place = happened.index((part.name, part.stat().st_ino))
        assert happened[place - 1] == ("on disk", part.stat().st_ino)
        if os.name == "posix":
            assert happened[place + 1] == ("on disk", part.parent.stat().st_ino)


@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
def test_ctrl_c_while_a_part_is_written(tmp_path: Path):
    """DuckDB answers it by an error of its own."""
    rows = {name: np.random.default_rng(1).random(3_000_000) for name in "ab"}
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    press = threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGINT))

    def write(connection: duckdb.DuckDBPyConnection) -> None:
        limit = time.monotonic() + 60
        press.start()
        while time.monotonic() < limit:
            write_parquet(connection, rows, tmp_path / "part")

    try:
        with duckdb.connect() as connection, pytest.raises(KeyboardInterrupt):
            write(connection)
    finally:
        press.join()
        signal.signal(signal.SIGINT, before)


def test_resume_without_a_folder_is_refused():
    with pytest.raises(wo.InvalidProblem, match="resume: needs out, the folder of the study"):
        run_study(toys.Toy(), DESIGN, Here(), resume=True)


def test_parts_left_half_written_are_cleared_away(tmp_path: Path):
    out = tmp_path / "out"
    run_study(toys.Toy(), DESIGN, Here(), out=out)
    leftover = out / "parts" / ".000000.parquet.99.part"
    leftover.write_bytes(b"half")
    run_study(toys.Toy(), DESIGN, Here(), out=out, resume=True)
    assert not leftover.exists()


def test_failures_are_kept_over_a_resume(tmp_path: Path):
    design = make_design({"a": range(5)})
    run_study(toys.Faulty(), design, Here(), out=tmp_path / "out")
    again = run_study(toys.Faulty(), design, Here(), out=tmp_path / "out", resume=True)
    assert again.failure[3] == "ZeroDivisionError: a is 3"
    assert np.isnan(again.outputs["y"][3])


@pytest.mark.parametrize(
    ("over", "changes", "options", "differs"),
    [
        ({"nip_load": [1e3, 2e3]}, {}, {"nodes": 17}, "design differs"),
        ({"nip_load": [1e3]}, {"roll_friction": 0.3}, {"nodes": 17}, "problem differs"),
        ({"nip_load": [1e3]}, {}, {"nodes": 25}, "options differs"),
        ({"nip_load": [1e3]}, {}, {"nodes": 17, "chunk": 5}, "chunk differs"),
        ({"nip_load": [1e3]}, {}, {"nodes": 17, "outputs": ("half_width",)}, "outputs differs"),
    ],
)
def test_the_manifest_guards_the_study(tmp_path: Path, over, changes, options, differs):
    wo.sweep(paper_nip(), {"nip_load": [1e3]}, nodes=17, workers=1, out=tmp_path)
    with pytest.raises(wo.InvalidProblem, match=f"holds another study than this: {differs}"):
        wo.sweep(paper_nip(**changes), over, workers=1, out=tmp_path, resume=True, **options)


def test_folders_that_hold_something_else_are_left_alone(tmp_path: Path):
    (tmp_path / "thesis.txt").write_text("mine", encoding="utf-8")
    with pytest.raises(wo.InvalidProblem, match="is not empty and holds no study"):
        run_study(toys.Toy(), DESIGN, Here(), out=tmp_path, resume=True)
    (tmp_path / "manifest.json").write_text("{}", encoding="utf-8")
    with pytest.raises(wo.InvalidProblem, match=r"its manifest\.json is damaged, and none of its"):
        run_study(toys.Toy(), DESIGN, Here(), out=tmp_path, resume=True)


def test_a_study_is_not_overwritten(tmp_path: Path):
    run_study(toys.Toy(), DESIGN, Here(), out=tmp_path)
    with pytest.raises(wo.InvalidProblem, match="holds a study already; resume it"):
        run_study(toys.Toy(), DESIGN, Here(), out=tmp_path)


def test_parts_can_be_queried(tmp_path: Path, table):
    over = {"nip_load": [1000.0, 2000.0], "winding_force": [0.0, 450.0, 900.0]}
    outputs = ("nip_induced_tension",)
    wo.sweep(paper_nip(), over, outputs, nodes=17, workers=1, out=tmp_path, chunk=2)
    with duckdb.connect() as connection:
        found = connection.execute(
            f"SELECT max(nip_induced_tension) FROM '{tmp_path}/parts/*.parquet' "
            "WHERE failure = '' AND nip_load = 2000"
        ).fetchone()
        failed = connection.execute(
            f"SELECT count(*) FROM '{tmp_path}/parts/*.parquet' WHERE failure LIKE 'NoSteady%'"
        ).fetchone()
    own = toys.table_of(paper_nip(), over, outputs, options={"nodes": 17}).outputs
    expected = np.nanmax(own["nip_induced_tension"][3:])
    # the chunks differ, so that other neighbours are the starts
    assert found[0] == pytest.approx(expected, rel=1e-8)
    assert failed[0] == table.failed.size == 3


def test_netcdf_comes_back_as_it_was(tmp_path: Path, table):
    export(table, tmp_path / "study.nc")
    with xarray.open_dataset(tmp_path / "study.nc", engine="scipy") as read:
        kept = table.to_dataset()
        assert np.array_equal(
            read.nip_induced_tension.values, kept.nip_induced_tension.values, equal_nan=True
        )
        assert read.half_width.attrs == kept.half_width.attrs
        assert read.attrs == kept.attrs
        assert [str(v) for v in read.failure.values.ravel()] == list(table.failure)


def test_csv_has_units_in_its_header_and_every_digit(tmp_path: Path, table):
    export(table, tmp_path / "study.csv")
    with (tmp_path / "study.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0]) == [
        "case", "nip_load [N/m]", "winding_force [N/m]", "nip_induced_tension [N/m]",
        "half_width [m]", "failure", "warnings",
    ]  # fmt: skip
    read = [float(row["half_width [m]"]) for row in rows]
    assert np.array_equal(read, table.outputs["half_width"], equal_nan=True)
    assert rows[1]["failure"].startswith("NoSteadyState")


def test_excel_has_the_rows_and_says_what_they_hang_on(tmp_path: Path, table):
    openpyxl = pytest.importorskip("openpyxl")
    export(table, tmp_path / "study.xlsx")
    book = openpyxl.load_workbook(tmp_path / "study.xlsx")
    rows = list(book["study"].iter_rows(values_only=True))
    assert rows[0][1] == "nip_load [N/m]"
    # Excel keeps 15 digits
    assert rows[1][4] == pytest.approx(table.outputs["half_width"][0], rel=1e-14)
    assert rows[2][4] is None  # a failed case
    about = dict(book["about"].iter_rows(values_only=True))
    assert about["version"] == wo.__version__
    assert json.loads(about["options"]) == {"nodes": 17}


def test_parquet_holds_the_same(tmp_path: Path, table):
    export(table, tmp_path / "study.parquet")
    with duckdb.connect() as connection:
        found = connection.execute(
            f"SELECT half_width FROM '{tmp_path}/study.parquet' ORDER BY \"case\""
        ).fetchnumpy()["half_width"]
    assert np.array_equal(np.ma.filled(found, np.nan), table.outputs["half_width"], equal_nan=True)


def test_other_endings_are_refused(tmp_path: Path, table):
    with pytest.raises(
        wo.InvalidProblem, match=r"ending '\.txt' is not a known format; must be \.nc"
    ):
        export(table, tmp_path / "study.txt")


def test_failures_are_ranked_without_their_numbers():
    reasons = np.array(["", "F = 3 too large", "F = 4.5e3 too large", "odd"], dtype=object)
    assert failures(reasons) == [("F = 3 too large", 2), ("odd", 1)]
