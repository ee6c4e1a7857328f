"""A kind of problem with closed-form outputs: curves with several zeros, jumps and limits."""

from __future__ import annotations

from dataclasses import dataclass
from math import nan, sqrt
from typing import Annotated, ClassVar, Literal

from pydantic import Field

from woundon import kinds
from woundon.errors import NoSteadyState, NotConverged
from woundon.problems.fields import Number
from woundon.problems.problem import Problem
from woundon.quantities import length, pure
from woundon.results import Residuals, Result

LIMIT = 0.77
DIP = 0.3017


class CurveProblem(Problem):
    """A point on a curve."""

    position: Annotated[Number, length("x", "position", "m"), Field(ge=-10, le=10)] = 1.0
    scale: Annotated[Number, pure("s", "scale of the height"), Field(gt=0, le=1e6)] = 1.0
    shape: Literal[
        "cubic", "dip", "step", "limit", "hole", "nowhere", "stuck", "line", "guessed", "branched"
    ] = "line"


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class CurveResult(Result):
    """Its height, with an error estimate of 1 %."""

    MAIN: ClassVar[tuple[str, ...]] = ("height",)

    height: Annotated[float, pure("y", "height")]
    rounded: Annotated[float, pure("y_r", "height, rounded to 0.001")] = nan
    nothing: Annotated[float, pure("n", "an output that is not known")] = nan
    started: Annotated[int, pure("k", "whether a neighbour supplied the initial guess")] = 0


def solve_curve(problem: CurveProblem, *, start: CurveResult | None = None) -> CurveResult:
    """Return the height."""
    x = problem.position
    forbidden = {"limit": x > LIMIT, "hole": 0.9 < x < 1.3}
    if forbidden.get(problem.shape, False):
        raise NoSteadyState.at("position", f"{x:g} is beyond the limit")
    if problem.shape == "nowhere":
        raise NoSteadyState.at("position", "there is no steady state")
    if problem.shape == "stuck":
        raise NotConverged("the iteration did not converge")
    if problem.shape == "guessed" and start is None and x > 2:
        raise NotConverged("the iteration did not converge")
    is_other_branch = problem.shape == "branched" and start is None and x > 2
    height = {
        "cubic": x**3 - x,
        "dip": (x - DIP) ** 2,
        "step": 1.0 if x > DIP else -1.0,
        "limit": sqrt(max(LIMIT - x, 0.0)),
        "hole": x - 1.0,
        "line": x,
        "guessed": x,
        "branched": -x if is_other_branch else x,
    }[problem.shape]
    return CurveResult(
        problem=problem, height=problem.scale * height,
        rounded=round(problem.scale * height, 3), residuals=Residuals(law=0.0),
        errors={"height": 0.01}, started=int(start is not None),
    )  # fmt: skip


kinds.register(CurveProblem, solve_curve, CurveResult)
