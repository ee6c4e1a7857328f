"""What the results of a nip and of two rollers have in common."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import nan
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

from ..quantities import Quantity, length, line_load
from .energy import pressure_resultant

if TYPE_CHECKING:
    from ..sensitivity import Sensitivity

__all__ = ["ContactOutputs"]


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class ContactOutputs:
    """What the results of a nip and of two rollers have in common.

    Attributes
    ----------
    rolling_resistance : float
        Dissipation of the viscoelastic bodies per length rolled [N/m], a force per metre of width;
        nan without a viscoelastic body.
    """

    CONTACT_PRESSURE: ClassVar[str] = "pressure"  # name of the array of the contact pressure

    rolling_resistance: Annotated[
        float, line_load("F_R", "rolling resistance of the viscoelastic bodies")
    ] = nan

    @property
    def dissipated_power(
        self,
    ) -> Annotated[
        float, Quantity("D", "W/m", "power dissipated in the viscoelastic bodies, per width")
    ]:
        """V F_R [W/m]: the heat that goes into the covers."""
        V = self.problem.rolling_speed  # type: ignore[attr-defined]
        return nan if V is None else float(V * self.rolling_resistance)

    @property
    def pressure_shift(
        self,
    ) -> Annotated[float, length("e_p", "pressure resultant, downstream of the line of centres")]:
        """Position of the pressure's resultant along +x, from the line of centres [m]."""
        result: Any = self
        if not result.problem.viscoelastic:
            return nan
        x, p = result.x[result.in_nip], getattr(result, result.CONTACT_PRESSURE)[result.in_nip]
        return float(pressure_resultant(x, p)[1] - result.offset)

    @property
    def nodes(self) -> int:
        """Number of nodes in the nip."""
        in_nip: slice = self.in_nip  # type: ignore[attr-defined]
        return in_nip.stop - in_nip.start

    def sensitivity(self, *parameters: str, outputs: Sequence[str] = ()) -> Sensitivity:
        """Return exact derivatives of outputs with respect to fields of the problem.

        Parameters
        ----------
        parameters : str
            Dotted names (``"roll.material.shear"``, ``"upper.material.youngs_modulus"``); every
            continuous field if none is given.
        outputs : sequence of str
            Names; the main ones if none is given.
        """
        # imported late: many results are never differentiated
        from .sensitivity import contact_sensitivity

        result: Any = self
        if result.refinement is not None:
            meshes = result.refinement.meshes
        else:  # loaded from a file
            meshes = [result._recomputed_solution()]
        outputs = (outputs,) if isinstance(outputs, str) else tuple(outputs)
        return contact_sensitivity(
            result, meshes, parameters, outputs or result._differentiated, result._excluded
        )
