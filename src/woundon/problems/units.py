"""Conversion of text with units ("66 um", "3.38 GPa", "17 pli") to SI numbers, and back.

The units are defined here: a registry with free prefixes reads "17 pli" as a small length and "min"
as a milli-inch.  Conversion multiplies exact fractions.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from decimal import Decimal
from fractions import Fraction
from functools import cache, lru_cache
from math import isfinite, pi
from typing import Any, NamedTuple

from ..errors import InvalidProblem, did_you_mean

__all__ = [
    "MILL",
    "TOTALS",
    "compatible_units",
    "definitions",
    "factor",
    "has_dimension",
    "is_unit",
    "known_units",
    "number_and_unit",
    "parse",
    "text_with_unit",
]

# One unit per line, defined by those above it; no prefixes, plurals or aliases.
_DEFINITIONS = """
m
s
rad
kg
K
degC = 1 K
degF = 5/9 K
deg = 0.017453292519943295 rad
% = 0.01
um = 1e-6 m
mm = 1e-3 m
cm = 1e-2 m
km = 1e3 m
in = 0.0254 m
ft = 0.3048 m
yd = 3 ft
mil = 2.54e-5 m
pt = 1 mil
gauge = 1e-2 mil
us = 1e-6 s
ms = 1e-3 s
min = 60 s
h = 3600 s
Hz = 1 / s
kHz = 1e3 / s
rpm = 0.10471975511965977 rad/s
g = 1e-3 kg
lb = 0.45359237 kg
oz = 1/16 lb
N = kg * m / s**2
mN = 1e-3 N
dN = 0.1 N
daN = 10 N
kN = 1e3 N
kgf = 9.80665 N
gf = 1e-3 kgf
lbf = 4.4482216152605 N
ozf = 1/16 lbf
W = N * m / s
kW = 1e3 W
hp = 745.69987158227022 W
Pa = N / m**2
kPa = 1e3 Pa
MPa = 1e6 Pa
GPa = 1e9 Pa
bar = 1e5 Pa
psi = lbf / in**2
ksi = 1e3 psi
pli = lbf / in
gsm = g / m**2
msf = 1000 ft**2
fpm = ft / min
mpm = m / min
"""

# Other spellings in use; output uses the spelling of the definitions above.
_SPELLINGS = {
    "inch": "in",
    "inches": "in",
    '"': "in",
    "\N{DOUBLE PRIME}": "in",
    "thou": "mil",
    "foot": "ft",
    "feet": "ft",
    "mic": "um",
    "micron": "um",
    "microns": "um",
    "mils": "mil",
    "lbs": "lb",
    "kp": "kgf",
    "\N{DEGREE SIGN}C": "degC",
    "\N{DEGREE SIGN}F": "degF",
    "PLI": "pli",
    "PSI": "psi",
    "KSI": "ksi",
    "GSM": "gsm",
    "FPM": "fpm",
    "MPM": "mpm",
    "\N{DEGREE SIGN}": "deg",
    "\N{MICRO SIGN}m": "um",
    "\N{MICRO SIGN}": "um",
    "\N{GREEK SMALL LETTER MU}m": "um",
    "\N{GREEK SMALL LETTER MU}": "um",
}

# Total in place of a quantity per width, by the unit of the latter: its name and unit.  "N" may be
# that of a torque per width, or of a force.
TOTALS = {
    "N/m": ("force", "N"),
    "kg/m": ("mass", "kg"),
    "W/m": ("power", "W"),
    "N": ("torque", "N*m"),
}

TURN = Fraction(2 * pi)  # [rad]

# Masses that are read as forces where the dimension of a quantity is that of the force: "lb/in".
# kg and g are forces per width only: kg/m^2 is a basis weight, and mills weigh in kg.
_FORCES = {"lb": "lbf", "lbs": "lbf", "oz": "ozf"}
_LINE_FORCES = {"kg": "kgf", "g": "gf"}

# Full names are rejected, with the unit in the message.
_FULL_NAMES = {
    "micrometer": "um",
    "micrometre": "um",
    "millimeter": "mm",
    "millimetre": "mm",
    "centimeter": "cm",
    "centimetre": "cm",
    "meter": "m",
    "metre": "m",
    "newton": "N",
    "pascal": "Pa",
    "degree": "deg",
    "kelvin": "K",
    "c": "degC",
    "f": "degF",
    "celsius": "degC",
    "fahrenheit": "degF",
    "yard": "yd",
    "ounce": "oz",
    "radian": "rad",
    "pound": "lbf",
    "second": "s",
    "minute": "min",
    "u": "um",
}

# Characters that are typed instead of a minus sign.
_DASHES = ("\N{MINUS SIGN}", "\N{EN DASH}", "\N{EM DASH}")

# Units for output, by SI unit.
_OUTPUT_UNITS = {
    "m": ("um", "mm", "m"),
    "N/m": ("N/m", "kN/m"),
    "Pa": ("Pa", "kPa", "MPa", "GPa"),
    "rad": ("deg", "rad"),
}

# Units of North American mills, by the unit that is displayed otherwise.
MILL = {
    "um": "mil",
    "mm": "in",
    "m": "ft",
    "N/m": "pli",
    "N": "lbf",
    "Pa": "psi",
    "kPa": "psi",
    "MPa": "ksi",
    "GPa": "ksi",
    "m/s": "fpm",
    "m/min": "fpm",
    "m/s^2": "ft/s^2",
    "K": "degF",  # of a difference of temperatures, without an offset
    "1/K": "1/degF",
    "kg/m": "lb/ft",
    "kg/m^3": "lb/ft^3",
    "N*m^2": "lbf*in^2",
    "N*m": "lbf*ft",
    "kW": "hp",
    "kg*m^2": "lb*ft^2",
}

_EXAMPLES = {
    "m": ", e.g. '66 um' or 66e-6",
    "N/m": ", e.g. '3.5 kN/m', '20 pli' or 3500",
    "Pa": ", e.g. '10 MPa' or 10e6",
    "rad": ", e.g. '90 deg' or '1.57 rad'",
    "K": ", e.g. '-10 K' or '-10 degC', a difference",
    "1/K": ", e.g. '1e-5 1/K' or 1e-5",
    "1": ", e.g. 0.2 or '20 %'",
}

_NAME = (
    r"(?:[A-Za-z\N{MICRO SIGN}\N{GREEK SMALL LETTER MU}%\N{DEGREE SIGN}]+"
    r'|["\N{DOUBLE PRIME}])'
)
# 1,000 or 1 000 or 1'000 or 1_000; and 3,5; the last group is the text after the number
_THOUSANDS = re.compile(r"\s*([+-]?\d{1,3}(?:[,' _\N{NO-BREAK SPACE}]\d{3})+(?:\.\d+)?)(?!\d)(.*)")
_DECIMAL_COMMA = re.compile(r"\s*([+-]?\d+),(\d+)(?![,.\d])(.*)")
_POWER = r"(?:(?:\*\*|\^)?-?\d|[\N{SUPERSCRIPT TWO}\N{SUPERSCRIPT THREE}])"
_FACTOR = f"{_NAME}{_POWER}?"
_DIVISOR = rf"/\s*(?=[\d.]*[1-9])\d+(?:\.\d+)?\s*{_FACTOR}"  # N/15 mm, lb/3000 ft^2
_UNIT = re.compile(
    rf"1/(?:[Ks]|deg[CF])|{_FACTOR}(?:(?:\s*[*/\N{{MIDDLE DOT}}]\s*|\s+){_FACTOR}|\s*{_DIVISOR})*"
)
_BASIS_WEIGHT = re.compile(r"/\s*\d|yd")  # not a stress: lb/3000 ft^2, oz/yd^2
# pounds per ream of so many sheets, by default 500: lb/ream 24x36, lb (25x38/500)
_REAM = re.compile(
    r"(lbs?)\s*(?:/|per)?\s*(?:ream)?\s*\(?"
    r"(\d{1,3}(?:\.\d)?)\s*[xX\N{MULTIPLICATION SIGN}]\s*(\d{1,3}(?:\.\d)?)"
    r"(?:\s*in)?(?:\s*[/-]\s*(\d{3}))?\)?"
)
# number, unit or ""
_QUANTITY = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d{1,3})?)\s*(.*?)\s*")
# sign, divisor, unit, power: of "N/15 mm" ("", "", "N", ""), ("/", "15", "mm", "")
_TERMS = re.compile(rf"([*/\N{{MIDDLE DOT}}]?)\s*(\d+(?:\.\d+)?)?\s*({_NAME})({_POWER}?)")
# superscripts become digits; * and ^ are deleted
_RAISED = str.maketrans("\N{SUPERSCRIPT TWO}\N{SUPERSCRIPT THREE}", "23", "*^")
_MAX_LENGTH = 60


class _Unit(NamedTuple):
    """A unit as a factor and powers of SI base units by name."""

    factor: Fraction
    powers: dict[str, int]


@cache
def _definitions() -> dict[str, _Unit]:
    """Return all units by name."""
    known: dict[str, _Unit] = {}
    for line in _DEFINITIONS.strip().splitlines():
        name, _, text = line.partition(" = ")
        number, *units = text.split(" ", 1)  # units: none or one text
        if not text:  # a base unit
            known[name] = _Unit(Fraction(1), {name: 1})
        elif number[0].isdecimal():  # a number and a product of units, or a number alone
            factor, powers = _product("".join(units), known)
            known[name] = _Unit(Fraction(number) * factor, powers)
        else:
            known[name] = _product(text, known)
    return known | {name: known[standard] for name, standard in _SPELLINGS.items()}


def _product(text: str, known: dict[str, _Unit]) -> _Unit:
    """Return the unit of a product of units such as "N/m", "kg m^-3" or "N/15 mm"."""
    factor, powers = Fraction(1), dict[str, int]()
    for sign, divisor, name, written_power in _TERMS.findall(text):
        power = int(written_power.translate(_RAISED) or 1) * (-1 if sign == "/" else 1)
        factor *= known[name].factor ** power / Fraction(divisor or 1)
        for base, times in known[name].powers.items():
            powers[base] = powers.get(base, 0) + times * power
    return _Unit(factor, {base: times for base, times in powers.items() if times})


@cache
def known_units() -> tuple[str, ...]:
    """Return the names of all known units."""
    return tuple(sorted(_definitions()))


def definitions() -> dict[str, dict[str, Any]]:
    """Return factor and powers of SI base units of all units by name."""
    return {
        name: {"factor": float(unit.factor), "powers": unit.powers}
        for name, unit in _definitions().items()
    }


def has_dimension(text: str, unit: str) -> bool:
    """Return True if text is a number with a unit of the dimension of ``unit``."""
    match = _QUANTITY.fullmatch(text) if len(text) <= _MAX_LENGTH else None
    return bool(match and is_unit(match[2]) and _conversion_factor(match[2], unit) is not None)


def is_unit(text: str) -> bool:
    """Return True if text is a known unit."""
    if len(text) > _MAX_LENGTH:
        return False
    text = _with_area(text)
    return bool(_UNIT.fullmatch(text)) and set(re.findall(_NAME, text)) <= set(known_units())


def _with_area(text: str) -> str:
    """Return pounds per ream as pounds per area; any other unit unchanged."""
    match = _REAM.fullmatch(text.strip())
    if match is None:
        return text
    pound, width, height, sheets = match.groups()
    area = Decimal(width) * Decimal(height) * int(sheets or 500)
    return f"{pound}/{area:f} in^2"


def compatible_units(unit: str, *further: str) -> dict[str, float]:
    """Return the units in which a quantity may be displayed, with their size in the SI ``unit``.

    These are the named units of the same dimension, the units for output, those of North American
    mills, and ``further`` ones; the smallest first.  The pure number has the name ''.  Units of
    another dimension are left out.
    """
    if unit != "1" and not is_unit(unit):  # of the output of a plug-in
        return {unit: 1.0}
    if unit == "1":
        same_dimension = ["%"]
    else:
        powers = _product(unit, _definitions()).powers
        same_dimension = [
            name
            for name, definition in _definitions().items()
            if definition.powers == powers and name not in _SPELLINGS
        ]
    names = dict.fromkeys((unit, *_OUTPUT_UNITS.get(unit, ()), *same_dimension, *further))
    names |= dict.fromkeys(MILL[name] for name in list(names) if name in MILL)
    sizes = {
        "" if name == "1" else name: Fraction(1) if name == "1" else _conversion_factor(name, unit)
        for name in names
    }
    return dict(sorted(((n, float(s)) for n, s in sizes.items() if s), key=lambda item: item[1]))


def factor(text: str, unit: str, field: str) -> Fraction:
    """Return the exact conversion factor from the unit ``text`` to an SI unit.

    Raises
    ------
    InvalidProblem
        If it is unknown or of another dimension.
    """
    return _factor(text, unit, field, text)


def number_and_unit(text: str) -> tuple[str, str] | None:
    """Return number and unit of a text, both as text; None if it does not begin with a number.

    >>> number_and_unit("66 um"), number_and_unit("3e-5"), number_and_unit("um")
    (('66', 'um'), ('3e-5', ''), None)
    """
    match = _QUANTITY.fullmatch(text) if len(text) <= _MAX_LENGTH else None
    return None if match is None else (match[1], match[2])


def parse(value: str | float, unit: str, field: str = "value") -> float:
    """Return ``value`` in SI; a plain number is in SI already.

    Parameters
    ----------
    value : str or float
        Number with its unit ("17 pli", "-400 N/m", "19 %") or a plain number.
    unit : str
        SI unit of the quantity, e.g. "N/m"; "1" for a pure number.
    field : str
        Name of the field, for the error message.

    Raises
    ------
    InvalidProblem
        If the value is not a number, or its unit is missing, unknown or of another dimension.
    """
    if isinstance(value, bool) or not isinstance(value, (str, int, float)):
        raise _fault(field, value, "is not a number", unit)
    if not isinstance(value, str):
        return _as_float(value, unit, field)
    parts = number_and_unit(value)
    if parts is None:
        raise _fault(field, value, "is not a number with a unit", unit)
    number, text = parts
    if not isfinite(float(number)):
        raise _fault(field, value, "is not a finite number", unit)
    if not text:
        if unit == "1":
            return float(number)
        raise _fault(field, value, "has no unit", unit)
    try:
        return float(Fraction(number) * _factor(text, unit, field, value))
    except OverflowError:
        raise _fault(field, value, "is not a finite number", unit) from None


def text_with_unit(value: float, unit: str, shown_unit: str = "") -> str | float:
    """Return a number in SI as readable text with a unit; the number itself if there is none.

    There is none for a pure number without ``shown_unit``, and for inf and nan.

    Parameters
    ----------
    value : float
    unit : str
        SI unit; a pure number stays a number unless ``shown_unit`` is given.
    shown_unit : str
        Preferred of units whose texts are equally easy to read.

    Returns
    -------
    str or float
        "66 um", "3.38 GPa"; :func:`parse` returns exactly the same number.
    """
    names = dict.fromkeys((shown_unit or unit, *_OUTPUT_UNITS.get(unit, (unit,))))
    if unit == "1":
        names = dict.fromkeys([shown_unit] if shown_unit else [])
    texts = [text for name in names if (text := _in_unit(value, name, unit))]
    if not texts:
        return value
    return min(texts, key=_reading_penalty) if value else texts[0]  # 0 in the preferred unit


def _in_unit(value: float, name: str, unit: str) -> str:
    """Return a number with a unit; empty if :func:`parse` would not return the same number."""
    try:
        factor = _factor(name, unit, "", "")
        # 15 digits suffice for decimals; numbers such as pi need 17.
        number = Decimal(repr(value)) * factor.denominator / factor.numerator
        for digits in (15, 17):
            text = f"{_short(round(number, digits - 1 - number.adjusted()))} {name}"
            if parse(text, unit) == value:
                return text
    except (InvalidProblem, ArithmeticError):  # no such unit here, or beyond what floats hold
        pass
    return ""


def _short(number: Decimal) -> str:
    """Return a number without trailing zeros; with an exponent below 1e-5 and from 1e7."""
    number = number.normalize()
    return f"{number:f}" if -5 <= number.adjusted() <= 6 else f"{number:e}"


def _reading_penalty(text: str) -> tuple[int, int]:
    """Return a penalty for numbers that are hard to read: long, below 1, or above 10^4.

    Of equal ones the number with fewer digits before the point is preferred.
    """
    number = text.split()[0].lstrip("-")
    digits = len(number.partition(".")[0])
    is_hard = number.startswith("0") or digits > 4
    return len(number) + 2 * is_hard + 4 * ("e" in number), digits


def _as_float(value: float, unit: str, field: str) -> float:
    """Return a number as float; reject one that is too large."""
    try:
        return float(value)
    except OverflowError:  # a whole number of more than 308 digits
        raise _fault(field, f"{str(value)[:9]}...", "is not a finite number", unit) from None


def _factor(text: str, unit: str, field: str, value: str) -> Fraction:
    """Return the conversion factor to an SI unit; ``value`` is quoted in the error message."""
    text = _with_area(text) if len(text) <= _MAX_LENGTH else text
    if len(text) > _MAX_LENGTH or not _UNIT.fullmatch(text):
        raise _fault(field, value, f"has the unreadable unit {text!r}", unit)
    for name in re.findall(_NAME, text):
        if name not in known_units():
            raise _fault(field, value, f"has the unknown unit {name!r}", unit, _nearest(name))
    factor = _conversion_factor(text, unit)
    if factor is None:
        name, total = TOTALS.get(unit, ("", ""))
        is_total = bool(name) and _conversion_factor(text, total) is not None
        hint = f"; a {name} is divided by the width of the web" if is_total else ""
        if _in_unit_of(text, unit, _LINE_FORCES) is not None:
            hint = "; kg and g are masses: write kgf and gf for forces"
        raise _fault(field, value, "has the wrong dimension", unit, hint)
    return factor


@lru_cache(maxsize=256)
def _conversion_factor(text: str, unit: str) -> Fraction | None:
    """Return the conversion factor; "lb" may be a force, so that lb/in is lbf/in."""
    text = _with_area(text)
    forces = _FORCES | (_LINE_FORCES if unit == "N/m" else {})
    if unit == "Pa" and _BASIS_WEIGHT.search(text):  # lb remains a mass
        forces = {}
    as_mass = _in_unit_of(text, unit, {})
    return _in_unit_of(text, unit, forces) if as_mass is None else as_mass


def _in_unit_of(text: str, unit: str, forces: Mapping[str, str]) -> Fraction | None:
    """Return the conversion factor with some masses read as forces; None if it does not fit."""
    known = _definitions()
    target = _product(unit, known)
    source = _product(text, known | {name: known[force] for name, force in forces.items()})
    if source.powers == target.powers:
        return source.factor / target.factor
    if target.powers == {"s": -1} and source.powers == {"rad": 1, "s": -1}:
        return source.factor / target.factor / TURN  # an angular frequency
    return None


def _nearest(name: str) -> str:
    """Return a hint for an unknown unit; wrong case ("mpa") is the most common mistake."""
    word = name.lower()
    if word == "ream":
        sizes = "lb/3000 ft^2, lb/ream 24x36, lb/ream 25x38 or lb/ream 17x22"
        return f"; reams have several sizes: write {sizes}"
    full = _FULL_NAMES.get(word) or _FULL_NAMES.get(word.removesuffix("s"))
    if full:
        return f"; did you mean {full!r}?"
    names = [known for known in known_units() if known not in _SPELLINGS]
    matches = [known for known in names if known.lower() == word]
    return f"; did you mean {matches[0]!r}?" if matches else did_you_mean(name, names)


def _fault(field: str, value: Any, reason: str, unit: str, hint: str = "") -> InvalidProblem:
    """Return the error for a text that is not a number with a unit."""
    expected = "a plain number" if unit == "1" else f"a value in {unit}"
    example = _EXAMPLES.get(unit, "")
    if isinstance(value, str) and len(value) <= _MAX_LENGTH:
        hint += _typing_hint(value)
    return InvalidProblem([(field, f"{value!r} {reason}; expected {expected}{example}{hint}")])


def _typing_hint(value: str) -> str:
    """Return a hint for unsupported separators and dashes; empty without them."""
    rule = "; write a decimal point, and no thousands separator"
    if match := _THOUSANDS.match(value):
        digits = re.sub(r"[^\d.+-]", "", match[1])
        unit = match[2].strip()
        plain = f"{digits} {unit}".strip()
        if "," in match[1] and match[1].count(",") == 1 and "." not in match[1]:
            decimal = f"{match[1].replace(',', '.')} {unit}".strip()
            return f"{rule}: {plain!r} or {decimal!r}"
        return f"{rule}: {plain!r}"
    if match := _DECIMAL_COMMA.match(value):
        decimal = f"{match[1]}.{match[2]} {match[3].strip()}".strip()
        return f"{rule}: {decimal!r}"
    if "," in value:
        return rule
    if any(dash in value for dash in _DASHES):
        return "; write the minus as '-'"
    return ""
