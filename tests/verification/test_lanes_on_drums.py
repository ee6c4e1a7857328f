"""Lanes in the nips of a two-drum winder: one nip split into several, sums, solved nips."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from lane_nips import PowerNip
from lane_profiles import STACKS
from slow_cases import slow_case

import woundon as wo
from woundon.problems.thickness_profile import Lanes
from woundon.roll.lane_tension import tension_in_nips
from woundon.winding.bodies import linear_cylinder
from woundon.winding.lane_nips import NipsOfWinding

Y = np.linspace(0, 2, 101)
BAND = wo.ThicknessProfile(position=Y, thickness=1 + 0.004 * (np.abs(Y - 1.2) < 0.11))
EVEN = wo.ThicknessProfile(position=[0, 2], thickness=[1, 1])
TWO_DRUMS = wo.WindingProblem.example().replace(
    winder=wo.TwoDrums(front_drum=wo.Rigid(radius=0.25), gap=0.02, rider_load=1500.0),
    drum=wo.Rigid(radius=0.3), nip_load=None, torque_split=0.5, web_tension=300.0,
    density=680.0, radius=0.2, roll_body="linear",
)  # fmt: skip
RIDER = {"winder.rider": wo.Rigid(radius=0.1), "winder.rider_load": 2000.0, "radius": 0.12}
COARSE = {"nodes": 33, "rtol": 0.01, "lanes": 20}


@cache
def solved(name: str) -> wo.WindingResult:
    """Return a winding with a band, by the name of the winder."""
    changes = {"two drums": {}, "rider": RIDER, "effective": {"roll_body": "effective"}}[name]
    return wo.solve(TWO_DRUMS.replace(thickness_profile=BAND, **changes), **COARSE)


# ---- the equations of the lanes -----------------------------------------------------------------

_, E_T, H, _ = STACKS["newsprint, K2 40"]
NIP = PowerNip(2000.0, 4e6, 0.19, 250.0, E_T, H, exponent=1.2)
RHO = np.array([2e-4, -1e-4, -1e-4])
LANES = Lanes(np.arange(3.0), np.full(3, 1 / 3), np.array([4e-3, -2e-3, -2e-3]), np.zeros(3))


def part_of(nip, part, *, friction=None, exponent=None):
    """Return a nip with a part of the load of another, at the same approach."""
    exponent = nip.exponent if exponent is None else exponent
    return PowerNip(
        part * nip.load, part * nip.load * exponent / nip.approach,
        nip.friction if friction is None else friction, nip.web, E_T, H, exponent=exponent,
    )  # fmt: skip


def tension_of(nips, mu=1e-3):
    wound_on = NIP.web + sum(nip.friction * nip.load for nip in nips)
    strain = wound_on / H / E_T
    return tension_in_nips(
        LANES, RHO + mu, np.full(3, mu), strain, nips, 0.1, wound_on, NIP.web, np.ones(3)
    )


def test_one_nip_is_several_with_its_load():
    """Invariance: nips that share the load at one approach add what one nip adds."""
    one = tension_of([NIP])
    several = tension_of([part_of(NIP, part) for part in (0.5, 0.3, 0.2)])
    assert one is not None
    assert several is not None
    # Newton's method ends at 1e-12
    assert several.wound_on == pytest.approx(one.wound_on, rel=1e-11)
    assert several.load == pytest.approx(np.tile(one.load, (3, 1)), rel=1e-10)


def test_each_nip_has_its_own_stiffness():
    """Closed form: linear nips on ridges that do not yield, P_k = N_k + k_k s rho."""
    nips = [part_of(NIP, part, friction=mu, exponent=1.0) for part, mu in ((0.6, 0.1), (1.2, 0.25))]
    nips[1].load /= 2  # half of the approach
    tension = tension_of(nips, mu=1e-30)
    assert tension is not None
    load = np.array([nip.load + nip.stiffness * 0.1 * RHO for nip in nips])
    assert (load > 0).all()
    means = np.array([[nip.load] for nip in nips])
    assert tension.load * means == pytest.approx(load, rel=1e-11)
    added = sum(nip.friction * own for nip, own in zip(nips, load, strict=True))
    h = H * (1 + LANES.excess)
    strain = RHO + (NIP.web - LANES.share @ (E_T * RHO * h)) / (E_T * H)
    wound_on = NIP.web + sum(nip.friction * nip.load for nip in nips)
    expected = (E_T * strain * h + added) / wound_on * H / h
    assert tension.wound_on == pytest.approx(expected, rel=1e-11)


# ---- windings -----------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["two drums", slow_case("rider")])
def test_sums_over_the_width(name):
    """Conservation: tension and the load of every nip, to rounding."""
    winding = solved(name)
    lanes, r = winding.lanes, winding.lanes.radius.values
    loads = winding.problem.drum_loads(r)
    names = ["front_load", *(["rider_load"] if name == "rider" else [])]
    for load in names:
        assert lanes[load].values @ lanes.share.values == pytest.approx(
            getattr(loads, load), rel=1e-12
        )
    assert ("rider_load" in lanes) == (name == "rider")
    rear = np.interp(r, winding.radius, winding.nip_load)
    assert lanes.nip_load.values @ lanes.share.values == pytest.approx(rear, rel=1e-12)
    web = np.interp(r, winding.radius, winding.web_tension)
    assert lanes.web_tension.values @ lanes.share.values == pytest.approx(web, rel=1e-12)


@pytest.mark.parametrize("changes", [{}, slow_case(RIDER)])
def test_equal_lanes_are_the_plain_winding(changes):
    result = wo.solve(TWO_DRUMS.replace(thickness_profile=EVEN, **changes), **COARSE | {"lanes": 5})
    roll, lanes = result.roll, result.lanes
    P = np.tile(roll.pressure[:, None], 5)
    assert lanes.pressure.values == pytest.approx(P, abs=1e-9 * roll.peak_pressure)
    tension = np.interp(lanes.radius.values, result.radius, result.wound_on_tension)
    assert lanes.wound_on_tension.values == pytest.approx(np.tile(tension[:, None], 5), rel=1e-9)
    for name in ("nip_load", "front_load"):
        load = lanes[name].values
        assert load == pytest.approx(np.tile(load.mean(axis=1)[:, None], 5), rel=1e-9)


def test_the_drums_lower_the_ridge():
    """All nips take over from the web: the same roll with equal added tension has higher ridges."""
    winding = solved("two drums")
    fixed = winding.problem.replace(
        tension_law=wo.Profile(radius=winding.radius, value=winding.wound_on_tension)
    )
    without = wo.solve(fixed, rtol=0.01, lanes=20)
    assert winding.worst_lane.ridge_height < 0.85 * without.worst_lane.ridge_height
    band = int(np.argmax(winding.lanes.thickness_excess.values))
    for name in ("nip_load", "front_load"):
        load = winding.lanes[name].values[-1]
        assert load[band] == load.max() > 1.1 * load.mean()


# ---- the nips of a lane -------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "fractions"),
    [
        ("two drums", (1.0, 1.0)),
        ("two drums", (1.4, 1.3)),
        ("two drums", (0.5, 0.6)),
        slow_case("rider", (1.4, 1.3, 1.5)),
        slow_case("rider", (0.5, 0.6, 0.4)),
        slow_case("rider", (2.0, 1.7, 2.2)),
    ],
)
def test_the_tension_added_under_all_loads_of_a_lane(name, fractions):
    """The nips solved with the loads of a lane: the changes of each nip alone are added.

    Loads of 0.5 to 2 of the mean; measured: at most 1.2 % of the wound-on tension.
    """
    winding = solved(name)
    of_winding = NipsOfWinding(winding, winding.roll)
    R = float(winding.nip_radius[-1])
    added = float(winding.nip_wound_on_tension[-1]) - 300.0
    nips = of_winding.nips(R, added)
    body = linear_cylinder(winding.problem, R)
    nip = winding.problem.nip(R, body)
    further = [
        each.replace(nip_load=f * each.nip_load, winding_force=f * each.winding_force)
        for each, f in zip(nip.next_nips, fractions[1:], strict=True)
    ]
    solution = wo.solve(
        nip.replace(
            nip_load=fractions[0] * nip.nip_load,
            winding_force=fractions[0] * nip.winding_force, next_nips=further,
        ),
        nodes=33,
    )  # fmt: skip
    by_lanes = sum(
        float(each.added(np.array([f * each.load]))[0][0])
        for each, f in zip(nips, fractions, strict=True)
    )
    exact = solution.roll_wound_on_tension - 300.0
    accepted = 0.012 if set(fractions) != {1.0} else 1e-6
    assert by_lanes == pytest.approx(exact, abs=accepted * (300.0 + exact))
    # each further nip alone, with another tension and traction of the web: measured 1.2 to 2.8 %
    for own, further_nip in zip(nips[1:], nip.next_nips, strict=True):
        alone = nip.replace(
            drum=further_nip.drum, nip_load=further_nip.nip_load, next_nips=(),
            winding_force=further_nip.winding_force, roll_wrap=1.0,
        )  # fmt: skip
        assert own.approach == pytest.approx(wo.solve(alone, nodes=33).approach, rel=0.04)
    # the rear nip's approach; the first nip of a result reports its own
    approach = nips[0].approach
    assert nips[0].load_at(np.array([approach]))[0] == pytest.approx([nips[0].load], rel=1e-9)
    if fractions[0] == 1.0:
        assert approach == pytest.approx(solution.approach, rel=1e-3)
    else:
        load = float(nips[0].load_at(np.array([solution.approach]))[0][0])
        # half and double loads are samples; between them a monotone cubic through their logarithms
        assert load == pytest.approx(fractions[0] * nips[0].load, rel=0.02)
