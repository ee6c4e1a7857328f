"""Measured tables: predictions, the error budget, pull tabs, rules, and the command."""

from __future__ import annotations

import itertools
import json
import re
import tomllib
from importlib import resources
from math import pi
from pathlib import Path

import numpy as np
import pandas
import pytest
from roller_cases import steel_pair

import woundon as wo
from woundon import kinds
from woundon.cli.commands import main
from woundon.io.case_texts import to_toml
from woundon.problems.paths import get_field
from woundon.quantities import scalar_outputs

NIP = wo.NipProblem.example()
ROLL = wo.RollProblem.example()
LOADS = [1500.0, 2000.0, 2500.0, 3000.0, 3500.0, 4000.0]
FINDINGS = ("no systematic difference beyond the error budget",)


def tensions(nodes: int | None = None, **changes: float) -> np.ndarray:
    cases = [NIP.replace(**changes, nip_load=P) for P in LOADS]
    return np.array([wo.solve(case, nodes=nodes).wound_on_tension for case in cases])


@pytest.fixture(scope="module")
def predicted() -> np.ndarray:
    return tensions()


@pytest.fixture(scope="module")
def roll() -> wo.RollResult:
    return wo.solve(ROLL)


def check_of(values, deviation=3.0, problem=NIP, **more):
    table = {"nip_load": LOADS, "wound_on_tension": values,
             "wound_on_tension +-": [deviation] * len(LOADS)}  # fmt: skip
    return wo.compare(problem, table, **more)


# ---- predictions and residuals ------------------------------------------------------------------


def test_residuals_are_measured_minus_a_single_solve(predicted):
    shift = np.array([1.0, -2.0, 3.0, 0.0, -1.0, -1.0])
    check = check_of(predicted + shift)
    assert check.predicted == pytest.approx(predicted, rel=1e-7)
    assert check.residual == pytest.approx(shift, abs=1e-4)
    assert check.inputs["nip_load"].tolist() == LOADS
    assert check.agreement("wound_on_tension").bias == pytest.approx(0.0, abs=1e-4)
    assert [entry.finding for entry in check.explanations] == list(FINDINGS)


def test_the_tension_of_a_wound_roll_is_an_input_that_rows_may_have():
    table = {"wound_on_tension": [350.0, 400.0], "core_pressure": [3e5, 3e5]}
    predicted = [
        wo.solve(ROLL.replace(wound_on_tension=T)).core_pressure for T in table["wound_on_tension"]
    ]
    assert wo.compare(ROLL, table).predicted == pytest.approx(predicted, rel=1e-12)


def test_totals_are_divided_by_the_width_of_the_case():
    """In comparisons and fits; a width in the table is that of the row."""
    wide = NIP.replace(width=2.0)
    totals = {"nip_load [kN]": [2.0, 4.0], "wound_on_tension [N]": [900.0, 1100.0],
              "wound_on_tension +- [N]": [10.0, 20.0]}  # fmt: skip
    check = wo.compare(wide, totals, nodes=17)
    np.testing.assert_allclose(check.inputs["nip_load"], [1000.0, 2000.0])
    np.testing.assert_allclose(check.measured, [450.0, 550.0])
    np.testing.assert_allclose(check.deviation, [5.0, 10.0])
    fit = wo.fit(wide, totals, ["roll_friction"], nodes=17, starts=1, profiles=False)
    np.testing.assert_allclose(fit.measured, [450.0, 550.0])
    rows = wo.compare(wide, {**totals, "width [m]": [2.0, 4.0]}, nodes=17)
    np.testing.assert_allclose(rows.measured, [450.0, 275.0])
    with pytest.raises(wo.InvalidProblem, match="is a force; expected a force per width"):
        wo.compare(NIP, totals, nodes=17)


def test_rows_without_a_value_and_rows_of_other_outputs_do_not_mix():
    table = {"nip_load": [2000.0, 2000.0, 3000.0], "nip_width [mm]": [4.0, None, 5.0],
             "wound_on_tension": [None, 600.0, None]}  # fmt: skip
    check = wo.compare(NIP, table, nodes=33)
    assert check.names == ("nip_width", "wound_on_tension", "nip_width")
    assert check.numbers == (1, 2, 3)
    results = [wo.solve(NIP.replace(nip_load=P), nodes=33) for P in (2000.0, 3000.0)]
    expected = [results[0].nip_width, results[0].wound_on_tension, results[1].nip_width]
    assert check.predicted == pytest.approx(expected, rel=1e-7)


