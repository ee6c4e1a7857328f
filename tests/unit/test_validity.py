"""Where a solved nip leaves the model: each warning by a case that earns it, with its numbers."""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from thesis_cases import newsprint_nip, paper_nip

import woundon as wo
from woundon import validity
from woundon.elasticity.mesh import Wrap, nip_mesh
from woundon.nip.validity import _body_surface_strains, _web_strain

NODES = 33  # warnings do not wait for accuracy


def isotropic(youngs_modulus: float, poissons_ratio: float = 0.3) -> wo.Isotropic:
    return wo.Isotropic(youngs_modulus=youngs_modulus, poissons_ratio=poissons_ratio)


def cover(thickness: float, material: wo.Isotropic | wo.Orthotropic) -> wo.Cylinder:
    return wo.Cylinder(radius=0.5, core_radius=0.5 - thickness, material=material)


def solved(problem: wo.NipProblem, nodes: int = NODES) -> wo.NipResult:
    return wo.solve(problem, nodes=nodes)


def the(result: wo.Result, pattern: str) -> list[float]:
    """Return the numbers of the one warning that matches, percents as shares."""
    matches = [match for text in result.warnings if (match := re.fullmatch(pattern, text))]
    assert len(matches) == 1, result.warnings
    return [float(n[:-1]) / 100 if n.endswith("%") else float(n) for n in matches[0].groups()]


NUMBER = r"(-?[\d.]+(?:e[+-]?\d+)?)"
PERCENT = r"(-?[\d.]+%)"


def test_an_ordinary_nip_earns_none() -> None:
    for problem in (paper_nip(), newsprint_nip(), paper_nip(drum=cover(0.02, isotropic(1e8)))):
        assert wo.solve(problem).warnings == ()


def test_a_wide_nip() -> None:
    drum = wo.HalfPlane(radius=0.06, material=isotropic(5e5))
    result = solved(paper_nip(drum=drum, nip_load=5000.0))
    width, share = the(result, f"the half width {NUMBER} mm is {PERCENT} of the smaller radius .*")
    assert width == pytest.approx(1e3 * result.half_width, rel=5e-3)
    assert share == pytest.approx(result.half_width / 0.06, abs=5e-3)


def test_a_cover_pressed_deep() -> None:
    result = solved(paper_nip(drum=cover(0.002, isotropic(1e6)), nip_load=3000.0))
    depth, share, thickness = the(
        result,
        f"the drum's indentation {NUMBER} mm is {PERCENT} of its elastic layer, {NUMBER} mm .*",
    )
    assert 1e-3 * depth < result.approach  # roll and web take some of it
    assert share == pytest.approx(1e-3 * depth / 0.002, rel=5e-3)
    assert thickness == 2.0


@pytest.mark.parametrize("body", ["roll", "drum"])
def test_a_pressure_near_the_modulus(body: str) -> None:
    soft = wo.HalfPlane(radius=0.3, material=isotropic(4e5))
    result = solved(paper_nip(**{body: soft}, nip_load=8000.0))
    peak, share, modulus = the(
        result, f"the peak pressure {NUMBER} MPa is {PERCENT} of the {body}'s stiffness {NUMBER} .*"
    )
    assert peak == pytest.approx(result.drum_pressure.max() / 1e6, rel=5e-3)
    assert modulus == pytest.approx(soft.material.stiffness.rr / 1e6, rel=5e-3)
    assert share == pytest.approx(peak / modulus, abs=1e-2)


def test_a_web_pressed_thin() -> None:
    paper = wo.material("paper").replace(radial=2e6)
    result = solved(paper_nip(web=wo.Web(thickness=66e-6, material=paper)))
    _, share, modulus = the(
        result, f"the peak pressure {NUMBER} MPa is {PERCENT} of the web's radial stiffness "
        f"{NUMBER} MPa .*",
    )  # fmt: skip
    assert modulus == 2.0
    assert share == pytest.approx(result.drum_pressure.max() / 2e6, abs=5e-3)


def test_a_surface_sheared_far() -> None:
    drum = wo.HalfPlane(radius=0.5, material=isotropic(1e6))
    result = solved(paper_nip(drum=drum, drum_friction=0.8, winding_force=1000.0))
    share, traction = the(
        result,
        f"the drum's surface shear strain is {PERCENT} at a traction of {NUMBER} MPa .*",
    )
    assert traction == pytest.approx(np.abs(result.drum_traction).max() / 1e6, rel=5e-3)
    assert share == pytest.approx(1e6 * traction / drum.material.stiffness.shear, abs=1e-2)


