"""Results that several files of tests look at; they are read-only."""

from __future__ import annotations

import pytest
from coarse_solutions import coarse_solution
from thesis_cases import newsprint_nip

import woundon as wo

NODES = 33  # of three meshes, so that errors are estimated


@pytest.fixture(scope="session")
def nip() -> wo.NipResult:
    """A nip without wraps."""
    return coarse_solution(newsprint_nip(), NODES)


@pytest.fixture(scope="session")
def wrapped() -> wo.NipResult:
    """A nip with both wraps."""
    problem = newsprint_nip(roll_wrap=1.0, drum_wrap=0.5, wrap_friction=0.3)
    return coarse_solution(problem, NODES)
