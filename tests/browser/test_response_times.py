"""Time from a moved slider to the drawn answer, in the browser, and growth of the server.

Times are those of ``slider_moves.py``, divided by the load of the machine.
"""

from __future__ import annotations

import threading
import time
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager

import httpx
import numpy as np
import pytest
from slider_moves import move_sliders, open_page

pytestmark = pytest.mark.campaign
MOVES, USERS = 60, 4
# requested: 60 ms in the median, 95 % within 100 ms; of four users, and next to another's study,
# twice as much
MEDIAN, LATE, FACTOR = 60.0, 100.0, 2.0
GROWTH = 30.0  # MB of all processes between the halves of a soak: a tenth of one worker


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


def move(pages):
    """Return the times of moves of the sliders of all pages at once, without the load [ms]."""
    moves, load = move_sliders(pages, MOVES)
    return moves[:, 0] / load


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
