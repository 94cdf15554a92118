"""What a page knows: the files of a folder, and a visit to them as the commands read it."""

import gc
import os
import re
import shlex
import tempfile
import threading
from argparse import Namespace
from collections import OrderedDict
from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from concurrent.futures import Future
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple
from urllib.parse import urlencode

from breaker.app.curve_traces import Mark, Trace, laid_over, marks_of, record_traces
from breaker.app.page_choices import WHOLE, Choices, id_of, overlay_text
from breaker.app.setting_rows import SettingRow, base_of, rows_of
from breaker.diagnosis.curves import overlaid
from breaker.diagnosis.report import Report, report_of
from breaker.diagnosis.session import Diagnosis
from breaker.model.parameters import MOTIONS
from breaker.records.description import describe_file
from breaker.records.files import Files, printable
from breaker.records.folder import is_folder, record_files
from breaker.records.formats.comtrade import lone_data
from breaker.records.formats.registry import look_into
from breaker.records.operations import MANIFEST
from breaker.records.proposal import Proposal, inspect_file
from breaker.records.sheet import Sheet
from breaker.records.table_proposal import Description

SHOWN = 100
"""Files of a list that are looked into at a time."""

_KEPT = 6  # visits, of which the page needs nothing anew
_LISTED = 10_000  # files of lists, whose descriptions are kept
_OPEN = 2  # of which files are kept open
_NONE = {"type": "", "reference": None, "tolerance": None}  # options that a page does not have
_TRAVEL = "travel_column"  # which chooses a channel of several, also where it is the base's


class Commands(NamedTuple):
    """What the commands do, called as they call it.

    Attributes:
        settings_of: The configuration of overlays.
        read_of: The visit that ``breaker report`` reads with options, files opened in those given.
        content_of: The bytes of its report by ending, and what to say of them.
        write_lines: Write a text where nothing of a user is, for a name and what is read.
    """

    settings_of: Callable[[Sequence[str]], Mapping]
    read_of: Callable[[Namespace, Files], Diagnosis]
    content_of: Callable[[Report, str], tuple[bytes, str]]
    write_lines: Callable[[str, str, Sequence[str]], str]


@dataclass(frozen=True, eq=False)
class Shown:
    """Records of a visit as a page shows them.

    Attributes:
        choices: What was chosen.
        overlay: The lines of YAML that repeat it.
        rows: Settings, with reasons.
        remarks: What is to be looked at, in words.
        trouble: Why nothing can be read so; empty if it can.
        read: As of ``breaker report``; None if there is trouble.
        traces: Of the curves.
        command: The command line that writes the same sheet.
        state: Of its files as they were read, a few signs.
    """

    choices: Choices
    overlay: str
    rows: Sequence[SettingRow]
    remarks: Sequence[str]
    trouble: str
    read: Diagnosis | None
    traces: Sequence[Trace]
    command: str
    state: str

    @property
    def address(self) -> str:
        """The query of what is asked about it: as long as its files stay as they are."""
        return f"{self.choices.address}&{urlencode({'state': self.state})}"

    @property
    def clock(self) -> str:
        """Unit of the times of its curves: that of a record, or samples where none was read."""
        return "ms" if any(each.kind == "travel" for each in self.traces) else "samples"


class MissingError(ValueError):
    """Something of an address that is not, or no more, among what is shown."""

    status = 404


class ChangedError(ValueError):
    """A file has changed since a page was shown."""

    status = 409


