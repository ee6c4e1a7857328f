"""One process at a time in a folder: a lock that ends with its process, and who holds it.

    DIR/.lock          locked by the operating system while a study is at work
    DIR/.owner.json    who that is; left behind by a process that was killed

The system gives the lock back when its process dies, and whoever has its number by then does not
matter: no stale lock keeps anybody out.
"""

from __future__ import annotations

import json
import os
import platform
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import datetime
from pathlib import Path

from ..errors import InvalidProblem
from ..io.files import read_whole, write_whole

__all__ = ["HIDDEN", "locked"]

HIDDEN = (".lock", ".owner.json")


@contextmanager
def locked(folder: Path) -> Iterator[str]:
    """Keep other processes out; provide what is to be said of one that died in here, '' if none.

    Raises
    ------
    InvalidProblem
        If another process holds the lock, with its number, host and start.
    OSError
        If the file system has no locks.
    """
    from filelock import FileLock, Timeout

    lock, owner = FileLock(folder / HIDDEN[0]), folder / HIDDEN[1]
    try:
        lock.acquire(blocking=False)
    except Timeout:
        who, _ = _owner(owner)
        text = f"{who} is at work in it; wait until it has ended, or stop it"
        raise InvalidProblem.at(str(folder), text) from None
    try:
        told = _left_behind(owner) if owner.exists() else ""
        since = f"{datetime.now():%Y-%m-%d %H:%M:%S}"
        here = {"process": os.getpid(), "host": platform.node(), "since": since}
        write_whole(owner, json.dumps(here).encode("utf-8"))
        yield told
    finally:
        owner.unlink(missing_ok=True)
        lock.release()


def _owner(path: Path) -> tuple[str, str]:
    """Return who holds or held the lock, and on which host ('' if that cannot be read)."""
    try:
        told = json.loads(read_whole(path, 10_000))
        return "process {process} on host {host}, since {since},".format(**told), str(told["host"])
    except (ValueError, LookupError, TypeError, RecursionError):
        return "another process", ""


def _left_behind(path: Path) -> str:
    who, host = _owner(path)
    text = f"{who} died at work in it; its lock is taken over"
    if host in ("", platform.node()):
        return text
    # a local lock on a folder of the network: nothing is lost, for all write the same parts
    return f"{text}. Make sure that it is not still running there: not all file systems tell"
