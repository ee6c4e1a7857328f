"""The address of the page: reload, links, back and forward; a server that is restarted."""

from __future__ import annotations

import base64
import json
import zlib

import pytest
from page_server import serving

import woundon as wo

CLOSE = 1e-7  # a solve from the previous case and a cold one


def fragment_of(state):
    """Return the fragment that holds a state."""
    packed = zlib.compress(json.dumps(state).encode())
    return "#" + base64.urlsafe_b64encode(packed).decode().rstrip("=")


def test_a_reload_keeps_case_tab_units_and_pins(look):
    seen = look()
    page = seen.page
    assert page.evaluate("() => location.hash") == ""
    seen.put("nip_load", "20 pli")
    page.click(".pin")
    seen.put("nip_load", "5000")
    page.click(".segmented >> text=mill")
    number = seen.output("wound_on_tension")
    seen.held(lambda state: state["case"]["nip_load"] == 5000 and state["system"] == "mill")
    page.reload()
    page.wait_for_selector(".chip.pin-A")
    seen.rest()
    assert seen.output("wound_on_tension") == pytest.approx(number, rel=CLOSE)
    assert float(seen.box("nip_load")) == pytest.approx(5000 / 175.1268352, rel=1e-5)
    page.fill("#f-drum_friction", "50")  # rejected, and to be corrected after a reload too
    assert page.locator(".fault").count() == 1
    page.click("#tab-fit")
    seen.held(lambda state: state["tab"] == "fit")
    page.reload()
    page.wait_for_selector("#fit-table")


def test_a_reload_at_once_keeps_the_last_change(look):
    """Before the address follows, 0.3 s later; from an address without a state and with one."""
    seen = look()
    page = seen.page
    for value in ("5000", "6000"):
        page.evaluate(
            """value => {
                const box = document.querySelector("[data-path=nip_load] .box")
                box.value = value
                for (const name of ["input", "change"]) {
                    box.dispatchEvent(new Event(name, { bubbles: true }))
                }
                box.blur()
                setTimeout(() => location.reload())
            }""",
            value,
        )
        page.wait_for_function(
            "value => document.querySelector('[data-path=nip_load] .box')?.value === value"
            " && performance.getEntriesByType('navigation')[0].type === 'reload'",
            arg=value,
        )
        seen.rest()
        seen.held(lambda state, load=float(value): state["case"]["nip_load"] == load)
    # what was left is not taken twice, nor by another address
    assert page.evaluate("() => sessionStorage.length") == 0
    assert look().box("nip_load") != "6000"


def test_a_case_without_a_steady_state_is_kept_with_its_error(look):
    seen = look()
    seen.put("winding_force", "5000")
    seen.held(lambda state: state["case"]["winding_force"] == 5000)
    seen.page.reload()
    seen.page.wait_for_selector("[data-path=winding_force] .fault")
    assert seen.box("winding_force") == "5000"


def test_tabs_are_entries_of_the_history(look):
    seen = look()
    page = seen.page
    page.click("#tab-study")
    seen.put("web_tension", "400")
    assert page.input_value("#study-first") == "web_tension"  # a study is of what was changed
    page.click("#tab-fit")
    page.go_back()
    page.wait_for_selector("#study-run")
    page.go_back()
    page.wait_for_selector("[data-output=wound_on_tension]")
    assert seen.box("web_tension") == "400"  # tabs go back, the case does not: that is undone
    page.go_forward()
    page.wait_for_selector("#study-run")
    seen.held(lambda state: state["tab"] == "study")
    assert page.get_attribute("#tab-study", "aria-selected") == "true"


