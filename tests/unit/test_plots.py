"""Figures: what they show, that nothing is covered or clipped, and that their bytes are fixed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from coarse_solutions import coarse_solution, solve_coarsely
from matplotlib.backends.backend_agg import FigureCanvasAgg
from slow_cases import slow_case
from thesis_cases import film_nip

import woundon as wo
from woundon import kinds, quantities
from woundon.quantities import Quantity, line_load, stress
from woundon.report import plots
from woundon.report.drawing import draw_figure
from woundon.report.figures import axis_label, symbol_text
from woundon.report.panels import Axis, Curve, Panel
from woundon.report.result_panels import array_panels
from woundon.report.sweep_panels import plot_sweep
from woundon.studies.cases import make_cases

NODES = 33
SOFT = wo.Isotropic(youngs_modulus=5e6, poissons_ratio=0.47)


def plot_outputs(result: Any) -> Any:
    """Draw a result of any kind as one is drawn whose kind does not say how."""
    return draw_figure([[maker.make(result)] for maker in array_panels(result).values()])


@pytest.fixture(scope="module")
def results(nip, wrapped) -> dict[str, Any]:
    """An example of every kind, and cases whose figures have more or less to show."""
    cover = wo.Cylinder(radius=0.0762, core_radius=0.0662, material=SOFT)
    pair = wo.RollerProblem.example()
    rubber = pair.replace(lower=wo.HalfPlane(radius=0.2, material=SOFT), tangential_load=None)
    more = {
        "soft cover": nip.problem.replace(drum=cover, winding_force=-200.0, roll_wrap=np.pi),
        "drum wrap alone": nip.problem.replace(drum_wrap=1.0),
        "drum slides": nip.problem.replace(
            nip_load=1e3, roll_wrap=np.pi, winding_force=400, drum_wrap=2.5
        ),
        "air": film_nip(),
        "static": pair.replace(motion="static"),
        "free rolling": rubber,
    }
    solved = {name: wo.solve(problem, nodes=NODES) for name, problem in more.items()}
    examples = {k.name: coarse_solution(k.problem.example(), NODES) for k in kinds.every()}
    return {**examples, **solved, "without wraps": nip, "wrapped on both": wrapped}


def curves(axes: Any) -> dict[str, np.ndarray]:
    """Return the points of a panel's lines by label."""
    return {line.get_label(): line.get_xydata() for line in axes.get_lines()}


# ---- the nip


def test_panels_show_the_results_in_the_units_of_their_labels(nip):
    tractions, slips, zones, tension = nip.plot().axes
    assert tractions.get_ylabel() == "Tangential traction $q$ [kPa]"
    assert slips.get_ylabel() == "Relative slip speed $v$ [%]"
    assert tension.get_ylabel() == "Web tension $T$ [N/m]"
    assert zones.get_xlabel() == "Position along the nip $x$ [mm]"
    drawn = [line.get_xydata() for line in tractions.get_lines()]
    for data, traction in zip(drawn, (nip.roll_traction, nip.drum_traction), strict=True):
        np.testing.assert_allclose(data[:, 0], 1e3 * nip.x)
        np.testing.assert_allclose(data[:, 1], 1e-3 * traction)
    drawn = [line.get_xydata() for line in slips.get_lines()]
    for data, slip in zip(drawn, (nip.roll_slip, nip.drum_slip), strict=True):
        np.testing.assert_allclose(data[:, 1], 100 * slip)
    (line,) = tension.get_lines()
    np.testing.assert_allclose(line.get_ydata(), nip.tension)


def highest(axes: Any) -> dict[str, float]:
    """Return the highest point of each shaded bound by label."""
    return {
        shade.get_label(): shade.get_paths()[0].vertices[:, 1].max() for shade in axes.collections
    }


