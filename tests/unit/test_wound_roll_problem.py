"""Wound rolls: what is refused, what a core is, and what a schedule says."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import woundon as wo
from woundon.problems.schedules import Curve
from woundon.report.result_panels import panels_of
from woundon.roll import solve as roll_solve

ROLL = wo.RollProblem.example()


def test_a_tube_shrinks_as_lame_says():
    steel = wo.Isotropic(youngs_modulus=206e9, poissons_ratio=0.3)
    solid = wo.Core(radius=0.05, inner_radius=0.0, material=steel).effective_stiffness
    # plane strain: u/r = -(1 + nu)(1 - 2 nu) P/E of a full cylinder
    assert solid == pytest.approx(206e9 / (1.3 * 0.4))
    thin = wo.Core(radius=0.05, inner_radius=0.0499, material=steel).effective_stiffness
    # a thin ring: E t/((1 - nu^2) r), to the ring's thickness
    assert thin == pytest.approx(206e9 * 0.002 / (1 - 0.09), rel=4e-3)


@pytest.mark.parametrize(
    "schedule",
    [
        wo.Taper(start=300.0, taper=0.4),
        wo.Taper(start=300.0, taper=0.4, law="hyperbolic"),
        wo.Taper(start=300.0, law="constant_torque"),
        wo.Taper(start=300.0, law="power", exponent=0.6),
        wo.Steps(value=[583.3333333333334 / 2, 250.0], depth=[0.06], ramp=0.05),
        wo.Profile(radius=[0.04, 0.1, 0.2], value=[300.0, 250.0, 100.0]),
        300.0,
    ],
)
def test_a_curve_s_slope_is_that_of_its_values(schedule: object):
    curve = Curve(schedule, 0.05, 0.2, scale=2.0)
    r = np.linspace(0.051, 0.199, 37)
    differences = (curve.at(r + 1e-7) - curve.at(r - 1e-7)) / 2e-7
    np.testing.assert_allclose(curve.slope(r), differences, rtol=1e-6, atol=1e-4)
    assert curve.at(np.array([0.05]))[0] == pytest.approx(2 * (
        schedule if isinstance(schedule, float) else getattr(schedule, "start", 291.6666666666667)
    ))  # fmt: skip


def test_a_profile_s_kinks_have_two_slopes():
    curve = Curve(wo.Profile(radius=[0.04, 0.1, 0.2], value=[300.0, 240.0, 200.0]), 0.05, 0.2)
    kink = np.array([0.1])
    assert curve.kinks.tolist() == [0.1]
    assert curve.slope(kink, -1)[0] == pytest.approx(-1000)
    assert curve.slope(kink, 1)[0] == pytest.approx(-400)
    assert curve.bends[0] == pytest.approx(0.1 * 600 / 240)


def test_a_stack_that_ends_is_reported():
    """A measured law that ends at 100 kPa cannot carry a roll of 300 kPa."""
    test = wo.StackTest(pressure=[0, 2e4, 5e4, 1e5], strain=[0, 0.03, 0.045, 0.058])
    with pytest.raises(wo.NotConverged) as fault:
        wo.solve(ROLL.replace(stack=ROLL.stack.replace(radial=test)))
    assert "beyond the range of the stack law" in str(fault.value)


@pytest.fixture(scope="module")
def result() -> wo.RollResult:
    return wo.solve(ROLL.replace(wound_on_tension=wo.Taper(start=400.0, taper=0.25)), rtol=1e-2)


@pytest.mark.parametrize("ending", ["nc", "json"])
def test_result_file_round_trip(result, tmp_path, ending: str):
    path = tmp_path / f"roll.{ending}"
    result.save(path)
    again = wo.load_result(path)
    assert again == result
    assert again.certified().largest < 1e-8
    assert again.at(0.1).radius[-1] == 0.1  # the build-up is in the file


def test_changes_that_open_nearly_the_whole_roll_are_warned_of():
    """Not by an estimated error of 1e297 of the pressure: a few layers stay on the core."""
    with pytest.warns(wo.ValidityWarning, match=r"separated from 44\.51 to 150 mm radius"):
        result = wo.solve(ROLL.replace(temperature_change=1000.0, radial_expansion=-1e-2))
    assert result.residuals.largest <= 1e-8


def test_the_margins_of_a_released_roll_are_those_on_its_core_and_of_the_finished_roll():
    limits = wo.Limits(layer_friction=0.3)
    wound, released = (
        wo.margins(wo.solve(ROLL.replace(core_removed=off), rtol=1e-2), limits)
        for off in (False, True)
    )
    for name in ("slip", "core"):  # of the same roll on other nodes
        assert released[name].value == pytest.approx(wound[name].value, rel=1e-3)
    assert released["compression"].value > 5 * wound["compression"].value
    # of 83 layers, whose only evaluated stage is the last one
    short = ROLL.replace(radius=0.05)
    on, off = (
        wo.margins(wo.solve(short.replace(core_removed=off), rtol=1e-2), limits)["core"].value
        for off in (False, True)
    )
    assert off == pytest.approx(on, rel=1e-3)


def test_a_core_is_there_or_removed():
    assert ROLL.replace(core_removed="true").core_removed is True
    assert ROLL.replace(core_removed="TRUE").core_removed is True  # of a spreadsheet
    assert ROLL.replace(core_removed="False").core_removed is False


HEATED: dict[str, Any] = {"temperature_change": 5, "radial_expansion": 1e-5}


@pytest.mark.parametrize(
    ("changes", "unused"),
    [
        ({"core_removed": True, "core_shrinkage": 1e-3}, "core_shrinkage"),
        (HEATED | {"core_removed": True, "core_expansion": 1e-5}, "core_expansion"),
        ({"moisture_change": -0.02}, "moisture_change"),
        ({"temperature_change": {"radius": [0.04, 0.2], "value": [0, 5]}}, "temperature_change"),
        ({"web_speed": 20.0, "density": None}, "web_speed"),
    ],
)
def test_changes_without_effect_are_warned_of(changes: dict[str, Any], unused: str):
    problem = ROLL.replace(**changes)
    assert [text.split()[0] for text in problem.input_warnings] == [unused]
    assert " is not used" in problem.input_warnings[0]
    used = {
        "core_removed": False, "density": 700.0, "radial_swelling": 0.5, "radial_expansion": 1e-5
    }  # fmt: skip
    assert not problem.replace(**used).input_warnings


def test_the_error_of_a_core_pressure_that_is_exactly_zero_is_zero():
    """A core that touches the roll nearly, by less than the error of the bore, has an error."""
    winding = wo.WindingProblem.example().replace(radius=0.12, tension_law="friction")
    for problem in (ROLL, winding):
        for away in ({"core_removed": True}, {"core_shrinkage": 0.05}):
            result = wo.solve(problem.replace(**away))
            assert (result.core_pressure, result.errors["core_pressure"]) == (0.0, 0.0)
    held = wo.solve(ROLL.replace(core_shrinkage=1e-4))
    assert held.errors["core_pressure"] > 0
    # the bore is released at the shrinkage of its displacement and of the core, which the first
    # layer compressed
    released, core = wo.solve(ROLL.replace(core_removed=True)), ROLL.core
    laid = ROLL.wound_on_tension / core.radius / core.effective_stiffness
    just = (laid - released.bore_displacement / core.radius) * (1 + 1e-7)
    nearly = wo.solve(ROLL.replace(core_shrinkage=just))
    assert 0 < nearly.core_gap < nearly.errors["bore_displacement"]
    assert nearly.errors["core_pressure"] > 0


@pytest.mark.parametrize(("share", "is_error"), [(0.99, False), (1.01, True)])
def test_a_gap_within_the_error_of_the_bore_leaves_the_core_pressure_uncertain(share, is_error):
    """The displacement by an error of the hoop stress is r_c/E_t times it."""
    result = wo.solve(ROLL.replace(core_shrinkage=0.02), rtol=0.1)
    assert result.core_gap > 0
    points = roll_solve._error_points(result)
    hoop = share * result.core_gap * ROLL.stack.tangential / ROLL.core.radius
    errors = roll_solve._largest_errors(
        result, np.full(points.size, 7.0), np.full(points.size, hoop)
    )
    assert errors["core_pressure"] == (7.0 if is_error else 0.0)
    removed = wo.solve(ROLL.replace(core_removed=True), rtol=0.1)
    shape = roll_solve._error_points(removed).size
    errors = roll_solve._largest_errors(removed, np.full(shape, 7.0), np.full(shape, 1e12))
    assert errors["core_pressure"] == 0.0


def test_a_change_without_effect_is_no_assumption():
    text = "Temperature, moisture and shrinkage change the finished roll"
    for kind in (ROLL, wo.WindingProblem.example()):
        for changes, expected in (
            ({"temperature_change": 10.0}, False),
            ({"core_removed": True, "core_shrinkage": 0.01}, False),
            ({"temperature_change": 10.0, "radial_expansion": 1e-5}, True),
            ({"core_shrinkage": 0.01}, True),
        ):
            assumptions = " ".join(kind.replace(**changes).assumptions)
            assert (text in assumptions) == expected, changes


def test_a_thin_ring_of_few_layers_collapses():
    """Two ways to the same number: p = E d^3/(4 R^3) of the compressed ring, by hand.

    Thick layers with a tension that rises outwards press a ring of few layers into the bore.
    """
    stack = wo.Stack(radial=2e9, tangential=2e9, poissons_ratio=0.0, shear=1e9)
    coil = wo.RollProblem(
        core=wo.Core(radius=0.5, stiffness=2e9), radius=0.504, web_thickness=2e-4, stack=stack,
        wound_on_tension=wo.Profile(radius=[0.5, 0.502, 0.504], value=[400.0, 400.0, 4000.0]),
        core_removed=True,
    )  # fmt: skip
    with pytest.warns(wo.ValidityWarning, match="the inner layers collapse into the bore"):
        result = wo.solve(coil)
    r = np.linspace(0.5, 0.504, 4001)
    stresses = result.at_radius(r)
    end = int(np.argmax(stresses["hoop_stress"] > 0))
    depth, P = r[end] - 0.5, stresses["pressure"][end]
    # balance of half the ring, to a step of the radii
    hoop_force = np.trapezoid(stresses["hoop_stress"][: end + 1], r[: end + 1])
    assert hoop_force == pytest.approx(-r[end] * P, rel=1e-3)
    R = (r[end] + 0.5) / 2
    # to a step of the radii
    assert result.bonded_collapse_load == pytest.approx(P / (2e9 * depth**3 / 4 / R**3), rel=5e-3)
    # N = r P of sliding layers: the innermost, d -> h, has nearly the largest stress
    single = -result.bore_hoop_stress * 4 * 0.5**2 / (2e9 * 2e-4**2)
    assert result.sliding_collapse_load == pytest.approx(single, rel=0.1)
    on_core = wo.solve(coil.replace(core_removed=False))
    assert np.isnan([on_core.bonded_collapse_load, on_core.sliding_collapse_load]).all()


def test_a_stack_too_soft_to_wind_on_is_reported_so():
    with pytest.raises(wo.NotConverged, match="stack at low pressure, or the core, is too soft"):
        wo.solve(ROLL.replace(**{"stack.radial.K1": 1e-6}))


def test_bounds_that_are_computed_from_inputs_allow_for_rounding():
    """The stated minimum is accepted: of 200 rolls of ten layers the rounding rejects some."""
    example = wo.RollProblem.example()
    for k in range(200):
        core, h = 0.03 + 1.7e-5 * k, 1e-5 * (1 + 0.0371 * k)
        roll = example.replace(radius=core + 10 * h, web_thickness=h, **{"core.radius": core})
        assert roll.radius == core + 10 * h
        R = core
        wo.Cylinder(radius=R, core_radius=R - R / 2000, material="steel")
        wo.Layered(radius=R, layers=[{"thickness": R / 6000, "material": "steel"}] * 3)
    with pytest.raises(wo.InvalidProblem, match=r"web_thickness.* 10 to 1e\+06 layers"):
        example.replace(radius=0.0445 + 9.999 * 66e-6)


def test_a_stage_of_exactly_ten_layers():
    result = wo.solve(wo.RollProblem.example(), rtol=1e-2)
    core, h = result.problem.core.radius, result.problem.web_thickness
    stage = result.at((core + 10 * h) * (1 - 1e-15))
    assert stage.layer_count == pytest.approx(10, rel=1e-9)


# ---- validity limits ----------------------------------------------------------------------------


def warned(problem: wo.RollProblem | wo.WindingProblem) -> tuple[str, ...]:
    """Return the warnings of the solved problem, which are also issued as Python's."""
    with pytest.warns(wo.ValidityWarning) as issued:
        result = wo.solve(problem)
    assert [str(one.message) for one in issued] == list(result.warnings)
    assert all(f"warning: {text[:40]}" in str(result) for text in result.warnings)
    return result.warnings