def test_a_row_without_a_steady_state_has_a_reason(predicted):
    table = {"winding_force": [0.0, -900.0], "wound_on_tension": [predicted[4], 1.0]}
    check = wo.compare(NIP, table)
    assert check.failures[0] == ""
    assert check.failures[1].startswith("winding_force: -900 is out of range")
    assert check.agreement("wound_on_tension").size == 1
    assert "1 value without a prediction, e.g. row 2: winding_force" in str(check)
    with pytest.raises(wo.InvalidProblem, match="no row of the table has a prediction"):
        wo.compare(NIP, {"winding_force": [-900.0], "wound_on_tension": [1.0]})


# ---- error budget -------------------------------------------------------------------------------


def test_the_spread_of_an_input_follows_its_closed_form():
    """Closed form: a^2 = 4 P R / (pi E*), so that 2 % of the load are 1 % of the width."""
    pair = steel_pair(tangential_load=None)
    check = wo.compare(pair, {"nip_width [mm]": [0.7]}, spread={"load": "2 %"})
    assert check.spread[0] == pytest.approx(0.01 * check.predicted[0], rel=1e-3)
    both = wo.compare(
        pair, {"nip_width [mm]": [0.7]}, spread={"load": "1.78 kN/m", "upper.radius": "4 %"}
    )
    # 1/R = 1/R1 + 1/R2: 4 % of one radius are 2 % of R
    assert both.spread[0] == pytest.approx(2**0.5 * check.spread[0], rel=1e-2)
    assert both.sources == ("load", "upper.radius")


def test_parts_of_the_budget_add_in_squares(predicted):
    check = check_of(predicted, spread={"roll.material.shear": "5 %"})
    total2 = check.deviation**2 + check.error**2 + check.spread**2
    assert check.total == pytest.approx(np.sqrt(total2))
    assert check.deviation.tolist() == [3.0] * len(LOADS)
    one = wo.solve(NIP.replace(nip_load=LOADS[0]))
    assert check.error[0] == pytest.approx(one.errors["wound_on_tension"], rel=0.05)
    # independent: the difference of two solutions on the mesh of the result
    step = 0.05 * NIP.roll.material.shear
    sides = [wo.solve(NIP.replace(nip_load=LOADS[0], **{"roll.material.shear": G}), nodes=65)
             .wound_on_tension for G in (1e7 - step, 1e7 + step)]  # fmt: skip
    assert check.spread[0] == pytest.approx(abs(sides[1] - sides[0]) / 2, rel=0.05)


@pytest.mark.slow
def test_independent_deviations_average_out_and_common_ones_do_not(predicted):
    alone = check_of(predicted, nodes=65).agreement("wound_on_tension")
    error = alone.bias_uncertainty**2 - 3.0**2 / len(LOADS)
    assert 0 < error < 1.0  # the mean discretisation error, squared
    check = check_of(predicted, nodes=65, spread={"roll.material.shear": "5 %"})
    both = check.agreement("wound_on_tension")
    added = both.bias_uncertainty**2 - alone.bias_uncertainty**2
    assert added == pytest.approx(float(np.mean(check.effects)) ** 2, rel=1e-6)


# ---- pull tabs and lengths ----------------------------------------------------------------------


def test_a_pull_tab_is_calibrated_by_a_line_or_by_friction_and_area():
    tab = wo.PullTab(slope="2 kPa/N", offset="5 kPa")
    assert tab.pressure(np.array([10.0, 20.0])).tolist() == [25e3, 45e3]
    strip = wo.PullTab(friction=0.25, area="10 cm^2")
    assert strip.pressure(100.0) == pytest.approx(100.0 / (2 * 0.25 * 1e-3))
    assert wo.PullTab(friction=0.25, area=1e-3, faces=1).pressure(50.0) == strip.pressure(100.0)


