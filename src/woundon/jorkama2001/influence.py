r"""Influence coefficients of half-plane and cylinder (thesis chapter 2 and section 3.4).

Tractions are piecewise linear on M equidistant nodes x_l = -a + (l - 1) dx, eqs. (106) to (108):
p = sum p_m psi_m and q = sum q_m psi_m, m = 2 ... M-1.  Surface displacements and strains are

    v_l   = sum_m A_lm p_m + B_lm q_m           normal displacement, outward
    u_l   = sum_m Cbar_lm p_m + Dbar_lm q_m     tangential displacement, along +x      (110)
    eps_l = sum_m C_lm p_m + D_lm q_m           strain, backward difference of u

A and Dbar depend on |l - m| only, B and Cbar on l - m with its sign (117).

Corrections of the printed text: (27), (30) and (102) are garbled, ``half_plane_constants`` has the
derived result; C^-1_m1 of (57) is C^-1_m1,n; cos nx of (113) is cos(n x/R); sin of (115) is sin^2;
(1/R)[v + du/dx] of (114) and (116) is v/R + du/dx; the second line of (111) gives Dbar.

The Fourier series (116) of a cylinder decays as 1/n^3 and needs more than 2 pi R/dx terms.  Here
the first powers of 1/n of the characteristic sequences are summed in closed form by polylogarithms,
Li_s(e^it) = sum e^int/n^s, so that about a thousand terms of the remainder give eleven digits.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache
from math import ceil, factorial, log, pi, sqrt
from typing import Any, NamedTuple

import numpy as np
from scipy.special import bernoulli, zeta

import woundon as wo

__all__ = [
    "Coefficients",
    "coefficients",
    "edge_strain",
    "half_plane_constants",
    "surface_strain",
]

Array = np.ndarray
Stiffness = Sequence[Any]  # A_rr, A_tt, A_rt, G: ``stiffness`` of a material [Pa]

POWERS = 4  # of 1/n that are summed in closed form: the remainder decays as 1/n^5
LEAST_TERMS = 1024  # of the remainder: it is below 1e-11 of the sums for the thesis's papers
DEAD = 18.0  # the reflection from the core has decayed to exp(-2 * 18) where powers are fitted


class Coefficients(NamedTuple):
    """Influence coefficients of a body's surface (110).

    Attributes
    ----------
    A, B : (M, M - 2) arrays
        Normal displacement at all nodes, by p and q [m/Pa].
    C, D : (M - 1, M - 2) arrays
        Strain in the cells that end at nodes 2 ... M, by p and q [1/Pa].
    """

    A: Array
    B: Array
    C: Array
    D: Array


def coefficients(body: wo.Body, M: int, a: float) -> Coefficients:
    """Return the influence coefficients of a body on M nodes over [-a, a].

    Raises
    ------
    InvalidProblem
        If the body is not rigid, a half-plane or a cylinder.
    """
    dx, k = 2 * a / (M - 1), np.subtract.outer(np.arange(M), np.arange(1, M - 1))  # k = l - m
    if isinstance(body, wo.Rigid):
        zeros = np.zeros(k.shape)
        return Coefficients(zeros, zeros, zeros[1:], zeros[1:])
    if isinstance(body, wo.HalfPlane):
        v_p, v_q, u_p, u_q = _half_plane(body, M, dx)
        curvature = 0.0  # (109) has no term v/R
    else:
        v_p, v_q, u_p, u_q = _cylinder(_cylindrical(body), M, dx)
        curvature = 1 / body.radius
    distance, side = np.abs(k), np.sign(k)
    A, B = v_p[distance], side * v_q[distance]
    C = np.diff(side * u_p[distance], axis=0) / dx + curvature * A[1:]  # (111), (116)
    D = np.diff(u_q[distance], axis=0) / dx + curvature * B[1:]
    return Coefficients(A, B, C, D)


def _cylindrical(body: wo.Body) -> wo.Cylinder:
    """Return a body that must be a cylinder."""
    if isinstance(body, wo.Cylinder):
        return body
    text = f"{type(body).__name__} is not possible; must be Rigid, HalfPlane or Cylinder"
    raise wo.InvalidProblem([("roll, drum", text)])


# ---- half-plane, section 2.1 --------------------------------------------------------------------


def half_plane_constants(stiffness: Stiffness) -> tuple[float, float, float]:
    """Return A, B, C of the half-plane [1/Pa] (30), derived again; y is normal to the surface."""
    A_yy, A_xx, A_xy, G, *_ = stiffness
    s, det = sqrt(A_xx * A_yy), A_xx * A_yy - A_xy**2
    root = sqrt((s - A_xy) * (s + A_xy + 2 * G))
    return 1 / (s + A_xy), sqrt(A_yy / G) * root / det, sqrt(A_xx / G) * root / det


def _half_plane(body: wo.HalfPlane, M: int, dx: float) -> tuple[Array, ...]:
    """Return A, B, Cbar, Dbar by distance l - m = 0 ... M-1 (111)."""
    A, B, C = half_plane_constants(body.material.stiffness)
    k = np.arange(-1.0, M + 1)
    square = k**2 * np.log(np.abs(k) * dx, where=k != 0, out=np.zeros(k.size))
    v_p = C * dx / (2 * pi) * (-3 + square[:-2] - 2 * square[1:-1] + square[2:])
    v_q = np.where(k[1:-1] > 0, -A * dx / 2, 0.0)
    return v_p, v_q, v_q, -B / C * v_p


# ---- cylinder, section 2.2 ----------------------------------------------------------------------


class _Series(NamedTuple):
    """The characteristic sequences of a cylinder (57), n = 1 ... N, split for summation [m/Pa].

    ``powers`` holds y_1 ... y_4 of gamma_1, gamma_2 = chi_1 and chi_2 in y_1/n + ... + y_4/n^4,
    shape (3, POWERS), and ``rest`` the remainders, shape (3, N).
    """

    gamma_0: float
    powers: Array
    rest: Array


@lru_cache(maxsize=64)
def _series(body: wo.Cylinder) -> _Series:
    """Return the sequences, their asymptotic powers fitted at n = N, N/2, N/4 (but for y_1)."""
    R, (A, B, C) = body.radius, half_plane_constants(body.material.stiffness)
    slowest = _exponents(np.array([1e6]), body.material.stiffness)[:, 2].real.item() / 1e6
    N = max(LEAST_TERMS, ceil(4 * DEAD / (slowest * log(R / body.core_radius))))
    gamma_0, sequences = _sequences(body, N)
    n = np.arange(1.0, N + 1)
    powers = np.empty((3, POWERS))
    powers[:, 0] = R * np.array([C, -A, B])  # a wave much shorter than R feels a half-plane
    at = N // 2 ** np.arange(POWERS - 1)
    # what remains of the sequences without y_1, by which three equations give y_2 ... y_4
    left = at * (at * sequences[:, at - 1] - powers[:, :1])  # y_2 + y_3/n + y_4/n^2
    powers[:, 1:] = np.linalg.solve(1.0 / at[:, None] ** np.arange(POWERS - 1), left.T).T
    rest = sequences - powers @ (1 / n ** np.arange(1, POWERS + 1)[:, None])
    return _Series(gamma_0, powers, rest)


def _exponents(n: Array, stiffness: Stiffness) -> Array:
    """Return lambda_n1 ... lambda_n4 for n >= 2 (44), (45)."""
    A_rr, A_tt, A_rt, G, *_ = stiffness
    mu = A_tt * G - A_rt * (A_rt + 2 * G) * n**2 + A_rr * (G + A_tt * n**2)
    kappa = 4 * A_rr * A_tt * G**2 * (n**2 - 1) ** 2
    first = np.sqrt((mu + np.sqrt(mu**2 - kappa + 0j)) / (2 * A_rr * G))
    third = sqrt(A_tt / A_rr) * (n**2 - 1) / first  # (43): the product of the roots squared
    return np.stack([first, -first, third, -third], axis=-1)


def _sequences(body: wo.Cylinder, N: int) -> tuple[float, Array]:
    """Return gamma_0, and gamma_1, gamma_2 = chi_1, chi_2 of n = 1 ... N (57) [m/Pa].

    The powers r^lambda are scaled by R or R_0, where they are largest, or they would overflow.
    """
    R, ln = body.radius, log(body.core_radius / body.radius)  # of R_0/R
    A_rr, A_tt, A_rt, G, *_ = body.material.stiffness
    n = np.arange(1.0, N + 1)[:, None]
    with np.errstate(invalid="ignore", divide="ignore"):  # lambda_13 = 0, replaced below
        exponent = _exponents(n[:, 0], body.material.stiffness)
    mu_1 = A_tt * G - A_rt * (A_rt + 2 * G) + A_rr * (G + A_tt)
    exponent[0] = sqrt(mu_1 / (A_rr * G)) * np.array([1, -1, 0, 0])  # (44)
    grows = exponent.real > 0
    decay = np.exp(np.where(grows, exponent, -exponent) * ln)
    outside, inside = np.where(grows, 1.0, decay), np.where(grows, decay, 1.0)  # at R and R_0
    # phi and varphi = eta phi (47) up to a factor, by the row of (42) that is not zero
    by_row = np.array(
        [
            [(A_rt + G) * n * exponent - (A_tt + G) * n, A_rr * exponent**2 - A_tt - n**2 * G],
            [G + n**2 * A_tt - G * exponent**2, (A_rt + G) * n * exponent + (A_tt + G) * n],
        ]
    )
    size = np.abs(by_row).max(axis=1, keepdims=True)
    mode = np.where(size[0] > size[1], by_row[0], by_row[1]) / size.max(axis=0)
    value, slope, core = mode * outside, mode * exponent * outside, mode * inside
    # n = 1: phi_13 = ln(r/R), varphi_13 = ln(r/R) + c, and phi_14 = varphi_14 = 1 (47)
    c = (A_rt + G) / (A_tt + G)
    value[:, 0, 2:], slope[:, 0, 2:] = [[0, 1], [c, 1]], [[1, 0], [1, 0]]
    core[:, 0, 2:] = [[ln, 1], [ln + c, 1]]
    system = np.array(
        [
            (A_rr * slope[0] + A_rt * (value[0] - n * value[1])) / R,  # sigma_r (54), (55)
            G * (slope[1] - value[1] + n * value[0]) / R,  # tau
            core[0],
            core[1],
        ]
    ).transpose(1, 0, 2)
    inverse = np.linalg.inv(system)[:, :, :2]
    gamma, chi = np.einsum("snm,nmj->sjn", value, inverse).real
    # n = 0 (53)
    root = sqrt(A_tt / A_rr)
    stress = [(A_rt + A_rr * root) / R, (A_rt - A_rr * root) * np.exp(root * ln) / R]
    b = np.linalg.solve([stress, [np.exp(root * ln), 1.0]], [1.0, 0.0])
    return float(b[0] + b[1] * np.exp(root * ln)), np.array([gamma[0], gamma[1], chi[1]])


def _cylinder(body: wo.Cylinder, M: int, dx: float) -> tuple[Array, ...]:
    """Return A, B, Cbar, Dbar by distance l - m = 0 ... M-1 (116); Dbar up to a constant."""
    series, delta = _series(body), dx / body.radius
    gamma_1, coupling, chi_2 = (
        _hat_sum(dict(enumerate(powers, 1)), rest, delta, M)
        for powers, rest in zip(series.powers, series.rest, strict=True)
    )
    mean = delta / (2 * pi) * series.gamma_0  # alpha_0 gamma_0
    return -mean - gamma_1.real, coupling.imag, coupling.imag, chi_2.real


def _hat_sum(powers: Mapping[int, float], rest: Array, delta: float, M: int) -> Array:
    """Return sum_n w_n h_n e^(i n k delta), k = 0 ... M-1, h_n of the hats (115).

    w_n is the sum of powers[s]/n^s, plus rest[n].
    """
    n, t = np.arange(1.0, rest.size + 1), delta * np.arange(-1.0, M + 1)
    hat = 4 * np.sin(n * delta / 2) ** 2 / (pi * n**2 * delta)
    # h_n e^int is a second difference of e^int/n^2; what is constant or linear in t drops out
    closed = polylogarithms({s + 2: y for s, y in powers.items()}, t, start=2)
    return np.asarray(_fourier(rest * hat, t[1:-1]) - np.diff(closed, 2) / (pi * delta))


def edge_strain(body: wo.Body, M: int, a: float) -> tuple[Array, Array]:
    """Return the coefficients of the strain at x_M = a itself, by p and q, (M - 2,) each [1/Pa].

    The thesis takes the strain of the last cell instead, which is what makes it converge slowly.
    """
    dx = 2 * a / (M - 1)
    if isinstance(body, wo.Rigid):
        return np.zeros(M - 2), np.zeros(M - 2)
    if isinstance(body, wo.HalfPlane):
        _, B, _ = half_plane_constants(body.material.stiffness)
        by_q = -B / pi * np.diff(_xlogx(dx * np.arange(0.0, M)), 2) / dx
        return np.zeros(M - 2), by_q[::-1]
    series, delta = _series(_cylindrical(body)), dx / body.radius
    (by_p, rest_p), (by_q, rest_q) = _strain_sequences(series)
    mean = delta / (2 * pi) * series.gamma_0
    p = _hat_sum(dict(enumerate(by_p)), rest_p, delta, M).real - mean
    q = _hat_sum(dict(enumerate(by_q)), rest_q, delta, M).imag
    # node m = 2 ... M-1 is M - m cells from x_M: distances M-2 ... 1
    return p[-2:0:-1] / body.radius, q[-2:0:-1] / body.radius


def _strain_sequences(series: _Series) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
    """Return n chi_1 - gamma_1 and gamma_2 - n chi_2: their powers 0 ... 4 of 1/n, and the rests.

    They are those of the strain (u_r + du_theta/dtheta)/R (59), by p and by q.
    """
    (g, c, h), (gamma_1, coupling, chi_2) = series.powers, series.rest
    n = np.arange(1.0, gamma_1.size + 1)
    by_p = np.append(c, 0.0) - np.append(0.0, g), n * coupling - gamma_1
    by_q = np.append(0.0, c) - np.append(h, 0.0), coupling - n * chi_2
    return by_p, by_q


# ---- the strain anywhere on the surface ----------------------------------------------------------


def surface_strain(body: wo.Body, x: Array, p: Array, q: Array, points: Array) -> Array:
    """Return the tangential strain of a body's surface, inside and outside the contact.

    The strain is exact for tractions that are linear between any nodes: no differences are taken.

    Parameters
    ----------
    body : Rigid, HalfPlane or Cylinder
    x : (M,) array
        Nodes along the surface, ascending [m].
    p, q : (M,) arrays
        Pressure, and traction along +x, at the nodes [Pa].
    points : (k,) array
        Where the strain is wanted [m]; of a cylinder at most half a turn from every node.

    Returns
    -------
    (k,) array

    Notes
    -----
    (32) differentiated for a half-plane, (59) for a cylinder.
    """
    if isinstance(body, wo.Rigid):
        return np.zeros(np.shape(points))
    if isinstance(body, wo.HalfPlane):
        A, B, _ = half_plane_constants(body.material.stiffness)
        by_q = _integral(x, q, points, lambda t: np.log(np.abs(t)), _xlogx)
        inside = np.interp(points, x, p, left=0.0, right=0.0)
        return np.asarray(-A * inside - B / pi * by_q)
    R, series = body.radius, _series(_cylindrical(body))
    theta, at = x / R, points / R
    strain_p, strain_q = _strain_sequences(series)
    by_p = _convolved(theta, p, at, *strain_p).real
    by_q = _convolved(theta, q, at, *strain_q).imag
    mean = float(np.trapezoid(p, theta)) * series.gamma_0 / 2
    return np.asarray((by_p + by_q - mean) / (pi * R))


def _convolved(theta: Array, f: Array, at: Array, powers: Array, rest: Array) -> Array:
    """Return int f(s) sum_n w_n e^(in(t-s)) ds, w_n = powers[0] + powers[1]/n + ... + rest[n]."""
    n = np.arange(1.0, rest.size + 1)

    def antiderivative(order: int) -> dict[int, float]:
        """Return weights of polylogarithms of a higher order: each integration adds 1."""
        return {s + order: y for s, y in enumerate(powers)}

    closed = _integral(
        theta,
        f,
        at,
        lambda t: polylogarithms(antiderivative(1), t) / 1j,
        lambda t: -polylogarithms(antiderivative(2), t),
    )
    spectrum = _integral(
        theta,
        f,
        np.zeros(1),
        lambda t: np.exp(1j * np.multiply.outer(t, n)) / (1j * n),
        lambda t: -np.exp(1j * np.multiply.outer(t, n)) / n**2,
    )[0]
    return np.asarray(closed + _fourier(rest * spectrum, at))


def _integral(
    x: Array,
    f: Array,
    points: Array,
    first: Callable[[Array], Array],
    second: Callable[[Array], Array],
) -> Array:
    """Return int f(s) k(t - s) ds at points t by parts, f linear between nodes x.

    ``first`` and ``second`` are antiderivatives of k; values of theirs may have further axes.
    """
    slope = np.concatenate([[0.0], np.diff(f) / np.diff(x), [0.0]])
    distance = np.subtract.outer(points, x)
    value = np.tensordot(np.diff(slope), np.moveaxis(second(distance), 1, 0), axes=1)
    for end, sign in ((0, 1.0), (-1, -1.0)):
        if f[end] != 0.0:
            value = value + sign * f[end] * first(distance[:, end])
    return np.asarray(value)


def _xlogx(t: Array) -> Array:
    """Return t (ln|t| - 1), the antiderivative of ln|t|, 0 at t = 0."""
    return np.asarray(t * (np.log(np.abs(t), where=t != 0, out=np.zeros(t.shape)) - 1))


# ---- sums over n --------------------------------------------------------------------------------


def polylogarithms(weights: Mapping[int, float], t: Array, start: int = 0) -> Array:
    """Return the sum of w_s Li_s(e^it) over s >= 1, |t| < 2 pi, but for powers t^k, k < ``start``.

    Notes
    -----
    Li_s(e^it) = sum_(k != s-1) zeta(s-k) (it)^k/k!
               + (it)^(s-1)/(s-1)! [1 + 1/2 + ... + 1/(s-1) - ln(-it)],  t > 0;  t = 0 for s >= 2.
    """
    # until (|t|/2 pi)^k is 1e-19: 64 terms at half a turn, a dozen within a nip
    count = max(8 + max(weights), ceil(44 / log(2 * pi / min(np.abs(t).max(), 6.0))))
    regular, singular = np.zeros(count), np.zeros(max(weights) + 1)
    for s, weight in weights.items():
        regular += weight * _expansion(s, count)
        singular[s - 1] += weight / factorial(s - 1)
    regular[:start] = 0.0
    it = 1j * np.abs(t)
    log_t = np.log(np.abs(t), where=t != 0, out=np.zeros(t.shape))
    value = np.polynomial.polynomial.polyval(it, regular)
    value -= np.polynomial.polynomial.polyval(it, singular) * (log_t - 0.5j * pi)
    return np.where(t < 0, value.conj(), value)


@lru_cache
def _expansion(s: int, count: int) -> Array:
    """Return the coefficients of (it)^k in Li_s(e^it), but for the logarithm's."""
    B = bernoulli(count)
    B[1] = 0.5  # zeta(-m) = -B_(m+1)/(m+1), and zeta(0) = -1/2
    order = s - np.arange(count)
    at_negative = -B[np.maximum(1 - order, 0)] / np.maximum(1 - order, 1)
    regular = np.where(order > 1, zeta(np.maximum(order, 2.0)), at_negative)
    regular[s - 1] = sum(1 / j for j in range(1, s))
    return regular / np.array([float(factorial(k)) for k in range(count)])


def _fourier(c: Array, t: Array) -> Array:
    """Return the sum of c_n e^int over n = 1 ... N at points t, for (N,) coefficients.

    With n = k W + j, j = 1 ... W and W = sqrt(N), e^int = e^ikWt e^ijt: only 2 W exponentials are
    computed at each point.
    """
    W = ceil(sqrt(c.size))
    by_block = np.pad(c, (0, W**2 - c.size)).reshape(W, W)  # [k, j - 1]
    inner = np.exp(1j * np.multiply.outer(t, np.arange(1, W + 1)))
    outer = np.exp(1j * np.multiply.outer(t, W * np.arange(W)))
    return np.asarray(np.sum(outer * (inner @ by_block.T), axis=-1))
