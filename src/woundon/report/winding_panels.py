"""The panels of a winding."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import isfinite

import numpy as np

from ..roll.result import RollResult
from ..winding.margins import Margin
from ..winding.result import WindingResult
from . import roll_panels
from .drives_report import power_panel, torque_panel
from .lane_panels import lane_panels
from .panels import LINES, SERIES, Area, Axis, Curve, Mark, Panel, PanelMaker
from .report_parts import quantity_of
from .roll_panels import (
    cut_above,
    disc_of,
    hoop_stress_at,
    over_radius,
    radii_between,
    scale_of,
    with_compression,
)
from .winder_panel import between_panel, winder_panel

__all__ = ["winding_panels"]

Array = np.ndarray
STAGES = 6  # drawn, of which the last is the finished roll
# A hoop stress is drawn up to so many times the depth of the compression.
ABOVE, BELOW = 2.5, 1.2
GAP = 0.1  # between the discs of a growing roll, of the last radius
MOST, LEAST = 1.05, -0.15  # of the reserves that are drawn; LEAST where none is negative
DEEPEST = -2.0  # a reserve below this is drawn here: the others would be pressed together
WITHOUT_FRICTION = -1.0  # drawn in place of an infinite reserve
BAR = 0.12  # of a reserve at the core alone, of the build-up


def winding_panels(result: WindingResult) -> dict[str, PanelMaker]:
    """Return the panels of a winding, over the radius.

    - tension: T_in, NIT and WOT, the nips that were solved as dots
    - reserves: reserve of each margin
    - pressure, hoop_stress: at stages of the build-up, the later the darker
    - compression: the part of the hoop stress that is compressive (if asked for)
    - hardness, loads: modulus of the roll, nip load and winding force (if asked for)
    - disc, hoop_disc: the roll from its side, coloured by pressure and hoop stress (if asked for)
    - film: its pressure as it grows, on one scale (if asked for)
    - those of the lanes across the width, with a thickness profile (:mod:`.lane_panels`)
    - winder: roll, drums and rider of a two-drum winder to scale
    - between: tensions of the web between its nips
    - torque, power: of the drives of core and drums, with a width and a speed (if asked for)
    """
    of_roll = roll_panels.roll_panels(result.roll)
    panels = {
        "tension": PanelMaker(tension),
        "reserves": PanelMaker(reserves),
        "pressure": PanelMaker(pressure),
        "hoop_stress": PanelMaker(hoop_stress),
        "compression": PanelMaker(OfRoll(roll_panels.compression), by_default=False),
        "loads": PanelMaker(loads, by_default=False),
        "hardness": PanelMaker(OfRoll(roll_panels.hardness), by_default=False),
        "disc": PanelMaker(OfRoll(roll_panels.disc), by_default=False, slow=True),
        "hoop_disc": PanelMaker(OfRoll(roll_panels.hoop_disc), by_default=False, slow=True),
        "film": PanelMaker(film, by_default=False, slow=True),
        **lane_panels(result),
    }
    if result.drum_drive is not None or result.core_drive is not None:
        panels["torque"] = PanelMaker(torque_panel, by_default=False)
        panels["power"] = PanelMaker(power_panel, by_default=False)
    if result.problem.winder is not None:
        panels["winder"] = PanelMaker(winder_panel)
    if result.front is not None:
        panels["between"] = PanelMaker(between_panel)
    if not result.problem.has_nip:
        del panels["loads"]
    if "compression" not in of_roll:
        del panels["compression"]
    return panels


@dataclass(frozen=True)
class OfRoll:
    """Makes a panel of the finished roll from the winding; instances of one ``make`` are equal."""

    make: Callable[[RollResult], Panel]

    def __call__(self, result: WindingResult) -> Panel:
        """Return the panel of a winding's roll."""
        return self.make(result.roll)


# ---- schedules and tensions ---------------------------------------------------------------------


def tension(result: WindingResult) -> Panel:
    """Return the panel of web tension, nip-induced and wound-on tension, the nips as dots."""
    r = result.radius
    curves = [
        Curve.of_output(result, "wound_on_tension", r, label="wound on"),
        Curve.of_output(result, "web_tension", r, label="web", colour="drum", line="dashed"),
        Curve.of_output(
            result, "nip_induced_tension", r, label="by the nip", colour="green", line="dotted"
        ),
        Curve(
            "nip_wound_on_tension",
            result.nip_radius,
            result.nip_wound_on_tension,
            label="solved nips",
            line="none",
            marker="point",
            in_legend=False,
        ),
    ]
    if not result.problem.has_nip:  # the wound-on tension is the web tension
        curves = curves[:1]
    y = Axis("Tension", quantity_of(result, "wound_on_tension"), from_zero=True)
    return over_radius(r, "tension", "Tension over the radius", y, curves, height=3.0)


def loads(result: WindingResult) -> Panel:
    """Return the panel of nip load and winding force."""
    r = result.radius
    has_winder = result.problem.winder is not None
    load, force = ("rear drum",) * 2 if has_winder else ("nip load", "winding force")
    curves = [
        Curve.of_output(result, "nip_load", r, label=load),
        Curve.of_output(result, "winding_force", r, label=force, colour="drum", line="dashed"),
    ]
    if has_winder:
        loads = result.problem.drum_loads(r)
        curves += [
            Curve("", r, loads.front_load, "P_2", "front drum", "green"),
            Curve("", r, loads.rider_load, "P_3", "rider", "purple"),
            Curve("", r, loads.front_force, "F_2", "front drum", "ink", "dotted"),
        ]
    y = Axis("Load", quantity_of(result, "nip_load"))
    return over_radius(r, "loads", "Nip load and winding force", y, curves)


