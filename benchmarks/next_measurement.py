"""The thesis's Table 3 with a roll that hardens: what its tensions identify, and what is next.

    python benchmarks/next_measurement.py [--nodes 25] [--draws 2]

The roll is a stack under the pressure that winding leaves in it; K2 is that of the fit to the point
(3502, 350) with K1 = 100 kPa (benchmarks/newsprint/one_point.md).  Unknown are K2, G and the
friction between web and roll, each to 50 %.  Completed are the fifteen wound-on tensions with their
standard deviation of 11.6 N/m.  The table is in docs/howto/next_measurement.md.
"""

from __future__ import annotations

import argparse

from hardening_newsprint import measured, nip, stack_of

import woundon as wo

K2, SUM, WOUND_ON = 49.3, 100e3, 700.0  # K2 [1], K1 [Pa], wound-on tension [N/m]
DEVIATION = 11.6  # of one wound-on tension, by the analysis of variance [N/m]
UNKNOWN = {"roll.stack.radial.K2": "50 %", "roll.stack.shear": "50 %", "roll_friction": "50 %"}
STATE = {"nip_load": 3502.0, "web_tension": 350.0}


def plan(nodes: int, draws: int) -> wo.NextExperiment:
    """Return the choice among five measurements."""
    data = measured()
    states = {name: data[name].tolist() for name in ("nip_load", "web_tension")}
    roll = wo.RollProblem(
        core=wo.Core(radius=0.0445, stiffness=1e9), radius=0.1, stack=stack_of(SUM, K2),
        web_thickness=66e-6, wound_on_tension=WOUND_ON,
    )  # fmt: skip
    tab = wo.Measurement(
        "pull_tab_pressure", {"radius": 0.07}, "20 %", problem=roll,
        fields={"stack.radial.K2": "roll.stack.radial.K2"}, label="one pull-tab pressure",
    )  # fmt: skip
    return wo.next_experiment(
        nip(*STATE.values(), K2, SUM, setting="wound").replace(drum_wrap=0.0), UNKNOWN,
        [
            tab,
            wo.Measurement("nip_width", STATE, "0.1 mm", label="one nip width"),
            wo.Measurement("approach", STATE, "5 um", label="one approach"),
            wo.Measurement("wound_on_tension", STATE, DEVIATION, label="one wound-on tension"),
        ],
        completed=[wo.Measurement("wound_on_tension", states, DEVIATION)],
        nodes=nodes, draws=draws,
    )  # fmt: skip


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--nodes", type=int, default=25)
    parser.add_argument("--draws", type=int, default=0)
    given = parser.parse_args()
    found = plan(given.nodes, given.draws)
    print(found)
    print("after one candidate alone, and its scores at the points drawn:")
    alone = zip(found.candidates, found.first_errors, found.first_scores.T, strict=True)
    for candidate, errors, scores in alone:
        print(f"  {candidate.name}: {(100 * errors).round(1)} % {scores.round(3)}")
