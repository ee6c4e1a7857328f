r"""The operating window: the probability that a roll keeps all its limits, over the set points.

The margins of windings at 5 x 5 Chebyshev-Lobatto points of (ln web tension, ln nip load), with
three levels of the torque split if it is varied, are interpolated.  Their derivatives with respect
to the uncertain inputs are differences over one standard deviation: to one side at the
centre and, for the inputs that matter there, to the other side, which gives the curvature, and to
one side at four more points.  :mod:`.window_map` computes the probabilities.

The windings are studies of three stages, each in a folder of its own, that can be resumed.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from math import isfinite, log
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..arguments import whole_number
from ..errors import InvalidProblem, NotConverged
from ..problems.grades import Grade, grade
from ..problems.messages import quote
from ..problems.problem import Problem
from ..problems.schedules import Profile, Taper
from ..quantities import Quantity, scalar_outputs
from ..results import Presented, ReadOnly
from .api import in_si
from .design import make_design
from .engine import Progress, run_study
from .kind_model import KindModel, field_quantity, get_field, kind_of, model_of
from .runners import runner_for
from .window_map import MarginMap, fitted, from_reserve, lobatto, standard_normal, to_reserve

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["OperatingPoint", "OperatingWindow", "operating_window"]

Array = np.ndarray
LEVELS = (0.5, 0.9, 0.99)  # of the contours
GRID = 33  # points of the map along web tension and nip load
# Accuracy of the windings: changes of the margins by 0.01, a tenth of what the usual spreads cause
ACCURACY: dict[str, Any] = {"rtol": 1e-2, "nodes": 33, "agreed": 1e-3}
MATTERS = 0.01  # of the variance of a margin at the centre, from which its slope is mapped
INNER = 0.5**0.5  # coordinate of the second and fourth of five Lobatto points
# off all lines of the 5 x 5 points, halfway between them in the angle
CHECKS = ((0.92387953, 0.38268343), (-0.38268343, 0.92387953),
          (-0.92387953, -0.38268343), (0.38268343, -0.92387953))  # fmt: skip
MOST_SPREAD = 2.0


class OperatingPoint(NamedTuple):
    """One point of an operating window.

    Attributes
    ----------
    values : mapping of str to float
        Web tension, nip load and torque split at the core, SI units.
    probability : float
        That all margins hold.
    binding : str
        The margin that is nearest to its limit, in its standard deviations.
    margins : mapping of str to (float, float)
        Each reserve with median inputs and its standard deviation, as a share of the limit.
    contributions : mapping of str to float
        Share of the variance of the binding margin that each uncertain input causes, largest first.
    """

    values: Mapping[str, float]
    probability: float
    binding: str
    margins: Mapping[str, tuple[float, float]]
    contributions: Mapping[str, float]


@dataclass(frozen=True, eq=False, repr=False)
class OperatingWindow(Presented, ReadOnly):
    """The probability that all margins of a winding hold, over its set points.

    Attributes
    ----------
    problem : WindingProblem
    names : tuple of str
        ``web_tension``, ``nip_load`` and, if it is varied, ``torque_split``.
    ranges : (d, 2) array
        Values at the core, SI units.
    margins : tuple of str
        The margins that have limits.
    uncertain : mapping of str to float
        Relative standard deviations by dotted name.
    axes : tuple of (n,) arrays
        Values of the map along each name, SI units.
    probability : (n, n[, n]) array
        That all margins hold; nan where no steady state exists.
    index : (n, n[, n], margins) array
        Mean distance of each margin from its limit, in its standard deviations.
    points : (p, d) array
        The operating points of the windings with median inputs, SI units.
    values : (p, margins) array
        Their reserves; nan where the winding failed.
    failures : tuple of (point, reason)
    errors : mapping of str to float
        Largest error of the probability over the map from ``interpolation``, ``linearisation``
        (leaving out the curvature) and ``sampling``; nan if unknown.
    interpolation : (margins,) array
        Estimated error of each interpolated margin, as a share of its limit near the limit.
    windings : int
        Windings that were solved.
    is_coarse : bool
        Whether this is the preview of 3 x 3 points.
    quantities : mapping of str to Quantity
    map : MarginMap
    model : KindModel
    """

    problem: Any
    names: tuple[str, ...]
    ranges: Array
    margins: tuple[str, ...]
    uncertain: Mapping[str, float]
    axes: tuple[Array, ...]
    probability: Array
    index: Array
    points: Array
    values: Array
    failures: tuple[tuple[tuple[float, ...], str], ...]
    errors: Mapping[str, float]
    interpolation: Array
    windings: int
    is_coarse: bool
    quantities: Mapping[str, Quantity]
    map: MarginMap
    model: Any

    @property
    def binding(self) -> Array:
        """Number of the binding margin over the map; -1 where no steady state exists."""
        return np.where(np.isnan(self.probability), -1, np.argmin(self.index, axis=-1))

    @property
    def best(self) -> OperatingPoint:
        """The point of the map with the highest probability.

        Among equal probabilities, that with the largest distance of the binding margin from its
        limit, in standard deviations.
        """
        highest = np.nanmax(self.probability)
        least = self.index.min(axis=-1)
        place = np.where(self.probability >= highest - 1e-12, least, -np.inf)
        where = np.unravel_index(int(np.argmax(place)), place.shape)
        return self.at(*(axis[k] for axis, k in zip(self.axes, where, strict=True)))

    def at(self, *values: float | str) -> OperatingPoint:
        """Return a point of the window.

        Parameters
        ----------
        *values : float or str
            Web tension, nip load and, if it is varied, torque split at the core; SI or texts with
            units.

        Raises
        ------
        InvalidProblem
            For values outside the ranges of the map.
        """
        if len(values) != len(self.names):
            text = f"{len(values)} values are given; must be {', '.join(self.names)}"
            raise InvalidProblem.at("values", text)
        given = in_si(self.problem, {n: [v] for n, v in zip(self.names, values, strict=True)})
        point = np.array([float(given[name][0]) for name in self.names])
        for name, value, (low, high) in zip(self.names, point, self.ranges, strict=True):
            if not low * (1 - 1e-9) <= value <= high * (1 + 1e-9):
                raise InvalidProblem.at(name, f"{value:g} is out of range; must be >= {low:g} and "
                                              f"<= {high:g}, the range of the map")  # fmt: skip
        x = _scaled(self.names, self.ranges, point[None])
        k = int(np.argmin(_index(*self.map.moments(x))[0]))
        reserves, deviations = (part[0] for part in self.map.reserves(x))
        variances = self.map.variances(x)[0, k]
        shares = variances / (variances.sum() or 1.0)
        ranked = sorted(zip(self.uncertain, shares.tolist(), strict=True), key=lambda p: -p[1])
        return OperatingPoint(
            dict(zip(self.names, point.tolist(), strict=True)),
            float(self.map.probability(x)[0]), self.margins[k],
            {name: (float(m), float(s))
             for name, m, s in zip(self.margins, reserves, deviations, strict=True)},
            dict(ranked),
        )  # fmt: skip

    def __repr__(self) -> str:
        best = self.best
        return f"OperatingWindow({self._text(best)}: probability {best.probability:.2f})"

    def __str__(self) -> str:
        return "\n".join(self.lines())

    def _text(self, point: OperatingPoint) -> str:
        texts = []
        for name, value in point.values.items():
            quantity = self.quantities[name]
            texts.append(f"{name} {quantity.shown(value):.4g} {quantity.display}".rstrip())
        return ", ".join(texts)

    def lines(self, *points: OperatingPoint) -> list[str]:
        """Return the window as lines of text: the best point, then others, and the errors."""
        rows = []
        for k, point in enumerate((self.best, *points)):
            head = "probability" if k else "highest probability"
            rows.append(f"{head} {point.probability:.2f} at {self._text(point)}")
            for name, (mean, deviation) in point.margins.items():
                mark = "  binding" * (name == point.binding)
                rows.append(f"  {name:<14}{mean:+8.2f} +- {deviation:.2f}{mark}")
            shares = [
                f"{name} {100 * share:.0f} %"
                for name, share in list(point.contributions.items())[:3]
                if share > 0.005
            ]
            rows.append(f"  variance of {point.binding}: {', '.join(shares) or 'none'}")
        solved = self.probability[~np.isnan(self.probability)]
        rows += [f"share of the map with a probability of at least {level:g}: "
                 f"{100 * np.mean(solved >= level) * solved.size / self.probability.size:.0f} %"
                 for level in LEVELS]  # fmt: skip
        known = [f"{name} {value:.2f}" for name, value in self.errors.items() if isfinite(value)]
        rows.append(f"estimated errors of the probability, at most: {', '.join(known)}")
        if np.isnan(self.probability).any():
            share = 100 * np.mean(np.isnan(self.probability))
            rows.append(f"no steady state, or not solved: {share:.0f} % of the map")
        preview = " (preview)" * self.is_coarse
        rows.append(f"{self.windings} windings, {len(self.failures)} failed{preview}")
        return rows

    def to_dataframe(self) -> pd.DataFrame:
        """Return the map as a table, SI units.

        A row for each point: the values at the core, the probability, the binding margin, and of
        each margin the reserve with median inputs and its standard deviation.
        """
        import pandas as pd

        mesh = np.stack(np.meshgrid(*self.axes, indexing="ij"), axis=-1).reshape(
            -1, len(self.names)
        )
        reserve, deviation = self.map.reserves(_scaled(self.names, self.ranges, mesh))
        columns: dict[str, Any] = dict(zip(self.names, mesh.T, strict=True))
        columns["probability"] = self.probability.ravel()
        words = np.array([*self.margins, ""], dtype=object)
        columns["binding"] = words[self.binding.ravel()]
        gone = np.isnan(self.probability.ravel())
        for k, name in enumerate(self.margins):
            columns[f"margins.{name}"] = np.where(gone, np.nan, reserve[:, k])
            columns[f"margins.{name} +-"] = np.where(gone, np.nan, deviation[:, k])
        return pd.DataFrame(columns)

    def to_json(self) -> str:
        """Return the best point and the error estimates as JSON, SI units."""
        best = self.best
        table = {
            "best": {**best._asdict(), "margins": {k: list(v) for k, v in best.margins.items()}},
            "errors": {k: v if isfinite(v) else None for k, v in self.errors.items()},
            "uncertain": dict(self.uncertain),
            "windings": self.windings,
            "failures": [[list(point), reason] for point, reason in self.failures],
        }
        return json.dumps(table, indent=1)

    def simulate(
        self, *values: float | str, samples: int = 100, seed: int = 1,
        workers: int | None = None, progress: bool | Progress = False,
    ) -> float:  # fmt: skip
        """Return the probability by Monte Carlo simulation with windings.

        Independent of the interpolation and of the expansion in the inputs: each sample is a
        winding.

        Parameters
        ----------
        *values : float or str
            As of :meth:`at`.
        samples, seed : int
            Number of draws, and their seed, which differs from that of the map by default.
        workers, progress
            As of :func:`operating_window`.

        Returns
        -------
        float
            Share of the windings that keep all limits; one without a solution keeps none.

        Raises
        ------
        InvalidProblem
            As of :meth:`at`.
        """
        z = standard_normal(len(self.uncertain), samples, seed)
        columns: dict[str, Any] = {
            n: np.full(samples, v) for n, v in self.at(*values).values.items()
        }
        for k, (name, spread) in enumerate(self.uncertain.items()):
            median = float(get_field(self.problem, name))
            columns[name] = median * np.exp(_sigma(spread) * z[:, k])
        table = run_study(
            self.model, make_design(columns, "table"), runner_for(workers, None), chunk=1,
            progress=progress,
        )  # fmt: skip
        reserves = np.column_stack(list(table.outputs.values()))
        return float(np.mean((reserves >= 0).all(axis=1)))

    def plot(self, path: Any = None, ax: Any = None) -> Any:
        """Draw the probability, its contours and the binding margins.

        Parameters
        ----------
        path, ax
            As of :func:`woundon.plot`.

        Returns
        -------
        matplotlib.figure.Figure, or ``ax`` where it is given
        """
        return self._figure(path, ax)


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

    >>> import woundon as wo
    >>> window = wo.operating_window(
    ...     problem, web_tension=(200, 500), nip_load=("1 kN/m", "4 kN/m"),
    ...     uncertain={"stack.radial.K2": 0.3, "roll_friction": 0.15},
    ... )  # doctest: +SKIP
    >>> window.best.probability, window.best.binding  # doctest: +SKIP

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
        Show the fraction done, or call with (windings done, windings expected).
    preview : callable, optional
        Is called with a coarse window after about a third of the windings.
    options : mapping
        Options of the solver.  By default a reduced accuracy: rtol 0.01, 33 nodes, agreed 0.001.

    Returns
    -------
    OperatingWindow

    Raises
    ------
    InvalidProblem
        For ranges or names at fault, without limits, or without spreads.
    NotConverged
        If too few windings can be solved.
    """
    _check_kind(problem)
    spreads, ties = _spreads(problem, uncertain, tie)
    whole_number("samples", samples, 100, 100_000)
    model = _model(problem, ties, options)
    for name in spreads:
        model.check_varied([name])
    ranges = _ranges(problem, web_tension, nip_load, torque_split)
    study = _Study(model, ranges, spreads, (samples, seed), workers, out, resume)
    with _reported(progress) as report:
        study.report = report
        coarse = study.coarse()
        if preview is not None:
            preview(coarse)
        return study.complete()


