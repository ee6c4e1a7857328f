"""Every law of every certificate can fail: a corrupted state raises the residual of its law.

A certificate that returned zeros, for one law or for all, fails here for each of them.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from math import pi
from typing import Any

import numpy as np
import pytest
from hardening_cases import nip as hardening_nip
from hardening_cases import roll as hardening_roll
from thesis_cases import newsprint_nip, paper_nip

import woundon as wo
from woundon.elasticity import hardening_ring
from woundon.problems.bodies import KernelBody
from woundon.problems.direct import ring
from woundon.results import ACCEPTED_RESIDUAL, Residuals

Array = np.ndarray
# ten thousand times what is accepted: no corruption below passes for rounding
SEEN = 1e4 * ACCEPTED_RESIDUAL


@cache
def solved(case: str) -> Any:
    steel = wo.HalfPlane(radius=0.25, material="steel")
    rollers = wo.RollerProblem(
        upper=steel, lower=steel, load=89e3, tangential_load=8.4e3, friction=0.5
    )
    cover = wo.Cylinder(radius=0.5, core_radius=0.48, material="soft-cover")
    return {
        "nip": lambda: wo.solve(newsprint_nip(), nodes=33),
        "nip on a cover": lambda: wo.solve(paper_nip(drum=cover), nodes=33),
        "nip on elements": lambda: wo.solve(paper_nip(drum=cover, nip_load=2500.0), rtol=1e-6),
        "wrapped": lambda: wo.solve(newsprint_nip().wrapped(), nodes=33),
        "wrapped on both": lambda: wo.solve(paper_nip(drum=cover).wrapped(drum_wrap=1.0), nodes=33),
        "rollers": lambda: wo.solve(rollers, nodes=41),
        "rollers, static": lambda: wo.solve(rollers.replace(motion="static"), nodes=41),
        "rollers, creepage": lambda: wo.solve(
            rollers.replace(tangential_load=None, creepage=1e-4), nodes=41
        ),
    }[case]()


NIPS = ["nip", "nip on a cover", "nip on elements"]
WRAPS = ["wrapped", "wrapped on both"]
ROLLERS = ["rollers", "rollers, static", "rollers, creepage"]

Corrupt = Callable[[Any], dict[str, Any]]


def changed(name: str, node: int, by: float) -> Corrupt:
    """Add to one node of an array a share of the array's largest value."""

    def corrupt(r: Any) -> dict[str, Any]:
        values = getattr(r, name).copy()
        values[node] += by * np.nanmax(np.abs(values))
        return {name: values}

    return corrupt


def scaled(name: str, by: float) -> Corrupt:
    return lambda r: {name: getattr(r, name) * by}


def beyond_the_bound(face: str) -> Corrupt:
    """Let a sticking node carry more than friction allows."""

    def corrupt(r: Any) -> dict[str, Any]:
        names = (f"{face}traction", f"{face}zone")
        traction, zone = (getattr(r, name).copy() for name in names)
        stuck = np.nonzero(zone == 0)[0]
        node = int(stuck[np.abs(r.x[stuck]) < 0.9 * r.half_width][1])
        traction[node] = 2 * np.max(r.pressure)
        return {names[0]: traction}

    return corrupt


