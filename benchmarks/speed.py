"""Time of two revisions of the program, in pairs in one run, in units of a dense solve.

    python benchmarks/speed.py                           this revision against version 0.2
    python benchmarks/speed.py --against eb946eac        against any other revision
    python benchmarks/speed.py readme command --cases 20 some kinds of work
    python benchmarks/speed.py --at FOLDER --offline     options of version_0_2.py
    python benchmarks/speed.py --alone                   without another revision

Two processes, one with each revision, solve the same problems in turns: a busy machine slows both.
Each solves a problem of its kind once before; bodies are new in each case, so that their
influence functions are part of the time.  Times are processor times of one thread; the unit d is a
dense LU solution of 398 x 398, the size of the thesis's system, in the same process.  Another
revision than 0.2 uses the packages of this environment.

    plain ... hardening   a solution with the default options (random_nips.py)
    two_nips, three_nips  the same, with --alone: earlier revisions have no further nips; wrapped
                          has the same nips without them
    carter                the example of two rollers
    readme                the wrapped nip of the README, radii up to 0.1 % apart
    neighbours            three wrapped nips, each with start= the one before, 1 to 5 % apart
    sensitivities         derivatives of a plain nip with respect to all inputs
    nip_and_derivatives   the same with the solution of the nip
    winding               the example of a winding, with other loads
    example_winding       the example of a winding
    scheduled_winding     newsprint of 45 g/m2, 1.25 m on 3 in, taper 20 %, a table of nip loads
    roll                  the example of a roll, with other tensions
    lanes_of_roll         the same with 50 lanes across the width, for a band of 0.8 %; at most 15
                          times roll is requested
    lanes_of_winding      winding with the same lanes; at most 30 times winding is requested
    two_drum_winding      newsprint on two drums, with --alone; one_drum_winding has the same loads
                          and forces of its rear drum alone
    loose                 the README's nip with rtol = 1e-2, to be compared with readme
    two_processes         wall-clock time of a nip in a sweep of 600 with 33 nodes on two processes
    sweep                 20 wrapped nips, five loads and four shear moduli, for each of them
    replace               1000 copies of the README's nip with another load, for each of them
    fit                   the friction of the README's nip without wrap from three measured tensions
    find                  the nip load of the README's nip for a wound-on tension
    window                operating window of the example of a winding, with one uncertain input
    scheduled_window      the same of the winding with schedules
    command               woundon solve examples/newsprint_table2.toml, from start to answer
"""

from __future__ import annotations

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import json
import resource
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
ROOT = HERE.parents[1]
# cases by default
SLOW = {
    "hardening": 10,
    "winding": 5,
    "roll": 20,
    "lanes_of_roll": 20,
    "lanes_of_winding": 3,
    "example_winding": 3,
    "scheduled_winding": 3,
    "one_drum_winding": 1,
    "two_drum_winding": 1,
    "carter": 20,
    "readme": 20,
    "loose": 20,
    "two_processes": 3,
    "sweep": 5,
    "window": 1,
    "scheduled_window": 1,
    "command": 10,
}
# what earlier revisions have not
NEW = ("two_nips", "three_nips", "one_drum_winding", "two_drum_winding")
SWEPT = 20  # nips of a sweep
COPIES = 1000
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