# ---- the windings -------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class _WindowModel(KindModel):
    """A winding whose schedules are given by their values at the core."""

    def variant(self, inputs: Mapping[str, Any]) -> Any:
        scaled = {
            path: value
            for name, given in inputs.items()
            for path, value in _with_value(self.problem, name, given).items()
        }
        return super().variant(scaled)


def _with_value(problem: Any, name: str, value: float) -> dict[str, Any]:
    """Return the fields that give a schedule a value at the core."""
    schedule = get_field(problem, name)
    if isinstance(schedule, Taper):
        return {f"{name}.start": value}
    if isinstance(schedule, Profile):
        factor = value / float(schedule.at(np.array(problem.core.radius)))
        return {f"{name}.value": tuple(factor * v for v in schedule.value)}
    return {name: value}


def _margin_names(problem: Any) -> tuple[str, ...]:
    """Return the names of the margins among the outputs of a problem's kind."""
    names = scalar_outputs(kind_of(problem).result)
    return tuple(name.removeprefix("margins.") for name in names if name.startswith("margins."))


def _check_kind(problem: Any) -> None:
    if not _margin_names(problem):
        text = f"{type(problem).__name__} is out of place; must be a WindingProblem"
        raise InvalidProblem.at("problem", text)


def _model(problem: Any, tie: Mapping[str, str], options: Mapping[str, Any] | None) -> KindModel:
    """Return the model whose outputs are the margins that have limits."""
    known = _margin_names(problem)
    given = {**ACCURACY, **(options or {})}
    made = model_of(problem, [f"margins.{name}" for name in known], tie, given)
    return _WindowModel(made.problem, made.outputs, made.options, made.tie)


