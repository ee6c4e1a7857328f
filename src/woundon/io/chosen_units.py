"""Display units of fields and outputs: ``wo.units(nip_load="kN/m")``, ``--unit``."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from os import PathLike
from typing import TYPE_CHECKING, Any

from .. import kinds
from ..arguments import check_type
from ..errors import InvalidProblem, did_you_mean, mapping_of
from ..problems.problem import Problem
from ..problems.units import MILL, TOTALS, factor
from ..quantities import DISPLAYED, Choice, Place, outputs, pattern, shown_in, value_of, walk
from ..results import Result
from .frames import to_frame

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["ResultInUnits", "check_names", "in_units", "units", "units_of"]

Names = dict[tuple[str, str], tuple[str, float]]  # as of woundon.quantities.Choice
System = dict[str, tuple[str, float]]  # unit for display -> unit in its place, its size in SI
SYSTEMS = ("SI", "mill")
SYSTEM = "system of units"  # its name among those of fields and outputs
# Units of quantities that are certainly per width, and those of their totals.
PER_WIDTH = {unit: total for unit, (_, total) in TOTALS.items() if unit.endswith("/m")}


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
        For an unknown name, or a unit that is no text, unknown or of another dimension.

    Examples
    --------
    >>> import woundon as wo
    >>> result = wo.solve(wo.RollerProblem.example(), nodes=33)
    >>> with wo.units(half_width="um"):
    ...     "um" in str(result)
    True
    """
    check_type("chosen", {} if chosen is None else chosen, Mapping)
    requested = {**(chosen or {}), **more}
    for name, unit in requested.items():
        check_type("chosen", name, str)
        check_type(name, unit, str)
    names = _by_name(requested, _places(kinds.every())) if requested else {}
    with shown_in(Choice(names)):
        yield


@contextmanager
def units_of(settings: Iterable[str]) -> Iterator[None]:
    """Use the units of texts "NAME=UNIT" of the command line, and those of the system "mill"."""
    requested = units_by_name(settings)
    system = _system(requested.pop(SYSTEM)) if SYSTEM in requested else {}
    with shown_in(Choice(system=system)), units(requested):
        yield


def units_by_name(settings: Iterable[str]) -> dict[str, str]:
    """Return the units of texts "NAME=UNIT" by name, a system of units by the name SYSTEM.

    >>> units_by_name(["nip_load = kN/m", "mill"])
    {'nip_load': 'kN/m', 'system of units': 'mill'}
    """
    chosen: list[tuple[str, str]] = []
    for text in settings:
        name, _, unit = (part.strip() for part in text.partition("="))
        if text in SYSTEMS:
            name, unit = SYSTEM, text
        if not name or not unit:
            reason = "must be written NAME=UNIT, e.g. nip_load='kN/m', or mill"
            raise InvalidProblem.at(text, reason)
        chosen.append((name, unit))
    return mapping_of(chosen)


def check_names(settings: Iterable[str], problems: Iterable[Problem | type[Problem]]) -> None:
    """Reject units of names that are no field or output of the kinds of some problems.

    Parameters
    ----------
    settings : iterable of str
        As of :func:`units_of`.
    problems : iterable of Problem, or of classes of problems

    Raises
    ------
    InvalidProblem
        States the permitted names.
    """
    requested = units_by_name(settings)
    requested.pop(SYSTEM, None)
    _by_name(requested, _places(map(kinds.of, problems)))


def _places(described: Iterable[kinds.Kind[Any, Any]]) -> list[Place]:
    """Return the fields and outputs of kinds of problem, with their names and quantities."""
    return [place for kind in described for place in (*walk(kind.problem), *outputs(kind.result))]


