"""Random thickness profiles, and the rolls that they are wound into."""

from __future__ import annotations

import numpy as np

import woundon as wo

STACKS = {
    "newsprint, K2 40": ({"K1": 10e3, "K2": 40.0}, 3.38e9, 66e-6, 350.0),
    "newsprint, K2 127": ({"K1": 10e3, "K2": 127.0}, 3.38e9, 66e-6, 350.0),
    "PET": ({"K1": 2e3, "K2": 200.0}, 4.8e9, 50e-6, 175.0),
}


def random_profile(rng: np.random.Generator, largest: float = 0.02) -> wo.ThicknessProfile:
    """Return a profile of a few waves, bands, steps and noise, of at most ``largest`` in all."""
    width, points = float(rng.uniform(0.5, 8.0)), int(rng.integers(5, 600))
    y = np.sort(np.concatenate([[0, width], rng.uniform(0, width, points)]))
    y = y[np.concatenate([[True], np.diff(y) > 1e-6 * width])]
    d = np.zeros(y.size)
    for _ in range(int(rng.integers(1, 4))):
        d += rng.normal() * np.cos(2 * np.pi * (rng.uniform(0.3, 8) * y / width + rng.uniform()))
    for _ in range(int(rng.integers(0, 3))):  # bands of any width
        centre, extent = rng.uniform(0, width), width * 10 ** rng.uniform(-2.5, -0.5)
        d += 2 * rng.normal() * np.exp(-(((y - centre) / extent) ** 2))
    if rng.uniform() < 0.3:
        d += 0.3 * rng.normal(size=y.size)
    if rng.uniform() < 0.3:  # thin edges
        d -= 2 * rng.uniform() * np.exp(-np.minimum(y, width - y) / (0.02 * width))
    d *= largest * rng.uniform(0.05, 1) / np.max(np.abs(d))
    return wo.ThicknessProfile(position=y, thickness=1 + d)


def random_roll(rng: np.random.Generator) -> wo.RollProblem:
    """Return a roll of one of three webs with a random profile."""
    law, E_t, h, tension = STACKS[str(rng.choice(list(STACKS)))]
    stack = wo.Stack(radial=wo.Pfeiffer(**law), tangential=E_t, poissons_ratio=0.01, shear=10e6)
    core = float(rng.uniform(0.03, 0.1))
    start = float(tension * rng.uniform(0.5, 1.3))
    profile = random_profile(rng)
    return wo.RollProblem(
        core=wo.Core(radius=core, stiffness=10 ** rng.uniform(8, 10.5)),
        radius=float(core * rng.uniform(1.5, 8)),
        stack=stack,
        web_thickness=h,
        wound_on_tension=wo.Taper(start=start, taper=float(rng.uniform(0, 0.5))),
        thickness_profile=profile,
        oscillation=float(profile.width * 10 ** rng.uniform(-3, -1))
        if rng.uniform() < 0.3
        else 0.0,
    )
