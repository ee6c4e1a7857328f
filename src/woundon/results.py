"""What all results share: their problem, their certificate, their errors, and how they are shown.

A result's outputs are its fields and properties that carry a
:class:`~woundon.quantities.Quantity`; saving, drawing and reporting find what they need through
:mod:`woundon.kinds`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import MISSING, dataclass, field, fields, replace
from enum import IntEnum
from types import MappingProxyType
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Self, TypeVar, overload

import numpy as np

from .errors import RESOLUTION, NotConverged, warn
from .quantities import Quantity, pure, scalar_outputs, value_of

if TYPE_CHECKING:
    from os import PathLike

    import pandas as pd
    import xarray
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from .io.chosen_units import ResultInUnits

__all__ = [
    "ACCEPTED_RESIDUAL", "ReadOnly", "Residuals", "Result", "Zone", "largest", "measured",
    "positive", "zone_runs",
]  # fmt: skip

ResultT = TypeVar("ResultT", bound="Result")

ACCEPTED_RESIDUAL = 1e-8


class Zone(IntEnum):
    """State of a contact point: stick, or slip with the web faster or slower than the body."""

    BACKWARD = -1
    STICK = 0
    FORWARD = 1

    @property
    def word(self) -> str:
        """What the web, or the lower surface, is against the body: "slower", "stick", "faster"."""
        return ("slower", "stick", "faster")[self + 1]


def zone_runs(x: np.ndarray, zones: np.ndarray) -> list[tuple[int, float, float]]:
    """Return runs (zone, from, to) [m] of neighbouring nodes in the same zone.

    Boundaries lie halfway between nodes.
    """
    changes = np.nonzero(np.diff(zones))[0]
    ends = [float(x[0]), *((x[changes] + x[changes + 1]) / 2).tolist(), float(x[-1])]
    first = [0, *(changes + 1).tolist()]
    return [(int(zones[k]), a, b) for k, a, b in zip(first, ends, ends[1:], strict=False)]


def largest(values: Any) -> float:
    """Return the largest of some violations, 0 of none, nan if one is nan.

    Python's ``max`` drops a nan that does not come first.
    """
    return float(np.maximum.reduce(values, axis=None, initial=0.0))


def positive(*values: np.ndarray) -> float:
    """Return 0 if all values are positive, else inf; nan counts as a violation."""
    return 0.0 if all((each > 0).all() for each in values) else float("inf")


class Residuals:
    """The certificate: the largest violation of each law, dimensionless, by the law's name.

    Pressures and tractions are measured by the largest pressure (times mu for the tractions),
    slips by the largest slope of the gap, loads by the load.
    """

    __slots__ = ("_laws",)

    def __init__(self, **laws: float) -> None:
        self._laws = MappingProxyType({law: float(value) for law, value in laws.items()})

    def items(self) -> Iterator[tuple[str, float]]:
        """Yield (law, violation)."""
        return iter(self._laws.items())

    @property
    def largest(self) -> float:
        """The largest of them; nan if one is nan, or if there is no law at all."""
        return float(np.max(list(self._laws.values()), initial=-np.inf)) if self._laws else np.nan

    @property
    def worst(self) -> str:
        """The law that is violated most; one whose violation is nan before all others."""
        return max(
            self._laws, key=lambda law: (self._laws[law] != self._laws[law], self._laws[law])
        )

    def replace(self, **laws: float) -> Residuals:
        """Return the same with some violations changed."""
        return Residuals(**self._laws | laws)

    def __getattr__(self, law: str) -> float:
        if law.startswith("_"):
            raise AttributeError(law)
        try:
            return self._laws[law]
        except KeyError:
            known = ", ".join(self._laws)
            raise AttributeError(f"no law {law!r} in this certificate; known: {known}") from None

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Residuals) and _same(dict(self._laws), dict(other._laws))

    __hash__ = None  # type: ignore[assignment]

    def __reduce__(self) -> Any:
        return _residuals, (dict(self._laws),)

    def __repr__(self) -> str:
        return f"Residuals({', '.join(f'{law}={v:.2g}' for law, v in self.items())})"


def _residuals(laws: dict[str, float]) -> Residuals:
    return Residuals(**laws)


class Presented:
    """Base of what users print, draw and export: results, margins, sensitivities, fits, tables.

    The packages ``show`` and ``io`` are imported when they are used; they depend on all others.
    """

    def __str__(self) -> str:
        from .show.presentation import text_of

        return text_of(self)

    def _repr_html_(self) -> str:
        from .show.presentation import html_of

        return html_of(self)

    def _html_of_table(self, head: str, frame: pd.DataFrame, remarks: Iterable[str] = ()) -> str:
        from .show.presentation import html_of_table

        return html_of_table(head, frame, remarks)

    def _figure(self, *options: Any) -> Any:
        from .show.presentation import figure_of

        return figure_of(self, *options)


class ReadOnly:
    """A dataclass whose arrays cannot be written to, nor can those of a copy or of a pickle."""

    def __post_init__(self) -> None:
        for value in vars(self).values():
            if isinstance(value, np.ndarray):
                value.setflags(write=False)

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self.__post_init__()


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class Result(Presented, ReadOnly):
    """What a solve returns; immutable.

    Attributes
    ----------
    problem : Problem
    residuals : Residuals
        The certificate.
    errors : mapping of str to float
        Estimated discretisation errors by output, SI units; nan where it cannot be told.
    warnings : tuple of str
        Where the solved case leaves the model's validity, or the grid is too coarse for it, with
        numbers; the latter begin with ``resolution:``.
    MAIN : tuple of str
        The outputs that a study gives where none is asked for.
    REPLACED : mapping of str to str
        Names that people may look for in vain, with what there is instead.
    MAY_BE_NAN : set of str, optional
        Fields that may be nan; in a file all others must be finite.  None where that is not told.
    ALONG : mapping of str to str
        Arrays that run along another one than the first, with its name.
    ESTIMATES : set of str
        Fields that no law of the certificate determines: estimates, and records of the solution.
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
    def residual(self) -> Annotated[float, pure("r", "largest violation of a contact law")]:
        """The largest violation of a law, dimensionless."""
        return self.residuals.largest

    @property
    def relabelled(self) -> Mapping[str, Quantity]:
        """Outputs that are another quantity in this very result than in others of its class."""
        return {}

    def checked(self, accepted: float = ACCEPTED_RESIDUAL) -> Self:
        """Return itself, if no law is broken: nothing unsolved is passed off as solved.

        Parameters
        ----------
        accepted : float
            The largest residual of a law that is satisfied.

        Raises
        ------
        NotConverged
            Naming every law that is not satisfied; carries the result.
        """
        broken = [f"{k} {v:.2g}" for k, v in self.residuals.items() if not v <= accepted]
        if broken or not self.residuals.largest <= accepted:
            told = ", ".join(broken) or "there is no certificate"
            if any(law.startswith("positive_pressure") for law in broken):
                told += "; the surfaces part within the contact, which is taken for one piece"
            outside = [text for text in self.warnings if not text.startswith(RESOLUTION)]
            shown = f"{accepted:g}".replace("e-0", "e-")
            text = "; ".join((f"laws are not satisfied to {shown}: {told}", *outside))
            raise NotConverged(text, self)
        return self

    def warned(self) -> Self:
        """Return itself, its warnings issued as Python's at the line that asked for the result."""
        warn(self.warnings)
        return self

    def certified(self) -> Residuals:
        """Return the certificate measured anew, from the problem and the arrays held here."""
        raise NotImplementedError(f"a {type(self).__name__} cannot be certified anew")

    def recomputed(self) -> Mapping[str, tuple[float, float]]:
        """Return the scalars that no law tells, by name: as the arrays give them, how exactly."""
        return {}

    @property
    def assumptions(self) -> tuple[str, ...]:
        """What the model assumes of this case, as sentences."""
        return tuple(getattr(self.problem, "assumptions", ()))

    def replace(self, **changes: Any) -> Self:
        """Return the same result with other fields."""
        return replace(self, **changes)

    @overload
    def plot(self, path: str | PathLike[str] | None = None, ax: None = None,
             panels: str | Sequence[str] | None = None) -> Figure: ...  # fmt: skip

    @overload
    def plot(self, path: str | PathLike[str] | None = None, *, ax: Axes,
             panels: str | Sequence[str] | None = None) -> Axes: ...  # fmt: skip

    def plot(self, path: Any = None, ax: Any = None, panels: Any = None) -> Any:
        """Draw the result; see :func:`woundon.plot`, which draws several in one picture.

        Parameters
        ----------
        path : path, optional
            Where to save, ``.png``, ``.svg`` or ``.pdf``.  Without it, and without ``ax``, a
            notebook shows the figure, and in a script ``plt.show()`` does.
        ax : matplotlib.axes.Axes, optional
            Into which one panel is drawn.
        panels : str or sequence of str, optional
            Which to draw, by name; a wrong name is told the choice.

        Returns
        -------
        matplotlib.figure.Figure, or ``ax`` where it is given
        """
        return self._figure(path, ax, panels)

    def save(self, path: Any) -> None:
        """Write the result to a file, by its ending: ``.nc``, ``.json`` or ``.csv``."""
        from .io.result_files import save_result

        save_result(self, path)

    def in_units(self, /, *chosen: str, **by_name: str) -> ResultInUnits:
        """Return the result with outputs as numbers in chosen units.

        >>> result.in_units("pli").wound_on_tension  # doctest: +SKIP
        4.0
        >>> print(result.in_units("mill", half_width="mm"))  # doctest: +SKIP

        Parameters
        ----------
        chosen : str
            Units ("pli", "psi", "um"): every output of the same dimension is given in it.  A unit
            of a total ("kN") multiplies by the ``width`` of the problem.  "mill" stands for the
            units of North American mills, "SI" for those of attributes.
        by_name : str
            Unit of one output or field, by its name.

        Returns
        -------
        ResultInUnits
            Outputs that no unit is chosen for are in SI.

        Raises
        ------
        InvalidProblem
            For an unknown unit or name, or a unit that no output has.
        """
        from .io.chosen_units import in_units

        return in_units(self, chosen, by_name)

    def to_xarray(self) -> xarray.Dataset:
        """Return the result as an xarray Dataset, every variable with unit and symbol."""
        from .io.result_files import to_dataset

        return to_dataset(self)

    def to_dataframe(self) -> pd.DataFrame:
        """Return the arrays as columns of a pandas DataFrame, SI units.

        Of a result without arrays its numbers, in a single row.  ``attrs["units"]`` and
        ``attrs["long_names"]`` tell what each column is.
        """
        from .io.frames import to_frame

        return to_frame(self)

    def __dir__(self) -> list[str]:
        # what is of use: not what its kind is made of, nor what it has something else in place of
        unsaved = {part.name for part in fields(self) if not part.metadata.get("saved", True)}
        hidden = {*unsaved, *self.REPLACED, "relabelled"}
        names = set(super().__dir__()) - hidden
        return sorted(name for name in names if not name.startswith("_") and not name.isupper())

    def __repr__(self) -> str:
        known, told = scalar_outputs(self), []
        del known["residual"]  # told last
        for name in dict.fromkeys((*filter(known.get, self.MAIN), *known)):
            value = value_of(self, name)
            if isinstance(value, float) and value == value:
                told.append(f"{name}={known[name].shown(value):.5g} {known[name].display}".strip())
            if len(told) == 3:
                break
        return f"{type(self).__name__}({', '.join(told)}, residual={self.residual:.1e})"

    def __eq__(self, other: object) -> bool:
        if type(other) is not type(self):
            return NotImplemented
        return all(
            _same(getattr(self, part.name), getattr(other, part.name))
            for part in fields(self) if part.compare
        )  # fmt: skip

    def __hash__(self) -> int:
        # of what equal results share and no nan or signed zero can part
        return hash((type(self), self.problem))

    def __getstate__(self) -> dict[str, Any]:
        # as in a file: a mesh, with its matrices a hundred times the rest, is made anew when needed
        made_anew = {
            part.name: part.default for part in fields(self)
            if not part.metadata.get("saved", True) and part.default is not MISSING
        }  # fmt: skip
        return {**self.__dict__, "errors": dict(self.errors), **made_anew}


