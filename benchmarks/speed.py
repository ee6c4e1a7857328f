"""How long things take, as multiples of one dense LU solve of 398 x 398 in the same run.

    python benchmarks/speed.py                          all tables
    python benchmarks/speed.py --write docs/tables      as files that docs/performance.md includes

398 x 398 is the thesis's system (M = 200, both faces).  One thread; processor time, so that a busy
machine matters little; each work between two solves of the baseline, medians of the ratios.
"""

from __future__ import annotations

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import csv
import resource
import subprocess
import sys
import time
import warnings
from collections.abc import Callable, Iterator
from importlib import resources
from math import pi
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from scipy.linalg import lu_factor, lu_solve

import woundon as wo
from jorkama2001 import procedure
from jorkama2001.cases import paper_nip

warnings.simplefilter("ignore", wo.ValidityWarning)
warnings.simplefilter("ignore", wo.ResolutionWarning)

PAPER = wo.material("paper")
COVER = wo.Cylinder(radius=0.5, core_radius=0.48, material=wo.material("soft-cover"))
HALF_PLANE_ROLL = paper_nip(roll=wo.HalfPlane(radius=0.3, material=PAPER))
COVERED = paper_nip(drum=COVER)
HYBRID = paper_nip(nip_load=1910.0, winding_force=-400.0)
# NIT [N/m] on elements, to 2e-8 (convergence.py)
LIMITS = {HALF_PLANE_ROLL: 134.753375, COVERED: 32.485679, HYBRID: -37.324869}

STEEL = wo.HalfPlane(radius=0.25, material=wo.material("steel"))
CARTER = wo.RollerProblem(
    upper=STEEL, lower=STEEL, load=89e3, tangential_load=8.4e3, friction=0.5, motion="rolling"
)

NEWSPRINT_ROLL = wo.WoundRollProblem.example()


class Baseline:
    """The dense solve that everything is measured by."""

    def __init__(self, size: int = 398) -> None:
        random = np.random.default_rng(0)
        self.matrix = random.normal(size=(size, size)) + size * np.eye(size)
        self.right = random.normal(size=size)
        self.seconds: list[float] = []

    def once(self) -> float:
        """Return the seconds of one solve."""
        self.seconds.append(_timed(lambda: lu_solve(lu_factor(self.matrix), self.right)))
        return self.seconds[-1]

    def ratio(self, work: Callable[[], object], repeats: int = 25) -> float:
        """Return the median of the work's time over the baseline's around it."""
        work()  # what is made once and kept
        ratios = []
        for _ in range(repeats):
            before = self.once()
            spent = _timed(work)
            ratios.append(2 * spent / (before + self.once()))
        return float(np.median(ratios))

    def in_turns(
        self, one: Callable[[], object], two: Callable[[], object], repeats: int = 25
    ) -> tuple[float, float, float]:
        """Return the medians of both works over the baseline's, and of the second over the first.

        They take turns, so that a busy machine slows both.
        """
        one(), two()
        times = [(_timed(one), _timed(two), self.once()) for _ in range(repeats)]
        first, second, dense = np.array(times).T
        ratios = first / dense, second / dense, second / first
        return tuple(float(np.median(part)) for part in ratios)  # type: ignore[return-value]


def _timed(work: Callable[[], object]) -> float:
    start = time.process_time()
    work()
    return time.process_time() - start


def _others(problem: Any) -> Iterator[Any]:
    """Yield the same nip with other loads, about one percent to either side."""
    random = np.random.default_rng(1)
    while True:
        yield problem.replace(nip_load=problem.nip_load * (1 + random.uniform(-0.01, 0.01)))


def _new_radii(problem: wo.NipProblem) -> Iterator[wo.NipProblem]:
    """Yield it with radii that were never met before."""
    random = np.random.default_rng(2)
    while True:
        factor = 1 + 1e-3 * random.uniform()
        fields = {"roll.radius": problem.roll.radius * factor,
                  "drum.radius": problem.drum.radius * factor}  # fmt: skip
        yield problem.replace(**fields)


def _error(problem: wo.NipProblem, tension: float) -> float:
    return abs(tension / LIMITS[problem] - 1)


