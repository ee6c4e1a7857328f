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


def test_powers_and_products_of_units_are_typeset(look):
    """In answers of the server and in the names of grades."""
    seen = look()
    read = """async () => {
        const { typeset, Units } = await import("/static/units.js")
        const { symbolText } = await import("/static/symbols.js")
        const units = new Units({ units: {}, unit_definitions: {}, systems: {} }, "SI")
        return [
            units.sentence("a = 0 m/s^2, J = 3 kg*m^2, m V^2 = 18 N/m, 3 um"),
            units.message("'3 kg/cm^2' is wrong; must be given [kg/m^3], e.g. in kg*m^2"),
            symbolText("V^2"), typeset("Pa/m**0.5"), typeset("1/degF"),
        ]
    }"""
    assert seen.page.evaluate(read) == [
        "a = 0 m/s², J = 3 kg·m², m V² = 18 N/m, 3 µm",
        "'3 kg/cm^2' is wrong; must be given [kg/m³], e.g. in kg·m²",
        "V²", "Pa/√m", "1/°F",
    ]  # fmt: skip
    grades = seen.page.inner_text("#grade")
    assert "g/m²" in grades
    assert "^" not in grades


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
