"""Ten thousand random nips: is each solved, is every law kept, is the answer the only one?

    python benchmarks/campaign.py --cases 10000 --workers 2
    python benchmarks/campaign.py --of wrapped --cases 500
    python benchmarks/campaign.py --of rollers --cases 500
    python benchmarks/campaign.py --two-starts 500

Each writes a table with a row a case (out/campaign_nips.csv, out/two_starts.csv), part by part:
stopped and called again it goes on.  The seed makes the case (random_nips.py); what failed says
why.  Times are the processor's, in dense solves of 398 x 398 in the same process.
"""

from __future__ import annotations

import os

# one thread a process, and before NumPy is loaded: matrices are small
os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import re
import sys
import time
import warnings
from collections import Counter
from collections.abc import Callable
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np
from hardening import dense_solve
from random_nips import flat_fields, random_nip, random_rollers, random_wrapped_nip
from table_run import Row, run_table

import woundon as wo
from woundon.contact.pivoting import solve_stick_slip
from woundon.contact.schemes import SCHEMES
from woundon.contact.stick_slip import Ending
from woundon.nip.equations import NipEquations

warnings.simplefilter("ignore", wo.ValidityWarning)
warnings.simplefilter("ignore", wo.ResolutionWarning)

RESIDUAL = 1e-8
REFUSED = ("InvalidProblem", "NoSteadyState")
NODES = 65  # of the compared cases; left free, different starts may choose different grids
SAME = 1e-7  # of mu+ P: loads are carried to 3e-9, states are the same to the last node

MAKES: dict[str, Callable[[int], Any]] = {
    "nips": random_nip, "wrapped": random_wrapped_nip, "rollers": random_rollers
}  # fmt: skip
OUTPUTS = (
    "main", "error", "half_width", "residual", "law", "iterations", "milliseconds", "dense",
    "warnings", "failure",
)  # fmt: skip
STARTS = ("other case", "all forward", "all backward", "all stick", "random", "twice the width")
COMPARED = ("nip_induced_tension", "tension_difference", "states_differ", "traction_difference",
            "failure")  # fmt: skip


def solved(seed: int, of: str = "nips") -> Row:
    """Return a row of the campaign."""
    row: Row = {}
    try:
        problem = MAKES[of](seed)
        row |= flat_fields(problem.model_dump())
        start = time.process_time()
        result = wo.solve(problem)
    except Exception as fault:  # whatever it is, it is a finding
        return row | {"failure": f"{type(fault).__name__}: {fault}"}
    seconds, name = time.process_time() - start, next(iter(type(result).MAIN), "half_width")
    return row | {
        "main": getattr(result, name),
        "error": result.errors.get(name, ""),
        "half_width": result.half_width,
        "residual": result.residuals.largest,
        "law": result.residuals.worst,
        "iterations": result.iterations,
        "milliseconds": round(1e3 * seconds, 2),
        "dense": round(seconds / _unit(), 2),
        "warnings": len(result.warnings),
    }


@cache
def _unit() -> float:
    """Return the processor time of a dense solve in this process [s]."""
    return dense_solve()


def inputs(of: str) -> list[str]:
    """Return the names of the fields of all bodies that a family's cases have."""
    found = (name for seed in range(60) for name, _ in flat_fields(MAKES[of](seed).model_dump()))
    return list(dict.fromkeys(found))


def compared(seed: int) -> Row:
    """Return how much the answers from different starts differ."""
    problem = random_nip(seed)
    try:
        cold = wo.solve_nip(problem, nodes=NODES)
        tension, states, traction = _whole_solver(seed, cold)
        more_states, more_traction = _last_grid(seed, cold)
    except Exception as fault:
        return {"failure": f"{type(fault).__name__}: {fault}"}
    return {
        "nip_induced_tension": cold.nip_induced_tension,
        "tension_difference": tension,
        "states_differ": max(states, more_states),
        "traction_difference": max(traction, more_traction),
    }


