"""Panels drawn with Matplotlib: the one renderer of all figures.

A panel is drawn in given axes (:func:`draw_panel`), or with others in a new figure
(:func:`draw_figure`).  Several results of a panel are drawn in different colours.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.gridspec import SubplotSpec
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullFormatter, ScalarFormatter

from ..errors import InvalidProblem
from ..problems.messages import quote
from .figures import (
    COLOURS,
    Picture,
    axis_label,
    check_format,
    formulas,
    save_figure,
    style,
    symbol_text,
    text_of,
    wrapped_text,
    zone_look,
)
from .panels import SERIES, Area, Axis, Bars, Curve, Disc, Map, Mark, Panel, Regions, Scale, widest

__all__ = ["check_axes", "draw_figure", "draw_panel", "show_panels"]

Array = np.ndarray
Colours = Sequence[str | None]  # of each case; None where a panel shows a single one
LINES = {"solid": "-", "dashed": "--", "dashdot": "-.", "dotted": ":", "none": "none"}
MARKERS = {
    "": "",
    "point": ".",
    "circle": "o",
    "ring": "o",
    "cross": "x",
    "square": "s",
    "diamond": "d",
    "triangle": "v",
}
SHADES: dict[str, dict[str, Any]] = {
    "shade0": {"color": "#DDDDDD"},
    "shade1": {"color": "#B5B5B5"},
    "drum": {"color": COLOURS["drum"], "alpha": 0.2},
    "alarm": {"color": COLOURS["alarm"], "alpha": 0.12},
}
EXTENDED = {"": "neither", "lower": "min", "upper": "max"}  # ends of a scale of colours
PALETTES = {"sequential": "viridis", "red above": "RdBu_r", "red below": "RdBu"}
NEUTRAL = COLOURS["web"]
LEGENDS_OF_FIGURE: dict[str, Any] = {
    "figure below": "outside lower center",
    "figure right": "outside right center",
}
LEGEND_WIDTH = 1.6  # inches, right of all panels
BAR_GAP, BAR_WIDTH = 0.1, 0.2  # inches, of the scale of colours at the right of a panel
LEVELS = 16  # of a coloured map
CHARACTERS = 11  # of a label per inch along its axis
NAME_WIDTH = 32  # characters in a line of a name next to a bar, or in a legend in a panel
TICK_WIDTH = 0.6  # inches along x for each number
FAINT = 0.35  # opacity of regions
MANY_POINTS = 2000  # of a curve; more are drawn as pixels
AROUND = 181  # spokes of a disc, its first and last the same
FEW_DECADES = 1e3  # ratio of the ends below which a logarithmic axis has labels at 1, 2 and 5
ONE_DECADE = 10.0  # ratio below which its labels are evenly spaced numbers
STEPS = (1, 2, 2.5, 5, 10)  # between the numbers along an axis
ROUNDING = 1e-9  # relative: smaller negative values are zero


# ---- figures ------------------------------------------------------------------------------------


def show_panels(
    panels: Sequence[Sequence[Panel]],
    labels: Sequence[str] = (),
    path: str | Path | None = None,
    ax: Axes | None = None,
    **options: Any,
) -> Figure | Axes:
    """Plot panels in a new figure and save it, or one panel in given axes.

    Parameters
    ----------
    panels : sequence of sequences of Panel
        Each panel, of one or several results.
    labels : sequence of str
        Of several results.
    path : path, optional
        File to save.  Without ``path`` and ``ax`` the figure is registered with pyplot: a notebook
        shows it, and a script shows it with ``plt.show()``.
    ax : Axes, optional
        Axes for the first panel; their style and title do not change.
    options
        As of :func:`draw_figure`.

    Raises
    ------
    InvalidProblem
        For an unknown file format.
    """
    if path is not None:
        check_format(path)
    if ax is not None:
        _draw_into(ax, panels[0], labels)
        figure: Any = ax.get_figure(root=True)
    else:
        figure = draw_figure(panels, labels, registered=path is None, **options)
    if path is not None:
        save_figure(figure, path)
    return figure if ax is None else ax


def draw_figure(
    panels: Sequence[Sequence[Panel]],
    labels: Sequence[str] = (),
    *,
    registered: bool = False,
    lettered: bool = True,
    title: str = "",
    same_y: bool = False,
) -> Figure:
    """Return a new figure of panels.

    Parameters
    ----------
    panels, labels
        As of :func:`show_panels`.
    registered : bool
        Whether the figure is pyplot's.
    lettered : bool
        Whether several panels are lettered (a), (b), ...
    title : str
        Of the figure.
    same_y : bool
        Whether all panels have the same y axis, which the first column shows.
    """
    colours = _colours(len(panels[0]))
    with style():
        figure, placed = _empty_figure(panels, registered, same_y)
        is_lettered = lettered and len(panels) > 1
        letters = iter("abcdefghijklmnopqrstuvwxyz" if is_lettered else "")
        of_figure: dict[str, dict[str, Artist]] = {}  # by label: panels have entries in common
        for axes, cases, shares_x in placed:
            handles, panel = draw_panel(axes, cases, colours), cases[0]
            if panel.legend in LEGENDS_OF_FIGURE:
                entries = of_figure.setdefault(panel.legend, {})
                entries.update({str(handle.get_label()): handle for handle in handles})
            elif handles:
                _add_legend(axes, handles, panel)
            # strips of stick and slip zones belong to the panel above them and have no letter
            if not panel.strips and (letter := next(letters, "")):
                axes.set_title(f"({letter})", loc="right", fontsize=9)
            if same_y and panel.column != panels[0][0].column:
                axes.set_ylabel("")
                axes.tick_params(labelleft=False)
            if shares_x:
                axes.set_xlabel("")
                axes.tick_params(labelbottom=False)
        for place, entries in of_figure.items():
            columns = len(entries) if place == "figure below" else 1
            figure.legend(
                handles=list(entries.values()), loc=LEGENDS_OF_FIGURE[place], ncols=columns
            )
        if len(panels[0]) > 1:
            names = _case_legend(labels, colours)
            figure.legend(handles=names, loc="outside upper center", ncols=min(len(names), 3))
        if title:
            figure.suptitle(title, fontsize=9)
    return figure


def _colours(cases: int) -> list[str | None]:
    """Return the colours of several cases; None for a single one, which has those of its curves."""
    if cases == 1:
        return [None]
    return [COLOURS[SERIES[k % len(SERIES)]] for k in range(cases)]


def _empty_figure(
    panels: Sequence[Sequence[Panel]], registered: bool, same_y: bool
) -> tuple[Picture, list[tuple[Axes, Sequence[Panel], bool]]]:
    """Return an empty figure, and (axes, panel of each result, flag) for each panel.

    The flag is True for axes that share the x axis of those below them, which alone has numbers.
    A ``registered`` figure is one of pyplot's; with ``same_y`` all panels share the y axis.
    """
    columns: dict[str, list[Sequence[Panel]]] = {}
    for cases in panels:
        columns.setdefault(cases[0].column, []).append(cases)
    heights = [[_height(cases) for cases in column] for column in columns.values()]
    widths = [max(cases[0].width for cases in column) for column in columns.values()]
    # [in] for the labels of the lowest x axis, and for a heading above a single panel
    height = max(map(sum, heights)) + (0.1 if len(panels) > 1 else 0.4)
    legend = LEGEND_WIDTH if panels[0][0].legend == "figure right" else 0.0
    figure = Picture.new((sum(widths) + legend, height), registered)
    placed: list[tuple[Axes, Sequence[Panel], bool]] = []
    for column, cells in zip(columns.values(), _cells(figure, heights, widths), strict=True):
        # of each panel but the lowest: whether it has the x axis of the one below it
        shared = [below[0].x == above[0].x for above, below in pairwise(column)]
        first: Axes | None = None
        for row, cases in enumerate(column):
            above = first if row and shared[row - 1] else None
            y = placed[0][0] if same_y and placed else None
            axes = figure.add_subplot(cells[row], sharex=above, sharey=y)
            first = above or axes
            placed.append((axes, cases, row < len(shared) and shared[row]))
    return figure, placed


def _cells(
    figure: Figure, heights: Sequence[Sequence[float]], widths: Sequence[float]
) -> list[list[SubplotSpec]]:
    """Return the places of the panels by columns; panels of one height are equally large.

    ``heights`` are those of the panels of each column, ``widths`` those of the columns [inches].
    """
    rows = max(map(len, heights))
    if len({height for column in heights for height in column}) == 1:
        grid = figure.add_gridspec(rows, len(widths), width_ratios=widths)
        return [[grid[row, place] for row in range(rows)] for place in range(len(widths))]
    grid = figure.add_gridspec(1, len(widths), width_ratios=widths)
    columns = []
    for place, column in enumerate(heights):
        cells = grid[0, place].subgridspec(len(column), 1, height_ratios=column)
        columns.append([cells[row] for row in range(len(column))])
    return columns


def _height(cases: Sequence[Panel]) -> float:
    """Return the height of a panel; strips of several cases stand below each other."""
    return cases[0].height * (len(cases) if cases[0].strips else 1)


def _draw_into(axes: Axes, cases: Sequence[Panel], labels: Sequence[str]) -> None:
    """Plot a panel with a legend in the user's axes."""
    colours = _colours(len(cases))
    handles = draw_panel(axes, cases, colours)
    if len(cases) > 1:
        handles += _case_legend(labels, colours)
    if handles:
        axes.legend(handles=handles)
        # the axes of a right scale lie over these
        for twin in axes.get_shared_x_axes().get_siblings(axes):
            if twin is not axes and twin.bbox.bounds == axes.bbox.bounds:
                axes.set_zorder(twin.get_zorder() + 1)  # the legend covers its curves
                axes.patch.set_visible(False)


