"""The command `breaker`: its commands, errors and exit status."""

import argparse
import gc
import importlib
import io
import logging
import os
import sys
from collections.abc import Sequence

from breaker import __version__
from breaker.common.clean_text import print_text
from breaker.common.compiling import set_threads

_COMMANDS = ("inspect", "infer", "compare", "report", "fit-prior", "view", "example")
_EXTRAS = {"torch": "networks", "xarray": "stores", "zarr": "stores", "pandas": "stores"}


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command, and return its exit status: 0; 1 if it failed; 130 if interrupted; 141 if
    the reader of its output closed the pipe.
    """
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # characters that the terminal lacks
    set_threads(1)  # records are small and inferred singly: more threads would only wait
    arguments = sys.argv[1:] if arguments is None else arguments
    options, unknown = parser(arguments[:1]).parse_known_args(arguments)
    if unknown:
        options.command.error(f"unknown arguments: {' '.join(unknown)}")
    if not sys.stderr.isatty():
        os.environ.setdefault("TQDM_DISABLE", "1")  # progress bars only on a terminal
    logging.getLogger("breaker").setLevel(logging.ERROR)  # results state reasons of warnings
    try:
        status = options.run(options)
        sys.stdout.flush()
        return status
    except KeyboardInterrupt:
        print_text("breaker: interrupted", on_stderr=True)
        return 130
    except BrokenPipeError:
        # Python flushes the output again at its end: redirect the rest to devnull.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 141
    except ModuleNotFoundError as error:
        remedy = f'run `pip install ".[{_EXTRAS.get(error.name, "workflow")}]"` in a clone'
        fault = f"missing in the environment of {sys.executable}: {error.name}; {remedy}"
    except MemoryError:
        fault = "out of memory; name fewer files or channels, or lower endurance.draws"
    except (OSError, ValueError) as error:
        fault = str(error)
    print_text(f"breaker: {fault}", on_stderr=True)
    return 1


def run() -> int:
    """Run the command as the main function of a process."""
    gc.disable()  # garbage collection takes a third of the time of a first command
    return main()


def parser(named: Sequence[str] = ()) -> argparse.ArgumentParser:
    """Return the parser of the commands in ``named``, or of all if it has none."""
    from breaker.cli.common_options import (
        SEVERAL,  # loads numpy, after the number of threads is set
    )

    what = "From a breaker's travel curve to the state of its drive."
    made = argparse.ArgumentParser(prog="breaker", description=what)
    made.add_argument("--version", action="version", version=f"breaker {__version__}")
    commands = made.add_subparsers(required=True, metavar="COMMAND")
    what = "configuration files; their keys replace the defaults"
    for name in [known for known in _COMMANDS if known in named] or _COMMANDS:
        module = importlib.import_module(f"breaker.cli.{name.replace('-', '_')}")
        about = module.__doc__.removesuffix(".").partition("`: ")[2]
        command = commands.add_parser(name, help=about, description=module.add.__doc__)
        command.set_defaults(run=module.run, command=command)
        module.add(command)
        command.add_argument("--config", metavar="YAML", help=what, **SEVERAL)
    return made
