"""Windings: the coupling of nips and roll, what is reported of it, and that its laws can fail."""

from __future__ import annotations

import itertools
import pickle
import re
import warnings
from collections.abc import Callable
from copy import deepcopy
from functools import cache
from typing import Any

import numpy as np
import pytest
from slow_cases import slow_case

import woundon as wo
from woundon.parallel import Cancelled
from woundon.results import ACCEPTED_RESIDUAL
from woundon.roll.stages import stages_at
from woundon.winding.bodies import effective_cylinder, effective_pressure
from woundon.winding.certificate import NIP_ARRAYS
from woundon.winding.interpolation import Piece
from woundon.winding.measured import smoothed
from woundon.winding.roll import wind

CASE = wo.WindingProblem.example().replace(radius=0.12)
COARSE: dict[str, Any] = {"nodes": 33, "rtol": 5e-3, "coupling_rtol": 1e-6}
SEEN = 1e4 * ACCEPTED_RESIDUAL


@cache
def wound(body: str = "linear") -> wo.WindingResult:
    return wo.solve(CASE.replace(roll_body=body), **COARSE)


@cache
def braked() -> wo.WindingResult:
    return wo.solve(CASE.replace(tension_law="friction", winding_force=-50.0))


def deviation(run: wo.WindingResult, r: float) -> float:
    """Return how far a linear winding's tension is from that of a nip solved at r, relative."""
    nip = run.problem.nip(r, wo.Cylinder(radius=r, core_radius=0.05, material="newsprint"))
    tension = np.interp(r, run.radius, run.wound_on_tension)
    return float(abs(wo.solve(nip, nodes=33).roll_wound_on_tension / tension - 1))


# ---- fewer nips -------------------------------------------------------------------------------


def test_without_error_estimates_a_winding_is_the_same():
    run = wo.solve(CASE.replace(roll_body="effective"), **COARSE, errors=False)
    np.testing.assert_array_equal(run.wound_on_tension, wound("effective").wound_on_tension)
    assert run.core_pressure == wound("effective").core_pressure
    assert np.isnan(run.nip_error).all()
    assert np.isnan(run.errors["core_pressure"])
    assert run.residuals.largest < ACCEPTED_RESIDUAL


@pytest.mark.filterwarnings("ignore::woundon.ResolutionWarning")
def test_a_survey_takes_fewer_nips_and_keeps_its_tolerance():
    """Within rtol of the winding with a fifth of it, over two pieces of the curve of tension."""
    loads = wo.Profile(radius=[0.05, 0.08, 0.12], value=[3000.0, 2800.0, 1600.0])
    problem = CASE.replace(roll_body="effective", nip_load=loads)
    rough = {"nodes": 33, "rtol": 1e-2, "coupling_rtol": 1e-3}
    survey, full = (wo.solve(problem, **rough, errors=errors) for errors in (False, True))
    assert survey.nip_radius.size < full.nip_radius.size
    assert survey.nips_solved < full.nips_solved
    fine = wo.solve(problem, nodes=33, rtol=2e-3, coupling_rtol=1e-5, errors=False)
    r = np.linspace(0.0525, 0.12, 200)  # above the piece on the core, which is less accurate
    tension, expected = (np.interp(r, one.radius, one.wound_on_tension) for one in (survey, fine))
    np.testing.assert_allclose(tension, expected, rtol=1e-2)


