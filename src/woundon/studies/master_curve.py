"""Master curves: moduli over many decades of frequency from isotherms of a dynamic test."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from math import isfinite, nan
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np

from ..arguments import check_arguments, check_type
from ..errors import InvalidProblem
from ..io.cells import numbers_by_name
from ..io.files import check_ending, check_writable
from ..io.sheets import TableSource, read_sheet
from ..io.spreadsheets import write_csv
from ..io.tables import Column, Names, is_known_header, match_columns, missing_column
from ..problems.inputs import NotANumber, real_number
from ..problems.measured_moduli import WARNING_MISFIT, DynamicTest, frequency_quantity
from ..problems.messages import not_one_of, quote
from ..problems.superposition import (
    Isotherm,
    log_shift_at,
    superpose,
    wlf_shifts,
)
from ..problems.units import number_and_unit
from ..quantities import Quantity, header, pure, stress
from .outcome import Outcome

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["MasterCurve", "master_curve"]

Array = np.ndarray

TEMPERATURE = Quantity("T", "K", "temperature", "degC")
SHIFT = pure("log10 a", "shift of an isotherm")
COLUMNS = {
    "temperature": TEMPERATURE,
    "frequency": frequency_quantity("frequency"),
    "storage_modulus": stress("E'", "storage modulus", "MPa"),
    "loss_modulus": stress("E''", "loss modulus", "MPa"),
    "tan_delta": pure("tan delta", "loss over storage modulus"),
}
# Rows whose temperatures differ by less belong to one isotherm: an instrument holds a temperature
# within a few tenths of a kelvin, and isotherms are at least 3 K apart [K].
SAME_TEMPERATURE = 1.0
LEAST_ROWS = 3  # of an isotherm
# Zeros of the scales differ, so that a temperature, unlike a difference, is not converted.
SCALES = {"degC": "degC", "\N{DEGREE SIGN}C": "degC", "K": "K"}
UNCERTAIN = 0.1  # decades, standard error of a shift that is remarked on


@dataclass(frozen=True, eq=False, repr=False)
class MasterCurve(Outcome):
    """Isotherms shifted to one master curve.

    Attributes
    ----------
    reference_temperature : float
        T_ref at which the moduli hold, in the scale of the isotherms.
    temperatures : (m,) array
        Of the isotherms, rising.
    shifts, errors : (m,) arrays
        log10 a(T) relative to T_ref, and their standard errors.  An isotherm measured at f gives
        the moduli at a f and T_ref.
    frequency, storage_modulus, loss_modulus : (n,) arrays
        a f [Hz], E' and E'' [Pa] of all points, frequencies rising.
    isotherm : (n,) int array
        Index of the isotherm of each point.
    misfit : float
        Root mean square of the relative residuals of the Prony series that follows all points [1].
    wlf : (C1, C2), optional
        Constants of the law of Williams, Landel and Ferry at T_ref [1], [K]; None for free shifts.
    scale : {"degC", "K"}
        Of all temperatures; degC if they were plain numbers.

    Examples
    --------
    >>> import numpy as np
    >>> import woundon as wo
    >>> f = np.logspace(-1, 2, 13)
    >>> cold, warm = (
    ...     {"frequency": f, "storage_modulus": 1e7 * (a * f) ** 0.2, "tan_delta": 13 * [0.325]}
    ...     for a in (10.0, 1.0)
    ... )
    >>> curve = wo.master_curve({20: cold, 40: warm}, 40)
    >>> cover = curve.material(poissons_ratio=0.48)
    >>> round(float(curve.shifts[0]), 1), round(cover.frequency[-1] / 1e3, 1)  # kHz
    (1.0, 1.0)
    """

    reference_temperature: float
    temperatures: Array
    shifts: Array
    errors: Array
    frequency: Array
    storage_modulus: Array
    loss_modulus: Array
    isotherm: Array
    misfit: float
    wlf: tuple[float, float] | None = None
    scale: str = "degC"

    def __repr__(self) -> str:
        low, high = self.frequency[[0, -1]]
        return (
            f"MasterCurve({self.temperatures.size} isotherms, {low:.3g} to {high:.3g} Hz at "
            f"{self.reference_temperature:g} {self.scale}, misfit {self.misfit:.2g})"
        )

    def material(self, poissons_ratio: float | str, **options: Any) -> DynamicTest:
        """Return the material of a cover at the reference temperature.

        Parameters
        ----------
        poissons_ratio : float
        **options
            Further fields of :class:`woundon.DynamicTest`, such as ``frequency_range``.

        Raises
        ------
        InvalidProblem
            If no Prony series follows the curve within 10 %.
        """
        return DynamicTest(
            frequency=self.frequency,
            storage_modulus=self.storage_modulus,
            loss_modulus=self.loss_modulus,
            poissons_ratio=poissons_ratio,
            **options,
        )

    def answer(self) -> list[str]:
        """Return the range of the curve with its misfit, then the shift of each isotherm."""
        low, high = self.frequency[[0, -1]]
        lines = [
            f"{low:.3g} to {high:.3g} Hz at {self.reference_temperature:g} {self.scale} from "
            f"{self.temperatures.size} isotherms; misfit {self.misfit:.2%} (rms)"
        ]
        if self.wlf is not None:
            C1, C2 = self.wlf
            lines.append(
                f"log10 a = -C1 (T - T_ref)/(C2 + T - T_ref): C1 = {C1:.4g}, C2 = {C2:.4g} K"
            )
        for k, T in enumerate(self.temperatures):
            shift = SHIFT.text(self.shifts[k] + 0.0, ".3f", error=self.errors[k])  # 0.0, not -0.0
            lines.append(f"T = {T:g} {self.scale}: log10 a = {shift}")
        return lines

    def remarks(self) -> list[str]:
        """Return what makes the curve doubtful."""
        found = []
        if self.misfit > WARNING_MISFIT:
            found.append(
                f"the shifted moduli deviate from any Prony series by {self.misfit:.1%} (rms): the "
                "material has several kinds of relaxation, or the moduli change with the "
                "temperature, too (vertical shifts are not applied)"
            )
        uncertain = self.temperatures[self.errors > UNCERTAIN]
        if uncertain.size:
            found.append(
                f"the shifts at {', '.join(f'{T:g}' for T in uncertain)} {self.scale} are known to "
                f"more than {UNCERTAIN:g} decades only: measure over more decades, or at "
                "temperatures between"
            )
        if (np.diff(self.shifts) > 0).any():
            found.append("a hotter isotherm is shifted up: check the temperatures")
        return found

    def to_dataframe(self) -> pd.DataFrame:
        """Return the points of the curve, SI units: temperature, frequency a f, moduli."""
        import pandas as pd

        return pd.DataFrame(
            {
                "temperature": self.temperatures[self.isotherm],
                "frequency": self.frequency,
                "storage_modulus": self.storage_modulus,
                "loss_modulus": self.loss_modulus,
            }
        )

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the curve as the CSV table that ``csv =`` of a case file reads.

        Parameters
        ----------
        path : path
            ``.csv`` file.

        Raises
        ------
        InvalidProblem
            For another ending, and a folder that does not exist or cannot be written.
        """
        check_type("path", path, str, os.PathLike)
        check_ending(path, (".csv",))
        check_writable(Path(path))
        units = {"frequency": "Hz", "storage_modulus": "Pa", "loss_modulus": "Pa"}
        frame = self.to_dataframe()[list(units)]
        write_csv(Path(path), frame.rename(columns=lambda name: header(name, units[name])))

    def shift_at(self, temperature: float | Array) -> Array:
        """Return log10 a at temperatures in the range of the isotherms, by the law if there is one.

        Parameters
        ----------
        temperature : float or array
        """
        T = np.asarray(temperature, dtype=float)
        if self.wlf is not None:
            return wlf_shifts(*self.wlf, T - self.reference_temperature)
        flat = [log_shift_at(each, self.temperatures, self.shifts) for each in T.ravel().tolist()]
        return np.reshape(flat, T.shape)


