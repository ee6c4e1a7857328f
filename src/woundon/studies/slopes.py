"""Derivatives of residuals, mended by what steps tell, and made anew where that is far off."""

from __future__ import annotations

import numpy as np

from .predict import Predictor

__all__ = ["ASTRAY", "Slopes", "best_step", "mended"]

Array = np.ndarray

ASTRAY = 0.3  # of the change of residuals that was not foreseen, from where they are made anew


def mended(J: Array, step: Array, rise: Array) -> Array | None:
    """Return derivatives by Broyden's formula; None where what they foresaw was far off."""
    miss = rise - J @ step
    if np.linalg.norm(miss) > ASTRAY * np.linalg.norm(rise):
        return None
    return np.asarray(J + np.outer(miss, step) / (step @ step))


def best_step(r: Array, J: Array, u: Array, low: Array, high: Array) -> tuple[Array, float]:
    """Return where the linear model about u has its least S within bounds, and what that gains."""
    from scipy.optimize import lsq_linear

    step = np.linalg.lstsq(J, -r, rcond=None)[0]
    if np.any(u + step < low) or np.any(u + step > high):
        inside = np.clip(u, low, high)
        step = lsq_linear(J, -r, (low - inside - 1e-12, high - inside + 1e-12)).x
    there = np.clip(u + step, low, high)
    left = r + J @ (there - u)
    return there, float(r @ r - left @ left)


class Slopes:
    """u -> derivatives of the residuals, from one place asked for to the next."""

    def __init__(self, predictor: Predictor) -> None:
        self.predictor = predictor
        self.last: tuple[Array, Array, Array] | None = None
        self.are_mended = False

    def __call__(self, u: Array) -> Array:
        """Return them, (m, p)."""
        if self.last is None:
            return self.anew(u)
        before, r_before, J_before = self.last
        r = self.predictor.residuals(u)
        J = mended(J_before, u - before, r - r_before)
        if J is None:
            return self.anew(u)
        self.last, self.are_mended = (u.copy(), r, J), True
        return J

    def anew(self, u: Array) -> Array:
        """Return them as the predictor has them."""
        J = self.predictor.jacobian(u)
        self.last, self.are_mended = (u.copy(), self.predictor.residuals(u), J), False
        return J
