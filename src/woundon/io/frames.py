"""Results as pandas DataFrames."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..quantities import outputs, value_of
from ..results import Result

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["to_frame"]


def to_frame(result: Result) -> pd.DataFrame:
    """Return the arrays of a result as columns, or its numbers as one row if it has no arrays.

    Arrays of another length than the first one are omitted.  SI units; the frame has the attributes
    ``units`` and ``long_names``, by column.

    >>> import woundon as wo
    >>> to_frame(wo.solve(wo.RollerProblem.example(), nodes=33)).attrs["units"]["pressure"]
    'Pa'

    """
    import numpy as np
    import pandas as pd

    known = {p.path: p.quantity for p in outputs(result) if p.quantity is not None}
    values = {name: value_of(result, name) for name in known}
    arrays = {name: value for name, value in values.items() if isinstance(value, np.ndarray)}
    length = next((array.shape[:1] for array in arrays.values()), None)
    columns = {name: array for name, array in arrays.items() if array.shape == length}
    frame = pd.DataFrame(columns) if columns else pd.DataFrame([values])
    frame.attrs = {
        "units": {name: known[name].unit for name in frame},
        "long_names": {name: known[name].meaning for name in frame},
    }
    return frame
