"""Find, grades, limits and operating windows on the page: it agrees with Python."""

from __future__ import annotations

import numpy as np
import pytest

import woundon as wo

CLOSE = 1e-6  # the page shows six digits of the value that it takes over


def test_the_nip_load_for_a_wound_on_tension_is_found_and_taken_over(look):
    seen = look(width=1366, height=768)
    page = seen.page
    page.fill("#find-target", "600")
    page.click("#find-run")
    page.wait_for_selector(".solutions li", timeout=60_000)
    found = page.inner_text(".solutions li")
    page.click(".solutions button")
    seen.rest()
    load = float(seen.box("nip_load"))
    assert f"nip load = {load:.5g} N/m" in found
    result = wo.solve(wo.NipProblem.example().replace(nip_load=load))
    # on another mesh: within the estimated errors
    apart = 2 * result.errors["wound_on_tension"]
    assert seen.output("wound_on_tension") == pytest.approx(600.0, abs=apart)
    page.select_option("#grade", "lwc")  # the solution is that of another web
    page.wait_for_selector(".solutions", state="detached")


@pytest.mark.slow
def test_a_target_out_of_reach_is_an_error_at_the_search(look):
    seen = look()
    seen.page.fill("#find-target", "20")  # less than the web tension
    seen.page.click("#find-run")
    seen.page.wait_for_selector(".find .fault", timeout=60_000)
    assert seen.page.locator(".solutions").count() == 0


def test_a_grade_fills_the_case(look):
    seen = look()
    page = seen.page
    assert page.locator("#grade option").count() == len(wo.grades()) + 1
    wide = "one => one.getBoundingClientRect().right <= one.closest('.left').clientWidth"
    assert page.eval_on_selector("#f-web-material", wide)
    page.select_option("#grade", "lwc")
    page.wait_for_function("() => document.querySelector('#f-web-thickness').value === '47'")
    seen.rest()
    result = wo.solve(wo.NipProblem.example().replace(grade="lwc"))
    assert seen.output("wound_on_tension") == pytest.approx(result.wound_on_tension, rel=CLOSE)
    seen.put("web.thickness", "50")  # it is that grade no more
    assert page.input_value("#grade") == ""


def test_the_answer_is_the_first_line_in_the_units_of_the_page(look):
    page = look(width=1366, height=768).page
    for place in (".answer", "[data-output=wound_on_tension]", "#find-run", "[data-panel=drawing]"):
        assert page.locator(place).bounding_box()["y"] < 700, place  # a laptop needs no scrolling
    top = "place => document.querySelector(place).getBoundingClientRect().top"
    assert page.evaluate(top, ".answer") < page.evaluate(top, ".certificate")
    page.click("text=mill")
    answer = "Wound-on tension 3.997 pli = web tension 1.999 pli + nip-induced tension 1.998 pli"
    assert page.inner_text(".answer") == answer


@pytest.mark.slow
def test_a_nip_takes_the_value_at_the_core_of_a_schedule_and_gives_it_back(look):
    seen = look()
    page = seen.page
    seen.winding_without_nips()
    taper = seen.box("web_tension.taper")
    for tab in ("study", "fit", "winding", "case"):  # each of them shows the kind of the case
        page.click(f"#tab-{tab}")
        assert page.input_value(".kind") == ("nip" if tab == "case" else "winding"), tab
    seen.rest()
    start = wo.WindingProblem.example().web_tension.start
    assert float(seen.box("web_tension")) == start
    assert page.locator(".notice").count() == 0
    page.click("#tab-winding")
    seen.rest()
    page.select_option(".kind", "winding")
    seen.rest()
    assert seen.box("web_tension.taper") == taper


@pytest.mark.slow
def test_the_roll_of_a_nip_is_of_the_grade_that_was_filled_into_a_winding(look):
    seen = look()
    page = seen.page
    page.click("#tab-winding")
    page.wait_for_selector(".schedule-plot")
    page.select_option("#grade", "lwc")
    page.wait_for_function("() => document.querySelector('#f-web_thickness').value === '47'")
    page.click("#tab-case")
    page.wait_for_selector("[data-output=wound_on_tension]")
    seen.rest()
    assert page.input_value("#grade") == "lwc"
    material = wo.NipProblem.example().replace(grade="lwc").roll.material
    assert float(seen.box("roll.material.tangential")) == material.tangential / 1e6
    assert page.locator(".warnings li", has_text="two papers").count() == 0


