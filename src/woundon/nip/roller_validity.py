"""Validity checks of two rollers."""

from __future__ import annotations

from ..validity import limit_warning, pair_warnings, zone_warnings
from .roller_result import RollerResult

__all__ = ["roller_warnings"]


def roller_warnings(result: RollerResult) -> tuple[str, ...]:
    """Return the warnings of rollers outside the validity limits, or on too coarse a mesh."""
    xi, mu = result.creepage, result.problem.friction  # xi is nan in static contact
    return (
        *pair_warnings(result, {"upper": result.traction, "lower": -result.traction}),
        *limit_warning("creepage", xi, "the rollers' surface speeds differ by {}"),
        *(zone_warnings(result.x, {"contact": result.zone}, "the lower surface") if mu else ()),
    )