def test_bounds_are_those_of_the_pressure_on_the_face(nip, wrapped):
    p = 1e-3 * nip.peak_pressure
    bounds = highest(nip.plot().axes[0])
    assert bounds == pytest.approx({r"$\pm \mu^{+} p$": 0.19 * p, r"$\pm \mu^{-} p$": 0.2 * p})
    own = wrapped.in_nip
    on_roll, on_drum = wrapped.roll_pressure[own].max(), wrapped.drum_pressure[own].max()
    bounds = highest(wrapped.plot().axes[0])
    assert bounds == pytest.approx(
        {r"$\pm \mu^{+} p^{+}$": 0.19e-3 * on_roll, r"$\pm \mu^{-} p^{-}$": 0.2e-3 * on_drum}
    )


def test_zone_bars_cover_the_contact(nip):
    zones = nip.plot().axes[2]
    assert [text.get_text() for text in zones.get_yticklabels()] == ["drum", "roll"][::-1]
    for row in (0, 1):
        bars = [bar for bar in zones.patches if round(bar.get_y() + bar.get_height() / 2) == row]
        assert sum(bar.get_width() for bar in bars) == pytest.approx(2e3 * nip.half_width)


# ---- the nip with its wraps


def test_a_wrapped_figure_shows_the_web_on_roll_and_drum(wrapped):
    figure = wrapped.plot()
    tractions, slips, _, tension, pressure = figure.axes[:5]
    own, a = wrapped.in_nip, wrapped.half_width
    for axes in (tractions, slips):  # the nip's nodes, no others
        assert all(len(data) == wrapped.nodes for data in curves(axes).values())
    assert tension.get_ylabel() == "Web tension $T$ [N/m]"
    assert pressure.get_ylabel() == "Pressure $p$ [kPa]"
    assert pressure.get_xlabel() == r"Angle from the edge of the nip $\theta$ [deg]"
    on_roll = curves(tension)["$T$ on roll"]
    angle = (wrapped.x[own.stop :] - a) / 0.1
    np.testing.assert_allclose(on_roll[:, 0], np.degrees(angle))
    np.testing.assert_allclose(on_roll[:, 1], wrapped.tension[own.stop :])
    assert on_roll[-1, 1] == pytest.approx(wrapped.wound_on_tension)
    assert rf"$\mathrm{{WOT}}$ {wrapped.wound_on_tension:.5g} N/m" in curves(tension)
    assert curves(tension)["end of slip"][0][0] == pytest.approx(np.degrees(wrapped.slip_angle))
    on_drum = curves(tension)["$T$ on drum"]
    angle = (-a - wrapped.x[: own.start]) / 0.0762
    np.testing.assert_allclose(on_drum[:, 0], np.degrees(angle))
    np.testing.assert_allclose(on_drum[:, 1], wrapped.tension[: own.start])
    drawn = curves(pressure)
    np.testing.assert_allclose(drawn["$p^{+}$"][:, 1], 1e-3 * wrapped.roll_pressure[own.stop :])
    np.testing.assert_allclose(drawn["$p^{-}$"][:, 1], 1e-3 * wrapped.drum_pressure[: own.start])
    # the friction of the wrap is its own field; where the web slips, the traction reaches its bound
    needed = drawn[r"$|q^{+}|/\mu^{+}$"][:, 1]
    np.testing.assert_allclose(needed, 1e-3 * np.abs(wrapped.roll_traction[own.stop :]) / 0.3)
    assert needed[0] == pytest.approx(drawn["$p^{+}$"][0, 1])


# ---- two rollers


