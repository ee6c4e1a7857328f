"""The assumptions of the models, as sentences, for each kind of problem."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from .bending import bends
from .paths import quantity_of_field

__all__ = ["of_nip", "of_roll", "of_rollers", "of_winding"]

PLANE = "Steady state, small strains, plane strain."
FRICTION = "Coulomb friction with constant coefficients."
UNIFORM = "The web has a uniform thickness and tension across its width."
UNIFORM_THICKNESS = "The web has a uniform thickness across its width."
UNLOADED_THICKNESS = "The web thickness is that without pressure, as caliper_pressure is not given."
CALIPER_THICKNESS = "The web thickness is that under the caliper pressure."
LANE = "The thickest lane does not change the stresses in the rest of the roll."
BEAMS = (
    "Drums and core of given flexural rigidity bend under their nip load as beams on two bearings."
)
LANES = "The lanes across the width share the web and the drum, without shear between them."
ROTATION = (
    "The roll is wound at a constant web speed and then stops; the core does not expand by its own "
    "centrifugal force."
)
STILL_LANES = "The lanes across the width are those of a web without centrifugal force."
CHANGES = "Temperature, moisture and shrinkage change the finished roll at once, without creep."
RELEASED = (
    "The core is removed at once; layers that are relieved follow the law of the stack back: its "
    "hysteresis, by which the pressure would fall faster, is neglected."
)
BONDED = "The layers of the roll are bonded: they do not slip on each other."
AIR = (
    "The air film is isothermal, as wide as the web, and escapes only through the web; friction "
    "falls linearly with its thickness."
)
# sizes: an estimate with slip planes between the layers and the moduli of newsprint
BONDED_ON_DRUMS = (
    "The layers of the roll are bonded: below the outer layer, on which all nips act, none slips. "
    "Slipping layers would be moved by each nip, the outer one by 5 to 20 N/m in each pass, the "
    "second one by up to 90 N/m (an estimate)."
)
BALANCE = (
    "The forces on the roll are in balance: the web leaves the rear drum along its common tangent "
    "with the roll, the rider idles, and rolling resistance is neglected (about 1 N/m of elastic "
    "drums and roll; slip between layers would add 0.5 to 2 % of the loads)."
)
WRAPPED = "The web is held to the roll at the end of the roll wrap."
NO_WRAP = (
    "The web is held to the roll at the trailing edge of the nip and does not slip downstream."
)


def of_nip(problem: Any) -> tuple[str, ...]:
    """Return the assumptions of a nip."""
    names = {f"next_nips.{k}.drum": f"drum of nip {k + 2}" for k in range(len(problem.next_nips))}
    bodies = (
        text
        for name, body in problem.named_bodies.items()
        for text in _body(names.get(name, name), body)
    )
    web = "linear elastic" if problem.web.linear else "a stack that hardens under pressure"
    return (
        PLANE,
        FRICTION,
        UNIFORM,
        f"The web is a thin strip, {web}.",
        *bodies,
        BONDED,
        WRAPPED if problem.roll_wrap else NO_WRAP,
        *([AIR] if problem.air is not None else []),
        *_centrifugal(problem, low=problem.web_tension, high=problem.web_tension),
    )


def of_rollers(problem: Any) -> tuple[str, ...]:
    """Return the assumptions of two rollers."""
    state = "Steady rolling" if problem.motion == "rolling" else "A static load, applied once"
    bodies = (
        text
        for name in ("upper", "lower")
        for text in _body(f"{name} roller", getattr(problem, name))
    )
    return f"{state}, small strains, plane strain.", FRICTION, *bodies


def _body(name: str, body: Any) -> Iterator[str]:
    """Yield the assumptions on a body."""
    if body.rigid:
        yield f"The {name} is rigid."
    elif getattr(body, "viscoelastic", False):
        yield f"The {name} is linear viscoelastic."
    elif body.linear:
        yield f"The {name} is linear elastic: its moduli do not depend on the pressure."
    else:
        yield f"The {name} hardens under wound-in and nip pressure, without hysteresis."


def _across(problem: Any, uniform: str) -> str:
    """Return the assumption on the thickness across the width; ``uniform`` for an even web."""
    if problem.thickness_profile is not None:
        return LANES
    return uniform if problem.gauge_excess == 0 else LANE


def of_roll(problem: Any) -> tuple[str, ...]:
    """Return the assumptions of a wound roll."""
    axisymmetric = "The roll is axisymmetric, its layers in static equilibrium and elastic."
    return (
        axisymmetric,
        _across(problem, UNIFORM_THICKNESS),
        UNLOADED_THICKNESS if problem.caliper_pressure is None else CALIPER_THICKNESS,
        "The radial stiffness depends on the pressure alone, loading and unloading alike.",
        "The layers neither slip nor creep.",
        *_changes(problem),
        *_rotation(problem),
        *([RELEASED] if problem.core_removed else []),
    )


ROLL_BODIES = {
    "effective": "In the nip the roll is linear, with its moduli at the pressure of wound roll "
    "and nip: the wound-on tension is within 7 % of that of roll_body = 'direct'.",
    "direct": "In the nip the roll hardens under the pressure wound in and that of the nip.",
    "linear": "In the nip the roll is linear, with the moduli of the web.",
}
LAWS = {
    "friction": "The web slips throughout the nip: WOT = T_in + F + mu P.",
    "fixed": "The nip-induced tension is given.",
}
WITHOUT_NIP = "The web is wound without a nip: WOT = T_in."
FOIL_FILM = (
    "The web runs onto the roll as a foil bearing: h = 0.643 R (12 eta V/(T - m V^2))^(2/3), "
    "less what escapes through the web in one revolution."
)
FULL_SLIP_ON_DRUMS = (
    "The web slips throughout all nips: WOT = T_in + F + mu P downstream of the rear drum, and "
    "of each further nip WOT exp(-mu theta) + F + mu P if that is larger, theta the arc "
    "upstream of it."
)


def of_winding(problem: Any) -> tuple[str, ...]:
    """Return the assumptions of a winding."""
    law = problem.tension_law
    tensions = problem.at("web_tension", problem.radii(2))  # at core, surface and all kinks
    if problem.solves_nips:
        drum = "The drum is rigid." if problem.drum.rigid else ""
        assumptions = (
            PLANE,
            FRICTION,
            ROLL_BODIES[problem.roll_body],
            *filter(None, [drum]),
            BONDED if problem.winder is None else BONDED_ON_DRUMS,
        )
    else:
        text = LAWS.get(law, "") if isinstance(law, str) else ""
        if law == "friction" and problem.winder is not None:
            text = FULL_SLIP_ON_DRUMS
        if law in ("nip", "friction") and not problem.has_nip:
            text = WITHOUT_NIP
        assumptions = (text or "The wound-on tension is given over the radius.",)
    return (
        *assumptions,
        *(() if problem.winder is None else (BALANCE,)),
        "The roll is axisymmetric, its layers elastic, and without creep.",
        UNLOADED_THICKNESS if problem.caliper_pressure is None else CALIPER_THICKNESS,
        _across(problem, UNIFORM),
        *([BEAMS] if bends(problem) else []),
        *([AIR] if problem.air is not None else []),
        *([FOIL_FILM] if problem.air is not None and not problem.has_nip else []),
        *_centrifugal(problem, low=float(tensions.min()), high=float(tensions.max())),
        *_changes(problem),
        *_rotation(problem),
        *([RELEASED] if problem.core_removed else []),
    )


def _changes(problem: Any) -> list[str]:
    """Return the assumption on the strains of the finished roll, if there are any."""
    return [CHANGES] if problem.is_strained else []


def _rotation(problem: Any) -> Iterator[str]:
    """Yield the assumptions on the rotation of a roll whose web has a centrifugal force."""
    if not problem.centrifugal_tension:
        return
    yield ROTATION
    if problem.thickness_profile is not None:
        yield STILL_LANES


REFERENCE_MASS = 0.01  # of a web of unknown density: m V^2 for each 10 g/m^2 [kg/m^2]


def _centrifugal(problem: Any, low: float, high: float) -> Iterator[str]:
    """Yield the part m V^2 of the tension of a web whose speed is given.

    On a curved path with the radius R the web, of the mass m per area, presses with
    (T - m V^2)/R on what it is wrapped on.  It is neglected if the density is not given.

    Parameters
    ----------
    problem : NipProblem or WindingProblem
    low, high : float
        Smallest and largest web tension [N/m].
    """
    V = problem.web_speed
    if not V:
        return
    speed, tension = (quantity_of_field(problem, name) for name in ("web_speed", "web_tension"))
    if problem.density is None:
        each = f"{tension.text(REFERENCE_MASS * V**2, '.3g')} of the tension for each 10 g/m^2"
        yield (
            f"The centrifugal force of the web is neglected: at {speed.text(V)} it takes m V^2 = "
            f"{each} (the density is not known)."
        )
        return
    force = problem.centrifugal_tension
    text = f"At {speed.text(V)} the centrifugal force of the web takes m V^2 = "
    text += f"{tension.text(force, '.3g')} of the tension"
    if low > 0:
        least, most = f"{100 * force / high:.2g}", f"{100 * force / low:.2g}"
        text += f", {least if least == most else f'{least} to {most}'} % of the web tension"
    yield f"{text}."
