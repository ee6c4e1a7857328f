"""Solve the golden cases with version 0.2 on fine meshes and write them as JSON.

    python benchmarks/version_0_2.py tests/golden/make.py                all families
    python benchmarks/version_0_2.py tests/golden/make.py rollers air    some of them
    python benchmarks/version_0_2.py tests/golden/make.py --list         names only

Each family has a file ``<family>.json`` next to this script: the commit, the versions of the
packages, and a list of cases with the entries

name, origin
    Text; the function and the seed that drew a random case.
problem
    ``{"type": ..., ...}``: the fields of the problem in SI units.  Each object has a ``type``, the
    snake-case name of its class, except a term of a Prony series, which is a pair (E_k, tau_k).
    A field that holds no number is left out where it has its default value.  All nips have the
    type ``nip_problem`` with the fields ``roll_wrap`` (0.0: the web is held at the trailing edge),
    ``drum_wrap``, ``wrap_friction`` and ``air``.
solver_options, coarser_solver_options
    How the case was solved, on the fine mesh and on one half as fine.
seconds, largest_residual
    The processor time of both solutions; the largest residual of the fine one.
outputs
    By name ``[value, error, change]``: the value, the error estimate of version 0.2 (null where it
    has none), and the value less that on the coarser mesh (null where only one mesh has it), in SI
    units.  Version 0.2 extrapolates the tensions, so that the change is not always smaller than the
    error estimate.
samples
    ``x_over_a`` and the arrays interpolated there, each as ``[values, changes]``; of rolls and
    windings at ``share_of_radius``, 0 at the core and 1 at the surface.
wrap_samples
    The same at angles [rad] downstream of the trailing edge of the nip.
reference
    Values of independent programs and closed forms: output, value, tolerance (the uncertainty of
    the value, absolute), source.  The two independent programs for nips state no errors; their
    tolerances are the largest differences found, rounded up.
rejected
    ``[exception, message]`` in place of all results, where version 0.2 rejects the case.

The outputs of nips have these names and definitions:

inlet_tension, outlet_tension       T at the leading and at the trailing edge of the nip
edge_to_edge_tension_rise           their difference; ``nip_induced_tension`` of version 0.2
wound_on_tension                    T at the end of the roll wrap; T_out without a roll wrap
nip_induced_tension                 wound_on_tension - T_in
drum_creepage                       ``drum_creep`` of version 0.2

All other outputs have the names of version 0.2.
"""

from __future__ import annotations

import argparse
import json
import platform
import re
import subprocess
import sys
import time
import warnings
from collections.abc import Callable, Iterator, Mapping
from functools import cache
from math import isfinite, pi
from pathlib import Path
from typing import Any, NamedTuple

import air
import hardening
import layered
import numpy as np
import random_nips
import rolls
import scipy
import viscoelastic
import wide
import windings

import woundon as wo
from woundon import theories
from woundon.problems.description import Description
from woundon.problems.materials import PronyTerm
from woundon.quantities import scalar_outputs

FOLDER = Path(__file__).parent
X_OVER_A = (-1.0, -0.95, -0.8, -0.6, -0.4, -0.2, 0.0, 0.2, 0.4, 0.6, 0.8, 0.95, 1.0)
ANGLES = (0.0, 0.05, 0.1, 0.3, 0.6, 1.0, 1.5, 2.0, 2.5, 3.0)
R_SHARES = (0.0, 0.02, 0.1, 0.25, 0.5, 0.75, 0.9, 0.98, 1.0)  # of the way from core to surface
# how a result was computed, and copies of other outputs
NOT_OUTPUTS = {
    "iterations", "series_terms", "series_error", "residual", "extrapolation", "nodes", "roll_rtol",
    "extrapolation_behind", "extrapolation_of_nip", "nip_residual", "agreed", "nips_solved",
    "traction_error", "wound_on_tension_error", "nip_induced_tension_error", "nip_width", "steps",
    "wound_on_tension_estimate", "surface_slope", "interpolation_error", "core_interpolation_error",
}  # fmt: skip
RENAMED = {
    "tension_before_nip": "inlet_tension",
    "tension_behind_nip": "outlet_tension",
    "drum_creep": "drum_creepage",
}


class Reference(NamedTuple):
    """A value of an independent program or of a closed form; the tolerance is absolute."""

    output: str
    value: float
    tolerance: float
    source: str


class Case(NamedTuple):
    """A case to be solved; ``fine`` and ``coarse`` are options of the solver."""

    name: str
    problem: Any
    reference: tuple[Reference, ...] = ()
    origin: str = ""
    fine: Mapping[str, Any] | None = None
    coarse: Mapping[str, Any] | None = None


# ---- problems as plain data ----------------------------------------------------------------------


def snake_case(name: str) -> str:
    """Return the snake-case form of the name of a class."""
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name).lower()


def plain(value: Any) -> Any:
    """Return a problem, or a part of it, as JSON data."""
    if isinstance(value, PronyTerm):
        return list(vars(value).values())[:2]
    if isinstance(value, tuple | list):
        return [plain(item) for item in value]
    if not isinstance(value, Description):
        return value
    found: dict[str, Any] = {"type": snake_case(type(value).__name__)}
    for name, field in type(value).model_fields.items():
        part = getattr(value, name)
        is_number = isinstance(part, int | float) and not isinstance(part, bool)
        if is_number or part != field.get_default():
            found[name] = plain(part)
    return found


