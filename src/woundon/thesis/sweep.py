"""Nips solved one after another along the curves of a figure."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Mapping

import numpy as np

from ..errors import ValidityWarning
from ..nip import solve_nip
from ..problems import NipProblem
from ..results import NipResult
from .frame import Scheme, Table
from .slip_zones import zone_lengths

__all__ = ["FINE", "WINDING_FORCES", "solved", "sweep"]

Array = np.ndarray

WINDING_FORCES = (-500.0, -400.0, -200.0, 0.0, 100.0)  # F of thesis sec. 4.3 to 4.5 [N/m]
NODES = 129  # NIT to about 0.1 N/m
THESIS_NODES = 200
FINE = 257  # zone borders to 0.6 % of the nip width or better

_UNITS = {
    "winding_force": "N/m", "nip_load": "N/m", "roll_friction": "1", "roll_radius": "m",
    "drum_radius": "m", "youngs_modulus": "Pa", "poissons_ratio": "1", "cover_thickness": "m",
    "radial": "Pa", "tangential": "Pa", "cross": "Pa", "shear": "Pa", "thickness": "m",
}  # fmt: skip
_OUTPUTS: dict[str, Callable[[NipResult], float]] = {
    "nip_induced_tension [N/m]": lambda r: r.nip_induced_tension,
    "nip_width [m]": lambda r: 2 * r.half_width,
    "approach [m]": lambda r: r.approach,
    "leading_roll_slip [1]": lambda r: zone_lengths(r).leading_roll,
    "trailing_roll_slip [1]": lambda r: zone_lengths(r).trailing_roll,
    "dual_slip [1]": lambda r: zone_lengths(r).dual,
}


def solved(
    problem: NipProblem, scheme: Scheme, nodes: int = NODES, start: NipResult | None = None
) -> NipResult:
    """Solve a nip accurately with so many nodes, or as the thesis did, with M = 200.

    ``start`` is a solved neighbour; the answer does not depend on it.
    """
    with warnings.catch_warnings():
        # the thesis's soft covers leave the model's validity; the gallery says where
        warnings.simplefilter("ignore", ValidityWarning)
        count = THESIS_NODES if scheme == "thesis" else nodes
        return solve_nip(problem, scheme=scheme, nodes=count, start=start)


def sweep(
    cases: Iterable[tuple[Mapping[str, float], NipProblem]], scheme: Scheme, nodes: int = NODES
) -> Table:
    """Solve cases, each told by the values of its parameters; return a row for each.

    Parameters
    ----------
    cases : iterable of (parameters, NipProblem)
        Parameters by name, the same names in every case; units are known by name.
    scheme : {"graded", "thesis"}
    nodes : int
        Of the graded scheme.
    """
    rows: list[list[float]] = []
    names: tuple[str, ...] = ()
    curve: list[float] = []  # all parameters but the last: they change where a new curve begins
    result: NipResult | None = None
    for parameters, problem in cases:
        names, before = tuple(parameters), curve
        curve = list(parameters.values())[:-1]
        result = solved(problem, scheme, nodes, result if curve == before else None)
        rows.append([*parameters.values(), *(of(result) for of in _OUTPUTS.values())])
    header = (*(f"{name} [{_UNITS[name]}]" for name in names), *_OUTPUTS)
    return Table(header, np.array(rows))
