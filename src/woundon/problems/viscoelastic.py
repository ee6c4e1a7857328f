"""Viscoelastic materials from measurements: a loss angle, or storage and loss moduli.

Both are converted to a Prony series, which :class:`~.materials.Isotropic` accepts directly.
"""

from __future__ import annotations

from functools import cached_property
from math import hypot, log10, pi, sqrt, tan
from typing import Annotated, Self

import numpy as np
from pydantic import Field, model_validator

from ..errors import InvalidProblem
from ..quantities import Quantity, angle, stress
from .fields import Number, Numbers, check_equal_lengths, check_rising
from .materials import SOFTEST, STIFFEST, OneModulus, PoissonsRatio
from .messages import quote

__all__ = ["DynamicTest", "LossAngle"]

# Relaxation times of the fitted series: number per decade, and decades by which they extend beyond
# the measured frequencies on both sides.
TIMES_PER_DECADE = 5
EXTENSION = 0.5
# Relative rms misfit above which a table is rejected, and above which a warning is given.  Tables
# with a scatter of 5 % are usual; 10 % is more than scatter explains.
LARGEST_MISFIT = 0.1
WARNING_MISFIT = 0.05
# Ratio of loss and storage modulus that a table must exceed somewhere.  Steel has about 2e-4; tan
# delta in place of the loss modulus gives 1e-7.
SMALLEST_LOSS = 1e-4


def _frequency(meaning: str) -> Quantity:
    return Quantity("f", "1/s", meaning, shown_unit="Hz", typical=(0.1, 1e4))


class LossAngle(OneModulus):
    """A standard linear solid with a given loss angle at one frequency.

    E(t) = E_inf + E_1 exp(-t/tau).  The loss angle is largest at the given frequency; far from it
    the loss is smaller than that of a real rubber.

    Parameters
    ----------
    youngs_modulus : float
        E_inf, after all relaxation [Pa], 1e-3 to 1e14.
    poissons_ratio : float
        nu, 0 <= nu <= 0.5.
    loss_angle : float
        delta [rad], 1e-6 to 1.5; tan delta is loss over storage modulus.
    frequency : float
        f [Hz].

    Raises
    ------
    InvalidProblem
        For values out of range.

    Examples
    --------
    >>> import woundon as wo
    >>> wo.LossAngle(
    ...     youngs_modulus="5 MPa", poissons_ratio=0.45, loss_angle="10 deg", frequency="100 Hz"
    ... ).relaxes
    True
    """

    youngs_modulus: Annotated[
        Number,
        stress("E_inf", "relaxed Young's modulus", "MPa", (1e6, 1e8)),
        Field(ge=SOFTEST, le=STIFFEST),
    ]
    poissons_ratio: PoissonsRatio
    loss_angle: Annotated[Number, angle("delta", "loss angle", (0.02, 0.5)), Field(ge=1e-6, le=1.5)]
    frequency: Annotated[Number, _frequency("frequency of the loss angle"), Field(ge=1e-9, le=1e12)]

    @property
    def long_term_modulus(self) -> float:
        """E_inf [Pa]."""
        return self.youngs_modulus

    @cached_property
    def prony_series(self) -> tuple[tuple[float, float], ...]:
        """E_1 [Pa] and tau [s]; the largest tan delta is g/(2 sqrt(1+g)) with g = E_1/E_inf."""
        t = tan(self.loss_angle)
        g = 2 * t * (t + hypot(1.0, t))
        return ((g * self.youngs_modulus, 1 / (2 * pi * self.frequency * sqrt(1 + g))),)