@pytest.mark.parametrize(
    ("changes", "theory", "name"),
    [
        ({}, wo.theories.carter, "Carter"),
        ({"motion": "static"}, wo.theories.cattaneo, "Cattaneo"),
        (
            {"lower": wo.HalfPlane(radius=0.2, material=SOFT), "tangential_load": None},
            wo.theories.bentall_johnson_stick,
            "Bentall-Johnson, no slip",
        ),
    ],
)
def test_rollers_are_drawn_with_the_closed_form_that_applies(changes, theory, name):
    result = wo.solve(wo.RollerProblem.example().replace(**changes), nodes=NODES)
    tractions, slips, zones = result.plot().axes
    assert tractions.get_ylabel() == "Pressure $p$, traction $q$ [MPa]"
    lines = tractions.get_lines()
    assert [line.get_label() for line in lines] == ["$p$", "$q$ on upper roller", name, name]
    np.testing.assert_allclose(lines[0].get_ydata(), 1e-6 * result.pressure)
    np.testing.assert_allclose(lines[1].get_ydata(), 1e-6 * result.traction)
    assert highest(tractions) == pytest.approx({r"$\pm \mu p$": 0.5e-6 * result.peak_pressure})
    exact = theory(result.problem)
    for marks, form in zip(lines[2:], (exact.pressure, exact.traction), strict=True):
        at = 1e-3 * marks.get_xdata()
        assert np.all(np.abs(at) <= result.half_width * (1 + 1e-12))
        np.testing.assert_allclose(marks.get_ydata(), 1e-6 * form(at))
    rolling = result.problem.motion == "rolling"
    factor, label = (100, "Relative slip speed $v$ [%]") if rolling else (1e6, "Slip $v$ [µm]")
    assert slips.get_ylabel() == label
    np.testing.assert_allclose(slips.get_lines()[0].get_ydata(), factor * result.slip)
    assert sum(bar.get_width() for bar in zones.patches) == pytest.approx(2e3 * result.half_width)


# ---- any kind


@pytest.mark.slow
def test_the_default_draws_every_array_once(results):
    for result in results.values():
        figure = plot_outputs(result)
        arrays = {
            place.path: place
            for place in quantities.walk(result)
            if isinstance(place.value, np.ndarray) and place.value.size > 1
        }
        first = next(iter(arrays))
        along = {name: result.ALONG.get(name, first) for name in arrays}
        shown = [name for name, over in along.items()
                 if name not in along.values()
                 and arrays[over].value.shape == arrays[name].value.shape]  # fmt: skip
        drawn = [line for axes in figure.axes for line in axes.get_lines()]
        assert len(drawn) == len(shown)
        for name in shown:
            place, x = arrays[name], arrays[along[name]]
            meaning = place.quantity.meaning.replace("> 0", ">\N{NO-BREAK SPACE}0")
            label = f"{symbol_text(place.quantity.symbol)} {meaning}"
            (line,) = [k for k in drawn if k.get_label().replace("\n", " ") == label]
            np.testing.assert_allclose(line.get_xdata(), 1e3 * x.value)
            np.testing.assert_allclose(line.get_ydata(), place.quantity.shown(place.value))
            unit = place.quantity.display.replace("um", "µm").replace("^3", "³")
            assert line.axes.get_ylabel().endswith(f"[{unit}]" if unit else "")
        assert figure.axes[-1].get_xlabel().endswith("[mm]")


# ---- every figure


SLOW = pytest.mark.slow
# one of every layout; the others differ from them in what is drawn
FIGURES: dict[str, Callable[[dict[str, Any]], Any]] = {
    **{kind.name: lambda r, kind=kind.name: r[kind].plot() for kind in kinds.every()},
    "wrapped on both": lambda r: r["wrapped on both"].plot(),
    "without wraps": lambda r: r["without wraps"].plot(),
    "by default": lambda r: plot_outputs(r["without wraps"]),
    "two": lambda r: wo.plot([r["without wraps"], r["nip"]]),
}
LIKE_OTHERS = ("nip", "without wraps", "winding")  # panels of other nips, and of rolls
MORE_FIGURES: dict[str, Callable[[dict[str, Any]], Any]] = {
    **{
        name: lambda r, name=name: r[name].plot()
        for name in (
            "soft cover",
            "air",
            "drum wrap alone",
            "drum slides",
            "static",
            "free rolling",
        )
    },
    "rollers by default": lambda r: plot_outputs(r["rollers"]),
    "two wrapped": lambda r: wo.plot([r["nip"], r["soft cover"]]),
    "two rollers": lambda r: wo.plot([r["rollers"], r["free rolling"]]),
    "chosen": lambda r: r["nip"].plot(panels=["wrap_tension", "curvature", "pressure"]),
    "one": lambda r: r["nip"].plot(panels="zones"),
}


