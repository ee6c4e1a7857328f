"""Time against version 0.2, in pairs in one run, and against each other.

    python benchmarks/speed.py                           all kinds of work
    python benchmarks/speed.py plain winding --cases 20  some of them
    python benchmarks/speed.py --at FOLDER --offline     options of version_0_2.py
    python benchmarks/speed.py --alone                   without version 0.2

Two processes, one with each version, solve the same random problems in turns, so that a busy
machine slows both.  Each solves a problem of its kind once before; bodies are new in each case, so
that their influence functions are part of the time.  Times are processor times of one thread; the
unit of the last column is a dense solve of 398 x 398, the size of the thesis's system.

    plain ... hardening   a solution with the default options (random_nips.py)
    neighbours            three wrapped nips, each with start= the one before, 1 to 5 % apart
    sensitivities         derivatives of a plain nip with respect to all inputs
    winding               the example of a winding, with other loads
"""

from __future__ import annotations

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import json
import subprocess
import sys
import time
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import IO, Any

import numpy as np
import version_0_2
from random_nips import FAMILIES, random_nip, random_wrapped_neighbours
from scipy.linalg import lu_factor, lu_solve

import woundon as wo

__all__ = ["Baseline"]

HERE = Path(__file__).resolve()
SLOW = {"hardening": 10, "winding": 5}  # cases by default
CASES = 100
WARM_UP = 999_999  # a seed that is not timed


class Baseline:
    """A dense LU solve, the unit of time."""

    def __init__(self, size: int = 398) -> None:
        random = np.random.default_rng(0)
        self.matrix = random.normal(size=(size, size)) + size * np.eye(size)
        self.right = random.normal(size=size)
        self.seconds: list[float] = []

    def once(self) -> float:
        """Return the seconds of one solve."""
        self.seconds.append(timed(lambda: lu_solve(lu_factor(self.matrix), self.right)))
        return self.seconds[-1]

    def ratio(self, work: Callable[[], object], repeats: int = 25) -> float:
        """Return the median of the work's time over that of the solves before and after it."""
        work()  # influence functions and meshes are computed once
        ratios = []
        for _ in range(repeats):
            before = self.once()
            spent = timed(work)
            ratios.append(2 * spent / (before + self.once()))
        return float(np.median(ratios))


def timed(work: Callable[[], object]) -> float:
    """Return the processor time of a call [s]."""
    start = time.process_time()
    work()
    return time.process_time() - start


# ---- the work -----------------------------------------------------------------------------------


def neighbours(seed: int) -> Callable[[], object]:
    """Return the solution of three neighbours of a wrapped nip, each from the one before."""
    first, *others = random_wrapped_neighbours(seed)
    solved = wo.solve(first)

    def work() -> None:
        start = solved
        for problem in others:
            start = wo.solve(problem, start=start)

    return work


def sensitivities(seed: int) -> Callable[[], object]:
    """Return the derivatives of a plain nip."""
    return wo.solve(random_nip(seed)).sensitivity


def winding(seed: int) -> Callable[[], object]:
    """Return the solution of a winding."""
    random, problem = np.random.default_rng(seed), wo.WindingProblem.example()
    factor = 1 + 0.05 * random.uniform(-1, 1)
    problem = problem.replace(nip_load=factor * problem.nip_load)
    return lambda: wo.solve(problem)


def _solution(of: str) -> Callable[[int], Callable[[], object]]:
    def prepare(seed: int) -> Callable[[], object]:
        problem = FAMILIES[of](seed)
        return lambda: wo.solve(problem)

    return prepare


WORK: dict[str, Callable[[int], Callable[[], object]]] = {
    **{of: _solution(of) for of in FAMILIES},
    "neighbours": neighbours, "sensitivities": sensitivities, "winding": winding,
}  # fmt: skip


