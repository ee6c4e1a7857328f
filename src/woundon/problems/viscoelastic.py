"""Viscoelastic materials by a loss angle, or by a Prony list of relative moduli.

Both are converted to a Prony series of absolute moduli, which :class:`~.materials.Isotropic`
accepts directly.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import cached_property
from math import hypot, pi, sqrt, tan
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, model_validator

from ..errors import InvalidProblem
from ..quantities import angle, share, stress
from .fields import Number, listed
from .materials import (
    SOFTEST,
    STIFFEST,
    Material,
    OneModulus,
    PoissonsRatio,
    RelaxationTime,
    RelaxingTerm,
    Stiffness,
    isotropic_stiffness,
)
from .measured_moduli import frequency_quantity
from .messages import quote

if TYPE_CHECKING:
    from .fields import CoercedField

__all__ = ["LossAngle", "RelativeProny", "RelativeTerm"]

# Largest sum of the relative moduli of a Prony list: E_0/E_inf of a glassy polymer is at most 1e4.
# A larger sum is 1 but for rounding.
LARGEST_SUM = 1 - 1e-4


# Ratio of frequencies within which a single relaxation time stands for a real material: tan delta
# is 2/(3 + 1/3) = 60 % of the given one there, that of rubber nearly the same.
WIDTH = 3.0


class LossAngle(OneModulus):
    """A standard linear solid with a given loss angle at one frequency.

    E(t) = E_inf + E_1 exp(-t/tau).  The loss angle is largest at the given frequency; far from it
    the loss is smaller than that of a real rubber.  A result has a warning if V/2a of the nip is
    not within a third to three times the frequency.

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
    frequency: Annotated[
        Number, frequency_quantity("frequency of the loss angle"), Field(ge=1e-9, le=1e12)
    ]

    @property
    def long_term_modulus(self) -> float:
        """E_inf [Pa]."""
        return self.youngs_modulus

    @property
    def measured_frequencies(self) -> tuple[float, float]:
        """A third of the frequency and three times it [Hz]."""
        return self.frequency / WIDTH, self.frequency * WIDTH

    @cached_property
    def prony_series(self) -> tuple[tuple[float, float], ...]:
        """E_1 [Pa] and tau [s]; the largest tan delta is g/(2 sqrt(1+g)) with g = E_1/E_inf."""
        t = tan(self.loss_angle)
        g = 2 * t * (t + hypot(1.0, t))
        return ((g * self.youngs_modulus, 1 / (2 * pi * self.frequency * sqrt(1 + g))),)


class RelativeTerm(RelaxingTerm):
    """A term g_k exp(-t/tau_k) of a relative Prony list; fields also accept a pair (g_k, tau_k).

    Parameters
    ----------
    fraction : float
        g_k, the part of the instantaneous modulus that relaxes with tau_k, > 0 and < 1.
    time : float
        tau_k [s], > 0.

    Examples
    --------
    >>> import woundon as wo
    >>> wo.RelativeTerm(fraction="30 %", time="1 ms").fraction
    0.3
    """

    fraction: Annotated[
        Number, share("g_k", "relaxing fraction of the instantaneous modulus"), Field(gt=0, lt=1)
    ]
    time: RelaxationTime


if TYPE_CHECKING:
    RelativeTerms = CoercedField[
        tuple[RelativeTerm, ...],
        Iterable[RelativeTerm | tuple[float | str, float | str] | Mapping[str, Any]],
    ]
else:
    RelativeTerms = Annotated[
        tuple[Annotated[RelativeTerm, BeforeValidator(RelativeTerm.coerce)], ...],
        BeforeValidator(listed),
    ]


