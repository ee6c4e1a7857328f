"""A study file of a nip, for the tests of the command line and of messages."""

from __future__ import annotations

from pathlib import Path

__all__ = ["nip_study"]


def nip_study(case: Path) -> str:
    """Return the text of a study of six nips around a case file."""
    return f"""
schema = 1
case = "{case.as_posix()}"
outputs = ["nip_induced_tension"]
[over]
nip_load = {{ from = "1 kN/m", to = "4 kN/m", count = 3 }}
winding_force = ["0 N/m", "300 N/m"]
[solver]
nodes = 17
"""
