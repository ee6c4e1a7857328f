"""How far given tractions, zones and slips are from each law of friction and of the web.

Every function takes what a result holds and measures it; nothing is taken from how it was solved.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

__all__ = ["friction_laws", "largest", "positive_pressure"]

Array = np.ndarray


def largest(values: Array) -> float:
    """Return the largest of some violations, 0 of none; nan if one is nan."""
    return float(np.max(values, initial=0.0))


def positive_pressure(*pressures: Array) -> float:
    """Return how far a pressure falls below zero, relative to the largest."""
    values = np.concatenate(pressures)
    return largest(np.maximum(-values, 0.0)) / float(np.max(np.abs(values)))


def friction_laws(
    zones: Array, traction: Array, slip: Array, bound: Array, *, unit: Array, slip_scale: float
) -> Mapping[str, float]:
    """Return the largest violation of each law of stick and slip, dimensionless.

    Parameters
    ----------
    zones : (m,) int array
        0 stick, 1 slip with the web faster, -1 slower.
    traction, slip : (m,) arrays
        q [Pa], and the slip that the law of the bodies gives.
    bound : (m,) array
        mu p [Pa].
    unit : (m,) array
        The traction that counts as one: mu times the largest pressure [Pa].
    slip_scale : float
        The slip that counts as one.
    """
    stuck = zones == 0
    known = np.isin(zones, (-1, 0, 1))
    return {
        "stick": largest(np.abs(slip)[stuck]) / slip_scale,
        "friction_bound": largest(((np.abs(traction) - bound) / unit)[stuck]),
        # a zone that is none of the three is no zone: its traction cannot be right
        "slip_traction": largest((np.abs(traction - np.sign(zones) * bound) / unit)[~stuck])
        + (0.0 if known.all() else float("inf")),
        "slip_direction": largest((-zones * slip)[~stuck]) / slip_scale,
    }
