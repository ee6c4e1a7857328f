"""The cylinder's characteristic sequences against the thesis's formulas in 60 digits and limits.

The program never computes a root of the characteristic equation; the reference does nothing else:
it follows thesis eqs. (42)-(57) literally, in multiple precision.
"""

from __future__ import annotations

from collections.abc import Callable
from math import cosh, log, sinh, sqrt

import mpmath as mp
import numpy as np
import pytest
from elastic_cases import Stiffness, isotropic
from hypothesis import given
from hypothesis import strategies as st

from woundon.elasticity import half_plane
from woundon.elasticity.cylinder import asymptotic_compliance, sequences, surface_compliance

MATERIALS: dict[str, Stiffness] = {
    "paper, real roots": (20e6, 3e9, 5e6, 10e6),
    "complex roots": (20e6, 30e6, 5e6, 30e6),
    "foam, nu = 0.1": isotropic(10e6, 0.1),
    "rubber, nu = 0.499": isotropic(10e6, 0.499),
    "rubber, nu = 0.49999": isotropic(10e6, 0.49999),
    "stiff in shear": (1e6, 1e9, 2e7, 1e9),
    "soft in shear": (1e9, 1e8, 1e7, 1e4),
}


class Wave:
    """One solution (phi, psi) of the n-th harmonic with its derivatives r d/dr."""

    def __init__(self, phi: Callable, psi: Callable, dphi: Callable, dpsi: Callable) -> None:
        self.phi, self.psi, self.dphi, self.dpsi = phi, psi, dphi, dpsi


def thesis_waves(n: int, R: mp.mpf, R0: mp.mpf, A: tuple[mp.mpf, ...]) -> list[Wave]:
    """Return the four solutions (44)-(48), powers scaled by R or R0 and n = 1 with its ln r."""
    A_rr, A_tt, A_rt, G = A
    mu = A_tt * G - A_rt * (A_rt + 2 * G) * n**2 + A_rr * (G + A_tt * n**2)
    root = mp.sqrt(mu**2 - 4 * A_rr * A_tt * G**2 * (n**2 - 1) ** 2)
    squares = [(mu + root) / (2 * A_rr * G)]
    waves = []
    if n == 1:
        c = (A_rt + G) / (A_tt + G)
        waves.append(Wave(mp.log, lambda r: -mp.log(r) - c, lambda r: mp.mpf(1), lambda r: -1))
        waves.append(Wave(lambda r: mp.mpf(1), lambda r: -1, lambda r: 0, lambda r: 0))
    else:
        squares.append((mu - root) / (2 * A_rr * G))
    for lam in (sign * mp.sqrt(square) for square in squares for sign in (1, -1)):
        # either row of (42) gives the ratio, but may vanish: take the larger
        first = A_rr * lam**2 - A_tt - n**2 * G, n * ((A_rt + G) * lam - (A_tt + G))
        second = -n * ((A_rt + G) * lam + A_tt + G), G * lam**2 - G - n**2 * A_tt
        row = max((first, second), key=lambda v: abs(v[0]) + abs(v[1]))
        at = R if mp.re(lam) > 0 else R0
        functions = [
            lambda r, f=factor, lam=lam, at=at: f * (r / at) ** lam
            for factor in (row[1], -row[0], lam * row[1], -lam * row[0])
        ]
        waves.append(Wave(*functions))
    return waves


def thesis_sequences(n: int, radius: float, core: float, stiffness: Stiffness) -> list[float]:
    """Return gamma_1, gamma_2, chi_1, chi_2 by thesis eqs. (55)-(57) in 60 digits."""
    with mp.workdps(60):
        R, R0, A_rr, A_tt, A_rt, G = map(mp.mpf, (radius, core, *stiffness))
        waves = thesis_waves(n, R, R0, (A_rr, A_tt, A_rt, G))
        conditions = mp.matrix(4, 4)
        for m, w in enumerate(waves):
            U, V = w.phi(R), w.psi(R)
            conditions[0, m] = A_rr * w.dphi(R) + A_rt * (U + n * V)
            conditions[1, m] = G * (w.dpsi(R) - V - n * U)
            conditions[2, m], conditions[3, m] = w.phi(R0), w.psi(R0)
        result = []
        for load in ([R, 0, 0, 0], [0, R, 0, 0]):
            a = mp.lu_solve(conditions, mp.matrix(load))
            U = mp.fsum(a[m] * w.phi(R) for m, w in enumerate(waves))
            V = mp.fsum(a[m] * w.psi(R) for m, w in enumerate(waves))
            result += [mp.re(U), mp.re(V)]
        (g1, c1), (g2, c2) = result[:2], result[2:]
        return [float(v) for v in (g1, -g2, -c1, c2)]


