"""Reports: numbers, units and errors are the result's; what does not apply is not said."""

from __future__ import annotations

import math
import re
from io import StringIO
from math import pi
from typing import Any

import numpy as np
import pytest
from coarse_solutions import coarse_solution
from rich.console import Console
from thesis_cases import newsprint_nip

import woundon as wo
from woundon import kinds, quantities
from woundon.io.chosen_units import units_of
from woundon.report.figures import unit_of
from woundon.report.html import unit_html
from woundon.report.html_report import _inputs, _is_omitted, report_file
from woundon.report.nip_report import nip_report
from woundon.report.report_parts import Row, Section, certificate_line, value_row, zone_line
from woundon.report.roll_report import changes_sections
from woundon.report.terminal import print_parts
from woundon.report.trade_rule import nip_trade_rule, winding_trade_rule

OF_ROLLS = (wo.RollResult, wo.WindingResult)
NODES = 33  # of three meshes, so that errors are estimated


def lines(text: str) -> list[str]:
    """Return the lines with single spaces."""
    return [" ".join(line.split()) for line in text.splitlines()]


def sections(parts: list[Any]) -> dict[str, list[str]]:
    """Return for each section of a report its lines as printed."""
    out = {}
    for part in parts:
        if isinstance(part, Section):
            paper = StringIO()
            print_parts([part], Console(file=paper))
            out[part.title] = lines(paper.getvalue())[1:]
    return out


@pytest.fixture(scope="module")
def examples() -> list[Any]:
    """One solved case of every kind."""
    return [coarse_solution(kind.problem.example(), NODES) for kind in kinds.every()]


# ---- rows ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("value", "error", "shown"),
    [
        (259.012, 0.1469, ("259.01", "0.15")),
        (5.02871, 1.9e-7, ("5.0287", "<0.0001")),  # below the last digit
        (-0.157158, 1e-18, ("-0.15716", "<1e-05")),
        (1.77e-8, 2.6e-6, ("0", "2.6e-06")),  # nothing is known of a value within its error
        (-0.4, 3.0, ("-0.4", "3")),
        (-0.04, 3.0, ("0", "3")),
        (0.0, 0.0, ("0", "")),
        (0.0, 0.2, ("0", "0.2")),
        (75, math.nan, ("75", "")),
        (math.nan, 0.1, ("nan", "")),
        ("rolling", math.nan, ("rolling", "")),
    ],
)
def test_a_value_shows_five_digits_and_no_more_than_its_error_tells(value, error, shown):
    row = Row("meaning", "s", value, "mm", error)
    assert (row.value_text, row.error_text) == shown


def test_every_error_estimate_stands_next_to_its_output(examples):
    """The outputs with a error estimate are in the report, with quantity, value, unit and error."""
    for result in examples:
        said = lines(str(result))
        estimate = dict(result.errors)
        estimate.pop("half_width", None)  # the width is there, twice it
        given = isinstance(result, wo.RollerResult) and "tangential_load"
        assert len(estimate) >= 3
        for name, error in estimate.items():
            if name == given or error != error:
                continue
            if name == "inlet_tension" and not result.problem.drum_wrap:
                continue  # it is the given web tension
            if isinstance(result, wo.WindingResult) and name.startswith("bore_"):
                continue  # of a roll on its core they are in the report of the roll
            quantity = quantities.output(result, name).quantity
            # the first one: those of the same nip without wraps come below
            line = next(x for x in said if x.startswith(f"{quantity.meaning} {quantity.symbol} "))
            value, unit, error_text = _parsed(line, quantity)
            size = quantity.shown(getattr(result, name))
            error = quantity.shown(error)
            # to the five digits of the value, or where the error begins
            assert value == pytest.approx(size, rel=1e-4, abs=error), name
            assert unit == quantity.display
            if error_text.startswith("<"):
                assert error < float(error_text[1:]) <= 1.01e-4 * abs(size)
            elif size or error:
                assert float(error_text) == pytest.approx(error, rel=0.06)  # two digits


