"""Random problems: how each ends, its residual, and the true errors of its outputs.

    python benchmarks/campaign.py --of all --cases 1000 --workers 2
    python benchmarks/campaign.py --of plain --cases 300 --errors
    python benchmarks/campaign.py --of plain wrapped --cases 300 --rtol 1e-4

Kinds (random_nips.py): plain, wrapped, covers, rollers, layered, viscoelastic, air, low_friction,
hardening, two_nips, three_nips.  A case ends in one of six ways:

solved          the result satisfies all contact conditions
inadmissible    the problem is rejected by its own validation, without any mesh
rejected        InvalidProblem or NoSteadyState by the solver; ``confirmed`` says whether another
                mesh, also for the load limit, leads to the same exception for the same field
not reached     the tolerance of ``--rtol`` is not reached with 1025 nodes
not converged   NotConverged for any other reason
error           any other exception

With ``--errors`` each solved case is solved again with 513 nodes (129 with hardening rolls), and
every output that has an error estimate is compared with that solution.  Wrapped nips of linear
bodies are compared with extrapolated solutions on another family of meshes (reference_mesh.py).

The table (out/campaign_KIND.csv, errors_KIND.csv, rtol_KIND.csv or rtol_errors_KIND.csv) has a row
a case and is written part by part: a run that is interrupted continues.  The seed determines the
case.  Times are processor times in units of one dense solve of 398 x 398 in the same process.
"""

from __future__ import annotations

import os

# one thread a process, set before NumPy is loaded: matrices are small
os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import re
import sys
import time
import warnings
from collections import Counter
from functools import cache, partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from unittest.mock import patch

import numpy as np
from random_nips import FAMILIES, flat_fields
from reference_mesh import extrapolated
from table_run import Row, run_table

import woundon as wo
from woundon.errors import NoSteadyState
from woundon.nip import load_limit

__all__ = ["ENDINGS", "compared", "solved"]

warnings.simplefilter("ignore", wo.ValidityWarning)
warnings.simplefilter("ignore", wo.ResolutionWarning)

ENDINGS = ("solved", "inadmissible", "rejected", "not reached", "not converged", "error")
COLUMNS = (
    "ending", "text", "confirmed", "residual", "condition", "consistency", "nodes", "iterations",
    "milliseconds", "dense", "warnings",
)  # fmt: skip
ACCEPTED = 1e-8  # largest residual of a result
# Nodes of the reference solutions, and of the solution that confirms a rejection.
FINE, FINE_HARDENING, OTHER = 513, 129, 97
OTHER_LOAD_LIMIT = 33
# Requested: 97 % of the errors within 1.5 estimates, none beyond 4.
WITHIN, SHARE, LARGEST = 1.5, 0.97, 4.0
# True errors below this share of an output are those of the solver, not of the mesh.
ROUNDING = 1e-9


def solved(seed: int, of: str = "plain", errors: bool = False, rtol: float | None = None) -> Row:
    """Return the row of a case."""
    try:
        problem = FAMILIES[of](seed)
    except wo.InvalidProblem as fault:
        return {"ending": "inadmissible", "text": _line(fault)}
    row: Row = dict(flat_fields(problem.model_dump()))
    start = time.process_time()
    try:
        result = wo.solve(problem, rtol=rtol) if rtol else wo.solve(problem)
    except (wo.InvalidProblem, NoSteadyState) as fault:
        confirmed = _confirmed(problem, fault)
        return row | {"ending": "rejected", "text": _line(fault), "confirmed": confirmed}
    except wo.NotConverged as fault:
        ending = "not reached" if rtol and "is not reached" in str(fault) else "not converged"
        return row | {"ending": ending, "text": _line(fault)}
    except Exception as fault:  # every other exception is a fault of the program
        return row | {"ending": "error", "text": _line(fault)}
    seconds = time.process_time() - start
    consistency = getattr(getattr(result, "solved", None) or result, "consistency", {})
    row |= {
        "ending": "solved",
        "residual": result.residuals.largest,
        "condition": result.residuals.worst,
        "consistency": max((value for _, value in consistency.items()), default=""),
        "nodes": _nodes(result),
        "iterations": getattr(result, "iterations", ""),
        "milliseconds": round(1e3 * seconds, 2),
        "dense": round(seconds / _unit(), 2),
        "warnings": len(result.warnings),
    }
    return row | (compared(problem, result, of) if errors else {})