def test_the_deviation_of_a_calibration_is_not_that_of_the_readings():
    table = {"measured_radius": [0.06, 0.1], "pull_tab_force [N]": [90.0, 80.0]}
    tab = {"slope": "2 kPa/N"}
    without = str(wo.compare(ROLL, table, tab=wo.PullTab(**tab)))
    assert "pressure: no standard deviations of the measurement" in without
    with_tab = str(wo.compare(ROLL, table, tab=wo.PullTab(**tab, deviation="5 %")))
    assert "no standard deviations of the measurement" not in with_tab
    assert "that of the calibration is known, but the single readings" in with_tab


def test_pressures_of_pull_tabs_are_compared_at_their_radii(roll):
    radius = np.array([0.06, 0.08, 0.1, 0.12, 0.14])
    true = np.asarray(roll.at_radius(radius)["pressure"])
    tab = wo.PullTab(slope="2 kPa/N", offset="5 kPa", deviation="3 %")
    force = (true - 5e3) / 2e3
    table = {"measured_radius [mm]": 1e3 * radius, "pull_tab_force [N]": force,
             "pull_tab_force +- [N]": [1.5] * 5}  # fmt: skip
    check = wo.compare(ROLL, table, tab=tab)
    assert check.names == ("pressure",) * 5
    assert check.residual == pytest.approx(np.zeros(5), abs=1e-3)
    assert check.deviation == pytest.approx(np.full(5, 3e3))
    assert check.spread == pytest.approx(0.03 * true)
    assert check.sources == ("pull tab",)
    by_diameter = {"diameter [mm]": 2e3 * radius, "pressure [Pa]": true}
    assert wo.compare(ROLL, by_diameter).residual == pytest.approx(np.zeros(5), abs=1e-3)


def test_a_radius_beyond_the_surface_by_rounding_is_that_of_the_surface(roll):
    beyond, table = ROLL.radius * (1 + 1e-10), {"residual_tension": [roll.residual_tension[-1]]}
    assert wo.compare(ROLL, {"measured_radius": [beyond], **table}).residual == pytest.approx([0.0])
    assert roll.at_radius(beyond) == roll.at_radius(ROLL.radius)
    with pytest.raises(wo.InvalidProblem, match=r"measured_radius: 0\.150001 is out of range"):
        wo.compare(ROLL, {"measured_radius": [ROLL.radius + 1e-6], **table})


def test_the_length_at_a_diameter_is_that_of_pressed_layers(roll):
    """Conservation: the mass laid up to a radius; of a stiff stack the area over the thickness."""
    radius = np.array([0.06, 0.1, 0.15])
    stages = [roll.at(r) for r in radius[:-1]] + [roll]
    known = [stage.wound_mass / (ROLL.density * ROLL.web_thickness) for stage in stages]
    table = {"diameter": 2 * radius, "length": known}
    assert wo.compare(ROLL, table).residual == pytest.approx(np.zeros(3), abs=1e-6)
    assert known[-1] == pytest.approx(roll.wound_length)
    assert f"compressed as wound (wound_length), {roll.wound_length:.5g} m" in str(
        wo.compare(ROLL, table)
    )
    assert f"without pressure (length), {roll.length:.5g} m" in str(wo.compare(ROLL, table))
    without = wo.compare(ROLL.replace(density=None), table)
    assert without.residual == pytest.approx(np.zeros(3), abs=1e-6)
    loose = ROLL.replace(wound_on_tension=1.0)
    area = pi * (radius**2 - ROLL.core.radius**2) / ROLL.web_thickness
    slack = wo.compare(loose, table).predicted
    assert slack == pytest.approx(area, rel=5e-3)
    assert (slack > area).all()


def test_a_winding_is_compared_over_its_radius():
    winding = wo.WindingProblem.example().replace(
        tension_law="fixed", nip_induced_tension=100.0, radius=0.2
    )
    result = wo.solve(winding)
    table = {"measured_radius": [0.1, 0.15], "wound_on_tension": [400.0, 390.0],
             "pressure": [1e5, 1e5], "length": [1.0, 1.0]}  # fmt: skip
    check = wo.compare(winding, table)
    T = np.interp([0.1, 0.15], result.radius, result.wound_on_tension)
    P = np.asarray(result.roll.at_radius([0.1, 0.15])["pressure"])
    assert check.predicted[check.of("wound_on_tension")] == pytest.approx(T)
    assert check.predicted[check.of("pressure")] == pytest.approx(P)
    assert np.isfinite(check.predicted).all()


