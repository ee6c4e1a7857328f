"""The cylinder's influence functions against plain summation, quadrature and one another."""

from __future__ import annotations

from functools import lru_cache
from math import pi

import numpy as np
import pytest
from elastic_cases import Stiffness, isotropic, whole
from scipy.integrate import quad

from woundon.elasticity import cylinder, half_plane
from woundon.elasticity.cylinder import sequences, surface_kernels
from woundon.elasticity.kernels import SurfaceKernels

PAPER: Stiffness = (20e6, 3e9, 5e6, 10e6)
COMPLEX: Stiffness = (20e6, 30e6, 5e6, 30e6)


BODIES: dict[str, tuple[float, float, Stiffness]] = {
    "thick roll": (0.3, 0.05, PAPER),
    "roll without a core": (0.3, 1e-3, PAPER),
    "complex roots": (0.2, 0.1, COMPLEX),
    "cover, 20 mm": (0.5, 0.48, isotropic(10e6, 0.1)),
    "rubber cover, 20 mm": (0.5, 0.48, isotropic(10e6, 0.4999)),
    "thin cover, R/200": (1.0, 0.995, isotropic(10e6, 0.45)),
}
NAMES = [
    f"{quantity}_{load}" for quantity in ("normal", "tangent", "slope", "strain") for load in "pq"
]


def kernels(body: tuple[float, float, Stiffness]) -> SurfaceKernels:
    """Return the kernels of a body."""
    R, R0, stiffness = body
    return surface_kernels(R, R0, *stiffness)


