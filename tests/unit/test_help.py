"""Editors, type checkers, help() and dir() show public names, fields, units and types."""

from __future__ import annotations

import inspect
import re
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
