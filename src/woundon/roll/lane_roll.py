"""The lanes of a finished roll: arrays, and the worst lane."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import numpy as np

from ..errors import InvalidProblem
from ..problems.roll import RollProblem
from ..problems.thickness_profile import Lanes
from ..problems.winding import WindingProblem
from ..quantities import Quantity, length, line_load, on_request, share, strain, stress

if TYPE_CHECKING:
    import xarray

__all__ = [
    "FEWEST_LANES",
    "LANES",
    "LANE_QUANTITIES",
    "MOST_LANES",
    "NIP_LOADS",
    "POSITION",
    "LaneRoll",
    "WithLanes",
    "WorstLane",
    "edges_of_lanes",
    "slack_lanes",
]

Array = np.ndarray

FEWEST_LANES, MOST_LANES = 4, 1000
LANES = 50  # by default: they resolve smooth profiles to 0.1 % of the tension
SLACK = 1e-9  # of the mean tension: a lane with less is slack

PRESSURES = ("pressure", "core_pressure", "compression")  # among the worst values
POSITION = length("y", "position across the web")
# Loads of the nips in the direction of travel.
NIP_LOADS = ("nip_load", "front_load", "rider_load")
# Variables of the lanes over radius and position; those of the front drum and the rider only on a
# two-drum winder whose nips are solved, deflections only of beams that the problem has, pressure
# and stress as wound only of a roll that is changed after winding.
LANE_QUANTITIES: Mapping[str, Quantity] = {
    "pressure": stress("P_j", "pressure between the layers of a lane"),
    "hoop_stress": stress("sigma_t,j", "hoop (MD) stress of a lane, > 0: tension"),
    "pressure_as_wound": stress("P_j,0", "pressure between the layers of a lane, as wound"),
    "hoop_stress_as_wound": stress("sigma_t,j,0", "hoop (MD) stress of a lane, as wound"),
    "wound_on_tension": line_load("WOT_j", "wound-on tension of a lane"),
    "web_tension": line_load("T_in,j", "web tension of a lane, upstream of the nip"),
    "nip_load": line_load("P_N,j", "nip load on a lane"),
    "front_load": line_load("P_2", "load of the front drum on a lane"),
    "rider_load": line_load("P_3", "load of the rider roll on a lane"),
    "drum_deflection": length("w_d", "deflection of the drum away from the roll", "um"),
    "core_deflection": length("w_c", "deflection of the core away from the drum", "um"),
    "front_deflection": length("w_2", "deflection of the front drum away from the roll", "um"),
    "rider_deflection": length("w_3", "deflection of the rider away from the roll", "um"),
    "ridge_height": length("dR_j", "height of the surface of a lane over the mean one", "um"),
    "band_strain": strain("eps_j", "strain along the web of a lane as wound"),
}


@dataclass(frozen=True)
class WorstLane:
    """The worst values of all lanes of the finished roll, each of another lane perhaps.

    Examples
    --------
    >>> import woundon as wo
    >>> profile = wo.ThicknessProfile(position=[0, 1, 2], thickness=[0.995, 1.005, 0.995])
    >>> result = wo.solve(wo.RollProblem.example().replace(thickness_profile=profile), lanes=20)
    >>> result.worst_lane.pressure > result.peak_pressure
    True
    """

    part_of_result: ClassVar[bool] = True

    pressure: Annotated[float, stress("P_w", "largest pressure in a lane")]
    core_pressure: Annotated[float, stress("P_c,w", "largest pressure of a lane on the core")]
    compression: Annotated[float, stress("S_w", "largest hoop (MD) compression of a lane")]
    tension: Annotated[float, line_load("WOT_w", "largest wound-on tension of a lane")]
    least_tension: Annotated[float, line_load("WOT_l", "smallest wound-on tension of a lane")]
    strain: Annotated[float, strain("eps_w", "largest strain along the web of a lane as wound")]
    ridge_height: Annotated[
        float, length("dR_w", "height of the highest lane over the mean surface", "um")
    ]
    slack_share: Annotated[float, share("s_w", "part of the width that is slack at some radius")]


@dataclass(frozen=True, eq=False)
class LaneRoll:
    """The lanes of a finished roll.

    Attributes
    ----------
    lanes : Lanes
    radius : (M,) array
        Of the layers in the mean roll [m].
    pressure, hoop_stress, wound_on_tension, web_tension, nip_load, ridge_height, band_strain
        (L, M) arrays, see :data:`LANE_QUANTITIES` [SI].
    further : mapping of str to (L, M) array
        Loads of further nips, deflections, and pressure and hoop stress before the changes after
        winding, by the names of :data:`LANE_QUANTITIES`.
    stages : int
        Number of stages of the build-up.
    stage_error : float
        Largest error estimate of a stage, relative to kappa + 2 and to the mean tension.
    errors : mapping of str to float
        Estimated errors of the worst values, by the name of the output [SI].
    warnings : tuple of str
        Warnings about the lanes.
    """

    lanes: Lanes
    radius: Array
    pressure: Array
    hoop_stress: Array
    wound_on_tension: Array
    web_tension: Array
    nip_load: Array
    ridge_height: Array
    band_strain: Array
    stages: int
    stage_error: float
    further: Mapping[str, Array] = field(default_factory=dict)
    errors: Mapping[str, float] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()

    @property
    def arrays(self) -> dict[str, Array]:
        """The variables over lanes and radius that the roll has, (L, M) arrays, by name."""
        own = {name: getattr(self, name) for name in LANE_QUANTITIES if hasattr(self, name)}
        return {**own, **self.further}

    @cached_property
    def worst(self) -> WorstLane:
        """The worst values of all lanes."""
        slack = slack_lanes(self.lanes.share, self.wound_on_tension)
        return WorstLane(
            pressure=float(np.max(self.pressure)),
            core_pressure=float(np.max(self.pressure[:, 0])),
            compression=float(np.max(-self.hoop_stress)),
            tension=float(np.max(self.wound_on_tension)),
            # interpolated between the stages, the tension of a slack lane is zero up to its error
            least_tension=max(0.0, float(np.min(self.wound_on_tension))),
            strain=float(np.max(self.band_strain)),
            ridge_height=float(np.max(self.ridge_height[:, -1])),
            slack_share=float(np.sum(self.lanes.share[slack])),
        )

    def of_lanes(self, lanes: Lanes) -> LaneRoll:
        """Return the first lanes, which are ``lanes``."""
        count = lanes.share.size
        further = {name: values[:count] for name, values in self.further.items()}
        own: dict[str, Any] = {
            name: values[:count] for name, values in self.arrays.items() if name not in further
        }
        return replace(self, lanes=lanes, **own, further=further)

    def with_layer_error(self, error: float) -> LaneRoll:
        """Return the lanes with the error by the thickness of the layers in their estimates.

        ``error`` is that of the pressure of the mean roll, relative to the largest; the tension, a
        property of the surface, hardly depends on it.
        """
        errors = dict(self.errors)
        for name in PRESSURES:
            errors[f"worst_lane.{name}"] += error * getattr(self.worst, name)
        return replace(self, errors=errors)

    def dataset(self) -> xarray.Dataset:
        """Return the lanes as an xarray Dataset over radius and position; see RollResult.lanes."""
        import xarray

        variables = {
            name: (("radius", "position"), values.T, LANE_QUANTITIES[name].attributes)
            for name, values in self.arrays.items()
        }
        across = {
            "share": ("position", self.lanes.share, {"units": "1"}),
            "thickness_excess": ("position", self.lanes.excess, {"units": "1"}),
            "slack": ("position", self.lanes.slack, {"units": "1"}),
        }
        places = {
            "radius": ("radius", self.radius, {"units": "m"}),
            "position": ("position", self.lanes.position, {"units": "m"}),
        }
        return xarray.Dataset({**variables, **across}, places)


def edges_of_lanes(position: Array) -> Array:
    """Return the edges of L lanes next to each other from their middles [m], (L + 1,)."""
    half = (position[1] - position[0]) / 2
    return np.append(position - half, position[-1] + half)


def slack_lanes(share: Array, tension: Array) -> Array:
    """Return whether lanes have no tension at some radius, (L,) bool array.

    Parameters
    ----------
    share : (L,) array
        Fraction of the width.
    tension : (L, M) array
        Wound-on tension [N/m].
    """
    mean = float(np.max(share @ tension))
    return np.asarray((tension <= SLACK * mean).any(axis=1))


class WithLanes:
    """Base class of a result that has lanes if its problem has a thickness profile."""

    problem: RollProblem | WindingProblem
    lane_roll: LaneRoll | None
    lane_count: int

    def check_lane_count(self) -> None:
        """Reject a number of lanes that no solution has.

        Raises
        ------
        InvalidProblem
        """
        has_lanes = self.problem.thickness_profile is not None
        if self.lane_count and not (has_lanes and FEWEST_LANES <= self.lane_count <= MOST_LANES):
            must = f"0, or {FEWEST_LANES} to {MOST_LANES}" if has_lanes else "0"
            text = f"{self.lane_count} is out of range; must be {must}"
            raise InvalidProblem.at("lane_count", text)

    @property
    def lanes(self) -> xarray.Dataset | None:
        """The lanes across the width over the radius; None without a thickness profile.

        Variables over (``radius``, ``position``), in SI units: ``pressure`` and ``hoop_stress``
        [Pa], ``wound_on_tension``, ``web_tension`` and ``nip_load`` per width of the lane [N/m],
        ``ridge_height`` of the surface over the mean one [m], ``band_strain`` of the web as wound
        [1]; on a two-drum winder also ``front_load`` and ``rider_load`` [N/m]; where the problem
        has beams, ``drum_deflection``, ``core_deflection``, ``front_deflection`` and
        ``rider_deflection`` from the bearings [m]; of a roll that is changed after winding
        ``pressure_as_wound`` and ``hoop_stress_as_wound`` [Pa]; over ``position`` ``share``,
        ``thickness_excess`` and ``slack`` [1].  A radius is that of the same layer in the mean
        roll.
        """
        return None if (lanes := self._lanes()) is None else lanes.dataset()

    @on_request
    def worst_lane(self) -> WorstLane | None:
        """The worst values of all lanes; None without a thickness profile.

        Files do not contain them: those of a loaded result are recomputed, in a winding
        with a few of the nips.
        """
        return None if (lanes := self._lanes()) is None else lanes.worst

    def recompute_lanes(self) -> LaneRoll:
        """Solve for the lanes of a result that was loaded from a file."""
        raise NotImplementedError

    def _lanes(self) -> LaneRoll | None:
        """Return the lanes, recomputed for a loaded result; None without a thickness profile."""
        if self.lane_roll is None and self.problem.thickness_profile is not None:
            object.__setattr__(self, "lane_roll", self.recompute_lanes())
        return self.lane_roll
