"""Beams across a web: closed forms, an independent program, convergence, many lanes."""

from __future__ import annotations

from math import cos, cosh, inf, sin, sinh

import numpy as np
import pytest
from scipy.integrate import solve_bvp

from woundon.elasticity.beam import Beam, BeamsAcross

EI, W, LOAD = 2e5, 2.5, 3000.0
SHEAR = 4e7  # a drum of about a tenth of its length in radius


def across(*beams, lanes=40, places=(0.0, W / 2, W)):
    return BeamsAcross(beams, np.full(lanes, W / lanes), np.array(places))


def uniform(lanes=40, beams=1):
    return np.full((lanes, beams, 1), LOAD)


@pytest.mark.parametrize("shear", [inf, SHEAR])
@pytest.mark.parametrize("lanes", [1, 7, 1000])
def test_a_uniform_load(lanes, shear):
    """Closed form: 5 q L^4/(384 EI), and q L^2/(8 S) by shear, in the middle; zero at the ends.

    The mean over the width is q L^4/(120 EI) + q L^2/(12 S).
    """
    deflection = across(Beam(EI, 0.0, shear), lanes=lanes).deflection(uniform(lanes))
    means, w = np.split(deflection, [lanes])
    mean = LOAD * W**4 / (120 * EI) + LOAD * W**2 / (12 * shear)
    assert means.mean() == pytest.approx(mean, rel=1e-10)
    w = w[:, 0, 0]
    middle = 5 * LOAD * W**4 / (384 * EI) + LOAD * W**2 / (8 * shear)
    # exact up to rounding, with any number of lanes
    assert w[1] == pytest.approx(middle, rel=1e-10)
    assert w[[0, 2]] == pytest.approx([0, 0], abs=1e-10 * middle)


def test_bearings_beyond_the_edges():
    """Closed form: q W^3 (b/16 + 5 W/384)/EI in the middle above the edges of the web."""
    b = 0.4
    edge, middle, other = across(Beam(EI, b)).deflection(uniform())[40:, 0, 0]
    sag = LOAD * W**3 * (b / 16 + 5 * W / 384) / EI
    assert middle - edge == pytest.approx(sag, rel=1e-10)
    assert other == pytest.approx(edge, rel=1e-10)
    # slope at the edge times b, and the bending of the cantilever under the reaction q W/2
    turned, bent = b * (W**3 / 24 + b * W**2 / 4), W * b**3 / 6
    assert edge == pytest.approx(LOAD * (turned + bent) / EI, rel=1e-10)


def test_a_uniform_load_on_a_foundation():
    """Closed form (Hetenyi 1946): both ends hinged, lambda^4 = k/4 EI; also of the lane means."""
    k = 2e6
    u = (k / (4 * EI)) ** 0.25 * W / 2
    A, B = (f / ((cosh(u) * cos(u)) ** 2 + (sinh(u) * sin(u)) ** 2) for f in
            (cosh(u) * cos(u), sinh(u) * sin(u)))  # fmt: skip
    middle = LOAD / k * (1 - A)
    errors = []
    for lanes in (10, 20, 40):
        stiffness = np.full((lanes, 1, 1), k)
        w = across(Beam(EI), lanes=lanes).on_foundation(stiffness, uniform(lanes))[lanes + 1, 0, 0]
        errors.append(abs(w / middle - 1))
        s = np.linspace(-u, u, 20 * lanes + 1)
        closed = LOAD / k * (1 - A * np.cosh(s) * np.cos(s) - B * np.sinh(s) * np.sin(s))
    # the foundation acts on the mean deflection of a lane: of order two in its width
    assert errors[1] == pytest.approx(errors[0] / 4, rel=0.1)
    assert errors[2] == pytest.approx(errors[1] / 4, rel=0.1)
    assert errors[2] < 1e-3
    assert closed.max() <= LOAD / k * 1.2


@pytest.mark.parametrize("shear", [inf, SHEAR])
def test_an_uneven_load_on_an_uneven_foundation(shear):
    """Independent program: collocation (scipy.integrate.solve_bvp) of the same equations."""
    b, lanes = 0.3, 400
    y = (np.arange(lanes) + 0.5) * W / lanes

    def load(y):
        return LOAD * (1 + 0.5 * np.sin(5 * y))

    def stiffness(y):
        return 1e6 * (1.5 + np.cos(4 * y))

    def slopes(y, z):
        w, psi, M, Q = z
        return np.array([psi - Q / shear, M / EI, Q, load(y) - stiffness(y) * w])

    def at_ends(left, right):
        """Cantilevers of the length b from the edges of the web to the bearings."""
        conditions = []
        for side, (w, psi, M, Q) in ((1, left), (-1, right)):
            beyond = Q * b**3 / (3 * EI) + Q * b / shear
            conditions += [M - side * Q * b, w - side * (psi * b - beyond)]
        return np.array(conditions)

    mesh = np.linspace(0, W, 200)
    solved = solve_bvp(slopes, at_ends, mesh, np.zeros((4, mesh.size)), tol=1e-8, max_nodes=100_000)
    assert solved.success
    w = across(Beam(EI, b, shear), lanes=lanes).on_foundation(
        stiffness(y)[:, None, None], load(y)[:, None, None]
    )[:lanes, 0, 0]
    # lanes of W/400: 1e-5; the tolerance of the collocation is 1e-8
    assert w == pytest.approx(solved.sol(y)[0], abs=5e-5 * np.abs(w).max())


def test_two_beams_pressed_together():
    """Invariance: drum and core yield together as one beam of 1/EI = 1/EI_1 + 1/EI_2."""
    k, lanes = 2e6, 30
    y = (np.arange(lanes) + 0.5) / lanes
    load = (LOAD * (1 + 0.3 * np.cos(3 * y)))[:, None, None]
    two = across(Beam(EI), Beam(3 * EI), lanes=lanes).on_foundation(
        np.full((lanes, 2, 2), k), np.tile(load, (1, 2, 1))
    )
    one = across(Beam(0.75 * EI), lanes=lanes).on_foundation(np.full((lanes, 1, 1), k), load)
    assert two.sum(axis=1) == pytest.approx(one[:, 0], rel=1e-10, abs=1e-12)
    assert two[:lanes, 0] == pytest.approx(3 * two[:lanes, 1], rel=1e-10)


def test_the_foundation_is_in_balance():
    """Conservation: the deflection is that under the load that the foundation leaves."""
    rng, lanes = np.random.default_rng(1), 25
    widths = rng.uniform(0.5, 1.5, lanes) * W / lanes
    beams = BeamsAcross([Beam(EI, 0.2), Beam(1e3, 0.0, 1e6)], widths, np.array([0.1, 1.0]))
    stiffness = rng.uniform(0, 1e7, (lanes, 2, 2))
    load = rng.uniform(-1, 1, (lanes, 2, 3)) * LOAD
    w = beams.on_foundation(stiffness, load)
    left = load - stiffness @ w[:lanes]
    assert beams.deflection(left) == pytest.approx(w, rel=1e-9, abs=1e-12 * np.abs(w).max())
