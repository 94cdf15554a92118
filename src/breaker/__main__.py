"""`python -m breaker`: the command `breaker`, where its script is not on the path."""

import sys

from breaker.cli import run

if __name__ == "__main__":
    sys.exit(run())
