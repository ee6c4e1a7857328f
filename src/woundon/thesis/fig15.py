"""Thesis Fig. 15, sec. 4.2: how the nip makes tension, Table 1 with P = 1900 and F = 100 N/m."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..results import NipResult
from ..zones import zone_runs
from .cases import paper_nip
from .frame import Figure, Scheme, Verdict
from .profiles import profiles
from .sweep import FINE, solved, zone_lengths

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Drawing

__all__ = ["figures"]

SHORT = 0.01  # of the nip width: a zone of a node or two


def figures(scheme: Scheme = "graded") -> tuple[Figure, ...]:
    """Solve the base case; return Fig. 15."""
    result = solved(paper_nip(), scheme, FINE)
    table = profiles([({}, result)])
    title = "Tractions, slips and web tension in the nip, hard drum"
    verdicts = (*_pattern(result), *_tension(result))
    return (Figure("fig15", title, scheme, table, verdicts, lambda: _draw(result)),)


def _pattern(r: NipResult) -> tuple[Verdict, ...]:
    roll = zone_runs(r.x, r.roll_zone)
    drum = [
        run for run in zone_runs(r.x, r.drum_zone) if run[2] - run[1] > SHORT * 2 * r.half_width
    ]
    lengths = zone_lengths(r)
    shortest = min(right - left for _, left, right in zone_runs(r.x, r.drum_zone))
    return (
        Verdict(
            "the web slips backward on the roll first, sticks from A on, slips forward from B on: "
            "zones in this order", float([int(zone) for zone, *_ in roll] == [-1, 0, 1]), 1, 1,
            note=f"1: yes.  s_r1 = {lengths.leading_roll:.3f}, s_r2 = {lengths.trailing_roll:.3f}",
        ),
        Verdict(
            "it sticks to the drum from the leading edge to C, then slips forward: zones in this "
            "order", float([int(zone) for zone, *_ in drum] == [0, 1]), 1, 1,
            note=f"1: yes.  s_d = {lengths.dual:.3f}; zones below 1 % of the width left out, the "
            f"shortest has {100 * shortest / (2 * r.half_width):.2f} %: at the very edge the "
            "pressure rises like a root, and no finite friction holds the web that it squeezes out",
        ),
        Verdict(
            "C lies behind B: the roll's face slips before the drum's",
            lengths.trailing_roll - lengths.dual, 0.0, note="s_r2 - s_d",
        ),
        Verdict(
            "the slip at the roll is negative at the leading edge",
            100 * float(r.roll_slip[0]), high=0.0, unit="%",
        ),
        Verdict(
            "and positive behind B", 100 * float(np.max(r.roll_slip)), 0.0, unit="%",
            note="largest v+",
        ),
    )  # fmt: skip


def _tension(r: NipResult) -> tuple[Verdict, ...]:
    T = r.web_tension - r.problem.web_tension
    C = r.half_width * (1 - 2 * zone_lengths(r).dual)
    before = np.flatnonzero(r.x < C)[:-1]  # the drum's stick zone, less the node beside C
    gained = r.nip_induced_tension - float(T[before][-1])
    paper, web = r.problem.web.material.stiffness, r.problem.web
    squeezed = -web.thickness * paper.rt / paper.rr * r.pressure
    miss = float(np.max(np.abs(T - squeezed)[before]))
    return (
        Verdict(
            "the tension grows in the dual slip zone only: its gain there over NIT",
            100 * gained / r.nip_induced_tension, 99.9, unit="%",
            note=f"{gained:.1f} of {r.nip_induced_tension:.1f} N/m",
        ),
        Verdict(
            "before C it falls a little", float(T[before].min()), high=0.0, unit="N/m",
            note=f"lowest tension, less T_in; the highest is {T[before].max():.2g}",
        ),
        Verdict(
            "because the pressure squeezes the web that the rigid drum holds (Poisson's effect): "
            "distance from -2h (A_rt/A_rr) p",
            100 * miss / float(-T.min()), high=5.0, unit="%",
            note="largest, over the deepest fall",
        ),
    )  # fmt: skip


def _draw(result: NipResult) -> Drawing:
    from .. import plots

    return plots.plot_nip(result)
