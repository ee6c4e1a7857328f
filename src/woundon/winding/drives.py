r"""Torque and power of the drives of core and drums over the radius of the roll.

The web arrives at the surface of the roll, of the radius r, with the speed V and the momentum V per
mass.  The moment of momentum of web and core about the axis of the roll, J omega with

    J = J_c + pi/2 rho w (r^4 - r_c^4),    omega = V/r,    dJ/dt = rho w t V r^2,

t the thickness of a layer, increases by the moment of the core drive M_c, of the web upstream, T_in
w r, of the forces F_k w of the drums, which pull the roll back, and of the momentum that the web
brings, rho w t V V r.  The latter equals omega dJ/dt, so that

    M_c = (T_in + sum F_k) w r + J domega/dt,    domega/dt = a/r - V^2 t/(2 pi r^3),

with dr/dt = t V/(2 pi r).  Growth slows the roll down: at constant web speed its inertia drives it.
A drum of the radius R_k and the inertia J_k has M_k = -F_k w R_k + J_k a/R_k.  The rider idles; its
acceleration takes the force J_3 a/R_3^2 from the roll.

The core drive moves the inertia of roll and core alone.  Where the drums drive the roll, because
there is no core drive or its torque is given (two-drum winders), they share it as they share the
web tension.  The sum of the powers is T_in V w + J omega domega/dt at constant speed, and
T_in V w without inertia.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from typing import Annotated, ClassVar, NamedTuple

import numpy as np

from ..problems.inertia import Inertia
from ..problems.winding import WindingProblem
from ..quantities import Quantity
from ..results import ReadOnly
from .criteria import ring_inertia

__all__ = ["DRIVES", "Drive", "drive_radii", "drives_of"]

Array = np.ndarray
RADII = 65  # in geometric progression, in addition to the kinks of the schedules
DRIVES = ("core_drive", "drum_drive", "front_drive")  # outputs of a winding
NO_DRIVE = 1e-9  # core torque, relative to that of the web tension, below which the core idles


@dataclass(frozen=True, eq=False, kw_only=True)
class Drive(ReadOnly):
    """Torque and power of the drive of the core or of a drum, over the radius of the roll.

    All arrays are (K,), along ``drive_radius`` of the winding, and of the whole width.  Torques and
    powers are > 0 if the drive drives, < 0 if it brakes.  Gears, bearings and rolling resistance
    are not included.

    Attributes
    ----------
    speed : array
        Angular speed of core or drum [rad/s].
    torque : array
        At constant web speed [N m].
    acceleration_torque : array
        Additional torque while the web speed increases by ``limits.acceleration`` [N m]; the same
        with the opposite sign while it decreases.
    power : array
        At constant web speed [W].

    Examples
    --------
    >>> import woundon as wo
    >>> problem = wo.WindingProblem.example().replace(
    ...     radius=0.12, tension_law="friction", width="2 m", web_speed="10 m/s"
    ... )
    >>> core = wo.solve(problem, rtol=0.01).core_drive  # 350 N/m at the core of 0.05 m
    >>> f"{core.torque[0]:.1f} N m, {core.power[0]:.0f} W"
    '35.0 N m, 7000 W'
    """

    part_of_result: ClassVar[bool] = True

    speed: Annotated[Array, Quantity("omega_k", "rad/s", "speed of this drive", "rpm")]
    torque: Annotated[Array, Quantity("M_k", "N*m", "torque of this drive at constant speed")]
    acceleration_torque: Annotated[
        Array, Quantity("M_a,k", "N*m", "additional torque of this drive for the acceleration")
    ]
    power: Annotated[Array, Quantity("W_k", "W", "power of this drive at constant speed", "kW")]

    @property
    def _largest_torques(self) -> Array:
        """Largest magnitude of the torque at each radius, speeding up and slowing down, (K,)."""
        return np.asarray(np.abs(self.torque) + np.abs(self.acceleration_torque))

    @property
    def largest_torque(
        self,
    ) -> Annotated[float, Quantity("M_k,max", "N*m", "largest torque of this drive")]:
        """Largest magnitude of the torque at constant speed, speeding up and slowing down [N m]."""
        return float(np.max(self._largest_torques))

    @property
    def largest_power(
        self,
    ) -> Annotated[float, Quantity("W_k,max", "W", "largest power of this drive", "kW")]:
        """Largest magnitude of the power at constant speed, speeding up and slowing down [W]."""
        return float(np.max(self._largest_torques * self.speed))


def drive_radii(problem: WindingProblem) -> Array:
    """Return the radii at which the drives are computed [m]; empty if they are not, (K,).

    They are closer at the core, where the growth of the roll changes its speed fast.
    """
    if problem.width is None or not problem.web_speed:
        return np.zeros(0)
    return np.union1d(np.geomspace(*problem.ends, RADII)[1:-1], problem.radii(2))


def drives_of(problem: WindingProblem, r: Array, film: float) -> dict[str, Drive | None]:
    """Return the drives of a winding by the name of the output: None for a drive it does not have.

    Without the width of the web and its speed there are none.

    Parameters
    ----------
    problem : WindingProblem
    r : (K,) array
        Radii of the roll [m].
    film : float
        Air film between the layers [m].
    """
    drives: dict[str, Drive | None] = dict.fromkeys(DRIVES)
    speed, width = problem.web_speed, problem.width
    if width is None or not speed:
        return drives
    web_moment = problem.at("web_tension", r) * r * width
    drums = _drums(problem, r)
    winder, rider = problem.winder, 0.0
    if winder is None:
        core = web_moment + problem.at("winding_force", r) * r * width
    else:
        core = problem.at("winder.core_torque", r) * width
        if winder.rider is not None:  # an idler: the roll accelerates it, by the force rider [N]
            rider = _inertia(problem).rider * problem.limits.acceleration / winder.rider.radius**2
    growth, acceleration = _moments_of_inertia(problem, r, film)
    acceleration = acceleration + rider * r
    has_core_drive = bool(np.any(np.abs(core) > NO_DRIVE * web_moment))
    # the core drive turns the inertia of the roll, unless the roll lies on two driven drums
    core_share = 1.0 if winder is None and has_core_drive else 0.0
    if has_core_drive:
        torque = core + core_share * growth
        drives["core_drive"] = Drive(
            speed=speed / r,
            torque=torque,
            acceleration_torque=core_share * acceleration,
            power=torque * speed / r,
        )
    for name, drum in drums.items():
        # torque of the drum per torque on the roll
        arm = drum.radius / r * drum.share * (1 - core_share)
        own = drum.inertia * problem.limits.acceleration / drum.radius
        torque = -drum.force * width * drum.radius + arm * growth
        drives[name] = Drive(
            speed=np.full_like(r, speed / drum.radius),
            torque=torque,
            acceleration_torque=own + arm * acceleration,
            power=torque * speed / drum.radius,
        )
    return drives


class _Drum(NamedTuple):
    """A driven drum over the radius of the roll.

    Attributes
    ----------
    radius, inertia : float
        [m], [kg m^2].
    force, share : (K,) arrays
        Winding force [N/m], and the share of the roll's inertia that it moves if there is no core
        drive [1].
    """

    radius: float
    inertia: float
    force: Array
    share: Array


def _drums(problem: WindingProblem, r: Array) -> dict[str, _Drum]:
    """Return the driven drums at radii of the roll (K,) [m], by the name of the output."""
    if not problem.has_nip:
        return {}
    inertia = _inertia(problem)
    rear_force = problem.at("winding_force", r)
    rear_share = np.ones_like(r)
    drums = {}
    if problem.winder is not None:
        rear_share = np.clip(problem.curve("torque_split").at(r), 0.0, 1.0)
        front_force = problem.drum_loads(r).front_force
        radius = problem.winder.front_drum.radius
        drums["front_drive"] = _Drum(radius, inertia.front_drum, front_force, 1 - rear_share)
    drums["drum_drive"] = _Drum(problem.drum_radius, inertia.drum, rear_force, rear_share)
    return drums


def _inertia(problem: WindingProblem) -> Inertia:
    """Return the moments of inertia of core and drums, 0 if they are not given."""
    return problem.inertia or Inertia()


def _moments_of_inertia(problem: WindingProblem, r: Array, film: float) -> tuple[Array, Array]:
    """Return J domega/dt of web and core at radii (K,) [N m]: by the growth, by the acceleration.

    That of the web is zero without its density.  ``film`` is the air between the layers [m].
    """
    V, width = problem.web_speed, problem.width
    assert V is not None
    assert width is not None
    a, web = problem.limits.acceleration, problem.web.thickness
    layer = web + film
    density = (problem.density or 0.0) * web / layer
    J = _inertia(problem).core + width * ring_inertia(problem.core.radius, r, density)
    return -J * V**2 * layer / (2 * pi * r**3), J * a / r
