"""The cases of the frozen set as objects, and what is kept of their results as plain numbers.

Arrays are kept as five numbers each: norm, sum, a sum with weights that tell every node from every
other, and both end values.
"""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from operator import attrgetter
from pathlib import Path
from typing import Any

import numpy as np

import woundon as wo

__all__ = ["MOMENTS", "Case", "Measured", "frozen_cases", "measured"]

Array = np.ndarray
Measured = dict[str, Any]  # quantity -> number, or the moments of an array

CASES = Path(__file__).parent / "frozen" / "cases.toml"
KINDS = ("nip", "wrap", "rollers", "sensitivity", "sweep", "fit")
MOMENTS = ("norm", "sum", "wave", "first", "last")

_OF_ANY = (
    "half_width", "nip_width", "approach", "offset", "peak_pressure", "iterations",
)  # fmt: skip
_OF_NIP = (
    *_OF_ANY, "nip_induced_tension", "tension_behind_nip", "drum_creep", "nodes", "series_terms",
    "series_error", "slip_ratios.leading_roll", "slip_ratios.trailing_roll", "slip_ratios.dual",
)  # fmt: skip
SCALARS = {
    "nip": (*_OF_NIP, "nip_induced_tension_error"),
    "wrap": (
        *_OF_NIP, "wound_on_tension", "wound_on_tension_error", "tension_before_nip",
        "roll_wrap_traction", "drum_wrap_traction", "slip_angle",
    ),
    "rollers": (*_OF_ANY, "creepage", "tangential_load", "traction_error"),
}  # fmt: skip
_ALONG_NIP = (
    "x", "slip_x", "pressure", "roll_traction", "drum_traction", "roll_slip", "drum_slip",
    "roll_zone", "drum_zone", "web_tension",
)  # fmt: skip
ARRAYS = {
    "nip": _ALONG_NIP,
    "wrap": (*_ALONG_NIP, "roll_pressure", "hoop_pressure", "curvature", "roll_strain"),
    "rollers": ("x", "pressure", "traction", "slip", "zone"),
}
FIT = (
    "estimates", "standard_errors", "covariance", "correlation", "rms", "direction", "condition",
    "effects", "joint_effect", "reached", "fitted",
)  # fmt: skip


@dataclass(frozen=True)
class Case:
    """One case as the file has it, and the objects it describes.

    Attributes
    ----------
    kind : str
        "nip", "wrap", "rollers", "sensitivity", "sweep" or "fit".
    number : int
        Among those of its kind, from 1.
    given : mapping
        Its table.
    described : mapping
        The file's named descriptions.
    """

    kind: str
    number: int
    given: Mapping[str, Any]
    described: Mapping[str, Any] = field(repr=False)

    @property
    def name(self) -> str:
        """Name among all cases."""
        return f"{self.kind} {self.number}: {self.given['name']}"

    def table(self, name: str) -> dict[str, Any]:
        """Return a table of the case, its values as objects; empty where it has none."""
        return {key: self._object(value) for key, value in self.given.get(name, {}).items()}

    @cached_property
    def problem(self) -> Any:
        """The problem, less any wrap."""
        return self._base.replace(**self.table("change"))

    @cached_property
    def _base(self) -> Any:
        base = self._object(self.given["base"])
        return base.replace(**dict.fromkeys(self.given.get("without", ())))

    def _object(self, value: Any) -> Any:
        """Make what a table or a name describes; all else stays."""
        if isinstance(value, list):
            return [self._object(item) for item in value]
        if isinstance(value, str) and value in self.described:
            return self._object(self.described[value])
        if isinstance(value, Mapping) and len(value) == 1:
            ((name, fields),) = value.items()
            if name[0].isupper():
                return getattr(wo, name)(**{k: self._object(v) for k, v in fields.items()})
        return value


def frozen_cases() -> list[Case]:
    """Return the cases."""
    tables = tomllib.loads(CASES.read_text("utf-8"))
    return [
        Case(kind, number, given, tables["described"])
        for kind in KINDS
        for number, given in enumerate(tables[kind], 1)
    ]


def measured(kind: str, result: Any) -> Measured:
    """Return the numbers of a solved case; a quantity that the result has not is left out."""
    if kind == "sensitivity":
        return _of_sensitivity(result)
    if kind == "sweep":
        return _of_sweep(result)
    if kind == "fit":
        return _of_fit(result)
    found = dict(_attributes(result, SCALARS[kind], float))
    found |= dict(_attributes(result, ARRAYS[kind], _moments))
    found["warnings"] = float(len(result.warnings))
    return found


def _attributes(
    result: Any, names: tuple[str, ...], take: Callable[[Any], Any]
) -> Iterator[tuple[str, Any]]:
    for name in names:
        try:
            value = attrgetter(name)(result)
        except AttributeError:
            continue
        yield name, take(value)


def _moments(values: Array) -> list[float]:
    """Return norm, sum, weighted sum and end values; nodes without a value (nan) count as 0."""
    y = np.nan_to_num(np.asarray(values, dtype=float))
    golden = np.pi * (3 - np.sqrt(5))  # an angle whose multiples never meet
    wave = np.cos(golden * np.arange(y.size))
    return [float(v) for v in (np.linalg.norm(y), y.sum(), wave @ y, y[0], y[-1])]


def _of_sensitivity(found: Any) -> Measured:
    out: Measured = {}
    for output in ("nip_induced_tension", "half_width", "drum_creep"):
        out[output] = float(found.values[found.outputs.index(output)])
        for parameter in found.parameters:
            out[f"{output} by {parameter}"] = found.derivative(output, parameter)
    fields = zip(found.parameters, found.fields, strict=True)
    out |= {f"field {name}": float(value) for name, value in fields}
    out["zone_change"] = float(bool(found.zone_change))
    return out


def _of_sweep(dataset: Any) -> Measured:
    numbers = (name for name, values in dataset.items() if values.dtype.kind == "f")
    out: Measured = {name: dataset[name].values.ravel().tolist() for name in numbers}
    for name in ("failure", "warnings"):
        out[name] = [float(bool(text)) for text in dataset[name].values.ravel()]
    return out


def _of_fit(found: Any) -> Measured:
    out: Measured = {name: np.ravel(getattr(found, name)).tolist() for name in FIT}
    for profile in found.profiles:
        out[f"profile of {profile.name}"] = [profile.low, profile.high, profile.rms_limit]
    out["solves"] = [float(found.solves)]
    return out
