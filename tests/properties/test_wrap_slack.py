"""Wrapped nips whose web becomes slack, or nearly so."""

from __future__ import annotations

import pytest
from random_nips import random_low_friction, random_wrapped_nip
from slow_cases import slow_case

import woundon as wo


def test_a_web_that_never_settles_at_a_wrong_width_is_reported_to_be_slack():
    """Within a percent of the load its tensions went on to and fro, all of them far below zero."""
    with pytest.raises(wo.NoSteadyState, match="leaves the web slack downstream of the nip"):
        wo.solve(random_wrapped_nip(306))


@pytest.mark.parametrize("seed", [1017081, slow_case(1019501)])
def test_a_slack_web_whose_load_jumps_with_the_width_is_reported_to_be_slack(seed: int) -> None:
    """From one width to the next by a tenth, about the load asked: two of 20 000 random nips."""
    with pytest.raises(wo.NoSteadyState, match="leaves the web slack downstream of the nip"):
        wo.solve(random_wrapped_nip(seed))


def test_a_web_that_is_slack_at_a_wrong_load_only_is_not_rejected():
    """A percent beyond the load asked it is; 0.25 % more web tension would do there too."""
    hardly = random_wrapped_nip(139).replace(web_tension=2385.0)
    result = wo.solve(hardly)
    assert result.tension.min() > 0
    assert result.residuals.largest < 1e-8


def test_a_web_that_the_winding_force_leaves_slack_at_any_width_is_rejected_without_a_mesh():
    """T_in + F + mu+ (P + |F|) < 0: no iteration converges on this very soft drum."""
    problem = random_low_friction(1100847)
    taut = -problem.winding_force - problem.roll_friction * problem.nip_load
    with pytest.raises(wo.NoSteadyState, match="downstream of the nip") as fault:
        wo.solve(problem)
    needed = float(str(fault.value).split("; about ")[1].split()[0])
    assert needed == pytest.approx(taut, rel=0.01)  # mu+ |F| is 0.8 % of it
