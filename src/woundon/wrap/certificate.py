"""The certificate of a wrapped nip: every law measured on the arrays that its result reports."""

from __future__ import annotations

from math import exp, inf
from typing import TYPE_CHECKING

import numpy as np

from ..contact.certificate import (
    beyond_rounding,
    friction_laws,
    from_edge,
    integral,
    largest,
    misplaced_slips,
    positive_pressure,
)
from ..contact.response import Tractions
from ..errors import InvalidProblem
from ..losses import Surface, balance_law
from ..results import Residuals
from ..two_bodies import mesh_of, within
from .equations import Known, WrapEquations
from .grid import OVERLAP, WrapGrid, grid_for, grid_of_0_1
from .laws import Along

if TYPE_CHECKING:
    from .result import WrappedNipResult

__all__ = ["certificate", "equations_of", "surfaces_of", "unknowns_of"]

Array = np.ndarray

BESIDE = 2 * OVERLAP
# of slopes, which rounding leaves of them in the finite elements of a roll that is not linear: up
# to 2e-10 are seen, by which the turn over the shortest cells misses 2e-8 of the curvature
TURNED = 1e-9
SURE = 1e-9  # of a law: below, nobody asks how much of it is rounding


def equations_of(result: WrappedNipResult) -> WrapEquations:
    """Assemble the equations of a result anew, about what it reports."""
    known = Known(
        result.web_tension, result.curvature,
        Tractions(result.roll_pressure, result.roll_traction),
        Tractions(result.pressure, result.drum_traction),
    )  # fmt: skip
    return WrapEquations(result.problem, _grid_of(result), result.half_width, known)


def _grid_of(result: WrappedNipResult) -> WrapGrid:
    """Return the grid: the nip's mesh, and as many cells on the arcs as there are nodes left.

    Raises
    ------
    InvalidProblem
        If the nodes cannot be those of such a nip.
    """
    first, mesh = result.in_nip.start, mesh_of(result)
    behind = result.x.size - first - mesh.nodes.size
    a = result.half_width
    args = result.problem, mesh.grid, a, first, max(behind, 1)
    grid = grid_for(*args)
    if grid.size != result.x.size or grid.first != first:
        raise InvalidProblem.at("x", f"its nodes are not those of a nip of half width {a:.6g} m")

    def apart(grid: WrapGrid) -> float:
        same = grid.size == result.x.size and grid.first == first
        return float(np.max(np.abs(result.x / a - grid.nodes))) if same else inf

    if apart(grid) < SURE * grid.size:
        return grid
    # one that began on the other side of where the arcs' shape changes
    beside = (grid_for(*args[:2], a * exp(side * BESIDE), *args[3:]) for side in (-1, 1))
    like_beside = (grid_for(*args, like) for like in beside)
    return min(grid, *like_beside, grid_of_0_1(*args), key=apart)


def unknowns_of(result: WrappedNipResult, equations: WrapEquations) -> tuple[Array, Array, float]:
    """Return z, q and the rigid slip that a result reports."""
    z = np.concatenate([
        result.roll_pressure[equations.roll_nodes], result.pressure[equations.drum_nodes],
        [result.offset / result.problem.contact_radius],
    ])  # fmt: skip
    q = np.concatenate([
        result.roll_traction[equations.roll_q], result.drum_traction[equations.drum_q],
    ])  # fmt: skip
    # the solved rigid slip is referred to the tension at the far side
    far = float(result.web_tension[-1])
    return z, q, result.drum_creep + equations.web.c11 / result.problem.web.thickness * far


def certificate(result: WrappedNipResult, equations: WrapEquations) -> Residuals:
    """Measure every law of a result.

    Parameters
    ----------
    result : WrappedNipResult
    equations : WrapEquations
        Its own; see :func:`equations_of`.
    """
    problem, grid, x, a = result.problem, equations.grid, result.x, result.half_width
    P, T = problem.nip_load, result.web_tension
    problem.web.refuse(max(float(np.max(p)) for p in (result.pressure, result.roll_pressure)))
    top = float(np.max(np.abs(grid.points[grid.first : grid.last])))
    top *= a / problem.contact_radius
    z, q, creep = unknowns_of(result, equations)
    along = equations.laws.at(z, q)
    slips = equations.at_nodes(along, creep)
    gained = from_edge(result.roll_traction + result.drum_traction, x)
    nip = result.in_nip
    carried = integral(result.pressure[nip], x[nip])
    force = integral(result.drum_traction, x) - problem.winding_force
    return Residuals(
        indentation=_indentation(equations, z, along.gap / top, top),
        positive_pressure=positive_pressure(result.roll_pressure, result.pressure),
        **_friction(result, equations, q, slips, top),
        slip_speed=largest([
            _differ(np.array([result.roll_slip, result.drum_slip]), slips, result.drum_creep),
            _differ(result.roll_strain, roll_strain(equations, along)),
        ]) / top,
        load_equilibrium=abs(carried / P - 1),
        force_equilibrium=beyond_rounding(np.asarray(force), T) / P,
        web_equilibrium=beyond_rounding(T - problem.web_tension - gained, T) / P,
        hoop_pressure=_hoop(result, equations),
        curvature=_curvature(result, equations, along.bend, top) / largest(np.abs(along.bend)),
        half_width=largest([
            largest(np.abs(x / a - grid.nodes) / np.maximum(1.0, np.abs(grid.nodes))),
            misplaced_slips(result.slip_x, x) / a,
        ]),
        **within(problem, (face.response for face in equations.laws.both)),
        **balance_law(
            result, lambda: surfaces_of(result, equations),
            lambda roll, drum: _put_in(result, equations, roll, drum),
        ),
    )  # fmt: skip


