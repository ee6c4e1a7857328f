"""``wo.plot``: figures of one or several results, and of the arrays of any kind.

A kind's panels are found through :mod:`woundon.kinds`; of woundon, only this room imports
matplotlib.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, overload

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from .. import kinds, quantities
from ..arguments import check_type
from ..errors import InvalidProblem, one_of
from ..problems.messages import quote
from ..results import Result
from .figures import (
    COLOURS,
    axis_label,
    quantity_of,
    symbol_text,
    text_of,
    unit_of,
    wrapped_text,
)
from .nip_plots import nip_panels
from .panels import Case, Panel, cases_of, draw_panels
from .roll_plots import roll_panels
from .roller_plots import roller_panels
from .winding_plots import winding_panels

__all__ = ["figure_for_file", "output_panels", "panel_columns", "panels_of", "plot"]

PANELS: Mapping[str, Callable[[Any], Mapping[str, Panel]]] = {
    "nip": nip_panels,
    "rollers": roller_panels,
    "roll": roll_panels,
    "winding": winding_panels,
}
LINES = ("-", "--", "-.", ":")


@overload
def plot(
    results: Sequence[Result] | Result,
    path: str | Path | None = None,
    ax: None = None,
    panels: str | Sequence[str] | None = None,
    *,
    labels: Sequence[str] | None = None,
) -> Figure: ...


@overload
def plot(
    results: Sequence[Result] | Result,
    path: str | Path | None = None,
    *,
    ax: Axes,
    panels: str | Sequence[str] | None = None,
    labels: Sequence[str] | None = None,
) -> Axes: ...


def plot(
    results: Sequence[Result] | Result,
    path: str | Path | None = None,
    ax: Axes | None = None,
    panels: str | Sequence[str] | None = None,
    *,
    labels: Sequence[str] | None = None,
) -> Any:
    """Plot one result, or several in one figure.

    Parameters
    ----------
    results : Result, or sequence of them
        Results of one kind, or of kinds with common panels such as a nip and a wrapped nip.
    path : path, optional
        Output file, ``.png``, ``.svg`` or ``.pdf``.  Without ``path`` and ``ax`` a notebook shows
        the figure; a script needs ``plt.show()``.
    ax : matplotlib.axes.Axes, optional
        Axes for one panel; the first panel unless ``panels`` names another.
    panels : str or sequence of str, optional
        Panels in the order of drawing: of a nip "tractions", "slips", "zones", "pressure",
        "tension", of a wrapped one "wrap_tension" and "wrap_pressure" too, of rollers "tractions",
        "slip", "zones"; of every kind any array by its name.
    labels : sequence of str, optional
        Labels of several results; by default the fields in which their problems differ.

    Returns
    -------
    matplotlib.figure.Figure, or ``ax`` where it is given

    Raises
    ------
    InvalidProblem
        For an unknown panel, results without common panels, or an unknown file format.

    Examples
    --------
    >>> import woundon as wo
    >>> import matplotlib.pyplot as plt
    >>> result = wo.solve(wo.RollerProblem.example())
    >>> figure, ax = plt.subplots()
    >>> wo.plot(result, ax=ax, panels="tractions") is ax
    True
    >>> plt.close(figure)
    """
    all_results, cases = _cases(results, labels)
    return draw_panels(_common_panels(all_results), cases, path, ax, panels)


def figure_for_file(
    results: Sequence[Result] | Result,
    *,
    labels: Sequence[str] | None = None,
    panels: str | Sequence[str] | None = None,
    lettered: bool = True,
) -> Figure:
    """Return the figure of :func:`plot` for a file: not registered with a window or notebook."""
    all_results, cases = _cases(results, labels)
    options: Any = {"choice": panels, "lettered": lettered, "registered": False}
    figure: Figure = draw_panels(_common_panels(all_results), cases, **options)
    return figure


def panel_columns(results: Sequence[Result]) -> list[list[str]]:
    """Return the names of the panels of a plot of results, by columns."""
    columns: dict[str, list[str]] = {}
    for name, panel in _common_panels(results).items():
        if panel.by_default:
            columns.setdefault(panel.column, []).append(name)
    return list(columns.values())


def _cases(results: Any, labels: Sequence[str] | None) -> tuple[list[Any], list[Case]]:
    """Return the results as a list, and as cases with labels and colours."""
    all_results: list[Any] = list(results) if isinstance(results, list | tuple) else [results]
    for result in all_results:
        check_type("results", result, Result)
    if not all_results:
        raise InvalidProblem.at("results", "there is none to plot")
    if labels is None:
        labels = _labels(all_results) if len(all_results) > 1 else [""]
    elif isinstance(labels, str) or len(labels) != len(all_results):
        raise InvalidProblem.at(
            "labels", f"{quote(labels)} must be {len(all_results)}, one a result"
        )
    return all_results, cases_of(all_results, labels)


def _common_panels(results: Sequence[Result]) -> dict[str, Panel]:
    """Return the panels that all results have, by name."""
    first, *others = [_panels(result) for result in results]
    common = {
        name: panel
        for name, panel in first.items()
        if all(other.get(name) == panel for other in others)
    }
    if not any(panel.by_default for panel in common.values()):
        names = sorted({kinds.of(result).name for result in results})
        text = f"results of {one_of(names, 'and')} have no panel in common"
        raise InvalidProblem.at("results", text)
    return common


def panels_of(result: Result) -> dict[str, Panel]:
    """Return the panels of the kind of a result."""
    kind = kinds.of(result)
    panels = kind.plot or PANELS.get(kind.name, output_panels)
    return dict(panels(result))


def _panels(result: Result) -> dict[str, Panel]:
    """Return the panels of the kind, then optional ones for every array."""
    panels = panels_of(result)
    abscissa, *names = _plotted_arrays(result) or [""]
    for name in names:
        panels.setdefault(
            name, Panel(Curves(abscissa, (name,)), "outputs", height=2.8, by_default=False)
        )
    return panels


def _labels(results: Sequence[Any]) -> list[str]:
    """Return labels that distinguish several results: kinds and one or two fields, or numbers."""
    fields = [{place.path: place for place in quantities.walk(r.problem)} for r in results]
    differ = [
        path
        for path in fields[0]
        if len({str(t[path].value) if path in t else None for t in fields}) > 1
    ]
    words = [kinds.of(r).name.replace("_", " ") for r in results]
    texts = [
        ", ".join(
            [
                *([word] if len(set(words)) > 1 else []),
                *(_value_text(t[path]) for path in differ[:2] if path in t),
            ]
        )
        for word, t in zip(words, fields, strict=True)
    ]
    if len(differ) > 2 or len(set(texts)) < len(texts) or not all(texts):
        return [f"{word} {k}" for k, word in enumerate(words, 1)]
    return texts


def _value_text(place: quantities.Place) -> str:
    """Return "nip load = 2000 N/m"."""
    name, quantity = place.name.replace("_", " "), place.quantity
    if quantity is None or not isinstance(place.value, int | float):
        return f"{name} = {place.value}"
    return f"{name} = {text_of(quantity, place.value, '.5g')}"


# ---- any kind -----------------------------------------------------------------------------------


@dataclass(frozen=True)
class Curves:
    """Curves of the arrays of one unit over the first array of a result."""

    along: str
    names: tuple[str, ...]

    def __call__(self, axes: Axes, cases: Sequence[Case]) -> list[Any]:
        """Plot the arrays."""
        handles: list[Any] = []
        x, y = (quantity_of(cases[0].result, name) for name in (self.along, self.names[0]))
        for case in cases:
            curves: list[Line2D] = []
            at = x.shown(getattr(case.result, self.along))
            for k, name in enumerate(self.names):
                quantity, values = quantity_of(case.result, name), getattr(case.result, name)
                whole = values.dtype.kind in "iub"
                curves += axes.plot(
                    at,
                    y.shown(values),
                    LINES[k % 4],
                    color=case.colour_or(COLOURS[k % 7]),
                    drawstyle="steps-mid" if whole else "default",
                    label=wrapped_text(f"{symbol_text(quantity.symbol)}  {quantity.meaning}"),
                )
            handles = handles or list(curves)
        axes.set_xlabel(axis_label(x.meaning[:1].upper() + x.meaning[1:], x))
        if len(self.names) == 1:
            axes.set_ylabel(axis_label(wrapped_text(y.meaning, 30), y))
            return []
        axes.set_ylabel(f"[{unit_of(y)}]" if y.display else "")
        return handles


def output_panels(result: Result) -> dict[str, Panel]:
    """Return panels with every array of a result over its first one.

    One for each unit, named after its arrays; whole numbers (zones, states) have one of their own.
    Arrays of another length than the first are omitted.

    Raises
    ------
    InvalidProblem
        For a result without arrays.
    """
    abscissa, *names = _plotted_arrays(result) or [""]
    if not names:
        raise InvalidProblem.at("plot", f"a {type(result).__name__} has no arrays to draw")
    groups: dict[tuple[str, str, bool], list[str]] = {}
    for name in names:
        whole, quantity = getattr(result, name).dtype.kind in "iub", quantity_of(result, name)
        groups.setdefault((quantity.unit, quantity.shown_unit, whole), []).append(name)
    return {
        ", ".join(group): Panel(Curves(abscissa, tuple(group)), "outputs", 9.0, 2.1, legend="right")
        for group in groups.values()
    }


def _plotted_arrays(result: Result) -> list[str]:
    """Return the names of the first array and of those with the same length."""
    arrays = [p for p in quantities.walk(result) if isinstance(p.value, np.ndarray)]
    return [p.path for p in arrays if p.value.ndim == 1 and p.value.shape == arrays[0].value.shape]
