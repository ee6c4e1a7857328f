"""Bending and crown of drums and core: validation, crowns, the loads of bent drums, windings."""

from __future__ import annotations

from math import cos, cosh, sin, sinh

import numpy as np
import pytest
from lane_nips import PowerNip
from lane_profiles import STACKS
from slow_cases import campaign_case, slow_case

import woundon as wo
from woundon.elasticity.beam import Beam, BeamsAcross
from woundon.problems.thickness_profile import Lanes
from woundon.roll.lane_tension import DrumsAcross, tension_in_nips

EI, W = 3e6, 2.4
EVEN = wo.ThicknessProfile(position=[0, W], thickness=[1, 1])
WINDING = wo.WindingProblem.example().replace(
    radius=0.08, roll_body="linear", thickness_profile=EVEN
)
DRUM = wo.DrumBending(flexural_rigidity=EI, bearing_distance=0.2)
TWO_DRUMS = {
    "winder": wo.TwoDrums(front_drum=wo.Rigid(radius=0.25), gap=0.02, rider_load=1500.0),
    "drum": wo.Rigid(radius=0.3), "nip_load": None, "torque_split": 0.5, "web_tension": 300.0,
}  # fmt: skip


# ---- validation ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("rigidity", "least"),
    [
        # P (5 W^4/384 + b W^3/16)/EI <= 0.1 m: 2000 N/m, b = 0.2 m
        ("flexural_rigidity", 2000 * (5 * W**4 / 384 + 0.2 * W**3 / 16) / 0.1),
        # P W^2/(8 kappa G A) <= 0.1 m
        ("shear_rigidity", 2000 * W**2 / 8 / 0.1),
    ],
)
def test_a_drum_may_bend_by_a_tenth_of_a_metre(rigidity, least):
    bent = WINDING.replace(drum_bending=DRUM.replace(flexural_rigidity=1e8))
    bent.replace(**{f"drum_bending.{rigidity}": 1.01 * least})
    with pytest.raises(wo.InvalidProblem, match=rf"drum_bending\.{rigidity}: .* is out of range"):
        bent.replace(**{f"drum_bending.{rigidity}": 0.99 * least})


# ---- crowns -------------------------------------------------------------------------------------


def test_the_mean_height_of_a_crown_in_lanes():
    """Quadrature: means over lanes of the parabola and of a table, by the midpoint rule."""
    ends = np.linspace(0.3, 2.7, 13)
    table = {"crown_position": [0.0, 1.0, 1.3, 3.0], "crown_height": [0.0, 1e-4, -1e-4, 0.0]}
    for drum in (DRUM.replace(crown=2e-4), DRUM.replace(**table)):
        fine = np.linspace(0.3, 2.7, 12 * 500 + 1)
        middles = (fine[1:] + fine[:-1]) / 2
        means = drum.heights(middles, edges=(0.3, 2.7)).reshape(12, 500).mean(axis=1)
        # the midpoint rule errs by about 1/(24 500^2) of the change of slope
        assert drum.mean_heights(ends) == pytest.approx(means, abs=1e-9)


def test_the_crown_of_an_even_load():
    """Closed form: the deflection of a beam under a uniform load, by the beams across the lanes."""
    for shear in (None, 2e7):
        drum = wo.Bending(flexural_rigidity=EI, bearing_distance=0.3, shear_rigidity=shear)
        beam = Beam(EI, 0.3, shear or np.inf)
        across = BeamsAcross([beam], np.full(10, W / 10), np.array([0.0, W / 2]))
        edge, middle = across.deflection(np.full((10, 1, 1), 2000.0))[10:, 0, 0]
        assert drum.even_crown(2000.0, W) == pytest.approx(middle - edge, rel=1e-9)


# ---- loads of bent drums ------------------------------------------------------------------------

_, E_T, H, _ = STACKS["newsprint, K2 40"]


def lanes_across(count, excess=None):
    d = np.zeros(count) if excess is None else excess
    return Lanes((np.arange(count) + 0.5) * W / count, np.full(count, 1 / count), d, 0 * d)


def drums_across(lanes, beams, nips=1, crown=None, loaded_by=None):
    count = lanes.share.size
    across = BeamsAcross(beams, np.full(count, W / count), np.zeros(0))
    crown = np.zeros((nips, count)) if crown is None else crown
    return DrumsAcross(
        crown, across, np.ones((nips, len(beams))) if loaded_by is None else loaded_by
    )


