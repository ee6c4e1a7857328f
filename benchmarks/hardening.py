"""Random nips of hardening rolls: the certificate, or a clear refusal; and what they cost.

    python benchmarks/hardening.py cases --cases 300     certificate <= 1e-8, told errors, refusals
    python benchmarks/hardening.py cases --web           the web hardens too, by the roll's stack
    python benchmarks/hardening.py price                 Table 2's nip, in dense solves of 398 x 398

Prices are processor time over that of a dense solve, measured before and after each nip.
"""

from __future__ import annotations

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
from collections.abc import Callable
from math import pi
from operator import attrgetter
from time import process_time
from typing import Any

import numpy as np

import woundon as wo
from woundon.problems.wound_roll import ring_of

UNKNOWNS = 398
REFUSED = (wo.InvalidProblem, wo.NoSteadyState)


def random_stack(rng: np.random.Generator, P0: float) -> wo.Stack:
    """Return a stack of any law whose modulus at P0 is a few to fifty MPa."""
    E = 10 ** rng.uniform(6.3, 7.7)
    share = rng.uniform(0.05, 1.0)  # of K1 + P0 that is K1
    Q = max(P0, 1e3) / (1 - min(share, 0.95))
    kind = rng.choice(["pfeiffer", "pfeiffer", "power", "polynomial", "test"])
    radial: Any
    if kind == "pfeiffer":
        radial = wo.Pfeiffer(K1=Q * share, K2=E / Q)
    elif kind == "power":
        radial = wo.PowerLaw(E0=0.2 * E, k=0.8 * E / (Q / 1e5) ** 0.7, m=0.7)
    elif kind == "polynomial":
        radial = wo.Polynomial(coefficients=(0.2 * E, 0.8 * E / Q, -0.1 * E / Q / 1e7))
    else:
        P = np.geomspace(0.02 * Q, 40 * Q, 12)
        radial = wo.StackTest(pressure=P, strain=np.log1p(P / Q / share) / (E / Q))
    return wo.Stack(
        radial=radial, tangential=10 ** rng.uniform(9, 9.8), poissons_ratio=rng.uniform(0, 0.2),
        shear=E * 10 ** rng.uniform(-0.7, 0.3),
        shear_exponent=float(rng.choice([0.0, 0.0, 0.5, 1.0])),
    )  # fmt: skip


def random_nip(rng: np.random.Generator) -> wo.Problem:
    """Return a nip, wrapped or not, of a web of the stack's own stiffness at light pressure."""
    P0 = 10 ** rng.uniform(3.5, 5.7)
    stack = random_stack(rng, P0)
    rr, tt, rt, shear = stack.tangent(P0)[:4]
    R = rng.uniform(0.1, 0.6)
    mu, load = rng.uniform(0.1, 0.5), 10 ** rng.uniform(1.5, 3.9)
    web = wo.Orthotropic(radial=rr, tangential=tt, cross=rt, shear=shear)
    plain = wo.NipProblem(
        web=wo.Web(thickness=rng.uniform(20e-6, 150e-6), material=web),
        roll=wo.WoundRoll(
            radius=R, core_radius=R * rng.uniform(0.1, 0.7), stack=stack, pressure=P0
        ),
        drum=wo.Rigid(radius=rng.uniform(0.05, 0.6)), roll_friction=rng.uniform(0.1, 0.5),
        drum_friction=mu, nip_load=load, winding_force=rng.uniform(-0.6, 0.6) * mu * load,
        web_tension=10 ** rng.uniform(2, 3),
    )  # fmt: skip
    return plain.wrapped(roll_wrap=rng.uniform(0.3, pi)) if rng.random() < 0.4 else plain


def cases(count: int, seed: int, nodes: int, web: bool = False) -> int:
    """Solve random nips; return how many ended otherwise than by certificate or refusal."""
    rng, ends, failed = np.random.default_rng(seed), {"solved": 0, "refused": 0}, 0
    worst = 0.0
    for k in range(count):
        problem: Any = None
        try:
            problem = random_nip(rng)
            if web:
                problem = problem.replace(**{"web.material": problem.roll.stack})
            result = wo.solve(problem, nodes=nodes)
        except REFUSED as stop:
            ends["refused"] += 1
            print(f"{k:4d} refused: {stop}", flush=True)
        except wo.NotConverged as stop:
            failed += 1
            print(f"{k:4d} NOT CONVERGED: {stop}\n     {problem!r}", flush=True)
        else:
            ends["solved"] += 1
            worst = max(worst, result.residuals.largest)
    print(f"{count} nips: {ends['solved']} solved, largest residual {worst:.1e}; "
          f"{ends['refused']} refused; {failed} not converged")  # fmt: skip
    return failed


