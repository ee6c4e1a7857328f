"""Margins of a wound roll: each criterion against a closed form, each seen to fail."""

from __future__ import annotations

from math import pi
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from coarse_solutions import coarse_solution
from scipy.integrate import quad
from scipy.optimize import brentq

import woundon as wo
from woundon.quantities import in_chosen_units
from woundon.report.panels import SERIES
from woundon.report.winding_panels import reserves
from woundon.roll.theories import constant_moduli
from woundon.winding import margins as module
from woundon.winding.criteria import (
    coil_set,
    collapse_pressure,
    sliding_layers_buckling_stress,
    torque_carried,
    torque_share,
)

NAMES = ("slip", "compression", "blocking", "core", "strength", "slack", "gauge_band", "bending")
MU = 0.19


@pytest.fixture(scope="module")
def problem() -> wo.RollProblem:
    return wo.RollProblem.example()


@pytest.fixture(scope="module")
def roll(problem: wo.RollProblem) -> wo.RollResult:
    return coarse_solution(problem)


def reserve(problem: wo.RollProblem, name: str, **limits: float) -> float:
    """Return the reserve of one margin of a roll wound for it."""
    found = wo.margins(coarse_solution(problem), wo.Limits(**limits))[name].reserve
    assert isinstance(found, float)
    return found


# ---- closed forms -------------------------------------------------------------------------------


def test_the_torque_of_a_start_is_that_of_the_rings_outside() -> None:
    r, s, T, rho, a = 0.07, 0.4, 300.0, 680.0, 1.5
    inertia = quad(lambda x: 2 * pi * x**3 * rho, r, s)[0]  # of rings, per metre of width
    assert torque_carried(np.array(r), s, T, rho, a) == pytest.approx(T * s + inertia * a / s)


def test_the_share_is_that_of_the_friction_all_around() -> None:
    r, P, torque = 0.07, 40e3, 9.0
    carried = quad(lambda angle: MU * P * r * r, 0, 2 * pi)[0]
    assert torque_share(np.array(r), P, MU, np.array(torque)) == pytest.approx(torque / carried)
    assert torque_share(np.array(r), 0.0, MU, np.array(torque)) == np.inf
    assert torque_share(np.array(r), 0.0, MU, np.array(0.0)) == 0  # none is asked of them


def test_a_thin_tube_collapses_as_in_its_source() -> None:
    """The worked example there: 29e6 psi, 0.29, r = 6.75 in, t = 0.375 in collapses at 1357 psi."""
    inch, psi = 0.0254, 6894.757
    steel = wo.Isotropic(youngs_modulus=29e6 * psi, poissons_ratio=0.29)
    tube = {"radius": 6.9375 * inch, "inner_radius": 6.5625 * inch, "material": steel}
    assert collapse_pressure(wo.Core(**tube)) == pytest.approx(1357 * psi, rel=5e-4)  # its digits
    # of a thicker one, and of a core of which only the stiffness is known, nothing is claimed
    assert np.isnan(collapse_pressure(wo.Core(**{**tube, "inner_radius": 6.2 * inch})))
    assert np.isnan(collapse_pressure(wo.Core(radius=0.1, stiffness=1e9)))


@pytest.mark.parametrize("laps", [1, 7, 60])
def test_layers_that_slide_buckle_as_beams_on_springs(laps: int) -> None:
    """The least load over all waves and modes of a chain of beams, by its eigenvalues."""
    E_r, E_t, h = 8e6, 3.4e9, 66e-6
    springs = E_r / h * (2 * np.eye(laps) - np.eye(laps, k=1) - np.eye(laps, k=-1))
    waves = np.geomspace(1.0, 1e5, 4001)
    softest = np.linalg.eigvalsh(springs)[0]
    load = np.min(E_t * h**3 / 12 * waves**2 + softest / waves**2)
    # of the waves' grid, whose minimum is flat
    assert sliding_layers_buckling_stress(E_r, E_t, h, laps * h) == pytest.approx(
        load / h, rel=1e-5
    )


