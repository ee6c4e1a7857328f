"""A two-drum winder: balance of forces and moments, closed forms, limits, rejected input."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import woundon as wo
from woundon.io.case_files import make_problem
from woundon.io.chosen_units import units_of
from woundon.quantities import walk

ROOT = Path(__file__).parents[2]
R = np.linspace(0.05, 0.6, 23)
REAR, FRONT, GAP, DENSITY = 0.3, 0.25, 0.02, 680.0
G = 9.80665  # m/s^2
WINDER = wo.TwoDrums(front_drum=wo.Rigid(radius=FRONT), gap=GAP, rider_load=2500.0)
CASE = wo.WindingProblem.example().replace(
    winder=WINDER, drum=wo.Rigid(radius=REAR), nip_load=None, torque_split=0.5, density=DENSITY
)
# a prescribed tension: the drums may slip, so that the balance holds for any forces
PRESCRIBED = CASE.replace(tension_law="fixed", nip_induced_tension=50.0)
DRIVEN = PRESCRIBED.replace(**{"winder.core_torque": 20.0, "winder.core_mass": 12.0})


def cross(arm: np.ndarray, force: np.ndarray) -> np.ndarray:
    """Return the moment of forces (k, 2) at arms (k, 2) about the axis of the roll."""
    return arm[:, 0] * force[:, 1] - arm[:, 1] * force[:, 0]


@pytest.mark.parametrize("split", [-0.5, 0.0, 0.5, 1.0, 1.3])
@pytest.mark.parametrize("front", [FRONT, REAR, 0.38])
def test_forces_and_moments_on_the_roll_vanish(front: float, split: float) -> None:
    """Closed form: sum of all forces and of their moments about two axes, in vectors.

    The centres are the corners of a triangle with known sides.  The roll turns counterclockwise.
    """
    winding = DRIVEN.replace(torque_split=split, **{"winder.front_drum.radius": front})
    loads, T = winding.drum_loads(R), winding.at("web_tension", R)
    apart = REAR + front + GAP
    at_rear = np.arccos((apart**2 + (R + REAR) ** 2 - (R + front) ** 2) / (2 * apart * (R + REAR)))
    centre = (R + REAR)[:, None] * np.column_stack([np.cos(at_rear), np.sin(at_rear)])

    def contact(drum: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Arm, direction of the load, and direction in which the surface of the roll moves."""
        inward = (centre - drum) / np.linalg.norm(centre - drum, axis=1)[:, None]
        return -R[:, None] * inward, inward, np.column_stack([inward[:, 1], -inward[:, 0]])

    arm_1, inward_1, forward_1 = contact(np.zeros((R.size, 2)))
    arm_2, inward_2, forward_2 = contact(np.array([[apart, 0.0]] * R.size))
    force_1 = loads.rear_load[:, None] * inward_1 - (loads.rear_force + T)[:, None] * forward_1
    force_2 = loads.front_load[:, None] * inward_2 - loads.front_force[:, None] * forward_2
    weight = G * (np.pi * DENSITY * (R**2 - 0.05**2) + 12.0)
    down = np.column_stack([0 * R, -(weight + 2500.0)])  # the idling rider presses vertically
    rounding = 1e-11 * np.abs(force_1).max()
    np.testing.assert_allclose(force_1 + force_2 + down, 0, atol=rounding)
    # core torque, counterclockwise, and the drums; weight and rider act through the axis
    torque = 20.0 + cross(arm_1, force_1) + cross(arm_2, force_2)
    np.testing.assert_allclose(torque, 0, atol=rounding)
    about_the_rear_drum = 20.0 + cross(centre + arm_1, force_1) + cross(centre + arm_2, force_2)
    np.testing.assert_allclose(about_the_rear_drum + cross(centre, down), 0, atol=rounding)
    # arcs of the web: angles between the lines of centres, and to the top of the roll
    between = np.arccos((inward_1 * inward_2).sum(axis=1))
    np.testing.assert_allclose(loads.front_arc, between, rtol=1e-12)
    np.testing.assert_allclose(np.cos(loads.rider_arc), -inward_2[:, 1], atol=1e-12)
    arcs = loads.front_arc + loads.rider_arc + loads.returning_arc
    np.testing.assert_allclose(arcs, 2 * np.pi, rtol=1e-15)


def test_three_equal_cylinders_that_touch() -> None:
    """Closed form: lines of centres 30 degrees off the vertical, a rear drum that drives alone."""
    winding = CASE.replace(
        radius=0.3, core=wo.Core(radius=0.05, stiffness=1e9), torque_split=1.0,
        drum=wo.Rigid(radius=0.25), **{"winder.front_drum.radius": 0.25, "winder.gap": 0.0},
    )  # fmt: skip
    loads = winding.drum_loads(0.25)
    down = G * np.pi * DENSITY * (0.25**2 - 0.05**2) + 2500.0
    assert loads.rear_load == pytest.approx(down / (2 * np.cos(np.pi / 6)), rel=1e-14)
    assert loads.front_load == pytest.approx(loads.rear_load, rel=1e-14)
    assert loads.front_arc == pytest.approx(np.pi / 3, rel=1e-14)


