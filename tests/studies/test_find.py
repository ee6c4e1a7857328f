"""Inverse problems: closed forms, round trips, several solutions, limits, and the command."""

from __future__ import annotations

import json
import pickle
from math import pi

import numpy as np
import pytest
from registered_kinds import registered
from roller_cases import steel_pair
from slow_cases import slow_case

import woundon as wo
from woundon.cli.commands import main
from woundon.io.case_files import load_case
from woundon.io.case_texts import template


@pytest.fixture
def curves():
    """The kind of closed-form curves, registered for the time of a test."""
    with registered("curve_problem") as module:
        yield module


# ---- nips and rolls -----------------------------------------------------------------------------


def test_the_load_of_a_hertzian_contact_is_found():
    """Closed form: a^2 = 4 P R / (pi E*)."""
    steel = wo.material("steel")
    modulus = steel.youngs_modulus / (2 * (1 - steel.poissons_ratio**2))
    found = wo.find(steel_pair(tangential_load=None), "load", nip_width="4 mm")
    load = pi * modulus * 0.002**2 / (4 * 0.125)
    assert found.value == pytest.approx(load, rel=1e-4)
    assert abs(found.value - load) < 2 * found.uncertainty
    assert found.problem.load == found.value
    assert found.result.nip_width == pytest.approx(4e-3, rel=1e-6)
    # dP/d(2a) = 2 P / (2a)
    assert found.slopes[0] == pytest.approx(4e-3 / (2 * load), rel=1e-3)
    assert len(found.solutions) == 1


@pytest.mark.parametrize(
    ("field", "value"),
    [("nip_load", 2500.0), slow_case("roll.material.shear", 1.6e7), slow_case("web_tension", 420)],
)
def test_a_value_is_recovered_from_the_output_that_it_gives(field, value):
    """Round trip, within the uncertainty that both discretisation errors cause."""
    problem = wo.NipProblem.example()
    tension = wo.solve(problem.replace(**{field: value})).wound_on_tension
    found = wo.find(problem, field, wound_on_tension=tension, points=9)
    assert abs(found.value - value) < 2 * found.uncertainty
    assert found.uncertainty < 0.02 * value
    single = wo.solve(found.problem, nodes=found.result.nodes)
    # warm starts do not change a result beyond the solver's tolerance
    assert single.wound_on_tension == pytest.approx(tension, rel=2e-7)


def test_the_target_may_be_a_total_force_and_a_symbol_is_recognised():
    problem = wo.NipProblem.example().replace(width=2.0)
    found = wo.find(problem, "nip_load", wound_on_tension="1.4 kN", points=5, nodes=33)
    assert found.target == 700.0
    with pytest.raises(wo.InvalidProblem, match="did you mean 'wound_on_tension'"):
        wo.find(problem, "nip_load", WOT=700.0)


@pytest.mark.slow
def test_all_solutions_are_found():
    """The wound-on tension has a maximum over the angle of a short wrap."""
    problem = wo.NipProblem.example()
    peak = wo.solve(problem.replace(roll_wrap=0.4)).wound_on_tension
    found = wo.find(problem, "roll_wrap", wound_on_tension=peak - 1.0, between=(0.05, 1.5))
    assert len(found.solutions) == 2
    assert found.value < 0.4 < found.solutions[1].value
    assert "2 values give" in str(found)
    assert list(found.values) == sorted(found.values)


def test_the_uncertainty_is_the_error_over_the_slope():
    """Independent: a central difference of two solutions on one mesh."""
    problem = wo.NipProblem.example()
    found = wo.find(problem, "nip_load", wound_on_tension=700.0, points=5, nodes=65)
    P, step = found.value, 5.0
    sides = [wo.solve(problem.replace(nip_load=P + d), nodes=65) for d in (-step, step)]
    slope = (sides[1].wound_on_tension - sides[0].wound_on_tension) / (2 * step)
    assert found.slopes[0] == pytest.approx(slope, rel=0.02)
    error = found.result.errors["wound_on_tension"]
    assert found.uncertainty == pytest.approx(error / abs(slope), rel=0.02)


@pytest.mark.slow
@pytest.mark.campaign
def test_the_load_for_a_margin_of_a_winding_is_found():
    problem = wo.WindingProblem.example()
    rough = {"nodes": 25, "rtol": 1e-2}
    share = wo.solve(problem.replace(nip_load=2500.0), **rough).torque_share
    found = wo.find(
        problem, "nip_load", between=(1500.0, 4000.0), points=3, torque_share=share, **rough
    )
    assert found.value == pytest.approx(2500.0, rel=0.02)


