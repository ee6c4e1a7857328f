"""Selection and layout of the panels of a figure.

A kind's plot function returns its panels by name, as its report function returns parts; they say
what is drawn, and know nothing of the figure around them.  A panel draws one case, or several in
colours of their own.
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

__all__ = ["Case", "Panel", "cases_of", "drawn"]

NEUTRAL = "#444444"


@dataclass(frozen=True, eq=False)
class Case:
    """A result in a panel; with several results each has its colour."""

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
    """Return the cases of results, in colours of their own if there are several."""
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
        Panels of one column stand below each other and share what runs along x.
    width, height : float
        Inches; the width counts once a column.
    strip : bool
        A strip of zones: no letter, and as much height for every case.
    legend : {"above", "right", "below"}
        Where it stands; "below" is below the whole figure, once.
    shown : bool
        Whether it is drawn where no panel is asked for.
    """

    draw: Callable[[Axes, Sequence[Case]], Sequence[Artist]]
    column: str = ""
    width: float = 6.3
    height: float = 3.2
    strip: bool = False
    legend: str = "above"
    shown: bool = True


Panels = Mapping[str, Panel]


def drawn(
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
        All there are.
    cases : sequence of Case
    path : path, optional
        Where to save.  Without it, and without ``ax``, the figure is pyplot's: a notebook shows
        it, in a script ``plt.show()`` does.
    ax : Axes, optional
        Into which one panel is drawn, the first one if none is chosen.
    choice : str or sequence of str, optional
        The panels to draw, in this order.
    lettered : bool
        Whether several panels are lettered (a), (b), ...
    registered : bool, optional
        Whether the figure is pyplot's; by default where it is not saved.

    Returns
    -------
    Figure, or Axes where these are given

    Raises
    ------
    InvalidProblem
        For a panel that there is not, for several into one ``ax``, for an ending of the path that
        is not a known format.
    """
    if path is not None:
        check_format(path)
    chosen = _selected_panels(panels, choice)
    if ax is not None:
        _draw_into(ax, chosen, choice, cases)
        if path is not None:
            save_figure(ax.get_figure(root=True), path)  # type: ignore[arg-type]
        return ax
    with style():
        pyplots = path is None if registered is None else registered
        figure = _figure(chosen, cases, registered=pyplots, lettered=lettered)
    if path is not None:
        save_figure(figure, path)
    return figure


def _selected_panels(panels: Panels, choice: str | Sequence[str] | None) -> list[Panel]:
    """Return the chosen panels; by default those shown by default."""
    if choice is None:
        return [panel for panel in panels.values() if panel.shown]
    names = [choice] if isinstance(choice, str) else list(choice)
    if not names:
        raise InvalidProblem.at("panels", f"none is chosen; must be {one_of(panels)}")
    for name in names:
        if name not in panels:
            near = nearest(name, panels)
            meant = f"; did you mean {near!r}?" if near else ""
            text = f"{quote(name)} is unknown; must be {one_of(panels)}{meant}"
            raise InvalidProblem.at("panels", text)
    return [panels[name] for name in names]


def _draw_into(ax: Axes, chosen: list[Panel], choice: Any, cases: Sequence[Case]) -> None:
    """Plot one panel in the user's axes, whose style and title do not change."""
    if not isinstance(ax, Axes):
        raise InvalidProblem.at("ax", f"{quote(ax)} is out of place; must be matplotlib's Axes")
    if choice is not None and len(chosen) != 1:
        text = f"{len(chosen)} panels are selected for one ax; select one panel, or omit ax"
        raise InvalidProblem.at("panels", text)
    handles = [*_curve_legend(chosen[0].draw(ax, cases), cases), *_case_legend(cases)]
    if handles:
        ax.legend(handles=handles)
        for twin in ax.get_shared_x_axes().get_siblings(ax):
            if twin is not ax and twin.bbox.bounds == ax.bbox.bounds:
                ax.set_zorder(twin.get_zorder() + 1)  # the legend covers its curves
                ax.patch.set_visible(False)


def _figure(
    chosen: list[Panel], cases: Sequence[Case], *, registered: bool, lettered: bool
) -> Picture:
    """Return a figure of panels."""
    figure, placed = _empty_figure(chosen, len(cases), registered)
    letters = iter("abcdefghijklmnopqrstuvwxyz" * (lettered and len(chosen) > 1))
    below: list[Any] = []
    for axes, panel, lowest in placed:
        handles = _curve_legend(panel.draw(axes, cases), cases)
        if panel.legend == "below":
            below = handles
        elif handles:
            _legend(axes, handles, panel)
        if not panel.strip and (mark := next(letters, "")):
            letter(axes, mark)
        if not lowest:
            axes.set_xlabel("")
            axes.tick_params(labelbottom=False)
    if below:
        figure.legend(handles=below, loc="outside lower center", ncols=len(below))
    names = _case_legend(cases)
    if names:
        figure.legend(handles=names, loc="outside upper center", ncols=min(len(names), 3))
    return figure


def _empty_figure(
    chosen: list[Panel], cases: int, registered: bool
) -> tuple[Picture, list[tuple[Axes, Panel, bool]]]:
    """Return an empty figure, and for each panel its axes and whether it is the lowest."""
    columns: dict[str, list[Panel]] = {}
    for panel in chosen:
        columns.setdefault(panel.column, []).append(panel)
    heights = [[p.height * (cases if p.strip else 1) for p in c] for c in columns.values()]
    widths = [max(panel.width for panel in column) for column in columns.values()]
    # a single panel has labels above and below it too
    size = (sum(widths), max(map(sum, heights)) + (0.1 if len(chosen) > 1 else 0.4))
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
