"""Free strains by temperature and moisture: their changes, coefficients and ranges."""

from __future__ import annotations

from collections.abc import Mapping

from pydantic import Field

from ..quantities import Quantity, pure

__all__ = [
    "ALONG_EXPANSION",
    "ALONG_SWELLING",
    "EXPANSION_RANGE",
    "FREE_STRAINS",
    "OF_WEB",
    "SWELLING_RANGE",
    "THROUGH_EXPANSION",
    "THROUGH_SWELLING",
    "expansion",
    "swelling",
]

PER_KELVIN = 1e-2  # larger than the thermal expansion of any solid

# Changes of the finished roll by free strains: the largest size of each, and the fields with its
# coefficients along the web, through the stack and of the core.
FREE_STRAINS: Mapping[str, tuple[float, tuple[str, str, str]]] = {
    "temperature_change": (
        1000.0,
        ("tangential_expansion", "radial_expansion", "core_expansion"),
    ),
    "moisture_change": (1.0, ("tangential_swelling", "radial_swelling", "core_swelling")),
}
# Coefficients of the web, which a grade may supply.
OF_WEB = tuple(name for _, coefficients in FREE_STRAINS.values() for name in coefficients[:2])
EXPANSION_RANGE = Field(ge=-PER_KELVIN, le=PER_KELVIN)
SWELLING_RANGE = Field(ge=-10, le=10)


def expansion(symbol: str, place: str) -> Quantity:
    """Return the quantity of a coefficient of thermal expansion [1/K]."""
    return Quantity(symbol, "1/K", f"thermal expansion {place}")


def swelling(symbol: str, place: str) -> Quantity:
    """Return the quantity of a coefficient of swelling [1]."""
    return pure(symbol, f"swelling {place}, strain by a moisture content of 1")


ALONG_EXPANSION = expansion("alpha_t", "along the web")
THROUGH_EXPANSION = expansion("alpha_r", "through the stack")
ALONG_SWELLING = swelling("beta_t", "along the web")
THROUGH_SWELLING = swelling("beta_r", "through the stack")
