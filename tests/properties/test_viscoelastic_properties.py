"""Random viscoelastic nips, wrapped nips and rollers: a certificate, or a rejection."""

from __future__ import annotations

import pytest
from random_nips import random_viscoelastic

import woundon as wo

SEEDS = range(9)


@pytest.mark.parametrize("seed", SEEDS)
def test_solved_or_rejected(seed: int) -> None:
    try:
        result = wo.solve(random_viscoelastic(seed))
    except (wo.InvalidProblem, wo.NoSteadyState, wo.NotConverged) as rejected:
        reasons = ("must be", "is needed", "too soft", "too thin", "the surfaces part")
        assert any(reason in str(rejected) for reason in reasons)  # noqa: PT017
    else:
        assert result.residuals.largest <= 1e-8


def test_the_sample_is_of_every_sort() -> None:
    problems = [random_viscoelastic(seed) for seed in range(20)]
    assert {type(p) for p in problems} == {wo.NipProblem, wo.NipProblem, wo.RollerProblem}
    assert {type(p.bodies[1]) for p in problems} == {wo.HalfPlane, wo.Cylinder, wo.Layered}
    assert any(p.bodies[0].viscoelastic for p in problems)
    assert all(p.viscoelastic for p in problems)
