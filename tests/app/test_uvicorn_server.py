"""How answers travel."""

import socket
import statistics
import time
from urllib.parse import urlsplit

REQUESTS = 30


def test_the_body_of_an_answer_follows_its_head_at_once(server):
    place = urlsplit(server)
    asked = f"GET /api HTTP/1.1\r\nHost: {place.netloc}\r\n\r\n".encode()
    gaps = []
    with socket.create_connection((place.hostname, place.port), timeout=40) as link:
        for _ in range(REQUESTS):
            link.sendall(asked)
            got = b""
            while b"\r\n\r\n" not in got:
                got += link.recv(65536)
            began = time.perf_counter()
            head, _, body = got.partition(b"\r\n\r\n")
            (line,) = (one for one in head.lower().split(b"\r\n") if b"content-length" in one)
            while len(body) < int(line.split(b":")[1]):
                body += link.recv(65536)
            gaps.append(time.perf_counter() - began)
    # Nagle's algorithm waits for an acknowledgement, which comes after 40 ms
    assert statistics.median(gaps) < 0.015
