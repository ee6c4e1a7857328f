"""Style, axis labels from quantities, legends, zone strips and saving of all figures.

A figure that is to be saved is made without pyplot, so that any number may be drawn in any thread,
and with fixed metadata: the same result gives the same bytes.  One that is to be seen is pyplot's
(:class:`Picture`).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from importlib import import_module
from io import BytesIO
from pathlib import Path
from textwrap import fill
from typing import Any, NoReturn, Self

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.patches import Patch

from ..errors import InvalidProblem
from ..io.files import write_whole
from ..quantities import Quantity
from ..results import zone_runs
from .report_parts import GREEK, SYMBOL, ZoneStrips, quantity_of

__all__ = [
    "COLOURS",
    "ZONE_COLOURS",
    "ZONE_HATCHES",
    "Picture",
    "along_contact",
    "axis_label",
    "check_format",
    "draw_zones",
    "figure_bytes",
    "legend_above",
    "letter",
    "quantity_of",
    "save_figure",
    "style",
    "symbol_text",
    "text_of",
    "unit_of",
    "wrapped_text",
]

Array = np.ndarray

# Palette of Okabe and Ito, distinguishable with any colour vision; in grey by line style
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#000000")
ZONE_COLOURS = {-1: "#E69F00", 0: "#F0F0F0", 1: "#56B4E9"}
ZONE_HATCHES = {-1: "\\\\\\\\", 0: "", 1: "////"}

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
_METADATA: dict[str, dict[str, Any]] = {
    ".png": {"Software": "woundon"},
    ".svg": {"Date": None, "Creator": "woundon"},
    ".pdf": {"CreationDate": None, "Creator": "woundon", "Producer": "woundon"},
}


@contextmanager
def style() -> Iterator[None]:
    """Use woundon's figure style within a context; the global style does not change."""
    # not rc_context: it would take back what pyplot sets when a notebook first loads it
    previous = {name: mpl.rcParams[name] for name in _STYLE}
    mpl.rcParams.update(_STYLE)
    try:
        yield
    finally:
        mpl.rcParams.update(previous)


class _Settled(ConstrainedLayoutEngine):
    """Layout engine that rounds the panel positions, so that figures are reproducible."""

    def execute(self, fig: Figure) -> None:
        """Lay out the panels."""
        super().execute(fig)
        for axes in fig.axes:
            if axes.get_in_layout():
                axes.set_position(np.round(axes.get_position(original=True).bounds, 6))
                axes.set_in_layout(True)


class Picture(Figure):
    """A figure that a notebook displays exactly once."""

    @classmethod
    def new(cls, size: tuple[float, float], registered: bool) -> Self:
        """Return an empty figure of a size [inches].

        A registered one is pyplot's: a notebook shows it when the cell ends, in a script
        ``plt.show()`` does.
        """
        if not registered:
            return cls(figsize=size, layout=_Settled())
        from matplotlib import pyplot as plt

        return plt.figure(figsize=size, layout=_Settled(), FigureClass=cls)  # type: ignore[return-value]

    def _ipython_display_(self) -> NoReturn:
        """Display the figure in a notebook once, not again at the end of the cell."""
        if "inline" in mpl.get_backend():
            import_module("matplotlib_inline.backend_inline")  # now IPython knows figures
            import_module("matplotlib.pyplot").close(self)
        raise NotImplementedError  # so IPython shows it as it shows any figure


# ---- saving -------------------------------------------------------------------------------------


def check_format(path: str | Path) -> str:
    """Return the suffix of a path; reject formats in which figures cannot be saved.

    Raises
    ------
    InvalidProblem
        For an ending other than .png, .svg, .pdf.
    """
    ending = Path(path).suffix
    if ending not in _METADATA:
        raise InvalidProblem(
            [
                (
                    str(path),
                    f"the ending {ending!r} is not a known format; must be {', '.join(_METADATA)}",
                )
            ]
        )
    return ending


def save_figure(figure: Figure, path: str | Path, *, dpi: int | None = None) -> None:
    """Save a figure with fixed metadata: the same figure gives the same bytes.

    ``dpi`` is the resolution of a PNG file, 200 by default.

    Raises
    ------
    InvalidProblem
        For an ending other than .png, .svg, .pdf.
    OSError
        If the file cannot be written; the one that was there stays as it was.
    """
    write_whole(path, figure_bytes(figure, check_format(path), dpi=dpi))


def figure_bytes(figure: Figure, ending: str, *, dpi: int | None = None) -> bytes:
    """Return a figure in the format of an ending that :func:`check_format` admits."""
    buffer = BytesIO()
    with style():
        figure.savefig(buffer, format=ending[1:], metadata=_METADATA[ending], dpi=dpi)
    return buffer.getvalue()


