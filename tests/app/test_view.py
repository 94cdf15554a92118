"""`breaker view` without a browser: what its pages say, and whom they answer."""

import asyncio
import hashlib
import json
import re
import socket
from html import unescape
from pathlib import Path
from urllib.parse import urlencode

import numpy as np
import pytest
import yaml

from breaker.app.local_server import HOST, POLICY, PageServer
from breaker.app.page_text import list_page
from breaker.app.view_session import SHOWN, Session
from breaker.cli import main
from breaker.cli.view import commands
from tests.app.conftest import ODD, Outside, started, until

TODAY = "file=today.csv"


def test_a_list_has_names_at_once_and_what_is_in_the_files_when_it_is_asked(page, folder, tmp_path):
    names = list_page(Session(str(folder / "curves"), [], commands(), tmp_path), "", "")
    assert names.count("not looked into yet") == 4
    assert "Looked into 0 of 4 files" in names
    told = page.get("/?look=9").text
    assert "Looked into" not in told
    for text in ("HV-20417", "R, Y, B", "closing and opening", "2021-03-14", "Bay 4"):
        assert text in told
    assert "not looked into yet" in names
    assert "not looked into yet" not in told


def test_curves_have_every_channel_and_marks_lie_on_them(page):
    found = json.loads(page.get(f"/curves?{TODAY}").text)
    kinds = {each["name"]: each["kind"] for each in found["traces"]}
    assert kinds["Travel 1 R"] == "travel"
    assert kinds["Contact 2"] == "contact"
    assert kinds["Coil 3 (A)"] == "coil"
    part = json.loads(page.get(f"/curves?{TODAY}&from=50&to=60").text)["traces"][0]
    assert 50 <= len(part["x"]) < 60
    assert len({each["name"] for each in found["traces"]}) == len(found["traces"])
    marks = json.loads(page.get(f"/marks?{TODAY}").text)["marks"]
    travel = found["traces"][0]
    for mark in [
        each for each in marks if each["name"].endswith(" R") and each["y"][0] is not None
    ]:
        near = min(range(len(travel["x"])), key=lambda i: abs(travel["x"][i] - mark["x"][0]))
        assert abs(travel["y"][near] - mark["y"][0]) < 2.0  # mm; a sample is 0.2 ms


def test_curves_of_several_files_are_named_by_their_files(page):
    found = json.loads(page.get("/curves?file=one.csv&file=old.csv").text)["traces"]
    assert {each["name"].partition(": ")[0] for each in found} == {"one.csv", "old.csv"}


def test_curves_of_what_cannot_be_read_have_samples_and_no_times(page):
    wrong = f"{TODAY}&set.rate=-3"
    assert json.loads(page.get(f"/curves?{wrong}").text)["clock"] == "samples"
    assert "10 samples apart" in page.get(f"/cursors?{wrong}&first=10&second=20").text
    assert json.loads(page.get(f"/curves?{TODAY}").text)["clock"] == "ms"


def test_readings_at_cursors_are_those_of_the_file(page, folder):
    text = page.get(f"/cursors?{TODAY}&first=40&second=100").text
    lines = (folder / "curves" / "today.csv").read_text().splitlines()
    head = next(i for i, line in enumerate(lines) if "Travel 1 (mm)" in line)
    place = lines[head].split(",").index("Travel 1 (mm)")
    rows = [line.split(",") for line in lines[head + 1 :]]
    rows = [row for row in rows if re.fullmatch(r"-?[\d.]+", row[0])]
    first, second = (float(rows[round(at * 5.0)][place]) for at in (40, 100))
    cells = re.search(r"<td>Travel 1 R</td><td>(.*?)</td><td>(.*?)</td><td>(.*?)</td>", text)
    assert [float(each) for each in cells.groups()] == pytest.approx(
        [first, second, second - first], rel=1e-3
    )
    assert "is no time" in unescape(page.get(f"/cursors?{TODAY}&first=x").text)


