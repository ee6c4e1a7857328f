"""The rival theories against published numbers, hand-derived limits and their own equations.

The numbers marked "reference" are published closed-form values or were computed independently of
this program; the integral equations are evaluated by adaptive quadrature (QUADPACK).
"""

from __future__ import annotations

from itertools import pairwise
from math import asin, atanh, exp, log, pi, sqrt
from typing import Any

import numpy as np
import pytest
import thesis_cases
from roller_cases import dissimilar_pair, steel_pair
from scipy.integrate import quad

import woundon as wo
from woundon import theories

PAPER = wo.material("paper")


def paper_nip(**fields: Any) -> wo.NipProblem:
    """Return the nip of Table 1 with a half-plane for a roll."""
    return thesis_cases.paper_nip(**{"roll": wo.HalfPlane(radius=0.3, material=PAPER)} | fields)


def integral(f: Any, a: float, kinks: tuple[float, ...] = ()) -> float:
    """Integrate f over [-a, a]; x = a sin(phi) removes the edges' roots, kinks split the range."""
    ends = sorted({-pi / 2, *(asin(np.clip(x / a, -1, 1)) for x in kinks), pi / 2})
    g = lambda phi: float(f(a * np.sin(phi))) * a * np.cos(phi)  # noqa: E731
    scale = max(abs(g(phi)) for phi in (-1.0, -0.4, 0.3, 1.1))
    options: Any = {"epsabs": 1e-11 * scale, "epsrel": 1e-11, "limit": 200}
    return sum(quad(g, lo, hi, **options)[0] for lo, hi in pairwise(ends))


def cauchy(f: Any, a: float, y: float, kinks: tuple[float, ...] = ()) -> float:
    """Return the principal value of int f(s)/(y - s) ds over [-a, a], its pole subtracted."""
    at_pole = float(f(y))
    rest = integral(lambda s: (float(f(s)) - at_pole) / (y - s), a, (*kinks, y))
    return rest + at_pole * log((a + y) / (a - y))


# ---- Hertz -----------------------------------------------------------------------------------


def test_hertz_of_equal_steel_rollers_has_the_reference_width_and_peak() -> None:
    contact = theories.hertz(steel_pair())
    # the reference gives 6 and 7 digits
    assert contact.half_width == pytest.approx(0.353759e-3, rel=2e-6)
    assert contact.peak_pressure == pytest.approx(160.1633e6, rel=1e-6)


def test_hertz_of_isotropic_bodies_has_the_textbook_modulus() -> None:
    contact = theories.hertz(steel_pair())
    assert contact.modulus == pytest.approx(206e9 / (2 * (1 - 0.3**2)), rel=1e-13)
    assert contact.radius == pytest.approx(0.125, rel=1e-15)


def test_hertz_pressure_carries_the_load_and_vanishes_outside() -> None:
    contact = theories.hertz(steel_pair())
    a = contact.half_width
    assert integral(contact.pressure, a) == pytest.approx(89e3, rel=1e-10)
    assert contact.pressure([-1.01 * a, a, 2 * a]).tolist() == [0.0, 0.0, 0.0]
    assert contact.pressure(0.0) == contact.peak_pressure


def test_hertz_of_orthotropic_paper_satisfies_the_gap_equation() -> None:
    problem = paper_nip()
    contact = theories.hertz(problem)
    a, C = contact.half_width, 2 / contact.modulus
    for t in (-0.9, -0.3, 0.2, 0.7):
        slope = C / pi * cauchy(contact.pressure, a, t * a)
        assert slope == pytest.approx(
            t * a / contact.radius, rel=1e-8
        )  # the quadrature reaches 1e-10


def test_hertz_modulus_of_paper_against_the_thesis_equation_102() -> None:
    A_xx, A_yy, A_xy, G = 3e9, 20e6, 5e6, 10e6
    s = sqrt(A_xx * A_yy)
    # (102) as printed, which names the surface direction x
    printed = 2 * sqrt(G) * (A_yy * A_xx - A_xy**2) / sqrt(A_xx * (s + A_xy + 2 * G) * (s - A_xy))
    assert theories.hertz(paper_nip()).modulus == pytest.approx(printed, rel=1e-12)


def test_a_rigid_body_has_no_compliance_and_a_core_is_not_seen() -> None:
    half_plane = theories.hertz(paper_nip())
    cored = theories.hertz(
        paper_nip(roll=wo.Cylinder(radius=0.3, core_radius=0.05, material=PAPER))
    )
    assert cored == half_plane
    soft_drum = theories.hertz(paper_nip(drum=wo.HalfPlane(radius=0.5, material=PAPER)))
    assert soft_drum.modulus == pytest.approx(half_plane.modulus / 2, rel=1e-14)


