"""The laws of taper and the steps of schedules: closed forms, forms of entry, and every field."""

from __future__ import annotations

import tomllib

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from slow_cases import slow_case

import woundon as wo
from woundon.io.case_files import make_problem
from woundon.io.case_texts import to_toml
from woundon.problems.finished_roll import OF_FINISHED_ROLL
from woundon.problems.schedules import Curve, schedule_fields
from woundon.studies.window_cases import with_value

WINDING = wo.WindingProblem.example().replace(tension_law="friction")
CORE, R = 0.05, 0.6
RADII = np.linspace(CORE, R, 23)
HARD_CORE = wo.Steps(value=[450.0, 350.0, 300.0], depth=[0.02, 0.2], ramp=0.002)


def values(schedule: object) -> np.ndarray:
    return Curve(schedule, CORE, R).at(RADII)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("law", "expected"),
    [
        # the formulas of the docstring, written again with numbers
        (wo.Taper(start=400.0, taper=0.3), lambda r: 400 - 120 * (r - 0.05) / 0.55),
        (wo.Taper(start=400.0, taper=0.3, law="hyperbolic"), lambda r: 280 + 120 * 0.05 / r),
        (wo.Taper(start=400.0, law="constant_torque"), lambda r: 20 / r),
        (wo.Taper(start=400.0, law="power", exponent=0.5), lambda r: 400 * np.sqrt(0.05 / r)),
        (wo.Taper(start=400.0, law="power", exponent=-1.0), lambda r: 8000 * r),
    ],
)
def test_the_laws_are_their_formulas(law: wo.Taper, expected: object):
    # rounding
    np.testing.assert_allclose(values(law), expected(RADII), rtol=1e-14)  # type: ignore[operator]


@given(st.floats(1.0, 1e3))
def test_laws_that_are_special_cases_of_others(start: float):
    torque = wo.Taper(start=start, law="constant_torque")
    hyperbolic = wo.Taper(start=start, law="hyperbolic", taper=1.0)
    # rounding: 1 - (1 - rc/r) has that of 1, up to R/rc = 12 times larger relative to rc/r
    np.testing.assert_allclose(values(hyperbolic), values(torque), rtol=1e-14)
    np.testing.assert_allclose(values(torque) * RADII, start * CORE, rtol=1e-14)
    power = wo.Taper(start=start, law="power", exponent=1.0)
    np.testing.assert_array_equal(values(power), values(torque))
    np.testing.assert_array_equal(values(wo.Taper(start=start, law="power", exponent=0.0)), start)


def test_steps_hold_their_values_between_the_ramps():
    r = CORE + np.array([0.0, 0.02, 0.021, 0.022, 0.2, 0.2015, 0.202, 0.55])
    expected = [450, 450, 400, 350, 350, 312.5, 300, 300]
    # rounding of the radii, on ramps of 5e4 N/m^2
    np.testing.assert_allclose(Curve(HARD_CORE, CORE, R).at(r), expected, rtol=1e-10)
    kinks = Curve(HARD_CORE, CORE, R).kinks
    np.testing.assert_allclose(kinks, CORE + np.array([0.02, 0.022, 0.2, 0.202]), rtol=1e-14)


@pytest.mark.parametrize("schedule", [HARD_CORE, wo.Taper(start=450.0, law="power", exponent=0.3)])
def test_every_scheduled_field_takes_every_law(schedule: wo.Steps | wo.Taper):
    """Each scheduled field of a winding and its winder, with values of its order of magnitude."""
    scale = {"torque_split": 1e-3, "nip_load": 5.0, "winder.rider_load": 8.0}
    for name in (*schedule_fields(wo.WindingProblem), "winder.rider_load", "winder.core_torque"):
        if name == "tension_law" or name in OF_FINISHED_ROLL:  # a name or a profile
            continue
        factor = scale.get(name, 1.0)
        law = schedule.replace(
            **(
                {"start": factor * schedule.start}
                if isinstance(schedule, wo.Taper)
                else {"value": [factor * value for value in schedule.value]}
            )
        )
        changes: dict[str, object] = {name: law}
        if name == "nip_induced_tension":
            changes["tension_law"] = "fixed"
        if name == "winding_force":
            changes["drum_friction"] = 2.0
        if name.startswith("winder"):
            front = wo.Rigid(radius=0.25)
            winder = wo.TwoDrums(front_drum=front, gap=0.02, rider_load=4e3)
            changes = {
                "winder": winder.replace(**{name.removeprefix("winder."): law}),
                "nip_load": None,
                "torque_split": 0.5,
                "drum_friction": 2.0,
            }
        problem = WINDING.replace(**changes)
        np.testing.assert_allclose(problem.at(name, RADII), factor * values(schedule), rtol=1e-14)
        assert make_problem(tomllib.loads(to_toml(problem))) == problem


