"""Reports of every kind of problem, printed by the browser: at most two A4 pages for a case."""

from __future__ import annotations

import re

import pytest
from slow_cases import slow_case

import woundon as wo
from woundon.errors import unwarned
from woundon.report.html_report import report_file

NIP = wo.NipProblem.example()
AIR = {"roughness": "3 um", "permeance": 1e-7}
CASES = {
    "nip": NIP,
    "air": NIP.replace(web_speed="15 m/s", air=AIR),
    "rollers": wo.RollerProblem.example(),
    "roll": wo.RollProblem.example(),
    # no nip is solved, which takes seconds
    "winding": wo.WindingProblem.example().replace(tension_law="friction"),
    # with all limits and their sources
    "grade": wo.WindingProblem.example().replace(tension_law="friction", grade="uncoated-fine"),
}


# the longest reports; the others have less to print
@pytest.mark.parametrize("name", [n if n in ("nip", "grade") else slow_case(n) for n in CASES])
def test_a_report_has_at_most_two_pages(browser, name: str) -> None:
    with unwarned():
        report = report_file([wo.solve(CASES[name])])
    assert ("drawing to scale" in report) == (name in ("nip", "air", "rollers"))
    page = browser.new_page()
    page.set_content(report)
    printed = page.pdf(format="A4", prefer_css_page_size=True)
    page.close()
    assert 1 <= len(re.findall(rb"/Type\s*/Page\b(?!s)", printed)) <= 2
