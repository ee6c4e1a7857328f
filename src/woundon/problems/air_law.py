"""The radial law of a stack with air between its layers."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from pydantic import Field

from ..quantities import length, stress
from .fields import Number, default
from .radial_laws import AnySolidLaw, RadialLaw

__all__ = ["AirBetween", "AmbientPressure"]

Array = np.ndarray


AmbientPressure = Annotated[
    Number, stress("p_a", "ambient pressure", "kPa", (80e3, 105e3)), Field(ge=1e3, le=1e7)
]


class AirBetween(RadialLaw):
    """A stack with a trapped air film between its layers: stack and air in series.

    A layer of web thickness t with a film h has the thickness t (1 - F(P)) + h p_a/(p_a + P) under
    the pressure P (isothermal air), so that E_r = (t + h)/(t/E_r(P) + h p_a/(p_a + P)^2).
    Contact between the layers through the film is neglected: the stack is as soft as trapped air
    can make it (after Good and Holmberg, Effect of air entrainment in centerwound rolls, abstract).

    Parameters
    ----------
    law : Pfeiffer, Polynomial, PowerLaw, StackTest or float
        Law of the stack without air.
    film : float
        h between two layers at ambient pressure [m].
    web_thickness : float
        t [m].
    ambient_pressure : float
        p_a [Pa].

    Examples
    --------
    >>> import woundon as wo
    >>> paper = wo.Pfeiffer(K1=10e3, K2=40.0)
    >>> law = wo.AirBetween(law=paper, film="2 um", web_thickness="66 um")
    >>> bool(law.modulus(0.0) < paper.modulus(0.0))
    True
    """

    law: Annotated[AnySolidLaw, stress("E_r", "radial modulus of the stack without air", "MPa")]
    film: Annotated[
        Number,
        length("h", "air film between two layers", "um", (0.0, 10e-6)),
        Field(ge=0, le=0.1),
    ]
    web_thickness: Annotated[
        Number, length("t", "web thickness", "um", (1e-5, 5e-4)), Field(gt=0, le=0.1)
    ]
    ambient_pressure: AmbientPressure = default(101325.0)

    @property
    def max_pressure(self) -> float:
        """Largest pressure of the law [Pa]."""
        return float(self.law.max_pressure)

    def _compliance(self, P: Array) -> Array:
        """Return 1/E_r(P): the strains of web and film, in the shares of their thicknesses.

        The film h under ambient pressure p_a is compressed isothermally to h p_a/(p_a + P).
        """
        h, t, p_a = self.film, self.web_thickness, self.ambient_pressure
        return (t / self.law.modulus(P) + h * p_a / (p_a + P) ** 2) / (t + h)

    def _modulus(self, P: Array) -> Array:
        return 1 / self._compliance(P)

    def _slope(self, P: Array) -> Array:
        """Return dE_r/dP = -(d(1/E_r)/dP) E_r^2, the compliance as of :meth:`_compliance`."""
        h, t, p_a = self.film, self.web_thickness, self.ambient_pressure
        of_stack = t * self.law.modulus_slope(P) / self.law.modulus(P) ** 2
        of_air = 2 * h * p_a / (p_a + P) ** 3
        return (of_stack + of_air) / (t + h) / self._compliance(P) ** 2

    def _strain(self, P: Array) -> Array:
        h, t, p_a = self.film, self.web_thickness, self.ambient_pressure
        return (t * self.law.strain_at(P) + h * P / (p_a + P)) / (t + h)
