"""Slip lengths and ratios: zone boundaries known to a cell, continuous in the solution."""

from __future__ import annotations

from collections.abc import Callable
from math import inf

import numpy as np
import pytest
from slow_cases import slow_case
from thesis_cases import newsprint_nip, paper_nip

import woundon as wo
from woundon.elasticity.mesh import Wrap, nip_mesh
from woundon.nip.zones import boundary_positions, slip_lengths
from woundon.results import zone_runs

Array = np.ndarray
X = nip_mesh(65, Wrap(), Wrap()).nodes
WIDEST = float(np.diff(X).max())


def state(boundary: float, power: float, ahead: int) -> tuple[Array, Array, Array]:
    """Return zones, slip and slack that grow with a power of the distance from a boundary."""
    distance = ahead * (X - boundary)
    zones = (distance > 0).astype(int)
    slip, slack = (np.maximum(side, 0.0) ** power for side in (distance, -distance))
    return zones, slip, slack


@pytest.mark.parametrize("boundary", [-0.77, -0.31, 0.0, 0.1234, 0.5, 0.9])
@pytest.mark.parametrize("power", [0.5, 1.0, 1.5])
def test_a_boundary_lies_in_its_cell(boundary: float, power: float) -> None:
    """Linear fields give it exactly where cells are even; others to a cell."""
    zones, slip, slack = state(boundary, power, ahead=1)
    leading, trailing = slip_lengths(X, zones, slip, slack)
    assert leading == 0.0
    cell = int(np.searchsorted(X, boundary, side="right"))
    assert X[cell - 1] <= 1 - trailing <= X[min(cell, X.size - 1)]
    # cells differ by a few percent, as the differences of linear fields do
    if power == 1.0 and abs(boundary) < 0.6:
        assert 1 - trailing == pytest.approx(boundary, abs=0.1 * WIDEST)
    zones, slip, slack = state(boundary, power, ahead=-1)
    leading, trailing = slip_lengths(X, -zones, -slip, slack)
    assert trailing == 0.0
    assert X[cell - 1] <= -leading - 1 <= X[cell]  # negative: the web is slower


@pytest.mark.parametrize("power", [0.5, 1.0, 1.5])
def test_a_boundary_moves_with_the_state_and_never_jumps(power: float) -> None:
    boundaries = np.linspace(-0.7, 0.7, 1401)  # thirty steps a cell
    found = [1 - slip_lengths(X, *state(b, power, ahead=1))[1] for b in boundaries]
    steps = np.diff(found) / np.diff(boundaries)
    # linear fields move it evenly; a root does so ten times as fast next to a node, and a boundary
    # half-way between nodes would jump by 30 steps
    assert steps.min() >= 0.0
    assert steps.max() < (1.8 if power == 1.0 else 12.0)


def test_opposite_slips_meet_where_slip_is_zero() -> None:
    slip = 0.3 - X
    zones = np.sign(slip).astype(int)
    leading, trailing = slip_lengths(X, zones, slip, 0 * slip)
    assert (leading - 1, 1 + trailing) == pytest.approx((0.3, 0.3), abs=1e-12)
    assert boundary_positions(X, zones, slip, 0 * slip) == pytest.approx([0.3], abs=1e-12)


def test_whole_faces_and_edges() -> None:
    one, zero = np.ones(X.size), np.zeros(X.size)
    for way in (1, -1):
        lengths = slip_lengths(X, way * one.astype(int), way * one, zero)
        assert lengths == (2.0 * way, 2.0 * way)
    assert slip_lengths(X, zero.astype(int), zero, one) == (0.0, 0.0)
    # a zone of the last two nodes alone is not longer than its cells
    zones, slip = zero.astype(int), zero.copy()
    zones[-2:], slip[-2:] = 1, 1e-6
    _, trailing = slip_lengths(X, zones, slip, one)
    assert 0 < trailing < 1 - X[-3]


# ---- of solved nips -----------------------------------------------------------------------------

FOAM = wo.Isotropic(youngs_modulus=10e6, poissons_ratio=0.1)
STIFF = wo.Isotropic(youngs_modulus=1e8, poissons_ratio=0.3)
NIPS = {
    "newsprint": newsprint_nip(),
    "half-plane drum": paper_nip(drum=wo.HalfPlane(radius=0.5, material=STIFF)),
    "foam cover": paper_nip(drum=wo.Cylinder(radius=0.5, core_radius=0.48, material=FOAM)),
}


