"""Nips solved for the figures: one, many over their parameters, and one along x; as datasets.

Every variable and coordinate of a dataset has its unit in ``attrs["units"]``.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np
import xarray as xr

import woundon as wo

from ..studies.api import study_of
from ..studies.model import Answer, KindModel
from ..studies.run import Workers, run_study
from . import procedure
from .cases import ONE_PAPER
from .outputs import OUTPUTS as ADDED
from .procedure import ProcedureResult

__all__ = [
    "FINE",
    "OUTPUTS",
    "Nip",
    "along_nip",
    "dataset",
    "joined",
    "quiet",
    "solved",
    "solved_accurately",
    "swept",
]

Array = np.ndarray
Nip = wo.NipResult | ProcedureResult

NODES = 129  # NIT to about 0.1 N/m
THESIS_NODES = 200
FINE = 257  # zone boundaries to 0.6 % of the nip width or better

# names in the data -> fields of the problem, where they differ
_FIELDS = {
    "roll_radius": "roll.radius",
    "drum_radius": "drum.radius",
    "cover_core_radius": "drum.core_radius",
    "youngs_modulus": "drum.material.youngs_modulus",
    "poissons_ratio": "drum.material.poissons_ratio",
    **{name: f"roll.material.{name}" for name in ("radial", "tangential", "cross", "shear")},
}

OUTPUTS = (
    "nip_induced_tension",
    "nip_width",
    "approach",
    "leading_roll_slip",
    "trailing_roll_slip",
    "dual_slip",
)


@contextmanager
def quiet() -> Iterator[None]:
    """Suppress warnings: the thesis's soft covers are outside the validity limits, as it states."""
    with warnings.catch_warnings():
        for category in (wo.ValidityWarning, wo.ResolutionWarning):
            warnings.simplefilter("ignore", category)
        yield


def solved(problem: wo.NipProblem, solver: str = "accurate", nodes: int = NODES) -> Nip:
    """Solve a nip accurately, or by the procedure of the thesis with M = 200."""
    if solver == "thesis":
        return procedure.solve(problem, THESIS_NODES)
    return solved_accurately(problem, nodes)


def solved_accurately(problem: wo.NipProblem, nodes: int = NODES) -> wo.NipResult:
    """Solve a nip, also one with wraps."""
    with quiet():
        return wo.solve(problem, nodes=nodes)


def swept(
    problem: wo.NipProblem,
    over: Mapping[str, Any],
    solver: str = "accurate",
    outputs: Sequence[str] = OUTPUTS,
    nodes: int = NODES,
) -> xr.Dataset:
    """Solve a nip for all combinations of values.

    Parameters
    ----------
    problem : NipProblem
    over : mapping
        Parameter -> values; a dimension each, in this order.  Moduli are those of roll and web.
    solver : {"accurate", "thesis"}
        Accurate, or by the procedure of the thesis; a wrapped nip is solved by the first only.
    outputs : sequence of str
        Of ``woundon.sweep``, the thesis's slip ratios among them.
    nodes : int
        Of the accurate solver.

    Raises
    ------
    NotConverged
        If a nip cannot be solved.
    """
    # parameters by the names of the fields; the dataset gets their own names again
    fields = {_FIELDS.get(name, name): values for name, values in over.items()}
    model, cases = study_of(problem, fields, outputs, tie=ONE_PAPER, options={"nodes": nodes})
    if solver == "thesis":
        model = _SolvedByProcedure(model.problem, model.outputs, tie=model.tie)
    data = run_study(model, cases, Workers(1)).to_dataset()
    for reason in filter(None, data["failure"].values.flat):
        raise wo.NotConverged(reason)
    names = {field: name for name, field in zip(over, fields, strict=True) if name != field}
    return data.drop_vars(["failure", "warnings"]).drop_attrs(deep=False).rename(names)


class _SolvedByProcedure(KindModel):
    """A nip with the outputs of a sweep, which the procedure of the thesis solves."""

    problem: wo.NipProblem

    def run(self, inputs: Mapping[str, Any], start: object) -> Answer:
        """Solve one case; the procedure takes no neighbouring solution as a start."""
        problem = self.with_ties(self.problem.replace(**inputs))
        nip = procedure.solve(problem, THESIS_NODES)
        values = tuple(_output(nip, name) for name in self.outputs)
        return Answer(values, warnings="", state=None)


def _output(nip: ProcedureResult, name: str) -> float:
    """Return an output of a nip by its name, also one of those that the reproduction adds."""
    added = {output.__name__: output for output in ADDED}
    return float(added[name](nip) if name in added else getattr(nip, name))


def dataset(dim: str, columns: Mapping[str, Array | Sequence[float]]) -> xr.Dataset:
    """Return columns of one length, by names with units (``"x [m]"``), as a dataset."""
    data: dict[str, Any] = {}
    for head, values in columns.items():
        name, _, unit = head[:-1].rpartition(" [")  # without the closing bracket
        data[name] = (dim, np.asarray(values), {"units": unit})
    return xr.Dataset(data, {dim: np.arange(len(values))})


def joined(head: str, parts: Mapping[float, xr.Dataset]) -> xr.Dataset:
    """Join datasets along a new dimension, by its name with unit, ``"roll_friction [1]"``.

    ``parts`` are the datasets by the value of this dimension; shorter ones are filled with nan.
    """
    name, _, unit = head[:-1].rpartition(" [")  # without the closing bracket
    values = xr.DataArray(list(parts), dims=name, name=name, attrs={"units": unit})
    return xr.concat(list(parts.values()), values, join="outer")


def along_nip(r: Nip) -> xr.Dataset:
    """Return a solved nip node by node: what Figs. 15, 20, 25 and 30 show."""
    return dataset(
        "node",
        {
            "x [m]": r.x,
            "pressure [Pa]": r.drum_pressure,
            "roll_traction [Pa]": r.roll_traction,
            "drum_traction [Pa]": r.drum_traction,
            "slip_x [m]": r.slip_x,
            "roll_slip [1]": r.roll_slip,
            "drum_slip [1]": r.drum_slip,
            "tension_increase [N/m]": r.tension - r.problem.web_tension,
            "roll_zone [1]": r.roll_zone,
            "drum_zone [1]": r.drum_zone,
        },
    )
