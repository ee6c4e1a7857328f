r"""The roll that a nip feels while it is wound: three answers to one question.

    linear      a cylinder of the web's own moduli; the stack takes no part in the nip
    effective   a linear cylinder of the stack at one pressure,
                    P_e = (mean of the wound pressure down to a below the surface) + 0.25 p_max
    direct      the stack under the pressure wound so far, hardening under the nip

The wound pressure grows from nothing at the surface, in newsprint to half its plateau a half-width
below it, where a line contact presses most: hence the mean.  0.25 p_max is what the direct solution
of confined nips wants in soft stacks (docs: stacks); nothing is fitted here.  P_e and the nip that
has it are found together, by a secant.
"""

from __future__ import annotations

from collections.abc import Callable
from math import nan
from typing import NamedTuple

import numpy as np

from ..errors import NotConverged
from ..problems.bodies import Body, Cylinder
from ..problems.materials import Material, Orthotropic
from ..problems.schedules import Profile
from ..problems.winding import WindingProblem
from ..problems.wound_roll import WoundRoll
from ..roll.result import WoundRollResult
from ..wrap.result import WrappedNipResult

__all__ = ["Felt", "effective_cylinder", "felt_pressure", "hardening_roll", "solved_nip"]

Array = np.ndarray
Solve = Callable[[Body, WrappedNipResult | None], WrappedNipResult]

SHARE = 0.25  # of p_max
DEPTHS = 33  # at which the wound pressure is averaged
MOST = 25  # nips until P_e is found
STEEP = 0.3  # first guess of dP_e(found)/dP_e(given)
TOLD = 2e-3  # of P_e, a step from which slopes are taken: less would tell the grid's noise
ALMOST = 0.9  # of the pressure at which a stack's law ends


class Felt(NamedTuple):
    """A nip on a roll wound so far.

    Attributes
    ----------
    result : WrappedNipResult
    pressure : float
        P_e of its roll [Pa]; nan where the roll has no single one.
    wanted : float
        P_e that wound pressure and nip ask for [Pa].
    steep : float
        How much of a change of P_e comes back.
    slope : float
        Change of the wound-on tension by that of P_e [m].
    """

    result: WrappedNipResult
    pressure: float = nan
    wanted: float = nan
    steep: float = STEEP
    slope: float = 0.0

    @property
    def radius(self) -> float:
        """Of the roll that it runs on [m]."""
        return float(self.result.problem.roll.radius)

    @property
    def tension(self) -> float:
        """The wound-on tension, as it would be at the pressure wanted [N/m]."""
        found = self.result.wound_on_tension
        return found + self.slope * (self.wanted - self.pressure) if self.slope else found


def solved_nip(
    problem: WindingProblem, stage: WoundRollResult, before: Felt | None, solve: Solve,
    agreed: float,
) -> Felt:  # fmt: skip
    """Return the nip on a roll wound so far.

    Parameters
    ----------
    problem : WindingProblem
    stage : WoundRollResult
        The roll that the nip runs on.
    before : Felt, optional
        The same nip on nearly the same roll, or a neighbour.
    solve : callable
        (roll, neighbouring result or None) -> result.
    agreed : float
        To what P_e is to be found, relative.
    """
    radius, start = float(stage.radius[-1]), before.result if before else None
    if problem.roll_body == "linear":
        return Felt(solve(_linear_cylinder(problem, radius), start))
    if problem.roll_body == "direct":
        return Felt(solve(hardening_roll(problem, stage), start))
    return _effective(problem, stage, before, solve, agreed)


def _effective(
    problem: WindingProblem, stage: WoundRollResult, before: Felt | None, solve: Solve,
    agreed: float,
) -> Felt:  # fmt: skip
    radius, most = float(stage.radius[-1]), ALMOST * problem.stack.limit
    steep, slope = (before.steep, before.slope) if before else (STEEP, 0.0)
    P = before.wanted if before else min(_first_guess(problem, stage), most)
    last: tuple[float, float, float] | None = None
    result = before.result if before else None
    for _ in range(MOST):
        result = solve(effective_cylinder(problem, radius, P), result)
        found = min(felt_pressure(stage, result), most)
        if last is not None and abs(P - last[0]) > TOLD * P:
            steep = float(np.clip((found - last[1]) / (P - last[0]), -2.0, 0.8))
            slope = (result.wound_on_tension - last[2]) / (P - last[0])
        wanted = max(P + (found - P) / (1 - steep), 0.2 * P)
        if abs(found - P) <= agreed * P:
            return Felt(result, P, wanted, steep, slope)
        last, P = (P, found, result.wound_on_tension), wanted
    raise NotConverged(f"the pressure that the roll feels is not found within {MOST} nips", result)


def _first_guess(problem: WindingProblem, stage: WoundRollResult) -> float:
    """Return P_e to begin with: of a contact as wide as it would be on a stack at 100 kPa."""
    P = float(problem.at("nip_load", stage.radius[-1]))
    return 1e5 + SHARE * P / 2e-3


def felt_pressure(stage: WoundRollResult, result: WrappedNipResult) -> float:
    """Return P_e that a roll and a nip on it ask for, whose tension the last laps take [Pa]."""
    surface, core = float(stage.radius[-1]), float(stage.radius[0])
    r = np.linspace(max(core, surface - result.half_width), surface, DEPTHS)
    wound = np.trapezoid(stage.at_radius(r)["pressure"], r) / (r[-1] - r[0])
    # what it would be if the last laps had been wound with what this nip gives: near the surface
    # the pressure goes with the tension
    laid = float(stage.problem.tension_curve.at(stage.radius[-1:])[0])
    gives = result.wound_on_tension / stage.problem.web_thickness
    return float(max(wound, 0.0) * gives / laid + SHARE * result.peak_pressure)


def effective_cylinder(problem: WindingProblem, radius: float, pressure: float) -> Cylinder:
    """Return the cylinder of the stack's tangent moduli at one pressure."""
    rr, tt, rt, shear, _ = problem.stack.tangent(pressure, pressure)
    material = Orthotropic(
        radial=float(rr), tangential=float(tt), cross=float(rt), shear=float(shear)
    )
    return Cylinder(radius=radius, core_radius=problem.core.radius, material=material)


def _linear_cylinder(problem: WindingProblem, radius: float) -> Cylinder:
    material = problem.web.material
    assert isinstance(material, Material)  # as the problem asks
    return Cylinder(radius=radius, core_radius=problem.core.radius, material=material)


def hardening_roll(problem: WindingProblem, stage: WoundRollResult) -> WoundRoll:
    """Return the roll of a stage, which hardens under the nip."""
    pressure = Profile(radius=stage.radius, value=np.maximum(stage.pressure, 0.0))
    return WoundRoll(
        radius=float(stage.radius[-1]), core_radius=problem.core.radius, stack=problem.stack,
        pressure=pressure,
    )  # fmt: skip