def test_formulas_of_labels_are_typeset(look):
    page = look().page
    label = page.locator("[data-path=winding_force] label")
    assert label.inner_text().replace("\xa0", " ").startswith("winding force (drum traction")
    assert label.locator("sub").all_inner_texts() == ["2", "2"]  # of -M2/R2
    quotient = "async () => (await import('/static/symbols.js')).symbolText('mu/mu0')"
    assert page.evaluate(quotient) == "μ/μ_0"


def test_a_limit_is_entered_next_to_its_margin_on_a_phone(look):
    seen = look(width=390, height=844)
    page = seen.page
    page.click("#tab-winding")
    page.wait_for_selector(".schedule-plot")
    page.select_option(".kind", "winding")
    page.click("[data-group=operation] summary")  # the form is shut, the answer above the fold
    page.select_option("[id='f-tension_law']", label="friction")  # no nip is solved
    page.wait_for_selector(".margins", timeout=60_000)
    seen.rest()
    assert page.evaluate("() => document.scrollingElement.scrollWidth") <= 390
    assert page.input_value("#limit-slip") == "100"  # [%], as the value next to it
    page.fill("#limit-blocking", "10000")  # [kPa]
    page.locator("#limit-blocking").blur()
    seen.rest()
    problem = wo.WindingProblem.example().replace(tension_law="friction")
    margins = wo.solve(problem.replace(limits={"blocking_pressure": "10 MPa"})).margins
    (blocking,) = (one for one in margins if one.name == "blocking")
    row = page.locator(".margins tr", has=page.locator("#limit-blocking"))
    assert page.evaluate("() => document.querySelector('.margins').scrollWidth") <= 390
    page.click("text=mill")  # numbers of six digits, "72.5189"
    seen.rest()
    cut_off = """() => [".table-scroll:has(> .margins)", "#limit-blocking"].filter((place) => {
        const box = document.querySelector(place)
        return box.scrollWidth > box.clientWidth
    })"""
    assert page.evaluate(cut_off) == []
    assert ("holds" if blocking.ok else "violated") in row.inner_text()


TABLE = "load [kN/m]\thalf_width [um]\n50\t265\n89\t354\n120\t411\n"


def test_a_pasted_table_is_fitted_and_the_estimate_taken_over(look):
    seen = look(width=1366, height=768)
    page = seen.page
    page.click("button.tables")
    page.select_option(".kind", "rollers")
    seen.rest()
    page.click("#tab-fit")
    page.click("#fit-example")
    assert page.input_value("#fit-table").startswith("load [")
    page.fill("#fit-table", TABLE)
    page.select_option("#fit-field-0", "upper.radius")
    page.fill("#fit-0-1", "1000")  # [mm]
    page.locator("#fit-0-1").blur()
    page.click("#fit-run")
    page.wait_for_selector("#fit-found", timeout=120_000)
    radius = float(page.get_attribute("[data-parameter='upper.radius']", "data-si"))
    data = {"load [kN/m]": [50, 89, 120], "half_width [um]": [265, 354, 411]}
    found = wo.fit(wo.RollerProblem.example(), data, {"upper.radius": (0.0625, 1.0)})
    assert radius == pytest.approx(found.estimates[0], rel=1e-6)  # bounds are another
    assert page.locator("[data-panel=fit] canvas, .cell-fit canvas").count() == 1
    assert page.locator("[data-panel=fit] .swatch circle").count() == 1  # points in the legend too
    assert page.locator(".panel-cell table").count() == 1
    page.click("#fit-take")
    seen.rest()
    assert float(seen.box("upper.radius")) == pytest.approx(1e3 * radius, rel=1e-4)


