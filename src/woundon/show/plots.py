"""Figures of results; the only module that imports matplotlib, and without its global state.

Figures are made without pyplot, so that any number may be drawn in any thread, and are saved with
fixed metadata: the same result gives the same bytes.
"""

from __future__ import annotations

from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from .errors import InvalidProblem
from .quantities import QUANTITIES
from .results import NipResult, Zone
from .wrap import WrappedNipResult
from .zones import zone_runs

__all__ = [
    "check_format",
    "draw_slips",
    "draw_tractions",
    "plot_nip",
    "plot_wrapped",
    "save_figure",
    "style",
]

Array = np.ndarray

# Okabe and Ito's palette: told apart with any colour vision, and by line style in grey
_ROLL, _DRUM, _TENSION = "#0072B2", "#D55E00", "#444444"
_ROLL_BOUND, _DRUM_BOUND = "#DDDDDD", "#B5B5B5"
_ZONES = {Zone.BACKWARD: "#E69F00", Zone.STICK: "#F0F0F0", Zone.FORWARD: "#56B4E9"}
_ZONE_HATCH = {Zone.BACKWARD: "\\\\\\\\", Zone.STICK: "", Zone.FORWARD: "////"}

_STYLE: Any = {
    "font.family": "DejaVu Sans",
    "font.size": 9,
    "axes.linewidth": 0.8,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#E6E6E6",
    "grid.linewidth": 0.6,
    "hatch.linewidth": 0.6,
    "legend.frameon": False,
    "legend.fontsize": 8.5,
    "lines.linewidth": 1.6,
    "svg.hashsalt": "woundon",
    "savefig.dpi": 200,
}
_METADATA: dict[str, dict[str, Any]] = {
    ".png": {"Software": "woundon"},
    ".svg": {"Date": None, "Creator": "woundon"},
    ".pdf": {"CreationDate": None, "Creator": "woundon", "Producer": "woundon"},
}


def style() -> AbstractContextManager[None]:
    """Return the context in which figures are made: woundon's style, the global one untouched."""
    return mpl.rc_context(_STYLE)


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
            3, 1, sharex=True, gridspec_kw={"height_ratios": [3.2, 2.8, 0.5]}
        )
        draw_tractions(tractions, result)
        draw_slips(slips, result)
        _draw_zones(zones, result)
        edge = 1.03 * QUANTITIES["x"].shown(result.half_width)
        zones.set_xlim(-edge, edge)
    if path is not None:
        save_figure(figure, path)
    return figure


def plot_wrapped(result: WrappedNipResult, path: str | Path | None = None) -> Figure:
    """Draw a nip with its wraps: the nip as :func:`plot_nip` does, then the web along the roll.

    Panel (c): web tension over the angle behind the trailing edge [deg], on a logarithmic scale;
    panel (d): pressure on the roll and |q+|/mu+, the pressure that its traction needs [kPa].

    Parameters
    ----------
    result : WrappedNipResult
    path : path, optional
        Where to save, ``.png``, ``.svg`` or ``.pdf``.

    Returns
    -------
    matplotlib.figure.Figure
    """
    with style():
        figure = Figure(figsize=(11.4, 6.6), layout="constrained")
        (tractions, tension), (slips, pressure) = figure.subplots(2, 2)
        draw_tractions(tractions, result.nip)
        draw_slips(slips, result.nip)
        slips.set_xlabel(_axis_label("Position along the nip $x$", "x"))
        _draw_along_roll(tension, pressure, result)
    if path is not None:
        save_figure(figure, path)
    return figure


def _draw_along_roll(tension: Axes, pressure: Axes, result: WrappedNipResult) -> None:
    """Draw tension and pressures behind the nip, over the angle from the trailing edge [deg]."""
    first = result.in_nip.stop  # the node behind the trailing edge
    behind = result.x[first:] - result.half_width
    angle = np.degrees(behind / result.problem.roll.radius)
    tension.plot(angle, result.web_tension[first:], "-.", color=_TENSION, label="$T$")
    (border,) = (tension.axvline(x, color=_ROLL, linewidth=0.8) for x in [_slip_end(result)])
    border.set_label("end of slip")
    tension.set_ylabel(_axis_label("Web tension $T$", "web_tension"))
    tension.set_title("(c)", loc="right", fontsize=9)
    for values, line, name in (
        (result.roll_pressure, "-", "$p^{+}$"),
        (np.abs(result.roll_traction) / result.wrap_friction, ":", r"$|q^{+}|/\mu^{+}$"),
    ):
        pressure.plot(angle, _shown("pressure", values[first:]), line, color=_ROLL, label=name)
    pressure.set_ylabel(_axis_label("Pressure $p$", "pressure"))
    pressure.set_title("(d)", loc="right", fontsize=9)
    pressure.set_xlabel(r"Angle behind the trailing edge $\theta$ [deg]")
    for axes in (tension, pressure):
        axes.set_xscale("log")
        _legend(axes, axes.get_lines())


