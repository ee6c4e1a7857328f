"""A nip at one radius as a function of its load, interpolated between three solved loads."""

from __future__ import annotations

import numpy as np
import pytest

import woundon as wo
from woundon.winding.lane_nips import LOADS, NipAtRadius, _completed

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
