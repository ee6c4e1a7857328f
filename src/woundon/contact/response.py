"""What a body answers on a grid: the slope, strain and displacement of its surface, as matrices.

A grid has n columns, one for each nodal pressure p and traction q that is unknown, and K points,
one in each cell and one at the end, in units of the half width a.  At every point

    dv/dx = slope  + slope_p p  + slope_q q        v: outward displacement
    eps   = strain + strain_p p + strain_q q       eps: strain along the surface

where slope and strain, what the linearisation leaves at zero tractions, are nil for a linear body.
A body that had to find an equilibrium inside it to answer says how well that is kept.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple, Protocol

import numpy as np

__all__ = [
    "Act",
    "ContactGrid",
    "Displace",
    "Gradients",
    "Response",
    "Tractions",
    "on_columns",
    "padded",
]

Array = np.ndarray
Gradients = tuple[Array, Array, Array, Array]
# points in units of a, or None for the grid's last one -> (k, n) by unit p and by unit q [m/Pa];
# or of what there is without tractions: v and u, (k,) [m]
Displace = Callable[[Array | None], tuple[Array, Array]]
Act = Callable[[Array, Array], tuple[Array, Array]]  # p, q -> slope, strain


class Tractions(NamedTuple):
    """Pressure and traction along +x at a grid's columns, (n,) each [Pa]."""

    pressure: Array
    traction: Array


def padded(values: Array) -> Array:
    """Return nodal values with the zeros of both ends."""
    out = np.zeros(values.size + 2)
    out[1:-1] = values
    return out


def on_columns(old: Array, new: Array, loads: Tractions) -> Tractions:
    """Carry loads over to other columns, linearly; they vanish at the ends -1 and 1."""
    nodes = np.concatenate([[-1.0], old, [1.0]])
    return Tractions(*(np.interp(new, nodes, padded(part)) for part in loads))


class ContactGrid(Protocol):
    """What a body sees of the grid that it is asked to respond on; lengths in units of a."""

    @property
    def columns(self) -> Array:
        """Where the unknown nodal tractions are, (n,)."""
        ...

    @property
    def nodes(self) -> Array:
        """Nodes of the piecewise linear tractions: the columns, and ends where they vanish."""
        ...

    @property
    def points(self) -> Array:
        """Where slope and strain are wanted: one point in each cell, then the end, (K,)."""
        ...

    @property
    def value(self) -> Array:
        """Traction at the points by its nodal values, (K, n)."""
        ...

    @property
    def slope(self) -> Array:
        """Its derivative there, per a, (K, n)."""
        ...

    def integrated(self, kernels: Any, curvature: float, radius: float, a: float) -> Response:
        """Return the response of a linear body by its influence functions.

        Parameters
        ----------
        kernels : SurfaceKernels
        curvature : float
            1/R where the strain has the term v/R, 0 where it has not [1/m].
        radius : float
            R [m].
        a : float
            Half width [m].
        """
        ...


class Response:
    """A body's linear response on a grid of n columns and K points.

    Parameters
    ----------
    gradients : tuple of (K, n) arrays, or callable
        slope_p, slope_q, strain_p, strain_q; or what makes them when first asked for.
    normal, tangent : callable, optional
        The displacement v, and u along +x, at any points (see the methods); nil without.
    slope, strain : (K,) arrays or 0
        What a linearised body has at zero tractions.
    rest : callable, optional
        The displacements v and u that it has then, at any points; nil without.
    imbalance : float or None
        What forces inside the body leave of its equilibrium, relative to the load; None where it
        had none to find.
    outside : str
        Empty, or in what the body is outside the range of its own law.
    pressure_slope : callable, optional
        Makes slope_p in the cells alone, (K-1, n), where that is cheaper.
    act : callable, optional
        Makes (p, q) -> slope and strain, (K,) each, where that is cheaper than by the gradients.
    terms : int
        Fourier terms summed, ``truncation_error`` their estimated relative error.

    Attributes
    ----------
    kept : bool
        Whether gradients, and v at the grid's last point, are to be kept once made.
    """

    kept = False
    _act: Act | None = None
    _at_end: tuple[Array, Array] | None = None

    def __init__(
        self,
        gradients: Gradients | Callable[[], Gradients],
        normal: Displace | None = None,
        tangent: Displace | None = None,
        *,
        slope: Array | float = 0.0,
        strain: Array | float = 0.0,
        rest: Displace | None = None,
        imbalance: float | None = None,
        outside: str = "",
        pressure_slope: Callable[[], Array] | None = None,
        act: Callable[[], Act] | None = None,
        terms: int = 0,
        truncation_error: float = 0.0,
    ) -> None:
        self._gradients, self._pressure_slope, self._make_act = gradients, pressure_slope, act
        self._normal, self._tangent = normal, tangent
        self.slope, self.strain, self._rest = slope, strain, rest
        self.imbalance, self.outside = imbalance, outside
        self.terms, self.truncation_error = terms, truncation_error

    @property  # not kept: they are asked for once, and fill the processor's memory
    def gradients(self) -> Gradients:
        """slope_p, slope_q, strain_p, strain_q, (K, n) each."""
        if not callable(self._gradients):
            return self._gradients
        made = self._gradients()
        if self.kept:
            self._gradients = made
        return made

    @property
    def acts(self) -> bool:
        """Whether it tells what given tractions do without its gradients."""
        return self._make_act is not None

    def pressure_slope(self) -> Array:
        """Return slope_p in the cells alone, (K-1, n)."""
        if self._pressure_slope is not None:
            return self._pressure_slope()
        return self.gradients[0][:-1]

    def act(self, p: Array, q: Array) -> tuple[Array, Array]:
        """Return slope and strain at the points under tractions, (K,) each; of a linear body."""
        if self._act is None and self._make_act is not None:
            self._act = self._make_act()
        if self._act is not None:
            return self._act(p, q)
        slope_p, slope_q, strain_p, strain_q = self.gradients
        return slope_p @ p + slope_q @ q, strain_p @ p + strain_q @ q

    def normal(self, points: Array | None = None) -> tuple[Array, Array]:
        """Return v at points in units of a (at the last of the grid's own), by p and by q."""
        if points is not None or not self.kept:
            return self._displacement(self._normal, points)
        if self._at_end is None:
            self._at_end = self._displacement(self._normal, None)
        return self._at_end

    def tangent(self, points: Array | None = None) -> tuple[Array, Array]:
        """Return u along +x at points in units of a, by p and by q, (k, n) each [m/Pa]."""
        return self._displacement(self._tangent, points)

    def rest(self, points: Array | None = None) -> tuple[Array, Array]:
        """Return v and u at zero tractions, (k,) each [m]; nil of a linear body."""
        if self._rest is not None:
            return self._rest(points)
        return (np.zeros(1 if points is None else points.size),) * 2

    def _displacement(self, displace: Displace | None, points: Array | None) -> tuple[Array, Array]:
        if displace is not None:
            return displace(points)
        none = np.zeros((1 if points is None else points.size, self.gradients[0].shape[1]))
        return none, none

    @classmethod
    def none(cls, grid: ContactGrid) -> Response:
        """Return the response of a body that does not deform."""
        return cls(lambda: (np.zeros((grid.points.size, grid.columns.size)),) * 4)
