"""Thesis Fig. 20, sec. 4.4: two slip patterns, mu+ below and above mu- = 0.4.

The text gives neither nip load nor winding force.  Taken are those of Fig. 19(b) and of Table 1:
P = 4897 and F = 100 N/m.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

import woundon as wo

from ..report.panels import Panel
from .cases import paper_nip
from .exhibits import Exhibit
from .nips import FINE, Nip, along_nip, joined, solved, solved_accurately
from .panels import slips_and_increase
from .verdicts import Verdict, accurate, at_least, at_most, untested, verdict, whether
from .zones import Run, longest_stick, runs

__all__ = ["exhibits"]

FRICTIONS = (0.3, 0.5)
NIP_LOAD = 4897.0
PRINTED = (206.0, 125.0)  # NIT of panels (a) and (b) in the text [N/m]
UNTOLD = (
    "the text gives neither P nor F, and two numbers fix two loads: the accurate solver has 206 "
    "and 126 N/m at P = 7500, F = 0, the thesis's 212 and 122 N/m at P = 9000, F = 100 N/m"
)


def exhibits(solver: str) -> list[Exhibit]:
    """Solve both frictions; return Fig. 20."""
    base = paper_nip(nip_load=NIP_LOAD, web_tension=0.0)  # T is then what the nip has added so far
    nips = {mu: solved(base.replace(roll_friction=mu), solver, FINE) for mu in FRICTIONS}
    data = joined("roll_friction [1]", {mu: along_nip(r) for mu, r in nips.items()})
    below, above = nips.values()
    taut = paper_nip(nip_load=NIP_LOAD)
    wrapped = [
        solved_accurately(taut.replace(roll_friction=mu, roll_wrap=np.pi)) for mu in FRICTIONS
    ]
    verdicts = [*_pattern(above), *_numbers(below, above), *accurate(_of_the_wrap(*wrapped))]
    return [Exhibit("fig20", data, verdicts, _panels([below, above]))]


def _pattern(r: Nip | wo.NipResult, when: str = "mu+ > mu-") -> list[Verdict]:
    """Test the statements about the stick and slip zones, under the condition ``when``."""
    own = r.in_nip
    x, T = r.x[own], r.tension[own]
    roll, drum = runs(x, r.roll_zone[own]), runs(x, r.drum_zone[own])
    leading = min(roll[0].right, drum[0].right) - x[0]
    stick, end = longest_stick(drum), _end_of_stick(drum)
    assert stick is not None
    return [
        verdict(
            f"{when}: the web slips at roll and drum at the leading edge already",
            100 * leading / (2 * r.half_width),
            at_least(1.0, "% of the width"),
        ),
        whether("where it is a little ahead of the drum", drum[0].zone == 1),
        verdict(
            "at the trailing end slip begins at the drum, before it does at the roll: from the "
            "end of stick at the drum to that at the roll",
            1e3 * (_end_of_stick(roll) - end),
            at_least(0.0, "mm"),
        ),
        whether(
            "first the drum is ahead of the web",
            drum[stick + 1].zone == -1,
            note="v- < 0 downstream of the stick zone",
        ),
        verdict("and the tension falls", T.min() - np.interp(end, x, T), at_most(0.0, "N/m")),
        whether("on the last part the slip turns round", drum[-1].zone == 1, note="v- > 0"),
    ]


def _end_of_stick(zones: list[Run]) -> float:
    """Return the downstream end of the longest stick zone of a face [m]."""
    k = longest_stick(zones)
    assert k is not None
    return zones[k].right


def _numbers(below: Nip, above: Nip) -> list[Verdict]:
    """Test the statements about the tensions of both nips."""
    a, b = below.nip_induced_tension, above.nip_induced_tension
    return [
        verdict(
            "mu+ > mu- makes much less tension (ch. 6): NIT of (b) over that of (a)",
            b / a,
            at_most(0.75),
            note=f"the text's numbers give {PRINTED[1] / PRINTED[0]:.2f}",
        ),
        untested(
            f"NIT is {PRINTED[0]:.0f} N/m in panel (a) and {PRINTED[1]:.0f} N/m in panel (b)",
            note=f"{UNTOLD}.  At the loads taken here they are {a:.0f} and {b:.0f} N/m",
        ),
    ]


def _of_the_wrap(below: wo.NipResult, above: wo.NipResult) -> list[Verdict]:
    """Test the statements for the wrapped nip."""
    # between the edges of the nip, the quantity that the text gives
    a, b = (r.outlet_tension - r.inlet_tension for r in (below, above))
    return [
        *_pattern(above, "with the web wrapped on the roll downstream of the nip, mu+ > mu-"),
        verdict(
            "and mu+ > mu- makes much less tension: NIT of (b) over that of (a)",
            b / a,
            at_most(0.75),
            note=f"{b:.0f} and {a:.0f} N/m.  What the nip alone loses is largely what (97) takes "
            "off (Fig. 19)",
        ),
    ]


def _panels(nips: Sequence[Nip]) -> list[Panel]:
    """Return the panels of the slips and of the tension that both nips have added so far."""
    return [
        replace(
            slips_and_increase(nip),
            heading=f"$mu+ = {nip.problem.roll_friction}$, $mu- = {nip.problem.drum_friction}$",
            column=str(k),
            width=4.5,
            legend="figure below",
        )
        for k, nip in enumerate(nips)
    ]