def master_curve(
    isotherms: TableSource,
    reference_temperature: float | str,
    *,
    shifts: Literal["free", "wlf"] = "free",
    columns: Mapping[str, str | None] | None = None,
) -> MasterCurve:
    """Shift isotherms of a dynamic test to one master curve (time-temperature superposition).

    The shift factors a(T) are those for which one Prony series with positive terms follows the
    storage and loss moduli of all isotherms at the frequencies a f best.

    Parameters
    ----------
    isotherms : path, table, or mapping of temperature to path or table
        A table with the columns temperature, frequency, storage_modulus, and loss_modulus or
        tan_delta; or such a table without temperature for each temperature (20.0 or "20 degC").
        All temperatures are in degC, or all in K.  Rows of one table within 1 K are one isotherm.
    reference_temperature : float or str
        Temperature of the cover in the nip, within the range of the isotherms and in their scale.
    shifts : "free" or "wlf"
        Free factors, or those of the law of Williams, Landel and Ferry (three isotherms or more).
    columns : mapping, optional
        Header -> name [unit], as of :func:`woundon.fit`; ``{"*": None}`` ignores other columns.

    Returns
    -------
    MasterCurve

    Raises
    ------
    InvalidProblem
        For tables that cannot be read, temperatures in degF or of two scales, fewer than two
        isotherms, isotherms that do not overlap, or a reference outside their range.

    References
    ----------
    M. L. Williams, R. F. Landel, J. D. Ferry, J. Am. Chem. Soc. 77 (1955) 3701, eq. (19).

    Examples
    --------
    >>> import numpy as np
    >>> import woundon as wo
    >>> f = np.logspace(-1, 2, 13)
    >>> def isotherm(a):  # of E = 5 MPa + sum of terms from 1 ms to 10 s at 20 degC
    ...     w = 2j * np.pi * a * f[:, None] * np.logspace(-5, 1, 13)
    ...     E = 5e6 + 1e6 * (w / (1 + w)).sum(axis=1)
    ...     return {"frequency": f, "storage_modulus": E.real, "loss_modulus": E.imag}
    >>> curve = wo.master_curve({20: isotherm(1.0), 40: isotherm(0.1), 60: isotherm(0.02)}, 20)
    >>> [round(float(shift), 1) for shift in curve.shifts]
    [0.0, -1.0, -1.7]
    """
    check_arguments(columns=columns)
    if shifts not in ("free", "wlf"):
        raise InvalidProblem.at("shifts", not_one_of(shifts, ("free", "wlf")))
    reference, scale = _temperature(reference_temperature, "reference_temperature")
    known, scale = _isotherms(isotherms, columns or {}, scale)
    least = 3 if shifts == "wlf" else 2
    if len(known) < least:
        text = f"{len(known)} given; must be at least {least} with shifts = {quote(shifts)}"
        raise InvalidProblem.at("isotherms", text)
    T = np.array([each.temperature for each in known])
    if not T[0] - SAME_TEMPERATURE <= reference <= T[-1] + SAME_TEMPERATURE:
        text = f"{reference:g} is out of range; must be >= {T[0]:g} and <= {T[-1]:g}, as measured"
        raise InvalidProblem.at("reference_temperature", text)
    found = superpose(known, reference, wlf=shifts == "wlf")
    wlf = found.wlf and found.wlf[:2]
    if wlf is None:
        at_reference = log_shift_at(float(np.clip(reference, T[0], T[-1])), T, found.shift)
        shift = found.shift - at_reference
    else:
        shift = wlf_shifts(*wlf, T - reference)
    reduced = np.concatenate(
        [10.0**x * each.frequency for x, each in zip(shift, known, strict=True)]
    )
    order = np.argsort(reduced, kind="stable")
    isotherm = np.repeat(np.arange(len(known)), [each.frequency.size for each in known])
    return MasterCurve(
        reference_temperature=reference,
        temperatures=T,
        shifts=shift,
        errors=_errors(found.covariance, T, reference),
        frequency=reduced[order],
        storage_modulus=np.concatenate([each.storage for each in known])[order],
        loss_modulus=np.concatenate([each.loss for each in known])[order],
        isotherm=isotherm[order],
        misfit=found.fit.misfit,
        wlf=wlf,
        scale=scale,
    )