def compared(problem: Any, result: Any, of: str) -> Row:
    """Return the true errors of a result's outputs, by "error NAME", and their estimates."""
    fine = FINE_HARDENING if of == "hardening" else FINE
    try:
        if of in ("wrapped", "covers", "two_nips", "three_nips"):
            reference: Any = SimpleNamespace(**extrapolated(problem))
        else:
            reference = wo.solve(problem, nodes=fine)
    except wo.NotConverged as fault:
        return {"text": f"no reference: {_line(fault)}"}
    row: Row = {}
    for name, estimate in result.errors.items():
        value, other = (_number(one, name) for one in (result, reference))
        if np.isfinite([value, other, estimate]).all():
            row |= {f"error {name}": abs(value - other), f"estimate {name}": estimate}
            row[f"value {name}"] = other
    return row


def _confirmed(problem: Any, fault: Exception) -> str:
    """Return "yes" if another mesh leads to the same rejection, else how it ends there."""
    try:
        with patch.object(load_limit, "NODES", OTHER_LOAD_LIMIT):
            wo.solve(problem, nodes=OTHER)
    except (wo.InvalidProblem, NoSteadyState, wo.NotConverged) as other:
        same = type(other) is type(fault) and _field(other) == _field(fault)
        return "yes" if same else _line(other)
    return "solved"


def _field(fault: Exception) -> str:
    return str(fault).partition(":")[0]


def _line(fault: Exception) -> str:
    return f"{type(fault).__name__}: {fault}".splitlines()[0]


def _nodes(result: Any) -> int:
    return int(result.x[getattr(result, "in_nip", slice(None))].size)


def _number(result: Any, name: str) -> float:
    if name.startswith("contacts.") and hasattr(result, "refinement"):
        return float(result.refinement.last.outputs[name])
    try:
        return float(getattr(result, name))
    except (AttributeError, TypeError, ValueError):
        return float("nan")


@cache
def _unit() -> float:
    """Return the processor time of a dense solve of 398 x 398 in this process [s]."""
    rng = np.random.default_rng(0)
    A, b, times = rng.random((398, 398)), rng.random(398), []
    for _ in range(15):
        start = time.process_time()
        np.linalg.solve(A, b)
        times.append(time.process_time() - start)
    return float(np.median(times))


def columns(of: str, errors: bool) -> list[str]:
    """Return the columns of a kind's table: all fields of its problems, then the outcome."""
    found: list[str] = []
    names: list[str] = []
    for seed in range(60):
        try:
            problem = FAMILIES[of](seed)
        except wo.InvalidProblem:
            continue
        found += [name for name, _ in flat_fields(problem.model_dump())]
        if errors and seed < 3:
            names += wo.solve(problem).errors
    each = [
        f"{what} {name}" for name in dict.fromkeys(names) for what in ("error", "estimate", "value")
    ]
    return ["seed", *dict.fromkeys(found), *COLUMNS, *each]


# ---- summaries ----------------------------------------------------------------------------------


def report(rows: list[dict[str, str]]) -> str:
    """Return how the cases end, as Markdown."""
    by = {ending: [row for row in rows if row["ending"] == ending] for ending in ENDINGS}
    good = by["solved"]
    lines = [("cases", f"{len(rows)}"), *((ending, f"{len(by[ending])}") for ending in ENDINGS)]
    if by["not reached"]:
        share = len(good) / (len(good) + len(by["not reached"]))
        lines.append(("tolerance reached", f"{100 * share:.1f} %"))
    confirmed = sum(row["confirmed"] == "yes" for row in by["rejected"])
    lines.append(("rejected, confirmed on another mesh", f"{confirmed} of {len(by['rejected'])}"))
    if good:
        worst = max(good, key=lambda row: _float(row["residual"]))
        above = sum(not float(row["residual"]) <= ACCEPTED for row in good)
        name = worst["condition"].replace("_", " ")
        lines += [
            ("residual above 1e-8", f"{above}"),
            ("largest residual", f"{float(worst['residual']):.1e} ({name}, seed {worst['seed']})"),
        ]
        for name, column in (
            ("nodes", "nodes"), ("Newton iterations", "iterations"),
            ("milliseconds", "milliseconds"), ("dense solves", "dense"),
        ):  # fmt: skip
            lines.append((f"{name}: median, 99 %, maximum", _spread(good, column)))
    text = _table(lines)
    for ending in ENDINGS[1:]:
        reasons = Counter(re.sub(r"-?\d[\d.e+-]*", "#", row["text"]) for row in by[ending])
        text += "".join(f"\n- {ending}, {n}: {reason}" for reason, n in reasons.most_common(12))
    for row in (*by["not converged"], *by["error"]):
        text += f"\n- seed {row['seed']}: {row['text']}"
    for row in by["rejected"]:
        if row["confirmed"] != "yes":
            text += f"\n- seed {row['seed']}, not confirmed ({row['confirmed']}): {row['text']}"
    return text + "\n"