def _whole_solver(seed: int, cold: wo.NipResult) -> tuple[float, int, float]:
    """Solve from other results and zones through ``start=``, width and all."""
    problem = cold.problem
    tension, states, traction = 0.0, 0, 0.0
    for name in STARTS:
        start = _start(name, seed, cold)
        again = wo.solve_nip(problem, nodes=NODES, start=start)
        change = abs(again.nip_induced_tension - cold.nip_induced_tension)
        tension = max(tension, change / (problem.roll_friction * problem.nip_load))
        states = max(states, int(np.count_nonzero(_zones(again) != _zones(cold))))
        traction = max(traction, _change(_tractions(again), _tractions(cold)))
    return tension, states, traction


def _start(name: str, seed: int, cold: wo.NipResult) -> wo.NipResult:
    if name == "other case":
        return wo.solve_nip(random_nip(10**6 + seed), nodes=33)
    if name == "twice the width":
        return cold.replace(half_width=2 * cold.half_width, x=2 * cold.x)
    size = cold.nodes
    random = np.random.default_rng(seed).integers(-1, 2, (2, size)).astype(np.int8)
    state = {"all forward": 1, "all backward": -1, "all stick": 0}.get(name)
    zones = random if state is None else np.full((2, size), state, dtype=np.int8)
    return cold.replace(roll_zone=zones[0], drum_zone=zones[1])


def _last_grid(seed: int, cold: wo.NipResult) -> tuple[int, float]:
    """Solve stick and slip of the last grid from states that have nothing to do with it."""
    mesh = SCHEMES["graded"].mesh(cold.nodes)
    equations = NipEquations.at(cold.problem, mesh, cold.half_width).stick_slip()
    expected = np.concatenate([cold.roll_zone[1:-1], cold.drum_zone[1:-1]])
    traction = np.concatenate([cold.roll_traction[1:-1], cold.drum_traction[1:-1]])
    random = np.random.default_rng(seed)
    starts = [np.full(expected.size, s, dtype=np.int8) for s in (0, 1, -1)]
    starts += [random.integers(-1, 2, expected.size).astype(np.int8) for _ in range(2)]
    states, change = 0, 0.0
    for start in starts:
        found = solve_stick_slip(equations, start)
        if found.ending is not Ending.SOLVED:
            raise wo.NotConverged(f"not found on the last grid: {found.ending.name}")
        states = max(states, int(np.count_nonzero(found.state != expected)))
        change = max(change, _change(found.traction, traction))
    return states, change


def _zones(result: wo.NipResult) -> np.ndarray:
    return np.concatenate([result.roll_zone, result.drum_zone])


def _tractions(result: wo.NipResult) -> np.ndarray:
    return np.concatenate([result.roll_traction, result.drum_traction])


def _change(one: np.ndarray, other: np.ndarray) -> float:
    return float(np.max(np.abs(one - other)) / np.max(np.abs(other)))


def report_campaign(rows: list[dict[str, str]]) -> str:
    """Return the campaign's summary as Markdown."""
    refused = [row for row in rows if row["failure"].startswith(REFUSED)]
    failed = [row for row in rows if row["failure"] and row not in refused]
    good = [row for row in rows if not row["failure"]]
    worst = max(good, key=lambda row: float(row["residual"]))
    systems = np.array([float(row["iterations"]) for row in good])
    times, units = (
        np.array([float(row[key]) for row in good]) for key in ("milliseconds", "dense")
    )
    loose = sum(float(row["residual"]) > RESIDUAL for row in good)
    lines = [
        ("cases", f"{len(rows)}"),
        *([("refused", f"{len(refused)}")] if refused else []),
        ("exceptions", f"{len(failed)}"),
        ("a residual above 1e-8", f"{loose}"),
        ("largest residual", f"{float(worst['residual']):.1e} ({worst['law'].replace('_', ' ')}, "
                             f"seed {worst['seed']})"),
        ("linear systems: median, 99 %, most", _spread(systems)),
        ("milliseconds: median, 99 %, most", _spread(times)),
        ("dense solves of 398 x 398: median, 99 %, most", _spread(units)),
        ("with a validity warning", f"{sum(int(row['warnings']) > 0 for row in good)}"),
    ]  # fmt: skip
    text = "| | |\n|---|---|\n" + "".join(f"| {name} | {value} |\n" for name, value in lines)
    reasons = Counter(_reason(row["failure"]) for row in refused)
    text += "".join(f"\n- refused, {count}: {reason}" for reason, count in reasons.items())
    return text + _failures(failed)