def test_a_pull_tab_at_the_surface_is_left_out(roll):
    """The pressure at the surface is zero by its boundary condition."""
    table = {"measured_radius [mm]": [100.0, 150.0], "pressure": [2e5, 2e4]}
    check = wo.compare(ROLL, table)
    assert check.agreement("pressure").size == 1
    assert "1 value without a prediction, e.g. row 2: pressure: is zero at the surface" in str(
        check
    )
    outside = wo.compare(ROLL, table | {"measured_radius [mm]": [100.0, 500.0]})
    assert "must be >= 0.0445 and <= 0.15 [m], on the roll" in str(outside)


# ---- possible causes ----------------------------------------------------------------------------


def causes(check: wo.Comparison) -> str:
    return "; ".join(cause for entry in check.explanations for cause in entry.causes)


def test_causes_are_inputs_with_the_change_that_is_needed():
    """Closed form: a^2 = 4 P R/(pi E*); 1/R and 1/E* are sums over two equal bodies."""
    pair = steel_pair(tangential_load=None)
    loads = np.array([60e3, 80e3, 100e3])
    width = np.array([wo.solve(pair.replace(load=P), nodes=33).nip_width for P in loads])
    table = {"load": loads, "nip_width": 1.05 * width, "nip_width +-": [1e-7] * 3}
    check = wo.compare(pair, table, nodes=33)
    assert "by 5 % of the mean, in 3 of 3 values" in str(check)
    assert "rises" not in str(check)  # a factor is not a trend
    nu = 0.3  # d ln(1 - nu^2)/d ln nu = -2 nu^2/(1 - nu^2): the change exceeds a factor of two
    assert abs(0.05 / (0.25 * -2 * nu**2 / (1 - nu**2))) > 1
    # (E/E1 + 1)/2 = 1.05^2; the stated change is that of a secant
    needed = 1 / (2 * 1.05**2 - 1) - 1
    (bias,) = [entry for entry in check.explanations if "larger than predicted" in entry.finding]
    found = [
        re.match(r"(\w+).material.youngs_modulus (.*) %: ", c).groups() for c in bias.causes[:2]
    ]
    assert {side for side, _ in found} == {"upper", "lower"}
    assert [float(change) for _, change in found] == pytest.approx([100 * needed] * 2, rel=0.05)
    # neither the friction nor the measured load is a cause
    assert all(not cause.startswith(("load", "friction", "upper.radius")) for cause in bias.causes)
    far = wo.compare(pair, {**table, "nip_width": 2 * width}, nodes=33)
    assert "no input alone: each would have to change by more than a factor of two" in str(far)


@pytest.mark.slow
def test_the_stated_change_of_an_input_removes_the_difference():
    """Independent: the problem is solved with the changed input."""
    measured = tensions(nodes=33, **{"roll.material.shear": 1.2e7})
    check = check_of(measured, nodes=33)
    (bias,) = [entry for entry in check.explanations if "larger than predicted" in entry.finding]
    changes = dict(re.match(r"([\w.]+) ([-+.\d]+) %", c).groups() for c in bias.causes[:-1])
    assert float(changes["roll.material.shear"]) == pytest.approx(20, rel=0.1)
    for name, change in changes.items():
        changed = NIP.replace(**{name: get_field(NIP, name) * (1 + float(change) / 100)})
        residual = check_of(measured, problem=changed, nodes=33).residual
        # by a secant at one row, for changes of up to a factor of two
        assert abs(residual.mean()) < 0.3 * check.residual.mean(), name


def test_a_tension_that_falls_with_the_speed_points_to_entrained_air(predicted):
    speed = np.linspace(5.0, 30.0, 6)
    table = {"nip_load": [3502.0] * 6, "web_speed [m/s]": speed,
             "wound_on_tension": 700.0 - 2.0 * (speed - 5.0) + [1, -1, 0, 1, -1, 0],
             "wound_on_tension +-": [3.0] * 6}  # fmt: skip
    check = wo.compare(NIP, table)
    assert check.covariates == ("web_speed",)
    assert "web_speed is not part of this problem: it is used for trends only" in str(check)
    (trend,) = [entry for entry in check.explanations if "with web_speed" in entry.finding]
    assert any("entrained air" in cause for cause in trend.causes)


