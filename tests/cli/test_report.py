"""`breaker report`, and records over a good one."""

import json
import re
import shutil
import sys
from pathlib import Path

import pytest
import yaml
from matplotlib.image import imread

from breaker.cli import main
from breaker.configuration.loading import defaults
from breaker.records.proposal import inspect_file
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


def test_a_report_has_every_channel_and_verdict(visit, capsys):
    beside = ["--before", "before.csv", "--reference", "before.csv"]
    assert report("today.csv", *beside, "--output", "a.html") == 0
    out = capsys.readouterr().out
    assert out.startswith("FAIL: slow\n")
    page = (visit / "a.html").read_text(encoding="utf-8")
    # A channel, the reference of a limit, what stands above the samples, and points of speeds.
    for text in ("<th>B</th>", "<td>175</td>", "North 400 kV", "from 40 to 80 % of stroke"):
        assert text in page
    assert re.search("± 6</td>.{,30}pass", page)
    assert "Travel 4" not in page
    assert page.count("data:image/png;base64,") == 2


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
    (visit / "weasyprint.py").write_text("raise OSError('no Pango')\n")
    monkeypatch.syspath_prepend(visit)
    monkeypatch.delitem(sys.modules, "weasyprint")
    assert report("today.csv", "--output", "a.pdf") == 1
    assert "breaker-drive[pdf]" in capsys.readouterr().err
    assert not (visit / "a.pdf").exists()


def test_what_the_analyser_printed_otherwise_is_marked_as_inspect_marks_it(visit):
    results = {"Stroke (mm)": [178.0, 182.0, 178.7], "Closing Velocity (m/s)": [4.1, 4.1, 4.4]}
    results["Over Travel (mm)"] = [1.0, 1.0, 1.0]  # which makers count in other ways
    write("today.csv", rate=5.0, results=results)
    compared = inspect_file("today.csv", defaults()["sensor"]).compared
    assert report("today.csv", "--output", "a.html") == 0
    page = (visit / "a.html").read_text(encoding="utf-8")
    printed = [f"{each.printed.value:g}" for each in compared if each.differs]
    assert printed == ["182", "4.4"]
    assert re.findall(r'<td class="bad">([^<]*) differs</td>', page) == printed
    (said,) = re.findall("stroke: measured [^<]*", page)
    assert re.match(r"stroke: measured 178\.\d mm, 2 % less than printed: .* one \(Y\)$", said)
    write("today.csv", rate=5.0, channels=1, results={"Stroke (mm)": [178.4]})
    assert report("today.csv", "--output", "a.html") == 0
    assert " differs<" not in (visit / "a.html").read_text(encoding="utf-8")


@pytest.mark.parametrize("name", ["a.csv", "my.yaml", "today.csv"])
def test_a_report_replaces_nothing_else(visit, name, capsys):
    assert report("today.csv", "--output", name) == 1
    assert capsys.readouterr().err.startswith("breaker: ")


def test_a_file_that_cannot_be_read_is_named_with_its_reason(visit, capsys):
    write("today.csv", rate=5.0, channels=1)
    (visit / "odd.csv").write_text("no numbers\n")
    assert report("today.csv", "odd.csv", "--output", "a.html") == 0
    assert "odd.csv" in (visit / "a.html").read_text(encoding="utf-8")
    assert report("odd.csv", "--output", "b.html") == 1
    assert "odd.csv" in capsys.readouterr().err


def test_the_entry_of_a_type_counts_for_its_drives(visit, capsys):
    """LTB 420 stands in the files: limits and reference are those of its entry, or of --type."""
    entry = {"limits": {"closing stroke": ["200 mm", None]}, "reference": "before.csv"}
    Path("types.yaml").write_text(yaml.safe_dump({"ltb-420": entry, "other": {}}))
    Path("with.yaml").write_text(yaml.safe_dump(EXPORT | {"types": "types.yaml"}))
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
    found = json.loads(capsys.readouterr().out)["records"]
    assert {e["name"] for r in found for e in r["limits"]} == {"closing stroke by type low"}


# ---- infer --reference --------------------------------------------------------------------------


def test_infer_lays_records_over_a_good_one(folder, capsys):
    call = ["infer", "a.csv", "--reference", "b 2.csv", "--config", "few.yaml"]
    assert main([*call, "--plot", "over.png"]) == 0
    assert "stays within ±" in capsys.readouterr().out
    assert imread("over.png").size
    assert main([*call, "--json", "--tolerance", "0.1"]) == 0
    (found,) = json.loads(capsys.readouterr().out)["reference"]
    assert found["motion"] == "closing"
    assert found["share"] == pytest.approx(0.001)
    assert found["leaves"]


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--reference", "open.csv"], "no usable closing"),
        (["--reference", "none.csv"], "none.csv"),
        (["--tolerance", "3"], "--reference"),
        (["--reference", "b 2.csv", "--plot", "b 2.csv"], "b 2.csv"),
    ],
)
def test_a_reference_that_helps_nobody_is_refused(folder, capsys, arguments, said):
    assert main(["infer", "a.csv", *arguments]) == 1
    assert said in capsys.readouterr().err


# ---- what files state against how they are read -------------------------------------------------


def settings(name, **more):
    """A configuration of exports without limits."""
    form = {"time_column": None, "travel_column": "Travel 1", "rate": None} | more
    with open(name, "w", encoding="utf-8") as file:
        yaml.safe_dump({"endurance": {"draws": 50, "format": form}}, file)
    return ["--config", name]


