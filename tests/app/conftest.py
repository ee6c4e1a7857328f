"""Clients of a server of the page."""

import os

import httpx
import pytest


@pytest.fixture(scope="session")
def server(process):
    """The address of a server."""
    return process.address


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


@pytest.fixture(scope="session")
def slow_nip(cases):
    """The tables of a nip on a hardening roll, whose solution takes seconds."""
    roll = {"kind": "wound_roll", "radius": 0.1, "core_radius": 0.0445, "pressure": 200e3}
    return cases["nip"] | {"roll": roll | {"stack": cases["roll"]["stack"]}}