@lru_cache(maxsize=4)
def faded_sequences(
    body: tuple[float, float, Stiffness], terms: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return the sequences, n = 1 ... terms, faded out smoothly over the last three quarters.

    The fading (a smooth step, all its derivatives vanish at either end) makes the plain sums
    converge faster than any power of terms * t/R, without any closed form.
    """
    R, R0, stiffness = body
    n = np.arange(1, terms + 1)
    x = np.clip((n / terms - 0.25) / 0.75, 1e-3, 1 - 1e-3)
    fade = 1 / (1 + np.exp(np.clip(1 / (1 - x) - 1 / x, -700, 700)))
    fade[n <= terms // 4] = 1.0
    return n, np.array(sequences(n, R, R0, *stiffness)) * fade


def plain_sums(body: tuple[float, float, Stiffness], t: float) -> dict[str, float]:
    """Sum the terms of thesis eq. (59) and its derivatives at the distance t: 30 000 or more."""
    R, R0, stiffness = body
    n, (g1, g2, c1, c2) = faded_sequences(body, max(30_000, round(1500 * R / (R - R0))))
    zero = sequences(np.array(0), R, R0, *stiffness)
    c, s = np.cos(n * t / R), np.sin(n * t / R)
    return {
        "normal_p": -(zero.gamma_1 / 2 + g1 @ c) / (pi * R),
        "normal_q": g2 @ s / (pi * R),
        "tangent_p": c1 @ s / (pi * R),
        "tangent_q": (zero.chi_2 / 2 + c2 @ c) / (pi * R),
        "slope_p": (n * g1) @ s / (pi * R**2),
        "slope_q": (n * g2) @ c / (pi * R**2),
        "strain_p": -(zero.gamma_1 / 2 + (g1 - n * c1) @ c) / (pi * R**2),
        "strain_q": (g2 - n * c2) @ s / (pi * R**2),
    }


@pytest.mark.parametrize("body", BODIES.values(), ids=BODIES)
def test_plain_summation(body: tuple[float, float, Stiffness]) -> None:
    """Each kernel equals its plainly summed series, near, far and on the other side."""
    R, R0, stiffness = body
    scale = max(half_plane.coefficients(*stiffness)) / pi
    k = kernels(body)
    zero = float(sequences(np.array(0), R, R0, *stiffness).chi_2) / R
    for t in (0.5 * (R - R0), 1.7 * (R - R0), 0.5 * pi * R, -0.9 * pi * R, pi * R):
        expected = plain_sums(body, t)
        for name in NAMES:
            derivative = name.split("_")[0] in ("slope", "strain")
            size = scale / (R - R0) if derivative else scale
            # 1e-9 of the half-plane at the distance of the thickness, or the rounding of the
            # plain sum (3e5 terms of that size at worst) and of a large torsional constant
            tolerance = 1e-9 * size + 1e-14 * zero * (not derivative)
            found = float(whole(getattr(k, name), np.array(t)))
            assert found == pytest.approx(expected[name], abs=tolerance), (name, t)


@pytest.mark.parametrize("name", ["foam", "rubber"])
def test_cover_of_a_thousandth(name: str) -> None:
    """A cover of R/1000 is a plane layer a thousandth thick: kernels agree to that order.

    Half a thickness away, against the Fourier integral of the layer's compliance; halving the
    cover halves the difference.
    """
    nu = {"foam": 0.1, "rubber": 0.49999}[name]
    E, kap = 10e6, 3 - 4 * nu

    def beyond_half_plane(k: float) -> float:  # L - 1, of x = k h
        decay = np.exp(-2 * k)
        half_up = kap * (1 - decay**2) - 4 * k * decay
        half_down = kap * (1 + decay**2) + (1 + kap**2 + 4 * k**2) * decay
        return float(half_up / half_down - 1)

    t = 0.5  # in thicknesses
    plane = 1 / t + quad(lambda k: beyond_half_plane(k) * np.sin(k * t), 0, 40, limit=200)[0]
    expected = 2 * (1 - nu**2) / (pi * E) * plane
    errors = []
    for h in (2e-3, 1e-3):
        k = surface_kernels(1.0, 1 - h, *isotropic(E, nu))
        assert k.truncation_error < 1e-10
        errors.append(float(whole(k.slope_p, np.array(t * h))) * h / expected - 1)
    assert abs(errors[1]) < 2e-3
    assert errors[1] / errors[0] == pytest.approx(0.5, abs=0.02)


@pytest.mark.parametrize("body", BODIES.values(), ids=BODIES)
def test_gradients_are_derivatives(body: tuple[float, float, Stiffness]) -> None:
    """The integral of slope is v's rise; that of strain - v/R is u's."""
    R, R0, stiffness = body
    k = kernels(body)
    a, b = 0.3 * (R - R0), 0.9 * (R - R0)
    scale = max(half_plane.coefficients(*stiffness)) / pi
    for load in "pq":
        v, u, slope, strain = (
            getattr(k, f"{q}_{load}") for q in ("normal", "tangent", "slope", "strain")
        )
        x, weight = np.polynomial.legendre.leggauss(40)
        t, weight = (a + b) / 2 + (b - a) / 2 * x, weight * (b - a) / 2
        ends = np.array([a, b])
        rise_v, rise_u = np.diff(whole(v, ends))[0], np.diff(whole(u, ends))[0]
        # the tables' errors; u_q carries the torsional constant, up to 1e5 times the rest
        rounding = 1e-14 * np.abs(whole(u, ends)).max()
        assert weight @ whole(slope, t) == pytest.approx(rise_v, abs=1e-9 * scale)
        stretch = weight @ (whole(strain, t) - whole(v, t) / R)
        assert stretch == pytest.approx(rise_u, abs=1e-9 * scale + rounding)


def test_singular_parts() -> None:
    """The strongest singularity is the half-plane's; curvature adds a weaker one to each kernel."""
    R, stiffness = 0.3, PAPER
    k = surface_kernels(R, 0.05, *stiffness)
    flat = half_plane.surface_kernels(*stiffness)
    for name in NAMES:
        curved, plane = getattr(k, name), getattr(flat, name)
        assert curved.inverse == pytest.approx(plane.inverse, rel=1e-14, abs=0)
        assert curved.delta == pytest.approx(plane.delta, rel=1e-14, abs=0)
        if plane.log or plane.sign:
            assert curved.log == pytest.approx(plane.log, rel=1e-14, abs=0)
            assert curved.sign == pytest.approx(plane.sign, rel=1e-14, abs=0)
    # next order, by hand from the sequences at one large n of a body without a core:
    # n^2 gamma_1/R - n C -> the coefficient of sin(n t)/n in slope_p
    n, C = 1e5, half_plane.coefficients(*stiffness).C
    second = float(sequences(np.array(n), 1.0, 1e-3, *stiffness).gamma_1) * n**2 - n * C
    # next order at this n is 1e-5 of it; n^2 times rounding is 1e-6
    assert k.slope_p.sign == pytest.approx(second / (2 * R), rel=1e-4)


@pytest.mark.parametrize("body", [BODIES["thick roll"], BODIES["cover, 20 mm"]])
def test_truncation_error_is_honest(
    body: tuple[float, float, Stiffness], monkeypatch: pytest.MonkeyPatch
) -> None:
    """With far too few terms the reported error bounds the true one, and not absurdly."""
    R, R0, stiffness = body
    best = kernels(body)
    monkeypatch.setattr(cylinder, "MAX_TERMS", best.terms // 4)
    for kept in (cylinder.layered_kernels, cylinder._elastic_spectrum):
        kept.cache_clear()
    rough = kernels(body)
    for kept in (cylinder.layered_kernels, cylinder._elastic_spectrum):
        kept.cache_clear()
    t = np.linspace(-R, R, 2001)
    unit = half_plane.coefficients(*stiffness).C / pi / min(R - R0, R)
    assert rough.terms == best.terms // 4
    true = max(
        np.abs(
            getattr(rough, f"{q}_{load}").smooth(t) - getattr(best, f"{q}_{load}").smooth(t)
        ).max()
        / unit
        for q in ("slope", "strain")
        for load in "pq"
    )
    assert true < 3 * rough.truncation_error
    assert rough.truncation_error < 1e3 * true


@pytest.mark.parametrize("name", ["thick roll", "roll without a core", "complex roots"])
def test_the_kernels_close_around_the_circle(name: str) -> None:
    """Half a turn away both sides meet smoothly: odd kernels are zero there, even ones flat.

    (On a thin cover all of them have died out there.)
    """
    R, R0, stiffness = BODIES[name]
    k = kernels(BODIES[name])
    scale = max(half_plane.coefficients(*stiffness)) / pi
    h = 1e-4 * R
    for kernel_name in NAMES:
        at, near = whole(getattr(k, kernel_name), np.array([pi * R, pi * R - h]))
        size = scale / R if kernel_name.split("_")[0] in ("slope", "strain") else scale
        if kernel_name in ("normal_q", "tangent_p", "slope_p", "strain_q"):
            # the series' own error, as in test_plain_summation
            assert at == pytest.approx(0.0, abs=1e-9 * size * R / (R - R0)), kernel_name
        else:
            # it falls by k'' h^2/2 where a kink would leave k' h, 1e4 times as much; k'' of the
            # torsional constant is zero
            assert near == pytest.approx(at, abs=20 * size * (h / R) ** 2), kernel_name


@pytest.mark.parametrize("name", list(BODIES))
def test_beyond_half_a_turn_kernels_go_on_around_the_circle(name: str) -> None:
    """Up to their reach, singular parts and all, as the short way round tells them."""
    R, R0, stiffness = BODIES[name]
    k = kernels(BODIES[name])
    assert k.max_distance > 1.05 * pi * R
    t = np.linspace(pi * R, k.max_distance, 50)
    scale = max(half_plane.coefficients(*stiffness)) / pi
    for kernel_name in ("normal_p", "normal_q", "slope_p", "slope_q", "strain_p", "strain_q"):
        kernel = getattr(k, kernel_name)
        size = scale / R if kernel_name.split("_")[0] in ("slope", "strain") else scale
        for sign in (1, -1):
            far, short = whole(kernel, sign * t), whole(kernel, sign * (t - 2 * pi * R))
            # the series' own error, as in test_plain_summation
            np.testing.assert_allclose(far, short, rtol=0, atol=1e-9 * size * R / (R - R0))


@pytest.mark.parametrize("wide", [2.0, 5.0, 20.0])
def test_length_tells_the_degree(wide: float) -> None:
    """Chebyshev interpolation in x and s on [-a, a] needs 20/asinh(length/a) points.

    A contact 2a wide on a cover of thickness a/2, a/5, a/20, with real and with double roots.
    """
    R, h = 1.0, 1e-3
    a = wide * h
    for stiffness in (PAPER, isotropic(1e7, 0.3)):
        k = surface_kernels(R, R - h, *stiffness)
        points = max(24, round(20 / np.arcsinh(k.length / a)))
        t = np.cos(pi * (np.arange(points) + 0.5) / points)
        x = np.linspace(-1, 1, 200)
        vandermonde = np.polynomial.chebyshev.chebvander
        weights = np.linalg.solve(vandermonde(t, points - 1).T, vandermonde(x, points - 1).T)
        for name in ("slope_p", "slope_q", "strain_p", "strain_q"):
            smooth = getattr(k, name).smooth
            found = weights.T @ smooth(a * (t[:, None] - t)) @ weights
            error = np.abs(found - smooth(a * (x[:, None] - x))).max()
            lead = max(abs(k.slope_p.inverse), abs(k.strain_q.inverse)) / a
            # exp(-20) times (a/length)^2 to ^3 of a double pole; kinks add (a/R)^2/points
            assert error < 3e-5 * lead


def test_smooth_is_tiny_when_the_body_is_large() -> None:
    """As R grows with everything else kept, the kernels become the half-plane's."""
    t = np.array([-3e-3, 1e-3, 5e-3])
    flat = half_plane.surface_kernels(*PAPER)
    errors = []
    for R in (1.0, 10.0, 100.0):
        k = surface_kernels(R, 0.3 * R, *PAPER)
        errors.append(np.abs(whole(k.slope_p, t) - flat.slope_p.inverse / t).max())
    # the first correction is of relative size t/R
    assert errors[0] / errors[1] == pytest.approx(10, rel=0.05)
    assert errors[1] / errors[2] == pytest.approx(10, rel=0.05)
