"""Compression tests of a stack: which rows are used, and the laws that are fitted to them.

Evidence: tests computed from known laws with known noise, in the columns of a testing machine.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pandas
import pytest

import woundon as wo
from woundon.cli.commands import main
from woundon.errors import InputWarning, InvalidProblem
from woundon.io.compression import branches_of, read_compression_test, rising_means

AREA, HEIGHT = 0.01, 0.02  # 100 cm^2, 20 mm
PAPER = wo.Pfeiffer(K1=10e3, K2=40.0)


def machine(law=PAPER, P=None, unload: bool = False, noise: float = 0.0, seed: int = 0):
    """Return the columns of a testing machine: load and deflection, loading and unloading."""
    P = np.linspace(0, 6e5, 300) if P is None else P
    if unload:
        P = np.concatenate([P, P[-2::-1]])
    eps = law.strain_at(P)
    rng = np.random.default_rng(seed)
    return {
        "Zeit [s]": np.arange(P.size) * 0.1,
        "Kraft [kN]": P * (1 + noise * rng.normal(size=P.size)) * AREA / 1e3,
        "Weg [mm]": (eps * HEIGHT + 0.5e-3) * 1e3,  # the machine has another origin
    }


# ---- reading ------------------------------------------------------------------------------------


def test_load_and_deflection_become_pressure_and_strain():
    test = read_compression_test(machine(), area="100 cm^2", height="20 mm")
    P, eps = test.used
    np.testing.assert_allclose(P, np.linspace(0, 6e5, 300), rtol=1e-12)
    np.testing.assert_allclose(eps, PAPER.strain_at(P) + 0.5e-3 / HEIGHT, rtol=1e-9)


def test_the_rising_branch_is_taken_and_the_other_is_named():
    test = read_compression_test(machine(unload=True), area=AREA, height=HEIGHT)
    assert test.account == (
        "used: loading in rows 1 to 300",
        "not used: unloading in rows 300 to 599",
        "3 rows of the branch are below the preload of 6 kPa",
    )
    unloading = read_compression_test(
        machine(unload=True), area=AREA, height=HEIGHT, branch="unloading"
    )
    assert unloading.is_used.nonzero()[0].tolist() == list(range(299, 596))


def test_of_several_cycles_the_first_to_the_largest_pressure_is_taken():
    half, full = np.linspace(0, 3e5, 50), np.linspace(0, 6e5, 100)
    P = np.concatenate([half, half[::-1], full, full[::-1], full])
    test = read_compression_test({"pressure": P, "strain": PAPER.strain_at(P)}, preload="20 kPa")
    assert test.account[0] == "used: loading in rows 100 to 200"
    assert len(branches_of(P)) == 5
    second = read_compression_test({"pressure": P, "strain": PAPER.strain_at(P)}, branch=5)
    assert second.account[0].startswith("used: loading in rows 30")
    with pytest.raises(InvalidProblem, match="9 is out of range; must be >= 1 and <= 5: 1: "):
        read_compression_test({"pressure": P, "strain": PAPER.strain_at(P)}, branch=9)


@pytest.mark.parametrize("rows", [300, 2000])
def test_noise_does_not_divide_a_branch(rows: int):
    rng = np.random.default_rng(3)
    for _ in range(40):
        P = np.linspace(0, 6e5, rows) * (1 + 0.03 * rng.normal(size=rows))
        assert [(each.start, each.end) for each in branches_of(P)] == [(0, rows)]


def test_compression_may_be_negative_and_the_load_cell_have_an_offset():
    table = machine()
    table["Kraft [kN]"] = -table["Kraft [kN]"] - 0.05
    table["Weg [mm]"] = -table["Weg [mm]"]
    test = read_compression_test(table, area=AREA, height=HEIGHT, offset="-50 N")
    P, eps = test.used
    np.testing.assert_allclose(P, np.linspace(0, 6e5, 300), atol=1e-6)
    assert np.all(np.diff(eps) > 0)
    assert "the sign of the load is reversed" in test.account[0]
    assert "the sign of the deflection is reversed" in test.account[1]


@pytest.mark.parametrize(
    ("change", "arguments", "words"),
    [
        ({}, {}, "area: missing; the load needs the area of the stack"),
        ({}, {"area": AREA}, "height: missing; the deflection needs the height"),
        ({}, {"area": "0 m^2", "height": HEIGHT},
         "area: '0 m^2' is out of range; must be >= 1e-06"),
        ({}, {"area": 1e-300, "height": HEIGHT},
         "area: 1e-300 is out of range; must be >= 1e-06 and <= 10 [m^2]"),
        ({}, {"area": AREA, "height": "20 um"},
         "height: '20 um' is out of range; must be >= 0.0001 and <= 10 [m]"),
        ({}, {"area": AREA, "height": "0.1 mm"},
         "is out of range; must be < 1, at which the stack has no thickness left; check the units"),
        ({"Kraft [kN]": None}, {}, "has no column pressure or force; its columns are"),
        ({"pressure [Pa]": np.arange(300.0)}, {"area": AREA}, "area: is given, but the file has"),
        ({}, {"area": AREA, "height": HEIGHT, "branch": "up"}, "branch: 'up' is unknown; must be"),
        ({}, {"area": AREA, "height": HEIGHT, "preload": "1 GPa"}, "must have at least 4"),
    ],
)  # fmt: skip
def test_a_test_that_cannot_be_read_is_rejected_with_the_remedy(change, arguments, words):
    table = {name: cells for name, cells in (machine() | change).items() if cells is not None}
    with pytest.raises(InvalidProblem) as fault:
        read_compression_test(table, **arguments)
    assert words in str(fault.value)


@pytest.mark.parametrize(
    ("origin", "words"),
    [
        (0.0, "row 5: strain 9.8 is out of range; must be < 1, .* percent need their unit, '%'"),
        (-12.0, "row 5: strains from -10.3 to -2.2 is out of range; must be within a range < 1"),
    ],
)
def test_strains_of_a_stack_without_thickness_are_rejected(tmp_path: Path, origin, words):
    """The strains of the example of StackTest in percent, without their unit."""
    path = tmp_path / "stack.csv"
    rows = zip([10, 50, 200, 500], [1.7, 4.5, 7.6, 9.8], strict=True)
    lines = ["pressure [kPa],strain [1]", *(f"{P},{eps + origin:.1f}" for P, eps in rows)]
    path.write_text("\n".join(lines))
    with pytest.raises(InvalidProblem, match=words):
        wo.fit_stack(path)


def test_noisy_rows_are_averaged_to_rising_ones():
    rng = np.random.default_rng(1)
    P = np.linspace(6e3, 6e5, 400) * (1 + 0.02 * rng.normal(size=400))
    eps = PAPER.strain_at(np.linspace(6e3, 6e5, 400))
    means = rising_means(P, eps)
    law = wo.StackTest(pressure=means[0], strain=means[1])
    at = np.array([5e4, 2e5, 4e5])
    # 2 % of the pressure in groups of 7 rows: 1 % of the pressure, about as much of the modulus
    # between knots that are 8 groups apart
    np.testing.assert_allclose(law.modulus(at), PAPER.modulus(at), rtol=0.1)


# ---- fits ---------------------------------------------------------------------------------------


def test_the_laws_of_exact_tests_are_found():
    for name, law in LAWS.items():
        found = wo.fit_stack(machine(law), area=AREA, height=HEIGHT)
        assert found.best.name == name
        for field in type(law).model_fields:
            # the strains are exact to 1e-12; a quadratic term is 1e-3 of the modulus
            fitted = getattr(found.best.law, field)
            np.testing.assert_allclose(fitted, getattr(law, field), rtol=1e-4)
        assert found.best.origin == pytest.approx(0.5e-3 / HEIGHT, rel=1e-4)


LAWS = {
    "pfeiffer": PAPER,
    "power_law": wo.PowerLaw(E0=5e5, k=1.2e7, m=0.7),
    "polynomial": wo.Polynomial(coefficients=[6e5, 45.0, 2e-5]),
    "constant": wo.fit_stack({"pressure": [1e3, 2e3, 3e3, 4e3, 5e3],
                              "strain": [1e-4, 2e-4, 3e-4, 4e-4, 5e-4]}).law("constant").law,
}  # fmt: skip


def random_law(kind: str, rng: np.random.Generator):
    """Return a law of paper or film, and its parameters in the order of the fit."""
    if kind == "pfeiffer":
        law = wo.Pfeiffer(K1=10 ** rng.uniform(3.3, 4.6), K2=rng.uniform(20, 120))
        return law, [law.K1, law.K2]
    if kind == "power_law":
        law = wo.PowerLaw(
            E0=10 ** rng.uniform(5.3, 6.3), k=10 ** rng.uniform(6.5, 7.5), m=rng.uniform(0.5, 1.1)
        )
        return law, [law.E0, law.k, law.m]
    c = [10 ** rng.uniform(5.5, 6.3), rng.uniform(20, 80), 10 ** rng.uniform(-5.5, -4.5)]
    return wo.Polynomial(coefficients=c), c


@pytest.mark.slow
def test_parameters_are_within_two_standard_errors_in_90_to_99_percent():
    """50 random laws with 2 % noise of the load: 133 parameters, of which 95 % are expected."""
    rng = np.random.default_rng(50)
    kinds = [("pfeiffer", "power_law", "polynomial")[k % 3] for k in range(50)]
    inside = []
    for kind in kinds:
        law, exact = random_law(kind, rng)
        P = np.linspace(0, 6e5, 200)
        table = machine(law, P, noise=0.02, seed=int(rng.integers(1 << 30)))
        fit = wo.fit_stack(table, area=AREA, height=HEIGHT).law(kind)
        errors = np.abs(np.array(list(fit.values.values())) - exact)
        inside += (errors <= 2 * np.array(list(fit.errors.values()))).tolist()
    assert 0.90 <= np.mean(inside) <= 0.99


def test_the_standard_error_is_that_of_repeated_tests():
    """The spread of the estimates of 60 tests of one law, which is known to 9 %."""
    fits = [
        wo.fit_stack(machine(noise=0.02, seed=seed), area=AREA, height=HEIGHT).law("pfeiffer")
        for seed in range(60)
    ]
    estimates = np.array([[*fit.values.values(), fit.origin] for fit in fits])
    errors = np.array([[*fit.errors.values(), fit.origin_error] for fit in fits])
    # three standard errors of the spread
    np.testing.assert_allclose(errors.mean(axis=0), estimates.std(axis=0, ddof=1), rtol=0.3)


def test_laws_that_follow_a_test_equally_well_are_named():
    found = wo.fit_stack(machine(noise=0.02), area=AREA, height=HEIGHT)
    misfits = [each.misfit for each in found.laws]
    assert misfits == sorted(misfits)
    assert found.laws[-1].name == "constant"
    assert any("the test as well as" in text for text in found.remarks())


def test_a_long_test_is_averaged():
    P = np.linspace(0, 6e5, 50_000)
    found = wo.fit_stack(machine(P=P, noise=0.02), area=AREA, height=HEIGHT).law("pfeiffer")
    assert found.values["K2"] == pytest.approx(40.0, rel=0.01)


# ---- command, case file, figure -----------------------------------------------------------------


def test_the_command_prints_the_laws_and_the_table_of_a_case(tmp_path: Path, capsys):
    pandas.DataFrame(machine(unload=True)).to_csv(
        tmp_path / "test.csv", sep=";", decimal=",", index=False
    )
    arguments = ["stack", str(tmp_path / "test.csv"), "--area", "100 cm^2", "--height", "20 mm"]
    picture = ["--plot", str(tmp_path / "test.png"), "--save", str(tmp_path / "laws.csv")]
    assert main([*arguments, *picture]) == 0
    out = capsys.readouterr().out
    assert "not used: unloading in rows 301 to 600" in out
    assert '[stack.radial]\nkind = "pfeiffer"\nK1 = ' in out
    assert (tmp_path / "test.png").stat().st_size > 10_000
    saved = pandas.read_csv(tmp_path / "laws.csv")
    assert set(saved["law"]) == {"pfeiffer", "power_law", "polynomial", "constant"}
    assert main([*arguments, "--json"]) == 0
    record = json.loads(capsys.readouterr().out)
    assert record["laws"][0]["values"]["K1"] == pytest.approx(10e3, rel=1e-3)


@pytest.mark.parametrize("preload", ["", "preload = 0\n"])
def test_a_case_file_takes_a_law_from_load_and_deflection(tmp_path: Path, preload: str):
    pandas.DataFrame(machine(unload=True)).to_csv(tmp_path / "test.csv", index=False)
    case = (
        'schema = 1\nradius = 0.5\nweb_thickness = "66 um"\nwound_on_tension = "400 N/m"\n'
        "core = {radius = 0.05, stiffness = 1e9}\n"
        '[stack]\ntangential = "3.38 GPa"\npoissons_ratio = 0.01\nshear = "10 MPa"\n'
        '[stack.radial]\ncsv = "test.csv"\narea = "100 cm^2"\nheight = "20 mm"\n'
        f"{preload}"
    )
    (tmp_path / "case.toml").write_text(case, encoding="utf-8")
    with pytest.warns(InputWarning, match="not used: unloading in rows 301 to 600"):
        problem = wo.load_case(tmp_path / "case.toml")
    law = problem.stack.radial
    assert isinstance(law, wo.StackTest)
    assert law.modulus(2e5) == pytest.approx(PAPER.modulus(2e5), rel=0.01)


def test_the_figure_shows_used_and_other_rows_and_all_laws():
    found = wo.fit_stack(machine(unload=True, noise=0.01), area=AREA, height=HEIGHT)
    strains, moduli = found.plot().axes
    labels = [line.get_label() for line in strains.lines]
    assert labels[:2] == ["rows left out", "rows"]
    assert len(labels) == 2 + 4
    assert len(moduli.lines) == 4
    (legend,) = moduli.figure.legends  # of both panels
    assert [text.get_text() for text in legend.get_texts()] == labels
