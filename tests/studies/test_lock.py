"""One process at a time in a study's folder."""

from __future__ import annotations

import json
import os
import platform
import signal
import subprocess
import sys
from contextlib import nullcontext
from pathlib import Path

import pytest
import toys

import woundon as wo
from woundon.studies import store
from woundon.studies.design import make_design
from woundon.studies.engine import run_study
from woundon.studies.runners import Here

DESIGN = make_design({"a": range(8)})
HOLDER = """
import sys
import time
from pathlib import Path
from woundon.studies.lock import locked

with locked(Path(sys.argv[1])):
    print("at work", flush=True)
    time.sleep(60)
"""


@pytest.fixture
def holder(tmp_path: Path):
    """A process that is at work in the folder."""
    command = [sys.executable, "-c", HOLDER, str(tmp_path)]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment) as process:
        assert process.stdout.readline() == "at work\n"
        yield process
        process.kill()


def _run(out: Path, **how):
    return run_study(toys.Toy(), DESIGN, Here(), out=out, **how)


def test_a_second_process_is_refused_and_told_who_is_there(holder, tmp_path: Path):
    with pytest.raises(wo.InvalidProblem) as refusal:
        _run(tmp_path, resume=True)
    said = str(refusal.value)
    assert said.startswith(f"{tmp_path}: process {holder.pid} on host {platform.node()}, since 2")
    assert said.endswith(", is at work in it; wait until it has ended, or stop it")
    assert not (tmp_path / "parts").exists()


@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
def test_the_lock_of_a_dead_process_is_taken_over_and_told(holder, tmp_path: Path):
    os.kill(holder.pid, signal.SIGKILL)
    holder.wait()
    text = rf"process {holder.pid} on host .* died at work in it; its lock is taken over$"
    with pytest.warns(UserWarning, match=text):
        _run(tmp_path, resume=True)
    _run(tmp_path, resume=True)  # it ended as it should: nothing is told


def test_numbers_of_processes_are_not_asked_about(tmp_path: Path):
    """The owner's note names a process that lives: it has that number now, and no lock."""
    note = {"process": os.getpid(), "host": platform.node(), "since": "2001-05-11 12:00:00"}
    (tmp_path / ".owner.json").write_text(json.dumps(note), encoding="utf-8")
    with pytest.warns(UserWarning, match="since 2001-05-11 12:00:00, died at work in it"):
        _run(tmp_path)


def test_of_other_hosts_the_user_is_asked(tmp_path: Path):
    note = {"process": 7, "host": "far.example", "since": "2001-05-11 12:00:00"}
    (tmp_path / ".owner.json").write_text(json.dumps(note), encoding="utf-8")
    with pytest.warns(UserWarning, match="on host far.example.* still running there"):
        _run(tmp_path)


@pytest.mark.parametrize("note", [b"", b"[]", b"{}", b"[" * 5000, b"\xff"])
def test_an_owner_s_note_that_cannot_be_read(tmp_path: Path, note: bytes):
    (tmp_path / ".owner.json").write_bytes(note)
    with pytest.warns(UserWarning, match="another process died at work in it"):
        _run(tmp_path)


def test_where_locks_do_not_reach_two_write_the_same(tmp_path: Path, monkeypatch):
    """The second begins, and ends, while the first is in the middle of its work."""
    monkeypatch.setattr(store, "locked", lambda folder: nullcontext(""))
    tables = []

    def again(done: int, size: int) -> None:
        if not tables:
            tables.append(_run(tmp_path, chunk=2, resume=True))

    tables += [_run(tmp_path, chunk=2, progress=again), _run(tmp_path, chunk=2, resume=True)]
    assert [table.outputs["y"].tolist() for table in tables] == 3 * [[2.0 * a for a in range(8)]]
    assert len(list((tmp_path / "parts").iterdir())) == 4


def test_within_one_process_too(tmp_path: Path):
    refused = []

    def again(done: int, size: int) -> None:
        with pytest.raises(wo.InvalidProblem, match=f"process {os.getpid()} on host") as refusal:
            _run(tmp_path, resume=True)
        refused.append(refusal)

    _run(tmp_path, progress=again)
    assert refused
