"""Random viscoelastic nips and rollers over speed: a certificate or a clear refusal; their price.

    python benchmarks/viscoelastic.py --cases 200     endings, and what each refusal says
    python benchmarks/viscoelastic.py --price         solves by those of the same elastic bodies

Log-uniform: one to eight Prony terms of 0.02 to 3 times E_inf and 1e-7 to 10 s, in a third of the
cases a loss angle; speeds from 1 mm/s to 100 m/s; the drum a half-plane, a cover of 0.5 to 40 mm or
layers, soft over hard or hard over soft; in a fifth the roll is viscoelastic too.  A third each of
plain nips, wrapped nips and rollers; all else as random_nips.py.
"""

from __future__ import annotations

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import statistics
import time
from collections import Counter
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from random_nips import _Draw, random_nip

import woundon as wo
from woundon.elasticity import cylinder, half_plane, lag, relaxation, rolling

__all__ = ["ending", "prices", "random_viscoelastic"]

RESIDUAL = 1e-8
# a measured master curve of a rubber, compound unknown: E_inf, then E_k [MPa] at tau_k [s]
RUBBER = wo.Isotropic(
    youngs_modulus=5.47e6, poissons_ratio=0.48,
    prony=[(1.43e6, 10), (1.2e6, 1), (1.6e6, 0.1), (2.33e6, 1e-2), (3.14e6, 1e-3), (4.71e6, 1e-4),
           (8.12e6, 1e-5), (15.6e6, 1e-6)],
)  # fmt: skip


def random_viscoelastic(seed: int) -> Any:
    """Return the problem that belongs to a seed; always the same one.

    Raises
    ------
    InvalidProblem
        If what was drawn is not admissible.
    """
    draw, plain = _Draw(2_000_000 + seed), random_nip(seed)
    speed, drum = draw.log(1e-3, 100.0), _drum(draw, plain.drum.radius)
    roll = plain.roll
    if draw.random.random() < 0.2:
        core = draw.even(0.1, 0.8) * roll.radius
        roll = wo.Cylinder(radius=roll.radius, core_radius=core, material=_rubber(draw, 1e7, 1e9))
    if seed % 3 == 2:
        friction = 0.0 if draw.random.random() < 0.3 else draw.even(0.05, 0.8)
        pull = draw.even(-0.8, 0.8) * friction * plain.nip_load
        return wo.RollerProblem(
            upper=roll, lower=drum, load=plain.nip_load, friction=friction, speed=speed,
            tangential_load=pull if friction else None,
        )  # fmt: skip
    nip = plain.replace(roll=roll, drum=drum, web_speed=speed)
    return nip if seed % 3 == 0 else nip.wrapped(drum_wrap=draw.even(0.0, 2.0) * (seed % 2))


def _rubber(draw: _Draw, low: float, high: float) -> wo.Material:
    E, nu = draw.log(low, high), draw.even(0.0, 0.499)
    if draw.random.random() < 1 / 3:
        return wo.LossAngle(
            youngs_modulus=E, poissons_ratio=nu, loss_angle=draw.log(1e-3, 1.2),
            frequency=draw.log(0.1, 1e5),
        )  # fmt: skip
    terms = range(int(draw.random.integers(1, 9)))
    prony = [(E * draw.log(0.02, 3.0), draw.log(1e-7, 10.0)) for _ in terms]
    return wo.Isotropic(youngs_modulus=E, poissons_ratio=nu, prony=prony)


def _drum(draw: _Draw, radius: float) -> wo.Body:
    material, which = _rubber(draw, 1e6, 1e9), draw.random.random()
    if which < 0.25:
        return wo.HalfPlane(radius=radius, material=material)
    if which < 0.6:
        cover = draw.log(0.5e-3, 40e-3)
        return wo.Cylinder(radius=radius, core_radius=radius - cover, material=material)
    hard = wo.Isotropic(youngs_modulus=draw.log(1e7, 2e11), poissons_ratio=0.3)
    layers = [
        wo.Layer(thickness=draw.log(0.3e-3, 20e-3), material=m) for m in (material, hard, material)
    ]
    return wo.Layered(radius=radius, layers=layers[int(draw.random.integers(2)) :])


def ending(seed: int) -> tuple[str, float]:
    """Return how a random case ends, "solved" or what the refusal says, and its residual."""
    try:
        result = wo.solve(random_viscoelastic(seed))
    except wo.InvalidProblem as refusal:
        return f"refused: {refusal}", 0.0
    except wo.NotConverged as failure:
        return f"NOT SOLVED: {failure}", np.inf
    return "solved", result.residuals.largest


# ---- price --------------------------------------------------------------------------------------


def _cases(prony: Any) -> Iterator[tuple[str, Any, dict[str, int]]]:
    """Yield contacts of a cover and of a half-plane, elastic where ``prony`` is None."""
    material, speed = RUBBER.replace(prony=prony), None if prony is None else 10.0
    for name, drum in (
        ("cover", wo.Cylinder(radius=0.25, core_radius=0.235, material=material)),
        ("half-plane", wo.HalfPlane(radius=0.25, material=material)),
    ):
        nip = wo.NipProblem.example().replace(drum=drum, web_speed=speed)
        rollers = wo.RollerProblem(
            upper=wo.Rigid(radius=0.2), lower=drum, load=2e3, friction=0.3, speed=speed
        )
        # on one grid: a solve of its own accord refines until the error is below 1e-3
        yield f"nip, {name}", nip, {"nodes": 129}
        yield f"wrapped nip, {name}", nip.wrapped(), {"nodes": 129}
        yield f"rollers, {name}", rollers, {"nodes": 201}
        driven = rollers.replace(tangential_load=300.0)
        yield f"driven rollers, {name}", driven, {"nodes": 201}


def prices(rounds: int = 7) -> Iterator[tuple[str, float, float]]:
    """Yield the price of viscoelastic solves by elastic ones: again, and the first of a body.

    One Prony term and eight, the median of the ratios of solves that take turns.
    """
    for terms in (1, 8):
        pairs = zip(_cases(None), _cases(RUBBER.prony[-terms:]), strict=True)
        for (name, elastic, options), (_, other, _) in pairs:
            again, first = [], []
            for _ in range(rounds):
                forget = (_forget, lambda: None)
                times = [[_time(p, options, f) for p in (elastic, other)] for f in forget]
                first.append(times[0][1] / times[0][0])
                again.append(times[1][1] / times[1][0])
            told = f"{name}, {terms} term{'s' * (terms > 1)}"
            yield told, statistics.median(again), statistics.median(first)


def _forget() -> None:
    for cached in (
        cylinder._kernels, cylinder._elastic_spectrum, cylinder.asymptotic_compliance,
        cylinder._slowest, half_plane.surface_kernels, rolling._kernels, rolling.half_plane_kernels,
        lag._tabulated, relaxation.creep,
    ):  # fmt: skip
        cached.cache_clear()


def _time(problem: Any, options: dict[str, int], before: Callable[[], None]) -> float:
    before()
    start = time.process_time()
    wo.solve(problem, **options)
    return time.process_time() - start


def main() -> None:
    """Run what is asked."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--cases", type=int, default=0)
    parser.add_argument("--price", action="store_true")
    asked = parser.parse_args()
    if asked.price:
        for name, again, first in prices():
            print(f"{name:28} {again:.2f}, the first {first:.2f}", flush=True)
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