def not_on_the_bound(face: str, by: float = 0.5) -> Corrupt:
    """Let a slipping node carry less than friction gives, or more."""

    def corrupt(r: Any) -> dict[str, Any]:
        names = (f"{face}traction", f"{face}zone")
        traction, zone = (getattr(r, name).copy() for name in names)
        inner = np.nonzero(zone[2:-2])[0] + 2
        traction[inner[inner.size // 2]] *= by
        return {names[0]: traction}

    return corrupt


def slipping_the_wrong_way(face: str) -> Corrupt:
    def corrupt(r: Any) -> dict[str, Any]:
        names = (f"{face}zone", f"{face}traction")
        zone, traction = (getattr(r, name).copy() for name in names)
        slips = zone != 0
        zone[slips], traction[slips] = -zone[slips], -traction[slips]
        return {names[0]: zone, names[1]: traction}

    return corrupt


def pulling(r: Any) -> dict[str, Any]:
    """Let a node in the middle pull."""
    pressure = r.pressure.copy()
    pressure[pressure.size // 2] = -0.01 * pressure.max()
    return {"pressure": pressure}


def _widest(r: Any) -> int:
    """Return the node that carries most: between the widest cells of the nip."""
    return int(r.in_nip.start + np.argmax(np.gradient(r.x[r.in_nip])))


# misses of the other sign than those below
NIP_OPPOSITES: list[tuple[str, Corrupt]] = [
    ("indentation", lambda r: {"offset": r.offset - 1e-3 * r.half_width}),
    ("stick", lambda r: {"drum_creep": r.drum_creep - 1e-4}),
    ("slip_traction", not_on_the_bound("roll_", 1.5)),
    ("slip_traction", not_on_the_bound("drum_", 0.5)),
    ("slip_traction", not_on_the_bound("drum_", 1.5)),
    ("slip_speed", lambda r: changed("roll_slip", r.in_nip.stop - 5, -0.1)(r)),
    ("slip_speed", lambda r: changed("drum_slip", r.in_nip.stop - 5, -0.1)(r)),
    ("load_equilibrium", scaled("pressure", 0.999)),
    ("force_equilibrium", lambda r: {"problem": r.problem.replace(winding_force=-50.0)}),
    ("half_width", scaled("x", 0.99)),
]
NIP_CORRUPTIONS: list[tuple[str, Corrupt]] = [
    ("indentation", scaled("offset", 1.0)),
    ("indentation", lambda r: {"offset": r.offset + 1e-3 * r.half_width}),
    ("indentation", changed("pressure", 9, 0.01)),
    ("positive_pressure", pulling),
    ("stick", lambda r: {"drum_creep": r.drum_creep + 1e-4}),
    ("friction_bound", beyond_the_bound("roll_")),
    ("friction_bound", beyond_the_bound("drum_")),
    ("slip_traction", not_on_the_bound("roll_")),
    ("slip_traction", lambda r: {"roll_zone": np.where(r.roll_zone == 1, 7, r.roll_zone)}),
    ("slip_direction", slipping_the_wrong_way("roll_")),
    ("slip_speed", lambda r: changed("roll_slip", r.in_nip.stop - 5, 0.1)(r)),
    ("slip_speed", lambda r: changed("drum_slip", r.in_nip.stop - 5, 0.1)(r)),
    ("slip_speed", lambda r: {"drum_creep": 1.1 * r.drum_creep}),
    ("load_equilibrium", scaled("pressure", 1.001)),
    ("load_equilibrium", lambda r: {"problem": r.problem.replace(nip_load=2e3)}),
    ("force_equilibrium", lambda r: changed("drum_traction", _widest(r), 0.1)(r)),
    ("force_equilibrium", lambda r: {"problem": r.problem.replace(winding_force=50.0)}),
    ("web_equilibrium", changed("web_tension", 7, 1e-3)),
    ("web_equilibrium", scaled("web_tension", 1.001)),
    ("web_equilibrium", scaled("nip_induced_tension", 38.0)),
    ("web_equilibrium", lambda r: {"extrapolation": 1.0}),
    ("half_width", scaled("half_width", 1.01)),
    ("half_width", scaled("x", 1.01)),
    ("web_equilibrium", changed("web_tension", 7, -1e-3)),
    ("web_equilibrium", lambda r: {"extrapolation": -1.0}),
    *NIP_OPPOSITES,
]
WRAP_CORRUPTIONS: list[tuple[str, Corrupt]] = [
    (law, corrupt) for law, corrupt in NIP_CORRUPTIONS
    if law not in ("web_equilibrium", "half_width", "indentation", "positive_pressure")
] + [
    ("indentation", lambda r: {"offset": r.offset + 1e-3 * r.half_width}),
    ("indentation", lambda r: changed("roll_pressure", r.in_nip.start + 9, 0.01)(r)),
    ("positive_pressure", scaled("roll_pressure", -1.0)),
    ("web_equilibrium", changed("web_tension", 3, 1e-3)),
    ("web_equilibrium", changed("web_tension", -1, 1e-3)),
    ("web_equilibrium", changed("web_tension", 3, -1e-3)),
    ("indentation", lambda r: {"offset": r.offset - 1e-3 * r.half_width}),
    ("hoop_pressure", changed("hoop_pressure", -5, -1e-2)),
    ("hoop_pressure", changed("roll_pressure", -3, -1e-2)),
    ("curvature", changed("curvature", -5, -1e-2)),
    ("slip_speed", changed("roll_strain", -5, -0.1)),
    ("hoop_pressure", changed("hoop_pressure", -5, 1e-2)),
    ("hoop_pressure", changed("roll_pressure", -3, 1e-2)),
    ("curvature", changed("curvature", -5, 1e-2)),
    ("slip_speed", changed("roll_strain", -5, 0.1)),
    ("slip_speed", lambda r: {"drum_slip": np.nan_to_num(r.drum_slip, nan=0.0)}),
    ("half_width", scaled("x", 1.01)),
]  # fmt: skip
ROLLER_CORRUPTIONS: list[tuple[str, Corrupt]] = [
    ("indentation", lambda r: {"offset": r.offset + 1e-3 * r.half_width}),
    ("indentation", changed("pressure", 9, 0.01)),
    ("positive_pressure", pulling),
    ("stick", lambda r: {"creepage": r.creepage + 1e-5, "shift": r.shift + 1e-9}),
    ("friction_bound", beyond_the_bound("")),
    ("slip_traction", not_on_the_bound("")),
    ("slip_direction", slipping_the_wrong_way("")),
    ("slip_speed", changed("slip", -5, 0.1)),
    ("load_equilibrium", scaled("pressure", 1.001)),
    ("force_equilibrium", scaled("traction", 1.1)),
    ("force_equilibrium", scaled("tangential_load", 1.1)),
    ("indentation", lambda r: {"offset": r.offset - 1e-3 * r.half_width}),
    ("stick", lambda r: {"creepage": r.creepage - 1e-5, "shift": r.shift - 1e-9}),
    ("slip_traction", not_on_the_bound("", 1.5)),
    ("slip_speed", changed("slip", -5, -0.1)),
    ("load_equilibrium", scaled("pressure", 0.999)),
    ("force_equilibrium", scaled("traction", 0.9)),
    ("force_equilibrium", scaled("tangential_load", 0.9)),
    ("half_width", scaled("x", 0.99)),
    ("half_width", scaled("half_width", 1.01)),
    ("half_width", scaled("x", 1.01)),
]
ALL = [
    *((case, law, corrupt) for case in NIPS for law, corrupt in NIP_CORRUPTIONS[1:]),
    *((case, law, corrupt) for case in WRAPS for law, corrupt in WRAP_CORRUPTIONS),
    *((case, law, corrupt) for case in ROLLERS for law, corrupt in ROLLER_CORRUPTIONS),
    ("rollers, creepage", "creepage", scaled("creepage", 1.1)),
    ("rollers, creepage", "creepage", scaled("creepage", 0.9)),
]
ids = [f"{case}: {law} {k}" for k, (case, law, _) in enumerate(ALL)]


@pytest.mark.parametrize("case", [*NIPS, *WRAPS, *ROLLERS])
def test_a_solved_state_keeps_every_law_measured_anew(case: str) -> None:
    result = solved(case)
    anew = result.certified()
    assert [law for law, _ in anew.items()] == [law for law, _ in result.residuals.items()]
    assert anew.largest <= ACCEPTED_RESIDUAL
    assert result.residuals.largest <= ACCEPTED_RESIDUAL
    assert result.residual == result.residuals.largest


@pytest.mark.parametrize(("case", "law", "corrupt"), ALL, ids=ids)
def test_a_corrupted_state_raises_the_residual_of_its_law(
    case: str, law: str, corrupt: Corrupt
) -> None:
    result = solved(case)
    assert getattr(result.certified(), law) <= ACCEPTED_RESIDUAL
    found = measured(result.replace(**corrupt(result)))
    assert not getattr(found, law) < SEEN
    assert not found.largest < SEEN


def measured(result: Any) -> Residuals:
    """Measure the certificate; nodes that can be no nip's break the law of the half width."""
    try:
        return result.certified()  # type: ignore[no-any-return]
    except wo.InvalidProblem:
        return Residuals(half_width=float("inf"))


@pytest.mark.parametrize(
    ("cases", "corruptions"),
    [(NIPS, NIP_CORRUPTIONS), (WRAPS, WRAP_CORRUPTIONS), (ROLLERS, ROLLER_CORRUPTIONS)],
    ids=["nip", "wrapped", "rollers"],
)
def test_no_law_is_without_its_corruption(
    cases: list[str], corruptions: list[tuple[str, Corrupt]]
) -> None:
    proved = {law for law, _ in corruptions} | {"creepage"}
    for case in cases:
        assert {law for law, _ in solved(case).residuals.items()} <= proved


@pytest.mark.parametrize("kind", ["nip", "wrapped", "rollers"])
def test_the_equilibrium_inside_each_body_is_a_law(
    kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A body that is left out of equilibrium is not certified, be it the first or the second."""
    stack = wo.Stack(
        radial=wo.Pfeiffer(K1=10e3, K2=40.0), tangential=3.38e9, poissons_ratio=0.01, shear=10e6
    )
    soft = wo.WoundRoll(radius=0.1, core_radius=0.0445, stack=stack, pressure=200e3)
    nip = newsprint_nip(roll=soft)
    cases = {
        "nip": nip, "wrapped": nip.wrapped(),
        "rollers": wo.RollerProblem(
            upper=wo.Rigid(radius=0.2), lower=soft, load=2e3, friction=0.3, tangential_load=100.0
        ),
    }  # fmt: skip
    law = "lower_equilibrium" if kind == "rollers" else "roll_equilibrium"
    result: Any = wo.solve(cases[kind], nodes=17)
    assert getattr(result.residuals, law) <= ACCEPTED_RESIDUAL
    ring.cache_clear()
    monkeypatch.setattr(hardening_ring, "_latest", None)
    monkeypatch.setattr(hardening_ring, "EQUILIBRIUM", 1e-3)
    assert getattr(result.certified(), law) > ACCEPTED_RESIDUAL


@pytest.mark.parametrize("case", ["nip", "wrapped", "rollers"])
def test_elastic_bodies_resist_no_rolling(case: str) -> None:
    result = solved(case)
    assert "power_balance" not in dict(result.residuals.items())
    broken = result.replace(rolling_resistance=1e-3).certified()
    assert broken.power_balance == broken.largest == float("inf")


@pytest.mark.parametrize("case", ["nip", "wrapped on both", "rollers"])
def test_every_array_and_every_told_number_is_under_some_law(case: str) -> None:
    """What a result reports is certified: no field can change unnoticed but those named here."""
    result = solved(case)
    derived = {
        "approach",  # by the displacements, which enter no law
        "leading_roll", "trailing_roll", "dual",  # measures of the zones
        "slip_x", "series_terms", "series_error", "iterations", "extrapolation",
        "extrapolation_behind", "extrapolation_of_nip", "traction_error", "shift",
    }  # fmt: skip
    from dataclasses import fields

    for part in fields(result):
        value = getattr(result, part.name)
        if part.name in derived or not isinstance(value, (float, np.ndarray)):
            continue
        if isinstance(value, np.ndarray) and value.dtype.kind != "f":
            continue
        if isinstance(value, float) and value != value:
            continue  # what it does not have: elastic bodies no rolling resistance
        if isinstance(value, float):
            wrong: Any = value * 1.1 + 1e-3 * result.half_width * (part.name == "offset")
        else:
            wrong = value.copy()
            k = int(np.argmax(np.nan_to_num(np.abs(value))))
            wrong[k] *= 1.1
        assert not measured(result.replace(**{part.name: wrong})).largest < SEEN, part.name


@pytest.mark.parametrize("case", ["nip", "wrapped on both", "rollers"])
def test_nan_is_never_hidden(case: str) -> None:
    result = solved(case)
    for name in ("pressure", "x"):
        values = getattr(result, name).copy()
        values[4] = np.nan
        broken = result.replace(**{name: values})
        assert np.isnan(broken.certified().largest)
        with pytest.raises(wo.NotConverged, match="nan"):
            broken.replace(residuals=broken.certified()).checked()


def test_a_nan_counts_as_the_largest() -> None:
    laws = {"indentation": 1e-12, "stick": float("nan"), "friction_bound": 3e-9}
    for order in (list(laws), list(laws)[::-1]):
        residuals = Residuals(**{law: laws[law] for law in order})
        assert np.isnan(residuals.largest)
        assert residuals.worst == "stick"
    assert Residuals(a=1.0, b=2.0).largest == 2.0
    assert Residuals(a=1.0, b=2.0).worst == "b"


def test_no_laws_are_no_certificate() -> None:
    assert np.isnan(Residuals().largest)
    with pytest.raises(wo.NotConverged, match="no certificate"):
        solved("nip").replace(residuals=Residuals()).checked()


def test_a_broken_law_is_refused_by_name_and_the_result_is_carried() -> None:
    result = solved("nip")
    broken = result.replace(residuals=result.residuals.replace(stick=2e-8, load_equilibrium=1e-3))
    with pytest.raises(wo.NotConverged, match=r"stick 2e-08, load_equilibrium 0\.001") as fault:
        broken.checked()
    assert fault.value.best is broken


def test_the_tension_told_is_the_integral_of_the_tractions() -> None:
    """NIT = int (q+ + q-) dx + extrapolation, by borders' places or, with rtol, to zero cells."""
    for result in solved("nip"), wo.solve(paper_nip(), rtol=1e-4):
        whole = np.trapezoid(result.roll_traction + result.drum_traction, result.x)
        assert result.nip_induced_tension - result.extrapolation == pytest.approx(whole, rel=1e-12)
        assert result.extrapolation != 0.0
        assert abs(result.extrapolation) < 1e-2 * whole
    wrapped = solved("wrapped on both")
    T, own = wrapped.web_tension, wrapped.in_nip
    first, last = float(T[own.start]), float(T[own.stop - 1])
    assert wrapped.wound_on_tension == float(T[-1]) + wrapped.extrapolation
    assert wrapped.tension_behind_nip == last + wrapped.extrapolation_behind
    gained = last - first + wrapped.extrapolation_of_nip
    assert wrapped.nip_induced_tension == pytest.approx(gained, rel=1e-12)
    before = first + wrapped.extrapolation_behind - wrapped.extrapolation_of_nip
    assert wrapped.tension_before_nip == pytest.approx(before, rel=1e-14)
    assert 0 not in (wrapped.extrapolation, wrapped.extrapolation_of_nip)
    assert wrapped.problem.drum_wrap == 1.0 < pi


def test_a_miss_of_curvature_counts_by_the_largest_either_way():
    # the drum is the smaller one, and the web bends the other way on it; a roll that deforms would
    # bend the web more behind the nip
    roll, drum = wo.Rigid(radius=0.5), wo.HalfPlane(radius=0.1, material="soft-cover")
    result = wo.solve(paper_nip(roll=roll, drum=drum).wrapped(drum_wrap=1.0), nodes=33)
    curvature = result.curvature.copy()
    assert -curvature.min() > curvature.max()
    curvature[-5] += 1e-3
    found = result.replace(curvature=curvature).certified().curvature
    # the other nodes are off by 1e-9 of the largest, as solved
    assert found == pytest.approx(1e-3 / -result.curvature.min(), rel=1e-4)


def test_what_rounding_leaves_of_a_hardening_rolls_curvature_hides_nothing():
    """Behind the edge, in the shortest cells, it is largest."""
    problem = hardening_nip(hardening_roll()).wrapped(roll_wrap=pi / 2)
    result = wo.solve(problem, nodes=17)
    assert result.residuals.curvature <= 1e-8
    for node in (result.in_nip.stop, result.x.size - 5):
        curvature = result.curvature.copy()
        curvature[node] += 1e-6 * curvature.max()
        found = result.replace(curvature=curvature).certified().curvature
        # at the edge 1e-9 of the slopes over cells of some thousandths of the half width are let go
        assert 5e-7 < found <= 1.1e-6


@pytest.mark.parametrize("case", ["nip on a cover", "rollers"])
def test_bodies_are_asked_about_the_loads_that_a_result_reports(
    case: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    result, respond = solved(case), KernelBody.respond
    asked: list[Any] = []

    def noted(body: Any, grid: Any, a: float, about: Any = None) -> Any:
        asked.append(about)
        return respond(body, grid, a, about)

    monkeypatch.setattr(KernelBody, "respond", noted)
    result.certified()
    if case == "rollers":
        tractions = [result.traction, -result.traction]
    else:
        tractions = [result.roll_traction, result.drum_traction]
    for about, traction in zip(asked, tractions, strict=True):
        np.testing.assert_array_equal(about.pressure, result.pressure[1:-1])
        np.testing.assert_array_equal(about.traction, traction[1:-1])