def plain_problem(problem: Any) -> dict[str, Any]:
    """Return a problem as JSON data, with one type for all nips."""
    found: dict[str, Any] = plain(problem)
    if isinstance(problem, wo.NipProblem | wo.WrappedNipProblem | wo.AirNipProblem):
        found["type"] = "nip_problem"
        found.setdefault("roll_wrap", 0.0)
        found.setdefault("drum_wrap", 0.0)
    return found


# ---- results as plain data -----------------------------------------------------------------------


def outputs(result: Any) -> dict[str, tuple[float, float | None]]:
    """Return the scalar outputs of a result and their error estimates."""
    found: dict[str, tuple[float, float | None]] = {}
    for name in scalar_outputs(result):
        if name in NOT_OUTPUTS:
            continue
        try:
            value = getattr(result, name)
        except AttributeError:
            continue
        if isinstance(value, int | float) and isfinite(value):
            found[RENAMED.get(name, name)] = float(value), error(result, name)
    problem = result.problem
    if "nip_induced_tension" in found and "web_tension" in type(problem).model_fields:
        found["edge_to_edge_tension_rise"] = found["nip_induced_tension"]
        if isinstance(problem, wo.NipProblem):
            found["wound_on_tension"] = found["outlet_tension"]
            found["inlet_tension"] = problem.web_tension, 0.0
        WOT, estimate = found["wound_on_tension"]
        found["nip_induced_tension"] = WOT - problem.web_tension, estimate
    return dict(sorted(found.items()))


def error(result: Any, name: str) -> float | None:
    """Return the error estimate of an output, None where there is none."""
    estimate = result.errors.get(name)
    return None if estimate is None or not isfinite(estimate) else float(estimate)


def nip_samples(result: Any) -> dict[str, Any]:
    """Return the arrays of a nip at ``X_OVER_A``."""
    own = result.in_nip
    names = {
        "drum_pressure": result.pressure,
        "roll_pressure": getattr(result, "roll_pressure", result.pressure),
        "roll_traction": result.roll_traction,
        "drum_traction": result.drum_traction,
        "tension": result.web_tension,
    }
    x = result.x[own] / result.half_width
    return {name: np.interp(X_OVER_A, x, values[own]) for name, values in names.items()}


def roller_samples(result: Any) -> dict[str, Any]:
    """Return the arrays of two rollers at ``X_OVER_A``."""
    x = result.x / result.half_width
    return {
        name: np.interp(X_OVER_A, x, getattr(result, name)) for name in ("pressure", "traction")
    }


def wrap_samples(result: Any) -> dict[str, Any]:
    """Return the arrays of the roll wrap at ``ANGLES``."""
    first = result.in_nip.stop - 1
    angle = (result.x[first:] - result.half_width) / result.problem.roll.radius
    names = ("web_tension", "roll_pressure", "roll_traction", "curvature")
    found = {name: np.interp(angles(result), angle, getattr(result, name)[first:])
             for name in names}  # fmt: skip
    found["tension"] = found.pop("web_tension")
    # the strain is known at one point in each cell
    points = (result.slip_x[first + 1 :] - result.half_width) / result.problem.roll.radius
    found["roll_strain"] = np.interp(angles(result), points, result.roll_strain[first + 1 :])
    return found


def angles(result: Any) -> list[float]:
    """Return the sampled angles that lie on the roll wrap."""
    return [angle for angle in ANGLES if angle < result.problem.roll_wrap - 1e-9]


def roll_samples(result: Any) -> dict[str, Any]:
    """Return the arrays of a wound roll, or of the roll of a winding, at ``R_SHARES``."""
    roll = result.roll if isinstance(result, wo.WindingResult) else result
    core, R = roll.radius[0], roll.radius[-1]
    r = core + np.array(R_SHARES) * (R - core)
    at = roll.at_radius(r)
    found = {name: at[name] for name in ("pressure", "hoop_stress")}
    if isinstance(result, wo.WindingResult):
        for name in ("wound_on_tension", "nip_induced_tension"):
            found[name] = np.interp(r, result.radius, getattr(result, name))
    return found


def sampled(fine: Any, coarse: Any) -> dict[str, Any]:
    """Return the sampled arrays of a result and of the coarser one."""

    def pairs(sample: Callable[[Any], dict[str, Any]], **axis: Any) -> dict[str, Any]:
        one, two = sample(fine), sample(coarse)
        return axis | {
            name: [digits(one[name], 8), digits(one[name] - two[name], 2)] for name in one
        }

    if isinstance(fine, wo.NipResult):
        return {"samples": pairs(nip_samples, x_over_a=X_OVER_A)}
    if isinstance(fine, wo.WrappedNipResult):
        found = {"samples": pairs(nip_samples, x_over_a=X_OVER_A)}
        if fine.problem.roll_wrap > 0:
            found["wrap_samples"] = pairs(wrap_samples, angle=angles(fine))
        return found
    if isinstance(fine, wo.RollerResult):
        return {"samples": pairs(roller_samples, x_over_a=X_OVER_A)}
    if isinstance(fine, wo.WoundRollResult | wo.WindingResult):
        return {"samples": pairs(roll_samples, share_of_radius=R_SHARES)}
    return {}


def digits(values: Any, count: int) -> list[float]:
    """Return numbers with so many significant digits."""
    return [float(f"{value:.{count}g}") for value in values]


def output_entry(value: float, estimate: float | None, coarser: float | None) -> list[Any]:
    """Return an output as value, error estimate and change from the coarser mesh."""
    change = None if coarser is None else value - coarser
    parts = ((value, 12), (estimate, 4), (change, 3))
    return [None if part is None else float(f"{part:.{count}g}") for part, count in parts]


# ---- solving -------------------------------------------------------------------------------------