class Session:
    """A folder or a file, the overlays of the command line, and what was read last.

    Args:
        named: The folder or file.
        overlays: Files of configuration that the command line names.
        commands: What the commands do.
        own: A folder of this session alone, for settings that are not saved.

    Raises:
        OSError: If the folder cannot be read.
    """

    def __init__(
        self, named: str, overlays: Sequence[str], commands: Commands, own: str | Path
    ) -> None:
        self.named, self.overlays, self.commands = named, list(overlays), commands
        self.own = Path(own)
        self.is_folder = is_folder(named)
        if self.is_folder:
            _check_readable(named)  # before a page is opened
        elif not os.path.exists(named):
            raise FileNotFoundError(f"there is no {printable(named)}; name a folder of exports")
        self._kept: OrderedDict[Hashable, Future] = OrderedDict()
        self._lock = threading.Lock()

    # ---- the list ----

    def files(self) -> dict[str, str]:
        """Return paths of all files by their ids.

        Raises:
            MissingError: If the folder is not there any more.
        """
        if not self.is_folder:
            return {id_of(Path(self.named).name): self.named}
        if not os.path.isdir(self.named):
            raise MissingError(
                f"the folder {printable(self.named)} is not there any more: was it renamed, or is "
                "its disk not connected? Put it back and load this page again"
            )
        folder = Path(self.named)
        parts = [folder, *(folder / each for each in MOTIONS)]

        def find() -> dict[str, str]:
            # Data without their description are listed with what is lacking.
            paths = [each for part in parts for each in (*record_files(part), *lone_data(part))]
            return {id_of(os.path.relpath(each, folder)): str(each) for each in paths}

        # Listed anew where the folder has changed: there may be ten thousand.
        return self._once(("listed", *(_times(str(each)) for each in parts)), find, 1)

    def listed(self, identities: Sequence[str], most: int) -> list[Description | None]:
        """Return what is in files of the list; None of those that were not looked into yet, of
        which as many as are told are now.
        """
        files, found = self.files(), []
        for each in identities:
            key = "described", _state(files[each])
            known = self._kept.get(key)
            new = known is None or not known.done()
            look = partial(describe_file, files[each])
            found.append(None if new and most <= 0 else self._once(key, look, _LISTED))
            most -= new
        return found

    @property
    def whole(self) -> bool:
        """Whether the folder says itself which file is which operation."""
        parts = [Path(self.named, each) for each in MOTIONS]
        table = Path(self.named, MANIFEST).exists()
        return self.is_folder and (table or any(each.is_dir() for each in parts))

    # ---- a visit ----

    def shown(self, choices: Choices, state: str = "") -> Shown:
        """Return a visit, read, inferred and judged; once for the same files and choices.

        Args:
            choices: What is chosen.
            state: Of the files as a page shows them, if it does.

        Raises:
            ChangedError: If they have changed since then.
            MissingError: If a file is not, or no more, among those that are listed.
            ConfigurationError, OSError, ValueError: If the configuration is wrong.
        """
        asked = [self.paths(each) for each in (choices.files, choices.before)]
        states = tuple(_state(each) for each in (*asked[0], *asked[1], *self.overlays))
        if state not in ("", _short(states)):
            raise ChangedError("a file has changed since this page was shown: load the page again")
        # One visit is read with many settings, and its files are opened once as long as they stay.
        files = self._once(("files", *states), Files, _OPEN)
        find = lambda: self._shown(choices, asked, files, _short(states))  # noqa: E731
        found = self._once(("shown", choices.address, states), find, _KEPT)
        # What a page then asks about it, it asks by what was chosen in the end.
        return self._once(("shown", found.choices.address, states), lambda: found, _KEPT)

    def paths(self, identities: Sequence[str]) -> list[str]:
        """Return what the command line calls files."""
        files = self.files()
        if lost := [each for each in identities if each not in files and each != WHOLE]:
            raise MissingError(
                f"{lost[0]} is not in {printable(self.named)} any more, or never was: was it moved "
                "or renamed? Go back to the list"
            )
        return [files.get(each, self.named) for each in identities]

    def _shown(
        self, choices: Choices, asked: Sequence[list[str]], files: Files, state: str
    ) -> Shown:
        configured = ("configured", *(_state(each) for each in self.overlays))
        config = self._once(configured, lambda: self.commands.settings_of(self.overlays), 1)
        first = asked[0][0] if choices.files[0] != WHOLE else next(iter(self.files().values()), "")
        layout, proposal, trouble = self._seen(first, files, config)
        base, name = base_of(config, proposal, choices.base)
        chosen = {k: v for k, v in choices.settings.items() if v != base[k] or k == _TRAVEL}
        choices = choices._replace(base=name, settings=chosen)
        form, own = {**base, **chosen}, config["endurance"]["format"]
        overlay = overlay_text({k: v for k, v in form.items() if v != own[k]})
        channels, read = [str(chosen[_TRAVEL])] if _TRAVEL in chosen else [], None
        about = {"files": asked[0], "before": asked[1], "channel": channels}
        about["same_transducer"] = choices.same
        try:
            with self._overlay(overlay) as written:
                options = Namespace(**about, config=written, **_NONE)
                read = self.commands.read_of(options, files)
                trouble = ""
        except (ValueError, OSError) as error:
            trouble = re.sub(rf"{re.escape(str(self.own))}\S*/(?=my\.yaml)", "", str(error))
        return Shown(
            choices,
            overlay,
            rows_of(base, proposal if name == "seen" else None, layout, chosen, read),
            proposal.remarks if proposal else (),
            trouble,
            read,
            _traces(read, layout, files),
            self._command(*asked, channels, choices.same),
            state,
        )

    def answered(self, choices: Choices, state: str = "") -> tuple[Report, list[Mark]]:
        """Return the report of a visit, and the marks of its curves.

        Raises:
            ChangedError: If its files have changed since a page was shown.
            ValueError: If nothing of it can be used.
        """
        shown = self.shown(choices, state)
        if shown.read is None:
            raise ValueError(shown.trouble)

        def answer() -> tuple[Report, list[Mark]]:
            return report_of(shown.read), marks_of(shown.read.estimates)

        return self._once(("answered", id(shown), shown), answer, _KEPT)

    def _seen(
        self, file: str | Path, files: Files, config: Mapping
    ) -> tuple[Sheet | None, Proposal | None, str]:
        """The layout of a file, what is proposed for it, and why nothing is."""
        first, layout = files[file], None
        try:
            layout = look_into(first)
            find = lambda: inspect_file(file, config["sensor"], files=files)  # noqa: E731
            # Of a file, whatever is chosen: a command proposes it of the overlays alone.
            return layout, first.once(("proposed", str(config["sensor"])), find), ""
        except (ValueError, OSError) as error:
            return layout, None, str(error)

    @contextmanager
    def _overlay(self, text: str) -> Iterator[list[str]]:
        """Yield the overlays, with lines of YAML in a file behind them."""
        place = self.own / "settings"
        place.mkdir(exist_ok=True)
        with tempfile.TemporaryDirectory(dir=place) as folder:
            file = Path(folder, "my.yaml")
            file.write_text(text, encoding="utf-8")
            yield [*self.overlays, str(file)]

    def _command(
        self, files: Sequence[str], before: Sequence[str], channels: Sequence[str], same: bool
    ) -> str:
        """The command line that writes the sheet of a page."""
        words = ["breaker", "report", *map(printable, files)]
        words += ["--before", *map(printable, before)] if before else []
        words += ["--same-transducer"] if same else []
        words += ["--channel", *channels] if channels else []
        return shlex.join([*words, "--config", *self.overlays, "my.yaml", "--output", "sheet.html"])

    def sheet(self, choices: Choices, state: str, ending: str) -> bytes:
        """Return the sheet of a visit, as ``breaker report`` writes it.

        Raises:
            ValueError: If there is none, or it is to be a PDF and WeasyPrint is not installed.
        """
        report, _ = self.answered(choices, state)
        try:
            return self.commands.content_of(report, ending)[0]
        finally:
            gc.collect()  # the figures of a sheet hold themselves, 20 MB of them

    def save(self, choices: Choices, name: str) -> str:
        """Write the settings of a page where the user says.

        Raises:
            OSError, ValueError: If it cannot or must not be written there.
        """
        text = self.shown(choices).overlay
        return self.commands.write_lines(name, text, [self.named, *self.overlays])

    def _once(self, key: Hashable, find: Callable[[], Any], most: int) -> Any:
        """What was found before, or is now; of a kind as many as are told are kept. Whoever asks
        for what is being found waits for it, and nobody else does.
        """
        with self._lock:
            new = key not in self._kept
            found = self._kept.setdefault(key, Future())
            self._kept.move_to_end(key)
            same = [each for each in self._kept if each[0] == key[0]]
            for each in same[: max(0, len(same) - most)]:
                del self._kept[each]
        if new:
            try:
                found.set_result(find())
            except BaseException as error:
                with self._lock:
                    self._kept.pop(key, None)
                found.set_exception(error)
        return found.result()


