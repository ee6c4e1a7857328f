"""Every condition of every certificate can fail: a corrupted result violates the condition.

Evidence: error injection.  ``test_certificate_fields.py`` corrupts every field of every result.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest
from hardening_cases import nip as hardening_nip
from hardening_cases import roll as hardening_roll
from thesis_cases import newsprint_nip, paper_nip

import woundon as wo
from woundon.elasticity import ring_equilibrium
from woundon.elasticity.surface import LinearSurface
from woundon.problems import wound_roll
from woundon.results import ACCEPTED_RESIDUAL, Residuals

Array = np.ndarray
# ten thousand times the accepted residual: rounding is not mistaken for a corruption
SEEN = 1e4 * ACCEPTED_RESIDUAL

RUBBER = wo.Isotropic(youngs_modulus=5e6, poissons_ratio=0.45, prony=[(3e6, 1e-3)])
STEEL = wo.HalfPlane(radius=0.25, material="steel")
COVER = wo.Cylinder(radius=0.5, core_radius=0.48, material="soft-cover")
ROLLERS = wo.RollerProblem(upper=STEEL, lower=STEEL, load=89e3, tangential_load=8.4e3, friction=0.5)
RUBBER_ROLLERS = wo.RollerProblem(
    upper=wo.Rigid(radius=0.2), lower=wo.HalfPlane(radius=0.25, material=RUBBER), load=2e3,
    friction=0.3, tangential_load=100.0, speed=2.0,
)  # fmt: skip
PROBLEMS: dict[str, wo.Problem] = {
    "nip": newsprint_nip(),
    "nip, cover": paper_nip(drum=COVER),
    "nip, hardening": hardening_nip(hardening_roll()),
    "wrapped": newsprint_nip(roll_wrap=np.pi),
    "wrapped, both": paper_nip(drum=COVER, roll_wrap=np.pi, drum_wrap=1.0),
    "rollers": ROLLERS,
    "rollers, static": ROLLERS.replace(motion="static"),
    "rollers, creepage": ROLLERS.replace(tangential_load=None, creepage=1e-4),
    "rollers, viscoelastic": RUBBER_ROLLERS,
}
NIPS = ("nip", "nip, cover", "nip, hardening")
WRAPS = ("wrapped", "wrapped, both")
ALL_ROLLERS = tuple(name for name in PROBLEMS if name.startswith("rollers"))


@cache
def solved(case: str) -> Any:
    return wo.solve(PROBLEMS[case], nodes=33)


Corrupt = Callable[[Any], dict[str, Any]]


def changed(name: str, node: int | Callable[[Any], int], by: float) -> Corrupt:
    """Add to one node of an array a share of the largest value of the array."""

    def corrupt(r: Any) -> dict[str, Any]:
        values = getattr(r, name).copy()
        values[node(r) if callable(node) else node] += by * np.nanmax(np.abs(values))
        return {name: values}

    return corrupt


def scaled(name: str, by: float) -> Corrupt:
    return lambda r: {name: getattr(r, name) * by}


def other_problem(**changes: Any) -> Corrupt:
    return lambda r: {"problem": r.problem.replace(**changes)}


def middle(r: Any) -> int:
    """Return the node in the middle of the nip."""
    return int((r.in_nip.start + r.in_nip.stop) // 2)


def stuck(face: str) -> Callable[[Any], int]:
    """Return the sticking node of the nip that is nearest to the middle."""

    def node(r: Any) -> int:
        nodes = np.flatnonzero(getattr(r, f"{face}zone") == 0)
        return int(nodes[np.abs(nodes - middle(r)).argmin()])

    return node


def slipping(face: str) -> Callable[[Any], int]:
    """Return a slipping node of the nip, away from its edges."""

    def node(r: Any) -> int:
        nodes = np.flatnonzero(getattr(r, f"{face}zone"))
        nodes = nodes[(nodes > r.in_nip.start + 2) & (nodes < r.in_nip.stop - 3)]
        return int(nodes[nodes.size // 2])

    return node


def beyond_the_bound(face: str) -> Corrupt:
    def corrupt(r: Any) -> dict[str, Any]:
        traction = getattr(r, f"{face}traction").copy()
        traction[stuck(face)(r)] = 2 * np.max(getattr(r, r.CONTACT_PRESSURE))
        return {f"{face}traction": traction}

    return corrupt


def off_the_bound(face: str, by: float) -> Corrupt:
    def corrupt(r: Any) -> dict[str, Any]:
        traction = getattr(r, f"{face}traction").copy()
        traction[slipping(face)(r)] *= by
        return {f"{face}traction": traction}

    return corrupt


def reversed_slip(face: str) -> Corrupt:
    def corrupt(r: Any) -> dict[str, Any]:
        zone, traction = (getattr(r, f"{face}{name}").copy() for name in ("zone", "traction"))
        slips = zone != 0
        zone[slips], traction[slips] = -zone[slips], -traction[slips]
        return {f"{face}zone": zone, f"{face}traction": traction}

    return corrupt


OF_NIPS: list[tuple[str, Corrupt]] = [
    ("gap_slope", lambda r: {"offset": r.offset + 1e-3 * r.half_width}),
    ("gap_slope", lambda r: {"offset": r.offset - 1e-3 * r.half_width}),
    ("gap_slope", changed("drum_pressure", middle, 0.01)),
    ("positive_pressure", changed("drum_pressure", middle, -1.2)),
    ("stick", lambda r: {"drum_creepage": r.drum_creepage + 1e-4}),
    ("stick", lambda r: {"drum_creepage": r.drum_creepage - 1e-4}),
    ("friction_bound", beyond_the_bound("roll_")),
    ("friction_bound", beyond_the_bound("drum_")),
    *(("slip_traction", off_the_bound(face, by))
      for face in ("roll_", "drum_") for by in (0.5, 1.5)),
    ("slip_direction", reversed_slip("roll_")),
    ("slip_direction", reversed_slip("drum_")),
    *(("slip_velocity", changed(name, middle, by))
      for name in ("roll_slip", "drum_slip") for by in (0.1, -0.1)),
    ("slip_velocity", scaled("drum_creepage", 1.1)),
    ("winding_force", changed("drum_traction", middle, 0.1)),
    ("winding_force", other_problem(winding_force=50.0)),
    ("winding_force", other_problem(winding_force=-50.0)),
    ("load", scaled("drum_pressure", 1.001)),
    ("load", scaled("drum_pressure", 0.999)),
    ("load", lambda r: {"problem": r.problem.replace(nip_load=0.99 * r.problem.nip_load)}),
    *(("tension", changed("tension", node, by))
      for node in (7, -1) for by in (1e-3, -1e-3)),
    ("zones", lambda r: {"roll_zone": np.where(r.roll_zone == 1, 7, r.roll_zone)}),
    ("zones", lambda r: {"drum_zone": np.append([1 - r.drum_zone[0]], r.drum_zone[1:])}),
    ("mesh", scaled("x", 1.01)),
    ("mesh", scaled("slip_x", 0.99)),
    ("mesh", scaled("half_width", 1.01)),
    ("mesh", lambda r: {"x": r.x[:-1]}),
    ("free_surface", changed("roll_traction", lambda r: r.in_nip.start, 1e-3)),
    ("free_surface", changed("drum_traction", lambda r: r.in_nip.stop - 1, 1e-3)),
    ("normal_equilibrium", changed("drum_pressure", lambda r: r.in_nip.stop - 1, 1e-3)),
]  # fmt: skip
OF_PLAIN: list[tuple[str, Corrupt]] = [
    ("curvature", lambda r: {"curvature": np.zeros(1)}),
    ("normal_equilibrium", lambda r: {"hoop_pressure": np.zeros(1)}),
    *(("roll_strain", changed("roll_strain", -5, by)) for by in (0.1, -0.1)),
]  # fmt: skip
# the load and the slope are those of the pressure on the roll in the nip, too
OF_WRAPS: list[tuple[str, Corrupt]] = [
    *(("hoop_pressure", changed(name, -5, by))
      for name in ("roll_pressure",) for by in (1e-2, -1e-2)),
    *(("curvature", changed("curvature", -5, by)) for by in (1e-2, -1e-2)),
    *(("roll_strain", changed("roll_strain", -5, by)) for by in (0.1, -0.1)),
    ("normal_equilibrium", changed("hoop_pressure", -5, 1e-2)),
    ("normal_equilibrium", changed("roll_pressure", middle, 1e-2)),
    ("positive_pressure", scaled("roll_pressure", -1.0)),
    ("slip_velocity", lambda r: {"drum_slip": np.nan_to_num(r.drum_slip, nan=0.0)}),
]  # fmt: skip
OF_ROLLERS: list[tuple[str, Corrupt]] = [
    ("gap_slope", lambda r: {"offset": r.offset + 1e-3 * r.half_width}),
    ("gap_slope", changed("pressure", 9, 0.01)),
    ("positive_pressure", changed("pressure", middle, -1.2)),
    *(("stick", lambda r, way=way: {"creepage": r.creepage + way * 1e-5,
                                    "shift": r.shift + way * 1e-9}) for way in (1, -1)),
    ("friction_bound", beyond_the_bound("")),
    ("slip_traction", off_the_bound("", 0.5)),
    ("slip_traction", off_the_bound("", 1.5)),
    ("slip_direction", reversed_slip("")),
    ("slip_velocity", changed("slip", -5, 0.1)),
    ("slip_velocity", changed("slip", -5, -0.1)),
    ("zones", lambda r: {"zone": np.where(r.zone == r.zone[-1], 7, r.zone)}),
    ("load", scaled("pressure", 1.001)),
    ("load", scaled("pressure", 0.999)),
    ("tangential_load", scaled("traction", 1.1)),
    ("tangential_load", scaled("tangential_load", 1.1)),
    ("tangential_load", scaled("tangential_load", 0.9)),
    ("tangential_load", scaled("tangential_load", np.nan)),
    ("mesh", scaled("x", 0.99)),
    ("mesh", scaled("slip_x", 1.01)),
    ("mesh", scaled("half_width", 1.01)),
    ("approach", scaled("approach", 1.01)),
]  # fmt: skip
ALL = [
    *((case, name, corrupt) for case in NIPS for name, corrupt in (*OF_NIPS, *OF_PLAIN)),
    *((case, name, corrupt) for case in WRAPS for name, corrupt in (*OF_NIPS, *OF_WRAPS)
      if name != "normal_equilibrium" or (name, corrupt) in OF_WRAPS),
    *((case, name, corrupt) for case in ALL_ROLLERS for name, corrupt in OF_ROLLERS),
    ("rollers, creepage", "creepage", scaled("creepage", 1.1)),
    ("rollers, creepage", "creepage", scaled("creepage", 0.9)),
    ("rollers, static", "creepage", lambda r: {"creepage": 0.0}),
    ("rollers", "creepage", lambda r: {"shift": 0.0}),
    ("rollers", "rolling_resistance", lambda r: {"rolling_resistance": 0.0}),
    ("rollers, viscoelastic", "rolling_resistance", scaled("rolling_resistance", 1.001)),
]  # fmt: skip


@pytest.mark.parametrize("case", PROBLEMS)
def test_a_solved_result_satisfies_every_condition_evaluated_again(case: str) -> None:
    result = solved(case)
    again = result.certified()
    assert [name for name, _ in again.items()] == [name for name, _ in result.residuals.items()]
    assert again.largest <= ACCEPTED_RESIDUAL
    assert result.residual == result.residuals.largest <= ACCEPTED_RESIDUAL


@pytest.mark.parametrize(
    ("case", "condition", "corrupt"), ALL,
    ids=[f"{case}: {condition} {k}" for k, (case, condition, _) in enumerate(ALL)],
)  # fmt: skip
def test_a_corrupted_result_violates_its_condition(
    case: str, condition: str, corrupt: Corrupt
) -> None:
    result = solved(case)
    found = result.replace(**corrupt(result)).certified()
    assert not dict(found.items()).get(condition, 0.0) < SEEN
    assert not found.largest < SEEN


@pytest.mark.parametrize("case", PROBLEMS)
def test_no_condition_is_without_its_corruption(case: str) -> None:
    tested = {condition for name, condition, _ in ALL if name == case}
    kind = NIPS if case in NIPS else WRAPS if case in WRAPS else ALL_ROLLERS
    tested |= {condition for name, condition, _ in ALL if name in kind}
    tested |= {f"{body}_equilibrium" for body in ("roll", "drum", "upper", "lower")}
    assert {name for name, _ in solved(case).residuals.items()} <= tested


@pytest.mark.parametrize("kind", ["nip", "wrapped", "rollers"])
def test_the_equilibrium_inside_a_nonlinear_body_is_a_condition(
    kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    soft = hardening_roll(K2=40.0, P0=200e3)
    cases = {
        "nip": newsprint_nip(roll=soft), "wrapped": newsprint_nip(roll=soft, roll_wrap=np.pi),
        "rollers": wo.RollerProblem(
            upper=wo.Rigid(radius=0.2), lower=soft, load=2e3, friction=0.3, tangential_load=100.0
        ),
    }  # fmt: skip
    condition = "lower_equilibrium" if kind == "rollers" else "roll_equilibrium"
    result: Any = wo.solve(cases[kind], nodes=17)
    assert getattr(result.residuals, condition) <= ACCEPTED_RESIDUAL
    # a ring whose iteration ends too early
    wound_roll.ring_of.cache_clear()
    monkeypatch.setattr(ring_equilibrium, "TOLERANCE", 1e-3)
    assert getattr(result.certified(), condition) > ACCEPTED_RESIDUAL
    wound_roll.ring_of.cache_clear()


@pytest.mark.parametrize("case", ["nip", "wrapped, both", "rollers"])
def test_nan_is_never_hidden(case: str) -> None:
    result = solved(case)
    for name in (result.CONTACT_PRESSURE, "x"):
        values = getattr(result, name).copy()
        values[4] = np.nan
        broken = result.replace(**{name: values})
        assert not broken.certified().largest <= ACCEPTED_RESIDUAL
        with pytest.raises(wo.NotConverged):
            broken.replace(residuals=broken.certified()).checked()


def test_a_nan_counts_as_the_largest() -> None:
    values = {"gap_slope": 1e-12, "stick": float("nan"), "friction_bound": 3e-9}
    for order in (list(values), list(values)[::-1]):
        residuals = Residuals(**{name: values[name] for name in order})
        assert np.isnan(residuals.largest)
        assert residuals.worst == "stick"
    assert Residuals(a=1.0, b=2.0).largest == 2.0
    assert Residuals(a=1.0, b=2.0).worst == "b"


def test_no_conditions_are_no_certificate() -> None:
    assert np.isnan(Residuals().largest)
    with pytest.raises(wo.NotConverged, match="no condition was evaluated"):
        solved("nip").replace(residuals=Residuals()).checked()


def test_a_violated_condition_is_named_and_the_result_is_carried() -> None:
    result = solved("nip")
    broken = result.replace(residuals=result.residuals.replace(stick=2e-8, load=1e-3))
    with pytest.raises(wo.NotConverged, match=r"stick 2e-08, load 0\.001") as fault:
        broken.checked()
    assert fault.value.best is broken


def test_the_tensions_are_those_of_the_tractions() -> None:
    """NIT = int (q+ + q-) dx = T(end) - T_in, by another sum: equilibrium."""
    for case in (*NIPS, *WRAPS):
        r = solved(case)
        T, own = r.tension, r.in_nip
        whole = np.trapezoid(r.roll_traction + r.drum_traction, r.x)
        assert r.nip_induced_tension == pytest.approx(whole, rel=1e-12)
        assert r.nip_induced_tension == pytest.approx(T[-1] - T[0], rel=1e-10)
        assert T[0] == r.problem.web_tension
        assert r.wound_on_tension == T[-1]
        assert (r.inlet_tension, r.outlet_tension) == (T[own.start], T[own.stop - 1])
    for case in NIPS:
        r = solved(case)
        assert (r.wound_on_tension, r.inlet_tension) == (r.outlet_tension, r.problem.web_tension)
        assert r.x[[0, -1]] == pytest.approx([-r.half_width, r.half_width])
        assert (r.slip_angle, r.hoop_pressure.size, r.curvature.size) == (0.0, 0, 0)
        assert r.roll_wrap_traction == r.drum_wrap_traction == 0
    # the traction downstream of the edge is that on the roll alone
    r = solved("wrapped, both")
    own, on_wrap = r.in_nip, slice(r.in_nip.stop - 1, None)
    on_roll = np.trapezoid(r.roll_traction[on_wrap], r.x[on_wrap])
    cell = r.x[own.stop] - r.x[own.stop - 1]
    lumped = abs(r.drum_traction[own.stop - 1] + r.roll_traction[own.stop - 1]) * cell
    assert r.wound_on_tension - r.outlet_tension == pytest.approx(on_roll, abs=lumped + 1e-6)


@pytest.mark.parametrize("case", ["nip", "nip, cover", "wrapped, both"])
def test_consistency_converges_with_the_mesh(case: str) -> None:
    """Equilibrium by another quadrature: the defects fall at least as the cells."""
    coarse, fine = (dict(wo.solve(PROBLEMS[case], nodes=n).consistency.items()) for n in (33, 129))
    for name in ("load", "tension"):
        # four times the nodes; trapezoidal rules in theta are of second order, and zone boundaries
        # move within their cells
        assert fine[name] < 0.5 * coarse[name] + 1e-6, name
        assert fine[name] < 5e-3, name


class WrongStrain(wo.Cylinder, abstract=True):  # not registered: of this test alone
    """A cylinder whose strain under pressure is 5 % too large."""

    def surface(self, face: Any, half_width: float, speed: float | None = None) -> Any:
        right, zero = super().surface(face, half_width, speed), np.zeros(face.nodes.size)
        tangent = right.tangent(zero, zero)
        wrong = tangent._replace(strain_p=1.05 * tangent.strain_p)
        return LinearSurface(wrong, np.array(right.end_tangent(zero, zero)))


@pytest.mark.parametrize("wrapped", [False, True])
def test_an_error_of_an_influence_function_is_detected_by_the_power_balance(wrapped: bool) -> None:
    """The residuals do not notice it: the equations have the same matrices."""
    roll: Any = newsprint_nip().roll
    wrong = WrongStrain(radius=roll.radius, core_radius=roll.core_radius, material=roll.material)

    def solved(body: wo.Body) -> Any:
        nip = newsprint_nip(roll=body)
        return wo.solve(nip.replace(roll_wrap=np.pi) if wrapped else nip, nodes=129)

    right, found = solved(roll), solved(wrong)
    assert found.residuals.largest <= ACCEPTED_RESIDUAL
    assert any("the condition power_balance is violated" in text for text in found.warnings)
    assert not any("power_balance" in text for text in right.warnings)
