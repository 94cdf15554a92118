"""The page for developers names the modules of the reading wing that one record passes."""

import re
import sys
from pathlib import Path

import pytest
import yaml

import breaker
from breaker.cli import main
from tests.exports import write

PAGE = (Path(__file__).parents[2] / "docs/development.md").read_text(encoding="utf-8")
WING = Path(breaker.__file__).parent / "reading"


def named():
    """Modules of the table, by room, as paths from the wing's folder."""
    part = PAGE.partition("### What one record passes\n")[2].partition("\n### ")[0]
    rows = re.findall(r"^\| [^|]+ \| `(\w+)/` \| ([^|]+) \|$", part, re.M)
    return {f"{room}/{each}.py" for room, some in rows for each in re.findall(r"`(\w+)`", some)}


def passed(*words):
    """Modules of the wing whose functions a command enters, but for what their import enters."""
    found, wing = {}, str(WING)

    def notice(frame, event, _):
        code = frame.f_code
        if event != "call" or code in found or not code.co_filename.startswith(wing):
            return
        above = frame
        while above and (above.f_code.co_name != "<module>" or not _is_own(above)):
            above = above.f_back
        if above is None:
            found[code] = Path(code.co_filename).relative_to(WING).as_posix()

    before = sys.getprofile()
    sys.setprofile(notice)
    try:
        assert main([*words]) == 0
    finally:
        sys.setprofile(before)
    return {*found.values()}


def _is_own(frame):
    return frame.f_code.co_filename.startswith(str(WING.parent))


@pytest.mark.parametrize("channels", [1, 3])
def test_the_page_names_what_a_record_passes(channels, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    form = {"time_column": None, "travel_column": "Travel 1", "rate": None}
    Path("own.yaml").write_text(yaml.safe_dump({"endurance": {"draws": 60, "format": form}}))
    write("one.csv", rate=5.0, channels=channels, motions=("closing", "opening"))
    found = passed("infer", "one.csv", "--config", "own.yaml")
    assert "records/raw_record.py" in found
    assert found - named() == set()


def test_what_the_page_names_is_there():
    assert [each for each in named() if not (WING / each).exists()] == []
