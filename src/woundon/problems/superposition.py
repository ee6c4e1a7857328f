r"""Time-temperature superposition: isotherms of a dynamic test shifted to one master curve.

In a material of one kind of relaxation all relaxation times vary with the temperature by one
factor a(T), so that the moduli at the frequency f and the temperature T are those at a(T) f and the
reference temperature.  The factors are those for which one Prony series with positive terms follows
all shifted moduli best (:mod:`..elasticity.prony_fit`): the series is smooth, obeys the
Kramers-Kronig relations, and uses storage and loss moduli.  The factors are free, or follow the law
of Williams, Landel and Ferry,

    log10 a = -C1 (T - T_ref)/(C2 + T - T_ref).

With residuals r(x) of the series, x = log10 a, both cases are a least squares problem of few
parameters.  It starts at the shifts by which neighbouring isotherms coincide best where they
overlap.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise
from math import log, pi
from typing import NamedTuple

import numpy as np

from ..elasticity.prony_fit import PronyFit, fit_dynamic_moduli, relaxation_times
from ..errors import InvalidProblem

__all__ = ["Isotherm", "Superposition", "log_shift_at", "superpose", "wlf_shifts"]

Array = np.ndarray

# Neighbouring isotherms overlap by at least so many points of each, and differ there by at most so
# much (rms of the difference of the logarithms): a tenth is scatter, and a fifth a vertical shift.
LEAST_OVERLAP = 3
LARGEST_DIFFERENCE = 0.2
SEARCH_STEP = 0.05  # decades, of the first search; the least squares problem converges from there
DIFFERENCE_STEP = 0.02  # decades, of the derivatives: the residuals are smooth but for active terms
MARGIN = 1.0  # decades by which the relaxation times extend beyond the first master curve
# Initial values of C1 and C2 of the polymers of the original paper, at 50 K above the glass
# transition, if the first shifts do not give any (Williams, Landel, Ferry 1955).
USUAL_WLF = 8.86, 101.6


class Isotherm(NamedTuple):
    """Moduli at one temperature, (n,) arrays, frequencies rising."""

    temperature: float
    frequency: Array
    storage: Array
    loss: Array


class Superposition(NamedTuple):
    """Shifted isotherms.

    Attributes
    ----------
    shift : (m,) array
        log10 a of each isotherm relative to the first one.
    covariance : (m, m) array
        Of the shifts.
    fit : PronyFit
        The series that follows the shifted moduli.
    wlf : (C1, C2, T_ref), optional
        Of the law of Williams, Landel and Ferry, if the shifts follow it.
    """

    shift: Array
    covariance: Array
    fit: PronyFit
    wlf: tuple[float, float, float] | None


def wlf_shifts(C1: float, C2: float, difference: Array) -> Array:
    """Return log10 a of temperatures that differ by ``difference`` from the reference [K]."""
    return np.asarray(-C1 * difference / (C2 + difference))


def superpose(isotherms: Sequence[Isotherm], reference: float, wlf: bool) -> Superposition:
    """Return the shifts of isotherms to one master curve.

    Parameters
    ----------
    isotherms : sequence of Isotherm
        Of rising temperature, at least 2, with ``wlf`` at least 3.
    reference : float
        T_ref of the law [K]; not used without ``wlf``.
    wlf : bool
        Whether the shifts follow the law of Williams, Landel and Ferry.

    Raises
    ------
    InvalidProblem
        If two neighbours do not overlap.
    """
    first = np.cumsum([0.0, *(_pair_shift(*pair) for pair in pairwise(isotherms))])
    residuals = _Residuals(isotherms, first)
    if not wlf:
        others, of_others = _least_squares(residuals, first[1:], _free)
        shift = _free(others)
        # the shift of the first isotherm is zero by definition: its row and column are zero
        covariance = np.zeros((shift.size, shift.size))
        covariance[1:, 1:] = of_others
        return Superposition(shift, covariance, residuals.fit(shift), None)
    difference = np.array([isotherm.temperature for isotherm in isotherms]) - reference
    start = _first_wlf(difference, first)
    lowest = log(1e-3)  # of C1, and of the distance of C2 from the pole, in logarithms

    def law(logarithms: Array) -> Array:
        """Return the shifts relative to the first isotherm, of ln C1 and ln(C2 - C2_min)."""
        shift = wlf_shifts(*_constants(logarithms, difference), difference)
        return shift - shift[0]

    logarithms, of_logarithms = _least_squares(residuals, np.maximum(start, lowest), law)
    shift = law(logarithms)
    # the covariance of the parameters, propagated to the shifts
    slope = _derivative(law, logarithms, 1e-4)
    C1, C2 = _constants(logarithms, difference)
    return Superposition(
        shift, slope @ of_logarithms @ slope.T, residuals.fit(shift), (C1, C2, reference)
    )


def _free(others: Array) -> Array:
    """Return the shifts of all isotherms relative to the first, of those of all others."""
    return np.concatenate([[0.0], others])


def _constants(p: Array, difference: Array) -> tuple[float, float]:
    """Return C1 and C2 of ln C1 and ln(C2 - C2_min); C2 + T - T_ref must be positive."""
    smallest = max(0.0, -float(difference.min()))
    return float(np.exp(p[0])), float(smallest + np.exp(p[1]))


def _first_wlf(difference: Array, shift: Array) -> Array:
    """Return ln C1 and ln(C2 - C2_min) near given shifts, by the linear form of the law.

    ``difference`` are T - T_ref of the isotherms, and ``shift`` their log10 a, (m,) each.
    With s = shift - s_0, s_0 that of the reference: s (C2 + d) + C1 d = 0 is linear in C1, C2 and
    their products with s_0.  The usual values serve where it gives no positive constants.
    """
    s_0 = float(np.interp(0.0, difference, shift))
    s, smallest = shift - s_0, max(0.0, -float(difference.min()))
    (C1, C2), *_ = np.linalg.lstsq(np.column_stack([difference, s]), -s * difference, rcond=None)
    if not (C1 > 0 and smallest < C2):
        usual_C1, C2 = USUAL_WLF
        C2 = max(C2, 2 * smallest)
        C1 = usual_C1
    return np.array([log(C1), log(C2 - smallest)])


class _Residuals:
    """Residuals of the series that follows shifted isotherms, for given relaxation times.

    These cover the frequencies of all isotherms shifted by ``first``, (m,), and a margin.
    """

    def __init__(self, isotherms: Sequence[Isotherm], first: Array) -> None:
        self.frequency = [isotherm.frequency for isotherm in isotherms]
        self.storage = np.concatenate([isotherm.storage for isotherm in isotherms])
        self.loss = np.concatenate([isotherm.loss for isotherm in isotherms])
        omega = 2 * pi * self._shifted(first)
        decade = 10.0**MARGIN
        self.time = relaxation_times(
            float(1 / omega.max()) / decade, decade * float(1 / omega.min())
        )

    def _shifted(self, shift: Array) -> Array:
        """Return a f of all points [Hz]."""
        return np.concatenate([10.0**x * f for x, f in zip(shift, self.frequency, strict=True)])

    def fit(self, shift: Array) -> PronyFit:
        """Return the series that follows the isotherms shifted by log10 a (m,)."""
        return fit_dynamic_moduli(self._shifted(shift), self.storage, self.loss, self.time)

    def __call__(self, shift: Array) -> Array:
        """Return the relative residuals of E' and E'', (2 n,)."""
        return self.fit(shift).residual.ravel()


