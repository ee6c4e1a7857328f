"""Are errors what the program says?  Random contacts at their default against far better answers.

    python benchmarks/error_estimate.py --cases 1000 --workers 2
    python benchmarks/error_estimate.py --of wrapped --cases 100
    python benchmarks/error_estimate.py --of neighbours --cases 200

The seed makes the case.  Nips are held against Chebyshev elements told to 1e-6, or where these are
not found against meshes of a thousand nodes fitted to the zones; all else against meshes of four
times the nodes and more.  ``neighbours``, plain or wrapped, are the last of four nips,
each solved from the one before it, 1 to 5 % away.  An output is not judged where the better
answer's own told error is more than a third of what is judged.
Stopped and called again it goes on.
"""

from __future__ import annotations

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import sys
import warnings
from collections.abc import Callable, Sequence
from functools import partial
from math import inf, nan
from pathlib import Path
from typing import Any

import hardening
import numpy as np
from layered import random_layered
from random_nips import (
    random_neighbours,
    random_nip,
    random_rollers,
    random_wrapped_neighbours,
    random_wrapped_nip,
)
from table_run import Row, run_table

import woundon as wo

__all__ = ["FAMILIES", "compared", "judged", "report"]

warnings.simplefilter("ignore", wo.ValidityWarning)
warnings.simplefilter("ignore", wo.ResolutionWarning)

WITHIN, SHARE = 1.5, 0.97  # of told errors, asked of so many cases
BEYOND = 4.0  # told errors, asked of all cases
LOOSE = 5.0  # the told error over the true one, asked of the median
KNOWN = 1 / 3  # of a told error, which the better answer's own must be below
BEST = 1e-6
EXACT = 1e-7  # relative
REFUSED = ("InvalidProblem", "NoSteadyState")
FINE = 700  # nodes from which a graded mesh is a better answer

MAIN = ("nip_induced_tension", "wound_on_tension", "half_width", "drum_creep", "peak_pressure",
        "tangential_load", "creepage")  # fmt: skip
OUTPUTS = (*MAIN, "tension_behind_nip", "offset", "leading_roll", "trailing_roll", "dual")


def _hardening(seed: int) -> Any:
    return hardening.random_nip(np.random.default_rng(seed))


FAMILIES: dict[str, tuple[Callable[[int], Any], int, int]] = {
    # problem by seed, or those on the way to it; how many times the nodes a better answer has, and
    # how many at most
    "nips": (random_nip, 16, 1025),
    "neighbours": (random_neighbours, 16, 1025),
    "layered": (random_layered, 16, 1025),
    "hardening": (_hardening, 4, 257),
    "wrapped": (random_wrapped_nip, 4, 513),
    "wrapped_neighbours": (random_wrapped_neighbours, 4, 513),
    "rollers": (random_rollers, 4, 401),
}
COLUMNS = ("bodies", "nodes", "reference", *OUTPUTS, *(f"{name}_true" for name in OUTPUTS),
           "failure")  # fmt: skip


def compared(seed: int, of: str = "nips") -> Row:
    """Return the true errors of a random case's outputs over the told ones, and relative."""
    make, finer, most = FAMILIES[of]
    try:
        made = make(seed)
        *before, problem = made if isinstance(made, list) else [made]
        options: dict[str, Any] = {}
        for one in before:
            options = {"start": wo.solve(one, **options)}
        result: Any = wo.solve(problem, **options)
        best = _better(problem, min(finer * (_nodes(result) - 1) + 1, most))
    except Exception as fault:
        return {"failure": f"{type(fault).__name__}: {fault}"}
    row: Row = {
        "bodies": " ".join(type(body).__name__ for body in problem.bodies),
        "nodes": _nodes(result),
        "reference": f"{getattr(best, 'scheme', 'graded')} {_nodes(best)}",
    }
    given = {"tangential_load"} if getattr(problem, "creepage", None) is None else {"creepage"}
    for name in OUTPUTS:
        if name in result.errors and name not in given:
            row |= judged(result, best, name)
    return row


def judged(result: Any, best: Any, name: str) -> Row:
    """Return true over told error, nan where it is not judged, and the true one, relative."""
    value, true = (float(getattr(one, name)) for one in (result, best))
    told, off = result.errors[name], abs(value - true)
    relative = off / abs(true) if true else nan
    if not best.errors[name] <= KNOWN * told:
        return {name: nan, f"{name}_true": relative}
    return {name: off / told if told else inf if off else 0.0, f"{name}_true": relative}


def _nodes(result: Any) -> int:
    return int(getattr(result, "nodes", result.x.size))


def _better(problem: Any, nodes: int) -> Any:
    """Return a much better answer: told to 1e-6 where a plain nip of linear bodies is."""
    if not isinstance(problem, wo.NipProblem) or not problem.linear:
        return _finest(problem, nodes)
    try:
        best: Any = wo.solve(problem, rtol=BEST)
    except wo.NotConverged as stop:
        best = stop.best
    if best is None or (best.scheme == "graded" and best.nodes < FINE):
        return wo.solve(problem, nodes=nodes)
    return best


