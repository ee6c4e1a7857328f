"""Thesis Fig. 25, sec. 4.6: the nip of Fig. 15 with a soft drum cover.

2 cm of E = 10 MPa, nu = 0.1.  The text gives no nip load; since it compares with Fig. 15, that
figure's P = 1900 N/m is taken.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..bodies import Cylinder
from ..materials import material
from ..problems import NipProblem
from ..results import NipResult
from ..zones import zone_runs
from .cases import paper_nip
from .frame import Figure, Scheme, Verdict
from .profiles import profiles
from .sweep import FINE, solved

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Drawing

__all__ = ["figures"]

FALL_LOAD = 3000.0  # where the web tension falls by what the text says [N/m]


def _soft(nip_load: float) -> NipProblem:
    cover = Cylinder(radius=0.5, core_radius=0.48, material=material("soft-cover"))
    # T is then what the nip has added so far, as the thesis shows it
    return paper_nip(nip_load=nip_load, drum=cover, web_tension=0.0)


def figures(scheme: Scheme = "graded") -> tuple[Figure, ...]:
    """Solve the soft-covered drum, and the hard one to compare with; return Fig. 25."""
    hard, soft = solved(paper_nip(), scheme, FINE), solved(_soft(1900.0), scheme, FINE)
    heavier = solved(_soft(FALL_LOAD), scheme, FINE)
    title = "Tractions, slips and web tension in the nip, soft drum cover"
    verdicts = (
        *_tractions(hard, soft),
        *_pattern(soft),
        *_edges(soft, heavier),
        *_tension(soft, heavier),
    )
    return (Figure("fig25", title, scheme, profiles([({}, soft)]), verdicts, lambda: _draw(soft)),)


def _tractions(hard: NipResult, soft: NipResult) -> tuple[Verdict, ...]:
    def smaller(name: str) -> float:
        peaks = [float(np.max(np.abs(getattr(r, name)))) for r in (soft, hard)]
        return 100 * (1 - peaks[0] / peaks[1])

    return (
        Verdict(
            "tractions are more than 50 % smaller than with the hard drum: at the roll",
            smaller("roll_traction"), 50.0, unit="%", note="of the largest",
        ),
        Verdict(
            "and at the drum", smaller("drum_traction"), 50.0, unit="%",
            note=f"of the largest.  It is bound to mu- p, and the wider nip's largest pressure is "
            f"{smaller('pressure'):.0f} % smaller only",
        ),
    )  # fmt: skip


def _pattern(r: NipResult) -> tuple[Verdict, ...]:
    roll, drum = zone_runs(r.x, r.roll_zone), zone_runs(r.x, r.drum_zone)
    signs = [int(zone) for zone, *_ in drum]
    forward = max((run for run in drum if run[0] == 1), key=lambda run: run[2] - run[1])
    turn = 100 * (r.half_width - forward[2]) / (2 * r.half_width)
    return (
        Verdict.whether(
            "the roll's pattern is that of the hard drum: backward, stick, forward",
            [int(zone) for zone, *_ in roll] == [-1, 0, 1],
        ),
        Verdict.whether(
            "the drum has a leading slip zone too, the web behind it", signs[0] == -1,
            f"v- < 0 on {100 * (drum[0][2] - drum[0][1]) / (2 * r.half_width):.1f} % of "
            "the width",
        ),
        Verdict.whether(
            "at the trailing edge the web is ahead of the drum first", max(signs[1:]) == 1, "v- > 0"
        ),
        Verdict(
            "and behind it very near the edge", float(signs[-1]), -1, -1, note="sign of v-"
        ),
        Verdict("from so near on", turn, 1e-6, 2.0, "% of the width"),
        Verdict(
            "slip is larger at the drum than at the roll: largest |v-| over largest |v+|",
            float(np.max(np.abs(r.drum_slip)) / np.max(np.abs(r.roll_slip))), 1.0,
        ),
    )  # fmt: skip


def _edges(r: NipResult, heavier: NipResult) -> tuple[Verdict, ...]:
    base, more = (100 * np.abs(nip.drum_slip[[1, -1]]) for nip in (r, heavier))
    return (
        Verdict(
            "|v-| is about 0.35 % at the leading edge", float(base[0]), 0.3, 0.4, "%",
            f"{more[0]:.2f} % at P = {FALL_LOAD:.0f} N/m",
        ),
        Verdict(
            "and at the trailing edge", float(base[1]), 0.3, 0.4, "%",
            f"{more[1]:.2f} % at P = {FALL_LOAD:.0f} N/m; it turns round within the last "
            "per cent of the width, where the cover's strain has a vertical tangent",
        ),
    )  # fmt: skip


def _tension(r: NipResult, heavier: NipResult) -> tuple[Verdict, ...]:
    T = r.web_tension - r.problem.web_tension
    both = (r.roll_zone == 0) & (r.drum_zone == 0)
    inside = both[1:] & both[:-1]
    share = float(np.sum(np.abs(np.diff(T))[inside]) / np.sum(np.abs(np.diff(T))))
    fall = float(np.max(heavier.problem.web_tension - heavier.web_tension))
    return (
        Verdict(
            "most of the tension's variation happens where both faces stick",
            100 * share, 50.0, unit="%",
        ),
        Verdict(
            "it is lowest at the nip's centre", float(r.x[np.argmin(T)] / r.half_width), -0.1, 0.1,
            note="x/a of the lowest tension",
        ),
        Verdict(
            "where it has fallen by almost 150 N/m", float(-T.min()), 135.0, 150.0, "N/m",
            f"at P = 1900 N/m; at {FALL_LOAD:.0f} N/m it falls by {fall:.0f} N/m, and the text "
            "does not give the load",
        ),
    )  # fmt: skip


def _draw(result: NipResult) -> Drawing:
    from .. import plots

    figure = plots.plot_nip(result)
    figure.axes[-1].set_ylabel(r"$T - T_\mathrm{in}$ [N/m]")
    return figure
