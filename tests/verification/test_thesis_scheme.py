"""The thesis's own scheme (sec. 3.4) against its values by an independent program.

Table 1 with a half-plane roll, P = 1900 N/m, F = 100 N/m: even nodes, backward differences, the web
tension lumped at the cells' ends.  The limit is 134.753 N/m.
"""

from __future__ import annotations

import numpy as np
import pytest
from published import solve_as_published
from thesis_cases import paper_nip

import woundon as wo
from woundon.contact.panagiotopoulos import panagiotopoulos
from woundon.contact.stick_slip import StickSlip

PROBLEM = paper_nip(roll=wo.HalfPlane(radius=0.3, material=wo.material("paper")))
LUMPED = {50: 111.07, 100: 119.39, 200: 125.26, 400: 129.16}  # independent program
PRINTED = {50: 110.913, 100: 119.285, 200: 125.198, 400: 129.160}  # (121) as printed, measured here
LIMIT = 134.7534  # the graded scheme with 1025 nodes


@pytest.mark.parametrize("nodes", LUMPED)
def test_values_by_pivoting(nodes: int) -> None:
    result = wo.solve_nip(PROBLEM, scheme="thesis", nodes=nodes)
    # asked: 0.3 %; the reference's two decimals are in fact met
    assert result.nip_induced_tension == pytest.approx(LUMPED[nodes], abs=0.006)
    assert result.residuals.largest <= 1e-8


@pytest.mark.parametrize("nodes", [50, 100, 200])
def test_values_by_the_published_process(nodes: int) -> None:
    """Steps 1 to 9 of sec. 3.6 from a cold start end in the very state that pivoting finds."""
    published = wo.solve_nip(PROBLEM, scheme="thesis", nodes=nodes, algorithm="panagiotopoulos")
    pivoting = wo.solve_nip(PROBLEM, scheme="thesis", nodes=nodes)
    # both solve the same linear system in the end, and the width to 3e-9 of the load
    assert published.nip_induced_tension == pytest.approx(pivoting.nip_induced_tension, rel=1e-8)
    np.testing.assert_array_equal(published.roll_zone, pivoting.roll_zone)
    np.testing.assert_array_equal(published.drum_zone, pivoting.drum_zone)
    assert published.residuals.largest <= 1e-8
    assert published.iterations > pivoting.iterations


@pytest.mark.parametrize("nodes", PRINTED)
def test_values_with_the_printed_web_coefficients(nodes: int) -> None:
    """Eq. (121) as printed changes NIT by less than 0.15 %; its fault is elsewhere, see below."""
    result = wo.solve_nip(PROBLEM, scheme="thesis-printed", nodes=nodes)
    assert result.nip_induced_tension == pytest.approx(PRINTED[nodes], abs=6e-4)
    assert result.nip_induced_tension == pytest.approx(LUMPED[nodes], rel=1.5e-3)
    assert result.residuals.largest <= 1e-8


def test_the_published_process_with_the_printed_coefficients_may_not_settle() -> None:
    """It goes on for ever at M = 200 and is not passed off as a solution."""
    for nodes in (50, 100):
        result = wo.solve_nip(
            PROBLEM, scheme="thesis-printed", nodes=nodes, algorithm="panagiotopoulos"
        )
        assert result.nip_induced_tension == pytest.approx(PRINTED[nodes], abs=6e-4)
    with pytest.raises(wo.NotConverged, match=r"CYCLE|LIMIT"):
        wo.solve_nip(PROBLEM, scheme="thesis-printed", nodes=200, algorithm="panagiotopoulos")


def test_the_printed_coefficients_make_the_traction_oscillate_ahead_of_the_slip_zone() -> None:
    """In stick, neighbouring rows of (121) give q_l + 4 q_(l-1) + q_(l-2) = rhs, root -3.73.

    So ahead of point C, where the drum starts to slip, the tractions alternate about their smooth
    course by tens of kPa and die backwards by a factor of 3.73 a node (measured: 3.72, 3.74).  With
    the tension lumped they do not.
    """

    def steps(scheme: str) -> np.ndarray:
        result = wo.solve_nip(PROBLEM, scheme=scheme, nodes=200)
        last = int(np.nonzero(result.drum_zone == wo.Zone.STICK)[0][-1])
        return np.diff((result.drum_traction + result.roll_traction)[last - 4 : last + 1])

    printed, lumped = steps("thesis-printed"), steps("thesis")
    # three steps away the smooth course, 25 Pa a node, is 4 % of what is left
    np.testing.assert_allclose(printed[1:] / printed[:-1], -(2 + np.sqrt(3)), rtol=0.06)
    assert np.all(lumped > 0)
    # the last step is the slip zone's own, the last but one shows the artefact alone
    assert abs(printed[-2]) > 500 * lumped[-2]


def test_it_nears_the_limit_slowly() -> None:
    """The strain at the trailing edge is taken half a cell inside, where p ~ sqrt(distance).

    The local order is 0.62, 0.69 and 0.76 here, and 0.86 at M = 1600: 7 % off at M = 200.
    """
    misses = [
        LIMIT - wo.solve_nip(PROBLEM, scheme="thesis", nodes=M).nip_induced_tension
        for M in (50, 100, 200, 400)
    ]
    orders = np.log2(np.array(misses[:-1]) / misses[1:])
    assert np.all((orders > 0.5) & (orders < 0.8))
    assert misses[2] == pytest.approx(0.07 * LIMIT, rel=0.02)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_published_process_settles_tractions_of_one_sign(sign: float) -> None:
    """All stuck, (1 + S K) q = -(c0 + S p0): the pressure, and q with it, settles step by step."""
    own = np.eye(3)
    problem = StickSlip(
        own, -0.2 * own, sign * np.array([0.7, 0.5, 0.6]), np.ones(3), sign * 0.4 * own,
        friction=np.full(3, 10.0), faces=1,
    )  # fmt: skip
    found = panagiotopoulos(problem)
    exact = -(problem.offset - 0.2) / (1 - sign * 0.08)
    assert (np.sign(exact) == -sign).all()
    # the process stops at changes of 1e-12; each step is 0.08 of the one before
    np.testing.assert_allclose(found.traction, exact, rtol=1e-11)


@pytest.mark.parametrize("nodes", [200, 400])
def test_a_load_far_below_the_figures_is_met_exactly(nodes: int) -> None:
    """1 N/m, where the web is a quarter as thick as the nip is wide: the limit that fig. 16 tells.

    A step to its half width that is taken for straight leaves 1e-7 of the laws.
    """
    result = wo.solve(paper_nip(winding_force=0.0, nip_load=1.0), scheme="thesis", nodes=nodes)
    assert result.residual <= 1e-8


def test_the_published_procedure_is_what_it_is_compared_with() -> None:
    """The one that benchmarks run: sums cut at 20 000 terms, of kernels summed exactly here."""
    told, _ = solve_as_published(paper_nip(), nodes=50)
    exact = wo.solve_nip(paper_nip(), scheme="thesis-printed", nodes=50).nip_induced_tension
    assert told == pytest.approx(exact, rel=1e-3)  # what the terms left out are worth, 3.4e-4
