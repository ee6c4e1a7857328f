"""Thesis Fig. 35, sec. 4.9: strain of the roll around the nip, and slip downstream of it.

The figure's curves are those of the nip alone, the web held to the roll at its trailing edge (97).
What the section concludes from them is tested on the solved wrap.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import NamedTuple

import numpy as np
import xarray as xr

import woundon as wo

from ..report.panels import Curve, Mark, Panel
from .cases import paper_nip
from .exhibits import Exhibit
from .fig34 import web_rate
from .influence import surface_strain
from .nips import FINE, Nip, dataset, joined, solved, solved_accurately
from .panels import COLOURS, LEGEND, axis, named
from .verdicts import Verdict, accurate, at_most, verdict, whether

__all__ = ["exhibits"]

LOAD = 10e3  # [N/m]
FRICTIONS = (0.7, 0.2)
CLAIMED = 0.5  # [deg]
FARTHEST = 3.0  # [deg]


class _Nip(NamedTuple):
    """A nip of the figure, without wrap and with the web wrapped on half the roll.

    ``data`` are roll strain, and its rate and that of a slipping web downstream of the nip (nan in
    the nip), over the angle from the trailing edge.
    """

    alone: Nip
    wrapped: wo.NipResult
    data: xr.Dataset

    @property
    def downstream(self) -> xr.Dataset:
        """Strain downstream of the nip."""
        return self.data.isel(point=self.data["angle"].values > 0)


def exhibits(solver: str) -> list[Exhibit]:
    """Solve P = 10 kN/m with mu+ = 0.7 and 0.2, alone and wrapped; return Fig. 35."""
    nips = [_nip(mu, solver) for mu in FRICTIONS]
    data = joined("roll_friction [1]", dict(zip(FRICTIONS, (n.data for n in nips), strict=True)))
    verdicts = [*_of_the_nip_alone(nips), *_of_the_wrap(nips)]
    return [Exhibit("fig35", data, verdicts, _panels(nips))]


@cache
def _nip(mu: float, solver: str) -> _Nip:
    """Solve the nip with and without a wrap; compute strains and rates downstream of it."""
    problem = paper_nip(nip_load=LOAD, roll_friction=mu)
    alone = solved(problem, solver, FINE)
    R, a = problem.roll.radius, alone.half_width
    downstream = np.radians(np.geomspace(2e-3, FARTHEST, 120))  # from the trailing edge
    strain = _roll_strain(alone, a + R * downstream)
    inside_x = alone.slip_x[1:]  # without the first, which may be repeated
    inside = _roll_strain(alone, inside_x)
    tension = problem.web_tension + alone.nip_induced_tension
    nan = np.full(inside.size, np.nan)
    data = dataset(
        "point",
        {
            "angle [rad]": np.append((inside_x - a) / R, downstream),
            "roll_strain [1]": np.append(inside, strain),
            "roll_rate [1/rad]": np.append(nan, np.gradient(strain, downstream)),
            "web_rate [1/rad]": np.append(nan, web_rate(problem.web, tension, mu, downstream)),
        },
    )
    return _Nip(alone, solved_accurately(problem.replace(roll_wrap=np.pi)), data)


def _roll_strain(r: Nip, x: np.ndarray) -> np.ndarray:
    """Return the strain of the roll's surface under the tractions of the nip, at any points."""
    return surface_strain(r.problem.roll, r.x, r.drum_pressure, r.roll_traction, x)


def _of_the_nip_alone(nips: list[_Nip]) -> list[Verdict]:
    """Test the statements about the nip without a wrap."""
    inside = max(n.data["roll_strain"][n.data["angle"] < 0].max() for n in nips)
    rises = all(bool((n.downstream["roll_strain"].diff("point") > 0).all()) for n in nips)
    return [
        verdict(
            "the roll's surface is compressed everywhere in the nip: largest strain",
            100 * inside,
            at_most(0.0, "%"),
        ),
        whether("downstream of the nip its strain rises steadily towards zero", rises),
        verdict(
            "downstream of the nip the roll's strain changes faster than that of a slipping web "
            "only within 0.5 degrees",
            max(_crossing(n.downstream) for n in nips),
            at_most(CLAIMED, "deg"),
            note="where the rates cross, measured from the trailing edge, the farther of the two; "
            "to cross at 0.5 degrees the web would have to pull with "
            + " and ".join(f"{_tension_to_cross(n) / 1e3:.1f} kN/m" for n in nips),
        ),
    ]


