"""The fields of the result of a wound roll."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Annotated

import numpy as np

from ..problems.roll import RollProblem
from ..quantities import length, pure, share, strain, stress
from ..results import Result
from .growth import Growth
from .lane_roll import LaneRoll, WithLanes

__all__ = ["RollFields"]

Array = np.ndarray


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class RollFields(WithLanes, Result):
    """The fields of a :class:`.RollResult`, which describes them, for the functions of its outputs.

    The result imports these functions, so that they cannot name its class.
    """

    problem: RollProblem
    radius: Annotated[Array, length("r", "radius")]
    pressure: Annotated[Array, stress("P", "pressure between the layers")]
    hoop_stress: Annotated[Array, stress("sigma_t", "hoop (MD) stress, > 0: tension")]
    displacement: Annotated[
        Array, length("u", "outward displacement of a layer since it was wound", "um")
    ]
    layer_strain: Annotated[Array, strain("eps_t", "strain of the layers along the web")]
    radial_modulus: Annotated[Array, stress("E_r", "radial modulus of the stack", "MPa")]
    source: Annotated[Array, stress("C", "source term of the layers as wound", "MPa")]
    pressure_gradient: Annotated[Array, stress("rP'", "radius times the pressure gradient")]
    stage_radius: Annotated[Array, length("s", "outer radius at the stages of the build-up")]
    growth: Annotated[Array, pure("kappa", "growth of a layer's pressure below the surface")]
    stage_order: Annotated[
        Array, pure("n_k", "order of the interpolation of the growth factor"), int
    ]
    thin_layer_growth: Annotated[
        Array, pure("kappa_0", "growth of a layer's pressure, limit of thin layers")
    ]
    surface_slope: Annotated[float, share("e_s", "relative error of the slope at the surface")]
    steps: Annotated[int, pure("n_it", "number of linear systems solved")] = 0
    lane_count: Annotated[int, pure("L", "number of lanes across the width")] = 0
    lane_roll: LaneRoll | None = field(default=None, compare=False, metadata={"saved": False})

    @property
    def is_off_core(self) -> bool:
        """True if the roll does not touch its core: it is removed, or has shrunk away."""
        return self.problem.core_removed or self.pressure[0] == 0

    @cached_property
    def kappa(self) -> Growth:
        """Kappa as a function of ln r."""
        return Growth.of(np.log(self.stage_radius), self.growth, self.stage_order)

    @cached_property
    def thin_layer_kappa(self) -> Growth:
        """Kappa as a function of ln r in the limit of thin layers."""
        return Growth.of(np.log(self.stage_radius), self.thin_layer_growth, self.stage_order)