def test_an_ordinary_roll_earns_no_warning():
    assert wo.solve(wo.RollProblem.example()).warnings == ()


def test_a_film_wound_at_a_strain_of_a_third():
    stack = wo.Stack(radial=wo.Pfeiffer(K1=2e3, K2=200.0), tangential=4.8e9, poissons_ratio=0.01,
                     shear=1e7)  # fmt: skip
    film = wo.RollProblem(
        core=wo.Core(radius=0.05, stiffness=1e9), radius=0.2, stack=stack, web_thickness=50e-6,
        wound_on_tension=0.33 * 4.8e9 * 50e-6,
    )  # fmt: skip
    texts = warned(film)
    assert any("wound at a strain of 33%" in text and "(limit 2%)" in text for text in texts)
    # lengths and radii have the same unit as in the report
    assert any("layers is -" in text and "at the radius 50 mm" in text for text in texts), texts
    # E_r = K2 (K1 + P) above E_t: Pfeiffer's law does not hold there
    assert any("% of the modulus along the web (limit 100%)" in text for text in texts)


def test_layers_compressed_beyond_small_strains():
    # K1 = 10 kPa and K2 = 10 at some 90 kPa: F = ln(10)/10 = 23 %
    soft = wo.RollProblem.example().replace(**{"stack.radial.K2": 10.0})
    result = wo.solve(soft)
    F = np.log1p(result.peak_pressure / 10e3) / 10
    assert any(f"compressed by {100 * F:.3g}% at" in text for text in result.warnings)


