"""The fields of the result of a winding."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated

import numpy as np

from ..problems.winding import WindingProblem
from ..quantities import length, line_load, pure, share, stress
from ..results import Result
from ..roll.lane_roll import LaneRoll, WithLanes
from ..roll.result import RollResult, WithRoll
from .bodies import NipSample
from .drives import Drive
from .drum_nips import DrumNips
from .roll import wind

__all__ = ["WindingFields"]

Array = np.ndarray


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class WindingFields(WithRoll, WithLanes, Result):
    """The fields of a :class:`.WindingResult`, which describes them, and its wound roll.

    They are what the functions of its outputs use.  The result imports these functions, so that
    they cannot name its class.
    """

    problem: WindingProblem
    radius: Annotated[Array, length("r", "radius")]
    web_tension: Annotated[Array, line_load("T_in", "web tension upstream of the nip")]
    nip_load: Annotated[Array, line_load("P", "nip load")]
    winding_force: Annotated[Array, line_load("F", "winding force")]
    nip_induced_tension: Annotated[Array, line_load("NIT", "nip-induced tension, WOT - T_in")]
    wound_on_tension: Annotated[Array, line_load("WOT", "wound-on tension")]
    nip_radius: Annotated[Array, length("r_k", "radii of the solved nips")]
    nip_wound_on_tension: Annotated[Array, line_load("WOT_k", "wound-on tension of each nip")]
    nip_departure: Annotated[
        Array, line_load("dWOT_k", "wound-on tension minus that of the smoothed schedule")
    ]
    nip_half_width: Annotated[Array, length("a_k", "half-width of each nip")]
    nip_peak_pressure: Annotated[Array, stress("p_max,k", "peak pressure of each nip")]
    nip_effective_pressure: Annotated[
        Array, stress("P_e,k", "pressure used to evaluate the effective radial modulus")
    ]
    nip_air_film: Annotated[Array, length("h_k", "entrained air film at each nip", "um")]
    nip_friction: Annotated[
        Array, pure("mu+_k", "effective friction coefficient with entrained air")
    ]
    air_film: Annotated[float, length("h", "air film between the layers", "um")]
    nip_error: Annotated[
        Array, line_load("WOT_k error", "estimated error of the wound-on tension of each nip")
    ]
    nip_residual: Annotated[Array, pure("r_k", "largest contact residual of each nip")]
    interpolation_error: Annotated[
        float, share("e_i", "relative interpolation error of the wound-on tension")
    ]
    nodes: Annotated[int, pure("N", "number of nodes of each nip")]
    roll_rtol: Annotated[float, pure("rtol", "relative tolerance of the pressure in the roll")]
    coupling_rtol: Annotated[float, pure("e_c", "relative tolerance of the nip-roll iteration")]
    nips_solved: Annotated[int, pure("n_nip", "number of solved nips")] = 0
    core_interpolation_error: Annotated[
        float, share("e_ic", "relative interpolation error near the core")
    ] = 0.0
    front: DrumNips | None = None
    rider: DrumNips | None = None
    drive_radius: Annotated[Array, length("r_d", "radii at which the drives are computed")] = field(
        default_factory=lambda: np.zeros(0)
    )
    core_drive: Drive | None = None
    drum_drive: Drive | None = None
    front_drive: Drive | None = None
    wound: RollResult | None = field(default=None, compare=False, metadata={"saved": False})
    nips: tuple[NipSample, ...] = field(default=(), compare=False, metadata={"saved": False})
    lane_count: Annotated[int, pure("L", "number of lanes across the width")] = 0
    lane_roll: LaneRoll | None = field(default=None, compare=False, metadata={"saved": False})

    @property
    def roll(self) -> RollResult:
        """The finished roll; its method ``at`` returns stages of the build-up.

        For a loaded result the roll is recomputed.
        """
        if self.wound is None:
            arrays = self.radius, self.wound_on_tension
            uncertified = wind(self.problem, *arrays, self.roll_rtol, self.air_film)
            object.__setattr__(self, "wound", uncertified.certified())
        assert self.wound is not None
        return self.wound
