"""Kappa as a function of the surface radius: the growth of a layer's pressure below the surface.

Kappa is defined in :mod:`.equations` and integrated in :mod:`.build_up`; in a roll of lanes
(:mod:`.lanes`) further functions of the surface radius are interpolated in the same way.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np

__all__ = ["ORDER", "Growth", "point_counts_of"]

Array = np.ndarray

ORDER = 3  # of the polynomial through the last stages
SAME = 1e-12  # of ln r: closer points are one
SMALLEST_SPACING = 0.5  # of a step: closer stages give an error estimate dominated by noise


class Growth:
    """Kappa over x = ln r: polynomials through up to four stages, none across a kink.

    Parameters
    ----------
    x : float
        ln r of the core.
    kappa : float, or (K,) array
        Value there, or the values of K functions that are interpolated together.

    Attributes
    ----------
    x : (J,) array
        The stages.
    kappa : (J,) or (J, K) array
        The values there.
    point_counts : (J,) int array
        Number of stages that the polynomial ending at each stage interpolates.
    """

    def __init__(self, x: float, kappa: float | Array) -> None:
        self.x, self.kappa = np.array([x]), np.array([kappa])
        self.point_counts = np.array([1])
        self.first = 0  # first stage of the next polynomials
        self._coefficients = np.zeros((ORDER + 1, 0, *self.kappa.shape[1:]))

    @classmethod
    def of(cls, x: Array, kappa: Array, point_counts: Array) -> Growth:
        """Create the function from stages; see the attributes."""
        growth = cls(float(x[0]), float(kappa[0]))
        growth.x, growth.kappa, growth.point_counts = x, kappa, point_counts
        growth.first = x.size - int(point_counts[-1])
        growth._coefficients = np.zeros((ORDER + 1, x.size - 1))
        for k in range(1, x.size):
            stages = slice(k + 1 - int(point_counts[k]), k + 1)
            coefficients = _newton_polynomial(x[stages] - x[k - 1], kappa[stages])
            growth._coefficients[: len(coefficients), k - 1] = coefficients
        return growth

    def truncate(self, x: float) -> Growth:
        """Return the same function up to x, with a last stage there."""
        n = int(np.searchsorted(self.x, x - 1e-12))
        truncated = Growth.__new__(Growth)  # all attributes follow
        truncated.x, truncated.kappa = self.x[:n], self.kappa[:n]
        truncated.point_counts = self.point_counts[:n]
        truncated._coefficients = self._coefficients[:, : n - 1]
        # the new last stage, n, lies on the polynomial that ends at stage n of this function
        truncated.first = n + 1 - int(self.point_counts[n])
        return truncated.with_stage(x, float(self(np.array([x]))[0]))

    @property
    def kinks(self) -> Array:
        """Numbers of the stages at which a new polynomial starts: the core (0) and the kinks.

        The polynomial of the following stage has two points.
        """
        return np.flatnonzero(self.point_counts == 2) - 1

    def start_new_polynomial(self) -> None:
        """Start the next polynomials at the last stage, where the tension has a kink."""
        self.first = self.x.size - 1

    def _last_stages(self) -> slice:
        """Return the stages that the next polynomial interpolates."""
        return slice(max(self.first, self.x.size - ORDER), None)

    def extrapolate(self, x: float) -> Any:
        """Extrapolate kappa to x by the polynomial through the last stages."""
        stages = self._last_stages()
        # with the origin at x the constant coefficient is the value there
        return _newton_polynomial(self.x[stages] - x, self.kappa[stages])[0]

    def lagrange_basis(self, surface: float, x: Array) -> Array:
        """Return the derivative of kappa(x) by the kappa of a further stage, with x any shape [1].

        ``surface`` is ln r of that stage.  Up to the last stage the derivative is zero; beyond, it
        is the Lagrange polynomial that is 1 at ``surface`` and 0 at the last stages.
        """
        basis = np.where(x > self.x[-1], 1.0, 0.0)
        for stage in self.x[self._last_stages()]:
            basis *= (x - stage) / (surface - stage)
        return basis

    def lagrange_slope(self, surface: float, x: Array) -> Array:
        """Return the derivative of :meth:`lagrange_basis` by x, at the last stage its outer one."""
        stages = self.x[self._last_stages()]
        slope = np.zeros(np.shape(x))
        for left_out in stages:
            term = 1 / (surface - left_out)
            for stage in stages[stages != left_out]:
                term = term * (x - stage) / (surface - stage)
            slope = slope + term
        return np.where(x >= self.x[-1], slope, 0.0)

    def basis(self, x: Array) -> tuple[Array, Array]:
        """Return the stages on whose kappa that at x depends, and its derivatives by them.

        Parameters
        ----------
        x : (k,) array

        Returns
        -------
        two (k, ORDER + 1) arrays
            Numbers of stages, and derivatives [1]; those of stages that are not used are zero.
        """
        # of the polynomials that end at each stage
        back = np.arange(ORDER + 1)
        is_used = back < self.point_counts[:, None]
        stages = np.maximum(np.arange(self.x.size)[:, None] - back, 0)
        nodes = self.x[stages]
        spans = nodes[:, :, None] - nodes[:, None, :]
        is_pair = is_used[:, :, None] & is_used[:, None, :] & ~np.eye(ORDER + 1, dtype=bool)
        denominators = np.where(is_pair, spans, 1.0).prod(axis=2)
        # Lagrange polynomials at the points
        last = np.clip(np.searchsorted(self.x, x, side="left"), 1, self.x.size - 1)
        distances = np.where(is_used[last], x[:, None] - nodes[last], 1.0)
        numerators = np.stack(
            [np.delete(distances, k, axis=1).prod(axis=1) for k in back.tolist()], axis=1
        )
        factors = is_used[last] * numerators / denominators[last]
        return stages[last], factors

    def with_stage(self, x: float, kappa: float | Array) -> Growth:
        """Return a copy with one more stage."""
        # all attributes of the new object follow
        extended, start = Growth.__new__(Growth), self._last_stages().start
        extended.x = np.append(self.x, x)
        extended.kappa = np.concatenate([self.kappa, np.asarray(kappa)[None]])
        extended.first = self.first
        extended.point_counts = np.append(self.point_counts, extended.x.size - start)
        column = np.zeros((ORDER + 1, 1, *self.kappa.shape[1:]))
        coefficients = _newton_polynomial(extended.x[start:] - self.x[-1], extended.kappa[start:])
        column[: len(coefficients), 0] = coefficients
        extended._coefficients = np.concatenate([self._coefficients, column], axis=1)
        return extended

    def interpolation_error(self, x: Array) -> Array:
        """Estimate the interpolation error of kappa at x by polynomials of one degree more.

        These interpolate a following stage in addition, or a previous one if none follows.
        """
        errors, interval = np.zeros(x.size), np.searchsorted(self.x, x, side="left")
        for j in range(1, self.x.size):
            in_interval, start = interval == j, j + 1 - int(self.point_counts[j])
            extra_stage = self._stage_after(j) or start - 1
            if extra_stage < 0 or not in_interval.any():
                continue
            stages = [*range(start, j + 1), extra_stage]
            leading = _newton_polynomial(self.x[stages] - self.x[j], self.kappa[stages])[-1]
            errors[in_interval] = leading * np.prod(
                x[in_interval, None] - self.x[stages[:-1]], axis=1
            )
        return errors

    def _stage_after(self, j: int) -> int:
        """Return a later stage before the next kink, not too close to stage j; 0 if none."""
        for k in range(j + 1, self.x.size):
            if k - 1 in self.kinks:
                return 0
            if self.x[k] - self.x[j] > SMALLEST_SPACING * (self.x[j] - self.x[j - 1]):
                return k
        return 0

    def __call__(self, x: Array) -> Array:
        """Return kappa at any x; of K functions with the shape (x.size, K), of x in one row."""
        if not self._coefficients.shape[1]:
            return np.broadcast_to(self.kappa[0], (*np.shape(x), *self.kappa.shape[1:]))
        t, c = self._local(x, np.searchsorted(self.x, x, side="left"))
        return np.asarray(c[0] + t * (c[1] + t * (c[2] + t * c[3])))

    def slope(self, x: Array, side: Array) -> Array:
        """Return d kappa/dx at x (n,); at a stage, of its inner (-1) or outer (1) side.

        Of K functions with the shape (n, K).
        """
        interval = np.where(
            side > 0,
            np.searchsorted(self.x, x + SAME, side="left"),
            np.searchsorted(self.x, x - SAME, side="left"),
        )
        t, c = self._local(x, interval)
        return np.asarray(c[1] + t * (2 * c[2] + t * 3 * c[3]))

    def _local(self, x: Array, interval: Array) -> tuple[Array, Array]:
        """Return x - x_k and the coefficients of the polynomials of the intervals that hold x.

        ``interval`` is the number of the stage at which each of them ends.
        """
        k = np.clip(interval - 1, 0, self._coefficients.shape[1] - 1)
        t = x - self.x[k]
        return t.reshape(t.shape + (1,) * (self.kappa.ndim - 1)), self._coefficients[:, k]


def point_counts_of(stages: Sequence[int], kinks: Array) -> Array:
    """Return the point counts of a function through some stages of another one.

    Parameters
    ----------
    stages : sequence of int
        Numbers of the stages behind the core, which is stage 0, in increasing order.
    kinks : int array
        Stages at which new polynomials start, among them the core.
    """
    counts, points = [1], 1
    for previous, _ in pairwise([0, *stages]):
        points = 2 if previous in kinks else min(points + 1, ORDER + 1)
        counts.append(points)
    return np.array(counts)


def _newton_polynomial(x: Array, y: Array) -> list[Any]:
    """Return the ascending coefficients of the polynomial through points, by Newton's formula.

    The values are (k,), or (k, K) of K functions; the coefficients are numbers or (K,) arrays.
    """
    nodes, differences = x.tolist(), y.tolist() if y.ndim == 1 else list(y)
    for k in range(1, len(nodes)):
        for j in range(len(nodes) - 1, k - 1, -1):
            differences[j] = (differences[j] - differences[j - 1]) / (nodes[j] - nodes[j - k])
    c = [differences[-1]]
    for k in range(len(nodes) - 2, -1, -1):  # multiply by (x - x_k) and add the next difference
        higher = (a - nodes[k] * b for a, b in zip(c, [*c[1:], 0.0], strict=True))
        c = [differences[k] - nodes[k] * c[0], *higher]
    return c
