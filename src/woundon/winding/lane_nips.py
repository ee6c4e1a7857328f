r"""The lanes of a winding: the nip load shared between them, and the tension that the nip adds.

A ridge is pressed harder by a straight drum.  At a few radii the nip is solved under further loads,
which gives the load-approach curve P(delta) and the added tension A(P) at that radius.  Relative to
the load N of the winding, with f = P/N,

    ln(delta/delta_N) and (A - A_N)/(mu+ N)    are functions of ln f and f

that vary little over the radius and are interpolated in ln(r - r_c).  Monotone cubics pass through
the samples; beyond them P is a power of delta, and A is linear.  Without load A = 0.  The winding
force is shared like the load.

A tension law without solved nips has no load-approach curve, and on a two-drum winder several nips
share the load: the nips then add the same tension to all lanes, and their load is not shared.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import numpy as np
from scipy.interpolate import PchipInterpolator

from ..errors import unwarned
from ..nip.result import NipResult
from ..nip.solve import solve_nip
from ..problems.bodies import Body
from ..problems.thickness_profile import Lanes
from ..roll.lane_roll import LaneRoll
from ..roll.lane_tension import TensionOfLanes, tension_in_nip, tension_of_web
from ..roll.lanes import TensionAt
from ..roll.result import RollResult
from ..roll.solve import lanes_of
from ..roll.stages import stages_at
from .bodies import NipSample, solved_nip, tension_on_roll
from .nips import PRESSURE_TOLERANCE
from .roll import wind

__all__ = ["NipAtRadius", "lanes_of_winding"]

Array = np.ndarray

RADII = 5  # at which the nip is solved under other loads, of those of the winding
# Loads relative to that of the winding.  Half and double enclose the loads of usual ridges.
LOADS = (0.5, 1.0, 2.0)


class _Curve:
    """A monotone cubic through samples, continued by straight lines.

    Parameters
    ----------
    x, y : (k,) arrays
        The samples, x rising.
    """

    def __init__(self, x: Array, y: Array) -> None:
        self.first, self.last = float(x[0]), float(x[-1])
        self.value = PchipInterpolator(x, y)
        self.slope = self.value.derivative()

    def at(self, x: Array) -> tuple[Array, Array]:
        """Return the values and the slopes at any x."""
        inside = np.clip(x, self.first, self.last)
        slope = self.slope(inside)
        return self.value(inside) + slope * (x - inside), slope


@dataclass(frozen=True)
class NipAtRadius:
    """A nip at one radius as a function of its load; see :class:`.lane_tension.NipAcross`.

    Parameters
    ----------
    load : float
        N of the winding [N/m].
    approach : float
        delta under this load [m].
    log_approach : (3,) array
        ln(delta/delta_N) at the loads LOADS.
    added_at_load : float
        A under this load [N/m].
    added_change : (3,) array
        (A - A_N)/(mu+ N) at the loads LOADS.
    friction_force : float
        mu+ N [N/m].
    """

    load: float
    approach: float
    log_approach: Array
    added_at_load: float
    added_change: Array
    friction_force: float

    @cached_property
    def _log_load(self) -> _Curve:
        """ln(P/N) over ln(delta/delta_N); a straight line is a power of delta."""
        return _Curve(self.log_approach, np.log(LOADS))

    @cached_property
    def _added_change(self) -> _Curve:
        """(A - A_N)/(mu+ N) over P/N; A = 0 without load."""
        without_load = -self.added_at_load / self.friction_force
        return _Curve(np.array([0.0, *LOADS]), np.array([without_load, *self.added_change]))

    def load_at(self, approach: Array) -> tuple[Array, Array]:
        """Return P [N/m] and dP/d delta [N/m^2] at approaches [m]; zero at negative ones."""
        touches = approach > 0
        delta = np.where(touches, approach, self.approach)  # any positive one without contact
        log_load, exponent = self._log_load.at(np.log(delta / self.approach))
        load = self.load * np.exp(log_load)
        # d ln P/d ln delta is the exponent
        return np.where(touches, load, 0.0), np.where(touches, load * exponent / delta, 0.0)

    def added(self, load: Array) -> tuple[Array, Array]:
        """Return A(P) [N/m] and dA/dP [1] at loads [N/m]."""
        change, slope = self._added_change.at(load / self.load)
        ratio = self.friction_force / self.load
        return self.added_at_load + self.friction_force * change, ratio * slope


class _Nips:
    """The nips of a winding across the width; see :class:`.lane_roll.NipsAcross`.

    Parameters
    ----------
    result : WindingResult
    roll : RollResult
        Its roll.
    """

    def __init__(self, result: Any, roll: RollResult) -> None:
        self.result, self.problem, self.roll = result, result.problem, roll
        self.core = float(self.problem.core.radius)
        solves_nip = self.problem.solves_nips and self.problem.winder is None
        self.samples = self._samples() if solves_nip else None

    def web_tension(self, r: Array) -> Array:
        """Return T_in at radii [N/m]."""
        return np.interp(r, self.result.radius, self.result.web_tension)

    def nip_load(self, r: Array) -> Array:
        """Return N at radii [N/m]; nan without solved nips."""
        load = np.interp(r, self.result.radius, self.result.nip_load)
        return load if self.samples is not None else np.full_like(load, np.nan)

    def tension_at(self, lanes: Lanes) -> TensionAt:
        """Return the function that gives the tension of lanes."""
        E_t = float(self.roll.problem.stack.tangential)
        h = float(self.roll.problem.web_thickness)

        def tension(x: float, c: Array, mu: Array, guess: Array) -> TensionOfLanes | None:
            r = np.array([np.exp(x)])
            wound_on = h * float(self.roll.problem.tension_curve.at(r)[0])
            web, strain = float(self.web_tension(r)[0]), wound_on / (h * E_t)
            if self.samples is None:
                return tension_of_web(lanes, c, mu, strain, 1 - web / wound_on)
            nip = self._nip(float(r[0]), wound_on - web)
            return tension_in_nip(lanes, c, mu, strain, nip, float(r[0]), wound_on, web, guess)

        return tension

    def _nip(self, radius: float, added: float) -> NipAtRadius:
        """Return the nip at a radius [m] with its added tension [N/m]."""
        assert self.samples is not None
        radii, rows = self.samples
        places = np.log(radii - self.core)
        x = np.clip(np.log(max(radius - self.core, 1e-12)), places[0], places[-1])
        values = np.array([np.interp(x, places, column) for column in rows.T])
        load = float(self.nip_load(np.array([radius]))[0])
        return NipAtRadius(
            load=load,
            approach=float(np.exp(values[0]) * load),
            log_approach=values[1:4],
            added_at_load=added,
            added_change=values[4:7],
            friction_force=float(values[7]) * load,
        )

    def _samples(self) -> tuple[Array, Array]:
        """Return radii (K,) [m], and ln(delta/N), ln(delta/delta_N), (A - A_N)/(mu N), mu there."""
        radii = self.result.nip_radius
        chosen = np.unique(np.round(np.linspace(0, radii.size - 1, RADII)).astype(int))
        friction = self.result.nip_friction
        rows = [self._row(float(radii[k]), float(friction[k])) for k in chosen]
        return radii[chosen], np.array(rows)

    def _row(self, radius: float, friction: float) -> Array:
        """Return the values of :meth:`_samples` at one radius; the nip is solved under all loads.

        ``friction`` is mu+ with the entrained air.
        """
        problem = self.problem
        load = float(problem.at("nip_load", radius))
        stage = None if problem.roll_body == "linear" else stages_at(self.roll, [radius])[0]
        sample: NipSample | None = None
        outputs = []
        with_air = problem.replace(stack=self.roll.problem.stack)
        for fraction in LOADS:
            solve = partial(self._solve, radius, friction, fraction)
            sample = solved_nip(with_air, radius, stage, None, sample, solve, PRESSURE_TOLERANCE)
            nip = sample.result
            outputs.append((nip.approach, tension_on_roll(nip) - nip.problem.web_tension))
        delta, added = np.array(outputs).T
        middle = LOADS.index(1.0)
        log_approach = np.log(delta / delta[middle])
        change = (added - added[middle]) / (friction * load)
        return np.array([np.log(delta[middle] / load), *log_approach, *change, friction])

    def _solve(
        self, radius: float, friction: float, fraction: float, body: Body, start: NipResult | None
    ) -> NipResult:
        """Solve the nip under a fraction of its load, with the friction that the air leaves."""
        nip = self.problem.nip(radius, body)
        if nip.air is not None:
            ratio = friction / nip.roll_friction
            wrap = nip.wrap_friction
            nip = nip.without_air(friction, None if wrap is None else wrap * ratio)
        nip = nip.replace(
            nip_load=fraction * nip.nip_load, winding_force=fraction * nip.winding_force
        )
        with unwarned():
            return solve_nip(nip, nodes=self.result.nodes, start=start, errors=start is None)


def lanes_of_winding(result: Any, rtol: float, count: int) -> LaneRoll:
    """Solve for the lanes of a winding.

    The effect of the thickness of the layers is part of the error estimates.

    Parameters
    ----------
    result : WindingResult
        The winding of the mean web, whose problem has a thickness profile.
    rtol : float
        Accepted error of the pressure, relative to the largest.
    count : int
        Number of lanes.
    """
    roll = wind(result.problem, result.radius, result.wound_on_tension, rtol, result.air_film)
    lanes = lanes_of(roll, result.problem, rtol, count, _Nips(result, roll.result))
    return lanes.with_finite_layers(abs(result.roll.finite_layer_effect))
