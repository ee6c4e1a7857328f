"""Exact sensitivities of random nips against central differences of nips solved on a fine grid.

    python benchmarks/sensitivities.py --cases 100

Elasticities are compared: percent of output per percent of field, of NIT (of the larger of |NIT|
and 1 % of mu+ P), the tension behind the nip, widths and drum creep.  Small steps, 1e-5 of the
field, tell whether the derivatives are those of the solved equations; where a node changes between
stick and slip within a step they have no derivative, and the field is counted apart.  Steps of 1 %,
over which the borders of the zones move by whole nodes, tell whether they are those of the nip.
Only a mesh's own outputs have exact derivatives, so that small steps are compared with borders left
where the mesh has them (``own_of_mesh``), and wide ones with tensions as they are told.
"""

from __future__ import annotations

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from unittest.mock import patch

import numpy as np
from random_nips import random_nip
from table_run import Row, run_table

import woundon as wo
from woundon.contact import loop
from woundon.nip.sensitivity import Sensitivity

warnings.simplefilter("ignore", wo.ValidityWarning)
warnings.simplefilter("ignore", wo.ResolutionWarning)

NODES = 257
SMALL, WIDE = 1e-5, 1e-2
ACCEPTED = 1e-4  # difference of elasticities, absolute below 1, relative above
OUTPUTS = ("nip_induced_tension", "half_width", "nip_width", "drum_creep", "rig_tension")
# what outputs of a nip alone have beyond the mesh's own, and of one with its wraps
EXTRAPOLATED = dict.fromkeys(
    ("nip_induced_tension", "tension_behind_nip", "rig_tension"), "extrapolation"
)
OF_WRAPPED = {
    "nip_induced_tension": "extrapolation_of_nip", "tension_behind_nip": "extrapolation_behind",
    "wound_on_tension": "extrapolation",
}  # fmt: skip
COLUMNS = ("fields", "at_zone_change", "largest_difference", "field", "output",
           "wide_median", "wide_largest", "wide_field", "failure")  # fmt: skip


# loads met to 3e-9 would leave 3e-4 of a difference over steps of 1e-5
MET = loop.Tolerance(load=1e-12, balance=1e-12)


def of_mesh(result: wo.NipResult | wo.WrappedNipResult, output: str) -> float:
    """Return an output as the mesh has it, without what it is extrapolated by."""
    beyond = (EXTRAPOLATED if isinstance(result, wo.NipResult) else OF_WRAPPED).get(output)
    return float(getattr(result, output) - (getattr(result, beyond) if beyond else 0.0))


@contextmanager
def own_of_mesh() -> Iterator[None]:
    """Leave borders where a mesh has them, so that outputs told and their derivatives are its own.

    What is solved within has no ``extrapolation`` of its borders, outside too.
    """
    with (
        patch("woundon.nip.solve.rest_of_borders", lambda *_: {}),
        patch("woundon.wrap.solve.rest_of_borders", lambda *_: {}),
        patch("woundon.wrap.outcome.rest_of_borders", lambda *_: {}),
    ):
        yield


@patch.object(loop, "FINE", MET)
def compared(seed: int, nodes: int = NODES, wide: bool = True) -> Row:
    """Return how far the exact elasticities of a random nip are from central differences."""
    try:
        with own_of_mesh():
            near = _all_differences(random_nip(seed), nodes, SMALL)
        far = _all_differences(random_nip(seed), nodes, WIDE) if wide else []
    except Exception as fault:
        return {"failure": f"{type(fault).__name__}: {fault}"}
    smooth = [found for found in near if found is not None and found[1]]
    table = np.array([difference for difference, _, _ in smooth])
    field, output = np.unravel_index(table.argmax(), table.shape)
    row: Row = {
        "fields": len(near),
        "at_zone_change": len(near) - len(smooth),
        "largest_difference": float(table.max()),
        "field": smooth[field][2],
        "output": OUTPUTS[output],
    }
    if wide:
        tension = [(found[0][0], found[2]) for found in far if found is not None]
        row["wide_median"] = float(np.median([value for value, _ in tension]))
        row["wide_largest"], row["wide_field"] = max(tension)
    return row


