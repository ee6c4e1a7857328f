"""Winders on the page: two drums, drawn to scale, and a centre winder without a nip."""

from __future__ import annotations

import tomllib

import pytest

import woundon as wo
from woundon.io.case_files import make_problem


def test_a_winding_gets_a_winder_in_the_form(look):
    """The page's result is that of the case that it saves."""
    seen = look(width=1366, height=900)
    page = seen.page
    seen.winding_without_nips()
    for group in ("winder", "drum", "operation"):
        page.evaluate(f"document.querySelector('[data-group={group}]').open = true")
    page.select_option("#f-winder", "TwoDrums")
    page.select_option("#f-nip_load", label="none")
    page.select_option("#f-torque_split", label="one number")
    for name, value in (
        ("torque_split", "0.5"), ("winder.front_drum.radius", "250"), ("winder.gap", "20"),
        ("winder.rider_load", "2500"),
    ):  # fmt: skip
        seen.put(name, value)
    assert page.locator(".fault").count() == 0
    problem = make_problem(tomllib.loads(seen.saved("Save the case").decode()))
    assert problem.winder == wo.TwoDrums(
        front_drum=wo.Rigid(radius=0.25), gap=0.02, rider_load=2500.0
    )
    result = wo.solve(problem)
    tension = seen.output("mean_wound_on_tension")
    assert tension == pytest.approx(result.mean_wound_on_tension, rel=1e-6)
    assert page.inner_text(".margins").count("slip of a drum") == 1
    before = seen.drawn("[data-panel=winder]")
    seen.put("winder.gap", "40")
    seen.redrawn("[data-panel=winder]", before)


def test_a_centre_winder_without_a_nip_has_the_torque_of_its_core_drive(look):
    """Without load the drum can be left out; with width and speed the report has the drives."""
    seen = look(width=1366, height=900)
    page = seen.page
    seen.winding_without_nips()
    for group in ("drum", "operation", "inertia"):
        page.evaluate(f"document.querySelector('[data-group={group}]').open = true")
    for name, value in (("nip_load", "0"), ("width", "2.5"), ("web_speed", "600")):  # m, m/min
        seen.put(name, value)
    page.select_option("#f-drum", label="none")
    seen.rest()
    problem = make_problem(tomllib.loads(seen.saved("Save the case").decode()))
    assert (problem.nip_load, problem.drum, problem.width) == (0.0, None, 2.5)
    result = wo.solve(problem)
    tension = seen.output("mean_wound_on_tension")
    assert tension == pytest.approx(result.mean_wound_on_tension, rel=1e-6)
    assert "largest torque of the core drive" in page.text_content("body")
    assert page.locator("sub", has_text="k,max").count() == 2  # of torque and power
    assert "a drum" not in page.inner_text(".margins")


def test_all_margins_of_a_roll_off_its_core_are_in_sight(look):
    """Without the core its pressure has no card; the words of all choices fit into their menus."""
    seen = look(width=1366, height=900)
    page = seen.page
    seen.winding_without_nips()
    page.evaluate("document.querySelectorAll('.group').forEach((group) => { group.open = true })")
    assert page.locator("[data-output=core_pressure]").count() == 1
    page.select_option("#f-core_removed", "true")
    page.wait_for_function("() => document.querySelectorAll('.margins tbody tr').length === 10")
    seen.rest()
    assert page.locator("[data-output=core_pressure]").count() == 0
    hidden = """() => {
        const table = document.querySelector(".margins").parentElement
        return table.scrollHeight - table.clientHeight
    }"""
    assert page.evaluate(hidden) == 0
    cut_off = """() => [...document.querySelectorAll(".field.choice select")].filter((menu) => {
        const width = menu.offsetWidth
        menu.style.width = "max-content"
        const needed = menu.offsetWidth
        menu.style.width = ""
        return width < needed
    }).map((menu) => menu.id)"""
    assert page.evaluate(cut_off) == []