def test_a_strip_that_is_bent_on_its_mandrel():
    """Bending strain h/2R of 12.7 mm on 254 mm: 2.5 %, E h/2R = 5 GPa at 200 GPa."""
    steel = wo.Stack(radial=2e9, tangential=200e9, poissons_ratio=0.01, shear=1e9)
    (text,) = warned(wo.RollProblem(
        core=wo.Core(radius=0.254, stiffness=200e9), radius=0.75, stack=steel,
        web_thickness=0.0127, wound_on_tension=30e6 * 0.0127,
    ))  # fmt: skip
    assert text.startswith("the web is bent to a strain of 2.5% on the core of 254 mm radius")


def test_the_bending_strain_is_compared_with_a_known_yield_strain():
    winding = wo.WindingProblem.example().replace(
        radius=0.06, tension_law="fixed", nip_induced_tension=50.0, web_tension=300.0
    )
    bending, wound = 66e-6 / 2 / 0.05, 350.0 / 66e-6 / 3.38e9
    face = bending + wound
    assert wo.solve(winding.replace(limits={"yield_strain": 1.01 * face})).warnings == ()
    (text,) = warned(winding.replace(limits={"yield_strain": 0.99 * face}))
    strains = f"{100 * wound:.3g}% by the tension and {100 * bending:.3g}% by bending"
    assert f"its strain of {strains} exceeds the yield strain of {99 * face:.3g}%" in text
    margins = wo.margins(wo.solve(wo.RollProblem.example()), wo.Limits(yield_strain=1e-4))
    assert margins["bending"].ok is False


