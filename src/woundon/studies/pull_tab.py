"""Pull tabs: the pressure between the layers of a roll from the force that moves a steel strip."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite
from typing import Any

from ..arguments import whole_number
from ..errors import InvalidProblem
from ..problems.messages import quote
from ..problems.units import parse
from ..quantities import Values

__all__ = ["PullTab"]


@dataclass(frozen=True, kw_only=True)
class PullTab:
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
    >>> tab = PullTab(friction=0.2, area="12.5 cm^2")
    >>> round(tab.pressure(100.0))  # 100 N on two faces
    200000
    """

    slope: Any = None
    offset: Any = 0.0
    friction: Any = None
    area: Any = None
    faces: int = 2
    deviation: Any = 0.0

    def __post_init__(self) -> None:
        """Convert texts with units to SI and check the fields."""
        units = {"slope": "Pa/N", "offset": "Pa", "friction": "1", "area": "m^2", "deviation": "1"}
        for name, unit in units.items():
            value = getattr(self, name)
            if value is not None or name in ("offset", "deviation"):  # which must not be None
                object.__setattr__(self, name, parse(value, unit, f"tab.{name}"))
        calibration = [
            name for name in ("slope", "friction", "area") if getattr(self, name) is not None
        ]
        if calibration not in (["slope"], ["friction", "area"]):
            text = (
                f"{', '.join(calibration) or 'nothing'} given; must be slope, or friction and area"
            )
            raise InvalidProblem.at("tab", text)
        for name in calibration:
            value = getattr(self, name)
            if not (isfinite(value) and value > 0):
                raise InvalidProblem.at(
                    f"tab.{name}", f"{quote(value)} is out of range; must be > 0"
                )
        if not isfinite(self.offset):
            raise InvalidProblem.at("tab.offset", f"{quote(self.offset)} is not a finite number")
        if not 0 <= self.deviation < 1:
            text = f"{quote(self.deviation)} is out of range; must be >= 0 and < 1"
            raise InvalidProblem.at("tab.deviation", text)
        whole_number("tab.faces", self.faces, 1, 2)

    @property
    def pressure_per_force(self) -> float:
        """Slope of the calibration [Pa/N]."""
        if self.slope is not None:
            return float(self.slope)
        return 1 / (self.faces * float(self.friction) * float(self.area))

    def pressure(self, force: Values) -> Values:
        """Return the pressure [Pa] for a force [N], or for an array of forces."""
        pressure: Any = self.pressure_per_force * force + self.offset
        return pressure
