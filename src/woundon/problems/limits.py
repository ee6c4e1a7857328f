"""Limits of a wound roll, to which its margins refer."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from ..quantities import Quantity, pure, strain, stress, tension
from .description import Description
from .fields import Number, OptionalNumber, default

__all__ = ["Limits"]


class Limits(Description):
    """Limits of a wound roll.  A limit that is None is not checked, which reports state.

    Parameters
    ----------
    layer_friction : float, optional
        Coefficient of friction between layers; by default the interlayer friction of the winding.
    torque_share : float
        Largest torque relative to the interlayer slip capacity; 0.5 is a safety factor of two.
    acceleration : float
        Acceleration of the web at a start or stop through the core alone [m/s^2]; needs the density
        of the web.
    compression : float, optional
        Largest compressive stress along the web [Pa]; 0 allows none.
    blocking_pressure : float, optional
        Pressure at which layers stick together or mark each other [Pa].
    core_pressure : float, optional
        Collapse pressure of the core [Pa]; by default the elastic collapse of a thin tube.
    web_strength : float, optional
        Tensile strength of the web [N/m].
    slack_tension : float, optional
        Minimum tension of the web [N/m]; it runs slack below.
    yield_strain : float, optional
        Strain along the web at which it yields, so that the lane of a gauge band becomes baggy, and
        a thick web keeps the curvature of the roll [1].

    Raises
    ------
    InvalidProblem
        For a limit out of range.

    Examples
    --------
    >>> import woundon as wo
    >>> limits = wo.Limits(blocking_pressure="1 MPa", slack_tension="30 N/m")
    >>> limits.blocking_pressure, limits.core_pressure
    (1000000.0, None)
    """

    layer_friction: Annotated[
        OptionalNumber,
        pure("mu_l", "interlayer friction coefficient of the wound roll", (0.1, 0.6)),
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
