"""The golden cases: their problems as objects of the program, and comparison with its results.

The files were written once, by version 0.2 (``provenance``).  Everything that depends on the names
of classes and of outputs is in ``TYPES``, ``build``, ``outputs`` and ``samples``.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from math import isfinite
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import woundon as wo
from woundon.quantities import value_of

__all__ = [
    "SLIP_LENGTHS", "Comparison", "GoldenCase", "build", "compare", "compare_samples", "families",
    "golden", "provenance",
]  # fmt: skip

FOLDER = Path(__file__).parent
# outputs of version 0.2 that results no longer have: the reproduction of the thesis computes it
REMOVED = frozenset({"rig_tension"})
# relative to the nip width: a short slip zone that a coarse mesh misses changes them by
# more than their error estimates
SLIP_LENGTHS = frozenset({"leading_roll", "trailing_roll", "dual"})
# outputs that do not depend on the discretisation are equal to rounding and solver tolerance
SOLVER_TOLERANCE = 1e-8


# ---- problems ------------------------------------------------------------------------------------

TYPES: Mapping[str, Any] = {
    "air": wo.Air,
    "core": wo.Core,
    "cylinder": wo.Cylinder,
    "half_plane": wo.HalfPlane,
    "isotropic": wo.Isotropic,
    "layer": wo.Layer,
    "layered": wo.Layered,
    "limits": wo.Limits,
    "loss_angle": wo.LossAngle,
    "nip_problem": wo.NipProblem,
    "orthotropic": wo.Orthotropic,
    "pfeiffer": wo.Pfeiffer,
    "polynomial": wo.Polynomial,
    "power_law": wo.PowerLaw,
    "profile": wo.Profile,
    "rigid": wo.Rigid,
    "roller_problem": wo.RollerProblem,
    "stack": wo.Stack,
    "stack_test": wo.StackTest,
    "taper": wo.Taper,
    "web": wo.Web,
    "winding_problem": wo.WindingProblem,
    "wound_roll": wo.WoundRoll,
    "wound_roll_problem": wo.RollProblem,
}


def build(data: Any) -> Any:
    """Return the object that the JSON data describe."""
    if isinstance(data, list):
        return [build(item) for item in data]
    if not isinstance(data, Mapping):
        return data
    fields = {name: build(value) for name, value in data.items() if name != "type"}
    if data["type"] == "constant":  # a modulus that does not depend on the pressure
        return fields["youngs_modulus"]
    return TYPES[data["type"]](**fields)


# ---- results -------------------------------------------------------------------------------------


class Output(NamedTuple):
    """A value and its estimated error; nan where there is no estimate."""

    value: float
    error: float


OF_THE_FILM = {name: f"air.{name}" for name in (
    "film", "film_in_nip", "foil_film", "nip_film", "friction_share", "inlet_length",
    "roll_friction", "wrap_friction",
)} | {"edge": "air.gradient"}  # fmt: skip


def outputs(result: Any, names: Any) -> dict[str, Output]:
    """Return outputs of a result by the names and definitions of the golden cases."""
    problem, found = result.problem, {}
    is_nip = hasattr(problem, "nip_load") and not hasattr(problem, "core")
    for name in names:
        own, offset = name, 0.0
        if is_nip and name == "edge_to_edge_tension_rise":
            own, offset = "outlet_tension", -result.inlet_tension
        if is_nip:
            own = OF_THE_FILM.get(own, own)
        value = float(value_of(result, own)) + offset
        found[name] = Output(value, float(result.errors.get(own, np.nan)))
    return found


def samples(result: Any, x_over_a: Any) -> dict[str, Any]:
    """Return the sampled arrays of a nip or of two rollers."""
    if isinstance(result, wo.RollerResult):
        arrays = {"pressure": result.pressure, "traction": result.traction}
        x = result.x
    else:
        own = result.in_nip
        arrays = {
            "drum_pressure": result.drum_pressure[own],
            "roll_pressure": result.roll_pressure[own],
            "roll_traction": result.roll_traction[own],
            "drum_traction": result.drum_traction[own],
            "tension": result.tension[own],
        }
        x = result.x[own]
    return {
        name: np.interp(x_over_a, x / result.half_width, values) for name, values in arrays.items()
    }


# ---- cases ---------------------------------------------------------------------------------------


@dataclass(frozen=True)
class GoldenCase:
    """One golden case; ``entry`` is its JSON data."""

    family: str
    entry: Mapping[str, Any]

    @property
    def name(self) -> str:
        """The family and the name."""
        return f"{self.family}: {self.entry['name']}"

    @cached_property
    def problem(self) -> Any:
        """The problem as an object of the program."""
        return build(self.entry["problem"])

    @property
    def is_rejected(self) -> bool:
        """Whether version 0.2 rejects the case, or does not solve it."""
        return "rejected" in self.entry

    @cached_property
    def outputs(self) -> dict[str, Output]:
        """The outputs of version 0.2, with the larger of error estimate and change of the mesh."""
        return {
            name: Output(value, max(abs(error or 0.0), abs(change or 0.0)))
            for name, (value, error, change) in self.entry.get("outputs", {}).items()
            if name not in REMOVED
        }


def families() -> list[str]:
    """Return the names of the families."""
    return sorted(path.stem for path in FOLDER.glob("*.json"))


def provenance(family: str) -> dict[str, str]:
    """Return the commit, and the versions of the packages, that solved a family."""
    return dict(_file(family)["solved_with"])


def golden(*names: str) -> list[GoldenCase]:
    """Return the cases of some families, of all without arguments."""
    found = []
    for family in names or families():
        found += [GoldenCase(family, entry) for entry in _file(family)["cases"]]
    return found


def _file(family: str) -> Any:
    return json.loads((FOLDER / f"{family}.json").read_text("utf-8"))


# ---- comparison ----------------------------------------------------------------------------------


class Comparison(NamedTuple):
    """A value of the program next to the golden one; ``ratio`` is the difference / allowance."""

    case: str
    output: str
    value: float
    golden: float
    allowance: float

    @property
    def ratio(self) -> float:
        """The difference relative to the allowance."""
        difference = abs(self.value - self.golden)
        return difference / self.allowance if difference else 0.0


def compare(case: GoldenCase, result: Any) -> Iterator[Comparison]:
    """Yield the outputs that the result has an error estimate for.

    The allowance is the sum of both error estimates.
    """
    own = outputs(result, case.outputs)
    for name, expected in case.outputs.items():
        value, error = own[name]
        if isfinite(error):
            allowance = error + expected.error + SOLVER_TOLERANCE * _scale(case, name)
            yield Comparison(case.name, name, value, expected.value, allowance)


def _scale(case: GoldenCase, name: str) -> float:
    """Return the size that a vanishing output is compared with."""
    value, problem = abs(case.outputs[name].value), case.entry["problem"]
    if name in ("offset", "approach", "shift"):
        return max(value, case.outputs["half_width"].value)
    if name == "tangential_load":
        return max(value, problem["friction"] * problem["load"])
    if "tension" in name and problem["type"] == "nip_problem":
        return max(value, problem["roll_friction"] * problem["nip_load"])
    return 1.0 if name in SLIP_LENGTHS else value


def compare_samples(case: GoldenCase, result: Any) -> Iterator[Comparison]:
    """Yield the sampled arrays of a nip or of two rollers.

    The arrays have no error estimates.  The allowance is four times the change between the two
    meshes of version 0.2, and 1e-3 of the largest value: at a traction jump and at a slip boundary
    the change of a single node is no measure of the error.
    """
    table = dict(case.entry.get("samples", {}))
    x_over_a = table.pop("x_over_a", None)
    if x_over_a is None:
        return
    own = samples(result, x_over_a)
    for name, (values, changes) in table.items():
        largest = max(max(map(abs, values)), 1e-300)
        for x, value, expected, change in zip(x_over_a, own[name], values, changes, strict=True):
            allowance = 4 * abs(change) + 1e-3 * largest
            yield Comparison(case.name, f"{name} at {x:g} a", float(value), expected, allowance)
