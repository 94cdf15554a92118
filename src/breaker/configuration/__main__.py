"""Check files, each over those before it, by line: ``python -m breaker.configuration FILE...``."""

import sys

from breaker.configuration.loading import ConfigurationError, load


def main(*files: str) -> None:
    """Check files; exit with their problems."""
    if not files:
        sys.exit("usage: python -m breaker.configuration FILE...")
    try:
        load(files)
    except ConfigurationError as error:
        sys.exit(str(error))
    print(f"{', '.join(files)}: no problem")


if __name__ == "__main__":
    main(*sys.argv[1:])
