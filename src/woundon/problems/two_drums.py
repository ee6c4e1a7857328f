r"""The nip loads of a two-drum winder: a roll under its weight and a rider roll on two drums.

The roll rests between two drums of equal centre height, with a gap between them::

            rider
              |
            (roll)          sin a = horizontal distance of the centres/(R + R_drum)
           a/    \b
      (rear)      (front)

Only normal loads N act; the tangential forces of the drums and the web are neglected:
N_r sin a = N_f sin b and N_r cos a + N_f cos b = W + rider load, so that

    N_r = (W + rider) sin b/sin(a + b),   N_f = (W + rider) sin a/sin(a + b)

or (W + rider)/(2 cos a) for equal drums.

The nip of a :class:`~woundon.WindingProblem` is the nip at the drum on which the web arrives,
usually the rear drum: ``drum`` is that drum, and ``nip_load`` is the load ``rear``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..errors import InvalidProblem
from .messages import quote

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

__all__ = ["GRAVITY", "DrumLoads", "drum_loads", "rider_load_for", "roll_weight"]

GRAVITY = 9.80665  # m/s^2, standard


class DrumLoads(NamedTuple):
    """Nip loads on the rear and the front drum [N/m].

    The web usually arrives on the rear drum, whose load is the nip load of the winding.
    """

    rear: Any
    front: Any


def roll_weight(
    radius: ArrayLike, core_radius: float, density: float, core_mass: float = 0.0
) -> Any:
    """Return the weight of a roll per metre of width [N/m], in the shape of ``radius``.

    Parameters
    ----------
    radius : array_like
        Radius of the roll [m].
    core_radius : float
        [m].
    density : float
        Density of the web [kg/m^3].
    core_mass : float
        Mass of core and shaft per metre of width [kg/m].

    Raises
    ------
    InvalidProblem
        For a negative number, nan, or a roll smaller than its core.

    Examples
    --------
    >>> from woundon.problems.two_drums import roll_weight
    >>> round(roll_weight(radius=0.5, core_radius=0.05, density=680.0))
    5185
    """
    R = _checked("radius", radius)
    rc, rho = _checked_number("core_radius", core_radius), _checked_number("density", density)
    core = _checked_number("core_mass", core_mass)
    if np.any(rc > R):
        smallest = quote(float(np.min(R)))
        text = f"{smallest} is out of range; must be >= core_radius = {rc:.6g} [m]"
        raise InvalidProblem.at("radius", text)
    return GRAVITY * (np.pi * rho * (R**2 - rc**2) + core)


def drum_loads(
    radius: ArrayLike,
    weight: ArrayLike,
    drum_radius: float | tuple[float, float],
    gap: float,
    rider_load: ArrayLike = 0.0,
) -> DrumLoads:
    """Return the nip loads between a roll and the two drums that support it.

    Parameters
    ----------
    radius : array_like
        R of the roll [m], > gap/2.
    weight : array_like
        W of the roll per metre of width [N/m]; see :func:`roll_weight`.
    drum_radius : float or (float, float)
        Radius of both drums, or of the rear and the front drum [m].
    gap : float
        Gap between the surfaces of the drums [m], >= 0.
    rider_load : array_like
        Vertical line load of a rider roll [N/m].

    Returns
    -------
    DrumLoads
        ``rear`` and ``front``; the nip load of a winding is that of the drum on which the web
        arrives, usually ``rear``.

    Raises
    ------
    InvalidProblem
        For numbers out of range: a roll that falls between the drums, or off the smaller one.

    Examples
    --------
    >>> from woundon.problems.two_drums import drum_loads
    >>> loads = drum_loads(radius=0.5, weight=5000.0, drum_radius=0.3, gap=0.01)
    >>> round(float(loads.rear)), round(float(loads.front))
    (2704, 2704)
    """
    rear, front = _shares(radius, drum_radius, gap)
    down = _checked("weight", weight) + _checked("rider_load", rider_load)
    return DrumLoads((down * rear)[()], (down * front)[()])  # [()]: scalars of scalar arguments


def rider_load_for(
    nip_load: ArrayLike,
    radius: ArrayLike,
    weight: ArrayLike,
    drum_radius: float | tuple[float, float],
    gap: float,
    drum: str = "rear",
) -> Any:
    """Return the rider-roll load that gives a target nip load on one drum [N/m].

    It is negative if the weight of the roll alone exceeds the target.

    Parameters
    ----------
    nip_load : array_like
        Target [N/m].
    radius, weight, drum_radius, gap
        As for :func:`drum_loads`.
    drum : "rear" or "front"
        The drum with the target; the web usually arrives on the rear drum.
    """
    if not isinstance(drum, str) or drum not in ("rear", "front"):
        raise InvalidProblem.at("drum", f"{quote(drum)} is unknown; must be 'rear' or 'front'")
    rear, front = _shares(radius, drum_radius, gap)
    share = rear if drum == "rear" else front
    return (_checked("nip_load", nip_load) / share - _checked("weight", weight))[()]


def _shares(
    radius: ArrayLike, drum_radius: float | tuple[float, float], gap: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return the loads on the rear and the front drum due to a unit vertical load [1]."""
    R, space = _checked("radius", radius), _checked_number("gap", gap)
    drums = _checked("drum_radius", drum_radius)
    if drums.size not in (1, 2) or not (drums > 0).all():
        text = f"{quote(drum_radius)} is out of range; must be one or two numbers > 0 [m]"
        raise InvalidProblem.at("drum_radius", text)
    if np.any(space >= 2 * R):
        text = f"{quote(float(np.min(R)))} is out of range; must be > gap/2 = {space / 2:.6g} [m]"
        raise InvalidProblem.at("radius", f"{text}, or the roll falls between the drums")
    first, second = np.broadcast_to(drums.ravel(), 2)  # radii of the rear and the front drum
    distance = first + second + space
    # horizontal distances of the roll's centre from those of the drums
    to_rear = (distance**2 + (R + first) ** 2 - (R + second) ** 2) / (2 * distance)
    to_front = distance - to_rear
    if np.any((to_rear <= 0) | (to_front <= 0)):
        # the radius of a roll whose centre is above that of the smaller drum
        small, large = sorted((first, second))
        largest = (distance**2 + small**2 - large**2) / (2 * (large - small))
        text = f"{quote(float(np.max(R)))} is out of range; must be < {largest:.6g} [m]"
        raise InvalidProblem.at("radius", f"{text}, or the roll rolls off the smaller drum")
    height = np.sqrt((R + first) ** 2 - to_rear**2)
    # sin b/sin(a + b) and sin a/sin(a + b): twice the area of the triangle of the three centres is
    # height * distance = (R + first) (R + second) sin(a + b)
    area = height * distance
    return (R + first) * to_front / area, (R + second) * to_rear / area


def _checked(name: str, value: Any) -> np.ndarray:
    """Return a value as an array; reject numbers < 0 and nan."""
    try:
        numbers = np.asarray(value, dtype=float)
    except (TypeError, ValueError, OverflowError):
        raise InvalidProblem.at(name, f"{quote(value)} is not a number; must be >= 0") from None
    wrong = numbers[~((numbers >= 0) & np.isfinite(numbers))]
    if wrong.size:
        text = f"{quote(float(wrong.flat[0]))} is out of range; must be >= 0"
        raise InvalidProblem.at(name, text)
    return numbers


def _checked_number(name: str, value: Any) -> float:
    """Return a single number; reject several, numbers < 0 and nan."""
    numbers = _checked(name, value)
    if numbers.size != 1:
        raise InvalidProblem.at(name, f"{quote(value)} is not a number; must be >= 0")
    return float(numbers.item())
