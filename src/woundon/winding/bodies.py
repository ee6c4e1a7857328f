r"""The wound roll as a body of the nip contact problem: three models.

    linear      a cylinder of the web's own moduli; the stack has no effect on the nip
    effective   a linear cylinder with the moduli of the stack at one pressure,
                    P_e = (mean of the wound pressure down to a below the surface) + 0.25 p_max
    direct      the stack under the pressure wound so far, which hardens under the nip

The wound pressure increases from zero at the surface; in newsprint it is half its plateau value at
the depth of one half-width, where the stress of a line contact is large.  Therefore its mean over
this depth is used.
The coefficient 0.25 of p_max follows from direct solutions of confined nips on soft stacks (docs:
stacks) and is not a fit parameter.  P_e and the nip are solved as a fixed point: WOT, a and p_max
are approximated by powers of P_e, whose exponents follow from two nips.
"""

from __future__ import annotations

from collections.abc import Callable
from math import isnan, nan
from typing import NamedTuple

import numpy as np

from ..contact.refinement import neighbouring_solution
from ..errors import NotConverged
from ..nip.result import NipResult
from ..problems.bodies import Body, Cylinder
from ..problems.materials import Material, Orthotropic
from ..problems.schedules import Profile
from ..problems.winding import WindingProblem
from ..problems.wound_roll import WoundRoll
from ..roll.result import RollResult
from ..roll.stages import Stage
from ..roll.weight import DEPTHS, PEAK_COEFFICIENT

__all__ = [
    "NipSample",
    "effective_cylinder",
    "effective_pressure",
    "hardening_roll",
    "linear_cylinder",
    "predicted_nip",
    "solved_nip",
    "tension_on_roll",
    "with_exponents",
]

Array = np.ndarray
Solve = Callable[[Body, NipResult | None], NipResult]

EXPONENT_STEP = 0.01  # relative difference of P_e for its exponents
MAX_NIPS = 25  # in the iteration for P_e
# Relative differences of P_e below this are too noisy to determine the exponents.
SMALLEST_STEP = 2e-3
STEP, TOLERANCE = 1e-3, 1e-9  # relative: difference step and convergence tolerance of P_e
# Bounds of f' in Newton's method for P_e = f(P_e), and of P_e after a step relative to that before
MIN_FEEDBACK, MAX_FEEDBACK, MIN_RATIO = -2.0, 0.8, 0.2
LARGEST_FRACTION = 0.9  # largest P_e, as a fraction of the maximum pressure of the stack law


class NipOutputs(NamedTuple):
    """Outputs of a nip that determine its effective pressure, or exponents of P_e in them [1].

    Attributes
    ----------
    tension : float
        Wound-on tension WOT [N/m].
    half_width : float
        a [m].
    peak : float
        Peak pressure p_max [Pa].
    """

    tension: float
    half_width: float
    peak: float


# Initial guess of the exponents of P_e: Hertz contact, with the modulus (E_r E_t)^1/2.
HERTZ = NipOutputs(0.0, -0.25, 0.25)


class NipSample(NamedTuple):
    """A solved nip at one radius of the growing roll.

    Attributes
    ----------
    result : NipResult
    pressure : float
        P_e with which the nip was solved [Pa]; nan if the roll body is not "effective".
    implied_pressure : float
        P_e that follows from the wound pressure and this nip [Pa].
    feedback : float
        Derivative of the implied pressure by P_e [1].
    exponents : NipOutputs
        Exponents of P_e in wound-on tension, half-width and peak pressure [1].
    """

    result: NipResult
    pressure: float = nan
    implied_pressure: float = nan
    feedback: float = 0.0
    exponents: NipOutputs = HERTZ

    @property
    def radius(self) -> float:
        """Radius of the roll [m]."""
        return float(self.result.problem.roll.radius)

    @property
    def tension(self) -> float:
        """Wound-on tension, extrapolated to the implied pressure [N/m]."""
        return (
            tension_on_roll(self.result)
            if isnan(self.implied_pressure)
            else self.outputs_at(self.implied_pressure).tension
        )

    def outputs_at(self, pressure: float) -> NipOutputs:
        """Extrapolate the outputs of the nip to another P_e [Pa], as powers of P_e."""
        ratio = pressure / self.pressure
        outputs, exponents = _nip_outputs(self.result), self.exponents
        return NipOutputs(
            outputs.tension * ratio**exponents.tension,
            outputs.half_width * ratio**exponents.half_width,
            outputs.peak * ratio**exponents.peak,
        )


