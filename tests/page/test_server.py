"""`breaker view` over HTTP: whom it answers, and what changes while it is shown."""

import asyncio
import hashlib
import re
import socket
import time
from html import unescape

import pytest

from breaker.cli import main
from breaker.page.server import HOST, POLICY, PageServer
from tests.page.conftest import Outside, Views, line, served, started

LINE = "file=line.csv"
PAGES = ("/", f"/inspection?{LINE}", f"/values?{LINE}", f"/curves?{LINE}&tab=0", "/static/page.js")


@pytest.fixture(scope="module")
def page(folder, tmp_path_factory):
    """A page of the folder."""
    with served(Views(folder / "curves", tmp_path_factory.mktemp("own"))) as found:
        yield found


@pytest.fixture
def one(tmp_path):
    """A page of a folder of one file, with the folder."""
    (tmp_path / "curves").mkdir()
    line(tmp_path / "curves" / "line.csv")
    with served(Views(tmp_path / "curves", tmp_path)) as found:
        yield found, tmp_path / "curves"


@pytest.mark.parametrize("path", PAGES)
def test_nobody_else_is_answered(page, path):
    assert page.get(path).status == 200
    for refused in (
        {"Cookie": ""},
        {"Cookie": f"breaker-{page.port}=guessed"},
        {"Host": f"evil.example:{page.port}"},
        {"Host": HOST},
        {"Origin": "http://evil.example"},
        {"Origin": "null"},
    ):
        assert page.get(path, **refused).status == 403


def test_a_token_opens_and_a_wrong_one_does_not(page):
    assert page.get("/?token=guessed", Cookie="").status == 403
    right = page.get(f"/?token={page.token}", Cookie="")
    assert right.status == 200
    assert {"HttpOnly", "SameSite=Strict"} <= {*right.headers["Set-Cookie"].split("; ")}


def test_nothing_is_changed_for_another_page_nor_by_another_method(page, tmp_path):
    body = str(tmp_path / "a.yaml")
    for headers in (
        {},
        {"Origin": "http://evil.example"},
        {"Origin": page.origin, "Sec_Fetch_Site": "cross-site"},
    ):
        assert page.get(f"/save?{LINE}", method="POST", body=body, **headers).status == 403
    assert page.get(f"/save?{LINE}").status == 404
    assert page.post("/", "").status == 404
    for method in ("PUT", "DELETE", "PATCH"):
        assert page.get("/", method=method, Origin=page.origin).status == 405
    assert not [*tmp_path.iterdir()]


def test_pages_load_nothing_from_elsewhere(page):
    for path in (*PAGES, "/static/page.css", "/static/icon.svg"):
        found = page.get(path)
        assert found.headers["Content-Security-Policy"] == POLICY
        assert not re.search(r"""(src|href|url\(|fetch\()\s*=?\s*["'`]?(https?:)?//""", found.text)
    assert "script-src 'self';" in POLICY
    assert page.get("/static/bokeh.min.js").status == 200
    assert page.get("/static/..%2f__init__.py").status == 404


def test_a_body_beyond_the_bound_is_refused(page):
    with socket.create_connection((HOST, page.port), timeout=20) as browser:
        head = f"POST /drop HTTP/1.1\r\nHost: {HOST}:{page.port}\r\nCookie: {page.cookie}\r\n"
        browser.sendall(f"{head}Content-Length: {2**30}\r\n\r\n".encode())
        assert b" 200 " not in browser.recv(4096)


def test_files_are_dropped(page):
    bound = "x" * 20
    part = f'--{bound}\r\nContent-Disposition: form-data; name="file"; filename="%s"\r\n\r\n1\r\n'
    body = part % "a.csv" + part % "b.csv" + f"--{bound}--\r\n"
    kind = f"multipart/form-data; boundary={bound}"
    assert page.post("/drop", body, Content_Type=kind).status == 200
    assert len(re.findall(r'"/inspection\?file=dropped\S*[ab]\.csv"', page.get("/").text)) == 2


def test_a_file_that_changes_while_it_is_shown_is_said(one):
    page, folder = one
    query = unescape(re.search(r'data-query="([^"]*)"', page.get(PAGES[1]).text)[1])
    asked = [f"/{name}?{query}&tab=0" for name in ("curves", "values", "model", "sheet/sheet.html")]
    assert {page.get(each).status for each in asked} == {200}
    line(folder / "line.csv", spike=20.0)
    assert {page.get(each).status for each in asked} == {409}
    again = unescape(re.search(r'data-query="([^"]*)"', page.get(PAGES[1]).text)[1])
    assert again != query
    assert page.get(f"/curves?{again}&tab=0").status == 200


