r"""Stresses below the surface of a linear roll under given surface tractions, by Fourier harmonics.

The surface r = R of a half-plane or cylinder carries the pressure p(x) and the traction q(x) along
+x, x = R theta.  With r outward, z = R - r the depth, sigma_r the normal and tau = tau_rx the
shear stress on the surfaces z = const,

    sigma_r = -p,   tau = q         at z = 0.

The harmonics exp(i n x/R) of the stresses are linear in those of the tractions:

    [sigma_r]   R  [-B11   i B12] [p]
    [  tau  ] = -  [ i B21   B22] [q],        B real, the identity at z = 0.
                r

**Cylinder.**  B transfers (S, T) = (r sigma_r, r tau) of :mod:`.layers` from R to r.  With A and H
of the layers above r and the compliance Y of what lies below, w = Y t,

    t_r = A' t_R - H w_r    gives    B = (I + H Y)^-1 A'.

**Half-plane** (r = R in the factor R/r, k = n/R).  The stress function phi(r) exp(i k x) with
sigma_r = phi_xx, tau = -phi_xr fulfils compatibility if phi = exp(lambda k r) and

    c11 lambda^4 - (2 c12 + 1/G) lambda^2 + c22 = 0,

c11, c12, c22 the plane-strain compliances along, across and through the surface.  With the
mean m of the two roots with a positive real part, their product Pi and d^2 = m^2 - Pi,

    c = e^(-m xi) cosh(d xi),   s = e^(-m xi) sinh(d xi)/d,   xi = k z,

    B11 = c + m s,    B12 = s,    B21 = -Pi s,    B22 = c - m s.

In real space a line load P then gives the radial stress field of Lekhnitskii (Anisotropic plates,
1968, sec. 34),

    sigma_r = -(2 m Pi P/pi) z^3/N,   tau = (2 m Pi P/pi) x z^2/N,
    N = (x^2 + lambda_1^2 z^2)(x^2 + lambda_2^2 z^2).

For large n the cylinder's B tends to that of the half-plane of its outermost layer, at the depth
R ln(R/r).  The difference is interpolated between harmonics by a cubic spline of ln n.

The harmonics of the half-plane have the period 2 pi R.  The images of a tangential load Q add the
far field of tau, 2 m z Q/(pi x^2), at x = +- 2 pi R, +- 4 pi R, ..., which is subtracted,

    sum = 2 m z Q pi/(3 L^2),   L = 2 pi R;     other images cancel or fall faster.
"""

from __future__ import annotations

from cmath import sqrt as csqrt
from dataclasses import dataclass, replace
from math import ceil, log, log1p, pi, sqrt

import numpy as np

from .layers import Layers, traction_transfers
from .strip import compliance

__all__ = ["Section", "cylinder_sections", "half_plane_sections", "traction_harmonics"]

Array = np.ndarray
Stiffness = tuple[float | None, ...]  # A_rr, A_tt, A_rt, G, and optionally D

# The last harmonic is damped by exp(-DAMPING) at the depth of a section: 5e-5 of a line load, much
# less of tractions wider than the depth.  Close to the surface of thin webs on large rolls the sums
# end at MAX_HARMONICS; harmonics of tractions that vanish as a square root decrease as n^(-3/2).
DAMPING = 10.0
MIN_HARMONICS, MAX_HARMONICS = 64, 1 << 17
# Points per wavelength of the last harmonic, and fewest on the period: the largest stress on the
# grid is then within 0.1 % of that between the points.
POINTS_PER_WAVE, MIN_POINTS = 2, 4096
# Harmonics at which a cylinder is evaluated: every one up to this number, then with spacings of
# SPACING n.  The difference between cylinder and half-plane is a smooth function of ln n.
EVERY_HARMONIC_BELOW, SPACING = 32, 0.06
# Points of the polynomials that interpolate it, with an error of 1e-10 of the largest B; splines of
# SciPy take a quarter of a second to import.
POINTS = 6
# Relative difference of the roots below which they are taken as equal: the error is its square, and
# the difference quotient would lose as many digits.
EQUAL_ROOTS = 1e-5


