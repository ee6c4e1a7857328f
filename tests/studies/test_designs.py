"""Which cases a study solves, and in which order."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from woundon.studies.cases import bisection_order, make_cases, serpentine, tour
from woundon.studies.sobol import saltelli_cases


@given(st.lists(st.integers(1, 5), min_size=1, max_size=4), st.randoms())
def test_a_grid_is_walked_one_step_at_a_time(shape, random):
    axes = list(range(len(shape)))
    random.shuffle(axes)
    path = serpentine(shape, axes)
    assert sorted(path) == list(range(int(np.prod(shape))))
    steps = np.abs(np.diff(np.unravel_index(path, shape), axis=1)).sum(axis=0)
    assert np.all(steps == 1)


@given(st.integers(1, 200), st.integers(1, 4), st.integers(0, 99))
def test_orders_of_a_table_take_every_row_once(rows, columns, seed):
    points = np.random.default_rng(seed).random((rows, columns))
    for order in (bisection_order(points), tour(points)):
        assert sorted(order) == list(range(rows))


def test_chunks_of_a_table_are_compact():
    points = np.random.default_rng(1).random((1024, 2))
    table = make_cases({"a": points[:, 0], "b": points[:, 1]}, "table")
    walked = [
        np.linalg.norm(np.diff(points[chunk.cases], axis=0), axis=1) for chunk in table.chunks()
    ]
    random = np.linalg.norm(np.diff(points, axis=0), axis=1)
    assert np.mean(np.concatenate(walked)) < 0.12 * np.mean(random)  # 0.09; sqrt(1/1024) = 0.03


def test_chunks_hold_every_case_once_and_hang_on_the_design_alone():
    grids = [make_cases({"a": range(7), "b": [1.0, 2.0, 3.0]}) for _ in range(2)]
    one, two = ([chunk.cases.tolist() for chunk in grid.chunks(4)] for grid in grids)
    assert sorted(np.concatenate(one)) == list(range(21))
    assert one == two
    assert [len(cases) for cases in one] == [4, 4, 4, 4, 4, 1]


def test_nested_fields_take_the_rarest_steps():
    (chunk,) = make_cases({"load": [1, 2, 3], "roll.material.shear": [5, 6]}).chunks()
    shears = [inputs["roll.material.shear"] for inputs in chunk.inputs]
    assert np.count_nonzero(np.diff(shears)) == 1


def test_a_latin_hypercube_has_one_case_in_every_stratum():
    over = {"a": (0.0, 1.0), "b": (1.0, 16.0, "log")}
    values = make_cases(over, "latin-hypercube", 16, seed=5).frame
    assert sorted((values["a"] * 16).astype(int)) == list(range(16))
    assert sorted((np.log2(values["b"]) * 4).astype(int)) == list(range(16))


def test_a_seed_repeats_a_design_and_another_one_does_not():
    draws = [make_cases({"a": (0.0, 1.0)}, "sobol", 8, seed).frame["a"] for seed in (1, 1, 2)]
    assert np.array_equal(draws[0], draws[1])
    assert not np.array_equal(draws[0], draws[2])


def test_saltellis_scheme_swaps_one_column_at_a_time():
    cases = saltelli_cases({"a": (0.0, 1.0), "b": (0.0, 1.0)}, 8, seed=0)
    a, b = (cases.frame[name].to_numpy().reshape(4, 8) for name in "ab")
    assert np.array_equal(a[2], a[1])  # A with a from B
    assert np.array_equal(b[2], b[0])
    assert np.array_equal(a[3], a[0])
    assert np.array_equal(b[3], b[1])