def solved_nip(
    problem: WindingProblem,
    radius: float,
    stage: Stage | None,
    previous: NipSample | None,
    neighbour: NipSample | None,
    solve: Solve,
    coupling_rtol: float,
    pressure: float | None = None,
) -> NipSample:
    """Solve the nip on the roll at a stage of its build-up.

    Parameters
    ----------
    problem : WindingProblem
    radius : float
        Radius of the roll [m].
    stage : Stage, optional
        The roll at this radius; None with a linear roll body.
    previous, neighbour : NipSample, optional
        Solutions of the same nip on a similar roll, and of a nearby nip, as initial guesses.
    solve : callable
        (roll, neighbouring result for a warm start, or None) -> result of the nip.
    coupling_rtol : float
        Relative tolerance of the effective pressure P_e, at which the moduli of the roll are taken.
    pressure : float, optional
        Guess of P_e without a solution on a similar roll [Pa].
    """
    guess = previous or neighbour
    start = guess.result if guess else None
    if stage is None:
        return NipSample(solve(linear_cylinder(problem, radius), start))
    if problem.roll_body == "direct":
        return NipSample(solve(hardening_roll(problem, stage), start))
    return _effective(problem, stage, previous, neighbour, solve, coupling_rtol, pressure)


def _effective(
    problem: WindingProblem,
    stage: Stage,
    previous: NipSample | None,
    neighbour: NipSample | None,
    solve: Solve,
    coupling_rtol: float,
    pressure: float | None,
) -> NipSample:
    """Solve the nip on an effective cylinder by a fixed-point iteration for P_e.

    P_e is the pressure at which the moduli of the cylinder are those of the stack.  It follows from
    the wound pressure and the nip, which depends on it.  Parameters as of :func:`solved_nip`.
    """
    guess, radius = previous or neighbour, float(stage.radius[-1])
    if previous:
        P = predicted_nip(problem, stage, previous).implied_pressure
    elif pressure:
        P = min(pressure, _largest_pressure(problem))
    else:
        P = _initial_pressure(problem, stage, neighbour)
    result = guess.result if guess else None
    last: NipSample | None = None
    for _ in range(MAX_NIPS):
        result = solve(effective_cylinder(problem, radius, P), result)
        sample = NipSample(result, P, exponents=guess.exponents if guess else HERTZ)
        if last is not None and abs(P - last.pressure) > SMALLEST_STEP * P:
            outputs = _nip_outputs(result), _nip_outputs(last.result)
            sample = sample._replace(exponents=_exponents(*outputs, P / last.pressure))
        sample = predicted_nip(problem, stage, sample)
        if abs(sample.implied_pressure - P) <= coupling_rtol * P:
            return sample
        last = guess = sample
        P = sample.implied_pressure
    raise NotConverged(
        f"the effective pressure P_e does not converge within {MAX_NIPS} nips", result
    )


def predicted_nip(problem: WindingProblem, stage: Stage, sample: NipSample) -> NipSample:
    """Return a nip with the effective pressure that it implies on a stage of the roll.

    The effective pressure P_e, at which the moduli of the roll are taken, is the wound pressure
    near the surface plus a part of the peak pressure of the nip.  The nip is not solved again: its
    outputs are extrapolated as powers of P_e, and P_e = f(P_e) is solved by Newton's method with a
    difference quotient for f'.

    Parameters
    ----------
    problem : WindingProblem
    stage : Stage
        The roll, with its wound pressure.
    sample : NipSample
        The solved nip, and the exponents of P_e in its outputs.
    """
    P, feedback, largest = sample.pressure, 0.0, _largest_pressure(problem)
    for _ in range(MAX_NIPS):
        f, f_step = (
            min(effective_pressure(stage, *sample.outputs_at(Q)), largest)
            for Q in (P, (1 + STEP) * P)
        )
        feedback = float(np.clip((f_step - f) / (STEP * P), MIN_FEEDBACK, MAX_FEEDBACK))
        last, P = P, max(P + (f - P) / (1 - feedback), MIN_RATIO * P)
        if abs(P - last) <= TOLERANCE * P:
            break
    return sample._replace(implied_pressure=P, feedback=feedback)


def _initial_pressure(problem: WindingProblem, stage: Stage, neighbour: NipSample | None) -> float:
    """Return the initial guess of P_e [Pa], from a neighbouring nip if it has an effective roll."""
    radius = float(stage.radius[-1])
    load = float(problem.at("nip_load", radius))
    if neighbour is None or isnan(neighbour.implied_pressure):
        # the wound pressure, and the load over the contact width, of a stack at 100 kPa
        P = 1e5 + PEAK_COEFFICIENT * load / 2e-3
    elif neighbour.radius != radius:  # the pressure varies little from nip to nip
        return neighbour.implied_pressure
    else:
        # the same nip of another winding, with another roll and another load: widths and
        # pressures of line contacts vary as the square root of the load
        factor = (load / neighbour.result.problem.nip_load) ** 0.5
        outputs = _nip_outputs(neighbour.result)
        P = effective_pressure(
            stage, stage.tension, factor * outputs.half_width, factor * outputs.peak
        )
    return min(P, _largest_pressure(problem))


