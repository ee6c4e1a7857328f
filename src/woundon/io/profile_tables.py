"""Thickness profiles from the tables of scanners: one scan or several, CSV or Excel."""

from __future__ import annotations

from os import PathLike
from pathlib import Path
from typing import NoReturn

import numpy as np

from ..arguments import check_type
from ..errors import InvalidProblem, one_of
from ..problems.inputs import is_basis_weight
from ..problems.thickness_profile import ThicknessProfile
from ..problems.units import parse
from ..quantities import Quantity, walk
from .columns import read_columns

__all__ = ["read_thickness_profile"]

FIELDS = ("position", "thickness", "slack")
RELATIVE = ("thickness", "spread")  # to the mean, if the thickness is a basis weight
WEIGHT = "kg/m^2"  # unit of a basis weight


def read_thickness_profile(path: str | PathLike[str]) -> ThicknessProfile:
    r"""Return the profile in a table with the columns ``position`` and ``thickness``.

    The headers have units, ``position [mm]``, ``thickness [um]`` or ``thickness [gsm]``; the latter
    is a basis weight, of which only the variation is used: the thickness and its spread are then
    relative to the mean over the width.  A column ``slack [%]`` is optional.
    Positions that occur in several rows, as in a list of several scans, have the mean thickness of
    these rows; their sample standard deviation, with n - 1, is ``spread``.

    Parameters
    ----------
    path : path
        CSV or Excel file.

    Raises
    ------
    InvalidProblem
        For a file that is not such a table, with the row; for scans that do not all have the same
        positions; for a profile that is not admissible.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import woundon as wo
    >>> scans = "position [mm], thickness [um]\n0, 66\n500, 66.4\n0, 66.2\n500, 66.2\n"
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = pathlib.Path(folder) / "scans.csv"
    ...     _ = file.write_text(scans)
    ...     profile = wo.read_thickness_profile(file)
    >>> [round(1e6 * h, 3) for h in profile.thickness], [round(1e6 * s, 3) for s in profile.spread]
    ([66.1, 66.3], [0.141, 0.141])
    """
    check_type("path", path, str, PathLike)
    known = {
        place.path: place.quantity
        for place in walk(ThicknessProfile)
        if place.path in FIELDS and place.quantity is not None
    }
    columns = read_columns(Path(path), known)
    is_weight = any(map(is_basis_weight, columns.get("thickness", ())))
    units = {name: quantity.unit for name, quantity in known.items()}
    units |= {"thickness": WEIGHT} if is_weight else {}
    values = {
        name: np.array([parse(cell, units[name], f"{path}: {name}") for cell in cells])
        for name, cells in columns.items()
    }
    missing = [name for name in ("position", "thickness") if name not in values]
    if missing:
        text = f"has no column {one_of(missing, 'or')}; must have position and thickness"
        raise InvalidProblem.at(str(path), text)
    position, scan = np.unique(values["position"], return_inverse=True)
    counts = np.bincount(scan)
    means = {
        name: np.bincount(scan, cells) / counts
        for name, cells in values.items()
        if name != "position"
    }
    if counts.max() > counts.min():
        _raise_missing(Path(path), known["position"], position, counts)
    if counts.max() > 1:
        squares = np.bincount(scan, (values["thickness"] - means["thickness"][scan]) ** 2)
        means["spread"] = np.sqrt(squares / (counts - 1))
    # with one scan the order of the rows is kept, so that the profile rejects an unsorted one
    places = position if counts.max() > 1 else values["position"]
    ordered = means if counts.max() > 1 else {name: values[name] for name in means}
    lists = {name: cells.tolist() for name, cells in {"position": places, **ordered}.items()}
    try:
        profile = ThicknessProfile(**lists)
    except InvalidProblem as fault:
        raise InvalidProblem((f"{path}: {field}", text) for field, text in fault.faults) from None
    if not is_weight:
        return profile
    relative = {name: ordered[name] / profile.mean for name in RELATIVE if name in ordered}
    return profile.replace(**{name: cells.tolist() for name, cells in relative.items()})


def _raise_missing(
    path: Path, quantity: Quantity, position: np.ndarray, counts: np.ndarray
) -> NoReturn:
    """Reject scans with different positions: their mean would have steps that no scan has.

    Parameters
    ----------
    path : path
    quantity : Quantity
        Of the positions.
    position : (n,) array
        Different positions [m].
    counts : (n,) int array
        Number of rows of each; not all are equal.
    """
    least, most = (
        f"{quantity.text(position[k], '.6g')} is in {counts[k]} of the rows"
        for k in (int(counts.argmin()), int(counts.argmax()))
    )
    text = f"{least}, {most}; each scan must have the same positions"
    raise InvalidProblem.at(f"{path}: position", text)
