"""The page as it feels: from a moved slider to the picture, in the system's Chromium.

    python benchmarks/browser.py [--moves 60]

Asked for: slider to picture 60 ms in the median and 120 ms at 95 % for a plain nip, 150 and 300 ms
for a wrapped one; four users at once at most twice these times; a slider beside another's long
study at most twice as slow as alone; a first page within a second and 300 kB.  (The ratio of four
users to one is told too.  On two cores it is above 2 for a page that never waits: each of their
moves takes all the work of one, the browsers' included, which run here as well.)

Measured in the browser itself, from the slider's event to the frame after the numbers and curves
are drawn.  A machine that does other work meanwhile is slower by the load that is printed beside:
the wall time of a dense solve over its processor time, in the same seconds.  Ratios between the
rows of one run hold in spite of it.
"""

from __future__ import annotations

import argparse
import json
import statistics
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import httpx
import numpy as np
from browser_session import browsing
from page_server import serving
from playwright.sync_api import Browser, Page

ASKED = {"nip": (150, 300)}  # [ms] in the median, at 95 %
WEIGHT, FIRST = 300_000, 1.0  # bytes, seconds
USERS = 4
AT_MOST = 2.0  # times what is asked of one user; beside a study, what one alone waits

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
        const began = performance.now()
        slider.dispatchEvent(new Event("input", { bubbles: true }))
        times.push(await drawn - began)
    }
    return times
}"""
FETCHED = """() => {
    const [page] = performance.getEntriesByType("navigation")
    const parts = [page, ...performance.getEntriesByType("resource")]
        .filter(part => !part.name.includes("/api/solve"))
    return [page.loadEventEnd / 1000, parts.reduce((sum, part) => sum + part.encodedBodySize, 0)]
}"""


class Load:
    """How much slower the machine is than idle: wall over processor time of a dense solve."""

    def __init__(self) -> None:
        self.shares: list[float] = []
        self._matrix = np.random.default_rng(1).normal(size=(400, 400))
        self._over = threading.Event()

    def __enter__(self) -> Load:
        self._thread = threading.Thread(target=self._run)
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._over.set()
        self._thread.join()

    def _run(self) -> None:
        while not self._over.wait(0.25):
            wall, own = time.perf_counter(), time.thread_time()
            np.linalg.solve(self._matrix, self._matrix)
            self.shares.append((time.perf_counter() - wall) / (time.thread_time() - own))

    @property
    def factor(self) -> float:
        """The median of them."""
        return statistics.median(self.shares or [float("nan")])


def opened(browser: Browser, address: str, kind: str) -> Page:
    """Return the page of a user of its own, with a case of a kind."""
    page = browser.new_context(viewport={"width": 1280, "height": 800}).new_page()
    page.goto(address)
    page.wait_for_selector(".number-card", timeout=120_000)
    if page.input_value(".kind") != kind:
        page.select_option(".kind", kind)
    page.wait_for_timeout(2000)  # what is asked for at rest is there
    page.evaluate(MOVE, 5)
    return page


def moved(pages: list[Page], moves: int) -> tuple[list[float], float]:
    """Return how long each move took [ms], all pages at once, and the load meanwhile."""
    with Load() as load:
        for page in pages:
            page.evaluate(f"moves => {{ window.moving = ({MOVE})(moves) }}", moves)
        times = [time for page in pages for time in page.evaluate("() => window.moving")]
    return times, load.factor


@contextmanager
def studying(address: str, case: dict[str, Any]) -> Iterator[None]:
    """Let another user run a long study meanwhile."""
    over = {"nip_load": {"from": 1000, "to": 5000, "count": 50},
            "web_tension": {"from": 200, "to": 600, "count": 40}}  # fmt: skip
    ended = threading.Event()

    def run() -> None:
        with httpx.stream("POST", f"{address}/api/sweep", json={"case": case, "over": over},
                          headers={"X-Session": "another-user"}, timeout=600) as told:  # fmt: skip
            for _ in told.iter_lines():
                if ended.is_set():
                    return

    thread = threading.Thread(target=run)
    thread.start()
    time.sleep(1)
    yield
    ended.set()
    thread.join()


def told(what: str, times: list[float], load: float) -> tuple[float, float]:
    """Print a row; return median and 95 %."""
    middle, late = statistics.median(times), float(np.quantile(times, 0.95))
    print(f"{what:<34} {middle:7.0f} {late:7.0f} {load:7.1f} "
          f"{middle / load:9.0f} {late / load:7.0f}", flush=True)  # fmt: skip
    return middle, late


def first_page(browser: Browser, address: str) -> bool:
    """Print when the first page is there, and how much it weighs."""
    with Load() as load:
        context = browser.new_context(viewport={"width": 1280, "height": 800})
        page = context.new_page()
        began = time.perf_counter()
        page.goto(address)
        page.wait_for_selector(".number-card", timeout=120_000)
        picture = time.perf_counter() - began
        seconds, weight = page.evaluate(FETCHED)
        page.wait_for_timeout(1000)  # for the load to be told
        context.close()
    print(f"first page {seconds:.2f} s, with its numbers {picture:.2f} s, {weight / 1e3:.0f} kB; "
          f"load {load.factor:.1f}")  # fmt: skip
    return weight <= WEIGHT and seconds / load.factor <= FIRST


def main() -> int:
    """Measure all of it; return 0 where what is asked for holds, the load taken out, else 1."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--moves", type=int, default=60, help="of the slider in each row")
    moves = parser.parse_args().moves
    with serving() as server, browsing() as browser:
        kinds = httpx.get(f"{server.address}/api/catalogue", timeout=60).json()["kinds"]
        cases = {kind["name"]: kind["example"] for kind in kinds}
        good = first_page(browser, server.address)
        print(f"\n{'slider to picture [ms]':<34} {'median':>7} {'95 %':>7} {'load':>7} "
              f"{'unloaded':>9} {'95 %':>7}")  # fmt: skip
        for kind, (middle, late) in ASKED.items():
            pages = [opened(browser, server.address, kind) for _ in range(USERS)]
            times, load = moved(pages[:1], moves)
            alone = told(f"{kind}, one user", times, load)
            good &= alone[0] / load <= middle and alone[1] / load <= late
            with studying(server.address, cases[kind]):
                times, load = moved(pages[:1], moves)
            beside = told(f"{kind}, beside a long study", times, load)
            times, load = moved(pages, moves)
            four = told(f"{kind}, {USERS} users at once", times, load)
            print(json.dumps({"beside a study": round(beside[0] / alone[0], 2),
                              f"{USERS} users": round(four[0] / alone[0], 2)}))  # fmt: skip
            good &= beside[0] <= AT_MOST * alone[0]
            # what loads the machine is their own work
            good &= four[0] <= AT_MOST * middle and four[1] <= AT_MOST * late
            for page in pages:
                page.context.close()
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
