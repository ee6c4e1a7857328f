"""The frozen set: does the program still give the numbers of version 0.1?  Ninety-five cases.

    python benchmarks/frozen.py compare            each solver at its own tolerances: to 1e-8
    python benchmarks/frozen.py compare --tight    all loads met to 1e-13: to 1e-11
    python benchmarks/frozen.py make               the reference numbers anew, with 0.1 on the path

The cases are in ``frozen/cases.toml``, the numbers in ``frozen/reference.json``.  ``compare`` ends
with 1 where a number differs by more than its bound or is missing, but for INTENDED ones.  At their
own tolerances the solvers meet a load to 3e-9 (wraps 8e-9), so that even another path to the same
root changes numbers by about 5e-9; tightened, the path does not matter.
"""

from __future__ import annotations

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import json
import sys
import warnings
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, nullcontext
from fnmatch import fnmatch
from functools import cache
from importlib import import_module
from math import isnan
from pathlib import Path
from typing import Any, NamedTuple
from unittest.mock import patch

import numpy as np
from frozen_cases import MOMENTS, Case, Measured, frozen_cases, measured

import woundon as wo

__all__ = [
    "Difference",
    "arcs_of_0_1",
    "borders_of_0_1",
    "differences",
    "kept",
    "program",
    "solved",
    "tightened",
]

REFERENCE = Path(__file__).parent / "frozen" / "reference.json"
WAYS = {"own": 1e-8, "tight": 1e-11}  # accepted relative difference
DIGITS = {"own": 12, "tight": 16}  # written

# How nearly loads, and the tension and curvature of a wrapped web, are met: on the last grid and on
# the coarse ones before it, where rollers' grids are fitted and errors told.
TOLERANCES = {
    "woundon.contact.loop": ("FINE", "COARSE", "COARSEST"),
    "woundon.wrap.solve": ("FINE",),
    "woundon.rollers.solve": ("FINE", "COARSE"),
}
# 1e-14 is reached in every case too; 1e-13 leaves rounding, some 1e-15 a sum, room
TIGHT = 1e-13


@contextmanager
def tightened(tight: float) -> Iterator[None]:
    """Meet all loads, and settle all that is linearised, to ``tight``."""
    from woundon.contact.loop import Tolerance  # 0.1, which makes the reference, has none

    both = Tolerance(load=tight, balance=tight)
    with ExitStack() as changed:
        for module, names in TOLERANCES.items():
            for name in names:
                changed.enter_context(patch.object(import_module(module), name, both))
        yield


# Arcs have other cells since; to see that nothing else moves, cases are solved with those of 0.1.
ARCS = {
    "woundon.wrap.grid": {"STEP": 1e-13, "OVERLAP": 0.0},
    "woundon.wrap.solve": dict.fromkeys(("ROLL_CELLS", "DRUM_CELLS", "RIGID_CELLS"), 3 / 4),
}  # fmt: skip


@contextmanager
def arcs_of_0_1() -> Iterator[None]:
    """Grade the cells of arcs as 0.1 did."""
    grid = import_module("woundon.wrap.grid")
    with ExitStack() as changed:
        changed.enter_context(patch.object(grid, "GRADING", grid.GRADING_0_1))
        for module, values in ARCS.items():
            for name, value in values.items():
                changed.enter_context(patch.object(import_module(module), name, value))
        yield


@contextmanager
def borders_of_0_1() -> Iterator[None]:
    """Leave the borders of zones where a mesh has them, and double meshes, from 65 nodes on."""
    from woundon.contact.loop import Ladder, halved

    def climb(ladder: Any, *_: Any) -> None:
        ladder.climb(halved(65, ladder.scheme.coarsest))

    solve, wrap = "woundon.nip.solve", "woundon.wrap"
    with (
        patch(f"{wrap}.solve.rest_of_borders", lambda *_: {}),
        patch(f"{wrap}.outcome.rest_of_borders", lambda *_: {}),
        patch(f"{wrap}.solve.CHOSEN", (65, 129, 257)),
        patch(f"{solve}.rest_of_borders", lambda *_: {}),
        patch(f"{solve}.CHOSEN", ()),
        patch.object(Ladder, "choose", climb),
    ):
        yield


