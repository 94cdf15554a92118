"""A first ``operations.csv`` of a folder, to be checked and completed. Light to import.

What files state goes before their names. What neither states is FILL IN, so that the table is
refused until it is completed.
"""

import math
import os
from collections import Counter, defaultdict
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

from breaker.common.numerals import natural
from breaker.common.safe_text import table_text
from breaker.model.parameters import MOTIONS
from breaker.model.quantities import ABOUT
from breaker.records.dates import dates_of, day_order, in_order, name_dates
from breaker.records.file_names import numbers_in, phases_in_names
from breaker.records.files import MOST_PARTS, is_store, printable
from breaker.records.folder import record_files, why_no_record
from breaker.records.header import Header
from breaker.records.lexicon import WORDS
from breaker.records.operations import FILL_IN, LONGEST
from breaker.records.settings import FORMAT
from breaker.records.words import by_words, motions_in

_meant = by_words(WORDS["stated"])
_COLUMNS = ("file", "motion", "operation", "channel", *ABOUT, "from", "to")
_Row = dict[str, Any]  # cells of a row of the table, and the folder that may be its breaker


class Part(NamedTuple):
    """A motion of a channel that is seen in a file.

    Attributes:
        motion: "closing" or "opening".
        channel, phase: Column of the travel, and its phase; empty if nothing states it.
        begin, end: Part of the record that contains the motion, ms; NaN for its ends.
        ratio: Stated mm for one unit of the reading; NaN where there is none.
        beside: Columns that go with it, by their settings, as ``contact_column``.
    """

    motion: str
    channel: str
    phase: str
    begin: float
    end: float
    ratio: float
    beside: Mapping[str, str | int] = MappingProxyType({})


class Description(NamedTuple):
    """What is seen in a file.

    Attributes:
        preamble: Header of the file.
        parts: Motions in the file.
        rate: kHz; NaN where it is doubtful or not stated, None where nothing is seen.
        timed: Whether it has the times of its samples.
        settings: Of ``endurance.format``, as far as the file shows them; FILL IN for others.
        sure: Whether it is certain which of its motions close.
        reason: Why it is not a record; empty if it may be one.
        samples: Digest of the samples of its travels, the same in copies; empty where not known.
    """

    preamble: Header = Header()
    parts: tuple[Part, ...] = ()
    rate: float | None = None
    timed: bool = False
    settings: Mapping[str, Any] = MappingProxyType({})
    sure: bool = True
    reason: str = ""
    samples: str = ""


class _File(NamedTuple):
    """A file: its path from the folder of the table, the motions that its folders or its name
    state, its other folders, and what is seen in it.
    """

    path: str
    motions: tuple[str, ...]
    folder: str
    seen: Description = Description()


def propose_manifest(
    folder: str | Path,
    channels: Sequence[str] = (),
    motions: Sequence[str] = MOTIONS,
    look: Callable[[Path], Description] | None = None,
    *,
    configured: bool = False,
) -> tuple[str, list[str]]:
    """Propose the table of a folder and those below it.

    Files go before names. A folder is a motion if it is named after one, and else a breaker. The
    counter comes from the names where they leave no doubt; else operations are numbered from 1.

    Args:
        folder: Folder of the curve files.
        channels: Columns of travel of each file, each a phase of its own.
        motions: Which motions have rows; a file of another one is left out.
        look: Describes a file, so that not only its name counts.
        configured: Whether a configuration states how the files are read.

    Returns:
        The text of the table, and what to check in it, in words.

    Raises:
        FileNotFoundError: If there is no such folder, or no record of these motions.
    """
    if not os.path.isdir(folder):
        raise FileNotFoundError(f"there is no folder {printable(folder)!r}; name that of the files")
    remarks: list[str] = []
    files = _files(Path(folder), remarks)
    if look:
        seen = [look(Path(folder, file.path)) for file in files]
        files = [file._replace(seen=each) for file, each in zip(files, seen, strict=True)]
        files = [_of_configuration(file) for file in files] if configured or channels else files
        files = _records(files, remarks)
    about = zip(files, _breakers(files), _dates(files), strict=True)
    rows = [row for each in about for row in _rows(*each, channels)]
    rows = [row for row in rows if row["motion"] in (*motions, FILL_IN)]
    if not rows:
        reason = f"{printable(folder)} has no file of a record of {' or '.join(motions)}"
        raise FileNotFoundError("; ".join([reason, *remarks]))
    groups: dict[tuple, list[_Row]] = defaultdict(list)
    for row in rows:
        groups[row["breaker"], row["folder"] if row["breaker"] == FILL_IN else ""].append(row)
    for (breaker, _), own in groups.items():
        _number(own, breaker, remarks)
    rows.sort(key=lambda row: (row["breaker"], row["operation"], row["motion"]))
    defaults = {key: _cell(value, key) for key, value in FORMAT.items()}
    shown = [k for k in FORMAT if any(row.get(k, "") not in ("", defaults[k]) for row in rows)]
    for name in (*_COLUMNS, *shown):
        if lacking := [row["file"] for row in rows if row.get(name) == FILL_IN]:
            remarks.append(f"{name} of {len(lacking)} rows is to be filled in, first {lacking[0]}")
    return table_text([*_COLUMNS, *shown], rows), remarks


