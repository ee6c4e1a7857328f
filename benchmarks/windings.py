"""Windings: what they cost, how far the effective roll is off, starts that differ, random cases.

    python benchmarks/windings.py speed       newsprint 0.05 to 0.6 m, each roll body
    python benchmarks/windings.py effective   the effective roll against the direct one
    python benchmarks/windings.py starts      the same roll from starts far apart
    python benchmarks/windings.py random [--cases 50] [--seed 0] [--out FILE]
    python benchmarks/windings.py measured    tables with noise, against nips under their loads
    python benchmarks/windings.py optimise    the newsprint schedule, its nips solved

``random`` keeps each case's ending in a file and goes on where it was stopped.  Times are processor
time; a dense solve of 398 unknowns stands beside them, for machines differ.
"""

from __future__ import annotations

import argparse
import time
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

import woundon as wo
from woundon.winding.bodies import hardening_roll
from woundon.winding.nips import Nips

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
    """What the effective roll is off: direct nips on the same roll, where it is small and large."""
    print(f"{'':26s}{'radius m':>9s}{'WOT N/m':>9s}{'direct':>8s}{'off':>8s}{'of NIT':>8s}")
    for name, problem in COMPARED.items():
        run = wo.solve(problem, rtol=1e-2, agreed=1e-4)
        radii = run.nip_radius[run.nip_radius >= 1.0499 * problem.core.radius]
        for r in radii[[1, radii.size // 2, -1]].tolist():
            try:
                nip = wo.solve(problem.nip(r, hardening_roll(problem, run.roll.at(r))), nodes=65)
            except wo.NotConverged as stop:
                print(f"{name:26s}{r:9.3f}  {str(stop)[:80]}", flush=True)
                continue
            wound, due = np.interp(r, run.radius, run.wound_on_tension), nip.roll_wound_on_tension
            of_added = (wound - due) / (due - nip.problem.web_tension)
            print(f"{name:26s}{r:9.3f}{wound:9.1f}{due:8.1f}{100 * (wound / due - 1):6.1f} %"
                  f"{100 * of_added:6.1f} %", flush=True)  # fmt: skip


def starts() -> None:
    """The same roll from starts far apart."""
    far = wo.solve(
        CASE.replace(roll_body="linear", nip_load=500.0,
                     web_tension=wo.Taper(start=800.0, taper=-0.4)), rtol=1e-2
    )  # fmt: skip
    for body, options in (
        ("linear", {"agreed": 1e-7}),
        ("effective", {"agreed": 1e-7}),
        # nips of 33 nodes on a roll of 0.1 m: as good a proof, at a tenth of the price
        ("direct", {"agreed": 1e-7, "nodes": 33, "rtol": 1e-2}),
    ):
        problem = CASE.replace(roll_body=body, radius=0.1 if body == "direct" else CASE.radius)
        one, two = (wo.solve(problem, start=start, **options) for start in (None, far))
        r = np.linspace(0.05, problem.radius, 400)
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


def random(count: int, seed: int, out: Path) -> None:
    """Random windings: certificate or clear refusal; those in the file are not wound again."""
    kept = out.read_text().splitlines() if out.exists() else []
    endings = dict(line.split("\t", 1) for line in kept if "\t" in line)
    for k in range(count):
        name = f"{seed}.{k}"
        if name in endings:
            continue
        start = time.process_time()
        try:
            endings[name] = next(ending(cases(1, 1000 * seed + k)))
        except wo.InvalidProblem as stop:
            endings[name] = f"{type(stop).__name__}: {stop}"
        with out.open("a") as file:
            file.write(f"{name}\t{endings[name].splitlines()[0]}\n")
        print(f"{name:>6s} {time.process_time() - start:5.1f} s  {endings[name][:150]}", flush=True)
    told: dict[str, int] = {}
    for k in range(count):
        word = endings[f"{seed}.{k}"].partition(":")[0]
        told[word] = told.get(word, 0) + 1
    print(told)


def measured() -> None:
    """Tension and nip load with noise: what is told, and what nips under these loads miss."""
    rng = np.random.default_rng(1)
    for count, noise in ((100, 0.02), (400, 0.02), (400, 0.05)):
        r = np.linspace(*CASE.ends, count)
        tension, load = (
            wo.Profile(radius=r, value=CASE.at(name, r) * (1 + noise * rng.standard_normal(count)))
            for name in ("web_tension", "nip_load")
        )
        run, taken = timed(CASE.replace(web_tension=tension, nip_load=load))
        nips = Nips(run.problem, run.nodes, run.agreed, lambda _: None, run.nips)
        at = rng.uniform(0.055, CASE.radius, 10).tolist()
        missed = [np.interp(r, run.radius, run.wound_on_tension) / nips.tension(r, run.roll) - 1
                  for r in at]  # fmt: skip
        print(f"{count} radii, {100 * noise:g} %: {run.nip_radius.size} radii, {run.nips_solved} "
              f"nips, {taken:.0f} s; told {run.interpolation_error:.1e}, missed by ten nips "
              f"{np.max(np.abs(missed)):.1e}, residual {run.residual:.1e}", flush=True)  # fmt: skip


def optimise(drawn: str = "") -> None:
    """The newsprint roll with the least compression that its limits allow, its nips solved."""
    limits = wo.Limits(layer_friction=0.19, torque_share=0.5, blocking_pressure=600e3,
                       core_pressure=800e3, slack_tension=150.0, web_strength=900.0)  # fmt: skip
    start = time.process_time()
    told = {"before": start}

    def tell(done: int, _: int) -> None:
        now = time.process_time()
        print(f"  winding {done}: {now - told['before']:.1f} s", flush=True)
        told["before"] = now

    found = wo.optimise_schedule(
        CASE, limits=limits, minimise="largest_compression", progress=tell, evaluations=40,
        options={"nodes": 33, "rtol": 5e-3},
    )  # fmt: skip
    print(found)
    print(f"{time.process_time() - start:.0f} s for {len(found.tried)} windings")
    if drawn:
        found.plot(drawn)


def main() -> None:
    """Print what is asked for."""
    reader = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    reader.add_argument("name", choices=("speed", "effective", "starts", "random", "measured",
                                         "optimise"))  # fmt: skip
    reader.add_argument("--cases", type=int, default=50, help="of random")
    reader.add_argument("--seed", type=int, default=0, help="of random")
    reader.add_argument("--out", type=Path, default=Path("windings_random.txt"),
                        help="file that keeps how the random cases end")  # fmt: skip
    reader.add_argument("--drawn", default="", help="file of the optimum's figure")
    given = reader.parse_args()
    if given.name == "random":
        random(given.cases, given.seed, given.out)
    elif given.name == "optimise":
        optimise(given.drawn)
    else:
        {"speed": speed, "effective": effective, "starts": starts, "measured": measured}[
            given.name
        ]()


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    main()
