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


LB, IN, FT, GRAVITY = 0.45359237, 0.0254, 0.3048, 9.80665  # exact


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        *(
            (f"20 {pli}", "N/m", 20 * LB * GRAVITY / IN)
            for pli in ("pli", "PLI", "lb/in", "lbs/in")
        ),
        ("3.5 N/mm", "N/m", 3500.0),
        *((f"66 {um}", "m", 66e-6) for um in ("mic", "micron", "microns")),
        *((f"0.004{inch}", "m", 101.6e-6) for inch in (" in", " inch", '"')),
        ("18 pt", "m", 457.2e-6),
        ("92 gauge", "m", 23.368e-6),
        ("2 yd", "m", 1.8288),
        ("3 oz", "kg", 3 * LB / 16),
        ("3 oz", "N", 3 * LB * GRAVITY / 16),
        ("3 ozf/in", "N/m", 3 * LB * GRAVITY / 16 / IN),
        ("2 oz/yd^2", "kg/m**2", 2 * LB / 16 / 0.9144**2),
        ("5 dN", "N", 0.5),
        ("5 dN/cm", "N/m", 50.0),
        ("3 kp/cm", "N/m", 3 * GRAVITY * 100),
        ("3 kg/cm", "N/m", 3 * GRAVITY * 100),
        ("1.5 g/in", "N/m", 1.5e-3 * GRAVITY / IN),
        ("1.5 gf/in", "N/m", 1.5e-3 * GRAVITY / IN),
        ("400 g/25 mm", "N/m", 0.4 * GRAVITY / 0.025),
        ("45 N/15 mm", "N/m", 3000.0),
        ("45 N / 15mm", "N/m", 3000.0),
        ("-9 degF", "K", -5.0),
        ("-9 \N{DEGREE SIGN}F", "K", -5.0),
        ("12 degC", "K", 12.0),
        ("12 \N{DEGREE SIGN}C", "K", 12.0),
        ("1.8e-5 1/degC", "1/K", 1.8e-5),
        ("1e-5 1/degF", "1/K", 1.8e-5),
        ("18 um/m/degC", "1/K", 1.8e-5),
        ("30 lb/3000 ft^2", "kg/m**2", 30 * LB / (3000 * FT**2)),
        ("30 lb/3000 ft\N{SUPERSCRIPT TWO}", "kg/m**2", 30 * LB / (3000 * FT**2)),
        ("30 lb/ream 24x36", "kg/m**2", 30 * LB / (3000 * FT**2)),
        ("30 lb/ream (24x36/500)", "kg/m**2", 30 * LB / (3000 * FT**2)),
        ("30 lb/24x36/480", "kg/m**2", 30 * LB / (2880 * FT**2)),  # tissue
        ("50 lbs/ream 25 x 38", "kg/m**2", 50 * LB / (25 * 38 * 500 * IN**2)),
        ("20 lb/ream 17x22 in/500", "kg/m**2", 20 * LB / (17 * 22 * 500 * IN**2)),
        ("20 lb/ream 25.5x30.5", "kg/m**2", 20 * LB / (25.5 * 30.5 * 500 * IN**2)),
    ],
)
def test_units_of_mills_and_laboratories(text, unit, value):
    # exact fractions against up to four roundings here
    assert parse(text, unit) == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize("text", ["1 lb/3000 ft^2", "1 lb/ream 24x36", "1 oz/yd^2"])
def test_a_basis_weight_in_pounds_is_no_stress(text: str):
    with pytest.raises(InvalidProblem, match="has the wrong dimension"):
        parse(text, "Pa")
    assert parse("1 oz/in^2", "Pa") == pytest.approx(parse("1 psi", "Pa") / 16, rel=4e-16)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("5 N/0 mm", "has the unreadable unit"),
        ("5 N/0.0 mm", "has the unreadable unit"),
        ("5 lb/ream 0x36", "has the unreadable unit"),
        ("1e308 kN/m", "is not a finite number"),
    ],
)
def test_units_and_numbers_without_a_finite_size(text: str, reason: str):
    with pytest.raises(InvalidProblem, match=reason):
        parse(text, "N/m")


def test_reams_of_paper_against_tables_of_the_trade():
    """Areas of Ivex, to a square foot; Sylvamo: gsm = lb 1406.5/(sheet [in^2]), exact: 1406.14."""
    for width, height, area in ((24, 36, 3000), (25, 38, 3299), (17, 22, 1299)):
        gsm = 1e3 * parse(f"1 lb/ream {width}x{height}", "kg/m^2")
        assert gsm == pytest.approx(1406.5 / (width * height), rel=3e-4)
        assert round(1e3 * LB / gsm / FT**2) == area


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
