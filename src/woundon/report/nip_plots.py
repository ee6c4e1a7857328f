"""The panels of a winding nip and its wraps."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ..nip.result import NipResult
from ..quantities import Quantity
from .figures import (
    COLOURS,
    along_contact,
    axis_label,
    draw_zones,
    quantity_of,
    text_of,
)
from .layer_slip_plots import LAYER_SLIP
from .panels import NEUTRAL, Case, Panel
from .report_parts import nip_zones

__all__ = ["draw_slips", "nip_panels"]

Array = np.ndarray
Cases = Sequence[Case]
Handles = list[Any]

ROLL, DRUM, TENSION = COLOURS[0], COLOURS[1], NEUTRAL
ROLL_BOUND, DRUM_BOUND = "#DDDDDD", "#B5B5B5"


# ---- the nip ------------------------------------------------------------------------------------


def nip_panels(result: NipResult) -> dict[str, Panel]:
    """Return the panels of a nip (thesis Fig. 15).

    - tractions: q+ and q- over the shaded bounds +-mu+ p and +-mu- p
    - slips: v+ and v-, and the web tension on the right
    - zones: at roll and drum
    - pressure, tension: alone, if asked for
    - layer_slip, layer_shear: if asked for, the shear between the layers of the roll less what
      friction carries over x and depth, and its largest values over the depth

    With a wrap, over the distance from the nip as an angle, on a logarithmic scale:

    - wrap_tension: the web tension
    - wrap_pressure: the pressure on the body and |q|/mu, the pressure that its traction requires

    """
    wraps = WRAPS if result.problem.is_wrapped else {}
    return {**NIP, **wraps, **LAYER_SLIP}


def draw_tractions(axes: Axes, cases: Cases) -> Handles:
    """Plot q+ and q- of nips along x; a single nip with shaded friction bounds."""
    x, q = (quantity_of(cases[0].result, name) for name in ("x", "roll_traction"))
    handles: Handles = []
    for case in cases:
        result, nip = case.result, case.result.in_nip
        at = x.shown(result.x[nip])
        shades = _draw_bounds(axes, result, x, q) if case.alone else []
        (roll,) = axes.plot(at, q.shown(result.roll_traction[nip]), color=case.colour_or(ROLL))
        (drum,) = axes.plot(
            at, q.shown(result.drum_traction[nip]), "--", color=case.colour_or(DRUM)
        )
        roll.set_label("$q^{+}$ on roll")
        drum.set_label("$q^{-}$ on drum")
        handles = handles or [roll, drum, *shades]
    axes.set_ylabel(axis_label("Tangential traction $q$", q))
    _format_x_axis(axes, cases)
    return handles


def _draw_bounds(axes: Axes, result: NipResult, x: Quantity, q: Quantity) -> Handles:
    """Shade the friction bounds, the narrower one on top."""
    problem, nip = result.without_air, result.in_nip
    wrapped = problem.is_wrapped
    bounds = [
        (problem.roll_friction, result.roll_pressure[nip], ROLL_BOUND, "+"),
        (problem.drum_friction, result.drum_pressure[nip], DRUM_BOUND, "-"),
    ]
    shades: Handles = []
    for mu, p, colour, sign in sorted(bounds, key=lambda bound: -bound[0]):
        label = rf"$\pm\mu^{{{sign}}}p{f'^{{{sign}}}' if wrapped else ''}$"
        high = q.shown(mu * p)
        at = x.shown(result.x[nip])
        shades.append(axes.fill_between(at, -high, high, color=colour, linewidth=0, label=label))
    return shades


def draw_slips(axes: Axes, cases: Cases) -> Handles:
    """Plot the slips v+ and v- of nips along x and, on the right, the web tension."""
    names = ("x", "roll_slip", "tension")
    x, v, T = (quantity_of(cases[0].result, name) for name in names)
    handles: Handles = []
    tension_axes = axes.twinx()
    for case in cases:
        result, nip = case.result, case.result.in_nip
        at, slip_at = x.shown(result.x[nip]), x.shown(result.slip_x[nip])
        (roll,) = axes.plot(slip_at, v.shown(result.roll_slip[nip]), color=case.colour_or(ROLL))
        (drum,) = axes.plot(
            slip_at, v.shown(result.drum_slip[nip]), "--", color=case.colour_or(DRUM)
        )
        (tension,) = tension_axes.plot(
            at, T.shown(result.tension[nip]), "-.", color=case.colour_or(TENSION)
        )
        roll.set_label("$v^{+}$ at roll")
        drum.set_label("$v^{-}$ at drum")
        tension.set_label("$T$ (right axis)")
        handles = handles or [roll, drum, tension]
    axes.set_ylabel(axis_label("Relative slip speed $v$", v))
    tension_axes.set_ylabel(axis_label("Web tension $T$", T))
    tension_axes.grid(visible=False)
    _format_x_axis(axes, cases)
    return handles


def _draw_pressure(axes: Axes, cases: Cases) -> Handles:
    return _draw_array(axes, cases, "drum_pressure", "Pressure $p$", DRUM)


def _draw_tension(axes: Axes, cases: Cases) -> Handles:
    return _draw_array(axes, cases, "tension", "Web tension $T$", TENSION)


def _draw_array(axes: Axes, cases: Cases, name: str, words: str, colour: str) -> Handles:
    """Plot one array between the edges of the nip."""
    x, y = (quantity_of(cases[0].result, output) for output in ("x", name))
    for case in cases:
        nip = case.result.in_nip
        values = getattr(case.result, name)[nip]
        axes.plot(x.shown(case.result.x[nip]), y.shown(values), color=case.colour_or(colour))
    axes.set_ylabel(axis_label(words, y))
    _format_x_axis(axes, cases)
    return []


def _draw_zones(axes: Axes, cases: Cases) -> Handles:
    """Plot the stick and slip zones of nips."""
    strips, colours = [nip_zones(case.result) for case in cases], [case.colour for case in cases]
    handles = draw_zones(axes, strips, quantity_of(cases[0].result, "x"), colours)
    _format_x_axis(axes, cases)
    return list(handles)


def _format_x_axis(axes: Axes, cases: Cases) -> None:
    along_contact(axes, [case.result for case in cases], "nip")


NIP = {
    "tractions": Panel(draw_tractions, "nip"),
    "slips": Panel(draw_slips, "nip", height=2.8),
    "zones": Panel(_draw_zones, "nip", height=0.5, strip=True),
    "pressure": Panel(_draw_pressure, "nip", by_default=False),
    "tension": Panel(_draw_tension, "nip", by_default=False),
}


# ---- the wraps ----------------------------------------------------------------------------------


def _draw_wrap_tension(axes: Axes, cases: Cases) -> Handles:
    """Plot the tension on roll and drum, over the angle from the nip."""
    T = quantity_of(cases[0].result, "tension")
    handles: Handles = []
    for case in cases:
        result, curves = case.result, []
        for face, theta, nodes in _wraps(result):
            line, label = ("-.", "$T$ on roll") if face == "roll" else (":", "$T$ on drum")
            (curve,) = axes.plot(
                theta,
                T.shown(result.tension[nodes]),
                line,
                color=case.colour_or(TENSION),
                label=label,
            )
            curves.append(curve)
        marks = _mark_wound_on(axes, result, T) if case.alone and result.problem.roll_wrap else []
        handles = handles or [*curves, *marks]
    axes.set_ylabel(axis_label("Web tension $T$", T))
    _format_angle_axis(axes, cases)
    return handles


def _mark_wound_on(axes: Axes, result: NipResult, T: Quantity) -> Handles:
    """Mark the wound-on tension, in the unit of its axis, and the end of the slip zone."""
    WOT, symbol = result.wound_on_tension, quantity_of(result, "wound_on_tension").symbol
    label = f"{symbol} {text_of(T, WOT, '.5g')}"
    marks: Handles = [axes.axhline(T.shown(WOT), color="#888888", linewidth=0.8, label=label)]
    if result.slip_angle:
        end = quantity_of(result, "slip_angle").shown(result.slip_angle)
        marks.append(axes.axvline(end, color=ROLL, linewidth=0.8, label="end of slip"))
    return marks


def _draw_wrap_pressure(axes: Axes, cases: Cases) -> Handles:
    """Plot the pressure on roll and drum, and the pressure required by the traction."""
    p = quantity_of(cases[0].result, "drum_pressure")
    handles: Handles = []
    for case in cases:
        curves, result = [], case.result
        for face, theta, nodes in _wraps(result):
            roll = face == "roll"
            sign, colour, lines = ("+", ROLL, "-:") if roll else ("-", DRUM, ("--", "-."))
            problem = result.without_air
            friction = problem.friction_on_wrap if roll else problem.drum_friction
            present = (result.roll_pressure if roll else result.drum_pressure)[nodes]
            required = np.abs(getattr(result, f"{face}_traction")[nodes]) / friction
            required_label = rf"$|q^{{{sign}}}|/\mu^{{{sign}}}$"
            for values, line, label in zip(
                (present, required), lines, (f"$p^{{{sign}}}$", required_label), strict=True
            ):
                curves += axes.plot(
                    theta, p.shown(values), line, color=case.colour_or(colour), label=label
                )
        handles = handles or curves
    axes.set_ylabel(axis_label("Pressure $p$", p))
    _format_angle_axis(axes, cases)
    return handles


def _wraps(result: NipResult) -> list[tuple[str, Array, slice]]:
    """Return the faces on which the web is wrapped: angles from the nip as displayed, nodes."""
    problem, nip, a = result.problem, result.in_nip, result.half_width
    angle, x = quantity_of(result, "slip_angle"), result.x
    faces = []
    if problem.roll_wrap:
        downstream = slice(nip.stop, None)
        faces.append(("roll", angle.shown((x[downstream] - a) / problem.roll.radius), downstream))
    if problem.drum_wrap:
        upstream = slice(0, nip.start)
        faces.append(("drum", angle.shown((-a - x[upstream]) / problem.drum.radius), upstream))
    return faces


def _format_angle_axis(axes: Axes, cases: Cases) -> None:
    """Label the axis of the angle from the nip, which is logarithmic."""
    angle = quantity_of(cases[0].result, "slip_angle")
    axes.set_xlabel(axis_label(r"Angle from the edge of the nip $\theta$", angle))
    axes.set_xscale("log")


WRAPS = {
    "wrap_tension": Panel(_draw_wrap_tension, "wraps", width=6.1),
    "wrap_pressure": Panel(_draw_wrap_pressure, "wraps", width=6.1, height=3.3),
}
