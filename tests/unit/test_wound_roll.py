"""Wound rolls: graded, frozen or estimated; their profiles and case files; what is refused."""

from __future__ import annotations

import itertools
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from derivatives import check_sensitivity
from thesis_cases import newsprint_nip

import woundon as wo
from woundon.elasticity.layers import stacked_compliance
from woundon.io.case_files import make_problem, read_case, to_toml
from woundon.problems.graded import graded_layers, wound_kernels

EXAMPLE = newsprint_nip()
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
    return np.array([result.nip_induced_tension, result.half_width, result.drum_creepage])


def cylinder(P: float, wound: float) -> wo.Cylinder:
    rr, tt, rt, shear, _ = PAPER.tangent(P, wound)
    material = wo.Orthotropic(radial=rr, tangential=tt, cross=rt, shear=shear)
    return wo.Cylinder(radius=0.1, core_radius=0.0445, material=material)


def wound(body: wo.WoundRoll) -> tuple[Any, ...]:
    return body.radius, body.core_radius, body.stack, body.pressure


# ---- frozen -------------------------------------------------------------------------------------


@pytest.mark.parametrize("pressure", [200e3, LEVEL], ids=["a number", "a level profile"])
def test_of_one_pressure_it_is_a_cylinder(pressure: Any) -> None:
    expected = outputs(EXAMPLE.replace(roll=cylinder(200e3, 200e3)))
    found = outputs(EXAMPLE.replace(roll=roll(pressure=pressure)))
    np.testing.assert_allclose(found, expected, rtol=1e-10)


def test_cells_converge_with_the_fourth_order() -> None:
    n = np.geomspace(2, 300, 12)
    graded = roll(pressure=GRADED)
    Y = [stacked_compliance(n, graded_layers(*wound(graded), parts)) for parts in (1, 2, 4)]
    size = np.abs(Y[-1]).max(axis=(0, 1))
    first, second = (np.max(np.abs(a - b) / size) for a, b in itertools.pairwise(Y))
    assert first < 1e-6
    assert first / second > 10
    estimate = wound_kernels(*wound(graded)).truncation_error
    assert first < estimate < 1e-4


def test_layers_of_a_gradient_by_hand() -> None:
    """Many thin layers, the modulus in the middle of each: another way to the same compliance."""
    graded = roll(pressure=GRADED)
    ends = np.log(0.1 / np.array([0.1, 0.09, 0.06, 0.0445]))
    y = np.unique(np.concatenate([np.linspace(a, b, 1200) for a, b in itertools.pairwise(ends)]))
    P = GRADED.at(0.1 * np.exp(-(y[1:] + y[:-1]) / 2))
    layers = tuple(zip(np.diff(y), *np.broadcast_arrays(*PAPER.tangent(P)[:4]), strict=True))
    n = np.geomspace(2, 60, 6)
    by_hand = stacked_compliance(n, layers)
    found = stacked_compliance(n, graded_layers(*wound(graded)))
    assert np.max(np.abs(found / by_hand - 1)) < 2e-5  # of the many layers, second order


def test_a_soft_surface_makes_a_wide_nip() -> None:
    """A wound pressure that falls to the surface acts more like that of the surface."""
    soft, hard = (outputs(EXAMPLE.replace(roll=roll(pressure=P)))[1] for P in (20e3, 200e3))
    between = outputs(EXAMPLE.replace(roll=roll(pressure=GRADED)))[1]
    assert hard < between < soft


@pytest.mark.slow
@pytest.mark.parametrize("name", ["roll.stack.radial.K2", "roll.pressure.value.3"])
def test_sensitivities_of_a_frozen_roll(name: str) -> None:
    result = wo.solve(EXAMPLE.replace(roll=roll(pressure=GRADED)), nodes=25)
    check_sensitivity(result, [name], ["half_width"], rtol=1e-4)


