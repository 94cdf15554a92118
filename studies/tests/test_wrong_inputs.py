"""Wrong inputs differ from their right twins, and a fault of the commands is caught."""

import numpy as np
import pandas as pd
import pytest

from studies import wrong_inputs
from studies.wrong_inputs import KINDS, Case, one_case, summary


def contents(folder):
    """Return all files of a folder by name."""
    return {str(f.relative_to(folder)): f.read_bytes() for f in folder.rglob("*") if f.is_file()}


@pytest.mark.parametrize("kind", ["cut closing", "s above ms", "other phase", "motions swapped"])
def test_a_wrong_input_differs_from_its_twin_and_a_seed_repeats_it(tmp_path, kind):
    make, _ = KINDS[kind]
    folders = [tmp_path / name for name in ("wrong", "again", "right")]
    for folder in folders:
        make(Case([3], folder), folder.name != "right")
    wrong, again, right = map(contents, folders)
    assert wrong == again
    assert wrong != right


def test_a_record_has_the_stroke_that_it_states(tmp_path):
    for motion in ("closing", "opening"):
        record = Case([1], tmp_path).record(motion)
        rests = (record.travel[record.time < record.first - 1], record.travel[-50:])
        assert abs(np.median(rests[1]) - np.median(rests[0])) == pytest.approx(
            record.stroke, rel=0.01
        )


@pytest.mark.parametrize(("remark", "silent"), [("", 1), ("ends before its rest", 0)])
def test_an_answer_without_a_word_is_silent(monkeypatch, remark, silent):
    """A product that answers everything, with the same remark or none."""
    monkeypatch.setattr(wrong_inputs, "call", lambda *_: (0, f'{{"remarks": ["{remark}"]}}', ""))
    table = summary(pd.DataFrame(one_case("cut closing", 0, 1)))
    assert table.loc[0, ["cases", "silent", "warned", "refused"]].tolist() == [
        1, silent, 1 - silent, 0
    ]  # fmt: skip
    assert table.loc[0, "twins_warned"] == 1 - silent