def _finest(problem: Any, nodes: int) -> Any:
    """Return the answer on so many nodes, or on half of them where these find none."""
    try:
        return wo.solve(problem, nodes=nodes)
    except wo.NotConverged:
        return wo.solve(problem, nodes=(nodes + 1) // 2)


def report(rows: Sequence[Row], of: str = "nips") -> tuple[str, bool]:
    """Return the summary as Markdown, and whether the main outputs' errors are as asked."""
    good = [row for row in rows if not row["failure"]]
    refused = [row for row in rows if str(row["failure"]).startswith(REFUSED)]
    failed = [row for row in rows if row["failure"] and row not in refused]
    counts = np.unique([int(str(row["nodes"])) for row in good], return_counts=True)
    by_elements = sum(str(row["reference"]).startswith("elements") for row in good)
    text = (
        f"{len(good)} {of}; nodes {', '.join(f'{n}: {k}' for n, k in zip(*counts, strict=True))}; "
        f"{by_elements} held against elements, {len(refused)} refused, {len(failed)} failed.\n\n"
        "| output | judged | within 1.5 told errors | largest true over told | told over true, "
        "median | true error: median, 97 % | beyond: seeds |\n|---|---|---|---|---|---|---|\n"
    )
    honest = not failed
    for name in OUTPUTS:
        line, kept = _line(good, name)
        text += line
        honest &= kept or name not in MAIN
    text += _by_bodies(good) + "".join(f"- seed {r['seed']}: {r['failure']}\n" for r in failed)
    return text, honest


def _numbers(rows: Sequence[Row], name: str) -> np.ndarray:
    return np.array([float(str(row.get(name) or nan)) for row in rows])


def _line(rows: Sequence[Row], name: str) -> tuple[str, bool]:
    ratio, true = _numbers(rows, name), _numbers(rows, f"{name}_true")
    known = np.isfinite(ratio)
    if not known.any():
        return "", True
    within, worst = float(np.mean(ratio[known] <= WITHIN)), float(ratio[known].max())
    median = _told_over_true(rows, name)
    order = [k for k in np.argsort(-np.where(known, ratio, -1)) if ratio[k] > WITHIN][:6]
    seeds = ", ".join(f"{rows[k]['seed']} ({ratio[k]:.1f})" for k in order)
    spread = ", ".join(f"{np.nanquantile(true, part):.1e}" for part in (0.5, 0.97))
    line = (
        f"| {name.replace('_', ' ')} | {known.sum()} | {within:.1%} | {worst:.2g} | {median:.2g} "
        f"| {spread} | {seeds} |\n"
    )
    return line, bool(within >= SHARE and worst <= BEYOND and median <= LOOSE)


def _told_over_true(rows: Sequence[Row], name: str) -> float:
    """Return the median of those that err at all: where all slips, NIT is exact on any mesh."""
    ratio = _numbers(rows, name)
    seen = ratio[np.isfinite(ratio) & (_numbers(rows, f"{name}_true") > EXACT)]
    return float(np.median(1 / seen)) if seen.size else nan


def _by_bodies(rows: Sequence[Row]) -> str:
    """Return by bodies how many times too large told errors of the main outputs are."""
    names = [name for name in MAIN if np.isfinite(_numbers(rows, name)).any()]
    text = "\n| told over true, median, of | cases | nodes, mean | "
    text += " | ".join(name.replace("_", " ") for name in names)
    text += " |\n|---|---|---|" + "---|" * len(names) + "\n"
    for bodies in sorted({str(row["bodies"]) for row in rows}):
        own = [row for row in rows if row["bodies"] == bodies]
        told = " | ".join(f"{_told_over_true(own, name):.2g}" for name in names)
        text += f"| {bodies} | {len(own)} | {np.mean(_numbers(own, 'nodes')):.0f} | {told} |\n"
    return text


def main() -> int:
    """Run; return 1 if a case failed or told errors are not as asked."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--of", choices=FAMILIES, default="nips")
    options.add_argument("--cases", type=int, default=200, help="random cases, seeds from --first")
    options.add_argument("--first", type=int, default=0, help="first seed")
    options.add_argument("--workers", type=int, default=1, help="processes")
    options.add_argument("--folder", type=Path, default=Path("out"), help="where the tables go")
    given = options.parse_args()
    path = given.folder / f"error_estimate_{given.of}.csv"
    seeds = range(given.first, given.first + given.cases)
    rows = run_table(path, ("seed", *COLUMNS), seeds, partial(compared, of=given.of), given.workers)
    text, honest = report(rows, given.of)  # type: ignore[arg-type]
    path.with_suffix(".md").write_text(text, encoding="utf-8")
    print(text)
    return int(not honest)


if __name__ == "__main__":
    sys.exit(main())
