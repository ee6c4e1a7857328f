"""A nip across the lanes in closed form: P = N (delta/delta_N)^p, and A = mu P."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from lane_rings import Nip

from woundon.roll.lane_tension import Lanes, tension_in_nips

Array = np.ndarray


@dataclass
class PowerNip:
    """The nip of the solver (``woundon.roll.lane_roll.NipsAcross``) and of the independent program.

    Parameters
    ----------
    load : float
        N [N/m].
    stiffness : float
        k = dP/d delta at N [N/m^2].
    friction, exponent : float
        mu and p.
    web : float
        T_in [N/m].
    modulus, thickness : float
        E_t [Pa] and h [m] of the web.
    """

    load: float
    stiffness: float
    friction: float
    web: float
    modulus: float
    thickness: float
    exponent: float = 1.0

    @property
    def approach(self) -> float:
        return self.exponent * self.load / self.stiffness

    @property
    def wound_on(self) -> float:
        """WOT of the mean web [N/m]."""
        return self.web + self.friction * self.load

    def load_at(self, approach: Array) -> tuple[Array, Array]:
        delta = np.maximum(approach, 0.0) / self.approach
        slope = self.stiffness * np.where(delta > 0, np.maximum(delta, 1e-300), 0.0) ** (
            self.exponent - 1
        )
        return self.load * delta**self.exponent, np.where(approach > 0, slope, 0.0)

    def approach_at(self, load: float) -> float:
        return self.approach * (load / self.load) ** (1 / self.exponent)

    def added(self, load: Array) -> tuple[Array, Array]:
        return self.friction * load, np.full_like(load, self.friction)

    def web_tension(self, r: Array) -> Array:
        return np.full(r.shape, self.web)

    def nip_loads(self, r: Array) -> Array:
        return np.full((1, r.size), self.load)

    def deflections(self, lanes: Lanes, loads: Array) -> dict[str, Array]:
        return {}

    def tension_at(self, lanes: Lanes):
        strain = self.wound_on / self.thickness / self.modulus

        def tension(x, c, mu, guess):
            radius = float(np.exp(x))
            return tension_in_nips(
                lanes, c, mu, strain, [self], radius, self.wound_on, self.web, guess
            )

        return tension

    def of_rings(self) -> Nip:
        """Return the same nip for the independent program."""
        return Nip(
            load_at=lambda delta: self.load_at(delta)[0],
            approach_at=self.approach_at,
            added=lambda load: self.friction * load,
            total=self.load,
        )
