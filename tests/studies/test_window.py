"""The operating window: closed forms, Monte Carlo simulation with windings, resuming, the command.

Evidence: closed form (probabilities of linear margins, a strength margin that is a power law of the
friction), independent method (every sample a winding), invariance (workers, resuming).
"""

from __future__ import annotations

import json
from contextlib import nullcontext
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import norm
from study_models import BOARD

import woundon as wo
from woundon.cli.commands import main
from woundon.io.case_files import to_toml
from woundon.report.study_panels import window_panels
from woundon.studies.window import BETWEEN
from woundon.studies.window_cases import spreads_and_ties, window_model, with_value
from woundon.studies.window_map import (
    MarginMap,
    SetPoints,
    expansion_of,
    fitted,
    from_reserve,
    lobatto,
    standard_normal,
    to_reserve,
)

RANGES = {"web_tension": (150.0, 450.0), "nip_load": (500.0, 3000.0)}
STRENGTH = 700.0  # N/m


def winding(**changes) -> wo.WindingProblem:
    """Return a small roll; the wound-on tension is T_in + mu N, so that no nip is solved."""
    given = {
        "grade": "newsprint", "core": wo.Core(radius=0.05, stiffness=1e9), "radius": 0.15,
        "drum": wo.Rigid(radius=0.25), "web_tension": 300.0, "nip_load": 1500.0,
        "tension_law": "friction", "limits": wo.Limits(web_strength=STRENGTH), **changes,
    }  # fmt: skip
    with pytest.warns(wo.InputWarning) if "roll_friction" in changes else nullcontext():
        return wo.WindingProblem(**given)


# ---- maps ---------------------------------------------------------------------------------------


def grid(n: int) -> np.ndarray:
    return np.stack(np.meshgrid(lobatto(n), lobatto(n), indexing="ij"), axis=-1).reshape(-1, 2)


def test_polynomials_are_interpolated_exactly():
    """Closed form: a polynomial of degree 4 is its own interpolant at 5 x 5 points."""

    def f(x):
        return np.stack([x[:, 0] ** 4 * x[:, 1] ** 3 - x[:, 1], 2 + x[:, 0]], axis=1)

    x = np.random.default_rng(0).uniform(-1, 1, (50, 2))
    # 1e-12: rounding of a least-squares solution with a condition number of about 10
    np.testing.assert_allclose(fitted(grid(5), f(grid(5)), [4, 4])(x), f(x), atol=1e-12)


def test_a_quadratic_is_fitted_without_some_points():
    """Closed form: without a corner of the 5 x 5 points the terms of degree 2 remain exact."""

    def f(x):
        return (1 + x[:, 0] - 2 * x[:, 0] * x[:, 1] + x[:, 1] ** 2)[:, None]

    points = grid(5)[grid(5).sum(axis=1) < 0.9]
    x = np.random.default_rng(0).uniform(-1, 1, (50, 2))
    np.testing.assert_allclose(fitted(points, f(points), [4, 4])(x), f(x), atol=1e-12)


def test_points_are_nested():
    assert set(lobatto(3)) <= set(lobatto(5)) <= set(lobatto(9))


@pytest.mark.parametrize("count", list(BETWEEN))
def test_checks_are_halfway_between_the_points(count):
    """Closed form: the Chebyshev polynomial T_n, n intervals, is 1 or -1 at them, 0 halfway."""
    assert np.abs(np.cos((count - 1) * np.arccos(lobatto(count)))) == pytest.approx(1.0)
    assert np.cos((count - 1) * np.arccos(BETWEEN[count])) == pytest.approx(0.0, abs=1e-6)


def test_reserves_are_transformed_and_back():
    """Closed form: the inverse function, its derivative by differences, and the same sign."""
    m = np.array([-3.0, -0.1, 0.0, 0.2, 1.0, 4.0])
    back, derivative = to_reserve(from_reserve(m))
    np.testing.assert_allclose(back, m, atol=1e-14)
    step = 1e-6  # its square is the relative error of the central difference
    numeric = 2 * step / (from_reserve(m + step) - from_reserve(m - step))
    np.testing.assert_allclose(derivative, numeric, rtol=1e-8)
    assert (np.sign(from_reserve(m)) == np.sign(m)).all()


