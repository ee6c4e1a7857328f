"""Files as a whole: what is read, what is refused unread, what is left when a write fails."""

from __future__ import annotations

import io
import os
import resource
import socket
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

import woundon as wo
from woundon.cli.commands import main
from woundon.io import files
from woundon.io.case_files import template
from woundon.io.files import read_whole, replaced_file, write_whole

# ---- reading ------------------------------------------------------------------------------------


def device(name: str) -> Any:
    return lambda folder: Path("/dev") / name


def pipe(folder: Path) -> Path:
    os.mkfifo(folder / "pipe")
    return folder / "pipe"


def bound(folder: Path) -> Path:
    where = os.getcwd()
    os.chdir(folder)  # the name of a socket is a hundred bytes long at most
    try:
        with socket.socket(socket.AF_UNIX) as made:
            made.bind("socket")
    finally:
        os.chdir(where)
    return folder / "socket"


def large(folder: Path) -> Path:
    with open(folder / "large", "wb") as file:
        file.truncate(20_000_000_000)  # takes no room on the disk
    return folder / "large"


def loop(folder: Path) -> Path:
    (folder / "loop").symlink_to("loop")
    return folder / "loop"


ODD = {
    "zero": (device("zero"), "is not a regular file, but a device or a pipe"),
    "null": (device("null"), "is not a regular file, but a device or a pipe"),
    "pipe": (pipe, "is not a regular file, but a device or a pipe"),
    "socket": (bound, "cannot be read: No such device or address"),
    "folder": (lambda folder: folder, "cannot be read: Is a directory"),
    "missing": (lambda folder: folder / "none", "cannot be read: No such file or directory"),
    "loop": (loop, "cannot be read: Too many levels of symbolic links"),
    "long name": (lambda folder: folder / ("x" * 300), "cannot be read: File name too long"),
    "large": (large, "is larger than "),
}


@pytest.mark.parametrize("load", [wo.load_case, wo.load_result])
@pytest.mark.parametrize("name", ODD)
def test_what_is_no_file_is_rejected_alike(tmp_path, load, name):
    make, said = ODD[name]
    path = make(tmp_path)
    with pytest.raises(wo.InvalidProblem) as refusal:
        load(path)
    assert type(refusal.value) is wo.InvalidProblem
    # errors shorten long words
    shown = str(path) if len(str(path)) < 200 else str(path)[:50]
    assert str(refusal.value).startswith(shown)
    assert said in str(refusal.value)
    assert len(str(refusal.value).splitlines()) == 1


def test_a_large_file_is_rejected_before_it_is_read(tmp_path, monkeypatch):
    class Unread(io.FileIO):
        def read(self, size: int | None = -1, /) -> bytes:
            raise AssertionError("read")

    monkeypatch.setattr(
        files, "open", lambda path, mode, opener: Unread(path, opener=opener), raising=False
    )  # fmt: skip
    with pytest.raises(wo.InvalidProblem, match="is larger than 10 MB"):
        wo.load_case(large(tmp_path))


def test_files_of_the_kernel_that_say_they_are_empty_are_read():
    assert read_whole("/proc/self/status", 10**6).startswith(b"Name:")
    with pytest.raises(wo.InvalidProblem, match="is larger than"):
        read_whole("/proc/self/status", 10)


@pytest.mark.parametrize("load", [wo.load_case, wo.load_result, wo.read_thickness_profile])
@pytest.mark.parametrize("path", [0, None, ["scan.csv"]])
def test_what_is_no_path_is_no_open_file(load, path):
    with pytest.raises(wo.InvalidProblem, match=r"path: .* is out of place; must be a str or"):
        load(path)


def test_a_link_to_a_file_is_read(tmp_path):
    (tmp_path / "case").write_bytes(b"x")
    (tmp_path / "link").symlink_to("case")
    assert read_whole(tmp_path / "link", 10) == b"x"


# ---- writing ------------------------------------------------------------------------------------


@contextmanager
def largest_file(size: int) -> Iterator[None]:
    """Let no file become larger, as on a disk that is full: the write itself fails."""
    kept, compiled = resource.getrlimit(resource.RLIMIT_FSIZE), sys.dont_write_bytecode
    sys.dont_write_bytecode = True  # Python would keep half of a module that is imported here first
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, kept[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, kept)
        sys.dont_write_bytecode = compiled


def test_a_block_that_raises_leaves_the_old_file_and_nothing_else(tmp_path):
    def fill(aside: Path) -> None:
        aside.write_text("half")
        raise KeyboardInterrupt

    path = tmp_path / "a"
    path.write_text("old")
    with pytest.raises(KeyboardInterrupt), replaced_file(path) as aside:
        fill(aside)
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_content_is_on_disk_before_it_takes_its_name(tmp_path, monkeypatch):
    done: list[tuple[str, Any]] = []
    fsync, replace = os.fsync, os.replace
    monkeypatch.setattr(
        files.os, "fsync", lambda d: (done.append(("to disk", os.fstat(d).st_ino)), fsync(d))
    )
    monkeypatch.setattr(
        files.os, "replace", lambda a, b: (done.append(("renamed", b)), replace(a, b))
    )
    write_whole(tmp_path / "a", b"new")
    file, folder = (tmp_path / "a").stat().st_ino, tmp_path.stat().st_ino
    assert done == [("to disk", file), ("renamed", tmp_path / "a"), ("to disk", folder)]


@pytest.mark.parametrize(
    "ending",
    [
        "nc",
        "json",
        "csv",
        "png",
        *(pytest.param(e, marks=pytest.mark.slow) for e in ("svg", "pdf")),
    ],
)
def test_a_full_disk_is_one_line_and_keeps_the_old_file(tmp_path, capsys, ending):
    path = tmp_path / f"rollers.{ending}"
    path.write_text("old")
    option = "--save" if ending in ("nc", "json", "csv") else "--plot"
    case = tmp_path / "case.toml"
    case.write_text(template("rollers"))
    command = ["solve", str(case), "--nodes", "25", option, str(path)]
    with largest_file(1000):
        assert main(command) == 2
    assert capsys.readouterr().err == f"error: {path}: File too large\n"
    assert path.read_text() == "old"
    assert set(tmp_path.iterdir()) == {case, path}
    assert main(command) == 0
    assert path.stat().st_size > 1000


def test_a_device_is_written_to_and_never_replaced():
    with pytest.raises(OSError, match="No space left on device: '/dev/full'"):
        write_whole("/dev/full", b"x")
    assert Path("/dev/full").is_char_device()


def test_links_modes_and_long_names_are_kept(tmp_path):
    file, link, name = tmp_path / "file", tmp_path / "link", tmp_path / ("x" * 255)
    file.write_text("old")
    file.chmod(0o640)
    link.symlink_to("file")
    write_whole(link, b"new")
    assert link.is_symlink()
    assert (file.read_text(), file.stat().st_mode & 0o777) == ("new", 0o640)
    write_whole(name, b"new")
    assert name.read_text() == "new"


def test_an_unwritable_place_is_named(tmp_path):
    for path in (tmp_path / "none" / "a", tmp_path):
        with pytest.raises(OSError) as fault:  # noqa: PT011
            write_whole(path, b"new")
        assert fault.value.filename == str(path)
    assert list(tmp_path.iterdir()) == []
