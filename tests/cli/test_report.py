"""`breaker report`, and records over a good one."""

import json
import re

import pytest
import yaml
from matplotlib.image import imread

from breaker.cli import main
from tests.exports import write

EXPORT = {"endurance": {"draws": 50, "format": {"time_column": None, "rate": 5.0}}}
LIMITS = [
    {"name": "slow", "motion": "closing", "of": "record", "upper": {"travel_time": 30.0}},
    {"name": "short", "motion": "closing", "quantity": "stroke", "reference": 175, "tolerance": 5},
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
    for text in (
        "<th>B</th>",
        "170 to 180",
        "differ by",
        "North 400 kV",  # of the text above the samples
        "from 40 % of stroke to 80 % of stroke",
        "touch at",  # by the contact of each channel, which no drive of the family has there
        "so none is shown",
        "since the visit before",
        "What the model adds",
    ):
        assert text in page
    assert re.search("170 to 180</td>.{,30}pass", page)
    assert "Travel 4" not in page
    assert page.count("data:image/png;base64,") == 1


def test_the_same_call_writes_the_same_pages(visit):
    for name in ("a.pdf", "b.pdf"):
        assert report("today.csv", "--output", name) == 0
    first = (visit / "a.pdf").read_bytes()
    assert first == (visit / "b.pdf").read_bytes()
    assert first.count(b"/Type /Page\n") + first.count(b"/Type /Page ") == 2
    assert report("today.csv", "--output", "a.pdf") == 0  # a report replaces a report


@pytest.mark.parametrize("name", ["a.csv", "my.yaml", "today.csv"])
def test_a_report_replaces_nothing_else(visit, name, capsys):
    assert report("today.csv", "--output", name) == 1
    assert capsys.readouterr().err.startswith("breaker: ")


def test_a_file_that_cannot_be_read_is_named_with_its_reason(visit, capsys):
    (visit / "odd.csv").write_text("no numbers\n")
    assert report("today.csv", "odd.csv", "--output", "a.html") == 0
    assert "odd.csv" in (visit / "a.html").read_text(encoding="utf-8")
    assert report("odd.csv", "--output", "b.html") == 1
    assert "odd.csv" in capsys.readouterr().err


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