@pytest.mark.parametrize(
    ("slopes", "expected"),
    [
        # independent margins: the product; the same margin twice: one of them
        ([[1.0, 0.0], [0.0, 1.0]], norm.cdf(0.5) * norm.cdf(1.0)),
        ([[1.0, 0.0], [1.0, 0.0]], norm.cdf(0.5)),
        # opposite margins: both ends of one distribution
        ([[1.0, 0.0], [-1.0, 0.0]], norm.cdf(0.5) + norm.cdf(1.0) - 1),
    ],
)
def test_the_probability_of_linear_margins(slopes, expected):
    """Closed form: margins 0.5 + s_1 z and 1 + s_2 z of standard normal z."""
    centre = np.zeros((1, 2))
    nominal = fitted(centre, np.array([[0.5, 1.0]]), [0, 0])
    none = np.zeros((0, 2))  # without further points the changes are linear
    expansion = expansion_of(none, none, none, np.array(slopes).T)
    mapped = MarginMap(nominal, *expansion, standard_normal(2, 4096, 0))
    # 0.003: Sobol points err by less than 1/5 of the standard deviation of independent draws
    assert mapped.probability(centre)[0] == pytest.approx(expected, abs=0.003)


def test_an_expansion_of_second_order_is_found_exactly():
    """Closed form: f = (2 + x_1) z_1 + 0.5 z_1 z_2 + z_2^2 + 0.1 z_3.

    Its mean is 1 and its variance (2 + x_1)^2 + 0.25 + 2 + 0.01; the product counts half for z_1.
    """
    rng = np.random.default_rng(0)
    x, z = rng.uniform(-1, 1, (60, 2)), rng.standard_normal((60, 3))

    def f(x, z):
        return ((2 + x[:, 0]) * z[:, 0] + 0.5 * z[:, 0] * z[:, 1] + z[:, 1] ** 2
                + 0.1 * z[:, 2])[:, None]  # fmt: skip

    expansion = expansion_of(x, z, f(x, z), np.array([[2.0], [1.0], [0.1]]))
    mapped = MarginMap(fitted(np.zeros((1, 2)), np.zeros((1, 1)), [0, 0]), *expansion, z)
    x, z = rng.uniform(-1, 1, (20, 2)), rng.standard_normal((20, 3))
    # 1e-12: rounding of a least-squares solution
    np.testing.assert_allclose(mapped.margins(x, z), f(x, z), atol=1e-12)
    np.testing.assert_allclose(mapped.means(x), 1.0, atol=1e-12)
    parts = np.stack([(2 + x[:, 0]) ** 2 + 0.125, 0 * x[:, 0] + 2.125, 0 * x[:, 0] + 0.01], axis=-1)
    np.testing.assert_allclose(mapped.variances(x)[:, 0], parts, atol=1e-12)
    np.testing.assert_allclose(mapped.distances(x)[:, 0] ** 2 * parts.sum(axis=-1), 1.0, atol=1e-12)


def test_few_points_permit_few_quadratic_terms():
    """Invariance: with too few points for all inputs, linear changes remain exact."""
    rng = np.random.default_rng(0)
    x, z = rng.uniform(-1, 1, (24, 2)), rng.standard_normal((24, 6))
    slopes = np.arange(1.0, 7.0)[:, None]  # all cause more than 1 % of the variance
    expansion = expansion_of(x, z, z @ slopes, slopes)
    assert len(expansion[0]) < 24 / 2
    mapped = MarginMap(fitted(np.zeros((1, 2)), np.zeros((1, 1)), [0, 0]), *expansion, z)
    np.testing.assert_allclose(mapped.variances(x)[:, 0], [slopes[:, 0] ** 2] * 24, atol=1e-12)