def test_a_rate_that_the_file_contradicts_is_refused_and_a_stated_one_taken(visit, capsys):
    right = ["infer", "today.csv", "--json", *settings("none.yaml")]
    assert main(right) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["warnings"] == []
    assert any("rate" in remark for remark in found["records"][0]["remarks"])
    wrong = settings("wrong.yaml", rate=10.0)
    for command in (["infer", "today.csv"], ["report", "today.csv", "--output", "a.html"]):
        assert main([*command, *wrong]) == 1
        out, err = capsys.readouterr()
        assert "5 kHz" in out + err
        assert "10 kHz" in out + err
    assert main(["compare", "before.csv", "--today", "today.csv", *wrong]) == 1
    assert "5 kHz" in capsys.readouterr().err


def test_a_table_that_names_the_file_wins_with_a_warning_on_top(visit, capsys):
    (visit / "own").mkdir()
    (visit / "today.csv").rename(visit / "own/today.csv")
    table = "file,motion,operation,rate\ntoday.csv,closing,1,5.5\n"
    (visit / "own/operations.csv").write_text(table)
    assert main(["infer", "own", *settings("none.yaml")]) == 0
    out = " ".join(capsys.readouterr().out.split())
    assert out.startswith("WARNING: own/today.csv states 5 kHz, and is read at 5.5 kHz")


def test_a_length_that_the_settings_contradict_is_warned_of(visit, capsys):
    text = (visit / "today.csv").read_text().replace("Sampling Speed (kC)", "User Field")
    (visit / "today.csv").write_text(text)
    assert main(["infer", "today.csv", *settings("ten.yaml", rate=10.0)]) == 0
    out = " ".join(capsys.readouterr().out.split())
    assert out.startswith("WARNING: today.csv")
    assert "400 ms" in out.partition("closing")[0]


def test_another_breaker_is_refused_in_a_report_and_warned_of_between_visits(visit, capsys):
    write("today.csv", rate=5.0, channels=1)
    write("other.csv", rate=5.0, channels=1, seed=7, serial="X", bay="Bay 9")
    assert report("today.csv", "other.csv", "--output", "a.html") == 1
    assert "HV-20417 and X" in capsys.readouterr().err
    one = settings("one.yaml")
    call = ["report", "today.csv", "--before", "other.csv", "--output", "a.html", *one]
    assert main(call) == 0
    page = (visit / "a.html").read_text(encoding="utf-8")
    assert "WARNING: the serial number was X and is HV-20417; the bay was Bay 9" in page
    capsys.readouterr()
    assert main(["compare", "other.csv", "--today", "today.csv", *one]) == 0
    assert "WARNING: the serial number was X and is HV-20417" in capsys.readouterr().out


def test_a_record_that_is_that_of_before_is_told(visit, capsys):
    (visit / "copy.csv").write_bytes((visit / "today.csv").read_bytes())
    call = ["compare", "copy.csv", "--today", "today.csv", *settings("one.yaml")]
    assert main(call) == 0
    out = " ".join(capsys.readouterr().out.split())
    assert out.startswith("WARNING: copy.csv and today.csv hold the same samples")


def test_a_time_of_the_models_contact_has_a_star_and_no_verdict(visit, capsys):
    limits = [{"quantity": "closing_time", "reference": 60, "tolerance": 10}]
    limits.append({"quantity": "bounce_time", "reference": 1, "tolerance": 1})
    (visit / "limits.yaml").write_text(yaml.safe_dump({"limits": limits}))
    call = ["infer", "today.csv", "--json", "--motion", "closing", "--config"]
    none = {"contact_column": "Aux 1"}  # in which no contact is seen
    one = settings("one.yaml", trigger_column="Coil 1 (A)", **none)[1]
    assert main([*call, one, "limits.yaml"]) == 0
    (found,) = json.loads(capsys.readouterr().out)["records"]
    assert found["quantities"]["closing_time"]["source"] in ("measured, touch inferred", None)
    assert found["quantities"]["reaction_time"]["source"] == "measured"
    limit, _ = found["limits"]
    assert limit["verdict"] == "inconclusive"
    assert limit["reason"]["code"] == "no-contact-channel"
    both = settings("both.yaml")[1]  # as their columns go with the travel
    assert main([*call, both, "limits.yaml"]) == 0
    (found,) = json.loads(capsys.readouterr().out)["records"]
    assert found["quantities"]["closing_time"]["source"] == "measured"
    assert [each["verdict"] for each in found["limits"]] == ["pass", "pass"]  # 0 is no less than 0


def test_folders_of_motions_are_reported_and_a_visit_that_cannot_be_used_is_refused(visit, capsys):
    for motion in ("closing", "opening"):
        (visit / "parts" / motion).mkdir(parents=True)
        shutil.copy(visit / "today.csv", visit / "parts" / motion / f"{motion}_00001.csv")
    (visit / "empty").mkdir()
    form = EXPORT["endurance"]["format"] | {"travel_column": "Travel 1 (mm)"}
    (visit / "my.yaml").write_text(yaml.safe_dump({"endurance": {"draws": 50, "format": form}}))
    assert report("parts", "--output", "a.html") == 0
    for folder, words in (
        ("empty", "no file of a record"),
        ("gone.csv", "visit before can be used"),
    ):
        capsys.readouterr()
        assert report("today.csv", "--before", folder, "--output", "b.html") == 1
        assert words in capsys.readouterr().err
        assert not (visit / "b.html").exists()
