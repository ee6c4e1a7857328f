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


Problems = list[Any]


def draw(name: str, seed: int) -> Problems:
    """Return the random problems of a kind of work."""
    if name == "neighbours":
        return random_wrapped_neighbours(seed)
    if name == "sensitivities":
        return [random_nip(seed)]
    if name != "winding":
        return [FAMILIES[name](seed)]
    problem = wo.WindingProblem.example()
    factor = 1 + 0.05 * np.random.default_rng(seed).uniform(-1, 1)
    return [problem.replace(nip_load=factor * problem.nip_load)]


def solve_all(problems: Problems) -> Callable[[], object]:
    """Return the solution of the last problem; of several, of all but the first by warm starts."""
    solved = wo.solve(problems[0]) if len(problems) > 1 else None

    def work() -> None:
        start = solved
        for problem in problems[1:] or problems:
            start = wo.solve(problem, start=start) if start else wo.solve(problem)

    return work


def differentiate(problems: Problems) -> Callable[[], object]:
    """Return the derivatives of a nip with respect to all inputs."""
    return wo.solve(problems[0]).sensitivity


WORK = [*FAMILIES, "neighbours", "sensitivities", "winding"]


# ---- problems as data, which both versions read -------------------------------------------------


def encode(value: Any) -> Any:
    """Return a problem, or a part of it, as JSON data: its class and the fields without default."""
    if isinstance(value, tuple | list):
        return [encode(item) for item in value]
    if not hasattr(type(value), "model_fields"):
        return value
    fields = {
        name: encode(getattr(value, name))
        for name, field in type(value).model_fields.items()
        if getattr(value, name) != field.get_default() or name == "roll_wrap"
    }
    return {"class": type(value).__name__, "fields": fields}


def decode(data: Any) -> Any:
    """Return the object of this version; version 0.2 has a class for each kind of nip."""
    if isinstance(data, list):
        return [decode(item) for item in data]
    if not isinstance(data, dict):
        return data
    name, fields = data["class"], {key: decode(value) for key, value in data["fields"].items()}
    if name == "PronyTerm":
        return tuple(fields.values())
    if name == "NipProblem" and hasattr(wo, "WrappedNipProblem"):
        if "air" in fields:
            name = "AirNipProblem"
        elif fields["roll_wrap"]:
            name = "WrappedNipProblem"
        else:
            del fields["roll_wrap"]
    return getattr(wo, name)(**fields)


def serve() -> None:
    """Answer lines [work, problems] with the seconds, or null for a problem that is rejected."""
    answers, sys.stdout = sys.stdout, sys.stderr
    warnings.simplefilter("ignore")
    baseline = Baseline()
    for line in sys.stdin:
        name, data = json.loads(line)
        try:
            before, problems = baseline.once(), decode(data)
            work = differentiate(problems) if name == "sensitivities" else solve_all(problems)
            seconds = timed(work)
            answer = [seconds, (before + baseline.once()) / 2]
        except (wo.InvalidProblem, wo.NoSteadyState, wo.NotConverged):
            answer = [None, None]
        print(json.dumps(answer), file=answers, flush=True)


class Version:
    """A process with one version of the program."""

    def __init__(self, python: str, source: Path) -> None:
        path = os.pathsep.join([str(source), str(HERE.parent)])
        self.process: Any = subprocess.Popen(
            [python, str(HERE), "--serve"], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
            text=True, env=os.environ | {"PYTHONPATH": path},
        )  # fmt: skip

    def seconds(self, name: str, data: Any) -> tuple[float, float] | None:
        """Return the processor times of a work on encoded problems, and of a dense solve."""
        lines: tuple[IO[str], IO[str]] = (self.process.stdin, self.process.stdout)
        lines[0].write(json.dumps([name, data]) + "\n")
        lines[0].flush()
        spent, unit = json.loads(lines[1].readline())
        return None if spent is None else (spent, unit)

    def close(self) -> None:
        """End the process."""
        self.process.stdin.close()
        self.process.wait()


def measured(versions: list[Version], name: str, cases: int, first: int) -> list[list[float]]:
    """Return the times of all versions, and of the dense solve, case by case."""
    rows = []
    for k in range(-1, cases):
        try:
            data = encode(draw(name, first + k if k >= 0 else WARM_UP))
        except wo.InvalidProblem:
            continue
        # the version that begins alternates
        order = range(len(versions)) if k % 2 else reversed(range(len(versions)))
        found = {i: versions[i].seconds(name, data) for i in order}
        both = [pair for _, pair in sorted(found.items()) if pair is not None]
        if k >= 0 and len(both) == len(versions):
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
