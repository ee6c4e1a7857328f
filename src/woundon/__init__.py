"""Winding mechanics: the winding nip, the tension it adds, the stresses that stay in the roll."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

_HOME = {
    "Cylinder": "bodies",
    "HalfPlane": "bodies",
    "InvalidProblem": "errors",
    "Isotropic": "materials",
    "NipProblem": "problems",
    "NipResult": "results",
    "NoSteadyState": "errors",
    "NotConverged": "errors",
    "Orthotropic": "materials",
    "Rigid": "bodies",
    "RollerProblem": "problems",
    "RollerResult": "results",
    "ValidityWarning": "errors",
    "Web": "problems",
    "WrappedNipResult": "wrap",
    "Zone": "results",
    "fit": "studies.nip",
    "global_sensitivity": "studies.nip",
    "load_case": "casefile",
    "load_result": "casefile",
    "material": "materials",
    "solve_nip": "nip",
    "solve_rollers": "rollers",
    "solve_wrapped_nip": "wrap",
    "sweep": "studies.nip",
    "theories": "",
}

__all__ = ["__version__", *sorted(_HOME)]

if TYPE_CHECKING:
    from . import theories
    from .bodies import Cylinder, HalfPlane, Rigid
    from .casefile import load_case, load_result
    from .errors import InvalidProblem, NoSteadyState, NotConverged, ValidityWarning
    from .materials import Isotropic, Orthotropic, material
    from .nip import solve_nip
    from .problems import NipProblem, RollerProblem, Web
    from .results import NipResult, RollerResult, Zone
    from .rollers import solve_rollers
    from .studies.nip import fit, global_sensitivity, sweep
    from .wrap import WrappedNipResult, solve_wrapped_nip


def __getattr__(name: str) -> Any:
    # names are fetched when first used: `import woundon` costs next to nothing
    if name not in _HOME:
        raise AttributeError(f"module 'woundon' has no attribute {name!r}")
    home = _HOME[name]
    module = import_module(f".{home or name}", __name__)
    value = getattr(module, name) if home else module
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return __all__
