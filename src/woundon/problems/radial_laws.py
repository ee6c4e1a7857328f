"""Radial laws of stacks: the tangent modulus E_r(P) of paper and film pressed by P through it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache, cached_property
from itertools import pairwise
from math import exp, inf, isfinite, log
from typing import TYPE_CHECKING, Annotated, Any, Self

import numpy as np
from numpy.polynomial import polynomial
from pydantic import BeforeValidator, Field, SerializeAsAny, field_validator, model_validator

from ..errors import InvalidProblem
from ..quantities import pure, strain, stress
from .family import Family
from .fields import Number, Numbers
from .materials import SOFTEST, STIFFEST
from .messages import quote

if TYPE_CHECKING:
    from scipy.interpolate import BSpline

    from .fields import CoercedField

# SciPy is imported where it is used: problems are read and written without it

__all__ = [
    "AnyLaw",
    "AnySolidLaw",
    "Constant",
    "Pfeiffer",
    "Polynomial",
    "PowerLaw",
    "RadialLaw",
    "SolidLaw",
    "StackTest",
]

Array = np.ndarray

# of the modulus without pressure; a law goes no lower, neither in tension nor where it softens
FLOOR = 0.01


class RadialLaw(Family):
    """The tangent modulus E_r(P) of a stack pressed by P: an open set.

    A member says ``_modulus``, ``_slope`` and ``_strain`` for 0 <= P <= ``highest``.  Beyond both
    ends the law goes on smoothly enough for an iteration that tries states there: below P = 0 with
    the modulus on its tangent, down to ``FLOOR`` of what it is without pressure; above ``highest``
    with the modulus of that pressure.
    """

    @property
    def highest(self) -> float:
        """Pressure up to which the law holds [Pa]; inf where it has no end."""
        return inf

    def _modulus(self, P: Array) -> Array:
        raise NotImplementedError

    def _slope(self, P: Array) -> Array:
        raise NotImplementedError

    def _strain(self, P: Array) -> Array:
        raise NotImplementedError

    @cached_property
    def _foot(self) -> tuple[float, float, float]:
        """E_r and its slope at P = 0, and the pressure at which the tangent ends."""
        start = np.zeros(1)
        E, slope = self._modulus(start).item(), self._slope(start).item()
        slope = slope if isfinite(slope) else 0.0
        return E, slope, -(1 - FLOOR) * E / slope if slope > 0 else -inf

    def _holds(self, P: Array) -> bool:
        """Return whether all pressures are within the law, as most are."""
        return P.size > 0 and bool(P.min() >= 0) and bool(P.max() <= self.highest)

    def modulus(self, P: float | Array) -> Any:
        """Return E_r = dP/d(-eps_r) [Pa], the shape of P [Pa]."""
        P = np.asarray(P, dtype=float)
        if self._holds(P):
            return self._modulus(P)[()]
        E, slope, least = self._foot
        foot = E + slope * np.clip(P, least, 0.0)
        return np.where(P < 0, foot, self._modulus(np.clip(P, 0.0, self.highest)))[()]

    def modulus_slope(self, P: float | Array) -> Any:
        """Return dE_r/dP [1], the shape of P [Pa]."""
        P = np.asarray(P, dtype=float)
        if self._holds(P):
            return self._slope(P)[()]
        _, slope, least = self._foot
        inner = self._slope(np.clip(P, 0.0, self.highest))
        beyond, pulled = self.highest < P, least > P
        inner = np.where(beyond, 0.0, inner)
        return np.where(P < 0, np.where(pulled, 0.0, slope), inner)[()]

    def strain_at(self, P: float | Array) -> Any:
        """Return F(P) = int dP/E_r from P = 0, compression positive [1], the shape of P [Pa]."""
        P = np.asarray(P, dtype=float)
        if self._holds(P):
            return self._strain(P)[()]
        E, slope, least = self._foot
        low, inner = np.clip(P, least, 0.0), np.clip(P, 0.0, self.highest)
        foot = low / E if slope == 0 else np.log1p(slope * low / E) / slope
        foot = foot + (np.minimum(P, low) - low) / (E * FLOOR)
        over = np.maximum(P - inner, 0.0) / self._modulus(inner)
        return np.where(P < 0, foot, self._strain(inner) + over)[()]

    def pressure_at(self, strain: float | Array) -> Any:
        """Return P at which F(P) is ``strain`` [Pa]: the inverse of :meth:`strain_at`."""
        wanted = np.asarray(strain, dtype=float)
        E, slope, _ = self._foot
        low = np.zeros_like(wanted)
        high = np.full_like(wanted, self.highest)
        P = np.minimum(low + min(E / slope if slope > 0 else 1e5, 1e5), high)
        for _ in range(200):
            miss = wanted - self.strain_at(P)
            low, high = np.where(miss > 0, P, low), np.where(miss < 0, P, high)
            # along the law whose modulus goes on rising as here; Pfeiffer's is hit at once
            E_r = self.modulus(P)
            rise = np.clip(np.minimum(self.modulus_slope(P), 1e99) * miss, -50.0, 50.0)
            step = E_r * miss * np.where(rise == 0, 1.0, np.expm1(rise) / np.where(rise, rise, 1.0))
            trial = P + step
            half = np.where(np.isfinite(high), low / 2 + high / 2, 2 * P)
            trial = np.where((trial < low) | (trial > high), half, trial)
            settled = np.abs(trial - P) <= 1e-14 * np.abs(P)  # steps below tell rounding
            P = trial
            if np.all(settled | (wanted <= 0)):
                break
        return self._beyond(wanted, P)[()]

    def _beyond(self, wanted: Array, P: Array) -> Array:
        """Return the pressures of strains, inverted in closed form at the law's two ends."""
        E, slope, least = self._foot
        end = self.strain_at(least) if isfinite(least) else -inf
        foot = E * wanted if slope == 0 else E / slope * np.expm1(slope * np.minimum(wanted, 0.0))
        if slope > 0:
            foot = np.where(wanted < end, least + (wanted - end) * E * FLOOR, foot)
        if isfinite(self.highest):
            last, top = self.strain_at(self.highest), self.highest
            P = np.where(wanted > last, top + (wanted - last) * self.modulus(top), P)
        return np.where(wanted < 0, foot, np.where(wanted == 0, 0.0, P))

    def reaches(self, modulus: float) -> float:
        """Return the least P >= 0 at which E_r reaches ``modulus`` [Pa]; inf if it never does."""
        from scipy.optimize import brentq

        top = self.highest if isfinite(self.highest) else 1e12
        grid = np.concatenate([[0.0], np.geomspace(min(1e-3, top / 2), top, 2000)])
        reached = np.nonzero(self.modulus(grid) >= modulus)[0]
        if not reached.size:
            return inf
        if reached[0] == 0:
            return 0.0
        low, high = grid[reached[0] - 1], grid[reached[0]]
        return float(brentq(lambda P: float(self.modulus(P)) - modulus, low, high, xtol=1e-9))