def check_axes(ax: Axes | None, choice: str | Sequence[str] | None) -> None:
    """Reject an ``ax`` that is no Axes, and a choice of several panels for it.

    Raises
    ------
    InvalidProblem
    """
    if ax is None:
        return
    if not isinstance(ax, Axes):
        raise InvalidProblem.at("ax", f"{quote(ax)} is out of place; must be matplotlib's Axes")
    if choice is not None and not isinstance(choice, str) and len(choice) > 1:
        text = f"{len(choice)} panels are selected for one ax; select one panel, or omit ax"
        raise InvalidProblem.at("panels", text)


# ---- one panel ----------------------------------------------------------------------------------


def draw_panel(axes: Axes, cases: Sequence[Panel], colours: Colours = (None,)) -> list[Artist]:
    """Plot a panel of one or several results in axes.

    Parameters
    ----------
    axes : Axes
    cases : sequence of Panel
        The same panel of each result.
    colours : sequence of str or None
        Of each result; None for a single one.

    Returns
    -------
    list of Artist
        Entries for a legend; of several results the line styles in grey, if there are several.
    """
    panel, alone = cases[0], len(cases) == 1  # the first one states what all have in common
    handles: list[Artist | None] = []
    if alone:
        handles += [_draw_area(axes, panel, area) for area in panel.areas]
    right = axes.twinx() if panel.right else axes
    for case, colour in zip(cases, colours, strict=True):
        curves = [curve for curve in case.curves if alone or not curve.alone]
        drawn = [_draw_curve(right if c.right else axes, case, c, colour) for c in curves]
        marks = [mark for mark in case.marks if alone or not mark.alone]
        drawn += [_draw_mark(axes, case, mark, colour if mark.value else None) for mark in marks]
        if case.map:
            drawn += _draw_map(axes, case, case.map, colour)
        if case is panel:  # the entries of the other results are the same in other colours
            handles = drawn + handles
    if panel.regions:
        handles = _draw_regions(axes, panel, panel.regions) + handles
    if panel.discs and panel.scale:
        _draw_discs(axes, panel, panel.discs, panel.scale)
    handles += [_draw_bars(axes, bars) for case in cases for bars in case.bars]
    if panel.strips:
        handles += _draw_strips(axes, cases, colours)
    if panel.note:
        _write_note(axes, panel.note)
    if panel.heading:
        axes.set_title(formulas(panel.heading), fontsize=9, loc="left")
    if panel.to_scale:
        axes.set_aspect("equal")
        axes.grid(visible=False)
    x = [curve.x for case in cases for curve in case.curves]
    _format_axis(axes, "x", [case.x for case in cases], x, _length_of_x(panel))
    left = [curve.y for case in cases for curve in case.curves if not curve.right]
    _format_axis(axes, "y", [case.y for case in cases], left, panel.height)
    if panel.right:
        right.set_ylabel(axis_label(panel.right))
        if limits := [case.right.limits for case in cases if case.right and case.right.limits]:
            right.set_ylim(*_shown(panel.right, np.array(widest(limits))))
        right.yaxis.set_major_formatter(_TickLabels(useOffset=False))
        right.grid(visible=False)
    entries = [handle for handle in handles if handle is not None]
    if len(entries) == 1 and not any(curve.label for curve in panel.curves) and not panel.map:
        return []  # the label of the axis names the only curve
    return entries if alone else _in_grey(entries)


