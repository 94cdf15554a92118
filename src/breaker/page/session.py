"""State of a page: files of a folder, and inspections, read and judged as by the commands."""

import os
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from breaker.common.clean_text import bare
from breaker.configuration.loading import check, merge
from breaker.diagnosis.report import read_inspection
from breaker.diagnosis.session import Diagnosis
from breaker.page.catalogue import MOST, Inspection, find_files, inspections_of
from breaker.page.choices import Choices, SettingRow, id_of, labelled, rows_of
from breaker.page.types import read_types
from breaker.records.description import Description, describe_file
from breaker.records.files import Files, printable
from breaker.records.folder import record_files
from breaker.records.formats.detection import look_into
from breaker.records.proposal import inspect_file
from breaker.records.settings import FORMAT

_TRAVEL = "travel_column"  # kept even if equal to the proposal, as it selects among channels


@dataclass(frozen=True)
class Shown:
    """An inspection on a page.

    Attributes:
        choices: Choices of the user, without settings that change nothing.
        type: Type of the breaker, as chosen or else as stated by the first file; may be empty.
        overlay: Keys of a configuration that reproduce the inspection.
        rows: Rows of the import settings.
        remarks: Remarks on the proposal.
        trouble: Reason why no motion can be read; empty if one can.
        diagnosis: Diagnosis of the inspection; None if there is trouble.
    """

    choices: Choices
    type: str
    overlay: Mapping[str, Any]
    rows: Sequence[SettingRow]
    remarks: Sequence[str]
    trouble: str
    diagnosis: Diagnosis | None


class MissingError(ValueError):
    """A file of an address is not, or no longer, in the list."""

    status = 404


class Session:
    """A folder or a file, and the configuration of the command line.

    Args:
        named: Folder or file.
        config: Configuration.
        limits: Entries of the section ``limits`` to use.
        types: File of types if the configuration names none.

    Raises:
        MissingError, OSError: If the folder does not exist, or cannot be read.
    """

    def __init__(
        self, named: str, config: Mapping, limits: Sequence[Mapping], types: str = "types.yaml"
    ) -> None:
        self.named, self.config, self.limits = named, config, limits
        if os.path.isdir(named):
            os.listdir(named)  # raises an error for an unreadable folder before a page opens
        self.files()
        self.types = config["types"] or os.path.abspath(types)

    def files(self) -> dict[str, str]:
        """Return paths of all files by identifier.

        Raises:
            MissingError: If the folder does not exist.
        """
        if os.path.isdir(self.named):
            return find_files(Path(self.named))
        if os.path.exists(self.named):
            return {id_of(Path(self.named).name): self.named}
        what = f"there is no {printable(self.named)}"
        raise MissingError(f"{what}. Name a folder of exports, or put it back.")

    def inspections(self) -> list[Inspection]:
        """Return the inspections of the list."""
        files = self.files()
        return inspections_of(files, {name: description_of(path) for name, path in files.items()})

    def _paths(self, identities: Sequence[str]) -> list[str]:
        """Return the paths of files by their identifiers."""
        files = self.files() if identities else {}
        if lost := [name for name in identities if name not in files]:
            raise MissingError(f"{lost[0]} is not in {self.named}. Go back to the list.")
        return [files[name] for name in identities]

    def shown(self, choices: Choices) -> Shown:
        """Return an inspection.

        Raises:
            MissingError: If a file is not, or no longer, in the list.
            ConfigurationError, OSError, ValueError: If the file of types is wrong.
        """
        files, before = map(self._paths, (choices.files, choices.before))
        first, opened, own = files[0], Files(), self.config["endurance"]["format"]
        name = choices.type or description_of(first).preamble.type
        types = read_types(self.types, self.config)
        entry = next((e for known, e in types.items() if bare(known) == bare(name)), None)
        sheet, proposal, base = None, None, {**FORMAT, **own}
        with suppress(ValueError, OSError):  # the diagnosis gives the reason
            first = next(iter(record_files(first)), first)  # of a folder with a table
            sheet = look_into(opened[first])
            if own == FORMAT:  # settings of the user replace the proposal
                proposal = inspect_file(first, self.config["sensor"], files=opened)
                base |= {**proposal.settings, **dict.fromkeys(proposal.lacking)}
        chosen = {k: v for k, v in choices.settings.items() if v != base[k] or k == _TRAVEL}
        choices = choices._replace(settings=chosen)
        if {"ratio", "travel_unit", _TRAVEL} & {*chosen, *(entry or ())}:
            base["stroke"] = FORMAT["stroke"]  # the proposed stroke is in the proposed scale
        form = {key: value for key, value in {**base, **chosen}.items() if value != own[key]}
        of_types = self.types if entry is not None or (types and not name) else None
        overlay = {"types": of_types} | ({"endurance": {"format": form}} if form else {})
        diagnosis, trouble = None, ""
        try:
            config = merge(self.config, overlay)
            check(config, curves=False)
            about = {"before": before, "same_transducer": choices.same, "opened": opened}
            about["channels"] = [str(chosen[_TRAVEL])] if _TRAVEL in chosen else []
            about["of_type"] = name if entry is not None else ""
            diagnosis = read_inspection(config, self.limits, files, **about)
        except (ValueError, OSError) as error:
            trouble = labelled(str(error))
        rows = rows_of(base, chosen, proposal, sheet, diagnosis.records if diagnosis else ())
        remarks = proposal.remarks if proposal else ()
        return Shown(choices, name, overlay, rows, remarks, trouble, diagnosis)


def description_of(path: str) -> Description:
    """Return header and motions of a file, read once for each state of the file."""
    state = os.stat(path)
    return _described(path, state.st_mtime_ns, state.st_size)


@lru_cache(2 * MOST)
def _described(path: str, *_: int) -> Description:
    return Description() if os.path.isdir(path) else describe_file(path)