def _spreads(
    problem: Any, uncertain: Any, tie: Mapping[str, str] | None
) -> tuple[dict[str, float], dict[str, str]]:
    """Return the relative standard deviations of the inputs, and the fields that follow others."""
    own: Mapping[str, Any] = uncertain if isinstance(uncertain, Mapping) else {}
    named: Grade | None = getattr(problem, "named_grade", None)
    if isinstance(uncertain, (str, Grade)):
        named = grade(uncertain)
    elif uncertain is not None and not isinstance(uncertain, Mapping):
        text = f"{quote(uncertain)} is out of place; must be {{field: relative deviation}}"
        raise InvalidProblem.at("uncertain", text)
    spreads: dict[str, float] = {}
    ties = dict(tie or {})
    if named is not None:
        followers = named.tied_fields(problem)
        ties = {**followers, **ties}
        spreads = {n: s for n, s in named.spread_of(problem).items() if n not in ties}
    for name, value in own.items():
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not (
            0 <= value <= MOST_SPREAD
        ):  # fmt: skip
            text = f"{quote(value)} is out of range; must be >= 0 and <= {MOST_SPREAD:g}"
            raise InvalidProblem.at(f"uncertain.{name}", text)
        spreads[name] = float(value)
    if not spreads:
        text = "missing; must be {field: relative standard deviation}, for the case names no grade"
        raise InvalidProblem.at("uncertain", text)
    for name in own:
        value = get_field(problem, name)
        if field_quantity(problem, name) is None or not isinstance(value, float) or value <= 0:
            text = f"{quote(value)} is not a number > 0, so it has no log-normal distribution"
            raise InvalidProblem.at(f"uncertain.{name}", text)
    found = {n: s for n, s in spreads.items() if s > 0 and get_field(problem, n) > 0}
    return found, ties


