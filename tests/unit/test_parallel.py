"""Work in processes: answers, errors, workers that die, cancellation, scripts, Ctrl-C."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from concurrent.futures import Future
from contextlib import suppress
from functools import partial
from multiprocessing import connection
from pathlib import Path

import process_tasks
import pytest
from joblib.externals.loky import process_executor
from joblib.externals.loky.backend import queues
from slow_cases import slow_case

import woundon as wo
from woundon import parallel
from woundon.parallel import Cancelled, Worker, WorkerDied, environment, in_processes

SQUARES = [(x, x * x) for x in range(8)]
posix = pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")


def children() -> set[int]:
    """Return the workers of this process."""
    found = set()
    for stat in Path("/proc").glob("[0-9]*/stat"):
        with suppress(OSError):
            state, parent = stat.read_text().rpartition(")")[2].split()[:2]
            command = (stat.parent / "cmdline").read_bytes()
            if int(parent) == os.getpid() and state != "Z" and b"popen_loky" in command:
                found.add(int(stat.parent.name))
    return found


def wait_for(condition: Callable[[], bool]) -> None:
    """Wait until a condition is true; a minute at most."""
    limit = time.monotonic() + 60
    while not condition():
        assert time.monotonic() < limit
        time.sleep(0.01)


def test_every_item_comes_with_its_answer():
    assert sorted(in_processes(process_tasks.square, range(8), 2)) == SQUARES
    assert list(in_processes(process_tasks.square, [], 2)) == []
    assert children() == set()


def test_workers_have_one_blas_thread_and_this_process_what_it_had(monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "7")
    monkeypatch.delenv("MKL_NUM_THREADS", raising=False)
    before = dict(os.environ)
    assert dict(in_processes(process_tasks.setting, list(environment()), 1)) == environment()
    # loky sets this for the OpenMP of its workers
    changed = {k: v for k, v in os.environ.items() if k != "KMP_INIT_AT_FORK"}
    assert changed == {k: v for k, v in before.items() if k != "KMP_INIT_AT_FORK"}


def test_what_work_raises_has_the_worker_s_traceback():
    with pytest.raises(ZeroDivisionError) as fault:
        list(in_processes(process_tasks.raises, range(8), 2))
    assert "return 1 // (x - 3)" in str(fault.value.__cause__)
    assert children() == set()


@posix
def test_a_worker_that_dies_loses_nothing(tmp_path: Path):
    work = partial(process_tasks.crash_at_three, once=str(tmp_path / "died"))
    assert sorted(in_processes(work, range(8), 2)) == SQUARES
    assert (tmp_path / "died").exists()


@posix
def test_an_item_that_kills_is_distinguished():
    found = dict(in_processes(process_tasks.crash_at_three, range(8), 2, died=lambda x: -x))
    assert found == {**dict(SQUARES), 3: -3}
    with pytest.raises(WorkerDied, match="two worker processes died during this item"):
        list(in_processes(process_tasks.crash_at_three, range(8), 2))


@posix
def test_workers_killed_while_they_wait_are_replaced():
    found = in_processes(process_tasks.square, range(8), 2)
    first = next(found)
    for process in children():
        os.kill(process, signal.SIGKILL)
    assert sorted([first, *found]) == SQUARES


@posix
def test_a_worker_that_died_while_it_was_idle_is_replaced_at_once():
    """The thread that watches the process may learn of its end after the next item came."""
    worker = Worker()
    try:
        for x in range(20):
            assert worker.submit(process_tasks.square, x).result() == x * x
            (process,) = worker._executor._processes.values()
            os.kill(process.pid, signal.SIGKILL)
            connection.wait([process.sentinel])
            assert worker.submit(process_tasks.square, x).result() == x * x
    finally:
        worker.kill()


def test_a_closed_generator_leaves_no_process():
    found = in_processes(process_tasks.square, range(8), 2)
    next(found)
    if sys.platform == "linux":
        wait_for(lambda: len(children()) == 2)  # the other one may still be starting
    found.close()
    assert children() == set()


def test_a_worker_starts_no_pool_of_its_own():
    assert list(in_processes(process_tasks.squares_by_a_pool, [4], 1)) == [(4, [0, 1, 4, 9])]


def test_work_is_cancelled_at_its_next_progress_and_the_worker_goes_on():
    worker = Worker()
    try:
        process = worker.submit(os.getpid).result()
        work = worker.submit(process_tasks.waits, 600.0)
        wait_for(work.running)
        worker.cancel()
        with pytest.raises(Cancelled):
            work.result(60)
        assert worker.submit(os.getpid).result() == process  # the flag is cleared
        assert worker.submit(process_tasks.waits, 0.05).result() == 0.05
    finally:
        worker.kill()


@pytest.mark.parametrize("problem", [wo.NipProblem, wo.RollerProblem, wo.RollProblem])
def test_solvers_report_fractions_and_can_be_cancelled(problem: type):
    seen: list[float] = []
    wo.solve(problem.example(), progress=seen.append)
    assert seen
    assert 0 <= min(seen) <= max(seen) <= 1

    def cancel(fraction: float) -> None:
        raise Cancelled

    with pytest.raises(Cancelled):
        wo.solve(problem.example(), progress=cancel)


def test_no_thread_outlives_its_worker(monkeypatch: pytest.MonkeyPatch):
    """A thread that removes semaphores while the command ends leaves a complaint about them."""
    feed = queues.Queue._feed

    def feed_slowly(*args: object) -> None:
        feed(*args)
        time.sleep(1.5)

    monkeypatch.setattr(queues.Queue, "_feed", staticmethod(feed_slowly))
    before = set(threading.enumerate())
    worker = Worker()
    assert worker.submit(abs, -1).result() == 1
    worker.kill()
    assert set(threading.enumerate()) <= before


def test_a_worker_is_killed_while_it_is_sent_more_than_its_pipe_holds():
    """The thread that writes ends too: nobody can read any more."""
    before = set(threading.enumerate())
    worker = Worker(prepare=partial(time.sleep, 600))  # reads nothing
    worker.submit(len, bytes(1 << 24))  # 16 MB; a pipe holds 64 kB
    worker.kill()
    assert set(threading.enumerate()) <= before


@pytest.mark.filterwarnings("ignore::pytest.PytestUnhandledThreadExceptionWarning")
def test_a_worker_is_killed_whose_thread_fails(monkeypatch: pytest.MonkeyPatch):
    """The other thread would wait for ever for something to write."""
    manager = process_executor._ExecutorManagerThread
    kill_process = manager.flag_executor_shutting_down

    def fail(self: object) -> None:
        kill_process(self)
        raise RuntimeError

    monkeypatch.setattr(manager, "flag_executor_shutting_down", fail)
    before = set(threading.enumerate())
    worker = Worker()
    assert worker.submit(abs, -1).result() == 1
    worker.kill()
    assert set(threading.enumerate()) <= before


def test_a_worker_is_killed_while_another_thread_starts_its_process(
    monkeypatch: pytest.MonkeyPatch,
):
    """Otherwise a process would start that nobody kills."""
    pipe, starting = parallel._parent_pipe, threading.Event()

    def pipe_slowly() -> object:
        starting.set()
        time.sleep(0.5)
        return pipe()

    monkeypatch.setattr(parallel, "_parent_pipe", pipe_slowly)
    worker = Worker()
    thread = threading.Thread(target=worker.submit, args=(time.sleep, 600))
    thread.start()
    starting.wait()
    worker.kill()
    thread.join()
    left = worker._executor
    worker.kill()
    assert left is None
    assert children() == set()


def test_a_cancellation_after_the_end_of_a_worker_leaves_no_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    """As of a request whose server ends meanwhile."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    worker = Worker()
    assert worker.submit(abs, -1).result() == 1
    worker.cancel()
    assert list(tmp_path.glob("woundon-*"))
    worker.kill()
    worker.cancel()
    assert not list(tmp_path.glob("woundon-*"))


