"""wo.sweep against wo.solve case by case: same numbers, labels, failures and warnings."""

from __future__ import annotations

import numpy as np
import pytest
import study_models as models
from thesis_cases import paper_nip

import woundon as wo
from woundon.problems.units import parse
from woundon.studies.api import study_of
from woundon.studies.cases import as_labels
from woundon.studies.model import model_of

# both solve the same discrete equations; they differ by the load's tolerance of 1e-10 and rounding
SAME = 1e-8
TENSION = ("nip_induced_tension",)
OUTPUTS = (*TENSION, "half_width", "drum_creepage", "approach", "dual", "peak_pressure")


@pytest.fixture(scope="module")
def grid():
    over = {"nip_load": [900.0, 1900.0, 4000.0], "roll.material.shear": [8e6, 1e7]}
    return wo.sweep(paper_nip(), over, OUTPUTS, nodes=25, workers=1)


def test_a_grid_gives_the_numbers_of_single_solves(grid):
    for P in grid.nip_load.values:
        for G in grid["roll.material.shear"].values:
            single = wo.solve(
                paper_nip(nip_load=P, **{"roll.material.shear": G}), nodes=25
            )  # fmt: skip
            case = grid.sel({"nip_load": P, "roll.material.shear": G})
            expected = {
                "nip_induced_tension": single.nip_induced_tension,
                "half_width": single.half_width,
                "drum_creepage": single.drum_creepage,
                "approach": single.approach,
                "dual": single.slip_ratios.dual,
                "peak_pressure": single.drum_pressure.max(),
            }
            for name, value in expected.items():
                assert float(case[name]) == pytest.approx(value, rel=SAME), name
            assert str(case.failure.values) == ""
            assert str(case.warnings.values) == "; ".join(single.warnings)


def test_an_input_without_effect_is_a_warning_of_its_case():
    roll = wo.RollProblem.example()
    heated = wo.sweep(roll, {"temperature_change": [0.0, 10.0]}, ["core_pressure"], rtol=0.01)
    cold, warm = (str(text) for text in heated.warnings.values)
    assert cold == ""
    assert warm == "; ".join(roll.replace(temperature_change=10.0).input_warnings)
    assert "temperature_change is not used" in warm


def test_labels_of_profiles_are_short_and_different():
    """A scanner's profile has hundreds of positions; other objects keep their complete text."""
    position = np.linspace(0.0, 2.0, 301)
    bands = [np.where(abs(position - y) < 0.1, 1.005, 1.0) for y in (0.7, 1.0)]
    profiles = [wo.ThicknessProfile(position=position, thickness=band) for band in bands]
    roll = wo.RollProblem.example()
    outputs, options = ["worst_lane.ridge_height"], {"lanes": 4, "rtol": 0.01}
    over = {"thickness_profile": [*profiles, profiles[0]]}
    labels = wo.sweep(roll, over, outputs, options=options)["thickness_profile"].values
    assert labels[0] == labels[2] != labels[1]
    assert all(label.startswith("ThicknessProfile(position=(0.0, ..., 2.0)") for label in labels)
    assert max(map(len, labels)) < 150
    table = {"position": position.tolist(), "thickness": bands[0].tolist()}  # as in a study file
    [label] = as_labels(np.array([table], dtype=object))
    assert label.startswith("{'position': [0.0, ..., 2.0]")
    assert len(label) < 100
    few = wo.Profile(radius=[0.04, 0.2], value=[300.0, 250.0])
    assert as_labels(np.array([few, None], dtype=object)).tolist() == [repr(few), "None"]


def test_numbers_depend_neither_on_workers_nor_on_the_rest_of_the_study():
    over = {"nip_load": np.linspace(1000, 3000, 24)}
    one = wo.sweep(paper_nip(), over, nodes=17, workers=1, chunk=6)
    two = wo.sweep(paper_nip(), over, nodes=17, workers=2, chunk=6)
    assert one.identical(two)