def test_equal_drums_lose_the_same_load_by_the_pull_of_the_front_drum() -> None:
    """Closed form: P = V/(2 cos a) - (1 - s) T_in tan(a + b)/2 of both drums."""
    winding = CASE.replace(**{"winder.front_drum.radius": REAR})
    loads, T = winding.drum_loads(R), winding.at("web_tension", R)
    half = loads.front_arc / 2
    expected = (loads.weight + 2500.0) / (2 * np.cos(half)) - 0.5 * T * np.tan(half)
    np.testing.assert_allclose(loads.rear_load, expected, rtol=1e-12)
    np.testing.assert_allclose(loads.front_load, expected, rtol=1e-12)


def test_between_drums_of_almost_infinite_radius_the_roll_is_a_wedge() -> None:
    """Limit: drums that touch, R_drum/R = 900: cos a = (2 R/R_drum)^1/2 to the order R/R_drum."""
    big = 45.0
    winding = CASE.replace(
        torque_split=1.0, drum=wo.Rigid(radius=big),
        **{"winder.front_drum.radius": big, "winder.gap": 0.0},
    )  # fmt: skip
    loads = winding.drum_loads(0.05)
    V = float(loads.weight) + 2500.0
    assert loads.rear_load == pytest.approx(V / (2 * np.sqrt(2 * 0.05 / big)), rel=2e-3)


def test_a_roll_far_larger_than_its_drums_puts_half_its_weight_on_each() -> None:
    """Limit: cos a tends to 1 as (d/R)^2/8, d the distance of the drums."""
    winding = CASE.replace(
        radius=50.0, torque_split=1.0, drum=wo.Rigid(radius=FRONT), **{"web.thickness": 1e-4},
    )  # fmt: skip
    loads = winding.drum_loads(50.0)
    V = float(loads.weight) + 2500.0
    assert loads.rear_load == pytest.approx(V / 2, rel=2e-5)
    assert loads.front_arc == pytest.approx(0.52 / 50.25, rel=1e-4)


def test_the_torque_split_moves_the_force_between_the_drums() -> None:
    """Moment balance: F1 = -s T_in and F1 + F2 = -T_in + M/R, whatever s."""
    for split in (0.0, 0.3, 1.0, 1.4):
        winding = DRIVEN.replace(torque_split=split)
        loads, T = winding.drum_loads(R), winding.at("web_tension", R)
        np.testing.assert_allclose(winding.at("winding_force", R), -split * T, rtol=1e-14)
        np.testing.assert_allclose(loads.rear_force + loads.front_force, -T + 20 / R, rtol=1e-12)
    surface = CASE.replace(torque_split=1.0).drum_loads(R)
    np.testing.assert_allclose(surface.front_force, 0, atol=1e-12)


def test_the_nip_of_the_winding_is_that_of_the_rear_drum() -> None:
    loads = CASE.drum_loads(R)
    np.testing.assert_array_equal(CASE.at("nip_load", R), loads.rear_load)
    assert CASE.drum.radius == REAR


def test_a_rider_load_may_depend_on_the_radius() -> None:
    relief = wo.Profile(radius=[0.05, 0.3, 0.6], value=["2.5 kN/m", "1 kN/m", 0.0])
    winding = PRESCRIBED.replace(**{"winder.rider_load": relief})
    np.testing.assert_allclose(
        winding.drum_loads([0.05, 0.175, 0.6]).rider_load, [2500, 1750, 0], rtol=1e-14
    )
    assert 0.3 in winding.kinks
    for rider_load, width in (("1 kN/m", None), ("2.5 kN", 2.5)):
        entered = PRESCRIBED.replace(width=width, **{"winder.rider_load": rider_load})
        assert entered.winder is not None
        assert entered.winder.rider_load == 1000.0


def test_the_cases_of_the_guides_are_valid() -> None:
    """Documentation: case of the how-to with its rider loads and drives, example of the theory."""
    guide = (ROOT / "docs/howto/two_drum_winder.md").read_text(encoding="utf-8")
    case, rider, driven = map(tomllib.loads, re.findall(r"```toml\n(.*?)```", guide, re.DOTALL))
    problem = make_problem(case)
    assert problem.drum_loads(0.6).rear_load > 3000
    relieved = make_problem(case | {"winder": case["winder"] | rider["winder"]})
    assert relieved.drum_loads(0.3).rider_load == pytest.approx(2000.0, rel=1e-12)
    assert make_problem(case | driven).inertia.front_drum == 50.0
    theory = (ROOT / "docs/theory/winding.md").read_text(encoding="utf-8")
    [code] = [
        text for text in re.findall(r"```python\n(.*?)```", theory, re.DOTALL) if "TwoDrums" in text
    ]
    names: dict[str, Any] = {"wo": wo, "problem": wo.WindingProblem.example()}
    exec(code, names)
    assert names["problem"].winder is not None


# ---- rejected input: field, value, permitted range, radius ---------------------------------------


def test_the_stated_rider_load_just_holds_the_roll() -> None:
    """The permitted range is that of the balance: slightly more is accepted."""
    least = 314.241
    with pytest.raises(wo.InvalidProblem, match="lifts off the rear drum"):
        PRESCRIBED.replace(**{"winder.rider_load": least - 0.01})
    held = PRESCRIBED.replace(**{"winder.rider_load": least + 0.01})
    assert 0 < held.drum_loads(0.05).rear_load < 0.05


def test_a_torque_per_width_is_shown_in_mill_units():
    # 1 lbf = 4.4482216152605 N exactly
    torque = next(p.quantity for p in walk(DRIVEN) if p.path == "winder.core_torque")
    assert torque is not None
    assert torque.text(20.0) == "20 N"
    with units_of(["mill"]):
        assert torque.text(20.0) == "4.496 lbf"
