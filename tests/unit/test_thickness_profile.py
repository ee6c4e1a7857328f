"""Thickness profiles: validation, lanes, files; results, margins and studies of lanes."""

from __future__ import annotations

import re
import warnings

import numpy as np
import pytest
from numpy.testing import assert_allclose

import woundon as wo
from woundon.io.case_files import apply_settings, read_case
from woundon.io.chosen_units import units_of
from woundon.report.html_report import report_file
from woundon.report.lane_panels import lane_panels

Y = np.linspace(0, 2, 101)
BAND = wo.ThicknessProfile(position=Y, thickness=66e-6 * (1 + 0.008 * (np.abs(Y - 1.2) < 0.11)))
ROLL = wo.RollProblem.example().replace(thickness_profile=BAND)


def test_a_profile_may_be_a_little_narrower_than_the_web():
    assert wo.WindingProblem.example().replace(width=2.01, thickness_profile=BAND).width == 2.01


def test_a_profile_of_another_web_is_an_input_warning():
    with pytest.warns(wo.InputWarning, match="the mean is .* the web is 80 um thick"):
        wo.solve(ROLL.replace(web_thickness=80e-6), lanes=4)


# ---- lanes --------------------------------------------------------------------------------------


@pytest.mark.parametrize("oscillation", [0.0, 0.013, 0.7])
@pytest.mark.parametrize("count", [1, 7, 50])
def test_the_volume_is_conserved(count, oscillation):
    """Conservation: the mean over the lanes is that over the profile."""
    lanes = BAND.lanes(count, oscillation)
    assert lanes.share @ lanes.excess == pytest.approx(0.0, abs=1e-15)
    assert lanes.share.sum() == pytest.approx(1.0, rel=1e-14)


def test_lanes_are_means_of_the_lines():
    """Closed form: the mean of a straight line is its value in the middle."""
    profile = wo.ThicknessProfile(position=[0, 4], thickness=[0.99, 1.01], slack=[0, 1e-3])
    lanes = profile.lanes(4)
    assert_allclose(lanes.position, [0.5, 1.5, 2.5, 3.5])
    assert_allclose(lanes.excess, [-0.0075, -0.0025, 0.0025, 0.0075], atol=1e-15)
    assert_allclose(lanes.slack, np.array([0.125, 0.375, 0.625, 0.875]) * 1e-3)


@pytest.mark.parametrize("count", [0, -1, "50", 2.5, True, 10_001, None])
def test_the_count_of_lanes_is_checked(count):
    text = "^count: .* is out of range; must be a whole number, 1 to 10000$"
    with pytest.raises(wo.InvalidProblem, match=text):
        BAND.lanes(count)


@pytest.mark.parametrize("amplitude", [float("nan"), -0.1, 10.1, "-1 mm"])
def test_the_amplitude_is_checked(amplitude):
    text = r"^oscillation: .* is out of range; must be >= 0 and <= 10 \[m\]$"
    for method in (lambda a: BAND.lanes(5, a), BAND.extremes):
        with pytest.raises(wo.InvalidProblem, match=text):
            method(amplitude)
    for other in (None, "wide", "1 kg"):
        with pytest.raises(wo.InvalidProblem, match=r"^oscillation: "):
            BAND.lanes(5, other)


def test_an_amplitude_is_a_length_with_a_unit():
    for moved, still in zip(BAND.lanes(np.int64(5), "0.1 m"), BAND.lanes(5, 0.1), strict=True):
        assert_allclose(moved, still, rtol=0)
    assert_allclose(BAND.extremes("10 cm").excess, BAND.extremes(np.float32(0.1)).excess, rtol=1e-6)


def test_an_oscillation_is_the_moving_average():
    """Closed form: a cosine of wave number k is multiplied by sin(k a)/(k a)."""
    y, k, a = np.linspace(0, 2, 4001), np.pi * 4, 0.1
    wave = wo.ThicknessProfile(position=y, thickness=1 + 0.01 * np.cos(k * y))
    still, moved = wave.lanes(40).excess, wave.lanes(40, a).excess
    # the lines between the points miss (k dy)^2/12 of the wave, 3e-6
    assert_allclose(moved, still * np.sin(k * a) / (k * a), atol=1e-7)


def test_the_variation_scales_the_deviations():
    assert_allclose(BAND.replace(variation=0.5).lanes(20).excess, BAND.lanes(20).excess / 2)
    assert not BAND.replace(variation=0.0).lanes(20).excess.any()


