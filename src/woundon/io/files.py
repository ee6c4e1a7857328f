"""Read complete files up to a limit, and replace files atomically."""

from __future__ import annotations

import contextlib
import os
import stat
from collections.abc import Collection, Iterator
from pathlib import Path
from shutil import copymode
from threading import get_ident

from ..errors import InvalidProblem

__all__ = ["check_ending", "check_writable", "read_whole", "replaced_file", "write_whole"]


def read_whole(path: str | Path, max_bytes: int) -> bytes:
    """Return the bytes of a regular file of at most ``max_bytes``.

    A missing file raises InvalidProblem, so that callers have one class of error to catch.

    Raises
    ------
    InvalidProblem
        If it is missing, cannot be read, is not a regular file, or is larger.

    Examples
    --------
    >>> read_whole("missing.toml", 1000)
    Traceback (most recent call last):
    woundon.errors.InvalidProblem: missing.toml: cannot be read: No such file or directory
    """
    # importing it loads NumPy, which the help of commands does not need
    from ..arguments import check_type

    check_type("path", path, str, os.PathLike)  # open() would take a number for an open file
    try:
        # open() would wait for a pipe that nobody writes to
        with open(path, "rb", opener=_open_nonblocking) as file:
            status = os.fstat(file.fileno())
            regular = stat.S_ISREG(status.st_mode)
            # files of the kernel state a size of 0
            content = file.read(max_bytes + 1) if regular and status.st_size <= max_bytes else b""
    except OSError as fault:
        raise InvalidProblem.at(str(path), f"cannot be read: {fault.strerror}") from None
    except ValueError as fault:  # a zero byte in the name
        raise InvalidProblem.at(repr(str(path)), f"cannot be read: {fault}") from None
    if not regular:
        raise InvalidProblem.at(str(path), "is not a regular file, but a device or a pipe")
    if max(status.st_size, len(content)) > max_bytes:
        text = f"is larger than {max_bytes / 1e6:g} MB"
        raise InvalidProblem.at(str(path), text)
    return content


def _open_nonblocking(path: str, flags: int) -> int:
    """Open a file without waiting for the other end of a pipe; return its descriptor."""
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0))


@contextlib.contextmanager
def replaced_file(path: str | Path) -> Iterator[Path]:
    """Yield a temporary path; the file written there replaces ``path`` when the block ends.

    The replacement is atomic, also after a loss of power: the content is on disk before the file is
    renamed.  If the block raises, the file at ``path`` is unchanged.

    Raises
    ------
    OSError
        If it cannot be written, with the name of ``path``.
    """
    place = Path(os.path.realpath(path))  # a link is kept, its target is replaced
    temporary = place.with_name(f".{place.name[:100]}.{os.getpid()}-{get_ident()}.part")
    try:
        with _path_in_errors(path):
            yield temporary
            with contextlib.suppress(FileNotFoundError):  # there is no file to replace
                copymode(place, temporary)
            _sync(temporary, os.O_RDWR)
            os.replace(temporary, place)
        with contextlib.suppress(OSError):  # not every system can do that for a folder
            _sync(place.parent, os.O_RDONLY)
    finally:
        with contextlib.suppress(OSError):
            temporary.unlink()


@contextlib.contextmanager
def _path_in_errors(path: str | Path) -> Iterator[None]:
    """Replace the name of the temporary file by ``path`` in errors of the system."""
    try:
        yield
    except OSError as fault:
        raise OSError(fault.errno, fault.strerror or str(fault), str(path)) from None


def _sync(path: Path, flags: int) -> None:
    """Write the buffers of a file or folder, opened with ``flags``, to the disk."""
    descriptor = os.open(path, flags)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def write_whole(path: str | os.PathLike[str], content: bytes) -> None:
    """Write a file atomically; see :func:`replaced_file`.

    Raises
    ------
    OSError
        If it cannot be written; an existing file is unchanged.
    """
    path = Path(path)
    if path.exists() and not path.is_file():  # a device or a pipe cannot be replaced
        with _path_in_errors(path):
            path.write_bytes(content)
        return
    with replaced_file(path) as temporary:
        temporary.write_bytes(content)


def check_ending(path: str | os.PathLike[str], known: Collection[str]) -> str:
    """Return the ending of a path, such as ".csv"; reject one that is not known.

    Raises
    ------
    InvalidProblem
        Lists the known endings.
    """
    ending = Path(path).suffix
    if ending not in known:
        text = f"the ending {ending!r} is not a known format; must be {', '.join(known)}"
        raise InvalidProblem.at(str(path), text)
    return ending


def check_writable(path: Path) -> None:
    """Reject a file that cannot be written, before a long computation.

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
