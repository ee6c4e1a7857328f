"""Values keep their size when the page changes its units: what was typed, ranges, limits, zooms."""

from __future__ import annotations

import math
import re

import pytest

# [SI]; the inch and the pound-force are defined, NIST SP 811
INCH, POUND = 0.0254, 4.4482216152605
SIZES = {
    "": 1, "N/m": 1, "pli": POUND / INCH, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9, "Pa": 1,
    "psi": POUND / INCH**2, "ksi": 1e3 * POUND / INCH**2, "m": 1, "mm": 1e-3, "µm": 1e-6,
    "ft": 12 * INCH, "in": INCH, "mil": 1e-3 * INCH, "m/min": 1 / 60, "fpm": INCH / 5,
    "kg/m³": 1, "lb/ft³": 0.45359237 / (12 * INCH) ** 3, "°": math.pi / 180, "%": 0.01,
    "1/K": 1, "K": 1, "°F": 5 / 9, "1/°F": 9 / 5, "N": 1, "m/s²": 1, "ft/s²": 12 * INCH, "s": 1,
}  # fmt: skip
DIGITS = 1e-5  # boxes show six digits, rounded twice here
POINT_DIGITS = 1e-3  # points of schedules show four

# texts and units of boxes, lists of numbers and points of schedules
SHOWN = r"""() => {
    const unitOf = (box) => box.closest(".limit")?.innerText
        ?? box.closest(".field")?.querySelector(".unit").innerText
        ?? box.parentElement.innerText.match(/\[(.*)\]|$/)[1]
    const boxes = [...document.querySelectorAll("input[inputmode=decimal], .field.list textarea")]
    const points = [...document.querySelectorAll(".knob")].map((knob) => knob.ariaValueText)
    return [
        ...boxes.flatMap((box) => box.value.split("\n").map((line, k) => [
            k ? `${box.id}-${k}` : box.id, line, unitOf(box) ?? ""])),
        ...points.map((text, k) => [`point-${k}`, ...text.match(/: (\S+) (\S+) at/).slice(1)]),
    ].filter(([, text]) => text)
}"""


def values(page):
    """Return the values [SI] of all boxes and points by their names."""
    found = page.evaluate(SHOWN)
    return {name: float(text) * SIZES[unit.strip(" []")] for name, text, unit in found}


def compare_systems(seen, *typed):
    """Type texts into boxes, in SI; values are the same in mill units, and in SI again."""
    page = seen.page
    for box, text in typed:
        page.fill(box, text)
        page.locator(box).blur()
    before = values(page)
    for system in ("mill", "SI"):
        page.click(f".segmented >> text={system}")
        seen.rest()
        after = values(page)
        assert after.keys() == before.keys()
        for name, value in before.items():
            digits = POINT_DIGITS if name.startswith("point") else DIGITS
            assert after[name] == pytest.approx(value, rel=digits), name
    return before


def test_every_box_of_a_nip_keeps_its_value(look):
    seen = look()
    found = compare_systems(seen, ("#find-target", "600"), ("#f-nip_load", "3500"))
    assert found["find-target"] == 600
    assert found["f-nip_load"] == 3500
    assert found["f-web-thickness"] == pytest.approx(66e-6)
    seen.page.click(".segmented >> text=mill")
    seen.put("nip_load", "25")
    seen.page.click(".segmented >> text=SI")
    assert values(seen.page)["f-nip_load"] == pytest.approx(25 * SIZES["pli"], rel=DIGITS)
    seen.page.select_option("#find-output", "nip_width")  # 600 N/m is no width
    assert seen.page.input_value("#find-target") == ""
    seen.page.click("#tab-study")
    found = compare_systems(seen, ("#study-first-0", "3000"), ("#study-first-1", "20 pli"))
    assert found["study-first-0"] == 3000
    seen.page.click("#tab-fit")
    seen.page.select_option("#fit-field-0", "web.thickness")
    found = compare_systems(seen, ("#fit-0-0", "50"))
    assert found["fit-0-0"] == pytest.approx(50e-6)


def test_every_box_of_a_winding_keeps_its_value(look):
    seen = look()
    page = seen.page
    page.click("#tab-winding")
    page.wait_for_selector(".schedule-plot")
    page.focus(".knob >> nth=2")
    page.keyboard.press("ArrowDown")
    seen.rest()
    found = compare_systems(seen)
    assert found["f-wound_on_tension-value"] == 350
    page.select_option(".kind", "winding")
    page.wait_for_selector("[id='f-tension_law']")
    page.select_option("[id='f-tension_law']", label="friction")  # no nip is solved
    page.wait_for_selector(".margins", timeout=60_000)
    seen.rest()
    found = compare_systems(seen, ("#limit-blocking", "900"))
    assert found["limit-blocking"] == found["f-limits-blocking_pressure"] == 900e3
    page.click("#tab-window")
    found = compare_systems(seen, ("#window-web_tension-0", "250"))
    assert found["window-web_tension-0"] == 250


def test_a_text_without_a_value_is_dropped_with_the_units_it_was_typed_in(look):
    seen = look()
    page = seen.page
    page.fill("#find-target", "600 parsec")
    assert "unknown unit" in page.inner_text(".find .fault")
    assert page.is_disabled("#find-run")
    page.fill("#f-nip_load", "3000 parsec")
    page.click(".segmented >> text=mill")
    assert page.input_value("#find-target") == ""
    assert float(page.input_value("#f-nip_load")) == pytest.approx(3502 / SIZES["pli"], rel=DIGITS)
    assert page.locator(".fault").count() == 0
    page.click("#tab-study")
    page.fill("#study-first-0", "2e3 parsec")
    assert page.is_disabled("#study-run")  # and what was typed stays to be corrected
    assert page.input_value("#study-first-0") == "2e3 parsec"


def test_a_panel_stays_zoomed_into_the_same_range(look):
    seen = look()
    page = seen.page
    page.focus("[data-panel=pressure] .plot")
    page.keyboard.press("+")

    def position():
        """Return x [m] at a quarter of the width."""
        box = page.locator("[data-panel=pressure] .u-over").bounding_box()
        page.mouse.move(box["x"] + box["width"] / 4, box["y"] + box["height"] / 2)
        place = page.locator("[data-panel=pressure] .at", has_text=re.compile(r"\d"))
        number = place.inner_text().split()[-2].replace("−", "-")
        return float(number) * SIZES[place.get_attribute("data-unit")]

    before = position()
    page.click(".segmented >> text=mill")
    seen.rest()
    # a pixel is read at most two nodes apart, of some hundred in the nip
    assert position() == pytest.approx(before, rel=0.05)