def test_a_failed_case_is_a_row_with_its_reason():
    # |F| < mu- P = 400 N/m
    over = {"winding_force": [0.0, 500.0, 100.0]}
    table = models.table_of(paper_nip(nip_load=1000.0), over, TENSION, options={"nodes": 17})
    assert table.failed.tolist() == [1]
    assert table.failure[1].startswith("NoSteadyState: winding_force: 500 is out of range")
    values = table.outputs["nip_induced_tension"]
    assert np.isnan(values[1])
    single = wo.solve(paper_nip(nip_load=1000.0, winding_force=100.0), nodes=17)
    assert values[2] == pytest.approx(single.nip_induced_tension, rel=SAME)


def test_bodies_and_materials_can_be_varied():
    drums = [wo.Rigid(radius=0.5), wo.Cylinder(radius=0.5, core_radius=0.48, material="rubber")]
    data = wo.sweep(
        paper_nip(), {"drum": drums, "roll.material": ["paper", "newsprint"]}, TENSION,
        nodes=17, workers=1,
    )  # fmt: skip
    assert data.drum.values.tolist() == [repr(d) for d in drums]
    assert data["roll.material"].values.tolist() == ["paper", "newsprint"]
    single = wo.solve(paper_nip(drum=drums[1], **{"roll.material": "newsprint"}), nodes=17)
    found = float(data.nip_induced_tension[1, 1])
    assert found == pytest.approx(single.nip_induced_tension, rel=SAME)


def test_values_may_be_texts_with_units():
    over = {"nip_load": ["1 kN/m", 2000.0, "12 pli"], "web.thickness": ("60 um", "7e-5 m")}
    _, cases = study_of(paper_nip(), over)
    assert cases.axes["nip_load"].tolist() == [1e3, 2e3, parse("12 pli", "N/m")]
    assert cases.axes["web.thickness"].tolist() == [60e-6, 7e-5]
    ranges = {"roll.material.shear": ("1 MPa", 1e8, "log"), "roll_friction": ["10 %", "0.3"]}
    _, drawn = study_of(paper_nip(), ranges, design="sobol", samples=8, seed=3)
    plain = {"roll.material.shear": (1e6, 1e8, "log"), "roll_friction": [0.1, 0.3]}
    _, same = study_of(paper_nip(), plain, design="sobol", samples=8, seed=3)
    assert drawn.record() == same.record()


@pytest.mark.parametrize(
    ("over", "options", "kind", "says"),
    [
        (
            {"winding_force": [5e3, 6e3], "roll_friction": [0.2, -1.0]}, {}, wo.InvalidProblem,
            r"over: none of the 4 cases was solved: 2 x NoSteadyState: winding_force: 5000 is out "
            r"of range.*; 2 x InvalidProblem: roll_friction: -1 is out of range",
        ),
        (
            {"nip_load": [1e3, 2e3]}, {"rtol": 1e-5}, wo.NotConverged,
            r"none of the 2 cases was solved: 2 x NotConverged: rtol = 1e-05 is not reached",
        ),
    ],
)  # fmt: skip
def test_a_sweep_without_any_solution_raises_with_its_reasons(
    over, options, kind, says, monkeypatch
):
    monkeypatch.setattr("woundon.nip.solve.MOST_NODES_RTOL", 70)  # soon out of reach
    with pytest.raises(kind, match=says) as fault:
        wo.sweep(paper_nip(), over, **options, workers=1)
    assert "\n" not in str(fault.value)
    if kind is wo.NotConverged:
        assert set(fault.value.best.failure.values.ravel()) != {""}


def test_estimates_that_no_output_is_are_omitted():
    """With nodes, all but the first case are solved on the last mesh alone: the same numbers."""
    nip = wo.NipProblem.example()
    over = {"nip_load": [1800.0, 2000.0, 2200.0]}
    outputs = ["wound_on_tension", "half_width"]
    quick = wo.sweep(nip, over, outputs, nodes=33, workers=1)
    full = wo.sweep(nip, over, [*outputs, "errors.half_width"], nodes=33, workers=1)
    for name in outputs:
        np.testing.assert_allclose(quick[name], full[name], rtol=1e-9)
    assert (full["errors.half_width"] > 0).all()
    assert (
        model_of(nip, outputs, None, {"nodes": 33}).without_estimates().options["errors"] is False
    )
    for asked, options in ((["errors.half_width"], {"nodes": 33}), (outputs, {})):
        model = model_of(nip, asked, None, options)
        assert model.without_estimates() is model
