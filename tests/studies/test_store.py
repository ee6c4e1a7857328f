"""A study on disk: bit-exact numbers, damage, read-only media, two processes, exports."""

from __future__ import annotations

import os
import shutil
import sqlite3
import subprocess
import sys
import threading
from collections.abc import Mapping
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import study_models as models
import xarray
from thesis_cases import paper_nip

import woundon as wo
from woundon.studies import store
from woundon.studies.cases import make_cases
from woundon.studies.export import export
from woundon.studies.run import Table, Workers, run_study

CASES = make_cases({"a": range(4), "b": [0.5, 1.5]})


class Other(models.LinearModel):
    """Has the record of a LinearModel and other values: a case that is solved again shows."""

    def value(self, inputs: Mapping[str, Any]) -> float:
        return -1.0

    def record(self) -> dict[str, Any]:
        return models.LinearModel().record()


class Bits(models.LinearModel):
    """Returns given bits as a float64, and fails at a = 6."""

    BITS = (
        0x7FF8000000000000, 0xFFF8000000000001, 0x8000000000000000, 0x7FF0000000000000,
        0x0000000000000001, 0x3FF0000000000001, 0, 0xFFEFFFFFFFFFFFFF,
    )  # fmt: skip

    def value(self, inputs: Mapping[str, Any]) -> float:
        if inputs["a"] == 6:
            raise ValueError("no µ \ud800 at six,\nin two lines")
        return float(np.uint64(self.BITS[int(inputs["a"])]).view(np.float64))


def run(out: Path, model: models.LinearModel | None = None, **how: Any) -> Table:
    """Run the eight cases of CASES in three chunks."""
    return run_study(model or models.LinearModel(), CASES, Workers(1), out=out, chunk=3, **how)


def change(out: Path, *statements: str) -> None:
    """Change the store by another program."""
    with closing(sqlite3.connect(out / "study.sqlite")) as connection, connection:
        for statement in statements:
            connection.execute(statement)


def chunks(out: Path) -> list[tuple[Any, ...]]:
    with closing(sqlite3.connect(out / "study.sqlite")) as connection:
        return connection.execute("SELECT * FROM chunk ORDER BY number").fetchall()


@pytest.fixture(scope="module")
def table() -> Table:
    """Six cases, three of which have no steady state: |F| >= 0.4 P."""
    over = {"nip_load": [1000.0, 2000.0], "winding_force": [0.0, 450.0, 900.0]}
    outputs = ("nip_induced_tension", "half_width")
    return models.table_of(paper_nip(), over, outputs, options={"nodes": 17})


def test_numbers_and_texts_come_back_to_the_last_bit(tmp_path: Path):
    cases = make_cases({"a": range(8)})
    first = run_study(Bits(), cases, Workers(1), out=tmp_path, chunk=3)
    again = run_study(Bits(), cases, Workers(1), out=tmp_path, chunk=3, resume=True)
    bits = first.outputs["y"].view(np.uint64).tolist()
    assert [*bits[:6], bits[7]] == [*Bits.BITS[:6], Bits.BITS[7]]
    assert first.outputs["y"].tobytes() == again.outputs["y"].tobytes()
    assert first.failure.tolist() == again.failure.tolist()
    assert again.failure[6] == "ValueError: no µ \ud800 at six,; in two lines"


def test_resume_solves_only_what_is_missing(tmp_path: Path):
    solved = []
    first = run(tmp_path)
    change(tmp_path, "DELETE FROM chunk WHERE number = 1")
    again = run(tmp_path, resume=True, progress=lambda done, size: solved.append((done, size)))
    assert solved == [(8, 8)]  # 5 of 8 cases were there
    assert np.array_equal(first.outputs["y"], again.outputs["y"])


@pytest.mark.skipif(os.name == "nt", reason="names that Windows does not admit")
@pytest.mark.parametrize("name", ["x[1]", "*", "?mode=memory", "a#b", "it's", 'a "b"', r"a%20\b"])
def test_a_folder_may_have_any_name(tmp_path: Path, name: str):
    first = run(tmp_path / name)
    assert [path.name for path in (tmp_path / name).iterdir()] == ["study.sqlite"]
    again = run(tmp_path / name, Other(), resume=True)
    assert np.array_equal(first.outputs["y"], again.outputs["y"])


