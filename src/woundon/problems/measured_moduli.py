"""Viscoelastic materials by measured tables: dynamic tests and relaxation tests.

A Prony series is fitted to the table, which the problem then uses like a given one.
"""

from __future__ import annotations

from functools import cached_property
from math import pi
from typing import Annotated, Self

import numpy as np
from pydantic import Field, model_validator

from ..elasticity.prony_fit import (
    PronyFit,
    decade_bias,
    fit_dynamic_moduli,
    fit_relaxation_modulus,
    usable_range,
)
from ..errors import InvalidProblem
from ..quantities import Quantity, pure, stress
from .fields import (
    Numbers,
    OptionalNumbers,
    check_equal_lengths,
    check_rising,
    check_within,
    default,
)
from .materials import SOFTEST, STIFFEST, OneModulus, PoissonsRatio
from .messages import quote
from .permitted import Conditional

__all__ = [
    "WARNING_MISFIT",
    "DynamicTest",
    "MeasuredModuli",
    "RelaxationTest",
    "frequency_quantity",
]

Array = np.ndarray

# Relative rms misfit above which a table is rejected, and above which a warning is given.  Tables
# with a scatter of 5 % are usual; 10 % is more than scatter explains.
LARGEST_MISFIT = 0.1
WARNING_MISFIT = 0.05
# Ratio of loss and storage modulus that a table must exceed somewhere.  Steel has about 2e-4; tan
# delta in place of the loss modulus gives 1e-7.
SMALLEST_LOSS = 1e-4
# tan delta, if it is given next to both moduli, differs from their ratio by rounding: instruments
# write three digits.
LARGEST_DIFFERENCE = 0.05
MOST_ROWS = 10_000
MOST_DECADES = 4  # of the bias in a message


def frequency_quantity(meaning: str) -> Quantity:
    """Return the quantity of a frequency [1/s], shown in Hz."""
    return Quantity("f", "1/s", meaning, shown_unit="Hz", typical=(0.1, 1e4))


class MeasuredModuli(OneModulus, abstract=True):
    """An isotropic material whose Prony series is fitted to a measured table."""

    @cached_property
    def _fit(self) -> PronyFit:
        """The fitted series."""
        raise NotImplementedError

    @property
    def _smallest_modulus(self) -> float:
        """The smallest measured modulus [Pa]."""
        raise NotImplementedError

    def _sort_rows(self, by: str, *others: str) -> None:
        """Sort the rows of the table by a column: instruments sweep in either direction."""
        rows = sorted(range(len(getattr(self, by))), key=getattr(self, by).__getitem__)
        for name in (by, *others):
            values = getattr(self, name)
            if values is not None:
                # in __dict__, because fields of a description cannot be set
                self.__dict__[name] = tuple(values[row] for row in rows)

    @property
    def misfit(self) -> float:
        """Root mean square of the relative residuals of the measured moduli [1]."""
        return self._fit.misfit

    @property
    def long_term_modulus(self) -> float:
        """E_inf [Pa], at least 1e-6 of the smallest modulus, as for a solid."""
        return max(self._fit.long_term, 1e-6 * self._smallest_modulus)

    @cached_property
    def prony_series(self) -> tuple[tuple[float, float], ...]:
        """E_k [Pa] and tau_k [s] of the terms with E_k > 0."""
        terms = zip(self._fit.modulus.tolist(), self._fit.time.tolist(), strict=True)
        return tuple((e, t) for e, t in terms if e > 0)

    @property
    def validity_warning(self) -> str:
        """A warning if the fit of the series has an error above 5 %, otherwise empty."""
        if self.misfit <= WARNING_MISFIT:
            return ""
        return f"its Prony series deviates from the measured moduli by {self.misfit:.1%} (rms)"


