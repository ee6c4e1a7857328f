"""Units at the edge: right to the last bit both ways, or refused with what is due."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from woundon.errors import InvalidProblem
from woundon.problems.units import known_units, parse, text_with_unit


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("66 um", "m", 66e-6),
        ("66um", "m", 66e-6),
        ("66 \N{MICRO SIGN}m", "m", 66e-6),
        ("66 \N{GREEK SMALL LETTER MU}m", "m", 66e-6),
        ("2.6 mil", "m", 2.6 * 25.4e-6),
        ("3 in", "m", 0.0762),
        ("3.38 GPa", "Pa", 3.38e9),
        ("2 N/mm2", "Pa", 2e6),
        ("2 N/mm²", "Pa", 2e6),
        ("2 N mm^-2", "Pa", 2e6),
        ("2 kg·m/s**2/mm²", "Pa", 2e6),
        ("2 kPa cm * mm / ft", "N/m", 2e3 * 1e-5 / 0.3048),
        ("2 MPa % mm", "N/m", 20.0),
        ("2 g / cm2", "kg/m**2", 20.0),
        ("2 kgf/cm", "N/m", 1961.33),
        ("-400 N/m", "N/m", -400.0),
        ("3.5 kN/m", "N/m", 3500.0),
        ("1e3 N/m", "N/m", 1000.0),
        (".5 N/m", "N/m", 0.5),
        ("80 gsm", "kg/m**2", 0.08),
        ("3000 ft/min", "m/s", 15.24),
        ("3000 fpm", "m/s", 15.24),
        ("3 min", "s", 180.0),
        ("180\N{DEGREE SIGN}", "rad", 3.141592653589793),
        ("66\N{NO-BREAK SPACE}um", "m", 66e-6),
        ("19 %", "1", 0.19),
        ("0.19", "1", 0.19),
        (3502, "N/m", 3502.0),
        (66e-6, "m", 66e-6),
    ],
)
def test_read_to_the_last_bit(text, unit, value):
    # conversion is by exact fractions, so the nearest double must come out
    assert parse(text, unit) == pytest.approx(value, rel=2.3e-16)


def test_mill_units():
    # definitions: 1 lbf = 4.4482216152605 N and 1 in = 25.4 mm exactly
    pli = 4.4482216152605 / 0.0254
    assert parse("17 pli", "N/m") == pytest.approx(17 * pli, rel=4e-16)  # two roundings here
    assert parse("17 pli", "N/m") == parse("17 lbf/in", "N/m")
    assert round(parse("17 pli", "N/m")) == 2977
    # 1 psi = 6894.757293168 Pa (NIST SP 811 gives 6.894757 E+03)
    assert parse("1 psi", "Pa") == pytest.approx(6894.757293168, rel=1e-12)


def test_every_known_unit_is_of_a_dimension_that_is_used():
    used = ("m", "m**2", "N/m", "N", "Pa", "1", "s", "1/s", "m/s", "kg", "kg/m**2", "rad", "K", "W")

    def fits(name: str, unit: str) -> bool:
        try:
            return parse(f"1 {name}", unit) > 0
        except InvalidProblem:
            return False

    assert [name for name in known_units() if not any(fits(name, unit) for unit in used)] == []


# ---- and back -----------------------------------------------------------------------------------


@given(
    st.floats(allow_nan=False, allow_infinity=False),
    st.sampled_from(["m", "N/m", "Pa", "rad", "1", "s", "m/s", "kg/m**2", "1/m"]),
    st.sampled_from(["", "mm", "MPa", "deg", "%"]),
)
def test_what_is_written_is_read_as_the_same_number(value, unit, shown):
    assert parse(text_with_unit(value, unit, shown), unit) == value
