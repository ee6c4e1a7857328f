"""Invalid input and units: where errors stand and in which units; which units fields read."""

from __future__ import annotations

import pytest

import woundon as wo

PLI = 175.1268352464764  # [N/m]
CLOSE = 1e-7  # a warm start and a cold start agree to the tolerance of the iteration


@pytest.fixture(scope="module")
def example():
    """The case that the page begins with."""
    return wo.NipProblem.example()


@pytest.mark.parametrize("text", ["5000", "ten"])
def test_a_change_of_the_kind_with_an_invalid_field_leaves_no_empty_page(look, example, text):
    seen = look()
    page = seen.page
    seen.put("winding_force", text)
    page.select_option(".kind", "rollers")
    seen.rest()
    assert page.locator("main .quiet", has_text="solving").count() == 0
    assert page.locator("main .notice").count() == 0
    rollers = wo.solve(wo.RollerProblem.example())
    assert seen.output("creepage") == pytest.approx(rollers.creepage, rel=CLOSE)
    page.select_option(".kind", "nip")
    seen.rest()
    assert page.locator("main .quiet", has_text="solving").count() == 0
    if text == "5000":  # the drum slides
        error = page.inner_text("main .notice")
        assert "winding force" in error
        assert "drum slips" in error
        assert page.locator("[data-path=winding_force] .fault").count() == 1
        seen.put("winding_force", "100")
    result = wo.solve(example.replace(winding_force=100.0 * (text == "5000")))
    assert seen.output("wound_on_tension") == pytest.approx(result.wound_on_tension, rel=CLOSE)
    assert page.locator("main .notice").count() == 0


def test_a_field_reads_the_units_that_the_command_line_reads(look, example):
    seen = look()
    for path, text in (
        ("nip_load", "20 pli"), ("web_tension", "400 N*m**-1"), ("web.thickness", "70 µm"),
        ("roll_wrap", "170°"), ("web.material.radial", "4 ksi"), ("drum_friction", "25 %"),
    ):  # fmt: skip
        seen.put(path, text)
        assert seen.page.locator(".fault").count() == 0
        example = example.replace(**{path: text.replace("µm", "um").replace("°", " deg")})
    result = wo.solve(example)
    assert seen.output("wound_on_tension") == pytest.approx(result.wound_on_tension, rel=CLOSE)


def test_units_are_read_in_lists_and_studies(look):
    seen = look()
    page = seen.page
    page.click("#tab-study")
    page.fill("#study-first-0", "20 pli")
    page.emulate_media(color_scheme="dark")  # the page is drawn again, as when results arrive
    seen.rest()
    assert page.input_value("#study-first-0") == "20 pli"
    page.locator("#study-first-0").blur()
    page.wait_for_function("() => document.querySelector('#study-first-0').value === '3502.54'")
    page.click("#tab-winding")
    page.wait_for_selector(".schedule-plot")
    page.select_option("[id='f-wound_on_tension']", label="points over the radius")
    seen.rest()
    page.fill("#f-wound_on_tension-radius", "4.45 cm\n3.5 in\n150")
    page.fill("#f-wound_on_tension-value", "2 pli\n0.3 kN/m\n250")
    page.locator("#f-wound_on_tension-value").blur()
    seen.rest()
    profile = wo.Profile(radius=[0.0445, 3.5 * 0.0254, 0.15], value=[2 * PLI, 300, 250])
    result = wo.solve(wo.RollProblem.example().replace(wound_on_tension=profile))
    assert seen.output("core_pressure") == pytest.approx(result.core_pressure, rel=CLOSE)


def test_a_unit_that_does_not_fit_is_rejected_at_its_field(look):
    seen = look()
    before = seen.output("wound_on_tension")
    for text, words in (
        ("20 kg", ["'kg'", "N/m"]), ("20 constructor", ["unknown unit"]),
        ("20 pli pli", ["'pli pli'"]), ("1e400", ["number"]),
    ):  # fmt: skip
        seen.put("nip_load", text)
        error = seen.page.inner_text("[data-path=nip_load] .fault")
        assert all(word in error for word in words)
        assert seen.output("wound_on_tension") == before


def test_errors_of_the_server_are_in_the_units_of_their_fields(look):
    seen = look()
    fault = "[data-path='roll.core_radius'] .fault"
    seen.put("roll.core_radius", "200")
    assert "200 is out of range" in seen.page.inner_text(fault)
    assert "0.9995 * radius = 99.95 [mm]" in seen.page.inner_text(fault)
    assert "99.95 [mm]" in seen.page.inner_text("main .notice")
    seen.page.click(".segmented >> text=mill")
    error = seen.page.inner_text(fault)
    assert "7.87402 is out of range" in error
    assert "3.93504 [in]" in error


def test_errors_of_points_over_the_radius_stand_at_their_list(look):
    seen = look()
    page = seen.page
    page.click("#tab-winding")
    page.select_option("[id='f-wound_on_tension']", label="points over the radius")
    seen.rest()
    page.fill("#f-wound_on_tension-radius", "50\n80\n100\n120\n150")
    page.locator("#f-wound_on_tension-radius").blur()
    seen.rest()
    error = page.inner_text("[data-path='wound_on_tension.radius'] .fault")
    assert "50 is out of range" in error
    assert "44.5 [mm]" in error
