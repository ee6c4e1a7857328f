"""Changes of a wound roll after winding: those of a winding are those of its roll."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import woundon as wo
from woundon.roll.stages import stages_at

WINDING = wo.WindingProblem.example().replace(radius=0.12)
DRIED: dict[str, Any] = {
    "moisture_change": wo.Profile(radius=[0.05, 0.1, 0.12], value=[0.0, -0.005, -0.03]),
    "tangential_swelling": 0.02,
    "radial_swelling": 0.3,
    "core_swelling": 0.05,
}
CHANGES: dict[str, dict[str, Any]] = {
    "off the core": {"core_removed": True},
    "soft core": {"core_shrinkage": 2e-3},
    "dried": DRIED,
    "cooled": {"temperature_change": -20.0, "radial_expansion": 1e-4, "core_expansion": 1.2e-5},
    "dried off the core": {**DRIED, "core_removed": True},
}
ARRAYS = "pressure", "hoop_stress", "displacement", "layer_strain"


@pytest.mark.parametrize(
    ("name", "law"), [*((name, "friction") for name in CHANGES), ("dried off the core", "nip")]
)
def test_a_winding_ends_with_the_changes_of_its_roll(name: str, law: str):
    """The roll is that of its own problem; nips and tension do not know what happens later."""
    problem, changes = WINDING.replace(tension_law=law), CHANGES[name]
    before, result = (wo.solve(case) for case in (problem, problem.replace(**changes)))
    np.testing.assert_array_equal(result.wound_on_tension, before.wound_on_tension)
    alone = before.roll.problem.replace(**changes)
    assert result.roll.problem == alone
    solved = wo.solve(alone, rtol=result.roll_rtol)
    for array in ARRAYS:  # the same operations: rounding errors at most
        expected = getattr(solved, array)
        largest = np.max(np.abs(expected))
        np.testing.assert_allclose(
            getattr(result.roll, array), expected, rtol=0, atol=1e-12 * largest
        )
    r = np.linspace(0.05, 0.12, 101)
    change = (
        result.roll.at_radius(r)["pressure"] - before.roll.at_radius(r)["pressure"]
    ) / before.peak_pressure
    assert np.max(np.abs(change)) > 0.01
    for output in ("core_pressure", "bore_hoop_stress", "bore_displacement", "core_gap"):
        expected = getattr(solved, output)
        assert getattr(result, output) == pytest.approx(expected, rel=1e-12, nan_ok=True)
    # the tension has the error of the nips, too
    assert result.errors["bore_hoop_stress"] >= solved.errors["bore_hoop_stress"]
    assert result.residuals.largest < 1e-8


def test_the_margins_of_a_winding_off_its_core_are_those_of_its_roll():
    result = wo.solve(WINDING.replace(tension_law="friction", core_removed=True))
    before = wo.solve(WINDING.replace(tension_law="friction"))
    assert result.margins["core"].value == pytest.approx(before.margins["core"].value, rel=1e-9)
    found = wo.margins(result.roll)["compression"]
    assert result.margins["compression"].value == pytest.approx(found.value, rel=1e-12)
    assert found.value > 3 * before.margins["compression"].value


def test_the_last_nip_runs_on_the_roll_as_wound():
    """A dried surface is loose: the nip at the full radius must be solved before it dries."""
    problem = WINDING.replace(**DRIED, radius=0.07)
    profile = wo.Profile(radius=[0.05, 0.069, 0.07], value=[0.0, -0.03, -0.03])
    result = wo.solve(problem.replace(moisture_change=profile), nodes=33)
    assert result.nip_radius[-1] == pytest.approx(0.07)
    as_wound = result.roll.as_wound.stresses_at(np.array([0.0699]))[0]
    assert result.roll.at_radius(0.0699)["pressure"] < 0.9 * as_wound[0]
    stage = stages_at(result.roll, [0.07], as_wound=True)[0]
    # on other nodes, each to the tolerance 1e-3 of the pressure in the roll
    atol = 2e-3 * result.peak_pressure
    np.testing.assert_allclose(stage.stresses_at(np.array([0.0699]))[0], as_wound, atol=atol)
    for name, (values, tolerance) in result.recomputed_nips().items():
        assert (np.abs(getattr(result, name) - values) <= tolerance).all(), name


def test_lanes_of_a_winding_have_the_changes():
    """Lanes of an even web are the roll of the mean web, also after drying."""
    even = wo.ThicknessProfile(position=[0.0, 1.0, 2.0], thickness=[1.0, 1.0, 1.0])
    problem = WINDING.replace(**DRIED, tension_law="friction", thickness_profile=even)
    result = wo.solve(problem, lanes=4)
    r, peak = result.lanes.radius.values, result.peak_pressure
    expected = result.roll.at_radius(r)["pressure"]
    for lane in result.lanes.pressure.values.T:
        # the lanes are solved in stages to a smaller tolerance than their nodes are chosen
        np.testing.assert_allclose(lane, expected, rtol=0, atol=1e-6 * peak)


def test_the_changes_are_in_case_files_and_results(tmp_path: Path):
    problem = WINDING.replace(tension_law="friction", **DRIED, core_shrinkage=1e-3)
    result = wo.solve(problem)
    result.save(tmp_path / "roll.json")
    loaded = wo.load_result(tmp_path / "roll.json")
    assert loaded.problem == problem
    assert loaded.core_gap == pytest.approx(result.core_gap, rel=1e-9)
    text = str(loaded)
    assert "Changes of the finished roll" in text
    assert "bore" in text
    assert "Off the core" in str(wo.solve(problem.replace(core_removed=True)))


def test_changes_without_effect_are_named():
    heated = WINDING.replace(temperature_change=5.0)
    assert any("temperature_change is not used" in text for text in heated.input_warnings)
    removed = WINDING.replace(core_removed=True, core_shrinkage=1e-3)
    assert "core_shrinkage is not used, as core_removed = true" in removed.input_warnings
    assert "core_shrinkage" in removed.unused
    assert "core_shrinkage" not in WINDING.replace(core_shrinkage=1e-3).unused
