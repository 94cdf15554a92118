"""`breaker report`, records over a good one, and what files state against how they are read."""

import json
import re
import sys

import pytest
import yaml
from matplotlib.image import imread

from breaker.cli import main
from tests.exports import write

EXPORT = {"endurance": {"draws": 50, "format": {"time_column": None, "rate": 5.0}}}
LIMITS = [
    {"name": "slow", "motion": "closing", "of": "record", "upper": {"travel_time": 30.0}},
    {"name": "short", "motion": "closing", "quantity": "stroke", "reference": 175, "tolerance": 6},
    {"name": "late", "motion": "closing", "of": "record", "upper": {"touch_time": 60.0}},
]


@pytest.fixture
def visit(tmp_path, monkeypatch):
    """A C-O of three channels with cross-talk on three more, that before, and a configuration."""
    monkeypatch.chdir(tmp_path)
    for seed, name in enumerate(("today.csv", "before.csv")):
        write(name, rate=5.0, seed=seed, motions=("closing", "opening"), unused="cross")
    (tmp_path / "my.yaml").write_text(yaml.safe_dump(EXPORT | {"limits": LIMITS}))
    return tmp_path


def report(*arguments):
    return main(["report", *arguments, "--config", "my.yaml"])


def page_of(name="a.html"):
    with open(name, encoding="utf-8") as file:
        return file.read()


def test_a_report_has_every_channel_and_verdict(visit, capsys):
    beside = ["--before", "before.csv", "--reference", "before.csv"]
    assert report("today.csv", *beside, "--output", "a.html") == 0
    assert capsys.readouterr().out.startswith("FAIL: slow")
    # A channel, the range of a limit, what stands above the samples, and points of speeds.
    limit = "<td>stroke from 169 up to 181</td>"
    for text in ("<th>B</th>", limit, "North 400 kV", "from 40 to 80 % of stroke"):
        assert text in page_of()
    assert "Travel 4" not in page_of()
    assert page_of().count("data:image/png;base64,") == 5  # travel, signals, difference
    assert "closing_speed" not in page_of()


def test_the_same_call_writes_the_same_page_and_a_pdf_is_that_page(visit, weasyprint):
    (visit / "a.pdf").write_bytes(b"%PDF-")  # a report replaces a report
    for name in ("a.html", "b.html", "a.pdf"):
        assert report("today.csv", "--output", name) == 0
    page = (visit / "a.html").read_bytes()
    assert (visit / "b.html").read_bytes() == page
    assert (visit / "a.pdf").read_bytes() == b"%PDF-" + page


def test_a_pdf_without_weasyprint_or_its_library_is_refused_with_the_extra(
    visit, no_weasyprint, monkeypatch, capsys
):
    assert report("today.csv", "--output", "a.pdf") == 1
    assert "breaker-drive[pdf]" in capsys.readouterr().err
    monkeypatch.delitem(sys.modules, "weasyprint")
    (visit / "weasyprint.py").write_text("raise OSError('no Pango')\n")
    monkeypatch.syspath_prepend(str(visit))
    assert report("today.csv", "--output", "a.pdf") == 1
    assert "breaker-drive[pdf]" in capsys.readouterr().err
    assert not (visit / "a.pdf").exists()


def test_a_value_that_the_analyser_printed_otherwise_has_a_note(visit):
    results = {"Stroke (mm)": [178.0, 182.0, 178.7], "Closing Velocity (m/s)": [4.1, 4.1, 4.4]}
    results["Over Travel (mm)"] = [1.0, 1.0, 1.0]  # which makers count in other ways
    write("today.csv", rate=5.0, results=results)
    assert report("today.csv", "--output", "a.html") == 0
    assert re.findall(r"relative to the printed ([\d.]+)\.", page_of()) == ["182", "4.4"]


@pytest.mark.parametrize("name", ["a.csv", "my.yaml", "today.csv"])
def test_a_report_replaces_nothing_else(visit, name, capsys):
    assert report("today.csv", "--output", name) == 1
    assert capsys.readouterr().err.startswith("breaker: ")


def test_a_file_that_cannot_be_used_is_named(visit, capsys):
    write("today.csv", rate=5.0, channels=1)
    (visit / "odd.csv").write_text("no numbers\n")
    assert report("today.csv", "odd.csv", "--output", "a.html") == 0
    assert "odd.csv" in page_of()
    (visit / "empty").mkdir()
    for call in (["odd.csv"], ["today.csv", "--before", "gone.csv"], ["empty"]):
        capsys.readouterr()
        assert report(*call, "--output", "b.html") == 1
        assert call[-1] in capsys.readouterr().err
        assert not (visit / "b.html").exists()


