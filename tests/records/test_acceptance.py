"""A folder is checked before any training."""

import pytest

from breaker.common.document import text_of
from breaker.configuration.definitions import simulated_test
from breaker.configuration.loading import defaults
from breaker.family.curve_file import write_curve
from breaker.family.endurance import EnduranceTest
from breaker.records.acceptance import check_folder, document_of

ENDURANCE = {"format": {}, "breaker": None, "phase": None, "events": {}}


@pytest.fixture(scope="module")
def life():
    return EnduranceTest.from_settings(simulated_test(defaults()), seed=1)


@pytest.fixture
def folder(tmp_path, life):
    """Twelve closings and an opening."""
    for motion, count in (("closing", 12), ("opening", 1)):
        (tmp_path / motion).mkdir()
        for number in range(1, count + 1):
            file = tmp_path / motion / f"{motion}_{number:03d}.csv"
            write_curve(file, *life.record(motion, number), motion=motion, operation=number)
    return tmp_path


def check(folder, motions=("closing", "opening"), **endurance):
    return check_folder(folder, {**ENDURANCE, **endurance}, defaults()["sensor"], motions)


def listed_in(folder, head, *rows):
    (folder / "operations.csv").write_text("\n".join([head, *rows]), encoding="utf-8")


def test_a_folder_is_a_table_and_what_cannot_be_listed_is_stated(folder):
    checked = check(folder)
    assert [(item.motion, item.accepted) for item in checked] == [("closing", 12), ("opening", 1)]
    line = text_of(document_of(checked)).splitlines()[1].split()
    assert line[:5] == ["closing", "12", "12", "0", "0"]
    assert 14 < float(line[5]) <= float(line[7]) < 15
    (folder / "opening" / "opening_001.csv").rename(folder / "opening" / "opening.csv")
    assert [bool(item.error) for item in check(folder)] == [False, True]


def test_an_event_that_the_workflow_refuses_is_refused(folder):
    row = "closing/closing_001.csv,closing,1,danced"
    listed_in(folder, "file,motion,operation,event", row)
    assert [item.accepted for item in check(folder)] == [0, 0]
    (closing,) = check(folder, ["closing"], events={"danced": ["f"]})
    assert (closing.accepted, closing.error) == (1, "")


def test_breakers_and_phases_of_a_table_are_apart(folder):
    rows = [f"closing/closing_{n:03d}.csv,closing,{n},CB{1 + n % 2},L1" for n in range(1, 13)]
    rows.append("opening/opening_001.csv,opening,1,CB1,L1")
    listed_in(folder, "file,motion,operation,breaker,phase", *rows)
    result = {item.name: item.accepted for item in check(folder)}
    expected = {"CB1 L1 closing": 6, "CB2 L1 closing": 6, "CB1 L1 opening": 1, "CB2 L1 opening": 0}
    assert result == expected
    assert {e.name.split()[0] for e in check(folder, breaker="CB2")} == {"CB2"}