class SolidLaw(RadialLaw, abstract=True):
    """The law of a stack of paper or film alone, without air between the laps."""


class Constant(SolidLaw):
    """A modulus that does not depend on pressure.

    Parameters
    ----------
    youngs_modulus : float
        E_r [Pa].
    """

    youngs_modulus: Annotated[
        Number,
        stress("E_r", "radial modulus of the stack", "MPa", (1e6, 1e8)),
        Field(ge=SOFTEST, le=STIFFEST),
    ]

    def _modulus(self, P: Array) -> Array:
        return np.full_like(P, self.youngs_modulus)

    def _slope(self, P: Array) -> Array:
        return np.zeros_like(P)

    def _strain(self, P: Array) -> Array:
        return P / self.youngs_modulus


class Pfeiffer(SolidLaw):
    """Pfeiffer's stack law P = K1 (exp(K2 eps) - 1): E_r = K2 (K1 + P).

    Parameters
    ----------
    K1 : float
        Pressure [Pa], > 0.
    K2 : float
        Springiness factor [1], > 0.
    """

    K1: Annotated[
        Number,
        stress("K1", "pressure of Pfeiffer's law", "kPa", (0.1e3, 100e3)),
        Field(gt=0, le=STIFFEST),
    ]
    K2: Annotated[
        Number, pure("K2", "springiness of Pfeiffer's law", (10.0, 500.0)), Field(gt=0, le=1e6)
    ]

    def _modulus(self, P: Array) -> Array:
        return self.K2 * (self.K1 + P)

    def _slope(self, P: Array) -> Array:
        return np.full_like(P, self.K2)

    def _strain(self, P: Array) -> Array:
        return np.log1p(P / self.K1) / self.K2

    def pressure_at(self, strain: float | Array) -> Any:
        """Return P at which F(P) is ``strain`` [Pa], in closed form."""
        wanted = np.asarray(strain, dtype=float)
        return self._beyond(wanted, self.K1 * np.expm1(np.clip(self.K2 * wanted, 0.0, 600.0)))[()]

    def reaches(self, modulus: float) -> float:
        """Return P at which E_r is ``modulus`` [Pa]; 0 if it is stiffer from the start."""
        return max(modulus / self.K2 - self.K1, 0.0)


