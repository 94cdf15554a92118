"""What the views of the page answer, asked without a server."""

import re
from html import unescape
from urllib.parse import urlencode

import numpy as np
import pytest
import yaml

from breaker.cli import main
from breaker.diagnosis.session import Diagnosis
from breaker.family.networks import shipped_levels
from tests.exports import record
from tests.page.conftest import ODD, REFUSED, Views, line

LINE, TODAY, STROKE = "file=line.csv", "file=today.csv", "limits.closing stroke"


def curves(ask, query):
    """Data of the curves of a tab by name."""
    result = [curve for panel in ask(f"/curves?{query}")["panels"] for curve in panel["curves"]]
    return {
        f"{curve['phase']} {curve['name']}": {
            axis: np.array(curve[axis], dtype=float) for axis in "xy"
        }
        for curve in result
    }


def value(ask, query, name):
    """Value and verdict of a quantity of closing at its first phase."""
    rows = re.split(r"<tr\b", ask(f"/values?{query}")["parts"]["values"])
    row = next(item for item in rows if f'"limits.closing {name}"' in item)
    return float(re.search("<td.*?>(.*?)<", row)[1]), re.match(' class="(.*?)"', row)[1]


def test_the_list_has_names_at_once_and_poles_of_an_inspection_in_one_row_later(ask):
    names, listed = ask("/"), unescape(ask.listed())
    assert 'data-seen="0" data-count="9"' in names
    assert (names.count(" data-unseen"), listed.count(" data-unseen")) == (9, 0)
    for text in ("HV-20417", "2021-03-14", "LTB 420"):
        assert (text in names, text in listed) == (False, True)
    groups = [re.findall(r' data-query="(.*?)"', item) for item in listed.split("<tbody>")]
    trips = "&".join(f"file=trip_{phase}.csv" for phase in "BRY")
    assert ["file=one.csv&before=old.csv", "file=old.csv"] in groups  # the newest first
    assert [f"{TODAY}&{trips.replace('file', 'before')}", trips] in groups


def test_a_limit_changes_the_verdict_until_it_is_removed(ask):
    query, verdicts = f"{LINE}&type=T 1", []
    for ends in (("99", "101"), ("100", "110"), ("", "90,5"), ("", "")):  # a decimal comma
        assert ask.set("t1" if verdicts else "T 1", STROKE, *ends) != REFUSED  # the same type
        verdicts.append(ask(f"/verdict?{query}")["verdict"])
        row = value(ask, query, "stroke")[1] or "none"
        assert f'class="banner {row}"' in ask(f"/values?{query}")["parts"]["verdict"]
        assert row == verdicts[-1]
        if ends[1] == "90,5":
            entry = {"limits": {"closing stroke": [None, 90.5]}}
            assert yaml.safe_load(ask.types.read_text()) == {"T 1": entry}
    assert verdicts == ["pass", "inconclusive", "fail", "none"]
    assert ask(f"/verdict?{LINE}&type=Other")["verdict"] == "none"  # a type without an entry
    assert ask("/verdict?file=bare.csv&type=T 1")["verdict"] == "unread"


def test_estimates_are_made_once_whatever_the_limits(ask, monkeypatch):
    made, infer = [], Diagnosis.infer
    monkeypatch.setattr(
        Diagnosis, "infer", lambda self, records: made.append(self.families) or infer(self, records)
    )
    parts = []
    for ends in (("", ""), ("99", "101"), ("", "90")):
        ask.set("T", STROKE, *ends)
        parts.append(ask(f"/model?{LINE}&type=T")["parts"])
    assert made.count(shipped_levels) == 1
    assert len({part["model"] for part in parts}) == 1
    assert len({part["verdict"] for part in parts}) == 3


@pytest.mark.parametrize(
    ("name", "key", "ends"),
    [
        ("T", STROKE, ["184", "170"]),
        ("T", STROKE, ["wide", ""]),
        ("", STROKE, ["170", "184"]),
        ("T", "limits.closing nonsense", ["1", "2"]),
        ("T", "colour.red", ["1", "2"]),
        ("T", "speeds.closing_speed", ["10 % of stroke", "far"]),
    ],
)
def test_a_wrong_value_of_a_type_is_refused_with_nothing_written(ask, name, key, ends):
    assert ask.set(name, key, *ends) == REFUSED
    assert not ask.types.exists()
    ask.set("T", STROKE, "90", "110")
    held = ask.types.read_bytes()
    assert ask.set(name, key, *ends) == REFUSED
    assert ask.types.read_bytes() == held


def test_a_type_has_its_speed_zone(ask):
    """Its ratio, which the page does not set, counts in the same way."""
    query = f"{LINE}&type=T"
    ask.set("T", "speeds.closing_speed", "20 % of stroke", "50 % of stroke")
    assert value(ask, query, "closing_speed")[0] == pytest.approx(100 / 60, rel=2e-3)
    (zone,) = (m["x"] for m in ask(f"/values?{query}")["marks"][0] if m["name"] == "speed zone")
    assert zone == pytest.approx([62.0, 80.0], rel=2e-3)
    ask.types.write_text("T: {ratio: 0.5}")
    assert value(ask, query, "stroke")[0] == pytest.approx(50.0, rel=1e-3)
    assert value(ask, LINE, "stroke")[0] == pytest.approx(100.0, rel=1e-3)


