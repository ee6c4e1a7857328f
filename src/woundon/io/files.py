"""Files as a whole: read up to a limit, written aside and put in place."""

from __future__ import annotations

import contextlib
import os
import stat
from collections.abc import Iterator
from pathlib import Path
from shutil import copymode
from threading import get_ident

from ..errors import InvalidProblem

__all__ = ["check_writable", "put_in_place", "read_whole", "write_whole"]


def read_whole(path: str | Path, most: int) -> bytes:
    """Return the bytes of a regular file that holds no more than ``most``.

    A missing file is no ``FileNotFoundError``: whoever loads has one class of error to catch.

    Raises
    ------
    InvalidProblem
        If it is missing, cannot be read, is no regular file, or is larger.
    """
    path = os.fspath(path)  # open() would take a number for an open file
    try:
        # a pipe that nobody writes to would keep open() waiting
        with open(path, "rb", opener=_at_once) as file:
            about = os.fstat(file.fileno())
            regular = stat.S_ISREG(about.st_mode)
            # the kernel's own files say that they are empty
            content = file.read(most + 1) if regular and about.st_size <= most else b""
    except OSError as fault:
        raise InvalidProblem.at(str(path), f"cannot be read: {fault.strerror}") from None
    except ValueError as fault:  # a zero byte in the name
        raise InvalidProblem.at(repr(str(path)), f"cannot be read: {fault}") from None
    if not regular:
        raise InvalidProblem.at(str(path), "is no regular file, but a device or a pipe")
    if max(about.st_size, len(content)) > most:
        text = f"is larger than {most / 1e6:g} MB, which no file of this sort is"
        raise InvalidProblem.at(str(path), text)
    return content


def _at_once(path: str, flags: int) -> int:
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0))


@contextlib.contextmanager
def put_in_place(path: str | Path) -> Iterator[Path]:
    """Yield a path beside ``path``; what is written there replaces ``path`` when the block ends.

    The file is there whole or not at all, also after a loss of power: its content is on disk before
    it takes its name.  If the block raises, what was at ``path`` stays as it was.

    Raises
    ------
    OSError
        If it cannot be written, with the name of ``path``.
    """
    place = Path(os.path.realpath(path))  # a link goes on leading to the file
    aside = place.with_name(f".{place.name[:100]}.{os.getpid()}-{get_ident()}.part")
    try:
        with _faults_of(path):
            yield aside
            with contextlib.suppress(FileNotFoundError):
                copymode(place, aside)
            _to_disk(aside, os.O_RDWR)
            os.replace(aside, place)
        with contextlib.suppress(OSError):  # not every system does that with a folder
            _to_disk(place.parent, os.O_RDONLY)
    finally:
        with contextlib.suppress(OSError):
            aside.unlink()


@contextlib.contextmanager
def _faults_of(path: str | Path) -> Iterator[None]:
    """Name ``path`` in the system's errors, whatever the file that they happened to."""
    try:
        yield
    except OSError as fault:
        raise OSError(fault.errno, fault.strerror or str(fault), str(path)) from None


def _to_disk(path: Path, flags: int) -> None:
    descriptor = os.open(path, flags)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def write_whole(path: str | Path, content: bytes) -> None:
    """Write a file so that it is there whole or not at all; see :func:`put_in_place`.

    Raises
    ------
    OSError
        If it cannot be written; the file that was there stays as it was.
    """
    path = Path(path)
    if path.exists() and not path.is_file():  # a device or a pipe is written to, never replaced
        with _faults_of(path):
            path.write_bytes(content)
        return
    with put_in_place(path) as aside:
        aside.write_bytes(content)


def check_writable(path: Path) -> None:
    """Refuse a file that cannot be written, before anything is solved.

    Raises
    ------
    InvalidProblem
        If the path is a folder, or its folder is missing or read-only.
    """
    folder = path.parent
    if not folder.is_dir():
        raise InvalidProblem.at(str(path), f"the folder {str(folder)!r} does not exist")
    if path.is_dir():
        raise InvalidProblem.at(str(path), "is a folder; name a file")
    if not all(os.access(part, os.W_OK) for part in (folder, path) if part.exists()):
        raise InvalidProblem.at(str(path), "cannot be written: no permission")
