"""The half-plane and the strip against isotropic textbook values and their own equations."""

from __future__ import annotations

from math import pi, sqrt

import pytest
from elastic_cases import isotropic
from hypothesis import given
from hypothesis import strategies as st

from woundon.elasticity import half_plane, strip

PAPER = (20e6, 3e9, 5e6, 10e6)
modulus = st.floats(1e5, 1e11)


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.45, 0.499, 0.49999])
def test_isotropic_half_plane(nu: float) -> None:
    """A = (1-2nu)(1+nu)/E and B = C = 2(1-nu^2)/E (Johnson 1985, sec. 2.4)."""
    E = 10e6
    A, B, C = half_plane.coefficients(*isotropic(E, nu))
    # the stiffness itself holds 1 - 2 nu to a relative 1e-16/(1 - 2 nu)
    exact = 1e-15 / (1 - 2 * nu)
    assert pytest.approx((1 - 2 * nu) * (1 + nu) / E, rel=max(exact, 1e-14)) == A
    assert pytest.approx(2 * (1 - nu**2) / E, rel=max(exact, 1e-14)) == B
    assert pytest.approx(2 * (1 - nu**2) / E, rel=max(exact, 1e-14)) == C


@given(A_rr=modulus, A_tt=modulus, share=st.floats(0, 0.999), G=modulus)
def test_coefficients_solve_their_equations(
    A_rr: float, A_tt: float, share: float, G: float
) -> None:
    """[[C, A], [A, B]] solves the Riccati equation of a wave on the half-plane.

    With a = A_rt/A_rr and D = A_tt - A_rt^2/A_rr the three components are
    1/A_rr = 2 a A + D A^2, 1/G = D B^2 - 2 A and C = a B + D A B: no root of (27) is used.
    """
    A_rt = share * sqrt(A_rr * A_tt)
    A, B, C = half_plane.coefficients(A_rr, A_tt, A_rt, G)
    a, D = A_rt / A_rr, A_tt - A_rt**2 / A_rr
    # D carries a cancellation of 1/(1 - share^2) <= 500 units of rounding, the sums as much
    assert (2 * a + D * A) * A * A_rr == pytest.approx(1, rel=1e-11)
    shear = D * B**2 / (1 / G + 2 * A)
    assert shear == pytest.approx(1, rel=1e-11)
    assert (a + D * A) * B == pytest.approx(C, rel=1e-11)


def test_half_plane_kernels() -> None:
    """The kernels carry eq. (32): logarithms, steps and their derivatives, nothing smooth."""
    A, B, C = half_plane.coefficients(*PAPER)
    k = half_plane.surface_kernels(*PAPER)
    assert k.normal_p.log == k.slope_p.inverse == C / pi
    assert k.tangent_q.log == k.strain_q.inverse == -B / pi
    assert k.normal_q.sign == k.tangent_p.sign == -A / 2
    assert k.slope_q.delta == k.strain_p.delta == -A
    assert all(getattr(k, name).smooth is None for name in ("normal_p", "slope_q", "strain_q"))


def test_strip_compliance_inverts_the_stiffness() -> None:
    """Compliance times stiffness is one; pressure strains an isotropic strip by nu(1+nu)p/E."""
    A_rr, A_tt, A_rt, _ = PAPER
    c11, c12, c22 = strip.compliance(A_rr, A_tt, A_rt)
    assert c11 * A_tt + c12 * A_rt == pytest.approx(1, rel=1e-15)
    assert c12 * A_tt + c22 * A_rt == pytest.approx(0, abs=1e-15)
    assert c12 * A_rt + c22 * A_rr == pytest.approx(1, rel=1e-15)
    E, nu = 4e9, 0.3
    soft = strip.compliance(*isotropic(E, nu)[:3])
    assert -soft.c12 == pytest.approx(nu * (1 + nu) / E, rel=1e-14)
