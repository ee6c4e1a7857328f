"""A server of the page in a process of its own, for tests and for what is measured here."""

from __future__ import annotations

import re
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import httpx

__all__ = ["Server", "serving"]


class Server(NamedTuple):
    """Where it answers, and its process."""

    address: str
    pid: int

    def memory(self) -> dict[str, float]:
        """Return what its processes hold, the server's and all workers' [MB]; {} if unknown."""
        try:
            children = self._children()
        except OSError:
            return {}
        return {"server": _resident(self.pid), "workers": sum(map(_resident, children))}

    def workers(self) -> list[int]:
        """Return the ids of its worker processes."""
        return [
            pid
            for pid in self._children()
            if b"popen_loky" in Path(f"/proc/{pid}/cmdline").read_bytes()
        ]

    def _children(self) -> list[int]:
        """Return the ids of all processes that it has started."""
        tasks = Path(f"/proc/{self.pid}/task").iterdir()
        return [int(pid) for task in tasks for pid in (task / "children").read_text().split()]


def _resident(pid: int) -> float:
    try:
        text = Path(f"/proc/{pid}/status").read_text()
    except OSError:
        return 0.0
    return int(text.partition("VmRSS:")[2].split()[0]) / 1024 if "VmRSS:" in text else 0.0


@contextmanager
def serving(*options: str) -> Iterator[Server]:
    """Provide a server on a free port, whose workers are ready."""
    port = [] if "--port" in options else ["--port", "0"]
    command = [sys.executable, "-m", "woundon", "app", "--no-browser", *port, *options]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    line = process.stdout.readline()
    found = re.search(r"http://[^/\s]+", line)
    assert found, f"the server did not start: {line}"
    server = Server(found[0], process.pid)
    try:
        _wait(server.address)
        yield server
    finally:
        process.terminate()
        process.communicate(timeout=30)


def _wait(address: str) -> None:
    for _ in range(600):
        try:
            kinds = httpx.get(f"{address}/api/catalogue", timeout=60).json()["kinds"]
            break
        except httpx.TransportError:
            time.sleep(0.1)
    # the last that is opened are those of studies
    study = {"case": kinds[0]["example"], "over": {"web_tension": [300, 400]}}
    httpx.post(f"{address}/api/sweep", json=study, timeout=120).raise_for_status()