def _by_name(
    requested: Mapping[str, str], places: Iterable[Place], width: float | None = None
) -> Names:
    """Return requested units with their sizes, by name and SI unit.

    Parameters
    ----------
    requested : mapping of str to str
        Name of a field or output -> unit.
    places : iterable of Place
        The fields and outputs that may be named; a name may have several quantities, by kind.
    width : float, optional
        Of the web [m]; with it, a unit of a total force is one of a force per width.

    Raises
    ------
    InvalidProblem
        Lists all unknown names, and units that are unknown or of another dimension.
    """
    known: dict[str, list[str]] = {}
    for place in places:
        if place.quantity is not None:
            known.setdefault(place.path, []).append(place.quantity.unit)
    names: Names = {}
    faults: list[tuple[str, str]] = []
    for name, unit in requested.items():
        si_units = known.get(pattern(name))
        if si_units is None:
            faults.append((name, f"no field or output{did_you_mean(name, known)}"))
            continue
        sizes = {si_unit: _size(unit, si_unit, width) for si_unit in si_units}
        names |= {(name, si_unit): (unit, size) for si_unit, size in sizes.items() if size}
        if not any(sizes.values()):
            try:  # the conversion fails again, with its error message
                factor(unit, si_units[-1], name)
            except InvalidProblem as fault:
                faults += fault.faults
    if faults:
        raise InvalidProblem(faults)
    return names


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

    def __init__(self, result: Result, choice: Choice) -> None:
        self.result, self._choice = result, choice
        self._quantities = {p.path: p.quantity for p in outputs(result) if p.quantity}
        self.units = {name: self._in_table(name, 1.0)[0] for name in self._quantities}
        self.units = {name: "" if unit == "1" else unit for name, unit in self.units.items()}

    def __getattr__(self, name: str) -> Any:
        # Python looks up names with an underscore to copy, also before there are quantities
        if name.startswith("_") or name not in self._quantities:
            known = ", ".join(self.__dict__.get("_quantities", ()))
            raise AttributeError(f"no output {name!r}; known: {known}")
        return self._number(name, value_of(self.result, name))

    __getitem__ = __getattr__

    def __dir__(self) -> list[str]:
        return sorted({*super().__dir__(), *self._quantities})

    def _in_table(self, name: str, value: Any) -> tuple[str, Any]:
        """Return unit and value of an output."""
        with shown_in(self._choice):
            return self._quantities[name].in_table(value)

    def _number(self, name: str, value: Any) -> Any:
        """Return an SI value, or an array of them, of an output in its unit."""
        return self._in_table(name, value)[1]

    @property
    def errors(self) -> dict[str, float]:
        """Estimated discretisation errors by output."""
        return {
            name: self._number(name, value)
            for name, value in self.result.errors.items()
            if name in self._quantities
        }

    def to_dataframe(self) -> pd.DataFrame:
        """Return the table of :meth:`woundon.Result.to_dataframe`."""
        frame = to_frame(self.result)
        for name in frame:
            frame[name] = self._number(name, frame[name])
        frame.attrs["units"] = {name: self.units[name] or "1" for name in frame}
        return frame

    def plot(
        self,
        path: str | PathLike[str] | None = None,
        ax: Axes | None = None,
        panels: str | Sequence[str] | None = None,
    ) -> Figure | Axes:
        """Draw the result; see :meth:`woundon.Result.plot`."""
        with shown_in(self._choice):
            return self.result._figure(path, ax, panels)

    def save(self, path: str | PathLike[str]) -> None:
        """Write a ``.csv`` table; netCDF and JSON files are always in SI."""
        with shown_in(self._choice):
            self.result.save(path)

    def __str__(self) -> str:
        with shown_in(self._choice):
            return str(self.result)

    def __repr__(self) -> str:
        with shown_in(self._choice):
            return repr(self.result)


def in_units(result: Result, chosen: Iterable[str], by_name: Mapping[str, str]) -> ResultInUnits:
    """Return a result in units.

    Parameters
    ----------
    result : Result
    chosen, by_name
        As of :meth:`woundon.Result.in_units`: units, and units by the name of an output.
    """
    width = getattr(result.problem, "width", None)
    places = [*walk(kinds.of(result).problem), *outputs(result)]
    displayed = _displayed(places)
    system: System = {}
    for unit in [chosen] if isinstance(chosen, str) else chosen:
        if unit in SYSTEMS:
            system |= _system(unit)
            continue
        sizes = {name: _size(unit, si_unit, width) for name, si_unit in displayed.items()}
        replaced = {name: (unit, size) for name, size in sizes.items() if size}
        if not replaced:
            raise _no_such_unit(unit, width)
        system |= replaced
    return ResultInUnits(result, Choice(_by_name(by_name, places, width), system))


def _displayed(places: Iterable[Place]) -> dict[str, str]:
    """Return the units in which quantities are displayed by default, with their SI units.

    SI units are among them, which texts of results have.
    """
    quantities = [place.quantity for place in places if place.quantity is not None]
    si_units = {quantity.unit for quantity in quantities}
    usual = {name: unit for name, (unit, _) in DISPLAYED.items() if unit in si_units}
    plain = {unit: unit for unit in si_units}
    return plain | usual | {q.shown_unit or q.unit: q.unit for q in quantities}


def _system(system: str) -> System:
    """Return the units of "SI" or "mill", by the unit that they replace where values are displayed.

    The second number is the unit's size in SI: ``{"N/m": ("pli", 175.1), "mm": ("in", 0.0254)}`` of
    mill units, and ``{"N/m": ("N/m", 1.0), "mm": ("m", 1.0)}`` of SI units.
    """
    sizes: System = {}
    for displayed_unit, si_unit in _displayed(_places(kinds.every())).items():
        unit = si_unit if system == "SI" else MILL.get(displayed_unit, "")
        if unit and unit != "1":
            size = 1.0 if unit == si_unit else float(factor(unit, si_unit, displayed_unit))
            sizes[displayed_unit] = (unit, size)
    return sizes


def _size(unit: str, si_unit: str, width: float | None) -> float | None:
    """Return the size of a unit in an SI unit; None if it has another dimension.

    With a width, a unit of the total over it ("kN" for "N/m") is converted too.
    """
    with suppress(InvalidProblem):
        return float(factor(unit, si_unit, "unit"))
    total = PER_WIDTH.get(si_unit)
    if total and width:
        with suppress(InvalidProblem):
            return 1 / width * float(factor(unit, total, "unit"))
    return None


def _no_such_unit(unit: str, width: float | None) -> InvalidProblem:
    """Return the error for a unit that no output has.

    It may be the unit of a total that cannot be converted without the width of the web, no unit at
    all, or a unit of another dimension.
    """
    for per_width, total in PER_WIDTH.items():
        try:
            factor(unit, total, "units")
        except InvalidProblem:
            continue
        if width is None:
            text = f"{unit!r} is the unit of a total; give the problem a width, or write a unit "
            return InvalidProblem.at("units", f"{text}of {per_width}")
    # A conversion to any SI unit fails here: because of the dimension, or because the text is no
    # unit, of which the error says more than the text below.
    try:
        factor(unit, "N/m", "units")
    except InvalidProblem as fault:
        if "dimension" not in str(fault):
            return fault
    return InvalidProblem.at("units", f"no output has the dimension of {unit!r}")