class DynamicTest(OneModulus):
    """An isotropic material with a measured table of storage and loss moduli.

    A Prony series is fitted by non-negative least squares of the relative residuals of storage and
    loss modulus, with five relaxation times per decade, from half a decade below to half a decade
    above the measured frequencies.  A table that no such series follows within 10 % violates the
    Kramers-Kronig relations and is rejected.

    Parameters
    ----------
    frequency : sequence of float
        f [Hz], rising; at least 3.
    storage_modulus, loss_modulus : sequence of float
        E' and E'' of Young's modulus [Pa], > 0.
    poissons_ratio : float
        nu, 0 <= nu <= 0.5.

    Raises
    ------
    InvalidProblem
        For columns of different lengths, frequencies that do not rise, moduli that are not causal,
        or loss moduli below 1e-4 of the storage moduli, such as tan delta.

    Examples
    --------
    >>> import woundon as wo
    >>> cover = wo.DynamicTest(
    ...     frequency=[1.0, 10.0, 100.0],
    ...     storage_modulus=[11e6, 15e6, 19e6],
    ...     loss_modulus=[1.7e6, 3e6, 1.7e6],
    ...     poissons_ratio=0.48,
    ... )
    >>> len(cover.frequency)
    3
    """

    frequency: Annotated[
        Numbers, _frequency("frequencies of a dynamic test"), Field(min_length=3, max_length=10_000)
    ]
    storage_modulus: Annotated[
        Numbers, stress("E'", "storage moduli", "MPa"), Field(min_length=3, max_length=10_000)
    ]
    loss_modulus: Annotated[
        Numbers, stress("E''", "loss moduli", "MPa"), Field(min_length=3, max_length=10_000)
    ]
    poissons_ratio: PoissonsRatio

    @model_validator(mode="after")
    def _check_table(self) -> Self:
        """Reject columns of different lengths and values out of range."""
        check_equal_lengths(self, "frequency", "storage_modulus", "loss_modulus")
        for name in ("storage_modulus", "loss_modulus"):
            for k, value in enumerate(getattr(self, name)):
                if not SOFTEST <= value <= STIFFEST:
                    text = f"{quote(value)} is out of range; must be >= 0.001 and <= 1e+14 [Pa]"
                    raise InvalidProblem.at(f"{name}.{k}", text)
        check_rising(self, "frequency", above=0.0)
        losses = zip(self.loss_modulus, self.storage_modulus, strict=True)
        ratio = max(loss / storage for loss, storage in losses)
        if ratio < SMALLEST_LOSS:
            raise InvalidProblem.at(
                "loss_modulus",
                f"is at most {ratio:.2g} of the storage modulus; must reach {SMALLEST_LOSS:g} of "
                "it; values of tan delta are entered multiplied by the storage moduli",
            )
        return self

    @property
    def measured_frequencies(self) -> tuple[float, float]:
        """The lowest and the highest measured frequency [Hz]."""
        return self.frequency[0], self.frequency[-1]

    @model_validator(mode="after")
    def _check_causality(self) -> Self:
        """Reject moduli that contradict the Kramers-Kronig relations."""
        if self.misfit > LARGEST_MISFIT:
            raise InvalidProblem.at(
                "loss_modulus",
                f"disagrees with the storage moduli (Kramers-Kronig relations): the best Prony "
                f"series deviates from the table by {self.misfit:.2g} (rms); must be <= "
                f"{LARGEST_MISFIT:g}",
            )
        return self

    @cached_property
    def _fit(self) -> tuple[tuple[float, ...], tuple[float, ...], float]:
        """(E_inf, E_1, E_2, ...) [Pa], tau_k [s], and the rms of the relative residuals."""
        from scipy.optimize import nnls

        omega = 2 * pi * np.array(self.frequency)
        low, high = log10(1 / omega[-1]) - EXTENSION, log10(1 / omega[0]) + EXTENSION
        tau = np.logspace(low, high, 1 + max(1, round(TIMES_PER_DECADE * (high - low))))
        i_omega_tau = 1j * omega[:, None] * tau
        terms = np.hstack([np.ones((omega.size, 1)), i_omega_tau / (1 + i_omega_tau)])
        storage, loss = np.array(self.storage_modulus), np.array(self.loss_modulus)
        rows = np.vstack([terms.real / storage[:, None], terms.imag / loss[:, None]])
        scale = storage.max()  # the unknown moduli are of the order of 1
        E, residual = nnls(rows * scale, np.ones(2 * omega.size))
        moduli, times = (E * scale).tolist(), tau.tolist()
        return tuple(moduli), tuple(times), float(residual / sqrt(2 * omega.size))

    @property
    def misfit(self) -> float:
        """Root mean square of the relative residuals of storage and loss moduli [1]."""
        _, _, rms = self._fit
        return rms

    @property
    def long_term_modulus(self) -> float:
        """E_inf [Pa], at least 1e-6 of the smallest storage modulus, as for a solid."""
        (E_inf, *_), _, _ = self._fit
        return max(E_inf, 1e-6 * min(self.storage_modulus))

    @cached_property
    def prony_series(self) -> tuple[tuple[float, float], ...]:
        """E_k [Pa] and tau_k [s] of the terms with E_k > 0."""
        E, tau, _ = self._fit
        return tuple((e, t) for e, t in zip(E[1:], tau, strict=True) if e > 0)

    @property
    def validity_warning(self) -> str:
        """A warning if the fit of the series has an error above 5 %, otherwise empty."""
        if self.misfit <= WARNING_MISFIT:
            return ""
        return f"its Prony series deviates from the measured moduli by {self.misfit:.1%} (rms)"
