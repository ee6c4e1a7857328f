"""A fit in words, as tables, and as JSON."""

from __future__ import annotations

from collections.abc import Iterator
from math import expm1, isfinite, log, nan
from typing import TYPE_CHECKING, Any

import numpy as np

from ..io.json_texts import json_text

if TYPE_CHECKING:
    import pandas as pd
    import xarray

    from .profiles import ProfileLikelihood

__all__ = ["line", "lines", "remarks", "to_dataset", "to_frame", "to_json"]

MOST_SHOWN = 3  # parameters in one line
_SAVED = (
    *("names", "estimates", "standard_errors", "covariance", "correlation", "rms", "weighted"),
    *("direction", "condition", "effects", "joint_effect", "at_bound", "not_identified"),
    *("minima", "reached", "starts", "solves", "measured", "fitted", "row_outputs", "row_numbers"),
)


def lines(fit: Any) -> list[str]:
    """Return the fit as lines of text: estimates, intervals, minima and correlations."""
    rms_unit = _rms_unit(fit)
    m, p = fit.measured.size, len(fit.names)
    head = (
        f"{m} measured values, {p} fitted {'parameter' if p == 1 else 'parameters'}, "
        f"RMS {_rms(fit, fit.rms):.4g}{rms_unit}; {fit.reached} of {fit.starts} starts converged "
        "to this minimum"
    )
    return [head, *_estimates(fit), *remarks(fit)]


def line(fit: Any) -> str:
    """Return the fit as one line of text."""
    entries = ((n, *_in_table(fit, n, v)) for n, v in zip(fit.names, fit.estimates, strict=True))
    texts = [
        f"{name}={value:.4g} {unit}".rstrip() for name, unit, value in list(entries)[:MOST_SHOWN]
    ]
    hidden = len(fit.names) - MOST_SHOWN
    texts += [f"{hidden} more"] if hidden > 0 else []
    rms = f"RMS {_rms(fit, fit.rms):.4g}{_rms_unit(fit)} of {fit.measured.size} measured values"
    return f"FitResult({', '.join(texts)}; {rms})"


def remarks(fit: Any) -> list[str]:
    """Return remarks on other minima, correlations and combinations that are not identifiable."""
    rms_unit = _rms_unit(fit)
    return [*_minima(fit, rms_unit), *_trade_offs(fit, rms_unit)]


def to_frame(fit: Any) -> pd.DataFrame:
    """Return a row for each parameter, SI units; the interval is open where it has no end."""
    import pandas as pd

    intervals = {profile.name: (profile.low, profile.high) for profile in fit.profiles}
    ends = [intervals.get(name, (nan, nan)) for name in fit.names]
    columns = {
        "estimate": fit.estimates,
        "standard_error": fit.standard_errors,
        "low": [low for low, _ in ends],
        "high": [high for _, high in ends],
        "unit": [_unit(fit, name) for name in fit.names],
    }
    frame = pd.DataFrame(columns, index=pd.Index(fit.names, name="parameter"))
    frame.attrs["long_names"] = {
        "low": "low end of the 95 % profile interval",
        "high": "high end of the 95 % profile interval",
    }
    return frame


def to_dataset(fit: Any) -> xarray.Dataset:
    """Return parameters and their covariance, measured and fitted values; SI units."""
    outputs = list(fit.row_outputs)
    units = [_unit(fit, name) for name in outputs]
    table = to_frame(fit).to_xarray()
    dims = ("parameter", "parameter_2")
    rms_unit = "standard deviations" if fit.weighted else units[0]
    return (
        table.set_coords("unit")
        .assign(
            covariance=(dims, fit.covariance),
            correlation=(dims, fit.correlation),
            measured=("measurement", fit.measured),
            fitted=("measurement", fit.fitted),
        )
        .assign_coords(
            parameter_2=list(fit.names),
            output=("measurement", outputs),
            row=("measurement", list(fit.row_numbers)),
            output_unit=("measurement", units),
        )
        .assign_attrs(rms=fit.rms, rms_unit=rms_unit)
    )


def _unit(fit: Any, name: str) -> str:
    """Return the SI unit of a parameter or an output, '' of a pure number."""
    unit = fit.quantities[name].unit if name in fit.quantities else ""
    return "" if unit == "1" else unit


def _rms_unit(fit: Any) -> str:
    """Return the unit of the RMS with a leading space."""
    if fit.weighted:
        return " standard deviations"
    unit, _ = _in_table(fit, fit.row_outputs[0], 1.0)
    return f" {unit}" if unit else ""