def options(case: Case) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the options of the fine and of the coarser solution."""
    problem = case.problem
    if case.fine is not None and case.coarse is not None:
        return dict(case.fine), dict(case.coarse)
    if isinstance(problem, wo.WoundRollProblem):
        return {"rtol": 1e-5}, {"rtol": 1e-4}
    if isinstance(problem, wo.WindingProblem):
        return {"nodes": 129, "rtol": 3e-4}, {"nodes": 65, "rtol": 1e-3}
    linear = getattr(problem, "linear", True)
    fine = 1025 if isinstance(problem, wo.RollerProblem) else 513
    fine = fine if linear else 129
    return {"nodes": fine}, {"nodes": (fine + 1) // 2}


def solved(case: Case) -> dict[str, Any]:
    """Solve a case; return its entry."""
    entry: dict[str, Any] = {"name": case.name}
    if case.origin:
        entry["origin"] = case.origin
    entry["problem"] = plain_problem(case.problem)
    if case.reference:
        entry["reference"] = [reference._asdict() for reference in case.reference]
    fine, coarse = options(case)
    start = time.process_time()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            one, two = wo.solve(case.problem, **fine), wo.solve(case.problem, **coarse)
    except (wo.InvalidProblem, wo.NotConverged) as fault:
        entry["rejected"] = [type(fault).__name__, str(fault)]
        entry["seconds"] = round(time.process_time() - start, 2)
        return entry
    entry["solver_options"], entry["coarser_solver_options"] = fine, coarse
    entry["seconds"] = round(time.process_time() - start, 2)
    entry["largest_residual"] = float(f"{one.residual:.2g}")
    coarser = outputs(two)
    entry["outputs"] = {
        name: output_entry(*found, coarser.get(name, (None,))[0])
        for name, found in outputs(one).items()
    }
    return entry | sampled(one, two)


# ---- the cases -----------------------------------------------------------------------------------

PAPER = wo.material("paper")
NEWSPRINT = wo.material("newsprint")
STEEL = wo.material("steel")
RUBBER = wo.Isotropic(youngs_modulus=5e6, poissons_ratio=0.45, prony=[(3e6, 1e-3), (2e6, 1e-2)])
TABLE_2 = wo.NipProblem.example()  # the nip of the README: newsprint on a hard drum
TABLE_1 = wo.NipProblem(
    web=wo.Web(thickness=66e-6, material=PAPER),
    roll=wo.Cylinder(radius=0.3, core_radius=0.05, material=PAPER), drum=wo.Rigid(radius=0.5),
    roll_friction=0.2, drum_friction=0.4, nip_load=1900.0, winding_force=100.0, web_tension=500.0,
)  # fmt: skip
HALF_PLANE = wo.HalfPlane(radius=0.3, material=PAPER)
INDEPENDENT = "an independent program: own graded mesh, term-by-term sums of the series"
WRAP_PROGRAM = "a second, independent program, with and without the web wrapped on the roll"


def cover(thickness: float, E: float, nu: float, radius: float = 0.5, **more: Any) -> wo.Cylinder:
    """Return a drum cover on a rigid core."""
    material = wo.Isotropic(youngs_modulus=E, poissons_ratio=nu, **more)
    return wo.Cylinder(radius=radius, core_radius=radius - thickness, material=material)


def published(half_width_mm: float, rise: float) -> tuple[Reference, ...]:
    """Return values of the independent program; its series end after a finite number of terms."""
    a = half_width_mm * 1e-3
    return (
        Reference("edge_to_edge_tension_rise", rise, 5e-4 * abs(rise), INDEPENDENT),
        Reference("half_width", a, 5e-5 * a, INDEPENDENT),
    )


def wrapped_published(rise: float, added: float) -> tuple[Reference, ...]:
    """Return values of the second program, printed with one decimal."""
    return (
        # its tension rises steeply at the trailing edge
        Reference("edge_to_edge_tension_rise", rise, 0.5, WRAP_PROGRAM),
        Reference("nip_induced_tension", added, 0.1, WRAP_PROGRAM),
    )


def drawn(
    draw: Callable[[int], Any], seeds: Any, of: str, name: str, keep: Callable[[Any], bool] = bool
) -> Iterator[Case]:
    """Yield random cases; seeds whose problem is inadmissible, or not to be kept, are left out."""
    for seed in seeds:
        try:
            problem = draw(seed)
        except wo.InvalidProblem:
            continue
        if keep(problem):
            origin = f"benchmarks/{of} of version 0.2, {draw.__name__}({seed})"
            yield Case(f"{name}, seed {seed}", problem, origin=origin)


def plain_nips() -> Iterator[Case]:
    """Yield nips without wraps."""
    yield Case("Table 2 (README)", TABLE_2, published(2.5144, 259.15))
    yield Case("Table 1", TABLE_1)
    yield Case("Table 1, half-plane roll", TABLE_1.replace(roll=HALF_PLANE),
               published(4.1581, 134.755))  # fmt: skip
    yield Case("Table 1, heavy load", TABLE_1.replace(nip_load=4897.0), published(6.5970, 212.85))
    yield Case("Table 1, driven drum", TABLE_1.replace(nip_load=1910.0, winding_force=-400.0),
               published(4.1643, -37.31))  # fmt: skip
    yield Case(
        "Table 1, full slip on the roll", TABLE_1.replace(nip_load=1500.0, winding_force=-500.0),
        (Reference("edge_to_edge_tension_rise", -200.0, 1e-5, "closed form mu+ P + F"),),
    )  # fmt: skip
    yield Case("Table 1, short stick zone", TABLE_1.replace(nip_load=11e3))
    yield Case("Table 2, light load", TABLE_2.replace(nip_load=10.0))
    yield Case("Table 2, slack web", TABLE_2.replace(web_tension=0.0))
    yield Case("Table 2, surface winding", TABLE_2.replace(winding_force=-350.0))
    paper = TABLE_1.replace(web_tension=300.0)
    heavy = {"nip_load": 10e3, "winding_force": -2000.0, "web_tension": 2500.0}
    for name, changes, rise in (
        ("Table 1, T_in 300", {}, 135.3),
        ("Table 1, T_in 300, F 0", {"winding_force": 0.0}, 111.9),
        ("Table 1, F 0, mu+ 0.05", {"winding_force": 0.0, "roll_friction": 0.05}, 86.2),
        ("Table 1, F 0, mu+ 1", {"winding_force": 0.0, "roll_friction": 1.0}, 26.2),
        ("Table 1, heavy, taut and driven", heavy, -92.5),
    ):
        reference = Reference("edge_to_edge_tension_rise", rise, 0.3, WRAP_PROGRAM)
        yield Case(name, paper.replace(**changes), (reference,))
    yield from drawn(random_nips.random_nip, range(12), "random_nips.py", "random nip")


def covers() -> Iterator[Case]:
    """Yield nips on covered and elastic drums, without wraps."""
    yield Case("Table 1, cover 20 mm", TABLE_1.replace(drum=cover(0.02, 10e6, 0.1)),
               (Reference("half_width", 7.4423e-3, 1.5e-6, INDEPENDENT),
                Reference("edge_to_edge_tension_rise", 32.4856, 0.005,
                          "version 0.2 with 1025 nodes and complete series")))  # fmt: skip
    yield Case("Table 1, soft rubber cover", TABLE_1.replace(drum=cover(0.02, 1e6, 0.499)))
    yield Case("Table 1, cellular cover", TABLE_1.replace(drum=cover(0.02, 1e6, 0.1)))
    yield Case("Table 1, thin cover", TABLE_1.replace(drum=cover(0.002, 50e6, 0.46)))
    yield Case("Table 1, steel half-plane drum",
               TABLE_1.replace(drum=wo.HalfPlane(radius=0.5, material=STEEL)))  # fmt: skip
    yield Case("Table 2, cover of 0.26 mm, wide nip", TABLE_2.replace(
        drum=cover(0.26e-3, 1e6, 0.45, 0.0762), nip_load=35020.0))  # fmt: skip


def wrapped_nips() -> Iterator[Case]:
    """Yield nips with the web wrapped on the roll."""
    paper = TABLE_1.replace(web_tension=300.0)
    yield Case("Table 2 (README), half a turn", TABLE_2.wrapped(), wrapped_published(328.9, 350.0))
    for load in (350.0, 876.0, 1751.0, 5837.0):
        yield Case(f"Table 2, P {load:g} N/m", TABLE_2.replace(nip_load=load).wrapped())
    yield Case("Table 2, load cell at a quarter turn", TABLE_2.wrapped(roll_wrap=pi / 2))
    yield Case("Table 2, short wrap", TABLE_2.wrapped(roll_wrap=0.1))
    yield Case("Table 2, other friction on the wrap", TABLE_2.wrapped(wrap_friction=0.4))
    yield Case("Table 2, board of 300 um", TABLE_2.wrapped().replace(**{"web.thickness": 300e-6}))
    yield Case("Table 1, F 100", paper.wrapped(), wrapped_published(160.2, 166.4))
    yield Case("Table 1, F 0", paper.replace(winding_force=0.0).wrapped(),
               wrapped_published(139.6, 147.5))  # fmt: skip
    for mu, rise, added in ((0.05, 88.0, 89.7), (1.0, 100.4, 123.5)):
        low = paper.replace(winding_force=0.0, roll_friction=mu)
        yield Case(f"Table 1, F 0, mu+ {mu:g}", low.wrapped(), wrapped_published(rise, added))
    heavy = paper.replace(nip_load=10e3, winding_force=-2000.0, web_tension=2500.0)
    yield Case("Table 1, heavy, taut and driven", heavy.wrapped(), wrapped_published(-69.1, -2.7))
    yield Case("Table 1, half-plane roll", paper.replace(roll=HALF_PLANE).wrapped())
    yield Case("Table 1, cover 20 mm", paper.replace(drum=cover(0.02, 10e6, 0.1)).wrapped())
    yield Case("Table 1, thin cover", paper.replace(drum=cover(0.002, 50e6, 0.46)).wrapped())
    yield from drawn(random_nips.random_wrapped_nip, range(0, 14, 2), "random_nips.py",
                     "random nip, roll wrap")  # fmt: skip


def drum_wraps() -> Iterator[Case]:
    """Yield nips with the web wrapped on the drum, with and without a wrap on the roll."""
    for angle in (0.3, pi / 2, pi):
        yield Case(f"Table 2, drum wrap {angle:.3g}, half a turn on the roll",
                   TABLE_2.wrapped(drum_wrap=angle))  # fmt: skip
    yield Case("Table 2, drum wrap alone", TABLE_2.wrapped(roll_wrap=0.0, drum_wrap=pi / 2))
    taut = TABLE_1.replace(web_tension=1000.0).wrapped(drum_wrap=pi / 2, winding_force=-900.0)
    yield Case("Table 1, force beyond the nip's friction", taut)
    soft = TABLE_1.replace(drum=cover(0.02, 10e6, 0.1))
    yield Case("Table 1, cover 20 mm, both wraps", soft.wrapped(drum_wrap=1.0))
    yield Case("Table 1, cover 20 mm, drum wrap alone",
               soft.wrapped(roll_wrap=0.0, drum_wrap=1.0))  # fmt: skip
    yield from drawn(random_nips.random_wrapped_nip, range(1, 15, 2), "random_nips.py",
                     "random nip, both wraps")  # fmt: skip


def low_friction() -> Iterator[Case]:
    """Yield nips with friction of 1e-6 to 1e-2 on one face or on both."""
    for mu in (1e-6, 1e-4, 1e-2):
        yield Case(f"Table 2, mu+ {mu:g}", TABLE_2.replace(roll_friction=mu))
        yield Case(f"Table 2, mu- {mu:g}", TABLE_2.replace(drum_friction=mu))
    both = TABLE_1.replace(roll_friction=1e-3, drum_friction=1e-4, winding_force=0.1)
    yield Case("Table 1, both faces", both)
    yield Case("Table 1, both faces, cover 20 mm", both.replace(drum=cover(0.02, 10e6, 0.1)))
    yield Case("Table 2, mu+ 1e-3, half a turn", TABLE_2.replace(roll_friction=1e-3).wrapped())
    yield Case("Table 2, mu- 1e-4, both wraps",
               TABLE_2.replace(drum_friction=1e-4).wrapped(drum_wrap=1.0))  # fmt: skip


def layered_bodies() -> Iterator[Case]:
    """Yield nips on layered drums and rolls."""
    materials = [wo.Isotropic(youngs_modulus=E, poissons_ratio=nu)
                 for E, nu in ((10e6, 0.49), (60e6, 0.45))]  # fmt: skip
    layers = [wo.Layer(thickness=h, material=m)
              for h, m in zip((0.015, 0.005, 0.02), (*materials, STEEL), strict=True)]  # fmt: skip
    three = TABLE_2.replace(drum=wo.Layered(radius=0.24, layers=layers))
    yield Case("Table 2, three-layer drum", three)
    yield Case("Table 2, three-layer drum, half a turn", three.wrapped())
    yield Case("Table 2, three-layer drum, both wraps", three.wrapped(drum_wrap=1.0))
    tube = wo.Layered(radius=0.24, layers=layers, core="free")
    yield Case("Table 2, three-layer tube", TABLE_2.replace(drum=tube))

    def keep(problem: Any) -> bool:
        return not problem.roll.confined_only

    yield from drawn(layered.random_layered, range(12), "layered.py", "random layered nip", keep)


def viscoelastic_nips() -> Iterator[Case]:
    """Yield nips on viscoelastic covers."""
    soft = wo.Cylinder(radius=0.25, core_radius=0.235, material=RUBBER)
    for V in (0.1, 3.0, 30.0):
        yield Case(f"Table 2, rubber cover, {V:g} m/s", TABLE_2.replace(drum=soft, web_speed=V))
    rolling = TABLE_2.replace(drum=soft, web_speed=3.0)
    yield Case("Table 2, rubber cover, half a turn", rolling.wrapped())
    yield Case("Table 2, rubber cover, both wraps", rolling.wrapped(drum_wrap=1.0))
    roll = wo.Cylinder(radius=0.2, core_radius=0.05, material=RUBBER.replace(youngs_modulus=50e6))
    yield Case("Table 2, viscoelastic roll, half a turn",
               TABLE_2.replace(roll=roll, web_speed=8.0).wrapped())  # fmt: skip
    seeds = [seed for seed in range(12) if seed % 3 < 2]
    yield from drawn(viscoelastic.random_viscoelastic, seeds, "viscoelastic.py",
                     "random viscoelastic nip")  # fmt: skip


def hardening_rolls() -> Iterator[Case]:
    """Yield nips whose roll, or web, hardens."""

    def stack(K1: float, K2: float, **more: float) -> wo.Stack:
        return wo.Stack(
            radial=wo.Pfeiffer(K1=K1, K2=K2), shear=10e6,
            tangential=NEWSPRINT.tangential - NEWSPRINT.cross**2 / NEWSPRINT.radial,
            poissons_ratio=NEWSPRINT.cross / NEWSPRINT.radial, **more,
        )  # fmt: skip

    def roll(stack: wo.Stack, P0: float) -> wo.WoundRoll:
        return wo.WoundRoll(radius=0.1, core_radius=0.0445, stack=stack, pressure=P0)

    soft, firm = stack(10e3, 127.0), stack(100e3, 65.0)
    nip = TABLE_2.replace(roll=roll(soft, 90e3))
    yield Case("Table 2, K1 10 kPa, K2 127, P0 90 kPa", nip)
    yield Case("the same, half a turn", nip.wrapped())
    yield Case("the same, both wraps", nip.wrapped(drum_wrap=1.0))
    yield Case("the same, light load", nip.replace(nip_load=350.0).wrapped())
    yield Case("the same, the web hardens", nip.replace(**{"web.material": soft}))
    yield Case("the same, the web hardens, half a turn",
               nip.wrapped().replace(**{"web.material": soft}))  # fmt: skip
    yield Case("Table 2, linear roll, the web hardens",
               TABLE_2.wrapped().replace(**{"web.material": firm}))  # fmt: skip
    yield Case("Table 2, K1 100 kPa, K2 65, P0 200 kPa",
               TABLE_2.replace(roll=roll(firm, 200e3)).wrapped())  # fmt: skip
    hard = roll(stack(10e3, 127.0, shear_exponent=0.5), 90e3)
    yield Case("Table 2, the shear modulus hardens", TABLE_2.replace(roll=hard))

    def random_hardening(seed: int) -> Any:
        return hardening.random_nip(np.random.default_rng(seed))

    for case in drawn(random_hardening, range(8), "", "random hardening nip"):
        seed = case.name.rpartition(" ")[2]
        yield case._replace(origin="benchmarks/hardening.py of version 0.2, random_nip("
                                   f"np.random.default_rng({seed}))")  # fmt: skip


def roller(shear: float, nu: float, radius: float = 0.05) -> wo.HalfPlane:
    """Return an isotropic half-plane roller of a shear modulus."""
    material = wo.Isotropic(youngs_modulus=2 * shear * (1 + nu), poissons_ratio=nu)
    return wo.HalfPlane(radius=radius, material=material)


def partial_slip(problem: wo.RollerProblem) -> tuple[Reference, ...]:
    """Return Carter's or Cattaneo's solution."""
    if problem.motion == "rolling":
        exact = theories.carter(problem)
        return (
            Reference("half_width", exact.half_width, 1e-12, "Carter (1926), closed form"),
            Reference("creepage", exact.creepage, 1e-12, "Carter (1926), closed form"),
        )
    exact = theories.cattaneo(problem)
    source = "Cattaneo (1938), Mindlin (1949), closed form"
    return (Reference("half_width", exact.half_width, 1e-12, source),)


CONTACT = "the open boundary-element program CONTACT, printed with four digits"
# reference values of a rigid cylinder on a flat bonded layer: nu, a/h -> P/P_Hertz, p(0)/(E* a/2R)
BONDED = {
    (0.3, 1.0): (1.55564006, 1.60976882),
    (0.3, 5.0): (5.59581921, 6.41260799),
    (0.5, 1.0): (1.90329916, 2.00232706),
    (0.5, 5.0): (18.2833054, 22.7522081),
}
# f R/c_inf over the Deborah number of Hunter's problem with E_0/E_inf = 2, c_inf = sqrt(4PR/pi E*)
HUNTER = {0.1: 0.08513067, 1.0: 0.17756473, 10.0: 0.04635429}


def rollers() -> Iterator[Case]:
    """Yield two rollers, rolling and static."""
    steel = wo.RollerProblem.example()
    yield Case(
        "Carter, steel, Q 8.4 kN/m", steel,
        (*partial_slip(steel), Reference("slip_share", 0.0993136, 5e-5, "Carter, closed form"),
         Reference("peak_pressure", 160.1633e6, 2e3, "Hertz, closed form")),
    )  # fmt: skip
    for Q in (-8.4e3, 40e3):
        driven = steel.replace(tangential_load=Q)
        yield Case(f"Carter, Q {Q:g} N/m", driven, partial_slip(driven))
    for xi in (1e-4, -4e-4):
        yield Case(f"steel, creepage {xi:g}", steel.replace(tangential_load=None, creepage=xi))
    full = steel.replace(tangential_load=None, creepage=-0.01)
    yield Case("steel, creepage of full slip", full,
               (Reference("tangential_load", -0.5 * 89e3, 1e-5, "closed form -mu P"),))  # fmt: skip
    for Q in (8.4e3, 40e3):
        static = steel.replace(tangential_load=Q, motion="static")
        yield Case(f"Cattaneo, Q {Q:g} N/m", static, partial_slip(static))
    free = wo.RollerProblem(upper=roller(23e9, 0.31), lower=roller(82e9, 0.28), load=16201.9,
                            friction=0.05)  # fmt: skip
    for share, xi in ((0.0, 4.294e-4), (0.75, 2.108e-4), (-0.75, 5.392e-4)):
        driven = free.replace(tangential_load=share * 0.05 * 16201.9)
        yield Case(f"Bentall and Johnson, Q {share:g} mu P", driven,
                   (Reference("creepage", -xi, 0.003 * xi, CONTACT),))  # fmt: skip
    limit = "Bentall and Johnson (1967), limit mu -> 0: -0.457386 kappa a/R"
    yield Case("Bentall and Johnson, low friction", free.replace(friction=1e-4),
               (Reference("creepage", -5.26299e-4, 1e-6, limit),))  # fmt: skip
    stick = free.replace(friction=10.0)
    yield Case("Bentall and Johnson, full stick", stick,
               (Reference("half_width", theories.bentall_johnson_stick(stick).half_width, 1e-9,
                          "closed form, full stick"),
                Reference("creepage", -3.67269e-4, 5e-7, "closed form, full stick")))  # fmt: skip
    yield Case("dissimilar rollers, static",
               free.replace(friction=0.2, tangential_load=500.0, motion="static"))  # fmt: skip
    yield Case("dissimilar rollers, creepage", free.replace(friction=0.1, creepage=-2e-4))
    yield from viscoelastic_rollers()
    yield from bonded_layers()
    covered = wo.RollerProblem(
        upper=cover(0.015, 5e6, 0.495, 0.2), lower=wo.HalfPlane(radius=0.25, material=STEEL),
        load=8e3, friction=0.4,
    )  # fmt: skip
    yield Case("covered roller on steel", covered)
    yield Case("covered roller on steel, driven", covered.replace(tangential_load=1500.0))
    layers = [wo.Layer(thickness=0.01, material=wo.Isotropic(youngs_modulus=E, poissons_ratio=0.4))
              for E in (20e6, 200e6)]  # fmt: skip
    layer_roller = covered.replace(upper=wo.Layered(radius=0.2, layers=layers), creepage=2e-3)
    yield Case("layered roller on steel, creepage", layer_roller)
    yield from drawn(random_nips.random_rollers, range(8), "random_nips.py", "random rollers")


def viscoelastic_rollers() -> Iterator[Case]:
    """Yield viscoelastic rollers: those of the CONTACT program, Hunter's problem, random ones."""
    peaks = {0.0: 60.32, 0.009: 78.74, 0.045: 84.72, 2.0: 85.31}
    creepages = {0.0: 1.378e-2, 0.009: 1.365e-2, 0.045: 1.152e-2, 2.0: 9.932e-3}
    for tau, peak in peaks.items():
        solid = wo.Isotropic(youngs_modulus=1600e6, poissons_ratio=0.4)
        body = wo.HalfPlane(radius=0.1, material=solid)
        if tau:
            body = body.replace(material=solid.replace(prony=[(1600e6, tau / 2)]))
        problem = wo.RollerProblem(
            upper=body, lower=body, load=6e5, friction=0.3, tangential_load=-0.6 * 0.3 * 6e5,
            speed=1.0 if tau else None,
        )  # fmt: skip
        xi = creepages[tau]
        exact = partial_slip(problem) if not tau else ()
        yield Case(
            f"viscoelastic half-planes, tau_C {tau:g} s", problem,
            (Reference("peak_pressure", peak * 1e6, 2e-4 * peak * 1e6, CONTACT),
             # its traction is of first order in its cells
             Reference("creepage", -xi, 0.02 * xi, CONTACT), *exact),
        )  # fmt: skip
    for De, resistance in HUNTER.items():
        E, nu, R, P, V = 5e6, 0.5, 0.25, 2e3, 1.0
        width = np.sqrt(4 * P * R * (1 - nu**2) / (pi * E))
        rubber = wo.Isotropic(youngs_modulus=E, poissons_ratio=nu, prony=[(E, De * width / V)])
        # the radius of the rigid roller is so large that it changes 1/R by 1e-9
        problem = wo.RollerProblem(
            upper=wo.Rigid(radius=2 * R), lower=wo.HalfPlane(radius=2 * R, material=rubber),
            load=P, friction=0.0, speed=V,
        )  # fmt: skip
        f = resistance * width / R * P
        yield Case(f"Hunter, De {De:g}", problem,
                   (Reference("rolling_resistance", f, 1e-5 * f,
                              "Hunter (1961), computed independently"),))  # fmt: skip
    seeds = range(2, 15, 3)
    yield from drawn(viscoelastic.random_viscoelastic, seeds, "viscoelastic.py",
                     "random viscoelastic rollers")  # fmt: skip


