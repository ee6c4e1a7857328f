"""Display units of fields and outputs: ``wo.units(nip_load="kN/m")``, ``--unit``."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from .. import kinds
from ..errors import InvalidProblem, did_you_mean
from ..problems.units import MILL, factor
from ..quantities import Place, outputs, pattern, shown_in, value_of, walk
from ..results import Result
from .frames import to_frame

__all__ = ["ResultInUnits", "in_units", "units", "units_of"]

Sizes = dict[tuple[str, str], tuple[str, float]]  # as of woundon.quantities.shown_in
SYSTEMS = ("SI", "mill")
# Quantities per width, and the unit of their totals.
_TOTALS = {"N/m": "N", "kg/m": "kg", "W/m": "W"}


@contextmanager
def units(chosen: Mapping[str, str] | None = None, /, **more: str) -> Iterator[None]:
    """Use chosen units in reports, figures and exported tables.

    Parameters
    ----------
    chosen, more : mapping of str to str
        Name of a field (dotted if nested) or output of any kind of problem -> unit.  Other
        quantities keep their default units; results, netCDF and JSON files are in SI.

    Raises
    ------
    InvalidProblem
        For an unknown name, or a unit that is unknown or of another dimension.

    Examples
    --------
    >>> import woundon as wo
    >>> result = wo.solve(wo.RollerProblem.example(), nodes=33)
    >>> with wo.units(half_width="um"):
    ...     "um" in str(result)
    True
    """
    requested = {**(chosen or {}), **more}
    known = _known() if requested else {}
    faults: list[tuple[str, str]] = []
    sizes: dict[tuple[str, str], tuple[str, float]] = {}
    for name, unit in requested.items():
        if pattern(name) not in known:
            faults.append((name, f"no field or output{did_you_mean(name, known)}"))
            continue
        count, last = len(sizes), InvalidProblem("")
        for si_unit in known[pattern(name)]:
            try:
                sizes[name, si_unit] = (unit, float(factor(unit, si_unit, name)))
            except InvalidProblem as fault:
                last = fault
        if len(sizes) == count:
            faults += last.faults
    if faults:
        raise InvalidProblem(faults)
    with shown_in(sizes):
        yield


@contextmanager
def units_of(settings: Iterable[str]) -> Iterator[None]:
    """Use the units of texts "NAME=UNIT" of the command line, and those of the system "mill"."""
    explicit: dict[str, str] = {}
    system: Sizes = {}
    for text in settings:
        if text in SYSTEMS:
            for kind in kinds.every():
                places = (*walk(kind.problem), *outputs(kind.result))
                system |= _system([p for p in places if p.quantity is not None], text)
            continue
        name, _, unit = (part.strip() for part in text.partition("="))
        if not name or not unit:
            raise InvalidProblem.at(
                text, "must be written NAME=UNIT, e.g. nip_load='kN/m', or mill"
            )
        explicit[name] = unit
    with shown_in(system), units(explicit):
        yield


def _known() -> dict[str, list[str]]:
    """Return the SI units of all fields and outputs; a name may have several, by kind."""
    known: dict[str, list[str]] = {}
    for kind in kinds.every():
        places: list[Any] = [*walk(kind.problem), *outputs(kind.result)]
        for place in places:
            if place.quantity is not None and place.quantity.unit not in known.get(place.path, []):
                known.setdefault(place.path, []).append(place.quantity.unit)
    return known


# ---- a result in units --------------------------------------------------------------------------


class ResultInUnits:
    """A result whose outputs are numbers in chosen units; see :meth:`woundon.Result.in_units`.

    An output is an attribute or an item: ``view.wound_on_tension``, ``view["wound_on_tension"]``.
    Printing, figures and tables use the same units.

    Attributes
    ----------
    result : Result
        In SI.
    units : dict of str to str
        Unit of every output; "" of a pure number.
    """

    def __init__(self, result: Result, sizes: Sizes) -> None:
        self.result, self._sizes = result, sizes
        # the quantities of the outputs, with the chosen units as their units for display
        with shown_in(sizes):
            self._quantities = {p.path: p.quantity for p in outputs(result) if p.quantity}
        self.units = {
            name: q.shown_unit if q.shown_in_si else ("" if q.unit == "1" else q.unit)
            for name, q in self._quantities.items()
        }

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_") or name not in self._quantities:
            known = ", ".join(self.__dict__.get("_quantities", ()))
            raise AttributeError(f"no output {name!r}; known: {known}")
        return self._number(name, value_of(self.result, name))

    __getitem__ = __getattr__

    def __dir__(self) -> list[str]:
        return sorted({*super().__dir__(), *self._quantities})

    def _number(self, name: str, value: Any) -> Any:
        return self._quantities[name].in_table(value)[1]

    @property
    def errors(self) -> dict[str, float]:
        """Estimated discretisation errors by output."""
        return {
            name: self._number(name, value)
            for name, value in self.result.errors.items()
            if name in self._quantities
        }

    def to_dataframe(self) -> Any:
        """Return the table of :meth:`woundon.Result.to_dataframe`."""
        frame = to_frame(self.result)
        for name in frame:
            frame[name] = self._number(name, frame[name])
        frame.attrs["units"] = {name: self.units[name] or "1" for name in frame}
        return frame

    def plot(self, *args: Any, **options: Any) -> Any:
        """Draw the result; see :meth:`woundon.Result.plot`."""
        with shown_in(self._sizes):
            return self.result.plot(*args, **options)

    def save(self, path: Any) -> None:
        """Write a ``.csv`` table; netCDF and JSON files are always in SI."""
        with shown_in(self._sizes):
            self.result.save(path)

    def __str__(self) -> str:
        with shown_in(self._sizes):
            return str(self.result)

    def __repr__(self) -> str:
        with shown_in(self._sizes):
            return repr(self.result)


def in_units(result: Result, chosen: Iterable[str], by_name: Mapping[str, str]) -> ResultInUnits:
    """Return a result in units; parameters as of :meth:`woundon.Result.in_units`."""
    kind, width = kinds.of(result), getattr(result.problem, "width", None)
    places = [
        p
        for p in (*walk(result.problem), *walk(kind.problem), *outputs(result))
        if p.quantity is not None
    ]
    sizes: Sizes = {}
    for unit in [chosen] if isinstance(chosen, str) else chosen:
        matches = (
            _system(places, unit) if unit in SYSTEMS else _quantities_with_unit(places, unit, width)
        )
        if not matches:
            raise _no_such_unit(unit, width)
        sizes |= matches
    for name, unit in by_name.items():
        matches = _quantities_with_unit([p for p in places if p.path == name], unit, width)
        if not matches:
            with units({name: unit}):  # raises with the reason, if the name or the unit is unknown
                raise _no_such_unit(unit, width)
        sizes |= matches
    return ResultInUnits(result, sizes)


def _system(places: Iterable[Place], system: str) -> Sizes:
    """Return the units of a system."""
    sizes: Sizes = {}
    for path, quantity in ((p.path, p.quantity) for p in places):
        assert quantity is not None
        unit = quantity.unit if system == "SI" else MILL.get(quantity.display or "1", "")
        if unit and unit != "1":
            size = 1.0 if system == "SI" else float(factor(unit, quantity.unit, path))
            sizes[path, quantity.unit] = (unit, size)
    return sizes


def _quantities_with_unit(places: Iterable[Place], unit: str, width: float | None) -> Sizes:
    """Return sizes of a unit for all quantities that have its dimension per width or in total."""
    sizes: Sizes = {}
    for path, quantity in ((p.path, p.quantity) for p in places):
        assert quantity is not None
        total = _TOTALS.get(quantity.unit, "")
        for si_unit, scale in ((quantity.unit, 1.0), (total, 1 / width if width else 0.0)):
            try:
                size = scale * float(factor(unit, si_unit, path)) if si_unit else 0.0
            except InvalidProblem:
                continue
            if size:
                sizes[path, quantity.unit] = (unit, size)
    return sizes


def _no_such_unit(unit: str, width: float | None) -> InvalidProblem:
    """Return the error for a unit that no output has."""
    for per_width, total in _TOTALS.items():
        try:
            factor(unit, total, "units")
        except InvalidProblem:
            continue
        if width is None:
            text = f"{unit!r} is the unit of a total; give the problem a width, or write a unit "
            return InvalidProblem.at("units", f"{text}of {per_width}")
    try:
        factor(unit, "N/m", "units")
    except InvalidProblem as fault:
        if "dimension" not in str(fault):
            return fault
    return InvalidProblem.at("units", f"no output has the dimension of {unit!r}")
