"""Random wound rolls: certificate or clear refusal, and told errors against true ones.

    python benchmarks/rolls.py random [--cases 200] [--seed 0]
    python benchmarks/rolls.py told [--cases 30] [--seed 0]     against rtol 1e-6, and against laps

Paper, film, foil and board; every radial law, schedule and core; hot, cold, on cores that shrink.
A case that ends in anything but a certificate or a refusal of the program makes the exit code 1.
"""

from __future__ import annotations

import argparse
import sys
import time
import warnings
from collections import Counter
from collections.abc import Iterator
from typing import Any

import numpy as np

import woundon as wo

LAWS = ("Pfeiffer", "Polynomial", "PowerLaw", "StackTest", "constant")
SCHEDULES = ("constant", "linear", "hyperbolic", "constant_torque", "profile", "smooth")


def cases(count: int, seed: int) -> Iterator[tuple[str, wo.RollProblem | Exception]]:
    """Yield the name and the problem of each case, or why it is none."""
    for k in range(count):
        rng = np.random.default_rng([seed, k])
        law, schedule = LAWS[k % len(LAWS)], str(rng.choice(SCHEDULES))
        try:
            yield f"{law}, {schedule}", _roll(rng, law, schedule)
        except wo.InvalidProblem as fault:
            yield f"{law}, {schedule}", fault


def _log(rng: Any, low: float, high: float) -> float:
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def _roll(rng: Any, law: str, schedule: str) -> wo.RollProblem:
    core, h = _log(rng, 0.01, 0.2), _log(rng, 8e-6, 5e-4)
    radius = core * _log(rng, 1.1, 15)
    tangential, nu = _log(rng, 0.2e9, 80e9), rng.uniform(0, 0.05)
    stress = tangential * _log(rng, 1e-4, 1e-2)  # strains that webs bear
    tube = rng.random() < 0.3
    more: dict[str, Any] = {}
    if rng.random() < 0.3:
        more = {"temperature_change": rng.uniform(-40, 40),
                "tangential_expansion": _log(rng, 1e-6, 5e-5),
                "radial_expansion": _log(rng, 1e-6, 2e-4), "core_expansion": 1.2e-5}  # fmt: skip
    if rng.random() < 0.2:
        more["core_shrinkage"] = rng.uniform(-1e-3, 1e-3)
    return wo.RollProblem(
        core=wo.Core(radius=core, inner_radius=core * rng.uniform(0, 0.95),
                     material=wo.Isotropic(youngs_modulus=_log(rng, 0.3e9, 200e9),
                                           poissons_ratio=0.3))
        if tube else wo.Core(radius=core, stiffness=_log(rng, 3e7, 1e11)),
        radius=radius, web_thickness=h, density=_log(rng, 400, 3000),
        stack=wo.Stack(radial=_law(rng, law), tangential=tangential, poissons_ratio=nu, shear=1e7),
        wound_on_tension=_tension(rng, schedule, stress * h, core, radius), **more,
    )  # fmt: skip


def _law(rng: Any, law: str) -> Any:
    K1, K2 = _log(rng, 1e3, 2e5), _log(rng, 10, 400)
    if law == "Polynomial":
        return wo.Polynomial(coefficients=[K1 * K2, K2, rng.uniform(-1, 1) * K2 / 5e6])
    if law == "PowerLaw":
        return wo.PowerLaw(E0=_log(rng, 1e4, 1e6), k=_log(rng, 1e6, 5e7), m=rng.uniform(0.2, 1.5))
    if law == "StackTest":
        P = np.concatenate([[0.0], np.geomspace(1e3, 3e6, 25)])
        return wo.StackTest(pressure=P, strain=np.log1p(P / K1) / K2)
    return _log(rng, 1e6, 3e9) if law == "constant" else wo.Pfeiffer(K1=K1, K2=K2)


def _tension(rng: Any, schedule: str, T: float, core: float, radius: float) -> Any:
    if schedule == "constant":
        return T
    if schedule in ("profile", "smooth"):
        r = np.sort(rng.uniform(core, radius, int(rng.integers(1, 12))))
        r = np.unique([core, *r, radius])
        value = T * np.exp(rng.normal(0, 0.2, r.size))
        return wo.Profile(
            radius=r, value=value, between="smooth" if schedule == "smooth" else "lines"
        )
    taper = 0.0 if schedule == "constant_torque" else rng.uniform(-0.3, 0.8)
    return wo.Taper(start=T, taper=taper, law=schedule)


def ending(problem: wo.RollProblem | Exception) -> str:
    """Return how a case ends: "certificate", or why it is refused, or else what is wrong."""
    if isinstance(problem, wo.InvalidProblem):
        return f"refused: {problem}"
    try:
        result = wo.solve(problem)
    except (wo.InvalidProblem, wo.NotConverged) as stop:
        return f"{'refused' if isinstance(stop, wo.InvalidProblem) else 'not converged'}: {stop}"
    except Exception as fault:  # whatever it is: that it is none is what is looked for
        return f"NO: {type(fault).__name__}: {fault}"
    left = result.certified().largest
    return "certificate" if left <= 1e-8 else f"NO: residual {left:.1e}"


def random(count: int, seed: int) -> int:
    """Solve random rolls; return how many ended in neither certificate nor refusal."""
    told: Counter[str] = Counter()
    for k, (name, problem) in enumerate(cases(count, seed)):
        start = time.process_time()
        text = ending(problem)
        told[text.partition(":")[0]] += 1
        if text != "certificate":
            print(f"{k:4d} {time.process_time() - start:5.1f} s  {name}: {text[:230]}", flush=True)
    print(dict(told))
    return told["NO"]


def told(count: int, seed: int) -> int:
    """Compare told errors with true ones, without what finite laps change."""
    ratios = []
    for k, (_, problem) in enumerate(cases(10 * count, seed)):
        if len(ratios) == count or isinstance(problem, Exception):
            continue
        try:
            ratios.append(missed(problem))
        except wo.NotConverged as stop:
            print(f"{k:4d} {stop}", flush=True)
    print(f"{len(ratios)} rolls: missed/told median {np.median(ratios):.2f}, "
          f"90 % below {np.quantile(ratios, 0.9):.2f}, largest {max(ratios):.2f}")  # fmt: skip
    return 0


def missed(problem: wo.RollProblem) -> float:
    """Return what a default solution misses of one to rtol 1e-6, of what is told."""
    result, fine = wo.solve(problem), wo.solve(problem, rtol=1e-6)
    r = np.union1d(np.linspace(problem.core.radius, problem.radius, 400), result.radius)
    miss = np.abs(result.at_radius(r)["pressure"] - fine.at_radius(r)["pressure"]).max()
    return float(miss / (result.errors["peak_pressure"] - np.abs(result.finite_laps).max()))


def main() -> int:
    """Run what is asked for."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("what", choices=["random", "told"])
    options.add_argument("--cases", type=int)
    options.add_argument("--seed", type=int, default=0)
    given = options.parse_args()
    warnings.simplefilter("ignore")
    run = {"random": random, "told": told}[given.what]
    count = given.cases or {"random": 200, "told": 30}[given.what]
    return 1 if run(count, given.seed) else 0


if __name__ == "__main__":
    sys.exit(main())