def nip_table(baseline: Baseline) -> str:
    """Return the times of the nip."""
    rows = []
    for name, problem in (("half-plane roll, hard drum", HALF_PLANE_ROLL),
                          ("cylinder roll, 20 mm cover", COVERED)):  # fmt: skip
        for nodes in (None, 65):
            result = wo.solve_nip(problem, nodes=nodes)
            others, radii = _others(problem), _new_radii(problem)
            error = _error(problem, result.nip_induced_tension)
            label = f"{name}, {result.nodes} nodes{' chosen by the program' * (nodes is None)}"

            def other() -> object:
                return wo.solve_nip(next(others), nodes=nodes)  # noqa: B023

            def first() -> object:
                return wo.solve_nip(next(radii), nodes=nodes)  # noqa: B023

            def near() -> object:
                return wo.solve_nip(next(others), nodes=nodes, start=result)  # noqa: B023

            if problem is COVERED:
                rows.append((f"{label}: first call with new radii", baseline.ratio(first), error))
            rows.append((f"{label}: another load", baseline.ratio(other), error))
            rows.append((f"{label}: another load, `start=` its neighbour",
                         baseline.ratio(near), error))  # fmt: skip
            slopes = baseline.ratio(result.sensitivity, 9)
            rows.append((f"{label}: all its sensitivities", slopes, None))
    accurately = {"half-plane roll, hard drum": HALF_PLANE_ROLL, "hybrid winding": HYBRID,
                  "cylinder roll, 20 mm cover": COVERED}  # fmt: skip
    for name, problem in accurately.items():
        result, others = wo.solve_nip(problem, rtol=1e-6), _others(problem)
        label = f"{name}, `rtol=1e-6`, {result.nodes} nodes on {result.scheme}"

        def accurate() -> object:
            return wo.solve_nip(next(others), rtol=1e-6)  # noqa: B023

        error = _error(problem, result.nip_induced_tension)
        rows.append((f"{label}: another load", baseline.ratio(accurate, 9), error))
    head = "| work | dense solves | true error of NIT |\n|---|---|---|\n"
    return head + "".join(
        f"| {label} | {ratio:.1f} | {'' if error is None else f'{error:.1e}'} |\n"
        for label, ratio, error in rows
    )


def published_table(baseline: Baseline) -> str:
    """Compare with the published procedure."""
    head = (
        "| nip | procedure | dense solves | milliseconds here | NIT N/m | error |\n"
        "|---|---|---|---|---|---|\n"
    )
    text = head
    for name, problem in (("20 mm cover", COVERED), ("half-plane roll", HALF_PLANE_ROLL)):

        def published() -> procedure.ProcedureResult:
            return procedure.solve(problem, cold=True, load_tolerance=1e-6)  # noqa: B023

        tension = published().nip_induced_tension

        slow = baseline.ratio(published, 3)
        unit = 1e3 * float(np.median(baseline.seconds))
        text += (f"| {name} | published | {slow:.0f} | {slow * unit:.0f} | {tension:.3f} | "
                 f"{_error(problem, tension):.1e} |\n")  # fmt: skip
        for nodes in (65, None):
            result = wo.solve_nip(problem, nodes=nodes)

            def default() -> object:
                return wo.solve_nip(problem, nodes=nodes)  # noqa: B023

            quick = baseline.ratio(default)
            error = _error(problem, result.nip_induced_tension)
            gain = _error(problem, tension) / error
            label = f"{'default' if nodes is None else 'graded'}, {result.nodes} nodes"
            text += (
                f"| | {label}: {slow / quick:.0f} times faster, {gain:.0f} times more accurate | "
                f"{quick:.1f} | {quick * unit:.1f} | {result.nip_induced_tension:.3f} | "
                f"{error:.1e} |\n"
            )
    return text


def carter_table(baseline: Baseline) -> str:
    """Return times and errors of two rollers against Carter's closed form."""
    exact = wo.theories.carter(CARTER)
    text = ("| nodes | dense solves | traction L2 | nodal traction L2 | creepage |\n"
            "|---|---|---|---|---|\n")  # fmt: skip
    for nodes in (25, 51, 101, 200, 401):
        result = wo.solve_rollers(CARTER, nodes=nodes)
        known = exact.traction(result.x)
        miss = (result.traction - known) ** 2
        nodal = np.sqrt(miss.mean() / (known**2).mean())
        along = np.sqrt(np.trapezoid(miss, result.x) / np.trapezoid(known**2, result.x))
        ratio = baseline.ratio(lambda: wo.solve_rollers(CARTER, nodes=nodes), 9)  # noqa: B023
        creepage = abs(result.creepage / exact.creepage - 1)
        text += f"| {nodes} | {ratio:.1f} | {along:.1e} | {nodal:.1e} | {creepage:.1e} |\n"
    return text


