"""``wo.plot``: figures of one or several results."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, overload

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from .. import kinds, quantities
from ..arguments import check_type
from ..errors import InvalidProblem, one_of
from ..problems.messages import quote
from ..results import Result
from .drawing import check_axes, draw_figure, show_panels
from .figures import named_value
from .panels import Panel
from .result_panels import chosen, named_panels

__all__ = ["figure_for_file", "figures_of_columns", "plot"]


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
        "tension", of a wrapped one "wrap_tension" and "wrap_pressure" too, with further nips
        "contacts_tension", of rollers "tractions", "slip", "zones"; of every kind any array by its
        name.
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
    check_axes(ax, panels)
    all_results, labels = _labelled(results, labels)
    return show_panels(_panels(all_results, panels), labels, path, ax)


def figure_for_file(
    results: Sequence[Result] | Result,
    *,
    labels: Sequence[str] | None = None,
    panels: str | Sequence[str] | None = None,
) -> Figure:
    """Return the figure of :func:`plot` for a file: not registered with a window or notebook."""
    all_results, labels = _labelled(results, labels)
    return draw_figure(_panels(all_results, panels), labels)


def figures_of_columns(
    results: Sequence[Result], labels: Sequence[str], size: float = 1.0, low: float = 1.0
) -> list[tuple[str, Figure]]:
    """Return each column of the figure of :func:`plot` as a figure, with the names of its panels.

    Parameters
    ----------
    results, labels
        As of :func:`plot`.
    size : float
        Of the panels, relative to those of :func:`plot`; letters have their usual size.
    low : float
        Further factor of the heights of more than two columns.

    Raises
    ------
    InvalidProblem
        For results without common panels.
    """
    columns: dict[str, list[list[Panel]]] = {}
    for cases in _panels(results, None):
        columns.setdefault(cases[0].column, []).append(cases)
    height = size * (low if len(columns) > 2 else 1.0)
    columns = {
        name: [
            [
                replace(panel, width=size * panel.width, height=height * panel.height)
                for panel in cases
            ]
            for cases in column
        ]
        for name, column in columns.items()
    }
    return [
        (", ".join(cases[0].name for cases in column), draw_figure(column, labels, lettered=False))
        for column in columns.values()
    ]


def _labelled(results: Any, labels: Sequence[str] | None) -> tuple[list[Result], Sequence[str]]:
    """Return the results as a list, and their labels; by default those that distinguish them."""
    all_results: list[Any] = list(results) if isinstance(results, list | tuple) else [results]
    for result in all_results:
        check_type("results", result, Result)
    if not all_results:
        raise InvalidProblem.at("results", "there is none to plot")
    if labels is None:
        labels = _labels(all_results) if len(all_results) > 1 else [""]
    elif isinstance(labels, str) or len(labels) != len(all_results):
        raise InvalidProblem.at(
            "labels", f"{quote(labels)} is out of place; must be {len(all_results)}, one a result"
        )
    return all_results, labels


def _panels(results: Sequence[Result], choice: str | Sequence[str] | None) -> list[list[Panel]]:
    """Return the chosen panels that all results have, or those drawn by default.

    Each is a list with the panel of every result.
    """
    makers = [named_panels(result) for result in results]
    first, *others = makers
    # panels of one name that the same function makes
    common = [
        name
        for name, maker in first.items()
        if all(name in other and other[name].make == maker.make for other in others)
    ]
    default = [name for name in common if first[name].by_default]
    if not (default if choice is None else common):
        names = sorted({kinds.of(result).name for result in results})
        text = f"results of {one_of(names, 'and')} have no panel in common"
        raise InvalidProblem.at("results", text)
    names = default if choice is None else chosen(choice, common)
    panels = [
        [each[name].make(result) for each, result in zip(makers, results, strict=True)]
        for name in names
    ]
    for cases in panels:
        units = {case.y.quantity.unit for case in cases if case.y.quantity}
        if len(units) > 1:
            text = (
                f"{cases[0].name!r} has no common unit ({', '.join(sorted(units))}); leave it out"
            )
            raise InvalidProblem.at("panels", text)
    return panels


def _labels(results: Sequence[Any]) -> list[str]:
    """Return labels that distinguish several results: kinds and one or two fields, or numbers."""
    # the fields of each problem by path, and the paths of those in which the problems differ
    fields = [{place.path: place for place in quantities.walk(r.problem)} for r in results]
    differ = [
        path
        for path in fields[0]
        if len({str(each[path].value) if path in each else None for each in fields}) > 1
    ]
    words = [kinds.of(r).name.replace("_", " ") for r in results]
    texts = [
        ", ".join(
            [
                *([word] if len(set(words)) > 1 else []),
                *(
                    named_value(path, each[path].quantity, each[path].value)
                    for path in differ[:2]
                    if path in each
                ),
            ]
        )
        for word, each in zip(words, fields, strict=True)
    ]
    # two fields do not tell all differences, or labels are equal or empty
    if len(differ) > 2 or len(set(texts)) < len(texts) or not all(texts):
        return [f"{word} {k}" for k, word in enumerate(words, 1)]
    return texts
