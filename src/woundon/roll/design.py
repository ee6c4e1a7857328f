"""The inverse: the wound-on tension that makes a wanted pressure.

A wanted P(r) has the source C = r^2 P'' + 3 r P' + P - E_t F(P), which every stage of the build-up
shares.  So each stage is known without those before it: with its surface at s, the pressure solves
the equations of :mod:`.equations` with this C and P(s) = 0, and its slope there is the tension,
T(s) = -r P'.  At the core T = b P - r P' by the core's condition.  No optimiser is needed.

A pressure cannot be wanted of the surface, where it is zero.  What is wanted there shows as far
below it as the pressure takes to rise: the outer layer, whose depth and miss the result tells.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from ..arguments import check_type, tolerance
from ..errors import InvalidProblem, NotConverged
from ..parallel import one_thread
from ..problems.inputs import Context, convert
from ..problems.messages import quote
from ..problems.roll import RollProblem
from ..problems.schedules import Profile
from ..problems.wound_roll import WoundRoll
from ..quantities import find
from .build_up import in_cells, nodes_between
from .equations import Solved, pressure_between
from .finished import equations_of

if TYPE_CHECKING:
    from .equations import StageEquations

__all__ = ["TensionDesign", "design_tension"]

Array = np.ndarray

CELLS = 160  # of each stage
FIRST = 40  # radii at which the tension is found, before it is refined
MOST = 4000
NUDGE = 1e-12  # of ln r
ROOM = 0.5  # of rtol, for what the curve between two radii may miss


@dataclass(frozen=True, eq=False)
class TensionDesign:
    """A tension found for a wanted pressure, and how near it comes.

    Attributes
    ----------
    problem : RollProblem
        With the tension found as its ``wound_on_tension``.
    radius : (M,) array
        [m].
    wanted, reached : (M,) arrays
        Pressure wanted there, and of the finished roll, which misses it in the outer layer [Pa].
    rtol : float
        As asked for.
    """

    problem: RollProblem
    radius: Array
    wanted: Array
    reached: Array
    rtol: float

    @property
    def tension(self) -> Profile:
        """Wound-on tension over the radius [N/m]."""
        tension = self.problem.wound_on_tension
        assert isinstance(tension, Profile)
        return tension

    @property
    def outer_layer(self) -> float:
        """Depth below the surface from which on the pressure is met to ``rtol`` [m]."""
        missed = np.abs(self.reached - self.wanted) > self.rtol * np.max(self.wanted)
        return float(self.radius[-1] - self.radius[missed].min()) if missed.any() else 0.0

    @property
    def surface_miss(self) -> float:
        """The largest miss, in the outer layer [Pa]: the pressure wanted of the surface itself."""
        return float(np.max(np.abs(self.reached - self.wanted)))


@one_thread
def design_tension(
    problem: RollProblem, pressure: float | str | Profile, *, rtol: float = 1e-4
) -> TensionDesign:
    """Find the wound-on tension over the radius that leaves a wanted pressure in the roll.

    Parameters
    ----------
    problem : RollProblem
        The roll; its own tension plays no part.
    pressure : float, str or Profile
        Wanted between the laps [Pa], or a text with a unit, "200 kPa", from the core to the
        surface, > 0.  A pressure has no kinks: through the values of a profile goes a curve over
        ln r, a cubic spline if it is ``smooth``, or else one that stays between the values.
    rtol : float
        Accepted miss of the pressure inside, relative to the largest; 1e-6 to 0.01.

    Returns
    -------
    TensionDesign
        Its ``problem`` is ready to be solved.

    Raises
    ------
    InvalidProblem
        For a pressure that is out of range, that does not reach from core to surface, or that no
        tension > 0 makes.
    NotConverged
        Where a stage cannot be solved.
    """
    check_type("problem", problem, RollProblem)
    tolerance("rtol", rtol, 1e-6, 1e-2)
    if problem.temperature_change or problem.core_shrinkage:
        raise InvalidProblem.at(
            "problem", "changes after winding; must be a roll as wound: temperature_change and "
            "core_shrinkage 0"
        )  # fmt: skip
    (place,) = find(WoundRoll, "pressure")
    wanted = _Wanted(problem, _checked(problem, convert(pressure, place, Context())))
    found = _Stages(equations_of(problem), wanted)
    x = _refined(found, rtol)
    WOT = np.array([found.tension(s) for s in x]) * problem.web_thickness
    r = np.exp(x)
    r[0], r[-1] = problem.core.radius, problem.radius
    nodes, last = found.solved[x[-1]]
    at = np.exp(nodes)
    at[0], at[-1] = problem.core.radius, problem.radius
    return TensionDesign(
        problem.replace(
            wound_on_tension=Profile(radius=r.tolist(), value=WOT.tolist(), between="smooth")
        ),
        at, wanted.pressure(nodes), last.P, rtol,
    )  # fmt: skip


def _checked(problem: RollProblem, pressure: float | Profile) -> Profile:
    """Return what is wanted as a profile from the core to the surface."""
    core, R, limit = problem.core.radius, problem.radius, problem.stack.limit
    if not isinstance(pressure, Profile):
        check_type("pressure", pressure, float, int, Profile)
        if not 0 < pressure < limit:
            top = f" and < {limit:.6g}" if np.isfinite(limit) else ""
            text = f"{quote(pressure)} is out of range; must be > 0{top} [Pa]"
            raise InvalidProblem.at("pressure", text)
        pressure = Profile(radius=[core, R], value=[pressure, pressure])
    for k, edge, name in ((0, core, "core.radius"), (-1, R, "radius")):
        r = pressure.radius[k]
        if abs(r - edge) > 1e-9 * edge:
            raise InvalidProblem.at(
                f"pressure.radius.{k % len(pressure.radius)}",
                f"{quote(r)} is out of range; must be {name} = {edge:.6g} [m]",
            )
    for k, P in enumerate(pressure.value):
        if not 0 <= P < limit or (P == 0 and k + 1 < len(pressure.value)):
            top = f" and < {limit:.6g}" if np.isfinite(limit) else ""
            raise InvalidProblem.at(
                f"pressure.value.{k}",
                f"{quote(P)} is out of range; must be > 0{top} [Pa], or 0 at the surface",
            )
    return pressure


class _Wanted:
    """A wanted pressure as a smooth curve over x = ln r, and its source."""

    def __init__(self, problem: RollProblem, pressure: Profile) -> None:
        from scipy.interpolate import BPoly, CubicSpline, PchipInterpolator

        x, P = np.log(pressure.radius), np.array(pressure.value)
        x[0], x[-1] = np.log([problem.core.radius, problem.radius])
        # monotone cubics, their bends made one at each value: C does not jump, T has no kinks
        cubics = PchipInterpolator(x, P)
        bend = cubics.derivative(2)
        behind, before = bend(np.append(x[0], x[1:] - NUDGE)), bend(np.append(x[:-1], x[-1]))
        less = np.where(np.abs(behind) < np.abs(before), behind, before)
        one = np.where(behind * before > 0, less, 0.0)
        ends = np.stack([P, cubics.derivative()(x), one], axis=1)
        smooth = pressure.between == "smooth"
        self._curve = CubicSpline(x, P) if smooth else BPoly.from_derivatives(x, ends)
        self._slope, self._bend = self._curve.derivative(), self._curve.derivative(2)
        self.knots, self.problem, self.strain = x, problem, problem.stack.radial.strain_at
        dense = np.concatenate([np.linspace(a, b, 9)[:-1] for a, b in pairwise(x)])
        k = int(np.argmin(self.pressure(dense)))
        if self.pressure(dense)[k] <= 0:
            raise InvalidProblem.at(
                "pressure", f"is < 0 at the radius {np.exp(dense[k]):.6g} m, between its values; "
                "must be > 0: give more values there"
            )  # fmt: skip

    def pressure(self, x: Array) -> Array:
        """P [Pa]."""
        return np.asarray(self._curve(x))

    def slope(self, x: Array) -> Array:
        """R P' [Pa]."""
        return np.asarray(self._slope(x))

    def source(self, x: Array, _: Array) -> Array:
        """C = D^2 P + 2 D P + P - E_t F(P) [Pa]."""
        P, E_t = self.pressure(x), self.problem.stack.tangential
        return np.asarray(self._bend(x) + 2 * self.slope(x) + P - E_t * self.strain(P))


