"""The panels of a wound roll."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..problems.paths import quantity_of_field
from ..problems.roll import RollProblem
from ..roll.result import RollResult
from .lane_panels import lane_panels
from .panels import Area, Axis, Curve, Disc, Limits, Mark, Panel, PanelMaker, Scale
from .report_parts import quantity_of

__all__ = [
    "cut_above",
    "disc",
    "disc_of",
    "hoop_disc",
    "hoop_stress_at",
    "over_radius",
    "radii_between",
    "radius_axis",
    "roll_panels",
    "scale_of",
    "with_compression",
]

Array = np.ndarray
POINTS = 401  # of a curve that is known between its nodes too
OUTWARD = 200  # of a coloured disc
# The stress at the ends is many times the compression inside: a hoop stress is drawn up to so many
# times the depth of the compression.
ABOVE, BELOW = 5.0, 1.3
MARGIN = 0.05  # of the values, above the largest one
# of pressures next to the largest one, below zero
ROUNDING = 1e-9


def roll_panels(result: RollResult) -> dict[str, PanelMaker]:
    """Return the panels of a wound roll, over the radius.

    - pressure between the layers, and that of the running roll with centrifugal force
    - hardness: the modulus through the stack
    - hoop_stress along the web, compression shaded; cut off above where there is any
    - tension: the wound-on tension, on the stages of the build-up
    - density of the wound layers, and as a density analyser on the winder draws it, where the
      web's density is given
    - compression: the part of the hoop stress that is compressive (if asked for)
    - residual_tension of the layers, and their outward displacement since they were wound (if
      asked for)
    - disc, hoop_disc: the roll from its side, coloured by pressure and hoop stress (if asked for)
    - those of the lanes across the width, with a thickness profile (:mod:`.lane_panels`)
    """
    panels = {
        "pressure": PanelMaker(pressure),
        "hardness": PanelMaker(hardness),
        "hoop_stress": PanelMaker(hoop_stress),
        "compression": PanelMaker(compression, by_default=False),
        "tension": PanelMaker(tension),
        "density": PanelMaker(density),
        "residual_tension": PanelMaker(residual_tension, by_default=False),
        "displacement": PanelMaker(displacement, by_default=False),
        "disc": PanelMaker(disc, by_default=False),
        "hoop_disc": PanelMaker(hoop_disc, by_default=False),
        **lane_panels(result),
    }
    if result.problem.density is None:
        del panels["density"]
    if np.count_nonzero(_compressed(result)) < 2:
        del panels["compression"]
    return panels


def radius_axis(radius: Array) -> Axis:
    """Return the axis from the first to the last of the radii [m], those of core and surface."""
    return Axis(
        "Radius $r$",
        quantity_of(RollResult, "radius"),
        limits=(float(radius[0]), float(radius[-1])),
    )


def radii_between(roll: RollResult, count: int = POINTS) -> Array:
    """Return evenly spaced radii from core to surface [m]: also between the nodes."""
    return np.linspace(roll.radius[0], roll.radius[-1], count)


def hoop_stress_at(roll: RollResult) -> Array:
    """Return the hoop stress at :func:`radii_between` [Pa]."""
    return np.asarray(roll.at_radius(radii_between(roll))["hoop_stress"])


def _compressed(roll: RollResult) -> Array:
    """Return the mask of compressive hoop stress on the radii of :func:`radii_between`."""
    return hoop_stress_at(roll) < 0


def cut_above(lowest: float, values: Array, below: float, above: float) -> Limits | None:
    """Return limits of an axis of hoop stresses, which are many times as large at core and surface.

    Parameters
    ----------
    lowest : float
        Largest compression, < 0; without compression there are no limits.
    values : array
        All stresses; the axis ends a little above the largest if that is less than ``above``.
    below, above : float
        Ends of the axis in multiples of the compression.
    """
    if lowest >= 0:
        return None
    highest = float(values.max())
    return below * lowest, min(highest + MARGIN * (highest - lowest), -above * lowest)


# ---- over the radius ----------------------------------------------------------------------------


def over_radius(
    radius: Array, name: str, title: str, y: Axis, curves: Sequence[Curve], **others: Any
) -> Panel:
    """Return a panel over the radius from core to surface.

    Parameters
    ----------
    radius : (n,) array
        The first and the last one are the ends of the axis [m].
    name, title, y, curves, others
        As of a :class:`~woundon.report.panels.Panel`; on the left by default.
    """
    place = {"column": "left", "height": 2.6, **others}
    return Panel(name, radius_axis(radius), y, title, curves=tuple(curves), **place)


def pressure(roll: RollResult) -> Panel:
    """Return the panel of the pressure between the layers."""
    r, quantity = radii_between(roll), quantity_of(roll, "pressure")
    curve = Curve("pressure", r, roll.at_radius(r)["pressure"], quantity.symbol)
    curves = [curve]
    if _has_changed(roll):
        as_wound = roll.as_wound.stresses_at(r)[0]
        curves = _before_and_after(roll, "pressure", r, as_wound, curve)
    y = Axis("Pressure $P$", quantity, from_zero=True)
    return over_radius(roll.radius, "pressure", "Pressure", y, curves, height=2.8)


def _has_changed(roll: RollResult) -> bool:
    """Return True if the finished roll differs from the roll as wound, which may have run."""
    return roll.is_changed or bool(roll.problem.centrifugal_stress)


def _before_and_after(
    roll: RollResult, name: str, r: Array, as_wound: Array, finished: Curve
) -> list[Curve]:
    """Return the curves of the finished roll, and of the roll as wound, before the changes.

    ``r`` and ``as_wound`` are radii [m] and values, (n,); ``finished`` is the other curve.
    """
    label = "as wound, running" if roll.problem.centrifugal_stress else "as wound"
    before = Curve(f"{name}_as_wound", r, as_wound, label=label, colour="drum", line="dashed")
    return [replace(finished, label="finished roll"), before]


def hardness(roll: RollResult) -> Panel:
    """Return the panel of the modulus through the stack."""
    curve = Curve.of_output(roll, "radial_modulus", roll.radius)
    y = Axis("Hardness $E_r$", quantity_of(roll, "radial_modulus"), from_zero=True)
    return over_radius(roll.radius, "hardness", "Hardness", y, [curve])


def displacement(roll: RollResult) -> Panel:
    """Return the panel of the displacement of the layers since they were wound."""
    curve = Curve.of_output(roll, "displacement", roll.radius)
    title = "Displacement of the layers since they were wound"
    y = Axis("Displacement $u$", quantity_of(roll, "displacement"), from_zero=True)
    return over_radius(roll.radius, "displacement", title, y, [curve])


def hoop_stress(roll: RollResult) -> Panel:
    """Return the panel of the hoop stress."""
    title, label = "Hoop stress", "Hoop stress $sigma_t$"
    return _stress_of_layers(roll, "hoop_stress", title=title, label=label, thickness=1.0)


def residual_tension(roll: RollResult) -> Panel:
    """Return the panel of the residual tension of the layers, the hoop stress times thickness."""
    title, label = "Residual tension of the layers", "Residual tension $T_r$"
    thickness = float(roll.problem.web_thickness)
    return _stress_of_layers(
        roll, "residual_tension", title=title, label=label, thickness=thickness
    )


def _stress_of_layers(
    roll: RollResult, name: str, title: str, label: str, thickness: float
) -> Panel:
    """Return the panel of the hoop stress times a thickness, compression shaded.

    With the thickness of the web [m] it is a tension per width, with 1 the stress itself.
    """
    r, quantity = radii_between(roll), quantity_of(roll, name)
    values = thickness * hoop_stress_at(roll)
    lowest = thickness * roll.least_hoop_stress
    shade = Area("compression", r, low=np.minimum(values, 0), high=0 * r, shade="drum")
    curves = [Curve(name, r, values, quantity.symbol)]
    if _has_changed(roll):
        as_wound = thickness * roll.as_wound.stresses_at(r)[1]
        curves = _before_and_after(roll, name, r, as_wound, curves[0])
        lowest = min(lowest, float(as_wound.min()))
    y = Axis(label, quantity, cut=cut_above(lowest, values, BELOW, ABOVE))
    return with_compression(over_radius(roll.radius, name, title, y, curves, height=2.8), shade)


def with_compression(panel: Panel, shade: Area) -> Panel:
    """Return a panel of a hoop stress with zero marked and compression shaded, if there is any."""
    return replace(
        panel,
        areas=(shade,) if (shade.low < 0).any() else (),
        marks=(Mark("x", 0.0, colour="web", alone=False),),
        column="right",
    )


def compression(roll: RollResult) -> Panel:
    """Return the panel of the compressive part of the hoop stress."""
    (compressed,) = np.nonzero(_compressed(roll))
    part = slice(compressed[0], compressed[-1] + 1)  # from the first to the last such radius
    r, stress = radii_between(roll)[part], quantity_of(roll, "hoop_stress")
    curve = Curve("hoop_stress", r, hoop_stress_at(roll)[part], stress.symbol, colour="drum")
    return Panel(
        "compression",
        radius_axis(r),
        Axis("Hoop stress $sigma_t$", stress),
        title="Hoop stress where it is compressive",
        curves=(curve,),
    )


def tension(roll: RollResult) -> Panel:
    """Return the panel of the wound-on tension, on the stages of the build-up."""
    problem = roll.problem
    quantity = quantity_of_field(RollProblem, "wound_on_tension")
    r = np.unique(np.concatenate([roll.stage_radius, problem.tension_curve.kinks]))
    values = problem.tension_curve.at(r) * problem.web_thickness
    curve = Curve("wound_on_tension", r, values, quantity.symbol)
    y, title = Axis("Wound-on tension", quantity, from_zero=True), "Tension over the radius"
    return over_radius(roll.radius, "tension", title, y, [curve], column="right")


def density(roll: RollResult) -> Panel:
    """Return the panel of the density of the finished roll and that as wound."""
    quantity, r = quantity_of(roll, "density"), roll.radius
    curves = [
        Curve("density", r, roll.density, label="in the roll"),
        Curve(
            "density_as_wound",
            r,
            roll.density_as_wound,
            label="as wound",
            colour="drum",
            line="dashed",
        ),
    ]
    return over_radius(r, "density", "Density of the layers", Axis("Density", quantity), curves)


# ---- cross sections -----------------------------------------------------------------------------


def disc(roll: RollResult) -> Panel:
    """Return the panel of the roll from its side, coloured by the pressure."""
    title, label = "Pressure in the roll", "Pressure $P$"
    return _disc_panel(roll, "disc", title=title, output="pressure", label=label)


def hoop_disc(roll: RollResult) -> Panel:
    """Return the panel of the roll from its side, coloured by the hoop stress."""
    title, label = "Hoop stress in the roll", "Hoop stress $sigma_t$"
    return _disc_panel(roll, "hoop_disc", title=title, output="hoop_stress", label=label)


def _disc_panel(roll: RollResult, name: str, title: str, output: str, label: str) -> Panel:
    """Return the panel of the roll from its side, coloured by an output."""
    radius = quantity_of(roll, "radius")
    return Panel(
        name,
        Axis("$x$", radius),
        Axis("$y$", radius),
        title=title,
        discs=(disc_of(roll, output, left=-float(roll.radius[-1])),),
        scale=scale_of(roll, output, label),
        width=5.4,
        height=4.4,
    )


def disc_of(roll: RollResult, output: str, left: float) -> Disc:
    """Return the cross section of a roll coloured by an output; its left edge is at ``left``."""
    r = radii_between(roll, OUTWARD)
    return Disc(r, np.asarray(roll.at_radius(r)[output]), left)


def scale_of(roll: RollResult, output: str, label: str) -> Scale:
    """Return the scale of the colours of an output: from zero, or symmetrical about it."""
    quantity = quantity_of(roll, output)
    values = disc_of(roll, output, left=0.0).values
    low, high = float(values.min()), float(values.max())
    clipped = "upper" if output == "hoop_stress" else ""
    if low > -ROUNDING * high:
        return Scale(Axis(label, quantity, limits=(0.0, high)), clipped=clipped)
    # the stress at core and surface is many times that inside, which would have almost no colour
    high = max(min(high, -2 * low), -low)
    return Scale(Axis(label, quantity, limits=(-high, high)), "red below", clipped)