@pytest.mark.parametrize("ending", ["html", "pdf"])
def test_a_sheet_is_that_of_the_command_with_the_settings_that_are_saved(
    page, folder, tmp_path, weasyprint, ending
):
    query = "file=one.csv&before=old.csv&same=1&set.zero=rest"
    settings = tmp_path / "my.yaml"
    said = page.post(f"/save?{query}", urlencode({"name": settings})).text
    assert said == f"written to {settings}"
    assert "zero: rest" in settings.read_text()
    output = tmp_path / f"sheet.{ending}"
    before = ["--before", str(folder / "curves" / "old.csv"), "--same-transducer"]
    assert "--same-transducer" in page.get(f"/visit?{query}").text
    config = ["--config", str(folder / "few.yaml"), str(settings)]
    named = str(folder / "curves" / "one.csv")
    assert main(["report", named, *before, *config, "--output", str(output)]) == 0
    sheet = page.get(f"/sheet.{ending}?{query}")
    assert sheet.content == output.read_bytes()
    assert 'filename="sheet' in sheet.headers["Content-Disposition"]


def test_a_reference_with_its_band_and_the_visit_before_lie_over_the_curves(
    opened, folder, tmp_path
):
    types = {"LTB 420": {"reference": str(folder / "curves" / "today.csv")}}
    (tmp_path / "types.yaml").write_text(yaml.safe_dump(types))
    (tmp_path / "good.yaml").write_text(yaml.safe_dump({"types": str(tmp_path / "types.yaml")}))
    overlays = [str(folder / "few.yaml"), str(tmp_path / "good.yaml")]
    page = opened(folder / "curves", tmp_path, overlays)
    found = json.loads(page.get("/curves?file=one.csv&before=old.csv").text)["traces"]
    laid = {each["name"]: each for each in found if each["laid"]}
    assert {name.partition(":")[0] for name in laid} == {"reference", "before"}
    own = next(each for each in found if each["kind"] == "travel" and not each["laid"])
    good = next(each for name, each in laid.items() if name.startswith("reference"))
    old = next(each for name, each in laid.items() if name.startswith("before"))
    halves = {round(high - y, 3) for y, high in zip(good["y"], good["high"], strict=True)}
    assert len(halves) == 1
    assert halves.pop() == pytest.approx(0.05 * 178.0, rel=0.03)  # mm, of the stroke
    assert "low" not in old
    for each in (good, old):  # aligned: one drive, whose noise is 0.1 mm
        at = [
            np.interp(x, own["x"], own["y"]) - y for x, y in zip(each["x"], each["y"], strict=False)
        ]
        assert max(map(abs, at)) < 3.0


def test_a_pdf_is_offered_where_it_can_be_made(page, weasyprint):
    assert f"/sheet.pdf?{TODAY}" in page.get(f"/answer?{TODAY}").text


def test_without_weasyprint_no_pdf_is_offered_and_one_that_is_asked_for_is_refused(
    page, no_weasyprint
):
    text = page.get(f"/answer?{TODAY}").text
    assert "/sheet.html?" in text
    assert "/sheet.pdf?" not in text
    refused = page.get(f"/sheet.pdf?{TODAY}")
    assert refused.status == 422
    assert "breaker-drive[pdf]" in refused.text


@pytest.mark.parametrize(
    ("query", "said"),
    [
        ("set.rate=fast", "is no number; write one"),
        ("set.rate=-3", "endurance.format.rate"),
        ("set.delimiter=;;", "endurance.format.delimiter"),
        ("set.seed=3", "the page has no setting"),
        ("set.time_unit=%22h%22", "endurance.format.time_unit"),
    ],
)
def test_a_wrong_setting_is_said_with_a_remedy(page, query, said):
    assert said in unescape(page.get(f"/visit?{TODAY}&{query}").text)


def test_names_and_texts_of_files_are_escaped_everywhere(page):
    listed = page.get("/?look=9").text
    assert "&lt;img src=x" in listed
    hostile = re.search(r'value="([^"]*img[^"]*)"', listed)[1]
    query = urlencode({"file": unescape(hostile)})
    pages = [listed, page.get(f"/visit?{query}").text, page.get(f"/answer?{query}").text]
    pages += [page.get(f"/{name}?{TODAY}").text for name in ("visit", "answer")]
    pages += [page.get(f"/cursors?{TODAY}&first=1&second=2").text]
    pages += [page.get("/visit?file=%3Cimg+src=x%3E").text]
    assert "Coil &lt;b&gt;" in pages[3]
    for each in pages:
        for raw in ("<img", "<script>alert", "<b>", 'onerror=alert(1)>"', ODD):
            assert raw not in each