# ---- theories of the nip-induced tension -------------------------------------------------------


def test_friction_limit_is_mu_P_in_centre_winding_and_shifts_by_F() -> None:
    assert theories.friction_limit(paper_nip(winding_force=0.0)) == pytest.approx(380.0)
    # reference: Table 1 at P = 1910, F = -500, where the whole roll side slips
    hybrid = paper_nip(nip_load=1910.0, winding_force=-500.0)
    assert theories.friction_limit(hybrid) == pytest.approx(-118.0, rel=1e-12)


def test_jalkanen_by_hand() -> None:
    web = wo.Web(thickness=1e-4, material=wo.Isotropic(youngs_modulus=3e9, poissons_ratio=0.0))
    # 3e9 * 1e-4 * 1e-3 / 0.3
    assert theories.jalkanen(paper_nip(web=web), 1e-3) == pytest.approx(1000.0, rel=1e-13)


def test_jalkanen_uses_the_plane_strain_modulus_with_free_faces() -> None:
    web = wo.Web(thickness=1e-4, material=wo.Isotropic(youngs_modulus=3e9, poissons_ratio=0.3))
    expected = 3e9 / (1 - 0.3**2) * 1e-4 * 1e-3 / 0.3
    assert theories.jalkanen(paper_nip(web=web), 1e-3) == pytest.approx(expected, rel=1e-12)


def test_dual_slip_limits_and_half() -> None:
    problem = paper_nip()
    full = 0.6 * 1900.0
    assert theories.dual_slip(problem, 0.0) == 0.0
    assert theories.dual_slip(problem, 0.5) == pytest.approx(full / 2, rel=1e-14)
    assert theories.dual_slip(problem, 1.0) == pytest.approx(full, rel=1e-14)


def test_dual_slip_is_the_printed_formula_173() -> None:
    problem, s = paper_nip(), np.array([0.03, 0.11, 0.4, 0.77])
    bracket = pi - 4 * (1 - 2 * s) * np.sqrt((1 - s) * s) - 2 * np.arcsin(1 - 2 * s)
    printed = 1900.0 / (2 * pi) * 0.6 * bracket
    np.testing.assert_allclose(theories.dual_slip(problem, s), printed, rtol=1e-12)


def test_dual_slip_is_the_friction_over_the_trailing_zone() -> None:
    problem, s = paper_nip(), 0.17
    contact = theories.hertz(problem)
    a = contact.half_width
    zone = lambda x: contact.pressure(x) if x > a * (1 - 2 * s) else 0.0  # noqa: E731
    expected = 0.6 * integral(zone, a, kinks=(a * (1 - 2 * s),))
    assert theories.dual_slip(problem, s) == pytest.approx(expected, rel=1e-9)


def test_dual_slip_grows_with_the_ratio_and_is_odd() -> None:
    s = np.linspace(-1, 1, 401)
    NIT = theories.dual_slip(paper_nip(), s)
    assert np.all(np.diff(NIT) > 0)
    np.testing.assert_allclose(NIT, -NIT[::-1], rtol=1e-12, atol=1e-12)


def test_dual_slip_of_a_short_zone_grows_as_its_length_to_three_halves() -> None:
    # p ~ sqrt(distance): NIT -> (mu+ + mu-) P 16/(3 pi) s^(3/2); 1e-6 cancels 1e-10 of the digits
    s = 1e-6
    limit = 0.6 * 1900.0 * 16 / (3 * pi) * s**1.5
    assert theories.dual_slip(paper_nip(), s) == pytest.approx(limit, rel=1e-5)


def test_capstan_by_hand() -> None:
    assert theories.capstan(100.0, 0.3, pi) == pytest.approx(100 * exp(0.3 * pi), rel=1e-15)
    there_and_back = theories.capstan(theories.capstan(100.0, 0.3, 2.0), 0.3, -2.0)
    assert there_and_back == pytest.approx(100.0, rel=1e-15)
    assert theories.capstan(1.0, 0.5, log(2) / 0.5) == pytest.approx(2.0, rel=1e-15)


# ---- Carter, Cattaneo ------------------------------------------------------------------------


def test_carter_has_the_reference_values() -> None:
    solution = theories.carter(steel_pair())
    a, c = solution.half_width, solution.stick_half_width
    # the reference gives 8 digits of each
    assert c / a == pytest.approx(0.90068638, rel=1e-8)
    assert solution.creepage == pytest.approx(1.4053224e-4, rel=1e-7)
    assert 1 - c / a == pytest.approx(0.0993136, rel=1e-6)