@pytest.mark.parametrize(
    "draw",
    [
        *(
            (slow_case if name in LIKE_OTHERS else pytest.param)(draw, id=name)
            for name, draw in FIGURES.items()
        ),
        *(pytest.param(draw, id=name, marks=SLOW) for name, draw in MORE_FIGURES.items()),
    ],
)
def test_nothing_is_covered_or_clipped(results, draw):
    """Legends stand outside the data, no text leaves the figure, and none covers another."""
    figure = draw(results)
    canvas = FigureCanvasAgg(figure)
    figure.draw_without_rendering()
    width, height = canvas.get_width_height()
    texts = list(figure.legends)
    for axes in figure.axes:
        box = axes.get_tightbbox()
        assert min(box.x0, box.y0) >= 0
        assert (box.x1 <= width, box.y1 <= height) == (True, True)
        texts += [axes.yaxis.label, axes.xaxis.label, axes._right_title]
        legend = axes.get_legend()
        if legend is not None:
            assert not legend.get_window_extent().overlaps(_shrunk(axes))
            texts.append(legend)
    boxes = [text.get_window_extent() for text in texts if _said(text)]
    for k, one in enumerate(boxes):
        assert not any(one.overlaps(other) for other in boxes[:k])


def _said(text: Any) -> bool:
    return not hasattr(text, "get_text") or bool(text.get_text())


def _shrunk(axes: Any) -> Any:
    """Return the panel less a pixel all around."""
    return axes.get_window_extent().padded(-1)


@pytest.mark.parametrize(
    ("kind", "ending", "panels"),
    [  # formats differ in what they write next to the picture, which is the same for all kinds
        ("nip", "svg", ["tractions", "zones"]), ("rollers", "png", ["tractions"]),
        ("roll", "pdf", ["pressure"]), pytest.param("winding", "svg", None, marks=SLOW),
    ],
)  # fmt: skip
def test_the_same_result_gives_the_same_bytes(results, tmp_path, kind, ending, panels):
    """A second result too, that is solved again."""
    again = solve_coarsely(results[kind].problem, NODES)
    one, other = tmp_path / f"a.{ending}", tmp_path / f"b.{ending}"
    results[kind].plot(one, panels=panels)
    again.plot(other, panels=panels)
    assert one.read_bytes() == other.read_bytes()
    assert len(one.read_bytes()) > 10_000
    for date in (b"CreationDate", b"dc:date"):  # which within a second are the same
        assert date not in one.read_bytes()


def test_global_style_is_left_alone(nip):
    import matplotlib as mpl

    before = dict(mpl.rcParams)
    nip.plot()
    assert dict(mpl.rcParams) == before


# ---- studies


def table(output: str, quantity: wo.Quantity) -> Any:
    """Return a sweep over loads and moduli, 6 by 2."""
    loads = np.geomspace(100.0, 1e4, 6)
    cases = make_cases({"nip_load": loads, "roll.material.shear": np.array([5e6, 2e7])})
    known = {
        "nip_load": line_load("P", "nip load"),
        "roll.material.shear": stress("G", "shear modulus", "MPa"),
        output: quantity,
    }
    outputs = {output: np.outer(loads, [1.0, 2.0]).ravel()}
    return SimpleNamespace(cases=cases, outputs=outputs, quantities=known)


def test_a_sweep_is_drawn_in_the_units_of_its_quantities():
    swept = table("peak_pressure", stress("p_max", "largest pressure"))
    (axes,) = plot_sweep(swept, "peak_pressure").axes
    assert axes.get_xlabel() == "nip load [N/m]"
    assert axes.get_ylabel() == "largest pressure [kPa]"
    assert axes.get_xscale() == "log"
    low, high = axes.get_lines()
    assert (low.get_label(), high.get_label()) == ("shear = 5 MPa", "shear = 20 MPa")
    np.testing.assert_allclose(high.get_ydata(), 2e-3 * np.geomspace(100.0, 1e4, 6))


