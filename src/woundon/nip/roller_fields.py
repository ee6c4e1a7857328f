"""The fields of the result of two rollers in contact."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import nan
from typing import Annotated

import numpy as np

from ..contact.refinement import Refinement
from ..problems.rollers import RollerProblem
from ..quantities import length, line_load, pure, share, strain, stress
from ..results import Result, Zone
from .contact_outputs import ContactOutputs

__all__ = ["RollerFields"]

Array = np.ndarray


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class RollerFields(ContactOutputs, Result):
    """The fields of a :class:`.RollerResult`, which describes them, for its certificate."""

    problem: RollerProblem
    creepage: Annotated[
        float, strain("xi", "creepage, relative speed of the lower minus the upper roller")
    ]
    shift: Annotated[
        float, length("s", "tangential displacement of the lower roller (static contact)", "um")
    ] = nan
    tangential_load: Annotated[float, line_load("Q", "tangential load on the upper roller")]
    half_width: Annotated[float, length("a", "half-width of the contact")]
    approach: Annotated[float, length("delta", "centre approach of the rollers")]
    offset: Annotated[
        float, length("Delta", "offset of the line of centres from the contact centre")
    ]
    x: Annotated[Array, length("x", "position along the contact, [-a, a]")]
    pressure: Annotated[Array, stress("p", "pressure", "MPa")]
    traction: Annotated[Array, stress("q", "traction on the upper roller", "MPa")]
    slip_x: Annotated[Array, length("x_v", "positions at which slip is evaluated")]
    slip: Annotated[
        Array, strain("v", "slip, > 0: lower surface faster (static contact: slip distance)")
    ]
    zone: Annotated[
        Array, pure("z", "zone: 0 stick; slip: 1 lower surface faster, -1 slower"), Zone
    ]
    traction_error: Annotated[
        float, share("e_q", "estimated error of the traction (L2), relative")
    ] = nan
    iterations: Annotated[int, pure("n_it", "number of Newton iterations")] = 0
    refinement: Refinement | None = field(
        default=None, repr=False, compare=False, metadata={"saved": False}
    )

    @property
    def in_nip(self) -> slice:
        """All nodes."""
        return slice(0, self.x.size)
