"""Thesis Figs. 21 and 22, sec. 4.5: NIT against the radii of roll and drum."""

from __future__ import annotations

import numpy as np
import pandas as pd
import xarray as xr

import woundon as wo

from .cases import WINDING_FORCES, paper_nip
from .exhibits import Exhibit
from .nips import swept
from .panels import curve_panels
from .verdicts import Range, Verdict, at_least, at_most, falls, grows, verdict

__all__ = ["exhibits"]

NIP_LOAD = 4850.0
RADII = np.array([0.1, 0.125, 0.15, 0.175, 0.2, 0.25, 0.3, 0.35, 0.4, 0.5, 0.6, 0.8, 1.0])
OTHERS = (0.25, 0.5)  # of the other body: panels (a) and (b)
_OTHER = {"roll": "drum", "drum": "roll"}


def exhibits(solver: str) -> list[Exhibit]:
    """Solve Table 1's nip over both radii and the winding force; return Figs. 21 and 22."""
    data = {body: _swept(body, solver) for body in _OTHER}
    own = {"roll": [_increasing()], "drum": _exponents(list(data.values()))}
    return [
        Exhibit(
            name,
            data[body],
            [*_trends(data[body], body), *own[body]],
            curve_panels(
                data[body],
                ["nip_induced_tension"],
                f"{body}_radius",
                panels=f"{_OTHER[body]}_radius",
            ),
        )
        for name, body in (("fig21", "roll"), ("fig22", "drum"))
    ]


def _swept(body: str, solver: str) -> xr.Dataset:
    """Solve the nip; dimensions: radius of the other body, winding force, radius of the body."""
    over = {
        f"{_OTHER[body]}_radius": OTHERS,
        "winding_force": WINDING_FORCES,
        f"{body}_radius": RADII,
    }
    return swept(paper_nip(nip_load=NIP_LOAD), over, solver)


def _trends(data: xr.Dataset, body: str) -> list[Verdict]:
    """Test the statements about the trends over the radius of a body, "roll" or "drum".

    Dimensions as of :func:`_swept`; [:, 3:] are the winding forces >= 0.
    """
    radius, other = f"{body}_radius", _OTHER[body]
    NIT = data["nip_induced_tension"]
    largest, half = NIT.sel({radius: 1.0}), NIT.sel({radius: 0.5})
    total = NIT.sel({radius: 0.1}) - largest
    return [
        falls(f"NIT falls as the {body}'s radius grows", NIT, radius),
        verdict(
            "it changes more at small radii: of its fall from 0.1 to 1 m, what is left from "
            "0.5 m on",
            100 * ((half - largest) / total).max(),
            at_most(25.0, "%"),
            note="largest",
        ),
        verdict(
            "which is negligible",
            100 * (1 - largest / half)[:, 3:].max(),
            at_most(5.0, "%"),
            note="fall of NIT from 0.5 to 1 m, largest for F >= 0; the power "
            "law of Fig. 22 asks for as much: the relative radius grows by a fifth to a third",
        ),
        grows(
            f"the lower the winding force, the less the {body}'s radius matters",
            total,
            "winding_force",
            note="smallest step of the falls over F; panel (a): "
            f"{', '.join(f'{fall:.0f}' for fall in total[0])} N/m for F = -500 to 100",
        ),
        falls(
            f"a larger {other} gives less NIT",
            NIT,
            f"{other}_radius",
            note="largest difference of the panels, (b) less (a)",
        ),
        verdict(
            "but steeper curves",
            (total[1] / total[0]).min(),
            at_least(1.0),
            note="smallest ratio of the falls, (b) over (a)",
        ),
        verdict(
            f"the dual slip ratio falls as the {body}'s radius grows",
            data["dual_slip"][:, 3:].diff(radius).max(),
            at_most(1e-9),
            note="largest step, F >= 0",
        ),
    ]


def _increasing() -> Verdict:
    """Test if the closed form (173) increases with the dual slip ratio."""
    problem, ratios = paper_nip(nip_load=NIP_LOAD), np.linspace(0.0, 1.0, 201)
    steps = np.diff([wo.theories.dual_slip(problem, float(s)) for s in ratios])
    return verdict(
        "NIT by the dual slip ratio alone, eq. (173), grows with it",
        steps.min(),
        at_least(0.0, "N/m"),
        note="smallest step of 1/200",
    )


def _exponents(data: list[xr.Dataset]) -> list[Verdict]:
    """Fit ln NIT by the logarithms of the relative radius and of the drum's."""
    nips = pd.concat([one["nip_induced_tension"].to_dataframe().reset_index() for one in data])
    R1, R2 = nips["roll_radius"], nips["drum_radius"]
    logarithms = nips.assign(
        relative=np.log(R1 * R2 / (R1 + R2)),
        drum=np.log(R2),
        tension=np.log(nips["nip_induced_tension"]),
    )

    def fit(radius: str, F: float) -> tuple[float, float]:
        """Return exponent and scatter of NIT by a radius for one winding force."""
        chosen = logarithms[logarithms["winding_force"] == F]
        x, y = chosen[radius], chosen["tension"]
        slope, level = np.polyfit(x, y, 1)
        return float(slope), float(np.std(y - slope * x - level))

    relative, drum = fit("relative", 0.0), fit("drum", 0.0)
    return [
        verdict(
            "NIT goes with the relative radius R* to the power -1/2: fitted exponent, F = 0",
            relative[0],
            Range(-0.55, -0.45),
            note="by F [N/m] "
            + ", ".join(f"{F:.0f}: {fit('relative', F)[0]:.2f}" for F in WINDING_FORCES)
            + ".  The strains go with a/R*, at a given load with R*^-1/2; but NIT over that strain "
            "still grows slowly with a, because the web brings a length of its own (Fig. 18)",
        ),
        verdict(
            "and not with the drum's radius: scatter of ln NIT about the fit by R*, over that by "
            "the drum's",
            relative[1] / drum[1],
            at_most(0.2),
            note=f"{100 * relative[1]:.1f} % against {100 * drum[1]:.0f} % of NIT",
        ),
    ]
