"""The command `breaker` as a whole: its commands, its errors and its exit status."""

import argparse
import gc
import os
import sys
from collections.abc import Sequence

from breaker import __version__
from breaker.cli import check, compare, fit_prior, infer, inspect, manifest
from breaker.cli.settings import PROJECT
from breaker.workflow import ConfigurationError, missing_packages, set_threads

__all__ = ["main", "run"]


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command.

    Returns:
        The exit status: 0; 1 where it failed; as of a command that a signal ended, 130 where it was
        interrupted and 141 where nobody reads its output to the end.
    """
    options = _parser().parse_args(arguments)
    _show_progress()
    set_threads(1)  # records are small, and inferred one by one: more threads wait for each other
    try:
        status = options.run(options)
        sys.stdout.flush()  # here, where a closed pipe is still caught
        return status
    except KeyboardInterrupt:
        print("breaker: interrupted", file=sys.stderr)
        return 130
    except BrokenPipeError:
        # Python writes what is left when it ends, and would complain: into nothing instead.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 141
    except ModuleNotFoundError as error:
        print(f"breaker: {missing_packages(error.name)}", file=sys.stderr)
        return 1
    except MemoryError:
        print("breaker: out of memory; name fewer files, or lower endurance.draws", file=sys.stderr)
        return 1
    except (ConfigurationError, OSError, ValueError) as error:
        print(f"breaker: {error}", file=sys.stderr)
        return 1


def run() -> int:
    """Run the command as a process of its own, and collect no garbage.

    There is hardly any, and to look for it, among all that was imported, takes a third of the time
    of a first answer: half of that at the end.
    """
    gc.disable()
    status = main()
    gc.freeze()
    return status


def _show_progress() -> None:
    """Show progress only to who waits for it, on a terminal. Before tqdm is loaded."""
    os.environ.setdefault("TQDM_DELAY", "2")  # s
    if not sys.stderr.isatty():
        os.environ.setdefault("TQDM_DISABLE", "1")


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="breaker", description="From a breaker's travel curve to the state of its drive."
    )
    parser.add_argument("--version", action="version", version=f"breaker {__version__}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    for each in (inspect, manifest, check, infer, compare, fit_prior):  # in the order of --help
        command = each.add(commands)
        command.add_argument(
            "--config",
            nargs="+",
            default=[],
            metavar="YAML",
            help=f"configuration files, laid over {PROJECT} if there is one, or the defaults",
        )
    return parser
