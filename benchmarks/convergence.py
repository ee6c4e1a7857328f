"""Error of the nip-induced tension against nodes and time, for three nips.

    python benchmarks/convergence.py                         tables
    python benchmarks/convergence.py --write docs            also the tables' files and the figures

Plain grids (``nodes=``): what is left of the error where borders of zones are at rest between the
nodes is erratic where zones are short; hence the root mean square over four neighbouring grids.
Asked (``rtol=``): grids fitted to the zones, from 2e-4 (rigid drums: 3e-5) down Chebyshev elements
between their borders.  Limit: NIT on elements to 2e-8.  Of the first nip the published procedure
too, against time.
"""

from __future__ import annotations

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import sys
import warnings
from pathlib import Path
from typing import NamedTuple

import numpy as np
from speed import COVERED, Baseline

import woundon as wo
from jorkama2001 import procedure
from jorkama2001.cases import paper_nip

warnings.simplefilter("ignore", wo.ValidityWarning)
warnings.simplefilter("ignore", wo.ResolutionWarning)

NIPS = {
    "hard drum": paper_nip(),
    "20 mm cover": COVERED,
    "hybrid winding, F = -400 N/m": paper_nip(nip_load=1910.0, winding_force=-400.0),
}
PLAIN = (25, 50, 100, 200, 400, 800)
NEIGHBOURS = (-2, 0, 1, 3)
ASKED = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7)
PUBLISHED = (50, 71, 100, 141, 200, 283)


class Point(NamedTuple):
    """One solution: its errors are relative to the larger of |NIT| and 1 % of mu+ P."""

    nodes: int
    error: float
    told: float
    dense_solves: float
    scheme: str = "graded"


def limit(problem: wo.NipProblem) -> float:
    """Return NIT as far as it goes [N/m]."""
    return _solved(problem, 2e-8).nip_induced_tension


def _solved(problem: wo.NipProblem, rtol: float) -> wo.NipResult:
    try:
        return wo.solve_nip(problem, rtol=rtol)
    except wo.NotConverged as stop:
        if stop.best is None:
            raise
        return stop.best


def plain(problem: wo.NipProblem, known: float, baseline: Baseline) -> list[Point]:
    """Return what plain grids give."""
    scale = max(abs(known), 0.01 * problem.roll_friction * problem.nip_load)
    points = []
    for nodes in PLAIN:
        found = [wo.solve_nip(problem, nodes=nodes + k) for k in NEIGHBOURS]
        errors = np.array([result.nip_induced_tension - known for result in found]) / scale
        told = float(np.median([result.nip_induced_tension_error for result in found])) / scale
        spent = baseline.ratio(lambda: wo.solve_nip(problem, nodes=nodes), 5 if nodes < 300 else 1)  # noqa: B023
        points.append(Point(nodes, float(np.sqrt(np.mean(errors**2))), told, spent))
    return points


def fitted(problem: wo.NipProblem, known: float, baseline: Baseline) -> list[Point]:
    """Return what asking for an accuracy gives."""
    scale = max(abs(known), 0.01 * problem.roll_friction * problem.nip_load)
    points = []
    for rtol in ASKED:
        result = _solved(problem, rtol)
        error = abs(result.nip_induced_tension - known) / scale
        spent = baseline.ratio(lambda: _solved(problem, rtol), 5 if rtol > 1e-5 else 1)  # noqa: B023
        told = result.nip_induced_tension_error / scale
        points.append(Point(result.nodes, error, told, spent, result.scheme))
    return points


def published(problem: wo.NipProblem, known: float, baseline: Baseline) -> list[Point]:
    """Return the errors of the procedure of the thesis."""
    points = []
    for nodes in PUBLISHED:

        def published() -> procedure.ProcedureResult:
            return procedure.solve(problem, nodes, cold=True, load_tolerance=1e-6)  # noqa: B023

        error = abs(published().nip_induced_tension / known - 1)
        spent = baseline.ratio(published, 1)
        points.append(Point(nodes, error, np.nan, spent, "thesis"))
    return points


def order(points: list[Point]) -> float:
    """Return the order of the error in the nodes, by least squares."""
    nodes, errors = np.log([p.nodes for p in points]), np.log([p.error for p in points])
    return float(-np.polyfit(nodes, errors, 1)[0])


def plain_table(found: dict[str, list[Point]]) -> str:
    """Return the table of the plain grids."""
    text = "| nodes |" + "".join(f" {name}: error | dense solves |" for name in found)
    text += "\n|---|" + "---|---|" * len(found) + "\n"
    for k, nodes in enumerate(PLAIN):
        cells = (f" {p[k].error:.1e} | {p[k].dense_solves:.1f} |" for p in found.values())
        text += f"| {nodes} |" + "".join(cells) + "\n"
    return text + "| order |" + "".join(f" {order(p):.2f} | |" for p in found.values()) + "\n"


