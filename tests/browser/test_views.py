"""How the page looks, and to whom it is open: sizes, schemes, keyboard, screen readers."""

from __future__ import annotations

import pytest

VIEWS = [
    (1280, 800, "light"),
    pytest.param(390, 844, "dark", marks=pytest.mark.slow),
    pytest.param(1280, 800, "dark", marks=pytest.mark.campaign),
    pytest.param(390, 844, "light", marks=pytest.mark.campaign),
]

# labels of numbers that are longer than their place
CLIPPED = """() => [...document.querySelectorAll('.number-card .what')]
    .filter(label => label.scrollHeight > label.clientHeight + 1).map(label => label.textContent)"""


def each_tab_fits(page, width, scheme):
    """Yield the tabs, each seen in turn, after a look at colours and width."""
    background = page.evaluate("() => getComputedStyle(document.body).backgroundColor")
    light = sum(map(int, background.removeprefix("rgb(").rstrip(")").split(","))) > 3 * 128
    assert light == (scheme == "light")
    for tab in page.eval_on_selector_all("[role=tab]", "tabs => tabs.map(tab => tab.id)"):
        page.click(f"#{tab}")
        yield tab
        wide = page.evaluate("() => document.scrollingElement.scrollWidth")
        assert wide <= width, tab


@pytest.mark.parametrize(("width", "height", "scheme"), VIEWS)
def test_a_view_fits_and_is_open_to_all(look, width, height, scheme):
    from axe_playwright_python.sync_playwright import Axe

    seen = look(width=width, height=height, color_scheme=scheme)
    page = seen.page
    page.click(".pin")
    for tab in each_tab_fits(page, width, scheme):
        seen.rest()
        assert page.evaluate(CLIPPED) == []
        found = Axe().run(page).response["violations"]
        serious = [one for one in found if one["impact"] in ("serious", "critical")]
        computed = [
            f"{tab}: {one['id']}: {node['html']}" for one in serious for node in one["nodes"]
        ]
        assert not computed


def test_all_can_be_done_with_the_keyboard(look):
    seen = look()
    page = seen.page
    page.keyboard.press("Tab")
    assert page.evaluate("() => document.activeElement.className") == "skip"
    page.keyboard.press("Enter")
    assert page.evaluate("() => document.activeElement.id") == "results"
    page.wait_for_selector(".sections")  # the last that moves the panels
    seen.rest()
    page.focus("[data-panel=pressure] .plot")
    page.keyboard.press("ArrowRight")
    page.keyboard.press("ArrowRight")
    assert seen.read("pressure") > 0  # under the cursor
    scale = "() => document.querySelector('[data-panel=pressure] .u-over').clientWidth"
    assert page.evaluate(scale) > 100
    seen.rest()
    before = seen.drawn("[data-panel=tractions]")
    page.keyboard.press("+")
    seen.redrawn("[data-panel=tractions]", before)  # zoomed together
    page.keyboard.press("0")
    page.keyboard.press("Escape")
    page.focus("#tab-case")
    page.keyboard.press("ArrowRight")
    assert page.get_attribute("#tab-study", "aria-selected") == "true"
    assert page.evaluate("() => document.activeElement.id") == "tab-study"  # arrows go on from it


@pytest.mark.slow
def test_it_fits_without_width_light_colour_and_motion(look):
    """A narrow dark screen; zones by patterns, curves as tables, nothing that moves."""
    seen = look(width=390, height=844, color_scheme="dark", reduced_motion="reduce")
    page = seen.page
    pattern = "() => getComputedStyle(document.querySelector('.zone.zone1')).fill"
    assert "hatch-faster" in page.evaluate(pattern)
    moving = """() => [...document.querySelectorAll('*')].filter(e => {
        const style = getComputedStyle(e)
        return style.animationName !== 'none' || style.transitionDuration !== '0s'
    }).length"""
    assert page.evaluate(moving) == 0
    page.evaluate("() => document.querySelector('.working').classList.add('busy')")
    assert page.evaluate(moving) == 0
    page.evaluate("() => document.querySelector('.working').classList.remove('busy')")
    page.click("button.tables")
    zones = page.inner_text(".cell-zones table")
    assert "stick" in zones
    assert "roll" in zones
    assert page.locator(".cell-tractions tbody tr").count() > 20
    page.click("button.tables")
    for _ in each_tab_fits(page, 390, "dark"):
        seen.rest()
