"""Thesis Fig. 15, sec. 4.2: how the nip adds tension, Table 1 with P = 1900 and F = 100 N/m."""

from __future__ import annotations

import numpy as np

from .cases import paper_nip
from .exhibits import Exhibit
from .nips import FINE, Nip, along_nip, solved
from .panels import nip_panels
from .verdicts import Range, Verdict, at_least, at_most, verdict, whether
from .zones import runs, zone_lengths

__all__ = ["exhibits", "gain_in_dual_slip", "squeezed"]

HEAVY_LOAD = 11000.0  # the heaviest of Fig. 16 [N/m]
SHORT = 0.01  # of the nip width: a zone of a node or two


def exhibits(solver: str) -> list[Exhibit]:
    """Solve the base case; return Fig. 15."""
    result = solved(paper_nip(), solver, FINE)
    heavy = solved(paper_nip(nip_load=HEAVY_LOAD), solver, FINE)
    verdicts = [*_pattern(result, heavy), *_tension(result)]
    return [Exhibit("fig15", along_nip(result), verdicts, nip_panels(result))]


def _pattern(r: Nip, heavy: Nip) -> list[Verdict]:
    """Test the statements about the stick and slip zones."""
    roll, drum, width = runs(r.x, r.roll_zone), runs(r.x, r.drum_zone), 2 * r.half_width
    lengths = zone_lengths(r)
    shortest = min(run.length for run in drum)
    return [
        whether(
            "the web slips backward on the roll first, sticks from A on, slips forward from B on: "
            "zones in this order",
            [run.zone for run in roll] == [-1, 0, 1],
            note=f"s_r1 = {lengths.leading_roll:.3f}, s_r2 = {lengths.trailing_roll:.3f}",
        ),
        whether(
            "it sticks to the drum from the leading edge to C, then slips forward: zones in this "
            "order",
            [run.zone for run in drum if run.length > SHORT * width] == [0, 1],
            note=f"s_d = {lengths.dual:.3f}; zones below 1 % of the width left out, the "
            f"shortest has {100 * shortest / width:.2f} %: at the very edge the "
            "pressure rises like a root, and no finite friction holds the web that it squeezes out",
        ),
        verdict(
            "C lies downstream of B: the roll's face slips before the drum's",
            lengths.trailing_roll - lengths.dual,
            at_least(0.0),
            note="s_r2 - s_d",
        ),
        verdict(
            "the slip at the roll is negative at the leading edge",
            100 * r.roll_slip[0],
            at_most(0.0, "%"),
        ),
        verdict(
            "and positive downstream of B",
            100 * r.roll_slip.max(),
            at_least(0.0, "%"),
            note="largest v+",
        ),
        verdict(
            "in some cases a very short stick area near C parts the roll's trailing slip zone: its "
            f"length at P = {HEAVY_LOAD / 1e3:.0f} kN/m",
            _parting_stick(heavy),
            Range(0.1, 5.0, "% of the width"),
            note="it is there with 257, 513 and 1025 nodes alike, so it is no artefact; at "
            "P = 1900 N/m, here shown, there is none",
        ),
    ]


def _parting_stick(r: Nip) -> float:
    """Return the length of the roll's second stick zone [% of the width]."""
    sticks = [run.length for run in runs(r.x, r.roll_zone) if run.zone == 0]
    return 100 * sticks[1] / (2 * r.half_width) if len(sticks) > 1 else 0.0


def _tension(r: Nip) -> list[Verdict]:
    """Test the statements about the web tension along the nip."""
    before = (r.tension - r.problem.web_tension)[: _dual_from(r) + 1]
    gained = gain_in_dual_slip(r)
    share, begins = squeezed(r)
    return [
        verdict(
            "the tension grows in the dual slip zone only: its gain there over NIT",
            100 * gained / r.nip_induced_tension,
            at_least(99.9, "%"),
            note=f"{gained:.1f} of {r.nip_induced_tension:.1f} N/m",
        ),
        verdict(
            "before C it falls a little",
            before.min(),
            at_most(0.0, "N/m"),
            note=f"lowest tension, less T_in; the highest is {before.max():.2g}",
        ),
        verdict(
            "because the pressure squeezes the web, which cannot stretch where it sticks to the "
            "rigid drum (Poisson's effect): the fall over 2h (A_rt/A_rr) times the rise of p",
            share,
            Range(0.95, 1.05),
            note=f"from where stick begins, at {100 * begins:.1f} % of the width",
        ),
    ]


def _dual_from(r: Nip) -> int:
    """Return the last node of the drum's stick zone except the neighbour of C."""
    C = r.half_width * (1 - 2 * zone_lengths(r).dual)
    return int(np.flatnonzero(r.x < C)[-2])  # the last is the neighbour of C


def gain_in_dual_slip(r: Nip) -> float:
    """Return the increase of the web tension in the dual slip zone [N/m]."""
    return float(r.tension[-1] - r.tension[_dual_from(r)])


def squeezed(r: Nip) -> tuple[float, float]:
    """Compare the fall of the tension where the web sticks to a rigid drum with Poisson's effect.

    There the web cannot stretch, so that T falls by 2h (A_rt/A_rr) times the rise of p.

    Parameters
    ----------
    r : NipResult or ProcedureResult

    Returns
    -------
    share : float
        The fall to the lowest tension over that, from where the web first sticks.
    begins : float
        Where it does, as a share of the nip's width.
    """
    low = int(np.argmin(r.tension))
    slips = np.flatnonzero(r.drum_zone[:low] != 0)
    first = int(slips[-1]) + 1 if slips.size else 0
    paper, thickness = r.problem.web.material.stiffness, r.problem.web.thickness
    rise = float(r.drum_pressure[low] - r.drum_pressure[first])
    fall = float(r.tension[first] - r.tension[low])
    begins = float(r.x[first] / r.half_width + 1) / 2
    return fall / (thickness * paper.rt / paper.rr * rise), begins
