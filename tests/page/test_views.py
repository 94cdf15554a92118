"""Answers of the views of the page, without a server."""

import re
from html import unescape
from urllib.parse import urlencode

import numpy as np
import pytest
import yaml

from breaker.cli import main
from tests.exports import record
from tests.page.conftest import ODD, REFUSED, Views, line

LINE, TODAY, STROKE = "file=line.csv", "file=today.csv", "closing stroke"


def value(ask, query, words):
    """Value of a quantity of the first motion at its first phase."""
    cells = rf"<td>{words}</td><td>[^<]*</td><td[^>]*>([\d.]+)"
    return float(re.search(cells, ask(f"/inspection?{query}"))[1])


def test_the_list_groups_poles_and_links_each_inspection_with_the_one_before(ask):
    listed = unescape(ask("/"))
    for text in ("HV-20417", "2021-03-14", "LTB 420"):
        assert text in listed
    groups = [re.findall(r' data-query="(.*?)"', item) for item in listed.split("<tbody>")]
    trips = "&".join(f"file=trip_{phase}.csv" for phase in "BRY")
    assert ["file=one.csv&before=old.csv", "file=old.csv"] in groups  # the newest first
    assert "arrays.nc" in listed  # a format that is not read
    assert [f"{TODAY}&{trips.replace('file', 'before')}", trips] in groups


def test_a_limit_changes_the_verdict_until_it_is_removed(ask):
    query, verdicts = f"{LINE}&type=T 1", []
    for ends in (("99", "101"), ("100", "110"), ("", "90,5"), ("", "")):  # a decimal comma
        assert ask.set("t1" if verdicts else "T 1", STROKE, *ends) != REFUSED  # the same type
        verdicts.append(ask(f"/verdict?{query}")["verdict"])
        assert f'id="verdict" class="{verdicts[-1]}"' in ask(f"/inspection?{query}")
        if ends[1] == "90,5":
            entry = {"limits": {STROKE: [None, 90.5]}}
            assert yaml.safe_load(ask.types.read_text()) == {"T 1": entry}
    assert verdicts == ["pass", "inconclusive", "fail", "none"]
    assert ask(f"/verdict?{LINE}&type=Other")["verdict"] == "none"  # a type without an entry
    assert ask("/verdict?file=bare.csv&type=T 1")["verdict"] == "unread"


@pytest.mark.parametrize(
    ("name", "quantity", "ends"),
    [
        ("T", STROKE, ["184", "170"]),
        ("T", STROKE, ["wide", ""]),
        ("", STROKE, ["170", "184"]),
        ("T", "closing nonsense", ["1", "2"]),
    ],
)
def test_a_wrong_limit_is_refused_with_nothing_written(ask, name, quantity, ends):
    assert ask.set(name, quantity, *ends) == REFUSED
    assert not ask.types.exists()
    ask.set("T", STROKE, "90", "110")
    held = ask.types.read_bytes()
    assert ask.set(name, quantity, *ends) == REFUSED
    assert ask.types.read_bytes() == held


def test_a_limit_can_be_set_on_each_quantity_of_the_form(ask):
    form = ask(f"/inspection?{TODAY}").partition('id="limit"')[2].partition("</form>")[0]
    names = re.findall('<option value="(.*?)">', form)
    assert {"closing stroke", "opening stroke", "closing_speed", "opening_over_travel"} <= {*names}
    assert "closing speed (m/s)</option>" in form
    for name in names:
        assert ask.set("T", name, "1") != REFUSED


def test_the_entry_of_a_type_scales_its_records(ask):
    ask.types.write_text("T: {ratio: 0.5}")
    assert value(ask, f"{LINE}&type=T", "stroke") == pytest.approx(50.0, rel=1e-3)
    assert value(ask, LINE, "stroke") == pytest.approx(100.0, rel=1e-3)


def test_a_motion_has_a_plot_with_all_phases_as_the_file_has_them(ask):
    columns = record(rate=5.0, motions=("closing", "opening"), noise=0.01)
    closing, opening = ask.motions(TODAY)
    for result in (closing, opening):
        for k, phase in enumerate("RYB"):
            assert {f"{phase} velocity", f"{phase} contact"} <= {*result}
            time, travel = result[f"{phase} travel"]
            there = columns[f"Travel {k + 1} (mm)"][np.rint(5.0 * time).astype(int)]
            assert travel == pytest.approx(there, abs=1e-4, nan_ok=True)