def _ranges(problem: Any, *given: Any) -> dict[str, tuple[float, float]]:
    """Return the ranges by name, SI units."""
    ranges: dict[str, tuple[float, float]] = {}
    for name, ends in zip(("web_tension", "nip_load", "torque_split"), given, strict=True):
        if ends is None and name == "torque_split":
            continue
        if isinstance(ends, str) or not hasattr(ends, "__len__") or len(ends) != 2:
            raise InvalidProblem.at(name, f"{quote(ends)} is out of place; must be (low, high)")
        low, high = (_number(name, end) for end in in_si(problem, {name: ends})[name])
        least = -1e-300 if name == "torque_split" else 0.0
        if not least < low < high < float("inf"):
            text = f"({low:g}, {high:g}) is out of range; must be 0 < low < high"
            raise InvalidProblem.at(name, text)
        ranges[name] = (low, high)
    return ranges


def _number(name: str, value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float, np.floating, np.integer)):
        raise InvalidProblem.at(name, f"{quote(value)} is not a number")
    return float(value)


def _sigma(spread: float) -> float:
    """Return the standard deviation of the logarithm of a log-normal distribution."""
    return log(1 + spread**2) ** 0.5


def _scaled(names: Sequence[str], ranges: Array, points: Array) -> Array:
    """Return values at the core as coordinates in [-1, 1]; tensions and loads by logarithm."""
    log_scale = np.array([name != "torque_split" for name in names])
    low, high, given = (
        np.where(log_scale, np.log(np.where(log_scale, v, 1.0)), v)
        for v in (ranges[:, 0], ranges[:, 1], points)
    )
    return np.clip(2 * (given - low) / (high - low) - 1, -1.0, 1.0)