def loads_of(lanes, nips, drums, rho=None, mu=1e-3):
    """Return the loads of the nips on lanes with given ridges rho, (K, L) [N/m]."""
    count, wound_on = lanes.share.size, nips[0].web + sum(nip.friction * nip.load for nip in nips)
    rho, mu = np.zeros(count) if rho is None else rho, np.full(count, mu)
    tension = tension_in_nips(
        lanes, rho + mu, mu, wound_on / H / E_T, nips, 0.1, wound_on, nips[0].web,
        np.ones(count), drums,
    )  # fmt: skip
    return None if tension is None else tension.load * np.array([[nip.load] for nip in nips])


def linear_nip(stiffness=1e7, load=2000.0, exponent=1.0):
    """Return a nip that adds no tension: the ridges stay."""
    return PowerNip(load, stiffness, 0.0, 250.0, E_T, H, exponent=exponent)


def test_a_bent_drum_on_linear_nips():
    """Closed form (Hetenyi 1946): a hinged beam on an elastic foundation under a mean load."""
    nip = linear_nip(stiffness=2e6)
    u = (nip.stiffness / (4 * EI)) ** 0.25 * W / 2
    C, S = cosh(u) * cos(u), sinh(u) * sin(u)
    errors = []
    for count in (20, 40, 80):
        lanes = lanes_across(count)
        load = loads_of(lanes, [nip], drums_across(lanes, [Beam(EI)]), mu=1e-30)[0]
        s = (2 * lanes.position / W - 1) * u
        shape = (C * np.cosh(s) * np.cos(s) + S * np.sinh(s) * np.sin(s)) / (C**2 + S**2)
        # mean of cosh cos and sinh sin over the width
        mean_C = (sinh(u) * cos(u) + cosh(u) * sin(u)) / (2 * u)
        mean_S = (cosh(u) * sin(u) - sinh(u) * cos(u)) / (2 * u)
        shape *= nip.load * (C**2 + S**2) / (C * mean_C + S * mean_S)
        errors.append(np.max(np.abs(load / shape - 1)))
        assert load @ lanes.share == pytest.approx(nip.load, rel=1e-12)
    assert load.max() > 1.2 * load.min()
    # order two in the width of the lanes
    assert errors[1] == pytest.approx(errors[0] / 4, rel=0.1)
    assert errors[2] == pytest.approx(errors[1] / 4, rel=0.1)
    assert errors[2] < 1e-3


def test_a_stiff_drum_is_straight():
    """Limit: E I of 1e20 N m^2, with ridges that yield to the nip."""
    lanes = lanes_across(30, excess=np.zeros(30))
    rho = 1e-4 * np.cos(5 * lanes.position)
    rho -= rho.mean()
    nip = PowerNip(2000.0, 1e7, 0.19, 250.0, E_T, H, exponent=1.2)
    straight = loads_of(lanes, [nip], None, rho)
    stiff = loads_of(lanes, [nip], drums_across(lanes, [Beam(1e20)]), rho)
    assert np.ptp(straight) > 100
    assert stiff == pytest.approx(straight, rel=1e-9)


def test_the_deflection_as_a_crown_makes_the_load_uniform():
    """Invariance: a drum that is straight under its load, of several nips each with its own."""
    lanes = lanes_across(25)
    nips = [linear_nip(exponent=1.2), linear_nip(load=3000.0, exponent=1.1)]
    beams = [Beam(EI), Beam(2 * EI, 0.3, 1e8), Beam(EI / 2)]
    loaded_by = np.array([[1, 0, 1], [0, 1, 0]])
    straight = drums_across(lanes, beams, 2, loaded_by=loaded_by)
    crown = loaded_by @ straight.deflection(np.tile([[2000.0], [3000.0]], 25))
    crown = crown - crown.mean(axis=1, keepdims=True)
    load = loads_of(lanes, nips, straight._replace(crown=crown))
    assert load == pytest.approx(np.tile([[2000.0], [3000.0]], 25), rel=1e-9)
    assert np.ptp(loads_of(lanes, nips, straight)[0]) > 500


def test_mirrored_drums_have_mirrored_loads():
    lanes = lanes_across(20)
    rho = 1e-4 * np.sin(lanes.position)
    nip = PowerNip(2000.0, 1e7, 0.19, 250.0, E_T, H, exponent=1.2)
    drums = drums_across(lanes, [Beam(EI, 0.1)], crown=1e-4 * lanes.position[None] / W)
    load = loads_of(lanes, [nip], drums, rho)
    mirrored = loads_of(lanes, [nip], drums._replace(crown=drums.crown[:, ::-1]), rho[::-1])
    # Newton's method ends at 1e-12 of the loads; deflections of ten approaches lose a digit
    assert mirrored == pytest.approx(load[:, ::-1], rel=1e-10)