def _parsed(line: str, quantity: wo.Quantity) -> tuple[float, str, str]:
    rest = line.removeprefix(f"{quantity.meaning} {quantity.symbol} ")
    value, _, rest = rest.partition(" ")
    unit, _, error = rest.partition("±")
    return float(value), unit.strip(), error.split(",")[0].strip()


# ---- the nip with its wraps ----------------------------------------------------------------------


def test_a_nip_that_is_none_without_its_wraps_says_why():
    wrapped = newsprint_nip(nip_load=1000.0, roll_wrap=pi, winding_force=400.0, drum_wrap=2.5)
    said = sections(nip_report(wo.solve(wrapped, nodes=NODES)))
    text = " ".join(said["Same nip with the web held at the trailing edge"])
    assert text.startswith("No steady state exists: winding_force: 400 is out of range")
    # the closed forms of the tension know no drum wrap
    assert [line.split()[0] for line in said["Other theories"]] == ["Hertz", "Hertz"]


# ---- the trade rule NIT = mu N -------------------------------------------------------------------


@pytest.mark.parametrize(
    "changes",
    [
        {"roll_wrap": 0.0},
        {"roll_wrap": 1.0, "drum_wrap": 0.5, "winding_force": -150.0},
        {"roll_wrap": pi, "web_speed": 30.0, "air": wo.Air(roughness=0.12e-6)},
    ],
)
def test_the_trade_rule_and_its_corrections_add_up_to_the_result(changes):
    # Conservation: NIT = mu N + F, less what stick and air take, plus the wrap
    result = wo.solve(newsprint_nip(**changes), nodes=NODES)
    rule, *corrections = nip_trade_rule(result).rows
    problem, nip = result.problem, result.in_nip
    assert rule.value == 0.19 * problem.nip_load + problem.winding_force
    added = sum(row.value for row in corrections)
    assert rule.value + added == pytest.approx(result.nip_induced_tension)
    # the tractions on the roll, integrated: winding force and tension agree to the solver's 1e-8
    Q = np.trapezoid(result.roll_traction[nip], result.x[nip])
    mu = result.air.roll_friction if result.air else 0.19
    assert corrections[0].value == pytest.approx(Q - mu * problem.nip_load, rel=1e-5)
    assert any("air" in row.meaning for row in corrections) == bool(result.air)
    assert any("wrap" in row.meaning for row in corrections) == (problem.roll_wrap > 0)


def test_the_reason_is_the_share_of_the_load_that_does_not_slip_forward():
    # Conservation: the shares add up; full slip at a low friction and F well below zero
    stuck = wo.solve(newsprint_nip(), nodes=NODES)
    text = nip_trade_rule(stuck).text
    shares = [float(share) for share in re.findall(r"([0-9.]+) %", text)]
    assert sum(shares[:3]) == pytest.approx(100, abs=0.16)  # each rounded to 0.1
    assert shares[3] == pytest.approx(
        100 * stuck.nip_induced_tension / (0.19 * stuck.problem.nip_load), abs=0.06
    )
    slips = newsprint_nip(nip_load=100.0, winding_force=-19.0, web_tension=19.0, roll_friction=0.02)
    section = nip_trade_rule(wo.solve(slips, nodes=NODES))
    assert "slips forward on the roll in the whole nip, as the rule assumes" in section.text
    surface = section.rows[1]  # T_in + F = 0: the rule of surface winding
    assert (surface.symbol, surface.value) == ("WOT", pytest.approx(2.0))


def test_the_trade_rule_of_a_winding_is_averaged_over_the_web():
    # Closed form: constant loads; the law "friction" is the rule itself
    problem = wo.WindingProblem.example().replace(radius=0.12, torque_split=0.5)
    by_rule = wo.solve(problem.replace(tension_law="friction"), rtol=0.01)
    (row,) = winding_trade_rule(by_rule).rows
    assert row.value == pytest.approx(by_rule.mean_nip_induced_tension)
    assert "that of this rule" in str(by_rule)
    fixed = problem.replace(torque_split=None, tension_law="fixed", nip_induced_tension=100.0)
    section = winding_trade_rule(wo.solve(fixed, rtol=0.01))
    assert section.rows[0].value == pytest.approx(0.19 * 2000)
    assert "prescribed" in section.text


