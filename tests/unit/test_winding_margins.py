"""Margins of a winding: its torque, its outputs, its report and figures."""

from __future__ import annotations

import math
import re
from typing import Any

import pytest

import woundon as wo
from woundon.report.winding_panels import reserves

LIMITS = wo.Limits(compression=100e3, blocking_pressure=2e6, web_strength=2e3, slack_tension=50.0)
OUTPUTS = {
    "torque_share": "slip", "largest_compression": "compression", "peak_pressure": "blocking",
    "largest_core_pressure": "core", "largest_tension": "strength", "least_tension": "slack",
    "band_strain": "gauge_band",
}  # fmt: skip


def winding(**changes: Any) -> wo.WindingProblem:
    """Return a small winding whose nip adds what is given, quickly solved."""
    fields: dict[str, Any] = {
        **dict(wo.WindingProblem.example()), "radius": 0.12, "web_tension": 300.0, "limits": LIMITS,
        "tension_law": "fixed", "nip_induced_tension": 100.0,
    }  # fmt: skip
    return wo.WindingProblem(**{**fields, **changes})


@pytest.fixture(scope="module")
def wound() -> wo.WindingResult:
    return wo.solve(winding())


def test_the_core_carries_what_the_drum_does_not(wound: wo.WindingResult) -> None:
    """With NIT given the roll is the same whatever drives it; the torque is that of T_in + F."""
    half = wo.solve(winding(torque_split=0.5))
    surface = wo.solve(winding(torque_split=1.0))
    assert half.core_pressure == wound.core_pressure
    assert half.torque_share == pytest.approx(wound.torque_share / 2)
    assert surface.torque_share == 0
    # of a roll alone NIT, which has no moment about the axis, is not distinguished from T_in
    alone = wo.margins(wound.roll, wo.Limits(layer_friction=0.19))["slip"].value
    assert alone == pytest.approx(wound.torque_share * 400 / 300, rel=1e-6)


def test_a_stop_by_the_core_counts_where_the_drum_drives() -> None:
    stopped = wo.solve(winding(torque_split=1.0, limits=wo.Limits(acceleration=2.0)))
    assert stopped.torque_share > 0
    slower = wo.solve(winding(torque_split=1.0, limits=wo.Limits(acceleration=1.0)))
    assert stopped.torque_share == pytest.approx(2 * slower.torque_share)


def test_the_friction_is_the_rolls_unless_one_is_given(wound: wo.WindingResult) -> None:
    rough = wo.solve(winding(limits=wo.Limits(layer_friction=0.38)))
    assert rough.torque_share == pytest.approx(wound.torque_share / 2)


def test_the_web_runs_slack_before_the_nip(wound: wo.WindingResult) -> None:
    """The span has less tension than the roll: T_in counts."""
    assert wound.margins["slack"].value == 300
    assert wound.margins["strength"].value == pytest.approx(400)
    tight = wo.margins(wound, LIMITS.replace(slack_tension=350.0))
    assert tight.violated == ("compression", "slack")


def test_margins_are_outputs_that_studies_vary(wound: wo.WindingResult) -> None:
    for name, margin in OUTPUTS.items():
        assert getattr(wound, name) == pytest.approx(wound.margins[margin].value)
    assert wound.margins.violated == ("compression",)
    assert wound.least_reserve == wound.margins["compression"].reserve < 0
    found = wo.sweep(winding(), {"web_tension": [200.0, 300.0]}, [*OUTPUTS, "least_reserve"])
    assert found.largest_compression.values[1] == wound.largest_compression
    assert found.least_reserve.values[0] > found.least_reserve.values[1]


@pytest.mark.slow
def test_a_schedule_is_sought_over_what_a_winder_sets() -> None:
    problem = winding(torque_split=0.2, web_tension=wo.Taper(start=300.0, taper=0.1))
    found = wo.optimise_schedule(problem, evaluations=5, options={"rtol": 1e-2})
    assert found.names == ("web_tension.taper", "torque_split", "nip_load")
    assert found.ranges.tolist() == [[0, 0.7], [0, 1], [500, 4000]]
    assert found.margins_after.least.reserve >= found.margins_before.least.reserve


def test_layers_without_friction_are_reported_in_words(
    wound: wo.WindingResult,
) -> None:
    """Limit: a film of three roughnesses leaves no friction, and any torque is too much."""
    air = wo.Air(roughness=1e-6)
    problem = winding(tension_law="nip", nip_induced_tension=None, air=air, web_speed=10.0)
    film = 3.01e-6 * (1 + wound.peak_pressure / air.ambient_pressure)  # compressed to 3.01 um
    margins = wo.margins(wound.replace(problem=problem, air_film=film))
    assert margins["slip"].value == math.inf
    assert margins.verdict.startswith(
        "The roll does not hold: interlayer slip and telescoping, because friction between the "
        "layers carries nothing"
    )
    text = str(margins)
    assert "no capacity" in text
    assert re.search(r"\binf\b", text) is None
    assert "Not considered: friction that falls" in text  # the air is considered
    assert "Not considered: air between layers" in str(wound.margins)
    panel = reserves(wound.replace(problem=problem, air_film=film))
    low, _ = panel.y.limits  # finite
    assert low < 0
    slip, *_ = [curve for curve in panel.curves if curve.name == "slip"]
    assert (slip.y == low).any()