def test_steps_with_units_are_read_where_a_field_holds_them():
    hard_core = wo.Steps(value=["10 MPa", "8 MPa"], depth=["20 mm"], ramp="2 mm")
    assert WINDING.replace(web_tension=hard_core).web_tension.value == (660.0, 528.0)  # 66 um
    table = {"value": ["4 pli", "3 pli"], "depth": ["1 in"]}
    steps = WINDING.replace(web_tension=table).web_tension
    assert isinstance(steps, wo.Steps)
    assert steps.depth == (0.0254,)
    total = WINDING.replace(width=2.0, web_tension={"value": ["900 N", 300.0], "depth": [0.02]})
    assert total.web_tension.value == (450.0, 300.0)
    with pytest.raises(wo.InvalidProblem, match=r"torque_split\.value\.0: .* wrong dimension"):
        WINDING.replace(torque_split=wo.Steps(value=["450 N/m", "300 N/m"], depth=[0.02]))


def test_a_ramp_longer_than_the_build_up_is_named():
    steps = wo.Steps(value=[450.0, 350.0], depth=[0.02], ramp=0.6)
    with pytest.raises(wo.InvalidProblem, match=r"web_tension\.ramp: 0\.6 .* < 0\.55 \[m\]") as f:
        WINDING.replace(web_tension=steps)
    assert len(f.value.faults) == 1


def test_a_set_point_scales_all_steps():
    problem = WINDING.replace(web_tension=HARD_CORE)
    scaled = problem.replace(**with_value(problem, "web_tension", 225.0))
    assert scaled.web_tension == HARD_CORE.replace(value=[225.0, 175.0, 150.0])


def test_a_stage_of_the_build_up_ends_before_the_next_step():
    roll = wo.RollProblem.example().replace(wound_on_tension=HARD_CORE, radius=0.3)
    stage = wo.solve(roll, rtol=1e-2).at(0.055)  # 10.5 mm of roll: all steps are still to come
    assert stage.problem.tension_curve.at(np.array([0.05, 0.055])) * 66e-6 == pytest.approx(450.0)


@pytest.mark.parametrize("body", ["linear", slow_case("effective")])
@pytest.mark.filterwarnings("ignore::woundon.ResolutionWarning")
def test_a_winding_with_steps_is_that_of_the_profile_through_their_corners(body: str):
    """The steps are linearised about a smooth tension, the profile is resolved by the nips."""
    problem = wo.WindingProblem.example().replace(
        radius=0.12, roll_body=body, web_tension=wo.Steps(value=[350, 300], depth=[0.02])
    )
    profile = wo.Profile(radius=[0.05, 0.07, 0.071, 0.12], value=[350, 350, 300, 300])
    steps, corners = (
        wo.solve(case, rtol=1e-2) for case in (problem, problem.replace(web_tension=profile))
    )
    r = np.linspace(0.0507, 0.12, 200)  # from the tenth layer
    tensions = (np.interp(r, one.radius, one.wound_on_tension) for one in (steps, corners))
    error = steps.interpolation_error + corners.interpolation_error
    np.testing.assert_allclose(*tensions, rtol=error)
    assert steps.interpolation_error < 0.02  # a step of 14 %
    assert steps.core_pressure == pytest.approx(corners.core_pressure, rel=2 * error)
    before, after = (float(np.interp(r, steps.radius, steps.web_tension)) for r in (0.07, 0.071))
    assert (before, after) == pytest.approx((350.0, 300.0))


def test_the_report_has_the_values_at_core_and_surface():
    result = wo.solve(WINDING.replace(radius=0.12, web_tension=HARD_CORE.replace(
        value=[450.0, 350.0], depth=[0.02])), rtol=1e-2)  # fmt: skip
    rows = [line for line in str(result).splitlines() if "web tension" in line and "at the" in line]
    assert [float(row.split()[-2]) for row in rows] == [450.0, 350.0], rows
