"""Selection and layout of the panels of a figure.

The plot function of a kind returns its panels by name; they do not depend on the figure that
contains them.  A panel draws one case, or several cases in different colours.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from ..errors import InvalidProblem, nearest, one_of
from ..problems.messages import quote
from .figures import COLOURS, Picture, check_format, legend_above, letter, save_figure, style

__all__ = ["Case", "Panel", "cases_of", "draw_panels"]

NEUTRAL = "#444444"


@dataclass(frozen=True, eq=False)
class Case:
    """A result in a panel; several results have different colours."""

    result: Any
    label: str = ""
    colour: str | None = None

    @property
    def alone(self) -> bool:
        """True if the panel shows a single result."""
        return self.colour is None

    def colour_or(self, colour: str) -> str:
        """Return the colour of a curve: the given one, or that of the case if there are several."""
        return self.colour or colour


def cases_of(results: Sequence[Any], labels: Sequence[str]) -> list[Case]:
    """Return the cases of results, in different colours if there are several."""
    if len(results) == 1:
        return [Case(results[0], *labels)]
    colours = (COLOURS[k % len(COLOURS)] for k in range(len(results)))
    return [Case(*case) for case in zip(results, labels, colours, strict=True)]


@dataclass(frozen=True)
class Panel:
    """One panel.

    Attributes
    ----------
    draw : callable
        (axes, cases) -> handles of its legend, those of the first case.
    column : str
        Panels of one column are drawn below each other and share their x axis.
    width, height : float
        Inches; a column has the width of its widest panel.
    strip : bool
        True for a strip of zones: it has no letter, and its height is that of one case.
    legend : {"above", "right", "below"}
        Position of the legend; "below" is below the whole figure.
    by_default : bool
        Whether the panel is drawn by default.
    """

    draw: Callable[[Axes, Sequence[Case]], Sequence[Artist]]
    column: str = ""
    width: float = 6.3
    height: float = 3.2
    strip: bool = False
    legend: str = "above"
    by_default: bool = True


Panels = Mapping[str, Panel]


def draw_panels(
    panels: Panels,
    cases: Sequence[Case],
    path: str | Path | None = None,
    ax: Axes | None = None,
    choice: str | Sequence[str] | None = None,
    *,
    lettered: bool = True,
    registered: bool | None = None,
) -> Any:
    """Plot panels in a new figure, or one panel in given axes.

    Parameters
    ----------
    panels : mapping of str to Panel
        All available panels.
    cases : sequence of Case
    path : path, optional
        File to save.  Without ``path`` and ``ax`` the figure is registered with pyplot: a notebook
        shows it, and a script shows it with ``plt.show()``.
    ax : Axes, optional
        Axes for one panel, the first one by default.
    choice : str or sequence of str, optional
        The panels to draw, in this order.
    lettered : bool
        Whether several panels are lettered (a), (b), ...
    registered : bool, optional
        Whether the figure is registered with pyplot; by default if it is not saved.

    Returns
    -------
    Figure, or Axes where these are given

    Raises
    ------
    InvalidProblem
        For an unknown panel, several panels for one ``ax``, or an unknown file format.
    """
    if path is not None:
        check_format(path)
    selection = _selected_panels(panels, choice)
    if ax is not None:
        _draw_into(ax, selection, choice, cases)
        if path is not None:
            save_figure(ax.get_figure(root=True), path)  # type: ignore[arg-type]
        return ax
    with style():
        pyplots = path is None if registered is None else registered
        figure = _figure(selection, cases, registered=pyplots, lettered=lettered)
    if path is not None:
        save_figure(figure, path)
    return figure


def _selected_panels(panels: Panels, choice: str | Sequence[str] | None) -> list[Panel]:
    """Return the chosen panels; by default those shown by default."""
    if choice is None:
        return [panel for panel in panels.values() if panel.by_default]
    names = [choice] if isinstance(choice, str) else list(choice)
    if not names:
        raise InvalidProblem.at("panels", f"none is chosen; must be {one_of(panels)}")
    for name in names:
        if name not in panels:
            suggestion = nearest(name, panels)
            hint = f"; did you mean {suggestion!r}?" if suggestion else ""
            text = f"{quote(name)} is unknown; must be {one_of(panels)}{hint}"
            raise InvalidProblem.at("panels", text)
    return [panels[name] for name in names]


def _draw_into(ax: Axes, selection: list[Panel], choice: Any, cases: Sequence[Case]) -> None:
    """Plot one panel in the user's axes, whose style and title do not change."""
    if not isinstance(ax, Axes):
        raise InvalidProblem.at("ax", f"{quote(ax)} is out of place; must be matplotlib's Axes")
    if choice is not None and len(selection) != 1:
        text = f"{len(selection)} panels are selected for one ax; select one panel, or omit ax"
        raise InvalidProblem.at("panels", text)
    handles = [*_curve_legend(selection[0].draw(ax, cases), cases), *_case_legend(cases)]
    if handles:
        ax.legend(handles=handles)
        for twin in ax.get_shared_x_axes().get_siblings(ax):
            if twin is not ax and twin.bbox.bounds == ax.bbox.bounds:
                ax.set_zorder(twin.get_zorder() + 1)  # the legend covers its curves
                ax.patch.set_visible(False)


