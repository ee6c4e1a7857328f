r"""Contact without friction: the largest load of one contact, and the half width of a load.

A contact of the half width a without friction satisfies

    v1' + v2' + (thickness change of the web)' + Delta/R* = x/R*,

a linear system for p and Delta, whose load int p dx is that of the half width.  The load grows with
the half width, up to the widest one for which the model of the bodies holds.

An open tube bends, and the pressure in the middle of the contact decreases.  At the half width
where it vanishes the surfaces separate, and no single contact carries a larger load.  The linear
system has solutions with positive pressures again at half widths of the order of the radius, but no
increasing load leads to them, and the gap of such a contact is not x^2/2R*.
"""

from __future__ import annotations

from functools import lru_cache
from math import inf, log

import numpy as np

from ..elasticity.mesh import Face, Wrap, nip_mesh
from ..errors import InvalidProblem
from ..problems.bodies import half_width_guess
from ..problems.contact_problem import ContactProblem

__all__ = [
    "bending_text",
    "check_load",
    "frictionless_half_width",
    "frictionless_pressure",
    "largest_half_width",
    "largest_load",
]

Array = np.ndarray
# Nodes of the mesh for the load limit: loads are accurate to 1 %.
NODES = 17
# Half widths of an open tube that are examined, in geometric progression: their number, and the
# smallest one relative to the largest.
WIDTH_COUNT, SMALLEST_WIDTH = 60, 1e-3
# Half widths without friction lie within a factor of a million of Hertz's.
DOUBLINGS = 20
# Share of its bending load up to which an open tube carries the load like a solid body.
BENDING_SHARE = 0.5
# Smallest pressure in the middle half of a contact in one piece, relative to the largest: friction
# and the tension of the web may reduce it by so much.
MIN_MIDDLE = 0.05


def check_load(problem: ContactProblem, load_field: str) -> None:
    """Reject a load that no single contact of the permitted half width carries.

    Parameters
    ----------
    problem : ContactProblem
        Problems with nonlinear bodies are not examined.
    load_field : str
        Name of the load.

    Raises
    ------
    InvalidProblem
        With the largest admissible load.
    """
    for name, body in zip(problem.pair, problem.bodies, strict=True):
        if body.resolution_fault:
            raise InvalidProblem.at(name, body.resolution_fault)
    if not problem.linear:
        return
    load = float(getattr(problem, load_field))
    bending_tubes = _bending_tubes(problem, load)
    # a contact of twice Hertz's half width usually carries the load: influence functions of larger
    # distances are not needed then
    trial_half_width = min(2 * half_width_guess(load, *problem.bodies), largest_half_width(problem))
    if not bending_tubes and load <= frictionless_load(problem, trial_half_width):
        return
    largest = largest_load(problem, load if bending_tubes else None)
    if load <= largest:
        return
    if bending_tubes:
        body = getattr(problem, bending_tubes[0])
        reason = (
            f"the {bending_tubes[0]} is a tube, {body.thickness:.4g} m thick in all on an open "
            "bore, which a larger load bends instead of being carried by one contact; use a rigid "
            "core, or stiffer or thicker layers"
        )
    else:
        reason = _narrowest_body(problem)
    raise InvalidProblem.at(
        load_field, f"{load:.6g} is out of range; must be <= {largest:.3g} [N/m], about: {reason}"
    )


def bending_text(problem: ContactProblem, load: float) -> str:
    """Return a text about an open tube that a load bends; empty if there is none.

    Friction and the tension of the web may reduce the load that one contact carries.
    """
    bending_tubes = _bending_tubes(problem, load) if problem.linear else []
    if not bending_tubes:
        return ""
    share = load / largest_load(problem, inf)
    return (
        f"the {bending_tubes[0]} is a tube on an open bore, and the load is {share:.0%} of the "
        "largest one that it carries in one contact without friction; use a smaller load"
    )


def _bending_tubes(problem: ContactProblem, load: float) -> list[str]:
    """Return the names of the open tubes that a load bends."""
    R = problem.contact_radius
    return [
        name
        for name, body in zip(problem.pair, problem.bodies, strict=True)
        if load > BENDING_SHARE * body.bending_load(R)
    ]


