"""Contacts many times as wide as a layer is thick, and what is refused beyond.

Smooth parts of influence functions are interpolated, and their hats' moments need enough points in
a cell; a wrap's long cells likewise.  Where that failed, stick and slip were not found.
"""

from __future__ import annotations

import re

import numpy as np
import pytest
from slow_cases import slow_case
from thesis_cases import newsprint_nip

import woundon as wo
from woundon.elasticity.mesh import Wrap, nip_mesh
from woundon.nip.load_limit import frictionless_pressure


def on_rigid_core(thickness: float, material: wo.Material, radius: float = 0.15) -> wo.Cylinder:
    return wo.Cylinder(radius=radius, core_radius=radius - thickness, material=material)


PAPER = wo.Orthotropic(radial=1.1e8, tangential=4.5e6, cross=1.5e5, shear=2e5)
RUBBER = wo.Isotropic(youngs_modulus=1e6, poissons_ratio=0.45)
LAYERS = {"paper": on_rigid_core(0.14e-3, PAPER), "rubber": on_rigid_core(0.26e-3, RUBBER)}


def frictionless_load(pair: wo.RollerProblem, nodes: int, a: float) -> float:
    """Return the load of a frictionless contact of half width ``a`` [N/m]."""
    face = nip_mesh(nodes, Wrap(), Wrap()).roll_face
    return float(a * face.weights @ frictionless_pressure(pair, face, a))


@pytest.mark.parametrize("name", [slow_case("paper"), "rubber"])
def test_coarse_meshes_carry_what_fine_ones_do(name: str) -> None:
    """17 nodes once carried half the load, or a negative one, where cells are longer than layers.

    A piecewise linear parabola of 17 nodes has 0.7 % less of it.
    """
    layer = LAYERS[name]
    pair = wo.RollerProblem(upper=wo.Rigid(radius=0.168), lower=layer, load=1.0, friction=0.0)
    for a in np.geomspace(0.5, 1.0, 3) * layer.max_half_width:
        coarse, fine = (frictionless_load(pair, n, a) for n in (17, 129))
        assert coarse == pytest.approx(fine, rel=0.01)


def test_ten_newsprint_loads_on_a_cover_of_a_quarter_millimetre() -> None:
    # a started mesh and a cold one differ by zones only: another width would show
    nip = newsprint_nip(drum=on_rigid_core(0.26e-3, RUBBER, 0.0762), nip_load=35020.0)
    result = wo.solve(nip, nodes=65)
    assert result.half_width > 30 * 0.26e-3
    finer = wo.solve(nip, nodes=129)
    assert result.half_width == pytest.approx(finer.half_width, rel=1e-3)
    assert any("the drum's indentation" in text for text in result.warnings)


@pytest.mark.parametrize("drum_wrap", [0.5, slow_case(3.0)])
def test_a_web_wrapped_on_a_thin_cover(drum_wrap: float) -> None:
    cover = on_rigid_core(0.19e-3, wo.Isotropic(youngs_modulus=8e5, poissons_ratio=0.33), 0.041)
    nip = newsprint_nip(drum=cover).replace(roll_wrap=np.pi, drum_wrap=drum_wrap)
    result, finer = (wo.solve(nip, nodes=nodes) for nodes in (33, 129))
    assert result.wound_on_tension == pytest.approx(finer.wound_on_tension, rel=0.01)


def test_a_contact_too_wide_to_be_resolved_is_rejected_with_what_to_change() -> None:
    nip = newsprint_nip(drum=on_rigid_core(0.04e-3, RUBBER, 0.0762), nip_load=1e5)
    text = (
        r"nip_load: 100000 is out of range; must be <= 1.*e\+04 .*the elastic layer of the drum, "
        "4e-05 m, is too thin for the contact of a larger load"
    )
    with pytest.raises(wo.InvalidProblem, match=text):
        wo.solve(nip)


def test_a_layer_whose_series_is_not_resolved_is_rejected() -> None:
    fibres = wo.Orthotropic(radial=2.5e9, tangential=1e6, cross=4e5, shear=5.0)
    text = ("roll: the response of its layer, 0.008 m thick, needs more than 262144 Fourier terms "
            r"(relative error ")  # fmt: skip
    with pytest.raises(wo.InvalidProblem, match=re.escape(text)) as fault:
        wo.solve(newsprint_nip(roll=on_rigid_core(0.008, fibres, 4.0)))
    assert "use a thicker layer or a material with less different stiffnesses" in str(fault)


# ---- webs far outside the model -----------------------------------------------------------------


@pytest.mark.parametrize("load", [1e-2, 1e-3, 1e-4])
def test_a_light_nip_of_a_taut_wrapped_web(load: float) -> None:
    """The web's own tension carries the load where it turns from roll to drum: P = 2 a T/R*.

    Rounding in its hoop pressure drowned the nip's.  The drum is rigid, the roll hardly gives.
    """
    result = wo.solve(newsprint_nip(nip_load=load).replace(roll_wrap=np.pi), nodes=33)
    turn = load * result.problem.contact_radius / (2 * 350.0)
    assert result.half_width == pytest.approx(turn, rel=0.8)
    assert result.residuals.largest <= 1e-8


def test_a_web_under_a_thousand_times_its_tension() -> None:
    result = wo.solve(newsprint_nip(web_tension=1e6).replace(roll_wrap=np.pi), nodes=33)
    assert result.residuals.largest <= 1e-8
    assert any("the web's strain is" in text for text in result.warnings)


def test_slips_are_known_to_the_rounding_of_the_webs_strain() -> None:
    """xi- holds the web's strain: of 1e7 no digit below 1e-9 is left in a difference."""
    soft = wo.Orthotropic(radial=2e7, tangential=1.0, cross=0.0, shear=1e7)
    result = wo.solve(newsprint_nip(**{"web.material": soft, "nip_load": 1e-3}), nodes=33)
    assert abs(result.drum_creepage) > 1e6
    assert result.residuals.largest <= 1e-8


def test_what_is_not_solved_says_how_far_outside_the_model_it_is() -> None:
    soft = wo.Orthotropic(radial=1.9e11, tangential=310.0, cross=2.5e6, shear=2.7e5)
    nip = wo.NipProblem(
        web=wo.Web(thickness=4.46e-6, material=soft),
        roll=wo.HalfPlane(radius=0.0078, material=soft),
        drum=wo.Rigid(radius=0.0067),
        roll_friction=0.00154, drum_friction=2.0,
        nip_load=520.0, winding_force=278.0, web_tension=0.4, roll_wrap=0.0,
    )  # fmt: skip
    with pytest.raises(wo.NotConverged) as fault:
        wo.solve(nip)
    message = re.search(r"this is far outside the model: tensions up to ([\d.e+]+) N/m .* stretch "
                     r"the web ([\d.e+]+) times its length; take smaller ones, or a thicker "
                     "or stiffer web", str(fault.value))  # fmt: skip
    assert message
    tension = 0.4 + 2.00154 * 520.0
    assert float(message[1]) == pytest.approx(tension, rel=5e-3)
    assert float(message[2]) == pytest.approx(
        tension / (4.46e-6 * (310.0 - 2.5e6**2 / 1.9e11)), rel=0.05
    )