@dataclass(frozen=True, eq=False)
class Section:
    """Stresses on a surface below that of the roll.

    Attributes
    ----------
    depth : float
        z [m].
    x : (n,) array
        Equidistant positions R theta around the roll, from -pi R [m].
    normal, shear : (n,) arrays
        sigma_r (compression < 0), and tau, exerted by the outer on the inner material along +x
        [Pa].
    """

    depth: float
    x: Array
    normal: Array
    shear: Array


def traction_harmonics(x: Array, f: Array, length: float, count: int) -> Array:
    """Return the integrals of f(x) exp(-2 pi i n x/length), n = 0 ... count.

    Parameters
    ----------
    x : (k,) array
        Nodes in ascending order.
    f : (..., k) array
        Values of piecewise linear functions, which are zero outside.
    length : float
        Period, in units of x.
    count : int

    Returns
    -------
    (..., count + 1) complex array

    Notes
    -----
    Integration by parts gives sums over the jumps of f at both ends and of its slope at the nodes.
    With n = m j + l, exp(-i n t) = exp(-i m j t) exp(-i l t), so that all sums are a product of two
    small matrices, of the high digits j and the low digits l.
    """
    slope = np.diff(f) / np.diff(x)
    slope_jumps = np.diff(slope, prepend=0.0, append=0.0)
    block = 1 << ceil(log(count + 1, 2) / 2)
    t = -2j * pi * x / length
    low_digits = np.exp(np.arange(block) * t[:, None])
    high_digits = np.exp(block * np.arange(-(-(count + 1) // block))[:, None] * t)

    def sums(jumps: Array, nodes: Array) -> Array:
        """Return the sums of jumps (..., m) at nodes (m,) times exp(-i n t), n = 1 ... count."""
        digits = (high_digits[:, nodes] * jumps[..., None, :]) @ low_digits[nodes]
        return digits.reshape(*jumps.shape[:-1], -1)[..., 1 : count + 1]

    # f jumps from zero up to f[0] at the first node, and from f[-1] down to zero at the last
    ends = np.array([0, -1])
    end_jumps = f[..., ends] * [1, -1]
    k = 2 * pi * np.arange(1, count + 1) / length
    out = np.empty((*f.shape[:-1], count + 1), dtype=complex)
    out[..., 0] = np.trapezoid(f, x)
    out[..., 1:] = -sums(slope_jumps, np.arange(x.size)) / k**2 - 1j * sums(end_jumps, ends) / k
    return out


@np.errstate(under="ignore")  # short waves vanish with depth
def half_plane_sections(
    x: Array, p: Array, q: Array, depths: Array, radius: float, stiffness: Stiffness
) -> tuple[Section, ...]:
    """Return the stresses in an orthotropic half-plane.

    Parameters
    ----------
    x, p, q : (k,) arrays
        Nodes [m], within one circumference, and piecewise linear tractions [Pa].
    depths : (m,) array
        z > 0 [m].
    radius : float
        R [m]: the stresses are returned for -pi R <= x < pi R.
    stiffness : (A_rr, A_tt, A_rt, G) or (A_rr, A_tt, A_rt, G, D)
        Plane-strain stiffness [Pa]; D as of :func:`.strip.stiffness_along`.

    Returns
    -------
    tuple of Section
        One for each depth.
    """
    roots, loads = _HalfPlaneRoots.of(stiffness), _SurfaceLoads(x, p, q, 2 * pi * radius)
    Q, sections = float(np.trapezoid(q, x)), []
    for z in depths.tolist():
        n = np.arange(loads.harmonics_needed(roots.slowest_decay * z) + 1)
        section = loads.section(z, roots.transfer(n * (z / radius)))
        # shear stress of the resultant Q in the neighbouring periods, the sum in the module header
        images = 2 * roots.mean * z * Q * pi / (3 * loads.period**2)
        sections.append(replace(section, shear=section.shear - images))
    return tuple(sections)


@np.errstate(under="ignore")  # short waves vanish with depth
def cylinder_sections(
    x: Array,
    p: Array,
    q: Array,
    depths: Array,
    radius: float,
    layers: Layers,
    open_bore: bool = False,
) -> tuple[Section, ...]:
    """Return the stresses in a cylinder of orthotropic layers on a core.

    Parameters
    ----------
    x, p, q : (k,) arrays
        Nodes [m], within one circumference, and piecewise linear tractions [Pa].
    depths : (m,) array
        z > 0 [m], above the core.
    radius : float
        R [m].
    layers : sequence of (depth, A_rr, A_tt, A_rt, G, D)
        As of :func:`.layers.stacked_compliance`.
    open_bore : bool
        True for an open bore, False for a rigid core.

    Returns
    -------
    tuple of Section
        One for each depth.
    """
    roots, loads = _HalfPlaneRoots.of(layers[0][1:]), _SurfaceLoads(x, p, q, 2 * pi * radius)
    y = -np.log1p(-np.asarray(depths) / radius)  # ln(R/r)
    counts = [loads.harmonics_needed(roots.slowest_decay * radius * each) for each in y.tolist()]
    # B of the cylinder is computed at the sampled harmonics only
    sampled = _sampled_harmonics(max(counts, default=MIN_HARMONICS))
    pieces, boundaries = _cut_layers(layers, y)
    cylinder = traction_transfers(sampled, pieces, open_bore)[boundaries]
    interpolation, sections = _Interpolation(sampled), []
    for k, (z, count) in enumerate(zip(depths.tolist(), counts, strict=True)):
        # B of the half-plane at all harmonics, plus its difference to B of the cylinder
        B = roots.transfer(np.arange(count + 1) * y[k])
        B += interpolation.values(cylinder[k] - roots.transfer(sampled * y[k]), count)
        sections.append(loads.section(z, B * (radius / (radius - z))))
    return tuple(sections)


def _sampled_harmonics(last: int) -> Array:
    """Return the harmonics, of 0 to the last, at which a cylinder is evaluated, (k,) int."""
    spaced = EVERY_HARMONIC_BELOW * np.exp(
        np.arange(0.0, log(max(last / EVERY_HARMONIC_BELOW, 1.0)), log1p(SPACING))
    )
    return np.unique(
        [*range(EVERY_HARMONIC_BELOW + 1), *np.rint(spaced).astype(int).tolist(), last]
    )


class _Interpolation:
    """Interpolation from sampled harmonics to all, by polynomials of ln n.

    Each value is that of the polynomial through the POINTS nearest sampled harmonics (Lagrange).

    Parameters
    ----------
    sampled : (k,) array of int
        Harmonics at which values are known, ascending from 0.
    """

    def __init__(self, sampled: Array) -> None:
        # n = 0 has no logarithm: its value is not interpolated
        x, targets = np.log(sampled[1:]), np.log(np.arange(1, sampled[-1] + 1))
        first = np.searchsorted(x, targets) - POINTS // 2
        self.stencil = np.clip(first, 0, x.size - POINTS) + np.arange(POINTS)[:, None]
        distance = targets - x[self.stencil]
        self.weights = np.empty_like(distance)
        for k in range(POINTS):
            others = np.delete(np.arange(POINTS), k)
            gaps = x[self.stencil[k]] - x[self.stencil[others]]
            self.weights[k] = np.prod(distance[others] / gaps, axis=0)

    def values(self, samples: Array, last: int) -> Array:
        """Return the values at the harmonics 0 to the last one, (2, 2, last + 1).

        ``samples`` are those at the sampled harmonics, (2, 2, k).
        """
        out = np.zeros((2, 2, last + 1))
        out[..., 0] = samples[..., 0]
        for stencil, weights in zip(self.stencil[:, :last], self.weights[:, :last], strict=True):
            out[..., 1:] += weights * samples[..., 1:].take(stencil, axis=-1)
        return out


def _cut_layers(layers: Layers, depths: Array) -> tuple[Layers, Array]:
    """Divide layers at depths ln(R/r), (m,), and return the number of the boundary at each depth.

    Boundaries are those between the layers that are returned, counted from the surface.
    """
    lower_edges = np.cumsum([float(layer[0] or 0.0) for layer in layers])
    cuts = np.union1d(depths, lower_edges[:-1])
    edges = np.concatenate([[0.0], cuts, lower_edges[-1:]])
    layer_of_piece = np.searchsorted(lower_edges, (edges[1:] + edges[:-1]) / 2)
    pieces = tuple(
        (thickness, *layers[k][1:])
        for thickness, k in zip(np.diff(edges).tolist(), layer_of_piece.tolist(), strict=True)
    )
    return pieces, np.searchsorted(cuts, depths)


@dataclass(frozen=True)
class _HalfPlaneRoots:
    """The roots lambda_1,2 = m +- d of the half-plane: m, their product Pi, and d."""

    mean: float
    product: float
    half_difference: complex

    @classmethod
    def of(cls, stiffness: Stiffness) -> _HalfPlaneRoots:
        """Compute the roots from the plane-strain stiffness."""
        A_rr, A_tt, A_rt, G = (float(value or 0.0) for value in stiffness[:4])
        c11, c12, c22 = compliance(A_rr, A_tt, A_rt, *stiffness[4:])
        product = sqrt(c22 / c11)
        mean = sqrt((2 * c12 + 1 / G) / c11 + 2 * product) / 2
        d = csqrt(mean**2 - product)
        return cls(mean, product, d if d.imag else d.real)  # real exponentials are faster

    @property
    def slowest_decay(self) -> float:
        """Smaller real part of the two roots: harmonics decay as exp(-slowest k z)."""
        # Pi over the larger root, because m - d would cancel
        larger = self.mean + self.half_difference.real
        return self.mean if self.half_difference.real == 0 else self.product / larger

    def transfer(self, xi: Array) -> Array:
        """Return B at xi = n z/R, (2, 2, n)."""
        m, d, product = self.mean, self.half_difference, self.product
        if abs(d) < EQUAL_ROOTS * m:  # the limit d = 0
            c = np.exp(-m * xi)
            s = xi * c
        else:
            root_2 = product / (m + d)  # m - d without cancellation
            decay_1, decay_2 = np.exp(-(m + d) * xi), np.exp(-root_2 * xi)
            c, s = (decay_1 + decay_2).real / 2, ((decay_2 - decay_1) / (2 * d)).real
        return np.array([[c + m * s, s], [-product * s, c - m * s]])


class _SurfaceLoads:
    """The Fourier coefficients of the tractions on a period.

    Parameters
    ----------
    x, p, q : (k,) arrays
        Nodes [m], and piecewise linear tractions [Pa].
    period : float
        Circumference [m].
    """

    def __init__(self, x: Array, p: Array, q: Array, period: float) -> None:
        self.x, self.tractions, self.period = x, np.array([p, q]), period
        self._harmonics = np.zeros((2, 0), dtype=complex)

    def harmonics_needed(self, damping: float) -> int:
        """Return the number of harmonics, from their decay exp(-2 pi n damping/period).

        ``damping`` is the depth times the rate of decay [m].
        """
        needed = ceil(DAMPING * self.period / (2 * pi * damping))
        return min(max(needed, MIN_HARMONICS), MAX_HARMONICS)

    def section(self, depth: float, B: Array) -> Section:
        """Return the stresses on one surface from the transfer B, (2, 2, n), of all harmonics."""
        count = B.shape[-1] - 1
        if count >= self._harmonics.shape[1]:
            self._harmonics = traction_harmonics(self.x, self.tractions, self.period, count)
        p, q = self._harmonics[:, : count + 1]
        size = max(POINTS_PER_WAVE << ceil(log(count, 2)), MIN_POINTS)
        x = self.period * (np.arange(size) / size - 0.5)
        # the transforms begin at x = 0: np.roll moves them to x = -period/2
        normal, shear = (
            np.roll(np.fft.irfft(harmonics, size) * (size / self.period), size // 2)
            for harmonics in (-B[0, 0] * p + 1j * B[0, 1] * q, 1j * B[1, 0] * p + B[1, 1] * q)
        )
        return Section(depth, x, normal, shear)
