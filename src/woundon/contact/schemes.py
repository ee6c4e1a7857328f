"""Two ways to put surface responses on a grid: the graded scheme and the thesis's.

A scheme makes meshes (:mod:`.meshes`).

graded   cosine nodes; slope and strain at the middle of each cell by exact kernel integrals; the
         strain at the trailing edge exact.
thesis   even nodes; slope and strain as backward differences of the nodal displacements (thesis
         eqs. 109, 114); the strain at the trailing edge is that of the last cell, half a cell
         inside, where the pressure goes like the root of the distance: hence its slow convergence.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any, ClassVar, Protocol

import numpy as np

from ..errors import InvalidProblem, did_you_mean
from .elements import ElementGrid, borders_of
from .grid import Grid, cosine_grid, segmented_grid, uniform_grid
from .meshes import ElementMesh, FittedMesh, GradedMesh, Mesh, ThesisMesh

__all__ = ["ELEMENTS", "SCHEMES", "Elements", "Graded", "Scheme", "Thesis", "scheme_of"]

Array = np.ndarray


class Scheme(Protocol):
    """Makes meshes.

    Attributes
    ----------
    name : str
    nodes : int
        How many nodes there are by default.
    coarsest : int
        A ladder of grids begins below so many.
    refines : bool
        Whether its changes from grid to grid tell its error, and it may be refined to a tolerance.
    starts_cold : bool
        Whether the published process begins on the finest grid, without a ladder.
    """

    nodes: ClassVar[int]
    coarsest: ClassVar[int]
    refines: ClassVar[bool]
    starts_cold: ClassVar[bool]

    @property
    def name(self) -> str:
        """As the command line and files write it."""
        ...

    def mesh(self, nodes: int) -> Mesh:
        """Return the scheme's own mesh of so many nodes."""
        ...

    def restored(self, nodes: Array, points: Array) -> Mesh:
        """Return the mesh of given nodes and points."""
        ...


@dataclass(frozen=True)
class Graded:
    """Edge-graded nodes, exact kernel integrals: second order (docs, discretisation)."""

    name: ClassVar[str] = "graded"
    nodes: ClassVar[int] = 65
    coarsest: ClassVar[int] = 24
    refines: ClassVar[bool] = True
    starts_cold: ClassVar[bool] = False

    def mesh(self, nodes: int) -> Mesh:
        """Return the cosine mesh of so many nodes."""
        return _graded_mesh(nodes)

    def fitted(self, borders: Array, nodes: int) -> Mesh:
        """Return a mesh of about so many nodes graded towards zone borders too."""
        return FittedMesh(segmented_grid(borders, nodes)) if borders.size else self.mesh(nodes)

    def restored(self, nodes: Array, points: Array) -> Mesh:
        """Return the mesh of given nodes and points."""
        return GradedMesh(Grid(nodes, points))


@dataclass(frozen=True)
class Thesis:
    """The published scheme (thesis sec. 3.4), the web tension lumped or by (121) as printed."""

    printed: bool = False
    nodes: ClassVar[int] = 200
    coarsest: ClassVar[int] = 60
    refines: ClassVar[bool] = False
    starts_cold: ClassVar[bool] = True

    @property
    def name(self) -> str:
        """``thesis`` or ``thesis-printed``."""
        return "thesis-printed" if self.printed else "thesis"

    def mesh(self, nodes: int) -> Mesh:
        """Return the even mesh of so many nodes."""
        return _thesis_mesh(nodes, self.printed)

    def restored(self, nodes: Array, points: Array) -> Mesh:
        """Return the mesh of as many nodes."""
        return self.mesh(nodes.size)


@dataclass(frozen=True)
class Elements:
    """Chebyshev elements between zone borders, which ``rtol`` asks for (docs, discretisation)."""

    name: ClassVar[str] = "elements"
    nodes: ClassVar[int] = 65
    coarsest: ClassVar[int] = 24
    refines: ClassVar[bool] = True
    starts_cold: ClassVar[bool] = False

    def mesh(self, nodes: int) -> Mesh:
        """Return the mesh of a single element."""
        return self.between(np.array([-1.0, 1.0]), nodes - 1)

    def between(self, borders: Array, cells: int) -> ElementMesh:
        """Return the mesh of so many cells between any two borders."""
        return _element_mesh(tuple(borders.tolist()), cells)

    def restored(self, nodes: Array, points: Array) -> Mesh:
        """Return the mesh of given nodes."""
        found = borders_of(nodes)
        if found is None:
            raise InvalidProblem.at("x", "its nodes are not those of Chebyshev elements")
        return self.between(*found)


@lru_cache(maxsize=64)
def _graded_mesh(nodes: int) -> Mesh:
    return GradedMesh(cosine_grid(nodes))


@lru_cache(maxsize=4)  # the width alone changes from one layout to another
def _element_mesh(borders: tuple[float, ...], cells: int) -> ElementMesh:
    return ElementMesh(ElementGrid.between(np.array(borders), cells))


@lru_cache(maxsize=64)
def _thesis_mesh(nodes: int, printed: bool) -> Mesh:
    return ThesisMesh(uniform_grid(nodes), printed)


SCHEMES: dict[str, Scheme] = {s.name: s for s in (Graded(), Thesis(), Thesis(printed=True))}
ELEMENTS = Elements()


def scheme_of(given: Any) -> Scheme:
    """Return a scheme by itself or by its name.

    Raises
    ------
    InvalidProblem
        For anything else.
    """
    if isinstance(given, str) and given in SCHEMES:
        return SCHEMES[given]
    if given == ELEMENTS.name:
        return ELEMENTS
    if hasattr(given, "starts_cold"):  # a scheme from outside too
        return given
    text = f"{given!r} is unknown{did_you_mean(str(given), SCHEMES)}"
    raise InvalidProblem.at("scheme", text)
