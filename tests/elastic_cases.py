"""Stiffnesses and whole kernels, for the tests of influence functions."""

from __future__ import annotations

import numpy as np

from woundon.elasticity.kernels import Kernel

__all__ = ["Stiffness", "isotropic", "whole"]

Stiffness = tuple[float, float, float, float]  # A_rr, A_tt, A_rt, G


def isotropic(E: float, nu: float) -> Stiffness:
    """Return A_rr, A_tt, A_rt, G of plane strain."""
    direct = E * (1 - nu) / ((1 + nu) * (1 - 2 * nu))
    return direct, direct, direct * nu / (1 - nu), E / (2 * (1 + nu))


def whole(kernel: Kernel, t: np.ndarray) -> np.ndarray:
    """Return the kernel with its singular parts, away from t = 0."""
    assert kernel.smooth is not None
    near = kernel.inverse / t + kernel.log * np.log(np.abs(t)) + kernel.sign * np.sign(t)
    return near + kernel.smooth(t)
