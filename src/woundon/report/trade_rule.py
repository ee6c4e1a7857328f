"""The trade rule NIT = mu N next to the solution, with the reason for the difference.

The rule is full slip: friction of the whole nip load pulls the web forward on the roll, so that

    NIT = mu N + F;     F = 0 (centre winding): NIT = mu N,   F = -T_in (surface): WOT = mu N.

The equilibrium of the web between its span and the end of the roll wrap is
NIT = Q+ + F + Q_w+ + sum F_k, with the tractions Q+ and Q_w+ on the roll in the nip and downstream
of it, and the winding forces F_k of further drums.  With the friction mu_e that an air film leaves,

    NIT - (mu N + F) = (Q+ - mu_e N) - (mu - mu_e) N + Q_w+ + sum F_k.

docs/theory/simple_formulas.md
"""

from __future__ import annotations

from math import isclose

import numpy as np

from .. import theories
from ..nip.result import NipResult
from ..results import Zone
from ..roll.density import mean_over_length
from ..winding.result import WindingResult
from .report_parts import Section, output_row

__all__ = ["nip_trade_rule", "winding_trade_rule"]

Array = np.ndarray

TITLE = "Trade rule NIT = mu N (full slip on the roll, N the nip load)"
SLIPS = "The web slips forward on the roll in the whole nip, as the rule assumes."
NOT_SAVED = (
    "Where the web slips and sticks in the nips is not saved with a result: solve the problem "
    "again to see the shares of the nip load."
)
PRESCRIBED = "The wound-on tension is prescribed and does not follow from this rule."


def nip_trade_rule(result: NipResult) -> Section:
    """Return the section of the rule for a nip; its rows add up to the computed tension."""
    problem, effective = result.problem, result.without_air
    N, F, T_in = problem.nip_load, problem.winding_force, problem.web_tension
    Q_w, F_k = result.roll_wrap_traction, sum(nip.winding_force for nip in problem.next_nips)
    Q = result.outlet_tension - problem.web_tension - F
    slip = Q - effective.roll_friction * N
    air = (effective.roll_friction - problem.roll_friction) * N
    rule = theories.friction_limit(problem)
    meaning = f"trade rule NIT = mu N{' + F' if F else ''}"
    rows = [output_row(result, "nip_induced_tension", rule, meaning=meaning)]
    for text, value in (
        ("stick or backward slip on the roll in the nip", slip),
        ("friction lost to the air film", air),
        ("friction on the roll wrap" + (" and in further nips" if problem.next_nips else ""), Q_w),
        ("winding forces of the further drums", F_k),
    ):
        if value:
            rows.append(
                output_row(result, "nip_induced_tension", value, meaning=text, symbol="dNIT")
            )
    if F and isclose(F, -T_in):
        text = "trade rule of surface winding WOT = mu N"
        rows.insert(1, output_row(result, "wound_on_tension", T_in + rule, meaning=text))
    return Section(TITLE, tuple(rows), _reason(result))


def _reason(result: NipResult) -> str:
    """Return the reason for the difference: shares of the nip load by zones, and of friction."""
    forward, stick, backward = _load_shares(result)
    if forward > 1 - 5e-4:  # printed as 100.0 %
        return SLIPS
    mu = result.without_air.roll_friction
    Q = result.outlet_tension - result.problem.web_tension - result.problem.winding_force
    return (
        "The rule assumes forward slip on the roll in the whole nip. The web slips forward under "
        f"{_percent(forward)} of the nip load, sticks under {_percent(stick)} and slips backward "
        f"under {_percent(backward)}: friction is "
        f"{_percent(Q / (mu * result.problem.nip_load))} of mu N."
    )


def _load_shares(result: NipResult) -> tuple[float, float, float]:
    """Return the shares of the load on the roll under forward slip, stick and backward slip [1]."""
    nip = result.in_nip
    x, p, zones = result.x[nip], result.roll_pressure[nip], result.roll_zone[nip]
    load = p * np.gradient(x)  # trapezoidal rule: the pressure is zero at the edges
    forward, stick, backward = (
        float(load[zones == zone].sum() / load.sum())
        for zone in (Zone.FORWARD, Zone.STICK, Zone.BACKWARD)
    )
    return forward, stick, backward


def winding_trade_rule(result: WindingResult) -> Section:
    """Return the section of the rule for a winding, averaged over the length of web."""
    r = result.radius
    friction = mean_over_length(r, result.problem.roll_friction * result.nip_load)
    rule = friction + mean_over_length(r, result.winding_force)
    meaning = f"trade rule NIT = mu N{' + F' if result.winding_force.any() else ''}, mean"
    row = output_row(result, "mean_nip_induced_tension", rule, meaning=meaning)
    return Section(TITLE, (row,), _winding_reason(result, friction))


def _winding_reason(result: WindingResult, friction: float) -> str:
    """Return the reason for the difference, from the nips if there are some.

    ``friction`` is mu N averaged over the length of web [N/m].
    """
    law, has_winder = result.problem.tension_law, result.problem.winder is not None
    if law == "friction" and has_winder:
        return "The rule is that of the rear drum; the web slips in all nips of both drums."
    if law == "friction":
        return "The wound-on tension is that of this rule: tension_law = 'friction'."
    if law != "nip":
        return PRESCRIBED
    roll_side = mean_over_length(result.radius, result.nip_induced_tension - result.winding_force)
    if result.front is not None:
        roll_side -= result.mean_front_added_tension
    if result.rider is not None:
        roll_side -= result.mean_rider_added_tension
    nip = "the nip of the rear drum" if has_winder else "the nip"
    text = (
        f"Friction on the roll, in {nip} and on its wrap, is {_percent(roll_side / friction)} of "
        "mu N in the mean."
    )
    if result.problem.air is not None:
        left = result.nip_friction / result.problem.roll_friction
        text += f" The air film leaves {_percent(left)} of the friction in the nip."
    nips = [sample.result for sample in result.nips]
    if not nips:  # of a loaded result, or of a copy
        return f"{text} {NOT_SAVED}"
    forward, stick, backward = map(np.array, zip(*map(_load_shares, nips), strict=True))
    return (
        f"{text} The rule assumes forward slip on the roll in the whole nip. The web slips forward "
        f"under {_percent(forward)} of the nip load, sticks under {_percent(stick)} and slips "
        f"backward under {_percent(backward)}."
    )


def _percent(shares: float | Array) -> str:
    """Return a share, or the smallest and the largest of several, in percent."""
    ends = np.round([100 * np.min(shares), 100 * np.max(shares)], 1) + 0.0  # without -0.0
    low, high = (f"{end:.1f}" for end in ends)
    return f"{low} %" if low == high else f"{low} to {high} %"
