"""The first lines of reports, assumptions and default values, limits of grades."""

from __future__ import annotations

import re
from typing import Any, get_args

import numpy as np
import pytest
from slow_cases import slow_case

import woundon as wo
from woundon.io.chosen_units import units_of
from woundon.quantities import scalar_outputs, value_of, walk
from woundon.report.answer import answer, answer_lines, defaults_section

NODES = 33


@pytest.fixture(scope="module")
def nip() -> wo.NipResult:
    return wo.solve(wo.NipProblem.example(), nodes=NODES)


@pytest.fixture(scope="module")
def winding() -> wo.WindingResult:
    """A winding of a grade, whose tension does not need nips."""
    return wo.solve(wo.WindingProblem(
        grade="newsprint", core=wo.Core(radius=0.05, stiffness=1e9), drum=wo.Rigid(radius=0.25),
        radius=0.15, web_tension=150.0, nip_load=500.0, tension_law="friction",
    ))  # fmt: skip


def tensions(line: str) -> list[float]:
    return [float(number) for number in re.findall(r"(-?[0-9.]+) N/m", line)]


def test_the_first_line_is_a_sum_of_tensions(nip: wo.NipResult) -> None:
    first = str(nip).splitlines()[0]
    assert first == answer(nip)
    total, web, added = tensions(first)
    assert total == web + added  # the printed digits, exactly
    # printed to three digits of the nip-induced tension; the last digit balances the sum
    assert total == pytest.approx(nip.wound_on_tension, abs=0.5)
    assert added == pytest.approx(nip.nip_induced_tension, abs=1.0)


def test_entrained_air_is_compared_with_the_same_nip_without_it() -> None:
    problem = wo.NipProblem.example().replace(web_speed=30.0, air=wo.Air(roughness=0.12e-6))
    result = wo.solve(problem, nodes=NODES)
    assert result.air is not None
    texts = [line.text for line in answer_lines(result)]
    assert 0 < result.air.friction_share < 1
    assert f"in the nip by {1 - result.air.friction_share:.1%}" in texts[1]
    assert texts[1].endswith("on the roll wrap to 0.")
    dry = wo.solve(problem.without_air(), nodes=NODES)
    before, after = re.findall(r"from ([0-9.]+) to ([0-9.]+)", texts[2])[0]
    assert float(before) == pytest.approx(dry.nip_induced_tension, rel=1e-3)  # four digits
    assert float(after) == pytest.approx(result.nip_induced_tension, rel=1e-3)
    # the page asks on every move of a slider: without the second nip
    assert len(answer_lines(result, full=False)) == 1


# ---- assumptions and defaults -------------------------------------------------------------------


def test_assumptions_follow_the_case(nip: wo.NipResult, winding: wo.WindingResult) -> None:
    assert "The drum is rigid." in nip.assumptions
    assert any("bonded" in text for text in nip.assumptions)
    assert not any("air" in text for text in nip.assumptions)
    soft = nip.problem.replace(drum=wo.HalfPlane(radius=0.1, material="newsprint"))
    assert "The drum is rigid." not in soft.assumptions
    held = nip.problem.replace(roll_wrap=0.0)
    assert len(set(held.assumptions) ^ set(nip.assumptions)) == 2  # where the web is held
    bodies = {body: wo.WindingProblem.example().replace(roll_body=body).assumptions
              for body in ("effective", "direct", "linear")}  # fmt: skip
    assert len(set(bodies.values())) == 3
    for result in (nip, winding, winding.roll):
        for text in result.assumptions:
            assert text in " ".join(str(result).split())


def defaults(problem: wo.Problem) -> list[str]:
    """Return the names of the defaults that a report lists."""
    return [text.split(" = ")[0] for part in defaults_section(problem)
            for text in part.text.split(", ")]  # fmt: skip


NIP, ROLL, WINDING = (
    wo.NipProblem.example(), wo.RollProblem.example(),
    wo.WindingProblem.example().replace(radius=0.12, tension_law="friction"),
)  # fmt: skip
SOFT = wo.Stack(radial=wo.Pfeiffer(K1="10 kPa", K2=40), tangential="3.38 GPa", poissons_ratio=0.01,
                shear="10 MPa")  # fmt: skip
WOUND = wo.WoundRoll(radius=0.1, core_radius=0.0445, stack=SOFT, pressure=2e5)
DEFAULTS_CASES = {
    "nip": NIP,
    "nip of a stack": NIP.replace(**{"web.material": SOFT}),
    "frozen roll": NIP.replace(roll=WOUND.replace(hardening="frozen")),
    "air": NIP.replace(web_speed=20.0, air=wo.Air(roughness=0.12e-6, permeance=1e-9)),
    "roll": ROLL,
    "warm roll": ROLL.replace(temperature_change=10.0, wound_on_tension=wo.Taper(start=350.0)),
    "expanding roll": ROLL.replace(radial_expansion=1e-6),
    "winding": WINDING,
    "torque split": WINDING.replace(torque_split=0.5, web_tension=wo.Taper(start=300.0)),
    "constant torque": WINDING.replace(
        web_tension=wo.Taper(start=300.0, law="constant_torque"), torque_split=0.5),
}  # fmt: skip
OTHER = {  # other permitted values of fields with defaults
    "roll_wrap": 0.0, "drum_wrap": 0.5, "winding_force": -50.0, "roll.hardening": "frozen",
    "tension_law": wo.Profile(radius=[0.05, 0.12], value=[400.0, 400.0]), "roll_body": "linear",
    "air.permeance": 1e-9, "air.full_friction": 0.5, "air.no_friction": 4.0,
    "core_shrinkage": 1e-5, "core_expansion": 1e-6, "tangential_expansion": 1e-6,
    "radial_expansion": 1e-6, "air.viscosity": 2e-5, "air.ambient_pressure": 9e4,
    "limits.torque_share": 0.5, "core_removed": True,
}  # fmt: skip


