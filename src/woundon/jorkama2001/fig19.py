"""Thesis Fig. 19, sec. 4.4: NIT against the friction between the layers.

The thesis holds the web to the roll from the trailing edge on (97).  What the section says is
tested on that, and again on fewer points with the web wrapped on half the roll downstream of the
nip.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import xarray as xr

from ..report.panels import Curve, Panel
from .cases import WINDING_FORCES, paper_nip
from .exhibits import Exhibit
from .nips import OUTPUTS, swept
from .panels import curve_panels, curves
from .verdicts import Verdict, accurate, at_least, at_most, exactly, verdict

__all__ = ["exhibits"]

NIP_LOADS = (1910.0, 4897.0)
FRICTIONS = np.linspace(0.05, 0.6, 45)
OVER = {"nip_load": NIP_LOADS, "winding_force": WINDING_FORCES, "roll_friction": FRICTIONS}
# the text tells for which forces there is a maximum; it is right from this friction on
LOWEST_FRICTION = 0.2 - 1e-9
CONFINED, WRAPPED, ESTIMATE = "nip_induced_tension", "wrapped_tension", "estimate"


def exhibits(solver: str) -> list[Exhibit]:
    """Solve Table 1's nip over mu+ and winding force at both loads; return Fig. 19."""
    data = swept(paper_nip(), OVER, solver, [*OUTPUTS, "wound_on_tension_estimate"])
    wrapped = _wrapped().rename({CONFINED: WRAPPED, "wound_on_tension": "wrapped_added"})
    data = data.rename(wound_on_tension_estimate=ESTIMATE)
    data = data.merge(wrapped.reindex_like(data), join="exact")
    for name in (ESTIMATE, "wrapped_added"):
        data[name].values -= paper_nip().web_tension
    verdicts = [
        *_statements(data[CONFINED], ""),
        *accurate(
            _statements(data[WRAPPED], "with the web wrapped on the roll downstream of the nip: ")
        ),
        *accurate([_share_of_fall()]),
    ]
    return [Exhibit("fig19", data, verdicts, _panels(data))]


@cache
def _wrapped() -> xr.Dataset:
    """Solve the wrapped nip; NIT is the increase of tension between the edges of the nip."""
    data = swept(
        paper_nip().replace(roll_wrap=np.pi),
        OVER | {"roll_friction": FRICTIONS[::4]},
        outputs=["inlet_tension", "outlet_tension", "wound_on_tension"],
        nodes=65,
    )
    data[CONFINED] = data["outlet_tension"] - data["inlet_tension"]
    data[CONFINED].attrs["units"] = "N/m"
    return data[[CONFINED, "wound_on_tension"]]


def _statements(NIT: xr.DataArray, when: str) -> list[Verdict]:
    """Test the statements about the nip-induced tension over the friction.

    ``when`` is the condition with which the first statement begins.
    """
    curves = NIT.dropna("roll_friction")
    low, high = (_maxima(curves.sel(nip_load=P)) for P in NIP_LOADS)  # mu+ by winding force
    said = [
        "highest such F.  Over all mu+ the maxima lie at mu+ by F [N/m] "
        + ", ".join(f"{F:.0f}: {mu:.3f}" for F, mu in maxima.items())
        for maxima in (low, high)
    ]
    steps, fall = _beyond_maxima(curves)
    low_forces, high_forces = ([F for F in m if m[F] >= LOWEST_FRICTION] for m in (low, high))
    return [
        verdict(
            f"{when}from mu+ = 0.2 on NIT has a maximum at the low load for F <= -200 N/m",
            max(low_forces, default=-np.inf),
            exactly(-200, "N/m"),
            note=f"{said[0]}: below it the web "
            "slips forward on nearly the whole roll and NIT grows like mu+ P + F",
        ),
        verdict(
            "for each of these forces", len(low_forces), exactly(3), note="curves with a maximum"
        ),
        verdict(
            "and at the high load for F = -500 N/m only",
            max(high_forces, default=-np.inf),
            exactly(-500, "N/m"),
            note=said[1],
        ),
        verdict(
            "beyond the maxima NIT falls as mu+ grows",
            steps,
            at_most(0.0, "N/m"),
            note="largest step",
        ),
        verdict(
            "the curves are steeper at the higher load",
            (fall[1] / fall[0]).min(),
            at_least(1.0),
            note="smallest ratio over F of the falls from the maximum to mu+ = 0.6",
        ),
    ]


