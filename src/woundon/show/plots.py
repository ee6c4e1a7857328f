"""Figures of results: a function for each kind, and one that draws the arrays of any.

Found through :mod:`woundon.kinds`; of woundon, only this room imports matplotlib.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from .. import quantities, theories
from ..errors import InvalidProblem
from ..nip.result import NipResult, WindingNipResult
from ..quantities import Place
from ..results import Result
from ..rollers.result import RollerResult
from ..wrap.result import WrappedNipResult
from .figures import (
    COLOURS,
    axis_label,
    check_format,
    draw_zones,
    legend_above,
    letter,
    quantity_of,
    save_figure,
    shown,
    style,
    symbol_text,
    unit_of,
    wrapped_text,
)
from .parts import ZoneStrips, nip_zones, roller_zones

__all__ = [
    "check_format", "draw_slips", "draw_tractions", "draw_zones", "plot_nip", "plot_outputs",
    "plot_rollers", "plot_wrapped", "save_figure", "style",
]  # fmt: skip

Array = np.ndarray

ROLL, DRUM, TENSION = COLOURS[0], COLOURS[1], "#444444"
ROLL_BOUND, DRUM_BOUND = "#DDDDDD", "#B5B5B5"
LINES = ("-", "--", "-.", ":")
# a strip of zones below two panels
HEIGHTS = [3.2, 2.8, 0.5]


def _made(figure: Figure, path: str | Path | None) -> Figure:
    if path is not None:
        save_figure(figure, path)
    return figure


# ---- the nip ------------------------------------------------------------------------------------


def plot_nip(result: NipResult, path: str | Path | None = None) -> Figure:
    """Draw the tractions with their friction bounds, the slip speeds and the web tension.

    Panel (a): q+ and q- over the shaded bounds +-mu+ p and +-mu- p [kPa].  Panel (b): slip v+ and
    v- [%], and the web tension [N/m] on the right.  Below: the zones at roll and drum.

    Parameters
    ----------
    result : NipResult
    path : path, optional
        Where to save, ``.png``, ``.svg`` or ``.pdf``.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    InvalidProblem
        For another ending of the path.

    Source: thesis Fig. 15.
    """
    with style():
        figure = Figure(figsize=(6.3, 6.6), layout="constrained")
        tractions, slips, zones = figure.subplots(
            3, 1, sharex=True, gridspec_kw={"height_ratios": HEIGHTS}
        )
        _draw_nip(tractions, slips, zones, result)
    return _made(figure, path)


def _draw_nip(tractions: Axes, slips: Axes, zones: Axes, result: WindingNipResult) -> None:
    draw_tractions(tractions, result)
    draw_slips(slips, result)
    _draw_zones_below(zones, nip_zones(result), result, "nip")


def _draw_zones_below(axes: Axes, strips: ZoneStrips, result: Any, contact: str) -> None:
    """Draw the zones of a figure's last panel and set the limits along x for all of them."""
    x = quantity_of(result, "x")
    draw_zones(axes, strips, x)
    axes.set_xlabel(axis_label(f"Position along the {contact} $x$", x))
    edge = 1.03 * x.shown(result.half_width)
    axes.set_xlim(-edge, edge)


def draw_tractions(axes: Axes, result: WindingNipResult) -> None:
    """Draw q+ and q- of the nip over their shaded friction bounds [kPa], along x [mm]."""
    problem, own = result.problem, result.in_nip
    x, on_drum = shown(result, "x")[own], shown(result, "pressure")[own]
    wrapped = isinstance(result, WrappedNipResult)
    on_roll = shown(result, "roll_pressure")[own] if wrapped else on_drum
    bounds = [
        (problem.roll_friction, on_roll, ROLL_BOUND, "+"),
        (problem.drum_friction, on_drum, DRUM_BOUND, "-"),
    ]
    # the narrower one lies on top
    shades = []
    for mu, p, colour, sign in sorted(bounds, key=lambda bound: -bound[0]):
        label = rf"$\pm\mu^{{{sign}}}p{f'^{{{sign}}}' if wrapped else ''}$"
        shade = axes.fill_between(x, -mu * p, mu * p, color=colour, linewidth=0, label=label)
        shades.append(shade)
    (roll,) = axes.plot(x, shown(result, "roll_traction")[own], color=ROLL)
    (drum,) = axes.plot(x, shown(result, "drum_traction")[own], "--", color=DRUM)
    roll.set_label("$q^{+}$ on roll")
    drum.set_label("$q^{-}$ on drum")
    legend_above(axes, [roll, drum, *shades])
    axes.set_ylabel(axis_label("Tangential traction $q$", quantity_of(result, "roll_traction")))
    letter(axes, "a")


