r"""Constitutive law of a stack that hardens under pressure: stresses and tangent from strains.

To the wound state with the pressure P0 a nip adds the stresses s_r, s_t, tau and the strains e_r,
e_t, gamma.  The pressure is P = P0 - s_r.  With the radial law F(P), F' = 1/E_r(P), the
complementary energy is

    W* = Phi(P) - (nu/E_t) s_r s_t + s_t^2/(2 E_t) + tau^2/(2 G(P)),   Phi' = F(P) - F(P0),

and e_r = dW*/ds_r = -dW*/dP, e_t = dW*/ds_t, gamma = dW*/dtau:

    e_r   = -(F(P) - F(P0)) - (nu/E_t) s_t + G' tau^2/(2 G^2)
    e_t   = (s_t - nu s_r)/E_t
    gamma = tau/G.

The last term of e_r follows from the dependence of G on the pressure.  The inverse needs P, at
every point the root of

    f(P) = F(P) - F(P0) - nu^2/E_t (P - P0) - G'(P) gamma^2/2 = -(e_r + nu e_t),

with f' = 1/M > 0 for E_r < E_t/nu^2.  Then s_t = E_t e_t - nu (P - P0), tau = G gamma, and

    ds_r  [ M            nu M                -M G' gamma           ] de_r
    ds_t = [ nu M         E_t + nu^2 M        -nu M G' gamma        ] de_t
    dtau   [ -M G' gamma  -nu M G' gamma      G + M (G' gamma)^2    ] dgamma.

Iterates of Newton's method may leave the range of the law, where F and G continue along their
tangents.  The converged solution is checked by
:meth:`.hardening_surface.HardeningSurface.range_message`.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple, Protocol

import numpy as np

__all__ = ["HardeningLaw", "RadialLaw", "StressState"]

Array = np.ndarray

# Largest E_r of iterates, relative to E_t/nu^2, at which the stack would be incompressible.
MAX_MODULUS = 0.95
MIN_MODULUS = 0.05  # relative to zero pressure: a stack with a lower modulus is torn
# Least f' of iterates relative to that without shear, and least G relative to that at the ends of
# the law.
LEAST_COMPLIANCE, LEAST_SHEAR = 0.1, 0.05
MAX_ITERATIONS = 50  # of Newton's method for the pressure
LAST_STEP = 1e-9  # of the pressure: the error after a step of Newton's method is its square


class RadialLaw(Protocol):
    """Compression of a stack through its thickness, also defined for negative pressures."""

    @property
    def max_pressure(self) -> float:
        """Pressure at which the law ends [Pa]."""
        ...

    def modulus(self, P: Array) -> Array:
        """Return E_r(P) [Pa]."""
        ...

    def modulus_slope(self, P: Array) -> Array:
        """Return dE_r/dP [1]."""
        ...

    def strain_at(self, P: Array) -> Array:
        """Return F(P), compression positive [1]."""
        ...

    def pressure_at(self, strain: Array) -> Array:
        """Return the pressure P at which F(P) is ``strain`` [Pa]."""
        ...

    def pressure_at_modulus(self, modulus: float) -> float:
        """Return the pressure at which E_r is ``modulus``; inf if it never is [Pa]."""
        ...


class StressState(NamedTuple):
    """Stresses s_r, s_t, tau (..., 3), their tangent (..., 3, 3), and the pressure P (...) [Pa]."""

    stress: Array
    tangent: Array
    pressure: Array


@dataclass(frozen=True)
class HardeningLaw:
    """A stack material in plane strain.

    Parameters
    ----------
    radial : RadialLaw
    tangential : float
        E_t [Pa].
    poissons_ratio : float
        nu.
    shear : float
        G at the wound pressure [Pa].
    shear_exponent : float
        beta of G = shear (E_r(P)/E_r(P0))^beta.
    """

    radial: RadialLaw
    tangential: float
    poissons_ratio: float
    shear: float
    shear_exponent: float = 0.0

    @cached_property
    def limit(self) -> float:
        """Pressure at which the law ends, or E_r is 95 % of E_t/nu^2; inf without either [Pa]."""
        nu, radial = self.poissons_ratio, self.radial
        stiff = radial.pressure_at_modulus(MAX_MODULUS * self.tangential / nu**2) if nu else np.inf
        return min(stiff, radial.max_pressure)

    @cached_property
    def min_pressure(self) -> float:
        """Negative pressure at which E_r is 5 % of that at zero pressure [Pa]; -inf if constant.

        A stack is torn there.  Laws continue along their tangent from zero to this pressure.
        """
        zero = np.zeros(())
        slope = float(self.radial.modulus_slope(zero))
        if not 0 < slope < np.inf:
            return -np.inf
        return (MIN_MODULUS - 1) * float(self.radial.modulus(zero)) / slope

    def stiffness(self, P0: float) -> tuple[float, float, float, float]:
        """Return A_rr, A_tt, A_rt, G of the wound stack [Pa]."""
        E_t, nu = self.tangential, self.poissons_ratio
        E_r = float(self.radial.modulus(np.asarray(P0)))
        D = 1 - nu * nu * E_r / E_t
        return E_r / D, E_t / D, nu * E_r / D, self.shear

    def stress_state(self, strain: Array, P0: Array, guess: Array | None = None) -> StressState:
        """Return the stresses added by strains to a stack wound with the pressure P0.

        Parameters
        ----------
        strain : (..., 3) array
            e_r, e_t, gamma.
        P0 : (...) array
            [Pa].
        guess : (...) array, optional
            Initial guess of P [Pa].
        """
        e_r, e_t, gamma = np.moveaxis(strain, -1, 0)
        E_t, nu = self.tangential, self.poissons_ratio
        P = self._pressure(-(e_r + nu * e_t), gamma, P0, guess)
        slope, G, G_slope = self._derivatives(P, gamma, P0)
        M, coupling = 1 / slope, -G_slope * gamma / slope
        stress = np.stack([P0 - P, E_t * e_t - nu * (P - P0), G * gamma], axis=-1)
        tangent = np.empty((*P.shape, 3, 3))
        tangent[..., 0, 0] = M
        tangent[..., 0, 1] = tangent[..., 1, 0] = nu * M
        tangent[..., 1, 1] = E_t + nu * nu * M
        tangent[..., 0, 2] = tangent[..., 2, 0] = coupling
        tangent[..., 1, 2] = tangent[..., 2, 1] = nu * coupling
        tangent[..., 2, 2] = G + M * (G_slope * gamma) ** 2
        return StressState(stress, tangent, P)

    def _pressure(self, target: Array, gamma: Array, P0: Array, guess: Array | None) -> Array:
        """Return the root P of f(P) = target by Newton's method, (...) [Pa].

        f(P) = F(P) - F(P0) - nu^2/E_t (P - P0) - G'(P) gamma^2/2, F the compression of the stack.

        Parameters
        ----------
        target, gamma, P0 : (...) arrays
            -(e_r + nu e_t) and the shear strain [1]; the wound pressure [Pa].
        guess : (...) array, optional
            Initial guess [Pa]; without it, and if it does not converge, the root for nu = 0 and a
            constant G.
        """
        c = self.poissons_ratio**2 / self.tangential
        F0 = self.radial.strain_at(P0)
        P = self._pressure_at_strain(F0 + target) if guess is None else guess
        if guess is None and c == 0 and self.shear_exponent == 0:
            return P  # exact: f(P) = F(P) - F(P0)
        for _ in range(MAX_ITERATIONS):
            slope, _, G_slope = self._derivatives(P, gamma, P0)
            f = self._strain(P) - F0 - c * (P - P0) - G_slope * gamma**2 / 2
            step = (target - f) / slope
            P = P + step
            if np.all(np.abs(step) <= LAST_STEP * (np.abs(P) + np.abs(P0))):
                return P
        return P if guess is None else self._pressure(target, gamma, P0, None)

    def _derivatives(self, P: Array, gamma: Array, P0: Array) -> tuple[Array, Array, Array]:
        """Return f'(P) [1/Pa], the shear modulus G [Pa] and G' = dG/dP [1], (...) arrays.

        f' = 1/E_r - nu^2/E_t - G'' gamma^2/2 and G = shear (E_r/E_r(P0))^beta.

        Lower bounds keep f' and G positive for iterates: f' where the shear strain gamma is large,
        G far below the least pressure of the law.
        """
        radial, beta = self.radial, self.shear_exponent
        in_range = np.minimum(P, self.limit)
        E = radial.modulus(in_range)
        f_slope = 1 / E - self.poissons_ratio**2 / self.tangential
        if beta == 0:
            return f_slope, np.full(P.shape, self.shear), np.zeros(P.shape)
        # outside the range G continues along its tangent, so that f has no step
        in_range = np.maximum(in_range, self.min_pressure)
        E, E_slope = radial.modulus(in_range), radial.modulus_slope(in_range)
        G = self.shear * (E / radial.modulus(P0)) ** beta
        rate = beta * E_slope / E  # G'/G
        # E_r'' by a central difference
        step = 1e-4 * E / np.maximum(E_slope, 1.0)
        difference = radial.modulus_slope(in_range + step) - radial.modulus_slope(in_range - step)
        E_second = difference / (2 * step)
        G_second = G * beta * E_second / E + G * rate * (rate - E_slope / E)
        G_second = np.where(in_range == P, G_second, 0.0)  # zero on the tangent
        f_slope = np.maximum(f_slope - G_second * gamma**2 / 2, LEAST_COMPLIANCE * f_slope)
        return f_slope, G * np.maximum(1 + rate * (P - in_range), LEAST_SHEAR), G * rate

    def _strain(self, P: Array) -> Array:
        """Return F(P) of pressures of any shape, continued linearly above the limit."""
        in_range = np.minimum(P, self.limit)
        return self.radial.strain_at(in_range) + (P - in_range) / self.radial.modulus(in_range)

    def _pressure_at_strain(self, strain: Array) -> Array:
        """Return the P at which F(P) is ``strain``, of its shape; linear above the limit."""
        if np.isinf(self.limit):
            return self.radial.pressure_at(strain)
        limit = np.asarray(self.limit)
        in_range = np.minimum(strain, self.radial.strain_at(limit))
        return self.radial.pressure_at(in_range) + (strain - in_range) * self.radial.modulus(limit)