def test_points_without_a_steady_state_are_outside_the_reachable_range():
    problem = wo.NipProblem.example()
    found = wo.find(problem, "winding_force", wound_on_tension=700.0, between=(-900, 900), points=7)
    assert found.failures
    assert all(abs(value) > 690 for value, _ in found.failures)
    assert np.isnan(found.outputs[[0, -1]]).all()
    # |F| < mu- P = 700.4 N/m
    assert "solved down to winding_force = -700.4 N/m; below it: winding_force: -9" in str(found)
    assert "solved up to winding_force = 700.4 N/m; above it: winding_force: 900" in str(found)


def test_the_limit_where_a_coil_leaves_its_core():
    """A shrinkage of 0.03 % ends the contact, in a range of +-10 %.

    Independent: the pressure of a linear stack is linear in the shrinkage.
    """
    coil = wo.RollProblem(
        core=wo.Core(diameter="508 mm", stiffness="50 GPa"), diameter="1500 mm",
        stack=wo.Stack(radial="2 GPa", tangential="206 GPa", poissons_ratio=0.01, shear="1 GPa"),
        web_thickness="1 mm", wound_on_tension="30 MPa",
    )  # fmt: skip
    wound, shrunk = (wo.solve(coil.replace(core_shrinkage=e)).core_pressure for e in (0.0, 1e-4))
    found = wo.find(coil, "core_shrinkage", core_pressure="300 kPa")
    # error estimates of the pressures are 1e-3 of the largest
    assert found.value == pytest.approx((wound - 300e3) / (wound - shrunk) * 1e-4, rel=2e-3)
    assert len(found.values) <= 35
    with pytest.raises(wo.NoSolution) as no:
        wo.find(coil, "core_shrinkage", core_pressure="-10 kPa", between=(0, 0.1))
    # off the core the pressure on it is zero
    assert no.value.reachable == pytest.approx((0.0, wound), abs=10.0)


PROFILE = wo.ThicknessProfile(position=[0.0, 0.5, 1.0, 1.5], thickness=[1.0, 1.01, 0.99, 1.0])


@pytest.mark.parametrize(
    ("name", "value", "low", "high"),
    [
        ("thickness_profile.variation", 1.4, 0.0, 6.0),
        slow_case("thickness_profile.thickness.1", 1.02, 1.01 * 0.8, 1.01 * 1.2),
    ],
)
def test_a_profile_is_searched_near_its_values(name: str, value: float, low: float, high: float):
    """Round trip.  A lane of half or one and a half of the mean takes more than seven minutes."""
    roll = wo.RollProblem.example().replace(thickness_profile=PROFILE)
    rough = {"rtol": 0.05, "lanes": 6}
    worst = wo.solve(roll.replace(**{name: value}), **rough).worst_lane.pressure
    found = wo.find(roll, name, points=5, options=rough, **{"worst_lane.pressure": worst})
    assert found.value == pytest.approx(value, rel=1e-6)
    assert low <= found.values.min() < found.values.max() <= high
    assert not found.failures


# ---- curves with known zeros --------------------------------------------------------------------


def test_three_zeros_of_a_cubic(curves):
    found = wo.find(curves.CurveProblem(shape="cubic"), "position", height=0.0, between=(-2, 1.9))
    assert [value for value, _ in found.solutions] == pytest.approx([-1, 0, 1], abs=1e-6)
    assert [result.height for _, result in found.solutions] == pytest.approx([0] * 3, abs=1e-6)
    assert found.slopes == pytest.approx([2, -1, 2], rel=1e-5)  # 3 x^2 - 1


@pytest.mark.parametrize("depth", [1e-3, 1e-5])
def test_two_zeros_between_neighbouring_points_are_found_at_a_minimum(curves, depth):
    problem = curves.CurveProblem(shape="dip")
    found = wo.find(problem, "position", height=depth, between=(-1, 1), points=9)
    expected = [curves.DIP - depth**0.5, curves.DIP + depth**0.5]
    assert [value for value, _ in found.solutions] == pytest.approx(expected, abs=1e-6)


