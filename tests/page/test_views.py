"""What the views of the page answer, asked without a server."""

import re
from html import unescape

import numpy as np
import pytest
import yaml
from bokeh.document import Document
from bokeh.models import ColumnDataSource

from breaker.cli import main
from breaker.page.session import MissingError
from tests.exports import record
from tests.page.conftest import ODD, Views, line

LINE, TODAY = "file=line.csv", "file=today.csv"


def curves(ask, query):
    """Data of the curves of a tab by name."""
    found = Document.from_json(ask(f"/curves?{query}")["doc"])
    return {each.name: each.data for each in found.select({"type": ColumnDataSource})}


def rows(text):
    """Queries of the rows of a list, by the names of their breakers."""
    groups = re.split(r'<tr class="breaker">', unescape(text))[1:]
    return {
        re.search(r"<th[^>]*>(.*)", each)[1].strip(): re.findall(r' data-query="(.*?)"', each)
        for each in groups
    }


def value(ask, query, key):
    """Value, verdict, and spot of the only phase of a quantity, such as "closing stroke"."""
    row = re.search(
        rf'<tr class="(\w*)">(?:(?!<tr).)*data-key="{key}"',
        ask(f"/values?{query}")["parts"]["values"],
        re.S,
    )
    cell = re.search(r'data-from="(.*?)" data-to="(.*?)"[^>]*>(.*?)<', row[0])
    return float(cell[3]), row[1], (float(cell[1]), float(cell[2]))


def states(text):
    """State of each import setting."""
    return {
        key: state for state, key in re.findall(r'<div class="(\w+)"><label for="set-(\w+)"', text)
    }


# ---- the list


def test_names_stand_in_the_list_at_once_and_headers_later(ask):
    names = ask("/")
    assert 'data-seen="0" data-count="9"' in names
    assert names.count(" data-unseen") == 9
    assert "HV-20417" not in names
    told = ask.listed()
    assert "data-unseen" not in told
    for text in ("HV-20417", "2021-03-14", "LTB 420", "closing", "opening"):
        assert text in told


def test_the_list_groups_by_breaker_and_date_and_poles_share_a_row(ask):
    trips = "&".join(f"file=trip_{phase}.csv" for phase in "BRY")
    found = rows(ask.listed())
    at_7, at_20417 = (
        next(v for k, v in found.items() if name in k) for name in ("HV-7", "HV-20417")
    )
    assert at_7 == ["file=old.csv", "file=one.csv&before=old.csv"]
    assert at_20417 == [trips, f"{TODAY}&{trips.replace('file', 'before')}"]


def test_ten_thousand_files_are_listed_and_no_more(tmp_path):
    (tmp_path / "many").mkdir()
    for k in range(10_001):
        (tmp_path / "many" / f"{k:05d}.csv").touch()
    assert 'data-count="10000"' in Views(tmp_path / "many", tmp_path)("/")


@pytest.mark.parametrize(
    ("ends", "verdict"),
    [(("99", "101"), "pass"), (("", "90"), "fail"), (("100", ""), "inconclusive"), ((), "none")],
)
def test_a_row_has_its_verdict(ask, ends, verdict):
    if ends:
        ask.set("T", "limits.closing stroke", *ends)
    assert ask(f"/verdict?{LINE}&type=T")["verdict"] == verdict
    assert ask("/verdict?file=bare.csv&type=T")["verdict"] == "unread"


# ---- limits and types


def test_a_limit_is_judged_by_the_page_and_by_the_command_alike(ask, folder, tmp_path):
    one = "file=one.csv"
    before = ask(f"/verdict?{one}")["verdict"]
    ask.set("LTB 420", "limits.closing stroke", "100", "170,5")  # a decimal comma
    limits = {"closing stroke": [100, 170.5]}
    assert yaml.safe_load(ask.types.read_text()) == {"LTB 420": {"limits": limits}}
    assert (before, ask(f"/verdict?{one}")["verdict"]) == ("none", "fail")
    assert value(ask, one, "closing stroke")[1] == "fail"
    assert 'class="banner fail"' in ask(f"/values?{one}")["parts"]["verdict"]
    (tmp_path / "my.yaml").write_text(yaml.safe_dump({"types": str(ask.types)}))
    config = ["--config", str(folder / "few.yaml"), str(tmp_path / "my.yaml")]
    output = tmp_path / "sheet.html"
    named = str(folder / "curves" / "one.csv")
    assert main(["report", named, *config, "--output", str(output)]) == 0
    assert output.read_bytes() == ask(f"/sheet/sheet.html?{one}")
    ask.set("ltb420", "limits.closing stroke", "", "")  # the same type
    assert ask(f"/verdict?{one}")["verdict"] == "none"