def processor_time() -> float:
    """Return the processor time of this process and of those that it has ended [s]."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.process_time() + used.ru_utime + used.ru_stime


def timed(work: Callable[[], object], clock: Callable[[], float] = processor_time) -> float:
    """Return the time of a call [s]."""
    start = clock()
    work()
    return clock() - start


# ---- the work -----------------------------------------------------------------------------------


Problems = list[Any]


def draw(name: str, seed: int) -> Problems:
    """Return the problems of a kind of work; random ones but for the examples."""
    if name == "neighbours":
        return random_wrapped_neighbours(seed)
    if name in ("sensitivities", "nip_and_derivatives"):
        return [random_nip(seed)]
    if name in FAMILIES:
        return [FAMILIES[name](seed)]
    if name == "carter":
        return [wo.RollerProblem.example()]
    change = np.random.default_rng(seed).uniform(-1, 1)
    if not name.endswith(("winding", "window", "roll")):
        nip = wo.NipProblem.example()
        return [nip.replace(**{"roll.radius": nip.roll.radius * (1 + 0.001 * change)})]
    if name.startswith("scheduled"):
        return [scheduled_winding()]
    lanes = {"thickness_profile": band()} if name.startswith("lanes") else {}
    if name.endswith("roll"):
        tension = 350 * (1 + 0.05 * change)
        return [wo.RollProblem.example().replace(wound_on_tension=tension, **lanes)]
    if name == "two_drum_winding":
        return [two_drum_winding()]
    if name == "one_drum_winding":
        return [on_rear_drum(two_drum_winding())]
    problem = wo.WindingProblem.example()
    factor = 1 + 0.05 * change if name in ("winding", "lanes_of_winding") else 1.0
    return [problem.replace(nip_load=factor * problem.nip_load, **lanes)]


def band() -> wo.ThicknessProfile:
    """Return the thickness of a web of 2 m with a band of 0.8 %, 0.2 m wide."""
    y = np.linspace(0.0, 2.0, 201)
    return wo.ThicknessProfile(position=y, thickness=1 + 0.008 * (np.abs(y - 1.2) < 0.1))


def scheduled_winding() -> wo.WindingProblem:
    """Return a winding of newsprint whose web tension and nip load vary over the radius."""
    loads = wo.Profile(
        radius=[0.0381, 0.15, 0.3, 0.45, 0.625], value=[3000.0, 2500.0, 2000.0, 1800.0, 1600.0]
    )
    return wo.WindingProblem.example().replace(
        radius=0.625, web_tension=wo.Taper(start=350.0, taper=0.2), nip_load=loads,
        **{"core.radius": 0.0381},
    )  # fmt: skip


def two_drum_winding() -> wo.WindingProblem:
    """Return a winding of newsprint on two drums, with a constant load of the rider."""
    winder = wo.TwoDrums(front_drum=wo.Rigid(radius=0.25), gap=0.02, rider_load=2500.0)
    return wo.WindingProblem.example().replace(
        radius=0.6, winder=winder, drum=wo.Rigid(radius=0.3), nip_load=None, torque_split=0.5,
        density=680.0, web_tension=300.0,
    )  # fmt: skip


def on_rear_drum(winding: wo.WindingProblem) -> wo.WindingProblem:
    """Return the winding with the rear drum of a two-drum winder alone."""
    radii = np.linspace(winding.core.radius, winding.radius, 60)
    loads = wo.Profile(radius=radii, value=winding.drum_loads(radii).rear_load)
    return winding.replace(winder=None, nip_load=loads)


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


def solve_and_differentiate(problems: Problems) -> Callable[[], object]:
    """Return the solution of a nip and its derivatives with respect to all inputs."""
    return lambda: wo.solve(problems[0]).sensitivity()


def sweep(problems: Problems) -> Callable[[], object]:
    """Return a sweep of a nip over its load and the shear modulus of its roll, in this process."""
    nip = problems[0]
    over = {
        "nip_load": nip.nip_load * np.linspace(0.8, 1.2, 5),
        "roll.material.shear": nip.roll.material.shear * np.linspace(0.9, 1.2, SWEPT // 5),
    }
    return lambda: wo.sweep(nip, over, workers=1)


def sweep_on_two_processes(problems: Problems) -> Callable[[], object]:
    """Return a sweep of a nip over 30 loads and 20 shear moduli, with 33 nodes."""
    nip = problems[0]
    over = {
        "nip_load": nip.nip_load * np.linspace(0.5, 1.5, 30),
        "roll.material.shear": nip.roll.material.shear * np.linspace(0.8, 1.3, 20),
    }
    return lambda: wo.sweep(nip, over, nodes=33, workers=2)


def solve_loosely(problems: Problems) -> Callable[[], object]:
    """Return the solution of a nip with a loose tolerance."""
    return lambda: wo.solve(problems[0], rtol=1e-2)


def replace(problems: Problems) -> Callable[[], object]:
    """Return the construction of copies of a nip with other loads."""
    nip = problems[0]
    loads = nip.nip_load * np.linspace(0.8, 1.2, COPIES)
    return lambda: [nip.replace(nip_load=float(load)) for load in loads]


def fit(problems: Problems) -> Callable[[], object]:
    """Return the fit of a nip's friction."""
    nip = problems[0].replace(roll_wrap=0.0)
    measured = {"nip_load": [900.0, 1800.0, 3500.0], "wound_on_tension": [430.0, 500.0, 600.0]}
    return lambda: wo.fit(nip, measured, ["roll_friction"], nodes=25, workers=1)


def find(problems: Problems) -> Callable[[], object]:
    """Return the search for the load of a nip with a given wound-on tension."""
    return lambda: wo.find(problems[0], "nip_load", wound_on_tension=600.0, nodes=25)


def window(problems: Problems) -> Callable[[], object]:
    """Return the operating window of a winding with one limit and one uncertain input."""
    winding = problems[0].replace(limits=wo.Limits(core_pressure="2 MPa"))
    options = {"uncertain": {"roll_friction": 0.1}, "samples": 128, "workers": 1}
    return lambda: wo.operating_window(winding, (200.0, 400.0), (1000.0, 4000.0), **options)


