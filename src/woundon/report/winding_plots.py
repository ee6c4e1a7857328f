"""The panels of a winding."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ..quantities import Quantity
from ..roll.result import RollResult
from ..winding.result import WindingResult
from .figures import COLOURS, axis_label, quantity_of
from .margin_plots import Disc, colour_scale, draw_disc, draw_margins
from .panels import NEUTRAL, Case, Panel

__all__ = ["winding_panels"]

Cases = Sequence[Case]
STAGES = 6  # drawn, of which the last is the finished roll
POINTS = 601
ABOVE = 2.5  # times the depth of the compression
# (output, label of its curve, line style)
TENSIONS = (
    ("wound_on_tension", "wound on (WOT)", "-"),
    ("web_tension", "web ($T_{in}$)", "--"),
    ("nip_induced_tension", "by the nip (NIT)", ":"),
)


def winding_panels(result: WindingResult) -> dict[str, Panel]:
    """Return the panels of a winding, over the radius.

    - tension: T_in, NIT and WOT, the nips that were solved as dots
    - pressure, hoop_stress: at stages of the build-up, the later the darker
    - reserves: reserve of each margin
    - loads: nip load and winding force (if asked for)
    - disc, hoop_disc: the roll from its side, coloured by pressure and hoop stress (if asked for)
    - film: its pressure as it grows, on one scale (if asked for)
    """
    return {
        "tension": Panel(_draw_tension, "left", height=3.0),
        "reserves": Panel(_draw_margins, "left", height=3.0),
        "pressure": Panel(Stages("pressure", "Pressure $P$"), "right", height=3.0),
        "hoop_stress": Panel(Stages("hoop_stress", r"Hoop stress $\sigma_t$"), "right", height=3.0),
        "loads": Panel(_draw_loads, "left", height=2.6, by_default=False),
        "disc": Panel(Disc("pressure", "Pressure $P$", "roll"), "disc", 5.4, 4.4, by_default=False),
        "hoop_disc": Panel(
            Disc("hoop_stress", r"Hoop stress $\sigma_t$", "roll"),
            "hoop",
            5.4,
            4.4,
            by_default=False,
        ),
        "film": Panel(_draw_discs, "film", width=11.0, height=2.6, by_default=False),
    }


def _draw_tension(axes: Axes, cases: Cases) -> list[Any]:
    """Plot web tension, nip-induced and wound-on tension over the radius, the nips as dots."""
    r, tension = (quantity_of(cases[0].result, name) for name in ("radius", "wound_on_tension"))
    handles: list[Any] = []
    for case in cases:
        result, lines = case.result, []
        for (name, words, dashes), default in zip(TENSIONS, COLOURS, strict=False):
            (line,) = axes.plot(
                r.shown(result.radius),
                tension.shown(getattr(result, name)),
                dashes,
                label=words,
                color=case.colour_or(default),
            )
            lines.append(line)
        at_nips = tension.shown(result.nip_wound_on_tension)
        axes.plot(r.shown(result.nip_radius), at_nips, ".", color=case.colour_or(COLOURS[0]))
        handles = handles or lines
    axes.set_ylabel(axis_label("Tension", tension))
    axes.set_ylim(bottom=min(0, axes.get_ylim()[0]))
    _format_x_axis(axes, cases)
    return handles


def _draw_loads(axes: Axes, cases: Cases) -> list[Any]:
    """Plot nip load and winding force over the radius."""
    r, load = (quantity_of(cases[0].result, name) for name in ("radius", "nip_load"))
    handles: list[Any] = []
    for case in cases:
        x, result = r.shown(case.result.radius), case.result
        lines = [
            *axes.plot(
                x,
                load.shown(result.nip_load),
                color=case.colour_or(COLOURS[0]),
                label="nip load $P$",
            ),
            *axes.plot(
                x,
                load.shown(result.winding_force),
                "--",
                color=case.colour_or(COLOURS[1]),
                label="winding force $F$",
            ),
        ]
        handles = handles or lines
    axes.set_ylabel(axis_label("Load", load))
    _format_x_axis(axes, cases)
    return handles


def _draw_margins(axes: Axes, cases: Cases) -> list[Any]:
    """Plot the margins over the radius; each of several cases in its colour."""
    handles: list[Any] = []
    for case in cases:
        lines = draw_margins(axes, case.result.margins, case.colour)
        handles = handles or lines
    _format_x_axis(axes, cases)
    return handles if cases[0].alone else []


@dataclass(frozen=True)
class Stages:
    """An output of the growing roll over the radius; of several windings the finished rolls."""

    name: str
    words: str

    def __call__(self, axes: Axes, cases: Cases) -> list[Any]:
        """Plot the output at stages of the build-up."""
        quantity = quantity_of(cases[0].result.roll, self.name)
        for case in cases:
            colour, rolls = case.colour_or(COLOURS[0]), [case.result.roll]
            if case.alone:
                rolls = _stages(case.result)
            for k, roll in enumerate(rolls, 1):
                x, y = _curve(roll, self.name, quantity)
                axes.plot(
                    x, y, color=colour, alpha=k / len(rolls), linewidth=1.0 + (roll is rolls[-1])
                )
        axes.set_ylabel(axis_label(self.words, quantity))
        if self.name == "hoop_stress":
            _clip_above(axes, [quantity.shown(c.result.roll.least_hoop_stress) for c in cases])
        else:
            axes.set_ylim(bottom=0)
        _format_x_axis(axes, cases)
        return []


def _stages(result: WindingResult) -> list[RollResult]:
    """Return the roll at evenly spaced stages of its build-up."""
    core, radius = float(result.radius[0]), float(result.radius[-1])
    surfaces = np.linspace(core, radius, STAGES + 1)[1:-1].tolist()
    return [*(result.roll.at(s) for s in surfaces), result.roll]


def _curve(roll: RollResult, name: str, quantity: Quantity) -> tuple[Any, Any]:
    r = np.linspace(roll.radius[0], roll.radius[-1], POINTS)
    return quantity_of(roll, "radius").shown(r), quantity.shown(roll.at_radius(r)[name])


def _clip_above(axes: Axes, deepest: list[Any]) -> None:
    """Clip the axis of hoop stresses above, if those at the ends are many times larger."""
    axes.axhline(0, color=NEUTRAL, linewidth=0.8)
    low = min(deepest)
    if low < 0:
        axes.axhspan(1.2 * low, 0, color=COLOURS[1], alpha=0.08, linewidth=0)
        axes.set_ylim(1.2 * low, min(axes.get_ylim()[1], -ABOVE * low))


def _draw_discs(axes: Axes, cases: Cases) -> list[Any]:
    """Plot the pressure of the growing roll as a row of discs on one scale."""
    rolls = _stages(cases[0].result)
    r, quantity = (quantity_of(rolls[-1], name) for name in ("radius", "pressure"))
    low, high, colours = colour_scale(max(rolls, key=lambda roll: roll.peak_pressure), "pressure")
    place, room = 0.0, 0.1 * float(r.shown(rolls[-1].radius[-1]))
    for roll in rolls:
        R = float(r.shown(roll.radius[-1]))
        mesh = draw_disc(axes, roll, "pressure", (place + R, R), (low, high, colours))
        axes.text(place + R, -0.5 * room, f"{R:.3g}", ha="center", va="top")
        place += 2 * R + room
    figure = axes.get_figure()
    assert figure is not None
    figure.colorbar(mesh, ax=axes, label=axis_label("Pressure $P$", quantity), pad=0.01)
    axes.set_xlim(0, place - room)
    axes.set_aspect("equal")
    axes.set_axis_off()
    axes.text(0, 1.0, axis_label("radius", r), transform=axes.transAxes, va="top")
    return []


def _format_x_axis(axes: Axes, cases: Cases) -> None:
    """Label the axis of the radius from core to surface."""
    quantity = quantity_of(cases[0].result, "radius")
    axes.set_xlabel(axis_label("Radius $r$", quantity))
    radii = [quantity.shown(case.result.radius[k]) for case in cases for k in (0, -1)]
    axes.set_xlim(min(radii), max(radii))