def _maxima(NIT: xr.DataArray) -> dict[float, float]:
    """Return the friction of each curve's maximum by winding force, nan if that is at an end."""
    at = NIT.idxmax("roll_friction")
    inner = at.isin(NIT["roll_friction"][1:-1])
    return dict(zip(WINDING_FORCES, at.where(inner).values.tolist(), strict=True))


def _beyond_maxima(NIT: xr.DataArray) -> tuple[xr.DataArray, xr.DataArray]:
    """Return the largest increase, and the decrease of each curve, beyond the maxima of NIT."""
    friction = NIT["roll_friction"]
    beyond = NIT.where(friction >= NIT.idxmax("roll_friction") - 1e-9)
    return beyond.diff("roll_friction").max(), beyond.max("roll_friction") - beyond[..., -1]


def _share_of_fall() -> Verdict:
    """Compare the falls of NIT in centre winding from mu+ = 0.1 to 0.6."""
    over = {"nip_load": NIP_LOADS, "roll_friction": [0.1, 0.6]}
    nips = swept(
        paper_nip(winding_force=0.0), over, outputs=[CONFINED, "wound_on_tension_estimate"]
    )
    wrapped = _wrapped()[CONFINED].sel(winding_force=0.0)
    wrapped = wrapped.sel(roll_friction=over["roll_friction"], method="nearest")
    fall = wrapped.diff("roll_friction").values / nips[CONFINED].diff("roll_friction").values
    estimate = nips["wound_on_tension_estimate"] - paper_nip().web_tension
    said = [
        "{:.0f} to {:.0f} N/m".format(*at[-1].values) for at in (nips[CONFINED], wrapped, estimate)
    ]
    return verdict(
        "and the decrease that was expected is the nip's own, in centre winding from mu+ = 0.1 to "
        "0.6: fall over that with the web held at the trailing edge",
        fall.min(),
        at_least(0.5),
        note=f"the lesser of both loads.  At P = {NIP_LOADS[1]:.0f} N/m NIT goes from {said[0]} "
        f"held there, from {said[1]} wrapped, and from {said[2]} by (183): most of the fall is the "
        "condition at the trailing edge (97), by which friction binds the web to a surface that is "
        "compressed there",
    )


def _panels(data: xr.Dataset) -> list[Panel]:
    """Return the curves of the nip alone, with points with the web wrapped, thin lines by (183)."""
    x, along = "roll_friction", "winding_force"
    points: dict[str, Any] = {"line": "none", "marker": "point"}
    thin: dict[str, Any] = {"line": "solid", "width": 0.6}
    nothing = np.empty(0)
    legend = (
        Curve(WRAPPED, nothing, nothing, label="wrapped", colour="soft", **points),
        Curve(ESTIMATE, nothing, nothing, label="by (183)", colour="soft", **thin),
    )
    alone = curve_panels(data, [CONFINED], x, along, panels="nip_load")
    panels = []
    for panel, P in zip(alone, NIP_LOADS, strict=True):
        part = data.sel(nip_load=P)
        compared = (
            *curves(part, x, WRAPPED, along, in_legend=False, **points),
            *curves(part, x, ESTIMATE, along, in_legend=False, **thin),
        )
        panels.append(replace(panel, curves=(*panel.curves, *compared)))
    return [*panels[:-1], replace(panels[-1], curves=(*panels[-1].curves, *legend))]
