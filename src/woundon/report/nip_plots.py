"""The panels of a winding nip and its wraps."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ..nip.result import NipResult
from .figures import (
    COLOURS,
    along_contact,
    axis_label,
    display_values,
    draw_zones,
    quantity_of,
    unit_of,
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

    - tractions: q+ and q- over the shaded bounds +-mu+ p and +-mu- p [kPa]
    - slips: v+ and v- [%], and the web tension [N/m] on the right
    - zones: at roll and drum
    - pressure, tension: alone, if asked for
    - layer_slip, layer_shear: if asked for, the shear between the layers of the roll less what
      friction carries over x and depth [kPa], and its largest values over the depth

    With a wrap, over the distance from the nip as an angle [deg], on a logarithmic scale:

    - wrap_tension: the web tension
    - wrap_pressure: the pressure on the body and |q|/mu, the pressure that its traction requires
      [kPa]
    """
    wraps = WRAPS if result.problem.is_wrapped else {}
    return {**NIP, **wraps, **LAYER_SLIP}


def draw_tractions(axes: Axes, cases: Cases) -> Handles:
    """Plot q+ and q- of nips along x; a single nip with shaded friction bounds."""
    handles: Handles = []
    for case in cases:
        result, nip = case.result, case.result.in_nip
        x = display_values(result, "x")[nip]
        shades = _draw_bounds(axes, result) if case.alone else []
        (roll,) = axes.plot(
            x, display_values(result, "roll_traction")[nip], color=case.colour_or(ROLL)
        )
        (drum,) = axes.plot(
            x, display_values(result, "drum_traction")[nip], "--", color=case.colour_or(DRUM)
        )
        roll.set_label("$q^{+}$ on roll")
        drum.set_label("$q^{-}$ on drum")
        handles = handles or [roll, drum, *shades]
    quantity = quantity_of(cases[0].result, "roll_traction")
    axes.set_ylabel(axis_label("Tangential traction $q$", quantity))
    _format_x_axis(axes, cases)
    return handles


def _draw_bounds(axes: Axes, result: NipResult) -> Handles:
    """Shade the friction bounds, the narrower one on top."""
    problem, nip = result.without_air, result.in_nip
    x, on_drum = display_values(result, "x")[nip], display_values(result, "drum_pressure")[nip]
    wrapped, on_roll = problem.is_wrapped, display_values(result, "roll_pressure")[nip]
    bounds = [
        (problem.roll_friction, on_roll, ROLL_BOUND, "+"),
        (problem.drum_friction, on_drum, DRUM_BOUND, "-"),
    ]
    shades: Handles = []
    for mu, p, colour, sign in sorted(bounds, key=lambda bound: -bound[0]):
        label = rf"$\pm\mu^{{{sign}}}p{f'^{{{sign}}}' if wrapped else ''}$"
        shade = axes.fill_between(x, -mu * p, mu * p, color=colour, linewidth=0, label=label)
        shades.append(shade)
    return shades


def draw_slips(axes: Axes, cases: Cases) -> Handles:
    """Plot the slips v+ and v- of nips along x and, on the right, the web tension."""
    handles: Handles = []
    tension_axes = axes.twinx()
    for case in cases:
        result, nip = case.result, case.result.in_nip
        x, slip_x = display_values(result, "x")[nip], display_values(result, "slip_x")[nip]
        (roll,) = axes.plot(
            slip_x, display_values(result, "roll_slip")[nip], color=case.colour_or(ROLL)
        )
        (drum,) = axes.plot(
            slip_x, display_values(result, "drum_slip")[nip], "--", color=case.colour_or(DRUM)
        )
        T = display_values(result, "tension")[nip]
        (tension,) = tension_axes.plot(x, T, "-.", color=case.colour_or(TENSION))
        roll.set_label("$v^{+}$ at roll")
        drum.set_label("$v^{-}$ at drum")
        tension.set_label("$T$ (right axis)")
        handles = handles or [roll, drum, tension]
    first = cases[0].result
    axes.set_ylabel(axis_label("Relative slip speed $v$", quantity_of(first, "roll_slip")))
    tension_axes.set_ylabel(axis_label("Web tension $T$", quantity_of(first, "tension")))
    tension_axes.grid(visible=False)
    _format_x_axis(axes, cases)
    return handles