@pytest.mark.parametrize("path", ["/", f"/visit?{TODAY}", f"/answer?{TODAY}", "/static/page.js"])
def test_nobody_else_is_answered(page, path):
    assert page.get(path).status == 200
    port = page.server.port
    for refused in (
        {"cookie": ""},
        {"cookie": f"breaker-{port}=guessed"},
        {"Host": f"evil.example:{port}"},
        {"Host": HOST},
        {"Origin": "http://evil.example"},
        {"Origin": "null"},
    ):
        assert page.get(path, **refused).status == 403


def test_a_token_opens_and_a_wrong_one_does_not(page):
    wrong = page.get("/?token=guessed", cookie="")
    assert wrong.status == 403
    assert "take the one on the terminal" in wrong.text
    right = page.get(f"/?token={page.server.token}", cookie="")
    assert right.status == 200
    cookie = right.headers["Set-Cookie"]
    assert "HttpOnly" in cookie
    assert "SameSite=Strict" in cookie


def test_nothing_is_changed_for_another_page(page, tmp_path):
    body = urlencode({"name": tmp_path / "a.yaml"})
    port = page.server.port
    for headers in (
        {},
        {"Origin": "http://evil.example"},
        {"Origin": f"http://{HOST}:{port}", "Sec_Fetch_Site": "cross-site"},
    ):
        answer = page.get(f"/save?{TODAY}", method="POST", body=body, **headers)
        assert answer.status == 403
    assert not list(tmp_path.iterdir())


def test_pages_load_nothing_from_elsewhere(page):
    for path in ("/", f"/visit?{TODAY}", f"/answer?{TODAY}", "/static/page.js", "/static/page.css"):
        answer = page.get(path)
        assert answer.headers["Content-Security-Policy"] == POLICY
        assert not re.search(r"""(src|href|url\(|fetch\()\s*=?\s*["'`]?(https?:)?//""", answer.text)
    assert "script-src 'self';" in POLICY
    assert page.get("/static/bokeh.min.js").status == 200
    assert page.get("/static/..%2f__init__.py").status == 404


def test_what_is_not_there_any_more_is_said(page, folder):
    lost = folder / "curves" / "lost.csv"
    lost.write_bytes((folder / "curves" / "today.csv").read_bytes())
    assert page.get("/visit?file=lost.csv").status == 200
    lost.unlink()
    answer = page.get("/visit?file=lost.csv")
    assert answer.status == 404
    assert "was it moved or renamed?" in answer.text
    assert page.get("/visit?file=../few.yaml").status == 404
    assert "no file is chosen" in page.get("/visit").text


def test_data_without_their_description_are_listed_with_what_is_lacking(tmp_path):
    """Planted: one of the two files of a COMTRADE record, as after copying it alone."""
    (tmp_path / "rec.dat").write_bytes(b"1,0,7\r\n2,100,8\r\n")
    (tmp_path / "two.cfg").write_text("")
    (tmp_path / "two.dat").write_bytes(b"1,0,7\r\n2,100,8\r\n")
    text = list_page(Session(str(tmp_path), [], commands(), tmp_path), "", "9")
    assert "rec.cfg" in text
    assert "Looked into" not in text
    assert "two.dat" not in text


def test_lines_of_a_user_are_not_replaced(page, tmp_path):
    mine = tmp_path / "mine.yaml"
    mine.write_text("seed: 3\n")
    body = urlencode({"name": mine})
    assert "it is not overwritten" in page.post(f"/save?{TODAY}", body).text
    assert mine.read_text() == "seed: 3\n"
    body = urlencode({"name": tmp_path / "none" / "a.yaml"})
    assert page.post(f"/save?{TODAY}", body).status == 422


