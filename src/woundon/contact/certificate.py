"""How far given tractions, zones and slips are from each law of friction and of the web.

Every function takes what a result holds and measures it; nothing is taken from how it was solved.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

__all__ = [
    "ROUNDING", "beyond_rounding", "friction_laws", "from_edge", "integral", "largest",
    "misplaced_slips", "positive", "positive_pressure",
]  # fmt: skip

Array = np.ndarray

ROUNDING = 4 * np.finfo(float).eps


def largest(values: Array | Sequence[float]) -> float:
    """Return the largest of some violations, 0 of none; nan if one is nan.

    Python's ``max`` drops a nan that does not come first.
    """
    return float(np.maximum.reduce(values, axis=None, initial=0.0))


def beyond_rounding(miss: Array, size: Array) -> float:
    """Return the largest miss of a sum, less what rounding of a number of its size may leave.

    A tension of 500 N/m is known to 6e-14 N/m, which is much beside a nip load of 1e-9 N/m.
    """
    return largest(np.abs(miss) - ROUNDING * np.abs(size).max())


def positive_pressure(*pressures: Array) -> float:
    """Return how far a pressure falls below zero, relative to the largest."""
    values = np.concatenate(pressures)
    return largest(np.maximum(-values, 0.0)) / float(np.abs(values).max())


def positive(*values: Array) -> float:
    """Return 0 if all values are positive, else inf; nan counts as a violation."""
    return 0.0 if all((each > 0).all() for each in values) else float("inf")


def misplaced_slips(slip_x: Array, x: Array) -> float:
    """Return by how much the points of the slips are outside the cells next to their nodes [m]."""
    before, behind = np.append(x[:1], x[:-1]), np.append(x[1:], x[-1:])
    return largest(np.maximum(before - slip_x, slip_x - behind))


def friction_laws(
    zones: Array,
    traction: Array,
    slip: Array,
    bound: Array,
    *,
    unit: Array,
    slip_scale: float,
    strain: float = 0.0,
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
    strain : float
        Of the web: a slip is a difference of strains, known to their rounding.
    """
    stuck, slips, rounding = (zones == 0).nonzero()[0], zones.nonzero()[0], ROUNDING * abs(strain)
    way, sliding, bounds = zones.take(slips), slip.take(slips), bound.take(slips)
    held = np.abs(traction.take(stuck)) - bound.take(stuck)
    # a number that is none of the three is no zone: its traction cannot be right
    wrong = float("inf") if (np.abs(way) != 1).any() else 0.0
    return {
        "stick": largest(np.abs(slip.take(stuck)) - rounding) / slip_scale,
        "friction_bound": largest(held / unit.take(stuck)),
        "slip_traction": wrong
        + largest(np.abs(traction.take(slips) - way * bounds) / unit.take(slips)),
        "slip_direction": largest(-way * sliding - rounding) / slip_scale,
    }


def from_edge(values: Array, x: Array) -> Array:
    """Integrate piecewise linear values from the first node to every node, (M,)."""
    out = np.zeros(x.size)
    np.cumsum((x[1:] - x[:-1]) * (values[1:] + values[:-1]), out=out[1:])
    return out / 2


def integral(values: Array, x: Array) -> float:
    """Integrate piecewise linear values over all nodes."""
    return float((x[1:] - x[:-1]) @ (values[1:] + values[:-1])) / 2
