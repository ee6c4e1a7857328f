r"""A two-drum winder: loads, forces and arcs of a roll on two drums under a rider roll.

The roll rests between two drums of equal centre height; the web arrives on the rear drum and runs
below the roll to the front drum, and on to the rider roll on top::

            rider
              |
            (roll)          sin a = horizontal distance of the centres/(R + R_drum)
           a/    \b
      (rear)      (front)   arcs: rear to front a + b, front to rider pi - b

Balance of the roll with the web in its nips, per metre of width.  A drum presses with the load P_k
along the line of centres, and its traction pulls the roll back with the force F_k (F_k < 0: it
drives).  The web leaves the rear drum along the common tangent of drum and roll and pulls with
T_in - m V^2, its tension less the momentum m V^2 that it brings to the roll; the roll takes up its
moment of momentum, so that the balance of moments contains T_in alone.  With a drum wrap F_1
contains the traction on it, so that T_in + F_1 is the force in either case.  M is the torque of the
core in the direction of rotation, and the rider idles, F_3 = 0:

    moment       F_1 + F_2 + F_3 = -T_in + M/R,    F_1 = -s T_in,  s the torque split
    horizontal   P_1 sin a - P_2 sin b = H cos a + F_2 cos b
    vertical     P_1 cos a + P_2 cos b = V - H sin a + F_2 sin b

with H = T_in + F_1 - m V^2, V the weight and the rider's load P_3.  The solution is

    P_1 = (V sin b + H cos(a + b) + F_2)/sin(a + b)
    P_2 = (V sin a - H - F_2 cos(a + b))/sin(a + b)
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from pydantic import Field

from ..quantities import Quantity, length, line_load, pure
from .bending import DrumBending
from .bodies import AnyBody, OptionalBody
from .description import Description
from .fields import Number, OptionalNested, OptionalNumber, default
from .messages import quote
from .permitted import Conditional
from .schedules import WindingSchedule

__all__ = ["DrumLoads", "TwoDrums"]

Array = np.ndarray

GRAVITY = 9.80665  # m/s^2, standard


class TwoDrums(Description):
    """The front drum and the rider roll of a two-drum winder; the winding's ``drum`` is the rear.

    The roll rests on two drums whose centres are equally high.  The nip load of the rear drum, the
    load and the winding force of the front drum and the arcs between the nips follow from the
    weight of the roll, the load of the rider and the torque split.

    Parameters
    ----------
    front_drum : Rigid, HalfPlane, Cylinder or another Body
    gap : float
        Between the surfaces of the drums [m].
    rider_load : float, Taper, Steps or Profile
        Vertical load of the rider roll, or another downward force on the roll, over its radius
        [N/m].
    rider : Body, optional
        The rider roll, which idles.  Without it the load presses the roll onto the drums, but its
        nip is not solved.
    core_torque : float, Taper, Steps or Profile
        Torque of a core drive per metre of width [N], > 0 in the direction of rotation.
    front_friction, rider_friction : float, optional
        Coefficients of friction of web and front drum, web and rider; by default the winding's
        ``drum_friction``.
    core_mass : float
        Mass of core and shaft per metre of width [kg/m].
    front_bending, rider_bending : DrumBending, optional
        Bending and crown of front drum and rider across the width; with a thickness profile.

    Raises
    ------
    InvalidProblem
        For a value out of range.

    Examples
    --------
    >>> import woundon as wo
    >>> winder = wo.TwoDrums(front_drum=wo.Rigid(radius=0.25), gap="20 mm", rider_load="1.5 kN/m")
    >>> winding = wo.WindingProblem.example().replace(
    ...     winder=winder, drum=wo.Rigid(radius=0.3), nip_load=None, torque_split=0.5
    ... )
    >>> loads = winding.drum_loads(0.5)
    >>> f"{loads.rear_load:.0f} and {loads.front_load:.0f} N/m, arc {loads.front_arc:.2f} rad"
    '2784 and 4273 N/m, arc 0.75 rad'
    """

    front_drum: Annotated[AnyBody, Field(description="the front drum")]
    gap: Annotated[
        Number,
        length("g", "gap between the surfaces of the drums", typical=(0.005, 0.05)),
        Field(ge=0, le=10),
    ]
    rider_load: Annotated[
        WindingSchedule, line_load("P_3", "load of the rider roll on the roll", (0.0, 6e3))
    ]
    rider: Annotated[OptionalBody, Field(description="the rider roll, which idles")] = default(None)
    core_torque: Annotated[
        WindingSchedule,
        Quantity("M_c", "N", "torque of the core per width, > 0: it drives", typical=(0.0, 200.0)),
    ] = default(0.0)
    front_friction: Annotated[
        OptionalNumber,
        pure("mu_2-", "friction coefficient of web and front drum", (0.1, 0.6)),
        Field(ge=1e-8, le=10.0),
        Conditional("default: drum_friction"),
    ] = default(None)
    rider_friction: Annotated[
        OptionalNumber,
        pure("mu_3-", "friction coefficient of web and rider roll", (0.1, 0.6)),
        Field(ge=1e-8, le=10.0),
        Conditional("default: drum_friction"),
    ] = default(None)
    core_mass: Annotated[
        Number,
        Quantity("m_c", "kg/m", "mass of core and shaft, per width", typical=(0.0, 50.0)),
        Field(ge=0, le=1e5),
    ] = default(0.0)
    front_bending: Annotated[
        OptionalNested[DrumBending],
        Field(description="bending and crown of the front drum"),
        Conditional("only with thickness_profile"),
    ] = default(None)
    rider_bending: Annotated[
        OptionalNested[DrumBending],
        Field(description="bending and crown of the rider roll"),
        Conditional("only with thickness_profile"),
    ] = default(None)

    def geometry_faults(
        self, rear_radius: float, smallest: float, largest: float
    ) -> Iterator[tuple[str, str]]:
        """Yield (field, message) if the roll does not rest between the drums and below the rider.

        Parameters
        ----------
        rear_radius : float
            Radius of the rear drum [m].
        smallest, largest : float
            Radii of the roll when the winding begins and ends [m].
        """
        rear, front, gap = rear_radius, self.front_drum.radius, self.gap
        if gap >= 2 * smallest:
            yield (
                "winder.gap",
                f"{quote(gap)} is out of range; must be < 2 core.radius = {2 * smallest:.6g} [m], "
                "or the core falls between the drums",
            )
            return
        if rear != front:
            # the radius of a roll whose centre is vertically above that of the smaller drum
            distance, small, large = rear + front + gap, *sorted((rear, front))
            end = (distance**2 + small**2 - large**2) / (2 * (large - small))
            if largest >= end:
                yield (
                    "radius",
                    f"{quote(largest)} is out of range; must be < {end:.6g} [m], or the roll rolls "
                    "off the smaller drum",
                )
                return
        if self.rider is None:
            return
        a, b = angles_at_drums(np.array(smallest), rear, front, gap)
        for name, radius, angle in (("drum", rear, a), ("winder.front_drum", front, b)):
            # horizontal distance of drum and rider, and height of the drum's highest place below
            # the top of the core, on which the rider lies
            side = float((smallest + radius) * np.sin(angle))
            height = float((smallest + radius) * np.cos(angle)) + smallest - radius
            if height >= 0:  # no part of the drum is higher than the top of the core
                continue
            end = (side**2 + height * (height + 2 * radius)) / (-2 * height)
            if self.rider.radius >= end:
                yield (
                    "winder.rider.radius",
                    f"{quote(self.rider.radius)} is out of range; must be < {end:.6g} [m], or the "
                    f"rider touches {name} at the radius {smallest:.6g} [m]",
                )


@dataclass(frozen=True, eq=False)
class DrumLoads:
    """Loads, forces and angles of a two-drum winder over the radius of the roll.

    Attributes
    ----------
    radius : (k,) array
        Of the roll [m]; all other arrays have the same shape, which may be ().
    rear_load, front_load, rider_load : (k,) arrays
        P_1, P_2, P_3: loads of the nips [N/m].
    rear_force, front_force : (k,) arrays
        F_1, F_2: winding forces of the drums, < 0: the drum drives [N/m].
    weight : (k,) array
        Of roll and core [N/m].
    rear_angle, front_angle : (k,) arrays
        a, b: angles between the vertical and the lines of centres of roll and drums [rad].
    """

    radius: Array
    rear_load: Array
    front_load: Array
    rider_load: Array
    rear_force: Array
    front_force: Array
    weight: Array
    rear_angle: Array
    front_angle: Array

    @property
    def front_arc(self) -> Array:
        """Arc of the web on the roll from the rear to the front drum, a + b [rad]."""
        return self.rear_angle + self.front_angle

    @property
    def rider_arc(self) -> Array:
        """Arc of the web on the roll from the front drum to the rider roll, pi - b [rad]."""
        return np.pi - self.front_angle

    @property
    def returning_arc(self) -> Array:
        """Arc from the rider, or the top of the roll, on to the rear drum, pi - a [rad]."""
        return np.pi - self.rear_angle


def balanced_loads(
    radius: Array,
    drum_radii: tuple[float, float],
    gap: float,
    weight: Array,
    rider_load: Array,
    web_tension: Array,
    centrifugal: float,
    rear_force: Array,
    core_force: Array,
) -> DrumLoads:
    """Return the loads and forces of the balance at the head of this file, an idling rider.

    Parameters
    ----------
    radius : (k,) array
        R of the roll [m].
    drum_radii : (float, float)
        Of the rear and the front drum [m].
    gap : float
        Between the drums [m].
    weight, rider_load, web_tension, rear_force : (k,) arrays
        W, P_3, T_in and F_1 [N/m].
    centrifugal : float
        m V^2 [N/m].
    core_force : (k,) array
        M/R, force of the core torque at the surface of the roll [N/m].
    """
    a, b = angles_at_drums(radius, *drum_radii, gap)
    front_force = core_force - web_tension - rear_force
    down, back = weight + rider_load, web_tension + rear_force - centrifugal  # V and H
    arc = a + b
    return DrumLoads(
        radius=radius,
        rear_load=(down * np.sin(b) + back * np.cos(arc) + front_force) / np.sin(arc),
        front_load=(down * np.sin(a) - back - front_force * np.cos(arc)) / np.sin(arc),
        rider_load=rider_load,
        rear_force=rear_force,
        front_force=front_force,
        weight=weight,
        rear_angle=a,
        front_angle=b,
    )


def angles_at_drums(
    radius: Array, rear_radius: float, front_radius: float, gap: float
) -> tuple[Array, Array]:
    """Return the angles a, b of the lines of centres from the vertical [rad].

    The centres of roll, rear and front drum form a triangle, whose lower side is horizontal.
    ``radius`` is that of the roll, (k,) [m].
    """
    distance = rear_radius + front_radius + gap
    to_rear, to_front = radius + rear_radius, radius + front_radius  # other sides of the triangle
    # horizontal distance of the roll's centre from that of the rear drum
    x = (distance**2 + to_rear**2 - to_front**2) / (2 * distance)
    return np.arcsin(x / to_rear), np.arcsin((distance - x) / to_front)


def roll_weight(radius: Array, core_radius: float, density: float, core_mass: float) -> Array:
    """Return the weight of roll and core per metre of width at radii of the roll, (k,) [N/m].

    ``density`` is that of the web [kg/m^3], ``core_mass`` that of core and shaft [kg/m].
    """
    return GRAVITY * (np.pi * density * (radius**2 - core_radius**2) + core_mass)
