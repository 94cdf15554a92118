"""A file is opened only if it is one, and nothing waits; what is said of it can be printed."""

import os
import socket
import threading
from pathlib import Path

import pytest

from breaker.records.files import LARGEST, RejectedCurveError, no_file, printable, read_bytes


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
    assert no_file(file) in str(said[0])
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
