"""The page shows the same numbers in both systems of units, in no unit of the other system.

Evidence: invariance, as of ``tests/unit/test_display_units.py``.
"""

from __future__ import annotations

import pytest
from rendered_numbers import differing_numbers, units_in
from slow_cases import slow_case

from woundon.problems.units import MILL

# all that is written about a result; numbers within charts have the units of their tables
SHOWN = """() => {
    const parts = [".answer", ".advice", ".warnings li", ".number-card .much", ".section-grid tr",
        ".section-grid section > p", ".drawing text", "table.margins td:nth-of-type(1)"]
    const words = (part) => {
        const walker = document.createTreeWalker(part, NodeFilter.SHOW_TEXT)
        const texts = []
        while (walker.nextNode()) texts.push(walker.currentNode.data)
        return texts.join(" ").replaceAll(/\\s+/g, " ")
    }
    return [...document.querySelectorAll(parts.join(", "))].map(words)
}"""
SPELT = {"µm": "um", "°": " deg", "−": "-", "³": "^3", "²": "^2", "·": "*"}


def shown(seen) -> list[str]:
    """Return the texts of the page, with units as the program writes them."""
    texts = "\n".join(seen.rest().page.evaluate(SHOWN))
    for sign, plain in SPELT.items():
        texts = texts.replace(sign, plain)
    return texts.splitlines()


@pytest.mark.parametrize(
    ("tab", "kind", "headline"),
    [
        ("case", "nip", "Wound-on tension"),
        slow_case("case", "rollers", "Creepage"),
        ("winding", "roll", "Pressure on the core"),
        slow_case("winding", "winding", "The roll"),
    ],
)
def test_the_page_shows_the_same_numbers_in_mill_units(look, tab, kind, headline):
    seen = look()
    if tab != "case":
        seen.page.click(f"#tab-{tab}")
    seen.page.select_option("select.kind", kind)
    seen.rest().page.wait_for_selector(".section-grid")
    usual = shown(seen)
    seen.page.click(".segmented >> text=mill")
    mill = shown(seen)
    assert mill[0].startswith(headline)
    assert differing_numbers("\n".join(usual), "\n".join(mill)) == []
    assert "in" in units_in("\n".join(mill))
    assert units_in("\n".join(mill)) & set(MILL) == set()
