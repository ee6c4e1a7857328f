"""Thesis Fig. 35, sec. 4.9: the roll's strain about the nip, and whether the web slips behind it.

The figure's curves are those of the nip alone, the web held to the roll at its trailing edge (97).
What the section concludes from them is tested on the solved wrap.
"""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..assembly import surface_response
from ..contact.discretisation import discretisation
from ..elasticity.strip import compliance
from ..results import NipResult, Zone
from ..surface import roll_strain
from ..wrap import WrappedNipResult, solve_wrapped_nip
from .cases import paper_nip
from .frame import Figure, Scheme, Table, Verdict
from .sweep import FINE, solved

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Drawing

__all__ = ["figures"]

Array = np.ndarray

LOAD = 10e3  # [N/m]
FRICTIONS = (0.7, 0.2)
CLAIMED = 0.5  # [deg]
FARTHEST = 3.0  # [deg]


class _Nip(NamedTuple):
    """A nip of the figure: alone, wrapped, and the strain of its roll over the angle."""

    alone: NipResult
    wrapped: WrappedNipResult
    table: Table


def figures(scheme: Scheme = "graded") -> tuple[Figure, ...]:
    """Solve P = 10 kN/m with mu+ = 0.7 and 0.2, alone and wrapped; return Fig. 35."""
    nips = [_nip(mu, scheme) for mu in FRICTIONS]
    table = nips[0].table.stacked(nips[1].table)
    title = "Strain of the roll's surface about the nip, and growth rates behind it"
    return (Figure("fig35", title, scheme, table, _verdicts(nips), lambda: _draw(table)),)


@cache
def _nip(mu: float, scheme: Scheme) -> _Nip:
    problem = paper_nip(nip_load=LOAD, roll_friction=mu)
    alone = solved(problem, scheme, FINE)
    R, a = problem.roll.radius, alone.half_width
    behind = np.radians(np.geomspace(2e-3, FARTHEST, 120))  # from the trailing edge
    strain = roll_strain(alone, a + R * behind)
    inside_x, inside = _strain_in_nip(alone)
    web = problem.web
    rate = compliance(*web.material.stiffness[:3]).c11 / web.thickness * mu
    nan = np.full(inside.size, np.nan)
    table = Table.of(
        {
            "roll_friction [1]": np.full(inside.size + behind.size, mu),
            "angle [rad]": np.append((inside_x - a) / R, behind),
            "roll_strain [1]": np.append(inside, strain),
            "roll_rate [1/rad]": np.append(nan, np.gradient(strain, behind)),
            "web_rate [1/rad]": np.append(nan, rate * alone.wound_on_tension * np.exp(mu * behind)),
        }
    )
    return _Nip(alone, solve_wrapped_nip(problem, nodes=129), table)


def _strain_in_nip(result: NipResult) -> tuple[Array, Array]:
    """Return collocation points [m] and the roll's strain there."""
    disc = discretisation(result.scheme, result.nodes)
    response = surface_response(result.problem.roll, disc, result.half_width)
    assert response is not None
    strain = response.strain_p @ result.pressure[1:-1]
    strain += response.strain_q @ result.roll_traction[1:-1]
    return result.half_width * disc.middle, strain[:-1]


def _verdicts(nips: list[_Nip]) -> tuple[Verdict, ...]:
    return (*_of_the_nip_alone(nips), *_of_the_wrap(nips))


def _of_the_nip_alone(nips: list[_Nip]) -> tuple[Verdict, ...]:
    inside = max(float(t["roll_strain"][t["angle"] < 0].max()) for *_, t in nips)
    behind = [t.within("angle", 1e-12) for *_, t in nips]
    rises = all(bool(np.all(np.diff(t["roll_strain"]) > 0)) for t in behind)
    crossing = max(_crossing(t) for t in behind)
    return (
        Verdict(
            "the roll's surface is compressed everywhere in the nip: largest strain",
            100 * inside, high=0.0, unit="%",
        ),
        Verdict.whether("behind the nip its strain rises steadily towards zero", rises),
        Verdict(
            "behind the nip the roll's strain changes faster than that of a slipping web only "
            "within 0.5 degrees",
            crossing, high=CLAIMED, unit="deg",
            note="where the rates cross, measured from the trailing edge, the farther of the two; "
            f"to cross at 0.5 degrees the web would have to pull with {_tension_to_cross(nips)}",
        ),
    )  # fmt: skip


