"""A kind of problem from outside the package: springs in a row, a list of parts, known answers.

It registers itself when imported, as a plug-in does; worker processes import it with the problem.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Annotated, Any, ClassVar

import numpy as np
from pydantic import Field

from woundon import kinds
from woundon.errors import InvalidProblem
from woundon.problems.description import Description
from woundon.problems.fields import Number
from woundon.problems.problem import Problem
from woundon.quantities import Quantity, length, pure
from woundon.results import Residuals, Result


class Spring(Description):
    """A linear spring."""

    stiffness: Annotated[Number, Quantity("k", "N/m", "stiffness of a spring"), Field(gt=0)]
    colour: str = "grey"


class SpringsProblem(Problem):
    """Springs in a row, held at ``origin``, under a force."""

    springs: tuple[Spring, ...]
    force: Annotated[Number, Quantity("F", "N", "force")]
    origin: Annotated[Number, length("x0", "where the first spring is held"), Field(default=0.0)]


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class SpringsResult(Result):
    """How far they stretch; ``solved`` tells how often the solver was called for it."""

    MAIN: ClassVar[tuple[str, ...]] = ("extension",)
    REPLACED: ClassVar[Any] = MappingProxyType({"strain": "springs have an extension"})

    extension: Annotated[float, length("u", "extension of the row")]
    solved: Annotated[int, pure("n", "how many solves lie behind it")] = 1

    @property
    def end(self) -> Annotated[float, length("x1", "where the last spring ends")]:
        return self.problem.origin + self.extension

    def share(self, spring: int = 0) -> Annotated[float, pure("s", "share of the first spring")]:
        return self.problem.force / self.problem.springs[spring].stiffness / self.extension

    def sensitivity(self, *names: str, outputs: Sequence[str] = ()) -> Any:
        """Exact derivatives of the end alone; the colour of springs has none."""
        if set(outputs) - {"end"}:
            raise InvalidProblem.at("outputs", f"{outputs} have no derivatives; only the end has")
        if any(name.endswith("colour") for name in names):
            raise InvalidProblem.at("colour", "not a continuous field")
        return _Sensitivity(("end",), names, np.array([[self._slope(name) for name in names]]))

    def _slope(self, name: str) -> float:
        if name == "origin":
            return 1.0
        if name == "force":
            return self.extension / self.problem.force
        spring = self.problem.springs[int(name.split(".")[1])]
        return -self.problem.force / spring.stiffness**2


@dataclass(frozen=True)
class _Sensitivity:
    outputs: tuple[str, ...]
    parameters: tuple[str, ...]
    derivatives: np.ndarray


def solve_springs(
    problem: SpringsProblem, *, rounds: int = 1, start: SpringsResult | None = None
) -> SpringsResult:
    """Solve; every round is the same."""
    extension = sum(problem.force / spring.stiffness for spring in problem.springs)
    behind = 0 if start is None else start.solved
    return SpringsResult(
        problem=problem, extension=extension, solved=behind + rounds,
        residuals=Residuals(balance=0.0), errors={"extension": 1e-3 * extension},
    )  # fmt: skip


kinds.register(SpringsProblem, solve_springs, SpringsResult)