class DynamicTest(MeasuredModuli):
    """An isotropic material with a measured table of storage and loss moduli.

    A Prony series is fitted by non-negative least squares of the relative residuals of storage and
    loss modulus, with five relaxation times per decade, from half a decade below to half a decade
    above the measured frequencies.  A table that no such series follows within 10 % violates the
    Kramers-Kronig relations and is rejected.

    Parameters
    ----------
    frequency : sequence of float
        f [Hz]; at least 3, different ones in any order.  Texts in "rad/s" are angular frequencies.
    storage_modulus, loss_modulus : sequence of float
        E' and E'' of Young's modulus [Pa], > 0.
    tan_delta : sequence of float
        E''/E', in place of ``loss_modulus``; with it, only to be checked against it.
    poissons_ratio : float
        nu, 0 <= nu <= 0.5; constant.
    frequency_range : (float, float), optional
        Lowest and highest frequency of the rows that are used [Hz]; by default all.  A nip needs
        those from two decades below V/2a upwards.

    Raises
    ------
    InvalidProblem
        For columns of different lengths, repeated frequencies, moduli that are not causal, or loss
        moduli below 1e-4 of the storage moduli, such as tan delta.

    Examples
    --------
    >>> import woundon as wo
    >>> cover = wo.DynamicTest(
    ...     frequency=[1.0, 10.0, 100.0],
    ...     storage_modulus=[11e6, 15e6, 19e6],
    ...     tan_delta=[0.15, 0.2, 0.09],
    ...     poissons_ratio=0.48,
    ... )
    >>> len(cover.prony_series) > 1
    True
    """

    frequency: Annotated[
        Numbers,
        frequency_quantity("frequencies of a dynamic test"),
        Field(min_length=3, max_length=MOST_ROWS),
    ]
    storage_modulus: Annotated[
        Numbers, stress("E'", "storage moduli", "MPa"), Field(min_length=3, max_length=MOST_ROWS)
    ]
    loss_modulus: Annotated[
        OptionalNumbers,
        stress("E''", "loss moduli", "MPa"),
        Field(min_length=3, max_length=MOST_ROWS),
        Conditional("required without tan_delta"),
    ] = default(None)
    tan_delta: Annotated[
        OptionalNumbers,
        pure("tan delta", "loss over storage moduli", (0.02, 1.0)),
        Field(min_length=3, max_length=MOST_ROWS),
        Conditional("required without loss_modulus"),
    ] = default(None)
    poissons_ratio: PoissonsRatio
    frequency_range: Annotated[
        OptionalNumbers,
        frequency_quantity("lowest and highest frequency that is used"),
        Field(min_length=2, max_length=2),
    ] = default(None)

    @model_validator(mode="after")
    def _check_table(self) -> Self:
        """Sort the rows; reject columns of different lengths and values out of range."""
        columns = ("storage_modulus", "loss_modulus", "tan_delta")
        given = [name for name in columns if getattr(self, name) is not None]
        if self.loss_modulus is None and self.tan_delta is None:
            text = "missing; must be moduli [Pa], unless tan_delta is given"
            raise InvalidProblem.at("loss_modulus", text)
        check_equal_lengths(self, "frequency", *given)
        check_within(self, "storage_modulus", SOFTEST, STIFFEST)
        check_within(self, "loss_modulus", SOFTEST, STIFFEST)
        for k, value in enumerate(self.tan_delta or ()):
            if not 0 < value <= 100:
                text = f"{quote(value)} is out of range; must be > 0 and <= 100"
                raise InvalidProblem.at(f"tan_delta.{k}", text)
        self._sort_rows("frequency", *columns)
        check_rising(self, "frequency", above=0.0)
        self._check_losses()
        return self

    def _check_losses(self) -> None:
        """Reject losses that are negligible, or differ from tan delta."""
        losses, storage = np.array(self._losses), np.array(self.storage_modulus)
        ratio = float((losses / storage).max())
        if ratio < SMALLEST_LOSS:
            text = (
                f"is at most {ratio:.2g} of the storage modulus; must reach {SMALLEST_LOSS:g} of "
                "it; a column of loss over storage modulus is tan_delta"
            )
            name = "loss_modulus" if self.tan_delta is None else "tan_delta"
            raise InvalidProblem.at(name, text)
        if self.tan_delta is not None and self.loss_modulus is not None:
            expected = np.array(self.loss_modulus) / storage
            difference = np.abs(np.array(self.tan_delta) / expected - 1)
            k = int(difference.argmax())
            if difference[k] > LARGEST_DIFFERENCE:
                text = (
                    f"{quote(self.tan_delta[k])} differs from loss_modulus / storage_modulus = "
                    f"{expected[k]:.4g}; must agree within {LARGEST_DIFFERENCE:.0%}, or be left out"
                )
                raise InvalidProblem.at(f"tan_delta.{k}", text)

    @model_validator(mode="after")
    def _check_range(self) -> Self:
        """Reject a range of frequencies that has fewer than three rows."""
        if self.frequency_range is not None:
            check_rising(self, "frequency_range", above=0.0)
            rows = int(self._is_used.sum())
            if rows < 3:
                text = f"contains {rows} of the measured frequencies; must contain at least 3"
                raise InvalidProblem.at("frequency_range", text)
        return self

    @model_validator(mode="after")
    def _check_causality(self) -> Self:
        """Reject moduli that contradict the Kramers-Kronig relations."""
        if self.misfit > LARGEST_MISFIT:
            raise InvalidProblem.at(
                "loss_modulus" if self.loss_modulus is not None else "tan_delta",
                f"disagrees with the storage moduli (Kramers-Kronig relations): the best Prony "
                f"series deviates from the table by {self.misfit:.2g} (rms); must be <= "
                f"{LARGEST_MISFIT:g}{self._remedy()}",
            )
        return self

    def _remedy(self) -> str:
        """Return the decades with the largest bias, and the range that a series follows."""
        f, storage, loss = self.measured_moduli
        if np.log10(f[-1] / f[0]) < MOST_DECADES:  # all of the table is of the same kind
            return ""
        bias = decade_bias(f, self._fit.residual)
        worst = sorted(sorted(bias, key=lambda k: -abs(bias[k]))[:MOST_DECADES])
        text = ", ".join(f"{bias[k]:+.0%} from 1e{k} Hz" for k in worst)
        usable = usable_range(f, storage, loss, WARNING_MISFIT)
        if usable is None:
            return f"; mean deviation by decade: {text}"
        low, high = usable
        return (
            f"; mean deviation by decade: {text}; with frequency_range = [{low:g}, {high:g}] the "
            f"series deviates by less than {WARNING_MISFIT:.0%}, and a nip needs the rows from two "
            "decades below V/2a upwards"
        )

    @property
    def _losses(self) -> tuple[float, ...]:
        """E'' [Pa]: as given, or tan delta times E'."""
        if self.loss_modulus is not None:
            return self.loss_modulus
        return tuple(
            tan_delta * storage
            for tan_delta, storage in zip(self.tan_delta or (), self.storage_modulus, strict=True)
        )

    @property
    def _is_used(self) -> Array:
        """True for the rows in ``frequency_range``, (n,)."""
        f = np.array(self.frequency)
        low, high = self.frequency_range or (f[0], f[-1])
        return np.array((f >= low) & (f <= high))

    @property
    def measured_moduli(self) -> tuple[Array, Array, Array]:
        """f [Hz], E' and E'' [Pa] of the rows that are used, (n,) each."""
        rows = self._is_used
        columns = self.frequency, self.storage_modulus, self._losses
        f, storage, loss = (np.array(column)[rows] for column in columns)
        return f, storage, loss

    @property
    def measured_frequencies(self) -> tuple[float, float]:
        """The lowest and the highest measured frequency that is used [Hz]."""
        f, _, _ = self.measured_moduli
        return float(f[0]), float(f[-1])

    @cached_property
    def _fit(self) -> PronyFit:
        return fit_dynamic_moduli(*self.measured_moduli)

    @property
    def _smallest_modulus(self) -> float:
        return min(self.storage_modulus)


