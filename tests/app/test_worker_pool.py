"""The pool of workers: newest wins, who dies or hangs is replaced, nobody waits for ever."""

import asyncio
import os
import signal
import sys
import threading
import time
from contextlib import asynccontextmanager

import coroutines
import process_tasks
import pytest

from woundon import kinds
from woundon.app import computations, worker_pool
from woundon.app.request_errors import RequestError
from woundon.app.worker_pool import Pool


@asynccontextmanager
async def pool(**more):
    made = Pool(1, process_tasks.nothing, **more)
    await made.open()
    try:
        yield made
    finally:
        made.close()


def run(test):
    """Run a coroutine with a limit of its own: a pool that hangs is a failure."""
    return coroutines.run(asyncio.wait_for(test, 60))


@pytest.fixture(scope="module")
def with_pool():
    """Run a test of a pool that serves others after it, in a loop that goes on."""
    loop = asyncio.new_event_loop()
    thread = threading.Thread(target=loop.run_forever)
    thread.start()

    def run(test):
        return asyncio.run_coroutine_threadsafe(asyncio.wait_for(test, 60), loop).result()

    shared = Pool(1, process_tasks.nothing)
    run(shared.open())
    yield lambda test: run(test(shared))
    loop.call_soon_threadsafe(shared.close)
    loop.call_soon_threadsafe(loop.stop)
    thread.join()
    loop.close()


def test_an_answer_and_a_fault_come_back(with_pool):
    async def test(own):
        assert await own.run(pow, 2, 10) == 1024
        with pytest.raises(RequestError) as raised:
            await own.run(divmod, 1, 0)
        assert raised.value.status == 500
        assert await own.run(pow, 2, 3) == 8

    with_pool(test)


def test_a_worker_that_dies_gives_one_error_and_the_next_request_is_served(with_pool):
    async def test(own):
        first = await own.run(os.getpid)
        with pytest.raises(RequestError) as raised:
            await own.run(os._exit, 1)
        assert (raised.value.status, raised.value.kind) == (503, "worker-died")
        assert await own.run(os.getpid) != first

    with_pool(test)


def test_a_worker_that_dies_while_it_is_idle_is_nobodys_error(with_pool):
    async def test(own):
        first = await own.run(os.getpid)
        os.kill(first, signal.SIGKILL)
        while not own._slots[0].worker._executor._flags.broken:  # loky has heard of it
            await asyncio.sleep(0.01)
        assert await own.run(os.getpid) != first

    with_pool(test)


def test_of_one_key_the_newest_request_wins(with_pool, monkeypatch):
    monkeypatch.setattr(worker_pool, "PATIENCE", 60.0)

    async def test(own):
        pid = await own.run(os.getpid)
        under_way = asyncio.create_task(own.run(process_tasks.waits, 600, key="slider"))
        waiting = asyncio.create_task(own.run(process_tasks.waits, 600, key="other"))
        await asyncio.sleep(0)  # both have come
        newest = await asyncio.gather(
            own.run(pow, 1, 1, key="other"), own.run(os.getpid, key="slider")
        )
        # the older one is cancelled after its grace, not waited for, and by the same process
        assert newest == [1, pid]
        for old in (under_way, waiting):
            with pytest.raises(RequestError) as raised:
                await old
            assert (raised.value.status, raised.value.kind) == (409, "superseded")

    with_pool(test)


def test_what_is_nearly_done_comes_to_its_end(with_pool, monkeypatch, tmp_path):
    """A stream of newer requests, each before the older is done, does not starve a slider."""
    monkeypatch.setattr(worker_pool, "GRACE", 60.0)
    work = process_tasks.waits_for_release

    async def test(own):
        for number in range(3):
            folder = tmp_path / str(number)
            folder.mkdir()
            tasks = []
            for k in range(3):
                tasks.append(asyncio.create_task(own.run(work, k, str(folder), key="slider")))
                await asyncio.sleep(0)  # it has come
            (folder / process_tasks.RELEASE).touch()
            done = await asyncio.gather(*tasks, return_exceptions=True)
            assert isinstance(done[1], RequestError)  # it waited when a newer one came
            assert done[0] == 0
            assert done[2] == 2

    with_pool(test)


