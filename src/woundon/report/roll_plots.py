"""The panels of a wound roll."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ..problems.paths import field_quantity
from ..problems.roll import RollProblem
from ..roll.result import RollResult
from .figures import COLOURS, axis_label, quantity_of
from .margin_plots import Disc
from .panels import NEUTRAL, Case, Panel

__all__ = ["roll_panels"]

Cases = Sequence[Case]
Handles = list[Any]
POINTS = 801
ABOVE = 5  # times the depth of the compression


def roll_panels(result: RollResult) -> dict[str, Panel]:
    """Return the panels of a wound roll, over the radius.

    - pressure between the layers
    - hoop_stress along the web, compression shaded; cut off above where there is any
    - hardness: the modulus through the stack
    - tension: the wound-on tension, on the stages of the build-up
    - density of the wound layers, and as a density analyser on the winder draws it, where the
      web's density is given
    - residual_tension of the layers, and their outward displacement since they were wound (if
      asked for)
    - disc, hoop_disc: the roll from its side, coloured by pressure and hoop stress (if asked for)
    """
    return {
        "pressure": Panel(OverRadius("pressure", "Pressure $P$"), "left", height=2.8),
        "hardness": Panel(OverRadius("radial_modulus", "Hardness $E_r$"), "left", height=2.6),
        "hoop_stress": Panel(_draw_hoop, "right", height=2.8),
        "tension": Panel(_draw_tension, "right", height=2.6),
        "residual_tension": Panel(_draw_residual, "right", height=2.8, by_default=False),
        "density": Panel(
            _draw_density, "left", height=2.6, by_default=result.problem.density is not None
        ),
        "displacement": Panel(
            OverRadius("displacement", "Displacement $u$"), "left", height=2.6, by_default=False
        ),
        "disc": Panel(
            Disc("pressure", "Pressure $P$"), "disc", width=5.4, height=4.4, by_default=False
        ),
        "hoop_disc": Panel(
            Disc("hoop_stress", r"Hoop stress $\sigma_t$"),
            "hoop",
            width=5.4,
            height=4.4,
            by_default=False,
        ),
    }


@dataclass(frozen=True)
class OverRadius:
    """An output over the radius."""

    name: str
    words: str

    def __call__(self, axes: Axes, cases: Cases) -> Handles:
        """Plot the output over the radius."""
        r, quantity = (quantity_of(cases[0].result, name) for name in ("radius", self.name))
        for case in cases:
            x, y = r.shown(case.result.radius), quantity.shown(getattr(case.result, self.name))
            axes.plot(x, y, color=case.colour_or(COLOURS[0]))
        axes.set_ylabel(axis_label(self.words, quantity))
        _format_x_axis(axes, cases)
        if all((getattr(case.result, self.name) > -1e-9).all() for case in cases):
            axes.set_ylim(bottom=0)
        return []


def _draw_hoop(axes: Axes, cases: Cases) -> Handles:
    return _draw_over_radius(axes, cases, "hoop_stress", r"Hoop stress $\sigma_t$")


def _draw_residual(axes: Axes, cases: Cases) -> Handles:
    return _draw_over_radius(axes, cases, "residual_tension", "Residual tension of the layers")


def _draw_over_radius(axes: Axes, cases: Cases, name: str, words: str) -> Handles:
    """Plot a stress or tension of the layers over the radius, compression shaded."""
    radius, quantity = (quantity_of(cases[0].result, output) for output in ("radius", name))
    handles: Handles = []
    axes.axhline(0, color=NEUTRAL, linewidth=0.8)
    for case in cases:
        result = case.result
        # between the nodes too, which are few
        r = np.linspace(result.radius[0], result.radius[-1], POINTS)
        x = radius.shown(r)
        times = _thickness(result, name)
        hoop = quantity.shown(times * result.at_radius(r)["hoop_stress"])
        (line,) = axes.plot(x, hoop, color=case.colour_or(COLOURS[0]), label=words)
        if case.alone:
            handles = [line, *_shade_compression(axes, x, hoop)]
    axes.set_ylabel(axis_label(words, quantity))
    _format_x_axis(axes, cases)
    deepest = quantity.shown(
        min(_thickness(case.result, name) * case.result.least_hoop_stress for case in cases)
    )
    if deepest < 0:  # without the wound-on stress at both ends, many times that inside
        axes.set_ylim(1.3 * deepest, min(axes.get_ylim()[1], -ABOVE * deepest))
    return handles


def _thickness(result: RollResult, name: str) -> float:
    return float(result.problem.web_thickness) if name == "residual_tension" else 1.0


def _draw_density(axes: Axes, cases: Cases) -> Handles:
    """Plot the density of the finished roll and that as wound."""
    handles = []
    r, density = (quantity_of(cases[0].result, name) for name in ("radius", "density"))
    for case in cases:
        x = r.shown(case.result.radius)
        for name, style, words in (
            ("density", "-", "in the roll"),
            ("density_as_wound", "--", "as wound"),
        ):
            colour = case.colour_or(COLOURS[0 if name == "density" else 1])
            values = density.shown(getattr(case.result, name))
            (line,) = axes.plot(x, values, style, color=colour, label=words)
            handles += [line] if case.alone else []
    axes.set_ylabel(axis_label("Density", density))
    _format_x_axis(axes, cases)
    return handles


def _shade_compression(axes: Axes, x: np.ndarray, hoop: np.ndarray) -> Handles:
    """Shade the region of hoop compression; return its legend entry."""
    if not (hoop < 0).any():
        return []
    shade = axes.fill_between(x, np.minimum(hoop, 0), 0, color=COLOURS[1], alpha=0.2, linewidth=0)
    shade.set_label("compression")
    return [shade]


def _draw_tension(axes: Axes, cases: Cases) -> Handles:
    """Plot the wound-on tension over the radius."""
    quantity = field_quantity(RollProblem, "wound_on_tension")
    assert quantity is not None
    radius = quantity_of(cases[0].result, "radius")
    for case in cases:
        problem, r = case.result.problem, case.result.stage_radius
        r = np.unique(np.concatenate([r, problem.tension_curve.kinks]))
        T = problem.tension_curve.at(r) * problem.web_thickness
        axes.plot(radius.shown(r), quantity.shown(T), color=case.colour_or(COLOURS[0]))
    axes.set_ylabel(axis_label("Wound-on tension", quantity))
    axes.set_ylim(bottom=0)
    _format_x_axis(axes, cases)
    return []


def _format_x_axis(axes: Axes, cases: Cases) -> None:
    """Label the axis of the radius from core to surface."""
    quantity = quantity_of(cases[0].result, "radius")
    ends = np.concatenate([case.result.radius[[0, -1]] for case in cases])
    axes.set_xlabel(axis_label("Radius $r$", quantity))
    axes.set_xlim(quantity.shown(float(ends.min())), quantity.shown(float(ends.max())))