def test_a_store_has_a_rollback_journal_and_a_transaction_a_chunk(tmp_path: Path):
    """A second connection sees every chunk as soon as it is reported; WAL files never exist."""
    seen = []

    def look(done: int, size: int) -> None:
        seen.append((done, len(chunks(tmp_path)), [path.name for path in tmp_path.iterdir()]))

    run(tmp_path, progress=look)
    assert seen == [(3, 1, ["study.sqlite"]), (6, 2, ["study.sqlite"]), (8, 3, ["study.sqlite"])]
    with closing(sqlite3.connect(tmp_path / "study.sqlite")) as connection:
        assert connection.execute("PRAGMA journal_mode").fetchone() == ("delete",)


# ---- damage -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "damage",
    [
        "UPDATE chunk SET outputs = zeroblob(24) WHERE number = 0",
        "UPDATE chunk SET outputs = NULL WHERE number = 0",
        "UPDATE chunk SET outputs = 3 WHERE number = 0",
        """UPDATE chunk SET failure = '["", "x", ""]' WHERE number = 0""",
        "UPDATE chunk SET failure = x'ff' WHERE number = 0",
        "UPDATE chunk SET failure = CAST(x'ff' AS TEXT) WHERE number = 0",
        "UPDATE chunk SET warnings = NULL WHERE number = 0",
        "UPDATE chunk SET sha256 = 'x' WHERE number = 0",
        "UPDATE chunk SET number = 3 WHERE number = 0",
        "DROP TABLE chunk",
        "UPDATE study SET record = x'5b'",
        "UPDATE study SET record = '[]'",
        "DELETE FROM study",
        "DROP TABLE study",
        "INSERT INTO study SELECT * FROM study",
        "CREATE VIEW more AS SELECT number FROM chunk",
        "CREATE INDEX more ON chunk (sha256)",
        "CREATE TABLE more (number INTEGER)",
        "CREATE TRIGGER more AFTER INSERT ON chunk BEGIN DELETE FROM chunk; END",
        "ALTER TABLE chunk ADD COLUMN more TEXT",
        "ALTER TABLE study RENAME COLUMN record TO text",
    ],
)
def test_a_damaged_study_is_rejected_and_left_as_it_is(tmp_path: Path, damage: str):
    run(tmp_path)
    change(tmp_path, damage)
    check_rejected_and_unchanged(tmp_path)


@pytest.mark.parametrize("content", [b"text", b"SQLite format 3\0", b"[" * 100_000, bytes(8192)])
def test_a_file_that_is_no_database_is_rejected_and_left_as_it_is(tmp_path: Path, content: bytes):
    (tmp_path / "study.sqlite").write_bytes(content)
    check_rejected_and_unchanged(tmp_path)


@pytest.mark.parametrize(
    "statements",
    [
        ("CREATE TABLE more (number INTEGER)", "DROP TABLE more"),
        ("CREATE TABLE notes (text TEXT)", "INSERT INTO notes VALUES ('mine')"),
        # a view whose rows have no end
        ("CREATE TABLE chunk (number INTEGER)", "CREATE VIEW study AS WITH RECURSIVE n(record) AS "
         "(SELECT 1 UNION ALL SELECT record + 1 FROM n) SELECT record FROM n"),
    ],
)  # fmt: skip
def test_a_database_of_another_program_is_rejected_and_left_as_it_is(
    tmp_path: Path, statements: tuple[str, ...]
):
    change(tmp_path, *statements)
    check_rejected_and_unchanged(tmp_path)


