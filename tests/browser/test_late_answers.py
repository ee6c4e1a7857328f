"""Answers that come late, broken, or after a newer request: the page comes to rest all the same."""

from __future__ import annotations

import json

import pytest

import woundon as wo

CLOSE = 1e-7  # a warm start and a cold start agree to the tolerance of the iteration
SUPERSEDED = {"type": "/problems/superseded", "title": "superseded", "status": 409, "errors": []}


@pytest.fixture
def seen(look_with):
    """A page of a context of its own, whose requests a test may answer itself."""
    seen = look_with(";")
    seen.page.wait_for_selector(".sections")  # of the report, the last request of the first state
    return seen


def shows(seen, problem):
    """Look that the page shows the solution of a problem."""
    expected = wo.solve(problem).wound_on_tension
    assert seen.rest().output("wound_on_tension") == pytest.approx(expected, rel=CLOSE)


@pytest.mark.parametrize(("is_moving", "option"), [(False, "?drawn=true"), (True, "report=true")])
def test_a_state_whose_request_was_superseded_is_solved_again(seen, is_moving, option):
    """Requests travel on several connections: an older one may come after a newer one."""
    if not is_moving:
        seen.put("nip_load", "5000")
    answer = {"status": 409, "content_type": "application/problem+json"}
    seen.page.route(
        lambda url: "/api/solve" in url and url.endswith(option),
        lambda route: route.fulfill(**answer, body=json.dumps(SUPERSEDED)),
        times=1,
    )
    with seen.page.expect_response(lambda response: response.status == 409):
        if is_moving:
            seen.page.focus("[data-path=nip_load] .slider")
            seen.page.keyboard.press("ArrowRight")
        else:
            seen.page.click("[aria-label=Undo]")
    shows(seen, wo.NipProblem.example().replace(nip_load=float(seen.box("nip_load"))))


def test_an_answer_that_breaks_off_is_asked_for_again(seen):
    before = seen.page.get_attribute("[data-output=wound_on_tension] .value", "data-si")
    seen.page.route(
        lambda url: "/api/solve" in url,
        lambda route: route.fulfill(content_type="application/json", body='{"kind":'),
        times=1,
    )
    seen.page.fill("#f-nip_load", "5000")
    seen.page.wait_for_selector(f"[data-output=wound_on_tension] .value:not([data-si='{before}'])")
    seen.page.wait_for_selector("#lost", state="detached")
    shows(seen, wo.NipProblem.example().replace(nip_load=5000.0))


def test_a_late_grade_does_not_change_the_kind_of_another_tab(seen):
    page, held = seen.page, []
    page.select_option("#grade", "lwc")
    page.wait_for_function("() => document.querySelector('#f-web-thickness').value === '47'")
    seen.rest()
    page.route("**/api/grade", lambda route: held.append(route))
    page.click("#tab-winding")
    while not held:
        page.wait_for_timeout(20)
    page.click("#tab-case")
    with page.expect_response("**/api/grade"):
        held[0].continue_()
    state = seen.held(lambda state: state["tab"] == "case")
    page.wait_for_timeout(500)  # the address would follow
    seen.rest()
    assert page.input_value(".kind") == state["kind"] == "nip"
    shows(seen, wo.NipProblem.example().replace(grade="lwc"))