def wrapped_table(baseline: Baseline) -> str:
    """Return the times of wrapped nips beside the plain one of the same bodies, next load."""
    text = ("| wrapped nip; another load, from its neighbour | plain | wrapped | ratio | asked "
            "| without a neighbour: plain | wrapped | ratio |\n"
            "|---|---|---|---|---|---|---|---|\n")  # fmt: skip
    for name, plain in (("hard drum", paper_nip(web_tension=350.0)),
                        ("20 mm cover", COVERED.replace(web_tension=350.0))):  # fmt: skip
        for both, asked in ((False, 2.5), (True, 4.0)):
            wrapped = plain.wrapped(roll_wrap=pi, drum_wrap=1.5 * both)
            near = baseline.in_turns(*(_next_load(nip, wo.solve(nip)) for nip in (plain, wrapped)))
            first = baseline.in_turns(*map(_next_load, (plain, wrapped)), repeats=15)
            label = f"{name}, {'both wraps' if both else 'wrapped on the roll'}"
            told = (f"{one:.1f} | {two:.1f} | {ratio:.1f}" for one, two, ratio in (near, first))
            text += f"| {label} | {f' | {asked} | '.join(told)} |\n"
    return text


def _next_load(problem: Any, start: Any = None) -> Callable[[], object]:
    """Return what solves it with another load, from a neighbour's solution or from nothing."""
    loads = _others(problem)
    return lambda: wo.solve(next(loads), start=start)


def rollers_table(baseline: Baseline) -> str:
    """Return the times of two equal rollers by nodes, and of Carter's traction to 3.5e-4."""
    text = "| nodes | dense solves | asked |\n|---|---|---|\n"
    for nodes, asked in ((150, "5 (traction L2 3.5e-4)"), (200, "6"), (401, ""), (800, "80")):
        ratio = baseline.ratio(lambda: wo.solve_rollers(CARTER, nodes=nodes), 9)  # noqa: B023
        text += f"| {nodes} | {ratio:.1f} | {asked} |\n"
    return text


def fit_table(baseline: Baseline) -> str:
    """Return what fits of two parameters to the 15 measured tensions cost, profiles and all."""
    path = resources.files("woundon") / "data" / "wound_on_tension_newsprint.csv"
    lines = [line for line in path.read_text("utf-8").splitlines() if not line.startswith("#")]
    rows = list(csv.DictReader(lines))
    measured = {name.removesuffix(" [N/m]"): [float(row[name]) for row in rows] for name in rows[0]}
    given = {name: measured[name] for name in ("nip_load", "web_tension")}
    vary = {"roll_friction": (0.05, 0.6), "roll.material.shear": (2e6, 1e8)}
    nip = wo.NipProblem.example()
    text = "| output | solves | dense solves | seconds here | asked |\n|---|---|---|---|---|\n"
    for output, problem in (("rig_tension", nip), ("wound_on_tension", nip.wrapped())):
        start = time.process_time()
        found = wo.fit(problem, given | {output: measured["measured"]}, vary)
        taken = time.process_time() - start
        dense = taken / float(np.median([baseline.once() for _ in range(15)]))
        text += f"| {output} | {found.solves} | {dense:.0f} | {taken:.1f} | 5 |\n"
    return text