def fitted_table(found: dict[str, list[Point]]) -> str:
    """Return the table of the fitted grids."""
    text = "| nip | `rtol` | scheme | nodes | error told | true error | dense solves |\n"
    text += "|---|---|---|---|---|---|---|\n"
    for name, points in found.items():
        for rtol, p in zip(ASKED, points, strict=True):
            true = f"{p.error:.1e}" if p.error else "is the limit"
            reached = "" if p.told <= rtol else " (not reached)"
            text += (
                f"| {name} | {rtol:.0e}{reached} | {p.scheme} | {p.nodes} | {p.told:.1e} | "
                f"{true} | {p.dense_solves:.0f} |\n"
            )
    return text


def figure(plains: dict[str, list[Point]], fits: dict[str, list[Point]], path: Path) -> None:
    """Draw errors against nodes and against time."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot as plt

    plt.rcParams["svg.hashsalt"] = "woundon"
    drawn, axes = plt.subplots(1, 2, figsize=(9, 3.8), sharey=True, layout="constrained")
    for k, name in enumerate(plains):
        for points, style, label in (
            (plains[name], "o-", f"{name}, plain"), (fits[name], "s--", f"{name}, rtol=")
        ):  # fmt: skip
            points = [p for p in points if p.error]  # without that which the limit is from
            errors = [p.error for p in points]
            axes[0].loglog(
                [p.nodes for p in points], errors, style, color=f"C{k}", ms=4, label=label
            )
            axes[1].loglog([p.dense_solves for p in points], errors, style, color=f"C{k}", ms=4)
    nodes = np.array([25.0, 800.0])
    axes[0].loglog(nodes, 3e-3 * (25 / nodes) ** 2, color="0.6", lw=1, label="order 2")
    axes[0].set_xticks(PLAIN, [str(n) for n in PLAIN])
    axes[0].set_xticks([], minor=True)
    axes[0].set(xlabel="nodes", ylabel="error of NIT, relative")
    axes[1].set(xlabel="time / dense solve of 398 x 398")
    drawn.legend(fontsize=7, frameon=False, loc="outside upper center", ncols=4)
    drawn.savefig(path, dpi=150, metadata={"Software": None})
    plt.close(drawn)


def against_time(series: dict[str, list[Point]], path: Path) -> None:
    """Draw the errors of one nip by several schemes against time."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot as plt

    drawn, ax = plt.subplots(figsize=(6.4, 4.0), layout="constrained")
    for (name, points), style in zip(series.items(), ("^-", "o-", "s-", "D-"), strict=True):
        points = [p for p in points if p.error]
        ax.loglog([p.dense_solves for p in points], [p.error for p in points], style, label=name)
    ax.axhline(1e-3, color="0.7", lw=0.8, zorder=0)
    ax.annotate("default", (1, 1e-3), xycoords=("axes fraction", "data"), ha="right", va="bottom",
                xytext=(-4, 1), textcoords="offset points", fontsize=8, color="0.4")  # fmt: skip
    ax.set(xlabel="time / dense solve of 398 x 398", ylabel="error of the nip-induced tension")
    ax.legend(frameon=False, fontsize=9)
    drawn.savefig(path, dpi=150, metadata={"Software": None})
    plt.close(drawn)


def main() -> int:
    """Print the tables, or write them with the figure."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--write", type=Path, help="the documentation's folder")
    given = options.parse_args()
    baseline = Baseline()
    plains, fits = {}, {}
    for name, problem in NIPS.items():
        known = limit(problem)
        print(f"{name}: limit {known:.6f} N/m", flush=True)
        plains[name] = plain(problem, known, baseline)
        fits[name] = fitted(problem, known, baseline)
    tables = {"convergence_plain": plain_table(plains), "convergence_fitted": fitted_table(fits)}
    for name, text in tables.items():
        print(f"\n{text}", flush=True)
        if given.write:
            (given.write / "tables").mkdir(parents=True, exist_ok=True)
            (given.write / "tables" / f"{name}.md").write_text(text, encoding="utf-8")
    if given.write:
        figure(plains, fits, given.write / "_static" / "convergence.png")
        first, problem = next(iter(NIPS.items()))
        asked = fits[first]
        series = {
            "published procedure": published(problem, limit(problem), baseline),
            "edge-graded nodes": plains[first],
            "nodes fitted to the zones": [p for p in asked if p.scheme == "graded"],
            "Chebyshev elements between the zones": [p for p in asked if p.scheme == "elements"],
        }
        against_time(series, given.write / "_static" / "error_against_time.png")
    return 0


if __name__ == "__main__":
    sys.exit(main())
