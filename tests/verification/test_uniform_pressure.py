"""The surface strain of rolls under a uniform pressure, by which wraps are closed."""

from __future__ import annotations

from functools import cache
from math import pi, sqrt

import numpy as np
import pytest
from hardening_cases import nip, roll
from slow_cases import slow_case

import woundon as wo
from woundon.elasticity.ring_elements import Fineness
from woundon.problems.wound_roll import ring_of

NEWSPRINT = wo.material("newsprint")
RUBBER = wo.Isotropic(youngs_modulus=20e6, poissons_ratio=0.4)
SOFT_SURFACE = wo.Profile(radius=[0.05, 0.099, 0.1], value=[2e5, 2e5, 0.0])


def ring_strain(R: float, R0: float, A_rr: float, A_tt: float, A_rt: float) -> float:
    """v(R)/R per unit pressure of a homogeneous ring on a rigid core.

    v = (r/R)^m - t^2m (r/R)^-m with m^2 = A_tt/A_rr is zero at R0 = t R.
    """
    m, t = sqrt(A_tt / A_rr), R0 / R
    return -1 / (A_rr * m * (1 + t ** (2 * m)) / (1 - t ** (2 * m)) + A_rt)


@pytest.mark.parametrize("core_radius", [0.02, 0.08, 0.0985])
@pytest.mark.parametrize("material", [NEWSPRINT, RUBBER], ids=["newsprint", "rubber"])
def test_a_homogeneous_cylinder_is_the_closed_form(material, core_radius: float) -> None:
    body = wo.Cylinder(radius=0.1, core_radius=core_radius, material=material)
    expected = ring_strain(0.1, core_radius, *material.stiffness[:3])
    assert body.uniform_strain(1e4) == pytest.approx(1e4 * expected, rel=1e-9)  # rounding


def test_a_thin_cover_on_a_stiff_shell_is_compressed_layer_by_layer() -> None:
    shell = wo.Isotropic(youngs_modulus=200e9, poissons_ratio=0.3)
    layers = [wo.Layer(thickness=1e-4, material=RUBBER), wo.Layer(thickness=0.02, material=shell)]
    drum = wo.Layered(radius=0.1, layers=layers)
    compressed = sum(1e4 * layer.thickness / layer.material.stiffness[0] for layer in layers)
    # the shell takes 3 % of it, and curvature changes its part by a tenth
    assert drum.uniform_strain(1e4) == pytest.approx(-compressed / 0.1, rel=0.005)


def test_small_pressures_on_a_graded_roll_meet_its_linearisation() -> None:
    """The equations of the ring, solved directly, against the harmonic n = 0 of many layers."""
    stack = wo.Stack(
        radial=wo.Pfeiffer(K1=1e4, K2=40.0), tangential=3.38e9, poissons_ratio=0.01, shear=1e7
    )
    hardening = wo.WoundRoll(radius=0.1, core_radius=0.05, stack=stack, pressure=SOFT_SURFACE)
    frozen = hardening.replace(hardening="frozen")
    # tolerance of the differential equations 1e-5; the layers of the kernels are as accurate
    assert hardening.uniform_strain(1.0) == pytest.approx(frozen.uniform_strain(1.0), rel=1e-4)
    # the layers at the surface harden
    assert abs(hardening.uniform_strain(1e4)) < 0.96 * abs(frozen.uniform_strain(1e4))


def test_a_hardening_ring_agrees_with_its_finite_elements() -> None:
    body, p = roll(P0=20e3), 15e3
    ring = ring_of(body)
    mesh = ring.mesh(Fineness(8, 8, 24), 2e-3)
    inward = mesh.hat_forces(np.linspace(-pi * body.radius, pi * body.radius, 400)).sum(axis=1)
    state = ring.equilibrium(mesh, np.stack([-p * inward, 0 * inward]))
    by_elements = state.u[mesh.topology.surface][0].mean() / body.radius
    # the elements of the same ring are accurate to 3e-5 (tests of the rings)
    assert body.uniform_strain(p) == pytest.approx(by_elements, rel=1e-4)


@cache
def wrapped(hardening: str) -> wo.NipResult:
    stack = wo.Stack(
        radial=wo.Pfeiffer(K1=10e3, K2=40.0), tangential=3.38e9, poissons_ratio=0.01, shear=1e7
    )
    body = wo.WoundRoll(
        radius=0.1, core_radius=0.05, stack=stack, pressure=SOFT_SURFACE, hardening=hardening
    )
    problem = nip(body, nip_load=2000.0, winding_force=100.0).replace(roll_wrap=pi)
    return wo.solve(problem, nodes=65)


@pytest.mark.filterwarnings("ignore::woundon.ValidityWarning", "ignore::woundon.ResolutionWarning")
@pytest.mark.parametrize("hardening", [slow_case("direct"), "frozen"])
def test_the_closed_tension_is_the_same_at_every_angle_of_the_wrap(hardening: str) -> None:
    """WOT reduced to a closed layer follows from tension and strain at any angle of the wrap."""
    result = wrapped(hardening)
    web, R = result.problem.web, result.problem.roll.radius
    angles = np.array([0.8, 1.2, 1.6, 2.0, 2.4])
    T = np.interp(angles * R, result.x, result.tension)
    strain = np.interp(angles * R, result.x, result.roll_strain)
    closed = np.array([result.problem.roll.uniform_strain(t / R) for t in T.tolist()])
    reduced = T + web.thickness / web.compliance.c11 * (closed - strain)
    # measured 0.3 %: the mesh is coarse between the nip and the end of the wrap
    assert reduced == pytest.approx(result.roll_wound_on_tension, rel=0.005)
