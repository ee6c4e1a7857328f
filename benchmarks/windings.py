"""Windings: what they cost, how far the effective roll is off, starts that differ, random cases.

    python benchmarks/windings.py speed       newsprint 0.05 to 0.6 m, each roll body
    python benchmarks/windings.py effective   the effective roll against the direct one
    python benchmarks/windings.py starts      the same roll from starts far apart
    python benchmarks/windings.py random [CASES] [SEED]

Times are processor time; a dense solve of 398 unknowns stands beside them, for machines differ.
"""

from __future__ import annotations

import sys
import time
import warnings
from collections.abc import Iterator
from typing import Any

import numpy as np

import woundon as wo

CASE = wo.WindingProblem.example()
COVER = wo.Cylinder(
    radius=0.25, core_radius=0.235, material=wo.Isotropic(youngs_modulus=20e6, poissons_ratio=0.4)
)
FILM = wo.WindingProblem(
    web=wo.Web(
        thickness=25e-6,
        material=wo.Orthotropic(radial=200e6, tangential=4.5e9, cross=20e6, shear=100e6),
    ),
    stack=wo.Stack(
        radial=wo.Pfeiffer(K1=5e3, K2=150.0), tangential=4.5e9, poissons_ratio=0.01, shear=30e6
    ),
    core=wo.Core(radius=0.0762, stiffness=5e9), drum=COVER.replace(radius=0.1, core_radius=0.085),
    radius=0.3, roll_friction=0.3, drum_friction=0.5,
    web_tension=wo.Taper(start=150.0, taper=0.25), nip_load=400.0, density=1390.0,
)  # fmt: skip
# newsprint's stack three times: that of the example, looser and stiffer
COMPARED = {
    "newsprint, 2 kN/m": CASE,
    "4 kN/m": CASE.replace(nip_load=4000.0),
    "0.7 kN/m": CASE.replace(nip_load=700.0),
    "stack K1 1 kPa, K2 80": CASE.replace(**{"stack.radial": wo.Pfeiffer(K1=1e3, K2=80.0)}),
    "stack K1 100 kPa, K2 40": CASE.replace(**{"stack.radial": wo.Pfeiffer(K1=100e3, K2=40.0)}),
    "stack K1 10 kPa, K2 150": CASE.replace(**{"stack.radial": wo.Pfeiffer(K1=10e3, K2=150.0)}),
    "covered drum": CASE.replace(drum=COVER),
    "film": FILM,
    "surface winding": CASE.replace(torque_split=1.0),
}


def timed(problem: wo.WindingProblem, **options: Any) -> tuple[wo.WindingResult, float]:
    """Return a winding and its processor time [s]."""
    start = time.process_time()
    run = wo.solve(problem, **options)
    return run, time.process_time() - start


def dense_solve() -> float:
    """Return the processor time of a dense solve of 398 unknowns [s]."""
    matrix = np.random.default_rng(0).normal(size=(398, 398))
    taken = []
    for _ in range(15):
        start = time.process_time()
        np.linalg.solve(matrix, matrix[0])
        taken.append(time.process_time() - start)
    return float(np.median(taken))


def speed() -> None:
    """Newsprint 0.05 to 0.6 m."""
    wo.solve(CASE.replace(radius=0.1, roll_body="linear"), rtol=0.05)
    for body in ("linear", "effective", "direct"):
        dense = dense_solve()
        run, taken = timed(CASE.replace(roll_body=body))
        print(
            f"{body:10s} {taken:6.1f} s, {taken / dense:6.0f} solves of {1e3 * dense:.1f} ms;"
            f" {run.nip_radius.size} radii, {run.nips_solved} nips, interpolation "
            f"{run.interpolation_error:.1e}, residual {run.residual:.1e}", flush=True,
        )  # fmt: skip


def effective() -> None:
    """What the effective roll is off, of the added tension, of the pressures."""
    print(
        f"{'':26s}{'WOT at the nips':>18s}{'NIT':>16s}{'mean WOT':>10s}{'P core':>8s}{'P mid':>8s}"
    )
    for name, problem in COMPARED.items():
        try:
            one, two = (
                wo.solve(problem.replace(roll_body=body)) for body in ("effective", "direct")
            )
        except (wo.InvalidProblem, wo.NotConverged) as stop:
            print(f"{name:26s}{str(stop)[:90]}", flush=True)
            continue
        r = two.nip_radius
        T, S = (np.interp(r, run.radius, run.wound_on_tension) for run in (one, two))
        added = S - two.problem.at("web_tension", r)
        off, of_added = 100 * (T / S - 1), 100 * (T - S) / np.abs(added)
        rest = [100 * (getattr(one, n) / getattr(two, n) - 1)
                for n in ("mean_wound_on_tension", "core_pressure", "mid_pressure")]  # fmt: skip
        print(f"{name:26s}{off.min():8.1f} to {off.max():4.1f} %{of_added.min():7.1f} to "
              f"{of_added.max():4.1f} %{rest[0]:8.1f} %{rest[1]:6.1f} %{rest[2]:6.1f} %",
              flush=True)  # fmt: skip