def _files(folder: Path, remarks: list[str]) -> list[_File]:
    """Return the files in a folder and below that may be records; remark on those left out."""
    found = []
    for count, (place, folders, _) in enumerate(os.walk(folder)):
        if count > MOST_PARTS:
            reason = f"{printable(folder)} has more than {MOST_PARTS:,} folders"
            raise FileNotFoundError(f"{reason}; name the folder of the curve files")
        folders[:] = sorted(e for e in folders if not e.startswith(".") and not is_store(e))
        for file in record_files(place):
            path = file.relative_to(folder).as_posix()
            if why := why_no_record(file):
                remarks.append(f"left out: {printable(path)} {why}")
                continue
            parts = path.split("/")[:-1]
            # The folder that is nearest to the file goes first, then its name.
            texts = [*reversed(parts), file.stem, folder.resolve().name]
            motions = next(filter(None, map(motions_in, texts)), (FILL_IN,))
            found.append(_File(path, motions, "/".join(p for p in parts if not motions_in(p))))
    return found


def _of_configuration(file: _File) -> _File:
    """Return a file without what a configuration states; headers go before it."""
    seen, motions = file.seen, tuple(m for m in MOTIONS if m in {p.motion for p in file.seen.parts})
    if file.motions == (FILL_IN,) and motions:
        file = file._replace(motions=motions)
    parts = seen.parts if seen.preamble.serial or seen.preamble.bay else ()
    return file._replace(seen=seen._replace(parts=parts, settings={}, sure=True, reason=""))


def _records(files: Sequence[_File], remarks: list[str]) -> list[_File]:
    """Return the files that may be records, each once: of those with equal samples the first."""
    first: dict[str, _File] = {}
    for file in sorted(files, key=lambda file: natural(file.path)):
        other = first.get(samples := file.seen.samples or file.path)
        if file.seen.reason and file.motions == (FILL_IN,):
            remarks.append(f"left out: {printable(file.path)} is no record: {file.seen.reason}")
        elif other:
            what = f"left out: {file.path} has the samples of {other.path}"
            remarks.append(f"{what}; export it again if it is of another breaker, date or phase")
        else:
            first[samples] = file
    return [*first.values()]


def _breakers(files: Sequence[_File]) -> list[str]:
    """Return the serial number or bay that each file states, or else its folder; to be filled in
    where other files, or others of the folder, state theirs.
    """
    stated = [f.seen.preamble.serial or " ".join(f.seen.preamble.bay.split()) for f in files]
    states = {file.folder for file, name in zip(files, stated, strict=True) if name}
    others = [FILL_IN if states and f.folder in {*states, ""} else f.folder for f in files]
    return [(name or other)[:LONGEST] for name, other in zip(stated, others, strict=True)]


