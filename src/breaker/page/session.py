"""What a page knows: the files of a folder, and inspections as the commands read and judge them."""

import gc
import json
import os
import re
import shutil
import tempfile
import threading
import time
from argparse import Namespace
from collections import OrderedDict, defaultdict
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple
from urllib.parse import urlencode

from breaker.common.text import bare
from breaker.diagnosis.report import Report, report_of
from breaker.diagnosis.session import Diagnosis
from breaker.page.catalogue import DROPPED, Inspection, find_files, inspections_of
from breaker.page.choices import Choices, SettingRow, base_of, id_of, overlay_text, rows_of
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

_KEPT = 2  # results of each kind that are kept, so that going back to an inspection is quick
_LOOKS = 0.5  # s, for which files of a list are described before it is shown again
_DROPPED = 256 * 2**20  # bytes of all dropped files: four of the largest records
_TRAVEL = "travel_column"  # it chooses among several channels, also where it is the base's


class Commands(NamedTuple):
    """Functions of the commands.

    Attributes:
        settings_of: Return the configuration of overlays.
        read_of: Return the ``Diagnosis`` of options, with files that are opened already.
        content_of: Return the bytes of a report by ending, and a remark.
    """

    settings_of: Callable[[Sequence[str]], Mapping]
    read_of: Callable[[Namespace, Files], Diagnosis]
    content_of: Callable[[Report, str], tuple[bytes, str]]


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
        source: The diagnosis whose estimates and changes it has, as limits change neither.
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
    source: Diagnosis | None
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
        self._kept: dict[str, OrderedDict[Hashable, Any]] = defaultdict(OrderedDict)
        self._lock = threading.RLock()
        self.types = self.config["types"] or os.path.abspath(types)
        self._described: dict[tuple, Description] = {}

    def _once(self, kind: str, key: Hashable, find: Callable[[], Any]) -> Any:
        """Return what was found before, or is found now, by one thread at a time."""
        with self._lock:
            kept = self._kept[kind]
            if key not in kept:
                kept[key] = find()
            kept.move_to_end(key)
            while len(kept) > _KEPT:
                kept.popitem(last=False)
            return kept[key]

    @property
    def config(self) -> Mapping:
        """The configuration of the command line."""
        states = tuple(map(_state, self.overlays))
        return self._once("config", states, lambda: self.commands.settings_of(self.overlays))

    # ---- the list ----

    def files(self) -> dict[str, str]:
        """Return paths of all files by identifier.

        Raises:
            MissingError: If the folder is not there any more.
        """
        if os.path.isdir(self.named):
            paths = find_files(Path(self.named))
        elif os.path.exists(self.named):
            paths = {id_of(Path(self.named).name): self.named}
        else:
            raise MissingError(
                f"the folder {printable(self.named)} is not there any more: was it renamed, or its "
                "disk removed? Put it back and load this page again"
            )
        dropped = find_files(self.dropped) if self.dropped.is_dir() else {}
        return {id_of(f"{DROPPED}/{name}"): path for name, path in dropped.items()} | paths

    def inspections(self, look: bool = True) -> list[Inspection]:
        """Return the inspections of the list. Files are described for half a second at most, so
        that the list is shown at once; those not described yet are ``seen`` later.
        """
        files, about = self.files(), {}
        end = time.monotonic() + (_LOOKS if look else 0.0)
        for name, path in files.items():
            if _state(path) in self._described or time.monotonic() < end:
                about[name] = self._description_of(path)
        key = tuple(files), tuple(map(id, about.values()))
        return self._once("list", key, lambda: inspections_of(files, about))

    def _description_of(self, path: str) -> Description:
        state = _state(path)
        if state not in self._described:
            self._described[state] = Description() if os.path.isdir(path) else describe_file(path)
        return self._described[state]

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
        names = [name for name, _ in parts]
        for name in names:
            if Path(name).name != name or name in ("", ".", "..") or "\0" in name:
                raise ValueError(f"{printable(name)} is no name of a file; drop files, not folders")
        folder = Path(tempfile.mkdtemp(prefix="", dir=self.dropped))
        for k, (name, content) in enumerate(parts):
            again = f" ({k + 1})" if name in names[:k] else ""
            place = folder / f"{Path(name).stem}{again}{Path(name).suffix}"
            with place.open("xb") as file:
                file.write(content)
        if not find_files(folder):
            shutil.rmtree(folder)
            listed = ", ".join(map(printable, names))
            raise ValueError(f"{listed}: no export among them; drop text, Excel or COMTRADE files")

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
        files, before = (self._paths(names) for names in (choices.files, choices.before))
        states = tuple(map(_state, (*files, *before, *self.overlays)))
        now = f"{hash((states, _state(self.types))) & 0xFFFFFFFFFFFF:x}"
        if state not in ("", now):
            raise ChangedError("a file has changed since this page was shown: load the page again")
        opened = self._once("files", states, Files)
        find = lambda: self._read(choices, files, before, opened, now)  # noqa: E731
        shown = self._once("shown", (choices.query, now), find)
        return self._once("shown", (shown.choices.query, now), lambda: shown)

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
        self, choices: Choices, files: list[str], before: list[str], opened: Files, state: str
    ) -> Shown:
        config, first = self.config, files[0]
        own = config["endurance"]["format"]
        if os.path.isdir(first):
            first = next(iter(record_files(first)), "")
        sheet, proposal, trouble = _propose(first, opened, config)
        if own != FORMAT:  # the user's settings count, not the proposed ones
            proposal = None
        name = self.type_of(choices, files)
        types = read_types(self.types, config)
        entry = next((some for known, some in types.items() if bare(known) == bare(name)), None)
        base = base_of(own, proposal)
        chosen = {k: v for k, v in choices.settings.items() if v != base[k] or k == _TRAVEL}
        choices = choices._replace(settings=chosen)
        if {"ratio", "travel_unit", _TRAVEL} & {*chosen, *(entry or ())}:
            base["stroke"] = FORMAT["stroke"]  # the proposal's is of its own scale
        form = {key: value for key, value in {**base, **chosen}.items() if value != own[key]}
        of_types = self.types if entry is not None or (types and not name) else None
        overlay = overlay_text(form, of_types)
        about = {"files": files, "before": before, "type": name if entry is not None else ""}
        about["channel"] = [str(chosen[_TRAVEL])] if _TRAVEL in chosen else []
        diagnosis = source = None
        try:
            diagnosis, source = self._diagnose(about, choices.same, overlay, opened)
            trouble = ""
        except (ValueError, OSError) as error:
            trouble = re.sub(rf"{re.escape(str(self.own))}\S*/my\.yaml, line \d+: ", "", str(error))
        rows = rows_of(base, proposal, sheet, chosen, diagnosis, trouble)
        remarks = proposal.remarks if proposal else ()
        results = trouble, diagnosis, source, sheet
        return Shown(choices, overlay, rows, remarks, *results, opened, state)

    def _diagnose(
        self, about: Mapping[str, Any], same: bool, overlay: str, opened: Files
    ) -> tuple[Diagnosis, Diagnosis]:
        """Return the inspection, and the one of the same files and settings, apart from limits,
        whose records it has.
        """
        with tempfile.TemporaryDirectory(dir=self.own) as folder:
            file = Path(folder, "my.yaml")
            file.write_text(overlay, encoding="utf-8")
            options = {**about, "same_transducer": same, "config": [*self.overlays, str(file)]}
            options |= {"reference": None, "tolerance": None}  # options that the page does not have
            new = self.commands.read_of(Namespace(**options), opened)
        settings = {**new.config, "limits": None, "types": None}
        same = [same, about["files"], about["before"], about["channel"]]
        key = opened, json.dumps([*same, settings], default=str)
        source = self._once("source", key, lambda: new)
        return replace(new, records=source.records, before=source.before), source

    def type_of(self, choices: Choices, files: Sequence[str] = ()) -> str:
        """Return the type of the breaker: the one that is chosen, or else stated by its file."""
        first = (files or self._paths(choices.files))[0]
        if choices.type or os.path.isdir(first):
            return choices.type
        return self._description_of(first).preamble.type

    def measured(self, choices: Choices, state: str = "") -> Diagnosis:
        """Return an inspection without the model's answer; raise as ``shown``, and ValueError if
        nothing can be used.
        """
        shown = self.shown(choices, state)
        if shown.diagnosis is None:
            raise ValueError(shown.trouble)
        find = lambda: replace(shown.diagnosis, families=tuple)  # noqa: E731
        return self._once("measured", shown.diagnosis, find)

    def complete(self, choices: Choices, state: str = "") -> Diagnosis:
        """Return an inspection with the model's answer and changes; raise as ``measured``."""
        self.measured(choices, state)  # what is wrong with the records is said before
        shown = self.shown(choices, state)
        inferred = {"estimates": shown.source.estimates, "changes": shown.source.changes}
        vars(shown.diagnosis).update(inferred)
        return shown.diagnosis

    def sheet(self, choices: Choices, state: str) -> bytes:
        """Return the sheet of an inspection, as ``breaker report`` writes it; raise as
        ``measured``.
        """
        try:
            report = report_of(self.complete(choices, state))
            return self.commands.content_of(report, ".html")[0]
        finally:
            gc.collect()  # the figures of a sheet hold themselves, 20 MB of them


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
        state = os.stat(path)
    except OSError:
        return (path,)
    if os.path.isdir(path):
        inside = (*sorted(record_files(path)), Path(path, MANIFEST))
        return path, hash(tuple(_state(str(part)) for part in inside)), state.st_mtime_ns
    return path, state.st_ino, state.st_size, state.st_mtime_ns, state.st_ctime_ns
