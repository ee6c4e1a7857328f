r"""The nip loads of a two-drum winder: a roll's own weight, and a rider roll, on two drums.

The roll rests in the valley between two drums whose centres are on a level, a gap between them::

            rider
              |
            (roll)          sin a = horizontal distance of the centres/(R + R_drum)
           a/    \b
      (rear)      (front)

Normal loads N alone hold it, for what the drums' torques and the web pull along their surfaces is
left out: N_r sin a = N_f sin b and N_r cos a + N_f cos b = W + rider load, so that

    N_r = (W + rider) sin b/sin(a + b),   N_f = (W + rider) sin a/sin(a + b)

and (W + rider)/(2 cos a) where the drums are alike.  A roll grows into the valley's opening: its
weight grows like R^2, while cos a tends to 1.

The nip of a :class:`~woundon.WindingProblem` is the nip on the drum on which the web arrives,
usually the rear drum.  Its ``drum`` is that drum, and its ``nip_load`` the load ``rear``.
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

    The web usually arrives on the rear drum, whose load is then the nip load of a winding.
    """

    rear: Any
    front: Any


def roll_weight(
    radius: ArrayLike, core_radius: float, density: float, core_mass: float = 0.0
) -> Any:
    """Return the weight of a roll per metre of width [N/m], the shape of ``radius``.

    Parameters
    ----------
    radius : array_like
        Of the roll so far [m].
    core_radius : float
        [m].
    density : float
        Of the web [kg/m^3].
    core_mass : float
        Of the core, and a shaft, per metre of width [kg/m].

    Raises
    ------
    InvalidProblem
        For a negative or missing number, or a roll smaller than its core.
    """
    R = _checked("radius", radius)
    rc, rho, core = (
        _checked(name, value).item()
        for name, value in (
            ("core_radius", core_radius),
            ("density", density),
            ("core_mass", core_mass),
        )
    )
    if np.any(rc > R):
        least = quote(float(np.min(R)))
        text = f"{least} is out of range; must be >= core_radius = {rc:.6g} [m]"
        raise InvalidProblem.at("radius", text)
    return GRAVITY * (np.pi * rho * (R**2 - rc**2) + core)


def drum_loads(
    radius: ArrayLike,
    weight: ArrayLike,
    drum_radius: float | tuple[float, float],
    gap: float,
    rider_load: ArrayLike = 0.0,
) -> DrumLoads:
    """Return the nip loads between a roll and the two drums it rests on.

    Parameters
    ----------
    radius : array_like
        R of the roll [m], > gap/2.
    weight : array_like
        W of the roll per metre of width [N/m]; see :func:`roll_weight`.
    drum_radius : float or (float, float)
        Of both drums, or of the rear and the front one [m].
    gap : float
        Between the drums' surfaces [m], >= 0.
    rider_load : array_like
        Line load of a rider roll, straight down [N/m].

    Returns
    -------
    DrumLoads
        ``rear`` and ``front``; the nip load of a winding is that of the drum on which the web
        arrives, usually ``rear``.

    Raises
    ------
    InvalidProblem
        For numbers out of range: a roll that falls between the drums, or off the smaller one.
    """
    rear, front = _shares(radius, drum_radius, gap)
    down = _checked("weight", weight) + _checked("rider_load", rider_load)
    return DrumLoads((down * rear)[()], (down * front)[()])


def rider_load_for(
    nip_load: ArrayLike,
    radius: ArrayLike,
    weight: ArrayLike,
    drum_radius: float | tuple[float, float],
    gap: float,
    drum: str = "rear",
) -> Any:
    """Return the rider roll's line load that makes a wanted nip load on one drum [N/m].

    Where it is negative the roll is too heavy: its weight alone loads the nip more.  Parameters as
    of :func:`drum_loads`, and

    Parameters
    ----------
    nip_load : array_like
        Wanted [N/m].
    drum : "rear" or "front"
        Which one; the web usually arrives on the rear drum.
    """
    if drum not in ("rear", "front"):
        raise InvalidProblem.at("drum", f"{quote(drum)} is unknown; must be 'rear' or 'front'")
    share = _shares(radius, drum_radius, gap)[drum == "front"]
    return (_checked("nip_load", nip_load) / share - _checked("weight", weight))[()]


def _shares(
    radius: ArrayLike, drum_radius: float | tuple[float, float], gap: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return the loads on both drums of a unit load straight down."""
    R, space = _checked("radius", radius), _checked("gap", gap).item()
    drums = _checked("drum_radius", drum_radius)
    if drums.size not in (1, 2) or not (drums > 0).all():
        text = f"{quote(drum_radius)} is out of range; must be one or two numbers > 0 [m]"
        raise InvalidProblem.at("drum_radius", text)
    if np.any(space >= 2 * R):
        text = f"{quote(float(np.min(R)))} is out of range; must be > gap/2 = {space / 2:.6g} [m]"
        raise InvalidProblem.at("radius", f"{text}, or the roll falls between the drums")
    first, second = np.broadcast_to(drums.ravel(), 2)
    apart = first + second + space
    # how far the roll's centre is from each drum's, along the level and along the line of centres
    to_rear = (apart**2 + (R + first) ** 2 - (R + second) ** 2) / (2 * apart)
    to_front = apart - to_rear
    if np.any((to_rear <= 0) | (to_front <= 0)):
        small, large = sorted((first, second))
        most = (apart**2 + small**2 - large**2) / (2 * (large - small))
        text = f"{quote(float(np.max(R)))} is out of range; must be < {most:.6g} [m]"
        raise InvalidProblem.at("radius", f"{text}, or the roll rolls off the smaller drum")
    up = np.sqrt((R + first) ** 2 - to_rear**2)
    # sin b/sin(a + b) and sin a/sin(a + b), with sin(a + b) = up * apart/(both lines of centres)
    return (R + first) * to_front / (up * apart), (R + second) * to_rear / (up * apart)


def _checked(name: str, value: Any) -> np.ndarray:
    """Return numbers >= 0."""
    try:
        numbers = np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        raise InvalidProblem.at(name, f"{quote(value)} is not a number; must be >= 0") from None
    wrong = numbers[~((numbers >= 0) & np.isfinite(numbers))]
    if wrong.size:
        text = f"{quote(float(wrong.flat[0]))} is out of range; must be >= 0"
        raise InvalidProblem.at(name, text)
    return numbers
