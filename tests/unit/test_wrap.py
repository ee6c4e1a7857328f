"""Nips with wraps: rejected values, fields of the problem, the nodes of the nip."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest
from thesis_cases import paper_nip

import woundon as wo
from woundon.jorkama2001.estimate import wound_on_tension_estimate

PAPER = paper_nip(web_tension=300.0)
QUICK = {"nodes": 25}


@pytest.fixture(scope="module")
def result() -> wo.NipResult:
    return wo.solve(PAPER.replace(roll_wrap=pi, drum_wrap=pi / 2), **QUICK)


def test_a_slack_web_is_rejected():
    slack = PAPER.replace(web_tension=0.0)
    with pytest.raises(wo.InvalidProblem, match=r"web_tension: 0 is .*must be taut"):
        wo.solve(slack.replace(roll_wrap=pi, drum_wrap=1.0))
    # NIT is about -320 N/m there
    pulled = PAPER.replace(winding_force=-700.0, roll_wrap=pi)
    with pytest.raises(wo.NoSteadyState, match="slack downstream of the nip") as fault:
        wo.solve(pulled)
    needed = float(str(fault.value).split("; about ")[1].split()[0])
    wo.solve(pulled.replace(web_tension=needed + 40), **QUICK)


def test_forces_that_slide_the_drum_are_rejected():
    with pytest.raises(wo.NoSteadyState, match="winding_force: 770 is out of range"):
        wo.solve(PAPER.replace(roll_wrap=pi, winding_force=770.0))
    assert wo.solve(PAPER.replace(roll_wrap=pi, winding_force=770.0, drum_wrap=1.0), **QUICK)


def test_the_nip_of_a_wrapped_result_is_its_nodes_in_nip(result):
    nip, x = result.in_nip, result.x
    assert (x[nip][0], x[nip][-1]) == (-result.half_width, result.half_width)
    assert result.nodes == x[nip].size == 25
    T, T_in = result.tension[nip], result.problem.web_tension
    # on the drum's arc the web has gained the drum's traction there, F less the nip's part
    force = np.trapezoid(result.drum_traction[nip], x[nip])
    assert force == pytest.approx(100 - (T[0] - T_in), rel=1e-9)
    assert result.drum_wrap_traction == pytest.approx(T[0] - T_in, rel=1e-3)
    assert np.isnan(result.roll_slip[: nip.start]).all()
    assert np.isnan(result.drum_slip[nip.stop :]).all()
    assert np.isnan(result.roll_strain[: nip.start]).all()
    assert np.isfinite(result.roll_strain[nip.start :]).all()


def test_tension_and_estimate_without_wrap_bracket_the_wound_on_tension():
    """Eqs (97) and (183) (theory page: wrap)."""
    held = wo.solve(PAPER, **QUICK)
    wrapped = wo.solve(PAPER.replace(roll_wrap=pi), **QUICK)
    low, high = sorted([held.outlet_tension, wound_on_tension_estimate(held)])
    assert low < wrapped.wound_on_tension < high
