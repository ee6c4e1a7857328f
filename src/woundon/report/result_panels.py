"""The panels of a result of any kind: those of its kind, and one for every array."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from .. import kinds, quantities
from ..arguments import check_arguments
from ..errors import InvalidProblem, nearest, one_of
from ..problems.messages import quote
from ..quantities import Quantity
from ..results import Result
from .nip_panels import nip_panels
from .panels import LINES, SERIES, Axis, Curve, Panel, PanelMaker, PanelMakers
from .report_parts import quantity_of
from .roll_panels import roll_panels
from .roller_panels import roller_panels
from .winding_panels import winding_panels

__all__ = ["array_panels", "chosen", "named_panels", "other_arrays", "panels_of"]

PANELS: Mapping[str, Callable[[Any], PanelMakers]] = {
    "nip": nip_panels,
    "rollers": roller_panels,
    "roll": roll_panels,
    "winding": winding_panels,
}
ZONES = ("zone", "roll_zone", "drum_zone")  # arrays that the strips of a panel show


def panels_of(result: Result) -> dict[str, PanelMaker]:
    """Return the makers of the panels of the kind of a result, by name of the panel.

    Raises
    ------
    InvalidProblem
        For a result of a kind without panels that has no arrays.
    """
    kind = kinds.of(result)
    return dict((kind.plot or PANELS.get(kind.name, array_panels))(result))


def named_panels(result: Result) -> dict[str, PanelMaker]:
    """Return the makers of the panels of the kind, then of a panel for every array, by name.

    Those of the arrays are drawn only if asked for.
    """
    panels = panels_of(result)
    for name, along in _arrays(result).items():
        panels.setdefault(name, PanelMaker(Arrays(along, (name,)), by_default=False))
    return panels


def other_arrays(result: Result, panels: Sequence[Panel]) -> dict[str, PanelMaker]:
    """Return makers of a panel for each array of a result that none of its panels shows.

    Parameters
    ----------
    result : Result
    panels : sequence of Panel
        Panels of the result that are drawn already.
    """
    drawn = {curve.name for panel in panels for curve in panel.curves}
    # strips draw the zones as bars and do not name the arrays
    drawn |= {name for panel in panels if panel.strips for name in ZONES}
    return {
        name: PanelMaker(Arrays(along, (name,)))
        for name, along in _arrays(result).items()
        if name not in drawn
    }


def chosen(names: str | Sequence[str], known: Sequence[str]) -> list[str]:
    """Return the names of panels that the user has chosen, as a list.

    Parameters
    ----------
    names : str or sequence of str
        The choice.
    known : sequence of str
        Names of all panels.

    Raises
    ------
    InvalidProblem
        For an unknown panel, or none.
    """
    check_arguments(panels=names)
    names = [names] if isinstance(names, str) else list(names)
    if not names:
        raise InvalidProblem.at("panels", f"none is chosen; must be {one_of(known)}")
    for name in names:
        if name not in known:
            suggestion = nearest(name, known)
            hint = f"; did you mean {suggestion!r}?" if suggestion else ""
            text = f"{quote(name)} is unknown; must be {one_of(known)}{hint}"
            raise InvalidProblem.at("panels", text)
    return names


# ---- arrays of any kind -------------------------------------------------------------------------


@dataclass(frozen=True)
class Arrays:
    """Makes the panel of the named arrays, which have one unit, over the array ``along``.

    Equal instances make the same panel, so that those of several results can be compared.
    """

    along: str
    names: tuple[str, ...]

    def __call__(self, result: Result) -> Panel:
        """Return the panel of a result."""
        x, first = quantity_of(result, self.along), quantity_of(result, self.names[0])
        alone = len(self.names) == 1
        return Panel(
            ", ".join(self.names),
            Axis(_capitalised(x.meaning), x),
            Axis(first.meaning if alone else "", first),
            title=_capitalised(first.meaning) if alone else ", ".join(self.names),
            curves=tuple(self._curve(result, k, name) for k, name in enumerate(self.names)),
            column="outputs",
            width=6.3 if alone else 9.0,
            height=2.8 if alone else 2.1,
            legend="right",
        )

    def _curve(self, result: Result, k: int, name: str) -> Curve:
        """Return the curve of the ``k``-th array; of several, the legend shows the meanings."""
        return Curve.of_output(
            result,
            name,
            quantities.value_of(result, self.along),
            label=quantity_of(result, name).meaning,
            colour=SERIES[k % len(SERIES)],
            line=LINES[k % len(LINES)],
            steps=_is_whole(result, name),
            in_legend=len(self.names) > 1,
        )


def array_panels(result: Result) -> dict[str, PanelMaker]:
    """Return makers of panels with every array of a result, for kinds without panels of their own.

    One for each unit, named after its arrays; whole numbers, such as zones, have one of their own.

    Raises
    ------
    InvalidProblem
        For a result without arrays.
    """
    groups: dict[tuple[str, str, str, bool], list[str]] = {}
    for name, along in _arrays(result).items():
        quantity: Quantity = quantity_of(result, name)
        group = along, quantity.unit, quantity.shown_unit, _is_whole(result, name)
        groups.setdefault(group, []).append(name)
    if not groups:
        raise InvalidProblem.at("plot", f"a {type(result).__name__} has no arrays to draw")
    return {
        ", ".join(names): PanelMaker(Arrays(along, tuple(names)))
        for (along, *_), names in groups.items()
    }


def _is_whole(result: Result, name: str) -> bool:
    """Return True for an array of whole numbers, such as zones."""
    return quantities.value_of(result, name).dtype.kind in "iub"


def _arrays(result: Result) -> dict[str, str]:
    """Return the names of arrays, and for each the array of the same length that it runs along.

    That is the first array, unless the result states another one.  Arrays along which others run,
    and those of another length, are left out.
    """
    arrays = {
        place.path: place.value
        for place in quantities.walk(result)
        if isinstance(place.value, np.ndarray) and place.value.ndim == 1 and place.value.size > 1
    }
    first = next(iter(arrays), "")
    along = {name: result.ALONG.get(name, first) for name in arrays}
    return {
        name: over
        for name, over in along.items()
        if name not in along.values() and arrays[over].shape == arrays[name].shape
    }


def _capitalised(text: str) -> str:
    return text[:1].upper() + text[1:]
