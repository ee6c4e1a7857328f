"""How much longer the wrapped nip takes than the plain one.

    python benchmarks/wrap.py

Prints milliseconds, shortest of some repeats, and the ratio; test_wrap_claims.py asks for less than
ten on a hard drum.
"""

from __future__ import annotations

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import warnings
from collections.abc import Callable
from math import pi
from time import process_time

import woundon as wo
from jorkama2001.cases import newsprint_nip, paper_nip

REPEATS = 15


def milliseconds(solve: Callable[[], object]) -> float:
    """Return the shortest time of a call, the processor's own: the machine may be busy."""
    times = []
    for _ in range(REPEATS):
        begun = process_time()
        solve()
        times.append(process_time() - begun)
    return 1e3 * min(times)


def main() -> None:
    """Time paper and newsprint, hard and covered drums."""
    warnings.simplefilter("ignore", wo.ValidityWarning)
    warnings.simplefilter("ignore", wo.ResolutionWarning)
    foam = wo.Isotropic(youngs_modulus=10e6, poissons_ratio=0.1)
    cases = {
        "paper, hard drum": paper_nip(),
        "newsprint, hard drum": newsprint_nip(),
        "paper, foam cover": paper_nip(
            drum=wo.Cylinder(radius=0.5, core_radius=0.48, material=foam)
        ),
    }
    print(f"{'65 nodes':22} plain [ms]   wrapped on roll   and on drum")
    for name, problem in cases.items():
        plain = milliseconds(lambda p=problem: wo.solve_nip(p, nodes=65))
        roll = milliseconds(lambda p=problem: wo.solve_wrapped_nip(p, nodes=65))
        both = milliseconds(lambda p=problem: wo.solve_wrapped_nip(p, drum_wrap=pi / 2, nodes=65))
        print(
            f"{name:22} {plain:8.1f} {roll:10.1f} ({roll / plain:3.1f}x) "
            f"{both:8.1f} ({both / plain:3.1f}x)"
        )


if __name__ == "__main__":
    main()
