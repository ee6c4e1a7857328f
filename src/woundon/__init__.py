"""Winding mechanics: the winding nip, the tension it adds, the stresses that stay in the roll."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

__version__ = "0.2.0.dev0"

_HOME = {
    "Air": "problems.air",
    "AirBetween": "problems.air_law",
    "AirFilm": "nip.entrained_air",
    "Body": "problems.bodies",
    "Comparison": "studies.compare",
    "Core": "problems.roll",
    "Cylinder": "problems.bodies",
    "DynamicTest": "problems.viscoelastic",
    "FindResult": "studies.find",
    "FitResult": "studies.fit",
    "Grade": "problems.grades",
    "HalfPlane": "problems.bodies",
    "InputWarning": "errors",
    "InvalidProblem": "errors",
    "Isotropic": "problems.materials",
    "Layer": "problems.bodies",
    "Layered": "problems.bodies",
    "Limits": "problems.limits",
    "LossAngle": "problems.viscoelastic",
    "Margin": "winding.margins",
    "Margins": "winding.margins",
    "Material": "problems.materials",
    "Measurement": "studies.planned",
    "NextExperiment": "studies.experiment",
    "NipProblem": "problems.nip",
    "NipResult": "nip.result",
    "NoSolution": "errors",
    "NoSteadyState": "errors",
    "NotConverged": "errors",
    "OperatingPoint": "studies.window",
    "OperatingWindow": "studies.window",
    "OptimisedSchedule": "studies.schedule",
    "Orthotropic": "problems.materials",
    "Pfeiffer": "problems.radial_laws",
    "Polynomial": "problems.radial_laws",
    "PowerLaw": "problems.radial_laws",
    "Problem": "problems.problem",
    "Profile": "problems.schedules",
    "PronyTerm": "problems.materials",
    "PullTab": "studies.pull_tab",
    "Quantity": "quantities",
    "Residuals": "results",
    "ResolutionWarning": "errors",
    "Result": "results",
    "Rigid": "problems.bodies",
    "RollerProblem": "problems.rollers",
    "RollerResult": "nip.roller_result",
    "Sensitivity": "nip.sensitivity",
    "SobolIndices": "studies.sobol",
    "Stack": "problems.stack",
    "StackTest": "problems.radial_laws",
    "Taper": "problems.schedules",
    "TensionDesign": "roll.design",
    "ValidityWarning": "errors",
    "Web": "problems.web",
    "WindingProblem": "problems.winding",
    "WindingResult": "winding.result",
    "WoundRoll": "problems.wound_roll",
    "RollProblem": "problems.roll",
    "RollResult": "roll.result",
    "Zone": "results",
    "compare": "studies.compare",
    "derivatives": "studies.derivatives",
    "design_tension": "roll.design",
    "find": "studies.find",
    "fit": "studies.api",
    "global_sensitivity": "studies.api",
    "grade": "problems.grades",
    "grades": "problems.grades",
    "kinds": "",
    "load_case": "io.case_files",
    "load_result": "io.result_files",
    "margins": "winding.margins",
    "material": "problems.materials",
    "next_experiment": "studies.experiment",
    "operating_window": "studies.window",
    "optimise_schedule": "studies.schedule",
    "plot": "show.plots",
    "solve": "kinds",
    "solve_table": "studies.case_table",
    "sweep": "studies.api",
    "theories": "",
    "units": "io.chosen_units",
}

# in full, for type checkers read no expression
__all__ = [
    "Air",
    "AirBetween",
    "AirFilm",
    "Body",
    "Comparison",
    "Core",
    "Cylinder",
    "DynamicTest",
    "FindResult",
    "FitResult",
    "Grade",
    "HalfPlane",
    "InputWarning",
    "InvalidProblem",
    "Isotropic",
    "Layer",
    "Layered",
    "Limits",
    "LossAngle",
    "Margin",
    "Margins",
    "Material",
    "Measurement",
    "NextExperiment",
    "NipProblem",
    "NipResult",
    "NoSolution",
    "NoSteadyState",
    "NotConverged",
    "OperatingPoint",
    "OperatingWindow",
    "OptimisedSchedule",
    "Orthotropic",
    "Pfeiffer",
    "Polynomial",
    "PowerLaw",
    "Problem",
    "Profile",
    "PronyTerm",
    "PullTab",
    "Quantity",
    "Residuals",
    "ResolutionWarning",
    "Result",
    "Rigid",
    "RollProblem",
    "RollResult",
    "RollerProblem",
    "RollerResult",
    "Sensitivity",
    "SobolIndices",
    "Stack",
    "StackTest",
    "Taper",
    "TensionDesign",
    "ValidityWarning",
    "Web",
    "WindingProblem",
    "WindingResult",
    "WoundRoll",
    "Zone",
    "__version__",
    "compare",
    "derivatives",
    "design_tension",
    "find",
    "fit",
    "global_sensitivity",
    "grade",
    "grades",
    "kinds",
    "load_case",
    "load_result",
    "margins",
    "material",
    "next_experiment",
    "operating_window",
    "optimise_schedule",
    "plot",
    "solve",
    "solve_table",
    "sweep",
    "theories",
    "units",
]  # fmt: skip

if TYPE_CHECKING:
    from . import kinds as kinds
    from . import theories as theories
    from .errors import InputWarning as InputWarning
    from .errors import InvalidProblem as InvalidProblem
    from .errors import NoSolution as NoSolution
    from .errors import NoSteadyState as NoSteadyState
    from .errors import NotConverged as NotConverged
    from .errors import ResolutionWarning as ResolutionWarning
    from .errors import ValidityWarning as ValidityWarning
    from .io.case_files import load_case as load_case
    from .io.chosen_units import units as units
    from .io.result_files import load_result as load_result
    from .kinds import solve as solve
    from .nip.entrained_air import AirFilm as AirFilm
    from .nip.result import NipResult as NipResult
    from .nip.roller_result import RollerResult as RollerResult
    from .nip.sensitivity import Sensitivity as Sensitivity
    from .problems.air import Air as Air
    from .problems.air_law import AirBetween as AirBetween
    from .problems.bodies import Body as Body
    from .problems.bodies import Cylinder as Cylinder
    from .problems.bodies import HalfPlane as HalfPlane
    from .problems.bodies import Layer as Layer
    from .problems.bodies import Layered as Layered
    from .problems.bodies import Rigid as Rigid
    from .problems.grades import Grade as Grade
    from .problems.grades import grade as grade
    from .problems.grades import grades as grades
    from .problems.limits import Limits as Limits
    from .problems.materials import Isotropic as Isotropic
    from .problems.materials import Material as Material
    from .problems.materials import Orthotropic as Orthotropic
    from .problems.materials import PronyTerm as PronyTerm
    from .problems.materials import material as material
    from .problems.nip import NipProblem as NipProblem
    from .problems.problem import Problem as Problem
    from .problems.radial_laws import Pfeiffer as Pfeiffer
    from .problems.radial_laws import Polynomial as Polynomial
    from .problems.radial_laws import PowerLaw as PowerLaw
    from .problems.radial_laws import StackTest as StackTest
    from .problems.roll import Core as Core
    from .problems.roll import RollProblem as RollProblem
    from .problems.rollers import RollerProblem as RollerProblem
    from .problems.schedules import Profile as Profile
    from .problems.schedules import Taper as Taper
    from .problems.stack import Stack as Stack
    from .problems.viscoelastic import DynamicTest as DynamicTest
    from .problems.viscoelastic import LossAngle as LossAngle
    from .problems.web import Web as Web
    from .problems.winding import WindingProblem as WindingProblem
    from .problems.wound_roll import WoundRoll as WoundRoll
    from .quantities import Quantity as Quantity
    from .results import Residuals as Residuals
    from .results import Result as Result
    from .results import Zone as Zone
    from .roll.design import TensionDesign as TensionDesign
    from .roll.design import design_tension as design_tension
    from .roll.result import RollResult as RollResult
    from .show.plots import plot as plot
    from .studies.api import fit as fit
    from .studies.api import global_sensitivity as global_sensitivity
    from .studies.api import sweep as sweep
    from .studies.case_table import solve_table as solve_table
    from .studies.compare import Comparison as Comparison
    from .studies.compare import compare as compare
    from .studies.derivatives import derivatives as derivatives
    from .studies.experiment import NextExperiment as NextExperiment
    from .studies.experiment import next_experiment as next_experiment
    from .studies.find import FindResult as FindResult
    from .studies.find import find as find
    from .studies.fit import FitResult as FitResult
    from .studies.planned import Measurement as Measurement
    from .studies.pull_tab import PullTab as PullTab
    from .studies.schedule import OptimisedSchedule as OptimisedSchedule
    from .studies.schedule import optimise_schedule as optimise_schedule
    from .studies.sobol import SobolIndices as SobolIndices
    from .studies.window import OperatingPoint as OperatingPoint
    from .studies.window import OperatingWindow as OperatingWindow
    from .studies.window import operating_window as operating_window
    from .winding.margins import Margin as Margin
    from .winding.margins import Margins as Margins
    from .winding.margins import margins as margins
    from .winding.result import WindingResult as WindingResult


if not TYPE_CHECKING:  # who would take any name for known

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
