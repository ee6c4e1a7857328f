"""Random nips with air over speed: a certificate, or a refusal that says why."""

from __future__ import annotations

import pytest
from air import ending, random_air
from seldom import seldom

# of every sort: rigid, elastic and viscoelastic drums, with and without a wrap, permeable webs;
# 15 is refused
SEEDS = (0, 1, 2, 5, 15)


@pytest.mark.parametrize("seed", [seldom(seed) if seed == 5 else seed for seed in SEEDS])
def test_solved_or_refused(seed: int) -> None:
    how, residual = ending(seed)
    assert how.startswith("refused: web_tension") if seed == 15 else how == "solved"
    assert residual <= 1e-8


def test_a_mesh_that_friction_changes_to_and_fro_is_kept() -> None:
    """Chosen anew in every turn it was 41, 65, 41, 65 ... nodes, and friction went with it."""
    assert ending(142)[0] == "solved"


def test_the_sample_is_of_every_sort() -> None:
    problems = [random_air(seed) for seed in SEEDS]
    assert {p.viscoelastic for p in problems} == {True, False}
    assert {p.drum_wrap > 0 for p in problems} == {True, False}
    assert {p.air.permeance > 0 for p in problems} == {True, False}