@pytest.mark.parametrize("motion", ["rolling", "static"])
def test_the_tractions_carry_the_tangential_load(motion: str) -> None:
    problem = steel_pair(motion=motion)
    solution = (theories.carter if motion == "rolling" else theories.cattaneo)(problem)
    a, c, d = solution.half_width, solution.stick_half_width, solution.stick_centre
    assert integral(solution.pressure, a) == pytest.approx(89e3, rel=1e-10)
    assert integral(solution.traction, a, (d - c, d + c)) == pytest.approx(8.4e3, rel=1e-9)


def test_carter_sticks_from_the_leading_edge_and_slips_at_the_trailing_one() -> None:
    solution = theories.carter(steel_pair())
    a, c = solution.half_width, solution.stick_half_width
    assert solution.stick_centre - c == pytest.approx(-a, rel=1e-14)
    x = np.linspace(-a, a, 2001)[1:-1]
    ratio = solution.traction(x) / solution.pressure(x)
    slip = x > 2 * c - a
    np.testing.assert_allclose(ratio[slip], 0.5, rtol=1e-12)
    assert np.all(ratio[~slip] < 0.5)
    assert np.all(ratio > 0)


def test_carter_satisfies_the_stick_equation_with_its_creepage() -> None:
    solution = theories.carter(steel_pair())
    a, c = solution.half_width, solution.stick_half_width
    B = 4 * (1 - 0.3**2) / 206e9
    for t in (-0.95, -0.5, 0.0, 0.6):
        strain = -B / pi * cauchy(solution.traction, a, t * a, (2 * c - a,))
        assert strain == pytest.approx(solution.creepage, rel=1e-8)  # the quadrature reaches 1e-10


def test_carter_slips_the_way_its_traction_points() -> None:
    solution = theories.carter(steel_pair())
    a, c = solution.half_width, solution.stick_half_width
    B = 4 * (1 - 0.3**2) / 206e9
    x = 0.5 * ((2 * c - a) + a)  # the middle of the slip zone
    slip = solution.creepage + B / pi * cauchy(solution.traction, a, x, (2 * c - a,))
    assert slip > 0  # the lower surface is the faster and pulls the upper along +x, as q > 0


def test_carter_in_the_rolling_direction_of_the_negative_load_is_the_mirror_in_q() -> None:
    plus, minus = (theories.carter(steel_pair(tangential_load=Q)) for Q in (8.4e3, -8.4e3))
    x = np.linspace(-1, 1, 51) * plus.half_width
    np.testing.assert_array_equal(minus.traction(x), -plus.traction(x))
    assert minus.creepage == -plus.creepage


def test_carter_load_and_creepage_are_inverse() -> None:
    by_load = theories.carter(steel_pair())
    by_creepage = theories.carter(steel_pair(tangential_load=None, creepage=by_load.creepage))
    assert by_creepage.tangential_load == pytest.approx(8.4e3, rel=1e-12)
    assert by_creepage.stick_half_width == pytest.approx(by_load.stick_half_width, rel=1e-12)


def test_carter_beyond_full_creepage_slides() -> None:
    sliding = theories.carter(steel_pair(tangential_load=None, creepage=-0.01))
    assert sliding.stick_half_width == 0.0
    assert sliding.tangential_load == pytest.approx(-0.5 * 89e3, rel=1e-14)
    x = np.linspace(-0.9, 0.9, 7) * sliding.half_width
    np.testing.assert_allclose(sliding.traction(x), -0.5 * sliding.pressure(x), rtol=1e-14)


def test_carter_of_orthotropic_rollers_scales_its_creepage_by_B_over_C() -> None:
    roller = wo.HalfPlane(radius=0.25, material=PAPER)
    pair = wo.RollerProblem(
        upper=roller, lower=roller, load=2e3, friction=0.2, tangential_load=100.0
    )
    solution = theories.carter(pair)
    B = _sum_B(PAPER)
    a, c = solution.half_width, solution.stick_half_width
    for t in (-0.8, 0.1):
        strain = -B / pi * cauchy(solution.traction, a, t * a, (2 * c - a,))
        assert strain == pytest.approx(solution.creepage, rel=1e-8)


def _sum_B(material: wo.Orthotropic | wo.Isotropic) -> float:
    from woundon.elasticity import half_plane

    return 2 * half_plane.coefficients(*material.stiffness).B


