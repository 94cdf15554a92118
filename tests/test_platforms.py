"""What other systems than Linux do in another way."""

import os

import pytest

from breaker.cli.outputs import whole


def test_a_file_is_written_whole_where_only_open_files_for_writing_can_be_synchronised(
    tmp_path, monkeypatch
):
    """As on Windows; and what was there stays read-only where it was."""
    fcntl = pytest.importorskip("fcntl")
    synchronised = []

    def fsync(number):
        assert fcntl.fcntl(number, fcntl.F_GETFL) & os.O_ACCMODE != os.O_RDONLY
        synchronised.append(number)

    monkeypatch.setattr(os, "fsync", fsync)
    file = tmp_path / "a.txt"
    file.write_text("old", encoding="utf-8")
    file.chmod(0o444)
    with whole(file) as part:
        part.write_text("new", encoding="utf-8")
    assert file.read_text(encoding="utf-8") == "new"
    assert file.stat().st_mode & 0o777 == 0o444
    assert len(synchronised) == 1