def _crossing(downstream: xr.Dataset) -> float:
    """Return the angle beyond which the slipping web's strain grows faster [deg]; 0 if always."""
    faster = np.flatnonzero(downstream["roll_rate"] > downstream["web_rate"])
    return float(np.degrees(downstream["angle"][faster[-1]])) if faster.size else 0.0


def _tension_to_cross(nip: _Nip) -> float:
    """Return the tension at which the rates cross at the angle claimed [N/m]; T_in is not given."""
    # the rate of the web is proportional to its tension
    at = int(np.argmin(np.abs(nip.downstream["angle"].values - np.radians(CLAIMED))))
    share = nip.downstream["roll_rate"][at] / nip.downstream["web_rate"][at]
    return float(share) * float(nip.alone.tension[-1])


def _of_the_wrap(nips: list[_Nip]) -> list[Verdict]:
    """Test the statements about the wrapped nip."""
    angles = [float(np.degrees(n.wrapped.slip_angle)) for n in nips]
    errors = [100 * abs(n.alone.tension[-1] / n.wrapped.wound_on_tension - 1) for n in nips]
    errors_text, angles_text = (
        " and ".join(f"{text} for mu+ = {mu:g}" for text, mu in zip(texts, FRICTIONS, strict=True))
        for texts in ([f"{e:.1f} %" for e in errors], [f"{angle:.2f}" for angle in angles])
    )
    of_the_wrap_alone = [
        whether(
            "so in centre winding the web slips on downstream of the nip, faster than the roll",
            all(n.wrapped.slip_zone is wo.Zone.FORWARD for n in nips),
            note="on the solved wrap",
        ),
        verdict(
            "but sticks again within about 0.5 degrees: solved slip angle",
            max(angles),
            at_most(2 * CLAIMED, "deg"),
            note=f"{angles_text}; the hoop pressure is too low to hold the web sooner, and while "
            "it slips on, less of its strain is taken from the nip",
        ),
    ]
    return [
        *accurate(of_the_wrap_alone),
        verdict(
            "holding the web at the trailing edge errs by at most 4.5 % of the wound-on tension",
            max(errors),
            at_most(4.5, "%"),
            note=f"against the solved wrap, {errors_text}",
        ),
    ]


def _panels(nips: list[_Nip]) -> list[Panel]:
    """Return the panels of the strain around the nip and of the rates downstream of it."""
    strains, rates = [], []
    for nip, mu, colour in zip(nips, FRICTIONS, COLOURS, strict=False):
        angle, strain = nip.data["angle"].values, nip.data["roll_strain"].values
        strains.append(Curve("roll_strain", angle, strain, colour=colour))
        for body, line in (("roll", "solid"), ("web", "dashed")):
            name, label = f"{body}_rate", f"{body}, {named('roll_friction', mu)}"
            rate = np.abs(nip.downstream[name].values)
            angle = nip.downstream["angle"].values
            rates.append(Curve(name, angle, rate, label=label, colour=colour, line=line))
    claimed = Mark("y", np.radians(CLAIMED))
    logarithmic = replace(axis("angle"), log=True)
    return [
        Panel("strains", axis("angle"), axis("roll_strain"), curves=tuple(strains), width=4.5),
        Panel(
            "rates",
            logarithmic,
            axis("roll_rate"),
            curves=tuple(rates),
            marks=(claimed,),
            column="rates",
            legend="right",
            width=4.5 + LEGEND,
        ),
    ]