NEARLY = "descents end where hundredths of a standard error are left: moves by up to 2 % of one"
# quantity -> what was meant to change
INTENDED = {
    "fit 2: *": NEARLY,
    "fit 3: *": NEARLY,
    "fit 4: *": NEARLY,
    "slip_ratios.*": "borders of the zones are found within a cell; they were half-way between",
    "nip *: wound_on_tension": "is tension_behind_nip, and compared under that name",
    "nip": "of a wrapped nip: is gone, for it invented a problem with a clipped force",
    "nip 17: nip_induced_tension_error": "a layer thinner than the coarsest cells: told exactly",
    "wrap *: wound_on_tension_error": "told by the changes of all meshes, as a nip's",
    "wrap *: approach": "slopes summed from the end of an arc were of first order in its cells",
    "sweep 5: approach": "rollers of less than 50 nodes: displacements as exact as a nip's, 1e-6",
    **dict.fromkeys(
        ("nip 16: warnings", "nip 17: warnings", "sweep 2: warnings"),
        "a cover is told of by its own indentation, not the approach, most of which the roll takes",
    ),
    # the told error of a nip is that of a scatter by all meshes
    "nip *: nip_induced_tension_error": "told by the changes of all meshes",
    "sweep *: nip_induced_tension_error": "told by the changes of all meshes",
    "nip 25: warnings": "1 N/m: a web as thick as a tenth of the nip is told of",
    "rollers 13: warnings": "rollers tell where they leave the model, as nips do",
    "rollers 14: warnings": "rollers tell where they leave the model, as nips do",
    "sensitivity 8: nip_induced_tension": "refined: derivatives are those of the mesh's own",
    "wrap 20: *": "both wraps on covers: long cells are integrated by enough points, WOT by 2e-8",
    "fit 5: *": "no absolute bound on the gradient any more: it stopped before the minimum",
}
# and where neither nodes nor rtol are given a wrapped nip is refined until its told error is below
# 0.1 %, as a plain one is; it had 65 nodes, which the cases here say
COST = ("iterations", "solves")  # told, not compared


class Noise(NamedTuple):
    """Quantities that the program cannot give again to the set's own bounds, and theirs.

    Measured on 0.1 by another start of the half width (0.8 and 1.05 times) and by other kernels of
    BLAS and NumPy (without AVX); the bounds are 2 to 10 times what was found.
    """

    kinds: tuple[str, ...]
    names: tuple[str, ...]
    own: float
    tight: float


NOISE = (
    # an error is told by coarse grids, which meet the load to 1e-4 of mu+ P, 1e-2 of the floor
    Noise(("nip", "wrap", "sweep"), ("*_tension_error",), 1e-2, 1e-11),
    # grids are fitted to zones that a coarser grid found at a load met to 1e-6; tightened, there
    # remains that the traction is extrapolated to a border like the root of the distance
    Noise(("rollers",), ("x", "pressure", "traction", "slip"), 1e-5, 1e-9),
    Noise(("rollers", "sweep"), ("peak_pressure",), 1e-7, 1e-10),
    Noise(("rollers", "sweep"), ("traction_error",), 1e-6, 1e-10),
    # between nip and arc smooth parts of kernels are interpolated inside the nip since, as they are
    # between its own nodes: 24 points leave 6e-6 of a displacement, less of what follows from it
    Noise(("wrap",), ("approach", "*_slip", "roll_wrap_traction"), 1e-5, 1e-5),
    Noise(
        ("wrap",),
        ("offset", "drum_*", "*_traction", "curvature", "hoop_pressure", "roll_strain"),
        3e-7,
        3e-7,
    ),
    Noise(
        ("wrap",),
        (
            "*tension*",
            "half_width",
            "nip_width",
            "peak_pressure",
            "*pressure",
            "slip_angle",
            "slip_x",
            "x",
        ),
        4e-8,
        4e-8,
    ),
    # a small shift, out of the even grid's equations for 200 nodes
    Noise(("nip",), ("offset",), 1e-8, 1e-10),
    # the last terms of a sum less what is summed in closed form: rounding, where they have died out
    Noise(("nip", "wrap"), ("series_error",), 2e-2, 2e-2),
    # forward differences of matrices known to 1e-14, by steps of 1e-7
    Noise(("sensitivity",), ("* by *",), 2e-6, 2e-6),
    # a fit stops at steps below 1e-8, or changes of S below 1e-10: 1e-5 standard errors of some %
    Noise(("fit",), ("estimates", "fitted", "rms", "profile of *"), 1e-6, 2e-8),
    # and its covariances take the noise of derivatives, of a load cell's tension by differences
    Noise(("fit",), ("*",), 1e-5, 1e-6),
)


class Difference(NamedTuple):
    """One number of a case, before and now."""

    case: str
    quantity: str
    before: float
    now: float
    relative: float
    bound: float
    intended: str

    @property
    def miss(self) -> bool:
        """Whether it is more than was accepted."""
        return not self.intended and not self.relative <= self.bound