@pytest.mark.parametrize("ratio", [1e-6, 0.15, 0.9, 0.999, 0.9995])
@pytest.mark.parametrize("stiffness", MATERIALS.values(), ids=MATERIALS)
def test_thesis_formulas_in_many_digits(stiffness: Stiffness, ratio: float) -> None:
    """Every sequence has 11 correct digits, thin, incompressible or at n = 1; Betti's among them.

    Digits are counted on the largest of the four sequences at each n; gamma_1, the small one in a
    thin incompressible layer, is counted on itself.
    """
    n = np.array([1, 2, 3, 7, 40, 300, 3000])
    R = 0.5
    expected = np.array([thesis_sequences(int(m), R, R * ratio, stiffness) for m in n]).T
    found = np.array(sequences(n, R, R * ratio, *stiffness))
    np.testing.assert_allclose(found[0], expected[0], rtol=1e-11)
    assert np.max(np.abs(found - expected).max(axis=0) / np.abs(expected).max(axis=0)) < 1e-11
    # the reference's own Betti, to show that equation and conditions are put up right
    np.testing.assert_allclose(expected[1], expected[2], rtol=1e-12, atol=1e-12 * R / stiffness[0])


def test_axisymmetric_sequences() -> None:
    """gamma_0 and chi_0 in closed form from thesis eq. (53); torsion is R/(2G) (R^2/R0^2 - 1)."""
    A_rr, A_tt, A_rt, G = stiffness = MATERIALS["paper, real roots"]
    R, R0 = 0.3, 0.05
    gamma_1, gamma_2, chi_1, chi_2 = sequences(np.array(0), R, R0, *stiffness)
    power, rho = sqrt(A_tt / A_rr), R0 / R
    echo = rho ** (2 * power)
    gamma_0 = R * (1 - echo) / (A_rr * power * (1 + echo) + A_rt * (1 - echo))
    assert gamma_1 == pytest.approx(gamma_0, rel=1e-12)  # a dozen doublings, 1e-16 each
    assert chi_2 == pytest.approx(R / (2 * G) * (1 / rho**2 - 1), rel=1e-12)
    assert gamma_2 == chi_1 == 0


def test_no_overflow_and_half_plane_limit() -> None:
    """Finite from n = 1 to 1e6, with n gamma_1/R -> C, n chi_2/R -> B, n gamma_2/R -> -A."""
    stiffness = MATERIALS["paper, real roots"]
    A, B, C = half_plane.coefficients(*stiffness)
    n = np.unique(np.logspace(0, 6, 61).round())
    for ratio in (1e-6, 0.5, 0.9995):
        found = np.array(sequences(n, 2.0, 2.0 * ratio, *stiffness)) * n / 2.0
        assert np.all(np.isfinite(found))
        for values, limit in zip(found, (C, -A, -A, B), strict=True):
            # the next coefficient of the expansion, over n; at 0.9995 the core is felt to n = 4e4
            far = n > 1e5
            next_order = np.abs(asymptotic_compliance(2, *stiffness)[2]).max()
            assert np.all(np.abs(values - limit)[far] < 1.1 * next_order / n[far])


@pytest.mark.parametrize("nu", [0.0, 0.25, 0.49])
def test_isotropic_disc(nu: float) -> None:
    """A disc with a vanishing core: Michell's solution (Barber, Elasticity, ch. 12).

    With kappa = 3 - 4 nu the stress function (a r^n + b r^(n+2)) cos(n theta) gives
    gamma_1 = chi_2 = R/(4G) [(kappa+1) n - (kappa-1)]/(n^2-1) and
    gamma_2 = chi_1 = R/(4G) [(kappa+1) - (kappa-1) n]/(n^2-1).
    """
    R, stiffness = 0.2, isotropic(1e9, nu)
    n = np.arange(3, 200)
    unit, kappa = R / (4 * stiffness[3]) / (n**2 - 1.0), 3 - 4 * nu
    found = sequences(n, R, R * 1e-6, *stiffness)
    direct = unit * ((kappa + 1) * n - (kappa - 1))
    cross = unit * ((kappa + 1) - (kappa - 1) * n)
    # the core's echo at n = 3 is (R0/R)^4 = 1e-24
    for values, expected in zip(found, (direct, cross, cross, direct), strict=True):
        np.testing.assert_allclose(values, expected, rtol=1e-13, atol=1e-13 * direct[-1])


def test_rigid_motions_do_not_strain() -> None:
    """Without a core to speak of, an unbalanced load moves the whole body and strains it not.

    At n = 1 the displacement grows as ln(R/R0) while the strain U + V of the surface stays.
    A balanced pair (pressure cos, traction -sin) leaves no force, so nothing grows.
    """
    stiffness = MATERIALS["complex roots"]
    cores = np.array([1e-3, 1e-4, 1e-5])
    g1, g2, c1, c2 = np.array([sequences(np.array(1), 1.0, R0, *stiffness) for R0 in cores]).T
    growth = np.diff(g1)
    assert growth[1] == pytest.approx(growth[0], rel=1e-4)  # one decade each, up to R0^lambda
    assert growth[0] > 0.1 * g1[0]
    # strain of the surface under pressure, (U + n V)/R, and displacement of the balanced pair
    # both lose what grows, up to the core's own echo (R0/R)^lambda, lambda = 2.1
    assert np.ptp(g1 - c1) < 1e-3 * growth[0]
    assert np.ptp(g1 - g2) < 1e-3 * growth[0]
    assert np.ptp(c2 - c1) < 1e-3 * growth[0]


