"""Assembly of the result of a winding from tension, roll and nips."""

from __future__ import annotations

from collections.abc import Sequence
from math import nan
from typing import Any

import numpy as np

from ..errors import RESOLUTION
from ..problems.paths import field_or_none
from ..problems.schedules import Steps
from ..problems.winding import LOADS, SCHEDULES, WindingProblem
from ..results import Residuals
from ..roll.solve import WoundRoll
from ..roll.validity import yield_warnings
from .bodies import NipSample, tension_on_roll
from .drives import drive_radii, drives_of
from .drum_nips import drum_nips
from .nips import Nips
from .result import WindingResult
from .roll import recomputed, wind

__all__ = ["assemble_result"]

Array = np.ndarray

ROLL_OUTPUTS = (
    "core_pressure",
    "mid_pressure",
    "least_hoop_stress",
    "bore_hoop_stress",
    "bore_displacement",
)


def assemble_result(
    problem: WindingProblem,
    r: Array,
    tension: Array,
    roll: WoundRoll,
    nips: Nips,
    *,
    interpolation: tuple[float, float],
    rtol: float,
    coupling_rtol: float,
    film: float,
    curved: Array | None = None,
    departure: Array | None = None,
) -> WindingResult:
    """Assemble the result of a winding, without its residuals.

    Parameters
    ----------
    problem : WindingProblem
    r, tension : (M,) arrays
        Radii [m], wound-on tension there [N/m].
    roll : WoundRoll
        The roll of this tension, without the changes after winding.
    nips : Nips
    interpolation : (float, float)
        Relative interpolation errors of the tension between the nips, and near the core.
    rtol, coupling_rtol, film : float
        See :class:`WindingResult`.
    curved : (M,) array, optional
        The tension, extrapolated to the core with its curvature [N/m].
    departure : (n,) array, optional
        Tension minus that of the nips, which are solved with smoothed schedules [N/m].
    """
    loads: dict[str, Any] = {name: problem.at(name, r) for name in LOADS}
    samples = nips.from_core_to_surface()
    finished = roll
    if problem.is_changed:
        finished = wind(problem, r, tension, rtol, film)
    wound = finished.certified()
    of_drives = drive_radii(problem)
    drives: dict[str, Any] = drives_of(problem, of_drives, film)
    result = WindingResult(
        problem=problem,
        radius=r,
        **loads,
        nip_induced_tension=tension - loads["web_tension"],
        wound_on_tension=tension,
        **_arrays_of_nips(nips, samples),
        nip_departure=np.zeros(len(samples)) if departure is None else departure,
        air_film=film,
        interpolation_error=interpolation[0],
        core_interpolation_error=interpolation[1],
        nodes=nips.nodes,
        roll_rtol=rtol,
        coupling_rtol=coupling_rtol,
        nips_solved=nips.solved,
        front=drum_nips([sample.result for sample in samples], 1),
        rider=drum_nips([sample.result for sample in samples], 2),
        drive_radius=of_drives,
        **drives,
        residuals=Residuals(),
        warnings=(
            *nips.warnings(),
            *_unevenness_warning(problem, interpolation[0], rtol, len(samples)),
            *wound.warnings,
            *yield_warnings(wound.problem, problem.limits.yield_strain),
        ),
        wound=wound,
        nips=tuple(samples),
    )
    if curved is None:
        return result.replace(errors=_errors(result, {}))
    curved_roll = recomputed(problem, finished, r, curved, film).result
    first_layers = {
        name: abs(getattr(curved_roll, name) - getattr(finished.result, name))
        for name in ROLL_OUTPUTS
    }
    return result.replace(errors=_errors(result, first_layers))


def _arrays_of_nips(nips: Nips, samples: Sequence[NipSample]) -> dict[str, Any]:
    """Return the arrays over the solved nips, (n,) each [SI], by the names of the result."""
    results = [sample.result for sample in samples]
    arrays = {
        "radius": [sample.radius for sample in samples],
        "wound_on_tension": [tension_on_roll(nip) for nip in results],
        "half_width": [nip.half_width for nip in results],
        "peak_pressure": [nip.peak_pressure for nip in results],
        "effective_pressure": [sample.pressure for sample in samples],
        "air_film": [nips.films[sample.radius] for sample in samples],
        # the friction that the air film leaves
        "friction": [nip.without_air.roll_friction for nip in results],
        "error": [nip.errors.get("roll_wound_on_tension", nan) for nip in results],
        "residual": [nip.residual for nip in results],
    }
    return {f"nip_{name}": np.array(values) for name, values in arrays.items()}


def _unevenness_warning(
    problem: WindingProblem, interpolation: float, rtol: float, count: int
) -> list[str]:
    """Return a warning if the interpolation error between the nips exceeds 2 rtol."""
    if interpolation <= 2 * rtol:
        return []
    if any(isinstance(field_or_none(problem, name), Steps) for name in SCHEDULES):
        return [
            f"{RESOLUTION}next to the steps of the schedules the interpolation error of the "
            f"wound-on tension is up to {100 * interpolation:.2g} %"
        ]
    return [
        f"{RESOLUTION}the schedules vary so much between the {count} nips that the interpolation "
        f"error of the wound-on tension is {100 * interpolation:.2g} %; smooth the schedules, or "
        "split the winding where they change"
    ]


def _errors(result: WindingResult, first_layers: dict[str, float]) -> dict[str, float]:
    """Return the error estimates of the outputs, from nips, interpolation and roll.

    The effect of the layers below the first nip is the difference to a roll whose tension is
    extrapolated there with its curvature.
    """
    errors = {}
    tension_error = result.interpolation_error + result.coupling_rtol
    if result.nip_radius.size:
        tension_error += float(np.max(result.nip_error / result.nip_wound_on_tension))
        errors["mean_wound_on_tension"] = tension_error * result.mean_wound_on_tension
    for name in ROLL_OUTPUTS:
        roll_error, value = result.roll.errors.get(name, nan), getattr(result, name)
        # the pressure in a roll is about proportional to the square of its tension, the other
        # outputs to a smaller power of it
        errors[name] = roll_error + 2 * tension_error * abs(value) + first_layers.get(name, 0.0)
    # the interpolation error near the core affects only the core pressure, in proportion: it is
    # that of a few layers, whose tension presses on the core directly
    errors["core_pressure"] += result.core_interpolation_error * result.core_pressure
    return errors