def _errors(covariance: Array, temperatures: Array, reference: float) -> Array:
    """Return the standard errors of shifts relative to that at the reference temperature, (m,).

    That shift is interpolated linearly between the neighbouring isotherms.  ``covariance``, (m, m),
    is that of the shifts at ``temperatures``, (m,).
    """
    identity = np.eye(temperatures.size)
    weights = [np.interp(reference, temperatures, row) for row in identity]
    difference = identity - np.array(weights)
    variance = np.einsum("ki,ij,kj->k", difference, covariance, difference)
    return np.sqrt(np.maximum(variance, 0.0))


# ---- tables -------------------------------------------------------------------------------------


class _Rows(NamedTuple):
    """The columns of a table in SI, (n,) each; temperature None where the table has none.

    Temperatures are in one of ``scales``.
    """

    temperature: Array | None
    frequency: Array
    storage: Array
    loss: Array
    where: str
    scales: set[str]


def _isotherms(
    tables: Any, columns: Mapping[str, str | None], scale: str
) -> tuple[list[Isotherm], str]:
    """Return the isotherms of one table, or of a table for each temperature, and their scale.

    The coldest is the first.  ``scale`` is that of the reference temperature, empty if it is a
    plain number.
    """
    found: list[Isotherm] = []
    if _is_by_temperature(tables):
        scales = {scale}
        for key, table in tables.items():
            T, own = _temperature(key, "isotherms")
            scales.add(own)
            rows = _read(table, f"isotherms[{T:g}]", columns)
            if T in [each.temperature for each in found]:
                text = f"{T:g} is given twice; must be different temperatures"
                raise InvalidProblem.at("isotherms", text)
            found.append(_isotherm(T, rows, np.arange(rows.frequency.size)))
        scale = _common_scale(scales, "isotherms")
    else:
        rows = _read(tables, "isotherms", columns)
        if rows.temperature is None:
            raise InvalidProblem.at(rows.where, "has no column temperature; must have one [degC]")
        scale = _common_scale({scale, *rows.scales}, rows.where)
        # a new isotherm begins where sorted temperatures differ by more than the control's scatter
        order = np.argsort(rows.temperature, kind="stable")
        steps = np.diff(rows.temperature[order]) > SAME_TEMPERATURE
        groups = np.split(order, np.flatnonzero(steps) + 1)
        found = [_isotherm(float(rows.temperature[k].mean()), rows, k) for k in groups]
    return sorted(found, key=lambda each: each.temperature), scale