class _Stages:
    """The stages of a roll that has a wanted source, solved where they are asked for."""

    def __init__(self, equations: StageEquations, wanted: _Wanted) -> None:
        self.equations, self.wanted = equations, wanted
        core = wanted.knots[:1]
        self.T_c = float((equations.core * wanted.pressure(core) - wanted.slope(core))[0])
        self.solved: dict[float, tuple[Array, Solved]] = {}
        law, E_t = wanted.problem.stack.radial, wanted.problem.stack.tangential
        E = float(law.modulus(0.0))
        # as :func:`.finished.layer_thickness`, with a tension that makes such a pressure
        P = float(np.max(wanted.pressure(wanted.knots)))
        T = np.sqrt(2 * E_t * float(law.strain_at(P)) * P)
        self.layer = min(law.pressure_at_modulus(2 * E) / T, (E / E_t) ** 0.5, 0.3)

    def tension(self, x: float) -> float:
        """Return T [Pa] with which the lap at ln r = x is laid."""
        start = self.wanted.knots[0]
        T = self.T_c if x <= start else -float(self._stage(x).Q[-1])
        if T > 0:
            return T
        r, h = np.exp(x), self.wanted.problem.web_thickness
        raise InvalidProblem.at(
            "pressure",
            f"needs a tension of {T * h:.4g} [N/m] at the radius {r:.6g} m; must be one that a "
            "tension > 0 makes: more pressure there, or less below",
        )

    def _stage(self, x: float) -> Solved:
        if x not in self.solved:
            knots = self.wanted.knots
            more = knots[1:-1] if knots.size < CELLS else None
            nodes = nodes_between(knots[0], x, CELLS, self.layer, more)
            guess = self._guess(x, nodes)
            source = in_cells(nodes, self.wanted.source)
            solved = self.equations.solve(nodes, source, self.T_c, *guess)
            if solved is None:
                raise NotConverged(f"no stage at the radius {np.exp(x):.6g} m has this pressure")
            self.solved[x] = nodes, solved
        return self.solved[x][1]

    def _guess(self, x: float, nodes: Array) -> tuple[Array, Array]:
        """Return the nearest stage, its surface moved to x."""
        if not self.solved:
            T = self.T_c
            return T * (x - nodes), np.full_like(nodes, -T)
        near = min(self.solved, key=lambda at: abs(at - x))
        behind, solved = self.solved[near]
        share = (nodes - nodes[0]) / (x - nodes[0])
        moved = nodes - (x - near) * share
        return pressure_between(behind, solved.P, solved.Q, moved)


def _refined(stages: _Stages, rtol: float) -> Array:
    """Return ln r at which the tension is given: so many that a smooth curve between is near it."""
    from scipy.interpolate import CubicSpline

    knots = stages.wanted.knots
    start, end = float(knots[0]), float(knots[-1])
    x = np.union1d(nodes_between(start, end, FIRST, stages.layer), knots)
    x = x[np.append(np.diff(x) > 1e-9, True)]
    x[0] = start
    T = np.array([stages.tension(s) for s in x.tolist()])
    bad = np.ones(x.size - 1, dtype=bool)
    while bad.any() and x.size < MOST:
        curve, middle = CubicSpline(np.exp(x), T), (x[:-1][bad] + x[1:][bad]) / 2
        more = np.array([stages.tension(s) for s in middle.tolist()])
        off = np.abs(curve(np.exp(middle)) - more) > ROOM * rtol * more
        # both halves of a cell that was off are looked at again
        x, order = np.unique(np.concatenate([x, middle]), return_index=True)
        T = np.concatenate([T, more])[order]
        again = middle[off]
        bad = np.isin(x[:-1], again) | np.isin(x[1:], again)
    return x