class Polynomial(SolidLaw):
    """A polynomial E_r = c_0 + c_1 P + c_2 P^2 + ...

    Parameters
    ----------
    coefficients : sequence of float
        c_0 [Pa], c_1 [1], c_2 [1/Pa], ...; c_0 > 0.  The law ends where the modulus has fallen to
        1 % of c_0.
    """

    coefficients: Annotated[
        Numbers,
        Field(
            min_length=1,
            max_length=12,
            description="c_0, c_1, ... of E_r, P in Pa",
            examples=[(4e5, 40.0)],
        ),
    ]

    @field_validator("coefficients")
    @classmethod
    def _stiff_at_first(cls, c: tuple[float, ...]) -> tuple[float, ...]:
        if not SOFTEST <= c[0] <= STIFFEST:
            text = f"{quote(c[0])} is out of range; must be >= {SOFTEST:g} and <= {STIFFEST:g} [Pa]"
            raise InvalidProblem.at("0", f"{text}: E_r at P = 0")
        return c

    @cached_property
    def _scale(self) -> float:
        """The least pressure at which the modulus is another [Pa]."""
        c = self.coefficients
        sizes = (abs(c[0] / c_k) ** (1 / k) for k, c_k in enumerate(c) if k and c_k)
        return min(sizes, default=1e5)

    @cached_property
    def highest(self) -> float:
        """Pressure at which the modulus has fallen to 1 % [Pa]; inf if it never does."""
        return self._first(FLOOR * self.coefficients[0])

    def _first(self, modulus: float) -> float:
        """Return the least P > 0 at which E_r is ``modulus``."""
        c = np.array(self.coefficients) * self._scale ** np.arange(len(self.coefficients))
        c[0] -= modulus
        roots = polynomial.polyroots(np.trim_zeros(c, "b")) if np.any(c[1:]) else np.zeros(0)
        real = roots.real[(np.abs(roots.imag) <= 1e-9 * np.abs(roots)) & (roots.real > 0)]
        return float(real.min()) * self._scale if real.size else inf

    def reaches(self, modulus: float) -> float:
        """Return the least P >= 0 at which E_r reaches ``modulus`` [Pa]; inf if it never does."""
        if modulus <= self.coefficients[0]:
            return 0.0
        first = self._first(modulus)
        return first if first <= self.highest else inf

    def _modulus(self, P: Array) -> Array:
        return polynomial.polyval(P, self.coefficients)

    def _slope(self, P: Array) -> Array:
        return polynomial.polyval(P, polynomial.polyder(self.coefficients))

    def _strain(self, P: Array) -> Array:
        # in t, P = scale (e^t - 1), the poles of 1/E_r are at a distance
        scale = self._scale

        def strains(t: Array) -> Array:
            P = scale * np.expm1(t)
            return (P + scale) / self._modulus(P)

        return _integral(strains, np.log1p(P / scale))


