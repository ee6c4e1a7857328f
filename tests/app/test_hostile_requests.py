"""The server answers hostile requests without a fault (``hostile_requests.py``)."""

import threading
import time

import hostile_requests
import httpx
import psutil
import pytest


@pytest.mark.parametrize(
    "requests",
    [20, pytest.param(500, marks=(pytest.mark.slow, pytest.mark.campaign))],
)
def test_hostile_requests_end_in_no_fault_of_the_server(process, requests):
    judge = hostile_requests.run(process, requests=requests, seed=3)
    judge.client.close()
    assert judge.faults == []
    assert sum(judge.statuses.values()) >= requests


def test_a_fault_is_recognised():
    """Against an address that answers everything with a 500."""
    judge = hostile_requests.Judge(hostile_requests.Server("http://x", 0))
    transport = httpx.MockTransport(lambda request: httpx.Response(500, text="Traceback"))
    judge.client.close()
    with httpx.Client(base_url="http://x", transport=transport) as judge.client:
        judge.send("damaged", "POST", "/api/solve", content=b"{}")
    assert len(judge.faults) == 2  # the status, and the content type


@pytest.mark.slow
def test_workers_killed_at_work_give_one_error_and_the_next_request_is_served(
    process, cases, slow_nip
):
    """All of them at once, in the midst of a state that takes seconds."""
    answers = []

    def ask():
        answers.append(httpx.post(f"{process.address}/api/solve", json=slow_nip, timeout=120,
                                  params={"nodes": 257}))  # fmt: skip

    def spent():
        return {pid: psutil.Process(pid).cpu_times().user for pid in process.workers()}

    thread, before, limit = threading.Thread(target=ask), spent(), time.monotonic() + 60
    thread.start()
    while not any(
        now > before.get(pid, 0.0) + 0.3 for pid, now in spent().items()
    ):  # one works at it
        assert time.monotonic() < limit
        time.sleep(0.02)
    killed = [psutil.Process(pid) for pid in process.workers()]
    for worker in killed:
        worker.kill()
    psutil.wait_procs(killed, timeout=60)
    thread.join()
    answer = answers[0].json()
    assert (answer["status"], answer["type"]) == (503, "/problems/worker-died")
    assert "send the request again" in answer["detail"]
    for path in ("solve", "python"):  # of the one and of the other workers
        again = httpx.post(f"{process.address}/api/{path}", json=cases["nip"], timeout=120)
        assert again.status_code == 200