def test_extremes_are_those_of_the_profile():
    d = BAND.extremes().excess
    assert d == pytest.approx([1.008 / (BAND.mean / 66e-6) - 1, 66e-6 / BAND.mean - 1])
    assert BAND.extremes().share.sum() == 0
    moved = BAND.extremes(0.3).excess
    # far from the band the thickness stays that of the thinnest place
    assert moved[1] == pytest.approx(d[1])
    assert moved[0] < 0.5 * d[0]


# ---- files --------------------------------------------------------------------------------------

CASE = """schema = 1
core.radius = "44.5 mm"
core.stiffness = "1 GPa"
radius = "0.15 m"
web_thickness = "66 um"
wound_on_tension = "350 N/m"
density = "680 kg/m^3"
oscillation = "5 mm"
stack.tangential = "3.38 GPa"
stack.poissons_ratio = 0.01
stack.shear = "10 MPa"
stack.radial.K1 = "10 kPa"
stack.radial.K2 = 40
[thickness_profile]
csv = "scan.csv"
"""


@pytest.mark.parametrize(
    ("header", "factor"),
    [("position [mm],thickness [um]", 1.0), ("position [mm],thickness [gsm]", 0.68)],
)
def test_a_scan_in_a_case_file(tmp_path, header, factor):
    rows = [f"{1e3 * y},{1e6 * h * factor}" for y, h in zip(Y, BAND.thickness, strict=True)]
    (tmp_path / "scan.csv").write_text("\n".join([header, *rows]))
    (tmp_path / "roll.toml").write_text(CASE)
    problem = wo.load_case(tmp_path / "roll.toml")
    assert_allclose(problem.thickness_profile.thickness, BAND.thickness)
    assert_allclose(problem.thickness_profile.position, BAND.position, atol=1e-15)
    assert problem.oscillation == 0.005


@pytest.mark.parametrize(
    ("rows", "words"),
    [
        (
            "position [mm],thickness [%]\n0,99.8\n10,100.2\n",
            "column 'thickness [%]': '%' has the w",
        ),
        (
            "position [mm],thickness [um]\n0,66\n10,100 %\n",
            "row 3, column 'thickness [um]': '100 %",
        ),
        (
            "position [mm],thickness [um]\n0,66\n10,\n20,66\n",
            "row 3, column 'thickness [um]': the cell is empty",
        ),
        ("position [mm],thickness [um]\n0,66\n10,660\n", "thickness.0: 6.6e-05 is out of range"),
        ("thickness [um]\n66\n66\n", "has no column position"),
        ("position [mm],slack [%]\n0,0\n10,0\n", "has no column thickness"),
    ],
)
def test_errors_of_a_scan_name_the_file(tmp_path, rows, words):
    """Errors of the values themselves are those of the fields in a case file."""
    path = tmp_path / "scan.csv"
    path.write_text(rows)
    with pytest.raises(wo.InvalidProblem, match=re.escape(f"{path}: {words}")):
        wo.read_thickness_profile(path)
    (tmp_path / "roll.toml").write_text(CASE)
    place = "thickness_profile." if "out of range" in words else f"{path}: "
    with pytest.raises(wo.InvalidProblem, match=re.escape(f"{place}{words}")):
        wo.load_case(tmp_path / "roll.toml")


@pytest.mark.parametrize("name", ['""', "3", '["scan.csv"]'])
def test_a_file_without_a_name_is_rejected(tmp_path, name):
    (tmp_path / "roll.toml").write_text(CASE.replace('"scan.csv"', name))
    with pytest.raises(wo.InvalidProblem, match=r"^thickness_profile\.csv: .* the name of a file"):
        wo.load_case(tmp_path / "roll.toml")


def test_a_file_is_not_set_on_the_command_line(tmp_path):
    (tmp_path / "scan.csv").write_text("position [mm],thickness [um]\n0,66\n10,66\n")
    (tmp_path / "roll.toml").write_text(CASE)
    setting = "thickness_profile.csv=scan.csv"
    with pytest.raises(wo.InvalidProblem, match=r"^thickness_profile\.csv: names a file"):
        apply_settings(read_case(tmp_path / "roll.toml"), [setting])


