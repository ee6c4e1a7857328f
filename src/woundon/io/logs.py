"""Average the log of a winder over bins of the radius, with its scatter.

A log has a row for each instant: radius or diameter, web tension, nip load, speed.  Rows during a
stop, and rows whose radius is missing, outside of the roll or an isolated spike, are left out.  The
others are sorted into bins of equal width of the radius; of each bin the means are kept, with

    scatter          standard deviation of the rows about a straight line in the radius
    standard error   of the mean: the rows of the bin in the order of the log are divided into
                     batches; the standard deviation of the means of the batches, divided by the
                     square root of their number (method of batch means: successive rows of a log
                     are correlated)
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..arguments import whole_number
from ..errors import InvalidProblem, one_of
from ..quantities import Quantity, length, velocity
from ..quantities import tension as tension_quantity
from .cells import Conversion, numbers_by_name
from .sheets import TableSource
from .tables import Names, find_columns, missing_column

__all__ = ["MOST_BINS", "POSITIONS", "BinnedLog", "binned", "read_binned"]

Array = np.ndarray

# column of the radius or of the diameter -> its factor to a radius
POSITIONS = {"radius": 1.0, "measured_radius": 1.0, "measured_diameter": 0.5, "diameter": 0.5}
# quantities by which a stop is recognised, also if they are not used
MOVING: dict[str, Quantity] = {
    "web_tension": tension_quantity("T_in", "web tension"),
    "web_speed": velocity("speed of the web"),
}
# quantities that logs have, named first in the error of a log without any
USUAL = ("web_tension", "nip_load", "web_speed", "winding_force", "torque_split")
STOPPED = 0.05  # share of the median below which the web stands still
MOST_BINS, USUAL_BINS, ROWS_PER_BIN = 1000, 50, 20
BATCHES = 10  # of the rows of a bin
NEXT_ROLL = 0.3  # fall of the radius, as a share of its range, with which another roll begins
EXTENSION = 0.02  # of a profile at both ends, as a share of the range of the radius
OUTSIDE = 0.1  # of the build-up, that a radius with noise may lie outside of core and roll
# Rows on each side with whose medians a radius is compared: spikes of 3 rows at most.
NEIGHBOURS = 5
SPIKE = 1 / USUAL_BINS  # of the range of the radius: less shifts a row by one bin at most
NOISE = 10.0  # median deviations, 6.7 standard deviations: normal noise does not have them
END_ROWS = 50  # of a log whose first step, from any core, is less than NEXT_ROLL of the range
BLOCKS = 1000  # of rows, whose median radii are compared to find another roll


@dataclass(frozen=True, eq=False)
class BinnedLog:
    """A log of n rows and q quantities in k bins, SI units.

    Attributes
    ----------
    where : str
        The file.
    names : tuple of str
    radius : (k,) array
        Mean radius of each bin [m], rising.
    rows : (k,) int array
        Number of rows of each bin.
    mean, scatter, error : (q, k) arrays
        Mean, standard deviation of the rows and standard error of the mean; nan without values.
    raw_radius : (n,) array
    raw : (q, n) array
    is_used : (n,) bool array
        Rows that are in a bin.
    left_out : mapping of str to int
        Reason -> number of rows.
    remarks : tuple of str
        What the reader left out or joined.
    """

    where: str
    names: tuple[str, ...]
    radius: Array
    rows: Array
    mean: Array
    scatter: Array
    error: Array
    raw_radius: Array
    raw: Array
    is_used: Array
    left_out: Mapping[str, int]
    remarks: tuple[str, ...] = ()

    def profile(self, name: str) -> tuple[Array, Array]:
        """Return radii [m] and values of a quantity that cover the roll, (j,) arrays.

        The means of the bins are extrapolated along straight lines to the ends of the log, and 2 %
        of its range of radii beyond them, because radii are noisy and logs begin a little late.
        """
        means = self.mean[self.names.index(name)]
        known = np.isfinite(means)
        r, values = self.radius[known], means[known]
        if r.size < 2:
            text = f"has {name} in one bin only; must have values at different radii"
            raise InvalidProblem.at(self.where, text)
        used = self.raw_radius[self.is_used]
        low, high = float(used.min()), float(used.max())
        margin = EXTENSION * (high - low)
        ends = np.array([max(low - margin, low / 2), high + margin])
        slopes = (
            np.diff(values[[0, 1]]) / np.diff(r[[0, 1]]),
            np.diff(values[-2:]) / np.diff(r[-2:]),
        )
        first = values[0] + slopes[0] * (ends[0] - r[0])
        last = values[-1] + slopes[1] * (ends[1] - r[-1])
        return np.r_[ends[0], r, ends[1]], np.r_[first, values, last]

    def account(self) -> str:
        """Return what was done with the rows, in one sentence."""
        text = f"{self.raw_radius.size} rows in {self.radius.size} bins over the radius"
        left_out = _counted(self.left_out)
        return f"{text}; left out: {left_out}" if left_out else f"{text}; none left out"


def read_binned(
    data: TableSource,
    fields: Mapping[str, Quantity],
    *,
    columns: Mapping[str, str | None] | None = None,
    bins: int | None = None,
    sheet: str = "",
    conversion: Conversion = Conversion(),  # noqa: B008
    limits: tuple[float, float] | None = None,
) -> BinnedLog:
    """Read a log and average it over the radius.

    Parameters
    ----------
    data : path, mapping or pandas.DataFrame
        As of :func:`~.sheets.find_table`.
    fields : mapping of str to Quantity
        Quantities that are read; other columns are ignored.
    columns : mapping
        Header -> name, with or without unit; None omits a column.
    bins : int, optional
        Number of bins of equal width, 2 to 1000; by default 50, with 20 rows a bin at least.
    sheet : str
        Name of a sheet.
    conversion : Conversion
        Width and thickness with which totals and stresses are converted.
    limits : (float, float), optional
        Radii of core and finished roll [m], outside of which a radius is an error of the sensor.

    Raises
    ------
    InvalidProblem
        If the file has no radius, none of the quantities, or the rows of several rolls.
    """
    if bins is not None:
        bins = whole_number("bins", bins, 2, MOST_BINS)
    positions = dict.fromkeys(POSITIONS, length("r", "radius of the roll"))
    names = Names({**MOVING, **fields, **positions})
    table, matched = find_columns(data, "log", names, columns, sheet)
    found = [column.name for column in matched]
    places = [name for name in found if name in POSITIONS]
    used = [name for name in found if name in fields and name not in POSITIONS]
    if len(places) != 1:
        text = f"has {one_of(places, 'and')}; must have one" if places else "has none"
        needed = f"needs a column of the radius or the diameter, and {text}"
        raise InvalidProblem.at(table.where, f"{needed}; its columns are {table.headers}")
    if not used:
        usual = [name for name in USUAL if name in fields]
        names_of_fields = list(dict.fromkeys([*usual, *fields]))[:8]
        raise missing_column(table, f"of {one_of(names_of_fields)}")
    by_name = numbers_by_name(table, matched, names, gaps=True, conversion=conversion)
    radius = POSITIONS[places[0]] * by_name[places[0]]
    moving = [by_name[name] for name in MOVING if name in by_name]
    raw = np.array([by_name[name] for name in used])
    return binned(radius, raw, used, moving, bins, table.where, table.remarks, limits)


def binned(
    radius: Array,
    raw: Array,
    names: Sequence[str],
    moving: Sequence[Array],
    bins: int | None,
    where: str = "log",
    remarks: tuple[str, ...] = (),
    limits: tuple[float, float] | None = None,
) -> BinnedLog:
    """Average the rows of a log over bins of the radius.

    Parameters
    ----------
    radius : (n,) array
        [m], in the order of the log; nan where it is missing.
    raw : (q, n) array
        Values; nan where they are missing.
    names : sequence of str
        Of the q quantities.
    moving : sequence of (n,) arrays
        Quantities that are zero during a stop.
    bins, limits : optional
        As of :func:`read_binned`.
    where, remarks
        As of :class:`BinnedLog`.

    Raises
    ------
    InvalidProblem
        If fewer than 4 rows are left, or the log has several rolls.

    Examples
    --------
    >>> radius = np.linspace(0.1, 0.5, 1000)
    >>> log = binned(radius, 300.0 + 0 * radius[None, :], ["web_tension"], [], bins=4)
    >>> log.radius.round(2), log.mean[0]
    (array([0.15, 0.25, 0.35, 0.45]), array([300., 300., 300., 300.]))
    """
    is_used, left_out = _used_rows(radius, raw, moving, limits)
    r, values = radius[is_used], raw[:, is_used]
    if r.size < 4 or r.max() <= r.min():
        text = f"has {r.size} rows with a radius and a value; must have at least 4"
        reasons = f"; left out: {_counted(left_out)}" if left_out else ""
        raise InvalidProblem.at(where, f"{text}, at different radii{reasons}")
    _check_one_roll(r, np.flatnonzero(is_used), where)
    count = bins or int(np.clip(r.size // ROWS_PER_BIN, 2, USUAL_BINS))
    bin_of_row = np.minimum((count * (r - r.min()) / (r.max() - r.min())).astype(int), count - 1)
    # empty bins are left out
    _, bin_of_row, rows = np.unique(bin_of_row, return_inverse=True, return_counts=True)
    statistics = [_statistics(r, each, bin_of_row, rows.size) for each in values]
    mean, scatter, error = (np.array(each) for each in zip(*statistics, strict=True))
    return BinnedLog(
        where=where,
        names=tuple(names),
        radius=np.bincount(bin_of_row, r) / rows,
        rows=rows,
        mean=mean,
        scatter=scatter,
        error=error,
        raw_radius=radius,
        raw=raw,
        is_used=is_used,
        left_out=left_out,
        remarks=remarks,
    )


def _used_rows(
    radius: Array,
    raw: Array,
    moving: Sequence[Array],
    limits: tuple[float, float] | None,
) -> tuple[Array, dict[str, int]]:
    """Return which rows of a log are used, (n,) bool array, and the number left out by reason.

    Parameters as of :func:`binned`.
    """
    left_out: dict[str, int] = {}
    is_used = np.ones(radius.size, dtype=bool)

    def leave_out(reason: str, rows: Array) -> None:
        """Take rows out that are still used, and count them."""
        if count := int(np.count_nonzero(rows & is_used)):
            left_out[reason] = left_out.get(reason, 0) + count
        is_used[rows] = False

    leave_out("no radius", ~(radius > 0))
    leave_out("no value", np.isnan(raw).all(axis=0))
    for values in moving:
        known = values[is_used & (values > 0)]
        if known.size:
            with np.errstate(invalid="ignore"):
                stands = values <= STOPPED * np.median(known)
            leave_out("the web stands still", stands)
    if limits is not None:
        core, surface = limits
        tolerance = OUTSIDE * (surface - core)
        outside = (radius < core - tolerance) | (radius > surface + tolerance)
        leave_out("radius outside of core and roll", outside)
    spikes = np.zeros(radius.size, dtype=bool)
    spikes[is_used] = _spikes(radius[is_used])
    leave_out("radius jumps to and fro", spikes)
    return is_used, left_out


def _counted(left_out: Mapping[str, int]) -> str:
    """Return the numbers of rows that were left out, with the reasons."""
    return ", ".join(f"{count} ({reason})" for reason, count in left_out.items())


def _spikes(r: Array) -> Array:
    """Return whether a radius lies beyond the rows before it and those after it, (n,) bool array.

    The radius of a row lies between the median of the rows before and that of the rows after it,
    except for noise.  The first and the last row, which have neighbours on one side only, are
    examined in a long log, in which no layer adds as much to the radius as a spike.

    Parameters
    ----------
    r : (n,) array
        Radii in the order of the log.

    Examples
    --------
    >>> radius = np.linspace(0.1, 0.5, 99)
    >>> radius[30] = 0.4
    >>> np.flatnonzero(_spikes(radius)).tolist()
    [30]
    """
    n = r.size
    if n < 4:  # too few for medians; the caller rejects such a log
        return np.zeros(n, dtype=bool)
    # medians[k] is that of the NEIGHBOURS rows before row k, medians[k + NEIGHBOURS + 1] that of
    # the rows after it
    padded = np.pad(r, NEIGHBOURS, mode="edge")
    medians = np.median(np.lib.stride_tricks.sliding_window_view(padded, NEIGHBOURS), axis=1)
    before, after = medians[:n], medians[NEIGHBOURS + 1 :]
    beyond = np.maximum(r - np.maximum(before, after), np.minimum(before, after) - r)
    noise = np.median(np.abs(r - (before + after) / 2))
    # range of the radius, of a long log without the ends, which may be wrong
    span = np.ptp(medians[NEIGHBOURS : n + 1] if n >= END_ROWS else medians)
    spikes = beyond > max(SPIKE * span, NOISE * noise)
    spikes &= np.abs(after - before) <= NEXT_ROLL * span  # the first rows of another roll are none
    if n >= END_ROWS:
        for end, other in ((0, after[0]), (-1, before[-1])):
            spikes[end] = abs(r[end] - other) > NEXT_ROLL * span
    return spikes


def _check_one_roll(r: Array, rows: Array, where: str) -> None:
    """Reject a log in which the radius falls back to that of the next core.

    Parameters
    ----------
    r : (n,) array
        Radii in the order of the log.
    rows : (n,) int array
        Their rows in the log, from 0.
    where : str
    """
    starts = np.linspace(0, r.size, min(BLOCKS, r.size) + 1).astype(int)[:-1]
    medians = np.array([np.median(block) for block in np.split(r, starts[1:])])
    falls = np.flatnonzero(np.diff(medians) < -NEXT_ROLL * np.ptp(r))
    if falls.size:
        row = 1 + int(rows[starts[falls[0] + 1]])
        text = f"has {1 + falls.size} rolls: the radius falls back near row {row} of the values"
        raise InvalidProblem.at(where, f"{text}; save the rows of one roll as a file")


def _statistics(r: Array, values: Array, bins: Array, k: int) -> tuple[Array, Array, Array]:
    """Return mean, scatter and standard error of the mean of each bin, (k,) arrays.

    Parameters
    ----------
    r, values : (n,) arrays
        Radius, and values in the order of the log; nan where they are missing.
    bins : (n,) int array
        Number of the bin of each row.
    k : int
        Number of bins.
    """
    known = np.isfinite(values)
    r, values, bins = r[known], values[known], bins[known]

    def sums(terms: Array | None = None) -> Array:
        """Return the sum of terms, or the number of rows, of each bin."""
        return np.bincount(bins, terms, k).astype(float)

    with np.errstate(divide="ignore", invalid="ignore"):  # bins without values
        count = sums()
        mean, centre = sums(values) / count, sums(r) / count
        x, y = r - centre[bins], values - mean[bins]
        spread = sums(x * x)
        slope = np.where(spread > 0, sums(x * y) / spread, 0.0)
        residual = y - slope[bins] * x
        # the straight line has two parameters
        scatter = np.sqrt(sums(residual**2) / np.maximum(count - 2, 1))
        of_batches = _error_by_batch_means(residual, bins, count)
        error = np.where(count >= 2 * BATCHES, of_batches, scatter / np.sqrt(count))
    few = count < 3
    scatter[few] = np.nan
    return mean, scatter, np.where(few, np.nan, error)


def _error_by_batch_means(residual: Array, bins: Array, count: Array) -> Array:
    """Return the standard error of the mean of each bin by the method of batch means, (k,).

    It is not defined for bins of less than BATCHES rows.

    Parameters
    ----------
    residual, bins : (n,) arrays
        Differences from the straight line in the order of the log, and the bins of the rows.
    count : (k,) array
        Number of rows of each bin.
    """
    k = count.size
    order = np.argsort(bins, kind="stable")  # the rows of a bin remain in the order of the log
    firsts = np.concatenate([[0], np.cumsum(count)[:-1]])
    rank = np.empty(bins.size)
    rank[order] = np.arange(bins.size) - firsts[bins[order]]
    batch = BATCHES * bins + (BATCHES * rank / count[bins]).astype(int)
    size = np.bincount(batch, minlength=BATCHES * k)
    means = np.bincount(batch, residual, BATCHES * k) / size
    return np.asarray(np.std(means.reshape(k, BATCHES), axis=1, ddof=1) / np.sqrt(BATCHES))
