"""Radial laws of stacks: the tangent modulus E_r(P) of layers of paper or film under pressure.

F(P) = int_0^P dP'/E_r(P')        compressive strain through the stack
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cached_property
from math import exp, inf, isfinite, log
from typing import TYPE_CHECKING, Annotated, Any, Self

import numpy as np
from numpy.polynomial import polynomial
from pydantic import BeforeValidator, Field, SerializeAsAny, field_validator, model_validator

from ..elasticity.quadrature import gauss_points
from ..errors import InvalidProblem
from ..quantities import Values, as_given, pure, strain, stress
from .family import Family
from .fields import Number, Numbers, check_equal_lengths, check_rising
from .materials import SOFTEST, STIFFEST
from .messages import quote

if TYPE_CHECKING:
    from scipy.interpolate import BSpline

    from .fields import CoercedField

# SciPy is imported inside functions: reading and writing problems does not need it.

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
    "pfeiffer_line",
]

Array = np.ndarray

# Smallest modulus of a law, relative to the modulus at P = 0.
FLOOR = 0.01
# Fit of a stack test.  Range of ln(K1/P_max) that is searched, P_max the largest pressure: at the
# lower end the strain is a logarithm of P over four decades, at the upper one it is linear in P.
SMALLEST_LN_K1, LARGEST_LN_K1 = -10.0, 5.0
# A cubic without inner knots has four coefficients; each inner knot adds one, and needs about three
# data points.  More knots would follow the scatter of the test.
CUBIC, POINTS_PER_KNOT, MOST_KNOTS = 4, 3, 8


class RadialLaw(Family):
    """The tangent modulus E_r(P) of a stack under the pressure P: an open set of laws.

    A subclass implements ``_modulus``, ``_slope`` and ``_strain`` for 0 <= P <= ``max_pressure``.
    The law is extrapolated for iterates: below P = 0 the modulus follows its tangent down to
    ``FLOOR`` E_r(0); above ``max_pressure`` it is constant.
    """

    @property
    def max_pressure(self) -> float:
        """Largest pressure of the law [Pa]; inf if it has no limit."""
        return inf

    def _modulus(self, P: Array) -> Array:
        """Return E_r(P) within the range of the law."""
        raise NotImplementedError

    def _slope(self, P: Array) -> Array:
        """Return dE_r/dP within the range of the law."""
        raise NotImplementedError

    def _strain(self, P: Array) -> Array:
        """Return F(P) within the range of the law."""
        raise NotImplementedError

    @cached_property
    def _tangent_at_zero(self) -> tuple[float, float, float]:
        """E_r and dE_r/dP at P = 0, and the pressure < 0 at which the tangent reaches FLOOR E_r."""
        zero = np.zeros(1)
        E, slope = self._modulus(zero).item(), self._slope(zero).item()
        slope = slope if isfinite(slope) else 0.0
        return E, slope, -(1 - FLOOR) * E / slope if slope > 0 else -inf

    def _in_range(self, P: Array) -> bool:
        """Return True if all pressures are within the range of the law."""
        return P.size > 0 and bool(P.min() >= 0) and bool(P.max() <= self.max_pressure)

    def modulus(self, P: Values) -> Values:
        """Return E_r = dP/d(-eps_r) [Pa] at pressures P of any shape [Pa]."""
        p = np.asarray(P, dtype=float)
        if self._in_range(p):
            return as_given(self._modulus(p))
        # the law continues along its tangent below zero, and is constant above its largest pressure
        E, slope, P_min = self._tangent_at_zero
        tangent = E + slope * np.clip(p, P_min, 0.0)
        return as_given(np.where(p < 0, tangent, self._modulus(np.clip(p, 0.0, self.max_pressure))))

    def modulus_slope(self, P: Values) -> Values:
        """Return dE_r/dP [1] at pressures P of any shape [Pa]."""
        p = np.asarray(P, dtype=float)
        if self._in_range(p):
            return as_given(self._slope(p))
        _, slope, P_min = self._tangent_at_zero
        inner = self._slope(np.clip(p, 0.0, self.max_pressure))
        inner = np.where(self.max_pressure < p, 0.0, inner)
        return as_given(np.where(p < 0, np.where(P_min > p, 0.0, slope), inner))

    def strain_at(self, P: Values) -> Values:
        """Return the compressive strain F(P) [1] at pressures P of any shape [Pa]."""
        p = np.asarray(P, dtype=float)
        if self._in_range(p):
            return as_given(self._strain(p))
        E, slope, P_min = self._tangent_at_zero
        # P < 0: integral of dP/E_r along the tangent down to P_min, then with FLOOR E_r(0)
        low, inner = np.clip(p, P_min, 0.0), np.clip(p, 0.0, self.max_pressure)
        below_zero = low / E if slope == 0 else np.log1p(slope * low / E) / slope
        below_zero = below_zero + (np.minimum(p, low) - low) / (E * FLOOR)
        beyond_max = np.maximum(p - inner, 0.0) / self._modulus(inner)
        return as_given(np.where(p < 0, below_zero, self._strain(inner) + beyond_max))

    def pressure_at(self, strain: Values) -> Values:
        """Return the pressure P at a compressive strain F(P) [Pa].

        Newton's method with bisection as a safeguard.
        """
        target = np.asarray(strain, dtype=float)
        E, slope, _ = self._tangent_at_zero
        low = np.zeros_like(target)
        high = np.full_like(target, self.max_pressure)
        # initial guess: the pressure at which the tangent has doubled the modulus, at most 1e5 Pa
        P = np.minimum(low + min(E / slope if slope > 0 else 1e5, 1e5), high)
        for _ in range(200):
            residual = target - self.strain_at(P)
            low, high = np.where(residual > 0, P, low), np.where(residual < 0, P, high)
            # The step assumes a modulus that is linear in P, which is exact for Pfeiffer's law.
            # An infinite slope is limited, as its product with a residual of 0 would be nan.
            x = np.clip(np.minimum(self.modulus_slope(P), 1e99) * residual, -50.0, 50.0)
            factor = np.where(x == 0, 1.0, np.expm1(x) / np.where(x, x, 1.0))
            trial = P + self.modulus(P) * residual * factor
            bisection = np.where(np.isfinite(high), low / 2 + high / 2, 2 * P)
            trial = np.where((trial < low) | (trial > high), bisection, trial)
            converged = np.abs(trial - P) <= 1e-14 * np.abs(P)  # rounding error
            P = trial
            if np.all(converged | (target <= 0)):
                break
        return as_given(self._extrapolate(target, P))

    def _extrapolate(self, strain: Array, P: Array) -> Array:
        """Return P, with closed forms at strains outside the range of the law.

        They are the inverse of the extrapolation of :meth:`strain_at`: tangents at P = 0 and at the
        largest pressure.  ``strain`` and ``P`` have one shape, and so has the result.
        """
        E, slope, P_min = self._tangent_at_zero
        end = self.strain_at(P_min) if isfinite(P_min) else -inf
        below_zero = (
            E * strain if slope == 0 else E / slope * np.expm1(slope * np.minimum(strain, 0.0))
        )
        if slope > 0:
            below_zero = np.where(strain < end, P_min + (strain - end) * E * FLOOR, below_zero)
        if isfinite(self.max_pressure):
            last, top = self.strain_at(self.max_pressure), self.max_pressure
            P = np.where(strain > last, top + (strain - last) * self.modulus(top), P)
        return np.where(strain < 0, below_zero, np.where(strain == 0, 0.0, P))

    def pressure_at_modulus(self, modulus: float) -> float:
        """Return the smallest P >= 0 at which E_r is ``modulus`` [Pa]; inf if there is none."""
        from scipy.optimize import brentq

        top = self.max_pressure if isfinite(self.max_pressure) else 1e12
        # a grid brackets the smallest solution: the modulus need not rise everywhere
        grid = np.concatenate([[0.0], np.geomspace(min(1e-3, top / 2), top, 2000)])
        stiff = np.nonzero(self.modulus(grid) >= modulus)[0]
        if not stiff.size:
            return inf
        if stiff[0] == 0:
            return 0.0
        low, high = grid[stiff[0] - 1], grid[stiff[0]]
        return float(brentq(lambda P: float(self.modulus(P)) - modulus, low, high, xtol=1e-9))


class SolidLaw(RadialLaw, abstract=True):
    """The law of a stack of paper or film, without air between the layers."""


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

    Examples
    --------
    >>> import woundon as wo
    >>> float(wo.Pfeiffer(K1="10 kPa", K2=40.0).modulus(100e3))
    4400000.0
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

    def pressure_at(self, strain: Values) -> Values:
        """Return the pressure at a compressive strain [Pa], in closed form."""
        target = np.asarray(strain, dtype=float)
        # Clipped: strains below 0 are extrapolated, and exp(710) overflows.
        P = self.K1 * np.expm1(np.clip(self.K2 * target, 0.0, 600.0))
        return as_given(self._extrapolate(target, P))

    def pressure_at_modulus(self, modulus: float) -> float:
        """Return P at which E_r is ``modulus`` [Pa]; 0 if E_r(0) is larger."""
        return max(modulus / self.K2 - self.K1, 0.0)


class Polynomial(SolidLaw):
    """A polynomial E_r = c_0 + c_1 P + c_2 P^2 + ...

    Parameters
    ----------
    coefficients : sequence of float
        c_0 [Pa], c_1 [1], c_2 [1/Pa], ...; c_0 > 0.  The law ends where the modulus falls to 1 %
        of c_0.

    Examples
    --------
    >>> import woundon as wo
    >>> float(wo.Polynomial(coefficients=(4e5, 40.0)).modulus(100e3))
    4400000.0
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
    def _check_modulus_at_zero(cls, c: tuple[float, ...]) -> tuple[float, ...]:
        """Reject a modulus that is not positive at zero pressure."""
        if not SOFTEST <= c[0] <= STIFFEST:
            text = f"{quote(c[0])} is out of range; must be >= {SOFTEST:g} and <= {STIFFEST:g} [Pa]"
            raise InvalidProblem.at("0", f"{text}: E_r at P = 0")
        return c

    @cached_property
    def _scale(self) -> float:
        """Smallest pressure at which a term is as large as c_0 [Pa], the unit of P."""
        c = self.coefficients
        pressures = (abs(c[0] / c_k) ** (1 / k) for k, c_k in enumerate(c) if k and c_k)
        return min(pressures, default=1e5)

    @cached_property
    def max_pressure(self) -> float:
        """Pressure at which the modulus falls to 1 % of c_0 [Pa]; inf if it does not."""
        return self._smallest_root(FLOOR * self.coefficients[0])

    def _smallest_root(self, modulus: float) -> float:
        """Return the smallest P > 0 at which E_r is ``modulus``; inf if there is none."""
        # coefficients of P/scale, all of the order of c_0
        c = np.array(self.coefficients) * self._scale ** np.arange(len(self.coefficients))
        c[0] -= modulus
        roots = polynomial.polyroots(np.trim_zeros(c, "b")) if np.any(c[1:]) else np.zeros(0)
        # an imaginary part up to 1e-9 of a root is a rounding error
        real = roots.real[(np.abs(roots.imag) <= 1e-9 * np.abs(roots)) & (roots.real > 0)]
        return float(real.min()) * self._scale if real.size else inf

    def pressure_at_modulus(self, modulus: float) -> float:
        """Return the smallest P >= 0 at which E_r is ``modulus`` [Pa]; inf if there is none."""
        if modulus <= self.coefficients[0]:
            return 0.0
        P = self._smallest_root(modulus) if modulus < inf else inf
        return inf if self.max_pressure < P else P

    def _modulus(self, P: Array) -> Array:
        return polynomial.polyval(P, self.coefficients)

    def _slope(self, P: Array) -> Array:
        return polynomial.polyval(P, polynomial.polyder(self.coefficients))

    def _strain(self, P: Array) -> Array:
        """Return F(P) = int_0^P dP/E_r by Gauss's rule."""
        # Substitution P = scale (e^t - 1): it moves the poles of 1/E_r away from the interval.
        scale = self._scale

        def integrand(t: Array) -> Array:
            """Return (dP/dt)/E_r."""
            P = scale * np.expm1(t)
            return (P + scale) / self._modulus(P)

        return _integral(integrand, np.log1p(P / scale))