# ---- what every report ends with -----------------------------------------------------------------


def test_the_certificate_names_its_largest_residual(examples):
    for result in examples:
        worst, count = result.residuals.worst, len(dict(result.residuals.items()))
        noun = "conditions" if isinstance(result, OF_ROLLS) else "contact conditions"
        assert str(result).splitlines()[-1] == (
            f"Certificate: all {count} {noun} are satisfied; largest residual "
            f"{result.residual:.1e} ({worst.replace('_', ' ')})"
        )


@pytest.mark.parametrize(
    ("laws", "said", "tone"),
    [
        (
            {"stick": 1e-12},
            "its one condition is satisfied; largest residual 1.0e-12 (stick)",
            "good",
        ),
        (
            {"stick": 2e-8, "a_b": 0},
            "1 of 2 contact conditions is NOT satisfied: stick 2.0e-08",
            "bad",
        ),
        (
            {"stick": 0.5, "a_b": math.nan, "c": 1e-9},
            "2 of 3 contact conditions are NOT satisfied: stick 5.0e-01, a b not known (nan)",
            "bad",
        ),
        ({}, "none; no contact condition was evaluated", "bad"),
    ],
)
def test_a_broken_law_is_never_hidden(laws, said, tone):
    line = certificate_line(wo.Residuals(**laws))
    assert (line.text, line.tone) == (f"Certificate: {said}", tone)


def test_the_sensitivities_of_rollers_are_printed_too():
    """Their fields are not those of a nip."""
    rollers = coarse_solution(wo.RollerProblem.example(), NODES)
    names = ("load", "upper.radius")
    table = lines(str(rollers.sensitivity(*names, outputs=["peak_pressure"])))
    # p0 varies as sqrt(P/R), and 1/R = 1/R1 + 1/R2 with equal radii
    assert "load 89000 N/m +0.5000" in table
    assert "upper.radius 250 mm -0.2500" in table


def test_the_derivatives_of_a_roll_are_printed_in_the_chosen_units():
    """Its fields are those of neither nips nor rollers; changes of temperature are in degF."""
    roll = wo.RollProblem.example().replace(radial_expansion=1e-4, temperature_change=-20.0)
    found = wo.derivatives(wo.solve(roll, rtol=0.1), "temperature_change", "radial_expansion")
    assert "temperature_change -20 K " in " ".join(str(found).split())
    with units_of(["mill"]):
        assert "temperature_change -36 degF " in " ".join(str(found).split())
        html = found._repr_html_()
    assert ">-36 °F<" in html
    assert ">5.5556e-05 1/°F<" in html
    assert "<i>&sigma;</i><sub>min</sub>" in html


# ---- on a terminal -------------------------------------------------------------------------------


def test_zones_are_drawn_in_proportion_and_short_ones_stay_in_sight(nip):
    x = np.linspace(-1.0, 1.0, 101)
    zones = np.zeros(101, dtype=np.int8)
    zones[0] = -1  # half a cell: 1/200 of the nip
    zones[51:] = 1
    runs = zone_line(x, zones, 60)
    assert [zone for zone, _ in runs] == [-1, 0, 1]
    assert sum(length for _, length in runs) == 60
    assert runs[0][1] == 1
    assert abs(runs[2][1] - 30) <= 1
    (roll,) = [line for line in str(nip).splitlines() if line.startswith(" roll  ")]
    assert roll.split()[1].count("▶") == pytest.approx(60 * nip.trailing_roll, abs=2)


@pytest.mark.parametrize("kind", [wo.RollProblem, wo.WindingProblem, wo.RollerProblem])
def test_every_input_of_a_report_has_a_meaning(kind: Any):
    problem = kind.example()
    if kind is wo.RollProblem:
        tension = wo.Taper(start=350.0, taper=0.2)
        problem = problem.replace(core_removed=True, wound_on_tension=tension)
    if kind is wo.WindingProblem:
        problem = problem.replace(radius=0.12, tension_law="friction")
    page = "".join(_inputs([coarse_solution(problem)], ["case"]))
    rows = re.findall(r"<tr><td[^>]*>(.*?)</td><td[^>]*>(.*?)</td>", page)
    assert len(rows) > 5
    assert [name for name, meaning in rows if not meaning] == []
    if kind is wo.RollProblem:
        assert "the core or mandrel is removed after winding" in dict(rows)["core_<wbr>removed"]


