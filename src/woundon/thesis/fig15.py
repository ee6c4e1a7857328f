"""Thesis Fig. 15, sec. 4.2: how the nip makes tension, Table 1 with P = 1900 and F = 100 N/m."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..results import NipResult
from ..zones import zone_runs
from .cases import paper_nip
from .frame import Figure, Scheme, Verdict
from .profiles import profiles, squeezed
from .slip_zones import zone_lengths
from .sweep import FINE, solved

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Drawing

__all__ = ["figures"]

HEAVY_LOAD = 11000.0  # the heaviest of Fig. 16 [N/m]
SHORT = 0.01  # of the nip width: a zone of a node or two


def figures(scheme: Scheme = "graded") -> tuple[Figure, ...]:
    """Solve the base case; return Fig. 15."""
    result = solved(paper_nip(), scheme, FINE)
    heavy = solved(paper_nip(nip_load=HEAVY_LOAD), scheme, FINE)
    table = profiles([({}, result)])
    title = "Tractions, slips and web tension in the nip, hard drum"
    verdicts = (*_pattern(result, heavy), *_tension(result))
    return (Figure("fig15", title, scheme, table, verdicts, lambda: _draw(result)),)


def _pattern(r: NipResult, heavy: NipResult) -> tuple[Verdict, ...]:
    roll = zone_runs(r.x, r.roll_zone)
    drum = [
        run for run in zone_runs(r.x, r.drum_zone) if run[2] - run[1] > SHORT * 2 * r.half_width
    ]
    lengths = zone_lengths(r)
    shortest = min(right - left for _, left, right in zone_runs(r.x, r.drum_zone))
    return (
        Verdict.whether(
            "the web slips backward on the roll first, sticks from A on, slips forward from B on: "
            "zones in this order", [int(zone) for zone, *_ in roll] == [-1, 0, 1],
            f"s_r1 = {lengths.leading_roll:.3f}, s_r2 = {lengths.trailing_roll:.3f}",
        ),
        Verdict.whether(
            "it sticks to the drum from the leading edge to C, then slips forward: zones in this "
            "order", [int(zone) for zone, *_ in drum] == [0, 1],
            f"s_d = {lengths.dual:.3f}; zones below 1 % of the width left out, the "
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
        Verdict(
            "in some cases a very short stick area near C parts the roll's trailing slip zone: its "
            f"length at P = {HEAVY_LOAD / 1e3:.0f} kN/m", *_parting_stick(heavy), "% of the width",
            note="it is there with 257, 513 and 1025 nodes alike, so it is no artefact; at "
            "P = 1900 N/m, here shown, there is none",
        ),
    )  # fmt: skip


def _parting_stick(r: NipResult) -> tuple[float, float, float]:
    """Return the length of the roll's second stick zone [% of the width], and what is short."""
    sticks = [run for run in zone_runs(r.x, r.roll_zone) if run[0] == 0]
    second = sticks[1][2] - sticks[1][1] if len(sticks) > 1 else 0.0
    return 100 * second / (2 * r.half_width), 0.1, 5.0


def _tension(r: NipResult) -> tuple[Verdict, ...]:
    T = r.web_tension - r.problem.web_tension
    C = r.half_width * (1 - 2 * zone_lengths(r).dual)
    before = np.flatnonzero(r.x < C)[:-1]  # the drum's stick zone, less the node beside C
    gained = r.nip_induced_tension - float(T[before][-1])
    share, begins = squeezed(r)
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
            "because the pressure squeezes the web, which cannot stretch where it sticks to the "
            "rigid drum (Poisson's effect): the fall over 2h (A_rt/A_rr) times the rise of p",
            share, 0.95, 1.05,
            note=f"from where stick begins, at {100 * begins:.1f} % of the width",
        ),
    )  # fmt: skip


def _draw(result: NipResult) -> Drawing:
    from .. import plots

    return plots.plot_nip(result)
