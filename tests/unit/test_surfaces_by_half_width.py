"""Surfaces between half widths at which they were computed: exact there, linear in ln a between."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import woundon as wo
from woundon.elasticity.mesh import Wrap, nip_mesh
from woundon.elasticity.surface import RigidSurface, SurfacesByHalfWidth

FACE = nip_mesh(13, Wrap(), Wrap()).roll_face
# a layer about as thick as the contact: its response depends on the half width
COVER = wo.Cylinder(radius=0.1, core_radius=0.095, material=wo.material("soft-cover"))
BODIES = COVER, wo.Rigid(radius=0.2)
P = np.sqrt(np.clip(1 - FACE.nodes**2, 0, None))


def slope(surfaces: SurfacesByHalfWidth, a: float, tolerance: float) -> np.ndarray:
    return surfaces.at(a, (FACE, FACE), tolerance)[0].deform(P, 0 * P).slope


@pytest.mark.parametrize("factor", [1.01, 1.05])
def test_the_error_is_below_the_tolerance_and_of_second_order(factor: float) -> None:
    a, surfaces = 5e-3, SurfacesByHalfWidth(BODIES)
    one, two = slope(surfaces, a, 0.0), slope(surfaces, factor * a, 0.0)
    assert np.abs(two - one).max() > 0.1 * np.log(factor) * np.abs(one).max()
    middle = a * factor**0.5
    between = slope(surfaces, middle, np.inf)
    np.testing.assert_allclose(between, (one + two) / 2, rtol=1e-12)
    exact = slope(SurfacesByHalfWidth(BODIES), middle, 0.0)
    estimate = (np.log(factor) / 2) ** 2 / 2
    assert np.abs(between - exact).max() <= estimate * np.abs(exact).max()
    # a smaller tolerance than the estimate computes the surface; a larger one does not
    assert np.array_equal(slope(surfaces, middle, 1.01 * estimate), between)
    np.testing.assert_allclose(slope(surfaces, middle, 0.99 * estimate), exact, rtol=1e-14)
    assert np.abs(between - exact).max() > 1e-3 * estimate * np.abs(exact).max()  # they differ
    # at a quarter of the distance in ln a from the latest of two half widths
    surfaces = SurfacesByHalfWidth(BODIES)
    one, two = slope(surfaces, a, 0.0), slope(surfaces, factor * a, 0.0)
    quarter = slope(surfaces, a * factor**0.75, np.inf)
    np.testing.assert_allclose(quarter, two + (one - two) / 4, rtol=1e-10)


class Nonlinear:
    """A body without mechanics that counts its surfaces."""

    linear = False

    def __init__(self) -> None:
        self.half_widths: list[float] = []

    def surface(self, face: Any, half_width: float, speed: float | None) -> RigidSurface:
        self.half_widths.append(half_width)
        return RigidSurface(face)


def test_nonlinear_bodies_are_not_interpolated() -> None:
    body = Nonlinear()
    surfaces = SurfacesByHalfWidth([body])
    for a in (1e-3, 1.01e-3, 1.005e-3, 1.005e-3):
        surfaces.at(a, [FACE], 1.0)
    assert body.half_widths == [1e-3, 1.01e-3, 1.005e-3]  # the same one is not computed again