def _length_of_x(panel: Panel) -> float:
    """Return the length of the x axis of a panel [inches], labels of the y axis included."""
    length = panel.width - (LEGEND_WIDTH if panel.legend == "right" else 0.0)
    if panel.to_scale and panel.x.limits and panel.y.limits:
        (left, right), (low, high) = panel.x.limits, panel.y.limits
        length = min(length, panel.height * (right - left) / (high - low))
    return length


def _write_note(axes: Axes, note: str) -> None:
    """Write a text in place of missing contents, whose axes have no numbers."""
    axes.text(0.5, 0.5, note, ha="center", transform=axes.transAxes)
    axes.tick_params(bottom=False, labelbottom=False)
    if len(axes.get_shared_y_axes().get_siblings(axes)) == 1:
        axes.tick_params(left=False, labelleft=False)
    axes.grid(visible=False)


def _in_grey(handles: Sequence[Artist]) -> list[Artist]:
    """Return the legend of several results: the line styles in grey, if there are several."""
    lines = [handle for handle in handles if isinstance(handle, Line2D)]
    if len(lines) < 2 and len(handles) < 2:
        return []  # the label of the axis names the only curve
    plain: list[Artist] = [
        Line2D([], [], color=NEUTRAL, linestyle=line.get_linestyle(), label=line.get_label())
        for line in lines
    ]
    return plain + [handle for handle in handles if handle not in lines]