def test_a_worker_is_killed_while_it_works():
    worker = Worker()
    work = worker.submit(time.sleep, 60)
    worker.kill()
    with pytest.raises(RuntimeError, match="shutdown"):
        work.result(60)
    assert worker.submit(process_tasks.square, 3).result() == 9
    worker.kill()


def test_workers_start_without_signal_masks(monkeypatch: pytest.MonkeyPatch):
    """As on Windows, which has none."""
    monkeypatch.delattr(signal, "pthread_sigmask", raising=False)
    monkeypatch.delattr(os, "sched_getaffinity", raising=False)
    assert parallel.usable_cores() >= 1
    assert sorted(in_processes(process_tasks.square, range(8), 2)) == SQUARES


def _start(script: str, *args: str) -> subprocess.Popen[str]:
    """Start a script that hears Ctrl-C, with a group of its own."""
    return subprocess.Popen(
        [sys.executable, script, *args], text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        start_new_session=True, env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
        # a shell lets jobs in its background ignore Ctrl-C, and that is inherited
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )  # fmt: skip


@posix
def test_ctrl_c_waits_until_a_worker_is_started(monkeypatch: pytest.MonkeyPatch):
    """The signal arrives in another thread, which no mask of the main thread prevents."""
    from joblib.externals.loky import ProcessPoolExecutor

    submit, pressed, submitted = ProcessPoolExecutor.submit, threading.Event(), []

    def press() -> None:
        pressed.wait()
        signal.raise_signal(signal.SIGINT)

    def submit_slowly(executor: ProcessPoolExecutor, *args: object) -> Future[int]:
        pressed.set()
        finger.join()
        submitted.append(submit(executor, *args))
        return submitted[0]

    monkeypatch.setattr(ProcessPoolExecutor, "submit", submit_slowly)
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    finger = threading.Thread(target=press)
    finger.start()
    worker = Worker()
    try:
        with pytest.raises(KeyboardInterrupt):
            worker.submit(process_tasks.square, 3)
        assert submitted[0].result() == 9
    finally:
        worker.kill()
        signal.signal(signal.SIGINT, before)
    assert children() == set()


