"""Surfaces between half widths at which they were computed: exact there, linear in ln a between."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import woundon as wo
from woundon.elasticity.mesh import Wrap, nip_mesh
from woundon.elasticity.surface import SurfacesByHalfWidth

FACE = nip_mesh(13, Wrap(), Wrap()).roll_face
ELASTIC, RIGID = wo.RollerProblem.example().upper, wo.Rigid(radius=0.2)
P = np.sqrt(np.clip(1 - FACE.nodes**2, 0, None))


def computed(a: float, faces: Any) -> Any:
    pairs = zip((ELASTIC, RIGID), faces, strict=True)
    return tuple(body.surface(face, a, None) for body, face in pairs)


def slope(surfaces: SurfacesByHalfWidth, a: float, tolerance: float) -> np.ndarray:
    return surfaces.at(a, (FACE, FACE), tolerance)[0].deform(P, 0 * P).slope


@pytest.mark.parametrize("factor", [1.01, 1.05])
def test_the_error_is_below_the_tolerance_and_of_second_order(factor: float) -> None:
    a, surfaces = 1e-3, SurfacesByHalfWidth(computed, linear=True)
    one, two = slope(surfaces, a, 0.0), slope(surfaces, factor * a, 0.0)
    middle = a * factor**0.5
    between = slope(surfaces, middle, np.inf)
    np.testing.assert_allclose(between, (one + two) / 2, rtol=1e-12)
    exact = slope(SurfacesByHalfWidth(computed, linear=True), middle, 0.0)
    estimate = (np.log(factor) / 2) ** 2 / 2
    assert np.abs(between - exact).max() <= estimate * np.abs(exact).max()
    # a smaller tolerance than the estimate computes the surface; a larger one does not
    assert np.array_equal(slope(surfaces, middle, 1.01 * estimate), between)
    np.testing.assert_allclose(slope(surfaces, middle, 0.99 * estimate), exact, rtol=1e-14)


def test_nonlinear_bodies_are_not_interpolated() -> None:
    counted = []

    def count(a: float, faces: Any) -> Any:
        counted.append(a)
        return computed(a, faces)

    surfaces = SurfacesByHalfWidth(count, linear=False)
    for a in (1e-3, 1.01e-3, 1.005e-3, 1.005e-3):
        surfaces.at(a, (FACE, FACE), 1.0)
    assert counted == [1e-3, 1.01e-3, 1.005e-3]  # the same half width is not computed again
