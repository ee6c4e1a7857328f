r"""A stack that stiffens under pressure: stresses and tangent by strains, of one potential.

About the wound state, of pressure P0, a nip adds stresses s_r, s_t, tau and strains e_r, e_t,
gamma.  The pressure is P = P0 - s_r.  The complementary energy

    W* = Phi(P) - (nu/E_t) s_r s_t + s_t^2/(2 E_t) + tau^2/(2 G(P)),   Phi' = F(P) - F(P0),

of the radial law F(P), F' = 1/E_r(P), gives by e_r = dW*/ds_r = -dW*/dP and so on

    e_r   = -(F(P) - F(P0)) - (nu/E_t) s_t + G' tau^2/(2 G^2)
    e_t   = (s_t - nu s_r)/E_t
    gamma = tau/G.

The last term of e_r is what a shear modulus that grows with the pressure asks for.  Solved for the
stresses all follows from P, at every point the root of

    f(P) = F(P) - F(P0) - nu^2/E_t (P - P0) - G'(P) gamma^2/2 = -(e_r + nu e_t),

where f' = 1/M > 0 while E_r < E_t/nu^2; then s_t = E_t e_t - nu (P - P0), tau = G gamma, and

    ds_r  [ M            nu M                -M G' gamma           ] de_r
    ds_t = [ nu M         E_t + nu^2 M        -nu M G' gamma        ] de_t
    dtau   [ -M G' gamma  -nu M G' gamma      G + M (G' gamma)^2    ] dgamma.

Newton's trial states may leave the range of the law; F and G go on along their tangents there, and
whoever has found a solution asks whether it is inside.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple, Protocol

import numpy as np

__all__ = ["HardeningLaw", "RadialLaw", "Stressed"]

Array = np.ndarray

MOST_MODULUS = 0.95  # of E_t/nu^2: beyond, trial states find this modulus
LEAST_MODULUS = 0.05  # of that at zero pressure: there a stack counts as torn
LOCAL_STEPS = 50
LOCAL_STEP = 1e-9  # of the pressure: the error after a step of Newton's method is its square


class RadialLaw(Protocol):
    """Compression of a stack through its thickness, defined for trial pressures of any size."""

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
        """Return P by F(P) [Pa]."""
        ...

    def pressure_at_modulus(self, modulus: float) -> float:
        """Return the pressure at which E_r is ``modulus``; inf if it never is [Pa]."""
        ...


class Stressed(NamedTuple):
    """Stresses added, r, t and rt (..., 3), their tangent (..., 3, 3), and P (...) [Pa]."""

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
        """Pressure at which the law ends, or E_r is 95 % of E_t/nu^2 [Pa]; inf if neither is."""
        nu, radial = self.poissons_ratio, self.radial
        stiff = radial.pressure_at_modulus(MOST_MODULUS * self.tangential / nu**2) if nu else np.inf
        return min(stiff, radial.max_pressure)

    @cached_property
    def lowest(self) -> float:
        """Pressure, below zero, at which E_r is 5 % of what it is at zero [Pa]; -inf if constant.

        There a stack comes apart; laws are to go on along their tangent from zero to here.
        """
        zero = np.zeros(())
        slope = float(self.radial.modulus_slope(zero))
        if not 0 < slope < np.inf:
            return -np.inf
        return (LEAST_MODULUS - 1) * float(self.radial.modulus(zero)) / slope

    def stiffness(self, P0: float) -> tuple[float, float, float, float]:
        """Return A_rr, A_tt, A_rt, G of the wound stack [Pa]."""
        E_t, nu, E_r = (
            self.tangential,
            self.poissons_ratio,
            float(self.radial.modulus(np.asarray(P0))),
        )
        D = 1 - nu * nu * E_r / E_t
        return E_r / D, E_t / D, nu * E_r / D, self.shear

    def stressed(self, strain: Array, P0: Array, guess: Array | None = None) -> Stressed:
        """Return the stresses that strains add to a stack wound under P0.

        Parameters
        ----------
        strain : (..., 3) array
            e_r, e_t, gamma.
        P0 : (...) array
            [Pa].
        guess : (...) array, optional
            Pressures P to start from [Pa]; they change rounding only.
        """
        e_r, e_t, gamma = np.moveaxis(strain, -1, 0)
        E_t, nu = self.tangential, self.poissons_ratio
        P = self._pressure(-(e_r + nu * e_t), gamma, P0, guess)
        rise, G, G_slope = self._rise(P, gamma, P0)
        M, coupling = 1 / rise, -G_slope * gamma / rise
        stress = np.stack([P0 - P, E_t * e_t - nu * (P - P0), G * gamma], axis=-1)
        tangent = np.empty((*P.shape, 3, 3))
        tangent[..., 0, 0] = M
        tangent[..., 0, 1] = tangent[..., 1, 0] = nu * M
        tangent[..., 1, 1] = E_t + nu * nu * M
        tangent[..., 0, 2] = tangent[..., 2, 0] = coupling
        tangent[..., 1, 2] = tangent[..., 2, 1] = nu * coupling
        tangent[..., 2, 2] = G + M * (G_slope * gamma) ** 2
        return Stressed(stress, tangent, P)

    def _pressure(self, h: Array, gamma: Array, P0: Array, guess: Array | None) -> Array:
        """Return the root P of f(P) = h by Newton's method, which may start from a guess."""
        radial, give = self.radial, self.poissons_ratio**2 / self.tangential
        F0 = radial.strain_at(P0)
        P = self._inverse(F0 + h) if guess is None else guess
        if guess is None and give == 0 and self.shear_exponent == 0:
            return P
        for _ in range(LOCAL_STEPS):
            rise, _, G_slope = self._rise(P, gamma, P0)
            miss = h - (self._strain(P) - F0 - give * (P - P0) - G_slope * gamma**2 / 2)
            step = miss / rise
            P = P + step
            if np.all(np.abs(step) <= LOCAL_STEP * (np.abs(P) + np.abs(P0))):
                return P
        return P if guess is None else self._pressure(h, gamma, P0, None)

    def _rise(self, P: Array, gamma: Array, P0: Array) -> tuple[Array, Array, Array]:
        """Return f'(P), G and G'; f' positive beyond the law's range too."""
        radial, beta = self.radial, self.shear_exponent
        own = np.minimum(P, self.limit)
        E = radial.modulus(own)
        rise = 1 / E - self.poissons_ratio**2 / self.tangential
        if beta == 0:
            return rise, np.full(P.shape, self.shear), np.zeros(P.shape)
        # beyond the law's ends G goes on along its tangent, so that f has no step
        own = np.maximum(own, self.lowest)
        E, slope = radial.modulus(own), radial.modulus_slope(own)
        G = self.shear * (E / radial.modulus(P0)) ** beta
        steep = beta * slope / E
        step = 1e-4 * E / np.maximum(slope, 1.0)
        bend = (radial.modulus_slope(own + step) - radial.modulus_slope(own - step)) / (2 * step)
        G_bend = np.where(own == P, G * beta * bend / E + G * steep * (steep - slope / E), 0.0)
        rise = np.maximum(rise - G_bend * gamma**2 / 2, 0.1 * rise)
        return rise, G * np.maximum(1 + steep * (P - own), 0.05), G * steep

    def _strain(self, P: Array) -> Array:
        low = np.minimum(P, self.limit)
        return self.radial.strain_at(low) + (P - low) / self.radial.modulus(low)

    def _inverse(self, strain: Array) -> Array:
        if np.isinf(self.limit):
            return self.radial.pressure_at(strain)
        limit = np.asarray(self.limit)
        low = np.minimum(strain, self.radial.strain_at(limit))
        beyond = (strain - low) * self.radial.modulus(limit)
        return self.radial.pressure_at(low) + beyond
