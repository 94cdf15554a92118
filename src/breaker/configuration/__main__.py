"""Check files, each over those before it, by line: ``python -m breaker.configuration FILE...``."""

import sys

from breaker.configuration.loading import ConfigurationError, load


def main(*files: str) -> int:
    """Check files; return the exit status."""
    if not files:
        print("usage: python -m breaker.configuration FILE...", file=sys.stderr)
        return 2
    try:
        load(files)
    except ConfigurationError as error:
        print(error, file=sys.stderr)
        return 1
    print(f"{', '.join(files)}: no problem")
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