def bonded_layers() -> Iterator[Case]:
    """Yield a rigid cylinder on a thin layer bonded to a rigid base, frictionless."""
    h, E, flatness = 0.01, 10e6, 1900.0
    for (nu, a_h), (load, peak) in BONDED.items():
        R, modulus, a = flatness * h / 2, E / (1 - nu**2), a_h * h
        problem = wo.RollerProblem(
            upper=wo.Rigid(radius=2 * R), lower=cover(h, E, nu, 2 * R), friction=0.0,
            load=load * pi * modulus * a**2 / (4 * R),
        )  # fmt: skip
        # the layer is curved: h/Rc = 1/1900
        source = "bonded flat layer, derived independently; the layer here is curved"
        p0 = peak * modulus * a / (2 * R)
        yield Case(f"rigid cylinder on a bonded layer, nu {nu:g}, a/h {a_h:g}", problem,
                   (Reference("half_width", a, a * 0.3 / flatness, source),
                    Reference("peak_pressure", p0, p0 * 1e-3, source)))  # fmt: skip


def air_nips() -> Iterator[Case]:
    """Yield nips with entrained air that retain 0.1 to 0.9 of the friction."""
    film, paper = wo.AirNipProblem.example(), TABLE_2.wrapped()
    for retained in (0.9, 0.7, 0.5, 0.3, 0.1):
        V = speed_for(film, retained)
        yield Case(
            f"film on a rubber drum, {retained:g} of the friction", film.replace(web_speed=V)
        )
    fields = {name: getattr(paper, name) for name in type(paper).model_fields}
    newsprint = wo.AirNipProblem(**fields | {"web_speed": 10.0, "air": wo.Air(roughness=1e-6)})
    for retained in (0.8, 0.4):
        V = speed_for(newsprint, retained)
        yield Case(f"Table 2, {retained:g} of the friction", newsprint.replace(web_speed=V))
    V = speed_for(film, 0.6)
    yield Case("film on a rubber drum, both wraps", film.replace(web_speed=V, drum_wrap=1.0))
    yield Case("film on a rubber drum, permeable web",
               film.replace(web_speed=V, **{"air.permeance": 1e-6}))  # fmt: skip
    yield from drawn(air.random_air, range(6), "air.py", "random nip with air")


