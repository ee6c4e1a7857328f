r"""What rolling viscoelastic bodies dissipate, and the balance of power of a contact.

A material point that meets the tractions p and q at the speed V moves at V v' and V u' in the
body's own frame, so that per speed and width the tractions' work on a body is

    W_i = int [-p v_i' + q_i u_i'] dx,      u' = eps - v/R,

nothing of an elastic body, what it dissipates of a viscoelastic one.  With the friction
int q slip dx of each face, and what closes the gap, the sum over a contact is

    sum W_i + friction = P e/R* + sum (creep Q) + web - sum int q_i v_i/R_i dx,

P e the moment of the pressure about the line of centres, creep Q the work of tractions between
surfaces of different speeds, web that of the tension on the strained web; the last term belongs to
the torques, as q acts at R + v.  The right-hand side is what shafts and tensions put in.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import isnan, nan
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import numpy as np

from .contact.certificate import integral
from .contact.response import Response, Tractions
from .quantities import Quantity, length, line_load

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from .contact.meshes import Mesh

__all__ = ["Losses", "Surface", "balance_law", "lost", "pressed", "surface", "surfaces"]

Array = np.ndarray
FREE = 1e-12  # resultant of tractions, of their size, that is rounding: no constant of v matters


class Surface(NamedTuple):
    """A body's surface in the cells of a contact, (N,) each."""

    slope: Array
    strain: Array
    normal: Array  # v [m]; not told of a flat one, a constant left out where it does no work
    pressure: Array
    traction: Array
    length: Array  # of the cells [m]
    curvature: float

    @property
    def turned(self) -> float:
        """int q v/R dx [N/m]: by how much more a torque acts as the surface is farther out."""
        return float(self.curvature * self.length @ (self.traction * self.normal))

    @property
    def work(self) -> float:
        """W, the work of the tractions on the body per length rolled and width [N/m]."""
        each = self.traction * self.strain - self.pressure * self.slope
        return float(self.length @ each) - self.turned


def surface(body: Any, response: Response, mesh: Mesh, a: float, load: Tractions) -> Surface:
    """Return a body's surface under its load on a mesh, in its cells."""
    p, q = load
    value, cells = mesh.value[:-1], a * mesh.grid.cells
    slope, strain = np.zeros((2, cells.size))
    if not body.rigid:
        slope_p, slope_q, strain_p, strain_q = (part[:-1] for part in response.gradients)
        slope, strain = slope_p @ p + slope_q @ q, strain_p @ p + strain_q @ q
    if not body.linear:
        rows = (cells.size + 1,)
        slope = slope + np.broadcast_to(response.slope, rows)[:-1]
        strain = strain + np.broadcast_to(response.strain, rows)[:-1]
    traction, v = value @ q, np.zeros(cells.size)
    if body.curvature and q.any():  # else nobody asks
        steps = slope * cells
        v = steps / 2 - np.cumsum(steps[::-1])[::-1]
        if abs(cells @ traction) > FREE * (cells @ np.abs(traction)):
            by_p, by_q = response.normal()
            v += float((by_p @ p)[0] + (by_q @ q)[0] + response.rest()[0][0])
    return Surface(slope, strain, v, value @ p, traction, cells, body.curvature)


def surfaces(
    problem: Any, responses: Iterable[Response], mesh: Mesh, a: float, loads: Iterable[Tractions]
) -> tuple[Surface, Surface]:
    """Return the surfaces of both bodies."""
    each = zip(problem.bodies, responses, loads, strict=True)
    one, two = (surface(body, response, mesh, a, load) for body, response, load in each)
    return one, two


def lost(problem: Any, bodies: tuple[Surface, Surface]) -> float:
    """Return what the viscoelastic bodies dissipate per length rolled and width [N/m]."""
    pairs = zip(problem.bodies, bodies, strict=True)
    return sum(own.work for body, own in pairs if body.viscoelastic)


def balance_law(
    result: Any, bodies: Callable[[], tuple[Surface, Surface]],
    put_in: Callable[[Surface, Surface], float],
) -> dict[str, float]:  # fmt: skip
    """Return the law of the balance of power, where a body is viscoelastic.

    Parameters
    ----------
    result : Result
    bodies : callable
        () -> the surfaces of both.
    put_in : callable
        What shafts and tensions put in less what friction takes, of the surfaces [N/m].
    """
    problem, told = result.problem, result.rolling_resistance
    if not problem.viscoelastic:
        return {} if isnan(told) else {"power_balance": float("inf")}
    both = one, two = bodies()
    elastic = one.work + two.work - lost(problem, both)  # nothing but for the cells
    size = float(one.length @ one.pressure) * result.half_width / problem.contact_radius
    return {"power_balance": abs(told + elastic - put_in(one, two)) / size}


def pressed(problem: Any, x: Array, shift: float, one: Surface, two: Surface) -> float:
    """Return P e/R* less what the torques have from the surfaces' being farther out [N/m]."""
    moment = one.length @ (one.pressure * (shift - x / problem.contact_radius))
    return float(moment) - one.turned - two.turned


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class Losses:
    """Outputs of rolling contacts with a viscoelastic body; nan without one.

    Attributes
    ----------
    rolling_resistance : float
        What the viscoelastic bodies dissipate per length rolled [N/m], a force per metre of width.
    """

    rolling_resistance: Annotated[
        float, line_load("F_R", "rolling resistance of the viscoelastic bodies")
    ] = nan

    @property
    def dissipated_power(
        self,
    ) -> Annotated[
        float, Quantity("D", "W/m", "power that the viscoelastic bodies turn into heat, per width")
    ]:
        """V F_R [W/m]: the heat that goes into the covers."""
        V = self.problem.rolling_speed  # type: ignore[attr-defined]
        return nan if V is None else float(V * self.rolling_resistance)

    @property
    def pressure_shift(
        self,
    ) -> Annotated[
        float, length("e_p", "the pressure's resultant behind the line of centres, < 0: before it")
    ]:
        """Where the pressure's resultant is along +x, from the line of centres [m]."""
        own: Any = self
        if own.problem.rolling_speed is None:
            return nan
        nip = own.in_nip
        x, p = own.x[nip], own.pressure[nip]
        moment = np.diff(x) @ (x[:-1] * (2 * p[:-1] + p[1:]) + x[1:] * (p[:-1] + 2 * p[1:])) / 6
        return float(moment) / integral(p, x) - float(own.offset)
