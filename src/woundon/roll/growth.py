"""Kappa over the build-up of a roll: the growth of a further layer's pressure below the surface."""

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
            own = slice(k + 1 - int(through[k]), k + 1)
            piece = _through(x[own] - x[k - 1], kappa[own])
            growth._pieces[: len(piece), k - 1] = piece
        return growth

    def until(self, x: float) -> Growth:
        """Return the same function up to x, with a last stage there."""
        kept = int(np.searchsorted(self.x, x - 1e-12))
        part = Growth.__new__(Growth)
        part.x, part.kappa = self.x[:kept], self.kappa[:kept]
        part.through, part._pieces = self.through[:kept], self._pieces[:, : kept - 1]
        part.first = kept + 1 - int(self.through[kept])
        return part.with_stage(x, float(self(np.array([x]))[0]))

    def restart(self) -> None:
        """Start the next polynomials at the last stage, where the tension has a kink."""
        self.first = self.x.size - 1

    def _last_stages(self) -> slice:
        return slice(max(self.first, self.x.size - ORDER), None)

    def extrapolate(self, x: float) -> float:
        """Extrapolate kappa to x by the polynomial through the last stages."""
        own = self._last_stages()
        return _through(self.x[own] - x, self.kappa[own])[0]

    def lagrange_basis(self, surface: float, x: Array) -> Array:
        """Return the derivative of kappa at x by that of a further stage at ``surface``."""
        basis = np.where(x > self.x[-1], 1.0, 0.0)
        for stage in self.x[self._last_stages()]:
            basis *= (x - stage) / (surface - stage)
        return basis

    def with_stage(self, x: float, kappa: float) -> Growth:
        """Return a copy with one more stage."""
        more, own = Growth.__new__(Growth), self._last_stages()
        more.x, more.kappa = np.append(self.x, x), np.append(self.kappa, kappa)
        more.first = self.first
        more.through = np.append(self.through, more.x.size - own.start)
        c = np.zeros((ORDER + 1, 1))
        piece = _through(more.x[own.start :] - self.x[-1], more.kappa[own.start :])
        c[: len(piece), 0] = piece
        more._pieces = np.hstack([self._pieces, c])
        return more

    def interpolation_error(self, x: Array) -> Array:
        """Estimate the interpolation error of kappa by polynomials of one degree more.

        These interpolate a following stage in addition, or a previous one if none follows.
        """
        errors, k = np.zeros(x.size), np.searchsorted(self.x, x, side="left")
        for j in range(1, self.x.size):
            at, start = k == j, j + 1 - int(self.through[j])
            more = self._stage_after(j) or start - 1
            if more < 0 or not at.any():
                continue
            own = [*range(start, j + 1), more]
            highest = _through(self.x[own] - self.x[j], self.kappa[own])[-1]
            errors[at] = highest * np.prod(x[at, None] - self.x[own[:-1]], axis=1)
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


def _through(x: Array, y: Array) -> list[float]:
    """Return the ascending coefficients of the polynomial through a few points."""
    at, divided = x.tolist(), y.tolist()
    for k in range(1, len(at)):
        for j in range(len(at) - 1, k - 1, -1):
            divided[j] = (divided[j] - divided[j - 1]) / (at[j] - at[j - k])
    c = [divided[-1]]
    for k in range(len(at) - 2, -1, -1):  # times (x - x_k), and the next difference
        times = (a - at[k] * b for a, b in zip(c, [*c[1:], 0.0], strict=True))
        c = [divided[k] - at[k] * c[0], *times]
    return c
