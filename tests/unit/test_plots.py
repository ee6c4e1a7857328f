"""Figures: what they show, that nothing is covered or clipped, and that their bytes are fixed."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

import woundon as wo
from woundon.plots import plot_nip
from woundon.results import NipResult


@pytest.fixture(scope="module")
def result() -> NipResult:
    newsprint = wo.material("newsprint")
    return wo.solve_nip(
        wo.NipProblem(
            web=wo.Web(thickness=66e-6, material=newsprint),
            roll=wo.HalfPlane(radius=0.1, material=newsprint),
            drum=wo.Rigid(radius=0.0762),
            roll_friction=0.19,
            drum_friction=0.2,
            nip_load=3502.0,
            web_tension=350.0,
        ),
        nodes=25,
    )


def test_panels_show_the_results_in_the_units_of_their_labels(result):
    tractions, slips, zones, tension = plot_nip(result).axes
    assert tractions.get_ylabel() == "Tangential traction $q$ [kPa]"
    assert slips.get_ylabel() == "Relative slip speed $v$ [%]"
    assert tension.get_ylabel() == "Web tension $T$ [N/m]"
    assert zones.get_xlabel() == "Position along the nip $x$ [mm]"
    drawn = [line.get_xydata() for line in tractions.get_lines()]
    for data, traction in zip(drawn, (result.roll_traction, result.drum_traction), strict=True):
        np.testing.assert_allclose(data[:, 0], 1e3 * result.x)
        np.testing.assert_allclose(data[:, 1], 1e-3 * traction)
    drawn = [line.get_xydata() for line in slips.get_lines()]
    for data, slip in zip(drawn, (result.roll_slip, result.drum_slip), strict=True):
        np.testing.assert_allclose(data[:, 1], 100 * slip)
    (line,) = tension.get_lines()
    np.testing.assert_allclose(line.get_ydata(), result.web_tension)


def test_zone_bars_cover_the_nip(result):
    zones = plot_nip(result).axes[2]
    for row in (0, 1):
        bars = [bar for bar in zones.patches if round(bar.get_y() + bar.get_height() / 2) == row]
        assert sum(bar.get_width() for bar in bars) == pytest.approx(2e3 * result.half_width)


def test_legends_cover_no_data_and_nothing_is_clipped(result):
    figure = plot_nip(result)
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    width, height = canvas.get_width_height()
    for axes in figure.axes:
        box = axes.get_tightbbox()
        assert box.x0 >= 0
        assert box.y0 >= 0
        assert box.x1 <= width
        assert box.y1 <= height
        legend = axes.get_legend()
        if legend is not None:
            assert legend.get_window_extent().y0 >= axes.get_window_extent().y1 - 1


@pytest.mark.parametrize("ending", ["png", "svg", "pdf"])
def test_the_same_result_gives_the_same_bytes(result, tmp_path, ending):
    one, other = tmp_path / f"a.{ending}", tmp_path / f"b.{ending}"
    result.plot(one)
    result.plot(other)
    assert one.read_bytes() == other.read_bytes()
    assert len(one.read_bytes()) > 10_000


def test_global_style_is_left_alone(result):
    import matplotlib as mpl

    before = dict(mpl.rcParams)
    plot_nip(result)
    assert dict(mpl.rcParams) == before


def test_unknown_ending_is_refused(result, tmp_path):
    with pytest.raises(wo.InvalidProblem, match=r"'.gif' names no format"):
        result.plot(tmp_path / "nip.gif")
