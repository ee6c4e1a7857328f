"""Outputs of nips that studies can name: slip ratios of the thesis, and tensions by eq. (183).

The ratios are over the nip width (:mod:`.zones`).  The tensions are nan for bodies for which (183)
is not defined.  Libraries are imported when an output is computed, since each process of woundon
loads this module.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Annotated

import woundon as wo

if TYPE_CHECKING:
    from .procedure import ProcedureResult

    Nip = wo.NipResult | ProcedureResult

__all__ = ["OUTPUTS"]


def leading_roll_slip(
    result: Nip,
) -> Annotated[float, wo.Quantity("s_r1", "1", "slip length at the roll's leading edge, to A")]:
    """Return s_r1."""
    from .zones import zone_lengths

    return zone_lengths(result).leading_roll


def trailing_roll_slip(
    result: Nip,
) -> Annotated[float, wo.Quantity("s_r2", "1", "slip length at the roll's trailing edge, from B")]:
    """Return s_r2."""
    from .zones import zone_lengths

    return zone_lengths(result).trailing_roll


def dual_slip(
    result: Nip,
) -> Annotated[float, wo.Quantity("s_d", "1", "length of slip at roll and drum, from C")]:
    """Return s_d."""
    from .zones import zone_lengths

    return zone_lengths(result).dual


def wound_on_tension_estimate(
    result: Nip,
) -> Annotated[
    float, wo.Quantity("WOT est.", "N/m", "wound-on tension estimated by eq. (183), no roll wrap")
]:
    """Return the estimate (183) half a turn downstream [N/m]."""
    from . import estimate

    return _nan_if_undefined(estimate.wound_on_tension_estimate, result)


def rig_tension(
    result: Nip,
) -> Annotated[
    float, wo.Quantity("T_rig", "N/m", "tension at a load cell to which the web is led, eq. (183)")
]:
    """Return the estimate (183) a quarter turn downstream, at the laboratory's load cell [N/m]."""
    from . import estimate

    return _nan_if_undefined(estimate.rig_tension, result)


def _nan_if_undefined(estimate: Callable[[Nip], float], result: Nip) -> float:
    """Return an estimate, nan for a body or an angle for which (183) is not defined."""
    try:
        return estimate(result)
    except wo.InvalidProblem:
        return float("nan")


OUTPUTS = (
    leading_roll_slip,
    trailing_roll_slip,
    dual_slip,
    wound_on_tension_estimate,
    rig_tension,
)