def starts() -> None:
    """The same roll from starts far apart."""
    far = wo.solve(
        CASE.replace(roll_body="linear", nip_load=500.0,
                     web_tension=wo.Taper(start=800.0, taper=-0.4)), rtol=1e-2
    )  # fmt: skip
    r = np.linspace(0.05, 0.6, 400)
    for body, agreed in (("linear", 1e-7), ("effective", 1e-7), ("direct", None)):
        problem = CASE.replace(roll_body=body)
        one, two = (wo.solve(problem, agreed=agreed, start=start) for start in (None, far))
        P, Q = (run.roll.at_radius(r)["pressure"] for run in (one, two))
        W, V = (np.interp(r, run.radius, run.wound_on_tension) for run in (one, two))
        print(f"{body:10s} pressure differs by {np.max(np.abs(P - Q)) / np.max(P):.1e} of the "
              f"largest, tension by {np.max(np.abs(W / V - 1)):.1e}", flush=True)  # fmt: skip


def cases(count: int, seed: int) -> Iterator[wo.WindingProblem]:
    """Yield random windings: paper and film, all schedules, bodies and laws."""
    rng = np.random.default_rng(seed)

    def log(low: float, high: float) -> float:
        return float(np.exp(rng.uniform(np.log(low), np.log(high))))

    while count:
        count -= 1
        core = log(0.02, 0.15)
        radius = core * log(1.3, 12)
        T, P = log(40, 900), log(150, 8000)
        tension: Any = T
        if rng.random() < 0.6:
            law = str(rng.choice(["linear", "hyperbolic", "constant_torque"]))
            taper = 0.0 if law == "constant_torque" else rng.uniform(-0.2, 0.6)
            tension = wo.Taper(start=T, taper=taper, law=law)
        load: Any = P
        if rng.random() < 0.3:
            middle = rng.uniform(core, radius)
            load = wo.Profile(radius=[core, middle, radius], value=[P, P * log(0.5, 2), P])
        material = wo.Orthotropic(
            radial=log(1e7, 3e8), tangential=log(2e9, 8e9), cross=5e6, shear=log(5e6, 1e8)
        )
        drum = log(0.06, 0.7)
        yield wo.WindingProblem(
            web=wo.Web(thickness=log(15e-6, 200e-6), material=material),
            stack=wo.Stack(radial=wo.Pfeiffer(K1=log(2e3, 2e5), K2=log(20, 200)),
                           tangential=material.tangential, poissons_ratio=0.01,
                           shear=log(5e6, 4e7)),
            core=wo.Core(radius=core, stiffness=log(1e8, 3e10)), radius=radius,
            drum=wo.Rigid(radius=drum) if rng.random() < 0.6 else wo.Cylinder(
                radius=drum, core_radius=0.93 * drum,
                material=wo.Isotropic(youngs_modulus=log(5e6, 1e8), poissons_ratio=0.4)),
            roll_friction=log(0.1, 0.6), drum_friction=log(0.1, 0.7), web_tension=tension,
            nip_load=load, drum_wrap=float(rng.choice([0.0, 1.0])),
            torque_split=None if rng.random() < 0.5 else float(rng.uniform(0, 1)),
            roll_body=str(rng.choice(["effective", "effective", "linear"])),
            tension_law=str(rng.choice(["nip", "nip", "nip", "friction"])),
        )  # fmt: skip


def ending(made: Iterator[wo.WindingProblem]) -> Iterator[str]:
    """Yield how each case ends: solved with a certificate, refused, or anything else."""
    while True:
        try:
            problem = next(made)
        except StopIteration:
            return
        try:
            run = wo.solve(problem, nodes=33, rtol=1e-2)
            yield "certificate" if run.certified().largest <= 1e-8 else f"NO: {run.residuals}"
        except (wo.InvalidProblem, wo.NotConverged) as stop:
            yield f"{type(stop).__name__}: {stop}"


def random(count: int = 50, seed: int = 0) -> None:
    """Random windings: certificate or clear refusal."""
    told: dict[str, int] = {}
    for k in range(count):
        start = time.process_time()
        try:
            text = next(ending(cases(1, 1000 * seed + k)))
        except wo.InvalidProblem as stop:
            text = f"{type(stop).__name__}: {stop}"
        word = text.partition(":")[0]
        told[word] = told.get(word, 0) + 1
        print(f"{k:3d} {time.process_time() - start:5.1f} s  {text[:150]}", flush=True)
    print(told)


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    name, *rest = sys.argv[1:] or ["speed"]
    {"speed": speed, "effective": effective, "starts": starts, "random": random}[name](
        *map(int, rest)
    )