class PowerLaw(SolidLaw):
    """A power of the pressure, E_r = E0 + k (P/100 kPa)^m.

    Parameters
    ----------
    E0 : float
        E_r at P = 0 [Pa], >= 0; > 0 where m >= 1, for a stack without stiffness has no finite
        strain then.
    k : float
        What 100 kPa add to it [Pa], > 0.
    m : float
        Exponent, 0.1 to 5.
    """

    E0: Annotated[
        Number,
        stress("E0", "modulus of the stack without pressure", "MPa", (0.1e6, 10e6)),
        Field(ge=0, le=STIFFEST),
    ]
    k: Annotated[
        Number,
        stress("k", "increase of the modulus at 100 kPa", "MPa", (1e6, 100e6)),
        Field(ge=SOFTEST, le=STIFFEST),
    ]
    m: Annotated[Number, pure("m", "exponent of the pressure", (0.5, 1.0)), Field(ge=0.1, le=5)]

    @model_validator(mode="after")
    def _finite_strain(self) -> Self:
        if self.E0 == 0 and self.m >= 1:
            raise InvalidProblem.at(
                "E0", "0 is out of range; must be > 0 [Pa] where m >= 1, or the strain is infinite"
            )
        if 0 < self.E0 < SOFTEST:
            text = f"{quote(self.E0)} is out of range; must be 0 or >= {SOFTEST:g} [Pa]"
            raise InvalidProblem.at("E0", text)
        return self

    @property
    def _start(self) -> float:
        """Pressure below which a law without E0 is taken as constant [Pa]: next to nothing."""
        return 1e-4 if self.E0 == 0 else 0.0

    def _modulus(self, P: Array) -> Array:
        return self.E0 + self.k * (np.maximum(P, self._start) / 1e5) ** self.m

    def _slope(self, P: Array) -> Array:
        with np.errstate(divide="ignore"):  # infinite at P = 0 where m < 1
            slope = self.k * self.m / 1e5 * (P / 1e5) ** (self.m - 1)
        return np.where(self._start > P, 0.0, slope)

    def _strain(self, P: Array) -> Array:
        from scipy.special import hyp2f1

        m = self.m
        if self.E0 == 0:
            start, above = self._start, np.maximum(P, self._start)
            grown = (above / 1e5) ** (1 - m) - (start / 1e5) ** (1 - m)
            first = np.minimum(P, start) / self._modulus(np.zeros(()))
            return first + 1e5 / (self.k * (1 - m)) * grown
        # int dx/(1 + x^m): Pfaff's transformation up to x = 1, then over ln x
        knee = 1e5 * (self.E0 / self.k) ** (1 / m)
        low = np.minimum(P, knee)
        z = (low / knee) ** m
        below = low * hyp2f1(1.0, 1.0, 1 + 1 / m, z / (1 + z)) / (1 + z)
        end = np.log(np.maximum(P / knee, 1.0))
        above = knee * _integral(lambda t: np.exp(t) / (1 + np.exp(m * t)), end)
        return (below + above) / self.E0

    def reaches(self, modulus: float) -> float:
        """Return P at which E_r is ``modulus`` [Pa]; 0 if it is stiffer from the start."""
        P = 1e5 * (max(modulus - self.E0, 0.0) / self.k) ** (1 / self.m)
        return P if self._start < P else 0.0