def test_a_motion_has_a_tab_with_all_phases_as_the_file_has_them(ask):
    assert re.findall(r'data-tab="(.)"', ask(f"/inspection?{TODAY}")) == ["0", "1"]
    columns = record(rate=5.0, motions=("closing", "opening"), noise=0.01)
    for tab in (0, 1):
        result = curves(ask, f"{TODAY}&tab={tab}")
        for k, phase in enumerate("RYB"):
            assert {f"{phase} velocity", f"{phase} contact"} <= {*result}
            travel = result[f"{phase} travel"]
            there = columns[f"Travel {k + 1} (mm)"][np.rint(5.0 * travel["x"]).astype(int)]
            assert travel["y"] == pytest.approx(there, abs=1e-4, nan_ok=True)
    assert ask(f"/curves?{TODAY}&tab=2") == 404


def test_planted_values_are_measured_and_shown_where_they_are(ask):
    result = curves(ask, f"{LINE}&tab=0")[" velocity"]
    within = (result["x"] > 55) & (result["x"] < 105)
    assert result["y"][within] == pytest.approx(100 / 60, rel=1e-3)
    assert value(ask, LINE, "stroke")[0] == pytest.approx(100.0, rel=1e-3)
    for name, planted in {"travel_time": 48.0, "closing_speed_10_50": 100 / 60}.items():
        assert value(ask, LINE, name)[0] == pytest.approx(planted, rel=2e-3)
    marks = {mark["name"]: mark for mark in ask(f"/values?{LINE}")["marks"][0]}
    assert [*marks["first motion"]["x"], *marks["first motion"]["y"]] == pytest.approx(
        [49.0, 0.0], abs=1.5
    )


def test_the_inspection_before_and_a_reference_lie_over_it(ask, folder):
    good = str(folder / "curves" / "today.csv")
    ask.types.write_text(yaml.safe_dump({"LTB 420": {"reference": good}}))
    result = curves(ask, "file=one.csv&before=old.csv&tab=0")
    (own,) = (data for name, data in result.items() if name.endswith(" travel"))
    for which in ("earlier", "reference"):
        (laid,) = (data for name, data in result.items() if f"{which}:" in name)
        near = np.abs(laid["x"] - np.interp(89.0, own["y"], own["x"])) < 5.0
        apart = np.interp(laid["x"][near], own["x"], own["y"]) - laid["y"][near]
        assert np.abs(apart).max() < 2.0  # mm; in half a sample it moves 0.5 mm


def test_a_doubtful_sample_is_drawn_as_one(tmp_path):
    line(tmp_path / "spike.csv", spike=20.0)
    result = curves(Views(tmp_path, tmp_path), "file=spike.csv&tab=0")
    at = result[" travel"]["x"] == 80.0
    assert np.isnan(result[" travel"]["y"][at])
    assert result[" doubtful samples"]["y"][at] == pytest.approx(70.0, abs=1e-6)


@pytest.mark.parametrize("rate", ["", "-3", "fast", "20"])
def test_what_cannot_be_read_shows_its_columns_and_a_form_to_decide(ask, rate):
    fields = re.split(r'(?=name="set\.)', ask("/inspection?file=bare.csv"))[1:]
    result = r'^name="(.*?)".*?value="([^"]*)"( selected|>\n<small)'  # of a choice, or of a text
    sent = {e[1]: unescape(e[2]) for e in (re.search(result, f, re.S) for f in fields)}
    query = urlencode({"file": "bare.csv", **sent, "set.rate": rate})  # as a browser sends it
    text = ask(f"/inspection?{query}")
    (state,) = re.findall(r'<div class="(\w+)"><label for="set-rate"', text)
    assert state == ("chosen" if rate else "missing")
    assert ask(f"/inspection?{LINE}&set.seed=3") == REFUSED
    if rate == "20":
        assert "data-trouble" not in text
        assert value(ask, query, "travel_time")[0] == pytest.approx(24.0, rel=1e-3)
    else:
        assert "data-trouble" in text
        assert ask(f"/values?{query}") == REFUSED
        assert curves(ask, query)["reading reading"]["y"].max() == 100.0


def test_a_sheet_and_its_verdict_are_those_of_the_command_with_the_lines_that_are_shown(
    ask, folder, tmp_path, capsys
):
    ask.set("LTB 420", STROKE, "100", "170")
    query = "file=one.csv&before=old.csv&same=1&set.zero=rest"
    settings, output = tmp_path / "my.yaml", tmp_path / "sheet.html"
    lines = re.search('<pre id="lines">(.*?)</pre>', ask(f"/inspection?{query}"), re.S)[1]
    settings.write_text(unescape(lines))
    named, before = (str(folder / "curves" / name) for name in ("one.csv", "old.csv"))
    words = [named, "--before", before, "--same-transducer", "--output", str(output)]
    assert main(["report", *words, "--config", str(folder / "few.yaml"), str(settings)]) == 0
    assert ask(f"/sheet?{query}") == output.read_text(encoding="utf-8")
    assert capsys.readouterr().out.startswith("FAIL")
    assert ask(f"/verdict?{query}")["verdict"] == "fail"


def test_names_and_texts_of_files_are_escaped_everywhere(ask):
    ask.set("<b>T", STROKE, "1", "2")
    listed, typed = ask.listed(), f"{LINE}&type=%3Cb%3ET"
    (hostile,) = re.findall(r'data-query="(\S*img\S*)"', listed)
    pages = [listed, *(ask(f"/inspection?{item}") for item in (unescape(hostile), TODAY, typed))]
    pages += ask(f"/model?{TODAY}")["parts"].values()
    pages += ask(f"/values?{typed}")["parts"].values()
    assert ("Coil &lt;b&gt;" in pages[2], "&lt;b&gt;T" in pages[3]) == (True, True)
    for raw in ("<img src=x", "<script>alert", "<b>", ODD):
        assert not [page for page in pages if raw in page]
