"""Reports of every kind of problem, printed by the browser: few A4 pages, figures to be read."""

from __future__ import annotations

import re

import pytest
from slow_cases import campaign_case, slow_case

import woundon as wo
from woundon.errors import unwarned
from woundon.report.html_report import report_file

NIP = wo.NipProblem.example()
PROFILE = wo.ThicknessProfile(
    position=[0.1 * k for k in range(21)], thickness=[1 + 0.002 * (k % 5 == 3) for k in range(21)]
)
WINDING = wo.WindingProblem.example().replace(tension_law="friction")
ON_TWO_DRUMS = WINDING.replace(
    tension_law="nip",
    nip_load=None,
    torque_split=0.5,
    density=680.0,
    winder=wo.TwoDrums(front_drum=wo.Rigid(radius=0.25), gap=0.02, rider_load=2500.0),
    inertia=wo.Inertia(core="3 kg*m^2"),
)
AIR = {"roughness": "3 um", "permeance": 1e-7}
CASES = {
    "nip": NIP,
    "air": NIP.replace(web_speed="15 m/s", air=AIR),
    "rollers": wo.RollerProblem.example(),
    "roll": wo.RollProblem.example(),
    "lanes": wo.RollProblem.example().replace(thickness_profile=PROFILE, density=680.0),
    # no nip is solved, which takes seconds
    "winding": WINDING,
    # with all limits and their sources
    "grade": WINDING.replace(grade="uncoated-fine"),
    "lanes wound": WINDING.replace(thickness_profile=PROFILE, density=680.0, web_speed="15 m/s"),
    "two drums": ON_TWO_DRUMS,
    "lanes on two drums": ON_TWO_DRUMS.replace(thickness_profile=PROFILE),
}
# more than two columns of panels are drawn below each other
PAGES = {"lanes wound": 3, "two drums": 3, "lanes on two drums": 4}
# heights of the letters of each figure as printed, drawn with 9 pt [pt]
LETTERS = """() => [...document.querySelectorAll("div.figures svg, div.three svg")].map((svg) => {
    const size = svg.getBoundingClientRect(), box = svg.viewBox.baseVal
    return 9 * 0.75 * Math.min(size.width / box.width, size.height / box.height)
})"""
# texts of figures that leave them, where they are cut off
CUT_OFF = """() => [...document.querySelectorAll("figure svg")].flatMap((svg) => {
    const outer = svg.getBoundingClientRect()
    return [...svg.querySelectorAll("g[id*=text_]")].filter((text) => {
        const box = text.getBoundingClientRect()
        return box.left < outer.left - 0.5 || box.right > outer.right + 0.5
            || box.top < outer.top - 0.5 || box.bottom > outer.bottom + 0.5
    }).map((text) => text.id)
})"""
PRINTED_WIDTH = 703  # [px] of an A4 page less its margins


# the longest reports; the others have less to print
QUICK, LONG = ("nip", "grade"), ("lanes on two drums",)


@pytest.mark.parametrize(
    "name",
    [n if n in QUICK else campaign_case(n) if n in LONG else slow_case(n) for n in CASES],
)
def test_a_report_has_few_pages_and_readable_figures(browser, name: str) -> None:
    with unwarned():
        report = report_file([wo.solve(CASES[name], rtol=0.02)])
    assert ("drawing to scale" in report) == (name in ("nip", "air", "rollers"))
    page = browser.new_page(viewport={"width": PRINTED_WIDTH, "height": 1000})
    page.emulate_media(media="print")
    page.set_content(report)
    letters = page.evaluate(LETTERS)
    cut_off = page.evaluate(CUT_OFF)
    printed = page.pdf(format="A4", prefer_css_page_size=True)
    page.close()
    assert 1 <= len(re.findall(rb"/Type\s*/Page\b(?!s)", printed)) <= PAGES.get(name, 2)
    assert min(letters) > 4.5
    assert cut_off == []
