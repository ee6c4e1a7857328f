"""Panels of viscoelastic covers: moduli over the frequency with those of the nip, master curves."""

from __future__ import annotations

from math import pi
from typing import Any

import numpy as np

from ..elasticity.prony_fit import complex_modulus, fit_dynamic_moduli
from ..elasticity.relaxation import modulus_ratio
from ..problems.materials import Material
from ..problems.measured_moduli import DynamicTest, frequency_quantity
from ..quantities import Quantity, pure, stress
from ..studies.master_curve import MasterCurve
from .panels import SERIES, Axis, Curve, Mark, Panel

__all__ = ["master_curve_panels", "moduli"]

Array = np.ndarray

FREQUENCY = frequency_quantity("frequency")
MODULUS = stress("E", "modulus", "MPa")
POINTS = 121  # of a curve over the frequency
# Decades that are drawn below and above the lowest frequency of the pressure of a nip: the response
# depends on those above, and on how far the material is relaxed below.
BELOW, ABOVE = 3.0, 2.0
MARKERS = ("circle", "square", "triangle", "diamond", "ring", "point", "cross")


# ---- in a nip -----------------------------------------------------------------------------------


def moduli(result: Any) -> Panel:
    """Return the panel of storage and loss moduli of all viscoelastic materials of a contact.

    V/2a is the lowest frequency of the pressure that a point of the surface meets in the nip.
    """
    lowest = abs(result.problem.rolling_speed) / result.nip_width
    curves: list[Curve] = []
    for name in result.problem.pair:
        materials = dict.fromkeys(getattr(result.problem, name).materials)
        relaxing = [material for material in materials if material.relaxes]
        for k, material in enumerate(relaxing):
            where = name if len(relaxing) == 1 else f"{name}, material {k + 1}"
            # another colour for each material: each has one dashed curve
            colour = SERIES[sum(each.line == "dashed" for each in curves) % len(SERIES)]
            curves += _moduli_of(material, where, colour, lowest)
    mark = Mark("y", lowest, label="V/2a", colour="ink", line="dotted", alone=False)
    return Panel(
        "moduli",
        Axis("Frequency $f$", FREQUENCY, log=True),
        Axis("Modulus", MODULUS, log=True),
        title="Moduli at the frequencies of the nip, from V/2a on",
        curves=tuple(curves),
        marks=(mark,),
        legend="right",
        width=6.6,
        height=3.4,
    )


def _moduli_of(material: Material, name: str, colour: str, lowest: float) -> list[Curve]:
    """Return the curves of one material over the frequency, and its measured points.

    They are Young's moduli, or shear moduli if the bulk modulus is constant and only the shear
    modulus relaxes.  Frequencies reach from decades below V/2a, or the lowest measured one, to
    decades above it, or the highest measured one.

    Parameters
    ----------
    material : Material
        Viscoelastic.
    name, colour : str
        In the legend.
    lowest : float
        V/2a, the lowest frequency of the nip [Hz].
    """
    measured = material.measured_frequencies or (lowest, lowest)
    low = min(lowest / 10**BELOW, measured[0])
    high = max(lowest * 10**ABOVE, measured[1])
    f = np.geomspace(low, high, POINTS)
    letter, relaxed = "E", getattr(material, "long_term_modulus", material.stiffness.shear)
    if material.bulk_is_constant:
        letter, relaxed = "G", material.stiffness.shear
    # A moving material relaxes over the lengths c = tau V and responds to wave numbers.  At 1 m/s
    # these lengths have the values of the times, and angular frequencies stand for wave numbers.
    complex_moduli = relaxed * modulus_ratio(material.relaxation(1.0), 2 * pi * f)
    curves = []
    if isinstance(material, DynamicTest):
        f_measured, storage, loss = material.measured_moduli
        for k, values in enumerate((storage, loss)):
            curves.append(
                Curve(
                    "moduli",
                    f_measured,
                    values,
                    label=f"measured, {name}",
                    colour=colour,
                    line="none",
                    marker="ring",
                    in_legend=k == 0,
                    opacity=0.5,
                    alone=True,
                )
            )
    return [
        *curves,
        Curve("moduli", f, complex_moduli.real, label=f"${letter}'$ of the {name}", colour=colour),
        Curve(
            "moduli",
            f,
            complex_moduli.imag,
            label=f"${letter}''$ of the {name}",
            colour=colour,
            line="dashed",
        ),
    ]


# ---- master curves ------------------------------------------------------------------------------


def master_curve_panels(curve: MasterCurve) -> list[Panel]:
    """Return the panels of the shifted moduli with the fitted series, and of the shifts."""
    return [_shifted_moduli(curve), _shifts(curve)]


def _shifted_moduli(curve: MasterCurve) -> Panel:
    """Return the panel of E' and E'' of all isotherms over the shifted frequency."""
    curves = []
    for k, T in enumerate(curve.temperatures):
        rows = curve.isotherm == k
        for values, is_storage in ((curve.storage_modulus, True), (curve.loss_modulus, False)):
            curves.append(
                Curve(
                    "isotherm",
                    curve.frequency[rows],
                    values[rows],
                    label=f"$T$ = {T:.4g} {curve.scale}",
                    colour=SERIES[k % len(SERIES)],
                    line="none",
                    marker=MARKERS[k % len(MARKERS)],
                    in_legend=is_storage,
                    opacity=0.5,
                )
            )
    fit = fit_dynamic_moduli(curve.frequency, curve.storage_modulus, curve.loss_modulus)
    f = np.geomspace(curve.frequency[0], curve.frequency[-1], POINTS)
    E = complex_modulus(fit, f)
    curves += [
        Curve("series", f, E.real, label="$E'$, series", colour="ink", width=1.0),
        Curve("series", f, E.imag, label="$E''$, series", colour="ink", line="dashed", width=1.0),
    ]
    return Panel(
        "moduli",
        Axis("Shifted frequency $a f$", FREQUENCY, log=True),
        Axis(f"Moduli at {curve.reference_temperature:g} {curve.scale}", MODULUS, log=True),
        curves=tuple(curves),
        legend="right",
        width=6.6,
        height=3.6,
    )


def _shifts(curve: MasterCurve) -> Panel:
    """Return the panel of log10 a over the temperature, with the law if there is one."""
    points = Curve(
        "shifts",
        curve.temperatures,
        curve.shifts,
        label="isotherms",
        line="none",
        marker="circle",
        y_error=curve.errors,
    )
    T = np.linspace(curve.temperatures[0], curve.temperatures[-1], POINTS)
    law = "Williams, Landel, Ferry" if curve.wlf else "interpolated"
    line = Curve("law", T, curve.shift_at(T), label=law, colour="ink", width=1.0)
    return Panel(
        "shifts",
        Axis("Temperature $T$", Quantity("T", curve.scale, "temperature")),
        Axis("Shift factor $log10 a$", pure("log10 a", "shift factor")),
        curves=(points, line),
        width=4.2,
        height=3.0,
    )
