"""Requests that are rejected: by host, origin, token, size, time; the command that serves."""

import socket
import subprocess
import sys
import threading
import time
from urllib.parse import urlsplit

import httpx
import pytest
from coroutines import run

from woundon.cli.commands import main

JSON = {"content-type": "application/json"}


class Bare:
    """The application without workers: what is refused needs none.  It keeps cookies."""

    def __init__(self, address, *given):
        # half a second of a process, which others need not wait for
        from woundon.app.routes import application

        self.app, self.address, self.cookies = application(*given), address, httpx.Cookies()

    def get(self, path, **more):
        return run(self._send("GET", path, **more))

    def post(self, path, **more):
        return run(self._send("POST", path, **more))

    async def _send(self, method, path, **more):
        transport = httpx.ASGITransport(self.app)
        async with httpx.AsyncClient(
            transport=transport, base_url=self.address, cookies=self.cookies
        ) as client:
            answer = await client.request(method, path, **more)
        self.cookies.update(answer.cookies)
        return answer


@pytest.fixture(scope="module")
def bare():
    """An application that serves this machine alone."""
    return Bare("http://127.0.0.1:8321")


@pytest.mark.parametrize("host", ["127.0.0.1:8321", "localhost:1", "[::1]:8321", "LOCALHOST"])
def test_this_machine_is_served(bare, host):
    headers = {"host": host, "origin": f"http://{host}"}
    assert bare.get("/api/catalogue", headers=headers).status_code == 200


@pytest.mark.parametrize(
    "host",
    ["evil.example", "127.0.0.1.evil.example", "evil.example:8321", "", "localhost@evil.example",
     "127.0.0.2", "0.0.0.0", "[::", "localhost.evil", "a" * 5000, "127.0.0.1/evil",
     "127.0.0.1:8321/evil", "127.0.0.1?evil", "127.0.0.1#evil", "127.0.0.1\\evil",
     "127.0.0.1:port", "127.0.0.1:8321:1", "[127.0.0.1", "user@127.0.0.1"],
)  # fmt: skip
def test_a_foreign_host_is_rejected(bare, host):
    answer = bare.get("/api/catalogue", headers={"host": host})
    assert answer.status_code == 400  # of Starlette's TrustedHostMiddleware
    assert "content-security-policy" in answer.headers


@pytest.mark.parametrize(
    "origin",
    ["http://evil.example", "null", "http://127.0.0.1:9999", "https://127.0.0.1:8321.evil",
     "file://", "http://localhost:8321", "ftp://127.0.0.1:8321", "http://[", "http://[::1",
     "//127.0.0.1:8321", "http://127.0.0.1:8321/path", ""],
)  # fmt: skip
@pytest.mark.parametrize("path", ["/api/solve", "/api/catalogue", "/"])
def test_a_foreign_origin_is_rejected(bare, path, origin):
    send = bare.post if path == "/api/solve" else bare.get
    assert send(path, headers={"origin": origin} | JSON).status_code == 403


@pytest.mark.parametrize("site", ["cross-site", "same-site"])
def test_what_a_browser_calls_cross_site_is_rejected(bare, site):
    headers = {"sec-fetch-site": site, "sec-fetch-mode": "no-cors"}
    assert bare.get("/api/catalogue", headers=headers).status_code == 403
    # but a link to the page may be followed
    headers["sec-fetch-mode"] = "navigate"
    assert bare.get("/", headers=headers).status_code == 200
    assert bare.get("/api/catalogue", headers=headers).status_code == 403


def test_every_answer_forbids_what_no_page_of_ours_needs(bare):
    for path in ("/", "/api", "/api/catalogue", "/openapi.json", "/nothing"):
        headers = bare.get(path).headers
        assert "default-src 'none'" in headers["content-security-policy"]
        assert "unsafe" not in headers["content-security-policy"]
        assert headers["x-content-type-options"] == "nosniff"
        assert headers["cross-origin-resource-policy"] == "same-origin"
        assert "set-cookie" not in headers
        assert not [name for name in headers if name.startswith("access-control")]


# ---- a token ----------------------------------------------------------------------------------


@pytest.fixture
def shared():
    return Bare("http://winder.example", ["winder.example"], "secret-token")


def test_without_the_token_nothing_is_served(shared):
    for path in ("/", "/api/catalogue", "/static/index.html"):
        assert shared.get(path).status_code == 401
    wrong = {"authorization": "Bearer secret-tokem"}
    assert shared.get("/", headers=wrong).status_code == 401
    assert shared.get("/?token=x").status_code == 401


def test_the_address_with_the_token_sets_a_cookie_of_this_site_alone(shared):
    answer = shared.get("/?token=secret-token")
    assert answer.status_code == 200
    assert "HttpOnly" in answer.headers["set-cookie"]
    assert "SameSite=strict" in answer.headers["set-cookie"]
    assert shared.get("/api/catalogue").status_code == 200


def test_programs_carry_the_token_in_their_head(shared):
    headers = {"authorization": "Bearer secret-token"}
    assert shared.get("/api/catalogue", headers=headers).status_code == 200


# ---- bodies -----------------------------------------------------------------------------------


def test_a_client_that_disconnects_within_the_body_raises_no_error(bare):
    """An exception that leaves the application is a traceback in the server's log."""
    parts = [{"type": "http.request", "body": b"{", "more_body": True}, {"type": "http.disconnect"}]
    sent = []
    scope = {
        "type": "http", "asgi": {"version": "3.0"}, "http_version": "1.1", "method": "POST",
        "scheme": "http", "path": "/api/solve", "raw_path": b"/api/solve", "query_string": b"",
        "root_path": "", "client": ("127.0.0.1", 1), "server": ("127.0.0.1", 8321),
        "headers": [(b"host", b"127.0.0.1:8321"), (b"content-type", b"application/json")],
    }  # fmt: skip

    async def receive():
        return parts.pop(0)

    async def send(message):
        sent.append(message)

    run(bare.app(scope, receive, send))
    assert sent[0]["status"] == 400