def surfaces_of(result: WrappedNipResult, equations: WrapEquations) -> tuple[Surface, Surface]:
    """Return the surfaces of roll and drum in nip and arcs."""
    return equations.laws.surfaces(
        Tractions(result.roll_pressure, result.roll_traction),
        Tractions(result.pressure, result.drum_traction),
    )


def _put_in(
    result: WrappedNipResult, equations: WrapEquations, roll: Surface, drum: Surface
) -> float:
    """Return what shafts and web tension put in less what friction takes [N/m].

    Beside what a plain nip has, T kappa works as the web goes along a path that is not a circle:
    on the drum up to the trailing edge, then on the roll.
    """
    problem, grid, a, web = equations.problem, equations.grid, result.half_width, equations.web
    first, last = grid.first, grid.last
    q = result.roll_traction + result.drum_traction
    tension = problem.web_tension + a * grid.to_points @ q
    stretched = web.c11 / problem.web.thickness * tension
    edge = float(equations.laws.roll.under(result.roll_pressure, result.roll_traction).strain[-1])
    edge += web.c12 * float(result.roll_pressure[-1])
    edge -= web.c11 / problem.web.thickness * float(result.web_tension[-1])
    # a node has the slip of the cell before it
    each = roll.length * roll.traction * (stretched[first:] + edge - result.roll_slip[first + 1 :])
    each[last - first :] -= (roll.length * roll.traction * roll.pressure)[last - first :] * web.c12
    slip = result.drum_slip[1 : last + 1]
    work = drum.length @ (drum.traction * (stretched[:last] + result.drum_creep - slip))
    weight = a * grid.cells * (grid.value @ result.hoop_pressure)
    work += weight[:last] @ drum.slope - weight[last:] @ roll.slope[last - first :]
    nip, shift = slice(0, last - first), result.offset / problem.contact_radius
    lever = shift - a * grid.points[first:last] / problem.contact_radius
    thinner = -np.diff(problem.web.thinned(result.roll_pressure[first : last + 1])[0])
    work += roll.pressure[nip] @ (roll.length[nip] * lever + thinner)
    return float(each.sum() + work) - roll.turned - drum.turned


def _friction(
    result: WrappedNipResult, equations: WrapEquations, q: Array, slips: Array, top: float
) -> dict[str, float]:
    on_roll, on_drum, friction = equations.roll_q, equations.drum_q, equations.friction
    p = np.concatenate([result.roll_pressure[on_roll], result.pressure[on_drum]])
    zones = np.concatenate([result.roll_zone[on_roll], result.drum_zone[on_drum]])
    v = np.concatenate([slips[0, on_roll], slips[1, on_drum]])
    unit = friction * np.max(np.abs(p))
    return dict(
        friction_laws(
            zones, q, v, friction * p, unit=unit, slip_scale=top, strain=result.drum_creep
        )
    )


def _differ(one: Array, two: Array, size: float = 0.0) -> float:
    """Return the largest difference of what is known to the rounding of ``size``.

    nan must stand where it stands in both.
    """
    if not np.array_equal(np.isnan(one), np.isnan(two)):
        return float("inf")
    both = ~np.isnan(one)
    return beyond_rounding(one[both] - two[both], np.asarray(size))


def _hoop(result: WrappedNipResult, equations: WrapEquations) -> float:
    """Return the miss of p+ - p- = T kappa where the web weighs on what it lies on."""
    weight = np.where(equations.weighs, result.web_tension * result.curvature, 0.0)
    own = float(np.max(np.abs(weight)))
    top = own if equations.weighs.any() else float(np.max(result.roll_pressure))
    miss = np.abs(result.roll_pressure - result.pressure - weight)
    return largest([largest(miss), largest(np.abs(result.hoop_pressure - weight))]) / top


def _curvature(
    result: WrappedNipResult, equations: WrapEquations, bend: Array, top: float
) -> float:
    """Return the miss of the curvature, the turn between points over their distance."""
    miss, points = np.abs(result.curvature - bend), result.half_width * equations.grid.points
    if not result.problem.linear:
        apart = np.diff(points, prepend=2 * points[0] - points[1])
        miss -= TURNED * top / np.append(apart, apart[-1])
    return largest(np.maximum(miss, 0.0))


def _indentation(equations: WrapEquations, z: Array, miss: Array, top: float) -> float:
    """Return the miss of the gap's slope, relative to its largest; less rounding where it matters.

    The pressure of a taut web on its arcs may be many times that of a light nip; rounding of a sum
    of k terms is about k^1/2 times theirs.
    """
    worst = largest(np.abs(miss))
    if worst < SURE:
        return worst
    _, by_z, _ = equations.indentation
    return beyond_rounding(miss, z.size**0.5 * (np.abs(by_z) @ np.abs(z)) / top)


def roll_strain(equations: WrapEquations, along: Along) -> Array:
    """Return the roll's surface strain in the cell before each node, (N,); nan before the nip."""
    first, strain = equations.grid.first, along.roll.strain
    out = np.full(equations.grid.size, np.nan)
    out[first], out[first + 1 :] = strain[0], strain[:-1]
    return out