def _dates(files: Sequence[_File]) -> list[str]:
    """Return the date in the header of each file, or else in its name. Others of the same kind
    decide where the day and the month may be either; else it is to be filled in.
    """
    pairs = [pair for file in files for pair in file.seen.preamble.pairs]
    order = day_order(dates_of(pair.text) for pair in pairs if "date" in _meant(pair.name))
    names = [name_dates(Path(file.path).stem) for file in files]
    order_of_names = day_order(names)
    found = []
    for file, named in zip(files, names, strict=True):
        stated = file.seen.preamble.dates
        readings = dict(zip((True, False), stated * (3 - len(stated)), strict=False))
        days = in_order(readings, order) if stated else in_order(named, order_of_names)
        found.append(FILL_IN if len(days) > 1 else "".join(days))
    return found


# ---- rows ----------------------------------------------------------------------------------------


def _rows(file: _File, breaker: str, date: str, channels: Sequence[str]) -> list[_Row]:
    """Return a row for each motion of each channel in a file, without the counter."""
    seen = file.seen
    sure = seen.sure or {part.motion for part in seen.parts} <= {*file.motions}
    unsure = {} if sure else {"motion": FILL_IN, "sign": FILL_IN}
    cells: _Row = {"file": file.path, "folder": file.folder, "breaker": breaker, "date": date}
    if seen.settings:
        cells |= {key: _cell(e, key) for key, e in {**FORMAT, **seen.settings}.items()}
    cells |= {"channel": "", "phase": "", "rate": ""}
    if not seen.timed and seen.rate is not None:
        cells["rate"] = FILL_IN if math.isnan(seen.rate) else _cell(seen.rate)
    if channels or not seen.parts:
        some = [{"channel": e, "phase": e} for e in channels] or [{}]
        return [{**cells, "motion": m, **each, **unsure} for m in file.motions for each in some]
    phases = Counter(dict({part.channel: part.phase for part in seen.parts}).values())
    found = []
    for part in seen.parts:
        own = {"motion": part.motion, "channel": part.channel, "phase": part.phase, **part.beside}
        own |= {"from": _cell(part.begin), "to": _cell(part.end)}
        if phases.total() > 1 and (not part.phase or phases[part.phase] > 1):
            own["phase"] = FILL_IN
        if cells["rate"] == FILL_IN and len(seen.parts) > phases.total():
            own |= {"from": FILL_IN, "to": FILL_IN}
        if part.ratio > 0:
            own["ratio"] = _cell(part.ratio)
        found.append({**cells, **own, **unsure})
    return found


def _cell(value: object, key: str = "") -> str:
    """Return the cell of a setting or a number; empty if it is not known, as None or NaN."""
    if value is None or value != value:
        return "none" if key == "time_column" else ""
    if isinstance(value, float):
        return f"{value:.6g}"
    return {"\t": "tab", " ": "blank"}.get(str(value), str(value))


def _number(rows: Sequence[_Row], breaker: str, remarks: list[str]) -> None:
    """Add phases in names, and counters: those in the names if they leave no doubt, else from 1, by
    the dates if all rows have one, then by name. The first operations of a day, in any motion and
    pole, are those after the last of the day before.
    """
    named = phases_in_names([*{Path(row["file"]): 0 for row in rows if not row["phase"]}])
    poles: dict[tuple[str, str], list[_Row]] = defaultdict(list)
    for row in rows:
        row["phase"] = row["phase"] or named.get(Path(row["file"]), "")
        row["pole"] = row["motion"], row["channel"] if row["phase"] == FILL_IN else row["phase"]
        poles[row["pole"]].append(row)
    sure = True
    for own in poles.values():
        numbers = numbers_in([Path(row["file"]).stem for row in own])
        sure = sure and len({*numbers} - {None}) == len(own)
        for row, number in zip(own, numbers, strict=True):
            row["operation"] = number
    if sure:
        return
    text = f"{len(rows)} rows are numbered from 1 in the order of dates or names"
    remarks.append(f"{breaker}: {text}" if breaker else text)
    dated = all(row["date"] not in ("", FILL_IN) for row in rows)
    counts: Counter = Counter()
    before, last = 0, ""
    for row in sorted(rows, key=lambda row: (row["date"] if dated else "", natural(row["file"]))):
        if dated and row["date"][:10] != last:
            before, last = before + max(counts.values(), default=0), row["date"][:10]
            counts.clear()
        counts[row["pole"]] += 1
        row["operation"] = before + counts[row["pole"]]
