"""The state of two rollers in contact."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Annotated, ClassVar

import numpy as np

from ..quantities import Quantity, length, share, stress
from ..results import Residuals
from .roller_fields import RollerFields
from .zones import slip_share

if TYPE_CHECKING:
    from ..contact.refinement import MeshSolution

__all__ = ["RollerResult"]

Array = np.ndarray


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class RollerResult(RollerFields):
    """The solution of two rollers in contact.

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
    refinement : Refinement
        The solutions on all meshes, for a warm start; None of a result loaded from a file.

    Examples
    --------
    >>> import woundon as wo
    >>> rollers = wo.solve(wo.RollerProblem.example())
    >>> print(f"creepage {rollers.creepage:.2e}, slip on {rollers.slip_share:.0%} of the width")
    creepage 1.41e-04, slip on 10% of the width
    """

    MAY_BE_NAN: ClassVar[frozenset[str]] = frozenset(
        {"creepage", "rolling_resistance", "shift", "traction_error"}
    )
    ALONG: ClassVar[Mapping[str, str]] = MappingProxyType({"slip": "slip_x"})
    ESTIMATES: ClassVar[frozenset[str]] = frozenset({"iterations", "traction_error"})

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
    def slip_share(self) -> Annotated[float, share("s_q", "slip length / width of the contact")]:
        """Share of the width on which the rollers slip [1]."""
        slack = self.problem.friction * self.pressure - np.abs(self.traction)
        return slip_share(self.x, self.zone, self.slip, slack)

    def certified(self) -> Residuals:
        """Return the certificate, evaluated from the problem and the arrays of this result."""
        from .roller_certificate import certificate

        return certificate(self)

    @property
    def consistency(self) -> Residuals:
        """Conditions that converge with the mesh: the power balance of viscoelastic rollers."""
        from .roller_certificate import consistency

        return consistency(self)

    def _recomputed_solution(self) -> MeshSolution:
        """Return the solution on the last mesh from the arrays of this result."""
        from .roller_certificate import recomputed_solution

        return recomputed_solution(self)

    @property
    def _differentiated(self) -> tuple[str, ...]:
        """Outputs of ``sensitivity`` where none is named."""
        main = ("half_width", "peak_pressure", "approach", "offset", "tangential_load")
        motion_output = "shift" if self.problem.motion == "static" else "creepage"
        dissipation = ("rolling_resistance",) if self.problem.viscoelastic else ()
        return (motion_output, *main, *dissipation)

    @property
    def _excluded(self) -> dict[str, str]:
        """Fields without a derivative, with the reason."""
        text = "0 has no derivative: with friction the rollers transmit tractions"
        return {} if self.problem.friction else {"friction": text}