def test_several_scans_in_a_spreadsheet(tmp_path):
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    book.active.append(["position [mm]", "thickness [gsm]"])
    for weight in (45.0, 45.4):
        for y in (0, 1000, 2000):
            book.active.append([y, weight + y / 1e4])
    book.save(tmp_path / "scans.xlsx")
    profile = wo.read_thickness_profile(tmp_path / "scans.xlsx")
    assert_allclose(profile.position, [0, 1, 2])
    # a basis weight becomes a thickness relative to the mean, 45.3 gsm
    assert_allclose(np.array(profile.thickness) * 45.3, [45.2, 45.3, 45.4])
    assert profile.mean == pytest.approx(1.0, rel=1e-14)
    # the sample standard deviation of 45.0 and 45.4 is 0.4/sqrt(2)
    assert_allclose(np.array(profile.spread) * 45.3, 0.4 / np.sqrt(2))
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # 45 gsm are no 45 mm
        result = wo.solve(wo.RollProblem.example().replace(thickness_profile=profile), lanes=6)
    text = str(result)
    assert "standard deviation between the scans" in text


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        ("0,66\n500,66.4\n1000,66\n0,66.2\n500,66.2", "1000 mm is in 1 .*, 0 mm is in 2"),
        ("0,66\n500,66\n1000,66\n500,66\n1000,66", "0 mm is in 1 .*, 500 mm is in 2"),
        ("0,66\n500,66\n500,66\n1000,66", "0 mm is in 1 .*, 500 mm is in 2"),
        ("0,66\n500,66\n0,66\n500.1,66", "500 mm is in 1 .*, 0 mm is in 2"),
    ],
)
def test_scans_with_different_positions_are_rejected(tmp_path, rows, message):
    """A mean of fewer scans at the edge would be a step of the web that no scan has."""
    (tmp_path / "scans.csv").write_text(f"position [mm],thickness [um]\n{rows}\n")
    with pytest.raises(wo.InvalidProblem, match=rf"scans\.csv: position: {message}"):
        wo.read_thickness_profile(tmp_path / "scans.csv")


# ---- results ------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def result():
    return wo.solve(ROLL)


def test_the_dataset(result):
    lanes = result.lanes
    assert lanes.pressure.dims == ("radius", "position")
    assert lanes.pressure.attrs["units"] == "Pa"
    assert_allclose(lanes.wound_on_tension @ lanes.share, 350.0, rtol=1e-12)
    assert_allclose(lanes.hoop_stress[-1] * 66e-6 * (1 + lanes.thickness_excess),
                    lanes.wound_on_tension[-1], rtol=1e-3)  # fmt: skip
    # the free surface carries its own tension, except for the discretisation error
    assert np.isnan(lanes.nip_load).all()


def test_results_without_a_profile_have_no_lanes():
    plain = wo.solve(wo.RollProblem.example())
    assert plain.lanes is None
    assert plain.worst_lane is None
    assert "Lanes across the width" not in str(plain)
    assert not any(name.startswith("worst_lane") for name in plain.to_xarray().variables)


def test_a_loaded_result_has_the_same_lanes(result, tmp_path):
    result.save(tmp_path / "roll.nc")
    loaded = wo.load_result(tmp_path / "roll.nc")
    assert loaded == result
    assert loaded.worst_lane.pressure == pytest.approx(result.worst_lane.pressure, rel=1e-4)
    assert loaded.worst_lane.tension == pytest.approx(result.worst_lane.tension, rel=1e-6)


def test_no_pressure_on_a_removed_core_is_reported(monkeypatch):
    """Of the lanes, of the roll and in a comparison with a roll on its core."""
    monkeypatch.setattr("woundon.report.html_report._figure", lambda *_: iter(()))
    cases = [ROLL.replace(radius=0.06, core_removed=removed) for removed in (False, True)]
    on_core, removed = (wo.solve(case, rtol=0.1, lanes=4) for case in cases)
    texts = str(on_core), str(removed), report_file([on_core] * 2), report_file([on_core, removed])
    counts = [" ".join(text.split()).count("pressure of a lane on the core") for text in texts]
    # in the results of each state; a comparison has neither
    assert counts == [1, 0, 2, 1]
    assert "pressure on the core" not in str(removed)


def test_the_report_names_slack_lanes():
    y = np.linspace(0, 1, 201)
    thin = wo.ThicknessProfile(position=y, thickness=1 - 0.2 * (np.abs(y - 0.5) < 0.1))
    result = wo.solve(wo.RollProblem.example().replace(thickness_profile=thin), lanes=20)
    text = " ".join(str(result).split())
    assert "Slack, without tension at some radius: 400 mm to 600 mm across the web, 20 %" in text
    with units_of(["mill"]):
        assert "15.75 in to 23.62 in across the web" in " ".join(str(result).split())


