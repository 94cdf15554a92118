"""`breaker view`: show a folder of exports in the browser."""

import argparse
import gc
import importlib.util
import signal
import sys
import tempfile
import webbrowser
from contextlib import suppress
from pathlib import Path

from breaker.cli.common_options import limits_of, settings_of
from breaker.common.clean_text import print_text


def add(view: argparse.ArgumentParser) -> None:
    """Show a folder of exports in the browser of this machine, offline: the curves, how each file
    was read, measured values, and the test sheet. The command never changes a record. Ctrl-C ends
    it.
    """
    what = "a folder of exports, or one export (default: the current folder)"
    view.add_argument("folder", metavar="FOLDER", help=what, nargs="?")
    view.add_argument("--example", action="store_true", help="show exports of a simulated breaker")
    view.add_argument("--port", type=int, default=0, help="port of the page (default: a free one)")
    view.add_argument(
        "--no-browser", action="store_true", help="print the address and open no browser"
    )


def run(options: argparse.Namespace) -> int:
    """Serve the page until the user ends it."""
    if not importlib.util.find_spec("tornado"):
        raise ValueError('the page needs tornado: run `pip install ".[app]"` in a clone')
    if options.example and options.folder:
        raise ValueError("--example shows exports of its own; leave it out, or the folder")
    config = settings_of(options.config)  # raises errors before a page opens
    gc.enable()  # other commands end too soon to need it
    import asyncio

    from breaker.family.exports import write_inspections
    from breaker.page.server import PageServer
    from breaker.page.session import Session

    with tempfile.TemporaryDirectory(prefix="breaker-view-") as temporary:
        named = options.folder or "."
        if options.example:
            named = temporary
            write_inspections(config, Path(named))
        session = Session(named, config, limits_of(config, options.config))
        server = PageServer(session, options.port)

        def ready() -> None:
            print_text(f"the page is at {server.address}\nCtrl-C ends it")
            sys.stdout.flush()  # a pipe or a file gets the address now, not at the end
            if not options.no_browser:
                with suppress(OSError, webbrowser.Error):
                    webbrowser.open(server.address)

        signal.signal(signal.SIGTERM, signal.default_int_handler)  # tidy up as after Ctrl-C
        try:
            asyncio.run(server.serve(asyncio.Event(), ready))
        except KeyboardInterrupt:
            print_text("ended; what was being written is written")
    return 0
