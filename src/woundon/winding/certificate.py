"""Residuals of a winding: nips, roll and the coupling between them."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..errors import unwarned
from ..nip.result import NipResult
from ..problems.bodies import Body
from ..problems.schedules import Curve
from ..problems.winding import WindingProblem
from ..results import ACCEPTED_RESIDUAL, Residuals, largest, positive
from ..roll.density import mean_over_length
from ..roll.result import RollResult
from ..roll.stages import stages_at
from .bodies import effective_cylinder, effective_pressure, hardening_roll, linear_cylinder
from .drives import drive_radii, drives_of
from .drum_nips import drum_nips
from .foil import mean_foil_film
from .measured import smoothed
from .nips import PRESSURE_TOLERANCE, Nips
from .winding_fields import WindingFields

__all__ = ["LARGEST_COUPLING_RTOL", "certificate", "recomputed_nips"]

Array = np.ndarray

LARGEST_COUPLING_RTOL = 1e-2  # largest tolerance that may be requested of nips and roll
# More than a winding has: a file with more is rejected, since its nips would take hours.
MOST_NIPS, MOST_NODES = 200, 1025
# Recomputed nips agree to this multiple of ``coupling_rtol``, with which the air film, the friction
# and the pressure in the roll are known, and at least to the accuracy of a warm start.
FACTOR, LEAST_DIFFERENCE = 10.0, 1e-6
LOADS = "web_tension", "nip_load", "winding_force", "nip_induced_tension", "wound_on_tension"
NIP_ARRAYS = (
    "nip_radius",
    "nip_wound_on_tension",
    "nip_departure",
    "nip_half_width",
    "nip_peak_pressure",
    "nip_effective_pressure",
    "nip_air_film",
    "nip_friction",
    "nip_error",
    "nip_residual",
)


def certificate(result: WindingFields) -> Residuals:
    """Compute the residuals of a result.

    roll
        Largest residual of the roll.
    roll_tension
        Difference between the tension of the roll and the reported wound-on tension, relative to
        the largest.
    nips
        Largest residual of any nip; infinite unless half-widths, pressures and friction
        coefficients are positive, all arrays of the nips have the same length, and nips and nodes
        are not too many.
    coupling
        Relative difference between the wound-on tension of each nip and the reported tension minus
        its departure under fluctuating schedules; scaled so that ``coupling_rtol`` is 1e-8.
    air
        Difference between the air film of the layers and the mean film of the nips, without a nip
        that of a foil bearing, relative to the web thickness; scaled so that ``coupling_rtol`` is
        1e-8.
    tension_balance
        Residual of WOT = T_in + NIT, relative to the largest WOT.
    schedules
        Differences of T_in, P and F from the schedules, and of the torques and powers of the drives
        from those that follow, each relative to its largest value.
    reach
        Relative difference of the end radii from core and roll radius; infinite unless radii
        increase and all arrays over the radius have the same length.

    The nips themselves are solved again by :func:`recomputed_nips`.
    """
    problem, r, roll = result.problem, result.radius, result.roll
    WOT = result.wound_on_tension
    wound = Curve(roll.problem.wound_on_tension, *problem.ends).at(r)
    tension = np.interp(result.nip_radius, r, WOT) - result.nip_departure
    mismatch = tension / result.nip_wound_on_tension - 1
    unit = _largest_size(WOT)
    # tolerances outside this range cannot be requested
    rtol = result.coupling_rtol
    scale = ACCEPTED_RESIDUAL / rtol if 0 < rtol <= LARGEST_COUPLING_RTOL else np.inf
    schedules = [
        largest(np.abs(getattr(result, name) - problem.at(name, r)))
        / _largest_size(problem.at(name, r))
        for name in ("web_tension", "nip_load", "winding_force")
    ]
    return Residuals(
        roll=roll.certified().largest,
        roll_tension=largest(np.abs(wound - WOT)) / unit,
        nips=largest([largest(result.nip_residual), _positivity_residual(result)]),
        coupling=largest(np.abs(mismatch)) * scale,
        air=_air_film_residual(result) * scale,
        tension_balance=largest(np.abs(WOT - result.web_tension - result.nip_induced_tension))
        / unit,
        schedules=largest([*schedules, _drives_residual(result)]),
        reach=_end_radii_residual(result),
    )


def _largest_size(values: Array) -> float:
    """Return the largest absolute value, by which residuals are divided; never zero."""
    return max(float(np.max(np.abs(values))), 1e-300)


def _end_radii_residual(result: WindingFields) -> float:
    """Return the relative difference of the end radii from those of the problem.

    It is infinite unless radii increase and the arrays over them have their length.
    """
    r = result.radius
    if not (np.diff(r) > 0).all() or any(getattr(result, name).shape != r.shape for name in LOADS):
        return np.inf
    return largest(np.abs(r[[0, -1]] / result.problem.ends - 1))


def _drives_residual(result: WindingFields) -> float:
    """Return the largest difference of the drives from those of the problem, relative to each.

    It is infinite if a drive is missing, or has arrays of another length.
    """
    r = drive_radii(result.problem)
    if result.drive_radius.shape != r.shape:
        return np.inf
    differences = [largest(np.abs(result.drive_radius - r)) / result.problem.radius]
    for name, expected in drives_of(result.problem, r, result.air_film).items():
        drive = getattr(result, name)
        if (drive is None) != (expected is None):
            return np.inf
        for field, values in vars(expected).items() if expected is not None else ():
            given = getattr(drive, field)
            if given.shape != values.shape:
                return np.inf
            differences.append(largest(np.abs(given - values)) / _largest_size(values))
    return largest(differences)


def _positivity_residual(result: WindingFields) -> float:
    """Return 0 if widths, pressures and friction of all nips are positive, else inf."""
    expected = result.nip_radius.shape if result.problem.solves_nips else (0,)
    if any(getattr(result, name).shape != expected for name in NIP_ARRAYS):
        return np.inf
    if not _has_drum_nips(result, expected):
        return np.inf
    if result.nip_radius.size > MOST_NIPS or result.nodes > MOST_NODES:
        return np.inf
    quantities = [result.nip_half_width, result.nip_peak_pressure, result.nip_friction]
    if result.problem.roll_body == "effective":
        quantities.append(result.nip_effective_pressure)
    # other roll bodies have no effective pressure
    elif not np.isnan(result.nip_effective_pressure).all():
        return np.inf
    return largest([positive(*quantities), 0.0 if (result.nip_residual >= 0).all() else np.inf])


def _has_drum_nips(result: WindingFields, expected: tuple[int, ...]) -> bool:
    """Return whether the nips of front drum and rider are those of the problem's winder."""
    winder, has_nips = result.problem.winder, bool(expected[0])
    for nips, is_solved in (
        (result.front, has_nips and winder is not None),
        (result.rider, has_nips and winder is not None and winder.rider is not None),
    ):
        if (nips is not None) != is_solved:
            return False
        if nips is not None and any(array.shape != expected for array in vars(nips).values()):
            return False
    return True


