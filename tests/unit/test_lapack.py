"""LAPACK as SciPy has it, however it was found."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest
import scipy.linalg.lapack
from seldom import seldom

from woundon.contact import lapack

CODE = """
import sys, numpy as np
{first}
from woundon.contact import lapack
assert ("scipy.linalg" in sys.modules) == {loaded}
import scipy.linalg
A, b = np.array([[2.0, 1.0], [1.0, 3.0]]), np.array([3.0, 5.0])
assert np.allclose(lapack.dgesv(A, b)[2], [0.8, 1.4], rtol=1e-15)
assert np.allclose(scipy.linalg.solve(A, b), [0.8, 1.4], rtol=1e-15)
"""


@pytest.mark.parametrize(
    ("first", "loaded"),
    [
        ("", False),
        seldom("import scipy.linalg", True),
        # a SciPy that keeps it elsewhere
        ("from importlib.machinery import PathFinder as P; find = P.find_spec\n"
         "P.find_spec = lambda name, *a: None if name == 'scipy.linalg._flapack' and "
         "'scipy.linalg' not in sys.modules else find(name, *a)", True),
    ],
)  # fmt: skip
def test_it_is_found_before_after_and_without_the_short_way(first: str, loaded: bool):
    code = CODE.format(first=first, loaded=loaded)
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, check=False)
    assert done.stderr == b""


def test_it_is_scipys_to_the_last_bit():
    random = np.random.default_rng(0)
    matrix, right = random.normal(size=(40, 40)), random.normal(size=(40, 3))
    for one, two in zip(lapack.dgesv(matrix, right), scipy.linalg.lapack.dgesv(matrix, right),
                        strict=True):  # fmt: skip
        assert np.array_equal(one, two)
    factor, pivots, _ = lapack.dgetrf(matrix)
    for one, two in zip((factor, pivots), scipy.linalg.lapack.dgetrf(matrix), strict=False):
        assert np.array_equal(one, two)
    told = lapack.dgetrs(factor, pivots, right, trans=1)[0]
    assert np.array_equal(told, scipy.linalg.lapack.dgetrs(factor, pivots, right, trans=1)[0])