def _rms(fit: Any, value: float) -> float:
    """Return a root mean square in the unit for display."""
    return value if fit.weighted else float(_in_table(fit, fit.row_outputs[0], value)[1])


def _in_table(fit: Any, name: str, value: Any) -> tuple[str, Any]:
    """Return unit (empty if dimensionless) and value, in SI or in chosen units."""
    quantity = fit.quantities.get(name)
    unit, converted = quantity.in_table(value) if quantity else ("", value)
    return "" if unit == "1" else unit, converted


def _estimates(fit: Any) -> Iterator[str]:
    """Yield a line for each parameter: estimate, standard error and profile interval."""
    profiles = {profile.name: profile for profile in fit.profiles}
    width = max(map(len, fit.names))
    for k, name in enumerate(fit.names):
        unit, value = _in_table(fit, name, fit.estimates[k])
        _, error = _in_table(fit, name, fit.standard_errors[k])
        text = f"{name:<{width}}  {value:.4g} {unit}".rstrip()
        if name in fit.not_identified:
            text += "; not identified by the data (standard error above 100 %)"
        elif isfinite(error):
            text += f", standard error {error:.2g} {unit}".rstrip()
            text += f" ({error / abs(value):.0%})" if value else ""
        if name in profiles:
            text += f"; 95 % profile interval {_interval(fit, profiles[name])}"
            if not (isfinite(profiles[name].low) or isfinite(profiles[name].high)):
                text += ": the data do not determine it within its bounds"
        if name in fit.at_bound:
            text += "; at its bound: widen the bounds, or the data do not determine it"
        yield text


def _interval(fit: Any, profile: ProfileLikelihood) -> str:
    ends = (_in_table(fit, profile.name, end) for end in (profile.low, profile.high))
    return " to ".join(
        f"{end:.4g} {unit}".rstrip() if isfinite(end) else "open" for unit, end in ends
    )


def _minima(fit: Any, rms_unit: str) -> Iterator[str]:
    """Yield a line on the second-best local minimum, if there is one."""
    # sorted by the sum of squared residuals; the first ones are the best minimum
    others = fit.minima[fit.reached :]
    for sum_of_squares, values in others[:1]:
        entries = ((n, *_in_table(fit, n, v)) for n, v in zip(fit.names, values, strict=True))
        place = ", ".join(f"{name} {value:.4g} {unit}".rstrip() for name, unit, value in entries)
        rms = _rms(fit, (sum_of_squares / fit.measured.size) ** 0.5)
        yield f"second-best local minimum: RMS {rms:.4g}{rms_unit} at {place}"


def _trade_offs(fit: Any, rms_unit: str) -> Iterator[str]:
    """Yield correlations and the least identified combination of parameters."""
    p = len(fit.names)
    for j in range(p):
        for k in range(j):
            r = fit.correlation[j, k]
            if abs(r) > 0.9:
                yield f"correlation of {fit.names[k]} and {fit.names[j]}: {r:.4f}"
    if p == 1:
        change = f"{_rms(fit, fit.effects[0]):.3g}{rms_unit} (RMS)"
        yield f"+10 % of {fit.names[0]} changes the fitted values by {change}"
        return
    leading = int(np.argmax(np.abs(fit.direction)))
    single, joint = (_rms(fit, effect) for effect in (fit.effects[leading], fit.joint_effect))
    moves = [
        f"{name} {expm1(log(1.1) * part):+.1%}"
        for name, part in zip(fit.names, fit.direction, strict=True)
        if abs(part) > 0.02
    ]
    text = (
        f"{' with '.join(moves)} together change the fitted values by "
        f"{joint:.3g}{rms_unit} (RMS); {fit.names[leading]} +10 % alone by {single:.3g}{rms_unit}"
    )
    if joint < 0.2 * single:
        text = f"nearly non-identifiable combination: {text}"
    yield f"{text}; condition number {fit.condition:.3g}"


def to_json(fit: Any) -> str:
    """Return the fit as JSON, SI units; nan and infinity are null."""
    record: dict[str, Any] = {name: getattr(fit, name) for name in _SAVED}
    record["units"] = {name: quantity.unit for name, quantity in fit.quantities.items()}
    record["profiles"] = {
        p.name: {"low": p.low, "high": p.high, "values": p.values, "rms": p.rms}
        for p in fit.profiles
    }
    if hasattr(fit.problem, "model_dump"):
        record["problem"] = fit.problem.model_dump()
    return json_text(record)