def test_the_entry_of_a_type_counts_for_its_drives(visit, capsys):
    """LTB 420 stands in the files: limits and reference are those of its entry, or of --type."""
    entry = {"limits": {"closing stroke": ["200 mm", None]}, "reference": "before.csv"}
    (visit / "types.yaml").write_text(yaml.safe_dump({"ltb-420": entry, "other": {}}))
    (visit / "with.yaml").write_text(yaml.safe_dump(EXPORT | {"types": "types.yaml"}))
    call = ["report", "today.csv", "--config", "with.yaml", "--output"]
    assert main([*call, "a.html"]) == 0
    assert "closing stroke by type" in capsys.readouterr().out
    assert main([*call, "b.html", "--type", "other"]) == 0
    assert "by type" not in capsys.readouterr().out
    with_reference, without = ((visit / e).read_bytes() for e in ("a.html", "b.html"))
    assert len(with_reference) > len(without)
    assert main([*call, "c.html", "--type", "GL 314"]) == 1
    err = capsys.readouterr().err
    assert "GL 314" in err
    assert "ltb-420, other" in err
    infer = ["infer", "today.csv", "--channel", "Travel 1", "--json", "--config", "with.yaml"]
    assert main(infer) == 0
    assert "closing stroke by type" in capsys.readouterr().out


def test_infer_lays_records_over_a_good_one(folder, capsys):
    call = ["infer", "a.csv", "--reference", "b 2.csv", "--config", "few.yaml"]
    assert main([*call, "--plot", "over.png"]) == 0
    assert imread("over.png").size
    capsys.readouterr()
    assert main([*call, "--json", "--tolerance", "0.1"]) == 0
    (found,) = json.loads(capsys.readouterr().out)["reference"]
    assert (found["motion"], found["share"]) == ("closing", pytest.approx(0.001))
    assert found["leaves"]
    for option, value, named in (
        ("--reference", "open.csv", "closing"),
        ("--reference", "none.csv", "none.csv"),
        ("--tolerance", "3", "--reference"),
    ):
        assert main(["infer", "a.csv", option, value]) == 1
        assert named in capsys.readouterr().err


# ---- what files state against how they are read -------------------------------------------------


def settings(name, **more):
    """A configuration of exports without limits."""
    form = {"time_column": None, "travel_column": "Travel 1", "rate": None} | more
    with open(name, "w", encoding="utf-8") as file:
        yaml.safe_dump({"endurance": {"draws": 50, "format": form}}, file)
    return ["--config", name]


def test_a_rate_that_the_file_contradicts_is_refused_and_a_stated_one_taken(visit, capsys):
    assert main(["infer", "today.csv", "--json", *settings("none.yaml")]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["warnings"] == []
    assert any("rate" in remark["text"] for remark in found["records"][0]["remarks"])
    wrong = settings("wrong.yaml", rate=10.0)
    for command in (["infer", "today.csv"], ["report", "today.csv", "--output", "a.html"]):
        assert main([*command, *wrong]) == 1
        out, err = capsys.readouterr()
        assert "5 kHz" in out + err
        assert "10 kHz" in out + err
    (visit / "own").mkdir()
    (visit / "today.csv").rename(visit / "own/today.csv")
    table = "file,motion,operation,rate\ntoday.csv,closing,1,5.5\n"
    (visit / "own/operations.csv").write_text(table)
    assert main(["infer", "own", *settings("none.yaml")]) == 0
    out = " ".join(capsys.readouterr().out.split())
    assert out.startswith("WARNING: own/today.csv states 5 kHz")


def test_another_breaker_is_refused_in_a_report_and_warned_of_between_visits(visit, capsys):
    write("today.csv", rate=5.0, channels=1)
    write("other.csv", rate=5.0, channels=1, seed=7, serial="X", bay="Bay 9")
    assert report("today.csv", "other.csv", "--output", "a.html") == 1
    assert "HV-20417" in capsys.readouterr().err
    one = settings("one.yaml")
    assert main(["report", "today.csv", "--before", "other.csv", "--output", "a.html", *one]) == 0
    assert re.search("WARNING: [^<]*HV-20417[^<]*Bay 9", page_of())


def test_a_time_at_the_estimated_contact_gets_no_verdict(visit, capsys):
    limits = [{"quantity": "closing_time", "reference": 60, "tolerance": 10}]
    limits.append({"quantity": "bounce_time", "reference": 1, "tolerance": 1})
    (visit / "limits.yaml").write_text(yaml.safe_dump({"limits": limits}))
    call = ["infer", "today.csv", "--json", "--motion", "closing", "--config"]
    none = {"contact_column": "Aux 1"}  # in which no contact is seen
    one = settings("one.yaml", trigger_column="Coil 1 (A)", **none)[1]
    assert main([*call, one, "limits.yaml"]) == 0
    (found,) = json.loads(capsys.readouterr().out)["records"]
    assert found["quantities"]["closing_time"].get("source") in ("mixed", None)
    assert found["quantities"]["reaction_time"]["source"] == "measured"
    limit, _ = found["limits"]
    assert (limit["verdict"], limit["reason"]["code"]) == ("inconclusive", "no-contact-channel")
    assert main([*call, settings("both.yaml")[1], "limits.yaml"]) == 0  # columns of the travel
    (found,) = json.loads(capsys.readouterr().out)["records"]
    assert found["quantities"]["closing_time"]["source"] == "measured"
    assert [each["verdict"] for each in found["limits"]] == ["pass", "pass"]  # 0 is no less than 0
