"""Files as a whole: read up to a limit, written aside and moved into place."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path

from ..errors import InvalidProblem

__all__ = ["check_writable", "read_whole", "write_whole"]


def read_whole(path: str | Path, most: int) -> bytes:
    """Return a file's bytes; no more than ``most`` are ever taken in.

    Raises
    ------
    InvalidProblem
        If it cannot be read, or is larger.
    """
    try:
        with open(path, "rb") as file:
            content = file.read(most + 1)
    except OSError as fault:
        raise InvalidProblem.at(str(path), f"cannot be read: {fault.strerror}") from None
    except ValueError as fault:  # a zero byte in the name
        raise InvalidProblem.at(repr(str(path)), f"cannot be read: {fault}") from None
    if len(content) > most:
        text = f"is larger than {most / 1e6:g} MB, which no file of this sort is"
        raise InvalidProblem.at(str(path), text)
    return content


def write_whole(path: str | Path, content: bytes) -> None:
    """Write a file so that it is there whole or not at all, also after a loss of power.

    Raises
    ------
    OSError
        If it cannot be written; the file that was there stays as it was.
    """
    path = Path(path)
    if path.exists() and not path.is_file():  # a device or a pipe is written to, never replaced
        path.write_bytes(content)
        return
    aside = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        with open(aside, "wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        os.replace(aside, path)
    except OSError as fault:
        raise OSError(fault.errno, fault.strerror, str(path)) from None
    finally:
        with contextlib.suppress(OSError):
            aside.unlink()


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
