"""Rolls in the limit of thin layers, to which closed forms apply."""

from __future__ import annotations

from typing import Any

import woundon as wo

# of the thickness: some hundred thousand layers, a million at most; their effect on the pressure,
# some percent, is of order one in it
FACTOR = 2e-3


def scaled(schedule: Any, factor: float) -> Any:
    """Return a tension [N/m] times a factor."""
    if isinstance(schedule, wo.Taper):
        return schedule.replace(start=factor * schedule.start)
    if isinstance(schedule, wo.Profile | wo.Steps):
        return schedule.replace(value=[factor * value for value in schedule.value])
    return factor * schedule


def thin(problem: wo.RollProblem, factor: float = FACTOR) -> wo.RollProblem:
    """Return the same roll of much thinner layers under the same stress."""
    return problem.replace(
        web_thickness=factor * problem.web_thickness,
        wound_on_tension=scaled(problem.wound_on_tension, factor),
    )
