r"""The roll that a nip feels while it is wound: three answers to one question.

    linear      a cylinder of the web's own moduli; the stack takes no part in the nip
    effective   a linear cylinder of the stack at one pressure,
                    P_e = (mean of the wound pressure down to a below the surface) + 0.25 p_max
    direct      the stack under the pressure wound so far, hardening under the nip

The wound pressure grows from nothing at the surface, in newsprint to half its plateau a half-width
below it, where a line contact presses most: hence the mean.  0.25 p_max is what the direct solution
of confined nips wants in soft stacks (docs: stacks); nothing is fitted here.  P_e and the nip that
has it are found together: WOT, a and p_max go with powers of P_e, which two nips tell.
"""

from __future__ import annotations

from collections.abc import Callable
from math import isnan, nan
from typing import NamedTuple

import numpy as np

from ..errors import NotConverged
from ..nip.result import NipResult
from ..problems.bodies import Body, Cylinder
from ..problems.materials import Material, Orthotropic
from ..problems.schedules import Profile
from ..problems.winding import WindingProblem
from ..problems.wound_roll import WoundRoll
from ..roll.result import RollResult
from ..roll.stages import Stage

__all__ = [
    "Felt",
    "effective_cylinder",
    "felt_pressure",
    "hardening_roll",
    "predicted_nip",
    "solved_nip",
    "tension_on_roll",
]

Array = np.ndarray
Solve = Callable[[Body, NipResult | None], NipResult]

SHARE = 0.25  # of p_max
DEPTHS = 33  # at which the wound pressure is averaged
MOST = 25  # nips until P_e is found
# powers of P_e with which WOT, a and p_max go, by first guess: Hertz's, with (E_r E_t)^1/2
HERTZ = 0.0, -0.25, 0.25
SMALLEST_STEP = 2e-3  # of P_e, for powers: smaller differences are discretisation noise
STEP, SETTLED = 1e-3, 1e-9  # of P_e
ALMOST = 0.9  # of the pressure at which a stack's law ends


class Felt(NamedTuple):
    """A nip on a roll wound so far.

    Attributes
    ----------
    result : NipResult
    pressure : float
        P_e of its roll [Pa]; nan where the roll has no single one.
    wanted : float
        P_e that wound pressure and nip ask for [Pa].
    steep : float
        How much of a change of P_e comes back.
    powers : (float, float, float)
        Of P_e, with which the wound-on tension, the half-width and the peak pressure go.
    """

    result: NipResult
    pressure: float = nan
    wanted: float = nan
    steep: float = 0.0
    powers: tuple[float, float, float] = HERTZ

    @property
    def radius(self) -> float:
        """Of the roll that it runs on [m]."""
        return float(self.result.problem.roll.radius)

    @property
    def tension(self) -> float:
        """The wound-on tension, as it would be at the pressure wanted [N/m]."""
        return tension_on_roll(self.result) if isnan(self.wanted) else self.at(self.wanted)[0]

    def at(self, pressure: float) -> tuple[float, float, float]:
        """Return WOT [N/m], a [m] and p_max [Pa] as they would be at another P_e."""
        by = pressure / self.pressure
        found = (value * by**power for value, power in zip(_told(self.result), self.powers,
                                                           strict=True))  # fmt: skip
        return next(found), next(found), next(found)


def solved_nip(
    problem: WindingProblem, radius: float, stage: Stage | None, own: Felt | None,
    near: Felt | None, solve: Solve, agreed: float,
) -> Felt:  # fmt: skip
    """Return the nip on a roll wound so far.

    Parameters
    ----------
    problem : WindingProblem
    radius : float
        Of the roll that the nip runs on [m].
    stage : Stage, optional
        What has been wound, which a linear roll does not feel.
    own, near : Felt, optional
        The same nip on nearly the same roll, and a neighbour.
    solve : callable
        (roll, neighbouring result or None) -> result.
    agreed : float
        To what P_e is to be found, relative.
    """
    known = own or near
    start = known.result if known else None
    if stage is None:
        return Felt(solve(_linear_cylinder(problem, radius), start))
    if problem.roll_body == "direct":
        return Felt(solve(hardening_roll(problem, stage), start))
    return _effective(problem, stage, own, near, solve, agreed)