def _all_differences(
    problem: wo.NipProblem, nodes: int, step: float
) -> list[tuple[np.ndarray, bool, str] | None]:
    """Return those by each field."""
    result = wo.solve_nip(problem, nodes=nodes)
    told = result.sensitivity(outputs=OUTPUTS)
    return [_differences(result, told, k, step) for k in range(len(told.parameters))]


def _differences(
    result: wo.NipResult, sensitivity: Sensitivity, k: int, step: float
) -> tuple[np.ndarray, bool, str] | None:
    """Return differences of the elasticities, whether all zones stayed, and the field.

    None where the step leads out of the admissible range.
    """
    problem, name = result.problem, sensitivity.parameters[k]
    size = abs(float(sensitivity.fields[k]))
    body = getattr(problem, name.partition(".")[0])
    if isinstance(body, wo.Cylinder) and name.endswith("radius"):
        size = body.thickness  # the radii of a layer matter by their difference
    try:
        ends = [
            wo.solve_nip(
                problem.replace(**{name: float(sensitivity.fields[k]) + sign * step * size}),
                nodes=result.nodes,
                start=result,
            )
            for sign in (1, -1)
        ]
    except wo.InvalidProblem:
        return None
    outputs = np.array([[getattr(end, output) for output in sensitivity.outputs] for end in ends])
    floor = 0.01 * problem.roll_friction * problem.nip_load
    scale = np.abs(sensitivity.values)
    scale[0] = max(scale[0], floor)
    elasticity = (outputs[0] - outputs[1]) / (2 * step * scale)
    exact = sensitivity.derivatives[:, k] * size / scale
    difference = np.abs(exact - elasticity) / np.maximum(1.0, np.abs(elasticity))
    stayed = all(
        np.array_equal(getattr(end, side), getattr(result, side))
        for end in ends
        for side in ("roll_zone", "drum_zone")
    )
    return difference, stayed, name


def report(rows: list[dict[str, str]]) -> str:
    """Return the summary as Markdown."""
    failed = [row for row in rows if row["failure"]]
    good = [row for row in rows if not row["failure"]]
    worst = max(good, key=lambda row: float(row["largest_difference"]))
    missed = [row["seed"] for row in good if not float(row["largest_difference"]) <= ACCEPTED]
    wide = np.array([float(row["wide_median"]) for row in good])
    widest = np.array([float(row["wide_largest"]) for row in good])
    lines = [
        ("cases", f"{len(rows)}"),
        ("exceptions", f"{len(failed)}"),
        ("fields", f"{sum(int(row['fields']) for row in good)}"),
        ("of these with a zone change within the small step",
         f"{sum(int(row['at_zone_change']) for row in good)}"),
        ("largest difference of elasticities, small steps",
         f"{float(worst['largest_difference']):.1e} ({worst['output']} by {worst['field']}, "
         f"seed {worst['seed']})"),
        (f"cases above {ACCEPTED:g}", f"{len(missed)} {', '.join(missed)}"),
        ("the same of NIT, steps of 1 %: a case's median field, median and 95 % of cases",
         f"{np.median(wide):.1e}, {np.quantile(wide, 0.95):.1e}"),
        ("a case's worst field, median and 95 % of cases",
         f"{np.median(widest):.1e}, {np.quantile(widest, 0.95):.1e}"),
    ]  # fmt: skip
    text = "| | |\n|---|---|\n" + "".join(f"| {name} | {value} |\n" for name, value in lines)
    return text + "".join(f"- seed {row['seed']}: {row['failure']}\n" for row in failed)


def main() -> int:
    """Run; return 1 if a case failed or missed."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--cases", type=int, default=100, help="random nips, seeds from --first")
    options.add_argument("--first", type=int, default=0, help="first seed")
    options.add_argument("--workers", type=int, default=1, help="processes")
    options.add_argument("--folder", type=Path, default=Path("out"), help="where the tables go")
    given = options.parse_args()
    seeds = range(given.first, given.first + given.cases)
    path = given.folder / "sensitivities.csv"
    rows = run_table(path, ("seed", *COLUMNS), seeds, compared, given.workers)
    text = report(rows)
    path.with_suffix(".md").write_text(text, encoding="utf-8")
    print(text)
    return int(any(row["failure"] or float(row["largest_difference"]) > ACCEPTED for row in rows))


if __name__ == "__main__":
    sys.exit(main())