def test_poissons_ratio_must_leave_the_energy_definite():
    """nu^2 < E_t/E_r at every pressure that occurs: of a constant law when it is defined."""
    E_t = 3.38e9
    with pytest.raises(wo.InvalidProblem, match=r"^poissons_ratio: 9 is .* < .* = 6.128, with E_r"):
        wo.Stack(radial=90e6, tangential=E_t, poissons_ratio=9.0, shear=1e7)
    roll = wo.RollProblem.example().replace(
        wound_on_tension=1500.0, **{"stack.poissons_ratio": 4.0}
    )
    with pytest.warns(wo.InputWarning, match=r"stack.poissons_ratio = 4: .* not that in the plane"):
        peak = wo.solve(roll).peak_pressure
    largest = np.sqrt(E_t / (40 * (10e3 + peak)))  # with the peak pressure for 4, 4 % above
    with pytest.raises(wo.InvalidProblem, match=r"^stack.poissons_ratio: 9 is") as fault:
        wo.solve(roll.replace(**{"stack.poissons_ratio": 9.0}))
    permitted = float(str(fault.value).split("(1/2) = ")[1].split(",")[0])
    assert permitted == pytest.approx(largest, rel=0.1)


def test_report_and_panels_of_a_roll_without_its_core():
    roll = wo.solve(wo.RollProblem.example().replace(core_removed=True), rtol=1e-2)
    text = str(roll)
    assert "ressure on the core" not in text  # there is none: zero would mislead
    assert text.splitlines()[0].startswith("Largest pressure ")
    assert "hoop stress at the bore -" in text.splitlines()[0]
    assert "Other theories" not in text  # that of the roll as wound


def test_the_axis_shows_the_compression_as_wound():
    """A roll that shrinks through its stack loses most of its compression."""
    shrunk = wo.RollProblem.example().replace(temperature_change=-40.0, radial_expansion=8e-4)
    roll = wo.solve(shrunk, rtol=1e-2)
    panel = panels_of(roll)["hoop_stress"].make(roll)
    before = next(curve for curve in panel.curves if curve.name == "hoop_stress_as_wound")
    assert before.y.min() < 2 * roll.least_hoop_stress
    assert panel.y.cut[0] < before.y.min()


@pytest.mark.parametrize("radius", [None, "wide", [0.1, None]])
def test_a_radius_that_is_no_number_is_rejected(radius) -> None:
    roll = wo.solve(wo.RollProblem.example(), rtol=1e-2)
    with pytest.raises(wo.InvalidProblem, match=r"^radius: .* must be >= 0.0445 and <= 0.15"):
        roll.at_radius(radius)
    with pytest.raises(wo.InvalidProblem, match="None is not a number"):
        roll.at_radius(None)