@cache
def speed_for(problem: wo.AirNipProblem, retained: float) -> float:
    """Return the web speed, rounded to two digits, at which air leaves a share of the friction."""
    low, high = 1e-2, 100.0
    for _ in range(12):
        V = (low * high) ** 0.5
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            result = wo.solve(problem.replace(web_speed=V), nodes=33)
        low, high = (V, high) if result.friction_share > retained else (low, V)
    return float(f"{V:.2g}")


def wound_rolls() -> Iterator[Case]:
    """Yield wound rolls."""
    source = "closed form (limit of thin layers), physics of the wound roll"
    pressure = Reference("core_pressure", 316.79e3, 60.0, "an independent program, thin layers")
    middle = Reference("mid_pressure", 208.86e3, 60.0, "an independent program, thin layers")
    yield Case("newsprint", wo.WoundRollProblem.example(), (pressure, middle))
    for E_c, core in ((20e9, 350.25e3), (0.2e9, 167.43e3)):
        problem = wo.WoundRollProblem(
            core=wo.Core(radius=0.05, stiffness=E_c), radius=0.2, web_thickness=50e-6,
            stack=wo.Stack(radial=40e6, tangential=4e9, poissons_ratio=0.01, shear=10e6),
            wound_on_tension=2e6 * 50e-6,
        )  # fmt: skip
        yield Case(f"constant moduli, E_c {E_c:g} Pa", problem,
                   (Reference("core_pressure", core, 10.0, source),))  # fmt: skip
    taper = wo.Taper(start=350.0, taper=0.3)
    yield Case("newsprint, tapered, cooled", wo.WoundRollProblem.example().replace(
        wound_on_tension=taper, temperature_change=-20.0, radial_expansion=5e-5,
        tangential_expansion=1e-5, core_expansion=1.2e-5))  # fmt: skip
    for k, (name, problem) in enumerate(rolls.cases(5, 0)):
        if not isinstance(problem, Exception):
            yield Case(f"random roll {k}: {name}", problem,
                       origin="benchmarks/rolls.py of version 0.2, cases(5, 0)")  # fmt: skip