@pytest.mark.parametrize("seed", [*range(10), *(campaign_case(k) for k in range(10, 500))])
def test_random_drums(seed):
    """Robustness: flexible and stiff drums, large crowns, up to three nips; the sums hold."""
    rng = np.random.default_rng(seed)
    lanes, count = lanes_across(40), int(rng.integers(1, 4))
    rho = rng.uniform(0, 3e-4) * np.cos(rng.uniform(1, 20) * lanes.position + rng.uniform(0, 6))
    nips = [
        PowerNip(10 ** rng.uniform(2.5, 3.7), 10 ** rng.uniform(6, 7.5), rng.uniform(0.05, 0.3),
                 250.0, E_T, H, exponent=rng.uniform(1, 1.5))
        for _ in range(count)
    ]  # fmt: skip
    beams = [Beam(10 ** rng.uniform(4.5, 8), rng.uniform(0, 0.5), 10 ** rng.uniform(7, 9))
             for _ in range(count)]  # fmt: skip
    crown = rng.uniform(-5e-4, 5e-4, (count, 1)) * (1 - (2 * lanes.position / W - 1) ** 2)
    drums = drums_across(lanes, beams, count, crown, np.eye(count))
    load = loads_of(lanes, nips, drums, rho - rho.mean())
    assert load is not None
    assert (load >= 0).all()
    assert load @ lanes.share == pytest.approx([nip.load for nip in nips], rel=1e-12)


# ---- windings -----------------------------------------------------------------------------------

COARSE = {"nodes": 33, "rtol": 0.01, "lanes": 24}


@pytest.fixture(scope="module")
def bent():
    core = wo.Bending(flexural_rigidity=2e7)
    return wo.solve(WINDING.replace(drum_bending=DRUM, core_bending=core), **COARSE)


def test_the_loads_of_a_bent_drum(bent):
    """Conservation, and integration of the reported load by the trapezoidal rule."""
    lanes, r = bent.lanes, bent.lanes.radius.values
    load = lanes.nip_load.values
    mean = np.interp(r, bent.radius, bent.nip_load)
    assert load @ lanes.share.values == pytest.approx(mean, rel=1e-12)
    assert load[-1, 0] > 1.5 * load[-1, 12]  # at the edges
    # the load as a step function on a fine mesh between the bearings
    y = np.linspace(-0.2, W + 0.2, 28 * 200 + 1)
    P = np.zeros(28 * 200)
    P[400:-400] = np.repeat(load[-1], 200)
    dy = y[1] - y[0]
    shear = np.append(0, np.cumsum(P) * dy)
    moment = np.append(0, np.cumsum((shear[1:] + shear[:-1]) / 2) * dy)
    moment -= moment[-1] * (y - y[0]) / (y[-1] - y[0])
    slope = np.append(0, np.cumsum((moment[1:] + moment[:-1]) / 2) * dy) / EI
    w = np.append(0, np.cumsum((slope[1:] + slope[:-1]) / 2) * dy)
    w -= w[-1] * (y - y[0]) / (y[-1] - y[0])
    means = ((w[1:] + w[:-1]) / 2)[400:-400].reshape(24, 200).mean(axis=1)
    assert lanes.drum_deflection.values[-1] == pytest.approx(means, rel=1e-4)


def test_the_error_of_the_number_of_lanes():
    """Honesty: ten times as many lanes are within the estimates: edges and middle are extremes.

    The extreme thicknesses are elsewhere, and the drum touches all lanes.
    """
    profile = wo.ThicknessProfile(
        position=[0, 0.6, 1.2, 1.8, W], thickness=[1, 1.0002, 1, 0.9998, 1]
    )
    drum = DRUM.replace(flexural_rigidity=1e7)
    problem = WINDING.replace(thickness_profile=profile, drum_bending=drum)
    few, many = (wo.solve(problem, **COARSE | {"lanes": count}) for count in (6, 60))
    for name in ("pressure", "tension", "least_tension", "strain", "ridge_height"):
        value, exact = (getattr(each.worst_lane, name) for each in (few, many))
        assert abs(value - exact) <= few.error(f"worst_lane.{name}"), name
    # the tension of the edge is that of its lane and half a lane of its slope
    assert many.lanes.nip_load.values[-1].min() > 500
    assert many.worst_lane.tension > 1.02 * few.worst_lane.tension


