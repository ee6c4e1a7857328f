"""Figures in the style of the thesis: panels of curves, line styles, legends, labels with units."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from io import BytesIO
from typing import Any

import matplotlib as mpl
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from .nips import Nip
from .zones import runs

__all__ = [
    "COLOURS",
    "LINES",
    "blank",
    "curves",
    "draw_slips",
    "figure_bytes",
    "nip_figure",
    "one_panel",
    "shared_legend",
    "sheet",
    "style",
]

# the thesis's line styles in its order; the colours tell its two solid lines apart
LINES = ("-", "--", "-.", ":", "-")
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#AA4499", "#444444")

# name -> axis label and factor from SI
AXES = {
    "nip_load": ("Nip load $P$ [kN/m]", 1e-3),
    "roll_friction": (r"Friction between layers $\mu^+$", 1.0),
    "roll_radius": ("Roll radius $R_1$ [m]", 1.0),
    "drum_radius": ("Drum radius $R_2$ [m]", 1.0),
    "youngs_modulus": ("Cover modulus $E_2$ [Pa]", 1.0),
    "cover_thickness": (r"Cover thickness $\Delta R_2$ [mm]", 1e3),
    "tangential": (r"$A_{\theta\theta}$ [GPa]", 1e-9),
    "x": ("Position along the nip $x$ [mm]", 1e3),
    "nip_induced_tension": ("NIT [N/m]", 1.0),
    "nip_width": ("Nip width $2a$ [mm]", 1e3),
    "leading_roll_slip": ("Leading edge $s_{r1}$", 1.0),
    "trailing_roll_slip": ("Trailing edge $s_{r2}$", 1.0),
    "dual_slip": ("Dual slip ratio $s_d$", 1.0),
    "tension_increase": (r"Web tension $T - T_\mathrm{in}$ [N/m]", 1.0),
    "traction": ("Tangential traction $q$ [MPa]", 1e-6),
}
LOGARITHMIC = ("youngs_modulus",)
# dimension -> what the titles of panels say of its values
TITLES: dict[str, Callable[[Any], str]] = {
    "nip_load": lambda P: f"$P = {P:.0f}$ N/m",
    "roll_radius": lambda R: f"$R_1 = {R}$ m",
    "drum_radius": lambda R: f"$R_2 = {R}$ m",
}
# dimension -> what a legend says of its values
NAMES: dict[str, Callable[[Any], str]] = {
    "winding_force": lambda F: f"$F = {F:.0f}$ N/m",
    "poissons_ratio": lambda nu: rf"$\nu_2 = {nu:g}$",
    "radial": lambda A_rr: f"$A_{{rr}}$ = {A_rr / 1e6:g} MPa",
    "cross": lambda A_rt: rf"$A_{{r\theta}}$ = {A_rt / 1e6:g} MPa",
    "cover": str,
    "rolling": lambda rolls: "rolling (Carter)" if rolls else "static (Cattaneo)",
}


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
# without a date, so that the same figure gives the same bytes
_METADATA: dict[str, dict[str, Any]] = {
    "png": {"Software": "woundon"},
    "svg": {"Date": None, "Creator": "woundon"},
}


@contextmanager
def style() -> Iterator[None]:
    """Draw in the style of the reproduction, and restore the global style."""
    # rc_context would also undo the backend that pyplot chooses when a notebook first loads it
    before = {name: mpl.rcParams[name] for name in _STYLE}
    mpl.rcParams.update(_STYLE)
    try:
        yield
    finally:
        mpl.rcParams.update(before)


def figure_bytes(figure: Figure, form: str, dpi: int | None = None) -> bytes:
    """Return a figure as a file of the form "png" or "svg"; the same figure gives the same bytes.

    ``dpi`` is the resolution of a PNG file, 200 by default.
    """
    drawn = BytesIO()
    with style():
        figure.savefig(drawn, format=form, metadata=_METADATA[form], dpi=dpi)
    return drawn.getvalue()


def blank(
    rows: int = 1, columns: int = 2, size: tuple[float, float] | None = None, letters: bool = True
) -> Figure:
    """Return a figure of empty panels, lettered (a), (b), ... if there are several."""
    with style():
        figure = Figure(figsize=size or (3.6 * columns, 3.3 * rows), layout="constrained")
        panels = figure.subplots(rows, columns, squeeze=False).flat
        if letters and rows * columns > 1:
            for letter, axes in zip("abcdefghi", panels, strict=False):
                axes.set_title(f"({letter})", loc="right", fontsize=9)
    return figure


def one_panel(size: tuple[float, float] = (6.0, 4.0)) -> tuple[Figure, Axes]:
    """Return a figure of one empty panel."""
    figure = blank(1, 1, size)
    return figure, figure.axes[0]


def curves(
    axes: Axes, data: xr.Dataset, x: str, y: str, along: str, names: Sequence[str] = ()
) -> None:
    """Draw a variable over another, or over a dimension, one curve for each value along a third.

    ``names`` stand in the legend in place of the values.
    """
    (x_label, per_x), (y_label, per_y) = AXES[x], AXES[y]
    for k, value in enumerate(data[along].values):
        one = data.isel({along: k})
        name = names[k] if names else NAMES[along](value)
        axes.plot(one[x] * per_x, one[y] * per_y, LINES[k], color=COLOURS[k], label=name)
    axes.set_xlabel(x_label)
    axes.set_ylabel(y_label)
    if x in LOGARITHMIC:
        axes.set_xscale("log")


def sheet(
    data: xr.Dataset,
    shown: Sequence[str],
    x: str,
    along: str = "winding_force",
    *,
    panels: str = "",
    names: Sequence[str] = (),
    legend: int = 5,
) -> Figure:
    """Draw one or two panels of curves with a legend in common.

    Parameters
    ----------
    data : Dataset
    shown : sequence of str
        Variables, a panel each.
    x, along, names
        As of :func:`curves`.
    panels : str
        Dimension along which each value has a panel, of a single variable.
    legend : int
        Its number of columns.
    """
    if panels:
        (y,) = shown
        parts = [(data.sel({panels: v}), y, TITLES[panels](v)) for v in data[panels].values]
    else:
        parts = [(data, y, "") for y in shown]
    figure = blank() if len(parts) == 2 else one_panel()[0]
    for axes, (part, y, title) in zip(figure.axes, parts, strict=True):
        curves(axes, part, x, y, along, names)
        axes.set_title(title, fontsize=9)
    shared_legend(figure, legend)
    return figure


def shared_legend(figure: Figure, columns: int = 5) -> None:
    """Draw one legend for all panels above them."""
    handles: dict[str, Any] = {}
    for axes in figure.axes:
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
            handles.setdefault(label, handle)
    with style():
        figure.legend(
            handles=list(handles.values()),
            labels=list(handles),
            loc="outside upper center",
            ncols=columns,
            handlelength=2.6,
            columnspacing=1.3,
        )


# ---- one nip along x ----------------------------------------------------------------------------

_SHADES = ("#DDDDDD", "#B5B5B5")
_ZONES = {-1: ("#E69F00", "\\\\\\\\"), 0: ("#F0F0F0", ""), 1: ("#56B4E9", "////")}
_WORDS = {0: "stick", 1: "slip, web faster", -1: "slip, web slower"}
_POSITION = "Position along the nip $x$ [mm]"


def nip_figure(result: Nip) -> Figure:
    """Draw a nip as the thesis does (Fig. 15): tractions; slips and web tension; and its zones."""
    with style():
        figure = Figure(figsize=(6.4, 7.6), layout="constrained")
        panels = figure.subplots(3, 1, sharex=True, height_ratios=(3.0, 2.8, 0.7))
        for axes, draw in zip(panels, (_draw_tractions, draw_slips, _draw_zones), strict=True):
            draw(axes, result)
        for letter, axes in zip("ab", panels, strict=False):
            axes.set_title(f"({letter})", loc="right", fontsize=9)
        panels[-1].set_xlabel(_POSITION)
        panels[-1].set_xlim(*(1.03e3 * r for r in (-result.half_width, result.half_width)))
    return figure


def _draw_tractions(axes: Axes, r: Nip) -> None:
    """Draw q+ and q- over the shaded friction bounds, the narrower one on top."""
    x, p = 1e3 * r.x, 1e-3 * r.drum_pressure
    frictions = {"+": r.problem.roll_friction, "-": r.problem.drum_friction}
    for k, (sign, mu) in enumerate(sorted(frictions.items(), key=lambda item: -item[1])):
        label = rf"$\pm\mu^{{{sign}}}p$"
        axes.fill_between(x, -mu * p, mu * p, color=_SHADES[1 - k], linewidth=0, label=label)
    axes.plot(x, 1e-3 * r.roll_traction, color=COLOURS[0], label="$q^{+}$ on roll")
    axes.plot(x, 1e-3 * r.drum_traction, "--", color=COLOURS[1], label="$q^{-}$ on drum")
    axes.set_ylabel("Tangential traction $q$ [kPa]")
    _legend_above(axes, axes.get_legend_handles_labels())


def draw_slips(axes: Axes, r: Nip) -> None:
    """Draw the slips v+ and v- and, on the right, the web tension; the legend above."""
    right = axes.twinx()
    axes.plot(1e3 * r.slip_x, 100 * r.roll_slip, color=COLOURS[0], label="$v^{+}$ at roll")
    axes.plot(1e3 * r.slip_x, 100 * r.drum_slip, "--", color=COLOURS[1], label="$v^{-}$ at drum")
    right.plot(1e3 * r.x, r.tension, "-.", color=COLOURS[4], label="$T$ (right axis)")
    axes.set_ylabel("Relative slip speed $v$ [%]")
    right.set_ylabel("Web tension $T$ [N/m]")
    right.grid(visible=False)
    handles, labels = axes.get_legend_handles_labels()
    more = right.get_legend_handles_labels()
    _legend_above(axes, (handles + more[0], labels + more[1]))


def _draw_zones(axes: Axes, r: Nip) -> None:
    """Draw the stick and slip zones of roll and drum as bars."""
    for row, zones in enumerate((r.drum_zone, r.roll_zone)):
        for run in runs(1e3 * r.x, zones):
            colour, hatch = _ZONES[run.zone]
            axes.barh(
                row,
                run.length,
                left=run.left,
                height=0.7,
                color=colour,
                hatch=hatch,
                edgecolor="#666666",
                linewidth=0.6,
            )
    axes.set_yticks([0, 1], ["drum", "roll"])
    axes.grid(visible=False)
    patches = [
        Patch(facecolor=colour, hatch=hatch, edgecolor="#666666", label=_WORDS[zone])
        for zone, (colour, hatch) in _ZONES.items()
    ]
    _legend_above(axes, (patches, [_WORDS[zone] for zone in _ZONES]))


def _legend_above(axes: Axes, entries: tuple[list[Any], list[Any]]) -> None:
    """Draw the legend above the panel."""
    handles, labels = entries
    axes.legend(
        handles,
        labels,
        loc="lower left",
        bbox_to_anchor=(0.0, 1.0),
        ncols=len(handles),
        borderaxespad=0.2,
        columnspacing=1.4,
    )
