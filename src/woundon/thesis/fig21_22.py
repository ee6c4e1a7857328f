"""Thesis Figs. 21 and 22, sec. 4.5: NIT against the radii of roll and drum."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from ..problems import NipProblem
from ..theories import dual_slip
from .cases import paper_nip
from .frame import Figure, Scheme, Table, Verdict
from .sweep import WINDING_FORCES, sweep

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Drawing

__all__ = ["figures"]

Array = np.ndarray

NIP_LOAD = 4850.0
RADII = np.array([0.1, 0.125, 0.15, 0.175, 0.2, 0.25, 0.3, 0.35, 0.4, 0.5, 0.6, 0.8, 1.0])
OTHERS = (0.25, 0.5)  # of the other body: panels (a) and (b)
_NAMES = {"roll": "drum", "drum": "roll"}


def figures(scheme: Scheme = "graded") -> tuple[Figure, ...]:
    """Solve Table 1's nip over both radii and the winding force; return Figs. 21 and 22."""
    tables = {body: sweep(_cases(body), scheme) for body in ("roll", "drum")}
    result = []
    for name, body in (("fig21", "roll"), ("fig22", "drum")):
        verdicts = list(_trends(tables[body], body))
        if body == "roll":
            verdicts.append(_increasing())
        else:
            verdicts.extend(_exponents(tables["roll"].stacked(tables["drum"])))
        result.append(
            Figure(
                name, f"NIT against the radius of the {body}", scheme, tables[body],
                tuple(verdicts), lambda body=body: _draw(tables[body], body),  # type: ignore[misc]
            )
        )  # fmt: skip
    return tuple(result)


def _cases(body: str) -> Iterator[tuple[dict[str, float], NipProblem]]:
    for other in OTHERS:
        for F in WINDING_FORCES:
            for R in RADII:
                radii = {f"{body}_radius": float(R), f"{_NAMES[body]}_radius": other}
                changes = {name.replace("_", "."): value for name, value in radii.items()}
                columns = {name: radii[name] for name in ("roll_radius", "drum_radius")}
                problem = paper_nip(nip_load=NIP_LOAD, winding_force=F, **changes)
                yield {"winding_force": F, **columns}, problem


def _by_panel(table: Table, name: str) -> Array:
    """Return an output as (panel, force, radius)."""
    return table[name].reshape(len(OTHERS), len(WINDING_FORCES), RADII.size)


def _trends(table: Table, body: str) -> tuple[Verdict, ...]:
    NIT, dual = _by_panel(table, "nip_induced_tension"), _by_panel(table, "dual_slip")
    half = int(np.flatnonzero(RADII == 0.5)[0])
    falls = NIT[:, :, 0] - NIT[:, :, -1]
    late = (NIT[:, :, half] - NIT[:, :, -1]) / falls
    other = _NAMES[body]
    return (
        Verdict(
            f"NIT falls as the {body}'s radius grows", float(np.max(np.diff(NIT, axis=2))),
            high=0.0, unit="N/m", note="largest step",
        ),
        Verdict(
            "it changes more at small radii: of its fall from 0.1 to 1 m, what is left from "
            "0.5 m on", 100 * float(np.max(late)), high=25.0, unit="%", note="largest",
        ),
        Verdict(
            "which is negligible", 100 * float(np.max(1 - NIT[:, 3:, -1] / NIT[:, 3:, half])),
            high=5.0, unit="%", note="fall of NIT from 0.5 to 1 m, largest for F >= 0; the power "
            "law of Fig. 22 asks for as much: the relative radius grows by a fifth to a third",
        ),
        Verdict(
            f"the lower the winding force, the less the {body}'s radius matters",
            float(np.min(np.diff(falls, axis=1))), 0.0, unit="N/m",
            note=f"smallest step of the falls over F; panel (a): "
            f"{', '.join(f'{fall:.0f}' for fall in falls[0])} N/m for F = -500 to 100",
        ),
        Verdict(
            f"a larger {other} gives less NIT", float(np.max(NIT[1] - NIT[0])), high=0.0,
            unit="N/m", note="largest difference of the panels, (b) less (a)",
        ),
        Verdict(
            "but steeper curves", float(np.min(falls[1] / falls[0])), 1.0,
            note="smallest ratio of the falls, (b) over (a)",
        ),
        Verdict(
            f"the dual slip ratio falls as the {body}'s radius grows",
            float(np.max(np.diff(dual, axis=2)[:, 3:])), high=1e-9,
            note="largest step, F >= 0",
        ),
    )  # fmt: skip


def _increasing() -> Verdict:
    problem, ratios = paper_nip(nip_load=NIP_LOAD), np.linspace(0.0, 1.0, 201)
    steps = np.diff([dual_slip(problem, float(s)) for s in ratios])
    return Verdict(
        "NIT by the dual slip ratio alone, eq. (173), grows with it",
        float(steps.min()),
        0.0,
        unit="N/m",
        note="smallest step of 1/200",
    )


def _exponents(table: Table) -> tuple[Verdict, ...]:
    """Fit ln NIT by the logarithms of the relative radius and of the drum's."""

    def fit(name: str, F: float) -> tuple[float, float]:
        rows = table.where(winding_force=F)
        R1, R2 = rows["roll_radius"], rows["drum_radius"]
        x = np.log(R1 * R2 / (R1 + R2) if name == "relative" else R2)
        y = np.log(rows["nip_induced_tension"])
        slope, level = np.polyfit(x, y, 1)
        return float(slope), float(np.std(y - slope * x - level))

    relative, drum = fit("relative", 0.0), fit("drum", 0.0)
    return (
        Verdict(
            "NIT goes with the relative radius R* to the power -1/2: fitted exponent, F = 0",
            relative[0], -0.55, -0.45,
            note="by F [N/m] "
            + ", ".join(f"{F:.0f}: {fit('relative', F)[0]:.2f}" for F in WINDING_FORCES)
            + ".  The strains go with a/R*, at a given load with R*^-1/2; but NIT over that strain "
            "still grows slowly with a, because the web brings a length of its own (Fig. 18)",
        ),
        Verdict(
            "and not with the drum's radius: scatter of ln NIT about the fit by R*, over that by "
            "the drum's", relative[1] / drum[1], high=0.2,
            note=f"{100 * relative[1]:.1f} % against {100 * drum[1]:.0f} % of NIT",
        ),
    )  # fmt: skip


def _draw(table: Table, body: str) -> Drawing:
    from . import drawing

    figure = drawing.blank()
    names = {"roll": "Roll radius $R_1$ [m]", "drum": "Drum radius $R_2$ [m]"}
    symbol = {"roll": "R_2", "drum": "R_1"}[body]
    for axes, other in zip(figure.axes, OTHERS, strict=True):
        drawing.curves(
            axes, table.where(**{f"{_NAMES[body]}_radius": other}), drawing.force_curves(),
            (f"{body}_radius", names[body], 1.0), ("nip_induced_tension", "NIT [N/m]", 1.0),
        )  # fmt: skip
        axes.set_title(f"${symbol} = {other}$ m", fontsize=9)
    drawing.shared_legend(figure)
    return figure