def _reason(failure: str) -> str:
    """Return what a refusal says, without its numbers."""
    return re.sub(r"-?\d[\d.e+-]*", "#", failure.splitlines()[0].partition(": ")[2])


def report_two_starts(rows: list[dict[str, str]]) -> str:
    """Return the summary of the different starts as Markdown."""
    failed = [row for row in rows if row["failure"]]
    good = [row for row in rows if not row["failure"]]
    tension = max(good, key=lambda row: float(row["tension_difference"]))
    other = [row["seed"] for row in good if float(row["tension_difference"]) > SAME]
    nodes = [row["seed"] for row in good if int(row["states_differ"])]
    lines = [
        ("cases", f"{len(rows)}"),
        ("starts each", f"{len(STARTS)} of the whole solver, 5 of the last grid"),
        ("exceptions", f"{len(failed)}"),
        ("largest difference of NIT, of mu+ P", f"{float(tension['tension_difference']):.1e} "
                                                f"(seed {tension['seed']})"),
        (f"cases with NIT further apart than {SAME:g} mu+ P", _named(other)),
        ("cases with a node in another state", _named(nodes)),
        ("largest difference of a traction, of the largest",
         f"{max(float(row['traction_difference']) for row in good):.1e}"),
    ]  # fmt: skip
    text = "| | |\n|---|---|\n" + "".join(f"| {name} | {value} |\n" for name, value in lines)
    return text + _failures(failed)


def _named(seeds: list[str]) -> str:
    return f"{len(seeds)}" + (f": seeds {', '.join(seeds[:20])}" if seeds else "")


def _spread(values: np.ndarray) -> str:
    return ", ".join(f"{np.quantile(values, part):.3g}" for part in (0.5, 0.99, 1.0))


def _failures(failed: list[dict[str, str]]) -> str:
    reasons = Counter(row["failure"].split(":")[0] for row in failed)
    seeds = "".join(f"- seed {row['seed']}: {row['failure'].splitlines()[0]}\n" for row in failed)
    return f"\n{', '.join(f'{n} {name}' for name, n in reasons.items())}\n\n{seeds}" * bool(failed)


def main() -> int:
    """Run; return 1 if a case failed."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--of", choices=MAKES, default="nips")
    options.add_argument("--cases", type=int, default=0, help="random cases, seeds from --first")
    options.add_argument("--two-starts", type=int, default=0, help="cases solved from many starts")
    options.add_argument("--first", type=int, default=0, help="first seed")
    options.add_argument("--workers", type=int, default=1, help="processes")
    options.add_argument("--folder", type=Path, default=Path("out"), help="where the tables go")
    given = options.parse_args()
    faults = 0
    for count, name, columns, work, report in (
        (
            given.cases,
            f"campaign_{given.of}",
            (*inputs(given.of), *OUTPUTS),
            partial(solved, of=given.of),
            report_campaign,
        ),
        (given.two_starts, "two_starts", COMPARED, compared, report_two_starts),
    ):
        if count:
            seeds = range(given.first, given.first + count)
            path = given.folder / f"{name}.csv"
            rows = run_table(path, ("seed", *columns), seeds, work, given.workers)
            faults += sum(not (row["failure"] or REFUSED[0]).startswith(REFUSED) for row in rows)
            text = report(rows)
            path.with_suffix(".md").write_text(text, encoding="utf-8")
            print(text)
    return int(faults > 0)


if __name__ == "__main__":
    sys.exit(main())
