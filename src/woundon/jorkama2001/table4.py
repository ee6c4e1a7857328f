"""Thesis Table 4: the winding theorem on measured tensions.

In centre winding the nip adds the same tension whatever the web brings along (the winding
theorem), so measured wound-on tension less T_in should depend on the nip load alone.  What is left
of it between the tensions is scatter that no model of this kind can follow.
"""

from __future__ import annotations

import numpy as np
import pandas as pd

from .cases import measured_tensions
from .exhibits import Exhibit
from .laboratory import rms
from .nips import dataset
from .verdicts import Verdict, at_least, at_most, verdict

__all__ = ["added_tensions", "as_text", "best_rms", "exhibits", "report"]

# averages and standard deviations by nip load, rows put right [N/m]
PRINTED_AVERAGES = (72.0, 142.0, 230.0, 345.0, 459.0)
PRINTED_DEVIATIONS = (17.0, 10.0, 13.0, 9.0, 7.0)


def added_tensions() -> pd.DataFrame:
    """Return the measured tension that the nip added, nip loads by web tensions [N/m]."""
    points = measured_tensions()
    points["added"] = points["measured"] - points["web_tension"]
    return points.pivot(index="nip_load", columns="web_tension", values="added")


def best_rms() -> float:
    """Return the RMS residual of the best model without influence of T_in [N/m]."""
    added = added_tensions()
    return rms(added.sub(added.mean(axis=1), axis=0).to_numpy())


def exhibits(solver: str) -> list[Exhibit]:
    """Return Table 4; measured data, the solver plays no part."""
    added = added_tensions()
    columns = {
        "nip_load [N/m]": added.index,
        **{f"added at T_in {T:.0f} N/m [N/m]": added[T] for T in added},
        "average [N/m]": added.mean(axis=1),
        "deviation [N/m]": added.std(axis=1),
    }
    data = dataset("row", columns)
    return [Exhibit("table4", data, _verdicts(added), text=report(), one_solver=True)]


def _verdicts(added: pd.DataFrame) -> list[Verdict]:
    """Test the statements about the measured tensions."""
    averages, deviations = added.mean(axis=1).to_numpy(), added.std(axis=1).to_numpy()
    relative = 100 * deviations / averages
    return [
        verdict(
            "apart from very low nip loads the added tension does not depend on T_in, to a good "
            "relative accuracy: standard deviation between the T_in over the average",
            max(relative[1:]),
            at_most(10.0, "%"),
            note="largest from 876 N/m on; by load "
            + ", ".join(f"{value:.0f}" for value in relative)
            + " %",
        ),
        verdict(
            "at the lowest nip load it does",
            relative[0],
            at_least(10.0, "%"),
            note="the same ratio at 350 N/m",
        ),
        verdict(
            "T_in has no systematic influence: chance that scatter alone makes the averages over "
            "the loads differ as they do",
            _chance(added),
            at_least(0.05),
            note="analysis of variance, load and T_in as factors; the averages at T_in = 175, 263 "
            "and 350 N/m are " + ", ".join(f"{mean:.0f}" for mean in added.mean()) + " N/m.  The "
            "thesis did not test this; fifteen points could not show less than some 20 N/m",
        ),
        verdict(
            "the printed averages follow from Table 3: largest distance",
            np.abs(averages - PRINTED_AVERAGES).max(),
            at_most(0.7, "N/m"),
            note="whole N/m are printed",
        ),
        verdict(
            "and the printed standard deviations",
            np.abs(deviations - PRINTED_DEVIATIONS).max(),
            at_most(0.7, "N/m"),
            note="of a sample of three",
        ),
    ]


def _chance(added: pd.DataFrame) -> float:
    """Return the p-value of T_in in a two-way analysis of variance without interaction.

    ``added`` are the tensions of nip loads (rows) by T_in (columns).
    """
    from scipy.special import fdtrc

    values = added.to_numpy()
    loads, tensions = values.shape
    by_tension, whole = values.mean(axis=0), values.mean()
    residuals = values - values.mean(axis=1, keepdims=True) - by_tension + whole
    between = loads * np.sum((by_tension - whole) ** 2) / (tensions - 1)
    freedom = (loads - 1) * (tensions - 1)
    F = between / (np.sum(residuals**2) / freedom)
    return float(fdtrc(tensions - 1, freedom, F))


def report() -> str:
    """Return Table 4 as text."""
    added = added_tensions()
    columns = {"average": added.mean(axis=1), "deviation": added.std(axis=1)}
    return "\n".join(
        [
            "Winding theorem on measured data: wound-on tension less T_in [N/m],",
            "by nip load and T_in [N/m]",
            as_text(added.assign(**columns)),
            f"RMS of the best model without T_in: {best_rms():.1f} N/m",
        ]
    )


def as_text(frame: pd.DataFrame) -> str:
    """Return a table as text, loads as whole numbers, one digit after the decimal point."""

    def whole(name: object) -> object:
        """Return a load as text, other names as they are."""
        return f"{name:.0f}" if isinstance(name, float) else name

    named = frame.rename(columns=whole, index=whole).rename_axis(index=None, columns=None)
    return str(named.to_string(float_format="%.1f", na_rep=""))
