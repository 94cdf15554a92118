"""`breaker view` over HTTP: whom it answers, and what changes while it is shown."""

import asyncio
import re
import subprocess
import sys

import pytest

from breaker.cli import main
from breaker.page.server import HOST, POLICY, PageServer
from tests.page.conftest import Page, Views, line

LINE = "file=line.csv"
LIMIT = '{"type": "T", "key": "limits.closing stroke", "ends": ["1", "2"]}'
PAGES = ("/", f"/inspection?{LINE}", f"/values?{LINE}", f"/curves?{LINE}&tab=0", "/static/page.js")


def test_nobody_else_is_answered_and_nothing_is_loaded_from_elsewhere(page):
    page, _ = page
    refused = [{"Origin": name} for name in ("http://evil.example", "null")]
    refused += [{"Host": name} for name in (HOST, f"evil.example:{page.port}")]
    cookies = ("", f"breaker-{page.port}=guessed", f"breaker-1={page.token}")
    refused += [{"Cookie": cookie} for cookie in cookies]
    for path in PAGES:
        assert {page.get(path, **item).status for item in refused} == {403}
        result = page.get(path)
        assert (result.status, result.headers["Content-Security-Policy"]) == (200, POLICY)
        assert not re.search(r"""(src|href|url\(|fetch\()\s*=?\s*["'`]?(https?:)?//""", result.text)
    assert "script-src 'self';" in POLICY
    assert page.get("/?token=guessed", Cookie="").status == 403
    right = page.get(f"/?token={page.token}", Cookie="")
    assert right.status == 200
    assert {"HttpOnly", "SameSite=Strict"} <= {*right.headers["Set-Cookie"].split("; ")}


def test_nothing_is_changed_for_another_page_or_by_another_method(page):
    page, folder = page
    for headers in ({}, {"Origin": "http://evil.example"}):
        assert page.get("/set", "POST", LIMIT, **headers).status == 403
    for path in ("/set", "/static/..%2f__init__.py", "/none"):
        assert page.get(path).status in (403, 404)
    assert page.post("/", "").status == 404
    assert page.get("/", "DELETE", Origin=page.origin).status == 405
    assert not [*folder.parent.glob("types.yaml")]


def test_what_changes_or_goes_while_it_is_shown_is_said(page):
    page, folder = page
    before = page.get(PAGES[2]).text
    line(folder / "line.csv", spike=20.0)
    assert page.get(PAGES[2]).text != before
    away = folder.parent / "away"
    for what, status in ((folder, 404), (folder / "line.csv", 200)):
        what.rename(away)
        assert (page.get(PAGES[1]).status, page.get("/").status) == (404, status)
        away.rename(what)
        assert page.get(PAGES[1]).status == 200
    (folder / "b.csv").touch()
    assert 'data-count="2"' in page.get("/").text
    for path in ("/inspection", "/inspection?file=../types.yaml", "/values?file=lost.csv"):
        assert page.get(path).status == 404


def test_records_are_never_changed_and_windows_do_not_disturb_each_other(page):
    page, folder = page

    def state():
        return [(file, file.stat().st_mtime_ns, file.read_bytes()) for file in folder.iterdir()]

    plain, before = page.get(PAGES[2]).text, state()
    for path in (*PAGES, "/?look=1", f"/sheet?{LINE}", f"{PAGES[1]}&set.zero=rest"):
        assert page.get(path).status == 200
    assert page.get(f"{PAGES[2]}&set.sign=-1").text != plain == page.get(PAGES[2]).text
    assert state() == before


_WATCHED = """
import sys
def seen(event, about):
    if event in ("socket.connect", "socket.sendto", "socket.getaddrinfo"):
        print(event, *map(str, about), file=sys.stderr, flush=True)
sys.addaudithook(seen)
import runpy
runpy.run_module("breaker", run_name="__main__")
"""


def test_the_example_leads_to_a_sheet_and_no_request_leaves_the_machine(folder, tmp_path):
    """Whatever a page is asked for, the command connects to nothing and asks for no name."""
    words = [sys.executable, "-c", _WATCHED, "view", "--example", "--no-browser"]
    words += ["--config", str(folder / "few.yaml")]
    about = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    with subprocess.Popen(words, **about) as process:
        page = Page(process.stdout.readline())
        assert "data-trouble" in page.get("/inspection?file=unknown.txt").text
        for name in ("model", "verdict", "sheet", "inspection"):
            assert page.get(f"/{name}?file=unknown.txt&set.rate=20").status == 200
        process.terminate()
        assert process.wait(60) == 0
        assert process.stderr.read() == ""


def test_what_hinders_the_command_is_said_on_one_line(page, capsys):
    page, folder = page
    for words in ([folder / "none"], [folder, "--example"], [folder, "--port", page.port]):
        assert main(["view", *map(str, words)]) == 1
        assert capsys.readouterr().err.count("\n") == 1


def test_workers_end_whatever_ends_the_page(folder, tmp_path):
    """Planted fault: an end between the first task and the wait left a thread, and the process."""
    server = PageServer(Views(folder / "curves", tmp_path).session)

    def ready():
        raise KeyError

    with pytest.raises(KeyError):
        asyncio.run(server.serve(asyncio.Event(), ready))
    for worker in server.workers.values():
        with pytest.raises(RuntimeError):
            worker.submit(int)
