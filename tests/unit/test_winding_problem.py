"""Windings: what is refused, with the radius where it is, and what schedules say."""

from __future__ import annotations

import numpy as np
import pytest

import woundon as wo

CASE = wo.WindingProblem.example()
FALLING = wo.Profile(radius=[0.05, 0.6], value=[2000.0, 400.0])


def test_a_drum_that_slides_is_rejected_with_the_radius():
    """mu- P falls below |F| = 200 N/m where P = 1000 N/m, at 0.05 + 0.55 * 1000/1600 m."""
    with pytest.raises(wo.NoSteadyState) as fault:
        CASE.replace(nip_load=FALLING, winding_force=-200.0)
    text = str(fault.value)
    assert text.startswith("winding_force: -200 at the radius 0.39")
    assert "the drum slips" in text
    # 2 mm beyond, on the grid of radii that are looked at
    assert float(text.split("radius ")[1].split()[0]) == pytest.approx(0.39375, abs=2.2e-3)


def test_a_torque_split_that_the_nip_cannot_carry_is_rejected_with_the_radius():
    with pytest.raises(wo.NoSteadyState, match=r"torque_split: 1 at the radius 0\.\d+ \[m\] means"):
        CASE.replace(nip_load=FALLING, torque_split=1.0)


def test_the_winding_force_follows_from_the_torque_split():
    """0 is centre winding, F = 0; 1 is surface winding, F = -T_in."""
    r = np.linspace(0.05, 0.6, 7)
    T = CASE.at("web_tension", r)
    half = CASE.replace(torque_split=wo.Profile(radius=[0.05, 0.6], value=[1.0, 0.0]))
    np.testing.assert_allclose(half.at("winding_force", r), -T * np.linspace(1, 0, 7), rtol=1e-14)


def test_the_nip_at_a_radius_has_the_loads_of_the_schedules():
    nip = CASE.nip(0.3, wo.HalfPlane(radius=0.3, material="newsprint"))
    assert nip.web_tension == pytest.approx(350 * (1 - 0.3 * 0.25 / 0.55), rel=1e-14)
    assert (nip.nip_load, nip.winding_force, nip.roll.radius) == (2000.0, 0.0, 0.3)
    assert nip.web == CASE.web
    assert nip.roll_wrap == CASE.roll_wrap
