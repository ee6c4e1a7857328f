"""The newsprint experiment with a roll that hardens: thesis Table 3, one-point and full fits.

    python benchmarks/hardening_newsprint.py points [SETTING ...]   one number fitted to one point
    python benchmarks/hardening_newsprint.py fits [NAME ...]     full fits, profile likelihood
    python benchmarks/hardening_newsprint.py tables              benchmarks/newsprint of these

The web is linear (thesis Table 2, 66 um).  The roll is

    confined  linear, the web held at the nip's edge; the load cell by the estimate (183)
    linear    linear; the web leaves it after a quarter turn, for the load cell
    quarter   a stack under one pressure, the web led as before
    drum      the same, with the web's half turn on the drum before the nip
    wound     the same again, under the pressure that winding leaves in a roll of this stack

K1 and P0 are told apart by nothing in "quarter" and "drum": each is one half of their sum.  In the
last P0 falls to zero at the surface, and K1 stands for the sum there.  Nothing is tuned but what is
said to be fitted.  What is done is kept in --folder, and not done again: an interrupted run goes on
there.
"""

from __future__ import annotations

import os
import sys

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import json
import time
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from importlib.resources import files
from math import exp, log, pi
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from scipy.optimize import root_scalar
from table_run import sources

import woundon as wo
import woundon.jorkama2001.nips  # adds the output rig_tension
from woundon.jorkama2001.cases import ONE_PAPER, newsprint_nip

SUMS = (10e3, 100e3, 200e3, 400e3)  # K1 + P0 [Pa]
EXPECTED = {10e3: 14.4, 100e3: 10.3, 200e3: 11.7, 400e3: 13.7}  # by an independent program [N/m]
FITTED = (3502.0, 350.0)  # nip load and web tension of the point that the thesis fitted [N/m]
WOUND_ON = 700.0  # measured there [N/m]
SETTINGS = ("quarter", "drum", "wound")
LINEAR = {"confined": "rig_tension", "linear": "wound_on_tension"}
TABLES = Path(__file__).parent / "newsprint"

K1, K2, P0 = "roll.stack.radial.K1", "roll.stack.radial.K2", "roll.pressure"
G, BETA = "roll.stack.shear", "roll.stack.shear_exponent"
SHORT = {K1: "K1", K2: "K2", G: "G", BETA: "exponent", "roll.material.shear": "G",
         "roll.material.radial": "A_rr"}  # fmt: skip
BOUNDS = {
    K1: (1e3, 1e6), K2: (5.0, 2000.0), G: (1e6, 1e8), BETA: (0.0, 1.0),
    "roll.material.shear": (3e5, 1e9), "roll.material.radial": (1e6, 5e9),
}  # fmt: skip
MODULI = ("roll.material.shear", "roll.material.radial")
PROFILED = {"confined": MODULI, "linear": MODULI, "quarter": (K1, K2), "wound": (K1,)}
# where the profile is so flat that a walk would not end: K1 and K2 refitted at these values
HELD = {"G": (G, (1e6, 3e6, 100e6)), "exponent": (BETA, (0.0, 0.25, 0.5, 1.0))}


def measured() -> pd.DataFrame:
    """Return the fifteen points."""
    path = files("woundon") / "data" / "wound_on_tension_newsprint.csv"
    with path.open(encoding="utf-8") as file:
        table = pd.read_csv(file, comment="#")
    return table.rename(columns=lambda name: name.partition(" [")[0])


# ---- the nip ------------------------------------------------------------------------------------


def stack_of(K1: float, K2: float, G: float = 10e6, exponent: float = 0.0) -> wo.Stack:
    """Return a stack that is along the web as Table 2 has it."""
    web: Any = wo.material("newsprint")
    A_rr, A_tt, A_rt = web.radial, web.tangential, web.cross
    return wo.Stack(
        radial=wo.Pfeiffer(K1=K1, K2=K2), tangential=A_tt - A_rt**2 / A_rr,
        poissons_ratio=A_rt / A_rr, shear=G, shear_exponent=exponent,
    )  # fmt: skip


@cache
def wound_pressure(stack: wo.Stack, tension: float = WOUND_ON) -> wo.Profile:
    """Return the pressure in a roll of the laboratory winder's size, wound with one tension."""
    wound: Any = wo.solve(wo.RollProblem(
        core=wo.Core(radius=0.0445, stiffness=1e9), radius=0.1, stack=stack, web_thickness=66e-6,
        wound_on_tension=tension,
    ))  # fmt: skip
    pressure = np.maximum(wound.pressure, 0.0)
    pressure[-1] = 0.0
    return wo.Profile(radius=wound.radius.tolist(), value=pressure.tolist())