def test_ten_thousand_files_are_listed_a_part_at_a_time(opened, tmp_path):
    (tmp_path / "many").mkdir()
    for k in range(10_000):
        (tmp_path / "many" / f"{k:05d}.csv").touch()
    text = opened(tmp_path / "many", tmp_path).get("/?page=3").text
    assert f"Files {2 * SHOWN + 1} to {3 * SHOWN} of 10000" in text
    assert "the workflow is made" in text


def test_records_are_never_changed(opened, folder, tmp_path):
    def state():
        files = sorted((folder / "curves").iterdir())
        return [(f, f.stat().st_mtime_ns, hashlib.sha256(f.read_bytes()).digest()) for f in files]

    before = state()
    page = opened(folder / "curves", tmp_path, [str(folder / "few.yaml")])
    for path in ("/?look=9", f"/visit?{TODAY}", f"/sheet.html?{TODAY}"):
        page.get(path.replace("today", "one"))
    named = urlencode({"name": folder / "curves" / "today.csv"})
    assert "is not overwritten" in page.post(f"/save?{TODAY}", named).text
    assert state() == before


def test_two_windows_and_two_sessions_do_not_disturb_each_other(page, opened, folder, tmp_path):
    other = opened(folder / "curves", tmp_path, [str(folder / "few.yaml")])
    one = "/answer?file=one.csv"
    plain = page.get(one).text
    assert other.get(f"{one}&set.ratio=2").text != plain
    assert page.get(one).text == plain == other.get(one).text
    assert other.get("/", cookie=f"breaker-{page.server.port}={page.server.token}").status == 403


def test_what_is_being_written_is_written_though_the_browser_is_closed(page, tmp_path):
    target, port = tmp_path / "left.yaml", page.server.port
    body = urlencode({"name": target})
    with socket.create_connection((HOST, port)) as browser:
        head = f"POST /save?file=one.csv HTTP/1.1\r\nHost: {HOST}:{port}\r\n"
        head += f"Origin: http://{HOST}:{port}\r\nCookie: breaker-{port}={page.server.token}\r\n"
        head += "Content-Type: application/x-www-form-urlencoded\r\n"
        browser.sendall(f"{head}Content-Length: {len(body)}\r\n\r\n{body}".encode())
    until(target.exists, "the settings")
    assert yaml.safe_load(target.read_text()) is not None


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
    with started(command=["-c", script], errors=tmp_path / "errors") as process:
        page = Outside(process.line)
        for path in (
            *("/", "/?look=9", f"/visit?{TODAY}", f"/answer?{TODAY}", f"/curves?{TODAY}"),
            *(f"/marks?{TODAY}", f"/sheet.html?{TODAY}"),
            *("/static/page.js", "/static/bokeh.min.js"),
        ):
            assert page.get(path).status in (200, 404)
    assert (tmp_path / "errors").read_text() == ""


def test_requests_beyond_the_bound_are_refused(page):
    port = page.server.port
    with socket.create_connection((HOST, port), timeout=20) as browser:
        head = f"POST /save?{TODAY} HTTP/1.1\r\nHost: {HOST}:{port}\r\n"
        browser.sendall(f"{head}Content-Length: {1 << 20}\r\n\r\n".encode())
        assert b" 200 " not in browser.recv(4096)


def test_a_file_that_changes_while_it_is_shown_is_said(opened, folder, tmp_path):
    (tmp_path / "curves").mkdir()
    shown = tmp_path / "curves" / "a.csv"
    shown.write_bytes((folder / "curves" / "one.csv").read_bytes())
    page = opened(tmp_path / "curves", tmp_path, [str(folder / "few.yaml")])
    text = unescape(page.get("/visit?file=a.csv").text)
    query = re.search(r'data-query="([^"]*)"', text)[1]
    asked = [f"/{name}?{query}" for name in ("curves", "answer", "marks", "sheet.html")]
    asked.append(f"/cursors?{query}&first=1&second=2")
    before = page.get("/curves?file=a.csv").text
    assert {page.get(each).status for each in asked} == {200}
    shown.write_bytes((folder / "curves" / "old.csv").read_bytes())
    for each in asked:
        found = page.get(each)
        assert found.status == 409
        assert "load the page again" in found.text
    assert re.search(r'data-query="([^"]*)"', page.get("/visit?file=a.csv").text)[1] != query
    assert page.get("/curves?file=a.csv").text != before