def draw_slips(axes: Axes, result: WindingNipResult) -> None:
    """Draw the slips v+ and v- [%] and, on the right, the web tension [N/m], along x [mm]."""
    own = result.in_nip
    x, slip_x = shown(result, "x")[own], shown(result, "slip_x")[own]
    (roll,) = axes.plot(slip_x, shown(result, "roll_slip")[own], color=ROLL)
    (drum,) = axes.plot(slip_x, shown(result, "drum_slip")[own], "--", color=DRUM)
    axes.set_ylabel(axis_label("Relative slip speed $v$", quantity_of(result, "roll_slip")))
    tension_axes = axes.twinx()
    (tension,) = tension_axes.plot(x, shown(result, "web_tension")[own], "-.", color=TENSION)
    tension_axes.set_ylabel(axis_label("Web tension $T$", quantity_of(result, "web_tension")))
    tension_axes.grid(visible=False)
    roll.set_label("$v^{+}$ at roll")
    drum.set_label("$v^{-}$ at drum")
    tension.set_label("$T$ (right axis)")
    legend_above(axes, [roll, drum, tension])
    letter(axes, "b")


# ---- the nip with its wraps ---------------------------------------------------------------------


def plot_wrapped(result: WrappedNipResult, path: str | Path | None = None) -> Figure:
    """Draw a nip with its wraps: the nip as :func:`plot_nip` does, then the web along the roll.

    Over the distance from the nip as an angle [deg], on a logarithmic scale: panel (c) the web
    tension; panel (d) the pressure on the roll and |q+|/mu+, the pressure that its traction needs
    [kPa].  Where the web is wrapped on the drum too, the same before the nip.

    Parameters
    ----------
    result : WrappedNipResult
    path : path, optional
        Where to save, ``.png``, ``.svg`` or ``.pdf``.

    Returns
    -------
    matplotlib.figure.Figure
    """
    if not (result.problem.roll_wrap or result.problem.drum_wrap):
        return plot_nip(result, path)  # type: ignore[arg-type]  # nothing beside the nip
    with style():
        figure = Figure(figsize=(11.4, 6.6), layout="constrained")
        grid = figure.add_gridspec(3, 2, height_ratios=HEIGHTS)
        tractions = figure.add_subplot(grid[0, 0])
        tension = figure.add_subplot(grid[0, 1])
        slips = figure.add_subplot(grid[1, 0], sharex=tractions)
        pressure = figure.add_subplot(grid[1:, 1], sharex=tension)
        zones = figure.add_subplot(grid[2, 0], sharex=tractions)
        _draw_nip(tractions, slips, zones, result)
        _draw_wraps(tension, pressure, result)
        for axes in (tractions, slips, tension):
            axes.tick_params(labelbottom=False)
    return _made(figure, path)


