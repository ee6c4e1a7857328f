r"""Prony series with non-negative terms that are fitted to measured moduli.

The series E(t) = E_inf + sum_k E_k exp(-t/tau_k) has at the angular frequency omega the modulus

    E(i omega) = E_inf + sum_k E_k i omega tau_k/(1 + i omega tau_k) = E' + i E''.

The tau_k are given, spaced evenly in ln tau; E_inf and E_k >= 0 are the non-negative least squares
solution of the residuals relative to the measured values, so that each decade counts alike.  A
series of many terms E_k >= 0 follows every causal modulus without a source of energy; what it does
not follow contradicts the Kramers-Kronig relations.
"""

from __future__ import annotations

from math import log10, pi, sqrt
from typing import NamedTuple

import numpy as np

__all__ = [
    "PronyFit",
    "complex_modulus",
    "decade_bias",
    "fit_dynamic_moduli",
    "fit_relaxation_modulus",
    "relaxation_times",
    "usable_range",
]

Array = np.ndarray

# Relaxation times of the fitted series: number per decade, and decades by which they extend beyond
# the measured times on both sides.
TIMES_PER_DECADE = 5
EXTENSION = 0.5


class PronyFit(NamedTuple):
    """A fitted series.

    Attributes
    ----------
    long_term : float
        E_inf [Pa].
    modulus, time : (K,) arrays
        E_k [Pa] and tau_k [s].
    residual : (..., n) array
        (fitted - measured)/measured: of E' and E'', (2, n), or of E(t), (n,).
    """

    long_term: float
    modulus: Array
    time: Array
    residual: Array

    @property
    def misfit(self) -> float:
        """Root mean square of the residuals [1]."""
        return float(sqrt(np.mean(self.residual**2)))


def relaxation_times(shortest: float, longest: float) -> Array:
    """Return the tau_k [s] for measurements at times from ``shortest`` to ``longest`` [s]."""
    low, high = log10(shortest) - EXTENSION, log10(longest) + EXTENSION
    return np.logspace(low, high, 1 + max(1, round(TIMES_PER_DECADE * (high - low))))


def fit_dynamic_moduli(
    frequency: Array, storage: Array, loss: Array, time: Array | None = None
) -> PronyFit:
    """Fit a series to storage and loss moduli.

    Parameters
    ----------
    frequency : (n,) array
        f [Hz], in any order.
    storage, loss : (n,) arrays
        E' and E'' [Pa], > 0.
    time : (K,) array, optional
        tau_k [s]; by default from the range of frequencies.
    """
    omega = 2 * pi * frequency
    if time is None:
        time = relaxation_times(float(1 / omega.max()), float(1 / omega.min()))
    i_omega_tau = 1j * omega[:, None] * time
    terms = i_omega_tau / (1 + i_omega_tau)
    constant = np.ones((omega.size, 1))
    columns = np.vstack([np.hstack([constant, terms.real]), np.hstack([0 * constant, terms.imag])])
    fit = _fit(columns, np.concatenate([storage, loss]), time)
    return fit._replace(residual=fit.residual.reshape(2, -1))


def fit_relaxation_modulus(t: Array, modulus: Array) -> PronyFit:
    """Fit a series to a relaxation modulus E(t), (n,) arrays [s], [Pa]."""
    time = relaxation_times(float(t.min()), float(t.max()))
    with np.errstate(under="ignore"):  # terms that are relaxed
        terms = np.exp(-t[:, None] / time)
    return _fit(np.hstack([np.ones((t.size, 1)), terms]), modulus, time)


def _fit(columns: Array, measured: Array, time: Array) -> PronyFit:
    """Return the series with the least squares of the relative residuals, all moduli >= 0.

    Parameters
    ----------
    columns : (m, 1 + K) array
        Measured value by the long-term modulus, and by the modulus of each term.
    measured : (m,) array
        [Pa], > 0.
    time : (K,) array
        tau_k [s].
    """
    from scipy.optimize import nnls  # problems are read and written without SciPy

    scale = float(measured.max())  # the unknown moduli are of the order of 1
    relative = columns * (scale / measured)[:, None]
    # neighbouring terms are alike, so that a few tables take more iterations than the default, 3 K
    E, _ = nnls(relative, np.ones(measured.size), maxiter=100 * time.size)
    return PronyFit(float(E[0]) * scale, E[1:] * scale, time, relative @ E - 1)


def complex_modulus(fit: PronyFit, frequency: Array) -> Array:
    """Return E(i omega) of a series at frequencies [Hz], complex, (n,) [Pa]."""
    i_omega_tau = 2j * pi * np.asarray(frequency)[:, None] * fit.time
    return fit.long_term + (i_omega_tau / (1 + i_omega_tau)) @ fit.modulus


def decade_bias(position: Array, residual: Array) -> dict[int, float]:
    """Return the mean residual of largest magnitude of each decade, by the decade's exponent.

    Parameters
    ----------
    position : (n,) array
        Frequencies or times, > 0.
    residual : (n,) or (m, n) array
        Of one or of m quantities; the mean of each is taken separately.
    """
    decade = np.floor(np.log10(position)).astype(int)
    rows = np.atleast_2d(residual)
    bias = {}
    for k in sorted(set(decade.tolist())):
        means = rows[:, decade == k].mean(axis=1)
        bias[k] = float(means[np.abs(means).argmax()])
    return bias


def usable_range(
    frequency: Array, storage: Array, loss: Array, largest_misfit: float
) -> tuple[float, float] | None:
    """Return the widest range of whole decades that a series follows, [Hz]; None without one.

    Parameters
    ----------
    frequency, storage, loss
        As of :func:`fit_dynamic_moduli`.
    largest_misfit : float
        Of the rows in the range [1].

    Notes
    -----
    The misfit increases with the range, so that the end of the range moves up only as its begin
    moves up.
    """
    decade = np.floor(np.log10(frequency)).astype(int)
    first, last = int(decade.min()), int(decade.max())
    best: tuple[int, int] | None = None
    end = first
    for begin in range(first, last + 1):
        end = max(end, begin)
        while end <= last:
            rows = (decade >= begin) & (decade <= end)
            if rows.sum() >= 3:
                fit = fit_dynamic_moduli(frequency[rows], storage[rows], loss[rows])
                if fit.misfit > largest_misfit:
                    break
                if best is None or end - begin > best[1] - best[0]:
                    best = begin, end
            end += 1
    return None if best is None else (10.0 ** best[0], 10.0 ** (best[1] + 1))
