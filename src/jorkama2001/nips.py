"""Nips solved for the figures: one, many over their parameters, and one along x; as datasets.

Every variable and coordinate of a dataset has its unit in ``attrs["units"]``.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from itertools import product
from typing import Annotated, Any

import numpy as np
import xarray as xr

import woundon as wo

from .cases import ONE_PAPER
from .zones import zone_lengths

__all__ = [
    "FINE", "OUTPUTS", "along_nip", "dataset", "joined", "options", "solved", "solved_wrapped",
    "swept", "swept_wrapped",
]  # fmt: skip

Array = np.ndarray

NODES = 129  # NIT to about 0.1 N/m
THESIS_NODES = 200
FINE = 257  # zone borders to 0.6 % of the nip width or better
WRAPPED_NODES = 65

# names in the data -> fields of the problem, where they differ
_FIELDS = {
    "roll_radius": "roll.radius",
    "drum_radius": "drum.radius",
    "cover_core_radius": "drum.core_radius",
    "youngs_modulus": "drum.material.youngs_modulus",
    "poissons_ratio": "drum.material.poissons_ratio",
    **{name: f"roll.material.{name}" for name in ("radial", "tangential", "cross", "shear")},
}


def _leading(result: wo.NipResult) -> Annotated[
    float, wo.Quantity("s_r1", "1", "slip length at the roll's leading edge / nip width, to A")
]:
    return zone_lengths(result).leading_roll


def _trailing(result: wo.NipResult) -> Annotated[
    float, wo.Quantity("s_r2", "1", "slip length at the roll's trailing edge / nip width, from B")
]:
    return zone_lengths(result).trailing_roll


def _dual(result: wo.NipResult) -> Annotated[
    float, wo.Quantity("s_d", "1", "length of slip at roll and drum / nip width, from C")
]:
    return zone_lengths(result).dual


# s_r1, s_r2 and s_d as the thesis measures them, outputs beside those of woundon
wo.NipResult.leading_roll_slip = property(_leading)  # type: ignore[attr-defined]
wo.NipResult.trailing_roll_slip = property(_trailing)  # type: ignore[attr-defined]
wo.NipResult.dual_slip = property(_dual)  # type: ignore[attr-defined]

OUTPUTS = (
    "nip_induced_tension", "nip_width", "approach", "leading_roll_slip", "trailing_roll_slip",
    "dual_slip",
)  # fmt: skip


def options(scheme: str, nodes: int = NODES) -> dict[str, Any]:
    """Return the solver's options: accurate with so many nodes, or as the thesis did, M = 200."""
    return {"scheme": scheme, "nodes": THESIS_NODES if scheme == "thesis" else nodes}


@contextmanager
def _quiet() -> Iterator[None]:
    """Leave out warnings: the thesis's soft covers leave the model's validity; the text says so."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", wo.ValidityWarning)
        yield


def solved(problem: wo.NipProblem, scheme: str, nodes: int = NODES) -> wo.NipResult:
    """Solve a nip."""
    with _quiet():
        return wo.solve_nip(problem, **options(scheme, nodes))


def solved_wrapped(problem: wo.NipProblem, nodes: int = WRAPPED_NODES) -> wo.WrappedNipResult:
    """Solve a nip with the web wrapped on half the roll behind it, accurately."""
    with _quiet():
        return wo.solve_wrapped_nip(problem, nodes=nodes)


def swept(
    problem: wo.NipProblem,
    over: Mapping[str, Any],
    scheme: str,
    outputs: Sequence[str] = OUTPUTS,
) -> xr.Dataset:
    """Solve a nip for all combinations of values.

    Parameters
    ----------
    problem : NipProblem
    over : mapping
        Parameter -> values; a dimension each.  Moduli are those of roll and web.
    scheme : {"graded", "thesis"}
    outputs : sequence of str
        Of ``woundon.sweep``, or the thesis's slip ratios.

    Raises
    ------
    NotConverged
        If a nip cannot be solved.
    """
    fields = {_FIELDS.get(name, name): values for name, values in over.items()}
    with _quiet():
        data = wo.sweep(problem, fields, outputs, tie=ONE_PAPER, workers=1, **options(scheme))
    for reason in filter(None, data["failure"].values.flat):
        raise wo.NotConverged(reason)
    names = {field: name for name, field in zip(over, fields, strict=True) if name != field}
    return data.drop_vars(["failure", "warnings"]).drop_attrs(deep=False).rename(names)


def swept_wrapped(problem: wo.NipProblem, over: Mapping[str, Any]) -> xr.Dataset:
    """Solve the nip with the web wrapped on half the roll for all combinations of values.

    The variables are ``wrapped_tension``, NIT, and ``wrapped_added``, the wound-on tension less
    T_in [N/m].
    """
    rows = []
    for values in product(*over.values()):
        case = problem.replace(**dict(zip(over, map(float, values), strict=True)))
        r = solved_wrapped(case)
        rows.append((r.nip_induced_tension, r.wound_on_tension - case.web_tension))
    shape = [len(values) for values in over.values()]
    names = ("wrapped_tension", "wrapped_added")
    columns = {
        name: (tuple(over), column.reshape(shape), {"units": "N/m"})
        for name, column in zip(names, np.transpose(rows), strict=True)
    }
    return xr.Dataset(columns, {name: np.asarray(values) for name, values in over.items()})


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