# ---- labels from quantities ---------------------------------------------------------------------


def unit_of(quantity: Quantity) -> str:
    """Return a quantity's unit for display as figures write it."""
    return quantity.display.replace("um", "µm")


def text_of(quantity: Quantity, value: float, form: str = ".4g") -> str:
    """Return an SI value with its unit for display as figures write it."""
    return f"{quantity.shown(float(value)):{form}} {unit_of(quantity)}".rstrip()


def axis_label(words: str, quantity: Quantity) -> str:
    """Return "words [unit]"."""
    unit = unit_of(quantity)
    return f"{words} [{unit}]" if unit else words


def symbol_text(symbol: str) -> str:
    """Return a symbol as figures write it: "s_l+" as s with index l and superscript +."""
    match = SYMBOL.fullmatch(symbol)
    if match is None:
        return symbol
    factor, base, number, index, sign = match.groups()
    if base in GREEK:
        base = rf"\{'varepsilon' if base == 'eps' else base}"
    elif len(base) > 1:
        base = rf"\mathrm{{{base}}}"
    subscript = "".join(filter(None, (number, rf"\mathrm{{{index}}}" if index else "")))
    lower = f"_{{{subscript}}}" if subscript else ""
    upper = f"^{{{sign}}}" if sign else ""
    return f"${factor}{base}{lower}{upper}$"


def wrapped_text(text: str, width: int = 44) -> str:
    """Wrap a text to a number of characters per line, without a break in "> 0"."""
    return fill(text.replace("> 0", ">\N{NO-BREAK SPACE}0"), width)


# ---- panels -------------------------------------------------------------------------------------


def along_contact(axes: Axes, results: Sequence[Any], contact: str) -> None:
    """Label the x axis, with limits at the edges of the widest contact."""
    x = quantity_of(results[0], "x")
    axes.set_xlabel(axis_label(f"Position along the {contact} $x$", x))
    edge = 1.03 * x.shown(max(result.half_width for result in results))
    axes.set_xlim(-edge, edge)


def letter(axes: Axes, text: str) -> None:
    """Write the letter of a panel above its right end."""
    axes.set_title(f"({text})", loc="right", fontsize=9)


def legend_above(axes: Axes, handles: list[Any]) -> None:
    """Put the legend above the panel, where it covers no data."""
    many = {"columnspacing": 0.8, "handlelength": 1.1, "handletextpad": 0.4}
    few = {"columnspacing": 1.4, "handlelength": 2.2}
    axes.legend(
        handles=handles,
        loc="lower left",
        bbox_to_anchor=(0.0, 1.0),
        ncols=len(handles),
        borderaxespad=0.2,
        **(many if len(handles) > 4 else few),
    )


def draw_zones(
    axes: Axes, strips: Sequence[ZoneStrips], x: Quantity, colours: Sequence[str | None] = (None,)
) -> list[Patch]:
    """Plot zones as bars along x, the first face on top; return the handles of the legend.

    Parameters
    ----------
    axes : Axes
    strips : sequence of ZoneStrips
        Of each case, below each other.
    x : Quantity
        Quantity along x.
    colours : sequence of str or None
        Of the names of each case's faces.
    """
    bars = [
        (face, zones, strip, colour)
        for strip, colour in zip(strips, colours, strict=True)
        for face, zones in strip.faces.items()
    ]
    rows = range(len(bars))[::-1]
    for row, (_, zones, strip, _) in zip(rows, bars, strict=True):
        for zone, left, right in zone_runs(x.shown(strip.x), zones):
            axes.barh(
                row,
                right - left,
                left=left,
                height=0.7,
                color=ZONE_COLOURS[zone],
                hatch=ZONE_HATCHES[zone],
                edgecolor="#666666",
                linewidth=0.6,
            )
    axes.set_yticks(list(rows), [face for face, *_ in bars])
    for text, (*_, colour) in zip(axes.get_yticklabels(), bars, strict=True):
        if colour is not None:
            text.set_color(colour)
    axes.set_ylim(-0.55, len(rows) - 0.45)
    axes.grid(visible=False)
    axes.tick_params(axis="y", length=0)
    words = {0: "stick", 1: f"slip, {strips[0].faster}", -1: f"slip, {strips[0].slower}"}
    return [
        Patch(
            facecolor=ZONE_COLOURS[zone], hatch=ZONE_HATCHES[zone], edgecolor="#666666", label=word
        )
        for zone, word in words.items()
    ]