def wound_roll_table(baseline: Baseline) -> str:
    """Return times and errors of wound rolls; errors by a solution to 1e-6."""
    stress, rolls = 350 / 66e-6, {}
    for laps, radius in ((1e3, 0.15), (1e5, 0.15), (1e5, 0.6)):
        thin = (radius - NEWSPRINT_ROLL.core.radius) / laps
        rolls[f"{laps:.0e} laps, {1e3 * radius:.0f} mm"] = NEWSPRINT_ROLL.replace(
            radius=radius, web_thickness=thin, wound_on_tension=stress * thin
        )
    tapered = wo.Taper(start=350.0, taper=0.4)
    rolls["newsprint, taper 40 %"] = NEWSPRINT_ROLL.replace(wound_on_tension=tapered)
    r = np.geomspace(0.0445, 0.15, 400)
    measured = wo.Profile(radius=r, value=350 * (r / 0.0445) ** -0.6)
    rolls["newsprint, tension at 400 radii"] = NEWSPRINT_ROLL.replace(wound_on_tension=measured)
    text = ("| roll | dense solves | stages | nodes | linear systems | error told | error |\n"
            "|---|---|---|---|---|---|---|\n")  # fmt: skip
    for name, roll in rolls.items():
        result, fine = wo.solve(roll), wo.solve(roll, rtol=3e-6)
        r = np.linspace(roll.core.radius, roll.radius, 2000)
        known = fine.at_radius(r)["pressure"]
        error = np.max(np.abs(result.at_radius(r)["pressure"] - known)) / known.max()
        own = result.errors["peak_pressure"] - np.abs(result.finite_laps).max()
        told = own / result.peak_pressure  # but for what finite laps change
        ratio = baseline.ratio(lambda: wo.solve(roll), 9)  # noqa: B023
        text += (f"| {name} | {ratio:.0f} | {result.stage_radius.size - 1} | {result.radius.size} "
                 f"| {result.steps} | {told:.1e} | {error:.1e} |\n")  # fmt: skip
    return text


def import_table() -> str:
    """Compare what it takes to start, whole processes by their processor time."""
    case = str(Path(__file__).parents[1] / "examples" / "newsprint_table2.toml")
    nip = [case, "--set", "wrap=none"]
    works = {
        "`import numpy`": ["-c", "import numpy"],
        "`import woundon`": ["-c", "import woundon"],
        "`import woundon` and all that `solve_nip` needs": [
            "-c",
            "import woundon as w; w.solve_nip",
        ],
        "`woundon --help`": ["-m", "woundon", "--help"],
        "`woundon nip CASE`": ["-m", "woundon", "nip", *nip],
        "`woundon solve CASE`, with its wraps": ["-m", "woundon", "solve", case],
    }
    spent: dict[str, list[float]] = {name: [] for name in works}
    with TemporaryDirectory() as folder:
        # compiled, as what is installed is; hence the first of ten rounds does not count
        compiled = {"PYTHONPYCACHEPREFIX": folder, "PYTHONDONTWRITEBYTECODE": ""}
        for _ in range(10):
            for name, words in works.items():
                before = _of_children()
                subprocess.run([sys.executable, *words], capture_output=True, check=True,
                               env={**os.environ, **compiled})  # fmt: skip
                spent[name].append(_of_children() - before)
    medians = {name: float(np.median(values[1:])) for name, values in spent.items()}
    unit = medians["`import numpy`"]
    text = "| process | milliseconds here | ratio |\n|---|---|---|\n"
    return text + "".join(
        f"| {name} | {1e3 * value:.0f} | {value / unit:.2f} |\n" for name, value in medians.items()
    )


def _of_children() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def main() -> int:
    """Print the tables, or write them."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--write", type=Path, help="folder for a file a table")
    options.add_argument("--only", nargs="+", help="names of the tables")
    given = options.parse_args()
    baseline = Baseline()
    tables: dict[str, Callable[[], str]] = {
        "nip": lambda: nip_table(baseline),
        "published": lambda: published_table(baseline),
        "wrapped": lambda: wrapped_table(baseline),
        "carter": lambda: carter_table(baseline),
        "rollers": lambda: rollers_table(baseline),
        "fit": lambda: fit_table(baseline),
        "wound_roll": lambda: wound_roll_table(baseline),
        "imports": import_table,
    }
    for name in given.only or tables:
        text = tables[name]()
        print(f"{name}\n\n{text}", flush=True)
        if given.write:
            given.write.mkdir(parents=True, exist_ok=True)
            (given.write / f"speed_{name}.md").write_text(text, encoding="utf-8")
    print(f"baseline: {1e3 * float(np.median(baseline.seconds or [np.nan])):.2f} ms")
    return 0


if __name__ == "__main__":
    sys.exit(main())