def test_a_crown_evens_the_load(bent):
    """The parabola of the deflection in the middle leaves a part of its fourth order."""
    load = 2000.0
    closed = sum(
        beam.even_crown(load, W) for beam in (bent.problem.drum_bending, bent.problem.core_bending)
    )
    assert bent.even_crown == pytest.approx(closed, rel=1e-9)
    crowned = wo.solve(bent.problem.replace(**{"drum_bending.crown": bent.even_crown}), **COARSE)
    uneven, even = (np.ptp(each.lanes.nip_load.values[-1]) for each in (bent, crowned))
    assert even < 0.1 * uneven
    # a table of the deflection itself
    y = np.linspace(0, W, 481)
    across = BeamsAcross([Beam(EI, 0.2), Beam(2e7)], np.full(24, W / 24), y)
    height = across.deflection(np.full((24, 2, 1), load))[24:, :, 0].sum(axis=1)
    table = {"drum_bending.crown_position": y, "drum_bending.crown_height": height}
    exact = wo.solve(bent.problem.replace(**table), **COARSE)
    # lines between the positions: (dy/W)^2 of the deflection
    assert np.ptp(exact.lanes.nip_load.values[-1]) < 1e-4 * uneven


@pytest.mark.parametrize("changes", [{}, slow_case(TWO_DRUMS)])
def test_a_winding_on_a_stiff_drum_is_that_on_a_straight_one(changes):
    y = np.linspace(0, W, 49)
    band = wo.ThicknessProfile(position=y, thickness=1 + 0.002 * np.cos(5 * y))
    problem = WINDING.replace(thickness_profile=band, density=680.0, **changes)
    stiff = problem.replace(drum_bending=wo.DrumBending(flexural_rigidity=1e22))
    straight, stiff = (wo.solve(each, **COARSE).lanes for each in (problem, stiff))
    for name in ("pressure", "nip_load", "wound_on_tension"):
        scale = float(straight[name].max())
        assert stiff[name].values == pytest.approx(straight[name].values, abs=1e-9 * scale)


def test_a_crowned_front_drum_presses_the_middle():
    """Conservation, and each drum has its own crown and deflection."""
    winder = TWO_DRUMS["winder"].replace(front_bending=DRUM.replace(crown=4e-4))
    problem = WINDING.replace(**{**TWO_DRUMS, "winder": winder}, density=680.0)
    lanes = wo.solve(problem, **COARSE | {"lanes": 12}).lanes
    share, front = lanes.share.values, lanes.front_load.values
    loads = problem.drum_loads(lanes.radius.values)
    assert front @ share == pytest.approx(loads.front_load, rel=1e-12)
    assert front[-1, 6] > 1.3 * front[-1, 0]
    # the rear drum is straight: its load follows the surface, which is lower where the web is tight
    assert np.ptp(lanes.nip_load.values[-1]) < 0.3 * np.ptp(front[-1])
    assert "drum_deflection" not in lanes
    # about that under an even load, from the bearings, since the load differs by a third
    across = BeamsAcross([Beam(EI, 0.2)], np.full(12, W / 12), np.zeros(0))
    even = across.deflection(np.full((12, 1, 1), loads.front_load[-1]))[:, 0, 0]
    assert lanes.front_deflection.values[-1] == pytest.approx(even, rel=0.3)


def test_report_figure_and_file_of_a_bent_drum(bent, tmp_path):
    text = " ".join(str(bent).split())
    assert "range of the deflection of the drum away from the roll" in text
    assert "range of the deflection of the core away from the drum" in text
    assert "crown for a uniform mean nip load of an even web" in text
    assert "bend under their nip load as beams on two bearings" in text
    bent.plot(tmp_path / "bent.png", panels=["deflection_across", "nip_load_across"])
    bent.save(tmp_path / "bent.nc")
    loaded = wo.load_result(tmp_path / "bent.nc")
    assert loaded.problem == bent.problem
    assert loaded.lanes.drum_deflection.values == pytest.approx(
        bent.lanes.drum_deflection.values, rel=1e-6
    )


def test_straight_drums_have_no_crown_and_no_deflection():
    plain = wo.WindingProblem.example().replace(radius=0.06, tension_law="friction")
    assert np.isnan(wo.solve(plain).even_crown)
