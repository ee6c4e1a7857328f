"""The one table of a result's quantities: symbol, SI unit, unit for display, description.

The command line, the files' labels and the nomenclature in the documentation all read it.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import pi
from types import MappingProxyType
from typing import NamedTuple

__all__ = ["QUANTITIES", "Quantity"]


class Quantity(NamedTuple):
    """A result's quantity; ``value_shown = value * per_si`` in the unit ``shown_unit``."""

    symbol: str
    unit: str
    description: str
    shown_unit: str = ""
    per_si: float = 1.0

    def shown(self, value: float) -> float:
        """Return an SI value in the unit for display."""
        return value * self.per_si

    @property
    def display(self) -> str:
        """The unit for display, '' for a pure number."""
        unit = self.shown_unit or self.unit
        return "" if unit == "1" else unit


def _length(symbol: str, description: str) -> Quantity:
    return Quantity(symbol, "m", description, "mm", 1e3)


def _stress(symbol: str, description: str) -> Quantity:
    return Quantity(symbol, "Pa", description, "kPa", 1e-3)


def _strain(symbol: str, description: str) -> Quantity:
    return Quantity(symbol, "1", description, "%", 1e2)


def _angle(symbol: str, description: str) -> Quantity:
    return Quantity(symbol, "rad", description, "deg", 180 / pi)


def _line_load(symbol: str, description: str) -> Quantity:
    return Quantity(symbol, "N/m", description)


QUANTITIES: Mapping[str, Quantity] = MappingProxyType(
    {
        # loads of the problem
        "nip_load": _line_load("P", "nip load"),
        "winding_force": _line_load("F", "winding force, integral of the drum traction"),
        "incoming_tension": _line_load("T_in", "web tension before the nip"),
        # scalars of a nip
        "nip_induced_tension": _line_load("NIT", "nip-induced tension"),
        "nip_induced_tension_error": _line_load(
            "NIT error", "estimated discretisation error of the nip-induced tension"
        ),
        "wound_on_tension": _line_load("T_out", "wound-on tension"),
        "half_width": _length("a", "half-width of the nip"),
        "nip_width": _length("2a", "nip width"),
        "approach": _length("delta", "approach of the centres of roll and drum"),
        "offset": _length("Delta", "shift of the contact centre from the line of centres"),
        "drum_creep": _strain("xi-", "creep of web and drum"),
        "peak_pressure": _stress("p_max", "largest pressure"),
        # arrays along the nip
        "x": _length("x", "position along the nip, with the web; the contact is [-a, a]"),
        "pressure": _stress("p", "pressure"),
        "roll_traction": _stress("q+", "traction of the web on the roll"),
        "drum_traction": _stress("q-", "traction of the web on the drum"),
        "slip_x": _length("x_v", "where the slips are taken, the middle of the cell before a node"),
        "roll_slip": _strain("v+", "slip of the web against the roll, > 0: web faster"),
        "drum_slip": _strain("v-", "slip of the web against the drum, > 0: web faster"),
        "web_tension": _line_load("T", "web tension along the nip"),
        "roll_zone": Quantity(
            "z+", "1", "zone at the roll: 0 stick, 1 slip with the web faster, -1 slower"
        ),
        "drum_zone": Quantity(
            "z-", "1", "zone at the drum: 0 stick, 1 slip with the web faster, -1 slower"
        ),
        # signed slip lengths over the nip width
        "leading_roll": _strain("s_l+", "slip length at the roll's leading edge / nip width"),
        "trailing_roll": _strain("s_t+", "slip length at the roll's trailing edge / nip width"),
        "dual": _strain("s_d", "length of slip at both roll and drum / nip width"),
        # the web wrapped on roll and drum
        "wound_on_tension_error": _line_load(
            "WOT error", "estimated discretisation error of the wound-on tension"
        ),
        "tension_before_nip": _line_load("T_n", "web tension at the leading edge of the nip"),
        "tension_behind_nip": _line_load("T_out", "web tension at the trailing edge of the nip"),
        "roll_wrap_traction": _line_load("Q_w+", "traction on the roll behind the nip, integrated"),
        "drum_wrap_traction": _line_load("Q_w-", "traction on the drum before the nip, integrated"),
        "roll_wrap": _angle("theta+", "angle from the nip to where the web is held to the roll"),
        "drum_wrap": _angle("theta-", "arc of the web on the drum before the nip"),
        "slip_angle": _angle("theta_s", "how far the web slips on the roll behind the nip"),
        "wrap_friction": Quantity("mu_w+", "1", "friction on the roll behind the nip"),
        "roll_strain": _strain("eps1", "strain of the roll's surface along the web"),
        "roll_pressure": _stress("p+", "pressure of the web on the roll"),
        "hoop_pressure": _stress("p_h", "hoop pressure, web tension times curvature"),
        "curvature": Quantity("kappa", "1/m", "curvature of the web, > 0: centre in the roll"),
        # two rollers
        "creepage": _strain("xi", "creepage, surface speed of the lower roller less the upper's"),
        "tangential_load": _line_load("Q", "tangential load on the upper roller"),
        "traction_error": _strain("e_q", "estimated error of the traction (L2), relative"),
        "traction": _stress("q", "traction on the upper roller"),
        "slip": _strain("v", "slip speed, > 0: lower surface faster"),
        "static_slip": Quantity("v", "m", "slip of static rollers, > 0: lower surface along +x"),
        "zone": Quantity(
            "z", "1", "zone: 0 stick, 1 slip with the lower surface faster, -1 slower"
        ),
        # how it was solved
        "iterations": Quantity("n_it", "1", "linear stick-slip systems solved"),
        "series_terms": Quantity("n_s", "1", "Fourier terms summed"),
        "series_error": Quantity("e_s", "1", "estimated truncation error of the series"),
        "residual": Quantity("r", "1", "largest violation of a contact law, dimensionless"),
    }
)
