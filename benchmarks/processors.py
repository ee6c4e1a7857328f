"""Tests and answers as on other processors: with the instructions that those have, and no others.

    python benchmarks/processors.py tests                 the ordinary ones, two minutes each
    python benchmarks/processors.py tests -m slow -n 2    further arguments go to pytest
    python benchmarks/processors.py answers --cases 2000  random nips, a quarter of them wrapped

Sums are then rounded otherwise.  Where that decides whether a case is solved, it was solved by
chance.  On processors that are not x86 the first of them is all that there is.
"""

from __future__ import annotations

import argparse
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
        done = run(name, __file__, "solve", "--cases", str(count))
        if done.returncode:
            print(f"{name}: {done.stderr[-500:]}")
            return 1
        found[name] = json.loads(done.stdout)
    apart, otherwise = [], 0
    for case, first in found["this one"].items():
        others = [solved[case] for solved in found.values()]
        if any(one != first for one in others if isinstance(one, str) or isinstance(first, str)):
            otherwise += 1
            print(f"{case} ends otherwise: {dict(zip(found, others, strict=True))}")
        elif not isinstance(first, str):
            most = max(abs(value - first[0]) for value, _ in others)
            apart.append((most / first[1] if most else 0.0, case))
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
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("what", choices=["tests", "answers", "solve"])
    parser.add_argument("--cases", type=int, default=2000, help="random nips of answers")
    given, rest = parser.parse_known_args()
    if given.what == "tests":
        return min(tests(rest), 1)
    if rest:
        parser.error(f"unrecognized arguments: {' '.join(rest)}")
    if given.what == "solve":  # as on one processor, for answers
        solve(given.cases)
        return 0
    return min(answers(given.cases), 1)


if __name__ == "__main__":
    sys.exit(main())
