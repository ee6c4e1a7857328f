"""The panels of the lanes across the width of the web, of a roll or a winding."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..quantities import Quantity
from ..roll.lane_roll import LANE_QUANTITIES, POSITION, edges_of_lanes
from ..roll.result import RollResult
from .panels import (
    Axis,
    Curve,
    Limits,
    Map,
    Mark,
    Panel,
    PanelMaker,
    Scale,
    round_at_most,
    with_margin,
)
from .report_parts import quantity_of

__all__ = ["lane_panels"]

Array = np.ndarray
RADII = 200  # of a map
# Part of the build-up, from the surface, over which the hardness across the width is averaged: a
# tester that strikes the surface feels the layers below it.
STRUCK = 0.1
DRAWN = 0.15  # height of the largest ridge in the drawing of the roll, of its radius
MARGIN = 0.06  # below and above curves, of their range
EVEN = (1e-3, 1e-6)  # ends of the axes of thickness [1] and ridges [m] that are zero everywhere
GAP = 0.06  # of the width, between the end of the roll and the bar of the scale
# Symbol, label and colour of the loads of several nips, and of several deflections.
DRUMS = {
    "nip_load": ("P_1", "rear drum", "roll"),
    "front_load": ("P_2", "front drum", "green"),
    "rider_load": ("P_3", "rider", "purple"),
}
DEFLECTIONS = {
    "drum_deflection": ("w_d", "drum", "roll"),
    "core_deflection": ("w_c", "core", "drum"),
    "front_deflection": ("w_2", "front drum", "green"),
    "rider_deflection": ("w_3", "rider", "purple"),
}


def lane_panels(result: Any) -> dict[str, PanelMaker]:
    """Return the panels of the lanes; none without a thickness profile.

    - thickness_across: thickness of the lanes relative to the mean, and the ridges
    - lane_pressure, lane_tension: maps over the position across the web and the radius
    - roll_surface: the roll from the front, its ridges enlarged, with a scale
    - hardness_across: modulus through the stack below the surface, as a hardness tester measures it
    - nip_load_across: loads of the nips on the lanes of the finished roll, if nips are solved
    - deflection_across: deflection of drums and core under these loads, if they are beams
    """
    if result.problem.thickness_profile is None:
        return {}
    panels = {
        "lane_pressure": PanelMaker(lane_pressure),
        "lane_tension": PanelMaker(lane_tension),
        "roll_surface": PanelMaker(roll_surface),
        "thickness_across": PanelMaker(thickness_across),
        "hardness_across": PanelMaker(hardness_across),
        "nip_load_across": PanelMaker(nip_load_across),
        "deflection_across": PanelMaker(deflection_across),
    }
    if not any(name in result.lanes for name in DEFLECTIONS):
        del panels["deflection_across"]
    if np.isnan(result.lanes.nip_load.values).any():
        del panels["nip_load_across"]
    return panels


def _to_edges(lanes: Any) -> Array:
    """Return the positions of the L lanes between those of the edges of the web, (L + 2,) [m]."""
    y = lanes.position.values
    left, *_, right = edges_of_lanes(y)
    return np.concatenate([[left], y, [right]])


def _across(lanes: Any) -> Axis:
    """Return the axis across the web."""
    left, *_, right = _to_edges(lanes).tolist()
    return Axis("Position across the web $y$", POSITION, limits=(left, right))


def _panel(name: str, title: str, lanes: Any, y: Axis, **others: Any) -> Panel:
    """Return a panel over the position across the web."""
    place = {"column": "across", "height": 2.6, **others}
    return Panel(name, _across(lanes), y, title, **place)


def thickness_across(result: Any) -> Panel:
    """Return the panel of the thickness of the lanes, and of the ridges of the finished roll."""
    lanes = result.lanes
    y, share = lanes.position.values, Quantity("d", "1", "thickness above the mean", "%")
    excess, ridge = lanes.thickness_excess.values, lanes.ridge_height.values[-1]
    left, right = _with_one_zero(excess, ridge)
    curves = (
        Curve("thickness_excess", y, excess, "d", "thickness"),
        Curve(
            "ridge_height",
            y,
            ridge,
            label="ridges",
            colour="drum",
            line="dashed",
            right=True,
        ),
    )
    return _panel(
        "thickness_across",
        "Thickness profile and ridges",
        lanes,
        Axis("Thickness above the mean $d$", share, limits=left),
        right=Axis("Height of the ridges", LANE_QUANTITIES["ridge_height"], limits=right),
        curves=curves,
        marks=(Mark("x", 0.0, alone=False),),
    )


def _with_one_zero(*curves: Array) -> list[Limits]:
    """Return the ends of the axes of thickness and ridges, with their zeros at one height.

    The largest deviation of each curve has the same length on its axis; of a curve that is zero
    everywhere, the axis has the length in EVEN.
    """
    sizes = [float(np.max(np.abs(curve))) or even for curve, even in zip(curves, EVEN, strict=True)]
    parts = np.concatenate([curve / size for curve, size in zip(curves, sizes, strict=True)])
    low, high = with_margin(parts, MARGIN)
    return [(low * size, high * size) for size in sizes]


def lane_pressure(result: Any) -> Panel:
    """Return the map of the pressure over position and radius."""
    title, label = "Pressure in the roll across the width", "Pressure $P$"
    return _map(result, "lane_pressure", title=title, output="pressure", label=label)


def lane_tension(result: Any) -> Panel:
    """Return the map of the wound-on tension over position and radius."""
    title, label = "Wound-on tension across the width", "Wound-on tension"
    return _map(result, "lane_tension", title=title, output="wound_on_tension", label=label)


def _map(result: Any, name: str, title: str, output: str, label: str) -> Panel:
    """Return the map of a variable of the lanes over position and radius.

    ``name`` and ``title`` are those of the panel, ``output`` is the variable, ``label`` that of the
    scale of its colours.
    """
    lanes, quantity = result.lanes, LANE_QUANTITIES[output]
    r = np.linspace(float(lanes.radius.values[0]), float(lanes.radius.values[-1]), RADII)
    # at even radii, (RADII, lanes)
    values = np.array([np.interp(r, lanes.radius.values, row) for row in lanes[output].values.T]).T
    limits = (float(values.min()) if output != "pressure" else 0.0, float(values.max()))
    if limits[1] <= limits[0] * (1 + 1e-9):  # all values equal, as of lanes of equal thickness
        limits = (0.0, limits[1])
    radius = Axis("Radius $r$", quantity_of(RollResult, "radius"), limits=(r[0], r[-1]))
    return _panel(
        name,
        title,
        lanes,
        radius,
        # the outer lanes up to the edges of the web
        map=Map(_to_edges(lanes), r, np.pad(values, ((0, 0), (1, 1)), mode="edge")),
        scale=Scale(Axis(label, quantity, limits=limits)),
        column="lanes",
        height=2.8,
    )


def roll_surface(result: Any) -> Panel:
    """Return the drawing of the roll from the front, with the ridges of its surface enlarged."""
    lanes = result.lanes
    inner = "bore" if result.problem.core_removed else "core"
    R = float(lanes.radius.values[-1])
    core, ridge = float(lanes.radius.values[0]), lanes.ridge_height.values[-1]
    # ridges are enlarged, but never reduced
    factor = round_at_most(max(DRAWN * R / max(float(np.max(np.abs(ridge))), 1e-12), 1.0))
    surface = R + factor * ridge
    ends, outline = _to_edges(lanes), np.pad(surface, 1, mode="edge")
    left, right = float(ends[0]), float(ends[-1])
    # a bar as high as the largest ridge, with its true height, inside the drawing
    height = float(np.max(np.abs(ridge)))
    bar = right - GAP * (right - left)
    quantity = LANE_QUANTITIES["ridge_height"]
    curves = [
        Curve("surface", ends, outline, label="surface"),
        Curve("surface", ends, -outline, in_legend=False),
        Curve("", np.full(2, left), np.array([-1, 1]) * outline[0], in_legend=False),
        Curve("", np.full(2, right), np.array([-1, 1]) * outline[-1], in_legend=False),
        Curve("", ends[[0, -1]], np.full(2, R), "", "mean", colour="soft", line="dotted"),
        Curve("", ends[[0, -1]], np.full(2, -R), colour="soft", line="dotted", in_legend=False),
        Curve("", ends[[0, -1]], np.full(2, core), "", inner, colour="ink", line="dashed"),
        Curve("", ends[[0, -1]], np.full(2, -core), colour="ink", line="dashed", in_legend=False),
        Curve(
            "",
            np.full(2, bar),
            np.array([-0.5, 0.5]) * factor * height,
            label=f"scale: {quantity.text(height, '.3g')}",
            colour="drum",
            width=3.0,
        ),
    ]
    return Panel(
        "roll_surface",
        _across(lanes),
        Axis(f"Radius, ridges {factor:g} times larger", quantity_of(RollResult, "radius")),
        f"Surface of the roll, ridges enlarged {factor:g} times",
        curves=tuple(curves),
        column="lanes",
        height=3.4,
    )


def hardness_across(result: Any) -> Panel:
    """Return the panel of the modulus below the surface, averaged over a part of the build-up."""
    lanes = result.lanes
    r, stack = lanes.radius.values, result.roll.problem.stack
    start = r[-1] - STRUCK * (r[-1] - r[0])
    points = np.linspace(start, r[-1], 50)
    pressure = np.array([np.interp(points, r, row) for row in lanes.pressure.values.T])
    hardness = np.trapezoid(stack.radial.modulus(pressure), points) / (r[-1] - start)
    quantity = quantity_of(RollResult, "radial_modulus")
    depth = quantity_of(RollResult, "radius").text(float(r[-1] - start), ".3g")
    return _panel(
        "hardness_across",
        f"Hardness across the width, mean of the outer {depth}",
        lanes,
        Axis("Hardness $E_r$", quantity, from_zero=True),
        curves=(Curve("hardness", lanes.position.values, hardness, quantity.symbol),),
    )


def nip_load_across(result: Any) -> Panel:
    """Return the panel of the loads of the nips on the lanes of the finished roll."""
    title, y = "Nip load on the lanes of the finished roll", "Nip load $P$"
    return _of_drums(result, "nip_load_across", title, y, DRUMS)


def deflection_across(result: Any) -> Panel:
    """Return the panel of the deflection of drums and core under the load of the finished roll."""
    title, y = "Deflection under the load on the finished roll", "Deflection $w$"
    return _of_drums(result, "deflection_across", title, y, DEFLECTIONS)


def _of_drums(
    result: Any, name: str, title: str, label: str, drums: Mapping[str, tuple[str, str, str]]
) -> Panel:
    """Return the panel of variables of drums on the lanes of the finished roll.

    ``drums`` has their names with symbol, label and colour; the load of one nip alone is not
    labelled.
    """
    lanes, curves = result.lanes, []
    variables = [variable for variable in drums if variable in lanes]
    for variable in variables:
        symbol, label_of_drum, colour = drums[variable]
        if variables == ["nip_load"]:
            symbol, label_of_drum = LANE_QUANTITIES[variable].symbol, ""
        values = lanes[variable].values[-1]
        curves.append(Curve(variable, lanes.position.values, values, symbol, label_of_drum, colour))
    y = Axis(label, LANE_QUANTITIES[variables[0]], from_zero=True)
    return _panel(name, title, lanes, y, curves=tuple(curves))