def _draw_pressure(axes: Axes, cases: Cases) -> Handles:
    return _draw_array(axes, cases, "drum_pressure", "Pressure $p$", DRUM)


def _draw_tension(axes: Axes, cases: Cases) -> Handles:
    return _draw_array(axes, cases, "tension", "Web tension $T$", TENSION)


def _draw_array(axes: Axes, cases: Cases, name: str, words: str, colour: str) -> Handles:
    """Plot one array between the edges of the nip."""
    for case in cases:
        nip = case.result.in_nip
        x, values = display_values(case.result, "x")[nip], display_values(case.result, name)[nip]
        axes.plot(x, values, color=case.colour_or(colour))
    axes.set_ylabel(axis_label(words, quantity_of(cases[0].result, name)))
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
    handles: Handles = []
    for case in cases:
        result = case.result
        T, curves = display_values(result, "tension"), []
        for face, theta, nodes in _wraps(result):
            line, label = ("-.", "$T$ on roll") if face == "roll" else (":", "$T$ on drum")
            (curve,) = axes.plot(theta, T[nodes], line, color=case.colour_or(TENSION), label=label)
            curves.append(curve)
        marks = _mark_wound_on(axes, result) if case.alone and result.problem.roll_wrap else []
        handles = handles or [*curves, *marks]
    axes.set_ylabel(axis_label("Web tension $T$", quantity_of(cases[0].result, "tension")))
    _format_angle_axis(axes, cases)
    return handles


def _mark_wound_on(axes: Axes, result: NipResult) -> Handles:
    """Mark the wound-on tension and the end of the slip zone."""
    WOT = quantity_of(result, "wound_on_tension")
    label = f"{WOT.symbol} {WOT.shown(result.wound_on_tension):.5g} {unit_of(WOT)}"
    marks: Handles = [
        axes.axhline(result.wound_on_tension, color="#888888", linewidth=0.8, label=label)
    ]
    if result.slip_angle:
        end = display_values(result, "slip_angle")
        marks.append(axes.axvline(end, color=ROLL, linewidth=0.8, label="end of slip"))
    return marks


def _draw_wrap_pressure(axes: Axes, cases: Cases) -> Handles:
    """Plot the pressure on roll and drum, and the pressure required by the traction."""
    handles: Handles = []
    for case in cases:
        curves, result = [], case.result
        for face, theta, nodes in _wraps(result):
            roll = face == "roll"
            sign, colour, lines = ("+", ROLL, "-:") if roll else ("-", DRUM, ("--", "-."))
            problem = result.without_air
            friction = problem.friction_on_wrap if roll else problem.drum_friction
            present = display_values(result, "roll_pressure" if roll else "drum_pressure")[nodes]
            required = np.abs(display_values(result, f"{face}_traction")[nodes]) / friction
            required_label = rf"$|q^{{{sign}}}|/\mu^{{{sign}}}$"
            for values, line, label in zip(
                (present, required), lines, (f"$p^{{{sign}}}$", required_label), strict=True
            ):
                curves += axes.plot(theta, values, line, color=case.colour_or(colour), label=label)
        handles = handles or curves
    axes.set_ylabel(axis_label("Pressure $p$", quantity_of(cases[0].result, "drum_pressure")))
    _format_angle_axis(axes, cases)
    return handles


def _wraps(result: NipResult) -> list[tuple[str, Array, slice]]:
    """Return the faces on which the web is wrapped: angles from the nip [deg], nodes."""
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
