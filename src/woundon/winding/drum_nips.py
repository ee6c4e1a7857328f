"""The nips of front drum or rider roll of a two-drum winder, over the radius of the roll."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np

from ..nip.result import NipResult
from ..nip.roll_contact import LEAST_STICK
from ..quantities import angle, length, line_load, share, stress
from ..results import ReadOnly

__all__ = ["DrumNips", "drum_nips"]

Array = np.ndarray


@dataclass(frozen=True, eq=False, kw_only=True)
class DrumNips(ReadOnly):
    """The nips of one drum, or of the rider, at the radii of the solved nips of a winding.

    The web is a layer of the roll there.  All arrays are (n,), along ``nip_radius`` of the winding.

    Attributes
    ----------
    load, force : arrays
        Nip load, and winding force of the drum, < 0: it drives [N/m].
    arc : array
        Arc of the web on the roll from the nip before to this one [rad].
    added_tension : array
        The part of the wound-on tension that this nip adds [N/m].
    slip_angle : array
        Angle on which the web slips on the roll, back from this nip [rad].
    stick_angle : array
        Angle of the arc on which the web sticks to the roll [rad].
    arc_least_tension, arc_largest_tension : arrays
        Smallest and largest tension of the web on the arc [N/m].
    width, peak_pressure : arrays
        Of the nip [m], [Pa].
    friction_ratio : array
        |F|/(mu P), share of the friction between web and drum that the winding force uses [1].

    Examples
    --------
    >>> import woundon as wo
    >>> wo.WindingResult.__dataclass_fields__["front"].type
    'DrumNips | None'
    """

    part_of_result: ClassVar[bool] = True

    load: Annotated[Array, line_load("P_k", "load of this nip")]
    force: Annotated[Array, line_load("F_k", "winding force of this drum, < 0: it drives")]
    arc: Annotated[Array, angle("theta_k", "arc of the web from the nip before to this one")]
    added_tension: Annotated[
        Array, line_load("WOT_k - WOT_k-1", "part of the wound-on tension that this nip adds")
    ]
    slip_angle: Annotated[Array, angle("theta_slip", "angle of slip upstream of this nip")]
    stick_angle: Annotated[Array, angle("theta_stick", "part of the arc on which the web sticks")]
    arc_least_tension: Annotated[Array, line_load("T_min", "smallest tension before this nip")]
    arc_largest_tension: Annotated[Array, line_load("T_max", "largest tension before this nip")]
    width: Annotated[Array, length("2a", "width of this nip")]
    peak_pressure: Annotated[Array, stress("p_max", "peak pressure of this nip")]
    friction_ratio: Annotated[Array, share("|F|/mu P", "used friction of this drum")]

    @property
    def least_tension(
        self,
    ) -> Annotated[float, line_load("T_min", "smallest tension before this nip in the build-up")]:
        """Smallest tension of the web upstream of the nip, of all radii [N/m]."""
        return float(self.arc_least_tension.min())

    @property
    def largest_tension(
        self,
    ) -> Annotated[float, line_load("T_max", "largest tension before this nip in the build-up")]:
        """Largest tension of the web upstream of the nip, of all radii [N/m]."""
        return float(self.arc_largest_tension.max())

    @property
    def largest_added_tension(
        self,
    ) -> Annotated[float, line_load("dWOT_k", "largest part of WOT that this nip adds")]:
        """Largest part of the wound-on tension that the nip adds, of all radii [N/m]."""
        return float(self.added_tension.max())

    @property
    def sticks(self) -> Array:
        """True where the web sticks on a part of the arc, so that the nip adds nothing, (n,)."""
        return np.asarray(self.stick_angle > LEAST_STICK * self.arc)


def drum_nips(nips: Sequence[NipResult], index: int) -> DrumNips | None:
    """Return the nips of one drum, from the solved nips of a winding.

    Parameters
    ----------
    nips : sequence of NipResult
        From the core to the surface.
    index : int
        1: front drum, 2: rider.

    Returns
    -------
    DrumNips or None
        None if there are no nips, or the winder has no such drum.
    """
    if not nips or len(nips[0].contacts) <= index:
        return None
    contacts = [nip.contacts[index] for nip in nips]

    def column(name: str) -> Array:
        """Return an attribute of all contacts, (n,)."""
        return np.array([float(getattr(contact, name)) for contact in contacts])

    return DrumNips(
        load=column("nip_load"),
        force=column("winding_force"),
        arc=column("angle") - [nip.contacts[index - 1].angle for nip in nips],
        added_tension=column("added_tension"),
        slip_angle=column("slip_angle"),
        stick_angle=column("stick_angle"),
        arc_least_tension=column("least_tension"),
        arc_largest_tension=column("largest_tension"),
        width=column("nip_width"),
        peak_pressure=column("peak_pressure"),
        friction_ratio=column("friction_ratio"),
    )