def nip(
    P: float, T: float, K2: float, Q: float, G: float = 10e6, exponent: float = 0.0,
    roll: wo.Body | None = None, setting: str = "quarter",
) -> wo.NipProblem:  # fmt: skip
    """Return the laboratory winder's nip, Q = K1 + P0 at the roll's surface."""
    wound = setting == "wound"
    stack = stack_of(Q if wound else Q / 2, K2, G, exponent)
    pressure = wound_pressure(stack) if wound else Q / 2
    return wo.NipProblem(
        web=wo.Web(thickness=66e-6, material=wo.material("newsprint")),
        roll=roll or wo.WoundRoll(radius=0.1, core_radius=0.0445, stack=stack, pressure=pressure),
        drum=wo.Rigid(radius=0.0762), roll_friction=0.19, drum_friction=0.2,
        nip_load=P, winding_force=0.0, web_tension=T, roll_wrap=pi / 2,
        drum_wrap=0.0 if setting == "quarter" else pi,
    )  # fmt: skip


# ---- one-point fits -----------------------------------------------------------------------------


def one_point(Q: float, nodes: int, setting: str = "quarter") -> tuple[float, np.ndarray]:
    """Return K2 fitted to the one point, and what is left at all fifteen [N/m]."""
    last: Any = None

    def tension(P: float, T: float, K2: float) -> float:
        nonlocal last
        problem = nip(P, T, K2, Q, setting=setting)
        try:
            last = wo.solve(problem, nodes=nodes, start=last)
        except wo.NotConverged:  # too far from the last one
            last = wo.solve(problem, nodes=nodes)
        return float(last.wound_on_tension)

    def miss(log_K2: float) -> float:
        return tension(*FITTED, exp(log_K2)) - WOUND_ON

    near = log(127.0 * (Q / 100e3) ** -0.4 if setting != "wound" else 50.0)
    K2 = exp(root_scalar(miss, x0=near, x1=near + 0.05, xtol=2e-4).root)
    data = measured().sort_values(["nip_load", "web_tension"])
    told = [tension(P, T, K2) for P, T in data[["nip_load", "web_tension"]].to_numpy()]
    return K2, np.array(told) - data["measured"].to_numpy()


def linear_points(name: str, nodes: int) -> Iterator[dict[str, Any]]:
    """Yield the linear roll's misses as printed, and with one modulus fitted to the one point."""
    data, output, problem = measured(), LINEAR[name], linear_nip(name)
    there = (data["nip_load"] == FITTED[0]) & (data["web_tension"] == FITTED[1])
    for field in (None, *MODULI):
        solved = problem
        if field is not None:
            solved = fit(problem, (field,), nodes, output, ONE_PAPER, data=data[there]).problem
        told = [
            getattr(wo.solve(solved.replace(nip_load=P, web_tension=T), nodes=nodes), output)
            for P, T in data[["nip_load", "web_tension"]].to_numpy()
        ]
        value = None if field is None else getattr(solved.roll.material, field.split(".")[-1])
        yield {"setting": name, "fitted": field and SHORT[field], "value": value, "nodes": nodes,
               "misses": (np.array(told) - data["measured"].to_numpy()).tolist()}  # fmt: skip


def linear_nip(name: str) -> Any:
    """Return the nip of a linear roll, confined or wrapped."""
    problem = newsprint_nip()
    return problem if name == "confined" else problem.replace(roll_wrap=pi / 2)


def points(settings: list[str], nodes: int, folder: Path) -> None:
    """Print the one-point fits."""
    print("roll       K1 + P0 [kPa]      K2   RMS [N/m]  expected   misses by load and tension")
    for setting in settings or (*LINEAR, *SETTINGS):
        if setting in LINEAR:
            for k, made in enumerate(linear_points(setting, nodes)):
                _keep(folder / f"point-{setting}-{k}-{nodes}.json", made)
                what = made["fitted"] and f"{made['fitted']} = {made['value'] / 1e6:.2f} MPa"
                print(f"{setting:8} {what or 'nothing fitted':>23} {rms(made['misses']):11.1f}")
            continue
        for Q in SUMS:
            kept = folder / f"point-{setting}-{Q:.0f}-{nodes}.json"
            made = _kept(kept) or {}
            if not made:
                K2, rest = one_point(Q, nodes, setting)
                made = _keep(kept, {"setting": setting, "Q": Q, "nodes": nodes, "fitted": "K2",
                                    "value": K2, "misses": rest.tolist()})  # fmt: skip
            row = " ".join(f"{v:6.1f}" for v in made["misses"])
            said = f"{rms(made['misses']):11.1f} {EXPECTED[Q]:9.1f}   {row}"
            print(f"{setting:8} {Q / 1e3:15.0f} {made['value']:7.1f} {said}", flush=True)