def test_a_minimum_above_the_target_is_no_solution(curves):
    with pytest.raises(wo.NoSolution) as caught:
        wo.find(curves.CurveProblem(shape="dip"), "position", height=-0.01, between=(-1, 1))
    assert caught.value.reachable[0] == pytest.approx(0, abs=1e-3)


def test_a_jump_across_the_target_is_no_solution(curves):
    problem = curves.CurveProblem(shape="step")
    with pytest.raises(wo.NoSolution, match=r"jumps across the target at position = 0\.3017 m"):
        wo.find(problem, "position", height=0.5, between=(-1, 1))


def test_a_discontinuity_of_the_discretisation_is_no_jump(curves):
    """An output in steps of 0.1 % of its range, e.g. of a winding whose radii are adaptive."""
    found = wo.find(curves.CurveProblem(), "position", rounded=0.3014, between=(0, 1))
    assert found.value == pytest.approx(0.3015, abs=1e-5)  # where 0.301 becomes 0.302
    assert found.reached == pytest.approx(0.3014, abs=6e-4)
    assert not found.jumps


def test_a_solution_next_to_the_limit_of_steady_states_is_found(curves):
    problem = curves.CurveProblem(shape="limit")
    found = wo.find(problem, "position", height=0.03, between=(-1, 1), points=5)
    assert found.value == pytest.approx(curves.LIMIT - 0.03**2, rel=1e-6)
    assert {reason for _, reason in found.failures} == {
        f"position: {value:g} is beyond the limit" for value, _ in found.failures
    }


def test_a_target_among_points_without_a_steady_state_is_no_solution(curves):
    problem = curves.CurveProblem(shape="hole")
    with pytest.raises(wo.NoSolution, match=r"solved up to position = 0\.89999.* above it: pos"):
        wo.find(problem, "position", height=0.1, between=(0, 2), points=5)
    found = wo.find(problem, "position", height=-0.2, between=(0, 2), points=3)
    assert found.value == pytest.approx(0.8, rel=1e-6)


def test_the_range_is_extended_while_the_output_approaches_the_target(curves):
    problem = curves.CurveProblem(scale=2.0, position=0.5)
    found = wo.find(problem, "scale", height=400.0)
    assert found.value == pytest.approx(800.0, rel=1e-6)
    with pytest.raises(wo.NoSolution, match=r"scale from 0\.000195313 to 20"):  # 2^-10
        wo.find(problem, "scale", height=-1.0)


def test_no_solution_carries_the_scan_and_pickles(curves):
    with pytest.raises(wo.NoSolution) as caught:
        wo.find(curves.CurveProblem(), "position", height=5.0, between=(0, 2), points=3)
    fault = caught.value
    assert isinstance(fault, wo.InvalidProblem)
    assert fault.reachable == (0.0, 2.0)
    # points next to the ends show that there is no extreme value inside
    assert fault.values == fault.outputs == pytest.approx((0.0, 0.01, 1.0, 1.99, 2.0))
    again = pickle.loads(pickle.dumps(fault))
    assert (str(again), again.reachable, again.values) == (str(fault), (0.0, 2.0), fault.values)
    assert str(fault) == "height: 5 is not reached by position from 0 m to 2 m, which gives 0 to 2"


def test_a_scan_without_any_solution_says_why(curves):
    problem = curves.CurveProblem(shape="nowhere")
    with pytest.raises(wo.NoSolution, match=r"no point of .* the first reason: position") as caught:
        wo.find(problem, "position", height=0.0)
    assert caught.value.reachable is None
    with pytest.raises(wo.NotConverged, match="the iteration did not converge"):
        wo.find(problem.replace(shape="stuck"), "position", height=0.0)
    with pytest.raises(wo.NoSolution, match="nothing is nan"):
        wo.find(problem.replace(shape="line"), "position", nothing=0.0)


@pytest.mark.parametrize(
    ("shape", "reason"),
    [("guessed", "not converged: the iteration did not converge"), ("branched", "height = -3")],
)
def test_a_solution_that_only_a_neighbour_leads_to_is_said_to_be_one(curves, shape, reason):
    problem = curves.CurveProblem(shape=shape)
    found = wo.find(problem, "position", height=3.0, between=(0.5, 4.0))
    assert found.value == pytest.approx(3.0, rel=1e-6)
    assert found.unconfirmed == ((found.value, reason),)
    expected = "position = 3 m is solved only from the result for a neighbouring value; without it"
    assert f"{expected}: {reason}" in str(found)
    assert json.loads(found.to_json())["unconfirmed"] == [[found.value, reason]]
    # below 2 m the solver needs no neighbour
    confirmed = wo.find(problem, "position", height=1.7, between=(0.5, 4.0))
    assert confirmed.unconfirmed == ()
    assert "neighbouring value" not in str(confirmed)


