"""Wound rolls: graded, frozen or estimated; their profiles and case files; what is refused."""

from __future__ import annotations

import itertools
import tomllib
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from own_mesh import own_tension
from refusals import refused_in_one_line
from seldom import seldom

import woundon as wo
from woundon.contact.schemes import Graded
from woundon.elasticity.layers import stacked_compliance
from woundon.io.case_files import make_problem, read_case, to_toml
from woundon.problems.graded import _peak, graded_layers, wound_kernels

EXAMPLE = wo.NipProblem.example()
PAPER = wo.Stack(
    radial=wo.Pfeiffer(K1=10e3, K2=127), tangential=3.38e9, poissons_ratio=0.01, shear=10e6
)
# a plateau, soft at the surface
GRADED = wo.Profile(radius=[0.0445, 0.06, 0.09, 0.1], value=[400e3, 200e3, 200e3, 20e3])
LEVEL = wo.Profile(radius=[0.05, 0.08], value=[200e3, 200e3])


def roll(**changes: Any) -> wo.WoundRoll:
    fields: dict[str, Any] = {
        "radius": 0.1, "core_radius": 0.0445, "stack": PAPER, "pressure": 200e3,
        "hardening": "frozen",
    }  # fmt: skip
    return wo.WoundRoll(**fields | changes)


def outputs(problem: wo.NipProblem, **options: Any) -> np.ndarray:
    result = wo.solve(problem, nodes=49, **options)
    return np.array([own_tension(result), result.half_width, result.drum_creep])


def cylinder(P: float, wound: float) -> wo.Cylinder:
    rr, tt, rt, shear, _ = PAPER.tangent(P, wound)
    material = wo.Orthotropic(radial=rr, tangential=tt, cross=rt, shear=shear)
    return wo.Cylinder(radius=0.1, core_radius=0.0445, material=material)


# ---- frozen -------------------------------------------------------------------------------------


@pytest.mark.parametrize("pressure", [200e3, LEVEL], ids=["a number", "a level profile"])
def test_of_one_pressure_it_is_a_cylinder(pressure: Any) -> None:
    expected = outputs(EXAMPLE.replace(roll=cylinder(200e3, 200e3)))
    found = outputs(EXAMPLE.replace(roll=roll(pressure=pressure)))
    np.testing.assert_allclose(found, expected, rtol=1e-10)


@pytest.mark.parametrize("hardening", ["frozen", "estimate"])
def test_of_a_constant_law_it_is_a_cylinder(hardening: str) -> None:
    rr, tt, rt, shear, _ = wo.material("newsprint").stiffness
    linear = wo.Stack(
        radial=rr * (1 - rt**2 / (rr * tt)), tangential=tt - rt**2 / rr, poissons_ratio=rt / rr,
        shear=shear,
    )  # fmt: skip
    made = roll(stack=linear, hardening=hardening)
    # what is found by linearisation anew takes another way to a load that is met to 3e-9
    rtol = 1e-10 if made.linear else 3e-9
    np.testing.assert_allclose(outputs(EXAMPLE.replace(roll=made)), outputs(EXAMPLE), rtol=rtol)


def test_cells_converge_with_the_fourth_order() -> None:
    n = np.geomspace(2, 300, 12)
    graded = roll(pressure=GRADED)
    Y = [stacked_compliance(n, graded_layers(graded, parts)) for parts in (1, 2, 4)]
    size = np.abs(Y[-1]).max(axis=(0, 1))
    first, second = (np.max(np.abs(a - b) / size) for a, b in itertools.pairwise(Y))
    assert first < 1e-6
    assert first / second > 10
    told = wound_kernels(graded).truncation_error
    assert first < told < 1e-4


