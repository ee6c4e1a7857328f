"""Figures of studies: curves of a sweep, a fit and its profiles, shares of variance."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from ..quantities import Quantity
from ..studies.cases import as_labels, is_numeric
from .figures import (
    COLOURS,
    Picture,
    axis_label,
    save_figure,
    style,
    text_of,
    wrapped_text,
)
from .panels import Case, Panel, draw_panels

if TYPE_CHECKING:
    from ..studies.fit_result import FitResult
    from ..studies.profiles import ProfileLikelihood
    from ..studies.run import Table
    from ..studies.sobol import SobolIndices

__all__ = ["plot_fit", "plot_indices", "plot_sweep"]

Array = np.ndarray

_LINES = ("-", "--", "-.", ":")
_MOST_CURVES, _MOST_PANELS = 7, 4
_LONG_NAME = 32  # characters; a longer one is too long for a legend


def plot_sweep(table: Table, output: str, path: str | Path | None = None) -> Figure:
    """Plot one output of a study.

    Of a grid: curves over the longest axis, a curve for each value of the next, a panel for each
    of a third; further inputs at their middle values.  At most seven curves and four panels are
    shown, spread over the values; the title gives their numbers if there are more.  Of a
    table: the output over every input.

    Parameters
    ----------
    table : Table
    output : str
    path : path, optional
        Where to save; without it the figure is pyplot's.
    """
    with style():
        draw = _grid_figure if table.cases.axes else _scatter
        figure = draw(table, output, path is None)
    if path is not None:
        save_figure(figure, path)
    return figure


def _grid_figure(table: Table, output: str, registered: bool) -> Figure:
    """Return the figure of a grid: curves over the longest axis, panels for the third."""
    shape, axes_of_grid = table.cases.shape, list(table.cases.axes.values())
    flat, text = _scaled(table.quantities.get(output), output, table.outputs[output])
    values = flat.reshape(shape)
    # numeric inputs first, then by the number of values; from the fourth on at the middle value
    inputs = sorted(range(len(shape)), key=lambda k: (not is_numeric(axes_of_grid[k]), -shape[k]))
    axes_order, fixed = inputs[:3], {k: shape[k] // 2 for k in inputs[3:]}
    values = values[tuple(fixed.get(k, slice(None)) for k in range(len(shape)))]
    values = np.transpose(values, [sorted(axes_order).index(k) for k in axes_order])
    while values.ndim < 3:
        values = values[..., None]
    panels = _evenly_spaced(values.shape[2], _MOST_PANELS)
    figure = Picture.new((3.4 * len(panels) + 1.6, 3.6), registered)
    axes = figure.subplots(1, len(panels), sharey=True, squeeze=False)[0]
    for panel, k in zip(axes, panels, strict=True):
        _draw_curves(panel, table, axes_order, values[:, :, k])
        if len(axes_order) > 2:
            panel.set_title(_value_label(table, axes_order[2], k), fontsize=9)
    axes[0].set_ylabel(text)
    if len(axes_order) > 1:
        axes[-1].legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    held_at = ", ".join(_value_label(table, k, place) for k, place in fixed.items())
    title = "; ".join(filter(None, [held_at, _omissions(values.shape)]))
    if title:
        figure.suptitle(title, fontsize=9)
    return figure


def _omissions(shape: tuple[int, ...]) -> str:
    """Return the number of curves and panels that are shown; '' if all are."""
    parts = [
        f"{limit} of {count} {name}"
        for count, limit, name in zip(
            shape[1:], (_MOST_CURVES, _MOST_PANELS), ("curves", "panels"), strict=True
        )
        if count > limit
    ]
    return f"{' and '.join(parts)} shown" if parts else ""


def _draw_curves(axes: Axes, table: Table, axes_order: list[int], values: Array) -> None:
    """Plot one panel of a grid."""
    name = table.cases.names[axes_order[0]]
    x = table.cases.axes[name]
    numeric = is_numeric(x)
    positions, text = np.arange(len(x)), name
    if numeric:
        positions, text = _scaled(table.quantities.get(name), name, x)
    order = np.argsort(positions, kind="stable")
    for place, k in enumerate(_evenly_spaced(values.shape[1], _MOST_CURVES)):
        label = _value_label(table, axes_order[1], k) if len(axes_order) > 1 else None
        mark = "." if positions.size <= 30 else None
        axes.plot(
            positions[order],
            values[order, k],
            _LINES[place % 4],
            color=COLOURS[place],
            marker=mark if numeric else "o",
            label=label,
        )
    if not numeric:
        axes.set_xticks(positions, [str(label) for label in as_labels(x)], rotation=20)
    elif _logarithmic(positions):
        _log_axis(axes.xaxis)
    axes.set_xlabel(text)


def _scatter(table: Table, output: str, registered: bool) -> Figure:
    """Return the figure of a design without a grid: the output over each input."""
    columns = {name: v for name, v in table.cases.columns.items() if is_numeric(v)}
    wide = min(len(columns), 3)
    rows = -(-len(columns) // max(wide, 1))
    figure = Picture.new((2.9 * wide + 0.6, 2.6 * rows + 0.4), registered)
    panels = figure.subplots(rows, wide, sharey=True, squeeze=False)
    for axes in panels.flat[len(columns) :]:
        axes.set_visible(False)
    values, text = _scaled(table.quantities.get(output), output, table.outputs[output])
    for axes, (name, inputs) in zip(panels.flat, columns.items(), strict=False):
        positions, x_label = _scaled(table.quantities.get(name), name, inputs, words=False)
        axes.plot(
            positions, values, ".", color=COLOURS[0], markersize=3, alpha=0.6, rasterized=True
        )
        if _logarithmic(positions):
            _log_axis(axes.xaxis)
        axes.set_xlabel(x_label)
    for axes in panels[:, 0]:
        axes.set_ylabel(text)
    return figure


def plot_fit(
    fit: FitResult,
    path: str | Path | None = None,
    ax: Axes | None = None,
    panels: str | Sequence[str] | None = None,
) -> Any:
    """Plot fitted against measured values ("agreement"), and the profile of each parameter.

    Parameters
    ----------
    fit : FitResult
    path, ax, panels
        As of :func:`~woundon.report.panels.draw_panels`; a profile has the name of its parameter.
    """
    known = {"agreement": Panel(_draw_agreement, "agreement", 3.3, 3.2)}
    for profile in fit.profiles:
        draw = partial(_draw_profile, profile)
        known[profile.name] = Panel(draw, profile.name, 3.1, 3.2)
    return draw_panels(known, [Case(fit)], path, ax, panels, lettered=False)


def _draw_profile(profile: ProfileLikelihood, axes: Axes, cases: Sequence[Case]) -> list[Any]:
    """Plot the profile likelihood of a parameter."""
    fit = cases[0].result
    label = "others refitted" if len(fit.names) > 1 else "profile"
    rms, text = _rms(fit)
    quantity = fit.quantities.get(profile.name)
    positions, x_label = _scaled(quantity, profile.name, profile.values, words=False)
    axes.plot(positions, rms * profile.rms, ".-", color=COLOURS[0], label=label)
    axes.axhline(rms * profile.rms_limit, color=COLOURS[1], linestyle="--", label="95 % limit")
    if _logarithmic(positions):
        _log_axis(axes.xaxis)
    axes.set_xlabel(x_label)
    axes.set_ylabel(text)
    axes.legend()
    return []


def _rms(fit: FitResult) -> tuple[float, str]:
    """Return the factor from SI to the displayed unit of an RMS, and the axis label."""
    quantity = fit.quantities.get(fit.row_outputs[0])
    if fit.weighted or quantity is None:
        return 1.0, "RMS of the fit [standard deviations]" if fit.weighted else "RMS of the fit"
    return float(quantity.shown(1.0)), axis_label("RMS of the fit", quantity)


def _draw_agreement(axes: Axes, cases: Sequence[Case]) -> list[Any]:
    """Plot fitted over measured values."""
    fit = cases[0].result
    outputs, ends = list(dict.fromkeys(fit.row_outputs)), []
    first = fit.quantities.get(outputs[0])  # all outputs of a fit have its SI unit
    for place, output in enumerate(outputs):
        rows = np.array([name == output for name in fit.row_outputs])
        measured, fitted = fit.measured[rows], fit.fitted[rows]
        if first is not None:
            measured, fitted = first.shown(measured), first.shown(fitted)
        ends += [measured.min(), measured.max(), fitted.min(), fitted.max()]
        axes.plot(
            measured,
            fitted,
            "os^dv"[place % 5],
            color=COLOURS[place % 7],
            markersize=4,
            label=_short_name(fit.quantities.get(output), output),
        )
    line = [min(ends), max(ends)]
    axes.plot(line, line, color="#888888", linewidth=0.8)
    for words, label in (("measured", axes.set_xlabel), ("fitted", axes.set_ylabel)):
        label(words if first is None else axis_label(words, first))
    axes.legend()
    return []


def _short_name(quantity: Quantity | None, name: str) -> str:
    """Return the name of a quantity for a legend: its meaning without the explanation, if short."""
    meaning = "" if quantity is None else quantity.meaning.partition(",")[0]
    return meaning if 0 < len(meaning) <= _LONG_NAME else name.replace("_", " ")


def plot_indices(
    indices: SobolIndices,
    path: str | Path | None = None,
    ax: Axes | None = None,
    panels: str | Sequence[str] | None = None,
) -> Any:
    """Plot first-order and total indices as bars with intervals, one panel per output.

    The input that explains most, with its interactions, stands on top.

    Parameters
    ----------
    indices : SobolIndices
    path, ax, panels
        As of :func:`~woundon.report.panels.draw_panels`; a panel has its output's name.
    """
    height = 0.42 * len(indices.inputs) + 1.0
    known = {
        output: Panel(partial(_draw_shares, k), "shares", height=height, legend="below")
        for k, output in enumerate(indices.outputs)
    }
    return draw_panels(known, [Case(indices)], path, ax, panels, lettered=False)


def _draw_shares(k: int, axes: Axes, cases: Sequence[Case]) -> list[Any]:
    """Plot the bars of an output."""
    indices = cases[0].result
    order = np.argsort(-indices.total_order[k], kind="stable")
    at, handles = np.arange(order.size), []
    for shift, label, values, ends in (
        (-0.2, "alone (first order)", indices.first_order, indices.first_interval),
        (0.2, "with interactions (total)", indices.total_order, indices.total_interval),
    ):
        value = values[k, order]
        bars = axes.barh(
            at + shift,
            value,
            height=0.38,
            xerr=np.abs(ends[:, k, order] - value),
            label=label,
            color=COLOURS[0 if shift < 0 else 4],
            error_kw={"linewidth": 0.9},
        )
        handles.append(bars)
    axes.set_yticks(at, [indices.inputs[j].replace("_", " ") for j in order])
    axes.invert_yaxis()
    axes.set_title(indices.outputs[k].replace("_", " "), fontsize=9, loc="left")
    axes.set_xlabel("share of the variance")
    return handles


def _evenly_spaced(count: int, limit: int) -> list[int]:
    """Return at most ``limit`` evenly spaced indices below ``count``, including both ends."""
    return sorted({round(k) for k in np.linspace(0, count - 1, min(count, limit))})


def _logarithmic(values: Array) -> bool:
    """Return True if values are spaced by factors rather than by steps."""
    if values.size < 3 or values.min() <= 0 or values.max() / values.min() < 10:
        return False
    return bool(np.median(values) < 0.5 * (values.min() + values.max()) * 0.7)


def _scaled(
    quantity: Quantity | None, name: str, values: Array, words: bool = True
) -> tuple[Array, str]:
    """Return values in the unit for display, and the axis label."""
    text = name.replace("_", " ")
    if quantity is None:
        return values, text
    text = wrapped_text(quantity.meaning.partition(",")[0], 36) if words else text
    return quantity.shown(values), axis_label(text, quantity)


def _log_axis(axis: Axis) -> None:
    """Label 1, 2 and 5 of every decade with plain numbers."""
    axis.axes.set(**{f"{axis.axis_name}scale": "log"})  # type: ignore[attr-defined]
    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_formatter(NullFormatter())


def _value_label(table: Table, axis: int, place: int) -> str:
    """Return a label such as "shear = 10 MPa" for an index on an axis."""
    field = table.cases.names[axis]
    values, quantity = table.cases.axes[field], table.quantities.get(field)
    value, name = as_labels(values)[place], field.rpartition(".")[2].replace("_", " ")
    if not is_numeric(values):
        return f"{name} = {value}"
    return f"{name} = {value:.4g}" if quantity is None else f"{name} = {text_of(quantity, value)}"
