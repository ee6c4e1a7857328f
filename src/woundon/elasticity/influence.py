r"""Surface response of a body by its influence functions.

Each of the influence functions of slope and strain (:class:`.kernels.SurfaceKernels`) is

    k(t) = inverse/t + delta Dirac(t) + log ln|t| + sign sgn(t) + lag(t) + smooth(t),   t = x - s.

Slope and strain at x are the integrals of k(x - s) times the pressure and traction, which are sums
of nodal hat functions.  The singular parts are integrated in closed form; in units of the half
width a they depend on the mesh only.  The lag of a viscoelastic surface is integrated by second
differences of its second integral.  The smooth part of a curved body varies on a length l, such as
the thickness of its outermost layer.  Inside the nip it is interpolated by polynomials in x and s
at the Chebyshev points t_i,

    int smooth(a (y-s)) hat_m(s) a ds = sum_ij L_i(y) smooth(a (t_i-t_j)) int L_j(s) hat_m(s) a ds

and on a wrap it is integrated by Gauss's rule.  If l is so short that the polynomials would have
more degrees of freedom than the mesh resolves, second differences of the second integral of the
complete influence function are used instead.
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
# exp(-rank asinh(l/a)), which is 2e-9 for rank = 20/asinh(l/a).
RANK_FACTOR, MIN_RANK, MAX_RANK = 20.0, 24, 600


class SmoothParts(NamedTuple):
    """Low-rank integration of the smooth parts: to_points @ smooth(targets, sources) @ moments.

    Attributes
    ----------
    targets, sources : (k,), (m,) arrays
        In units of a.
    to_points : (n+1, k) array
        Interpolation matrix from the targets to the points of the face.
    moments : (m, n) array
        Integrals against the hat functions of a function given at the sources [m].
    """

    targets: Array
    sources: Array
    to_points: Array
    moments: Array


class InfluenceSurface:
    """The :class:`.surface.SurfaceResponse` of a linear body with known influence functions.

    Parameters
    ----------
    kernels : SurfaceKernels
    radius : float
        R [m].
    curved : bool
        True if the influence functions are periodic around the circumference.
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
        self.max_distance = kernels.max_distance or self.period / 2

    # ---- values and derivatives ----------------------------------------------------------------

    def deform(self, p: Array, q: Array) -> Deformation:
        """Return slopes and strains at the points of the face, (n+1,) each.

        The influence matrices are not formed for this, unless they exist already or are needed: for
        a viscoelastic surface, and for smooth parts that polynomials do not resolve.

        Parameters
        ----------
        p, q : (n,) arrays
            Nodal pressures and tractions [Pa].
        """
        if "_matrices" in vars(self) or self.kernels.lag is not None or self._is_unresolved:
            values = self._matrices @ np.array([p, q])[:, :, None]
            slope, strain = values[..., 0].sum(axis=1)
            return Deformation(slope, strain)
        # products with the loads first: singular parts, ln a, then the low-rank smooth parts
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
        return float(self._end_values[0] @ p + self._end_values[1] @ q)

    def end_tangent(self, p: Array, q: Array) -> tuple[Array, Array]:
        """Return the influence functions of v at the trailing edge."""
        return self._end_values[0], self._end_values[1]

    def end_tangential_displacement(self, p: Array, q: Array) -> float:
        """Return u at the last node [m]."""
        kernels = self.kernels
        tangent = kernels.tangent_p, kernels.tangent_q
        by_p, by_q = self._displacement(tangent, smooth_parts(tangent), -1)
        return float(by_p @ p + by_q @ q)

    def strain_outside(self, p: Array, q: Array, s: Array) -> Array:
        """Return the strain at positions s (k,) [m] along the surface, outside of the face."""
        nodes = self.a * self.face.nodes
        return surface_strain(self.kernels, self.period, self.max_distance, nodes, p, q, s)

    @cached_property
    def _matrices(self) -> Array:
        """Influence matrices: (slope or strain, by p or q, n+1, n) [1/Pa].

        The sum of the singular parts, the smooth parts and the lags.
        """
        n, a, face, kernels = self.face.nodes.size, self.a, self.face, self.kernels
        out: Array = (self._factors.reshape(4, 4) @ self._singular.reshape(4, -1)).reshape(
            2, 2, n + 1, n
        )
        out += self._log_factors[:, :, None, None] * face.weights
        if self._smooth_values is not None:
            parts = self._smooth_parts
            out += parts.to_points @ (self._smooth_values @ parts.moments)
        if self._is_unresolved:
            # replace the columns of the inner nodes by second differences of the second integrals
            for matrix, kernel in zip(out.reshape(4, n + 1, n), kernels.gradients, strict=True):
                K = kernel.second_integral
                if K is not None:
                    exact = by_second_integral(K, None, a * face.points, a * face.nodes)
                    matrix[:, 1:-1] = exact[:, 1:-1]
        if kernels.lag is not None:
            out += _lag_integrals(kernels.lag, a * face.points, a * face.nodes).reshape(out.shape)
        return out

    @cached_property
    def _end_values(self) -> Array:
        """v at the trailing edge by p and by q, (2, n) [m/Pa]."""
        kernels = self.kernels
        return self._displacement((kernels.normal_p, kernels.normal_q), kernels.normal_smooth, -2)

    def _displacement(self, kernels: tuple[Kernel, Kernel], smooth: Smooth | None, k: int) -> Array:
        """Return a displacement at one point by nodal pressures p and tractions q, (2, n) [m/Pa].

        Parameters
        ----------
        kernels : (Kernel, Kernel)
            Influence functions of this displacement by p and by q.
        smooth : callable or None
            t -> their smooth parts, (2, *t.shape); None for a half-plane.
        k : int
            Number of the point among those of the face.
        """
        face, point = self.face, self.face.points[k, None]
        out = _factors(kernels, self.a) @ self._singular[:, k]
        out += _log_factors(kernels, self.a)[:, None] * face.weights
        if smooth is not None:
            parts = self._smooth_parts
            values = self._smooth_between(kernels, smooth, point, parts.sources)
            out += values[:, 0] @ parts.moments
        for part, kernel in zip(out, kernels, strict=True):
            if kernel.lag is not None:
                part += _lag_integrals(kernel.lag, self.a * point, self.a * face.nodes)[0, 0]
        return out

    # ---- parts of the influence functions ------------------------------------------------------

    @cached_property
    def _factors(self) -> Array:
        """Coefficients of 1/t, Dirac, ln|t| and sgn: (slope or strain, by p or q, part)."""
        return _factors(self.kernels.gradients, self.a).reshape(2, 2, 4)

    @cached_property
    def _log_factors(self) -> Array:
        """Coefficients of ln a in ln|a t| = ln|t| + ln a, (slope or strain, by p or q)."""
        return _log_factors(self.kernels.gradients, self.a).reshape(2, 2)

    @cached_property
    def _singular(self) -> Array:
        """Integrals of 1/t, Dirac, ln|t| and sgn against the hats, (4, points, nodes)."""
        face = self.face
        if face.is_nip:
            return _nip_integrals(face.size)
        return singular_integrals(face.points, face.nodes)

    # ---- smooth parts --------------------------------------------------------------------------

    @cached_property
    def _rank(self) -> int:
        """Number of Chebyshev points that resolve the smooth parts over the nip."""
        return max(MIN_RANK, round(RANK_FACTOR / asinh(self.kernels.length / self.a)))

    @cached_property
    def _is_unresolved(self) -> bool:
        """True if the smooth parts vary too rapidly for polynomials."""
        return self._rank > min(MAX_RANK, 8 * (self.face.size - 1))

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
        """Targets and sources of the smooth parts, with interpolation and integration.

        Both are the Chebyshev points in the nip; on the wraps the targets are the points of the
        face, and the sources Gauss points.
        """
        face, a, length = self.face, self.a, self.kernels.length
        points, nodes, cells = face.points, face.nodes, face.nip_cells
        if self._is_unresolved:
            gauss, hats = gauss_points(nodes, a, length)
            return SmoothParts(points, gauss, np.eye(points.size), hats)
        rank, chebyshev = self._rank, _chebyshev_points(self._rank)
        at_points, nip_moments = _nip_interpolation(face.size, rank)
        if face.is_nip:
            return SmoothParts(chebyshev, chebyshev, at_points, a * nip_moments)
        # rows: points in the nip interpolate the Chebyshev points, others are targets themselves
        on_wraps = np.r_[0 : cells.start, cells.stop : points.size]
        to_points = np.zeros((points.size, rank + on_wraps.size))
        to_points[cells, :rank] = at_points[:-2]
        to_points[on_wraps, rank + np.arange(on_wraps.size)] = 1.0
        sources, moments = [chebyshev], [np.zeros((rank, nodes.size))]
        moments[0][:, face.first : face.last + 1] = a * nip_moments
        for wrap in (slice(0, face.first + 1), slice(face.last, None)):
            if nodes[wrap].size > 1:
                gauss, hats = gauss_points(nodes[wrap], a, length)
                sources.append(gauss)
                moments.append(np.zeros((gauss.size, nodes.size)))
                moments[-1][:, wrap] = hats
        targets = np.append(chebyshev, points[on_wraps])
        return SmoothParts(targets, np.concatenate(sources), to_points, np.concatenate(moments))

    def _smooth_between(
        self, kernels: tuple[Kernel, ...], smooth: Smooth, points: Array, sources: Array
    ) -> Array:
        """Return smooth parts between points and sources, (kernels, points, sources).

        At distances above half the circumference the smooth part is that of the shorter arc.  The
        singular parts are integrated over the longer arc; their difference is added here.
        """
        t = self.a * (points[:, None] - sources)
        longest = self.a * max(points[-1] - sources[0], sources[-1] - points[0])
        if self.face.is_nip and longest <= self.max_distance:
            return smooth(t)
        on_longer_arc = np.abs(t) > self.max_distance
        t_long = t[on_longer_arc]
        t[on_longer_arc] = t_short = t_long - np.sign(t_long) * self.period
        values = smooth(t)
        if t_long.size:
            values[:, on_longer_arc] += singular(kernels, t_short) - singular(kernels, t_long)
        return values