def _effective(
    problem: WindingProblem, stage: Stage, own: Felt | None, near: Felt | None, solve: Solve,
    agreed: float,
) -> Felt:  # fmt: skip
    known, radius = own or near, float(stage.radius[-1])
    if own:
        P = predicted_nip(problem, stage, own).wanted
    elif near and isnan(near.wanted):  # of a winding with another roll body
        P = min(_first_guess(problem, stage), _most(problem))
    elif near and near.radius != radius:
        P = near.wanted
    elif near:
        # The same nip of another winding, with another roll and another load: widths and
        # pressures of line contacts vary as the root of the load.
        load = float(problem.at("nip_load", radius))
        wider = (load / near.result.problem.nip_load) ** 0.5
        _, a, peak = _told(near.result)
        P = min(felt_pressure(stage, stage.tension, wider * a, wider * peak), _most(problem))
    else:
        P = min(_first_guess(problem, stage), _most(problem))
    result = known.result if known else None
    last: Felt | None = None
    for _ in range(MOST):
        result = solve(effective_cylinder(problem, radius, P), result)
        felt = Felt(result, P, powers=known.powers if known else HERTZ)
        if last is not None and abs(P - last.pressure) > SMALLEST_STEP * P:
            felt = felt._replace(powers=_powers(felt, last))
        felt = predicted_nip(problem, stage, felt)
        if abs(felt.wanted - P) <= agreed * P:
            return felt
        last = known = felt
        P = felt.wanted
    raise NotConverged(f"the pressure that the roll feels is not found within {MOST} nips", result)


def predicted_nip(problem: WindingProblem, stage: Stage, felt: Felt) -> Felt:
    """Return a nip with the P_e that it and a roll wound so far ask for, as far as powers tell."""
    P, steep, most = felt.pressure, 0.0, _most(problem)
    for _ in range(MOST):
        found, more = (min(felt_pressure(stage, *felt.at(Q)), most) for Q in (P, (1 + STEP) * P))
        steep = float(np.clip((more - found) / (STEP * P), -2.0, 0.8))
        last, P = P, max(P + (found - P) / (1 - steep), 0.2 * P)
        if abs(P - last) <= SETTLED * P:
            break
    return felt._replace(wanted=P, steep=steep)


def tension_on_roll(result: NipResult) -> float:
    """Return the tension with which the web is wound into the roll [N/m].

    The roll has closed layers, and its surface is free of the nip when the next layer arrives.
    """
    return result.roll_wound_on_tension


def _told(result: NipResult) -> tuple[float, float, float]:
    return tension_on_roll(result), result.half_width, result.peak_pressure


def _powers(felt: Felt, last: Felt) -> tuple[float, float, float]:
    """Return the powers of P_e that two nips tell; a tension without sign has none."""
    ratios = np.divide(_told(felt.result), _told(last.result))
    by = np.log(np.where(ratios > 0, ratios, 1.0)) / np.log(felt.pressure / last.pressure)
    return float(by[0]), float(by[1]), float(by[2])


def _most(problem: WindingProblem) -> float:
    return float(ALMOST * problem.stack.limit)


def _first_guess(problem: WindingProblem, stage: Stage) -> float:
    """Return P_e to begin with: of a contact as wide as it would be on a stack at 100 kPa."""
    P = float(problem.at("nip_load", stage.radius[-1]))
    return 1e5 + SHARE * P / 2e-3


def felt_pressure(stage: Stage, tension: float, half_width: float, peak: float) -> float:
    """Return P_e that a roll and a nip on it ask for, whose tension the last laps take [Pa].

    Parameters
    ----------
    stage : Stage
    tension, half_width, peak : float
        WOT [N/m], a [m] and p_max [Pa] of the nip.
    """
    surface, core = float(stage.radius[-1]), float(stage.radius[0])
    r = np.linspace(max(core, surface - half_width), surface, DEPTHS)
    wound = np.trapezoid(stage.pressure_at(r), r) / (r[-1] - r[0])
    # what it would be if the last laps had been wound with what this nip gives: near the surface
    # the pressure goes with the tension
    return float(max(wound, 0.0) * tension / stage.tension + SHARE * peak)


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


def hardening_roll(problem: WindingProblem, stage: Stage | RollResult) -> WoundRoll:
    """Return the roll of a stage, which hardens under the nip."""
    pressure = Profile(radius=stage.radius, value=np.maximum(stage.pressure, 0.0))
    return WoundRoll(
        radius=float(stage.radius[-1]), core_radius=problem.core.radius, stack=problem.stack,
        pressure=pressure,
    )  # fmt: skip
