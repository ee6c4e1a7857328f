"""The inverse problem: the wound-on tension that gives a target pressure.

In the limit of thin layers a target P(r) has the source C = r^2 P'' + 3 r P' + P - E_t F(P), the
same at every stage of the build-up.  Each stage is therefore independent of the previous ones: with
the surface at s, the pressure solves the equations of :mod:`.equations` with this C and P(s) = 0,
and its slope there is the tension, T(s) = -r P'.  At the core, T = b P - r P' by the core
condition.  No optimiser is needed.

The pressure p = T h/2r under which layers of the thickness h are wound (:class:`.Layers`) depends
on the tension.  It is that by the tension of the limit of thin layers, then that by the tension
found with it, and so on: as p changes the tension by the part h/r or so, few repetitions suffice.
With L = (D + 1)^2, D = d/d ln r, and r p = T h/2

    C = L P - L p - E_t (F(P) - F(p)),    L p = h D^2 T/2r.

The second derivative of T is a central difference over SPAN layers on either side: shorter changes
of the tension, such as those on the core, have no meaning in these equations.

The pressure at the surface is zero, whatever the target is.  In an outer layer, in which the
pressure rises, the pressure differs from the target; the result has the depth of this layer and the
largest difference.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Annotated

import numpy as np

from ..arguments import check_type, tolerance
from ..errors import InvalidProblem, NotConverged
from ..parallel import one_thread
from ..problems.description import Description
from ..problems.messages import quote
from ..problems.permitted import is_within
from ..problems.roll import RollProblem
from ..problems.schedules import Profile, Schedule
from ..quantities import stress
from .build_up import Layers
from .equations import StageData, StageSolution, initial_guess
from .finished import layers_of, surface_layer_of_stack
from .stage_nodes import evaluate_in_cells, nodes_between, radii_of_nodes

__all__ = ["TensionDesign", "design_tension"]

Array = np.ndarray

CELLS = 160  # of each stage
FIRST_RADII = 40  # radii of the tension before refinement
MAX_RADII = 4000
ONE_SIDED = 1e-12  # of ln r
INTERPOLATION_SHARE = 0.5  # of rtol: accepted interpolation error of the tension between radii
REPETITION_SHARE = 0.5  # of rtol: accepted change of the tension by the last repetition
SPAN = 4  # layers on either side, for the second derivative of the tension
MOST_REPETITIONS = 12


@dataclass(frozen=True, eq=False)
class TensionDesign:
    """The wound-on tension for a target pressure, and the pressure reached.

    Attributes
    ----------
    problem : RollProblem
        The roll with this tension as its ``wound_on_tension``.
    radius : (M,) array
        [m].
    target_pressure, pressure : (M,) arrays
        The target, and the pressure of the finished roll, lower in the outer layer [Pa].
    rtol : float
        Tolerance of the design.

    Examples
    --------
    >>> import woundon as wo
    >>> design = wo.design_tension(wo.RollProblem.example(), "100 kPa")
    >>> middle = design.radius.size // 2
    >>> bool(abs(design.pressure[middle] / 100e3 - 1) < design.rtol)
    True
    """

    problem: RollProblem
    radius: Array
    target_pressure: Array
    pressure: Array
    rtol: float

    @property
    def tension(self) -> Profile:
        """Wound-on tension over the radius [N/m]."""
        tension = self.problem.wound_on_tension
        assert isinstance(tension, Profile)
        return tension

    @property
    def outer_layer(self) -> float:
        """Depth of the outer layer in which the error of the pressure exceeds ``rtol`` [m]."""
        deviation = np.abs(self.pressure - self.target_pressure)
        reached = np.flatnonzero(deviation <= self.rtol * np.max(self.target_pressure))
        begin = self.radius[reached[-1] if reached.size else 0]
        return float(self.radius[-1] - begin)

    @property
    def surface_deviation(self) -> float:
        """Largest deviation from the target, at the surface if there is an outer layer [Pa]."""
        return float(np.max(np.abs(self.pressure - self.target_pressure)))


@one_thread
def design_tension(
    problem: RollProblem, pressure: float | str | Profile, *, rtol: float = 1e-4
) -> TensionDesign:
    """Compute the wound-on tension over the radius that gives a target pressure in the roll.

    Parameters
    ----------
    problem : RollProblem
        The roll; its tension is ignored.
    pressure : float, str or Profile
        Target pressure between the layers [Pa], or a text with a unit, "200 kPa", from the core to
        the surface, > 0.  A pressure has no kinks: the values of a profile are interpolated over
        ln r by a cubic spline if it is ``smooth``, otherwise by a monotone curve.
    rtol : float
        Accepted error of the pressure below the outer layer, relative to the largest; 1e-6
        to 0.01.  On the core, where the tension changes from layer to layer, it is up to 1e-3.

    Returns
    -------
    TensionDesign
        Its ``problem`` is ready to be solved.

    Raises
    ------
    InvalidProblem
        For a pressure that is out of range, that does not reach from core to surface, or that no
        tension > 0 gives.
    NotConverged
        If a stage cannot be solved.

    Examples
    --------
    >>> import woundon as wo
    >>> design = wo.design_tension(wo.RollProblem.example(), "100 kPa")
    >>> bool(min(design.tension.value) > 0)
    True
    """
    check_type("problem", problem, RollProblem)
    tolerance("rtol", rtol, 1e-6, 1e-2)
    if problem.is_changed:
        raise InvalidProblem.at(
            "problem",
            "changes after winding; must be a roll as wound: temperature_change, "
            "moisture_change and core_shrinkage 0, core_removed false",
        )
    target = _TargetPressure(problem, _as_profile(problem, _Target(pressure=pressure).pressure))
    layers, last = layers_of(problem).thin, np.inf
    stages = _TargetStages(layers, target)
    for _ in range(MOST_REPETITIONS):
        x = _refined_radii(stages, rtol)
        T = np.array([stages.tension(s) for s in x])
        smooth = _SmoothTension(x, T)
        if isinstance(layers.tension, _SmoothTension):
            last = layers.tension.difference(smooth)
        if last <= REPETITION_SHARE * rtol:
            break
        layers = replace(layers_of(problem), tension=smooth)
        stages = _TargetStages(layers, target, stages.solved)
    else:
        raise NotConverged(
            f"after {MOST_REPETITIONS} repetitions the tension still changes by {last:.2g} of it, "
            f"more than rtol = {rtol:g} permits: it depends too much on the layer thickness; raise "
            "rtol, or take thinner layers"
        )
    ends = problem.core.radius, problem.radius
    r, WOT = radii_of_nodes(x, *ends), T * problem.web_thickness
    schedule = Profile(radius=r.tolist(), value=WOT.tolist(), between="smooth")
    design = problem.replace(wound_on_tension=schedule)
    nodes, P = stages.finished_pressure(layers_of(design))
    return TensionDesign(design, radii_of_nodes(nodes, *ends), target.pressure(nodes), P, rtol)


class _SmoothTension:
    """A cubic spline of the wound-on stress over ln r [Pa]; see :class:`.Tension`.

    Parameters
    ----------
    x, T : (k,) arrays
        ln r from core to surface, and the stress there [Pa].
    """

    def __init__(self, x: Array, T: Array) -> None:
        from scipy.interpolate import CubicSpline

        self.x, self.T = x, T
        self.spline = CubicSpline(x, T)
        self.kinks = self.bends = np.zeros(0)

    def at(self, r: Array) -> Array:
        """Return T at radii [Pa]."""
        return np.asarray(self.spline(np.log(r)))

    def slope(self, r: Array, side: int | Array) -> Array:
        """Return dT/dr [Pa/m]; a spline has no kinks, whose side is the second argument."""
        return np.asarray(self.spline(np.log(r), 1) / r)

    def second(self, x: Array, step: Array) -> Array:
        """Return the second difference by ln r over steps (k,) of it, (k,) [Pa].

        Within a step of core and surface it is that at this step from them.
        """
        x = np.clip(x, self.x[0] + step, self.x[-1] - step)
        T = self.spline
        return np.asarray((T(x + step) - 2 * T(x) + T(x - step)) / step**2)

    def difference(self, other: _SmoothTension) -> float:
        """Return the largest relative difference from another tension, at its points [1]."""
        return float(np.max(np.abs(self.spline(other.x) / other.T - 1)))


class _Target(Description):
    """Target pressure, read like a field of a problem: with units, as a number or a profile."""

    pressure: Annotated[Schedule, stress("P", "target pressure")]


def _as_profile(problem: RollProblem, pressure: float | Profile) -> Profile:
    """Return the target pressure as a profile from the core to the surface."""
    core, R, limit = problem.core.radius, problem.radius, problem.stack.limit
    must = f"must be > 0{f' and < {limit:.6g}' if np.isfinite(limit) else ''} [Pa]"
    if not isinstance(pressure, Profile):
        if not 0 < pressure < limit:
            raise InvalidProblem.at("pressure", f"{quote(pressure)} is out of range; {must}")
        pressure = Profile(radius=[core, R], value=[pressure, pressure])
    for k, edge, name in ((0, core, "core.radius"), (-1, R, "radius")):
        r = pressure.radius[k]
        if not is_within(r, edge, edge):
            raise InvalidProblem.at(
                f"pressure.radius.{k % len(pressure.radius)}",  # counted from 0, not -1
                f"{quote(r)} is out of range; must be {name} = {edge:.6g} [m]",
            )
    for k, P in enumerate(pressure.value):
        # zero is permitted at the last value, the surface
        if not 0 <= P < limit or (P == 0 and k + 1 < len(pressure.value)):
            text = f"{quote(P)} is out of range; {must}, or 0 at the surface"
            raise InvalidProblem.at(f"pressure.value.{k}", text)
    return pressure


class _TargetPressure:
    """A target pressure as a smooth curve over x = ln r, and its source."""

    def __init__(self, problem: RollProblem, pressure: Profile) -> None:
        from scipy.interpolate import BPoly, CubicSpline, PchipInterpolator

        x, P = np.log(pressure.radius), np.array(pressure.value)
        x[0], x[-1] = np.log([problem.core.radius, problem.radius])
        # Monotone cubics, made quintics with one second derivative at each value: the smaller
        # one of both sides, or 0 if they differ in sign.  Then C does not jump, and T has no kinks.
        cubics = PchipInterpolator(x, P)
        second = cubics.derivative(2)
        inner, outer = second(np.append(x[0], x[1:] - ONE_SIDED)), second(np.append(x[:-1], x[-1]))
        smaller = np.where(np.abs(inner) < np.abs(outer), inner, outer)
        common = np.where(inner * outer > 0, smaller, 0.0)
        ends = np.stack([P, cubics.derivative()(x), common], axis=1)
        smooth = pressure.between == "smooth"
        self._curve = CubicSpline(x, P) if smooth else BPoly.from_derivatives(x, ends)
        self._slope, self._curvature = self._curve.derivative(), self._curve.derivative(2)
        self.knots, self.problem, self.strain = x, problem, problem.stack.radial.strain_at
        # the pressure may be negative between the values
        dense = np.concatenate([np.linspace(a, b, 9)[:-1] for a, b in pairwise(x)])
        k = int(np.argmin(self.pressure(dense)))
        if self.pressure(dense)[k] <= 0:
            raise InvalidProblem.at(
                "pressure",
                f"is < 0 at the radius {np.exp(dense[k]):.6g} m, between its values; "
                "must be > 0: give more values there",
            )

    def pressure(self, x: Array) -> Array:
        """Return P at x = ln r [Pa]."""
        return np.asarray(self._curve(x))

    def slope(self, x: Array) -> Array:
        """Return r P' at x = ln r [Pa]."""
        return np.asarray(self._slope(x))

    def source_of_thin_layers(self, x: Array) -> Array:
        """Return D^2 P + 2 D P + P - E_t F(P) at x = ln r, D = d/dx [Pa]."""
        P, E_t = self.pressure(x), self.problem.stack.tangential
        return np.asarray(self._curvature(x) + 2 * self.slope(x) + P - E_t * self.strain(P))


