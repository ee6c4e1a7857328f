"""Several nips of one outer layer as one coupled system (:mod:`coupled_nips`).

With one nip it is an independent check of the wrapped nip.  With two it shows what a second nip
does: a layer that sticks anywhere between the nips keeps the strain with which it was laid.

Reference: an independent program with its own influence functions, hard drums; newsprint of the
thesis's Table 2.  Its values are on other meshes: 0.3 % of a tension.
"""

from __future__ import annotations

from math import exp
from typing import Any

import numpy as np
import pytest
from coupled_nips import Case, Nip

import woundon as wo

NEWSPRINT = wo.NipProblem.example()  # P = 3502 N/m on a drum of 76.2 mm, T_in = 350 N/m
P, DRUM, T_IN = NEWSPRINT.nip_load, 0.0762, 350.0
AFTER = 2.0  # arc downstream of the last nip [rad]; its length changes nothing beyond the slip
MESHES = 0.003  # of a tension: the error of 24 to 32 cells, and of the reference


def case(nips: tuple[Nip, ...], **fields: Any) -> Case:
    """Return the newsprint roll with given nips."""
    friction = fields.pop("friction", NEWSPRINT.roll_friction)
    given = {
        "roll": NEWSPRINT.roll,
        "web": NEWSPRINT.web,
        "end": nips[-1].angle + AFTER,
        "tension": T_IN,
        "roll_friction": friction,
        "drum_friction": NEWSPRINT.drum_friction,
        "arc_friction": friction,
    }
    return Case(nips=nips, **given | fields)


def two(angle: float, load: float = P, **fields: Any) -> Case:
    """Return two nips on like drums, without winding force."""
    return case((Nip(0.0, DRUM, P), Nip(angle, DRUM, load)), **fields)


def test_one_nip_is_the_wrapped_nip() -> None:
    """Second-order mesh errors of 32 cells: 0.05 % of a tension, 0.15 % of the half width."""
    problem = NEWSPRINT.replace(roll_wrap=2.8)
    known, found = wo.solve(problem, nodes=129), case((Nip(0.0, DRUM, P),), end=2.8).solve()
    assert found.wound_on_tension == pytest.approx(known.wound_on_tension, rel=5e-4)
    assert found.closed_tension == pytest.approx(known.roll_wound_on_tension, rel=5e-4)
    assert found.on_arc(0)[0] == pytest.approx(known.outlet_tension, rel=5e-4)
    assert found.half_width[0] == pytest.approx(known.half_width, rel=1.5e-3)


def test_a_second_nip_without_load_adds_nothing() -> None:
    """The reference's closed tension is constant to 0.08 N/m of 699 for 300 to 1 N/m.

    Next to a light nip cells are smaller, also in front of the first one: 0.11 % of mesh error.
    """
    alone = case((Nip(0.0, DRUM, P),)).solve()
    light, lightest = (two(1.5, load).solve() for load in (300.0, 3.0))
    assert light.closed_tension == pytest.approx(lightest.closed_tension, abs=0.2)
    assert lightest.closed_tension == pytest.approx(alone.closed_tension, rel=1.5e-3)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("angle", "load", "solved_curvature", "added"),
    [
        (0.7, P, True, 432.0),
        (1.5, P, True, 416.0),
        (1.5, P, False, 417.1),
        (2.2, P, False, 397.0),
    ],
)
def test_tension_added_by_two_like_nips(
    angle: float, load: float, solved_curvature: bool, added: float
) -> None:
    found = two(angle, load, solved_curvature=solved_curvature).solve()
    assert found.closed_tension == pytest.approx(T_IN + added, rel=MESHES)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("friction", "gain"), [(0.05, 118.0), (0.1, 120.0), (0.19, 68.0), (0.4, 9.6), (0.8, 2.4)]
)
def test_gain_of_the_second_nip_over_the_friction(friction: float, gain: float) -> None:
    """Differences of tensions of 520 to 770 N/m; the 68 is 64.4 in another reference."""
    alone = case((Nip(0.0, DRUM, P),), friction=friction).solve()
    both = two(1.5, friction=friction).solve()
    assert both.closed_tension - alone.closed_tension == pytest.approx(gain, abs=4.0)


