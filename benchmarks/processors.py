"""The tests as on other processors: linear algebra and NumPy with the instructions that those have.

    python benchmarks/processors.py                     the ordinary tests, two minutes each
    python benchmarks/processors.py -m slow -n 2        further arguments go to pytest

Sums are then rounded otherwise.  Where that decides whether a case is solved, it was solved by
chance.  On processors that are not x86 the first of them is all that there is.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

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


def main() -> int:
    failed = 0
    for name, (core, without) in PROCESSORS.items():
        command = [sys.executable, "-m", "pytest", "-q", "--tb=line", *USUAL, *sys.argv[1:]]
        told = {"OPENBLAS_CORETYPE": core, "NPY_DISABLE_CPU_FEATURES": without}
        one_thread = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")
        environment = os.environ | one_thread | {key: value for key, value in told.items() if value}
        done = subprocess.run(
            command, cwd=HERE, env=environment, capture_output=True, text=True, check=False
        )
        told_of = r"^(?:FAILED|ERROR) .*|^.*(?:passed|failed).*"
        lines = re.findall(told_of, done.stdout, re.MULTILINE)
        print(f"{name}: {lines[-1].strip('= ') if lines else done.stderr[-500:]}", flush=True)
        for line in lines[:-1]:
            print(f"  {line}")
        failed += done.returncode != 0
    return min(failed, 1)


if __name__ == "__main__":
    sys.exit(main())
