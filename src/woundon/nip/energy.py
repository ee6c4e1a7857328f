r"""Dissipation in viscoelastic bodies, and the balance of power of a nip.

A material point that meets the tractions p and q at the speed V moves at V v' and V u' in the
body's own frame.  Per length rolled and width, the tractions do the work

    W = int (-p v' + q u') dx,      u' = eps - v/R,

on a body: zero for an elastic one, the dissipation for a viscoelastic one.  The work on both bodies
and the friction work int q v_slip dx of both faces equal the work that shafts and web tensions
supply.  Without the last two, for every stretch of web (kappa its curvature, eps its strain),

    W+ + W- = P e/R* + int q+ (eps - eps_end) dx + int q- (eps + xi) dx - friction + wraps
              - int (q+ v+/R+ + q- v-/R-) dx,

P e the moment of the pressure about the line of centres.  The balance is exact for the continuous
equations; its defect on a mesh is of the order of the discretisation error.

For two rollers without a web, the gap slope v1' + v2' = (x - Delta)/R* and the slip
s = eps2 - eps1 + xi, with q_1 = q and q_2 = -q, give the balance

    sum W_i = P (Delta - x_p)/R* + xi Q - int q s dx - sum int q_i v_i/R_i dx,

x_p being the position of the pressure's resultant.  The left-hand side is evaluated at one point in
each cell for the viscoelastic bodies alone, the right-hand side by exact integrals of the nodal
functions where they are known: the two agree to the order of the discretisation only.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..elasticity.surface import Deformation

if TYPE_CHECKING:
    from ..problems.contact_problem import ContactProblem
    from .contact_equations import Side
    from .equations import NipEquations, NipState

__all__ = [
    "BodyWork",
    "body_work",
    "dissipation",
    "power_balance",
    "pressure_resultant",
    "viscoelastic_outputs",
    "work_on_bodies",
]

Array = np.ndarray


def pressure_resultant(x: Array, p: Array) -> tuple[float, float]:
    """Return the resultant P of a piecewise linear pressure [N/m], and its position along x [m].

    Examples
    --------
    >>> pressure_resultant(np.array([0.0, 3.0]), np.array([0.0, 2.0]))
    (3.0, 2.0)
    """
    load = float(np.trapezoid(p, x))
    moment = np.diff(x) @ (x[:-1] * (2 * p[:-1] + p[1:]) + x[1:] * (p[:-1] + 2 * p[1:])) / 6
    return load, float(moment) / load


class BodyWork(NamedTuple):
    """Fields in the cells of a face, and integrals over it.

    Attributes
    ----------
    p, q, slope : (n-1,) arrays
    lengths : (n-1,) array
        Of the cells [m].
    curvature_work : float
        int q v/R dx, the work of the traction by the term v/R of u' [N/m].
    work : float
        W [N/m].
    """

    p: Array
    q: Array
    slope: Array
    lengths: Array
    curvature_work: float
    work: float


def body_work(side: Side, deformation: Deformation, p: Array, q: Array, a: float) -> BodyWork:
    """Return the work of nodal pressures and tractions on a body, and the fields in its cells.

    Parameters
    ----------
    side : Side
        The body on its face of n nodes.
    deformation : Deformation
        Under these pressures and tractions.
    p, q : (n,) arrays
        [Pa].
    a : float
        Half width [m].
    """
    face, lengths = side.face, a * side.face.cells
    slope, strain = deformation.slope[:-2], deformation.strain[:-2]
    p_cell, q_cell = (face.hats[:-2] @ part for part in (p, q))
    curvature_work = 0.0
    if side.flattening and q.any():
        v = side.displacement(deformation.slope, p, q, a)
        curvature_work = float(lengths @ (q_cell * (v[:-1] + v[1:]) / 2)) / side.radius
    work = float(lengths @ (q_cell * strain - p_cell * slope)) - curvature_work
    return BodyWork(p_cell, q_cell, slope, lengths, curvature_work, work)


def work_on_bodies(state: NipState) -> tuple[BodyWork, BodyWork]:
    """Return the work on the roll and on the drum of a web nip.

    That on the roll is without the work along the deformation by other nips.
    """
    f = state.fields
    a, _, roll, drum = f.geometry
    own = Deformation(f.roll.slope - f.far.slope, f.roll.strain - f.far.strain)
    return body_work(roll, own, *f.on_roll, a), body_work(drum, f.drum, *f.on_drum, a)


def dissipation(problem: ContactProblem, bodies: tuple[BodyWork, BodyWork]) -> float:
    """Return the work on the viscoelastic bodies per length rolled and width [N/m]."""
    pairs = zip(problem.bodies, bodies, strict=True)
    return sum(work.work for body, work in pairs if body.viscoelastic)


def viscoelastic_outputs(
    problem: ContactProblem, bodies: tuple[BodyWork, BodyWork], x: Array, p: Array, offset: float
) -> dict[str, float]:
    """Return the outputs that only contacts with a viscoelastic body have, by name, in SI units.

    Parameters
    ----------
    problem : ContactProblem
        With a viscoelastic body.
    bodies : tuple of BodyWork
        The work on both bodies.
    x, p : (n,) arrays
        Nodes of the contact [m] and the pressure there [Pa].
    offset : float
        Delta [m].
    """
    assert problem.rolling_speed is not None  # required with a viscoelastic body
    resistance = dissipation(problem, bodies)
    return {
        "rolling_resistance": resistance,
        "dissipated_power": problem.rolling_speed * resistance,
        "pressure_shift": pressure_resultant(x, p)[1] - offset,
    }


def power_balance(equations: NipEquations, state: NipState) -> float:
    """Return the signed defect of the balance of power of a web nip, relative to P a/R*.

    That is W+ + W- minus the right-hand side of the balance in the docstring of the module, term by
    term.  All integrals are sums over the cells of a face, with the values at their points.
    """
    layout, f, problem = equations.layout, state.fields, equations.problem
    a, mesh = f.geometry.a, f.geometry.mesh
    web, first, last = problem.web, layout.first, layout.last
    c11, c12 = web.compliance.c11 / web.thickness, web.compliance.c12
    roll, drum = work_on_bodies(state)
    slip_roll, slip_drum = equations.slip_velocities(state.u[layout.xi], f, state.laid_strain)
    tension = f.tension[0] + a * f.transfer[:-1]
    # traction times strain of the web, less the friction work
    reference = -state.laid_strain - c11 * f.tension[-1]
    creepage = state.u[layout.xi] - c11 * f.tension[-1]
    supplied = (roll.lengths * roll.q) @ (c11 * tension[first:] + reference - slip_roll)
    supplied += (drum.lengths * drum.q) @ (c11 * tension[:last] + creepage - slip_drum)
    # the strain -c12 p+ of the web: its work in the nip is that of the thickening c12 q in the gap
    # slope; only that on the roll wrap remains
    wrap = slice(last - first, None)
    supplied -= c12 * (roll.lengths[wrap] * roll.q[wrap]) @ roll.p[wrap]
    # wraps: the hoop pressure T kappa does work along the deformed path of the web
    hoop = a * mesh.cells * mesh.at_points(f.p_roll - f.p_drum)
    supplied += hoop[:last] @ drum.slope - hoop[last:] @ f.roll.slope[:-2][wrap]
    nip = slice(0, last - first)
    # moment of the pressure about the line of centres, and the compression of the web
    lever = state.u[layout.shift] - a * mesh.points[first:last] / problem.contact_radius
    thinning = np.diff(web.thinned(f.p_roll[first : last + 1])[0])
    supplied += roll.p[nip] @ (roll.lengths[nip] * lever - thinning)
    supplied -= roll.curvature_work + drum.curvature_work
    # the work along the deformation by other nips is none of the own work
    supplied -= (roll.lengths * roll.q) @ f.far.strain[:-2]
    supplied += (roll.lengths * roll.p) @ f.far.slope[:-2]
    # the work on an elastic body is zero; its discretisation error is part of the defect
    dissipated = dissipation(problem, (roll, drum))
    return float((dissipated - supplied) / (problem.nip_load * a / problem.contact_radius))
