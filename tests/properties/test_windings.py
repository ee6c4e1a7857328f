"""Known trends of windings.

The rolls are linear and the nips coarse: the trends are many times larger than the error of 2 %.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest

import woundon as wo

CASE = wo.WindingProblem.example().replace(radius=0.12, roll_body="linear", web_tension=350.0)
SOFT = wo.Cylinder(
    radius=0.25, core_radius=0.23, material=wo.Isotropic(youngs_modulus=10e6, poissons_ratio=0.3)
)
pytestmark = pytest.mark.filterwarnings("ignore::woundon.ResolutionWarning")


@cache
def wound() -> wo.WindingResult:
    return wo.solve(CASE, nodes=25, rtol=2e-2)


def changed(**changes: Any) -> wo.WindingResult:
    return wo.solve(CASE.replace(**changes), nodes=25, rtol=2e-2)


@pytest.mark.slow
def test_a_softer_nip_adds_less_tension():
    """A covered drum spreads the load: less pressure, so less stretch of what rolls under it."""
    soft = changed(drum=SOFT)
    assert soft.mean_nip_induced_tension < 0.8 * wound().mean_nip_induced_tension
    assert soft.nip_half_width.min() > 1.2 * wound().nip_half_width.max()
    assert soft.mid_pressure < 0.9 * wound().mid_pressure


@pytest.mark.slow
def test_a_larger_drum_adds_less_tension():
    """A flatter contact is wider and presses less for the same load."""
    large = changed(**{"drum.radius": 0.75})
    assert large.mean_nip_induced_tension < 0.97 * wound().mean_nip_induced_tension
    np.testing.assert_allclose(large.nip_radius, wound().nip_radius)
    assert (large.nip_peak_pressure < 0.97 * wound().nip_peak_pressure).all()


def test_more_nip_load_winds_a_harder_roll():
    """The nip stretches the web under it: more load, more tension, up to mu+ P."""
    light, own = changed(nip_load=800.0), wound()
    assert light.mean_nip_induced_tension < 0.7 * own.mean_nip_induced_tension
    assert light.mid_pressure < 0.8 * own.mid_pressure
    assert (light.nip_induced_tension < 0.19 * 800.0 * 1.02).all()


@pytest.mark.slow
def test_surface_winding_winds_softer_than_centre_winding():
    """With F = -T_in the nip must carry the whole web tension; what is left is about mu+ P."""
    surface, half = changed(torque_split=1.0), changed(torque_split=0.5)
    tensions = [run.mean_wound_on_tension for run in (surface, half, wound())]
    assert tensions[0] < tensions[1] < tensions[2]
    assert tensions[0] < 0.75 * tensions[2]


@pytest.mark.slow
def test_slippery_layers_take_no_tension_from_the_nip():
    """Layers that slip throughout the nip pass on mu+ P and no more: higher friction, more NIT."""
    runs = [changed(roll_friction=mu) for mu in (0.02, 0.05)]
    added = [run.mean_nip_induced_tension for run in runs]
    # 2 and 5 % of 2000 N/m, less what slips the other way at the nip's inlet
    assert 0.85 * 40.0 < added[0] < 40.0
    assert 0.85 * 100.0 < added[1] < 100.0
    assert added[1] < wound().mean_nip_induced_tension
