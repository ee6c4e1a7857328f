"""Validity checks of solved cases, and checks of the mesh: warnings with numbers.

The model is linear and plane, with small strains and a thin taut web; the documentation of the
warnings gives the reasons for the limits.  A warning is data, not an error: the equations are
solved in any case.  Warnings about the mesh begin with :data:`woundon.errors.RESOLUTION`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from .errors import RESOLUTION
from .problems.bodies import half_width_guess
from .problems.contact_problem import ContactProblem
from .quantities import length, line_load, stress
from .results import Zone

__all__ = [
    "LENGTH",
    "LIMITS",
    "PRESSURE",
    "STIFFNESS",
    "TENSION",
    "THICKNESS",
    "Limit",
    "far_outside",
    "limit_warning",
    "zone_warnings",
]

Array = np.ndarray


# quantities in the texts of warnings, which are displayed in the units of the user
LENGTH, THICKNESS = length("x", "length or position"), length("h", "thickness", "um")
PRESSURE, STIFFNESS = stress("P", "pressure"), stress("A", "stiffness", "MPa")
TENSION = line_load("T", "tension")


class Limit(NamedTuple):
    """Largest admissible value of a ratio, and the assumption that is violated beyond it."""

    maximum: float
    reason: str


LIMITS = {
    "half width": Limit(0.2, "the gap is no longer a parabola"),
    "indentation": Limit(0.1, "strains are not small"),
    "peak pressure": Limit(0.1, "the material is not linear there"),
    "shear strain": Limit(0.1, "strains are not small"),
    "surface strain": Limit(0.1, "strains are not small"),
    "creepage": Limit(0.1, "strains are not small"),
    "pressure on the web": Limit(0.1, "the web's thickness changes too much"),
    "web strain": Limit(0.02, "paper breaks and film yields at a few percent"),
    "bending strain": Limit(0.02, "paper breaks and film yields at a few percent"),
    "layer compression": Limit(0.2, "strains are not small"),
    "stack modulus": Limit(1.0, "no stack is stiffer than its web"),
    "web thickness": Limit(0.1, "the web is no thin strip in so narrow a nip"),
}
# A zone boundary is known to a cell, and so the length of such a zone to a quarter.
FEW_NODES = 4
# Relative to the nip width: a narrower zone, mostly at an edge, does not affect the outputs.
NARROW_ZONE = 0.02


def limit_warning(name: str, ratio: float, template: str, *values: object) -> tuple[str, ...]:
    """Return a warning if the size of a ratio exceeds the named limit.

    In the template ``{}`` is replaced by the ratio, ``{0}`` and so on by the values.
    """
    limit = LIMITS[name]
    if not abs(ratio) > limit.maximum:
        return ()
    text = template.replace("{}", _percent(ratio)).format(*values)
    return (f"{text} (limit {_percent(limit.maximum)}): {limit.reason}",)


def _percent(ratio: float) -> str:
    """Return a ratio as text in percent."""
    return f"{100 * ratio:.3g}%"


def far_outside(problem: ContactProblem, load: float) -> Iterator[str]:
    """Yield a text for each body whose stiffness is less than the mean pressure of a load [N/m].

    The pressure is that of the estimated width of the contact, which is not solved.
    """
    p = load / (2 * half_width_guess(load, *problem.bodies))
    for name, body in zip(problem.pair, problem.bodies, strict=True):
        if body.surface_material is not None:
            stiffness = body.surface_material.stiffness
            modulus = min(stiffness.rr, stiffness.tt)
            if p > modulus:
                yield (
                    f"this is far outside the model: a mean pressure of about {p:.2g} Pa is more "
                    f"than the {name}'s stiffness, {modulus:.2g} Pa; take a smaller load or a "
                    f"stiffer {name}"
                )


def zone_warnings(x: Array, faces: Mapping[str, Array], slips: str = "the web") -> Iterator[str]:
    """Yield warnings about zones with too few nodes.

    There is none about a zone of a small part of the nip's width, or about a point at which the
    slip changes its direction.  A slip zone at the end of the nip is the dual-slip zone if all
    faces slip there in the same direction.

    Parameters
    ----------
    x : (M,) array
        Nodes of the nip [m].
    faces : mapping of str to (M,) int array
        Zones by the name of the body against which the web, or the lower surface, slips.
    slips : str
        Name of the surface that is faster or slower.
    """
    # of the last node within the nip; the pressure is zero at its end
    trailing = {int(zones[-2]) for zones in faces.values()}
    dual = len(faces) > 1 and len(trailing) == 1 and trailing != {Zone.STICK}
    for face, zones in faces.items():
        for first, last in _runs_between_ends(zones):
            count = last - first + 1
            with_neighbours = slice(first - 1, last + 2)
            width = float(x[last + 1] - x[first - 1])
            if count >= FEW_NODES or width <= NARROW_ZONE * float(x[-1] - x[0]):
                continue
            if _is_reversal(zones[with_neighbours]):
                continue
            where = f"a {_zone_name(Zone(int(zones[first])), slips)} at the {face}"
            if dual and last == zones.size - 2:
                where = "the dual-slip zone"
            nodes = "1 node" if count == 1 else f"{count} nodes"
            cell = LENGTH.stored_text(float(np.diff(x[with_neighbours]).max()), ".2g")
            yield (
                f"{RESOLUTION}{nodes} in {where}, the ends of which are known to {cell}; "
                f"use {2 * x.size - 1} nodes"  # half the spacing
            )


def _runs_between_ends(zones: Array) -> Iterator[tuple[int, int]]:
    """Yield first and last index of each run of nodes in one zone, without the ends of the nip."""
    inner = zones[1:-1]
    changes = (inner[1:] != inner[:-1]).nonzero()[0] + 1  # indices in inner, one less than in zones
    for first, end in pairwise([1, *(changes + 1).tolist(), zones.size - 1]):
        yield first, end - 1


def _is_reversal(zones: Array) -> bool:
    """Return True for a stick zone of one node between its neighbours of opposite slip.

    It is the point at which the slip changes its direction; the error estimates of creepage and
    slip lengths contain the cell in which it lies.
    """
    return zones.size == 3 and zones[1] == Zone.STICK and zones[0] * zones[2] < 0


def _zone_name(zone: Zone, slips: str) -> str:
    """Return the name of a zone, with the surface that slips in it."""
    return f"zone with {slips} {zone.word}" if zone else "stick zone"