def _figure(
    selection: list[Panel], cases: Sequence[Case], *, registered: bool, lettered: bool
) -> Picture:
    """Return a figure of panels."""
    figure, placed = _empty_figure(selection, len(cases), registered)
    letters = iter("abcdefghijklmnopqrstuvwxyz" * (lettered and len(selection) > 1))
    below_axes: list[Any] = []
    for axes, panel, lowest in placed:
        handles = _curve_legend(panel.draw(axes, cases), cases)
        if panel.legend == "below":
            below_axes = handles
        elif handles:
            _legend(axes, handles, panel)
        if not panel.strip and (mark := next(letters, "")):
            letter(axes, mark)
        if not lowest:
            axes.set_xlabel("")
            axes.tick_params(labelbottom=False)
    if below_axes:
        figure.legend(handles=below_axes, loc="outside lower center", ncols=len(below_axes))
    names = _case_legend(cases)
    if names:
        figure.legend(handles=names, loc="outside upper center", ncols=min(len(names), 3))
    return figure


def _empty_figure(
    selection: list[Panel], cases: int, registered: bool
) -> tuple[Picture, list[tuple[Axes, Panel, bool]]]:
    """Return an empty figure, and for each panel its axes and whether it is the lowest."""
    columns: dict[str, list[Panel]] = {}
    for panel in selection:
        columns.setdefault(panel.column, []).append(panel)
    heights = [[p.height * (cases if p.strip else 1) for p in c] for c in columns.values()]
    widths = [max(panel.width for panel in column) for column in columns.values()]
    # a single panel has labels above and below it too
    size = (sum(widths), max(map(sum, heights)) + (0.1 if len(selection) > 1 else 0.4))
    figure = Picture.new(size, registered)
    grid = figure.add_gridspec(1, len(columns), width_ratios=widths)
    placed: list[tuple[Axes, Panel, bool]] = []
    for place, (column, tall) in enumerate(zip(columns.values(), heights, strict=True)):
        rows = grid[0, place].subgridspec(len(column), 1, height_ratios=tall)
        first: Axes | None = None
        for row, panel in enumerate(column):
            axes = figure.add_subplot(rows[row], sharex=first)
            first = first or axes
            placed.append((axes, panel, panel is column[-1]))
    return figure, placed


def _legend(axes: Axes, handles: list[Any], panel: Panel) -> None:
    """Add the legend of a panel above its axes or to the right of them."""
    if panel.legend == "above":
        legend_above(axes, handles)
    else:
        axes.legend(handles=handles, loc="center left", bbox_to_anchor=(1.0, 0.5))


def _curve_legend(handles: Sequence[Any], cases: Sequence[Case]) -> list[Any]:
    """Return the legend entries of a panel; with several results the line styles, in grey."""
    if len(cases) == 1:
        return list(handles)
    lines = [handle for handle in handles if isinstance(handle, Line2D)]
    if len(lines) < 2 and len(handles) < 2:
        return []  # the axis says it
    plain = [
        Line2D([], [], color=NEUTRAL, linestyle=line.get_linestyle(), label=line.get_label())
        for line in lines
    ]
    return plain + [handle for handle in handles if handle not in lines]


def _case_legend(cases: Sequence[Case]) -> list[Line2D]:
    """Return the legend of several cases."""
    if len(cases) == 1:
        return []
    return [Line2D([], [], color=case.colour, linewidth=3, label=case.label) for case in cases]