def test_the_margin_of_bending_is_that_of_the_worst_lane(result):
    """Strain of the lane and h/2r, where their sum is the largest."""
    lanes, margin = result.lanes, wo.margins(result, wo.Limits(yield_strain=0.01))["bending"]
    strains = lanes.band_strain + 66e-6 / 2 / lanes.radius
    assert margin.value == float(strains.max())
    assert margin.value > float(result.bending_strain[0] + 350 / 66e-6 / ROLL.stack.tangential)
    assert "% thicker than the mean" in margin.note
    assert "uneven across the width" not in margin.left_out
    plain = wo.margins(wo.solve(wo.RollProblem.example(), rtol=1e-2))["bending"]
    assert "uneven across the width" in plain.left_out


def test_an_even_web_has_no_deviation_by_rounding():
    even = wo.ThicknessProfile(position=[0, 2.4], thickness=[1, 1])
    assert not even.lanes(20).excess.any()
    roll = wo.solve(wo.RollProblem.example().replace(thickness_profile=even), lanes=20, rtol=1e-2)
    assert "as thick as the mean" in wo.margins(roll)["gauge_band"].note
    panel = lane_panels(roll)["thickness_across"].make(roll)
    low, high = panel.y.limits
    assert -0.01 < low < 0 < high < 0.01


@pytest.mark.parametrize("name", ["blocking", "core", "strength", "compression", "gauge_band"])
def test_margins_are_those_of_the_worst_lane(result, name):
    limits = wo.Limits(
        blocking_pressure=1e6, core_pressure=1e6, web_strength=1e3, compression=1e6,
        yield_strain=0.01,
    )  # fmt: skip
    worst = {
        "blocking": result.worst_lane.pressure,
        "core": result.worst_lane.core_pressure,
        "strength": result.worst_lane.tension,
        "compression": result.worst_lane.compression,
        "gauge_band": result.worst_lane.strain,
    }
    margin = wo.margins(result, limits)[name]
    assert margin.value == pytest.approx(worst[name], rel=1e-12)
    # the lanes of the band, 1.09 to 1.31 m, differ by rounding only
    assert re.search(r"in the lane at 1[123]\d0 mm across the web", margin.note)
    assert "thicker than the mean" in margin.note


def test_the_smallest_tension_is_that_of_the_thinnest_lane(result):
    margin = wo.margins(result, wo.Limits(slack_tension=100.0))["slack"]
    assert margin.value == pytest.approx(result.worst_lane.least_tension, rel=1e-9)
    assert "thinner than the mean" in margin.note


def test_figures_of_the_lanes(result, tmp_path):
    panels = [
        "lane_pressure",
        "lane_tension",
        "roll_surface",
        "thickness_across",
        "hardness_across",
    ]
    result.plot(tmp_path / "lanes.png", panels=panels)
    with units_of(["mill"]):
        result.plot(tmp_path / "mill.png", panels=panels)
    with pytest.raises(wo.InvalidProblem, match="nip_load_across"):
        result.plot(tmp_path / "lanes.png", panels="nip_load_across")


def test_maps_of_lanes_reach_the_edges_of_the_web(result):
    for panel in (
        lane_panels(result)[name].make(result) for name in ("lane_pressure", "lane_tension")
    ):
        assert panel.map is not None
        assert panel.map.x[[0, -1]] == pytest.approx(panel.x.limits, abs=1e-12)
        assert panel.map.x[[0, -1]] == pytest.approx([0, 2], abs=1e-12)
        assert panel.map.values.shape == (panel.map.y.size, panel.map.x.size)


def test_thickness_and_ridges_have_one_zero(result, tmp_path):
    figure = result.plot(panels="thickness_across")
    left, right = figure.axes
    zeros = [axes.transData.transform((0, 0))[1] for axes in (left, right)]
    assert zeros[0] == pytest.approx(zeros[1], abs=0.1)  # pixels
    for axes, curve in ((left, left.lines[0]), (right, right.lines[0])):
        low, high = axes.get_ylim()
        assert low < min(curve.get_ydata())
        assert max(curve.get_ydata()) < high


# ---- studies ------------------------------------------------------------------------------------