@pytest.mark.slow
def test_a_file_of_an_instrument_is_fitted(look, tmp_path):
    nptdms = pytest.importorskip("nptdms")
    rate = {"wf_increment": 0.5, "wf_start_offset": 0.0}
    path = tmp_path / "run.tdms"
    with nptdms.TdmsWriter(path) as writer:
        for group in ("idle", "loaded"):
            writer.write_segment(
                [
                    nptdms.ChannelObject(
                        group, name, np.array(values), rate | {"unit_string": unit}
                    )
                    for name, values, unit in (
                        ("load", [50.0, 89.0, 120.0], "kN/m"),
                        ("half_width", [265.0, 354.0, 411.0], "um"),
                        ("Door 3", [0.0, 0.0, 0.0], ""),
                    )
                ]
            )
    page = look().page
    page.click("button.tables")
    page.select_option(".kind", "rollers")
    page.click("#tab-fit")
    page.set_input_files("#fit-file", path)
    page.fill("#fit-sheet", "loaded")
    page.select_option("#fit-field-0", "upper.radius")
    page.click("#fit-run")
    page.wait_for_selector("#fit-found", timeout=120_000)
    radius = float(page.get_attribute("[data-parameter='upper.radius']", "data-si"))
    data = {"load [kN/m]": [50, 89, 120], "half_width [um]": [265, 354, 411]}
    found = wo.fit(wo.RollerProblem.example(), data, {"upper.radius": None})
    assert radius == pytest.approx(found.estimates[0], rel=1e-6)
    assert "channels without a known name are not read: Door 3" in page.inner_text(".remarks")


@pytest.mark.slow
def test_a_fit_is_cancelled_and_its_errors_are_shown_on_a_phone(look):
    seen = look(width=390, height=844)
    page = seen.page
    page.click("#tab-fit")
    assert page.evaluate("() => document.scrollingElement.scrollWidth") <= 390
    page.fill("#fit-table", "no_such [m]\n1\n2")
    page.click("#fit-run")
    page.wait_for_selector(".fit .fault >> text=no_such", timeout=60_000)
    page.fill("#fit-table", "nip_load [kN/m], wound_on_tension [N/m]\n" + "3, 620\n4, 705\n" * 50)
    page.click("#fit-run")
    page.wait_for_selector("#fit-cancel:enabled")
    page.click("#fit-cancel")
    page.wait_for_selector(".study-state >> text=Cancelled")


@pytest.mark.slow
def test_an_operating_window_reports_its_progress_and_is_cancelled(look):
    seen = look()
    page = seen.page
    page.click("#tab-window")
    page.select_option("[id='f-tension_law']", label="friction")  # no nip is solved
    page.wait_for_selector("#window-run:enabled")
    seen.rest()
    page.click("#window-run")
    page.wait_for_selector(".study-state >> text=windings", timeout=60_000)
    page.click("#tab-case")  # it goes on while another tab is shown
    page.click("#tab-window")
    page.click("#window-cancel")
    page.wait_for_selector(".study-state >> text=Cancelled")
    page.select_option("#window-axis-2", "torque_split")  # a third range
    assert page.locator("#window-torque_split-1").input_value() == "0.5"


PROFILE = """schema = 1
radius = "80 mm"
tension_law = "friction"
web_tension = "250 N/m"
nip_load = "500 N/m"
roll_friction = 0.19
drum_friction = 0.2
density = "680 kg/m^3"
core = { radius = "50 mm", stiffness = "1 GPa" }
drum = { kind = "rigid", radius = "250 mm" }
web = { thickness = "66 um", material = "newsprint" }
stack = { tangential = "3.38 GPa", poissons_ratio = 0.01, shear = "10 MPa", radial = 40e6 }
limits = { yield_strain = "0.17 %" }
thickness_profile = { position = ["0 m", "1 m", "2 m"], thickness = [0.995, 1.005, 0.995] }
"""


@pytest.mark.slow
def test_the_set_points_of_an_operating_window_are_chosen(look):
    seen = look()
    page = seen.page
    seen.offer("case.toml", PROFILE.encode())
    page.wait_for_selector("[id='f-tension_law']")
    page.click("#tab-window")
    seen.rest()
    assert page.locator("#window-axis-2 option").count() == 4  # none, and three fields
    page.select_option("#window-axis-0", "oscillation")
    page.select_option("#window-axis-1", "thickness_profile.variation")
    # a tenth of the width of the profile
    assert page.input_value("#window-oscillation-1") == "200"
    assert page.input_value("[id='window-thickness_profile.variation-1']") == "2"
    with page.expect_request("**/api/window") as request:
        page.click("#window-run")
    assert request.value.post_data_json["vary"] == {
        "oscillation": [0, 0.2], "thickness_profile.variation": [0.5, 2],
    }  # fmt: skip
    page.wait_for_selector(".study-state >> text=windings", timeout=60_000)
    page.click("#window-cancel")
    page.wait_for_selector(".study-state >> text=Cancelled")