def test_schedules_keep_their_shape():
    """Invariance: the ratio of the value at two radii is that of the given schedule."""
    for schedule in (
        300.0,
        wo.Taper(start=300.0, taper=0.3),
        wo.Profile(radius=(0.04, 0.1, 0.2), value=(310.0, 280.0, 250.0)),
    ):
        problem = winding(web_tension=schedule)
        scaled = problem.replace(**with_value(problem, "web_tension", 450.0))
        r = np.array([0.05, 0.09, 0.15])
        before, after = problem.at("web_tension", r), scaled.at("web_tension", r)
        assert after[0] == pytest.approx(450.0)
        np.testing.assert_allclose(after / after[0], before / before[0], rtol=1e-12)


@pytest.mark.parametrize(
    ("name", "ends", "middle"),
    [
        ("web_tension", (100.0, 400.0), 200.0),  # geometric mean
        ("oscillation", (0.0, 0.4), 0.2),
        ("winding_force", (-100.0, 300.0), 100.0),
        ("torque_split", (0.2, 0.6), 0.4),
    ],
)
def test_set_points_are_logarithmic_if_all_values_are_positive(name, ends, middle):
    points = SetPoints((name, "nip_load"), np.array([ends, (1.0, 4.0)]))
    values = points.values(np.array([[-1.0, -1.0], [0.0, 0.0], [1.0, 1.0]]))
    np.testing.assert_allclose(values[:, 0], [ends[0], middle, ends[1]], rtol=1e-14)
    np.testing.assert_allclose(points.coordinates(values)[:, 0], [-1, 0, 1], atol=1e-14)


# ---- what is rejected ---------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("changes", "field"),
    [
        ({"uncertain": {"stack.radial.K9": 0.1}}, "stack.radial.K9"),
        ({"uncertain": {"roll_friction": -0.1}}, "uncertain.roll_friction"),
        ({"uncertain": {"winding_force": 0.1}}, "uncertain.winding_force"),
        ({"uncertain": 0.1}, "uncertain"),
        ({"web_tension": (400, 200)}, "web_tension"),
        ({"nip_load": 1000.0}, "nip_load"),
        ({"samples": 3}, "samples"),
        ({"resume": True}, "resume"),
    ],
)
def test_invalid_arguments_are_named(changes, field):
    with pytest.raises(wo.InvalidProblem) as fault:
        wo.operating_window(winding(), **{**RANGES, **changes})
    assert field in [name for name, _ in fault.value.faults]


T = (150.0, 450.0)


@pytest.mark.parametrize(
    ("ranges", "message"),
    [
        ({"web_tension": T}, "vary: web_tension given; must be the ranges of 2 or 3 fields"),
        ({}, "vary: none given; must be"),
        ({"web_tension": T, "vary": {"web_tension": T}}, "vary.web_tension: is given twice"),
        ({"web_tension": T, "vary": ["nip_load"]}, r"vary: .*nip_load.*; must be a Mapping"),
        ({"web_tension": T, "vary": {"oscillation": (0, 0.1)}}, "oscillation: has no effect"),
        ({"web_tension": T, "vary": {"oscillation": (-0.1, 0.1)}}, r"oscillation: -0.1 .*>= 0"),
        ({"web_tension": T, "vary": {"thickness_profile.variation": (1, 2)}}, "thickness_profile"),
        ({"web_tension": T, "vary": {"web.width": (1, 2)}}, "web.width: .*no"),
        ({"web_tension": T, "vary": {"web.material": (1, 2)}}, "web.material: .*not a number"),
        ({"web_tension": (0.0, 450.0), "nip_load": T}, r"web_tension: 0 .*>= 1e-06 .*\[N/m\]"),
        (
            {"web_tension": T, "vary": {"roll_friction": (0.1, 0.3)}},
            "uncertain.roll_friction: is a set point, which has no spread",
        ),
        (
            {**RANGES, "vary": {"roll_friction": (0.1, 0.3), "density": (500, 900)}},
            "vary: web_tension, nip_load, roll_friction and density given",
        ),
    ],
)
def test_set_points_that_are_rejected(ranges, message):
    with pytest.raises(wo.InvalidProblem, match=message):
        wo.operating_window(winding(), **ranges, uncertain={"roll_friction": 0.1})