def test_the_write_ahead_log_of_another_program_is_left_as_it_is(tmp_path: Path):
    """SQLite would write the log into the file, and delete it, when the last connection closes."""
    path, out = tmp_path / "notes.sqlite", tmp_path / "out"
    out.mkdir()
    with closing(sqlite3.connect(path)) as connection:
        connection.execute("PRAGMA journal_mode=WAL")
        connection.execute("CREATE TABLE notes (text TEXT)")
        connection.commit()
        for ending in ("", "-wal"):
            shutil.copy(f"{path}{ending}", out / f"study.sqlite{ending}")
    files = {file.name: file.read_bytes() for file in out.iterdir()}
    with pytest.raises(wo.InvalidProblem, match="it has a write-ahead log, and a study has none"):
        run(out, resume=True)
    assert {file.name: file.read_bytes() for file in out.iterdir()} == files


def check_rejected_and_unchanged(out: Path) -> None:
    """Check that a damaged study is neither resumed nor overwritten, and is the only file."""
    path = out / "study.sqlite"
    content = path.read_bytes()
    says = r"its study\.sqlite is damaged .* is left as it is; solve the study in another folder"
    for resume, match in ((True, says), (False, says + "|contains a study already")):
        with pytest.raises(wo.InvalidProblem, match=match) as fault:
            run(out, resume=resume)
        assert "\\n" not in str(fault.value)  # one line, without escaped line breaks
    assert path.read_bytes() == content
    assert [file.name for file in out.iterdir()] == ["study.sqlite"]


@pytest.mark.parametrize("text", [b"CREATE TABLE study", b"tablestudystudy"])
def test_a_store_with_a_damaged_name_is_rejected_and_left_as_it_is(tmp_path: Path, text: bytes):
    """SQLite quotes the name, which is not UTF-8 any more, in the text of its error."""
    run(tmp_path)
    path = tmp_path / "study.sqlite"
    content = path.read_bytes()
    assert text in content
    path.write_bytes(content.replace(text, text.replace(b"stu", b"\xcb\xcb\xcb")))
    check_rejected_and_unchanged(tmp_path)


def test_a_store_with_a_damaged_page_is_rejected_and_left_as_it_is(tmp_path: Path):
    run(tmp_path)
    path = tmp_path / "study.sqlite"
    content = bytearray(path.read_bytes())
    content[2 * 4096 + 7] ^= 0x7F  # what SQLite's check of the file finds, and states in two lines
    path.write_bytes(content)
    check_rejected_and_unchanged(tmp_path)


@pytest.mark.parametrize("resume", [False, True])
def test_an_empty_file_is_a_study_that_was_killed_at_once(tmp_path: Path, resume: bool):
    (tmp_path / "study.sqlite").touch()
    assert run(tmp_path, resume=resume).failed.size == 0
    assert len(chunks(tmp_path)) == 3


# ---- two processes ------------------------------------------------------------------------------


def test_two_at_work_in_one_folder_write_the_same(tmp_path: Path):
    """The second begins, and ends, while the first is in the middle of its work."""
    tables = []

    def again(done: int, size: int) -> None:
        if not tables:
            tables.append(run(tmp_path, resume=True))

    first = run(tmp_path, progress=again)
    assert tables[0].outputs["y"].tolist() == first.outputs["y"].tolist()
    assert len(chunks(tmp_path)) == 3
    run(tmp_path, Other(), resume=True)


def test_a_study_that_another_process_creates_meanwhile_is_resumed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    """It comes between the look for the file and the look into the folder."""
    lexists, looked = os.path.lexists, []

    def lexists_before(path: Path) -> bool:
        if looked:
            return lexists(path)
        looked.append(path)
        run(tmp_path)  # the other one
        return False

    monkeypatch.setattr(os.path, "lexists", lexists_before)
    assert run(tmp_path, resume=True).failed.size == 0