def test_what_friction_must_hold_is_reported(roll: wo.RollResult) -> None:
    """Of newsprint about as much as its compression; a taper without compression has no note."""
    note = wo.margins(roll)["compression"].note
    computed = float(note.partition("about ")[2].partition(" kPa")[0])
    compressed = roll.at_radius(r := np.linspace(0.0445, 0.15, 2001))["hoop_stress"] < 0
    depth = np.ptp(r[compressed])
    E_r = float(np.mean(roll.problem.stack.radial.modulus(
        roll.at_radius(r[compressed])["pressure"])))  # fmt: skip
    by_hand = 2 * pi / np.sqrt(12) * 66e-6 / depth * np.sqrt(E_r * 3.38e9)
    assert 1e3 * computed == pytest.approx(by_hand, rel=0.02)
    falls = np.geomspace(0.0445, 0.15, 40)
    gentle = wo.Profile(radius=falls, value=350.0 * (falls / 0.0445) ** -0.8)
    tapered = wo.solve(roll.problem.replace(wound_on_tension=gentle))
    assert "slid" not in wo.margins(tapered)["compression"].note


def test_a_roll_in_closed_form_slips_where_and_as_it_should() -> None:
    """Constant moduli: P is known in closed form, and so is the share, over all radii."""
    stack = wo.Stack(radial=40e6, tangential=4e9, poissons_ratio=0.01, shear=10e6)
    core, h, T = wo.Core(radius=0.05, stiffness=2e8), 100e-6, 200.0
    problem = wo.RollProblem(
        core=core, radius=0.2, stack=stack, web_thickness=h, wound_on_tension=T
    )
    found = wo.margins(wo.solve(problem, rtol=1e-5), wo.Limits(layer_friction=MU))["slip"]
    r = np.linspace(0.05, 0.2 - module.TAIL_LAYERS * h, 2001)
    P = constant_moduli(problem, r).pressure
    share = T * 0.2 / (2 * pi * r**2 * MU * P)
    assert found.value == pytest.approx(share.max(), rel=1e-4)  # ten times the solver's
    assert found.radius == pytest.approx(r[np.argmax(share)], abs=0.15 / module.PLACES)


# ---- over the build-up --------------------------------------------------------------------------


def test_what_is_worst_before_the_roll_is_finished_is_found(problem: wo.RollProblem) -> None:
    """A tension that ends low asks most of the laps when the roll is half wound."""
    falls = wo.Profile(radius=[0.0445, 0.09, 0.1, 0.15], value=[400.0, 400.0, 200.0, 200.0])
    roll = wo.solve(problem.replace(wound_on_tension=falls))
    found = wo.margins(roll, wo.Limits(layer_friction=MU))
    slip = found["slip"]
    assert slip.note.startswith("when the radius of the roll was 90.66 mm")
    half = roll.at(0.09065625)
    torque = wo.margins(half, wo.Limits(layer_friction=MU))["slip"]
    assert slip.value == pytest.approx(torque.value, rel=2e-3)  # what stages err by default
    assert found["blocking"].note == "no limit given"  # which takes time: of the finished roll


