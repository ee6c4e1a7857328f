"""The nip loads of a two-drum winder: statics, closed forms, invalid input, and their use."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import woundon as wo
from woundon.problems.two_drums import GRAVITY, drum_loads, rider_load_for, roll_weight

ROOT = Path(__file__).parents[2]
R = np.array([0.1, 0.3, 0.6])


def test_the_weight_is_that_of_the_ring_and_the_core():
    weight = roll_weight(R, 0.05, 680.0, core_mass=4.0)
    np.testing.assert_allclose(weight, GRAVITY * (680 * np.pi * (R**2 - 0.05**2) + 4), rtol=1e-15)
    assert roll_weight(0.05, 0.05, 680.0) == 0


def test_three_equal_cylinders_that_touch():
    """Centres on an equilateral triangle: each line of centres 30 degrees off the vertical."""
    rear, front = drum_loads(0.25, 1000.0, 0.25, 0.0, rider_load=200.0)
    assert rear == pytest.approx(1200 / (2 * np.cos(np.pi / 6)), rel=1e-14)
    assert front == pytest.approx(rear, rel=1e-14)


def test_a_roll_far_larger_than_its_drums_puts_half_its_weight_on_each():
    """cos a tends to 1 as (d/R)^2/8, 2.5e-7 here."""
    assert drum_loads(500.0, 1.0, 0.25, 0.01).rear == pytest.approx(0.5, rel=1e-6)


def test_loads_on_unequal_drums_hold_the_roll():
    """Forces along the lines of centres, whose directions are found by triangulation."""
    first, second, gap, down = 0.3, 0.2, 0.02, 5000.0
    rear, front = drum_loads(R, down, (first, second), gap)
    apart = first + second + gap
    x = np.array([
        np.arccos((apart**2 + (r + first) ** 2 - (r + second) ** 2) / (2 * apart * (r + first)))
        for r in R
    ])  # fmt: skip
    centre = (R + first) * np.array([np.cos(x), np.sin(x)])
    from_front = centre - np.array([[apart], [0]])
    force = rear * centre / np.hypot(*centre) + front * from_front / np.hypot(*from_front)
    np.testing.assert_allclose(force, [np.zeros(3), np.full(3, down)], atol=1e-11 * down)
    assert (rear < front).all()  # the larger drum pushes it onto the smaller one


def test_the_rider_makes_the_wanted_nip_load():
    weight = roll_weight(R, 0.05, 680.0)
    for drum in ("rear", "front"):
        more = rider_load_for(4000.0, R, weight, (0.3, 0.25), 0.02, drum)
        loads = drum_loads(R[:2], weight[:2], (0.3, 0.25), 0.02, more[:2])
        np.testing.assert_allclose(getattr(loads, drum), 4000.0, rtol=1e-13)
    # the heaviest roll loads the nip more than wanted by itself
    assert (more[:2] > 0).all()
    assert more[2] < 0


# ---- use: the nip of a winding is on the drum on which the web arrives ---------------------------


def on_the_rear_drum(problem: wo.WindingProblem, names: dict[str, Any], rider: Any) -> None:
    """Require the nip of ``problem`` to be that on the rear drum of two unequal drums."""
    rear, front, r, gap = (names[name] for name in ("rear", "front", "r", "gap"))
    assert rear != front
    assert problem.drum.radius == rear
    loads = drum_loads(r, names["weight"], (rear, front), gap, rider)
    np.testing.assert_allclose(problem.at("nip_load", r), loads.rear, rtol=1e-12)


def test_the_guide_winds_on_the_rear_drum() -> None:
    text = (ROOT / "docs/theory/winding.md").read_text(encoding="utf-8")
    blocks = re.findall(r"```python\n(.*?)```", text, re.S)
    [block] = [code for code in blocks if "drum_loads(" in code]
    names: dict[str, Any] = {"np": np, "wo": wo, "problem": wo.WindingProblem.example()}
    exec(block, names)
    assert "gap=0.02, rider_load=1500" in block
    on_the_rear_drum(names["problem"], names | {"gap": 0.02}, 1500.0)
