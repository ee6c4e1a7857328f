"""Pull tabs: the pressure between the layers of a roll from the force that moves a steel strip."""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_validator

from ..errors import InvalidProblem, one_of
from ..problems.description import Description
from ..problems.fields import Number, OptionalNumber, default
from ..quantities import Quantity, Values, pure, share, stress

__all__ = ["PullTab"]


class PullTab(Description):
    """A pull tab with its calibration: pressure = slope * force + offset.

    A tab wound between two layers slides on ``faces`` faces when it is pulled, F = faces mu A P.
    Give the calibration line, or the coefficient of friction and the area:

    Parameters
    ----------
    slope : float or str
        Pressure per force [Pa/N].
    offset : float or str
        Pressure at zero force [Pa].
    friction : float
        Coefficient of friction between tab and web, or tab and envelope.
    area : float or str
        Area of one face between the layers [m^2].
    faces : int
        Faces on which the tab slides, 1 or 2.
    deviation : float or str
        Relative standard deviation of the calibration; it is common to all readings of the tab.

    Raises
    ------
    InvalidProblem
        If neither slope nor friction and area are given, or a value is out of range.

    Examples
    --------
    >>> import woundon as wo
    >>> tab = wo.PullTab(friction=0.2, area="12.5 cm^2")
    >>> round(tab.pressure(100.0))  # 100 N on two faces
    200000
    """

    slope: Annotated[OptionalNumber, Quantity("k_t", "Pa/N", "pressure per force"), Field(gt=0)] = (
        default(None)
    )
    offset: Annotated[Number, stress("P_0", "pressure at zero force")] = default(0.0)
    friction: Annotated[
        OptionalNumber, pure("mu_t", "coefficient of friction of the tab"), Field(gt=0)
    ] = default(None)
    area: Annotated[
        OptionalNumber, Quantity("A_t", "m^2", "area of one face of the tab", "cm^2"), Field(gt=0)
    ] = default(None)
    faces: Literal[1, 2] = 2
    deviation: Annotated[
        Number, share("s_t", "relative standard deviation of the calibration"), Field(ge=0, lt=1)
    ] = default(0.0)

    @model_validator(mode="after")
    def _check_calibration(self) -> Self:
        """Reject a tab with neither a slope nor friction and area, or with both."""
        calibration = [
            name for name in ("slope", "friction", "area") if getattr(self, name) is not None
        ]
        if calibration not in (["slope"], ["friction", "area"]):
            given = one_of(calibration, "and") if calibration else "nothing"
            text = f"the tab has {given}; must have slope, or friction and area"
            raise InvalidProblem.at("", text)
        return self

    @property
    def pressure_per_force(self) -> float:
        """Slope of the calibration [Pa/N]."""
        if self.slope is not None:
            return self.slope
        assert self.friction is not None
        assert self.area is not None
        return 1 / (self.faces * self.friction * self.area)

    def pressure(self, force: Values) -> Values:
        """Return the pressure [Pa] for a force [N], or for an array of forces."""
        pressure: Any = self.pressure_per_force * force + self.offset
        return pressure
