"""Wrong inputs differ from their right twins, and a fault of the commands is caught."""

import pandas as pd
import pytest

from studies import wrong_inputs
from studies.wrong_inputs import KINDS, Case, one_case, summary


def contents(folder):
    """Return all files of a folder by name."""
    return {str(f.relative_to(folder)): f.read_bytes() for f in folder.rglob("*") if f.is_file()}


@pytest.mark.parametrize("kind", ["cut closing", "s above ms"])
def test_a_wrong_input_differs_from_its_twin_and_a_seed_repeats_it(tmp_path, kind):
    make, _ = KINDS[kind]
    folders = [tmp_path / name for name in ("wrong", "again", "right")]
    for folder in folders:
        make(Case([3], folder), folder.name != "right")
    wrong, again, right = map(contents, folders)
    assert wrong == again
    assert wrong != right


@pytest.mark.parametrize(("remark", "silent"), [("", 1), ("ends before its rest", 0)])
def test_an_answer_without_a_word_is_silent(monkeypatch, remark, silent):
    """A product that answers everything, with the same remark or none."""
    monkeypatch.setattr(wrong_inputs, "call", lambda *_: (0, f'{{"remarks": ["{remark}"]}}', ""))
    table = summary(pd.DataFrame(one_case("cut closing", 0, 1)))
    columns = ["cases", "silent", "warned", "refused", "twins_warned"]
    assert table.loc[0, columns].tolist() == [1, silent, 1 - silent, 0, 1 - silent]
