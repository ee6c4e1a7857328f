"""The pool of workers: newest wins, who dies or hangs is replaced, nobody waits for ever."""

import asyncio
import os
import signal
import threading
import time
from contextlib import asynccontextmanager

import chores
import loops
import pytest

from woundon import kinds
from woundon.app import answers, workers
from woundon.app.refusals import Refusal
from woundon.app.workers import Pool


@asynccontextmanager
async def pool(**more):
    made = Pool(1, chores.nothing, **more)
    await made.open()
    try:
        yield made
    finally:
        made.close()


def run(test):
    """Run a coroutine with a limit of its own: a pool that hangs is a failure."""
    return loops.run(asyncio.wait_for(test, 60))


@pytest.fixture(scope="module")
def with_pool():
    """Run a test of a pool that serves others after it, in a loop that goes on."""
    loop = asyncio.new_event_loop()
    thread = threading.Thread(target=loop.run_forever)
    thread.start()

    def run(test):
        return asyncio.run_coroutine_threadsafe(asyncio.wait_for(test, 60), loop).result()

    shared = Pool(1, chores.nothing)
    run(shared.open())
    yield lambda test: run(test(shared))
    loop.call_soon_threadsafe(shared.close)
    loop.call_soon_threadsafe(loop.stop)
    thread.join()
    loop.close()


def test_an_answer_and_a_fault_come_back(with_pool):
    async def test(own):
        assert await own.run(pow, 2, 10) == 1024
        with pytest.raises(Refusal) as raised:
            await own.run(divmod, 1, 0)
        assert raised.value.status == 500
        assert await own.run(pow, 2, 3) == 8

    with_pool(test)


def test_a_worker_that_dies_gives_one_error_and_the_next_request_is_served(with_pool):
    async def test(own):
        first = await own.run(os.getpid)
        with pytest.raises(Refusal) as raised:
            await own.run(os._exit, 1)
        assert (raised.value.status, raised.value.kind) == (503, "worker-died")
        assert await own.run(os.getpid) != first

    with_pool(test)


def test_a_worker_that_dies_while_it_is_idle_is_nobodys_error(with_pool):
    async def test(own):
        first = await own.run(os.getpid)
        os.kill(first, signal.SIGKILL)
        await asyncio.sleep(0.3)
        assert await own.run(os.getpid) != first

    with_pool(test)


def test_an_interrupt_that_a_library_made_a_fault_of_is_no_fault(capfd):
    async def test():
        async with pool() as own:
            older = asyncio.create_task(
                own.run(chores.turns_every_fault_into_its_own, key="slider")
            )
            await asyncio.sleep(0.2)
            assert await own.run(pow, 2, 10, key="slider") == 1024
            with pytest.raises(Refusal) as raised:
                await older
            assert raised.value.status == 409

    run(test())
    assert "Traceback" not in capfd.readouterr().err


def test_of_one_key_the_newest_request_wins(with_pool):
    async def test(own):
        pid = await own.run(os.getpid)
        under_way = asyncio.create_task(own.run(time.sleep, 30, key="slider"))
        waiting = asyncio.create_task(own.run(time.sleep, 30, key="other"))
        await asyncio.sleep(0.2)
        began = time.monotonic()
        newest = await asyncio.gather(
            own.run(pow, 1, 1, key="other"), own.run(os.getpid, key="slider")
        )
        # interrupted after its grace, not waited for, and by the same process
        assert time.monotonic() - began < 25
        assert newest == [1, pid]
        for old in (under_way, waiting):
            with pytest.raises(Refusal) as raised:
                await old
            assert (raised.value.status, raised.value.kind) == (409, "superseded")

    with_pool(test)


def test_what_is_nearly_done_comes_to_its_end(with_pool):
    """A stream of newer requests, each before the older is done, does not starve a slider."""

    async def test(own):
        await own.run(os.getpid)
        tasks = []
        for _ in range(10):
            tasks.append(asyncio.create_task(own.run(time.sleep, 0.3, key="slider")))
            await asyncio.sleep(0.1)
        done = await asyncio.gather(*tasks, return_exceptions=True)
        assert sum(one is None for one in done) >= 3
        assert any(isinstance(one, Refusal) for one in done)
        assert done[-1] is None

    with_pool(test)


def test_what_takes_too_long_is_ended():
    async def test():
        async with pool(seconds=0.5) as own:
            with pytest.raises(Refusal) as raised:
                await own.run(time.sleep, 30)
            assert raised.value.status == 504
            assert await own.run(pow, 2, 3, seconds=30) == 8

    run(test())


@pytest.mark.skipif(not hasattr(signal, "pthread_sigmask"), reason="signals of POSIX")
def test_a_worker_deaf_to_interruption_is_replaced(monkeypatch, with_pool):
    monkeypatch.setattr(workers, "HEED", 1.0)

    async def test(own):
        pid = await own.run(os.getpid)
        with pytest.raises(Refusal):
            await own.run(chores.is_deaf, seconds=0.5)
        assert await own.run(os.getpid) != pid

    with_pool(test)


def test_more_requests_than_may_wait_are_refused():
    async def test():
        async with pool(waiting=2) as own:
            tasks = [asyncio.create_task(own.run(time.sleep, 0.5)) for _ in range(3)]
            await asyncio.sleep(0.1)
            with pytest.raises(Refusal) as raised:
                await own.run(pow, 1, 1)
            assert (raised.value.status, raised.value.kind) == (503, "busy")
            await asyncio.gather(*tasks)

    run(test())


def test_who_is_gone_is_not_worked_for(with_pool):
    async def test(own):
        task = asyncio.create_task(own.run(time.sleep, 30))
        await asyncio.sleep(0.2)
        task.cancel()
        began = time.monotonic()
        assert await own.run(pow, 2, 2) == 4
        assert time.monotonic() - began < 25

    with_pool(test)


def test_who_is_gone_before_the_work_begins_is_not_worked_for(with_pool):
    """Nor does it cost the worker."""

    async def test(own):
        pid = await own.run(os.getpid)
        for _ in range(5):
            task = asyncio.create_task(own.run(time.sleep, 30))
            await asyncio.sleep(0)  # it is handed out, and the worker has not heard of it
            task.cancel()
            assert await own.run(os.getpid) == pid

    with_pool(test)


def test_a_new_worker_solves_what_takes_no_time(monkeypatch):
    begun = []
    monkeypatch.setattr(answers, "solved", lambda problem, _: begun.append(kinds.of(problem).name))
    monkeypatch.setattr(answers, "state_of", lambda _: None)
    answers.warm_up()
    assert begun == [kind.name for kind in kinds.every() if kind.name != "winding"]