def test_find_the_oscillation_that_keeps_a_band_below_yield():
    limit = 0.00168
    assert wo.solve(ROLL).worst_lane.strain > limit
    found = wo.find(
        ROLL, "oscillation", between=(0.0, 0.9), points=5, **{"worst_lane.strain": limit}
    )
    assert found.result.worst_lane.strain == pytest.approx(limit, rel=1e-5)
    assert 0.05 < found.value < 0.9


def test_a_sweep_over_the_size_of_a_band():
    sizes = np.array([0.25, 0.5, 1.0])
    table = wo.sweep(
        ROLL,
        {"thickness_profile.variation": sizes.tolist()},
        outputs=["worst_lane.ridge_height", "worst_lane.tension"],
    )
    quotients = table["worst_lane.ridge_height"].values / sizes
    tension = table["worst_lane.tension"].values
    # the modulus of the stack is at most in proportion to the tension, and so is what the ridge
    # rises above its proportion to the size
    for k in (1, 2):
        assert 1.0 < quotients[k] / quotients[0] < tension[k] / tension[0]
    # ridge = a d + b d^2, with a next term that is smaller by about b d/a, 4.5 % at full size
    b = np.diff(quotients) / np.diff(sizes)
    assert b[1] == pytest.approx(b[0], rel=0.05)


LIMIT = 0.0023  # of the strain of a band, with that by bending
OSCILLATIONS, SIZES = (0.0, 0.3), (0.25, 1.5)


@pytest.fixture(scope="module")
def wound() -> wo.WindingProblem:
    """Return a winding whose wound-on tension is T_in + mu N, so that no nip is solved."""
    return wo.WindingProblem.example().replace(
        radius=0.07, tension_law="friction", web_tension=250.0, nip_load=500.0,
        thickness_profile=BAND, limits=wo.Limits(yield_strain=LIMIT),
    )  # fmt: skip


@pytest.fixture(scope="module")
def window(wound) -> wo.OperatingWindow:
    return wo.operating_window(
        wound, vary={"oscillation": OSCILLATIONS, "thickness_profile.variation": SIZES},
        uncertain={"roll_friction": 0.1}, samples=256, workers=1, options={"lanes": 20},
    )  # fmt: skip


@pytest.mark.slow
def test_a_window_over_oscillation_and_the_size_of_a_band(window, wound):
    """Independent solutions between the nodes of the map: margins are those of the worst lane."""
    assert window.names == ("oscillation", "thickness_profile.variation")
    assert window.margins == ("slip", "gauge_band", "bending")
    for oscillation, size in ((0.05, 0.4), (0.12, 1.3), (0.22, 0.8), (0.28, 1.1)):
        changes = {"oscillation": oscillation, "thickness_profile.variation": size}
        result = wo.solve(wound.replace(**changes), lanes=20)
        margins = window.at(oscillation, size).margins
        strains = {"gauge_band": result.worst_lane.strain, "bending": result.face_strain}
        for name, strain in strains.items():
            reserve, deviation = margins[name]
            # 0.01 of the limit: the polynomials of degree four, and the accuracy of the windings
            assert reserve == pytest.approx(1 - strain / LIMIT, abs=0.01)
            assert deviation > 0
    # never safer than at a larger oscillation with a smaller band
    assert (np.diff(window.probability, axis=0) >= -0.02).all()
    assert (np.diff(window.probability, axis=1) <= 0.02).all()
    assert window.probability[0, -1] == 0.0
    assert window.probability[-1, 0] > 0.95


@pytest.mark.parametrize(
    ("ranges", "message"),
    [
        ({"oscillation": (0, "1.2 m")}, r"oscillation: 1\.2 .*<= 1 \[m\], half the width of the"),
        ({"thickness_profile.variation": (0.5, 90)}, r"variation: 90 .*<= 10"),
        ({"thickness_profile.variation": (-0.5, 1)}, r"variation: -0\.5 .*>= 0"),
        ({"thickness_profile.thickness": (0.5, 1)}, "thickness_profile.thickness: .* not a number"),
    ],
)
def test_a_range_that_the_profile_does_not_permit(ranges, message, wound):
    with pytest.raises(wo.InvalidProblem, match=message):
        wo.operating_window(wound, (200, 300), vary=ranges, uncertain={"roll_friction": 0.1})


@pytest.mark.slow
def test_the_boundary_of_a_window_is_the_oscillation_that_find_finds(window, wound):
    found = wo.find(
        wound, "oscillation", between=OSCILLATIONS, points=5, options={"lanes": 20},
        face_strain=LIMIT,
    )  # fmt: skip
    reserve, _ = window.at(found.value, 1.0).margins["bending"]
    assert reserve == pytest.approx(0.0, abs=0.01)  # as between the nodes
    # half of the draws of a friction of the same median: the probability is about a half
    assert window.at(found.value, 1.0).probability == pytest.approx(0.5, abs=0.1)


