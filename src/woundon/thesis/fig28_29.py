"""Thesis Figs. 28 and 29, sec. 4.7: NIT and dual slip ratio against the paper's moduli."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..materials import Orthotropic
from ..problems import NipProblem
from .cases import paper_nip
from .frame import Figure, Scheme, Table, Verdict
from .sweep import sweep

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Drawing

__all__ = ["constants_nip", "figures"]

Array = np.ndarray

SHEAR = (1e6, 20e6, 100e6)  # G: rows of panels (a), (b), (c) [Pa]
CROSS = (0.1e6, 1e6, 40e6)  # A_rt: columns of panels 1, 2, 3
RADIAL = (4e6, 20e6, 100e6)  # A_rr: curves
TANGENTIAL = 1e9 * np.array([0.5, 0.55, 0.6, 0.7, 0.85, 1, 1.5, 2, 3, 4, 5, 6, 7])  # A_tt: x axis


def constants_nip(*, radial: float, tangential: float, cross: float, shear: float) -> NipProblem:
    """Return Table 1's nip at 5 kN/m with other moduli of roll and web [Pa]."""
    paper = Orthotropic(radial=radial, tangential=tangential, cross=cross, shear=shear)
    return paper_nip(nip_load=5000.0, **{"web.material": paper, "roll.material": paper})


def figures(scheme: Scheme = "graded") -> tuple[Figure, ...]:
    """Solve the nip over the four moduli; return Figs. 28 and 29."""
    moduli = (
        {"shear": G, "cross": rt, "radial": rr, "tangential": float(tt)}
        for G in SHEAR
        for rt in CROSS
        for rr in RADIAL
        for tt in TANGENTIAL
    )
    table = sweep(((of, constants_nip(**of)) for of in moduli), scheme)
    return (
        Figure(
            "fig28", "NIT against the elastic constants of the paper", scheme, table,
            _tension_verdicts(table), lambda: _draw(table, "nip_induced_tension", "NIT [N/m]"),
        ),
        Figure(
            "fig29", "Dual slip ratio against the elastic constants of the paper", scheme, table,
            _dual_verdicts(table, scheme),
            lambda: _draw(table, "dual_slip", "Dual slip ratio $s_d$"),
        ),
    )  # fmt: skip


def _grid(table: Table, name: str) -> Array:
    """Return an output as (G, A_rt, A_rr, A_tt)."""
    return table[name].reshape(len(SHEAR), len(CROSS), len(RADIAL), TANGENTIAL.size)


def _where(found: Array) -> str:
    """Say at which moduli the flagged steps of A_rr lie."""
    places = [
        f"G {SHEAR[i] / 1e6:g}, A_rt {CROSS[j] / 1e6:g}, A_rr {RADIAL[k] / 1e6:g} to "
        f"{RADIAL[k + 1] / 1e6:g} MPa at A_tt {TANGENTIAL[found[i, j, k]].min() / 1e9:g} to "
        f"{TANGENTIAL[found[i, j, k]].max() / 1e9:g} GPa"
        for i, j, k in np.argwhere(found.any(axis=3))
    ]
    return "; ".join(places) or "nowhere"


def _tension_verdicts(table: Table) -> tuple[Verdict, ...]:
    NIT = _grid(table, "nip_induced_tension")
    rising = np.diff(NIT, axis=2) > 0
    exception = np.zeros_like(rising)
    exception[-1, -1][:, TANGENTIAL <= 0.61e9] = True
    small = 100 * np.abs(NIT[:, 1] / NIT[:, 0] - 1)
    return (
        Verdict(
            "NIT grows with A_tt", float(np.min(np.diff(NIT, axis=3))), 0.0, unit="N/m",
            note="smallest step",
        ),
        Verdict(
            "usually it falls as A_rr grows", 100 * float(np.mean(~rising)), 80.0,
            unit="% of the steps", note="the text says usually",
        ),
        Verdict(
            "except for A_tt from 0.5 to 0.6 GPa, A_rt = 40 MPa and G = 100 MPa: there it grows",
            float(np.max(np.diff(NIT, axis=2)[exception])), 0.0, unit="N/m", note="largest step",
        ),
        Verdict(
            "and nowhere else", float(np.sum(rising & ~exception)), high=0,
            note=f"steps that grow elsewhere.  All: {_where(rising)}.  A_rt^2 comes near A_rr A_tt "
            "there, and a soft roll loses more tension to Poisson's effect than it gains by being "
            "soft.  No web thickness from 20 to 100 um confines it to what the text says",
        ),
        Verdict(
            "it grows with G", float(np.min(np.diff(NIT, axis=0))), 0.0, unit="N/m",
            note="smallest step",
        ),
        Verdict(
            "up to A_rt = 1 MPa it does not depend on A_rt", float(small.max()), high=5.0, unit="%",
            note="largest change from 0.1 to 1 MPa",
        ),
        Verdict(
            "beyond, it falls as A_rt grows", float(np.max(NIT[:, 2] - NIT[:, 1])), high=0.0,
            unit="N/m", note="largest change from 1 to 40 MPa",
        ),
    )  # fmt: skip


def _dual_verdicts(table: Table, scheme: Scheme) -> tuple[Verdict, ...]:
    dual = _grid(table, "dual_slip")
    # what a step may fall by through the grid: a cell of the thesis's, a fraction of one else
    cell = {"graded": 0.001, "thesis": 0.005}[scheme]

    def verdict(statement: str, steps: Array, note: str = "") -> Verdict:
        grows = 100 * float(np.mean(steps > -cell))
        low, high = float(steps.min()), float(steps.max())
        said = f"steps from {low:.3f} to {high:.3f}{note}"
        return Verdict(statement, grows, 95.0, unit="% of the steps", note=said)

    by_cross = np.diff(dual, axis=1)
    high_end = 100 * float(np.mean(by_cross[..., TANGENTIAL > 3.5e9] > -cell))
    return (
        verdict("the dual slip ratio grows with A_tt", np.diff(dual, axis=3)),
        verdict(
            "with A_rr", np.diff(dual, axis=2),
            ".  It falls, as NIT does; the text likens it to NIT in the same sentence, so that "
            "this may be a slip of the pen",
        ),
        verdict("with G", np.diff(dual, axis=0)),
        verdict(
            "and, unlike NIT, with A_rt", by_cross,
            f".  It does in {high_end:.0f} % of the steps with A_tt of 4 GPa or more, as in "
            "Fig. 30; where A_tt is small, A_rt^2 comes near A_rr A_tt and it falls",
        ),
    )  # fmt: skip


def _draw(table: Table, name: str, label: str) -> Drawing:
    from . import drawing

    figure = drawing.blank(3, 3, (9.0, 8.4), letters=False)
    lines = [
        drawing.Curve(k, f"$A_{{rr}}$ = {rr / 1e6:g} MPa", radial=rr) for k, rr in enumerate(RADIAL)
    ]
    for k, axes in enumerate(figure.axes):
        row, column = divmod(k, 3)
        panel = table.where(shear=SHEAR[row], cross=CROSS[column])
        x_label = r"$A_{\theta\theta}$ [GPa]" if row == 2 else ""
        drawing.curves(
            axes, panel, lines, ("tangential", x_label, 1e-9),
            (name, label if column == 0 else "", 1.0),
        )  # fmt: skip
        axes.set_title(
            f"({'abc'[row]}$_{column + 1}$)  $G$ = {SHEAR[row] / 1e6:g}, "
            rf"$A_{{r\theta}}$ = {CROSS[column] / 1e6:g} MPa",
            fontsize=8.5,
        )
    drawing.shared_legend(figure, 3)
    return figure
