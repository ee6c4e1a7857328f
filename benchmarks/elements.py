"""Random nips to rtol=1e-6: how many on Chebyshev elements, why not the others, and told errors.

    python benchmarks/elements.py                  eighty nips
    python benchmarks/elements.py --first 2000 --cases 40

True errors are against rtol=2e-8, on elements one or two orders higher, where those are found.
"""

from __future__ import annotations

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import sys
import warnings
from collections import Counter
from time import process_time

import numpy as np
from random_nips import random_nip

import woundon as wo

warnings.simplefilter("ignore", wo.ValidityWarning)
warnings.simplefilter("ignore", wo.ResolutionWarning)

OUTPUTS = (
    "nip_induced_tension", "tension_behind_nip", "half_width", "drum_creep", "peak_pressure",
    "offset", "leading_roll", "trailing_roll", "dual",
)  # fmt: skip
FINEST = 2e-8


def solved(problem: wo.NipProblem, rtol: float) -> tuple[str, wo.NipResult | None]:
    """Return in what a nip ended, and its result."""
    try:
        result = wo.solve_nip(problem, rtol=rtol)
    except wo.InvalidProblem:
        return "refused", None
    except wo.NotConverged as stop:
        return "graded, not reached" if stop.best else "not converged", stop.best
    return result.scheme, result


def ratios(result: wo.NipResult, finest: wo.NipResult) -> dict[str, float]:
    """Return true over told errors by output; what a run of 1e-8 leaves is taken off."""
    found = {}
    for name in OUTPUTS:
        told = result.errors[name]
        off = abs(getattr(result, name) - getattr(finest, name)) - finest.errors[name]
        if told > 0:
            found[name] = max(off, 0.0) / told
    return found


def main() -> int:
    """Print the ends, the price of each, and how true told errors are."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--first", type=int, default=3000, help="the first seed")
    options.add_argument("--cases", type=int, default=80)
    options.add_argument("--rtol", type=float, default=1e-6)
    given = options.parse_args()
    ends: Counter[str] = Counter()
    spent: dict[str, list[float]] = {}
    all_ratios: dict[str, list[float]] = {name: [] for name in OUTPUTS}
    for seed in range(given.first, given.first + given.cases):
        problem, begun = random_nip(seed), process_time()
        end, result = solved(problem, given.rtol)
        ends[end] += 1
        spent.setdefault(end, []).append(process_time() - begun)
        if end != "elements":
            print(f"{seed}: {end}", flush=True)
            continue
        assert result is not None
        finest = solved(problem, FINEST)[1]
        if finest is None or finest.scheme != "elements":
            continue
        for name, ratio in ratios(result, finest).items():
            all_ratios[name].append(ratio)
            if ratio > 1.5:
                print(f"{seed}: {name} {ratio:.1f} times what was told", flush=True)
    for end, count in ends.most_common():
        print(f"{count:4} {end}, median {np.median(spent[end]):.2f} s")
    print("true over told: output, nips, share within 1.5, largest")
    for name, found in all_ratios.items():
        if found:
            within = np.mean(np.array(found) <= 1.5)
            print(f"{name:20} {len(found):4} {within:.3f} {max(found):.1f}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
