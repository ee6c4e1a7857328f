"""Forms of inputs: units of mills, totals, stresses, diameters, basis weights, and outputs."""

from __future__ import annotations

import pickle

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import woundon as wo
from woundon.io.case_files import apply_settings, make_problem, to_toml
from woundon.problems.inputs import FloatWithUnit

NIP = wo.NipProblem.example()
WINDING = wo.WindingProblem.example()
ROLL = wo.RollProblem.example()
PLI = 4.4482216152605 / 0.0254

forces = st.floats(1.0, 1e5)
widths = st.floats(0.1, 12.0)


def test_a_text_with_a_unit_is_given_or_replaces_a_value():
    assert NIP.replace(nip_load="20 pli").nip_load == pytest.approx(20 * PLI, rel=1e-15)
    fields = {name: getattr(NIP, name) for name in type(NIP).model_fields}
    assert wo.NipProblem(**fields | {"nip_load": "20 pli"}) == NIP.replace(nip_load="20 pli")


# ---- totals -------------------------------------------------------------------------------------


@given(forces, widths)
def test_a_total_over_the_width_is_the_load_per_width(force, width):
    total = NIP.replace(width=width, nip_load=f"{force!r} N", web_tension=f"{force!r} N")
    per_width = NIP.replace(width=width, nip_load=force / width, web_tension=force / width)
    assert total == per_width
    assert total.width == width


@given(forces, widths)
def test_totals_in_schedules_and_limits(force, width):
    text, each = f"{force!r} N", force / width
    case = {"width": width, "web_tension": {"start": text, "taper": 0.3},
            "limits": {"web_strength": text}}  # fmt: skip
    assert WINDING.replace(**case).web_tension == wo.Taper(start=each, taper=0.3)
    assert WINDING.replace(**case).limits.web_strength == each
    made = WINDING.replace(width=width, web_tension=wo.Taper(start=text))
    assert made.web_tension == wo.Taper(start=each)
    assert type(made.web_tension.start) is float
    assert WINDING.replace(width=width, **{"web_tension.start": text}).web_tension.start == each


# ---- stresses, basis weights, diameters ---------------------------------------------------------


@given(st.floats(1e5, 5e7), st.floats(10e-6, 500e-6))
def test_a_web_tension_as_a_stress(stress, thickness):
    changes = {"web_tension": f"{stress!r} Pa", "web.thickness": thickness}
    assert NIP.replace(**changes).web_tension == stress * thickness
    assert WINDING.replace(**changes).web_tension == stress * thickness
    roll = ROLL.replace(wound_on_tension=f"{stress!r} Pa", web_thickness=60e-6)
    assert roll.wound_on_tension == stress * 60e-6


def test_values_that_are_changed_together_convert_each_other():
    changes = {"web_tension.start": "10 MPa", "web.thickness": "45 gsm", "density": "900 kg/m^3"}
    for ordered in (changes, dict(reversed(changes.items()))):
        variant = WINDING.replace(**ordered)
        assert variant.web.thickness == 0.045 / 900
        assert variant.web_tension.start == 10e6 * variant.web.thickness


@given(st.floats(0.01, 0.5), st.floats(300, 1500))
def test_basis_weight_is_density_times_thickness(weight, density):
    text = f"{weight!r} kg/m^2"
    web = wo.Web(thickness=text, density=density, material="newsprint")
    assert web.thickness == weight / density
    nested = {"thickness": text, "material": "newsprint"}
    assert WINDING.replace(density=density, web=nested).web.thickness == web.thickness
    assert WINDING.replace(density="45 gsm").density == 0.045 / 66e-6
    assert ROLL.replace(web_thickness="45 gsm", density="680 kg/m^3").web_thickness == 0.045 / 680


@given(st.floats(1e-3, 1.0))
def test_a_diameter_is_twice_the_radius(radius):
    assert wo.Rigid(diameter=2 * radius) == wo.Rigid(radius=radius)
    assert wo.Rigid(diameter=f"{2 * radius!r} m") == wo.Rigid(radius=radius)
    assert NIP.replace(**{"drum.diameter": 2 * radius}).drum == wo.Rigid(radius=radius)


# ---- hostile texts ------------------------------------------------------------------------------


def faulty_fields(make):
    try:
        make()
    except wo.InvalidProblem as report:
        return {field for field, _ in report.faults}
    return set()


@settings(max_examples=40)
@given(st.text(max_size=80))
def test_any_text_is_a_load_or_is_rejected_by_name(text):
    fields = faulty_fields(lambda: NIP.replace(nip_load=text))
    assert fields <= {"nip_load", "winding_force"}


@given(st.text(alphabet="0123456789.,' _-+eE/*^kNMPampli\"", max_size=30))
def test_texts_that_look_like_values(text):
    for make in (wo.Taper, lambda start: WINDING.replace(web_tension={"start": start})):
        fields = faulty_fields(lambda make=make: make(start=text))
        assert all("start" in field for field in fields)


# ---- schedules that are not yet part of a problem -----------------------------------------------


