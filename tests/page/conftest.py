"""Pages of a folder of exports: their views alone, and a server without a browser."""

import asyncio
import http.client
import json
import re
import threading
from types import SimpleNamespace
from urllib.parse import parse_qs

import numpy as np
import pytest

from breaker.cli.common_options import limits_of, settings_of
from breaker.page.server import HOST, PageServer
from breaker.page.session import Session
from breaker.page.views import VIEWS, Asked
from tests.exports import pole, write

ODD = "Coil <b>&\"' (A)"
REFUSED = 422


class Views:
    """Answers of views without a server, or the status of an error."""

    def __init__(self, folder, own, *overlays):
        self.types, config = own / "types.yaml", settings_of([*map(str, overlays)])
        limits = limits_of(config, overlays)
        self.session = Session(str(folder), config, limits, types=str(self.types))

    def __call__(self, path, **form):
        name, _, query = path[1:].partition("?")
        fields = {key: [value] for key, value in form.items()}
        asked = Asked(self.session, parse_qs(query, keep_blank_values=True), fields)
        try:
            return VIEWS["POST" if form else "GET", name](asked)
        except (ValueError, OSError) as error:
            return getattr(error, "status", REFUSED)

    def set(self, of_type, quantity, low="", high=""):
        return self("/set?file=line.csv", type=of_type, quantity=quantity, low=low, high=high)

    def motions(self, query):
        """Curves and marks of the motions of an inspection, ``(2, n)``, by phase and name."""
        page = self(f"/inspection?{query}")
        for motion in json.loads(re.search('id="data">(.*?)</script>', page)[1]):
            lines = [curve for panel in motion["panels"] for curve in panel["curves"]]
            named = {f"{e['phase']} {e['name']}": e for e in lines}
            named |= {mark["name"]: mark for mark in motion["marks"]}
            yield {name: np.array([e["x"], e["y"]], float) for name, e in named.items()}


class Page:
    """A page by the address that a command prints, asked as by a browser by default."""

    def __init__(self, address):
        self.port, self.token = re.search(rf"http://{HOST}:(\d+)/\?token=(\S+)", address).groups()
        self.origin, self.cookie = f"http://{HOST}:{self.port}", f"breaker-{self.port}={self.token}"

    def get(self, path, method="GET", body=None, **headers):
        headers = {name.replace("_", "-"): value for name, value in headers.items()}
        connection = http.client.HTTPConnection(HOST, int(self.port), timeout=60)
        connection.request(method, path, body=body, headers={"Cookie": self.cookie, **headers})
        got = connection.getresponse()
        text = got.read().decode("utf-8", "replace")
        connection.close()
        return SimpleNamespace(status=got.status, headers=got.headers, text=text)

    def post(self, path, body, **headers):
        headers = {"Origin": self.origin, **headers}
        return self.get(path, "POST", body, **headers, Content_Type=FORM)


FORM = "application/x-www-form-urlencoded"


@pytest.fixture
def page(folder, tmp_path):
    """A page of a folder of one file, served in a thread, and that folder."""
    curves = tmp_path / "curves"
    curves.mkdir()
    line(curves / "line.csv")
    server = PageServer(Views(curves, tmp_path, folder / "few.yaml").session)
    loop, ended = asyncio.new_event_loop(), asyncio.Event()
    thread = threading.Thread(target=loop.run_until_complete, args=(server.serve(ended),))
    thread.start()
    yield Page(server.address), curves
    loop.call_soon_threadsafe(ended.set)
    thread.join()
    loop.close()


def line(path, header="time (ms),travel (mm)", spike=0.0):
    """Write a travel of 100 mm in 60 ms at one speed, from 50 ms on, at 10 kHz, without noise."""
    time = np.arange(3000) / 10.0
    travel = 100.0 * np.clip((time - 50.0) / 60.0, 0.0, 1.0)
    travel[800] += spike
    columns = [time, travel][-1 - header.count(",") :]
    np.savetxt(path, np.transpose(columns), "%.4f", ",", header=header, comments="")


@pytest.fixture(scope="package")
def folder(tmp_path_factory):
    """Exports of two breakers and others, next to a configuration of few draws."""
    place = tmp_path_factory.mktemp("page")
    curves = place / "curves"
    curves.mkdir()
    write(curves / "today.csv", rate=5.0, motions=("closing", "opening"), noise=0.01)
    text, odd = (curves / "today.csv").read_text(encoding="latin-1"), ODD.replace('"', '""')
    (curves / "today.csv").write_text(text.replace("Coil 6 (A)", f'"{odd}"'), encoding="latin-1")
    for seed, phase in enumerate("RYB"):
        pole(curves / f"trip_{phase}.csv", phase, seed, date="21/02/2020", noise=0.01)
    about = {"rate": 5.0, "serial": "HV-7", "noise": 0.01, "channels": 1}
    write(curves / "old.csv", date="25/05/2018", **about)
    write(curves / "one.csv", date="26/05/2019", **about)
    line(curves / "line.csv")
    line(curves / "bare.csv", "reading")
    (curves / "<img src=x onerror=alert(1)>.csv").write_text("<script>alert(2)</script>")
    (curves / "arrays.nc").touch()
    (place / "few.yaml").write_text("endurance: {draws: 50}")
    return place


@pytest.fixture
def ask(folder, tmp_path):
    """The views of that folder."""
    return Views(folder / "curves", tmp_path, folder / "few.yaml")
