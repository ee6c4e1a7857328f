"""Result of a winding: the wound-on tension over the radius and the wound roll."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from types import MappingProxyType
from typing import Annotated, ClassVar

import numpy as np

from ..quantities import length, line_load
from ..results import Residuals
from ..roll.density import mean_over_length
from ..roll.lane_roll import LANES, LaneRoll
from .certificate import certificate, recomputed_nips
from .drives import DRIVES, Drive
from .drum_nips import DrumNips
from .margins import WithMargins

__all__ = ["WindingResult"]

Array = np.ndarray


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class WindingResult(WithMargins):
    """Loads and tensions of a winding over the radius, with its nips and the wound roll.

    Arrays of length M are piecewise linear functions of the radius.  Arrays of length n belong to
    the solved nips; n = 0 if the tension law needs no nips.

    Attributes
    ----------
    problem : WindingProblem
    radius : (M,) array
        From the core to the surface [m].
    web_tension, nip_load, winding_force : (M,) arrays
        T_in, P, F [N/m].
    nip_induced_tension, wound_on_tension : (M,) arrays
        NIT = WOT - T_in, and WOT [N/m].
    nip_radius, nip_wound_on_tension, nip_half_width, nip_peak_pressure : (n,) arrays
        Solved nips [m], [N/m], [m], [Pa].
    nip_departure : (n,) array
        Wound-on tension minus that of the nips, which are solved with smoothed schedules if those
        of the problem fluctuate; otherwise 0 [N/m].
    nip_effective_pressure : (n,) array
        P_e at which the moduli of an effective roll are evaluated [Pa]; nan for other roll bodies.
    nip_air_film, nip_friction : (n,) arrays
        Entrained air film at ambient pressure [m], and the effective friction with this air [1].
    air_film : float
        Air film between the layers: mean of the films over the length of web [m].
    nip_error, nip_residual : (n,) arrays
        Estimated discretisation error [N/m], and largest contact residual [1].
    interpolation_error, core_interpolation_error : float
        Relative interpolation error of the wound-on tension, and that within 5 % of the core radius
        from the core [1].
    front, rider : DrumNips or None
        Nips of the front drum and of the rider of a two-drum winder, at the radii of the solved
        nips; None without a winder, a rider or nips.
    drive_radius : (K,) array
        Radii at which the drives are computed [m]; empty without ``width`` and ``web_speed``.
    core_drive, drum_drive, front_drive : Drive or None
        Torque and power of the drives of core, winding (rear) drum and front drum; None without
        this drive, or without ``width`` and ``web_speed``.
    nodes, nips_solved : int
        Number of nodes of each nip; number of nips solved in all iterations.
    roll_rtol, coupling_rtol : float
        Requested relative tolerances of the pressure in the roll, and of the nip-roll iteration
        [1].
    nips : tuple of NipSample
        The solved nips, for warm starts of neighbouring windings; empty after loading.
    lane_count : int
        Number of lanes across the width; 0 without a thickness profile.
    lane_roll : LaneRoll, optional
        The lanes, if the problem has a thickness profile; recomputed for a loaded result.

    Examples
    --------
    >>> import woundon as wo
    >>> problem = wo.WindingProblem.example().replace(radius=0.12, tension_law="friction")
    >>> result = wo.solve(problem)
    >>> bool((result.wound_on_tension > result.web_tension).all())
    True
    >>> result.core_pressure == result.roll.core_pressure
    True
    """

    MAIN: ClassVar[tuple[str, ...]] = (
        "mean_wound_on_tension",
        "core_pressure",
        "mid_pressure",
        "least_hoop_stress",
    )
    REPLACED: ClassVar[Mapping[str, str]] = MappingProxyType(
        {
            "pressure": "it is the roll's, result.roll.pressure; numbers are core_pressure, "
            "mid_pressure and peak_pressure",
            "hoop_stress": "it is the roll's: result.roll.hoop_stress",
            "at": "a stage of the build-up is one of the roll: result.roll.at(radius)",
            "wound": "the roll is result.roll",
        }
    )
    MAY_BE_NAN: ClassVar[frozenset[str]] = frozenset({"nip_effective_pressure", "nip_error"})
    ALONG: ClassVar[Mapping[str, str]] = MappingProxyType(
        dict.fromkeys(
            (
                "nip_wound_on_tension",
                "nip_half_width",
                "nip_peak_pressure",
                "nip_effective_pressure",
                "nip_departure",
                "nip_error",
                "nip_residual",
                *(
                    f"{drum}.{name.name}"
                    for drum in ("front", "rider")
                    for name in fields(DrumNips)
                ),
            ),
            "nip_radius",
        )
        | dict.fromkeys(
            (f"{drive}.{name.name}" for drive in DRIVES for name in fields(Drive)), "drive_radius"
        )
    )
    ESTIMATES: ClassVar[frozenset[str]] = frozenset(
        {
            "core_interpolation_error",
            "coupling_rtol",
            "interpolation_error",
            "nip_error",
            "nip_residual",
            "nips_solved",
            "nodes",
            "roll_rtol",
        }
    )

    def recompute_lanes(self) -> LaneRoll:
        """Solve for the lanes again, with a few of the nips."""
        from .lane_nips import lanes_of_winding

        return lanes_of_winding(self, self.roll_rtol, self.lane_count or LANES)

    @property
    def mean_wound_on_tension(
        self,
    ) -> Annotated[float, line_load("WOT_m", "wound-on tension, mean over the length of web")]:
        """Mean of WOT over the web's length [N/m]."""
        return mean_over_length(self.radius, self.wound_on_tension)

    @property
    def mean_nip_induced_tension(
        self,
    ) -> Annotated[float, line_load("NIT_m", "nip-induced tension, mean over the length of web")]:
        """Mean of NIT over the web's length [N/m]."""
        return mean_over_length(self.radius, self.nip_induced_tension)

    @property
    def mean_front_added_tension(
        self,
    ) -> Annotated[float, line_load("WOT_2m", "part of WOT that the front drum adds, mean")]:
        """Mean over the web's length of the tension that the front drum adds [N/m]; else nan."""
        return self._mean_added(self.front)

    @property
    def mean_rider_added_tension(
        self,
    ) -> Annotated[float, line_load("WOT_3m", "part of WOT that the rider roll adds, mean")]:
        """Mean over the web's length of the tension that the rider adds [N/m]; else nan."""
        return self._mean_added(self.rider)

    @property
    def even_crown(
        self,
    ) -> Annotated[float, length("c_0", "crown for a uniform mean nip load of an even web", "um")]:
        """Crown of the drum that makes the nip load of an even web uniform, at its mean [m].

        The mean nip load is that over the web's length; see :meth:`.Bending.even_crown`.  nan
        without ``drum_bending``.
        """
        problem = self.problem
        if problem.drum_bending is None or problem.thickness_profile is None:
            return float("nan")
        load = mean_over_length(self.radius, self.nip_load)
        beams = [problem.drum_bending, problem.core_bending]
        width = problem.thickness_profile.width
        return float(sum(beam.even_crown(load, width) for beam in beams if beam is not None))

    def _mean_added(self, drum: DrumNips | None) -> float:
        """Return the mean over the length of web of the tension that a nip adds [N/m]."""
        if drum is None:
            return float("nan")
        return mean_over_length(self.nip_radius, drum.added_tension)

    def certified(self) -> Residuals:
        """Compute the residuals from problem and arrays."""
        self.check_lane_count()
        return certificate(self)

    def recomputed_nips(self) -> Mapping[str, tuple[Array, Array]]:
        """Return the outputs of the nips, solved again from the problem and the roll; tolerances.

        No condition of the certificate determines their widths, pressures, air films and friction.
        It takes seconds, with a direct roll a minute; a loaded result is therefore not checked by
        it.
        """
        return recomputed_nips(self)