def test_layers_of_a_gradient_by_hand() -> None:
    """Many thin layers, the modulus in the middle of each: another way to the same compliance."""
    graded = roll(pressure=GRADED)
    ends = np.log(0.1 / np.array([0.1, 0.09, 0.06, 0.0445]))
    y = np.unique(np.concatenate([np.linspace(a, b, 1200) for a, b in itertools.pairwise(ends)]))
    P = GRADED.at(0.1 * np.exp(-(y[1:] + y[:-1]) / 2))
    layers = tuple(zip(np.diff(y), *np.broadcast_arrays(*PAPER.tangent(P)[:4]), strict=True))
    n = np.geomspace(2, 60, 6)
    by_hand = stacked_compliance(n, layers)
    found = stacked_compliance(n, graded_layers(graded))
    assert np.max(np.abs(found / by_hand - 1)) < 2e-5  # of the many layers, second order


def test_a_soft_surface_makes_a_wide_nip() -> None:
    """A wound pressure that falls to the surface acts more like that of the surface."""
    soft, hard = (outputs(EXAMPLE.replace(roll=roll(pressure=P)))[1] for P in (20e3, 200e3))
    between = outputs(EXAMPLE.replace(roll=roll(pressure=GRADED)))[1]
    assert hard < between < soft


def test_it_rolls_in_wrapped_nips_and_against_rollers() -> None:
    problem = EXAMPLE.replace(roll=roll(pressure=GRADED))
    assert wo.solve(problem.wrapped(), nodes=33).residuals.largest <= 1e-8
    pair = wo.RollerProblem(upper=roll(pressure=GRADED), lower=wo.Rigid(radius=0.2), load=2e3,
                            friction=0.2, tangential_load=100.0)  # fmt: skip
    assert wo.solve(pair, nodes=49).residuals.largest <= 1e-8


@pytest.mark.parametrize(
    ("name", "value"), [seldom("roll.stack.radial.K2", 127.0), ("roll.pressure.value.3", 20e3)]
)
def test_sensitivities_of_a_frozen_roll(name: str, value: float) -> None:
    problem = EXAMPLE.replace(roll=roll(pressure=GRADED))
    result = wo.solve(problem, nodes=25)
    slope = result.sensitivity(name).derivative("half_width", name)
    step = 1e-3 * value
    up, down = (
        wo.solve(problem.replace(**{name: value + sign * step}), nodes=25, start=result)
        for sign in (1, -1)
    )
    by_differences = (up.half_width - down.half_width) / (2 * step)
    assert slope == pytest.approx(by_differences, rel=1e-4)


# ---- estimate -----------------------------------------------------------------------------------


def test_the_estimate_is_the_cylinder_it_says() -> None:
    estimate = wo.solve(EXAMPLE.replace(roll=roll(hardening="estimate")), nodes=49)
    mean = np.trapezoid(estimate.pressure, estimate.x)
    h, p = np.diff(estimate.x), estimate.pressure
    square = h @ (p[1:] ** 2 + p[1:] * p[:-1] + p[:-1] ** 2) / 3
    peak = 3 * np.pi / 8 * square / mean
    assert peak == pytest.approx(estimate.peak_pressure, rel=0.02)
    linear = EXAMPLE.replace(roll=cylinder(200e3 + 0.3 * peak, 200e3))
    expected = wo.solve(linear, nodes=49)
    assert own_tension(estimate) == pytest.approx(own_tension(expected), rel=1e-7)
    assert estimate.residuals.largest <= 1e-8


def test_the_estimate_is_smooth_in_the_parameters() -> None:
    """Second differences fall as they should: no switch from node to node."""
    problem = EXAMPLE.replace(roll=roll(hardening="estimate"))
    found = [
        outputs(problem.replace(**{"roll.stack.radial.K2": 127 * (1 + 1e-3 * k)}))[1]
        for k in range(5)
    ]
    second = np.diff(found, 2)
    assert np.max(np.abs(second)) < 1e-5 * found[0]
    assert np.ptp(second) < 1e-7 * found[0]


