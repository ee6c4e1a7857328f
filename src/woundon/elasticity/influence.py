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

import numpy as np

from .hat_integrals import (
    SourceRule,
    by_second_integral,
    gauss_rule_in_cells,
    singular_integrals,
)
from .kernels import Kernel, SurfaceKernels, singular, smooth_parts
from .lag import Lag
from .mesh import Face, cosine_nodes, hat_weights
from .quadrature import gauss_rule
from .surface import LinearSurface, SurfaceTangent

__all__ = ["InfluenceSurface"]

Array = np.ndarray
Smooth = Callable[[Array], Array]

# A function with poles at +-i l is interpolated on [-a, a] with an error of about
# exp(-rank asinh(l/a)), which is 2e-9 for rank = 20/asinh(l/a).
RANK_FACTOR, MIN_RANK, MAX_RANK = 20.0, 24, 600


class InfluenceSurface(LinearSurface):
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

    def __init__(
        self, kernels: SurfaceKernels, radius: float, curved: bool, face: Face, half_width: float
    ) -> None:
        self.kernels, self.face, self.a = kernels, face, half_width
        self.period = 2 * pi * radius if curved else inf
        self.max_distance = kernels.max_distance or self.period / 2

    def end_tangential_displacement(self, p: Array, q: Array) -> float:
        """Return u at the last node under nodal pressures and tractions, (n,) each [m]."""
        kernels = self.kernels
        tangent = kernels.tangent_p, kernels.tangent_q
        by_p, by_q = self._displacement(tangent, smooth_parts(tangent), -1)
        return float(by_p @ p + by_q @ q)

    def strain_outside(self, p: Array, q: Array, s: Array) -> Array:
        """Return the strain at positions s (k,) [m] along the surface, outside of the face."""
        outside = self.tangent_outside(s)
        return np.asarray(outside.strain_p @ p + outside.strain_q @ q)

    def tangent_outside(self, s: Array) -> SurfaceTangent:
        """Return the derivatives of slope and strain at positions s [m] outside, (k, n) each."""
        nodes = self.a * self.face.nodes
        return gradient_matrices(self.kernels, self.period, self.max_distance, nodes, s)

    @cached_property
    def _tangent(self) -> SurfaceTangent:  # type: ignore[override]
        """Influence matrices: the sums of the singular parts, the smooth parts and the lags."""
        n, a, face, kernels = self.face.nodes.size, self.a, self.face, self.kernels
        out: Array = (_factors(kernels.gradients, a) @ self._singular.reshape(4, -1)).reshape(
            4, n + 1, n
        )
        out += _log_factors(kernels.gradients, a)[:, None, None] * face.weights
        if kernels.smooth is not None:
            out += self._smooth_integrals(kernels.gradients, kernels.smooth)
        if self._is_unresolved:
            # replace the columns of the inner nodes by second differences of the second integrals
            for matrix, kernel in zip(out, kernels.gradients, strict=True):
                K = kernel.second_integral
                if K is not None:
                    exact = by_second_integral(K, None, a * face.points, a * face.nodes)
                    matrix[:, 1:-1] = exact[:, 1:-1]
        if kernels.lag is not None:
            out += _lag_integrals(kernels.lag, a * face.points, a * face.nodes)
        return SurfaceTangent(*out)

    @cached_property
    def _end(self) -> Array:  # type: ignore[override]
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
            out += self._integrals_at(kernels, smooth, point)[:, 0]
        for part, kernel in zip(out, kernels, strict=True):
            if kernel.lag is not None:
                part += _lag_integrals(kernel.lag, self.a * point, self.a * face.nodes)[0, 0]
        return out

    # ---- parts of the influence functions ------------------------------------------------------

    @cached_property
    def _singular(self) -> Array:
        """Integrals of 1/t, Dirac, ln|t| and sgn against the hats, (4, points, nodes)."""
        face = self.face
        if face.is_nip:
            return _nip_integrals(face.size)
        return singular_integrals(face.points, face.nodes)

    @cached_property
    def _rank(self) -> int:
        """Number of Chebyshev points that resolve the smooth parts over the nip."""
        return max(MIN_RANK, round(RANK_FACTOR / asinh(self.kernels.length / self.a)))

    @cached_property
    def _is_unresolved(self) -> bool:
        """True if the smooth parts vary too rapidly for polynomials."""
        return self._rank > min(MAX_RANK, 8 * (self.face.size - 1))

    @cached_property
    def _sources(self) -> list[tuple[slice, SourceRule]]:
        """Chebyshev points in the nip and Gauss points on the wraps, each with its nodes."""
        face, n, last = self.face, self.face.nodes.size, self.face.last
        if self._is_unresolved:
            return [self._gauss_rule(slice(0, n))]
        moments = self.a * _nip_interpolation(face.size, self._rank)[1]
        nip = slice(face.first, last + 1), SourceRule(_chebyshev_points(self._rank), moments)
        upstream = [self._gauss_rule(slice(0, face.first + 1))] if face.first else []
        downstream = [self._gauss_rule(slice(last, n))] if face.extends_downstream else []
        return [*upstream, nip, *downstream]

    def _gauss_rule(self, nodes: slice) -> tuple[slice, SourceRule]:
        """Return Gauss's rule in the cells between some nodes, after these nodes."""
        return nodes, gauss_rule_in_cells(self.face.nodes[nodes], self.a, self.kernels.length)

    def _smooth_integrals(self, kernels: tuple[Kernel, ...], smooth: Smooth) -> Array:
        """Return the integrals of smooth parts at all points of the face, (kernels, n+1, n).

        Those in the nip are interpolated between the Chebyshev points.
        """
        face, points, nip = self.face, self.face.points, self.face.nip_cells
        if self._is_unresolved:
            return self._integrals_at(kernels, smooth, points)
        at_points, _ = _nip_interpolation(face.size, self._rank)
        if face.is_nip:  # the edge included
            return at_points @ self._integrals_at(kernels, smooth, _chebyshev_points(self._rank))
        upstream, downstream = points[: nip.start], points[nip.stop :]
        targets = np.concatenate([upstream, _chebyshev_points(self._rank), downstream])
        out, stop = self._integrals_at(kernels, smooth, targets), nip.start + self._rank
        inside = at_points[: nip.stop - nip.start] @ out[:, nip.start : stop]
        return np.concatenate([out[:, : nip.start], inside, out[:, stop:]], axis=1)

    def _integrals_at(self, kernels: tuple[Kernel, ...], smooth: Smooth, targets: Array) -> Array:
        """Return the integrals of smooth parts at targets, (kernels, targets, n)."""
        sources = np.concatenate([rule.points for _, rule in self._sources])
        values, start = self._smooth_between(kernels, smooth, targets, sources), 0
        out = np.zeros((*values.shape[:2], self.face.nodes.size))
        for nodes, rule in self._sources:
            stop = start + rule.points.size
            out[..., nodes] += values[..., start:stop] @ rule.moments
            start = stop
        return out

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