def test_a_write_waits_for_the_transaction_of_another_process(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    """Which ends after 0.5 s, before the limit; a longer one ends the study in one line."""
    holder = (
        "import sqlite3, sys\n"
        "connection = sqlite3.connect(sys.argv[1], isolation_level=None)\n"
        "connection.execute('BEGIN EXCLUSIVE')\n"
        "print('locked', flush=True)\n"
        "sys.stdin.readline()\n"
        "connection.execute('COMMIT')\n"
    )
    run(tmp_path)
    command = [sys.executable, "-c", holder, str(tmp_path / "study.sqlite")]
    for patience in (60.0, 0.0):
        monkeypatch.setattr(store, "PATIENCE", patience)
        pipe = subprocess.PIPE
        with subprocess.Popen(command, stdin=pipe, stdout=pipe, text=True) as process:
            assert process.stdin is not None
            assert process.stdout is not None
            assert process.stdout.readline() == "locked\n"
            if patience:
                threading.Timer(0.5, process.stdin.close).start()  # which ends the transaction
                assert run(tmp_path, resume=True).failed.size == 0
            else:
                with pytest.raises(OSError, match="database is locked; chunks in the file remain"):
                    run(tmp_path, resume=True)


# ---- read-only media ----------------------------------------------------------------------------


def make_read_only(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let every path report that it cannot be written, as on a read-only medium."""
    access = os.access
    monkeypatch.setattr(os, "access", lambda path, mode: mode != os.W_OK and access(path, mode))


def test_a_read_only_store_with_an_interrupted_write_is_rejected(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    """The file holds half a transaction, which only the journal can undo."""
    first = run(tmp_path / "study")
    path, copy = tmp_path / "study" / "study.sqlite", tmp_path / "copy"
    copy.mkdir()
    with closing(sqlite3.connect(path, isolation_level=None)) as connection:
        connection.execute("PRAGMA cache_size=1")  # so that pages are written before the end
        connection.execute("BEGIN")
        connection.execute("UPDATE chunk SET outputs = zeroblob(9000)")
        for file in path.parent.iterdir():
            shutil.copy(file, copy)
        connection.rollback()
    assert len(list(copy.iterdir())) == 2
    make_read_only(monkeypatch)
    assert np.array_equal(run(path.parent, resume=True).outputs["y"], first.outputs["y"])
    with pytest.raises(OSError, match="a write to it was interrupted; copy the folder"):
        run(copy, resume=True)


def test_an_incomplete_read_only_study_is_rejected(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    run(tmp_path)
    change(tmp_path, "DELETE FROM chunk WHERE number = 1")
    before = (tmp_path / "study.sqlite").read_bytes()
    make_read_only(monkeypatch)
    with pytest.raises(OSError, match="cannot be written, and 1 of 3 chunks are not in it"):
        run(tmp_path, resume=True)
    assert (tmp_path / "study.sqlite").read_bytes() == before


# ---- whose study it is --------------------------------------------------------------------------


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
def test_another_study_is_not_mixed_in(tmp_path: Path, over, changes, options, differs):
    wo.sweep(paper_nip(), {"nip_load": [1e3]}, nodes=17, workers=1, out=tmp_path)
    with pytest.raises(wo.InvalidProblem, match=f"contains another study: {differs}"):
        wo.sweep(paper_nip(**changes), over, workers=1, out=tmp_path, resume=True, **options)


def test_folders_that_hold_something_else_are_left_alone(tmp_path: Path):
    (tmp_path / "thesis.txt").write_text("mine", encoding="utf-8")
    with pytest.raises(wo.InvalidProblem, match="is not empty and contains no study"):
        run_study(models.LinearModel(), CASES, Workers(1), out=tmp_path, resume=True)
    assert [path.name for path in tmp_path.iterdir()] == ["thesis.txt"]


def test_a_study_is_not_overwritten(tmp_path: Path):
    run_study(models.LinearModel(), CASES, Workers(1), out=tmp_path)
    with pytest.raises(wo.InvalidProblem, match="contains a study already; resume it"):
        run_study(models.LinearModel(), CASES, Workers(1), out=tmp_path)


# ---- exports ------------------------------------------------------------------------------------


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


def test_parquet_holds_the_same_bits(tmp_path: Path, table):
    parquet = pytest.importorskip("pyarrow.parquet")
    export(table, tmp_path / "study.parquet")
    found = parquet.read_table(tmp_path / "study.parquet")
    assert found.column_names == list(table.to_dataframe())
    half_width = found["half_width"].to_numpy()
    assert half_width.tobytes() == table.outputs["half_width"].tobytes()
    assert found["failure"].to_pylist() == table.failure.tolist()
