"""The winding theorem: a nip under another web tension, from a solved one, without solving.

The tension T_in before the nip enters no equation of the nip but by a constant (equations): the
tractions, slips and zones are the same, tensions are shifted by it, the web is thinner and longer.
"""

from __future__ import annotations

from types import MappingProxyType
from typing import Any

from ..problems.nip import NipProblem
from .result import NipResult
from .validity import nip_warnings

__all__ = ["SHIFTED", "at_tension", "neighbour"]

# outputs that depend on T_in through T_in + NIT alone, and so have the same derivatives
SHIFTED = MappingProxyType({
    "web_tension": frozenset({
        "nip_induced_tension", "nip_induced_tension_error", "tension_behind_nip", "rig_tension",
        "wound_on_tension_estimate", "half_width", "nip_width", "offset", "peak_pressure",
        "leading_roll", "trailing_roll", "dual",
    })
})  # fmt: skip


def at_tension(result: NipResult, T_in: float) -> NipResult:
    """Return the result of the same nip under the web tension T_in [N/m]."""
    step, web = T_in - result.problem.web_tension, result.problem.web
    c = web.compliance
    moved = result.replace(
        problem=result.problem.replace(web_tension=T_in),
        web_tension=result.web_tension + step,
        approach=result.approach - c.c12 * step,
        drum_creep=result.drum_creep - c.c11 / web.thickness * step,
    )
    return moved.replace(warnings=nip_warnings(moved))


def neighbour(problem: NipProblem, start: Any) -> NipResult | None:
    """Return the result of a problem that differs from a solved one in its tension alone."""
    others = (name for name in NipProblem.model_fields if name != "web_tension")
    if all(getattr(start.problem, name) == getattr(problem, name) for name in others):
        return at_tension(start, problem.web_tension)
    return None
