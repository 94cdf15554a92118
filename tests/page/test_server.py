"""`breaker view` over HTTP: whom it answers, and what changes while it runs."""

import re
import subprocess
import sys

from breaker.cli import main
from breaker.page.server import HOST, POLICY
from tests.page.conftest import FORM, Page, line

LINE = "file=line.csv"
LIMIT = "type=T&quantity=closing+stroke&low=50&high=60"
PAGES = ("/", f"/inspection?{LINE}", f"/verdict?{LINE}", "/static/page.js")


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


def test_a_limit_is_set_by_the_form_of_this_page_only(page):
    page, folder = page
    for origin in ({}, {"Origin": "http://evil.example"}):
        assert page.get(f"/set?{LINE}", "POST", LIMIT, Content_Type=FORM, **origin).status == 403
    for path in (f"/set?{LINE}", "/static/..%2f__init__.py", "/none"):
        assert page.get(path).status in (403, 404)
    assert page.post("/", "").status == 404
    assert page.get("/", "DELETE", Origin=page.origin).status == 405
    assert not [*folder.parent.glob("types.yaml")]
    answer = page.post(f"/set?{LINE}", LIMIT)
    assert (answer.status, answer.headers["Location"]) == (303, f"/inspection?{LINE}&type=T")
    assert '"fail"' in page.get(f"/verdict?{LINE}&type=T").text


def test_files_that_change_or_go_change_the_page_and_are_never_written(page):
    page, folder = page
    before, content = page.get(PAGES[1]).text, (folder / "line.csv").read_bytes()
    for path in (*PAGES, f"/sheet?{LINE}", f"{PAGES[1]}&set.zero=rest"):
        assert page.get(path).status == 200
    assert [(file.name, file.read_bytes()) for file in folder.iterdir()] == [("line.csv", content)]
    line(folder / "line.csv", spike=20.0)
    assert page.get(PAGES[1]).text != before
    away = folder.parent / "away"
    for what, status in ((folder, 404), (folder / "line.csv", 200)):
        what.rename(away)
        assert (page.get(PAGES[1]).status, page.get("/").status) == (404, status)
        away.rename(what)
        assert page.get(PAGES[1]).status == 200
    (folder / "b.csv").touch()
    assert "b.csv" in page.get("/").text
    for path in ("/inspection", "/inspection?file=../types.yaml", "/verdict?file=lost.csv"):
        assert page.get(path).status == 404


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
    """The command opens no connection and resolves no name."""
    words = [sys.executable, "-c", _WATCHED, "view", "--example", "--no-browser"]
    words += ["--config", str(folder / "few.yaml")]
    about = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    with subprocess.Popen(words, **about) as process:
        page = Page(process.stdout.readline())
        assert "NOT READ" in page.get("/inspection?file=unknown.txt").text
        for name in ("verdict", "sheet", "inspection"):
            assert page.get(f"/{name}?file=unknown.txt&set.rate=20").status == 200
        process.terminate()
        assert process.wait(60) == 0
        assert process.stderr.read() == ""


def test_errors_of_the_command_are_one_line(page, capsys):
    page, folder = page
    for words in ([folder / "none"], [folder, "--example"], [folder, "--port", page.port]):
        assert main(["view", *map(str, words)]) == 1
        assert capsys.readouterr().err.count("\n") == 1
