"""What a nip's own mesh has: there its equations hold, and its derivatives are exact."""

from __future__ import annotations

from typing import Any

__all__ = ["own_tension"]


def own_tension(of: Any) -> Any:
    """Return NIT as the mesh has it, of a result or of a study's data with both outputs.

    The NIT that is told is corrected by ``extrapolation`` for where borders of stick lie within
    their cells, found with the factors at hand: what a solve began with shows there by a hundredth
    of the correction.
    """
    wrapped = hasattr(of, "extrapolation_of_nip")
    return of.nip_induced_tension - (of.extrapolation_of_nip if wrapped else of.extrapolation)
