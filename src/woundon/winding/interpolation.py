r"""A function of the radius from as few values as will do, and how far it may be off.

Between kinks it is a polynomial through Leja's points: each further one is where the product of the
distances to the others is largest, so that points are added one by one and none is wasted.  The
coordinate is ln(r - r_c), for a nip feels a roll's depth.  Before a value is added the polynomial
without it says what it expects there.  This difference is the error estimate of the
polynomial with it, which is smaller.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache

import numpy as np

__all__ = ["Piece", "leja"]

Array = np.ndarray
FINE = 4001
FEWEST = 7  # points of a piece
TESTS = 2  # the last points, whose misses tell the error,
UNTESTED = 3  # but not the first ones, which any polynomial has


@cache
def leja(count: int) -> tuple[float, ...]:
    """Return Leja's points on [0, 1], the first ones both ends."""
    x = np.linspace(0, 1, FINE)
    chosen = [0.0, 1.0]
    product = np.abs(x * (x - 1))
    while len(chosen) < count:
        chosen.append(float(x[np.argmax(product)]))
        product *= np.abs(x - chosen[-1])
    return tuple(chosen[:count])


class Piece:
    """A polynomial between two places; its points are at Leja's, in their order.

    Parameters
    ----------
    start, end : float
        Where it begins and ends.
    count : int
        How many points it has to begin with.
    """

    def __init__(self, start: float, end: float, count: int = FEWEST) -> None:
        self.start, self.end = start, end
        self.places = [start, end, *(start + share * (end - start) for share in leja(count)[2:])]

    @property
    def next(self) -> float:
        """Where the next value is wanted."""
        share = leja(len(self.places) + 1)[-1]
        return self.start + share * (self.end - self.start)

    def at(self, x: Array, values: Mapping[float, float], first: int | None = None) -> Array:
        """Return the polynomial through the values at its points, or at the first ones of them."""
        own = np.array(self.places[:first])
        y = np.array([values[place] for place in self.places[:first]])
        # barycentric: stable at any point
        scale = 4 / (self.end - self.start)
        apart = scale * (own[:, None] - own) + np.eye(own.size)
        weights = 1 / apart.prod(axis=1)
        with np.errstate(divide="ignore", invalid="ignore"):
            terms = weights / (np.asarray(x)[..., None] - own)
            found = terms @ y / terms.sum(axis=-1)
        hit = np.asarray(x)[..., None] == own
        return np.where(hit.any(axis=-1), hit @ y, found)

    def misses(self, values: Mapping[float, float]) -> list[tuple[float, float]]:
        """Return of the last points where they are, and by how far the polynomial before is off."""
        differences = []
        for k in range(max(UNTESTED, len(self.places) - TESTS), len(self.places)):
            place = self.places[k]
            off = float(self.at(np.array(place), values, k)) - values[place]
            differences.append((place, abs(off)))
        return differences