def bonded_layer(kh: float, E: float, nu: float) -> float:
    """Return k u/p of a plane layer bonded to a rigid base, its surface free of shear [1/Pa]."""
    kap = 3 - 4 * nu
    up = 2 * kap * sinh(2 * kh) - 4 * kh
    down = 2 * kap * cosh(2 * kh) + 1 + kap**2 + 4 * kh**2
    return 2 * up / down * (1 - nu**2) / E


@pytest.mark.parametrize("nu", [0.3, 0.4999])
@pytest.mark.parametrize("kh", [0.3, 1.0, 3.0])
def test_thin_cover_is_a_plane_layer(kh: float, nu: float) -> None:
    """gamma_n1 n/R -> the plane bonded layer's compliance, with an error linear in h/R."""
    E = 10e6
    errors = []
    for h in (4e-3, 2e-3, 1e-3):
        n = kh / h  # of R = 1; the formulas take any real n
        gamma_1 = sequences(np.array(n), 1.0, 1.0 - h, *isotropic(E, nu)).gamma_1
        errors.append(float(gamma_1) * n / bonded_layer(kh, E, nu) - 1)
    assert abs(errors[-1]) < 5e-3
    # halving h halves the curvature error, to the next order h/R
    assert errors[1] / errors[0] == pytest.approx(0.5, abs=0.02)
    assert errors[2] / errors[1] == pytest.approx(0.5, abs=0.02)


def test_coinciding_roots_are_no_exception() -> None:
    """As G passes through the value where two roots meet, the sequences run straight through."""
    A_rr, A_tt, A_rt = 20e6, 80e6, 10e6
    n, s = 6, sqrt(20e6 * 80e6)
    # mu_n = sqrt(kappa_n): the discriminant of (43) vanishes; linear in G
    G = (s**2 - A_rt**2) * n**2 / (2 * A_rt * n**2 - A_rr - A_tt + 2 * s * (n**2 - 1.0))
    roots = np.roots(
        [
            A_rr * G,
            -(A_rr * (G + n**2 * A_tt) - A_rt * (A_rt + 2 * G) * n**2 + A_tt * G),
            A_tt * G * (n**2 - 1.0) ** 2,
        ]
    )
    assert abs(roots[0] - roots[1]) < 1e-6 * abs(roots[0])
    step = 1e-4
    below, at, above = (
        np.array(sequences(np.array(n), 0.3, 0.1, A_rr, A_tt, A_rt, G * (1 + e)))
        for e in (-step, 0.0, step)
    )
    # a smooth function's second difference is step^2 times its curvature; a branch's, sqrt(step)
    assert np.abs(above - 2 * at + below).max() < 3 * step**2 * np.abs(at).max()
    assert np.abs(above - below).max() > 0.01 * step * np.abs(at).max()


def test_expansion_in_inverse_powers() -> None:
    """The expansion's error falls as the first power left out."""
    stiffness = MATERIALS["paper, real roots"]
    n = np.array([20.0, 40.0, 80.0])
    exact = surface_compliance(n, 12.0, *stiffness)
    for orders in (1, 2, 3, 5):
        series = asymptotic_compliance(orders, *stiffness)
        sums = sum(series[j][:, :, None] / n**j for j in range(1, orders + 1))
        error = np.abs(exact - sums).max(axis=(0, 1))
        slopes = np.log2(error[:-1] / error[1:])
        # an order's coefficient may be near zero (that of 1/n^4 is): then the next one shows
        assert np.all(slopes > orders + 0.9)


modulus = st.floats(1e6, 1e10)


@given(
    A_rr=modulus,
    A_tt=modulus,
    share=st.floats(0, 0.99),
    G=modulus,
    ratio=st.floats(1e-3, 0.9995),
    n=st.integers(0, 2000),
    size=st.floats(1e-2, 50),
)
def test_compliance_is_symmetric_and_positive(
    A_rr: float, A_tt: float, share: float, G: float, ratio: float, n: int, size: float
) -> None:
    """Betti's theorem, positive work, and the scaling with size and stiffness, for any material."""
    stiffness = A_rr, A_tt, share * sqrt(A_rr * A_tt), G
    Y = surface_compliance(np.array(n), -log(ratio), *stiffness)
    product = sqrt(Y[0, 0] * Y[1, 1])
    assert product > 0
    assert abs(Y[0, 1] - Y[1, 0]) < 1e-11 * product
    assert abs(Y[0, 1]) < product
    twice = np.array(sequences(np.array(n), size, size * ratio, *(2 * v for v in stiffness)))
    once = np.array(sequences(np.array(n), 1.0, ratio, *stiffness))
    # ln(R/R0) of a thin layer takes the rounding of R0/R, 1e-16/5e-4
    np.testing.assert_allclose(2 * twice, size * once, rtol=1e-11, atol=1e-12 * size * product)
