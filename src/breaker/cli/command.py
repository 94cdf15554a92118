"""The command `breaker` as a whole: its commands, its errors and its exit status."""

import argparse
import gc
import importlib
import io
import logging
import os
import signal
import sys
from collections.abc import Sequence
from typing import TextIO

from breaker import DISTRIBUTION, __version__
from breaker.cli.inputs import PROJECT, SEVERAL, add_path
from breaker.common.compiling import set_threads
from breaker.common.text import UNPRINTED, say
from breaker.configuration.loading import ConfigurationError

_COMMANDS = ("inspect", "infer", "compare", "report", "fit-prior", "view", "example")
_EXTRAS = {"torch": "networks", "xarray": "stores", "zarr": "stores", "pandas": "stores"}


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command, and return its exit status: 0; 1 where it failed; 130 where it was
    interrupted; 141 where the reader of its output left.
    """
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        if stream is None:  # it is closed
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))  # noqa: SIM115
        elif isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # letters that it lacks
    set_threads(1)  # records are small, and inferred one by one: more threads wait for each other
    arguments = sys.argv[1:] if arguments is None else arguments
    status, fault = 1, ""
    try:
        options = parser(arguments[:1]).parse_args(arguments)
        if not sys.stderr.isatty():
            os.environ.setdefault("TQDM_DISABLE", "1")  # progress is for who waits on a terminal
        logging.getLogger("breaker").setLevel(logging.ERROR)  # answers state reasons of warnings
        status = options.run(options)
    except SystemExit as end:  # --help, --version, a wrong option, or a signal
        raise SystemExit(_flushed(end.code)) from None
    except KeyboardInterrupt:
        status, fault = 130, "interrupted"
    except BrokenPipeError:
        status = 141
    except ModuleNotFoundError as error:
        remedy = f'run `pip install "{DISTRIBUTION}[{_EXTRAS.get(error.name, "workflow")}]"`'
        fault = f"missing in the environment of {sys.executable}: {error.name}; {remedy}"
    except MemoryError:
        fault = f"out of memory; {options.smaller}"
    except (ConfigurationError, OSError, ValueError) as error:
        fault = str(error)
    if fault:
        say(f"breaker: {fault}", on_stderr=True)
    return _flushed(status)


def run() -> int:
    """Run the command as a process of its own, without garbage collection.

    To look for garbage takes a third of the time of a first answer. A kill, or a terminal that
    closes, ends the command as an interrupt does: no file stays half written.
    """
    gc.disable()
    for signal_name in ("SIGTERM", "SIGHUP"):  # Windows has the first alone
        number = getattr(signal, signal_name, None)
        if number and signal.getsignal(number) is signal.SIG_DFL:  # not under nohup
            signal.signal(number, _end)
    status = main()
    gc.freeze()
    return status


def _end(number: int, _: object) -> None:
    signal.signal(number, signal.SIG_IGN)  # a second signal must not stop the tidying
    raise SystemExit(128 + number)


def _flushed(status: int) -> int:
    """Return the status, or another where what was printed could not be written."""
    try:
        sys.stdout.flush()
        return status
    except OSError as error:
        # Python would write the rest when it ends, and complain: send the rest to nowhere.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        if isinstance(error, BrokenPipeError):
            return 141
        if status == 0:
            say(f"breaker: {UNPRINTED}: {error.strerror}", on_stderr=True)
        return 1


class _Parser(argparse.ArgumentParser):
    """A parser that escapes control characters of the arguments in its messages."""

    def _print_message(self, message: str, file: TextIO | None = None) -> None:
        say(message, on_stderr=file is not sys.stdout, end="")


def parser(named: Sequence[str] = ()) -> argparse.ArgumentParser:
    """Return the parser of the command that is named first, or of all where none is."""
    what = "From a breaker's travel curve to the state of its drive."
    made = _Parser(prog="breaker", description=what)
    made.add_argument("--version", action="version", version=f"breaker {__version__}")
    made.set_defaults(smaller="name fewer files, or lower endurance.draws")
    commands = made.add_subparsers(required=True, metavar="COMMAND")
    what = f"configuration files; their keys replace those of {PROJECT}, or the defaults"
    for name in [known for known in _COMMANDS if known in named] or _COMMANDS:
        module = importlib.import_module(f"breaker.cli.{name.replace('-', '_')}")
        about = module.__doc__.removesuffix(".").partition("`: ")[2]
        command = commands.add_parser(name, help=about, description=module.add.__doc__)
        command.set_defaults(run=module.run)
        module.add(command)
        add_path(command, "--config", "YAML", what, **SEVERAL)
    return made
