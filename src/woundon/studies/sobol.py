"""Sobol' indices: the share of the variance of an output that is due to each input.

The cases are those of Saltelli's scheme, A, B and A with one column of B for each input, run as a
study like any other: stored, resumed and spread over workers.  Indices by scipy.stats.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import ceil, log2
from typing import TYPE_CHECKING, Any

import numpy as np

from ..arguments import check_arguments, whole_number
from ..errors import InvalidProblem
from .cases import MOST_CASES, Cases, cases_in_ranges, check_number
from .outcome import Outcome
from .run import Table, failures

if TYPE_CHECKING:
    import pandas as pd
    import xarray

__all__ = ["SobolIndices", "saltelli_cases", "sobol_indices_of"]

Array = np.ndarray
RESAMPLES = 200
WIDE = 0.2  # width of a 95 % interval: an index of 0.5 may be 0.4 or 0.6
ROUNDING = 1e-9  # difference of two equal indices
MAX_SHOWN = 3  # inputs in one line


@dataclass(frozen=True, eq=False, repr=False)
class SobolIndices(Outcome):
    """Result of :func:`woundon.global_sensitivity`: Sobol' indices with 95 % intervals.

    Attributes
    ----------
    inputs, outputs : tuple of str
    first_order : (outputs, inputs) array
        Share of the variance due to the input alone.
    total_order : (outputs, inputs) array
        Share of the variance due to the input and all its interactions.
    first_interval, total_interval : (2, outputs, inputs) arrays
        Low and high ends of the bootstrapped 95 % intervals.
    table : Table
        The cases with their outputs.

    Examples
    --------
    >>> import woundon as wo
    >>> ranges = {"load": (50e3, 100e3), "friction": (0.3, 0.5)}
    >>> indices = wo.global_sensitivity(
    ...     wo.RollerProblem.example(), ranges, ["half_width"], samples=16, nodes=17, workers=1
    ... )
    >>> indices.inputs, indices.outputs
    (('load', 'friction'), ('half_width',))
    """

    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    first_order: Array
    total_order: Array
    first_interval: Array
    total_interval: Array
    table: Table

    def to_xarray(self) -> xarray.Dataset:
        """Return the indices as an xarray Dataset along ``output`` and ``input``."""
        import xarray

        names = ("first_order", "total_order", "first_interval", "total_interval")
        variables: dict[str, Any] = {}
        for name in names:
            values = getattr(self, name)
            dims = ("end", "output", "input")[-values.ndim :]  # only intervals have ends
            variables[name] = (dims, values, {"units": "1"})
        coordinates = {"output": list(self.outputs), "input": list(self.inputs)}
        return xarray.Dataset(variables, {**coordinates, "end": ["low", "high"]})

    def to_dataframe(self) -> pd.DataFrame:
        """Return a row for each output and input: the indices and their 95 % intervals [1]."""
        import pandas as pd

        index = pd.MultiIndex.from_product([self.outputs, self.inputs], names=["output", "input"])
        columns = {
            "first_order": self.first_order,
            "first_low": self.first_interval[0],
            "first_high": self.first_interval[1],
            "total_order": self.total_order,
            "total_low": self.total_interval[0],
            "total_high": self.total_interval[1],
        }
        return pd.DataFrame({name: v.ravel() for name, v in columns.items()}, index=index)

    def __repr__(self) -> str:
        order = self._strongest_first(0)[:MAX_SHOWN]
        texts = ", ".join(f"{self.inputs[j]} {self.total_order[0, j]:.2f}" for j in order)
        suffix = f"; {len(self.outputs)} outputs" if len(self.outputs) > 1 else ""
        return f"SobolIndices({self.outputs[0]}: {texts} of {len(self.inputs)} inputs{suffix})"

    def heading(self) -> str:
        """Return the heading of the table in a notebook."""
        return "Share of the variance, alone (first order) and with interactions (total)"

    def table_for_display(self) -> pd.DataFrame:
        """Return the indices, the strongest input of each output first."""
        rows = [
            k * len(self.inputs) + j
            for k in range(len(self.outputs))
            for j in self._strongest_first(k)
        ]
        return self.to_dataframe().iloc[rows]

    def _strongest_first(self, output: int) -> Array:
        """Return the numbers of the inputs in the order of their total index."""
        return np.argsort(-self.total_order[output])

    def answer(self) -> list[str]:
        """Return the indices as lines of text, by output, the strongest input first."""
        out = []
        for k, output in enumerate(self.outputs):
            out.append(f"{output}: share of the variance, alone / with interactions")
            for j in self._strongest_first(k):
                ends = self.total_interval[:, k, j]
                mark = "  *" if self.uncertain[k, j] else ""
                out.append(
                    f"  {self.inputs[j]:<28} {self.first_order[k, j]:6.3f} / "
                    f"{self.total_order[k, j]:.3f}  (95 %: {ends[0]:.3f} to {ends[1]:.3f}){mark}"
                )
        return out

    @property
    def samples(self) -> int:
        """Number of samples, the cases without those of mixed columns."""
        return len(self.table.cases) // (len(self.inputs) + 2)

    @property
    def uncertain(self) -> Array:
        """Indices that the samples do not determine, an (outputs, inputs) array of bool.

        One of the two 95 % intervals is wider than 0.2, or the first-order index, which cannot
        exceed the total index, does so.
        """
        is_wide = self._widths.max(axis=0) > WIDE
        return np.asarray(is_wide | (self.first_order > self.total_order + ROUNDING))

    @property
    def _widths(self) -> Array:
        """Widths of the 95 % intervals, (order, outputs, inputs)."""
        return np.ptp([self.first_interval, self.total_interval], axis=1)

    @property
    def proposed_samples(self) -> int:
        """Number of samples with which all 95 % intervals are expected to be narrower than 0.2.

        The width falls as the square root of the number of samples; a power of 2, the present
        number if that is sufficient.
        """
        if not self.uncertain.any():
            return self.samples
        required = self.samples * max(2.0, (float(np.nanmax(self._widths)) / WIDE) ** 2)
        return int(2 ** ceil(log2(required)))

    def remarks(self) -> list[str]:
        """Return a remark on the indices that the samples do not determine, if there are any."""
        if not self.uncertain.any():
            return []
        return [
            f"* not determined by {self.samples} samples (interval wider than {WIDE:g}, or first "
            f"order above total): use {self.proposed_samples} samples"
        ]


def saltelli_cases(ranges: Mapping[str, Any], samples: int, seed: int) -> Cases:
    """Return the samples * (inputs + 2) cases of Saltelli's scheme: A, B, A with columns of B.

    Parameters
    ----------
    ranges : mapping
        Dotted name -> (low, high) or (low, high, "log").
    samples : int
        A power of 2.
    seed : int
        Of the scrambled Sobol points.

    Raises
    ------
    InvalidProblem
        For an invalid range or number of samples.
    """
    from scipy.stats import qmc

    if not ranges:
        raise InvalidProblem.at("over", "nothing to vary: give fields and their ranges")
    if len(ranges) < 2:
        text = "has one field; must be two or more: the index of a single input is 1"
        raise InvalidProblem.at("over", text)
    check_arguments(seed=seed)
    whole_number("samples", samples, 1, MOST_CASES)
    if samples < 4 or samples & (samples - 1):
        raise InvalidProblem.at("samples", f"{samples!r} is not a power of 2, at least 4")
    d = len(ranges)
    check_number(samples * (d + 2))
    unit = qmc.Sobol(2 * d, rng=seed).random_base2(int(log2(samples)))
    A, B = unit[:, :d], unit[:, d:]
    mixed = [np.where(np.arange(d) == k, B, A) for k in range(d)]
    # sobol_indices_of relies on this order
    return cases_in_ranges(ranges, np.concatenate([A, B, *mixed]))


def sobol_indices_of(table: Table, seed: int) -> SobolIndices:
    """Return the indices from the solved cases of :func:`saltelli_cases`.

    Raises
    ------
    InvalidProblem
        If a case failed: the indices need every one.
    """
    if table.failed.size:
        reason, count = failures(table.failure)[0]
        raise InvalidProblem.at(
            "over",
            f"narrow the ranges: Sobol's indices need every case, and {table.failed.size} of "
            f"{len(table.cases)} failed, {count} like this: {reason}",
        )
    inputs, outputs = table.cases.names, tuple(table.outputs)
    values = np.stack(list(table.outputs.values())).reshape(len(outputs), len(inputs) + 2, -1)
    first, total = _indices(values)
    samples = values.shape[-1]
    rng = np.random.default_rng(seed)
    draws = [_indices(values[:, :, rng.integers(samples, size=samples)]) for _ in range(RESAMPLES)]
    ends = np.quantile(np.array(draws), [0.025, 0.975], axis=0)  # (end, order, output, input)
    return SobolIndices(inputs, outputs, first, total, ends[:, 0], ends[:, 1], table)


def _indices(values: Array) -> tuple[Array, Array]:
    """Return first-order and total-order indices, (outputs, inputs) arrays.

    Parameters
    ----------
    values : (outputs, 2 + inputs, samples) array
        At A, at B, and at A with one column of B for each input.
    """
    from scipy.stats import sobol_indices

    # SciPy expects (1, samples) for A and B, and (inputs, 1, samples) for the mixed cases
    results: Sequence[Any] = [
        sobol_indices(func={"f_A": v[:1], "f_B": v[1:2], "f_AB": v[2:, None, :]}, n=v.shape[-1])
        for v in values
    ]
    return (
        np.array([np.ravel(f.first_order) for f in results]),
        np.array([np.ravel(f.total_order) for f in results]),
    )