def test_planted_values_are_measured_and_shown_where_they_are(ask):
    (result,) = ask.motions(LINE)
    time, velocity = result[" velocity"]
    assert velocity[(time > 55) & (time < 105)] == pytest.approx(100 / 60, rel=1e-3)
    assert value(ask, LINE, "travel time") == pytest.approx(48.0, rel=2e-3)
    assert result["first motion"] == pytest.approx([49.0, 0.0], abs=1.5)


def test_the_inspection_before_and_a_reference_lie_over_it(ask, folder):
    good = str(folder / "curves" / "today.csv")
    ask.types.write_text(yaml.safe_dump({"LTB 420": {"reference": good}}))
    (result,) = ask.motions("file=one.csv&before=old.csv")
    ((time, travel),) = (data for name, data in result.items() if name.endswith(" travel"))
    for which in ("earlier", "reference"):
        (laid,) = (data for name, data in result.items() if f"{which}:" in name)
        near = laid[:, np.abs(laid[0] - np.interp(89.0, travel, time)) < 5.0]
        difference = np.interp(near[0], time, travel) - near[1]
        assert np.abs(difference).max() < 2.0  # mm; in half a sample it moves 0.5 mm


def test_a_doubtful_sample_is_drawn_as_one(tmp_path):
    line(tmp_path / "spike.csv", spike=20.0)
    (result,) = Views(tmp_path, tmp_path).motions("file=spike.csv")
    (time, travel), (_, doubtful) = result[" travel"], result[" doubtful samples"]
    assert np.isnan(travel[time == 80.0])
    assert doubtful[time == 80.0] == pytest.approx(70.0, abs=1e-6)


@pytest.mark.parametrize("rate", ["", "-3", "fast", "20"])
def test_a_file_that_cannot_be_read_has_a_form_to_decide(ask, rate):
    fields = re.split(r'(?=name="set\.)', ask("/inspection?file=bare.csv"))[1:]
    result = r'^name="(.*?)".*?value="([^"]*)"( selected|>\n<small)'  # of a choice, or of a text
    sent = {e[1]: unescape(e[2]) for e in (re.search(result, f, re.S) for f in fields)}
    query = urlencode({"file": "bare.csv", **sent, "set.rate": rate})  # as a browser sends it
    text = ask(f"/inspection?{query}")
    (state,) = re.findall(r'<div class="(\w+)"><label for="set-rate"', text)
    assert state == ("chosen" if rate else "missing")
    assert ask(f"/inspection?{LINE}&set.seed=3") == REFUSED
    if rate == "20":
        assert value(ask, query, "travel time") == pytest.approx(24.0, rel=1e-3)
    else:
        assert 'id="verdict" class="unread"' in text
        assert "Sampling rate (kHz)" in ask(f"/verdict?{query}")["text"]
        assert ask(f"/sheet?{query}") == REFUSED


def test_a_sheet_and_its_verdict_are_those_of_the_command_with_the_lines_that_are_shown(
    ask, folder, tmp_path, capsys
):
    ask.set("LTB 420", STROKE, "100", "170")
    query = "file=one.csv&before=old.csv&same=1&set.zero=rest"
    settings, output = tmp_path / "my.yaml", tmp_path / "sheet.html"
    lines = re.search('<pre id="lines".*?>(.*?)</pre>', ask(f"/inspection?{query}"), re.S)[1]
    settings.write_text(unescape(lines))
    named, before = (str(folder / "curves" / name) for name in ("one.csv", "old.csv"))
    words = [named, "--before", before, "--same-transducer", "--output", str(output)]
    assert main(["report", *words, "--config", str(folder / "few.yaml"), str(settings)]) == 0
    assert ask(f"/sheet?{query}") == output.read_text(encoding="utf-8")
    assert capsys.readouterr().out.startswith("FAIL")
    assert ask(f"/verdict?{query}")["verdict"] == "fail"


def test_names_and_texts_of_files_are_escaped_everywhere(ask):
    ask.set("<b>T", STROKE, "1", "2")
    listed = ask("/")
    (hostile,) = re.findall(r'data-query="(\S*img\S*)"', listed)
    queries = unescape(hostile), TODAY, f"{LINE}&type=%3Cb%3ET"
    pages = [listed, *(ask(f"/inspection?{query}") for query in queries)]
    assert ("Coil &lt;b&gt;" in pages[2], "&lt;b&gt;T" in pages[3]) == (True, True)
    for raw in ("<img src=x", "<script>alert", "<b>", ODD):
        assert not [page for page in pages if raw in page]