def gradient_matrices(
    kernels: SurfaceKernels, period: float, max_distance: float, nodes: Array, s: Array
) -> SurfaceTangent:
    """Return slope and strain of a surface outside of a contact by nodal pressures and tractions.

    Singular parts are integrated in closed form, smooth ones by the trapezoidal rule: its error is
    of the order of that of the nodal loads.

    Parameters
    ----------
    kernels : SurfaceKernels
    period, max_distance : float
        Circumference, and the distance above which the shorter arc is used [m].
    nodes : (n,) array
        [m].
    s : (k,) array
        Positions along the surface [m], outside of the nodes or at their ends.

    Returns
    -------
    SurfaceTangent of (k, n) arrays
    """
    gradients, singular_parts = kernels.gradients, singular_integrals(s, nodes)
    out: Array = np.tensordot(_factors(gradients, 1.0), singular_parts, axes=1)
    if kernels.smooth is not None:
        t = s[:, None] - nodes
        on_longer_arc = np.abs(t) > max_distance
        t_short = np.where(on_longer_arc, t - np.sign(t) * period, t)
        values = kernels.smooth(t_short)
        values[:, on_longer_arc] += singular(gradients, t_short[on_longer_arc]) - singular(
            gradients, t[on_longer_arc]
        )
        out += values * hat_weights(np.diff(nodes))
    if kernels.lag is not None:
        out += _lag_integrals(kernels.lag, s, nodes)
    return SurfaceTangent(*out)


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
    s, weights = gauss_rule(8 + ceil(rank * pi / (size - 1) / 2))
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
