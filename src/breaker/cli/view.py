"""`breaker view`: show a folder of exports in the browser."""

import argparse
import gc
import importlib.util
import sys
import tempfile
import webbrowser
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from breaker import DISTRIBUTION
from breaker.cli.command_inputs import add_path, settings_of
from breaker.cli.inspect import table_of
from breaker.cli.outputs import check_outputs, write_lines
from breaker.cli.report import ReadVisit, content_of, read_of, visit_of
from breaker.common.visible_text import say

if TYPE_CHECKING:
    from breaker.app.view_session import Asked
    from breaker.reading.files.guards import Files

_NEEDED = ("bokeh", "tornado")


def add(view: argparse.ArgumentParser) -> None:
    """Show a folder of exports in the browser of this machine, offline: curves, how they were read,
    measured values, and the sheet of a visit; of a run's results a life and a fleet. Records are
    never changed. It ends with Ctrl-C.
    """
    what = "a folder of exports or of a run's results, or one export (default: the current folder)"
    add_path(view, "folder", "FOLDER", what, nargs="?")
    view.add_argument("--example", action="store_true", help="show exports of a simulated breaker")
    view.add_argument("--port", type=int, default=0, help="where it listens (default: a free port)")
    view.add_argument("--no-browser", action="store_true", help="only print the page's address")


def _run(options: argparse.Namespace) -> int:
    if lacking := [name for name in _NEEDED if importlib.util.find_spec(name) is None]:
        raise ValueError(f'the page needs {", ".join(lacking)}: pip install "{DISTRIBUTION}[app]"')
    if options.example and options.folder:
        raise ValueError("--example shows exports of its own; leave it out, or the folder")
    config = settings_of(options.config)  # what is wrong there is said before a page opens
    gc.enable()  # commands do without, as they end soon
    import asyncio

    from breaker.app.local_server import PageServer
    from breaker.app.view_session import Session

    with tempfile.TemporaryDirectory(prefix="breaker-view-") as own:
        named = _example(own, config) if options.example else options.folder or "."
        server = PageServer(Session(named, options.config, commands(), own), options.port)

        def ready() -> None:
            say(f"the page is at {server.address}\nCtrl-C ends it")
            if not (options.no_browser or _opened(server.address)):
                say("no browser could be started: open the address in one of this machine")
            sys.stdout.flush()  # a pipe or a file is told the address now, not at the end

        try:
            asyncio.run(server.serve(asyncio.Event(), ready))
        except KeyboardInterrupt:
            say("ended; what was being written is written")
    return 0


def _example(own: str, config: Mapping) -> str:
    """Those of ``breaker example --visits``, in a folder that goes when the command ends."""
    from breaker.drive.simulation.visit_exports import write_visits

    folder = Path(own, "example")
    folder.mkdir()
    write_visits(config, folder)
    return str(folder)


def _opened(address: str) -> bool:
    try:
        return webbrowser.open(address)
    except (OSError, webbrowser.Error):
        return False


def commands():
    """Return what the page asks of the other commands."""
    from breaker.app.view_session import Commands

    return Commands(settings_of, _read, visit_of, content_of, _table_of, _write)


def _read(asked: "Asked", overlays: Sequence[str], opened: "Files") -> ReadVisit:
    """What ``breaker report`` reads with these options."""
    given = {"files": [*asked.files], "before": [*asked.before], "config": [*overlays]}
    given |= {"channel": [asked.channel] if asked.channel else []}
    return read_of(argparse.Namespace(**given, reference=None, tolerance=None), opened)


def _table_of(folder: str, overlays: Sequence[str]) -> tuple[str, list[str]]:
    """What ``breaker inspect`` proposes for a folder."""
    return table_of(folder, settings_of(overlays))


def _write(name: str, text: str, read: Sequence[str]) -> str:
    """Write lines that a user may complete, where none of theirs are."""
    check_outputs([(name, "lines")], read)
    return write_lines(name, text)
