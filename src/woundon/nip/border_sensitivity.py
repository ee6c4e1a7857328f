r"""Sensitivities of a nip on elements, whose borders move with everything else.

Between given borders and for a given half width the nip is solved once (:class:`~.layout.Layout`),
and leaves conditions C(y, theta), one for each of the unknowns y = (borders, ln a).  They are few;
so C_y, C_theta and what the outputs change by are central differences of solved layouts, each with
as many elements as the result, which move with the borders:

    dJ/dtheta = J_theta - J_y C_y^-1 C_theta
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ..contact.meshes import ElementMesh
from ..contact.response import Tractions
from ..contact.schemes import ELEMENTS
from ..two_bodies import mesh_of
from .borders import scales
from .differential import Differential
from .equations import NipMatrices
from .layout import Face, Layout
from .result import RIG_ANGLE, NipResult
from .roll_surface import Rise

if TYPE_CHECKING:
    from ..problems.nip import NipProblem

__all__ = ["BorderDifferential"]

Array = np.ndarray

# of the way to the next border, of ln a and of a field: its square is left of a derivative, and
# what rounding leaves of a layout, 1e-11, over it
STEP = 1e-4


class BorderDifferential(Differential):
    """C and C_y of a nip on elements."""

    outputs = (
        "nip_induced_tension", "tension_behind_nip", "half_width", "nip_width", "drum_creep",
    )  # fmt: skip
    more = ("rig_tension",)

    here: Layout

    def __init__(self, result: NipResult, told: tuple[str, ...]) -> None:
        super().__init__(result, told)
        mesh = mesh_of(result)
        assert isinstance(mesh, ElementMesh)
        self.grid, inner = mesh.grid, mesh.grid.borders[1:-1]
        first = 1 + self.grid.order * np.arange(inner.size + 1)  # behind each border
        self.zones: list[tuple[int, ...]] = []
        self.borders: list[Array] = []
        for zones in (result.roll_zone[first], result.drum_zone[first]):
            turns = np.nonzero(np.diff(zones))[0]
            self.zones.append((int(zones[0]), *(int(zones[k + 1]) for k in turns)))
            self.borders.append(inner[turns])
        self.y = np.concatenate([*self.borders, [np.log(self.half_width)]])
        self.here = self._layout(self.problem, self.y)
        self.rest = self.here.left

    def jacobian(self) -> Array:
        """Return C_y."""
        return self._by_unknowns[0]

    def output_gradients(self) -> Array:
        """Return J_y of the outputs, (outputs, unknowns)."""
        return self._by_unknowns[1]

    @cached_property
    def _by_unknowns(self) -> tuple[Array, Array]:
        """C_y and J_y, from the same layouts."""
        steps = STEP * scales(self.y)
        columns, slopes = [], []
        for k, step in enumerate(steps):
            move = np.where(np.arange(self.y.size) == k, step, 0.0)
            ahead, back = (self._layout(self.problem, self.y + d) for d in (move, -move))
            columns.append((ahead.left - back.left) / (2 * step))
            told = [self.output_values(self.problem, at) for at in (ahead, back)]
            slopes.append((told[0] - told[1]) / (2 * step))
        return np.array(columns).T, np.array(slopes).T

    def residual(self, problem: NipProblem, made: Layout) -> Array:
        """Return C of another problem between the fixed borders."""
        return made.left

    def output_values(self, problem: NipProblem, made: Layout) -> Array:
        """Return the outputs of a layout."""
        state, n, a = made.solved[0], made.mesh.unknowns, made.half_width
        each = zip(problem.bodies, np.split(state.traction, [n]), strict=True)
        NIT = sum(a * float(made.mesh.facing(body.rigid).grid.weights @ q) for body, q in each)
        stretch = problem.web.compliance.c11 / problem.web.thickness
        T_out = problem.web_tension + NIT
        told = [NIT, T_out, a, 2 * a, state.solution.creep - stretch * T_out]
        if "rig_tension" in self.told:
            loads = Tractions(state.pressure, state.traction[:n])
            rise = Rise(problem, made.mesh.grid, a, RIG_ANGLE, loads)
            told.append(T_out + rise.of(problem, a) / stretch)
        return np.array(told)

    def changes(self, name: str, value: float) -> tuple[Array, Array]:
        """Return C_theta and the outputs' explicit J_theta for one field."""
        ahead, back = (self.changes_over(step, name, value) for step in (STEP, -STEP))
        return (ahead[0] + back[0]) / 2, (ahead[1] + back[1]) / 2

    def assembled(self, problem: NipProblem, a: float, part: str) -> Layout:
        """Return the layout of a problem of which only one part is another; a is fixed."""
        here = self.here
        one, two = (
            problem.respond(body, here.mesh, here.half_width) if name == part else known
            for name, body, known in zip(
                problem.pair, problem.bodies, here.made.responses, strict=True
            )
        )
        made = replace(here, problem=problem)
        vars(made)["made"] = NipMatrices.of(problem, here.mesh, here.half_width, one, two)
        return made

    def bounds(self) -> Iterator[tuple[str, Array, Array]]:
        """Yield nothing: no node is about to change its zone where borders move."""
        yield from ()

    def _layout(self, problem: NipProblem, y: Array) -> Layout:
        """Return the layout between borders, its elements moved with them."""
        cut = self.borders[0].size
        faces = list(map(Face, self.zones, (y[:cut], y[cut:-1])))
        order = np.argsort(self.y[:-1])
        was, now = (np.concatenate([[-1.0], at[:-1][order], [1.0]]) for at in (self.y, y))
        mesh = ELEMENTS.between(np.interp(self.grid.borders, was, now), self.grid.order)
        return Layout(problem, faces, float(np.exp(y[-1])), mesh)
