"""Derivatives of residuals, mended by what steps tell, and made anew where that is far off."""

from __future__ import annotations

import numpy as np

from .predict import Predictor

__all__ = ["Slopes", "mended"]

Array = np.ndarray

ASTRAY = 0.3  # of the change of residuals that was not foreseen, from where they are made anew


def mended(J: Array, step: Array, rise: Array) -> Array | None:
    """Return derivatives by Broyden's formula; None where what they foresaw was far off."""
    miss = rise - J @ step
    if np.linalg.norm(miss) > ASTRAY * np.linalg.norm(rise):
        return None
    return np.asarray(J + np.outer(miss, step) / (step @ step))


class Slopes:
    """u -> derivatives of the residuals, from one place asked for to the next."""

    def __init__(self, predictor: Predictor) -> None:
        self.predictor = predictor
        self.last: tuple[Array, Array, Array] | None = None

    def __call__(self, u: Array) -> Array:
        """Return them, (m, p)."""
        r, J = self.predictor.residuals(u), None
        if self.last is not None:
            before, r_before, J_before = self.last
            J = mended(J_before, u - before, r - r_before)
        if J is None:
            J = self.predictor.jacobian(u)
        self.last = u.copy(), r, J
        return J