@pytest.mark.parametrize(
    ("name", "key", "ends"),
    [
        ("T", "limits.closing stroke", ("184", "170")),
        ("T", "limits.closing stroke", ("wide", "")),
        ("T", "limits.closing nonsense", ("1", "2")),
        ("T", "colour.red", ("1", "2")),
        ("T", "ratio", ("-1",)),
        ("T", "speeds.closing_speed", ("10 % of stroke", "far")),
        ("", "limits.closing stroke", ("170", "184")),
    ],
)
def test_a_wrong_limit_is_refused_with_nothing_written(ask, name, key, ends):
    with pytest.raises(ValueError):
        ask.set(name, key, *ends)
    assert not ask.types.exists()
    ask.set("T", "limits.closing stroke", "90", "110")
    before = ask.types.read_bytes()
    with pytest.raises(ValueError):
        ask.set(name, key, *ends)
    assert ask.types.read_bytes() == before


def test_a_type_has_its_speed_zone_and_ratio(ask):
    query = f"{LINE}&type=T"
    ask.set("T", "speeds.closing_speed", "20 % of stroke", "50 % of stroke")
    speed, _, spot = value(ask, query, "closing closing_speed")
    assert speed == pytest.approx(100 / 60, rel=1e-3)
    assert spot == pytest.approx((62.0, 80.0), abs=0.1)
    ask.set("T", "ratio", "0.5")
    assert value(ask, query, "closing stroke")[0] == pytest.approx(50.0, rel=1e-3)
    assert value(ask, LINE, "closing stroke")[0] == pytest.approx(100.0, rel=1e-3)


def test_types_are_exported_and_imported(ask, folder, tmp_path):
    with pytest.raises(MissingError):
        ask("/types.yaml")
    ask.set("T", "limits.closing stroke", "99", "101")
    content = ask("/types.yaml")
    assert content == ask.types.read_bytes()
    (tmp_path / "other").mkdir()
    other = Views(folder / "curves", tmp_path / "other")
    other.set("U", "ratio", "2")
    other("/import", content)
    assert {*yaml.safe_load(other.types.read_text())} == {"T", "U"}
    assert other(f"/verdict?{LINE}&type=T")["verdict"] == "pass"
    before = other.types.read_bytes()
    for wrong in (b"", b"- 1", b"\xff\xfe", b"T: {limits: {closing stroke: [3, 1]}}", b"a: ["):
        with pytest.raises(ValueError):
            other("/import", wrong)
        assert other.types.read_bytes() == before


def test_a_type_without_an_entry_is_no_error(ask):
    ask.set("T", "ratio", "2")
    query = f"{LINE}&type=Nobody"
    assert "data-trouble" not in ask(f"/inspection?{query}")
    assert ask(f"/verdict?{query}")["verdict"] == "none"


# ---- curves and values


def test_a_motion_has_a_tab_with_all_phases_as_the_file_has_them(ask):
    assert re.findall(r'data-tab="(.)"', ask(f"/inspection?{TODAY}")) == ["0", "1"]
    columns = record(rate=5.0, motions=("closing", "opening"), noise=0.01)
    for tab in (0, 1):
        found = curves(ask, f"{TODAY}&tab={tab}")
        for k, phase in enumerate("RYB"):
            assert {f"{phase} {name}" for name in ("velocity", "contact")} <= {*found}
            travel = found[f"{phase} travel"]
            there = columns[f"Travel {k + 1} (mm)"][np.rint(5.0 * travel["x"]).astype(int)]
            assert travel["y"] == pytest.approx(there, abs=1e-6, nan_ok=True)
    with pytest.raises(MissingError):
        ask(f"/curves?{TODAY}&tab=2")


def test_velocity_is_the_planted_slope_and_values_show_where_they_are_measured(ask):
    found = curves(ask, f"{LINE}&tab=0")[" velocity"]
    within = (found["x"] > 55) & (found["x"] < 105)
    assert found["y"][within] == pytest.approx(100 / 60, rel=1e-3)
    for key, planted, spot in (
        ("closing stroke", 100.0, None),
        ("closing travel_time", 48.0, (56.0, 104.0)),
        ("closing closing_speed_10_50", 100 / 60, (56.0, 80.0)),
    ):
        measured, _, ends = value(ask, LINE, key)
        assert measured == pytest.approx(planted, rel=1e-3)
        assert spot is None or ends == pytest.approx(spot, abs=0.1)
    marks = ask(f"/values?{LINE}")["marks"][0]["marks"]
    assert marks["x"][marks["name"].index("first motion")] == pytest.approx(50.0, abs=0.2)


def test_the_inspection_before_and_a_reference_lie_over_it_at_half_of_the_travel(ask, folder):
    good = str(folder / "curves" / "today.csv")
    ask.types.write_text(yaml.safe_dump({"LTB 420": {"reference": good}}))
    found = curves(ask, "file=one.csv&before=old.csv&tab=0")
    (own,) = (data for name, data in found.items() if name.endswith(" travel"))
    for which in ("earlier", "reference"):
        (laid,) = (data for name, data in found.items() if f"{which}:" in (name or ""))
        near = np.abs(laid["x"] - np.interp(89.0, own["y"], own["x"])) < 5.0
        apart = np.interp(laid["x"][near], own["x"], own["y"]) - laid["y"][near]
        assert np.abs(apart).max() < 2.0  # mm; half a sample is 0.5 mm
    band = found[None]
    assert (band["high"] - band["low"])[0] == pytest.approx(0.1 * 178.0, rel=0.03)


