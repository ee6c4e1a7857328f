"""Random nips with air over speed: a certificate or a clear refusal.

    python benchmarks/air.py --cases 50     endings, and what each refusal says

As random_nips.py and, where the drum is viscoelastic, a third of them, viscoelastic.py; speeds from
1 cm/s to 100 m/s; roughness of 0.05 um to a third of the web's thickness; a third of the webs lets
air through, 1e-10 to 1e-5 m/Pa/s; wraps of 0 to 2 rad on the drum in half of the cases.
"""

from __future__ import annotations

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
from collections import Counter

import numpy as np
from random_nips import _Draw, random_nip
from viscoelastic import RESIDUAL, _drum

import woundon as wo

__all__ = ["ending", "random_air"]


def random_air(seed: int) -> wo.AirNipProblem:
    """Return the problem that belongs to a seed; always the same one.

    Raises
    ------
    InvalidProblem
        If what was drawn is not admissible.
    """
    draw, plain = _Draw(3_000_000 + seed), random_nip(seed)
    drum = _drum(draw, plain.drum.radius) if seed % 3 == 2 else plain.drum
    air = wo.Air(
        roughness=draw.log(0.05e-6, plain.web.thickness / 3),
        permeance=draw.log(1e-10, 1e-5) if draw.random.random() < 1 / 3 else 0.0,
    )
    fields = {name: getattr(plain, name) for name in wo.NipProblem.model_fields}
    wrap = draw.even(0.0, 2.0) * (seed % 2)
    speed = draw.log(1e-2, 100.0)
    fields |= {"drum": drum, "drum_wrap": wrap, "web_speed": speed, "air": air}
    return wo.AirNipProblem(**fields)


def ending(seed: int) -> tuple[str, float]:
    """Return how a random case ends, "solved" or what the refusal says, and its residual."""
    try:
        result = wo.solve(random_air(seed))
    except (wo.InvalidProblem, wo.NoSteadyState) as refusal:
        return f"refused: {refusal}", 0.0
    except wo.NotConverged as failure:
        return f"NOT SOLVED: {failure}", np.inf
    return "solved", result.residuals.largest


def main() -> None:
    """Run what is asked."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--cases", type=int, default=50)
    endings: Counter[str] = Counter()
    for seed in range(parser.parse_args().cases):
        how, residual = ending(seed)
        if how != "solved" or residual > RESIDUAL:
            print(seed, how[:180], f"{residual:.1e}", flush=True)
        endings[how.partition(":")[0]] += 1
    print(dict(endings))


if __name__ == "__main__":
    main()
