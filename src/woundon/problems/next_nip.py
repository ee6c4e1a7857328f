"""Further nips of the outer layer of a wound roll: front drum and rider roll."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from math import pi
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import BeforeValidator, Field

from ..quantities import angle, line_load, pure
from .bodies import AnyBody
from .description import Description
from .fields import Number, OptionalNumber, default, listed

if TYPE_CHECKING:
    from .fields import CoercedField

__all__ = ["NextNip", "NextNips"]


class NextNip(Description):
    """A further nip through which the web runs with the roll on which it was laid.

    Parameters
    ----------
    angle : float
        From the nip before to this one, along the roll in the direction of travel [rad], 0.01 to
        pi; the further nips of a problem lie within its roll wrap.
    drum : Rigid, HalfPlane, Cylinder or another Body
        Front drum or rider roll.
    nip_load : float
        P_k [N/m], 1e-12 to 1e7.
    winding_force : float
        F_k = integral of q- [N/m], |F_k| < mu- P_k; F_k > 0: the drum brakes, < 0: it drives.
    drum_friction : float, optional
        mu- between web and this drum, 1e-8 to 10; that of the first drum if None.

    Examples
    --------
    >>> import woundon as wo
    >>> front = wo.NextNip(angle=1.5, drum=wo.Rigid(radius=0.25), nip_load="3 kN/m")
    >>> nip = wo.NipProblem.example().replace(next_nips=[front])
    >>> nip.next_nips[0].nip_load
    3000.0
    """

    angle: Annotated[
        Number,
        angle("theta_k", "angle from the nip before to this one, on the roll", (0.5, 2.5)),
        Field(ge=0.01, le=pi),
    ]
    drum: Annotated[AnyBody, Field(description="the front drum or rider roll")]
    nip_load: Annotated[
        Number, line_load("P_k", "load of this nip", (500.0, 10e3)), Field(ge=1e-12, le=1e7)
    ]
    winding_force: Annotated[
        Number,
        line_load("F_k", "winding force of this drum, < 0: it drives", (-500.0, 500.0)),
        Field(ge=-1e7, le=1e7),
    ] = default(0.0)
    drum_friction: Annotated[
        OptionalNumber,
        pure("mu_k-", "friction coefficient of web and this drum", (0.1, 0.6)),
        Field(ge=1e-8, le=10.0),
    ] = default(None)


if TYPE_CHECKING:
    NextNips = CoercedField[tuple[NextNip, ...], Iterable[NextNip | Mapping[str, Any]]]
else:
    NextNips = Annotated[tuple[NextNip, ...], BeforeValidator(listed)]
