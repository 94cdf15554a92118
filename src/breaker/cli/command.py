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

from breaker import __version__
from breaker.cli.command_inputs import PROJECT, SEVERAL, add_path
from breaker.common.visible_text import UNPRINTED, say
from breaker.configuration.yaml_sources import ConfigurationError
from breaker.workflow.jobs import missing_packages, set_threads

_COMMANDS = ("inspect", "infer", "compare", "report", "fit-prior", "view", "example")
_REMOVED = {  # commands, and options behind their command, with what to use in their place
    "plan": (
        "the command plan was removed without a replacement; compare what records determine with "
        "`breaker infer`"
    ),
    "manifest": "the command manifest was removed; use `breaker inspect FOLDER`",
    "check": "the command check was removed; use `breaker inspect FOLDER`",
    "infer --exact": (
        "the option --exact was removed; leave it out, and the networks of the family answer"
    ),
}


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command.

    Returns:
        The exit status: 0; 1 where it failed; 2 where it names what was removed; as of a command
        that a signal ended, 130 where it was interrupted and 141 where nobody reads its output to
        the end.
    """
    _prepare_streams()
    set_threads(1)  # records are small, and inferred one by one: more threads wait for each other
    arguments = sys.argv[1:] if arguments is None else arguments
    if instead := _removed(arguments):
        _complain(instead)
        return 2
    status = 1
    try:
        options = _parser(arguments[:1]).parse_args(arguments)
        _show_progress()
        logging.getLogger("breaker").setLevel(logging.ERROR)  # answers have the reasons of warnings
        status = options.run(options)
    except SystemExit as end:  # --help, --version, a wrong option, or a signal
        raise SystemExit(_flushed(end.code)) from None
    except KeyboardInterrupt:
        _complain("interrupted")
        status = 130
    except BrokenPipeError:
        status = 141
    except ModuleNotFoundError as error:
        _complain(missing_packages(error.name))
    except MemoryError:
        _complain(f"out of memory; {options.smaller}")
    except (ConfigurationError, OSError, ValueError) as error:
        _complain(str(error))
    return _flushed(status)


def _removed(arguments: Sequence[str]) -> str:
    """Return what to use in place of a removed command or option; "" where none is named."""
    command, *options = arguments or [""]
    named = [f"{command} {each}" for each in options] if command in _COMMANDS else [command]
    return next((_REMOVED[each] for each in named if each in _REMOVED), "")


def _complain(text: str) -> None:
    say(f"breaker: {text}", beside=True)


def _prepare_streams() -> None:
    """Make any text printable: signs that an output lacks are replaced, one that is closed takes
    everything and keeps nothing.
    """
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        if stream is None:
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))  # noqa: SIM115
        elif isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")


def _flushed(status: int) -> int:
    """The status, or another where what was printed could not be written."""
    try:
        sys.stdout.flush()
        return status
    except OSError as error:
        # Python writes what is left when it ends, and would complain: into nothing instead.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        if isinstance(error, BrokenPipeError):
            return 141
        if status == 0:
            _complain(f"{UNPRINTED}: {error.strerror}")
        return 1


def run() -> int:
    """Run the command as a process of its own, and collect no garbage.

    There is hardly any, and to look for it, among all that was imported, takes a third of the time
    of a first answer: half of that at the end.
    """
    gc.disable()
    _end_in_order()
    status = main()
    gc.freeze()
    return status


def _end_in_order() -> None:
    """Let a kill, or a terminal that closes, end the command as an interrupt does: of a file that
    is being written nothing stays.
    """

    def end(number: int, _: object) -> None:
        signal.signal(number, signal.SIG_IGN)  # once is enough: another is not to stop the tidying
        raise SystemExit(128 + number)

    for each in filter(None, (getattr(signal, name, None) for name in ("SIGTERM", "SIGHUP"))):
        if signal.getsignal(each) is signal.SIG_DFL:  # not under nohup
            signal.signal(each, end)  # Windows has the first alone


def _show_progress() -> None:
    """Show progress only to who waits for it, on a terminal. Before tqdm is loaded."""
    os.environ.setdefault("TQDM_DELAY", "2")  # s
    if not sys.stderr.isatty():
        os.environ.setdefault("TQDM_DISABLE", "1")


class _Once(argparse.Action):
    """Take the value of an option that can be given once: of two, one would be lost."""

    def __call__(self, parser, namespace, values, option_string=None) -> None:
        if option_string and getattr(namespace, self.dest, self.default) is not self.default:
            parser.error(f"{option_string} is given twice; leave one of them out")
        setattr(namespace, self.dest, values)


class _Parser(argparse.ArgumentParser):
    """A parser whose options are given once, and which shows on a terminal what it was given."""

    def __init__(self, **settings) -> None:
        super().__init__(**settings)
        self.register("action", None, _Once)

    def _print_message(self, message: str, file: TextIO | None = None) -> None:
        say(message, beside=file is not sys.stdout, end="")


def _parser(named: Sequence[str]) -> argparse.ArgumentParser:
    """The parser of the command that is named first, or of all where none is."""
    parser = _Parser(
        prog="breaker", description="From a breaker's travel curve to the state of its drive."
    )
    parser.add_argument("--version", action="version", version=f"breaker {__version__}")
    parser.set_defaults(smaller="name fewer files, or lower endurance.draws")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    what = f"configuration files, laid over {PROJECT} if there is one, or the defaults"
    for name in [each for each in _COMMANDS if each in named] or _COMMANDS:
        module = importlib.import_module(f"breaker.cli.{name.replace('-', '_')}")
        about = module.__doc__.removesuffix(".").partition("`: ")[2]
        command = commands.add_parser(name, help=about, description=module.add.__doc__)
        command.set_defaults(run=module._run)
        module.add(command)
        add_path(command, "--config", "YAML", what, **SEVERAL)
    return parser
