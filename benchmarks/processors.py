"""Tests and answers as on other processors: with the instructions that those have, and no others.

    python benchmarks/processors.py                     the ordinary tests, two minutes each
    python benchmarks/processors.py -m slow -n 2        further arguments go to pytest
    python benchmarks/processors.py answers 2000        random nips, a quarter of them wrapped

Sums are then rounded otherwise.  Where that decides whether a case is solved, it was solved by
chance.  On processors that are not x86 the first of them is all that there is.
"""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import warnings
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent.parent
# OpenBLAS's kernels, and what NumPy leaves out
PROCESSORS = {
    "this one": ("", ""),
    "without AVX": ("Prescott", "X86_V3 X86_V4 AVX512_ICL AVX512_SPR"),
    "AVX": ("Sandybridge", "X86_V3 X86_V4 AVX512_ICL AVX512_SPR"),
    "AVX2": ("Haswell", "X86_V4 AVX512_ICL AVX512_SPR"),
    "AVX2, another maker's": ("Zen", "X86_V4 AVX512_ICL AVX512_SPR"),
    "AVX-512": ("SkylakeX", ""),
}
USUAL = ["-n", str((os.cpu_count() or 1) + 1), "--dist", "worksteal", "-m", "not slow"]
FIRST = 700_000  # seed
APART = 1e-3  # of the told error, from which on answers are counted


def run(processor: str, *command: str) -> subprocess.CompletedProcess[str]:
    """Run Python as on a processor, on one thread."""
    core, without = PROCESSORS[processor]
    told = {"OPENBLAS_CORETYPE": core, "NPY_DISABLE_CPU_FEATURES": without}
    one_thread = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")
    environment = os.environ | one_thread | {key: value for key, value in told.items() if value}
    return subprocess.run(
        [sys.executable, *command], cwd=HERE, env=environment, capture_output=True, text=True,
        check=False,
    )  # fmt: skip


def tests(arguments: list[str]) -> int:
    """Run the tests as on every processor; tell how many were failed on."""
    failed = 0
    for name in PROCESSORS:
        done = run(name, "-m", "pytest", "-q", "--tb=line", *USUAL, *arguments)
        told_of = r"^(?:FAILED|ERROR) .*|^.*(?:passed|failed).*"
        lines = re.findall(told_of, done.stdout, re.MULTILINE)
        print(f"{name}: {lines[-1].strip('= ') if lines else done.stderr[-500:]}", flush=True)
        for line in lines[:-1]:
            print(f"  {line}")
        failed += done.returncode != 0
    return failed


def answers(count: int) -> int:
    """Solve random nips as on every processor; tell how far apart the answers are."""
    found = {}
    for name in PROCESSORS:
        done = run(name, __file__, "solve", str(count))
        if done.returncode:
            print(f"{name}: {done.stderr[-500:]}")
            return 1
        found[name] = json.loads(done.stdout)
    apart, otherwise = [], 0
    for case, first in found["this one"].items():
        others = [solved[case] for solved in found.values()]
        if any(isinstance(one, str) != isinstance(first, str) for one in others):
            otherwise += 1
            print(f"{case} ends otherwise: {dict(zip(found, others, strict=True))}")
        elif not isinstance(first, str):
            apart.append((max(abs(value - first[0]) for value, _ in others) / first[1], case))
    print(f"{len(apart)} of {count} nips solved as on {len(found)} processors, {otherwise} not on "
          f"all; {sum(part > APART for part, _ in apart)} answers more than {APART:g} of their "
          f"told errors apart")  # fmt: skip
    for part, case in sorted(apart, reverse=True)[:5]:
        print(f"  {case}: {part:.1e} of it")
    return otherwise


def solve(count: int) -> None:
    """Print value and told error of each nip, or what it ended in."""
    from random_nips import random_nip, random_wrapped_nip

    import woundon as wo

    warnings.simplefilter("ignore")
    found: dict[str, Any] = {}
    for seed in range(FIRST, FIRST + count):
        wrapped = seed % 4 == 0
        output = "wound_on_tension" if wrapped else "nip_induced_tension"
        try:
            result = wo.solve((random_wrapped_nip if wrapped else random_nip)(seed))
            found[f"{seed}"] = getattr(result, output), result.errors[output]
        except (wo.InvalidProblem, wo.NotConverged, wo.NoSteadyState) as stop:
            found[f"{seed}"] = type(stop).__name__
    print(json.dumps(found))


def main() -> int:
    match sys.argv[1:]:
        case ["answers", count]:
            return min(answers(int(count)), 1)
        case ["solve", count]:
            solve(int(count))
            return 0
        case arguments:
            return min(tests(arguments), 1)


if __name__ == "__main__":
    sys.exit(main())