def test_damaged_addresses_are_rejected(look):
    seen = look()
    seen.put("nip_load", "4000")
    state = seen.held(lambda state: state["case"]["nip_load"] == 4000)
    good = fragment_of(state)
    middle = len(good) // 2
    other = "A" if good[middle] != "A" else "B"
    fragments = [
        good[:middle] + other + good[middle + 1 :],
        good[:middle],
        "#" + "A" * 40_000,
        fragment_of(" " * 2_000_000),
        fragment_of(state | {"kind": "roll"}),
        fragment_of(state | {"kind": "no such"}),
        fragment_of(state | {"case": state["case"] | {"web": 5}}),
        fragment_of(state | {"case": state["case"] | {"drum": {"kind": "<img src=x>"}}}),
        fragment_of([]),
    ]
    seen.open(fragments[0])
    assert seen.page.locator("#notice").count() == 1
    assert seen.box("nip_load") == "3502"
    enter, box = "fragment => { location.hash = fragment }", "'[data-path=nip_load] .box'"
    for number, fragment in enumerate(fragments):
        load = 4000 + number
        seen.page.evaluate(enter, fragment_of(state | {"case": state["case"] | {"nip_load": load}}))
        seen.page.wait_for_function(f"() => document.querySelector({box}).value === '{load}'")
        assert seen.page.locator("#notice").count() == 0
        seen.page.evaluate(enter, fragment)
        seen.page.wait_for_selector("#notice")
        assert seen.box("nip_load") == str(load), fragment[:80]


def tables(problem):
    """Return the tables of a problem, as the page holds them."""
    return problem.model_dump(mode="json", exclude_none=True)


def test_the_tab_winding_starts_with_the_values_of_the_nip(look):
    # no nip of a winding is solved, which takes seconds
    winding = wo.WindingProblem.example().replace(tension_law="friction")
    nip, others = tables(wo.NipProblem.example()), {"winding": tables(winding)}
    seen = look(fragment_of({"kind": "nip", "case": nip, "others": others, "pins": []}))
    page = seen.page
    for path, text in (("web.thickness", "80"), ("roll.radius", "200"), ("roll.core_radius", "50"),
                       ("web_tension", "300")):  # fmt: skip
        seen.put(path, text)
    page.evaluate("() => document.querySelectorAll('.group').forEach(one => one.open = true)")
    nip = wo.NipProblem.example()
    nip = nip.replace(**{"web.thickness": 80e-6, "roll.radius": 0.2, "roll.core_radius": 0.05})
    wound_on = wo.solve(nip.replace(web_tension=300)).roll_wound_on_tension
    page.click("#tab-winding")
    page.wait_for_selector(".schedule-plot")
    seen.rest()
    roll = wo.RollProblem.example().replace(
        **{"web_thickness": 80e-6, "radius": 0.2, "core.radius": 0.05, "wound_on_tension": wound_on}
    )
    # the tension is taken over with five digits
    assert seen.output("core_pressure") == pytest.approx(wo.solve(roll).core_pressure, rel=1e-4)
    seen.put("web_thickness", "90")
    page.select_option(".kind", "winding")
    page.wait_for_selector("[id='f-tension_law']")
    assert seen.box("web.thickness") == "80"
    assert [seen.box(path) for path in ("radius", "core.radius")] == ["200", "50"]
    assert seen.box("web_tension") == "300"
    page.click("#tab-case")
    seen.rest()
    assert seen.box("web.thickness") == "80"
    seen.put("roll.radius", "250")
    page.click("#tab-winding")
    page.wait_for_selector(".schedule-plot")
    # what has changed in the nip since then, and what was entered for the roll
    assert [seen.box(path) for path in ("radius", "web_thickness")] == ["250", "90"]


@pytest.mark.slow
def test_a_restarted_server_is_explained_and_the_page_continues(browser):
    page = browser.new_page()
    shown = "[data-output=wound_on_tension] .value"
    with serving() as server:
        port = server.address.rpartition(":")[2]
        page.goto(server.address)
        number = page.get_attribute(shown, "data-si", timeout=60_000)
    page.fill("#f-nip_load", "5000")
    page.wait_for_selector("#lost")
    assert "does not respond" in page.inner_text("#lost")
    assert "woundon app" in page.inner_text("#lost")
    assert page.get_attribute(shown, "data-si") == number
    with serving("--port", port):
        page.wait_for_selector("#lost", state="detached", timeout=60_000)
        page.wait_for_selector(f"{shown}:not([data-si='{number}'])", timeout=60_000)
        result = wo.solve(wo.NipProblem.example().replace(nip_load=5000))
        found = float(page.get_attribute(shown, "data-si"))
        assert found == pytest.approx(result.wound_on_tension, rel=CLOSE)
    page.close()
