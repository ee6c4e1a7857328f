"""Malformed and hostile requests to a server of the page.

described  requests that schemathesis generates from the interface's own description, and requests
           that contradict it
damaged    cases and studies with one to four places overwritten: nan, 1e308, texts, markup, deep
           and long lists, wrong types, unknown names, paths
raw        bytes that are no HTTP, headers without end, wrong lengths

Every answer must have a status below 500 (or state that the server is busy or that the request
took too long), arrive within the stated time, and be problem+json within 15 s if the request is
rejected.
Afterwards the server must solve a case and hold no more memory than permitted.
"""

from __future__ import annotations

import copy
import json
import random
import socket
import time
from collections import Counter
from collections.abc import Callable, Iterator
from typing import Any
from urllib.parse import urlsplit

import httpx
from page_server import Server

LONGEST = 200.0  # s; what takes longest may take 180
LONGEST_REJECTION = 15.0  # s; alone on the machine they take less than 1
GROWTH = 300.0  # MB, of all processes together
WORKABLE = (503, 504)  # busy, its worker died, or beyond the stated time: it says so
JSON = {"content-type": "application/json"}

PATHS = (
    "solve", "solve", "curve", "sensitivities", "sweep", "report", "figure", "file", "python",
    "case/write", "case/read", "design", "find", "fit",
)  # fmt: skip
VALUES: tuple[Callable[[random.Random], Any], ...] = (
    lambda r: float("nan"), lambda r: 1e308, lambda r: -1e308, lambda r: 10**400, lambda r: 5e-324,
    lambda r: 0, lambda r: -1, lambda r: True, lambda r: None, lambda r: "", lambda r: "nan",
    lambda r: "1e999 m", lambda r: "66 um", lambda r: "9" * 5000, lambda r: "m" * 100_000,
    lambda r: "<script>alert(1)</script>", lambda r: "../../etc/passwd", lambda r: "/etc/passwd",
    lambda r: "\u202e\x00\x1b[31m", lambda r: [], lambda r: {}, lambda r: [1.0] * 20_000,
    lambda r: nested(r.choice((5, 30, 150, 5000))), lambda r: {"kind": "rigid"},
    lambda r: {"kind": r.choice(("layered", "wound_roll", "nothing", 7)), "radius": r.random()},
    lambda r: {"csv": "/etc/passwd"}, lambda r: r.uniform(-1, 1) * 10 ** r.uniform(-300, 300),
    lambda r: r.choice(("newsprint", "steel", "direct", "free")),
)  # fmt: skip


def nested(deep: int) -> Any:
    """Return a table in a table in a table."""
    made: Any = 1
    for _ in range(min(deep, 900)):
        made = {"a": made}
    return made


# ---- what is sent -----------------------------------------------------------------------------


def damaged(random_: random.Random, kinds: list[Any]) -> tuple[str, dict[str, Any], Any]:
    """Return path, query and body of a request whose body is wrong somewhere."""
    case = copy.deepcopy(random_.choice(kinds)["example"])
    over: Any = {"nip_load": {"from": 1e3, "to": 2e3, "count": 3}}
    path = random_.choice(PATHS)
    body: Any = {
        "sweep": {"case": case, "over": over, "outputs": ["nip_induced_tension"]},
        "report": {"cases": [{"case": case}], "units": {"nip_load": "pli"}},
        "figure": {"cases": [{"label": "A", "case": case}]},
        "case/read": {"toml": json.dumps(case)},
        "find": {"case": case, "field": "nip_load", "output": "wound_on_tension", "target": 5e2},
        "fit": {
            "case": case,
            "table": "nip_load [kN/m]\n1;2",
            "vary": {"roll_friction": [0.1, 0.3]},
        },
        "design": {"case": case, "pressure": {"radius": [0.0445, 0.15], "value": [2e5, 1e5]}},
    }.get(path, case)
    for _ in range(random_.randint(1, 4)):
        _overwrite(random_, body)
    query: dict[str, Any] = {"field": random_.choice(("nip_load", "drum.radius", "roll"))}
    if path != "curve":
        query = {}
    if random_.random() < 0.2:
        name = random_.choice(("nodes", "rtol", "scheme", "points", "low", "warm", "format"))
        query[name] = random_.choice(("nan", "-1", "4000", "1e308", "x" * 300, "../x", "7"))
    return f"/api/{path}", query, body


def _overwrite(random_: random.Random, body: Any) -> None:
    """Put a hostile value at a random place, or add a new name."""
    place = body
    while True:
        keys = list(place) if isinstance(place, dict) else list(range(len(place)))
        if not keys:
            return
        key = random_.choice(keys)
        inner = place[key]
        if isinstance(inner, (dict, list)) and inner and random_.random() < 0.75:
            place = inner
            continue
        if isinstance(place, dict) and random_.random() < 0.2:
            key = random_.choice(("kind", "schema", "__class__", "a.b.c", "<b>", "x" * 500))
        place[key] = random_.choice(VALUES)(random_)
        return


