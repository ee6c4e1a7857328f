"""Windings on two drums: their nips, limits, margins, report, drawing, files and studies."""

from __future__ import annotations

import re
from functools import cache
from math import exp
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import woundon as wo
from woundon.io.chosen_units import units_of
from woundon.report.answer import answer_lines
from woundon.report.winding_panels import winding_panels
from woundon.studies.window_cases import ranges_of
from woundon.winding.certificate import certificate

DENSITY, MU = 680.0, 0.19
# stiff linear rolls: the nips do not depend on the wound roll, and are solved once at each radius
CASE = wo.WindingProblem.example().replace(
    winder=wo.TwoDrums(front_drum=wo.Rigid(radius=0.25), gap=0.02, rider_load=1500.0),
    drum=wo.Rigid(radius=0.3), nip_load=None, torque_split=0.5, web_tension=300.0,
    density=DENSITY, radius=0.35, roll_body="linear",
    limits=wo.Limits(web_strength=2000.0, slack_tension=50.0),
)  # fmt: skip
WITH_RIDER = CASE.replace(
    **{"winder.rider": wo.Rigid(radius=0.1), "winder.rider_load": 2000.0}, radius=0.12
)
COARSE: dict[str, Any] = {"nodes": 33, "rtol": 0.01}


@cache
def solved(name: str) -> wo.WindingResult:
    problem = {"two drums": CASE, "rider": WITH_RIDER}[name]
    return wo.solve(problem, **COARSE)


def on_web_roll(radius: float) -> wo.Cylinder:
    """Return the linear roll of a radius, of the moduli of the web."""
    material = CASE.web.material
    return wo.Cylinder(radius=radius, core_radius=0.05, material=material)


# ---- the nips -----------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["two drums", "rider"])
def test_each_nip_of_the_winding_is_solved_with_those_of_the_other_drums(name: str) -> None:
    """Invariance: the nip of a radius, solved without a warm start, to its residuals."""
    winding = solved(name)
    for k in (2, -1):
        radius = float(winding.nip_radius[k])
        nip = wo.solve(winding.problem.nip(radius, on_web_roll(radius)), nodes=33)
        assert winding.nip_wound_on_tension[k] == pytest.approx(nip.roll_wound_on_tension, rel=1e-7)
        for drum, contact in zip((winding.front, winding.rider), nip.contacts[1:], strict=False):
            assert drum is not None
            assert drum.load[k] == pytest.approx(contact.nip_load, rel=1e-12)
            assert drum.arc_least_tension[k] == pytest.approx(contact.least_tension, rel=1e-7)
            assert drum.width[k] == pytest.approx(contact.nip_width, rel=1e-7)


def test_the_nips_have_the_loads_and_arcs_of_the_balance() -> None:
    winding = solved("rider")
    loads = winding.problem.drum_loads(winding.nip_radius)
    front, rider = winding.front, winding.rider
    assert front is not None
    assert rider is not None
    for values, expected in (
        (front.load, loads.front_load), (front.force, loads.front_force),
        (front.arc, loads.front_arc), (rider.load, loads.rider_load), (rider.force, 0 * rider.load),
        (rider.arc, loads.rider_arc),
    ):  # fmt: skip
        np.testing.assert_allclose(values, expected, rtol=1e-12)
    np.testing.assert_allclose(
        winding.nip_load, winding.problem.drum_loads(winding.radius).rear_load
    )


