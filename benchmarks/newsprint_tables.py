"""Tables and figures of the newsprint experiment, of what hardening_newsprint.py has kept."""

from __future__ import annotations

import json
from collections.abc import Iterator
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from hardening_newsprint import FITTED, HELD, SHORT, TABLES, measured, rms
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter
from scipy.special import fdtrc

from woundon.report.figures import COLOURS, style
from woundon.studies.profiles import threshold

__all__ = ["floor", "lack_of_fit", "misses_figure", "profiles_figure", "tables"]

NAMES = {
    "confined": "linear, confined, (183)", "linear": "linear, wrapped",
    "quarter": "hardening, wrapped", "drum": "hardening, half a turn on the drum too",
    "wound": "hardening, drum too, wound pressure",
}  # fmt: skip
UNITS = {"K1": ("kPa", 1e-3), "G": ("MPa", 1e-6), "A_rr": ("MPa", 1e-6)}
HALVED = ("quarter", "drum")  # where P0 is as large as K1


def floor() -> tuple[float, int]:
    """Return the least RMS of any model in which web tension only passes through, and its freedom.

    Its predictions are one number a nip load, at best the mean of what was measured [N/m].
    """
    data = measured()
    added = data["measured"] - data["web_tension"]
    rest = added - added.groupby(data["nip_load"]).transform("mean")
    return rms(rest), len(data) - data["nip_load"].nunique()


def lack_of_fit(value: float, fitted: int) -> float:
    """Return how probable a model's RMS would be if it were right, by the F test of lack of fit.

    The scatter of the web tensions, of one nip load, is taken for that of repeated measurements.
    """
    pure, free = floor()
    loads = measured()["nip_load"].nunique()
    m = len(measured())
    lack = max(m * (value**2 - pure**2), 0.0) / (loads - fitted)
    return float(fdtrc(loads - fitted, free, lack / (m * pure**2 / free)))


# ---- tables -------------------------------------------------------------------------------------


def tables(folder: Path) -> None:
    """Write benchmarks/newsprint/*."""
    kept = [json.loads(path.read_text()) for path in sorted(folder.glob("point-*.json"))]
    _write("one_point.md", _one_point(kept))
    _misses(kept).to_csv(TABLES / "misses.csv", index=False, float_format="%.1f")
    fits = {path.stem.split("-", 1)[1].rsplit("-", 1)[0]: json.loads(path.read_text())
            for path in sorted(folder.glob("fit-*.json"))}  # fmt: skip
    _write("full.md", _full(fits))
    _write("held.md", _held(fits))
    _profiles(fits).to_csv(TABLES / "profiles.csv", index=False, float_format="%.5g")


def _write(name: str, lines: Iterator[str]) -> None:
    text = "\n".join(lines) + "\n"
    (TABLES / name).write_text(text, encoding="utf-8")
    print(text)


def _one_point(kept: list[dict[str, Any]]) -> Iterator[str]:
    yield "| roll | K1 + P0 [kPa] | fitted | RMS of all 15 | of the other 14 | F test |"
    yield "| --- | ---: | ---: | ---: | ---: | ---: |"
    for model, name in NAMES.items():
        own = [one for one in kept if one["setting"] == model]
        for one in sorted(own, key=lambda one: one.get("Q", 0.0)):
            Q, misses = one.get("Q"), np.array(one["misses"])
            told = _told(one["fitted"], one["value"]) if one["fitted"] else "Table 2"
            p = lack_of_fit(rms(misses), bool(one["fitted"]))
            others = f"{rms(misses[~_fitted()]):.1f}" if one["fitted"] else ""
            where = "" if Q is None else f"{Q / 1e3:.0f}"
            yield f"| {name} | {where} | {told} | {rms(misses):.1f} | {others} | {p:.3f} |"


def _fitted() -> np.ndarray:
    data = measured()
    return ((data["nip_load"] == FITTED[0]) & (data["web_tension"] == FITTED[1])).to_numpy()


def _told(name: str, value: float) -> str:
    unit, factor = UNITS.get(name, ("", 1.0))
    return f"{name} = {value * factor:.3g} {unit}".rstrip()


def _misses(kept: list[dict[str, Any]]) -> pd.DataFrame:
    """Return the misses at all points, a column a model [N/m]."""
    table = measured()[["nip_load", "web_tension", "measured"]]
    for one in kept:
        Q = one.get("Q")
        of = one["fitted"] or "printed"
        table[f"{one['setting']} {of if Q is None else f'{Q / 1e3:.0f}'}"] = one["misses"]
    return table


def _full(fits: dict[str, dict[str, Any]]) -> Iterator[str]:
    yield "| roll | fitted | estimate | 95 % interval | RMS | F test |"
    yield "| --- | --- | ---: | ---: | ---: | ---: |"
    for model, name in NAMES.items():
        own = {f.removeprefix(model).strip("-"): fit for f, fit in fits.items()
               if f.split("-")[0] == model}  # fmt: skip
        if not own:
            continue
        fit = min(own.values(), key=lambda fit: fit["rms"])
        p = lack_of_fit(fit["rms"], len(fit["names"]))
        ends = [name, f"{fit['rms']:.2f}", f"{p:.3f}"]
        for field, value in zip(fit["names"], fit["estimates"], strict=True):
            label, factor = _label(model, SHORT[field])
            profile = own.get(SHORT[field], {"profiles": {}})["profiles"].get(field)
            told = "" if profile is None else " to ".join(
                _end(profile[end], factor) for end in ("low", "high")
            )  # fmt: skip
            bound = " (bound)" if field in fit["at_bound"] else ""
            yield (f"| {ends[0]} | {label} | {value * factor:.3g}{bound} | {told} | {ends[1]} | "
                   f"{ends[2]} |")  # fmt: skip
            ends = ["", "", ""]


