"""A file is opened once, and its lines are split once, whatever a command asks of it."""

import argparse
import tracemalloc
from collections import Counter

import pytest

from breaker.cli.command_inputs import read_visit
from breaker.drive.answers.assessment import Assessment
from breaker.drive.answers.drive_records import read_operations
from breaker.quantities.parameters import MOTIONS
from breaker.reading.files import delimited_text as text
from breaker.reading.files import formats, guards
from breaker.reading.files.format_settings import complete
from breaker.reading.files.operations_table import Operation
from breaker.reading.inspection.setting_proposal import inspect_file
from tests.answers.test_parts import written
from tests.exports import write


@pytest.fixture
def counted(monkeypatch):
    """How often files are opened, and texts split."""
    found, (real, split) = Counter(), (guards.read_bytes, text._blocks)
    text._kept_blocks.cache_clear()

    def opened(file):
        found["opened"] += 1
        return real(file)

    def blocks(*form):
        found["split"] += 1
        return split(*form)

    monkeypatch.setattr("breaker.reading.files.guards.read_bytes", opened)
    monkeypatch.setattr(text, "_blocks", blocks)
    return found


def test_three_motions_are_read_of_a_file_that_is_opened_once(tmp_path, counted, monkeypatch):
    monkeypatch.setattr(text, "_KEPT", 0)  # nor are columns read again where no cells are kept
    operation = written(tmp_path / "oco.csv")
    records = read_operations({motion: [operation] for motion in MOTIONS}, {}, loose=True)
    assert [each.reason for each in records] == [""] * 3
    assert counted == {"opened": 1, "split": 1}


def test_channels_of_a_visit_are_read_of_files_that_are_opened_once(tmp_path, counted):
    names = [str(tmp_path / f"{k}.csv") for k in range(2)]
    for k, name in enumerate(names):
        write(name, rate=5.0, seed=k, channels=3)
    form = complete({"time_column": None, "rate": 5.0, "travel_column": "Travel 1"})
    assessment = Assessment({"endurance": {"format": form}})
    records = read_visit(names, argparse.Namespace(channel=[]), assessment)
    assert len({(each.operation.file, each.operation.channel) for each in records}) == 6
    assert not any(each.reason for each in records)
    assert counted == {"opened": 2, "split": 2}


def test_a_file_that_cannot_be_read_is_opened_once(tmp_path, counted):
    (tmp_path / "a.csv").write_text("no record\n")
    operations = {motion: [Operation(1, tmp_path / "a.csv")] for motion in MOTIONS}
    assert read_operations(operations, {}, loose=True)[0].reason
    assert counted["opened"] == 1


def test_a_file_that_is_inspected_is_opened_once(tmp_path, counted, defaults):
    write(tmp_path / "a.csv", rate=5.0, seed=1, channels=3)
    proposal = inspect_file(tmp_path / "a.csv", defaults["sensor"])
    assert sum(bool(each.record) for each in proposal.motions) == 3
    assert counted == {"opened": 1, "split": 1}


def test_cells_of_few_texts_are_kept(tmp_path):
    """Those of eight exports of 2 MB were 185 MB, to the end of a job that takes some 220 else."""
    text._kept_blocks.cache_clear()
    settings = complete({"time_column": "time", "travel_column": "travel"})
    rows = "".join(f"{0.1 * k:.4f},{0.01 * k:.4f}\n" for k in range(30_000))
    tracemalloc.start()
    for k in range(6):
        (tmp_path / f"{k}.csv").write_text(f"time,travel\n{rows}")
        formats.read_columns(tmp_path / f"{k}.csv", settings)
    kept, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert kept < 3 * 15 * len(rows)