def test_the_front_drum_pulls_web_where_friction_on_the_arc_cannot_hold_it() -> None:
    """Independent method: two nips alone decide whether the web slips on the whole arc.

    With W the tension after the rear nip and a the tension that the front nip alone adds, the web
    sticks on the arc if a < W (1 - exp(-mu theta)), as far as the arc is free of both nips.  The
    radii next to the threshold, by less than 10 % of W, are left out.
    """
    winding, checked = solved("two drums"), 0
    front = winding.front
    assert front is not None
    for k, radius in enumerate(winding.nip_radius.tolist()):
        nip = winding.problem.nip(radius, on_web_roll(radius))
        further = nip.next_nips[0]
        rear = wo.solve(nip.replace(next_nips=(), roll_wrap=np.pi), nodes=33)
        W = rear.roll_wound_on_tension
        alone = wo.solve(
            nip.replace(
                next_nips=(), roll_wrap=np.pi, drum=further.drum, nip_load=further.nip_load,
                winding_force=further.winding_force,
            ),
            nodes=33,
        )  # fmt: skip
        added = alone.wound_on_tension - nip.web_tension
        free = front.arc[k] - (rear.half_width + front.width[k] / 2) / radius
        held = W * (1 - exp(-MU * free))
        if abs(added - held) < 0.1 * W:
            continue
        checked += 1
        assert bool(front.sticks[k]) == (added < held)
        if front.sticks[k]:
            # the squeeze of the ring by the front nip: below 0.5 % in the reference's cases
            assert front.added_tension[k] == pytest.approx(0, abs=5e-3 * W)
        else:
            assert front.added_tension[k] > 5e-3 * W
    assert checked >= 3


def test_more_torque_on_the_front_drum_winds_harder_through_the_rear_nip() -> None:
    """Torque splits 0.7, 0.5, 0.3: the rear nip holds back less of the tension, first order."""
    nips = [
        wo.solve(CASE.replace(torque_split=s).nip(0.2, on_web_roll(0.2)), nodes=33)
        for s in (0.7, 0.5, 0.3)
    ]
    WOT = [nip.roll_wound_on_tension for nip in nips]
    assert WOT[0] < WOT[1] < WOT[2]


def test_full_slip_has_the_tension_of_light_loads() -> None:
    """Closed form: max{T1, T1 exp(-mu theta) + F2 + mu P2}, T1 = T_in + F1 + mu P1, and so on."""
    problem = WITH_RIDER.replace(tension_law="friction")
    r = np.array([0.06, 0.08, 0.11])
    loads, result = problem.drum_loads(r), wo.solve(problem)
    T = 300.0 + loads.rear_force + MU * loads.rear_load
    T = np.maximum(T, T * np.exp(-MU * loads.front_arc) + loads.front_force + MU * loads.front_load)
    T = np.maximum(T, T * np.exp(-MU * loads.rider_arc) + MU * loads.rider_load)
    # the reported tension is linear in between, to 0.03 % of the default accuracy
    found = np.interp(r, result.radius, result.wound_on_tension)
    np.testing.assert_allclose(found, T, rtol=4e-4)
    # friction on the arcs has an effect, and the wrap on the rear drum belongs to its capacity
    assert not {"wrap_friction", "drum_wrap"} & set(problem.unused)
    slippery = wo.solve(problem.replace(wrap_friction=MU / 4)).wound_on_tension
    assert slippery[0] > 1.05 * result.wound_on_tension[0]


# ---- result, margins, report --------------------------------------------------------------------


def test_margins_contain_the_tensions_between_the_drums_and_their_slip() -> None:
    winding = solved("rider")
    front, rider = winding.front, winding.rider
    assert front is not None
    assert rider is not None
    least = min(front.least_tension, rider.least_tension)
    assert winding.least_tension <= least * (1 + 1e-3)  # interpolated over the radius
    assert winding.largest_tension >= front.largest_tension * (1 - 1e-3)
    r = winding.radius
    loads = winding.problem.drum_loads(r)
    used = np.maximum(
        150 / (0.2 * loads.rear_load), np.abs(loads.front_force) / (0.2 * loads.front_load)
    )
    assert winding.drum_friction_used == pytest.approx(used.max(), rel=1e-12)
    margin = winding.margins["drum_slip"]
    assert margin.limit == 1
    assert margin.note == "of the rear drum"
    assert winding.margins.drum_slip == pytest.approx(1 - used.max(), rel=1e-12)


def test_other_windings_have_no_margin_of_the_drums() -> None:
    winding = wo.solve(wo.WindingProblem.example().replace(radius=0.08, tension_law="friction"))
    assert np.isnan(winding.margins.drum_slip)
    assert "drum_slip" not in str(winding.margins)
    assert winding.front is None
    assert np.isnan(winding.mean_front_added_tension)