@pytest.mark.parametrize(
    ("changes", "ranges", "message"),
    [
        (
            {"winding_force": wo.Profile(radius=[0.05, 0.15], value=[0, -50])},
            {"winding_force": (-50, -10)},
            "winding_force: is 0 at the core; must not be 0",
        ),
        (
            {"torque_split": wo.Steps(value=[0, 0.5], depth=[0.02])},
            {"torque_split": (0.1, 0.5)},
            "torque_split: is 0 at the core; must not be 0",
        ),
        ({}, {"tension_law": (300, 400)}, "tension_law: 'friction' is not a number"),
        (
            {"nip_load": 0.0},
            {"torque_split": (0, 0.5)},
            "torque_split: 0.5 is given",
        ),
        (
            {"nip_load": 0.0},
            {"winding_force": (-5, 5)},
            "winding_force: -5 is given",
        ),
        (
            {"density": None, "web_speed": 10.0},
            {"web_speed": (10, 20)},
            "web_speed: has no effect",
        ),
    ],
)
def test_schedules_that_have_no_set_point(changes, ranges, message):
    with pytest.raises(wo.InvalidProblem, match=message):
        wo.operating_window(winding(**changes), T, vary=ranges, uncertain={"core.stiffness": 0.1})


def test_spreads_may_be_in_percent():
    """As spread= of wo.compare and unknown= of wo.next_measurements."""
    spreads, _ = spreads_and_ties(winding(), {"roll_friction": "15 %", "nip_load": 0.05}, None)
    assert (spreads["roll_friction"], spreads["nip_load"]) == (0.15, 0.05)
    with pytest.raises(wo.InvalidProblem, match=r"uncertain.nip_load: '5 N/m' has the wrong dim"):
        spreads_and_ties(winding(), {"nip_load": "5 N/m"}, None)


def test_spreads_are_required_without_a_grade():
    problem = wo.WindingProblem.example()
    with pytest.raises(wo.InvalidProblem, match="uncertain: missing"):
        wo.operating_window(problem, **RANGES)
    with pytest.raises(wo.InvalidProblem, match="must be a WindingProblem"):
        wo.operating_window(wo.NipProblem.example(), **RANGES)


def test_a_problem_remembers_its_grade():
    problem = winding()
    assert problem.replace(nip_load=900.0).named_grade == wo.grade("newsprint")
    assert wo.WindingProblem.example().named_grade is None
    assert problem.named_grade.tied_fields(problem) == {
        "stack.tangential": "web.material.tangential"
    }


def test_margins_are_outputs_of_studies():
    """Invariance: the reserve of a sweep is that of the result."""
    problem = winding()
    data = wo.sweep(problem, {"nip_load": [1500.0]}, ["margins.strength", "margins.core"])
    result = wo.solve(problem)
    assert float(data["margins.strength"][0]) == result.margins["strength"].reserve
    assert np.isnan(float(data["margins.core"][0]))


@pytest.mark.slow
def test_friction_shares_replace_the_nips():
    """Independent method: a winding with the friction shares of its nips keeps its margins."""
    limits = wo.Limits(blocking_pressure=400e3, web_strength=STRENGTH)
    model = window_model(winding(tension_law="nip", limits=limits), {}, None)
    set_point = {"web_tension": 250.0, "nip_load": 1200.0}
    answer = model.run(set_point, None)
    count = len(answer.values) - len(model.depths)
    margins, shares = answer.values[:count], answer.values[count:]
    without_nips = model.run({**set_point, "friction_share": shares}, None)
    assert without_nips.state.nips_solved == 0
    assert answer.state.nips_solved > 0
    # 0.01: the reduced accuracy of the windings
    np.testing.assert_allclose(without_nips.values[:count], margins, atol=0.01)


# ---- windows of windings ------------------------------------------------------------------------


