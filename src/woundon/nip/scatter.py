"""What a nip's outputs owe to where within their cells its zones end."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import pairwise
from math import hypot
from typing import Any, NamedTuple

import numpy as np

from ..contact.borders import at_rest, by_turning
from ..contact.jumps import Jumps
from ..contact.levels import Level
from ..contact.resting import Resting, by_misses
from ..contact.told import Foreseen
from ..contact.zones import Runs
from ..two_bodies import SLIP_RATIOS
from .trailing_edge import at_trailing_edge, resting_at_trailing_edge

__all__ = ["by_borders", "by_cells", "rest_of_borders", "resting", "unseen_stick",
           "with_borders"]  # fmt: skip

Array = np.ndarray

# of what is usual where that is mostly the borders' doing; as how many changes a mesh alone counts
REST, KNOWN = 0.3, 2.0
# of a cell, by which ends of zones scatter: random nips' err by a tenth in the middle, but a few by
# much more than that allows
WITHIN_CELL = 0.16
OUTPUTS = ("nip_induced_tension", "peak_pressure", "offset", "drum_creep")  # the width hardly
RESTS = ("nip_induced_tension", "offset", "drum_creep")  # that come to rest with the borders
MOVED = np.isin(OUTPUTS, RESTS)
MISSED = 0.1  # of what the trailing edge changes, by which outputs of random nips err


class _AtBorders(NamedTuple):
    """What outputs change by as borders come to rest, and by how much they may be off, (4,)."""

    rest: Array
    scatter: Array
    wider: float = 0.0  # what the half width changes by as jumps come to rest: it is not moved


def by_borders(problem: Any, level: Level, usual: Mapping[str, Foreseen]) -> dict[str, Foreseen]:
    """Return by how much outputs scatter on a mesh, by its borders and by what is usual."""
    at = _at_borders(problem, level)
    if at is None:
        return dict(usual)
    scatter = dict(zip(OUTPUTS, at.scatter.tolist(), strict=True))
    scatter["tension_behind_nip"] = scatter["nip_induced_tension"]
    if at.wider:
        scatter |= {"half_width": at.wider, "nip_width": 2 * at.wider}
    return with_borders(usual, scatter)


def with_borders(
    usual: Mapping[str, Foreseen], scatter: Mapping[str, float]
) -> dict[str, Foreseen]:
    """Return by how much outputs scatter that do so usually, and by what their borders leave."""
    found = dict(usual)
    for name, (size, changes) in usual.items():
        if name in scatter:
            rest = size * (1.0 if changes == KNOWN else REST)
            found[name] = Foreseen(hypot(scatter[name], rest), KNOWN)
    return found


def rest_of_borders(problem: Any, level: Level) -> dict[str, float]:
    """Return what outputs change by as the borders of a solved mesh come to rest; {} if unknown."""
    at = _at_borders(problem, level) if level.mesh.regardless else None
    if at is None:
        return {}
    rest = dict(zip(OUTPUTS, at.rest.tolist(), strict=True))
    return {name: rest[name] for name in RESTS}


def _at_borders(problem: Any, level: Level) -> _AtBorders | None:
    """Return what a mesh's borders tell; None where stick and slip were not solved for jointly."""
    if "borders" not in level.kept:
        solution, joint = level.state.solution, level.equations.joint
        jointly = joint is not None and solution.joint is not None
        level.kept["borders"] = _found(problem, level) if jointly else None
    found: _AtBorders | None = level.kept["borders"]
    return found