def _is_by_temperature(tables: Any) -> bool:
    """Return True for a mapping of temperatures to tables, False for one table.

    The keys of a table with columns in memory are headers, which do not begin with a number, and
    its values are no tables or paths.
    """
    if not isinstance(tables, Mapping):
        return False
    return any(
        not isinstance(key, str)
        or number_and_unit(key) is not None
        or isinstance(value, (Mapping, str, os.PathLike))
        or hasattr(value, "columns")  # pandas.DataFrame
        for key, value in tables.items()
    )


def _temperature(value: Any, field: str) -> tuple[float, str]:
    """Return a temperature with its scale, "degC", "K", or "" of a plain number.

    Raises
    ------
    InvalidProblem
        If it is not a number, or in another scale.
    """
    number, unit = value, ""
    if isinstance(value, str) and (parts := number_and_unit(value)):
        number, unit = float(parts[0]), parts[1]
        if unit not in SCALES:
            reason = f"is in {unit}" if unit else "has no unit"
            raise InvalidProblem.at(field, f"{quote(value)} {reason}; {_MUST}")
    try:
        temperature = real_number(number)
    except NotANumber:
        temperature = nan
    if not isfinite(temperature):
        raise InvalidProblem.at(field, f"{quote(value)} is not a temperature; {_MUST}")
    return temperature, SCALES.get(unit, "")