def largest_load(problem: ContactProblem, sufficient: float | None = None) -> float:
    """Return the largest load of a single contact without friction [N/m].

    Parameters
    ----------
    problem : ContactProblem
    sufficient : float, optional
        A load at which the search may stop.  Half widths are examined from the smallest one, until
        the surfaces separate in the middle of the contact.  By default only the largest half width
        is examined.
    """
    widest = largest_half_width(problem)
    if sufficient is None:
        return frictionless_load(problem, widest)
    face, largest = nip_mesh(NODES, Wrap(), Wrap()).roll_face, 0.0
    middle = np.abs(face.nodes) < 0.5
    for a in np.geomspace(SMALLEST_WIDTH, 1.0, WIDTH_COUNT) * widest:
        p = frictionless_pressure(problem, face, a)
        if p[middle].min() <= MIN_MIDDLE * p.max():
            break
        largest = max(largest, float(a * face.weights @ p))
        if largest >= sufficient:
            break
    return largest


def largest_half_width(problem: ContactProblem) -> float:
    """Return the largest half width for which the model of the bodies holds [m]."""
    return min(min(body.radius, body.max_half_width) for body in problem.bodies)


def frictionless_half_width(
    problem: ContactProblem, load: float, guess: float, largest: float
) -> float:
    """Return the approximate half width at which a frictionless contact carries a load [m].

    The half width is doubled or halved until the load lies in between, and interpolated with powers
    of it.  Where thin layers or open tubes bend, Hertz's half width may be forty times too small.

    Parameters
    ----------
    problem : ContactProblem
        With linear bodies.
    load, guess : float
        [N/m], [m].
    largest : float
        Largest half width that is permitted [m].
    """
    a = min(2 * guess, largest)
    P = frictionless_load(problem, a)
    is_increased = load > P
    for _ in range(DOUBLINGS):
        b, Q = a, P
        a = min(2 * b, largest) if is_increased else b / 2
        P = frictionless_load(problem, a)
        if a == largest or (load > P) != is_increased:
            break
    if not 0 < min(P, Q) < max(P, Q):  # the load does not increase with the half width
        return guess
    exponent = log(load / Q) / log(P / Q)
    return b * (a / b) ** min(max(exponent, 0.0), 1.0)


@lru_cache(maxsize=2)  # the load limit and the initial guess use the same half width
def frictionless_load(problem: ContactProblem, a: float) -> float:
    """Return the load of a frictionless contact of half width ``a`` [N/m]."""
    face = nip_mesh(NODES, Wrap(), Wrap()).roll_face
    return float(a * face.weights @ frictionless_pressure(problem, face, a))


def frictionless_pressure(problem: ContactProblem, face: Face, a: float) -> Array:
    """Return the nodal pressures of a frictionless contact of half width ``a``, (N+1,) [Pa]."""
    N = face.cells.size
    matrix = np.ones((N, N))  # columns: inner pressures, Delta/R*
    zero = np.zeros(N + 1)
    matrix[:, :-1] = (problem.thinning / a * face.derivative)[:-2, 1:-1]
    for body in problem.bodies:
        if not body.rigid:
            surface = body.surface(face, a, problem.rolling_speed)
            matrix[:, :-1] += surface.tangent(zero, zero).slope_p[:-2, 1:-1]
    out = np.zeros(N + 1)
    out[1:-1] = np.linalg.solve(matrix, face.points[:-2] * (a / problem.contact_radius))[:-1]
    return out


def _narrowest_body(problem: ContactProblem) -> str:
    """Return a text about the body that limits the half width."""
    named = zip(problem.pair, problem.bodies, strict=True)
    name, body = min(named, key=lambda pair: min(pair[1].radius, pair[1].max_half_width))
    if body.radius <= body.max_half_width:
        return f"a larger load makes the contact wider than the radius of the {name}"
    return (
        f"the elastic layer of the {name}, {body.thickness:.3g} m, is too thin for the contact "
        f"of a larger load; use a smaller load, a thicker or stiffer layer, or a Rigid {name}"
    )
