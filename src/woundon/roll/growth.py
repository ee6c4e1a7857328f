"""Kappa as a function of the surface radius: the growth of a layer's pressure below the surface.

Kappa is defined in :mod:`.equations` and integrated in :mod:`.build_up`.
"""

from __future__ import annotations

import numpy as np

__all__ = ["ORDER", "Growth"]

Array = np.ndarray

ORDER = 3  # of the polynomial through the last stages
SMALLEST_SPACING = 0.5  # of a step: closer stages give an error estimate dominated by noise


class Growth:
    """Kappa over x = ln r: polynomials through up to four stages, none across a kink.

    Parameters
    ----------
    x, kappa : float
        Values at the core.

    Attributes
    ----------
    x, kappa : (J,) arrays
        The stages.
    through : (J,) int array
        Number of stages that the polynomial ending at each stage interpolates.
    """

    def __init__(self, x: float, kappa: float) -> None:
        self.x, self.kappa = np.array([x]), np.array([kappa])
        self.through = np.array([1])
        self.first = 0  # first stage of the next polynomials
        self._pieces = np.zeros((ORDER + 1, 0))

    @classmethod
    def of(cls, x: Array, kappa: Array, through: Array) -> Growth:
        """Create the function from stages; see the attributes."""
        growth = cls(float(x[0]), float(kappa[0]))
        growth.x, growth.kappa, growth.through = x, kappa, through
        growth.first = x.size - int(through[-1])
        growth._pieces = np.zeros((ORDER + 1, x.size - 1))
        for k in range(1, x.size):
            stages = slice(k + 1 - int(through[k]), k + 1)
            piece = _newton_polynomial(x[stages] - x[k - 1], kappa[stages])
            growth._pieces[: len(piece), k - 1] = piece
        return growth

    def until(self, x: float) -> Growth:
        """Return the same function up to x, with a last stage there."""
        n = int(np.searchsorted(self.x, x - 1e-12))
        part = Growth.__new__(Growth)
        part.x, part.kappa = self.x[:n], self.kappa[:n]
        part.through, part._pieces = self.through[:n], self._pieces[:, : n - 1]
        part.first = n + 1 - int(self.through[n])
        return part.with_stage(x, float(self(np.array([x]))[0]))

    def restart(self) -> None:
        """Start the next polynomials at the last stage, where the tension has a kink."""
        self.first = self.x.size - 1

    def _last_stages(self) -> slice:
        """Return the stages that the next polynomial interpolates."""
        return slice(max(self.first, self.x.size - ORDER), None)

    def extrapolate(self, x: float) -> float:
        """Extrapolate kappa to x by the polynomial through the last stages."""
        stages = self._last_stages()
        return _newton_polynomial(self.x[stages] - x, self.kappa[stages])[0]

    def lagrange_basis(self, surface: float, x: Array) -> Array:
        """Return the derivative of kappa(x) by the kappa of a further stage at ``surface``."""
        basis = np.where(x > self.x[-1], 1.0, 0.0)
        for stage in self.x[self._last_stages()]:
            basis *= (x - stage) / (surface - stage)
        return basis

    def with_stage(self, x: float, kappa: float) -> Growth:
        """Return a copy with one more stage."""
        copy, start = Growth.__new__(Growth), self._last_stages().start
        copy.x, copy.kappa = np.append(self.x, x), np.append(self.kappa, kappa)
        copy.first = self.first
        copy.through = np.append(self.through, copy.x.size - start)
        c = np.zeros((ORDER + 1, 1))
        piece = _newton_polynomial(copy.x[start:] - self.x[-1], copy.kappa[start:])
        c[: len(piece), 0] = piece
        copy._pieces = np.hstack([self._pieces, c])
        return copy

    def interpolation_error(self, x: Array) -> Array:
        """Estimate the interpolation error of kappa at x by polynomials of one degree more.

        These interpolate a following stage in addition, or a previous one if none follows.
        """
        errors, interval = np.zeros(x.size), np.searchsorted(self.x, x, side="left")
        for j in range(1, self.x.size):
            inside, start = interval == j, j + 1 - int(self.through[j])
            additional = self._stage_after(j) or start - 1
            if additional < 0 or not inside.any():
                continue
            stages = [*range(start, j + 1), additional]
            highest = _newton_polynomial(self.x[stages] - self.x[j], self.kappa[stages])[-1]
            errors[inside] = highest * np.prod(x[inside, None] - self.x[stages[:-1]], axis=1)
        return errors

    def _stage_after(self, j: int) -> int:
        """Return a later stage before the next kink, not too close to stage j; 0 if none."""
        for k in range(j + 1, self.x.size):
            if self.through[k] == 2:
                return 0
            if self.x[k] - self.x[j] > SMALLEST_SPACING * (self.x[j] - self.x[j - 1]):
                return k
        return 0

    def __call__(self, x: Array) -> Array:
        """Return kappa at any x."""
        if not self._pieces.shape[1]:
            return np.full(np.shape(x), self.kappa[0])
        k = np.clip(np.searchsorted(self.x, x, side="left") - 1, 0, self._pieces.shape[1] - 1)
        t, c = x - self.x[k], self._pieces[:, k]
        return np.asarray(c[0] + t * (c[1] + t * (c[2] + t * c[3])))


def _newton_polynomial(x: Array, y: Array) -> list[float]:
    """Return the ascending coefficients of the polynomial through points, by Newton's formula."""
    nodes, differences = x.tolist(), y.tolist()
    for k in range(1, len(nodes)):
        for j in range(len(nodes) - 1, k - 1, -1):
            differences[j] = (differences[j] - differences[j - 1]) / (nodes[j] - nodes[j - k])
    c = [differences[-1]]
    for k in range(len(nodes) - 2, -1, -1):  # multiply by (x - x_k) and add the next difference
        higher = (a - nodes[k] * b for a, b in zip(c, [*c[1:], 0.0], strict=True))
        c = [differences[k] - nodes[k] * c[0], *higher]
    return c