class PowerLaw(SolidLaw):
    """A power of the pressure, E_r = E0 + k (P/100 kPa)^m.

    Parameters
    ----------
    E0 : float
        E_r at P = 0 [Pa], >= 0; > 0 if m >= 1, otherwise the strain is infinite.
    k : float
        Increase of E_r at 100 kPa [Pa], > 0.
    m : float
        Exponent, 0.1 to 5.

    Examples
    --------
    >>> import woundon as wo
    >>> law = wo.PowerLaw(E0="1 MPa", k="20 MPa", m=0.8)
    >>> float(law.modulus(100e3))
    21000000.0
    """

    E0: Annotated[
        Number,
        stress("E0", "modulus of the stack at zero pressure", "MPa", (0.1e6, 10e6)),
        Field(ge=0, le=STIFFEST),
    ]
    k: Annotated[
        Number,
        stress("k", "increase of the modulus at 100 kPa", "MPa", (1e6, 100e6)),
        Field(ge=SOFTEST, le=STIFFEST),
    ]
    m: Annotated[Number, pure("m", "exponent of the pressure", (0.5, 1.0)), Field(ge=0.1, le=5)]

    @model_validator(mode="after")
    def _check_strain(self) -> Self:
        """Reject a law with an infinite strain or too small a modulus."""
        if self.E0 == 0 and self.m >= 1:
            raise InvalidProblem.at(
                "E0",
                "0 is out of range; must be > 0 [Pa] if m >= 1, otherwise the strain is infinite",
            )
        if 0 < self.E0 < SOFTEST:
            text = f"{quote(self.E0)} is out of range; must be 0 or >= {SOFTEST:g} [Pa]"
            raise InvalidProblem.at("E0", text)
        return self

    @property
    def _start(self) -> float:
        """Pressure below which the modulus is constant if E0 = 0 [Pa], to keep it positive."""
        return 1e-4 if self.E0 == 0 else 0.0

    def _modulus(self, P: Array) -> Array:
        return self.E0 + self.k * (np.maximum(P, self._start) / 1e5) ** self.m

    def _slope(self, P: Array) -> Array:
        """Return dE_r/dP = k m/P_1 (P/P_1)^(m - 1), P_1 = 100 kPa."""
        with np.errstate(divide="ignore"):  # infinite at P = 0 where m < 1
            slope = self.k * self.m / 1e5 * (P / 1e5) ** (self.m - 1)
        return np.where(self._start > P, 0.0, slope)

    def _strain(self, P: Array) -> Array:
        """Return F(P) = int_0^P dP/E_r, in closed form up to the pressure that doubles E0."""
        from scipy.special import hyp2f1

        m = self.m
        if self.E0 == 0:  # then m < 1; the modulus is constant up to start
            start, upper = self._start, np.maximum(P, self._start)
            integral = ((upper / 1e5) ** (1 - m) - (start / 1e5) ** (1 - m)) / (1 - m)
            constant = np.minimum(P, start) / self._modulus(np.zeros(()))
            return constant + 1e5 / self.k * integral
        # E0 F = P1 int_0^(P/P1) dx/(1 + x^m), P1 the pressure that doubles the modulus:
        # hypergeometric function with Pfaff's transformation up to x = 1, then quadrature over ln x
        P1 = 1e5 * (self.E0 / self.k) ** (1 / m)
        low = np.minimum(P, P1)
        z = (low / P1) ** m
        lower = low * hyp2f1(1.0, 1.0, 1 + 1 / m, z / (1 + z)) / (1 + z)
        end = np.log(np.maximum(P / P1, 1.0))
        upper = P1 * _integral(lambda t: np.exp(t) / (1 + np.exp(m * t)), end)
        return (lower + upper) / self.E0

    def pressure_at_modulus(self, modulus: float) -> float:
        """Return P at which E_r is ``modulus`` [Pa]; 0 if E_r(0) is larger."""
        P = 1e5 * (max(modulus - self.E0, 0.0) / self.k) ** (1 / self.m)
        return P if self._start < P else 0.0