def test_no_torque_goes_through_a_roll_without_a_core_drive() -> None:
    """Conservation: the torque through the layers of a given roll is that of the core alone."""
    tension = wo.Profile(radius=[0.05, 0.35], value=[400.0, 400.0])
    shares = [
        wo.solve(CASE.replace(tension_law=tension, **{"winder.core_torque": M})).torque_share
        for M in (0.0, 10.0, 20.0)
    ]
    assert shares[0] == 0
    # M/R is linear between the reported radii, to 0.05 %
    assert shares[2] == pytest.approx(2 * shares[1], rel=5e-4)
    # of one drum, whose F = M/R - T_in leaves this torque to the core
    r = np.linspace(0.05, 0.35, 200)
    alone = CASE.replace(
        winder=None, torque_split=None, tension_law=tension, nip_load=2000.0,
        winding_force=wo.Profile(radius=r, value=10.0 / r - 300.0),
    )  # fmt: skip
    # the profile is linear between 200 radii, 1/r^2 error at the core (0.0015/0.05)^2/8
    assert wo.solve(alone).torque_share == pytest.approx(shares[1], rel=2e-3)


def test_the_first_lines_say_what_the_drums_add() -> None:
    lines = [line.text for line in answer_lines(solved("two drums"))]
    assert any(line.startswith("Mean wound-on tension") for line in lines)
    [front] = [line for line in lines if line.startswith("The front drum adds")]
    assert "slips on the whole arc between the drums" in front
    held = wo.solve(CASE.replace(radius=0.1), **COARSE)
    lines = [line.text for line in answer_lines(held)]
    assert "The front drum adds nothing: the layer sticks between the drums." in lines
    text = str(held)
    assert "load of the front drum" in text
    assert "bonded" in text


def test_a_saved_winding_has_its_drums(tmp_path: Path) -> None:
    winding = solved("rider")
    for name in ("winding.nc", "winding.json"):
        winding.save(tmp_path / name)
        loaded = wo.load_result(tmp_path / name)
        assert loaded.problem == winding.problem
        np.testing.assert_array_equal(loaded.front.added_tension, winding.front.added_tension)
        np.testing.assert_array_equal(loaded.rider.slip_angle, winding.rider.slip_angle)
        assert loaded.mean_rider_added_tension == winding.mean_rider_added_tension


def test_the_certificate_needs_the_nips_of_all_drums() -> None:
    """Error injection: a missing drum, and arrays of other lengths."""
    winding = solved("rider")
    front = winding.front
    assert front is not None
    assert certificate(winding).largest < 1e-8
    short = type(front)(**{name: array[1:] for name, array in vars(front).items()})
    for damaged in ({"front": None}, {"rider": None}, {"front": short}):
        assert certificate(winding.replace(**damaged)).nips == np.inf
    assert certificate(solved("two drums").replace(rider=front)).nips == np.inf


def test_the_nips_of_all_drums_are_solved_again() -> None:
    """Error injection: 0.1 % of any value of front drum and rider is noticed.

    Only where a drum adds less than 1 % of the tension, 0.1 % of that may be within the tolerance.
    """
    problem = WITH_RIDER.replace(roll_body="effective", radius=0.09)
    winding = wo.solve(problem, **COARSE, coupling_rtol=1e-6)
    again = winding.recomputed_nips()
    assert winding.front is not None
    assert winding.rider is not None
    for drum in ("front", "rider"):
        for name, values in vars(getattr(winding, drum)).items():
            expected, within = again[f"{drum}.{name}"]
            assert (np.abs(values - expected) <= within).all(), (drum, name)
            large = np.abs(values) > 0.01 * winding.nip_wound_on_tension
            is_noticed = np.abs(1.001 * values - expected) > within
            if name == "added_tension":
                assert is_noticed[large].all(), drum
            else:
                assert is_noticed.any() or not values.any(), (drum, name)


