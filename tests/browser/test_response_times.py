"""Time from a moved slider to the drawn answer, in the browser, and growth of the server.

Measured in the browser from the slider's event to the frame after the numbers are drawn.  Times are
divided by the load of the machine: wall time over processor time of a dense solve, measured at the
same time.
"""

from __future__ import annotations

import statistics
import threading
import time
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from typing import Any

import httpx
import numpy as np
import pytest

pytestmark = pytest.mark.campaign
MOVES, USERS = 60, 4
# requested: 95 % within 100 ms; of four users, and next to another's study, twice as much
MEDIAN, LATE, FACTOR = 75.0, 100.0, 2.0
GROWTH = 30.0  # MB of all processes between the halves of a soak: a tenth of one worker

MOVE = """async moves => {
    const slider = document.querySelector("[data-path=nip_load] .slider")
    const number = document.querySelector(".number-card .value")
    const times = []
    for (let k = 0; k < moves; k++) {
        const drawn = new Promise(done => {
            const watch = new MutationObserver(() => {
                watch.disconnect()
                requestAnimationFrame(() => setTimeout(() => done(performance.now())))
            })
            watch.observe(number, { attributes: true, attributeFilter: ["data-si"] })
        })
        slider.value = 300 + 5 * (k % 80)
        const start = performance.now()
        slider.dispatchEvent(new Event("input", { bubbles: true }))
        times.push(await drawn - start)
    }
    return times
}"""


@contextmanager
def load() -> Iterator[list[float]]:
    """Collect ratios of wall to processor time of a dense solve; 1 on an idle machine."""
    matrix = np.random.default_rng(1).normal(size=(400, 400))
    over, ratios = threading.Event(), list[float]()

    def measure() -> None:
        while not over.wait(0.25):
            wall, own = time.perf_counter(), time.thread_time()
            np.linalg.solve(matrix, matrix)
            ratios.append((time.perf_counter() - wall) / (time.thread_time() - own))

    thread = threading.Thread(target=measure)
    thread.start()
    yield ratios
    over.set()
    thread.join()


def open_page(browser: Any, address: str) -> Any:
    page = browser.new_context(viewport={"width": 1280, "height": 800}).new_page()
    page.goto(address)
    page.wait_for_selector(".number-card", timeout=120_000)
    page.wait_for_timeout(2000)  # background requests of the first page are complete
    page.evaluate(MOVE, 5)
    return page


def move(pages: list[Any]) -> np.ndarray:
    """Move the sliders of all pages at once; return the times without the load [ms]."""
    with load() as ratios:
        for page in pages:
            page.evaluate(f"moves => {{ window.moving = ({MOVE})(moves) }}", MOVES)
        times = [one for page in pages for one in page.evaluate("() => window.moving")]
    return np.array(times) / statistics.median(ratios)


@contextmanager
def long_study(address: str) -> Iterator[None]:
    """Run a long study of another user."""
    case = httpx.get(f"{address}/api/catalogue", timeout=60).json()["kinds"][0]["example"]
    over = {"nip_load": {"from": 1000, "to": 5000, "count": 50},
            "web_tension": {"from": 200, "to": 600, "count": 40}}  # fmt: skip
    ended = threading.Event()

    def run() -> None:
        study, headers = {"case": case, "over": over}, {"X-Session": "another-user"}
        url = f"{address}/api/sweep"
        with httpx.stream("POST", url, json=study, headers=headers, timeout=600) as answer:
            for _ in answer.iter_lines():
                if ended.is_set():
                    return

    thread = threading.Thread(target=run)
    thread.start()
    time.sleep(1)
    yield
    ended.set()
    thread.join()


def test_a_slider_is_answered_in_time_for_one_user_four_and_next_to_a_study(browser, address):
    pages = [open_page(browser, address) for _ in range(USERS)]
    one = move(pages[:1])
    assert np.median(one) <= MEDIAN
    assert np.quantile(one, 0.95) <= LATE
    with long_study(address):
        assert np.median(move(pages[:1])) <= FACTOR * np.median(one)
    four = move(pages)
    assert np.median(four) <= FACTOR * MEDIAN
    assert np.quantile(four, 0.95) <= FACTOR * LATE


def test_twenty_requests_a_second_for_ten_minutes_do_not_grow_the_server(process):
    kinds = httpx.get(f"{process.address}/api/catalogue", timeout=60).json()["kinds"]
    cases = {kind["name"]: kind["example"] for kind in kinds}
    statuses, memory = Counter[int](), list[float]()

    def send(client: httpx.Client, number: int) -> None:
        kind, field = (("nip", "nip_load"), ("rollers", "load"))[number % 4 == 2]
        case = cases[kind] | {field: cases[kind][field] * (0.8 + 0.4 * (number % 97) / 97)}
        session = {"X-Session": f"soak-user-{number % 8}"}
        path, body, query = "solve", case, {}
        if number % 50 == 7:
            path, query = "curve", {"field": field}
        elif number % 50 == 19:
            body = case | {field: -1}
        elif number % 200 == 33:
            path, body = "sweep", {"case": case, "over": {field: [case[field], 1.1 * case[field]]}}
        answer = client.post(f"/api/{path}", json=body, params=query, headers=session)
        statuses[answer.status_code] += 1

    start, number, sent = time.monotonic(), 0, []
    with (
        httpx.Client(base_url=process.address, timeout=120) as client,
        ThreadPoolExecutor(16) as pool,
    ):
        while time.monotonic() - start < 600:
            sent.append(pool.submit(send, client, number))
            number += 1
            if number % 300 == 0:
                memory.append(sum(process.memory().values()))
            time.sleep(max(0.0, start + number / 20 - time.monotonic()))
    for one in sent:
        one.result()
    assert set(statuses) <= {200, 422, 503}
    half = len(memory) // 2
    assert max(memory[half:]) - max(memory[:half]) <= GROWTH