class _TargetStages:
    """The stages of a roll with the source of a target pressure, solved on demand.

    Attributes
    ----------
    T_c : float
        T of the core condition, b P - r P' [Pa].
    surface_layer : float
        Depth of the layer below the surface in which the pressure rises, in ln r.
    solved : dict
        Nodes and solution of each solved stage by ln r of its surface.
    """

    def __init__(
        self,
        layers: Layers,
        target: _TargetPressure,
        known: Mapping[float, tuple[Array, StageSolution]] | None = None,
    ) -> None:
        self.layers, self.equations, self.target = layers, layers.equations, target
        self.known = known or {}  # stages with another tension, the initial guesses of these
        core = target.knots[:1]
        on_core, slope = target.pressure(core), target.slope(core)
        if layers.thickness:
            on_core = on_core - layers.own_pressure(core)
            slope = slope - layers.own_slope(core, 1)
        self.T_c = float((self.equations.core * on_core - slope)[0])
        self.solved: dict[float, tuple[Array, StageSolution]] = {}
        # for a pressure P the tension T is bounded by T^2/(2 E_t) = W(P) <= F(P) P, W the energy of
        # compression
        stack, P = target.problem.stack, float(np.max(target.pressure(target.knots)))
        T = (2 * stack.tangential * float(stack.radial.strain_at(P)) * P) ** 0.5
        self.surface_layer = surface_layer_of_stack(stack, T)

    def tension(self, x: float) -> float:
        """Return the wound-on stress T of the layer at ln r = x [Pa]."""
        start = self.target.knots[0]
        c = self.equations.centrifugal
        T = self.T_c if x <= start else c - float(self._solve_stage(x).Q[-1])
        if c < T:
            return T
        r, h = np.exp(x), self.target.problem.web_thickness
        least = f"{c * h:.4g}, the centrifugal force" if c else "0"
        raise InvalidProblem.at(
            "pressure",
            f"needs a tension of {T * h:.4g} [N/m] at the radius {r:.6g} m; must be > {least}; "
            "raise the pressure there, or lower it at smaller radii",
        )

    def source(self, x: Array, _: Array) -> Array:
        """Return C at x = ln r [Pa]; it has no kinks, whose side is the second argument."""
        C, layers = self.target.source_of_thin_layers(x), self.layers
        if not layers.thickness:
            return C
        assert isinstance(layers.tension, _SmoothTension)
        F = self.equations.strain(layers.own_pressure(x))
        h = layers.thickness / np.exp(x)  # in ln r
        by_tension = h / 2 * layers.tension.second(x, SPAN * h)
        return np.asarray(C + self.equations.tangential * F - by_tension)

    def finished_pressure(self, layers: Layers) -> tuple[Array, Array]:
        """Return ln r of nodes, and the pressure of the finished roll of these layers there [Pa].

        They are wound with the tension of the stages, whose source the roll has.
        """
        x = max(self.solved)
        nodes, wound = self.solved[x]
        own = layers.own_pressure(nodes)
        stage = replace(self._stage(nodes), surface_pressure=-own[-1], own=layers.own(nodes))
        solved = layers.equations.at_rest.solve(stage, wound.P, wound.Q)
        if solved is None:
            raise NotConverged("the finished roll has no equilibrium at rest")
        return nodes, np.asarray(solved.P + own)

    def _stage(self, nodes: Array) -> StageData:
        """Return the equations of a stage with the nodes ln r."""
        source = evaluate_in_cells(nodes, self.source)
        return StageData(nodes, source, self.T_c, own=self.layers.own(nodes))

    def _solve_stage(self, x: float) -> StageSolution:
        """Return the solved stage with the surface at ln r = x."""
        if x not in self.solved:
            knots = self.target.knots
            # inner values of the target are nodes too, unless they are as dense as nodes
            kinks = knots[1:-1] if knots.size < CELLS else None
            nodes = nodes_between(knots[0], x, CELLS, self.surface_layer, kinks)
            guess = self._guess(x, nodes)
            solved = self.equations.solve(self._stage(nodes), *guess)
            if solved is None:
                raise NotConverged(f"no stage at the radius {np.exp(x):.6g} m has this pressure")
            self.solved[x] = nodes, solved
        return self.solved[x][1]

    def _guess(self, x: float, nodes: Array) -> tuple[Array, Array]:
        """Return the initial guess: the known stage, or the nearest one, its surface moved to x."""
        if x in self.known:
            return self.known[x][1].P, self.known[x][1].Q
        if not self.solved:
            return initial_guess(nodes, self.T_c, None)
        other_nodes, solved = self.solved[min(self.solved, key=lambda surface: abs(surface - x))]
        return initial_guess(nodes, self.T_c, (other_nodes, solved.P, solved.Q))