def measured(
    result: ResultT, *, errors: Mapping[str, float], residuals: Residuals, warnings: tuple[str, ...]
) -> ResultT:
    """Return the same result with what was measured on it.

    Parameters
    ----------
    result : Result
        As it was made, without any of these.
    errors : mapping of str to float
        Estimated discretisation errors by output, SI units.
    residuals : Residuals
    warnings : tuple of str
    """
    found = object.__new__(type(result))  # all else was seen to when it was made
    vars(found).update(vars(result), residuals=residuals, warnings=warnings)
    vars(found)["errors"] = MappingProxyType(dict(errors))
    return found


def _same(one: Any, two: Any) -> bool:
    """Return whether two fields are equal; nan equals nan."""
    if type(one) is type(two) and getattr(one, "part_of_result", False):
        return all(_same(getattr(one, f.name), getattr(two, f.name)) for f in fields(one))
    if isinstance(one, np.ndarray) and isinstance(two, np.ndarray):
        return bool(np.array_equal(one, two, equal_nan=one.dtype.kind == "f"))
    if isinstance(one, Mapping) and isinstance(two, Mapping):
        return one.keys() == two.keys() and all(_same(one[k], two[k]) for k in one)
    if isinstance(one, tuple) and isinstance(two, tuple):
        return len(one) == len(two) and all(map(_same, one, two))
    return bool(one == two or (one != one and two != two))
