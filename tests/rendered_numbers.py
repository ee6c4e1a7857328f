"""Numbers with their units, read from what users see: texts, pages, figures.

Texts and figures of the same object in two systems of units are compared after conversion to SI.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from html import unescape
from math import floor, log10
from typing import Any, NamedTuple

import numpy as np
from matplotlib.collections import QuadMesh
from matplotlib.contour import ContourSet
from matplotlib.figure import Figure

from woundon.problems.units import definitions, is_unit

__all__ = [
    "differing_artists",
    "differing_numbers",
    "numbers",
    "text_of_page",
    "units_in",
    "units_of_figure",
]

NUMBER = r"(?<![\w.^])[+-]?\d+(?:\.\d+)?(?:e[+-]?\d+)?(?![\w.])"
# numbers that share the unit behind the last one: of a value and its limit, of a range
UNIT = r"(?:1/)?[A-Za-z%][\w/*^%]*"
SHARED = rf"({NUMBER}(?:(?:\s|,|<=|>=|->|± ?<?|to|and)*{NUMBER})*)\s+({UNIT})(?![\w])"
# the error of a value, in its unit; an error below the last digit begins with "<"
ERROR = rf"[ \t]*(?:±|\+-)[ \t]*(<?)({NUMBER})"
BRACKET = re.compile(r"\[([^\[\]]+)\]")


class Shown(NamedTuple):
    """A number in SI, and the size of its last printed digit."""

    value: float
    digit: float


def size(unit: str) -> float:
    """Return the size of a unit in SI; 1 of none."""
    if not unit or not is_unit(unit):
        return 1.0
    product = 1.0
    # pounds per length are forces in a table of tensions; here they occur as a mass alone
    for sign, name, power in re.findall(r"([*/]?)([A-Za-z%]+)\^?(\d?)", unit):
        product *= definitions()[name]["factor"] ** (int(power or 1) * (-1 if sign == "/" else 1))
    return product


def numbers(text: str) -> list[Shown]:
    """Return the numbers of a text in SI; a unit in brackets is that of the numbers in its line."""
    shown: list[Shown] = []
    for line in _as_written(text).replace("m/s^2", "").splitlines():
        bracket = BRACKET.search(line)
        default = bracket[1] if bracket and is_unit(bracket[1]) else ""
        units: dict[int, str] = {}
        for match in re.finditer(SHARED, line):
            if is_unit(match[2]):
                units |= {
                    match.start(1) + number.start(): match[2]
                    for number in re.finditer(NUMBER, match[1])
                }
                error = re.match(ERROR, line[match.end() :])
                if error:
                    units[match.end() + error.start(2)] = match[2]
        for number in re.finditer(NUMBER, line):
            if line[: number.start()].rstrip().endswith("<"):
                continue
            unit = size(units.get(number.start(), default))
            mantissa, _, power = number[0].partition("e")
            last = int(power or 0) - len(mantissa.partition(".")[2])  # power of ten of this digit
            if line[: number.start()].rstrip().endswith(("±", "+-")) and float(number[0]) > 0:
                # errors have two digits, also those without decimals: 758 is printed as 760
                last = max(last, floor(log10(float(number[0]))) - 1)
            shown.append(Shown(float(number[0]) * unit, 10.0**last * unit))
    return shown


def _as_written(text: str) -> str:
    """Return a text with printed units as the program reads them."""
    for printed, unit in {"µm": "um", "°F": "degF", "·": "*", "²": "^2", "³": "^3"}.items():
        text = text.replace(printed, unit)
    return text


def units_in(text: str) -> set[str]:
    """Return the units of the numbers of a text, and those in brackets."""
    text = _as_written(text)
    names = {match[2] for match in re.finditer(SHARED, text)} | set(BRACKET.findall(text))
    return {name for name in names if is_unit(name)}


def words(text: str) -> str:
    """Return a text without numbers and units."""
    plain = re.sub(rf"<?{NUMBER}(?![/\d])|±|\+-", " ", _as_written(text))
    return " ".join(word for word in plain.split() if not is_unit(word.strip("[],;.():")))


def differing_numbers(one: str, other: str) -> list[tuple[Any, ...]]:
    """Return what differs between two texts by more than the last digits that are printed."""
    differing: list[tuple[Any, ...]] = []
    for a, b in zip(one.splitlines(), other.splitlines(), strict=True):
        if words(a) != words(b):
            differing.append((words(a), words(b)))
            continue
        first, second = numbers(a), numbers(b)
        if "<" in a + b:  # an error below the last digit of one text may be printed in the other
            first, second = first[: min(len(first), len(second))], second[: len(first)]
        if len(first) != len(second):
            differing.append((a, b))
        for x, y in zip(first, second, strict=False):
            # twice: the last of a sum is the difference of rounded values
            if abs(x.value - y.value) > x.digit + y.digit + 1e-9 * abs(x.value):
                differing.append((a, b, x.value, y.value))
    return differing


def text_of_page(page: str) -> str:
    """Return the text of an HTML page, a line for each row or paragraph, without drawings."""
    text = re.sub(r"<svg.*?</svg>|<style.*?</style>", "", page, flags=re.DOTALL)
    text = re.sub(r"\s*\n\s*", " ", text)
    text = re.sub(r"<sup>(\d)</sup>", r"^\1", text)
    text = re.sub(r"</(tr|p|h\d|caption|footer)>", "\n", text)
    text = re.sub(r"<t[dh][^>]*>", " ", text)
    return unescape(re.sub(r"<[^>]+>", "", text)).replace("·", "*")


# ---- figures ------------------------------------------------------------------------------------


def unit_in(label: str) -> str:
    """Return the unit of the label of an axis."""
    typed = label.replace("µm", "um").replace("²", "^2").replace("³", "^3").replace("·", "*")
    found = BRACKET.findall(typed)
    return found[-1] if found and is_unit(found[-1]) else ""


def coordinates(artist: Any, axes: Any) -> Iterator[tuple[str, np.ndarray]]:
    """Yield the coordinates of an artist along the axes that are data: ("x", values)."""
    transform = artist.get_transform()
    vertices: Any = None
    if hasattr(artist, "get_xydata"):
        vertices = artist.get_xydata()
    elif isinstance(artist, QuadMesh):
        vertices = artist.get_coordinates().reshape(-1, 2)
    elif isinstance(artist, ContourSet) and artist.filled:
        paths = [path.vertices for path in artist.get_paths() if len(path.vertices)]
        ends = np.concatenate(paths)  # the levels are round numbers in the unit of display
        vertices = np.array([ends.min(axis=0), ends.max(axis=0)])
    elif hasattr(artist, "get_paths"):
        paths = [path.vertices for path in artist.get_paths() if len(path.vertices)]
        vertices = np.concatenate(paths) if paths else np.zeros((0, 2))
    elif hasattr(artist, "get_bbox"):
        vertices = artist.get_bbox().get_points()
    elif hasattr(artist, "get_xy"):
        vertices = np.atleast_2d(artist.get_xy())
    if vertices is None or not hasattr(transform, "contains_branch_seperately"):
        return
    for name, along, values in zip(
        "xy",
        transform.contains_branch_seperately(axes.transData),
        np.asarray(vertices, dtype=float).T,
        strict=True,
    ):
        if along and values.size:
            yield name, values


def artists(figure: Figure) -> list[tuple[str, Any]]:
    """Return what a figure shows: coordinates in SI by axis, coloured values in SI, texts."""
    shown: list[tuple[str, Any]] = []
    for k, axes in enumerate(figure.axes):
        if hasattr(axes, "_colorbar"):  # of values that are read from what they colour
            continue
        texts = [text.get_text() for text in axes.texts if text.get_text()]
        written = " ".join(sorted(texts, key=lambda text: "[" not in text))
        # the label may be that of a twin, or a text in axes without labels
        along = [twin.get_xlabel() for twin in axes.get_shared_x_axes().get_siblings(axes)]
        labels = {"x": max(along, key=len), "y": axes.get_ylabel()}
        units = {name: unit_in(label or written) for name, label in labels.items()}
        for artist in (*axes.lines, *axes.collections, *axes.patches):
            for name, values in coordinates(artist, axes):
                kind = f"{k} {type(artist).__name__} {name}"
                shown.append((kind, values * size(units[name])))
            colours = getattr(artist, "get_array", lambda: None)()
            bar = getattr(artist, "colorbar", None)
            if bar is not None and colours is not None:
                unit = size(unit_in(bar.ax.get_ylabel()))
                ends = (artist.zmin, artist.zmax) if isinstance(artist, ContourSet) else colours
                shown.append((f"{k} colour", np.ravel(ends) * unit))
        for name in "xy":
            ends = np.array(getattr(axes, f"get_{name}lim")())
            shown.append((f"{k} limits {name}", ends * size(units[name])))
        legend = axes.get_legend()
        entries = [entry.get_text() for entry in legend.get_texts()] if legend else []
        shown += [(f"{k} text", text) for text in (written, axes.get_title(), *entries) if text]
    for legend in figure.legends:
        shown += [("legend", entry.get_text()) for entry in legend.get_texts()]
    return shown


def units_of_figure(figure: Figure) -> set[str]:
    """Return the units of the axes, texts and legends of a figure."""
    texts = [text for _, text in artists(figure) if isinstance(text, str)]
    drawn = [part for axes in figure.axes for part in (axes, *axes.child_axes)]  # colour bars
    labels = [label for axes in drawn for label in (axes.get_xlabel(), axes.get_ylabel())]
    return units_in("\n".join([*texts, *labels]))


def differing_artists(one: Figure, other: Figure) -> list[Any]:
    """Return what differs between the figures of an object in two systems of units."""
    first, second = artists(one), artists(other)
    if [name for name, _ in first] != [name for name, _ in second]:
        return [([name for name, _ in first], [name for name, _ in second])]
    differing: list[Any] = []
    for (name, a), (_, b) in zip(first, second, strict=True):
        if isinstance(a, str):
            differing += [(name, *pair) for pair in differing_numbers(a, b)]
            continue
        a, b = (np.ma.filled(values, np.nan) for values in (a, b))
        # 1e-9: rounding of the conversion, relative to the largest value
        largest = np.nanmax(np.abs(a), initial=0.0)
        if a.shape != b.shape or not np.allclose(a, b, rtol=0, atol=1e-9 * largest, equal_nan=True):
            differing.append((name, a, b))
    return differing
