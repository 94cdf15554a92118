"""State of a page: files of a folder, and inspections, read and judged as by the commands."""

import json
import os
import threading
import time
from collections import OrderedDict, defaultdict
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

from breaker.common.text import bare
from breaker.configuration.loading import check, merge
from breaker.diagnosis.report import read_inspection
from breaker.diagnosis.session import Diagnosis
from breaker.page.catalogue import Inspection, find_files, inspections_of
from breaker.page.choices import Choices, SettingRow, id_of, rows_of
from breaker.page.types import read_types
from breaker.records.description import Description, describe_file
from breaker.records.files import Files, printable
from breaker.records.folder import record_files
from breaker.records.formats.registry import look_into
from breaker.records.operations import MANIFEST
from breaker.records.proposal import Proposal, inspect_file
from breaker.records.settings import FORMAT
from breaker.records.sheet import Sheet

_KEPT = 2  # results kept of each kind, so that going back to an inspection is fast
_LOOKS = 0.5  # s; longest time for describing files before the list is shown again
_TRAVEL = "travel_column"  # kept even if equal to the proposal, as it selects among channels


@dataclass(frozen=True, eq=False)
class Shown:
    """An inspection on a page.

    Attributes:
        choices: Choices of the user, without settings that change nothing.
        overlay: Keys of a configuration that reproduce the inspection.
        rows: Rows of the import settings.
        remarks: Remarks on the proposal.
        trouble: Reason why no motion can be read; empty if one can.
        diagnosis: Diagnosis of the inspection; None if there is trouble.
        source: Diagnosis with the same estimates and changes, which do not depend on limits.
        sheet: Contents of the first file, if it can be read.
        files: Opened files.
    """

    choices: Choices
    overlay: Mapping[str, Any]
    rows: Sequence[SettingRow]
    remarks: Sequence[str]
    trouble: str
    diagnosis: Diagnosis | None
    source: Diagnosis | None
    sheet: Sheet | None
    files: Files

    @cached_property
    def measured(self) -> Diagnosis:
        """Inspection without results of the model; raise a ValueError if no record can be used."""
        if self.diagnosis is None:
            raise ValueError(self.trouble)
        return replace(self.diagnosis, families=tuple)

    @cached_property
    def complete(self) -> Diagnosis:
        """Inspection with results of the model and changes; raise as ``measured``."""
        if self.diagnosis is None:
            raise ValueError(self.trouble)
        inferred = {"estimates": self.source.estimates, "changes": self.source.changes}
        vars(self.diagnosis).update(inferred)
        return self.diagnosis


class MissingError(ValueError):
    """A file of an address is not, or no longer, in the list."""

    status = 404


