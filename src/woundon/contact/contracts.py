"""What the loop asks of a contact, of its equations, and of what they come to."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from .meshes import Mesh
from .stick_slip import StickSlip, StickSlipSolution
from .told import Foreseen

if TYPE_CHECKING:
    from .levels import Before, Level, Scalars, Start

__all__ = ["Contact", "Equations", "State"]

Array = np.ndarray


class State(Protocol):
    """What solved tractions come to on one mesh."""

    @property
    def half_width(self) -> float:
        """a [m]."""
        ...

    @property
    def solution(self) -> StickSlipSolution:
        """Tractions, zones, slips."""
        ...

    @property
    def known(self) -> Any:
        """What to linearise about next on the same mesh."""
        ...


class Equations(Protocol):
    """A contact's equations for one half width, linear."""

    def stick_slip(self) -> StickSlip:
        """Return the stick-slip problem, the normal problem put in."""
        ...

    def state(self, solution: StickSlipSolution) -> Any:
        """Return the state of solved tractions."""
        ...

    def carried(self, state: Any) -> float:
        """Return the load that a state carries [N/m]."""
        ...

    def imbalance(self, state: Any) -> float:
        """Return what a state leaves of whatever was linearised, relative; 0 where nothing was."""
        ...

    def frictionless(self) -> float | None:
        """Return the load without friction [N/m] where the equations tell it, else None."""
        ...

    @property
    def faces(self) -> Sequence[Array]:
        """Where each face's unknown tractions are, in units of a."""
        ...

    @property
    def places(self) -> Array:
        """Where what is linearised about is given, in units of a."""
        ...


class Contact(Protocol):
    """A problem that the loop can solve."""

    @property
    def load(self) -> float:
        """What the pressure must carry [N/m]."""
        ...

    @property
    def widest(self) -> float:
        """Largest half width that makes sense [m]."""
        ...

    @property
    def beyond(self) -> str:
        """What is wrong with a wider one, and what to change."""
        ...

    @property
    def outside(self) -> str:
        """What of the problem lies far outside the model, and what to change; '' where nothing."""
        ...

    @property
    def settles_apart(self) -> bool:
        """Whether what is linearised must settle before a load tells the width.

        Bodies that are not linear must; else both settle together.
        """
        ...

    def stand_in(self, peak: float | None) -> Contact | None:
        """Return a linear contact to start from, for this largest pressure; None if unknown."""
        ...

    def guess(self) -> float:
        """Return a half width to start from [m]."""
        ...

    def frictionless_load(self, mesh: Mesh, a: float) -> float:
        """Return the load that a frictionless contact of half width a carries [N/m]."""
        ...

    def about(self, mesh: Mesh, a: float, before: Before | None) -> Any:
        """Return what to linearise about on a mesh, after another or to begin with."""
        ...

    def equations(self, mesh: Mesh, a: float, about: Any, last: Any = None) -> Any:
        """Return the equations for the half width a [m]; what still holds of the last may stay."""
        ...

    def zones(self, start: Start, equations: Any) -> Array:
        """Return the zones to begin with, after another mesh or a neighbouring case."""
        ...

    def first_zones(self, equations: Any) -> Array | None:
        """Return the zones to begin with where nothing is known; None for all in stick."""
        ...

    def refuse(self, equations: Any, state: Any) -> None:
        """Raise for a state that shows that there is no steady state."""
        ...

    def scalars(self, level: Level) -> Scalars:
        """Return the numbers whose changes from mesh to mesh tell their errors."""
        ...

    def scale(self, name: str, value: float) -> float:
        """Return what relative errors of a scalar are measured by."""
        ...

    @property
    def order(self) -> float:
        """By which power of the cells errors fall from mesh to mesh, those that fall least."""
        ...

    def foreseen(self, level: Level, scalars: Scalars) -> Mapping[str, Foreseen]:
        """Return what a solved mesh lets foresee of how its scalars scatter, where it does."""
        ...

    def grains(self, level: Level) -> Scalars:
        """Return what a solved mesh leaves of scalars that changes need not show."""
        ...