def _held(fits: dict[str, dict[str, Any]]) -> Iterator[str]:
    yield "| held | K1 + P0 [kPa] | K2 | RMS |"
    yield "| --- | ---: | ---: | ---: |"
    for short in HELD:
        for value, fit in _of_held(fits, short):
            unit, factor = UNITS.get(short, ("", 1.0))
            name = {"exponent": "exponent of G"}.get(short, short)
            Q, K2 = 2e-3 * fit["estimates"][0], fit["estimates"][1]
            held = f"{name} = {value * factor:.3g} {unit}".rstrip()
            yield f"| {held} | {Q:.0f} | {K2:.0f} | {fit['rms']:.2f} |"


def _of_held(fits: dict[str, dict[str, Any]], short: str) -> list[tuple[float, dict[str, Any]]]:
    """Return the fits with a parameter held, by its value."""
    start = f"held-{short}="
    found = ((float(name.removeprefix(start)), fit) for name, fit in fits.items()
             if name.startswith(start))  # fmt: skip
    printed = [(10e6, fits["held-exponent=0"])] if short == "G" else []
    return sorted([*found, *printed], key=lambda pair: pair[0])


def _end(value: float | None, factor: float) -> str:
    return "open" if value is None or not isfinite(value) else f"{value * factor:.3g}"


def _label(model: str, short: str) -> tuple[str, float]:
    """Return what a parameter is called, with its unit, and the factor to that."""
    unit, factor = UNITS.get(short, ("", 1.0))
    if short == "K1" and model in HALVED:
        return "K1 + P0 [kPa]", 2 * factor
    return f"{short} [{unit}]" if unit else short, factor


def _profiles(fits: dict[str, dict[str, Any]]) -> pd.DataFrame:
    """Return the profiles: value, RMS and its 95 % limit."""
    rows = []
    for name, fit in fits.items():
        for field, profile in fit["profiles"].items():
            model = name.split("-")[0]
            label, factor = _label(model, SHORT[field])
            limit = _limit(min(profile["rms"]), len(fit["names"]))
            rows += [
                (model, label, value * factor, off, limit)
                for value, off in zip(profile["values"], profile["rms"], strict=True)
            ]
    for short in HELD:
        found, (label, factor) = _of_held(fits, short), _label("held", short)
        if found:
            limit = _limit(min(fit["rms"] for _, fit in found), 3)
            rows += [("held", label, value * factor, fit["rms"], limit) for value, fit in found]
    return pd.DataFrame(rows, columns=["model", "parameter", "value", "rms", "limit"])


def _limit(value: float, fitted: int) -> float:
    """Return the RMS up to which a parameter is within its 95 % interval."""
    return float(np.sqrt(threshold(value**2, len(measured()) - fitted, weighted=False)))


# ---- figures ------------------------------------------------------------------------------------

CURVES = {
    "confined printed": ("confined, (183), as printed", ":"),
    "linear printed": ("linear, wrapped, as printed", "-."),
    "quarter 100": ("hardening, K1 + P0 = 100 kPa, one point fitted", "-"),
    "wound 100": ("the same in a wound roll, K1 = 100 kPa", "--"),
}
PARAMETERS = {"K1 + P0 [kPa]": "quarter", "K2": "quarter", "G [MPa]": "held", "exponent": "held"}


def misses_figure() -> Any:
    """Return what the nip adds to the tension, measured and by four models."""
    table = pd.read_csv(TABLES / "misses.csv")
    with style():
        figure = Figure(figsize=(6.4, 4.2), layout="constrained")
        axes = figure.subplots()
        for marker, (tension, own) in zip("v^o", table.groupby("web_tension"), strict=True):
            added = own["measured"] - tension
            axes.plot(own["nip_load"] / 1e3, added, marker, color="black", mfc="none",
                      label=f"measured, T_in = {tension:.0f} N/m")  # fmt: skip
        for k, (column, (name, line)) in enumerate(CURVES.items()):
            added = table["measured"] + table[column] - table["web_tension"]
            mean = added.groupby(table["nip_load"]).mean()
            axes.plot(mean.index / 1e3, mean, line, color=COLOURS[k], label=name)
        axes.set_xlabel("nip load P [kN/m]")
        axes.set_ylabel("tension at the load cell less T_in [N/m]")
        axes.legend()
    return figure


def profiles_figure() -> Any:
    """Return the profiles of the hardening roll's parameters."""
    table = pd.read_csv(TABLES / "profiles.csv")
    with style():
        figure = Figure(figsize=(7.0, 5.2), layout="constrained")
        for axes, (name, model) in zip(figure.subplots(2, 2).flat, PARAMETERS.items(), strict=True):
            own = table[(table["model"] == model) & (table["parameter"] == name)]
            axes.plot(own["value"], own["rms"], ".-", color=COLOURS[0], label="others refitted")
            axes.axhline(own["limit"].iloc[0], color=COLOURS[1], ls="--", label="95 % limit")
            axes.axhline(floor()[0], color="grey", ls=":", label="floor of any such model")
            if name != "exponent":
                axes.set_xscale("log")
                axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
                axes.xaxis.set_major_formatter("{x:g}")
                axes.xaxis.set_minor_formatter(NullFormatter())
            axes.set_xlabel(f"{name} of G" if name == "exponent" else name)
            axes.set_ylabel("RMS [N/m]")
        axes.legend()
    return figure