def _traces(read: Diagnosis | None, first: Sheet | None, files: Files) -> list[Trace]:
    """Curves of all files that can be looked into; the others are said elsewhere. Over them lie the
    reference and the visit before.
    """
    records, layouts = read.records if read else (), []
    for each in dict.fromkeys(each.operation.file for each in records):
        with suppress(ValueError, OSError):
            layouts.append(look_into(files[each]))
    found = record_traces(records, layouts or [*filter(None, [first])])
    if read:
        found += laid_over(records, read.overlays, "reference", band=True)
        found += laid_over(records, overlaid(records, read.before), "before")
    return found


def _check_readable(folder: str) -> None:
    """Raises OSError with a remedy if a folder may not be read."""
    try:
        os.listdir(folder)
    except OSError as error:
        why = error.strerror or str(error)
        raise OSError(
            f"{printable(folder)} cannot be read ({why}): ask for the right to read it, or copy "
            "the exports into a folder of your own"
        ) from error


def _short(states: tuple) -> str:
    """States of files as a few signs, for as long as the command runs."""
    return f"{hash(states) & 0xFFFFFFFFFFFF:x}"


def _times(folder: str) -> tuple:
    """When the list of a folder's files was changed last; nothing where there is none."""
    try:
        found = os.stat(folder)
    except OSError:
        return ()
    return found.st_ino, found.st_mtime_ns, found.st_ctime_ns


def _state(path: str) -> tuple:
    """A file as it is now: one that changes is read again."""
    try:
        found = os.stat(path)
    except OSError:
        return (path,)
    if os.path.isdir(path):
        parts = sorted(each for each in record_files(path))
        table = Path(path, MANIFEST)
        inside = hash(tuple(_state(str(each)) for each in [*parts, table]))
        return path, inside, found.st_mtime_ns
    return path, found.st_ino, found.st_size, found.st_mtime_ns, found.st_ctime_ns
