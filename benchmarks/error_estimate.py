"""Are errors what the program says?  Random nips against grids of eight times the nodes.

    python benchmarks/error_estimate.py --cases 200
    python benchmarks/error_estimate.py --cases 200 --nodes 65

Without ``--nodes`` the program chooses the grid, 65 nodes up to 257; the reference then has 8 times
the nodes, but 1025 at most.  Asked of NIT; of the other outputs it is told.
"""

from __future__ import annotations

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import sys
import warnings
from functools import partial
from pathlib import Path

import numpy as np
from random_nips import random_nip
from table_run import Row, run_table

import woundon as wo

warnings.simplefilter("ignore", wo.ValidityWarning)
warnings.simplefilter("ignore", wo.ResolutionWarning)

FINER, FINEST = 8, 1025
WITHIN = 1.5  # estimates; asked of 97 % of the cases
SHARE = 0.97
LOOSE = 5.0  # the estimate over the true error, asked of the median
OTHERS = ("half_width", "peak_pressure", "offset", "drum_creep", "leading_roll", "trailing_roll",
          "dual")  # fmt: skip
COLUMNS = ("nodes", "nip_induced_tension", "estimate", "reference_nodes", "reference", "scale",
           *OTHERS, "failure")  # fmt: skip


def compared(seed: int, nodes: int | None = None, finer: int = FINER) -> Row:
    """Return a random nip's NIT, its estimated error and a reference; others' true over told."""
    problem = random_nip(seed)
    try:
        result = wo.solve_nip(problem, nodes=nodes)
        count = min(finer * (result.nodes - 1) + 1, FINEST)
        fine = wo.solve_nip(problem, nodes=count)
    except Exception as fault:
        return {"failure": f"{type(fault).__name__}: {fault}"}
    reference = fine.nip_induced_tension
    return {
        "nodes": result.nodes,
        "nip_induced_tension": result.nip_induced_tension,
        "estimate": result.nip_induced_tension_error,
        "reference_nodes": count,
        "reference": reference,
        "scale": max(abs(reference), 0.01 * problem.roll_friction * problem.nip_load),
        **{name: _true_over_told(result, fine, name) for name in OTHERS},
    }


def _true_over_told(result: wo.NipResult, fine: wo.NipResult, name: str) -> float:
    true, told = abs(getattr(result, name) - getattr(fine, name)), result.errors[name]
    return true / told if told else float("inf") if true else 0.0


def ratios(rows: list[Row]) -> np.ndarray:
    """Return true error over estimate, a row each."""
    return np.array([
        abs(float(row["nip_induced_tension"]) - float(row["reference"])) / float(row["estimate"])
        for row in rows
    ])  # fmt: skip


def report(rows: list[Row]) -> str:
    """Return the summary as Markdown."""
    failed = [row for row in rows if row["failure"]]
    good = [row for row in rows if not row["failure"]]
    ratio = ratios(good)
    scale = np.array([float(row["scale"]) for row in good])
    true = ratio * np.array([float(row["estimate"]) for row in good]) / scale
    counts = np.unique([int(row["nodes"]) for row in good], return_counts=True)
    outside = [str(row["seed"]) for row, value in zip(good, ratio, strict=True) if value > WITHIN]
    lines = [
        ("cases", f"{len(rows)}"),
        ("exceptions", f"{len(failed)}"),
        ("nodes", ", ".join(f"{nodes}: {count}" for nodes, count in zip(*counts, strict=True))),
        (f"true error below {WITHIN} estimates", f"{np.mean(ratio <= WITHIN):.1%}"),
        ("true error below the estimate", f"{np.mean(ratio <= 1):.1%}"),
        ("largest true error over the estimate", f"{ratio.max():.3g}"),
        ("estimate over true error, median", f"{np.median(1 / ratio):.3g}"),
        ("true error, of the larger of NIT and 1 % of mu+ P: median, 95 %, largest",
         ", ".join(f"{np.quantile(true, part):.1e}" for part in (0.5, 0.95, 1.0))),
        ("outside: seeds", ", ".join(outside[:20]) or "none"),
    ]  # fmt: skip
    text = "| | |\n|---|---|\n" + "".join(f"| {name} | {value} |\n" for name, value in lines)
    text += (
        f"\n| output | true error below {WITHIN} estimates | largest true error over the estimate "
        "| estimate over true error, median |\n"
    )
    text += "|---|---|---|---|\n" + "".join(_line(good, name) for name in OTHERS)
    return text + "".join(f"- seed {row['seed']}: {row['failure']}\n" for row in failed)


def _line(rows: list[Row], name: str) -> str:
    ratio = np.array([float(str(row[name])) for row in rows])
    seen = ratio[(ratio > 0) & np.isfinite(ratio)]  # where a mesh tells of it, and not for certain
    within, median = np.mean(ratio <= WITHIN), np.median(1 / seen) if seen.size else np.nan
    return f"| {name.replace('_', ' ')} | {within:.1%} | {ratio.max():.3g} | {median:.3g} |\n"


def main() -> int:
    """Run; return 1 if a case failed or the estimates are not as asked."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--cases", type=int, default=200, help="random nips, seeds from --first")
    options.add_argument("--first", type=int, default=0, help="first seed")
    options.add_argument("--nodes", type=int, help="a fixed grid, in place of the program's choice")
    options.add_argument("--finer", type=int, default=FINER, help="nodes of the reference, times")
    options.add_argument("--workers", type=int, default=1, help="processes")
    options.add_argument("--folder", type=Path, default=Path("out"), help="where the tables go")
    given = options.parse_args()
    name = f"error_estimate_{given.nodes}" if given.nodes else "error_estimate"
    path = given.folder / f"{name}.csv"
    seeds = range(given.first, given.first + given.cases)
    work = partial(compared, nodes=given.nodes, finer=given.finer)
    rows: list[Row] = list(run_table(path, ("seed", *COLUMNS), seeds, work, given.workers))
    text = report(rows)
    path.with_suffix(".md").write_text(text, encoding="utf-8")
    print(text)
    good = ratios([row for row in rows if not row["failure"]])
    honest = np.mean(good <= WITHIN) >= SHARE and np.median(1 / good) <= LOOSE
    return int(len(good) < len(rows) or not honest)


if __name__ == "__main__":
    sys.exit(main())