def _draw_wraps(tension: Axes, pressure: Axes, result: WrappedNipResult) -> None:
    """Draw tension and pressures on roll and drum, over the angle from the nip [deg]."""
    problem, own, a = result.problem, result.in_nip, result.half_width
    angle, wound = (quantity_of(result, name) for name in ("slip_angle", "wound_on_tension"))
    T, marks = shown(result, "web_tension"), []
    if problem.roll_wrap:
        behind = slice(own.stop, None)
        theta = angle.shown((result.x[behind] - a) / problem.roll.radius)
        tension.plot(theta, T[behind], "-.", color=TENSION, label="$T$ on roll")
        _draw_pressures(pressure, theta, result, behind, "roll", problem.friction_behind)
        far = f"{wound.symbol} {wound.shown(T[-1]):.5g}"
        marks.append(tension.axhline(T[-1], color="#888888", linewidth=0.8, label=far))
        if result.slip_angle:
            end = shown(result, "slip_angle")
            marks.append(tension.axvline(end, color=ROLL, linewidth=0.8, label="end of slip"))
    if problem.drum_wrap:
        before = slice(0, own.start)
        theta = angle.shown((-a - result.x[before]) / problem.drum.radius)
        tension.plot(theta, T[before], ":", color=TENSION, label="$T$ on drum")
        _draw_pressures(pressure, theta, result, before, "drum", problem.drum_friction)
    tension.set_ylabel(axis_label("Web tension $T$", quantity_of(result, "web_tension")))
    pressure.set_ylabel(axis_label("Pressure $p$", quantity_of(result, "pressure")))
    pressure.set_xlabel(axis_label(r"Angle from the edge of the nip $\theta$", angle))
    curves = [line for line in tension.get_lines() if line not in marks]
    for axes, name, handles in (
        (tension, "c", [*curves, *marks]),
        (pressure, "d", list(pressure.get_lines())),
    ):
        axes.set_xscale("log")
        letter(axes, name)
        legend_above(axes, handles)


def _draw_pressures(
    axes: Axes, theta: Array, result: WrappedNipResult, own: slice, face: str, friction: float
) -> None:
    """Draw the pressure on a face, and the one that its traction needs."""
    roll = face == "roll"
    sign, colour, lines = ("+", ROLL, "-:") if roll else ("-", DRUM, ("--", "-."))
    needed = np.abs(shown(result, f"{face}_traction")[own]) / friction
    present = shown(result, "roll_pressure" if roll else "pressure")[own]
    axes.plot(theta, present, lines[0], color=colour, label=f"$p^{{{sign}}}$")
    needs = rf"$|q^{{{sign}}}|/\mu^{{{sign}}}$"
    axes.plot(theta, needed, lines[1], color=colour, label=needs)


# ---- two rollers --------------------------------------------------------------------------------


def plot_rollers(result: RollerResult, path: str | Path | None = None) -> Figure:
    """Draw pressure and traction with its friction bound, the slip and the zones.

    Panel (a): p and q over the shaded bound +-mu p [MPa], beside them the closed forms that apply:
    Carter's (rolling), Cattaneo's (static), or Bentall and Johnson's for dissimilar rollers that
    roll freely without slip.  Panel (b): the slip, a speed over the
    speed [%] in rolling, a length [mm] in static contact.  Below: the zones.

    Parameters
    ----------
    result : RollerResult
    path : path, optional
        Where to save, ``.png``, ``.svg`` or ``.pdf``.

    Returns
    -------
    matplotlib.figure.Figure
    """
    with style():
        figure = Figure(figsize=(6.3, 6.2), layout="constrained")
        heights = [*HEIGHTS[:2], 0.3]
        tractions, slips, zones = figure.subplots(
            3, 1, sharex=True, gridspec_kw={"height_ratios": heights}
        )
        _draw_roller_tractions(tractions, result)
        _draw_roller_slip(slips, result)
        _draw_zones_below(zones, roller_zones(result), result, "contact")
    return _made(figure, path)


def _draw_roller_tractions(axes: Axes, result: RollerResult) -> None:
    x, p, mu = shown(result, "x"), shown(result, "pressure"), result.problem.friction
    shade = axes.fill_between(x, -mu * p, mu * p, color=ROLL_BOUND, linewidth=0)
    shade.set_label(r"$\pm\mu p$")
    (pressure,) = axes.plot(x, p, "-.", color=TENSION, label="$p$")
    (traction,) = axes.plot(x, shown(result, "traction"), color=ROLL, label="$q$ on upper roller")
    handles = [pressure, traction, shade]
    quantity = quantity_of(result, "pressure")
    name, forms = _closed_forms(result)
    inside = -np.cos(np.linspace(0, np.pi, 42)) * result.half_width
    for form in forms:
        (marks,) = axes.plot(
            quantity_of(result, "x").shown(inside), quantity.shown(form(inside)), "o",
            color=DRUM, markersize=3.5, fillstyle="none", markeredgewidth=0.8, label=name,
        )  # fmt: skip
    legend_above(axes, [*handles, marks] if forms else handles)
    axes.set_ylabel(axis_label("Pressure $p$, traction $q$", quantity))
    letter(axes, "a")