def test_what_goes_is_said_and_may_come_back(one):
    page, folder = one
    for away in (folder, folder / "line.csv"):
        away.rename(folder.parent / "away")
        assert page.get(PAGES[1]).status == 404
        assert page.get("/").status == (404 if away == folder else 200)
        (folder.parent / "away").rename(away)
        assert page.get(PAGES[1]).status == 200
    (folder / "b.csv").touch()
    assert "b.csv" in page.get("/").text
    for path in ("/inspection", "/inspection?file=../types.yaml", "/values?file=lost.csv"):
        assert page.get(path).status == 404


def test_records_are_never_changed(one):
    page, folder = one

    def state():
        files = sorted(folder.iterdir())
        return [(f, f.stat().st_mtime_ns, hashlib.sha256(f.read_bytes()).digest()) for f in files]

    before = state()
    for path in (*PAGES, "/?look=1", f"/sheet/sheet.html?{LINE}"):
        assert page.get(path).status == 200
    assert page.post(f"/save?{LINE}", str(folder / "line.csv")).status == 422
    assert page.post(f"/save?{LINE}", str(folder / "none" / "a.yaml")).status == 422
    assert state() == before


def test_two_windows_and_two_sessions_do_not_disturb_each_other(page, one):
    other, path = one[0], f"/curves?{LINE}&tab=0"
    size = len(other.get(path).text)
    values = f"/values?{LINE}"
    plain = page.get(values).text
    assert other.get(f"{values}&set.ratio=2").text != plain
    assert page.get(values).text == plain == other.get(values).text
    assert other.get("/", Cookie=page.cookie).status == 403
    assert size


def test_what_is_being_written_is_written_though_the_browser_is_closed(page, tmp_path):
    target = tmp_path / "left.yaml"
    with socket.create_connection((HOST, page.port)) as browser:
        head = f"POST /save?{LINE} HTTP/1.1\r\nHost: {HOST}:{page.port}\r\n"
        head += f"Origin: {page.origin}\r\nCookie: {page.cookie}\r\n"
        body = str(target)
        browser.sendall(f"{head}Content-Length: {len(body)}\r\n\r\n{body}".encode())
    end = time.monotonic() + 30
    while not target.exists():
        assert time.monotonic() < end
        time.sleep(0.05)


def test_no_request_leaves_the_machine(folder, tmp_path):
    """Whatever a page is asked for, the command connects to nothing and asks for no name."""
    script = (
        "import sys\n"
        "def seen(event, about):\n"
        "    if event in ('socket.connect', 'socket.sendto', 'socket.getaddrinfo'):\n"
        "        print(event, *map(str, about), file=sys.stderr, flush=True)\n"
        "sys.addaudithook(seen)\n"
        "from breaker.cli import main\n"
        f"sys.exit(main(['view', {str(folder / 'curves')!r}, '--no-browser']))\n"
    )
    with started("-c", script, errors=tmp_path / "errors") as process:
        page = Outside(process.line)
        more = ("/?look=1", f"/verdict?{LINE}", f"/model?{LINE}&model=1", "/static/bokeh.min.js")
        for path in (*PAGES, *more, f"/sheet/sheet.html?{LINE}"):
            assert page.get(path).status == 200
    assert (tmp_path / "errors").read_text() == ""


def test_what_hinders_the_command_is_said_on_one_line(page, folder, monkeypatch, capsys):
    def refused(path):
        raise PermissionError(13, "Permission denied", path)

    def said(*words):
        assert main(["view", *map(str, words)]) == 1
        assert capsys.readouterr().err.count("\n") == 1

    said(folder / "none")
    said(folder, "--example")
    said(folder, "--port", page.port)
    with monkeypatch.context() as patch:
        patch.setattr("os.listdir", refused)
        said(folder)
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    said(folder)


def test_the_example_leads_from_an_unknown_export_to_a_sheet():
    with started("-m", "breaker", "view", "--example", "--no-browser") as process:
        page = Outside(process.line)
        listed = page.get("/").text
        queries = [unescape(each) for each in re.findall(r'data-query="(.*?)"', listed)]
        (unknown,) = (each for each in queries if "unknown" in each)
        assert "data-trouble" in page.get(f"/inspection?{unknown}").text
        read = f"{unknown}&set.rate=20"
        assert "data-trouble" not in page.get(f"/inspection?{read}").text
        assert page.get(f"/sheet/sheet.html?{read}").status == 200
        process.terminate()
        assert process.wait(20) == 128 + 15


def test_workers_end_whatever_ends_the_page(folder, tmp_path):
    """Planted fault: an end between the first task and the wait left a thread, and the process."""

    class End(Exception):
        pass

    server = PageServer(Views(folder / "curves", tmp_path).session)

    def ready():
        raise End

    with pytest.raises(End):
        asyncio.run(server.serve(asyncio.Event(), ready))
    for each in server.workers.values():
        with pytest.raises(RuntimeError):
            each.submit(int)