def _refined_radii(stages: _TargetStages, rtol: float) -> Array:
    """Return ln r of the tension profile, refined until its interpolation error is accepted.

    The tension is computed in the middle of cells and compared with a cubic spline through the
    others.

    Parameters
    ----------
    stages : _TargetStages
        Gives the tension at any surface radius.
    rtol : float
        Tolerance of the design, of which INTERPOLATION_SHARE is accepted here.
    """
    from scipy.interpolate import CubicSpline

    knots = stages.target.knots
    start, end = float(knots[0]), float(knots[-1])
    x = np.union1d(nodes_between(start, end, FIRST_RADII, stages.surface_layer), knots)
    x = x[np.append(np.diff(x) > 1e-9, True)]  # a node close to a knot is left out
    x[0] = start
    T = np.array([stages.tension(s) for s in x.tolist()])
    to_check = np.ones(x.size - 1, dtype=bool)  # cells between neighbouring radii
    while to_check.any() and x.size < MAX_RADII:
        curve, middle = CubicSpline(np.exp(x), T), (x[:-1][to_check] + x[1:][to_check]) / 2
        T_middle = np.array([stages.tension(s) for s in middle.tolist()])
        exceeds = np.abs(curve(np.exp(middle)) - T_middle) > INTERPOLATION_SHARE * rtol * T_middle
        # both halves of a cell with too large an error are checked again
        x, order = np.unique(np.concatenate([x, middle]), return_index=True)
        T = np.concatenate([T, T_middle])[order]
        rejected = middle[exceeds]
        to_check = np.isin(x[:-1], rejected) | np.isin(x[1:], rejected)
    return x
