"""Nips solved for the figures: one, many over their parameters, and one along x; as datasets.

Every variable and coordinate of a dataset has its unit in ``attrs["units"]``.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Annotated, Any

import numpy as np
import xarray as xr

import woundon as wo

from .cases import ONE_PAPER
from .zones import zone_lengths

__all__ = [
    "FINE", "OUTPUTS", "along_nip", "dataset", "joined", "options", "quiet", "solved", "swept",
]  # fmt: skip

Array = np.ndarray

NODES = 129  # NIT to about 0.1 N/m
THESIS_NODES = 200
FINE = 257  # zone borders to 0.6 % of the nip width or better

# names in the data -> fields of the problem, where they differ
_FIELDS = {
    "roll_radius": "roll.radius",
    "drum_radius": "drum.radius",
    "cover_core_radius": "drum.core_radius",
    "youngs_modulus": "drum.material.youngs_modulus",
    "poissons_ratio": "drum.material.poissons_ratio",
    **{name: f"roll.material.{name}" for name in ("radial", "tangential", "cross", "shear")},
}


def _leading(
    result: wo.NipResult,
) -> Annotated[float, wo.Quantity("s_r1", "1", "slip length at the roll's leading edge, to A")]:
    return zone_lengths(result).leading_roll


def _trailing(
    result: wo.NipResult,
) -> Annotated[float, wo.Quantity("s_r2", "1", "slip length at the roll's trailing edge, from B")]:
    return zone_lengths(result).trailing_roll


def _dual(
    result: wo.NipResult,
) -> Annotated[float, wo.Quantity("s_d", "1", "length of slip at roll and drum, from C")]:
    return zone_lengths(result).dual


# the thesis's slip ratios, over the nip width, as outputs of every study
wo.NipResult.leading_roll_slip = property(_leading)  # type: ignore[attr-defined]
wo.NipResult.trailing_roll_slip = property(_trailing)  # type: ignore[attr-defined]
wo.NipResult.dual_slip = property(_dual)  # type: ignore[attr-defined]

OUTPUTS = (
    "nip_induced_tension", "nip_width", "approach", "leading_roll_slip", "trailing_roll_slip",
    "dual_slip",
)  # fmt: skip


def options(scheme: str, nodes: int = NODES) -> dict[str, Any]:
    """Return the solver's options: accurate with so many nodes, or as the thesis did, M = 200."""
    return {"scheme": scheme, "nodes": THESIS_NODES} if scheme == "thesis" else {"nodes": nodes}


@contextmanager
def quiet() -> Iterator[None]:
    """Leave out warnings: the thesis's soft covers leave the model's validity; the text says so."""
    with warnings.catch_warnings():
        for category in (wo.ValidityWarning, wo.ResolutionWarning):
            warnings.simplefilter("ignore", category)
        yield


def solved(problem: wo.Problem, scheme: str = "graded", nodes: int = NODES) -> Any:
    """Solve a nip; a wrapped one, ``problem.wrapped()``, accurately only."""
    with quiet():
        return wo.solve(problem, **options(scheme, nodes))


def swept(
    problem: wo.Problem,
    over: Mapping[str, Any],
    scheme: str = "graded",
    outputs: Sequence[str] = OUTPUTS,
    nodes: int = NODES,
) -> xr.Dataset:
    """Solve a nip for all combinations of values.

    Parameters
    ----------
    problem : NipProblem or WrappedNipProblem
    over : mapping
        Parameter -> values; a dimension each.  Moduli are those of roll and web.
    scheme : {"graded", "thesis"}
        A wrapped nip is solved by the first only.
    outputs : sequence of str
        Of ``woundon.sweep``, the thesis's slip ratios among them.
    nodes : int
        Of the accurate scheme.

    Raises
    ------
    NotConverged
        If a nip cannot be solved.
    """
    fields = {_FIELDS.get(name, name): values for name, values in over.items()}
    with quiet():
        data = wo.sweep(
            problem, fields, outputs, tie=ONE_PAPER, workers=1, options=options(scheme, nodes)
        )
    for reason in filter(None, data["failure"].values.flat):
        raise wo.NotConverged(reason)
    names = {field: name for name, field in zip(over, fields, strict=True) if name != field}
    return data.drop_vars(["failure", "warnings"]).drop_attrs(deep=False).rename(names)


def dataset(dim: str, columns: Mapping[str, Array | Sequence[float]]) -> xr.Dataset:
    """Return columns of one length, by names with units (``"x [m]"``), as a dataset."""
    data: dict[str, Any] = {}
    for head, values in columns.items():
        name, _, unit = head[:-1].rpartition(" [")
        data[name] = (dim, np.asarray(values), {"units": unit})
    return xr.Dataset(data, {dim: np.arange(len(values))})


def joined(head: str, parts: Mapping[float, xr.Dataset]) -> xr.Dataset:
    """Join datasets along a new dimension, by its name with unit, ``"roll_friction [1]"``.

    What is shorter than others is filled with nan.
    """
    name, _, unit = head[:-1].rpartition(" [")
    values = xr.DataArray(list(parts), dims=name, name=name, attrs={"units": unit})
    return xr.concat(list(parts.values()), values, join="outer")


def along_nip(r: wo.NipResult) -> xr.Dataset:
    """Return a solved nip node by node: what Figs. 15, 20, 25 and 30 show."""
    return dataset(
        "node",
        {
            "x [m]": r.x,
            "pressure [Pa]": r.pressure,
            "roll_traction [Pa]": r.roll_traction,
            "drum_traction [Pa]": r.drum_traction,
            "slip_x [m]": r.slip_x,
            "roll_slip [1]": r.roll_slip,
            "drum_slip [1]": r.drum_slip,
            "tension_increase [N/m]": r.web_tension - r.problem.web_tension,
            "roll_zone [1]": r.roll_zone,
            "drum_zone [1]": r.drum_zone,
        },
    )
