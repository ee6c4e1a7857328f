"""The model against the experiment: wound-on tension of newsprint, thesis Tables 3 and 4.

Fifteen measured points, five nip loads by three web tensions.  One modulus is fitted to one of the
points, the other fourteen are predicted.  The measured tension that the nip adds scatters between
the web tensions, which no model with the winding theorem can follow: the floor.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq
from thesis_cases import measured_tensions, newsprint_nip

import woundon as wo
from woundon.jorkama2001.estimate import rig_tension

Array = np.ndarray
POINTS = measured_tensions()
LOADS, TENSIONS, MEASURED = (
    np.array([point[name] for point in POINTS]) for name in ("nip_load", "web_tension", "measured")
)
FITTED = (LOADS == 3502.0) & (TENSIONS == 350.0)
FLOOR = 9.5  # N/m, of any theory without influence of T_in
PRINTED = 11.9  # N/m, of the theory that the thesis prints


def rms(misses: Array) -> float:
    return float(np.sqrt(np.mean(misses**2)))


def theory(thickness: float, **moduli: float) -> Array:
    """Return eq. (183), the web led off after a quarter turn, at the fifteen points [N/m].

    By the winding theorem five solved nips stand for fifteen.
    """
    material = {f"{part}.material.{name}": value for name, value in moduli.items()
                for part in ("web", "roll")}  # fmt: skip
    nip = newsprint_nip(**{"web.thickness": thickness}, **material)
    added = {P: rig_tension(wo.solve(nip.replace(nip_load=P))) - 350.0 for P in set(LOADS)}
    return TENSIONS + [added[P] for P in LOADS]


def test_the_measured_points() -> None:
    assert len(POINTS) == 15
    assert sorted(set(LOADS)) == [350.0, 876.0, 1751.0, 3502.0, 5837.0]
    assert sorted(set(TENSIONS)) == [175.0, 263.0, 350.0]
    (fitted,) = (point for point, there in zip(POINTS, FITTED, strict=True) if there)
    assert (fitted["measured"], fitted["thesis_theory"]) == (700.0, 699.0)


def test_the_winding_theorem_on_measured_tensions() -> None:
    """Table 4: the added tension depends on the nip load, hardly on the web tension."""
    added = [(MEASURED - TENSIONS)[load == LOADS] for load in sorted(set(LOADS))]
    averages = [float(np.mean(values)) for values in added]
    # the thesis rounds to whole N/m, in Table 3 from which ours is computed and again in Table 4
    assert averages == pytest.approx([72, 142, 230, 345, 459], abs=0.7)
    deviations = [float(np.std(values, ddof=1)) for values in added]
    assert deviations == pytest.approx([17, 10, 13, 9, 7], abs=0.7)
    assert averages == sorted(averages)


def test_what_the_thesis_reached_and_what_can_be_reached() -> None:
    printed = np.array([point["thesis_theory"] for point in POINTS])
    assert rms(printed - MEASURED) == pytest.approx(PRINTED, abs=0.05)
    added = MEASURED - TENSIONS
    best = [float(np.mean(added[load == LOADS])) for load in LOADS]
    assert rms(best - added) == pytest.approx(FLOOR, abs=0.05)


# (modulus, 2h): fitted value [MPa], RMS over 15 and over the 14 predicted points [N/m]
FITS = {
    ("shear", 66e-6): (6.36, 13.3, 13.8),
    ("radial", 66e-6): (42.95, 13.1, 13.5),
    ("shear", 57e-6): (9.93, 12.1, 12.6),
    ("radial", 57e-6): (27.19, 12.1, 12.5),
}


@pytest.mark.parametrize(("modulus", "thickness"), FITS)
def test_the_one_point_fit_predicts_the_other_points(modulus: str, thickness: float) -> None:
    def too_high(value: float) -> float:
        nip = {f"{part}.material.{modulus}": value for part in ("web", "roll")}
        nip["web.thickness"] = thickness
        return rig_tension(wo.solve(newsprint_nip(**nip))) - 700.0

    value, of_all, predicted = FITS[modulus, thickness]
    fit = brentq(too_high, 0.5e6 * value, 2e6 * value, xtol=1.0)
    # NIT is known to 0.1 % at the default nodes; the modulus goes with about its second power
    assert fit / 1e6 == pytest.approx(value, rel=3e-3)
    misses = theory(thickness, **{modulus: fit}) - MEASURED
    assert rms(misses) == pytest.approx(of_all, abs=0.1)
    assert rms(misses[~FITTED]) == pytest.approx(predicted, abs=0.1)
    # the fitted point is met, and the others as well as the theory printed in the thesis meets them
    assert misses[FITTED] == pytest.approx(0.0, abs=0.01)
    assert FLOOR < rms(misses) < 1.15 * PRINTED
