"""Base class of results: problem, residuals, error estimates, presentation.

The outputs of a result are its fields and properties that are annotated with a
:class:`~woundon.quantities.Quantity`; saving, drawing and reporting find what they need through
:mod:`woundon.kinds`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import MISSING, dataclass, field, fields, replace
from enum import IntEnum
from types import MappingProxyType
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Self, TypeVar, overload

import numpy as np

from .errors import RESOLUTION, InvalidProblem, NotConverged, did_you_mean, warn
from .quantities import Quantity, pure, scalar_outputs, value_of

if TYPE_CHECKING:
    from os import PathLike

    import pandas as pd
    import xarray
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import ArrayLike

    from .io.chosen_units import ResultInUnits

__all__ = [
    "ACCEPTED_RESIDUAL",
    "ReadOnly",
    "Residuals",
    "Result",
    "Zone",
    "largest",
    "measured",
    "positive",
    "zone_runs",
]

ResultT = TypeVar("ResultT", bound="Result")

# A converged Newton iteration leaves residuals of 1e-11 or less; a wrong one leaves far more.
ACCEPTED_RESIDUAL = 1e-8


class Zone(IntEnum):
    """State of a contact point: stick, or slip with the web faster or slower than the body.

    Examples
    --------
    >>> Zone(1), Zone.STICK.word
    (<Zone.FORWARD: 1>, 'stick')
    """

    BACKWARD = -1
    STICK = 0
    FORWARD = 1

    @property
    def word(self) -> str:
        """Speed of the web, or lower surface, relative to the body: slower, stick, faster."""
        return ("slower", "stick", "faster")[self + 1]  # of -1, 0, 1


def zone_runs(x: np.ndarray, zones: np.ndarray) -> list[tuple[int, float, float]]:
    """Return runs (zone, from, to) [m] of neighbouring nodes in the same zone.

    ``x`` are the nodes, ``zones`` their zones, both (n,).  Boundaries lie halfway between nodes.
    """
    changes = np.nonzero(np.diff(zones))[0]
    ends = [float(x[0]), *((x[changes] + x[changes + 1]) / 2).tolist(), float(x[-1])]
    first = [0, *(changes + 1).tolist()]
    return [(int(zones[k]), a, b) for k, a, b in zip(first, ends, ends[1:], strict=False)]


def largest(values: ArrayLike) -> float:
    """Return the largest of some violations: 0 if there are none, nan if one is nan.

    Python's ``max`` drops a nan that does not come first.
    """
    return float(np.maximum.reduce(values, axis=None, initial=0.0))


def positive(*values: np.ndarray) -> float:
    """Return the violation of positivity: 0 if all values are positive, else inf, also for nan."""
    return 0.0 if all((each > 0).all() for each in values) else float("inf")


class Residuals:
    """The largest violation of each contact condition, dimensionless, by its name.

    Pressures are relative to the largest pressure, tractions to mu times the largest pressure,
    slip velocities to the largest slope of the gap, and loads to the load.

    Examples
    --------
    >>> residuals = Residuals(gap_slope=1e-14, load=3e-16)
    >>> residuals.largest, residuals.worst, residuals.load
    (1e-14, 'gap_slope', 3e-16)
    """

    __slots__ = ("_values",)

    def __init__(self, **values: float) -> None:
        self._values = MappingProxyType({name: float(value) for name, value in values.items()})

    def items(self) -> Iterator[tuple[str, float]]:
        """Yield (condition, violation)."""
        return iter(self._values.items())

    @property
    def largest(self) -> float:
        """The largest violation; nan if one is nan, or if there are none."""
        values = list(self._values.values())
        return float(np.max(values)) if values else np.nan

    @property
    def worst(self) -> str:
        """The condition with the largest violation; one with nan precedes all others."""
        values = self._values
        # a nan differs from itself, and True is larger than False
        return max(values, key=lambda name: (values[name] != values[name], values[name]))

    def replace(self, **values: float) -> Residuals:
        """Return a copy in which some violations are replaced."""
        return Residuals(**self._values | values)

    def __getattr__(self, name: str) -> float:
        """Return the violation of the condition with this name."""
        if name.startswith("_"):
            raise AttributeError(name)
        try:
            return self._values[name]
        except KeyError:
            known = ", ".join(self._values)
            raise AttributeError(f"no contact condition {name!r}; known: {known}") from None

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Residuals) and _same(dict(self._values), dict(other._values))

    __hash__ = None  # type: ignore[assignment]

    def __reduce__(self) -> Any:
        return _residuals, (dict(self._values),)

    def __repr__(self) -> str:
        return f"Residuals({', '.join(f'{name}={value:.2g}' for name, value in self.items())})"


def _residuals(values: dict[str, float]) -> Residuals:
    """Return residuals from a pickle, which calls this without keywords."""
    return Residuals(**values)


class Presented:
    """Base class of all that users print, draw and export.

    Results, margins, sensitivities, fits and tables of studies inherit from it.

    The packages ``report`` and ``io`` are imported when they are used; they depend on all others.
    """

    def __str__(self) -> str:
        """Return the report as text."""
        from .report.presentation import text_of

        return text_of(self)

    def _repr_html_(self) -> str:
        """Return the report as HTML, which notebooks display."""
        from .report.presentation import html_of

        return html_of(self)

    def _figure(self, *options: Any) -> Figure | Axes:
        """Draw the figure of this object; options are the arguments of its method ``plot``."""
        from .report.presentation import figure_of

        return figure_of(self, *options)


class ReadOnly:
    """A dataclass whose arrays are read-only, also those of a copy or of a pickle."""

    def __post_init__(self) -> None:
        """Make all arrays read-only."""
        for value in vars(self).values():
            if isinstance(value, np.ndarray):
                value.setflags(write=False)

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Restore a copy or a pickle, whose arrays would be writable."""
        self.__dict__.update(state)
        self.__post_init__()


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class Result(Presented, ReadOnly):
    """The solution of a problem; immutable.

    Attributes
    ----------
    problem : Problem
    residuals : Residuals
        Violations of the contact conditions.
    errors : mapping of str to float
        Estimated discretisation errors by output, SI units; nan if there is no estimate.
    warnings : tuple of str
        Sentences with numbers where the case lies outside the validity limits of the model, or
        where the mesh is too coarse for it; the latter begin with ``resolution:``.
    MAIN : tuple of str
        The default outputs of a study.
    REPLACED : mapping of str to str
        Names that users may try, with the names to use instead.
    MAY_BE_NAN : set of str, optional
        Fields that may be nan; in a file all others must be finite.  None if that is not declared.
    ALONG : mapping of str to str
        Arrays that run along another array than the first one, with the name of that array.
    ESTIMATES : set of str
        Fields that no contact condition determines: estimates, and records of the solution.

    Examples
    --------
    >>> import woundon as wo
    >>> result = wo.solve(wo.NipProblem.example(), nodes=41)
    >>> result.residuals.largest < 1e-8
    True
    >>> print(f"{result.wound_on_tension:.0f} N/m, {result.error('wound_on_tension'):.1f} N/m")
    700 N/m, 2.2 N/m
    """

    MAIN: ClassVar[tuple[str, ...]] = ()
    REPLACED: ClassVar[Mapping[str, str]] = MappingProxyType({})
    MAY_BE_NAN: ClassVar[frozenset[str] | None] = None
    ALONG: ClassVar[Mapping[str, str]] = MappingProxyType({})
    ESTIMATES: ClassVar[frozenset[str]] = frozenset()

    problem: Any
    residuals: Residuals
    errors: Mapping[str, float] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "errors", MappingProxyType(dict(self.errors)))

    @property
    def residual(self) -> Annotated[float, pure("r", "largest violation of a contact condition")]:
        """The largest violation of a contact condition, dimensionless."""
        return self.residuals.largest

    def error(self, output: str) -> float:
        """Return the estimated discretisation error of an output, nan if there is no estimate.

        Parameters
        ----------
        output : str
            Name of a scalar output.

        Raises
        ------
        InvalidProblem
            For an unknown name.
        """
        if output not in self.errors and output not in scalar_outputs(self):
            text = f"unknown output{did_you_mean(output, scalar_outputs(self))}"
            raise InvalidProblem.at(output, text)
        return self.errors.get(output, float("nan"))

    @property
    def relabelled(self) -> Mapping[str, Quantity]:
        """Quantities, by output, that differ in this result from those of its class."""
        return {}

    def checked(self, accepted: float = ACCEPTED_RESIDUAL) -> Self:
        """Return the result itself if all contact conditions are satisfied.

        Parameters
        ----------
        accepted : float
            Largest residual of a condition that is satisfied.

        Raises
        ------
        NotConverged
            Naming every condition that is not satisfied; carries the result.
        """
        violated = [f"{k} {v:.2g}" for k, v in self.residuals.items() if not v <= accepted]
        if violated or not self.residuals.largest <= accepted:
            reasons = ", ".join(violated) or "no condition was evaluated"
            if any(name.startswith("positive_pressure") for name in violated):
                reasons += "; the surfaces separate within the contact, which the model excludes"
            # warnings about the validity limits may give the reason, those about the mesh do not
            beyond_limits = [text for text in self.warnings if not text.startswith(RESOLUTION)]
            shown = f"{accepted:g}".replace("e-0", "e-")  # 1e-8, not 1e-08
            text = f"contact conditions are not satisfied to {shown}: {reasons}"
            raise NotConverged("; ".join((text, *beyond_limits)), self)
        return self

    def warned(self) -> Self:
        """Issue the warnings as Python's, at the line of the caller; return the result itself."""
        warn(self.warnings)
        return self

    def certified(self) -> Residuals:
        """Return the residuals, evaluated from the problem and the arrays of this result."""
        raise NotImplementedError(f"a {type(self).__name__} does not evaluate its residuals")

    def recomputed(self) -> Mapping[str, tuple[float, float]]:
        """Return (value computed from the arrays, its tolerance) of scalars, by name [SI].

        They are those in the fields of the result that no contact condition determines.
        """
        return {}

    @property
    def assumptions(self) -> tuple[str, ...]:
        """Assumptions of the model for this case, as sentences."""
        return tuple(getattr(self.problem, "assumptions", ()))

    def replace(self, **changes: Any) -> Self:
        """Return a copy with some fields replaced."""
        return replace(self, **changes)

    @overload
    def plot(
        self,
        path: str | PathLike[str] | None = None,
        ax: None = None,
        panels: str | Sequence[str] | None = None,
    ) -> Figure: ...

    @overload
    def plot(
        self,
        path: str | PathLike[str] | None = None,
        *,
        ax: Axes,
        panels: str | Sequence[str] | None = None,
    ) -> Axes: ...

    def plot(self, path: Any = None, ax: Any = None, panels: Any = None) -> Any:
        """Draw the result; :func:`woundon.plot` draws several results in one figure.

        Parameters
        ----------
        path : path, optional
            File to save to, ``.png``, ``.svg`` or ``.pdf``.  Without it, and without ``ax``, a
            notebook displays the figure; a script calls ``plt.show()``.
        ax : matplotlib.axes.Axes, optional
            Axes for a single panel.
        panels : str or sequence of str, optional
            Names of the panels to draw; the error message for a wrong name lists all names.

        Returns
        -------
        matplotlib.figure.Figure, or ``ax`` if it is given
        """
        return self._figure(path, ax, panels)

    def save(self, path: str | PathLike[str]) -> None:
        """Save the result to a file; the suffix, .nc, .json or .csv, determines the format."""
        from .io.result_files import save_result

        save_result(self, path)

    def in_units(self, /, *chosen: str, **by_name: str) -> ResultInUnits:
        """Return the result with outputs as numbers in chosen units.

        Parameters
        ----------
        chosen : str
            Units ("pli", "psi", "um"), each for every output of its dimension.  A unit of a total
            force ("kN") multiplies by the ``width`` of the problem.  "mill" selects the units of
            North American mills, "SI" those of the attributes.
        by_name : str
            Unit of one output or field, by its name.

        Returns
        -------
        ResultInUnits
            Outputs without a chosen unit are in SI.

        Raises
        ------
        InvalidProblem
            For an unknown unit or name, or a unit that no output has.

        Examples
        --------
        >>> import woundon as wo
        >>> result = wo.solve(wo.NipProblem.example(), nodes=41)
        >>> print(f'{result.in_units("pli").wound_on_tension:.1f} pli')
        4.0 pli
        """
        from .io.chosen_units import in_units

        return in_units(self, chosen, by_name)

    def to_xarray(self) -> xarray.Dataset:
        """Return an xarray Dataset; its variables have the attributes unit and symbol."""
        from .io.datasets import to_dataset

        return to_dataset(self)

    def to_dataframe(self) -> pd.DataFrame:
        """Return the arrays as columns of a pandas DataFrame, SI units.

        A result without arrays returns its scalars in a single row.  ``attrs["units"]`` and
        ``attrs["long_names"]`` describe the columns.
        """
        from .io.frames import to_frame

        return to_frame(self)

    def __dir__(self) -> list[str]:
        """Return the names for completion, without internal fields and replaced names."""
        unsaved = {part.name for part in fields(self) if not part.metadata.get("saved", True)}
        hidden = {*unsaved, *self.REPLACED, "relabelled"}
        names = set(super().__dir__()) - hidden
        return sorted(name for name in names if not name.startswith("_") and not name.isupper())

    def __repr__(self) -> str:
        """Return the class with up to three outputs, the main ones first, and the residual."""
        known, texts = scalar_outputs(self), []
        del known["residual"]  # it comes last
        for name in dict.fromkeys((*filter(known.get, self.MAIN), *known)):
            value = value_of(self, name)
            if isinstance(value, float) and value == value:
                texts.append(f"{name}={known[name].shown(value):.5g} {known[name].display}".strip())
            if len(texts) == 3:
                break
        return f"{type(self).__name__}({', '.join(texts)}, residual={self.residual:.1e})"

    def __eq__(self, other: object) -> bool:
        """Return True for a result of the same class with equal fields; nan equals nan."""
        if type(other) is not type(self):
            return NotImplemented
        names = [part.name for part in fields(self) if part.compare]
        return all(_same(getattr(self, name), getattr(other, name)) for name in names)

    def __hash__(self) -> int:
        # nan and signed zeros in the arrays compare as equal but hash differently
        return hash((type(self), self.problem))

    def __getstate__(self) -> dict[str, Any]:
        """Return the state of a pickle, without the fields that files do not contain."""
        # meshes and their matrices, a hundred times as large, are recomputed on demand
        unsaved = [part for part in fields(self) if not part.metadata.get("saved", True)]
        defaults = {part.name: part.default for part in unsaved if part.default is not MISSING}
        return {**self.__dict__, "errors": dict(self.errors), **defaults}