def coupled_windings() -> Iterator[Case]:
    """Yield coupled windings."""
    yield Case("newsprint", windings.CASE)
    surface = windings.CASE.replace(torque_split=1.0, drum=windings.COVER, radius=0.3)
    yield Case("newsprint, surface winding on a covered drum", surface)
    yield Case("film, tapered", windings.FILM)
    yield Case("film, with air", windings.FILM.replace(
        air=wo.Air(roughness=0.5e-6), web_speed=5.0))  # fmt: skip
    coarse = {"nodes": 33, "rtol": 3e-3}
    yield Case("newsprint, hardening roll in the nip",
               windings.CASE.replace(roll_body="direct", radius=0.1),
               fine={"nodes": 65, "rtol": 1e-3}, coarse=coarse)  # fmt: skip


def rejected() -> Iterator[Case]:
    """Yield widely sampled random cases that version 0.2 rejects because no contact is possible."""
    # a wide nip and a wide wrapped nip of the same seed have the same bodies
    draws = ((wide.wide_nip, 0, 3), (wide.wide_wrapped_nip, 20, 3), (wide.wide_rollers, 0, 2))
    for draw, first, count in draws:
        for case in drawn(draw, range(first, 400), "wide.py", f"wide random {draw.__name__[5:]}"):
            try:
                with warnings.catch_warnings():
                    warnings.simplefilter("ignore")
                    wo.solve(case.problem, nodes=33)
            except (wo.InvalidProblem, wo.NotConverged) as fault:
                # an iteration that fails is no reason to reject the problem
                if "stick and slip not found" in str(fault):
                    continue
                yield case._replace(fine={"nodes": 65}, coarse={"nodes": 33})
                count -= 1
                if count == 0:
                    break