@posix
def test_ctrl_c_waits_until_all_workers_are_killed(monkeypatch: pytest.MonkeyPatch):
    kill = Worker.kill

    def kill_slowly(worker: Worker) -> None:
        signal.raise_signal(signal.SIGINT)
        kill(worker)

    monkeypatch.setattr(Worker, "kill", kill_slowly)
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt):
            list(in_processes(process_tasks.square, range(8), 2))
    finally:
        signal.signal(signal.SIGINT, before)
    assert children() == set()


STUDY = """
import numpy as np
import woundon as wo
from thesis_cases import paper_nip

print("the script runs")
over = {"nip_load": np.linspace(1000, 4000, 80)}
data = wo.sweep(paper_nip(), over, nodes=17, chunk=2, workers=2)
print(int(np.isfinite(data.wound_on_tension).sum()), "solved")
"""


@pytest.mark.slow
@posix
def test_a_study_in_a_script_without_a_guard(tmp_path: Path):
    """40 chunks, of which the workers hold two at a time."""
    (tmp_path / "study.py").write_text(STUDY, encoding="utf-8")
    said, complained = _start(str(tmp_path / "study.py")).communicate(timeout=300)
    assert said.splitlines() == ["the script runs", "80 solved"]
    assert complained == ""


OWN = """
import numpy as np
from woundon.parallel import in_processes

SCALE = np.array([0.5])

def half(x):
    return float(SCALE[0] * x)

print(sorted(in_processes(half, range(4), 2)))
"""


@posix
def test_work_defined_in_a_script_without_a_guard(tmp_path: Path):
    path = tmp_path / "own.py"
    path.write_text(OWN, encoding="utf-8")
    said, complained = _start(str(path)).communicate(timeout=300)
    assert said == "[(0, 0.0), (1, 0.5), (2, 1.0), (3, 1.5)]\n"
    assert complained == ""


SLEEPERS = """
import sys
from contextlib import suppress
from functools import partial
import process_tasks
from woundon.parallel import in_processes

folder, finishing = sys.argv[1:]
work = partial(process_tasks.waits_for_release, folder=folder)
for item, _ in in_processes(work, range(50), 2, finishing=finishing):
    print(item, flush=True)
"""


def _asleep(tmp_path: Path, finishing: str) -> tuple[subprocess.Popen, list[int]]:
    """Start two workers that wait over each item; return the script and the workers' ids."""
    pids = tmp_path / "pids"
    pids.mkdir()
    (tmp_path / "sleep.py").write_text(SLEEPERS, encoding="utf-8")
    script = _start(str(tmp_path / "sleep.py"), str(pids), finishing)
    wait_for(lambda: len(list(pids.iterdir())) == 2 or script.poll() is not None)
    found = [int(path.name) for path in pids.iterdir()]
    assert len(found) == 2
    assert all(map(_alive, found))
    return script, found


def _alive(pid: int) -> bool:
    try:
        os.kill(pid, 0)
        stat = Path(f"/proc/{pid}/stat")
        return not stat.exists() or stat.read_text().rpartition(")")[2].split()[0] != "Z"
    except (ProcessLookupError, FileNotFoundError):
        return False


@posix
@pytest.mark.parametrize("send", [slow_case(os.kill), os.killpg])
def test_ctrl_c_stops_at_once_and_leaves_no_worker(tmp_path: Path, send):
    """To the parent alone, and to the whole group as a terminal does; its work does not end."""
    script, pids = _asleep(tmp_path, "")
    send(script.pid, signal.SIGINT)
    said, complained = script.communicate(timeout=60)
    assert script.returncode == -signal.SIGINT
    assert said == ""
    assert complained.count("Traceback") == 1  # the script's own
    assert not any(map(_alive, pids))


@posix
def test_the_first_ctrl_c_finishes_what_is_under_way_where_asked(tmp_path: Path):
    script, pids = _asleep(tmp_path, "finishing")
    os.killpg(script.pid, signal.SIGINT)
    assert script.stderr.readline() == "finishing\n"
    (tmp_path / "pids" / process_tasks.RELEASE).touch()
    said, _ = script.communicate(timeout=60)
    assert sorted(said.split()) == ["0", "1"]
    assert script.returncode == -signal.SIGINT
    assert not any(map(_alive, pids))


@posix
def test_the_second_ctrl_c_stops_at_once(tmp_path: Path):
    script, pids = _asleep(tmp_path, "finishing")
    os.killpg(script.pid, signal.SIGINT)
    assert script.stderr.readline() == "finishing\n"
    assert all(map(_alive, pids))
    os.killpg(script.pid, signal.SIGINT)
    script.communicate(timeout=60)
    assert script.returncode == -signal.SIGINT
    assert not any(map(_alive, pids))


@posix
def test_kill_9_leaves_no_worker(tmp_path: Path):
    script, pids = _asleep(tmp_path, "")
    script.kill()
    script.communicate(timeout=60)
    wait_for(lambda: not any(map(_alive, pids)))