class StackTest(SolidLaw):
    """A measured compression test, interpolated by a monotone law.

    Pfeiffer's law gives K1; then a monotone cubic spline over ln(1 + P/K1) is fitted to the
    strains.  The law ends at the largest measured pressure.

    Parameters
    ----------
    pressure : sequence of float
        P [Pa], >= 0, increasing; at least 4.
    strain : sequence of float
        Compressive strain [1], < 1, increasing; the origin is arbitrary.

    Examples
    --------
    >>> import woundon as wo
    >>> test = wo.StackTest(
    ...     pressure=[10e3, 50e3, 200e3, 500e3], strain=[0.017, 0.045, 0.076, 0.098]
    ... )
    >>> test.max_pressure
    500000.0
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
    def _check_test(self) -> Self:
        """Reject a test whose pressures or strains do not increase."""
        check_equal_lengths(self, "pressure", "strain")
        if self.pressure[0] < 0:
            text = f"{quote(self.pressure[0])} is out of range; must be >= 0 [Pa]"
            raise InvalidProblem.at("pressure.0", text)
        check_rising(self, "pressure")
        check_rising(self, "strain")
        if self.strain[-1] >= 1:
            text = (
                f"{quote(self.strain[-1])} is out of range; must be < 1, at which the stack has no "
                "thickness left; strains in percent need their unit, '%'"
            )
            raise InvalidProblem.at(f"strain.{len(self.strain) - 1}", text)
        return self

    @property
    def max_pressure(self) -> float:
        """The largest measured pressure [Pa]."""
        return self.pressure[-1]

    @cached_property
    def _fit(self) -> tuple[float, BSpline]:
        """K1 [Pa] and the monotone least-squares spline of the strain over ln(1 + P/K1)."""
        from scipy.interpolate import BSpline
        from scipy.optimize import lsq_linear

        P, e = np.array(self.pressure), np.array(self.strain)
        K1, slope = pfeiffer_line(P, e)
        x = np.log1p(P / K1)
        inner_count = min((P.size - CUBIC) // POINTS_PER_KNOT, MOST_KNOTS)
        count = CUBIC + inner_count
        # Inner knots at quantiles of the data: every interval contains data.
        inner_knots = np.quantile(x, np.linspace(0, 1, inner_count + 2)[1:-1])
        knots = np.concatenate([[x[0]] * 4, inner_knots, [x[-1]] * 4])
        greville = np.array([knots[k + 1 : k + 4].mean() for k in range(count)])
        basis = BSpline.design_matrix(x, knots, 3).toarray()
        # The unknowns are the first coefficient and the increments of the others.  Increasing
        # coefficients give an increasing spline: their increments are at least 1 % of those of the
        # straight line.  The first one is free, because the origin of the strain is arbitrary.
        cumulative = np.tril(np.ones((count, count)))
        lower = np.concatenate([[-np.inf], FLOOR * slope * np.diff(greville)])
        increments = lsq_linear(basis @ cumulative, e, (lower, np.inf), tol=1e-14).x
        return K1, BSpline(knots, cumulative @ increments, 3)

    def _derivative(self, P: Array, order: int) -> Array:
        """Return a derivative of the strain by ln(1 + P/K1), of order 0, 1 or 2; 0 is the strain.

        P is an array of any shape [Pa], and so is the result [1].
        Below the smallest measured pressure the spline is extrapolated linearly.
        """
        K1, spline = self._fit  # t: its knots, the first at the smallest measured pressure
        x, first = np.log1p(P / K1), spline.t[0]
        value = spline(np.maximum(x, first), order)
        if order > 1:
            return np.where(x < first, 0.0, value)
        if order == 1:
            return value
        return value + np.minimum(x - first, 0.0) * spline(first, 1)

    def _modulus(self, P: Array) -> Array:
        K1, _ = self._fit
        return (K1 + P) / self._derivative(P, 1)

    def _slope(self, P: Array) -> Array:
        first = self._derivative(P, 1)
        return 1 / first - self._derivative(P, 2) / first**2

    def _strain(self, P: Array) -> Array:
        return self._derivative(P, 0) - self._derivative(np.zeros(()), 0)

    @cached_property
    def misfit(self) -> float:
        """Largest residual of the fit, relative to the range of the measured strain [1]."""
        e = np.array(self.strain)
        offset = self._derivative(np.array(self.pressure), 0) - e
        return float(np.max(np.abs(offset)) / (e[-1] - e[0]))


def _integral(f: Callable[[Array], Array], end: Array) -> Array:
    """Return the integrals of a smooth function f from 0 to each of ``end``, in its shape."""
    t, weights = gauss_points(np.linspace(0.0, 1.0, 7), 24)
    return end * (f(end[..., None] * t) @ weights)


def pfeiffer_line(P: Array, strain: Array) -> tuple[float, float]:
    """Return K1 [Pa] and 1/K2 of the least-squares line of the strain over ln(1 + P/K1).

    Parameters
    ----------
    P, strain : (n,) arrays
        Pressures [Pa], the largest one > 0, and strains with any origin.
    """
    from scipy.optimize import minimize_scalar

    def squared_error(log_K1: float) -> float:
        return float(_fit_line(np.log1p(P / exp(log_K1)), strain)[1])

    ln_P = log(P.max())
    ln_K1_range = ln_P + SMALLEST_LN_K1, ln_P + LARGEST_LN_K1
    K1 = exp(minimize_scalar(squared_error, bounds=ln_K1_range, method="bounded").x)
    (_, slope), _ = _fit_line(np.log1p(P / K1), strain)
    return K1, slope


def _fit_line(x: Array, y: Array) -> tuple[tuple[float, float], float]:
    """Return (offset, slope) of the least-squares line through y(x), and its squared error."""
    x0, y0 = x.mean(), y.mean()
    slope = float((x - x0) @ (y - y0) / ((x - x0) @ (x - x0)))
    residuals = y - y0 - slope * (x - x0)
    return (float(y0 - slope * x0), slope), float(residuals @ residuals)


def _law(value: Any) -> Any:
    """Convert a table or a number, a constant modulus, to a law."""
    if isinstance(value, (RadialLaw, Mapping)):
        return RadialLaw.coerce(value)
    try:
        return Constant(youngs_modulus=value)
    except InvalidProblem as fault:
        raise InvalidProblem(fault.faults[0][1]) from None  # the caller adds the field's name


if TYPE_CHECKING:
    AnyLaw = CoercedField[RadialLaw, RadialLaw | float | str | Mapping[str, Any]]
    AnySolidLaw = CoercedField[SolidLaw, SolidLaw | float | str | Mapping[str, Any]]
else:
    AnyLaw = Annotated[SerializeAsAny[RadialLaw], BeforeValidator(_law)]
    AnySolidLaw = Annotated[SerializeAsAny[SolidLaw], BeforeValidator(_law)]
