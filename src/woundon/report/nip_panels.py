"""The panels of a winding nip, its wraps, its air film and the layers of its roll."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..errors import unwarned
from ..nip.layer_slip import LayerSlip, friction_limit, interior_stress, wound_in_pressure
from ..nip.result import NipResult
from ..nip.roll_contact import nip_nodes
from ..nip.roller_result import RollerResult
from ..results import zone_runs
from .moduli_panels import moduli
from .panels import Area, Axis, Contour, Curve, Map, Mark, Panel, PanelMaker, Scale, Strip
from .report_parts import friction_bounds, quantity_of, zone_strips

__all__ = ["along_contact", "bounds_of_friction", "nip_panels", "zones_panel"]

Array = np.ndarray

DEPTHS, PLACES = 40, 301  # of the map of the shear between layers: numbers of z and of x
LEAST_EXCESS = 1.0  # [Pa], end of the colour scale where no layer slips
UNKNOWN = "no interior stresses of this roll"


def nip_panels(result: NipResult) -> dict[str, PanelMaker]:
    """Return the panels of a nip (thesis Fig. 15).

    - tractions: q+ and q- over the shaded bounds +-mu+ p and +-mu- p
    - slips: v+ and v-, and the web tension on the right
    - zones: at roll and drum
    - pressure, tension: alone, if asked for
    - air_film: film of entrained air between web and roll, if asked for
    - layer_slip, layer_shear: if asked for, the shear between the layers of the roll less what
      friction carries over x and depth, and its largest values over the depth

    - moduli: with a viscoelastic body, its moduli over the frequency with V/2a, if asked for

    With a wrap, over the distance from the nip as an angle, on a logarithmic scale:

    - wrap_tension: the web tension
    - wrap_pressure: the pressure on the body and |q|/mu, the pressure that its traction requires

    With further nips:

    - contacts_tension: the web tension along the roll through all nips, over the angle
    """
    panels = {
        "tractions": PanelMaker(tractions),
        "slips": PanelMaker(slips),
        "zones": PanelMaker(zones),
        "pressure": PanelMaker(pressure, by_default=False),
        "tension": PanelMaker(tension, by_default=False),
    }
    if result.air is not None:
        panels["air_film"] = PanelMaker(air_film, by_default=False)
    if result.problem.viscoelastic:
        panels["moduli"] = PanelMaker(moduli, by_default=False)
    if result.problem.is_wrapped:
        panels["wrap_tension"] = PanelMaker(wrap_tension)
        panels["wrap_pressure"] = PanelMaker(wrap_pressure)
    if result.problem.next_nips:
        panels["contacts_tension"] = PanelMaker(contacts_tension)
    return {
        **panels,
        "layer_slip": PanelMaker(layer_slip, by_default=False, slow=True),
        "layer_shear": PanelMaker(layer_shear, by_default=False, slow=True),
    }


# ---- along the contact --------------------------------------------------------------------------


def along_contact(result: NipResult | RollerResult, contact: str) -> Axis:
    """Return the axis along a contact, somewhat wider than it."""
    edge = 1.03 * result.half_width
    label = f"Position along the {contact} $x$"
    return Axis(label, quantity_of(result, "x"), limits=(-edge, edge))


def bounds_of_friction(
    result: NipResult | RollerResult, labels: Mapping[str, str]
) -> tuple[Area, ...]:
    """Return the friction bounds in the contact, the wider one first.

    ``labels`` are the symbols of the bounds by the name of the traction.
    """
    nip = result.in_nip
    bounds = [(labels[name], bound[nip]) for name, bound in friction_bounds(result).items()]
    bounds.sort(key=lambda bound: -float(np.max(bound[1])))
    return tuple(
        Area(label, result.x[nip], -bound, bound, f"shade{k}", symmetrical=True)
        for k, (label, bound) in enumerate(bounds)
    )


def zones_panel(result: NipResult | RollerResult, contact: str, height: float) -> Panel:
    """Return the panel of the stick and slip zones.

    ``contact`` is the word for the contact in the label of the axis, and the column of the figure.
    """
    known = zone_strips(result)
    assert known is not None  # results of these two kinds have zones
    strips = [Strip(face, tuple(zone_runs(known.x, each))) for face, each in known.faces.items()]
    return Panel(
        "zones",
        along_contact(result, contact),
        Axis(""),
        title="Zones",
        strips=tuple(strips),
        words=(known.slower, "stick", known.faster),
        column=contact,
        height=height,
    )


def zones(result: NipResult) -> Panel:
    """Return the panel of the zones at roll and drum."""
    return zones_panel(result, "nip", height=0.5)


def _in_nip(result: NipResult, name: str, label: str, colour: str, line: str = "solid") -> Curve:
    """Return the curve of an output between the edges of the nip; texts as of :class:`.Curve`."""
    x = result.slip_x if name.endswith("_slip") else result.x
    return Curve.of_output(result, name, x, label, colour, line, nodes=result.in_nip)


def _panel(
    result: NipResult, name: str, title: str, y: Axis, curves: Sequence[Curve], **others: Any
) -> Panel:
    """Return a panel along the nip; ``others`` are further fields of the panel."""
    x = along_contact(result, "nip")
    return Panel(name, x, y, title, curves=tuple(curves), column="nip", **others)


def tractions(result: NipResult) -> Panel:
    """Return the panel of the tractions over their bounds."""
    wrapped = result.problem.is_wrapped
    labels = {
        "roll_traction": "mu+ p+" if wrapped else "mu+ p",
        "drum_traction": "mu- p-" if wrapped else "mu- p",
    }
    return _panel(
        result,
        "tractions",
        "Tangential tractions and friction bounds",
        Axis("Tangential traction $q$", quantity_of(result, "roll_traction")),
        [
            _in_nip(result, "roll_traction", label="on roll", colour="roll"),
            _in_nip(result, "drum_traction", label="on drum", colour="drum", line="dashed"),
        ],
        areas=bounds_of_friction(result, labels),
    )


def slips(result: NipResult) -> Panel:
    """Return the panel of the slips with the web tension on the right."""
    return _panel(
        result,
        "slips",
        "Slip and web tension in the nip",
        Axis("Relative slip speed $v$", quantity_of(result, "roll_slip")),
        [
            _in_nip(result, "roll_slip", label="at roll", colour="roll"),
            _in_nip(result, "drum_slip", label="at drum", colour="drum", line="dashed"),
            replace(_in_nip(result, "tension", label="", colour="web", line="dashdot"), right=True),
        ],
        right=Axis("Web tension $T$", quantity_of(result, "tension")),
        height=2.8,
    )


def pressure(result: NipResult) -> Panel:
    """Return the panel of the pressure in the nip; with a wrap, on roll and drum."""
    if result.problem.is_wrapped:
        curves = [
            _in_nip(result, "roll_pressure", label="on roll", colour="roll"),
            _in_nip(result, "drum_pressure", label="on drum", colour="drum", line="dashed"),
        ]
    else:  # both faces have the same pressure
        curves = [_in_nip(result, "drum_pressure", label="in the nip", colour="web")]
    y = Axis("Pressure $p$", quantity_of(result, "drum_pressure"), from_zero=True)
    return _panel(result, "pressure", "Pressure", y, curves)


def tension(result: NipResult) -> Panel:
    """Return the panel of the web tension in the nip."""
    y = Axis("Web tension $T$", quantity_of(result, "tension"))
    curve = _in_nip(result, "tension", label="", colour="web")
    return _panel(result, "tension", "Web tension in the nip", y, [curve])


def air_film(result: NipResult) -> Panel:
    """Return the panel of the entrained air between web and roll."""
    x = result.x[result.in_nip]
    curve = Curve.of_output(result, "air.thickness", x, label="between web and roll")
    y = Axis("Air film $h$", quantity_of(result, "air.thickness"), from_zero=True)
    return _panel(result, "air_film", "Air film in the nip", y, [curve])


# ---- the wraps ----------------------------------------------------------------------------------


def _wraps(result: NipResult) -> list[tuple[str, Array, slice]]:
    """Return (name, angles from the first nip [rad], slice of the nodes) of its wraps."""
    problem, nip, a, x = result.problem, result.in_nip, result.half_width, result.x
    faces = []
    if problem.roll_wrap:
        nips = nip_nodes(result)
        downstream = slice(nip.stop, nips[1].start if len(nips) > 1 else None)
        faces.append(("roll", (x[downstream] - a) / problem.roll.radius, downstream))
    if problem.drum_wrap:
        upstream = slice(0, nip.start)
        faces.append(("drum", (-a - x[upstream]) / problem.drum.radius, upstream))
    return faces


def _angle_axis(result: NipResult) -> Axis:
    """Return the logarithmic axis of the angle from the nip."""
    angle = quantity_of(result, "slip_angle")
    return Axis("Angle from the edge of the nip $theta$", angle, log=True)


def wrap_tension(result: NipResult) -> Panel:
    """Return the panel of the tension on roll and drum, with the wound-on tension."""
    T = quantity_of(result, "tension")
    lines = {"roll": "dashdot", "drum": "dotted"}
    curves = [
        Curve(
            "tension",
            angle,
            result.tension[nodes],
            symbol=T.symbol,
            label=f"on {face}",
            colour="web",
            line=lines[face],
        )
        for face, angle, nodes in _wraps(result)
    ]
    marks = []
    if result.problem.roll_wrap:
        WOT = quantity_of(result, "wound_on_tension").symbol
        marks.append(Mark("x", result.wound_on_tension, label="wound-on tension", symbol=WOT))
        if result.slip_angle:
            marks.append(Mark("y", result.slip_angle, label="end of slip", colour="roll"))
    return Panel(
        "wrap_tension",
        _angle_axis(result),
        Axis("Web tension $T$", T),
        title="Web tension on the wraps",
        curves=tuple(curves),
        marks=tuple(marks),
        column="wraps",
        width=6.1,
    )


def contacts_tension(result: NipResult) -> Panel:
    """Return the panel of the web tension along the roll, with the nips and the zones of stick."""
    on_roll = slice(result.in_nip.start, None)
    theta = result.x[on_roll] / result.problem.roll.radius
    T, sticks = result.tension[on_roll], result.roll_zone[on_roll] == 0
    tension, WOT = quantity_of(result, "tension"), quantity_of(result, "wound_on_tension")
    curves = (
        Curve(
            "tension",
            theta,
            T,
            symbol=tension.symbol,
            label="slips on the roll",
            colour="web",
            line="dashed",
        ),
        Curve(
            "tension",
            theta,
            np.where(sticks, T, np.nan),
            symbol=tension.symbol,
            label="sticks to the roll",
            colour="roll",
        ),
    )
    marks = [Mark("x", result.wound_on_tension, label="wound-on tension", symbol=WOT.symbol)]
    marks += [
        Mark("y", contact.angle, label="" if k else "nips", line="dotted", alone=False)
        for k, contact in enumerate(result.contacts)
    ]
    return Panel(
        "contacts_tension",
        Axis("Angle from the first nip $theta$", quantity_of(result, "slip_angle")),
        Axis("Web tension $T$", tension),
        title="Web tension through all nips",
        curves=curves,
        marks=tuple(marks),
        column="wraps",
        width=6.1,
    )


def wrap_pressure(result: NipResult) -> Panel:
    """Return the panel of the pressure on roll and drum, and that required by the traction."""
    problem, curves = result.without_air, []  # friction as the air film leaves it
    for face, angle, nodes in _wraps(result):
        if face == "roll":
            sign, friction, lines = "+", problem.friction_on_wrap, ("solid", "dotted")
        else:
            sign, friction, lines = "-", problem.drum_friction, ("dashed", "dashdot")
        present = getattr(result, f"{face}_pressure")[nodes]
        required = np.abs(getattr(result, f"{face}_traction")[nodes]) / friction
        label = f"$|q{sign}|/mu{sign}$"
        curves += [
            Curve(
                f"{face}_pressure", angle, present, symbol=f"p{sign}", colour=face, line=lines[0]
            ),
            Curve(f"{face}_traction", angle, required, label=label, colour=face, line=lines[1]),
        ]
    return Panel(
        "wrap_pressure",
        _angle_axis(result),
        Axis("Pressure $p$", quantity_of(result, "drum_pressure")),
        title="Pressure on the wraps",
        curves=tuple(curves),
        column="wraps",
        width=6.1,
        height=3.3,
    )


# ---- the layers of the roll ---------------------------------------------------------------------


def _layer_slip_of(result: NipResult) -> LayerSlip | None:
    """Return the layer-slip index without its warning; None without interior stresses."""
    with unwarned():
        return result.layer_slip


def _depth_axis(result: NipResult, slip: LayerSlip | None) -> Axis:
    """Return the axis of the depth, which points down: its limits descend."""
    depth = quantity_of(result, "half_width")
    if slip is None:
        return Axis("Depth $z$", depth)
    limits = (_deepest(slip), float(slip.interface_depth[0]))
    return Axis("Depth $z$", depth, log=True, limits=limits)


def _deepest(slip: LayerSlip) -> float:
    """Return the largest depth of the panels [m].

    It is 1.5 times the depth of slip, but at least 8 times that of the first interface, and not
    below the last one.
    """
    deepest, preferred = float(slip.interface_depth[-1]), 1.5 * slip.depth
    return min(deepest, max(preferred, 8 * float(slip.interface_depth[0])))


def layer_slip(result: NipResult) -> Panel:
    """Return the panel of |tau| - mu (P0 + p) over x and depth, with the boundary of slip."""
    slip, stress = _layer_slip_of(result), quantity_of(result, "drum_pressure")
    panel = Panel(
        "layer_slip",
        Axis("Position along the nip $x$", quantity_of(result, "x")),
        _depth_axis(result, slip),
        title="Shear between the layers beyond friction",
        note=UNKNOWN if slip is None else "",
        width=6.6,
        height=3.6,
    )
    if slip is None:
        return panel
    x, z, excess = _excess_below(result, slip)
    top = float(max(excess.max(), LEAST_EXCESS))
    scale = Axis("Excess $|tau| - mu(P_0 + p)$", stress, limits=(-top, top))
    reach, a = float(x[-1]), result.half_width
    return replace(
        panel,
        x=Axis(panel.x.label, panel.x.quantity, limits=(-reach, reach)),
        map=Map(x, z, excess, (Contour(0.0, "boundary of slip"),)),
        scale=Scale(scale, "red above", clipped="lower"),  # values may be below -top
        marks=tuple(Mark("y", edge, line="dotted", alone=False) for edge in (-a, a)),
    )


def _excess_below(result: NipResult, slip: LayerSlip) -> tuple[Array, Array, Array]:
    """Return x (n,), z (m,) and the excess of the shear (m, n), around the slipping layers."""
    z = np.geomspace(slip.interface_depth[0], _deepest(slip), DEPTHS)
    reach = max(0.6 * slip.width, 2 * result.half_width)
    # the spacing is 10 times closer in the middle than at the ends: stresses vary most in the nip
    x = reach * np.sinh(np.linspace(-3, 3, PLACES)) / np.sinh(3)
    sections = interior_stress(result, z) or ()
    P0 = wound_in_pressure(result, z)
    excess = [
        np.interp(x, s.x, np.abs(s.shear) - friction_limit(result, P - s.normal))
        for s, P in zip(sections, P0, strict=True)
    ]
    return x, z, np.array(excess)


def layer_shear(result: NipResult) -> Panel:
    """Return the panel of the largest shear, the friction limit and the excess over the depth."""
    slip, stress = _layer_slip_of(result), quantity_of(result, "drum_pressure")
    curves: tuple[Curve, ...] = ()
    if slip is not None:
        z = slip.interface_depth
        curves = (
            Curve("layer_slip", slip.largest_shear, z, label="$max|tau|$", colour="roll"),
            Curve(
                "layer_slip",
                slip.friction_limit,
                z,
                label="$mu(P_0 + max p)$",
                colour="drum",
                line="dashed",
            ),
            Curve(
                "layer_slip", slip.excess, z, label="largest excess", colour="web", line="dashdot"
            ),
        )
    return Panel(
        "layer_shear",
        Axis("Stress", stress),
        _depth_axis(result, slip),
        title="Shear and friction between the layers",
        curves=curves,
        marks=(Mark("y", 0.0, alone=False),),
        note=UNKNOWN if slip is None else "",
        width=5.4,
        height=3.6,
    )