@pytest.mark.parametrize(
    "name", [slow_case(name) if name == "air" else name for name in DEFAULTS_CASES]
)
def test_the_listed_defaults_are_those_with_an_effect(name: str) -> None:
    """Definition: a default is used if another value of the field changes an output."""
    problem = DEFAULTS_CASES[name]
    options: dict[str, Any] = {"nodes": 17} if isinstance(problem, wo.NipProblem) else {"rtol": 0.1}

    def outputs(case: wo.Problem) -> list[float]:
        result = wo.solve(case, **options)
        values = [value_of(result, output) for output in scalar_outputs(result)
                  if output not in ("iterations", "residual")]  # fmt: skip
        if isinstance(result, wo.RollResult):
            values.append(wo.margins(result)["gauge_band"].value)
        return values

    listed, reference = defaults(problem), outputs(problem)
    for place in walk(problem):
        default = getattr(place.field, "default", None)
        if default is None or place.value != default:
            continue
        words = [word for word in get_args(place.field.annotation) if isinstance(word, str)]
        others = [OTHER.get(place.path, 1e-2)] if place.path in OTHER or not words else words
        has_effect = False
        for other in others:
            try:
                changed = outputs(problem.replace(**{place.path: other}))
            except wo.InvalidProblem:  # winding_force next to torque_split, taper of a constant one
                continue
            has_effect |= not np.allclose(changed, reference, rtol=1e-12, atol=0, equal_nan=True)
        assert (place.path in listed) == has_effect, place.path


def centrifugal(problem: wo.Problem) -> str:
    return "".join(text for text in problem.assumptions if "centrifugal" in text)


def test_the_centrifugal_force_is_stated() -> None:
    # Definition: m V^2 with m = density * thickness, relative to the web tension
    film = wo.grade("pet-12")
    nip = wo.NipProblem(grade="pet-12", roll=film.roll(0.2, 0.08), drum=wo.Rigid(radius=0.1),
                        nip_load=300.0, web_tension=100.0)  # fmt: skip
    assert centrifugal(nip) == ""
    fast = nip.replace(web_speed=30.0)
    force = film.density * film.thickness * 30.0**2
    assert (
        f"At 1800 m/min the centrifugal force of the web takes m V^2 = {force:.3g} N/m of the "
        f"tension, {force:.2g} % "  # of a tension of 100 N/m
    ) in centrifugal(fast)
    assert not any("centrifugal" in text for text in fast.input_warnings)
    with units_of(["mill"]):
        text = f"takes m V^2 = {force / 175.127:.3g} pli"
        assert text in centrifugal(fast)
    unknown = wo.NipProblem.example().replace(web_speed=30.0)
    assert "9 N/m of the tension for each 10 g/m^2 (the density is not known)" in (
        centrifugal(unknown)
    )
    assert any("centrifugal" in text for text in unknown.input_warnings)
    # 680 kg/m^3 of 66 um at 20 m/s: 17.952 N/m; 350 N/m at the core, 245 N/m at the surface
    winding = wo.WindingProblem.example().replace(web_speed=20.0)
    assert "18 N/m of the tension, 5.1 to 7.3 % of the web tension" in centrifugal(winding)


# ---- margins ------------------------------------------------------------------------------------


def test_the_verdict_names_the_smallest_reserve_and_what_to_change(
    winding: wo.WindingResult,
) -> None:
    loose = wo.margins(winding, wo.Limits(blocking_pressure=1e9))
    assert loose.verdict.startswith("The roll holds as far as it is checked; smallest reserve: ")
    assert loose.advice == ""
    tight = wo.margins(winding, wo.Limits(blocking_pressure=1e3, slack_tension=151.0))
    assert tight.verdict.startswith("The roll does not hold: blocking exceeds its limit by ")
    assert tight["blocking"].hint in tight.advice
    assert "slack web" in tight.advice
    assert "No margin" in wo.margins(winding.roll, wo.Limits()).verdict


@pytest.mark.slow
def test_reserves_are_outputs_of_studies(winding: wo.WindingResult) -> None:
    for margin in winding.margins:
        reserve = getattr(winding.margins, margin.name)
        assert reserve == margin.reserve or reserve != reserve
    swept = wo.sweep(winding.problem, {"web_tension": [150.0, 300.0]}, ["margins.blocking"])
    values = swept["margins.blocking"].values
    assert values[0] == winding.margins.blocking > values[1]
    goal = float(values.mean())
    found = wo.find(winding.problem, "web_tension", between=(150.0, 300.0),
                    **{"margins.blocking": goal})  # fmt: skip
    assert found.result.margins.blocking == pytest.approx(goal, rel=1e-2)