def test_exponents_of_the_effective_pressure_are_those_of_solved_nips():
    """Central differences over 1 % of the same nip; one over 1 % upwards is off by their change."""
    run = wound("effective")
    for sample in run.nips[:: len(run.nips) // 3]:
        outputs = []
        for factor in (1.01, 0.99):
            body = effective_cylinder(run.problem, sample.radius, factor * sample.pressure)
            nip = wo.solve(sample.result.problem.replace(roll=body), nodes=33)
            outputs.append([nip.roll_wound_on_tension, nip.half_width, nip.peak_pressure])
        expected = np.log(np.divide(*outputs)) / np.log(1.01 / 0.99)
        np.testing.assert_allclose(sample.exponents, expected, rtol=0, atol=5e-3)


# ---- interpolation ------------------------------------------------------------------------------


def test_a_piece_meets_polynomials_exactly_and_estimates_its_error():
    piece = Piece(-3.0, 1.0, 7)
    values = {x: x**3 - 2 * x for x in piece.places}
    x = np.linspace(-3, 1, 101)
    np.testing.assert_allclose(piece.at(x, values), x**3 - 2 * x, atol=1e-11)
    np.testing.assert_allclose(piece.at(np.array(piece.places), values), list(values.values()))
    assert max(error for _, error in piece.error_estimates(values)) < 1e-11
    # the error at a kink is in the estimate
    kinked = {x: abs(x + 0.9) for x in piece.places}
    off = np.max(np.abs(piece.at(x, kinked) - np.abs(x + 0.9)))
    assert max(error for _, error in piece.error_estimates(kinked)) > 0.3 * off


# ---- measured schedules -------------------------------------------------------------------------


@cache
def wandering() -> wo.WindingResult:
    """Tension and nip load as measured: 5 % of noise at 100 radii."""
    rng = np.random.default_rng(3)
    r = np.linspace(0.05, 0.12, 100)
    noise = 1 + 0.05 * rng.standard_normal((2, r.size))
    tension, load = (
        wo.Profile(radius=r, value=values * more)
        for values, more in zip(
            (CASE.at("web_tension", r), CASE.at("nip_load", r)), noise, strict=True
        )
    )
    problem = CASE.replace(roll_body="linear", web_tension=tension, nip_load=load)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return wo.solve(problem, **COARSE)


@pytest.mark.slow
def test_schedules_that_wander_take_as_few_nips_as_smooth_ones():
    run = wandering()
    assert run.nip_radius.size <= 20
    assert run.radius.size > 90  # the tension is reported wherever they turn
    assert run.certified().coupling <= ACCEPTED_RESIDUAL
    # more than interpolation would leave, for the tension follows the measured load and tension
    bends = np.diff(np.sign(np.diff(run.wound_on_tension)))
    assert np.count_nonzero(bends) > 40


@pytest.mark.slow
def test_nips_under_measured_loads_are_within_the_error_reported():
    run = wandering()
    for r in (0.0573, 0.0811, 0.1024):
        off = deviation(run, r)
        assert off <= run.interpolation_error
    # noise moves the tension by 5 % of it and more: what is left is the second order
    assert run.interpolation_error < 0.015


@pytest.mark.slow
def test_smooth_tables_and_few_kinks_do_not_wander():
    r = np.linspace(0.05, 0.12, 80)
    smooth = wo.Profile(radius=r, value=350 - 900 * (r - 0.05))
    assert smoothed(CASE.replace(web_tension=smooth), 1e-3) is None
    kinked = wo.Profile(radius=[0.05, 0.07, 0.12], value=[2000.0, 2600.0, 2000.0])
    assert smoothed(CASE.replace(nip_load=kinked), 1e-3) is None
    found = smoothed(wandering().problem, 1e-3)
    assert found is not None
    assert np.max(np.abs(found.at("nip_load", r) / 2000 - 1)) < 0.05
    assert found.curve("nip_load").kinks.size == 0


# ---- coupling -----------------------------------------------------------------------------------


def test_each_nip_answers_what_the_roll_was_wound_with():
    """Solved again by hand at a radius of the result, on the roll that the result tells."""
    run = wound("effective")
    k = run.nip_radius.size // 2
    r = float(run.nip_radius[k])
    roll = effective_cylinder(run.problem, r, float(run.nip_effective_pressure[k]))
    nip = wo.solve(run.problem.nip(r, roll), nodes=33)
    tension = np.interp(r, run.radius, run.wound_on_tension)
    assert nip.roll_wound_on_tension == pytest.approx(tension, rel=2 * run.coupling_rtol)
    assert run.roll.problem.tension_curve.at(r) * 66e-6 == pytest.approx(tension, rel=1e-12)
    # and the roll so far asks for the modulus that it has; what is left is a second-order change
    stage = stages_at(run.roll, [r])[0]
    found = effective_pressure(stage, nip.roll_wound_on_tension, nip.half_width, nip.peak_pressure)
    assert found == pytest.approx(float(run.nip_effective_pressure[k]), rel=1e-4)


def test_nips_are_solved_down_to_ten_layers_on_the_core():
    """There the share falls to a half within a few millimetres: no tangent tells it."""
    run = wound()
    assert run.nip_radius[0] == pytest.approx(0.05 + 10 * 66e-6)
    assert np.count_nonzero(run.nip_radius < 0.0525) >= 3
    for r in (0.0508, 0.0517, 0.0522):
        off = deviation(run, r)
        # and the error of linear interpolation between the radii, 0.3 rtol
        assert off <= run.core_interpolation_error + 0.3 * COARSE["rtol"]
    assert run.nip_induced_tension[0] < 0.2 * run.nip_induced_tension.max()


def test_what_the_first_layers_may_do_is_in_the_error_of_the_core_pressure():
    """Wound with the web's tension alone, or with that of the tenth lap, it stays within bounds."""
    run = wound()
    r, tension = run.radius, run.wound_on_tension
    own = 2 * run.interpolation_error * run.core_pressure
    first = r < run.nip_radius[0]
    for least in (0.5, 2.0):  # of what the tangent says that nips add there
        other = tension + first * (least - 1) * run.nip_induced_tension
        roll = wind(run.problem, r, other, COARSE["rtol"]).result
        off = abs(roll.core_pressure - run.core_pressure)
        assert off < run.errors["core_pressure"] + own
    assert run.errors["core_pressure"] > run.roll.errors["core_pressure"] + own


@pytest.mark.slow
def test_a_roll_whose_stages_are_chosen_otherwise_keeps_nothing_from_agreeing():
    """Two choices of them, each asked for by the tension of the other, once went on for ever."""
    problem = CASE.replace(
        radius=0.6, nip_load=1300.0610347693473,
        web_tension=wo.Taper(start=350.0, taper=0.4418487287723576),
    )  # fmt: skip
    assert wo.solve(problem, **COARSE).residuals.coupling <= ACCEPTED_RESIDUAL


@pytest.mark.slow
def test_the_roll_does_not_depend_on_where_the_winding_was_begun():
    """From half the tension and a quarter of the nip load, and with as many radii as without."""
    far = CASE.replace(web_tension=800.0, nip_load=500.0, roll_body="linear")
    start = wo.solve(far, nodes=25, rtol=5e-2)
    one, two = (
        wo.solve(CASE.replace(radius=0.08), **(COARSE | {"coupling_rtol": 1e-7}), start=begun)
        for begun in (None, start)
    )
    np.testing.assert_array_equal(one.radius, two.radius)
    # to what they agree, times what a turn leaves of a change, in steps of two turns
    np.testing.assert_allclose(one.wound_on_tension, two.wound_on_tension, rtol=2e-6)
    P, Q = (run.roll.at_radius(one.radius)["pressure"] for run in (one, two))
    np.testing.assert_allclose(P, Q, atol=1e-6 * P.max())


def test_what_the_winder_sets_is_reported_over_the_radius():
    run = wound()
    r = run.radius
    np.testing.assert_allclose(run.web_tension, CASE.curve("web_tension").at(r), rtol=1e-14)
    np.testing.assert_allclose(run.nip_induced_tension, run.wound_on_tension - run.web_tension)
    assert (r[0], r[-1]) == (0.05, 0.12)
    assert set(run.nip_radius) <= set(r)
    assert run.mass == pytest.approx(680 * np.pi * (0.12**2 - 0.05**2))
    assert run.mean_wound_on_tension == pytest.approx(
        np.trapezoid(run.wound_on_tension * r, r) / np.trapezoid(r, r)
    )


def test_warnings_of_nips_state_their_radii_in_the_unit_of_the_report():
    result = wo.solve(CASE.replace(radius=0.053), nodes=25, rtol=5e-3)
    (text,) = (text for text in result.warnings if "nip at the radius" in text)
    radii = re.search(r"nip at the radius ([\d.]+) mm and \d+ more up to ([\d.]+) mm: ", text)
    assert radii is not None, text
    assert 50.0 <= float(radii[1]) < float(radii[2]) <= 53.0  # from the core to the surface


@pytest.mark.parametrize("copied", [deepcopy, lambda run: pickle.loads(pickle.dumps(run))])
def test_the_report_of_a_copy_states_what_it_lacks(copied: Callable[[Any], Any]):
    """The solved nips are a hundred times as large as the rest, and not in a copy or a file."""
    whole, rest = str(wound()).splitlines(), str(copied(wound())).splitlines()
    differ = [line for line in rest if line not in whole]
    text = " ".join(" ".join(differ).split())
    assert "The web slips forward under" in " ".join(" ".join(whole).split())
    assert "sticks in the nips is not saved with a result: solve the problem again" in text
    assert len(differ) <= 3  # of the paragraph with this text


def test_the_interpolation_error_is_reported():
    """Nips at radii that took no part miss the curve by no more than is reported."""
    run = wound()
    for r in (0.057, 0.075, 0.1):
        off = deviation(run, r)
        assert off <= run.interpolation_error <= 5e-3
    assert run.errors["mean_wound_on_tension"] > run.interpolation_error * 400


@pytest.mark.parametrize("schedule", [300.0, wo.Taper(start=400.0, taper=0.3)])
def test_with_the_law_of_friction_it_is_the_uncoupled_roll(schedule: Any):
    """T_in + mu+ P of a constant load is linear where T_in is: the same roll, to rounding."""
    problem = CASE.replace(tension_law="friction", web_tension=schedule, **{"stack.radial": 20e6})
    run = wo.solve(problem)
    more = 0.19 * 2000.0
    if isinstance(schedule, float):
        alone = schedule + more
    else:
        start = schedule.start + more
        alone = wo.Taper(start=start, taper=schedule.taper * schedule.start / start)
    roll = wo.solve(problem.wound_roll(alone))
    r = np.linspace(0.05, 0.12, 50)
    P, Q = run.roll.at_radius(r)["pressure"], roll.at_radius(r)["pressure"]
    np.testing.assert_allclose(P, Q, atol=1e-9 * roll.peak_pressure)
    assert run.nip_radius.size == 0


def test_the_other_laws():
    fixed = wo.solve(CASE.replace(tension_law="fixed", nip_induced_tension=120.0))
    np.testing.assert_allclose(fixed.wound_on_tension, fixed.web_tension + 120.0)
    table = wo.Profile(radius=[0.05, 0.08, 0.2], value=[500.0, 400.0, 300.0])
    given = wo.solve(CASE.replace(tension_law=table))
    np.testing.assert_allclose(given.wound_on_tension, table.at(given.radius))
    surface = wo.solve(CASE.replace(tension_law="friction", torque_split=1.0, nip_load=3000.0))
    np.testing.assert_allclose(surface.wound_on_tension, 0.19 * 3000.0)  # T_in cancels


def test_a_tension_that_leaves_a_lap_slack_is_rejected_with_the_radius():
    with pytest.raises(
        wo.NoSteadyState, match=r"wound-on tension falls to -5.* at the radius 0.12"
    ):
        wo.solve(CASE.replace(tension_law="fixed", nip_induced_tension=-250.0))


def test_a_nip_that_has_no_steady_state_is_reported_with_its_radius(
    monkeypatch: pytest.MonkeyPatch,
):
    def slack(*_: Any, **__: Any) -> Any:
        raise wo.NoSteadyState.at("web_tension", "5 leaves the web slack")

    monkeypatch.setattr("woundon.winding.nips.solve_nip", slack)
    with pytest.raises(wo.NoSteadyState, match=r"web_tension: at the radius 0.05066 m: 5 leaves"):
        wo.solve(CASE)


@pytest.mark.slow
def test_nips_whose_tension_jumps_do_not_converge(monkeypatch: pytest.MonkeyPatch):
    """Tensions that change by 1e-4 from solve to solve cannot agree to 1e-6: no result is given."""
    solve, count = wo.solve, itertools.count()

    def jumping(*args: Any, **options: Any) -> Any:
        result = solve(*args, **options)
        tension = result.roll_wound_on_tension
        return result.replace(roll_wound_on_tension=tension * (1 + 1e-4 * (next(count) % 3)))

    monkeypatch.setattr("woundon.winding.nips.solve_nip", jumping)
    with pytest.raises(wo.NotConverged, match="the nip-roll iteration does not converge") as stop:
        wo.solve(CASE.replace(radius=0.06), nodes=25, rtol=5e-2, coupling_rtol=1e-6)
    assert stop.value.best is not None


@pytest.mark.slow
def test_a_loose_tolerance_of_the_roll_does_not_keep_the_iteration_from_converging():
    # the stages of the roll follow rtol: another stage changes the tension by 3e-6
    newsprint = wo.grade("newsprint")
    problem = wo.WindingProblem(
        grade=newsprint, radius=0.6, core=wo.Core(radius=0.05, stiffness=1e9), web_tension=200.0,
        nip_load=2000.0, drum=wo.Rigid(radius=0.4), web={"thickness": 66e-6},
    )  # fmt: skip
    loose = wo.solve(problem, rtol=1e-2)
    assert loose.coupling_rtol == pytest.approx(1e-5)
    error = loose.error("mean_wound_on_tension")
    assert abs(loose.mean_wound_on_tension - 374.1) < error + 0.05  # as printed with rtol 1e-3


def test_progress_is_a_fraction_after_every_nip():
    seen: list[float] = []
    rough = {**COARSE, "nodes": 25, "rtol": 0.05}
    run = wo.solve(
        CASE.replace(roll_body="linear", radius=0.06),
        **rough,
        progress=seen.append,
    )
    assert len(seen) == run.nips_solved + 1
    assert 0 < seen[0] < seen[-1] == 1


@pytest.mark.parametrize(
    "changes", [{}, slow_case({"web_speed": 10.0, "air": wo.Air(roughness=1e-6)})]
)
def test_progress_is_about_proportional_to_the_nips_that_are_solved(changes: dict[str, Any]):
    seen: list[float] = []
    wo.solve(CASE.replace(radius=0.1, **changes), rtol=1e-2, nodes=25, progress=seen.append)
    fractions = np.array(seen)
    assert (np.diff(fractions) >= 0).all()
    assert fractions[-1] == 1
    # an estimate, from the convergence of the iteration; above all it does not stay at its end
    share = np.arange(1, fractions.size + 1) / fractions.size
    assert np.abs(fractions - share).max() < 0.35
    assert share[fractions >= 0.9][0] > 0.7


def test_a_winding_stops_where_its_progress_raises():
    def cancel(fraction: float) -> None:
        raise Cancelled

    with pytest.raises(Cancelled):
        wo.solve(CASE, **COARSE, progress=cancel)


# ---- the certificate ----------------------------------------------------------------------------

Corrupt = Callable[[Any], dict[str, Any]]


def changed(name: str, node: int, by: float) -> Corrupt:
    def corrupt(run: Any) -> dict[str, Any]:
        values = getattr(run, name).copy()
        values[node] += by * np.max(np.abs(values))
        return {name: values}

    return corrupt


def of_roll(**changes: Callable[[Any], Any]) -> Corrupt:
    return lambda run: {
        "wound": run.roll.replace(**{name: make(run.roll) for name, make in changes.items()})
    }


FAULTS: list[tuple[str, Corrupt]] = [
    ("roll", of_roll(pressure=lambda roll: roll.pressure * 1.01)),
    ("roll_tension", of_roll(problem=lambda roll: roll.problem.replace(wound_on_tension=400))),
    ("nips", lambda run: {"nip_residual": run.nip_residual + 1e-3}),
    # would take hours to be solved again
    ("nips", lambda run: {"nodes": 2000}),
    ("nips", lambda run: {name: np.repeat(getattr(run, name), 30) for name in NIP_ARRAYS}),
    ("coupling", changed("nip_wound_on_tension", 2, 0.5)),
    ("coupling", lambda run: {"nip_departure": run.nip_departure + 5.0}),
    ("tension_balance", changed("nip_induced_tension", 3, 0.01)),
    ("schedules", changed("nip_load", 1, 0.01)),
    ("schedules", changed("web_tension", 1, 0.01)),
    ("schedules", changed("winding_force", 1, 0.01)),
    ("reach", changed("radius", -1, 0.01)),
    ("reach", lambda run: {"radius": run.radius[[0, 2, 1, *range(3, run.radius.size)]]}),
    ("air", lambda run: {"air_film": run.air_film + 0.1 * run.problem.web.thickness}),
]


@pytest.mark.parametrize(("law", "corrupt"), FAULTS)
def test_every_law_can_fail(law: str, corrupt: Corrupt):
    run = braked() if law == "schedules" else wound()
    assert getattr(run.certified(), law) <= ACCEPTED_RESIDUAL
    assert getattr(run.replace(**corrupt(run)).certified(), law) > SEEN


def test_no_law_is_without_its_fault():
    assert {law for law, _ in FAULTS} == set(dict(wound().residuals.items()))