def solved(case: Case) -> Any:
    """Solve a case."""
    problem, options, study = case.problem, case.table("options"), case.table("study")
    if case.kind == "sweep":
        outputs, over = case.given["outputs"], case.table("over")
        return wo.sweep(problem, over, outputs, workers=1, **study, options=options)
    if case.kind == "fit":
        data, vary = case.given["measured"], case.table("vary")
        return wo.fit(problem, data, vary, **study, options=options)
    if case.kind == "wrap":
        wrap = case.table("wrap")
        force = wrap.pop("winding_force", problem.winding_force)
        problem = problem.wrapped(**wrap).replace(winding_force=force)
    if "start" in case.given:
        neighbour = problem.replace(**case.table("start"))
        options["start"] = wo.solve(neighbour, **options)
    if case.kind == "nip" and not options.keys() & {"nodes", "rtol"}:
        options["nodes"] = int(kept(case, "own")["nodes"])  # told errors ask for others now
    result = wo.solve(problem, **options)
    return result.sensitivity() if case.kind == "sensitivity" else result


def program() -> Any:
    """Return what solves the cases: this module, or that for 0.1, which has no ``solve``."""
    return sys.modules[__name__] if hasattr(wo, "solve") else import_module("frozen_program_0_1")


def kept(case: Case, way: str) -> Measured:
    """Return the numbers that 0.1 gave for a case."""
    return dict(_reference()[case.name][way])


@cache
def _reference() -> Mapping[str, Any]:
    return dict(json.loads(REFERENCE.read_text("utf-8"))["cases"])


