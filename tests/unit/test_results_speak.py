"""Results as HTML and as tables."""

from __future__ import annotations

from html.parser import HTMLParser
from typing import Any

import numpy as np
import pytest
from coarse_solutions import coarse_solution
from thesis_cases import newsprint_nip

import woundon as wo
from woundon import kinds, quantities
from woundon.report.html import label_html, parts_html, symbol_html, unit_html
from woundon.report.report_parts import Line, Section, row_of

NODES = 25
KINDS = [kind.name for kind in kinds.every()]
STUDIES = ["fit", "sobol", "sensitivity"]
BOUNDS = {"roll_friction": (0.1, 0.4), "roll.material.shear": (3e6, 3e7)}


@pytest.fixture(scope="module")
def solutions() -> dict[str, Any]:
    """A result of every kind, and of every study."""
    made: dict[str, Any] = {
        kind.name: coarse_solution(kind.problem.example(), NODES) for kind in kinds.every()
    }
    problem = newsprint_nip()
    loads = (1000.0, 2000.0, 3500.0, 5000.0)
    exact = [wo.solve(problem.replace(nip_load=P), nodes=NODES).wound_on_tension for P in loads]
    measured = np.add(exact, [0.3, -0.4, 0.2, -0.1])
    data = {"nip_load [N/m]": loads, "wound_on_tension [N/m]": measured}
    ranges = {"nip_load": (2e3, 3e3), "roll_friction": (0.15, 0.3)}
    made["fit"] = wo.fit(problem, data, BOUNDS, nodes=NODES, starts=1)
    made["sobol"] = wo.global_sensitivity(problem, ranges, samples=8, nodes=NODES, workers=1)
    made["sensitivity"] = made["nip"].sensitivity()
    return made


class Page(HTMLParser):
    """The tags and texts of a page, whose tags must match."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.texts: list[str] = []
        self.tags: set[str] = set()
        self.feed(html)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag: str, attrs: Any) -> None:
        self.open.append(tag)
        self.tags.add(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.texts.append(data)


# ---- as HTML


@pytest.mark.parametrize("kind", KINDS)
def test_a_notebook_gets_the_report_as_tables(solutions, kind: str) -> None:
    page = Page(solutions[kind]._repr_html_())
    assert {"table", "tr", "td"} <= page.tags
    text = " ".join("".join(page.texts).split())
    for line in str(solutions[kind]).splitlines():  # nothing that is printed is missing
        if not set(line) & set("◀▶") and "·····" not in line:
            for word in line.split():
                forms = (form(word) for form in (str, symbol_html, label_html, unit_html))
                assert any("".join(Page(form).texts) in text for form in forms), word


def test_every_text_is_escaped() -> None:
    evil = "<script>alert('&')</script>"
    rows = (row_of(quantities.Quantity(evil, evil, evil), 1.0, note=evil),)
    html = parts_html([Section(evil, rows, evil), Line(evil, "warning"), Line(evil)])
    assert "<script" not in html
    assert "".join(Page(html).texts).count(evil) == 8


# ---- as tables


def test_tables_of_studies_have_their_numbers(solutions) -> None:
    fit, sobol, slopes = (solutions[name] for name in STUDIES)
    frame, data = fit.to_dataframe(), fit.to_xarray()
    assert frame.loc["roll.material.shear", "unit"] == "Pa"
    assert frame.loc["roll.material.shear", "low"] == fit.profiles[1].low
    assert data.estimate.sel(parameter="roll_friction") == fit.estimate("roll_friction")
    np.testing.assert_array_equal(data.covariance, fit.covariance)
    np.testing.assert_array_equal(data.measured, fit.measured)
    assert list(data.output_unit.values) == ["N/m"] * 4
    frame = sobol.to_dataframe()
    at = ("wound_on_tension", "roll_friction")
    assert frame.loc[at, "total_order"] == sobol.total_order[0, 1]
    assert frame.loc[at, "total_high"] == sobol.total_interval[1, 0, 1]
    frame = slopes.to_dataframe()
    column = slopes.elasticities[slopes.outputs.index("half_width")]
    np.testing.assert_array_equal(frame["half_width"], column)
    one = slopes.to_xarray().derivative.sel(output="nip_width", parameter="nip_load")
    assert one == slopes.derivative("nip_width", "nip_load")
