"""The panels of a result for the page: the data of the figures as JSON, in SI units.

A panel is a dict of

- ``name``, ``title``, ``column`` (panels of one column share their x axis), ``x``, ``y``,
  ``right``: the axes, each ``{"label", "quantity", "log", "from_zero", "range"}``
- ``group``: column of the figure; "outputs" of arrays that no other panel shows
- ``curves``: ``{"name", "symbol", "label", "role", "dash", "marker", "side", "alone",
  "in_legend", "opacity", "x", "y"}``
- ``areas``: ``{"label", "shade", "symmetrical", "x", "low", "high"}``, shaded behind them
- ``marks``: ``{"along", "value", "label"}``, straight lines parallel to the axis ``along``, at
  ``value`` of the other axis
- ``strips``: ``{"label", "runs": [[zone, from, to], ...]}`` in place of curves, and ``words``
- ``map``: ``{"x", "y", "values", "contours"}``, and ``discs``: ``{"radius", "values", "left"}``,
  coloured by ``scale``

None stands for nan and infinity.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

import numpy as np

from ..report.panels import Axis, Curve, Panel
from ..report.result_panels import other_arrays, panels_of
from ..results import Result
from .input_forms import quantity_schema

__all__ = ["panel_data", "slow_panel_data"]

Array = np.ndarray
DIGITS = 8  # significant ones: a curve is drawn, the outputs are exact
PURE = {"symbol": "", "label": "", "unit": "1", "shown_unit": ""}  # without a quantity
AREA = ("label", "shade", "symmetrical", "x", "low", "high")
CURVE = ("name", "symbol", "label", "marker", "alone", "in_legend", "opacity", "x", "y")
FORMULA = re.compile(r"\s*\$[^$]*\$")


def panel_data(result: Result) -> list[dict[str, Any]]:
    """Return the panels of a result, except those that take longer than a warm solution."""
    return [_panel(maker.make(result)) for maker in panels_of(result).values() if not maker.slow]


def slow_panel_data(result: Result) -> list[dict[str, Any]]:
    """Return the slow panels of a result, and one for each array that no panel shows."""
    makers = panels_of(result).values()
    quick = [maker.make(result) for maker in makers if not maker.slow]
    slow = [maker.make(result) for maker in makers if maker.slow]
    others = other_arrays(result, [*quick, *slow]).values()
    return [_panel(panel) for panel in (*slow, *(maker.make(result) for maker in others))]


def _panel(panel: Panel) -> dict[str, Any]:
    """Return a panel for JSON."""
    # "group" is the column of the figure, and "column" names the panels that share an x axis: those
    # with the same label, except a panel alone in a column of the figure, which may show another
    # range of x.
    alone = panel.column == panel.name
    return {
        "name": panel.name,
        "title": panel.title,
        "column": panel.name if alone else _plain(panel.x.label),
        "group": panel.column,
        "x": _axis(panel.x),
        "y": _axis(panel.y),
        "right": _axis(panel.right) if panel.right else None,
        "curves": [_curve(curve) for curve in panel.curves],
        "areas": [_fields(area, AREA) for area in panel.areas],
        "marks": [_fields(mark, ("along", "value", "label")) for mark in panel.marks],
        **_coloured(panel),
        **_zones(panel),
        "note": panel.note,
    }


def _fields(part: Any, names: Sequence[str]) -> dict[str, Any]:
    """Return fields of a part of a panel by name, arrays as lists of numbers."""
    fields = {name: getattr(part, name) for name in names}
    return {
        name: _numbers(value) if isinstance(value, np.ndarray) else value
        for name, value in fields.items()
    }


def _axis(axis: Axis) -> dict[str, Any]:
    """Return an axis for JSON; its label without the symbols."""
    return {
        **_fields(axis, ("log", "from_zero")),
        "label": _plain(axis.label),
        "quantity": quantity_schema(axis.quantity) if axis.quantity else PURE,
        "range": list(axis.limits) if axis.limits else None,
    }


def _plain(label: str) -> str:
    return FORMULA.sub("", label)


def _curve(curve: Curve) -> dict[str, Any]:
    """Return a curve for JSON."""
    return {
        **_fields(curve, CURVE),
        "role": curve.colour,
        "dash": curve.line,
        "side": "right" if curve.right else "left",
    }


def _zones(panel: Panel) -> dict[str, Any]:
    """Return the strips of zones for JSON; nothing without strips."""
    if not panel.strips:
        return {}
    strips = [
        {
            "label": strip.face,
            "runs": [[zone, *_numbers(np.array(ends))] for zone, *ends in strip.runs],
        }
        for strip in panel.strips
    ]
    return {"strips": strips, "words": list(panel.words)}


def _coloured(panel: Panel) -> dict[str, Any]:
    """Return coloured values for JSON; nothing without a scale."""
    if panel.scale is None:
        return {}
    scale = {**_axis(panel.scale.axis), "palette": panel.scale.palette}
    if panel.map is None:
        discs = [_fields(disc, ("radius", "values", "left")) for disc in panel.discs]
        return {"scale": scale, "discs": discs}
    contours = [_fields(contour, ("level", "label")) for contour in panel.map.contours]
    plane = _fields(panel.map, ("x", "y", "values"))
    return {"scale": scale, "map": {**plane, "contours": contours}}


def _numbers(values: Array) -> list[Any]:
    """Return an array as rounded numbers, rows as lists; None where not finite."""
    finite = np.isfinite(values)
    size = np.where(finite & (np.abs(values) > 1e-290), np.abs(values), 1.0)
    scale = 10.0 ** (DIGITS - 1 - np.floor(np.log10(size)))
    rounded = (np.round(values * scale) / scale).astype(object)
    rounded[~finite] = None
    numbers: list[Any] = rounded.tolist()
    return numbers
