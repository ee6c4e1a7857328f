"""Results that woundon 0.1 saved (schema 1), as this version has them.

nip          wound_on_tension was T_out: a property now, tension_behind_nip
wrapped_nip  the problem was a NipProblem, wraps and force stood on the result; its tensions at the
             nip, wrap tractions and slip angle are properties now
rollers      where the slip is taken, and the shift of static ones, were not told
all          slip ratios in a table of their own; one error, that of the tension
thesis       its scheme interpolated the kernels, which are integrated exactly now; those of
             wrapped nips were integrated by other points: by today's the laws hold less closely,
             which the result says
"""

from __future__ import annotations

from dataclasses import fields
from typing import Any

import numpy as np

from .. import kinds
from ..results import ACCEPTED_RESIDUAL, Residuals

__all__ = ["accepted", "completed", "is_of_0_1", "judged", "upgraded"]

Array = np.ndarray
Record = dict[str, Any]

INTERPOLATED, INTEGRATED = 1e-4, 1e-5  # of a law: what the other kernels leave, of both kinds
SAVED_BY_0_1 = "saved by woundon 0.1: by today's kernels its laws hold to"
_WRAPS = ("roll_wrap", "drum_wrap", "wrap_friction", "winding_force")
_TOLD = {"nip": "nip_induced_tension", "wrapped_nip": "wound_on_tension"}


def upgraded(record: Record) -> Record:
    """Return a record of schema 1 with the parts of one of schema 2."""
    kind, problem, given = record["kind"], dict(record["problem"]), dict(record)
    if kind == "wrapped_nip":
        problem |= {name: given[name] for name in _WRAPS}
    prefix = "slip_ratio_"  # of netCDF
    given |= {name.removeprefix(prefix): given[name] for name in record if name.startswith(prefix)}
    given |= given.get("slip_ratios", {})
    if kind == "rollers":
        given["slip_x"] = _slip_x(np.asarray(given["x"], dtype=float)).tolist()
    if kind == "nip":
        given["extrapolation"] = _extrapolation(given)
    names = [part.name for part in fields(kinds.named(kind).result) if part.name != "errors"]
    told = {name: given[name] for name in names if name in given}
    apart = {name: told.pop(name) for name in ("problem", "residuals", "warnings")}
    error = given.get(f"{_TOLD.get(kind)}_error")
    return {
        "schema": 1,
        "version": record["version"],
        "kind": kind,
        **apart,
        "problem": problem,
        "fields": told,
        "dimensions": {name: ["x"] for name, value in told.items() if isinstance(value, list)},
        "units": record.get("units", {}),
        "errors": {_TOLD[kind]: error} if error else {},  # 0: only one grid was solved
    }


def _extrapolation(given: Record) -> float:
    """Return what NIT has beyond the integral of the tractions; 0 where that is rounding."""
    tractions = np.add(given["roll_traction"], given["drum_traction"])
    beyond = float(given["nip_induced_tension"] - np.trapezoid(tractions, given["x"]))
    return beyond if abs(beyond) > 1e-9 * given["problem"]["nip_load"] else 0.0


def _slip_x(x: Array) -> Array:
    """Return where the slip was taken: at the middle of the cell before each node, (M,) [m].

    The middle of the parameter in which the cells of the grids of 0.1 were even: the angle of
    cosine nodes, or t of x ~ t^2.2 from and to zone borders six cells apart or more.
    """
    nodes, count = x / x[-1], x.size - 1
    middle = -np.cos(np.pi * (np.arange(count) + 0.5) / count)
    if not _same(nodes, -np.cos(np.pi * np.arange(count + 1) / count)):
        parts, left = [], 0
        while left < count:
            right = next(
                j for j in range(left + 6, count + 1)
                if _same(nodes[left : j + 1], _between(nodes[left], nodes[j], j - left, 0.0))
            )  # fmt: skip
            parts.append(_between(nodes[left], nodes[right], right - left, 0.5)[:-1])
            left = right
        middle = np.concatenate(parts)
    return np.asarray(x[-1] * np.append(middle[:1], middle))


def _same(nodes: Array, made: Array) -> bool:
    return np.allclose(nodes, made, rtol=0, atol=1e-12)


def _between(left: float, right: float, cells: int, part: float) -> Array:
    """Return the points at a part of each cell between two borders, and one more."""
    t = np.minimum((np.arange(cells + 1) + part) / cells, 1.0)
    return np.asarray(left + (right - left) * t**2.2 / (t**2.2 + (1 - t) ** 2.2))


def completed(result: Any) -> Any:
    """Return a result of 0.1 with what its equations tell: the shift of static rollers."""
    if getattr(result.problem, "motion", "") != "static":
        return result
    equations = kinds.fetch("woundon.rollers.certificate:matrices_of")(result)
    unshifted = equations.slips(result.pressure[1:-1], result.traction[1:-1], 0.0)
    return result.replace(shift=float(np.median(result.slip[1:-1] - unshifted)))


def accepted(result: Any) -> float:
    """Return the largest residual by which a result, once of 0.1, holds what it says."""
    if getattr(result, "scheme", "").startswith("thesis"):
        return INTERPOLATED
    return INTEGRATED if kinds.of(result.problem).name == "wrapped_nip" else ACCEPTED_RESIDUAL


def is_of_0_1(record: Record, result: Any) -> bool:
    """Tell whether 0.1 saved a result, which later versions may have saved again."""
    return record["schema"] == 1 or any(text.startswith(SAVED_BY_0_1) for text in result.warnings)


def judged(result: Any, residuals: Residuals) -> Any:
    """Return a result of 0.1 with a warning of what today's equations leave, if it is more."""
    if residuals.largest <= ACCEPTED_RESIDUAL:
        return result
    told = f"{SAVED_BY_0_1} {residuals.largest:.1g}"
    return result.replace(warnings=(*result.warnings, told))