class Session:
    """A folder or a file, the configuration of the command line, and the last results.

    Args:
        named: Folder or file.
        config: Configuration.
        limits: Entries of the section ``limits`` to use.
        types: File of types if the configuration names none.

    Raises:
        OSError: If the folder cannot be read.
    """

    def __init__(
        self, named: str, config: Mapping, limits: Sequence[Mapping], types: str = "types.yaml"
    ) -> None:
        self.named, self.config, self.limits = named, config, limits
        if os.path.isdir(named):
            os.listdir(named)  # raises an error for an unreadable folder before a page opens
        elif not os.path.exists(named):
            raise FileNotFoundError(f"there is no {printable(named)}; name a folder of exports")
        self.types = config["types"] or os.path.abspath(types)
        self._kept: dict[str, OrderedDict[Hashable, Any]] = defaultdict(OrderedDict)
        self._lock = threading.RLock()
        self._described: dict[tuple, Description] = {}

    def _once(self, kind: str, key: Hashable, find: Callable[[], Any]) -> Any:
        """Return the kept result for a key, or call ``find`` for it, in one thread at a time."""
        with self._lock:
            kept = self._kept[kind]
            if key not in kept:
                kept[key] = find()
            kept.move_to_end(key)
            while len(kept) > _KEPT:
                kept.popitem(last=False)
            return kept[key]

    # ---- the list ----

    def files(self) -> dict[str, str]:
        """Return paths of all files by identifier.

        Raises:
            MissingError: If the folder no longer exists.
        """
        if os.path.isdir(self.named):
            return find_files(Path(self.named))
        if os.path.exists(self.named):
            return {id_of(Path(self.named).name): self.named}
        raise MissingError(
            f"the folder {printable(self.named)} is not there any more: was it renamed, or its "
            "disk removed? Put it back and load this page again"
        )

    def inspections(self, look: bool = False) -> list[Inspection]:
        """Return the inspections of the list. With ``look``, describe files for at most half a
        second, so that the list appears at once; later calls describe the other files.
        """
        files, about = self.files(), {}
        end = time.monotonic() + (_LOOKS if look else 0.0)
        for name, path in files.items():
            if _state(path) in self._described or time.monotonic() < end:
                about[name] = self._description_of(path)
        return inspections_of(files, about)

    def _description_of(self, path: str) -> Description:
        state = _state(path)
        if state not in self._described:
            self._described[state] = Description() if os.path.isdir(path) else describe_file(path)
        return self._described[state]

    # ---- an inspection ----

    def shown(self, choices: Choices) -> Shown:
        """Return an inspection, which is read once for the same files and choices.

        Raises:
            MissingError: If a file is not, or no longer, in the list.
            ConfigurationError, OSError, ValueError: If the file of types is wrong.
        """
        files, before = (self._paths(names) for names in (choices.files, choices.before))
        states = tuple(map(_state, (*files, *before)))
        opened = self._once("files", states, Files)
        key = choices.query, states, _state(self.types)
        return self._once("shown", key, lambda: self._read(choices, files, before, opened))

    def _paths(self, identities: Sequence[str]) -> list[str]:
        """Return the paths of files by their identifiers."""
        files = self.files() if identities else {}
        if lost := [name for name in identities if name not in files]:
            raise MissingError(
                f"{lost[0]} is not in {printable(self.named)} any more, or never was: was it moved "
                "or renamed? Go back to the list"
            )
        return [files[name] for name in identities]

    def type_of(self, choices: Choices) -> str:
        """Return the chosen type of the breaker, or else the type that its file states."""
        first = self._paths(choices.files)[0]
        if choices.type or os.path.isdir(first):
            return choices.type
        return self._description_of(first).preamble.type

    def _read(self, choices: Choices, files: list[str], before: list[str], opened: Files) -> Shown:
        own = self.config["endurance"]["format"]
        first = next(iter(record_files(files[0])), "") if os.path.isdir(files[0]) else files[0]
        sheet, proposal, trouble = _propose(first, opened, self.config["sensor"])
        base = {**FORMAT, **own}
        if own != FORMAT:  # settings of the user replace the proposal
            proposal = None
        if proposal:
            base |= {**proposal.settings, **dict.fromkeys(proposal.lacking)}
        name, types = self.type_of(choices), read_types(self.types, self.config)
        entry = next((e for known, e in types.items() if bare(known) == bare(name)), None)
        chosen = {k: v for k, v in choices.settings.items() if v != base[k] or k == _TRAVEL}
        choices = choices._replace(settings=chosen)
        if {"ratio", "travel_unit", _TRAVEL} & {*chosen, *(entry or ())}:
            base["stroke"] = FORMAT["stroke"]  # the proposed stroke is in the proposed scale
        form = {key: value for key, value in {**base, **chosen}.items() if value != own[key]}
        of_types = self.types if entry is not None or (types and not name) else None
        overlay = {"types": of_types} | ({"endurance": {"format": form}} if form else {})
        named = choices._replace(type=name if entry is not None else "")
        diagnosis = source = None
        try:
            diagnosis, source = self._diagnose(named, files, before, overlay, opened)
            trouble = ""
        except (ValueError, OSError) as error:
            trouble = str(error)
        rows = rows_of(base, chosen, proposal, sheet, diagnosis.records if diagnosis else ())
        remarks = proposal.remarks if proposal else ()
        results = trouble, diagnosis, source, sheet
        return Shown(choices, overlay, rows, remarks, *results, opened)

    def _diagnose(
        self,
        choices: Choices,
        files: list[str],
        before: list[str],
        overlay: Mapping[str, Any],
        opened: Files,
    ) -> tuple[Diagnosis, Diagnosis]:
        """Return the inspection, and the diagnosis of the same files and settings (except limits)
        that provides its records.
        """
        config = merge(self.config, overlay)
        check(config, curves=False)
        about = {
            "before": before,
            "channels": [str(choices.settings[_TRAVEL])] if _TRAVEL in choices.settings else [],
            "same_transducer": choices.same,
        }
        new = read_inspection(
            config, self.limits, files, **about, of_type=choices.type, opened=opened
        )
        settings = {**new.config, "limits": None, "types": None}
        about |= {"files": files, "reference": new.reference}
        about |= {"settings": settings}
        key = opened, json.dumps(about, default=str)
        source = self._once("source", key, lambda: new)
        records = {name: getattr(source, name) for name in ("records", "before", "overlays")}
        return replace(new, **records), source


def _propose(
    file: str | Path, files: Files, sensor: Mapping
) -> tuple[Sheet | None, Proposal | None, str]:
    """Return the contents of a file, the proposed settings, and the reason if there are none."""
    sheet = None
    try:
        sheet = look_into(files[file])
        find = lambda: inspect_file(file, sensor, files=files)  # noqa: E731
        return sheet, files[file].once("proposed", find), ""
    except (ValueError, OSError) as error:
        return sheet, None, str(error)


def _state(path: str) -> tuple:
    """Return a key of a file or folder that changes with its contents."""
    try:
        state = os.stat(path)
    except OSError:
        return (path,)
    if os.path.isdir(path):
        inside = (*sorted(record_files(path)), Path(path, MANIFEST))
        return path, hash(tuple(_state(str(part)) for part in inside)), state.st_mtime_ns
    return path, state.st_ino, state.st_size, state.st_mtime_ns, state.st_ctime_ns
