"""Nips solved one after another along the curves of a figure."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Mapping
from typing import NamedTuple

import numpy as np

from ..errors import ValidityWarning
from ..nip import solve_nip
from ..problems import NipProblem
from ..results import NipResult
from .frame import Scheme, Table

__all__ = ["FINE", "WINDING_FORCES", "solved", "sweep", "zone_lengths"]

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


class ZoneLengths(NamedTuple):
    """Slip lengths over the nip width: s_r1, s_r2, s_d of thesis eq. (172)."""

    leading_roll: float
    trailing_roll: float
    dual: float


def zone_lengths(result: NipResult) -> ZoneLengths:
    """Measure the slip zones between the thesis's points A, B and C.

    A ends the leading slip at the roll, B begins the forward slip there, C ends the stick at the
    drum.  The roll may stick again for a short length around C, at heavy loads for instance; that
    is not taken off s_r2 and s_d, which run from B and C to the trailing edge.  A face that slips
    all over counts as its trailing zone.  The sign of s_d is that of the slip at the drum, because
    at the roll the web is always the faster one there.
    """
    x = result.x
    border = np.concatenate([x[:1], (x[1:] + x[:-1]) / 2, x[-1:]]) / (2 * result.half_width) + 0.5
    roll, drum = _runs(result.roll_zone), _runs(result.drum_zone)
    if all(zone != 0 for zone, *_ in roll):
        return ZoneLengths(0.0, float(roll[-1][0]), _dual(drum, border))
    leading = roll[0][0]
    first = next(k for k, run in enumerate(roll) if run[0] == 0)
    trailing, B = next(((run[0], run[1]) for run in roll[first:] if run[0] != 0), (0, x.size))
    A = roll[first][1] if leading else 0
    return ZoneLengths(
        leading * float(border[A]), trailing * float(1 - border[B]), _dual(drum, border)
    )


def _dual(drum: list[tuple[int, int, int]], border: Array) -> float:
    """Return s_d, from the end of the drum's longest stick zone."""
    sticks = [k for k, run in enumerate(drum) if run[0] == 0]
    if not sticks:
        return float(drum[-1][0])
    k = max(sticks, key=lambda k: drum[k][2] - drum[k][1])
    return 0.0 if k + 1 == len(drum) else drum[k + 1][0] * float(1 - border[drum[k][2]])


def _runs(zones: Array) -> list[tuple[int, int, int]]:
    """Return runs of one zone: (zone, first node, node behind the last)."""
    ends = [*(np.flatnonzero(np.diff(zones)) + 1).tolist(), zones.size]
    return [(int(zones[a]), a, b) for a, b in zip([0, *ends[:-1]], ends, strict=True)]