def test_a_doubtful_sample_is_drawn_as_one(tmp_path):
    line(tmp_path / "spike.csv", spike=20.0)
    found = curves(Views(tmp_path, tmp_path), "file=spike.csv&tab=0")
    at = found[" travel"]["x"] == 80.0
    assert np.isnan(found[" travel"]["y"][at])
    assert found[" doubtful samples"]["y"][at] == pytest.approx(70.0, abs=1e-6)


def test_a_file_that_cannot_be_read_shows_its_columns_and_what_to_decide(ask):
    text = ask("/inspection?file=bare.csv")
    assert "data-trouble" in text
    assert states(text)["rate"] == "missing"
    assert curves(ask, "file=bare.csv")["reading reading"]["y"].max() == 100.0
    with pytest.raises(ValueError):
        ask("/values?file=bare.csv")
    query = "file=bare.csv&set.rate=20"
    text = ask(f"/inspection?{query}")
    assert "data-trouble" not in text
    assert states(text)["rate"] == "chosen"
    assert value(ask, query, "closing travel_time")[0] == pytest.approx(24.0, rel=1e-3)


@pytest.mark.parametrize("setting", ["rate=fast", "rate=-3", "time_unit=%22h%22", "ratio=0"])
def test_a_wrong_setting_is_said_and_can_be_changed(ask, setting):
    text = ask(f"/inspection?{LINE}&set.{setting}")
    assert "data-trouble" in text
    assert f"endurance.format.{setting.partition('=')[0]}" in text
    with pytest.raises(ValueError):
        ask(f"/inspection?{LINE}&set.seed=3")


# ---- files


def test_dropped_files_are_kept_apart_and_data_alone_say_what_they_lack(ask, tmp_path):
    content = (tmp_path / "a", tmp_path / "b")
    for each, spike in zip(content, (0.0, 20.0), strict=True):
        line(each, spike=spike)
    ask("/drop", b"", [("same.csv", content[0].read_bytes()), ("rec.dat", b"1,0,7\r\n2,1,8\r\n")])
    ask("/drop", b"", [("same.csv", content[1].read_bytes())])
    text = ask.listed()
    assert 'data-count="12"' in text
    assert "rec.cfg" in text
    same = re.findall(r'"/inspection\?(file=dropped\S*same\.csv)"', text)
    assert len({str(curves(ask, f"{each}&tab=0").keys()) for each in same}) == 2


@pytest.mark.parametrize("name", ["", "..", "a/b.csv", "a\0.csv"])
def test_a_drop_has_names_and_a_bound(ask, tmp_path, name):
    with pytest.raises(ValueError):
        ask("/drop", b"", [(name, b"1")])
    ask("/drop", b"", [("a.csv", b"1")])
    (place,) = tmp_path.rglob("a.csv")
    with place.open("r+b") as file:
        file.truncate(2**28)
    with pytest.raises(ValueError):
        ask("/drop", b"", [("b.csv", b"1")])
    assert not [*tmp_path.rglob("b.csv")]


@pytest.mark.parametrize("ending", ["html", "pdf"])
def test_a_sheet_is_that_of_the_command_with_the_settings_that_are_saved(
    ask, folder, tmp_path, weasyprint, ending
):
    query = "file=one.csv&before=old.csv&same=1&set.zero=rest"
    settings, output = tmp_path / "my.yaml", tmp_path / f"sheet.{ending}"
    ask(f"/save?{query}", str(settings).encode())
    assert yaml.safe_load(settings.read_text())["endurance"]["format"]["zero"] == "rest"
    before = ["--before", str(folder / "curves" / "old.csv"), "--same-transducer"]
    config = ["--config", str(folder / "few.yaml"), str(settings)]
    named = str(folder / "curves" / "one.csv")
    assert main(["report", named, *before, *config, "--output", str(output)]) == 0
    assert ask(f"/sheet/sheet.{ending}?{query}") == output.read_bytes()
    with pytest.raises(OSError):  # lines of a user are not replaced
        ask(f"/save?{query}", str(settings).encode())


def test_without_weasyprint_a_pdf_is_refused(ask, no_weasyprint):
    with pytest.raises(ValueError):
        ask(f"/sheet/sheet.pdf?{LINE}")


def test_names_and_texts_of_files_are_escaped_everywhere(ask):
    hostile = next(q for some in rows(ask.listed()).values() for q in some if "img" in q)
    ask.set("<b>T", "limits.closing stroke", "1", "2")
    pages = [ask.listed(), ask(f"/inspection?{hostile}"), ask(f"/inspection?{TODAY}")]
    pages.append(ask(f"/inspection?{LINE}&type=%3Cb%3ET"))
    pages += ask(f"/values?{TODAY}&model=1")["parts"].values()
    pages += ask(f"/values?{LINE}&type=%3Cb%3ET")["parts"].values()
    assert "Coil &lt;b&gt;" in pages[2]
    assert "&lt;b&gt;T" in pages[3]
    for each in pages:
        for raw in ("<img src=x", "<script>alert", "<b>", ODD):
            assert raw not in each
