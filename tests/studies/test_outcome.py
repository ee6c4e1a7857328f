"""Text, HTML, JSON and figure of what studies return, which have one base class.

Evidence: invariance; the same numbers in every form.
"""

from __future__ import annotations

import json

import pytest

import woundon as wo
from woundon.quantities import stress
from woundon.report.study_panels import in_words


@pytest.fixture(scope="module")
def found() -> wo.FindResult:
    return wo.find(wo.RollerProblem.example(), "load", nip_width="1 mm", nodes=33)


@pytest.fixture(scope="module")
def schedule() -> wo.OptimisedSchedule:
    return wo.optimise_schedule(
        wo.RollProblem.example(), {"wound_on_tension": (200.0, 400.0)},
        limits=wo.Limits(core_pressure="1 MPa"), evaluations=5, options={"rtol": 1e-2},
    )  # fmt: skip


def test_a_notebook_shows_answer_table_and_remarks(found: wo.FindResult) -> None:
    html = found._repr_html_()
    assert str(found) == "\n".join([*found.answer(), *found.remarks()])
    # symbols in the text become letters
    assert html.count("<p ") == 1 + len(found.remarks())
    assert f"{found.value:.4g}" in html


def test_rows_of_the_table_are_the_json_by_default(schedule: wo.OptimisedSchedule) -> None:
    (row,) = json.loads(schedule.to_json())["rows"]
    assert row == {"field": "wound_on_tension", "start": schedule.start[0],
                   "value": schedule.values[0], "low": 200.0, "high": 400.0}  # fmt: skip
    assert "All limits are kept" in schedule._repr_html_()


def test_sobol_indices_and_their_cases_are_shown_like_other_studies() -> None:
    indices = wo.global_sensitivity(
        wo.RollerProblem.example(), {"load": (50e3, 100e3), "friction": (0.3, 0.5)},
        ["half_width"], samples=4, nodes=17, workers=1,
    )  # fmt: skip
    assert str(indices) == "\n".join(indices.lines())
    html = indices._repr_html_()
    assert "with interactions (total)" in html
    rows = json.loads(indices.to_json())["rows"]
    assert [row["total_order"] for row in rows] == pytest.approx(indices.total_order[0])
    assert f"{rows[0]['total_order']:.4g}" in html
    (axes,) = indices.plot().axes
    labels = [text.get_text() for text in axes.get_yticklabels()]
    assert sorted(labels) == ["friction coefficient of the\nrollers", "load"]
    assert axes.get_title(loc="left") == "half-width of the contact"
    assert axes.get_xlabel() == "share of the variance, with 95 % intervals"
    cases = indices.table._repr_html_()
    assert cases.count("<tr") == 1 + len(indices.table.cases)
    assert "half_width" in cases


def test_a_panel_is_drawn_into_given_axes(schedule: wo.OptimisedSchedule) -> None:
    from matplotlib.figure import Figure

    ax = Figure().add_subplot()
    assert schedule.plot(ax=ax, panels="reserves") is ax
    with pytest.raises(wo.InvalidProblem, match=r"must be .* or reserves"):
        schedule.plot(panels="reserve")


def test_error_bars_of_a_comparison_are_explained_in_its_legends() -> None:
    data = {"load": [4e3, 8e3], "nip_width [mm]": [0.65, 0.92], "nip_width +- [mm]": [0.02] * 2}
    problem = wo.RollerProblem.example().replace(tangential_load=0.0)
    figure = wo.compare(problem, data, nodes=17).plot()
    for axes in figure.axes:
        (entry, *_) = axes.get_legend().get_texts()
        assert entry.get_text() == "two standard uncertainties"
        (points,) = axes.containers
        assert points.get_label() == entry.get_text()
        assert points.has_yerr


def test_labels_are_words_and_name_the_part_of_a_field() -> None:
    assert in_words("upper.material.shear", stress("G", "shear modulus, of a layer")) == (
        "shear modulus (upper material)"
    )
    assert in_words("gauge_band", None) == "gauge band"
