"""What a wrapped nip's outputs owe to where within their cells its zones end."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from ..contact.borders import at_rest, by_turning
from ..contact.jumps import Jumps
from ..contact.levels import Level
from ..contact.resting import Resting, by_misses
from ..contact.told import Foreseen
from ..nip.scatter import with_borders

__all__ = ["by_borders", "rest_of_borders", "resting"]

Array = np.ndarray

# that come to rest with the borders; width and pressure hardly depend on these, the offset errs
# otherwise: once borders rest it is off by as much
RESTS = ("wound_on_tension", "nip_induced_tension", "tension_behind_nip", "drum_creep")

KNOWN = 1.0  # changes that a mesh alone counts as: shares of what borders leave open are of nips


class _AtBorders(NamedTuple):
    """What outputs change by as borders come to rest, and by how much they may be off, by name."""

    rest: Mapping[str, float]
    scatter: Mapping[str, float]


def by_borders(level: Level, usual: Mapping[str, Foreseen]) -> dict[str, Foreseen]:
    """Return by how much outputs scatter on a mesh, by its borders and by what is usual."""
    found = with_borders(usual, _at_borders(level).scatter)
    return {name: Foreseen(size, min(known, KNOWN)) for name, (size, known) in found.items()}


def rest_of_borders(level: Level) -> dict[str, float]:
    """Return what outputs change by as the borders of a solved mesh come to rest; {} if unknown."""
    rest = _at_borders(level).rest
    return {name: rest[name] for name in RESTS if name in rest}


def _at_borders(level: Level) -> _AtBorders:
    """Return what a mesh's borders tell; nothing where it was not solved for jointly."""
    found: _AtBorders | None = level.kept.get("borders")
    if found is None:
        solution, joint = level.state.solution, level.equations.joint
        jointly = joint is not None and solution.joint is not None
        found = level.kept["borders"] = _found(level) if jointly else _AtBorders({}, {})
    return found


def resting(level: Level, outputs: Sequence[str]) -> Resting:
    """Return the derivatives of what some outputs change by as borders come to rest."""
    equations, gradients = level.equations, _gradients(level)
    by_unknowns = np.array([gradients[name] for name in outputs]).T
    faces = equations.roll_q, equations.drum_q
    return by_misses(equations.joint, level.state.solution, faces, by_unknowns, _jumps(level))


def _found(level: Level) -> _AtBorders:
    equations, names = level.equations, _gradients(level)
    faces, gradients = (equations.roll_q, equations.drum_q), np.array(list(names.values())).T
    far, start = equations.roll_q.size - 1, equations.roll_q.size  # where arcs end and begin
    ends = [far] * equations.roll_arc + [start] * equations.drum_arc
    joint, solution = equations.joint, level.state.solution
    jumps = _jumps(level)
    moved = by_turning(joint, solution, faces, gradients, ends, jumps)
    others = []
    if jumps:
        changes, off = jumps.changes(joint, solution, gradients)
        moves = [name in RESTS for name in names]
        others.append((changes, np.where(moves, off, np.abs(changes) + off)))
    told = at_rest(moved, *others)
    rest, scatter = (dict(zip(names, part.tolist(), strict=True)) for part in told)
    return _AtBorders(rest, scatter)


def _jumps(level: Level) -> Jumps | None:
    """Return where tractions of rigid bodies jump."""
    equations, problem = level.equations, level.equations.problem
    on_roll, both = equations.roll_q.size, equations.roll_q.size + equations.drum_q.size
    ends = (0, on_roll - 1), (on_roll, both - 1)
    rigid = [end for end, body in zip(ends, problem.bodies, strict=True) if body.rigid]
    return Jumps.of(equations.joint, level.state.solution, rigid)


def _gradients(level: Level) -> dict[str, Array]:
    """Return those of the outputs by the joint system's unknowns, at the load asked, (k + m + 1,).

    To first order; what the tension gains from the nip's leading edge on goes like the load.
    """
    equations, state, load = level.equations, level.state, level.load
    problem, grid, along = equations.problem, equations.grid, state.along
    k, n_p = equations.load_weights.size, equations.roll_nodes.size
    carried, gain = equations.load_weights / load, equations.tension_q
    wider, first, last, far = carried / level.power, grid.first, grid.last, -1
    stretch = equations.web.c11 / problem.web.thickness

    def tension(since: int | None, upto: int) -> Array:
        out = np.zeros(k + equations.columns.size + 1)
        out[:k] = carried * float(along.tension[first] - along.tension[upto])
        out[k:-1] = gain[upto] if since is None else gain[upto] - gain[since]
        return out

    none = np.zeros(k + equations.columns.size + 1)
    width, peak, creep = none.copy(), none.copy(), none.copy()
    p = along.drum_loads.pressure
    top = first + int(np.argmax(p[first : last + 1]))
    width[:k] = wider * level.half_width
    peak[:k] = (wider - carried) * p[top]
    peak[n_p + top - equations.drum_nodes[0]] += 1.0
    creep[k:-1], creep[-1] = -stretch * gain[far], 1.0  # it hardly depends on the load
    return {
        "wound_on_tension": tension(None, far), "nip_induced_tension": tension(first, last),
        "tension_behind_nip": tension(None, last), "half_width": width, "nip_width": 2 * width,
        "peak_pressure": peak, "drum_creep": creep,
    }  # fmt: skip