def test_peak_of_a_half_ellipse() -> None:
    x = Graded().mesh(257).columns
    peak, growth = _peak(x, 3e5 * np.sqrt(1 - x**2))
    assert peak == pytest.approx(3e5, rel=1e-4)
    assert growth @ (3e5 * np.sqrt(1 - x**2)) == pytest.approx(1)  # of the first degree
    assert _peak(x, np.zeros(x.size))[0] == 0.0


def test_the_estimate_answers_with_its_tangent() -> None:
    mesh, body, a = Graded().mesh(25), roll(hardening="estimate"), 2e-3
    rng = np.random.default_rng(3)
    p = 5e5 * np.sqrt(1 - mesh.columns**2) * (1 + 0.2 * mesh.columns)
    q = rng.normal(0, 1e5, p.size)
    response = body.respond(mesh, a, wo.Tractions(p, q))

    def told(p: np.ndarray, q: np.ndarray) -> list[np.ndarray]:
        """Slope, strain and displacements by the matrices about these loads themselves."""
        own = body.respond(mesh, a, wo.Tractions(p, q))
        v_p, v_q, w_p, w_q = own.gradients
        (n_p, n_q), (t_p, t_q), rest = own.normal(), own.tangent(), own.rest()
        return [
            own.slope + v_p @ p + v_q @ q, own.strain + w_p @ p + w_q @ q,
            rest[0] + n_p @ p + n_q @ q, rest[1] + t_p @ p + t_q @ q,
        ]  # fmt: skip

    peak, _ = _peak(mesh.columns, p)
    linear = cylinder(200e3 + 0.3 * peak, 200e3).respond(mesh, a)
    np.testing.assert_allclose(told(p, q)[0], linear.gradients[0] @ p + linear.gradients[1] @ q,
                               rtol=1e-11, atol=1e-11 * 1e-3)  # fmt: skip
    dp, dq = rng.normal(0, 1e5, (2, p.size))
    step = 1e-3
    up, down = told(p + step * dp, q + step * dq), told(p - step * dp, q - step * dq)
    v_p, v_q, w_p, w_q = response.gradients
    maps = [(v_p, v_q), (w_p, w_q), response.normal(), response.tangent()]
    made = [by_p @ dp + by_q @ dq for by_p, by_q in maps]
    for plus, minus, tangent in zip(up, down, made, strict=True):
        by_differences = (plus - minus) / (2 * step)
        # errors of both differences, 1e-4^2 and 1e-3^2 of a changing modulus
        assert np.max(np.abs(by_differences - tangent)) < 1e-6 * np.max(np.abs(tangent))


def test_sensitivities_of_the_estimate() -> None:
    problem = EXAMPLE.replace(roll=roll(hardening="estimate"))
    result = wo.solve(problem, nodes=49)
    for name, value in (("roll.stack.radial.K2", 127.0), ("roll.pressure", 200e3)):
        up, down = (
            wo.solve(problem.replace(**{name: value * (1 + 1e-3 * sign)}), nodes=49, start=result)
            for sign in (1, -1)
        )
        by_differences = (up.half_width - down.half_width) / (2e-3 * value)
        slope = result.sensitivity(name).derivative("half_width", name)
        assert slope == pytest.approx(by_differences, rel=1e-4), name


def test_what_is_no_full_answer_says_so() -> None:
    told = {"estimate": "an estimate", "frozen": "too soft under the nip"}
    for hardening, words in told.items():
        problem = EXAMPLE.replace(roll=roll(hardening=hardening))
        result = wo.solve(problem, nodes=33)
        assert any(words in warning for warning in result.warnings)
        assert words in str(result)


# ---- refused ------------------------------------------------------------------------------------

ESTIMATE = {"hardening": "estimate"}


