"""The judge of damaged files: what it calls right, masked, flagged, silent, and a defect."""

import contextlib
import time

import numpy as np
import pytest
import xarray as xr

from breaker.records import reader, record
from studies.faults import judge as judging
from studies.faults.__main__ import defects, run, tabulate
from studies.faults.judge import KINDS, good_file, is_right, judge, try_kind

SEED = 5
EACH = 4  # files of each kind


@pytest.fixture(scope="module", params=["closing", "opening"])
def good(request):
    return good_file("comma", request.param, 0, SEED)


def test_what_is_near_enough_is_right(good):
    assert is_right(good, good.record)
    assert is_right(good, good.record + 0.29)
    assert is_right(good, np.where(np.arange(151) % 3, good.record, np.nan))
    grid = good.first + np.linspace(-2.0, 58.0, 151)
    assert is_right(good, np.interp(grid + 0.2, good.time, good.travel))  # 0.2 ms late


@pytest.mark.parametrize("by", [0.6, -0.6])
def test_what_is_far_off_is_wrong(good, by):
    assert not is_right(good, good.record + by)
    assert not is_right(good, good.record + by * (np.arange(151) == 0))
    grid = good.first + np.linspace(-2.0, 58.0, 151)
    assert not is_right(good, np.interp(grid + by, good.time, good.travel))  # ms


def test_outcomes(good, monkeypatch, tmp_path):
    def outcome(*, shift=0.0, **values):
        result = {"accepted": True, "reason": "", "remarks": "", "masked": 0, **values}
        curves = xr.Dataset(
            {"travel": (("operation", "time"), good.record[None] + shift)}
            | {name: ("operation", [value]) for name, value in result.items()}
        )
        monkeypatch.setattr(judging, "read_curves", lambda *args, **kwargs: curves)
        return judge(tmp_path / "a.csv", good)[0]

    assert outcome() == "right"
    assert outcome(remarks="noise") == "right"
    assert outcome(masked=3) == "masked"
    assert outcome(shift=1.0, remarks="noise") == "flagged"
    assert outcome(shift=1.0) == "silent"
    assert outcome(shift=1.0, masked=3) == "silent"
    assert outcome(accepted=False, reason="too short") == "rejected"
    assert outcome(accepted=False) == "exception"  # a rejection without a reason


def test_another_error_and_a_hang_are_defects(good, monkeypatch, tmp_path):
    def fails(*_, **__):
        raise KeyError("travel")

    def hangs(*_, **__):
        while True:
            with contextlib.suppress(Exception):  # what a reader must not do
                time.sleep(0.01)

    monkeypatch.setattr(judging, "SECONDS", 0.02)
    for read, text in ((fails, "KeyError: 'travel'"), (hangs, "")):
        monkeypatch.setattr(judging, "read_curves", read)
        outcome, words, _ = judge(tmp_path / "a.csv", good)
        assert outcome == "exception"
        assert text in words


@pytest.fixture(scope="module")
def few_good_files():
    """To read fewer before they are damaged."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(judging, "_GOOD", 1)
        yield


@pytest.fixture(scope="module")
def trials(few_good_files):
    return run(EACH * len(KINDS), SEED)


def test_the_reader_notices_damage(trials):
    table = tabulate(trials)
    assert table.loc["all", "exception"] == 0
    assert table.loc["all", "slowest"] < 2.0
    # Of some 120 accepted files, 0.3 % silent ones would be more than three once in 1,700 seeds.
    assert table.drop(["all", "excursion"]).silent.sum() <= 3  # excursions look like motions
    whole = [trial for trial in trials if trial.kind == "nothing"]
    assert [(trial.outcome, trial.words) for trial in whole] == EACH * [("right", "")]
    first = next(trial for trial in trials if trial.kind == KINDS[1] and trial.number == 0)
    assert try_kind(KINDS[1], 0, SEED)[:-1] == first[:-1]  # a seed repeats its trials


@pytest.mark.parametrize(
    ("module", "stage", "without", "kind"),
    [
        (reader, "check_stroke", None, "gain"),
        (record, "noise_remarks", [], "noisy"),
    ],
    ids=["gain", "noisy"],
)
def test_a_reader_without_a_stage_is_caught(
    module, stage, without, kind, few_good_files, monkeypatch
):
    def silent():
        return sum(try_kind(kind, number, SEED).outcome == "silent" for number in range(30))

    before = silent()
    monkeypatch.setattr(module, stage, lambda *_: without)
    assert silent() >= before + 3


def test_what_is_wrong_with_a_table():
    trial = try_kind("nothing", 0, SEED)._replace(kind="gap", seconds=0.1)
    assert defects(tabulate([*999 * [trial], trial._replace(outcome="silent")])) == []
    for wrong in (
        [trial._replace(outcome="silent")] * 2,
        [trial._replace(outcome="exception")],
        [trial._replace(seconds=2.1)],
    ):
        assert len(defects(tabulate([*999 * [trial], *wrong]))) == 1
