"""Units of choice: in reports, figures and tables, and nowhere else."""

from __future__ import annotations

from pathlib import Path

import pytest
from thesis_cases import newsprint_nip

import woundon as wo
from woundon.problems.paths import field_quantity
from woundon.quantities import output


@pytest.fixture(scope="module")
def nip():
    return wo.solve(newsprint_nip(), nodes=33)


def test_choices_nest_and_are_taken_back():
    with wo.units(nip_load="kN/m"):
        with wo.units(half_width="um"):
            assert field_quantity(wo.NipProblem, "nip_load").display == "kN/m"
            assert output(wo.NipResult, "half_width").quantity.display == "um"
        assert output(wo.NipResult, "half_width").quantity.display == "mm"
    assert field_quantity(wo.NipProblem, "nip_load").display == "N/m"


@pytest.mark.parametrize(
    ("chosen", "more", "field"),
    [("mill", {}, "chosen"), ({3: "um"}, {}, "chosen"), (None, {"half_width": 3}, "half_width")],
)
def test_what_is_no_choice_of_units_is_rejected(chosen, more, field: str):
    with pytest.raises(wo.InvalidProblem, match=f"^{field}: .* must be"), wo.units(chosen, **more):
        pass


def test_files_for_programs_stay_si(nip, tmp_path: Path):
    with wo.units(nip_load="kN/m", half_width="um"):
        nip.save(tmp_path / "nip.json")
        assert nip.to_xarray().half_width.attrs["units"] == "m"
    assert wo.load_result(tmp_path / "nip.json") == nip
