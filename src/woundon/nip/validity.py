"""Where a solved nip, alone or wrapped, leaves the model of two bodies and a thin taut web."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..errors import RESOLUTION
from ..problems.nip import WindingNip
from ..validity import pair_warnings, past, zone_warnings
from .result import WindingNipResult

__all__ = ["nip_warnings", "web_far_outside"]

Array = np.ndarray

SERIES_ERROR = 1e-4
FAR_STRAIN = 1.0
FAR_THICKNESS = 10.0  # nip widths


def nip_warnings(result: WindingNipResult) -> tuple[str, ...]:
    """Return where a solved nip leaves the model's validity, and what its grid is too coarse for.

    Strains and tensions are those of the whole web; surfaces and zones those of the nip.
    """
    own = result.in_nip
    tractions = {"roll": result.roll_traction[own], "drum": result.drum_traction[own]}
    zones = {"roll": result.roll_zone[own], "drum": result.drum_zone[own]}
    return (
        *pair_warnings(result, tractions),
        *_cautions(result),
        *_surface_strains(result),
        *_web(result),
        *zone_warnings(result.x[own], zones),
        *_series(result),
    )


def _cautions(r: WindingNipResult) -> Iterator[str]:
    for name, body in (("roll", r.problem.roll), ("drum", r.problem.drum)):
        if body.caution:
            yield f"of the {name}: {body.caution}"


def _surface_strains(r: WindingNipResult) -> Iterator[str]:
    x = r.x[r.in_nip]
    for name, strain in (("roll", _roll_strain(r)), ("drum", _drum_strain(r))):
        if not getattr(r.problem, name).rigid:
            k = int(np.argmax(np.abs(strain)))
            yield from past(
                "surface strain", float(strain[k]),
                f"the {name}'s surface strain is {{}} at x = {x[k] * 1e3:.3g} mm",
            )  # fmt: skip


def _web_strain(r: WindingNipResult) -> Array:
    """Return the web's strain (thesis eq. 72) along all of it, (N,)."""
    web = r.problem.web
    c = web.compliance
    p = getattr(r, "roll_pressure", r.pressure)  # on a wrap nothing else presses
    return c.c11 / web.thickness * r.web_tension - c.c12 * p


def _where_slips_are_taken(r: WindingNipResult) -> Array:
    own = r.in_nip
    return np.interp(r.slip_x[own], r.x[own], _web_strain(r)[own])


def _drum_strain(r: WindingNipResult) -> Array:
    """Return the drum's tangential surface strain in the nip, by its slip (thesis eq. 133)."""
    return _where_slips_are_taken(r) + r.drum_creep - r.drum_slip[r.in_nip]


def _roll_strain(r: WindingNipResult) -> Array:
    """Return the roll's tangential surface strain in the nip less that at the trailing edge."""
    strain = _where_slips_are_taken(r) - r.roll_slip[r.in_nip]
    return strain - strain[-1]


def _web(r: WindingNipResult) -> Iterator[str]:
    web, peak, strain = r.problem.web, float(np.max(r.pressure)), _web_strain(r)
    modulus = web.radial_modulus(peak)
    yield from past(
        "pressure on the web", peak / modulus,
        f"the peak pressure {peak / 1e6:.3g} MPa is {{}} of the web's radial stiffness "
        f"{modulus / 1e6:.3g} MPa",
    )  # fmt: skip
    k = int(np.argmax(np.abs(strain)))
    yield from past(
        "web strain", float(strain[k]),
        f"the web's strain is {{}} at a tension of {r.web_tension[k]:.4g} N/m",
    )  # fmt: skip
    yield from past(
        "web thickness", web.thickness / r.nip_width,
        f"the web's thickness {web.thickness * 1e6:.3g} um is {{}} of the nip width "
        f"{r.nip_width * 1e3:.3g} mm",
    )  # fmt: skip
    slackest = float(np.min(r.web_tension))
    if slackest < 0:
        at = float(r.x[int(np.argmin(r.web_tension))])
        yield (
            f"the web is slack: its tension falls to {slackest:.4g} N/m at x = {at * 1e3:.3g} mm; "
            f"at least {r.problem.web_tension - slackest:.4g} N/m of web tension are needed"
        )


def web_far_outside(problem: WindingNip, width: float) -> Iterator[str]:
    """Yield where a web is far outside the model, and what to change.

    Parameters
    ----------
    problem : NipProblem or WrappedNipProblem
    width : float
        About that of the nip [m].
    """
    web = problem.web
    tension = problem.web_tension + (problem.roll_friction + problem.drum_friction) * (
        problem.nip_load
    )
    strain = web.compliance.c11 / web.thickness * tension
    if strain > FAR_STRAIN:
        yield (
            f"this is far outside the model: tensions up to {tension:.3g} N/m (web tension, and "
            f"what friction may add) stretch the web {strain:.2g} times its length; take smaller "
            "ones, or a thicker or stiffer web"
        )
    if width < web.thickness / FAR_THICKNESS:
        yield (
            f"this is far outside the model: a nip about {width:.2g} m wide is nothing beside the "
            f"web's thickness, {web.thickness:.2g} m; take a larger nip load, or a smaller web "
            "tension"
        )


def _series(r: WindingNipResult) -> Iterator[str]:
    if r.series_error > SERIES_ERROR:
        yield (
            f"{RESOLUTION}the series of an elastic layer is truncated with an error of "
            f"{r.series_error:.2g} after {r.series_terms} terms"
        )
