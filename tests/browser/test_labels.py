"""Labels of charts and drawings: none covers another or is cut off, axes name their quantities."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

import woundon as wo

# what canvases write, by their last drawing: text, its box and its turn, in pixels of the screen
RECORDED = """
const write = CanvasRenderingContext2D.prototype.fillText
const clear = CanvasRenderingContext2D.prototype.clearRect
CanvasRenderingContext2D.prototype.fillText = function (text, x, y, ...more) {
    const size = this.measureText(text)
    const at = this.getTransform()
    const points = [[-size.actualBoundingBoxLeft, -size.actualBoundingBoxAscent],
        [size.actualBoundingBoxRight, size.actualBoundingBoxDescent]]
        .map(([dx, dy]) => at.transformPoint(new DOMPoint(x + dx, y + dy)))
    if (text) (this.canvas.texts ??= []).push({ text,
        left: Math.min(...points.map(p => p.x)), right: Math.max(...points.map(p => p.x)),
        top: Math.min(...points.map(p => p.y)), bottom: Math.max(...points.map(p => p.y)) })
    return write.call(this, text, x, y, ...more)
}
CanvasRenderingContext2D.prototype.clearRect = function (...box) {
    this.canvas.texts = []
    return clear.call(this, ...box)
}
"""
WRITTEN = """() => Object.fromEntries([...document.querySelectorAll('[data-panel]')]
    .filter(panel => panel.querySelector('canvas')).map(panel => {
        const canvas = panel.querySelector('canvas')
        return [panel.dataset.panel, { texts: canvas.texts ?? [], width: canvas.width,
            height: canvas.height, ratio: devicePixelRatio }]
    }))"""

# boxes of the labels of drawings; points on their lines, corners of their hatches and arrow heads
DRAWN = """() => [...document.querySelectorAll('svg.scaled')].map(svg => {
    const box = part => part.getBoundingClientRect().toJSON()
    const hatched = part => getComputedStyle(part).fill.startsWith('url')
    const along = path => Array.from({ length: 201 }, (_, k) => {
        const at = path.getPointAtLength(k / 200 * path.getTotalLength())
        const { x, y } = new DOMPoint(at.x, at.y).matrixTransform(path.getScreenCTM())
        return [x, y]
    })
    return { labels: [...svg.querySelectorAll('text')].map(part => [part.textContent, box(part)]),
        areas: [...svg.querySelectorAll('circle, path')]
            .filter(part => hatched(part) || part.matches('.arrow')).map(box),
        lines: [...svg.querySelectorAll('.web, .turn, .dimension path:not(.arrow), .layer-line, ' +
            '.centre-line')].map(along),
        frame: box(svg) }
})"""


# numbers that are longer than their box
CUT_OFF = """() => [...document.querySelectorAll('input.box')]
    .filter(box => box.scrollWidth > box.clientWidth).map(box => `${box.id} ${box.value}`)"""


def overlap(a, b, slack=1.0):
    """Tell whether two boxes overlap by more than a slack [px]."""
    return (
        min(a["right"], b["right"]) - max(a["left"], b["left"]) > slack
        and min(a["bottom"], b["bottom"]) - max(a["top"], b["top"]) > slack
    )


def inside(box, frame, slack=1.0):
    """Tell whether a box lies within another one."""
    return (
        box["left"] >= frame["left"] - slack and box["right"] <= frame["right"] + slack
        and box["top"] >= frame["top"] - slack and box["bottom"] <= frame["bottom"] + slack
    )  # fmt: skip


PHONE = pytest.param(390, marks=pytest.mark.slow)


@pytest.fixture(
    params=[(1280, 1600), pytest.param((390, 3200), marks=pytest.mark.slow)], ids=["desk", "phone"]
)
def recorded(request, look_with):
    """A page of a desk or a phone that keeps what its canvases write."""
    width, height = request.param
    return look_with(RECORDED, width=width, height=height)


def written(seen):
    """Return what each panel writes, after a look that nothing covers another or is cut off."""
    seen.rest()
    panels = seen.page.evaluate(WRITTEN)
    for name, panel in panels.items():
        frame = {"left": 0, "top": 0, "right": panel["width"], "bottom": panel["height"]}
        for label in panel["texts"]:
            assert inside(label, frame), (name, label)
        for a, b in itertools.combinations(panel["texts"], 2):
            assert not overlap(a, b), (name, a["text"], b["text"])
    return panels


def test_labels_of_axes_do_not_overlap(recorded):
    page = recorded.page
    page.wait_for_selector(
        "[data-panel=layer_slip] canvas"
    )  # with a scale of colours; the last one
    for system in ("mill", "SI"):
        page.click(f".segmented >> text={system}")
        panels = written(recorded)
        page.evaluate("() => document.querySelectorAll('.group').forEach(one => one.open = true)")
        assert page.evaluate(CUT_OFF) == []
        assert set(panels) >= {"tractions", "slips", "pressure", "wrap_tension", "layer_slip"}


def test_a_logarithmic_axis_is_labelled_however_far_it_is_zoomed(recorded):
    page = recorded.page
    plot = page.locator("[data-panel=wrap_tension] .plot")
    plot.scroll_into_view_if_needed()
    plot.focus()
    numbers = []
    for _ in range(6):
        (panel,) = (p for name, p in written(recorded).items() if name == "wrap_tension")
        below = max(label["bottom"] for label in panel["texts"] if is_number(label["text"]))
        ticks = [float(label["text"]) for label in panel["texts"]
                 if is_number(label["text"]) and abs(label["bottom"] - below) < 3]  # fmt: skip
        assert len(ticks) >= 2
        assert ticks == sorted(ticks)
        numbers.append(ticks)
        page.keyboard.press("+")
    whole = np.log10(numbers[0])
    np.testing.assert_allclose(whole, np.round(whole))  # decades
    assert len(whole) >= 4
    assert numbers[-1][-1] / numbers[-1][0] < 3


def test_labels_of_a_map_are_whole(recorded):
    page = recorded.page
    page.click("#tab-study")
    page.select_option("#study-first", "winding_force")  # with the longest label
    page.select_option("#study-second", "web_tension")
    for box, text in (
        ("first-0", "0"),
        ("first-1", "100"),
        ("first-count", "2"),
        ("second-count", "2"),
    ):
        page.fill(f"#study-{box}", text)
        page.locator(f"#study-{box}").blur()
    page.click("#study-run")
    page.wait_for_selector("text=Done in", timeout=60_000)
    texts = [label["text"] for label in written(recorded)["map"]["texts"]]
    assert sum("[N/m]" in text for text in texts) == 2


def is_number(text):
    """Tell whether a label is a number."""
    try:
        float(text)
    except ValueError:
        return False
    return True


@pytest.mark.slow
@pytest.mark.parametrize("width", [1280, PHONE])
def test_labels_of_the_drawing_cross_neither_hatches_nor_arrows(look, width):
    seen = look(width=width)
    page = seen.page
    page.evaluate("() => document.querySelectorAll('.group').forEach(one => one.open = true)")
    drums = ("rigid", "elastic cylinder on a core")
    for drum, wrap in ((drums[0], "0"), (drums[0], "135"), (drums[1], "90"), (drums[1], "170")):
        page.select_option("#f-drum", label=drum)
        seen.put("drum_wrap", wrap)
        drawings = page.evaluate(DRAWN)
        assert len(drawings) == 2
        for drawing in drawings:
            check_labels(drawing)


@pytest.mark.slow
@pytest.mark.parametrize("width", [1280, PHONE])
def test_labels_of_a_wide_nip_are_apart_from_each_other(look, width):
    """A soft cover makes a nip so wide that the web is drawn thicker than to scale."""
    seen = look(width=width)
    page = seen.page
    page.evaluate("() => document.querySelectorAll('.group').forEach(one => one.open = true)")
    page.select_option("#f-drum", label="layered (cover)")
    page.select_option("[id='f-drum-layers-0-material']", label="soft-cover")
    for thickness, web in (("20", "66"), ("12", "15")):
        seen.put("drum.layers.0.thickness", thickness)
        seen.put("web.thickness", web)
        for system in ("mill", "SI"):
            page.click(f".segmented >> text={system}")
            seen.rest()
            for drawing in page.evaluate(DRAWN):
                check_labels(drawing)


def test_labels_of_rollers_cross_nothing(look):
    seen = look()
    seen.page.select_option(".kind", "rollers")
    seen.put("upper.radius", "20")
    for drawing in seen.page.evaluate(DRAWN):
        check_labels(drawing)


def check_labels(drawing):
    """Look that the labels of a drawing are whole and apart from each other and from its lines."""
    labels = drawing["labels"]
    assert len(labels) >= 4
    for text, box in labels:
        assert inside(box, drawing["frame"]), text
        assert not any(overlap(box, area) for area in drawing["areas"]), text
        for x, y in itertools.chain(*drawing["lines"]):
            assert not (
                box["left"] < x < box["right"] and box["top"] + 1 < y < box["bottom"] - 1
            ), text
    for (one, a), (other, b) in itertools.combinations(labels, 2):
        assert not overlap(a, b, 3.0), (one, other)


@pytest.mark.parametrize("width", [1280, PHONE])
def test_the_axis_of_a_schedule_names_its_quantity(look, width):
    seen = look(width=width)
    page = seen.page
    page.click("#tab-winding")
    page.wait_for_selector(".schedule-plot")
    seen.rest()
    page.click(".design summary")
    page.wait_for_selector(".design .schedule-plot")
    for system, tension, pressure in (("SI", "N/m", "kPa"), ("mill", "pli", "psi")):
        page.click(f".segmented >> text={system}")
        seen.rest()
        labels = page.eval_on_selector_all(
            ".schedule-plot", """plots => plots.map(plot => ({
                frame: plot.getBoundingClientRect().toJSON(),
                knobs: [...plot.querySelectorAll('.knob')].map(knob =>
                    knob.getBoundingClientRect().toJSON()),
                labels: [...plot.querySelectorAll('text')].map(text =>
                    ({ text: text.textContent, ...text.getBoundingClientRect().toJSON() })) }))"""
        )  # fmt: skip
        for plot, quantity, unit in zip(labels, ("tension", "pressure"), (tension, pressure),
                                        strict=True):  # fmt: skip
            texts = [label["text"] for label in plot["labels"]]
            assert any(quantity in text and f"[{unit}]" in text for text in texts)
            assert any("Radius" in text for text in texts)
            assert all(inside(label, plot["frame"]) for label in plot["labels"])
            for a, b in itertools.combinations(plot["labels"], 2):
                assert not overlap(a, b, 3.0), (a["text"], b["text"])
            for label, knob in itertools.product(plot["labels"], plot["knobs"]):
                assert not overlap(label, knob), label["text"]


def test_the_whole_hoop_stress_is_shown_and_its_compression_enlarged(recorded):
    page = recorded.page
    page.click("#tab-winding")
    page.wait_for_selector("[data-panel=hoop_stress] canvas")
    page.wait_for_selector(".sections")  # with the report come the other outputs
    page.click(".more summary")
    page.wait_for_selector(".more canvas")
    panels = written(recorded)
    result = wo.solve(wo.RollProblem.example())
    stress = result.at_radius(np.linspace(result.radius[0], result.radius[-1], 241))["hoop_stress"]
    low, high = shown_range(panels["hoop_stress"])
    assert low < 1e-3 * stress.min()
    assert high > 1e-3 * stress.max()  # [kPa]
    low, high = shown_range(panels["compression"])
    assert low < 1e-3 * stress.min() < 0.8 * low  # it fills the panel
    assert high < -0.2 * low


def shown_range(panel):
    """Return the values at the lower and the upper end of a panel's y axis.

    The labels of the y axis stand left of the panel; those of the x axis below it.
    """
    labels = [(one["text"].replace("−", "-"), one) for one in panel["texts"]]
    left = min(one["right"] for text, one in labels if is_number(text))
    ticks = [(float(text), (one["top"] + one["bottom"]) / 2) for text, one in labels
             if is_number(text) and one["right"] < left + 5]  # fmt: skip
    below = max(
        one["top"] for text, one in labels if is_number(text)
    )  # of the labels of the x axis
    values, places = zip(*ticks, strict=True)
    slope, start = np.polyfit(places, values, 1)
    ratio = panel["ratio"]
    return slope * (below - 10 * ratio) + start, slope * 8 * ratio + start
