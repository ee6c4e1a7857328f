"""Influence functions: the surface response of a body to line loads, split by singularity.

A body's surface is loaded at s by a line load of unit pressure (``p``) or unit tangential traction
along +x (``q``), each 1 N/m.  At the distance t = x - s along the surface it moves by v (outward)
and u (along +x); its slope is dv/dx and its surface strain eps.  Each of these eight influence
functions is a sum

    k(t) = inverse / t  +  delta * Dirac(t)  +  log * ln|t|  +  sign * sgn(t)  +  lag  +  smooth(t)

The singular parts are integrated in closed form against the traction elements, the smooth part by
interpolation.  The lag is the delayed response of a viscoelastic surface, zero for an elastic one.
The half-plane has no smooth part.  That of a curved body is bounded, and smooth on either side of
t = 0; at t = 0 it has a kink |t|, t ln|t| or weaker.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

__all__ = ["Kernel", "SurfaceKernels", "singular", "smooth_parts"]

Array = np.ndarray


@dataclass(frozen=True, slots=True)
class Kernel:
    """One influence function k(t), per N/m; see the sum above.

    Attributes
    ----------
    inverse, delta, log, sign : float
        Coefficients of the singular parts.
    smooth : callable, optional
        t -> smooth part.
    second_integral : callable, optional
        t -> K(t), K'' = k, of the singular and smooth parts without the lag; the constant and the
        linear term of K are arbitrary.
    lag : Lag, optional
        Delayed response of a viscoelastic surface.
    """

    inverse: float = 0.0
    delta: float = 0.0
    log: float = 0.0
    sign: float = 0.0
    smooth: Callable[[Array], Array] | None = None
    second_integral: Callable[[Array], Array] | None = None
    lag: Any = None  # a Lag

    def singular(self, t: Array) -> Array:
        """Return the singular parts and the lag at t (k,), t != 0: no Dirac pulse."""
        return np.asarray(singular((self,), t)[0])


@dataclass(frozen=True, slots=True)
class SurfaceKernels:
    """The eight influence functions of a surface, ``<quantity>_<load>``.

    Those of a curved body are periodic in t with its circumference.

    Attributes
    ----------
    normal_p, normal_q : Kernel
        Outward normal displacement v [m per N/m].
    tangent_p, tangent_q : Kernel
        Tangential displacement u along +x [m per N/m].
    slope_p, slope_q : Kernel
        dv/dx [1 per N/m].
    strain_p, strain_q : Kernel
        Tangential surface strain; v/R + du/dx on a cylinder, du/dx on a half-plane [1 per N/m].
    uniform_strain : float
        Strain under a uniform pressure of 1 Pa on the whole circumference or half-plane [1/Pa].
    length : float
        Length scale of the smooth parts [m]: they behave as functions with poles at
        t = +- i length.  Their polynomial interpolation in x and s on [-a, a] needs a degree of
        about 20/asinh(length/a) for an error of 1e-5 of the leading part.
    truncation_error : float
        Estimated error of the summed series relative to the half-plane coefficients.
    terms : int
        Number of Fourier terms summed; 0 where there is no series.
    smooth_gradients : callable, optional
        t -> the smooth parts of ``gradients``, (4, *t.shape), from a common table.
    smooth_normals : callable, optional
        t -> the smooth parts of ``normal_p`` and ``normal_q``, (2, *t.shape).
    lag : Lag, optional
        The lags of ``gradients``.
    max_distance : float, optional
        Largest |t| at which the smooth parts are defined [m]; by default half the circumference.
    """

    normal_p: Kernel = field(default_factory=Kernel)
    normal_q: Kernel = field(default_factory=Kernel)
    tangent_p: Kernel = field(default_factory=Kernel)
    tangent_q: Kernel = field(default_factory=Kernel)
    slope_p: Kernel = field(default_factory=Kernel)
    slope_q: Kernel = field(default_factory=Kernel)
    strain_p: Kernel = field(default_factory=Kernel)
    strain_q: Kernel = field(default_factory=Kernel)
    uniform_strain: float = 0.0
    length: float = np.inf
    truncation_error: float = 0.0
    terms: int = 0
    smooth_gradients: Callable[[Array], Array] | None = None
    lag: Any = None  # a Lag
    smooth_normals: Callable[[Array], Array] | None = None
    max_distance: float | None = None

    @property
    def gradients(self) -> tuple[Kernel, Kernel, Kernel, Kernel]:
        """The influence functions of slope and strain."""
        return self.slope_p, self.slope_q, self.strain_p, self.strain_q

    @property
    def smooth(self) -> Callable[[Array], Array] | None:
        """The smooth parts of ``gradients``, t -> (4, *t.shape); None for a half-plane."""
        if self.smooth_gradients is not None:
            return self.smooth_gradients
        return smooth_parts(self.gradients)

    @property
    def normal_smooth(self) -> Callable[[Array], Array] | None:
        """The smooth parts of ``normal_p`` and ``normal_q``, t -> (2, *t.shape), or None."""
        return self.smooth_normals or smooth_parts((self.normal_p, self.normal_q))


def singular(kernels: Sequence[Kernel], t: Array) -> Array:
    """Return the singular parts and the lags of kernels at t (k,), t != 0, (kernels, k)."""
    factors = np.array([[kernel.inverse, kernel.log, kernel.sign] for kernel in kernels])
    values: Array = factors @ np.array([1 / t, np.log(np.abs(t)), np.sign(t)])
    for value, kernel in zip(values, kernels, strict=True):
        if kernel.lag is not None:
            # the kernel is the second derivative of the lag's second integral
            value += kernel.lag.evaluate(t, order=2)[0]
    return values


def smooth_parts(kernels: Sequence[Kernel]) -> Callable[[Array], Array] | None:
    """Return the smooth parts as a function t -> (kernels, *t.shape); None if no kernel has one."""
    parts = [kernel.smooth for kernel in kernels]
    if not any(parts):
        return None
    return lambda t: np.array([np.zeros(t.shape) if f is None else f(t) for f in parts])
