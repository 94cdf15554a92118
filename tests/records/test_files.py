"""Which operation a file is: its name says, and a name that does not is refused."""

import pytest

from breaker.records.files import list_curves, operation_number
from breaker.records.manifest import Operation


def fill(folder, *names):
    for name in names:
        (folder / name).write_text("", encoding="utf-8")


@pytest.mark.parametrize(
    ("name", "number"),
    [
        ("operation_0001.csv", 1),
        ("12.csv", 12),
        ("2024-03-05_breaker7_closing_0310.csv", 310),
        ("op-12.csv", 12),
        ("folder_99/op_3.csv", 3),
        ("op_0005_closing.csv", 5),
        ("op_5.v2.csv", 2),
    ],
)
def test_the_last_whole_number_of_the_name_counts(name, number):
    assert operation_number(name) == number


def test_a_name_without_number_is_refused(tmp_path):
    fill(tmp_path, "operation_1.csv", "closing.csv")
    with pytest.raises(ValueError, match=r"closing\.csv: the name has no number.*rename it"):
        list_curves(tmp_path)


def test_a_number_in_the_folder_or_the_ending_does_not_count():
    with pytest.raises(ValueError, match="no number"):
        operation_number("run_7/closing.mp3")


def test_operations_are_in_the_order_of_their_numbers(tmp_path):
    fill(tmp_path, "op_10.csv", "op_9.csv", "op_100.csv", "op_2.csv")
    listed = list_curves(tmp_path)
    assert [number for number, _ in listed] == [2, 9, 10, 100]
    assert [file.name for _, file in listed] == ["op_2.csv", "op_9.csv", "op_10.csv", "op_100.csv"]


def test_only_csv_files_of_the_folder_itself_count(tmp_path):
    (tmp_path / "old").mkdir()
    fill(tmp_path, "op_1.csv", "op_2.txt", "notes 3.md", "old/op_4.csv")
    assert list_curves(str(tmp_path)) == [Operation(1, tmp_path / "op_1.csv")]


def test_two_files_of_one_operation_are_refused_and_both_named(tmp_path):
    fill(tmp_path, "a_7.csv", "b_007.csv", "c_8.csv")
    with pytest.raises(ValueError, match=r"b_007\.csv and .*a_7\.csv are both operation 7; rename"):
        list_curves(tmp_path)


@pytest.mark.parametrize("folder", ["", "not there"])
def test_a_folder_without_csv_is_refused(tmp_path, folder):
    fill(tmp_path, "op_1.txt")
    with pytest.raises(FileNotFoundError, match=r"no CSV file: endurance\.curves must name"):
        list_curves(tmp_path / folder)


def test_endings_in_capitals_count_and_hidden_files_do_not(tmp_path):
    for name in ("op_2.CSV", "op_1.csv", "._op_1.csv", "op_3.txt"):
        (tmp_path / name).write_text("")
    assert [each.number for each in list_curves(tmp_path)] == [1, 2]