def test_what_takes_too_long_is_ended():
    async def test():
        async with pool(seconds=0.5) as own:
            with pytest.raises(RequestError) as raised:
                await own.run(time.sleep, 30)
            assert raised.value.status == 504
            own.seconds = 30  # a new process is started
            assert await own.run(pow, 2, 3) == 8

    run(test())


def test_a_worker_that_does_not_end_its_cancelled_work_is_replaced(monkeypatch, with_pool):
    """A solve that reports no progress, or is in C code."""
    monkeypatch.setattr(worker_pool, "PATIENCE", 0.5)

    async def test(own):
        pid = await own.run(os.getpid)
        with monkeypatch.context() as patch:
            patch.setattr(own, "seconds", 0.5)
            with pytest.raises(RequestError) as raised:
                await own.run(time.sleep, 30)
        assert raised.value.status == 504
        assert await own.run(os.getpid) != pid

    with_pool(test)


def test_a_worker_is_bounded_and_stands_back(tmp_path):
    if sys.platform != "linux":
        pytest.skip("limits of Linux")

    async def test():
        async with pool(nice=3) as own:
            first = await own.run(process_tasks.limits)
            with pytest.raises(RequestError):
                await own.run(os._exit, 1)
            # a process that replaces another too
            return first, await own.run(process_tasks.limits)

    assert run(test()) == ((worker_pool.MEMORY, os.nice(0) + 3),) * 2


def test_a_worker_that_holds_much_memory_is_replaced(with_pool):
    """As after a solve with a thousand nodes, whose matrices the process would keep."""

    async def test(own):
        first = await own.run(os.getpid)
        assert await own.run(process_tasks.keeps_memory, 10**6) == first
        assert await own.run(process_tasks.keeps_memory, worker_pool.RELEASE) == first
        assert await own.run(os.getpid) != first

    with_pool(test)


def test_a_worker_starts_where_there_are_neither_limits_nor_priorities(monkeypatch):
    """As on Windows."""
    monkeypatch.delattr(os, "nice", raising=False)
    monkeypatch.setitem(sys.modules, "resource", None)
    begun = []
    worker_pool._prepare(5, lambda: begun.append(True))
    assert begun == [True]


def test_more_requests_than_may_wait_are_rejected():
    async def test():
        async with pool(waiting=2) as own:
            tasks = [asyncio.create_task(own.run(time.sleep, 0.5)) for _ in range(3)]
            await asyncio.sleep(0)  # all have come
            with pytest.raises(RequestError) as raised:
                await own.run(pow, 1, 1)
            assert (raised.value.status, raised.value.kind) == (503, "busy")
            await asyncio.gather(*tasks)

    run(test())


def test_who_is_gone_is_not_worked_for(with_pool, tmp_path):
    async def test(own):
        task = asyncio.create_task(own.run(process_tasks.waits_for_release, 0, str(tmp_path)))
        while not list(tmp_path.iterdir()):  # it has begun
            await asyncio.sleep(0.01)
        task.cancel()
        assert await own.run(pow, 2, 2) == 4

    with_pool(test)


def test_who_is_gone_before_the_work_begins_is_not_worked_for(with_pool, monkeypatch):
    """Nor does it cost the worker."""
    monkeypatch.setattr(worker_pool, "PATIENCE", 60.0)

    async def test(own):
        pid = await own.run(os.getpid)
        for _ in range(5):
            task = asyncio.create_task(own.run(process_tasks.waits, 30))
            await asyncio.sleep(0)  # it is handed out, and the worker has not heard of it
            task.cancel()
            assert await own.run(os.getpid) == pid

    with_pool(test)


def test_a_new_worker_solves_what_takes_no_time(monkeypatch):
    begun = []
    monkeypatch.setattr(
        computations, "solved", lambda problem, _: begun.append(kinds.of(problem).name)
    )
    monkeypatch.setattr(computations, "state_of", lambda _: None)
    computations.warm_up()
    assert begun == [kind.name for kind in kinds.every() if kind.name != "winding"]