def _closed_forms(result: RollerResult) -> tuple[str, tuple[Callable[[Array], Array], ...]]:
    """Return the name of the theory that applies with its p(x) and q(x); none where none does."""
    problem = result.problem
    known: list[tuple[str, Callable[..., Any]]] = [("Cattaneo", theories.cattaneo)]
    if problem.motion == "rolling":
        known = [("Carter", theories.carter)]
        if problem.creepage is None and not problem.tangential_load:
            known.append(("Bentall-Johnson, no slip", theories.bentall_johnson_stick))
    for name, theory in known:
        try:
            found = theory(problem)
        except InvalidProblem:  # not similar, or of no linear elastic material
            continue
        return name, (found.pressure, found.traction)
    return "", ()


def _draw_roller_slip(axes: Axes, result: RollerResult) -> None:
    rolling = result.problem.motion == "rolling"
    quantity = quantity_of(result, "creepage" if rolling else "shift")
    axes.plot(shown(result, "slip_x"), quantity.shown(result.slip), color=ROLL)
    words = "Relative slip speed $v$" if rolling else "Slip $v$"
    axes.set_ylabel(axis_label(words, quantity))
    letter(axes, "b")


# ---- any kind -----------------------------------------------------------------------------------


def plot_outputs(result: Result, path: str | Path | None = None) -> Figure:
    """Draw every array of a result of any kind over its first one, a panel for each unit.

    Whole numbers (zones, states) have a panel of their own; arrays of another length than the
    first are left out.

    Parameters
    ----------
    result : Result
    path : path, optional
        Where to save, ``.png``, ``.svg`` or ``.pdf``.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    InvalidProblem
        For a result without arrays.
    """
    arrays = [p for p in quantities.walk(result) if isinstance(p.value, np.ndarray)]
    arrays = [p for p in arrays if p.value.ndim == 1 and p.value.shape == arrays[0].value.shape]
    if len(arrays) < 2:
        raise InvalidProblem.at("plot", f"a {type(result).__name__} has no arrays to draw")
    along, *drawn = arrays

    def panel_of(place: Place) -> tuple[str, bool]:
        return _quantity(place).display, place.value.dtype.kind in "iub"

    order = list(dict.fromkeys(map(panel_of, drawn)))
    panels = groupby(sorted(drawn, key=lambda p: order.index(panel_of(p))), panel_of)
    with style():
        figure = Figure(figsize=(9.0, 1.0 + 2.1 * len(order)), layout="constrained")
        rows = figure.subplots(len(order), 1, sharex=True, squeeze=False)[:, 0]
        for axes, (_, places) in zip(rows, panels, strict=True):
            _draw_panel(axes, along, list(places))
        rows[-1].set_xlabel(_label(along))
    return _made(figure, path)


def _draw_panel(axes: Axes, along: Place, places: list[Place]) -> None:
    """Draw arrays of one unit, their names on the right."""
    x = _quantity(along).shown(along.value)
    for k, place in enumerate(places):
        quantity, whole = _quantity(place), place.value.dtype.kind in "iub"
        axes.plot(
            x, quantity.shown(place.value), LINES[k % 4], color=COLOURS[k % 7],
            drawstyle="steps-mid" if whole else "default",
            label=wrapped_text(f"{symbol_text(quantity.symbol)}  {quantity.meaning}"),
        )  # fmt: skip
    unit = unit_of(_quantity(places[0]))
    axes.set_ylabel(f"[{unit}]" if unit else "")
    axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))


def _label(place: Place) -> str:
    meaning = _quantity(place).meaning
    return axis_label(meaning[:1].upper() + meaning[1:], _quantity(place))


def _quantity(place: Place) -> quantities.Quantity:
    assert place.quantity is not None  # an output without one is none
    return place.quantity
