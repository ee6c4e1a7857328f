"""Sweeps of nips by the procedure of the thesis: its own values, in the order of the parameters."""

from __future__ import annotations

import pytest

import woundon as wo
from woundon.jorkama2001 import nips, procedure
from woundon.jorkama2001.cases import paper_nip
from woundon.jorkama2001.nips import swept
from woundon.jorkama2001.zones import zone_lengths


@pytest.fixture(autouse=True)
def coarse(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(nips, "THESIS_NODES", 25)


def test_a_sweep_has_the_values_of_the_procedure() -> None:
    over = {"winding_force": [100.0, -200.0], "shear": [10e6, 5e6]}
    data = swept(paper_nip(), over, "thesis", ["nip_induced_tension", "dual_slip"])
    assert data["nip_induced_tension"].dims == ("winding_force", "shear")
    assert data["winding_force"].values.tolist() == over["winding_force"]  # not sorted
    paper = wo.material("paper").replace(shear=5e6)  # of roll and web
    problem = paper_nip(winding_force=-200.0, **{"roll.material": paper, "web.material": paper})
    nip = procedure.solve(problem, 25)
    last = data.isel(winding_force=1, shear=1)
    assert last["nip_induced_tension"] == nip.nip_induced_tension
    assert last["dual_slip"] == zone_lengths(nip).dual
    units = {name: of.attrs["units"] for name, of in data.variables.items()}
    assert units == {
        "winding_force": "N/m", "shear": "Pa", "nip_induced_tension": "N/m", "dual_slip": "1",
    }  # fmt: skip


def test_a_nip_that_cannot_be_solved_ends_a_sweep() -> None:
    with pytest.raises(wo.NotConverged, match="winding_force"):
        swept(paper_nip(), {"winding_force": [100.0, 2000.0]}, "thesis", ["nip_induced_tension"])
