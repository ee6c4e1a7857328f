"""Where a solved case leaves the model: linear, small-strain, two-dimensional, a taut web.

Each warning is a sentence with its numbers.  The limits are where the neglected terms reach about
a tenth of those kept; a warning is data, not an error: the solved equations hold all the same.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import Any

import numpy as np

from ..results import Zone
from .equations import web_compliance
from .result import WindingNipResult

__all__ = ["nip_warnings"]

Array = np.ndarray

LARGE_STRAIN = 0.1  # quadratic terms of the strain are then a tenth of the linear ones
WIDE_NIP = 0.2  # of the smaller radius: the parabola for the circle is then off by 1 %
FEW_NODES = 4
NARROW_ZONE = 0.02  # of the nip width
SERIES_ERROR = 1e-4


def nip_warnings(result: WindingNipResult) -> tuple[str, ...]:
    """Return where a solved nip leaves the model's validity, with numbers."""
    parts: tuple[Any, ...] = (_bodies, _geometry, _pressure, _surface, _web, _numerics)
    nip: Any = _Nip(result)
    return tuple(warning for part in parts for warning in part(nip))


class _Nip:
    """A result's fields, its arrays cut to the nip."""

    def __init__(self, result: WindingNipResult) -> None:
        self._result, self._own = result, result.in_nip

    def __getattr__(self, name: str) -> Any:
        value = getattr(self._result, name)
        if isinstance(value, np.ndarray):
            value = value[self._own]
        setattr(self, name, value)
        return value


def _bodies(r: _Nip) -> Iterator[str]:
    for name, body in (("roll", r.problem.roll), ("drum", r.problem.drum)):
        if body.caution:
            yield f"of the {name}: {body.caution}"


def _geometry(r: _Nip) -> Iterator[str]:
    radius = min(r.problem.roll.radius, r.problem.drum.radius)
    if r.half_width > WIDE_NIP * radius:
        yield (
            f"the half width {r.half_width * 1e3:.3g} mm is {r.half_width / radius:.0%} of the "
            f"smaller radius: the gap is no parabola any more"
        )
    for name, body in (("roll", r.problem.roll), ("drum", r.problem.drum)):
        if r.approach > LARGE_STRAIN * body.thickness:
            yield (
                f"the approach {r.approach * 1e3:.3g} mm is {r.approach / body.thickness:.0%} of "
                f"the {name}'s elastic layer, {body.thickness * 1e3:.3g} mm: strains are not small"
            )


def _pressure(r: _Nip) -> Iterator[str]:
    peak = float(np.max(r.pressure))
    for name, body in (("roll", r.problem.roll), ("drum", r.problem.drum)):
        if body.surface_material is not None:
            stiffness = body.surface_material.stiffness
            modulus = min(stiffness.rr, stiffness.tt)
            if peak > LARGE_STRAIN * modulus:
                yield (
                    f"the peak pressure {peak / 1e6:.3g} MPa is {peak / modulus:.0%} of the "
                    f"{name}'s stiffness {modulus / 1e6:.3g} MPa: the material is not linear there"
                )
    web = r.problem.web.material.stiffness
    if peak > LARGE_STRAIN * web.rr:
        yield (
            f"the peak pressure {peak / 1e6:.3g} MPa is {peak / web.rr:.0%} of the web's radial "
            f"stiffness {web.rr / 1e6:.3g} MPa: the web's thickness changes too much"
        )


def _surface(r: _Nip) -> Iterator[str]:
    for name, body, traction, strain in (
        ("roll", r.problem.roll, r.roll_traction, _roll_strain(r)),
        ("drum", r.problem.drum, r.drum_traction, _drum_strain(r)),
    ):
        if body.rigid:
            continue
        if body.surface_material is not None:
            shear = float(np.max(np.abs(traction)))
            angle = shear / body.surface_material.stiffness.shear
            if angle > LARGE_STRAIN:
                yield (
                    f"the {name}'s surface shear strain is {angle:.0%} "
                    f"at a traction of {shear / 1e6:.3g} MPa: strains are not small"
                )
        k = int(np.argmax(np.abs(strain)))
        if abs(strain[k]) > LARGE_STRAIN:
            yield (
                f"the {name}'s surface strain is {strain[k]:.0%} at x = {r.x[k] * 1e3:.3g} mm: "
                f"strains are not small"
            )


def _web_strain(r: _Nip) -> Array:
    """Return the web's strain (thesis eq. 72) where the slips are taken, (M,)."""
    web = r.problem.web
    c = web_compliance(web)
    strain = c.c11 / web.thickness * r.web_tension - c.c12 * r.pressure
    return np.interp(r.slip_x, r.x, strain)


def _drum_strain(r: _Nip) -> Array:
    """Return the drum's tangential surface strain in the nip, by its slip (thesis eq. 133)."""
    return _web_strain(r) + r.drum_creep - r.drum_slip


def _roll_strain(r: _Nip) -> Array:
    """Return the roll's tangential surface strain less that at the trailing edge."""
    strain = _web_strain(r) - r.roll_slip
    return strain - strain[-1]


def _web(r: _Nip) -> Iterator[str]:
    slackest = float(np.min(r.web_tension))
    if slackest < 0:
        at = float(r.x[int(np.argmin(r.web_tension))])
        yield (
            f"the web is slack: its tension falls to {slackest:.4g} N/m at x = {at * 1e3:.3g} mm; "
            f"at least {r.problem.web_tension - slackest:.4g} N/m of web tension are needed"
        )


def _numerics(r: _Nip) -> Iterator[str]:
    for face, zones in (("roll", r.roll_zone), ("drum", r.drum_zone)):
        inner = zones[1:-1]
        borders = (np.nonzero(inner[1:] != inner[:-1])[0] + 1).tolist()
        for first, last in pairwise([0, *borders, inner.size]):
            count, width = last - first, float(r.x[last + 1] - r.x[first])
            # a narrower zone, mostly at the very edge, cannot move NIT beyond its stated error
            if count < FEW_NODES and width > NARROW_ZONE * 2 * r.half_width:
                zone = Zone(int(zones[first + 1])).name.lower()
                yield (
                    f"{count} {'node' if count == 1 else 'nodes'} in a {zone} zone of the {face}; "
                    f"use nodes={2 * r.nodes - 1}"
                )
    if r.series_error > SERIES_ERROR:
        yield (
            f"the series of an elastic layer is truncated with an error of {r.series_error:.2g} "
            f"after {r.series_terms} terms"
        )