def report_errors(rows: list[dict[str, str]]) -> str:
    """Return how true the error estimates are, as Markdown."""
    names = [key.removeprefix("error ") for key in rows[0] if key.startswith("error ")]
    text = (
        f"| output | cases | within {WITHIN} estimates | largest error / estimate (seed) | "
        "estimate / error, median | relative error, median, 97 % |\n|---|---|---|---|---|---|\n"
    )
    for name in names:
        found = [
            (float(row[f"error {name}"]), float(row[f"estimate {name}"]),
             abs(float(row[f"value {name}"])), row["seed"])
            for row in rows if row.get(f"error {name}")
        ]  # fmt: skip
        if not found:
            continue
        error, estimate, value = np.array([row[:3] for row in found]).T
        # errors of the size of the reference solution's rounding say nothing
        ratio = np.where(error <= ROUNDING * value, 0.0, error / np.maximum(estimate, 1e-300))
        k = int(ratio.argmax())
        inverse = float(np.median(1 / np.maximum(ratio[ratio > 0], 1e-300))) if ratio.any() else 0.0
        share, flag = float(np.mean(ratio <= WITHIN)), ""
        if share < SHARE or ratio[k] > LARGEST:
            flag = " *"
        relative = (error / np.maximum(value, 1e-300))[value > estimate]  # not of outputs near zero
        text += (
            f"| {name.replace('_', ' ')}{flag} | {len(found)} | {100 * share:.1f} % | "
            f"{ratio[k]:.2f} ({found[k][3]}) | {inverse:.1f} | {_two(relative)} |\n"
        )
    return (
        f"{text}\n\\* fewer than {100 * SHARE:.0f} % within {WITHIN}, or one beyond {LARGEST:g}\n"
    )


def _two(values: np.ndarray) -> str:
    return ", ".join(f"{np.quantile(values, q):.1e}" for q in (0.5, 0.97)) if values.size else "-"


def _float(text: str) -> float:
    return float(text) if text else 0.0


def _spread(rows: list[dict[str, str]], column: str) -> str:
    values = [float(row[column]) for row in rows if row[column]]
    if not values:
        return "-"
    return ", ".join(f"{np.quantile(values, part):.3g}" for part in (0.5, 0.99, 1.0))


def _table(lines: list[tuple[str, str]]) -> str:
    return "| | |\n|---|---|\n" + "".join(f"| {name} | {value} |\n" for name, value in lines)


def main() -> int:
    """Run; return 1 if a case ends in NotConverged, an error or an unconfirmed rejection."""
    options = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    options.add_argument(
        "--of", nargs="+", choices=[*FAMILIES, "all"], default=["plain"], metavar="KIND"
    )
    options.add_argument("--cases", type=int, default=100, help="of each kind")
    options.add_argument("--first", type=int, default=0, help="first seed")
    options.add_argument("--errors", action="store_true", help="compare with a fine mesh")
    options.add_argument("--rtol", type=float, help="tolerance in place of the default")
    options.add_argument("--workers", type=int, default=1, help="processes")
    options.add_argument("--folder", type=Path, default=Path("out"), help="folder of the tables")
    given = options.parse_args()
    kinds = list(FAMILIES) if "all" in given.of else given.of
    return max([_run(of, given) for of in kinds])


def _run(of: str, given: argparse.Namespace) -> int:
    asked = {"rtol": given.rtol, "errors": given.errors}
    name = "_".join(name for name, value in asked.items() if value) or "campaign"
    path = given.folder / f"{name}_{of}.csv"
    work = partial(solved, of=of, errors=given.errors, rtol=given.rtol)
    seeds = range(given.first, given.first + given.cases)
    rows = run_table(path, columns(of, given.errors), seeds, work, given.workers)
    text = f"{of}\n\n{report(rows)}"
    if given.errors:
        text += f"\n{report_errors(rows)}"
    path.with_suffix(".md").write_text(text, encoding="utf-8")
    print(text)
    return int(
        any(row["ending"] in ("not converged", "error") for row in rows)
        or any(row["ending"] == "rejected" and row["confirmed"] != "yes" for row in rows)
    )


if __name__ == "__main__":
    sys.exit(main())