@pytest.mark.parametrize(
    "kind", ["text/plain", "application/x-www-form-urlencoded", "multipart/form-data", ""]
)
def test_a_body_that_forms_of_other_sites_send_is_rejected(bare, kind):
    answer = bare.post("/api/solve", content=b"{}", headers={"content-type": kind})
    assert answer.status_code == 422


@pytest.mark.parametrize("message", [{}, {"content-length": "100000000"}])
def test_a_body_of_100_mb_is_rejected_whether_its_length_is_reported_or_not(server, message):
    assert sent_100_mb(server, message) in (413, None)
    assert httpx.get(f"{server}/api/catalogue").status_code == 200


def sent_100_mb(server, message):
    """Return the answer's status; None where the connection was closed while it was sent."""
    megabytes = (b" " * 1_000_000 for _ in range(100))
    try:
        return httpx.post(
            f"{server}/api/solve", content=megabytes, headers=JSON | message
        ).status_code
    except httpx.TransportError:
        return None


def test_memory_is_bounded_whatever_is_sent(process):
    """The server grows by less than a tenth of what is sent to it."""
    before = process.memory().get("server", 0.0)
    for _ in range(5):
        sent_100_mb(process.address, {})
    assert process.memory().get("server", 0.0) - before < 50  # MB


def test_deep_nesting_is_rejected(server):
    for body in (b'{"a":' * 150 + b"1" + b"}" * 150, b"[" * 10_000 + b"]" * 10_000):
        answer = httpx.post(f"{server}/api/solve", content=body, headers=JSON, timeout=60)
        assert answer.status_code in (400, 422)
        assert "nested too deeply" in answer.json()["detail"] or "not JSON" in answer.text


def test_a_slow_sender_is_not_waited_for(server):
    """Neither for a head nor for a body; meanwhile others are served."""
    place = urlsplit(server)
    heads = {
        "head": b"POST /api/solve HTTP/1.1\r\nHost: 127.0.0.1\r\n",
        "body": b"POST /api/solve HTTP/1.1\r\nHost: 127.0.0.1\r\n"
                b"Content-Type: application/json\r\nContent-Length: 1000\r\n\r\n{",
    }  # fmt: skip
    ended = {}

    def send(name, head):
        with socket.create_connection((place.hostname, place.port), timeout=40) as link:
            began = time.monotonic()
            link.sendall(head)
            answer = link.recv(10_000)
            ended[name] = time.monotonic() - began, answer

    threads = [threading.Thread(target=send, args=item) for item in heads.items()]
    for thread in threads:
        thread.start()
    assert httpx.get(f"{server}/api/catalogue").status_code == 200
    for thread in threads:
        thread.join(40)
    # ten seconds each, and what a busy machine adds
    assert ended["head"][0] < 25
    assert ended["head"][1] == b""
    assert ended["body"][0] < 25
    assert b"408" in ended["body"][1]


# ---- the command ------------------------------------------------------------------------------


def test_without_the_extra_the_command_names_it():
    code = ("import sys; sys.modules['uvicorn'] = None; from woundon.cli.commands import main; "
            "sys.exit(main(['app', '--no-browser']))")  # fmt: skip
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 2
    assert 'pip install "woundon[app]"' in done.stderr
    assert done.stderr.count("\n") == 1


@pytest.fixture
def served(monkeypatch):
    """Whom the command would serve: nobody is, for that would not end."""
    from woundon.app import uvicorn_server

    called = []
    monkeypatch.setattr(
        uvicorn_server, "serve", lambda at, names, *rest, **more: called.append(names)
    )
    return called


def test_a_port_that_is_taken_is_reported(server, served, capsys):
    port = str(urlsplit(server).port)
    assert main(["app", "--no-browser", "--port", port]) == 2
    assert capsys.readouterr().err.startswith(f"error: port {port}: cannot listen at 127.0.0.1")
    assert served == []


@pytest.mark.parametrize("host", ["", " "])
def test_an_empty_host_does_not_listen_at_all_addresses(served, capsys, host):
    assert main(["app", "--no-browser", "--port", "0", "--host", host]) == 2
    error = capsys.readouterr().err
    assert error.startswith("error: host: ")
    assert "127.0.0.1" in error
    assert served == []


INTERRUPTED = """
import signal
from woundon.app import uvicorn_server

class Finalised:
    def __del__(self):
        signal.raise_signal(signal.SIGINT)

made = uvicorn_server.application

def application(*args):
    Finalised()
    return made(*args)

uvicorn_server.application = application
before = signal.getsignal(signal.SIGINT)
with uvicorn_server.interrupts_counted() as pressed, uvicorn_server.listening("127.0.0.1", 0) as at:
    uvicorn_server.serve(at, pressed=pressed)
assert signal.getsignal(signal.SIGINT) is before
print("ended")
"""


@pytest.mark.slow
def test_ctrl_c_while_the_server_is_made_is_not_lost():
    """It comes where no exception can be raised: in a finaliser."""
    command = [sys.executable, "-c", INTERRUPTED]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    assert done.stdout == "ended\n", done.stderr


def test_who_serves_others_is_reported_the_token_and_the_proxy(served, capsys):
    assert main(["app", "--no-browser", "--port", "0", "--name", "winder.example"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert "http://winder.example" in lines[0]
    assert "?token=" in lines[0]
    assert "reverse proxy" in "".join(lines)
    assert served == [("127.0.0.1", "winder.example")]