_MUST = "must be in degC or K, e.g. 40.0 or '40 degC'"


def _common_scale(scales: Iterable[str], where: str) -> str:
    """Return the scale of all temperatures; "" is that of plain numbers, which are in degC alone.

    Raises
    ------
    InvalidProblem
        For temperatures of several scales.
    """
    named = sorted({*scales} - {""})
    if len(named) > 1:
        text = f"temperatures are in {' and '.join(named)}; must be in one scale, with the "
        raise InvalidProblem.at(where, f"{text}reference_temperature")
    return named[0] if named else "degC"


def _scales_of(column: Column, where: str) -> set[str]:
    """Return the scales of the cells of a column of temperatures."""
    field = f"{where}: column {column.header!r}"
    scales = {_temperature(f"0 {column.unit}", field)[1]} if column.unit else set()
    for cell in column.cells:
        if isinstance(cell, str) and cell.strip()[-1:].isalpha():  # with its own unit
            scales.add(_temperature(cell.replace(",", "."), field)[1])
    return scales


def _read(table: TableSource, where: str, columns: Mapping[str, str | None]) -> _Rows:
    """Return the columns of a table; loss moduli from tan delta where it has only these.

    ``where`` names columns in memory in error messages.
    """
    names = Names(COLUMNS)
    sheet = read_sheet(table, where, is_known_header(names, columns))
    matched = match_columns(sheet, names, columns)
    scales: set[str] = set()
    for column in matched:
        if column.name == "temperature":
            scales |= _scales_of(column, sheet.where)
    values = numbers_by_name(sheet, matched, names, gaps=False)
    missing = [name for name in ("frequency", "storage_modulus") if name not in values]
    if "loss_modulus" not in values and "tan_delta" not in values:
        missing.append("loss_modulus or tan_delta")
    if missing:
        raise missing_column(sheet, ", ".join(missing))
    for name in ("frequency", "storage_modulus", "loss_modulus", "tan_delta"):
        if name in values and not (values[name] > 0).all():
            row = sheet.numbers[int((~(values[name] > 0)).argmax())]
            raise InvalidProblem.at(sheet.where, f"row {row}: {name} must be > 0")
    storage, loss = values["storage_modulus"], values.get("loss_modulus")
    if loss is None:
        loss = values["tan_delta"] * storage
    return _Rows(values.get("temperature"), values["frequency"], storage, loss, sheet.where, scales)


def _isotherm(temperature: float, rows: _Rows, index: Array) -> Isotherm:
    """Return the isotherm of the rows ``index``, (k,) int, of a table.

    Raises
    ------
    InvalidProblem
        For too few rows, and frequencies that are measured twice.
    """
    index = index[np.argsort(rows.frequency[index], kind="stable")]
    f = rows.frequency[index]
    if f.size < LEAST_ROWS or (np.diff(f) <= 0).any():
        reason = f"{f.size} rows" if f.size < LEAST_ROWS else "a frequency that is measured twice"
        text = (
            f"the isotherm at {temperature:g} has {reason}; must have at least {LEAST_ROWS} rows "
        )
        text += f"of different frequencies; rows within {SAME_TEMPERATURE:g} K are one isotherm"
        raise InvalidProblem.at(rows.where, text)
    return Isotherm(temperature, f, rows.storage[index], rows.loss[index])
