"""What the equations of a solved nip change by, at its unknowns; :mod:`.sensitivity` asks."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from ..contact.resting import Resting
from ..errors import InvalidProblem

__all__ = ["Differential"]

Array = np.ndarray
# relative; matrices are known to 1e-14, so their forward differences to 1e-6 at the worst
STEP = 1e-7
# an equilibrium inside a body is known to 1e-11
STEP_OF_TANGENTS = 1e-5
NEAR_CHANGE = 1e-6  # margin of a node's law, relative, below which a zone change is announced


class Differential:
    """The residual R(u, theta) about a converged state, and what it changes by.

    Attributes
    ----------
    result, problem
        The state.
    told : tuple of str
        ``outputs``, and ``more`` where wanted.
    rest : array
        R itself, what the solution left.
    here : object
        The matrices of the state.
    half_width : float
        a [m].
    resting : Resting, optional
        What outputs change by as borders come to rest; else none does.
    """

    outputs: ClassVar[tuple[str, ...]]
    more: ClassVar[tuple[str, ...]] = ()  # told only where one of them is asked for: they cost more

    rest: Array
    here: Any
    resting: Resting | None = None
    _known: tuple[Any, Any] | None = None

    def __init__(self, result: Any, told: tuple[str, ...]) -> None:
        self.told = told
        self.result, self.problem, self.half_width = result, result.problem, result.half_width
        # bodies that are not linear have their tangents about the result, which is kept fixed
        self.step = STEP if self.problem.linear else STEP_OF_TANGENTS

    def laws(self, made: Any) -> Any:
        """Return what laws say at the fixed unknowns; both R and J ask for the same ones."""
        if self._known is None or self._known[0] is not made:
            self._known = made, self.laws_of(made)
        return self._known[1]

    def laws_of(self, made: Any) -> Any:
        """Return what laws say at the fixed unknowns."""
        raise NotImplementedError

    def jacobian(self) -> Array:
        """Return R_u."""
        raise NotImplementedError

    def output_gradients(self) -> Array:
        """Return J_u of the outputs, (outputs, unknowns)."""
        raise NotImplementedError

    def residual(self, problem: Any, made: Any) -> Array:
        """Return R at the fixed unknowns, of another problem or half width."""
        raise NotImplementedError

    def output_values(self, problem: Any, made: Any) -> Array:
        """Return the outputs of another problem or half width at the fixed unknowns."""
        raise NotImplementedError

    def assembled(self, problem: Any, a: float, part: str) -> Any:
        """Assemble for a half width and a problem of which only one part is another ('' none)."""
        raise NotImplementedError

    def by_width(self) -> tuple[Array, Array]:
        """Return dR/dln a and the outputs' dJ/dln a."""
        return self.by_width_over(self.step)

    def by_width_over(self, step: float) -> tuple[Array, Array]:
        """Return the same by the difference over a step of ln a."""
        wider = self.assembled(self.problem, self.half_width * float(np.exp(step)), "")
        return self._slopes(self.problem, wider, step)

    def changes(self, name: str, value: float) -> tuple[Array, Array]:
        """Return R_theta and the outputs' explicit J_theta for one field."""
        return self.changes_over(self.step, name, value)

    def changes_over(self, share: float, name: str, value: float) -> tuple[Array, Array]:
        """Return the same by the difference over a share of the field."""
        step = share * self._size(name, value)
        try:
            problem = self.problem.replace(**{name: value + step})
        except InvalidProblem:  # at the border of the admissible range
            step = -step
            problem = self.problem.replace(**{name: value + step})
        made = self.assembled(problem, self.half_width, name.partition(".")[0])
        return self._slopes(problem, made, step)

    def _slopes(self, problem: Any, made: Any, step: float) -> tuple[Array, Array]:
        outputs = self.output_values(problem, made) - self.outputs_here
        return (self.residual(problem, made) - self.rest) / step, outputs / step

    @cached_property
    def outputs_here(self) -> Array:
        """The outputs at the result, as it tells them."""
        return self.output_values(self.problem, self.here)

    def _size(self, name: str, value: float) -> float:
        """Return the scale on which a field matters."""
        head, _, rest = name.partition(".")
        thickness = getattr(getattr(self.problem, head), "thickness", np.inf)
        if head in self.problem.pair and rest.endswith("radius") and np.isfinite(thickness):
            return float(thickness)  # the radii of a thin layer matter by their difference
        if value != 0:
            return abs(value)
        if name in ("winding_force", "web_tension"):
            return float(self.problem.drum_friction * self.problem.nip_load)
        return 1 / self.problem.web.compliance.c22 if name.endswith("cross") else 1.0

    def near_zone_change(self) -> str:
        """Name the nodes whose law is kept by a hair only."""
        found = []
        for face, nodes, bound in self.bounds():
            traction, slip, zones = (
                getattr(self.result, f"{face}_{of}")[nodes] for of in ("traction", "slip", "zone")
            )
            spare = np.where(
                zones == 0,
                (bound - np.abs(traction)) / np.max(bound),
                np.abs(slip) / max(float(np.max(np.abs(slip))), 1e-300),
            )
            found += [f"{face} node {k}" for k in nodes[spare < NEAR_CHANGE]]
        return ", ".join(found)

    def bounds(self) -> Iterator[tuple[str, Array, Array]]:
        """Yield each face by name, the nodes of its tractions, and what friction can hold there."""
        raise NotImplementedError
