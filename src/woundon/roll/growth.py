"""Kappa over the build-up of a roll: how a further lap's pressure grows below the surface."""

from __future__ import annotations

import numpy as np

__all__ = ["ORDER", "Growth"]

Array = np.ndarray

ORDER = 3  # of the polynomial through the last stages
NOISE = 0.5  # of a step: the least distance of a stage that tells its error


class Growth:
    """Kappa over x = ln r: polynomials through up to four stages, none across a kink.

    Parameters
    ----------
    x, kappa : float
        Of the core, where a roll begins.

    Attributes
    ----------
    x, kappa : (J,) arrays
        The stages.
    through : (J,) int array
        How many stages the polynomial that ends at each goes through.
    """

    def __init__(self, x: float, kappa: float) -> None:
        self.x, self.kappa = np.array([x]), np.array([kappa])
        self.through = np.array([1])
        self.first = 0  # the stage behind which no polynomial reaches
        self._pieces = np.zeros((ORDER + 1, 0))

    @classmethod
    def of(cls, x: Array, kappa: Array, through: Array) -> Growth:
        """Return that of given stages; see the attributes."""
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
        """Return the same up to x, a last stage there."""
        kept = int(np.searchsorted(self.x, x - 1e-12))
        part = Growth.__new__(Growth)
        part.x, part.kappa = self.x[:kept], self.kappa[:kept]
        part.through, part._pieces = self.through[:kept], self._pieces[:, : kept - 1]
        part.first = kept + 1 - int(self.through[kept])
        return part.then(x, float(self(np.array([x]))[0]))

    def restart(self) -> None:
        """Draw no polynomial across the last stage: there the tension has a kink."""
        self.first = self.x.size - 1

    def _behind(self) -> slice:
        return slice(max(self.first, self.x.size - ORDER), None)

    def extrapolated(self, x: float) -> float:
        """Return what the polynomial through the last stages says of the next one."""
        own = self._behind()
        return _through(self.x[own] - x, self.kappa[own])[0]

    def share(self, surface: float, x: Array) -> Array:
        """Return how kappa at any x follows that of a further stage at ``surface``: 0 to 1."""
        share = np.where(x > self.x[-1], 1.0, 0.0)
        for stage in self.x[self._behind()]:
            share *= (x - stage) / (surface - stage)
        return share

    def then(self, x: float, kappa: float) -> Growth:
        """Return this with one more stage."""
        more, own = Growth.__new__(Growth), self._behind()
        more.x, more.kappa = np.append(self.x, x), np.append(self.kappa, kappa)
        more.first = self.first
        more.through = np.append(self.through, more.x.size - own.start)
        c = np.zeros((ORDER + 1, 1))
        piece = _through(more.x[own.start :] - self.x[-1], more.kappa[own.start :])
        c[: len(piece), 0] = piece
        more._pieces = np.hstack([self._pieces, c])
        return more

    def missed(self, x: Array) -> Array:
        """Return by how much kappa misses the next higher polynomials, which tells its error.

        They go through a stage that follows too, or one more behind where none does.
        """
        missed, k = np.zeros(x.size), np.searchsorted(self.x, x, side="left")
        for j in range(1, self.x.size):
            at, start = k == j, j + 1 - int(self.through[j])
            more = self._stage_after(j) or start - 1
            if more < 0 or not at.any():
                continue
            own = [*range(start, j + 1), more]
            highest = _through(self.x[own] - self.x[j], self.kappa[own])[-1]
            missed[at] = highest * np.prod(x[at, None] - self.x[own[:-1]], axis=1)
        return missed

    def _stage_after(self, j: int) -> int:
        """Return a stage before the next kink, not so near j that it tells noise; 0 if none."""
        for k in range(j + 1, self.x.size):
            if self.through[k] == 2:
                return 0
            if self.x[k] - self.x[j] > NOISE * (self.x[j] - self.x[j - 1]):
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
