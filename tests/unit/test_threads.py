"""A solve has one BLAS thread, and leaves the process those it had."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import pytest
from threadpoolctl import threadpool_info, threadpool_limits

import woundon.parallel
from woundon.parallel import VARIABLES, one_thread


def _blas_threads() -> set[int]:
    return {part["num_threads"] for part in threadpool_info() if part["user_api"] == "blas"}


@pytest.fixture
def three(monkeypatch: pytest.MonkeyPatch):
    """A process whose libraries have three threads each, and whose environment says nothing."""
    import scipy.linalg  # noqa: F401  # brings the second library

    for name in VARIABLES:
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(woundon.parallel, "_LIMIT", woundon.parallel._Limit())
    with threadpool_limits(limits=3, user_api="blas"):
        yield


@pytest.mark.usefixtures("three")
def test_a_function_has_one_thread_as_long_as_it_runs():
    assert _blas_threads() == {3}
    assert one_thread(_blas_threads)() == {1}
    assert _blas_threads() == {3}


@pytest.mark.usefixtures("three")
def test_the_threads_come_back_after_an_error():
    @one_thread
    def fails() -> None:
        raise ArithmeticError

    with pytest.raises(ArithmeticError):
        fails()
    assert _blas_threads() == {3}


@pytest.mark.usefixtures("three")
def test_another_that_ends_meanwhile_does_not_take_the_limit_away():
    @one_thread
    def outer() -> set[int]:
        with ThreadPoolExecutor(1) as pool:
            pool.submit(one_thread(_blas_threads)).result()
        return _blas_threads()

    assert outer() == {1}
    assert _blas_threads() == {3}