def some_nips(quick: str) -> pytest.MarkDecorator:
    """Take them all, but one in the runs that take long."""
    each = [name if name == quick else slow_case(name) for name in NIPS]
    return pytest.mark.parametrize("name", each)


RATIOS = ("leading_roll", "trailing_roll", "dual")


def swept(problem: wo.NipProblem, loads: Array) -> dict[str, Array]:
    results = [wo.solve(problem.replace(nip_load=P), nodes=65) for P in loads]
    return {name: np.array([getattr(r, name) for r in results]) for name in RATIOS}


@some_nips("newsprint")
def test_ratios_vary_smoothly_with_the_load(name: str) -> None:
    """Second differences over sixty loads; half-way borders jump by a whole cell."""
    ratios = swept(NIPS[name], np.geomspace(500.0, 5000.0, 60))
    cell = WIDEST / 2  # of the nip width
    for ratio, values in ratios.items():
        # where both faces begin to slip at the trailing edge, or another face is the shorter one,
        # dual itself has a jump or a kink: on a finer mesh as well
        values = values[values != 0]
        assert values.size >= 20  # on the foam cover dual is 0 above 1.3 to 1.7 kN/m
        # measured: 7 % of a cell on the roll, half a cell on a rigid drum, against which the
        # traction jumps at a boundary; boundaries half-way between nodes jump by whole cells
        limit = 0.6 if ratio == "dual" else 0.12
        assert np.abs(np.diff(values, 2)).max() < limit * cell, ratio


def bisected(differs: Callable[[float], bool], low: float, high: float) -> tuple[float, float]:
    """Return neighbouring numbers between which something changes."""
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (low, middle) if differs(middle) else (middle, high)
    return low, high


@pytest.mark.slow
@some_nips("foam cover")
def test_ratios_are_continuous_where_a_node_changes(name: str) -> None:
    """To the last digit of the load, on either side of a change between stick and slip."""
    problem = NIPS[name]

    def solved(load: float) -> wo.NipResult:
        return wo.solve(problem.replace(nip_load=load), nodes=65)

    def zones(load: float) -> bytes:
        return solved(load).roll_zone.tobytes()

    start = zones(1900.0)
    assert zones(3500.0) != start
    low, high = bisected(lambda load: zones(load) != start, 1900.0, 3500.0)
    below, above = solved(low), solved(high)
    assert np.count_nonzero(below.roll_zone != above.roll_zone) == 1
    for ratio in ("leading_roll", "trailing_roll"):
        # slips and slacks are zero to rounding there, of which borders take roots
        assert getattr(below, ratio) == pytest.approx(getattr(above, ratio), abs=1e-5), ratio


def test_ratios_converge() -> None:
    """A boundary is known to a fraction of its cell."""
    problem = NIPS["half-plane drum"]
    fine = wo.solve(problem, nodes=513)
    before = inf
    for nodes in (33, 65, 129):
        result = wo.solve(problem, nodes=nodes)
        cell = float(np.diff(result.x).max()) / result.nip_width
        miss = max(abs(getattr(result, ratio) - getattr(fine, ratio)) for ratio in RATIOS)
        assert miss < 0.5 * cell
        assert miss < before
        before = miss


@pytest.mark.parametrize("drum_wrap", [0.0, 1.0])
def test_slip_ratios_of_a_wrapped_nip_are_those_of_its_zones_between_the_edges(
    drum_wrap: float,
) -> None:
    r = wo.solve(newsprint_nip(roll_wrap=np.pi, drum_wrap=drum_wrap), nodes=65)
    x, width = r.x[r.in_nip], 2 * r.half_width
    assert (x[0], x[-1]) == pytest.approx((-r.half_width, r.half_width), rel=1e-12)
    zones = zone_runs(x, r.roll_zone[r.in_nip])
    cell = float(np.max(np.diff(x)))  # zones change half-way between nodes, slips somewhere there
    for ratio, (zone, first, last) in ((r.leading_roll, zones[0]), (r.trailing_roll, zones[-1])):
        assert zone != 0
        assert ratio * width == pytest.approx(zone * (last - first), abs=cell)
