"""A page of two visits, without a browser."""

import asyncio
import http.client
import os
import re
import subprocess
import sys
import threading
import time
from contextlib import contextmanager
from typing import NamedTuple

import pytest
import yaml

from breaker.app.local_server import HOST, PageServer
from breaker.app.view_session import Session
from breaker.cli.view import commands
from tests.exports import write

ODD = "Coil <b>&\"' (A)"
LIMITS = [{"name": "slow", "motion": "closing", "of": "record", "upper": {"travel_time": 30.0}}]


class Got(NamedTuple):
    """What a page answers."""

    status: int
    text: str
    content: bytes
    headers: http.client.HTTPMessage


class Outside:
    """A page by the address that a command has printed, asked as a browser asks: with the cookie,
    unless told otherwise.
    """

    def __init__(self, line):
        self.port, self.token = re.search(rf"http://{HOST}:(\d+)/\?token=(\S+)", line).groups()

    def get(self, path, *, cookie=None, method="GET", body=None, **headers):
        headers = {name.replace("_", "-"): value for name, value in headers.items()}
        own = f"breaker-{self.port}={self.token}"
        headers |= {"Cookie": own if cookie is None else cookie}
        connection = http.client.HTTPConnection(HOST, int(self.port), timeout=60)
        connection.request(method, path, body=body, headers=headers)
        answer = connection.getresponse()
        content = answer.read()
        connection.close()
        return Got(answer.status, content.decode("utf-8", "replace"), content, answer.headers)

    def post(self, path, body):
        origin = f"http://{HOST}:{self.port}"
        form = "application/x-www-form-urlencoded"
        return self.get(path, method="POST", body=body, Origin=origin, Content_Type=form)


@contextmanager
def started(folder="", *, command=("-m", "breaker"), more=("--no-browser",), errors=None):
    """The command in a process of its own, with its first line; it is ended."""
    words = [sys.executable, *command, *(["view", str(folder), *more] if folder else [])]
    buffered = os.environ | {"PYTHONUNBUFFERED": ""}  # as on most machines
    with open(errors or os.devnull, "w") as said:
        process = subprocess.Popen(
            words, stdout=subprocess.PIPE, stderr=said, text=True, env=buffered
        )
        try:
            process.line = process.stdout.readline()
            yield process
        finally:
            process.terminate()
            process.wait(20)
            process.stdout.close()


def until(there, what):
    """Wait for something."""
    end = time.monotonic() + 30
    while not there():
        assert time.monotonic() < end, f"{what} did not come"
        time.sleep(0.05)


class Page(Outside):
    """A server in a thread."""

    def __init__(self, session):
        self.server, self.loop = PageServer(session), asyncio.new_event_loop()
        super().__init__(self.server.address)
        self.ended = asyncio.Event()
        serve = self.server.serve(self.ended)
        self.thread = threading.Thread(target=self.loop.run_until_complete, args=(serve,))
        self.thread.start()

    def end(self):
        self.loop.call_soon_threadsafe(self.ended.set)
        self.thread.join()
        self.loop.close()


@pytest.fixture
def opened():
    """Opens pages, and ends them."""
    pages = []

    def open_page(folder, own, overlays=()):
        pages.append(Page(Session(str(folder), list(overlays), commands(), own)))
        return pages[-1]

    yield open_page
    for each in pages:
        each.end()


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder of three exports and a text that is none, beside a configuration."""
    place = tmp_path_factory.mktemp("view")
    (place / "curves").mkdir()
    for seed, name in enumerate(("today.csv",)):
        write(place / "curves" / name, rate=5.0, seed=seed, motions=("closing", "opening"))
    for seed, name in enumerate(("old.csv", "one.csv")):
        write(place / "curves" / name, rate=5.0, seed=seed, channels=1)
    text = (place / "curves" / "today.csv").read_text(encoding="utf-8")
    escaped = ODD.replace('"', '""')
    (place / "curves" / "today.csv").write_text(text.replace("Coil 6 (A)", f'"{escaped}"'))
    (place / "curves" / "<img src=x onerror=alert(1)>.csv").write_text("<script>alert(2)</script>")
    few = {"endurance": {"draws": 50}, "limits": LIMITS}
    (place / "few.yaml").write_text(yaml.safe_dump(few))
    return place


@pytest.fixture(scope="module")
def page(folder, tmp_path_factory):
    """A page of that folder."""
    overlays = [str(folder / "few.yaml")]
    own = tmp_path_factory.mktemp("own")
    found = Page(Session(str(folder / "curves"), overlays, commands(), own))
    yield found
    found.end()
