"""A server of the page on a free port, as people start it; its workers are ready."""

import os
import re
import subprocess
import sys
import time

import httpx
import pytest


@pytest.fixture(scope="session")
def server():
    """The address of a server."""
    command = [sys.executable, "-m", "woundon", "app", "--no-browser", "--port", "0"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=os.environ)
    address = re.search(r"http://\S+", process.stdout.readline())[0].rstrip("/")
    for _ in range(600):
        try:
            httpx.get(f"{address}/api/catalogue", timeout=60)
            break
        except httpx.TransportError:
            time.sleep(0.1)
    yield address
    process.terminate()
    process.communicate(timeout=20)


@pytest.fixture
def client(server):
    """A client of the server, of a session of its own."""
    headers = {"X-Session": os.urandom(8).hex()}
    with httpx.Client(base_url=server, headers=headers, timeout=120) as made:
        yield made


@pytest.fixture(scope="session")
def catalogue(server):
    """What the server says that there is."""
    return httpx.get(f"{server}/api/catalogue", timeout=120).json()


@pytest.fixture(scope="session")
def cases(catalogue):
    """The tables of each kind's example."""
    return {kind["name"]: kind["example"] for kind in catalogue["kinds"]}
