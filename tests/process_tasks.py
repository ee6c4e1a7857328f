"""Work for worker processes, which import nothing but this: each start counts."""

from __future__ import annotations

import os
import signal
import time
from pathlib import Path

from woundon.parallel import in_processes, progress


def square(x: int) -> int:
    return x * x


def raises(x: int) -> int:
    return 1 // (x - 3)


def setting(name: str) -> str:
    return os.environ[name]


def crash_at_three(x: int, once: str = "") -> int:
    """Kill its process at 3: the first time only if ``once`` names a file, else always."""
    if x == 3 and not (once and Path(once).exists()):
        if once:
            Path(once).touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return x * x


def squares_by_a_pool(x: int) -> list[int]:
    return sorted(answer for _, answer in in_processes(square, range(x), 2))


RELEASE = "release"


def waits_for_release(x: int, folder: str) -> int:
    """Leave a file named for its process, and wait for the file RELEASE in the folder."""
    (Path(folder) / str(os.getpid())).touch()
    while not (Path(folder) / RELEASE).exists():
        time.sleep(0.01)
    return x


def nothing() -> None:
    """What a worker gets ready."""


def waits(seconds: float) -> float:
    """Wait, and report progress while doing so."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        progress(1 - (end - time.monotonic()) / seconds)
        time.sleep(0.01)
    return seconds


def limits() -> tuple[int, int]:
    """Return the limit of the address space, and the priority, of this process."""
    import resource

    return resource.getrlimit(resource.RLIMIT_AS)[0], os.nice(0)


_kept: list[bytearray] = []


def keeps_memory(size: int) -> int:
    """Keep memory of this size, every page written; return the process."""
    _kept.append(bytearray(b"1" * size))
    return os.getpid()
