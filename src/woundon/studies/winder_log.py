"""``wo.read_log``: the log of a winder, averaged over the radius, for problems and comparisons."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import nan
from typing import TYPE_CHECKING, Any

import numpy as np

from ..arguments import check_type
from ..errors import InvalidProblem
from ..io.logs import POSITIONS, BinnedLog, read_binned
from ..problems.problem import Problem
from ..problems.schedules import Profile, schedule_fields
from ..quantities import Quantity, walk
from .column_names import columns_of, conversion_of
from .observations import measured_columns
from .outcome import Outcome

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["WinderLog", "read_log"]

Array = np.ndarray


def read_log(
    log: Any,
    problem: Problem,
    *,
    columns: Mapping[str, str | None] | None = None,
    bins: int | None = None,
    sheet: str = "",
) -> WinderLog:
    """Read the log of a winder and average it over bins of the radius.

    Rows without a radius, those during a stop (web speed or web tension below 5 % of its median),
    those whose radius is outside of the core and the roll of the problem by more than a tenth of
    the build-up, and those with a spike of the radius are left out; the result states how many.
    Columns with unknown names are ignored.

    Parameters
    ----------
    log : path, mapping or pandas.DataFrame
        CSV, Excel, ``.lvm`` or ``.tdms`` file, of up to a million rows, with a column of the radius
        or the diameter and columns of inputs or outputs of the problem, with their units.
    problem : Problem
        Its fields and outputs are the names of the columns; its width converts total forces.
    columns : mapping
        Header -> name, with or without unit; None omits a column.
    bins : int, optional
        Number of bins of equal width, 2 to 1000; by default 50, with 20 rows a bin at least.
    sheet : str
        Sheet of an Excel file, segment or group of an instrument file.

    Returns
    -------
    WinderLog
        Its ``problem`` contains the profiles of the log; :func:`woundon.fit` and
        :func:`woundon.compare` take it as measured values.

    Raises
    ------
    InvalidProblem
        For a file that cannot be read, without a radius or any quantity, or with several rolls.

    Examples
    --------
    >>> import numpy as np
    >>> import woundon as wo
    >>> rows = {"diameter [mm]": np.linspace(100, 1200, 5000),
    ...         "web_tension [N/m]": np.linspace(400, 320, 5000)}
    >>> log = wo.read_log(rows, wo.WindingProblem.example())
    >>> print(log.answer()[0])
    5000 rows in 50 bins over the radius; none left out
    >>> round(float(log.problem.web_tension.at(0.25)))
    371
    """
    check_type("problem", problem, Problem)
    known = {
        name: quantity
        for name, quantity in {**columns_of(problem), **measured_columns(problem)}.items()
        if quantity is not None
    }
    # a field that is a schedule is no column of numbers, but may be one of a log
    known |= schedule_fields(type(problem))
    known = {name: quantity for name, quantity in known.items() if name not in POSITIONS}
    result = read_binned(
        log,
        known,
        columns=columns,
        bins=bins,
        sheet=sheet,
        conversion=conversion_of(problem),
        limits=_limits(problem),
    )
    quantities = {name: known[name] for name in result.names}
    return WinderLog(bins=result, quantities=quantities, base=problem)


def _limits(problem: Problem) -> tuple[float, float] | None:
    """Return the radii of the core and of the finished roll [m]; None for a problem without."""
    values = {place.path: place.value for place in walk(problem)}
    core, surface = values.get("core.radius"), values.get("radius")
    if isinstance(core, float) and isinstance(surface, float):
        return core, surface
    return None


@dataclass(frozen=True, eq=False, repr=False)
class WinderLog(Outcome):
    """The log of a winder in bins over the radius; result of :func:`read_log`.

    Attributes
    ----------
    bins : BinnedLog
        Arrays over the k bins: ``radius`` and ``rows``, (k,); ``mean``, ``scatter`` and ``error``,
        (quantities, k).
    quantities : mapping of str to Quantity
        By name, in the order of the arrays.
    base : Problem
        The problem with whose names the log was read.

    Examples
    --------
    >>> import woundon as wo
    >>> rows = {"radius [m]": [0.1, 0.2, 0.3, 0.4], "nip_load [kN/m]": [2.0, 2.0, 3.0, 3.0]}
    >>> log = wo.read_log(rows, wo.WindingProblem.example(), bins=2)
    >>> float(log.profile("nip_load").at(0.25))
    2500.0
    """

    bins: BinnedLog
    quantities: Mapping[str, Quantity]
    base: Problem

    def profile(self, name: str) -> Profile:
        """Return the means of a quantity over the radius as a profile, SI.

        It reaches 2 % of the range of the radii beyond the log, along straight lines.

        Raises
        ------
        InvalidProblem
            If the log has no such quantity.
        """
        if name not in self.bins.names:
            text = f"{name!r} is not in the log; it has {', '.join(self.bins.names)}"
            raise InvalidProblem.at("name", text)
        radius, values = self.bins.profile(name)
        return Profile(radius=radius, value=values)

    @property
    def inputs(self) -> tuple[str, ...]:
        """The quantities that are schedules of the problem."""
        return tuple(name for name in self.bins.names if name in schedule_fields(type(self.base)))

    @property
    def problem(self) -> Problem:
        """The problem with the schedules of the log in place of its own."""
        return self.base.replace(**{name: self.profile(name) for name in self.inputs})

    def measured(self) -> pd.DataFrame:
        """Return the table of measured values for :func:`woundon.fit` and :func:`woundon.compare`.

        A row is a bin.  Outputs and inputs have the standard errors of their means; schedules of
        the problem are no columns, because they are fields of :attr:`problem`.  A bin of less than
        three rows has the scatter of the rows of the other bins as its error, and one of equal
        values their mean error; :meth:`remarks` counts these bins.

        Raises
        ------
        InvalidProblem
            If no quantity of the log is an output.
        """
        import pandas as pd

        outputs = [name for name in self.bins.names if name not in self.inputs]
        if not outputs:
            names = ", ".join(self.bins.names)
            text = f"has {names} only, which are inputs; its problem contains them"
            raise InvalidProblem.at(self.bins.where, text)
        measurable = measured_columns(self.base)
        place = "measured_radius" if "measured_radius" in measurable else "roll.radius"
        columns: dict[str, Array] = {place: self.bins.radius}
        for name in outputs:
            columns[name] = self.bins.mean[self.bins.names.index(name)]
            errors, _ = self._standard_errors(name)
            if errors is not None:
                columns[f"{name} +-"] = errors
        return pd.DataFrame(columns)

    def _standard_errors(self, name: str) -> tuple[Array | None, list[str]]:
        """Return the standard errors of the means, (k,), and remarks on those of other bins.

        The mean of one or two rows scatters at most as a row does, however they are correlated.
        The errors are None if no bin has one.
        """
        k = self.bins.names.index(name)
        mean, scatter, error = (
            each[k] for each in (self.bins.mean, self.bins.scatter, self.bins.error)
        )
        known = error > 0
        few, equal = np.isnan(error) & np.isfinite(mean), error == 0
        if not known.any():
            # the means of an input that never changes are exact
            exact = equal.any() and name not in measured_columns(self.base)
            text = f"{name}: no standard errors, so that all its means have the same weight"
            return None, [] if exact else [text]
        remarks = []
        if few.any():
            text = f"{name}: {_bins(few)} of less than 3 rows has the scatter of the rows of the "
            remarks.append(f"{text}others as its standard error")
        if equal.any():
            text = f"{name}: {_bins(equal)} of equal values has the mean standard error of the "
            remarks.append(f"{text}others")
        errors = np.where(few, _rms(scatter[known]), np.where(equal, _rms(error[known]), error))
        return errors, remarks

    def answer(self) -> list[str]:
        """Return what was done with the rows, and the range and scatter of each quantity."""
        lines = [self.bins.account()]
        for k, name in enumerate(self.bins.names):
            quantity = self.quantities[name]
            low, high = np.nanmin(self.bins.mean[k]), np.nanmax(self.bins.mean[k])
            scatter, error = _rms(self.bins.scatter[k]), _rms(self.bins.error[k])
            lines.append(
                f"{name}: {quantity.shown(low):.4g} to {quantity.text(high)}; scatter of the rows "
                f"{quantity.text(scatter)}, standard error of a mean {quantity.text(error)}"
            )
        return lines

    def remarks(self) -> list[str]:
        """Return what the reader left out or joined, and which means have other bins' errors."""
        outputs = [name for name in self.bins.names if name not in self.inputs]
        return [
            *self.bins.remarks,
            *(text for name in outputs for text in self._standard_errors(name)[1]),
        ]

    def to_dataframe(self) -> pd.DataFrame:
        """Return the bins as a table, SI units: radius, number of rows, means, scatter, errors."""
        import pandas as pd

        columns: dict[str, Array] = {"radius": self.bins.radius, "rows": self.bins.rows}
        for k, name in enumerate(self.bins.names):
            columns[name] = self.bins.mean[k]
            columns[f"{name} scatter"] = self.bins.scatter[k]
            columns[f"{name} +-"] = self.bins.error[k]
        return pd.DataFrame(columns)


def _rms(values: Array) -> float:
    """Return the root mean square of the values that are known; nan if none is."""
    known = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(known**2))) if known.size else nan


def _bins(chosen: Array) -> str:
    """Return the number of bins as a text: "1 bin", "each of 3 bins"."""
    count = int(np.count_nonzero(chosen))
    return "1 bin" if count == 1 else f"each of {count} bins"
