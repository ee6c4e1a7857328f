"""Panels: the page and the figures draw the same arrays."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from coarse_solutions import coarse_solution
from thesis_cases import film_nip

import woundon as wo
from woundon.app.plot_data import panel_data, slow_panel_data
from woundon.report.plots import figure_for_file
from woundon.report.result_panels import panels_of

PROBLEMS = {
    "nip": wo.NipProblem.example(),
    "nip with air": film_nip(),
    "rollers": wo.RollerProblem.example(),
    "roll": wo.RollProblem.example(),
    "winding": wo.WindingProblem.example().replace(radius=0.1, roll_body="linear"),
}
# The page rounds to eight digits.
ROUNDED = {"rtol": 1e-7, "atol": 1e-300}


def array(values: Any) -> np.ndarray:
    """Return the numbers of a page; nan for None."""
    return np.array([np.nan if value is None else value for value in values])


def shown(axis: dict[str, Any], values: Any, panel_axis: Any) -> np.ndarray:
    """Return values of the page in the unit of the figure's axis."""
    quantity = panel_axis.quantity
    assert axis["quantity"]["shown_unit"] == (quantity.display if quantity else "")
    return quantity.shown(array(values)) if quantity else array(values)


@pytest.mark.parametrize("name", PROBLEMS)
def test_the_panels_of_the_page_are_those_of_the_figures(name: str) -> None:
    """All panels, with the same curves: arrays on the axes of the figure, labels."""
    result = coarse_solution(PROBLEMS[name], 33)
    page = {panel["name"]: panel for panel in (*panel_data(result), *slow_panel_data(result))}
    makers = panels_of(result)
    assert set(makers) <= set(page)
    for panel_name, maker in makers.items():
        panel, seen = maker.make(result), page[panel_name]
        figure = figure_for_file(result, panels=panel_name)
        left, right = figure.axes[0].get_lines(), figure.axes[-1].get_lines()
        lines = {False: iter(left), True: iter(right)}  # of each axis in this order
        assert len(seen["curves"]) == len(panel.curves)
        for curve in seen["curves"]:
            line = next(lines[curve["right"]])
            axis, y_axis = ("right", panel.right) if curve["right"] else ("y", panel.y)
            x, y = shown(seen["x"], curve["x"], panel.x), shown(seen[axis], curve["y"], y_axis)
            np.testing.assert_allclose(x, line.get_xdata(), **ROUNDED)
            np.testing.assert_allclose(y, line.get_ydata(), **ROUNDED)
        assert [len(strip["runs"]) for strip in seen["strips"]] == [
            len(strip.runs) for strip in panel.strips
        ]
        drawn = sum(len(strip.runs) for strip in panel.strips)
        assert not drawn or len(figure.axes[0].patches) == drawn
        assert bool(seen["scale"]) == any(
            "colorbar" in bar.get_label() for axes in figure.axes for bar in axes.child_axes
        )


def test_an_array_that_no_panel_shows_has_one_of_its_own() -> None:
    result = coarse_solution(PROBLEMS["nip"], 33)
    others = [panel["name"] for panel in slow_panel_data(result) if panel["group"] == "outputs"]
    assert others == ["roll_strain", "hoop_pressure", "curvature"]


def test_quick_panels_are_drawn_while_a_slider_moves() -> None:
    """Those that need the interior stresses of the roll come with the report."""
    result = coarse_solution(PROBLEMS["nip"], 33)
    quick = {panel["name"] for panel in panel_data(result)}
    assert {"tractions", "tension", "wrap_pressure"} <= quick
    assert not quick & {"layer_slip", "layer_shear"}
