"""Random viscoelastic nips, wrapped nips and rollers: a certificate, or a refusal that says why."""

from __future__ import annotations

import pytest
from viscoelastic import ending, random_viscoelastic

import woundon as wo

# some of the 200 of benchmarks/viscoelastic.py
SEEDS = range(9)


@pytest.mark.parametrize("seed", SEEDS)
def test_solved_or_refused(seed: int) -> None:
    how, residual = ending(seed)
    if how == "solved":
        assert residual <= 1e-8
    else:
        assert any(why in how for why in ("must be", "too soft", "too thin", "the surfaces part"))


def test_the_sample_is_of_every_sort() -> None:
    problems = [random_viscoelastic(seed) for seed in range(9)]
    assert {type(p) for p in problems} == {wo.NipProblem, wo.WrappedNipProblem, wo.RollerProblem}
    assert {type(p.bodies[1]) for p in problems} == {wo.HalfPlane, wo.Cylinder, wo.Layered}
    assert any(p.bodies[0].viscoelastic for p in problems)
    assert all(p.viscoelastic for p in problems)