def grid(*shape: int) -> Any:
    """Return a sweep over so many values of one to four fields, its output their product."""
    names = ("nip_load", "web_tension", "roll_friction", "drum_friction")[: len(shape)]
    values = [np.linspace(1.0, 2.0, size) for size in shape]
    product = np.prod(np.meshgrid(*values, indexing="ij"), axis=0).ravel()
    cases = make_cases(dict(zip(names, values, strict=True)))
    return SimpleNamespace(cases=cases, outputs={"output": product}, quantities={})


@pytest.mark.parametrize(
    ("shape", "curves", "panels", "stated"),
    [((50, 10), 7, 1, [(7, 10)]), ((50, 7), 7, 1, []), ((50,), 1, 1, []),
     ((50, 10, 6), 7, 4, [(7, 10), (4, 6)]), ((50, 7, 6), 7, 4, [(4, 6)]),
     ((50, 8, 3, 2), 7, 3, [(7, 8)])],
)  # fmt: skip
def test_a_sweep_states_how_many_curves_and_panels_it_shows(shape, curves, panels, stated):
    figure = plot_sweep(grid(*shape), "output")
    assert len(figure.axes) == panels
    assert all(len(axes.get_lines()) == curves for axes in figure.axes)
    assert [axes.get_legend() for axes in figure.axes] == [None] * panels
    assert len(figure.legends) == (curves > 1)  # one of all panels
    figure.draw_without_rendering()
    widths = [axes.get_window_extent().width for axes in figure.axes]
    assert widths == pytest.approx([widths[0]] * panels, rel=1e-4)  # positions are rounded
    title = figure.get_suptitle()
    assert [f"{n} of {count}" in title for n, count in stated] == [True] * len(stated)
    assert title.count(" of ") == len(stated)
    assert ("drum friction" in title) == (len(shape) > 3)


def test_a_common_panel_that_is_not_drawn_by_default_can_be_chosen(nip, monkeypatch):
    on_request = {
        name: replace(maker, by_default=False) for name, maker in plots.named_panels(nip).items()
    }
    monkeypatch.setattr(plots, "named_panels", lambda result: on_request)
    assert wo.plot([nip, nip], panels="pressure").axes
    with pytest.raises(wo.InvalidProblem, match="no panel in common"):
        wo.plot([nip, nip])


@pytest.mark.parametrize(
    ("unit", "printed"), [("kg/m^3", "kg/m³"), ("m/s^2", "m/s²"), ("Pa*s", "Pa·s"), ("mm", "mm")]
)
def test_units_of_axes_have_typographic_powers_and_products(unit, printed):
    axis = Axis("Density", quantities.Quantity("rho", unit, "density"))
    assert axis_label(axis) == f"Density [{printed}]"


def test_panels_without_a_solution_say_so():
    swept = grid(3, 2, 2)
    swept.outputs["output"][::2] = np.nan  # the first value of the third input
    empty, drawn = plot_sweep(swept, "output").axes
    assert [text.get_text() for text in empty.texts] == ["no case was solved"]
    assert drawn.texts[:] == []
    assert empty.get_ylim() == drawn.get_ylim()
    swept.outputs["output"][:] = np.nan
    (axes,) = plot_sweep(swept, "output").axes
    assert [text.get_text() for text in axes.texts] == ["none of the 12 cases was solved"]
    assert not any(tick.label1.get_visible() for tick in axes.yaxis.get_major_ticks())


# ---- scales, labels and legends


def test_a_scale_of_colours_is_as_tall_as_its_panel(results):
    figure = results["roll"].plot(panels=["pressure", "hardness", "disc"])
    figure.draw_without_rendering()
    disc = figure.axes[-1]
    (bar,) = disc.child_axes
    assert bar.get_window_extent().height == pytest.approx(disc.get_window_extent().height)
    assert bar.get_window_extent().height < 0.8 * figure.bbox.height
    assert bar.get_ylabel() == "Pressure $P$ [kPa]"