@pytest.mark.slow
def test_without_friction_on_the_arc_it_carries_nothing() -> None:
    """Reference: 455.17 N/m before and 455.08 after; 800.4 N/m, the largest gain."""
    found = two(1.5, arc_friction=1e-6).solve()
    assert np.ptp(found.on_arc(0)[1:-1]) < 0.1
    assert found.closed_tension == pytest.approx(800.4, rel=MESHES)


def test_a_mesh_of_twice_the_cells_agrees() -> None:
    """Reference: 721.7, 723.7, 725.05, 725.17 for 12, 16, 32, 64 cells, 0.5 % from 12 to 64."""
    coarse, fine = (two(1.5, cells=cells).solve() for cells in (12, 24))
    assert coarse.closed_tension == pytest.approx(fine.closed_tension, rel=5e-3)


# front share -F2/T_in of the torque; T_in 300 N/m, drums of 300 and 250 mm; closed tension, and
# the least tension between the drums
BUILD_UP = [
    (0.10, 1.72, 1936.0, 2136.0, 0.5, 448.8, 296.0),
    (0.10, 1.72, 1936.0, 2136.0, 1.0, 496.9, 424.0),
    (0.50, 0.75, 2200.0, 3354.0, 0.5, 450.5, 271.0),
    (0.50, 0.75, 2200.0, 3354.0, 1.0, 471.9, 331.0),
    (0.50, 0.75, 2200.0, 3354.0, 1.5, 485.9, 396.0),
]


@pytest.mark.slow
@pytest.mark.parametrize(("radius", "angle", "rear", "front", "share", "closed", "least"), BUILD_UP)
def test_two_drum_winder(
    radius: float,
    angle: float,
    rear: float,
    front: float,
    share: float,
    closed: float,
    least: float,
) -> None:
    """The front drum acts through the force of the rear one, F1 = -T_in - F2."""
    T, F2 = 300.0, -share * 300.0
    roll = NEWSPRINT.roll.replace(radius=radius)
    nips = (Nip(0.0, 0.3, rear, -T - F2), Nip(angle, 0.25, front, F2))
    found = case(nips, roll=roll, tension=T, drum_friction=0.4, cells=24).solve()
    assert found.closed_tension == pytest.approx(closed, rel=MESHES)
    assert found.on_arc(0).min() == pytest.approx(least, rel=2 * MESHES)  # of a minimum


def predicted_to_stick(angle: float, load: float, friction: float) -> tuple[bool, float]:
    """Return whether a layer sticks between two nips, from single nips, and how clearly.

    A single nip of the second load raises the tension by a2; the disturbance W1 - a2 in front of it
    decays along the capstan curve.
    """
    single = NEWSPRINT.replace(roll_friction=friction, wrap_friction=friction)
    W1 = wo.solve(single).wound_on_tension
    a2 = wo.solve(single.replace(nip_load=load)).nip_induced_tension
    largest = W1 * (1 - exp(-friction * angle))
    return a2 < largest, abs(a2 / largest - 1)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("angle", "load", "friction"),
    [(1.5, 350.0, 0.19), (1.5, P, 0.19), (2.5, 1500.0, 0.3), (0.7, 1500.0, 0.3), (2.2, P, 0.6)],
)
def test_criterion_of_sticking(angle: float, load: float, friction: float) -> None:
    """Where the layer sticks, the second nip only squeezes the ring: 2.5 N/m in the reference."""
    sticks, margin = predicted_to_stick(angle, load, friction)
    assert margin > 0.05  # away from the threshold
    alone = case((Nip(0.0, DRUM, P),), friction=friction).solve()
    both = two(angle, load, friction=friction).solve()
    gain = both.closed_tension - alone.closed_tension
    # the mesh error of a difference is 1 N/m
    assert gain < 2.5 + 2.0 if sticks else gain > 8.0