def _derivative(function: Callable[[Array], Array], p: Array, step: float) -> Array:
    """Return the derivatives of a function of p by central differences, (values, parameters)."""
    steps = step * np.eye(p.size)
    columns = [(function(p + each) - function(p - each)) / (2 * step) for each in steps]
    return np.column_stack(columns)


def _least_squares(
    residuals: _Residuals, start: Array, law: Callable[[Array], Array]
) -> tuple[Array, Array]:
    """Return the parameters of the least residuals, (p,), and their covariance, (p, p).

    ``law`` returns the shifts, (m,), of parameters, (p,); ``start`` is their initial guess.
    """
    from scipy.optimize import least_squares  # problems are read and written without SciPy

    def function(p: Array) -> Array:
        """Return the residuals, (2 n,)."""
        return residuals(law(p))

    def jacobian(p: Array) -> Array:
        """Return their derivatives by the parameters, (2 n, p), by the chain rule."""
        by_shift = _derivative(residuals, law(p), DIFFERENCE_STEP)
        return np.asarray(by_shift @ _derivative(law, p, 1e-4))

    found = least_squares(function, start, jacobian, xtol=1e-4, max_nfev=30)
    fit = residuals.fit(law(found.x))
    # also fitted: the long-term modulus and those terms of the series that are not zero
    freedom = max(1, found.fun.size - int((fit.modulus > 0).sum()) - 1 - start.size)
    J = np.asarray(found.jac, dtype=float)
    inverse = np.linalg.pinv(J.T @ J)
    return found.x, inverse * (2 * found.cost / freedom)


def _pair_shift(colder: Isotherm, hotter: Isotherm) -> float:
    """Return log10 a of an isotherm relative to its colder neighbour, by the points that overlap.

    Raises
    ------
    InvalidProblem
        If no shift makes the moduli coincide.
    """
    x, y = np.log10(colder.frequency), np.log10(hotter.frequency)
    fixed, moved = (np.log([each.storage, each.loss]) for each in (colder, hotter))
    lowest, highest = float(x[0] - y[-1]), float(x[-1] - y[0])
    best, shift = np.inf, 0.0
    for d in np.arange(lowest, highest, SEARCH_STEP):
        # points of each isotherm in the range of the other one
        inside = (y + d >= x[0]) & (y + d <= x[-1])
        others = (x >= y[0] + d) & (x <= y[-1] + d)
        if min(inside.sum(), others.sum()) < LEAST_OVERLAP:
            continue
        interpolated = np.array([np.interp(y[inside] + d, x, row) for row in fixed])
        difference = float(np.sqrt(np.mean((interpolated - moved[:, inside]) ** 2)))
        if difference < best:
            best, shift = difference, float(d)
    if best > LARGEST_DIFFERENCE:
        differ = "" if np.isinf(best) else f", where they overlap, by {best:.0%} (rms)"
        raise InvalidProblem.at(
            "isotherms",
            f"the moduli at {colder.temperature:g} and {hotter.temperature:g} differ at any "
            f"shift{differ}; must coincide within {LARGEST_DIFFERENCE:.0%} in at least "
            f"{LEAST_OVERLAP} points: measure at a temperature between them, or over more decades",
        )
    return shift


def log_shift_at(temperature: float, temperatures: Array, shift: Array) -> float:
    """Return log10 a at a temperature between isotherms, interpolated by a monotone cubic.

    Two isotherms are connected by a straight line.  ``temperatures`` rise; ``shift`` is log10 a of
    each, (m,).
    """
    from scipy.interpolate import PchipInterpolator

    if temperatures.size == 2:
        return float(np.interp(temperature, temperatures, shift))
    return float(PchipInterpolator(temperatures, shift)(temperature))
