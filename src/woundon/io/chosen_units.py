"""Units that people choose for fields and outputs: ``wo.units(nip_load="kN/m")``, ``--unit``."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager
from typing import Any

from .. import kinds
from ..errors import InvalidProblem, did_you_mean
from ..quantities import outputs, pattern, shown_in, walk
from ..unit_parsing import factor

__all__ = ["units", "units_of"]


@contextmanager
def units(chosen: Mapping[str, str] | None = None, /, **more: str) -> Iterator[None]:
    """Show fields and outputs in units of choice: reports, figures, and tables that are written.

    >>> with wo.units(nip_load="kN/m", half_width="um"):  # doctest: +SKIP
    ...     print(result)

    Parameters
    ----------
    chosen, more : mapping of str to str
        Name of a field (dotted where it is nested) or output, of any kind -> unit.  What is not
        named is shown as ever; results themselves, netCDF and JSON files stay SI.

    Raises
    ------
    InvalidProblem
        For a name that no kind has, or a unit that is unknown or of another dimension.
    """
    asked = {**(chosen or {}), **more}
    known = _known() if asked else {}
    faults: list[tuple[str, str]] = []
    sizes: dict[tuple[str, str], tuple[str, float]] = {}
    for name, unit in asked.items():
        if pattern(name) not in known:
            faults.append((name, f"no field or output{did_you_mean(name, known)}"))
            continue
        told, last = len(sizes), InvalidProblem("")
        for of in known[pattern(name)]:
            try:
                sizes[name, of] = (unit, float(factor(unit, of, name)))
            except InvalidProblem as fault:
                last = fault
        if len(sizes) == told:
            faults += last.faults
    if faults:
        raise InvalidProblem(faults)
    with shown_in(sizes):
        yield


def units_of(told: Iterable[str]) -> AbstractContextManager[None]:
    """Return the context of :func:`units` for texts "NAME=UNIT", as the command line has them."""
    chosen: dict[str, str] = {}
    for text in told:
        name, _, unit = (part.strip() for part in text.partition("="))
        if not name or not unit:
            raise InvalidProblem.at(text, "must be written NAME=UNIT, e.g. nip_load='kN/m'")
        chosen[name] = unit
    return units(chosen)


def _known() -> dict[str, list[str]]:
    """Return the SI units of all fields and outputs; a name may be of two, in two kinds."""
    known: dict[str, list[str]] = {}
    for kind in kinds.every():
        places: list[Any] = [*walk(kind.problem), *outputs(kind.result)]
        for place in places:
            if place.quantity is not None and place.quantity.unit not in known.get(place.path, []):
                known.setdefault(place.path, []).append(place.quantity.unit)
    return known