def test_cattaneo_sticks_in_the_middle_and_is_even() -> None:
    solution = theories.cattaneo(steel_pair(motion="static"))
    a, c = solution.half_width, solution.stick_half_width
    assert c / a == pytest.approx(0.90068638, rel=1e-8)
    x = np.linspace(-a, a, 999)
    np.testing.assert_allclose(solution.traction(x), solution.traction(-x), atol=1e-3)
    assert np.isnan(solution.creepage)
    # where it sticks, the tangential displacement is uniform: strain zero
    strain = cauchy(solution.traction, a, 0.4 * a, (-c, c))
    assert strain == pytest.approx(0.0, abs=1e-8 * 0.5 * solution.peak_pressure)


# ---- Bentall and Johnson -----------------------------------------------------------------------


def test_bentall_johnson_creepages_have_the_reference_values() -> None:
    pair = dissimilar_pair()
    assert theories.hertz(pair).half_width == pytest.approx(0.1e-3, rel=1e-5)
    # six digits in the reference; the soft upper roller is the faster one before strain
    assert theories.bentall_johnson_frictionless(pair) == pytest.approx(-5.26299e-4, rel=1e-5)
    stick = theories.bentall_johnson_stick(pair)
    assert stick.creepage == pytest.approx(-3.67269e-4, rel=1e-5)
    assert stick.pressure(0.0) == pytest.approx(103.788e6, rel=1e-5)


def test_the_frictionless_slip_reverses_where_it_halves_the_load() -> None:
    pair = dissimilar_pair()
    contact = theories.hertz(pair)
    a, b = contact.half_width, 0.40397275 * contact.half_width
    inner = integral(lambda x: contact.pressure(x) if abs(x) < b else 0.0, a, kinks=(-b, b))
    assert inner == pytest.approx(pair.load / 2, rel=1e-7)  # eight digits of b
    D = 0.38 / 46e9 - 0.44 / 164e9  # A = (1 - 2 nu)/(2 G)
    xi = theories.bentall_johnson_frictionless(pair)
    assert D * contact.pressure(b) + xi == pytest.approx(0.0, abs=1e-7 * abs(xi))


def check_full_stick(
    stick: Any, coefficients: tuple[float, float, float], R: float, places: tuple[float, ...]
) -> None:
    """Check slope and strain of both half-planes at places in units of the half width.

    ``coefficients`` are B, C and D [1/Pa]; the principal values are known to 1e-8.
    """
    a, (B, C, D) = stick.half_width, coefficients
    for y in np.array(places) * a:
        slope = C / pi * cauchy(stick.pressure, a, y) - D * stick.traction(y)
        strain = B / pi * cauchy(stick.traction, a, y) + D * stick.pressure(y)
        assert slope == pytest.approx(y / R, abs=1e-8 * a / R)
        assert strain == pytest.approx(-stick.creepage, rel=1e-8)


def test_full_stick_satisfies_both_equations_and_carries_the_load() -> None:
    pair = dissimilar_pair()
    stick, R = theories.bentall_johnson_stick(pair), 0.025
    a, C, D = stick.half_width, 0.69 / 23e9 + 0.72 / 82e9, 0.38 / 46e9 - 0.44 / 164e9
    assert stick.oscillation == pytest.approx(atanh(0.143834) / pi, rel=5e-6)
    assert integral(stick.pressure, a) == pytest.approx(pair.load, rel=1e-9)
    assert integral(stick.traction, a) == pytest.approx(0.0, abs=1e-9 * pair.load)
    check_full_stick(stick, (C, C, D), R, (-0.7, 0.1, 0.5))


def test_full_stick_of_orthotropic_rollers_satisfies_both_equations() -> None:
    from woundon.elasticity import half_plane

    pair = wo.RollerProblem(
        upper=wo.HalfPlane(radius=0.3, material=PAPER),
        lower=wo.Rigid(radius=0.5),
        load=1900.0,
        friction=0.4,
    )
    stick, R = theories.bentall_johnson_stick(pair), 1 / (1 / 0.3 + 1 / 0.5)
    D, B, C = half_plane.coefficients(*PAPER.stiffness)
    assert integral(stick.pressure, stick.half_width) == pytest.approx(1900.0, rel=1e-9)
    check_full_stick(stick, (B, C, D), R, (-0.6, 0.3))


def test_full_stick_of_similar_rollers_is_hertz() -> None:
    pair = steel_pair(tangential_load=None)
    stick, contact = theories.bentall_johnson_stick(pair), theories.hertz(pair)
    x = np.linspace(-1.1, 1.1, 45) * contact.half_width
    np.testing.assert_allclose(stick.pressure(x), contact.pressure(x), rtol=1e-12, atol=1e-3)
    assert np.all(stick.traction(x) == 0.0)
    assert stick.creepage == 0.0
