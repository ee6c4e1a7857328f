"""The windings of an operating window: solved cases, and friction shares interpolated of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InvalidProblem
from .cases import table_of_cases
from .kind_model import get_field
from .run import Workers, run_study
from .window_map import SetPoints, fitted, from_reserve
from .window_model import FRICTION_SHARE, WindowModel
from .window_result import log_deviation

__all__ = ["Case", "CaseSolver", "Point", "Shares", "Windings", "share_polynomials"]

Array = np.ndarray
Point = tuple[float, ...]  # coordinates of a set point, or inputs in standard deviations
Case = tuple[Point, Point]  # set point, inputs
Shares = Callable[[Case], tuple[float, ...]]
TOGETHER = 3  # windings that one worker solves in a row, each from the one before


@dataclass(eq=False)
class Windings:
    """Solved windings: margins, friction shares and reasons of failures by case.

    Attributes
    ----------
    margins : dict of Case to (margins,) array
        The transformed reserves y; nan where the winding failed.
    shares : dict of Case to (depths,) array
    reasons : dict of Case to str
    """

    margins: dict[Case, Array] = field(default_factory=dict)
    shares: dict[Case, Array] = field(default_factory=dict)
    reasons: dict[Case, str] = field(default_factory=dict)

    def add(self, case: Case, outputs: Array, depths: int, reason: str) -> None:
        """Add a winding by its outputs, the last of which are friction shares at the depths."""
        count = outputs.size - depths
        self.margins[case] = from_reserve(outputs[:count])
        self.shares[case] = outputs[count:]
        if reason:
            self.reasons[case] = reason

    def is_solved(self, case: Case) -> bool:
        """Return True if a case is solved; False if it failed or is unknown."""
        return case in self.margins and case not in self.reasons


class CaseSolver:
    """Solves windings at set points and inputs, stage by stage.

    Parameters
    ----------
    model : WindowModel
    set_points : SetPoints
    spreads : mapping of str to float
        Relative standard deviations of the inputs.
    workers, out, resume
        As of :func:`~woundon.operating_window`.
    """

    def __init__(
        self,
        model: WindowModel,
        set_points: SetPoints,
        spreads: Mapping[str, float],
        workers: int | None,
        out: str | Path | None,
        resume: bool,
    ) -> None:
        if resume and out is None:
            raise InvalidProblem.at("resume", "needs out, the folder of the windings")
        self.model, self.set_points, self.spreads = model, set_points, dict(spreads)
        self.workers, self.resume = workers, resume
        self.out = None if out is None else Path(out)

    def solve(
        self,
        stage: str,
        windings: Windings,
        cases: Sequence[Case],
        shares: Shares | None = None,
        report: Callable[[int], None] = lambda solved: None,
    ) -> None:
        """Solve the cases of a stage that are not solved yet.

        Parameters
        ----------
        stage : str
            Name of its folder.
        windings : Windings
            Where the solved cases are added.
        cases : sequence of Case
        shares : callable, optional
            Friction shares of a case; by default the nips are solved.
        report : callable
            Is called with the number of windings solved in this stage.
        """
        new = [case for case in dict.fromkeys(cases) if case not in windings.margins]
        if not new:
            return
        table = run_study(
            self.model,
            table_of_cases(self._columns(new, shares)),
            Workers(self.workers),
            out=None if self.out is None else self.out / stage,
            resume=self.resume,
            chunk=TOGETHER,
            progress=lambda solved, _: report(solved),
        )
        outputs = np.column_stack(list(table.outputs.values()))
        for case, row, reason in zip(new, outputs, table.failure, strict=True):
            windings.add(case, row, len(self.model.depths), str(reason))

    def _columns(self, cases: Sequence[Case], shares: Shares | None) -> dict[str, Any]:
        """Return the inputs of cases by name."""
        values = self.set_points.values(np.array([x for x, _ in cases]))
        columns: dict[str, Any] = dict(zip(self.set_points.names, values.T, strict=True))
        for k, (name, spread) in enumerate(self.spreads.items()):
            z = np.array([inputs[k] for _, inputs in cases])
            median = float(get_field(self.model.problem, name))
            columns[name] = median * np.exp(log_deviation(spread) * z)
        if shares is not None:
            columns[FRICTION_SHARE] = [shares(case) for case in cases]
        return columns


def share_polynomials(
    windings: Windings, points: Sequence[Point], degrees: Sequence[int], steps: Sequence[Case]
) -> Shares:
    """Return the friction shares as a function of set point and inputs.

    Polynomials interpolate their arcsine transform: shares are at most 1 and, near the core, where
    the roll is hard, little more than 0, which sums of effects would pass.

    Parameters
    ----------
    windings : Windings
        With solved nips.
    points : sequence of Point
        Solved with median inputs; polynomials of the set point go through their shares.
    degrees : sequence of int
        Largest degree along each coordinate.
    steps : sequence of Case
        One for each input, which is one standard deviation higher, all at the same solved point.
        The effect of an input on the transform is linear and the same at all set points.
    """
    median = (0.0,) * len(steps)
    angles = np.array([_angle(windings.shares[x, median]) for x in points])
    nominal = fitted(np.array(points), angles, degrees)
    slopes = np.zeros((len(steps), angles.shape[1]))
    for k, (x, inputs) in enumerate(steps):
        if windings.is_solved((x, inputs)):
            slopes[k] = _angle(windings.shares[x, inputs]) - _angle(windings.shares[x, median])

    def shares(case: Case) -> tuple[float, ...]:
        x, inputs = case
        angle = nominal(np.array([x]))[0] + np.array(inputs) @ slopes
        return tuple(_share(angle).tolist())

    return shares


def _angle(share: Array) -> Array:
    """Return the arcsine transform of shares in [-1, 1], an odd function."""
    size = np.minimum(np.abs(share), 1.0)
    return np.asarray(np.sign(share) * np.arcsin(np.sqrt(size)))


def _share(angle: Array) -> Array:
    """Return the shares of their arcsine transforms."""
    size = np.minimum(np.abs(angle), np.pi / 2)
    return np.asarray(np.sign(angle) * np.sin(size) ** 2)