@pytest.fixture(scope="module")
def strength() -> wo.OperatingWindow:
    return wo.operating_window(winding(), **RANGES, uncertain={
        **dict.fromkeys(wo.grade("newsprint").spread_of(winding()), 0), "roll_friction": 0.3,
    }, workers=1)  # fmt: skip


@pytest.mark.slow
def test_the_probability_of_a_strength_margin(strength):
    """Closed form: T + mu N <= T_b, mu log-normal."""
    sigma = np.sqrt(np.log(1 + 0.3**2))
    for T, N in ((300.0, 2000.0), (400.0, 1500.0), (200.0, 2500.0), (420.0, 2800.0)):
        expected = norm.cdf(np.log((STRENGTH - T) / N / 0.19) / sigma)
        point = strength.at(T, N)
        # 0.03: interpolation in the set points and the second-order expansion in mu
        assert point.probability == pytest.approx(expected, abs=0.03), (T, N)
        assert point.contributions == {"roll_friction": 1.0}
    reserve, _ = strength.at(300.0, 2000.0).margins["strength"]
    assert reserve == pytest.approx(1 - (300 + 0.19 * 2000) / STRENGTH, abs=2e-3)


@pytest.mark.slow
def test_the_best_point_and_the_table(strength):
    best = strength.best
    assert best.probability == np.nanmax(strength.probability)
    table = strength.to_dataframe()
    assert len(table) == strength.probability.size
    assert set(table["binding"]) <= set(strength.margins)
    assert all(error < 0.1 for error in strength.errors.values())
    assert json.loads(strength.to_json())["windings"] == strength.windings
    with pytest.raises(wo.InvalidProblem, match="the range of the map"):
        strength.at(1000.0, 1500.0)
    for load, given, field in (
        (None, {}, "nip_load"), (2e3, {"seed": 1.5}, "seed"), (2e3, {"samples": 0}, "samples"),
    ):  # fmt: skip
        with pytest.raises(wo.InvalidProblem, match=f"{field}: "):
            strength.simulate(300.0, load, **given)


def test_without_uncertain_inputs_margins_hold_or_do_not():
    """Closed form: T + mu N <= T_b; no input dominates."""
    window = wo.operating_window(
        winding(radius=0.06), **RANGES, uncertain=dict.fromkeys(
            wo.grade("newsprint").spread_of(winding()), 0
        ), workers=1, options={"rtol": 0.02},
    )  # fmt: skip
    T, N = np.meshgrid(*window.axes, indexing="ij")
    holds = T + 0.19 * N < STRENGTH
    np.testing.assert_array_equal(window.probability, holds.astype(float))
    assert (window.dominant == -1).all()


@pytest.mark.slow
@pytest.mark.campaign
def test_monte_carlo_simulation_agrees():
    """Independent method: 128 windings with drawn inputs, three points."""
    problem = winding(limits=wo.Limits(blocking_pressure=400e3, compression=300e3), radius=0.3)
    window = wo.operating_window(problem, **RANGES, uncertain={
        "roll_friction": 0.15, "stack.radial.K1": 0.5, "stack.radial.K2": 0.3,
        "stack.poissons_ratio": 0, "density": 0, "drum_friction": 0, "stack.shear": 0,
        "web.material.radial": 0, "web.material.cross": 0, "web.material.shear": 0,
    }, workers=1)  # fmt: skip
    for T, N in ((200.0, 800.0), (250.0, 1200.0), (300.0, 2000.0)):
        simulated = window.simulate(T, N, samples=128, workers=1)
        # 0.05 is the requested agreement; Sobol points of 128 draws err by about 0.02
        assert window.at(T, N).probability == pytest.approx(simulated, abs=0.05), (T, N)


