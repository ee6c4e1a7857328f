"""Thesis Fig. 19, sec. 4.4: NIT against the friction between the layers."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .cases import paper_nip
from .frame import Figure, Scheme, Table, Verdict
from .sweep import WINDING_FORCES, sweep

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Drawing

__all__ = ["figures"]

Array = np.ndarray

NIP_LOADS = (1910.0, 4897.0)
FRICTIONS = np.linspace(0.05, 0.6, 45)
# the text tells for which forces there is a maximum; it is right from this friction on
LOWEST_FRICTION = 0.2 - 1e-9


def figures(scheme: Scheme = "graded") -> tuple[Figure, ...]:
    """Solve Table 1's nip over mu+ and winding force at both loads; return Fig. 19."""
    cases = (
        (
            {"nip_load": P, "winding_force": F, "roll_friction": mu},
            paper_nip(nip_load=P, winding_force=F, roll_friction=float(mu)),
        )
        for P in NIP_LOADS
        for F in WINDING_FORCES
        for mu in FRICTIONS
    )
    table = sweep(cases, scheme)
    title = "NIT against the friction between the layers"
    verdicts = (*_maxima(table), *_trends(table))
    return (Figure("fig19", title, scheme, table, verdicts, lambda: _draw(table)),)


def _curve(table: Table, P: float, F: float, lowest: float = 0.0) -> tuple[Array, Array]:
    rows = table.where(nip_load=P, winding_force=F).within("roll_friction", lowest)
    return rows["roll_friction"], rows["nip_induced_tension"]


def _maximum(table: Table, P: float, F: float) -> float:
    """Return the friction of the curve's maximum, nan if that is at an end."""
    mu, NIT = _curve(table, P, F)
    k = int(np.argmax(NIT))
    return float(mu[k]) if 0 < k < mu.size - 1 else float("nan")


def _maxima(table: Table) -> tuple[Verdict, ...]:
    def forces(P: float) -> list[float]:
        return [F for F in WINDING_FORCES if _maximum(table, P, F) >= LOWEST_FRICTION]

    def said(P: float) -> str:
        at = ", ".join(f"{F:.0f}: {_maximum(table, P, F):.3f}" for F in WINDING_FORCES)
        return f"highest such F.  Over all mu+ every curve has one, at mu+ by F [N/m] {at}"

    low, high = (forces(P) for P in NIP_LOADS)
    return (
        Verdict(
            "from mu+ = 0.2 on NIT has a maximum at the low load for F <= -200 N/m",
            max(low, default=-np.inf), -200, -200, "N/m",
            said(NIP_LOADS[0]) + ": below it the web slips forward on nearly the whole roll and "
            "NIT grows like mu+ P + F",
        ),
        Verdict("for each of these forces", float(len(low)), 3, 3, note="curves with a maximum"),
        Verdict(
            "and at the high load for F = -500 N/m only",
            max(high, default=-np.inf), -500, -500, "N/m", said(NIP_LOADS[1]),
        ),
    )  # fmt: skip


def _trends(table: Table) -> tuple[Verdict, ...]:
    """Return what is said of the falling parts; they are all falling from mu+ = 0.4 on."""
    falls = np.empty((len(NIP_LOADS), len(WINDING_FORCES)))
    steps: list[float] = []
    for i, P in enumerate(NIP_LOADS):
        for j, F in enumerate(WINDING_FORCES):
            _, NIT = _curve(table, P, F, 0.4)
            falls[i, j] = NIT[0] - NIT[-1]
            steps.append(float(np.max(np.diff(NIT))))
    return (
        Verdict(
            "beyond the maxima NIT falls as mu+ grows", max(steps), high=0.0, unit="N/m",
            note="largest step for mu+ >= 0.4",
        ),
        Verdict(
            "the curves are steeper at the higher load", float(np.min(falls[1] / falls[0])), 1.0,
            note="smallest ratio over F of the falls from mu+ = 0.4 to 0.6",
        ),
    )  # fmt: skip


def _draw(table: Table) -> Drawing:
    from . import drawing

    figure = drawing.blank()
    for axes, P in zip(figure.axes, NIP_LOADS, strict=True):
        drawing.curves(
            axes, table.where(nip_load=P), drawing.force_curves(),
            ("roll_friction", r"Friction between layers $\mu^+$", 1.0),
            ("nip_induced_tension", "NIT [N/m]", 1.0),
        )  # fmt: skip
        axes.set_title(f"$P = {P:.0f}$ N/m", fontsize=9)
    drawing.shared_legend(figure)
    return figure