def _case_legend(labels: Sequence[str], colours: Colours) -> list[Artist]:
    """Return the legend of several results."""
    return [
        Line2D([], [], color=colour, linewidth=3, label=label)
        for label, colour in zip(labels, colours, strict=True)
    ]


def _add_legend(axes: Axes, handles: list[Artist], panel: Panel) -> None:
    """Add the legend of a panel; above it, it covers no data."""
    if panel.legend == "inside":
        axes.legend(handles=handles)
    elif panel.legend == "right":
        axes.legend(handles=handles, loc="center left", bbox_to_anchor=(1.0, 0.5))
    elif panel.legend == "stacked":
        axes.legend(handles=handles, loc="lower center", bbox_to_anchor=(0.3, 1.0))
    else:
        many = {"columnspacing": 0.8, "handlelength": 1.1, "handletextpad": 0.4}
        few = {"columnspacing": 1.4, "handlelength": 2.2}
        axes.legend(
            handles=handles,
            loc="lower left",
            bbox_to_anchor=(0.0, 1.0),
            # in one line, or in two: half of them, rounded up
            ncols=len(handles) if len(handles) < 7 else -(-len(handles) // 2),
            borderaxespad=0.2,
            **(many if len(handles) > 4 else few),
        )


# ---- axes ---------------------------------------------------------------------------------------


class _TickLabels(ScalarFormatter):
    """Labels with their power of ten, "1.5e8"; a common one would stand below the legend."""

    def __call__(self, x: float, pos: int | None = None) -> str:
        """Return the label of a tick."""
        power = super().get_offset().removeprefix("1")  # "1e8" of all ticks
        return super().__call__(x, pos) + (power if x else "")

    def get_offset(self) -> str:
        """Return the text at the end of the axis: none."""
        return ""


def _shown(axis: Axis | None, values: Array | float) -> Any:
    """Return values along an axis in the unit for display."""
    return axis.quantity.shown(values) if axis is not None and axis.quantity else values


def _format_axis(
    axes: Axes, name: str, cases: Sequence[Axis], values: Sequence[Array], length: float
) -> None:
    """Set label, scale and limits of an axis of a panel of one or several results.

    Parameters
    ----------
    axes : Axes
    name : {"x", "y"}
    cases : sequence of Axis
        The axis of each result.
    values : sequence of arrays
        Of all curves along the axis [SI].
    length : float
        Of the axis [inches].
    """
    axis, lines = cases[0], axes.xaxis if name == "x" else axes.yaxis
    lines.set_label_text(axis_label(axis, int(CHARACTERS * length)))
    if isinstance(lines.get_major_formatter(), ScalarFormatter):  # numbers, no names of strips
        lines.set_major_formatter(_TickLabels(useOffset=False))
    if name == "x":
        lines.set_major_locator(MaxNLocator(min(9, int(length / TICK_WIDTH)), steps=STEPS))
    if axis.names:
        names = [wrapped_text(formulas(each), NAME_WIDTH) for each in axis.names]
        lines.set_ticks(range(len(names)), names)
        if name == "x":
            axes.tick_params(axis="x", rotation=20)
    limits = [ends for case in cases if (ends := case.limits or case.cut)]
    ends = _shown(axis, np.array(widest(limits))) if limits else None
    if axis.log:
        finite = np.concatenate(
            [value[np.isfinite(value) & (value > 0)] for value in values] or [[]]
        )
        _set_log_scale(axes, name, ends if ends is not None else _shown(axis, finite))
    if ends is not None:
        axes.set(**{f"{name}lim": tuple(ends)})
    elif axis.from_zero and name == "y":
        finite = np.concatenate([value[np.isfinite(value)] for value in values])
        if finite.min() >= -ROUNDING * abs(finite).max():
            # the usual margin is a part of the range of the values, which zero extends
            top = (1 + mpl.rcParams["axes.ymargin"]) * _shown(axis, finite.max())
            axes.set_ylim(bottom=0, top=max(top, axes.get_ylim()[1]))


def _set_log_scale(axes: Axes, name: str, values: Array) -> None:
    """Make an axis logarithmic, with plain numbers as labels if it has few decades.

    ``values`` are the ends of the axis, or the values along it, in the unit for display.
    """
    axes.set(**{f"{name}scale": "log"})
    axis, ratio = axes.xaxis if name == "x" else axes.yaxis, np.max(values) / np.min(values)
    if ratio < FEW_DECADES:
        one_decade = MaxNLocator(5, steps=STEPS)
        axis.set_major_locator(
            one_decade if ratio < ONE_DECADE else LogLocator(subs=(1.0, 2.0, 5.0))
        )
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axis.set_minor_formatter(NullFormatter())


# ---- contents -----------------------------------------------------------------------------------


def _draw_area(axes: Axes, panel: Panel, area: Area) -> Artist | None:
    """Shade an area; return its legend entry, None without a label."""
    x, low, high = _shown(panel.x, area.x), _shown(panel.y, area.low), _shown(panel.y, area.high)
    # "mu p" becomes "$\\mu p$", and "$\\pm \\mu p$"
    label = f"$\\pm {formulas(f'${area.label}$')[1:]}" if area.symmetrical else formulas(area.label)
    shade = axes.fill_between(x, low, high, linewidth=0, label=label, **SHADES[area.shade])
    return shade if area.label else None


def _draw_curve(axes: Axes, panel: Panel, curve: Curve, colour: str | None) -> Artist | None:
    """Plot a curve or points, with error bars if there are some; return the legend entry."""
    y_axis = panel.right if curve.right else panel.y
    x, y = _shown(panel.x, curve.x), _shown(y_axis, curve.y)
    colour = colour or COLOURS[curve.colour]
    axis_words = "(right axis)" if curve.right else ""
    words = (symbol_text(curve.symbol), formulas(curve.label), axis_words)
    label = " ".join(filter(None, words))
    look: dict[str, Any] = {
        "color": colour,
        "linestyle": LINES[curve.line],
        "linewidth": curve.width,
        "marker": MARKERS[curve.marker],
        "markersize": 4,
        "markerfacecolor": "white" if curve.marker == "ring" else colour,
        "alpha": curve.opacity,
        "drawstyle": "steps-mid" if curve.steps else "default",
        "clip_on": not (curve.line == "none" and x.size == 1),  # a point at the edge is whole
        # points over lines, faint ones below
        "zorder": (3 if curve.opacity == 1 else 1.5) if curve.line == "none" else 2,
        "label": wrapped_text(label, NAME_WIDTH if panel.legend == "inside" else 44) or None
        if panel.legend in ("right", "figure right", "inside")
        else label or None,
        "rasterized": x.size > MANY_POINTS,
    }
    errors = {"xerr": (panel.x, curve.x_error), "yerr": (y_axis, curve.y_error)}
    lengths = {
        name: np.abs(_shown(axis, error))
        for name, (axis, error) in errors.items()
        if error is not None
    }
    entry: Any
    if lengths:
        entry = axes.errorbar(x, y, elinewidth=0.9, **lengths, **look)
    else:
        (entry,) = axes.plot(x, y, **look)
    return entry if label and curve.in_legend else None


def _draw_mark(axes: Axes, panel: Panel, mark: Mark, colour: str | None) -> Artist | None:
    """Plot a straight line across the panel; return its legend entry, None if it has none.

    ``colour`` is that of the result among several; None for the colour of the mark.
    """
    axis = panel.y if mark.along == "x" else panel.x
    label = formulas(mark.label)
    if mark.symbol and axis.quantity:
        label = f"{symbol_text(mark.symbol)} {text_of(axis.quantity, mark.value, '.5g')}"
    draw = axes.axhline if mark.along == "x" else axes.axvline
    line = draw(
        _shown(axis, mark.value),
        color=colour or COLOURS[mark.colour],
        linestyle=LINES[mark.line],
        linewidth=0.8,
        label=None if mark.written else label or None,
    )
    if mark.written:
        axes.annotate(
            label,
            (0.99, _shown(axis, mark.value)),
            xytext=(0, 2),
            xycoords=("axes fraction", "data"),
            textcoords="offset points",
            color=COLOURS[mark.colour],
            ha="right",
            va="bottom",
        )
    return line if label and not mark.written else None


def _draw_map(axes: Axes, panel: Panel, plane: Map, colour: str | None) -> list[Artist | None]:
    """Plot contours, over the coloured values of a single result; return the legend entries.

    ``colour`` is that of the result among several, whose values would cover each other.
    """
    scale = panel.scale
    x, y = _shown(panel.x, plane.x), _shown(panel.y, plane.y)
    values = _shown(scale.axis if scale else None, plane.values)
    if scale and scale.axis.limits and colour is None:
        low, high = _shown(scale.axis, np.array(scale.axis.limits))
        about_zero = scale.palette != "sequential"
        levels = MaxNLocator(LEVELS, symmetric=about_zero, steps=STEPS).tick_values(low, high)
        palette, extend = PALETTES[scale.palette], EXTENDED[scale.clipped]
        filled = axes.contourf(x, y, values, levels, cmap=palette, extend=extend)
        _add_colour_bar(axes, panel, scale, filled)
    entries: list[Artist | None] = []
    for contour in plane.contours:
        line: Any = {"color": colour or COLOURS["ink"], "linestyle": LINES[contour.line]}
        if np.nanmin(plane.values) < contour.level < np.nanmax(plane.values):
            level = _shown(scale.axis if scale else None, contour.level)
            drawn = axes.contour(
                x, y, values, [level], colors=line["color"], linestyles=line["linestyle"]
            )
            if any(np.size(path.vertices) for path in drawn.get_paths()):  # none next to a gap
                entries.append(Line2D([], [], label=formulas(contour.label), **line))
    return entries


def _draw_regions(axes: Axes, panel: Panel, regions: Regions) -> list[Artist | None]:
    """Plot regions in their colours; return the legend entries."""
    x, y = _shown(panel.x, regions.x), _shown(panel.y, regions.y)
    entries: list[Artist | None] = []
    for k, (name, colour) in enumerate(zip(regions.names, regions.colours, strict=True)):
        if (regions.index == k).any():
            axes.pcolormesh(
                x,
                y,
                np.where(regions.index == k, 1.0, np.nan),
                cmap=ListedColormap([COLOURS[colour]]),
                alpha=FAINT,
                shading="nearest",
                rasterized=True,
                linewidth=0,
            )
            entries.append(Patch(facecolor=COLOURS[colour], alpha=FAINT, label=name))
    return entries


def _draw_discs(axes: Axes, panel: Panel, discs: Sequence[Disc], scale: Scale) -> None:
    """Plot cross sections of rolls; several are named by their radii."""
    assert scale.axis.limits is not None
    low, high = _shown(scale.axis, np.array(scale.axis.limits))
    angle = np.linspace(0, 2 * np.pi, AROUND)
    for disc in discs:  # values are (k,) over the radius, and repeated around the disc
        r, left = _shown(panel.x, disc.radius), _shown(panel.x, disc.left)
        x, y = left + r[-1] + np.outer(r, np.cos(angle)), np.outer(r, np.sin(angle))
        mesh = axes.pcolormesh(
            x,
            y,
            np.repeat(_shown(scale.axis, disc.values)[:, None], AROUND, 1),
            cmap=PALETTES[scale.palette],
            vmin=low,
            vmax=high,
            shading="gouraud",
            rasterized=True,
        )
        axes.fill(x[0], y[0], facecolor="#D9D9D9", edgecolor=NEUTRAL, linewidth=0.8)
        if len(discs) > 1:
            lowest = -0.05 * _shown(panel.x, discs[-1].radius[-1])
            axes.text(left + r[-1], lowest, f"{r[-1]:.3g}", ha="center", va="top")
    _add_colour_bar(axes, panel, scale, mesh)
    axes.set_aspect("equal")
    axes.margins(0.03)
    axes.grid(visible=False)
    if len(discs) > 1:
        axes.set_axis_off()
        axes.text(0, 1.0, axis_label(panel.x), transform=axes.transAxes, va="top")


def _add_colour_bar(axes: Axes, panel: Panel, scale: Scale, coloured: ScalarMappable) -> None:
    """Add the scale of coloured values at the right of a panel, as tall as the panel."""
    bounds = (1 + BAR_GAP / panel.width, 0.0, BAR_WIDTH / panel.width, 1.0)
    bar = axes.inset_axes(bounds, label="<colorbar>")
    label, extend = axis_label(scale.axis), EXTENDED[scale.clipped]
    axes.figure.colorbar(coloured, cax=bar, label=label, extend=extend, format=_TickLabels())


def _draw_bars(axes: Axes, bars: Bars) -> Any:
    """Plot horizontal bars; return their legend entry."""
    positions = np.arange(bars.values.size) + bars.shift
    errors = None if bars.interval is None else np.abs(bars.interval - bars.values)
    drawn = axes.barh(
        positions,
        bars.values,
        height=0.38,
        xerr=errors,
        label=bars.label,
        color=COLOURS[bars.colour],
        error_kw={"linewidth": 0.9},
    )
    return drawn if bars.label else None


def _draw_strips(axes: Axes, cases: Sequence[Panel], colours: Colours) -> list[Artist | None]:
    """Plot zones as bars along x, the first face on top; return the entries of the legend.

    ``colours`` are those of the names of the faces of each result; None for a single one.
    """
    strips = [
        (strip, colour)
        for case, colour in zip(cases, colours, strict=True)
        for strip in case.strips
    ]
    rows = range(len(strips))[::-1]
    for row, (strip, _) in zip(rows, strips, strict=True):
        for zone, first, last in strip.runs:
            left, right = _shown(cases[0].x, np.array([first, last]))
            look = zone_look(zone)
            axes.barh(row, right - left, left=left, height=0.7, linewidth=0.6, **look)
    axes.set_yticks(list(rows), [strip.face for strip, _ in strips])
    for text, (_, colour) in zip(axes.get_yticklabels(), strips, strict=True):
        if colour is not None:
            text.set_color(colour)
    axes.set_ylim(-0.55, len(rows) - 0.45)
    axes.grid(visible=False)
    axes.tick_params(axis="y", length=0)
    slower, stick, faster = cases[0].words
    words = {0: stick, 1: f"slip, {faster}", -1: f"slip, {slower}"}
    return [Patch(**zone_look(zone), label=word) for zone, word in words.items()]