def surface_strain(
    kernels: SurfaceKernels,
    period: float,
    max_distance: float,
    nodes: Array,
    p: Array,
    q: Array,
    s: Array,
) -> Array:
    """Return the surface strain of a body outside of a contact.

    Parameters
    ----------
    kernels : SurfaceKernels
    period, max_distance : float
        Circumference, and the distance above which the shorter arc is used [m].
    nodes, p, q : (n,) arrays
        Nodes [m], pressures and tractions [Pa].
    s : (k,) array
        Positions along the surface [m], outside of the nodes or at their ends.

    Returns
    -------
    (k,) array
    """
    out, singular_parts = np.zeros(s.size), singular_integrals(s, nodes)
    sources, hats = gauss_points(nodes, 1.0, kernels.length)
    t = s[:, None] - sources
    on_longer_arc = np.abs(t) > max_distance
    t_short = np.where(on_longer_arc, t - np.sign(t) * period, t)
    for kernel, load in ((kernels.strain_p, p), (kernels.strain_q, q)):
        out += np.tensordot(_factors((kernel,), 1.0)[0], singular_parts, axes=1) @ load
        if kernel.smooth is not None:
            values = kernel.smooth(t_short)
            values[on_longer_arc] += (
                singular((kernel,), t_short[on_longer_arc])[0]
                - singular((kernel,), t[on_longer_arc])[0]
            )
            out += values @ (hats @ load)
        if kernel.lag is not None:
            out += _lag_integrals(kernel.lag, s, nodes)[0] @ load
    return out