@pytest.mark.parametrize(
    ("make", "told"),
    [
        (lambda: roll(pressure=-1.0), "pressure: -1 is out of range; must be >= 0 and < "),
        (lambda: roll(pressure="much"), "pressure: 'much' is not a number; must be a number [Pa] "),
        (
            lambda: roll(pressure=wo.Profile(radius=[0.05, 0.1], value=[2e5, -3.0])),
            "pressure.value.1: -3 is out of range; must be >= 0 and < ",
        ),
        (
            lambda: roll(pressure={"radius": [0.1, 0.05], "value": [2e5, 2e5]}),
            "pressure.radius.1: 0.05 is out of range; must be > 0.1 [m], the radius before it",
        ),
        (
            lambda: roll(pressure={"radius": [0.05, 0.1], "value": [2e5]}),
            "pressure.value: 1 values; must be at least 2",
        ),
        (
            lambda: roll(pressure={"radius": [0.05, 0.1, 0.2], "value": [2e5, 2e5]}),
            "pressure.value: 2 values; must be as many as of radius, 3",
        ),
        (
            lambda: roll(stack=PAPER.replace(poissons_ratio=8.0, tangential=1e9)),
            "pressure: 200000 is out of range; must be >= 0 and < 113031 [Pa], where the stack",
        ),
        (
            lambda: roll(stack=PAPER.replace(radial=wo.Polynomial(coefficients=[1e6, -8.0]))),
            "pressure: 200000 is out of range; must be >= 0 and < ",
            ),
        (lambda: roll(core_radius=0.2), "core_radius: 0.2 is out of range; must be >= 1e-09 *"),
        (lambda: roll(hardening="linear"), "hardening: 'linear' is unknown; must be 'direct', 'es"),
        (
            lambda: roll(stack=PAPER.replace(shear_exponent=0.5), **ESTIMATE),
            "hardening: 'estimate' is out of place where the shear modulus hardens",
        ),
        (
            lambda: roll(pressure=50e3, **ESTIMATE),
            "hardening: 'estimate' needs a stack of E_r/E_r' >= 100000 [Pa] at the surface (K1 + P0"
            " of Pfeiffer's law), and it is 60000; must be 'direct' or 'frozen'",
        ),
        (
            lambda: EXAMPLE.replace(roll=roll(**ESTIMATE)).wrapped(),
            "roll.hardening: 'estimate' is for a nip without wraps only; must be 'direct' or 'fro",
        ),
        (
            lambda: wo.RollerProblem(upper=roll(**ESTIMATE), lower=wo.Rigid(radius=0.2), load=2e3,
                                     friction=0.2),
            "upper.hardening: 'estimate' is for a nip without wraps only",
        ),
    ],
)  # fmt: skip
def test_refused_with_one_line(make: Any, told: str) -> None:
    refused_in_one_line(make, told)


# ---- case files ---------------------------------------------------------------------------------

CASE = """\
schema = 1
roll_friction = 0.19
drum_friction = 0.2
nip_load = "3.5 kN/m"
drum = {radius = "76.2 mm"}
web = {thickness = "66 um", material = "newsprint"}

[roll]
radius = "100 mm"
core_radius = "44.5 mm"
hardening = "frozen"
pressure = "200 kPa"

[roll.stack]
tangential = "3.38 GPa"
poissons_ratio = 0.01
shear = "10 MPa"
radial = {K1 = "10 kPa", K2 = 127}
"""


def case(text: str, folder: Path) -> Any:
    path = folder / "case.toml"
    path.write_text(text)
    return make_problem(read_case(path))


@pytest.mark.parametrize("comments", [False, True])
@pytest.mark.parametrize("pressure", [200e3, GRADED], ids=["a number", "a profile"])
def test_case_files_come_back(pressure: Any, comments: bool, tmp_path: Path) -> None:
    plain = case(CASE, tmp_path)
    assert plain.roll == roll()
    problem = plain.replace(**{"roll.pressure": pressure})
    text = to_toml(problem, comments)
    assert make_problem(tomllib.loads(text)) == problem
    if pressure is GRADED:  # values have the unit of the field that they are of
        assert '"200 kPa"' in text


