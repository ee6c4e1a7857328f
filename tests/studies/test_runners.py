"""Who solves: this process, a pool, a Dask cluster; workers that die; Ctrl-C and kill -9."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import study_models as models
from slow_cases import slow_case
from thesis_cases import paper_nip

import woundon as wo
from woundon.studies import run
from woundon.studies.cases import make_cases
from woundon.studies.run import DIED, Workers, run_study

CASES = make_cases({"a": range(8)})


def test_a_model_that_raises_fails_its_case_alone():
    table = run_study(models.FailingModel(), CASES, Workers(1))
    assert table.failed.tolist() == [3]
    assert table.failure[3] == "ZeroDivisionError: a is 3"
    assert np.array_equal(np.delete(table.outputs["y"], 3), np.delete(2.0 * np.arange(8), 3))


def test_a_worker_that_dies_changes_nothing(tmp_path: Path):
    table = run_study(models.CrashingModel(once=str(tmp_path / "died")), CASES, Workers(2), chunk=2)
    assert (tmp_path / "died").exists()
    assert table.failed.size == 0
    assert np.array_equal(table.outputs["y"], 2.0 * np.arange(8))


def test_a_chunk_that_kills_every_worker_fails_alone():
    table = run_study(models.CrashingModel(), CASES, Workers(2), chunk=2)
    assert table.failed.tolist() == [2, 3]
    assert set(table.failure[2:4]) == {DIED}
    assert table.outputs["y"][4:].tolist() == [8.0, 10.0, 12.0, 14.0]


_clock = [0.0]  # of this process, in place of the real one


def process_of(seconds: float) -> int:
    """Work for some seconds of the clock; return the number of the process."""
    _clock[0] += seconds
    return os.getpid()


def test_long_work_moves_to_several_processes(monkeypatch: pytest.MonkeyPatch):
    """Short ones are solved by this process alone."""
    monkeypatch.setattr(run, "time", SimpleNamespace(perf_counter=lambda: _clock[0]))
    monkeypatch.setattr(run, "usable_cores", lambda: 2)
    work = run.WORTH_PROCESSES / 60
    short = [pid for _, pid in Workers().map(process_of, [0.9 * work] * 60)]
    long = [pid for _, pid in Workers().map(process_of, [2.0 * work] * 60)]
    assert set(short) == {os.getpid()}
    assert long.count(os.getpid()) == 1  # which shows how long the others take


def dask_cluster(workers: int, *, processes: bool):
    """Return a cluster of this machine, whose parts talk as those of several do."""
    distributed = pytest.importorskip("distributed")
    return distributed.LocalCluster(
        n_workers=workers, threads_per_worker=1, processes=processes, host="127.0.0.1",
        protocol="tcp", dashboard_address=None,
    )  # fmt: skip


@pytest.fixture(scope="module")
def cluster():
    """A cluster whose two workers are processes, which take seconds to start."""
    with dask_cluster(2, processes=True) as made:
        yield made


@pytest.fixture(scope="module")
def thread():
    """A cluster whose worker is a thread."""
    with dask_cluster(1, processes=False) as made:
        yield made


@pytest.mark.filterwarnings("ignore")  # of Dask's own event loops
@pytest.mark.parametrize("kind", ["thread", slow_case("cluster")])
def test_dask_gives_the_same_numbers(kind: str, request: pytest.FixtureRequest):
    over = {"nip_load": np.linspace(1000, 3000, 12)}
    address = request.getfixturevalue(kind).scheduler_address
    here = wo.sweep(paper_nip(), over, nodes=17, workers=1, chunk=3)
    there = wo.sweep(paper_nip(), over, nodes=17, chunk=3, scheduler=address)
    assert here.identical(there)


@pytest.mark.filterwarnings("ignore")
def test_the_profiles_of_a_fit_are_found_on_a_cluster(thread):
    """The same intervals; a worker starts from the minimum only, to the solver tolerance."""
    data = {"load": [5e4, 8.9e4, 1.2e5], "half_width": [266e-6, 353e-6, 412e-6]}
    pair, vary, how = wo.RollerProblem.example(), ["upper.radius"], {"starts": 1, "nodes": 17}
    here = wo.fit(pair, data, vary, workers=1, **how)
    there = wo.fit(pair, data, vary, scheduler=thread.scheduler_address, **how)
    for one, other in zip(here.profiles, there.profiles, strict=True):
        assert [other.low, other.high] == pytest.approx([one.low, one.high], rel=1e-6)


@pytest.mark.filterwarnings("ignore")
def test_an_operating_window_is_solved_on_a_cluster(thread):
    given = {"uncertain": {"roll_friction": 0.3}, "samples": 128}
    here = wo.operating_window(models.BOARD, (200, 500), (1e3, 4e3), **given, workers=1)
    there = wo.operating_window(
        models.BOARD, (200, 500), (1e3, 4e3), **given, scheduler=thread.scheduler_address
    )
    np.testing.assert_array_equal(here.probability, there.probability)


@pytest.mark.filterwarnings("ignore")
def test_a_machine_of_a_cluster_without_the_program_is_named(
    thread, monkeypatch: pytest.MonkeyPatch
):
    """Otherwise its worker would leave the cluster, and the study would wait for others."""
    client = pytest.importorskip("distributed").Client
    get_versions = client.get_versions

    def without_program(*args, **options):
        versions = get_versions(*args, **options)
        for worker in versions["workers"].values():
            worker["packages"]["woundon"] = None
        return versions

    monkeypatch.setattr(client, "get_versions", without_program)
    with pytest.raises(wo.InvalidProblem, match=r"scheduler: tcp://\S+ has no woundon; install"):
        list(Workers(scheduler=thread.scheduler_address).map(abs, [1]))


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
def test_a_dask_worker_killed_in_the_middle_changes_nothing(cluster):
    pids = [worker.pid for worker in cluster.workers.values()]
    killed = []

    def kill_one(done: int, size: int) -> None:
        if not killed and done >= 6:
            os.kill(pids[0], signal.SIGKILL)
            killed.append(done)

    workers = Workers(scheduler=cluster.scheduler_address)
    cases = make_cases({"a": range(30)})
    table = run_study(models.SlowModel(seconds=0.05), cases, workers, chunk=2, progress=kill_one)
    assert killed
    assert killed[0] < 30
    limit = time.monotonic() + 60
    while pids[0] in [each.pid for each in cluster.workers.values()]:
        assert time.monotonic() < limit
        time.sleep(0.05)  # its nanny hears of it later
    assert pids[0] not in [worker.pid for worker in cluster.workers.values()]
    assert table.failed.size == 0
    assert np.array_equal(table.outputs["y"], 2.0 * np.arange(30))


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
def test_ctrl_c_finishes_what_a_cluster_works_on(cluster, tmp_path: Path, capsys):
    """Four chunks a worker are under way: these are finished and kept, the others not begun."""
    pressed = []

    def press(done: int, size: int) -> None:
        if not pressed:
            pressed.append(done)
            signal.raise_signal(signal.SIGINT)

    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    cases, workers = make_cases({"a": range(60)}), Workers(scheduler=cluster.scheduler_address)
    try:
        with pytest.raises(KeyboardInterrupt):
            run_study(models.SlowModel(), cases, workers, chunk=2, out=tmp_path, progress=press)
    finally:
        signal.signal(signal.SIGINT, before)
    assert capsys.readouterr().err.count("press Ctrl-C again to stop at once") == 1
    assert 4 <= len(models.stored(tmp_path)) <= 10
    resumed = run_study(
        models.SlowModel(seconds=0.0), cases, Workers(1), chunk=2, out=tmp_path, resume=True
    )
    assert np.array_equal(resumed.outputs["y"], 2.0 * np.arange(60))


@pytest.mark.filterwarnings("ignore")
def test_a_scheduler_out_of_reach_is_reported(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(run, "CONNECTING", 0.5)
    with pytest.raises(wo.InvalidProblem, match=r"'tcp://127\.0\.0\.1:9' cannot be reached"):
        run_study(models.LinearModel(), CASES, Workers(scheduler="tcp://127.0.0.1:9"))


# a study of 6000 nips, some 20 ms each, in 1200 chunks: it takes a minute at least
STUDY = """
schema = 1
case = "{case}"
[over]
nip_load = {{ from = "1 kN/m", to = "4 kN/m", count = 6000 }}
[solver]
nodes = 33
"""
CASE = Path(__file__).with_name("nip_alone.toml")


def _interrupted_in_the_middle(study: Path, out: Path, workers: str) -> tuple[int, str]:
    """Start the study, press Ctrl-C after the first chunks; return exit code and output."""
    command = [
        sys.executable, "-m", "woundon", "sweep", str(study), "--out", str(out), "--chunk", "5",
        "--workers", workers,
    ]  # fmt: skip
    process = subprocess.Popen(
        command, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True,
        start_new_session=True,
        # a shell lets jobs in its background ignore Ctrl-C, which processes inherit
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )  # fmt: skip
    limit = time.monotonic() + 120
    while len(models.stored(out)) < 3 and process.poll() is None and time.monotonic() < limit:
        time.sleep(0.005)
    os.killpg(process.pid, signal.SIGINT)  # a terminal sends it to the whole group
    said = process.communicate(timeout=120)[1]
    return process.returncode, said


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The study file."""
    study = tmp_path_factory.mktemp("study") / "study.toml"
    study.write_text(STUDY.format(case=CASE), encoding="utf-8")
    return study


@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
@pytest.mark.parametrize("workers", ["1", slow_case("2")])
def test_ctrl_c_ends_cleanly(study: Path, tmp_path: Path, workers: str):
    out = tmp_path / "out"
    code, said = _interrupted_in_the_middle(study, out, workers)
    assert code == 130
    assert "finishing the chunks under way; press Ctrl-C again to stop at once" in said
    assert f"interrupted; the solved cases are in {out}, --resume continues" in said
    assert "Traceback" not in said
    assert [path.name for path in out.iterdir()] == ["study.sqlite"]
    assert 3 <= len(models.stored(out)) < 1200