def described(count: int, seed: int, address: str, document: Any) -> Iterator[Any]:
    """Yield requests made of the interface's description."""
    import schemathesis
    from hypothesis import HealthCheck, Phase, given, settings
    from hypothesis import seed as seeded

    schema = schemathesis.openapi.from_dict(document)
    routes = [route.ok() for route in schema.get_all_operations()]
    each, made = max(1, count // (2 * len(routes))), list[Any]()
    for route in routes:
        for mode in schemathesis.GenerationMode:
            if mode.name == "NEGATIVE" and not (route.body or route.query):
                continue

            @seeded(seed)
            @settings(max_examples=each, database=None, deadline=None, phases=[Phase.generate],
                      suppress_health_check=list(HealthCheck))  # fmt: skip
            @given(route.as_strategy(generation_mode=mode))
            def collect(case: Any) -> None:
                made.append(case)

            collect()
    yield from (case.as_transport_kwargs(base_url=address) for case in made)


RAW = (
    b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03", b"GET / HTTP/9.9\r\n\r\n", b"\r\n" * 10_000,
    b"GET /" + b"a" * 100_000 + b" HTTP/1.1\r\n\r\n", b"POST /api/solve HTTP/1.1\r\n\r\n",
    b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nHost: evil\r\n\r\n",
    b"POST /api/solve HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: -5\r\n\r\n",
    b"POST /api/solve HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: 5\r\n"
    b"Transfer-Encoding: chunked\r\n\r\n0\r\n\r\nGET / HTTP/1.1\r\n\r\n",
    b"GET /static/../../../../etc/passwd HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n",
    b"GET /static/%2e%2e/%2e%2e/pyproject.toml HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n",
    b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n" + b"X: y\r\n" * 20_000 + b"\r\n",
)  # fmt: skip


def raw(address: str, content: bytes) -> bytes:
    """Send bytes as they are; return the first of what comes back."""
    place = urlsplit(address)
    with socket.create_connection((place.hostname or "", place.port or 0), timeout=30) as link:
        try:
            link.sendall(content)
            link.shutdown(socket.SHUT_WR)
            return link.recv(65_536)
        except OSError:
            return b""


# ---- what must come back ----------------------------------------------------------------------


class Judge:
    """Sends, and keeps what was wrong with the answers."""

    def __init__(self, server: Server) -> None:
        self.client = httpx.Client(base_url=server.address, timeout=LONGEST + 30)
        self.statuses, self.faults = Counter[str](), list[str]()
        self.slowest, self.slowest_request = 0.0, ""

    def send(self, what: str, method: str, path: str, **more: Any) -> None:
        """Send a request and look at its answer."""
        began = time.monotonic()
        try:
            answer = self.client.request(method, path, **more)
        except (httpx.InvalidURL, UnicodeError, ValueError, TypeError):
            self.statuses["not sent"] += 1
            return
        except httpx.TransportError as fault:
            # the connection may be closed on who sends too much, but not for nothing
            self.statuses["closed"] += 1
            if len(more.get("content", b"")) < 1_000_000:
                self.faults.append(f"{what}: {method} {path}: {fault!r}")
            return
        seconds = time.monotonic() - began
        self.statuses[str(answer.status_code)] += 1
        record = f"{what}: {method} {path} {str(more)[:300]} -> {answer.status_code}"
        if seconds > self.slowest:
            self.slowest, self.slowest_request = seconds, record
        if answer.status_code >= 500 and answer.status_code not in WORKABLE:
            self.faults.append(f"{record} {answer.text[:300]}")
        if seconds > (LONGEST_REJECTION if 400 <= answer.status_code < 500 else LONGEST):
            self.faults.append(f"{record} after {seconds:.0f} s")
        kind = answer.headers.get("content-type", "")
        of_middleware = answer.text in ("Invalid host header", "Content Too Large")
        problem = kind.startswith("application/problem+json") or of_middleware
        if answer.status_code >= 400 and not problem:
            self.faults.append(f"{record} as {kind!r}")


def run(server: Server, requests: int, seed: int) -> Judge:
    """Send so many requests; return what was found."""
    judge, random_ = Judge(server), random.Random(seed)
    kinds = judge.client.get("/api/catalogue").json()["kinds"]
    document = judge.client.get("/openapi.json").json()
    before = server.memory()
    from_description = list(described(requests // 2, seed, server.address, document))
    for number in range(requests - len(from_description)):
        path, query, body = damaged(random.Random(f"{seed}-{number}"), kinds)
        content = json.dumps(body).encode()
        judge.send(f"damaged {number}", "POST", path, params=query, content=content, headers=JSON)
    for number, given in enumerate(from_description):
        known = {name: given[name] for name in ("params", "json", "headers", "data")
                 if given.get(name) is not None}  # fmt: skip
        if isinstance(known.get("json"), (float, int, list, dict, str)):
            content = json.dumps(known.pop("json"), default=str).encode()
            known |= {"content": content, "headers": {**dict(known.get("headers", {})), **JSON}}
        if isinstance(known.get("data"), (bytes, str)):
            known["content"] = known.pop("data")
        judge.send(f"described {number}", given["method"], given["url"], **known)
    for content in random_.sample(RAW, min(len(RAW), requests)):
        answer = raw(server.address, content)
        judge.statuses[f"raw {answer[9:12].decode('latin-1') or 'closed'}"] += 1
        if answer[9:10] == b"5" or b"root:" in answer or b"build-system" in answer:
            judge.faults.append(f"raw {content[:60]!r}: {answer[:200]!r}")
    good = judge.client.post("/api/solve", json=kinds[0]["example"])
    if good.status_code != 200:
        judge.faults.append(f"in the end a case is answered with {good.status_code}")
    after = server.memory()
    grown = {name: after[name] - before[name] for name in before}
    if sum(grown.values()) > GROWTH:
        judge.faults.append(f"the processes have grown by {grown} MB")
    print(f"{dict(judge.statuses)}; grown by "
          + ", ".join(f"{name} {size:.0f} MB" for name, size in grown.items())
          + f"\nslowest, {judge.slowest:.1f} s: {judge.slowest_request}")  # fmt: skip
    return judge