def with_exponents(problem: WindingProblem, stage: Stage, sample: NipSample) -> NipSample:
    """Return a nip with its exponents of P_e, from the same nip under a slightly higher P_e.

    They stay as they are if this nip cannot be solved on the same mesh.  Parameters as of
    :func:`predicted_nip`.
    """
    assert sample.result.refinement is not None  # only of a loaded result
    mesh, P = sample.result.refinement.last, (1 + EXPONENT_STEP) * sample.pressure
    roll = effective_cylinder(problem, sample.radius, P)
    try:
        outputs = neighbouring_solution(mesh, mesh.system.problem.replace(roll=roll)).outputs
    except ArithmeticError:  # of the iteration, or of a body under an iterate
        return sample
    neighbour = NipOutputs(
        outputs["roll_wound_on_tension"], outputs["half_width"], outputs["peak_pressure"]
    )
    exponents = _exponents(neighbour, _nip_outputs(sample.result), 1 + EXPONENT_STEP)
    return predicted_nip(problem, stage, sample._replace(exponents=exponents))


def tension_on_roll(result: NipResult) -> float:
    """Return the tension with which the web is wound into the roll [N/m].

    The roll has closed layers, and its surface is free of the nip when the next layer arrives.
    """
    return result.roll_wound_on_tension


def _nip_outputs(result: NipResult) -> NipOutputs:
    """Return the outputs of a nip that determine its effective pressure."""
    return NipOutputs(tension_on_roll(result), result.half_width, result.peak_pressure)


def _exponents(outputs: NipOutputs, others: NipOutputs, ratio: float) -> NipOutputs:
    """Return the exponents of P_e in the outputs of a nip from its solutions for two P_e.

    ``ratio`` is that of the two P_e.  The exponent of a tension that changes its sign is 0.
    """
    # x = c P_e^k for two P_e: k = ln(x/x_other)/ln(ratio)
    ratios = np.divide(outputs, others)
    logarithms = np.log(np.where(ratios > 0, ratios, 1.0))
    return NipOutputs(*(logarithms / np.log(ratio)).tolist())


def _largest_pressure(problem: WindingProblem) -> float:
    """Return the largest permitted P_e [Pa], somewhat below the end of the law of the stack."""
    return float(LARGEST_FRACTION * problem.stack.limit)


def effective_pressure(stage: Stage, tension: float, half_width: float, peak: float) -> float:
    """Return P_e from the wound pressure and the peak pressure of the nip [Pa].

    Parameters
    ----------
    stage : Stage
    tension, half_width, peak : float
        WOT [N/m], a [m] and p_max [Pa] of the nip.
    """
    surface, core = float(stage.radius[-1]), float(stage.radius[0])
    r = np.linspace(max(core, surface - half_width), surface, DEPTHS)
    wound = np.trapezoid(stage.stresses_at(r)[0], r) / (r[-1] - r[0])
    # Near the surface the pressure is proportional to the tension of the last layers, without their
    # centrifugal force: it is scaled to the tension of this nip.
    force = stage.centrifugal_tension
    ratio = (tension - force) / (stage.tension - force)
    return float(max(wound, 0.0) * ratio + PEAK_COEFFICIENT * peak)


def effective_cylinder(problem: WindingProblem, radius: float, pressure: float) -> Cylinder:
    """Return a linear cylinder with the tangent moduli of the stack at one pressure.

    ``radius`` is that of the roll [m], ``pressure`` the effective pressure P_e of the nip [Pa].
    """
    # taken as wound under this pressure, so that the shear modulus is ``shear`` of the stack
    rr, tt, rt, shear, _ = problem.stack.tangent(pressure, P0=pressure)
    material = Orthotropic(
        radial=float(rr), tangential=float(tt), cross=float(rt), shear=float(shear)
    )
    return Cylinder(radius=radius, core_radius=problem.core.radius, material=material)


def linear_cylinder(problem: WindingProblem, radius: float) -> Cylinder:
    """Return a cylinder of a radius [m] with the moduli of the web itself, without the stack."""
    material = problem.web.material
    assert isinstance(material, Material)  # validated by the problem
    return Cylinder(radius=radius, core_radius=problem.core.radius, material=material)


def hardening_roll(problem: WindingProblem, stage: Stage | RollResult) -> WoundRoll:
    """Return the wound roll of a stage as a nonlinear body that hardens under the nip."""
    # the computed pressure may be below zero by rounding, at the surface where it is zero
    pressure = Profile(radius=stage.radius, value=np.maximum(stage.pressure, 0.0))
    return WoundRoll(
        radius=float(stage.radius[-1]),
        core_radius=problem.core.radius,
        stack=problem.stack,
        pressure=pressure,
    )
