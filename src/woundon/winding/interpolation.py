r"""Adaptive interpolation of a function of the radius, with an error estimate.

Between kinks the interpolant is a polynomial through Leja points: each further point maximises the
product of the distances to the others, so that all earlier values are reused.  The coordinate is
ln(r - r_c), because the nip depends on the depth of the roll.  The error estimate is the difference
between a new value and the polynomial without it, an upper estimate for the polynomial with it.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache

import numpy as np

__all__ = ["Piece", "leja"]

Array = np.ndarray
GRID = 4001
TESTS = 2  # number of last points that give the error estimate
UNTESTED = 3  # first points, for which a polynomial of low order gives no estimate


@cache
def leja(count: int) -> tuple[float, ...]:
    """Return the Leja points on [0, 1]; the first two are the ends.

    They are chosen among GRID even points.
    """
    x = np.linspace(0, 1, GRID)
    chosen = [0.0, 1.0]
    product = np.abs(x * (x - 1))
    while len(chosen) < count:
        chosen.append(float(x[np.argmax(product)]))
        product *= np.abs(x - chosen[-1])
    return tuple(chosen[:count])


class Piece:
    """A polynomial on an interval, through Leja points in their order.

    Parameters
    ----------
    start, end : float
        The interval.
    count : int
        Initial number of points, at least two.

    Attributes
    ----------
    places : list of float
        Coordinates of the interpolation points, in the order of the Leja points.
    """

    def __init__(self, start: float, end: float, count: int) -> None:
        self.start, self.end = start, end
        self.places = [start, end, *(start + t * (end - start) for t in leja(count)[2:])]

    @property
    def next_place(self) -> float:
        """Coordinate of the next interpolation point."""
        return self.start + leja(len(self.places) + 1)[-1] * (self.end - self.start)

    def at(self, x: Array, values: Mapping[float, float], first: int | None = None) -> Array:
        """Evaluate the polynomial through the values at the interpolation points.

        Parameters
        ----------
        x : array
            Coordinates in the interval, any shape.
        values : mapping of float to float
            Values by the coordinates of the points.
        first : int, optional
            Number of points that are used, in their order; by default all.
        """
        nodes = np.array(self.places[:first])
        y = np.array([values[place] for place in self.places[:first]])
        # barycentric formula, stable at any x; the scale prevents very small or large products
        scale = 4 / (self.end - self.start)
        distances = scale * (nodes[:, None] - nodes) + np.eye(nodes.size)  # 1 of a node to itself
        weights = 1 / distances.prod(axis=1)
        with np.errstate(divide="ignore", invalid="ignore"):
            terms = weights / (np.asarray(x)[..., None] - nodes)
            polynomial = terms @ y / terms.sum(axis=-1)
        is_node = np.asarray(x)[..., None] == nodes
        return np.where(is_node.any(axis=-1), is_node @ y, polynomial)

    def error_estimates(self, values: Mapping[float, float]) -> list[tuple[float, float]]:
        """Return (coordinate, error) of the last points.

        The error is that of the polynomial through the points before it.  ``values`` map the
        coordinates of the points to the values there.
        """
        differences = []
        for k in range(max(UNTESTED, len(self.places) - TESTS), len(self.places)):
            place = self.places[k]
            error = float(self.at(np.array(place), values, first=k)) - values[place]
            differences.append((place, abs(error)))
        return differences