def run_command(problems: Problems) -> Callable[[], object]:
    """Return the command line that solves the case file of the README's nip."""
    command = [sys.executable, "-m", "woundon", "solve", "examples/newsprint_table2.toml"]
    # compiled modules are kept, as in an installed program
    env = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    return lambda: subprocess.run(command, cwd=ROOT, env=env, check=True, stdout=subprocess.DEVNULL)


METHODS: dict[str, Callable[[Problems], Callable[[], object]]] = {
    "sensitivities": differentiate,
    "nip_and_derivatives": solve_and_differentiate,
    "sweep": sweep,
    "two_processes": sweep_on_two_processes,
    "loose": solve_loosely,
    "replace": replace,
    "fit": fit,
    "find": find,
    "window": window,
    "scheduled_window": window,
    "command": run_command,
}
WORK = [
    *FAMILIES, "carter", "readme", "neighbours", "sensitivities", "nip_and_derivatives", "winding",
    "example_winding", "scheduled_winding", "one_drum_winding", "two_drum_winding", "roll",
    "lanes_of_roll", "lanes_of_winding", "loose", "sweep", "two_processes", "replace", "fit",
    "find", "window", "scheduled_window", "command",
]  # fmt: skip


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
            clock = time.perf_counter if name == "two_processes" else processor_time
            seconds = timed(METHODS.get(name, solve_all)(problems), clock)
            seconds /= {"sweep": SWEPT, "two_processes": 600, "replace": COPIES}.get(name, 1)
            answer = [seconds, (before + baseline.once()) / 2]
        except (wo.InvalidProblem, wo.NoSteadyState, wo.NotConverged):
            answer = [None, None]
        print(json.dumps(answer), file=answers, flush=True)


def source_of(revision: str) -> Path:
    """Return the sources of a revision, in a worktree of this repository."""
    git = ["git", "-C", str(ROOT)]
    command = [*git, "rev-parse", "--verify", f"{revision}^{{commit}}"]
    commit = subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip()
    tree = ROOT / ".revisions" / commit
    if not tree.is_dir():
        # --force: a worktree whose folder was deleted stays registered
        create = ["worktree", "add", "--force", "--quiet", "--detach", str(tree), commit]
        subprocess.run([*git, *create], check=True)
    return tree / "src"


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
    """Return for each case the times of all versions, then those of their dense solves."""
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
            rows.append([*(spent for spent, _ in both), *(unit for _, unit in both)])
    return rows


def main() -> int:
    """Print the table."""
    options = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    options.add_argument("work", nargs="*", choices=[*WORK, []], help="kinds of work; all if none")
    options.add_argument("--cases", type=int, help="cases of each")
    options.add_argument("--first", type=int, default=0, help="first seed")
    options.add_argument("--against", default="0.2", help="revision to compare with")
    options.add_argument("--alone", action="store_true", help="without another revision")
    options.add_argument("--at", type=Path, default=version_0_2.TREE, help="worktree of 0.2")
    options.add_argument("--offline", action="store_true", help="0.2 uses these packages")
    options.add_argument("--serve", action="store_true", help=argparse.SUPPRESS)
    given = options.parse_args()
    if given.serve:
        serve()
        return 0
    versions = [Version(sys.executable, Path(wo.__file__).parents[1])]
    if given.against != "0.2" and not given.alone:
        versions.append(Version(sys.executable, source_of(given.against)))
    elif not given.alone:
        tree = given.at.resolve()
        version_0_2.create(tree, offline=given.offline)
        versions.append(Version(str(version_0_2.python(tree)), version_0_2.source(tree)))
    print(f"| work | cases | ms, median | d | of {given.against}: ms | d | ratio, median | 90 % |\n"
          "|---|---|---|---|---|---|---|---|")  # fmt: skip
    units: list[float] = []
    others = [name for name in WORK if given.alone or name not in NEW]
    for name in given.work or others:
        cases = given.cases or SLOW.get(name, CASES)
        times = np.array(measured(versions, name, cases, given.first))
        if not times.size:
            print(f"| {name} | 0 |  |  |  |  |  |  |")
            continue
        spent, unit = np.split(times, 2, axis=1)
        units += [*unit[:, 0]]
        pairs = zip(np.median(spent, axis=0), np.median(spent / unit, axis=0), strict=True)
        cells = [f"{1e3 * median:.3g} | {dense:.3g}" for median, dense in pairs]
        if len(versions) > 1:
            ratio = spent[:, 0] / spent[:, 1]
            cells.append(f"{np.median(ratio):.2f} | {np.quantile(ratio, 0.9):.2f}")
        print(f"| {name} | {len(times)} | {' | '.join(cells)} |", flush=True)
    print(f"\nd = {1e3 * np.median(units):.3g} ms")
    for version in versions:
        version.close()
    return 0


if __name__ == "__main__":
    sys.exit(main())
