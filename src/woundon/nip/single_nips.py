"""The nips of one web on a roll, each alone: their loads, and the arcs between them."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from math import pi
from typing import NamedTuple

from ..errors import InvalidProblem
from ..problems.nip import NipProblem
from .equations import NipEquations
from .load_limit import check_load

__all__ = ["SingleNips", "check_nips", "single_nips"]

# Least end of an arc, from the centre of the nip, in half widths without friction: friction and
# tension change the half width by up to a few tens of percent.
LEAST_ARC = 2.0


class SingleNips(NamedTuple):
    """The nips of a problem, each alone.

    Attributes
    ----------
    problems : tuple of NipProblem
        With the arc up to the leading edge of the next nip as the roll wrap.  The tension upstream
        of further nips is that of the problem; the solution replaces it.
    half_widths : tuple of float
        Of the contacts without friction [m].
    """

    problems: tuple[NipProblem, ...]
    half_widths: tuple[float, ...]


@lru_cache(maxsize=4)  # the meshes of a solution use the same nips
def single_nips(problem: NipProblem) -> SingleNips:
    """Return the nips of a problem with ``next_nips``, each alone.

    Raises
    ------
    InvalidProblem
        If there is no arc between two nips, or behind the last one, or if it reaches the first nip.
    """
    angles = [further.angle for further in problem.next_nips]
    first = problem.replace(next_nips=(), roll_wrap=angles[0])
    alone = [first]
    for further, friction in zip(problem.next_nips, problem.drum_frictions[1:], strict=True):
        alone.append(
            first.replace(
                drum=further.drum,
                nip_load=further.nip_load,
                winding_force=further.winding_force,
                drum_friction=friction,
                drum_wrap=0.0,
            )
        )
    R = problem.roll.radius
    half_widths = tuple(NipEquations(each, 3).initial_half_width() for each in alone)
    edges = [a / R for a in half_widths]
    arcs = [angle - edge for angle, edge in zip(angles, edges[1:], strict=True)]
    arcs.append(problem.roll_wrap - sum(angles))
    _check_arcs(problem, arcs, edges)
    wrapped = [each.replace(roll_wrap=arc) for each, arc in zip(alone, arcs, strict=True)]
    return SingleNips(tuple(wrapped), half_widths)


def _check_arcs(problem: NipProblem, arcs: Sequence[float], edges: Sequence[float]) -> None:
    """Reject arcs behind the nips [rad] that are too short for the half widths ``edges`` [rad].

    Nor may the last one reach the first nip.

    Raises
    ------
    InvalidProblem
        Naming the angle to the next nip, or the wrap behind the last one.
    """
    angles = [further.angle for further in problem.next_nips]
    for k, (arc, edge) in enumerate(zip(arcs, edges, strict=True)):
        short = LEAST_ARC * edge - arc
        if short > 0 and k < len(angles):
            raise InvalidProblem.at(
                f"next_nips.{k}.angle",
                f"{angles[k]:.6g} is out of range; must be >= {angles[k] + short:.4g} [rad], so "
                "that there is an arc between the two nips",
            )
        if short > 0:
            raise InvalidProblem.at(
                "roll_wrap",
                f"{problem.roll_wrap:.6g} is out of range; must be >= "
                f"{problem.roll_wrap + short:.4g} [rad], so that there is an arc behind the last "
                "nip",
            )
    most = 2 * pi - LEAST_ARC * edges[0]  # where the laid layer runs into the first nip again
    if problem.roll_wrap > most:
        raise InvalidProblem.at(
            "roll_wrap",
            f"{problem.roll_wrap:.6g} is out of range; must be <= {most:.4g} [rad], so that the "
            "arc behind the last nip ends before the first one",
        )


def check_nips(problem: NipProblem) -> None:
    """Reject further nips that touch, and loads that no single contact carries.

    Raises
    ------
    InvalidProblem
        Naming the field of the further nip.
    """
    for k, each in enumerate(single_nips(problem).problems[1:]):
        try:
            check_load(each, "nip_load")
        except InvalidProblem as fault:
            raise fault.under(f"next_nips.{k}") from None