def _crossing(table: Table) -> float:
    """Return the angle beyond which the slipping web's strain grows faster [deg]."""
    faster = np.flatnonzero(table["roll_rate"] > table["web_rate"])
    return float(np.degrees(table["angle"][faster[-1]])) if faster.size else 0.0


def _tension_to_cross(nips: list[_Nip]) -> str:
    """Return the tensions at which the rates cross at the angle claimed; T_in is not given."""
    needed = []
    for alone, _, table in nips:
        behind = table.within("angle", 1e-12)
        k = int(np.argmin(np.abs(behind["angle"] - np.radians(CLAIMED))))
        share = behind["roll_rate"][k] / behind["web_rate"][k]
        needed.append(f"{share * alone.wound_on_tension / 1e3:.1f} kN/m")
    return " and ".join(needed)


def _of_the_wrap(nips: list[_Nip]) -> tuple[Verdict, ...]:
    angles = [float(np.degrees(w.slip_angle)) for _, w, _ in nips]
    forward = all(w.slip_zone is Zone.FORWARD for _, w, _ in nips)
    errors = [100 * abs(r.wound_on_tension / w.wound_on_tension - 1) for r, w, _ in nips]
    which = " and ".join(
        f"{e:.1f} % for mu+ = {mu:g}" for e, mu in zip(errors, FRICTIONS, strict=True)
    )
    far = " and ".join(f"{e:.2f} for mu+ = {mu:g}" for e, mu in zip(angles, FRICTIONS, strict=True))
    return (
        Verdict.whether(
            "so in centre winding the web slips on behind the nip, faster than the roll", forward,
            "on the solved wrap",
        ),
        Verdict(
            "but sticks again within about 0.5 degrees: solved slip angle", max(angles),
            high=2 * CLAIMED, unit="deg",
            note=f"{far}; the hoop pressure is too low to hold the web sooner, and while it slips "
            "on, less of its strain is taken from the nip",
        ),
        Verdict(
            "holding the web at the trailing edge errs by at most 4.5 % of the wound-on tension",
            max(errors), high=4.5, unit="%", note=f"against the solved wrap, {which}",
        ),
    )  # fmt: skip


def _draw(table: Table) -> Drawing:
    from . import drawing

    figure = drawing.blank(1, 2, (9.0, 3.9))
    strains, rates = figure.axes
    for k, mu in enumerate(FRICTIONS):
        rows = table.where(roll_friction=mu)
        angle = np.degrees(rows["angle"])
        behind = angle > 0
        look: Any = {"color": ("#0072B2", "#D55E00")[k]}
        strains.plot(
            angle, 100 * rows["roll_strain"], "-", label=rf"roll, $\mu^+$ = {mu:g}", **look
        )
        rates.loglog(angle[behind], np.abs(rows["roll_rate"][behind]), "-", **look)
        rates.loglog(
            angle[behind], rows["web_rate"][behind], "--",
            label=rf"slipping web, $\mu^+$ = {mu:g}", **look,
        )  # fmt: skip
    rates.axvline(CLAIMED, color="#666666", linewidth=0.8)
    for axes in (strains, rates):
        axes.set_xlabel(r"Angle behind the trailing edge $\theta$ [deg]")
    strains.set_ylabel(r"Roll surface strain $\varepsilon_{\theta 1}$ [%]")
    rates.set_ylabel(r"$|d\varepsilon/d\theta|$ [1/rad]")
    drawing.shared_legend(figure, 4)
    return figure