def measured(
    result: ResultT, *, errors: Mapping[str, float], residuals: Residuals, warnings: tuple[str, ...]
) -> ResultT:
    """Return a copy of a result with error estimates, residuals and warnings.

    Parameters
    ----------
    result : Result
    errors : mapping of str to float
        Estimated discretisation errors by output, SI units.
    residuals : Residuals
    warnings : tuple of str
    """
    copy = object.__new__(type(result))  # __post_init__ has already treated the other fields
    vars(copy).update(vars(result), residuals=residuals, warnings=warnings)
    vars(copy)["errors"] = MappingProxyType(dict(errors))
    return copy


def _same(one: Any, two: Any) -> bool:
    """Return True if two values of a field are equal; nan equals nan, also in arrays and parts."""
    if type(one) is type(two) and getattr(one, "part_of_result", False):
        return all(_same(getattr(one, f.name), getattr(two, f.name)) for f in fields(one))
    if isinstance(one, np.ndarray) and isinstance(two, np.ndarray):
        return bool(np.array_equal(one, two, equal_nan=one.dtype.kind == "f"))
    if isinstance(one, Mapping) and isinstance(two, Mapping):
        return one.keys() == two.keys() and all(_same(one[k], two[k]) for k in one)
    if isinstance(one, tuple) and isinstance(two, tuple):
        return len(one) == len(two) and all(map(_same, one, two))
    return bool(one == two or (one != one and two != two))