class RelaxationTest(MeasuredModuli):
    """An isotropic material with a measured relaxation modulus E(t).

    A Prony series is fitted by non-negative least squares of the relative residuals, with five
    relaxation times per decade, from half a decade below to half a decade above the measured times.
    The modulus may rise by its scatter.  A table that no such series follows within 10 % is
    rejected.

    Parameters
    ----------
    time : sequence of float
        t after the step of the strain [s], > 0; at least 3, different ones in any order.
    modulus : sequence of float
        E(t), stress over strain in uniaxial tension or compression [Pa], > 0.
    poissons_ratio : float
        nu, 0 <= nu <= 0.5; constant.

    Raises
    ------
    InvalidProblem
        For columns of different lengths, repeated times, or moduli that do not relax.

    Notes
    -----
    A test from t_1 to t_2 is a measurement at the frequencies from 1/(2 pi t_2) to 1/(2 pi t_1).
    The nip's begin at V/2a, so that a test needs times of less than a millisecond, or tests at
    several temperatures.

    Examples
    --------
    >>> import woundon as wo
    >>> test = wo.RelaxationTest(
    ...     time=["1 ms", "10 ms", "100 ms", "1 s"],
    ...     modulus=["12 MPa", "10 MPa", "9 MPa", "8.6 MPa"],
    ...     poissons_ratio=0.48,
    ... )
    >>> round(test.measured_frequencies[1])
    159
    """

    time: Annotated[
        Numbers,
        Quantity("t", "s", "times of a relaxation test", "s", (1e-4, 1e4)),
        Field(min_length=3, max_length=MOST_ROWS),
    ]
    modulus: Annotated[
        Numbers,
        stress("E(t)", "relaxation moduli", "MPa"),
        Field(min_length=3, max_length=MOST_ROWS),
    ]
    poissons_ratio: PoissonsRatio

    @model_validator(mode="after")
    def _check_table(self) -> Self:
        """Sort the rows; reject columns of different lengths and values out of range."""
        check_equal_lengths(self, "time", "modulus")
        check_within(self, "modulus", SOFTEST, STIFFEST)
        self._sort_rows("time", "modulus")
        check_rising(self, "time", above=0.0)
        if self.misfit > LARGEST_MISFIT:
            bias = decade_bias(np.array(self.time), self._fit.residual)
            worst = max(bias, key=lambda k: abs(bias[k]))
            raise InvalidProblem.at(
                "modulus",
                f"does not relax: the best Prony series deviates from the table by "
                f"{self.misfit:.2g} (rms), by {bias[worst]:+.0%} from 1e{worst} s on; must be <= "
                f"{LARGEST_MISFIT:g}",
            )
        if not self.prony_series:
            text = "does not fall; an elastic material is Isotropic(youngs_modulus, poissons_ratio)"
            raise InvalidProblem.at("modulus", text)
        return self

    @property
    def measured_frequencies(self) -> tuple[float, float]:
        """1/(2 pi t) of the longest and of the shortest time [Hz]."""
        return 1 / (2 * pi * self.time[-1]), 1 / (2 * pi * self.time[0])

    @cached_property
    def _fit(self) -> PronyFit:
        return fit_relaxation_modulus(np.array(self.time), np.array(self.modulus))

    @property
    def _smallest_modulus(self) -> float:
        return min(self.modulus)