# ---- stages of the build-up ---------------------------------------------------------------------


def _stages(result: WindingResult) -> list[RollResult]:
    """Return the roll at evenly spaced stages of its build-up; the last is the finished one."""
    core, radius = float(result.radius[0]), float(result.radius[-1])
    surfaces = np.linspace(core, radius, STAGES + 1)[1:-1].tolist()  # between core and full radius
    return [*(result.roll.at(surface) for surface in surfaces), result.roll]


def _curves_of_stages(result: WindingResult, name: str) -> tuple[Curve, ...]:
    """Return an output at the stages of the build-up, the later the darker.

    Of several results the finished rolls are compared.
    """
    stages, symbol = _stages(result), quantity_of(result.roll, name).symbol
    labels = [f"stage {k}" for k in range(1, len(stages))]
    labels[-1] = "earlier stages"  # one entry of the legend for all of them
    curves = []
    for k, (roll, label) in enumerate(zip(stages, [*labels, "finished roll"], strict=True), 1):
        r, finished = radii_between(roll), k == len(stages)
        values = np.asarray(roll.at_radius(r)[name])
        curve = Curve(
            name,
            r,
            values,
            symbol,
            label,
            opacity=k / len(stages),
            width=2.0 if finished else 1.0,
            alone=not finished,
            in_legend=k >= len(labels),
        )
        curves.append(curve)
    return tuple(curves)


def pressure(result: WindingResult) -> Panel:
    """Return the panel of the pressure at stages of the build-up."""
    y = Axis("Pressure $P$", quantity_of(result.roll, "pressure"), from_zero=True)
    place = {"column": "right", "height": 3.0}
    curves = _curves_of_stages(result, "pressure")
    return over_radius(result.radius, "pressure", "Pressure", y, curves, **place)


def hoop_stress(result: WindingResult) -> Panel:
    """Return the panel of the hoop stress at stages of the build-up, compression shaded."""
    lowest, values = result.roll.least_hoop_stress, hoop_stress_at(result.roll)
    cut = cut_above(lowest, values, BELOW, ABOVE)
    y = Axis("Hoop stress $sigma_t$", quantity_of(result.roll, "hoop_stress"), cut=cut)
    curves = _curves_of_stages(result, "hoop_stress")
    panel = over_radius(result.radius, "hoop_stress", "Hoop stress", y, curves, height=3.0)
    depth = np.full(2, BELOW * min(lowest, 0.0))
    # the stress differs between the stages: all of the negative range from core to surface
    ends = result.radius[[0, -1]]
    shade = Area("compression", ends, low=depth, high=0 * depth, shade="drum")
    return with_compression(panel, shade)


def film(result: WindingResult) -> Panel:
    """Return the panel of the growing roll as a row of discs on one scale of the pressure."""
    stages, discs, left = _stages(result), [], 0.0
    for roll in stages:
        discs.append(disc_of(roll, "pressure", left))
        left += 2 * float(roll.radius[-1]) + GAP * float(result.radius[-1])
    highest = max(stages, key=lambda roll: roll.peak_pressure)
    return Panel(
        "film",
        Axis("Radius", quantity_of(result.roll, "radius")),
        Axis(""),
        title="Pressure in the growing roll",
        discs=tuple(discs),
        scale=scale_of(highest, "pressure", "Pressure $P$"),
        width=11.0,
        height=2.6,
    )


# ---- margins ------------------------------------------------------------------------------------


def reserves(result: WindingResult) -> Panel:
    """Return the panel of the reserves, their smallest values as circles, red below zero."""
    margins, r = result.margins, result.radius[[0, -1]]  # of core and surface
    checked = [margin.reserve for margin in margins if margin.checked]
    reserves_drawn = (m if isfinite(m) else WITHOUT_FRICTION for m in checked)
    deepest = min(reserves_drawn, default=0.0)
    low = max(1.2 * deepest, DEEPEST) if deepest < 0 else LEAST
    curves: list[Curve] = []
    for k, margin in enumerate(margins):  # more than there are colours
        if margin.checked:
            colour, line = SERIES[k % len(SERIES)], LINES[k // len(SERIES)]
            curves += _curves_of_margin(margin, colour, line, low, float(r[1]))
    return over_radius(
        r,
        "reserves",
        "Reserves of the margins",
        Axis("Reserve, share of the limit", limits=(low, MOST)),
        curves,
        areas=(Area("", r, low=np.full(2, low), high=np.zeros(2), shade="alarm"),),
        marks=(Mark("x", 0.0, "limit", colour="alarm", written=True, alone=False),),
        height=3.0,
    )


def _curves_of_margin(
    margin: Margin, colour: str, line: str, low: float, surface: float
) -> list[Curve]:
    """Return the reserve of a margin over the radius, at least ``low``, and its smallest value."""
    r, reserve = margin.over_radius, margin.reserve_of(margin.values)
    words = margin.name.replace("_", " ")
    if r.size == 1:  # of the core alone
        r, reserve = np.array([r[0], r[0] + BAR * (surface - r[0])]), np.repeat(reserve, 2)
    smallest = np.clip(np.array([margin.reserve]), low, MOST)
    return [
        # larger ones leave the panel, whose axis ends at MOST
        Curve(
            margin.name, r, np.clip(reserve, low, 2 * MOST), label=words, colour=colour, line=line
        ),
        Curve(
            margin.name,
            np.array([margin.radius]),
            smallest,
            label=f"smallest reserve, {words}",
            colour=colour if margin.ok else "alarm",
            line="none",
            marker="circle",
            in_legend=False,
        ),
    ]
