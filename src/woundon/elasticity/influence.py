r"""Surface response of a body by its influence functions.

Each of the influence functions of slope and strain (:class:`.kernels.SurfaceKernels`) is

    k(t) = inverse/t + delta Dirac(t) + log ln|t| + sign sgn(t) + lag(t) + smooth(t),   t = x - s.

The singular parts are integrated in closed form; in units of the half width a they depend on the
mesh only.  The lag of a viscoelastic surface is integrated by second differences of its second
integral.  The smooth part of a curved body varies on the length l of its layer.  Inside the nip it
is interpolated by polynomials in x and s at the Chebyshev points t_i,

    int smooth(a (y-s)) hat_m(s) a ds = sum_ij L_i(y) smooth(a (t_i-t_j)) int L_j(s) hat_m(s) a ds

and on a wrap it is integrated by Gauss's rule.  Where l is so short that the polynomials would have
more degrees of freedom than the mesh resolves, the second integral of the whole kernel serves.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property, lru_cache, partial
from math import asinh, ceil, inf, log, pi
from typing import NamedTuple

import numpy as np

from .hat_integrals import by_second_integral, gauss_points, singular_integrals
from .kernels import Kernel, SurfaceKernels, singular, smooth_parts
from .lag import Lag
from .mesh import Face, cosine_nodes
from .surface import Deformation, SurfaceTangent

__all__ = ["InfluenceSurface"]

Array = np.ndarray
Smooth = Callable[[Array], Array]

# A function with poles at +-i l is interpolated on [-a, a] with an error of about
# exp(-rank asinh(l/a)); rank = 20/asinh(l/a) leaves 2e-9 of its largest value.
DIGITS, LEAST_RANK, HIGHEST_RANK = 20.0, 24, 600


class SmoothParts(NamedTuple):
    """Points and sources between which smooth parts are evaluated.

    Attributes
    ----------
    targets, sources : (k,), (m,) arrays
        In units of a.
    to_points : (n+1, k) array
        Interpolates values at the targets at the points of the face.
    moments : (m, n) array
        Integrates values at the sources against the hats [m].
    """

    targets: Array
    sources: Array
    to_points: Array
    moments: Array


class InfluenceSurface:
    """The surface of a linear body on a face.

    Parameters
    ----------
    kernels : SurfaceKernels
    radius : float
        R [m].
    curved : bool
        Whether the influence functions are periodic around the circumference.
    face : Face
    half_width : float
        a [m].
    """

    rigid = False

    def __init__(
        self, kernels: SurfaceKernels, radius: float, curved: bool, face: Face, half_width: float
    ) -> None:
        self.kernels, self.face, self.a = kernels, face, half_width
        self.period = 2 * pi * radius if curved else inf
        self.reach = kernels.reach or self.period / 2

    # ---- values and derivatives ----------------------------------------------------------------

    def deform(self, p: Array, q: Array) -> Deformation:
        """Return the deformation, without assembling the matrices where they are not needed."""
        if "_matrices" in vars(self) or self.kernels.lag is not None or self._is_short:
            values = self._matrices @ np.array([p, q])[:, :, None]
            slope, strain = values[..., 0].sum(axis=1)
            return Deformation(slope, strain)
        loads = np.array([p, q]).T
        out = np.einsum("ijk,kpj->ip", self._factors, self._singular @ loads)
        out += (self._log_factors @ (self.face.weights @ loads))[:, None]
        if self._smooth_values is not None:
            parts = self._smooth_parts
            weighted = self._smooth_values @ (parts.moments @ loads).T[..., None]
            out += weighted[..., 0].sum(axis=1) @ parts.to_points.T
        return Deformation(out[0], out[1])

    def tangent(self, p: Array, q: Array) -> SurfaceTangent:
        """Return the influence matrices."""
        (slope_p, slope_q), (strain_p, strain_q) = self._matrices
        return SurfaceTangent(slope_p, slope_q, strain_p, strain_q)

    def end_displacement(self, p: Array, q: Array) -> float:
        """Return v at the trailing edge of the nip [m]."""
        return float(self._end[0] @ p + self._end[1] @ q)

    def end_tangent(self, p: Array, q: Array) -> tuple[Array, Array]:
        """Return the influence functions of v at the trailing edge."""
        return self._end[0], self._end[1]

    def end_tangential_displacement(self, p: Array, q: Array) -> float:
        """Return u at the last node [m]."""
        kernels = self.kernels
        both = kernels.tangent_p, kernels.tangent_q
        by_p, by_q = self._displacement(both, smooth_parts(both), -1)
        return float(by_p @ p + by_q @ q)

    def strain_outside(self, p: Array, q: Array, s: Array) -> Array:
        """Return the strain at positions s (k,) [m] along the surface, outside of the face."""
        nodes = self.a * self.face.nodes
        return surface_strain(self.kernels, self.period, self.reach, nodes, p, q, s)

    @cached_property
    def _matrices(self) -> Array:
        """Slope and strain by p and by q, (2, 2, n+1, n)."""
        n, a, face, kernels = self.face.nodes.size, self.a, self.face, self.kernels
        out: Array = (self._factors.reshape(4, 4) @ self._singular.reshape(4, -1)).reshape(
            2, 2, n + 1, n
        )
        out += self._log_factors[:, :, None, None] * face.weights
        if self._smooth_values is not None:
            parts = self._smooth_parts
            out += parts.to_points @ (self._smooth_values @ parts.moments)
        if self._is_short:
            for part, kernel in zip(out.reshape(4, n + 1, n), kernels.gradients, strict=True):
                if kernel.twice is None:
                    continue
                exact = by_second_integral(kernel.twice, None, a * face.points, a * face.nodes)
                part[:, 1:-1] = exact[:, 1:-1]
        if kernels.lag is not None:
            out += self._lag_integrals(kernels.lag, face.points).reshape(out.shape)
        return out

    @cached_property
    def _end(self) -> Array:
        """v at the trailing edge by p and by q, (2, n) [m/Pa]."""
        kernels = self.kernels
        return self._displacement((kernels.normal_p, kernels.normal_q), kernels.normal_smooth, -2)

    def _displacement(self, both: tuple[Kernel, Kernel], smooth: Smooth | None, k: int) -> Array:
        """Integrals of the influence functions of a displacement at point k of the face, (2, n)."""
        face, point = self.face, self.face.points[k, None]
        out = _factors(both, self.a) @ self._singular[:, k]
        out += _log_factors(both, self.a)[:, None] * face.weights
        if smooth is not None:
            parts = self._smooth_parts
            out += self._smooth_between(both, smooth, point, parts.sources)[:, 0] @ parts.moments
        for part, kernel in zip(out, both, strict=True):
            if kernel.lag is not None:
                part += self._lag_integrals(kernel.lag, point)[0, 0]
        return out

    # ---- parts of the influence functions ------------------------------------------------------

    @cached_property
    def _factors(self) -> Array:
        """Factors of the singular parts: (slope or strain, by p or q, part)."""
        return _factors(self.kernels.gradients, self.a).reshape(2, 2, 4)

    @cached_property
    def _log_factors(self) -> Array:
        """Factors of ln a in ln|a t| = ln|t| + ln a, (slope or strain, by p or q)."""
        return _log_factors(self.kernels.gradients, self.a).reshape(2, 2)

    @cached_property
    def _singular(self) -> Array:
        """Integrals of the singular parts, (4, points, nodes)."""
        face = self.face
        if face.is_nip:
            return _nip_integrals(face.size)
        return singular_integrals(face.points, face.nodes)

    def _lag_integrals(self, lag: Lag, points: Array) -> Array:
        """Integrals of the lags, (kernels, points, nodes)."""
        second, first = partial(_lag_second, lag), partial(lag.exactly, order=1)
        return by_second_integral(second, first, self.a * points, self.a * self.face.nodes)

    # ---- smooth parts --------------------------------------------------------------------------

    @cached_property
    def _rank(self) -> int:
        """Interpolation points that resolve the smooth parts over the nip."""
        return max(LEAST_RANK, round(DIGITS / asinh(self.kernels.length / self.a)))

    @cached_property
    def _is_short(self) -> bool:
        """True if the smooth parts vary too rapidly for polynomials."""
        return self._rank > min(HIGHEST_RANK, 8 * (self.face.size - 1))

    @cached_property
    def _smooth_values(self) -> Array | None:
        """Smooth parts between targets and sources, (2, 2, targets, sources)."""
        smooth = self.kernels.smooth
        if smooth is None:
            return None
        targets, sources, _, _ = self._smooth_parts
        values = self._smooth_between(self.kernels.gradients, smooth, targets, sources)
        return values.reshape(2, 2, targets.size, sources.size)

    @cached_property
    def _smooth_parts(self) -> SmoothParts:
        face, a, length = self.face, self.a, self.kernels.length
        points, nodes, cells = face.points, face.nodes, face.nip_cells
        if self._is_short:
            sources, moments = gauss_points(nodes, a, length)
            return SmoothParts(points, sources, np.eye(points.size), moments)
        rank = self._rank
        at_points, nip_moments = _nip_interpolation(face.size, rank)
        if face.is_nip:
            chebyshev = _chebyshev_points(rank)
            return SmoothParts(chebyshev, chebyshev, at_points, a * nip_moments)
        others = np.r_[0 : cells.start, cells.stop : points.size]
        to_points = np.zeros((points.size, rank + others.size))
        to_points[cells, :rank] = at_points[:-2]
        to_points[others, rank + np.arange(others.size)] = 1.0
        parts, weights = [_chebyshev_points(rank)], [np.zeros((rank, nodes.size))]
        weights[0][:, face.first : face.last + 1] = a * nip_moments
        for wrap in (slice(0, face.first + 1), slice(face.last, None)):
            if nodes[wrap].size > 1:
                at, hats = gauss_points(nodes[wrap], a, length)
                parts.append(at)
                weights.append(np.zeros((at.size, nodes.size)))
                weights[-1][:, wrap] = hats
        targets = np.append(_chebyshev_points(rank), points[others])
        return SmoothParts(targets, np.concatenate(parts), to_points, np.concatenate(weights))

    def _smooth_between(
        self, kernels: tuple[Kernel, ...], smooth: Smooth, points: Array, sources: Array
    ) -> Array:
        """Return smooth parts between points and sources, (kernels, points, sources).

        Beyond half the circumference the shorter way round counts.  The singular parts are
        integrated along the longer way there, so their difference belongs to the smooth part.
        """
        t = self.a * (points[:, None] - sources)
        if self.a * max(points[-1] - sources[0], sources[-1] - points[0]) <= self.reach and (
            self.face.is_nip
        ):
            return smooth(t)
        far = np.abs(t) > self.reach
        long = t[far]
        t[far] = short = long - np.sign(long) * self.period
        values = smooth(t)
        if long.size:
            values[:, far] += singular(kernels, short) - singular(kernels, long)
        return values


def surface_strain(
    kernels: SurfaceKernels,
    period: float,
    reach: float,
    nodes: Array,
    p: Array,
    q: Array,
    at: Array,
) -> Array:
    """Return the surface strain of a body outside of a contact.

    Parameters
    ----------
    kernels : SurfaceKernels
    period, reach : float
        Circumference, and the distance beyond which the shorter way round counts [m].
    nodes, p, q : (n,) arrays
        Nodes [m], pressures and tractions [Pa].
    at : (k,) array
        Positions along the surface [m], outside of the nodes or at their ends.

    Returns
    -------
    (k,) array
    """
    both, out = (kernels.strain_p, kernels.strain_q), np.zeros(at.size)
    singular_parts = singular_integrals(at, nodes)
    sources, hats = gauss_points(nodes, 1.0, kernels.length)
    t = at[:, None] - sources
    far = np.abs(t) > reach
    short = np.where(far, t - np.sign(t) * period, t)
    for kernel, load in zip(both, (p, q), strict=True):
        out += (_factors((kernel,), 1.0)[0] @ singular_parts.reshape(4, -1)).reshape(
            at.size, -1
        ) @ load
        if kernel.smooth is not None:
            values = kernel.smooth(short)
            values[far] += singular((kernel,), short[far])[0] - singular((kernel,), t[far])[0]
            out += values @ (hats @ load)
        lag = kernel.lag
        if lag is not None:
            out += (
                by_second_integral(
                    partial(_lag_second, lag), partial(lag.exactly, order=1), at, nodes
                )[0]
                @ load
            )
    return out


def _lag_second(lag: Lag, t: Array) -> Array:
    """Return the second integrals of lags at t."""
    return lag.twice(t < 0, np.log(np.maximum(np.abs(t), 1e-300)))


def _factors(kernels: tuple[Kernel, ...], a: float) -> Array:
    """Return the factors of the integrals of 1/t, Dirac, ln|t| and sgn in units of a."""
    return np.array([[k.inverse, k.delta, k.log * a, k.sign * a] for k in kernels])


def _log_factors(kernels: tuple[Kernel, ...], a: float) -> Array:
    return np.array([k.log for k in kernels]) * (a * log(a))


@lru_cache(maxsize=32)
def _nip_integrals(size: int) -> Array:
    """Integrals of the singular parts inside a nip without wraps, by its size only."""
    x = cosine_nodes(size)
    out = singular_integrals(np.append(x[1::2], [1.0, 1.0]), x[0::2])
    out.setflags(write=False)
    return out


@lru_cache(maxsize=64)
def _chebyshev_points(rank: int) -> Array:
    """Return the Chebyshev points of the first kind, increasing."""
    return -np.cos(np.pi * (2 * np.arange(rank) + 1) / (2 * rank))


@lru_cache(maxsize=64)
def _nip_interpolation(size: int, rank: int) -> tuple[Array, Array]:
    """Lagrange polynomials of the Chebyshev points in a nip, by its size.

    Returns
    -------
    (size+1, rank), (rank, size) arrays
        At the points of the face, and integrated against the hats in units of a.
    """
    chebyshev = np.polynomial.chebyshev.chebvander
    nodes = _chebyshev_points(rank)
    transform = np.cos(np.outer(np.arange(rank), np.arccos(nodes))) * (2 / rank)
    transform[0] /= 2
    x = cosine_nodes(size)
    s, w = np.polynomial.legendre.leggauss(8 + ceil(rank * pi / (size - 1) / 2))
    cells, part = np.diff(x[0::2]), (s + 1) / 2
    at = x[0:-2:2, None] + cells[:, None] * part
    lagrange = (chebyshev(at.ravel(), rank - 1) @ transform).reshape(*at.shape, rank)
    weighted = lagrange * (cells[:, None] * w / 2)[..., None]
    left, right = ((weighted * hat[:, None]).sum(axis=1).T for hat in (1 - part, part))
    moments = np.zeros((rank, size))
    moments[:, :-1] += left
    moments[:, 1:] += right
    at_points = np.append(x[1::2], [1.0, 1.0])
    return chebyshev(at_points, rank - 1) @ transform, moments