def test_a_surface_stretched_far() -> None:
    # the web drags a thin soft cover along and stretches it downstream
    soft = cover(0.005, isotropic(1e6, 0.45))
    result = solved(paper_nip(drum=soft, nip_load=8e3, drum_friction=0.8, winding_force=4e3))
    strain, at = the(result, f"the drum's surface strain is {PERCENT} at x = {NUMBER} mm .*")
    assert strain == pytest.approx(-0.2, abs=0.01)
    assert abs(at) < 1e3 * result.half_width


def test_a_slack_web() -> None:
    result = solved(paper_nip(web_tension=1.0))
    lowest, _, missing = the(
        result, f"the web is slack: its tension falls to {NUMBER} N/m at x = {NUMBER} mm; at least "
        f"{NUMBER} N/m of web tension are needed",
    )  # fmt: skip
    assert lowest == pytest.approx(result.tension.min(), rel=1e-3)
    # the winding theorem: NIT and all tractions stay, so that much tension is just enough
    enough = solved(paper_nip(web_tension=missing * 1.001))
    assert enough.tension.min() == pytest.approx(0.0, abs=0.01)
    assert enough.warnings == ()


def test_few_nodes_in_a_zone() -> None:
    result = solved(newsprint_nip(), nodes=13)
    texts = result.warnings
    resolved = [re.sub(r", the ends of which are known to [\d.]+ mm", "", text) for text in texts]
    assert "resolution: 2 nodes in a stick zone at the roll; use 25 nodes" in resolved
    # the words of the reports; the roll's last zone and the drum's are one
    assert "resolution: 3 nodes in a zone with the web slower at the roll; use 25 nodes" in resolved
    assert "resolution: 3 nodes in the dual-slip zone; use 25 nodes" in resolved
    cell = float(np.diff(result.x[result.in_nip]).max()) * 1e3
    known = [float(text.split("known to ")[1].split(" mm")[0]) for text in texts if "known" in text]
    assert all(0 < one <= 1.05 * cell for one in known)
    assert not any("nodes in a" in text for text in solved(newsprint_nip(), nodes=65).warnings)


def test_the_point_where_the_slip_reverses_is_no_unresolved_zone() -> None:
    def resolved(zones: list[int]) -> bool:
        x = np.linspace(-1.0, 1.0, len(zones))
        return not list(validity.zone_warnings(x, {"drum": np.array(zones)}))

    slower, faster = [-1] * 6, [1] * 6
    assert resolved([*slower, 0, *faster])
    assert not resolved([*slower, 0, *slower])  # a stick zone of its own
    assert not resolved([*slower, 0, 0, *faster])


@pytest.mark.slow  # a quarter of a million terms
def test_a_series_cut_short() -> None:
    stiff_outward = wo.Orthotropic(radial=1e10, tangential=1e4, cross=0.0, shear=1e4)
    light = {"nip_load": 10.0, "winding_force": 0.0}  # the contact is resolved, the series is not
    result = solved(paper_nip(drum=cover(0.005, stiff_outward), **light))
    error, terms = the(
        result, "resolution: the series of an elastic layer is truncated with an error of "
        f"{NUMBER} after {NUMBER} terms",
    )  # fmt: skip
    assert error == pytest.approx(result.series_error, rel=0.05)
    assert terms == result.series_terms


@pytest.mark.parametrize("thickness", [66e-6, 33e-6])
def test_the_drums_surface_strain_is_that_of_its_own_response(thickness: float) -> None:
    """The warning reads the strain off the web's and the slip; the kernels give it directly."""
    drum = cover(0.02, isotropic(2e6, 0.45))
    problem = paper_nip(drum=drum, winding_force=300.0, **{"web.thickness": thickness})
    result = solved(problem, nodes=129)
    surface = drum.surface(nip_mesh(129, Wrap(), Wrap()).drum_face, result.half_width)
    direct = surface.deform(result.drum_pressure, result.drum_traction).strain[:-1]
    # tensions are interpolated to the cells' middles: second order in the cells
    np.testing.assert_allclose(
        _body_surface_strains(result, _web_strain(result))["drum"][1:],
        direct[:-1],
        atol=1e-3 * np.abs(direct).max(),
    )


# ---- the web ------------------------------------------------------------------------------------


@pytest.mark.parametrize("wrapped", [False, True])
def test_a_web_stretched_far(wrapped: bool) -> None:
    nip = newsprint_nip(web_tension=1e5)
    result = wo.solve(nip.replace(roll_wrap=np.pi) if wrapped else nip, nodes=NODES)
    strain, tension, limit = the(
        result, f"the web's strain is {PERCENT} at a tension of {NUMBER} N/m "
        f"\\(limit {PERCENT}\\): paper breaks and film yields at a few percent",
    )  # fmt: skip
    # eps = T/(2h D) under what little the pressure adds; D = A_tt - A_rt^2/A_rr
    assert strain == pytest.approx(tension / (66e-6 * (3.38e9 - 25e12 / 27e6)), rel=5e-3)
    # paper breaks at 1 to 3 %: an ordinary winder's tension is far from it
    assert limit == 0.02
    assert wo.solve(nip.replace(web_tension=1e3), nodes=65).warnings == ()