def test_the_drawing_is_that_of_the_geometry() -> None:
    """Closed form: bodies touch, distances of their centres are sums of their radii."""
    panel = winding_panels(solved("rider"))["winder"].make(solved("rider"))
    assert panel.to_scale

    def circle(name: str) -> tuple[np.ndarray, float]:
        curve = next(c for c in panel.curves if c.name == name)
        centre = np.array([(v.min() + v.max()) / 2 for v in (curve.x, curve.y)])
        return centre, float(np.ptp(curve.x) / 2)

    # of polygons with 120 sides
    roll, R = circle("radius")
    for name in ("drum", "front_drum", "rider"):
        centre, radius = circle(name)
        assert np.hypot(*(centre - roll)) == pytest.approx(R + radius, rel=1e-3)
    (rear, a), (front, b) = circle("drum"), circle("front_drum")
    assert front[0] - rear[0] == pytest.approx(a + b + 0.02, rel=1e-3)
    web = next(c for c in panel.curves if c.name == "web")
    on_roll = np.hypot(web.x - roll[0], web.y - roll[1])
    assert on_roll.min() == pytest.approx(R, rel=1e-3)  # no part of the web is inside of the roll


def test_the_report_in_mill_units_has_no_other_ones() -> None:
    with units_of(["mill"]):
        assert not re.findall(r"\d (N/m|N|kPa|MPa|mm|um)\b", str(solved("rider")))


# ---- studies ------------------------------------------------------------------------------------

QUICK = CASE.replace(tension_law="friction", radius=0.2)


def test_the_torque_split_is_found_swept_and_fitted() -> None:
    found = wo.find(
        QUICK, "torque_split", between=(0.3, 0.5), points=3, mean_wound_on_tension=390.0
    )
    assert found.result.mean_wound_on_tension == pytest.approx(390.0, rel=1e-4)
    swept = wo.sweep(QUICK, {"torque_split": [0.3, 0.4, 0.5]}, ["mean_wound_on_tension"])
    tension = swept["mean_wound_on_tension"].to_numpy()
    assert (np.diff(tension) < 0).all()
    measured = {
        "winder.rider_load [N/m]": [1500.0, 1800.0, 2200.0],
        "mean_wound_on_tension [N/m]": [
            wo.solve(
                QUICK.replace(torque_split=0.4, **{"winder.rider_load": load})
            ).mean_wound_on_tension
            for load in (1500.0, 1800.0, 2200.0)
        ],
    }
    fitted = wo.fit(QUICK, measured, {"torque_split": (0.3, 0.5)})
    assert fitted.estimates[0] == pytest.approx(0.4, rel=1e-3)


def test_an_operating_window_is_over_the_rider_load() -> None:
    board = QUICK.replace(
        stack=wo.Stack(radial=27e6, tangential=3.38e9, poissons_ratio=0.01, shear=10e6),
        radius=0.08, limits=wo.Limits(blocking_pressure="200 kPa"), **{"web.thickness": "500 um"},
    )  # fmt: skip
    window = wo.operating_window(
        board,
        web_tension=(250, 350), rider_load=("1.5 kN/m", "2.5 kN/m"),
        uncertain={"roll_friction": 0.2}, samples=128, workers=1,
    )  # fmt: skip
    assert window.names == ("web_tension", "winder.rider_load")
    assert set(window.margins) >= {"blocking", "drum_slip"}
    point = window.at("300 N/m", "2 kN/m")
    assert 0 <= point.probability <= 1
    window.plot()
    # the rear drum of a winder may brake
    none = dict.fromkeys(("web_tension", "nip_load", "rider_load", "torque_split"))
    given = {"torque_split": (-0.2, 0.6), "web_tension": (250, 350)}
    assert ranges_of(board, none | given, {})["torque_split"] == (-0.2, 0.6)
    with pytest.raises(wo.InvalidProblem, match=r"torque_split: -0\.2 is out of range"):
        ranges_of(wo.WindingProblem.example(), none | given, {})


@pytest.mark.parametrize(
    ("problem", "ranges", "text"),
    [
        (QUICK, {"nip_load": (1e3, 2e3)}, "nip_load: is given for a winding with a winder"),
        (QUICK, {}, "winder.rider_load"),
        (
            wo.WindingProblem.example(),
            {"rider_load": (1e3, 2e3)},
            "rider_load: is given for a winding without a winder",
        ),
    ],
)
def test_a_window_over_the_wrong_load_is_rejected(
    problem: wo.WindingProblem, ranges: dict[str, Any], text: str
) -> None:
    with pytest.raises(wo.InvalidProblem) as fault:
        wo.operating_window(
            problem, web_tension=(250, 350), uncertain={"roll_friction": 0.2}, **ranges
        )
    assert text in str(fault.value)
