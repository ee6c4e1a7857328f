"""The nips of one web on a wound roll, one after the other: loads, tensions, slip between them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property, partial
from itertools import pairwise
from math import nan

import numpy as np

from ..contact.newton import NewtonFailed
from ..contact.refinement import refine
from .nip_fields import NipFields
from .several_nips import system_of

__all__ = ["LEAST_STICK", "RollContact", "contacts_of", "nip_nodes"]


# Shortest stick zone of an arc, relative to its length: about a cell of a coarse mesh.
LEAST_STICK = 0.02


@dataclass(frozen=True, eq=False)
class FirstNips:
    """The same web with the first nips of a result alone; they are solved when they are used."""

    result: NipFields

    @cached_property
    def tensions(self) -> list[float]:
        """The wound-on tension of no nip, of the first one, the first two ... of all [N/m].

        That of no nip is the web tension; nan if the iteration finds no solution.
        """
        result = self.result
        problem, tensions = result.without_air, [result.problem.web_tension]
        given = problem.next_nips
        last_arc = problem.roll_wrap - sum(nip.angle for nip in given)
        for count in range(len(given)):
            kept = given[:count]
            arc = max(last_arc, given[count].angle)
            wrap = sum(nip.angle for nip in kept) + arc
            fewer = problem.replace(next_nips=kept, roll_wrap=wrap)
            try:
                solved = refine(partial(system_of, fewer), nodes=result.nodes).last
            except NewtonFailed:
                tensions.append(nan)
            else:
                tensions.append(float(solved.outputs["roll_wound_on_tension"]))
        return [*tensions, result.roll_wound_on_tension]


@dataclass(frozen=True)
class RollContact:
    """One of the nips through which a web runs with the roll.

    Attributes
    ----------
    angle : float
        From the first nip to this one, along the roll [rad].
    nip_load, winding_force : float
        P_k, and F_k; F_k > 0: the drum brakes [N/m].
    friction_ratio : float
        abs(F_k)/(mu- P_k), 1 where the drum slips; with a drum wrap, which carries a part of the
        force, the ratio to the friction of the nip alone.
    inlet_tension, outlet_tension : float
        Web tension at the leading and at the trailing edge [N/m].
    nip_width : float
        2a [m].
    peak_pressure : float
        Largest pressure on the drum [Pa].
    drum_creepage : float
        xi-, creepage of web and drum.
    arc : float
        Angle between the edges of the nip before and of this one [rad]; nan of the first nip.
    slip_angle, stick_angle : float
        Angle of the arc on which the web slips, back from this nip, and that on which it sticks
        [rad]; nan of the first nip.
    least_tension, largest_tension : float
        On the arc upstream [N/m]; nan of the first nip.

    Examples
    --------
    >>> import woundon as wo
    >>> front = wo.NextNip(angle=1.5, drum=wo.Rigid(radius=0.25), nip_load=600.0)
    >>> nip = wo.NipProblem.example().replace(next_nips=[front])
    >>> rear, front = wo.solve(nip, nodes=41).contacts
    >>> front.sticks_upstream, round(front.slip_angle, 1)
    (True, 0.7)
    """

    angle: float
    nip_load: float
    winding_force: float
    friction_ratio: float
    inlet_tension: float
    outlet_tension: float
    nip_width: float
    peak_pressure: float
    drum_creepage: float
    arc: float
    slip_angle: float
    stick_angle: float
    least_tension: float
    largest_tension: float
    number: int = field(repr=False)
    first_nips: FirstNips = field(repr=False, compare=False)

    @property
    def sticks_upstream(self) -> bool:
        """True if the web sticks to the roll on a part of the arc between the nip before and this.

        Then this nip adds nothing to the wound-on tension.  False of the first nip.
        """
        return self.stick_angle > LEAST_STICK * self.arc

    @property
    def added_tension(self) -> float:
        """The part of ``roll_wound_on_tension`` that this nip adds to that of the nips before it.

        The first nip adds its own to the web tension.  The same web is solved with the nips up to
        the one before, on as many nodes [N/m]; nan if that has no solution.
        """
        tensions = self.first_nips.tensions
        return float(tensions[self.number + 1] - tensions[self.number])


def nip_nodes(result: NipFields) -> list[slice]:
    """Return the nodes of each nip, edges included."""
    nips = [result.in_nip]
    for centre, a in zip(result.next_positions, result.next_half_widths, strict=True):
        # the arc before ends just upstream of the leading edge
        first, last = np.searchsorted(
            result.x, [centre - a * (1 + 5e-10), centre + a * (1 - 5e-10)]
        )
        nips.append(slice(int(first), int(last) + 1))
    return nips


def contacts_of(result: NipFields) -> Iterator[RollContact]:
    """Yield the nips of a result in the direction of travel."""
    problem, angle = result.problem, 0.0
    first_nips = FirstNips(result)
    halves = [result.half_width, *result.next_half_widths]
    creepages = [result.drum_creepage, *result.next_creepages]
    nips = nip_nodes(result)
    arcs = [slice(0, 0), *(slice(one.stop - 1, two.start) for one, two in pairwise(nips))]
    for k, (nip, arc) in enumerate(zip(nips, arcs, strict=True)):
        further = problem.next_nips[k - 1] if k else None
        given = further or problem
        angle += further.angle if further else 0.0
        length, slips, sticks = _angles_before(result, arc) if k else (nan, nan, nan)
        T = result.tension[arc]
        yield RollContact(
            angle=angle,
            nip_load=given.nip_load,
            winding_force=given.winding_force,
            friction_ratio=abs(given.winding_force) / (problem.drum_frictions[k] * given.nip_load),
            inlet_tension=float(result.tension[nip.start]),
            outlet_tension=float(result.tension[nip.stop - 1]),
            nip_width=2 * float(halves[k]),
            peak_pressure=float(result.drum_pressure[nip].max()),
            drum_creepage=float(creepages[k]),
            arc=length,
            slip_angle=slips,
            stick_angle=sticks,
            least_tension=float(T.min()) if k else nan,
            largest_tension=float(T.max()) if k else nan,
            number=k,
            first_nips=first_nips,
        )


def _angles_before(result: NipFields, arc: slice) -> tuple[float, float, float]:
    """Return the angles of an arc, of the slip back from its end, and of stick [rad].

    A single sticking node is a place where the slip changes its direction.
    """
    x, zones = result.x[arc], result.roll_zone[arc]
    cells = np.nonzero((zones[1:] == 0) & (zones[:-1] == 0))[0]
    length, sticks = float(x[-1] - x[0]), float((x[cells + 1] - x[cells]).sum())
    end_of_stick = x[cells[-1] + 1] if sticks > LEAST_STICK * length else x[0]
    R = float(result.problem.roll.radius)
    return length / R, float(x[-1] - end_of_stick) / R, sticks / R