@pytest.mark.parametrize("ends", [(3.1, 4.5), (1.2, 9.0), (6.0, 70.0), (2.0, 1500.0)])
def test_logarithmic_axes_have_at_least_three_labels(ends: tuple[float, float]):
    x = np.geomspace(*ends, 5)
    panel = Panel("a", Axis("x", log=True, limits=ends), Axis("y"), curves=(Curve("a", x, x),))
    (axes,) = draw_figure([[panel]]).axes
    figure = axes.figure
    figure.draw_without_rendering()
    labels = [text.get_text() for text in axes.get_xticklabels()]
    ticks = zip(axes.get_xticks(), labels, strict=True)
    assert len([label for tick, label in ticks if ends[0] <= tick <= ends[1] and label]) >= 3


def test_labels_with_formulas_are_wrapped_between_the_words():
    share = Quantity("d", "1", "thickness above the mean", "%")
    label = axis_label(Axis("Thickness above the mean $|sigma_t|/d$", share), 24)
    assert label == "Thickness above the mean\n$|\\sigma_{\\mathrm{t}}|/d$ [%]"
    assert axis_label(Axis("Hoop stress $sigma_t$", share), 18) == (
        "Hoop stress $\\sigma_{\\mathrm{t}}$ [%]"
    )


def test_numbers_of_a_narrow_drawing_to_scale_do_not_touch():
    x, y = np.array([-0.341, 1.0]), np.array([-0.38, 1.8])
    millimetres = Quantity("x", "m", "horizontal", "mm")
    axis = Axis("horizontal", millimetres, limits=(x[0], x[1]))
    panel = Panel(
        "a", axis, Axis("vertical", millimetres, limits=(y[0], y[1])), to_scale=True, height=3.6,
        curves=(Curve("a", x, y, label="a long name in the legend"),), legend="right",
    )  # fmt: skip
    (axes,) = draw_figure([[panel]]).axes
    axes.figure.draw_without_rendering()
    boxes = [text.get_window_extent() for text in axes.get_xticklabels() if text.get_text()]
    assert all(right.x0 - left.x1 > 4 for left, right in pairwise(boxes))


def test_an_axis_from_zero_has_room_above_its_curve():
    x = np.linspace(0.0, 1.0, 5)
    panel = Panel("a", Axis("x"), Axis("y", from_zero=True), curves=(Curve("a", x, 8 + 0.1 * x),))
    (axes,) = draw_figure([[panel]]).axes
    assert axes.get_ylim() == pytest.approx((0.0, 1.05 * 8.1))


def test_no_power_of_ten_stands_apart_from_the_labels():
    x = np.linspace(2.05e10, 2.3e10, 5)
    panel = Panel("a", Axis("x"), Axis("y"), curves=(Curve("a", x, 1e-7 * x),), width=3.1)
    (axes,) = draw_figure([[panel]]).axes
    axes.figure.draw_without_rendering()
    assert (axes.xaxis.get_offset_text().get_text(), axes.yaxis.get_offset_text().get_text()) == (
        "", "",
    )  # fmt: skip
    texts = [text.get_text() for text in axes.get_xticklabels()]
    assert [float(text) for text in texts] == pytest.approx(list(axes.get_xticks()))
    boxes = [text.get_window_extent() for text in axes.get_xticklabels()]
    assert not any(left.overlaps(right) for left, right in pairwise(boxes))


def test_legends_of_a_winding_name_all_that_is_drawn(results):
    figure = results["winding"].plot(panels=["pressure", "hoop_stress", "reserves"])
    pressure, hoop, reserves = (
        [text.get_text() for text in axes.get_legend().get_texts()] for axes in figure.axes
    )
    assert pressure == ["$P$ earlier stages", "$P$ finished roll"]
    assert [text.partition("$ ")[2] or text for text in hoop] == [
        "earlier stages", "finished roll", "compression",
    ]  # fmt: skip
    assert "slip" in reserves
    assert not any("_" in text for text in reserves)