def serve() -> None:
    """Answer lines [work, seed] with the seconds, or null for a problem that is rejected."""
    answers, sys.stdout = sys.stdout, sys.stderr
    warnings.simplefilter("ignore")
    baseline = Baseline()
    for line in sys.stdin:
        name, seed = json.loads(line)
        try:
            before, work = baseline.once(), WORK[name](seed)
            seconds = timed(work)
            computed = [seconds, (before + baseline.once()) / 2]
        except (wo.InvalidProblem, wo.NoSteadyState, wo.NotConverged):
            computed = [None, None]
        print(json.dumps(computed), file=answers, flush=True)


class Version:
    """A process with one version of the program."""

    def __init__(self, python: str, source: Path) -> None:
        path = os.pathsep.join([str(source), str(HERE.parent)])
        self.process: Any = subprocess.Popen(
            [python, str(HERE), "--serve"], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
            text=True, env=os.environ | {"PYTHONPATH": path},
        )  # fmt: skip

    def seconds(self, name: str, seed: int) -> tuple[float, float] | None:
        """Return the processor times of a work and of a dense solve."""
        lines: tuple[IO[str], IO[str]] = (self.process.stdin, self.process.stdout)
        lines[0].write(json.dumps([name, seed]) + "\n")
        lines[0].flush()
        spent, unit = json.loads(lines[1].readline())
        return None if spent is None else (spent, unit)

    def close(self) -> None:
        """End the process."""
        self.process.stdin.close()
        self.process.wait()


def measured(versions: list[Version], name: str, cases: int, first: int) -> list[list[float]]:
    """Return the times of all versions, and of the dense solve, case by case."""
    for version in versions:
        version.seconds(name, WARM_UP)
    rows = []
    for k in range(cases):
        # the version that begins alternates
        order = range(len(versions)) if k % 2 else reversed(range(len(versions)))
        found = {i: versions[i].seconds(name, first + k) for i in order}
        both = [pair for _, pair in sorted(found.items()) if pair is not None]
        if len(both) == len(versions):
            rows.append([*(spent for spent, _ in both), both[0][1]])
    return rows


def main() -> int:
    """Print the table."""
    options = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    options.add_argument("work", nargs="*", choices=[*WORK, []], help="kinds of work; all if none")
    options.add_argument("--cases", type=int, help="random cases of each")
    options.add_argument("--first", type=int, default=0, help="first seed")
    options.add_argument("--alone", action="store_true", help="without version 0.2")
    options.add_argument("--at", type=Path, default=version_0_2.TREE, help="its worktree")
    options.add_argument("--offline", action="store_true", help="it uses these packages")
    options.add_argument("--serve", action="store_true", help=argparse.SUPPRESS)
    given = options.parse_args()
    if given.serve:
        serve()
        return 0
    versions = [Version(sys.executable, Path(wo.__file__).parents[1])]
    if not given.alone:
        tree = given.at.resolve()
        version_0_2.create(tree, offline=given.offline)
        versions.append(Version(str(version_0_2.python(tree)), version_0_2.source(tree)))
    plain = None
    print("| work | cases | ms, median | of version 0.2 | ratio, median | 90 % | by a plain nip "
          "| dense solves |\n|---|---|---|---|---|---|---|---|")  # fmt: skip
    for name in given.work or WORK:
        cases = given.cases or SLOW.get(name, CASES)
        times = np.array(measured(versions, name, cases, given.first))
        if not times.size:
            print(f"| {name} | 0 |  |  |  |  |  |  |")
            continue
        own, unit = float(np.median(times[:, 0])), times[:, -1]
        if name == "plain":
            plain = own
        against = ["", "", ""]
        if len(versions) > 1:
            ratio = times[:, 0] / times[:, 1]
            against = [f"{1e3 * np.median(times[:, 1]):.3g}", f"{np.median(ratio):.2f}",
                       f"{np.quantile(ratio, 0.9):.2f}"]  # fmt: skip
        by_plain = "" if plain is None else f"{own / plain:.2g}"
        print(f"| {name.replace('_', ' ')} | {len(times)} | {1e3 * own:.3g} | "
              f"{' | '.join(against)} | {by_plain} | {np.median(times[:, 0] / unit):.3g} |",
              flush=True)  # fmt: skip
    for version in versions:
        version.close()
    return 0


if __name__ == "__main__":
    sys.exit(main())