def test_a_folder_that_goes_and_comes_back_is_said(opened, folder, tmp_path):
    (tmp_path / "curves").mkdir()
    (tmp_path / "curves" / "a.csv").write_bytes((folder / "curves" / "one.csv").read_bytes())
    page = opened(tmp_path / "curves", tmp_path)
    (tmp_path / "curves").rename(tmp_path / "away")
    for path in ("/", "/visit?file=a.csv"):
        found = page.get(path)
        assert found.status == 404
        assert "Put it back" in found.text
    (tmp_path / "away").rename(tmp_path / "curves")
    assert page.get("/visit?file=a.csv").status == 200
    (tmp_path / "curves" / "b.csv").touch()
    assert "b.csv" in page.get("/").text  # the list is made anew where the folder has changed


def test_a_folder_that_cannot_be_read_is_said_with_a_remedy(folder, monkeypatch, capsys):
    def refused(path):
        raise PermissionError(13, "Permission denied", path)

    monkeypatch.setattr("breaker.app.view_session.os.listdir", refused)
    assert main(["view", str(folder / "curves")]) == 1
    assert "ask for the right to read it" in capsys.readouterr().err


def test_a_port_in_use_and_a_folder_that_is_not_there(page, folder, tmp_path, capsys):
    session = Session(str(folder / "curves"), [], commands(), tmp_path)
    with pytest.raises(OSError, match="leave --port out"):
        PageServer(session, page.server.port)
    assert main(["view", str(tmp_path / "none")]) == 1
    assert "name a folder of exports" in capsys.readouterr().err


def test_the_example_leads_from_an_unknown_export_to_a_sheet():
    """What lacks stands first; filled in, it is read; and the visits of the breaker differ."""
    with started(command=["-m", "breaker", "view", "--example", "--no-browser"]) as process:
        page = Outside(process.line)
        assert page.get("/").text.count("visit_20") > 2
        text = unescape(page.get("/visit?file=unknown.txt").text)
        assert re.search(r'<tr class="(\w+)">\s*<td><label for="set-(\w+)"', text).groups() == (
            "lacking",
            "rate",
        )
        assert "No sheet yet" in text
        filled = "file=unknown.txt&set.rate=20"
        assert "No sheet yet" not in page.get(f"/visit?{filled}").text
        assert "<h1>Test report</h1>" in page.get(f"/sheet.html?{filled}").text
        both = "file=visit_2026-03-02.csv&before=visit_2014-05-12.csv"
        answer = unescape(page.get(f"/answer?{both}").text)
        assert re.search("<h2>[^<]*2014-05-12", answer)
        assert str(Path("example")) not in page.get(f"/visit?{both}").text.partition("<main")[0]
    assert main(["view", "somewhere", "--example"]) == 1


def test_without_the_extra_one_line_says_what_to_install(monkeypatch, capsys):
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    assert main(["view", "."]) == 1
    assert capsys.readouterr().err.count("\n") == 1


def test_the_command_prints_its_address_and_ends(folder):
    with started(folder / "curves") as process:
        process.terminate()
        assert process.wait(20) == 128 + 15
    assert re.fullmatch(rf"the page is at http://{HOST}:\d+/\?token=[\w-]{{32}}\n", process.line)


def test_workers_end_whatever_ends_the_page(folder, tmp_path):
    """Planted fault: an end between the first task and the wait left a thread, and the process."""

    class End(Exception):
        pass

    server = PageServer(Session(str(folder / "curves"), [], commands(), tmp_path))

    def ready():
        server.slow.submit(int)
        raise End

    with pytest.raises(End):
        asyncio.run(server.serve(asyncio.Event(), ready))
    for each in (server.quick, server.slow):
        with pytest.raises(RuntimeError):
            each.submit(int)
