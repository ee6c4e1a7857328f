r"""The operating window: the probability that a roll keeps all its limits, over the set points.

:mod:`.window_study` solves the windings, :mod:`.window_map` interpolates their margins and computes
the probabilities.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..arguments import whole_number
from ..errors import InvalidProblem
from ..problems.grades import Grade, grade
from ..problems.messages import quote
from ..problems.paths import field_quantity, get_field
from ..problems.problem import Problem
from .api import in_si
from .progress import Progress, progress_reporter
from .window_cases import CaseSolver
from .window_map import SetPoints
from .window_model import margin_names, window_model
from .window_result import OperatingWindow
from .window_study import WindowStudy

__all__ = ["operating_window"]

MOST_SPREAD = 2.0


def operating_window(
    problem: Problem,
    web_tension: Sequence[float | str],
    nip_load: Sequence[float | str],
    torque_split: Sequence[float | str] | None = None,
    *,
    uncertain: Mapping[str, float] | Grade | str | None = None,
    tie: Mapping[str, str] | None = None,
    samples: int = 2048,
    seed: int = 0,
    workers: int | None = None,
    out: str | Path | None = None,
    resume: bool = False,
    progress: bool | Progress = False,
    preview: Callable[[OperatingWindow], Any] | None = None,
    options: Mapping[str, Any] | None = None,
) -> OperatingWindow:
    """Map the probability that all margins of a winding hold, over web tension and nip load.

    Schedules keep their shape; the ranges are of their values at the core.

    Parameters
    ----------
    problem : WindingProblem
        With at least one limit.
    web_tension, nip_load, torque_split : (low, high)
        At the core, SI or texts with units.  Without ``torque_split`` it stays as it is.
    uncertain : mapping, Grade or str, optional
        Dotted name of a field -> relative standard deviation of its log-normal distribution, whose
        median is the value of the problem.  A grade, or its name, gives the spreads of the grade.
        By default those of the grade that the problem was made with; a mapping then replaces
        single ones, 0 removes one.
    tie : mapping of str to str
        Field -> field that it follows.  With the spreads of a grade, values that it supplies to
        several fields are tied.
    samples, seed : int
        Draws from the distributions, 100 to 100 000, and the seed of their generator.
    workers : int
        Processes; by default one for each core.
    out : path
        Folder for the windings; ``resume=True`` continues an interrupted computation.
    progress : bool or callable
        Show the fraction done, or call with (work done, work expected); a winding whose nips are
        solved counts as 20 with known friction shares.
    preview : callable, optional
        Is called with a coarse window of 3 x 3 points, after about a third of the time.
    options : mapping
        Options of the solver.  By default a reduced accuracy: rtol 0.01, 33 nodes,
        coupling_rtol 0.001.

    Returns
    -------
    OperatingWindow

    Raises
    ------
    InvalidProblem
        For invalid ranges or names, without limits, or without spreads.
    NotConverged
        If too few windings can be solved.

    Examples
    --------
    A roll of 60 layers of board with full slip in the nip, so that no nip is solved:

    >>> import woundon as wo
    >>> board = wo.WindingProblem.example().replace(
    ...     stack=wo.Stack(radial=27e6, tangential=3.38e9, poissons_ratio=0.01, shear=10e6),
    ...     radius=0.08, tension_law="friction", limits=wo.Limits(blocking_pressure="200 kPa"),
    ...     **{"web.thickness": "500 um"},
    ... )
    >>> window = wo.operating_window(
    ...     board, web_tension=(200, 500), nip_load=("1 kN/m", "4 kN/m"),
    ...     uncertain={"roll_friction": 0.3}, samples=128, workers=1,
    ... )
    >>> window.best.probability, window.at("400 N/m", "3 kN/m").binding
    (1.0, 'blocking')
    """
    _check_kind(problem)
    spreads, ties = _spreads(problem, uncertain, tie)
    whole_number("samples", samples, 100, 100_000)
    model = window_model(problem, ties, options)
    for name in spreads:
        model.check_varied([name])
    ranges = _ranges(problem, web_tension, nip_load, torque_split)
    set_points = SetPoints(tuple(ranges), np.array(list(ranges.values())))
    solver = CaseSolver(model, set_points, spreads, workers, out, resume)
    with progress_reporter(progress, "winding") as report:
        study = WindowStudy(solver, (samples, seed), report)
        coarse = study.coarse()
        if preview is not None:
            preview(coarse)
        return study.complete()


def _check_kind(problem: Any) -> None:
    if not margin_names(problem):
        text = f"{type(problem).__name__} is out of place; must be a WindingProblem"
        raise InvalidProblem.at("problem", text)


def _spreads(
    problem: Any, uncertain: Any, tie: Mapping[str, str] | None
) -> tuple[dict[str, float], dict[str, str]]:
    """Return the relative standard deviations of the inputs, and the fields that follow others."""
    overrides: Mapping[str, Any] = uncertain if isinstance(uncertain, Mapping) else {}
    base_grade: Grade | None = getattr(problem, "named_grade", None)
    if isinstance(uncertain, (str, Grade)):
        base_grade = grade(uncertain)
    elif uncertain is not None and not isinstance(uncertain, Mapping):
        text = f"{quote(uncertain)} is out of place; must be {{field: relative deviation}}"
        raise InvalidProblem.at("uncertain", text)
    spreads: dict[str, float] = {}
    ties = dict(tie or {})
    if base_grade is not None:
        ties = {**base_grade.tied_fields(problem), **ties}
        spreads = {n: s for n, s in base_grade.spread_of(problem).items() if n not in ties}
    spreads |= {name: _spread(problem, name, value) for name, value in overrides.items()}
    if not spreads:
        text = (
            "missing, and the case names no grade that has spreads; must be {field: relative "
            "standard deviation}, on the command line --uncertain FIELD=DEVIATION"
        )
        raise InvalidProblem.at("uncertain", text)
    return {n: s for n, s in spreads.items() if s > 0 and get_field(problem, n) > 0}, ties


def _spread(problem: Any, name: str, spread: Any) -> float:
    """Return a relative standard deviation of a field that has a log-normal distribution."""
    is_number = isinstance(spread, (int, float)) and not isinstance(spread, bool)
    if not is_number or not 0 <= spread <= MOST_SPREAD:
        text = f"{quote(spread)} is out of range; must be >= 0 and <= {MOST_SPREAD:g}"
        raise InvalidProblem.at(f"uncertain.{name}", text)
    value = get_field(problem, name)
    if field_quantity(problem, name) is None or not isinstance(value, float) or value <= 0:
        text = f"{quote(value)} is not a number > 0, so it has no log-normal distribution"
        raise InvalidProblem.at(f"uncertain.{name}", text)
    return float(spread)


def _ranges(problem: Any, *intervals: Any) -> dict[str, tuple[float, float]]:
    """Return the ranges by name, SI units."""
    ranges: dict[str, tuple[float, float]] = {}
    for name, ends in zip(("web_tension", "nip_load", "torque_split"), intervals, strict=True):
        if ends is None and name == "torque_split":
            continue
        if isinstance(ends, str) or not hasattr(ends, "__len__") or len(ends) != 2:
            raise InvalidProblem.at(name, f"{quote(ends)} is out of place; must be (low, high)")
        low, high = (_number(name, end) for end in in_si(problem, {name: ends})[name])
        lowest = -1e-300 if name == "torque_split" else 0.0
        if not lowest < low < high < float("inf"):
            text = f"({low:g}, {high:g}) is out of range; must be 0 < low < high"
            raise InvalidProblem.at(name, text)
        ranges[name] = (low, high)
    return ranges


def _number(name: str, value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float, np.floating, np.integer)):
        raise InvalidProblem.at(name, f"{quote(value)} is not a number")
    return float(value)