def test_a_value_keeps_its_unit_until_it_has_a_problem():
    taper = wo.Taper(start="10 MPa", taper="30 %")
    assert taper.start == 10e6
    assert isinstance(taper.start, FloatWithUnit)
    again = pickle.loads(pickle.dumps(taper.replace(taper=0.2)))
    assert WINDING.replace(web_tension=again).web_tension.start == 10e6 * 66e-6
    with pytest.raises(wo.InvalidProblem, match=r"web_tension\.start: '20 %' has the wrong"):
        WINDING.replace(web_tension=wo.Taper(start="20 %"))
    with pytest.raises(wo.InvalidProblem, match=r"torque_split\.start: .* has the wrong dimension"):
        WINDING.replace(torque_split=wo.Taper(start="200 N/m"))
    profile = wo.Profile(radius=[0.05, 0.6], value=["2 pli", "1 pli"])
    assert WINDING.replace(web_tension=profile).web_tension.value == pytest.approx((2 * PLI, PLI))


# ---- case files, settings, sweeps ---------------------------------------------------------------


def test_a_case_file_with_totals_and_diameters():
    case = {
        "schema": 1, "width": "2.5 m", "nip_load": "9 kN", "web_tension": "10 MPa",
        "roll_friction": 0.2, "drum_friction": 0.2,
        "web": {"thickness": "2.6 mil", "material": "newsprint"},
        "roll": {"diameter": "40 in", "core_diameter": "4 in", "material": "newsprint"},
        "drum": {"kind": "rigid", "diameter": "20 in"},
    }  # fmt: skip
    problem = make_problem(case, "nip")
    assert problem.nip_load == 3600.0
    assert problem.web_tension == pytest.approx(10e6 * 66.04e-6)
    assert (problem.roll.radius, problem.drum.radius) == pytest.approx((0.508, 0.254))
    assert "width" in to_toml(problem)
    changed = apply_settings(case, ["roll.radius=0.4", "drum.diameter=10 in", "nip_load=5 kN"])
    assert make_problem(changed, "nip").roll.radius == 0.4
    assert make_problem(changed, "nip").drum.radius == pytest.approx(0.127)
    assert make_problem(changed, "nip").nip_load == 2000.0


# ---- inputs without effect ----------------------------------------------------------------------


def test_a_speed_that_nothing_depends_on_is_reported():
    fast = NIP.replace(web_speed="3000 ft/min")
    assert fast.web_speed == 15.24
    assert fast.rolling_speed is None
    with pytest.warns(wo.InputWarning, match="web_speed = 15.24 m/s is not used"):
        result = wo.solve(fast, nodes=17)
    assert "web_speed = 15.24 m/s is not used" in str(result)
    assert result.nip_induced_tension == wo.solve(NIP, nodes=17).nip_induced_tension
    assert not WINDING.replace(web_speed=10.0).input_warnings  # the centrifugal force
    assert WINDING.replace(web_speed=10.0, density=None).input_warnings
    still = WINDING.replace(web_speed=10.0, density=None)
    assert still.input_warnings
    assert "web_speed" in still.unused
    assert still.wound_roll(300.0).input_warnings == ()
    roll = wo.RollProblem.example().replace(web_speed=10.0, density=None)
    assert any("web_speed = 10 m/s is not used" in text for text in roll.input_warnings)
    assert not NIP.input_warnings
    assert not wo.NipProblem.example().input_warnings


def test_a_web_that_its_centrifugal_force_lifts_off_the_drum_wrap_is_rejected_by_its_tension():
    # m V^2 = 700 * 66e-6 * 100^2 = 462 N/m; the web tension falls to 245 N/m
    fast = {"web_speed": 100.0, "density": 700.0, "drum_wrap": 1.0}
    with pytest.raises(wo.InvalidProblem, match=r"web_tension: 245 at the radius 0.6 .* > 462"):
        WINDING.replace(**fast)
    assert WINDING.replace(**fast, web_tension=470.0).drum_wrap == 1.0
    # a speed out of reach is no fault of a wound-on tension, which a winding does not have
    heavy = WINDING.replace(radius=2.0, density=3e4, web_speed=200.0, **{"web.thickness": 1e-3})
    assert heavy.centrifugal_tension == pytest.approx(1.2e6)


# ---- outputs in units ---------------------------------------------------------------------------


def test_results_in_chosen_units():
    result = wo.solve(NIP.replace(width=2.0), nodes=17)
    view = result.in_units("pli", "um")
    assert view.nip_induced_tension * PLI == pytest.approx(result.nip_induced_tension)
    assert view["half_width"] == pytest.approx(result.half_width * 1e6)
    assert view.units["half_width"] == "um"
    assert view.tension == pytest.approx(result.tension / PLI)
    assert view.errors["half_width"] == pytest.approx(result.errors["half_width"] * 1e6)
    assert "pli" in str(view)
    frame = view.to_dataframe()
    assert frame["tension"].to_numpy() == pytest.approx(view.tension)
    assert frame.attrs["units"]["tension"] == "pli"
    total = result.in_units("kN")
    assert total.nip_induced_tension == pytest.approx(result.nip_induced_tension * 2.0 / 1e3)
    assert result.in_units("mill", half_width="mm").units["peak_pressure"] == "psi"
    assert result.in_units("SI").peak_pressure == result.peak_pressure
