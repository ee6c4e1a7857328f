"""Validity checks of a nip, two bodies and a thin taut web, and of two rollers."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from ..elasticity.mesh import Wrap, nip_mesh
from ..errors import RESOLUTION
from ..problems.bodies import Body
from ..problems.nip import NipProblem
from ..validity import (
    LENGTH,
    LIMITS,
    STIFFNESS,
    TENSION,
    THICKNESS,
    limit_warning,
    zone_warnings,
)
from .result import NipResult
from .roller_result import RollerResult

__all__ = ["nip_warnings", "roller_warnings", "web_far_outside"]

Array = np.ndarray

# Accepted truncation error of a Fourier series: a tenth of the default criterion of the solver.
SERIES_ERROR = 1e-4
# Far outside the model, by which an unsolved case is explained: a web of twice its length, and one
# that is ten nip widths thick.
FAR_STRAIN = 1.0
FAR_THICKNESS = 10.0


def nip_warnings(result: NipResult) -> tuple[str, ...]:
    """Return the warnings of a nip outside the validity limits, or on too coarse a mesh.

    Strains and tensions are those of the whole web; surfaces and zones those of the nip.
    """
    nip, strain = result.in_nip, _web_strain(result)
    tractions = {"roll": result.roll_traction[nip], "drum": result.drum_traction[nip]}
    zones = {"roll": result.roll_zone[nip], "drum": result.drum_zone[nip]}
    return (
        *_pair_warnings(result, tractions),
        *_body_warnings(result),
        *_surface_strain_warnings(result, strain[nip]),
        *_web_warnings(result, strain),
        *zone_warnings(result.x[nip], zones),
        *_series_warning(result),
    )


def roller_warnings(result: RollerResult) -> tuple[str, ...]:
    """Return the warnings of rollers outside the validity limits, or on too coarse a mesh."""
    xi, mu = result.creepage, result.problem.friction  # xi is nan in static contact
    return (
        *_pair_warnings(result, {"upper": result.traction, "lower": -result.traction}),
        *limit_warning("creepage", xi, "the rollers' surface speeds differ by {}"),
        *(zone_warnings(result.x, {"contact": result.zone}, "the lower surface") if mu else ()),
    )


def _pair_warnings(
    result: NipResult | RollerResult, tractions: Mapping[str, Array]
) -> Iterator[str]:
    """Yield warnings about two bodies in contact outside the validity limits.

    Parameters
    ----------
    result : NipResult or RollerResult
    tractions : mapping of str to array
        On each body, by its name in the problem [Pa].
    """
    problem, a, approach = result.problem, result.half_width, result.approach
    radius = min(body.radius for body in problem.bodies)
    yield from limit_warning(
        "half width",
        a / radius,
        "the half width {0} is {} of the smaller radius",
        LENGTH.stored_text(a, ".3g"),
    )
    for name in problem.pair:
        body = getattr(problem, name)
        warnings = filter(None, (material.validity_warning for material in body.materials))
        yield from dict.fromkeys(f"the {name}: {text}" for text in warnings)
        yield from _frequency_warnings(name, body, problem.rolling_speed, a)
        if approach > LIMITS["indentation"].maximum * body.thickness:  # an upper bound
            depth = _indentation(result, body, tractions[name])
            yield from limit_warning(
                "indentation",
                depth / body.thickness,
                "the {0}'s indentation {1} is {} of its elastic layer, {2}",
                name,
                LENGTH.stored_text(depth, ".3g"),
                LENGTH.stored_text(body.thickness, ".3g"),
            )
        yield from _stiffness_warnings(name, body, float(result.peak_pressure), tractions[name])


def _frequency_warnings(
    name: str, body: Body, speed: float | None, half_width: float
) -> Iterator[str]:
    """Yield warnings about materials that were not measured at the frequencies of the nip.

    ``speed`` is the speed of rolling [m/s], None in static contact.
    """
    if speed is None:
        return
    frequency = abs(speed) / (2 * half_width)  # the lowest one of the pressure of a nip
    for low, high in dict.fromkeys(filter(None, (m.measured_frequencies for m in body.materials))):
        if not low <= frequency <= high:
            yield (
                f"the {name}'s moduli are known from {low:.3g} to {high:.3g} Hz and are "
                f"extrapolated: the nip contains frequencies from V/2a = {frequency:.3g} Hz on; "
                "measure at other temperatures too and shift the isotherms to one master curve "
                "(wo.master_curve), or measure to higher frequencies"
            )


def _indentation(result: NipResult | RollerResult, body: Body, traction: Array) -> float:
    """Return the indentation of a body of finite thickness in the middle of the nip [m].

    ``traction`` is that on the body at the nodes of the nip [Pa].
    """
    if not body.linear:
        return float(result.approach)  # an upper bound
    p, q = getattr(result, result.CONTACT_PRESSURE)[result.in_nip], traction
    speed = result.problem.rolling_speed
    mesh = nip_mesh(p.size, Wrap(), Wrap())  # without wraps, so that both faces are alike
    a, face = result.half_width, mesh.roll_face
    surface = body.surface(face, a, speed)
    slope, _ = surface.deform(p, q)
    v = face.displacement_at_nodes(slope, surface.end_displacement(p, q), a)
    return -float(np.interp(0.0, mesh.nodes, v))  # v is outward


def _stiffness_warnings(name: str, body: Body, peak: float, traction: Array) -> Iterator[str]:
    """Yield warnings about peak pressure and traction relative to the stiffness of a body.

    ``peak`` is the largest pressure, ``traction`` that at the nodes [Pa].
    """
    if body.surface_material is None:
        return
    stiffness = body.surface_material.stiffness
    modulus, shear = min(stiffness.rr, stiffness.tt), float(np.abs(traction).max())
    yield from limit_warning(
        "peak pressure",
        peak / modulus,
        "the peak pressure {0} is {} of the {1}'s stiffness {2}",
        STIFFNESS.stored_text(peak, ".3g"),
        name,
        STIFFNESS.stored_text(modulus, ".3g"),
    )
    yield from limit_warning(
        "shear strain",
        shear / stiffness.shear,
        "the {0}'s surface shear strain is {} at a traction of {1}",
        name,
        STIFFNESS.stored_text(shear, ".3g"),
    )


def _body_warnings(r: NipResult) -> Iterator[str]:
    """Yield the warnings of the bodies."""
    for name, body in (("roll", r.problem.roll), ("drum", r.problem.drum)):
        if body.validity_warning:
            yield f"of the {name}: {body.validity_warning}"


def _surface_strain_warnings(r: NipResult, web: Array) -> Iterator[str]:
    """Yield warnings about large surface strains; ``web`` is the strain of the web in the nip."""
    x = r.x[r.in_nip]
    for (name, strain), body in zip(
        _body_surface_strains(r, web).items(), r.problem.bodies, strict=True
    ):
        if not body.rigid:
            k = int(np.abs(strain).argmax())
            yield from limit_warning(
                "surface strain",
                float(strain[k]),
                "the {0}'s surface strain is {} at x = {1}",
                name,
                LENGTH.stored_text(x[k], ".3g"),
            )


def _body_surface_strains(r: NipResult, web: Array) -> dict[str, Array]:
    """Return the surface strains of the bodies at the points of the slip velocities (eq. 133).

    ``web`` is the strain of the web in the nip.  The strain of the roll is relative to that at the
    trailing edge.
    """
    nip = r.in_nip
    web = np.interp(r.slip_x[nip], r.x[nip], web)
    roll = web - r.roll_slip[nip]
    return {"roll": roll - roll[-1], "drum": web + r.drum_creepage - r.drum_slip[nip]}


def _web_strain(r: NipResult) -> Array:
    """Return the strain of the web (thesis eq. 72) at all nodes, (N,)."""
    web = r.problem.web
    c = web.compliance
    p = r.roll_pressure
    return c.c11 / web.thickness * r.tension - c.c12 * p


def _web_warnings(r: NipResult, strain: Array) -> Iterator[str]:
    """Yield warnings about pressure, strain, thickness and slackness of the web.

    ``strain`` is that of the web at all nodes.
    """
    web, peak = r.problem.web, float(r.drum_pressure.max())
    modulus = web.radial_modulus(peak)
    yield from limit_warning(
        "pressure on the web",
        peak / modulus,
        "the peak pressure {0} is {} of the web's radial stiffness {1}",
        STIFFNESS.stored_text(peak, ".3g"),
        STIFFNESS.stored_text(modulus, ".3g"),
    )
    k = int(np.abs(strain).argmax())
    yield from limit_warning(
        "web strain",
        float(strain[k]),
        "the web's strain is {} at a tension of {0}",
        TENSION.stored_text(r.tension[k]),
    )
    yield from limit_warning(
        "web thickness",
        web.thickness / r.nip_width,
        "the web's thickness {0} is {} of the nip width {1}",
        THICKNESS.stored_text(web.thickness, ".3g"),
        LENGTH.stored_text(r.nip_width, ".3g"),
    )
    min_tension = float(np.min(r.tension))
    if min_tension < 0:
        x = LENGTH.stored_text(r.x[int(np.argmin(r.tension))], ".3g")
        tensions = min_tension, r.problem.web_tension - min_tension
        least, needed = map(TENSION.stored_text, tensions)
        yield (
            f"the web is slack: its tension falls to {least} at x = {x}; at least {needed} of web "
            "tension are needed"
        )


def web_far_outside(problem: NipProblem, width: float) -> Iterator[str]:
    """Yield a text for each quantity of the web that is far outside the validity limits.

    Parameters
    ----------
    problem : NipProblem
    width : float
        Approximate nip width [m].
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
            f"this is far outside the model: a nip width of about {width:.2g} m is negligible next "
            f"to the thickness of the web, {web.thickness:.2g} m; take a larger load or a smaller "
            "web tension"
        )


def _series_warning(r: NipResult) -> Iterator[str]:
    """Yield a warning if the Fourier series of a body is truncated too early."""
    if r.series_error > SERIES_ERROR:
        yield (
            f"{RESOLUTION}the series of an elastic layer is truncated with an error of "
            f"{r.series_error:.2g} after {r.series_terms} terms"
        )