# ---- output -------------------------------------------------------------------------------------


def test_the_command_prints_the_answer_first(tmp_path, capsys):
    case = tmp_path / "case.toml"
    case.write_text(template("nip"))
    new = tmp_path / "found.toml"
    given = ["find", str(case), "--vary", "nip_load=1 kN/m:5 kN/m", "--points", "5",
             "--nodes", "33", "--target", "wound_on_tension=700 N/m", "--case", str(new),
             "--plot", str(tmp_path / "f.svg")]  # fmt: skip
    assert main(given) == 0
    message = capsys.readouterr().out.splitlines()
    assert message[0].startswith("nip_load = 3")
    assert message[2].split() == ["nip_load", "[N/m]", "wound_on_tension", "[N/m]"]
    assert sum(line.endswith("solution") for line in message) == 1
    result = wo.solve(load_case(new), nodes=33)
    assert result.wound_on_tension == pytest.approx(700.0, rel=2e-7)
    assert (tmp_path / "f.svg").exists()


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("temperature_change", "tangential_expansion, radial_expansion and core_expansion are 0"),
        ("core_shrinkage", "core_removed = true"),
        ("radial_expansion", ""),  # without a change of temperature
    ],
)
def test_a_field_without_effect_is_rejected_with_its_reason(name: str, reason: str):
    roll = wo.RollProblem.example().replace(core_removed=name == "core_shrinkage")
    expected = f"{name}: has no effect in this case{', as ' if reason else ''}{reason}; must be"
    with pytest.raises(wo.InvalidProblem) as rejected:
        wo.find(roll, name, peak_pressure="100 kPa")
    assert str(rejected.value).startswith(expected)


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("core_shrinkage", "core_removed = true"),
        ("temperature_change", "tangential_expansion and radial_expansion are 0"),
    ],
)
def test_the_reason_is_that_of_the_field_if_several_have_no_effect(name: str, reason: str):
    roll = wo.RollProblem.example().replace(
        core_removed=True, core_shrinkage=1e-3, temperature_change=-10.0, moisture_change=0.01
    )
    with pytest.raises(wo.InvalidProblem) as rejected:
        wo.find(roll, name, peak_pressure="100 kPa")
    assert str(rejected.value).startswith(f"{name}: has no effect in this case, as {reason};")


def test_a_change_of_the_finished_roll_is_searched_where_rolls_have_it():
    """To five times the usual change, 40 K, unless a range is given, which may be larger."""
    roll = wo.RollProblem.example().replace(radial_expansion=1e-4)
    with pytest.raises(wo.NoSolution, match="temperature_change from -40 K to 200 K") as missed:
        wo.find(roll, "temperature_change", core_pressure="1 MPa", points=3, rtol=0.1)
    assert max(missed.value.values) == 200.0
    found = wo.find(
        roll, "temperature_change", core_pressure="0.6 MPa", between=(0, 900), points=3, rtol=0.1
    )
    assert found.value > 200.0
    with pytest.raises(wo.InvalidProblem, match=r"must be >= -1000 and <= 1000 \[K\]"):
        wo.find(roll, "temperature_change", core_pressure="1 MPa", between=(0, 2000))


def test_the_command_as_json_and_its_exit_status(tmp_path, capsys):
    case = tmp_path / "case.toml"
    case.write_text(template("rollers"))
    assert main(["find", str(case), "--vary", "load", "--target", "nip_width=0.004", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["target"] == 0.004
    common = ["find", str(case), "--vary"]
    assert main([*common, "load=1e5:2e5", "--target", "nip_width=1 m"]) == 3
    assert "no solution: nip_width: 1000 mm is not reached by load" in capsys.readouterr().err
    assert main([*common, "lode", "--target", "nip_width=1 mm"]) == 2
    assert main([*common, "load=1", "--target", "nip_width=1 mm"]) == 2
    assert main([*common, "load", "--target", "nip_width"]) == 2
    assert main([*common, "load", "--target", "nip_width=1 mm", "--case", "x.txt"]) == 2
