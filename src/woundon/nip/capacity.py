"""The largest load that one contact of two bodies carries.

A frictionless contact of half width a satisfies the equations of the gap's slope with the pressure
alone, a linear system for linear bodies.  Its load grows with a, up to the largest half width that
the bodies permit; a thin tube on an open bore bends instead, so that the pressure vanishes in the
middle of a wide contact.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..elasticity.mesh import Face, Wrap, nip_mesh
from ..errors import InvalidProblem

__all__ = ["check_load", "frictionless_load"]

Array = np.ndarray

NODES = 23  # leaves about 0.3 % of the load
# A contact is in one piece if the pressure in its middle half exceeds this share of the largest;
# less of it may vanish under friction.
LEAST_PRESSURE = 0.05
# Half widths tried, relative to the largest one, where the largest one is not in one piece.
SHARES = np.geomspace(1e-3, 1.0, 60)
# The load of a contact with friction differs from the frictionless one by less than this.
FRICTION = 1.5


def frictionless_load(problem: Any, a: float) -> tuple[float, bool]:
    """Return the load of a frictionless contact [N/m], and whether it is in one piece."""
    mesh = nip_mesh(NODES, Wrap(), Wrap())
    face = Face(mesh, mesh.first, mesh.last)
    matrix = np.zeros((NODES - 1, NODES - 1))
    zero = np.zeros(NODES)
    slope = problem.thinning / a * face.derivative[:-2]
    for body in problem.bodies:
        slope = slope + body.surface(face, a, problem.rolling_speed).tangent(zero, zero).slope_p[:-2]
    matrix[:, :-1], matrix[:, -1] = slope[:, 1:-1], 1.0
    p = np.linalg.solve(matrix, mesh.points * (a / problem.contact_radius))[:-1]
    middle = np.abs(mesh.nodes[1:-1]) < 0.5
    return float(a * mesh.weights[1:-1] @ p), bool(p[middle].min() > LEAST_PRESSURE * p.max())


def check_load(problem: Any, field: str, widest: float) -> None:
    """Raise where no contact up to a half width carries the load; nonlinear bodies are not checked.

    Raises
    ------
    InvalidProblem
        With the largest load permitted, about.
    """
    load = getattr(problem, field)
    if not problem.linear:
        return
    carried, whole = frictionless_load(problem, widest)
    if whole and carried * FRICTION >= load:
        return
    tried = [frictionless_load(problem, share * widest) for share in SHARES]
    largest = max((carried for carried, whole in tried if whole), default=0.0)
    if largest * FRICTION >= load:
        return
    narrow = min(problem.bodies, key=lambda body: min(body.radius, body.widest))
    name = problem.pair[problem.bodies.index(narrow)]
    reason = "the load is too large, or the bodies are too soft"
    if narrow.widest < narrow.radius:
        reason = (
            f"the elastic layer of the {name}, {narrow.thickness:.3g} m, is too thin for a wider "
            f"contact: take a thicker or stiffer layer, or a Rigid {name}"
        )
    if not whole:
        reason = (
            "a larger load bends a thin body instead of being carried by one contact; a rigid "
            "core, or stiffer or thicker layers are needed"
        )
    raise InvalidProblem.at(
        field,
        f"{load:.6g} is out of range; must be < {largest:.3g} [N/m], about, which a contact of "
        f"half width {widest:.3g} m carries: {reason}",
    )
