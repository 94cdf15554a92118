"""`breaker report`, records over a good one, and what files state against how they are read."""

import json
import re

import pytest
import yaml

from breaker.cli import main
from tests.exports import pole, write

FORM = {"time_column": None, "rate": 5.0}
LIMITS = [
    {"name": "slow", "motion": "closing", "of": "record", "upper": {"travel_time": 30.0}},
    {"name": "short", "motion": "closing", "quantity": "stroke", "reference": 175, "tolerance": 6},
    {"name": "late", "motion": "closing", "of": "record", "upper": {"touch_time": 60.0}},
]


def settings(name, form=(), **sections):
    """Write a configuration of exports."""
    endurance = {"draws": 50, "format": FORM | dict(form)}
    with open(name, "w", encoding="utf-8") as file:
        yaml.safe_dump({"endurance": endurance, **sections}, file)
    return ["--config", name]


@pytest.fixture(scope="module")
def exports(tmp_path_factory):
    """A C-O of three channels with cross-talk on three more, and an earlier one."""
    folder = tmp_path_factory.mktemp("exports")
    for seed, name in enumerate(("today.csv", "before.csv")):
        motions = ("closing", "opening")
        write(folder / name, rate=5.0, seed=seed, motions=motions, unused="cross")
    return folder


@pytest.fixture
def inspection(exports, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for file in exports.iterdir():
        (tmp_path / file.name).write_bytes(file.read_bytes())
    settings("my.yaml", limits=LIMITS)
    return tmp_path


def report(*arguments, config="my.yaml"):
    return main(["report", *arguments, "--config", config])


def page_of(name="a.html"):
    with open(name, encoding="utf-8") as file:
        return file.read()


def test_a_report_has_every_channel_and_verdict(inspection, capsys):
    earlier = ["--before", "before.csv", "--reference", "before.csv"]
    assert report("today.csv", *earlier, "--output", "a.html") == 0
    assert "\nFAIL: slow" in f"\n{capsys.readouterr().out}"
    page = page_of()
    # A channel, the range of a limit, and what stands above the samples.
    limit = "<td>stroke from 169 up to 181</td>"
    for text in ("<th>B</th>", limit, "North 400 kV"):
        assert text in page
    assert "Travel 4" not in page
    assert page.count("data:image/png;base64,") == 5  # travel, signals, difference
    assert "closing_speed" not in page


def test_files_that_cannot_be_used_or_are_of_another_breaker_are_named(inspection, capsys):
    write("today.csv", rate=5.0, channels=1)
    write("other.csv", rate=5.0, channels=1, seed=7, serial="X", bay="Bay 9")
    (inspection / "odd.csv").write_text("no numbers\n")
    (inspection / "empty").mkdir()
    for call, named in (
        (["odd.csv"], "odd.csv"),
        (["today.csv", "--before", "gone.csv"], "gone.csv"),
        (["empty"], "empty"),
        (["today.csv", "other.csv"], "HV-20417"),
    ):
        assert report(*call, "--output", "b.html") == 1
        assert named in capsys.readouterr().err
        assert not (inspection / "b.html").exists()
    one = settings("one.yaml", {"travel_column": "Travel 1"})[1]
    call = ["today.csv", "odd.csv", "--before", "other.csv", "--output", "a.html"]
    assert report(*call, config=one) == 0
    assert "odd.csv" in page_of()
    assert re.search("WARNING: [^<]*HV-20417[^<]*Bay 9", page_of())


def test_the_entry_of_a_type_counts_for_its_drives(inspection, capsys):
    """LTB 420 stands in the files: limits and reference are those of its entry, or of --type."""
    entry = {"limits": {"closing stroke": ["200 mm", None]}, "reference": "before.csv"}
    (inspection / "types.yaml").write_text(yaml.safe_dump({"ltb-420": entry, "other": {}}))
    config = settings("with.yaml", {"travel_column": "Travel 1"}, types="types.yaml")[1]
    assert report("today.csv", "--output", "a.html", config=config) == 0
    assert "FAIL: " in capsys.readouterr().out
    other = ["--type", "other"]
    assert report("today.csv", "--output", "b.html", *other, config=config) == 0
    assert "FAIL: " not in capsys.readouterr().out
    assert len(page_of("a.html")) > len(page_of("b.html"))  # with the reference
    assert report("today.csv", "--output", "c.html", "--type", "GL 314", config=config) == 1
    err = capsys.readouterr().err
    assert "GL 314" in err
    assert "ltb-420, other" in err


def test_a_reference_that_cannot_be_used_is_refused(folder, capsys):
    for option, value, named in (
        ("--reference", "open.csv", "closing"),
        ("--reference", "none.csv", "none.csv"),
    ):
        call = ["report", "a.csv", "--output", "r.html", "--config", "few.yaml", option, value]
        assert main(call) == 1
        assert named in capsys.readouterr().err


# ---- what files state against how they are read -------------------------------------------------


def test_a_rate_that_the_file_contradicts_is_refused_and_a_stated_one_taken(inspection, capsys):
    one = {"travel_column": "Travel 1"}
    assert main(["infer", "today.csv", "--json", *settings("none.yaml", one | {"rate": None})]) == 0
    result = json.loads(capsys.readouterr().out)
    assert [warning["code"] for warning in result["warnings"]] == ["phase-taken"]
    assert any("rate" in remark["text"] for remark in result["records"][0]["remarks"])
    wrong = settings("wrong.yaml", one | {"rate": 10.0})
    for command in (["infer", "today.csv"], ["report", "today.csv", "--output", "a.html"]):
        assert main([*command, *wrong]) == 1
        message = "".join(capsys.readouterr())
        assert "5 kHz" in message
        assert "10 kHz" in message
    (inspection / "own").mkdir()
    (inspection / "today.csv").rename(inspection / "own/today.csv")
    table = "file,motion,operation,rate\ntoday.csv,closing,1,5.5\n"
    (inspection / "own/operations.csv").write_text(table)
    assert main(["infer", "own", "--config", "none.yaml"]) == 0
    out = " ".join(capsys.readouterr().out.split())
    assert "WARNING: own/today.csv states 5 kHz" in out


def test_a_time_at_the_estimated_contact_gets_no_verdict(inspection, capsys):
    limits = [{"quantity": "closing_time", "reference": 60, "tolerance": 10}]
    limits.append({"quantity": "bounce_time", "reference": 1, "tolerance": 1})
    call = ["infer", "today.csv", "--json", "--motion", "closing"]
    one = {"travel_column": "Travel 1", "rate": None}
    unseen = one | {"contact_column": "Aux 1", "trigger_column": "Coil 1 (A)"}
    records = []
    for form in (unseen, one):  # no contact is seen, and columns of the travel
        assert main([*call, *settings("one.yaml", form, limits=limits)]) == 0
        records += json.loads(capsys.readouterr().out)["records"]
    estimated, measured = records
    assert estimated["quantities"]["closing_time"].get("source") in ("mixed", None)
    assert estimated["quantities"]["reaction_time"]["source"] == "measured"
    limit, _ = estimated["limits"]
    assert (limit["verdict"], limit["reason"]["code"]) == ("inconclusive", "no-contact-channel")
    assert measured["quantities"]["closing_time"]["source"] == "measured"
    assert [item["verdict"] for item in measured["limits"]] == ["pass", "pass"]  # 0 <= 0


# ---- poles in files of their own ----------------------------------------------------------------


@pytest.mark.parametrize(("most", "verdict"), [(0.01, "inconclusive"), (5.0, "pass")])
def test_poles_in_files_of_their_own_stand_side_by_side(inspection, most, verdict):
    """A limit of simultaneity below what contacts are known to is inconclusive."""
    for k, phase in enumerate("RYB"):
        pole(f"{k}.csv", phase, k, clock=f"10:42:1{k}", trip=30.0 + 4 * k)
    columns = ("travel_column", "contact_column", "trigger_column")
    form = dict(zip(columns, ("Travel 1", "Contact 1", "Coil 1 (A)"), strict=True))
    config = settings("poles.yaml", form, report={"simultaneity": {"closing": most}})[1]
    assert report("0.csv", "1.csv", "2.csv", "--output", "a.html", config=config) == 0
    page = page_of()
    assert page.count("<th>± 95 %, widest</th>") == 1
    assert "<th>R</th><th>Y</th><th>B</th>" in page
    assert f"{verdict}: " in page
    # Each file has the coil later by 4 ms: that is no difference of poles.
    touch = re.search(r"simultaneity of the touch: ([\d.]+) ± [\d.]+ ms, \w first", page)
    assert float(touch[1]) < 0.5
    assert "2021-03-14 10:42:10, 2021-03-14 10:42:11" in page
