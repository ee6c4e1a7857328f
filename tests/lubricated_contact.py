"""A whole lubricated contact by finite volumes: nothing of its inlet's asymptotics."""

from __future__ import annotations

from collections.abc import Callable
from math import pi

import numpy as np

Array = np.ndarray

MU, AMBIENT = 1.81e-5, 101325.0


def sinks(x: Array) -> Array:
    """What pressures, constant on cells, open a gap by in their middles: -(2/pi) int p ln|s - t|.

    Times the half sum C of the compliances of two elastic half-planes.
    """
    at = (x[1:] + x[:-1]) / 2
    left, right = (
        (at[:, None] - s) * (np.log(np.abs(at[:, None] - s)) - 1) for s in (x[:-1], x[1:])
    )
    return np.asarray(-2 / pi * (left - right))


def second_derivative(x: Array) -> Array:
    """Second differences on uneven points; none at the ends."""
    before, after, k = np.diff(x)[:-1], np.diff(x)[1:], np.arange(1, x.size - 1)
    out = np.zeros((x.size, x.size))
    out[k, k - 1] = 2 / (before * (before + after))
    out[k, k + 1] = 2 / (after * (before + after))
    out[k, k] = -2 / (before * after)
    return out


def passing_film(
    R: float, P: float, V: float, a: float, film: float, gives: Callable[[Array], Array],
    middle: float = 0.0, cells: int = 400,
) -> float:  # fmt: skip
    """Return the film that passes a contact of the curvature 1/R under P, at ambient pressure.

    Air compressible and isothermal, pressures constant on cells that are fine at both edges.

    Parameters
    ----------
    a, middle : float
        Half width of the dry contact and its centre, along +x from the line of centres [m].
    film : float
        To begin with [m].
    gives : callable
        Sides of the cells (n + 1,) -> what their pressures open the gap by (n, n).
    """
    quarter = cells // 4
    fine = np.sinh(np.linspace(0, 1, quarter + 1) * 6) / np.sinh(6)
    edges = [-a - 6 * a * fine[::-1], -a + a * fine[1:-1], (a - a * fine)[::-1], a + 3 * a * fine]
    x = np.unique(np.concatenate(edges)) + middle
    at, wide, apart = (x[1:] + x[:-1]) / 2, np.diff(x), np.diff((x[1:] + x[:-1]) / 2)
    opened, n, peak = gives(x), at.size, 2 * P / pi / a
    inside = np.abs(at - middle) < a
    p = peak * np.sqrt(np.clip(1 - ((at - middle) / a) ** 2, 1e-8, None))
    bend, unit = at**2 / 2 / R, AMBIENT * V * film
    unknown = np.append(p, 2 * film - np.min((bend + opened @ p)[inside]))
    by_gap = np.hstack([opened, np.ones((n, 1))])
    mean, cell = (by_gap[1:] + by_gap[:-1]) / 2, np.arange(n - 1)

    def flows(unknown: Array) -> tuple[Array, Array, Array]:
        p, h = unknown[:-1], by_gap @ unknown + bend
        pm, hm, rise = AMBIENT + (p[1:] + p[:-1]) / 2, (h[1:] + h[:-1]) / 2, np.diff(p) / apart
        speed = V * hm - hm**3 * rise / 12 / MU
        by = (pm * (V - 3 * hm**2 * rise / 12 / MU))[:, None] * mean
        drag = pm * hm**3 / 12 / MU / apart
        by[cell, cell] += speed / 2 + drag
        by[cell, cell + 1] += speed / 2 - drag
        return h, pm * speed, by

    for _ in range(100):
        h, flow, by = flows(unknown)
        # far outside the air is at rest with the surfaces: p = 0 in the last cell of both ends
        miss = np.concatenate([
            [unknown[0] / peak], np.diff(flow) / unit,
            [unknown[n - 1] / peak, wide @ unknown[:-1] / P - 1],
        ])  # fmt: skip
        jacobian = np.zeros((n + 1, n + 1))
        jacobian[0, 0] = jacobian[n - 1, n - 1] = 1 / peak
        jacobian[1 : n - 1] = np.diff(by, axis=0) / unit
        jacobian[n, :-1] = wide / P
        step = np.linalg.solve(jacobian, -miss)
        falls = -(by_gap @ step)
        share = min(1.0, 0.5 * float(np.min(np.where(falls > 0, h / np.abs(falls), np.inf))))
        unknown = unknown + share * step
        if share == 1 and np.max(np.abs(step[:-1])) < 1e-8 * peak:
            return float(flows(unknown)[1][n // 2]) / V / AMBIENT
    raise AssertionError("the lubricated contact was not found")
