"""A nip at one radius as a function of its load, interpolated between three solved loads."""

from __future__ import annotations

import numpy as np
import pytest

import woundon as wo
from woundon.roll.solve_lanes import build_up_of, solve_lanes
from woundon.winding.lane_nips import (
    LOADS,
    NipAtRadius,
    NipsOfWinding,
    _approach_and_added,
    _completed,
    _load_warnings,
    largest_load,
)

POWER = 1.2  # P = N (delta/delta_N)^p
NIP = NipAtRadius(
    load=2000.0,
    approach=5e-5,
    log_approach=np.log(LOADS) / POWER,
    added_at_load=380.0,
    added_change=np.array([0.0, *LOADS]) - 1.0,
    friction_force=380.0,
)


def test_the_load_is_a_power_of_the_approach():
    approach = NIP.approach * np.array([-1.0, 0.0, 0.1, 0.7, 1.0, 1.5, 10.0])
    load, slope = NIP.load_at(approach)
    expected = NIP.load * np.maximum(approach / NIP.approach, 0.0) ** POWER
    # a cubic of a straight line is exact up to rounding
    assert load == pytest.approx(expected, rel=1e-12)
    assert slope[2:] == pytest.approx(POWER * expected[2:] / approach[2:], rel=1e-12)
    assert slope[:2] == pytest.approx([0.0, 0.0], abs=0)


def test_the_added_tension_is_linear_beyond_the_samples():
    load = NIP.load * np.array([0.0, 0.3, 1.0, 2.0, 5.0])
    added, slope = NIP.added(load)
    assert added == pytest.approx(0.19 * load, rel=1e-12, abs=1e-10)
    assert slope == pytest.approx(np.full(5, 0.19), rel=1e-12)


def test_the_slopes_between_and_beyond_uneven_samples():
    """Central differences of 1e-6 of the argument: their error is about 1e-9 of the slope."""
    nip = NipAtRadius(
        2000.0, 5e-5, np.array([-0.6, 0.0, 0.5]), 380.0, np.array([-1, -0.45, 0, 0.8]), 380.0
    )
    for function, scale in ((nip.load_at, nip.approach), (nip.added, nip.load)):
        x = scale * np.array([0.2, 0.7, 1.2, 2.5, 4.0])
        difference = (function(x * (1 + 1e-6))[0] - function(x * (1 - 1e-6))[0]) / (2e-6 * x)
        assert function(x)[1] == pytest.approx(difference, rel=1e-7)


def test_the_approach_is_that_of_the_load():
    assert not hasattr(NIP, "approach_at")
    assert NIP.load_at(np.array([NIP.approach]))[0] == pytest.approx([NIP.load], rel=1e-12)


def test_loads_without_a_steady_state_are_on_the_line_through_the_two_nearest_others():
    """Closed form: a straight line is continued exactly."""
    x = np.array([0.1, 0.5, 1.0, 2.0])
    for unknown in ([3], [0], [0, 1], [0, 3], [2, 3]):
        values = 3.0 * x - 1.0
        values[unknown] = np.nan
        assert _completed(x, values) == pytest.approx(3.0 * x - 1.0, rel=1e-12)
    curved = np.array([np.nan, 0.0, 1.0, 4.0])
    assert _completed(x, curved)[0] == pytest.approx(-0.8)
    with pytest.raises(wo.NotConverged, match="no steady state under other loads"):
        _completed(x, np.array([np.nan, np.nan, 0.0, np.nan]))


def winding(**bending: float) -> wo.WindingProblem:
    """Return an even web on a stiff drum that has a crown; the nips do not depend on the roll."""
    return wo.WindingProblem.example().replace(
        radius=0.06, roll_body="linear", web_tension=350.0, drum_bending=wo.DrumBending(**bending),
        thickness_profile=wo.ThicknessProfile(position=[0, 2], thickness=[1, 1]),
    )  # fmt: skip


def test_nips_are_solved_up_to_the_largest_load_of_a_lane():
    """A crown of four times the approach: the middle lane carries three times the mean load."""
    result = wo.solve(winding(flexural_rigidity=1e9, crown=2e-4), nodes=33, rtol=0.01, lanes=6)
    ratio, place = largest_load(result.lane_roll)
    assert 2 < ratio < 4
    assert place == pytest.approx(1.0, abs=0.2)
    assert not any("times the mean nip load" in text for text in result.warnings)
    nips = NipsOfWinding(result, result.roll, largest=1.25 * ratio)
    assert (nips.sampled, nips.solved_up_to) == ((*LOADS, 4.0), 4.0)
    # the first two doublings only
    few = NipsOfWinding(result, result.roll)
    assert [*_load_warnings(result.lane_roll, nips)] == []
    (text,) = _load_warnings(result.lane_roll, few)
    assert (
        f"at {1e3 * place:.4g} mm across the web carries up to {ratio:.3g} times the mean" in text
    )
    assert "solved up to 2 times the mean, and extrapolated beyond" in text
    # at a solved nip the load-approach curve passes through the nip under four times its load
    radius, mu = float(result.nip_radius[-1]), float(result.nip_friction[-1])
    sample = nips._sample(radius, mu, (4.0,), None)
    delta, added = _approach_and_added(sample, 0)
    nip = nips.nips(radius, float(result.nip_induced_tension[-1]))[0]
    # the mean load solved again from another initial guess: 1e-4 of load and tension
    assert nip.load_at(np.array([delta]))[0] == pytest.approx([4.0 * nip.load], rel=1e-3)
    assert nip.added(np.array([4.0 * nip.load]))[0] == pytest.approx([added], rel=1e-3)


def test_the_first_layers_are_wound_with_the_web_tension_under_any_load():
    """On the core the nips add nothing: no lane may have less than the web tension there."""
    for lanes in (6, 12):
        result = wo.solve(winding(flexural_rigidity=1e5), nodes=33, rtol=0.01, lanes=lanes)
        on_core = result.lanes.wound_on_tension.values[0]
        np.testing.assert_allclose(on_core, result.web_tension[0], rtol=1e-6)
        # a lane without load has nearly the tension of the web, whatever the number of lanes; with
        # changes as on the first nip it had 327 to 350 N/m
        assert 0.995 * 350 < result.worst_lane.least_tension <= 350 * (1 + 1e-9)


class NoContact:
    """Nips whose lanes cannot share the load."""

    def tension_at(self, lanes: object):
        return lambda *arguments: None


def test_lanes_that_cannot_be_wound_are_not_blamed_on_the_stack():
    """The roll of the mean web exists; a crown or profile is at fault."""
    profile = wo.ThicknessProfile(position=[0, 2], thickness=[1, 1])
    problem = wo.RollProblem.example().replace(thickness_profile=profile)
    result = wo.solve(problem, rtol=0.01, lanes=4)
    with pytest.raises(wo.NotConverged, match=r"vary too much between the lanes.*even_crown") as no:
        solve_lanes(result, build_up_of(result), problem, count=4, nips=NoContact())
    assert "too soft" not in str(no.value)


def test_extrapolated_loads_are_said(monkeypatch):
    monkeypatch.setattr("woundon.winding.lane_nips.MOST_LOAD", 2.0)
    with pytest.warns(wo.ValidityWarning, match="solved up to 2"):
        wo.solve(winding(flexural_rigidity=1e9, crown=2e-4), nodes=33, rtol=0.01, lanes=6)
