"""Random layered and graded nips: load limits, guesses and responses of thin and bending layers."""

from __future__ import annotations

import numpy as np
import pytest
from random_nips import random_layered

import woundon as wo
from woundon.elasticity.influence import RANK_FACTOR
from woundon.elasticity.mesh import Wrap, nip_mesh
from woundon.nip import load_limit
from woundon.nip.load_limit import frictionless_half_width, largest_load
from woundon.problems.bodies import half_width_guess


@pytest.mark.parametrize("seed", [34, 30002, 30069, 30137])
def test_the_load_limit_of_a_tube_does_not_depend_on_the_mesh(
    seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The surfaces separate near the load that bends a thin ring off the other body."""
    problem = random_layered(seed)
    assert problem.nip_load > (coarse := largest_load(problem, problem.nip_load))
    monkeypatch.setattr(load_limit, "NODES", 65)
    assert largest_load(problem, problem.nip_load) == pytest.approx(coarse, rel=0.05)
    assert coarse == pytest.approx(problem.drum.bending_load(problem.contact_radius), rel=0.15)


def test_the_half_width_of_a_wide_contact_is_guessed() -> None:
    problem = random_layered(50459)
    hertz = half_width_guess(problem.nip_load, *problem.bodies)
    guess = frictionless_half_width(problem, problem.nip_load, hertz, problem.drum.radius)
    solved = wo.solve(problem, nodes=33).half_width
    assert hertz < solved / 30
    assert guess == pytest.approx(solved, rel=0.3)


def test_the_response_of_a_thin_coating_is_continuous() -> None:
    """The degree of the polynomials increases with the half width by whole numbers."""
    problem = random_layered(30370)
    kernels = problem.drum.kernels()
    face = nip_mesh(45, Wrap(), Wrap()).drum_face
    for degree in (99.5, 199.5):
        a = kernels.length / np.sinh(RANK_FACTOR / degree)
        narrow, wide = (problem.drum.surface(face, a * (1 + d)) for d in (-1e-9, 1e-9))
        assert wide._rank == narrow._rank + 1
        q = 1 - face.nodes**2
        slopes = [surface.deform(0 * q, q).slope for surface in (narrow, wide)]
        np.testing.assert_allclose(*slopes, rtol=0, atol=1e-4 * np.abs(slopes[0]).max())