def _air_film_residual(result: WindingFields) -> float:
    """Return the difference of the air film from the mean film of the nips, over thickness."""
    if not result.problem.has_nip:
        mean = mean_foil_film(result.problem)
    else:
        mean = mean_over_length(result.nip_radius, result.nip_air_film)
    return abs(result.air_film - mean) / float(result.problem.web.thickness)


def recomputed_nips(result: WindingFields) -> Mapping[str, tuple[Array, Array]]:
    """Solve the nips of a result again; return (outputs, tolerances) by the name of the field.

    A nip follows from the problem, its radius and the body of the roll: the effective pressure, or
    the stage of the roll.  With a direct roll and fluctuating schedules the stages belong to the
    roll of the smoothed schedules, which is not part of the result: nothing is recomputed then.
    """
    smooth = smoothed(result.problem, result.roll_rtol)
    problem, roll = smooth or result.problem, result.roll
    if not result.nip_radius.size or (smooth and problem.roll_body == "direct"):
        return {}
    nips = Nips(problem, result.nodes, result.coupling_rtol, report=lambda _: None)
    solved, rows, pressures = None, [], []  # solved: the previous nip, a warm start
    again: list[NipResult] = []
    for radius, P_e in zip(result.nip_radius.tolist(), result.nip_effective_pressure, strict=True):
        body = _roll_body(problem.replace(stack=roll.problem.stack), radius, P_e, roll)
        with unwarned():
            solved = nips.solve(body, solved)
        outputs = solved.roll_wound_on_tension, solved.half_width, solved.peak_pressure
        again.append(solved)
        rows.append((*outputs, nips.films[radius], solved.without_air.roll_friction))
        if problem.roll_body == "effective" and smooth is None:
            stage = stages_at(roll, [radius], as_wound=True)[0]
            pressures.append(effective_pressure(stage, *outputs))
    names = "wound_on_tension", "half_width", "peak_pressure", "air_film", "friction"
    within = max(FACTOR * result.coupling_rtol, LEAST_DIFFERENCE)
    values = {
        f"nip_{name}": (column, within * np.abs(column))
        for name, column in zip(names, np.array(rows).T, strict=True)
    }
    for name, index in (("front", 1), ("rider", 2)):
        drum = drum_nips(again, index)
        for field, column in vars(drum).items() if drum is not None else ():
            # differences of tensions and of angles may be close to zero
            sizes = {"added_tension": values["nip_wound_on_tension"][0]}
            sizes |= dict.fromkeys(("slip_angle", "stick_angle"), drum.arc if drum else column)
            values[f"{name}.{field}"] = column, within * np.abs(sizes.get(field, column))
    if pressures:
        P = np.array(pressures)
        values["nip_effective_pressure"] = P, PRESSURE_TOLERANCE * P
    return values


def _roll_body(problem: WindingProblem, radius: float, P_e: float, roll: RollResult) -> Body:
    """Return the roll at a radius [m] as a body of the nip; P_e is its effective pressure [Pa]."""
    if problem.roll_body == "effective":
        return effective_cylinder(problem, radius, P_e)
    if problem.roll_body == "direct":
        return hardening_roll(problem, stages_at(roll, [radius], as_wound=True)[0])
    return linear_cylinder(problem, radius)