# ---- prices -------------------------------------------------------------------------------------


def dense_solve() -> float:
    """Return the processor time of a dense solve [s], the least of several."""
    rng = np.random.default_rng(0)
    A, b = rng.random((UNKNOWNS, UNKNOWNS)), rng.random(UNKNOWNS)
    times = []
    for _ in range(15):
        start = process_time()
        np.linalg.solve(A, b)
        times.append(process_time() - start)
    return float(np.median(times))


def priced(solve: Callable[[], Any], cold: bool) -> tuple[Any, float]:
    """Return what a solve gives and its price."""
    if cold:
        ring_of.cache_clear()
    before, start = dense_solve(), process_time()
    result = solve()
    taken = process_time() - start
    return result, taken / ((before + dense_solve()) / 2)


FITTED = ("roll.stack.radial.K1", "roll.stack.radial.K2", "roll.pressure", "roll.stack.shear")


def _differences(found: Any) -> None:
    """Solve what central differences by the same fields take, each from the nip itself."""
    for name in FITTED:
        value = attrgetter(name)(found.problem)
        for step in (2e-3, -2e-3):
            wo.solve(found.problem.replace(**{name: value * (1 + step)}), start=found)


def price() -> None:
    """Print the prices of Table 2's nip, plain and wrapped, cold, near and of derivatives."""
    web: Any = wo.material("newsprint")
    stack = wo.Stack(
        radial=wo.Pfeiffer(K1=10e3, K2=127.0),
        tangential=web.tangential - web.cross**2 / web.radial,
        poissons_ratio=web.cross / web.radial, shear=10e6,
    )  # fmt: skip
    plain = wo.NipProblem(
        web=wo.Web(thickness=66e-6, material=web),
        roll=wo.WoundRoll(radius=0.1, core_radius=0.0445, stack=stack, pressure=90e3),
        drum=wo.Rigid(radius=0.0762), roll_friction=0.19, drum_friction=0.2,
        nip_load=3502.0, winding_force=0.0, web_tension=350.0,
    )  # fmt: skip
    for name, problem, asked in (
        ("plain", plain, (2000, 700)), ("wrapped", plain.wrapped(roll_wrap=pi / 2), (3000, 1200)),
    ):  # fmt: skip
        near = problem.replace(**{"roll.stack.radial.K2": 130.0})
        wo.solve(problem, nodes=17)  # orderings of unknowns and the like are made once
        first, cold = priced(lambda problem=problem: wo.solve(problem), cold=True)
        found, warm = priced(lambda near=near, first=first: wo.solve(near, start=first), cold=False)
        print(f"{name:8} {first.x.size:4d} nodes  cold {cold:6.0f} (asked {asked[0]})  "
              f"from a neighbour {warm:6.0f} (asked {asked[1]})", flush=True)  # fmt: skip
        _, slopes = priced(lambda found=found: found.sensitivity(*FITTED), cold=False)
        _, differences = priced(lambda found=found: _differences(found), cold=False)
        print(f"{name:8} {len(FITTED)} derivatives {slopes:6.0f}, "
              f"by central differences {differences:6.0f}", flush=True)  # fmt: skip


def main() -> None:
    """Run what is asked."""
    asked = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    asked.add_argument("what", choices=("cases", "price"))
    asked.add_argument("--cases", type=int, default=300)
    asked.add_argument("--seed", type=int, default=1)
    asked.add_argument("--nodes", type=int, default=33)
    asked.add_argument("--web", action="store_true")
    given = asked.parse_args()
    if given.what == "price":
        price()
    elif cases(given.cases, given.seed, given.nodes, given.web):
        raise SystemExit(1)


if __name__ == "__main__":
    main()