def _values(names: Sequence[str], ranges: Array, x: Array) -> Array:
    """Return the values at the core of coordinates."""
    share, (low, high) = (x + 1) / 2, ranges.T
    log_scale = np.array([name != "torque_split" for name in names])
    ratio = np.where(log_scale, high / np.where(log_scale, low, 1.0), 1.0)
    return np.where(log_scale, low * ratio**share, low + (high - low) * share)


def _index(mean: Array, deviation: Array) -> Array:
    """Return means in standard deviations; without a deviation a large multiple of the mean."""
    return np.asarray(mean / np.maximum(deviation, 1e-6))


class _Study:
    """The windings of a window, in stages, and the maps that follow from them."""

    def __init__(
        self, model: KindModel, ranges: Mapping[str, tuple[float, float]],
        spreads: Mapping[str, float], sampling: tuple[int, int], workers: int | None,
        out: str | Path | None, resume: bool,
    ) -> None:  # fmt: skip
        self.model, self.spreads, self.sampling = model, dict(spreads), sampling
        self.names, self.ranges = tuple(ranges), np.array(list(ranges.values()))
        self.workers, self.resume = workers, resume
        self.out = None if out is None else Path(out)
        if resume and out is None:
            raise InvalidProblem.at("resume", "needs out, the folder of the windings")
        self.report: Callable[[int, int], None] = lambda done, expected: None
        self.found: dict[tuple[tuple[float, ...], tuple[float, ...]], Array] = {}
        self.reasons: dict[tuple[tuple[float, ...], tuple[float, ...]], str] = {}
        self.inputs = len(spreads)
        self.median = (0.0,) * self.inputs
        self.centre = (0.0,) * len(self.names)
        third = [lobatto(3)] * (len(self.names) - 2)
        self.fine = [tuple(p) for p in _product(lobatto(5), lobatto(5), *third)]
        self.rough = [tuple(p) for p in _product(lobatto(3), lobatto(3), *third)]
        self.checks = [(*pair, *(0.0 for _ in third)) for pair in CHECKS]
        # four more slopes for three inputs are expected to be mapped
        self.expected = len(self.fine) + self.inputs + len(CHECKS) + 5 * min(3, self.inputs)

    def run(self, stage: str, cases: Sequence[tuple[tuple[float, ...], tuple[float, ...]]]) -> None:
        """Solve windings: coordinates of the point, and inputs in standard deviations."""
        new = [case for case in dict.fromkeys(cases) if case not in self.found]
        if not new:
            return
        points = _values(self.names, self.ranges, np.array([x for x, _ in new]))
        columns: dict[str, Any] = dict(zip(self.names, points.T, strict=True))
        for k, (name, spread) in enumerate(self.spreads.items()):
            z = np.array([case[1][k] for case in new])
            columns[name] = float(get_field(self.model.problem, name)) * np.exp(_sigma(spread) * z)
        done = len(self.found)
        self.expected = max(self.expected, done + len(new))
        table = run_study(
            self.model, make_design(columns, "table"), runner_for(self.workers, None),
            out=None if self.out is None else self.out / stage, resume=self.resume, chunk=1,
            progress=lambda solved, _: self.report(done + solved, self.expected),
        )  # fmt: skip
        values = np.column_stack(list(table.outputs.values()))
        for case, row, reason in zip(new, values, table.failure, strict=True):
            self.found[case] = from_reserve(row)
            if reason:
                self.reasons[case] = str(reason)

    def _step(self, k: int, size: float) -> tuple[float, ...]:
        return tuple(size * (j == k) for j in range(self.inputs))

    def coarse(self) -> OperatingWindow:
        """Solve 3 x 3 points and one difference for each input."""
        steps = [(self.centre, self._step(k, 1.0)) for k in range(self.inputs)]
        self.run("coarse", [*((x, self.median) for x in self.rough), *steps])
        return self.window(self.rough, [2] * len(self.names), is_coarse=True)

    def complete(self) -> OperatingWindow:
        """Solve all points; of the inputs that matter, second differences and slopes."""
        steps = [(self.centre, self._step(k, -1.0)) for k in self._important()]
        points = [(x, self.median) for x in (*self.fine, *self.checks)]
        self.run("fine", [*points, *steps])
        outer = [(u, v, *self.centre[2:]) for u in (-INNER, INNER) for v in (-INNER, INNER)]
        self.outer = [min(self.fine, key=lambda f: float(np.sum((np.array(f) - x) ** 2)))
                      for x in map(np.array, outer)]  # fmt: skip
        self.run("slopes", [(x, self._step(k, 1.0)) for k in self._important()
                            for x in self.outer])  # fmt: skip
        return self.window(self.fine, [4, 4, *[2] * (len(self.names) - 2)], is_coarse=False)

    def _important(self) -> list[int]:
        """Return the inputs that matter at the centre, or whose effect is unknown."""
        slopes, curvature = (part[self._checked()] for part in self._differences(self.centre))
        variance = slopes**2 + curvature**2 / 2
        total = np.nansum(variance, axis=1, keepdims=True)
        share = variance / np.where(total > 0, total, 1.0)
        return np.nonzero(~(share <= MATTERS).all(axis=0))[0].tolist()

    # ---- maps -----------------------------------------------------------------------------------

    def _checked(self) -> Array:
        """Return which margins have a limit: those that any winding gives as a number."""
        return np.isfinite(np.array(list(self.found.values()))).any(axis=0)

    def _differences(self, x: tuple[float, ...]) -> tuple[Array, Array]:
        """Return slope and curvature of all margins for all inputs at a point, nan if unknown."""
        base = self.found.get((x, self.median), np.array(np.nan))
        none = np.full(len(self.model.outputs), np.nan)
        slopes, curvature = [], []
        for k in range(self.inputs):
            up = self.found.get((x, self._step(k, 1.0)), none) - base
            down = self.found.get((x, self._step(k, -1.0)), none) - base
            both = np.isfinite(up) & np.isfinite(down)
            slopes.append(np.where(both, (up - down) / 2, np.where(np.isfinite(up), up, -down)))
            curvature.append(np.where(both, up + down, 0.0))
        return np.array(slopes).T, np.array(curvature).T

    def window(
        self, nodes: Sequence[tuple[float, ...]], degrees: Sequence[int], *, is_coarse: bool
    ) -> OperatingWindow:
        """Return the window of what is solved so far."""
        checked = self._checked()
        if not checked.any():
            self._reject()
        x = np.array(nodes)
        reserves = np.array([self.found[node, self.median] for node in nodes])[:, checked]
        solved = np.isfinite(reserves).all(axis=1)
        if solved.sum() < 4:
            reasons = "; ".join(dict.fromkeys(self.reasons.values()))
            raise NotConverged(f"only {solved.sum()} of {len(x)} windings were solved: {reasons}")
        nominal = fitted(x[solved], reserves[solved], degrees)
        mapped = MarginMap(
            nominal, *self._expansion(checked), standard_normal(self.inputs, *self.sampling)
        )
        interpolation = self._interpolation(mapped, checked, x[solved], reserves[solved])
        axes_x = [np.linspace(-1, 1, GRID), np.linspace(-1, 1, GRID)]
        axes_x += [lobatto(3)] * (len(self.names) - 2)
        mesh = np.array(_product(*axes_x))
        shape = tuple(len(axis) for axis in axes_x)
        steady = self._steady(mesh, x[~solved])
        probability = np.where(steady, mapped.probability(mesh), np.nan)
        points = _values(self.names, self.ranges, x)
        axes = tuple(
            _values(self.names, self.ranges, np.tile(axis[:, None], len(self.names)))[:, k]
            for k, axis in enumerate(axes_x)
        )
        if not steady.any():
            raise NotConverged("no steady state exists at any point of the map")
        known = _margin_names(self.model.problem)
        return OperatingWindow(
            problem=self.model.problem, names=self.names, ranges=self.ranges,
            margins=tuple(n for n, given in zip(known, checked, strict=True) if given),
            uncertain=self.spreads, axes=axes, probability=probability.reshape(shape),
            index=_index(*mapped.moments(mesh)).reshape(*shape, -1), points=points,
            values=to_reserve(reserves)[0], failures=self._failures(), interpolation=interpolation,
            errors=self._errors(mapped, mesh[steady], interpolation, is_coarse=is_coarse),
            windings=len(self.found), is_coarse=is_coarse, map=mapped,
            model=replace(self.model, outputs=tuple(
                n for n, given in zip(self.model.outputs, checked, strict=True) if given)),
            quantities={n: q for n in (*self.names, *self.spreads)
                        if (q := self.model.quantity(n)) is not None},
        )  # fmt: skip

    def _reject(self) -> None:
        if self.reasons and len(self.reasons) == len(self.found):
            reasons = "; ".join(dict.fromkeys(self.reasons.values()))
            raise NotConverged(f"none of {len(self.found)} windings was solved: {reasons}")
        text = "none is given; must be at least one, or no margin can be checked"
        raise InvalidProblem.at("limits", text)

    def _expansion(self, checked: Array) -> tuple[tuple[Any, ...], Array]:
        """Return slopes as functions of the point, and curvatures."""
        centre, curvature = (part[checked] for part in self._differences(self.centre))
        curvature = np.nan_to_num(curvature)
        slopes = []
        for k in range(self.inputs):
            places, values = [self.centre[:2]], [np.nan_to_num(centre[:, k])]
            for x in getattr(self, "outer", ()):
                up = self.found.get((x, self._step(k, 1.0)))
                if up is None:
                    continue
                change = (up - self.found[x, self.median])[checked]
                if np.isfinite(change).all():
                    places.append(x[:2])
                    # a difference to one side contains half of the curvature
                    values.append(change - curvature[:, k] / 2)
            degree = 1 if len(places) == 5 else 0
            slopes.append(fitted(np.array(places), np.array(values), [degree, degree]))
        return tuple(slopes), curvature

    def _interpolation(self, mapped: MarginMap, checked: Array, x: Array, values: Array) -> Array:
        """Return the error of the interpolated margins, from windings at other points.

        Without these, the difference to the interpolant of the 3 x 3 points that it contains.
        """
        pairs = [(c, self.found[c, self.median][checked]) for c in self.checks
                 if (c, self.median) in self.found]  # fmt: skip
        pairs = [(c, row) for c, row in pairs if np.isfinite(row).all()]
        if not pairs:
            return np.full(int(checked.sum()), np.nan)
        places, rows = np.array([c for c, _ in pairs]), np.array([row for _, row in pairs])
        return np.asarray(np.abs(mapped.nominal(places) - rows).max(axis=0))

    def _errors(
        self, mapped: MarginMap, mesh: Array, interpolation: Array, *, is_coarse: bool
    ) -> dict[str, float]:
        """Return the largest errors of the probability over the map."""
        # every third point: they vary slowly
        some = mesh[::3]
        reference = mapped.probability(some)
        errors = {"interpolation": np.nan, "linearisation": np.nan}
        if not is_coarse:
            linear = mapped.probability(some, linear=True)
            errors["linearisation"] = float(np.abs(linear - reference).max())
        if np.isfinite(interpolation).all():
            shifted = [mapped.probability(some, shift=s * interpolation) for s in (-1, 1)]
            errors["interpolation"] = float(np.abs(np.array(shifted) - reference).max())
        # of independent draws; that of Sobol points is smaller
        errors["sampling"] = float(np.sqrt(reference * (1 - reference) / len(mapped.sample)).max())
        return errors

    def _steady(self, mesh: Array, failed: Array) -> Array:
        """Return at which points a winding exists: no load slides the drum, no node near failed."""
        steady = np.ones(len(mesh), dtype=bool)
        if not len(failed):
            return steady
        nodes = np.array(self.fine)
        nearest = np.argmin(((mesh[:, None] - nodes[None]) ** 2).sum(axis=-1), axis=1)
        refused = {
            node for (node, z), reason in self.reasons.items()
            if z == self.median and not reason.startswith("NoSteadyState")
        }  # fmt: skip
        steady &= np.array([self.fine[k] not in refused for k in nearest])
        for k, point in enumerate(_values(self.names, self.ranges, mesh)):
            if steady[k]:
                try:
                    self.model.variant(dict(zip(self.names, point.tolist(), strict=True)))
                except InvalidProblem:
                    steady[k] = False
        return steady

    def _failures(self) -> tuple[tuple[tuple[float, ...], str], ...]:
        found = []
        for (x, _), reason in self.reasons.items():
            point = _values(self.names, self.ranges, np.array([x]))[0]
            found.append((tuple(point.tolist()), reason))
        return tuple(found)


def _product(*axes: Array) -> list[tuple[float, ...]]:
    mesh = np.meshgrid(*axes, indexing="ij")
    return [tuple(row) for row in np.stack(mesh, axis=-1).reshape(-1, len(axes)).tolist()]


@contextmanager
def _reported(progress: bool | Progress) -> Iterator[Callable[[int, int], None]]:
    if progress is True:
        from .bars import fraction_bar

        with fraction_bar("winding") as tell:
            yield lambda done, expected: tell(done / expected)
    elif progress:
        yield progress
    else:
        yield lambda done, expected: None
