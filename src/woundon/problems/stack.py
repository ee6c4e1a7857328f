"""Stacks: layers of paper or film, whose modulus increases with the pressure.

The law of a stack follows from a complementary energy of the pressure P = -sigma_r through it, the
stress sigma_t along it and the shear stress tau,

    W = int F dP + (nu/E_t) P sigma_t + sigma_t^2/(2 E_t) + tau^2/(2 G),

    eps_r = -F(P) - (nu/E_t) sigma_t + G' tau^2/(2 G^2),    F = int dP/E_r, from P = 0,
    eps_t = (nu/E_t) P + sigma_t/E_t,      gamma = tau/G,

so that its tangent compliances are symmetric: c_rr = 1/E_r(P), c_rt = -nu/E_t, c_tt = 1/E_t.  It is
elastic: the hysteresis of paper is neglected (docs/theory/hardening.md).
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from math import inf
from typing import TYPE_CHECKING, Annotated, Any, Self

import numpy as np
from pydantic import BeforeValidator, Field, model_validator

from ..elasticity.quadrature import gauss_points
from ..errors import InvalidProblem
from ..quantities import Values, as_given, pure, stress
from . import air_law as air_law  # registers its law
from .fields import Number, default
from .materials import SOFTEST, STIFFEST, Solid, Stiffness
from .messages import quote
from .radial_laws import AnyLaw, Pfeiffer

if TYPE_CHECKING:
    from .fields import Nested

__all__ = ["EXAMPLE", "AnyStack", "Stack"]

Array = np.ndarray

# Gauss points per cell of an integral over the pressure, and number of bisections of the cells
# towards zero: a law with K1 = 1e-6 P is integrated to 1e-12.
GAUSS, SMALLEST_CELL = 12, 24
# Newton's method for the plateau pressure, in ln P: the error after a step is about its square.
PLATEAU_STEP, LARGEST_STEP, PLATEAU_STEPS = 1e-8, 3.0, 60
# Thinning per strain along the web above which a web held in its width loses volume by stretching.
MOST_THINNING = 1.0
# Pressure above which no roll is wound [Pa].  Laws that stiffen faster than P^2 have a bounded work
# of compression: above a certain tension no plateau exists.
LAST_PRESSURE = 1e10


class Stack(Solid):
    """The material of a wound roll: hardening through the layers, linear along them.

    Parameters
    ----------
    radial : Pfeiffer, Polynomial, PowerLaw, StackTest or float
        The tangent modulus E_r(P) in uniaxial compression [Pa]; a number is a constant modulus.
    tangential : float
        E_t along the web [Pa].
    poissons_ratio : float
        nu, thinning of the stack per strain along the web in uniaxial tension.
    shear : float
        G [Pa] of the wound stack.
    shear_exponent : float
        beta of G = shear (E_r(P)/E_r(P0))^beta, P0 the pressure wound in.

    Raises
    ------
    InvalidProblem
        If nu^2 >= E_t/E_r(0): the strain energy would be indefinite.

    Examples
    --------
    >>> import woundon as wo
    >>> stack = wo.Stack(radial=wo.Pfeiffer(K1="10 kPa", K2=40), tangential="3.38 GPa",
    ...                  poissons_ratio=0.01, shear="10 MPa")
    >>> float(stack.radial.modulus(100e3))
    4400000.0
    """

    radial: Annotated[AnyLaw, stress("E_r", "radial modulus of the stack", "MPa")]
    tangential: Annotated[
        Number,
        stress("E_t", "modulus along the web", "MPa", (5e8, 1e10)),
        Field(ge=SOFTEST, le=STIFFEST),
    ]
    poissons_ratio: Annotated[
        Number,
        pure("nu", "Poisson's ratio, thinning due to strain along the web", (0.0, 0.3)),
        Field(ge=0, le=10),
    ]
    shear: Annotated[
        Number,
        stress("G", "shear modulus of the wound stack", "MPa", (1e6, 1e8)),
        Field(ge=SOFTEST, le=STIFFEST),
    ]
    shear_exponent: Annotated[
        Number, pure("beta", "exponent of the shear modulus in E_r", (0.0, 1.0)), Field(ge=0, le=2)
    ] = default(0.0)

    @model_validator(mode="after")
    def _check_energy(self) -> Self:
        """Reject a stack with an indefinite strain energy at zero pressure."""
        if self.limit <= 0:
            raise self.beyond_limit(0.0)
        return self

    def beyond_limit(self, P: float) -> InvalidProblem:
        """Return the error for a pressure P >= :attr:`limit` [Pa].

        The strain energy is positive definite if the determinant of the compliances is positive,
        c_rr c_tt > c_rt^2, that is nu^2 < E_t/E_r(P).
        """
        end, E = self.radial.max_pressure, float(self.radial.modulus(P))
        if end <= P:
            text = f"the pressure reaches {P:.4g} [Pa], beyond the range of the stack law, which "
            text += f"ends at {end:.4g} [Pa]; lower the load, or extend the law"
            return InvalidProblem.at("radial", text)
        return InvalidProblem.at(
            "poissons_ratio",
            f"{quote(self.poissons_ratio)} is out of range; must be >= 0 and < "
            f"(tangential/E_r)^(1/2) = {(self.tangential / E) ** 0.5:.4g}, with E_r = {E:.4g} [Pa] "
            f"at the pressure {P:.4g} [Pa], or the strain energy is indefinite",
        )

    def input_warnings(self, field: str) -> Iterator[str]:
        """Yield a sentence if Poisson's ratio appears to be one in the plane of the web.

        Parameters
        ----------
        field : str
            Name of the field that describes the stack.
        """
        if self.poissons_ratio > MOST_THINNING:
            percent = f"{self.poissons_ratio:.3g} %"
            yield (
                f"{field}.poissons_ratio = {self.poissons_ratio:.4g}: stretched by 1 %, the layers "
                f"become {percent} thinner and lose volume; it is the ratio through the thickness, "
                "not that in the plane of the web"
            )

    @property
    def stiffest(self) -> float:
        """E_t/nu^2, the E_r at which the energy becomes indefinite [Pa]."""
        nu = self.poissons_ratio
        return self.tangential / nu**2 if nu > 0 else inf

    @cached_property
    def limit(self) -> float:
        """Largest pressure [Pa]: the end of the law, or the limit of a definite energy."""
        return min(self.radial.max_pressure, self.radial.pressure_at_modulus(self.stiffest))

    @cached_property
    def stiffness(self) -> Stiffness:
        """The plane-strain stiffness A_rr, A_tt, A_rt, G without pressure [Pa]."""
        return self.tangent(0.0)._replace(along=self.tangential)  # D is E_t, without rounding

    def compression_energy(self, P: Values) -> Values:
        """Return int_0^P P' dP'/E_r(P') [Pa], the work of uniaxial compression per volume.

        Parameters
        ----------
        P : array_like
            Pressure [Pa], >= 0.
        """
        p = np.asarray(P, dtype=float)
        # E_r may vary over pressures much smaller than P: cells are bisected towards zero.
        ends = np.append(0.0, 0.5 ** np.arange(SMALLEST_CELL, -1, -1))
        fraction, weight = gauss_points(ends, GAUSS)
        pressures = p[..., None] * fraction
        return as_given(p * ((pressures / self.radial.modulus(pressures)) @ weight))

    def plateau_pressure(self, stress: Values) -> Values:
        """Return the pressure far from core and surface of a roll wound at constant tension [Pa].

        The strain energy of compression equals that of the tension, T^2/(2 E_t) =
        int_0^P P' dP'/E_r, the first integral of the equations of a wound roll without the
        curvature terms.  It is 3 to 13 % too low for rolls of paper and film.

        Parameters
        ----------
        stress : array_like
            T = WOT/h [Pa], >= 0.

        Raises
        ------
        InvalidProblem
            If the law of the stack ends below that pressure.

        Examples
        --------
        >>> import woundon as wo
        >>> stack = wo.Stack(radial=wo.Pfeiffer(K1=10e3, K2=40.0), tangential=3.38e9,
        ...                  poissons_ratio=0.01, shear=10e6)
        >>> round(stack.plateau_pressure(350 / 66e-6))
        196689
        """
        T = np.asarray(stress, dtype=float)
        work = np.maximum(T**2 / (2 * self.tangential), 1e-300)  # > 0 for its logarithm
        # Newton's method in logarithms: d ln W/d ln P is nearly constant, 2 for a constant modulus
        # and 1 for one proportional to P.
        # Initial guess: a constant modulus, that at 1 Pa, as the one at 0 may be 0.
        P = np.sqrt(2 * work * self.radial.modulus(np.zeros(T.shape) + 1.0))
        for _ in range(PLATEAU_STEPS):
            W = self.compression_energy(P)
            # d ln W/d ln P = P^2/(E_r W)
            step = (np.log(work) - np.log(W)) * W * self.radial.modulus(P) / P**2
            P = np.minimum(
                P * np.exp(np.clip(step, -LARGEST_STEP, LARGEST_STEP)), 2 * LAST_PRESSURE
            )
            if np.all(np.abs(step) <= PLATEAU_STEP):
                break
        P = np.where(T > 0, P, 0.0)
        self.check_pressure(P)
        return as_given(P)

    def check_pressure(self, P: float | Array) -> None:
        """Raise an error if a pressure is beyond the range of the law.

        Raises
        ------
        InvalidProblem
        """
        highest, end = float(np.max(P, initial=0.0)), min(self.radial.max_pressure, LAST_PRESSURE)
        if not highest <= end:
            raise InvalidProblem.at(
                "stack.radial",
                f"the law ends at {end:.4g} [Pa], below the pressure wound into the roll",
            )

    def tangent(self, P: float | Array, P0: float | Array | None = None) -> Stiffness:
        """Return the tangent stiffness A_rr, A_tt, A_rt, G without shear [Pa].

        Parameters
        ----------
        P : array_like
            Pressure through the stack [Pa].  For iterates above :attr:`limit` E_r is at most 99.9 %
            of :attr:`stiffest`.
        P0 : array_like, optional
            Wound-in pressure, at which G is ``shear`` [Pa]; by default P.
        """
        E_t, nu = self.tangential, self.poissons_ratio
        E: Any = np.minimum(self.radial.modulus(P), 0.999 * self.stiffest)
        D = 1 - nu * nu * E / E_t
        return Stiffness(E / D, E_t / D, nu * E / D, self.shear_modulus(P, P0))

    def shear_modulus(self, P: float | Array, P0: float | Array | None = None) -> Any:
        """Return G [Pa]; parameters as of :meth:`tangent`."""
        if P0 is None or self.shear_exponent == 0:
            return np.full(np.shape(P), self.shear)[()]
        ratio = self.radial.modulus(P) / self.radial.modulus(P0)
        return self.shear * ratio**self.shear_exponent

    def shear_slope(self, P: float | Array, P0: float | Array | None = None) -> Any:
        """Return G' = dG/dP [1]; parameters as of :meth:`tangent`."""
        rate = self.shear_exponent * self.radial.modulus_slope(P) / self.radial.modulus(P)
        return rate * self.shear_modulus(P, P0)


if TYPE_CHECKING:
    AnyStack = Nested[Stack]
else:
    AnyStack = Annotated[Stack, BeforeValidator(Stack.coerce)]

# Newsprint of the thesis's Table 2; K1 and K2 are illustrative.
EXAMPLE = Stack(
    radial=Pfeiffer(K1=10e3, K2=40.0), tangential=3.38e9, poissons_ratio=0.01, shear=10e6
)
