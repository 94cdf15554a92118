"""Tests that every format of curve files passes.

A subclass has a fixture ``example``, whose ``write`` writes ``TIME`` and ``TRAVEL`` into a file of
the format. The settings name columns and units; what they leave out is as in the defaults.
"""

from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from breaker.records.files import Opened, RejectedCurveError
from breaker.records.formats.detection import ENDINGS, FORMATS, format_of, look_into, read_columns
from breaker.records.settings import TO_MS, complete
from breaker.records.words import split_unit
from tests.records.refused import refusal

TIME = np.round(0.1 * np.arange(60), 1)
"""Times of the example, ms."""

TRAVEL = np.round(0.02 * np.arange(60) ** 1.5, 3)
"""Travel of the example, mm."""


class Example(NamedTuple):
    """A file of a format.

    Attributes:
        name: Of the file.
        settings: Those of ``endurance.format`` that read it.
        channel: Its column of travel, in mm.
        write: Writes ``TIME`` and ``TRAVEL`` into a file.
    """

    name: str
    settings: Mapping
    channel: str
    write: Callable[[Path], None]


class FormatContract:
    """The tests; a subclass has a fixture ``example``."""

    @pytest.fixture
    def curve_file(self, tmp_path, example) -> Path:
        """The example as a file."""
        example.write(tmp_path / example.name)
        return tmp_path / example.name

    @pytest.fixture
    def settings(self, example) -> Mapping:
        """All settings that read the example."""
        return complete(example.settings)

    def test_it_is_one_of_the_formats(self, curve_file):
        format_ = format_of(Opened(curve_file))
        assert format_ in FORMATS
        assert {curve_file.suffix, *format_.endings} <= {*ENDINGS}

    def test_what_is_read_is_what_was_written(self, curve_file, settings):
        columns = read_columns(curve_file, settings)
        assert np.allclose(columns.time * TO_MS[settings["time_unit"]], TIME)
        assert np.allclose(columns.travel, TRAVEL, atol=1e-3)
        assert columns.lines.shape == columns.time.shape == columns.travel.shape

    def test_what_it_shows_holds_what_is_read(self, curve_file, settings, example):
        layout = look_into(curve_file)
        place = [split_unit(name)[0] for name in layout.names].index(example.channel)
        usual = format_of(Opened(curve_file)).endings
        assert layout.kind == usual.get(curve_file.suffix, layout.kind) != ""
        read = read_columns(curve_file, settings).travel
        assert np.allclose(layout.columns[place], read)
        assert layout.units[place] == "mm"

    def test_another_column_is_refused_by_name(self, curve_file, settings):
        with pytest.raises(RejectedCurveError, match="no such"):
            read_columns(curve_file, settings, "no such")

    @pytest.mark.parametrize("content", [b"", b"\0\1\2" * 99, b"no record", None])
    def test_what_is_no_record_is_refused_in_one_line(self, curve_file, settings, content):
        curve_file.unlink()
        if content is not None:
            curve_file.write_bytes(content)
        for use in (lambda: read_columns(curve_file, settings), lambda: look_into(curve_file)):
            assert refusal(curve_file, use).isprintable()

    def test_damaged_files_are_read_or_refused(self, curve_file, settings):
        """Cut, and with flipped bytes: no other error."""
        whole, rng = curve_file.read_bytes(), np.random.default_rng(1)
        for i in range(40):
            damaged = bytearray(whole[: rng.integers(1, len(whole))] if i % 3 == 0 else whole)
            for place in rng.integers(len(damaged), size=i % 5):
                damaged[place] = rng.integers(256)
            curve_file.write_bytes(damaged)
            with suppress(RejectedCurveError):
                assert read_columns(curve_file, settings).travel.size > 0

    def test_an_opened_file_stays_what_it_was(self, curve_file, settings):
        opened = Opened(curve_file)
        before = read_columns(opened, settings).travel
        for item in curve_file.parent.iterdir():
            item.unlink()
        assert np.array_equal(read_columns(opened, settings).travel, before)
