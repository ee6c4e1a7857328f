"""Every number of reports, pages and figures is the same in all systems of units.

Evidence: invariance.  The reports of all kinds as text and as HTML, and all panels, are rendered in
several systems; their numbers agree after conversion to SI, up to their last printed digits.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from coarse_solutions import coarse_solution
from rendered_numbers import (
    differing_artists,
    differing_numbers,
    numbers,
    text_of_page,
    units_in,
    units_of_figure,
)
from slow_cases import slow_case
from viscoelastic_cases import cover, rubber

import woundon as wo
from woundon import kinds
from woundon.io.chosen_units import units_of
from woundon.problems.units import MILL
from woundon.quantities import in_chosen_units, outputs, walk
from woundon.report.drawing import draw_figure
from woundon.report.html_report import report_file
from woundon.report.plots import figure_for_file
from woundon.report.result_panels import array_panels, panels_of
from woundon.report.scale_drawing import REACH, scale_drawing
from woundon.report.schedule_report import schedule_parts
from woundon.report.sweep_panels import plot_sweep
from woundon.report.terminal import plain_text
from woundon.studies.api import study_of
from woundon.studies.run import Workers, run_study

NIP, PAIR, ROLL = wo.NipProblem.example(), wo.RollerProblem.example(), wo.RollProblem.example()
WINDING = wo.WindingProblem.example()
COVERED = NIP.replace(drum=cover(rubber()), web_speed=5.0)
LIMITS = wo.Limits(
    web_strength=800.0, blocking_pressure=3e5, core_pressure=1e6, slack_tension=300.0,
    yield_strain=0.01, compression=0.0,
)  # fmt: skip
PROBLEMS = {
    "nip": NIP.replace(drum_wrap=0.5, web_speed=30.0, air=wo.Air(roughness=3e-6)),
    "nip without wraps": NIP.replace(roll_wrap=0.0),
    "nip with a soft cover": COVERED,
    # outside the limits of validity: the warnings have numbers
    "nip under a large load": NIP.replace(nip_load=4e4, web_tension=8e3),
    "rollers": PAIR,
    "rollers, static": PAIR.replace(motion="static"),
    "roll": ROLL.replace(
        wound_on_tension=wo.Taper(start=350.0, taper=0.3), gauge_excess=0.01, density=650.0,
        temperature_change=-10.0,
    ),
    "winding": WINDING.replace(
        radius=0.1, roll_body="linear", limits=LIMITS, gauge_excess=0.01, density=650.0,
        winding_force=50.0,
    ),
}  # fmt: skip
METRIC = {"N/m": "kN/m", "Pa": "bar", "m": "um", "m/s": "m/s", "rad": "rad"}


def by_name(units: dict[str, str]) -> Any:
    """Choose a unit for every field and output of an SI unit, each by its name."""
    places = [p for kind in kinds.every() for p in (*walk(kind.problem), *outputs(kind.result))]
    return wo.units(
        {p.path: units[p.quantity.unit] for p in places if p.quantity and p.quantity.unit in units}
    )


SYSTEMS: dict[str, Callable[[], Any]] = {
    "mill": lambda: units_of(["mill"]),
    # one output in another unit than those on the same axis
    "single": lambda: wo.units(
        wound_on_tension="pli", nip_width="um", hoop_stress="psi", winding_force="pli"
    ),
    "metric": lambda: by_name(METRIC),
    "SI": lambda: units_of(["SI"]),
}


def cases(**quick: str) -> Any:
    """Return all kinds in all systems as parameters; those that are not named as quick are slow."""
    pairs = [(kind, system) for kind in PROBLEMS for system in SYSTEMS]
    rows = [
        pair if pair[1] in quick.get(pair[0], "").split() else slow_case(*pair) for pair in pairs
    ]
    return pytest.mark.parametrize(("kind", "system"), rows)


def in_both(system: str, render: Callable[[], Any]) -> tuple[Any, Any]:
    """Return what is rendered in the usual units and in those of a system."""
    usual = render()
    with SYSTEMS[system]():
        return usual, render()


def assert_no_other_units(system: str, units: set[str]) -> None:
    """Assert that no number is left in a unit which the mills do not use."""
    assert units
    if system == "mill":
        assert units & set(MILL) == set()


def joined(text: str) -> str:
    return " ".join(text.split())  # paragraphs may be wrapped elsewhere


# the winding has the same rows on its page
@cases(nip="mill single", rollers="mill", roll="mill")
def test_reports_have_the_same_numbers(kind: str, system: str) -> None:
    result = coarse_solution(PROBLEMS[kind], 33)
    usual, chosen = in_both(system, lambda: joined(str(result)))
    assert differing_numbers(usual, chosen) == []
    assert_no_other_units(system, units_in(chosen))


@cases(nip="mill", rollers="mill", roll="mill", winding="mill")
def test_pages_have_the_same_numbers(kind: str, system: str, monkeypatch) -> None:
    # the figures are compared by themselves
    monkeypatch.setattr("woundon.report.html_report._figure", lambda *_: iter(()))
    result = coarse_solution(PROBLEMS[kind], 33)
    usual, chosen = in_both(system, lambda: text_of_page(report_file([result, result])))
    assert differing_numbers(usual, chosen) == []
    assert_no_other_units(system, units_in(chosen))


@cases(nip="mill", rollers="mill", roll="mill")
def test_panels_show_the_same_numbers(kind: str, system: str) -> None:
    result = coarse_solution(PROBLEMS[kind], 33)
    for panel in panels_of(result):
        pair = in_both(system, lambda panel=panel: figure_for_file(result, panels=panel))
        assert (panel, differing_artists(*pair)) == (panel, [])
        assert_no_other_units(system, units_of_figure(pair[1]))


def test_a_value_in_a_legend_has_the_unit_of_its_axis() -> None:
    with SYSTEMS["single"]():
        figure = figure_for_file(coarse_solution(PROBLEMS["nip"], 33), panels="wrap_tension")
    assert units_of_figure(figure) == {"N/m", "deg"}


@pytest.mark.parametrize("system", ["mill", "single"])
def test_panels_of_any_array_show_the_same_numbers(system: str) -> None:
    """The panels of a kind without panels of its own: several arrays on an axis."""
    result = coarse_solution(PROBLEMS["roll"], 33)
    for maker in array_panels(result).values():
        pair = in_both(system, lambda maker=maker: draw_figure([[maker.make(result)]]))
        assert differing_artists(*pair) == []


@pytest.mark.parametrize("kind", ["nip", "rollers"])
def test_the_drawing_to_scale_has_the_same_lengths(kind: str) -> None:
    """Its scale bar has a round length in the unit that is displayed."""
    result = coarse_solution(PROBLEMS[kind], 33)
    figures = in_both("mill", lambda: scale_drawing(result))
    texts = [[text.get_text() for axes in figure.axes for text in axes.texts] for figure in figures]
    bars = [next(text for text in part if text[:1].isdigit()) for part in texts]
    others = ["\n".join(text for text in part if text not in ("", *bars)) for part in texts]
    assert differing_numbers(*others) == []
    for figure, bar in zip(figures, bars, strict=True):
        (length,) = numbers(bar)
        surface, *_, drawn = (np.ptp(line.get_xdata()) for line in figure.axes[1].lines)
        expected = length.value / (2 * REACH * result.half_width)  # of the width of the drawing
        assert drawn / surface == pytest.approx(expected, rel=1e-12)  # rounding
    assert bars[1].endswith(" in")


# ---- texts that results keep --------------------------------------------------------------------


def test_warnings_are_kept_in_the_usual_units_and_displayed_in_the_chosen_ones():
    result = coarse_solution(PROBLEMS["nip under a large load"], 33)
    with SYSTEMS["mill"]():
        again = wo.solve(result.problem, nodes=33)
        assert " psi" in str(result)
    assert again.warnings == result.warnings
    assert any(" MPa" in text for text in result.warnings)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("depth 2.54 mm, 12 layers", "depth 0.1 in, 12 layers"),
        ("moduli are 6.894757 and 68.94757 GPa", "moduli are 1000 and 10000 ksi"),
        ("from 25.4 to 50.8 mm", "from 1 to 2 in"),
        ("a speed of 5 m/s, 3 m wide, 2 kg/m^2", "a speed of 984 fpm, 9.84 ft wide, 2 kg/m^2"),
        # a change of temperature: no offset
        ("cooled by -20 K to -10 K", "cooled by -36 degF to -18 degF"),
        ("E0 mm, 2h mm", "E0 mm, 2h mm"),
        # errors that a report quotes
        ("the law ends at 6894.757 [Pa], below", "the law ends at 1 [psi], below"),
        (
            "radius: 6.096 is out of range; must be >= 0.3048 and <= 3.048 [m], on the roll of K2",
            "radius: 20 is out of range; must be >= 1 and <= 10 [ft], on the roll of K2",
        ),
    ],
)
def test_texts_of_results_are_converted(text: str, expected: str) -> None:
    assert in_chosen_units(text) == text
    with SYSTEMS["mill"]():
        assert in_chosen_units(text) == expected


# ---- studies ------------------------------------------------------------------------------------

LOADS = [4e3, 6e3, 8e3, 1e4]
MEASURED = {
    "nip_width": {"load": LOADS, "nip_width [mm]": [0.65, 0.8, 0.92, 1.03],
                  "nip_width +- [mm]": [0.02] * 4},
    "pressure": {"measured_radius [mm]": [60.0, 80.0, 100.0, 120.0],
                 "pressure [kPa]": [190.0, 210.0, 240.0, 260.0], "pressure +- [kPa]": [5.0] * 4},
    # larger than the predictions, and rising faster: with causes and needed changes
    "larger": {"load": [4e3, 6e3, 8e3, 1e4, 1.2e4],
               "nip_width [mm]": [0.15, 0.193, 0.232, 0.267, 0.3], "nip_width +- [mm]": [0.01] * 5},
    # one value, from which no causes are derived
    "length": {"diameter [mm]": [200.0], "length [m]": [420.0]},
}  # fmt: skip
FREE = PAIR.replace(tangential_load=0.0)
LEAN = {"nodes": 17}
PLANNED = [
    wo.Measurement("peak_pressure", {"lower.radius": [0.3, 0.5]}, "1 %"),
    wo.Measurement("half_width", {"load": "90 kN/m"}, "0.1 mm"),
    wo.Measurement("nip_width", {"friction": 0.3, "lower.radius": "400 mm"}, "10 %"),
]


def preview_of_window() -> wo.OperatingWindow:
    """Return the first, coarse map of an operating window; no nip is solved."""
    problem = WINDING.replace(
        radius=0.08, tension_law="friction", limits=wo.Limits(web_strength=700.0),
        **{"web.thickness": 500e-6},
    )  # fmt: skip
    previews: list[wo.OperatingWindow] = []

    def stop(window: wo.OperatingWindow) -> None:
        previews.append(window)
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        wo.operating_window(
            problem, web_tension=(150.0, 450.0), nip_load=(500.0, 3e3),
            uncertain={"roll_friction": 0.3}, samples=100, workers=1, preview=stop,
        )  # fmt: skip
    return previews[0]


STUDIES: dict[str, Callable[[], Any]] = {
    "find": lambda: wo.find(FREE, "load", nip_width="0.8 mm", **LEAN),
    "fit": lambda: wo.fit(
        FREE, MEASURED["nip_width"], ["upper.material.youngs_modulus"], starts=1, **LEAN
    ),
    "comparison": lambda: wo.compare(FREE, MEASURED["nip_width"], **LEAN),
    "comparison over the radius": lambda: wo.compare(ROLL, MEASURED["pressure"]),
    "comparison with causes": lambda: wo.compare(FREE, MEASURED["larger"], **LEAN),
    "comparison of a length": lambda: wo.compare(ROLL, MEASURED["length"], rtol=1e-3),
    "window": preview_of_window,
    "plan": lambda: wo.next_experiment(
        FREE, {"upper.radius": "5 %", "load": "10 %"}, PLANNED[::2], draws=0, **LEAN
    ),
    "Sobol' indices": lambda: wo.global_sensitivity(
        FREE, {"load": (5e4, 1e5), "upper.radius": (0.2, 0.3)}, ["half_width"],
        samples=4, workers=1, **LEAN,
    ),
    "schedule": lambda: wo.optimise_schedule(
        ROLL.replace(**{"stack.radial": 8e6}),  # does not harden: quickly solved
        {"wound_on_tension": (200.0, 400.0)}, limits=LIMITS, evaluations=5,
        options={"rtol": 3e-3},
    ),
}  # fmt: skip


@pytest.mark.parametrize("study", STUDIES)
def test_studies_show_the_same_numbers(study: str) -> None:
    outcome = STUDIES[study]()
    usual, mill = in_both("mill", lambda: joined("\n".join([*outcome.lines(), repr(outcome)])))
    assert differing_numbers(usual, mill) == []
    assert_no_other_units("mill", units_in(mill))
    assert differing_artists(*in_both("mill", outcome.plot)) == []


@pytest.mark.parametrize("measured", ["larger", "length"])
def test_texts_of_a_comparison_are_kept_in_the_usual_units(measured: str):
    problem, options = (ROLL, {"rtol": 1e-3}) if measured == "length" else (FREE, LEAN)
    usual, mill = in_both("mill", lambda: wo.compare(problem, MEASURED[measured], **options))
    assert mill.explanations == usual.explanations
    assert mill.notes == usual.notes
    texts = [*usual.notes, *(text for e in usual.explanations for text in (e.finding, *e.causes))]
    assert units_in("\n".join(texts)) >= {"length": {"m"}, "larger": {"mm", "MPa"}}[measured]


def test_planned_measurements_are_named_with_units():
    series, text, several = PLANNED
    usual = (
        "2 values of peak_pressure at lower.radius 300 mm to 500 mm",
        "half_width at load 9e+04 N/m",
        "nip_width at friction 0.3, lower.radius 400 mm",
    )
    assert (series.name, text.name, several.name) == usual
    with SYSTEMS["mill"]():
        assert text.name == "half_width at load 513.9 pli"
        assert (series.stored_name, text.stored_name, several.stored_name) == usual
    with wo.units(load="kN/m"):
        assert text.name == "half_width at load 90 kN/m"
    # a position in a roll, and a text that needs the thickness of the web
    tab = wo.Measurement("pull_tab_pressure", {"radius": 0.1, "web_tension": "2 MPa"}, "5 %")
    assert tab.name == "pull_tab_pressure at radius 100 mm, web_tension 2 MPa"
    assert wo.Measurement("nip_width", {"load": 1.0}, "5 %", label="first").name == "first"


def test_a_field_has_the_same_unit_in_all_kinds():
    """So that a measurement without a problem can be named with the units of its state."""
    units: dict[str, set[str]] = {}
    for kind in kinds.every():
        for place in walk(kind.problem):
            if place.quantity is not None:
                units.setdefault(place.path, set()).add(place.quantity.unit)
    assert {name: known for name, known in units.items() if len(known) > 1} == {}


def test_sweeps_show_the_same_numbers():
    study = study_of(FREE, {"load": LOADS}, ["nip_width"], options=LEAN)
    table = run_study(*study, Workers(1))
    assert differing_artists(*in_both("mill", lambda: plot_sweep(table, "nip_width"))) == []


def test_schedules_for_a_target_pressure_show_the_same_numbers():
    design = wo.design_tension(ROLL, 150e3)
    roll = wo.solve(design.problem, rtol=1e-3)

    usual, mill = in_both("mill", lambda: plain_text(schedule_parts(design, roll)))
    assert differing_numbers(usual, mill) == []
    assert_no_other_units("mill", units_in(mill))
