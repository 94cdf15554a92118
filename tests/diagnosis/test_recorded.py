"""Which records of which breakers are read from folders."""

import shutil

import pytest

from breaker.common.randomness import generator
from breaker.configuration.definitions import family_of
from breaker.diagnosis import type_records as recorded
from breaker.diagnosis.session import Diagnosis
from breaker.diagnosis.type_records import list_breakers, read_breakers
from breaker.shipped import HELD_BACK
from tests.diagnosis.drives import breakers_of, type_of, write_breakers

MOTIONS = ("closing", "opening")


@pytest.fixture(scope="module")
def drives(prior, defaults):
    rng = generator(6, "test recorded")
    return breakers_of(type_of(prior, rng), family_of(HELD_BACK), 2, rng)


@pytest.fixture
def read(levels, defaults):
    assessment = Diagnosis(defaults, families=lambda: [levels])
    return lambda *folders, **of: read_breakers(list_breakers(folders, MOTIONS, **of), assessment)


@pytest.fixture
def folder(tmp_path, drives):
    return write_breakers(tmp_path / "type", drives, 2, generator(1, "test files"))


def names_and_counts(found):
    return {
        name: {motion: len(each) for motion, each in by_motion.items()}
        for name, by_motion in found.records.items()
    }


def test_breakers_of_a_table(folder, read):
    found = read(folder)
    both = {"closing": 2, "opening": 2}
    assert names_and_counts(found) == {"Q0": both, "Q1": both}
    assert found.rejected == []
    assert found.left_out == 0
    assert found.noise_sd == pytest.approx(0.1, rel=0.15)
    # Motions of each operation, together.
    assert [each.motions for each in found.answers["Q0"]] == [MOTIONS] * 4
    assert found.size.lengths == pytest.approx(1.0, abs=0.3)


@pytest.mark.parametrize(("other", "types"), [("gl-314", 1), ("GL318", 2)])
def test_a_type_in_two_spellings_is_one(folder, read, other, types):
    table = folder / "operations.csv"
    head, *rows = table.read_text(encoding="utf-8").splitlines()
    of = [f"{row},{'GL 314' if k else other}" for k, row in enumerate(rows)]
    table.write_text("\n".join([f"{head},type", *of]), encoding="utf-8")
    found = read(folder)
    assert sorted(found.types)[0] == "GL 314"
    assert len(found.types) == types


def test_one_type_of_a_table_is_chosen_in_any_spelling(folder):
    table = folder / "operations.csv"
    head, *rows = table.read_text(encoding="utf-8").splitlines()
    of = [f"{row},{'GL 314' if 'Q1' in row else 'GL318'}" for row in rows]
    table.write_text("\n".join([f"{head},type", *of]), encoding="utf-8")
    every, own = (list_breakers([folder], MOTIONS, name) for name in ("", "gl-314"))
    assert {name for listed in every.values() for name in listed} == {"Q0", "Q1"}
    assert own == {motion: {"Q1": every[motion]["Q1"]} for motion in MOTIONS}
    with pytest.raises(ValueError, match=r"no operation is of type GL31: .* GL 314, GL318"):
        list_breakers([folder], MOTIONS, "GL31")


def test_phases_are_records_of_their_breaker(folder, read):
    table = folder / "operations.csv"
    head, *rows = table.read_text(encoding="utf-8").splitlines()
    cells = [row.split(",") for row in rows]
    phases = [f"{c[0]},{c[1]},1,{c[3]},L{1 + k % 2}" for k, c in enumerate(cells)]
    table.write_text("\n".join([f"{head},phase", *phases]), encoding="utf-8")
    found = read(folder)
    assert names_and_counts(found)["Q0"] == {"closing": 2, "opening": 2}
    assert [each.motions for each in found.answers["Q0"]] == [MOTIONS] * 4


def test_a_motion_that_is_nowhere_is_left_out(tmp_path, drives, read):
    rng = generator(1, "test files")
    folder = write_breakers(tmp_path / "closings", drives, 1, rng, motions=["closing"])
    assert read(folder).motions == ["closing"]


def test_no_more_records_than_are_needed(folder, read, monkeypatch):
    monkeypatch.setattr(recorded, "_MOST", 1)
    found = read(folder)
    assert names_and_counts(found)["Q0"] == {"closing": 1, "opening": 1}
    assert found.left_out == 4
    monkeypatch.setattr(recorded, "_MOST", 3)
    assert recorded._spread(9).tolist() == [0, 4, 8]


def test_rejected_records_have_their_reason(folder, read):
    (folder / "closing_0_1.csv").write_text("time,travel\n0,1\n", encoding="utf-8")
    found = read(folder)
    assert names_and_counts(found)["Q0"] == {"closing": 1, "opening": 2}
    assert len(found.rejected) == 1
    assert "closing_0_1.csv" in found.rejected[0]


def test_nothing_to_read(tmp_path, folder, read):
    with pytest.raises(FileNotFoundError, match=r"has no file of a record.*breaker inspect"):
        read(tmp_path)
    with pytest.raises(FileNotFoundError, match=r"there is no folder .*nowhere"):
        read(folder, tmp_path / "nowhere")  # one of several is not left out in silence
    for file in folder.glob("*_*.csv"):
        file.write_text("time,travel\n0,1\n", encoding="utf-8")
    with pytest.raises(ValueError, match="none of 8 records can be used"):
        read(folder)


def test_a_copy_in_any_folder_or_breaker_counts_once(tmp_path, folder, drives, read):
    """A record of Q0 that was saved again as one of Q1, and a folder that is there twice."""
    copied = folder / "closing_1_1.csv"
    copied.write_bytes((folder / "closing_0_1.csv").read_bytes() + b"\n")
    again = shutil.copytree(folder, tmp_path / "again")
    found = read(folder, again)
    assert names_and_counts(found) == {
        "Q0": {"closing": 2, "opening": 2},
        "Q1": {"closing": 1, "opening": 2},
    }
    assert len(found.rejected) == 1 + 8
