"""Thesis Fig. 20, sec. 4.4: two slip patterns, mu+ below and above mu- = 0.4.

The text gives neither nip load nor winding force.  Taken are those of Fig. 19(b) and of Table 1:
P = 4897 and F = 100 N/m.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..results import NipResult
from ..zones import zone_runs
from .cases import paper_nip
from .frame import Figure, Scheme, Verdict
from .profiles import profiles
from .sweep import FINE, solved

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Drawing

__all__ = ["figures"]

FRICTIONS = (0.3, 0.5)
NIP_LOAD = 4897.0
PRINTED = (206.0, 125.0)  # NIT of panels (a) and (b) in the text [N/m]
UNTOLD = (
    "the text gives neither P nor F, and two numbers fix two loads: the accurate scheme has 206 "
    "and 126 N/m at P = 7500, F = 0, the thesis's 212 and 122 N/m at P = 9000, F = 100 N/m"
)


def figures(scheme: Scheme = "graded") -> tuple[Figure, ...]:
    """Solve both frictions; return Fig. 20."""
    base = paper_nip(nip_load=NIP_LOAD, web_tension=0.0)  # T is then what the nip has added so far
    nips = [solved(base.replace(roll_friction=mu), scheme, FINE) for mu in FRICTIONS]
    table = profiles(
        [({"roll_friction [1]": mu}, r) for mu, r in zip(FRICTIONS, nips, strict=True)]
    )
    title = "Slips and tension for mu+ below and above mu-"
    verdicts = (*_pattern(nips[1]), *_numbers(*nips))
    return (Figure("fig20", title, scheme, table, verdicts, lambda: _draw(nips)),)


def _pattern(r: NipResult) -> tuple[Verdict, ...]:
    roll, drum = zone_runs(r.x, r.roll_zone), zone_runs(r.x, r.drum_zone)
    signs = [int(zone) for zone, *_ in drum]
    leading = min(roll[0][2], drum[0][2]) - r.x[0]
    T = r.web_tension
    return (
        Verdict(
            "mu+ > mu-: the web slips at roll and drum at the leading edge already",
            100 * leading / (2 * r.half_width), 1.0, unit="% of the width",
        ),
        Verdict.whether("where it is a little ahead of the drum", signs[0] == 1),
        Verdict(
            "at the trailing end slip begins at the drum, before it does at the roll: from the "
            "end of stick at the drum to that at the roll",
            1e3 * (_end_of_stick(roll) - _end_of_stick(drum)), 0.0, unit="mm",
        ),
        Verdict.whether(
            "first the drum is ahead of the web", _after_stick(drum) == -1,
            "v- < 0 behind the stick zone",
        ),
        Verdict(
            "and the tension falls", float(np.min(T) - np.interp(_end_of_stick(drum), r.x, T)),
            high=0.0, unit="N/m",
        ),
        Verdict.whether("on the last part the slip turns round", signs[-1] == 1, "v- > 0"),
    )  # fmt: skip


def _numbers(below: NipResult, above: NipResult) -> tuple[Verdict, ...]:
    a, b = below.nip_induced_tension, above.nip_induced_tension
    return (
        Verdict(
            "mu+ > mu- makes much less tension (ch. 6): NIT of (b) over that of (a)", b / a,
            high=0.75, note=f"the text's numbers give {PRINTED[1] / PRINTED[0]:.2f}",
        ),
        Verdict.untested(
            f"NIT is {PRINTED[0]:.0f} N/m in panel (a) and {PRINTED[1]:.0f} N/m in panel (b)",
            f"{UNTOLD}.  At the loads taken here they are {a:.0f} and {b:.0f} N/m",
        ),
    )  # fmt: skip


def _stick(runs: list) -> int:
    """Return the index of the longest stick zone."""
    return max(
        (k for k, run in enumerate(runs) if run[0] == 0), key=lambda k: runs[k][2] - runs[k][1]
    )


def _end_of_stick(runs: list) -> float:
    return float(runs[_stick(runs)][2])


def _after_stick(runs: list) -> int:
    return int(runs[_stick(runs) + 1][0])


def _draw(nips: list[NipResult]) -> Drawing:
    from .. import plots
    from . import drawing

    figure = drawing.blank(1, 2, (9.0, 3.6), letters=False)
    panels = list(figure.axes)
    with plots.style():
        for letter, axes, nip in zip("ab", panels, nips, strict=True):
            plots.draw_slips(axes, nip)
            text = rf"({letter})  $\mu^+ = {nip.problem.roll_friction}$, $\mu^- = 0.4$"
            drawing.panel_letter(axes, "")  # the letter stands inside, the legend is above
            axes.text(0.04, 0.93, text, transform=axes.transAxes)
            axes.set_xlabel("Position along the nip $x$ [mm]")
        for twin in figure.axes[2:]:
            twin.set_ylabel(r"$T - T_\mathrm{in}$ [N/m]")
    return figure
