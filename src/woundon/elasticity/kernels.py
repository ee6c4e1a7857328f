"""The surface response of a body to line loads, taken apart by singularity.

A body's surface is loaded at s by a line load of unit pressure (``p``) or unit tangential traction
along +x (``q``), each 1 N/m.  At the distance t = x - s along the surface it moves by v (outward)
and u (along +x); its slope is dv/dx and its surface strain eps.  Each of these eight influence
functions is a sum

    k(t) = inverse / t  +  delta * Dirac(t)  +  log * ln|t|  +  sign * sgn(t)  +  lag  +  smooth(t)

whose first parts are integrated in closed form against the traction elements and whose smooth rest
is integrated by interpolation.  The lag is that of a viscoelastic surface, zero for an elastic one.
The half-plane has no smooth rest.  A curved body's rest is smooth on either side of t = 0 and
bounded; at t = 0 it has a kink |t|, t ln|t| or weaker.
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
    """One influence function; the coefficients' units follow from the quantity (per N/m).

    ``twice`` is a second integral of it, K with K'' = k, whatever its constant and line; singular
    parts are included but for the lag, where one is known.  ``lag`` is what the past of a
    viscoelastic surface adds.
    """

    inverse: float = 0.0
    delta: float = 0.0
    log: float = 0.0
    sign: float = 0.0
    smooth: Callable[[Array], Array] | None = None
    twice: Callable[[Array], Array] | None = None
    lag: Any = None  # a Lag

    def singular(self, t: Array) -> Array:
        """Return the singular parts and the lag at t (k,), t != 0."""
        return np.asarray(singular((self,), t)[0])


@dataclass(frozen=True, slots=True)
class SurfaceKernels:
    """The eight influence functions of a surface, ``<quantity>_<load>``.

    A curved body's hold up to their reach; beyond half the circumference the way round is shorter.

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
        Length on which the smooth parts vary [m]: they behave as functions with poles at
        t = +- i length.  Polynomials interpolating them in x and s on [-a, a] need a degree of
        about 20/asinh(length/a) to leave 1e-5 of the leading part.
    truncation_error : float
        Estimated error of the summed series relative to the half-plane coefficients.
    terms : int
        Number of Fourier terms summed; 0 where there is no series.
    together : callable, optional
        t -> the smooth parts of ``gradients``, (4, *t.shape), where quicker than one by one.
    normal_together : callable, optional
        t -> those of ``normal_p`` and ``normal_q``, (2, *t.shape), alike.
    lag : Lag, optional
        The lags of ``gradients`` together.
    reach : float, optional
        Largest |t| for which the smooth parts hold [m]; half the circumference without.
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
    together: Callable[[Array], Array] | None = None
    lag: Any = None  # a Lag
    normal_together: Callable[[Array], Array] | None = None
    reach: float | None = None

    @property
    def gradients(self) -> tuple[Kernel, Kernel, Kernel, Kernel]:
        """The kernels of slope and strain, which the nip's equations are made of."""
        return self.slope_p, self.slope_q, self.strain_p, self.strain_q

    @property
    def smooth(self) -> Callable[[Array], Array] | None:
        """The smooth parts of ``gradients``, t -> (4, *t.shape); None where there are none."""
        if self.together is not None:
            return self.together
        return smooth_parts(self.gradients)

    @property
    def normal_smooth(self) -> Callable[[Array], Array] | None:
        """Those of ``normal_p`` and ``normal_q``, t -> (2, *t.shape)."""
        return self.normal_together or smooth_parts((self.normal_p, self.normal_q))


def singular(kernels: Sequence[Kernel], t: Array) -> Array:
    """Return the singular parts and the lags of some kernels at t (k,), t != 0, (kernels, k)."""
    factors = np.array([[kernel.inverse, kernel.log, kernel.sign] for kernel in kernels])
    values: Array = factors @ np.array([1 / t, np.log(np.abs(t)), np.sign(t)])
    for value, kernel in zip(values, kernels, strict=True):
        if kernel.lag is not None:
            value += kernel.lag.exactly(t, 2)[0]
    return values


def smooth_parts(kernels: Sequence[Kernel]) -> Callable[[Array], Array] | None:
    """Return the smooth parts of some kernels as one function; None where there are none."""
    parts = [kernel.smooth for kernel in kernels]
    if not any(parts):
        return None
    return lambda t: np.array([np.zeros(t.shape) if f is None else f(t) for f in parts])
