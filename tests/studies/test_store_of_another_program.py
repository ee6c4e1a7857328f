"""A study belongs to the version that solved it, and a complete one is read without writing.

Evidence: a study whose record states another version is not resumed; the files of a complete study
are the same, to their times, when it has been resumed.
"""

from __future__ import annotations

import os
import sqlite3
import subprocess
import sys
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
import xarray

import woundon as wo
from woundon.cli import commands as cli

STUDY = """\
schema = 1
outputs = ["half_width"]
[over]
nip_load = [1000.0, 2000.0, 3000.0]
[solver]
nodes = 17
"""

Capture = pytest.CaptureFixture[str]


@pytest.fixture
def study(tmp_path: Path, capsys: Capture) -> Path:
    """A study file."""
    assert cli.main(["new", "nip"]) == 0
    (tmp_path / "case.toml").write_text(capsys.readouterr().out, encoding="utf-8")
    path = tmp_path / "study.toml"
    path.write_text(f'case = "case.toml"\n{STUDY}', encoding="utf-8")
    return path


def sweep(study: Path, out: Path, *more: str) -> int:
    return cli.main(["sweep", str(study), "--out", str(out), "--workers", "1", *more])


def lose(out: Path, number: int) -> None:
    """Delete a chunk."""
    with closing(sqlite3.connect(out / "study.sqlite")) as connection, connection:
        assert connection.execute("DELETE FROM chunk WHERE number = ?", (number,)).rowcount == 1


# ---- another program ----------------------------------------------------------------------------


@pytest.mark.parametrize("complete", [True, False])
def test_another_version_does_not_resume_a_study(
    study: Path, tmp_path: Path, capsys: Capture, complete: bool
):
    """Neither a complete one nor one that lacks a chunk, whatever else its tables contain."""
    out = tmp_path / "out"
    assert sweep(study, out, "--chunk", "1") == 0
    if not complete:
        lose(out, 0)
    with closing(sqlite3.connect(out / "study.sqlite")) as connection, connection:
        connection.execute("UPDATE study SET record = json_set(record, '$.version', '0.3.1')")
        connection.execute("ALTER TABLE study ADD COLUMN sha256 TEXT")  # as version 0.3.1 had it
    before = state(out)
    capsys.readouterr()
    assert sweep(study, out, "--chunk", "1", "--resume") == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert f"solved by another program: woundon 0.3.1, this is woundon {wo.__version__};" in line
    assert state(out) == before


# ---- read-only media ----------------------------------------------------------------------------


def state(folder: Path) -> dict[str, tuple[int, int]]:
    """Return size and time of last change of a folder and all that is in it."""
    return {str(path): (path.stat().st_size, path.stat().st_mtime_ns)
            for path in (folder, *folder.rglob("*"))}  # fmt: skip


@pytest.mark.parametrize("chunk", [1, 2, 100])
def test_a_complete_study_is_read_without_any_writing(chunk: int, tmp_path: Path):
    problem, over, out = (
        wo.NipProblem.example().replace(roll_wrap=0.0),
        {"nip_load": [1e3, 2e3, 3e3]},
        tmp_path / "out",
    )
    first = wo.sweep(problem, over, nodes=17, workers=1, out=out, chunk=chunk)
    before = state(out)
    again = wo.sweep(problem, over, nodes=17, workers=1, out=out, chunk=chunk, resume=True)
    assert again.identical(first)
    assert state(out) == before


def test_a_complete_study_is_exported_to_another_folder(
    study: Path, tmp_path: Path, capsys: Capture
):
    out, exported = tmp_path / "out", tmp_path / "exported" / "here"
    assert sweep(study, out) == 0
    before = state(out)
    formats = [part for ending in ("nc", "csv", "xlsx") for part in ("--export", ending)]
    assert sweep(study, out, "--resume", "--export-to", str(exported), *formats) == 0
    assert state(out) == before
    assert {path.name for path in exported.iterdir()} == {
        "study.nc", "study.csv", "study.xlsx", "half_width.png",
    }  # fmt: skip
    with (
        xarray.open_dataset(exported / "study.nc", engine="scipy") as one,
        xarray.open_dataset(out / "study.nc", engine="scipy") as other,
    ):
        assert np.array_equal(one.half_width, other.half_width)


@pytest.mark.skipif(
    os.name == "nt" or getattr(os, "geteuid", int)() == 0, reason="permissions bind other users"
)
def test_a_read_only_folder(study: Path, tmp_path: Path, capsys: Capture):
    out = tmp_path / "out"
    assert sweep(study, out, "--chunk", "1") == 0
    try:
        out.chmod(0o555)
        capsys.readouterr()
        assert sweep(study, out, "--chunk", "1", "--resume") == 2
        assert "--export-to" in capsys.readouterr().err
        exported = tmp_path / "exported"
        assert sweep(study, out, "--chunk", "1", "--resume", "--export-to", str(exported)) == 0
        assert (exported / "study.csv").exists()
    finally:
        out.chmod(0o755)


@pytest.mark.skipif(sys.platform != "linux", reason="mounts a file system")
def test_a_read_only_medium(study: Path, tmp_path: Path, capsys: Capture):
    """A file system that is mounted read-only, with a complete study and with one that is not."""
    disk = tmp_path / "disk"
    disk.mkdir()
    mount = ["mount", "-t", "tmpfs", "tmpfs", str(disk)]
    if subprocess.run(mount, capture_output=True, check=False).returncode:
        pytest.skip("file systems may not be mounted here")
    try:
        complete, cut = disk / "complete", disk / "cut"
        for out in (complete, cut):
            assert sweep(study, out, "--chunk", "1") == 0
        lose(cut, 1)
        subprocess.run(["mount", "-o", "remount,ro", str(disk)], check=True)
        exported = ("--chunk", "1", "--resume", "--export-to", str(tmp_path / "exported"))
        assert sweep(study, complete, *exported) == 0
        assert (tmp_path / "exported" / "study.csv").read_bytes() == (
            (complete / "study.csv").read_bytes()
        )
        capsys.readouterr()
        assert sweep(study, cut, *exported) == 2
        assert "1 of 3 chunks are not in it" in capsys.readouterr().err
    finally:
        subprocess.run(["umount", "-l", str(disk)], check=True)
