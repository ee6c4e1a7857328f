"""Panels as data: what figures and the page draw, in SI units, without a drawing library.

The panels of a result are functions (``nip_panels.py``, ``roll_panels.py``, ...) that return a
:class:`Panel`.  :mod:`.drawing` draws them with Matplotlib, the page draws the same data.

Labels contain symbols between dollars, in the notation of quantities: ``"Pressure $p$"``,
``"$|q+|/mu+$"``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from .. import quantities
from ..quantities import Quantity
from ..results import Result
from .report_parts import quantity_of

__all__ = [
    "LINES",
    "SERIES",
    "Area",
    "Axis",
    "Bars",
    "Contour",
    "Curve",
    "Disc",
    "Limits",
    "Map",
    "Mark",
    "Panel",
    "PanelMaker",
    "PanelMakers",
    "Regions",
    "Scale",
    "Strip",
    "axis_of_names",
    "round_at_most",
    "widest",
    "with_margin",
]

Array = np.ndarray
Limits = tuple[float, float]
Legend = Literal["above", "stacked", "inside", "right", "figure below", "figure right"]

# Names of the colours of several curves in one panel, in their order.
SERIES = ("roll", "drum", "green", "purple", "sky", "amber", "ink")
# their lines
LINES = ("solid", "dashed", "dashdot", "dotted")


@dataclass(frozen=True)
class Axis:
    """An axis of a panel.

    Attributes
    ----------
    label : str
    quantity : Quantity or None
        Of the numbers along the axis; None for plain numbers.
    log : bool
        True for a logarithmic axis.
    from_zero : bool
        True if the axis begins at zero, unless values are negative.
    limits : (first, last), optional
        Ends of the axis; descending if the axis points down.
    cut : (first, last), optional
        Ends of the axis in a figure, which omits values outside; the page shows all values.
    names : tuple of str
        Names of the positions 0, 1, 2, ... in place of numbers.
    """

    label: str
    quantity: Quantity | None = None
    log: bool = False
    from_zero: bool = False
    limits: Limits | None = None
    cut: Limits | None = None
    names: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class Curve:
    """A curve, or points.

    Attributes
    ----------
    name : str
        Output that it shows.
    x, y : (n,) arrays
    symbol, label : str
        Of its entry in the legend.
    colour : str
        "roll", "drum", "web", another name in :data:`SERIES`, "soft" or "alarm".
    line : {"solid", "dashed", "dashdot", "dotted", "none"}
    marker : {"", "point", "circle", "ring", "cross", "square", "diamond", "triangle"}
    right : bool
        True if its values are those of the right axis.
    alone : bool
        True if it is omitted where the panel compares several results.
    in_legend : bool
        Whether the legend has an entry for it.
    opacity, width : float
        Share of full colour; width of the line in points.
    steps : bool
        True for a piecewise constant curve.
    x_error, y_error : (n,) arrays, optional
        Half lengths of error bars.
    """

    name: str
    x: Array
    y: Array
    symbol: str = ""
    label: str = ""
    colour: str = "roll"
    line: str = "solid"
    marker: str = ""
    right: bool = False
    alone: bool = False
    in_legend: bool = True
    opacity: float = 1.0
    width: float = 1.6
    steps: bool = False
    x_error: Array | None = None
    y_error: Array | None = None

    @classmethod
    def of_output(
        cls,
        result: Result,
        name: str,
        x: Array,
        label: str = "",
        colour: str = "roll",
        line: str = "solid",
        *,
        nodes: slice = slice(None),
        **others: Any,
    ) -> Curve:
        """Return the curve of an output, which the legend names by its symbol and a label.

        Parameters
        ----------
        result : Result
        name : str
            Of an output that is an (n,) array.
        x : (n,) array
            Abscissa [SI].
        label, colour, line, others
            Fields of the curve.
        nodes : slice
            The part of the arrays that is drawn.
        """
        y, symbol = quantities.value_of(result, name), quantity_of(result, name).symbol
        return cls(name, x[nodes], y[nodes], symbol, label, colour, line, **others)


@dataclass(frozen=True, eq=False)
class Area:
    """A shaded area between two curves, behind all others; omitted for several results.

    ``shade`` is "shade0", "shade1" (friction bounds, the wider one first), "drum" or "alarm".
    The label of a symmetrical area, which reaches from -high to high, is the symbol of high.
    ``x``, ``low`` and ``high`` are (n,) arrays.
    """

    label: str
    x: Array
    low: Array
    high: Array
    shade: str
    symmetrical: bool = False


@dataclass(frozen=True)
class Mark:
    """A straight line parallel to the axis ``along``, at ``value`` of the other axis.

    The legend names it by its symbol and value, or else by its label; without both, the line is
    not named.  ``along`` is "x" or "y", ``written`` places the label next to the line, and
    ``alone`` omits the line where the panel compares several results.
    """

    along: str
    value: float
    label: str = ""
    symbol: str = ""
    colour: str = "soft"
    line: str = "solid"
    written: bool = False
    alone: bool = True


@dataclass(frozen=True)
class Strip:
    """The zones of one face along a contact: runs (zone, from, to), the ends in metres."""

    face: str
    runs: tuple[tuple[int, float, float], ...]


@dataclass(frozen=True)
class Scale:
    """The scale of coloured values: its axis with limits, and the palette.

    The palette is "sequential", "red above" or "red below" zero.  ``clipped`` is "lower", "upper"
    or "": the end beyond which values have the last colour.
    """

    axis: Axis
    palette: str = "sequential"
    clipped: str = ""


@dataclass(frozen=True)
class Contour:
    """The line on which a map has the value ``level``."""

    level: float
    label: str
    line: str = "solid"


@dataclass(frozen=True, eq=False)
class Map:
    """Values over a plane, with contours; coloured if the panel has a scale.

    ``x`` is (n,), ``y`` (m,), ``values`` (m, n).
    """

    x: Array
    y: Array
    values: Array
    contours: tuple[Contour, ...] = ()


@dataclass(frozen=True, eq=False)
class Regions:
    """Regions of a plane: the (m, n) indices of their names; -1 where there is none.

    ``x`` is (n,), ``y`` (m,); each region has a name and a colour.
    """

    x: Array
    y: Array
    index: Array
    names: tuple[str, ...]
    colours: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Disc:
    """The cross section of a roll, coloured by values over its radius, (k,) arrays.

    ``left`` is the position of its left edge.
    """

    radius: Array
    values: Array
    left: float = 0.0


@dataclass(frozen=True, eq=False)
class Bars:
    """Horizontal bars at the named positions 0, 1, ... of the y axis, moved down by ``shift``.

    ``values`` is (n,), a bar for each position.  ``interval`` is (2, n), the ends of the error
    bars.
    """

    label: str
    values: Array
    shift: float
    colour: str
    interval: Array | None = None


@dataclass(frozen=True, eq=False)
class Panel:
    """One panel.

    Attributes
    ----------
    name : str
    x, y, right : Axis
        ``right`` is a second vertical axis.
    title : str
        Heading on the page.
    curves, areas, marks, strips, map, regions, discs, scale, bars
        Contents.
    words : (str, str, str)
        Meaning of the zones -1, 0 and 1 of the strips.
    heading, note : str
        Text above the panel; text in place of missing contents.
    column : str
        Panels of one column are drawn below each other; those with the same x axis share it.  By
        default a panel has a column of its own, named after it.
    to_scale : bool
        True for a drawing: lengths along both axes have the same scale.
    width, height : float
        Inches; a column has the width of its widest panel.
    legend : {"above", "stacked", "inside", "right", "figure below", "figure right"}
        Position of the legend: above in one row or below each other, in the panel, or on its right;
        one legend of all panels of a figure below or right of them.
    """

    name: str
    x: Axis
    y: Axis
    title: str = ""
    right: Axis | None = None
    curves: tuple[Curve, ...] = ()
    areas: tuple[Area, ...] = ()
    marks: tuple[Mark, ...] = ()
    strips: tuple[Strip, ...] = ()
    words: tuple[str, str, str] = ("", "stick", "")
    map: Map | None = None
    regions: Regions | None = None
    discs: tuple[Disc, ...] = ()
    scale: Scale | None = None
    bars: tuple[Bars, ...] = ()
    heading: str = ""
    note: str = ""
    column: str = ""
    to_scale: bool = False
    width: float = 6.3
    height: float = 3.2
    legend: Legend = "above"

    def __post_init__(self) -> None:
        """Name a column of its own after the panel."""
        object.__setattr__(self, "column", self.column or self.name)


@dataclass(frozen=True)
class PanelMaker:
    """The function that makes a panel from a result.

    Attributes
    ----------
    make : callable
        (result) -> Panel.
    by_default : bool
        Whether a figure without a choice of panels contains it.
    slow : bool
        True if it takes longer than a warm solution; the page then asks for it at rest.
    """

    make: Callable[[Any], Panel]
    by_default: bool = True
    slow: bool = False


PanelMakers = Mapping[str, PanelMaker]


def axis_of_names(names: Sequence[str], room: float = 0.6) -> Axis:
    """Return a vertical axis of names, the first on top, with some room above it and below."""
    return Axis("", limits=(len(names) - 1 + room, -room), names=tuple(names))


def round_at_most(limit: float) -> float:
    """Return the largest 1, 2 or 5 times a power of ten that is not above a limit > 0.

    >>> round_at_most(4.9), round_at_most(0.05)
    (2.0, 0.05)
    """
    power = float(10.0 ** np.floor(np.log10(limit)))
    return max(n * power for n in (1, 2, 5) if n * power <= limit)


def with_margin(values: Array, margin: float) -> Limits:
    """Return the ends of an axis that contains all values, with a margin relative to their range.

    Around a single value it is relative to this value, or 1 in SI units around zero.
    """
    low, high = float(np.min(values)), float(np.max(values))
    width = margin * (high - low or abs(high) or 1.0)
    return low - width, high + width


def widest(limits: list[Limits]) -> Limits:
    """Return the limits that contain all of some limits, which all ascend or all descend."""
    first, last = zip(*limits, strict=True)
    if limits[0][0] > limits[0][1]:
        return max(first), min(last)
    return min(first), max(last)
