"""What a page knows: the files of a folder, and inspections as the commands read and judge them."""

import gc
import os
import re
import shutil
import tempfile
import threading
import time
from argparse import Namespace
from collections import OrderedDict
from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from concurrent.futures import Future
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple
from urllib.parse import urlencode

from breaker.common.text import bare
from breaker.diagnosis.report import Report, report_of
from breaker.diagnosis.session import Diagnosis
from breaker.page.catalogue import DROPPED, Inspection, find_files, inspections_of
from breaker.page.choices import Choices, SettingRow, id_of, overlay_text, rows_of
from breaker.page.types import read_types
from breaker.records.description import describe_file
from breaker.records.files import Files, printable
from breaker.records.folder import record_files
from breaker.records.formats.registry import look_into
from breaker.records.operations import MANIFEST
from breaker.records.proposal import Proposal, inspect_file
from breaker.records.settings import FORMAT
from breaker.records.sheet import Sheet
from breaker.records.table_proposal import Description

_KEPT = 2  # inspections that are kept, so that going back to one is quick
_OPEN = 1  # inspections whose files are kept open
_LOOKS = 0.5  # s, for which files of a list are described before it is shown again
_DROPPED = 256 * 2**20  # bytes of all dropped files: four of the largest records
_NONE = {"reference": None, "tolerance": None}  # options that the page does not have
_TRAVEL = "travel_column"  # it chooses among several channels, also where it is the base's


class Commands(NamedTuple):
    """Functions of the commands.

    Attributes:
        settings_of: Return the configuration of overlays.
        read_of: Return the ``Diagnosis`` of options, with files that are opened already.
        content_of: Return the bytes of a report by ending, and a remark.
        write_lines: Write a text to a new file; takes its name, the text and the files read.
    """

    settings_of: Callable[[Sequence[str]], Mapping]
    read_of: Callable[[Namespace, Files], Diagnosis]
    content_of: Callable[[Report, str], tuple[bytes, str]]
    write_lines: Callable[[str, str, Sequence[str]], str]


@dataclass(frozen=True, eq=False)
class Shown:
    """An inspection as a page shows it.

    Attributes:
        choices: What was chosen, without settings that change nothing.
        overlay: Lines of YAML that repeat it.
        rows: Form of the import settings.
        remarks: Remarks on the proposal.
        trouble: Reason why nothing can be read; empty if it can.
        diagnosis: The inspection; None if there is trouble.
        sheet: Contents of the first file, if it can be read.
        files: Its files, opened.
        state: State of the files as they were read.
    """

    choices: Choices
    overlay: str
    rows: Sequence[SettingRow]
    remarks: Sequence[str]
    trouble: str
    diagnosis: Diagnosis | None
    sheet: Sheet | None
    files: Files
    state: str

    @property
    def query(self) -> str:
        """The query of further requests, which are refused once a file has changed."""
        return f"{self.choices.query}&{urlencode({'state': self.state})}"


class MissingError(ValueError):
    """A file of an address is not, or no longer, in the list."""

    status = 404


class ChangedError(ValueError):
    """A file has changed since a page was shown."""

    status = 409


