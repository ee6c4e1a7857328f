"""Outputs vary smoothly with inputs: no jumps with the grid larger than the stated error.

Otherwise a fit ends in a false minimum with confident errors.
"""

from __future__ import annotations

import numpy as np
import pytest
from thesis_cases import paper_nip

import woundon as wo

LOADS = np.geomspace(1000.0, 3000.0, 120)
OUTPUTS = ("nip_induced_tension", "nip_induced_tension_error")


def _scan(loads=LOADS, **options):
    data = wo.sweep(
        paper_nip(winding_force=0.0), {"nip_load": loads}, OUTPUTS, workers=1, **options
    )
    return tuple(data[name].values for name in OUTPUTS)


def _off(values):
    """Return how far each value lies off the chord through its neighbours."""
    return np.abs(np.diff(values, 2)) / 2


@pytest.mark.slow
def test_on_one_grid_there_are_no_jumps():
    """Only kinks, where a node changes its zone: far below the stated error of the grid."""
    own, error = _scan(nodes=33)
    off = _off(own)
    assert np.all(np.diff(own) > 0)
    assert off.max() < 0.05 * np.median(error)
    assert off.max() < 3e-5 * own.max()
    assert np.median(off) < 2e-5 * own.max()


@pytest.mark.slow
def test_between_grids_the_jumps_stay_below_the_stated_error():
    """Where the estimate asks for a finer grid the result moves by the estimated error."""
    NIT, error = _scan()
    off = _off(NIT)
    estimate = np.maximum(np.maximum(error[:-2], error[1:-1]), error[2:])
    assert np.all(off <= estimate)
    assert off.max() < 1e-3 * NIT.max()
    assert np.all(np.diff(NIT) > 0)


@pytest.mark.parametrize("nodes", [33, 65])
def test_warm_and_cold_solves_agree(nodes: int):
    """What a case starts from does not show in its numbers."""
    near = wo.solve(paper_nip(nip_load=1400.0), nodes=nodes)
    far = wo.solve(paper_nip(nip_load=6000.0, winding_force=-300.0), nodes=nodes)
    cold, *warm = (
        wo.solve(paper_nip(nip_load=1500.0), nodes=nodes, start=start)
        for start in (None, near, far)
    )
    for result in warm:
        # the tolerance of the last mesh is 1e-11 of the unknowns
        assert result.nip_induced_tension == pytest.approx(cold.nip_induced_tension, rel=1e-8)
        assert np.array_equal(result.roll_zone, cold.roll_zone)
