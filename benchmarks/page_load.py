"""What a server of the page takes: how quickly it answers, to whom, and whether it grows.

    python benchmarks/page_load.py latency              one user and four, beside a long study
    python benchmarks/page_load.py soak --minutes 10    20 requests a second: no growth

latency    from the request of a slider to the whole answer over the loopback, median and 95 %: a
           plain nip and a wrapped one; as ratios to one user alone, four users at once, and one
           beside another's long study.  The wall clock of a busy machine says little: the ratios,
           and the part that is not the solver's, say more.
soak       states, curves, refusals, studies begun and left, in turn; memory every half minute.  The
           last half must hold no more than the first half did, but for what is said.
"""

from __future__ import annotations

import argparse
import json
import statistics
import sys
import threading
import time
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import httpx
from page_server import Server, serving

GROWTH = 30.0  # MB of all processes between the halves of a soak: a tenth of one worker


# ---- latency ----------------------------------------------------------------------------------


def slider(address: str, case: dict[str, Any], moves: int, session: str) -> list[tuple[float, ...]]:
    """Return (seconds to the answer, of these in the solver's worker) for each move."""
    told = []
    with httpx.Client(base_url=address, headers={"X-Session": session}, timeout=120) as client:
        for move in range(moves + 5):
            moved = case | {"nip_load": 3000.0 + 7 * move}
            began = time.perf_counter()
            answer = client.post("/api/solve", json=moved)
            seconds = time.perf_counter() - began
            told.append((seconds, answer.raise_for_status().json()["seconds"]))
    return told[5:]


def _shares(told: list[tuple[float, ...]]) -> tuple[float, float, float]:
    """Return the median, the 95th percentile, and the median beside the worker's part [ms]."""
    whole = sorted(seconds for seconds, _ in told)
    beside = statistics.median(seconds - worked for seconds, worked in told)
    return 1e3 * statistics.median(whole), 1e3 * whole[int(0.95 * len(whole))], 1e3 * beside


def latency(server: Server, moves: int) -> bool:
    """Print how quickly states come."""
    kinds = httpx.get(f"{server.address}/api/catalogue").json()["kinds"]
    cases = {kind["name"]: kind["example"] for kind in kinds}
    good = True
    for name in ("nip",):
        alone = _shares(slider(server.address, cases[name], moves, "latency-0"))
        _print(f"{name}, one user", alone, alone)
        with ThreadPoolExecutor(4) as pool:
            of = [pool.submit(slider, server.address, cases[name], moves, f"latency-{k}")
                  for k in range(4)]  # fmt: skip
            four = _shares([one for user in of for one in user.result()])
        _print(f"{name}, four users", four, alone)
        beside = _shares(_beside_a_study(server, cases, name, moves))
        _print(f"{name}, beside a study", beside, alone)
        good = good and beside[0] <= 2 * alone[0]
    return good


def _print(what: str, told: tuple[float, ...], alone: tuple[float, ...]) -> None:
    median, most, beside = told
    print(f"{what:30} median {median:6.1f} ms, 95 % {most:6.1f} ms, beside the solver "
          f"{beside:5.1f} ms, {median / alone[0]:4.2f} x one user alone", flush=True)  # fmt: skip


def _beside_a_study(server: Server, cases: Any, name: str, moves: int) -> list[tuple[float, ...]]:
    """Return the slider's times while all workers of studies are busy with another's study."""
    study = {
        "case": cases["nip"],
        "over": {"nip_load": {"from": 2000, "to": 4000, "count": 2500}},
    }
    session, stop = {"X-Session": "long-study"}, threading.Event()

    def go_on() -> None:
        with httpx.stream("POST", f"{server.address}/api/sweep", json=study, headers=session,
                          timeout=600) as answer:  # fmt: skip
            for _ in answer.iter_lines():
                if stop.is_set():
                    return

    thread = threading.Thread(target=go_on)
    thread.start()
    time.sleep(1.0)
    try:
        return slider(server.address, cases[name], moves, "latency-0")
    finally:
        stop.set()
        httpx.post(f"{server.address}/api/cancel", headers=session)
        thread.join()


# ---- soak -------------------------------------------------------------------------------------


def soak(server: Server, minutes: float, rate: float) -> bool:
    """Send requests for so long; return whether nothing grew and nothing failed."""
    kinds = httpx.get(f"{server.address}/api/catalogue").json()["kinds"]
    cases = {kind["name"]: kind["example"] for kind in kinds}
    statuses, memory = Counter[str](), list[tuple[float, float]]()
    began, number = time.monotonic(), 0
    with httpx.Client(base_url=server.address, timeout=120) as http, ThreadPoolExecutor(16) as pool:
        while (now := time.monotonic() - began) < 60 * minutes:
            pool.submit(_one, http, cases, number, statuses)
            number += 1
            if number % int(30 * rate) == 0:
                held = server.memory()
                memory.append((held["server"], held["workers"]))
                told = ", ".join(f"{name} {size:.0f} MB" for name, size in held.items())
                print(f"{now:5.0f} s, {number} requests, {dict(statuses)}; {told}", flush=True)
            time.sleep(max(0.0, began + number / rate - time.monotonic()))
    half = len(memory) // 2
    if half < 1:
        return "5" not in {status[0] for status in statuses}
    first, last = (max(map(sum, part)) for part in (memory[:half], memory[half:]))
    print(f"{dict(statuses)}; the first half held {first:.0f} MB at most, the last {last:.0f} MB")
    failed = sum(count for status, count in statuses.items() if status in ("500", "fault"))
    return last - first <= GROWTH and not failed


def _one(client: httpx.Client, cases: Any, number: int, statuses: Counter[str]) -> None:
    """Send one of a user's requests."""
    kind = "rollers" if number % 4 == 2 else "nip"
    field = "load" if kind == "rollers" else "nip_load"
    case = cases[kind] | {field: cases[kind][field] * (0.8 + 0.4 * (number % 97) / 97)}
    session = {"X-Session": f"soak-user-{number % 8}"}
    try:
        if number % 50 == 7:
            answer = client.post("/api/curve", json=case, params={"field": field}, headers=session)
        elif number % 50 == 19:
            answer = client.post("/api/solve", json=case | {field: -1}, headers=session)
        elif number % 200 == 33:
            study = {"case": case, "over": {field: [case[field], 1.1 * case[field]]},
                     "outputs": ["half_width"]}  # fmt: skip
            answer = client.post("/api/sweep", json=study, headers=session)
            last = json.loads(answer.text.splitlines()[-1])
            statuses[f"study {last.get('event', 'refused')}"] += 1
        else:
            answer = client.post("/api/solve", json=case, headers=session)
        statuses[str(answer.status_code)] += 1
    except Exception as fault:
        statuses["fault"] += 1
        print(f"request {number}: {fault!r}")


def main() -> int:
    """Run from the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("what", choices=("latency", "soak"))
    parser.add_argument("--moves", type=int, default=100, help="of the slider")
    parser.add_argument("--minutes", type=float, default=10.0, help="of the soak")
    parser.add_argument("--rate", type=float, default=20.0, help="requests a second")
    given = parser.parse_args()
    with serving() as server:
        good = (latency(server, given.moves) if given.what == "latency"
                else soak(server, given.minutes, given.rate))  # fmt: skip
    return not good


if __name__ == "__main__":
    sys.exit(main())