def measure(case: Case, way: str = "own") -> Measured:
    """Solve a case; return its numbers."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # validity, resolution
        own = hasattr(wo, "solve")
        with (
            program().tightened(TIGHT) if way == "tight" else nullcontext(),
            arcs_of_0_1() if own else nullcontext(),
            borders_of_0_1() if own else nullcontext(),
        ):
            return measured(case.kind, program().solved(case))


def differences(
    case: Case, before: Measured, now: Measured, way: str = "own"
) -> Iterator[Difference]:
    """Yield every number of a case, before and now."""
    for name, old in before.items():
        if name in COST:
            continue
        names = (name, f"{case.kind} {case.number}: {name}")
        changed = next(
            (why for key, why in INTENDED.items() if any(fnmatch(n, key) for n in names)), ""
        )
        new = now.get(name, np.full(np.shape(old), np.nan))
        bound = _bound(case.kind, name, way)
        for label, a, b, floor in _numbers(case, name, old, new, before):
            yield Difference(case.name, label, a, b, _relative(a, b, floor), bound, changed)


def _bound(kind: str, name: str, way: str) -> float:
    for noise in NOISE:
        if kind in noise.kinds and any(fnmatch(name, pattern) for pattern in noise.names):
            return float(getattr(noise, way))
    return WAYS[way]


def _relative(a: float, b: float, floor: float) -> float:
    """Return |a - b| over the larger of |a| and the floor; nan only equals nan."""
    if a == b or (isnan(a) and isnan(b)):
        return 0.0
    if not np.isfinite([a, b]).all():
        return float("inf")
    return abs(a - b) / max(abs(a), floor, 1e-300)


def _numbers(
    case: Case, name: str, old: Any, new: Any, before: Measured
) -> Iterator[tuple[str, float, float, float]]:
    """Yield label, both values and the floor of each number of a quantity."""
    floor = _floor(case, name, before)
    if not isinstance(old, list):
        yield name, old, float(new), floor
        return
    of_array = case.kind in ("nip", "wrap", "rollers")
    if of_array:
        floor = old[0]  # the norm: a sum may vanish by symmetry, an end value by the laws
    elif case.kind == "sweep":
        # small beside its neighbours in the column: the change of sign of an offset
        floor = max(floor, 1e-3 * float(np.nanmax(np.abs(old))))
    new = np.ravel(new).tolist()
    new += [float("nan")] * (len(old) - len(new))
    for k, (a, b) in enumerate(zip(old, new, strict=False)):
        yield f"{name}.{MOMENTS[k]}" if of_array else f"{name}[{k}]", a, b, floor


def _floor(case: Case, name: str, before: Measured) -> float:
    """Return below which size a quantity that may vanish is compared in absolute terms.

    Each is what the noise of the quantity scales with: rounding of the tractions for tensions, of
    the half width for lengths and angles, and an elasticity of one for derivatives.
    """
    problem = case.problem
    if case.kind == "sensitivity" and " by " in name:
        output, field = name.split(" by ")
        size = abs(before[f"field {field}"]) or problem.drum_friction * problem.nip_load
        return float(abs(before[output]) / size)
    if case.kind == "fit":
        return 1e-3 * abs(before["fitted"][0]) if name == "rms" else 0.0
    nip = hasattr(problem, "nip_load")
    bodies = (problem.roll, problem.drum) if nip else (problem.upper, problem.lower)
    a, curvature = before.get("half_width", 0.0), sum(1 / body.radius for body in bodies)
    a = float(np.nanmax(a))
    if nip and ("tension" in name or name.endswith("wrap_traction")):
        return float(0.01 * problem.roll_friction * problem.nip_load)  # as rtol of the solvers
    return {
        "tangential_load": 0.0 if nip else 0.01 * problem.friction * problem.load,
        "offset": 1e-3 * a,
        "approach": a**2 * curvature / 2,
        "drum_creep": 0.01 * a * curvature,
        "traction_error": 1.0,  # relative to the traction
    }.get(name, 0.0)


# ---- commands ------------------------------------------------------------------------------------


def make() -> None:
    """Write the reference numbers."""
    if hasattr(wo, "solve"):
        sys.exit(f"the reference numbers are those of 0.1, this is {wo.__version__}")
    cases = {
        case.name: {way: _rounded(measure(case, way), DIGITS[way]) for way in WAYS}
        for case in frozen_cases()
    }
    head = json.dumps({"version": wo.__version__, "numpy": np.__version__, "tight": TIGHT})
    body = ",\n".join(
        f"{json.dumps(name)}: {json.dumps(numbers, separators=(',', ':'))}"
        for name, numbers in cases.items()
    )
    REFERENCE.write_text(f'{head[:-1]}, "cases": {{\n{body}\n}}}}\n', encoding="utf-8")
    print(f"{len(cases)} cases, {REFERENCE.stat().st_size / 1e3:.0f} kB: {REFERENCE}")


def _rounded(numbers: Measured, digits: int) -> Measured:
    def rounded(value: Any) -> Any:
        if isinstance(value, list):
            return [rounded(item) for item in value]
        short = float(f"{value:.{digits}g}")
        return int(short) if short.is_integer() and abs(short) < 1e6 else short

    return {name: rounded(value) for name, value in numbers.items()}


def compare(way: str, only: str, most: int) -> int:
    """Print how far all cases are from the reference; return 1 where one misses."""
    found: list[Difference] = []
    solves: dict[str, list[float]] = defaultdict(lambda: [0.0, 0.0])
    cases = [case for case in frozen_cases() if only in case.name]
    for case in cases:
        before = kept(case, way)
        try:
            now = measure(case, way)
        except Exception as fault:  # one case must not hide the others
            print(f"{case.name}: {type(fault).__name__}: {fault}")
            now = {}
        found += differences(case, before, now, way)
        for name in COST:
            for k, numbers in enumerate((before, now)):
                solves[case.kind][k] += float(np.sum(numbers.get(name, 0.0)))
    _tell(found, most)
    for kind, (old, new) in solves.items():
        if old:
            print(f"{kind}: {old:.0f} linear systems or solves before, {new:.0f} now")
    misses = [d for d in found if d.miss]
    bad = len({d.case for d in misses})
    print(f"{len(cases)} cases, {len(found)} numbers: {len(misses)} misses in {bad} cases")
    return 1 if misses or not cases else 0


def _tell(found: Iterable[Difference], most: int) -> None:
    """Print the largest difference of each quantity, and the worst misses."""
    groups: dict[tuple[str, str], list[Difference]] = defaultdict(list)
    for d in found:
        groups[d.case.split()[0], _heading(d.quantity)].append(d)
    print(f"{'kind':12} {'quantity':40} {'largest':>8} {'bound':>8}  case")
    for (kind, quantity), group in sorted(groups.items()):
        worst = max(group, key=lambda d: d.relative / d.bound)
        mark = "  INTENDED: " + worst.intended if worst.intended else "  MISS" * worst.miss
        print(f"{kind:12} {quantity:40} {worst.relative:8.1e} {worst.bound:8.0e}  "
              f"{worst.case.split(':')[0]}{mark}")  # fmt: skip
    for d in sorted((d for d in found if d.miss), key=lambda d: -d.relative)[:most]:
        print(f"MISS {d.case}: {d.quantity}: {d.before:.16g} was, {d.now:.16g} is, "
              f"{d.relative:.1e} > {d.bound:.0e}")  # fmt: skip


def _heading(quantity: str) -> str:
    """Return what is told in one line: all moments of an array, all derivatives of an output."""
    head, dot, last = quantity.rpartition(".")
    if dot and last in MOMENTS:
        return head
    if quantity.startswith("field "):
        return "field"
    output, by, _ = quantity.partition(" by ")
    return f"{output} by fields" if by else quantity.partition("[")[0]


def main() -> int:
    """Make the reference numbers, or compare with them."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("command", choices=("make", "compare"))
    options.add_argument("--tight", action="store_true", help="with all loads met to 1e-13")
    options.add_argument("--only", default="", help="cases whose name holds this text")
    options.add_argument("--most", type=int, default=40, help="misses that are listed")
    given = options.parse_args()
    if given.command == "make":
        make()
        return 0
    return compare("tight" if given.tight else "own", given.only, given.most)


if __name__ == "__main__":
    sys.exit(main())
