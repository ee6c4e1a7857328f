"""The panels of a two-drum winder: the winder to scale, and the web between its nips."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..problems.two_drums import TwoDrums
from ..problems.winding import WindingProblem
from ..quantities import value_of
from ..winding.result import WindingResult
from .panels import Axis, Curve, Panel, with_margin
from .report_parts import quantity_of
from .roll_panels import over_radius

__all__ = ["between_panel", "winder_panel"]

Array = np.ndarray
POINTS = 121  # of a circle
STRAIGHT = 1.2  # length of the web upstream of the rear drum, in radii of this drum
MARGIN = 0.04  # around the bodies, of the width of the drawing
WIDTH, TALLEST = 3.9, 4.0  # inches of the drawing, without its legend and the labels of its axes
LABELS = 0.6  # inches, below the drawing


def winder_panel(result: WindingResult) -> Panel:
    """Return the panel of a two-drum winder with the finished roll, and the core dashed."""
    problem, winder = result.problem, result.problem.winder
    assert winder is not None  # only windings with one have this panel
    rear, front = problem.drum_radius, winder.front_drum.radius
    core, radius = problem.ends
    first, last = (_centre(problem, r) for r in (core, radius))
    curves = [
        _circle("radius", last, radius, "wound roll"),
        _circle("core", first, core, "core at the start", line="dashed"),
        _circle("core", last, core, "", in_legend=False),
        _circle("drum", (0.0, 0.0), rear, "rear drum", colour="drum"),
        _circle("front_drum", (_apart(problem, winder), 0.0), front, "front drum", colour="green"),
    ]
    if winder.rider is not None:
        above = (last[0], last[1] + radius + winder.rider.radius)
        curves.append(_circle("rider", above, winder.rider.radius, "rider roll", colour="purple"))
    x, y = _web_path(problem, last)
    curves.append(Curve("web", x, y, label="web", colour="ink", width=2.4))
    size = quantity_of(result, "radius")
    x_ends, y_ends = (
        with_margin(np.concatenate(values), MARGIN)
        for values in ([c.x for c in curves], [c.y for c in curves])
    )
    return Panel(
        "winder",
        Axis("Horizontal", size, limits=x_ends),
        Axis("Vertical", size, limits=y_ends),
        title="Winder, to scale",
        curves=tuple(curves),
        to_scale=True,
        height=min(WIDTH * (y_ends[1] - y_ends[0]) / (x_ends[1] - x_ends[0]), TALLEST) + LABELS,
        legend="right",
    )


def between_panel(result: WindingResult) -> Panel:
    """Return the panel of the tensions of the web upstream of front drum and rider."""
    r = result.nip_radius
    curves = [
        Curve.of_output(result, "wound_on_tension", result.radius, label="wound on"),
        Curve.of_output(result, "web_tension", result.radius, "web", "drum", "dashed"),
    ]
    for name, words, colour in (("front", "front drum", "green"), ("rider", "rider", "purple")):
        nips = getattr(result, name)
        if nips is None:
            continue
        for kind, line in (("least", "dotted"), ("largest", "dashdot")):
            output = f"{name}.arc_{kind}_tension"
            label = f"{'smallest' if kind == 'least' else kind} before the {words}"
            values = value_of(result, output)
            curves.append(Curve(output, r, values, label=label, colour=colour, line=line))
    y = Axis("Tension", quantity_of(result, "wound_on_tension"), from_zero=True)
    title = "Tension between the nips"
    place: dict[str, Any] = {"column": "winder", "legend": "right"}  # below the drawing
    return over_radius(result.radius, "between", title, y, curves, height=3.0, **place)


def _circle(
    name: str,
    centre: tuple[float, float],
    radius: float,
    label: str,
    colour: str = "roll",
    line: str = "solid",
    in_legend: bool = True,
) -> Curve:
    """Return a circle with its centre and radius [m]; other arguments as of :class:`.Curve`."""
    angle = np.linspace(0, 2 * np.pi, POINTS)
    x, y = centre[0] + radius * np.cos(angle), centre[1] + radius * np.sin(angle)
    return Curve(name, x, y, label=label, colour=colour, line=line, in_legend=in_legend)


def _apart(problem: WindingProblem, winder: TwoDrums) -> float:
    """Return the distance of the centres of the drums [m]."""
    return problem.drum_radius + winder.front_drum.radius + winder.gap


def _centre(problem: WindingProblem, radius: float) -> tuple[float, float]:
    """Return the centre of the roll with a radius, relative to that of the rear drum [m]."""
    to_rear, angle = radius + problem.drum_radius, float(problem.drum_loads(radius).rear_angle)
    return to_rear * np.sin(angle), to_rear * np.cos(angle)


def _web_path(problem: WindingProblem, centre: tuple[float, float]) -> tuple[Array, Array]:
    """Return x and y of the web: straight, on the rear drum, and on the roll up to its top [m].

    Two (n,) arrays, in the direction of travel.
    The rear drum turns clockwise about the origin, the finished roll counterclockwise about its
    ``centre``.
    """
    drum, roll = problem.drum_radius, problem.radius
    nip = np.pi / 2 - float(problem.drum_loads(roll).rear_angle)  # direction of the roll's centre
    start = nip + problem.drum_wrap  # where the web reaches the drum
    on_drum = np.linspace(start, nip, POINTS)
    on_roll = np.linspace(nip - np.pi, np.pi / 2, POINTS)
    x = np.concatenate([drum * np.cos(on_drum), centre[0] + roll * np.cos(on_roll)])
    y = np.concatenate([drum * np.sin(on_drum), centre[1] + roll * np.sin(on_roll)])
    straight = STRAIGHT * drum
    return (
        np.append(drum * np.cos(start) - straight * np.sin(start), x),
        np.append(drum * np.sin(start) + straight * np.cos(start), y),
    )