def test_the_effects_outside_a_problem_name_classes_and_fields_that_exist():
    """A misspelt name would never match a difference."""
    path = resources.files("woundon") / "studies" / "explanations.toml"
    content = tomllib.loads(path.read_text("utf-8"))
    fields = {"radius"}.union(*(kind.problem.model_fields for kind in kinds.every()))
    for effect in content["effects"]:
        assert effect.get("unless", "air") in fields
        for difference in effect["explains"]:
            of_class, word, *trend = difference.split()
            assert of_class in {"tension", *content["classes"]}
            assert word in ("rises", "falls") if trend else word in ("larger", "smaller")
            assert not trend or (trend[0] == "with" and trend[1] in fields)
    for output in itertools.chain(*content["classes"].values()):
        assert any(output in scalar_outputs(kind.result) for kind in kinds.every()) or (
            output == "pressure"  # over the radius
        )


def test_a_constant_ratio_of_pressures_points_to_the_calibration(roll):
    radius = np.linspace(0.06, 0.14, 6)
    true = np.asarray(roll.at_radius(radius)["pressure"])
    table = {"measured_radius": radius, "pressure": 1.3 * true, "pressure +-": [3e3] * 6}
    check = wo.compare(ROLL, table)
    assert "the ratio is nearly constant (1.3): the calibration of the tab" in causes(check)
    relaxed = wo.compare(ROLL, table, spread={"wound_on_tension": "20 %"})
    assert "lies within the spread of the inputs" in str(relaxed)
    assert "largest contribution is that of wound_on_tension" in str(relaxed)


# ---- input and output ---------------------------------------------------------------------------


def test_the_command(tmp_path: Path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("roll.toml").write_text(to_toml(ROLL))
    Path("tabs.csv").write_text(
        "diameter [mm];pull tab force [N];Nr\n120;125,0;1\n200;125,0;2\n280;95,5;3\n"
    )
    command = ["compare", "tabs.csv", "roll.toml", "--tab-friction", "0.25", "--tab-area",
               "12 cm^2", "--tab-deviation", "5 %", "--column", "Nr=", "--spread",
               "wound_on_tension=5 %"]  # fmt: skip
    assert main([*command, "--plot", "tabs.svg", "--save", "tabs_compared.csv"]) == 0
    message = capsys.readouterr().out
    assert message.startswith("pressure: 3 values, measured - predicted")
    assert Path("tabs.svg").exists()
    frame = pandas.read_csv("tabs_compared.csv")
    assert frame.measured[0] == pytest.approx(125.0 / (2 * 0.25 * 12e-4))
    assert main([*command, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["sources"] == ["wound_on_tension", "pull tab"]
    assert main(["compare", "tabs.csv", "roll.toml", "--column", "Nr="]) == 2
    assert main([*command, "--save", "x.txt"]) == 2


def test_the_scatter_of_an_input_adds_its_effect_on_the_prediction():
    """Hertz's law: the half width of two cylinders varies as the square root of the load."""
    rollers = wo.RollerProblem.example()
    load, width = 89e3, wo.solve(rollers.replace(load=89e3)).half_width
    table = {"load": [load], "load +-": [0.04 * load], "half_width": [width]}
    own = 0.01 * width
    check = wo.compare(rollers, table | {"half_width +-": [own]})
    # d ln a/d ln P = 1/2, so that 4 % of the load are 2 % of the half width
    assert check.deviation[0] == pytest.approx(width * (0.01**2 + 0.02**2) ** 0.5, rel=1e-3)
    # without a deviation of the output there is none: the residuals contain the scatter
    assert np.isnan(wo.compare(rollers, table).deviation[0])
    rows = {name: [*cells, *cells] for name, cells in table.items()} | {"half_width +-": [own] * 2}
    found = wo.fit(rollers, rows, {"upper.radius": (0.1, 1.0)}, starts=1, profiles=False)
    exact = wo.fit(
        rollers,
        {name: cells for name, cells in rows.items() if name != "load +-"},
        {"upper.radius": (0.1, 1.0)},
        starts=1,
        profiles=False,
    )
    ratio = found.standard_errors[0] / exact.standard_errors[0]
    assert ratio == pytest.approx(5**0.5, rel=1e-3)
