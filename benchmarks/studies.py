"""How many nips a study solves per second, what the engine costs, how workers share the work.

    python benchmarks/studies.py                     samples of three studies, two minutes
    python benchmarks/studies.py --only cover --chunks 100
    python benchmarks/studies.py --dask 20000        by a Dask cluster of two workers here

Each study is a grid of a million cases of the thesis's Table 1: nip load, winding force, friction
and shear modulus are varied; chunks of 100 neighbours are drawn from it.  Rates are given by
the clock, and by processor time as multiples of a dense LU solve of 398 x 398 in the same run: on a
busy machine only the latter means something.  Of a Dask cluster the memory of the process that
hands out the work is told too.
"""

from __future__ import annotations

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import resource
import time
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from speed import COVER, Baseline

import woundon as wo
from jorkama2001.cases import paper_nip
from woundon.studies.design import Design, make_design
from woundon.studies.engine import run_study
from woundon.studies.evaluate import Block, Chunk
from woundon.studies.kind_model import KindModel, model_of
from woundon.studies.runners import DaskRunner, Here, Pool

warnings.simplefilter("ignore", wo.ValidityWarning)
warnings.simplefilter("ignore", wo.ResolutionWarning)

OVER = {
    "nip_load": (1000.0, 5000.0, 100),
    "winding_force": (-100.0, 200.0, 50),
    "roll_friction": (0.15, 0.3, 20),
    "roll.material.shear": (6e6, 15e6, 10),
}
HALF_PLANE = paper_nip(roll=wo.HalfPlane(radius=0.3, material=wo.material("paper")))
# what is solved, its tension, and how many nips a second are asked of two cores
STUDIES = {
    "half-plane": (HALF_PLANE, "nip_induced_tension", 1000),
    "cover": (paper_nip(drum=COVER), "nip_induced_tension", 300),
    "wrapped": (HALF_PLANE.wrapped(), "wound_on_tension", 100),
}


@dataclass
class Study:
    """A study's model and design."""

    model: KindModel
    design: Design

    @classmethod
    def of(cls, name: str) -> Study:
        """Return one by its name."""
        problem, tension, _ = STUDIES[name]
        outputs = (tension, f"errors.{tension}")
        over = {field: np.linspace(*ends) for field, ends in OVER.items()}
        tie = {"web.material": "roll.material"}
        return cls(model_of(problem, outputs, tie, {}), make_design(over))

    def sample(self, count: int) -> list[Chunk]:
        """Return chunks drawn from the whole grid."""
        chunks = self.design.chunks()
        places = np.random.default_rng(0).choice(len(chunks), count, replace=False)
        return [Chunk(int(k), chunks[k], self.design.inputs(chunks[k])) for k in places]


def timed(run: Callable[[], Any]) -> tuple[Any, float, float]:
    """Return the outcome, seconds by the clock, and seconds of this process and its children."""
    wall, before = time.perf_counter(), os.times()
    out = run()
    after = os.times()
    return out, time.perf_counter() - wall, sum(after[:4]) - sum(before[:4])


def alone(study: Study, chunks: list[Chunk]) -> float:
    """Return processor seconds a case of the solver alone, each from the result before."""
    solver, cases = study.model.kind.solver, sum(len(c.cases) for c in chunks)
    rows = [[study.model.variant(row) for row in chunk.rows()] for chunk in chunks]

    def solve() -> None:
        for problems in rows:
            state = None
            for problem in problems:
                state = solver(problem, start=state)

    return timed(solve)[2] / cases


def accuracy(study: Study, chunks: list[Chunk], blocks: list[Block], count: int) -> str:
    """Compare cases drawn from the blocks with solutions on 513 nodes."""
    rng, solved = np.random.default_rng(0), {b.number: b for b in blocks}
    tension, true, told, scale = study.model.outputs[0], [], [], []
    for _ in range(count):
        chunk = chunks[rng.integers(len(chunks))]
        row = int(rng.integers(len(chunk.cases)))
        problem = study.model.variant(list(chunk.rows())[row])
        fine = getattr(wo.solve(problem, nodes=513), tension)
        value, error = solved[chunk.number].values[row]
        true.append(abs(value - fine))
        told.append(error)
        scale.append(max(abs(fine), 0.01 * problem.roll_friction * problem.nip_load))
    ratios, errors = np.array(true) / told, np.array(true) / scale
    return (
        f"true errors of {count}: median {np.median(errors):.2%}, largest {errors.max():.2%}; "
        f"{np.mean(ratios <= 1.5):.0%} within 1.5 told ones, largest {ratios.max():.2g} of them"
    )


