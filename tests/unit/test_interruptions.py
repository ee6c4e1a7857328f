"""Ctrl-C, SIGTERM and SIGHUP end commands in one line, with the exit code that shells expect."""

from __future__ import annotations

import os
import re
import signal
import sqlite3
import subprocess
import sys
import threading
import time
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import IO

import httpx
import pytest
from slow_cases import slow_case

import woundon as wo
from woundon.io.case_texts import to_toml
from woundon.parallel import terminations_as_interrupts

pytestmark = pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")

STUDY = """
schema = 1
case = "case.toml"
outputs = ["nip_width"]
[over]
nip_load = { from = "3 kN/m", to = "4 kN/m", count = 1000 }
[solver]
nodes = 65
"""
CODES = {signal.SIGINT: 130, signal.SIGTERM: 143, signal.SIGHUP: 129}


def start(
    *arguments: str, cwd: Path, stderr: int | IO[str] = subprocess.PIPE
) -> subprocess.Popen[str]:
    """Start a command in a process group of its own."""
    command = [sys.executable, "-m", "woundon", *arguments]

    def as_in_a_terminal() -> None:
        # a shell ignores Ctrl-C for what runs in the background, and nohup ignores SIGHUP
        signal.signal(signal.SIGINT, signal.default_int_handler)
        signal.signal(signal.SIGHUP, signal.SIG_DFL)

    return subprocess.Popen(
        command, cwd=cwd, stdout=subprocess.PIPE, stderr=stderr, text=True, start_new_session=True,
        preexec_fn=as_in_a_terminal,
    )  # fmt: skip


def wait_for(condition) -> None:
    """Wait until a condition is true; a minute at most."""
    limit = time.monotonic() + 60
    while not condition():
        assert time.monotonic() < limit
        time.sleep(0.02)


def solved_chunks(store: Path) -> int:
    """Return the number of chunks in the file of a study."""
    try:
        with sqlite3.connect(store) as database:
            return database.execute("SELECT count(*) FROM chunk").fetchone()[0]
    except sqlite3.OperationalError:  # not created yet
        return 0


def processes(group: int) -> list[str]:
    """Return the processes of a group that is not a shell's."""
    done = subprocess.run(["ps", "-A", "-o", "pgid=,stat="], capture_output=True, text=True)
    rows = [line.split() for line in done.stdout.splitlines()]
    return [state for number, state in rows if int(number) == group and state[0] != "Z"]


def study(folder: Path, workers: str) -> Sequence[str]:
    """Write a study of a thousand nips; return the command that solves it."""
    (folder / "case.toml").write_text(to_toml(wo.NipProblem.example()), encoding="utf-8")
    (folder / "study.toml").write_text(STUDY, encoding="utf-8")
    return ("sweep", "study.toml", "--out", "out", "--workers", workers, "--chunk", "4")


@pytest.mark.parametrize(
    ("number", "workers", "send"),
    [
        (signal.SIGTERM, "2", os.killpg),  # as batch systems and service managers do
        slow_case(signal.SIGHUP, "2", os.killpg),  # as a terminal that closes does
        slow_case(signal.SIGTERM, "2", os.kill),
        slow_case(signal.SIGHUP, "1", os.kill),
    ],
)
def test_a_study_keeps_its_cases_and_says_how_to_resume(tmp_path: Path, number, workers, send):
    command = start(*study(tmp_path, workers), cwd=tmp_path)
    wait_for(lambda: solved_chunks(tmp_path / "out" / "study.sqlite") or command.poll() is not None)
    send(command.pid, number)
    said, complained = command.communicate(timeout=120)
    # of the progress a line every 10 s, and the bar at the end
    *progress, last = complained.splitlines()
    assert progress
    assert all(line.startswith("solving") for line in progress)
    assert last == "interrupted; the solved cases are in out, --resume continues"
    assert said == ""
    assert command.returncode == CODES[number]
    assert solved_chunks(tmp_path / "out" / "study.sqlite") > 0
    wait_for(lambda: not processes(command.pid))


@pytest.mark.parametrize(
    "number", [signal.SIGTERM, slow_case(signal.SIGHUP), slow_case(signal.SIGINT)]
)
def test_a_command_without_a_folder_says_that_nothing_is_kept(tmp_path: Path, number):
    study(tmp_path, "1")
    (tmp_path / "cases.csv").write_text(
        "nip_load [N/m]\n" + "\n".join(map(str, range(3000, 4000))), encoding="utf-8"
    )
    error_output = tmp_path / "error_output.txt"
    with error_output.open("w") as channel:
        command = start(
            "table", "cases.csv", "--case", "case.toml", "--out", "out.csv", "--workers", "2",
            cwd=tmp_path, stderr=channel,
        )  # fmt: skip
    wait_for(lambda: len(processes(command.pid)) > 2)  # with a worker and loky's tracker
    command.send_signal(number)
    if number == signal.SIGINT:  # the first one lets it finish what is under way
        wait_for(lambda: "press Ctrl-C again" in error_output.read_text())
        command.send_signal(number)
    command.communicate(timeout=120)
    complained = error_output.read_text()
    assert complained.splitlines()[-1] == "interrupted; nothing is kept"
    assert "Traceback" not in complained
    assert command.returncode == CODES[number]


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
def test_the_server_ends_in_one_line_while_it_computes(tmp_path: Path, number):
    command = start("app", "--no-browser", "--port", "0", cwd=tmp_path)
    assert command.stdout is not None
    found = re.search(r"http://\S+(?=/\s)", command.stdout.readline())
    assert found is not None
    case = httpx.get(f"{found[0]}/api/catalogue", timeout=60).json()["kinds"][0]["example"]

    def solve() -> None:
        with suppress(httpx.HTTPError):
            httpx.post(f"{found[0]}/api/curve?points=40&field=nip_load", json=case, timeout=60)

    request = threading.Thread(target=solve)
    request.start()
    wait_for(lambda: len(processes(command.pid)) > 2)  # the request has started a worker
    os.killpg(command.pid, number)
    _, complained = command.communicate(timeout=120)
    request.join()
    assert complained == "stopped; open pages keep their cases until the server is started again\n"
    assert command.returncode == CODES[number]
    wait_for(lambda: not processes(command.pid))


def test_a_signal_that_is_ignored_or_handled_is_left_alone():
    """As SIGHUP under nohup."""
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with terminations_as_interrupts() as arrived:
            signal.raise_signal(signal.SIGHUP)
            with pytest.raises(KeyboardInterrupt):
                signal.raise_signal(signal.SIGTERM)
        assert arrived == [signal.SIGTERM]
        assert signal.getsignal(signal.SIGTERM) is signal.SIG_DFL
    finally:
        signal.signal(signal.SIGHUP, before)
