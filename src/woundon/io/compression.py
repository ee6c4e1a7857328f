"""Read compression tests of a stack: pressure and strain, or load and deflection of a machine.

    P = (F - F_0)/A        pressure of a load F on the area A, with the offset F_0 of the load cell
    eps = delta/H          compressive strain of a deflection delta of a stack of height H

Compression may have either sign in the file.  The rows are divided into branches at the reversals
of the pressure; one branch is used, by default the one that rises to the largest pressure.  Rows
below the preload are left out, because the sheets of a stack are not flat in contact there.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ..errors import InvalidProblem, one_of
from ..problems.messages import quote
from ..problems.units import parse
from ..quantities import Quantity, length, strain, stress
from .cells import numbers_by_name
from .sheets import Sheet, TableSource
from .tables import Names, find_columns, missing_column

__all__ = ["Branch", "CompressionTest", "branches_of", "read_compression_test", "rising_means"]

Array = np.ndarray

COLUMNS: dict[str, Quantity] = {
    "pressure": stress("P", "pressure on the stack"),
    "strain": strain("eps", "compressive strain of the stack"),
    "force": Quantity("F", "N", "load on the stack"),
    "deflection": length("delta", "deflection of the stack"),
}
REVERSAL = 0.05  # change of the pressure that ends a branch, as a share of its range
BLOCKS = 200  # of successive rows, whose means are searched for reversals
NOISES, FEW_ROWS = 8.0, 20  # standard deviations of the noise; rows without an estimate of it
PRELOAD = 0.01  # default, as a share of the largest pressure
SAME_PEAK = 0.98  # of the largest pressure: branches with such a peak rise to the largest one
MOST_ROWS = 1_000_000
MEANS, ROWS_PER_MEAN = 60, 4  # of a list of means
# Of a stack [m^2], [m], from a few sheets under a probe to a bale; others are errors of units.
AREAS, HEIGHTS = (1e-6, 10.0), (1e-4, 10.0)


class Branch(NamedTuple):
    """Successive rows in which the pressure rises or falls.

    Attributes
    ----------
    start, end : int
        The first row, and that behind the last one, from 0.
    rises : bool
    """

    start: int
    end: int
    rises: bool

    def in_words(self, rows: Sequence[int]) -> str:
        """Return the kind of the branch with its row numbers."""
        kind = "loading" if self.rises else "unloading"
        return f"{kind} in rows {rows[self.start]} to {rows[self.end - 1]}"


@dataclass(frozen=True, eq=False)
class CompressionTest:
    """The n rows of a compression test, SI units.

    Attributes
    ----------
    where : str
    pressure, strain : (n,) arrays
        Compression is positive; the origin of the strain is arbitrary.
    is_used : (n,) bool array
    account : tuple of str
        Which rows are used, and which are not.
    """

    where: str
    pressure: Array
    strain: Array
    is_used: Array
    account: tuple[str, ...]

    @property
    def used(self) -> tuple[Array, Array]:
        """Pressure and strain of the rows that are used."""
        return self.pressure[self.is_used], self.strain[self.is_used]


def read_compression_test(
    data: TableSource,
    *,
    area: float | str | None = None,
    height: float | str | None = None,
    offset: float | str = 0.0,
    preload: float | str | None = None,
    branch: str | int = "loading",
    columns: Mapping[str, str | None] | None = None,
    sheet: str = "",
) -> CompressionTest:
    """Read a compression test; parameters as of :func:`woundon.fit_stack`.

    Raises
    ------
    InvalidProblem
        If the table has not the columns, area or height are missing for them or out of range, or a
        strain is not < 1.

    Examples
    --------
    >>> table = {"Load [N]": [10.0, 100.0, 400.0, 900.0], "Weg [mm]": [0.0, 0.4, 0.7, 0.9]}
    >>> test = read_compression_test(table, area="100 cm^2", height="20 mm")
    >>> test.pressure, test.strain
    (array([ 1000., 10000., 40000., 90000.]), array([0.   , 0.02 , 0.035, 0.045]))
    """
    names = Names(COLUMNS)
    table, matched = find_columns(data, "test", names, columns, sheet)
    if len(table.numbers) > MOST_ROWS:
        raise InvalidProblem.at(table.where, f"has too many rows; must be at most {MOST_ROWS}")
    values = numbers_by_name(table, matched, names, gaps=True)
    P = _pressure(values, area, offset, table)
    eps = _strain(values, height, table)
    known = np.isfinite(P) & np.isfinite(eps)
    rows, P, eps = np.array(table.numbers)[known], P[known], eps[known]
    account = [*table.remarks]
    if not known.all():
        account.append(f"{np.count_nonzero(~known)} rows with an empty cell are not used")
    if P.size < 4 or np.ptp(P) == 0:
        text = f"has {P.size} rows with pressure and strain; must have at least 4, of different "
        raise InvalidProblem.at(table.where, f"{text}pressures")
    if abs(P.min()) > P.max():
        P = -P
        account.append("compression is negative in the file; the sign of the load is reversed")
    parts = branches_of(P)
    part = _chosen(parts, P, branch, rows.tolist(), table.where)
    inner = slice(part.start, part.end)
    if np.polyfit(P[inner], eps[inner], 1)[0] < 0:
        eps = -eps
        account.append("the sign of the deflection is reversed, so that it rises with the load")
    if preload is not None:
        least = _in_si(preload, "Pa", "preload")
    else:  # a table whose rows all rise is a curve without noise
        is_curve = bool(np.all(np.diff(P) > 0) and np.all(np.diff(eps) > 0))
        least = 0.0 if is_curve else PRELOAD * float(P.max())
    in_branch = np.zeros(P.size, dtype=bool)
    in_branch[inner] = True
    is_used = in_branch & (least <= P) & (P >= 0)
    account.append(f"used: {part.in_words(rows.tolist())}")
    others = [each.in_words(rows.tolist()) for each in parts if each is not part]
    if others:
        account.append(f"not used: {'; '.join(others[:5])}{'; ...' if len(others) > 5 else ''}")
    below = int(np.count_nonzero(in_branch & ~is_used))
    if below:
        account.append(f"{below} rows of the branch are below the preload of {least / 1e3:.4g} kPa")
    if is_used.sum() < 4:
        text = f"has {is_used.sum()} rows of the branch above the preload of {least:.4g} [Pa]"
        raise InvalidProblem.at(table.where, f"{text}; must have at least 4")
    _check_strains(eps[is_used], rows[is_used], values, table.where)
    return CompressionTest(table.where, P, eps, is_used, tuple(account))


def _pressure(
    values: Mapping[str, Array], area: float | str | None, offset: float | str, table: Sheet
) -> Array:
    """Return the pressure of each row, without the offset of the load, (n,) [Pa].

    ``values`` are the columns of the file; other parameters as of :func:`woundon.fit_stack`.
    """
    if "pressure" in values:
        if area is not None:
            text = "is given, but the file has a column of the pressure; must be omitted"
            raise InvalidProblem.at("area", text)
        return values["pressure"] - _in_si(offset, "Pa", "offset")
    if "force" not in values:
        raise _missing("pressure", "force", table)
    if area is None:
        raise InvalidProblem.at("area", "missing; the load needs the area of the stack, '100 cm^2'")
    return (values["force"] - _in_si(offset, "N", "offset")) / _in_si(area, "m^2", "area", AREAS)


def _strain(values: Mapping[str, Array], height: float | str | None, table: Sheet) -> Array:
    """Return the strain of each row, (n,) [1]; parameters as of :func:`_pressure`."""
    if "strain" in values:
        if height is not None:
            text = "is given, but the file has a column of the strain; must be omitted"
            raise InvalidProblem.at("height", text)
        return values["strain"]
    if "deflection" not in values:
        raise _missing("strain", "deflection", table)
    if height is None:
        text = "missing; the deflection needs the height of the stack without load, '20 mm'"
        raise InvalidProblem.at("height", text)
    return values["deflection"] / _in_si(height, "m", "height", HEIGHTS)


def _missing(name: str, other: str, table: Sheet) -> InvalidProblem:
    """Return the error for a test without a column of the pressure, or of the strain."""
    example = f"assign one, as in --column 'HEADER={other} [{COLUMNS[other].display}]'"
    return missing_column(table, f"{name} or {other}", f"{example}. {table.origin}".rstrip(". "))


def _in_si(
    value: float | str, unit: str, name: str, limits: tuple[float, float] | None = None
) -> float:
    """Return a value in SI; reject one that is not finite, or not within limits."""
    number = parse(value, unit, name)
    low, high = limits or (-np.inf, np.inf)
    if not np.isfinite(number) or not low <= number <= high:
        permitted = f">= {low:g} and <= {high:g} [{unit}]" if limits else "finite"
        raise InvalidProblem.at(name, f"{quote(value)} is out of range; must be {permitted}")
    return number


def _check_strains(eps: Array, rows: Array, values: Mapping[str, Array], where: str) -> None:
    """Reject strains of a stack that has no thickness left.

    Parameters
    ----------
    eps, rows : (n,) arrays
        Strains that are used, and their rows.
    values : mapping of str to array
        Columns of the file.
    where : str
    """
    worst = int(np.argmax(eps))
    fault, limit = f"strain {quote(eps[worst])}", "< 1"
    if eps[worst] < 1 and np.ptp(eps) < 1:
        return
    if eps[worst] < 1:  # they begin far below 0, and their origin is arbitrary
        fault, limit = (
            f"strains from {quote(eps.min())} to {quote(eps.max())}",
            "within a range < 1",
        )
    if "strain" in values:
        reason = "strains in percent need their unit, '%'; or the columns are swapped"
    else:
        reason = "check the units of deflection and height, whether columns are swapped, and "
        reason += "whether the deflection begins near 0"
    text = f"row {rows[worst]}: {fault} is out of range; must be {limit}, at which the stack has "
    raise InvalidProblem.at(where, f"{text}no thickness left; {reason}")


def branches_of(P: Array) -> list[Branch]:
    """Return the branches of a test: the rows between the reversals of the pressure.

    A reversal is a change by 5 % of the range of the pressure, and by more than the noise, in the
    means of successive rows, at most 200.

    Examples
    --------
    >>> branches_of(np.array([0.0, 5.0, 10.0, 5.0, 0.0]))
    [Branch(start=0, end=3, rises=True), Branch(start=2, end=5, rises=False)]
    """
    blocks = np.linspace(0, P.size, min(BLOCKS, P.size) + 1).astype(int)
    means = np.add.reduceat(P, blocks[:-1]) / np.diff(blocks)
    changes = np.abs(np.diff(means, 2))
    # of a second difference of independent noise the standard deviation is 6^(1/2) times its own,
    # and 98 % of the absolute values are within 2.33 standard deviations
    noise = float(np.quantile(changes, 0.98)) / (2.33 * 6**0.5) if changes.size > FEW_ROWS else 0.0
    limit = min(max(REVERSAL * float(np.ptp(P)), NOISES * noise), 0.5 * float(np.ptp(P)))
    turns = [0]
    for block, is_maximum in _reversals(means, limit):
        near = slice(blocks[block - 1], blocks[min(block + 2, blocks.size - 1)])
        extreme = np.argmax(P[near]) if is_maximum else np.argmin(P[near])
        turns.append(int(near.start + extreme))
    turns = sorted({*turns, P.size - 1})
    return [Branch(start, end + 1, bool(P[end] > P[start])) for start, end in pairwise(turns)]


def _reversals(values: Array, limit: float) -> list[tuple[int, bool]]:
    """Return the extremes at which values turn and then change by more than ``limit``.

    Returns
    -------
    list of (int, bool)
        Number of the value, > 0, and whether it is a maximum.
    """
    turns: list[tuple[int, bool]] = []
    lowest = highest = 0  # numbers of the extremes since the last reversal
    rises: bool | None = None  # not known before the first change
    for k, value in enumerate(values.tolist()):
        lowest = k if value < values[lowest] else lowest
        highest = k if value > values[highest] else highest
        if rises is not False and values[highest] - value > limit:  # it falls again
            turns.append((highest, True))
            rises, lowest = False, k
        elif rises is not True and value - values[lowest] > limit:
            turns.append((lowest, False))
            rises, highest = True, k
    return [(number, is_maximum) for number, is_maximum in turns if number > 0]


def _chosen(
    parts: Sequence[Branch], P: Array, branch: str | int, rows: Sequence[int], where: str
) -> Branch:
    """Return the requested branch: by its number from 1, or the first one that rises to the peak.

    Parameters
    ----------
    parts : sequence of Branch
    P : (n,) array
        Pressure of the rows [Pa].
    branch : "loading", "unloading" or int
    rows : sequence of n int
        Their numbers in the file.
    where : str

    Raises
    ------
    InvalidProblem
        If there is no such branch; lists those of the test.
    """
    known = "; ".join(f"{k}: {each.in_words(rows)}" for k, each in enumerate(parts[:8], 1))
    if isinstance(branch, int) or branch.isdecimal():
        number = int(branch)
        if not 1 <= number <= len(parts):
            text = f"{number} is out of range; must be >= 1 and <= {len(parts)}: {known}"
            raise InvalidProblem.at("branch", text)
        return parts[number - 1]
    if branch not in ("loading", "unloading"):
        text = f"{quote(branch)} is unknown; must be {one_of(['loading', 'unloading'])} or a number"
        raise InvalidProblem.at("branch", f"{text}; {known}")
    rises = branch == "loading"
    candidates = [each for each in parts if each.rises == rises]
    if not candidates:
        raise InvalidProblem.at("branch", f"{where} has no {branch} branch; it has {known}")
    peaks = [float(P[each.start : each.end].max()) for each in candidates]
    return next(
        each for each, peak in zip(candidates, peaks, strict=True) if peak >= SAME_PEAK * max(peaks)
    )


def rising_means(P: Array, eps: Array) -> tuple[Array, Array]:
    """Return rows of a test as rising pressures and strains: as they are, or their means.

    Rows that rise strictly are returned unchanged.  Others are sorted by the pressure and averaged
    in groups; groups whose strain does not rise are joined to the next one.

    Parameters
    ----------
    P, eps : (n,) arrays

    Returns
    -------
    pressure, strain : (k,) arrays
    """
    if np.all(np.diff(P) > 0) and np.all(np.diff(eps) > 0):
        return P, eps
    order = np.argsort(P, kind="stable")
    count = max(4, min(MEANS, P.size // ROWS_PER_MEAN))
    groups = [[group] for group in np.array_split(order, count)]
    joined: list[list[Array]] = []
    for group in groups:
        joined.append(group)
        while len(joined) > 1 and not _rises(joined[-2], joined[-1], P, eps):
            last = joined.pop()
            joined[-1] = joined[-1] + last
    rows = [np.concatenate(group) for group in joined]
    return np.array([P[k].mean() for k in rows]), np.array([eps[k].mean() for k in rows])


def _rises(lower: list[Array], upper: list[Array], P: Array, eps: Array) -> bool:
    """Return True if pressure and strain of a group of rows are above those of another one."""
    first, second = np.concatenate(lower), np.concatenate(upper)
    return bool(P[second].mean() > P[first].mean() and eps[second].mean() > eps[first].mean())
