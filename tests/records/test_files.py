"""Which operation a file is: its name says, and a name that does not is refused."""

import os
import socket
import threading
from pathlib import Path

import pytest

from breaker.records.files import (
    LARGEST,
    RejectedCurveError,
    list_curves,
    operation_number,
    printable,
    read_bytes,
)
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
    assert [each.number for each in listed] == [2, 9, 10, 100]
    assert [each.file.name for each in listed] == [f"op_{n}.csv" for n in (2, 9, 10, 100)]


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


# ---- how a file is opened ------------------------------------------------------------------------


def a_pipe(file: Path) -> None:
    os.mkfifo(file)


def a_folder(file: Path) -> None:
    file.mkdir()


def a_socket(file: Path) -> None:
    here = os.getcwd()
    os.chdir(file.parent)  # the path of a socket may have some 100 bytes
    try:
        with socket.socket(socket.AF_UNIX) as end:
            end.bind(file.name)
    finally:
        os.chdir(here)


def a_device(file: Path) -> None:
    file.symlink_to("/dev/zero")


def a_loop(file: Path) -> None:
    file.symlink_to(file.name)


def a_broken_link(file: Path) -> None:
    file.symlink_to("nowhere.csv")


def a_large_file(file: Path) -> None:
    with file.open("wb") as stream:
        stream.truncate(LARGEST + 1)


@pytest.mark.parametrize(
    ("made", "reason"),
    [
        (a_pipe, "is a pipe, not a file"),
        (a_folder, "is a folder, not a file"),
        (a_socket, "is a socket, not a file"),
        (a_device, "is a device, not a file"),
        (a_loop, "a link that leads back to itself; put the file itself"),
        (a_broken_link, "is not there: was it moved or deleted, or does a link lead nowhere"),
        (a_large_file, "has 64 MiB, but no record .* 64 MiB; export it alone"),
        (lambda file: None, "is not there"),
    ],
)
def test_what_is_no_file_is_rejected_and_nothing_waits(tmp_path, made, reason):
    file, said = tmp_path / "op_1.csv", []
    made(file)

    def read():
        try:
            read_bytes(file)
        except RejectedCurveError as error:
            said.append(error)

    thread = threading.Thread(target=read, daemon=True)
    thread.start()
    thread.join(timeout=2.0)
    assert not thread.is_alive(), "waits for a pipe that nobody writes to"
    assert len(said) == 1
    with pytest.raises(RejectedCurveError, match=rf"op_1\.csv: .*{reason}"):
        raise said[0]


def test_a_file_that_grows_beyond_the_limit_is_rejected(tmp_path, monkeypatch):
    file = tmp_path / "op_1.csv"
    file.write_bytes(b"x" * 101)
    monkeypatch.setattr("breaker.records.files.LARGEST", 100)
    monkeypatch.setattr("breaker.records.files._require_regular", lambda *_: None)
    with pytest.raises(RejectedCurveError, match="more"):
        read_bytes(file)


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root reads all")
def test_a_file_without_permission_is_rejected(tmp_path):
    file = tmp_path / "op_1.csv"
    file.write_bytes(b"1")
    file.chmod(0)
    with pytest.raises(RejectedCurveError, match="give yourself the permission"):
        read_bytes(file)


@pytest.mark.parametrize("name", ["a\0b.csv", "x" * 300 + ".csv", "\ud800.csv"])
def test_a_name_that_no_file_has_is_rejected(tmp_path, name):
    with pytest.raises(RejectedCurveError) as told:
        read_bytes(tmp_path / name)
    assert str(told.value).isprintable()


def test_a_file_is_read_as_it_is(tmp_path):
    file = tmp_path / "op_1.csv"
    file.write_bytes(b"\xff\r\n\0")
    assert read_bytes(str(file)) == b"\xff\r\n\0"


@pytest.mark.parametrize(
    ("text", "shown"),
    [("närüß 1.csv", "närüß 1.csv"), ("a\nb\t\x1b[2J", r"a\nb\t\x1b[2J"), ("\udcff", r"\udcff")],
)
def test_what_cannot_be_printed_is_escaped(text, shown):
    assert printable(text) == shown
    assert str(RejectedCurveError(text, "why", line=3)) == f"{shown}, line 3: why"