class StackTest(SolidLaw):
    """A measured compression test, fitted by a law that rises throughout.

    Pfeiffer's law is fitted first; a monotone cubic spline over ln(1 + P/K1) takes what it leaves.
    The law ends at the largest measured pressure.

    Parameters
    ----------
    pressure : sequence of float
        P [Pa], >= 0, rising; at least 4.
    strain : sequence of float
        Compressive strain [1], rising; where it is zero does not matter.
    """

    pressure: Annotated[
        Numbers,
        stress("P_i", "pressures of a stack test"),
        Field(min_length=4, max_length=10_000, examples=[(10e3, 50e3, 200e3, 500e3)]),
    ]
    strain: Annotated[
        Numbers,
        strain("eps_i", "strains of a stack test"),
        Field(min_length=4, max_length=10_000, examples=[(0.017, 0.045, 0.076, 0.098)]),
    ]

    @model_validator(mode="after")
    def _rises(self) -> Self:
        if len(self.pressure) != len(self.strain):
            text = (
                f"{len(self.strain)} values; must be as many as of pressure, {len(self.pressure)}"
            )
            raise InvalidProblem.at("strain", text)
        if self.pressure[0] < 0:
            text = f"{quote(self.pressure[0])} is out of range; must be >= 0 [Pa]"
            raise InvalidProblem.at("pressure.0", text)
        for name, unit in (("pressure", " [Pa]"), ("strain", "")):
            values = getattr(self, name)
            for k, (before, value) in enumerate(pairwise(values), start=1):
                if value <= before:
                    text = f"{quote(value)} is out of range; must be > {quote(before)}{unit}, the "
                    raise InvalidProblem.at(f"{name}.{k}", f"{text}value before it")
        return self

    @property
    def highest(self) -> float:
        """The largest measured pressure [Pa]."""
        return self.pressure[-1]

    @cached_property
    def _fit(self) -> tuple[float, BSpline]:
        """K1 [Pa] and the strain over ln(1 + P/K1), less that at P = 0."""
        from scipy.interpolate import BSpline
        from scipy.optimize import lsq_linear, minimize_scalar

        P, e = np.array(self.pressure), np.array(self.strain)

        def missed(log_K1: float) -> float:
            return float(_line(np.log1p(P / exp(log_K1)), e)[1])

        ends = log(P[-1]) - 10.0, log(P[-1]) + 5.0
        K1 = exp(minimize_scalar(missed, bounds=ends, method="bounded").x)
        x = np.log1p(P / K1)
        (_, slope), _ = _line(x, e)
        inner = min((P.size - 4) // 3, 8)
        # no more knots than data between them: quantiles of the data
        cuts = np.quantile(x, np.linspace(0, 1, inner + 2)[1:-1])
        knots = np.concatenate([[x[0]] * 4, cuts, [x[-1]] * 4])
        greville = np.array([knots[k + 1 : k + 4].mean() for k in range(inner + 4)])
        basis = BSpline.design_matrix(x, knots, 3).toarray()
        rising = np.tril(np.ones((inner + 4, inner + 4)))
        # rising coefficients make a rising spline: steps of at least 1 % of the line's
        least = np.concatenate([[-np.inf], FLOOR * slope * np.diff(greville)])
        steps = lsq_linear(basis @ rising, e, (least, np.inf), tol=1e-14).x
        return K1, BSpline(knots, rising @ steps, 3)

    def _over(self, P: Array, order: int) -> Array:
        """Return a derivative of the strain with respect to ln(1 + P/K1), linear below the data."""
        K1, spline = self._fit
        x, first = np.log1p(P / K1), spline.t[0]
        inside = spline(np.maximum(x, first), order)
        if order > 1:
            return np.where(x < first, 0.0, inside)
        return inside + np.minimum(x - first, 0.0) * spline(first, 1) * (order == 0)

    def _modulus(self, P: Array) -> Array:
        return (self._fit[0] + P) / self._over(P, 1)

    def _slope(self, P: Array) -> Array:
        first = self._over(P, 1)
        return 1 / first - self._over(P, 2) / first**2

    def _strain(self, P: Array) -> Array:
        return self._over(P, 0) - self._over(np.zeros(()), 0)

    @cached_property
    def misfit(self) -> float:
        """The fit's largest miss of a measured strain, of the largest strain [1]."""
        e = np.array(self.strain)
        offset = self._over(np.array(self.pressure), 0) - e
        return float(np.max(np.abs(offset)) / (e[-1] - e[0]))


def _integral(f: Callable[[Array], Array], end: Array) -> Array:
    """Return the integrals of a smooth f from 0 to ``end``."""
    t, weights = _six_panels()
    return end * (f(end[..., None] * t) @ weights)


@cache
def _six_panels() -> tuple[Array, Array]:
    """Return points and weights of Gauss's rule on six panels of [0, 1]."""
    x, w = np.polynomial.legendre.leggauss(24)
    return ((np.arange(6)[:, None] + (x + 1) / 2) / 6).ravel(), np.tile(w / 12, 6)


def _line(x: Array, y: Array) -> tuple[tuple[float, float], float]:
    """Return offset and slope of the straight line nearest to y(x), and the sum of its squares."""
    x0, y0 = x.mean(), y.mean()
    slope = float((x - x0) @ (y - y0) / ((x - x0) @ (x - x0)))
    rest = y - y0 - slope * (x - x0)
    return (float(y0 - slope * x0), slope), float(rest @ rest)


def _law(value: Any) -> Any:
    """Return the law of a table; a number is a modulus that does not change."""
    if isinstance(value, (RadialLaw, Mapping)):
        return RadialLaw.coerce(value)
    try:
        return Constant(youngs_modulus=value)
    except InvalidProblem as fault:
        raise InvalidProblem(fault.faults[0][1]) from None  # the field's name is the caller's


if TYPE_CHECKING:
    AnyLaw = CoercedField[RadialLaw, RadialLaw | float | str | Mapping[str, Any]]
    AnySolidLaw = CoercedField[SolidLaw, SolidLaw | float | str | Mapping[str, Any]]
else:
    AnyLaw = Annotated[SerializeAsAny[RadialLaw], BeforeValidator(_law)]
    AnySolidLaw = Annotated[SerializeAsAny[SolidLaw], BeforeValidator(_law)]