def rms(rest: Any) -> float:
    """Return the root of the mean square."""
    return float(np.sqrt(np.mean(np.square(rest))))


# ---- full fits ----------------------------------------------------------------------------------


def models() -> dict[str, dict[str, Any]]:
    """Return what is fitted, by name: the arguments of ``wo.fit``.

    A name with a parameter behind its dash is the same fit, begun where that one ended if it was
    made, with the profile of the parameter; "held-" with a value is the fit of K1 and K2 with that
    parameter held.
    """
    half = {"tie": {P0: K1}}
    Q = 100e3
    start: dict[str, Any] = {"K2": 127.0, "Q": Q}
    # the pressure of "wound" stays that of this stack, which is about the one-point fit's: near the
    # surface it hardly depends on the stack
    wound = nip(*FITTED, K2=50.0, Q=Q, setting="wound")
    made: dict[str, dict[str, Any]] = {
        **{name: {"problem": linear_nip(name), "vary": MODULI, "tie": ONE_PAPER,
                  "output": output} for name, output in LINEAR.items()},
        "four": {"problem": nip(*FITTED, **start, exponent=0.1), "vary": (K1, K2, G, BETA), **half},
        "quarter": {"problem": nip(*FITTED, K2=147.0, Q=75e3), "vary": (K1, K2), **half},
        "wound": {"problem": wound, "vary": (K1, K2)},
    }  # fmt: skip
    for name, profiled in PROFILED.items():
        made |= {f"{name}-{SHORT[p]}": {**made[name], "begin": name, "profiles": [p]}
                 for p in profiled}  # fmt: skip
    for short, (field, values) in HELD.items():
        for value in values:
            share = value / 10e6 if field == G else 1.0  # K2 goes about with G
            problem = nip(*FITTED, K2=127.0 * share, Q=Q).replace(**{field: value})
            made[f"held-{short}={value:g}"] = {"problem": problem, "vary": (K1, K2), **half}
    return made


def fit(
    problem: Any, vary: Sequence[str], nodes: int, output: str = "wound_on_tension",
    tie: Mapping[str, str] | None = None, profiles: list[str] | None = None,
    data: pd.DataFrame | None = None,
) -> Any:  # fmt: skip
    """Return the fit to measured points, all fifteen of them by default."""
    data = measured() if data is None else data
    columns = {name: data[name] for name in ("nip_load", "web_tension")}
    return wo.fit(
        problem, {**columns, output: data["measured"]}, {name: BOUNDS[name] for name in vary},
        tie=tie, starts=1, nodes=nodes, profiles=profiles or (),
    )  # fmt: skip


def fits(names: list[str], nodes: int, folder: Path) -> None:
    """Make the full fits that are not there yet."""
    known = models()
    for name in names or known:
        asked, kept = dict(known[name]), folder / f"fit-{name}-{nodes}.json"
        begin, began = asked.pop("begin", None), time.process_time()
        if _kept(kept) is not None:
            continue
        before = _kept(folder / f"fit-{begin}-{nodes}.json")
        if before is not None:
            at = dict(zip(before["names"], before["estimates"], strict=True))
            asked["problem"] = asked["problem"].replace(**at)
        made = fit(nodes=nodes, **asked)
        _keep(kept, {**json.loads(made.to_json()), "seconds": time.process_time() - began})
        print(f"--- {name}, {nodes} nodes\n{made}", flush=True)


# ---- what is kept -------------------------------------------------------------------------------


def _kept(path: Path) -> dict[str, Any] | None:
    """Return what was found before, None if nothing was."""
    if not path.exists():
        return None
    record: dict[str, Any] = json.loads(path.read_text())
    if record["sources"] != sources():
        print(f"{path}: made by other sources of the program", file=sys.stderr)
    return record


def _keep(path: Path, record: dict[str, Any]) -> dict[str, Any]:
    path.parent.mkdir(parents=True, exist_ok=True)
    aside = path.with_suffix(".part")
    aside.write_text(json.dumps({"sources": sources(), **record}))
    os.replace(aside, path)
    return record


def main() -> None:
    """Run what is asked."""
    asked = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    asked.add_argument("what", choices=("points", "fits", "tables"))
    asked.add_argument("names", nargs="*", help="of settings or fits; all without")
    asked.add_argument("--nodes", type=int, help="33 of points (0.1 %% of WOT), 17 of fits")
    asked.add_argument("--folder", type=Path, default=Path("out/newsprint"), help="of the results")
    given = asked.parse_args()
    if given.what == "points":
        points(given.names, given.nodes or 33, given.folder)
    elif given.what == "fits":
        fits(given.names, given.nodes or 17, given.folder)
    else:
        from newsprint_tables import tables

        tables(given.folder)


if __name__ == "__main__":
    main()