def _lag_integrals(lag: Lag, points: Array, nodes: Array) -> Array:
    """Return the integrals of lags against the hat functions, (kernels, points, nodes)."""

    def second_integral(t: Array) -> Array:
        """Return the second integrals of the lags at t."""
        return lag.second_integral(t < 0, np.log(np.maximum(np.abs(t), 1e-300)))

    return by_second_integral(second_integral, partial(lag.evaluate, order=1), points, nodes)


def _factors(kernels: tuple[Kernel, ...], a: float) -> Array:
    """Return the coefficients of the integrals of 1/t, Dirac, ln|t| and sgn, (kernels, 4).

    The integrals are in units of the half width ``a`` [m]; those of ln|t| and sgn are proportional
    to it.
    """
    return np.array([[k.inverse, k.delta, k.log * a, k.sign * a] for k in kernels])


def _log_factors(kernels: tuple[Kernel, ...], a: float) -> Array:
    """Return the coefficients of ln a in ln|a t| = ln|t| + ln a, (kernels,), ``a`` in metres."""
    return np.array([k.log for k in kernels]) * (a * log(a))


@lru_cache(maxsize=32)
def _nip_integrals(size: int) -> Array:
    """Return the integrals of the singular parts in a nip without wraps, (4, size, size)."""
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
    """Return values and moments of the Lagrange polynomials of the Chebyshev points in a nip.

    Returns
    -------
    (size+1, rank), (rank, size) arrays
        Values at the points of the face, and integrals against the hat functions in units of a.
    """
    chebyshev = np.polynomial.chebyshev.chebvander
    nodes = _chebyshev_points(rank)
    # values at the Chebyshev points -> coefficients of the Chebyshev polynomials
    transform = np.cos(np.outer(np.arange(rank), np.arccos(nodes))) * (2 / rank)
    transform[0] /= 2
    x = cosine_nodes(size)
    s, weights = np.polynomial.legendre.leggauss(8 + ceil(rank * pi / (size - 1) / 2))
    cells, fraction = np.diff(x[0::2]), (s + 1) / 2
    gauss = x[0:-2:2, None] + cells[:, None] * fraction
    lagrange = (chebyshev(gauss.ravel(), rank - 1) @ transform).reshape(*gauss.shape, rank)
    weighted = lagrange * (cells[:, None] * weights / 2)[..., None]
    # against the halves of the hat functions of the left and of the right node of each cell
    left, right = ((weighted * hat[:, None]).sum(axis=1).T for hat in (1 - fraction, fraction))
    moments = np.zeros((rank, size))
    moments[:, :-1] += left
    moments[:, 1:] += right
    at_points = np.append(x[1::2], [1.0, 1.0])
    return chebyshev(at_points, rank - 1) @ transform, moments