def test_what_is_no_full_answer_says_so() -> None:
    result = wo.solve(EXAMPLE.replace(roll=roll()), nodes=33)
    words = "without hardening in the nip: too soft"
    assert any(words in warning for warning in result.warnings)
    assert words in str(result)


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
radial = {csv = "test.csv"}
"""


def case(text: str, folder: Path) -> Any:
    path = folder / "case.toml"
    path.write_text(text)
    return make_problem(read_case(path))


def test_columns_from_a_csv_file(tmp_path: Path) -> None:
    P = np.linspace(0, 800, 9)
    e = 100 * np.log1p(P / 20) / 30
    rows = "\n".join(f"{p:.10g},\t{s:.10g}" for p, s in zip(P, e, strict=True))
    (tmp_path / "test.csv").write_text(f"# measured\npressure [kPa], strain [%]\n{rows}\n")
    problem = case(CASE, tmp_path)
    law = problem.roll.stack.radial
    assert isinstance(law, wo.StackTest)
    np.testing.assert_allclose(law.pressure, 1e3 * P)
    np.testing.assert_allclose(law.strain, e / 100, rtol=1e-9)
    assert make_problem(tomllib.loads(to_toml(problem))) == problem
    assert law.misfit < 1e-6
    # decimal commas, semicolons between
    rows = rows.replace(",\t", ";").replace(".", ",")
    (tmp_path / "test.csv").write_text(f"pressure [kPa];strain [%]\n{rows}\n")
    assert case(CASE, tmp_path) == problem


TESTED = {
    "header [kPa], [%]": "pressure [kPa],strain [%]\n10,1.7\n50,4.5\n200,7.6\n500,9.8\n",
    "row of units": "Pressure;Strain\nkPa;%\n10;1,7\n50;4,5\n200;7,6\n500;9,8\n",
    "cells": "pressure;strain\n10 kPa;1,7 %\n50 kPa;4,5 %\n0,2 MPa;7,6 %\n500 kPa;9,8 %\n",
    "fractions": "pressure (kPa)\tstrain\n10\t0.017\n50\t0.045\n200\t0.076\n500\t0.098\n",
}


@pytest.mark.parametrize("name", TESTED)
def test_units_of_columns_of_a_case_are_those_of_tables(name: str, tmp_path: Path) -> None:
    (tmp_path / "test.csv").write_text(TESTED[name])
    law = case(CASE, tmp_path).roll.stack.radial
    # exact fractions, rounded once
    assert law.pressure == (10e3, 50e3, 200e3, 500e3)
    assert law.strain == (0.017, 0.045, 0.076, 0.098)


def test_percentages_of_an_excel_file_in_a_case(tmp_path: Path) -> None:
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    book.active.append(["pressure [kPa]", "strain [%]"])
    for row in ((10, 0.017), (50, 0.045), (200, 0.076), (500, 0.098)):
        book.active.append(row)
        book.active.cell(book.active.max_row, 2).number_format = "0.0%"
    book.save(tmp_path / "test.xlsx")
    text = CASE.replace("test.csv", "test.xlsx")
    assert case(text, tmp_path).roll.stack.radial.strain == (0.017, 0.045, 0.076, 0.098)


@pytest.mark.parametrize(
    ("table", "reason"),
    [
        ("pressure,strain\n10,0.017\n50,0.045\n", "column 'pressure': has no unit"),
        ("10.000;1,7\n20.000;2,7\n", "numbers in row 1, but no header above them"),
        ("pressure [kPa];strain\n10.000;0,017\n50;0,045\n", "'10.000' has a point where other"),
        ("pressure [kPa],strain\n1,,\n", "has 0 rows with pressure and strain"),
        ("tress [kPa],strain\n1,0.1\n", "has no column pressure or force; its columns are 'tress"),
        ("pressure [kPa],strain +- [%]\n1,0.1\n", "has no column strain or deflection"),
    ],
)
def test_columns_of_a_case_are_rejected_as_those_of_tables(
    table: str, reason: str, tmp_path: Path
) -> None:
    (tmp_path / "test.csv").write_text(table)
    with pytest.raises(wo.InvalidProblem, match=f"test.csv: .*{reason}"):
        case(CASE, tmp_path)


def test_a_poor_fit_of_a_test_is_reported() -> None:
    P = np.linspace(0, 8e5, 6)
    e = np.log1p(P / 2e4) / 30 + np.array([0, 0.01, -0.01, 0.01, -0.01, 0.01])
    law = wo.StackTest(pressure=P, strain=np.sort(e) + 1e-4 * np.arange(6))
    assert law.misfit > 0.01
    assert "its stack test is fitted to" in roll(stack=PAPER.replace(radial=law)).validity_warning