def _found(problem: Any, level: Level) -> _AtBorders:
    """Return what borders, jumps and the trailing edge leave open."""
    solution, joint = level.state.solution, level.equations.joint
    gradients, jumps = _gradients(problem, level), _jumps(problem, level)
    faces = (np.arange(joint.unknowns),) * 2
    moved = by_turning(joint, solution, faces, gradients, jumps=jumps)
    others, wider = [], 0.0
    if jumps:
        by_width = np.zeros(len(gradients))
        by_width[: joint.unknowns] = level.equations.matrices.weights / (level.load * level.power)
        all_outputs = np.column_stack([gradients, by_width])
        changes, off = jumps.changes(joint, solution, all_outputs)
        wider = float(abs(changes[-1]) + off[-1]) * level.half_width
        changes, off = changes[:-1], off[:-1]
        others.append((changes, np.where(MOVED, off, np.abs(changes) + off)))
    edge = at_trailing_edge(problem, level, gradients)
    if edge is not None:
        others.append((edge, MISSED * MOVED * edge))
    return _AtBorders(*at_rest(moved, *others), wider)


def _jumps(problem: Any, level: Level) -> Jumps | None:
    """Return where tractions of rigid bodies jump."""
    n = level.equations.joint.unknowns
    rigid = (face for face, body in enumerate(problem.bodies) if body.rigid)
    return Jumps.of(
        level.equations.joint,
        level.state.solution,
        [(face * n, (face + 1) * n - 1) for face in rigid],
    )


def resting(problem: Any, level: Level) -> Resting:
    """Return the derivatives of what NIT changes by as borders, jumps and the edge are told."""
    joint, gradients = level.equations.joint, _gradients(problem, level)[:, :1]
    faces = (np.arange(joint.unknowns),) * 2
    borders = by_misses(joint, level.state.solution, faces, gradients, _jumps(problem, level))
    edge = resting_at_trailing_edge(problem, level, gradients)
    return borders if edge is None else borders.beside(edge)


def _gradients(problem: Any, level: Level) -> Array:
    """Return those of the outputs by the joint system's unknowns, (n + m + 2, outputs).

    At the load asked, to first order.
    """
    weights, state = level.equations.matrices.weights, level.state
    n, p, load = weights.size, state.pressure, level.load
    whole = float(weights @ state.traction.reshape(2, n).sum(axis=0))
    top = int(p.argmax())
    stretch = problem.web.compliance.c11 / problem.web.thickness
    by_unknowns = np.zeros((len(OUTPUTS), 3 * n + 2))
    tension, peak, offset, creep = by_unknowns
    tension[:n] = weights * (-whole / load)
    tension[n + 1 : 2 * n + 1] = tension[2 * n + 1 : -1] = weights
    peak[:n] = weights * (p[top] * (1 / level.power - 1) / load)
    peak[top] += 1.0
    offset[n] = problem.contact_radius
    creep[n + 1 : -1], creep[-1] = -stretch * tension[n + 1 : -1], 1.0
    return by_unknowns.T


def by_cells(nodes: Array, faces: Sequence[Runs]) -> dict[str, Foreseen]:
    """Return by how much slip ratios scatter, by the cells in which zones end; in units of a."""
    (leading, trailing), (_, drum) = (
        [
            float(nodes[node] - nodes[node - 1]) / 2
            for node in nodes[1:-1].searchsorted([face.borders[0][0], face.borders[-1][0]]) + 1
        ]
        if face.borders
        else (0.0, 0.0)
        for face in faces
    )
    cells = dict(zip(SLIP_RATIOS, (leading, trailing, max(trailing, drum)), strict=True))
    return {name: Foreseen(WITHIN_CELL * cell, KNOWN) for name, cell in cells.items()}


def unseen_stick(nodes: Array, faces: Iterable[Runs]) -> float:
    """Return by how much slip ratios err as stick that is shorter than its cell is not seen.

    It is where slip meets slip the other way, of up to a cell: half of it in the middle, and that
    of a width of 2a.
    """
    met = [
        place
        for face in faces
        for (one, two), (place, _) in zip(pairwise(face.zones), face.borders, strict=True)
        if one * two < 0
    ]
    if not met:
        return 0.0
    ends = nodes[1:-1].searchsorted(met) + 1
    return float((nodes[ends] - nodes[ends - 1]).max()) / 4
