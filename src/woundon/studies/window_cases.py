"""The windings of an operating window: problems at set points, friction shares, and solutions.

A set point is the value of a field, of a schedule at the core; the schedule keeps its shape.

Nearly all the time of a winding is spent on its nips, while the *friction share* y of the
wound-on tension varies little and smoothly with the set point and the inputs:

    WOT(r) = T_in(r) + F(r) + y(d) mu P(r),      d = (r - r_c)/(R - r_c)

with the roll friction mu and the nip load P.  A winding whose y is interpolated takes only the
computation of the roll, about a twentieth of the time.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import log
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..arguments import check_arguments
from ..errors import InvalidProblem, one_of
from ..problems.grades import Grade, grade
from ..problems.messages import out_of_range
from ..problems.paths import get_field, varied_number
from ..problems.schedules import Profile, Steps, Taper
from ..problems.units import parse
from ..problems.winding import SCHEDULES, WindingProblem
from ..quantities import Quantity, scalar_outputs
from ..results import Result
from .api import range_in_si
from .cases import table_of_cases
from .model import Answer, KindModel, kind_of, model_of, solver_options
from .progress import Progress
from .run import Workers, run_study
from .window_map import SetPoints, fitted, from_reserve

__all__ = [
    "CaseSolver",
    "Shares",
    "Windings",
    "joined",
    "margin_names",
    "ranges_of",
    "share_polynomials",
    "spreads_and_ties",
    "window_model",
    "with_value",
]

Array = np.ndarray
Shares = Callable[[Array, Array], Array]  # set points x, inputs z -> friction shares

# Accuracy of the windings: changes of the margins by 0.01, a tenth of what the usual spreads cause;
# the errors of a window follow from its checks, not from estimates of single windings
ACCURACY: dict[str, Any] = {"rtol": 1e-2, "nodes": 33, "coupling_rtol": 1e-3, "errors": False}
FRICTION_SHARE = "friction_share"  # the column of the shares, one tuple for each case
# depths at which the shares are known: even in the logarithm, for they change near the core, and
# even in the radius
BY_LOGARITHM, EVEN = 25, 17
SAME_DEPTH = 9  # decimals of d
MOST_SPREAD = 2.0
MOST_AXES = 3  # of a window; the third one has three levels
TOGETHER = 3  # windings that one worker solves in a row, each from the one before


# ---- input --------------------------------------------------------------------------------------


def spreads_and_ties(
    problem: WindingProblem,
    uncertain: Mapping[str, float | str] | Grade | str | None,
    tie: Mapping[str, str] | None,
) -> tuple[dict[str, float], dict[str, str]]:
    """Return the relative standard deviations of the inputs, and the fields that follow others."""
    base_grade = problem.named_grade
    if isinstance(uncertain, (str, Grade)):
        base_grade, uncertain = grade(uncertain), None
    check_arguments(uncertain=uncertain, tie=tie)
    spreads, ties = dict[str, float](), dict(tie or {})
    if base_grade is not None:
        ties = {**base_grade.tied_fields(problem), **ties}
        spreads = {n: s for n, s in base_grade.spread_of(problem).items() if n not in ties}
    for name, spread in (uncertain or {}).items():
        varied_number(problem, name, where := f"uncertain.{name}", is_relative=True)
        spreads[name] = parse(spread, "1", where)
        if not 0 <= spreads[name] <= MOST_SPREAD:
            raise InvalidProblem.at(where, out_of_range(spreads[name], 0.0, MOST_SPREAD, "1"))
    if not spreads:
        text = (
            "missing, and the case names no grade that has spreads; must be {field: relative "
            "standard deviation}, on the command line --uncertain FIELD=DEVIATION"
        )
        raise InvalidProblem.at("uncertain", text)
    # a spread of 0 removes an input; a field of 0 has no log-normal distribution
    return {n: s for n, s in spreads.items() if s > 0 and get_field(problem, n) > 0}, ties


def ranges_of(
    problem: WindingProblem,
    named: Mapping[str, Any],
    vary: Mapping[str, Any],
) -> dict[str, tuple[float, float]]:
    """Return the ranges of the set points in SI units by the dotted names of their fields.

    Parameters
    ----------
    problem : WindingProblem
    named : mapping of str to (low, high) or None
        Of ``web_tension``, ``nip_load``, ``rider_load`` and ``torque_split``.
    vary : mapping of str to (low, high)
        Of any other fields.

    Raises
    ------
    InvalidProblem
        For other than two or three ranges, a load that the winding does not have, a field twice,
        one that is no number, and values out of the range of the field.
    """
    load = "nip_load" if problem.winder is None else "winder.rider_load"
    if problem.winder is None and named["rider_load"] is not None:
        text = "is given for a winding without a winder; must be left out"
        raise InvalidProblem.at("rider_load", f"{text}: the load is nip_load")
    if problem.winder is not None and named["nip_load"] is not None:
        text = "is given for a winding with a winder; must be left out"
        raise InvalidProblem.at("nip_load", f"{text}: it follows from rider_load")
    fields = {"rider_load": "winder.rider_load"}
    given = {fields.get(name, name): ends for name, ends in named.items() if ends is not None}
    for name, ends in vary.items():
        if name in given:
            raise InvalidProblem.at(f"vary.{name}", "is given twice; must be given once")
        given[name] = ends
    if not 2 <= len(given) <= MOST_AXES:
        names = one_of(given, "and") if given else "none"
        text = f"{names} given; must be the ranges of 2 or {MOST_AXES} "
        raise InvalidProblem.at("vary", f"{text}fields, such as web_tension and {load}")
    return {name: _range_of(problem, name, ends) for name, ends in given.items()}


def _range_of(problem: WindingProblem, name: str, ends: Any) -> tuple[float, float]:
    """Return the range of a set point in SI units, within that of its field or schedule."""
    schedule = get_field(problem, name)
    if name not in SCHEDULES or isinstance(schedule, str):  # the name of a law of the tension
        varied_number(problem, name)
    low, high = range_in_si(problem, name, ends)
    if name == "nip_load" and low == 0.0:
        text = "0 is out of range; must be > 0, as the friction of the nip is a share of its load"
        raise InvalidProblem.at(name, text)
    is_curve = isinstance(schedule, Profile | Steps)
    if is_curve and float(problem.curve(name).at(np.array(problem.core.radius))) == 0.0:
        text = "is 0 at the core; must not be 0 there, as its values are scaled to those of"
        raise InvalidProblem.at(name, f"{text} the range")
    return low, high


# ---- problems -----------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class WindowModel(KindModel):
    """Windings whose schedules are given by their values at the core; the outputs are margins.

    Attributes
    ----------
    depths : tuple of float
        Relative depths d at which the friction shares are outputs, behind the other outputs; none
        if a wound-on tension takes no nip, or nips and roll are also coupled by entrained air, or
        margins depend on the tensions between the nips of a two-drum winder.
    """

    problem: WindingProblem
    depths: tuple[float, ...] = ()

    def variant(self, inputs: Mapping[str, Any]) -> WindingProblem:
        """Return the problem of one case; with friction shares, one that needs no nip."""
        fields: dict[str, Any] = {}
        for name, value in inputs.items():
            if name != FRICTION_SHARE:
                fields |= with_value(self.problem, name, value)
        # rejects a set point without a steady state
        problem = self.with_ties(self.problem.replace(**fields))
        if FRICTION_SHARE not in inputs:
            return problem
        r, without_friction, friction = self._tensions(problem)
        tension = without_friction + np.array(inputs[FRICTION_SHARE]) * friction
        return problem.replace(tension_law=Profile(radius=r, value=tension))

    def run(self, inputs: Mapping[str, Any], start: Result | None) -> Answer:
        """Solve one case for its margins and the friction shares (WOT - T_in - F)/(mu P)."""
        count = len(self.outputs) - len(self.depths)  # of margins, which come first
        answer = KindModel.run(replace(self, outputs=self.outputs[:count]), inputs, start)
        if not self.depths:
            return answer
        winding = answer.state
        r, without_friction, friction = self._tensions(winding.problem)
        tension = np.interp(r, winding.radius, winding.wound_on_tension)
        shares = (tension - without_friction) / friction
        return answer._replace(values=(*answer.values, *shares.tolist()))

    def _tensions(self, problem: WindingProblem) -> tuple[Array, Array, Array]:
        """Return radii at the depths [m], and T_in + F and mu P there [N/m], (depths,) arrays."""
        core, R = problem.ends
        r = core + np.array(self.depths) * (R - core)
        r[-1] = R  # rounding may lead out of the roll
        without_friction = problem.at("web_tension", r) + problem.at("winding_force", r)
        return r, without_friction, problem.roll_friction * problem.at("nip_load", r)

    def with_margins(self, names: Sequence[str]) -> WindowModel:
        """Return the model whose outputs are some of the margins, without friction shares."""
        return replace(self, outputs=tuple(f"margins.{name}" for name in names), depths=())

    def quantity(self, name: str) -> Quantity | None:
        """Return the quantity of an output or a field; None for friction shares."""
        return None if name.startswith(FRICTION_SHARE) else super().quantity(name)


def window_model(
    problem: WindingProblem, tie: Mapping[str, str], options: Mapping[str, Any] | None
) -> WindowModel:
    """Return the model whose outputs are all margins, and the friction shares where they help.

    Parameters
    ----------
    problem : WindingProblem
    tie : mapping of str to str
        Field -> field that it follows.
    options : mapping, optional
        Options of the solver in place of the reduced accuracy.
    """
    names = [f"margins.{name}" for name in margin_names(problem)]
    base = model_of(problem, names, tie, {**ACCURACY, **solver_options(None, None, options)})
    depths = _depths(problem)
    shares = tuple(f"{FRICTION_SHARE}[{k}]" for k in range(len(depths)))
    return WindowModel(problem, (*base.outputs, *shares), base.options, base.tie, depths)


def margin_names(problem: WindingProblem) -> tuple[str, ...]:
    """Return the names of the margins among the outputs of a winding."""
    names = scalar_outputs(kind_of(problem).result)
    return tuple(name.removeprefix("margins.") for name in names if name.startswith("margins."))


def _depths(problem: WindingProblem) -> tuple[float, ...]:
    """Return the relative depths at which the friction shares of a winding are interpolated."""
    if not problem.solves_nips or problem.air is not None or problem.winder is not None:
        return ()
    core, R = problem.ends  # radii of the core and of the finished roll
    first = problem.web.thickness / (R - core)
    kinks = [(r - core) / (R - core) for r in problem.kinks if core < r < R]
    d = [0.0, *np.geomspace(first, 1.0, BY_LOGARITHM), *np.linspace(0.0, 1.0, EVEN), *kinks]
    return tuple(np.unique(np.round(d, SAME_DEPTH)).tolist())


def with_value(problem: WindingProblem, name: str, value: Any) -> dict[str, Any]:
    """Return the fields that give a field a value, or a schedule this value at the core."""
    schedule = get_field(problem, name)
    if isinstance(schedule, Taper):
        return {f"{name}.start": value}
    if isinstance(schedule, Profile | Steps):
        factor = value / float(problem.curve(name).at(np.array(problem.core.radius)))
        return {f"{name}.value": tuple(factor * v for v in schedule.value)}
    return {name: value}


def input_values(
    problem: WindingProblem, spreads: Mapping[str, float], z: Array
) -> dict[str, Array]:
    """Return the values of log-normal inputs by name, (cases,) each.

    Parameters
    ----------
    problem : WindingProblem
        Has the medians.
    spreads : mapping of str to float
        Standard deviations relative to the mean.
    z : (cases, inputs) array
        Logarithms in standard deviations from the median.

    Examples
    --------
    >>> import woundon as wo
    >>> problem = wo.WindingProblem.example()  # friction 0.19
    >>> values = input_values(problem, {"roll_friction": 0.3}, np.array([[0.0], [1.0]]))
    >>> values["roll_friction"].round(4)
    array([0.19  , 0.2548])
    """
    values = {}
    for (name, spread), column in zip(spreads.items(), z.T, strict=True):
        deviation = log(1 + spread**2) ** 0.5
        values[name] = float(get_field(problem, name)) * np.exp(deviation * column)
    return values


# ---- solutions ----------------------------------------------------------------------------------


class Windings(NamedTuple):
    """Solved windings.

    Attributes
    ----------
    x : (cases, d) array
        Coordinates of the set points.
    z : (cases, inputs) array
        Logarithms of the inputs in standard deviations from their medians.
    margins : (cases, margins) array
        The transformed reserves y of :mod:`.window_map`; nan where a winding failed.
    shares : (cases, depths) array
        Friction shares; no columns if the model has none.
    failures : (cases,) object array of str
        Reasons; empty where a winding was solved.
    """

    x: Array
    z: Array
    margins: Array
    shares: Array
    failures: Array

    @property
    def is_solved(self) -> Array:
        """Mask of the solved windings, (cases,)."""
        return np.asarray(self.failures == "")

    def rows(self, selection: Array | slice | Sequence[int]) -> Windings:
        """Return some of the windings: those of a mask, a slice or a list of numbers."""
        return Windings(*(array[selection] for array in self))


def joined(*parts: Windings) -> Windings:
    """Return the windings of several parts."""
    return Windings(*(np.concatenate(arrays) for arrays in zip(*parts, strict=True)))


@dataclass(frozen=True)
class CaseSolver:
    """Solves windings at set points and inputs.

    Attributes
    ----------
    model : WindowModel
    set_points : SetPoints
    spreads : mapping of str to float
        Relative standard deviations of the inputs.
    workers : Workers
    out, resume
        As of :func:`~woundon.operating_window`.
    chunk : int
        Windings that one worker solves in a row, each from the one before.
    """

    model: WindowModel
    set_points: SetPoints
    spreads: Mapping[str, float]
    workers: Workers
    out: Path | None = None
    resume: bool = False
    chunk: int = TOGETHER

    def solve(
        self,
        stage: str,
        x: Array,
        z: Array,
        shares: Shares | None = None,
        progress: bool | Progress = False,
    ) -> Windings:
        """Solve windings.

        Parameters
        ----------
        stage : str
            Name of their folder.
        x : (cases, d) array
            Coordinates of the set points.
        z : (cases, inputs) array
            Logarithms of the inputs in standard deviations from their medians.
        shares : callable, optional
            Friction shares of cases; by default the nips are solved.
        progress : bool or callable
            As of :func:`~woundon.operating_window`.
        """
        # outputs of the model: the reserves, then the friction share at each depth
        count = len(self.model.outputs) - len(self.model.depths)
        if not len(x):  # a study needs a case
            outputs, failures = np.zeros((0, len(self.model.outputs))), np.zeros(0, dtype=object)
            return Windings(x, z, outputs[:, :count], outputs[:, count:], failures)
        values = self.set_points.values(x).T
        columns: dict[str, Any] = dict(zip(self.set_points.names, values, strict=True))
        columns |= input_values(self.model.problem, self.spreads, z)
        if shares is not None:
            columns[FRICTION_SHARE] = [tuple(row) for row in shares(x, z).tolist()]
        table = run_study(
            self.model,
            table_of_cases(columns),
            self.workers,
            out=None if self.out is None else self.out / stage,
            resume=self.resume,
            chunk=self.chunk,
            progress=progress,
        )
        outputs = np.column_stack(list(table.outputs.values()))
        margins = from_reserve(outputs[:, :count])
        return Windings(x, z, margins, outputs[:, count:], table.failure)


# ---- friction shares ----------------------------------------------------------------------------


def share_polynomials(
    nominal: Windings, degrees: Sequence[int], base: Windings, steps: Windings
) -> Shares:
    """Return the friction shares as a function of set points and inputs.

    Polynomials interpolate their arcsine transform: shares are at most 1 and, near the core, where
    the roll is hard, little more than 0, which sums of effects would pass.

    Parameters
    ----------
    nominal : Windings
        With solved nips and median inputs; polynomials of the set point go through their shares.
    degrees : sequence of int
        Largest degree along each coordinate.
    base, steps : Windings
        With solved nips at one set point: with median inputs, and with one input each one standard
        deviation higher.  The effect of an input on the transform is linear and the same at all set
        points; it is 0 if the winding has failed.
    """
    solved = nominal.rows(nominal.is_solved)
    polynomial = fitted(solved.x, _angle(solved.shares), degrees)
    effects = np.nan_to_num(_angle(steps.shares) - _angle(base.shares))

    def shares(x: Array, z: Array) -> Array:
        """Return the friction shares of cases, (cases, depths)."""
        angle = polynomial(x) + z @ effects
        size = np.minimum(np.abs(angle), np.pi / 2)  # a share of 1 at most
        return np.asarray(np.sign(angle) * np.sin(size) ** 2)

    return shares


def _angle(share: Array) -> Array:
    """Return the arcsine transform of shares, arcsin(sqrt(share)), continued as an odd function.

    Shares outside [-1, 1] count as its ends.
    """
    size = np.minimum(np.abs(share), 1.0)
    return np.asarray(np.sign(share) * np.arcsin(np.sqrt(size)))