@pytest.mark.slow
def test_the_figure_of_a_window_has_the_fields_on_its_axes(window, tmp_path):
    figure = window.plot(tmp_path / "window.png")
    axes = figure.axes[0]
    assert axes.get_xlabel() == "amplitude of the oscillation of the web across the roll [mm]"
    assert axes.get_ylabel() == "factor of the variation of the thickness"
    assert axes.get_xlim() == (0.0, 300.0)
    with units_of(["mill"]):
        figure = window.plot(tmp_path / "mill.png")
        assert figure.axes[0].get_xlabel().endswith("across the roll [in]")
        inches = window.best.values["oscillation"] / 0.0254
        assert f"oscillation {inches:.4g} in" in str(window)
    header = str(window.to_dataframe().columns.tolist())
    assert "'oscillation', 'thickness_profile.variation', 'probability'" in header


# ---- windings -----------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def winding():
    problem = wo.WindingProblem.example().replace(radius=0.15, thickness_profile=BAND)
    return wo.solve(problem, rtol=0.01, lanes=30)


def test_a_winding_shares_tension_and_nip_load(winding):
    lanes, r = winding.lanes, winding.lanes.radius.values
    load = np.interp(r, winding.radius, winding.nip_load)
    web = np.interp(r, winding.radius, winding.web_tension)
    assert_allclose(lanes.nip_load @ lanes.share, load, rtol=1e-12)
    assert_allclose(lanes.web_tension @ lanes.share, web, rtol=1e-12)
    band = int(np.argmax(lanes.thickness_excess.values))
    assert (lanes.nip_load[-1, band] > load[-1]).all()
    assert winding.ridge_height == winding.worst_lane.ridge_height > 0
    assert winding.band_strain == pytest.approx(winding.worst_lane.strain)
    assert "The nip load on a lane is between" in str(winding)


def test_the_nip_lowers_the_ridge(winding):
    """The same roll with the same wound-on tension in all lanes' web, without a nip."""
    fixed = winding.problem.replace(
        tension_law=wo.Profile(radius=winding.radius, value=winding.wound_on_tension),
        web_tension=winding.problem.web_tension,
    )
    without = wo.solve(fixed, rtol=0.01, lanes=30)
    ratio = winding.worst_lane.ridge_height / without.worst_lane.ridge_height
    # 1/(1 + mu k s/(E_t h)) with k of about 1e7 N/m^2 and dA/dP of 0.08, less than mu at this load:
    # 0.08 * 1e7 * 0.15/(3.38e9 * 66e-6) = 0.54
    assert ratio == pytest.approx(1 / 1.54, rel=0.1)


def test_a_loaded_winding_has_lanes(winding, tmp_path):
    winding.save(tmp_path / "winding.nc")
    loaded = wo.load_result(tmp_path / "winding.nc")
    assert loaded.worst_lane.tension == pytest.approx(winding.worst_lane.tension, rel=1e-8)
    assert loaded.lanes.sizes["position"] == 30


@pytest.mark.parametrize("kind", [wo.RollProblem, wo.WindingProblem])
def test_an_oscillation_without_a_profile_has_no_effect_and_says_so(kind):
    problem = kind.example().replace(oscillation=0.1)
    assert problem.input_warnings == ("oscillation = 0.1 m is not used: there is no profile",)


# ---- progress -----------------------------------------------------------------------------------


def test_the_lanes_of_a_roll_report_their_progress_and_stop_where_it_raises():
    band = wo.ThicknessProfile(position=[0.0, 1.0, 2.0], thickness=[1.0, 1.02, 1.0])
    roll = wo.RollProblem.example().replace(thickness_profile=band)
    seen: list[float] = []
    wo.solve(roll, rtol=0.05, lanes=4, progress=seen.append)
    assert seen == sorted(seen)
    assert seen[-1] == 1.0
    of_lanes = [done for done in seen if 0.15 < done < 1.0]  # the mean web takes 15 %
    assert len(of_lanes) > 20
    assert max(np.diff(of_lanes)) < 0.3

    def stop(done: float) -> None:
        if done > 0.5:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        wo.solve(roll, rtol=0.05, lanes=4, progress=stop)