def test_long_lists_of_an_input_are_shortened_and_short_ones_may_be_broken():
    """A scanner's profile fits to the page; a line of the printed table has about 25 characters."""
    many = np.linspace(0.0, 2.0, 301)
    thickness = 66e-6 + 1e-6 * np.sin(9 * many)
    roll = wo.RollProblem.example().replace(
        thickness_profile=wo.ThicknessProfile(position=many, thickness=thickness),
        wound_on_tension=wo.Profile(radius=[0.04, 0.1, 0.15], value=[300.0, 280.0, 250.0]),
    )
    page = "".join(_inputs([coarse_solution(roll)], ["case"]))
    text = page.replace("&nbsp;", " ")
    low, high = 1e6 * thickness.min(), 1e6 * thickness.max()
    assert ">301 values, 0 to 2000 mm<" in text
    assert f">301 values, {low:.5g} to {high:.5g} µm<" in text
    assert '<span class="list">40, 100, 150&nbsp;mm</span>' in page
    cells = re.findall(r"<td[^>]*>(?:<span[^>]*>)?([^<]*)", text)
    assert max(map(len, cells)) < 90
    even = value_row(quantities.length("h", "thickness", "um"), (66e-6,) * 9)
    assert even.text == "9 values, 66 um"


def test_the_coefficients_of_a_change_are_reported_with_their_grade():
    grade = wo.grade("newsprint")
    roll = wo.RollProblem(
        grade=grade, core=wo.Core(radius=0.05, stiffness=1e9), radius=0.2, moisture_change=-0.02,
        radial_swelling=0.3, wound_on_tension=300.0,
    )  # fmt: skip
    for problem in (roll, roll.replace(core_swelling=0.01)):
        (section,) = changes_sections(problem)
        rows = {row.symbol: row for row in section.rows}
        assert rows["beta_t"].value == grade.tangential_swelling
        assert rows["beta_t"].note == ", of the grade 'newsprint'"
        assert (rows["beta_r"].value, rows["beta_r"].note) == (0.3, "")
        assert ("beta_c" in rows) == bool(problem.core_swelling)
    assert not list(changes_sections(roll.replace(moisture_change=0.0)))


def test_inputs_leave_out_zeros_without_effect_only():
    problem = wo.RollProblem.example().replace(
        temperature_change=5.0, radial_expansion=1e-4, core_removed=True, core_shrinkage=1e-3
    )
    omitted = {place.path for place in quantities.walk(problem) if _is_omitted(problem, place)}
    assert "core_expansion" in omitted
    assert not {"core_shrinkage", "tangential_expansion"} & omitted
    nip = wo.NipProblem.example()
    (further,) = (place for place in quantities.walk(nip) if place.path == "next_nips")
    assert _is_omitted(nip, further)


def test_units_are_typeset_alike_in_figures_and_pages():
    """The stress at the edge of a zone; the page had a power of 1/2, the figure a root."""
    quantity = wo.Quantity("K", "Pa/m**0.5", "stress intensity")
    assert unit_of(quantity) == unit_html(quantity.display) == "Pa/√m"


def test_powers_and_products_of_units_are_typeset_in_pages():
    """The centrifugal force has a symbol with a square; defaults have units with powers."""
    winding = wo.WindingProblem.example().replace(
        tension_law="friction", width=2.0, density=680.0, web_speed=20.0,
        inertia=wo.Inertia(core=3.0),
    )  # fmt: skip
    page = report_file([wo.solve(winding)])
    assert "<i>m</i> <i>V</i><sup>2</sup>" in page
    for text in ("inertia.drum = 0 kg·m²", "acceleration = 0 m/s²"):
        assert text in page
    texts = re.sub(r"<(svg|style).*?</\1>", "", page, flags=re.DOTALL)
    assert re.findall(r"\w(?:</?\w+>)*\^\d|[a-z]\*[a-z]", texts) == []
