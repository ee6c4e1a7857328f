"""Two source trees against each other: the same jobs, in turns, in one run.

    python benchmarks/paired.py OLD/src NEW/src
    python benchmarks/paired.py OLD/src NEW/src --only rollers --sessions 9

Each tree has a process of its own, one thread, that is told over a pipe what to do; the two take
turns, A B, B A, so that a busy machine slows both.  Processor time is taken.  Processes are started
anew some times, because where the memory lies makes one a percent or two faster than its twin.  The
ratio of a job is the median over all turns of new over old; what it is known to is its standard
error, from the sessions' own medians.  Ends with 1 if a ratio is above the limit by more than two
of these.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from math import pi
from pathlib import Path
from typing import Any

import numpy as np

ENOUGH = 0.03  # seconds of a turn; short jobs are repeated
ENVIRONMENT = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "PYTHONHASHSEED": "0"}
CASE = """schema = 1
nip_load = "3502 N/m"
web_tension = "350 N/m"
roll_friction = 0.19
drum_friction = 0.20
[web]
thickness = "66 um"
material = "newsprint"
[roll]
kind = "cylinder"
radius = "100 mm"
core_radius = "44.5 mm"
material = "newsprint"
[drum]
kind = "rigid"
radius = "76.2 mm"
"""

Work = Callable[[], object]
Prepare = Callable[[np.random.Generator], Work]


# ---- the jobs, in the process of a tree ----------------------------------------------------------


def jobs() -> dict[str, Prepare]:
    """Return the jobs by name: each prepares, untimed, the work that is timed.

    No two are quite the same, so that nothing is just remembered.
    """
    import woundon as wo

    paper = wo.Orthotropic(radial=20e6, tangential=3e9, cross=5e6, shear=10e6)
    cover = wo.Isotropic(youngs_modulus=10e6, poissons_ratio=0.1)
    steel = wo.HalfPlane(
        radius=0.25, material=wo.Isotropic(youngs_modulus=206e9, poissons_ratio=0.3)
    )
    bare = wo.NipProblem(
        web=wo.Web(thickness=66e-6, material=paper),
        roll=wo.Cylinder(radius=0.3, core_radius=0.05, material=paper),
        drum=wo.Rigid(radius=0.5), roll_friction=0.2, drum_friction=0.4,
        nip_load=1900.0, winding_force=100.0, web_tension=500.0,
    )  # fmt: skip
    half_plane = bare.replace(roll=wo.HalfPlane(radius=0.3, material=paper))
    covered = bare.replace(drum=wo.Cylinder(radius=0.5, core_radius=0.48, material=cover))
    carter = wo.RollerProblem(
        upper=steel, lower=steel, load=89e3, friction=0.5, tangential_load=8.4e3
    )
    neighbour = wo.solve_nip(half_plane)

    def nip(problem: Any, **options: Any) -> Prepare:
        def prepare(random: np.random.Generator) -> Work:
            other = problem.replace(nip_load=problem.nip_load * random.uniform(0.99, 1.01))
            return lambda: wo.solve_nip(other, **options)

        return prepare

    def new_radii(random: np.random.Generator) -> Work:
        factor = 1 + 1e-3 * random.uniform()  # never met before
        radii = {"roll.radius": 0.3 * factor, "drum.radius": 0.5 * factor}
        other = covered.replace(**radii)
        return lambda: wo.solve_nip(other, nodes=65)

    def wrapped(**wrap: float) -> Prepare:
        def prepare(random: np.random.Generator) -> Work:
            other = bare.replace(nip_load=1900 * random.uniform(0.99, 1.01))
            return lambda: wo.solve_wrapped_nip(other, nodes=65, **wrap)

        return prepare

    def rollers(nodes: int) -> Prepare:
        def prepare(random: np.random.Generator) -> Work:
            other = carter.replace(load=89e3 * random.uniform(0.99, 1.01))
            return lambda: wo.solve_rollers(other, nodes=nodes)

        return prepare

    def sensitivity(random: np.random.Generator) -> Work:
        other = covered.replace(nip_load=1900 * random.uniform(0.99, 1.01))
        return wo.solve_nip(other, nodes=65).sensitivity

    def sweep(random: np.random.Generator) -> Work:
        loads = np.linspace(500.0, 5000.0, 25) * random.uniform(0.99, 1.01)
        over = {"nip_load": loads.tolist(), "roll_friction": [0.15, 0.2, 0.25, 0.3]}
        return lambda: wo.sweep(bare, over, ("nip_induced_tension", "half_width"), workers=1)

    return {
        "half-plane roll, hard drum, default nodes": nip(half_plane),
        "the same, started from the load before": nip(half_plane, start=neighbour),
        "cylinder roll, hard drum, default nodes": nip(bare),
        "cylinder roll, 20 mm cover, default nodes": nip(covered),
        "cylinder roll, 20 mm cover, 65 nodes": nip(covered, nodes=65),
        "the same, new radii": new_radii,
        "wrapped on the roll, 65 nodes": wrapped(),
        "wrapped on roll and drum, 65 nodes": wrapped(drum_wrap=pi / 2),
        "two rollers, 101 nodes": rollers(101),
        "two rollers, 401 nodes": rollers(401),
        "sensitivities, 20 mm cover, 65 nodes": sensitivity,
        "sweep of 100 cases, one process": sweep,
    }


def serve() -> None:
    """Do the jobs asked for on standard input, (name, times, seed); answer with seconds each."""
    known = jobs()
    print(json.dumps(list(known)), flush=True)
    for line in sys.stdin:
        name, times, seed = json.loads(line)
        random, spent = np.random.default_rng(seed), 0.0
        for _ in range(times):
            work = known[name](random)
            start = time.process_time()
            work()
            spent += time.process_time() - start
        print(json.dumps(spent / times), flush=True)


class Tree:
    """A source tree with its process."""

    def __init__(self, source: Path) -> None:
        self.environment = os.environ | ENVIRONMENT | {"PYTHONPATH": str(source)}
        self.process = subprocess.Popen(
            [sys.executable, "-W", "ignore", __file__, "--serve"], env=self.environment,
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
        )  # fmt: skip
        self.jobs: list[str] = self._answer()

    def _answer(self) -> Any:
        assert self.process.stdout is not None
        return json.loads(self.process.stdout.readline())

    def seconds(self, name: str, times: int, seed: int) -> float:
        """Return the processor time of a job, the mean of some times; a seed draws the same."""
        assert self.process.stdin is not None
        print(json.dumps((name, times, seed)), file=self.process.stdin, flush=True)
        return float(self._answer())

    def whole_process(self, words: list[str]) -> float:
        """Return the processor time of a process from start to end."""
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run(
            [sys.executable, *words], env=self.environment, check=True, stdout=subprocess.DEVNULL
        )
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime

    def close(self) -> None:
        """End the process."""
        self.process.communicate()


# ---- turns ---------------------------------------------------------------------------------------

Clock = Callable[[Tree, int], float]


def clocks(old: Tree, case: str, only: str) -> Iterator[tuple[str, Clock]]:
    """Yield the name of every job, and what takes its time in a tree."""
    whole = {
        "import woundon": ["-c", "import woundon"],
        "import woundon and solve_nip": ["-c", "import woundon; woundon.solve_nip"],
        "woundon nip CASE": ["-m", "woundon", "nip", case],
    }
    for name in old.jobs:
        if only in name:
            old.seconds(name, 1, 0)  # what is made once and kept
            times = max(1, round(ENOUGH / old.seconds(name, 2, 1)))
            yield name, lambda tree, seed, name=name, times=times: tree.seconds(name, times, seed)
    for name, words in whole.items():
        if only in name:
            yield name, lambda tree, _, words=words: tree.whole_process(words)


def session(
    sources: tuple[Path, Path], case: str, only: str, turns: int
) -> dict[str, list[tuple[float, float]]]:
    """Return the seconds, old and new, of every turn of every job, both processes made anew."""
    old, new = trees = tuple(Tree(source) for source in sources)
    try:
        made = dict(clocks(old, case, only))
        for clock in made.values():
            clock(old, 0), clock(new, 0)
        found: dict[str, list[tuple[float, float]]] = {name: [] for name in made}
        for turn in range(turns):
            for name, clock in made.items():
                order = trees if turn % 2 == 0 else trees[::-1]
                spent = {id(tree): clock(tree, 2 + turn) for tree in order}
                found[name].append((spent[id(old)], spent[id(new)]))
    finally:
        for tree in trees:
            tree.close()
    return found


def _told(sessions: list[dict[str, list[tuple[float, float]]]], limit: float) -> bool:
    """Print the ratios; return whether all are within the limit, as far as they are known."""
    print(f"{'job':44} {'old ms':>8} {'new ms':>8} {'new/old':>8} {'+-':>6} {'sessions':>13}")
    good, medians = True, []
    for name in sessions[0]:
        ratios = [np.array([b / a for a, b in found[name]]) for found in sessions]
        each = np.array([np.median(r) for r in ratios])
        ratio = float(np.median(np.concatenate(ratios)))
        error = float(each.std(ddof=1) / np.sqrt(each.size)) if each.size > 1 else float("nan")
        spent = np.median(np.concatenate([np.array(found[name]) for found in sessions]), axis=0)
        slow = ratio - (2 * error if each.size > 1 else 0.0) > limit
        good, medians = good and not slow, [*medians, ratio]
        print(f"{name:44} {1e3 * spent[0]:8.2f} {1e3 * spent[1]:8.2f} {ratio:8.3f} {error:6.3f} "
              f"{each.min():6.3f} {each.max():6.3f}{'  SLOWER' * slow}")  # fmt: skip
    print(f"geometric mean {np.exp(np.mean(np.log(medians))):.3f}")
    return good


def main() -> int:
    """Compare two trees."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("sources", nargs="*", type=Path, help="src folders: old, new")
    options.add_argument("--only", default="", help="jobs whose name holds this text")
    options.add_argument("--sessions", type=int, default=5, help="fresh pairs of processes")
    options.add_argument("--turns", type=int, default=10, help="of each job in a session")
    options.add_argument("--limit", type=float, default=1.05, help="ratio that is accepted")
    options.add_argument("--serve", action="store_true", help=argparse.SUPPRESS)
    given = options.parse_args()
    if given.serve:
        serve()
        return 0
    if len(given.sources) != 2 or not all((s / "woundon").is_dir() for s in given.sources):
        options.error("two folders are needed that hold woundon: OLD/src NEW/src")
    old, new = (source.resolve() for source in given.sources)
    with tempfile.TemporaryDirectory() as folder:
        case = Path(folder) / "case.toml"
        case.write_text(CASE, encoding="utf-8")
        found = [session((old, new), str(case), given.only, given.turns)
                 for _ in range(given.sessions)]  # fmt: skip
    return 0 if _told(found, given.limit) else 1


if __name__ == "__main__":
    sys.exit(main())