class Session:
    """A folder or a file, the overlays of the command line, and what was read last.

    Args:
        named: The folder or file.
        overlays: Files of configuration of the command line.
        commands: Functions of the commands.
        own: A folder of this session alone, for dropped files.
        types: File of types where the configuration names none.

    Raises:
        OSError: If the folder cannot be read.
    """

    def __init__(
        self,
        named: str,
        overlays: Sequence[str],
        commands: Commands,
        own: str | Path,
        types: str = "types.yaml",
    ) -> None:
        self.named, self.overlays, self.commands = named, [*overlays], commands
        self.own, self.dropped = Path(own), Path(own, "dropped")
        if os.path.isdir(named):
            os.listdir(named)  # one that may not be read is refused before a page is opened
        elif not os.path.exists(named):
            raise FileNotFoundError(f"there is no {printable(named)}; name a folder of exports")
        self._kept: dict[str, OrderedDict[Hashable, Future]] = {}
        self._lock = threading.Lock()
        self.types = self.config["types"] or os.path.abspath(types)
        self._described: dict[tuple, Description] = {}

    @property
    def config(self) -> Mapping:
        """The configuration of the command line."""
        states = tuple(map(_state, self.overlays))
        return self._once("config", states, lambda: self.commands.settings_of(self.overlays), 1)

    # ---- the list ----

    def files(self) -> dict[str, str]:
        """Return paths of all files by identifier.

        Raises:
            MissingError: If the folder is not there any more.
        """
        if os.path.isdir(self.named):
            found = find_files(Path(self.named))
        elif os.path.exists(self.named):
            found = {id_of(Path(self.named).name): self.named}
        else:
            raise MissingError(
                f"the folder {printable(self.named)} is not there any more: was it renamed, or its "
                "disk removed? Put it back and load this page again"
            )
        dropped = find_files(self.dropped) if self.dropped.is_dir() else {}
        return {id_of(f"{DROPPED}/{name}"): path for name, path in dropped.items()} | found

    def inspections(self, look: bool = True) -> list[Inspection]:
        """Return the inspections of the list. Files are described for half a second at most, so
        that the list is shown at once; those not described yet are ``seen`` later.
        """
        files, found = self.files(), {}
        end = time.monotonic() + (_LOOKS if look else 0.0)
        for name, path in files.items():
            if _state(path) in self._described or time.monotonic() < end:
                found[name] = self._description_of(path)
        return inspections_of(files, found)

    def drop(self, parts: Sequence[tuple[str, bytes]]) -> None:
        """Keep files that were dropped on the page together, for this session alone. Each drop has
        a folder, so that no file replaces one of the same name.

        Raises:
            ValueError: If a name is none of a file, or the files are too large together.
        """
        self.dropped.mkdir(exist_ok=True)
        kept = sum(file.stat().st_size for file in self.dropped.rglob("*") if file.is_file())
        if kept + sum(len(content) for _, content in parts) > _DROPPED:
            limit = f"more than {_DROPPED // 2**20} MiB are dropped"
            raise ValueError(f"{limit}; start breaker view with their folder")
        for name, _ in parts:
            if Path(name).name != name or name in ("", ".", "..") or "\0" in name:
                raise ValueError(f"{printable(name)} is no name of a file; drop files, not folders")
        folder = Path(tempfile.mkdtemp(prefix="", dir=self.dropped))
        for name, content in parts:
            place, number = folder / name, 2
            while place.exists():
                place = folder / f"{Path(name).stem} ({number}){Path(name).suffix}"
                number += 1
            place.write_bytes(content)
        if not find_files(folder):
            shutil.rmtree(folder)
            names = ", ".join(printable(name) for name, _ in parts)
            raise ValueError(f"{names}: no export among them; drop text, Excel or COMTRADE files")

    # ---- an inspection ----

    def shown(self, choices: Choices, state: str = "") -> Shown:
        """Return an inspection as it was read; once for the same files and choices.

        Args:
            choices: What is chosen.
            state: State of the files as a page shows them.

        Raises:
            ChangedError: If they have changed since then.
            MissingError: If a file is not, or no longer, in the list.
            ConfigurationError, OSError, ValueError: If the configuration is wrong.
        """
        files, before = (self._paths(some) for some in (choices.files, choices.before))
        named = (*files, *before, *self.overlays, self.types)
        states = tuple(map(_state, named))  # the last one is that of the types
        now = f"{hash(states) & 0xFFFFFFFFFFFF:x}"
        if state not in ("", now):
            raise ChangedError("a file has changed since this page was shown: load the page again")
        opened = self._once("files", states[:-1], Files, _OPEN)
        same = choices.query, states[:-1]
        find = lambda: self._read(choices, files, before, opened, now, same)  # noqa: E731
        found = self._once("shown", (choices.query, states), find, _KEPT)
        return self._once("shown", (found.choices.query, states), lambda: found, _KEPT)

    def _paths(self, identities: Sequence[str]) -> list[str]:
        """Return the paths of files."""
        files = self.files() if identities else {}
        if lost := [name for name in identities if name not in files]:
            raise MissingError(
                f"{lost[0]} is not in {printable(self.named)} any more, or never was: was it moved "
                "or renamed? Go back to the list"
            )
        return [files[name] for name in identities]

    def _read(
        self,
        choices: Choices,
        files: list[str],
        before: list[str],
        opened: Files,
        state: str,
        same: Hashable,
    ) -> Shown:
        config = self.config
        first = files[0] if not os.path.isdir(files[0]) else next(iter(record_files(files[0])), "")
        sheet, proposal, trouble = _propose(first, opened, config)
        own = config["endurance"]["format"]
        configured = proposal is None or own != FORMAT
        base = {**FORMAT, **own}
        if not configured:
            base |= {**proposal.settings, **dict.fromkeys(proposal.lacking)}
        chosen = {k: v for k, v in choices.settings.items() if v != base[k] or k == _TRAVEL}
        choices = choices._replace(settings=chosen)
        name = self.type_of(choices, files)
        types = read_types(self.types, config).items()
        known = [entry for each, entry in types if bare(each) == bare(name)]
        if {"ratio", "travel_unit", _TRAVEL} & {*chosen, *(known[0] if known else ())}:
            base["stroke"] = FORMAT["stroke"]  # the proposal's is of its own scale
        form = {key: v for key, v in {**base, **chosen}.items() if v != own[key]}
        of_types = self.types if known or (not name and os.path.exists(self.types)) else None
        overlay = overlay_text(form, of_types)
        channels, diagnosis = [str(chosen[_TRAVEL])] if _TRAVEL in chosen else [], None
        about = {"files": files, "before": before, "channel": channels, "type": name * bool(known)}
        try:
            with self._overlay(overlay) as written:
                options = Namespace(**about, **_NONE, config=written, same_transducer=choices.same)
                diagnosis = self.commands.read_of(options, opened)
                diagnosis = self._with_other_limits(diagnosis, same)
                trouble = ""
        except (ValueError, OSError) as error:
            trouble = re.sub(rf"{re.escape(str(self.own))}\S*/my\.yaml, line \d+: ", "", str(error))
        rows = rows_of(base, None if configured else proposal, sheet, chosen, diagnosis)
        wrong = [key for key in chosen if f"endurance.format.{key} " in trouble]
        rows = [
            row._replace(state="missing", reason=trouble) if row.key in wrong else row
            for row in rows
        ]
        rows.sort(key=lambda row: row.key not in wrong)
        remarks = proposal.remarks if proposal else ()
        about = diagnosis, sheet, opened, state
        return Shown(choices, overlay, rows, remarks, trouble, *about)

    def _with_other_limits(self, new: Diagnosis, same: Hashable) -> Diagnosis:
        """Return a diagnosis; if nothing but its limits changed, with the estimates of before."""
        old = self._once("estimated", same, lambda: new, _KEPT)
        about = [{**each.config, "limits": None, "types": None} for each in (old, new)]
        if old is new or about[0] != about[1]:
            self._kept["estimated"].pop(same, None)
            return self._once("estimated", same, lambda: new, _KEPT)
        found = replace(new, records=old.records)  # to which the estimates belong
        if "estimates" in vars(old):
            vars(found)["estimates"] = old.estimates
        return found

    def type_of(self, choices: Choices, files: Sequence[str] = ()) -> str:
        """Return the type of the breaker: the one that is chosen, or else stated by its file."""
        first = (files or self._paths(choices.files))[0]
        if choices.type or os.path.isdir(first):
            return choices.type
        return self._description_of(first).preamble.type

    def _description_of(self, path: str) -> Description:
        state = _state(path)
        if state not in self._described:
            self._described[state] = Description() if os.path.isdir(path) else describe_file(path)
        return self._described[state]

    def diagnosis(self, choices: Choices, state: str = "") -> Diagnosis:
        """Return an inspection; raise as ``shown``, and ValueError if nothing can be used."""
        shown = self.shown(choices, state)
        if shown.diagnosis is None:
            raise ValueError(shown.trouble)
        return shown.diagnosis

    def measured(self, choices: Choices, state: str = "") -> Diagnosis:
        """Return an inspection without the model's answer; raise as ``diagnosis``."""
        found = self.diagnosis(choices, state)
        return self._once("measured", found, lambda: replace(found, families=tuple), _KEPT)

    def sheet(self, choices: Choices, state: str, ending: str) -> bytes:
        """Return the sheet of an inspection, as ``breaker report`` writes it.

        Raises:
            ValueError: If there is none, or it is to be a PDF and WeasyPrint is not installed.
        """
        try:
            return self.commands.content_of(report_of(self.diagnosis(choices, state)), ending)[0]
        finally:
            gc.collect()  # the figures of a sheet hold themselves, 20 MB of them

    def save(self, choices: Choices, name: str) -> str:
        """Write the settings of a page to a new file.

        Raises:
            OSError, ValueError: If it cannot or must not be written there.
        """
        text = self.shown(choices).overlay
        return self.commands.write_lines(name, text, [self.named, *self.overlays])

    @contextmanager
    def _overlay(self, text: str) -> Iterator[list[str]]:
        """Yield the overlays, with lines of YAML in a file behind them."""
        with tempfile.TemporaryDirectory(dir=self.own) as folder:
            file = Path(folder, "my.yaml")
            file.write_text(text, encoding="utf-8")
            yield [*self.overlays, str(file)]

    def _once(self, kind: str, key: Hashable, find: Callable[[], Any], most: int) -> Any:
        """Return what was found before, or is found now; ``most`` of a kind are kept. Whoever asks
        for what is being found waits for it, and nobody else does.
        """
        with self._lock:
            kept = self._kept.setdefault(kind, OrderedDict())
            new = key not in kept
            found = kept.setdefault(key, Future())
            kept.move_to_end(key)
            if len(kept) > most:
                kept.popitem(last=False)
        if new:
            try:
                found.set_result(find())
            except BaseException as error:
                with self._lock:
                    kept.pop(key, None)
                found.set_exception(error)
        return found.result()


def _propose(
    file: str | Path, files: Files, config: Mapping
) -> tuple[Sheet | None, Proposal | None, str]:
    """Return the contents of a file, the proposal for it, and why there is none."""
    first, sheet = files[file], None
    try:
        sheet = look_into(first)
        find = lambda: inspect_file(file, config["sensor"], files=files)  # noqa: E731
        return sheet, first.once(("proposed", str(config["sensor"])), find), ""
    except (ValueError, OSError) as error:
        return sheet, None, str(error)


def _state(path: str) -> tuple:
    """Return the state of a file or folder, which changes with its contents."""
    try:
        found = os.stat(path)
    except OSError:
        return (path,)
    if os.path.isdir(path):
        inside = (*sorted(record_files(path)), Path(path, MANIFEST))
        return path, hash(tuple(_state(str(part)) for part in inside)), found.st_mtime_ns
    return path, found.st_ino, found.st_size, found.st_mtime_ns, found.st_ctime_ns
