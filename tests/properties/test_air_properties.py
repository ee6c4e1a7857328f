"""Random nips with air: a certificate, or a rejection that names the field."""

from __future__ import annotations

import pytest
from random_nips import random_air
from slow_cases import slow_case

import woundon as wo

SEEDS = (0, 1, 2, 3, 5, 8, 15, 142)


@pytest.mark.parametrize("seed", [slow_case(seed) if seed in (5, 142) else seed for seed in SEEDS])
def test_solved_or_rejected(seed: int) -> None:
    try:
        result = wo.solve(random_air(seed))
    except (wo.InvalidProblem, wo.NoSteadyState) as rejected:
        assert "must be" in str(rejected) or "is needed" in str(rejected)  # noqa: PT017
    else:
        assert result.residuals.largest <= 1e-8


def test_the_sample_is_of_every_sort() -> None:
    problems = [random_air(seed) for seed in range(20)]
    assert {p.viscoelastic for p in problems} == {True, False}
    assert {p.drum_wrap > 0 for p in problems} == {True, False}
    assert {p.air.permeance > 0 for p in problems} == {True, False}
