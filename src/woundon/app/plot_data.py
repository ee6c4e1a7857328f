"""The panels of a result for the page: the data of the figures as JSON, in SI units.

The fields of a panel are those of :class:`~woundon.report.panels.Panel` and its parts, with three
differences:

- labels of axes have no formulas, and a quantity is described as in the catalogue;
- ``column`` names the panels of the page that share their x axis, and ``group`` is the column of
  the figure: "outputs" of arrays that no other panel shows;
- arrays are rounded, None stands for nan and infinity.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import fields, is_dataclass, replace
from typing import Any

import numpy as np

from ..quantities import Quantity
from ..report.panels import Axis, Panel
from ..report.result_panels import other_arrays, panels_of
from ..results import Result
from .input_forms import quantity_schema

__all__ = ["panel_data", "slow_panel_data"]

Array = np.ndarray
DIGITS = 8  # significant ones: a curve is drawn, the outputs are exact
PURE = Quantity("", "1", "")  # of an axis without a quantity
FORMULA = re.compile(r"\s*\$[^$]*\$")


def panel_data(result: Result) -> list[dict[str, Any]]:
    """Return the panels of a result, except the slow ones: longer than a warm-started solution."""
    makers = panels_of(result).values()
    return _data_of([maker.make(result) for maker in makers if not maker.slow])


def slow_panel_data(result: Result) -> list[dict[str, Any]]:
    """Return the slow panels of a result, and one for each array that no panel shows."""
    makers = panels_of(result).values()
    quick = [maker.make(result) for maker in makers if not maker.slow]
    slow = [maker.make(result) for maker in makers if maker.slow]
    others = other_arrays(result, [*quick, *slow]).values()
    return _data_of([*slow, *(maker.make(result) for maker in others)])


def _data_of(panels: Sequence[Panel]) -> list[dict[str, Any]]:
    """Return panels for JSON.

    On the page panels share their x axis if it has the same label, except a panel that is alone in
    its column of the figure, which may show another range of x.
    """
    entries = []
    for panel in panels:
        entry = _plain(panel)
        is_alone = panel.column == panel.name
        column = panel.name if is_alone else entry["x"]["label"]
        entries.append({**entry, "group": panel.column, "column": column})
    return entries


def _plain(part: Any) -> Any:
    """Return a part of a panel for JSON: its fields by name, arrays as lists of numbers."""
    if isinstance(part, Axis):
        label, quantity = FORMULA.sub("", part.label), part.quantity or PURE
        part = replace(part, label=label, quantity=quantity)
    if isinstance(part, Quantity):
        return quantity_schema(part)
    if isinstance(part, np.ndarray):
        return _numbers(part)
    if isinstance(part, tuple):
        return [_plain(inner) for inner in part]
    if is_dataclass(part):
        return {field.name: _plain(getattr(part, field.name)) for field in fields(part)}
    return part


def _numbers(values: Array) -> list[Any]:
    """Return an array as rounded numbers, rows as lists; None where not finite."""
    finite = np.isfinite(values)
    # numbers below 1e-290 are rounded to 0: their scale would overflow
    size = np.where(finite & (np.abs(values) > 1e-290), np.abs(values), 1.0)
    scale = 10.0 ** (DIGITS - 1 - np.floor(np.log10(size)))
    rounded = (np.round(values * scale) / scale).astype(object)
    rounded[~finite] = None
    numbers: list[Any] = rounded.tolist()
    return numbers
