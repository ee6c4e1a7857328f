"""Style, texts of labels and saving of all figures.

A figure that is to be saved is made without pyplot, so that any number may be drawn in any thread,
and with fixed metadata: the same result gives the same bytes.  One that is to be seen is pyplot's
(:class:`Picture`).
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from io import BytesIO
from pathlib import Path
from textwrap import fill
from typing import Any, NoReturn, Self

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine

from ..io.files import check_ending, write_whole
from ..quantities import Quantity
from .panels import Axis
from .report_parts import GREEK, SYMBOL, printed_unit

__all__ = [
    "COLOURS",
    "Picture",
    "axis_label",
    "check_format",
    "figure_bytes",
    "formulas",
    "named_value",
    "save_figure",
    "style",
    "symbol_text",
    "text_of",
    "unit_of",
    "wrapped_text",
    "zone_look",
]

# Palette of Okabe and Ito, distinguishable with any colour vision; in grey by line style
COLOURS = {
    "roll": "#0072B2",
    "drum": "#D55E00",
    "green": "#009E73",
    "purple": "#CC79A7",
    "sky": "#56B4E9",
    "amber": "#E69F00",
    "ink": "#000000",
    "web": "#444444",
    "soft": "#888888",
    "alarm": "#B00020",
}
ZONE_COLOURS = {-1: COLOURS["amber"], 0: "#F0F0F0", 1: COLOURS["sky"]}
ZONE_HATCHES = {-1: "\\\\\\\\", 0: "", 1: "////"}
FORMULA = re.compile(r"\$([^$]*)\$")  # in a label
UNIT = re.compile(r"(?<=\d )[A-Za-z][A-Za-z0-9/*^.]*")  # after a number in a label, or a word
PLACE = "\ue000"  # a character of a formula while a label is wrapped
PLACES = re.compile(f"{PLACE}+")
WORD = re.compile(r"[A-Za-z]+\d*(?:_\w+)?[+-]?")  # a symbol in a formula

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
            if axes.get_in_layout():  # setting a position takes them out of it
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
        raise NotImplementedError  # IPython then shows it as it shows any figure


def zone_look(zone: int) -> dict[str, Any]:
    """Return fill, hatch and edge of a zone as Matplotlib's properties of a patch."""
    return {
        "facecolor": ZONE_COLOURS[zone],
        "hatch": ZONE_HATCHES[zone],
        "edgecolor": "#666666",
    }


# ---- saving -------------------------------------------------------------------------------------


def check_format(path: str | Path) -> str:
    """Return the suffix of a path; reject formats in which figures cannot be saved.

    Raises
    ------
    InvalidProblem
        For an ending other than .png, .svg, .pdf.
    """
    return check_ending(path, _METADATA)


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
        # the format is the ending without its dot
        figure.savefig(buffer, format=ending[1:], metadata=_METADATA[ending], dpi=dpi)
    return buffer.getvalue()


# ---- labels from quantities ---------------------------------------------------------------------


def unit_of(quantity: Quantity) -> str:
    """Return a quantity's unit for display as figures write it: µm, lb/ft³, Pa·s."""
    return printed_unit(quantity.display)


def text_of(quantity: Quantity, value: float, form: str = ".4g") -> str:
    """Return an SI value with its unit for display as figures write it."""
    return f"{quantity.shown(float(value)):{form}} {unit_of(quantity)}".rstrip()


def named_value(path: str, quantity: Quantity | None, value: object) -> str:
    """Return the value of a field with its name, such as "nip load = 2000 N/m", for a legend."""
    name = path.rpartition(".")[2].replace("_", " ")
    if isinstance(value, bool) or not isinstance(value, int | float | np.number):
        return f"{name} = {value}"
    text = f"{value:.5g}" if quantity is None else text_of(quantity, float(value), ".5g")
    return f"{name} = {text}"


def axis_label(axis: Axis, width: int = 60) -> str:
    """Return "label [unit]", wrapped to a number of characters per line, formulas as one word."""
    unit = unit_of(axis.quantity) if axis.quantity else ""
    label = f"{axis.label} [{unit}]".lstrip() if unit else axis.label
    known = iter(FORMULA.findall(label))
    # a symbol with its index, of any name, is about two characters wide
    lengths = FORMULA.sub(
        lambda formula: PLACE * len(WORD.sub(lambda word: word[0][:2], formula[1])), label
    )
    words = wrapped_text(lengths, width)
    return formulas(PLACES.sub(lambda _: f"${next(known)}$", words))


def formulas(label: str) -> str:
    r"""Return a label with its formulas and the units after numbers as figures write them.

    >>> formulas("Pressure $p$"), formulas("$|q+|/mu+$")
    ('Pressure $p$', '$|q^{+}|/\\mu^{+}$')
    >>> formulas("temperature change -36 degF"), formulas("scale: 5 um, 2 kg/m^3")
    ('temperature change -36 °F', 'scale: 5 µm, 2 kg/m³')
    """
    words = FORMULA.sub(lambda formula: f"${_in_tex(formula[1])}$", label)
    return UNIT.sub(lambda unit: printed_unit(unit[0]), words)


def _in_tex(formula: str) -> str:
    """Return a formula of symbols, operators and brackets in the notation of TeX."""
    return WORD.sub(lambda word: symbol_text(word[0]).strip("$"), formula)


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