def test_a_profile_has_the_unit_of_its_field(tmp_path: Path) -> None:
    table = '\n[roll.pressure]\nradius = ["50 mm", 0.1]\nvalue = ["2 bar", 1e5]\n'
    problem = case(CASE.replace('pressure = "200 kPa"\n', "") + table, tmp_path)
    assert problem.roll.pressure == wo.Profile(radius=[0.05, 0.1], value=[2e5, 1e5])
    bad = table.replace("2 bar", "2 mm")
    with pytest.raises(wo.InvalidProblem, match=r"roll\.pressure\.value\.0: '2 mm' has the wrong"):
        case(CASE.replace('pressure = "200 kPa"\n', "") + bad, tmp_path)


def test_columns_from_a_csv_file(tmp_path: Path) -> None:
    P = np.linspace(0, 800, 9)
    e = 100 * np.log1p(P / 20) / 30
    rows = "\n".join(f"{p:.10g},\t{s:.10g}" for p, s in zip(P, e, strict=True))
    (tmp_path / "test.csv").write_text(f"# measured\npressure [kPa], strain [%]\n{rows}\n")
    text = CASE.replace('radial = {K1 = "10 kPa", K2 = 127}', 'radial = {csv = "test.csv"}')
    problem = case(text, tmp_path)
    law = problem.roll.stack.radial
    assert isinstance(law, wo.StackTest)
    np.testing.assert_allclose(law.pressure, 1e3 * P)
    np.testing.assert_allclose(law.strain, e / 100, rtol=1e-9)
    assert make_problem(tomllib.loads(to_toml(problem))) == problem
    assert law.misfit < 1e-6
    # decimal commas, semicolons between
    rows = rows.replace(",\t", ";").replace(".", ",")
    (tmp_path / "test.csv").write_text(f"pressure [kPa];strain [%]\n{rows}\n")
    assert case(text, tmp_path) == problem


@pytest.mark.parametrize(
    ("content", "told"),
    [
        ("pressure [kPa], strain\n", "test.csv: holds no header with rows below it"),
        ("pressure [kPa], strain\n1, 2\n3\n", "test.csv: row 2 has 1 cells, the header 2"),
        ("strain, strain\n1, 2\n", "test.csv: two columns are 'strain'"),
        ("pressure [kPa], kind\n1, 2\n", "test.csv: has a column 'kind', which the case gives"),
        ("pressure [mm], strain\n" + "1, 2\n" * 4, "radial.pressure.0: '1 mm' has the wrong dim"),
        ("pressure [kPa], strain\n1, x\n2, 3\n3, 4\n4, 5", "radial.strain.0: 'x' is"),
        ("pressure [kPa], stress\n" + "1, 2\n" * 4, "stress: no such field"),
        (None, "test.csv: cannot be read"),
    ],
)
def test_columns_that_cannot_be_read(content: str | None, told: str, tmp_path: Path) -> None:
    if content is not None:
        (tmp_path / "test.csv").write_text(content)
    text = CASE.replace('radial = {K1 = "10 kPa", K2 = 127}',
                        'radial = {kind = "stack_test", csv = "test.csv"}')  # fmt: skip
    with pytest.raises(wo.InvalidProblem) as report:
        case(text, tmp_path)
    assert told in str(report.value)


def test_a_poor_fit_of_a_test_is_told() -> None:
    P = np.linspace(0, 8e5, 6)
    e = np.log1p(P / 2e4) / 30 + np.array([0, 0.01, -0.01, 0.01, -0.01, 0.01])
    law = wo.StackTest(pressure=P, strain=np.sort(e) + 1e-4 * np.arange(6))
    assert law.misfit > 0.01
    assert "its stack test is fitted to" in roll(stack=PAPER.replace(radial=law)).caution


def test_saved_and_loaded(tmp_path: Path) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        result = wo.solve(EXAMPLE.replace(roll=roll(pressure=GRADED)), nodes=33)
    result.save(tmp_path / "nip.nc")
    again = wo.load_result(tmp_path / "nip.nc")
    assert again.problem == result.problem
    assert again.certified().largest <= 1e-8
