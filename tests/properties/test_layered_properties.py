"""Random layered and graded nips: a certificate, or a refusal that says why."""

from __future__ import annotations

from functools import cache

import pytest
from layered import ending as _ending
from layered import random_layered
from seldom import seldom

import woundon as wo

ending = cache(_ending)

# some of the 300 of benchmarks/layered.py: coatings of micrometres, open bores, graded rolls, and
# cases that are refused: 3, 34 and 219 are tubes that the load flattens; of 349 the load jumps with
# the width on 33 nodes, so that the mesh between 17 and 65 has no answer
SEEDS = [0, 1, 3, 4, 5, 6, 13, 17, 24, 34, 42, 219, 349]


@pytest.mark.parametrize("seed", [seldom(seed) if seed in (5, 34, 42) else seed for seed in SEEDS])
def test_solved_or_refused(seed: int) -> None:
    how, residual = ending(seed)
    if how == "solved":
        assert residual <= 1e-8
    else:
        assert how.startswith("refused: ")
        assert "must be" in how


def test_the_sample_is_one_of_every_sort() -> None:
    endings = [ending(seed)[0].partition(":")[0] for seed in (0, 3, 4)]
    assert sorted(set(endings)) == ["refused", "solved"]
    drums = {random_layered(seed).drum.core for seed in (0, 1, 5, 6, 42)}
    rolls = {type(random_layered(seed).roll) for seed in (0, 1, 5, 6, 42)}
    assert drums == {"rigid", "free"}
    assert rolls == {wo.WoundRoll, wo.Layered}
