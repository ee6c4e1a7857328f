"""What a wound roll must bear: the limits that its margins are measured by."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from ..quantities import Quantity, pure, strain, stress, tension
from .description import Description
from .fields import Number, OptionalNumber, default

__all__ = ["Limits"]


class Limits(Description):
    """Limits of a wound roll; one that is None is not checked, and reports say so.

    Parameters
    ----------
    layer_friction : float, optional
        Coefficient of friction between layers; by default that of web and roll where the winding
        is known.
    torque_share : float
        Largest share of the torque which friction between laps can carry that may be asked of it;
        0.5 is a safety of two.
    acceleration : float
        Of the web at a start or a stop which the core alone drives or brakes [m/s^2]; needs the
        web's density.
    compression : float, optional
        Largest stress along the web in compression [Pa]; 0 allows none.
    blocking_pressure : float, optional
        Between layers, beyond which they stick or mark each other [Pa].
    core_pressure : float, optional
        That the core bears [Pa]; without it the elastic collapse of a thin tube.
    web_strength : float, optional
        Tension that the web bears [N/m].
    slack_tension : float, optional
        Tension at and below which the web runs slack [N/m].
    yield_strain : float, optional
        Strain along the web at which it yields, so that the lane of a gauge band stays longer and
        is baggy [1].

    Raises
    ------
    InvalidProblem
        For a limit out of range.
    """

    layer_friction: Annotated[
        OptionalNumber,
        pure("mu_l", "interlayer friction coefficient", (0.1, 0.6)),
        Field(gt=0, le=10),
    ] = default(None)
    torque_share: Annotated[
        Number,
        pure("S_M", "allowed torque / interlayer slip capacity", (0.1, 1.0)),
        Field(gt=0, le=1),
    ] = default(1.0)
    acceleration: Annotated[
        Number,
        Quantity(
            "a",
            "m/s^2",
            "web acceleration at a core-driven start or stop",
            typical=(0.0, 2.0),
        ),
        Field(ge=0, le=1000),
    ] = default(0.0)
    compression: Annotated[
        OptionalNumber,
        stress("S_c", "largest hoop (MD) compression", typical=(0.0, 500e3)),
        Field(ge=0, le=1e12),
    ] = default(None)
    blocking_pressure: Annotated[
        OptionalNumber,
        stress("P_b", "blocking pressure", typical=(100e3, 3e6)),
        Field(gt=0, le=1e12),
    ] = default(None)
    core_pressure: Annotated[
        OptionalNumber,
        stress("P_cc", "core collapse pressure", "MPa", (0.5e6, 10e6)),
        Field(gt=0, le=1e12),
    ] = default(None)
    web_strength: Annotated[
        OptionalNumber,
        tension("T_b", "tensile strength of the web", (500.0, 10e3)),
        Field(gt=0, le=1e8),
    ] = default(None)
    slack_tension: Annotated[
        OptionalNumber,
        tension("T_s", "minimum web tension", (5.0, 100.0)),
        Field(gt=0, le=1e8),
    ] = default(None)
    yield_strain: Annotated[
        OptionalNumber,
        strain("eps_y", "yield strain of the web (MD)"),
        Field(gt=0, le=1),
    ] = default(None)
