"""Solved meshes, and what one mesh or a neighbouring case hands to the next."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from .grid import nearest_nodes, zone_borders
from .meshes import Mesh
from .told import Scatter
from .zones import Runs

__all__ = ["Before", "Known", "Level", "Scalars", "Start", "Widths"]

Array = np.ndarray
Scalars = Mapping[str, float]

SOLVED = 1e-8  # of the load, which no mesh that counts misses by more: less of it is rounding


class Known(NamedTuple):
    """What is known before a half width is tried: a state to linearise about, and zones."""

    about: Any
    zones: Array | None


class Before(NamedTuple):
    """What another mesh, or a neighbouring case, was linearised about."""

    places: Array  # in units of a
    about: Any


class Widths(NamedTuple):
    """The half width that carries the load on each mesh, by its number of nodes [m].

    ``power`` is d ln P/d ln a: with it a neighbouring case knows where to begin.  ``scatters`` are
    those of the outputs, told by other cases alone in the last ``unchecked`` of them; ``runs`` the
    zones of each face, borders to a fraction of a cell, in units of a.
    """

    power: float
    by_nodes: Mapping[int, float]
    scatters: Mapping[str, Scatter] = MappingProxyType({})
    unchecked: int = 0
    runs: Sequence[Runs] | None = None

    def at(self, share: float) -> Widths:
        """Return what they would be at another load, ``share`` times as large."""
        factor = share ** (1 / self.power)
        by_nodes = {nodes: a * factor for nodes, a in self.by_nodes.items()}
        return self._replace(by_nodes=by_nodes)


@dataclass(frozen=True, eq=False)
class Start:
    """What one mesh, or a neighbouring case, hands to the next.

    Attributes
    ----------
    half_width : float
        [m].
    faces : sequence of arrays
        Where each face's tractions were, in units of a.
    zones : (m,) int array
        Their states, face by face.
    power : float
        d ln P/d ln a.
    frictionless : (a, load), optional
        A half width and the load that it would carry on that mesh without friction.
    level : Level, optional
        The solved mesh itself.
    widths : Widths, optional
        Those of a neighbouring case, at the load asked.
    before : Before, optional
        What it was linearised about.
    rough : bool
        Whether it is no more than a guess.
    runs : sequence of Runs, optional
        The zones of each face, borders to a fraction of a cell, in units of a.
    """

    half_width: float
    faces: Sequence[Array]
    zones: Array
    power: float = 2.0
    frictionless: tuple[float, float] | None = None
    level: Level | None = None
    widths: Widths | None = None
    before: Before | None = None
    rough: bool = False
    runs: Sequence[Runs] | None = None

    def zones_on(self, faces: Sequence[Array]) -> list[Array]:
        """Carry the zones over: each new node takes that of the nearest old one of its face."""
        found, first = [], 0
        for old, new in zip(self.faces, faces, strict=True):
            found.append(self.zones[first:][nearest_nodes(old, new)])
            first += old.size
        return found


@dataclass(frozen=True, eq=False)
class Level:
    """A solved mesh, and the power d ln P/d ln a found on the way; what was made of it is kept."""

    mesh: Mesh
    equations: Any
    state: Any
    load: float  # asked
    power: float
    kept: dict[str, Any] = field(default_factory=dict, repr=False)

    @cached_property
    def share(self) -> float:
        """Load asked over load carried, of a coarse mesh that is not solved to the last digit."""
        share = self.load / float(self.equations.carried(self.state))
        return share if abs(share - 1) > SOLVED else 1.0

    @property
    def half_width(self) -> float:
        """The half width at which this mesh would carry the load [m]."""
        return float(self.state.half_width * self.share ** (1 / self.power))

    def at_load(self, value: float) -> float:
        """Return a pressure as it would be at the load asked: it goes like load over width."""
        return float(value * self.share ** (1 - 1 / self.power))

    @property
    def start(self) -> Start:
        """What the next mesh starts from."""
        # by the factors of a joint system the next width is followed: it need not be nearer
        followed = self.state.solution.joint is not None
        load = None if followed else self.equations.frictionless()
        frictionless = None if load is None else (self.state.half_width, load)
        zones = self.state.solution.state
        return Start(
            self.half_width, self.equations.faces, zones, self.power, frictionless, self,
            before=Before(self.equations.places, self.state.known),
        )  # fmt: skip

    def borders(self) -> Array:
        """Return where zones change on any face, in units of the half width."""
        solution, first, found = self.state.solution, 0, []
        slack = solution.bound - np.abs(solution.traction)
        for face in self.equations.faces:
            own = slice(first, first + face.size)
            nodes = np.concatenate([[-1.0], face, [1.0]])
            found.append(zone_borders(nodes, solution.state[own], slack[own]))
            first += face.size
        return np.sort(np.concatenate(found))
