"""Thesis Fig. 25, sec. 4.6: the nip of Fig. 15 with a soft drum cover.

2 cm of E = 10 MPa, nu = 0.1.  The text gives no nip load; since it compares with Fig. 15, that
figure's P = 1900 N/m is taken.
"""

from __future__ import annotations

import numpy as np

from .cases import covered_nip, paper_nip
from .exhibits import Exhibit
from .nips import FINE, Nip, along_nip, solved
from .panels import nip_panels, slips_and_increase
from .verdicts import Range, Verdict, at_least, exactly, verdict, whether
from .zones import runs

__all__ = ["exhibits"]

FALL_LOAD = 3000.0  # where the web tension falls by what the text says [N/m]


def exhibits(solver: str) -> list[Exhibit]:
    """Solve the soft-covered drum, and the hard one to compare with; return Fig. 25."""
    # without T_in, T is what the nip has added so far, as the thesis shows it
    soft, heavier = (
        solved(covered_nip(10e6, 0.1, nip_load=P, web_tension=0.0), solver, FINE)
        for P in (1900.0, FALL_LOAD)
    )
    hard = solved(paper_nip(), solver, FINE)
    verdicts = [
        *_tractions(hard, soft),
        *_pattern(soft),
        *_edges(soft, heavier),
        *_tension(soft, heavier),
    ]
    tractions, _, zones = nip_panels(soft)
    panels = [tractions, slips_and_increase(soft), zones]
    return [Exhibit("fig25", along_nip(soft), verdicts, panels)]


def _tractions(hard: Nip, soft: Nip) -> list[Verdict]:
    """Test the statements about the tractions with a soft and with a hard drum."""

    def smaller(name: str) -> float:
        """Return by how much the peak of a traction is smaller with the soft drum [%]."""
        peaks = [float(np.max(np.abs(getattr(r, name)))) for r in (soft, hard)]
        return 100 * (1 - peaks[0] / peaks[1])

    return [
        verdict(
            "tractions are more than 50 % smaller than with the hard drum: at the roll",
            smaller("roll_traction"),
            at_least(50.0, "%"),
            note="of the largest",
        ),
        verdict(
            "and at the drum",
            smaller("drum_traction"),
            at_least(50.0, "%"),
            note=f"of the largest.  It is bound to mu- p, and the wider nip's largest pressure is "
            f"{smaller('drum_pressure'):.0f} % smaller only",
        ),
    ]


def _pattern(r: Nip) -> list[Verdict]:
    """Test the statements about the stick and slip zones."""
    roll, drum, width = runs(r.x, r.roll_zone), runs(r.x, r.drum_zone), 2 * r.half_width
    forward = max((run for run in drum if run.zone == 1), key=lambda run: run.length)
    return [
        whether(
            "the roll's pattern is that of the hard drum: backward, stick, forward",
            [run.zone for run in roll] == [-1, 0, 1],
        ),
        whether(
            "the drum has a leading slip zone too, the web downstream of it",
            drum[0].zone == -1,
            note=f"v- < 0 on {100 * drum[0].length / width:.1f} % of the width",
        ),
        whether(
            "at the trailing edge the web is ahead of the drum first",
            max(run.zone for run in drum[1:]) == 1,
            note="v- > 0",
        ),
        verdict(
            "and downstream of it very near the edge", drum[-1].zone, exactly(-1), note="sign of v-"
        ),
        verdict(
            "from so near on",
            100 * (r.half_width - forward.right) / width,
            Range(1e-6, 2.0, "% of the width"),
        ),
        verdict(
            "slip is larger at the drum than at the roll: largest |v-| over largest |v+|",
            np.max(np.abs(r.drum_slip)) / np.max(np.abs(r.roll_slip)),
            at_least(1.0),
        ),
    ]


def _edges(r: Nip, heavier: Nip) -> list[Verdict]:
    """Test the statements about the slip at the edges of the nip."""
    # at the leading and at the trailing edge; the procedure of the thesis repeats the first value
    base, more = (100 * np.abs(nip.drum_slip[[1, -1]]) for nip in (r, heavier))
    return [
        verdict(
            "|v-| is about 0.35 % at the leading edge",
            base[0],
            Range(0.3, 0.4, "%"),
            note=f"{more[0]:.2f} % at P = {FALL_LOAD:.0f} N/m",
        ),
        verdict(
            "and at the trailing edge",
            base[1],
            Range(0.3, 0.4, "%"),
            note=f"{more[1]:.2f} % at P = {FALL_LOAD:.0f} N/m; it turns round within the last "
            "per cent of the width, where the cover's strain has a vertical tangent",
        ),
    ]


def _tension(r: Nip, heavier: Nip) -> list[Verdict]:
    """Test the statements about the web tension."""
    T, steps = r.tension, np.abs(np.diff(r.tension))
    both = (r.roll_zone == 0) & (r.drum_zone == 0)
    inside = both[1:] & both[:-1]
    return [
        verdict(
            "most of the tension's variation happens where both faces stick",
            100 * steps[inside].sum() / steps.sum(),
            at_least(50.0, "%"),
        ),
        verdict(
            "it is lowest at the nip's centre",
            r.x[np.argmin(T)] / r.half_width,
            Range(-0.1, 0.1),
            note="x/a of the lowest tension",
        ),
        verdict(
            "where it has fallen by almost 150 N/m",
            -T.min(),
            Range(135.0, 150.0, "N/m"),
            note=f"at P = 1900 N/m; at {FALL_LOAD:.0f} N/m it falls by {-heavier.tension.min():.0f}"
            " N/m, and the text does not give the load",
        ),
    ]
