"""Viscoelastic materials by what is measured: a loss angle, or a table of storage and loss moduli.

Both come to a Prony series, as :class:`~.materials.Isotropic` takes it directly.
"""

from __future__ import annotations

from functools import cached_property
from itertools import pairwise
from math import hypot, log10, pi, sqrt, tan
from typing import Annotated, Self

import numpy as np
from pydantic import Field, model_validator

from ..errors import InvalidProblem
from ..quantities import Quantity, angle, stress
from .fields import Number, Numbers
from .materials import SOFTEST, STIFFEST, OneModulus, PoissonsRatio
from .messages import quote

__all__ = ["DynamicTest", "LossAngle"]

PER_DECADE = 5  # relaxation times
BEYOND = 0.5  # decades to either side of the measured frequencies
LARGEST_MISFIT = 0.1
TOLD_MISFIT = 0.05


def _frequency(meaning: str) -> Quantity:
    return Quantity("f", "1/s", meaning, "Hz", (0.1, 1e4))


class LossAngle(OneModulus):
    """An isotropic material of which a loss angle at one frequency is known: a standard solid.

    E(t) = E_inf + E_1 exp(-t/tau), the one whose loss is largest at that frequency; far from it the
    loss is less than in a real rubber.

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
    """

    youngs_modulus: Annotated[
        Number,
        stress("E_inf", "Young's modulus after all relaxation", "MPa", (1e6, 1e8)),
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
        """E_1 [Pa] and tau [s]: tan delta = g/(2 sqrt(1+g)), g = E_1/E_inf, at its largest."""
        t = tan(self.loss_angle)
        g = 2 * t * (t + hypot(1.0, t))
        return ((g * self.youngs_modulus, 1 / (2 * pi * self.frequency * sqrt(1 + g))),)


class DynamicTest(OneModulus):
    """An isotropic material by a measured table of storage and loss moduli.

    A Prony series is fitted to it, five times a decade, no modulus negative, half a decade beyond
    the measured frequencies; relative misfits count, of storage and loss alike.  What such a series
    cannot follow is not causal (Kramers and Kronig), and is refused beyond 10 %.

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
        For tables of unlike lengths, frequencies that do not rise, or moduli that are not causal.
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
    def _is_a_table(self) -> Self:
        for name in ("storage_modulus", "loss_modulus"):
            values = getattr(self, name)
            if len(values) != len(self.frequency):
                text = f"{len(values)} values; must be as many as of frequency, "
                raise InvalidProblem.at(name, f"{text}{len(self.frequency)}")
            for k, value in enumerate(values):
                if not SOFTEST <= value <= STIFFEST:
                    text = f"{quote(value)} is out of range; must be >= 0.001 and <= 1e+14 [Pa]"
                    raise InvalidProblem.at(f"{name}.{k}", text)
        for k, (before, value) in enumerate(pairwise((0.0, *self.frequency))):
            if value <= before:
                what = ", the value before it" if k else ""
                text = f"{quote(value)} is out of range; must be > {quote(before)} [1/s]{what}"
                raise InvalidProblem.at(f"frequency.{k}", text)
        return self

    @model_validator(mode="after")
    def _is_causal(self) -> Self:
        if self.misfit > LARGEST_MISFIT:
            raise InvalidProblem.at(
                "loss_modulus",
                f"misses what the storage moduli imply: no series of relaxing moduli is nearer to "
                f"the table than {self.misfit:.2g}; must be within {LARGEST_MISFIT:g} (Kramers and "
                "Kronig)",
            )
        return self

    @cached_property
    def _fit(self) -> tuple[tuple[float, ...], tuple[float, ...], float]:
        """E_inf and E_k [Pa], tau_k [s], and the rms of the relative misfits."""
        from scipy.optimize import nnls

        omega = 2 * pi * np.array(self.frequency)
        low, high = log10(1 / omega[-1]) - BEYOND, log10(1 / omega[0]) + BEYOND
        tau = np.logspace(low, high, 1 + max(1, round(PER_DECADE * (high - low))))
        wave = 1j * omega[:, None] * tau
        terms = np.hstack([np.ones((omega.size, 1)), wave / (1 + wave)])
        storage, loss = np.array(self.storage_modulus), np.array(self.loss_modulus)
        rows = np.vstack([terms.real / storage[:, None], terms.imag / loss[:, None]])
        scale = storage.max()
        E, miss = nnls(rows * scale, np.ones(2 * omega.size))
        found, times = (E * scale).tolist(), tau.tolist()
        return tuple(found), tuple(times), float(miss / sqrt(2 * omega.size))

    @property
    def misfit(self) -> float:
        """Rms of what the series misses of storage and loss moduli, relative [1]."""
        return self._fit[2]

    @property
    def long_term_modulus(self) -> float:
        """E_inf [Pa]; at least a millionth of the least storage modulus, for a liquid has none."""
        return max(self._fit[0][0], 1e-6 * min(self.storage_modulus))

    @cached_property
    def prony_series(self) -> tuple[tuple[float, float], ...]:
        """E_k [Pa] and tau_k [s], those that are not nil."""
        E, tau, _ = self._fit
        return tuple((e, t) for e, t in zip(E[1:], tau, strict=True) if e > 0)

    @property
    def caution(self) -> str:
        """How far the series is from the table, where it is far."""
        if self.misfit <= TOLD_MISFIT:
            return ""
        return f"its Prony series misses the measured moduli by {self.misfit:.1%} (rms)"
