r"""The windings of an operating window as a model of studies: schedules and friction shares.

A set point is the value of a schedule at the core; the schedule keeps its shape.

Nearly all the time of a winding is spent on its nips, while the *friction share* y of the
wound-on tension varies little and smoothly with the set point and the inputs:

    WOT(r) = T_in(r) + F(r) + y(d) mu P(r),      d = (r - r_c)/(R - r_c)

with the roll friction mu and the nip load P.  A winding whose y is interpolated takes only the
computation of the roll, about a twentieth of the time.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..problems.paths import get_field
from ..problems.schedules import Profile, Taper
from ..quantities import Quantity, scalar_outputs
from .kind_model import KindModel, kind_of, model_of
from .model import Answer

__all__ = ["FRICTION_SHARE", "WindowModel", "margin_names", "window_model", "with_value"]

Array = np.ndarray
# Accuracy of the windings: changes of the margins by 0.01, a tenth of what the usual spreads cause
ACCURACY: dict[str, Any] = {"rtol": 1e-2, "nodes": 33, "coupling_rtol": 1e-3}
FRICTION_SHARE = "friction_share"  # the column of the shares, one tuple for each case
# depths at which the shares are known: even in the logarithm, for they change near the core, and
# even in the radius
BY_LOGARITHM, EVEN = 25, 17
SAME_DEPTH = 9  # decimals of d


@dataclass(frozen=True, eq=False)
class WindowModel(KindModel):
    """Windings whose schedules are given by their values at the core.

    Attributes
    ----------
    depths : tuple of float
        Relative depths d at which the friction shares are outputs, behind the other outputs; none
        if a wound-on tension takes no nip, or nips and roll are also coupled by entrained air.
    """

    depths: tuple[float, ...] = ()

    def variant(self, inputs: Mapping[str, Any]) -> Any:
        """Return the problem of one case; with friction shares, one that needs no nip."""
        shares = inputs.get(FRICTION_SHARE)
        fields: dict[str, Any] = {}
        for name, value in inputs.items():
            if name != FRICTION_SHARE:
                fields |= with_value(self.problem, name, value)
        problem = super().variant(fields)  # rejects a set point without a steady state
        if shares is None:
            return problem
        r = _radii(problem, self.depths)
        tension = _without_friction(problem, r) + np.array(shares) * _friction(problem, r)
        return problem.replace(tension_law=Profile(radius=r, value=tension))

    def run(self, inputs: Mapping[str, Any], start: Any | None) -> Answer:
        """Solve one case for its margins and the friction shares (WOT - T_in - F)/(mu+ P)."""
        count = len(self.outputs) - len(self.depths)
        margins = replace(self, outputs=self.outputs[:count])
        answer = KindModel.run(margins, inputs, start)
        if not self.depths:
            return answer
        result, problem = answer.state, answer.state.problem
        r = _radii(problem, self.depths)
        tension = np.interp(r, result.radius, result.wound_on_tension)
        shares = (tension - _without_friction(problem, r)) / _friction(problem, r)
        return answer._replace(values=(*answer.values, *shares.tolist()))

    def only(self, outputs: Iterable[str]) -> WindowModel:
        """Return the model without friction shares and with some of the margins."""
        return replace(self, outputs=tuple(outputs), depths=())

    def quantity(self, name: str) -> Quantity | None:
        """Return the quantity of an output or a field; None for friction shares."""
        return None if name.startswith(FRICTION_SHARE) else super().quantity(name)


def _radii(problem: Any, depths: Sequence[float]) -> Array:
    """Return the radii at relative depths between core and surface [m]."""
    core, R = problem.ends
    r = core + np.array(depths) * (R - core)
    r[-1] = R
    return np.asarray(r)


def _without_friction(problem: Any, r: Array) -> Array:
    """Return T_in + F, the wound-on tension without friction on the roll [N/m]."""
    return np.asarray(problem.at("web_tension", r) + problem.at("winding_force", r))


def _friction(problem: Any, r: Array) -> Array:
    """Return mu+ P, the largest friction force on the roll [N/m]."""
    return np.asarray(problem.roll_friction * problem.at("nip_load", r))


def _depths(problem: Any) -> tuple[float, ...]:
    """Return the relative depths at which the friction shares of a winding are interpolated."""
    if problem.tension_law != "nip" or problem.air is not None:
        return ()
    core, R = problem.ends
    first = problem.web.thickness / (R - core)
    kinks = [(r - core) / (R - core) for r in problem.kinks if core < r < R]
    d = [0.0, *np.geomspace(first, 1.0, BY_LOGARITHM), *np.linspace(0.0, 1.0, EVEN), *kinks]
    return tuple(np.unique(np.round(d, SAME_DEPTH)).tolist())


def with_value(problem: Any, name: str, value: Any) -> dict[str, Any]:
    """Return the fields that give a field a value, or a schedule this value at the core."""
    schedule = get_field(problem, name)
    if isinstance(schedule, Taper):
        return {f"{name}.start": value}
    if isinstance(schedule, Profile):
        factor = value / float(schedule.at(np.array(problem.core.radius)))
        return {f"{name}.value": tuple(factor * v for v in schedule.value)}
    return {name: value}


def margin_names(problem: Any) -> tuple[str, ...]:
    """Return the names of the margins among the outputs of a problem's kind."""
    names = scalar_outputs(kind_of(problem).result)
    return tuple(name.removeprefix("margins.") for name in names if name.startswith("margins."))


def window_model(
    problem: Any, tie: Mapping[str, str], options: Mapping[str, Any] | None
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
    base = model_of(problem, names, tie, {**ACCURACY, **(options or {})})
    depths = _depths(problem)
    shares = tuple(f"{FRICTION_SHARE}[{k}]" for k in range(len(depths)))
    return WindowModel(base.problem, (*base.outputs, *shares), base.options, base.tie, depths)
