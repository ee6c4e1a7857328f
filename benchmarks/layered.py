"""Random nips of layered drums and graded rolls: a certificate or a clear refusal; and their price.

    python benchmarks/layered.py --cases 300          endings, and what each refusal says
    python benchmarks/layered.py --price              a three-layer drum's first call by a cover's

Log-uniform: one to six layers of 1 um to 30 mm, E 5e5 to 2e11 Pa, on a rigid core or an open bore;
half of the rolls are graded by a wound pressure of 10 kPa to 2 MPa over their radius, K1 1 kPa to
1 MPa, K2 5 to 500, the other half paper over a core shell; all else as random_nips.py.
"""

from __future__ import annotations

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import statistics
import time
from collections import Counter
from functools import partial

import numpy as np
from random_nips import _Draw, random_nip

import woundon as wo
from woundon.elasticity import cylinder

__all__ = ["ending", "price", "random_layered"]

RESIDUAL = 1e-8


def random_layered(seed: int) -> wo.NipProblem:
    """Return the nip that belongs to a seed; always the same one.

    Raises
    ------
    InvalidProblem
        If what was drawn is not admissible, as layers thicker than the radius.
    """
    draw, plain = _Draw(1_000_000 + seed), random_nip(seed)
    layers = [
        wo.Layer(
            thickness=draw.log(1e-6, 30e-3),
            material=wo.Isotropic(
                youngs_modulus=draw.log(5e5, 2e11), poissons_ratio=draw.even(0.0, 0.495)
            ),
        )
        for _ in range(int(draw.random.integers(1, 7)))
    ]
    core = ("rigid", "free")[int(draw.random.integers(2))]
    drum = wo.Layered(radius=plain.drum.radius, layers=layers, core=core)
    return plain.replace(drum=drum, roll=_roll(draw, plain))


def _roll(draw: _Draw, plain: wo.NipProblem) -> wo.Body:
    R, paper = plain.roll.radius, plain.web.material
    core = draw.even(0.1, 0.9) * R
    if draw.random.random() < 0.5:
        shell = wo.Layer(thickness=draw.even(0.05, 0.3) * core, material="steel")
        layers = (wo.Layer(thickness=R - core, material=paper), shell)
        return wo.Layered(radius=R, layers=layers, core="free")
    law = wo.Pfeiffer(K1=draw.log(1e3, 1e6), K2=draw.log(5.0, 500.0))
    stack = wo.Stack(
        radial=law, tangential=paper.tangential, poissons_ratio=draw.even(0.0, 0.3),
        shear=paper.shear,
    )  # fmt: skip
    radii = np.sort(draw.random.uniform(core, R, 4))
    pressure = wo.Profile(radius=radii, value=[draw.log(10e3, 2e6) for _ in radii])
    hardening = ("frozen", "estimate")[int(draw.random.integers(2))]
    return wo.WoundRoll(
        radius=R, core_radius=core, stack=stack, pressure=pressure, hardening=hardening
    )


def ending(seed: int) -> tuple[str, float]:
    """Return how a random nip ends, "solved" or what the refusal says, and its residual."""
    try:
        result = wo.solve(random_layered(seed))
    except wo.InvalidProblem as refusal:
        return f"refused: {refusal}", 0.0
    except wo.NotConverged as failure:
        return f"NOT SOLVED: {failure}", np.inf
    return "solved", result.residuals.largest


def price(rounds: int = 9) -> float:
    """Return the price of a three-layer drum's first call by that of a one-layer cover."""
    steel, example = wo.material("steel"), wo.NipProblem.example()
    soft, hard = (
        wo.Isotropic(youngs_modulus=E, poissons_ratio=nu) for E, nu in ((10e6, 0.49), (60e6, 0.45))
    )
    cover = wo.Cylinder(radius=0.24, core_radius=0.225, material=soft)
    layers = [
        wo.Layer(thickness=h, material=m) for h, m in ((0.015, soft), (0.005, hard), (0.02, steel))
    ]
    three = wo.Layered(radius=0.24, layers=layers)
    timed = {}
    for name, drum in (("cover", cover), ("three", three)):
        first = partial(wo.solve, example.replace(drum=drum))
        first()
        timed[name] = []
        for _ in range(rounds):
            cylinder._kernels.cache_clear()
            start = time.perf_counter()
            first()
            timed[name].append(time.perf_counter() - start)
    ratio = statistics.median(timed["three"]) / statistics.median(timed["cover"])
    times = {name: f"{1e3 * statistics.median(all_):.1f} ms" for name, all_ in timed.items()}
    print(f"first call: {times}, ratio {ratio:.2f}")
    return ratio


def main() -> None:
    """Run what is asked."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--cases", type=int, default=0)
    parser.add_argument("--price", action="store_true")
    asked = parser.parse_args()
    if asked.price:
        price()
    endings: Counter[str] = Counter()
    for seed in range(asked.cases):
        how, residual = ending(seed)
        if how != "solved" or residual > RESIDUAL:
            print(seed, how[:180], f"{residual:.1e}", flush=True)
        endings[how.partition(":")[0]] += 1
    if asked.cases:
        print(dict(endings))


if __name__ == "__main__":
    main()
