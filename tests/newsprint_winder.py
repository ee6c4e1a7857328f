"""The laboratory winder of thesis Table 3 with a linear and with a hardening roll.

The web is linear (thesis Table 2, 66 um).  It leaves the roll after a quarter turn, for the load
cell.  Settings of the hardening roll:

    quarter   a stack under one pressure
    drum      the same, with half a turn of the web on the drum upstream of the nip
    wound     the same again, under the pressure in a wound roll of this stack

Of K1 and P0 only the sum Q enters in "quarter" and "drum": each is one half of it.  In "wound" P0
is zero at the surface, and K1 is the sum there.
"""

from __future__ import annotations

from functools import cache
from importlib.resources import files
from math import exp, log, pi
from typing import Any

import numpy as np
import pandas as pd
from scipy.optimize import root_scalar
from scipy.special import fdtrc
from thesis_cases import newsprint_nip

import woundon as wo

FITTED = (3502.0, 350.0)  # nip load and web tension of the point that the thesis fitted [N/m]
WOUND_ON = 700.0  # measured there [N/m]
K1, K2, P0 = "roll.stack.radial.K1", "roll.stack.radial.K2", "roll.pressure"
MODULI = ("roll.material.shear", "roll.material.radial")
BOUNDS = {
    K1: (1e3, 1e6), K2: (5.0, 2000.0), MODULI[0]: (3e5, 1e9), MODULI[1]: (1e6, 5e9),
}  # fmt: skip


def measured() -> pd.DataFrame:
    """Return the fifteen points."""
    path = files("woundon") / "data" / "wound_on_tension_newsprint.csv"
    with path.open(encoding="utf-8") as file:
        table = pd.read_csv(file, comment="#")
    return table.rename(columns=lambda name: name.partition(" [")[0])


def stack_of(K1: float, K2: float) -> wo.Stack:
    """Return a stack whose moduli along the web are those of Table 2."""
    web: Any = wo.material("newsprint")
    A_rr, A_tt, A_rt = web.radial, web.tangential, web.cross
    return wo.Stack(
        radial=wo.Pfeiffer(K1=K1, K2=K2), tangential=A_tt - A_rt**2 / A_rr,
        poissons_ratio=A_rt / A_rr, shear=10e6,
    )  # fmt: skip


@cache
def wound_pressure(stack: wo.Stack, tension: float = WOUND_ON) -> wo.Profile:
    """Return the pressure in a roll of the laboratory winder, wound with one tension."""
    wound: Any = wo.solve(wo.RollProblem(
        core=wo.Core(radius=0.0445, stiffness=1e9), radius=0.1, stack=stack, web_thickness=66e-6,
        wound_on_tension=tension,
    ))  # fmt: skip
    pressure = np.maximum(wound.pressure, 0.0)
    pressure[-1] = 0.0
    return wo.Profile(radius=wound.radius.tolist(), value=pressure.tolist())


def nip(P: float, T: float, K2: float, Q: float, setting: str = "quarter") -> wo.NipProblem:
    """Return the nip of the laboratory winder, Q = K1 + P0 at the surface of the roll."""
    wound = setting == "wound"
    stack = stack_of(Q if wound else Q / 2, K2)
    pressure = wound_pressure(stack) if wound else Q / 2
    return wo.NipProblem(
        web=wo.Web(thickness=66e-6, material=wo.material("newsprint")),
        roll=wo.WoundRoll(radius=0.1, core_radius=0.0445, stack=stack, pressure=pressure),
        drum=wo.Rigid(radius=0.0762), roll_friction=0.19, drum_friction=0.2,
        nip_load=P, winding_force=0.0, web_tension=T, roll_wrap=pi / 2,
        drum_wrap=0.0 if setting == "quarter" else pi,
    )  # fmt: skip


def linear_nip() -> wo.NipProblem:
    """Return the nip with the linear roll of Table 2."""
    return newsprint_nip(roll_wrap=pi / 2)


def one_point(Q: float, nodes: int, setting: str = "quarter") -> tuple[float, np.ndarray]:
    """Return K2 fitted to the one point, and the deviations at all fifteen [N/m]."""
    last: Any = None

    def tension(P: float, T: float, K2: float) -> float:
        nonlocal last
        last = wo.solve(nip(P, T, K2, Q, setting), nodes=nodes, start=last)
        return float(last.wound_on_tension)

    near = log(50.0 if setting == "wound" else 127.0 * (Q / 100e3) ** -0.4)
    K2 = exp(
        root_scalar(
            lambda log_K2: tension(*FITTED, exp(log_K2)) - WOUND_ON,
            x0=near, x1=near + 0.05, xtol=2e-4,
        ).root
    )  # fmt: skip
    data = measured().sort_values(["nip_load", "web_tension"])
    computed = [tension(P, T, K2) for P, T in data[["nip_load", "web_tension"]].to_numpy()]
    return K2, np.array(computed) - data["measured"].to_numpy()


def rms(deviations: Any) -> float:
    """Return the root of the mean square."""
    return float(np.sqrt(np.mean(np.square(deviations))))


def floor() -> tuple[float, int]:
    """Return the smallest RMS of any model that adds a tension to T_in, and its freedom.

    The predictions of such a model are one number for each nip load, at best the mean [N/m].
    """
    data = measured()
    added = data["measured"] - data["web_tension"]
    rest = added - added.groupby(data["nip_load"]).transform("mean")
    return rms(rest), len(data) - data["nip_load"].nunique()


def lack_of_fit(value: float, fitted: int) -> float:
    """Return the p-value of an RMS by the F test of lack of fit.

    The scatter between web tensions at one nip load stands for that of repeated measurements.
    """
    pure, free = floor()
    loads, m = measured()["nip_load"].nunique(), len(measured())
    lack = max(m * (value**2 - pure**2), 0.0) / (loads - fitted)
    return float(fdtrc(loads - fitted, free, lack / (m * pure**2 / free)))
