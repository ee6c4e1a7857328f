"""The state of two rollers in contact."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from math import nan
from types import MappingProxyType
from typing import Annotated, Any, ClassVar

import numpy as np

from .. import kinds
from ..losses import Losses
from ..problems.rollers import RollerProblem
from ..quantities import Quantity, length, line_load, pure, strain, stress
from ..results import Residuals, Result, Zone

__all__ = ["RollerResult"]

Array = np.ndarray


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class RollerResult(Losses, Result):
    """The state of two rollers in contact.

    Attributes
    ----------
    problem : RollerProblem
    creepage : float
        xi, the lower roller's surface speed less the upper's, over the speed, before strain; > 0
        where it drags the upper roller along +x.  nan for a static contact; without friction that
        of vanishing friction, where it is not given.
    shift : float
        Of static rollers, the lower one's along +x less the upper's [m]; half-planes have it up to
        a constant.  nan for a rolling contact.
    tangential_load : float
        Q on the upper roller along +x [N/m].
    half_width, approach, offset : float
        a, approach > 0 and Delta [m].
    x, pressure, traction : (M,) arrays
        Nodes [m], p and q [Pa] (on the upper roller).
    slip_x, slip, zone : (M,) arrays
        Where the slip is taken [m]; slip, a speed over the speed in rolling, a length in static
        contact [m]; :class:`~woundon.results.Zone`, with the lower surface for the web.
    traction_error : float
        Estimated discretisation error of the traction, L2 norm relative to its own [1].
    mesh : Mesh
        On which it was solved.
    """

    MAY_BE_NAN: ClassVar[frozenset[str]] = frozenset(
        {"creepage", "rolling_resistance", "shift", "traction_error"}
    )
    ALONG: ClassVar[Mapping[str, str]] = MappingProxyType({"slip": "slip_x"})
    ESTIMATES: ClassVar[frozenset[str]] = frozenset({"iterations", "traction_error"})

    problem: RollerProblem
    creepage: Annotated[
        float, strain("xi", "creepage, surface speed of the lower roller less the upper's")
    ]
    shift: Annotated[float, length("s", "shift of the lower roller, static contact", "um")] = nan
    tangential_load: Annotated[float, line_load("Q", "tangential load on the upper roller")]
    half_width: Annotated[float, length("a", "half-width of the contact")]
    approach: Annotated[float, length("delta", "approach of the rollers' centres")]
    offset: Annotated[float, length("Delta", "line of centres, from the centre of the contact")]
    x: Annotated[Array, length("x", "position along the contact, [-a, a]")]
    pressure: Annotated[Array, stress("p", "pressure", "MPa")]
    traction: Annotated[Array, stress("q", "traction on the upper roller", "MPa")]
    slip_x: Annotated[Array, length("x_v", "where the slip is taken")]
    slip: Annotated[
        Array, strain("v", "slip, > 0: lower surface faster; a length of static rollers")
    ]
    zone: Annotated[
        Array, pure("z", "zone: 0 stick, 1 slip with the lower surface faster, -1 slower"), Zone
    ]
    traction_error: Annotated[
        float, strain("e_q", "estimated error of the traction (L2), relative")
    ] = nan
    iterations: Annotated[int, pure("n_it", "linear stick-slip systems solved")] = 0
    scheme: str = "graded"
    mesh: Any = field(default=None, repr=False, compare=False, metadata={"saved": False})

    @property
    def relabelled(self) -> Mapping[str, Quantity]:
        """The slip of static rollers is a length."""
        if self.problem.motion == "rolling":
            return {}
        return {"slip": length("v", "slip, > 0: lower surface along +x")}

    @property
    def nip_width(self) -> Annotated[float, length("2a", "width of the contact")]:
        """2a [m]."""
        return 2 * self.half_width

    @property
    def peak_pressure(self) -> Annotated[float, stress("p_max", "largest pressure", "MPa")]:
        """Largest nodal pressure [Pa]."""
        return float(np.max(self.pressure))

    @property
    def slip_share(self) -> Annotated[float, strain("s_q", "slip length / width of the contact")]:
        """Share of the width on which the rollers slip [1]."""
        return sum(right - left for zone, left, right in self._runs() if zone) / self.nip_width

    def _runs(self) -> Iterator[tuple[int, float, float]]:
        from ..contact.zones import zone_runs

        yield from zone_runs(self.x, self.zone)

    @property
    def in_nip(self) -> slice:
        """All nodes."""
        return slice(0, self.x.size)

    @property
    def nodes(self) -> int:
        """Number of nodes."""
        return self.x.size

    def certified(self) -> Residuals:
        """Return the certificate measured anew, from the problem and the arrays held here."""
        from .certificate import certificate, matrices_of

        return certificate(self, matrices_of(self))

    def recomputed(self) -> Mapping[str, tuple[float, float]]:
        """Return the scalars that no law tells, by name: as the arrays give them, how exactly."""
        told: Mapping[str, tuple[float, float]] = kinds.fetch("woundon.rollers.solve:recomputed")(
            self
        )
        return told