FAMILIES: dict[str, Callable[[], Iterator[Case]]] = {
    "plain": plain_nips, "covers": covers, "wrapped": wrapped_nips, "drum_wraps": drum_wraps,
    "rollers": rollers, "low_friction": low_friction, "layered": layered_bodies,
    "viscoelastic": viscoelastic_nips, "hardening": hardening_rolls, "air": air_nips,
    "rolls": wound_rolls, "windings": coupled_windings, "rejected": rejected,
}  # fmt: skip


# ---- files ---------------------------------------------------------------------------------------


def provenance() -> dict[str, str]:
    """Return what computed the cases."""
    tree = Path(wo.__file__).parents[2]
    command = ["git", "-C", str(tree), "rev-parse", "HEAD"]
    commit = subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip()
    return {"woundon": wo.__version__, "commit": commit, "python": platform.python_version(),
            "numpy": np.__version__, "scipy": scipy.__version__}  # fmt: skip


def write(family: str, cases: list[dict[str, Any]]) -> None:
    """Write the file of a family, one entry of a case a line."""
    lines = ['{"solved_with": ' + json.dumps(provenance()) + ",", ' "cases": [']
    for k, case in enumerate(cases):
        entries = [f"  {json.dumps(name)}: {_text(value)}" for name, value in case.items()]
        lines += ["  {", ",\n".join(entries), "  }" + "," * (k + 1 < len(cases))]
    (FOLDER / f"{family}.json").write_text("\n".join([*lines, " ]}", ""]), encoding="utf-8")


def _text(value: Any) -> str:
    """Return JSON: a table of lists with one list a line, all else in one line."""
    if isinstance(value, dict) and any(isinstance(part, list) for part in value.values()):
        rows = [f"    {json.dumps(name)}: {json.dumps(part)}" for name, part in value.items()]
        return "{\n" + ",\n".join(rows) + "\n  }"
    return json.dumps(value)


def main() -> int:
    """Run the command line."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("families", nargs="*", choices=[*FAMILIES, []], help="all by default")
    parser.add_argument("--list", action="store_true", help="print the names of the cases and stop")
    asked = parser.parse_args()
    total = 0.0
    for family in asked.families or FAMILIES:
        cases: list[dict[str, Any]] = []
        for case in FAMILIES[family]():
            if asked.list:
                print(f"{family}: {case.name}")
                continue
            entry = solved(case)
            cases.append(entry)
            total += entry["seconds"]
            ending = ": ".join(entry.get("rejected", ()))[:90]
            print(f"{family:13} {entry['seconds']:7.2f} s  {case.name}  {ending}", flush=True)
        if not asked.list:
            write(family, cases)
    print(f"{total:.0f} s of processor time", file=sys.stderr)
    return 0


if __name__ == "__main__":
    sys.exit(main())
