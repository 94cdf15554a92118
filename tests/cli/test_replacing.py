"""Files and folders that appear whole or not at all."""

import os

import pytest

from breaker.cli.outputs import whole


def test_what_was_there_stays_until_all_is_written(tmp_path):
    target = tmp_path / "a.txt"
    target.write_text("old")
    target.chmod(0o640)
    with whole(target) as part:
        part.write_text("new")
        assert target.read_text() == "old"
    assert target.read_text() == "new"
    assert target.stat().st_mode & 0o777 == 0o640
    assert os.listdir(tmp_path) == ["a.txt"]


@pytest.mark.parametrize("error", [OSError(28, "No space left"), KeyboardInterrupt()])
@pytest.mark.parametrize("folder", [False, True])
def test_what_was_there_stays_after_an_error(tmp_path, error, folder):
    target = tmp_path / "a.zarr"
    if folder:
        target.mkdir()
        (target / "old").touch()
    else:
        target.write_text("old")

    def fail():
        with whole(target) as part:
            if folder:
                part.mkdir()
            (part / "half" if folder else part).write_text("half")
            raise error

    with pytest.raises(type(error)):
        fail()
    assert os.listdir(tmp_path) == ["a.zarr"]
    assert (os.listdir(target) == ["old"]) if folder else (target.read_text() == "old")


def test_a_folder_takes_the_place_of_a_folder(tmp_path):
    target = tmp_path / "a.zarr"
    for name in ("old", "new"):
        with whole(target) as part:
            part.mkdir()
            (part / name).touch()
    assert os.listdir(target) == ["new"]
    assert os.listdir(tmp_path) == ["a.zarr"]


def test_a_link_stays_one_and_the_longest_name_is_no_trouble(tmp_path):
    target, link = tmp_path / ("a" * 255), tmp_path / "link"
    link.symlink_to(target.name)
    with whole(link) as part:
        part.write_text("new")
    assert link.is_symlink()
    assert target.read_text() == "new"
