"""Windings: what is refused, with the radius where it is, and what schedules say."""

from __future__ import annotations

import tomllib

import numpy as np
import pytest
from rejections import assert_rejected

import woundon as wo
from woundon.io.case_files import make_problem
from woundon.io.case_texts import to_toml

CASE = wo.WindingProblem.example()
FALLING = wo.Profile(radius=[0.05, 0.6], value=[2000.0, 400.0])


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"radius": 0.04}, "core.radius: 0.05 is out of range; must be > 0 and < radius = 0.04"),
        ({"web.thickness": 1.5e-7}, "web.thickness: 1.5e-07 is out of range; must be >= 5.5e-07"),
        ({"nip_load": -5.0}, "nip_load: -5 is out of range; must be >= 1e-12 and <= 1e+07 [N/m]"),
        ({"nip_load": float("nan")}, "nip_load: nan is not a finite number"),
        ({"web_tension": 0.0}, "web_tension: 0 is out of range; must be >= 1e-06"),
        ({"web_tension": wo.Taper(start=300.0, taper=1.0)},
         "web_tension.taper: 1 is out of range; leaves 0 [N/m] at the radius 0.6 [m], must be >="),
        ({"nip_load": wo.Profile(radius=[0.06, 0.6], value=[1e3, 1e3])},
         "nip_load.radius.0: 0.06 is out of range; must be <= core.radius = 0.05 [m]: the "),
        ({"web_tension": wo.Profile(radius=[0.05, 0.5], value=[300, 300])},
         "web_tension.radius.1: 0.5 is out of range; must be >= radius = 0.6 [m]: the schedule"),
        ({"web_tension": wo.Profile(radius=[0.05, 0.6], value=[300, -1])},
         "web_tension.value.1: -1 is out of range; must be >= 1e-06 and <= 1e+06 [N/m]"),
        ({"torque_split": 1.5}, "torque_split: 1.5 is out of range; must be >= 0 and <= 1"),
        ({"torque_split": 0.5, "winding_force": -100.0},
         "torque_split: is given together with winding_force; must be one of the two"),
        ({"tension_law": "fixed"}, "nip_induced_tension: missing; must be given [N/m] with"),
        ({"nip_induced_tension": 100.0},
         "nip_induced_tension: is given together with tension_law = 'nip'; must be left out"),
        ({"tension_law": "nips"}, "tension_law: 'nips' is unknown; must be 'nip', 'friction' or"),
        ({"tension_law": 300.0}, "tension_law: 300 is out of place; must be 'nip', 'friction',"),
        ({"roll_body": "soft"}, "roll_body: 'soft' is unknown; must be 'effective', 'direct' or"),
        ({"nip_loud": 3.0}, "nip_loud: no such field; did you mean 'nip_load'?"),
    ],
)  # fmt: skip
def test_what_cannot_be_wound_is_rejected(changes: dict, message: str):
    assert_rejected(lambda: CASE.replace(**changes), message)


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


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"tension_law": "friction"},
        {"tension_law": "fixed", "nip_induced_tension": wo.Taper(start=100.0, taper=0.2)},
        {"tension_law": wo.Profile(radius=[0.05, 0.6], value=[500.0, 300.0])},
        {"torque_split": 0.3, "roll_body": "direct", "drum_wrap": 1.0, "wrap_friction": 0.1},
        {"nip_load": FALLING},
    ],
)
def test_a_case_file_gives_the_problem_back(changes: dict):
    problem = CASE.replace(**changes)
    assert make_problem(tomllib.loads(to_toml(problem))) == problem


def test_a_linear_roll_needs_a_web_that_does_not_harden():
    hardening = wo.WindingProblem.example()
    web = wo.Web(thickness=66e-6, material=hardening.stack)
    assert_rejected(
        lambda: hardening.replace(web=web, roll_body="linear"),
        "roll_body: 'linear' needs the moduli of a web that does not harden",
    )