class RelativeProny(Material):
    """An isotropic material by a Prony list of relative moduli, as finite element programs use it.

    With ``bulk="relaxing"`` Young's modulus relaxes and Poisson's ratio is constant,

        E(t) = E_0 [1 - sum_k g_k (1 - exp(-t/tau_k))],

    with ``bulk="constant"`` the shear modulus G relaxes in this way and the bulk modulus K does
    not: Poisson's ratio increases with time.  This is the meaning of a list without terms for the
    bulk modulus in Abaqus (g_i without k_i) and Ansys (shear without bulk terms).

    Parameters
    ----------
    instantaneous_modulus : float
        E_0, Young's modulus before any relaxation [Pa], 1e-3 to 1e14.
    poissons_ratio : float
        nu, 0 <= nu <= 0.5; with a constant bulk modulus the ratio before any relaxation.
    prony_relative : sequence of (float, float)
        g_k, > 0 with a sum of less than 1, and tau_k [s], > 0.
    bulk : "relaxing" or "constant"
        Whether the bulk modulus relaxes like the shear modulus.

    Raises
    ------
    InvalidProblem
        For values out of range, and terms whose sum is 1: they leave no modulus after relaxation.

    Examples
    --------
    >>> import woundon as wo
    >>> rubber = wo.RelativeProny(
    ...     instantaneous_modulus="10 MPa", poissons_ratio=0.45, prony_relative=[(0.3, "1 ms")]
    ... )
    >>> round(rubber.long_term_modulus)
    7000000
    """

    instantaneous_modulus: Annotated[
        Number,
        stress("E_0", "instantaneous Young's modulus", "MPa", (1e6, 1e8)),
        Field(ge=SOFTEST, le=STIFFEST),
    ]
    poissons_ratio: PoissonsRatio
    prony_relative: Annotated[
        RelativeTerms,
        Field(min_length=1, max_length=100, description="terms of the modulus relative to E_0"),
    ]
    bulk: Literal["relaxing", "constant"] = "relaxing"

    @model_validator(mode="after")
    def _check_sum(self) -> Self:
        """Reject terms that leave no modulus after relaxation."""
        total = self._relaxing_fraction
        if total > LARGEST_SUM:
            raise InvalidProblem.at(
                "prony_relative",
                f"fractions with the sum {quote(total)} are out of range; must be <= "
                f"{LARGEST_SUM:g}, or no modulus is left after relaxation, as of a fluid; some "
                "programs normalise the fractions to the sum 1 by default (pyvisco without "
                "opt=True): repeat the fit with the long-term modulus as a parameter",
            )
        return self

    @property
    def _relaxing_fraction(self) -> float:
        """The sum of g_k."""
        return sum(term.fraction for term in self.prony_relative)

    @property
    def bulk_is_constant(self) -> bool:
        """True if the shear modulus alone relaxes."""
        return self.bulk == "constant"

    @property
    def _long_term(self) -> tuple[float, float]:
        """Young's modulus [Pa] and Poisson's ratio after all relaxation.

        With a constant bulk modulus 1/E = 1/(3 G) + 1/(9 K) and nu = E/(2 G) - 1, where
        1/(9 K) = (1 - 2 nu_0)/(3 E_0) and G = (1 - sum g) G_0.
        """
        E, nu, left = self.instantaneous_modulus, self.poissons_ratio, 1 - self._relaxing_fraction
        if not self.bulk_is_constant:
            return left * E, nu
        shear = left * E / (2 * (1 + nu))
        relaxed = 1 / (1 / (3 * shear) + (1 - 2 * nu) / (3 * E))
        # nu = 1/2 - E/(6 K), without the cancellation of E/(2 G) - 1 near 1/2
        return relaxed, 0.5 - relaxed * (1 - 2 * nu) / (2 * E)

    @property
    def long_term_modulus(self) -> float:
        """E_inf, Young's modulus after all relaxation [Pa]."""
        return self._long_term[0]

    @property
    def long_term_poissons_ratio(self) -> float:
        """nu after all relaxation [1]."""
        return self._long_term[1]

    @property
    def relaxes(self) -> bool:
        """True: a viscoelastic material."""
        return True

    def relaxation(self, speed: float) -> tuple[tuple[float, float], ...]:
        """Return the relaxation in rolling: pairs g_k/(1 - sum g) [1], speed * tau_k [m].

        They belong to all moduli, or with a constant bulk modulus to the shear modulus.
        """
        left = 1 - self._relaxing_fraction
        return tuple((term.fraction / left, speed * term.time) for term in self.prony_relative)

    @cached_property
    def stiffness(self) -> Stiffness:
        """The plane-strain stiffness A_rr = A_tt, A_rt, G, D after all relaxation [Pa]."""
        return isotropic_stiffness(*self._long_term)
