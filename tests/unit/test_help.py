"""Editors, type checkers, help() and dir() show public names, fields, units and types."""

from __future__ import annotations

import inspect
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from pydantic import BaseModel

import woundon as wo
from woundon import kinds, quantities

SOURCE = Path(wo.__file__).parents[1]
PROBLEMS = [kind.problem for kind in kinds.every()]
DESCRIPTIONS = [
    *PROBLEMS,
    wo.Web,
    wo.Cylinder,
    wo.HalfPlane,
    wo.Rigid,
    wo.Orthotropic,
    wo.Isotropic,
]
PYDANTICS = {name for name in dir(BaseModel) if not name.startswith("_")}

SCRIPT = """
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import woundon as wo

web = wo.Web(thickness=66e-6, material="newsprint")
roll = wo.Cylinder(radius=0.1, core_radius=0.0445, material=wo.material("newsprint"))
steel = wo.HalfPlane(radius=0.25, material={"youngs_modulus": 206e9, "poissons_ratio": 0.3})
problem = wo.NipProblem(
    web=web, roll=roll, drum=wo.Rigid(radius=0.0762), roll_friction=0.19, drum_friction=0.2,
    nip_load=3502, web_tension=350.0,
)
other = problem.replace(nip_load=2e3, **{"web.thickness": 57e-6})
by_table = wo.NipProblem(
    web=web, roll=roll, drum={"kind": "rigid", "radius": 0.1}, roll_friction=0.2, drum_friction=0.2,
    nip_load=np.float64(3e3),
)
shear: float = other.web.material.stiffness.shear
radius: float = by_table.drum.radius


def report(result: wo.NipResult, path: Path) -> str:
    result.save(path)
    result.plot(path.with_suffix(".png"))
    figure, axes = plt.subplots()
    result.plot(ax=axes, panels="tractions").set_title("mine")
    result.plot(panels=["slips", "zones"]).savefig("two.png")
    return f"{result}: {result.nip_width:.3g}"


nip = wo.solve(problem, nodes=33)
text: str = report(nip, Path("nip.nc"))
tension: float = nip.outlet_tension + nip.error("outlet_tension")
peak = float(np.max(nip.drum_pressure))
load: float = nip.problem.nip_load
wrapped = wo.solve(problem.replace(roll_wrap=1.0))
wound_on: float = wrapped.wound_on_tension
pair = wo.RollerProblem(upper=steel, lower=steel, load=89e3, friction=0.5)
share: float = wo.solve(pair).slip_share
wo.plot([nip, wo.solve(other)], labels=["one", "other"]).set_size_inches(5, 5)
slopes: wo.Sensitivity = nip.sensitivity("nip_load")
over = {"nip_load": [1e3, 2e3], "web.material": ["paper", "newsprint"]}
table = wo.sweep(problem, over, nodes=33)
highest = float(table["nip_induced_tension"].max())
fit: wo.FitResult = wo.fit(problem, {"half_width [mm]": [2.5]}, ["roll.material.shear"])
value: float = fit.estimate("roll.material.shear")
shares: wo.SobolIndices = wo.global_sensitivity(problem, {"nip_load": (1e3, 2e3)}, samples=8)
loaded = wo.load_result("nip.nc")
try:
    wo.solve(wo.load_case("case.toml"))
except (wo.InvalidProblem, wo.NotConverged) as fault:
    print(fault)
"""
WRONG = """
import woundon as wo

wo.Web(thickness="66 um", material="newsprint")
wo.Web(thickness=66e-6, material=3.0)
wo.Web(thickness=66e-6)
wo.solve(3.0)
wo.solve(wo.NipProblem.example()).half_widht
wo.no_such_name
"""


def checked(script: str, folder: Path) -> str:
    """Return what mypy says of a user's script, without any settings of this project."""
    pytest.importorskip("mypy")
    (folder / "script.py").write_text(script, encoding="utf-8")
    (folder / "mypy.ini").write_text("[mypy]\n", encoding="utf-8")
    command = [sys.executable, "-m", "mypy", "--strict", "--follow-imports=silent", "script.py"]
    env = {**os.environ, "MYPYPATH": str(SOURCE), "MYPY_CACHE_DIR": str(folder / "cache")}
    run = subprocess.run(command, cwd=folder, env=env, capture_output=True, text=True, timeout=600)
    return run.stdout + run.stderr


@pytest.mark.campaign
def test_a_strictly_typed_script_is_clean_and_a_wrong_one_is_not(tmp_path: Path) -> None:
    assert checked(SCRIPT, tmp_path).startswith("Success")
    estimate = checked(WRONG, tmp_path)
    lines = [int(line) for line in re.findall(r"script.py:(\d+): error", estimate)]
    assert lines == [5, 6, 7, 8, 9], estimate


# ---- public names


def test_public_names_are_the_same_for_type_checkers_and_at_run_time() -> None:
    stub = Path(wo.__file__).with_name("__init__.pyi").read_text(encoding="utf-8")
    listed = re.findall(r"import (\w+) as \1$", stub, re.M)
    assert sorted(listed) == sorted(set(wo.__all__) - {"__version__"})
    assert set(listed) <= set(dir(wo))
    assert all(hasattr(wo, name) for name in listed)
    assert (SOURCE / "woundon" / "py.typed").exists()


@pytest.mark.parametrize("cls", DESCRIPTIONS)
def test_only_public_names_are_offered(cls: type[Any]) -> None:
    known = set(dir(cls))
    assert {"replace"} <= known
    assert not known & PYDANTICS
    assert not [name for name in known if name.startswith(("_", "model_"))]


# ---- help


@pytest.mark.parametrize("cls", DESCRIPTIONS)
def test_help_has_every_field_with_symbol_unit_and_range(cls: type[Any]) -> None:
    table = " ".join(cls.__doc__.partition("Fields, SI units::\n\n")[2].split())
    assert list(inspect.signature(cls).parameters) == list(cls.model_fields)
    for name, field in cls.model_fields.items():
        quantity = quantities.quantity_of(field)
        assert f"{name} " in table
        if quantity is not None:
            assert f"{name} {quantity.symbol}, {quantity.meaning}: " in table
            assert quantity.unit == "1" or f"[{quantity.unit}]" in table
    for place in (p for p in quantities.walk(cls) if p.owner is cls and p.quantity):
        for bound in (getattr(part, "le", None) for part in place.field.metadata):
            assert bound is None or f"<= {bound:.6g}" in table
