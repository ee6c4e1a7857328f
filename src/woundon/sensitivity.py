"""Derivatives of the outputs of a result with respect to fields of its problem."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from .results import Presented, ReadOnly

if TYPE_CHECKING:
    import pandas as pd
    import xarray

__all__ = ["Sensitivity"]

Array = np.ndarray

MOST_SHOWN = 3  # parameters in the one-line representation


@dataclass(frozen=True, eq=False, repr=False)
class Sensitivity(Presented, ReadOnly):
    """First derivatives of the outputs of a result at one problem.

    Attributes
    ----------
    outputs : tuple of str
        Those asked for; by default ``wound_on_tension``, ``nip_induced_tension``,
        ``outlet_tension``, ``half_width``, ``nip_width`` and ``drum_creepage``.
    parameters : tuple of str
        Dotted names of the fields.
    derivatives : (outputs, parameters) array
        SI units of output per SI unit of field.
    values, fields : (outputs,), (parameters,) arrays
        Outputs and fields at the problem at which the derivatives were taken [SI].
    zone_change : str
        Empty, or the nodes that are about to change between stick and slip: there the
        derivatives to both sides differ.
    errors : (outputs, parameters) array
        Estimated discretisation errors of the derivatives; nan where they are not known.

    Examples
    --------
    >>> import woundon as wo
    >>> nip = wo.solve(wo.NipProblem.example(), nodes=41)
    >>> slopes = nip.sensitivity("roll_friction", "nip_load", outputs=["wound_on_tension"])
    >>> print(slopes.elasticities.round(2))
    [[0.07 0.34]]
    """

    outputs: tuple[str, ...]
    parameters: tuple[str, ...]
    derivatives: Array
    values: Array
    fields: Array
    zone_change: str = ""
    errors: Array | None = None

    def derivative(self, output: str, parameter: str) -> float:
        """Return d output / d parameter."""
        row, column = self.outputs.index(output), self.parameters.index(parameter)
        return float(self.derivatives[row, column])

    @property
    def elasticities(self) -> Array:
        """Percent of output per percent of field, (outputs, parameters); 0 for a field at 0.

        nan for an output that is 0.
        """
        values = np.where(self.values == 0, np.nan, self.values)
        return self.derivatives * self.fields / values[:, None]

    def to_xarray(self) -> xarray.Dataset:
        """Return derivatives [SI] and elasticities along ``output`` and ``parameter``."""
        import xarray

        dims = ("output", "parameter")
        tables = {
            "derivative": (dims, self.derivatives, {"long_name": "d output / d parameter, SI"}),
            "elasticity": (dims, self.elasticities, {"units": "1"}),
        }
        variables = {"value": ("output", self.values), "field": ("parameter", self.fields)}
        places = {"output": list(self.outputs), "parameter": list(self.parameters)}
        return xarray.Dataset(tables, places | variables, {"zone_change": self.zone_change})

    def to_dataframe(self) -> pd.DataFrame:
        """Return a row for each parameter: its value [SI] and the outputs' elasticities [1]."""
        import pandas as pd

        columns = {"value": self.fields, **dict(zip(self.outputs, self.elasticities, strict=True))}
        return pd.DataFrame(columns, index=pd.Index(self.parameters, name="parameter"))

    def __repr__(self) -> str:
        first = self.sorted()
        largest = zip(first.parameters[:MOST_SHOWN], first.elasticities[0], strict=False)
        shown = ", ".join(f"{name} {value:+.2f}" for name, value in largest)
        counts = f"{len(self.parameters)} parameters; {len(self.outputs)} outputs"
        return f"Sensitivity({self.outputs[0]}: {shown} of {counts})"

    def sorted(self) -> Sensitivity:
        """Return a copy with the parameters sorted by the size of the first output's elasticity.

        The largest is first; an elasticity that is not defined counts as 0.
        """
        order = np.argsort(-np.abs(np.nan_to_num(self.elasticities[0])), kind="stable")
        return replace(
            self,
            parameters=tuple(self.parameters[k] for k in order),
            derivatives=self.derivatives[:, order],
            fields=self.fields[order],
            errors=None if self.errors is None else self.errors[:, order],
        )