def _slip_end(result: WrappedNipResult) -> float:
    return float(np.degrees(result.slip_angle)) or float("nan")


def check_format(path: str | Path) -> str:
    """Return the path's ending if figures are saved in its format.

    Raises
    ------
    InvalidProblem
        For an ending other than .png, .svg, .pdf.
    """
    ending = Path(path).suffix
    if ending not in _METADATA:
        raise InvalidProblem(
            [(str(path), f"the ending {ending!r} names no format; must be {', '.join(_METADATA)}")]
        )
    return ending


def save_figure(figure: Figure, path: str | Path, *, dpi: int | None = None) -> None:
    """Save a figure with fixed metadata: the same figure gives the same bytes.

    ``dpi`` is the resolution of a PNG file, 200 by default.

    Raises
    ------
    InvalidProblem
        For an ending other than .png, .svg, .pdf.
    OSError
        If the file cannot be written.
    """
    ending = check_format(path)
    with style():
        figure.savefig(path, format=ending[1:], metadata=_METADATA[ending], dpi=dpi)


def _shown(name: str, values: Array) -> Array:
    return values * QUANTITIES[name].per_si


def _axis_label(symbol: str, name: str) -> str:
    return f"{symbol} [{QUANTITIES[name].display}]"


def _legend(axes: Axes, handles: list[Any]) -> None:
    """Put the legend above the panel, where it covers no data."""
    axes.legend(
        handles=handles, loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=len(handles),
        borderaxespad=0.2, columnspacing=1.4, handlelength=2.2,
    )  # fmt: skip


def draw_tractions(axes: Axes, result: NipResult) -> None:
    """Draw q+ and q- over their shaded friction bounds [kPa], along x [mm]."""
    problem, x, p = result.problem, _shown("x", result.x), _shown("pressure", result.pressure)
    bounds = [
        (problem.roll_friction, _ROLL_BOUND, r"$\pm\mu^{+}p$"),
        (problem.drum_friction, _DRUM_BOUND, r"$\pm\mu^{-}p$"),
    ]
    # the narrower one lies on top
    shades = [
        axes.fill_between(x, -mu * p, mu * p, color=colour, linewidth=0, label=label)
        for mu, colour, label in sorted(bounds, reverse=True)
    ]
    (roll,) = axes.plot(x, _shown("roll_traction", result.roll_traction), color=_ROLL)
    (drum,) = axes.plot(x, _shown("drum_traction", result.drum_traction), "--", color=_DRUM)
    roll.set_label("$q^{+}$ on roll")
    drum.set_label("$q^{-}$ on drum")
    _legend(axes, [roll, drum, *shades])
    axes.set_ylabel(_axis_label("Tangential traction $q$", "roll_traction"))
    axes.set_title("(a)", loc="right", fontsize=9)


def draw_slips(axes: Axes, result: NipResult) -> None:
    """Draw the slips v+ and v- [%] and, on the right, the web tension [N/m], along x [mm]."""
    x, slip_x = _shown("x", result.x), _shown("slip_x", result.slip_x)
    (roll,) = axes.plot(slip_x, _shown("roll_slip", result.roll_slip), color=_ROLL)
    (drum,) = axes.plot(slip_x, _shown("drum_slip", result.drum_slip), "--", color=_DRUM)
    axes.set_ylabel(_axis_label("Relative slip speed $v$", "roll_slip"))
    tension_axes = axes.twinx()
    (tension,) = tension_axes.plot(x, result.web_tension, "-.", color=_TENSION)
    tension_axes.set_ylabel(_axis_label("Web tension $T$", "web_tension"))
    tension_axes.grid(visible=False)
    roll.set_label("$v^{+}$ at roll")
    drum.set_label("$v^{-}$ at drum")
    tension.set_label("$T$ (right axis)")
    _legend(axes, [roll, drum, tension])
    axes.set_title("(b)", loc="right", fontsize=9)


def _draw_zones(axes: Axes, result: NipResult) -> None:
    x = _shown("x", result.x)
    for row, zones in ((1, result.roll_zone), (0, result.drum_zone)):
        for zone, left, right in zone_runs(x, zones):
            axes.barh(
                row, right - left, left=left, height=0.7, color=_ZONES[zone],
                hatch=_ZONE_HATCH[zone], edgecolor="#666666", linewidth=0.6,
            )  # fmt: skip
    axes.set_yticks([1, 0], ["roll", "drum"])
    axes.set_ylim(-0.55, 1.55)
    axes.grid(visible=False)
    axes.tick_params(axis="y", length=0)
    axes.set_xlabel(_axis_label("Position along the nip $x$", "x"))
    words = {
        Zone.STICK: "stick",
        Zone.FORWARD: "slip, web faster",
        Zone.BACKWARD: "slip, web slower",
    }
    _legend(
        axes,
        [
            Patch(facecolor=_ZONES[zone], hatch=_ZONE_HATCH[zone], edgecolor="#666666", label=word)
            for zone, word in words.items()
        ],
    )