@pytest.mark.slow
@pytest.mark.campaign
def test_an_interrupted_window_is_resumed(strength, tmp_path: Path):
    """Invariance: the map is the same, and no winding is solved twice."""

    def stop(done: int, expected: int) -> None:
        if done > 14:
            raise KeyboardInterrupt

    options = {"uncertain": {**dict.fromkeys(wo.grade("newsprint").spread_of(winding()), 0),
                             "roll_friction": 0.3}, "workers": 1, "out": tmp_path}  # fmt: skip
    with pytest.raises(KeyboardInterrupt):
        wo.operating_window(winding(), **RANGES, **options, progress=stop)
    calls: list[int] = []
    resumed = wo.operating_window(
        winding(), **RANGES, **options, resume=True, progress=lambda done, _: calls.append(done)
    )
    assert min(calls) > 14  # of chunks of three windings
    np.testing.assert_array_equal(resumed.probability, strength.probability)


@pytest.mark.slow
@pytest.mark.campaign
def test_points_without_a_steady_state_are_not_mapped(tmp_path: Path):
    """Closed form: the drum slides where torque_split T > mu- N."""
    window = wo.operating_window(
        winding(torque_split=0.8), (200.0, 450.0), (600.0, 3000.0), workers=1,
        uncertain={"roll_friction": 0.3}, options={"rtol": 0.02},
    )  # fmt: skip
    T, N = np.meshgrid(*window.axes, indexing="ij")
    slides = 0.8 * T >= 0.2 * N
    assert slides.any()
    # next to a winding that failed for another reason the map may have gaps, but none of the
    # points where the drum slides has a value
    assert np.isnan(window.probability[slides]).all()
    assert np.isfinite(window.probability[~slides]).all()
    window.plot(tmp_path / "window.png")


@pytest.mark.slow
def test_the_command(tmp_path: Path, capsys):
    """With two set points that have options of their own, and any other field as a third one."""
    case = tmp_path / "board.toml"
    case.write_text(to_toml(BOARD), encoding="utf-8")
    code = main([
        "window", str(case), "--web-tension", "200 N/m:400 N/m", "--nip-load", "1000:3000",
        "--vary", "winding_force=-60:60", "--uncertain", "roll_friction=0.3",
        "--at", "300:2 kN/m:0", "--workers", "1", "--samples", "128",
        "--plot", str(tmp_path / "w.png"), "--csv", str(tmp_path / "w.csv"),
    ])  # fmt: skip
    text = capsys.readouterr().out
    assert code == 0
    assert text.startswith("highest probability")
    assert "at web_tension 300 N/m, nip_load 2000 N/m, winding_force 0 N/m" in text
    assert "variance of blocking: roll_friction 100 %" in text
    assert (tmp_path / "w.png").stat().st_size > 0
    header = (tmp_path / "w.csv").read_text("utf-8").splitlines()[0]
    assert header.startswith("web_tension [N/m],nip_load [N/m],winding_force [N/m],probability,")
    assert main(["window", str(case), "--vary", "nip_load=1:2", "--at", "1:2"]) == 2


def test_a_table_of_another_ending_is_rejected_before_the_windings(tmp_path: Path, capsys):
    case = tmp_path / "board.toml"
    case.write_text(to_toml(BOARD), encoding="utf-8")
    ranges = ["--web-tension", "200:400", "--nip-load", "1000:3000"]
    assert main(["window", str(case), *ranges, "--csv", str(tmp_path / "w.txt")]) == 2
    assert "the ending '.txt' is not a known format" in capsys.readouterr().err


@pytest.mark.slow
def test_a_third_set_point_is_in_the_heading_of_the_figure():
    window = wo.operating_window(
        BOARD, (200.0, 400.0), (1e3, 3e3), vary={"core.stiffness": ("0.5 GPa", "2 GPa")},
        uncertain={"roll_friction": 0.3}, samples=128, workers=1,
    )  # fmt: skip
    (panel,) = window_panels(window)
    # a nip load that is one number is not only that at the core
    assert panel.x.label == "web tension upstream of the nip, at the core"
    assert panel.y.label == "nip load"
    level = window.best.values["core.stiffness"]
    assert panel.heading == f"stiffness of the core (core) {1e-6 * level:.3g} MPa"
    assert window.probability.shape == (33, 33, 3)