def test_the_stages_that_are_looked_at_suffice(
    problem: wo.RollProblem, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Sixty-four stages in place of sixteen change no value by more than 2 %."""
    rises = wo.Profile(radius=[0.0445, 0.1, 0.15], value=[250.0, 500.0, 200.0])
    roll = wo.solve(problem.replace(wound_on_tension=rises, density=None))
    few = wo.margins(roll, wo.Limits(layer_friction=MU))
    monkeypatch.setattr(module, "STAGES", 64)
    many = wo.margins(roll, wo.Limits(layer_friction=MU))
    for one, other in zip(few, many, strict=True):
        assert one.value == pytest.approx(other.value, rel=0.02), one.name


# ---- what every winder knows --------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "limits", "change"),
    [
        ("slip", {"layer_friction": MU}, {"wound_on_tension": 600.0}),  # P grows like T^2
        ("compression", {"compression": 1e5},
         {"wound_on_tension": wo.Taper(start=350.0, taper=0.4)}),
        ("blocking", {"blocking_pressure": 4e5}, {"wound_on_tension": 250.0}),
        ("core", {"core_pressure": 4e5}, {"core.stiffness": 1e8}),  # it gives way
        ("strength", {"web_strength": 1e3}, {"wound_on_tension": 250.0}),
        ("slack", {"slack_tension": 50.0}, {"wound_on_tension": 450.0}),
        ("gauge_band", {"yield_strain": 0.01}, {"wound_on_tension": 250.0}),
    ],
)  # fmt: skip
def test_each_margin_grows_with_what_is_known_to_help(
    problem: wo.RollProblem, name: str, limits: dict[str, float], change: dict[str, object]
) -> None:
    assert reserve(problem.replace(**change), name, **limits) > reserve(problem, name, **limits)


def test_friction_helps_and_a_start_by_the_core_asks_for_more(roll: wo.RollResult) -> None:
    def share(**limits: float) -> float:
        return float(wo.margins(roll, wo.Limits(**limits))["slip"].value)

    assert share(layer_friction=2 * MU) == pytest.approx(share(layer_friction=MU) / 2)
    assert share(layer_friction=MU, acceleration=2.0) > share(layer_friction=MU)
    # a share of half is a safety of two
    safe = wo.margins(roll, wo.Limits(layer_friction=MU, torque_share=0.5))["slip"]
    assert safe.reserve == pytest.approx(1 - 2 * share(layer_friction=MU))


# ---- limits -------------------------------------------------------------------------------------

KEPT = {
    "layer_friction": MU, "compression": 3e5, "blocking_pressure": 5e5, "core_pressure": 5e5,
    "web_strength": 1e3, "slack_tension": 50.0, "yield_strain": 0.01,
}  # fmt: skip
BROKEN = {
    "slip": {"torque_share": 0.05}, "compression": {"compression": 0.0},
    "blocking": {"blocking_pressure": 2e5}, "core": {"core_pressure": 2e5},
    "strength": {"web_strength": 300.0}, "slack": {"slack_tension": 400.0},
    "gauge_band": {"yield_strain": 0.001}, "bending": {"yield_strain": 0.002},
}  # fmt: skip


def test_all_margins_may_hold(roll: wo.RollResult) -> None:
    found = wo.margins(roll, wo.Limits(**KEPT))
    assert tuple(margin.name for margin in found) == NAMES
    assert all(margin.ok is True for margin in found)
    assert found.violated == ()


@pytest.mark.parametrize("name", NAMES)
def test_each_margin_can_fail_and_fails_alone(roll: wo.RollResult, name: str) -> None:
    found = wo.margins(roll, wo.Limits(**{**KEPT, **BROKEN[name]}))
    # a web that yields by its tension yields the more where it is bent
    violated = (name, "bending") if name == "gauge_band" else (name,)
    assert found.violated == violated
    assert found.least is found[violated[-1]]
    assert found[name].reserve < 0
    message = str(found)
    assert message.count("VIOLATED") == len(violated)
    assert found._repr_html_().count("#B00020") == len(violated)  # in red, and in a word


def test_none_is_silently_absent(roll: wo.RollResult) -> None:
    found = wo.margins(roll)
    assert [margin.ok for margin in found] == [None] * 8
    assert found.least is None
    message = str(found)
    for name in NAMES:
        assert f" {found[name].title}: " in message
        assert found[name].left_out.split(",")[0][:20] in " ".join(message.split())
    assert message.count("not checked") == 8
    assert message.count("no limit given") == 7
    assert "the friction between layers is not given" in message


def test_the_collapse_of_a_thin_tube_is_a_limit_of_its_own(problem: wo.RollProblem) -> None:
    board = wo.Isotropic(youngs_modulus=3e9, poissons_ratio=0.3)
    thin = wo.Core(radius=0.0445, inner_radius=0.0425, material=board)
    margin = wo.margins(wo.solve(problem.replace(core=thin)))["core"]
    assert margin.limit == collapse_pressure(thin)
    assert margin.ok is False
    assert "elastic collapse of a thin tube" in margin.note


def test_the_worst_value_of_all_stages_is_continuous() -> None:
    """Stages that differ by less than the default error of a roll: the place is the final one."""
    r = np.linspace(0.05, 0.1, 3)
    early, final = (module._State(s, "", r, np.zeros(3), np.zeros(3)) for s in (0.08, 0.1))
    for excess in (0.9 * module.ALIKE, 1.1 * module.ALIKE):
        peak = np.array([0.0, 1 + excess, 0.0])
        found = module._worst([early, final], [peak, np.array([0.0, 0.0, 1.0])])
        assert found.value == 1 + excess
        assert found.radius == (r[2] if excess < module.ALIKE else r[1])


# ---- yield by bending ---------------------------------------------------------------------------


@pytest.mark.parametrize("k", [1.2, 2.0, 5.0, 50.0])
@pytest.mark.parametrize("t", [0.0, 0.3, 0.6, 0.95])
def test_the_coil_set_by_quadrature(t: float, k: float) -> None:
    """Independent: a by bisection of the mean stress, on a fine grid of the thickness."""
    eta = (np.arange(20_000) + 0.5) / 10_000 - 1
    a = brentq(lambda a: np.mean(np.clip(a + k * eta, -1, 1)) - t, -k - 1, k + 1, xtol=1e-12)
    kept = 1 - 1.5 / k * 2 * np.mean(np.clip(a + k * eta, -1, 1) * eta)
    # the grid misses 1e-8 in smooth parts and 1e-8 k at the kinks
    assert coil_set(t * 2e-3, k * 2e-3, 2e-3) == pytest.approx(kept, abs=1e-6)
    if t == 0:
        assert coil_set(0.0, k, 1.0) == pytest.approx(1 - 1.5 / k + 0.5 / k**3, rel=1e-12)


def test_the_coil_set_begins_at_yield() -> None:
    assert coil_set(0.4, 0.6, 1.0) == 0
    assert 0 < coil_set(0.4, 0.61, 1.0) < 1e-3
    assert coil_set(0.0, 1e6, 1.0) == pytest.approx(1, abs=2e-6)  # all of it


def test_the_margin_of_bending() -> None:
    strip = wo.RollProblem(
        core=wo.Core(radius=0.254, stiffness=60e9), radius=0.5, web_thickness=1e-3,
        wound_on_tension=30e3, stack=wo.Stack(
            radial=2e9, tangential=210e9, poissons_ratio=0.3, shear=1e9),
    )  # fmt: skip
    roll = wo.solve(strip, rtol=1e-2)
    bending = 1e-3 / 2 / 0.254
    assert roll.bending_strain[0] == pytest.approx(bending, rel=1e-12)
    found = wo.margins(roll, wo.Limits(yield_strain=1.2e-3))["bending"]
    assert found.value == pytest.approx(30e6 / 210e9 + bending, rel=1e-9)
    assert found.radius == 0.254
    assert found.ok is False
    radius = 0.254 / coil_set(30e6 / 210e9, bending, 1.2e-3)
    assert f"keeps a curl of {1e3 * radius:.3g} mm radius" in in_chosen_units(found.note)
    assert "straightened" not in found.note
    assert "straightened" in wo.margins(roll, wo.Limits(yield_strain=0.9e-3))["bending"].note
    assert "tension alone" in wo.margins(roll, wo.Limits(yield_strain=1e-4))["bending"].note
    holds = wo.margins(roll, wo.Limits(yield_strain=0.003))["bending"]
    assert (holds.ok, holds.note) == (True, "")
    assert wo.margins(roll)["bending"].verdict == "not checked"
    assert np.isnan(wo.margins(roll).bending)


def test_the_inner_layers_of_a_coil_off_its_mandrel() -> None:
    """Both limits are margins: bonded layers hold, freely sliding ones depend on friction."""
    steel = wo.Stack(radial=2e9, tangential=200e9, poissons_ratio=0.0, shear=1e9)
    coil = wo.RollProblem(
        core=wo.Core(diameter=0.508, stiffness=60e9), diameter=1.5, web_thickness=1e-3,
        stack=steel, wound_on_tension=30e3, core_removed=True,
    )  # fmt: skip
    result = wo.solve(coil)
    found = wo.margins(result)
    assert found["collapse"].value == result.bonded_collapse_load < 0.1
    assert found["collapse"].reserve == pytest.approx(1 - result.bonded_collapse_load)
    assert found.least is not None
    assert found.least.name == "collapse"  # no other has a limit
    # the innermost layer alone: 4 |sigma_t| r_c^2/(E_t h^2)
    single = 4 * 28.59e6 * 0.254**2 / (200e9 * 1e-3**2)
    assert found["sliding_collapse"].value == pytest.approx(single, rel=0.02)
    assert found["sliding_collapse"].verdict == "not checked"
    assert "friction between the layers" in found["sliding_collapse"].note
    assert "collapse of the inner layers" in str(found)
    # wound with a hundredth of the tension neither needs friction
    loose = wo.margins(wo.solve(coil.replace(wound_on_tension=300.0)))
    assert loose["sliding_collapse"].verdict == "holds"
    assert loose["sliding_collapse"].value == pytest.approx(single / 100, rel=0.02)
    on_mandrel = wo.margins(wo.solve(coil.replace(core_removed=False)))
    assert {margin.name for margin in on_mandrel} == set(NAMES)


def test_a_ring_that_collapses_into_the_bore_violates_its_margin() -> None:
    stack = wo.Stack(radial=2e9, tangential=2e9, poissons_ratio=0.0, shear=1e9)
    ring = wo.RollProblem(
        core=wo.Core(radius=0.5, stiffness=2e9), radius=0.504, web_thickness=2e-4, stack=stack,
        wound_on_tension=wo.Profile(radius=[0.5, 0.502, 0.504], value=[400.0, 400.0, 4000.0]),
        core_removed=True,
    )  # fmt: skip
    with pytest.warns(wo.ValidityWarning, match="the inner layers collapse into the bore"):
        found = wo.margins(wo.solve(ring))
    assert found.violated == ("collapse",)
    assert "collapse of the inner layers exceeds its limit" in found.verdict
    assert "smaller core" in found.advice


@pytest.mark.parametrize("change", [{"core_removed": True}, {"core_shrinkage": 1e-3}])
def test_lanes_as_wound_count_where_the_roll_is_changed_later(change: dict[str, Any]) -> None:
    """The core carries the worst lane before it is removed, and layers their compression."""
    lanes = wo.ThicknessProfile(position=[0, 1, 2], thickness=[0.995, 1.01, 0.995])
    kept = wo.RollProblem.example().replace(thickness_profile=lanes)
    before, after = (
        wo.margins(wo.solve(problem, lanes=10, rtol=1e-2))
        for problem in (kept, kept.replace(**change))
    )
    # the stages of the lanes are the same ones
    assert after["core"].value == pytest.approx(before["core"].value, rel=1e-9)
    assert after["compression"].value >= before["compression"].value * (1 - 1e-9)
    assert after["blocking"].value < before["blocking"].value


COOLED = {"temperature_change": -40.0, "radial_expansion": 2e-4}
HEATED = {"temperature_change": 40.0, "radial_expansion": 1e-3}


def test_the_hint_and_what_is_left_out_are_those_of_the_case() -> None:
    """At the bore off its core a stiffer core is of no use; a given change of moisture counts."""
    kept = wo.RollProblem.example()
    swollen = kept.replace(moisture_change=0.01, radial_swelling=0.1)
    removed = kept.replace(core_removed=True)
    of = {
        name: wo.margins(coarse_solution(p), wo.Limits(compression=1e5))["compression"]
        for name, p in (("kept", kept), ("swollen", swollen), ("removed", removed))
    }
    assert "stiffer core" in of["kept"].hint
    assert of["removed"].radius == removed.core.radius
    assert "stiffer" not in of["removed"].hint
    assert ["moisture" in of[name].left_out for name in of] == [True, False, True]
    assert of["removed"].distance == "3730 %"  # without an exponent


@pytest.mark.parametrize("change", [{"core_removed": True}, HEATED, COOLED])
def test_the_worst_lanes_count_as_wound_and_after_the_change(change: dict[str, Any]) -> None:
    profile = wo.ThicknessProfile(position=[0, 1, 2], thickness=[0.995, 1.01, 0.995])
    roll = wo.solve(
        wo.RollProblem.example().replace(thickness_profile=profile, **change), lanes=10, rtol=1e-2
    )
    found, lanes = wo.margins(roll), roll.lanes
    assert lanes is not None
    wound_hoop, hoop = lanes.hoop_stress_as_wound.values, lanes.hoop_stress.values
    wound_pressure, pressure = lanes.pressure_as_wound.values[0], lanes.pressure.values[0]
    largest = -min(wound_hoop.min(), hoop.min())
    assert found["compression"].value == pytest.approx(largest, rel=1e-12)
    assert found["core"].value == max(wound_pressure.max(), pressure.max())
    # each side is the larger one in one of the cases
    assert (hoop.min() < wound_hoop.min()) == (change is not COOLED)
    assert (pressure.max() > wound_pressure.max()) == (change is HEATED)
    thickness = roll.problem.web_thickness * (1 + lanes.thickness_excess.values)
    web = max(lanes.wound_on_tension.values.max(), lanes.web_tension.values.max())
    finished = (thickness * hoop).max()
    assert found["strength"].value == pytest.approx(max(web, finished), rel=1e-12)
    assert (finished > 2 * web) == (change is HEATED)


# ---- yield of the finished roll -----------------------------------------------------------------

GROWTH = {"temperature_change": 40.0, "radial_expansion": 1e-3}  # through the stack alone
ALIKE = dict.fromkeys(("tangential_expansion", "radial_expansion", "core_expansion"), 1e-4)


def test_the_tension_after_the_changes_is_in_the_margins_of_yield(problem: wo.RollProblem) -> None:
    """A stack that grows through its thickness stretches its layers."""
    grown, wound = (wo.solve(p, rtol=0.01) for p in (problem.replace(**GROWTH), problem))
    E_t = problem.stack.tangential
    T = problem.wound_on_tension / problem.web_thickness
    assert grown.hoop_stress.max() > 1.1 * T
    tension = np.maximum(grown.hoop_stress, T) / E_t
    found = wo.margins(grown)
    assert found["gauge_band"].value == pytest.approx(tension.max(), rel=1e-12)
    bent = problem.web_thickness / (2 * grown.radius)
    assert found["bending"].value == pytest.approx((tension + bent).max(), rel=1e-12)
    assert wo.margins(wound)["gauge_band"].value == pytest.approx(T / E_t, rel=1e-12)
    # at its surface the hoop stress is that of winding up to the discretisation error
    assert wo.margins(wound)["strength"].value == pytest.approx(problem.wound_on_tension, rel=1e-12)


def test_a_free_strain_without_stress_does_not_bring_yield_nearer(problem: wo.RollProblem) -> None:
    """Layers and core that expand alike in all directions have the stresses of winding."""
    heated = wo.solve(problem.replace(temperature_change=40.0, **ALIKE), rtol=0.01)
    strain = problem.wound_on_tension / problem.web_thickness / problem.stack.tangential
    found = wo.margins(heated)
    # the hoop stress at the surface is that of winding up to the error of its slope there
    error = 2 * abs(heated.surface_slope)
    assert found["gauge_band"].value == pytest.approx(strain, rel=max(error, 1e-9))
    bent = problem.web_thickness / (2 * problem.core.radius)
    assert found["bending"].value == pytest.approx(strain + bent, rel=max(error, 1e-9))


def test_the_compression_at_the_bore_off_its_core_bends_the_inner_face_further() -> None:
    """The tension rises towards the surface, and the bore is compressed more than it was taut."""
    rising = wo.Profile(radius=[0.254, 0.3, 0.75], value=[10e3, 40e3, 40e3])
    problem = wo.RollProblem(
        core=wo.Core(diameter=0.508, stiffness=60e9), diameter=1.5, web_thickness=1e-3,
        wound_on_tension=rising, core_removed=True,
        stack=wo.Stack(radial=2e9, tangential=200e9, poissons_ratio=0.0, shear=1e9),
    )  # fmt: skip
    roll = wo.solve(problem, rtol=0.01)
    T, E_t = 10e3 / problem.web_thickness, problem.stack.tangential
    compression = -float(roll.hoop_stress[0])
    assert compression > 1.1 * T
    strain = compression / E_t + problem.web_thickness / (2 * problem.core.radius)
    found = wo.margins(roll, wo.Limits(yield_strain=strain / 1.01))["bending"]
    assert found.value == pytest.approx(strain, rel=1e-12)
    assert found.verdict == "VIOLATED"
    below = wo.Limits(yield_strain=compression / E_t / 1.01)
    assert "compression alone" in wo.margins(roll, below)["bending"].note
    even = wo.ThicknessProfile(position=[0, 1], thickness=[1, 1])
    lanes = wo.solve(problem.replace(thickness_profile=even), rtol=0.01, lanes=4)
    # lanes have a discretisation error of their own; without the compression it would be 9 % less
    assert wo.margins(lanes)["bending"].value == pytest.approx(strain, rel=0.01)


def test_lanes_of_equal_thickness_yield_as_the_plain_roll(problem: wo.RollProblem) -> None:
    even = wo.ThicknessProfile(position=[0, 1], thickness=[1, 1])
    lanes = wo.solve(problem.replace(thickness_profile=even, **GROWTH), rtol=0.01, lanes=4)
    plain = wo.margins(wo.solve(problem.replace(**GROWTH), rtol=0.01))
    of_lanes = wo.margins(lanes)
    for name in ("gauge_band", "bending", "strength"):
        # the lanes have the discretisation error of the roll, another one at its surface
        assert of_lanes[name].value == pytest.approx(plain[name].value, rel=1e-3), name


def test_the_change_of_a_lone_lane_is_left_out_in_words(problem: wo.RollProblem) -> None:
    band = problem.replace(gauge_excess=0.001)
    for case, is_named in ((band, False), (band.replace(**GROWTH), True)):
        left_out = wo.margins(coarse_solution(case))["gauge_band"].left_out
        assert ("own tension after winding" in left_out) == is_named


# ---- one way to all margins ---------------------------------------------------------------------


@pytest.mark.parametrize("core_removed", [False, True])
def test_every_margin_has_its_reserve_as_an_attribute(core_removed: bool) -> None:
    found = wo.margins(coarse_solution(wo.RollProblem.example().replace(core_removed=core_removed)))
    for name in module.TITLES:
        expected = next((m.reserve for m in found if m.name == name), np.nan)
        assert getattr(found, name) == pytest.approx(expected, nan_ok=True), name
    assert np.isnan(found.collapse) != core_removed


def test_the_panel_of_the_reserves_shows_every_checked_margin() -> None:
    """There are more margins than colours."""
    roll = coarse_solution(wo.RollProblem.example().replace(core_removed=True, density=700.0))
    limits = wo.Limits(
        layer_friction=0.3, compression=1e5, blocking_pressure=1e6, core_pressure=1e6,
        web_strength=1e4, yield_strain=0.01, acceleration=0.5,
    )  # fmt: skip
    found = wo.margins(roll, limits)
    checked = {margin.name for margin in found if margin.checked}
    assert len(checked) > len(SERIES)
    panel = reserves(SimpleNamespace(margins=found, radius=roll.radius))
    drawn = {curve.name: (curve.colour, curve.line) for curve in panel.curves if curve.in_legend}
    assert drawn.keys() == checked
    assert len(set(drawn.values())) == len(drawn)
    # a reserve of -35 does not press the others together
    assert panel.y.limits[0] == -2.0