def test_a_web_as_thick_as_its_nip_is_wide() -> None:
    result = solved(paper_nip(nip_load=0.1, winding_force=0.0))
    thickness, share, width, limit = the(
        result, f"the web's thickness {NUMBER} um is {PERCENT} of the nip width {NUMBER} mm "
        f"\\(limit {PERCENT}\\): the web is no thin strip in so narrow a nip",
    )  # fmt: skip
    assert thickness == 66.0
    assert width == pytest.approx(1e3 * result.nip_width, rel=5e-3)
    assert share == pytest.approx(66e-6 / result.nip_width, rel=5e-3)
    assert limit == 0.1


# ---- two rollers --------------------------------------------------------------------------------


def rollers(**changes: object) -> wo.RollerProblem:
    return wo.RollerProblem.example().replace(**changes)


def test_ordinary_rollers_earn_none() -> None:
    assert wo.solve(rollers()).warnings == ()
    assert wo.solve(rollers(motion="static")).warnings == ()


def test_rollers_that_are_pressed_and_driven_too_far() -> None:
    soft = wo.HalfPlane(radius=0.25, material=isotropic(1e6))
    result = wo.solve(
        rollers(upper=soft, load=3e4, tangential_load=None, creepage=0.15), nodes=NODES
    )
    width, share, _ = the(
        result, f"the half width {NUMBER} mm is {PERCENT} of the smaller radius "
        f"\\(limit {PERCENT}\\): .*",
    )  # fmt: skip
    assert share == pytest.approx(1e-3 * width / 0.25, rel=5e-3)
    peak, share, modulus, _ = the(
        result, f"the peak pressure {NUMBER} MPa is {PERCENT} of the upper's stiffness "
        f"{NUMBER} MPa \\(limit {PERCENT}\\): .*",
    )  # fmt: skip
    assert share == pytest.approx(peak / modulus, rel=1e-2)
    assert the(result, f"the rollers' surface speeds differ by {PERCENT} \\(limit 10%\\): .*") == [
        0.15
    ]


def test_a_layer_under_a_rigid_roller_takes_all_of_the_approach() -> None:
    soft = cover(0.002, isotropic(1e6))
    problem = rollers(upper=wo.Rigid(radius=0.25), lower=soft, load=1e4, tangential_load=100.0)
    result = wo.solve(problem)
    depth, _, _, _ = the(
        result, f"the lower's indentation {NUMBER} mm is {PERCENT} of its elastic layer, "
        f"{NUMBER} mm \\(limit {PERCENT}\\): strains are not small",
    )  # fmt: skip
    # the contact's middle is off the line of centres by the traction
    assert depth == pytest.approx(1e3 * result.approach, rel=0.01)


# ---- issued -------------------------------------------------------------------------------------


def issued(call: Callable[[], object]) -> list[warnings.WarningMessage]:
    """Return what is issued, all of it."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        call()
    return caught


SOLVES = {
    "solve": lambda: wo.solve(newsprint_nip(web_tension=1e5), nodes=13),
    "wrapped": lambda: wo.solve(newsprint_nip(web_tension=1e5, roll_wrap=np.pi), nodes=NODES),
    "rollers": lambda: wo.solve(rollers(tangential_load=None, creepage=0.2)),
}


@pytest.mark.parametrize("way", SOLVES)
def test_warnings_are_issued_once_at_the_users_line(way: str) -> None:
    result: list[wo.Result] = []
    output = issued(lambda: result.append(SOLVES[way]()))
    texts = [str(one.message) for one in output]
    assert texts == [text.removeprefix("resolution: ") for text in result[0].warnings]
    assert texts
    assert {one.filename for one in output} == {__file__}
    for one in output:
        of_grid = f"resolution: {one.message}" in result[0].warnings
        assert one.category is (wo.ResolutionWarning if of_grid else wo.ValidityWarning)


def test_every_limit_stands_in_the_documentation() -> None:
    page = (Path(__file__).parents[2] / "docs" / "howto" / "warnings.md").read_text("utf-8")
    rows = [line.split("|")[1:-1] for line in page.splitlines() if line.startswith("| ")]
    computed = {name.strip(): limit.strip() for name, limit, *_ in rows}
    for name, limit in validity.LIMITS.items():
        assert computed[name] == f"{100 * limit.maximum:g} %"
