"""A study belongs to the program that solved it, and a complete one is read without writing.

Evidence: a copy of the package, one constant of which is changed, may not resume a study of the
package; the files of a complete study are the same, to their times, when it has been resumed.
"""

from __future__ import annotations

import os
import shutil
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

PACKAGE = Path(wo.__file__).parent
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


@pytest.fixture(scope="module")
def copied(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a copy of the package, compiled files included: compiling takes seconds."""
    folder = tmp_path_factory.mktemp("program")
    shutil.copytree(PACKAGE, folder / "woundon")
    return folder


def by(program: Path, study: Path, out: Path, *more: str) -> subprocess.CompletedProcess[str]:
    """Run a sweep by the package of a folder."""
    command = [sys.executable, "-B", "-m", "woundon", "sweep", str(study), "--out", str(out)]
    return subprocess.run(
        [*command, "--workers", "1", "--export", "csv", *more], check=False, capture_output=True,
        text=True, env={**os.environ, "PYTHONPATH": str(program)}, cwd=program, timeout=300,
    )  # fmt: skip


@pytest.mark.slow
def test_another_program_does_not_resume_a_study(study: Path, copied: Path, tmp_path: Path):
    """Neither a complete one nor one that lacks a chunk; the program that began it does."""
    out = tmp_path / "out"
    done = by(copied, study, out, "--chunk", "1")
    assert done.returncode == 0, done.stderr
    changed = copied / "woundon" / "elasticity" / "half_plane.py"
    before = changed.read_bytes()
    changed.write_bytes(before + b"\nANOTHER = 1\n")
    for complete in (True, False):
        if not complete:
            lose(out, 0)
        files = {path: path.read_bytes() for path in out.rglob("*") if path.is_file()}
        again = by(copied, study, out, "--chunk", "1", "--resume")
        assert again.returncode == 2
        assert len(again.stderr.splitlines()) == 1
        assert "another program" in again.stderr
        assert {path: path.read_bytes() for path in out.rglob("*") if path.is_file()} == files
    changed.write_bytes(before)
    assert by(copied, study, out, "--chunk", "1", "--resume").returncode == 0


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