def report(name: str, count: int, check: int, baseline: Baseline) -> None:
    """Print rates and shares of a study."""
    study = Study.of(name)
    chunks = study.sample(count)
    cases = sum(len(c.cases) for c in chunks)
    study.model.run({}, None)
    unit = float(np.median([baseline.once() for _ in range(15)]))
    blocks, wall, spent = timed(lambda: list(Here().solved(study.model, chunks)))
    unit = (unit + float(np.median([baseline.once() for _ in range(15)]))) / 2
    failed = sum(np.count_nonzero(b.failure != "") for b in blocks)
    print(f"{name}: {cases} of {study.design.size} cases, {failed} failed; "
          f"asked of two cores {STUDIES[name][2]} a second")  # fmt: skip
    print(f"  here: {cases / wall:.0f} a second by the clock, {cases / spent:.0f} by processor time"
          f"; {spent / cases / unit:.2f} dense solves of {1e3 * unit:.2f} ms each")  # fmt: skip
    few = chunks[:: max(1, len(chunks) // 5)]
    pairs = [(timed(lambda: list(Here().solved(study.model, few)))[2], alone(study, few))
             for _ in range(3)]  # fmt: skip
    whole, bare = np.min(pairs, axis=0)
    whole /= sum(len(c.cases) for c in few)
    print(f"  a case takes {1e3 * whole:.2f} ms in the study, {1e3 * bare:.2f} in the solver: "
          f"{whole / bare - 1:+.0%}")  # fmt: skip
    rates = {workers: pooled(study, chunks, workers) for workers in (1, 2)}
    told = ", ".join(
        f"{w}: {by_clock:.0f}, {by_cpu:.0f}" for w, (by_clock, by_cpu) in rates.items()
    )
    print(f"  pools, a second by the clock and by processor time all together: {told}; two are "
          f"worth {rates[2][1] / rates[1][1]:.2f} by processor time")  # fmt: skip
    print(f"  {accuracy(study, chunks, blocks, check)}", flush=True)


def pooled(study: Study, chunks: list[Chunk], workers: int) -> tuple[float, float]:
    """Return cases a second by the clock, and if each worker had a core to itself.

    Without what it takes to start them.
    """
    first = [Chunk(0, chunks[0].cases[:1], {k: v[:1] for k, v in chunks[0].inputs.items()})]
    starting = [timed(lambda: list(Pool(workers).solved(study.model, first * workers)))
                for _ in range(2)]  # fmt: skip
    _, wall, spent = timed(lambda: list(Pool(workers).solved(study.model, chunks)))
    begun_wall, begun = np.min([(w, s) for _, w, s in starting], axis=0)
    cases = sum(len(c.cases) for c in chunks)
    return cases / (wall - begun_wall), workers * cases / (spent - begun)


def resident() -> float:
    """Return the memory of this process [MB]."""
    text = Path("/proc/self/status").read_text("utf-8")
    return next(int(line.split()[1]) / 1024 for line in text.splitlines() if "VmRSS" in line)


def by_dask(name: str, count: int) -> None:
    """Solve so many cases from the middle of a grid by a Dask cluster of two workers, kept on disk.

    Neighbours are as near as in the whole grid: only the nip loads are fewer.
    """
    from distributed import LocalCluster

    study = Study.of(name)
    over = {column.name: column.values for column in study.design.columns}
    loads = np.array(over["nip_load"])
    few = max(1, round(count * loads.size / study.design.size))
    over["nip_load"] = loads[loads.size // 2 :][:few]
    sample = Study(study.model, make_design(over))
    count = sample.design.size
    seen = [resident()]
    with (
        LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster,
        TemporaryDirectory() as folder,
    ):
        seen.append(resident())

        def note(done: int, of: int) -> None:
            seen.append(resident())

        began, own = time.perf_counter(), time.process_time()
        table = run_study(sample.model, sample.design, DaskRunner(cluster.scheduler_address),
                          out=Path(folder) / "study", progress=note)  # fmt: skip
        wall, own = time.perf_counter() - began, time.process_time() - own
        size = sum(path.stat().st_size for path in Path(folder).rglob("*") if path.is_file())
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    print(f"{name}, {count} cases, Dask with two workers: {count / wall:.0f} a second by the "
          f"clock, {len(table.failed)} failed; workers spent "
          f"{1e3 * (used.ru_utime + used.ru_stime) / count:.2f} ms a case, the process that hands "
          f"out (scheduler and writing included) {1e3 * own / count:.3f} ms; its memory: "
          f"{seen[0]:.0f} MB before, {seen[1]:.0f} with the cluster, {seen[2]:.0f} at the first "
          f"chunk, {max(seen):.0f} at most; {size / count:.0f} bytes a case on disk")  # fmt: skip


def main() -> None:
    """Print rates, shares and errors."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--only", nargs="+", choices=STUDIES, default=list(STUDIES))
    options.add_argument("--chunks", type=int, default=10, help="of 100 cases each")
    options.add_argument("--check", type=int, default=50, help="cases compared with fine ones")
    options.add_argument("--dask", type=int, metavar="CASES", help="by a Dask cluster instead")
    given = options.parse_args()
    if given.dask:
        by_dask(given.only[0], given.dask)
        return
    baseline = Baseline()
    for name in given.only:
        report(name, given.chunks, given.check, baseline)


if __name__ == "__main__":
    main()
